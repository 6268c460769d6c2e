"""What is derived from a loop closure, against SymPy's own time derivative of functions of time."""

import numpy as np
import pytest
import sympy as sp

from mechlib.closure import Closure, Coordinate, OpenLoopError
from mechlib.fourbar import FourBar
from mechlib.hacksaw import Hacksaw


def fourbar():
    """Source B's wiper: another mechanism, with two unknowns."""
    crank, coupler, rocker = (Coordinate.named(f"theta_{k} omega_{k} alpha_{k}") for k in (1, 2, 3))
    r0, r1, r2, r3 = sp.symbols("r_0:4", positive=True)
    th1, th2, th3 = (c.position for c in (crank, coupler, rocker))
    return Closure(
        equations=(
            r0 - r1 * sp.cos(th1) - r2 * sp.cos(th2) + r3 * sp.cos(th3),
            r1 * sp.sin(th1) + r2 * sp.sin(th2) - r3 * sp.sin(th3),
        ),
        unknowns=(coupler, rocker),
        input=crank,
        parameters=(r0, r1, r2, r3),
    )


CLOSURES = pytest.mark.parametrize("closure", [Hacksaw.closure, fourbar()], ids=["hacksaw", "four-bar"])


@CLOSURES
def test_velocity_and_acceleration_equations_are_the_time_derivatives(closure):
    t = sp.Symbol("t")
    names, moving = {}, {}
    for k, c in enumerate((*closure.unknowns, closure.input)):
        f = sp.Function(f"f{k}")(t)
        moving[c.position] = f
        names |= {f.diff(t, 2): c.acceleration, f.diff(t): c.velocity, f: c.position}
    once = closure.position_equations.subs(moving).diff(t)
    for derived, expected in ((closure.velocity_equations, once), (closure.acceleration_equations, once.diff(t))):
        for symbol in (2, 1, 0):  # the highest derivative first: it contains the others
            expected = expected.subs({old: new for old, new in names.items() if _order(old) == symbol})
        assert sp.simplify(derived - expected) == sp.zeros(*derived.shape)


def _order(expression):
    return expression.derivative_count if isinstance(expression, sp.Derivative) else 0


@CLOSURES
def test_one_jacobian_serves_position_velocity_and_acceleration(closure):
    _, velocities, accelerations = zip(*closure.unknowns, strict=True)
    for equations, unknowns in (
        (closure.velocity_equations, velocities),
        (closure.acceleration_equations, accelerations),
    ):
        assert sp.simplify(equations.jacobian(unknowns) - closure.jacobian) == sp.zeros(*closure.jacobian.shape)


def test_many_points_give_the_bits_of_one_point_at_a_time_whatever_their_shape():
    loop, rng = Hacksaw().loop, np.random.default_rng(1)
    q, v = rng.uniform(0.1, 1, (2, 4, 5, 3))
    u, du, ddu = rng.uniform(0.1, 1, (3, 4, 5))
    for call, args in (
        (loop.residual, (q, u)),
        (loop.jacobian, (q, u)),
        (loop.velocity, (q, u, du)),
        (loop.acceleration, (q, v, u, du, ddu)),
    ):
        together = call(*args)
        for index in np.ndindex(4, 5):
            np.testing.assert_allclose(together[index], call(*(a[index] for a in args)), rtol=1e-13, atol=1e-15)


def test_one_position_may_meet_many_inputs():
    loop = Hacksaw().loop
    q, u = Hacksaw().position(0.3), np.linspace(0, 1, 7)
    assert loop.residual(q, u).shape == (7, 3)
    assert loop.jacobian(q, u).shape == (7, 3, 3)  # it does not depend on the input, and is there at each all the same


def test_the_compiled_jacobian_is_the_slope_of_the_compiled_residual():
    loop, rng = Hacksaw().loop, np.random.default_rng(2)
    for _ in range(20):
        q, u, h = rng.uniform(-1, 1, 3), rng.uniform(0, 6), 1e-6
        slope = [(loop.residual(q + d, u) - loop.residual(q - d, u)) / (2 * h) for d in h * np.eye(3)]
        np.testing.assert_allclose(loop.jacobian(q, u), np.transpose(slope), atol=1e-9)  # h^2/6, and 1e-16/h


def test_in_a_singular_position_no_velocity_is_told():
    saw = Hacksaw(r1y=0.045, r2=0.075, r3=0.120)  # the coupler stands upright as the crank points straight down
    theta2 = np.array([0.0, -np.pi / 2])
    upright = [-0.045, np.arctan2(-0.045, 0), np.pi / 2]
    q = np.array([saw.position(0.0), upright])
    assert np.abs(saw.loop.residual(q, theta2)).max() < 1e-16
    with pytest.raises(ZeroDivisionError, match=r"singular position at point 1, theta_2 = -1\.5708"):
        saw.loop.velocity(q, theta2, np.ones(2))
    with pytest.raises(ZeroDivisionError, match="singular position at point 0"):
        saw.loop.acceleration(q[1], np.zeros(3), theta2[1], 1.0, 0.0)


def test_a_closure_wants_a_number_for_each_parameter():
    with pytest.raises(ValueError, match=r"has the parameters \(r_1y, r_2, r_3\), got 2 numbers"):
        Hacksaw.closure.loop(0.1, 0.2)


def test_an_open_loop_says_at_which_input_and_by_how_much():
    error = OpenLoopError("theta_2", [0.0, 1.0, 2.0], [-0.01, 0.002, 0.001])
    assert str(error) == "the loop cannot close at theta_2 = 1: 0.002 m are missing (and at 1 other point)"
    assert error.points.tolist() == [1, 2]
    assert error.gaps.tolist() == [0.002, 0.001]


@pytest.mark.parametrize("branch", ["open", "crossed"])
def test_in_a_flat_position_no_velocity_is_given_though_rounding_leaves_the_jacobian_just_regular(branch):
    stretched = FourBar(1.0, 0.5, 0.25, 0.25)
    with pytest.raises(ZeroDivisionError, match="no velocity is determined"):
        stretched.loop.velocity(stretched.position(0.0, branch), 0.0, 1.0)
