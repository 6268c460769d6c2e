"""The pages and cards that the grader writes are plain HTML that anybody can read, on any screen."""

import re

import pytest
from judging import judged

from autograder.checks import EXERCISES
from autograder.judge import Graded
from autograder.notebook import Card
from autograder.report import card_html, feedback_page, index_page
from autograder.spec import PUBLIC_SALT

EXERCISE = EXERCISES["01_newton_1d"]
SAID = "Isolation: landlock. namespaces cannot be had: bubblewrap is not installed; sudo apt install bubblewrap."
SCREENS = pytest.mark.parametrize(("width", "theme"), [(1280, "light"), (1280, "dark"), (360, "light"), (360, "dark")])


def practised(task, function):
    return judged(task, function, "", public=True, salt=PUBLIC_SALT)


def fails(*args):
    raise TypeError(f"unsupported operand: {'very_long_name_' * 12}")


@pytest.fixture(scope="module")
def graded():
    """Every verdict: a right answer, a named mistake, a failure, a gap."""
    brackets, newton, failures, order = EXERCISE.tasks
    assessments = (
        practised(brackets, brackets.reference),
        practised(newton, newton.variants[0].function),
        practised(failures, fails),
        practised(order, lambda *args: None),
    )
    notes = ("code cell 3 stopped with NameError: name 'x' is not defined",)
    return Graded(EXERCISE.name, assessments, notes, "a line that is printed " * 20, "namespaces")


@SCREENS
def test_a_feedback_page_and_the_table_of_a_cohort_read_on_any_screen_and_by_anyone(
    tmp_path, graded, opened, axe, width, theme
):
    pages = {
        "feedback": feedback_page("zoé", EXERCISE.title, graded, f"{EXERCISE.name}.txt", SAID),
        "index": index_page([("zoé", graded, "feedback.html")] * 30, SAID),
    }
    for name, page in pages.items():
        (tmp_path / f"{name}.html").write_text(page, encoding="utf-8")
        assert "<script" not in page
        with opened((tmp_path / f"{name}.html").as_uri(), width, theme) as (tab, trouble):
            sideways = tab.evaluate("document.documentElement.scrollWidth - innerWidth")
            violations = axe(tab)
        assert (trouble, violations) == ([], [])
        assert sideways <= 0


@SCREENS
def test_the_card_of_a_check_reads_on_the_page_of_a_notebook(tmp_path, graded, opened, axe, width, theme):
    """A notebook gives the card its colours: black on white, or light on dark."""
    colours = {"light": "color: #000; background: #fff", "dark": "color: #e0e0e0; background: #111"}[theme]
    cards = "".join(card_html(assessment) for assessment in graded.assessments)
    page = (
        f'<!doctype html><html lang="en"><title>notebook</title><body style="{colours}"><main><h1>x</h1>{cards}</main>'
    )
    (tmp_path / "notebook.html").write_text(page, encoding="utf-8")
    assert "<script" not in page
    with opened((tmp_path / "notebook.html").as_uri(), width, theme) as (tab, trouble):
        sideways = tab.evaluate("document.documentElement.scrollWidth - innerWidth")
        violations = axe(tab)
    assert (trouble, violations) == ([], [])
    assert sideways <= 0


def test_the_text_of_a_card_says_what_its_html_says(graded):
    for assessment in graded.assessments:
        html = re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", Card(assessment)._repr_html_()))
        for words in (assessment.mistake, assessment.section, *(f.says for f in assessment.findings)):
            if assessment.verdict not in ("right", "missing"):
                assert words[:60].lower() in repr(Card(assessment)).lower()
                assert words[:60].lower() in html.replace("&#39;", "'").replace("&gt;", ">").lower()


def test_the_points_on_a_card_add_up(graded):
    for assessment in graded.assessments:
        told = [float(n) for n in re.findall(r"\[[ x]\] ([\d.]+) (?:of|more)", repr(Card(assessment)))]
        assert sum(told) == assessment.points
