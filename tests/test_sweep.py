"""The consecutive sweep of source A: the verified figures, and what it says where it fails."""

import numpy as np
import pytest

from mechlib.closure import OpenLoopError
from mechlib.hacksaw import Hacksaw
from mechlib.motion import Motion, MotorProfile
from mechlib.newton import ConvergenceError, newton
from mechlib.sweep import consecutive

SEED = [-0.1, -0.5, 3.0]  # source A, eq. (16)
R1Y, R2, R3 = 0.045, 0.075, 0.170
DEGREES = np.array([1, 180 / np.pi, 180 / np.pi])


def profile_points(points=1000):
    profile = MotorProfile.through()
    return profile.at(np.linspace(0, 2 * profile.T, points))


@pytest.fixture(scope="module")
def saw():
    return Hacksaw()


@pytest.fixture(scope="module")
def swept(saw):
    return consecutive(saw, profile_points(), SEED)


def test_source_a_at_rest_takes_4_iterations_for_the_position_2_for_the_velocity_and_2_for_the_acceleration():
    """Newton-Raphson on the printed equations (7) to (15), one stage after the other; the source counts 4, 2 and 4."""
    r1, th1, th3 = q = newton(
        lambda q: [
            -q[0] * np.cos(q[1]) + R2 + R3 * np.cos(q[2]),
            q[0] * np.sin(q[1]) - R3 * np.sin(q[2]),
            q[0] * np.sin(q[1]) - R1Y,
        ],
        lambda q: [
            [-np.cos(q[1]), q[0] * np.sin(q[1]), -R3 * np.sin(q[2])],
            [np.sin(q[1]), q[0] * np.cos(q[1]), -R3 * np.cos(q[2])],
            [np.sin(q[1]), q[0] * np.cos(q[1]), 0],
        ],
        SEED,
        tol=1e-6,
    ).root
    matrix = np.array(
        [
            [-np.cos(th1), r1 * np.sin(th1), -R3 * np.sin(th3)],
            [np.sin(th1), r1 * np.cos(th1), -R3 * np.cos(th3)],
            [np.sin(th1), r1 * np.cos(th1), 0],
        ]
    )

    def gamma(v):  # the crank is at rest
        vr, w1, w3 = v
        along = r1 * w1**2 * np.array([np.cos(th1), -np.sin(th1), -np.sin(th1)])
        coriolis = 2 * vr * w1 * np.array([np.sin(th1), np.cos(th1), np.cos(th1)])
        return along + coriolis + R3 * w3**2 * np.array([-np.cos(th3), np.sin(th3), 0])

    velocity = newton(lambda v: matrix @ v, lambda v: matrix, [0.5, 0, -0.5], tol=1e-6)
    acceleration = newton(lambda a: matrix @ a + gamma(velocity.root), lambda a: matrix, [0.5, 0, -0.5], tol=1e-6)
    assert (velocity.iterations, acceleration.iterations) == (2, 2)
    assert np.abs([*velocity.root, *acceleration.root]).max() < 1e-15
    assert q == pytest.approx([-0.09967249135979, -0.46842178054592, 2.87369374118380], abs=1e-13)


def test_source_a_position_at_rest_takes_four_iterations_of_the_sweep(saw):
    rest = Motion([0.0], [0.0], [0.0], [0.0])
    found = consecutive(saw, rest, SEED)
    assert found.iterations.tolist() == [4]
    assert np.abs(found.velocity).max() == np.abs(found.acceleration).max() == 0


@pytest.mark.parametrize(
    ("quantity", "lowest", "highest", "digits"),
    [
        ("position", [-0.24499996, -28.2736, 135.0995], [-0.09500025, -10.5838, 190.1642], (8, 4, 4)),
        ("velocity", [-0.477940, -75.8712, -171.4134], [0.604780, 53.8392, 171.4111], (6, 4, 4)),
        ("acceleration", [-3.388934, -380.790, -1075.704], [4.609808, 640.015, 1494.771], (6, 3, 3)),
    ],
)
def test_the_ranges_of_the_sweep_to_the_verified_digits(swept, quantity, lowest, highest, digits):
    values = getattr(swept, quantity) * DEGREES
    for column, (low, high, places) in enumerate(zip(lowest, highest, digits, strict=True)):
        assert f"{values[:, column].min():.{places}f}" == f"{low:.{places}f}"
        assert f"{values[:, column].max():.{places}f}" == f"{high:.{places}f}"


def test_every_step_norm_falls_below_the_tolerance_and_the_positions_are_far_better(saw, swept):
    assert swept.errors.max() < 1e-6
    assert np.abs(swept.position - saw.position(swept.motion.position)).max() < 1e-11  # quadratic: some 1e-6 squared


def test_with_a_tighter_tolerance_the_loop_is_closed_to_1e_14_of_its_scale(saw):
    found = consecutive(saw, profile_points(), SEED, tol=1e-9)
    x, y = np.cos(found.motion.position), np.sin(found.motion.position)
    r1, th1, th3 = found.position.T
    open_by = [
        r1 * np.cos(th1) - R2 * x - R3 * np.cos(th3),
        r1 * np.sin(th1) - R2 * y - R3 * np.sin(th3),
        r1 * np.sin(th1) - R1Y,
    ]
    assert np.abs(open_by).max() < 1e-14 * (R1Y + R2 + R3)


def test_velocity_and_acceleration_are_the_time_derivatives_of_the_position(saw):
    """Central differences of order two: their error is h^2/6 of the third derivative, and falls with the square."""
    profile, middle = MotorProfile.through(), np.linspace(0.01, 3.8, 379)
    corners = profile.T / 3 * np.arange(1, 4)
    errors = []
    for h in (1e-3, 5e-4):
        behind, here, ahead = (consecutive(saw, profile.at(middle + d), SEED, tol=1e-9) for d in (-h, 0, h))
        clear = np.abs(middle[:, None] - corners).min(axis=1) > h  # the jerk leaps at a corner of alpha
        v = (ahead.position - behind.position) / (2 * h) - here.velocity
        a = (ahead.velocity - behind.velocity) / (2 * h) - here.acceleration
        errors.append([np.abs(v[clear]).max(), np.abs(a[clear]).max()])
    assert np.max(errors) < 2e-3
    np.testing.assert_allclose(np.log2(np.divide(*errors)), 2, atol=0.05)


def test_a_sweep_starts_each_position_from_the_one_before(saw, monkeypatch):
    from mechlib import sweep

    seeds = []

    def spy(residual, jacobian, seed, *rest, **options):
        seeds.append(np.array(seed))
        return newton(residual, jacobian, seed, *rest, **options)

    monkeypatch.setattr(sweep, "newton", spy)
    found = consecutive(saw, profile_points(50), SEED)
    assert np.array_equal(seeds[0], SEED)
    assert np.array_equal(seeds[1:], found.position[:-1])


def test_the_seed_chooses_the_branch_of_the_whole_sweep(saw):
    motion = profile_points(200)
    for seed, branch in ((SEED, "left"), ([0.24, 0.2, 0.2], "right")):
        found = consecutive(saw, motion, seed)
        np.testing.assert_allclose(found.position, saw.position(motion.position, branch), atol=1e-9)


def test_a_sweep_that_leaves_its_branch_is_refused_at_the_point(saw):
    """The crank is turned half round between two points: the last position is no seed for the next."""
    saw = Hacksaw(r1y=0.045, r2=0.075, r3=0.121)
    rng = np.random.default_rng(3)
    refused = 0
    for _ in range(200):
        angles = np.cumsum(rng.uniform(0, 3, 8))
        motion = Motion(np.arange(8.0), angles, np.ones(8), np.zeros(8))
        try:
            found = consecutive(saw, motion, saw.position(angles[0]))
        except ConvergenceError as why:
            refused += 1
            assert str(why).startswith("point ")
        else:
            assert (saw.branch(found.position) == "left").all()
    assert refused > 10


def test_a_loop_that_cannot_close_is_refused_before_anything_is_solved():
    motion = profile_points()
    with pytest.raises(OpenLoopError, match="180 other points") as raised:
        consecutive(Hacksaw(r3=0.10), motion, SEED)
    assert len(raised.value.points) == 181
    assert (np.abs(R1Y - R2 * np.sin(motion.position[raised.value.points])) > 0.10).all()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"seed": [np.nan, 0, 0]}, "seed must be finite, got nan at index 0"),
        ({"tol": 0.0}, "tol must be positive, got 0.0"),
        ({"max_iterations": 0}, "max_iterations must be positive, got 0"),
    ],
)
def test_a_sweep_that_cannot_be_is_refused_with_the_value(saw, change, says):
    with pytest.raises(ValueError, match=says):
        consecutive(saw, profile_points(3), **{"seed": SEED, **change})


def test_a_position_that_is_not_found_is_told_with_its_point(saw):
    with pytest.raises(ConvergenceError, match=r"^point 0, t = 0 s: no root after 2 iterations"):
        consecutive(saw, profile_points(3), SEED, max_iterations=2)
