"""Exercise 3 by other right ways than the reference's: each gets full points from every draw."""

from itertools import pairwise

import numpy as np
import pytest
import sympy as sp
from judging import judged
from numpy.polynomial import Polynomial
from scipy.integrate import cumulative_simpson, quad, solve_ivp
from scipy.interpolate import PPoly
from scipy.optimize import brentq

# --- integrate_pieces


def by_one_sympy_piecewise(ends, alpha):
    t = sp.Symbol("t", real=True)
    curve = sp.Piecewise(
        *((sp.Poly(row[::-1].tolist(), t).as_expr(), t < end) for row, end in zip(alpha[:-1], ends[1:-1], strict=True)),
        (sp.Poly(alpha[-1][::-1].tolist(), t).as_expr(), True),
    )
    answer = []
    for width in (alpha.shape[1] + 1, alpha.shape[1] + 2):
        curve = sp.integrate(curve, t)
        curve -= curve.subs(t, 0)
        curve = sp.piecewise_fold(curve)
        answer.append([[float(sp.expand(piece).coeff(t, j)) for j in range(width)] for piece, _ in curve.args])
    return answer


def by_numpy_polynomials(ends, alpha):
    omega, theta, speed, angle = [], [], 0.0, 0.0
    for row, start, end in zip(alpha, ends[:-1], ends[1:], strict=True):
        omega.append(Polynomial(row).integ(lbnd=start, k=speed))
        theta.append(omega[-1].integ(lbnd=start, k=angle))
        speed, angle = omega[-1](end), theta[-1](end)
    return np.array([p.coef for p in omega]), np.array([p.coef for p in theta])


def by_ppoly(ends, alpha):
    def shifted(rows, by):
        full = [Polynomial(row)(Polynomial([shift, 1.0])).coef for row, shift in zip(rows, by, strict=True)]
        return np.array([np.pad(row, (0, rows.shape[1] - len(row))) for row in full])

    omega = PPoly(shifted(alpha, ends[:-1])[:, ::-1].T, ends).antiderivative()
    return [shifted(p.c[::-1].T, -ends[:-1]) for p in (omega, omega.antiderivative())]


def padded(ends, alpha):
    omega, theta = by_numpy_polynomials(ends, alpha)
    return np.stack((np.pad(omega, ((0, 0), (0, 1))), theta))


# --- first_turn


def positive(peak, turns):
    if peak <= 0 or turns <= 0:
        raise ValueError(f"got {peak}, {turns}")


def by_solve(peak, turns):
    positive(peak, turns)
    T = sp.Symbol("T", positive=True)
    (duration,) = sp.solve(sp.Rational(1, 3) * peak * T**2 - 2 * sp.pi * turns, T)
    return float(duration)


def by_quadrature(peak, turns):
    positive(peak, turns)

    def angle(T):  # theta(T) is the integral of (T - t) alpha(t)
        return quad(lambda t: (T - t) * peak * min(1, 3 * t / T, 3 - 3 * t / T), 0, T, points=[T / 3, 2 * T / 3])[0]

    return brentq(lambda T: angle(T) - 2 * np.pi * turns, 1e-3, 1e2)


def by_mean_speed(peak, turns):
    positive(peak, turns)
    return np.array((2 * np.pi * turns / (peak / 3)) ** 0.5)


# --- motor_profile


def valid(t, T):
    if not T > 0:
        raise ValueError(f"T = {T}")
    if not np.all(np.isfinite(t)) or np.min(t) < 0:
        raise ValueError(f"t = {next(x for x in t if not 0 <= x < np.inf)}")


def by_a_loop(t, T, peak):
    valid(t, T)
    rows = []
    for x in t:
        if x < T / 3:
            rows.append([3 * peak * x / T, 3 * peak * x**2 / (2 * T), peak * x**3 / (2 * T)])
        elif x <= 2 * T / 3:
            rows.append([peak, peak * (x - T / 6), peak * (x * x / 2 - T * x / 6 + T * T / 54)])
        elif x < T:
            y = T - x  # the mirror image of the first piece
            speed = 2 * peak * T / 3
            rows.append(
                [
                    3 * peak * y / T,
                    speed - 3 * peak * y**2 / (2 * T),
                    peak * T**2 / 3 - speed * y + peak * y**3 / (2 * T),
                ]
            )
        else:
            rows.append([0, 2 * peak * T / 3, peak * T * (2 * x - T) / 3])
    return rows


def by_ramps(t, T, peak):
    """Each corner of the trapezoid switches a ramp on."""
    valid(t, T)
    corners, slopes = T / 3 * np.arange(4), 3 * peak / T * np.array([1, -1, -1, 1])
    since = np.maximum(t[:, None] - corners, 0)
    return np.stack([since @ slopes, since**2 @ slopes / 2, since**3 @ slopes / 6], axis=1)


def by_masks(t, T, peak):
    valid(t, T)
    out = np.empty((len(t), 3))
    ends, alpha = (
        T * np.array([0, 1 / 3, 2 / 3, 1, 1e3]),
        [[0, 3 * peak / T], [peak, 0], [3 * peak, -3 * peak / T], [0, 0]],
    )
    for coefficients in zip(range(4), alpha, *by_numpy_polynomials(ends, np.array(alpha)), strict=True):
        k, *rows = coefficients
        mask = (t >= ends[k]) & (t < ends[k + 1])
        out[mask] = np.transpose([Polynomial(row)(t[mask]) for row in rows])
    return out


def by_an_integrator(t, T, peak):
    valid(t, T)

    def alpha(t):
        return peak * np.clip(np.minimum(3 * t / T, 3 - 3 * t / T), 0, 1)

    corners = [*(T / 3 * np.arange(4)), max(t.max(), 1.1 * T)]
    out, state = np.empty((len(t), 3)), [0.0, 0.0]
    for start, end in pairwise(corners):
        run = solve_ivp(lambda t, y: [alpha(t), y[0]], (start, end), state, rtol=1e-12, atol=1e-13, dense_output=True)
        mask = (t >= start) & (t <= end)
        if mask.any():
            out[mask] = np.column_stack((alpha(t[mask]), *run.sol(t[mask])))
        state = run.y[:, -1]
    return out


# --- misprint


def by_halves_of_each_piece(alpha, omega, theta, T):
    """Simpson's rule over each piece is exact for these polynomials: compare the increments."""
    for name, function, derivative in (("omega", omega, alpha), ("theta", theta, omega)):
        scale = max(abs(function(x)) for x in np.linspace(0.01, 2 * T, 50))
        tiny = 1e-9 * T
        bad_slope, bad_start, last = [], [], 0.0
        for k in range(4):
            a, b = k * T / 3 + tiny, (k + 1) * T / 3 - tiny
            for c, d in ((a, (a + b) / 2), ((a + b) / 2, b)):
                integral = (d - c) / 6 * (derivative(c) + 4 * derivative((c + d) / 2) + derivative(d))
                if abs(function(d) - function(c) - integral) > 1e-4 * scale and k not in bad_slope:
                    bad_slope.append(k)
            if abs(function(a) - last) > 1e-4 * scale:
                bad_start.append(k)
            last = function(b)
        for found in (bad_slope, bad_start):
            if found:
                return [name, found[0]]
    return None


def by_gradient(alpha, omega, theta, T):
    """np.gradient on a grid of each piece; the jump by the values at the ends of the grids."""
    grids = [np.linspace(k * T / 3, (k + 1) * T / 3, 401)[:-1] + T / 2400 for k in range(4)]
    for name, function, derivative in (("omega", omega, alpha), ("theta", theta, omega)):
        level = max(np.abs(derivative(g)).max() for g in grids)
        for k, g in enumerate(grids):
            if np.abs(np.gradient(function(g), g) - derivative(g))[1:-1].max() > 0.01 * level:
                return name, k
        largest = max(np.abs(function(g)).max() for g in grids)
        step = [function(g[0]) - (function(grids[k - 1][-1]) if k else 0.0) for k, g in enumerate(grids)]
        for k, jump in enumerate(step):
            if abs(jump) > 0.05 * largest:
                return name, np.int64(k)
    return None


def by_integrating_anew(alpha, omega, theta, T):
    """Sum alpha up to what omega should be, and that to what theta should be: no comparison of slopes."""
    t = np.linspace(0, 2 * T, 1201)
    right = cumulative_simpson(alpha(t), x=t, initial=0)
    for name, function in (("omega", omega), ("theta", theta)):
        off = np.abs(function(t) - right) > 2e-3 * np.abs(right).max()
        if off.any():
            return name, min(3, int(3 * t[off].mean() / T))
        right = cumulative_simpson(right, x=t, initial=0)
    return None


ROUTES = {
    "integrate_pieces": (by_one_sympy_piecewise, by_numpy_polynomials, by_ppoly, padded),
    "first_turn": (by_solve, by_quadrature, by_mean_speed),
    "motor_profile": (by_a_loop, by_ramps, by_masks, by_an_integrator),
    "misprint": (by_halves_of_each_piece, by_gradient, by_integrating_anew),
}


@pytest.mark.parametrize(
    ("name", "function"),
    [(name, function) for name, functions in ROUTES.items() for function in functions],
    ids=lambda value: getattr(value, "__name__", value),
)
def test_another_right_way_gets_full_points(name, function):
    draws = 10 if function in (by_one_sympy_piecewise, by_an_integrator) else 40
    for student in range(draws):
        assessment = judged(name, function, f"route {student}")
        assert assessment.verdict == "right", assessment.diagnosis
