"""Exercise 4: the loop closure of the power hacksaw."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from autograder.checks.answers import array
from autograder.compare import Tolerance, difference, disagreement, numbers, wrong_shape
from autograder.outcome import Outcome, Raised, Value
from autograder.spec import Aspect, Case, Exercise, Task, Trial, Variant, readings


def slanted(rng: np.random.Generator) -> float:
    """An angle of any quadrant, away from the axes: neither its sine nor its cosine is small."""
    return rng.integers(4) * np.pi / 2 + rng.uniform(0.3, np.pi / 2 - 0.3)


def either_sign(rng: np.random.Generator, low: float, high: float, size: int | tuple[int, ...]) -> np.ndarray:
    return rng.uniform(low, high, size) * rng.choice([-1, 1], size)


# --- closure_equations ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Vector:
    """A vector r e^(i theta) in the complex plane with its first two time derivatives.

    The factors multiply a term of the derivatives: 1 is right, 0 forgets it.
    """

    radial: float = 1.0  # v_r along the vector, a_r in the acceleration
    coriolis: float = 1.0
    turning: float = 1.0  # omega r across the vector, alpha r in the acceleration
    tangential: float = 1.0  # alpha r alone
    centripetal: float = 1.0
    power: int = 2  # of omega in the centripetal term
    unit: Callable = lambda th: np.exp(1j * th)

    def __call__(self, length: tuple, angle: tuple) -> np.ndarray:
        """Position, velocity and acceleration, shape (3,), of (r, v_r, a_r) and (theta, omega, alpha)."""
        (r, dr, ddr), (th, w, al) = length, angle
        along = r, self.radial * dr, self.radial * ddr - self.centripetal * r * w**self.power
        across = 0, self.turning * r * w, self.turning * self.tangential * r * al + self.coriolis * 2 * dr * w
        return (np.array(along) + 1j * np.array(across)) * self.unit(th)


def cosine_keeps_its_sign(length: tuple, angle: tuple) -> np.ndarray:
    """The vector of somebody to whom the derivative of the cosine is the sine."""
    (r, dr, ddr), (th, w, al) = length, angle
    c, s = np.cos(th), np.sin(th)
    x = [r * c, dr * c + r * w * s, ddr * c + 2 * dr * w * s + r * al * s + r * w**2 * c]
    y = [r * s, dr * s + r * w * c, ddr * s + 2 * dr * w * c + r * al * c + r * w**2 * s]
    return np.array(x) + 1j * np.array(y)


RIGHT = Vector()


def residuals(q, v, a, crank, lengths, line=RIGHT, pin=RIGHT, coupler=RIGHT) -> np.ndarray:
    """Residuals of the position, velocity and acceleration equations, a row each: Fx, Fy, Fc.

    Each of the three vectors is differentiated in its own way.
    """
    (r1, th1, th3), (vr, w1, w3), (ar, al1, al3), (r1y, r2, r3) = q, v, a, lengths
    z1 = line((r1, vr, ar), (th1, w1, al1))
    z2 = pin((r2, 0, 0), crank)
    z3 = coupler((r3, 0, 0), (th3, w3, al3))
    return np.column_stack(((-z1 + z2 + z3).real, (z1 - z2 - z3).imag, z1.imag - [r1y, 0, 0]))


def with_vectors(line: Callable = RIGHT, pin: Callable = RIGHT, coupler: Callable = RIGHT) -> Callable:
    return lambda *args: residuals(*args, line=line, pin=pin, coupler=coupler)


def everywhere(vector: Callable) -> Callable:
    return with_vectors(vector, vector, vector)


def coupler_with_the_other_sign(*args):
    right, without = residuals(*args), residuals(*args, coupler=lambda length, angle: np.zeros(3))
    return np.column_stack((right[:, 0], 2 * without[:, 1] - right[:, 1], right[:, 2]))


def height_in_the_derivatives(q, v, a, crank, lengths):
    return residuals(q, v, a, crank, lengths) - np.outer([0, 1, 1], [0, 0, lengths[0]])


def crank_at_rest(q, v, a, crank, lengths):
    return residuals(q, v, a, (crank[0], 0, 0), lengths)


def equation_cases(rng: np.random.Generator) -> list[Case]:
    """Numbers that close no loop: each term is there to be seen, and so is its absence."""

    def numbers_of(r1: float) -> Case:
        angles = np.array([slanted(rng) for _ in range(3)])
        angles[0] = slanted(rng) - 2 * np.pi
        q = np.array([r1, angles[0], angles[1]])
        v, a = either_sign(rng, 0.5, 3, 3), either_sign(rng, 0.5, 3, 3)
        crank = np.array([angles[2], *either_sign(rng, 1, 3, 2)])
        lengths = np.array([rng.uniform(0.2, 0.4), rng.uniform(0.5, 0.9), rng.uniform(1.1, 2)])
        label = f"r1 = {r1:.3g}, theta1 = {q[1]:.3g}, theta3 = {q[2]:.3g}, theta2 = {crank[0]:.3g}"
        return Case((q, v, a, crank, lengths), label=label)

    return [numbers_of(-rng.uniform(0.5, 1.5)), numbers_of(rng.uniform(0.5, 1.5)), numbers_of(-rng.uniform(0.5, 1.5))]


ROUND_OFF = Tolerance(1e-9, "a sum of products differs by round-off, some 1e-16 of the scale, however it is ordered")


def row_of(level: int) -> Callable:
    """Looks at one row, and says which of its equations is off."""

    def fault(trial: Trial, right: Trial) -> str | None:
        expected = right.outcome.value
        got = array(trial, expected.shape)
        if isinstance(got, str):
            return got
        if (why := difference(expected[level], got[level], ROUND_OFF)) is None:
            return None
        off = ~(np.abs(got[level] - expected[level]) <= ROUND_OFF.relative * np.abs(expected[level]).max())
        wrong = [name for name, is_off in zip(("Fx", "Fy", "Fc"), off, strict=True) if is_off]
        return f"wrong in the row: {', '.join(wrong)}" + ("" if why.startswith("it is off") else f"; {why}")

    return fault


CLOSURE_EQUATIONS = Task(
    name="closure_equations",
    title="the position, velocity and acceleration equations of the saw",
    function="closure_equations",
    reference=residuals,
    cases=equation_cases,
    tolerance=ROUND_OFF,
    section="hacksaw-closure: Differentiate: the chain rule",
    aspects=(
        Aspect("row 0 has the position equations Fx, Fy, Fc, with the signs that are asked for", 1.0, row_of(0)),
        Aspect("row 1 has their first time derivatives", 1.0, row_of(1)),
        Aspect("row 2 has their second time derivatives, with every term", 2.0, row_of(2)),
    ),
    variants=(
        Variant(
            "The Coriolis term is missing",
            "The length and the angle of r1 both change. How often does the product rule meet v_r omega1 "
            "when r1 cos(theta1) is differentiated twice?",
            with_vectors(replace(RIGHT, coriolis=0)),
            share=0.5,
        ),
        Variant(
            "The Coriolis term is there once",
            "It comes from two places: from the change of v_r's direction, and from the change of r1 in omega1 r1.",
            with_vectors(replace(RIGHT, coriolis=0.5)),
            share=0.625,
        ),
        Variant(
            "The Coriolis term has the wrong sign",
            "Differentiate v_r cos(theta1) by the product rule, and keep the sign that the cosine brings.",
            with_vectors(replace(RIGHT, coriolis=-1)),
            share=0.625,
        ),
        Variant(
            "The centripetal term of the crank is missing",
            "A crank at constant speed still accelerates its pin: towards what?",
            with_vectors(pin=replace(RIGHT, centripetal=0)),
            share=0.625,
        ),
        Variant(
            "The centripetal term of the coupler is missing",
            "omega3 sin(theta3) is a product of two things that change in time.",
            with_vectors(coupler=replace(RIGHT, centripetal=0)),
            share=0.625,
        ),
        Variant(
            "The centripetal term of r1 is missing",
            "omega1 r1 sin(theta1) is a product of three things that change in time.",
            with_vectors(replace(RIGHT, centripetal=0)),
            share=0.625,
        ),
        Variant(
            "The centripetal terms are missing",
            "omega sin(theta) is a product of two things that change in time.",
            everywhere(replace(RIGHT, centripetal=0)),
            share=0.5,
        ),
        Variant(
            "Every term with a product of two velocities is missing",
            "The velocity equations hold angles and lengths, and these change as well as the velocities.",
            everywhere(replace(RIGHT, centripetal=0, coriolis=0)),
            share=0.5,
        ),
        Variant(
            "The centripetal terms point outwards",
            "A cosine that is differentiated twice comes back with which sign?",
            everywhere(replace(RIGHT, centripetal=-1)),
            share=0.5,
        ),
        Variant(
            "The angular velocity in the centripetal terms is not squared",
            "Look at the units: r omega is a velocity.",
            everywhere(replace(RIGHT, power=1)),
            share=0.5,
        ),
        Variant(
            "The angular acceleration of the crank is missing",
            "The motor speeds up: alpha2 is given, and it is not zero.",
            with_vectors(pin=replace(RIGHT, tangential=0)),
            share=0.625,
        ),
        Variant(
            "theta2 is held constant",
            "The crank turns: theta2 is known, and it changes in time.",
            crank_at_rest,
            share=0.25,
        ),
        Variant(
            "r1 is held constant",
            "The distance from O to the slider changes in time. What does the product rule give for r1 cos(theta1)?",
            with_vectors(replace(RIGHT, radial=0, coriolis=0)),
            share=0.25,
        ),
        Variant(
            "theta1 is held constant",
            "The direction from O to the slider changes in time. What does the product rule give for r1 cos(theta1)?",
            with_vectors(replace(RIGHT, turning=0, coriolis=0, centripetal=0)),
            share=0.25,
        ),
        Variant(
            "The derivative of the cosine has the wrong sign",
            "At theta = 0 the cosine is at its largest: does it rise or fall from there?",
            everywhere(cosine_keeps_its_sign),
            share=0.25,
        ),
        Variant(
            "The height is still there in the derivatives",
            "What is the time derivative of a constant?",
            height_in_the_derivatives,
            share=0.25,
        ),
        Variant(
            "The coupler has the wrong sign in Fy",
            "r1 = r2 + r3, for the vertical components too: which vectors stand on the same side?",
            coupler_with_the_other_sign,
            share=0.25,
        ),
        Variant(
            "Fx has the opposite sign",
            "It closes the same loop, but the task states the sign of each equation: a Jacobian must fit to it.",
            lambda *args: residuals(*args) * [-1, 1, 1],
            share=0.75,
        ),
        Variant(
            "The equations are in the order Fc, Fx, Fy",
            "Which equation belongs to which column?",
            lambda *args: residuals(*args)[:, [2, 0, 1]],
            share=0.75,
        ),
        Variant(
            "Sine and cosine are exchanged",
            "The angles are measured from the horizontal: which component does the cosine give?",
            everywhere(replace(RIGHT, unit=lambda th: np.sin(th) + 1j * np.cos(th))),
        ),
        Variant(
            "The angles are taken for degrees",
            "They are in radians, and NumPy wants radians.",
            everywhere(replace(RIGHT, unit=lambda th: np.exp(1j * np.deg2rad(th)))),
            share=0.25,
        ),
        Variant(
            "The lengths are unpacked in the order r2, r3, r1y",
            "The order of the lengths is stated in the task.",
            lambda q, v, a, crank, lengths: residuals(q, v, a, crank, np.roll(lengths, 1)),
            share=0.5,
        ),
        Variant(
            "The result is transposed",
            "A row is a level (position, velocity, acceleration), a column an equation.",
            lambda *args: residuals(*args).T,
            share=0.5,
        ),
    ),
)

# --- closure_jacobian -------------------------------------------------------------------------------------------------


def jacobian(q, lengths) -> np.ndarray:
    """Derivatives of (Fx, Fy, Fc) by (r1, theta1, theta3)."""
    (r1, th1, th3), (_, _, r3) = q, lengths
    return np.array(
        [
            [-np.cos(th1), r1 * np.sin(th1), -r3 * np.sin(th3)],
            [np.sin(th1), r1 * np.cos(th1), -r3 * np.cos(th3)],
            [np.sin(th1), r1 * np.cos(th1), 0],
        ]
    )


def without_r1(q, lengths) -> np.ndarray:
    """The Jacobian after r1 = r1y/sin(theta1) is put into Fx and Fy."""
    matrix = jacobian(q, lengths)
    matrix[0, :2] = 0, lengths[0] / np.sin(q[1]) ** 2
    matrix[1, :2] = 0, 0
    return matrix


def jacobian_cases(rng: np.random.Generator) -> list[Case]:
    def at(r1: float) -> Case:
        q = np.array([r1, slanted(rng) - 2 * np.pi, slanted(rng)])
        lengths = np.array([rng.uniform(0.2, 0.4), rng.uniform(0.5, 0.9), rng.uniform(1.1, 2)])
        return Case((q, lengths), label=f"r1 = {q[0]:.3g}, theta1 = {q[1]:.3g}, theta3 = {q[2]:.3g}")

    return [at(-rng.uniform(0.5, 0.9)), at(rng.uniform(0.5, 0.9)), at(-rng.uniform(1.2, 2)), at(rng.uniform(1.2, 2))]


def column(k: int) -> Callable:
    def fault(trial: Trial, right: Trial) -> str | None:
        got = array(trial, (3, 3))
        return got if isinstance(got, str) else difference(right.outcome.value[:, k], got[:, k], DIFFERENCES)

    return fault


DIFFERENCES = Tolerance(1e-6, "a Jacobian by differences is right to 1e-7 of the scale, one by formulas to round-off")

CLOSURE_JACOBIAN = Task(
    name="closure_jacobian",
    title="the Jacobian of the closure",
    function="closure_jacobian",
    reference=jacobian,
    cases=jacobian_cases,
    tolerance=DIFFERENCES,
    section="hacksaw-closure: One Jacobian for three levels",
    aspects=(
        Aspect("column 0 has the derivatives of Fx, Fy and Fc by r1", 0.5, column(0)),
        Aspect("column 1 has those by theta1", 0.75, column(1)),
        Aspect("column 2 has those by theta3", 0.75, column(2)),
    ),
    variants=(
        Variant(
            "The Jacobian is transposed",
            "A row is an equation, a column an unknown.",
            lambda *args: jacobian(*args).T,
            share=0.5,
        ),
        Variant(
            "It is source A's matrix (17)",
            "It is the Jacobian of another system, from which r1 was eliminated. Here r1 is an unknown, "
            "and the first row is that of Fx.",
            lambda *args: without_r1(*args)[[2, 0, 1]],
        ),
        Variant(
            "r1 is eliminated from Fx and Fy",
            "Here r1 is an unknown of its own: Fx and Fy are differentiated as they stand.",
            without_r1,
        ),
        Variant(
            "The rows are in the order Fc, Fx, Fy",
            "Which row belongs to which equation?",
            lambda *args: jacobian(*args)[[2, 0, 1]],
            share=0.75,
        ),
        Variant(
            "The columns are in the order theta1, theta3, r1",
            "Which column belongs to which unknown?",
            lambda *args: jacobian(*args)[:, [1, 2, 0]],
            share=0.75,
        ),
        Variant(
            "Every sign is turned round",
            "Which signs have the equations? Differentiate them as they stand.",
            lambda *args: -jacobian(*args),
            share=0.5,
        ),
        Variant(
            "The derivative of the cosine has the wrong sign",
            "At theta = 0 the cosine is at its largest: does it rise or fall from there?",
            lambda *args: jacobian(*args) * [[1, -1, -1], [1, 1, 1], [1, 1, 1]],
            share=0.25,
        ),
        Variant(
            "The coupler has the wrong sign in Fy",
            "Look at the sign of r3 sin(theta3) in Fy.",
            lambda *args: jacobian(*args) * [[1, 1, 1], [1, 1, -1], [1, 1, 1]],
            share=0.625,
        ),
        Variant(
            "The length of the crank stands where that of the coupler belongs",
            "Which length turns with theta3?",
            lambda q, lengths: jacobian(q, lengths[[0, 2, 1]]),
            share=0.625,
        ),
        Variant(
            "The factor r1 is missing in the derivatives by theta1",
            "theta1 stands inside r1 sin(theta1): what becomes of the factor?",
            lambda q, lengths: jacobian((1.0, q[1], q[2]), lengths),
            share=0.625,
        ),
        Variant(
            "The column of r1 is zero",
            "The distance from O to the slider is an unknown, and not a length of the mechanism.",
            lambda *args: jacobian(*args) * [0, 1, 1],
        ),
        Variant(
            "Sine and cosine are exchanged",
            "The angles are measured from the horizontal: which component does the cosine give?",
            lambda q, lengths: jacobian((q[0], *(np.pi / 2 - q[1:])), lengths),
        ),
        Variant(
            "The angles are taken for degrees",
            "They are in radians, and NumPy wants radians.",
            lambda q, lengths: jacobian((q[0], *np.deg2rad(q[1:])), lengths),
            share=0.25,
        ),
    ),
)

# --- assemblies -------------------------------------------------------------------------------------------------------


def sine_of_the_coupler(theta2, lengths) -> float:
    r1y, r2, r3 = lengths
    return (r1y - r2 * np.sin(theta2)) / r3


def polar(x: float, y: float) -> tuple[float, float]:
    return np.hypot(x, y), np.arctan2(y, x)


def closed(theta2, lengths, sine=sine_of_the_coupler, left=lambda reach: np.pi - reach, line=polar) -> np.ndarray:
    """Both assemblies, the coupler to the left first, with one of the parts exchanged; nan where there are none."""
    r1y, r2, r3 = lengths
    reach = np.arcsin(sine(theta2, lengths))
    rows = []
    for th3 in (left(reach), reach):
        r1, th1 = line(r2 * np.cos(theta2) + r3 * np.cos(th3), r1y)
        rows.append((r1, th1, th3))
    return np.array(rows)


def assemblies(theta2, lengths) -> np.ndarray:
    if abs(sine_of_the_coupler(theta2, lengths)) > 1:
        raise ValueError(f"the loop cannot close at theta2 = {theta2:.6g}")
    return closed(theta2, lengths)


def clipped(theta2, lengths) -> np.ndarray:
    return closed(theta2, lengths, sine=lambda *args: np.clip(sine_of_the_coupler(*args), -1, 1))


def refused_on_one_side(theta2, lengths) -> np.ndarray:
    if sine_of_the_coupler(theta2, lengths) > 1:
        raise ValueError("the loop cannot close")
    return closed(theta2, lengths)


def side_from_the_branch(theta2, lengths) -> np.ndarray:
    """r1 < 0 on the left branch and theta1 in a half turn about zero: right while the slider is to the left of O."""
    rows = closed(theta2, lengths)
    x = rows[:, 0] * np.cos(rows[:, 1])
    return np.column_stack((rows[:, 0] * [-1, 1], np.arctan(lengths[0] / x), rows[:, 2]))


def assembly_cases(rng: np.random.Generator) -> list[Case]:
    cases = []
    for quadrant in rng.permutation(4):  # the crank turns round
        r1y, r2 = rng.uniform(0.03, 0.05), rng.uniform(0.06, 0.09)
        r3 = rng.uniform(1.2, 1.6) * (r1y + r2)
        theta2 = quadrant * np.pi / 2 + rng.uniform(0.3, np.pi / 2 - 0.3)
        if abs(r1y - r2 * np.sin(theta2)) < 0.005:  # the coupler level: its branches differ in sign alone
            theta2 = 2 * np.pi - theta2  # the crank as far below O as it was above
        cases.append(_assembly_case(theta2, (r1y, r2, r3), "normal"))
    # a long crank: both assemblies lie on the same side of O, the right one, and then the left one
    for turn in (0.0, np.pi):
        r1y, r3 = rng.uniform(0.03, 0.05), rng.uniform(0.06, 0.09)
        r2 = rng.uniform(1.7, 2) * r3
        theta2 = turn + np.arcsin((r1y + rng.uniform(0.2, 0.5) * r3) / r2) * (1 if turn == 0 else -1)
        cases.append(_assembly_case(theta2, (r1y, r2, r3), "long"))
    for side in (1, -1):  # the crank pin too far below the guide, and too far above it
        r1y, r3 = rng.uniform(0.03, 0.05), rng.uniform(0.06, 0.09)
        r2 = r1y + rng.uniform(1.2, 1.6) * r3
        theta2 = -side * np.pi / 2 + rng.uniform(-0.2, 0.2)
        cases.append(_assembly_case(theta2, (r1y, r2, r3), "open"))
    return cases


def _assembly_case(theta2: float, lengths: tuple, kind: str) -> Case:
    label = f"theta2 = {theta2:.4g}, r1y = {lengths[0]:.3g}, r2 = {lengths[1]:.3g}, r3 = {lengths[2]:.3g}"
    return Case((float(theta2), np.array(lengths)), kind=kind, label=label)


NEAR = Tolerance(1e-8, "a closed form is right to round-off, and so is an iteration that has converged")


def same_assemblies(expected: Outcome, got: Outcome) -> str | None:
    """The joints are compared, and not the numbers: whole turns, and r1 < 0 with the opposite direction, are right."""
    if isinstance(expected, Raised) and isinstance(got, Value) and holds_nan(got.value):
        return f"it returned nan where {expected.type} is right"
    if not (isinstance(expected, Value) and isinstance(got, Value)):
        return disagreement(expected, got, NEAR)
    right, answer = np.asarray(expected.value), numbers(got.value)
    if isinstance(answer, str):
        return answer
    if answer.shape != right.shape:
        return wrong_shape(answer, right.shape)
    if not np.isfinite(right).all():  # of a known mistake: nothing is there to compare
        return None if not np.isfinite(answer).any() else "it is a number where there is none"
    if not np.isfinite(answer).all():
        return "it is not a number where the loop closes"
    r1 = np.abs(right[:, 0])
    with np.errstate(over="ignore", invalid="ignore"):  # an answer may be huge
        slider = ~(np.abs(_end(answer[:, 0], answer[:, 1]) - _end(right[:, 0], right[:, 1])) <= NEAR.relative * r1)
        coupler = ~(np.abs(_end(1, answer[:, 2]) - _end(1, right[:, 2])) <= NEAR.relative)
        length = ~(np.abs(np.abs(answer[:, 0]) - r1) <= NEAR.relative * r1)
    parts = ((length, "the length r1"), (slider & ~length, "the direction theta1 of r1"), (coupler, "theta3"))
    for row, name in enumerate(("the machine's assembly", "the other assembly")):
        wrong = [part for off, part in parts if off[row]]
        if wrong:
            return f"wrong in row {row}, {name}: {' and '.join(wrong)}"
    return None


def holds_nan(value) -> bool:
    answer = numbers(value)
    return not isinstance(answer, str) and bool(np.isnan(answer).any())


def _end(length, angle):
    return length * np.exp(1j * angle)


ASSEMBLIES = Task(
    name="assemblies",
    title="both assemblies in closed form, the machine's first",
    function="assemblies",
    reference=assemblies,
    cases=assembly_cases,
    agree=same_assemblies,
    tolerance=NEAR,
    section="hacksaw-closure: Two assembly branches",
    aspects=(
        Aspect("both assemblies close the loop, and the one with the coupler to the left is first", 1.0),
        Aspect("it holds where a long crank brings both sliders to the same side of O", 0.5, kind="long"),
        Aspect("it raises ValueError where the loop cannot close, above and below", 0.5, kind="open"),
    ),
    variants=(
        Variant(
            "The assemblies are in the other order",
            "Where does the coupler point to in the first row? Look at the sign of cos(theta3).",
            lambda *args: closed(*args)[::-1],
            share=0.5,
        ),
        Variant(
            "Both rows hold the same assembly",
            "An equation sin(theta3) = s has two solutions in a turn.",
            lambda *args: closed(*args)[[0, 0]],
            share=0.25,
        ),
        Variant(
            "Both rows hold the same assembly, the one with the coupler to the right",
            "np.arcsin gives one solution of sin(theta3) = s. Which is the other?",
            lambda *args: closed(*args)[[1, 1]],
        ),
        Variant(
            "The second solution of the sine is taken at pi plus the first",
            "Which two angles of a turn have the same sine? Draw the unit circle.",
            lambda *args: closed(*args, left=lambda reach: np.pi + reach),
            share=0.25,
        ),
        Variant(
            "The height of the guide is missing from the angle of the coupler",
            "Subtract Fy from Fc, term by term.",
            lambda *args: closed(*args, sine=lambda th2, l: -l[1] * np.sin(th2) / l[2]),
        ),
        Variant(
            "The height of the crank pin is added where it is to be subtracted",
            "By how much must the coupler rise to reach the guide, when the pin is as high as the guide?",
            lambda *args: closed(*args, sine=lambda th2, l: (l[0] + l[1] * np.sin(th2)) / l[2]),
        ),
        Variant(
            "The sine of the coupler has the wrong sign",
            "The coupler goes from A to B. When A lies above the guide, does it rise or fall?",
            lambda *args: closed(*args, sine=lambda *p: -sine_of_the_coupler(*p)),
            share=0.25,
        ),
        Variant(
            "theta1 lies in the wrong quadrant",
            "The arc tangent of y/x cannot tell (x, y) from (-x, -y). Does your r1 point along your theta1 "
            "to the slider?",
            lambda *args: closed(*args, line=lambda x, y: (np.hypot(x, y), np.arctan(y / x))),
            share=0.5,
        ),
        Variant(
            "The sign of r1 is taken from the assembly, and not from where the slider is",
            "With a long crank the slider can be to the right of O and the coupler point to the left. "
            "Does your r1 point along your theta1 to the slider?",
            side_from_the_branch,
            share=0.75,
            kind="long",
        ),
        *readings(
            "r1 is the x of the slider, and not its distance from O",
            "r1 is the length of the vector from O to the slider, which lies higher than O.",
            lambda *args: closed(*args, line=lambda x, y: (abs(x), np.arctan2(y, x))),
            lambda *args: closed(*args, line=lambda x, y: (x, np.arctan2(y, x))),
            share=0.25,
        ),
        *readings(
            "r1 begins at the crank pin, and not at O",
            "r1 = r2 + r3: is the crank in its horizontal component?",
            lambda th2, l: closed(th2, l, line=lambda x, y: polar(x - l[1] * np.cos(th2), y)),
            lambda th2, l: closed(th2, l, line=lambda x, y: polar(x - l[1] * np.cos(th2), y - l[1] * np.sin(th2))),
        ),
        Variant(
            "The columns are in the order r1, theta3, theta1",
            "The order of the unknowns is that of q.",
            lambda *args: closed(*args)[:, [0, 2, 1]],
            share=0.5,
        ),
        Variant(
            "The angles are returned in degrees",
            "Radians are asked for.",
            lambda *args: closed(*args) * [1, 180 / np.pi, 180 / np.pi],
            share=0.5,
        ),
        Variant(
            "theta2 is taken for degrees",
            "It is in radians, and NumPy wants radians.",
            lambda th2, lengths: closed(np.deg2rad(th2), lengths),
            share=0.25,
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
            refused_on_one_side,
            share=0.75,
            kind="open",
        ),
    ),
)

EXERCISE = Exercise(
    name="04_hacksaw_closure",
    title="The loop closure of the power hacksaw",
    tasks=(CLOSURE_EQUATIONS, CLOSURE_JACOBIAN, ASSEMBLIES),
)
