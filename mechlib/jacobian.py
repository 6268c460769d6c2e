"""A Jacobian by finite differences, and the entries of a Jacobian that disagree with it."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike


def finite_difference_jacobian(residual: Callable[[np.ndarray], ArrayLike], x: ArrayLike) -> np.ndarray:
    """Jacobian by central differences.

    The step balances the truncation, of order h^2, against the round-off, of order eps/h: h = eps^(1/3) max(1, |x_j|).

    Parameters
    ----------
    residual : callable, (n,) -> (m,)
    x : array_like, shape (n,)

    Returns
    -------
    ndarray, shape (m, n)
        ``[i, j]`` is the derivative of ``residual(x)[i]`` by ``x[j]``.

    Raises
    ------
    ValueError
        If `x` is not a finite vector.
    """
    x = np.array(x, dtype=float)
    if x.ndim != 1 or not np.isfinite(x).all():
        raise ValueError(f"x must be a finite vector, got {x}")
    columns = []
    for j, h in enumerate(np.cbrt(np.finfo(float).eps) * np.maximum(1.0, np.abs(x))):
        ahead, behind = x.copy(), x.copy()
        ahead[j] += h
        behind[j] -= h
        rise = np.asarray(residual(ahead), dtype=float) - np.asarray(residual(behind), dtype=float)
        columns.append(rise / (ahead[j] - behind[j]))  # the step as it was stored, not as it was asked for
    return np.stack(columns, axis=-1)


def wrong_entries(
    residual: Callable[[np.ndarray], ArrayLike],
    jacobian: Callable[[np.ndarray], ArrayLike],
    x: ArrayLike,
    rtol: float = 1e-5,
) -> list[tuple[int, int]]:
    """Entries of a Jacobian that finite differences contradict.

    Parameters
    ----------
    residual : callable, (n,) -> (m,)
    jacobian : callable, (n,) -> (m, n)
    x : array_like, shape (n,)
        Where to look; a random point, since at a special one a wrong entry may be right by chance.
    rtol : float
        Disagreement that is forgiven, relative to the largest entry of its row: a row has the units of its equation.

    Returns
    -------
    list of (row, column)
        Counted from zero, in reading order.

    Raises
    ------
    ValueError
        If the Jacobian has another shape than the differences.
    """
    expected = finite_difference_jacobian(residual, x)
    claimed = np.asarray(jacobian(np.array(x, dtype=float)), dtype=float)
    if claimed.shape != expected.shape:
        raise ValueError(f"the Jacobian has shape {claimed.shape}, {expected.shape} was expected")
    scale = np.abs(expected).max(axis=1, keepdims=True)
    wrong = ~(np.abs(claimed - expected) <= rtol * scale)  # nan counts as wrong
    return [(int(i), int(j)) for i, j in np.argwhere(wrong)]
