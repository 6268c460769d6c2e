"""Points of the plane as complex numbers."""

import numpy as np
from numpy.typing import ArrayLike


def unit(angle: ArrayLike) -> np.ndarray:
    """In this direction, rad; any shape."""
    return np.exp(1j * np.asarray(angle))


def xy(z: np.ndarray) -> np.ndarray:
    """Their coordinates; shapes (...) -> (..., 2)."""
    return np.stack((z.real, z.imag), axis=-1)
