"""A folder of submissions nobody has vetted becomes grades, feedback and a journal."""

import atexit
import hashlib
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from functools import cache, partial
from importlib.resources import files
from pathlib import Path

from autograder import judge
from autograder.checks import EXERCISES
from autograder.ingest import Refused, read
from autograder.journal import Journal
from autograder.judge import Graded
from autograder.report import feedback_link, feedback_page, index_page, write_grades
from autograder.sandbox import Sandbox
from autograder.submissions import Submission, contents, find, unpacked


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
                    running = {submit(*contents(s), salt, s.student, level): s for s in waiting}
                    for finished in as_completed(running):
                        s = running[finished]
                        results[s] = finished.result()
                        journal.put(s.student, s.exercise, digests[s], results[s])
                        progress(sum(g is not None for g in results.values()), len(submissions))
    graded = [(s.student, results[s]) for s in submissions]
    publish(graded, out, level)
    return graded


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
