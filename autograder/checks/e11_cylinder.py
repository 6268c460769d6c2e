"""Exercise 11: a mechanism that a hydraulic cylinder moves, and the force of the cylinder by two methods."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from autograder.checks.answers import array, refuses
from autograder.checks.e07_closed_form import BESIDE, by_columns, differences
from autograder.checks.plane import unit
from autograder.compare import Tolerance, difference, disagreement, numbers, wrong_shape
from autograder.outcome import Lost, Outcome, Raised, Value
from autograder.spec import Aspect, Case, Exercise, Task, Trial, Variant, readings

G = 9.80665
EXACT = Tolerance(1e-9, "two ways to write it differ by round-off", absolute=1e-12)
STEP = 5e-4  # s, or m of the stroke
SLOPE = Tolerance(1e-6, "differences over two steps to each side are right to 1e-8 of the scale here")
AROUND = STEP * np.array([0, *BESIDE])[:, None]
ANGLES = ("theta2", "theta4")
OPEN, FLAT = np.deg2rad([35, 125])  # the angle D that the rocker and the cylinder are drawn with

# --- a cylinder that moves --------------------------------------------------------------------------------------------


def words(lengths) -> str:
    return ", ".join(f"{name} = {x:.4g}" for name, x in zip(("o2", "o4", "b", "l"), lengths, strict=True)) + " m"


def closing(D, o2, o4, b) -> np.ndarray:
    """The length O2-A with which rocker and cylinder have this angle between them."""
    return b * np.cos(D) + np.sqrt(o2**2 + o4**2 - (b * np.sin(D)) ** 2)


def thin_bars(lengths, bodies) -> np.ndarray:
    """Moments of inertia about the centres of mass: the barrel is 2 g2 long, the rod l, the rocker 2 g4."""
    (g2, _, g4), m = bodies.T
    return m * np.array([2 * g2, lengths[3], 2 * g4]) ** 2 / 12


@dataclass(frozen=True)
class Swung:
    """A cylinder at some instants: `lengths` are o2, o4, b and l, and a row of `bodies` is rG and the mass."""

    lengths: np.ndarray
    bodies: np.ndarray
    stroke: np.ndarray

    @classmethod
    def drawn(cls, rng: np.random.Generator, n: int, short_rod: bool = False) -> "Swung":
        """Any instants, at which nothing is still; with a short rod the triangle closes without it as well."""
        o2, o4 = rng.uniform([0.1, 0.6], [0.6, 1.2])
        d = np.hypot(o2, o4)
        b = d * rng.uniform(0.2, 0.5)
        shortest = closing(FLAT, o2, o4, b)
        l = rng.uniform(0.3, 0.8) * (shortest - d + b) if short_rod else rng.uniform(0.2, 0.5) * shortest
        v, acc = rng.uniform([[0.1], [0.2]], [[0.5], [2.0]], (2, n)) * rng.choice([-1, 1], (2, n))
        bodies = rng.uniform([[0.1, 2], [0.05, 1], [0.2, 0.5]], [[0.5, 6], [0.4, 4], [0.8, 1.5]])
        a = closing(rng.uniform(OPEN, FLAT, n), o2, o4, b) - l
        return cls(np.array([o2, o4, b, l]), bodies, np.array([a, v, acc]))

    @cached_property
    def angles(self) -> np.ndarray:
        return TRIANGLE(self.stroke[0], self.lengths)

    @cached_property
    def ratios(self) -> np.ndarray:
        return RATIOS(self.stroke[0], self.angles, self.lengths)

    @property
    def args(self) -> tuple[np.ndarray, ...]:
        return self.stroke, self.angles, self.ratios, self.lengths, self.bodies

    @property
    def label(self) -> str:
        return f"{self.stroke.shape[1]} strokes, {words(self.lengths)}"

    def case(self, what: str = "", kind: str = "normal") -> Case:
        return Case(self.args, kind=kind, label=f"{self.label}{what and ', '}{what}")


def carried(a, lengths, bodies) -> tuple[np.ndarray, np.ndarray]:
    """The centres of mass as complex numbers, and the angles of the three bodies; shape (..., 3)."""
    theta2, theta4 = np.moveaxis(TRIANGLE(a, lengths), -1, 0)
    (g2, g3, g4), o = bodies[:, 0], lengths[0] - 1j * lengths[1]
    centres = o + g2 * unit(theta2), o + (a + g3) * unit(theta2), g4 * unit(theta4)
    return np.stack(centres, axis=-1), np.stack((theta2, theta2, theta4), axis=-1)


def along(path, lengths, bodies) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """From the positions of five near points each: what is m |z'|^2 + I th'^2 of all bodies, half of its slope, and
    the slope of the potential energy; shape (points,)."""
    (z, dz), (th, dth) = (differences(five, STEP) for five in carried(path, lengths, bodies))
    m, inertia = bodies[:, 1], thin_bars(lengths, bodies)
    return (
        (m * abs(z) ** 2 + inertia * th**2).sum(axis=1),
        ((z.conj() * dz).real * m + inertia * th * dth).sum(axis=1),
        G * (m * z.imag).sum(axis=1),
    )


def then(function: Callable, change: Callable) -> Callable:
    return lambda *args: change(function(*args))


# --- cylinder_angles --------------------------------------------------------------------------------------------------


def refuse_lengths(a, lengths) -> None:
    if min(lengths) <= 0:
        raise ValueError(f"a length of {min(lengths):.6g} m")


def refuse_open(a, lengths) -> None:
    o2, o4, b, l = lengths
    d, s = np.hypot(o2, o4), np.asarray(a) + l
    if (wrong := (s < abs(d - b)) | (s > d + b)).any():
        raise ValueError(f"the triangle is open at a stroke of {np.asarray(a)[wrong][0]:.6g} m")


@dataclass(frozen=True)
class Triangle:
    """theta2 and theta4 by the law of cosines, with one of the parts exchanged.

    Attributes
    ----------
    sides : of psi and of phi: 1 is the right of the line from O2 to O4.
    cosines : (phi, psi) from their cosines.
    """

    sides: tuple[float, float] = (1, 1)
    length: Callable = lambda a, l: a + l
    beta: Callable = lambda o2, o4: np.arctan2(o4, o2)
    law: float = 1
    exchanged: bool = False
    arc: Callable = np.arccos
    turned: tuple[float, float] = (0, 0)
    refusals: tuple[Callable, ...] = ()

    def __call__(self, a, lengths) -> np.ndarray:
        for refuse in self.refusals:
            refuse(a, lengths)
        o2, o4, b, l = lengths
        d, s, beta = np.hypot(o2, o4), self.length(a, l), self.beta(o2, o4)
        phi = self.arc(self.law * (d**2 + b**2 - s**2) / (2 * d * b))
        psi = self.arc(self.law * (d**2 + s**2 - b**2) / (2 * d * s))
        if self.exchanged:
            phi, psi = psi, phi
        theta = np.pi - beta - self.sides[0] * psi, self.sides[1] * phi - beta
        return np.stack(theta, axis=-1) + self.turned


TRIANGLE = Triangle()
REFUSING = Triangle(refusals=(refuse_lengths, refuse_open))
as_triangle = partial(replace, REFUSING)


def angle_cases(rng: np.random.Generator) -> list[Case]:
    def case(n: int, kind: str = "normal", at: int | None = None, factor: float = 1.0) -> Case:
        """With one of the lengths changed, and a triangle that still closes."""
        lengths = Swung.drawn(rng, n, short_rod=True).lengths
        if at is not None:
            lengths[at] *= factor
        o2, o4, b, l = lengths
        a = closing(rng.uniform(OPEN, FLAT, n), o2, o4, b) - l
        return Case((a, lengths), kind=kind, label=f"{n} strokes, {words(lengths)}")

    def open_case(reach: Callable) -> Case:
        (a, lengths), k = case(6).args, rng.integers(6)
        a[k] = reach(np.hypot(*lengths[:2]), lengths[2]) - lengths[3]
        return Case((a, lengths), kind="open", label=f"a stroke of {a[k]:.4g} m, {words(lengths)}")

    return [
        case(50),
        case(12),
        case(1),
        open_case(lambda d, b: (d - b) * rng.uniform(0.9, 0.99)),
        open_case(lambda d, b: (d + b) * rng.uniform(1.01, 1.1)),
        case(6, "negative", rng.choice([0, 3]), 0.0),
        case(6, "negative", rng.choice([0, 1, 3]), -1.0),
    ]


def angles_of_anything(a, lengths) -> np.ndarray:
    """With a length that is not positive, they are what the quadrant of an arc tangent makes of them."""
    return np.full((len(a), 2), np.nan) if min(lengths) <= 0 else REFUSING(a, lengths)


def same_angles(expected: Outcome, got: Outcome) -> str | None:
    """Whole turns are no difference; of a known mistake, nothing but nan stands for whatever came."""
    if not (isinstance(expected, Value) and isinstance(got, Value)):
        return disagreement(expected, got, EXACT)
    right, answer = np.asarray(expected.value), numbers(got.value)
    if isinstance(answer, str):
        return answer
    if answer.shape != right.shape:
        return wrong_shape(answer, right.shape)
    if np.isnan(right).all():
        return None
    alike = (np.abs(unit(answer) - unit(right)) < 1e-8) | (np.isnan(answer) & np.isnan(right))
    return None if alike.all() else "an angle is off"


def of_pairs(trial: Trial) -> np.ndarray | str:
    return array(trial, (len(trial.case.args[0]), 2), "(points, 2)")


def triangle_closes(trial: Trial, right: Trial) -> str | None:
    """Whether O2, A and O4 are joined, drawn from the lengths and the two angles alone."""
    theta = of_pairs(trial)
    if isinstance(theta, str):
        return theta
    a, (o2, o4, b, l) = trial.case.args
    e2, e4 = unit(theta).T
    gap = np.abs(o2 - 1j * o4 + (a + l) * e2 - b * e4)
    closed = gap < 1e-9
    return None if closed.all() else f"cylinder and rocker do not meet in A at index {int(np.argmin(closed))}"


def on_the_right(trial: Trial, right: Trial) -> str | None:
    theta = of_pairs(trial)
    if isinstance(theta, str):
        return theta
    a, (o2, o4, _, l) = trial.case.args
    side = ((-o2 + 1j * o4).conjugate() * (a + l) * unit(theta[:, 0])).imag < 0
    return None if side.all() else f"A lies on the left at index {int(np.argmin(side))}"


def out_of_reach(a, lengths) -> tuple[float, ...]:
    """The strokes that leave the triangle open, and the lengths O2-A that go with them."""
    o2, o4, b, l = lengths
    d, s = np.hypot(o2, o4), a + l
    wrong = (s < d - b) | (s > d + b)
    return *a[wrong], *s[wrong]


CYLINDER_ANGLES = Task(
    name="cylinder_angles",
    title="the angles of cylinder and rocker from the stroke",
    function="cylinder_angles",
    reference=REFUSING,
    cases=angle_cases,
    agree=same_angles,
    tolerance=EXACT,
    section="cylinder-kinematics: A triangle with a side that grows",
    aspects=(
        Aspect("the triangle closes: cylinder and rocker meet in A", 1.0, triangle_closes),
        Aspect("A lies on the right, seen from O2 to O4", 0.5, on_the_right),
        Aspect(
            "it raises ValueError, with the stroke, where the triangle cannot close",
            0.25,
            refuses(out_of_reach, EXACT),
            kind="open",
        ),
        Aspect(
            "it raises ValueError, with the length, where one is not positive",
            0.25,
            refuses(lambda a, lengths: (min(lengths),), EXACT),
            kind="negative",
        ),
    ),
    variants=(
        Variant(
            "It is the other branch: A lies on the left",
            "Two triangles have these sides. On which side of O2-O4 is A?",
            as_triangle(sides=(-1, -1)),
            share=0.5,
        ),
        Variant(
            "theta2 is that of the other branch",
            "Draw both angles: do cylinder and rocker meet?",
            as_triangle(sides=(-1, 1)),
            share=0.25,
        ),
        Variant(
            "theta4 is that of the other branch",
            "Draw both angles: do cylinder and rocker meet?",
            as_triangle(sides=(1, -1)),
            share=0.25,
        ),
        Variant(
            "The stroke is taken for the length O2-A",
            "The stroke says where the piston is. What is between the piston and A?",
            as_triangle(length=lambda a, l: a),
            share=0.25,
        ),
        Variant(
            "The direction of O2-O4 is forgotten",
            "The law of cosines gives angles against O2-O4, which is neither horizontal nor vertical.",
            as_triangle(beta=lambda o2, o4: 0.0),
            share=0.25,
        ),
        Variant(
            "The direction of O2-O4 is measured from the vertical",
            "Source C has two angles of the line O2-O4: which of them is measured from the x axis?",
            as_triangle(beta=lambda o2, o4: np.arctan2(o2, o4)),
            share=0.25,
        ),
        Variant(
            "The direction of O2-O4 has the wrong sign",
            "O2 is lower than O4. Is the angle to be added, or taken away?",
            as_triangle(beta=lambda o2, o4: -np.arctan2(o4, o2)),
            share=0.25,
        ),
        Variant(
            "The angles of the triangle at O2 and O4 are exchanged",
            "Each angle of a triangle is opposite to a side: which side is opposite to the angle at O4?",
            as_triangle(exchanged=True),
            share=0.25,
        ),
        Variant(
            "The cosines have the wrong sign",
            "In the law of cosines, which of the three squares is taken away?",
            as_triangle(law=-1),
            share=0.25,
        ),
        Variant(
            "The arc sine is taken of a cosine",
            "Which function undoes a cosine?",
            as_triangle(arc=np.arcsin),
            share=0.25,
        ),
        Variant(
            "theta2 points from A to O2",
            "Which end of the cylinder stands on the ground?",
            as_triangle(turned=(np.pi, 0)),
            share=0.25,
        ),
        Variant(
            "theta4 points from A to O4",
            "Which end of the rocker is O4?",
            as_triangle(turned=(0, np.pi)),
            share=0.25,
        ),
        Variant(
            "The angles are returned in degrees",
            "Angles are in rad until they are plotted.",
            then(REFUSING, np.rad2deg),
            share=0.5,
        ),
        Variant(
            "theta4 comes first",
            "In which order does the task ask for the two?",
            then(REFUSING, lambda theta: theta[:, ::-1]),
            share=0.5,
        ),
        Variant(
            "Rows and columns are exchanged",
            "A row holds the two angles at one stroke.",
            then(REFUSING, np.transpose),
            share=0.5,
        ),
        *readings(
            "A triangle that cannot close gets angles",
            "How long must the cylinder be at least, and at most?",
            as_triangle(refusals=(refuse_lengths,)),
            as_triangle(refusals=(refuse_lengths,), arc=lambda cosine: np.arccos(np.clip(cosine, -1, 1))),
            share=0.75,
            kind="open",
        ),
        Variant(
            "A length that is not positive gets angles",
            "A bar of no length is no bar.",
            angles_of_anything,
            share=0.75,
            kind="negative",
        ),
    ),
)


# --- cylinder_ratios --------------------------------------------------------------------------------------------------

NEARLY_FLAT = Tolerance(1e-8, "two ways to write it differ by round-off, and more where the triangle is nearly flat")
DEAD = 1e-6  # the sine of the angle between cylinder and rocker


def refuse_flat(a, angles, lengths) -> None:
    if (flat := np.abs(np.sin(angles @ [1, -1])) < DEAD).any():
        raise ValueError(f"the triangle is flat at a stroke of {a[flat][0]:.6g} m")


def cosine_sine(D, b, s):
    return np.cos(D), np.sin(D), b, s


def divided(C, S, b, s):
    return C / (s * S), 1 / (b * S), -1 / (s * S**2), -C / (b * S**2)


def projected(C, S, b, s):
    return S * C / s, S / b, (C**2 - S**2) / s, C / b


def projected_alone(C, S, b, s):
    """With the derivatives of what would be right."""
    return *projected(C, S, b, s)[:2], *divided(C, S, b, s)[2:]


def as_printed(C, S, b, s):
    return S * C / s, S / b, C / s, C / b


@dataclass(frozen=True)
class Ratios:
    """h by the sums along and across the cylinder, with k by a formula; 1 is right, and 2 for Coriolis."""

    coriolis: float = 2
    cylinder: float = 1
    rocker: float = 1
    k: Callable = divided

    def __call__(self, a, angles, lengths) -> np.ndarray:
        refuse_flat(a, angles, lengths)
        b, s, D = lengths[2], a + lengths[3], angles @ [1, -1]
        k2, k4, *_ = self.k(np.cos(D), np.sin(D), b, s)
        inwards2, inwards4 = self.cylinder * s * k2**2, self.rocker * b * k4**2
        h4 = (inwards4 * np.cos(D) - inwards2) / (b * np.sin(D))
        h2 = (b * h4 * np.cos(D) + inwards4 * np.sin(D) - self.coriolis * k2) / s
        return in_pairs(k2, k4, h2, h4)


RATIOS = Ratios()
as_ratios = partial(replace, RATIOS)


def in_pairs(k2, k4, h2, h4) -> np.ndarray:
    return np.array([[k2, k4], [h2, h4]]).swapaxes(1, 2)


@dataclass(frozen=True)
class Differentiated:
    """k by formulas of the sine and the cosine, and h by their derivatives, with one of the parts exchanged.

    Attributes
    ----------
    formula : (C, S, b, s) -> k2, k4 and the parts of h2 and h4 that have the change of D as a factor.
    change : (k2, k4) -> dD/da.
    given : (a, angles, lengths) -> C, S, b, s.
    """

    formula: Callable
    change: Callable = lambda k2, k4: k2 - k4
    given: Callable = lambda a, angles, lengths: cosine_sine(angles @ [1, -1], lengths[2], a + lengths[3])

    def __call__(self, a, angles, lengths) -> np.ndarray:
        refuse_flat(a, angles, lengths)
        C, S, b, s = self.given(a, angles, lengths)
        k2, k4, of_D2, of_D4 = self.formula(C, S, b, s)
        dD = self.change(k2, k4)
        return in_pairs(k2, k4, of_D2 * dD - k2 / s, of_D4 * dD)


as_derivative = partial(Differentiated, divided)


def flat_stroke(rng: np.random.Generator, off: float) -> Case:
    """One of the strokes leaves the triangle flat, stretched or folded, or nearly so."""
    w = Swung.drawn(rng, 5)
    a, angles, (o2, o4, b, l) = w.stroke[0], w.angles.copy(), w.lengths
    k = rng.integers(5)
    D = rng.choice([0, np.pi])
    D += off if D == 0 else -off
    a[k] = closing(D, o2, o4, b) - l
    angles[k] = np.pi - np.arctan2(o4, o2) - np.array([0, D])
    return Case((a, angles, w.lengths), kind="flat", label=f"{w.label}, nearly flat at a = {a[k]:.4g} m")


def ratio_cases(rng: np.random.Generator) -> list[Case]:
    def case(n: int) -> Case:
        w = Swung.drawn(rng, n)
        return Case((w.stroke[0], w.angles, w.lengths), label=w.label)

    return [case(40), case(1), flat_stroke(rng, 1e-9), flat_stroke(rng, 1e-9), flat_stroke(rng, 3e-4)]


def ratios_of_anything(a, angles, lengths) -> np.ndarray:
    """Where the triangle is flat, they are what round-off makes of them."""
    try:
        return RATIOS(a, angles, lengths)
    except ValueError:
        return np.full((2, len(a), 2), np.nan)


def same_where_known(expected: Outcome, got: Outcome) -> str | None:
    """Of a known mistake, nan stands for whatever came."""
    if isinstance(expected, Value) and isinstance(got, Value):
        right, answer = np.asarray(expected.value), numbers(got.value)
        if not isinstance(answer, str) and answer.shape == right.shape and np.isnan(right).all():
            return None
    return disagreement(expected, got, NEARLY_FLAT)


def is_the_slope(level: int) -> Callable:
    """Whether k (level 0) or h (1) is the derivative of the angles of triangles that are a little longer or shorter."""

    def fault(trial: Trial, right: Trial) -> str | None:
        a, _, lengths = trial.case.args
        got = array(trial, (2, len(a), 2), "(2, points, 2)")
        if isinstance(got, str):
            return got
        expected = differences(TRIANGLE(a + AROUND, lengths), STEP)
        return by_columns(expected[level], got[level], ANGLES, SLOPE)

    return fault


CYLINDER_RATIOS = Task(
    name="cylinder_ratios",
    title="velocity and acceleration ratios of cylinder and rocker",
    function="cylinder_ratios",
    reference=RATIOS,
    cases=ratio_cases,
    agree=same_where_known,
    tolerance=NEARLY_FLAT,
    section="cylinder-kinematics: Velocity and acceleration ratios",
    aspects=(
        Aspect("k is what the angles change by, with the stroke", 1.25, is_the_slope(0)),
        Aspect("h is what k changes by, with the stroke", 1.25, is_the_slope(1)),
        Aspect(
            "it raises ValueError, with the stroke, where the triangle is flat, and not where it is nearly so",
            0.5,
            refuses(lambda a, angles, lengths: tuple(a[np.abs(np.sin(angles @ [1, -1])) < DEAD]), SLOPE),
            kind="flat",
        ),
    ),
    variants=(
        *readings(
            "The velocity is projected, and not divided by sin D",
            "Differentiate the angles by differences: is your k4 too large, or too small? Source C has this slip.",
            Differentiated(projected),
            Differentiated(projected_alone),
            as_ratios(k=projected),
            lambda *args: np.array([Differentiated(projected)(*args)[0], RATIOS(*args)[1]]),
        ),
        Variant(
            "The velocity is projected, and h2 has cos D where the derivative of sin 2D / 2 has cos 2D",
            "Differentiate your k by differences, and then the angles. Source C has both slips.",
            Differentiated(as_printed),
        ),
        Variant(
            "The Coriolis term is missing, or 1/s is differentiated with the wrong sign",
            "A point that slides along a line that turns: which term has both velocities? Also, s stands in k2.",
            as_ratios(coriolis=0),
        ),
        Variant(
            "The Coriolis term is half of what it should be, or the change of s is forgotten",
            "s times a unit vector is differentiated twice: how often does the mixed term come? s stands in k2.",
            as_ratios(coriolis=1),
        ),
        Variant(
            "The Coriolis term has the wrong sign",
            "On which side of the equation does it stand?",
            as_ratios(coriolis=-2),
        ),
        Variant(
            "Both centripetal terms are missing",
            "Differentiate a cosine twice: what comes beside the second derivative of the angle?",
            as_ratios(cylinder=0, rocker=0),
        ),
        Variant(
            "The centripetal term of the cylinder is missing",
            "The cylinder turns as well.",
            as_ratios(cylinder=0),
        ),
        Variant(
            "The centripetal term of the rocker is missing, or D changes with theta2 alone",
            "A turns about O4, and D is the difference of two angles that both change.",
            as_ratios(rocker=0),
        ),
        Variant(
            "The centripetal terms have the wrong sign",
            "A point that turns evenly accelerates towards the centre.",
            as_ratios(cylinder=-1, rocker=-1),
        ),
        Variant(
            "D is taken for constant in h",
            "D is the difference of two angles, and both change with the stroke.",
            as_derivative(change=lambda k2, k4: 0),
        ),
        Variant(
            "D changes with theta4 alone",
            "D is the difference of two angles, and both change with the stroke.",
            as_derivative(change=lambda k2, k4: -k4),
        ),
        Variant(
            "The change of D has the wrong sign",
            "Differentiate theta2 - theta4.",
            as_derivative(change=lambda k2, k4: k4 - k2),
        ),
        Variant(
            "The changes of the two angles are added",
            "Differentiate theta2 - theta4.",
            as_derivative(change=lambda k2, k4: k2 + k4),
        ),
        *readings(
            "D has the wrong sign",
            "The task says from which angle the other is taken.",
            Differentiated(divided, given=lambda a, angles, q: cosine_sine(angles @ [-1, 1], q[2], a + q[3])),
            Differentiated(
                divided,
                lambda k2, k4: k4 - k2,
                given=lambda a, angles, q: cosine_sine(angles @ [-1, 1], q[2], a + q[3]),
            ),
        ),
        Variant(
            "The stroke is taken for the length O2-A",
            "The stroke says where the piston is. What is between the piston and A?",
            as_derivative(given=lambda a, angles, q: cosine_sine(angles @ [1, -1], q[2], a)),
        ),
        Variant(
            "Sine and cosine of D are exchanged",
            "Does the rocker have a velocity where the cylinder is across it?",
            as_derivative(given=lambda a, angles, q: cosine_sine(np.pi / 2 - angles @ [1, -1], q[2], a + q[3])),
        ),
        Variant(
            "The lengths b and s are exchanged",
            "Which of the two lengths turns with theta4?",
            as_derivative(given=lambda a, angles, q: cosine_sine(angles @ [1, -1], a + q[3], q[2])),
        ),
        Variant(
            "The angles are taken for degrees",
            "They are in radians, and NumPy wants radians.",
            as_derivative(given=lambda a, angles, q: cosine_sine(np.deg2rad(angles) @ [1, -1], q[2], a + q[3])),
        ),
        Variant(
            "theta4 comes first",
            "In which order does the task ask for the two?",
            then(RATIOS, lambda ratios: ratios[..., ::-1]),
            share=0.5,
        ),
        Variant(
            "The ratio h comes first, and k second",
            "In which order does the task ask for them?",
            then(RATIOS, lambda ratios: ratios[::-1]),
            share=0.5,
        ),
        Variant(
            "The angles come before the points",
            "The shape is (2, points, 2).",
            then(RATIOS, lambda ratios: ratios.swapaxes(1, 2)),
            share=0.5,
        ),
        Variant(
            "A flat triangle gets ratios",
            "Where the triangle is flat, the stroke determines no velocity: what does a division by round-off give?",
            ratios_of_anything,
            share=0.8,
            kind="flat",
        ),
    ),
)


# --- virtual_power ----------------------------------------------------------------------------------------------------


def refuse_masses(bodies) -> None:
    if (masses := bodies[:, 1]).min() <= 0:
        raise ValueError(f"a mass of {masses.min():.6g} kg")


def of_the_barrel(lengths, bodies) -> np.ndarray:
    """Source C: the moment of inertia of the rocker, with the mass of the barrel."""
    return thin_bars(lengths, bodies) * [1, 1, bodies[0, 1] / bodies[2, 1]]


def ends(lengths, bodies) -> np.ndarray:
    return 4 * thin_bars(lengths, bodies)


@dataclass(frozen=True)
class Power:
    """The force by virtual power, with parts that can be forgotten or exchanged: 1 is right, and 2 for Coriolis.

    Attributes
    ----------
    inertial, weight, turning : of m a, m g and I eps.
    centripetal, coriolis : of the accelerations.
    slides, slides_on : of the sliding in the velocity of the rod, and in its acceleration.
    direction : of an angle, as a complex number.
    arm : (a, l, g3) -> of the centre of mass of the rod, from O2.
    inertia : (lengths, bodies) -> of the three.
    steiner : of m r^2 beside the moments of inertia.
    turn : (k, h, v, acc) -> the angular acceleration.
    """

    inertial: float = 1
    weight: float = 1
    turning: float = 1
    centripetal: float = 1
    coriolis: float = 2
    slides: float = 1
    slides_on: float = 1
    direction: Callable = unit
    arm: Callable = lambda a, l, g3: a + g3
    inertia: Callable = thin_bars
    steiner: float = 0
    turn: Callable = lambda k, h, v, acc: k * acc + h * v**2
    refuse: Callable = refuse_masses

    def __call__(self, stroke, angles, ratios, lengths, bodies) -> np.ndarray:
        self.refuse(bodies)
        (a, v, acc), (k, h) = stroke, ratios
        omega, eps = k.T * v, self.turn(k.T, h.T, v, acc)
        (k2, k4), (w2, w4), (eps2, eps4), (e2, e4) = k.T, omega, eps, self.direction(angles).T
        (g2, g3, g4), m = bodies.T
        r3 = self.arm(a, lengths[3], g3)
        on2, on4 = 1j * eps2 - self.centripetal * w2**2, 1j * eps4 - self.centripetal * w4**2
        sliding = self.slides_on * acc + self.coriolis * 1j * w2 * v
        velocities = 1j * k2 * g2 * e2, (self.slides + 1j * k2 * r3) * e2, 1j * k4 * g4 * e4
        accelerations = on2 * g2 * e2, (sliding + on2 * r3) * e2, on4 * g4 * e4
        I2, I3, I4 = self.inertia(lengths, bodies)
        beside2, beside3, beside4 = (self.steiner * m * np.array([g2 + 0 * a, r3, g4 + 0 * a]).T ** 2).T
        about2, about4 = I2 + beside2 + I3 + beside3, I4 + beside4
        force = self.turning * (about2 * eps2 * k2 + about4 * eps4 * k4)
        for mass, u, accelerated in zip(m, velocities, accelerations, strict=True):
            force = force + mass * (u.conj() * (self.inertial * accelerated + 1j * self.weight * G)).real
        return force


POWER = Power()
as_power = partial(replace, POWER)


def at_turning_points(rest: Callable) -> Callable:
    """The force from the power of the motion: where nothing moves, zero is divided by zero."""

    def divided_by_v(stroke, *rest_of_args) -> np.ndarray:
        return np.where(stroke[1] == 0, rest(), POWER(stroke, *rest_of_args))

    return divided_by_v


def divides_zero() -> float:
    raise ZeroDivisionError("division by zero")


def power_cases(rng: np.random.Generator) -> list[Case]:
    turns, rests = Swung.drawn(rng, 8), Swung.drawn(rng, 8)
    turns.stroke[1, rng.choice(8, 3, replace=False)] = 0
    rests.stroke[1:] = 0
    heavy = Swung.drawn(rng, 4)
    light = [replace(heavy, bodies=heavy.bodies.copy()) for _ in range(2)]
    for w, factor in zip(light, (0, -1), strict=True):
        w.bodies[rng.integers(3), 1] *= factor
    return [
        Swung.drawn(rng, 30).case(),
        Swung.drawn(rng, 1).case(),
        turns.case("with turning points", "turn"),
        rests.case("at rest", "rest"),
        *(w.case("a mass that is not positive", "massless") for w in light),
    ]


def forces(trial: Trial) -> np.ndarray | str:
    return array(trial, (trial.case.args[0].shape[1],), "(points,)")


def gives_the_energy(trial: Trial, right: Trial) -> str | None:
    """Whether its power is the rate of the energy, from the positions a little earlier and later."""
    force = forces(trial)
    if isinstance(force, str):
        return force
    (a, v, acc), _, _, lengths, bodies = trial.case.args
    path = a + v * AROUND + acc * AROUND**2 / 2
    _, kinetic, potential = along(path, lengths, bodies)
    return difference((kinetic + potential) / v, force, SLOPE)


def is_that_of_lagrange(trial: Trial, right: Trial) -> str | None:
    """From the energies at strokes that are a little shorter and longer: a velocity that is zero is no matter."""
    force = forces(trial)
    return force if isinstance(force, str) else difference([1, -1, 1] @ by_energies(*trial.case.args), force, SLOPE)


def by_energies(stroke, angles, ratios, lengths, bodies) -> np.ndarray:
    """d/dt(dT/dv), dT/da and dV/da from the positions; of T = M v^2 / 2."""
    a, v, acc = stroke
    M, half, slope = along(a + AROUND, lengths, bodies)
    return np.array([M * acc + 2 * half * v**2, half * v**2, slope])


VIRTUAL_POWER = Task(
    name="virtual_power",
    title="the force of the cylinder by virtual power",
    function="virtual_power",
    reference=POWER,
    cases=power_cases,
    tolerance=EXACT,
    section="cylinder-force: Virtual power",
    aspects=(
        Aspect("where the cylinder moves, its power is the rate of the energy", 1.5, gives_the_energy),
        Aspect("where it turns round, its force is that of Lagrange's equation", 0.75, is_that_of_lagrange, "turn"),
        Aspect("at rest it holds the weights", 0.5, is_that_of_lagrange, "rest"),
        Aspect(
            "it raises ValueError, with the mass, where one is not positive",
            0.25,
            refuses(lambda *args: (args[-1][:, 1].min(),), EXACT),
            kind="massless",
        ),
    ),
    variants=(
        *readings(
            "The power of the motion is divided by its velocity",
            "At a turning point that is zero by zero. Whose velocity need not be that of the motion?",
            at_turning_points(lambda: np.nan),
            at_turning_points(lambda: 0.0),
            at_turning_points(divides_zero),
            share=0.5,
            kind="turn",
        ),
        Variant(
            "The power is returned, and not the force",
            "A power is N m/s.",
            lambda stroke, *rest: stroke[1] * POWER(stroke, *rest),
            share=0.25,
        ),
        Variant("The weight is forgotten", "Which force acts on every body?", as_power(weight=0), share=0.25),
        Variant("The weight is counted twice", "m (a + g) holds it once.", as_power(weight=2), share=0.25),
        Variant(
            "The weight has the wrong sign",
            "Must the cylinder push, or pull, to hold up the rocker?",
            as_power(weight=-1),
            share=0.25,
        ),
        Variant(
            "The term m a has the wrong sign",
            "Which way must one push to accelerate?",
            as_power(inertial=-1),
            share=0.25,
        ),
        Variant(
            "The bodies have no moments of inertia",
            "A body that turns faster and faster takes more than its centre of mass.",
            as_power(turning=0),
            share=0.25,
        ),
        Variant(
            "The term I eps has the wrong sign",
            "Which way must one turn to accelerate?",
            as_power(turning=-1),
            share=0.25,
        ),
        Variant(
            "The rocker's moment of inertia has the mass of the barrel",
            "Units cannot tell it, the name of the mass can. Source C has this slip.",
            as_power(inertia=of_the_barrel),
            share=0.5,
        ),
        Variant(
            "The moments of inertia are about the ends of the bars",
            "With the acceleration of the centre of mass goes the moment about the centre of mass.",
            as_power(inertia=ends),
            share=0.5,
        ),
        Variant(
            "The moments of inertia are about O2 and O4",
            "m a of the centre of mass already holds what Steiner adds.",
            as_power(steiner=1),
            share=0.5,
        ),
        Variant(
            "Barrel and rocker are half as long in their moments of inertia",
            "From the joint to the centre of mass is half of an even bar.",
            as_power(inertia=lambda lengths, bodies: thin_bars(lengths, bodies) * [1 / 4, 1, 1 / 4]),
            share=0.5,
        ),
        Variant(
            "The rod is 2 g3 long in its moment of inertia",
            "g3 need not be half of the rod: how long is it?",
            as_power(inertia=lambda lengths, bodies: thin_bars(np.full(4, 2 * bodies[1, 0]), bodies)),
            share=0.5,
        ),
        Variant(
            "The Coriolis acceleration is missing",
            "The rod slides along a line that turns.",
            as_power(coriolis=0),
            share=0.5,
        ),
        Variant(
            "The Coriolis acceleration is half of what it should be",
            "The direction of the sliding turns, and the arm grows: two equal parts.",
            as_power(coriolis=1),
            share=0.5,
        ),
        Variant(
            "The Coriolis acceleration has the wrong sign",
            "Differentiate (a + g3) times a unit vector twice.",
            as_power(coriolis=-2),
            share=0.5,
        ),
        Variant(
            "The centripetal accelerations are missing",
            "A point that turns evenly accelerates: towards what?",
            as_power(centripetal=0),
            share=0.5,
        ),
        Variant(
            "The centripetal accelerations point outwards",
            "A point that turns evenly accelerates: towards what?",
            as_power(centripetal=-1),
            share=0.5,
        ),
        Variant(
            "The rod does not slide: its centre of mass only turns about O2",
            "The rod goes with the piston. What does its centre of mass do where the cylinder does not turn?",
            as_power(slides=0, slides_on=0, coriolis=0),
            share=0.25,
        ),
        Variant(
            "The sliding is missing from the velocity of the rod",
            "Where the cylinder does not turn, does the rod stand still? Source C has this slip.",
            as_power(slides=0),
            share=0.25,
        ),
        Variant(
            "The acceleration of the stroke is missing from that of the rod",
            "The rod goes with the piston.",
            as_power(slides_on=0),
            share=0.25,
        ),
        Variant(
            "The length O2-A stands where the stroke belongs",
            "g3 is measured from the piston. How far from O2 is the piston?",
            as_power(arm=lambda a, l, g3: a + l + g3),
            share=0.25,
        ),
        Variant(
            "The centre of mass of the rod stays at g3 from O2",
            "g3 is measured from the piston. How far from O2 is the piston?",
            as_power(arm=lambda a, l, g3: g3 + 0 * a),
            share=0.25,
        ),
        Variant(
            "The ratio h is forgotten in the angular accelerations",
            "Differentiate k v by time: both factors change.",
            as_power(turn=lambda k, h, v, acc: k * acc),
            share=0.5,
        ),
        Variant(
            "The velocity is not squared beside h",
            "Which unit has h v?",
            as_power(turn=lambda k, h, v, acc: k * acc + h * v),
            share=0.5,
        ),
        Variant(
            "The ratio k stands where h belongs",
            "Differentiate k v by time: what is k v^2?",
            as_power(turn=lambda k, h, v, acc: k * acc + k * v**2),
            share=0.5,
        ),
        Variant(
            "Sine and cosine are exchanged",
            "The angles are measured from the horizontal: which component does the cosine give?",
            as_power(direction=lambda angle: 1j * unit(-angle)),
            share=0.25,
        ),
        Variant(
            "The angles are taken for degrees",
            "They are in radians, and NumPy wants radians.",
            as_power(direction=lambda angle: unit(np.deg2rad(angle))),
            share=0.25,
        ),
        Variant(
            "Cylinder and rocker exchange their ratios",
            "In which order does `ratios` hold the two?",
            lambda stroke, angles, ratios, *rest: POWER(stroke, angles, ratios[..., ::-1], *rest),
        ),
        Variant(
            "The force has the wrong sign",
            "It is positive where the cylinder pushes.",
            then(POWER, np.negative),
            share=0.5,
        ),
        Variant(
            "A mass that is not positive gets a force",
            "What weighs nothing is no body.",
            as_power(refuse=lambda bodies: None),
            share=0.75,
            kind="massless",
        ),
    ),
)

# --- lagrange_terms ---------------------------------------------------------------------------------------------------

TERMS = ("d/dt dT/dv", "dT/da", "dV/da")


def refuse_lost(stroke, angles) -> None:
    if (lost := np.isnan(angles).any(axis=1)).any():
        raise ValueError(f"there are no angles at a stroke of {stroke[0, np.argmax(lost)]:.6g} m")


def about_joints(lengths, bodies) -> np.ndarray:
    """Of the barrel about O2 and of the rocker about O4, but of the rod about its centre of mass."""
    return thin_bars(lengths, bodies) * [4, 1, 4]


@dataclass(frozen=True)
class Lagrange:
    """The three terms, of each body, with parts that can be forgotten or exchanged: 1 is right.

    Attributes
    ----------
    weight : of the potential energy.
    sliding : of the mass that slides.
    shifts : of the growth of the arm of the rod, in the slope of its moment of inertia.
    lift : of the lift of the rod by its sliding.
    levers : (k2, k4, D, s) -> what the weights of barrel, rod and rocker turn with.
    height : (angle) -> what the weight of an arm works with.
    """

    weight: float = 1
    sliding: float = 1
    shifts: float = 1
    lift: float = 1
    power: int = 2
    arm: Callable = lambda a, l, g3: a + g3
    moments: Callable = about_joints
    steiner: float = 1
    lever: Callable = lambda k2, D, s: k2
    at: Callable = lambda angles: angles
    cos: Callable = np.cos
    refuse: Callable = refuse_lost

    def of_bodies(self, stroke, angles, ratios, lengths, bodies) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """M, half of its slope, and the slope of V; shape (bodies, points)."""
        a, angles = stroke[0], self.at(angles)
        ((k2, k4), (h2, h4)), (th2, th4) = ratios.swapaxes(1, 2), angles.T
        (g2, g3, g4), (m2, m3, m4) = bodies.T
        r3 = self.arm(a, lengths[3], g3)
        I2, I3, I4 = self.moments(lengths, bodies)
        about2 = I3 + self.steiner * m3 * r3**2
        squared2, squared4 = k2**self.power, k4**self.power
        M = I2 * squared2, self.sliding * m3 + about2 * squared2, I4 * squared4
        half = I2 * k2 * h2, about2 * k2 * h2 + self.shifts * m3 * r3 * k2**2, I4 * k4 * h4
        lever = self.lever(k2, th2 - th4, a + lengths[3])
        lifted = self.lift * self.cos(np.pi / 2 - th2) + r3 * self.cos(th2) * lever
        V = m2 * g2 * self.cos(th2) * k2, m3 * lifted, m4 * g4 * self.cos(th4) * k4
        return np.array(M), np.array(half), self.weight * G * np.array(V)

    def __call__(self, stroke, angles, ratios, lengths, bodies) -> np.ndarray:
        self.refuse(stroke, angles)
        _, v, acc = stroke
        M, half, slope = (part.sum(axis=0) for part in self.of_bodies(stroke, angles, ratios, lengths, bodies))
        return np.array([M * acc + 2 * half * v**2, half * v**2, slope])


LAGRANGE = Lagrange()
as_lagrange = partial(replace, LAGRANGE)


def combined(*rows: tuple[float, float, float]) -> Callable:
    """Each of the three terms as a sum of the three right ones."""
    return then(LAGRANGE, lambda terms: np.array(rows) @ terms)


def slipped_moment(factor: Callable) -> Lagrange:
    """With the moment of inertia of the rocker that `factor` makes of (lengths, bodies)."""

    def moments(lengths, bodies) -> np.ndarray:
        I2, I3, _ = about_joints(lengths, bodies)
        return np.array([I2, I3, factor(lengths, bodies)])

    return as_lagrange(moments=moments)


def lagrange_cases(rng: np.random.Generator) -> list[Case]:
    turns, lost = Swung.drawn(rng, 8), Swung.drawn(rng, 9)
    turns.stroke[1, rng.choice(8, 3, replace=False)] = 0
    lost.ratios  # noqa: B018  # before the angles are lost
    first = rng.integers(3, 7)
    lost.angles[first : first + 2] = np.nan
    lost.ratios[:, first : first + 2] = np.nan
    return [
        Swung.drawn(rng, 30).case(),
        Swung.drawn(rng, 1).case(),
        turns.case("with turning points"),
        lost.case("open at some strokes", "open"),
    ]


def three(trial: Trial) -> np.ndarray | str:
    return array(trial, (3, trial.case.args[0].shape[1]), "(3, points)")


def is_the_term(k: int) -> Callable:
    """Whether a term is that of the energies at strokes that are a little shorter and longer."""

    def fault(trial: Trial, right: Trial) -> str | None:
        terms = three(trial)
        return terms if isinstance(terms, str) else difference(by_energies(*trial.case.args)[k], terms[k], SLOPE)

    return fault


def is_virtual_power(trial: Trial, right: Trial) -> str | None:
    terms = three(trial)
    return terms if isinstance(terms, str) else difference(POWER(*trial.case.args), [1, -1, 1] @ terms, EXACT)


def same_terms(expected: Outcome, got: Outcome) -> str | None:
    """Each term on its own scale."""
    if isinstance(expected, Value) and isinstance(got, Value):
        right, answer = np.asarray(expected.value), numbers(got.value)
        if not isinstance(answer, str) and answer.shape == right.shape and right.ndim == 2:
            return by_columns(right.T, answer.T, TERMS, EXACT) if len(right) == 3 else difference(right, answer, EXACT)
    return disagreement(expected, got, EXACT)


LAGRANGE_TERMS = Task(
    name="lagrange_terms",
    title="the force of the cylinder by Lagrange's equation, term by term",
    function="lagrange_terms",
    reference=LAGRANGE,
    cases=lagrange_cases,
    agree=same_terms,
    tolerance=EXACT,
    section="cylinder-force: Lagrange's equation",
    aspects=(
        Aspect("dV/da is what the potential energy changes by, with the stroke", 0.75, is_the_term(2)),
        Aspect("dT/da is what the kinetic energy changes by, with the stroke, at the same v", 0.75, is_the_term(1)),
        Aspect("d/dt(dT/dv)", 0.75, is_the_term(0)),
        Aspect("together they are the force by virtual power, to round-off", 0.5, is_virtual_power),
        Aspect(
            "it raises ValueError, with the stroke, where there are no angles",
            0.25,
            refuses(lambda stroke, angles, *rest: tuple(stroke[0, np.isnan(angles).any(axis=1)]), EXACT),
            kind="open",
        ),
    ),
    variants=(
        Variant(
            "In d/dt(dT/dv) half of the term with v^2 is missing",
            "dT/dv is M v. Differentiate it by time: with M' v^2, or with half of it?",
            combined((1, -1, 0), (0, 1, 0), (0, 0, 1)),
            share=0.5,
        ),
        Variant(
            "In d/dt(dT/dv) the change of the inertia is forgotten",
            "dT/dv is M v, and M changes with the stroke.",
            combined((1, -2, 0), (0, 1, 0), (0, 0, 1)),
            share=0.5,
        ),
        Variant(
            "The term dT/da is left out",
            "T depends on the stroke by more than the velocity.",
            combined((1, 0, 0), (0, 0, 0), (0, 0, 1)),
            share=0.5,
        ),
        Variant(
            "The term dT/da is twice too large",
            "T is half of M v^2.",
            combined((1, 0, 0), (0, 2, 0), (0, 0, 1)),
            share=0.5,
        ),
        Variant(
            "The term dT/da has the wrong sign",
            "The task asks for dT/da; the minus is in Lagrange's equation.",
            combined((1, 0, 0), (0, -1, 0), (0, 0, 1)),
            share=0.5,
        ),
        Variant(
            "T has lost its half",
            "T is half of M v^2.",
            combined((2, 0, 0), (0, 2, 0), (0, 0, 1)),
            share=0.25,
        ),
        Variant(
            "The first two terms are exchanged",
            "In which order does the task ask for them?",
            combined((0, 1, 0), (1, 0, 0), (0, 0, 1)),
            share=0.5,
        ),
        Variant(
            "The potential energy comes first",
            "In which order does the task ask for them?",
            combined((0, 0, 1), (1, 0, 0), (0, 1, 0)),
            share=0.5,
        ),
        Variant(
            "The force is returned, and not its three terms",
            "The next task looks at each term.",
            then(LAGRANGE, lambda terms: np.array([1, -1, 1]) @ terms),
            share=0.5,
        ),
        Variant(
            "Rows and columns are exchanged",
            "The shape is (3, points).",
            then(LAGRANGE, np.transpose),
            share=0.5,
        ),
        Variant("The weight is forgotten", "V is the energy of what?", as_lagrange(weight=0), share=0.5),
        Variant("The weight is counted twice", "V is m g y, once for each body.", as_lagrange(weight=2), share=0.5),
        Variant(
            "The weight has the wrong sign",
            "V grows with the height.",
            as_lagrange(weight=-1),
            share=0.5,
        ),
        *readings(
            "The gravity term of the rod has sin^2 D and cos^2 D where the ratio of the cylinder belongs",
            "Differentiate the height of G3 by differences, at some stroke. Source C has this slip.",
            as_lagrange(lever=lambda k2, D, s: (np.cos(D) ** 2 - np.sin(D) ** 2) / s),
            as_lagrange(lever=lambda k2, D, s: (np.sin(D) ** 2 - np.cos(D) ** 2) / s),
            as_lagrange(lever=lambda k2, D, s: 1 / s),
            as_lagrange(lever=lambda k2, D, s: np.sin(D) ** 2 * np.cos(D) ** 2 / s),
            share=0.5,
        ),
        Variant(
            "The rod is not lifted by its sliding",
            "Where the cylinder does not turn, the stroke still lifts the rod.",
            as_lagrange(lift=0),
            share=0.5,
        ),
        Variant(
            "The sliding is missing from the kinetic energy of the rod",
            "Where the cylinder does not turn, does the rod stand still?",
            as_lagrange(sliding=0),
            share=0.5,
        ),
        Variant(
            "The arm of the rod is taken for constant in the slope of the inertia",
            "a + g3 is in M: differentiate it as well.",
            as_lagrange(shifts=0),
            share=0.5,
        ),
        Variant(
            "The rod does not slide: its centre of mass stays where it is on the cylinder",
            "The rod goes with the piston: it has a velocity along the cylinder, its arm grows, and it is lifted.",
            as_lagrange(sliding=0, shifts=0, lift=0),
        ),
        Variant(
            "The length O2-A stands where the stroke belongs",
            "g3 is measured from the piston. How far from O2 is the piston?",
            as_lagrange(arm=lambda a, l, g3: a + l + g3),
        ),
        Variant(
            "The centre of mass of the rod stays at g3 from O2",
            "g3 is measured from the piston. How far from O2 is the piston?",
            as_lagrange(arm=lambda a, l, g3: g3 + 0 * a),
        ),
        Variant(
            "Barrel and rocker have their moments of inertia about the centres of mass",
            "They turn about O2 and O4.",
            as_lagrange(moments=thin_bars),
            share=0.5,
        ),
        Variant(
            "Steiner's term is counted twice",
            "m L^2 / 3 is about the end of a bar, m L^2 / 12 about its middle.",
            as_lagrange(moments=lambda lengths, bodies: thin_bars(lengths, bodies) * [7, 1, 7]),
            share=0.5,
        ),
        Variant(
            "The rod has its moment of inertia about its end",
            "Steiner's rule begins at the centre of mass.",
            as_lagrange(moments=lambda lengths, bodies: ends(lengths, bodies)),
            share=0.5,
        ),
        Variant(
            "The rod has no arm in its kinetic energy",
            "The centre of mass of the rod turns about O2: how far away?",
            as_lagrange(steiner=0, shifts=0),
            share=0.5,
        ),
        *readings(
            "The rocker's moment of inertia has the mass of the barrel",
            "Units cannot tell it, the name of the mass can. Source C has this slip.",
            slipped_moment(lambda q, bodies: (bodies[2, 0] ** 2) * (bodies[0, 1] / 3 + bodies[2, 1])),
            slipped_moment(lambda q, bodies: (bodies[2, 0] ** 2) * (bodies[0, 1] / 3 + bodies[0, 1])),
            share=0.5,
        ),
        Variant(
            "The ratios are not squared in the inertia",
            "T has the square of the angular velocity, k v.",
            as_lagrange(power=1),
            share=0.5,
        ),
        Variant(
            "Sine and cosine are exchanged in the potential energy",
            "Which of the two gives the height, and what is its derivative?",
            as_lagrange(cos=np.sin),
            share=0.5,
        ),
        Variant(
            "The angles are taken for degrees",
            "They are in radians, and NumPy wants radians.",
            as_lagrange(at=np.deg2rad),
            share=0.5,
        ),
        Variant(
            "nan goes through",
            "Where the triangle is open there are no angles: whoever reads the force must not have to look for it.",
            as_lagrange(refuse=lambda stroke, angles: None),
            share=0.75,
            kind="open",
        ),
    ),
)

# --- wrong_term -------------------------------------------------------------------------------------------------------

BODIES = ("barrel", "rod", "rocker")
MOMENTUM, KINETIC, WEIGHTS = range(3)
ROD = 1
TENTH = 0.1  # of the largest value of a term, as the task says
ANY = ("any", "any")  # whichever term: differences are off in every right way to form them
INSTANTS = 400
Named = tuple[str, str] | None


def left_over(t, stroke, kinetic, potential, terms) -> np.ndarray:
    """By how much each term of each body does not fit the energies, in parts of its largest value; shape (3, 3)."""
    _, v, acc = stroke
    rate, falling = (np.gradient(energy, t, axis=1) for energy in (kinetic, potential))
    # of T = M v^2 / 2: nothing is divided by a velocity that passes zero
    fits = np.array([2 * rate * v - 2 * kinetic * acc, rate * v - 2 * kinetic * acc, falling * v])
    works = terms * v**2
    return np.abs(works - fits).max(axis=2) / np.abs(works).max(axis=2)


def wrong_term(*args) -> Named:
    off = left_over(*args)
    term, body = np.unravel_index(off.argmax(), off.shape)
    return (TERMS[term], BODIES[body]) if off.max() > TENTH else None


def naming(change: Callable) -> Callable:
    """Another answer wherever a term is wrong."""
    return lambda *args: found and change(*found) if (found := wrong_term(*args)) else None


def of_a_kinetic(change: Callable) -> Callable:
    """Another answer where one of the kinetic terms is wrong."""
    return naming(lambda term, body: (term, body) if term == TERMS[WEIGHTS] else change(term, body))


def largest_term(t, stroke, kinetic, potential, terms) -> Named:
    largest = np.abs(terms).max(axis=2)
    term, body = np.unravel_index(largest.argmax(), largest.shape)
    return TERMS[term], BODIES[body]


@dataclass(frozen=True)
class Watched:
    """A cylinder along a period of its motion, with its energies and the terms of its force, body by body."""

    t: np.ndarray
    at: Swung

    @classmethod
    def drawn(cls, rng: np.random.Generator, heavy: float) -> "Watched":
        w, period = Swung.drawn(rng, INSTANTS), rng.uniform(0.8, 1.5)
        t = period * np.arange(INSTANTS) / INSTANTS
        o2, o4, b, l = w.lengths
        low, high = closing(np.array([FLAT, OPEN]), o2, o4, b) - l
        rates = 2 * np.pi / period * np.array([[1], [2]])
        phases = rates * t + rng.uniform(0, 2 * np.pi, (2, 1))
        swing = rng.uniform([[0.3], [0.1]], [[0.6], [0.3]]) * (high - low) / 2
        derivatives = (swing * np.sin(phases), swing * rates * np.cos(phases), -swing * rates**2 * np.sin(phases))
        stroke = np.array([each.sum(axis=0) for each in derivatives])
        stroke[0] += (low + high) / 2
        return cls(t, Swung(w.lengths, w.bodies * [1, heavy], stroke))

    def parts(self, slip: Lagrange = LAGRANGE) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return slip.of_bodies(*self.at.args)

    @cached_property
    def energies(self) -> tuple[np.ndarray, np.ndarray]:
        (a, v, _), M = self.at.stroke, self.parts()[0]
        heights = carried(a, self.at.lengths, self.at.bodies)[0].imag.T
        return M * v**2 / 2, G * self.at.bodies[:, 1:] * heights

    def case(self, terms: np.ndarray, what: str) -> Case:
        label = f"{self.at.label}, a motion of {self.t[-1] + self.t[1]:.3g} s, {what}"
        return Case((self.t, self.at.stroke, *self.energies, terms), label=label)


def in_momentum(w: Watched, rng: np.random.Generator) -> np.ndarray:
    (M, half, _), (_, v, acc) = w.parts(), w.at.stroke
    of_acc, of_v2 = ((1, 1), (1, 0), (1, -2), (rng.uniform(1.5, 3), 2))[rng.integers(4)]
    return of_acc * M * acc + of_v2 * half * v**2


def in_kinetic(w: Watched, rng: np.random.Generator) -> np.ndarray:
    return (2, -1, rng.uniform(1.5, 3))[rng.integers(3)] * w.parts()[1] * w.at.stroke[1] ** 2


def in_weights(w: Watched, rng: np.random.Generator) -> np.ndarray:
    slips = as_lagrange(weight=-1), as_lagrange(cos=np.sin), as_lagrange(weight=rng.uniform(1.5, 3))
    return w.parts(slips[rng.integers(3)])[2]


def as_in_the_source(w: Watched, rng: np.random.Generator) -> np.ndarray:
    return w.parts(as_lagrange(lever=lambda k2, D, s: (np.cos(D) ** 2 - np.sin(D) ** 2) / s))[2]


def planted_cases(rng: np.random.Generator) -> list[Case]:
    def case(term: int = 0, body: int = 0, wrong: Callable | None = None) -> Case:
        """With differences that are good enough, and a mistake that is clearly one, also where it is not weighted by v.

        The masses are so small, or without a mistake so large, that no newton is a measure of a mistake.
        """
        while True:
            w = Watched.drawn(rng, 10 ** (rng.uniform(-6, -5) if wrong else rng.uniform(3, 4)))
            (M, half, slope), (_, v, acc) = w.parts(), w.at.stroke
            right = np.array([M * acc + 2 * half * v**2, half * v**2, slope])
            if left_over(*w.case(right, "").args).max() > TENTH / 4:
                continue
            if wrong is None:
                return w.case(right, "no mistake")
            terms = right.copy()
            terms[term, body] = wrong(w, rng)[body]
            off = np.abs((terms - right)[term, body]).max() / np.abs(terms[term, body]).max()
            handed_out = w.case(terms, f"a mistake in {TERMS[term]} of the {BODIES[body]}")
            if min(off, left_over(*handed_out.args)[term, body]) > 2.5 * TENTH:
                return handed_out

    slipped, told = rng.permutation(3), rng.permutation(3)
    return [
        *(case(MOMENTUM, body, in_momentum) for body in slipped[:2]),
        *(case(KINETIC, body, in_kinetic) for body in told[:2]),
        case(WEIGHTS, ROD, as_in_the_source),
        case(WEIGHTS, rng.choice([0, 2]), in_weights),
        *(case() for _ in range(2)),
    ]


def same_name(expected: Outcome, got: Outcome) -> str | None:
    match expected, got:
        case _, Lost(why=why):
            return why
        case _, Raised(type=name):
            return f"it raised {name}"
        case Value(value=right), Value(value=answer):
            if right is None or answer is None:
                if right is answer:
                    return None
                return "it names a term where all are right" if right is None else "it names none where one is wrong"
            if not isinstance(answer, (tuple, list)) or len(answer) != 2:
                return f"it is neither None nor a pair such as {(TERMS[0], BODIES[0])}"
            if right == ANY or tuple(map(str, answer)) == tuple(map(str, right)):
                return None
            if answer[0] not in TERMS or answer[1] not in BODIES:
                return "it holds a name that is not one of those in TERMS and BODIES"
            return f"it names the wrong {'body' if answer[1] != right[1] else 'term'}"
    return None


def wherever(holds: Callable) -> Callable:
    """Looks at the cases where this holds of the right answer."""
    return lambda trial, right: same_name(right.outcome, trial.outcome) if holds(right.outcome.value) else None


WRONG_TERM = Task(
    name="wrong_term",
    title="find the planted wrong term of a force",
    function="wrong_term",
    reference=wrong_term,
    cases=planted_cases,
    agree=same_name,
    tolerance=Tolerance(0.0, "a term is right or wrong"),
    section="cylinder-force: Why the two methods differed",
    aspects=(
        Aspect(
            "it names the body and which of the two terms of the kinetic energy is wrong",
            1.0,
            wherever(lambda right: right is not None and right[0] != TERMS[WEIGHTS]),
        ),
        Aspect(
            "it names the body whose dV/da is wrong",
            0.5,
            wherever(lambda right: right is not None and right[0] == TERMS[WEIGHTS]),
        ),
        Aspect("it names none where all are right", 0.5, wherever(lambda right: right is None)),
    ),
    variants=(
        Variant(
            "Whichever kinetic term is wrong, d/dt dT/dv is named",
            "The power of the two together tells the body. dT/dv is 2 T/v: what does that tell of each?",
            of_a_kinetic(lambda term, body: (TERMS[MOMENTUM], body)),
            share=0.25,
        ),
        Variant(
            "Whichever kinetic term is wrong, dT/da is named",
            "The power of the two together tells the body. dT/dv is 2 T/v: what does that tell of each?",
            of_a_kinetic(lambda term, body: (TERMS[KINETIC], body)),
            share=0.25,
        ),
        Variant(
            "The two kinetic terms are exchanged",
            "Which of the two is still right when dT/dv is 2 T/v?",
            of_a_kinetic(lambda term, body: (TERMS[KINETIC if term == TERMS[MOMENTUM] else MOMENTUM], body)),
            share=0.25,
        ),
        Variant(
            "The kinetic terms are not looked at",
            "What do the two terms of T do to the kinetic energy?",
            of_a_kinetic(lambda term, body: None),
        ),
        Variant(
            "The largest term is named",
            "Large terms can be right. Which one does not fit the energies?",
            largest_term,
        ),
        Variant(
            "The body comes first",
            "In which order does the task ask for the two?",
            naming(lambda term, body: (body, term)),
            share=0.5,
        ),
        Variant(
            "Numbers are returned, and not names",
            "TERMS and BODIES hold the names.",
            naming(lambda term, body: (TERMS.index(term), BODIES.index(body))),
            share=0.5,
        ),
        Variant(
            "A wrong weight is not seen",
            "Over a whole period a force that depends on the stroke alone does no work, be it right or wrong: look at "
            "each instant.",
            naming(lambda term, body: None if term == TERMS[WEIGHTS] else (term, body)),
            share=0.5,
        ),
        Variant(
            "The errors of differences are taken for a mistake",
            "From which size on does the task call a term wrong?",
            lambda *args: wrong_term(*args) or ANY,
            share=0.75,
        ),
    ),
)

EXERCISE = Exercise(
    name="11_cylinder",
    title="The hydraulic cylinder: how it moves a mechanism, and with which force",
    tasks=(CYLINDER_ANGLES, CYLINDER_RATIOS, VIRTUAL_POWER, LAGRANGE_TERMS, WRONG_TERM),
)
