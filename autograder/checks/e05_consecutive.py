"""Exercise 5: the power hacksaw solved consecutively, and along a motion."""

import re
from collections.abc import Callable
from itertools import pairwise

import numpy as np

from autograder.checks.answers import array, refuses
from autograder.compare import Tolerance, difference
from autograder.outcome import Raised
from autograder.spec import Aspect, Case, Exercise, Task, Trial, Variant, readings
from mechlib.hacksaw import Hacksaw
from mechlib.newton import ConvergenceError, newton

TURN = 2 * np.pi


def random_saw(rng: np.random.Generator, crank: float = 0.075) -> Hacksaw:
    """Lengths near the proportions of source A: the loop closes all round, 39 degrees or more from singular."""
    r2 = crank * rng.uniform(0.7, 1.3)
    return Hacksaw(r1y=r2 * rng.uniform(0.4, 0.7), r2=r2, r3=r2 * rng.uniform(2.2, 3.0))


def equations(saw: Hacksaw) -> tuple[Callable, Callable]:
    """Closure and Jacobian of one position: several times cheaper than those of `saw.loop`, which take many."""

    def residual(q, theta2):
        r1, theta1, theta3 = q
        x, y = r1 * np.cos(theta1), r1 * np.sin(theta1)
        to_x = saw.r2 * np.cos(theta2) + saw.r3 * np.cos(theta3)
        to_y = saw.r2 * np.sin(theta2) + saw.r3 * np.sin(theta3)
        return np.array([to_x - x, y - to_y, y - saw.r1y])

    def jacobian(q, theta2):
        r1, theta1, theta3 = q
        c, s = np.cos(theta1), np.sin(theta1)
        a, b = saw.r3 * np.cos(theta3), saw.r3 * np.sin(theta3)
        return np.array([[-c, r1 * s, -b], [s, r1 * c, -a], [s, r1 * c, 0.0]])

    return residual, jacobian


def in_degrees(q: np.ndarray) -> np.ndarray:
    return q * [1.0, 180 / np.pi, 180 / np.pi]


def wrapped_from(low: float, q: np.ndarray) -> np.ndarray:
    return np.concatenate((q[..., :1], (q[..., 1:] - low) % TURN + low), axis=-1)


def slips_of_the_angles(positions: Callable) -> tuple[Variant, ...]:
    """Mistakes with angles in what a right solver (residual, jacobian, theta2, seed, tol) takes and gives."""
    turn = "Newton-Raphson stays on the turn of its seed, and an angle that does not leap can be differentiated."
    return (
        Variant(
            "The crank angle is taken for degrees",
            "theta2 comes in radians: it needs no conversion.",
            lambda f, j, theta2, *rest: positions(f, j, np.deg2rad(theta2), *rest),
        ),
        Variant(
            "The angles are returned in degrees",
            "Angles are in rad until they are plotted.",
            lambda *args: in_degrees(positions(*args)),
            share=0.5,
        ),
        Variant(
            "The angles are brought into one turn, from 0 to 2 pi",
            turn,
            lambda *args: wrapped_from(0.0, positions(*args)),
            share=0.5,
        ),
        Variant(
            "The angles are brought into one turn, from -pi to pi",
            turn,
            lambda *args: wrapped_from(-np.pi, positions(*args)),
            share=0.5,
        ),
        Variant(
            "r1 is made positive",
            "r1 is the component of a vector along its own direction: with theta1 near zero the slider lies at r1 < 0.",
            lambda *args: np.abs(positions(*args)) * [1, 0, 0] + positions(*args) * [0, 1, 1],
            share=0.5,
        ),
    )


# --- saw_position -----------------------------------------------------------------------------------------------------


def one_position(residual, jacobian, theta2, seed, tol=1e-6):
    return newton(lambda q: residual(q, theta2), lambda q: jacobian(q, theta2), seed, tol).root


def position_case(
    rng: np.random.Generator, crank: float, last_step: tuple[float, float], next_step: float = 0.0, turns: int = 0
) -> Case:
    """A position whose tolerance lies well between two steps: no rounding decides when to stop.

    The residual has the size of the saw. So a small saw looks closed a step too early, and a large one does not: that
    tells a stop on the residual from a last step that is not taken.
    """
    while True:
        saw, theta2 = random_saw(rng, crank), rng.uniform(-TURN, 2 * TURN)
        away = rng.uniform(0.1, 0.6, 3) * rng.choice([-1, 1], 3) * [saw.r3, 1, 1]
        seed = saw.position(theta2) + away + [0, turns * TURN, turns * TURN]
        residual, jacobian = equations(saw)
        try:
            path = newton(lambda q, f=residual, u=theta2: f(q, u), lambda q, f=jacobian, u=theta2: f(q, u), seed, 1e-13)
        except ConvergenceError:
            continue
        for k in range(2, min(path.iterations - 1, 6)):
            before, last, after = path.errors[k - 1 : k + 2]
            open_by = np.linalg.norm(residual(path.history[k], theta2))
            clear = open_by < 1.5 * last if crank < 1 else open_by > 6 * last  # half of tol, and twice tol
            home = np.abs(path.root - seed + away).max() < 1e-9  # on the seed's own branch and turn
            if last_step[0] < last < last_step[1] and before > 9 * last and after > next_step and clear and home:
                label = (
                    f"a crank of {saw.r2:.3g} m at {theta2:.3f} rad, the seed {turns} turns on, tol = {3 * last:.1e}"
                )
                return Case((residual, jacobian, theta2, seed, 3 * last), label=label)


def position_cases(rng: np.random.Generator) -> list[Case]:
    short = random_saw(rng)
    short = Hacksaw(short.r1y, short.r2, r3=(short.r1y + short.r2) * rng.uniform(0.6, 0.8))
    theta2 = -TURN / 4 + rng.uniform(-0.1, 0.1)  # the crank pin is furthest from the guide
    seed = np.array([-short.r2, -0.5, 2.5]) * rng.uniform(0.9, 1.1, 3)
    return [
        position_case(rng, 0.075, (2e-3, 1e-2), next_step=2e-6),  # two iterations fewer than with the default tol
        position_case(rng, 7.5, (1e-7, 1e-4)),
        position_case(rng, 0.075, (1e-7, 1e-4), turns=int(rng.choice([-1, 1]))),
        Case((*equations(short), theta2, seed, 1e-6), kind="open", label="a loop that is open"),
    ]


def is_the_position(trial: Trial, right: Trial) -> str | None:
    got = array(trial, (3,))
    if isinstance(got, str):
        return got
    near = Tolerance(0.0, "the position is known to about tol", absolute=10 * trial.case.args[4])
    return difference(right.outcome.value, got, near)


def looks(trial: Trial) -> int:
    """At how many points in turn the residual was evaluated."""
    points = [np.asarray(q) for q, *_ in trial.evaluations[0]]
    return len(points) and 1 + sum(not np.array_equal(a, b) for a, b in pairwise(points))


def stops_on_the_step(trial: Trial, right: Trial) -> str | None:
    got = array(trial, (3,))
    if isinstance(got, str):
        return got
    more = looks(trial) - looks(right)
    if more < 0 or more > 1:  # one more look, at the root, is forgiven
        return f"it looks at the loop at {abs(more)} point{'s' * (abs(more) > 1)} {'more' if more > 0 else 'fewer'}"
    # the last step has a third of tol, and what it leaves is far less
    taken = np.abs(got - right.outcome.value).max() < 0.05 * trial.case.args[4]
    return None if taken else "the step that proves convergence is not taken"


def fails_aloud(trial: Trial, right: Trial) -> str | None:
    match trial.outcome:
        case Raised() as raised if raised.is_a("ArithmeticError"):
            return None
        case Raised(type=name):
            return f"it raised {name}, which is no ArithmeticError"
        case _:
            return "it returned a value where the loop cannot close"


def on_the_residual(residual, jacobian, theta2, seed, tol):
    q = np.array(seed)
    for _ in range(50):
        if np.linalg.norm(residual(q, theta2)) < tol:
            return q
        q = q - np.linalg.solve(jacobian(q, theta2), residual(q, theta2))
    raise ConvergenceError("no position", None)


def without_the_last_step(residual, jacobian, theta2, seed, tol):
    path = newton(lambda q: residual(q, theta2), lambda q: jacobian(q, theta2), seed, tol)
    return path.history[-2]


SAW_POSITION = Task(
    name="saw_position",
    title="one position of the hacksaw",
    function="saw_position",
    reference=one_position,
    cases=position_cases,
    tolerance=Tolerance(0.0, "two ways to write a step differ by round-off", absolute=1e-9),
    section="hacksaw-consecutive: First the position",
    aspects=(
        Aspect("it is the position on the branch and the turn of the seed", 1.5, is_the_position),
        Aspect("it stops at the first step whose 2-norm is below tol, and takes that step", 0.5, stops_on_the_step),
        Aspect("it raises ConvergenceError where the loop cannot close", 1.0, fails_aloud, kind="open"),
    ),
    variants=(
        Variant(
            "The step has the wrong sign",
            "J d = F gives the step that must be taken from q.",
            lambda f, j, *rest: one_position(f, lambda *at: -j(*at), *rest),
            by_path=True,
        ),
        Variant(
            "The Jacobian is transposed",
            "Row i belongs to equation i: which index is the unknown's?",
            lambda f, j, *rest: one_position(f, lambda *at: j(*at).T, *rest),
            by_path=True,
        ),
        Variant(
            "The Jacobian of the seed is used in every step",
            "Where must the Jacobian be evaluated in each step?",
            lambda f, j, theta2, seed, *rest: one_position(f, lambda *at: j(seed, theta2), theta2, seed, *rest),
            share=0.25,
            by_path=True,
        ),
        Variant(
            "A single step is taken",
            "One step solves a linear system. Are the position equations linear?",
            lambda f, j, theta2, seed, tol: seed - np.linalg.solve(j(seed, theta2), f(seed, theta2)),
        ),
        Variant(
            "It stops when the residual is small, and not when the step is",
            "The residual is a length of the loop, and tol bounds a step of the unknowns.",
            on_the_residual,
            share=0.5,
        ),
        Variant(
            "The last step is not taken",
            "The step that proves convergence is known: its end is far nearer to the position.",
            without_the_last_step,
            share=0.5,
        ),
        *slips_of_the_angles(one_position),
    ),
)

# --- saw_rates --------------------------------------------------------------------------------------------------------


def closes(q, theta2, lengths) -> None:
    gap = np.linalg.norm(Hacksaw(*lengths).loop.residual(q, theta2), axis=-1)
    if gap.max() > 1e-6:
        raise ValueError(f"the position at index {gap.argmax()} leaves the loop open by {gap.max():.3g} m")


def rates(q, crank, lengths) -> np.ndarray:
    loop, (theta2, omega2, alpha2) = Hacksaw(*lengths).loop, crank
    closes(q, theta2, lengths)
    v = loop.velocity(q, theta2, omega2)
    return np.stack((v, loop.acceleration(q, v, theta2, omega2, alpha2)))


def column(*entries) -> np.ndarray:
    return np.stack(np.broadcast_arrays(*entries), axis=-1)


def coriolis(q, v, crank, lengths):
    th1, (vr, w1) = q[:, 1], v.T[:2]
    return 2 * vr * w1 * column(np.sin(th1), np.cos(th1), np.cos(th1)).T


def of_r1(q, v, crank, lengths):
    th1, w1 = q[:, 1], v[:, 1]
    return q[:, 0] * w1**2 * column(np.cos(th1), -np.sin(th1), -np.sin(th1)).T


def of_the_crank(q, v, crank, lengths):
    theta2, omega2, _ = crank
    return lengths[1] * omega2**2 * column(-np.cos(theta2), np.sin(theta2), 0 * theta2).T


def of_the_coupler(q, v, crank, lengths):
    th3, w3 = q[:, 2], v[:, 2]
    return lengths[2] * w3**2 * column(-np.cos(th3), np.sin(th3), 0 * th3).T


def of_alpha2(q, v, crank, lengths):
    theta2, _, alpha2 = crank
    return lengths[1] * alpha2 * column(-np.sin(theta2), -np.cos(theta2), 0 * theta2).T


def not_squared(q, v, crank, lengths):
    """What is too much in the centripetal terms when a speed should have been squared and is not."""
    omega2 = crank[1]
    return (
        of_the_crank(q, v, crank, lengths) * (1 - 1 / omega2)
        + of_the_coupler(q, v, crank, lengths) * (1 - 1 / v[:, 2])
        + of_r1(q, v, crank, lengths) * (1 - 1 / v[:, 1])
    )


def lacking(*terms: Callable, share: float = 1.0) -> Callable:
    """Rates in whose acceleration equations a share of these terms is missing."""

    def wrong(q, crank, lengths):
        v, a = rates(q, crank, lengths)
        missing = share * sum(term(q, v, crank, lengths) for term in terms)
        jacobian = Hacksaw(*lengths).loop.jacobian(q, crank[0])
        return np.stack((v, a + np.linalg.solve(jacobian, missing.T[..., None])[..., 0]))

    return wrong


def by_the_transposed(q, crank, lengths):
    loop, (theta2, omega2, alpha2) = Hacksaw(*lengths).loop, crank
    jacobian = loop.jacobian(q, theta2)

    def again(right: np.ndarray) -> np.ndarray:
        """The solution of J x = b, taken back to b and solved with the transposed Jacobian."""
        return np.linalg.solve(np.swapaxes(jacobian, -1, -2), jacobian @ right[..., None])[..., 0]

    v = again(loop.velocity(q, theta2, omega2))
    return np.stack((v, again(loop.acceleration(q, v, theta2, omega2, alpha2))))


def at_degrees(q, crank, lengths):
    loop, (theta2, omega2, alpha2) = Hacksaw(*lengths).loop, crank
    v = loop.velocity(q, np.deg2rad(theta2), omega2)
    return np.stack((v, loop.acceleration(q, v, np.deg2rad(theta2), omega2, alpha2)))


def rates_cases(rng: np.random.Generator) -> list[Case]:
    def points(n: int, kind: str = "normal") -> Case:
        saw, theta2 = random_saw(rng), rng.uniform(0, 2 * TURN, n)
        omega2 = rng.uniform(2, 9, n) * rng.choice([-1, 1], n)
        alpha2 = rng.uniform(20, 60, n) * rng.choice([-1, 1], n)
        q = saw.position(theta2)
        if kind == "open":  # by a little, and with no positive gap: only its size can tell
            k, gap = rng.integers(3, n), -rng.uniform(1e-5, 1e-4, 3)
            q[k] += np.linalg.solve(saw.loop.jacobian(q, theta2)[k], gap)
        label = f"{n} point{'s' * (n > 1)}{', one of them open' * (kind == 'open')}, a crank of {saw.r2:.4f} m"
        return Case((q, np.stack((theta2, omega2, alpha2)), (saw.r1y, saw.r2, saw.r3)), kind=kind, label=label)

    return [points(7), points(4), points(1), points(5, "open")]


def part(index: int, trial: Trial, right: Trial) -> str | None:
    got = array(trial, right.outcome.value.shape)
    return got if isinstance(got, str) else difference(right.outcome.value[index], got[index], RATES_TOLERANCE)


def index_of_the_open(q, crank, lengths) -> tuple[int, int]:
    """The index of the point at which the loop is open, counted from zero or from one."""
    first = int(np.linalg.norm(Hacksaw(*lengths).loop.residual(q, crank[0]), axis=-1).argmax())
    return first, first + 1


RATES_TOLERANCE = Tolerance(1e-6, "a linear solve is right to 1e-13 of the scale here")

LACKING = (
    ("The Coriolis term is forgotten", lacking(coriolis)),
    ("The Coriolis term is counted once", lacking(coriolis, share=0.5)),
    ("The centripetal term of the crank is forgotten", lacking(of_the_crank)),
    ("The centripetal term of the coupler is forgotten", lacking(of_the_coupler)),
    ("The centripetal term of r1 is forgotten", lacking(of_r1)),
    ("The angular acceleration of the crank is forgotten", lacking(of_alpha2)),
    ("The angular velocities are not squared in the centripetal terms", lacking(not_squared)),
    (
        "Every term with a product of velocities is forgotten",
        lacking(coriolis, of_r1, of_the_crank, of_the_coupler),
    ),
)

SAW_RATES = Task(
    name="saw_rates",
    title="velocities and accelerations by two linear solves",
    function="saw_rates",
    reference=rates,
    cases=rates_cases,
    tolerance=RATES_TOLERANCE,
    section="hacksaw-consecutive: Then velocity and acceleration, each by one solve",
    aspects=(
        Aspect("the velocities, at one point or many", 1.5, lambda *trials: part(0, *trials)),
        Aspect("the accelerations, at one point or many", 2.0, lambda *trials: part(1, *trials)),
        Aspect(
            "it raises ValueError, with the index, where a position does not close the loop",
            0.5,
            refuses(index_of_the_open, RATES_TOLERANCE),
            kind="open",
        ),
    ),
    variants=(
        *(
            Variant(
                name,
                "Differentiate the velocity equation of one row by hand, term by term, and compare.",
                function,
                share=0.5,
            )
            for name, function in LACKING
        ),
        Variant(
            "The right side of the velocities has the wrong sign",
            "J v + F_u omega2 = 0: what stands on the right of J v?",
            lambda *args: rates(*args) * [[[-1]], [[1]]],
            share=0.25,
        ),
        Variant(
            "The right side of the accelerations has the wrong sign",
            "J a + gamma = 0: what stands on the right of J a?",
            lambda *args: rates(*args) * [[[1]], [[-1]]],
            share=0.5,
        ),
        Variant(
            "The right sides of both systems have the wrong sign",
            "What does not hold the unknown goes to the other side of the equation.",
            lambda *args: -rates(*args),
            share=0.25,
        ),
        Variant(
            "The velocities are returned where the accelerations are asked for",
            "The second solve has a right side of its own.",
            lambda *args: rates(*args)[[0, 0]],
            share=0.375,
        ),
        Variant(
            "Velocities and accelerations are exchanged",
            "The first entry holds the velocities.",
            lambda *args: rates(*args)[::-1],
            share=0.5,
        ),
        Variant(
            "The Jacobian is transposed",
            "Row i belongs to equation i: which index is the unknown's?",
            by_the_transposed,
        ),
        Variant(
            "The angular velocity of the crank is taken as 1 rad/s",
            "A velocity for omega2 = 1 is a velocity ratio: what drives the crank?",
            lambda q, crank, lengths: rates(q, (crank[0], np.ones_like(crank[1]), crank[2]), lengths),
            share=0.25,
        ),
        Variant(
            "The angular rates are returned in degrees",
            "Angles are in rad until they are plotted.",
            lambda *args: in_degrees(rates(*args)),
            share=0.5,
        ),
        Variant(
            "The crank angle is taken for degrees",
            "theta2 comes in radians: it needs no conversion.",
            at_degrees,
        ),
    ),
)

# --- saw_sweep --------------------------------------------------------------------------------------------------------


def sweep(residual, jacobian, theta2, seed, tol=1e-6) -> np.ndarray:
    found = []
    for k, u in enumerate(theta2):
        try:
            found.append(one_position(residual, jacobian, u, found[-1] if found else seed, tol))
        except ConvergenceError as why:
            raise ConvergenceError(f"point {k}: {why}", why.path) from None
    return np.array(found)


def cold(residual, jacobian, theta2, seed, tol=1e-6) -> np.ndarray:
    return np.array([one_position(residual, jacobian, u, seed, tol) for u in theta2])


def one_step_everywhere(residual, jacobian, theta2, seed, tol=1e-6) -> np.ndarray:
    """Also at the first point, where the seed is far."""
    found = [np.asarray(seed, dtype=float)]
    for u in theta2:
        found.append(found[-1] - np.linalg.solve(jacobian(found[-1], u), residual(found[-1], u)))
    return np.array(found[1:])


def one_step_each(residual, jacobian, theta2, seed, tol=1e-6) -> np.ndarray:
    first = one_position(residual, jacobian, theta2[0], seed, tol)
    return np.array([first, *one_step_everywhere(residual, jacobian, theta2[1:], first)])


def ends(saw: Hacksaw, theta2: np.ndarray, seeds: np.ndarray) -> np.ndarray:
    """Where 12 iterations from each seed end, at all crank angles; nan where they do not; shape (seeds, points, 3)."""
    q = np.repeat(seeds[:, None], len(theta2), axis=1)
    with np.errstate(all="ignore"):
        for _ in range(12):
            step = np.linalg.solve(saw.loop.jacobian(q, theta2), saw.loop.residual(q, theta2)[..., None])[..., 0]
            q = q - step
    q[~(np.abs(step).max(axis=-1) < 1e-9)] = np.nan
    return q


def lost_when_cold(rng: np.random.Generator) -> Case:
    """A turn of the crank, and a seed that is good at its beginning and leads astray further on.

    A cold start ends elsewhere at some of the points, and a change of the seed by round-off does not change where.
    """
    n = int(rng.integers(20, 27))
    while True:
        saw = random_saw(rng)
        turned = rng.choice([-1, 1]) * np.linspace(0, rng.uniform(1.0, 1.2) * TURN, n)
        theta2 = rng.uniform(-TURN / 2, TURN / 2) + turned
        right = saw.position(theta2)
        r1, theta1, _ = right[0]
        seed = np.array([r1 * rng.uniform(0.8, 1.2), theta1 + rng.uniform(-0.2, 0.2), rng.uniform(1.9, 2.3)])
        found, *shifted = ends(saw, theta2, np.outer((1, 1 - 1e-9, 1 + 1e-9), seed))
        astray = (np.abs(found - right).max(axis=1) > 1e-3).sum()
        sure = all(np.abs(other - found).max() < 1e-6 for other in shifted)  # nan is not
        if np.abs(found[0] - right[0]).max() < 1e-9 and astray >= 3 and sure:
            label = f"{n} crank angles, a crank of {saw.r2:.4f} m; a cold start is astray at {astray} of them"
            return Case((*equations(saw), theta2, seed, 1e-6), label=label)


def opens_on_the_way(rng: np.random.Generator) -> Case:
    """A coupler that is too short for some crank angles; each angle is clearly on one side."""
    while True:
        saw = random_saw(rng)
        saw = Hacksaw(saw.r1y, saw.r2, r3=(saw.r1y + saw.r2) * rng.uniform(0.8, 0.95))
        theta2 = TURN / 4 + np.linspace(0, TURN / 2, 32) + rng.uniform(0, 0.05)
        first = int(np.argmax(saw.gap(theta2) > 0))
        last = saw.gap(theta2[first - 1]) / saw.r3
        # no number of iterations is taken for the index
        if last < -0.015 and saw.gap(theta2[first]) / saw.r3 > 0.01 and first > 10 and first % 5:
            seed = saw.position(theta2[0]) * rng.uniform(0.95, 1.05, 3)
            args = (*equations(saw), theta2, seed, 1e-6)
            return Case(args, kind="open", label="a loop that opens on the way")


def sweep_cases(rng: np.random.Generator) -> list[Case]:
    return [lost_when_cold(rng), opens_on_the_way(rng)]


def follows_the_saw(trial: Trial, right: Trial) -> str | None:
    got = array(trial, right.outcome.value.shape)
    if isinstance(got, str):
        return got
    near = Tolerance(0.0, "each position is known to about tol", absolute=10 * trial.case.args[4])
    return difference(right.outcome.value, got, near)


def starts_warm(trial: Trial, right: Trial) -> str | None:
    """Each point is begun about as near to its position as the one before is, or nearer.

    A line through the last two positions misses by a second difference, which is no more than twice a first one.
    """
    theta2, positions = trial.case.args[2], right.outcome.value
    steps = np.linalg.norm(np.diff(positions, axis=0), axis=1)
    looked = [at for at in trial.evaluations[0] if len(at) == 2 and np.shape(at[0]) == (3,) and np.size(at[1]) == 1]
    angles = np.array([float(np.ravel(u)[0]) for _, u in looked])
    for k in range(1, len(theta2)):
        here = np.flatnonzero(np.abs(angles - theta2[k]) < 1e-9)
        if not here.size:
            return f"the loop is never looked at for the crank angle of index {k} alone"
        if np.linalg.norm(looked[here[0]][0] - positions[k]) > 2 * steps[max(k - 2, 0) : k].max():
            return f"the iteration at index {k} starts far from the position before it"
    return None


def says_where(trial: Trial, right: Trial) -> str | None:
    if fault := fails_aloud(trial, right):
        return fault
    first = re.search(r"\d+", right.outcome.message).group()
    said = re.findall(r"(?<![\w.])\d+(?!\w|\.\d)", trial.outcome.message)
    return None if first in said else "its message does not tell the index of the first point that cannot close"


SAW_SWEEP = Task(
    name="saw_sweep",
    title="positions along a motion, warm-started",
    function="saw_sweep",
    reference=sweep,
    cases=sweep_cases,
    tolerance=Tolerance(0.0, "a converged position is right to 1e-11 here", absolute=1e-8),
    section="hacksaw-consecutive: Warm start",
    aspects=(
        Aspect("a position for every crank angle, all on the branch and the turn of the first", 1.5, follows_the_saw),
        Aspect("each point starts from the position before it, or from a better guess", 1.0, starts_warm),
        Aspect("it raises ConvergenceError, with the index, where the loop opens", 0.5, says_where, kind="open"),
    ),
    variants=(
        Variant(
            "Every point starts from the seed",
            "Only the first point starts from the seed. What is known when the second begins?",
            cold,
            share=0.25,
        ),
        *readings(
            "One step is taken at each point",
            "A small step of the crank needs few iterations. Does one of them reach tol?",
            one_step_each,
            one_step_everywhere,
            share=0.25,
        ),
        Variant(
            "The last point is missing",
            "There are as many positions as crank angles.",
            lambda *args: sweep(*args)[:-1],
            share=0.5,
        ),
        Variant(
            "The seed is returned as the first point, and all others are late by one",
            "The seed is a guess. Is the position stored before it is solved for?",
            lambda f, j, theta2, seed, *rest: np.vstack((seed, sweep(f, j, theta2, seed, *rest)[:-1])),
            share=0.5,
        ),
        Variant(
            "The seed is returned in front of the positions",
            "There are as many positions as crank angles, and the seed is none of them.",
            lambda f, j, theta2, seed, *rest: np.vstack((seed, sweep(f, j, theta2, seed, *rest))),
            share=0.5,
        ),
        Variant(
            "Rows and columns are exchanged",
            "A row holds one position.",
            lambda *args: sweep(*args).T,
            share=0.5,
        ),
        *slips_of_the_angles(sweep),
    ),
)

EXERCISE = Exercise(
    name="05_consecutive",
    title="The power hacksaw, one solve after the other",
    tasks=(SAW_POSITION, SAW_RATES, SAW_SWEEP),
    imports=("motion", "newton", "require"),  # the motor's profile needs the last
)
