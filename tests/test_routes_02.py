"""Exercise 2 by other right ways than the reference's: each gets full points from every draw."""

import math

import numpy as np
import pytest
from judging import judged
from scipy.linalg import lu_factor, lu_solve

# --- newton


def newton_by(solve):
    def solver(residual, jacobian, seed, tol, max_iterations):
        x = [list(map(float, seed))]
        for _ in range(max_iterations):
            step = solve(np.array(jacobian(x[-1])), np.array(residual(x[-1])))
            x.append([a - d for a, d in zip(x[-1], step, strict=True)])
            if not np.isfinite(x[-1]).all():
                raise ArithmeticError("no longer a number")
            if math.hypot(*step) < tol:
                return x
        raise ArithmeticError("out of iterations")

    return solver


def elimination(matrix, right):
    """By Gauss, with the largest pivot of the column."""
    rows = [[*map(float, row), float(b)] for row, b in zip(matrix, right, strict=True)]
    n = len(rows)
    for k in range(n):
        p = max(range(k, n), key=lambda i: abs(rows[i][k]))
        rows[k], rows[p] = rows[p], rows[k]
        if rows[k][k] == 0:
            raise ArithmeticError("singular")
        for i in range(k + 1, n):
            factor = rows[i][k] / rows[k][k]
            rows[i] = [a - factor * b for a, b in zip(rows[i], rows[k], strict=True)]
    x = [0.0] * n
    for k in reversed(range(n)):
        x[k] = (rows[k][n] - sum(rows[k][j] * x[j] for j in range(k + 1, n))) / rows[k][k]
    return x


def least_squares(matrix, right):
    answer, _, rank, _ = np.linalg.lstsq(matrix, right, rcond=None)
    if rank < len(right):
        raise ArithmeticError("singular")
    return answer


def newton_by_lu_in_place(residual, jacobian, seed, tol, max_iterations):
    x, path = np.array(seed, dtype=float), [tuple(seed)]
    for _ in range(max_iterations):
        matrix = np.asarray(jacobian(x))
        if np.linalg.matrix_rank(matrix, tol=0) < len(x):
            raise ArithmeticError(f"singular at {x}")
        step = lu_solve(lu_factor(matrix), residual(x))
        x -= step
        path.append(tuple(x))
        if step @ step < tol**2:
            return np.array(path)
    raise ArithmeticError(f"{x} is no root")


# --- jacobian_fd


def forward(residual, x):
    base, columns = np.array(residual(x)), []
    for j, value in enumerate(x):
        ahead = np.array(x, dtype=float)
        ahead[j] += 2e-8 * max(abs(value), 0.5)
        columns.append((np.array(residual(ahead)) - base) / (ahead[j] - value))
    return np.stack(columns, axis=1)


def backward_in_lists(residual, x):
    x = [float(value) for value in x]
    base = residual(x)
    rows = [[0.0] * len(x) for _ in base]
    for j, value in enumerate(x):
        h = 1e-8 * (1 + abs(value))
        for i, y in enumerate(residual([*x[:j], value - h, *x[j + 1 :]])):
            rows[i][j] = (base[i] - y) / h
    return rows


def central_by_a_matrix_of_steps(residual, x):
    steps = np.diag(6e-6 * np.hypot(1, x))
    return np.transpose(
        [(np.asarray(residual(x + h)) - np.asarray(residual(x - h))) / (2 * h[j]) for j, h in enumerate(steps)]
    )


# --- jacobian_errors


def errors_by(difference):
    def named(residual, jacobian, x):
        near, given = np.array(difference(residual, x)), np.array(jacobian(x))
        scale = np.linalg.norm(near, np.inf, axis=1)
        return np.argwhere(np.abs((given - near) / scale[:, None]) > 1e-4)

    return named


def errors_backwards_in_lists(residual, jacobian, x):
    """From the last entry to the first, as lists."""
    near, given = backward_in_lists(residual, x), jacobian(x)
    places = [(i, j) for i in range(len(near)) for j in range(len(near[0]))]
    wrong = [(i, j) for i, j in places if abs(given[i][j] - near[i][j]) > 1e-4 * max(map(abs, near[i]))]
    return [list(place) for place in wrong[::-1]]


# --- basin_map


def map_of_all_at_once(residual, jacobian, xs, ys, roots):
    q = np.stack(np.meshgrid(xs, ys), axis=-1).astype(float)
    with np.errstate(all="ignore"):
        for _ in range(50):
            (a, b), (c, d) = np.moveaxis(jacobian(q), (-2, -1), (0, 1))
            u, v = np.moveaxis(residual(q), -1, 0)
            q = q - np.stack((d * u - b * v, a * v - c * u), axis=-1) / (a * d - b * c)[..., None]
        near = np.linalg.norm(q[..., None, :] - roots, axis=-1) < 1e-6
    return np.where(near.any(axis=-1), near.argmax(axis=-1), -1)


def map_by(solver):
    def mapped(residual, jacobian, xs, ys, roots):
        answer = np.zeros((len(ys), len(xs)), dtype=int) - 1
        for (j, i), _ in np.ndenumerate(answer):
            try:
                end = solver(residual, jacobian, np.array([xs[i], ys[j]]), 1e-9, 50)[-1]
            except ArithmeticError:
                continue
            for index, root in enumerate(roots):
                if np.allclose(end, root, rtol=0, atol=1e-6):
                    answer[j, i] = index
        return answer.tolist()

    return mapped


ROUTES = {
    "newton": (newton_by(elimination), newton_by(least_squares), newton_by_lu_in_place),
    "jacobian_fd": (forward, backward_in_lists, central_by_a_matrix_of_steps),
    "jacobian_errors": (errors_by(forward), errors_by(central_by_a_matrix_of_steps), errors_backwards_in_lists),
    "basin_map": (map_of_all_at_once, map_by(newton_by(elimination)), map_by(newton_by_lu_in_place)),
}


@pytest.mark.parametrize(
    ("name", "function"),
    [(name, route) for name, routes in ROUTES.items() for route in routes],
    ids=lambda value: getattr(value, "__qualname__", value),
)
def test_another_right_way_gets_full_points(name, function):
    for student in range(5 if name == "basin_map" else 40):
        assessment = judged(name, function, f"route {student}")
        assert assessment.verdict == "right", assessment.diagnosis
