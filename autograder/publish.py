"""The files that people read, made from the journal; each is replaced whole, so that nobody ever reads half of one."""

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import psutil

from autograder import report
from autograder.checks import EXERCISES
from autograder.judge import Graded

PART = ".part-"  # begins the name of a file that is being written; the number of the process follows
NO_EXERCISE = "nothing"  # name of the page of a student who handed in no notebook


def publish_page(student: str, graded: Graded, out: Path, isolation: str, book: str = "") -> Graded:
    """Write what one student gets back for one notebook.

    Parameters
    ----------
    isolation : str
        What is said of the isolation level.
    book : str
        Address of the built book.

    Returns
    -------
    Graded
        Without what the notebook printed, which for a whole cohort need not fit into memory.
    """
    page = page_of(out, student, graded.exercise)
    page.parent.mkdir(parents=True, exist_ok=True)
    title = EXERCISES[graded.exercise].title if graded.exercise in EXERCISES else graded.exercise
    printed = page.with_suffix(".txt")
    if graded.output:
        write(printed, graded.output)
    else:
        printed.unlink(missing_ok=True)
    write(page, report.feedback_page(student, title, graded, printed.name, isolation, book))
    return replace(graded, output="")


def publish_tables(
    results: Sequence[tuple[str, Graded]], out: Path, isolation: str, former: set[tuple[str, str]]
) -> None:
    """Write the table of all and ``grades.csv``, and take away the pages of submissions that are no more.

    Parameters
    ----------
    results : sequence of (student, Graded)
    isolation : str
        What is said of the isolation level.
    former : set of (student, exercise)
        Whose pages an earlier run may have left.
    """
    sweep(out)
    for student, exercise in former - {(student, graded.exercise) for student, graded in results}:
        page = page_of(out, student, exercise)
        page.unlink(missing_ok=True)
        page.with_suffix(".txt").unlink(missing_ok=True)
    rows = [(student, g, report.feedback_link(student, g.exercise or NO_EXERCISE)) for student, g in results]
    write(out / "index.html", report.index_page(rows, isolation))
    write(out / "grades.csv", report.grades(results))


def page_of(out: Path, student: str, exercise: str) -> Path:
    return out / "feedback" / student / f"{exercise or NO_EXERCISE}.html"


def write(path: Path, text: str) -> None:
    """Put a file in the place of another, at once."""
    part = path.with_name(f"{PART}{os.getpid()}-{path.name}")
    part.write_text(text, "utf-8", newline="")
    os.chmod(part, 0o644)
    os.replace(part, path)


def sweep(out: Path) -> None:
    """Take away what a run left half written that is no more."""
    for part in out.rglob(f"{PART}*"):
        process = part.name.removeprefix(PART).partition("-")[0]
        if process.isdigit() and not psutil.pid_exists(int(process)):
            part.unlink(missing_ok=True)
