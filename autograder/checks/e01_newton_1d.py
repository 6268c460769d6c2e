"""Exercise 1: Newton-Raphson in one variable."""

from collections.abc import Callable, Iterator
from functools import partial
from itertools import pairwise

import numpy as np

from autograder.checks.answers import refuses
from autograder.checks.iteration import (
    ends_on_the_root,
    errors,
    evaluates_once_an_iteration,
    fails_aloud,
    says_where,
    slips_of_the_history,
    stops_when_asked,
    takes_newtons_steps,
)
from autograder.compare import Tolerance
from autograder.spec import Aspect, Case, Exercise, Task, Trial, Variant
from mechlib.bracket import brackets
from mechlib.newton import ConvergenceError, newton_1d, order

Function = Callable[[float], float]

# --- brackets ---------------------------------------------------------------------------------------------------------


def bracket_cases(rng: np.random.Generator) -> list[Case]:
    def of_roots(roots: np.ndarray) -> Function:
        return lambda x: np.prod([x - root for root in roots], axis=0)

    cases = []
    for n, count in ((20, 3), (31, 4), (12, 2), (25, 0)):
        a = rng.uniform(-5, 5)
        b = a + rng.uniform(2, 10)
        cell = (b - a) / n
        # the last cell, the first, and others; in the middle of each: no rounding of the grid changes the answer
        cells = np.concatenate(([n - 1, 0], 1 + rng.choice(n - 2, n - 2, replace=False)))[:count]
        roots = a + cell * (cells + rng.uniform(0.2, 0.8, count))
        pairs = np.repeat(roots[:1], 2)  # a double root does not change the sign, and is not bracketed
        f = of_roots(np.concatenate((roots, pairs))) if n == 31 else of_roots(roots)
        f = f if count else lambda x: np.cosh(x)
        cases.append(Case((f, a, b, n), label=f"{count} changes of sign on [{a:.3g}, {b:.3g}] with n = {n}"))
    f, a, b, n = cases[0].args
    few = -int(rng.integers(2, 9))
    bad = (((b, a, n), "a > b"), ((a, a, n), "a = b"), ((a, b, 0), "n = 0"), ((a, b, few), f"n = {few}"))
    cases += [Case((f, *args), kind="bad", label=label) for args, label in bad]
    return [*cases, Case((f, a, b, 1), kind="bad", label="n = 1, which is good")]


def without_a_change(f, a, b, n):
    grid = np.linspace(a, b, n + 1)
    return np.array([(u, v) for u, v in pairwise(grid) if f(u) * f(v) > 0])


def each_grid_point_once(trial: Trial, right: Trial) -> str | None:
    n = trial.case.args[3]
    points = sum(np.size(asked[0]) for asked in trial.evaluations[0])
    return None if points <= n + 1 else f"it evaluates f at {points} points, where the grid has {n + 1}"


GRID = Tolerance(1e-9, "a grid point is right to round-off")

BRACKETS = Task(
    name="brackets",
    title="the subintervals that hold a zero, by Bolzano",
    function="brackets",
    reference=brackets,
    cases=bracket_cases,
    tolerance=GRID,
    section="newton-1d: Is there a root, and is it the only one?",
    aspects=(
        Aspect("it returns every subinterval on which f changes sign, and no other", 1.0),
        Aspect("it evaluates f once at each grid point", 0.5, each_grid_point_once),
        Aspect(
            "it refuses a >= b and n < 1, and nothing else, with a ValueError that holds the wrong value",
            0.5,
            refuses(lambda f, a, b, n: (n,) if a < b else (a, b), GRID),
            kind="bad",
        ),
    ),
    variants=(
        Variant(
            "The grid has n points, and not n subintervals",
            "Count the fence posts: how many ends do n subintervals have?",
            lambda f, a, b, n: brackets(f, a, b, n - 1),
            share=0.25,
        ),
        Variant(
            "Only the ends of the whole interval are compared",
            "An even number of zeros leaves the sign at the ends the same. Where else must the sign be looked at?",
            lambda f, a, b, n: brackets(f, a, b, 1),
        ),
        Variant(
            "The subintervals without a change of sign",
            "What does Bolzano ask of the product f(a) f(b)?",
            without_a_change,
        ),
        Variant(
            "The last subinterval is left out",
            "Does the loop reach the subinterval that ends at b?",
            lambda f, a, b, n: (found := brackets(f, a, b, n))[found[:, 1] < b - (b - a) / (2 * n)],
            share=0.25,
        ),
    ),
)

# --- newton_1d --------------------------------------------------------------------------------------------------------


def functions(rng: np.random.Generator, scale: float) -> tuple[Function, Function, float, str]:
    """A function with one root of the order of the scale and of its sign, its derivative, a seed, and its name."""
    height = 10 ** rng.uniform(-4, 4) * rng.choice([-1, 1])  # the size of f tells nothing of the distance to its root
    c = rng.uniform(1.2, 3)
    g, dg, name = [
        (lambda u: u**3 + u - c**3 - c, lambda u: 3 * u**2 + 1, f"u^3 + u - {c**3 + c:.3g}"),
        (lambda u: np.exp(u) - np.exp(c), lambda u: np.exp(u), f"e^u - {np.exp(c):.3g}"),
        (lambda u: np.sin(u) / 2 + u - c, lambda u: np.cos(u) / 2 + 1, f"sin(u)/2 + u - {c:.3g}"),
    ][rng.integers(3)]
    seed = scale * (c + rng.uniform(0.4, 1.2))
    return (
        lambda x: height * g(x / scale),
        lambda x: height * dg(x / scale) / scale,
        seed,
        f"f(x) = {height:.3g} ({name}), u = x/{scale:.3g}, from x = {seed:.4g}",
    )


def solvable(rng: np.random.Generator, scale: float, tol: float, error: str) -> Case:
    """A case in which no rounding decides when to stop, and the other error would stop elsewhere."""
    while True:
        f, df, seed, name = functions(rng, scale)
        path = newton_1d(f, df, seed, tol, error)
        other = newton_1d(f, df, seed, tol, "relative" if error == "absolute" else "absolute")
        clear = not ((path.errors > tol / 3) & (path.errors < 3 * tol)).any()
        shrinks = (np.diff(path.errors) < 0).all()
        if clear and shrinks and 3 <= path.iterations <= 10 and path.iterations != other.iterations:
            return Case((f, df, seed, tol, error, 30), label=f"{name}, {error} error below {tol:g}")


def newton_cases(rng: np.random.Generator) -> list[Case]:
    """Four cases on which every way to stop takes another number of iterations, also with one too many or too few."""

    def iterations(function: Callable) -> np.ndarray:
        return np.array([len(function(*case.args)) for case in cases])

    side = rng.choice([-1, 1])  # a root of either sign, reached from either side
    while True:
        cases = [
            solvable(rng, scale=side * 1e3 * rng.uniform(1, 9), tol=1e-6, error="absolute"),
            solvable(rng, scale=side * 1e4 * rng.uniform(1, 9), tol=1e-5, error="relative"),
            solvable(rng, scale=-side * 1e-3 * rng.uniform(1, 9), tol=1e-6, error="absolute"),
            solvable(rng, scale=-side * 1e-4 * rng.uniform(1, 9), tol=1e-7, error="relative"),
        ]
        rules = iterates, on_the_residual, always_absolute, always_relative
        ways = [iterations(rule) + more for rule in rules for more in (-1, 0, 1)]
        if len({tuple(way) for way in ways}) == len(ways):
            return cases


def iterates(f, df, seed, tol, error, max_iterations):
    return newton_1d(f, df, seed, tol, error, max_iterations).history


def on_the_residual(f, df, seed, tol, error, max_iterations):
    x = [seed]
    while abs(f(x[-1])) > tol and len(x) <= max_iterations:
        x.append(x[-1] - f(x[-1]) / df(x[-1]))
    return np.array(x)


def always_absolute(f, df, seed, tol, error, max_iterations):
    return iterates(f, df, seed, tol, "absolute", max_iterations)


def always_relative(f, df, seed, tol, error, max_iterations):
    return iterates(f, df, seed, tol, "relative", max_iterations)


def one_too_many(f, df, seed, tol, error, max_iterations):
    x = iterates(f, df, seed, tol, error, max_iterations)
    return np.append(x, x[-1] - f(x[-1]) / df(x[-1]))


NEWTON_1D = Task(
    name="newton_1d",
    title="Newton-Raphson with its history, stopped by the absolute or the relative error",
    function="newton_1d",
    reference=iterates,
    cases=newton_cases,
    tolerance=Tolerance(1e-8, "two ways to write a step differ by round-off"),
    section="newton-1d: Follow the tangent",
    errors=errors,
    aspects=(
        Aspect("the last iterate is the root", 1.5, ends_on_the_root),
        Aspect("the history begins with the seed, and every step is Newton's", 1.0, takes_newtons_steps),
        Aspect("it stops at the first step whose error, of the kind asked for, is below tol", 1.0, stops_when_asked),
        Aspect("it evaluates f and f' once an iteration", 0.5, evaluates_once_an_iteration),
    ),
    variants=(
        Variant(
            "The step has the wrong sign",
            "Draw the tangent at the seed: on which side of the seed does it meet the axis?",
            lambda f, df, *rest: iterates(f, lambda x: -df(x), *rest),
            by_path=True,
        ),
        Variant(
            "The slope of the seed is used in every step",
            "This is the chord method, of order one. Where must the slope be taken in each step?",
            lambda f, df, seed, *rest: iterates(f, lambda x: df(seed), seed, *rest),
            share=0.25,
            by_path=True,
        ),
        Variant(
            "It stops when f is small, and not when the step is",
            "The size of f depends on its units: multiply f by a thousand, and the root is where it was.",
            on_the_residual,
            share=0.5,
        ),
        Variant(
            "The absolute error is used whichever error is asked for",
            "Read how the relative error is defined: what does it divide the step by?",
            always_absolute,
            share=0.5,
        ),
        Variant(
            "The relative error is used whichever error is asked for",
            "Where the absolute error is asked for, tol has the units of x.",
            always_relative,
            share=0.5,
        ),
        Variant(
            "One iteration too many",
            "Is the error looked at before or after the step that it belongs to?",
            one_too_many,
            share=0.5,
        ),
        *slips_of_the_history(iterates),
    ),
)

# --- failures ---------------------------------------------------------------------------------------------------------


def failing_functions(rng: np.random.Generator) -> Iterator[tuple[Function, Function, float, str]]:
    # Python's own numbers: their division by zero is not NumPy's
    a, c = (rng.uniform(0.3, 0.7, 2) + rng.integers(2, 9, 2)).tolist()
    yield lambda x: (x - a) ** 2 - c, lambda x: 2 * (x - a), a, "a seed where the derivative is zero"
    yield (
        lambda x: ((x - a) / c) ** 3 - 2 * (x - a) / c + 2,
        lambda x: (3 * ((x - a) / c) ** 2 - 2) / c,
        a,
        "a two-cycle",
    )
    yield lambda x: np.cbrt(x - a), lambda x: np.cbrt(x - a) ** -2 / 3, a + c, "a cusp that throws the iterates off"
    yield lambda x: np.log(x / a), lambda x: 1 / x, a * (np.e + c), "a seed that leaves the domain"


def failure_cases(rng: np.random.Generator) -> list[Case]:
    cases = [Case((f, df, seed, 1e-9, "absolute", 25), label=name) for f, df, seed, name in failing_functions(rng)]
    f, df, seed, tol, error, _ = solvable(rng, scale=rng.uniform(1, 9), tol=1e-6, error="relative").args
    enough = newton_1d(f, df, seed, tol, error).iterations
    return [*cases, Case((f, df, seed, tol, error, enough - 1), label="one iteration fewer than it takes")]


def history_at_the_end(*args):
    """What there is when the iterations run out, and no word that it is no answer."""
    try:
        return iterates(*args)
    except ConvergenceError as failure:
        if failure.path.iterations < args[-1]:
            raise
        return failure.path.history


FAILURES = Task(
    name="failures",
    title="newton_1d says so when there is no convergence",
    function="newton_1d",
    reference=iterates,
    cases=failure_cases,
    tolerance=Tolerance(1e-8, "two ways to write a step differ by round-off"),
    section="newton-1d: How it fails",
    aspects=(
        Aspect(
            "it raises ConvergenceError where the derivative is zero, x is not finite, or the iterations run out",
            1.0,
            fails_aloud,
        ),
        Aspect("the message tells the x at which it failed", 1.0, says_where),
    ),
    variants=(
        Variant(
            "Where the iterations run out, the history is returned",
            "Whoever calls the function takes what it returns for an answer.",
            history_at_the_end,
            share=0.25,
        ),
    ),
)

# --- order ------------------------------------------------------------------------------------------------------------


def order_cases(rng: np.random.Generator) -> list[Case]:
    sign, size = rng.choice([-1, 1]), int(rng.integers(3, 10))
    eps = np.finfo(float).eps

    def converging(p: float, rate: float, first: float, steps: int, sign: int, size: int) -> np.ndarray:
        """Iterates near a root of the size of a power of two, which end in a step that counts and two that do not."""
        root, errors = sign * rng.uniform(1.7, 1.95) * 2.0**size, [first]
        for _ in range(steps):
            errors.append(rate * errors[-1] ** p)
        unit = np.spacing(abs(root))  # about half of eps at the root: some 8.4, 0 and 7.6 units of round-off can be met
        digits = np.round(np.array([8.4, 0, 7.6, 0]) * eps * abs(root) / unit)
        return np.concatenate((root + abs(root) * np.array(errors), root + unit * digits))

    rate, golden, short = rng.uniform(0.2, 0.4), (1 + 5**0.5) / 2, partial(Case, kind="short")
    down = int(np.log(100 * eps) / np.log(rate))
    quadratic = converging(2, rng.uniform(0.5, 1), rng.uniform(0.12, 0.25), 3, sign, size)
    linear = converging(1, rate, rng.uniform(0.3, 0.5), down, sign, -size)
    secant = converging(golden, rng.uniform(0.5, 1), rng.uniform(0.12, 0.25), 5, -sign, -size)
    return [
        Case((quadratic,), label="a quadratic history that ends in round-off"),
        Case((linear,), label="a linear history that ends in round-off"),
        Case((secant,), label="the history of a secant method that ends in round-off"),
        Case((quadratic[:4],), label="a quadratic history of four iterates"),
        short((quadratic[:2],), label="two iterates"),
        short((quadratic[:3],), label="three iterates"),
        short((np.repeat(rng.uniform(1, 5), 5),), label="no step above round-off"),
    ]


def order_from_steps(
    history, choose=lambda s: s[-3:], round_off=8.0, ratio=lambda s: np.log(s[2] / s[1]) / np.log(s[1] / s[0])
):
    """The observed order with one of its parts exchanged."""
    steps = np.abs(np.diff(history))
    s = choose(steps[steps > round_off * np.finfo(float).eps * abs(history[-1])])
    return ratio(s) if len(s) == 3 else np.nan


ORDER = Task(
    name="order",
    title="the observed order of convergence",
    function="order",
    reference=order,
    cases=order_cases,
    tolerance=Tolerance(1e-6, "the same three steps give the same order to round-off"),
    section="newton-1d: How fast: the order of convergence",
    aspects=(
        Aspect("it is taken from the last three steps longer than 8 units of round-off at the root", 1.5),
        Aspect("it is nan where there are fewer than three", 0.5, kind="short"),
    ),
    variants=(
        Variant(
            "Steps of the size of round-off are counted in",
            "The last digit trembles: such a step says nothing of convergence. Which steps are long enough?",
            lambda h: order_from_steps(h, round_off=0.0),
            share=0.25,
        ),
        Variant(
            "The first three steps are used",
            "The order is what happens near the root: which steps are nearest?",
            lambda h: order_from_steps(h, choose=lambda s: s[:3]),
            share=0.5,
        ),
        Variant(
            "The ratio of the logarithms is upside down",
            "A quadratic history must give two, and not one half.",
            lambda h: 1 / order_from_steps(h),
            share=0.5,
        ),
        Variant(
            "The rate of convergence, and not its order",
            "That each step is so many times shorter is the rate. How does the number of right digits grow?",
            lambda h: order_from_steps(h, ratio=lambda s: s[2] / s[1]),
        ),
    ),
)

EXERCISE = Exercise(
    name="01_newton_1d",
    title="Newton-Raphson in one variable",
    tasks=(BRACKETS, NEWTON_1D, FAILURES, ORDER),
)
