"""Exercise 10: the windscreen wiper under the torque of its motor."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

from autograder.checks.answers import array, refuses, said
from autograder.checks.e04_hacksaw_closure import either_sign
from autograder.checks.e05_consecutive import TURN
from autograder.compare import Tolerance, difference, disagreement, numbers, wrong_shape
from autograder.outcome import Outcome, Raised, Value
from autograder.spec import Aspect, Case, Exercise, Task, Trial, Variant, readings
from mechlib import dynamics

GRAVITY = 9.81
NEAR = Tolerance(1e-9, "a formula is right to round-off")
CRANK, COUPLER, FIRST, SECOND, BAR = range(5)
TURNS_WITH = (0, 1, 2, 2)  # the angle of each body; the bar turns with none

# --- the machine ------------------------------------------------------------------------------------------------------


def points(lengths: np.ndarray, bars: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The joints O A B C D E F, B seen from C, and the centres G1 to G5, each as parts along 1, e1, e2 and e3."""
    r0, r1, r2, r3, r4, r5, _ = lengths
    g1, g2, g3, g4, g5 = bars[:, 0]
    joints = [(0, 0, 0, 0), (0, r1, 0, 0), (0, r1, r2, 0), (r0, 0, 0, 0)]
    joints += [(r0, 0, 0, r4), (r0 + r5, 0, 0, r4), (r0 + r5, 0, 0, 0), (r0, 0, 0, r3)]
    centres = [(0, g1, 0, 0), (0, r1, g2, 0), (r0, 0, 0, g3), (r0 + r5, 0, 0, g4), (r0 + g5, 0, 0, r4)]
    return np.array(joints), np.array(centres)


def directions(position: np.ndarray) -> np.ndarray:
    """1, e1, e2 and e3, as complex numbers; shapes (..., 3) -> (..., 4)."""
    position = np.asarray(position)
    return np.exp(1j * np.concatenate((np.zeros_like(position[..., :1]), position), axis=-1))


def closed(theta1: float, lengths, side: int = -1, force: bool = False) -> tuple[float, float, float]:
    """All three angles on the branch on which the wiper is built, or on the other (side 1); in plain floats."""
    r0, r1, r2, r3 = map(float, lengths[:4])
    x, y = r0 - r1 * math.cos(theta1), -r1 * math.sin(theta1)
    distance = math.hypot(x, y)
    cosine = (distance**2 + r3**2 - r2**2) / (2 * distance * r3)
    if force:
        cosine = min(max(cosine, -1.0), 1.0)
    if not abs(cosine) <= 1:
        raise ArithmeticError(f"the loop cannot close at theta1 = {theta1:.6g} rad")
    theta3 = math.atan2(y, x) + math.pi + side * math.acos(cosine)
    return theta1, math.atan2(y + r3 * math.sin(theta3), x + r3 * math.cos(theta3)), theta3


def ratios(position, lengths) -> tuple[float, float]:
    """Angular velocities of coupler and blades for one radian per second of the crank."""
    (th1, th2, th3), (_, r1, r2, r3) = position, lengths[:4]
    return r1 * math.sin(th1 - th3) / (r2 * math.sin(th3 - th2)), r1 * math.sin(th1 - th2) / (r3 * math.sin(th3 - th2))


@dataclass(frozen=True)
class Balance:
    """The crank's acceleration from the balance of power: no joint force enters, and none of the 17 equations."""

    lengths: np.ndarray
    bars: np.ndarray

    @cached_property
    def numbers(self) -> tuple[list[float], list[list[float]]]:
        return self.lengths.tolist(), self.bars.tolist()

    def __call__(self, position, omega1: float, torque: float) -> float:
        (_, r1, r2, r3, r4, _, _), bars = self.numbers
        (g1, m1, i1), (g2, m2, i2), (g3, m3, i3), (g4, m4, i4), (_, m5, _) = bars
        th1, th2, th3 = map(float, position)
        c12, c13, c23, s = math.cos(th1 - th2), math.cos(th1 - th3), math.cos(th2 - th3), math.sin(th3 - th2)
        k2, k3 = ratios((th1, th2, th3), (0, r1, r2, r3))
        h2 = (r1 * c13 + r2 * k2**2 * c23 - r3 * k3**2) / (r2 * s)  # and their derivatives by theta1
        h3 = (r1 * c12 + r2 * k2**2 - r3 * k3**2 * c23) / (r3 * s)
        swinging = i3 + m3 * g3**2 + i4 + m4 * g4**2 + m5 * r4**2
        inertia = i1 + m1 * g1**2 + m2 * (r1**2 + g2**2 * k2**2 + 2 * r1 * g2 * k2 * c12) + i2 * k2**2
        inertia += swinging * k3**2
        change = m2 * (r1 * g2 * (h2 * c12 - k2 * (1 - k2) * math.sin(th1 - th2)) + g2**2 * k2 * h2) + i2 * k2 * h2
        change += swinging * k3 * h3
        weight = m1 * g1 * math.cos(th1) + m2 * (r1 * math.cos(th1) + g2 * k2 * math.cos(th2))
        weight += (m3 * g3 + m4 * g4 + m5 * r4) * k3 * math.cos(th3)
        return (torque - GRAVITY * weight - change * omega1**2) / inertia


def random_machine(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Lengths and bodies of a crank-rocker whose coupler always turns its rocker well."""
    while True:
        r2 = rng.uniform(0.18, 0.3)
        r0, r1, r3 = r2 * rng.uniform([0.9, 0.35, 0.65], [1.25, 0.5, 1.0])
        distance = np.array([r0 - r1, r0 + r1])
        cosine = (r2**2 + r3**2 - distance**2) / (2 * r2 * r3)
        if (np.abs(cosine) < np.cos(np.deg2rad(25))).all() and r1 < 0.7 * min(r0, r3):
            break
    r4, r5, r6 = rng.uniform([0.25, 0.2, 0.5], [0.35, 0.4, 0.7])
    centres = np.array([r1, r2, r4, r4, r5]) * rng.uniform(0.4, 0.9, 5)
    masses = rng.uniform(0.2, 0.6, 5)
    inertias = masses * centres**2 * rng.uniform(0.4, 1.2, 5)
    return np.array([r0, r1, r2, r3, r4, r5, r6]), np.column_stack((centres, masses, inertias))


def words(lengths: np.ndarray) -> str:
    return f"r0 = {lengths[0]:.4g} m, r1 = {lengths[1]:.4g} m, r2 = {lengths[2]:.4g} m, r3 = {lengths[3]:.4g} m"


# --- direct_system ----------------------------------------------------------------------------------------------------

BODIES = ("crank", "coupler", "first blade", "second blade", "bar")
ABOUT = (0, 1, 3, 6, 4)  # the joint about which the moments of each body are taken
JOINTS = (  # the two bodies that each joins, with its place among the points as each of them sees it
    ((CRANK, 0),),
    ((CRANK, 1), (COUPLER, 1)),
    ((COUPLER, 2), (FIRST, 7)),
    ((FIRST, 3),),
    ((FIRST, 4), (BAR, 4)),
    ((BAR, 5), (SECOND, 5)),
    ((SECOND, 6),),
)
ROWS = [
    f"{body}, {what}"
    for body, about in zip(BODIES, ABOUT, strict=True)
    for what in ("x", "y", f"moment about {'OABCDEF'[about]}")
]
ROWS += ["closure, x", "closure, y"]
NEWTON = [3 * k + i for k in range(5) for i in (0, 1)]
MOMENTS = [3 * k + 2 for k in range(5)]
OF_BODIES, OF_CLOSURE = list(range(15)), [15, 16]
System = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Equations:
    """The 17 equations with terms that can be forgotten: 1 is right."""

    centripetal: float = 1
    in_closure: float = 1  # the same, in the last two rows
    torque: float = 1
    weight: float = 1
    moment_of_weight: float = 1
    load: float = 1
    moment_of_load: float = 1
    reaction: float = -1  # on the second of the two bars that a joint joins
    arms: Callable = points  # (lengths, bars) -> where the forces act
    paths: Callable = points  # and where the centres of mass move

    def __call__(self, position, velocity, torque, loads, lengths, bars) -> System:
        e, w = directions(position), np.array([0, *velocity])
        (joints, centres), paths = self.arms(lengths, bars), self.paths(lengths, bars)[1]
        matrix, known = np.zeros((17, 17)), np.zeros(17)

        def put(into: np.ndarray, body: int, arm: complex, force, moment: float = 1) -> None:
            """A known force, or the forces for one unit of some unknowns each."""
            into[3 * body : 3 * body + 3] += force.real, force.imag, moment * (arm.conjugate() * force).imag

        for k, (_, mass, inertia) in enumerate(bars):
            arm = (centres[k] - joints[ABOUT[k]]) @ e
            put(matrix[:, :3], k, arm, -mass * 1j * (paths[k] * e)[1:])
            put(known, k, arm, self.centripetal * mass * (w**2 * paths[k]) @ e)
            put(known, k, arm, -1j * self.weight * mass * GRAVITY, self.moment_of_weight)
            if k != BAR:
                matrix[3 * k + 2, TURNS_WITH[k]] -= inertia
        for j, joined in enumerate(JOINTS):
            for (body, place), sign in zip(joined, (1, self.reaction), strict=False):
                arm = (joints[place] - joints[ABOUT[body]]) @ e
                put(matrix[:, 3 + 2 * j : 5 + 2 * j], body, arm, sign * np.array([1, 1j]))
        for body, force in zip((FIRST, SECOND), np.array(loads) @ [1, 1j], strict=True):
            put(known, body, (centres[body] - joints[ABOUT[body]]) @ e, self.load * force, self.moment_of_load)
        known[2] += self.torque * torque
        # r0 - r1 c1 - r2 c2 + r3 c3 and r1 s1 + r2 s2 - r3 s3, differentiated twice
        loop = np.array([lengths[1], lengths[2], -lengths[3]]) * e[1:]
        matrix[15:, :3] = loop.imag, loop.real
        inward = self.in_closure * (w[1:] ** 2) @ loop
        known[15:] = inward.real, -inward.imag
        return matrix, -known


RIGHT = Equations()


def system_cases(rng: np.random.Generator) -> list[Case]:
    def case() -> Case:
        lengths, bars = random_machine(rng)
        position = np.array(closed(rng.uniform(0, TURN), lengths))
        velocity = either_sign(rng, 3, 8, 1) * np.array([1, *ratios(position, lengths)])
        torque, loads = float(either_sign(rng, 2, 6, 1)[0]), either_sign(rng, 2, 6, (2, 2))
        label = f"theta1 = {position[0]:.3g} rad, {words(lengths)}"
        return Case((position, velocity, torque, loads, lengths, bars), label=label)

    return [case() for _ in range(2)]


def system(outcome: Outcome) -> System | str:
    """The matrix and the right side that were returned, or a sentence that says what came instead."""
    if isinstance(outcome, Raised):
        return f"it raised {outcome.type}"
    if not (isinstance(outcome, Value) and isinstance(outcome.value, (tuple, list)) and len(outcome.value) == 2):
        return "it is not a pair (matrix, right)"
    found = tuple(numbers(part) for part in outcome.value)
    for got, shape, name in zip(found, ((17, 17), (17,)), ("the matrix", "the right side"), strict=True):
        if isinstance(got, str):
            return got.replace("it is", f"{name} is", 1)
        if got.shape != shape:
            return f"of {name}, {wrong_shape(got, shape)}"
    return found


def rows_agree(rows: list[int], *parts: int) -> Callable:
    """Looks at rows of the matrix (part 0) or of the right side (1), each held to its own scale."""

    def fault(trial: Trial, right: Trial) -> str | None:
        got = system(trial.outcome)
        return got if isinstance(got, str) else off_in(rows, parts, right.outcome.value, got)

    return fault


def off_in(rows: list[int], parts: tuple[int, ...], expected: System, got: System) -> str | None:
    for part, where in ((0, "of the matrix"), (1, "of the right side")):
        if part in parts:
            right, answer = (each[part].reshape(17, -1)[rows] for each in (expected, got))
            off = ~(np.abs(answer - right) <= NEAR.relative * np.abs(right).max(axis=1, keepdims=True)).all(axis=1)
            if off.any():
                row = rows[int(np.argmax(off))]
                why = difference(expected[part][row], got[part][row], NEAR)
                return f"row {row} {where}, {ROWS[row]}: {why}"
    return None


def same_system(expected: Outcome, got: Outcome) -> str | None:
    if isinstance(expected, Value) and isinstance(got, Value):
        one, other = system(expected), system(got)
        if isinstance(one, tuple) and isinstance(other, tuple):
            return off_in([*OF_BODIES, *OF_CLOSURE], (0, 1), one, other)
        if isinstance(one, tuple):
            return other
        return None if one == other else f"{one}, and {other}"
    return disagreement(expected, got, NEAR)


def edited(change: Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray], System | None]) -> Callable:
    """The right system with something changed in it, given its matrix, its right side, the lengths and the bodies."""

    def wrong(*args) -> System:
        matrix, right = RIGHT(*args)
        return change(matrix, right, *args[4:]) or (matrix, right)

    return wrong


def own_inertia(factor: float) -> Callable:
    """The mass times its squared distance from the joint is added so many times to the moment of inertia."""

    def change(matrix, right, lengths, bars) -> None:
        for k, angle in enumerate(TURNS_WITH):
            matrix[3 * k + 2, angle] -= (factor - 1) * bars[k, 1] * bars[k, 0] ** 2

    return edited(change)


def as_if_a_were_fixed(*args) -> System:
    (matrix, right), (position, velocity, _, _, lengths, bars) = RIGHT(*args), args
    (centre, mass, _), (e1, e2) = bars[COUPLER], directions(position)[1:3]
    right[5] += mass * centre * lengths[1] * velocity[0] ** 2 * (e2.conjugate() * e1).imag
    matrix[5, 0] = 0
    return matrix, right


def turning_bar(matrix, right, lengths, bars) -> None:
    matrix[14, 2] -= bars[BAR, 2]


def bar_at_its_end(lengths, bars):
    joints, centres = points(lengths, bars)
    centres[BAR] = joints[5]
    return joints, centres


def bar_like_b(lengths, bars):
    joints, centres = points(lengths, bars)
    centres[BAR, 3] = lengths[3]
    return joints, centres


def permuted(rows=slice(None), columns=slice(None)) -> Callable:
    return edited(lambda matrix, right, *_: (matrix[rows][:, columns], right[rows]))


GROUPED = [0, 3, 6, 9, 12, 1, 4, 7, 10, 13, 2, 5, 8, 11, 14, 15, 16]

DIRECT_SYSTEM = Task(
    name="direct_system",
    title="seventeen equations for accelerations and forces",
    function="direct_system",
    reference=RIGHT,
    cases=system_cases,
    agree=same_system,
    tolerance=NEAR,
    section="wiper-direct-dynamics: Seventeen equations",
    aspects=(
        Aspect(
            "Newton's equations of the five bodies: forces, and masses times accelerations", 1.0, rows_agree(NEWTON, 0)
        ),
        Aspect("the moments of the five bodies: arms, and moments of inertia", 1.0, rows_agree(MOMENTS, 0)),
        Aspect("their right side: torque, weights, loads and centripetal terms", 1.25, rows_agree(OF_BODIES, 1)),
        Aspect("the closure's two acceleration equations, with their right side", 0.75, rows_agree(OF_CLOSURE, 0, 1)),
    ),
    variants=(
        Variant(
            "The matrix is transposed",
            "A row is an equation, a column an unknown.",
            edited(lambda matrix, right, *_: (matrix.T, right)),
            share=0.5,
        ),
        Variant(
            "The centripetal terms of the closure are missing",
            "A cosine that is differentiated twice gives two terms. Which of them is known?",
            replace(RIGHT, in_closure=0),
            share=0.75,
        ),
        Variant(
            "The centripetal terms of the closure have the wrong sign",
            "They are known: what happens to a sign when a term moves to the right side?",
            replace(RIGHT, in_closure=-1),
            share=0.75,
        ),
        Variant(
            "The centripetal terms of the bodies are missing",
            "A body that is turned at constant speed accelerates still: where to?",
            replace(RIGHT, centripetal=0),
            share=0.5,
        ),
        Variant(
            "The centripetal terms of the bodies have the wrong sign",
            "They point inwards, and they are known: follow the two signs to the right side.",
            replace(RIGHT, centripetal=-1),
            share=0.5,
        ),
        Variant(
            "All centripetal terms are missing",
            "The velocities are given, and they are not zero.",
            replace(RIGHT, centripetal=0, in_closure=0),
            share=0.5,
        ),
        Variant(
            "All centripetal terms have the wrong sign",
            "They point inwards, and they are known: follow the two signs to the right side.",
            replace(RIGHT, centripetal=-1, in_closure=-1),
            share=0.5,
        ),
        Variant(
            "The torque is missing",
            "Which body does the motor turn? Its torque stands in one equation.",
            replace(RIGHT, torque=0),
            share=0.5,
        ),
        Variant(
            "The torque has the wrong sign",
            "The torque is known: what happens to its sign when it moves to the right side?",
            replace(RIGHT, torque=-1),
            share=0.5,
        ),
        Variant(
            "The weight is forgotten",
            "Which force acts on each body although nothing touches it?",
            replace(RIGHT, weight=0),
            share=0.5,
        ),
        Variant(
            "The weight is doubled",
            "How often does the weight of a body stand in its equations?",
            replace(RIGHT, weight=2),
            share=0.5,
        ),
        Variant(
            "The weight has the wrong sign",
            "It points downwards, and it is known: follow the two signs to the right side.",
            replace(RIGHT, weight=-1),
            share=0.5,
        ),
        Variant(
            "The moments of the weights are forgotten",
            "The weight acts at the centre of mass, and moments are taken about a joint.",
            replace(RIGHT, moment_of_weight=0),
            share=0.5,
        ),
        Variant(
            "The loads are forgotten",
            "Two known forces act on the blades. In which rows do they stand?",
            replace(RIGHT, load=0),
            share=0.5,
        ),
        Variant(
            "The loads have the wrong sign",
            "They are known: what happens to their sign when they move to the right side?",
            replace(RIGHT, load=-1),
            share=0.5,
        ),
        Variant(
            "The moments of the loads are forgotten",
            "The loads act at the centres of mass, and moments are taken about a joint.",
            replace(RIGHT, moment_of_load=0),
            share=0.5,
        ),
        Variant(
            "The moments of inertia about the centres of mass stand where those about the joints belong",
            "Moments are taken about a joint: what does Steiner add?",
            own_inertia(0),
            share=0.5,
        ),
        Variant(
            "The distance from the joint is in the moment of inertia twice",
            "m a at the centre of mass has a moment about the joint. Is it in the moment of inertia as well?",
            own_inertia(2),
            share=0.5,
        ),
        Variant(
            "The moments of the coupler are taken as if A were fixed",
            "A accelerates, and the whole coupler with it: which moment does that give about A?",
            as_if_a_were_fixed,
            share=0.5,
        ),
        Variant(
            "The mass of the bar is at its end",
            "Where is the centre of mass of the bar, seen from D?",
            replace(RIGHT, arms=bar_at_its_end),
            share=0.5,
        ),
        Variant(
            "The bar accelerates like B",
            "Which joint does the bar hang on, and how far is it from C?",
            replace(RIGHT, paths=bar_like_b),
        ),
        Variant(
            "The bar turns with the blades",
            "D-E is as long as C-F, and the blades are parallel. How much does the bar turn?",
            edited(turning_bar),
            share=0.5,
        ),
        Variant(
            "A joint acts on both of its bodies with the same sign",
            "What one body does to another, the other does back.",
            replace(RIGHT, reaction=1),
        ),
        Variant(
            "The forces come before the accelerations",
            "In which order does the task ask for the unknowns?",
            permuted(columns=[*range(3, 17), 0, 1, 2]),
            share=0.5,
        ),
        Variant(
            "The two equations of the closure come first",
            "In which order does the task ask for the equations?",
            permuted(rows=[15, 16, *range(15)]),
            share=0.5,
        ),
        Variant(
            "The equations are grouped: all of x, all of y, all moments",
            "In which order does the task ask for the equations?",
            permuted(rows=GROUPED),
            share=0.5,
        ),
        Variant(
            "Every equation has the opposite sign",
            "The solution is the same, but the task states the sign of each equation.",
            edited(lambda matrix, right, *_: (-matrix, -right)),
            share=0.5,
        ),
        Variant(
            "The right side has the wrong sign",
            "All terms of an equation add up to zero. What happens to those that are known?",
            edited(lambda matrix, right, *_: (matrix, -right)),
            share=0.5,
        ),
        Variant(
            "The angles are taken for degrees",
            "They are in radians, and NumPy wants radians.",
            lambda position, *rest: RIGHT(np.deg2rad(position), *rest),
        ),
        Variant(
            "The two blades are exchanged",
            "Row 2 of the table of bodies is the blade that turns about C.",
            lambda *args: RIGHT(*args[:5], args[5][[0, 1, 3, 2, 4]]),
        ),
    ),
)

# --- driven_motion ----------------------------------------------------------------------------------------------------

State = tuple[float, float]
Instant = tuple[float, float, float]  # time, angle and speed
FOLLOWED = Tolerance(1e-5, "by which factor does your error fall when you halve the step?")
SAME = Tolerance(3e-5, "the same steps give the same numbers")
INTERVALS, LASTS = 12, 0.12  # s
MOST = 50  # evaluations from one instant to the next


def rk4(
    slope: Callable, t: float, h: float, y: State, half=0.5, third=0.5, whole=1.0, of=(1, 2, 2, 1), base=1
) -> State:
    """One step of Runge and Kutta's method; what follows `y` makes another of it."""

    def at(c: float, k: State) -> State:
        return slope(t + c * h, (y[0] + c * h * k[0], y[1] + c * h * k[1]))

    k = [slope(t, y)]
    k.append(at(half, k[0]))
    k.append(at(third, k[base]))
    k.append(at(whole, k[2]))
    return tuple(y[i] + h * sum(w * each[i] for w, each in zip(of, k, strict=True)) / sum(of) for i in (0, 1))


def euler(slope: Callable, t: float, h: float, y: State) -> State:
    d = slope(t, y)
    return y[0] + h * d[0], y[1] + h * d[1]


def euler_with_the_new_speed(slope: Callable, t: float, h: float, y: State) -> State:
    speed = y[1] + h * slope(t, y)[1]
    return y[0] + h * speed, speed


def midpoint(slope: Callable, t: float, h: float, y: State) -> State:
    d = slope(t + h / 2, euler(slope, t, h / 2, y))
    return y[0] + h * d[0], y[1] + h * d[1]


def heun(slope: Callable, t: float, h: float, y: State) -> State:
    d, further = slope(t, y), slope(t + h, euler(slope, t, h, y))
    return y[0] + h * (d[0] + further[0]) / 2, y[1] + h * (d[1] + further[1]) / 2


def closed_now(now: Instant, at: Instant, begin: Instant, lengths) -> tuple[float, float, float]:
    return closed(now[1], lengths)


@dataclass(frozen=True)
class Integration:
    """Steps from instant to instant; each part can be exchanged. `at` is where the step begins, `begin` the motion."""

    step: Callable = rk4
    parts: int = 1  # of the way from one instant to the next
    position: Callable = closed_now
    asked: Callable = lambda now, at, begin: now
    factor: float = 1  # of the torque
    start: Callable = lambda theta, omega: (theta, omega)
    instants: Callable = lambda t: t
    looks: bool = True

    def __call__(self, acceleration, torque, start, t, lengths) -> np.ndarray:
        if self.looks:
            require_instants(start, t)
        t = self.instants(np.asarray(t, dtype=float)).tolist()
        states = [self.start(*map(float, start))]
        begin = (t[0], *states[0])

        def slopes(at: Instant) -> Callable:
            def slope(now: float, y: State) -> State:
                given = self.factor * torque(*self.asked((now, *y), at, begin))
                return y[1], acceleration(self.position((now, *y), at, begin, lengths), y[1], given)

            return slope

        for last, following in pairwise(t):
            y, h = states[-1], (following - last) / self.parts
            for n in range(self.parts):
                y = self.step(slopes((last + n * h, *y)), last + n * h, h, y)
            states.append(y)
        return np.array(states)


def require_instants(start, t) -> None:
    for value in (*start, *t):
        if not math.isfinite(value):
            raise ValueError(f"start and t must be finite, got {value}")
    for last, following in pairwise(t):
        if following <= last:
            raise ValueError(f"t must increase, but {following} follows on {last}")


driven_motion = Integration(parts=2)
one_step_each = Integration()


def stale(of: int, with_crank: bool) -> Callable:
    """Coupler and blades as they were when the step began (1) or the motion (2), and maybe the crank as well."""

    def position(now, at, begin, lengths):
        theta1, *rest = closed((now, at, begin)[of][1], lengths)
        return theta1 if with_crank else now[1], *rest

    return position


def nan_where_open(now, at, begin, lengths):
    try:
        return closed(now[1], lengths)
    except ArithmeticError:
        return now[1], math.nan, math.nan


def nan_of_nan(now, at, begin, lengths):
    return (math.nan,) * 3 if math.isnan(now[1]) else closed(now[1], lengths)


def by_default(acceleration, torque, start, t, lengths) -> np.ndarray:
    def slope(now, y):
        theta1, omega1 = y.tolist()
        return omega1, acceleration(closed(theta1, lengths), omega1, torque(now, theta1, omega1))

    require_instants(start, t)
    return solve_ivp(slope, (t[0], t[-1]), start, t_eval=t).y.T


def with_a_flywheel(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A heavy crank makes the motion so smooth that steps of fourth order need not be short."""
    lengths, bars = random_machine(rng)
    bars[CRANK, 2] = rng.uniform(0.02, 0.04)
    return lengths, bars


def uneven(rng: np.random.Generator) -> np.ndarray:
    steps = rng.uniform(0.8, 1.2, INTERVALS)
    return rng.uniform(0.3, 0.9) + np.concatenate(([0], np.cumsum(steps))) * LASTS / steps.sum()


def smooth_torque(rng: np.random.Generator, way: float) -> Callable[[float, float, float], float]:
    lasting, swing = rng.uniform(0.6, 1.2, 2)
    rate, phase, braking, swaying = rng.uniform([10, 0, 0.03, 0.2], [20, TURN, 0.06, 0.4])

    def torque(t, theta1, omega1):
        given = way * lasting + swing * math.sin(rate * t + phase) - braking * omega1 + swaying * math.cos(theta1)
        return float(given)

    return torque


def off(states: np.ndarray, right: np.ndarray) -> float:
    """The largest error of angle or speed, each in parts of its largest value."""
    return float((np.abs(states - right) / np.abs(right).max(axis=0)).max())


def moves_smoothly(rng: np.random.Generator, driven: bool) -> tuple:
    """A motion that steps of fourth order follow well, from a lost start too, and others do not, each in its way."""
    steps = partial(rk4, of=(1, 1, 1, 1)), midpoint, heun, partial(rk4, base=0)
    coarse = [*(replace(one_step_each, step=step) for step in steps), by_default]
    lost = replace(one_step_each, start=lambda theta, omega: (0.0, omega))
    while True:
        lengths, bars = with_a_flywheel(rng)
        way = float(rng.choice([-1, 1]))
        start = (float(rng.uniform(0.5, TURN)), way * float(rng.uniform(3, 6)))
        torque = smooth_torque(rng, way) if driven else lambda t, theta1, omega1: 0.0
        args = (Balance(lengths, bars), torque, start, uneven(rng), lengths)
        right = driven_motion(*args)
        if off(one_step_each(*args), right) > 1e-6:
            continue
        if not driven:
            return args
        ends = [right]
        for method in coarse:
            ends.append(method(*args))
            if min(off(ends[-1], other) for other in ends[:-1]) < 1e-4:
                break
        else:
            if off(lost(*args), replace(lost, parts=2)(*args)) < 1e-5:
                return args


def dead_point(rng: np.random.Generator) -> Case:
    """A flywheel with bars that weigh next to nothing, and that are too short to let it turn round."""
    r2 = rng.uniform(0.18, 0.3)
    r3 = r2 * rng.uniform(0.7, 0.95)
    r1 = r2 * rng.uniform(0.4, 0.6)
    r0 = (r2 + r3) * rng.uniform(1.05, 1.15) - r1
    way, inertia = float(rng.choice([-1, 1])), rng.uniform(0.02, 0.04)
    lengths = np.array([r0, r1, r2, r3, *rng.uniform(0.3, 0.5, 3)])
    start = (way * (dead_angle(lengths) - float(rng.uniform(0.2, 0.35))), way * float(rng.uniform(4, 6)))

    def acceleration(position, omega1, torque):
        return (torque + 1e-3 * math.sin(position[2])) / inertia  # not a number where the position is none

    args = (acceleration, lambda t, theta1, omega1: 0.02 * way, start, uneven(rng), lengths)
    return Case(args, kind="dead", label=f"a loop that opens on the way, {words(lengths)}")


def dead_angle(lengths: np.ndarray) -> float:
    """The first crank angle at which coupler and rocker are in line and the loop opens."""
    r0, r1, r2, r3 = lengths[:4]
    return float(np.arccos((r0**2 + r1**2 - (r2 + r3) ** 2) / (2 * r0 * r1)))


def motion_cases(rng: np.random.Generator) -> list[Case]:
    acceleration, torque, start, t, lengths = driven = moves_smoothly(rng, driven=True)
    place = int(rng.integers(2, 5))
    back, twice, unknown = t.copy(), t.copy(), t.copy()
    back[[place, place + 1]], twice[place + 1], unknown[-1] = t[[place + 1, place]], t[place], math.nan
    bad = [
        (start, back, "instants that do not increase"),
        (start, twice, "an instant that comes twice"),
        (start, unknown, "a last instant that is not a number"),
        ((math.nan, start[1]), t, "a start that is not a number"),
        ((start[0], math.inf), t, "a speed that is not finite"),
    ]
    coasting = moves_smoothly(rng, driven=False)
    label = f"from theta1 = {start[0]:.3g} rad at {start[1]:.3g} rad/s, {words(lengths)}"
    return [
        Case(driven, label=label),
        Case(coasting, kind="coasting", label=f"no torque, {words(coasting[4])}"),
        dead_point(rng),
        *(Case((acceleration, torque, begin, at, lengths), kind="bad", label=label) for begin, at, label in bad),
    ]


def states(trial: Trial, right: Trial) -> np.ndarray | str:
    return array(trial, (len(trial.case.args[3]), 2), "(points, 2)")


def follows(near: Tolerance) -> Callable:
    def fault(trial: Trial, right: Trial) -> str | None:
        got = states(trial, right)
        if isinstance(got, str):
            return got
        if difference(np.array(trial.case.args[2]), got[0], NEAR):
            return "it does not begin with the start"
        return same_columns(right.outcome.value, got, near)

    return fault


def same_columns(expected: np.ndarray, got: np.ndarray, near: Tolerance) -> str | None:
    """Angles and speeds, each held to their own scale."""
    for name, right, answer in zip(("theta1", "omega1"), expected.T, got.T, strict=True):
        if why := difference(right, answer, near):
            return f"{name}: {why}"
    return None


def same_motion(expected: Outcome, got: Outcome) -> str | None:
    """Where nothing is right, one motion that is no number is like another: they stop being one at other points."""
    if not (isinstance(expected, Value) and isinstance(got, Value)):
        return disagreement(expected, got, SAME)
    right, answer = np.asarray(expected.value), numbers(got.value)
    if isinstance(answer, str):
        return answer
    if answer.shape != right.shape:
        return wrong_shape(answer, right.shape)
    if np.isnan(right).any():
        return None if np.isnan(answer).any() else "it is a number, where nan is right"
    return (
        same_columns(right, answer, SAME)
        if right.ndim == 2 and right.shape[1] == 2
        else difference(right, answer, SAME)
    )


def keeps_the_energy(trial: Trial, right: Trial) -> str | None:
    got = states(trial, right)
    if isinstance(got, str):
        return got
    machine, lengths = trial.case.args[0], trial.case.args[4]
    try:
        position = np.array([closed(theta1, lengths) for theta1 in got[:, 0].tolist()])
    except ArithmeticError:
        return "it leads to where the loop cannot close"
    velocity = got[:, 1:] * [[1, *ratios(q, lengths)] for q in position.tolist()]
    kinetic, potential = RIGHT_ACCOUNT.energies(position, velocity, lengths, machine.bars)
    drift = np.abs(kinetic + potential - kinetic[0] - potential[0]).max()
    return (
        f"the energy drifts by {drift / kinetic.max():.1g} of the kinetic energy"
        if drift > 2e-5 * kinetic.max()
        else None
    )


def asked_closed(trial: Trial, right: Trial) -> str | None:
    lengths = trial.case.args[4]
    asked = [np.ravel(position) for position, *_ in trial.evaluations[0]]
    if not asked:
        return "the acceleration is never evaluated"
    if any(len(position) != 3 for position in asked):
        return "it asks for the acceleration at a position that has not three angles"
    e = directions(np.array(asked))
    r0, r1, r2, r3 = lengths[:4]
    opening = np.abs(e @ [-r0, r1, r2, -r3])
    if not (opening < 1e-8).all():
        return f"it asks for the acceleration where the loop is open by {np.max(opening):.1g} m"
    return None if ((e[:, 3] / e[:, 2]).imag > 0).all() else "it asks for the acceleration on the other branch"


def asks_seldom(trial: Trial, right: Trial) -> str | None:
    n, intervals = len(trial.evaluations[0]), len(trial.case.args[3]) - 1
    return f"it evaluates the acceleration {n} times for {intervals} intervals" if n > MOST * intervals else None


def says_where_it_is_dead(trial: Trial, right: Trial) -> str | None:
    match trial.outcome:
        case Raised() as raised if raised.is_a("ArithmeticError") or raised.is_a("ValueError"):
            dead = dead_angle(trial.case.args[4])
            told = any(-0.01 < abs(x) - dead < 0.6 for x in said(raised.message))
            return None if told else "its message does not tell the angle at which the loop cannot close"
        case Raised(type=name):
            return f"it raised {name}, which is neither an ArithmeticError nor a ValueError"
        case _:
            return "it returned a value where the loop cannot close"


def wrong_input(acceleration, torque, start, t, lengths) -> tuple[float, ...]:
    place = np.flatnonzero(np.diff(t) <= 0)
    return (t[place[0]], t[place[0] + 1]) if place.size else tuple(x for x in (*start, t[-1]) if not np.isfinite(x))


def changed(change: Callable) -> Callable:
    return lambda *args: change(one_step_each(*args))


RPM = TURN / 60

DRIVEN_MOTION = Task(
    name="driven_motion",
    title="the motion that a torque makes",
    function="driven_motion",
    reference=driven_motion,
    cases=motion_cases,
    agree=same_motion,
    tolerance=SAME,
    section="wiper-direct-dynamics: The motion that a torque makes",
    aspects=(
        Aspect(
            "a row for each instant, which begins with the start and follows the motion to a twentieth",
            0.5,
            follows(Tolerance(0.05, "the motion is another one")),
        ),
        Aspect("it follows the motion to 1e-5", 1.0, follows(FOLLOWED)),
        Aspect("without a torque the energy stays", 0.25, keeps_the_energy, kind="coasting"),
        Aspect("the loop is closed wherever the acceleration is asked for", 0.5, asked_closed),
        Aspect(f"it asks at most {MOST} times from one instant to the next", 0.25, asks_seldom),
        Aspect("it raises where the loop cannot close, and tells the angle", 0.25, says_where_it_is_dead, kind="dead"),
        Aspect(
            "it raises ValueError for a start or instants that cannot be, and tells the value",
            0.25,
            refuses(wrong_input, FOLLOWED),
            kind="bad",
        ),
    ),
    variants=(
        *readings(
            "It is Euler's method",
            "Its error falls with the step to the first power. Which methods look ahead before they step?",
            replace(one_step_each, step=euler),
            replace(one_step_each, step=euler_with_the_new_speed),
        ),
        *readings(
            "The method is of second order",
            "Half the step leaves a quarter of its error. Which method leaves a sixteenth?",
            replace(one_step_each, step=midpoint),
            replace(one_step_each, step=heun),
            share=0.25,
        ),
        *readings(
            "A stage of Runge and Kutta's method begins in the wrong place",
            "Each of the stages takes the slope of the one before. How far does it go, and from where?",
            *(
                replace(one_step_each, step=partial(rk4, **wrong))
                for wrong in ({"base": 0}, {"third": 1.0}, {"half": 1.0}, {"whole": 0.5}, {"half": 1.0, "third": 1.0})
            ),
            share=0.25,
        ),
        Variant(
            "The slopes of Runge and Kutta's method have equal weights",
            "Two of the four slopes belong to the middle of the step.",
            replace(one_step_each, step=partial(rk4, of=(1, 1, 1, 1))),
            share=0.25,
        ),
        *readings(
            "The torque is frozen from one instant to the next",
            "The torque changes within a step: at which time, angle and speed does each evaluation need it?",
            replace(one_step_each, asked=lambda now, at, begin: at),
            replace(one_step_each, asked=lambda now, at, begin: (at[0], *now[1:])),
        ),
        *readings(
            "The torque is that of the start",
            "It depends on the time, the angle and the speed: when is it evaluated?",
            replace(one_step_each, asked=lambda now, at, begin: begin),
            replace(one_step_each, asked=lambda now, at, begin: (begin[0], *now[1:])),
            replace(one_step_each, asked=lambda now, at, begin: (0.0, *now[1:])),
            replace(one_step_each, asked=lambda now, at, begin: (0.0, *begin[1:])),
        ),
        Variant(
            "The time is counted from the first instant",
            "The first instant need not be zero, and the torque wants the time itself.",
            replace(one_step_each, asked=lambda now, at, begin: (now[0] - begin[0], *now[1:])),
        ),
        Variant(
            "The torque is forgotten",
            "What moves the crank?",
            replace(one_step_each, factor=0),
        ),
        Variant(
            "The torque has the wrong sign",
            "A positive torque turns the crank on: which sign does `acceleration` want?",
            replace(one_step_each, factor=-1),
        ),
        Variant(
            "The initial speed is lost",
            "The motion starts at an angle and with a speed.",
            replace(one_step_each, start=lambda theta, omega: (theta, 0.0)),
        ),
        Variant(
            "The initial angle is lost",
            "The motion starts at an angle and with a speed.",
            replace(one_step_each, start=lambda theta, omega: (0.0, omega)),
        ),
        *readings(
            "The start is taken for degrees",
            "Angle and speed come in rad and rad/s.",
            replace(one_step_each, start=lambda theta, omega: (math.radians(theta), math.radians(omega))),
            replace(one_step_each, start=lambda theta, omega: (math.radians(theta), omega)),
        ),
        Variant(
            "The initial speed is taken for revolutions per minute",
            "It is in rad/s already.",
            replace(one_step_each, start=lambda theta, omega: (theta, omega * RPM)),
        ),
        *readings(
            "Angles and speeds are returned in degrees",
            "Radians are asked for.",
            changed(np.rad2deg),
            changed(lambda found: found * [180 / np.pi, 1]),
        ),
        *readings(
            "Coupler and blades stay where they were at the start",
            "The crank takes them along: where must the loop be closed?",
            *(replace(one_step_each, position=stale(2, with_crank)) for with_crank in (False, True)),
        ),
        *readings(
            "The loop is closed only once a step",
            "The crank moves on within a step, and coupler and blades with it.",
            *(replace(one_step_each, position=stale(1, with_crank)) for with_crank in (False, True)),
        ),
        Variant(
            "The loop is closed on the other branch",
            "The wiper is built so that the blade is ahead of the coupler by less than half a turn.",
            replace(one_step_each, position=lambda now, at, begin, lengths: closed(now[1], lengths, side=1)),
        ),
        *readings(
            "The instants are taken as evenly spaced",
            "Each step is as long as the instants are apart.",
            replace(one_step_each, instants=lambda t: t[0] + (t[1] - t[0]) * np.arange(len(t))),
            replace(one_step_each, instants=lambda t: np.linspace(t[0], t[-1], len(t))),
        ),
        Variant(
            "The integrator keeps its default accuracy",
            "`solve_ivp` allows an error of a thousandth in every step unless it is told otherwise.",
            by_default,
            share=0.25,
        ),
        Variant(
            "Rows and columns are exchanged",
            "A row holds the state of one instant.",
            changed(np.transpose),
            share=0.5,
        ),
        Variant(
            "The speed comes before the angle",
            "In which order does the task ask for them?",
            changed(lambda found: found[:, ::-1]),
            share=0.5,
        ),
        Variant(
            "The start is missing",
            "There are as many rows as instants, and the first instant is that of the start.",
            changed(lambda found: found[1:]),
            share=0.5,
        ),
        Variant(
            "The last instant is missing",
            "There are as many rows as instants.",
            changed(lambda found: found[:-1]),
            share=0.5,
        ),
        Variant(
            "Where the loop cannot close, nan is returned",
            "NumPy warns and goes on. Who reads the motion must not have to look for nan.",
            replace(one_step_each, position=nan_where_open),
            share=0.75,
            kind="dead",
        ),
        Variant(
            "Where the loop cannot close, the motion goes on",
            "No bar reaches the next joint there: which angle did you give to `acceleration`?",
            replace(one_step_each, position=lambda now, at, begin, lengths: closed(now[1], lengths, force=True)),
            share=0.75,
            kind="dead",
        ),
        *readings(
            "A start and instants that cannot be are not refused",
            "Look at them before the first step.",
            replace(one_step_each, looks=False),
            replace(one_step_each, looks=False, position=nan_of_nan),
            share=0.75,
            kind="bad",
        ),
    ),
)

# --- energy_drift -----------------------------------------------------------------------------------------------------


def trapezoids(power: np.ndarray, t: np.ndarray) -> np.ndarray:
    return np.concatenate(([0.0], np.cumsum(np.diff(t) * (power[1:] + power[:-1]) / 2)))


def energy_less_that_at_the_start(energy: np.ndarray, work: np.ndarray) -> np.ndarray:
    return energy - energy[0] - work


@dataclass(frozen=True)
class Account:
    """Energy and work along a motion, with terms that can be forgotten: 1 is right."""

    translation: float = 1
    rotation: float = 1  # of every body but the bar
    bar_turning: float = 0
    half: float = 0.5
    lifted: tuple[float, ...] = (1, 1, 1, 1, 1)  # the potential energy of each body
    height: Callable = np.imag
    inertia: Callable = lambda bars: bars[:, 2]
    paths: Callable = points
    torque: float = 1
    loads: float = 1
    work: Callable = trapezoids
    drift: Callable = energy_less_that_at_the_start

    def energies(self, position, velocity, lengths, bars) -> tuple[np.ndarray, np.ndarray]:
        e, mass, inertia = directions(position), bars[:, 1], self.inertia(bars)
        speed = np.abs(self.velocities(position, velocity, lengths, bars))
        turning = np.asarray(velocity)[:, TURNS_WITH] ** 2 @ inertia[:4]
        turning += self.bar_turning * inertia[BAR] * velocity[:, 2] ** 2
        heights = self.height(e @ points(lengths, bars)[1].T)
        kinetic = self.half * (self.translation * speed**2 @ mass + self.rotation * turning)
        return kinetic, GRAVITY * heights @ (mass * self.lifted)

    def velocities(self, position, velocity, lengths, bars) -> np.ndarray:
        """Of the centres of mass, as complex numbers."""
        e, w = directions(position), np.column_stack((np.zeros(len(velocity)), velocity))
        return 1j * (w * e) @ self.paths(lengths, bars)[1].T

    def __call__(self, t, position, velocity, torque, loads, lengths, bars) -> np.ndarray:
        if not len(t) == len(position) == len(velocity) == len(torque) == len(loads):
            raise ValueError("there must be as many positions, velocities, torques and loads as instants")
        v = self.velocities(position, velocity, lengths, bars)[:, [FIRST, SECOND]]
        of_loads = (v.conjugate() * (loads @ [1, 1j])).real.sum(axis=1)
        power = self.torque * torque * velocity[:, 0] + self.loads * of_loads
        energy = sum(self.energies(position, velocity, lengths, bars))
        return self.drift(energy, self.work(power, t))


RIGHT_ACCOUNT = Account()


def energy_cases(rng: np.random.Generator) -> list[Case]:
    def case(torque: bool, loads: bool, kind: str = "normal") -> Case:
        lengths, bars = random_machine(rng)
        n = int(rng.integers(40, 60))
        t = rng.uniform(0.2, 0.8) + np.concatenate(([0], np.cumsum(rng.uniform(0.5, 1.5, n - 1)))) * 0.02
        speed, swing, rate = rng.uniform([5, 0.2, 5], [8, 0.4, 8]) * rng.choice([-1, 1], 3)
        theta1 = rng.uniform(0, TURN) + speed * t + swing * np.sin(rate * t)
        omega1 = speed + swing * rate * np.cos(rate * t)
        position = np.array([closed(theta, lengths) for theta in theta1.tolist()])
        velocity = omega1[:, None] * [[1, *ratios(q, lengths)] for q in position.tolist()]
        given = rng.uniform(1, 3) + rng.uniform(-1, 1, n) if torque else np.zeros(n)
        acting = rng.uniform(1, 3, (2, 2)) * rng.choice([-1, 1], (2, 2)) + rng.uniform(-1, 1, (n, 2, 2))
        acting = acting if loads else np.zeros((n, 2, 2))
        return Case((t, position, velocity, given, acting, lengths, bars), kind=kind, label=f"{n} instants")

    free, unequal = case(False, False), case(True, True).args
    while np.ptp(np.sign(RIGHT_ACCOUNT(*free.args)[1:])) == 0:
        free = case(False, False)
    too_few = [
        Case(
            tuple(each[:few] if k == place else each for k, each in enumerate(unequal)),
            kind="unequal",
            label=f"{few} {name}, and {len(unequal[0])} of the others",
        )
        for place, (few, name) in enumerate(
            ((2, "instants"), (1, "position"), (1, "velocity"), (1, "torque"), (1, "pair of loads"))
        )
    ]
    return [
        free,
        case(True, False, "torque"),
        case(True, True, "work"),
        coasting_case(rng),
        *too_few,
    ]


def coasting_case(rng: np.random.Generator) -> Case:
    """A motion that obeys the laws."""
    machine, _, _, t, lengths = args = moves_smoothly(rng, driven=False)
    theta1, omega1 = driven_motion(*args).T
    position = np.array([closed(theta, lengths) for theta in theta1.tolist()])
    velocity = omega1[:, None] * [[1, *ratios(q, lengths)] for q in position.tolist()]
    n = len(t)
    args = (t, position, velocity, np.zeros(n), np.zeros((n, 2, 2)), lengths, machine.bars)
    return Case(args, kind="coasting", label="a motion without torque and loads")


def stays(trial: Trial, right: Trial) -> str | None:
    got = array(trial, right.outcome.value.shape, "(points,)")
    if isinstance(got, str):
        return got
    _, position, velocity, _, _, lengths, bars = trial.case.args
    kinetic, _ = RIGHT_ACCOUNT.energies(position, velocity, lengths, bars)
    return None if np.abs(got).max() < 1e-5 * kinetic.max() else "it drifts where the motion obeys the laws"


def account(**parts) -> Callable:
    return replace(RIGHT_ACCOUNT, **parts)


def about_the_joint(bars: np.ndarray) -> np.ndarray:
    return bars[:, 2] + bars[:, 1] * bars[:, 0] ** 2


def coupler_about_a(lengths, bars):
    joints, centres = points(lengths, bars)
    centres[COUPLER, 1] = 0
    return joints, centres


def without(*bars: int) -> tuple[float, ...]:
    return tuple(0.0 if k in bars else 1.0 for k in range(5))


def work_at_the_left(power, t):
    return np.concatenate(([0.0], np.cumsum(np.diff(t) * power[:-1])))


def work_at_the_right(power, t):
    return np.concatenate(([0.0], np.cumsum(np.diff(t) * power[1:])))


def in_degrees(*args):
    t, position, *rest = args
    return RIGHT_ACCOUNT(t, np.deg2rad(position), *rest)


def stretched_by_numpy(t, *args):
    n = max(map(len, args[:4]))
    t = t if len(t) == n else t[0] + np.diff(t) * np.arange(n)
    return RIGHT_ACCOUNT(t, *(np.broadcast_to(each, (n, *each.shape[1:])) for each in args[:4]), *args[4:])


def without_the_bar(t, position, velocity, torque, loads, lengths, bars):
    lighter = bars.copy()
    lighter[BAR, 1] = 0
    return RIGHT_ACCOUNT(t, position, velocity, torque, loads, lengths, lighter)


ENERGY_DRIFT = Task(
    name="energy_drift",
    title="the energy that came from nowhere",
    function="energy_drift",
    reference=RIGHT_ACCOUNT,
    cases=energy_cases,
    tolerance=NEAR,
    section="wiper-direct-dynamics: Energy as a witness",
    aspects=(
        Aspect("without torque and loads: kinetic and potential energy, less those at the start", 1.0),
        Aspect("it stays zero along a motion that obeys the laws", 0.25, stays, kind="coasting"),
        Aspect("less the work of the torque", 0.25, kind="torque"),
        Aspect("less the work of the loads as well", 0.25, kind="work"),
        Aspect("it raises ValueError if the arrays do not have the same points", 0.25, kind="unequal"),
    ),
    variants=(
        Variant(
            "The energy at the start is not subtracted",
            "A drift begins at zero.",
            account(drift=lambda energy, work: energy - work),
            share=0.25,
        ),
        *readings(
            "The drift is relative",
            "The drift is asked for in joules.",
            account(drift=lambda energy, work: (energy - energy[0] - work) / energy[0]),
            account(drift=lambda energy, work: (energy - energy[0] - work) / np.abs(energy).max()),
            share=0.25,
        ),
        Variant(
            "The drift has no sign",
            "Energy can come and go: the sign tells which.",
            account(drift=lambda energy, work: np.abs(energy - energy[0] - work)),
            share=0.5,
        ),
        Variant(
            "The potential energy has the wrong sign",
            "What is lifted gains potential energy.",
            account(lifted=(-1,) * 5),
            share=0.25,
        ),
        Variant(
            "The potential energy is forgotten",
            "What is lifted gains energy.",
            account(lifted=(0,) * 5),
            share=0.25,
        ),
        Variant(
            "The potential energy is taken from x",
            "Weight points downwards: along which axis?",
            account(height=np.real),
            share=0.25,
        ),
        Variant(
            "The bar has no potential energy",
            "The bar does not turn. Is it lifted?",
            account(lifted=without(BAR)),
            share=0.25,
        ),
        Variant(
            "The bar is left out",
            "There are five bodies.",
            without_the_bar,
            share=0.25,
        ),
        Variant(
            "The rotation is missing in the kinetic energy",
            "A body that turns about its centre of mass has kinetic energy.",
            account(rotation=0),
            share=0.25,
        ),
        Variant(
            "The translation is missing in the kinetic energy",
            "The moments of inertia are about the centres of mass, and those move.",
            account(translation=0),
            share=0.25,
        ),
        Variant(
            "The translation is counted twice in the kinetic energy",
            "The moment of inertia about a joint holds the motion of the centre of mass already.",
            account(inertia=about_the_joint),
            share=0.25,
        ),
        Variant(
            "The kinetic energy has no factor of one half",
            "Which constant does the integral of v dv bring?",
            account(half=1),
            share=0.25,
        ),
        Variant(
            "The coupler moves as if A were fixed",
            "Its centre of mass is carried along by A.",
            account(paths=coupler_about_a),
            share=0.25,
        ),
        Variant(
            "The bar moves like B",
            "Which joint does the bar hang on, and how far is it from C?",
            account(paths=bar_like_b),
            share=0.25,
        ),
        Variant(
            "The bar turns with the blades",
            "D-E is as long as C-F, and the blades are parallel. How much does the bar turn?",
            account(bar_turning=1),
            share=0.25,
        ),
        Variant(
            "The work has the wrong sign",
            "Work that is done on the machine is in its energy: what is left when it is taken away?",
            account(drift=lambda energy, work: energy - energy[0] + work),
            share=0.5,
            kind="work",
        ),
        Variant(
            "The work is forgotten",
            "Torque and loads change the energy, and that is no drift.",
            account(torque=0, loads=0),
            share=0.5,
            kind="work",
        ),
        Variant(
            "The work of the torque is forgotten",
            "What does a torque give per second at this angular velocity?",
            account(torque=0),
            share=0.5,
            kind="work",
        ),
        Variant(
            "The work of the torque has the wrong sign",
            "A torque along the motion gives energy to the machine.",
            account(torque=-1),
            share=0.5,
            kind="work",
        ),
        Variant(
            "The work of the loads is forgotten",
            "What does a force give per second at the point where it acts?",
            account(loads=0),
            share=0.75,
            kind="work",
        ),
        Variant(
            "The work of the loads has the wrong sign",
            "A force along the motion gives energy to the machine.",
            account(loads=-1),
            share=0.75,
            kind="work",
        ),
        *readings(
            "The power is summed up without trapezoids",
            "Between two instants the power changes: which mean of the two do trapezoids take?",
            account(work=work_at_the_left),
            account(work=work_at_the_right),
            share=0.5,
            kind="work",
        ),
        *readings(
            "The instants are taken as evenly spaced",
            "Each trapezoid is as wide as its two instants are apart.",
            account(work=lambda power, t: trapezoids(power, t[0] + (t[1] - t[0]) * np.arange(len(t)))),
            account(work=lambda power, t: trapezoids(power, np.linspace(t[0], t[-1], len(t)))),
            share=0.5,
            kind="work",
        ),
        Variant(
            "The whole work is subtracted at every instant",
            "At each instant, only the work until then has been done.",
            account(work=lambda power, t: trapezoids(power, t)[-1]),
            share=0.5,
            kind="work",
        ),
        Variant(
            "The power is subtracted, and not the work",
            "Joules less watts: what is between the two?",
            account(work=lambda power, t: power),
            share=0.5,
            kind="work",
        ),
        Variant(
            "The angles are taken for degrees",
            "They are in radians, and NumPy wants radians.",
            in_degrees,
        ),
        *readings(
            "Arrays of unequal length are paired by force",
            "`zip` cuts, and NumPy stretches an array of one point: compare the lengths first.",
            lambda *args: RIGHT_ACCOUNT(*(each[: min(map(len, args[:5]))] for each in args[:5]), *args[5:]),
            stretched_by_numpy,
            share=0.75,
            kind="unequal",
        ),
    ),
)

# --- smooth_friction --------------------------------------------------------------------------------------------------


def smooth_friction(velocity, size: float, v0: float) -> np.ndarray:
    if not v0 > 0:
        raise ValueError(f"v0 must be positive, got {v0}")
    return dynamics.friction(velocity, size, v0)


def friction_by(fading: Callable, along: Callable | None = None) -> Callable:
    """Another law: fading(|v|/v0) is its size, along(v, |v|) its direction."""

    def law(velocity, size, v0):
        velocity = np.asarray(velocity, dtype=float)
        speed = np.linalg.norm(velocity, axis=-1, keepdims=True)
        unit = velocity / np.where(speed > 0, speed, 1)
        return -size * (along(velocity, speed) if along else unit) * fading(speed / v0)

    return law


def nothing_by_nothing(velocity, size, v0):
    return smooth_friction(np.where(velocity == 0, np.nan, velocity), size, v0)


def friction_cases(rng: np.random.Generator) -> list[Case]:
    def case(low: float, high: float, shape: tuple[int, ...], kind: str = "normal") -> Case:
        """Speeds from low to high times v0, in any direction that is not along an axis."""
        v0, size = float(10 ** rng.uniform(-3, -1)), float(rng.uniform(2, 8))
        speed = v0 * 10 ** rng.uniform(np.log10(low), np.log10(high), shape)
        angle = rng.uniform(0.2, TURN / 4 - 0.2, shape) + TURN / 4 * rng.integers(0, 4, shape)
        velocity = speed[..., None] * np.stack((np.cos(angle), np.sin(angle)), axis=-1)
        label = f"shape {velocity.shape}, speeds from {low:g} to {high:g} v0"
        return Case((velocity, size, v0), kind=kind, label=label)

    around, (points_, size, v0) = case(0.2, 3, (12,), "around"), case(1e-9, 1e-3, (9,)).args
    points_[[2, 5]] = 0
    bad = case(0.2, 30, (4,)).args[0]
    return [
        case(40, 4000, (20,)),
        case(40, 4000, (6, 2)),
        case(40, 4000, ()),
        around,
        case(0.2, 3, (5, 2), "around"),
        Case((points_, size, v0), kind="rest", label="at rest, and very near it"),
        Case((np.zeros(2), size, v0), kind="rest", label="one point at rest"),
        *(Case((bad, 3.0, v0), kind="bad", label=f"v0 = {v0:g}") for v0 in (0.0, -float(rng.uniform(0.01, 0.9)))),
        *(
            Case((bad, size, 0.05), kind="bad", label=f"size = {size:g}")
            for size in (0.0, -float(rng.uniform(0.1, 0.9)))
        ),
    ]


def wrong_number(velocity, size, v0) -> tuple[float, ...]:
    return (size,) if size < 0 else (v0,)


def whole_and_against(trial: Trial, right: Trial) -> str | None:
    """Size and direction, from the velocity alone."""
    velocity, size, _ = trial.case.args
    got = array(trial, velocity.shape, "(..., 2)")
    if isinstance(got, str):
        return got
    speed, force = np.linalg.norm(velocity, axis=-1), np.linalg.norm(got, axis=-1)
    if not (np.abs(force - size) <= 1e-9 * size).all():
        return "its size is not that of friction"
    against = (got * velocity).sum(axis=-1)
    return None if (np.abs(against + size * speed) <= 1e-9 * size * speed).all() else "it is not against the velocity"


SMOOTH_FRICTION = Task(
    name="smooth_friction",
    title="friction without chatter near rest",
    function="smooth_friction",
    reference=smooth_friction,
    cases=friction_cases,
    tolerance=NEAR,
    section="wiper-direct-dynamics: Friction that comes to rest",
    aspects=(
        Aspect("away from rest it has the given size, and is against the velocity", 0.75, whole_and_against),
        Aspect("around v0 it fades as the hyperbolic tangent of |v|/v0", 0.5, kind="around"),
        Aspect("at rest it is zero, and near rest as small as the speed is", 0.5, kind="rest"),
        Aspect(
            "it raises ValueError for a size or a width that cannot be, and tells it",
            0.25,
            refuses(wrong_number, NEAR),
            kind="bad",
        ),
    ),
    variants=(
        Variant(
            "The friction is along the motion",
            "Friction takes energy: which sign has its power?",
            lambda *args: -smooth_friction(*args),
        ),
        *readings(
            "The friction is taken component by component",
            "One force acts against one velocity: how large is it when both components are full?",
            friction_by(np.ones_like, lambda v, speed: np.sign(v)),
            lambda velocity, size, v0: -size * np.tanh(np.asarray(velocity) / v0),
            friction_by(np.tanh, lambda v, speed: np.sign(v)),
            kind="around",
        ),
        Variant(
            "It is source B's formula, as printed in our copy",
            "Put in a velocity along an axis: how large should the force be?",
            lambda velocity, size, v0: (
                -size * np.sign(velocity) - velocity / np.linalg.norm(velocity, axis=-1, keepdims=True)
            ),
        ),
        Variant(
            "The friction does not fade near rest",
            "A force that leaps at rest makes an integrator chatter. What does the width v0 do?",
            friction_by(np.ones_like),
            share=0.25,
            kind="around",
        ),
        Variant(
            "It fades in a straight line",
            "The task asks for the hyperbolic tangent, which has no corner.",
            friction_by(lambda x: np.minimum(x, 1)),
            share=0.25,
            kind="around",
        ),
        *readings(
            "It fades by another law",
            "The task asks for the hyperbolic tangent.",
            friction_by(lambda x: x / np.sqrt(1 + x**2)),
            friction_by(lambda x: x / (1 + x)),
            friction_by(lambda x: 2 / np.pi * np.arctan(x)),
            friction_by(lambda x: 1 - np.exp(-x)),
            kind="around",
        ),
        *readings(
            "It grows with the speed",
            "Dry friction is as large at any speed: which part of the formula is a direction, and not a velocity?",
            friction_by(lambda x: x),
            friction_by(np.tanh, lambda v, speed: v),
            friction_by(np.ones_like, lambda v, speed: v),
            kind="around",
        ),
        Variant(
            "The speed is multiplied by the width, and not divided",
            "tanh wants a number without a unit.",
            lambda velocity, size, v0: friction_by(np.tanh)(velocity, size, 1 / v0),
        ),
        Variant(
            "The size of the friction is missing",
            "How large is it away from rest?",
            lambda velocity, size, v0: smooth_friction(velocity, 1.0, v0),
        ),
        Variant(
            "The width is missing",
            "How fast is fast, and how slow is slow? v0 tells.",
            lambda velocity, size, v0: smooth_friction(velocity, size, 1.0),
        ),
        *readings(
            "One norm is taken over all points",
            "Each velocity has a length of its own: along which axis are its two components?",
            lambda velocity, size, v0: (
                -size * velocity / np.linalg.norm(velocity) * np.tanh(np.linalg.norm(velocity) / v0)
            ),
            lambda velocity, size, v0: (
                -size * velocity / np.sqrt((velocity**2).sum(axis=0)) * np.tanh(np.sqrt((velocity**2).sum(axis=0)) / v0)
            ),
        ),
        Variant(
            "The length of the velocity is the sum of its components",
            "Pythagoras.",
            friction_by(
                lambda x: np.ones_like(x),
                lambda v, speed: v / np.maximum(np.abs(v).sum(axis=-1, keepdims=True), 1e-300),
            ),
        ),
        *readings(
            "Only its size is returned",
            "A force has two components.",
            lambda velocity, size, v0: size * np.tanh(np.linalg.norm(velocity, axis=-1) / v0),
            lambda velocity, size, v0: -size * np.tanh(np.linalg.norm(velocity, axis=-1) / v0),
        ),
        Variant(
            "At rest it is not a number",
            "Zero divided by zero: what is the force at rest?",
            nothing_by_nothing,
            share=0.5,
            kind="rest",
        ),
        Variant(
            "A size and a width that cannot be are not refused",
            "Look at them before you divide.",
            friction_by(np.tanh),
            share=0.75,
            kind="bad",
        ),
    ),
)

EXERCISE = Exercise(
    name="10_wiper_direct_dynamics",
    title="The windscreen wiper under the torque of its motor",
    tasks=(DIRECT_SYSTEM, DRIVEN_MOTION, ENERGY_DRIFT, SMOOTH_FRICTION),
    imports=("newton", "require"),
)
