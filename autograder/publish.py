"""The files that people read, made from the journal; each is replaced whole, so that nobody ever reads half of one."""

import os
import tempfile
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from autograder import report
from autograder.checks import EXERCISES
from autograder.judge import Graded

NO_EXERCISE = "nothing"  # name of the page of a student who handed in no notebook


def publish(
    results: Iterable[tuple[str, Graded]], out: Path, isolation: str, former: set[tuple[str, str]], book: str = ""
) -> list[tuple[str, Graded]]:
    """Write the pages, the table of all, and ``grades.csv``; take away the pages of submissions that are no more.

    Parameters
    ----------
    results : iterable of (student, Graded)
        One at a time, so that what all notebooks printed need not fit into memory.
    isolation : str
        What is said of the isolation level.
    former : set of (student, exercise)
        Whose pages an earlier run may have left.
    book : str
        Address of the built book.

    Returns
    -------
    list of (student, Graded)
        Without what the notebooks printed.
    """
    brief = []
    for student, graded in results:
        page = page_of(out, student, graded.exercise)
        page.parent.mkdir(parents=True, exist_ok=True)
        title = EXERCISES[graded.exercise].title if graded.exercise in EXERCISES else graded.exercise
        printed = page.with_suffix(".txt")
        if graded.output:
            write(printed, graded.output)
        else:
            printed.unlink(missing_ok=True)
        write(page, report.feedback_page(student, title, graded, printed.name, isolation, book))
        brief.append((student, replace(graded, output="")))
    for student, exercise in former - {(student, graded.exercise) for student, graded in brief}:
        page = page_of(out, student, exercise)
        page.unlink(missing_ok=True)
        page.with_suffix(".txt").unlink(missing_ok=True)
    rows = [(student, g, report.feedback_link(student, g.exercise or NO_EXERCISE)) for student, g in brief]
    write(out / "index.html", report.index_page(rows, isolation))
    write(out / "grades.csv", report.grades(brief))
    return brief


def page_of(out: Path, student: str, exercise: str) -> Path:
    return out / "feedback" / student / f"{exercise or NO_EXERCISE}.html"


def write(path: Path, text: str) -> None:
    """Put a file in the place of another, at once."""
    with tempfile.NamedTemporaryFile("w", encoding="utf-8", newline="", dir=path.parent, delete=False) as file:
        file.write(text)
    os.chmod(file.name, 0o644)
    os.replace(file.name, path)
