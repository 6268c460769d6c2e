"""Exercise 2: Newton-Raphson in several variables."""

from collections.abc import Callable

import numpy as np

from autograder.checks.answers import array
from autograder.checks.iteration import (
    ends_on_the_root,
    errors,
    fails_aloud,
    history,
    slips_of_the_history,
    stops_when_asked,
    takes_newtons_steps,
)
from autograder.compare import Tolerance, numbers, wrong_shape
from autograder.outcome import Lost, Outcome, Raised, Value
from autograder.spec import Aspect, Case, Exercise, Task, Trial, Variant
from mechlib.basins import basins
from mechlib.jacobian import finite_difference_jacobian, wrong_entries
from mechlib.newton import newton

Field = Callable[[np.ndarray], np.ndarray]

# --- newton -----------------------------------------------------------------------------------------------------------


def system(rng: np.random.Generator, n: int, scale: float, height: float) -> tuple[Field, Field, np.ndarray]:
    """A system with one root near a seed; its Jacobian is almost, but not quite, symmetric.

    So the transposed Jacobian finds the root as well, at order one: a check of the root alone cannot see it.
    """
    root = scale * rng.uniform(0.5, 2, n) * rng.choice([-1, 1], n)
    half = rng.uniform(-0.3, 0.3, (n, n))
    linear = (
        np.diag(rng.uniform(2, 3, n))
        + (half + half.T) / 2
        + 0.15 * (np.triu(np.ones((n, n)), 1) - np.tril(np.ones((n, n)), -1))
    )
    bend = rng.uniform(0.2, 0.5, n)

    def residual(x):
        y = (np.asarray(x, dtype=float) - root) / scale
        return height * (linear @ y + bend * (np.cosh(y) - 1))

    def jacobian(x):
        y = (np.asarray(x, dtype=float) - root) / scale
        return height * (linear + np.diag(bend * np.sinh(y))) / scale

    return residual, jacobian, root + scale * rng.uniform(0.3, 0.8, n) * rng.choice([-1, 1], n)


def newton_cases(rng: np.random.Generator) -> list[Case]:
    cases = []
    # flat, steep, even: the size of the residual tells nothing of the distance to the root
    for n, scale, height in ((2, 1.0, 1e-6), (3, 200.0, 1e6), (4, 5e-3, 1.0)):
        while True:
            residual, jacobian, seed = system(rng, n, scale, height * rng.uniform(0.3, 3))
            tol = 1e-8 * scale
            if n == 4:  # between the norms of a step: the largest entry alone is below it one step before the 2-norm is
                step = np.diff(newton(residual, jacobian, seed, tol).history, axis=0)[2]
                norm, largest = np.linalg.norm(step), np.abs(step).max()
                tol = float(np.sqrt(norm * largest))
                if norm < 1.3 * largest:
                    continue
            path = newton(residual, jacobian, seed, tol)
            # no rounding decides when to stop
            margin = 1.1 if n == 4 else 3
            clear = not ((path.errors > tol / margin) & (path.errors < margin * tol)).any()
            if clear and 3 <= path.iterations <= 8:
                break
        cases.append(Case((residual, jacobian, seed, tol, 40), label=f"{n} unknowns of the order of {scale:g}"))
    few = Case(
        (residual, jacobian, seed, tol, path.iterations - 1), kind="failing", label="one iteration fewer than it takes"
    )
    return [*cases, _ill_conditioned(rng), *_without_a_root(rng), few]


def _ill_conditioned(rng: np.random.Generator) -> Case:
    """Linear, condition 1e10, from the origin: the first iterate is the first step itself."""
    u, v = (np.linalg.qr(rng.normal(size=(5, 5)))[0] for _ in range(2))
    matrix = u @ np.diag(np.logspace(0, -10, 5)) @ v
    right = matrix @ rng.uniform(1, 2, 5)
    args = (lambda x: matrix @ x - right, lambda x: matrix, np.zeros(5), 1e-2, 10)
    return Case(args, kind="ill", label="five equations that are nearly dependent, from the origin")


def _without_a_root(rng: np.random.Generator) -> list[Case]:
    a, b = rng.uniform(0.5, 2, 2)
    singular = (lambda x: np.array([x[0] ** 2 - a, x[1] ** 2 - b]), lambda x: np.diag(2 * np.asarray(x)))
    rootless = (
        lambda x: np.array([x[0] ** 2 + a, x[1] - b * x[0]]),
        lambda x: np.array([[2 * x[0], 0.0], [-b, 1.0]]),
    )
    return [
        Case((*singular, np.array([0.0, 1.0]), 1e-9, 25), kind="failing", label="a singular Jacobian at the seed"),
        Case((*rootless, np.array([a, b]), 1e-9, 25), kind="failing", label="a system that has no root"),
    ]


def solves_and_does_not_invert(trial: Trial, right: Trial) -> str | None:
    iterates = history(trial)
    if isinstance(iterates, str):
        return iterates
    if len(iterates) < 2 or not np.isfinite(iterates[1]).all():
        return "there is no finite first step"
    residual, jacobian, seed, *_ = trial.case.args
    matrix, step = jacobian(seed), seed - iterates[1]
    left = np.linalg.norm(matrix @ step - residual(seed)) / (np.linalg.norm(matrix) * np.linalg.norm(step))
    # elimination leaves some 1e-16 of this whatever the condition; an inverse leaves 1e-16 times the condition, 1e-6
    if left < 1e-11:
        return None
    return f"the first step leaves {left:.0e} of the scale, where a solve leaves less than 1e-15: is an inverse formed?"


def iterates(residual, jacobian, seed, tol, max_iterations):
    return newton(residual, jacobian, seed, tol, max_iterations=max_iterations).history


def by_the_largest_entry(residual, jacobian, seed, tol, max_iterations):
    x, step = [np.array(seed)], np.inf
    while np.abs(step).max() > tol and len(x) <= max_iterations:
        step = np.linalg.solve(jacobian(x[-1]), residual(x[-1]))
        x.append(x[-1] - step)
    return np.array(x)


def on_the_residual(residual, jacobian, seed, tol, max_iterations):
    x = [np.array(seed)]
    while np.linalg.norm(residual(x[-1])) > tol and len(x) <= max_iterations:
        x.append(x[-1] - np.linalg.solve(jacobian(x[-1]), residual(x[-1])))
    return np.array(x)


NEWTON = Task(
    name="newton",
    title="Newton-Raphson in n variables, by a linear solve",
    function="newton",
    reference=iterates,
    cases=newton_cases,
    tolerance=Tolerance(1e-8, "two ways to write a step differ by round-off"),
    section="newton-nd: Solve, do not invert",
    errors=errors,
    aspects=(
        Aspect("the last iterate is the root", 1.0, ends_on_the_root),
        Aspect("the history begins with the seed, and every step is Newton's", 1.0, takes_newtons_steps),
        Aspect("it stops at the first step whose 2-norm is below tol", 0.5, stops_when_asked),
        Aspect("each step is solved for, and no inverse is formed", 1.0, solves_and_does_not_invert, kind="ill"),
        Aspect(
            "it raises ConvergenceError where the Jacobian is singular or the iterations run out",
            0.5,
            fails_aloud,
            kind="failing",
        ),
    ),
    variants=(
        Variant(
            "The Jacobian is transposed",
            "It lands on the root at order one. Row i belongs to equation i: which index is the unknown's?",
            lambda f, j, *rest: iterates(f, lambda x: j(x).T, *rest),
            share=0.25,
            by_path=True,
        ),
        Variant(
            "The Jacobian of the seed is used in every step",
            "It lands on the root at order one. Where must the Jacobian be evaluated in each step?",
            lambda f, j, seed, *rest: iterates(f, lambda x: j(seed), seed, *rest),
            share=0.25,
            by_path=True,
        ),
        Variant(
            "The step has the wrong sign",
            "The step is what must be taken from x: solve the linear model for where it vanishes.",
            lambda f, j, *rest: iterates(f, lambda x: -j(x), *rest),
            by_path=True,
        ),
        Variant(
            "It stops when the residual is small, and not when the step is",
            "The residual has the units of the equations, and tol those of the unknowns.",
            on_the_residual,
            share=0.5,
        ),
        Variant(
            "The largest entry of the step is compared with tol, and not its 2-norm",
            "Which length of a vector does the task ask for?",
            by_the_largest_entry,
            share=0.5,
        ),
        *slips_of_the_history(iterates),
    ),
)

# --- jacobian_fd ------------------------------------------------------------------------------------------------------


def difference_cases(rng: np.random.Generator) -> list[Case]:
    def waves(m: int, n: int) -> Field:
        a, b = rng.uniform(0.5, 2, (m, n)), rng.uniform(0.5, 1.5, (n, n))
        return lambda x: a @ np.sin(b @ np.asarray(x, dtype=float))

    def long(n: int, size: float) -> Field:
        a = rng.uniform(0.5, 2, (n, n))
        return lambda x: a @ (np.asarray(x, dtype=float) / size) ** 2

    cases = [
        Case((waves(m, n), rng.uniform(-1, 1, n)), label=f"{m} equations, {n} unknowns")
        for m, n in ((3, 3), (2, 4), (5, 2))
    ]
    size = 10 ** rng.uniform(7, 8)
    x = size * rng.uniform(1, 3, 3) * rng.permutation([-1, -1, 1])
    return [*cases, Case((long(3, size), x), kind="large", label=f"unknowns of the order of {size:.0e}")]


def evaluates_little(trial: Trial, right: Trial) -> str | None:
    n, asked = len(trial.case.args[1]), len(trial.evaluations[0])
    return None if asked <= 2 * n + 1 else f"it evaluates the function {asked} times for {n} unknowns"


JACOBIAN_FD = Task(
    name="jacobian_fd",
    title="a Jacobian by finite differences",
    function="jacobian_fd",
    reference=finite_difference_jacobian,
    cases=difference_cases,
    # a one-sided difference with the best step leaves 1e-8 of the scale, some 1e-7 where the curvature is large
    tolerance=Tolerance(1e-5, "a difference with a good step is right to 1e-7 of the scale or better"),
    section="newton-nd: A Jacobian by differences",
    aspects=(
        Aspect("it has a row an equation and a column an unknown, right to 1e-5 of the largest entry", 1.0),
        Aspect("it is as good where the unknowns are large, of the order of 1e8", 0.5, kind="large"),
        Aspect("it evaluates the function at most 2 n + 1 times", 0.5, evaluates_little),
    ),
    variants=(
        Variant(
            "The Jacobian is transposed",
            "A column holds what one unknown does to all equations: along which axis are the columns put together?",
            lambda f, x: finite_difference_jacobian(f, x).T,
            share=0.5,
        ),
        Variant(
            "The difference is divided by h, and spans 2 h",
            "How far apart are the two points?",
            lambda f, x: 2 * finite_difference_jacobian(f, x),
            share=0.5,
        ),
        Variant(
            "The difference has the wrong sign",
            "Which of the two points lies ahead?",
            lambda f, x: -finite_difference_jacobian(f, x),
            share=0.5,
        ),
    ),
)

# --- jacobian_errors --------------------------------------------------------------------------------------------------


def planted_cases(rng: np.random.Generator) -> list[Case]:
    """Right Jacobians with mistakes planted at random places.

    Each row has a right entry that is almost zero, and one row has no positive entry: an entry is judged neither by its
    own size nor by the largest with its sign. The first mistake of each is a small one.
    """

    def planted(n: int, mistakes: int, kind: str, rows: np.ndarray | float = 1.0) -> Case:
        x = rng.uniform(0.3, 1.2, n)
        # |y'| of sin stays away from zero here, so that every planted change can be seen
        a = rng.uniform(0.5, 2, (n, n)) * rng.choice([-1, 1], (n, n))
        row = rng.integers(n)
        a[row] = -np.abs(a[row])
        nearly_zero = rng.integers(n, size=n)
        a[np.arange(n), nearly_zero] = -1e-9
        factor = np.ones((n, n))
        places = rng.permutation([(i, j) for i, j in np.ndindex(n, n) if j != nearly_zero[i]])
        for k, (i, j) in enumerate(places[:mistakes]):
            small = 1 + 0.02 * np.abs(a[i] * np.cos(x)).max() / (a[i, j] * np.cos(x[j]))
            factor[i, j] = rng.choice([-1.0, 0.0, 1.5, 0.7]) if k else small

        def residual(x):
            return (rows * a * np.sin(np.asarray(x, dtype=float))).sum(axis=1)

        def jacobian(x):
            return rows * a * np.cos(np.asarray(x, dtype=float)) * factor

        return Case((residual, jacobian, x), kind=kind, label=f"{mistakes} wrong entries of {n * n}")

    return [
        planted(3, 2, "normal"),
        planted(4, 3, "normal"),
        planted(5, 1, "normal"),
        planted(4, 0, "right"),
        # each equation has units of its own, from the smallest to the largest, and most have a mistake
        planted(4, 8, "units", rows=rng.permutation(np.logspace(-6, 6, 4))[:, None]),
    ]


def same_places(expected: Outcome, got: Outcome) -> str | None:
    """Pairs of indices in any order and any container."""
    match expected, got:
        case _, Lost(why=why):
            return why
        case _, Raised(type=name):
            return f"it raised {name}"
        case Value(value=right), Value(value=answer):
            places = numbers(answer)
            if isinstance(places, str):
                return places
            if places.size and (places.ndim != 2 or places.shape[1] != 2):
                return wrong_shape(places, "(number of wrong entries, 2)")
            if len(places) > 1000 or not (np.isfinite(places) & (places == np.round(places))).all():
                return "it does not name entries by two whole numbers each"
            found, planted = ({tuple(map(int, p)) for p in pairs} for pairs in (places.reshape(-1, 2), right))
            missed, extra = len(planted - found), len(found - planted)
            if not missed and not extra:
                return None
            return f"it misses {missed} of {len(planted)} wrong entries and names {extra} that are right"


JACOBIAN_ERRORS = Task(
    name="jacobian_errors",
    title="verify a Jacobian and name its wrong entries",
    function="jacobian_errors",
    reference=wrong_entries,
    cases=planted_cases,
    agree=same_places,
    tolerance=Tolerance(0.0, "a place is right or wrong"),
    section="newton-nd: Verify a Jacobian",
    aspects=(
        Aspect("it names the wrong entries, and no right one, counted from zero", 1.0),
        Aspect("it names none where the Jacobian is right", 0.5, kind="right"),
        Aspect("it holds in rows of any size: each equation has units of its own", 0.5, kind="units"),
    ),
    variants=(
        Variant(
            "Column and row are exchanged",
            "The first index is the equation's.",
            lambda *args: [(j, i) for i, j in wrong_entries(*args)],
            share=0.5,
        ),
        Variant(
            "The entries are counted from one",
            "Python counts from zero, and so does the task.",
            lambda *args: [(i + 1, j + 1) for i, j in wrong_entries(*args)],
            share=0.5,
        ),
        Variant(
            "Only the first wrong entry is named",
            "There may be more than one.",
            lambda *args: wrong_entries(*args)[:1],
            share=0.25,
        ),
        Variant(
            "The right entries are named",
            "Which side of the comparison are the wrong ones on?",
            lambda f, j, x: [p for p in np.ndindex(j(x).shape) if p not in wrong_entries(f, j, x)],
        ),
    ),
)

# --- basin_map --------------------------------------------------------------------------------------------------------


def cubic(rng: np.random.Generator) -> tuple[Field, Field, np.ndarray]:
    """z^3 = c in two real unknowns: three roots, and a singular Jacobian at the origin."""
    c = rng.uniform(0.7, 1.5) * np.exp(1j * rng.uniform(0, 2 * np.pi))
    angles = (np.angle(c) + 2 * np.pi * np.arange(3)) / 3

    def residual(q):
        q = np.asarray(q)  # a list is as right as an array
        z = (q[..., 0] + 1j * q[..., 1]) ** 3 - c
        return np.stack((z.real, z.imag), axis=-1)

    def jacobian(q):
        q = np.asarray(q)
        dz = 3 * (q[..., 0] + 1j * q[..., 1]) ** 2
        return np.stack((np.stack((dz.real, -dz.imag), axis=-1), np.stack((dz.imag, dz.real), axis=-1)), axis=-2)

    return residual, jacobian, np.abs(c) ** (1 / 3) * np.column_stack((np.cos(angles), np.sin(angles)))


def settled(case: Case) -> np.ndarray:
    """Which seeds lie clear of the boundaries of the basins: a shift of the seed leads to the same root."""
    residual, jacobian, xs, ys, roots = case.args
    maps = [
        basins(residual, jacobian, xs + dx, ys + dy, roots)
        for dx, dy in ((0, 0), (1e-4, 0), (-1e-4, 0), (0, 1e-4), (0, -1e-4))
    ]
    same = np.all([m == maps[0] for m in maps], axis=0)
    return same | np.logical_and.outer(ys == 0, xs == 0)  # at the origin the Jacobian is singular: no root, for certain


def nearest_root(residual, jacobian, xs, ys, roots):
    """The map of somebody who does not iterate."""
    seeds = np.stack(np.meshgrid(xs, ys), axis=-1)
    return np.linalg.norm(seeds[:, :, None] - roots, axis=-1).argmin(axis=-1)


def basin_cases(rng: np.random.Generator) -> list[Case]:
    cases = []
    for nx, ny, known in ((7, 4, 3), (5, 8, 3), (6, 5, 2)):
        leaps = 0
        while leaps < 3:  # seeds from which the iteration leaps over the nearest root
            residual, jacobian, roots = cubic(rng)
            xs, ys = np.sort(rng.uniform(-2, 2, nx)), np.sort(rng.uniform(-2, 2, ny))
            if nx == 6:
                xs[2] = ys[2] = 0.0
            args = (residual, jacobian, xs, ys, roots[:known])
            kind = "none" if nx == 6 else "normal"
            case = Case(args, kind=kind, label=f"{nx} x {ny} seeds, {known} of 3 roots known")
            found = basins(*args)
            leaps = (found != nearest_root(*args))[settled(case)].sum()
            if nx == 6 and (found[2, 1] < 0 or found[1, 2] < 0):
                leaps = 0  # what was found just before the singular point must not pass for what is found there
        cases.append(case)
    return cases


def same_map(trial: Trial, right: Trial) -> str | None:
    expected = right.outcome.value
    found = array(trial, expected.shape, "(len(ys), len(xs))")
    if isinstance(found, str):
        return found
    sure = settled(trial.case)
    wrong = int((found != expected)[sure].sum())
    return f"{wrong} of {int(sure.sum())} seeds lead elsewhere" if wrong else None


BASIN_MAP = Task(
    name="basin_map",
    title="the basins of attraction of two equations in two unknowns",
    function="basin_map",
    reference=basins,
    cases=basin_cases,
    tolerance=Tolerance(0.0, "an index is right or wrong"),
    section="newton-nd: Basins of attraction",
    aspects=(
        Aspect("[j, i] is the index of the root found from (xs[i], ys[j])", 1.5, same_map),
        Aspect("it is -1 where no known root is found, or the Jacobian is singular", 0.5, same_map, kind="none"),
    ),
    variants=(
        Variant(
            "The map is transposed",
            "A map is drawn with x to the right and y upwards: which index counts the rows?",
            lambda *args: basins(*args).T,
            share=0.5,
        ),
        Variant(
            "The roots are counted from one",
            "The index is that of the array of roots.",
            lambda *args: basins(*args) + 1,
            share=0.5,
        ),
        Variant(
            "The root nearest to the seed, and not the one that the iteration finds",
            "Newton-Raphson may leap over the nearest root: iterate first.",
            nearest_root,
        ),
    ),
    seconds=20.0,
)

EXERCISE = Exercise(
    name="02_newton_nd",
    title="Newton-Raphson in several variables",
    tasks=(NEWTON, JACOBIAN_FD, JACOBIAN_ERRORS, BASIN_MAP),
)
