"""The grader is examined: what is wrong loses points, whoever or whatever made it wrong."""

import random
from dataclasses import replace

import pytest
from examination.mutants import mutants
from examination.report import examined, waived, write
from examination.solutions import solutions
from examination.trial import calling, equivalents, judge

from autograder.judge import assess

SOLUTIONS = pytest.mark.parametrize("solution", solutions(), ids=lambda s: s.function)
ENOUGH = 15  # mutants a task


@SOLUTIONS
def test_the_solution_in_the_notebook_gets_full_points(solution):
    for task in solution.tasks:
        assessment = assess(task, calling(solution.made()), task.draw("salt", "anyone"), public=False)
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
