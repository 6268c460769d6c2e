"""The benchmarks measure what they say; how long things take is their business, and no test's."""

import json
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from autograder.isolation import survey

BENCHMARKS = Path(__file__).parent / "benchmarks"
HELD = 60  # MB
FORK = """
import os, sys
def hold(size): return b"x" * int(1e6 * size)
before, after = map(float, sys.argv[1:])
held = hold(before)
if os.fork() == 0:
    held_too = hold(after)
    print("ready", flush=True)
sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def namespaces():
    found = survey()["namespaces"]
    if not found.available:
        pytest.skip(f"isolation level namespaces: {found.reason}")


@pytest.fixture
def module(monkeypatch):
    monkeypatch.syspath_prepend(BENCHMARKS)
    return pytest.importorskip


@contextmanager
def forked(before, after):
    """A process that holds so many MB before it forks, and whose child holds more."""
    command = [sys.executable, "-c", FORK, str(before), str(after)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout.readline() == b"ready\n"
        yield process.pid
        process.stdin.close()


def run(script, *options):
    command = [sys.executable, BENCHMARKS / f"{script}.py", *options]
    ran = subprocess.run(command, capture_output=True, text=True, encoding="utf-8")
    return ran.returncode, ran.stdout + ran.stderr


def test_the_memory_of_a_tree_counts_a_child_and_what_is_shared_once(module):
    measuring = module("measuring")
    held = {}
    for before, after in ((0, 0), (HELD, 0), (0, HELD), (HELD, HELD)):
        with forked(before, after) as pid:
            held[before, after] = measuring.memory(pid)[0] / measuring.MB
    for (before, after), tree in held.items():
        assert tree - held[0, 0] == pytest.approx(before + after, abs=5)


def test_every_mistake_of_the_benchmarks_still_has_its_place_in_the_solutions(module):
    cohort, assignment = module("cohort_of_300"), module("assignment")
    for exercise, mistakes in cohort.MISTAKES.items():
        text = (cohort.SOLUTIONS / f"{exercise}.ipynb").read_text("utf-8")
        assert all(cohort.edited(text, *mistake) != text for mistake in mistakes)
    for answer in assignment.ANSWERS:
        assert (assignment.answered(answer) is None) == (answer.edits is None)


def test_a_small_cohort_is_graded_as_it_was_made():
    code, said = run("cohort_of_300", "--students", "2", "--exercises", "01_newton_1d", "04_hacksaw_closure")
    assert code == 0, said
    assert "2 students, 4 notebooks" in said


@pytest.mark.proof
def test_our_half_of_the_comparison_gives_every_answer_its_due():
    code, said = run("against_nbgrader", "--submissions", "12", "--tries", "1", "--ours-only")
    assert code in (0, 1), said  # 1: a busy computer; 2 would be marks that were not due
    assert "the student's own work" in said


def test_the_kept_measurement_beside_nbgrader_reached_every_bound(module):
    against = module("against_nbgrader")
    found = json.loads(against.KEPT.read_text("utf-8"))
    assert found["ratios"]["submissions a second, once started"] > 0
    assert against.missed(found) == []
