"""Exercise 9: other right ways get full points, and ways that only look right do not."""

import math
from functools import cache

import numpy as np
import pytest
import scipy.linalg
from judging import judged, paper

from autograder.checks import task
from autograder.checks.e09_wiper_inverse_dynamics import Moving
from mechlib import dynamics
from mechlib.closure import compiled
from mechlib.motion import Motion
from mechlib.sweep import Sweep
from mechlib.wiper import BODIES, MassProperties, Wiper

DRAWS = [f"route {n}" for n in range(15)]
G = 9.81
TURNS = (0, 1, 2, 2, None)
JOINTS_OF = ({"O": 1, "A": 1}, {"A": -1, "B": 1}, {"B": -1, "C": 1, "D": 1}, {"E": -1, "F": 1}, {"D": -1, "E": 1})


def faults(assessment):
    return [finding.fault for finding in assessment.findings if finding.fault]


# --- Steiner


def by_gyration(inertia, mass, given, wanted):
    """Radii of gyration, in a list."""
    found = []
    for I, m, a, b in zip(inertia, mass, given, wanted, strict=True):
        squared = I / m - a * a
        if squared <= 0:
            raise ValueError(f"I = {I:.4g} is too small")
        found.append(m * (squared + b * b))
    return found


def by_two_particles(inertia, mass, given, wanted):
    """Two halves of the mass on both sides of the centre of mass, on a line across that to the axis."""
    with np.errstate(invalid="ignore"):
        half = np.sqrt((inertia - mass * given**2) / mass)
    for k, length in enumerate(half):
        if not length > 0:
            raise ValueError(f"bar {k}: {inertia[k] - mass[k] * given[k] ** 2:.4g} kg m^2 about its centre")
    return mass / 2 * (np.abs(wanted + 1j * half) ** 2 + np.abs(wanted - 1j * half) ** 2)


def by_matrices(inertia, mass, given, wanted):
    table = np.array([inertia, mass * given * given, mass * wanted * wanted])
    least = np.array([1, -1, 0]) @ table
    if min(least) <= 0:
        raise ValueError(str(min(least)))
    return np.array([1, -1, 1]) @ table


# --- accelerations


def known(motion):
    for k in range(motion.shape[1]):
        if np.isnan(motion[:, k]).any():
            raise ValueError(f"point {k} of the sweep is nan")


def by_mechlib(motion, lengths, bars):
    known(motion)
    wiper, sweep = given(motion, lengths, bars)
    return np.stack([dynamics.trace(wiper, sweep, f"G{k}").acceleration for k in range(1, 6)], axis=1)


def given(motion, lengths, bars):
    """A wiper of mechlib that moves so."""
    masses = tuple(MassProperties(m, inertia, centre) for centre, m, inertia in bars)
    first, others = motion[:, :, 0], motion[:, :, 1:]
    points = motion.shape[1]
    return Wiper(*lengths, masses), Sweep(
        Motion(np.arange(points) * 1.0, *first), *others, np.zeros(points, int), np.zeros(points)
    )


def where(theta, lengths, centres):
    """O to F, and G1 to G5, in lists of complex numbers."""
    r0, r1, _, r3, r4, r5, _ = map(float, lengths)
    crank, coupler, rocker = (complex(math.cos(angle), math.sin(angle)) for angle in theta)
    a, d, f = r1 * crank, r0 + r4 * rocker, r0 + r5
    g1, g2, g3, g4, g5 = centres
    joints = [0j, a, r0 + r3 * rocker, r0 + 0j, d, d + r5, f + 0j]
    return [*joints, g1 * crank, a + g2 * coupler, r0 + g3 * rocker, f + g4 * rocker, d + g5]


def by_points(motion, lengths, bars):
    """A point at a time, from differences of the places; lists."""
    known(motion)
    h, rows = 2e-3, []
    for theta, omega, alpha in zip(*motion, strict=True):
        step = [theta + omega * t * h + alpha * (t * h) ** 2 / 2 for t in range(-3, 4)]
        z = np.array([where(angles, lengths, bars[:, 0])[7:] for angles in step])
        a = (2 * (z[0] + z[6]) - 27 * (z[1] + z[5]) + 270 * (z[2] + z[4]) - 490 * z[3]) / (180 * h**2)
        rows.append([[each.real, each.imag] for each in a])
    return rows


def by_turning_matrices(motion, lengths, bars):
    known(motion)
    a = np.empty((motion.shape[1], 5, 2))
    for k, (theta, omega, alpha) in enumerate(motion.transpose(1, 0, 2)):
        turned = [np.array([[np.cos(x), -np.sin(x)], [np.sin(x), np.cos(x)]]) for x in theta]
        unit = [R @ [-(w**2), al] for R, w, al in zip(turned, omega, alpha, strict=True)]
        for body, angle in enumerate(TURNS[:4]):
            a[k, body] = bars[body, 0] * unit[angle] + (lengths[1] * unit[0] if body == 1 else 0)
        a[k, 4] = lengths[4] * unit[2]
    return a


# --- equations


@cache
def of_mechlib():
    arguments = dynamics.arguments(Wiper)
    system = Wiper.rigid.inverse
    return compiled(arguments, system.matrix), compiled(arguments, system.right)


def by_the_rows_of_mechlib(motion, accelerations, loads, lengths, bars):
    values = dynamics.values(*given(motion, lengths, bars), loads)
    matrix, right = (function(*values) for function in of_mechlib())
    return matrix, right[..., 0]


def by_trials(motion, accelerations, loads, lengths, bars):
    """The sums for unknowns that are all zero, and then with one of them at a time; nothing but places is used."""
    if np.shape(loads) != (motion.shape[1], 2, 2):
        raise ValueError("a load for each blade and point, please")
    matrices, rights = [], []
    for theta, alpha, a, load in zip(motion[0], motion[2], accelerations, loads, strict=True):
        at = where(theta, lengths, bars[:, 0])
        (zero,) = sums(at, alpha, a, load, bars, [np.zeros(15)])
        matrices.append(np.array([each - zero for each in sums(at, alpha, a, load, bars, np.eye(15))]).T.tolist())
        rights.append([-x for x in zero])
    return [matrices, rights]


def sums(at, alpha, a, load, bars, tried):
    for x in tried:
        force = {name: complex(x[1 + 2 * k], x[2 + 2 * k]) for k, name in enumerate("OABCDEF")}
        rows = []
        for k, joints in enumerate(JOINTS_OF):
            about = at["OABCDEF".index("OACFD"[k])]
            acting = [(at["OABCDEF".index(name)], side * force[name]) for name, side in joints.items()]
            own = -bars[k, 1] * complex(a[k][0], a[k][1] + G) + (complex(*load[k - 2]) if k in (2, 3) else 0)
            acting.append((at[7 + k], own))
            total = sum(f for _, f in acting)
            moment = sum(((place - about).conjugate() * f).imag for place, f in acting)
            moment += x[0] * (k == 0) - (bars[k, 2] * alpha[TURNS[k]] if k < 4 else 0)
            rows += [total.real, total.imag, moment]
        yield np.array(rows)


def by_the_moving_joints(motion, accelerations, loads, lengths, bars):
    """Moments of inertia about the joints, and m r x a of A and of D where they move; blocks put together."""
    n = motion.shape[1]
    if np.shape(loads) != (n, 2, 2):
        raise ValueError(f"{np.shape(loads)}")
    (theta, omega, alpha), (_, r1, r2, r3, r4, r5, _) = motion, lengths
    rG, m, central = bars.T
    s, c = np.sin(theta), np.cos(theta)
    arm = [np.stack((-s[:, k], c[:, k]), axis=-1) for k in range(3)]
    I = np.eye(2)
    force = np.zeros((n, 5, 2, 7, 2))
    moment = np.zeros((n, 5, 7, 2))
    for k, joints in enumerate(JOINTS_OF):
        for name, side in joints.items():
            force[:, k, :, "OABCDEF".index(name)] = side * I
    moment[:, 0, 1], moment[:, 1, 2] = r1 * arm[0], r2 * arm[1]
    moment[:, 2, 2], moment[:, 2, 4] = -r3 * arm[2], r4 * arm[2]
    moment[:, 3, 5], moment[:, 4, 5, 1] = -r4 * arm[2], r5
    rows = np.concatenate((force.reshape(n, 5, 2, 14), moment.reshape(n, 5, 1, 14)), axis=2)
    first = np.zeros((n, 15, 1))
    first[:, 2] = 1

    known = m[:, None] * (accelerations + np.array([0, G]))
    known[:, 2] -= loads[:, 0]
    known[:, 3] -= loads[:, 1]
    al = np.hstack((alpha, alpha[:, 2:], np.zeros((n, 1))))
    pinned = np.zeros((n, 5, 2))
    pinned[:, 1] = r1 * (alpha[:, :1] * arm[0] - omega[:, :1] ** 2 * np.stack((c[:, 0], s[:, 0]), axis=-1))
    pinned[:, 4] = accelerations[:, 4]
    on_body = m[:, None] * (pinned + np.array([0, G]))
    on_body[:, 2:4] -= loads
    across = np.stack((*arm, arm[2], np.broadcast_to([0.0, 1.0], (n, 2))), axis=1)
    turned = (central + m * rG**2) * al + rG * (across * on_body).sum(axis=-1)
    right = np.concatenate((known, turned[..., None]), axis=2).reshape(n, 15)
    return np.concatenate((first, rows.reshape(n, 15, 14)), axis=2), right


# --- torque and forces


def rubbing(velocities, size):
    angle = np.arctan2(velocities[..., 1], velocities[..., 0])
    moves = (velocities != 0).any(axis=-1)
    return -size * np.stack((moves * np.cos(angle), moves * np.sin(angle)), axis=-1)


def by_scipy(system, velocities, size):
    """LU point by point; what fails is caught."""
    matrix, right = system(rubbing(velocities, size))
    torque, forces = [], []
    for k, (A, b) in enumerate(zip(matrix, right, strict=True)):
        if np.linalg.matrix_rank(A) < 15:
            raise ValueError(f"index {k}: singular")
        x = scipy.linalg.solve(A, b).tolist()
        torque.append(x[0])
        forces.append([x[1 + 2 * j : 3 + 2 * j] for j in range(7)])
    return [torque, forces]


def by_qr(system, velocities, size):
    matrix, right = system(dynamics.friction(velocities, size))
    q, r = np.linalg.qr(matrix)
    pivots = np.abs(np.diagonal(r, axis1=1, axis2=2)).min(axis=1)
    if (pivots < 1e-13).any():
        raise ArithmeticValueError(f"singular first at {pivots.tolist().index(pivots[pivots < 1e-13][0])}")
    x = np.linalg.solve(r, q.swapaxes(1, 2) @ right[:, :, None])[:, :, 0]
    return x[:, 0], np.stack((x[:, 1::2], x[:, 2::2]), axis=-1)


class ArithmeticValueError(ArithmeticError, ValueError):
    pass


def by_least_squares(system, velocities, size):
    loads = np.array([[[-size * c / (math.hypot(*v) or 1) for c in v] for v in pair] for pair in velocities])
    found = []
    for k, (A, b) in enumerate(zip(*system(loads), strict=True)):
        x, _, rank, _ = np.linalg.lstsq(A, b, rcond=1e-12)
        if rank < 15:
            raise ValueError(f"the matrix at point {k} has the rank {rank}")
        found.append(x)
    M, *pairs = np.array(found).T
    return M, np.array(pairs).T.reshape(-1, 7, 2)


# --- witnesses


def of_as_many(motion, *arrays):
    if {len(each) for each in arrays} != {motion.shape[1]}:
        raise ValueError("not of the same points")


def power_by_dot_products(motion, velocities, accelerations, loads, bars, torque):
    """Dot products of all that acts, in one sum."""
    of_as_many(motion, velocities, accelerations, loads, torque)
    force = bars[:, 1, None] * (accelerations + np.array([0.0, G]))
    force[:, 2:4] -= loads
    spin = bars[:, 2] * np.hstack((motion[2], motion[2][:, 2:], np.zeros((len(torque), 1))))
    turning = np.hstack((motion[1], motion[1][:, 2:], np.zeros((len(torque), 1))))
    return torque * motion[1][:, 0] - np.einsum("kij,kij->k", force, velocities) - np.einsum("ki,ki->k", spin, turning)


def power_point_by_point(motion, velocities, accelerations, loads, bars, torque):
    of_as_many(motion, velocities, accelerations, loads, torque)
    watts = []
    for k in range(motion.shape[1]):
        total = torque[k] * motion[1, k, 0]
        for body, (_, m, inertia) in enumerate(bars):
            total -= m * float(np.dot(accelerations[k, body] + [0, G], velocities[k, body]))
            if body < 4:
                total -= inertia * motion[1, k, TURNS[body]] * motion[2, k, TURNS[body]]
        watts.append(total + float(np.vdot(loads[k], velocities[k, 2:4])))
    return watts


def power_by_forces(motion, velocities, accelerations, loads, bars, torque):
    """Drives first, masses second, with complex numbers."""
    of_as_many(motion, velocities, accelerations, loads, torque)
    v, a, f = ((each[..., 0] + 1j * each[..., 1]) for each in (velocities, accelerations, loads))
    masses = (bars[:, 1] * ((a + 1j * G) * v.conj()).real).sum(axis=1)
    turned = motion[1] * motion[2] @ np.array([bars[0, 2], bars[1, 2], bars[2, 2] + bars[3, 2]])
    return torque * motion[1, :, 0] + (f * v[:, [2, 3]].conj()).real.sum(axis=1) - masses - turned


def residuals_by_cross(motion, places, accelerations, loads, bars, torque, forces):
    """An incidence matrix, and the cross product of vectors in space."""
    of_as_many(motion, places, accelerations, loads, torque, forces)
    n = motion.shape[1]
    sides = np.array([[joints.get(name, 0) for name in "OABCDEF"] for joints in JOINTS_OF])
    acting = sides[:, :, None] * forces[:, None]
    arms = places[:, None, :7] - places[:, 7:, None]
    z = np.cross(np.concatenate((arms, 0 * arms[..., :1]), -1), np.concatenate((acting, 0 * acting[..., :1]), -1))[
        ..., 2
    ]
    known = -bars[:, 1, None] * (accelerations + np.array([0, G]))
    known[:, 2:4] += loads
    moments = z.sum(axis=2) - bars[:, 2] * np.hstack((motion[2], motion[2][:, 2:], np.zeros((n, 1))))
    moments[:, 0] += torque
    return np.concatenate((acting.sum(axis=2) + known, moments[..., None]), axis=2)


def residuals_by_trials(motion, places, accelerations, loads, bars, torque, forces):
    """The sums about the joints of `sums`, moved to the centres of mass; lists."""
    of_as_many(motion, places, accelerations, loads, torque, forces)
    found = []
    for k in range(motion.shape[1]):
        at = [complex(*place) for place in places[k]]
        x = np.array([torque[k], *np.ravel(forces[k])])
        (rows,) = sums(at, motion[2, k], accelerations[k], loads[k], bars, [x])
        bodies = np.reshape(rows, (5, 3)).tolist()
        for body, name in enumerate("OACFD"):
            arm = at[7 + body] - at["OABCDEF".index(name)]
            bodies[body][2] -= (arm.conjugate() * complex(*bodies[body][:2])).imag
        found.append(bodies)
    return found


def residuals_in_columns(motion, places, accelerations, loads, bars, torque, forces):
    of_as_many(motion, places, accelerations, loads, torque, forces)
    at = {name: places[:, k] for k, name in enumerate("OABCDEF")}
    out = np.empty((3, 5, motion.shape[1]))
    for k, joints in enumerate(JOINTS_OF):
        pulls = {name: side * forces[:, "OABCDEF".index(name)] for name, side in joints.items()}
        total = sum(pulls.values()) - bars[k, 1] * accelerations[:, k]
        total[:, 1] -= bars[k, 1] * G
        if k in (2, 3):
            total += loads[:, k - 2]
        arms = {name: at[name] - places[:, 7 + k] for name in joints}
        out[:2, k] = total.T
        out[2, k] = sum(np.linalg.det(np.stack((arms[name], pulls[name]), axis=1)) for name in joints)
        out[2, k] -= bars[k, 2] * (motion[2][:, TURNS[k]] if k < 4 else 0)
    out[2, 0] += torque
    return out.transpose(2, 1, 0)


def verdict_by(power, residuals, least):
    def find(motion, places, velocities, accelerations, loads, bars, torque, forces):
        watts = np.array(power(motion, velocities, accelerations, loads, bars, torque))
        off = np.abs(residuals(motion, places, accelerations, loads, bars, torque, forces))
        off[..., :2] /= np.abs(forces).max()
        off[..., 2] /= np.abs(torque).max()
        (bodies,) = np.nonzero((off > least).any(axis=(0, 2)))
        return [
            np.abs(watts).max() / np.abs(torque * motion[1][:, 0]).max() > least,
            *(bodies if len(bodies) else [None]),
        ]

    return find


RIGHT = {
    "steiner": (by_gyration, by_two_particles, by_matrices),
    "centre_accelerations": (by_mechlib, by_points, by_turning_matrices),
    "fifteen_equations": (by_the_rows_of_mechlib, by_trials, by_the_moving_joints),
    "torque_and_forces": (by_scipy, by_qr, by_least_squares),
    "power_residual": (power_by_dot_products, power_point_by_point, power_by_forces),
    "body_residuals": (residuals_by_cross, residuals_by_trials, residuals_in_columns),
    "planted_mistake": (
        verdict_by(power_by_dot_products, residuals_by_cross, 1e-3),
        verdict_by(power_point_by_point, residuals_by_trials, 1e-6),
        verdict_by(power_by_forces, residuals_in_columns, 1e-2),
    ),
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


@pytest.mark.parametrize("seed", range(5))
def test_torque_and_forces_and_both_witnesses_are_those_of_mechlib(seed):
    rng = np.random.default_rng(seed)
    w = Moving.drawn(rng, 9)
    wiper, sweep = given(w.motion, w.lengths, w.bars)
    right = dynamics.inverse_dynamics(wiper, sweep, w.loads)
    torque, forces = w.solved()
    np.testing.assert_allclose(torque, right.torque, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(forces, np.stack(list(right.forces.values()), axis=1), rtol=1e-11, atol=1e-10)

    wrong_torque, wrong_forces = torque + rng.normal(size=9), forces + rng.normal(size=forces.shape)
    named = dict(zip(right.forces, wrong_forces.swapaxes(0, 1), strict=True))
    by_bodies = dynamics.residuals(wiper, sweep, dynamics.Reactions(wrong_torque, named), w.loads)
    found = task("body_residuals").reference(
        w.motion, w.places, w.accelerations, w.loads, w.bars, wrong_torque, wrong_forces
    )
    np.testing.assert_allclose(found, by_bodies, atol=1e-12)
    by_energies = wrong_torque * w.motion[1][:, 0] - dynamics.power(wiper, sweep, w.loads)
    watts = task("power_residual").reference(w.motion, w.velocities, w.accelerations, w.loads, w.bars, wrong_torque)
    np.testing.assert_allclose(watts, by_energies, atol=1e-11)


def test_every_drawn_wiper_is_a_crank_rocker_away_from_its_dead_points():
    rng = np.random.default_rng(0)
    for _ in range(50):
        w = Moving.drawn(rng, 6)
        wiper, sweep = given(w.motion, w.lengths, w.bars)
        assert wiper.grashof == "crank-rocker"
        q = wiper.position(np.linspace(0, 2 * np.pi, 200))
        assert np.rad2deg(wiper.transmission_angle(q)).min() > 19.9
        assert np.abs(wiper.loop.residual(sweep.position, w.motion[0, :, 0])).max() < 1e-12


def test_moments_of_inertia_in_the_cases_are_those_of_bodies_made_of_particles():
    """The reference is Steiner's rule; here the moments are summed over particles, about both axes."""
    rng = np.random.default_rng(1)
    m, z = rng.uniform(0.1, 1, (4, 6)), rng.normal(size=(4, 6)) + 1j * rng.normal(size=(4, 6))
    centre = (m * z).sum(axis=1) / m.sum(axis=1)
    axes = rng.normal(size=(2, 4)) + 1j * rng.normal(size=(2, 4))
    about = [(m * np.abs(z - axis[:, None]) ** 2).sum(axis=1) for axis in axes]
    given, wanted = np.abs(axes - centre)
    np.testing.assert_allclose(task("steiner").reference(about[0], m.sum(axis=1), given, wanted), about[1])


def test_the_planted_mistake_of_the_source_is_always_among_the_cases_and_no_power_sees_it():
    for student in DRAWS:
        asked = paper(task("planted_mistake"), "salt", student)
        assert asked.expected[0].outcome.value == (False, BODIES.index("bar"))
        motion, _, velocities, accelerations, loads, bars, torque, _ = asked.cases[0].args
        watts = task("power_residual").reference(motion, velocities, accelerations, loads, bars, torque)
        assert np.abs(watts).max() < 1e-10 * np.abs(torque * motion[1][:, 0]).max()


# --- ways that only look right


def test_an_inverse_is_seen_and_loses_half_a_point():
    def by_inverse(system, velocities, size):
        matrix, right = system(rubbing(velocities, size))
        for k, A in enumerate(matrix):
            if np.linalg.det(A) == 0:
                raise ValueError(f"singular at index {k}")
        x = (np.linalg.inv(matrix) @ right[..., None])[..., 0]
        return x[:, 0], x[:, 1:].reshape(-1, 7, 2)

    for student in DRAWS:
        assessment = judged("torque_and_forces", by_inverse, student)
        assert assessment.points == 2.5
        assert [fault for fault in faults(assessment) if "is an inverse formed?" in fault]


def test_asking_for_all_equations_again_at_every_point_loses_a_quarter():
    def again(system, velocities, size):
        loads = rubbing(velocities, size)
        point_by_point = [[part[k] for part in system(loads)] for k in range(len(loads))]
        return by_qr(lambda _: tuple(map(np.array, zip(*point_by_point, strict=True))), velocities, size)

    for student in DRAWS[:5]:
        assessment = judged("torque_and_forces", again, student)
        assert assessment.points == 2.75
        assert [fault for fault in faults(assessment) if "it asks for the equations" in fault]


@pytest.mark.parametrize("answer", [(False, 4), (False, None), (True, 4), (True, 1), (False, 0), (True, None)])
def test_a_guess_finds_no_planted_mistake(answer):
    for student in DRAWS:
        assert judged("planted_mistake", lambda *args: answer, student).points == 0


@pytest.mark.parametrize("name", ["power_residual", "body_residuals"])
def test_residuals_that_are_always_zero_earn_nothing(name):
    for student in DRAWS[:5]:
        assert judged(name, lambda *args: 0 * task(name).reference(*args), student).points < 0.5


def test_the_source_s_equations_lose_the_moment_of_the_bar_alone():
    """Source B, row 15: the arm r5 for the centre of mass. The torque is right, and the answer is not."""

    def of_the_source(motion, accelerations, loads, lengths, bars):
        matrix, right = by_the_moving_joints(motion, accelerations, loads, lengths, bars)
        right[:, 14] *= lengths[5] / bars[4, 0]
        return matrix, right

    for student in DRAWS:
        assessment = judged("fifteen_equations", of_the_source, student)
        assert assessment.mistake.startswith("The centre of mass of the bar has the arm r5. ")
        assert assessment.points == 3


def test_a_blade_that_stands_still_may_cost_its_own_points_only():
    def nan_at_rest(system, velocities, size):
        with np.errstate(invalid="ignore", divide="ignore"):
            loads = -size * velocities / np.linalg.norm(velocities, axis=-1, keepdims=True)
        return by_qr(lambda _: system(loads), velocities, size)

    for student in DRAWS:
        assert judged("torque_and_forces", nan_at_rest, student).points == 2.75
