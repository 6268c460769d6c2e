"""No attack does harm outside its worker, and its honest neighbour is graded as if nothing had been."""

import json
import subprocess
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from concurrent.futures import TimeoutError as Late
from dataclasses import replace

import pytest
from handing_in import code

from attacks.papers import ARCHIVES, NOTEBOOKS
from attacks.table import ATTACKS, BOTH, CALLS, CLASSES, FINDINGS, NAMESPACES, TOOLS, Attack
from attacks.world import CANARY, SOLUTION, WATCHES, World, sandbox_in
from autograder import ingest, judge
from autograder.channel import WorkerLost
from autograder.checks import EXERCISES
from autograder.isolation import survey
from autograder.report import card_html, card_text

EXERCISE = EXERCISES["01_newton_1d"]
SETTLING = 10.0  # s, for killed processes to be gone; it takes milliseconds
PATIENCE = 60.0  # s, for a judge on a busy computer; every attack has a limit of a few at most
SLIPS = ("NameError", "SyntaxError", "AttributeError", "TypeError", "ImportError")  # of an attack's author


def honest():
    """The solution, but for its figures."""
    return ["".join(cell["source"]) for cell in json.loads(code(SOLUTION.read_text("utf-8")))["cells"]]


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
            world.seen.append(raised.message if raised else "")
        world.seen.append(worker.output)
        return world.harm()


def run_notebook(world, place, attack):
    tasks = tuple(replace(task, seconds=attack.seconds) for task in EXERCISE.tasks)
    hasty = replace(EXERCISE, tasks=tasks, cell_seconds=attack.seconds)
    cells = [f"NUMBERS = {numbers()}\nINPUT = {CANARY!r}\n{world.aim()}{TOOLS}", attack.source]
    graded = judge.grade(hasty, cells, place, CANARY, "attacker")
    world.points += graded.points
    world.seen += [text for a in graded.assessments for text in (a.diagnosis, card_text(a))] + [*graded.notes]
    world.seen.append(graded.output)
    world.pages += [card_html(assessment) for assessment in graded.assessments]
    return world.harm()


def harm(world, place, attack, patience=PATIENCE, settling=SETTLING):
    """The names of the watches that fired."""
    place.rest()
    world.begin()
    with ThreadPoolExecutor(1) as thread:
        done = thread.submit(run_notebook if attack.graded else run_cell, world, place, attack)
        try:
            found = done.result(patience)
        except Late:
            world.hung, found = True, set()
            place.close()  # or we would wait, too
    place.rest()
    return found | world.lasting_harm(settling)


def graded(place):
    return judge.grade(EXERCISE, honest(), place, "salt", "neighbour").assessments


def test_every_class_and_every_finding_has_its_attacks():
    held = Counter(name for attack in ATTACKS for name in attack.of)
    held["finding 14"] = len(NOTEBOOKS)
    held["finding 15"] = len(ARCHIVES)
    assert [name for name in (*CLASSES, *FINDINGS) if not held[name]] == []
    assert len({attack.name for attack in ATTACKS}) + len(NOTEBOOKS) + len(ARCHIVES) >= 80


@pytest.mark.parametrize("make", [*NOTEBOOKS.values(), *ARCHIVES.values()], ids=[*NOTEBOOKS, *ARCHIVES])
def test_a_hostile_file_does_no_harm(tmp_path, make):
    with World() as world, ThreadPoolExecutor(1) as thread:
        try:
            world.seen.append(thread.submit(read_in, make(tmp_path, world), tmp_path / "out").result(PATIENCE))
        except Late:
            world.hung = True
        assert world.harm() == set()
    assert not {path.name for path in tmp_path.iterdir()} - {"handed-in.ipynb", "handed-in.zip", "out"}


def read_in(path, out):
    """What is said of a file that was handed in, and what was found in it."""
    try:
        if path.suffix == ".zip":
            ingest.unzip(path, out)
            return str(sorted(out.rglob("*")))
        return str(ingest.parse(ingest.read(path)))
    except ingest.Refused as refusal:
        return str(refusal)


def act_for(watch):
    """A harmless act that a watch must see, done by a process that nothing confines."""
    if watch == "points":
        return Attack("an answer that is right", "\n".join(honest()), watch, frozenset(), graded=True)
    if watch == "patience":
        return Attack("a nap", "time.sleep(3)", watch, frozenset())
    return next(attack for attack in ATTACKS if attack.watch == watch and attack.free)


def raw_output():
    command = [sys.executable, "-c", "print('\x1b[31m<script>')"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


HERE = {  # what no worker does at any level, for the judge cleans and counts at all of them
    "control characters": lambda world: world.seen.append(raw_output()),
    "markup": lambda world: world.pages.append(raw_output()),
    "memory of the grader": lambda world: bytearray(500 << 20).count(1),
}


@pytest.mark.parametrize("watch", WATCHES)
def test_a_watch_sees_a_harmless_act_that_nothing_confines(watch):
    with World() as world:
        if watch in HERE:
            world.begin()
            HERE[watch](world)
            assert watch in world.harm()
        else:
            with sandbox_in(world, "none") as place:
                patience = 0.5 if watch == "patience" else PATIENCE
                assert watch in harm(world, place, act_for(watch), patience, settling=0.2)


@pytest.fixture(scope="module", params=["namespaces", pytest.param("landlock", marks=pytest.mark.proof)])
def field(request):
    """A level, its sandbox, what there is to harm, and what an honest neighbour gets."""
    level = survey()[request.param]
    if not level.available:
        pytest.skip(f"isolation level {level.name}: {level.reason}")
    with World() as world, sandbox_in(world, level.name) as place:
        before = graded(place)
        assert all(assessment.verdict == "right" for assessment in before)
        yield world, place, before


HELD_AT_BOTH = [attack for attack in ATTACKS if attack.levels == BOTH]
HELD_BY_NAMESPACES = [attack for attack in ATTACKS if attack.levels == NAMESPACES]


@pytest.mark.parametrize("attack", HELD_AT_BOTH, ids=lambda attack: attack.name)
def test_an_attack_does_no_harm(field, attack):
    world, place, before = field
    assert harm(world, place, attack) == set()
    assert graded(place) == before


@pytest.mark.parametrize("field", NAMESPACES, indirect=True)
@pytest.mark.parametrize("attack", HELD_BY_NAMESPACES, ids=lambda attack: attack.name)
def test_an_attack_on_the_disk_does_no_harm_in_namespaces(field, attack):
    test_an_attack_does_no_harm(field, attack)


@pytest.mark.proof
@pytest.mark.parametrize("attack", [a for a in ATTACKS if a.free], ids=lambda attack: attack.name)
def test_the_same_attack_does_harm_where_nothing_is_confined(attack):
    with World() as world, sandbox_in(world, "none") as place:
        assert attack.watch in harm(world, place, attack, settling=0.2)
