"""Exercise 5: other right ways get full points, and ways that only look right do not."""

import math

import numpy as np
import pytest
from judging import judged
from scipy.linalg import lu_factor, lu_solve

from autograder.checks import task

DRAWS = [f"route {n}" for n in range(40)]


def faults(assessment):
    return [finding.fault for finding in assessment.findings if finding.fault]


# --- one position


def by_cramer(residual, jacobian, theta2, seed, tol=1e-6):
    """Lists and determinants; it looks once more at where it arrived."""
    q = list(seed)
    for _ in range(15):
        m, f = np.array(jacobian(q, theta2)), np.array(residual(q, theta2))
        step = [np.linalg.det(np.where(np.arange(3) == j, f[:, None], m)) / np.linalg.det(m) for j in range(3)]
        q = [a - d for a, d in zip(q, step, strict=True)]
        if math.hypot(*step) < tol:
            residual(q, theta2)
            return q
    raise ArithmeticError("no position")


def by_lu_in_place(residual, jacobian, theta2, seed, tol=1e-6):
    q = np.array(seed, dtype=float)
    step = np.full(3, np.inf)
    count = 0
    while np.linalg.norm(step) >= tol:
        count += 1
        if count > 100:
            raise OverflowError("the loop does not close")
        step = lu_solve(lu_factor(jacobian(q, theta2)), residual(q, theta2))
        q -= step
    return q[:, None].T[0]


def by_recursion(residual, jacobian, theta2, seed, tol=1e-6, left=30):
    if not left:
        raise FloatingPointError("no iterations are left")
    step = np.linalg.lstsq(jacobian(seed, theta2), residual(seed, theta2), rcond=None)[0]
    ahead = seed - step
    return ahead if np.sqrt(step @ step) < tol else by_recursion(residual, jacobian, theta2, ahead, tol, left - 1)


# --- rates


def closed(q, theta2, lengths):
    r1y, r2, r3 = lengths
    r1, th1, th3 = np.transpose(q)
    gap = [r1 * np.cos(th1) - r2 * np.cos(theta2) - r3 * np.cos(th3)]
    gap += [r1 * np.sin(th1) - r2 * np.sin(theta2) - r3 * np.sin(th3), r1 * np.sin(th1) - r1y]
    if np.abs(gap).max() > 1e-6:
        raise ValueError(f"position {np.abs(gap).max(axis=0).argmax()} is open")
    return r1, th1, th3


def by_formulas(q, crank, lengths):
    """In closed form: the slider's x, and r1 and theta1 as its polar coordinates."""
    (theta2, w2, al2), (r1y, r2, r3) = crank, lengths
    r1, _, th3 = closed(q, theta2, lengths)
    w3 = -w2 * r2 * np.cos(theta2) / (r3 * np.cos(th3))
    al3 = (r2 * np.sin(theta2) * w2**2 + r3 * np.sin(th3) * w3**2 - al2 * r2 * np.cos(theta2)) / (r3 * np.cos(th3))
    x = r2 * np.cos(theta2) + r3 * np.cos(th3)
    vx = -r2 * np.sin(theta2) * w2 - r3 * np.sin(th3) * w3
    ax = -r2 * (np.cos(theta2) * w2**2 + np.sin(theta2) * al2) - r3 * (np.cos(th3) * w3**2 + np.sin(th3) * al3)
    vr, w1 = vx * x / r1, -vx * r1y / r1**2
    ar = (vx**2 + x * ax) / r1 - (x * vx) ** 2 / r1**3
    al1 = -ax * r1y / r1**2 + 2 * vx * r1y * vr / r1**3
    return np.array([[vr, w1, w3], [ar, al1, al3]]).transpose(0, 2, 1)


def by_loops(q, crank, lengths):
    closed(q, crank[0], lengths)
    _, r2, r3 = lengths
    velocities, accelerations = [], []
    for (r1, th1, th3), theta2, w2, al2 in zip(q, *crank, strict=True):
        s1, c1, s2, c2, s3, c3 = (f(a) for a in (th1, theta2, th3) for f in (math.sin, math.cos))
        inverse = np.linalg.inv([[-c1, r1 * s1, -r3 * s3], [s1, r1 * c1, -r3 * c3], [s1, r1 * c1, 0]])
        vr, w1, w3 = inverse @ [r2 * s2 * w2, r2 * c2 * w2, 0]
        known = [
            2 * vr * w1 * s1 + r1 * w1**2 * c1 - r3 * w3**2 * c3 - r2 * (w2**2 * c2 + al2 * s2),
            2 * vr * w1 * c1 - r1 * w1**2 * s1 + r3 * w3**2 * s3 + r2 * (w2**2 * s2 - al2 * c2),
            2 * vr * w1 * c1 - r1 * w1**2 * s1,
        ]
        velocities.append([vr, w1, w3])
        accelerations.append(list(-inverse @ known))
    return velocities, accelerations


def by_complex_numbers(q, crank, lengths):
    """r1 e^(i th1) = r2 e^(i th2) + r3 e^(i th3), in which the height of the left side is constant."""
    (theta2, w2, al2), (_, r2, r3) = crank, lengths
    r1, th1, th3 = closed(q, theta2, lengths)
    e1, e2, e3 = (np.exp(1j * angle) for angle in (th1, theta2, th3))
    w3 = -(r2 * e2).real * w2 / (r3 * e3).real
    motion = 1j * (r2 * w2 * e2 + r3 * w3 * e3) / e1
    towards = r2 * e2 * w2**2 + r3 * e3 * w3**2 - 1j * r2 * e2 * al2
    al3 = towards.imag / (r3 * e3).real
    total = (1j * r3 * al3 * e3 - towards) / e1
    vr, w1 = motion.real, motion.imag / r1
    rates = (vr, w1, w3), (total.real + r1 * w1**2, (total.imag - 2 * vr * w1) / r1, al3)
    return [np.stack(three, axis=-1) for three in rates]


# --- sweep


def by_lists(residual, jacobian, theta2, seed, tol=1e-6):
    q, rows = list(seed), []
    for k in range(len(theta2)):
        try:
            q = by_cramer(residual, jacobian, float(theta2[k]), q, tol)
        except ArithmeticError:
            raise ArithmeticError(f"the loop does not close at index {k}, theta2 = {theta2[k]:.3f}") from None
        rows.append(q)
    return rows


def extrapolated(residual, jacobian, theta2, seed, tol=1e-6):
    """The line through the last two positions is a better guess than the last."""
    found = np.empty((len(theta2), 3))
    for k, angle in enumerate(theta2):
        guess = seed if k == 0 else found[0] if k == 1 else 2 * found[k - 1] - found[k - 2]
        try:
            found[k] = by_recursion(residual, jacobian, angle, guess, tol)
        except ArithmeticError as why:
            raise ArithmeticError(f"{why} (point {k} of {len(theta2)})") from why
    return found


def by_continuation(residual, jacobian, theta2, seed, tol=1e-6):
    """Four small turns of the crank between two angles."""
    q, found = by_lu_in_place(residual, jacobian, theta2[0], seed, tol), []
    for k in range(len(theta2)):
        before = theta2[max(k - 1, 0)]
        for part in (0.25, 0.5, 0.75, 1.0):
            angle = theta2[k] if part == 1 else before + part * (theta2[k] - before)
            try:
                q = by_lu_in_place(residual, jacobian, angle, q, tol)
            except ArithmeticError:
                raise ArithmeticError(f"open between the points {k - 1} and {k}") from None
        found.append(q)
    return np.array(found)


RIGHT = {
    "saw_position": (by_cramer, by_lu_in_place, by_recursion),
    "saw_rates": (by_formulas, by_loops, by_complex_numbers),
    "saw_sweep": (by_lists, extrapolated, by_continuation),
}


@pytest.mark.parametrize(
    ("name", "route"), [(n, r) for n, routes in RIGHT.items() for r in routes], ids=lambda x: getattr(x, "__name__", x)
)
def test_another_right_way_gets_full_points(name, route):
    for student in DRAWS:
        assessment = judged(name, route, student)
        assert (assessment.verdict, assessment.points) == ("right", task(name).points), (student, assessment.diagnosis)


def test_a_position_that_is_never_refused_loses_the_point_for_the_open_loop():
    def never_raises(residual, jacobian, theta2, seed, tol=1e-6):
        q = np.array(seed)
        for _ in range(15):  # as the program of source A has it
            step = np.linalg.solve(jacobian(q, theta2), residual(q, theta2))
            q = q - step
            if np.linalg.norm(step) < tol:
                break
        return q

    for student in DRAWS:
        assessment = judged("saw_position", never_raises, student)
        assert assessment.points == 2
        assert faults(assessment) == ["it returned a value where the loop cannot close"]


def test_a_tolerance_of_ones_own_is_seen_in_the_number_of_looks():
    for own in (1e-12, 1e-6):
        for student in DRAWS:
            assessment = judged("saw_position", lambda *args, own=own: by_lu_in_place(*args[:4], own), student)
            assert assessment.points == 2.5
            assert [fault for fault in faults(assessment) if "more" in fault]


def test_starting_every_point_from_the_first_position_is_a_cold_start():
    def from_the_first(residual, jacobian, theta2, seed, tol=1e-6):
        first = by_lu_in_place(residual, jacobian, theta2[0], seed, tol)
        found = []
        for k, angle in enumerate(theta2):
            try:
                found.append(by_lu_in_place(residual, jacobian, angle, first, tol))
            except ArithmeticError:
                raise ArithmeticError(f"point {k}") from None
        return found

    for student in DRAWS:
        assessment = judged("saw_sweep", from_the_first, student)
        assert assessment.points < 3
        assert any("far from the position before it" in f or "off by" in f for f in faults(assessment))


def test_an_index_that_is_one_off_or_missing_is_not_the_index():
    def told(change):
        def solver(residual, jacobian, theta2, seed, tol=1e-6):
            q, found = seed, []
            for k, angle in enumerate(theta2):
                try:
                    q = by_lu_in_place(residual, jacobian, angle, q, tol)
                except ArithmeticError:
                    raise ArithmeticError(change(k, angle)) from None
                found.append(q)
            return found

        return solver

    for change, points in (
        (lambda k, angle: f"open at index {k}.", 3),
        (lambda k, angle: f"open at point {k + 1}", 2.5),
        (lambda k, angle: f"open at {angle:.6f} rad after 100 iterations", 2.5),
    ):
        for student in DRAWS:
            assert judged("saw_sweep", told(change), student).points == points


def test_velocities_alone_earn_their_part():
    def no_accelerations(q, crank, lengths):
        v, _ = by_formulas(q, crank, lengths)
        return v, np.zeros_like(v)

    for student in DRAWS:
        assert judged("saw_rates", no_accelerations, student).points == 2
