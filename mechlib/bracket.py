"""Where a continuous function must have a zero: Bolzano's theorem on a grid."""

from collections.abc import Callable

import numpy as np


def brackets(f: Callable[[float], float], a: float, b: float, n: int) -> np.ndarray:
    """Subintervals of [a, b] on which f changes sign.

    A continuous f has a zero in each of them (Bolzano); one only, if f is monotonic there. Two zeros in one
    subinterval are not seen: take n large enough. A pole changes sign as well: f must be continuous.

    Parameters
    ----------
    f : callable, float -> float
    a, b : float
        Ends, a < b.
    n : int
        Number of equal subintervals.

    Returns
    -------
    ndarray, shape (k, 2)
        Left and right ends, from left to right. A zero that falls on a grid point ends its subinterval;
        the first grid point, if it is a zero, begins the first.

    Raises
    ------
    ValueError
        If not a < b, or n is not positive.

    References
    ----------
    Source B, section 1.
    """
    if not a < b:
        raise ValueError(f"the interval must have a < b, got a = {a}, b = {b}")
    if n < 1:
        raise ValueError(f"n must be positive, got {n}")
    x = np.linspace(a, b, n + 1)
    sign = np.sign([f(point) for point in x])
    change = (sign[:-1] * sign[1:] < 0) | (sign[1:] == 0)
    change[0] |= sign[0] == 0
    return np.column_stack((x[:-1], x[1:]))[change]
