"""The consecutive sweep of source A: the verified figures, and what it says where it fails."""

import numpy as np
import pytest

from mechlib.batched import batched
from mechlib.closure import OpenLoopError
from mechlib.hacksaw import Hacksaw
from mechlib.motion import Motion, MotorProfile
from mechlib.newton import ConvergenceError, newton
from mechlib.sweep import consecutive, simultaneous

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


def test_a_sweep_whose_last_position_is_no_seed_goes_on_from_an_earlier_one_or_is_refused_at_the_point():
    """Great turns of the crank between two points, close to the singular position."""
    saw = Hacksaw(r1y=0.045, r2=0.075, r3=0.121)
    rng = np.random.default_rng(3)
    astray, refused = 0, 0
    for _ in range(200):
        angles = np.cumsum(rng.uniform(0, 3, 8))
        motion, built = Motion(np.arange(8.0), angles, np.ones(8), np.zeros(8)), saw.position(angles)
        ends = [iterated(saw, u, q) for u, q in zip(angles[1:], built[:-1], strict=True)]
        astray += np.nanmax(np.abs(ends - built[1:])) > 1e-6 or bool(np.isnan(ends).any())
        try:
            found = consecutive(saw, motion, built[0], tol=1e-9)
        except ConvergenceError as why:
            refused += 1
            assert str(why).startswith("point ")
        else:
            np.testing.assert_allclose(found.position, built, atol=1e-9)
    assert astray > 50
    assert 0 < refused < astray / 2


def iterated(saw, u, seed):
    """A position from this one seed, wherever it leads."""
    try:
        return newton(lambda q: saw.loop.residual(q, u), lambda q: saw.loop.jacobian(q, u), seed).root
    except ConvergenceError:
        return np.full(3, np.nan)


SWEEPS = pytest.mark.parametrize(
    ("sweep", "seed"),
    [(consecutive, SEED), (simultaneous, SEED + [0.0] * 6), (batched, SEED)],
    ids=lambda x: getattr(x, "__name__", ""),
)


@SWEEPS
def test_behind_the_points_that_cannot_close_a_sweep_stays_on_its_branch_and_gives_no_number_for_them(sweep, seed):
    """Coupler of 100 mm: the loop is open at 181 of the 1000 points; peers go on along the other branch behind them."""
    saw, motion = Hacksaw(r3=0.10), profile_points()
    found = sweep(saw, motion, seed, tol=1e-9, open_points="leave out")
    open_by = np.abs(R1Y - R2 * np.sin(motion.position)) - 0.10
    assert found.open_points.tolist() == np.flatnonzero(open_by > 0).tolist()
    assert len(found.open_points) == 181
    closed = open_by <= 0
    for numbers in (found.position, found.velocity, found.acceleration):
        assert np.isnan(numbers[~closed]).all()
        assert np.isfinite(numbers[closed]).all()
    exact = saw.position(motion.position[closed], "left")
    away = np.abs(np.cos(exact[:, 2]))  # near the singular position an angle is known to less
    assert (np.abs(found.position[closed] - exact).max(axis=1) * away < 1e-12).all()


@SWEEPS
def test_a_motion_along_which_the_loop_closes_nowhere_is_refused(sweep, seed):
    with pytest.raises(OpenLoopError, match="999 other points"):
        sweep(Hacksaw(r3=0.01, r2=0.01), profile_points(), seed, open_points="leave out")


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
        ({"open_points": "drop"}, "open_points must be 'refuse' or 'leave out', got 'drop'"),
    ],
)
@SWEEPS
def test_a_sweep_that_cannot_be_is_refused_with_the_value(saw, sweep, seed, change, says):
    with pytest.raises(ValueError, match=says):
        sweep(saw, profile_points(200), **{"seed": seed, **change})


def test_a_position_that_is_not_found_is_told_with_its_point(saw):
    with pytest.raises(ConvergenceError, match=r"^point 0, t = 0 s: no root after 2 iterations"):
        consecutive(saw, profile_points(3), SEED, max_iterations=2)


# --- the simultaneous solver ------------------------------------------------------------------------------------------


def test_source_a_at_rest_takes_5_iterations_of_the_simultaneous_solver(saw):
    """Its seed vector; the programs have the last six with opposite signs, and as many iterations."""
    rest, first = Motion([0.0], [0.0], [0.0], [0.0]), [-0.1, -0.5, 3.0, 0.5, 0, -0.5, 0.5, 0, -0.5]
    for signs in (1, -1):
        found = simultaneous(saw, rest, [*first[:3], *(signs * x for x in first[3:])])
        assert found.iterations.tolist() == [5]
        assert [f"{x:.6f}" for x in found.position[0]] == ["-0.099672", "-0.468422", "2.873694"]
        assert np.abs([found.velocity, found.acceleration]).max() < 1e-9


@pytest.fixture(scope="module")
def together(saw):
    return simultaneous(saw, profile_points(), [-0.0997, -0.4684, 2.8737] + [0.0] * 6)


def test_source_a_figure_13_the_two_solvers_differ_by_some_1e_12(swept, together):
    nine = [np.hstack((s.position, s.velocity, s.acceleration)) for s in (swept, together)]
    differences = np.linalg.norm(nine[0] - nine[1], axis=1)
    assert 1e-13 < differences.max() < 2e-11  # 1.7e-12 is verified; a factor of ten for another processor


def test_source_a_figure_11_the_simultaneous_error_stays_below_the_tolerance_and_is_usually_the_larger(swept, together):
    assert together.errors.max() < 1e-6
    more = swept.iterations != together.iterations
    assert np.mean(together.errors > swept.errors) > 0.7
    assert more.sum() > 0


def test_the_simultaneous_solver_takes_2_to_4_iterations_a_point(together):
    counts = np.bincount(together.iterations, minlength=5)
    assert counts[:2].sum() == 0
    np.testing.assert_allclose(counts[2:], [16, 945, 39], atol=3)  # rounding may decide a step near the tolerance


def test_source_a_figures_15_to_17_both_solvers_against_the_closed_form(saw, swept, together):
    motion = swept.motion
    exact = saw.closed_form(motion.position, motion.velocity, motion.acceleration)
    names = ("position", "velocity", "acceleration")
    for name, right, bound in zip(names, exact, (1e-14, 1e-14, 1e-13), strict=True):
        assert np.abs(getattr(together, name) - right).max() < 10 * bound  # round-off: within a factor of ten
    assert np.abs(swept.position - exact[0]).max() < 1e-11  # the square of the tolerance


def test_the_closed_form_gives_the_rates_of_the_linear_solves(saw):
    rng = np.random.default_rng(2)
    for branch in ("left", "right"):
        theta2, omega2, alpha2 = rng.normal(scale=5, size=(3, 400))
        q, v, a = saw.closed_form(theta2, omega2, alpha2, branch)
        np.testing.assert_array_equal(q, saw.position(theta2, branch))
        for mine, theirs in zip((v, a), saw.loop.rates(q, theta2, omega2, alpha2), strict=True):
            np.testing.assert_allclose(mine, theirs, rtol=0, atol=1e-12 * np.abs(theirs).max())
