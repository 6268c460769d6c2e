"""Claims of the chapter on the consecutive sweep, proven without the code that it calls."""

import numpy as np
import pytest
import sympy as sp
from hypothesis import assume, given
from hypothesis import strategies as st

R1Y, R2, R3 = 0.045, 0.075, 0.170  # m, source A
TURN = 2 * np.pi
CRANK = np.linspace(0, TURN, 1001)


def sine(crank):
    """sin(theta3), from the second and third equation of the closure."""
    return (R1Y - R2 * np.sin(crank)) / R3


def coupler(seed, crank, iterations=12):
    """theta3 by Newton-Raphson on sin(theta3) = c alone."""
    c, th3 = sine(crank), np.full_like(crank, seed)
    for _ in range(iterations):
        th3 = th3 - (np.sin(th3) - c) / np.cos(th3)
    return th3


def test_newton_on_the_closure_moves_theta3_as_newton_on_its_sine_does():
    """The rows Fc and Fy - Fc are free of one another's other unknowns, and rows may be added."""
    r1, th1, th3, r1y, r2, r3, th2 = sp.symbols("r1 th1 th3 r1y r2 r3 th2")
    fx = -r1 * sp.cos(th1) + r2 * sp.cos(th2) + r3 * sp.cos(th3)
    fy = r1 * sp.sin(th1) - r2 * sp.sin(th2) - r3 * sp.sin(th3)
    closure = sp.Matrix([fx, fy, r1 * sp.sin(th1) - r1y])
    step = closure.jacobian((r1, th1, th3)).LUsolve(closure)
    alone = (sp.sin(th3) - (r1y - r2 * sp.sin(th2)) / r3) / sp.cos(th3)
    assert sp.simplify(step[2] - alone) == 0


def test_from_the_sketch_a_cold_start_goes_astray_and_from_source_a_s_seed_it_does_not():
    built = np.pi - np.arcsin(sine(CRANK))
    assert np.abs(coupler(3.0, CRANK) - built).max() < 1e-12
    assert coupler(2.0, CRANK[:1])[0] == pytest.approx(built[0], abs=1e-12)  # good at rest
    assert (np.abs(coupler(2.0, CRANK) - built) > 1).sum() > 100


@given(st.floats(1.001, 3), st.floats(-50, 50))
def test_a_loop_that_cannot_close_never_lets_a_step_become_small(c, th3):
    for _ in range(50):
        assume(abs(np.cos(th3)) > 1e-8)
        step = (np.sin(th3) - c) / np.cos(th3)
        assert abs(step) >= (c - 1) * (1 - 1e-12)
        th3 -= step


def test_the_last_step_leaves_half_the_tangent_times_its_square():
    crank, d = CRANK[::50], 1e-4
    true = np.pi - np.arcsin(sine(crank))
    before = true + d
    after = before - (np.sin(before) - sine(crank)) / np.cos(before)
    left, step = after - true, before - after
    np.testing.assert_allclose(left, -np.tan(true) / 2 * step**2, atol=1e-11)  # the next term, d^3


def test_the_saw_is_a_quick_return_and_takes_longer_on_its_way_out():
    crank = np.linspace(0, TURN, 2_000_001)
    x = R2 * np.cos(crank) - np.sqrt(R3**2 - (R1Y - R2 * np.sin(crank)) ** 2)
    farthest, nearest = crank[x.argmin()], crank[x.argmax()]
    inwards = (nearest - farthest) % TURN  # the crank turns from the outer to the inner dead centre
    assert (TURN - inwards) / inwards > 1.1
    outer = np.pi - np.arcsin(R1Y / (R3 + R2))
    inner = TURN - np.arcsin(R1Y / (R3 - R2))
    assert (farthest, nearest) == (pytest.approx(outer, abs=1e-5), pytest.approx(inner, abs=1e-5))
    assert np.ptp(x) > 2 * R2


def test_half_of_the_coriolis_term_shows_in_alpha1_alone():
    r1, th1, th3, r3, vr, w1 = sp.symbols("r1 th1 th3 r3 vr w1", nonzero=True)
    c1, s1, c3, s3 = sp.cos(th1), sp.sin(th1), sp.cos(th3), sp.sin(th3)
    jacobian = sp.Matrix([[-c1, r1 * s1, -r3 * s3], [s1, r1 * c1, -r3 * c3], [s1, r1 * c1, 0]])
    slip = jacobian.LUsolve(vr * w1 * sp.Matrix([s1, c1, c1]))
    assert sp.simplify(slip - sp.Matrix([0, vr * w1 / r1, 0])) == sp.zeros(3, 1)


@given(st.integers(0, 2**32 - 1))
def test_newton_solves_a_linear_system_in_one_step_and_confirms_it_in_a_second(seed):
    """A5: source A counts four iterations for the acceleration, whose equations are linear."""
    rng = np.random.default_rng(seed)
    matrix = np.linalg.qr(rng.normal(size=(3, 3)))[0] * rng.uniform(0.5, 2, 3)
    right, x = rng.normal(size=3), rng.uniform(-100, 100, 3)
    steps = []
    for _ in range(2):
        d = np.linalg.solve(matrix, matrix @ x - right)
        x = x - d
        steps.append(np.linalg.norm(d))
    assert steps[0] > 1e-6 > 1e-11 > steps[1]
