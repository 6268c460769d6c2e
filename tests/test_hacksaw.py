"""The power hacksaw of source A: its closed form, its branches, and what it says where it cannot close."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mechlib.closure import OpenLoopError
from mechlib.hacksaw import Hacksaw
from mechlib.newton import ConvergenceError, newton

TURN = np.linspace(0, 2 * np.pi, 1000)
BRANCHES = pytest.mark.parametrize("branch", ["left", "right"])
lengths = st.floats(0.01, 1.0)


def spectral_derivative(periodic):
    """d/dtheta of the values at equal steps of a turn: exact to round-off for a smooth periodic function."""
    modes = np.fft.rfftfreq(len(periodic), 1 / len(periodic))
    return np.fft.irfft(1j * modes[:, None] * np.fft.rfft(periodic, axis=0), len(periodic), axis=0)


def test_source_a_position_at_rest_to_the_printed_digits():
    r1, theta1, theta3 = Hacksaw().position(0.0)
    assert (f"{r1:.6f}", f"{theta1:.6f}", f"{theta3:.6f}") == ("-0.099672", "-0.468422", "2.873694")
    assert [r1, theta1, theta3] == pytest.approx([-0.09967249135979, -0.46842178054592, 2.87369374118380], abs=5e-15)


@BRANCHES
@given(lengths, lengths, lengths, st.floats(-10, 10))
def test_the_closed_form_closes_the_loop_with_rigid_bars_and_the_slider_on_its_guide(branch, r1y, r2, r3, theta2):
    saw = Hacksaw(r1y, r2, r3)
    assume(saw.gap(theta2) <= 0)
    q = saw.position(theta2, branch)
    size = r1y + r2 + r3
    assert np.abs(saw.loop.residual(q, theta2)).max() < 1e-15 * size
    O, A, B = saw.points(theta2, q)
    assert O.tolist() == [0, 0]
    assert np.linalg.norm(A) == pytest.approx(r2, abs=1e-15 * size)
    assert np.linalg.norm(B - A) == pytest.approx(r3, abs=2e-15 * size)
    assert B[1] == pytest.approx(r1y, abs=1e-15 * size)


@given(lengths, lengths, lengths, st.floats(-10, 10))
def test_the_branches_are_mirror_images_in_the_upright_through_the_crank_pin(r1y, r2, r3, theta2):
    saw = Hacksaw(r1y, r2, r3)
    assume(saw.gap(theta2) < 0)
    (_, A, left), (_, _, right) = (saw.points(theta2, saw.position(theta2, side)) for side in ("left", "right"))
    assert left[0] <= A[0] <= right[0]
    assert left[0] + right[0] == pytest.approx(2 * A[0], abs=1e-14)
    assert saw.branch(saw.position(theta2, "left")) == "left"
    assert saw.branch(saw.position(theta2, "right")) == "right"


@BRANCHES
@pytest.mark.parametrize("r3", [0.170, 0.125], ids=["the saw of source A", "a slider that passes under the shaft"])
def test_the_position_is_continuous_over_a_turn_and_comes_back(branch, r3):
    q = Hacksaw(r3=r3).position(TURN, branch)
    assert np.abs(np.diff(q, axis=0)).max() < 0.05
    np.testing.assert_allclose(q[-1], q[0], atol=1e-14)


@BRANCHES
def test_velocity_and_acceleration_are_the_derivatives_of_the_position(branch):
    saw, theta2 = Hacksaw(), np.linspace(0, 2 * np.pi, 512, endpoint=False)
    q = saw.position(theta2, branch)
    slope, bend = spectral_derivative(q), spectral_derivative(spectral_derivative(q))
    omega2, alpha2 = 3.0, -7.0
    v = saw.loop.velocity(q, theta2, omega2)
    a = saw.loop.acceleration(q, v, theta2, omega2, alpha2)
    np.testing.assert_allclose(v, slope * omega2, atol=1e-11)
    np.testing.assert_allclose(a, bend * omega2**2 + slope * alpha2, atol=1e-9)  # 256 modes, squared, times 1e-15


def test_the_machine_never_reaches_its_singular_position():
    assert np.abs(np.cos(Hacksaw().position(TURN)[:, 2])).min() > 0.7


def test_a_loop_that_cannot_close_gives_no_number_but_the_angles_and_the_gap():
    saw = Hacksaw(r3=0.10)
    with pytest.raises(OpenLoopError, match=r"cannot close at theta_2 = 3\.9783: 0\.000683 m") as raised:
        saw.position(np.linspace(0, 2 * np.pi, 200))
    theta2 = np.linspace(0, 2 * np.pi, 200)[raised.value.points]
    needed = 0.045 - 0.075 * np.sin(theta2)
    np.testing.assert_allclose(raised.value.gaps, needed - 0.10, atol=1e-16)
    assert (raised.value.gaps > 0).all()


@given(st.floats(0.02, 0.11), st.floats(0, 2 * np.pi), st.floats(-3, 3))
def test_newton_finds_no_root_of_a_loop_that_cannot_close(r3, theta2, seed):
    saw = Hacksaw(r3=r3)
    assume(saw.gap(theta2) > 1e-6)
    with pytest.raises(ConvergenceError):
        newton(lambda q: saw.loop.residual(q, theta2), lambda q: saw.loop.jacobian(q, theta2), [-0.1, -0.5, seed])


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Hacksaw(r2=-0.1), "r2 must be a positive number, got -0.1"),
        (lambda: Hacksaw(r1y=0.0), "r1y must be a positive number, got 0.0"),
        (lambda: Hacksaw(r3=np.nan), "r3 must be a positive number, got nan"),
        (lambda: Hacksaw(r3=np.ones(2)), "r3 must be a positive number"),
        (lambda: Hacksaw().position(0.0, "up"), "branch must be 'left' or 'right', got 'up'"),
        (lambda: Hacksaw().position([[0.0, np.nan]]), "theta2 must be finite, got nan at index 0, 1"),
        (lambda: Hacksaw().position(np.inf), "theta2 must be finite, got inf$"),
    ],
)
def test_a_saw_that_cannot_be_is_refused_with_the_value(make, says):
    with pytest.raises(ValueError, match=says):
        make()
