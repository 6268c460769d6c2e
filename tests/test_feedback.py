"""The pages and cards that the grader writes are plain HTML that anybody can read, on any screen."""

import re
from dataclasses import replace

import numpy as np
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


def errors_of(function, task=EXERCISE.tasks[1]):
    return judged(task, function, "zoé", salt="figure").convergence


def orders(errors):
    """Observed order of convergence, from each three errors that follow each other."""
    logarithms = np.diff(np.log(errors))
    return logarithms[1:] / logarithms[:-1]


def test_a_wrong_iteration_is_drawn_beside_the_right_one():
    newton = EXERCISE.tasks[1]
    chord = next(v.function for v in newton.variants if "slope of the seed" in v.name)
    answer, right = errors_of(chord)
    assert orders(answer)[-1] == pytest.approx(1, abs=0.1)
    assert orders(right[:-2])[-1] > 1.7  # the last one is the root, and the one before as good as it
    assert answer[0] == right[0]
    assert errors_of(newton.reference) == ()
    assert errors_of(lambda *arguments: None) == ()


def test_an_iteration_that_runs_away_is_drawn_as_far_as_it_is_finite():
    def uphill(f, df, seed, tol, error, max_iterations):
        x = seed
        for _ in range(max_iterations):
            x += f(x) / df(x)
        raise RuntimeError("no convergence")

    answer, _ = errors_of(uphill)
    assert answer[1] > answer[0] > 0
    assert np.isfinite(answer).all()


def test_the_figure_of_an_iteration_says_its_numbers_to_those_who_do_not_see_it():
    task = EXERCISE.tasks[1]
    chord = next(v.function for v in task.variants if "slope of the seed" in v.name)
    a = judged(task, chord, "zoé", salt="figure")
    page = card_html(a)
    assert page.count('<svg role="img"') == 1
    assert f"Yours: {a.convergence[0][0]:.0e}, {a.convergence[0][1]:.0e}" in page
    assert len(page) < 30_000
    assert "<svg" not in card_html(judged(task, task.reference, "zoé"))


def test_a_page_links_to_the_book_where_its_address_is_known(graded):
    linked = feedback_page("zoé", EXERCISE.title, graded, "x.txt", SAID, "https://example.org/course/")
    assert 'href="https://example.org/course/newton-1d.html#follow-the-tangent"' in linked
    assert "<a" not in feedback_page("zoé", EXERCISE.title, replace(graded, output=""), "x.txt", SAID)
