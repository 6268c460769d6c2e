"""A folder of submissions nobody has vetted becomes grades, feedback and a journal."""

import atexit
import hashlib
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from functools import cache, partial
from importlib.resources import files
from itertools import islice
from pathlib import Path

from autograder import isolation, judge
from autograder.checks import EXERCISES
from autograder.ingest import Refused, read
from autograder.journal import Journal
from autograder.judge import Assessment, Graded
from autograder.publish import publish_page, publish_tables
from autograder.sandbox import Sandbox
from autograder.submissions import Contents, Submission, contents, find, unpacked

Keep = Callable[[Assessment], None]


def grade_cohort(
    folder: Path,
    out: Path,
    level: str,
    salt: str | None = None,
    jobs: int = 1,
    scheduler: str | None = None,
    progress: Callable[[int, int], None] = lambda done, of: None,
    book: str = "",
) -> list[tuple[str, Graded]]:
    """Grade a folder of submissions into `out`; what the journal holds already is not graded again.

    Every task is in the journal before the next of its submission begins; on a cluster every submission is, when it
    comes back. Whatever ends a run, the next one goes on from there.

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
    book : str
        Address of the built book, for links from the feedback to its sections.

    Returns
    -------
    list of (student, Graded)
        Sorted by student and exercise, without what the notebooks printed.

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
            keys = {s: (s.student, s.exercise, _digest(s, salt, level)) for s in submissions}
            whole = journal.graded()
            waiting = [s for s in submissions if keys[s] not in whole]
            said = isolation.statement(level)
            results = {}
            for s in submissions:
                if keys[s] in whole:
                    results[s] = publish_page(s.student, journal.get(*keys[s]), out, said, book)
            progress(len(results), len(submissions))
            if waiting:
                with _graders(level, jobs, scheduler) as (submit, at_once):

                    def start(s: Submission) -> Future:
                        keep = partial(journal.keep, *keys[s])
                        return submit(contents(s), salt, s.student, level, journal.judged(*keys[s]), keep=keep)

                    for s, graded in _as_they_come(start, waiting, at_once):
                        journal.put(*keys[s], graded)
                        results[s] = publish_page(s.student, graded, out, said, book)
                        progress(len(results), len(submissions))
            found = [(s.student, results[s]) for s in submissions]
            publish_tables(found, out, said, former={(student, exercise) for student, exercise, _ in whole})
            return found


def _as_they_come(
    start: Callable[[Submission], Future], submissions: Iterable[Submission], at_once: int
) -> Iterator[tuple[Submission, Graded]]:
    """Hand out so many at once, and give each result as it comes: a long cohort never lies in memory as a whole."""
    waiting = iter(submissions)
    running = {start(s): s for s in islice(waiting, at_once)}
    while running:
        for finished in wait(running, return_when=FIRST_COMPLETED).done:
            yield running.pop(finished), finished.result()
            running |= {start(s): s for s in islice(waiting, 1)}


@contextmanager
def _graders(level: str, jobs: int, scheduler: str | None) -> Iterator[tuple[Callable[..., Future], int]]:
    """Something to hand submissions to, and how many it should have in hand."""
    if scheduler is None:
        with _threads(level, jobs) as submit:
            yield submit, 2 * jobs
        return
    from distributed import Client

    try:
        client = Client(scheduler, timeout="10s")
    except (OSError, ValueError) as error:
        raise Refused(f"no Dask scheduler answers at {scheduler}: {str(error).splitlines()[0]}") from None
    with client, client.get_executor(pure=False) as cluster:
        # the journal stays here: what a computer of the cluster has judged is kept when it comes back
        yield lambda *question, keep: cluster.submit(_grade, _own_sandbox, *question), 4 * sum(client.ncores().values())


@contextmanager
def _threads(level: str, jobs: int) -> Iterator[Callable[..., Future]]:
    """Threads that share one sandbox: judging is light, and what a student wrote runs in processes of its own."""
    stopped = threading.Event()
    with Sandbox(level) as sandbox:
        threads = ThreadPoolExecutor(jobs)

        def submit(*question, keep: Keep) -> Future:
            def keep_unless_stopped(assessment: Assessment) -> None:
                if stopped.is_set():  # it may be the end of its worker that was judged
                    raise InterruptedError("the run was stopped")
                keep(assessment)

            return threads.submit(_grade, lambda _: sandbox, *question, keep_unless_stopped)

        try:
            yield submit
        except BaseException:
            stopped.set()
            sandbox.close()
            raise
        finally:
            threads.shutdown(cancel_futures=True)


def _grade(
    sandbox_at: Callable[[str], Sandbox],
    handed_in: Contents,
    salt: str,
    student: str,
    level: str,
    known: dict[str, Assessment],
    keep: Keep = lambda assessment: None,
) -> Graded:
    name, notes = handed_in.exercise, handed_in.notes
    if handed_in.refused:
        return judge.ungraded(name, EXERCISES.get(name), handed_in.refused, level, notes)
    sandbox = sandbox_at(level)
    return judge.grade(EXERCISES[name], handed_in.cells, sandbox, salt, student, notes=notes, known=known, keep=keep)


@cache
def _own_sandbox(level: str) -> Sandbox:
    """The sandbox of a process that grades for others, for as long as it lives."""
    sandbox = Sandbox(level)
    atexit.register(sandbox.close)
    return sandbox


def _digest(submission: Submission, salt: str, level: str) -> str:
    try:
        content = read(submission.path)
    except Refused as why:
        content = str(why).encode()
    notes = "\n".join(submission.notes).encode()  # they tell of its neighbours
    return hashlib.sha256(b"\0".join((content, notes, salt.encode(), level.encode(), _grader()))).hexdigest()


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
