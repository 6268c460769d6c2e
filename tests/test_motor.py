"""The wiper starts from rest: which motor turns it, where a weak one stalls, and how evenly it then runs."""

import numpy as np
import pytest
from linkages import TURN

from mechlib import dynamics
from mechlib.batched import batched
from mechlib.closure import OpenLoopError
from mechlib.direct import Run, rubbing, simulate
from mechlib.motion import Motion
from mechlib.motor import Motor, StallError, Turns, run_up, turning_torque
from mechlib.wiper import Wiper

SPEED = 35 * 2 * np.pi / 60
FRICTION = 4.5


@pytest.fixture(scope="module")
def wiper():
    return Wiper()


@pytest.fixture(scope="module")
def to_turn_on(wiper):
    """At every angle, from the fifteen equations at standstill: no inertia, but weight and friction against the way."""
    creeping = Motion(TURN, TURN, np.full_like(TURN, 1e-6), np.zeros_like(TURN))
    sweep = batched(wiper, creeping, np.deg2rad([55, 125]), 1e-12)
    velocities = (dynamics.trace(wiper, sweep, point).velocity for point in ("G3", "G4"))
    loads = np.stack([dynamics.friction(v, FRICTION) for v in velocities], axis=1)
    return dynamics.inverse_dynamics(wiper, sweep, loads).torque


def test_a_motor_has_its_torque_in_a_straight_line_from_standstill_to_no_load():
    motor = Motor.through(speed=SPEED, torque=1.3, stall_torque=30.0)
    assert motor(0.0, 0.0, 0.0) == 30.0
    assert motor(0.0, 0.0, motor.no_load_speed) == 0.0
    assert motor(0.0, 0.0, SPEED) == pytest.approx(1.3, rel=1e-13)
    np.testing.assert_allclose(np.diff(motor(0.0, 0.0, np.arange(4.0)), 2), 0, atol=1e-14)


def test_the_wiper_runs_up_to_35_rpm_and_then_every_turn_is_like_the_last(wiper, to_turn_on):
    mean = np.trapezoid(to_turn_on, TURN) / (2 * np.pi)
    motor = Motor.through(speed=SPEED, torque=mean, stall_torque=30.0)
    run = run_up(wiper, motor, np.linspace(0, 5.2, 1041), FRICTION, rtol=1e-7)
    turns = Turns.of(run)
    assert turns.speed[-1] == pytest.approx(SPEED, rel=5e-3)  # the mean of the torque is not at the mean speed
    np.testing.assert_allclose(turns.speed[1:], turns.speed[-1], rtol=1e-5)
    np.testing.assert_allclose(turns.ripple[1:], turns.ripple[-1], rtol=1e-3)
    assert np.abs(run.drift).max() < 1e-6 * np.abs(run.energy).max()


def test_a_torque_above_the_largest_that_turns_it_on_does_and_one_below_stalls_where_more_is_needed(wiper, to_turn_on):
    t = np.linspace(0, 1.2, 13)
    largest = to_turn_on.max()
    assert run_up(wiper, lambda *_: 1.05 * largest, t, FRICTION, rtol=1e-6).position[-1, 0] > 2 * np.pi
    weak = 0.5 * to_turn_on[0]
    with pytest.raises(StallError) as stalled:
        run_up(wiper, lambda *_: weak, t, FRICTION, rtol=1e-6)
    said = str(stalled.value)
    assert said.startswith("the motor stalls at theta_1 = ")
    assert said.endswith(f"N m, and it gives {weak:.6g} N m")
    theta, takes = (float(said.split(mark)[1].split()[0].rstrip(":")) for mark in ("theta_1 = ", "takes "))
    assert takes > weak
    assert takes == pytest.approx(np.interp(theta, TURN, to_turn_on), rel=1e-3)


def test_a_weight_that_turns_the_crank_back_is_a_stall(wiper):
    with pytest.raises(StallError, match="to turn on from there takes"):
        run_up(wiper, lambda *_: 0.2, np.linspace(0, 3, 31), theta=0.5, rtol=1e-6)


def test_the_torque_that_turns_it_on_is_that_of_the_fifteen_equations(wiper, to_turn_on):
    for k in range(0, 361, 45):
        position = np.array([TURN[k], *wiper.position(TURN[k])])
        assert turning_torque(wiper, position, FRICTION) == pytest.approx(to_turn_on[k], abs=1e-9)


def test_friction_that_fades_holds_but_for_a_creep_as_small_as_its_width(wiper):
    """Held by friction, the blades still move, at atanh(needed/there is) v0: half the width, half the speed."""
    torque, speeds = 0.9, []
    for v0 in (0.01, 0.005):
        run = simulate(wiper, lambda *_: torque, (0.0, 0.0), [0, 0.5], rubbing(wiper, FRICTION, v0), rtol=1e-8)
        speeds.append(run.velocity[-1, 0])
    assert 0 < speeds[0] < 0.05
    assert speeds[1] == pytest.approx(speeds[0] / 2, rel=0.05)


def test_turns_are_found_between_the_instants_that_were_looked_at():
    """theta = w t + e sin(w t): the speed ripples by 2 e about w."""
    w, e = 3.0, 0.1
    t = np.linspace(0, 10, 1001)
    theta, omega = w * t + e * np.sin(w * t), w * (1 + e * np.cos(w * t))
    run = Run(t, theta[:, None], omega[:, None], *np.zeros((3, len(t))))
    turns = Turns.of(run)
    assert len(turns.begin) == 4
    np.testing.assert_allclose(turns.begin, 2 * np.pi / w * np.arange(4), atol=1e-8)
    np.testing.assert_allclose(turns.speed, w, rtol=1e-8)
    np.testing.assert_allclose(turns.ripple, 2 * e, rtol=1e-3)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda w: Motor(0.0, 4.0), "stall_torque must be a positive number, got 0.0"),
        (lambda w: Motor(30.0, -4.0), "no_load_speed must be a positive number, got -4.0"),
        (lambda w: Motor.through(4.0, 31.0, 30.0), "torque must be below the 30.0 N m of standstill, got 31.0"),
        (lambda w: run_up(w, Motor(30.0, 4.0), [0, 1], FRICTION, v0=0.0), "v0 must be a positive number, got 0.0"),
        (lambda w: run_up(w, Motor(30.0, 4.0), [0, 1], -1.0), "must not be negative, got -1.0"),
    ],
)
def test_a_motor_or_a_friction_that_cannot_be_is_refused_with_the_value(wiper, make, says):
    with pytest.raises(ValueError, match=says):
        make(wiper)


def test_no_motor_runs_a_linkage_up_that_is_no_crank_rocker():
    longer = Wiper(r1=0.130)
    assert longer.grashof == "triple-rocker"
    with pytest.raises(OpenLoopError, match=r"the loop cannot close at theta_1 = .*: .* m are missing \(and at"):
        run_up(longer, Motor(30.0, 4.0), [0, 1])


def test_a_motion_that_ends_in_a_dead_point_says_where():
    """Coupler and rocker are in line where the pin A is as far from C as both are long."""
    longer = Wiper(r1=0.130)
    dead = np.arccos((longer.r0**2 + longer.r1**2 - (longer.r2 + longer.r3) ** 2) / (2 * longer.r0 * longer.r1))
    with pytest.raises((ArithmeticError, OpenLoopError)) as refused:
        simulate(longer, lambda *_: 5.0, (0.0, 1.0), [0, 2], max_evaluations=5000)
    assert float(str(refused.value).split("theta_1 = ")[1].split()[0].rstrip(":")) == pytest.approx(dead, abs=1e-4)


def test_friction_that_leaps_at_rest_ends_in_words_and_not_in_waiting(wiper):
    with pytest.raises(ArithmeticError, match=r"gets no further than t = .* s, theta_1 = .* in 2000 evaluations"):
        simulate(wiper, lambda *_: 0.3, (0.0, 0.0), [0, 1], rubbing(wiper, FRICTION, 0.0), max_evaluations=2000)
