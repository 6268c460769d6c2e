"""The mechanisms of mechlib and those of a multibody engine, which shares no equation with it, are the same."""

import runpy
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import exudyn
import numpy as np
import pytest

from mechlib.cylinder import Cylinder, Swing, newton_euler, virtual_power
from mechlib.hacksaw import Hacksaw
from mechlib.motion import MotorProfile
from mechlib.sweep import consecutive
from mechlib.wiper import Wiper

ENGINE = Path(__file__).parents[1] / "book" / "engine"
TABLES = {
    "hacksaw": ("hacksaw.csv", "hacksaw_steps.csv"),
    "wiper": ("wiper_inverse.csv", "wiper_run_up.csv", "wiper_coasting.csv", "wiper_steps.csv"),
    "cylinder": ("cylinder.csv", "cylinder_steps.csv"),
}
COLUMNS = {"hacksaw": (10, 10), "wiper": (31, 3, 3, 9), "cylinder": (9, 9)}
COARSER = 4  # the wiper is run again with steps so many times as long: seconds, and not a minute

# Parts of a quantity's range: of the stroke for the length r1, of its own swing for an angle.
AGREES = np.repeat([1e-9, 1e-6, 1e-3], 3)

# Another processor rounds otherwise. A unit in the last place of theta2 moves the positions by some 3e-15 of their
# range, and the integrator divides it by h = 1.2e-4 s for the velocities (1e-11) and once more for the accelerations
# (3e-8). The errors of the engine itself, 2e-7 and 1e-6, stay well above.
ROUND_OFF = np.repeat([1e-14, 1e-10, 1e-7], 3)

# The same for the columns of wiper_steps.csv. Forces go with h to the power of minus two: a unit in the last place of a
# length or of the time of a turn moves them by up to 6e-9 with the coarser steps, and 4e-7 with those of the table.
WIPER_ROUND_OFF = np.array([1e-7] * 4 + [1e-11, 1e-7, 1e-9, 1e-7])
FINEST_ROUND_OFF = np.array([4e-6] * 4 + [1e-11, 1e-7, 1e-9, 1e-7])

# And for those of cylinder.csv: 2e-8 of the range of Q, and more of what hardly changes: O2_x has a hundredth of it.
CYLINDER_ROUND_OFF = np.array([1e-7, 2e-6, 1e-7, 1e-6, 1e-7, 1e-6, 1e-7, 2e-6])


def table(folder, name):
    return np.loadtxt(folder / name, delimiter=",")


def python(code, cwd=None):
    """Run it where the scripts of the engine can be imported."""
    code = f"import runpy, sys; from pathlib import Path; sys.path.insert(0, {str(ENGINE)!r}); {code}"
    return subprocess.run([sys.executable, "-c", code], cwd=cwd, capture_output=True, text=True)


def run_again(tmp_path_factory, name, *arguments):
    """The script, run once more: the folder of its tables, what it said, and what it left where it ran."""
    here, there = tmp_path_factory.mktemp("here"), tmp_path_factory.mktemp("there")
    call = ", ".join((f"Path({str(there)!r})", *map(str, arguments)))
    done = python(f"import {name}; {name}.main({call})", cwd=here)
    done.check_returncode()
    return there, done, list(here.iterdir())


@pytest.fixture(scope="module")
def hacksaw_again(tmp_path_factory):
    return run_again(tmp_path_factory, "hacksaw")


@pytest.fixture(scope="module")
def wiper_again(tmp_path_factory):
    return run_again(tmp_path_factory, "wiper", COARSER)


@pytest.fixture(scope="module")
def cylinder_again(tmp_path_factory):
    return run_again(tmp_path_factory, "cylinder")


@pytest.fixture(params=TABLES)
def again(request):
    """Of each mechanism: its name, and its script run again."""
    return request.param, request.getfixturevalue(f"{request.param}_again")


def script(name):
    """What a script defines."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ENGINE)
        return SimpleNamespace(**runpy.run_path(str(ENGINE / f"{name}.py")))


# --- each mechanism


def test_a_run_says_what_it_wrote_and_leaves_nothing_else(again):
    name, (there, done, here) = again
    assert [Path(line.partition(": ")[0]) for line in done.stdout.splitlines()] == [there / t for t in TABLES[name]]
    assert done.stderr == ""
    assert here == []
    assert sorted(path.name for path in there.iterdir()) == sorted(TABLES[name])


def test_a_table_says_what_made_it_and_what_its_columns_are(again):
    name, (there, *_) = again
    for file, columns in zip(TABLES[name], COLUMNS[name], strict=True):
        first, *_, last = [line for line in (there / file).read_text("utf-8").splitlines() if line.startswith("#")]
        assert first == f"# Exudyn {exudyn.__version__}, made by: python book/engine/{name}.py"
        assert len(set(last.split(", "))) == table(ENGINE, file).shape[1] == table(there, file).shape[1] == columns


@pytest.mark.parametrize("name", TABLES)
def test_without_the_engine_one_sentence_says_what_to_type(name):
    done = python(f"sys.modules['exudyn'] = None; runpy.run_path({str(ENGINE / name)!r} + '.py', run_name='__main__')")
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == "The engine, exudyn, is not installed: type make environment\n"


@pytest.mark.parametrize(
    ("runs", "given"),
    [
        ("import hacksaw; hacksaw.simulate(1)", ["mechlib", "mechlib.motion", "mechlib.require"]),
        ("import wiper; wiper.by_engine((30.0, 3.83), 8)", []),
        ("import cylinder; cylinder.simulate(1)", []),
    ],
    ids=["hacksaw: the motion of its motor", "wiper: two numbers", "cylinder: nothing"],
)
def test_of_mechlib_the_engine_is_given_no_more_than_the_motor(runs, given):
    done = python(f"{runs}; print(*sorted(name for name in sys.modules if name.startswith('mechlib')))")
    assert (done.stdout.split(), done.stderr) == (given, "")


# --- the hacksaw


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


@pytest.fixture(scope="module")
def saw():
    return table(ENGINE, "hacksaw.csv")


def errors(found, expected, span):
    return np.abs(found - expected).max(axis=0) / span


def test_the_stored_table_agrees_with_mechlib_at_every_instant(saw, motion, mechlib, span):
    np.testing.assert_allclose(saw[:, 0], motion.t, rtol=1e-15)
    assert (errors(saw[:, 1:], mechlib, span) < AGREES).all()


def test_the_engine_run_again_reproduces_the_stored_table_and_agrees_too(hacksaw_again, saw, mechlib, span):
    new = table(hacksaw_again[0], "hacksaw.csv")
    assert (errors(new[:, 1:], saw[:, 1:], span) < ROUND_OFF).all()
    assert (errors(new[:, 1:], mechlib, span) < AGREES).all()


@pytest.mark.parametrize("change", [{"r1y": 0.045 + 1e-9}, {"r2": 0.075 + 1e-9}, {"r3": 0.170 + 1e-9}], ids=str)
def test_a_length_that_is_a_nanometre_off_would_be_seen(saw, motion, span, change):
    other = Hacksaw(**change).position(motion.position)
    assert (errors(saw[:, 1:4], other, span[:3]) > 2 * AGREES[:3]).any()


def test_positions_are_exact_at_any_step_and_the_rest_has_the_order_two_of_the_integrator(hacksaw_again):
    stored, new = (table(folder, "hacksaw_steps.csv") for folder in (ENGINE, hacksaw_again[0]))
    assert (np.abs(new - stored)[:, 1:] < ROUND_OFF).all()
    for steps in (stored, new):
        np.testing.assert_allclose(steps[:-1, 0] / steps[1:, 0], 2, rtol=1e-12)
        assert steps[:, 1:4].max() < 1e-14
        np.testing.assert_allclose(np.log2(steps[:-1, 4:] / steps[1:, 4:]), 2, atol=0.1)


def test_the_limit_of_small_steps_is_mechlib(saw, mechlib, span):
    """Richardson extrapolation takes the error of order two away; what is left is of order four, and round-off."""
    engine = script("hacksaw")
    limit = (4 * saw[:, 1:] - engine.simulate(engine.STEPS // 2)) / 3
    assert (errors(limit, mechlib, span)[3:] < np.repeat([2e-9, 1e-7], 3)).all()


# --- the wiper


def tables(folder):
    return {file[len("wiper_") : -len(".csv")]: table(folder, file) for file in TABLES["wiper"][:-1]}


@pytest.fixture(scope="module")
def wiper():
    return script("wiper")


@pytest.fixture(scope="module")
def turn_and_motions(wiper):
    """What mechlib has for the three tables."""
    return wiper.by_mechlib(wiper.through_mean(), tables(ENGINE))


def test_torque_and_joint_forces_over_a_turn_agree_within_1e_5_of_their_ranges(wiper, turn_and_motions):
    off = wiper.errors(tables(ENGINE), turn_and_motions)
    assert max(off["M without friction"], off["M"]) < 5e-6
    assert max(off["joint forces without friction"], off["joint forces"]) < 1e-5


def test_the_run_up_agrees_within_1e_5_of_35_rpm_from_the_first_instant_on(wiper, turn_and_motions):
    off = wiper.errors(tables(ENGINE), turn_and_motions)
    assert off["omega_1 running up"] < 5e-6
    assert off["theta_1 running up"] < 2e-8


def test_the_engine_has_the_verified_torques_and_the_coasting_wiper_of_source_b():
    turn, coasting = table(ENGINE, "wiper_inverse.csv"), table(ENGINE, "wiper_coasting.csv")
    free, rubbed = turn[:, 1], turn[:, 16]
    np.testing.assert_allclose([free.min(), free.max()], [-2.1396116335, 2.3845747939], atol=2e-5)
    np.testing.assert_allclose([rubbed.min(), rubbed.max()], [-0.7824455265, 4.5923100587], atol=2e-5)
    at_e = np.abs(turn[:, 16 + 1 + 2 * "OABCDEF".index("E") :][:, :2]).max(axis=0)
    np.testing.assert_allclose(at_e, [32.24432821, 1.50472315], rtol=1e-5)
    np.testing.assert_allclose(coasting[-1], [2.0, 13.74361211, 3.76830092], rtol=5e-5)


@pytest.mark.parametrize("bar", range(5))
def test_a_gram_more_on_a_bar_would_be_seen(wiper, bar):
    masses = list(Wiper.masses)
    masses[bar] = replace(masses[bar], mass=masses[bar].mass + 1e-3)
    other = wiper.turn_by_mechlib(Wiper(masses=tuple(masses)), 0.0)[:, :1]
    assert errors(table(ENGINE, "wiper_inverse.csv")[:, 1:2], other, np.ptp(other)) > 2e-5


def test_the_wiper_run_again_errs_as_stored_and_all_errors_fall_with_the_square_of_the_step(wiper_again):
    stored, new = (table(folder, "wiper_steps.csv") for folder in (ENGINE, wiper_again[0]))
    np.testing.assert_allclose(stored[:, 0], [1 / 8, 1 / 4, 1 / 2, 1])
    assert (np.abs(new - stored[: len(new)])[:, 1:] < WIPER_ROUND_OFF).all()
    orders = np.log2(stored[:-1, 1:] / stored[1:, 1:])
    np.testing.assert_allclose(orders[1:], 2, atol=0.1)
    np.testing.assert_allclose(orders[0], 2, atol=0.2)


def test_the_limit_of_small_steps_is_mechlib_for_the_wiper_too(wiper, turn_and_motions, wiper_again):
    """Richardson extrapolation from the tables and from those with steps four times as long."""
    fine, coarse = tables(ENGINE), tables(wiper_again[0])
    limit = {name: (COARSER**2 * fine[name] - coarse[name]) / (COARSER**2 - 1) for name in fine}
    off = wiper.errors(limit, turn_and_motions)
    assert max(off[name] for name in off if "coasting" not in name) < 1e-6
    assert max(off.values()) < 1e-4


@pytest.mark.proof
def test_the_wiper_run_again_gives_the_stored_tables(wiper, tmp_path_factory):
    there, *_ = run_again(tmp_path_factory, "wiper")
    off = wiper.errors(tables(there), tables(ENGINE))
    assert (np.array(list(off.values())) < FINEST_ROUND_OFF).all()


# --- the cylinder


@pytest.fixture(scope="module")
def period():
    """The forces of the engine over a period."""
    return table(ENGINE, "cylinder.csv")


def forces(cylinder, t):
    """What mechlib has for them."""
    sweep = cylinder.sweep(cylinder.length(Swing().at(t)))
    Q, joints = newton_euler(cylinder, sweep)
    return sweep, np.column_stack((Q, joints["O2"], joints["A"], joints["O4"], joints["P"][:, 0]))


@pytest.fixture(scope="module")
def expected(period):
    return forces(Cylinder(), period[:, 0])


def test_force_and_reactions_over_a_period_agree_within_1e_4_of_their_ranges(period, expected):
    sweep, all_forces = expected
    np.testing.assert_allclose(period[:, 0], np.arange(201) / 200, atol=1e-15)
    for Q in (virtual_power(Cylinder(), sweep), all_forces[:, 0]):
        assert errors(period[:, 1], Q, np.ptp(Q)) < 5e-6
    assert (errors(period[:, 1:], all_forces, np.ptp(all_forces, axis=0)) < 2e-5).all()


def test_the_engine_has_the_verified_forces_of_source_c_and_not_the_printed_ones(period):
    """At 0, 0.01, 0.25 and 0.75 s; the source prints 43.14926, 42.284, 29.371299 and 56.648."""
    at = period[[0, 2, 50, 150], 1]
    np.testing.assert_allclose(at, [43.14926, 42.672362, 35.455131495, 50.845686583], atol=1e-4)
    assert (np.abs(at - [43.14926, 42.284, 29.371299, 56.648])[1:] > 0.3).all()


@pytest.mark.parametrize("body", range(3))
def test_a_gram_more_on_a_body_would_be_seen(period, expected, body):
    masses = list(Cylinder.masses)
    masses[body] = replace(masses[body], mass=masses[body].mass + 1e-3)
    _, other = forces(Cylinder(masses=tuple(masses)), period[:, 0])
    assert (errors(period[:, 1:], other, np.ptp(expected[1], axis=0)) > 4e-5).any()


def test_the_cylinder_run_again_gives_the_stored_tables(cylinder_again, period, expected):
    span = np.ptp(expected[1], axis=0)
    assert (errors(table(cylinder_again[0], "cylinder.csv")[:, 1:], period[:, 1:], span) < CYLINDER_ROUND_OFF).all()


def test_all_errors_of_the_cylinder_fall_with_the_square_of_the_step(cylinder_again):
    stored, new = (table(folder, "cylinder_steps.csv") for folder in (ENGINE, cylinder_again[0]))
    assert (np.abs(new - stored)[:, 1:] < CYLINDER_ROUND_OFF).all()
    for steps in (stored, new):
        np.testing.assert_allclose(steps[:, 0], 0.005 / np.array([1, 2, 4, 8]), rtol=1e-12)
        np.testing.assert_allclose(np.log2(steps[:-1, 1:] / steps[1:, 1:]), 2, atol=0.1)


def test_the_limit_of_small_steps_is_mechlib_for_the_cylinder_too(period, expected):
    """Richardson extrapolation, as for the hacksaw; what is left is round-off."""
    engine, exact = script("cylinder"), expected[1]
    limit = (4 * period[:, 1:] - engine.simulate(engine.STEPS // 2)) / 3
    assert (errors(limit, exact, np.ptp(exact, axis=0)) < CYLINDER_ROUND_OFF).all()
