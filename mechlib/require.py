"""Input that cannot be, said in one sentence with the value that is wrong."""

import numpy as np
from numpy.typing import ArrayLike


def finite(name: str, values: ArrayLike) -> np.ndarray:
    """The values as an array of floats.

    Raises
    ------
    ValueError
        If one of them is infinite or not a number; the sentence says which.
    """
    array = np.asarray(values, dtype=float)
    bad = ~np.isfinite(array)
    if bad.any():
        where = tuple(int(i) for i in np.argwhere(bad)[0])
        place = f" at index {', '.join(map(str, where))}" if where else ""
        raise ValueError(f"{name} must be finite, got {array[where]}{place}")
    return array


def positive(**quantities: float) -> None:
    """Nothing, if every quantity is a positive, finite number.

    Raises
    ------
    ValueError
        If one of them is not; the sentence has its name and value.
    """
    for name, value in quantities.items():
        if not (np.ndim(value) == 0 and 0 < value < np.inf):
            raise ValueError(f"{name} must be a positive number, got {value}")


def one_of(name: str, value: str, known: tuple[str, ...]) -> None:
    """Nothing, if the value is one of those known.

    Raises
    ------
    ValueError
        If it is not; the sentence lists those that are.
    """
    if value not in known:
        raise ValueError(f"{name} must be {' or '.join(map(repr, known))}, got {value!r}")
