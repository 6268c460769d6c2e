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
    _all(np.isfinite(array), f"{name} must be finite", array)
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


def all_positive(**quantities: ArrayLike) -> None:
    """Nothing, if every quantity is a positive, finite number or an array of such.

    Raises
    ------
    ValueError
        If one of them is not; the sentence has its name, the value, and where it stands.
    """
    for name, values in quantities.items():
        array = np.asarray(values, dtype=float)
        if not (array.min(initial=np.inf) > 0 and array.max(initial=0) < np.inf):  # neither holds for nan
            _all((array > 0) & (array < np.inf), f"{name} must be a positive number", array)


def one_of(name: str, value: str, known: tuple[str, ...]) -> None:
    """Nothing, if the value is one of those known.

    Raises
    ------
    ValueError
        If it is not; the sentence lists those that are.
    """
    if value not in known:
        raise ValueError(f"{name} must be {' or '.join(map(repr, known))}, got {value!r}")


def _all(good: np.ndarray, claim: str, array: np.ndarray) -> None:
    if not good.all():
        where = tuple(int(i) for i in np.argwhere(~good)[0])
        place = f" at index {', '.join(map(str, where))}" if where else ""
        raise ValueError(f"{claim}, got {array[where]}{place}")
