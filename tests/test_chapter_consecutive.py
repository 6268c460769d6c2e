"""Claims of the chapter on the consecutive solution, proven without the code that the chapter calls."""

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

R1Y, R2, R3 = 0.045, 0.075, 0.170  # m, source A
SEED = np.array([-0.1, -0.5, 3.0])
SKETCHED = np.array([-0.1, -0.5, 2.0])
T = np.sqrt(6 * np.pi / 5)


def crank(t):
    """theta2, omega2, alpha2 of the motor, from the polynomials of source A as they should be."""
    first, second, third = t < T / 3, t < 2 * T / 3, t < T
    pieces = [first, second & ~first, third & ~second]

    def choose(*values):
        return np.select(pieces, values[:3], values[3])

    return (
        choose(
            5 * t**3 / (2 * T),
            5 * t**2 / 2 - 5 * T * t / 6 + 5 * T**2 / 54,
            15 * t**2 / 2 - 25 * T * t / 6 - 5 * t**3 / (2 * T) + 5 * T**2 / 6,
            10 * T * t / 3 - 5 * T**2 / 3,
        ),
        choose(
            15 * t**2 / (2 * T),
            5 * t - 5 * T / 6,
            15 * t - 25 * T / 6 - 15 * t**2 / (2 * T),
            np.full_like(t, 10 * T / 3),
        ),
        choose(15 * t / T, np.full_like(t, 5), 15 - 15 * t / T, np.zeros_like(t)),
    )


TIMES = np.linspace(0, 2 * T, 1000)
THETA2, OMEGA2, ALPHA2 = crank(TIMES)


def residual(q, theta2):
    loop = R2 * np.exp(1j * theta2) + R3 * np.exp(1j * q[2]) - q[0] * np.exp(1j * q[1])
    return np.array([loop.real, -loop.imag, q[0] * np.sin(q[1]) - R1Y])


def jacobian(q):
    slide, coupler = np.exp(1j * q[1]), R3 * 1j * np.exp(1j * q[2])
    across = 1j * q[0] * slide
    return np.array(
        [
            [-slide.real, -across.real, coupler.real],
            [slide.imag, across.imag, -coupler.imag],
            [slide.imag, across.imag, 0],
        ]
    )


def iterate(theta2, seed, tol=1e-6):
    q, path = np.array(seed, dtype=float), []
    for _ in range(50):
        step = np.linalg.solve(jacobian(q), residual(q, theta2))
        q = q - step
        path.append(q)
        if np.linalg.norm(step) < tol:
            return path
    raise ArithmeticError("no root")


def closed_form():
    """The nine quantities as functions of theta2, omega2 and alpha2: x(theta2) differentiated by SymPy."""
    u, w, a = sp.symbols("u w a")
    theta3 = sp.pi - sp.asin((R1Y - R2 * sp.sin(u)) / R3)
    x = R2 * sp.cos(u) + R3 * sp.cos(theta3)
    q = sp.Matrix([-sp.sqrt(x**2 + R1Y**2), sp.atan(R1Y / x), theta3])
    return sp.lambdify((u, w, a), [*q, *(q.diff(u) * w), *(q.diff(u, 2) * w**2 + q.diff(u) * a)])


NINE = np.array(np.broadcast_arrays(*closed_form()(THETA2, OMEGA2, ALPHA2)))
BUILT = NINE[:3].T


@given(st.floats(-0.3, -0.05), st.floats(-1, 0), st.floats(1.8, 4.4), st.floats(0, 2 * np.pi))
def test_theta3_is_iterated_as_if_it_were_alone(r1, theta1, theta3, theta2):
    c = (R1Y - R2 * np.sin(theta2)) / R3
    q = np.array([r1, theta1, theta3])
    step = np.linalg.solve(jacobian(q), residual(q, theta2))[2]
    assert step == pytest.approx((np.sin(theta3) - c) / np.cos(theta3), abs=1e-10)


def test_the_sketched_seed_is_good_at_rest_and_leads_to_other_assemblies_later():
    np.testing.assert_allclose(iterate(0.0, SKETCHED)[-1], [-0.099672, -0.468422, 2.873694], atol=5e-7)
    ends = np.array([iterate(u, SKETCHED)[-1] for u in THETA2])
    np.testing.assert_allclose([residual(q, u) for q, u in zip(ends, THETA2, strict=True)], 0, atol=1e-11)
    right = np.cos(ends[:, 2]) > 0
    positive = ~right & (ends[:, 0] > 0)
    turned = ~right & ~positive & (np.abs(ends - BUILT).max(axis=1) > 1)
    assert min(right.sum(), positive.sum(), turned.sum()) > 40  # a few hop about with the last digit of the computer
    assert (np.abs(ends - BUILT).max(axis=1) < 1e-9).sum() > 700


def test_from_source_a_s_seed_every_position_is_found_cold_or_warm():
    cold = [iterate(u, SEED) for u in THETA2]
    np.testing.assert_allclose([path[-1] for path in cold], BUILT, atol=1e-10)
    q, warm = SEED, []
    for u in THETA2:
        warm.append(iterate(u, q))
        q = warm[-1][-1]
    np.testing.assert_allclose([path[-1] for path in warm], BUILT, atol=2e-12)
    for paths, total in ((cold, 4663), (warm, 2881)):
        assert sum(map(len, paths)) == pytest.approx(total, abs=3)  # rounding may decide a step near the tolerance


@pytest.mark.parametrize(("order", "total", "farthest"), [(1, 1992, 2.0e-4), (2, 1361, 1.8e-6)])
def test_each_order_of_the_prediction_brings_the_seed_nearer(order, total, farthest):
    dt = np.diff(TIMES)[:, None]
    ahead = BUILT[:-1] + NINE[3:6].T[:-1] * dt + (order == 2) * NINE[6:].T[:-1] * dt**2 / 2
    seeds = [SEED, *ahead]
    assert np.linalg.norm(ahead - BUILT[1:], axis=1).max() == pytest.approx(farthest, rel=0.03)
    iterations = [len(iterate(u, seed)) for u, seed in zip(THETA2, seeds, strict=True)]
    assert sum(iterations) == pytest.approx(total, abs=3)


def test_a_linear_system_takes_two_iterations_from_any_seed():
    rng = np.random.default_rng(1)
    for q in BUILT[::100]:
        matrix, right = jacobian(q), rng.normal(size=3)
        x, steps = rng.normal(scale=100, size=3), []
        while not steps or steps[-1] >= 1e-6:
            d = np.linalg.solve(matrix, matrix @ x - right)
            x, steps = x - d, [*steps, np.linalg.norm(d)]
        assert len(steps) == 2


def test_the_last_step_leaves_about_its_square():
    q, constants = SEED, []
    for u, exact in zip(THETA2, BUILT, strict=True):
        path = iterate(u, q)
        last = np.linalg.norm(path[-1] - path[-2]) if len(path) > 1 else 0
        q = path[-1]
        if last > 1e-7:
            constants.append(np.linalg.norm(q - exact) / last**2)
    assert 0.4 < min(constants) < max(constants) < 1.6


def test_the_ranges_of_the_nine_quantities():
    degrees = np.array([1, 180 / np.pi, 180 / np.pi] * 3)[:, None]
    lowest = "-0.24499996 -28.2736 135.0995 -0.477940 -75.8712 -171.4134 -3.388934 -380.790 -1075.704"
    largest = "-0.09500025 -10.5838 190.1642 0.604780 53.8392 171.4111 4.609808 640.015 1494.771"
    for printed, computed in ((lowest, (NINE * degrees).min(axis=1)), (largest, (NINE * degrees).max(axis=1))):
        digits = [len(text.partition(".")[2]) for text in printed.split()]
        assert [f"{value:.{n}f}" for value, n in zip(computed, digits, strict=True)] == printed.split()


def test_the_offset_makes_the_strokes_unequal():
    def turned(height):
        """Crank angle from the outer dead centre to the inner one, by looking."""
        u = np.linspace(0, 2 * np.pi, 2_000_001)
        x = R2 * np.cos(u) - np.sqrt(R3**2 - (height - R2 * np.sin(u)) ** 2)
        return (u[x.argmax()] - u[x.argmin()]) % (2 * np.pi), np.ptp(x)

    inwards, stroke = turned(R1Y)
    assert (2 * np.pi - inwards) / inwards == pytest.approx(1.2180, abs=1e-4)
    assert stroke == pytest.approx(0.15717, abs=1e-5)
    assert turned(0.0) == (pytest.approx(np.pi, abs=1e-5), pytest.approx(2 * R2))


def test_a_coupler_of_100_mm_is_too_short_at_181_of_the_instants():
    open_by = np.abs(R1Y - R2 * np.sin(THETA2)) - 0.100
    assert (open_by > 0).sum() == 181
    assert THETA2[np.argmax(open_by > 0)] == pytest.approx(3.96958, abs=1e-5)


def test_a11_the_axis_of_source_a_cuts_the_velocity_at_15_instants():
    assert (np.abs(NINE[3]) > 0.6).sum() == 15


def test_the_coriolis_term_reaches_the_angular_acceleration_of_r1_alone():
    r1, th1, th3, r3 = sp.symbols("r1 th1 th3 r3")
    matrix = sp.Matrix(
        [
            [-sp.cos(th1), r1 * sp.sin(th1), -r3 * sp.sin(th3)],
            [sp.sin(th1), r1 * sp.cos(th1), -r3 * sp.cos(th3)],
            [sp.sin(th1), r1 * sp.cos(th1), 0],
        ]
    )
    reached = sp.simplify(matrix.LUsolve(sp.Matrix([sp.sin(th1), sp.cos(th1), sp.cos(th1)])))
    assert list(reached) == [0, 1 / r1, 0]


def test_the_acceleration_has_corners_where_that_of_the_motor_has_them():
    """Its slopes on both sides differ at T/3, 2T/3 and T, and nowhere else."""
    h = 1e-5
    rates = closed_form()

    def slopes(t):
        a = np.array([rates(*(value[0] for value in crank(np.array([s]))))[6:] for s in (t - h, t, t + h)], dtype=float)
        return (a[2] - 2 * a[1] + a[0]) / h

    jumps = {share: np.abs(slopes(share * T)).max() for share in (1 / 3, 2 / 3, 1, 0.5, 0.8, 1.4)}
    assert min(jumps[share] for share in (1 / 3, 2 / 3, 1)) > 1
    assert max(jumps[share] for share in (0.5, 0.8, 1.4)) < 0.05
