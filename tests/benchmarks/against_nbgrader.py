"""The same assignment and submissions, graded by nbgrader and by us: speed, memory, and what isolation costs.

python tests/benchmarks/against_nbgrader.py [--submissions N] [--tries N] [--ours-only] [--keep]

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
from importlib.metadata import version
from pathlib import Path

import alone
import assignment
from assignment import ANSWERS, NAME, Answer
from measuring import Cost, computer, cost
from rich.console import Console
from rich.table import Table

from autograder.sandbox import ENVIRONMENT

HERE = Path(__file__).resolve().parent
NBGRADER = "0.9.6"
THEIRS = HERE.parents[1] / "_build" / "benchmarks" / f"nbgrader-{NBGRADER}"
KEPT = HERE / "measured" / f"{Path(__file__).stem}.json"
JOBS, SALT = 4, "benchmark"  # two a core: while one is judged, another computes
COPIES = 3  # of the submissions, where the time of one is looked for: the start is much longer
TRIES = 3  # of which the quickest counts: other work on the computer only ever adds

FASTER, OVERHEAD, MEMORY, MEMORY_A_WORKER = 30.0, 50.0, 250.0, 100.0  # times; ms; MB

Submissions = dict[str, Answer]


def submissions(number: int) -> Submissions:
    return {f"student{n:03d}": ANSWERS[n % len(ANSWERS)] for n in range(number)}


# --- ours -------------------------------------------------------------------------------------------------------------


def ours(handed_in: Submissions, jobs: int, scratch: Path) -> tuple[Cost, dict[str, float]]:
    """`autograder grade`, at `namespaces`: what it took, and the marks."""
    scratch = Path(tempfile.mkdtemp(dir=scratch))
    folder, out, salt = (scratch / name for name in ("submitted", "graded", "salt"))
    salt.write_text(SALT, "utf-8")
    for student, answer in handed_in.items():
        (folder / student).mkdir(parents=True)
        (folder / student / f"{NAME}.ipynb").write_text(assignment.ours(answer), "utf-8")
    options = ["--out", out, "--salt", salt, "--isolation", "namespaces", "-j", jobs]
    run = cost([sys.executable, *map(str, [assignment.__file__, "grade", folder, *options])])
    return run, marks(out / "grades.csv", "student", "points", "max")


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


def theirs(handed_in: Submissions, scratch: Path) -> tuple[Cost, dict[str, float]]:
    """`nbgrader autograde`, which has no option to grade in parallel: what it took, and the marks."""
    command = install()
    course = Path(tempfile.mkdtemp(dir=scratch))
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("JUPYTER", "PYTHON"))}
    environment |= {"HOME": str(scratch), "PATH": f"{command.parent}:{os.environ['PATH']}"}
    source = course / "source" / NAME / f"{NAME}.ipynb"
    source.parent.mkdir(parents=True)
    source.write_text(assignment.theirs_source(), "utf-8")
    (course / "nbgrader_config.py").write_text(f"c = get_config()\nc.CourseDirectory.course_id = {NAME!r}\n", "utf-8")
    cost([str(command), "generate_assignment", NAME], course, environment)
    released = (course / "release" / NAME / source.name).read_text("utf-8")
    for student, answer in handed_in.items():
        path = course / "submitted" / student / NAME / source.name
        path.parent.mkdir(parents=True)
        path.write_text(assignment.theirs(answer, released), "utf-8")
    run = cost([str(command), "autograde", NAME], course, environment)
    cost([str(command), "export"], course, environment)
    return run, marks(course / "grades.csv", "student_id", "score", "max_score")


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


def steady(first: Cost, run: Cost, number: int) -> float:
    """Submissions a second, once the first is graded."""
    return (number - 1) / (run.seconds - first.seconds)


def figures(first: Cost, run: Cost, number: int) -> dict[str, float]:
    return {
        "one submission alone, s": first.seconds,
        "all, s": run.seconds,
        "submissions a second, from the start": number / run.seconds,
        "submissions a second, once started": steady(first, run, number),
        "memory, MB": run.peak,
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--submissions", type=int, default=40)
    parser.add_argument("--tries", type=int, default=TRIES, help="of our overhead, of which the quickest counts")
    parser.add_argument("--ours-only", action="store_true", help="without nbgrader, which is not installed then")
    parser.add_argument("--keep", action="store_true", help=f"write {KEPT.relative_to(HERE.parents[1])}")
    asked = parser.parse_args()
    number = asked.submissions
    one, handed_in, more = submissions(1), submissions(number), submissions(COPIES * number)
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder)
        first, _ = ours(one, JOBS, scratch)
        run, got = ours(handed_in, JOBS, scratch)
        void = misjudged(handed_in, "autograder", got)
        tries = [(ours(one, 1, scratch)[0], ours(more, 1, scratch)[0], own_work(handed_in)) for _ in range(asked.tries)]
        in_turn = min(1e3 / steady(alone, all_in_turn, len(more)) for alone, all_in_turn, _ in tries)
        work = min(1e3 * seconds for _, _, seconds in tries)
        found = {
            "date": datetime.date.today().isoformat(),
            "computer": computer(),
            "versions": {"nbgrader": NBGRADER} | {name: version(name) for name in ("ipython", "matplotlib", "numpy")},
            "submissions": number,
            "workers": JOBS,
            "ours": figures(first, run, number)
            | {
                "one after the other, ms a submission": in_turn,
                "of which the student's own work, ms": work,
                "overhead, ms": in_turn - work,
            },
        }
        if not asked.ours_only:
            first, _ = theirs(one, scratch)
            run, got = theirs(handed_in, scratch)
            void += misjudged(handed_in, "nbgrader", got)
            found["nbgrader"] = figures(first, run, number)
            found["ratios"] = {name: found["ours"][name] / value for name, value in found["nbgrader"].items()}

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
