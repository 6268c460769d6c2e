"""The run-up of source A's motor, against quadrature and the printed figures."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from mechlib.motion import Motion, MotorProfile

times = st.floats(0.1, 10)
peaks = st.floats(0.1, 100)


def trapezium(t, T, peak):
    """The acceleration of source A, eq. (3), as one draws it."""
    return peak * min(1.0, 3 * t / T, max(0.0, 3 * (T - t) / T))


def test_source_a_first_turn_takes_t_to_fifteen_digits():
    exact = mpmath.sqrt(6 * mpmath.pi / 5)
    T = MotorProfile.through().T
    assert abs(T - exact) < 1e-15
    assert f"{T:.3f}" == "1.942"  # as printed


def test_source_a_speed_after_the_run_up_and_three_turns_after_twice_its_time():
    profile = MotorProfile.through()
    end = profile.at([profile.T, 2 * profile.T])
    assert end.velocity == pytest.approx([6.472086375185664] * 2, abs=2e-15)
    assert end.velocity[0] * 30 / np.pi == pytest.approx(61.804, abs=5e-4)
    assert end.position == pytest.approx([2 * np.pi, 6 * np.pi], rel=1e-15)


@given(times, peaks, st.floats(0, 3))
def test_angle_and_speed_are_the_integrals_of_the_acceleration(T, peak, share):
    t = share * T
    got = MotorProfile(T, peak).at([t])
    corners = [k * T / 3 for k in (1, 2, 3) if k * T / 3 < t]
    alpha = lambda s: trapezium(s, T, peak)
    speed = quad(alpha, 0, t, points=corners or None)[0]
    angle = quad(lambda s: (t - s) * alpha(s), 0, t, points=corners or None)[0]  # Cauchy: one integral for two
    assert got.acceleration[0] == pytest.approx(alpha(t), abs=1e-12 * peak)
    assert got.velocity[0] == pytest.approx(speed, abs=1e-12 * peak * T)
    assert got.position[0] == pytest.approx(angle, abs=1e-12 * peak * T**2)


@given(st.floats(0.1, 100), peaks)
def test_a_profile_through_an_angle_turns_through_it(angle, peak):
    profile = MotorProfile.through(angle, peak)
    assert profile.at([profile.T]).position[0] == pytest.approx(angle, rel=1e-14)


@given(times, peaks, st.floats(0, 1))
def test_the_speeds_at_mirrored_instants_add_up_to_that_at_the_end(T, peak, share):
    at = lambda t: MotorProfile(T, peak).at([t]).velocity[0]
    assert at(share * T) + at(T - share * T) == pytest.approx(at(T), rel=1e-13)


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: MotorProfile(0.0), "T must be a positive number, got 0.0"),
        (lambda: MotorProfile(-2.0), "T must be a positive number, got -2.0"),
        (lambda: MotorProfile(np.nan), "T must be a positive number, got nan"),
        (lambda: MotorProfile(1.0, peak=np.inf), "peak must be a positive number, got inf"),
        (lambda: MotorProfile.through(-1.0), "angle must be a positive number, got -1.0"),
        (lambda: MotorProfile(1.0).at([0.0, np.nan]), "t must be finite, got nan at index 1"),
        (lambda: MotorProfile(1.0).at([-0.5, 0.0]), "the motor starts at t = 0, got t = -0.5"),
        (lambda: MotorProfile(1.0).at([0.0, 2.0, 1.0]), "t must increase, got 2.0 before 1.0 at index 2"),
        (lambda: Motion([0, 1], [0, 1], [0, np.inf], [0, 0]), "velocity must be finite, got inf at index 1"),
        (lambda: Motion([0, 1], [0, 1, 2], [0, 0], [0, 0]), r"must be \(points,\) alike"),
        (lambda: Motion([[0, 1]], [[0, 1]], [[0, 0]], [[0, 0]]), r"must be \(points,\) alike"),
    ],
)
def test_a_motion_that_cannot_be_is_refused_with_the_value(make, says):
    with pytest.raises(ValueError, match=says):
        make()
