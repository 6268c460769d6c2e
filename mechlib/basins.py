"""Basins of attraction: to which root does Newton-Raphson run from each point of the plane?"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike


def basins(
    residual: Callable[[np.ndarray], np.ndarray],
    jacobian: Callable[[np.ndarray], np.ndarray],
    xs: ArrayLike,
    ys: ArrayLike,
    roots: ArrayLike,
    tol: float = 1e-8,
    max_iterations: int = 50,
) -> np.ndarray:
    """Map of the roots that Newton-Raphson finds from every point of a grid, all points at once.

    Parameters
    ----------
    residual : callable, (points, 2) -> (points, 2)
    jacobian : callable, (points, 2) -> (points, 2, 2)
    xs, ys : array_like, shapes (nx,), (ny,)
        The seeds are all pairs of them.
    roots : array_like, shape (r, 2)
        The known roots.
    tol : float
        An iterate nearer than this to a root has found it.
    max_iterations : int

    Returns
    -------
    ndarray of int, shape (ny, nx)
        ``[j, i]`` is the index of the root found from ``(xs[i], ys[j])``; -1 where none was.
    """
    x, y = np.meshgrid(xs, ys)
    q = np.column_stack((x.ravel(), y.ravel())).astype(float)
    with np.errstate(all="ignore"):  # a seed on a singular point runs to infinity, and finds no root
        for _ in range(max_iterations):
            q = q - _solve_2x2(jacobian(q), residual(q))
        distance = np.linalg.norm(q[:, None, :] - np.asarray(roots, dtype=float), axis=-1)
        found = np.where(distance.min(axis=1) < tol, distance.argmin(axis=1), -1)
    return found.reshape(x.shape)


def _solve_2x2(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Cramer's rule: where a matrix is singular it gives infinity, and leaves the other points alone."""
    (a, b), (c, d) = np.moveaxis(matrix, 0, -1)
    u, v = np.moveaxis(right, 0, -1)
    return np.stack((d * u - b * v, a * v - c * u), axis=-1) / (a * d - b * c)[:, None]
