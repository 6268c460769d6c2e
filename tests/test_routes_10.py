"""Exercise 10: other right ways get full points, ways that only look right do not, and the oracles agree."""

import numpy as np
import pytest
import sympy as sp
from judging import judged
from scipy.integrate import odeint, solve_ivp
from sympy.physics import mechanics

from autograder.checks import e10_wiper_direct_dynamics as e10
from autograder.checks import task
from mechlib import direct, eksergian
from mechlib.newton import newton
from mechlib.wiper import MassProperties, Wiper

DRAWS = [f"route {n}" for n in range(8)]


def machine(lengths, bars):
    return Wiper(*lengths, tuple(MassProperties(mass, inertia, centre) for centre, mass, inertia in bars))


def faults(assessment):
    return [finding.fault for finding in assessment.findings if finding.fault]


# --- the checks' own numbers, beside mechlib's


@pytest.mark.parametrize("draw", DRAWS)
def test_the_reference_is_the_system_that_mechlib_assembles(draw):
    for case in task("direct_system").draw("salt", draw):
        position, velocity, torque, loads, lengths, bars = case.args
        matrix, right = e10.RIGHT(*case.args)
        system = direct._system(machine(lengths, bars), position[None], velocity[None], np.array([torque]), loads[None])
        np.testing.assert_allclose(matrix, system[0][0], rtol=0, atol=1e-12)
        np.testing.assert_allclose(right, system[1][0, :, 0], rtol=0, atol=1e-12)


@pytest.mark.parametrize("draw", DRAWS)
def test_the_acceleration_that_is_handed_in_is_that_of_eksergians_equation(draw):
    for case in task("driven_motion").draw("salt", draw)[:2]:
        acceleration, _, (theta1, omega1), _, lengths = case.args
        position = e10.closed(theta1, lengths)
        terms = eksergian.terms(machine(lengths, acceleration.bars), theta1, position[1:], omega1)
        expected = (1.5 - terms.inertial) / terms.inertia
        assert acceleration(position, omega1, 1.5) == pytest.approx(expected, rel=1e-10)


def test_the_motion_that_should_not_drift_is_that_of_mechlib():
    (case,) = (case for case in task("energy_drift").draw("salt", "anyone") if case.kind == "coasting")
    t, position, velocity, _, _, lengths, bars = case.args
    run = direct.simulate(machine(lengths, bars), lambda *_: 0.0, (position[0, 0], velocity[0, 0]), t)
    np.testing.assert_allclose(position, run.position, atol=1e-6)
    np.testing.assert_allclose(velocity, run.velocity, atol=1e-5)


# --- the system


def by_sums_of_functions(position, velocity, torque, loads, lengths, bars):
    """The equations as functions that are zero where they hold; the matrix by putting in one unknown at a time."""
    _, r1, r2, r3, r4, r5, _ = lengths
    g1, g2, g3, g4, g5 = bars[:, 0]

    def cross(a, b):
        return (a.conjugate() * b).imag

    def zero(x):
        al = x[:3]
        O, A, B, C, D, E, F = x[3::2] + 1j * x[4::2]
        e1, e2, e3 = np.exp(1j * position)
        a1, a2, a3 = ((1j * al[k] - w**2) * e for k, (w, e) in enumerate(zip(velocity, (e1, e2, e3), strict=True)))
        weights = -1j * 9.81 * bars[:, 1]
        G = np.array([g1 * a1, r1 * a1 + g2 * a2, g3 * a3, g4 * a3, r4 * a3])
        f = weights - bars[:, 1] * G
        f[2] += loads[0, 0] + 1j * loads[0, 1]
        f[3] += loads[1, 0] + 1j * loads[1, 1]
        I = bars[:, 2]
        rows = [f[0] + O + A, cross(g1 * e1, f[0]) + cross(r1 * e1, A) + torque - I[0] * al[0]]
        rows += [f[1] - A + B, cross(g2 * e2, f[1]) + cross(r2 * e2, B) - I[1] * al[1]]
        rows += [f[2] - B + C + D, cross(g3 * e3, f[2]) + cross(e3, r4 * D - r3 * B) - I[2] * al[2]]
        rows += [f[3] - E + F, cross(g4 * e3, f[3]) - cross(r4 * e3, E) - I[3] * al[2]]
        rows += [f[4] - D + E, cross(g5 + 0j, f[4]) + cross(r5 + 0j, E)]
        closure = -r1 * a1 - r2 * a2 + r3 * a3
        flat = [part for xy, moment in zip(rows[::2], rows[1::2], strict=True) for part in (xy.real, xy.imag, moment)]
        return np.array([*flat, closure.real, -closure.imag])

    known = zero(np.zeros(17))
    return [(zero(unit) - known).tolist() for unit in np.eye(17)], known


def transposed_back(*args):
    columns, known = by_sums_of_functions(*args)
    return np.array(columns).T, -known


def by_sympy(position, velocity, torque, loads, lengths, bars):
    """The positions of all centres, differentiated by SymPy; moments about the joints by cross products."""
    t = mechanics.dynamicsymbols._t
    angles = mechanics.dynamicsymbols("q1:4")
    rates, second = [q.diff(t) for q in angles], sp.symbols("al1:4")
    r0, r1, r2, r3, r4, r5, _ = map(float, lengths)
    g, m, inertia = bars.T.tolist()

    def at(origin, length, q):
        return origin + sp.Matrix([length * sp.cos(q), length * sp.sin(q)])

    O, C, F = sp.Matrix([0, 0]), sp.Matrix([r0, 0]), sp.Matrix([r0 + r5, 0])
    A, B, D, E = at(O, r1, angles[0]), at(C, r3, angles[2]), at(C, r4, angles[2]), at(F, r4, angles[2])
    centres = [at(O, g[0], angles[0]), at(A, g[1], angles[1]), at(C, g[2], angles[2]), at(F, g[3], angles[2])]
    centres.append(D + sp.Matrix([g[4], 0]))
    forces = sp.symbols("Ox Oy Ax Ay Bx By Cx Cy Dx Dy Ex Ey Fx Fy")
    force = {name: sp.Matrix(forces[2 * k : 2 * k + 2]) for k, name in enumerate("OABCDEF")}
    place = dict(zip("OABCDEF", (O, A, B, C, D, E, F), strict=True))
    acting = [{"O": 1, "A": 1}, {"A": -1, "B": 1}, {"B": -1, "C": 1, "D": 1}, {"E": -1, "F": 1}, {"D": -1, "E": 1}]
    turning = [second[0], second[1], second[2], second[2], 0]
    number = dict(zip(angles, position, strict=True)) | dict(zip(rates, velocity, strict=True))

    def moment(arm, f):
        return arm[0] * f[1] - arm[1] * f[0]

    def evaluated(expression):
        accelerated = expression.subs({q.diff(t, 2): al for q, al in zip(angles, second, strict=True)})
        return accelerated.subs({rate: number[rate] for rate in rates}).subs({q: number[q] for q in angles})

    rows = []
    for k, (about, known) in enumerate(zip("OACFD", (0, 0, *loads.tolist(), 0), strict=True)):
        inertial = -m[k] * centres[k].diff(t, 2) + sp.Matrix([0, -9.81 * m[k]])
        inertial += sp.Matrix(known) if known else sp.zeros(2, 1)
        total = inertial + sum((sign * force[j] for j, sign in acting[k].items()), sp.zeros(2, 1))
        turns = moment(centres[k] - place[about], inertial) - inertia[k] * turning[k]
        turns += sum(moment(place[j] - place[about], sign * force[j]) for j, sign in acting[k].items())
        rows += [total[0], total[1], turns + (torque if k == 0 else 0)]
    rows += list((C + at(O, r3, angles[2]) - A - at(O, r2, angles[1])).diff(t, 2))
    rows[-1] = -rows[-1]
    column = sp.Matrix([evaluated(row) for row in rows])
    matrix, right = sp.linear_eq_to_matrix(list(column), [*second, *forces])
    return np.array(matrix, dtype=float), np.array(right, dtype=float).ravel()


def by_mechlib(position, velocity, torque, loads, lengths, bars):
    parts = (position[None], velocity[None], np.array([torque]), loads[None])
    matrix, right = direct._system(machine(lengths, bars), *parts)
    return matrix[0], right[0, :, 0]


@pytest.mark.parametrize("route", [transposed_back, by_mechlib], ids=lambda f: f.__name__)
def test_the_equations_are_right_however_they_are_written(route):
    for student in DRAWS:
        assessment = judged("direct_system", route, student)
        assert assessment.points == 4, assessment.diagnosis


def test_the_equations_may_be_derived_by_sympy():
    assessment = judged("direct_system", by_sympy, DRAWS[0])
    assert assessment.points == 4, assessment.diagnosis


def test_a_matrix_of_columns_is_named_a_transposed_one():
    def columns(*args):
        found, known = by_sums_of_functions(*args)
        return found, -known

    for student in DRAWS:
        assert judged("direct_system", columns, student).mistake.startswith("The matrix is transposed. ")


def test_what_is_right_counts_beside_a_wrong_right_side():
    def without_gyrations(*args):
        matrix, right = e10.RIGHT(*args)
        return matrix, np.where(np.arange(17) < 15, 0, right)

    for student in DRAWS:
        assessment = judged("direct_system", without_gyrations, student)
        assert (assessment.points, len(faults(assessment))) == (2.75, 1)


# --- the motion


def positions(theta1, lengths):
    r0, r1, r2, r3 = lengths[:4]

    def residual(q):
        return np.array(
            [
                r0 - r1 * np.cos(theta1) - r2 * np.cos(q[0]) + r3 * np.cos(q[1]),
                r1 * np.sin(theta1) + r2 * np.sin(q[0]) - r3 * np.sin(q[1]),
            ]
        )

    def jacobian(q):
        return np.array([[r2 * np.sin(q[0]), -r3 * np.sin(q[1])], [r2 * np.cos(q[0]), -r3 * np.cos(q[1])]])

    return residual, jacobian


def looked_at(start, t):
    if not np.isfinite(start).all() or not np.isfinite(t).all():
        raise ValueError(f"not finite: {start}, {t[~np.isfinite(t)]}")
    steps = np.diff(t)
    if not (steps > 0).all():
        raise ValueError(f"t must increase: {t[np.argmin(steps)]}, {t[np.argmin(steps) + 1]}")


def slope_by_newton(acceleration, torque, start, lengths):
    """Closed by Newton-Raphson from the position before."""
    x, y = lengths[0] - lengths[1] * np.cos(start[0]), -lengths[1] * np.sin(start[0])
    last = np.array([np.arctan2(y, x) + 0.7, np.arctan2(y, x) + np.pi - 0.9])

    def slope(time, state):
        nonlocal last
        theta1, omega1 = state
        try:
            last = newton(*positions(theta1, lengths), last, 1e-10).root
        except ArithmeticError:
            raise ArithmeticError(f"no position at theta1 = {theta1:.5f}") from None
        return np.array([omega1, acceleration(np.array([theta1, *last]), omega1, torque(time, theta1, omega1))])

    return slope


def by_adaptive_steps(method, **how):
    def motion(acceleration, torque, start, t, lengths):
        looked_at(start, t)
        slope = slope_by_newton(acceleration, torque, start, lengths)
        found = solve_ivp(slope, (t[0], t[-1]), start, method, t_eval=t, **how)
        if not found.success:
            raise ArithmeticError(f"it stops at theta1 = {found.y[0, -1]}")
        return found.y.T

    return motion


def by_odeint(acceleration, torque, start, t, lengths):
    looked_at(start, t)
    slope = slope_by_newton(acceleration, torque, start, lengths)
    return odeint(slope, start, t, tfirst=True, rtol=1e-9, atol=1e-9)


def by_fixed_steps(step, parts=1):
    def motion(acceleration, torque, start, t, lengths):
        looked_at(start, t)
        slope = slope_by_newton(acceleration, torque, start, lengths)
        states = [np.array(start)]
        for k in range(len(t) - 1):
            y, h = states[-1], (t[k + 1] - t[k]) / parts
            for n in range(parts):
                y = step(slope, t[k] + n * h, h, y)
            states.append(y)
        return [state.tolist() for state in states]

    return motion


def runge_kutta(f, t, h, y):
    a = f(t, y)
    b = f(t + h / 2, y + h / 2 * a)
    c = f(t + h / 2, y + h / 2 * b)
    return y + h / 6 * (a + 2 * b + 2 * c + f(t + h, y + h * c))


def three_eighths(f, t, h, y):
    """Kutta's other rule of fourth order."""
    a = f(t, y)
    b = f(t + h / 3, y + h / 3 * a)
    c = f(t + 2 * h / 3, y + h * (b - a / 3))
    return y + h / 8 * (a + 3 * b + 3 * c + f(t + h, y + h * (a - b + c)))


def halved_midpoints(f, t, h, y):
    """Gragg's, extrapolated: 2 and 4 midpoints, and what their difference tells."""

    def midpoints(n):
        before, now, s = y, y + h / n * f(t, y), h / n
        for k in range(1, n):
            before, now = now, before + 2 * s * f(t + k * s, now)
        return (before + now + s * f(t + h, now)) / 2

    return (4 * midpoints(4) - midpoints(2)) / 3


def euler(f, t, h, y):
    return y + h * f(t, y)


MOTIONS = {
    "RK45": by_adaptive_steps("RK45", rtol=1e-8, atol=1e-10),
    "LSODA": by_adaptive_steps("LSODA", rtol=1e-9, atol=1e-10),
    "odeint": by_odeint,
    "runge_kutta": by_fixed_steps(runge_kutta),
    "runge_kutta, finer": by_fixed_steps(runge_kutta, 3),
    "three_eighths": by_fixed_steps(three_eighths),
    "halved_midpoints": by_fixed_steps(halved_midpoints, 2),
}


@pytest.mark.parametrize("route", MOTIONS)
def test_the_motion_may_be_found_by_any_integrator_that_is_good_enough(route):
    for student in DRAWS[:4]:
        assessment = judged("driven_motion", MOTIONS[route], student)
        assert assessment.points == 3, (route, faults(assessment))


def test_eulers_method_with_shorter_steps_loses_the_accuracy_and_what_it_costs():
    for parts, lost in ((20, 1.25), (60, 1.5)):
        for student in DRAWS[:2]:
            assessment = judged("driven_motion", by_fixed_steps(euler, parts), student)
            assert 3 - assessment.points >= lost, (parts, faults(assessment))


def test_an_integrator_that_gives_up_without_a_word_loses_the_points_for_the_dead_point():
    def silent(acceleration, torque, start, t, lengths):
        looked_at(start, t)

        def slope(time, y):
            r0, r1, r2, r3 = lengths[:4]
            x, up = r0 - r1 * np.cos(y[0]), -r1 * np.sin(y[0])
            d = np.hypot(x, up)
            th3 = np.arctan2(up, x) + np.pi - np.arccos((d**2 + r3**2 - r2**2) / (2 * d * r3))
            th2 = np.arctan2(up + r3 * np.sin(th3), x + r3 * np.cos(th3))
            return y[1], acceleration(np.array([y[0], th2, th3]), y[1], torque(time, *y))

        return solve_ivp(slope, (t[0], t[-1]), start, "DOP853", t, rtol=1e-9, atol=1e-9).y.T

    for student in DRAWS[:4]:
        assessment = judged("driven_motion", silent, student)
        assert (assessment.points, len(faults(assessment))) == (2.75, 1)


# --- energy


def by_loops(t, position, velocity, torque, loads, lengths, bars):
    """A point and a body at a time, in plain floats; the speeds from the moments of inertia about the joints."""
    if not len(t) == len(position) == len(velocity) == len(torque) == len(loads):
        raise ValueError("not the same points")
    drift, work, before = [], 0.0, None
    for k in range(len(t)):
        (q1, q2, q3), (w1, w2, w3) = position[k].tolist(), velocity[k].tolist()
        (g1, m1, i1), (g2, m2, i2), (g3, m3, i3), (g4, m4, i4), (_, m5, _) = bars.tolist()
        about_c = i3 + m3 * g3**2 + i4 + m4 * g4**2 + m5 * lengths[4] ** 2
        swing = (lengths[1] * w1) ** 2 + (g2 * w2) ** 2 + 2 * lengths[1] * g2 * w1 * w2 * np.cos(q1 - q2)
        energy = ((i1 + m1 * g1**2) * w1**2 + m2 * swing + i2 * w2**2 + about_c * w3**2) / 2
        first = (m1 * g1 + m2 * lengths[1]) * np.sin(q1) + m2 * g2 * np.sin(q2)
        energy += 9.81 * (first + (m3 * g3 + m4 * g4 + m5 * lengths[4]) * np.sin(q3))
        across = np.array([-np.sin(q3), np.cos(q3)])
        power = torque[k] * w1 + w3 * across @ (g3 * loads[k, 0] + g4 * loads[k, 1])
        if before:
            work += (t[k] - before[0]) * (power + before[1]) / 2
        else:
            start = energy
        before = (t[k], power)
        drift.append(energy - start - work)
    return drift


def by_mechlibs_energies(t, position, velocity, torque, loads, lengths, bars):
    if len({len(each) for each in (t, position, velocity, torque, loads)}) != 1:
        raise ValueError("not the same points")
    wiper = machine(lengths, bars)
    energy = direct._energy(Wiper)(*position.T, *velocity.T, *wiper.constants)[..., 0, 0]
    power = torque * velocity[:, 0] + (direct.load_velocities(wiper, position, velocity) * loads).sum(axis=(1, 2))
    return energy - energy[0] - np.array([np.trapezoid(power[: k + 1], t[: k + 1]) for k in range(len(t))])


@pytest.mark.parametrize("route", [by_loops, by_mechlibs_energies], ids=lambda f: f.__name__)
def test_the_energy_is_right_however_it_is_summed_up(route):
    for student in DRAWS:
        assessment = judged("energy_drift", route, student)
        assert assessment.points == 2, assessment.diagnosis


# --- friction


def by_polar_coordinates(velocity, size, v0):
    if not (v0 > 0 and size >= 0):
        raise ValueError(f"v0 = {v0}, size = {size}")
    speed, direction = np.hypot(*np.moveaxis(velocity, -1, 0)), np.arctan2(velocity[..., 1], velocity[..., 0])
    force = -size * np.tanh(speed / v0)
    return np.stack((force * np.cos(direction), force * np.sin(direction)), axis=-1)


def by_a_limit(velocity, size, v0):
    """tanh(x)/x, with its series near zero, times v/v0: nothing is divided by a speed."""
    if v0 <= 0:
        raise ValueError(f"v0 is {v0}")
    if size < 0:
        raise ValueError(f"size is {size}")
    x = np.sqrt((velocity**2).sum(-1)) / v0
    small = x < 1e-3
    factor = np.where(small, 1 - x**2 / 3 + 2 * x**4 / 15, np.tanh(x) / np.where(small, 1, x))
    return (-size / v0 * factor[..., None] * velocity).tolist()


def by_lists(velocity, size, v0):
    """One point after the other, and exponentials."""
    if not v0 > 0 or not size >= 0:
        raise ValueError(f"{v0} and {size}")
    if np.ndim(velocity) > 1:
        return [by_lists(each, size, v0) for each in velocity]
    x, y = map(float, velocity)
    speed = (x * x + y * y) ** 0.5
    if speed == 0:
        return [0.0, 0.0]
    fading = -np.expm1(-2 * speed / v0) / (1 + np.exp(-2 * speed / v0))
    return [-size * x / speed * fading, -size * y / speed * fading]


@pytest.mark.parametrize("route", [by_polar_coordinates, by_a_limit, by_lists], ids=lambda f: f.__name__)
def test_the_friction_is_right_however_it_is_written(route):
    for student in DRAWS:
        assessment = judged("smooth_friction", route, student)
        assert assessment.points == 2, assessment.diagnosis


def test_an_offset_in_the_denominator_is_no_cure():
    for student in DRAWS:
        offset = judged(
            "smooth_friction", lambda v, size, v0: -size * v / (np.linalg.norm(v, axis=-1) + v0)[..., None], student
        )
        assert offset.points < 2
