"""Exercise 6: other right ways get full points, and ways that only look right do not."""

import math

import numpy as np
import pytest
import sympy as sp
from judging import judged
from scipy.linalg import lu_factor, lu_solve, solve_triangular
from scipy.optimize._numdiff import approx_derivative

from autograder.checks import task

DRAWS = [f"route {n}" for n in range(10)]


def faults(assessment):
    return [finding.fault for finding in assessment.findings if finding.fault]


# --- nine equations


def by_complex_numbers(state, crank, lengths):
    """r1 e^(i th1) - r2 e^(i th2) - r3 e^(i th3), differentiated as a whole."""

    def vector(r, dr, ddr, th, w, al):
        unit = np.exp(1j * th)
        return r * unit, (dr + 1j * r * w) * unit, (ddr - r * w**2 + 1j * (r * al + 2 * dr * w)) * unit

    r1y, r2, r3 = lengths
    r1, th1, th3, vr, w1, w3, ar, al1, al3 = state
    line, pin, coupler = (
        vector(r1, vr, ar, th1, w1, al1),
        vector(r2, 0, 0, *crank),
        vector(r3, 0, 0, th3, w3, al3),
    )
    found = []
    for level in range(3):
        gap = line[level] - pin[level] - coupler[level]
        found += [-gap.real, gap.imag, line[level].imag - (r1y if level == 0 else 0)]
    return found


def by_matrices_of_exercise_5(state, crank, lengths):
    """J v + F_u omega2 and J a + gamma."""
    q, v, a = np.reshape(state, (3, 3))
    (r1, th1, th3), (vr, w1, w3), (th2, w2, al2), (r1y, r2, r3) = q, v, crank, lengths
    own = position_jacobian(q, r3)
    x = r2 * np.cos(th2) + r3 * np.cos(th3) - r1 * np.cos(th1)
    y = r1 * np.sin(th1) - r2 * np.sin(th2) - r3 * np.sin(th3)
    drive = -r2 * np.array([math.sin(th2), math.cos(th2), 0])
    guide = 2 * vr * w1 * np.cos(th1) - r1 * w1**2 * np.sin(th1)
    gamma = drive * al2 + w2**2 * r2 * np.array([-math.cos(th2), math.sin(th2), 0]) + [0, guide, guide]
    gamma[0] += 2 * vr * w1 * np.sin(th1) + r1 * w1**2 * np.cos(th1) - r3 * w3**2 * np.cos(th3)
    gamma[1] += r3 * w3**2 * np.sin(th3)
    return np.hstack(([x, y, r1 * np.sin(th1) - r1y], own @ v + drive * w2, own @ a + gamma))


def position_jacobian(q, r3):
    r1, th1, th3 = q
    c1, s1 = math.cos(th1), math.sin(th1)
    return np.array([[-c1, r1 * s1, -r3 * math.sin(th3)], [s1, r1 * c1, -r3 * math.cos(th3)], [s1, r1 * c1, 0]])


T = sp.Symbol("t")
UNKNOWN = [sp.Function(name)(T) for name in ("r1", "theta1", "theta3")]
TURN = sp.Function("theta2")(T)
SIZES = sp.symbols("r1y r2 r3")


def symbols_at(state, crank, lengths):
    values = np.reshape(state, (3, 3))
    found = dict(zip(SIZES, lengths, strict=True))
    for order in (2, 1, 0):  # the derivatives before what they are derivatives of
        for function, number in zip((*UNKNOWN, TURN), (*values[order], crank[order]), strict=True):
            found[function.diff(T, order) if order else function] = number
    return found


def closure_of_time():
    (r1, th1, th3), (r1y, r2, r3) = UNKNOWN, SIZES
    position = sp.Matrix(
        [
            -r1 * sp.cos(th1) + r2 * sp.cos(TURN) + r3 * sp.cos(th3),
            r1 * sp.sin(th1) - r2 * sp.sin(TURN) - r3 * sp.sin(th3),
            r1 * sp.sin(th1) - r1y,
        ]
    )
    return sp.Matrix.vstack(position, position.diff(T), position.diff(T, 2))


OF_TIME = closure_of_time()
STATE_OF_TIME = [q.diff(T, order) if order else q for order in range(3) for q in UNKNOWN]


def by_functions_of_time(state, crank, lengths):
    """SymPy differentiates by the time itself."""
    return np.array(OF_TIME.subs(symbols_at(state, crank, lengths)).evalf(), dtype=float).ravel()


# --- their Jacobian


def by_sympy(state, crank, lengths):
    return np.array(OF_TIME.jacobian(STATE_OF_TIME).subs(symbols_at(state, crank, lengths)).evalf(), dtype=float)


def by_complex_steps(state, crank, lengths):
    """No difference is formed, so that the step may be tiny: a list of columns, in a list of lists."""
    matrix = [[0.0] * 9 for _ in range(9)]
    for j in range(9):
        ahead = [complex(x, 1e-30 * (i == j)) for i, x in enumerate(state)]
        for i, value in enumerate(by_sines(ahead, crank, lengths)):
            matrix[i][j] = value.imag / 1e-30
    return matrix


def by_sines(state, crank, lengths):
    """The equations once more, in functions that take complex numbers."""
    r1, th1, th3, vr, w1, w3, ar, al1, al3 = np.array(state)
    r3 = lengths[2]
    x1 = [np.cos(th1), -w1 * np.sin(th1), -al1 * np.sin(th1) - w1**2 * np.cos(th1)]
    y1 = [np.sin(th1), w1 * np.cos(th1), al1 * np.cos(th1) - w1**2 * np.sin(th1)]
    x3 = [np.cos(th3), -w3 * np.sin(th3), -al3 * np.sin(th3) - w3**2 * np.cos(th3)]
    y3 = [np.sin(th3), w3 * np.cos(th3), al3 * np.cos(th3) - w3**2 * np.sin(th3)]

    def times_r1(z):  # Leibniz
        return [r1 * z[0], vr * z[0] + r1 * z[1], ar * z[0] + 2 * vr * z[1] + r1 * z[2]]

    left, height = times_r1(x1), times_r1(y1)  # what does not depend on the unknowns is left out
    return [e for k in range(3) for e in (r3 * x3[k] - left[k], height[k] - r3 * y3[k], height[k])]


def by_central_differences(state, crank, lengths):
    return approx_derivative(lambda x: by_matrices_of_exercise_5(x, crank, lengths), state, method="3-point")


# --- one point


def by_lu_in_place(residual, jacobian, crank, seed, tol=1e-6):
    """It looks once more at where it arrived."""
    x, count, length = np.array(seed, dtype=float), 0, np.inf
    while length >= tol:
        count += 1
        matrix = jacobian(x, crank)
        if count > 100 or np.linalg.matrix_rank(matrix, tol=1e-14) < 9:
            raise OverflowError("no state")
        step = lu_solve(lu_factor(matrix), residual(x, crank))
        x -= step
        length = math.sqrt(step @ step)
    residual(x, crank)
    return [x, count, length]


def by_elimination(residual, jacobian, crank, seed, tol=1e-6, count=1):
    """Gauss with pivots, in lists, and recursion for the loop."""
    rows = [[*row, f] for row, f in zip(np.asarray(jacobian(seed, crank)).tolist(), residual(seed, crank), strict=True)]
    for k in range(9):
        rows[k:] = sorted(rows[k:], key=lambda row: -abs(row[k]))
        for i in range(k + 1, 9):
            factor = rows[i][k] / rows[k][k]  # a singular matrix divides by zero: an ArithmeticError
            rows[i] = [a - factor * b for a, b in zip(rows[i], rows[k], strict=True)]
    step = [0.0] * 9
    for k in reversed(range(9)):
        step[k] = (rows[k][9] - sum(rows[k][j] * step[j] for j in range(k + 1, 9))) / rows[k][k]
    ahead = [x - d for x, d in zip(seed, step, strict=True)]
    if not all(map(math.isfinite, ahead)) or count > 40:
        raise ArithmeticError("no state")
    length = math.hypot(*step)
    return (ahead, count, length) if length < tol else by_elimination(residual, jacobian, crank, ahead, tol, count + 1)


def by_qr(residual, jacobian, crank, seed, tol=1e-6):
    history = [np.asarray(seed, dtype=float)]
    while len(history) < 2 or np.linalg.norm(history[-1] - history[-2]) >= tol:
        q, r = np.linalg.qr(jacobian(history[-1], crank))
        if len(history) > 60 or np.abs(np.diag(r)).min() < 1e-13:
            raise FloatingPointError(f"no state near {history[-1]}")
        history.append(history[-1] - solve_triangular(r, q.T @ residual(history[-1], crank)))
    return history[-1], np.float64(len(history) - 1), np.linalg.norm(history[-1] - history[-2])


# --- all points


def by_lists(residual, jacobian, crank, seed, tol=1e-6):
    states, counts, lengths = [], [], []
    for k in range(len(crank[0])):
        try:
            seed, count, length = by_elimination(residual, jacobian, [row[k] for row in crank], seed, tol)
        except ArithmeticError:
            raise ArithmeticError(f"the loop does not close at index {k}") from None
        states.append(seed)
        counts.append(count)
        lengths.append(length)
    return states, counts, lengths


def extrapolated(residual, jacobian, crank, seed, tol=1e-6):
    """The line through the last two states is a better guess than the last."""
    found, counts, lengths = [], [], []
    for k, at in enumerate(crank.T):
        guess = [seed, *found[:1]][k] if k < 2 else 2 * found[-1] - found[-2]
        try:
            state, count, length = by_qr(residual, jacobian, at, guess, tol)
        except ArithmeticError as why:
            raise ArithmeticError(f"{why} (point {k} of {len(crank.T)})") from why
        found.append(state)
        counts.append(count)
        lengths.append(length)
    return np.vstack(found), counts, lengths


def with_rates_from_nothing(residual, jacobian, crank, seed, tol=1e-6):
    """Positions from the point before, velocities and accelerations from zero: they are linear in the equations."""
    n = crank.shape[1]
    states, effort = np.empty((n, 9)), np.empty((2, n))
    for k in range(n):
        guess = np.array(seed) if k == 0 else np.append(states[k - 1, :3], np.zeros(6))
        try:
            states[k], *effort[:, k] = by_lu_in_place(residual, jacobian, crank[:, k], guess, tol)
        except ArithmeticError:
            raise ArithmeticError(f"open: {k}") from None
    return states, *effort


RIGHT = {
    "nine_equations": (by_complex_numbers, by_matrices_of_exercise_5, by_functions_of_time),
    "nine_jacobian": (by_sympy, by_complex_steps, by_central_differences),
    "one_point": (by_lu_in_place, by_elimination, by_qr),
    "all_points": (by_lists, extrapolated, with_rates_from_nothing),
}
SLOW = {by_functions_of_time, by_sympy}


@pytest.mark.parametrize(
    ("name", "route"), [(n, r) for n, routes in RIGHT.items() for r in routes], ids=lambda x: getattr(x, "__name__", x)
)
def test_another_right_way_gets_full_points(name, route):
    for student in DRAWS[:1] if route in SLOW else DRAWS:
        assessment = judged(name, route, student)
        assert (assessment.verdict, assessment.points) == ("right", task(name).points), (student, assessment.diagnosis)
        assert assessment.mistake == ""


def test_the_reference_jacobian_is_that_of_the_reference_equations_by_differences():
    equations, jacobian = task("nine_equations").reference, task("nine_jacobian").reference
    for student in DRAWS:
        for case in task("nine_jacobian").draw("salt", student):
            state, *rest = case.args
            differences = approx_derivative(lambda x, rest=rest: equations(x, *rest), state, method="3-point")
            assert np.abs(differences - jacobian(state, *rest)).max() < 1e-7


def test_the_systems_that_are_handed_out_are_those_of_the_first_two_tasks():
    for student in DRAWS:
        for case in task("one_point").draw("salt", student)[:3]:
            residual, jacobian, crank, seed, _ = case.args
            r3 = -jacobian(seed, crank)[0, 2] / np.sin(seed[2])
            still = np.array([0, 0, 0, *seed[3:]])  # r1 = 0: the two other lengths alone are left
            x, _, height = residual(still, np.zeros(3))[:3]
            lengths = (-height, x - r3, r3)
            assert np.allclose(residual(seed, crank), by_complex_numbers(seed, crank, lengths), rtol=0, atol=1e-9)
            assert np.allclose(jacobian(seed, crank), by_complex_steps(seed, crank, lengths), rtol=0, atol=1e-9)


def test_a_point_that_is_never_refused_loses_half_a_point():
    def never_raises(residual, jacobian, crank, seed, tol=1e-6):
        x, count, length = np.array(seed), 0, np.inf
        while length >= tol and count < 15:
            step = np.linalg.lstsq(jacobian(x, crank), residual(x, crank), rcond=None)[0]
            x, count, length = x - step, count + 1, np.linalg.norm(step)
        return x, count, length

    for student in DRAWS:
        assessment = judged("one_point", never_raises, student)
        assert assessment.points == 2.5
        assert faults(assessment) == ["it returned a value where there is no state to be found"]


def test_an_inverse_is_seen_and_loses_a_quarter_of_a_point():
    def by_inverse(residual, jacobian, crank, seed, tol=1e-6):
        x = np.array(seed)
        for k in range(1, 41):
            matrix = jacobian(x, crank)
            if np.linalg.det(matrix) == 0:
                break
            step = np.linalg.inv(matrix) @ residual(x, crank)
            x = x - step
            if np.linalg.norm(step) < tol:
                return x, k, np.linalg.norm(step)
        raise ArithmeticError("no state")

    for student in DRAWS:
        assessment = judged("one_point", by_inverse, student)
        assert assessment.points == 2.75
        assert [fault for fault in faults(assessment) if "is an inverse formed?" in fault]


def test_a_tolerance_of_ones_own_is_seen_in_the_steps():
    def solver(*args):
        return by_qr(*args[:4], 1e-6)

    def sweep(*args):
        return by_lists(*args[:4], 1e-6)

    for student in DRAWS:
        assert judged("one_point", solver, student).points == 2.25
        assert "more" in faults(judged("one_point", solver, student))[0]
        assert judged("all_points", sweep, student).points == 2.25
        assert "after the first step" in faults(judged("all_points", sweep, student))[0]


def test_iterations_and_errors_are_held_to_the_students_own_steps():
    def changed(change):
        def sweep(*args):
            return change(*map(np.array, extrapolated(*args)))

        return sweep

    for change in (
        lambda states, iterations, errors: (states, iterations + 1, errors),
        lambda states, iterations, errors: (states, iterations, 2 * errors),
        lambda states, iterations, errors: (states, iterations, errors[::-1]),
    ):
        for student in DRAWS[:5]:
            assert judged("all_points", changed(change), student).points == 2.25


def test_starting_every_point_from_the_first_state_is_a_cold_start():
    def from_the_first(residual, jacobian, crank, seed, tol=1e-6):
        first = by_qr(residual, jacobian, crank[:, 0], seed, tol)
        found = []
        for k, at in enumerate(crank.T):
            try:
                found.append(by_qr(residual, jacobian, at, first[0] if k else seed, tol))
            except ArithmeticError:
                raise ArithmeticError(f"point {k}") from None
        return tuple(zip(*found, strict=True))

    for student in DRAWS:
        assessment = judged("all_points", from_the_first, student)
        assert assessment.points < 3
        assert any("far from the position before it" in f or "off by" in f for f in faults(assessment))
