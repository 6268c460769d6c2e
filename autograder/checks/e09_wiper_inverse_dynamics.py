"""Exercise 9: torque and joint forces of the windscreen wiper, and two witnesses of them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from autograder.checks.answers import array, arrays, refuses, said
from autograder.checks.e05_consecutive import TURN
from autograder.checks.plane import xy
from autograder.compare import Tolerance, difference, disagreement, numbers
from autograder.outcome import Lost, Outcome, Raised, Value
from autograder.spec import Aspect, Case, Exercise, Task, Trial, Variant, readings
from mechlib import dynamics, rigidbody
from mechlib.wiper import BODIES, Wiper

G = 9.81
EXACT = Tolerance(1e-9, "a formula is right to round-off")
CRANK, COUPLER, FIRST, SECOND, BAR = range(5)
JOINTS = tuple(joint.name for joint in Wiper.rigid.joints)
B, D, E = map(JOINTS.index, "BDE")
ABOUT = [JOINTS.index(body.about) for body in Wiper.rigid.bodies]
SIDES = tuple(  # of each body: +1 where a joint force acts on it as it is, -1 where it acts with the opposite sign
    tuple((joint.on == body) - (joint.by == body) for joint in Wiper.rigid.joints) for body in BODIES
)
ALIKE, OPPOSITE = (tuple(tuple(map(of, sides)) for sides in SIDES) for of in (abs, lambda side: -side))
TURNS_WITH = [0, 1, 2, 2]  # the angle of each body but the bar, which is in translation
RUBBED = [FIRST, SECOND]

# --- a wiper that moves -----------------------------------------------------------------------------------------------


def in_the_plane(v: np.ndarray) -> np.ndarray:
    return v[..., 0] + 1j * v[..., 1]


def cross(arm: np.ndarray, force: np.ndarray) -> np.ndarray:
    return (arm.conj() * force).imag


def carried(e: np.ndarray, lengths: np.ndarray, rG: np.ndarray) -> np.ndarray:
    """What O to F and G1 to G5 have of the directions of crank, coupler and rocker, or of their derivatives."""
    _, r1, _, r3, r4, _, _ = lengths
    e1, e2, e3 = e.T
    o, a, b, d = 0 * e1, r1 * e1, r3 * e3, r4 * e3
    return np.stack((o, a, b, o, d, d, o, rG[0] * e1, a + rG[1] * e2, rG[2] * e3, rG[3] * e3, d), axis=-1)


def places(theta: np.ndarray, lengths: np.ndarray, rG: np.ndarray) -> np.ndarray:
    """O to F and G1 to G5 as complex numbers, shape (points, 12)."""
    c, f = lengths[0], lengths[0] + lengths[5]
    return carried(np.exp(1j * theta), lengths, rG) + np.array([0, 0, c, c, c, f, f, 0, 0, c, f, c + rG[4]])


@dataclass(frozen=True)
class Moving:
    """A wiper at some instants, and what the tasks hand out of it."""

    motion: np.ndarray
    lengths: np.ndarray
    bars: np.ndarray
    loads: np.ndarray

    @classmethod
    def drawn(cls, rng: np.random.Generator, points: int) -> "Moving":
        """A crank-rocker whose coupler and rocker are never nearer than 20 degrees to a line, with any masses."""
        while True:
            r2 = rng.uniform(0.18, 0.3)
            r0, r1, r3 = r2 * rng.uniform([0.95, 0.3, 0.6], [1.25, 0.5, 0.95])
            far, near = ((r2**2 + r3**2 - (r0 + side * r1) ** 2) / (2 * r2 * r3) for side in (1, -1))
            if max(-far, near) < np.cos(np.deg2rad(20)):
                break
        r4 = r3 * rng.uniform(1.4, 2.2)
        wiper = Wiper(r0, r1, r2, r3, r4, rng.uniform(0.2, 0.4), r4 * rng.uniform(1.5, 2.2))
        u, du = rng.uniform(0, TURN, points), rng.uniform(2.5, 5, points) * rng.choice([-1, 1])
        ddu = rng.uniform(4, 15, points) * rng.choice([-1, 1], points)
        q = wiper.position(u)
        states = zip((u, du, ddu), (q, *wiper.loop.rates(q, u, du, ddu)), strict=True)
        bars = np.column_stack((rng.uniform(0.05, 0.3, 5), rng.uniform(0.1, 0.6, 5), 10 ** rng.uniform(-3, -2, 5)))
        loads = rng.uniform(2, 6, (points, 2, 2)) * rng.choice([-1, 1], (points, 2, 2))
        return cls(np.array([np.column_stack(each) for each in states]), np.array(wiper.constants[:7]), bars, loads)

    @property
    def label(self) -> str:
        return f"{self.motion.shape[1]} points, r1 to r5 = {', '.join(f'{r:.3g}' for r in self.lengths[1:6])} m"

    @cached_property
    def places(self) -> np.ndarray:
        return xy(places(self.motion[0], self.lengths, self.bars[:, 0]))

    @cached_property
    def velocities(self) -> np.ndarray:
        """Of the centres of mass."""
        theta, omega, _ = self.motion
        return xy(carried(1j * omega * np.exp(1j * theta), self.lengths, self.bars[:, 0])[:, 7:])

    @cached_property
    def accelerations(self) -> np.ndarray:
        """Of the centres of mass."""
        return accelerations(self.motion, self.lengths, self.bars)

    def system(self, loads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return fifteen(self.motion, self.accelerations, loads, self.lengths, self.bars)

    def solved(self, off: np.ndarray | float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """Torque and forces of its loads, with something wrong on the right side."""
        matrix, right = self.system(self.loads)
        return split(np.linalg.solve(matrix, (right + off)[..., None])[..., 0])


def split(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return x[:, 0], x[:, 1:].reshape(len(x), len(JOINTS), 2)


def of_n_points(n: int, **given: np.ndarray) -> None:
    """ValueError if one of the arrays is not one of n points; a single one is stretched by NumPy without a word."""
    for name, each in given.items():
        if np.shape(each)[:1] != (n,):
            raise ValueError(f"{name} has the shape {np.shape(each)}, and there are {n} points")


def refused(trial: Trial, right: Trial) -> str | None:
    return disagreement(right.outcome, trial.outcome, EXACT)


def pair(outcome: Outcome, names: Sequence[str], shapes: Sequence[tuple[int, ...]]) -> tuple[np.ndarray, ...] | str:
    return arrays(outcome, dict(zip(names, shapes, strict=True)), f"a pair ({', '.join(names)})")


def near(right: np.ndarray, answer: np.ndarray, tolerance: Tolerance) -> bool:
    """`difference` without words: many known mistakes are compared."""
    allowed = tolerance.relative * np.abs(right, where=np.isfinite(right), out=np.zeros(right.shape)).max(initial=0)
    return bool(((np.abs(answer - right) <= allowed) | (np.isnan(answer) & np.isnan(right))).all())


def same_pair(split_up: Callable, names: Sequence[str], tolerance: Tolerance) -> Callable:
    """Whether two pairs are the same, each of the pieces that `split_up` makes of them on its own scale."""

    def agree(expected: Outcome, got: Outcome) -> str | None:
        if not (isinstance(expected, Value) and isinstance(got, Value)):
            return disagreement(expected, got, tolerance)
        right = [np.asarray(part) for part in expected.value]
        answer = pair(got, names, [part.shape for part in right])
        if isinstance(answer, str):
            return answer
        pieces = zip(split_up(*right), split_up(*answer), strict=True)
        return None if all(near(*piece, tolerance) for piece in pieces) else "a part of it is off"

    return agree


# --- steiner ----------------------------------------------------------------------------------------------------------


def steiner(inertia, mass, given, wanted) -> np.ndarray:
    central = rigidbody.steiner(inertia, -mass, given)
    if (central <= 0).any():
        raise ValueError(f"about the centre of mass the moment would be {central[central <= 0][0]:.6g}")
    return rigidbody.steiner(central, mass, wanted)


def steiner_unrefused(inertia, mass, given, wanted):
    return inertia + mass * (wanted**2 - given**2)


def steiner_cases(rng: np.random.Generator) -> list[Case]:
    def bars(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Bodies of five particles each: mass, moment about the centre of mass, and two distances from it."""
        m = rng.uniform(0.05, 0.4, (n, 5))
        z = rng.uniform(0.1, 0.6, (n, 5)) * np.exp(1j * rng.uniform(0, TURN, (n, 5)))
        off = z - ((m * z).sum(axis=1) / m.sum(axis=1))[:, None]
        # any two distances, but as far from each other as from zero
        near, far = rng.uniform([[0.1], [0.35]], [[0.2], [0.6]], (2, n))
        return m.sum(axis=1), (m * np.abs(off) ** 2).sum(axis=1), *rng.permuted([near, far], axis=0)

    def case(given: float, wanted: float, kind: str, label: str) -> Case:
        n = int(rng.integers(4, 8))
        mass, central, one, other = bars(n)
        one, other = given * one, wanted * other
        return Case((central + mass * one**2, mass, one, other), kind=kind, label=f"{n} bars, {label}")

    def impossible() -> Case:
        n = int(rng.integers(4, 8))
        mass, central, one, other = bars(n)
        central[rng.integers(n)] *= -rng.uniform(0.05, 0.3)
        return Case((central + mass * one**2, mass, one, other), kind="impossible", label="a bar that cannot be")

    return [
        case(0, 1, "out", "from the centre of mass"),
        case(1, 0, "back", "to the centre of mass"),
        case(1, 1, "normal", "from one axis to another"),
        case(1, 1, "normal", "from one axis to another"),
        impossible(),
    ]


def the_moment_or_its_rest(inertia, mass, given, wanted) -> tuple[float, ...]:
    central = inertia - mass * given**2
    return inertia[central <= 0][0], central[central <= 0][0]


STEINER = Task(
    name="steiner",
    title="moments of inertia about parallel axes",
    function="steiner",
    reference=steiner,
    cases=steiner_cases,
    tolerance=EXACT,
    section="wiper-inverse-dynamics: Mass properties by Steiner",
    aspects=(
        Aspect("from the centre of mass to another axis", 0.5, kind="out"),
        Aspect("from another axis to the centre of mass", 0.5, kind="back"),
        Aspect("from any parallel axis to any other", 0.5),
        Aspect("it raises ValueError where no body can have such a moment", 0.25, kind="impossible"),
        Aspect(
            "its message tells that moment, or what is left of it about the centre of mass",
            0.25,
            refuses(the_moment_or_its_rest, EXACT),
            kind="impossible",
        ),
    ),
    variants=(
        Variant(
            "The given moments are taken for those about the centre of mass",
            "Steiner's rule begins at the centre of mass: does `inertia` hold for it?",
            lambda inertia, mass, given, wanted: inertia + mass * wanted**2,
            share=0.25,
        ),
        Variant(
            "The moments about the centre of mass are returned",
            "That is half of the way: to which axis does it go on?",
            lambda inertia, mass, given, wanted: steiner(inertia, mass, given, 0 * wanted),
            share=0.25,
        ),
        *readings(
            "The distance between the two axes is squared",
            "Steiner's rule measures from the centre of mass. Does it hold between two other axes?",
            lambda inertia, mass, given, wanted: inertia + mass * (wanted - given) ** 2,
            lambda inertia, mass, given, wanted: inertia + mass * (wanted - given) * np.abs(wanted - given),
            share=0.25,
        ),
        Variant(
            "m d^2 is added on the way to the centre of mass",
            "Of all parallel axes, about which is the moment least?",
            lambda inertia, mass, given, wanted: inertia + mass * (given**2 + wanted**2),
            share=0.25,
        ),
        Variant(
            "m d^2 is subtracted on the way from the centre of mass",
            "Of all parallel axes, about which is the moment least?",
            lambda inertia, mass, given, wanted: steiner(inertia, mass, given, 0 * wanted) - mass * wanted**2,
            share=0.25,
        ),
        Variant(
            "m d^2 is added and subtracted the wrong way round",
            "Of all parallel axes, about which is the moment least?",
            lambda inertia, mass, given, wanted: steiner_unrefused(inertia, mass, wanted, given),
        ),
        Variant(
            "The distances are not squared",
            "kg m is no moment of inertia.",
            lambda inertia, mass, given, wanted: inertia - mass * given + mass * wanted,
        ),
        Variant(
            "The weight stands where the mass belongs",
            "N m s^2 is kg m^2: which unit has your second term?",
            lambda inertia, mass, given, wanted: inertia + mass * G * (wanted**2 - given**2),
        ),
        Variant(
            "The mass is missing from the second term",
            "m^2 is no moment of inertia.",
            lambda inertia, mass, given, wanted: inertia + wanted**2 - given**2,
        ),
        Variant(
            "A moment that no body can have goes through",
            "What is left of it about the centre of mass?",
            steiner_unrefused,
            share=0.75,
            kind="impossible",
        ),
    ),
)


# --- centre_accelerations ---------------------------------------------------------------------------------------------

STEP = 5e-4  # s
DERIVATIVE = Tolerance(1e-6, "differences over two steps to each side are right to 1e-8 of the scale here")
CENTRES = ("G1", "G2", "G3", "G4", "G5")


def accelerations(motion, lengths, bars) -> np.ndarray:
    lost = ~np.isfinite(motion).all(axis=(0, 2))
    if lost.any():
        raise ValueError(f"there is no position at index {np.argmax(lost)}")
    return accelerations_by()(motion, lengths, bars)


def accelerations_by(
    centripetal: float = 1.0,
    tangential: float = 1.0,
    power: int = 2,
    unit: Callable = lambda theta: np.exp(1j * theta),
    at: Callable = lambda lengths, rG: (lengths, rG),
    changed: Callable = lambda a, of_unit, lengths, rG: a,
) -> Callable:
    """The accelerations with one of the parts exchanged.

    Parameters
    ----------
    at : (lengths, rG) -> those that are used.
    changed : (a, of_unit, lengths, rG) -> a, complex; `of_unit` is of a point at 1 m along crank, coupler and rocker.
    """

    def wrong(motion, lengths, bars):
        theta, omega, alpha = motion
        of_unit = (tangential * 1j * alpha - centripetal * omega**power) * unit(theta)
        lengths, rG = at(lengths, bars[:, 0])
        a = carried(of_unit, lengths, rG)[:, 7:]
        return xy(changed(a, of_unit, lengths, rG))

    return wrong


def put(column: int, value: Callable) -> Callable:
    """Exchange one of the five."""

    def changed(a, of_unit, lengths, rG):
        a[:, column] = value(of_unit.T, lengths, rG)
        return a

    return accelerations_by(changed=changed)


# the lengths of which half is taken for rG: those of C-D or of the whole blades; source B draws r3/2 on the coupler
HALVES = ((1, 2, 4, 4, 5), (1, 2, 6, 6, 5), (1, 3, 4, 4, 5))


def at_the_middles(*of_bars: int) -> Callable:
    return lambda lengths, rG: (lengths, np.array([lengths[k] / 2 for k in of_bars]))


def in_degrees(*which: int) -> Callable:
    """Angles, velocities or accelerations taken for degrees."""

    def wrong(motion, lengths, bars):
        motion = motion.copy()
        motion[list(which)] = np.deg2rad(motion[list(which)])
        return accelerations_by()(motion, lengths, bars)

    return wrong


def without_the_centripetal_of_a(motion, lengths, bars):
    a = accelerations_by()(motion, lengths, bars)
    theta, omega, _ = motion
    a[:, COUPLER] += xy(lengths[1] * omega[:, 0] ** 2 * np.exp(1j * theta[:, 0]))
    return a


def acceleration_cases(rng: np.random.Generator) -> list[Case]:
    def case(points: int) -> Case:
        w = Moving.drawn(rng, points)
        return Case((w.motion, w.lengths, w.bars), label=w.label)

    w = Moving.drawn(rng, 12)
    motion, lost = w.motion.copy(), int(rng.integers(4, 8))
    motion[:, lost:10, 1:] = np.nan
    # no other number in a message is taken for the index: there are neither 4 to 7 axes nor bodies beside it
    return [case(7), case(10), Case((motion, w.lengths, w.bars), kind="open", label=f"nan from index {lost} on")]


def is_the_second_difference(*columns: int) -> Callable:
    """Whether the accelerations are those of points that bars carry, from where the points are a little later."""

    def fault(trial: Trial, right: Trial) -> str | None:
        motion, lengths, bars = trial.case.args
        got = array(trial, (motion.shape[1], 5, 2), "(points, 5, 2)")
        if isinstance(got, str):
            return got
        theta, omega, alpha = motion
        z = [places(theta + omega * t + alpha * t**2 / 2, lengths, bars[:, 0])[:, 7:] for t in STEP * np.arange(-2, 3)]
        expected = xy(16 * (z[1] + z[3]) - (z[0] + z[4]) - 30 * z[2]) / (12 * STEP**2)
        for k in columns:
            if why := difference(expected[:, k], got[:, k], DERIVATIVE):
                return f"{CENTRES[k]}: {why}"
        return None

    return fault


def tells_the_first(trial: Trial, right: Trial) -> str | None:
    if fault := refused(trial, right):
        return fault
    first = np.argmax(~np.isfinite(trial.case.args[0]).all(axis=(0, 2)))
    return None if first in said(trial.outcome.message) else "its message does not tell the index of the first point"


CENTRE_ACCELERATIONS = Task(
    name="centre_accelerations",
    title="accelerations of the five centres of mass, for all points in one call",
    function="centre_accelerations",
    reference=accelerations,
    cases=acceleration_cases,
    tolerance=DERIVATIVE,
    section="wiper-inverse-dynamics: How the centres of mass accelerate",
    aspects=(
        Aspect(
            "G1, G3 and G4 accelerate as points that turn about O, C and F", 0.75, is_the_second_difference(0, 2, 3)
        ),
        Aspect("G2 accelerates as a point that A carries along", 0.5, is_the_second_difference(1)),
        Aspect("G5 accelerates as a point of a bar in translation", 0.5, is_the_second_difference(4)),
        Aspect(
            "nan is refused with a ValueError that tells the index of the first such point",
            0.25,
            tells_the_first,
            "open",
        ),
    ),
    variants=(
        Variant(
            "The centripetal terms are missing",
            "A crank at constant speed still accelerates its points: towards what?",
            accelerations_by(centripetal=0),
            share=0.25,
        ),
        Variant(
            "The centripetal terms point outwards",
            "A cosine that is differentiated twice comes back with which sign?",
            accelerations_by(centripetal=-1),
            share=0.25,
        ),
        Variant(
            "The tangential terms are missing",
            "The angular accelerations are given, and they are not zero.",
            accelerations_by(tangential=0),
            share=0.25,
        ),
        Variant(
            "The tangential terms have the wrong sign",
            "Which way does a point go when an angle grows?",
            accelerations_by(tangential=-1),
            share=0.25,
        ),
        Variant(
            "The angular velocities are not squared",
            "Which unit has r omega?",
            accelerations_by(power=1),
            share=0.25,
        ),
        Variant(
            "The acceleration of A is missing from G2",
            "The coupler turns about A, and A does not stand still.",
            put(COUPLER, lambda e, lengths, rG: rG[1] * e[1]),
            share=0.6,
        ),
        Variant(
            "The centripetal acceleration of A is missing from G2",
            "A moves on a circle.",
            without_the_centripetal_of_a,
            share=0.6,
        ),
        Variant(
            "The bar has the acceleration of B, and not that of D",
            "At which distance from C is the joint that carries the bar? Source B has this slip.",
            put(BAR, lambda e, lengths, rG: lengths[3] * e[2]),
            share=0.6,
        ),
        *readings(
            "The bar turns",
            "D-E is as long as C-F: can the angle of the bar change?",
            *(put(BAR, lambda e, lengths, rG, with_=k: lengths[4] * e[2] + rG[4] * e[with_]) for k in (2, 1)),
            share=0.6,
        ),
        *readings(
            "The centres of mass are taken at the middles of the bars",
            "The blades are not even along their length: `bars` tells where each centre of mass is.",
            *(accelerations_by(at=at_the_middles(*halves)) for halves in HALVES),
            share=0.25,
        ),
        Variant(
            "The centres of mass of the two blades are exchanged",
            "The first blade turns about C, and is the third of the five. Source B exchanges the two somewhere.",
            accelerations_by(at=lambda lengths, rG: (lengths, rG[[0, 1, 3, 2, 4]])),
            share=0.25,
        ),
        Variant(
            "Coupler and rocker exchange their angles",
            "In which order does `motion` hold the three angles?",
            lambda motion, lengths, bars: accelerations_by()(motion[:, :, [0, 2, 1]], lengths, bars),
        ),
        Variant(
            "Sine and cosine are exchanged",
            "The angles are measured from the horizontal: which component does the cosine give?",
            accelerations_by(unit=lambda theta: np.sin(theta) + 1j * np.cos(theta)),
        ),
        *readings(
            "The angles are taken for degrees",
            "They are in radians, and NumPy wants radians.",
            in_degrees(0),
            in_degrees(0, 1, 2),
        ),
        Variant(
            "The velocities are returned",
            "Differentiate once more.",
            lambda motion, lengths, bars: xy(
                carried(1j * motion[1] * np.exp(1j * motion[0]), lengths, bars[:, 0])[:, 7:]
            ),
            share=0.25,
        ),
        Variant(
            "Gravity is added",
            "Gravity is a force, and it comes in with the equations. Here is only how the points move.",
            lambda *args: accelerations_by()(*args) + np.array([0, G]),
            share=0.25,
        ),
        Variant(
            "The sizes are returned, and not the vectors",
            "The equations need x and y.",
            lambda *args: np.linalg.norm(accelerations_by()(*args), axis=-1),
            share=0.5,
        ),
        Variant(
            "The bars come first, and the points second",
            "The shape is (points, 5, 2).",
            lambda *args: accelerations_by()(*args).swapaxes(0, 1),
            share=0.5,
        ),
        Variant(
            "nan goes through",
            "A sweep leaves nan where the loop cannot close: whoever reads the torque must not have to look for it.",
            accelerations_by(),
            share=0.875,
            kind="open",
        ),
    ),
)

# --- fifteen_equations ------------------------------------------------------------------------------------------------

BOTH = (1.0, 1.0)  # in the equations of the forces, and in those of the moments


@dataclass(frozen=True)
class Fifteen:
    """The system, with parts that can be forgotten or exchanged: 1 is right.

    Attributes
    ----------
    weight, load, inertial : a pair of factors each, in the forces and in the moments.
    steiner : of what the moments of inertia have more about the joints than about the centres of mass.
    of_joints : of each body, what its moments have from the acceleration of its joint; without a wrong arm only A and
        D have one.
    spun : of a moment of inertia of the bar, with the angular acceleration of the blades.
    at : (theta, lengths, rG) -> those that are used.
    sides : of the joint forces in the equations of the forces, and in those of the moments.
    arms : (complex arms of the joints, arms of the centres of mass, lengths) -> the same, changed.
    """

    weight: tuple[float, float] = BOTH
    load: tuple[float, float] = BOTH
    inertial: tuple[float, float] = BOTH
    steiner: float = 1
    of_joints: tuple[float, ...] = (1, 1, 1, 1, 1)
    spun: float = 0
    at: Callable = lambda theta, lengths, rG: (theta, lengths, rG)
    sides: tuple = (SIDES, SIDES)
    arms: Callable = lambda arms, of_centres, lengths: (arms, of_centres)

    def __call__(self, motion, accelerations, loads, lengths, bars) -> tuple[np.ndarray, np.ndarray]:
        _, m, inertia = bars.T
        theta, lengths, rG = self.at(motion[0], lengths, bars[:, 0])
        turning = np.zeros((len(theta), 5))
        turning[:, :4] = motion[2][:, TURNS_WITH]
        z, n = places(theta, lengths, rG), len(theta)
        about = z[:, ABOUT]
        arms = z[:, None, :7] - about[:, :, None]
        arms[:, COUPLER, B] = lengths[2] * np.exp(1j * theta[:, 1])  # with wrong angles the loop is open
        arms, r = self.arms(arms, z[:, 7:] - about, lengths)

        of_forces, of_moments = map(np.array, self.sides)
        matrix = np.zeros((n, 5, 3, 15))
        matrix[:, CRANK, 2, 0] = 1
        matrix[:, :, 0, 1::2] = matrix[:, :, 1, 2::2] = of_forces
        matrix[:, :, 2, 1::2], matrix[:, :, 2, 2::2] = -of_moments * arms.imag, of_moments * arms.real

        a, load = in_the_plane(accelerations), np.zeros((n, 5), complex)
        load[:, RUBBED] = in_the_plane(np.asarray(loads))
        force, moment = (
            m * (inertial * a + 1j * weight * G) - factor * load
            for inertial, weight, factor in zip(self.inertial, self.weight, self.load, strict=True)
        )
        about_centre = inertia * turning
        about_centre[:, BAR] += self.spun * inertia[BAR] * motion[2][:, 2]
        spin = m * np.abs(r) ** 2 * turning  # the part of Steiner in the moments of m a
        of_joint = m * cross(r, a) - spin
        changed = self.inertial[1] * (about_centre + (self.steiner - 1) * spin)
        changed += (np.array(self.of_joints) - 1) * of_joint
        right = np.stack((force.real, force.imag, changed + cross(r, moment)), axis=-1)
        return matrix.reshape(n, 15, 15), right.reshape(n, 15)


RIGHT = Fifteen()


def fifteen(motion, accelerations, loads, lengths, bars) -> tuple[np.ndarray, np.ndarray]:
    n = motion.shape[1]
    if np.shape(loads) != (n, 2, 2):
        raise ValueError(f"loads has the shape {np.shape(loads)}, and not {(n, 2, 2)}")
    return RIGHT(motion, accelerations, loads, lengths, bars)


def then(change: Callable) -> Callable:
    return lambda *args: change(*RIGHT(*args))


def rows(order: Sequence[int]) -> Callable:
    return then(lambda matrix, right: (matrix[:, order], right[:, order]))


def times(of_matrix, of_right) -> Callable:
    return then(lambda matrix, right: (matrix * of_matrix, right * of_right))


A_AT_REST = (1, 0, 1, 1, 1)
BY_THE_JOINT = (0, 1, 0, 0, 1)  # I_P alpha where the joint is fixed, and not m r x a
MOMENTS = np.arange(15) % 3 == 2
SIGNS = np.where(MOMENTS, -1, 1)
X, Y, M = (list(range(k, 15, 3)) for k in range(3))


def scaled(body: int, joint: int, factor: Callable) -> Callable:
    """One of the arms times a ratio of lengths."""

    def arms(arms, of_centres, lengths):
        arms[:, body, joint] *= factor(*lengths)
        return arms, of_centres

    return replace(RIGHT, arms=arms)


def bar_held_at_its_end(arms, of_centres, lengths):
    of_centres[:, BAR] = lengths[5]
    return arms, of_centres


def both_ways(**part) -> tuple[Callable, Callable]:
    """A wrong arm in m r x a, or in the moments of inertia about the joints."""
    return replace(RIGHT, **part), replace(RIGHT, of_joints=BY_THE_JOINT, **part)


def middles(halves: Sequence[int]) -> Callable:
    return lambda theta, lengths, rG: (theta, *at_the_middles(*halves)(lengths, rG))


def in_degrees_taken(theta, lengths, rG):
    return np.deg2rad(theta), lengths, rG


def crossed(arms, of_centres, lengths):
    """x of an arm for y, where there is an angle."""
    arms[:, :BAR], of_centres[:, :BAR] = 1j * arms[:, :BAR].conj(), 1j * of_centres[:, :BAR].conj()
    return arms, of_centres


PARTS = ("the forces in the matrix", "the moments in the matrix", "the forces on the right", "the moments on the right")


def pieces(matrix: np.ndarray, right: np.ndarray) -> tuple[np.ndarray, ...]:
    """Equations of the forces and of the moments apart, for these are small; others' shapes in one piece."""
    if matrix.ndim != 3 or matrix.shape[1:] != (15, 15) or right.ndim != 2 or right.shape[1:] != (15,):
        return matrix, right
    return matrix[:, ~MOMENTS], matrix[:, MOMENTS], right[:, ~MOMENTS], right[:, MOMENTS]


def equation_cases(rng: np.random.Generator) -> list[Case]:
    def case(w: Moving, loads: np.ndarray, kind: str, words: str = "") -> Case:
        return Case((w.motion, w.accelerations, loads, w.lengths, w.bars), kind=kind, label=w.label + words)

    normal = [Moving.drawn(rng, int(n)) for n in rng.integers(4, 8, 2)]
    two, five = Moving.drawn(rng, 2), Moving.drawn(rng, 5)
    return [
        *(case(w, w.loads, "normal") for w in normal),
        case(two, two.loads[0], "shape", ", loads of one point alone"),
        case(five, five.loads[:1], "shape", ", loads of one point alone"),
        case(five, five.loads[:3], "shape", ", loads of three points"),
    ]


def system_of(trial: Trial) -> tuple[np.ndarray, ...] | str:
    n = trial.case.args[0].shape[1]
    return pair(trial.outcome, ("matrix", "right"), ((n, 15, 15), (n, 15)))


def piece(k: int) -> Callable:
    """Looks at one of the four, and says in which equations something is wrong."""

    def fault(trial: Trial, right: Trial) -> str | None:
        got = system_of(trial)
        if isinstance(got, str):
            return got
        wanted, answer = pieces(*right.outcome.value)[k], pieces(*got)[k]
        if not (why := difference(wanted, answer, EXACT)):
            return None
        off = ~(np.abs(answer - wanted) <= EXACT.relative * np.abs(wanted).max())
        of_rows = off.reshape(*off.shape[:2], -1).any(axis=(0, 2))
        names = [name for name, is_moment in zip(Wiper.rigid.inverse.rows, MOMENTS, strict=True) if is_moment == k % 2]
        wrong = "; ".join(name for name, is_off in zip(names, of_rows, strict=True) if is_off)
        return f"{PARTS[k]} are wrong in the rows {wrong}" + ("" if why.startswith("it is off") else f": {why}")

    return fault


def balances_each_body(trial: Trial, right: Trial) -> str | None:
    """The forces that solve the system, looked at body by body: no part of the reference is used."""
    got = system_of(trial)
    if isinstance(got, str):
        return got
    motion, accelerations, loads, lengths, bars = trial.case.args
    try:
        torque, forces = split(np.linalg.solve(got[0], got[1][..., None])[..., 0])
    except np.linalg.LinAlgError:
        return "the matrix is singular"
    at = xy(places(motion[0], lengths, bars[:, 0]))
    left = residuals(motion, at, accelerations, loads, bars, torque, forces)
    if np.abs(left).max() < 1e-9 * np.abs(forces).max():
        return None
    return "the torque and the forces that solve them leave a body out of balance"


def spread(matrix, right):
    return matrix, right[..., None]


FIFTEEN_EQUATIONS = Task(
    name="fifteen_equations",
    title="the 15 x 15 system, for all points in one call",
    function="fifteen_equations",
    reference=fifteen,
    cases=equation_cases,
    agree=same_pair(pieces, ("matrix", "right"), EXACT),
    tolerance=EXACT,
    section="wiper-inverse-dynamics: Fifteen equations",
    aspects=(
        Aspect("matrix, rows of the forces: each joint force acts on two bodies, with opposite signs", 0.75, piece(0)),
        Aspect("matrix, rows of the moments: the arms of the joints, and the torque", 1.0, piece(1)),
        Aspect("right side of the forces: masses, weights and loads", 0.75, piece(2)),
        Aspect("right side of the moments about O, A, C, F and D", 1.0, piece(3)),
        Aspect("the torque and the forces that solve them leave every body in balance", 0.25, balances_each_body),
        Aspect("loads of another shape are refused with a ValueError", 0.25, refused, kind="shape"),
    ),
    variants=(
        *readings(
            "I_G stands where the moment about the joint belongs",
            "The moments are about a joint, and `bars` has the moments of inertia about the centres of mass.",
            replace(RIGHT, steiner=0),
            replace(RIGHT, steiner=0, of_joints=A_AT_REST),
            share=0.6,
        ),
        Variant(
            "Steiner's term is counted twice",
            "m r x a of the centre of mass holds it already: does the moment of inertia bring it once more?",
            replace(RIGHT, steiner=2),
            share=0.6,
        ),
        Variant(
            "The acceleration of A is missing from the moments about A",
            "A is no fixed point: what more than I_A alpha2 is there?",
            replace(RIGHT, of_joints=A_AT_REST),
            share=0.6,
        ),
        *readings(
            "The weight is forgotten",
            "Which force acts on every body, whether it moves or not?",
            replace(RIGHT, weight=(0, 0)),
            replace(RIGHT, weight=(1, 0)),
            replace(RIGHT, weight=(0, 1)),
            share=0.5,
        ),
        Variant(
            "The weight is counted twice",
            "m (a + g) holds it once.",
            replace(RIGHT, weight=(2, 2)),
            share=0.5,
        ),
        *readings(
            "The weight pulls upwards",
            "y points upwards: on which side of the equation is m g, and with which sign?",
            replace(RIGHT, weight=(-1, -1)),
            replace(RIGHT, weight=(1, -1)),
            replace(RIGHT, weight=(-1, 1)),
            share=0.5,
        ),
        *readings(
            "The loads are forgotten",
            "Two known forces act on the blades: where do they stand?",
            replace(RIGHT, load=(0, 0)),
            replace(RIGHT, load=(1, 0)),
            replace(RIGHT, load=(0, 1)),
            share=0.5,
        ),
        *readings(
            "The loads have the wrong sign",
            "A known force goes to the other side of the equation.",
            replace(RIGHT, load=(-1, -1)),
            replace(RIGHT, load=(1, -1)),
            replace(RIGHT, load=(-1, 1)),
            share=0.5,
        ),
        Variant(
            "m a and I alpha have the wrong sign",
            "The sum of the forces is m a. With which sign does it stand on the right?",
            replace(RIGHT, inertial=(-1, -1)),
            share=0.5,
        ),
        Variant(
            "The centre of mass of the bar has the arm r5",
            "Source B has this slip. How far from D is the centre of mass of the bar?",
            replace(RIGHT, arms=bar_held_at_its_end),
            share=0.75,
        ),
        Variant(
            "E has half of the bar as its arm",
            "How far from D is E?",
            scaled(BAR, E, lambda *r: 0.5),
            share=0.6,
        ),
        Variant(
            "E has the arm r4 + a on the second blade",
            "In source B r4 contains a = r4 - r3 already. How far from F is E?",
            scaled(SECOND, E, lambda r0, r1, r2, r3, r4, r5, r6: (2 * r4 - r3) / r4),
            share=0.6,
        ),
        Variant(
            "D has the arm r3 on the first blade",
            "r3 leads from C to B. How far from C is D?",
            scaled(FIRST, D, lambda r0, r1, r2, r3, r4, r5, r6: r3 / r4),
            share=0.6,
        ),
        *readings(
            "The bar has an angular acceleration",
            "Can the angle of a bar change that is as long as C-F, between two blades of the same length?",
            replace(RIGHT, spun=1),
            share=0.75,
        ),
        *readings(
            "The centres of mass are taken at the middles of the bars",
            "The blades are not even along their length: `bars` tells where each centre of mass is.",
            *(wrong for halves in HALVES for wrong in both_ways(at=middles(halves))),
            share=0.6,
        ),
        *readings(
            "A joint force acts on both bodies with the same sign",
            "Action and reaction: what the one body does to the other comes back with which sign?",
            replace(RIGHT, sides=(ALIKE, ALIKE)),
            replace(RIGHT, sides=(ALIKE, SIDES)),
            replace(RIGHT, sides=(SIDES, ALIKE)),
            share=0.25,
        ),
        Variant(
            "Every joint force has the opposite sign",
            "The convention says on which of its two bodies each force acts as it is.",
            replace(RIGHT, sides=(OPPOSITE, OPPOSITE)),
            share=0.6,
        ),
        Variant(
            "The moments count clockwise",
            "The equations hold as well, but the convention is that moments count counter-clockwise.",
            times(SIGNS[:, None], SIGNS),
            share=0.75,
        ),
        Variant(
            "All equations have the opposite sign",
            "They hold as well, but by the convention the unknowns act on the left, and m a stands on the right.",
            times(-1, -1),
            share=0.75,
        ),
        Variant(
            "The torque has the wrong sign",
            "The torque acts on the crank, counter-clockwise like all moments.",
            times(np.where(np.arange(15) == 0, -1, 1), 1),
            share=0.75,
        ),
        *readings(
            "Sine and cosine are exchanged in the arms",
            "A moment is x times the force along y, less y times the force along x: which is the cosine's?",
            *both_ways(arms=crossed),
            share=0.5,
        ),
        *readings(
            "The angles are taken for degrees",
            "They are in radians, and NumPy wants radians.",
            *both_ways(at=in_degrees_taken),
            lambda motion, *rest: RIGHT(np.deg2rad(motion), *rest),
            share=0.5,
        ),
        Variant(
            "First come all rows of x, then those of y, then the moments",
            "The rows go body by body.",
            rows(X + Y + M),
            share=0.75,
        ),
        Variant(
            "The five moments come after the ten forces",
            "The rows go body by body: each has three.",
            rows(sorted(X + Y) + M),
            share=0.75,
        ),
        Variant(
            "The torque is the last unknown",
            "The convention names the order of the unknowns.",
            then(lambda matrix, right: (np.roll(matrix, -1, axis=2), right)),
            share=0.75,
        ),
        Variant(
            "All components along x come before those along y",
            "The unknowns go joint by joint.",
            then(lambda matrix, right: (matrix[:, :, [0, *range(1, 15, 2), *range(2, 15, 2)]], right)),
            share=0.75,
        ),
        Variant(
            "The matrix is transposed",
            "A row is an equation, a column an unknown.",
            then(lambda matrix, right: (matrix.swapaxes(1, 2), right)),
            share=0.5,
        ),
        Variant(
            "The right side is a matrix of one column",
            "Its shape is (points, 15).",
            then(spread),
            share=0.75,
        ),
        Variant(
            "Loads of another shape go through",
            "NumPy stretches what does not fit, if it can: compare the shapes first.",
            lambda motion, a, loads, *rest: RIGHT(motion, a, np.broadcast_to(loads, (motion.shape[1], 2, 2)), *rest),
            share=0.75,
            kind="shape",
        ),
    ),
)

# --- torque_and_forces ------------------------------------------------------------------------------------------------

SOLVED = Tolerance(1e-6, "a solve is right to 1e-14 of the scale here, and to 1e-8 where the matrix is nearly singular")
MOST_CONDITION = 1e12
NEARLY = 1e-8  # of the largest singular value
SMALLEST_LEFT = 1e-12  # an inverse leaves some 1e-9


def against(velocities, size) -> np.ndarray:
    return dynamics.friction(velocities, size)


def not_singular(matrix: np.ndarray) -> None:
    singular = ~(np.linalg.cond(matrix) <= MOST_CONDITION)
    if singular.any():
        raise ValueError(f"the matrix is singular at index {np.argmax(singular)}")


def solved_by(
    friction: Callable = against,
    solve: Callable = np.linalg.solve,
    changed: Callable = lambda torque, forces: (torque, forces),
    unknowns: Callable = lambda x: x,
    look: Callable = lambda matrix: None,
) -> Callable:
    """Torque and forces, with one of the parts exchanged."""

    def wrong(system, velocities, size):
        matrix, right = system(friction(velocities, size))
        look(matrix)
        return changed(*split(unknowns(solve(matrix, right[..., None])[..., 0])))

    return wrong


def by_component(velocities, size) -> np.ndarray:
    return -size * np.sign(velocities)


def of_the_source(velocities, size) -> np.ndarray:
    return by_component(velocities, size) + against(velocities, 1)


torque_and_forces = solved_by(look=not_singular)


def of_the_first_point(matrix, right):
    return np.linalg.solve(np.broadcast_to(matrix[:1], matrix.shape), right)


def late(values: np.ndarray, first: float = 1.0) -> np.ndarray:
    """Each point has what the one before should have."""
    return np.concatenate((first * values[:1], values[:-1]))


def linear_system(w: Moving, rng: np.random.Generator, spoil: str = "") -> Callable:
    """(loads) -> (matrix, right) of a wiper; made nearly singular at all points, or singular at some."""
    points = w.motion.shape[1]
    ready = w.system(np.zeros((points, 2, 2)))
    lost = np.zeros((points, 15))
    if spoil == "nearly":
        u, s, v = np.linalg.svd(ready[0])
        s[:, :-1], s[:, -1] = 1, NEARLY
        matrix = u * s[:, None] @ v
        ready = matrix, (matrix @ rng.uniform(1, 2, (points, 15, 1)))[..., 0]
    if spoil == "singular":
        lost[int(rng.integers(3, 6)) : 8, int(rng.integers(15))] = 1

    def system(loads):
        loads = np.asarray(loads, dtype=float)
        if loads.shape != (points, 2, 2):
            raise ValueError(f"the system takes loads of the shape {(points, 2, 2)}, and got {loads.shape}")
        matrix, right = ready
        if not spoil:
            matrix, right = w.system(loads)
        return matrix * (1 - lost)[..., None], right.copy()

    return system


def solving_cases(rng: np.random.Generator) -> list[Case]:
    def case(kind: str, words: str, size: float, spoil: str = "", points: int = 0, still: Sequence[int] = ()) -> Case:
        w = Moving.drawn(rng, points or int(rng.integers(8, 13)))
        velocities = w.velocities[:, RUBBED].copy()
        velocities[:, 1] *= rng.uniform(0.5, 0.9)  # no wiper: but then the two blades can be told apart
        velocities[list(still)] = 0
        label = f"{len(velocities)} points, friction of {size:.3g} N, {words}"
        return Case((linear_system(w, rng, spoil), velocities, size), kind=kind, label=label)

    return [
        case("normal", "a wiper", 0.0),
        case("normal", "a wiper", 0.0),
        case("rubs", "a wiper", float(rng.uniform(3, 6))),
        case("rubs", "a wiper", float(rng.uniform(3, 6))),
        case("rest", "blades that stop", float(rng.uniform(3, 6)), still=rng.choice(8, 2, replace=False)),
        case("nearly", "a matrix that is nearly singular", 0.0, "nearly", 4),
        case("singular", "a matrix that is singular", 0.0, "singular", 12),
    ]


TORQUE_AND_FORCES = ("torque", "forces")


def motor_and_joints(trial: Trial, points: int) -> tuple[np.ndarray, ...] | str:
    return pair(trial.outcome, TORQUE_AND_FORCES, ((points,), (points, len(JOINTS), 2)))


def solves_the_system(trial: Trial, right: Trial) -> str | None:
    """Whether the answer fits the equations, with the friction that the task asks for."""
    got = motor_and_joints(trial, len(trial.case.args[1]))
    if isinstance(got, str):
        return got
    for name, wanted, answer in zip(TORQUE_AND_FORCES, right.outcome.value, got, strict=True):
        if why := difference(wanted, answer, SOLVED):
            return f"{name}: {why}"
    return None


def rubs_against_the_motion(trial: Trial, right: Trial) -> str | None:
    _, velocities, size = trial.case.args
    for (loads,) in trial.evaluations[0][:1]:
        speed, of_force = np.linalg.norm(velocities, axis=-1), np.linalg.norm(loads, axis=-1)
        if np.abs(of_force - size).max() > 1e-9 * size:
            return "the friction on a blade has not the size that is given"
        if np.abs((loads * velocities).sum(axis=-1) + size * speed).max() > 1e-9 * size * speed.max():
            return "the friction on a blade is not against its velocity"
    return solves_the_system(trial, right)


def asks_once(trial: Trial, right: Trial) -> str | None:
    asked = len(trial.evaluations[0])
    if asked > 1:
        return f"it asks for the equations {asked} times: they come for all points at once"
    return solves_the_system(trial, right)


def solves_and_does_not_invert(trial: Trial, right: Trial) -> str | None:
    system, velocities, _ = trial.case.args
    got = motor_and_joints(trial, len(velocities))
    if isinstance(got, str):
        return got
    x = np.column_stack((got[0], got[1].reshape(len(velocities), -1)))
    matrix, known = system(np.zeros((len(velocities), 2, 2)))
    # the norm is 1: elimination leaves some 1e-16 of x whatever the condition, an inverse 1e-16 times the condition
    left = np.abs((matrix @ x[..., None])[..., 0] - known).max() / np.abs(x).max()
    if left < SMALLEST_LEFT:
        return None
    return f"the solution leaves {left:.0e} of the scale, where a solve leaves less than 1e-14: is an inverse formed?"


def tells_where_it_is_singular(trial: Trial, right: Trial) -> str | None:
    if fault := disagreement(right.outcome, trial.outcome, SOLVED):
        return fault
    (first,) = said(right.outcome.message)
    told = first in said(trial.outcome.message)
    return None if told else "its message does not tell the index of the first point"


TORQUE = Task(
    name="torque_and_forces",
    title="torque and joint forces over a turn, with friction",
    function="torque_and_forces",
    reference=torque_and_forces,
    cases=solving_cases,
    agree=same_pair(lambda torque, forces: (torque, forces), TORQUE_AND_FORCES, SOLVED),
    tolerance=SOLVED,
    section="wiper-inverse-dynamics: Torque and forces over a turn",
    aspects=(
        Aspect("torque and forces solve the equations of every point", 0.75, solves_the_system),
        Aspect(
            "friction has the size that is given, against the motion of each blade",
            1.0,
            rubs_against_the_motion,
            "rubs",
        ),
        Aspect("a blade that stands still is not rubbed, and there is no nan", 0.25, solves_the_system, "rest"),
        Aspect("the equations of all points are asked for once", 0.25, asks_once, "rubs"),
        Aspect("the systems are solved, and no inverse is formed", 0.5, solves_and_does_not_invert, "nearly"),
        Aspect(
            "a singular matrix is refused with a ValueError that tells the index of the first such point",
            0.25,
            tells_where_it_is_singular,
            "singular",
        ),
    ),
    variants=(
        Variant(
            "The friction is along the motion",
            "Does it drive the blades, or brake them?",
            solved_by(lambda *args: -against(*args)),
            share=0.5,
            kind="rubs",
        ),
        *readings(
            "The friction is taken component by component",
            "How large is a force with two such components, and which way does it point? Source B has this slip.",
            solved_by(by_component),
            solved_by(of_the_source),
            share=0.5,
            kind="rubs",
        ),
        *readings(
            "The friction has an x component only",
            "The blades swing: which way do they go in the middle of the swing?",
            solved_by(lambda *args: against(*args) * [1, 0]),
            solved_by(lambda velocities, size: by_component(velocities, size) * [1, 0]),
            share=0.5,
            kind="rubs",
        ),
        Variant(
            "The friction grows with the speed",
            "Dry friction has one size: divide by the speed.",
            solved_by(lambda velocities, size: -size * velocities),
            share=0.5,
            kind="rubs",
        ),
        *readings(
            "Only one blade is rubbed",
            "There are two blades on the glass.",
            solved_by(lambda *args: against(*args) * [[1], [0]]),
            solved_by(lambda *args: against(*args) * [[0], [1]]),
            share=0.5,
            kind="rubs",
        ),
        Variant(
            "Each blade has half of the friction",
            "The size is that of the friction on each blade.",
            solved_by(lambda *args: against(*args) / 2),
            share=0.5,
            kind="rubs",
        ),
        Variant(
            "There is no friction",
            "Is `size` used?",
            solved_by(lambda *args: 0 * against(*args)),
            share=0.5,
            kind="rubs",
        ),
        *readings(
            "Each point has the friction of the point before",
            "A value that a loop carries from point to point: when is it renewed?",
            solved_by(lambda *args: late(against(*args))),
            solved_by(lambda *args: late(against(*args), 0)),
            solved_by(lambda *args: np.roll(against(*args), 1, axis=0)),
            share=0.5,
            kind="rubs",
        ),
        Variant(
            "The matrix of the first point serves for all",
            "The arms turn with the angles: what changes from point to point?",
            solved_by(solve=of_the_first_point),
            share=0.25,
        ),
        Variant(
            "Every point has the solution of the last",
            "An array that is filled anew at each point is the same array at each point.",
            solved_by(unknowns=lambda x: np.broadcast_to(x[-1:], x.shape)),
            share=0.25,
        ),
        *readings(
            "Each point has the solution of the point before",
            "A value that a loop carries from point to point: when is it renewed?",
            solved_by(unknowns=late),
            solved_by(unknowns=lambda x: late(x, 0)),
            solved_by(unknowns=lambda x: np.roll(x, 1, axis=0)),
            share=0.25,
        ),
        Variant(
            "The norm of the torque is returned",
            "A motor can also be driven: which sign has its torque then?",
            solved_by(changed=lambda torque, forces: (np.abs(torque), forces)),
            share=0.75,
        ),
        Variant(
            "The torque is taken from the last unknown",
            "Which place has M among the unknowns?",
            solved_by(
                changed=lambda torque, forces: (
                    forces[:, -1, 1],
                    np.column_stack((torque, forces.reshape(len(torque), -1)[:, :-1])).reshape(forces.shape),
                )
            ),
            share=0.25,
        ),
        Variant(
            "The forces are cut into x and y in the wrong order",
            "The unknowns go joint by joint: x and y of a joint are neighbours.",
            solved_by(changed=lambda torque, forces: (torque, forces.reshape(len(torque), 2, -1).swapaxes(1, 2))),
            share=0.5,
        ),
        Variant(
            "The forces are in one row",
            "The shape of the forces is (points, 7, 2).",
            solved_by(changed=lambda torque, forces: (torque, forces.reshape(len(torque), -1))),
            share=0.75,
        ),
        Variant(
            "The forces come first, and the torque second",
            "In which order does the task ask for them?",
            solved_by(changed=lambda torque, forces: (forces, torque)),
            share=0.75,
        ),
        Variant(
            "A blade that stands still gets nan",
            "Zero divided by zero: what is the friction of a blade at rest?",
            solved_by(lambda velocities, size: -size * velocities / np.linalg.norm(velocities, axis=-1, keepdims=True)),
            share=0.75,
            kind="rest",
        ),
    ),
)

# --- power_residual ---------------------------------------------------------------------------------------------------

BALANCE = Tolerance(1e-9, "a sum of products is right to round-off")


def power(
    motion,
    velocities,
    accelerations,
    loads,
    bars,
    torque,
    weight: float = 1,
    load: Sequence[float] = (1, 1),
    inertial: float = 1,
    turning: float = 1,
    spun: float = 0,
    steiner: float = 0,
    of_motor: Callable = lambda torque, omega: torque * omega[:, 0],
) -> np.ndarray:
    """What the motor and the loads give, less what the masses take; factors as those of `Fifteen`."""
    (rG, m, inertia), (_, omega, alpha) = bars.T, motion
    moved = (m[:, None] * (inertial * accelerations + [0, weight * G]) * velocities).sum(axis=(1, 2))
    about = inertia[:4] + steiner * m[:4] * rG[:4] ** 2
    turned = (about * omega[:, TURNS_WITH] * alpha[:, TURNS_WITH]).sum(axis=1)
    turned = turning * turned + spun * inertia[BAR] * omega[:, 2] * alpha[:, 2]
    given = (loads * velocities[:, RUBBED]).sum(axis=2) @ np.array(load)
    return of_motor(torque, omega) + given - moved - turned


def power_residual(motion, velocities, accelerations, loads, bars, torque) -> np.ndarray:
    of_n_points(motion.shape[1], velocities=velocities, accelerations=accelerations, loads=loads, torque=torque)
    return power(motion, velocities, accelerations, loads, bars, torque)


def power_cases(rng: np.random.Generator) -> list[Case]:
    def case(kind: str, words: str, off: float = 0.0, loaded: bool = True, cut: Callable | None = None) -> Case:
        w = Moving.drawn(rng, int(rng.integers(7, 13)))
        w = w if loaded else replace(w, loads=0 * w.loads)
        torque = w.solved()[0]
        torque = torque + off * np.abs(torque).max() * rng.uniform(0.5, 1.5, len(torque))
        args = [w.motion, w.velocities, w.accelerations, w.loads, w.bars, torque]
        if cut:
            k, shorter = cut
            args[k] = shorter(args[k])
        return Case(tuple(args), kind=kind, label=f"{w.label}, {words}")

    sides = rng.permutation([-1.0, 1.0])
    return [
        case("normal", "a wrong torque", sides[0]),
        case("normal", "a wrong torque", sides[1]),
        case("free", "a wrong torque, no friction", 1.0, loaded=False),
        case("right", "the right torque"),
        case("shape", "torque of one point alone", cut=(5, lambda torque: torque[:1])),
        case("shape", "loads of one point alone", cut=(3, lambda loads: loads[:1])),
        case("shape", "velocities of one point alone", cut=(1, lambda v: v[:1])),
        case("shape", "accelerations of one point alone", cut=(2, lambda a: a[:1])),
    ]


def is_zero(shape: Callable, scale: Callable) -> Callable:
    """Looks at a residual of right torques and forces, which come from the 15 equations."""

    def fault(trial: Trial, right: Trial) -> str | None:
        got = array(trial, shape(trial.case.args[0].shape[1]))
        if isinstance(got, str):
            return got
        left = np.abs(got).max()
        return None if left < 1e-9 * scale(*trial.case.args) else "it is not zero for what is right"

    return fault


POWER_RESIDUAL = Task(
    name="power_residual",
    title="the first witness: a power balance",
    function="power_residual",
    reference=power_residual,
    cases=power_cases,
    tolerance=BALANCE,
    section="wiper-inverse-dynamics: Two witnesses",
    aspects=(
        Aspect("without loads: the motor's power less what the energies take", 0.25, kind="free"),
        Aspect("with loads, whatever the torque", 0.25),
        Aspect(
            "it is zero where the torque is right",
            0.25,
            is_zero(lambda n: (n,), lambda motion, *rest: np.abs(rest[-1] * motion[1][:, 0]).max()),
            kind="right",
        ),
        Aspect("arrays of another number of points are refused with a ValueError", 0.25, refused, kind="shape"),
    ),
    variants=(
        Variant(
            "The weight is forgotten",
            "Where a centre of mass rises, the motor lifts it.",
            partial(power, weight=0),
        ),
        Variant(
            "The weight is counted twice",
            "m (a + g) holds it once.",
            partial(power, weight=2),
        ),
        Variant(
            "The weight has the wrong sign",
            "Does lifting cost power, or give it?",
            partial(power, weight=-1),
        ),
        Variant(
            "The friction is forgotten",
            "The loads move: what power do they give?",
            partial(power, load=(0, 0)),
            share=0.25,
        ),
        Variant(
            "The friction has the wrong sign",
            "A force against the motion gives a negative power: the dot product brings the sign.",
            partial(power, load=(-1, -1)),
            share=0.25,
        ),
        *readings(
            "The friction of one blade is forgotten",
            "There are two loads.",
            partial(power, load=(1, 0)),
            partial(power, load=(0, 1)),
            share=0.25,
        ),
        Variant(
            "The energy of turning is forgotten",
            "A body that turns about its centre of mass has kinetic energy although that does not move.",
            partial(power, turning=0),
        ),
        Variant(
            "The moments of inertia are those about the joints",
            "m a v of the centre of mass is there already: about which point must the rest be?",
            partial(power, steiner=1),
        ),
        Variant(
            "The bar turns",
            "Which bodies change their angle?",
            partial(power, spun=1),
        ),
        Variant(
            "The energy of translation is forgotten",
            "How does m v^2/2 change in time?",
            partial(power, inertial=0),
        ),
        Variant(
            "The norm of the torque is taken",
            "A motor can also be driven: which sign has its power then?",
            partial(power, of_motor=lambda torque, omega: np.abs(torque) * omega[:, 0]),
        ),
        Variant(
            "The torque is not multiplied by the angular velocity",
            "N m is no power.",
            partial(power, of_motor=lambda torque, omega: torque),
        ),
        Variant(
            "The residual has the wrong sign",
            "The task says what is to be subtracted from what.",
            lambda *args: -power(*args),
            share=0.5,
        ),
        Variant(
            "It is divided by the angular velocity of the crank",
            "A power is asked for, in W.",
            lambda motion, *args: power(motion, *args) / motion[1][:, 0],
            share=0.5,
        ),
        Variant(
            "The number of points is not looked at",
            "NumPy stretches an array of one point to all of them.",
            power,
            share=0.75,
            kind="shape",
        ),
    ),
)

# --- body_residuals ---------------------------------------------------------------------------------------------------


def residuals(
    motion,
    at,
    accelerations,
    loads,
    bars,
    torque,
    forces,
    weight: float = 1,
    load: float = 1,
    inertial: float = 1,
    turning: float = 1,
    spun: float = 0,
    driven: Sequence[float] = (1, 0, 0, 0, 0),
    sides: tuple = SIDES,
    around: float = 1,
    lever: Callable = lambda arms: arms,
) -> np.ndarray:
    """The sums of forces and moments about the centres of mass that should be zero, body by body in plain sums."""
    _, m, inertia = bars.T
    joints, centres = np.split(in_the_plane(at), [len(JOINTS)], axis=1)
    pulls, a = in_the_plane(forces), in_the_plane(accelerations)
    found = np.empty((motion.shape[1], 5, 3))
    for k, of_joints in enumerate(sides):
        acting = np.array(of_joints) * pulls
        force = acting.sum(axis=1) - m[k] * (inertial * a[:, k] + 1j * weight * G)
        if k in RUBBED:
            force += load * in_the_plane(loads[:, RUBBED.index(k)])
        moment = around * cross(lever(joints - centres[:, [k]]), acting).sum(axis=1) + driven[k] * torque
        if k == BAR:
            moment -= spun * inertia[k] * motion[2][:, 2]
        else:
            moment -= turning * inertia[k] * motion[2][:, TURNS_WITH[k]]
        found[:, k] = np.column_stack((force.real, force.imag, moment))
    return found


def body_residuals(motion, at, accelerations, loads, bars, torque, forces) -> np.ndarray:
    n = motion.shape[1]
    of_n_points(n, places=at, accelerations=accelerations, loads=loads, torque=torque, forces=forces)
    return residuals(motion, at, accelerations, loads, bars, torque, forces)


def about_the_joints(motion, at, accelerations, loads, bars, torque, forces):
    """All moments about the joint of each body, with the moment of inertia about the centre of mass."""
    moved = at.copy()
    moved[:, 7:] = at[:, ABOUT]
    return residuals(motion, moved, accelerations, loads, bars, torque, forces)


def residual_cases(rng: np.random.Generator) -> list[Case]:
    def case(kind: str, words: str, off: float = 0.0, cut: tuple | None = None) -> Case:
        w = Moving.drawn(rng, int(rng.integers(7, 13)))
        torque, forces = w.solved()
        torque = torque + off * np.abs(torque).max() * rng.uniform(0.5, 1.5, torque.shape) * rng.choice([-1, 1])
        scatter = rng.uniform(0.5, 1.5, forces.shape) * rng.choice([-1, 1], forces.shape)
        forces = forces + off * np.abs(forces).max() * scatter
        args = [w.motion, w.places, w.accelerations, w.loads, w.bars, torque, forces]
        if cut:
            k, shorter = cut
            args[k] = shorter(args[k])
        return Case(tuple(args), kind=kind, label=f"{w.label}, {words}")

    return [
        case("normal", "wrong torque and forces", 0.3),
        case("normal", "wrong torque and forces", 0.3),
        case("right", "right torque and forces"),
        case("shape", "torque of one point alone", 0.3, cut=(5, lambda torque: torque[:1])),
        case("shape", "forces of one point alone", 0.3, cut=(6, lambda forces: forces[:1])),
        case("shape", "loads of one point alone", 0.3, cut=(3, lambda loads: loads[:1])),
        case("shape", "places of one point alone", 0.3, cut=(1, lambda at: at[:1])),
        case("shape", "accelerations of one point alone", 0.3, cut=(2, lambda a: a[:1])),
    ]


def sums(*columns: int) -> Callable:
    def fault(trial: Trial, right: Trial) -> str | None:
        wanted = right.outcome.value
        got = array(trial, wanted.shape, "(points, 5, 3)")
        if isinstance(got, str):
            return got
        for k, name in enumerate(BODIES):
            if why := difference(wanted[:, k, list(columns)], got[:, k, list(columns)], BALANCE):
                return f"{name}: {why}"
        return None

    return fault


def same_sums(expected: Outcome, got: Outcome) -> str | None:
    """Forces and moments each on their own scale."""
    if isinstance(expected, Value) and isinstance(got, Value):
        right, answer = np.asarray(expected.value), numbers(got.value)
        if (
            not isinstance(answer, str)
            and answer.shape == right.shape
            and right.ndim == 3
            and right.shape[1:] == (5, 3)
        ):
            parts = ((right[..., part], answer[..., part]) for part in (slice(2), 2))
            return None if all(near(*pair, BALANCE) for pair in parts) else "a sum is off"
    return disagreement(expected, got, BALANCE)


BODY_RESIDUALS = Task(
    name="body_residuals",
    title="the second witness: each body about its own centre of mass",
    function="body_residuals",
    reference=body_residuals,
    cases=residual_cases,
    agree=same_sums,
    tolerance=BALANCE,
    section="wiper-inverse-dynamics: Two witnesses",
    aspects=(
        Aspect("the sums of the forces, body by body, whatever torque and forces are", 0.25, sums(0, 1)),
        Aspect("the sums of the moments about each centre of mass", 0.25, sums(2)),
        Aspect(
            "they are zero where torque and forces are right",
            0.25,
            is_zero(lambda n: (n, 5, 3), lambda *args: np.abs(args[-1]).max()),
            kind="right",
        ),
        Aspect("arrays of another number of points are refused with a ValueError", 0.25, refused, kind="shape"),
    ),
    variants=(
        Variant(
            "A joint force acts on both bodies with the same sign",
            "Action and reaction: which body feels the force as it is, and which the opposite?",
            partial(residuals, sides=ALIKE),
        ),
        Variant(
            "Every joint force has the opposite sign",
            "The convention says on which of its two bodies each force acts as it is.",
            partial(residuals, sides=OPPOSITE),
        ),
        Variant("The weight is forgotten", "Which force acts on every body?", partial(residuals, weight=0)),
        Variant("The weight is counted twice", "m (a + g) holds it once.", partial(residuals, weight=2)),
        Variant("The weight pulls upwards", "y points upwards.", partial(residuals, weight=-1)),
        Variant("The loads are forgotten", "What else acts on the two blades?", partial(residuals, load=0)),
        Variant(
            "The loads have the wrong sign",
            "The loads act on the blades as they are handed in.",
            partial(residuals, load=-1),
        ),
        Variant(
            "m a has the wrong sign",
            "What is left when m a is taken away from the sum of the forces?",
            partial(residuals, inertial=-1),
        ),
        Variant(
            "I alpha has the wrong sign",
            "What is left when I alpha is taken away from the sum of the moments?",
            partial(residuals, turning=-1),
            share=0.25,
        ),
        Variant(
            "I alpha is forgotten",
            "The sum of the moments is not zero where a body turns faster and faster.",
            partial(residuals, turning=0),
            share=0.25,
        ),
        Variant(
            "The bar turns",
            "Can the angle of the bar change?",
            partial(residuals, spun=1),
            share=0.25,
        ),
        Variant(
            "The torque is forgotten",
            "On which body does the motor act?",
            partial(residuals, driven=(0, 0, 0, 0, 0)),
            share=0.25,
        ),
        Variant(
            "The torque acts on every body",
            "The motor drives one body, and stands on the ground.",
            partial(residuals, driven=(1, 1, 1, 1, 1)),
            share=0.25,
        ),
        Variant(
            "The moments are about the joints",
            "About the centre of mass no weight and no m a has a moment: which arms are left?",
            about_the_joints,
            share=0.25,
        ),
        Variant(
            "The arms lead from the joints to the centre of mass",
            "An arm begins at the point about which the moments are.",
            partial(residuals, lever=lambda arms: -arms),
            share=0.25,
        ),
        Variant(
            "x and y are exchanged in the moments",
            "A moment is x times the force along y, less y times the force along x.",
            partial(residuals, lever=lambda arms: arms.imag + 1j * arms.real),
            share=0.25,
        ),
        Variant(
            "All residuals have the opposite sign",
            "The task says what is to be subtracted from what.",
            lambda *args: -residuals(*args),
            share=0.5,
        ),
        Variant(
            "The number of points is not looked at",
            "NumPy stretches an array of one point to all of them.",
            residuals,
            share=0.75,
            kind="shape",
        ),
    ),
)

# --- planted_mistake --------------------------------------------------------------------------------------------------

LEAST = 1e-3  # of the largest power, force or torque, as the task says
Answer = tuple[bool, int | None]
ANY = -1  # whichever body: round-off is different in every right way to add


def left_over(motion, at, velocities, accelerations, loads, bars, torque, forces) -> tuple[float, np.ndarray]:
    """The largest residual of the power, and those of each body, (5, 2): forces and moment, in parts of the largest."""
    watts = power(motion, velocities, accelerations, loads, bars, torque)
    each = np.abs(residuals(motion, at, accelerations, loads, bars, torque, forces)).max(axis=0)
    of_power = np.abs(watts).max() / np.abs(torque * motion[1][:, 0]).max()
    newtons, moments = each[:, :2].max(axis=1) / np.abs(forces).max(), each[:, 2] / np.abs(torque).max()
    return of_power, np.column_stack((newtons, moments))


def planted_by(
    bodies: Callable = lambda off: off.max(axis=1),
    sees: Callable = lambda of_power: of_power > LEAST,
    says: Callable = lambda seen, body: (seen, body),
) -> Callable:
    def find(*args) -> Answer:
        of_power, off = left_over(*args)
        each = bodies(off)
        return says(bool(sees(of_power)), int(each.argmax()) if each.max() > LEAST else None)

    return find


planted_mistake = planted_by()


def unless_power_holds(*args) -> Answer:
    seen, body = planted_mistake(*args)
    return seen, body if seen else None


def by_the_largest_force(*args) -> Answer:
    seen, body = planted_mistake(*args)
    forces = np.abs(args[-1]).max(axis=(0, 2))
    return seen, None if body is None else int(np.argmax([forces[np.array(of) != 0].max() for of in SIDES]))


def any_residual_counts(choose: Callable, always_seen: bool, *args) -> Answer:
    """The largest residual is named, or that of the first or the last body, however small."""
    seen, body = planted_mistake(*args)
    return seen or always_seen, ANY if body is None else choose(body)


UNSEEN = [(k, axis) for k in (CRANK, FIRST, SECOND) for axis in (0, 1)]
ALONG_THE_BAR = BAR, 0  # which has no moment about its centre of mass
SEEN = [(CRANK, 2), (COUPLER, 0), (COUPLER, 1), (COUPLER, 2), (FIRST, 2), (SECOND, 2), (BAR, 1)]


def planting_cases(rng: np.random.Generator) -> list[Case]:
    def case(words: str, plant: Callable, sign: int = 1) -> Case:
        """With masses so small, or without a mistake so large, that no newton is a measure of a mistake."""
        while True:
            w = Moving.drawn(rng, int(rng.integers(8, 13)))
            scale = 10 ** (rng.uniform(3, 4) if plant is nothing else rng.uniform(-6, -5))
            w = replace(w, bars=w.bars * [1, scale, scale], loads=w.loads * scale)
            wrong = plant(w)
            handed_out = w.motion, w.places, w.velocities, w.accelerations, w.loads, w.bars
            watts = power(w.motion, *handed_out[2:], w.solved(wrong)[0])
            if watts[np.abs(watts).argmax()] * sign < 0:  # a balance can fail to both sides
                wrong = -wrong
            of_power, off = left_over(*(args := (*handed_out, *w.solved(wrong))))
            if (clear := [x for x in (of_power, *off.flat) if x > 1e-10]) and min(clear) < 20 * LEAST:
                continue  # near the bound that the task names
            return Case(args, label=f"{w.label}, {words}")

    def nothing(w: Moving) -> float:
        return 0.0

    def held_at_its_end(w: Moving) -> np.ndarray:
        wrong = np.zeros((w.motion.shape[1], 15))
        rG, m, _ = w.bars[BAR]
        wrong[:, 14] = m * (w.lengths[5] - rG) * (w.accelerations[:, BAR, 1] + G)
        return wrong

    def in_a_row(body: int, axis: int) -> Callable:
        """At one point alone."""

        def plant(w: Moving) -> np.ndarray:
            wrong = np.zeros((w.motion.shape[1], 15))
            largest = np.abs(w.solved()[axis != 2]).max()
            wrong[rng.integers(len(wrong)), 3 * body + axis] = largest * rng.uniform(0.2, 0.6) * rng.choice([-1, 1])
            return wrong

        return plant

    def one_to_each_side(*rows: tuple[int, int]) -> list[Case]:
        return [
            case(f"a mistake in an equation of the {BODIES[body]}", in_a_row(body, axis), sign)
            for (body, axis), sign in zip(rows, (-1, 1), strict=True)
        ]

    return [
        case("a mistake in an equation of the bar", held_at_its_end),
        *one_to_each_side(*(UNSEEN[i] for i in rng.choice(len(UNSEEN), 2, replace=False))),
        *one_to_each_side(ALONG_THE_BAR, SEEN[rng.integers(len(SEEN))]),
        *(case("no mistake", nothing) for _ in range(2)),
    ]


def same_verdict(expected: Outcome, got: Outcome) -> str | None:
    match expected, got:
        case _, Lost(why=why):
            return why
        case _, Raised(type=name):
            return f"it raised {name}"
        case Value(value=(seen, body)), Value(value=answer):
            if not isinstance(answer, (tuple, list)) or len(answer) != 2:
                return "it is not a pair (seen, body)"
            said_seen, named = answer
            if not isinstance(seen, bool):  # of a known mistake
                return None if repr((said_seen, named)) == repr((seen, body)) else "it is something else"
            if body == ANY and named is not None:
                body = named
            if not (isinstance(said_seen, (bool, np.bool_)) or (isinstance(said_seen, int) and said_seen in (0, 1))):
                return "its first part is neither True nor False"
            if named is not None and (isinstance(named, bool) or isinstance(numbers(named), str) or np.ndim(named)):
                return "its second part is neither None nor the number of a body"
            if body is None and named is not None:
                return "it names a body where nothing is wrong"
            if body is not None and named is None:
                return "it names no body where one is out of balance"
            if named != body:
                return "it names the wrong body"
            if bool(said_seen) != seen:
                return "the power balance sees it" if seen else "the power balance does not see it"
    return None


def wherever(holds: Callable) -> Callable:
    """Looks at the cases where this holds of the right answer."""
    return lambda trial, right: same_verdict(right.outcome, trial.outcome) if holds(*right.outcome.value) else None


PLANTED_MISTAKE = Task(
    name="planted_mistake",
    title="find a planted mistake, and say which witness sees it",
    function="planted_mistake",
    reference=planted_mistake,
    cases=planting_cases,
    agree=same_verdict,
    tolerance=Tolerance(0.0, "a body is in balance or not"),
    section="wiper-inverse-dynamics: Two witnesses",
    aspects=(
        Aspect(
            "it names the body where the power balance sees nothing",
            0.5,
            wherever(lambda seen, k: k is not None and not seen),
        ),
        Aspect("it names the body where the power balance sees the mistake too", 0.25, wherever(lambda seen, k: seen)),
        Aspect("it names no body where nothing is wrong", 0.25, wherever(lambda seen, k: k is None)),
    ),
    variants=(
        Variant(
            "The bodies are looked at only where the power balance does not hold",
            "A force that does no work is in no power balance. Which witness sees it?",
            unless_power_holds,
            share=0.25,
        ),
        Variant(
            "Only the sums of the forces are looked at",
            "A wrong arm changes no sum of forces.",
            planted_by(bodies=lambda off: off[:, 0]),
        ),
        Variant(
            "The bodies are counted from one",
            "Python counts from zero, and so does the task.",
            planted_by(says=lambda seen, body: (seen, None if body is None else body + 1)),
            share=0.25,
        ),
        Variant(
            "The body with the largest force is named",
            "Large forces can be right. Which residual is not zero?",
            by_the_largest_force,
        ),
        Variant(
            "The power balance is said to see every mistake",
            "Does the residual of the power change with the mistake?",
            planted_by(sees=lambda of_power: True, says=lambda seen, body: (body is not None, body)),
            share=0.25,
        ),
        Variant(
            "It is said whether the power balance holds, and not whether it sees the mistake",
            "The first part is True where the power balance shows that something is wrong.",
            planted_by(says=lambda seen, body: (not seen, body)),
            share=0.25,
        ),
        Variant(
            "The body comes first",
            "In which order does the task ask for the two?",
            planted_by(says=lambda seen, body: (body, seen)),
            share=0.25,
        ),
        *readings(
            "Round-off is taken for a mistake",
            "Numbers computed in two ways are hardly ever equal. From which size on are they different?",
            *(
                partial(any_residual_counts, choose, always_seen)
                for choose in (int, lambda body: CRANK, lambda body: BAR)
                for always_seen in (True, False)
            ),
        ),
    ),
)

EXERCISE = Exercise(
    name="09_wiper_inverse_dynamics",
    title="The windscreen wiper: torque and forces",
    tasks=(
        STEINER,
        CENTRE_ACCELERATIONS,
        FIFTEEN_EQUATIONS,
        TORQUE,
        POWER_RESIDUAL,
        BODY_RESIDUALS,
        PLANTED_MISTAKE,
    ),
    imports=("batched", "closure", "cramer", "motion", "newton", "require", "sweep"),  # how the wiper moves
)
