"""The windscreen wiper of source B: its verified figures, and oracles that share nothing with the assembled system."""

from itertools import islice

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from linkages import TURN, crank_rockers

from mechlib import dynamics
from mechlib.batched import batched
from mechlib.closure import OpenLoopError
from mechlib.grashof import grashof
from mechlib.motion import Motion
from mechlib.newton import newton
from mechlib.rigidbody import steiner
from mechlib.sweep import Sweep, consecutive
from mechlib.wiper import BODIES, MassProperties, Wiper

SEED = np.deg2rad([55, 125])
OMEGA = 35 * 2 * np.pi / 60


def turning(theta1=TURN, omega=OMEGA):
    return Motion(theta1 / omega, theta1, np.full_like(theta1, omega), np.zeros_like(theta1))


def as_the_source_iterates(wiper, motion):
    """From the fixed seed at every point, until the residual is below 1e-9; what that leaves is in its last digits."""
    q = []
    for u in motion.position:
        found = np.array(SEED)
        while np.linalg.norm(F := wiper.loop.residual(found, u)) >= 1e-9:
            found = found - np.linalg.solve(wiper.loop.jacobian(found, u), F)
        q.append(found)
    q = np.array(q)
    rates = wiper.loop.rates(q, motion.position, motion.velocity, motion.acceleration)
    return Sweep(motion, q, *rates, np.zeros(len(q), int), np.zeros(len(q)))


@pytest.fixture(scope="module")
def wiper():
    return Wiper()


@pytest.fixture(scope="module")
def source(wiper):
    return as_the_source_iterates(wiper, turning())


@pytest.fixture(scope="module")
def exact(wiper):
    return batched(wiper, turning(), SEED, tol=1e-12)


def friction(wiper, sweep):
    return np.stack([dynamics.friction(dynamics.trace(wiper, sweep, p).velocity, 4.5) for p in ("G3", "G4")], axis=1)


# --- kinematics -------------------------------------------------------------------------------------------------------


def test_the_wiper_is_a_crank_rocker(wiper):
    assert wiper.grashof == "crank-rocker"


def test_source_b_ranges_of_the_angles_to_the_verified_digits(source):
    degrees = np.rad2deg(source.position)
    assert [f"{x:.9f}" for x in degrees.min(axis=0)] == ["9.244160602", "71.682304059"]
    assert [f"{x:.9f}" for x in degrees.max(axis=0)] == ["66.259135816", "160.536790827"]


def test_source_b_takes_3_to_5_iterations_a_point_from_the_fixed_seed(wiper):
    counts = []
    for u in TURN:
        q, count = np.array(SEED), 0
        while np.linalg.norm(F := wiper.loop.residual(q, u)) >= 1e-9:
            q, count = q - np.linalg.solve(wiper.loop.jacobian(q, u), F), count + 1
        counts.append(count)
    assert (min(counts), max(counts), sum(counts)) == (3, 5, 1662)


def test_source_b_largest_speed_of_h_and_acceleration_of_g(wiper, source):
    speed = np.linalg.norm(dynamics.trace(wiper, source, "H").velocity, axis=1).max()
    acceleration = np.linalg.norm(dynamics.trace(wiper, source, "G").acceleration, axis=1).max()
    assert (f"{speed:.10f}", f"{acceleration:.10f}") == ("2.3569008807", "15.4033537305")


def test_closed_form_newton_and_the_batched_sweep_agree(wiper, exact):
    np.testing.assert_allclose(exact.position, wiper.position(TURN), atol=2e-15 * 50)
    np.testing.assert_allclose(consecutive(wiper, turning(), SEED, 1e-12).position, exact.position, atol=1e-13)


@given(
    st.floats(0.2, 2), st.floats(0.2, 2), st.floats(0.2, 2), st.floats(0.2, 2), st.floats(-7, 7),
    st.sampled_from(["open", "crossed"]),
)  # fmt: skip
def test_every_closed_position_has_rigid_bars(r0, r1, r2, r3, theta1, branch):
    wiper = Wiper(r0=r0, r1=r1, r2=r2, r3=r3)
    assume(wiper.gap(theta1) < -1e-6)
    q = wiper.position(theta1, branch)
    A = r1 * np.exp(1j * theta1)
    B = r0 + r3 * np.exp(1j * q[1])
    assert abs(B - A) == pytest.approx(r2, abs=1e-8)
    assert A + r2 * np.exp(1j * q[0]) == pytest.approx(B, abs=1e-8)
    assert wiper.branch(q) == branch


def test_the_blades_stay_parallel_and_the_bar_between_them_level(wiper, exact):
    at = {name: dynamics.trace(wiper, exact, name).position for name in "CDEFGH"}
    np.testing.assert_allclose(at["E"] - at["D"], at["F"] - at["C"], atol=1e-15)
    np.testing.assert_allclose(at["H"] - at["F"], at["G"] - at["C"], atol=1e-15)
    np.testing.assert_allclose(np.linalg.norm(at["G"] - at["C"], axis=1), wiper.r6, rtol=1e-14)


@pytest.mark.parametrize("point", ["A", "B", "D", "E", "G", "H", "G1", "G2", "G3", "G4", "G5"])
def test_velocities_and_accelerations_of_the_points_are_derivatives_of_their_positions(wiper, point):
    """Exact to round-off by the Fourier series of a smooth periodic function."""
    theta1 = np.linspace(0, 2 * np.pi, 512, endpoint=False)
    path = dynamics.trace(wiper, batched(wiper, turning(theta1), SEED, 1e-12), point)

    def derivative(values):
        modes = np.fft.rfftfreq(len(values), 1 / len(values))
        return np.fft.irfft(1j * modes[:, None] * np.fft.rfft(values, axis=0), len(values), axis=0) * OMEGA

    np.testing.assert_allclose(derivative(path.position), path.velocity, atol=1e-11)
    np.testing.assert_allclose(derivative(path.velocity), path.acceleration, atol=1e-9)


@pytest.mark.parametrize(
    ("bars", "kind"),
    [
        ((0.245, 0.105, 0.220, 0.150), "crank-rocker"),
        ((0.245, 0.150, 0.220, 0.105), "rocker-crank"),
        ((1.0, 3.0, 3.5, 3.2), "double-crank"),
        ((3.0, 3.2, 1.0, 3.5), "double-rocker"),
        ((4.0, 2.0, 3.0, 2.0), "triple-rocker"),
        ((2.0, 1.0, 2.0, 1.0), "change-point"),
    ],
)
def test_grashofs_classes_are_what_the_bars_can_do(bars, kind):
    """A bar turns all the way round if the loop closes at each of its angles, whatever the rule says."""
    assert grashof(*bars) == kind
    r0, r1, r2, r3 = bars

    def all_round(ground, turning, a, b):
        distance = np.abs(ground - turning * np.exp(1j * np.linspace(0, 2 * np.pi, 720)))
        return bool(((distance <= a + b + 1e-12) & (distance >= abs(a - b) - 1e-12)).all())

    driver, follower = all_round(r0, r1, r2, r3), all_round(r0, r3, r2, r1)
    expected = {
        "crank-rocker": (True, False),
        "rocker-crank": (False, True),
        "double-crank": (True, True),
        "double-rocker": (False, False),
        "triple-rocker": (False, False),
        "change-point": (True, True),
    }
    assert (driver, follower) == expected[kind]


# --- masses and forces ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("inertia", "mass", "distance", "printed"),
    [
        (101211.52, 88.21, 52.5, "344340.3325"),
        (783941.91, 177.73, 110, "2934474.91"),
        (14101969.44, 437.58, 289.49, "50773125"),
        (14041914.46, 434.52, 290.47, "50703593"),
        (1916773.41, 240.13, 150, "7319698.41"),
    ],
)
def test_source_b_table_of_steiner(inertia, mass, distance, printed):
    digits = len(printed.partition(".")[2])
    assert f"{steiner(inertia, mass, distance):.{digits}f}" == printed


def test_the_bars_of_the_wiper_have_the_moments_about_their_ends_of_source_b(wiper):
    ends = [steiner(bar.inertia, bar.mass, bar.centre) for bar in wiper.masses[:4]]
    assert ends == pytest.approx([0.0003443403325, 0.002934475, 0.050703593, 0.050773125], rel=1e-7)


def test_the_system_of_inverse_dynamics_is_15_by_15_with_a_name_for_each_row_and_column(wiper):
    system = wiper.rigid.inverse
    assert system.columns == ("M", *(f"{joint}_{axis}" for joint in "OABCDEF" for axis in "xy"))
    assert [row for row in system.rows if "moment" in row] == [
        f"{body}, moment about {joint}" for body, joint in zip(BODIES, "OACFD", strict=True)
    ]
    assert system.matrix.shape == (15, 15)
    assert wiper.rigid.direct.matrix.shape == (17, 17)


def test_source_b_torque_and_reactions_to_all_digits_that_its_positions_have(wiper, source, exact):
    """A residual of 1e-9 leaves some 1e-8 in a torque: the last two printed digits depend on how it was iterated."""
    for sweep, near in ((source, 1e-8), (exact, 2e-8)):
        without = dynamics.inverse_dynamics(wiper, sweep)
        assert [without.torque.min(), without.torque.max()] == pytest.approx([-2.1396116335, 2.3845747939], abs=near)
        rubbing = dynamics.inverse_dynamics(wiper, sweep, friction(wiper, sweep))
        assert [rubbing.torque.min(), rubbing.torque.max()] == pytest.approx([-0.7824455265, 4.5923100587], abs=near)
        assert np.abs(rubbing.forces["E"]).max(axis=0) == pytest.approx([32.24432821, 1.50472315], abs=near)


def test_the_condition_number_of_the_15_by_15_matrix_is_at_most_67(wiper, exact):
    from mechlib.closure import compiled

    rigid = wiper.rigid
    arguments = dynamics.arguments(Wiper)
    matrices = compiled(arguments, rigid.inverse.matrix)(*dynamics.values(wiper, exact))
    assert np.linalg.cond(matrices).max() <= 67


@pytest.mark.parametrize("rubbing", [False, True], ids=["no friction", "friction"])
def test_power_and_each_body_s_balance_hold_for_200_random_crank_rockers_with_random_masses(rubbing):
    rng = np.random.default_rng(11)
    for wiper in islice(crank_rockers(rng), 200):
        q = wiper.position(TURN)
        omega, alpha = rng.uniform(1, 8), rng.uniform(-5, 5)
        motion = Motion(TURN, TURN, np.full_like(TURN, omega), np.full_like(TURN, alpha))
        rates = wiper.loop.rates(q, motion.position, motion.velocity, motion.acceleration)
        sweep = Sweep(motion, q, *rates, np.zeros(len(q), int), np.zeros(len(q)))
        loads = friction(wiper, sweep) if rubbing else None
        found = dynamics.inverse_dynamics(wiper, sweep, loads)
        balance = found.torque * omega - dynamics.power(wiper, sweep, loads)
        assert np.abs(balance).max() < 1e-12 * np.abs(found.torque).max() * omega
        largest = max(np.abs(force).max() for force in found.forces.values())
        assert np.abs(dynamics.residuals(wiper, sweep, found, loads)).max() < 1e-12 * largest


def test_a_wrong_reaction_is_seen_by_the_balance_of_its_body_and_not_by_the_power(wiper, exact):
    """Mistake B1: an arm of bar 5 twice as long changes E and D, and no power."""
    found = dynamics.inverse_dynamics(wiper, exact)
    forces = dict(found.forces)
    for joint in "DE":
        forces[joint] = forces[joint] + [0.0, 1.0]
    wrong = dynamics.Reactions(found.torque, forces)
    assert np.abs(wrong.torque * OMEGA - dynamics.power(wiper, exact)).max() < 1e-12
    assert np.abs(dynamics.residuals(wiper, exact, wrong)).max() > 0.1


def test_friction_has_its_size_and_is_against_the_motion():
    rng = np.random.default_rng(4)
    v = rng.normal(size=(50, 2))
    force = dynamics.friction(v, 4.5)
    np.testing.assert_allclose(np.linalg.norm(force, axis=1), 4.5)
    np.testing.assert_allclose((force * v).sum(axis=1), -4.5 * np.linalg.norm(v, axis=1))
    assert dynamics.friction([0.0, 0.0], 4.5).tolist() == [0.0, 0.0]
    slow = dynamics.friction([1e-6, 0.0], 4.5, v0=1e-3)
    assert slow[0] == pytest.approx(-4.5e-3, rel=1e-5)


# --- bad input --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Wiper(r2=-0.2), "r2 must be a positive number, got -0.2"),
        (lambda: Wiper(masses=Wiper().masses[:4]), "masses must be 5, of crank, coupler, .*; got 4"),
        (lambda: MassProperties(-1.0, 0.1, 0.1), "mass must be a positive number, got -1.0"),
        (lambda: grashof(5.0, 1.0, 1.5, 2.0), "the ground of 5 must be shorter than the other bars together, 4.5"),
        (lambda: grashof(1.0, 0.0, 1.0, 1.0), "driver must be a positive number, got 0.0"),
        (lambda: Wiper().position(np.nan), "theta1 must be finite, got nan"),
        (lambda: Wiper().position(0.0, "left"), "branch must be 'open' or 'crossed', got 'left'"),
        (lambda: dynamics.friction([1.0, 0.0], -4.5), "size and v0 must not be negative, got -4.5"),
    ],
)
def test_a_wiper_that_cannot_be_is_refused_with_the_value(make, says):
    with pytest.raises(ValueError, match=says):
        make()


def test_a_wiper_that_cannot_close_gives_no_number():
    with pytest.raises(OpenLoopError, match="cannot close at theta_1"):
        Wiper(r2=0.12, r3=0.12).position(TURN)


def test_loads_of_another_shape_are_refused(wiper, exact):
    with pytest.raises(ValueError, match=r"loads must be \(361, 2, 2\)"):
        dynamics.inverse_dynamics(wiper, exact, np.zeros((361, 2)))


def test_newton_from_the_seed_of_the_source_finds_the_branch_that_is_built(wiper):
    found = newton(lambda q: wiper.loop.residual(q, 1.0), lambda q: wiper.loop.jacobian(q, 1.0), SEED)
    assert wiper.branch(found.root) == "open"
