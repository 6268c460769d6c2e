"""Exercise 7: other right ways get full points, and ways that only look right do not."""

import cmath
import math

import numpy as np
import pytest
from judging import judged

from autograder.checks import task
from mechlib.closure import Closure, Coordinate
from mechlib.newton import newton

DRAWS = [f"route {n}" for n in range(25)]


def faults(assessment):
    return [finding.fault for finding in assessment.findings if finding.fault]


# --- position


def refuse(theta2, lengths):
    r1y, r2, r3 = lengths
    for k, angle in enumerate(np.ravel(theta2)):
        if not -r3 <= r2 * math.sin(angle) - r1y <= r3:
            raise ValueError(f"at index {k}, theta2 = {angle:.3f} rad, the coupler is too short")


def by_pythagoras(theta2, lengths, branch="left"):
    """The coupler by its sides; the slider's direction by a half angle; lists for arrays."""
    refuse(theta2, lengths)
    if np.ndim(theta2):
        return [by_pythagoras(angle, lengths, branch) for angle in theta2]
    r1y, r2, r3 = lengths
    side = 1.0 if branch == "right" else -1.0
    rise = r1y - r2 * math.sin(theta2)
    reach = side * math.sqrt((r3 - rise) * (r3 + rise))
    theta3 = math.atan(rise / reach) + (0 if side > 0 else math.pi)
    x = r2 * math.cos(theta2) + reach
    r1 = side * math.hypot(x, r1y)
    return [r1, 2 * math.atan2(r1y * side, abs(r1) + x * side), theta3]


def by_complex_numbers(theta2, lengths, branch="left"):
    """theta3 as an arc cosine from the vertical; r1 as the quotient of a vector and its direction; some turns on."""
    refuse(theta2, lengths)
    r1y, r2, r3 = lengths
    side = {"left": -1, "right": 1}[branch]
    from_above = np.arccos((r1y - r2 * np.sin(theta2)) / r3)
    theta3 = np.pi / 2 - side * from_above
    slider = r2 * np.exp(1j * np.asarray(theta2)) + r3 * np.exp(1j * theta3)
    theta1 = np.angle(side * slider)
    r1 = (slider / np.exp(1j * theta1)).real
    found = np.empty((*np.shape(theta2), 3))
    found[..., 0], found[..., 1], found[..., 2] = r1, theta1 + 4 * np.pi, theta3 - 2 * np.pi
    return found


def by_the_law_of_cosines(theta2, lengths, branch="left"):
    """In the triangle O, A, B' with B' on the guide: r3^2 = r1^2 + r2^2 - 2 r1 r2 cos(...), as an equation for x."""
    refuse(theta2, lengths)
    r1y, r2, r3 = lengths
    found = np.zeros((*np.shape(theta2), 3))
    for index in np.ndindex(np.shape(theta2)):
        angle = theta2 if not index else theta2[index]
        p = r2 * np.cos(angle)
        q = r2**2 + r1y**2 - 2 * r1y * r2 * np.sin(angle) - r3**2
        root = np.sqrt(p**2 - q)
        x = p - root if branch == "left" else p + root
        theta3 = np.arctan2(r1y - r2 * np.sin(angle), x - p)
        if branch == "left" and theta3 < 0:
            theta3 += 2 * np.pi
        cotangent = np.pi / 2 - np.arctan(x / r1y)
        r1 = r1y / np.sin(cotangent)
        found[index] = (r1, cotangent, theta3) if branch == "right" else (-r1, cotangent - np.pi, theta3)
    return found


def by_newton(theta2, lengths, branch="left"):
    """No closed form at all: from a good seed it is as right to all the digits that are asked for."""
    refuse(theta2, lengths)
    r1y, r2, r3 = lengths

    def one(angle):
        def residual(q):
            x, y = q[0] * np.cos(q[1]), q[0] * np.sin(q[1])
            to_x, to_y = r2 * np.cos(angle) + r3 * np.cos(q[2]), r2 * np.sin(angle) + r3 * np.sin(q[2])
            return np.array([to_x - x, y - to_y, y - r1y])

        def jacobian(q):
            (r1, th1, th3) = q
            s, c = np.sin(th1), np.cos(th1)
            return np.array([[-c, r1 * s, -r3 * np.sin(th3)], [s, r1 * c, -r3 * np.cos(th3)], [s, r1 * c, 0]])

        near = np.array(by_pythagoras(angle, lengths, branch)) * 1.01
        return newton(residual, jacobian, near, 1e-9).root

    flat = np.array([one(angle) for angle in np.ravel(theta2)])
    return flat.reshape(*np.shape(theta2), 3)


# --- all nine


def by_quotients(theta2, omega2, alpha2, lengths):
    """The chain rule on r1^2 = x^2 + y^2 and on tan(theta1) = y/x, in no angle."""
    q = np.array(by_complex_numbers(theta2, lengths))
    r1, _, th3 = q.T
    r1y, r2, r3 = lengths
    w3 = -omega2 * r2 * np.cos(theta2) / (r3 * np.cos(th3))
    al3 = (r2 * np.sin(theta2) * omega2**2 - r2 * np.cos(theta2) * alpha2) / (r3 * np.cos(th3)) + np.tan(th3) * w3**2
    x = r2 * np.cos(theta2) + r3 * np.cos(th3)
    vx = -r2 * np.sin(theta2) * omega2 - r3 * np.sin(th3) * w3
    ax = -r2 * (np.cos(theta2) * omega2**2 + np.sin(theta2) * alpha2) - r3 * (np.cos(th3) * w3**2 + np.sin(th3) * al3)
    vr, w1 = x * vx / r1, -r1y * vx / r1**2
    ar, al1 = (vx**2 + x * ax - vr**2) / r1, -r1y * ax / r1**2 + 2 * r1y * vx * vr / r1**3
    return np.array([q.T, [vr, w1, w3], [ar, al1, al3]]).transpose(0, 2, 1)


def by_loops(theta2, omega2, alpha2, lengths):
    """A point at a time, complex numbers, lists."""
    _, r2, r3 = lengths
    rows = [[], [], []]
    for k in range(len(theta2)):
        q = by_pythagoras(float(theta2[k]), lengths)
        e1, e2, e3 = (cmath.exp(1j * angle) for angle in (q[1], float(theta2[k]), q[2]))
        w2, al2 = float(omega2[k]), float(alpha2[k])
        w3 = -r2 * w2 * e2.real / (r3 * e3.real)
        motion = 1j * (r2 * w2 * e2 + r3 * w3 * e3) / e1
        inward = r2 * w2**2 * e2 + r3 * w3**2 * e3 - 1j * r2 * al2 * e2
        al3 = inward.imag / (r3 * e3.real)
        total = (1j * r3 * al3 * e3 - inward) / e1
        vr, w1 = motion.real, motion.imag / q[0]
        rows[0].append(q)
        rows[1].append([vr, w1, w3])
        rows[2].append([total.real + q[0] * w1**2, (total.imag - 2 * vr * w1) / q[0], al3])
    return rows


def by_linear_solves(theta2, omega2, alpha2, lengths):
    """The position in closed form, and the rates by the closure of mechlib."""
    th1, th3 = (Coordinate.named(f"theta_{k} omega_{k} alpha_{k}") for k in (1, 3))
    r1, crank = Coordinate.named("r_1 v_r a_r"), Coordinate.named("theta_2 omega_2 alpha_2")
    q = np.array(by_the_law_of_cosines(theta2, lengths))
    loop = LOOPS.setdefault("saw", _closure(r1, th1, th3, crank)).loop(*lengths)
    return np.stack((q, *loop.rates(q, theta2, omega2, alpha2)))


def _closure(r1, th1, th3, crank):
    import sympy as sp

    r1y, r2, r3 = lengths = sp.symbols("h a b")
    along, up = (
        r1.position * f(th1.position) - r2 * f(crank.position) - r3 * f(th3.position) for f in (sp.cos, sp.sin)
    )
    return Closure((along, up, r1.position * sp.sin(th1.position) - r1y), (r1, th1, th3), crank, lengths)


LOOPS = {}


def by_differences(theta2, omega2, alpha2, lengths):
    """Differences of the closed position over a fine step, in time; fourth order."""
    h = 1e-3 / np.abs(omega2)
    at = [by_complex_numbers(theta2 + omega2 * k * h + alpha2 * (k * h) ** 2 / 2, lengths) for k in range(-3, 4)]
    first = sum(c * (at[3 + k] - at[3 - k]) for k, c in ((1, 45), (2, -9), (3, 1))) / (60 * h[:, None])
    second = sum(c * (at[3 + k] + at[3 - k]) for k, c in ((1, 270), (2, -27), (3, 2), (0, -245)))
    return at[3], first, second / (180 * h[:, None] ** 2)


# --- errors


def by_remainders(computed, exact):
    """The half turn on and back, and lists."""
    if len(computed[0]) != len(exact[0]):
        raise ValueError("not the same points")
    errors = []
    for level in range(3):
        gap = computed[level] - exact[level]
        if level == 0:
            gap[:, 1:] = (gap[:, 1:] + np.pi) % (2 * np.pi) - np.pi
        errors.append(np.abs(gap).tolist())
    return errors, [[max_with_nan(column) for column in zip(*level, strict=True)] for level in errors]


def max_with_nan(values):
    return math.nan if any(math.isnan(v) for v in values) else max(values)


def by_chords(computed, exact):
    """The angle between two directions from the chord of the unit circle."""
    computed, exact = (np.asarray(states, dtype=float) for states in (computed, exact))
    if computed.shape != exact.shape:
        raise ValueError("not the same points")
    errors = abs(exact - computed)
    chord = 2 * np.abs(np.sin((computed[0, :, 1:] - exact[0, :, 1:]) / 2))
    errors[0, :, 1:] = 2 * np.arcsin(chord / 2)
    return [errors, np.amax(errors, axis=-2)]


def by_the_nearer_way(computed, exact):
    if computed.shape != exact.shape:
        raise ValueError("not the same points")
    errors = np.sqrt((computed - exact) ** 2)
    way = np.fmod(errors[0, :, 1:], 2 * np.pi)
    errors[0, :, 1:] = np.minimum(way, 2 * np.pi - way)
    largest = np.full((3, 3), -np.inf)
    for k in range(errors.shape[1]):
        largest = np.maximum(largest, errors[:, k])
    return errors, largest


def by_sine_and_cosine(computed, exact):
    if np.shape(computed) != np.shape(exact):
        raise ValueError("not the same points")
    off = computed - exact
    angle = np.arctan2(np.sin(off), np.cos(off))
    is_angle = np.zeros((3, 1, 3), dtype=bool)
    is_angle[0, 0, 1:] = True
    errors = np.abs(np.where(is_angle, angle, off))
    return errors, np.sort(errors, axis=1)[:, -1]


RIGHT = {
    "closed_position": (by_pythagoras, by_complex_numbers, by_the_law_of_cosines, by_newton),
    "closed_form": (by_quotients, by_loops, by_linear_solves, by_differences),
    "absolute_errors": (by_remainders, by_chords, by_the_nearer_way, by_sine_and_cosine),
}


@pytest.mark.parametrize(
    ("name", "route"), [(n, r) for n, routes in RIGHT.items() for r in routes], ids=lambda x: getattr(x, "__name__", x)
)
def test_another_right_way_gets_full_points(name, route):
    for student in DRAWS[: 5 if route is by_newton else None]:
        assessment = judged(name, route, student)
        said = assessment.verdict, assessment.points, assessment.diagnosis
        assert said == ("right", task(name).points, ""), student


def test_a_loop_over_the_points_is_told_nothing_though_arrays_are_handed_over():
    for student in DRAWS[:5]:
        assert judged("closed_form", by_loops, student, public=True).verdict == "right"


def test_an_angle_that_leaps_costs_no_more_than_its_own_points():
    def principal(theta2, lengths, branch="left"):
        found = np.array(by_pythagoras(theta2, lengths, branch))
        found[..., 2] = np.angle(np.exp(1j * found[..., 2]))
        return found

    for student in DRAWS:
        assessment = judged("closed_position", principal, student)
        assert (assessment.points, faults(assessment)) == (3.5, ["theta3 leaps between two neighbours"])


def test_the_formula_of_the_source_holds_until_the_slider_passes_the_shaft():
    """Source A, section 5.3: the arc tangent of r1y/x, and r1 from its sine."""

    def of_the_source(theta2, lengths, branch="left"):
        found = np.array(by_pythagoras(theta2, lengths, branch))
        r1y, r2, r3 = lengths
        theta1 = np.arctan(r1y / (r2 * np.cos(theta2) + r3 * np.cos(found[..., 2])))
        found[..., 0], found[..., 1] = r1y / np.sin(theta1), theta1
        return found

    for student in DRAWS:
        assessment = judged("closed_position", of_the_source, student)
        assert assessment.points == 3.5
        assert assessment.mistake.startswith("theta1 is the arc tangent of r1y/x, and leaps")


@pytest.mark.parametrize(
    ("change", "points"),
    [
        (lambda k, angle: f"open at index {k}.", 4),
        (lambda k, angle: f"open at point {k + 1}", 3.5),
        (lambda k, angle: f"open at {angle:.6f} rad", 3.5),
        (lambda k, angle: "the loop cannot close", 3.5),
    ],
)
def test_an_index_that_is_one_off_or_missing_is_not_the_index(change, points):
    def told(theta2, lengths, branch="left"):
        r1y, r2, r3 = lengths
        gap = np.abs(r1y - r2 * np.sin(theta2)) - r3
        if np.any(gap > 0):
            k = int(np.argmax(gap > 0))
            raise ValueError(change(k, np.ravel(theta2)[k]))
        return by_pythagoras(theta2, lengths, branch)

    for student in DRAWS:
        assert judged("closed_position", told, student).points == points


def test_nan_where_the_loop_cannot_close_loses_the_points_for_the_refusal():
    def silent(theta2, lengths, branch="left"):
        r1y, r2, r3 = lengths
        with np.errstate(invalid="ignore"):
            reach = np.arcsin((r1y - r2 * np.sin(theta2)) / r3)
        side = -1 if branch == "left" else 1
        x = r2 * np.cos(theta2) + side * r3 * np.cos(reach)
        theta3 = np.pi - reach if side < 0 else reach
        return np.stack((side * np.hypot(x, r1y), np.arctan2(side * r1y, side * x), theta3), axis=-1)

    for student in DRAWS:
        assessment = judged("closed_position", silent, student)
        assert (assessment.points, assessment.mistake.split(".")[0]) == (
            3,
            "Where the loop cannot close, nan is returned",
        )


def test_rates_that_are_nothing_earn_the_position_and_the_refusal_alone():
    def no_rates(theta2, omega2, alpha2, lengths):
        q = np.array(by_complex_numbers(theta2, lengths))
        return q, np.zeros_like(q), np.zeros_like(q)

    for student in DRAWS:
        assert judged("closed_form", no_rates, student).points == 1


def test_accelerations_of_wrong_velocities_are_not_right_because_they_fit_to_them():
    def doubled(theta2, omega2, alpha2, lengths):
        return by_quotients(theta2, omega2, alpha2, lengths) * np.array([1, 2, 2])[:, None, None]

    for student in DRAWS:
        assert judged("closed_form", doubled, student).points == 1


def test_errors_alone_earn_their_part():
    def without_the_largest(computed, exact):
        return by_chords(computed, exact)[0], None

    for student in DRAWS:
        assert judged("absolute_errors", without_the_largest, student).points == 0.75


def test_whole_turns_of_the_angles_hide_no_known_mistake():
    def turned_on_and_once(theta2, omega2, alpha2, lengths):
        q, v, a = by_quotients(theta2, omega2, alpha2, lengths)
        return (
            q + np.array([0, 0, 2 * np.pi]),
            v,
            a + np.stack((0 * theta2, v[:, 0] * v[:, 1] / q[:, 0], 0 * theta2), axis=-1),
        )

    for student in DRAWS:
        assessment = judged("closed_form", turned_on_and_once, student)
        assert assessment.mistake.startswith("The Coriolis term is counted once")
