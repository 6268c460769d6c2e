"""A folder of submissions nobody has vetted becomes grades, feedback and a journal."""

import atexit
import hashlib
import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, partial
from importlib.resources import files
from pathlib import Path

from autograder import judge
from autograder.checks import EXERCISES
from autograder.ingest import Notebook, Refused, parse, read, unzip
from autograder.journal import Journal
from autograder.judge import Graded
from autograder.report import feedback_link, feedback_page, index_page, write_grades
from autograder.sandbox import Sandbox
from autograder.spec import Exercise


@dataclass(frozen=True)
class Submission:
    """One notebook of one student; why it cannot be graded, if that is known from outside."""

    student: str
    exercise: str
    path: Path
    refused: str = ""


def identify(path: Path) -> tuple[Exercise, Notebook]:
    """Which exercise a file is, by its own word or by its name, and its cells.

    Raises
    ------
    Refused
        If it cannot be read, or belongs to another course.
    """
    notebook = parse(read(path))
    exercise = EXERCISES.get(notebook.exercise or "") or EXERCISES.get(path.stem)
    if exercise is None:
        raise Refused(f"{path.name} is no exercise of this course: there are {', '.join(EXERCISES)}")
    names = dict.fromkeys(task.function for task in exercise.tasks)
    if notebook.exercise != exercise.name and not any(name in cell for cell in notebook.cells for name in names):
        raise Refused(f"{path.name} holds none of {', '.join(names)}: is it a notebook of another course?")
    return exercise, notebook


def find(folder: Path) -> list[Submission]:
    """The submissions of a cohort: ``folder/<student>/<exercise>.ipynb``, sorted.

    A notebook under another name counts for the exercise that it says it is, unless that one is there by name.

    Raises
    ------
    Refused
        If the folder is missing, or holds no students.
    """
    if not folder.is_dir():
        raise Refused(f"{folder} is not a folder of submissions: it must hold <student>/<exercise>.ipynb")
    students = sorted(path for path in folder.iterdir() if path.is_dir() and not path.name.startswith("."))
    found = [submission for student in students for submission in _of_student(student)]
    if not found:
        raise Refused(f"{folder} holds no <student>/<exercise>.ipynb; the exercises are {', '.join(EXERCISES)}")
    return sorted(found, key=lambda s: (s.student, s.exercise))


def _of_student(student: Path) -> list[Submission]:
    if student.is_symlink():
        return [Submission(student.name, "", student, f"{student.name} is a link: hand in the folder itself")]
    notebooks = sorted(student.glob("*.ipynb"), key=lambda path: (path.stem not in EXERCISES, path.name))
    found: dict[str, Submission] = {}
    strays = []
    for path in notebooks:
        try:
            name = path.stem if path.stem in EXERCISES else identify(path)[0].name
        except Refused as why:
            strays.append(Submission(student.name, path.stem, path, str(why)))
            continue
        found.setdefault(name, Submission(student.name, name, path))
    if not notebooks:
        strays.append(Submission(student.name, "", student, f"{student.name} handed in no notebook"))
    return [*found.values(), *strays]


@contextmanager
def unpacked(path: Path):
    """The folder of submissions, unpacked first if it is a zip file."""
    if path.suffix.lower() != ".zip":
        yield path
        return
    with tempfile.TemporaryDirectory() as folder:
        unzip(path, Path(folder))
        yield Path(folder)


def grade_cohort(
    folder: Path,
    out: Path,
    level: str,
    salt: str | None = None,
    jobs: int = 1,
    scheduler: str | None = None,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> list[tuple[str, Graded]]:
    """Grade a folder of submissions into `out`; what the journal holds already is not graded again.

    Parameters
    ----------
    folder : Path
        ``<student>/<exercise>.ipynb``, or a zip file of it.
    out : Path
        Gets ``grades.csv``, ``feedback/<student>/<exercise>.html``, ``index.html`` and ``journal.sqlite``.
    level : str
        Isolation level, as `autograder.isolation.choose` gives it.
    salt : str, optional
        What the hidden inputs are drawn from; left out, it is drawn once and kept in the journal.
    jobs : int
        Submissions at a time, each in a process of its own.
    scheduler : str, optional
        Address of a Dask scheduler; its workers do the grading, as many at a time as they have threads.
    progress : callable, (done, of) -> None

    Returns
    -------
    list of (student, Graded)
        Sorted by student and exercise.

    Raises
    ------
    Refused
        If there is nothing to grade, or nobody answers at the address.
    """
    if out.resolve().is_relative_to(folder.resolve()):
        raise Refused(f"the output {out} lies inside the submissions {folder}: name a folder outside")
    with unpacked(folder) as submitted:
        submissions = find(submitted)
        out.mkdir(parents=True, exist_ok=True)
        with Journal(out / "journal.sqlite") as journal:
            salt = salt or journal.salt()
            digests = {s: _digest(s, salt, level) for s in submissions}
            results = {s: journal.get(s.student, s.exercise, digests[s]) for s in submissions}
            waiting = [s for s, graded in results.items() if graded is None]
            progress(len(submissions) - len(waiting), len(submissions))
            if waiting:
                with _graders(level, jobs, scheduler) as submit:
                    running = {submit(*_read(s), salt, s.student, level): s for s in waiting}
                    for finished in as_completed(running):
                        s = running[finished]
                        results[s] = finished.result()
                        journal.put(s.student, s.exercise, digests[s], results[s])
                        progress(sum(g is not None for g in results.values()), len(submissions))
    graded = [(s.student, results[s]) for s in submissions]
    publish(graded, out, level)
    return graded


def _read(submission: Submission) -> tuple[str, tuple[str, ...], str]:
    """Exercise, cells, and why they cannot be graded: all that leaves the folder."""
    if submission.refused:
        return submission.exercise, (), submission.refused
    try:
        exercise, notebook = identify(submission.path)
    except Refused as refusal:
        return submission.exercise, (), str(refusal)
    if exercise.name != submission.exercise:
        return submission.exercise, (), f"{submission.path.name} says that it is {exercise.name}"
    return exercise.name, notebook.cells, ""


@contextmanager
def _graders(level: str, jobs: int, scheduler: str | None):
    """Something to hand submissions to: threads that share one sandbox, or the workers of a cluster."""
    if scheduler is None:
        # the judging is light, and what a student wrote runs in processes of its own
        with Sandbox(level) as sandbox, ThreadPoolExecutor(jobs) as threads:
            yield partial(threads.submit, _grade, lambda _: sandbox)
        return
    from distributed import Client

    try:
        client = Client(scheduler, timeout="10s")
    except (OSError, ValueError) as error:
        raise Refused(f"no Dask scheduler answers at {scheduler}: {str(error).splitlines()[0]}") from None
    with client, client.get_executor(pure=False) as cluster:
        yield partial(cluster.submit, _grade, _own_sandbox)


def _grade(
    sandbox_at: Callable[[str], Sandbox],
    name: str,
    cells: tuple[str, ...],
    refused: str,
    salt: str,
    student: str,
    level: str,
) -> Graded:
    if refused:
        return judge.ungraded(name, EXERCISES.get(name), refused, level)
    return judge.grade(EXERCISES[name], cells, sandbox_at(level), salt, student)


@cache
def _own_sandbox(level: str) -> Sandbox:
    """The sandbox of a process that grades for others, for as long as it lives."""
    sandbox = Sandbox(level)
    atexit.register(sandbox.close)
    return sandbox


def publish(graded: list[tuple[str, Graded]], out: Path, level: str) -> None:
    """Write the table and the pages."""
    write_grades(out / "grades.csv", graded)
    for student, g in graded:
        page = out / "feedback" / student / f"{g.exercise or 'nothing'}.html"
        page.parent.mkdir(parents=True, exist_ok=True)
        page.write_text(
            feedback_page(student, EXERCISES[g.exercise].title if g.exercise in EXERCISES else g.exercise, g),
            encoding="utf-8",
        )
    rows = [(student, g, feedback_link(student, g.exercise or "nothing")) for student, g in graded]
    (out / "index.html").write_text(index_page(rows, f"Isolation: {level}."), encoding="utf-8")


def _digest(submission: Submission, salt: str, level: str) -> str:
    try:
        content = read(submission.path)
    except Refused as why:
        content = str(why).encode()
    return hashlib.sha256(b"\0".join((content, salt.encode(), level.encode(), _grader()))).hexdigest()


@cache
def _grader() -> bytes:
    """The grader as it stands: a changed check, reference or template makes old results stale."""
    here = [
        p
        for package in ("autograder", "mechlib")
        for p in Path(str(files(package))).rglob("*")
        if p.suffix in (".py", ".html")
    ]
    return hashlib.sha256(b"".join(p.read_bytes() for p in sorted(here))).digest()
