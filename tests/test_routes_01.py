"""Exercise 1 by other right ways than the reference's: each gets full points from every draw."""

import math
from itertools import pairwise

import numpy as np
import pytest
from judging import judged
from scipy.optimize import newton

# --- brackets


def brackets_by_lists(f, a, b, n):
    if b <= a or n <= 0:
        raise ValueError(f"not an interval in parts: [{a}, {b}] in {n}")
    grid = [(a * (n - i) + b * i) / n for i in range(n + 1)]
    signs = [math.copysign(1, f(x)) for x in grid]
    return [[u, v] for (u, s), (v, t) in pairwise(zip(grid, signs, strict=True)) if s != t]


def brackets_in_one_evaluation(f, a, b, n):
    if not b > a:
        raise ValueError(f"{b} is not above {a}")
    if n < 1:
        raise ValueError(n)
    x = np.linspace(a, b, n + 1)
    k = np.flatnonzero(np.diff(np.signbit(np.broadcast_to(f(x), x.shape))))
    return x[k[:, None] + [0, 1]]


def brackets_from_the_right(f, a, b, n):
    if (b - a) <= 0:
        raise ValueError(f"a = {a:.3g}")
    if int(n) < 1:
        raise ValueError(f"{n} subintervals")
    found, right, above = [], b, f(b) > 0
    for i in reversed(range(n)):
        left = a + i * (b - a) / n
        if (f(left) > 0) != above:
            found.insert(0, (left, right))
            above = not above
        right = left
    return tuple(found)


# --- newton_1d and failures


def newton_by_recursion(f, df, seed, tol, error, max_iterations):
    if max_iterations == 0:
        raise ArithmeticError(f"nothing found, ended at {seed}")
    slope = df(seed)
    ahead = seed - f(seed) / slope if slope else math.nan
    if not math.isfinite(ahead):
        raise OverflowError(f"no way on from {seed}")
    if abs(ahead - seed) < tol * (abs(ahead) if error == "relative" else 1):
        return [seed, ahead]
    return [seed, *newton_by_recursion(f, df, ahead, tol, error, max_iterations - 1)]


def newton_with_values_ahead(f, df, seed, tol, error, max_iterations):
    """Function and slope are known before the loop begins, so that each is asked for once more, at the root."""
    x = np.full(max_iterations + 1, np.nan)
    x[0], y, slope = seed, f(seed), df(seed)
    for k in range(max_iterations):
        with np.errstate(all="ignore"):
            x[k + 1] = x[k] - np.float64(y) / slope
        if not np.isfinite(x[k + 1]):
            raise FloatingPointError(f"left the numbers after {x[k]:.4g}")
        change = abs(x[k + 1] - x[k])
        if (change / abs(x[k + 1]) if error == "relative" else change) < tol:
            return x[: k + 2]
        y, slope = f(x[k + 1]), df(x[k + 1])
    raise ArithmeticError(f"x = {x[-1]} is no root")


def newton_by_scipy(f, df, seed, tol, error, max_iterations):
    """SciPy takes the steps, one at a time; the rule is the task's."""
    x = [float(seed)]
    while len(x) <= max_iterations:
        value, slope = f(x[-1]), df(x[-1])
        if slope == 0:
            raise ArithmeticError(f"flat at {x[-1]}")
        ahead, _ = newton(lambda _, y=value: y, x[-1], lambda _, s=slope: s, maxiter=1, disp=False, full_output=True)
        x.append(ahead)
        if not np.isfinite(ahead):
            raise ArithmeticError(f"{x[-2]} leads to {ahead}")
        scale = {"absolute": 1, "relative": abs(ahead)}[error]
        if abs(x[-2] - ahead) / scale < tol:
            return tuple(x)
    raise ArithmeticError(f"the last of {max_iterations} iterates is {x[-1]}")


# --- order


def order_by_slope(history):
    """The slope of the straight line that the logarithms of two pairs of steps lie on."""
    x = np.array(history, dtype=float)
    steps = [abs(b - a) for a, b in pairwise(x) if abs(b - a) > 8 * np.finfo(float).eps * abs(x[-1])][-3:]
    return np.polyfit(np.log(steps[:-1]), np.log(steps[1:]), 1)[0] if len(steps) == 3 else math.nan


def order_from_behind(history):
    long = []
    for k in range(len(history) - 1, 0, -1):
        step = abs(history[k] - history[k - 1])
        if step / abs(history[-1]) > 2.0**-49:
            long.append(math.log2(step))
        if len(long) == 3:
            return (long[0] - long[1]) / (long[1] - long[2])
    return float("nan")


def order_with_a_mask(history):
    steps = np.abs(np.ediff1d(history))
    kept = np.log(steps[steps > np.spacing(1.0) * np.abs(8 * history[-1])])
    rises = np.diff(kept)[-2:]
    return np.array(rises[1] / rises[0] if rises.size == 2 else np.nan)


@pytest.mark.parametrize(
    ("name", "function"),
    [
        ("brackets", brackets_by_lists),
        ("brackets", brackets_in_one_evaluation),
        ("brackets", brackets_from_the_right),
        *(
            (name, function)
            for name in ("newton_1d", "failures")
            for function in (newton_by_recursion, newton_with_values_ahead, newton_by_scipy)
        ),
        ("order", order_by_slope),
        ("order", order_from_behind),
        ("order", order_with_a_mask),
    ],
    ids=lambda value: getattr(value, "__name__", value),
)
def test_another_right_way_gets_full_points(name, function):
    for student in range(40):
        assessment = judged(name, function, f"route {student}")
        assert assessment.verdict == "right", assessment.diagnosis
