"""No attack does harm outside its worker, and its honest neighbour is graded as if nothing had been."""

import json
from concurrent.futures import ThreadPoolExecutor
from concurrent.futures import TimeoutError as Late
from dataclasses import replace
from pathlib import Path

import pytest

from attacks.table import ATTACKS, CALLS, TOOLS
from attacks.world import CANARY, World, sandbox_in
from autograder import judge
from autograder.channel import WorkerLost
from autograder.checks import EXERCISES
from autograder.isolation import survey

ROOT = Path(__file__).resolve().parents[2]
EXERCISE = EXERCISES["01_newton_1d"]
LEVELS = ("namespaces", "landlock")
PATIENCE = 60.0  # s, for a judge on a busy computer; every attack has a limit of a few at most
SLIPS = ("NameError", "SyntaxError", "AttributeError", "TypeError", "ImportError")  # of an attack's author


def honest():
    """The solution, but for its figures."""
    cells = json.loads((ROOT / "solutions" / "01_newton_1d.ipynb").read_text("utf-8"))["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    return [source for source in code if source.startswith(("import", "class", "def"))]


def numbers():
    """Of the system calls that libseccomp knows on this computer."""
    pyseccomp = pytest.importorskip("pyseccomp", reason="isolation level landlock: needs pyseccomp")
    native = pyseccomp.system_arch()
    return {name: pyseccomp.resolve_syscall(native, name) for name in CALLS}


def run_cell(world, place, attack):
    with place.worker() as worker:
        assert worker.run(f"NUMBERS = {numbers()}\n{world.aim()}{TOOLS}", seconds=20).raised is None
        try:
            raised = worker.run(attack.source, seconds=attack.seconds).raised
        except WorkerLost as lost:
            world.seen.append(str(lost))
        else:
            assert raised is None or not any(map(raised.is_a, SLIPS)), raised
            world.seen.append(str(raised))
        world.seen.append(worker.output)
        return world.harm()


def run_notebook(world, place, attack):
    tasks = tuple(replace(task, seconds=attack.seconds) for task in EXERCISE.tasks)
    hasty = replace(EXERCISE, tasks=tasks, cell_seconds=attack.seconds)
    cells = [f"NUMBERS = {numbers()}\n{world.aim()}{TOOLS}", attack.source]
    graded = judge.grade(hasty, cells, place, CANARY, "attacker")
    world.points += graded.points
    world.seen.append(repr(graded))
    return world.harm()


def harm(world, place, attack):
    """The names of the watches that fired."""
    world.begin()
    with ThreadPoolExecutor(1) as thread:
        done = thread.submit(run_notebook if attack.graded else run_cell, world, place, attack)
        try:
            found = done.result(PATIENCE)
        except Late:
            world.hung, found = True, set()
            place.close()  # or we would wait, too
    return found | world.lasting_harm()


def graded(place):
    return judge.grade(EXERCISE, honest(), place, "salt", "neighbour").assessments


@pytest.fixture(scope="module", params=LEVELS)
def field(request):
    """A level, its sandbox, what there is to harm, and what an honest neighbour gets."""
    level = survey()[request.param]
    if not level.available:
        pytest.skip(f"isolation level {level.name}: {level.reason}")
    with World() as world, sandbox_in(world, level.name) as place:
        before = graded(place)
        assert all(assessment.verdict == "right" for assessment in before)
        yield world, place, before


@pytest.mark.parametrize("attack", ATTACKS, ids=lambda attack: attack.name)
def test_an_attack_does_no_harm(field, attack):
    world, place, before = field
    if place.level not in attack.levels:
        return
    assert harm(world, place, attack) == set()
    assert graded(place) == before


@pytest.mark.proof
@pytest.mark.parametrize("attack", [a for a in ATTACKS if a.free], ids=lambda attack: attack.name)
def test_the_same_attack_does_harm_where_nothing_is_confined(attack):
    with World() as world, sandbox_in(world, "none") as place:
        assert attack.watch in harm(world, place, attack)
