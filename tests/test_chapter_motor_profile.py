"""Claims of the chapter on the run-up of a motor, proven without the code that it calls."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

THIRDS, TRIANGLE = 1 / 3, 1 / 2


def run_up(share, T, peak):
    """Speed and angle at T when each ramp takes this share, by a Runge-Kutta method that stops at each corner."""

    def acceleration(t):
        return peak * min(1.0, t / (share * T), (T - t) / (share * T))

    state, corners = np.zeros(2), T * np.array([0, share, 1 - share, 1])
    for start, end in pairwise(corners):
        if end > start:
            step = solve_ivp(lambda t, y: (acceleration(t), y[0]), (start, end), state, rtol=1e-10, atol=1e-12)
            state = step.y[:, -1]
    return state


@given(share=st.floats(0.05, 0.5), T=st.floats(0.5, 5), peak=st.floats(1, 10))
def test_a_trapezoid_s_mean_speed_is_half_of_its_last(share, T, peak):
    speed, angle = run_up(share, T, peak)
    assert speed == pytest.approx((1 - share) * peak * T, rel=1e-8)
    assert angle == pytest.approx(speed * T / 2, rel=1e-8)


def test_in_thirds_one_turn_takes_1_942_s_and_ends_at_61_8_rpm():
    speed, angle = run_up(THIRDS, 1.9416259125556992, 5.0)
    assert angle == pytest.approx(2 * np.pi, rel=1e-8)
    assert f"{speed * 30 / np.pi:.1f}" == "61.8"


def test_a14_the_triangle_has_42_percent_less_jerk_than_the_thirds_and_takes_15_percent_more_time():
    """The same peak and the same angle: T^2 (1 - r) stays, and the jerk is peak/(r T)."""
    time_squared = Fraction(2, 3) / Fraction(1, 2)
    assert f"{100 * (float(time_squared) ** 0.5 - 1):.0f}" == "15"
    jerk_squared = (Fraction(1, 3) / Fraction(1, 2)) ** 2 / time_squared
    assert f"{100 * (1 - float(jerk_squared) ** 0.5):.0f}" == "42"


def test_among_trapezoids_of_one_peak_and_angle_the_jerk_falls_and_the_time_grows_with_the_ramp():
    r = sp.Symbol("r", positive=True)
    time_squared, jerk_squared = 1 / (1 - r), (1 - r) / r**2
    for share in np.linspace(0.01, 0.5, 50):
        assert time_squared.diff(r).subs(r, share) > 0
        assert jerk_squared.diff(r).subs(r, share) < 0


def test_select_takes_the_first_condition_that_is_true_and_piecewise_the_last():
    x = np.array([0.0, 1.0, 2.0])
    conditions = [x < 1, x <= 1]
    assert np.select(conditions, [10.0, 20.0]).tolist() == [10, 20, 0]
    assert np.piecewise(x, conditions, [10.0, 20.0]).tolist() == [20, 20, 0]


def test_sympy_s_piecewise_takes_the_first_and_is_not_a_number_where_none_is_true():
    x = sp.Symbol("x")
    function = sp.Piecewise((10, x < 1), (20, x <= 1))
    assert [function.subs(x, value) for value in (0, 1)] == [10, 20]
    assert function.subs(x, 2) is sp.nan


def test_sympy_joins_the_pieces_in_integrate_and_leaves_them_in_piecewise_integrate():
    x = sp.Symbol("x", positive=True)
    step = sp.Piecewise((2, x < 1), (3, True))

    def jump(f):
        return sp.limit(f.args[1][0] - f.args[0][0], x, 1)

    assert jump(sp.integrate(step, x)) == 0
    assert jump(step.piecewise_integrate(x)) == 1


@pytest.mark.parametrize("k", range(4))
@pytest.mark.parametrize("name", ["omega", "theta"])
@pytest.mark.parametrize("kind", ["slope", "constant"])
def test_one_error_in_one_piece_is_named_if_omega_is_looked_at_first(name, k, kind):
    """Slopes first, then the first jump; in symbols, with the pieces of alpha integrated by SymPy's own hand."""
    t = sp.Symbol("t", positive=True)
    corners = [sp.Integer(n) for n in range(4)]
    alpha = sp.Piecewise((t, t < 1), (1, t < 2), (3 - t, t < 3), (0, True))
    curves = {"alpha": alpha, "omega": sp.integrate(alpha, t)}
    curves["theta"] = sp.integrate(curves["omega"], t)
    pieces = {key: [piece for piece, _ in curve.args] for key, curve in curves.items()}
    pieces[name][k] += sp.Rational(1, 7) * ((t - corners[k]) if kind == "slope" else 1)

    def find():
        for function, derivative in (("omega", "alpha"), ("theta", "omega")):
            f, df = pieces[function], pieces[derivative]
            wrong = [i for i in range(4) if sp.expand(f[i].diff(t) - df[i]) != 0]
            before = [sp.Integer(0), *f[:3]]
            wrong += [i for i in range(4) if (f[i] - before[i]).subs(t, corners[i]) != 0]
            if wrong:
                return function, wrong[0]

    assert find() == (name, k)
