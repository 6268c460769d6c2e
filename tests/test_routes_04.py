"""Exercise 4: whoever goes another right way gets full points, and an unknown slip costs its own part alone."""

import math
from functools import cache
from itertools import product

import numpy as np
import pytest
import sympy as sp
from judging import judged
from scipy.optimize import brentq

from autograder.checks import task
from mechlib.hacksaw import Hacksaw

STUDENTS = [f"route {n}" for n in range(40)]


def routes(*functions):
    return pytest.mark.parametrize("function", functions, ids=lambda f: f.__name__)


# --- closure_equations


def by_mechlib(q, v, a, crank, lengths):
    """The closure that the chapter derives, in which the numbers are put for the symbols."""
    closure = Hacksaw.closure
    values = dict(zip(closure.parameters, lengths, strict=True))
    coordinates = *closure.unknowns, closure.input
    for coordinate, *numbers in zip(coordinates, (*q, crank[0]), (*v, crank[1]), (*a, crank[2]), strict=True):
        values |= dict(zip(coordinate, numbers, strict=True))
    levels = closure.position_equations, closure.velocity_equations, closure.acceleration_equations
    return [[float(F.subs(values)) for F in level] for level in levels]


@cache
def differentiated_in_time():
    """Functions of time, differentiated twice, and their names put back: nothing here knows a chain rule of ours."""
    t = sp.Symbol("t")
    r1, th1, th2, th3 = moving = [sp.Function(name)(t) for name in ("r1", "th1", "th2", "th3")]
    r1y, r2, r3 = lengths = sp.symbols("r1y r2 r3")
    F = sp.Matrix(
        [
            -r1 * sp.cos(th1) + r2 * sp.cos(th2) + r3 * sp.cos(th3),
            r1 * sp.sin(th1) - r2 * sp.sin(th2) - r3 * sp.sin(th3),
            r1 * sp.sin(th1) - r1y,
        ]
    )
    names = [sp.symbols(f"x{k} v{k} a{k}") for k in range(4)]
    back = [(f.diff(t, n), names[k][n]) for n in (2, 1, 0) for k, f in enumerate(moving)]
    arguments = [*(symbol for name in names for symbol in name), *lengths]
    return sp.lambdify(arguments, sp.Matrix([[*F], [*F.diff(t)], [*F.diff(t, 2)]]).subs(back))


def by_functions_of_time(q, v, a, crank, lengths):
    moving = [(q[0], v[0], a[0]), (q[1], v[1], a[1]), crank, (q[2], v[2], a[2])]
    return differentiated_in_time()(*(float(x) for triple in moving for x in triple), *lengths)


def by_taylor_polynomials(q, v, a, crank, lengths):
    """Each vector as a power series in time up to its square; the k-th derivative is k! times its coefficient."""

    def times(f, g):
        return [f[0] * g[0], f[0] * g[1] + f[1] * g[0], f[0] * g[2] + f[1] * g[1] + f[2] * g[0]]

    def vector(length, angle):
        th, w, al = angle
        e = complex(math.cos(th), math.sin(th))
        unit = [e, 1j * w * e, (1j * al / 2 - w**2 / 2) * e]
        return times([length[0], length[1], length[2] / 2], unit)

    r1y, r2, r3 = lengths
    one = vector((q[0], v[0], a[0]), (q[1], v[1], a[1]))
    two, three = vector((r2, 0, 0), crank), vector((r3, 0, 0), (q[2], v[2], a[2]))
    rows = []
    for k in range(3):
        gap = math.factorial(k) * (one[k] - two[k] - three[k])
        rows.append((-gap.real, gap.imag, math.factorial(k) * one[k].imag - (r1y if k == 0 else 0)))
    return rows


@routes(by_mechlib, by_functions_of_time, by_taylor_polynomials)
def test_other_derivations_of_the_equations_get_full_points(function):
    for student in STUDENTS[: 10 if function is by_mechlib else None]:
        assessment = judged("closure_equations", function, student)
        assert assessment.points == 4, assessment.diagnosis


def test_a_slip_in_one_level_costs_that_level_alone_and_its_equation_is_named():
    reference = task("closure_equations").reference
    for level, earned in ((1, 3), (2, 2)):

        def slip(*args, level=level):
            rows = reference(*args)
            rows[level, 1] += 0.1  # Fy
            return rows

        assessment = judged("closure_equations", slip, "anyone")
        assert assessment.points == earned
        assert "wrong in the row: Fy." in assessment.diagnosis


# --- closure_jacobian


def closure(q, lengths, th2=0.7):
    (r1, th1, th3), (r1y, r2, r3) = q, lengths
    return np.array(
        [
            -r1 * np.cos(th1) + r2 * np.cos(th2) + r3 * np.cos(th3),
            r1 * np.sin(th1) - r2 * np.sin(th2) - r3 * np.sin(th3),
            r1 * np.sin(th1) - r1y,
        ]
    )


def by_central_differences(q, lengths):
    steps = 1e-5 * np.eye(3)
    return np.transpose([(closure(q + h, lengths) - closure(q - h, lengths)) / 2e-5 for h in steps])


def by_forward_differences(q, lengths):
    return np.transpose([(closure(q + h, lengths) - closure(q, lengths)) / 1e-8 for h in 1e-8 * np.eye(3)])


def by_a_complex_step(q, lengths):
    return [list(row) for row in np.transpose([closure(q + 1e-30j * e, lengths).imag / 1e-30 for e in np.eye(3)])]


def by_the_velocity_equations(q, lengths):
    """Column j is the velocity row for the j-th velocity of one and a crank that stands still."""
    return np.column_stack([by_taylor_polynomials(q, e, (0, 0, 0), (0.3, 0, 0), lengths)[1] for e in np.eye(3)])


def by_sympy(q, lengths):
    symbols = sp.symbols("r1 th1 th3")
    (r1, th1, th3), r3 = symbols, sp.Symbol("r3")
    F = sp.Matrix(
        [-r1 * sp.cos(th1) + r3 * sp.cos(th3), r1 * sp.sin(th1) - r3 * sp.sin(th3), r1 * sp.sin(th1)]
    ).jacobian(symbols)
    values = dict(zip((*symbols, r3), (*q, lengths[2]), strict=True))
    return np.array(F.subs(values).evalf(), dtype=float)


@routes(by_central_differences, by_forward_differences, by_a_complex_step, by_the_velocity_equations, by_sympy)
def test_other_ways_to_the_jacobian_get_full_points(function):
    for student in STUDENTS:
        assessment = judged("closure_jacobian", function, student)
        assert assessment.points == 2, assessment.diagnosis


# --- assemblies


def by_circle_and_line(theta2, lengths):
    """Where the circle about A meets the guide; r1 as in the source, its sign from the side of O."""
    r1y, r2, r3 = lengths
    x, y = r2 * math.cos(theta2), r2 * math.sin(theta2)
    reach = math.sqrt(r3**2 - (r1y - y) ** 2)  # raises ValueError itself
    rows = []
    for side in (-1, 1):
        slider = x + side * reach
        r1 = math.copysign(math.hypot(slider, r1y), slider)
        rows.append([r1, math.atan(r1y / slider), math.atan2(r1y - y, side * reach)])
    return rows


def by_bisection(theta2, lengths):
    r1y, r2, r3 = lengths
    rows = []
    for low in (np.pi / 2, -np.pi / 2):  # one half turn for each side
        th3 = brentq(lambda th3: r2 * np.sin(theta2) + r3 * np.sin(th3) - r1y, low, low + np.pi, xtol=1e-14)
        z = r2 * np.exp(1j * theta2) + r3 * np.exp(1j * th3)
        rows.append((abs(z), np.angle(z), th3))
    return tuple(rows)


def by_newton(theta2, lengths):
    r1y, r2, r3 = lengths
    if not -r3 <= r1y - r2 * np.sin(theta2) <= r3:
        raise ValueError("no assembly")
    rows = []
    for th3 in (np.pi, 0.0):
        x = r2 * np.cos(theta2) + r3 * np.cos(th3)
        q = np.array([np.hypot(x, r1y), np.arctan2(r1y, x), th3])
        for _ in range(60):
            step = np.linalg.solve(by_a_complex_step(q, lengths), closure(q, lengths, theta2))
            q = q - step
            if np.linalg.norm(step) < 1e-10:
                break
        rows.append(q)
    return np.array(rows)


def as_mechlib_has_it(theta2, lengths):
    saw = Hacksaw(*lengths)
    return np.stack([saw.position(theta2, branch) for branch in ("left", "right")])


def r1_from_the_sine(theta2, lengths):
    """theta1 between -90 and 90 degrees, and r1 from the guide: the sign comes out right by itself."""
    r1y, r2, r3 = lengths
    th3 = np.pi - math.asin((r1y - r2 * np.sin(theta2)) / r3)
    th3 = np.array([th3, np.pi - th3])
    th1 = np.arctan(r1y / (r2 * np.cos(theta2) + r3 * np.cos(th3)))
    return np.column_stack((r1y / np.sin(th1), th1, th3))


@routes(by_circle_and_line, by_bisection, by_newton, as_mechlib_has_it, r1_from_the_sine)
def test_other_ways_to_the_assemblies_get_full_points(function):
    for student in STUDENTS:
        assessment = judged("assemblies", function, student)
        assert assessment.points == 2, assessment.diagnosis


@pytest.mark.parametrize(("turns", "sign"), [*product((-2, 1), (-1, 1))])
def test_another_turn_and_a_length_of_the_other_sign_are_the_same_assembly(turns, sign):
    def elsewhere(theta2, lengths):
        r1, th1, th3 = as_mechlib_has_it(theta2, lengths).T
        return np.column_stack(
            (sign * r1, th1 + 2 * np.pi * turns + (0 if sign > 0 else np.pi), th3 - 2 * np.pi * turns)
        )

    for student in STUDENTS[:10]:
        assert judged("assemblies", elsewhere, student).points == 2


def test_the_sign_of_r1_alone_is_not_the_same_assembly():
    def turned(theta2, lengths):
        return as_mechlib_has_it(theta2, lengths) * [-1, 1, 1]

    assessment = judged("assemblies", turned, "anyone")
    assert assessment.points == 0
    assert "theta1" in assessment.diagnosis


def test_nan_where_no_assembly_exists_is_called_nan():
    right = task("assemblies").reference

    def quiet(theta2, lengths):
        try:
            return right(theta2, lengths)
        except ValueError:
            return np.full((2, 3), np.nan)

    assessment = judged("assemblies", quiet, "anyone")
    assert assessment.points == 1.5
    assert "it returned nan where ValueError is right" in assessment.diagnosis


def test_two_mistakes_are_told_by_the_one_that_counts_first():
    """Whoever forgets to refuse an open loop as well still learns that the order of the assemblies is wrong."""

    def two_mistakes(theta2, lengths):
        with np.errstate(invalid="ignore"):
            reach = np.arcsin((lengths[0] - lengths[1] * np.sin(theta2)) / lengths[2])
        rows = []
        for th3 in (reach, np.pi - reach):
            x = lengths[1] * np.cos(theta2) + lengths[2] * np.cos(th3)
            rows.append((np.hypot(x, lengths[0]), np.arctan2(lengths[0], x), th3))
        return np.array(rows)

    for student in STUDENTS[:10]:
        assert judged("assemblies", two_mistakes, student).diagnosis.startswith(
            "The assemblies are in the other order."
        )
