"""Exercise 8: the windscreen wiper, from Grashof's rule to the motion of its blades."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product
from math import cos, hypot, sin

import numpy as np

from autograder.checks.answers import array, arrays, refuses
from autograder.checks.e05_consecutive import TURN, says_where
from autograder.checks.e07_closed_form import BESIDE, by_columns, differences
from autograder.checks.plane import unit
from autograder.compare import Tolerance, difference, disagreement, numbers, wrong_shape
from autograder.outcome import Outcome, Raised, Value
from autograder.spec import Aspect, Case, Exercise, Task, Trial, Variant, readings
from mechlib.grashof import grashof
from mechlib.newton import ConvergenceError, Iteration
from mechlib.wiper import Branch, Wiper

EXACT = Tolerance(1e-9, "two ways to write it differ by round-off", absolute=1e-9)

# --- grashof_class ----------------------------------------------------------------------------------------------------

CLASSES = {"ground": "double-crank", "crank": "crank-rocker", "coupler": "double-rocker", "rocker": "rocker-crank"}
PLACES = tuple(CLASSES)


def compared(shortest, p, q, longest) -> str:
    """Which sum is the larger, as `<`, `=` or `>`; sums that differ by rounding are the same."""
    excess = (shortest + longest) - (p + q)
    return "=" if abs(excess) <= 1e-9 * (p + q) else "<" if excess < 0 else ">"


def classed(
    compare: Callable = compared,
    bars: Callable = sorted,
    deciding: Callable = np.argmin,
    names: dict[str, str] | None = None,
    closes: Callable = lambda longest, others: longest < others,
    positive: bool = True,
) -> Callable:
    """Grashof's rule with one of its parts exchanged."""

    def find(*lengths: float) -> str:
        if positive and min(lengths) <= 0:
            raise ValueError(f"a length of {min(lengths):g}")
        longest = max(lengths)
        if not closes(longest, sum(lengths) - longest):
            raise ValueError(f"a bar of {longest:g} cannot be closed")
        turning = CLASSES[PLACES[int(deciding(lengths))]]
        found = {"<": turning, "=": "change-point", ">": "triple-rocker"}[compare(*bars(lengths))]
        return (names or {}).get(found, found)

    return find


def exactly(equal: str) -> Callable:
    """The two sums as floats; `equal` says what they are taken for where they are the same."""
    return lambda s, p, q, l: equal if s + l == p + q else "<" if s + l < p + q else ">"


def linkage(rng: np.random.Generator, turns: bool) -> list[float]:
    """Four bars from the shortest to the longest, all clearly different, on a clear side of Grashof's rule."""
    while True:
        s, p, q, l = np.sort(rng.uniform(0.05, 0.5, 4))
        excess = (s + l) - (p + q)
        apart = np.diff((s, p, q, l)).min() > 0.01 and l < 0.95 * (s + p + q)
        if apart and (excess < 0) == turns and abs(excess) > 0.01:
            return [s, p, q, l]


def placed(rng: np.random.Generator, bars, shortest: str, unit: float = 1.0) -> tuple[float, ...]:
    """Bars, shortest first, with the shortest in a given place and the others anywhere."""
    others = iter(rng.permutation(bars[1:]))
    return tuple(float(bars[0] if place == shortest else next(others)) * unit for place in PLACES)


def class_cases(rng: np.random.Generator) -> list[Case]:
    def case(lengths: tuple[float, ...], kind: str = "normal") -> Case:
        label = ", ".join(f"{place} {length:.6g}" for place, length in zip(PLACES, lengths, strict=True))
        return Case(lengths, kind=kind, label=label)

    def flat(unit: float, sign: int) -> tuple[float, ...]:
        """Whole millimetres, so that the sums are the same but for the rounding that has this sign."""
        while True:
            s, p, q = sorted(int(n) for n in rng.choice(np.arange(60, 400), 3, replace=False))
            bars = [n / unit for n in (s, p, q, p + q - s)]
            if p - s > 10 and np.sign((bars[0] + bars[3]) - (bars[1] + bars[2])) == sign:
                return placed(rng, bars, rng.choice(PLACES))

    def stretched() -> list[float]:
        """The longest bar is longer than the two middle ones, and the shortest is needed to join them."""
        s, p, q, _ = linkage(rng, True)
        while p < 1.8 * s:
            s, p, q, _ = linkage(rng, True)
        return [s, p, q, p + q + rng.uniform(0.3, 0.7) * s]

    def normal() -> list[tuple[float, ...]]:
        units = rng.permutation([1, 1, 1, 1, 1000, 1000, 1000, 1000])
        turning = [placed(rng, linkage(rng, True), PLACES[k % 4], unit) for k, unit in enumerate(units)]
        others = linkage(rng, False), linkage(rng, False), stretched()
        return turning + [
            placed(rng, bars, place) for bars, place in zip(others, rng.permutation(PLACES), strict=False)
        ]

    plain, unsorted = normal(), classed(bars=in_the_order_of_the_source)
    while not 0 < sum(unsorted(*lengths) == "triple-rocker" for lengths in plain[:8]) < 8:
        plain = normal()
    near = [linkage(rng, True) for _ in range(2)]
    for bars, off in zip(near, (1e-8, -1e-8), strict=True):
        bars[3] = (bars[1] + bars[2]) * (1 + off) - bars[0]
    nothing, less = (rng.permutation([length, *rng.uniform(0.2, 0.3, 3)]) for length in (0.0, -rng.uniform(0.03, 0.06)))
    long = [placed(rng, linkage(rng, True), place) for place in PLACES]
    for k, lengths in enumerate(long):
        others = sum(lengths) - lengths[k]
        long[k] = (*lengths[:k], others * rng.uniform(1.05, 1.5), *lengths[k + 1 :])
    s, p, q = (int(n) for n in rng.choice(np.arange(60, 200), 3, replace=False))
    return [
        *(case(plain[k]) for k in rng.permutation(len(plain))),
        # with a wrong rule the sums that are the same cannot tell how they were compared
        *(case(lengths, "change") for lengths in plain),
        *(case(flat(1000, sign), "change") for sign in (-1, 1)),
        case(flat(1, 0), "change"),
        *(case(placed(rng, bars, rng.choice(PLACES)), "change") for bars in near),
        *(case(lengths, "open") for lengths in long),
        case(placed(rng, [s, p, q, s + p + q], rng.choice(PLACES)), "open"),
        *(case(tuple(map(float, lengths)), "negative") for lengths in (nothing, less)),
    ]


def in_the_order_of_the_source(lengths) -> tuple[float, ...]:
    """As if the crank were the shortest bar and the ground the longest: so it is with source B's lengths."""
    ground, crank, coupler, rocker = lengths
    return crank, coupler, rocker, ground


def same_class(expected: Outcome, got: Outcome) -> str | None:
    if isinstance(expected, Value) and isinstance(got, Value):
        if not isinstance(got.value, str):
            return "it is not one of the six words"
        return None if got.value == expected.value else "it is another class"
    return disagreement(expected, got, EXACT)


def refuses_the_length(of: Callable) -> Callable:
    def fault(trial: Trial, right: Trial) -> str | None:
        if isinstance(trial.outcome, Value):
            return "it returned a value where ValueError is right"
        return refuses(lambda *lengths: (of(lengths),), EXACT)(trial, right)

    return fault


GRASHOF_CLASS = Task(
    name="grashof_class",
    title="the class of a four-bar linkage by Grashof's rule",
    function="grashof_class",
    reference=grashof,
    cases=class_cases,
    agree=same_class,
    tolerance=EXACT,
    section="wiper-kinematics: Grashof's rule",
    aspects=(
        Aspect("the class of linkages in which a bar turns round, and of those in which none does", 1.0),
        Aspect(
            "a change point is recognised in spite of rounding, and nothing else is taken for one", 0.5, None, "change"
        ),
        Aspect(
            "it raises ValueError, with the longest length, where the bars cannot be joined",
            0.25,
            refuses_the_length(max),
            kind="open",
        ),
        Aspect(
            "it raises ValueError, with the length, where one is not positive",
            0.25,
            refuses_the_length(min),
            kind="negative",
        ),
    ),
    variants=(
        Variant(
            "The place of the shortest bar is ignored",
            "The rule says that a bar turns round. Which one, and beside which others?",
            classed(names=dict.fromkeys(CLASSES.values(), "crank-rocker")),
            share=0.25,
        ),
        Variant(
            "The place of the longest bar decides",
            "Which bar turns round: the shortest, or the longest?",
            classed(deciding=np.argmax),
            share=0.25,
        ),
        Variant(
            "The shortest and the longest bar are not compared together with the other two",
            "The two extremes are on one side of the inequality, the two between them on the other.",
            classed(bars=lambda lengths: [sorted(lengths)[k] for k in (0, 2, 3, 1)]),
            share=0.25,
        ),
        Variant(
            "The bars are not sorted: the crank is taken for the shortest and the ground for the longest",
            "So it is in source B's wiper. In the rule the bars stand by their lengths.",
            classed(bars=in_the_order_of_the_source),
            share=0.25,
        ),
        Variant(
            "The inequality is turned round",
            "If the longest bar is very long, can anything still turn round?",
            classed(lambda *bars: {"<": ">", ">": "<", "=": "="}[compared(*bars)]),
            share=0.25,
        ),
        Variant(
            "Double-crank and double-rocker are exchanged",
            "If the ground is the shortest bar, which bars turn round beside it?",
            classed(names={"double-crank": "double-rocker", "double-rocker": "double-crank"}),
            share=0.5,
        ),
        Variant(
            "Crank-rocker and rocker-crank are exchanged",
            "The first word is for the bar that is driven.",
            classed(names={"crank-rocker": "rocker-crank", "rocker-crank": "crank-rocker"}),
            share=0.5,
        ),
        Variant(
            "A rocker-crank is called a crank-rocker",
            "Both bars at the ground may be the shortest. Does it matter which of them is driven?",
            classed(names={"rocker-crank": "crank-rocker"}),
            share=0.5,
        ),
        Variant(
            "A triple-rocker is called a double-rocker",
            "In a double-rocker the coupler still turns round. What turns where the rule does not hold?",
            classed(names={"triple-rocker": "double-rocker"}),
            share=0.5,
        ),
        Variant(
            "The two sums must be equal to the last digit",
            "0.1 + 0.2 == 0.3 is false: how near must two sums of floats be?",
            classed(exactly("=")),
            share=0.5,
            kind="change",
        ),
        Variant(
            "Sums that are not the same are taken for a change point",
            "`np.isclose` has tolerances of its own: which ones does the task ask for?",
            classed(lambda s, p, q, l: "=" if np.isclose(s + l, p + q) else "<" if s + l < p + q else ">"),
            share=0.5,
            kind="change",
        ),
        *readings(
            "A change point is given another class",
            "What if the two sums are the same?",
            classed(exactly("<")),
            classed(exactly(">")),
            classed(lambda *bars: "<" if compared(*bars) == "=" else compared(*bars)),
            classed(lambda *bars: ">" if compared(*bars) == "=" else compared(*bars)),
            share=0.5,
            kind="change",
        ),
        Variant(
            "Bars that cannot be joined get a class",
            "Can a bar reach its joint if it is longer than the other three together?",
            classed(closes=lambda *_: True),
            share=0.75,
            kind="open",
        ),
        Variant(
            "Bars that can only lie flat get a class",
            "A bar that is as long as the other three together joins them in one line, and nothing moves.",
            classed(closes=lambda longest, others: longest <= others),
            share=0.75,
            kind="open",
        ),
        Variant(
            "A length that is not positive gets a class",
            "A bar of no length is no bar.",
            classed(positive=False),
            share=0.75,
            kind="negative",
        ),
    ),
)

# --- wiper_positions --------------------------------------------------------------------------------------------------

SEED = np.deg2rad([55.0, 125.0])  # source B
Positions = tuple[np.ndarray, np.ndarray]


def random_wiper(rng: np.random.Generator) -> Wiper:
    """Lengths near those of source B: a crank-rocker whose transmission angle is 25 degrees or more."""
    while True:
        r0, r1, r2, r3, r4, r5, r6 = rng.uniform(0.85, 1.15, 7) * [0.245, 0.105, 0.22, 0.15, 0.3, 0.3, 0.645]
        apart = r0 + np.array([-r1, r1])
        between = np.abs(r2**2 + r3**2 - apart**2) / (2 * r2 * r3)
        wiper = Wiper(r0, r1, r2, r3, r4, r5, r6)
        if between.max() < np.cos(np.deg2rad(25)) and wiper.grashof == "crank-rocker":
            return wiper


def lengths_of(wiper: Wiper, count: int = 4) -> tuple[float, ...]:
    return tuple(float(getattr(wiper, f"r{k}")) for k in range(count))


def words(wiper: Wiper, count: int = 4) -> str:
    return ", ".join(f"r{k} = {length:.4g}" for k, length in enumerate(lengths_of(wiper, count))) + " m"


def equations(lengths) -> Callable:
    """By how much the loop is open, at one position or at many."""
    r0, r1, r2, r3 = lengths

    def residual(q, theta1):
        theta2, theta3 = np.transpose(q)
        x = r0 - r1 * np.cos(theta1) - r2 * np.cos(theta2) + r3 * np.cos(theta3)
        return np.array((x, r1 * np.sin(theta1) + r2 * np.sin(theta2) - r3 * np.sin(theta3))).T

    return residual


def of_the_loop(q, lengths) -> np.ndarray:
    """The Jacobian; it does not depend on theta1. Shape (2, 2) of one position, (2, 2, points) of many."""
    (theta2, theta3), (_, _, r2, r3) = np.transpose(q), lengths
    return np.array([[r2 * np.sin(theta2), -r3 * np.sin(theta3)], [r2 * np.cos(theta2), -r3 * np.cos(theta3)]])


def at_one_point(q, start, lengths) -> tuple[tuple[float, float], ...]:
    """The same in plain floats, several times faster."""
    (theta2, theta3), (_, _, r2, r3) = q, lengths
    return (r2 * sin(theta2), -r3 * sin(theta3)), (r2 * cos(theta2), -r3 * cos(theta3))


def by_cramer(matrix, right) -> np.ndarray:
    """The solution of two equations, at one point or at many."""
    ((a, b), (c, d)), (e, f) = matrix, right
    return np.array([d * e - b * f, a * f - c * e]) / (a * d - b * c)


def iterated(
    residual,
    theta1,
    lengths,
    seed,
    tol=1e-9,
    warm=False,
    jacobian: Callable = at_one_point,
    most: int = 50,
    on_the_step: bool = False,
) -> Positions:
    """Newton-Raphson at every crank angle, with one of its parts exchanged."""
    found, counts = [], []
    for k, angle in enumerate(theta1):
        start = q = np.array(found[-1] if warm and found else seed, dtype=float)
        step = np.full(2, np.inf)
        for count in range(most + 1):
            gap = np.asarray(residual(q, angle))
            if hypot(*(step if on_the_step else gap)) < tol or most == count == 1:
                break
            if count == most:
                raise ConvergenceError(f"point {k}: the loop is still open", Iteration(q[None], gap, False))
            step = by_cramer(jacobian(q, start, lengths), gap)
            q = q - step
        found.append(q)
        counts.append(count)
    return np.array(found), np.array(counts)


def with_jacobian(jacobian: Callable) -> Callable:
    """A few steps with another matrix, at two angles: a path shows no more."""
    return lambda residual, theta1, *rest: iterated(residual, theta1[:2], *rest, jacobian=jacobian, most=5)


@lru_cache(4)
def known(theta1: tuple[float, ...], lengths, seed: tuple[float, ...], *rest) -> Positions:
    return iterated(equations(lengths), theta1, lengths, seed, *rest)


def changed(change: Callable) -> Callable:
    """Right positions and counts that are changed when all is done; they are worked out once for all such mistakes."""
    return lambda residual, theta1, lengths, seed, *rest: change(*known(tuple(theta1), lengths, tuple(seed), *rest))


SIGNS = [np.array(signs).reshape(2, 2) for signs in product((1, -1), repeat=4) if 0 < signs.count(-1) < 3]


def clear(wiper: Wiper, theta1, seed, tol: float, warm: bool) -> Positions | None:
    """The right answer, if it is on the turn of the seed and on one branch throughout."""
    residual = equations(lengths_of(wiper))
    try:
        q, counts = iterated(residual, theta1, lengths_of(wiper), seed, tol, warm)
    except ConvergenceError:
        return None
    near = np.abs(q - seed).max() < np.pi
    return (q, counts) if counts.max() < 9 and near and len({*wiper.branch(q)}) == 1 else None


def turning(rng: np.random.Generator, n: int, turned: float) -> np.ndarray:
    return rng.uniform(-TURN, TURN) + rng.choice([-1, 1]) * np.linspace(0, turned, n)


def fixed_case(rng: np.random.Generator, branch: Branch, tol: float, turns=(0, 0)) -> Case:
    """A turn of the crank from one seed; a loose tol leaves something to be seen of when it stops."""
    while True:
        wiper, theta1 = random_wiper(rng), turning(rng, int(rng.integers(6, 9)), rng.uniform(0.8, 0.85) * TURN)
        q = wiper.position(theta1, branch)
        seed = q.mean(axis=0) + rng.uniform(0.05, 0.2, 2) * rng.choice([-1, 1], 2) + TURN * np.array(turns)
        answer = clear(wiper, theta1, seed, tol, warm=False)
        if tol < 1e-6:  # one that starts from the position before takes other numbers of steps
            warm = answer and clear(wiper, theta1, seed, tol, warm=True)
            shows = warm is None or (warm[1] != answer[1]).any()
        else:
            shows = answer and np.abs(answer[0] - TURN * np.array(turns) - q).max() > 1e-6
        if answer and shows:
            label = f"{len(theta1)} crank angles, {words(wiper)}, the {branch} branch, tol = {tol:.1e}"
            return Case((equations(lengths_of(wiper)), theta1, lengths_of(wiper), seed, tol), label=label)


def warm_case(rng: np.random.Generator) -> Case:
    """More than a turn of the crank, and a seed that is near at its beginning alone."""
    while True:
        wiper, theta1 = random_wiper(rng), turning(rng, int(rng.integers(13, 16)), rng.uniform(1.0, 1.1) * TURN)
        branch = rng.choice(["open", "crossed"])
        seed = wiper.position(theta1[0], branch) + rng.uniform(0.1, 0.3, 2) * rng.choice([-1, 1], 2)
        tol = float(10 ** rng.uniform(-9, -8))
        answer, cold = (clear(wiper, theta1, seed, tol, warm) for warm in (True, False))
        if answer and cold and (cold[1] != answer[1]).sum() > 2:
            label = f"{len(theta1)} crank angles, {words(wiper)}, the {branch} branch, each from the one before"
            return Case(
                (equations(lengths_of(wiper)), theta1, lengths_of(wiper), seed, tol, True), kind="warm", label=label
            )


def open_case(rng: np.random.Generator, warm: bool) -> Case:
    """A coupler and a rocker that are too short for the crank when it points away from C."""
    while True:
        wiper = random_wiper(rng)
        wiper = replace(wiper, r2=(wiper.r0 + wiper.r1) * rng.uniform(0.9, 0.97) - wiper.r3)
        theta1 = (np.linspace(0.3, np.pi, 18) + rng.uniform(0, 0.05)) * rng.choice([-1, 1])
        gaps = wiper.gap(theta1)
        first = int(np.argmax(gaps > 0))
        # no number of iterations is taken for the index, and each angle is clearly on one side
        if first > 8 and np.abs(gaps[first - 1 : first + 1]).min() > 1e-3 and (gaps[first:] > 0).all():
            q = wiper.position(theta1[:first], "open")
            seed = (q[0] if warm else q.mean(axis=0)) + rng.uniform(-0.05, 0.05, 2)
            if clear(wiper, theta1[:first], seed, 1e-9, warm):
                args = (equations(lengths_of(wiper)), theta1, lengths_of(wiper), seed, 1e-9, warm)
                how = "the position before" if warm else "the seed"
                return Case(args, kind="open", label=f"a linkage that opens on the way, from {how}, {words(wiper)}")


def wiper_cases(rng: np.random.Generator) -> list[Case]:
    return [
        fixed_case(rng, "open", float(10 ** rng.uniform(-4, -3)), rng.permutation([0, rng.choice([-1, 1])])),
        fixed_case(rng, "crossed", float(10 ** rng.uniform(-9, -8))),
        warm_case(rng),
        open_case(rng, warm=True),
        open_case(rng, warm=False),
    ]


def named(outcome: Outcome, right: Outcome, *names: str) -> tuple[np.ndarray, ...] | str:
    """The arrays of an answer in several parts that have these names."""
    shapes = {name: np.shape(part) for name, part in zip(names, right.value, strict=True)}
    return arrays(outcome, shapes, f"({', '.join(names)})")


def same_parts(*names: str) -> Callable:
    """Whether all parts of two answers are the same; of a known mistake, nan stands for whatever came."""

    def disagree(expected: Outcome, got: Outcome) -> str | None:
        if not (isinstance(expected, Value) and isinstance(got, Value)):
            return disagreement(expected, got, EXACT)
        found = named(got, expected, *names)
        if isinstance(found, str):
            return found
        for name, right, answer in zip(names, expected.value, found, strict=True):
            if why := difference(right, np.where(np.isnan(right), np.nan, answer), EXACT):
                return f"{name}: {why}"
        return None

    return disagree


POSITIONS = ("positions", "iterations")


def closes(trial: Trial, right: Trial) -> str | None:
    """Whether the bars meet, drawn from their lengths and angles alone."""
    found = named(trial.outcome, right.outcome, *POSITIONS)
    if isinstance(found, str):
        return found
    _, theta1, (r0, r1, r2, r3), _, tol, *_ = trial.case.args
    theta2, theta3 = found[0].T
    gap = np.abs(r1 * unit(theta1) + r2 * unit(theta2) - r0 - r3 * unit(theta3))
    side = np.sin(right.outcome.value[0] @ [-1, 1])
    turned = found[0] - right.outcome.value[0]
    looked_for = (
        (gap < tol * (1 + 1e-6), "coupler and rocker are further apart than tol"),
        (np.sin(theta3 - theta2) * side > 0, "it is the other branch"),
        (np.abs(turned).max(axis=-1) < 1, "an angle is not on the turn of the seed"),
    )
    for holds, fault in looked_for:
        if not holds.all():
            return f"{fault} at index {int(np.argmin(holds))}"
    return None


def counts_its_steps(trial: Trial, right: Trial) -> str | None:
    found = named(trial.outcome, right.outcome, *POSITIONS)
    if isinstance(found, str):
        return found
    more = found[1] - right.outcome.value[1]
    if not more.any():
        return None
    k = int(np.argmax(more != 0))
    return (
        f"at index {k} there are {abs(more[k]):g} {'more' if more[k] > 0 else 'fewer'} steps than Newton-Raphson takes"
    )


def starts_where_asked(trial: Trial, right: Trial) -> str | None:
    return closes(trial, right) or counts_its_steps(trial, right)


def last_iterate(residual, theta1, *rest) -> Positions:
    """Right as far as the linkage closes; where a lost iteration ends is chance, and what is begun there as well."""
    for closed in range(len(theta1), 0, -1):
        try:
            found = iterated(residual, theta1[:closed], *rest)
        except ConvergenceError:
            continue
        q, counts = (np.full((len(theta1), *part.shape[1:]), np.nan) for part in found)
        q[:closed], counts[:closed] = found
        return q, counts
    return np.full((len(theta1), 2), np.nan), np.full(len(theta1), np.nan)


def wrapped_to(low: float) -> Callable:
    return changed(lambda q, counts: ((q - low) % TURN + low, counts))


WIPER_POSITIONS = Task(
    name="wiper_positions",
    title="theta2 and theta3 by Newton-Raphson, at many crank angles",
    function="wiper_positions",
    reference=iterated,
    cases=wiper_cases,
    agree=same_parts(*POSITIONS),
    tolerance=EXACT,
    section="wiper-kinematics: Where the bars are",
    aspects=(
        Aspect("the linkage is closed to tol at every angle, on the branch and the turn of the seed", 1.0, closes),
        Aspect("it takes Newton's steps until the residual is below tol, and counts them", 0.75, counts_its_steps),
        Aspect("with warm=True each angle starts from the position before it", 0.75, starts_where_asked, "warm"),
        Aspect("it raises ArithmeticError, with the index, where the linkage cannot close", 0.5, says_where, "open"),
    ),
    variants=(
        Variant(
            "The step has the wrong sign",
            "J d = F gives the step that must be taken from q.",
            with_jacobian(lambda q, start, lengths: -of_the_loop(q, lengths)),
            by_path=True,
        ),
        Variant(
            "The Jacobian is transposed",
            "Row i belongs to equation i: which index is the unknown's?",
            with_jacobian(lambda q, start, lengths: of_the_loop(q, lengths).T),
            by_path=True,
        ),
        Variant(
            "The Jacobian of the seed is used in every step",
            "Where must the Jacobian be evaluated in each step?",
            with_jacobian(lambda q, start, lengths: of_the_loop(start, lengths)),
            share=0.25,
            by_path=True,
        ),
        *readings(
            "A sign of the Jacobian is wrong",
            "Differentiate each of the two equations by theta2, and then by theta3: four terms, four signs.",
            *(with_jacobian(lambda q, start, lengths, s=s: s * of_the_loop(q, lengths)) for s in SIGNS),
            by_path=True,
        ),
        Variant(
            "Sine and cosine are exchanged in the Jacobian",
            "What is the derivative of a cosine?",
            with_jacobian(lambda q, start, lengths: of_the_loop(np.pi / 2 - q, lengths)),
            by_path=True,
        ),
        Variant(
            "The lengths of coupler and rocker are exchanged in the Jacobian",
            "Which length turns with theta2?",
            with_jacobian(lambda q, start, lengths: of_the_loop(q, np.array(lengths)[[0, 1, 3, 2]])),
            by_path=True,
        ),
        Variant(
            "The angles of the Jacobian are taken for degrees",
            "They are in radians, and NumPy wants radians.",
            with_jacobian(lambda q, start, lengths: of_the_loop(np.deg2rad(q), lengths)),
            by_path=True,
        ),
        Variant(
            "The crank angle is taken for degrees",
            "theta1 comes in radians: it needs no conversion.",
            lambda residual, theta1, *rest: iterated(residual, np.deg2rad(theta1[:2]), *rest),
            by_path=True,
        ),
        Variant(
            "The seed is taken for degrees",
            "The seed comes in radians: it needs no conversion.",
            lambda residual, theta1, lengths, seed, *rest: iterated(
                residual, theta1[:2], lengths, np.deg2rad(seed), *rest, most=5
            ),
            by_path=True,
        ),
        Variant(
            "The seed of source B is used, whatever seed is given",
            "The branch that is wanted is that of the argument `seed`.",
            lambda residual, theta1, lengths, seed, *rest: iterated(residual, theta1[:2], lengths, SEED, *rest, most=5),
            share=0.25,
            by_path=True,
        ),
        Variant(
            "theta3 and theta2 are exchanged in the seed, which leads to the other branch",
            "The seed holds theta2 first.",
            lambda residual, theta1, lengths, seed, *rest: iterated(
                residual, theta1[:2], lengths, seed[::-1], *rest, most=5
            ),
            by_path=True,
        ),
        Variant(
            "A single step is taken",
            "One step solves a linear system. Are the position equations linear?",
            lambda *args: iterated(*args, most=1),
        ),
        Variant(
            "It stops when the step is small, and not when the residual is",
            "Here tol is a length: it bounds by how much the loop is open. Exercise 5 bounded the step.",
            lambda *args: iterated(*args, on_the_step=True),
            share=0.5,
        ),
        Variant(
            "The tolerance of source B is used, whatever tol is given",
            "Is the argument `tol` used?",
            lambda residual, theta1, lengths, seed, tol, *rest: iterated(residual, theta1, lengths, seed, 1e-9, *rest),
            share=0.5,
        ),
        Variant(
            "There is one iteration too many in the count",
            "A look at the residual is no step: how many steps are taken from the seed?",
            changed(lambda q, counts: (q, counts + 1)),
            share=0.5,
        ),
        Variant(
            "There is one iteration too few in the count",
            "Where does the count begin, and is the last step counted?",
            changed(lambda q, counts: (q, counts - 1)),
            share=0.5,
        ),
        Variant(
            "The count goes on from one angle to the next",
            "How many steps does each angle need of its own?",
            changed(lambda q, counts: (q, np.cumsum(counts))),
            share=0.5,
        ),
        Variant(
            "theta3 comes first",
            "In which order does the task ask for the two?",
            changed(lambda q, counts: (q[:, ::-1], counts)),
            share=0.5,
        ),
        Variant(
            "Rows and columns are exchanged",
            "A row holds one position.",
            changed(lambda q, counts: (q.T, counts)),
            share=0.5,
        ),
        Variant(
            "The iterations come first, and the positions second",
            "In which order does the task ask for them?",
            changed(lambda q, counts: (counts, q)),
            share=0.5,
        ),
        Variant(
            "The angles are returned in degrees",
            "Angles are in rad until they are plotted.",
            changed(lambda q, counts: (np.rad2deg(q), counts)),
            share=0.5,
        ),
        Variant(
            "The angles are brought into one turn, from 0 to 2 pi",
            "Newton-Raphson stays on the turn of its seed, and an angle that does not leap can be differentiated.",
            wrapped_to(0.0),
            share=0.5,
        ),
        Variant(
            "The angles are brought into one turn, from -pi to pi",
            "Newton-Raphson stays on the turn of its seed, and an angle that does not leap can be differentiated.",
            wrapped_to(-np.pi),
            share=0.5,
        ),
        Variant(
            "Every angle starts from the position before, whatever `warm` says",
            "With warm=False each angle starts from the seed, as source B's program does.",
            lambda residual, theta1, lengths, seed, tol, warm=False: iterated(
                residual, theta1, lengths, seed, tol, True
            ),
            share=0.5,
        ),
        Variant(
            "Every angle starts from the seed, whatever `warm` says",
            "With warm=True only the first angle starts from the seed.",
            lambda residual, theta1, lengths, seed, tol, warm=False: iterated(residual, theta1, lengths, seed, tol),
            share=0.5,
            kind="warm",
        ),
        Variant(
            "Where the linkage cannot close, the last iterate is returned",
            "When the steps run out, what is wrong with the position that is left?",
            last_iterate,
            share=0.75,
            kind="open",
        ),
    ),
)

# --- wiper_rates ------------------------------------------------------------------------------------------------------

SLOPE = Tolerance(1e-6, "differences over two steps to each side are right to 1e-7 of the scale here", absolute=1e-6)
STEP = 5e-4  # s
DEAD = 1e-6  # the sine of the angle between coupler and rocker


def refuse_open(q, crank, lengths) -> None:
    gap = np.linalg.norm(equations(lengths)(q, crank[0]), axis=-1)
    if gap.max() > 1e-6:
        raise ValueError(f"the position at index {gap.argmax()} leaves the loop open by {gap.max():.3g} m")


def is_dead(q) -> np.ndarray:
    return np.abs(np.sin(q[:, 1] - q[:, 0])) < DEAD


def refuse_dead(q, *_) -> None:
    if is_dead(q).any():
        raise ValueError(f"a dead point at index {is_dead(q).argmax()}")


def refuse(q, crank, lengths) -> None:
    refuse_open(q, crank, lengths)
    refuse_dead(q)


@dataclass(frozen=True)
class Rates:
    """Velocities and accelerations by two linear solves, with one of the parts exchanged.

    The centripetal terms are pairs, one factor for each of the two equations: 1 is right.
    """

    crank: tuple[float, float] = (1, 1)
    coupler: tuple[float, float] = (1, 1)
    rocker: tuple[float, float] = (1, 1)
    driven: float = 1  # alpha1
    signs: tuple[float, float] = (1, 1)  # of the right sides of velocities and accelerations
    jacobian: Callable = of_the_loop
    arm: Callable = lambda theta1: (np.sin(theta1), np.cos(theta1))
    refuses: Callable = refuse

    def __call__(self, q, crank, lengths) -> np.ndarray:
        self.refuses(q, crank, lengths)
        (theta1, omega1, alpha1), (_, r1, r2, r3) = crank, lengths
        matrix, (theta2, theta3) = self.jacobian(q, lengths), q.T
        v = by_cramer(matrix, -self.signs[0] * r1 * omega1 * np.array(self.arm(theta1)))
        n1, n2, n3 = r1 * omega1**2, *(np.array([[r2], [r3]]) * v**2)
        t1 = self.driven * r1 * alpha1
        known = [
            t1 * np.sin(theta1)
            + self.crank[0] * n1 * np.cos(theta1)
            + self.coupler[0] * n2 * np.cos(theta2)
            - self.rocker[0] * n3 * np.cos(theta3),
            t1 * np.cos(theta1)
            - self.crank[1] * n1 * np.sin(theta1)
            - self.coupler[1] * n2 * np.sin(theta2)
            + self.rocker[1] * n3 * np.sin(theta3),
        ]
        return np.stack((v.T, by_cramer(matrix, -self.signs[1] * np.array(known)).T))


RIGHT = Rates()


def in_one_or_both(factor: float, *terms: str) -> tuple[Rates, ...]:
    """A factor of centripetal terms in both equations, or in one of them."""
    return tuple(replace(RIGHT, **dict.fromkeys(terms, pair)) for pair in ((factor, factor), (factor, 1), (1, factor)))


def rates_cases(rng: np.random.Generator) -> list[Case]:
    def case(wiper: Wiper, theta1, q, kind: str = "normal", what: str = "") -> Case:
        n = len(theta1)
        omega1 = rng.uniform(2, 9, n) * rng.choice([-1, 1], n)
        alpha1 = rng.uniform(20, 60, n) * rng.choice([-1, 1], n)
        label = f"{n} point{'s' * (n > 1)}{what}, {words(wiper)}"
        return Case((q, np.stack((theta1, omega1, alpha1)), lengths_of(wiper)), kind=kind, label=label)

    def closed(n: int, branch: Branch, **more) -> Case:
        wiper, theta1 = random_wiper(rng), rng.uniform(-TURN, 2 * TURN, n)
        return case(wiper, theta1, wiper.position(theta1, branch), **more)

    opened = closed(int(rng.integers(6, 9)), "open", kind="open", what=", one of them open")
    q, _, lengths = opened.args
    k = int(rng.integers(3, len(q)))
    q[k] += by_cramer(of_the_loop(q[k], lengths), rng.uniform(1e-5, 1e-4, 2) * rng.choice([-1, 1], 2))

    def dead(stretched: bool, off: float, what: str) -> Case:
        """One point at which coupler and rocker are in line but for a small angle, among others."""
        while True:
            r0, r2, r3 = rng.uniform(0.2, 0.3), rng.uniform(0.18, 0.25), rng.uniform(0.12, 0.16)
            theta2 = rng.uniform(-np.pi, np.pi)
            theta3 = theta2 + np.pi * stretched + off
            pin = r0 + r3 * unit(theta3) - r2 * unit(theta2)
            wiper, theta1 = Wiper(r0, abs(pin), r2, r3), rng.uniform(-np.pi, np.pi, 40)
            theta1 = theta1[wiper.gap(theta1) < -0.02][:8]
            if len(theta1) < 8:
                continue
            q, k = wiper.position(theta1), int(rng.integers(3, 8))
            q[k], theta1[k] = (theta2, theta3), np.angle(pin)
            return case(wiper, theta1, q, "dead", what)

    return [
        closed(120, "open"),
        closed(1, "crossed"),
        opened,
        *(dead(bool(k), off, ", one of them dead") for k, off in enumerate(rng.permutation([-4e-7, 4e-7]))),
        dead(bool(rng.integers(2)), rng.choice([-3e-4, 3e-4]), ", one of them nearly dead"),
    ]


def by_differences(q, crank, lengths) -> np.ndarray:
    """Velocities and accelerations from closed positions at five instants, without an equation for them."""
    theta1, omega1, alpha1 = crank
    wiper = Wiper(*lengths)
    t = STEP * np.array([0, *BESIDE])[:, None]
    five = wiper.position(theta1 + omega1 * t + alpha1 * t**2 / 2, wiper.branch(q)[0])
    return np.stack(differences(np.unwrap(five, axis=0), STEP))


RATES = (("omega2", "omega3"), ("alpha2", "alpha3"))


def is_the_slope(level: int) -> Callable:
    """Whether the velocities (level 0) or accelerations (1) are time derivatives of the positions."""

    def fault(trial: Trial, right: Trial) -> str | None:
        got = array(trial, right.outcome.value.shape, "(2, points, 2)")
        if isinstance(got, str):
            return got
        return by_columns(by_differences(*trial.case.args)[level], got[level], RATES[level], SLOPE)

    return fault


def index_of_the_wrong(q, crank, lengths) -> tuple[int, int]:
    """The index of the point that is open or dead, counted from zero or from one."""
    gap = np.linalg.norm(equations(lengths)(q, crank[0]), axis=-1)
    k = int(gap.argmax() if gap.max() > 1e-6 else np.abs(np.sin(q[:, 1] - q[:, 0])).argmin())
    return k, k + 1


def refuses_dead_points_alone(trial: Trial, right: Trial) -> str | None:
    if isinstance(right.outcome, Raised):
        return refuses(index_of_the_wrong, SLOPE)(trial, right)
    return "it refuses what is no dead point" if isinstance(trial.outcome, Raised) else None


def same_rates(expected: Outcome, got: Outcome) -> str | None:
    """Each of the four is held to its own scale; of a known mistake, nan stands for whatever came."""
    if not (isinstance(expected, Value) and isinstance(got, Value)):
        return disagreement(expected, got, SLOPE)
    right, answer = np.asarray(expected.value), numbers(got.value)
    if isinstance(answer, str):
        return answer
    if answer.shape != right.shape:
        return wrong_shape(answer, right.shape)
    scale = np.abs(right).max(axis=1, keepdims=True)
    return None if (~(np.abs(answer - right) > SLOPE.relative * scale) | np.isnan(right)).all() else "it is off"


def at_degrees(q, crank, lengths) -> np.ndarray:
    refuse(q, crank, lengths)
    return replace(RIGHT, refuses=refuse_dead)(q, (np.deg2rad(crank[0]), *crank[1:]), lengths)


def also_in_dead_points(q, *rest) -> np.ndarray:
    """Without a look at the angle between coupler and rocker; what comes of a division by nothing is chance."""
    return np.where(is_dead(q)[:, None], np.nan, replace(RIGHT, refuses=refuse_open)(q, *rest))


TERM = "Differentiate the velocity equation of each row by hand, term by term, and compare."

WIPER_RATES = Task(
    name="wiper_rates",
    title="angular velocities and accelerations by two linear solves, for all points",
    function="wiper_rates",
    reference=RIGHT,
    cases=rates_cases,
    agree=same_rates,
    tolerance=SLOPE,
    section="wiper-kinematics: How fast they move",
    aspects=(
        Aspect("the angular velocities, at one point or many", 1.0, is_the_slope(0)),
        Aspect("the angular accelerations, at one point or many", 1.25, is_the_slope(1)),
        Aspect(
            "it raises ValueError, with the index, where a position does not close the loop",
            0.25,
            refuses(index_of_the_wrong, SLOPE),
            kind="open",
        ),
        Aspect(
            "it raises ValueError, with the index, in a dead point, and not near one",
            0.5,
            refuses_dead_points_alone,
            kind="dead",
        ),
    ),
    variants=(
        *(
            variant
            for bar in ("crank", "coupler", "rocker")
            for variant in (
                *readings(
                    f"The centripetal term of the {bar} is forgotten", TERM, *in_one_or_both(0, bar), share=1 / 3
                ),
                *readings(
                    f"The centripetal term of the {bar} has the wrong sign", TERM, *in_one_or_both(-1, bar), share=1 / 3
                ),
            )
        ),
        Variant(
            "The centripetal terms are forgotten, or their angular velocities are not squared",
            "Look at their units. Without the squares they are a row of the velocity equations: what is their sum?",
            in_one_or_both(0, "crank", "coupler", "rocker")[0],
            share=1 / 3,
        ),
        Variant("The angular acceleration of the crank is forgotten", TERM, replace(RIGHT, driven=0), share=1 / 3),
        Variant(
            "The right side of the velocities has the wrong sign",
            "J v + F_u omega1 = 0: what stands on the right of J v?",
            lambda *args: RIGHT(*args) * [[[-1]], [[1]]],
            share=0.25,
        ),
        Variant(
            "The right side of the accelerations has the wrong sign",
            "J a + gamma = 0: what stands on the right of J a?",
            replace(RIGHT, signs=(1, -1)),
            share=1 / 3,
        ),
        Variant(
            "The right sides of both systems have the wrong sign",
            "What does not hold the unknown goes to the other side of the equation.",
            replace(RIGHT, signs=(-1, -1)),
            share=0.25,
        ),
        *readings(
            "A sign of the Jacobian is wrong",
            "Differentiate each of the two equations by theta2, and then by theta3: four terms, four signs.",
            *(replace(RIGHT, jacobian=lambda q, lengths, s=s: s[..., None] * of_the_loop(q, lengths)) for s in SIGNS),
        ),
        Variant(
            "The Jacobian is transposed",
            "Row i belongs to equation i: which index is the unknown's?",
            replace(RIGHT, jacobian=lambda q, lengths: of_the_loop(q, lengths).swapaxes(0, 1)),
        ),
        Variant(
            "Sine and cosine are exchanged in the Jacobian",
            "What is the derivative of a cosine?",
            replace(RIGHT, jacobian=lambda q, lengths: of_the_loop(np.pi / 2 - q, lengths)),
        ),
        Variant(
            "Sine and cosine of the crank are exchanged in the velocity equations",
            "What is the derivative of a cosine?",
            replace(RIGHT, arm=lambda theta1: (np.cos(theta1), np.sin(theta1))),
        ),
        Variant(
            "The lengths of coupler and rocker are exchanged in the Jacobian",
            "Which length turns with theta2?",
            replace(RIGHT, jacobian=lambda q, lengths: of_the_loop(q, np.array(lengths)[[0, 1, 3, 2]])),
        ),
        Variant(
            "The crank angle is taken for degrees",
            "theta1 comes in radians: it needs no conversion.",
            at_degrees,
        ),
        Variant(
            "The angular velocity of the crank is taken as 1 rad/s",
            "A velocity for omega1 = 1 is a velocity ratio: what drives the crank?",
            lambda q, crank, lengths: RIGHT(q, (crank[0], np.ones_like(crank[1]), crank[2]), lengths),
            share=0.25,
        ),
        Variant(
            "The angular velocity of the crank is taken for revolutions per minute",
            "omega1 comes in rad/s: it needs no conversion.",
            lambda q, crank, lengths: RIGHT(q, (crank[0], crank[1] * TURN / 60, crank[2]), lengths),
            share=0.25,
        ),
        Variant(
            "The angular rates are returned in degrees",
            "Angles are in rad until they are plotted.",
            lambda *args: np.rad2deg(RIGHT(*args)),
            share=0.5,
        ),
        Variant(
            "The velocities are returned where the accelerations are asked for",
            "The second solve has a right side of its own.",
            lambda *args: RIGHT(*args)[[0, 0]],
            share=1 / 3,
        ),
        Variant(
            "Velocities and accelerations are exchanged",
            "The first entry holds the velocities.",
            lambda *args: RIGHT(*args)[::-1],
            share=0.5,
        ),
        Variant(
            "The rates of theta3 come first",
            "In which order does the task ask for the two?",
            lambda *args: RIGHT(*args)[..., ::-1],
            share=0.5,
        ),
        Variant(
            "The points are along the last axis",
            "The shape is (2, points, 2): the two unknowns are at the end.",
            lambda *args: RIGHT(*args).swapaxes(1, 2),
            share=0.5,
        ),
        Variant(
            "Positions that leave the loop open get rates",
            "What do velocities mean at a position that the linkage cannot have?",
            replace(RIGHT, refuses=refuse_dead),
            share=0.75,
            kind="open",
        ),
        Variant(
            "A dead point gets rates",
            "Where coupler and rocker are in line, what is the determinant of the Jacobian?",
            also_in_dead_points,
            share=0.75,
            kind="dead",
        ),
    ),
)

# --- wiper_points -----------------------------------------------------------------------------------------------------

PARTS = ("points", "speed", "acceleration")


@dataclass(frozen=True)
class Drawing:
    """The points as complex numbers, and the motion of two, with one of the parts exchanged.

    `lengths` of a point on a blade are summed, by their indices; `pivots` are those from which B, D, G and E, H are
    drawn, of C and F.
    """

    B: tuple[int, ...] = (3,)
    D: tuple[int, ...] = (4,)
    E: tuple[int, ...] = (4,)
    G: tuple[int, ...] = (6,)
    H: tuple[int, ...] = (6,)
    c: tuple[int, ...] = (0,)  # the lengths from O to C
    f: tuple[int, ...] = (0, 5)
    of_e: tuple[int, ...] | None = None  # where the second blade begins for E, if not in F
    of_h: tuple[int, ...] | None = None
    direction: Callable = unit
    blade: int = 1  # the unknown that is the blades' angle
    turning: int = 1  # the unknown whose rates are the blades'
    speed: Callable = lambda arm, omega: arm * np.abs(omega)
    acceleration: Callable = lambda arm, omega, alpha: arm * np.hypot(alpha, omega**2)
    fast: int = 6
    slow: int = 6
    positive: bool = True

    def __call__(self, theta1, q, rates, lengths) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        if self.positive and min(lengths) <= 0:
            raise ValueError(f"a length of {min(lengths)} m")

        def along(indices: tuple[int, ...]) -> float:
            return sum(lengths[k] for k in indices)

        blade = self.direction(q[:, self.blade])
        C, F = along(self.c) + 0 * blade, along(self.f) + 0 * blade
        E, H = (F if at is None else along(at) for at in (self.of_e, self.of_h))
        points = [
            lengths[1] * self.direction(theta1),
            C + along(self.B) * blade,
            C,
            C + along(self.D) * blade,
            E + along(self.E) * blade,
            F,
            C + along(self.G) * blade,
            H + along(self.H) * blade,
        ]
        omega, alpha = rates[:, :, self.turning]
        return (
            np.moveaxis([np.real(points), np.imag(points)], 0, -1),
            self.speed(lengths[self.fast], omega),
            self.acceleration(lengths[self.slow], omega, alpha),
        )


DRAWING = Drawing()


def drawn_as(**parts) -> Drawing:
    return replace(DRAWING, **parts)


def drawn_then(change: Callable) -> Callable:
    return lambda *args: change(*DRAWING(*args))


def points_cases(rng: np.random.Generator) -> list[Case]:
    def case(n: int, at: int | None = None, length: float = 1.0) -> Case:
        wiper, theta1 = random_wiper(rng), rng.uniform(-TURN, 2 * TURN, n)
        q = wiper.position(theta1, rng.choice(["open", "crossed"]))
        crank = np.stack((theta1, *(rng.uniform(least, 3 * least, n) * rng.choice([-1, 1], n) for least in (2.5, 20))))
        lengths = list(lengths_of(wiper, 7))
        args = (theta1, q, RIGHT(q, crank, lengths[:4]))
        label = f"{n} points, {words(wiper, 7)}"
        if at is not None:
            lengths[at] *= length
            label = f"r{at} = {lengths[at]:.4g} m"
        return Case((*args, tuple(lengths)), kind="normal" if at is None else "negative", label=label)

    return [case(60), case(1), case(3, int(rng.integers(7)), 0.0), case(3, int(rng.integers(6)), -1.0)]


def triple(trial: Trial, right: Trial) -> list[np.ndarray] | str:
    return named(trial.outcome, right.outcome, *PARTS)


def is_the_drawing(second: bool) -> Callable:
    """Whether the first or the second blade is a drawing of rigid bars, from their lengths and the angles of two."""

    def fault(trial: Trial, right: Trial) -> str | None:
        found = triple(trial, right)
        if isinstance(found, str):
            return found
        A, B, C, D, E, F, G, H = found[0] @ [1, 1j]
        theta1, q, _, (r0, r1, r2, r3, r4, r5, r6) = trial.case.args
        looked_for = (
            ("F", F - C - r5, "it is not r5 to the right of C"),
            ("E", E - D - r5, "D-E is not a bar of r5 that is parallel to the ground"),
            ("E", np.abs(E - F) - r4, "it is not r4 from F"),
            ("H", H - G - r5, "the blades are not parallel"),
            ("H", np.abs(H - F) - r6, "it is not r6 from F"),
        )
        if not second:
            looked_for = (
                ("A", np.angle(A / unit(theta1)), "it is not in the direction theta1 from O"),
                ("A", np.abs(A) - r1, "it is not r1 from O"),
                ("C", C - r0, "it is not r0 to the right of O"),
                ("B", B - A - r2 * unit(q[:, 0]), "the coupler does not lead from A to B"),
                ("B", np.abs(B - C) - r3, "it is not r3 from C"),
                ("D", r3 * (D - C) - r4 * (B - C), "it is not r4 from C on the line through B"),
                ("G", r3 * (G - C) - r6 * (B - C), "it is not r6 from C on the line through B"),
            )
        for name, off, why in looked_for:
            if not (np.abs(off) < 1e-9).all():
                return f"point {name}: {why} at index {int(np.argmin(np.abs(off) < 1e-9))}"
        return None

    return fault


def is_the_motion(level: int, name: str) -> Callable:
    """Whether speed (level 0) or acceleration (1) is that of the end of a blade that is turned on for a moment."""

    def fault(trial: Trial, right: Trial) -> str | None:
        found = triple(trial, right)
        if isinstance(found, str):
            return found
        _, q, rates, lengths = trial.case.args
        t = STEP * np.array([0, *BESIDE])[:, None]
        omega, alpha = rates[:, :, 1]
        path = lengths[6] * unit(q[:, 1] + omega * t + alpha * t**2 / 2)
        return by_columns(np.abs(differences(path, STEP)[level])[:, None], found[1 + level][:, None], (name,), SLOPE)

    return fault


def off(name: str, advice: str, *functions: Callable, share: float = 0.5, **more) -> tuple[Variant, ...]:
    return readings(name, advice, *functions, share=share, **more)


WIPER_POINTS = Task(
    name="wiper_points",
    title="the points A to H, the speed of H and the acceleration of G",
    function="wiper_points",
    reference=DRAWING,
    cases=points_cases,
    agree=same_parts(*PARTS),
    tolerance=EXACT,
    section="wiper-kinematics: Points, and the sector they wipe",
    aspects=(
        Aspect("A, B, C, D and G: each bar has its length, and D and G lie on C-B", 0.75, is_the_drawing(False)),
        Aspect(
            "F, E and H: the second blade is parallel to the first, and D-E to the ground", 0.75, is_the_drawing(True)
        ),
        Aspect("the speed of H", 0.5, is_the_motion(0, "speed")),
        Aspect("the size of the acceleration of G", 0.75, is_the_motion(1, "acceleration")),
        Aspect(
            "it raises ValueError, with the length, where one is not positive",
            0.25,
            refuses(lambda theta1, q, rates, lengths: (min(lengths),), EXACT),
            kind="negative",
        ),
    ),
    variants=(
        *off(
            "The second blade begins in C",
            "C carries the first blade. Which joint carries the second?",
            drawn_as(of_e=(0,), of_h=(0,)),
            drawn_as(of_e=(0,)),
            drawn_as(of_h=(0,)),
            drawn_as(f=(0,)),
        ),
        *off(
            "F is r5 from O, and not from C",
            "D-E is as long as C-F. Where does C lie?",
            drawn_as(f=(5,)),
            drawn_as(of_e=(5,), of_h=(5,)),
        ),
        *off(
            "r3 stands where r4 belongs: it is the point B",
            "The bar D-E is joined to the blades beyond B: how far from C?",
            drawn_as(D=(3,), E=(3,)),
            drawn_as(D=(3,)),
            drawn_as(E=(3,)),
            share=0.25,
        ),
        *off(
            "r4 stands where r3 belongs: it is the point D",
            "How far from C is the coupler joined to the first blade?",
            drawn_as(B=(4,)),
            share=0.25,
        ),
        *off(
            "D is counted from B, and not from C",
            "r4 already contains the part from C to B.",
            drawn_as(D=(3, 4), E=(3, 4)),
            drawn_as(D=(3, 4)),
            share=0.25,
        ),
        *off(
            "G and H are counted from D and E",
            "r6 is the whole blade, from its joint at the ground to its end.",
            drawn_as(G=(4, 6), H=(4, 6)),
            share=0.25,
        ),
        *off(
            "r4 stands where r6 belongs: the blades end in D and E",
            "How long is a blade?",
            drawn_as(G=(4,), H=(4,)),
            drawn_as(G=(4,), H=(4,), fast=4, slow=4),
            share=0.25,
        ),
        *off(
            "C is put in O",
            "The ground is a bar as well: how long is it?",
            drawn_as(c=()),
            drawn_as(c=(), f=(5,)),
            share=0.25,
        ),
        *off(
            "The angle of the coupler is taken for that of the blades",
            "Which of the two unknowns turns about C?",
            drawn_as(blade=0),
            drawn_as(blade=0, turning=0),
            share=0.25,
        ),
        *off(
            "The rates of the coupler are taken for those of the blades",
            "Which of the two unknowns turns about C?",
            drawn_as(turning=0),
        ),
        *off(
            "Sine and cosine are exchanged",
            "The angles are measured from the horizontal: which component does the cosine give?",
            drawn_as(direction=lambda angle: 1j * unit(-angle)),
            share=0.25,
        ),
        *off(
            "y points down",
            "theta1 grows from the x axis towards the y axis: at a quarter turn, where is A?",
            drawn_as(direction=lambda angle: unit(-angle)),
            share=0.25,
        ),
        *off(
            "The angles are taken for degrees",
            "They are in radians, and NumPy wants radians.",
            drawn_as(direction=lambda angle: unit(np.deg2rad(angle))),
            share=0.25,
        ),
        *off(
            "The speed of H keeps the sign of omega3",
            "A speed is the size of a velocity.",
            drawn_as(speed=lambda arm, omega: arm * omega),
        ),
        *off(
            "The speed is that of E",
            "How far is H from the joint about which it turns?",
            drawn_as(fast=4),
        ),
        *off(
            "The acceleration is that of D",
            "How far is G from the joint about which it turns?",
            drawn_as(slow=4),
        ),
        *off(
            "The centripetal part of the acceleration is forgotten",
            "Does a blade accelerate that turns evenly?",
            drawn_as(acceleration=lambda arm, omega, alpha: arm * np.abs(alpha)),
            drawn_as(acceleration=lambda arm, omega, alpha: arm * alpha),
        ),
        *off(
            "The tangential part of the acceleration is forgotten",
            "At the end of its sweep omega3 is zero. Is there an acceleration?",
            drawn_as(acceleration=lambda arm, omega, alpha: arm * omega**2),
        ),
        *off(
            "The angular velocity is not squared in the centripetal part",
            "Look at the units of the two parts.",
            drawn_as(acceleration=lambda arm, omega, alpha: arm * np.hypot(alpha, omega)),
        ),
        *off(
            "The two parts of the acceleration are added as if they had one direction",
            "One part is along the blade, the other across it.",
            drawn_as(acceleration=lambda arm, omega, alpha: arm * (np.abs(alpha) + omega**2)),
            drawn_as(acceleration=lambda arm, omega, alpha: arm * (alpha + omega**2)),
            drawn_as(acceleration=lambda arm, omega, alpha: arm * np.abs(alpha + omega**2)),
            drawn_as(acceleration=lambda arm, omega, alpha: arm * np.abs(alpha - omega**2)),
        ),
        *off(
            "Speed and acceleration are exchanged",
            "In which order does the task ask for them?",
            drawn_then(lambda points, speed, acceleration: (points, acceleration, speed)),
        ),
        *off(
            "The points have the shape (points, 8, 2)",
            "The first axis holds A to H.",
            drawn_then(lambda points, *rest: (points.swapaxes(0, 1), *rest)),
        ),
        *off(
            "The points have the shape (8, 2, points)",
            "The last axis holds x and y.",
            drawn_then(lambda points, *rest: (points.swapaxes(1, 2), *rest)),
        ),
        *off(
            "A length that is not positive is drawn",
            "A bar of no length is no bar.",
            drawn_as(positive=False),
            share=0.75,
            kind="negative",
        ),
    ),
)

EXERCISE = Exercise(
    name="08_wiper_kinematics",
    title="The windscreen wiper: where it is and how fast it moves",
    tasks=(GRASHOF_CLASS, WIPER_POSITIONS, WIPER_RATES, WIPER_POINTS),
)
