"""The saw of mechlib and that of a multibody engine, which shares no equation with it, are the same saw."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import exudyn
import numpy as np
import pytest

from mechlib.hacksaw import Hacksaw
from mechlib.motion import MotorProfile
from mechlib.sweep import consecutive

SCRIPT = Path(__file__).parents[1] / "book" / "engine" / "hacksaw.py"
TABLES = ("hacksaw.csv", "hacksaw_steps.csv")

# Parts of a quantity's range: of the stroke for the length r1, of its own swing for an angle.
AGREES = np.repeat([1e-9, 1e-6, 1e-3], 3)

# Another processor rounds otherwise. A unit in the last place of theta2 moves the positions by some 3e-15 of their
# range, and the integrator divides it by h = 1.2e-4 s for the velocities (1e-11) and once more for the accelerations
# (3e-8). The errors of the engine itself, 2e-7 and 1e-6, stay well above.
ROUND_OFF = np.repeat([1e-14, 1e-10, 1e-7], 3)


@pytest.fixture(scope="module")
def engine():
    spec = importlib.util.spec_from_file_location("engine_hacksaw", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def motion():
    profile = MotorProfile.through(2 * np.pi)
    return profile.at(np.linspace(0, 2 * profile.T, 1000))


@pytest.fixture(scope="module")
def mechlib(motion):
    swept = consecutive(Hacksaw(), motion, [-0.1, -0.5, 3.0], tol=1e-12)
    return np.hstack((swept.position, swept.velocity, swept.acceleration))


@pytest.fixture(scope="module")
def span(mechlib):
    return np.ptp(mechlib, axis=0)


def table(folder, name):
    return np.loadtxt(folder / name, delimiter=",")


@pytest.fixture(scope="module")
def saw():
    return table(SCRIPT.parent, "hacksaw.csv")


@pytest.fixture(scope="module")
def again(tmp_path_factory):
    """The script, run once more: the folder of its tables, what it said, and what it left where it ran."""
    here, there = tmp_path_factory.mktemp("here"), tmp_path_factory.mktemp("there")
    code = f"import pathlib, runpy; runpy.run_path({str(SCRIPT)!r})['main'](pathlib.Path({str(there)!r}))"
    done = subprocess.run([sys.executable, "-c", code], cwd=here, capture_output=True, text=True, check=True)
    return there, done, list(here.iterdir())


def errors(found, expected, span):
    return np.abs(found - expected).max(axis=0) / span


def test_the_stored_table_agrees_with_mechlib_at_every_instant(saw, motion, mechlib, span):
    np.testing.assert_allclose(saw[:, 0], motion.t, rtol=1e-15)
    assert (errors(saw[:, 1:], mechlib, span) < AGREES).all()


def test_the_engine_run_again_reproduces_the_stored_table_and_agrees_too(again, saw, mechlib, span):
    new = table(again[0], "hacksaw.csv")
    assert (errors(new[:, 1:], saw[:, 1:], span) < ROUND_OFF).all()
    assert (errors(new[:, 1:], mechlib, span) < AGREES).all()


@pytest.mark.parametrize("change", [{"r1y": 0.045 + 1e-9}, {"r2": 0.075 + 1e-9}, {"r3": 0.170 + 1e-9}], ids=str)
def test_a_length_that_is_a_nanometre_off_would_be_seen(saw, motion, span, change):
    other = Hacksaw(**change).position(motion.position)
    assert (errors(saw[:, 1:4], other, span[:3]) > 2 * AGREES[:3]).any()


def test_positions_are_exact_at_any_step_and_the_rest_has_the_order_two_of_the_integrator(again):
    stored, new = (table(folder, "hacksaw_steps.csv") for folder in (SCRIPT.parent, again[0]))
    assert (np.abs(new - stored)[:, 1:] < ROUND_OFF).all()
    for steps in (stored, new):
        np.testing.assert_allclose(steps[:-1, 0] / steps[1:, 0], 2, rtol=1e-12)
        assert steps[:, 1:4].max() < 1e-14
        np.testing.assert_allclose(np.log2(steps[:-1, 4:] / steps[1:, 4:]), 2, atol=0.1)


def test_the_limit_of_small_steps_is_mechlib(engine, saw, mechlib, span):
    """Richardson extrapolation takes the error of order two away; what is left is of order four, and round-off."""
    limit = (4 * saw[:, 1:] - engine.simulate(engine.STEPS // 2)) / 3
    assert (errors(limit, mechlib, span)[3:] < np.repeat([2e-9, 1e-7], 3)).all()


def test_the_engine_is_given_the_motion_of_the_motor_and_nothing_else_of_mechlib():
    code = (
        f"import runpy, sys; runpy.run_path({str(SCRIPT)!r})['simulate'](1); "
        "print(*sorted(name for name in sys.modules if name.startswith('mechlib')))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["mechlib", "mechlib.motion", "mechlib.require"]


def test_a_run_says_what_it_wrote_and_leaves_nothing_else(again):
    there, done, here = again
    assert [Path(line.partition(": ")[0]) for line in done.stdout.splitlines()] == [there / name for name in TABLES]
    assert done.stderr == ""
    assert here == []
    assert sorted(path.name for path in there.iterdir()) == sorted(TABLES)


@pytest.mark.parametrize("name", TABLES)
def test_a_table_says_what_made_it_and_what_its_columns_are(again, name):
    first, *_, last = [line for line in (again[0] / name).read_text("utf-8").splitlines() if line.startswith("#")]
    assert first == f"# Exudyn {exudyn.__version__}, made by: python book/engine/hacksaw.py"
    assert len(last.split(", ")) == table(SCRIPT.parent, name).shape[1] == 10


def test_without_the_engine_one_sentence_says_what_to_type():
    code = f"import runpy, sys; sys.modules['exudyn'] = None; runpy.run_path({str(SCRIPT)!r}, run_name='__main__')"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == "The engine, exudyn, is not installed: type make environment\n"
