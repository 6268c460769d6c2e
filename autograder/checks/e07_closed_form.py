"""Exercise 7: the power hacksaw in closed form, and the errors of the two solvers."""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from autograder.checks.answers import array
from autograder.checks.e04_hacksaw_closure import sine_of_the_coupler
from autograder.checks.e05_consecutive import TURN, in_degrees, random_saw, wrapped_from
from autograder.compare import Tolerance, difference, disagreement, numbers, wrong_shape
from autograder.outcome import Outcome, Raised, Value
from autograder.spec import Aspect, Case, Exercise, Task, Trial, Variant, readings
from mechlib.closure import OpenLoopError
from mechlib.hacksaw import Branch, Hacksaw

NEAR = Tolerance(1e-8, "a closed form is right to round-off")

# --- closed_position --------------------------------------------------------------------------------------------------


def position(theta2, lengths, branch: Branch = "left") -> np.ndarray:
    try:
        return Hacksaw(*lengths).position(theta2, branch)
    except OpenLoopError as why:
        raise ValueError(f"the loop cannot close at index {why.points[0]}") from None


def continuous(x: np.ndarray, r1y: float, side: int) -> tuple[np.ndarray, np.ndarray]:
    """r1 and theta1 of a slider at (x, r1y); side is -1 on the left branch, where r1 is negative."""
    return side * np.hypot(x, r1y), np.arctan2(side * r1y, side * x)


def by_the_sine(reach: np.ndarray, branch: Branch) -> np.ndarray:
    return np.pi - reach if branch == "left" else reach


def by_formulas(
    theta2,
    lengths,
    branch: Branch = "left",
    sine: Callable = sine_of_the_coupler,
    coupler: Callable = by_the_sine,
    line: Callable = continuous,
) -> np.ndarray:
    """The position with one of its parts exchanged; nan where the loop cannot close."""
    r1y, r2, r3 = lengths
    theta3 = coupler(np.arcsin(sine(theta2, lengths)), branch)
    x = r2 * np.cos(theta2) + r3 * np.cos(theta3)
    return np.stack((*line(x, r1y, -1 if branch == "left" else 1), theta3), axis=-1)


def with_parts(**parts: Callable) -> Callable:
    """The same, but refused where the loop cannot close."""

    def wrong(theta2, lengths, branch: Branch = "left"):
        if (np.abs(sine_of_the_coupler(theta2, lengths)) > 1).any():
            raise ValueError("the loop cannot close")
        return by_formulas(theta2, lengths, branch, **parts)

    return wrong


def cosine_for_sine(theta2, lengths, branch: Branch = "left"):
    r1y, r2, r3 = lengths
    theta3 = by_the_sine(np.arcsin((r1y - r2 * np.cos(theta2)) / r3), branch)
    x = r2 * np.sin(theta2) + r3 * np.sin(theta3)
    return np.stack((*continuous(x, r1y, -1 if branch == "left" else 1), theta3), axis=-1)


def clipped(theta2, lengths, branch: Branch = "left"):
    return by_formulas(theta2, lengths, branch, sine=lambda *args: np.clip(sine_of_the_coupler(*args), -1, 1))


def refused_below_alone(theta2, lengths, branch: Branch = "left"):
    if (sine_of_the_coupler(theta2, lengths) > 1).any():
        raise ValueError("the loop cannot close")
    return by_formulas(theta2, lengths, branch)


def refused_above_alone(theta2, lengths, branch: Branch = "left"):
    if (sine_of_the_coupler(theta2, lengths) < -1).any():
        raise ValueError("the loop cannot close")
    return by_formulas(theta2, lengths, branch)


def words(saw: Hacksaw) -> str:
    return f"r1y = {saw.r1y:.4g} m, r2 = {saw.r2:.4g} m, r3 = {saw.r3:.4g} m"


def turned(rng: np.random.Generator, start: float, end: float, least: int) -> np.ndarray:
    """Crank angles from the one to the other, or back, maybe a turn on; many more than there are unknowns."""
    angles = np.linspace(start, end, int(rng.integers(least, least + 10)))
    return angles[:: rng.choice([-1, 1])] + TURN * rng.integers(-1, 2)


def passes_the_shaft(rng: np.random.Generator) -> tuple[Hacksaw, float]:
    """A saw whose slider changes the side of O, with a crank that cannot turn round, and the least sine of its angle.

    On the left branch the slider stands above O where sin(theta2) is `level`.
    """
    r2, part, level = rng.uniform(0.06, 0.09), rng.uniform(0.5, 0.7), rng.uniform(0.05, 0.3)
    saw = Hacksaw(part * r2, r2, r2 * np.sqrt(1 + part**2 - 2 * part * level))
    return saw, (saw.r1y - saw.r3) / r2


def opens(rng: np.random.Generator, side: int) -> tuple[Hacksaw, np.ndarray]:
    """A coupler too short where the crank pin is low (side -1) or high (1), and angles that are clearly on one side."""
    while True:
        r2 = rng.uniform(0.06, 0.09)
        if side < 0:
            r1y = r2 * rng.uniform(0.4, 0.7)
            saw = Hacksaw(r1y, r2, (r1y + r2) * rng.uniform(0.8, 0.95))
        else:
            saw = Hacksaw(r2 * rng.uniform(0.2, 0.35), r2, r2 * rng.uniform(0.5, 0.6))
        theta2 = np.linspace(0, TURN / 2, 32) + rng.uniform(0, 0.05)
        theta2 = theta2[theta2 < TURN / 2 - 0.05] * side
        gaps = saw.gap(theta2) / saw.r3
        first, count = int(np.argmax(gaps > 0)), int((gaps > 0).sum())
        # no other number in a message is taken for the index
        if (np.abs(gaps) > 0.01).all() and 3 < first < len(theta2) and first not in (count, len(theta2) - count):
            return saw, theta2


def position_cases(rng: np.random.Generator) -> list[Case]:
    def case(saw: Hacksaw, theta2, *branch: Branch, kind: str = "normal") -> Case:
        many = f"{np.size(theta2)} angles" if np.ndim(theta2) else "one angle"
        table = f" in a table of {np.shape(theta2)}" * (np.ndim(theta2) > 1)
        label = f"{many}{table}, the {branch[0] if branch else 'left'} branch, {words(saw)}"
        return Case((theta2, (saw.r1y, saw.r2, saw.r3), *branch), kind=kind, label=label)

    start = rng.uniform(0, TURN)
    normal = [turned(rng, start, start + rng.uniform(1.02, 1.2) * TURN, 16) for _ in range(2)]
    changing, least = passes_the_shaft(rng)
    low = np.arcsin(0.8 * least)
    half = [turned(rng, low, TURN / 2 - low, 40) for _ in range(2)]
    low_saw, low_angles = opens(rng, -1)
    high_saw, high_angles = opens(rng, 1)
    beyond = float(rng.choice(low_angles[low_saw.gap(low_angles) > 0]))
    return [
        case(random_saw(rng), normal[0]),
        case(random_saw(rng), normal[1], "right"),
        case(changing, half[0], "left", kind="passes"),
        case(changing, half[1], "right", kind="passes"),
        case(random_saw(rng), float(rng.uniform(-TURN, TURN)), kind="shape"),
        case(random_saw(rng), rng.uniform(0, TURN, (2, 4)), "right", kind="shape"),
        case(low_saw, low_angles, kind="open"),
        case(high_saw, high_angles, "right", kind="open"),
        case(low_saw, beyond, kind="open"),
    ]


def branch_of(case: Case) -> Branch:
    return case.args[2] if len(case.args) > 2 else "left"


def open_by(q: np.ndarray, theta2, lengths, branch: Branch) -> str | None:
    """What is wrong with a position as a drawing of bars and joints; a whole turn of an angle is nothing."""
    (r1, theta1, theta3), (r1y, r2, r3) = np.moveaxis(q, -1, 0), lengths
    pin, slider = r2 * np.exp(1j * np.asarray(theta2)), r1 * np.exp(1j * theta1)
    side, allowed = -1 if branch == "left" else 1, NEAR.relative * r3
    looked_for = (
        (np.isfinite(q).all(axis=-1), "it is not a number"),
        (np.abs(slider.imag - r1y) <= allowed, "the slider is not on its guide"),
        (np.abs(np.abs(slider - pin) - r3) <= allowed, "A and B are not as far apart as the coupler is long"),
        (np.abs(slider - pin - r3 * np.exp(1j * theta3)) <= allowed, "theta3 does not lead from A to B"),
        (side * np.cos(theta3) > 0, "the coupler points to the other side"),
        (side * r1 > 0, "r1 has the sign of the other branch"),
    )
    for holds, fault in looked_for:
        if not holds.all():
            wrong = np.argwhere(~holds)[0].tolist()
            return fault + (f" at index {wrong[0] if len(wrong) == 1 else tuple(wrong)}" if wrong else "")
    return None


def closes_the_loop(trial: Trial, right: Trial) -> str | None:
    got = array(trial, right.outcome.value.shape, "(..., 3)")
    return got if isinstance(got, str) else open_by(got, *trial.case.args[:2], branch_of(trial.case))


def on_branch(branch: Branch) -> Callable:
    return lambda trial, right: closes_the_loop(trial, right) if branch_of(trial.case) == branch else None


def does_not_leap(trial: Trial, right: Trial) -> str | None:
    if fault := closes_the_loop(trial, right):
        return fault
    steps = np.abs(np.diff(array(trial, right.outcome.value.shape), axis=0))
    for column, name in ((1, "theta1"), (2, "theta3")):
        if steps[:, column].max() > 1:
            return f"{name} leaps between two neighbours"
    return None


def tells_the_first(trial: Trial, right: Trial) -> str | None:
    if fault := disagreement(right.outcome, trial.outcome, NEAR):
        return fault
    if not np.ndim(trial.case.args[0]):
        return None  # a single angle has no index
    first = re.search(r"\d+", right.outcome.message).group()
    said = re.findall(r"(?<![\w.])\d+(?!\w|\.\d)", trial.outcome.message)
    return None if first in said else "its message does not tell the index of the first angle that cannot close"


def same_position(expected: Outcome, got: Outcome) -> str | None:
    """A whole turn that an angle has in all points is no difference; one that comes or goes is a leap."""
    if isinstance(expected, Value) and isinstance(got, Value):
        right, answer = np.asarray(expected.value), numbers(got.value)
        if not isinstance(answer, str) and answer.shape == right.shape and answer.ndim and answer.shape[-1] == 3:
            turns = np.round((answer - right).reshape(-1, 3)[0] / TURN) * [0, 1, 1]
            got = Value(answer - TURN * np.nan_to_num(turns, posinf=0, neginf=0))
    return disagreement(expected, got, NEAR)


def turned_by_the_arctangent(x, r1y, side):
    """As the source has it: right while the slider stays on its side."""
    return r1y / np.sin(np.arctan(r1y / x)), np.arctan(r1y / x)


CLOSED_POSITION = Task(
    name="closed_position",
    title="theta3, theta1 and r1 in closed form, on the branch that is asked for",
    function="closed_position",
    reference=position,
    cases=position_cases,
    agree=same_position,
    tolerance=NEAR,
    section="hacksaw-validation: The closed form",
    aspects=(
        Aspect("on the left branch the loop closes, the coupler points left, and r1 < 0", 1.5, on_branch("left")),
        Aspect("on the right branch it closes, the coupler points right, and r1 > 0", 0.5, on_branch("right")),
        Aspect("neither angle leaps, also where the slider passes the shaft", 0.5, does_not_leap, kind="passes"),
        Aspect("one angle has the shape (3,), a table of angles one axis more", 0.5, closes_the_loop, kind="shape"),
        Aspect("it raises ValueError where the loop cannot close, above and below", 0.5, kind="open"),
        Aspect("its message tells the index of the first such angle", 0.5, tells_the_first, kind="open"),
    ),
    variants=(
        Variant(
            "The branches are exchanged",
            "Where does the coupler point to? Look at the sign of cos(theta3).",
            lambda theta2, lengths, branch="left": position(theta2, lengths, "right" if branch == "left" else "left"),
            share=0.5,
        ),
        Variant(
            "The coupler always points to the right",
            "np.arcsin gives one solution of sin(theta3) = s. Which is the other?",
            lambda theta2, lengths, branch="left": position(theta2, lengths, "right"),
            share=0.25,
        ),
        Variant(
            "The coupler always points to the left",
            "Is `branch` used?",
            lambda theta2, lengths, branch="left": position(theta2, lengths),
            share=0.5,
        ),
        Variant(
            "The second solution of the sine is taken at pi plus the first",
            "Which two angles of a turn have the same sine? Draw the unit circle.",
            with_parts(coupler=lambda reach, branch: np.pi + reach if branch == "left" else reach),
            share=0.25,
        ),
        Variant(
            "The height of the guide is missing from the angle of the coupler",
            "Write the vertical component of r1 = r2 + r3: what is its left side?",
            with_parts(sine=lambda theta2, lengths: -lengths[1] * np.sin(theta2) / lengths[2]),
        ),
        Variant(
            "The height of the guide has the wrong sign",
            "By how much must the coupler rise from a crank pin that is as high as O?",
            with_parts(sine=lambda theta2, lengths: -(lengths[0] + lengths[1] * np.sin(theta2)) / lengths[2]),
        ),
        Variant(
            "The height of the crank pin is added where it is to be subtracted",
            "By how much must the coupler rise to reach the guide, when the pin is as high as the guide?",
            with_parts(sine=lambda theta2, lengths: (lengths[0] + lengths[1] * np.sin(theta2)) / lengths[2]),
        ),
        Variant(
            "The sine of the coupler has the wrong sign",
            "The coupler goes from A to B. When A lies above the guide, does it rise or fall?",
            with_parts(sine=lambda *args: -sine_of_the_coupler(*args)),
            share=0.25,
        ),
        Variant(
            "Sine and cosine are exchanged",
            "The angles are measured from the horizontal: which component does the cosine give?",
            cosine_for_sine,
        ),
        Variant(
            "r1 is made positive",
            "r1 is the component of a vector along its own direction. Where does r1 at theta1 lead to?",
            lambda *args: np.abs(position(*args)) * [1, 0, 0] + position(*args) * [0, 1, 1],
            share=0.5,
        ),
        Variant(
            "r1 is positive on both branches, and theta1 points to the slider",
            "It closes the loop, but on the left branch r1 < 0 is asked for, as in the other exercises.",
            with_parts(line=lambda x, r1y, side: (np.hypot(x, r1y), np.arctan2(r1y, x))),
            share=0.5,
        ),
        Variant(
            "theta1 is half a turn off on the left branch",
            "With r1 < 0 the slider lies opposite to the direction theta1.",
            with_parts(line=lambda x, r1y, side: (side * np.hypot(x, r1y), np.arctan2(r1y, x))),
            share=0.5,
        ),
        Variant(
            "theta1 has the wrong sign",
            "With r1 < 0 and the slider above O: is theta1 positive or negative?",
            with_parts(line=lambda x, r1y, side: (continuous(x, r1y, side)[0], -continuous(x, r1y, side)[1])),
            share=0.25,
        ),
        Variant(
            "theta1 is measured from the vertical",
            "The tangent of an angle from the horizontal is y/x.",
            with_parts(line=lambda x, r1y, side: (continuous(x, r1y, side)[0], np.arctan(x / r1y))),
            share=0.5,
        ),
        Variant(
            "r1 is the x of the slider, and not its distance from O",
            "r1 is the length of the vector from O to the slider, which lies higher than O.",
            with_parts(line=lambda x, r1y, side: (x, continuous(x, r1y, side)[1])),
            share=0.5,
        ),
        *readings(
            "theta1 is the arc tangent of r1y/x, and leaps where the slider passes the shaft",
            "The arc tangent of a fraction cannot tell (x, y) from (-x, -y). `np.arctan2` can, with the right signs.",
            with_parts(line=turned_by_the_arctangent),
            with_parts(line=lambda x, r1y, side: (side * np.hypot(x, r1y), np.arctan(r1y / x))),
            share=0.75,
            kind="passes",
        ),
        Variant(
            "The angles are brought into one turn, from 0 to 2 pi",
            "An angle that does not leap can be differentiated. Which angle leaps?",
            lambda *args: wrapped_from(0.0, position(*args)),
            share=0.75,
        ),
        Variant(
            "The angles are brought into one turn, from -pi to pi",
            "An angle that does not leap can be differentiated. Which angle leaps?",
            lambda *args: wrapped_from(-np.pi, position(*args)),
            share=0.75,
        ),
        Variant(
            "The angles are returned in degrees",
            "Angles are in rad until they are plotted.",
            lambda *args: in_degrees(position(*args)),
            share=0.5,
        ),
        Variant(
            "theta2 is taken for degrees",
            "It is in radians, and NumPy wants radians.",
            lambda theta2, *args: by_formulas(np.deg2rad(theta2), *args),
            share=0.25,
        ),
        Variant(
            "The columns are in the order theta3, theta1, r1",
            "That is the order in which they are found. Which is asked for?",
            lambda *args: position(*args)[..., ::-1],
            share=0.5,
        ),
        Variant(
            "Rows and columns are exchanged",
            "The last axis holds r1, theta1 and theta3: along which axis are the three put together?",
            lambda *args: np.moveaxis(position(*args), -1, 0),
            share=0.5,
        ),
        Variant(
            "Where the loop cannot close, nan is returned",
            "NumPy warns and goes on. Who reads the position must not have to look for nan.",
            by_formulas,
            share=0.75,
            kind="open",
        ),
        Variant(
            "Where the loop cannot close, it is closed by force",
            "A sine that is cut off at one gives an angle, but the coupler does not reach the guide.",
            clipped,
            share=0.75,
            kind="open",
        ),
        Variant(
            "Only a crank pin too far below the guide is refused",
            "The pin can also be too far above the guide: what are the bounds of a sine?",
            refused_below_alone,
            share=0.75,
            kind="open",
        ),
        Variant(
            "Only a crank pin too far above the guide is refused",
            "The pin can also be too far below the guide: what are the bounds of a sine?",
            refused_above_alone,
            share=0.75,
            kind="open",
        ),
    ),
)

# --- closed_form ------------------------------------------------------------------------------------------------------

NAMES = (("r1", "theta1", "theta3"), ("v_r", "omega1", "omega3"), ("a_r", "alpha1", "alpha3"))
BESIDE = (-2, -1, 1, 2)  # each instant has two neighbours in time on each side, this many steps away
STEP = 5e-4  # s
ANGLES = np.array([[[0, 1, 1]], [[0, 0, 0]], [[0, 0, 0]]], dtype=bool)  # an angle, and not a rate


def circular(off: np.ndarray, angles: np.ndarray = ANGLES) -> np.ndarray:
    """Differences from which whole turns are left out, where there are angles."""
    return np.where(angles, off - TURN * np.round(off / TURN), off)


def closed_form(theta2, omega2, alpha2, lengths) -> np.ndarray:
    position(theta2, lengths)  # a plain ValueError where it cannot close
    return np.stack(Hacksaw(*lengths).closed_form(theta2, omega2, alpha2))


@dataclass(frozen=True)
class Formulas:
    """The nine quantities, with terms that can be forgotten: 1 is right.

    A pair is for a term that stands in the equation of alpha3, and in that of the slider's acceleration as well.
    """

    crank: tuple[float, float] = (1, 1)  # omega2^2
    driven: tuple[float, float] = (1, 1)  # alpha2
    coupler: tuple[float, float] = (1, 1)  # omega3^2
    turning: float = 1  # r1 omega1^2
    coriolis: float = 1
    power: int = 2  # of the angular velocities
    sign3: int = 1  # of omega3
    leaned: Callable = np.cos  # of theta1: a speed along the guide times it is one along r1
    branch: Branch = "left"
    found: Callable = position

    def __call__(self, theta2, omega2, alpha2, lengths) -> np.ndarray:
        q = self.found(theta2, lengths, self.branch)
        (r1, theta1, theta3), (_, r2, r3) = q.T, lengths
        c2, s2, c3, s3 = r2 * np.cos(theta2), r2 * np.sin(theta2), r3 * np.cos(theta3), r3 * np.sin(theta3)
        omega3 = -self.sign3 * omega2 * c2 / c3
        square2, square3 = omega2**self.power, omega3**self.power
        (crank, also_crank), (driven, also_driven), (coupler, also_coupler) = self.crank, self.driven, self.coupler
        alpha3 = (coupler * s3 * square3 + crank * s2 * square2 - driven * c2 * alpha2) / c3
        dx = -s2 * omega2 - s3 * omega3
        ddx = -also_crank * c2 * square2 - also_driven * s2 * alpha2 - also_coupler * c3 * square3 - s3 * alpha3
        v_r, omega1 = dx * self.leaned(theta1), -dx * np.sin(theta1) / r1
        a_r = ddx * np.cos(theta1) + self.turning * r1 * omega1**self.power
        alpha1 = -(ddx * np.sin(theta1) + self.coriolis * 2 * v_r * omega1) / r1
        rates = (v_r, omega1, omega3), (a_r, alpha1, alpha3)
        return np.stack((q, *(np.stack(three, axis=-1) for three in rates)))


RIGHT = Formulas()


def forgotten_somewhere(term: str) -> tuple[Callable, ...]:
    """A term that is missing in both of its equations, or in one of them."""
    return tuple(replace(RIGHT, **{term: pair}) for pair in ((0, 0), (0, 1), (1, 0)))


def along_the_guide(velocity: bool, acceleration: bool, carried: bool) -> Callable:
    """The slider's speed or acceleration along its guide as v_r or a_r; or a v_r that the Coriolis term has as well."""

    def wrong(*args):
        right = RIGHT(*args)
        found = replace(RIGHT, leaned=np.ones_like)(*args) if carried else right.copy()
        cosine = np.cos(right[0, :, 1])
        if velocity:
            found[1, :, 0] = right[1, :, 0] / cosine
        if acceleration:
            found[2, :, 0] = (right[2, :, 0] - right[0, :, 0] * right[1, :, 1] ** 2) / cosine
        return found

    return wrong


def omega3_turned_alone(*args):
    found = RIGHT(*args)
    found[1, :, 2] *= -1
    return found


def nine_cases(rng: np.random.Generator) -> list[Case]:
    def case(instants: int) -> Case:
        saw = random_saw(rng)
        angle = rng.uniform(-TURN, 2 * TURN, instants)
        speed = rng.uniform(2, 9, instants) * rng.choice([-1, 1], instants)
        alpha2 = rng.uniform(20, 60, instants) * rng.choice([-1, 1], instants)
        t = STEP * np.array([0, *BESIDE])[:, None]
        crank = (angle + speed * t + alpha2 * t**2 / 2, speed + alpha2 * t, alpha2 + 0 * t)
        label = f"{5 * instants} points, {words(saw)}"
        return Case((*(each.ravel() for each in crank), (saw.r1y, saw.r2, saw.r3)), label=label)

    saw, theta2 = opens(rng, int(rng.choice([-1, 1])))
    rates = rng.uniform(2, 9, (2, len(theta2)))
    refused = Case((theta2, *rates, (saw.r1y, saw.r2, saw.r3)), kind="open", label=f"a loop that opens, {words(saw)}")
    return [case(6), case(40), refused]


def slopes(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """First and second time derivatives of positions in the middle of five instants."""
    return differences(np.unwrap(q.reshape(5, -1, 3), axis=0), STEP)  # no r1 leaps by metres


def differences(five: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """First and second derivatives at the first of five instants, from those BESIDE it; fourth order in the step."""
    middle, far_back, back, ahead, far_ahead = five
    first = (8 * (ahead - back) - (far_ahead - far_back)) / (12 * step)
    return first, (16 * (ahead + back) - (far_ahead + far_back) - 30 * middle) / (12 * step**2)


def shaped(trial: Trial, right: Trial) -> np.ndarray | str:
    return array(trial, right.outcome.value.shape, "(3, points, 3)")


def position_closes(trial: Trial, right: Trial) -> str | None:
    got = shaped(trial, right)
    return got if isinstance(got, str) else open_by(got[0], trial.case.args[0], trial.case.args[3], "left")


def is_the_slope(level: int) -> Callable:
    """Whether the velocities (level 1) or accelerations (2) are the derivatives of the answer's own positions."""

    def fault(trial: Trial, right: Trial) -> str | None:
        got = shaped(trial, right)
        if isinstance(got, str):
            return got
        instants = got.shape[1] // 5
        expected = slopes(got[0])[level - 1]
        if why := by_columns(expected, got[level, :instants], NAMES[level], DERIVATIVE):
            return why
        # the neighbours in time, which have no neighbours of their own on both sides
        return by_columns(right.outcome.value[level], got[level], NAMES[level], DERIVATIVE)

    return fault


def by_columns(expected: np.ndarray, got: np.ndarray, names: tuple[str, ...], tolerance: Tolerance) -> str | None:
    """Each column is held to its own scale: a length is small beside an angle."""
    for name, wanted, answer in zip(names, expected.T, got.T, strict=True):
        if why := difference(wanted, answer, tolerance):
            return f"{name}: {why}"
    return None


def same_nine(expected: Outcome, got: Outcome) -> str | None:
    """Whole turns of the angles are no difference."""
    if not (isinstance(expected, Value) and isinstance(got, Value)):
        return disagreement(expected, got, DERIVATIVE)
    right, answer = np.asarray(expected.value), numbers(got.value)
    if isinstance(answer, str):
        return answer
    if answer.shape != right.shape:
        return wrong_shape(answer, right.shape)
    if right.ndim != 3 or right.shape[::2] != (3, 3):  # of a known mistake
        return difference(right, answer, DERIVATIVE)
    return same_columns(right, right + circular(answer - right), DERIVATIVE)


def same_columns(right: np.ndarray, answer: np.ndarray, tolerance: Tolerance) -> str | None:
    """As `by_columns` for all levels, shape (levels, points, 3), in few words: many known mistakes are compared."""
    scale = np.where(np.isfinite(right), np.abs(right), 0).max(axis=1, keepdims=True)
    alike = np.isclose(answer, right, rtol=0, atol=tolerance.relative * scale, equal_nan=True)
    return None if alike.all() else "one of the nine is off"


DERIVATIVE = Tolerance(1e-6, "differences over two steps to each side are right to 1e-7 of the scale here")

WRONG_TERMS = (
    ("The centripetal term of the crank is forgotten", *forgotten_somewhere("crank")),
    ("The centripetal term of the coupler is forgotten", *forgotten_somewhere("coupler")),
    ("The angular acceleration of the crank is forgotten", *forgotten_somewhere("driven")),
    ("The centripetal term of r1 is forgotten", replace(RIGHT, turning=0)),
    ("The centripetal term of r1 has the wrong sign", replace(RIGHT, turning=-1)),
    ("The Coriolis term is forgotten", replace(RIGHT, coriolis=0)),
    ("The Coriolis term is counted once", replace(RIGHT, coriolis=0.5)),
    ("The Coriolis term has the wrong sign", replace(RIGHT, coriolis=-1)),
    ("The angular velocities are not squared", replace(RIGHT, power=1)),
)

CLOSED_FORM = Task(
    name="closed_form",
    title="all nine quantities in closed form, for all points in one call",
    function="closed_form",
    reference=closed_form,
    cases=nine_cases,
    agree=same_nine,
    tolerance=DERIVATIVE,
    section="hacksaw-validation: All nine in closed form",
    aspects=(
        Aspect("the positions of all points close the loop on the left branch", 0.5, position_closes),
        Aspect("the velocities are the time derivatives of the positions", 1.5, is_the_slope(1)),
        Aspect("the accelerations are their second time derivatives", 1.5, is_the_slope(2)),
        Aspect("it raises ValueError where the loop cannot close", 0.5, kind="open"),
    ),
    variants=(
        *(
            variant
            for name, *functions in WRONG_TERMS
            for variant in readings(
                name,
                "Differentiate the velocity that the acceleration belongs to, factor by factor, and compare.",
                *functions,
                share=0.5,
            )
        ),
        *readings(
            "omega3 has the wrong sign",
            "The height of B does not change: by how much does the coupler's share make up for the crank's?",
            replace(RIGHT, sign3=-1),
            omega3_turned_alone,
            share=0.25,
        ),
        *readings(
            "The slider's motion along the guide is taken for that along r1",
            "v_r is the rate of the length r1, and the guide is not parallel to r1.",
            along_the_guide(True, False, False),
            along_the_guide(True, False, True),
            along_the_guide(True, True, False),
            along_the_guide(True, True, True),
            share=0.375,
        ),
        Variant(
            "The coupler points to the right",
            "The saw is on the left branch.",
            replace(RIGHT, branch="right"),
            share=0.25,
        ),
        Variant(
            "omega2 is taken for revolutions per minute",
            "omega2 comes in rad/s: it needs no conversion.",
            lambda theta2, omega2, *rest: RIGHT(theta2, omega2 * TURN / 60, *rest),
            share=0.5,
        ),
        Variant(
            "omega2 and alpha2 are taken for degrees",
            "They come in rad/s and rad/s^2: they need no conversion.",
            lambda theta2, omega2, alpha2, lengths: RIGHT(theta2, np.deg2rad(omega2), np.deg2rad(alpha2), lengths),
            share=0.5,
        ),
        Variant(
            "theta2 is taken for degrees",
            "It is in radians, and NumPy wants radians.",
            lambda theta2, *rest: RIGHT(np.deg2rad(theta2), *rest),
            share=0.25,
        ),
        Variant(
            "omega2 is taken as 1 rad/s",
            "A velocity for omega2 = 1 is a velocity ratio: what drives the crank?",
            lambda theta2, omega2, *rest: RIGHT(theta2, np.ones_like(omega2), *rest),
            share=0.25,
        ),
        Variant(
            "The angles and their derivatives are returned in degrees",
            "Angles are in rad until they are plotted.",
            lambda *args: in_degrees(closed_form(*args)),
            share=0.5,
        ),
        Variant(
            "Velocities and accelerations are exchanged",
            "In which order does the task ask for the three?",
            lambda *args: closed_form(*args)[[0, 2, 1]],
            share=0.5,
        ),
        Variant(
            "The points are along the last axis",
            "The shape is (3, points, 3): a quantity is at the end.",
            lambda *args: closed_form(*args).swapaxes(1, 2),
            share=0.5,
        ),
        Variant(
            "The nine are side by side in one row",
            "The shape is (3, points, 3): positions, velocities and accelerations are one behind the other.",
            lambda *args: np.hstack(closed_form(*args)),
            share=0.5,
        ),
        Variant(
            "Where the loop cannot close, nan is returned",
            "NumPy warns and goes on. Does the position refuse such an angle?",
            replace(RIGHT, found=by_formulas),
            share=0.875,
            kind="open",
        ),
    ),
)

# --- absolute_errors --------------------------------------------------------------------------------------------------


def of_the_same_points(computed, exact) -> tuple[np.ndarray, np.ndarray]:
    if np.shape(computed) != np.shape(exact):
        raise ValueError(f"{np.shape(computed)} and {np.shape(exact)} are not states of the same points")
    return np.asarray(computed), np.asarray(exact)


def most(errors: np.ndarray) -> np.ndarray:
    return errors.max(axis=1)


def errors_by(
    compare: Callable = lambda computed, exact: np.abs(circular(computed - exact)),
    largest: Callable = most,
    paired: Callable = of_the_same_points,
) -> Callable:
    """The pair of all errors and the largest, with one of the parts exchanged."""

    def wrong(computed, exact):
        errors = compare(*paired(computed, exact))
        return errors, largest(errors)

    return wrong


absolute_errors = errors_by()


def cut_to_the_shorter(computed, exact) -> tuple[np.ndarray, np.ndarray]:
    n = min(computed.shape[1], exact.shape[1])
    return computed[:, :n], exact[:, :n]


def signed(sign: int) -> Callable:
    """The errors have a sign, and the largest are those of their size."""
    return lambda computed, exact: (sign * circular(computed - exact), absolute_errors(computed, exact)[1])


def error_cases(rng: np.random.Generator) -> list[Case]:
    def states(n: int) -> np.ndarray:
        saw = random_saw(rng)
        omega2, alpha2 = rng.uniform(2, 9, n), rng.uniform(20, 60, n) * rng.choice([-1, 1], n)
        return closed_form(rng.uniform(0, TURN, n), omega2, alpha2, (saw.r1y, saw.r2, saw.r3))

    def planted(exact: np.ndarray, least: float) -> np.ndarray:
        size = least * np.array([1, 1e3, 1e5])[:, None, None] * rng.uniform(0.2, 1, exact.shape)
        return size * rng.choice([-1, 1], exact.shape)

    def case(computed: np.ndarray, exact: np.ndarray, kind: str, label: str) -> Case:
        return Case((computed, exact), kind=kind, label=f"{computed.shape[1]} points, {label}")

    exact = [states(int(rng.integers(5, 12))) for _ in range(5)]
    cases = [case(e + planted(e, 1e-9), e, "normal", "small errors of either sign") for e in exact[:2]]
    far = exact[2] + planted(exact[2], 1e-6)
    points = rng.permutation(far.shape[1])
    far[0, points[:3], 1:] += TURN * rng.choice([-3, -2, -1, 1, 2, 3], (3, 2))
    far[0, points[3], 0] += rng.uniform(3.5, 6) * rng.choice([-1, 1])
    far[1:, points[4]] += rng.uniform(4, 9, (2, 3)) * rng.choice([-1, 1], (2, 3))
    cases.append(case(far, exact[2], "turns", "angles that are whole turns off, and other errors that are as large"))
    missing = exact[3] + planted(exact[3], 1e-9)
    missing[:, rng.integers(1, missing.shape[1])] = np.nan
    cases.append(case(missing, exact[3], "missing", "one of them nan"))
    whole, one = exact[4] + planted(exact[4], 1e-9), exact[4][:, :1]
    pairs = ((one, whole), (whole, one), (whole[:, :3], exact[4]))
    return cases + [case(*pair, "unequal", f"and {pair[1].shape[1]} exact ones") for pair in pairs]


def pair_of(value, n: int) -> tuple[np.ndarray | str, np.ndarray | str] | str:
    """Both parts of an answer, or sentences that say what came instead."""
    if not isinstance(value, (tuple, list)) or len(value) != 2:
        return "it is not a pair (errors, largest)"
    parts = []
    for name, part, shape in zip(("errors", "largest"), value, ((3, n, 3), (3, 3)), strict=True):
        found = numbers(part)
        if isinstance(found, str):
            found = f"{name}: {found}"
        elif found.shape != shape:
            found = f"{name}: {wrong_shape(found, shape)}"
        parts.append(found)
    return parts[0], parts[1]


def looked_at(which: tuple[int, ...]) -> Callable:
    """Whether the errors (0), the largest (1) or both are right."""

    def fault(trial: Trial, right: Trial) -> str | None:
        if isinstance(trial.outcome, Raised):
            return f"it raised {trial.outcome.type}"
        pair = pair_of(trial.outcome.value, right.outcome.value[0].shape[1])
        return pair if isinstance(pair, str) else off_in(right.outcome.value, pair, which)

    return fault


def off_in(right, pair, which: tuple[int, ...]) -> str | None:
    for k in which:
        if isinstance(pair[k], str):
            return pair[k]
        levels = right[k] if k == 0 else right[k][:, None]
        answers = pair[k] if k == 0 else pair[k][:, None]
        for wanted, answer, names in zip(levels, answers, NAMES, strict=True):
            if why := by_columns(wanted, answer, names, ERRORS):
                return f"{('errors', 'largest')[k]}, {why}"
    return None


def same_errors(expected: Outcome, got: Outcome) -> str | None:
    if not (isinstance(expected, Value) and isinstance(got, Value)):
        return disagreement(expected, got, ERRORS)
    if not isinstance(got.value, (tuple, list)) or len(got.value) != 2:
        return "it is not a pair (errors, largest)"
    for right, part in zip(map(np.asarray, expected.value), got.value, strict=True):
        answer = numbers(part)
        if isinstance(answer, str):
            return answer
        if answer.shape != right.shape:
            return wrong_shape(answer, right.shape)
        if right.shape == (3, 3):
            fault = same_columns(right[:, None], answer[:, None], ERRORS)
        else:  # other shapes than (3, points, 3) are those of known mistakes
            fault = same_columns(right, answer, ERRORS) if right.ndim == 3 else difference(right, answer, ERRORS)
        if fault:
            return fault
    return None


ERRORS = Tolerance(1e-5, "round-off is some 1e-6 of the smallest error here")

ABSOLUTE_ERRORS = Task(
    name="absolute_errors",
    title="absolute errors of a solver, and the largest of each quantity",
    function="absolute_errors",
    reference=absolute_errors,
    cases=error_cases,
    agree=same_errors,
    tolerance=ERRORS,
    section="hacksaw-validation: Whose error is it?",
    aspects=(
        Aspect("the errors of the nine quantities at every point, small ones too", 0.5, looked_at((0,))),
        Aspect("the largest error of each quantity over all points", 0.5, looked_at((1,))),
        Aspect("a whole turn of an angle is no error, and of nothing else", 0.5, looked_at((0, 1)), kind="turns"),
        Aspect("where a state is missing the error is nan, and so is the largest", 0.25, looked_at((0, 1)), "missing"),
        Aspect("it raises ValueError if the two do not have the same points", 0.25, kind="unequal"),
    ),
    variants=(
        *readings(
            "The errors are relative",
            "The task asks for absolute errors: what is the relative error where a velocity is zero?",
            errors_by(lambda computed, exact: np.abs(circular(computed - exact)) / np.abs(exact)),
            errors_by(lambda computed, exact: np.abs(circular(computed - exact)) / np.abs(computed)),
            errors_by(lambda computed, exact: np.abs(circular(computed - exact) / exact) * 100),
            share=0.25,
        ),
        *readings(
            "The errors keep their sign",
            "An error of -1 is larger than one of 0.5.",
            errors_by(lambda computed, exact: circular(computed - exact)),
            errors_by(lambda computed, exact: circular(exact - computed)),
            signed(1),
            signed(-1),
            share=0.25,
        ),
        Variant(
            "The errors are squared",
            "A squared error has other units than the quantity.",
            errors_by(lambda computed, exact: circular(computed - exact) ** 2),
            share=0.25,
        ),
        Variant(
            "Small errors of the angles are lost in a cosine",
            "The cosine of 1e-9 is 1 to all digits of a double: what does `np.arccos` make of it?",
            errors_by(
                lambda computed, exact: np.abs(np.where(ANGLES, np.arccos(np.cos(computed - exact)), computed - exact))
            ),
            share=0.5,
        ),
        Variant(
            "Angles that are whole turns apart are different",
            "Two angles that are a whole turn apart are one direction.",
            errors_by(lambda computed, exact: np.abs(computed - exact)),
            share=0.75,
            kind="turns",
        ),
        *readings(
            "Whole turns are left out of more than the angles",
            "Which of the nine are angles? An angular velocity that is 2 pi rad/s off is wrong.",
            *(
                errors_by(lambda computed, exact, angles=angles: np.abs(circular(computed - exact, angles)))
                for angles in ([[[1, 1, 1]], [[0, 0, 0]], [[0, 0, 0]]], [0, 1, 1], [1, 1, 1])
            ),
            share=0.75,
            kind="turns",
        ),
        Variant(
            "The mean is taken in place of the largest",
            "One bad point among a thousand hardly moves a mean.",
            errors_by(largest=lambda errors: errors.mean(axis=1)),
            share=0.5,
        ),
        *readings(
            "The norm over the points is taken in place of the largest",
            "A norm over the points grows with their number. Which error is the largest?",
            errors_by(largest=lambda errors: np.linalg.norm(errors, axis=1)),
            errors_by(largest=lambda errors: np.sqrt((errors**2).mean(axis=1))),
            share=0.5,
        ),
        *readings(
            "The three quantities of a level are thrown together",
            "Metres and radians have no common largest. The shape that is asked for is (3, 3).",
            errors_by(largest=lambda errors: errors.max(axis=(1, 2))),
            errors_by(largest=lambda errors: np.linalg.norm(errors, axis=2).max(axis=1)),
            share=0.5,
        ),
        Variant(
            "The largest is taken over the quantities, and not over the points",
            "Which axis counts the points?",
            errors_by(largest=lambda errors: errors.max(axis=2)),
            share=0.5,
        ),
        Variant(
            "The angles and their derivatives are returned in degrees",
            "Radians are asked for.",
            errors_by(lambda computed, exact: in_degrees(np.abs(circular(computed - exact)))),
            share=0.5,
        ),
        Variant(
            "The largest come first, and the errors second",
            "In which order does the task ask for them?",
            lambda *args: absolute_errors(*args)[::-1],
            share=0.5,
        ),
        *readings(
            "A point without a number is passed over",
            "A solver that gave up at one point has not solved the motion: what must its largest error say?",
            errors_by(largest=lambda errors: np.nanmax(errors, axis=1)),
            errors_by(lambda computed, exact: np.nan_to_num(np.abs(circular(computed - exact)))),
            share=0.75,
            kind="missing",
        ),
        *readings(
            "Unequal numbers of points are paired by force",
            "NumPy stretches an array of one point, and `zip` cuts the longer: compare the shapes first.",
            errors_by(paired=lambda computed, exact: (computed, exact)),
            errors_by(paired=cut_to_the_shorter),
            share=0.75,
            kind="unequal",
        ),
    ),
)

EXERCISE = Exercise(
    name="07_closed_form",
    title="The power hacksaw in closed form",
    tasks=(CLOSED_POSITION, CLOSED_FORM, ABSOLUTE_ERRORS),
    imports=("closure", "cramer", "motion", "newton", "require", "sweep"),  # the two solvers, and what they need
)
