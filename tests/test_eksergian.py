"""Eksergian's one equation, beside the seventeen that do not know of it."""

from itertools import chain, islice

import numpy as np
import pytest
import sympy as sp
from linkages import crank_rockers

from mechlib import eksergian
from mechlib.direct import direct_dynamics
from mechlib.dynamics import inverse_dynamics
from mechlib.motion import Motion
from mechlib.sweep import consecutive
from mechlib.wiper import Wiper


@pytest.fixture(scope="module")
def wipers():
    return list(islice(crank_rockers(np.random.default_rng(5)), 30))


def test_the_one_equation_gives_the_acceleration_of_the_seventeen(wipers):
    rng = np.random.default_rng(6)
    for wiper in wipers:
        theta, omega, torque = rng.uniform(-7, 7), rng.uniform(-8, 8), rng.uniform(-5, 5)
        loads = rng.uniform(-5, 5, (2, 2))
        q = wiper.position(theta)
        state = np.array([[theta, *q]]), np.array([[omega, *wiper.loop.velocity(q, theta, omega)]])
        seventeen = direct_dynamics(wiper, *state, [torque], loads[None]).accelerations[0, 0]
        J, inertial, load = eksergian.terms(wiper, theta, q, omega, loads)
        assert (torque + load - inertial) / J == pytest.approx(seventeen, rel=1e-10, abs=1e-10)


def test_the_velocity_ratios_and_their_derivatives_are_differences_of_the_position(wipers):
    step = 1e-4
    for wiper in wipers[:5]:
        before, here, after = wiper.position(1 + step * np.arange(-1, 2))
        k, h = eksergian.ratios(wiper, 1.0, here)
        np.testing.assert_allclose(k, (after - before) / (2 * step), atol=1e-6)
        np.testing.assert_allclose(h, (after - 2 * here + before) / step**2, atol=1e-5)


def test_the_torque_in_symbols_is_that_of_the_fifteen_equations(wipers):
    closure, forces = Wiper.closure, (load.force for load in Wiper.rigid.loads)
    symbols = (*closure.input, *(q.position for q in closure.unknowns), *Wiper.parameters, *chain(*forces))
    torque = sp.lambdify(symbols, eksergian.torque(Wiper.rigid), cse=True)
    rng = np.random.default_rng(7)
    for wiper in wipers[:5]:
        crank = rng.uniform(-7, 7, (3, 1))
        q, loads = wiper.position(crank[0]), rng.uniform(-5, 5, (1, 2, 2))
        motion = Motion(np.zeros(1), *crank)
        expected = inverse_dynamics(wiper, consecutive(wiper, motion, q[0], tol=1e-13), loads).torque[0]
        found = torque(*crank[:, 0], *q[0], *wiper.constants, *loads.ravel())
        assert found == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_the_reduced_inertia_tells_the_kinetic_energy(wipers):
    """Masses of the centres, moving as differences of their positions say."""
    step = 1e-5
    for wiper in wipers[:5]:
        energy, angles = 0.0, []
        for theta in (1 - step, 1 + step):
            q2, q3 = wiper.position(theta)
            angles.append(np.array([theta, q2, q3, q3, 0]))
        lengths = [bar.centre for bar in wiper.masses]
        begin = [0, wiper.r1, 0, 0, wiper.r4]  # what carries the joint from which a centre is so far
        carried = [0, 0, 0, 0, 2]
        centres = [
            [begin[b] * np.exp(1j * angle[carried[b]]) + lengths[b] * np.exp(1j * angle[b]) for b in range(5)]
            for angle in angles
        ]
        for bar, v, w in zip(wiper.masses, np.diff(centres, axis=0)[0], np.diff(angles, axis=0)[0], strict=True):
            energy += (bar.mass * abs(v) ** 2 + bar.inertia * w**2) / 2 / (2 * step) ** 2
        J = eksergian.terms(wiper, 1.0, wiper.position(1.0), 0.0).inertia
        assert J / 2 == pytest.approx(energy, rel=1e-7)


def test_a_dead_point_is_refused_with_its_angle():
    """Ground and crank as long as coupler and rocker: at half a turn coupler and rocker lie in one line."""
    folded = Wiper(r0=0.2, r1=0.1, r2=0.2, r3=0.1)
    with pytest.raises(ZeroDivisionError, match=r"singular position at theta_1 = 0: no velocity is determined"):
        eksergian.ratios(folded, 0.0, np.array([0.0, 0.0]))
