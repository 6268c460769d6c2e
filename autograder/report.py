"""What people read: the card of a check, the feedback page of a student, the grade table."""

import csv
import io
import re
from collections.abc import Iterable
from urllib.parse import quote

from jinja2 import Environment, PackageLoader

from autograder.decay import decay
from autograder.judge import Assessment, Graded, stopped

WORDS = {
    "right": "right",
    "partly": "partly right",
    "wrong": "not right",
    "error": "stopped with an error",
    "timeout": "no answer in time",
    "missing": "not started",
}
COLUMNS = ("student", "exercise", "task", "points", "max", "verdict", "diagnosis", "isolation")
# beside the words, never instead of them; each is seen on white and on black
COLOURS = {"right": "#2e8b57", "partly": "#b8860b", "missing": "#808080"}


def points(value: float) -> str:
    """Points without needless digits: 2, 1.5, 0.25."""
    return f"{value:.2f}".rstrip("0").rstrip(".")


def sentence(text: str) -> str:
    """With a capital and a full stop."""
    return stopped(text[:1].upper() + text[1:])


_templates = Environment(
    loader=PackageLoader("autograder"), autoescape=True, trim_blocks=True, lstrip_blocks=True, auto_reload=False
)
_templates.globals.update(points=points, words=WORDS, colours=COLOURS)


def card_text(a: Assessment) -> str:
    """The card of one task as plain text."""
    lines = [f"{a.task}: {WORDS[a.verdict]}, {points(a.points)} of {points(a.max)} points"]
    if said := a.mistake or a.why:
        lines.append(f"  {sentence(said)}")
    if a.verdict != "missing":
        for f in a.findings:
            fault = f". No: {stopped(f.fault)}" if f.fault else ""
            lines.append(f"  [{' ' if f.fault else 'x'}] {points(f.earned)} of {points(f.points)}: {f.says}{fault}")
        if a.granted > 0:
            lines.append(f"  [x] {points(a.granted)} more for what is right beside this mistake")
    if a.verdict != "right":
        lines.append(f"  To read: {a.section}")
    return "\n".join(lines)


def convergence_words(a: Assessment) -> str:
    """The drawing of errors against iterations, for those who do not see it."""
    answer, right = ([f"{error:.0e}" for error in errors if error] for errors in a.convergence)
    return f"Error of each iterate. Yours: {', '.join(answer)}. Right ones: {', '.join(right)}."


def card_html(a: Assessment) -> str:
    """The card of one task as HTML without script."""
    return str(_templates.get_template("card.html").module.card(a))


def feedback_page(student: str, title: str, graded: Graded, printed: str, isolation: str, book: str = "") -> str:
    """The page that a student gets back.

    Parameters
    ----------
    printed : str
        Name of the file, beside the page, with what the notebook printed.
    isolation : str
        What is said of the isolation level.
    book : str
        Address of the built book, for links to its sections; without it they are named.
    """
    page = _templates.get_template("feedback.html")
    return page.render(student=student, title=title, graded=graded, printed=printed, isolation=isolation, book=book)


def section_address(book: str, section: str) -> str:
    """Where a section is in the built book, from its name as ``chapter: heading``."""
    chapter, _, heading = section.partition(": ")
    anchor = re.sub("[^a-z0-9]+", "-", heading.lower()).strip("-")
    return f"{book.rstrip('/')}/{chapter}.html#{anchor}"


_templates.filters.update(
    sentence=sentence,
    stopped=stopped,
    decay=lambda a: decay(a.convergence),
    zip=zip,
    convergence_words=convergence_words,
    section_address=section_address,
)


def index_page(rows: Iterable[tuple[str, Graded, str]], isolation: str) -> str:
    """The table of a cohort, for the instructor."""
    return _templates.get_template("index.html").render(rows=rows, isolation=isolation)


def grades(results: Iterable[tuple[str, Graded]]) -> str:
    """`grades.csv`: a row a task, sorted, without time stamps, so that two runs can be compared byte by byte."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(COLUMNS)
    for student, g in sorted(results, key=lambda result: (result[0], result[1].exercise)):
        for a in g.assessments:
            row = (student, g.exercise, a.task, points(a.points), points(a.max), a.verdict, a.diagnosis, g.isolation)
            table.writerow([_harmless(cell) for cell in row])
    return text.getvalue()


def _harmless(cell: str) -> str:
    """A cell that no spreadsheet takes for a formula: a student chooses the name of a folder, and of an exception."""
    return f"'{cell}" if cell[:1] in "=+-@\t\r" and cell[:1] else cell


def feedback_link(student: str, exercise: str) -> str:
    """Address of a feedback page, as seen from the index."""
    return f"feedback/{quote(student)}/{quote(exercise)}.html"
