"""Exercise 11: other right ways get full points, and ways that only look right do not."""

import math
from itertools import islice, product

import numpy as np
import pytest
from judging import judged
from linkages import cylinders
from scipy.optimize import fsolve

from autograder.checks import task
from autograder.checks.e11_cylinder import BODIES, POWER, RATIOS, TERMS, TRIANGLE, Swung, thin_bars
from mechlib.cylinder import Cylinder, lagrange, newton_euler, virtual_power
from mechlib.motion import Motion
from mechlib.rigidbody import MassProperties
from mechlib.sweep import Sweep

DRAWS = [f"route {n}" for n in range(12)]
G = 9.80665


def faults(assessment):
    return [finding.fault for finding in assessment.findings if finding.fault]


# --- angles


def refuse(a, lengths):
    for length in lengths:
        if not length > 0:
            raise ValueError(f"no bar has {length:.4g} m")
    o2, o4, b, l = lengths
    for stroke in a:
        if not abs(math.hypot(o2, o4) - b) <= stroke + l <= math.hypot(o2, o4) + b:
            raise ValueError(f"{stroke:.6g} m cannot be closed")


def by_circles(a, lengths):
    """Where the circle of the cylinder about O2 meets that of the rocker about O4."""
    refuse(a, lengths)
    o2, o4, b, l = lengths
    o, s = complex(o2, -o4), np.asarray(a) + l
    d = abs(o)
    x = (s**2 - b**2 + d**2) / (2 * d)
    A = o + (x - 1j * np.sqrt(s**2 - x**2)) * (-o / d)
    return np.transpose([np.angle(A - o), np.angle(A)])


def by_half_angles(a, lengths):
    """In lists, and with some turns too many."""
    refuse(a, lengths)
    o2, o4, b, l = map(float, lengths)
    d, found = math.hypot(o2, o4), []
    for stroke in a:
        s = stroke + l
        p = (d + b + s) / 2
        phi = 2 * math.atan2(math.sqrt((p - d) * (p - b)), math.sqrt(p * (p - s)))
        psi = 2 * math.atan2(math.sqrt((p - d) * (p - s)), math.sqrt(p * (p - b)))
        beta = math.atan2(o4, o2)
        found.append((5 * math.pi - beta - psi, phi - beta - 2 * math.pi))
    return found


def by_iteration(a, lengths):
    """From the folded triangle, turned a little to the right."""
    refuse(a, lengths)
    o2, o4, b, l = lengths
    along = math.atan2(o4, -o2)

    def gap(theta, s):
        return (
            o2 + s * math.cos(theta[0]) - b * math.cos(theta[1]),
            -o4 + s * math.sin(theta[0]) - b * math.sin(theta[1]),
        )

    return np.array([fsolve(gap, (along - 0.3, along - 2), args=(x + l,), xtol=1e-13) for x in a])


# --- ratios


def refuse_flat(a, angles):
    for stroke, (th2, th4) in zip(a, angles, strict=True):
        if abs(math.sin(th2 - th4)) < 1e-6:
            raise ValueError(f"flat at {stroke:.5g}")


def by_linear_systems(a, angles, lengths):
    refuse_flat(a, angles)
    b, s = lengths[2], a + lengths[3]
    (c2, c4), (s2, s4) = np.cos(angles.T), np.sin(angles.T)
    matrix = np.moveaxis([[-s * s2, b * s4], [s * c2, -b * c4]], -1, 0)

    def solve(x, y):
        return np.linalg.solve(matrix, np.stack((x, y), axis=1)[..., None])[..., 0]

    k2, k4 = (k := solve(-c2, -s2)).T
    h = solve(
        2 * s2 * k2 + s * c2 * k2**2 - b * c4 * k4**2,
        -2 * c2 * k2 + s * s2 * k2**2 - b * s4 * k4**2,
    )
    return [k, h]


def by_the_law_of_cosines(a, angles, lengths):
    """Its angles, differentiated twice; the given ones serve to refuse alone."""
    refuse_flat(a, angles)
    o2, o4, b, l = lengths
    s, dd = a + l, o2**2 + o4**2
    area = np.sqrt(4 * dd * b**2 - (dd + b**2 - s**2) ** 2)  # four times that of the triangle
    slope = 2 * s * (dd + b**2 - s**2) / area
    k4, h4 = 2 * s / area, 2 / area - 2 * s * slope / area**2
    top = s**2 + b**2 - dd
    k2 = top / (s * area)
    h2 = 2 / area - top * (area + s * slope) / (s * area) ** 2
    return np.stack((np.column_stack((k2, k4)), np.column_stack((h2, h4))))


def by_mechlib(a, angles, lengths):
    refuse_flat(a, angles)
    return np.array(given(lengths).ratios(a + lengths[3], angles))


def given(lengths, bodies=None):
    """A cylinder of mechlib with these lengths, and room for any stroke."""
    o2, o4, b, l = lengths
    room = {"li": 1e-3, "ls": math.hypot(o2, o4) + b, "e": 1e-4}
    if bodies is None:
        return Cylinder(o2, o4, b, l, **room)
    moments = thin_bars(lengths, bodies)
    masses = (MassProperties(m, moment, centre) for (centre, m), moment in zip(bodies, moments, strict=True))
    return Cylinder(o2, o4, b, l, **room, masses=tuple(masses))


def moved(stroke, angles, lengths, bodies):
    """A cylinder of mechlib and its sweep over these points."""
    cylinder = given(lengths, bodies)
    (a, v, acc), points = stroke, stroke.shape[1]
    motion = Motion(np.arange(points) * 1.0, a + lengths[3], v, acc)
    rates = cylinder.loop.rates(angles, motion.position, v, acc)
    return cylinder, Sweep(motion, angles, *rates, np.zeros(points, int), np.zeros(points))


# --- forces


def refuse_masses(bodies):
    for m in bodies[:, 1]:
        if m <= 0:
            raise ValueError(f"m = {m}")


def power_by_mechlib(stroke, angles, ratios, lengths, bodies):
    refuse_masses(bodies)
    return virtual_power(*moved(stroke, angles, lengths, bodies))


def by_the_forces_of_the_joints(stroke, angles, ratios, lengths, bodies):
    """Newton and Euler: nine equations, and no virtual velocity."""
    refuse_masses(bodies)
    return list(newton_euler(*moved(stroke, angles, lengths, bodies))[0])


def by_reduced_inertia(stroke, angles, ratios, lengths, bodies):
    """M acc + M' v^2 / 2 + V', point by point."""
    refuse_masses(bodies)
    (g2, m2), (g3, m3), (g4, m4) = bodies
    found = []
    for (a, v, acc), (th2, th4), (k2, k4), (h2, h4) in zip(stroke.T, angles, *ratios, strict=True):
        r, about4 = a + g3, m4 * g4**2 * 4 / 3
        about2 = m2 * g2**2 * 4 / 3 + m3 * (lengths[3] ** 2 / 12 + r**2)
        M = about2 * k2**2 + about4 * k4**2 + m3
        half = about2 * k2 * h2 + m3 * r * k2**2 + about4 * k4 * h4
        lift = (m2 * g2 + m3 * r) * math.cos(th2) * k2 + m3 * math.sin(th2) + m4 * g4 * math.cos(th4) * k4
        found.append(M * acc + half * v**2 + G * lift)
    return found


# --- terms


def refuse_nan(stroke, angles):
    for a, pair in zip(stroke[0], angles, strict=True):
        if pair[0] != pair[0]:
            raise ValueError(f"{a:.5g} m is open")


def terms_by_three_motions(stroke, angles, ratios, lengths, bodies):
    """At rest, with the acceleration alone, and as it moves: each gives one of the terms."""
    refuse_nan(stroke, angles)

    def force(v, acc):
        return lagrange(*moved(np.array([stroke[0], v, acc]), angles, lengths, bodies))

    still = 0 * stroke[0]
    by_weight = force(still, still)
    by_acceleration = force(still, stroke[2]) - by_weight
    rest = force(stroke[1], stroke[2]) - by_acceleration - by_weight
    return by_acceleration + 2 * rest, rest, by_weight


def terms_by_complex_numbers(stroke, angles, ratios, lengths, bodies):
    refuse_nan(stroke, angles)
    (a, v, acc), (k, h), (g, m) = stroke, ratios.swapaxes(1, 2), bodies.T
    e2, e4 = np.exp(1j * angles.T)
    (k2, k4), (h2, h4) = k, h
    r = a + g[1]
    u = np.array([1j * k2 * g[0] * e2, (1 + 1j * k2 * r) * e2, 1j * k4 * g[2] * e4])
    du = [(1j * h2 - k2**2) * g[0] * e2, (2j * k2 + (1j * h2 - k2**2) * r) * e2, (1j * h4 - k4**2) * g[2] * e4]
    turning, change = (np.array([x[0], x[0], x[1]]) for x in (k, h))
    moments = m * np.array([2 * g[0], lengths[3], 2 * g[2]]) ** 2 / 12
    M = m @ abs(u) ** 2 + moments @ turning**2
    half = m @ (u.conj() * du).real + moments @ (turning * change)
    return np.array([M * acc + 2 * half * v**2, half * v**2, G * m @ u.imag])


def terms_by_momentum(stroke, angles, ratios, lengths, bodies):
    """d/dt of the momentum of each body, by the product rule with angular velocities and accelerations."""
    refuse_nan(stroke, angles)
    rows = []
    for (a, v, acc), (th2, th4), (k2, k4), (h2, h4) in zip(stroke.T, angles, *ratios, strict=True):
        w2, w4, r = k2 * v, k4 * v, a + bodies[1, 0]
        eps2, eps4 = k2 * acc + h2 * v**2, k4 * acc + h4 * v**2
        (g2, _, g4), (m2, m3, m4) = bodies.T
        I2, I4 = m2 * (g2**2 + g2**2 / 3) + m3 * (lengths[3] ** 2 / 12 + r**2), m4 * (g4**2 + g4**2 / 3)
        spin = I2 * eps2 + 2 * m3 * r * v * w2  # d/dt of the angular momenta
        first = spin * k2 + I2 * w2 * h2 * v + I4 * (eps4 * k4 + w4 * h4 * v) + m3 * acc
        second = I2 * w2 * h2 * v + m3 * r * w2**2 + I4 * w4 * h4 * v
        third = m2 * G * g2 * math.cos(th2) * k2 + m4 * G * g4 * math.cos(th4) * k4
        rows.append((first, second, third + m3 * G * (math.sin(th2) + r * math.cos(th2) * k2)))
    return np.array(rows).T


# --- the wrong term


def named(off, bound):
    worst = max(off, key=off.get)
    return worst if off[worst] > bound else None


def by_fourier(t, stroke, kinetic, potential, terms):
    _, v, acc = stroke
    n = len(t)

    def rate(x):
        return np.fft.irfft(2j * np.pi * np.fft.rfftfreq(n, t[1] - t[0]) * np.fft.rfft(x), n)

    off = {}
    for k, body in enumerate(BODIES):
        T = kinetic[k]
        fits = 2 * rate(T) * v - 2 * T * acc, rate(T) * v - 2 * T * acc, rate(potential[k]) * v
        for name, fit, term in zip(TERMS, fits, terms[:, k], strict=True):
            off[name, body] = abs(fit - term * v**2).max() / abs(fit).max()
    return named(off, 0.05)


def by_polynomials(t, stroke, kinetic, potential, terms):
    """M and V as polynomials of the stroke, fitted where the cylinder is fast; their derivatives are exact."""
    a, v, acc = stroke
    fast, off = abs(v) > 0.1 * abs(v).max(), {}
    for k, body in enumerate(BODIES):
        M = np.polynomial.Chebyshev.fit(a[fast], 2 * kinetic[k][fast] / v[fast] ** 2, 12)
        slope, lift = M.deriv()(a), np.polynomial.Chebyshev.fit(a, potential[k], 12).deriv()(a)
        for name, fit, term in zip(
            TERMS, (M(a) * acc + slope * v**2, slope * v**2 / 2, lift), terms[:, k], strict=True
        ):
            off[name, body] = abs(fit - term)[fast].max() / abs(term).max()
    return named(off, 0.1)


def by_quotients(t, stroke, kinetic, potential, terms):
    """Differences of the momentum, away from where the cylinder turns round, with a loop around all."""
    _, v, acc = stroke
    fast, off = np.flatnonzero(abs(v) > 0.25 * abs(v).max()), {}
    fast = fast[(fast > 0) & (fast < len(t) - 1)]
    for k, body in enumerate(BODIES):
        dT, dV = (np.gradient(x[k], t)[fast] / v[fast] for x in (kinetic, potential))
        momentum = 2 * dT - 2 * kinetic[k][fast] * acc[fast] / v[fast] ** 2
        for name, fit, term in zip(TERMS, (momentum, momentum - dT, dV), terms[:, k], strict=True):
            off[name, body] = abs(fit - term[fast]).max() / abs(term).max()
    return named(off, 0.1)


RIGHT = {
    "cylinder_angles": (by_circles, by_half_angles, by_iteration),
    "cylinder_ratios": (by_linear_systems, by_the_law_of_cosines, by_mechlib),
    "virtual_power": (power_by_mechlib, by_the_forces_of_the_joints, by_reduced_inertia),
    "lagrange_terms": (terms_by_three_motions, terms_by_complex_numbers, terms_by_momentum),
    "wrong_term": (by_fourier, by_polynomials, by_quotients),
}


@pytest.mark.parametrize(
    ("name", "route"), [(n, r) for n, routes in RIGHT.items() for r in routes], ids=lambda x: getattr(x, "__name__", x)
)
def test_another_right_way_gets_full_points(name, route):
    for student in DRAWS:
        assessment = judged(name, route, student)
        said = assessment.verdict, assessment.points, assessment.diagnosis
        assert said == ("right", task(name).points, ""), student


# --- what is handed out is what mechlib says


def test_angles_ratios_and_force_of_random_cylinders_are_those_of_mechlib():
    for cylinder, motion in islice(cylinders(np.random.default_rng(11)), 20):
        a, lengths = motion.position - cylinder.l, np.array([cylinder.o2, cylinder.o4, cylinder.b, cylinder.l])
        sweep = cylinder.sweep(motion)
        np.testing.assert_allclose(TRIANGLE(a, lengths), sweep.position, atol=1e-12)
        ratios = np.array(cylinder.ratios(motion.position, sweep.position))
        np.testing.assert_allclose(RATIOS(a, sweep.position, lengths), ratios, rtol=1e-9, atol=1e-9)

        bodies = np.array([[body.centre, body.mass] for body in cylinder.masses])
        stroke = np.array([a, motion.velocity, motion.acceleration])
        right = virtual_power(*moved(stroke, sweep.position, lengths, bodies))
        for found in (
            POWER(stroke, sweep.position, ratios, lengths, bodies),
            [1, -1, 1] @ task("lagrange_terms").reference(stroke, sweep.position, ratios, lengths, bodies),
        ):
            np.testing.assert_allclose(found, right, atol=1e-11 * np.abs(right).max())


def test_every_drawn_cylinder_stays_away_from_a_flat_triangle():
    rng = np.random.default_rng(0)
    for _ in range(50):
        w = Swung.drawn(rng, 6, short_rod=rng.random() < 0.5)
        D = w.angles @ [1, -1]
        assert (np.rad2deg(D) > 34.9).all()
        assert (np.rad2deg(D) < 125.1).all()
        assert (w.stroke[0] > 0).all()
        assert w.lengths[3] > 0.01


# --- ways that only look right


def test_a_force_that_is_zero_by_zero_at_a_turning_point_costs_what_is_looked_at_there():
    def divided(stroke, *rest):
        return POWER(stroke, *rest) * stroke[1] / stroke[1]

    for student in DRAWS:
        assessment = judged("virtual_power", divided, student)
        assert assessment.mistake.startswith("The power of the motion is divided by its velocity. ")
        assert assessment.points == 1.75


def test_a_force_without_its_terms_is_no_answer_of_lagrange():
    for student in DRAWS:
        assert judged("lagrange_terms", POWER, student).points == 1.5  # as its known mistake grants


def test_a_guess_finds_no_wrong_term():
    for student in DRAWS:
        for answer in (None, *product(TERMS, BODIES)):
            assert judged("wrong_term", lambda *args, answer=answer: answer, student).points == 0


def test_the_work_over_a_period_finds_no_wrong_weight():
    """A force of the stroke alone does no work there: the argument that looks right and is not."""

    def by_work(t, stroke, kinetic, potential, terms):
        found = by_fourier(t, stroke, kinetic, potential, terms)
        if found and found[0] != TERMS[2]:
            return found
        power = terms[2] * stroke[1]
        work = np.abs(power.mean(axis=1)) / np.abs(power).max(axis=1)
        return (TERMS[2], BODIES[int(work.argmax())]) if work.max() > 1e-6 else None

    for student in DRAWS:
        assessment = judged("wrong_term", by_work, student)
        assert assessment.mistake.startswith("A wrong weight is not seen. ")
        assert assessment.points == 1.5
