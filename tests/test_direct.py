"""Direct dynamics of the wiper: the inverse of inverse dynamics, and the energy as its witness."""

import numpy as np
import pytest

from mechlib import dynamics
from mechlib.batched import batched
from mechlib.direct import direct_dynamics, rubbing, simulate
from mechlib.motion import Motion
from mechlib.motor import Motor
from mechlib.wiper import Wiper

SEED = np.deg2rad([55, 125])
OMEGA = 35 * 2 * np.pi / 60
COASTING = {"torque": lambda *_: 0.0, "start": (0.0, OMEGA)}


@pytest.fixture(scope="module")
def wiper():
    return Wiper()


def relative_drift(run):
    return np.abs(run.drift).max() / run.energy[0]


@pytest.mark.parametrize("alpha", [0.0, 7.0], ids=["constant speed", "accelerated"])
def test_direct_dynamics_gives_back_the_motion_whose_torque_inverse_dynamics_found(wiper, alpha):
    theta1 = np.linspace(0, 2 * np.pi, 361)
    motion = Motion(theta1 / OMEGA, theta1, np.full_like(theta1, OMEGA), np.full_like(theta1, alpha))
    sweep = batched(wiper, motion, SEED, 1e-12)
    loads = np.stack([dynamics.friction(dynamics.trace(wiper, sweep, p).velocity, 4.5) for p in ("G3", "G4")], axis=1)
    inverse = dynamics.inverse_dynamics(wiper, sweep, loads)
    position = np.column_stack((theta1, sweep.position))
    velocity = np.column_stack((motion.velocity, sweep.velocity))
    direct = direct_dynamics(wiper, position, velocity, inverse.torque, loads)
    np.testing.assert_allclose(direct.accelerations[:, 0], alpha, atol=1e-10)
    np.testing.assert_allclose(direct.accelerations[:, 1:], sweep.acceleration, atol=1e-10)
    for joint, force in inverse.forces.items():
        np.testing.assert_allclose(direct.forces[joint], force, atol=1e-10)


def test_source_b_the_coasting_wiper_after_two_seconds_to_the_verified_digits(wiper):
    run = simulate(wiper, **COASTING, t=np.linspace(0, 2, 21))
    assert (f"{run.position[-1, 0]:.8f}", f"{run.velocity[-1, 0]:.8f}") == ("13.74361211", "3.76830092")
    assert relative_drift(run) < 1e-11
    assert run.opening.max() < 1e-15


def test_without_friction_and_torque_the_energy_stays_over_ten_seconds(wiper):
    assert relative_drift(simulate(wiper, **COASTING, t=np.linspace(0, 10, 21))) < 1e-10


def test_a_position_solved_to_1e_9_only_lets_the_energy_drift(wiper):
    run = simulate(wiper, **COASTING, t=np.linspace(0, 2, 21), position_tol=1e-9, rtol=1e-10)
    assert 1e-10 < relative_drift(run) < 1e-6


def test_all_coordinates_integrated_let_the_loop_open_and_two_cures_hold_it_closed(wiper):
    t = np.linspace(0, 2, 9)
    free, held, closed = (
        simulate(wiper, **COASTING, t=t, rtol=1e-7, **how)
        for how in ({"coordinates": "all"}, {"coordinates": "all", "stabilise": 30.0}, {})
    )
    assert free.opening[-1] > 20 * held.opening[-1] > 0
    assert closed.opening.max() < 1e-15
    assert relative_drift(held) < relative_drift(free)


def test_energy_and_work_agree_with_a_motor_and_friction(wiper):
    run = simulate(wiper, Motor(8.0, 8.0), (0.0, 0.0), np.linspace(0, 1, 6), rubbing(wiper, 4.5, 0.01), rtol=1e-9)
    assert run.velocity[-1, 0] > 1
    assert np.abs(run.drift).max() < 1e-7 * np.abs(run.energy).max()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"coordinates": "some"}, "coordinates must be 'input' or 'all', got 'some'"),
        ({"start": (np.nan, 1.0)}, "theta must be finite, got nan"),
        ({"torque": lambda *_: np.inf}, "torque must be finite, got inf"),
        ({"loads": lambda q, v: np.zeros((1, 2))}, r"loads must be \(1, 2, 2\)"),
    ],
)
def test_a_run_that_cannot_be_is_refused_with_the_value(wiper, change, says):
    with pytest.raises(ValueError, match=says):
        simulate(**{"machine": wiper, **COASTING, "t": np.linspace(0, 0.1, 3), **change})
