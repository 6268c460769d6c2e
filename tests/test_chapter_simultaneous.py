"""Claims of the chapter on the simultaneous solution, proven without the code that the chapter calls."""

import numpy as np
import pytest
import sympy as sp

R1Y, R2, R3 = 0.045, 0.075, 0.170  # m, source A
SEED = np.array([-0.1, -0.5, 3, 0.5, 0, -0.5, 0.5, 0, -0.5])
START = np.array([-0.0997, -0.4684, 2.8737, 0, 0, 0, 0, 0, 0])  # listing E.4
AT_REST = (0.0, 0.0, 0.0)
T = np.sqrt(6 * np.pi / 5)
TIMES = np.linspace(0, 2 * T, 1000)

# the loop as functions of the time, differentiated by it; then each derivative gets a name of its own
t = sp.Symbol("t")
PATHS = [sp.Function(name)(t) for name in ("length", "line", "coupler", "crank")]
_r, _line, _coupler, _crank = PATHS
CLOSURE = sp.Matrix(
    [
        -_r * sp.cos(_line) + R2 * sp.cos(_crank) + R3 * sp.cos(_coupler),
        _r * sp.sin(_line) - R2 * sp.sin(_crank) - R3 * sp.sin(_coupler),
        _r * sp.sin(_line) - R1Y,
    ]
)
NAMES = sp.symbols("r1 th1 th3 th2 vr w1 w3 w2 ar al1 al3 al2")
UNKNOWNS = [NAMES[k] for k in (0, 1, 2, 4, 5, 6, 8, 9, 10)]
CRANK = [NAMES[k] for k in (3, 7, 11)]


def named(expression):
    for order in (2, 1, 0):
        symbols = NAMES[4 * order : 4 * order + 4]
        expression = expression.subs({path.diff(t, order): s for path, s in zip(PATHS, symbols, strict=True)})
    return expression


LEVELS = [named(CLOSURE.diff(t, order)) for order in range(3)]
NINE = sp.Matrix.vstack(*LEVELS)
JACOBIANS = [named(CLOSURE.jacobian(PATHS[:3]).diff(t, order)) for order in range(3)]  # J and its derivatives by time


def function(matrix):
    compiled = sp.lambdify((UNKNOWNS, CRANK), matrix, cse=True)
    return lambda x, crank: np.squeeze(compiled(x, crank))


RESIDUAL, MATRIX = function(NINE), function(NINE.jacobian(UNKNOWNS))


def diagonal(x, crank):
    keep = np.kron(np.eye(3), np.ones((3, 3)))
    return MATRIX(x, crank) * keep


def source_system():
    """Rows Fc, Fx, Fy, Fx', Fy', Fc', Fc'', Fx'', Fy''; r1 eliminated from the second and the third."""
    (fx, fy, fc), (dfx, dfy, dfc), (ddfx, ddfy, ddfc) = LEVELS
    gone = {NAMES[0]: R1Y / sp.sin(NAMES[1])}
    return function(sp.Matrix([fc, fx.subs(gone), fy.subs(gone), dfx, dfy, dfc, ddfc, ddfx, ddfy]))


SOURCE = source_system()


def appendix_d(x, crank, repaired=False):
    """As printed."""
    r1, th1, th3, vr, w1, w3, ar, al1, al3 = x
    s1, c1, s3, c3 = np.sin(th1), np.cos(th1), np.sin(th3), np.cos(th3)
    sg1 = -r1 * c1 * w1**2 - 2 * vr * s1 * w1 + ar * c1 - al1 * r1 * s1
    sg2 = 2 * vr * c1 - 2 * w1 * r1 * s1
    sg3 = al1 * c1 - w1**2 * s1
    sg4, sg5 = -R3 * s3, -R3 * c3
    sg6, sg7 = vr * c1 - w1 * r1 * s1, 2 * w1 * c1
    first = [c1 * w1**2 + al1 * s1, 0, w3**2 * R3 * s3 - al3 * R3 * c3]
    first[1] = -r1 * s1 * w1**2 + 2 * vr * c1 * w1 + ar * s1 + al1 * r1 * c1
    two = (s1, r1 * c1) if repaired else (sg7, c1)
    return np.array(
        [
            [s1, r1 * c1, 0, 0, 0, 0, 0, 0, 0],
            [0, R1Y * (1 / np.tan(th1) ** 2 + 1), sg4, 0, 0, 0, 0, 0, 0],
            [0, 0, sg5, 0, 0, 0, 0, 0, 0],
            [w1 * s1, vr * s1 + w1 * r1 * c1, -w3 * R3 * c3, -c1, r1 * s1, sg4, 0, 0, 0],
            [w1 * c1, sg6, w3 * R3 * s3, s1, r1 * c1, sg5, 0, 0, 0],
            [w1 * c1, sg6, 0, s1, r1 * c1, 0, 0, 0, 0],
            [sg3, sg1, 0, sg7, sg2, 0, *two, 0],
            [*first, 2 * w1 * s1, 2 * vr * s1 + 2 * w1 * r1 * c1, -2 * w3 * R3 * c3, -c1, r1 * s1, sg4],
            [sg3, sg1, R3 * c3 * w3**2 + al3 * R3 * s3, sg7, sg2, 2 * w3 * R3 * s3, s1, r1 * c1, sg5],
        ]
    )


def complex_step(residual, x, crank):
    """Derivatives without subtraction: the imaginary part of f(x + ih), divided by h."""
    columns = [np.imag(residual(x + 1e-30j * unit, crank)) / 1e-30 for unit in np.eye(len(x))]
    return np.stack(columns, axis=-1)


def motor(time):
    """theta2, omega2, alpha2, from the polynomials of source A as they should be."""
    pieces = [time < T / 3, time < 2 * T / 3, time < T]
    theta = (
        5 * time**3 / (2 * T),
        5 * time**2 / 2 - 5 * T * time / 6 + 5 * T**2 / 54,
        15 * time**2 / 2 - 25 * T * time / 6 - 5 * time**3 / (2 * T) + 5 * T**2 / 6,
    )
    omega = (
        15 * time**2 / (2 * T),
        5 * time - 5 * T / 6,
        15 * time - 25 * T / 6 - 15 * time**2 / (2 * T),
    )
    alpha = (15 * time / T, np.full_like(time, 5), 15 - 15 * time / T)
    ends = (10 * T * time / 3 - 5 * T**2 / 3, np.full_like(time, 10 * T / 3), np.zeros_like(time))
    levels = zip((theta, omega, alpha), ends, strict=True)
    return np.stack([np.select(pieces, first, last) for first, last in levels], axis=-1)


CRANKS = motor(TIMES)


def exact():
    """The nine unknowns from x(theta2), differentiated by SymPy."""
    u, w, a = sp.symbols("u w a")
    theta3 = sp.pi - sp.asin((R1Y - R2 * sp.sin(u)) / R3)
    x = R2 * sp.cos(u) + R3 * sp.cos(theta3)
    q = sp.Matrix([-sp.sqrt(x**2 + R1Y**2), sp.atan(R1Y / x), theta3])
    rates = [*q, *(q.diff(u) * w), *(q.diff(u, 2) * w**2 + q.diff(u) * a)]
    return np.stack(np.broadcast_arrays(*sp.lambdify((u, w, a), rates, cse=True)(*CRANKS.T)), axis=-1)


EXACT = exact()


def iterate(residual, matrix, crank, x, tol=1e-6, most=50):
    """Iterates and the norms of the steps."""
    path, sizes = [np.array(x, dtype=float)], []
    while len(sizes) < most and not (sizes and sizes[-1] < tol):
        d = np.linalg.solve(matrix(path[-1], crank), residual(path[-1], crank))
        path.append(path[-1] - d)
        sizes.append(np.linalg.norm(d))
    return np.array(path), np.array(sizes)


def position_alone(crank, q, tol=1e-6):
    """The first three equations; the rates, which do not occur in them, are anything."""
    rest = np.zeros(6)
    return iterate(
        lambda q, crank: RESIDUAL([*q, *rest], crank)[:3],
        lambda q, crank: MATRIX([*q, *rest], crank)[:3, :3],
        crank,
        q,
        tol,
    )


def follow(guess=lambda x: x, matrix=MATRIX, tol=1e-6):
    """Solution, iterations and last step of each instant."""
    x, found = START, []
    for k, crank in enumerate(CRANKS):
        path, sizes = iterate(RESIDUAL, matrix, crank, guess(x) if k else START, tol)
        x = path[-1]
        found.append((x, len(sizes), sizes[-1]))
    return tuple(map(np.array, zip(*found, strict=True)))


def stage_by_stage(tol=1e-6):
    q, found = START[:3], []
    for crank in CRANKS:
        path, sizes = position_alone(crank, q, tol)
        q = path[-1]
        x = np.concatenate((q, np.zeros(6)))
        for level in (3, 6):  # linear: one solve each
            here = slice(level, level + 3)
            x[here] = np.linalg.solve(MATRIX(x, crank)[here, here], -RESIDUAL(x, crank)[here])
        found.append((x, len(sizes), sizes[-1]))
    return tuple(map(np.array, zip(*found, strict=True)))


@pytest.fixture(scope="module")
def together():
    return follow()


@pytest.fixture(scope="module")
def consecutive():
    return stage_by_stage()


# --- the printed matrix -----------------------------------------------------------------------------------------------


def test_appendix_d_differs_from_the_derivatives_in_two_entries_of_row_7():
    rng = np.random.default_rng(1)
    for _ in range(20):
        x, crank = rng.normal(size=9), rng.normal(size=3)
        right = complex_step(SOURCE, x, crank)
        off = np.abs(appendix_d(x, crank) - right) > 1e-12 * np.abs(right).max()
        assert (np.argwhere(off) + 1).tolist() == [[7, 7], [7, 8]]
        np.testing.assert_allclose(appendix_d(x, crank, repaired=True), right, atol=1e-12 * np.abs(right).max())


def test_at_rest_21_of_the_45_entries_can_be_seen():
    moving = complex_step(SOURCE, np.random.default_rng(2).normal(size=9), np.ones(3))
    resting = complex_step(SOURCE, EXACT[0], AT_REST)
    assert [int((np.abs(m) > 1e-13).sum()) for m in (moving, resting)] == [45, 21]


def test_with_the_printed_matrix_positions_and_velocities_converge_and_the_accelerations_do_not():
    path, sizes = iterate(SOURCE, appendix_d, AT_REST, SEED)
    assert len(sizes) == 50
    np.testing.assert_allclose(path[-1][:6], EXACT[0][:6], atol=1e-12)
    assert path[-1][7] == pytest.approx(5.80, abs=0.01)
    assert sizes[-1] / sizes[-2] == pytest.approx(1.109923, abs=1e-6)
    r1, th1, th3 = EXACT[0][:3]
    assert 1 - r1 * np.cos(th3) / (np.cos(th1) * np.cos(th1 - th3)) == pytest.approx(1.109923, abs=1e-6)


def test_with_the_printed_matrix_no_instant_of_the_motion_attracts():
    radii = []
    for x, crank in zip(EXACT, CRANKS, strict=True):
        factor = np.eye(9) - np.linalg.solve(appendix_d(x, crank), appendix_d(x, crank, repaired=True))
        eigenvalues = np.linalg.eigvals(factor)
        radii.append(np.abs(eigenvalues).max())
        assert (np.abs(eigenvalues) > 1e-6).sum() == 1  # rank one
    assert (min(radii), max(radii)) == (pytest.approx(1.085, abs=1e-3), pytest.approx(1.246, abs=1e-3))


@pytest.mark.parametrize("signs", [1, -1])
def test_repaired_it_takes_5_iterations_like_the_equations_with_r1(signs):
    seed = np.concatenate((SEED[:3], signs * SEED[3:]))
    repaired = iterate(SOURCE, lambda x, crank: appendix_d(x, crank, repaired=True), AT_REST, seed)
    for path, sizes in (repaired, iterate(RESIDUAL, MATRIX, AT_REST, seed)):
        assert len(sizes) == 5
        assert [f"{value:.6f}" for value in path[-1][:3]] == ["-0.099672", "-0.468422", "2.873694"]
        np.testing.assert_allclose(path[-1][3:], 0, atol=1e-12)


# --- the blocks -------------------------------------------------------------------------------------------------------


def test_the_blocks_are_those_of_the_product_rule():
    binomial = [[1, 0, 0], [1, 1, 0], [1, 2, 1]]
    whole = sp.zeros(9)
    for i in range(3):
        for j in range(i + 1):
            whole[3 * i : 3 * i + 3, 3 * j : 3 * j + 3] = binomial[i][j] * JACOBIANS[i - j]
    assert (NINE.jacobian(UNKNOWNS) - whole).expand() == sp.zeros(9)


def test_the_determinant_is_the_cube_of_that_of_the_position():
    rng = np.random.default_rng(3)
    for _ in range(20):
        matrix = MATRIX(rng.normal(size=9), rng.normal(size=3))
        assert np.linalg.det(matrix) == pytest.approx(np.linalg.det(matrix[:3, :3]) ** 3, rel=1e-9)


def test_the_positions_are_iterated_as_if_they_were_alone():
    alone, sizes = position_alone(AT_REST, SEED[:3])
    path, _ = iterate(RESIDUAL, MATRIX, AT_REST, SEED)
    assert len(sizes) == 4
    np.testing.assert_allclose(path[:5, :3], alone, atol=1e-14)


def test_a_step_can_be_taken_block_by_block():
    x, crank = EXACT[300] + 0.1, CRANKS[300]
    jacobian, first, second = (function(matrix)(x, crank) for matrix in JACOBIANS)
    f, df, ddf = np.split(RESIDUAL(x, crank), 3)
    dq = np.linalg.solve(jacobian, f)
    dv = np.linalg.solve(jacobian, df - first @ dq)
    da = np.linalg.solve(jacobian, ddf - second @ dq - 2 * first @ dv)
    whole = np.linalg.solve(MATRIX(x, crank), RESIDUAL(x, crank))
    np.testing.assert_allclose(np.concatenate((dq, dv, da)), whole, rtol=1e-9)


def test_without_the_coupling_a_linear_error_is_gone_after_three_steps():
    x, crank = EXACT[300], CRANKS[300]
    factor = np.eye(9) - np.linalg.solve(diagonal(x, crank), MATRIX(x, crank))
    assert np.abs(np.linalg.matrix_power(factor, 2)).max() > 1
    np.testing.assert_allclose(np.linalg.matrix_power(factor, 3), 0, atol=1e-12)


def test_without_the_coupling_rest_takes_one_iteration_less_and_motion_two_more():
    near = np.concatenate((EXACT[300, :3] + 0.03, np.zeros(6)))
    for crank, start, counts in ((AT_REST, SEED, (5, 4)), (CRANKS[300], near, (4, 6))):
        assert tuple(len(iterate(RESIDUAL, m, crank, start)[1]) for m in (MATRIX, diagonal)) == counts


# --- one point --------------------------------------------------------------------------------------------------------


def test_the_products_of_the_equations_are_those_that_the_errors_are_read_from():
    """Velocity equations: q q and q v. Acceleration equations: q q, q v, v v and q a."""
    groups = [UNKNOWNS[k : k + 3] for k in (0, 3, 6)]

    def products(equations):
        second = {
            (i, j)
            for i in range(3)
            for j in range(i, 3)
            if any(f.diff(x).diff(y) != 0 for f in equations for x in groups[i] for y in groups[j])
        }
        return second

    assert [products(level) for level in LEVELS] == [{(0, 0)}, {(0, 0), (0, 1)}, {(0, 0), (0, 1), (1, 1), (0, 2)}]


def test_the_accelerations_are_the_last_to_satisfy_the_tolerance():
    path, _ = iterate(RESIDUAL, MATRIX, AT_REST, SEED)
    steps = np.linalg.norm(np.diff(path, axis=0).reshape(-1, 3, 3), axis=2)
    assert (steps[3, :2] < 1e-6).all()
    assert steps[3, 2] > 1e-6
    ratio = steps[1:4] / steps[1:4, :1]
    assert ((0.1 < ratio[:, 2] / ratio[:, 1] ** 2) & (ratio[:, 2] / ratio[:, 1] ** 2 < 1)).all()


def test_rates_ten_times_as_far_off_make_the_last_steps_a_hundred_times_as_long():
    steps = {}
    for factor, count in ((0, 4), (1, 5), (10, 5), (100, 5)):
        sizes = iterate(RESIDUAL, MATRIX, AT_REST, np.concatenate((SEED[:3], factor * SEED[3:])))[1]
        assert len(sizes) == count
        steps[factor] = sizes
    np.testing.assert_allclose(steps[100][2:4] / steps[10][2:4], 100, rtol=0.02)
    np.testing.assert_allclose(steps[10][2:4] / steps[1][2:4], 100, rtol=0.15)


def test_from_the_exact_position_wrong_rates_take_three_iterations():
    x = np.concatenate((EXACT[300, :3], np.full(6, 100.0)))
    path, sizes = iterate(RESIDUAL, MATRIX, CRANKS[300], x)
    assert len(sizes) == 3
    np.testing.assert_allclose(path[1, :6], EXACT[300, :6], atol=1e-9)
    assert np.abs(path[1, 6:] - EXACT[300, 6:]).max() > 1
    np.testing.assert_allclose(path[2], EXACT[300], atol=1e-6)


# --- along the motion -------------------------------------------------------------------------------------------------


def test_the_iterations_of_both_solvers(together, consecutive):
    for (_, counts, _), expected in ((together, [0, 0, 16, 945, 39]), (consecutive, [0, 3, 115, 882, 0])):
        np.testing.assert_allclose(np.bincount(counts, minlength=5), expected, atol=4)  # rounding may decide a step


DT = TIMES[1]


def ahead(x):
    q, v, a = np.split(x, 3)
    return np.concatenate((q + v * DT + a * DT**2 / 2, v + a * DT, a))


@pytest.mark.parametrize(
    ("guess", "matrix", "total"),
    [
        (lambda x: np.concatenate((x[:3], np.zeros(6))), MATRIX, 3878),
        (ahead, MATRIX, 2283),
        (lambda x: x, diagonal, 4798),
    ],
    ids=["rates zero", "predicted", "diagonal blocks"],
)
def test_what_a_seed_of_the_rates_is_worth(guess, matrix, total):
    x, counts, _ = follow(guess, matrix)
    assert counts.sum() == pytest.approx(total, abs=6)
    np.testing.assert_allclose(x, EXACT, atol=1e-9)


def test_after_equally_many_iterations_the_simultaneous_step_is_the_larger(together, consecutive):
    (_, counts, steps), (_, counts_alone, steps_alone) = together, consecutive
    extra = counts - counts_alone
    assert set(extra) == {0, 1}
    larger = steps > steps_alone
    assert larger[1:][extra[1:] == 0].all()  # at rest, from zeros, the six rates add nothing: the two are equal
    assert not larger[extra == 1].any()
    assert larger.mean() == pytest.approx(0.856, abs=0.005)
    assert max(steps.max(), steps_alone.max()) < 1e-6


def test_the_difference_of_the_solvers_is_the_error_that_the_consecutive_one_carries(together, consecutive):
    (x, counts, _), (y, counts_alone, steps_alone) = together, consecutive
    difference = np.linalg.norm(x - y, axis=1)
    assert 1e-12 < difference.max() < 3e-12
    assert np.abs(x - EXACT).max() < 2e-13
    clear = difference > 1e-13
    assert clear.sum() == pytest.approx(36, abs=2)
    assert steps_alone[clear].min() > 2.4e-7
    assert (counts - counts_alone)[clear].all()
    for k in np.flatnonzero(clear):
        matrix = MATRIX(EXACT[k], CRANKS[k])
        right = np.concatenate((matrix[:3, :3] @ (y - EXACT)[k, :3], np.zeros(6)))
        assert difference[k] == pytest.approx(np.linalg.norm(np.linalg.solve(matrix, right)), rel=0.03)


def test_the_difference_follows_the_square_of_the_tolerance(together, consecutive):
    assert np.linalg.norm(together[0] - consecutive[0], axis=1).max() < 20 * 1e-6**2
    coarse = np.linalg.norm(follow(tol=1e-4)[0] - stage_by_stage(1e-4)[0], axis=1).max()
    assert 5 * 1e-4**2 < coarse < 20 * 1e-4**2
