"""The checks themselves are examined: the right answer gets full points, each known mistake gets its name."""

import contextlib
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from judging import judged

from autograder.checks import EXERCISES, exercise, task
from autograder.spec import PUBLIC_SALT, task_table

TASKS = [t for e in EXERCISES.values() for t in e.tasks]
VARIANTS = [(t, v) for t in TASKS for v in t.variants]
STUDENTS = [f"student {n}" for n in range(8)]  # the proofs draw 300
POINTS = {  # as the course says
    "01_newton_1d": [2, 4, 2, 2],
    "02_newton_nd": [4, 2, 2, 2],
    "03_motor_profile": [3, 1, 4, 2],
    "04_hacksaw_closure": [4, 2, 2],
    "05_consecutive": [3, 4, 3],
    "06_simultaneous": [1.5, 2.5, 3, 3],
    "07_closed_form": [4, 4, 2],
    "08_wiper_kinematics": [2, 3, 3, 3],
    "09_wiper_inverse_dynamics": [2, 2, 4, 3, 1, 1, 1],
    "10_wiper_direct_dynamics": [4, 3, 2, 2],
    "11_cylinder": [2, 3, 3, 3, 2],
    "12_monte_carlo": [3, 4, 3, 2, 2],
}


@pytest.mark.parametrize("t", TASKS, ids=lambda t: t.name)
def test_the_reference_gets_full_points_from_every_draw(t):
    for student in STUDENTS:
        assessment = judged(t, t.reference, student)
        assert (assessment.verdict, assessment.points) == ("right", t.points), assessment.diagnosis


@pytest.mark.parametrize("t", TASKS, ids=lambda t: t.name)
def test_no_shape_that_a_submission_chose_comes_back_for_hidden_cases(t):
    told = {public: str(judged(t, lambda *_: np.zeros((0, 123456789)), "spy", public=public)) for public in (0, 1)}
    assert "123456789" not in told[False]
    assert "its shape is another one" in told[False] or "123456789" not in told[True]


@pytest.mark.parametrize(("t", "variant"), VARIANTS, ids=lambda x: x.name)
def test_a_known_mistake_is_named_from_every_draw_and_loses_points(t, variant):
    for student in STUDENTS:
        assessment = judged(t, variant.function, student)
        assert assessment.diagnosis == f"{variant.name}. {variant.advice}"
        assert assessment.points < t.points
        assert assessment.points >= variant.share * t.points


@pytest.mark.proof
@pytest.mark.parametrize("t", TASKS, ids=lambda t: t.name)
def test_a_whole_years_students_are_told_the_same_of_the_same_answer(t):
    for student in (f"year {n}" for n in range(300)):
        assert judged(t, t.reference, student).verdict == "right", student
        for variant in t.variants:
            assert judged(t, variant.function, student).diagnosis.startswith(f"{variant.name}. "), student


def fails(*args, **kwargs):
    raise ArithmeticError("at x = 1")


def refuses(*args, **kwargs):
    raise ValueError("bad input")


EMPTY = [None, 0.0, np.nan, [], [0.0], "text", {}, np.zeros((3, 3)), fails, refuses]


@pytest.mark.parametrize("t", TASKS, ids=lambda t: t.name)
@pytest.mark.parametrize("answer", EMPTY, ids=lambda answer: getattr(answer, "__name__", str(answer)))
def test_an_answer_without_any_work_gets_no_points(t, answer):
    for student in STUDENTS[:3]:
        assessment = judged(t, answer if callable(answer) else lambda *args, **kwargs: answer, student)
        assert assessment.points == 0
        assert assessment.diagnosis


def probing(how):
    """A submission that evaluates every function it is handed in an odd way, and then answers in an odd way."""

    def answer(*args, **kwargs):
        for arg in args:
            if callable(arg):
                with contextlib.suppress(Exception):
                    how(arg)
        raise ArithmeticError("no luck")

    return answer


ODD = {
    "nothing": lambda f: f(),
    "two arguments": lambda f: f(1.0, 2.0),
    "text": lambda f: f("x"),
    "a list of one": lambda f: f([1.0]),
    "an empty array": lambda f: f(np.empty(0)),
    "a matrix": lambda f: f(np.ones((3, 3))),
    "nan": lambda f: f(np.nan),
    "a bomb": lambda f: f(np.ones(1_000_000)),
}
STRANGE = [
    [[np.nan, 1.0]],
    [[np.inf, 0]],
    np.full((4, 4), np.inf),
    np.ones((100_000, 2)),
    [[0.5, 1]],
    [[1, 2, 3]],
    [[[]]],
    {1: 2},
]


@pytest.mark.parametrize("t", TASKS, ids=lambda t: t.name)
def test_no_odd_evaluation_and_no_strange_answer_upsets_the_judge(t):
    functions = [probing(how) for how in ODD.values()] + [lambda *args, value=value: value for value in STRANGE]
    for function in functions:
        assessment = judged(t, function, "anyone")
        assert assessment.points == 0
        assert "does not understand" not in assessment.diagnosis


def test_a_loop_that_never_stops_asking_is_endless_on_a_fast_computer_too():
    def loops(f, df, seed, tol, error, max_iterations):
        while True:
            f(seed)

    for name in ("newton_1d", "failures"):
        assessment = judged(task(name), loops, "anyone")
        assert (assessment.verdict, assessment.points) == ("timeout", 0)
        assert assessment.diagnosis == "it did not end in time: does a loop never end?"


def test_a_singular_jacobian_may_be_refused_before_the_residual_is_asked_for():
    def solver(residual, jacobian, seed, tol, max_iterations):
        x, history = np.array(seed), [np.array(seed)]
        for _ in range(max_iterations):
            matrix = np.asarray(jacobian(x))
            if np.linalg.matrix_rank(matrix) < len(x):
                raise ArithmeticError(f"singular at {x}")
            d = np.linalg.solve(matrix, residual(x))
            x = x - d
            history.append(x)
            if np.linalg.norm(d) < tol:
                return np.array(history)
        raise ArithmeticError(f"no convergence at {x}")

    assert judged(task("newton"), solver, "anyone").verdict == "right"


def test_an_answer_that_breaks_a_check_is_an_error_of_its_task_alone():
    broken = replace(TASKS[0], aspects=(replace(TASKS[0].aspects[0], fault=lambda trial, right: 1 / 0),))
    assessment = judged(broken, broken.reference, "anyone")
    assert (assessment.verdict, assessment.points) == ("error", 0)
    assert "does not understand this answer (ZeroDivisionError)" in assessment.diagnosis


@pytest.mark.parametrize("t", TASKS, ids=lambda t: t.name)
def test_a_hidden_fault_tells_neither_the_input_nor_the_exceptions_words(t):
    def leaks(*args, **kwargs):
        raise RuntimeError(f"hidden input: {args}")

    hidden, public = judged(t, leaks, "anyone"), judged(t, leaks, "anyone", public=True)
    assert "hidden input" not in str(hidden)
    assert not any(case.label in str(hidden) for case in t.draw("salt", "anyone"))
    assert "hidden input" in str(public)


@pytest.mark.parametrize("t", TASKS, ids=lambda t: t.name)
def test_each_student_and_each_salt_has_inputs_of_its_own_and_always_the_same(t):
    def drawn(salt, student):
        return [
            [arg if not callable(arg) else None for arg in case.args] + [case.label] for case in t.draw(salt, student)
        ]

    assert repr(drawn("salt", "a")) == repr(drawn("salt", "a"))
    assert len({repr(drawn(*who)) for who in (("salt", "a"), ("salt", "b"), ("pepper", "a"), (PUBLIC_SALT, ""))}) == 4


def test_points_are_what_the_course_says():
    assert {e.name: [t.points for t in e.tasks] for e in EXERCISES.values()} == POINTS


def test_names_of_tasks_are_different_in_all_exercises():
    assert len({t.name for t in TASKS}) == len(TASKS)


def test_an_unknown_name_is_answered_with_those_that_exist():
    with pytest.raises(LookupError, match="there is no exercise '99_x': there are 01_newton_1d, 02_newton_nd"):
        exercise("99_x")
    with pytest.raises(LookupError, match="there is no task 'newtn': there are brackets, newton_1d"):
        task("newtn")


@pytest.mark.parametrize("t", TASKS, ids=lambda t: t.name)
def test_the_section_to_read_exists_in_the_book(t):
    chapter, section = t.section.split(": ", 1)
    text = (Path(__file__).parents[1] / "book" / f"{chapter}.md").read_text("utf-8")
    assert section in re.findall(r"^#+ (.*?)\s*$", text, re.MULTILINE)


def test_the_table_of_an_exercise_adds_up():
    for e in EXERCISES.values():
        aspects = re.findall(r"^\| \| ([\d.]+) \|", task_table(e), re.MULTILINE)
        assert sum(map(float, aspects)) == e.points
        assert f"**{e.points:g}**" in task_table(e)


def test_a_slow_right_way_is_no_mistake_but_an_inverse_is():
    newton = task("newton")

    def by(step):
        def solver(residual, jacobian, seed, tol, max_iterations):
            x, history = np.array(seed), [np.array(seed)]
            for _ in range(max_iterations):
                d = step(np.asarray(jacobian(x)), np.asarray(residual(x)))
                x = x - d
                history.append(x)
                if np.linalg.norm(d) < tol:
                    return np.array(history)
            raise ArithmeticError("no convergence")

        return solver

    def qr(matrix, right):
        q, r = np.linalg.qr(matrix)
        return np.linalg.solve(r, q.T @ right)

    for student in STUDENTS[:5]:
        by_qr = judged(newton, by(qr), student)
        by_inverse = judged(newton, by(lambda m, b: np.linalg.inv(m) @ b), student)
        failed = [[f.says for f in a.findings if f.fault and "no inverse" in f.says] for a in (by_qr, by_inverse)]
        assert [len(f) for f in failed] == [0, 1]
