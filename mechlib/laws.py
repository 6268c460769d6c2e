"""How parameters are spread: each by a law of its own, or several together.

A joint law turns points of the unit cube into parameters. So the same law serves any source of such points: a generator
of random numbers, or an evenly spread sequence.
"""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtri

from mechlib import require

SMALLEST = 2.0**-54  # half of the spacing of random numbers: a normal law has no value at zero


class Law(Protocol):
    """How one parameter is spread."""

    mean: float
    deviation: float

    def quantile(self, unit: np.ndarray) -> np.ndarray:
        """The value below which this part of all values lies; any shape."""


class JointLaw(Protocol):
    """How all parameters are spread together.

    Attributes
    ----------
    mean : ndarray, shape (k,)
    covariance : ndarray, shape (k, k)
    """

    mean: np.ndarray
    covariance: np.ndarray

    def throw(self, unit: np.ndarray) -> np.ndarray:
        """Parameters from points of the unit cube; shapes (throws, k) -> (throws, k)."""


@dataclass(frozen=True)
class Uniform:
    """Anywhere within a tolerance, and equally often.

    Raises
    ------
    ValueError
        If the mean is not finite, or the half width negative.
    """

    mean: float
    half_width: float

    def __post_init__(self):
        _spread("half_width", self.mean, self.half_width)

    @property
    def deviation(self) -> float:
        return self.half_width / np.sqrt(3)

    def quantile(self, unit: np.ndarray) -> np.ndarray:
        return unit * (2 * self.half_width) + (self.mean - self.half_width)


@dataclass(frozen=True)
class Normal:
    """By the law of Gauss.

    Raises
    ------
    ValueError
        If the mean is not finite, or the deviation negative.
    """

    mean: float
    deviation: float

    def __post_init__(self):
        _spread("deviation", self.mean, self.deviation)

    def quantile(self, unit: np.ndarray) -> np.ndarray:
        return self.mean + self.deviation * ndtri(np.maximum(unit, SMALLEST))


@dataclass(frozen=True)
class Given:
    """By a law of the user's own: a frozen distribution of `scipy.stats`, or whatever has its three methods.

    Attributes
    ----------
    distribution : object
        With `ppf(unit)`, the quantiles, and `mean()` and `std()`.

    Raises
    ------
    ValueError
        If its mean or its deviation is not finite: then neither has a sum of throws any limit.
    """

    distribution: object

    def __post_init__(self):
        _spread("deviation", self.mean, self.deviation)

    @property
    def mean(self) -> float:
        return float(self.distribution.mean())

    @property
    def deviation(self) -> float:
        return float(self.distribution.std())

    def quantile(self, unit: np.ndarray) -> np.ndarray:
        return self.distribution.ppf(np.maximum(unit, SMALLEST))


@dataclass(frozen=True)
class Independent:
    """Each parameter by its own law, whatever the others are.

    Attributes
    ----------
    laws : tuple of k Law
    """

    laws: tuple[Law, ...]

    @property
    def mean(self) -> np.ndarray:
        return np.array([law.mean for law in self.laws])

    @property
    def covariance(self) -> np.ndarray:
        return np.diag([law.deviation**2 for law in self.laws])

    def throw(self, unit: np.ndarray) -> np.ndarray:
        thrown = np.empty(unit.shape[::-1])  # each parameter in one piece
        for k, law in enumerate(self.laws):
            thrown[k] = law.quantile(unit[:, k])
        return thrown.T


@dataclass(frozen=True)
class Correlated:
    """Normal laws that depend on one another, as dimensions cut in one clamping do.

    Attributes
    ----------
    mean : array_like, shape (k,)
    covariance : array_like, shape (k, k)

    Raises
    ------
    ValueError
        If the covariance has another shape, is not symmetric, or gives some sum of parameters a negative variance.
    """

    mean: np.ndarray
    covariance: np.ndarray
    _factor: np.ndarray = field(init=False, repr=False)

    def __post_init__(self):
        mean, covariance = require.finite("mean", self.mean), require.finite("covariance", self.covariance)
        if mean.ndim != 1 or covariance.shape != 2 * mean.shape:
            raise ValueError(
                f"covariance must be ({mean.size}, {mean.size}), as the mean has it; got {covariance.shape}"
            )
        if not np.allclose(covariance, covariance.T, rtol=1e-12, atol=0):
            i, j = np.argwhere(~np.isclose(covariance, covariance.T, rtol=1e-12, atol=0))[0]
            raise ValueError(
                f"covariance must be symmetric, got {covariance[i, j]} at {i}, {j} and {covariance[j, i]} at {j}, {i}"
            )
        scale = np.sqrt(np.maximum(np.diag(covariance), 0))
        scale[scale == 0] = 1.0
        variances, directions = np.linalg.eigh(covariance / np.outer(scale, scale))
        if variances[0] < -1e-12:
            weights = ", ".join(f"{weight:.3g}" for weight in directions[:, 0] / scale)
            raise ValueError(
                f"covariance must give no sum of parameters a negative variance, got {variances[0]:.3g} "
                f"for the sum with the weights {weights}"
            )
        for name, value in {
            "mean": mean,
            "covariance": covariance,
            # here and not in each process, whose last bit may be another
            "_factor": scale[:, None] * directions * np.sqrt(np.maximum(variances, 0)),
        }.items():
            object.__setattr__(self, name, value)

    def throw(self, unit: np.ndarray) -> np.ndarray:
        normal = ndtri(np.maximum(unit, SMALLEST))
        return self.mean + np.einsum("jk,nk->jn", self._factor, normal).T


def tolerances(nominal: ArrayLike, half_width: ArrayLike) -> Independent:
    """Every parameter uniform about its nominal value; shapes (k,), and (k,) or one for all.

    Raises
    ------
    ValueError
        If a nominal value is not finite, or a half width negative.
    """
    nominal, half_width = np.broadcast_arrays(np.asarray(nominal, float), np.asarray(half_width, float))
    return Independent(tuple(map(Uniform, nominal.tolist(), half_width.tolist())))


def _spread(name: str, mean: float, size: float) -> None:
    require.finite("mean", mean)
    if not 0 <= size < np.inf:
        raise ValueError(f"{name} must not be negative or without limit, got {size}")
