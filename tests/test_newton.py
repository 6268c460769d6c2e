"""Claims about Newton-Raphson that a reader could dispute, each settled by one test."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy import cos, sin
from scipy.optimize import brentq

from mechlib.basins import basins
from mechlib.bracket import brackets
from mechlib.jacobian import finite_difference_jacobian, wrong_entries
from mechlib.newton import ConvergenceError, newton, newton_1d, order

R1Y, R2, R3 = 0.045, 0.075, 0.170  # m, source A section 5.2


def hacksaw(q):
    """Source A, eqs. (7)-(9), at rest: theta2 = 0."""
    r1, th1, th3 = q
    return np.array([-r1 * cos(th1) + R2 + R3 * cos(th3), r1 * sin(th1) - R3 * sin(th3), r1 * sin(th1) - R1Y])


def hacksaw_jacobian(q):
    r1, th1, th3 = q
    return np.array(
        [
            [-cos(th1), r1 * sin(th1), -R3 * sin(th3)],
            [sin(th1), r1 * cos(th1), -R3 * cos(th3)],
            [sin(th1), r1 * cos(th1), 0],
        ]
    )


def two_parabolas(q):
    x, y = q[..., 0], q[..., 1]
    return np.stack((x**2 + y - 2, x + y**2 - 2 + 0.1 * (x - 1)), axis=-1)


def two_parabolas_jacobian(q):
    x, y = q[..., 0], q[..., 1]
    one = np.ones_like(x)
    return np.stack((np.stack((2 * x, one), axis=-1), np.stack((1.1 * one, 2 * y), axis=-1)), axis=-2)


def test_source_a_position_takes_four_iterations():
    found = newton(hacksaw, hacksaw_jacobian, seed=[-0.1, -0.5, 3.0], tol=1e-6)
    assert found.iterations == 4
    np.testing.assert_allclose(found.root, [-0.099672, -0.468422, 2.873694], atol=5e-7)  # as printed: six digits


def test_the_order_is_two_with_the_jacobian_and_one_with_its_transpose():
    right = newton(two_parabolas, two_parabolas_jacobian, seed=[1.2, 1.1])
    transposed = newton(two_parabolas, lambda q: two_parabolas_jacobian(q).T, seed=[1.2, 1.1])
    assert right.order() == pytest.approx(2, abs=0.2)  # coarse: three steps are all there are
    assert transposed.order() == pytest.approx(1, abs=0.1)
    np.testing.assert_allclose(transposed.root, [1, 1], atol=1e-9)  # the same root: only the order tells


def test_a_double_root_is_of_order_one():
    assert newton_1d(lambda x: (x - 1) ** 2, lambda x: 2 * (x - 1), seed=3.0).order() == pytest.approx(1, abs=1e-6)


@given(st.floats(0.5, 50), st.floats(1e-3, 1e3))
def test_the_root_of_an_increasing_convex_function_is_brents(level, scale):
    f, df = lambda x: np.expm1(x / scale) - level, lambda x: np.exp(x / scale) / scale
    found = newton_1d(f, df, seed=4 * scale, tol=1e-12 * scale)
    assert found.root == pytest.approx(brentq(f, 0, 5 * scale, xtol=1e-14 * scale), rel=1e-10)


@given(st.floats(0.1, 0.5), st.integers(0, 2**32 - 1))
def test_in_one_unknown_both_solvers_take_the_same_steps(bend, seed):
    start = float(np.random.default_rng(seed).uniform(-2, 2))
    f, df = lambda x: x + bend * sin(x) - 1, lambda x: 1 + bend * cos(x)
    one = newton_1d(f, df, start)
    many = newton(lambda x: f(x), lambda x: np.diag(df(x)), [start])
    np.testing.assert_allclose(many.history[:, 0], one.history, rtol=1e-12, atol=1e-14)


def test_the_relative_error_does_not_depend_on_the_unit_of_x():
    metres = newton_1d(lambda x: x**3 - 2, lambda x: 3 * x**2, 2.0, tol=1e-4, error="relative")
    millimetres = newton_1d(
        lambda x: (x / 1e3) ** 3 - 2, lambda x: 3e-3 * (x / 1e3) ** 2, 2e3, tol=1e-4, error="relative"
    )
    absolute = newton_1d(lambda x: (x / 1e3) ** 3 - 2, lambda x: 3e-3 * (x / 1e3) ** 2, 2e3, tol=1e-4)
    assert millimetres.iterations == metres.iterations < absolute.iterations


def test_the_order_is_nan_with_fewer_than_three_steps_above_round_off():
    assert np.isnan(order([1.0, 1.1, 1.11]))
    assert np.isnan(order([1.0, 1.1, 1.11, 1.11, 1.11]))


def test_each_iteration_evaluates_the_function_and_its_derivative_once():
    calls = {"f": 0, "df": 0}

    def counted(name, function):
        def call(x):
            calls[name] += 1
            return function(x)

        return call

    found = newton_1d(counted("f", lambda x: x**2 - 2), counted("df", lambda x: 2 * x), 1.0)
    assert calls == {"f": found.evaluations, "df": found.evaluations}


@pytest.mark.parametrize(
    ("f", "df", "seed", "says"),
    [
        (lambda x: x**2 + 1, lambda x: 2 * x, 0.0, "zero derivative in iteration 1, at x = 0$"),
        (lambda x: x**3 - 2 * x + 2, lambda x: 3 * x**2 - 2, 0.0, "no root after 50 iterations.* at x = "),
        (lambda x: np.cbrt(x), lambda x: np.cbrt(x) ** -2 / 3, 1.0, "no root after 50 iterations"),
        (lambda x: np.log(x), lambda x: 1 / x, 5.0, "iteration 2 left the domain, from x = -3"),
    ],
    ids=["stationary seed", "two-cycle", "cusp", "leaves the domain"],
)
def test_a_failure_in_one_variable_says_where_and_why(f, df, seed, says):
    with pytest.raises(ConvergenceError, match=says) as failure:
        newton_1d(f, df, seed)
    assert not failure.value.path.converged
    assert failure.value.path.history[0] == seed


@pytest.mark.parametrize(
    ("f", "df", "seed", "says"),
    [
        (lambda x: x**2 + 1, lambda x: np.diag(2 * x), [0.0], "singular Jacobian in iteration 1, at x = "),
        (lambda x: np.cbrt(x), lambda x: np.diag(np.cbrt(x) ** -2 / 3), [1.0], "no root after 50 iterations"),
        (lambda x: np.log(x), lambda x: np.diag(1 / x), [5.0], "left the domain"),
    ],
    ids=["stationary seed", "cusp", "leaves the domain"],
)
def test_a_failure_in_many_variables_says_where_and_why(f, df, seed, says):
    with pytest.raises(ConvergenceError, match=says):
        newton(f, df, seed)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"tol": 0.0}, "tol must be positive, got 0.0"),
        ({"tol": np.nan}, "tol must be positive, got nan"),
        ({"seed": np.inf}, "seed must be finite, got inf"),
        ({"seed": [1.0, 2.0]}, "seed must be one number"),
        ({"error": "relativ"}, "error must be 'absolute' or 'relative', got 'relativ'"),
        ({"max_iterations": 0}, "max_iterations must be positive, got 0"),
    ],
    ids=lambda value: str(value) if isinstance(value, dict) else "",
)
def test_bad_input_is_refused_with_the_value_that_is_wrong(change, says):
    with pytest.raises(ValueError, match=says):
        newton_1d(lambda x: x - 1, lambda x: 1.0, **{"seed": 0.0, **change})


def test_a_jacobian_that_is_not_square_is_no_failure_of_convergence():
    with pytest.raises(ValueError, match="does not fit 2 unknowns"):
        newton(lambda x: x, lambda x: np.ones((3, 2)), [0.0, 0.0])


def test_differences_agree_with_the_exact_jacobian_to_nine_digits():
    q = np.array([-0.2, -0.4, 2.5])
    # central differences: eps^(2/3), some 4e-11, times a third derivative of the order of one
    np.testing.assert_allclose(finite_difference_jacobian(hacksaw, q), hacksaw_jacobian(q), atol=1e-9)


@given(st.sets(st.tuples(st.integers(0, 2), st.integers(0, 2)), max_size=9), st.integers(0, 2**32 - 1))
def test_planted_mistakes_in_a_jacobian_are_named_and_no_others(planted, seed):
    rng = np.random.default_rng(seed)
    a, units = rng.uniform(0.5, 2, (3, 3)), 10 ** rng.uniform(-6, 6, (3, 1))
    x = rng.uniform(0.3, 1.2, 3)  # cos stays away from zero, so that each entry counts

    def jacobian(x):
        matrix = units * a * cos(x)
        for place in planted:
            matrix[place] *= -1
        return matrix

    assert wrong_entries(lambda x: (units * a * sin(x)).sum(axis=1), jacobian, x) == sorted(planted)


@given(st.lists(st.integers(0, 39), unique=True, max_size=6))
def test_bolzano_finds_the_subinterval_of_every_simple_zero(cells):
    zeros = [0.25 * (cell + 0.4) for cell in cells]
    found = brackets(lambda x: np.prod([x - zero for zero in zeros]), 0, 10, 40)
    np.testing.assert_allclose(found[:, 0], [0.25 * cell for cell in sorted(cells)], atol=1e-12)


def test_a_zero_on_a_grid_point_is_found_once():
    assert brackets(lambda x: x, -1, 1, 2).tolist() == [[-1, 0]]
    assert brackets(lambda x: x, 0, 1, 2).tolist() == [[0, 0.5]]


@pytest.mark.parametrize(("a", "b", "n", "says"), [(1, 0, 5, "a = 1, b = 0"), (0, 0, 5, "a < b"), (0, 1, 0, "got 0")])
def test_an_interval_that_is_none_is_refused(a, b, n, says):
    with pytest.raises(ValueError, match=says):
        brackets(np.cos, a, b, n)


def test_the_basin_map_agrees_with_the_solver_point_by_point():
    roots = [newton(two_parabolas, two_parabolas_jacobian, seed).root for seed in ([1.2, 1.1], [-2, -2])]
    xs, ys = np.linspace(-4, 4, 9), np.linspace(-3, 5, 7)
    found = basins(two_parabolas, two_parabolas_jacobian, xs, ys, roots, tol=1e-3)
    for j, i in np.ndindex(found.shape):
        try:
            end = newton(two_parabolas, two_parabolas_jacobian, [xs[i], ys[j]]).root
        except ConvergenceError:
            end = [np.nan, np.nan]
        near = [k for k, root in enumerate(roots) if np.linalg.norm(end - root) < 1e-3]
        assert found[j, i] == (near[0] if near else -1)
    assert set(np.unique(found)) == {-1, 0, 1}
