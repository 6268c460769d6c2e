"""The files that people read, made from the journal; each is replaced whole, so that nobody ever reads half of one."""

import os
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from autograder import report
from autograder.checks import EXERCISES
from autograder.judge import Graded

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
    with tempfile.NamedTemporaryFile("w", encoding="utf-8", newline="", dir=path.parent, delete=False) as file:
        file.write(text)
    os.chmod(file.name, 0o644)
    os.replace(file.name, path)
