"""The grader is examined: what is wrong loses points, whoever or whatever made it wrong."""

import random
from collections import defaultdict
from dataclasses import replace
from itertools import combinations

import pytest
from examination.mutants import mutants
from examination.report import examined, waived, write
from examination.solutions import solutions
from examination.student import function
from examination.students import STUDENTS
from examination.trial import calling, equivalents, judge
from judging import judged

from autograder.checks import EXERCISES, task
from autograder.judge import assess, drawn

SOLUTIONS = pytest.mark.parametrize("solution", solutions(), ids=lambda s: s.function)
ENOUGH = 15  # mutants a task
OF_THE_SOURCE = defaultdict(set) | {  # nobody could write them from the text of the task
    "motor_profile": {
        f"The angle{of} is that of the printed equation (5)"
        for of in ("", " of the first piece", " of the second piece", " of the third piece")
    },
    "closure_jacobian": {"It is source A's matrix (17)"},
    "nine_jacobian": {"The guide's acceleration row is that of source A's appendix D"},
}
TOGETHER = {  # two mistakes that are a third
    (
        "The results are polynomials of the time since the start of the piece",
        "The acceleration is read as a polynomial of the time since the start of the piece",
    ): "Acceleration and results are polynomials of the time since the start of the piece",
    (
        "The angle has no constants of integration",
        "The speed has no constants of integration",
    ): "The constants of integration are forgotten",
    (
        "The shaft has its final speed all the time",
        "The square root is missing",
    ): "The speed at T is set to the angle",
    (
        "The Coriolis term is missing",
        "The centripetal terms are missing",
    ): "Every term with a product of two velocities is missing",
    (
        "The angular acceleration of the crank is forgotten",
        "The angular velocity of the crank is forgotten",
    ): "The crank does not move in the derivatives",
    (
        "m d^2 is added on the way to the centre of mass",
        "m d^2 is subtracted on the way from the centre of mass",
    ): "m d^2 is added and subtracted the wrong way round",
    ("r1 is eliminated from Fx and Fy", "The rows are in the order Fc, Fx, Fy"): "It is source A's matrix (17)",
    (
        "The right side of the velocities has the wrong sign",
        "The right side of the accelerations has the wrong sign",
    ): "The right sides of both systems have the wrong sign",
    (
        "The last point is missing",
        "The seed is returned in front of the positions",
    ): "The seed is returned as the first point, and all others are late by one",
    (
        "The height of the guide has the wrong sign",
        "The height of the crank pin is added where it is to be subtracted",
    ): "The sine of the coupler has the wrong sign",
    (
        "r1 is made positive",
        "theta1 is half a turn off on the left branch",
    ): "r1 is positive on both branches, and theta1 points to the slider",
    (
        "The centripetal terms of the closure are missing",
        "The centripetal terms of the bodies are missing",
    ): "All centripetal terms are missing",
    (
        "The centripetal terms of the closure have the wrong sign",
        "The centripetal terms of the bodies have the wrong sign",
    ): "All centripetal terms have the wrong sign",
    (
        "The work of the torque is forgotten",
        "The work of the loads is forgotten",
    ): "The work is forgotten",
    (
        "The work of the torque has the wrong sign",
        "The work of the loads has the wrong sign",
    ): "The work has the wrong sign",
    (
        "The work has the wrong sign",
        "The work of the torque has the wrong sign",
    ): "The work of the loads has the wrong sign",
    (
        "The work has the wrong sign",
        "The work of the loads has the wrong sign",
    ): "The work of the torque has the wrong sign",
    (
        "The angles of the triangle at O2 and O4 are exchanged",
        "The cosines have the wrong sign",
    ): "theta4 comes first",
    (
        "The Coriolis term is missing, or 1/s is differentiated with the wrong sign",
        "The centripetal terms have the wrong sign",
    ): "The change of D has the wrong sign",
    (
        "The Coriolis acceleration is missing",
        "The centripetal accelerations are missing",
    ): "The Coriolis acceleration is half of what it should be",
    (
        "The angles of the triangle at O2 and O4 are exchanged",
        "theta4 comes first",
    ): "The cosines have the wrong sign",
    (
        "The cosines have the wrong sign",
        "theta4 comes first",
    ): "The angles of the triangle at O2 and O4 are exchanged",
    (
        "The Coriolis term is half of what it should be, or the change of s is forgotten",
        "Both centripetal terms are missing",
    ): "D is taken for constant in h",
    (
        "The Coriolis term is half of what it should be, or the change of s is forgotten",
        "The centripetal term of the cylinder is missing",
    ): "D changes with theta4 alone",
    (
        "The Coriolis acceleration is missing",
        "The sliding is missing from the velocity of the rod",
    ): "The rod does not slide: its centre of mass only turns about O2",
    (
        "The Coriolis acceleration is half of what it should be",
        "The centripetal accelerations point outwards",
    ): "The centripetal accelerations are missing",
    (
        "The Coriolis acceleration has the wrong sign",
        "The centripetal accelerations point outwards",
    ): "The Coriolis acceleration is missing",
    (
        "The branches are exchanged",
        "It is the open branch, whichever is asked for",
    ): "It is the crossed branch, whichever is asked for",
    (
        "The branches are exchanged",
        "It is the crossed branch, whichever is asked for",
    ): "It is the open branch, whichever is asked for",
    (
        "rcy cos(theta3) has a minus in Py",
        "rcy sin(theta3) has a plus in Px",
    ): "P is on the other side of the coupler",
    (
        "rcy cos(theta3) has a minus in Py",
        "P is on the other side of the coupler",
    ): "rcy sin(theta3) has a plus in Px",
    (
        "rcy sin(theta3) has a plus in Px",
        "P is on the other side of the coupler",
    ): "rcy cos(theta3) has a minus in Py",
    (
        "The arm is not turned with the frame",
        "The crank is not turned with the frame",
    ): "The frame is not turned",
    ("The frame is not turned", "The frame is not moved"): "The frame is not looked at",
    (
        "The half width is taken for the deviation",
        "The sizes are added",
    ): "The worst case is given: the sizes are added, with the half widths",
    ("The throws have no logarithm", "The errors have no logarithm"): "No logarithm is taken",
}
WRITTEN = pytest.mark.parametrize("name", STUDENTS)
DRAWS = pytest.mark.parametrize("draws", [3, pytest.param(200, marks=pytest.mark.proof)])


@SOLUTIONS
def test_the_solution_in_the_notebook_gets_full_points(solution):
    for t in solution.tasks:
        assessment = assess(drawn(t, "salt", "anyone"), calling(solution.made()), public=False)
        assert assessment.verdict == "right", assessment.diagnosis


@SOLUTIONS
def test_a_mutant_drawn_at_random_loses_points_or_is_the_reference(solution):
    made = mutants(solution.source)
    assert len(made) >= ENOUGH * len(solution.tasks)
    drawn = [m for m in random.Random(solution.function).sample(made, 3) if not waived(solution, m)]
    survivors = [mutant for mutant in drawn if not judge(solution, mutant).lost]
    assert not [*filter(None, equivalents(solution, survivors, inputs_wanted=100).values())]


def test_a_loop_that_never_ends_is_a_timeout_and_not_the_end_of_the_examination():
    order = next(s for s in solutions() if s.function == "order")
    endless = replace(mutants(order.source)[0], source="def order(history):\n    while True:\n        pass")
    assert judge(order, endless, seconds=0.05).verdicts == {"timeout"}


@pytest.mark.proof
def test_every_mutant_that_is_not_the_reference_loses_points():
    rows = examined()
    write(rows)
    survivors = {f"{row['tasks'][0]}: {mutant}": where for row in rows for mutant, where in row["survivors"].items()}
    killed = sum(row["killed"] for row in rows)
    for row in rows:
        print(f"{' and '.join(row['tasks'])}: {row['killed']} of {row['mutants']} mutants lose points")
    print(f"{killed} of {killed + len(survivors)} that are not equivalent", *survivors, sep="\n")
    assert killed >= 0.98 * (killed + len(survivors))


# --- mistakes as students write them


def test_the_students_make_every_known_mistake_but_those_that_are_a_formula_of_the_source():
    known = {t.name: {v.name for v in t.variants} for e in EXERCISES.values() for t in e.tasks if t.variants}
    assert {name: set(student.mistakes) | OF_THE_SOURCE[name] for name, student in STUDENTS.items()} == known


@WRITTEN
@DRAWS
def test_no_mistake_is_named_on_a_right_solution(name, draws):
    right = function(STUDENTS[name].right, task(name).function)
    for n in range(draws):
        assessment = judged(name, right, f"right {n}")
        assert (assessment.verdict, assessment.mistake) == ("right", ""), assessment.diagnosis


@WRITTEN
@DRAWS
def test_a_mistake_that_a_student_makes_from_its_name_alone_is_named(name, draws):
    student = STUDENTS[name]
    wrong = {mistake: function(student.written(mistake), task(name).function) for mistake in student.mistakes}
    for n in range(draws if name != "basin_map" else draws // 3):
        for mistake, made in wrong.items():
            assessment = judged(name, made, f"student {n}")
            assert assessment.mistake.startswith(f"{mistake}. "), f"{mistake}: {assessment.diagnosis}"


@WRITTEN
@pytest.mark.proof
def test_of_two_mistakes_at_once_a_true_one_is_named_or_none(name):
    student = STUDENTS[name]
    written = {pair: both for pair in combinations(student.mistakes, 2) if (both := student.written(*pair))}
    made = {pair: function(both, task(name).function) for pair, both in written.items()}
    for n in range(20):
        for pair, both in made.items():
            true = tuple(f"{mistake}. " for mistake in (*pair, TOGETHER.get(pair)) if mistake)
            named = judged(name, both, f"student {n}").mistake
            assert named == "" or named.startswith(true), f"{pair}: {named}"


@SOLUTIONS
@pytest.mark.proof
def test_the_solution_in_the_notebook_is_told_no_mistake_whatever_is_drawn(solution):
    for t in solution.tasks:
        for n in range(200):
            assessment = judged(t, solution.made(), f"student {n}", salt=f"salt {n}")
            assert (assessment.verdict, assessment.mistake) == ("right", ""), assessment.diagnosis
