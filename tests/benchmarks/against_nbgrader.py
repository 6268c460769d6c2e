"""The same assignment and submissions, graded by nbgrader and by us: speed, memory, and what isolation costs.

python tests/benchmarks/against_nbgrader.py [--submissions N] [--ours-only] [--keep]

nbgrader is installed into an environment of its own, on demand. Exit code: 0 every bound is reached, 1 one is missed,
2 the marks are not those that were due, and the comparison is void.
"""

import argparse
import csv
import datetime
import json
import os
import subprocess
import sys
import tempfile
from collections import defaultdict
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import alone
import assignment
from assignment import ANSWERS, NAME, Answer
from measuring import computer, cost
from rich.console import Console
from rich.table import Table

from autograder.sandbox import ENVIRONMENT

HERE = Path(__file__).resolve().parent
NBGRADER = "0.9.6"
THEIRS = HERE.parents[1] / "_build" / "benchmarks" / f"nbgrader-{NBGRADER}"
KEPT = HERE / "measured" / f"{Path(__file__).stem}.json"
JOBS, SALT = 2, "benchmark"
COPIES = 3  # of the submissions, where the time of one is looked for: the start is much longer

FASTER, OVERHEAD, MEMORY, MEMORY_A_WORKER = 30.0, 50.0, 250.0, 100.0  # times; ms; MB

Submissions = dict[str, Answer]


@dataclass(frozen=True)
class Graded:
    """What a grader took, and the share of the points that it gave each student."""

    alone: float
    seconds: float
    peak: float
    marks: dict[str, float]

    @property
    def rate(self) -> float:
        """Submissions a second, from the command to its end."""
        return len(self.marks) / self.seconds

    @property
    def steady(self) -> float:
        """Submissions a second, once the first is graded."""
        return (len(self.marks) - 1) / (self.seconds - self.alone)


def submissions(number: int) -> Submissions:
    return {f"student{n:03d}": ANSWERS[n % len(ANSWERS)] for n in range(number)}


# --- ours -------------------------------------------------------------------------------------------------------------


def ours(handed_in: Submissions, jobs: int, scratch: Path) -> Graded:
    """`autograder grade`, at `namespaces`."""
    salt = scratch / "salt"
    salt.write_text(SALT, "utf-8")

    def grade(some: Submissions, name: str):
        folder, out = scratch / name, scratch / f"{name}-graded"
        for student, answer in some.items():
            (folder / student).mkdir(parents=True)
            (folder / student / f"{NAME}.ipynb").write_text(assignment.ours(answer), "utf-8")
        options = ["--out", out, "--salt", salt, "--isolation", "namespaces", "-j", jobs]
        return cost([sys.executable, *map(str, [assignment.__file__, "grade", folder, *options])]), out / "grades.csv"

    first, _ = grade(dict([*handed_in.items()][:1]), f"one-{jobs}")
    run, grades = grade(handed_in, f"all-{jobs}")
    return Graded(first.seconds, run.seconds, run.peak, marks(grades, "student", "points", "max"))


def marks(grades: Path, student: str, points: str, most: str) -> dict[str, float]:
    """The share of all points that each student got."""
    got, could = defaultdict(float), defaultdict(float)
    with open(grades, encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            got[row[student]] += float(row[points] or 0)
            could[row[student]] += float(row[most])
    return {name: got[name] / could[name] for name in got}


def own_work(handed_in: Submissions) -> float:
    """Seconds that a submission takes where nothing is kept from it."""
    command = [sys.executable, alone.__file__, SALT, *(f"{student}={a.name}" for student, a in handed_in.items())]
    ran = subprocess.run(command, env=os.environ | ENVIRONMENT, stdout=subprocess.PIPE, text=True, check=True)
    return float(ran.stdout.splitlines()[-1])


# --- theirs -----------------------------------------------------------------------------------------------------------


def install() -> Path:
    """The command nbgrader, in an environment of its own."""
    python, command = THEIRS / "bin" / "python", THEIRS / "bin" / "nbgrader"
    if not command.exists():
        uv = [sys.executable, "-m", "uv"]
        subprocess.run([*uv, "venv", "--quiet", "--python", sys.executable, THEIRS], check=True)
        packages = [f"nbgrader=={NBGRADER}", *(f"{name}=={version(name)}" for name in ("numpy", "matplotlib"))]
        subprocess.run([*uv, "pip", "install", "--quiet", "--python", python, *packages, "ipykernel"], check=True)
    return command


def theirs(handed_in: Submissions, scratch: Path) -> Graded:
    """`nbgrader autograde`, which has no option to grade in parallel."""
    command = install()
    home = scratch / "home"
    home.mkdir()
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("JUPYTER", "PYTHON"))}
    environment |= {"HOME": str(home), "PATH": f"{command.parent}:{os.environ['PATH']}"}

    def grade(some: Submissions, name: str):
        course = scratch / name
        source = course / "source" / NAME / f"{NAME}.ipynb"
        source.parent.mkdir(parents=True)
        source.write_text(assignment.theirs_source(), "utf-8")
        (course / "nbgrader_config.py").write_text(f"c = get_config()\nc.CourseDirectory.course_id = {NAME!r}\n")
        cost([str(command), "generate_assignment", NAME], course, environment)
        released = (course / "release" / NAME / source.name).read_text("utf-8")
        for student, answer in some.items():
            path = course / "submitted" / student / NAME / source.name
            path.parent.mkdir(parents=True)
            path.write_text(assignment.theirs(answer, released), "utf-8")
        run = cost([str(command), "autograde", NAME], course, environment)
        cost([str(command), "export"], course, environment)
        return run, course / "grades.csv"

    first, _ = grade(dict([*handed_in.items()][:1]), "one")
    run, grades = grade(handed_in, "all")
    return Graded(first.seconds, run.seconds, run.peak, marks(grades, "student_id", "score", "max_score"))


# --- the comparison ---------------------------------------------------------------------------------------------------


def misjudged(handed_in: Submissions, who: str, marks: dict[str, float]) -> list[str]:
    """Why a comparison would be void: a right answer without full points, a mistake with them, or points for none."""
    due = {
        student: "all" if answer.right else "none" if answer.edits is None else "some"
        for student, answer in handed_in.items()
    }
    got = {student: {0.0: "none", 1.0: "all"}.get(marks.get(student), "some") for student in handed_in}
    return [
        f"{who} gave {student} ({handed_in[student].name}) {got[student]} of the points, and {due[student]} were due"
        for student in handed_in
        if got[student] != due[student]
    ]


def missed(found: dict) -> list[str]:
    """The bounds that were not reached, and by how much."""
    most = MEMORY + JOBS * MEMORY_A_WORKER
    bounds = [
        ("overhead, ms", found["ours"]["overhead, ms"], OVERHEAD, False),
        ("memory, MB", found["ours"]["memory, MB"], most, False),
    ]
    if "ratios" in found:
        bounds.append(
            ("submissions a second, times theirs", found["ratios"]["submissions a second, once started"], FASTER, True)
        )
    return [
        f"{name}: {value:.1f}, where {bound:g} was to be reached ({abs(value / bound - 1):.0%} off)"
        for name, value, bound, at_least in bounds
        if (value < bound if at_least else value > bound)
    ]


def figures(graded: Graded) -> dict[str, float]:
    return {
        "one submission alone, s": graded.alone,
        "all, s": graded.seconds,
        "submissions a second": graded.rate,
        "submissions a second, once started": graded.steady,
        "memory, MB": graded.peak,
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--submissions", type=int, default=40)
    parser.add_argument("--ours-only", action="store_true", help="without nbgrader, which is not installed then")
    parser.add_argument("--keep", action="store_true", help=f"write {KEPT.relative_to(HERE.parents[1])}")
    asked = parser.parse_args()
    handed_in = submissions(asked.submissions)
    void = []
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder)
        side_by_side, in_turn = (
            ours(handed_in, JOBS, scratch),
            ours(submissions(COPIES * asked.submissions), 1, scratch),
        )
        void += misjudged(handed_in, "autograder", side_by_side.marks)
        found = {
            "date": datetime.date.today().isoformat(),
            "computer": computer(),
            "versions": {"nbgrader": NBGRADER} | {name: version(name) for name in ("ipython", "matplotlib", "numpy")},
            "submissions": asked.submissions,
            "workers": JOBS,
            "ours": figures(side_by_side),
        }
        work = own_work(handed_in)
        found["ours"] |= {
            "one after the other, ms a submission": 1e3 / in_turn.steady,
            "of which the student's own work, ms": 1e3 * work,
            "overhead, ms": 1e3 * (1 / in_turn.steady - work),
        }
        if not asked.ours_only:
            nbgrader = theirs(handed_in, scratch)
            void += misjudged(handed_in, "nbgrader", nbgrader.marks)
            found["nbgrader"] = figures(nbgrader)
            found["ratios"] = {name: found["ours"][name] / value for name, value in found["nbgrader"].items() if value}

    console = Console(soft_wrap=True, highlight=False)
    columns = [name for name in ("ours", "nbgrader", "ratios") if name in found]
    table = Table("", *columns, title=f"{asked.submissions} submissions, {JOBS} workers at namespaces")
    for name in found["ours"]:
        table.add_row(name, *(f"{found[c][name]:.3g}" if name in found[c] else "" for c in columns))
    console.print(table)
    console.print(*(f"{name}: {value}" for name, value in found["computer"].items()), sep=", ")
    for sentence in void:
        console.print(f"void: {sentence}", markup=False)
    lacking = missed(found)
    for sentence in lacking:
        console.print(f"missed: {sentence}", markup=False)
    if asked.keep and not void:
        KEPT.parent.mkdir(exist_ok=True)
        KEPT.write_text(json.dumps(found, indent=2) + "\n", "utf-8")
    return 2 if void else 1 if lacking else 0


if __name__ == "__main__":
    sys.exit(main())
