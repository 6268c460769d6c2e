"""The hydraulic cylinder of source C: its verified figures, and oracles that share nothing with its equations."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
import sympy as sp
from hypothesis import assume, given
from hypothesis import strategies as st
from linkages import cylinders

from mechlib import dynamics
from mechlib.closure import OpenLoopError
from mechlib.cylinder import Cylinder, Swing, energies, lagrange, newton_euler, virtual_power
from mechlib.direct import direct_dynamics
from mechlib.eksergian import velocity_ratios
from mechlib.motion import Motion
from mechlib.rigidbody import MassProperties
from mechlib.sweep import consecutive

WAYS = {"virtual power": virtual_power, "Lagrange": lagrange, "Newton-Euler": lambda c, s: newton_euler(c, s)[0]}


@pytest.fixture(scope="module")
def cylinder():
    return Cylinder()


def along_the_source(cylinder, t):
    motion = cylinder.length(Swing().at(t))
    still = np.abs(motion.velocity) < 1e-15  # the cosine of a rounded quarter turn
    return cylinder.sweep(replace(motion, velocity=np.where(still, 0.0, motion.velocity)))


@pytest.fixture(scope="module")
def thousand(cylinder):
    return along_the_source(cylinder, np.arange(1000) / 1000)


@pytest.fixture(scope="module")
def random():
    return [(c, c.sweep(motion)) for c, motion in islice(cylinders(np.random.default_rng(9)), 200)]


def rate(values):
    """Derivative by time of what repeats every second, along the first axis."""
    n = len(values)
    modes = np.fft.fft(values, axis=0).T * 2j * np.pi * np.fft.fftfreq(n, 1 / n)
    return np.fft.ifft(modes.T, axis=0)


def as_complex(pairs):
    return pairs[..., 0] + 1j * pairs[..., 1]


def by_hand(cylinder, sweep):
    """Joints, centres of mass and angles of the bodies, from the positions alone."""
    s, (th2, th4) = sweep.motion.position, sweep.position.T
    start, e2, e4 = cylinder.o2 - 1j * cylinder.o4, np.exp(1j * th2), np.exp(1j * th4)
    piston = start + (s - cylinder.l) * e2
    g2, g3, g4 = (body.centre for body in cylinder.masses)
    joints = {"O2": start + 0 * e2, "P": piston, "A": start + s * e2, "O4": 0 * e4}
    return joints, (start + g2 * e2, piston + g3 * e2, g4 * e4), (th2, th2, th4)


# --- kinematics


def test_source_c_geometry_at_the_start(cylinder):
    sweep = along_the_source(cylinder, [0.0, 0.5])
    assert f"{cylinder.d:.4f}" == "1.0308"
    np.testing.assert_allclose(sweep.position[0], [np.pi / 2, 0], atol=1e-15)
    assert f"{sweep.velocity[0, 1]:.6f}" == "0.502655"
    assert sweep.velocity[0, 0] == pytest.approx(0, abs=1e-15)
    assert f"{sweep.motion.velocity[0]:.3f}" == "0.126"
    low, high = cylinder.stops
    assert (f"{high - 0.6:.3f}", f"{0.6 - low:.3f}") == ("0.195", "0.195")
    assert f"{cylinder.areas[1]:.3e}" == "6.032e-04"
    about_o2 = cylinder.masses[0].inertia + cylinder.masses[0].mass * cylinder.masses[0].centre ** 2
    assert (f"{about_o2:.1f}", f"{cylinder.masses[1].inertia:.3f}") == ("0.6", "0.027")


def test_the_closure_gives_w4_as_v_over_b_sin_d_and_w2_as_v_cos_d_over_s_sin_d():
    s, b, th2, th4 = sp.symbols("s b theta_2 theta_4", positive=True)
    free = {symbol: sp.Symbol(symbol.name, positive=True) for symbol in Cylinder.closure.jacobian.free_symbols}
    k2, k4 = (ratio.subs(free) for ratio in velocity_ratios(Cylinder.closure)[0])
    D = th2 - th4
    assert sp.simplify(k4 - 1 / (b * sp.sin(D))) == 0
    assert sp.simplify(k2 - sp.cos(D) / (s * sp.sin(D))) == 0


def test_the_ratios_of_velocity_and_acceleration_are_differences_of_the_positions(random):
    step = 1e-4
    for cylinder, sweep in random[:20]:
        for branch in ("right", "left"):
            s = sweep.motion.position
            before, here, after = (cylinder.position(s + shift, branch) for shift in (-step, 0.0, step))
            k, h = cylinder.ratios(s, here)
            np.testing.assert_allclose((after - before) / (2 * step), k, atol=1e-5 * np.abs(k).max())
            np.testing.assert_allclose((after - 2 * here + before) / step**2, h, atol=1e-4 * np.abs(h).max())


@given(
    st.floats(0.01, 3), st.floats(0.01, 3), st.floats(0.05, 3), st.floats(0.01, 7),
    st.sampled_from(["right", "left"]),
)  # fmt: skip
def test_every_closed_position_has_rigid_bars_on_its_side(o2, o4, b, s, branch):
    short, long = abs(np.hypot(o2, o4) - b), np.hypot(o2, o4) + b
    assume(short < s < long)
    l = (short + long) / 4
    cylinder = Cylinder(o2, o4, b, l, li=0.9 * (short + long) / 4, ls=long, e=1e-4)
    th2, th4 = cylinder.position(s, branch)
    start, end = o2 - 1j * o4, b * np.exp(1j * th4)
    assert start + s * np.exp(1j * th2) == pytest.approx(end, abs=1e-13)
    assume(min(s - short, long - s) > 1e-6)  # at a flat triangle the two branches meet
    to_o4 = -start
    side = (to_o4.conjugate() * (end - start)).imag
    assert (side < 0) == (branch == "right")
    assert cylinder.branch([th2, th4]) == branch


def test_newton_raphson_finds_the_closed_form(cylinder):
    motion = cylinder.length(Swing().at(np.linspace(0, 1, 21)))
    found = consecutive(cylinder, motion, cylinder.position(motion.position[0]) + 0.05, tol=1e-12)
    np.testing.assert_allclose(found.position, cylinder.position(motion.position), atol=1e-13)


def test_velocities_and_accelerations_are_derivatives_of_the_positions(cylinder):
    sweep = along_the_source(cylinder, np.arange(128) / 128)
    joints, centres, _ = by_hand(cylinder, sweep)
    for name, z in {**joints, **dict(zip(("G2", "G3", "G4"), centres, strict=True))}.items():
        path = dynamics.trace(cylinder, sweep, name)
        np.testing.assert_allclose(as_complex(path.position), z, atol=1e-15)
        np.testing.assert_allclose(as_complex(path.velocity), rate(z), atol=1e-11)
        np.testing.assert_allclose(as_complex(path.acceleration), rate(rate(z)), atol=1e-9)
    np.testing.assert_allclose(rate(sweep.position), sweep.velocity, atol=1e-11)
    np.testing.assert_allclose(rate(sweep.velocity), sweep.acceleration, atol=1e-9)


# --- forces


@pytest.mark.parametrize("way", WAYS)
def test_source_c_right_force_to_the_verified_digits(cylinder, way):
    Q = WAYS[way](cylinder, along_the_source(cylinder, [0.0, 0.01, 0.25, 0.75]))
    digits = ["43.14926", "42.672362", "35.455131495", "50.845686583"]
    assert [f"{value:.{len(text.partition('.')[2])}f}" for value, text in zip(Q, digits, strict=True)] == digits


def apart(cylinder, sweep):
    """Of the three ways, over the largest force."""
    forces = np.array([way(cylinder, sweep) for way in WAYS.values()])
    return np.ptp(forces, axis=0).max() / np.abs(forces).max()


def test_the_three_ways_agree_at_1000_times_where_the_velocity_is_zero_included(cylinder, thousand):
    assert (thousand.motion.velocity == 0).sum() == 2
    assert apart(cylinder, thousand) < 1e-12


def test_the_three_ways_agree_for_200_random_mechanisms_and_motions_on_both_branches(random):
    for cylinder, sweep in random:
        assert sweep.motion.velocity[0] == 0
        assert apart(cylinder, sweep) < 1e-12
    for cylinder, sweep in random[:50]:
        assert apart(cylinder, cylinder.sweep(sweep.motion, "left")) < 1e-12


def test_the_power_of_the_cylinder_is_the_rate_of_the_energy(cylinder, thousand, random):
    for c, sweep in [(cylinder, thousand), *random]:
        power = virtual_power(c, sweep) * sweep.motion.velocity
        assert np.abs(power - dynamics.power(c, sweep)).max() < 1e-10 * np.abs(power).max()


def test_the_energies_are_those_of_the_positions_and_their_rate_is_the_power_of_the_cylinder(cylinder):
    sweep = along_the_source(cylinder, np.arange(128) / 128)
    _, centres, angles = by_hand(cylinder, sweep)
    bodies = list(zip(cylinder.masses, centres, angles, strict=True))
    T = sum(m.mass * abs(rate(z)) ** 2 / 2 + m.inertia * rate(angle).real ** 2 / 2 for m, z, angle in bodies)
    V = sum(m.mass * cylinder.g * z.imag for m, z, _ in bodies)
    kinetic, potential = energies(cylinder, sweep)
    np.testing.assert_allclose(kinetic, T, atol=1e-12)
    np.testing.assert_allclose(potential, V, atol=1e-12)
    power = newton_euler(cylinder, sweep)[0] * sweep.motion.velocity
    assert np.abs(power - rate(T + V).real).max() < 1e-10 * np.abs(power).max()


def imbalances(cylinder, sweep, Q, forces):
    """Of each body: what Newton leaves over, and Euler about its own centre of mass; accelerations from positions."""
    joints, centres, angles = by_hand(cylinder, sweep)
    e2 = np.exp(1j * sweep.position[:, 0])
    across, couple = forces["P"].T
    on_rod = Q * e2 + across * 1j * e2
    O2, A, O4 = (as_complex(forces[name]) for name in ("O2", "A", "O4"))
    acting = ({"O2": O2, "P": -on_rod}, {"P": on_rod, "A": A}, {"A": -A, "O4": O4})
    couples, left = (-couple, couple, 0), []
    for body, z, angle, forces_on, moment in zip(cylinder.masses, centres, angles, acting, couples, strict=True):
        newton = sum(forces_on.values()) - body.mass * (rate(rate(z)) + 1j * cylinder.g)
        euler = sum(((joints[name] - z).conjugate() * f).imag for name, f in forces_on.items()) + moment
        left += [np.abs(newton), np.abs(euler - body.inertia * rate(rate(angle)).real)]
    return np.max(left)


def test_the_reactions_balance_each_body_of_source_c(cylinder):
    sweep = along_the_source(cylinder, np.arange(64) / 64)
    assert imbalances(cylinder, sweep, *newton_euler(cylinder, sweep)) < 1e-9


def test_the_reactions_balance_each_body_of_200_random_mechanisms(random):
    for cylinder, sweep in random:
        Q, forces = newton_euler(cylinder, sweep)
        largest = max(np.abs(Q).max(), *(np.abs(force).max() for force in forces.values()))
        left = dynamics.residuals(cylinder, sweep, dynamics.Reactions(Q, forces))
        assert np.abs(left).max() < 1e-12 * largest


def test_a_force_across_the_rod_that_is_wrong_is_seen_by_the_balance_and_by_no_power(cylinder):
    sweep = along_the_source(cylinder, np.arange(64) / 64)
    Q, forces = newton_euler(cylinder, sweep)
    for wrong in ([1.0, 0.0], [0.0, 1.0]):
        changed = forces | {"P": forces["P"] + wrong}
        assert imbalances(cylinder, sweep, Q, changed) > 0.5
        assert np.abs(dynamics.residuals(cylinder, sweep, dynamics.Reactions(Q, changed))).max() > 0.5


def test_a_mechanism_held_still_needs_the_slope_of_its_potential_energy(random):
    step = 1e-6
    for cylinder, sweep in random[:20]:
        s = sweep.motion.position[:8]
        still = Motion(sweep.motion.t[:8], s, np.zeros(8), np.zeros(8))

        def height(shift, c=cylinder, still=still):
            _, centres, _ = by_hand(c, c.sweep(replace(still, position=still.position + shift)))
            return sum(body.mass * c.g * z.imag for body, z in zip(c.masses, centres, strict=True))

        Q = virtual_power(cylinder, cylinder.sweep(still))
        np.testing.assert_allclose((height(step) - height(-step)) / (2 * step), Q, atol=1e-7 * np.abs(Q).max() + 1e-7)


def test_the_force_found_gives_the_motion_back(cylinder):
    """Direct dynamics, with the thrust along the slide given: eleven equations."""
    sweep = along_the_source(cylinder, np.arange(64) / 64)
    Q, forces = newton_euler(cylinder, sweep)
    motion = sweep.motion
    position, velocity = (
        np.column_stack(pair) for pair in ((motion.position, sweep.position), (motion.velocity, sweep.velocity))
    )
    found = direct_dynamics(cylinder, position, velocity, Q)
    expected = np.column_stack((motion.acceleration, sweep.acceleration))
    np.testing.assert_allclose(found.accelerations, expected, atol=1e-12)
    for name, force in found.forces.items():
        np.testing.assert_allclose(force, forces[name], atol=1e-11)


def test_the_system_of_newton_and_euler_has_a_name_for_each_row_and_column():
    system = Cylinder.rigid.inverse
    assert system.columns == ("Q", "O2_x", "O2_y", "P_n", "P_m", "A_x", "A_y", "O4_x", "O4_y")
    assert system.rows[2::3] == ("barrel, moment about O2", "rod, moment about A", "rocker, moment about O4")
    assert Cylinder.rigid.direct.matrix.shape == (11, 11)


# --- pressures


@pytest.mark.parametrize("back", [0.0, 3e5])
def test_the_pressures_on_their_areas_make_the_force_and_one_chamber_is_at_the_return_line(cylinder, back):
    Q = np.linspace(-500, 500, 101)
    piston, rod = cylinder.pressures(Q, back)
    whole, ring = np.pi * 0.016**2, np.pi * (0.016**2 - 0.008**2)
    np.testing.assert_allclose(piston * whole - rod * ring, Q, atol=1e-12 * 500 + 1e-12 * back)
    np.testing.assert_allclose(np.minimum(piston, rod), back, rtol=1e-15)
    assert (piston[Q > back * (whole - ring)] > back).all()
    assert (rod[Q < back * (whole - ring)] > back).all()


# --- bad input


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Cylinder(b=0.0), "b must be a positive number, got 0.0"),
        (lambda: Cylinder(l=-0.4), "l must be a positive number, got -0.4"),
        (lambda: Cylinder(o4=np.nan), "o4 must be a positive number, got nan"),
        (lambda: Cylinder(masses=Cylinder().masses[:2]), "masses must be 3, of barrel, rod, rocker; got 2"),
        (lambda: MassProperties.slender(1.0, 0.0, 0.1), "inertia must be a positive number, got 0.0"),
        (lambda: Cylinder(rod_radius=0.016), "the rod must be thinner than the piston, 0.016 m, got 0.016"),
        (lambda: Cylinder(ls=0.41), "a piston of 0.01 m has no stroke between li = 0.4 and ls = 0.41 m"),
        (
            lambda: Cylinder(b=0.01, l=0.1),
            "no stroke: the stops leave from 0.405 to 0.795 m, and the triangle from 0.920776 to 0.940776 m",
        ),
        (lambda: Cylinder().position(0.0), "s must be positive, got 0.0"),
        (lambda: Cylinder().position(np.inf), "s must be finite, got inf"),
        (lambda: Cylinder().position(1.0, "open"), "branch must be 'right' or 'left', got 'open'"),
        (lambda: Swing(amplitude=0.0), "amplitude must be a positive number, got 0.0"),
        (lambda: Cylinder().pressures(10.0, back=-1.0), "back must not be negative, got -1.0"),
        (lambda: Cylinder().pressures([1.0, np.nan]), "force must be finite, got nan at index 1"),
    ],
)
def test_what_cannot_be_is_refused_with_the_value(make, says):
    with pytest.raises(ValueError, match=f"^{says}$"):
        make()


@pytest.mark.parametrize(("s", "missing"), [(0.75, "0.0308"), (1.3, "0.0192")])
def test_a_length_that_the_triangle_cannot_close_gives_the_limits_and_no_number(cylinder, s, missing):
    says = f"at s = {s}: {missing} m are missing; the triangle closes from 0.780776 to 1.28078 m$"
    with pytest.raises(OpenLoopError, match=says):
        cylinder.position([1.0, s])


def test_a_motion_past_the_stops_is_refused_with_the_time_and_the_limits(cylinder):
    t = np.linspace(0, 1, 5)
    for middle, a in ((0.78, "0.8"), (0.41, "0.39")):
        with pytest.raises(ValueError, match=f"stop at t = 0.[27]5 s, a = {a} m: it can move from 0.405 to 0.795 m$"):
            cylinder.sweep(cylinder.length(Swing(middle).at(t)))
    for stop in cylinder.stops:  # up to them it can go
        cylinder.sweep(cylinder.length(Motion(t, np.full(5, stop), 0 * t, 0 * t)))


def test_at_a_flat_triangle_there_is_a_position_and_no_velocity():
    cylinder = Cylinder(ls=0.9)
    s = cylinder.reach[1]
    th2, th4 = cylinder.position(s)
    assert np.exp(1j * th2) == pytest.approx(np.exp(1j * th4), abs=1e-15)
    with pytest.raises(ZeroDivisionError, match=r"singular position at point 0, s = 1\.28078"):
        cylinder.ratios(s, [th2, th4])
