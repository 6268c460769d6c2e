"""What drives a mechanism: the motion of its input, and the run-up of a motor by exact integration, piece by piece."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PPoly

from mechlib import require


@dataclass(frozen=True)
class Motion:
    """The input of a mechanism at the instants of a sweep.

    Attributes
    ----------
    t : ndarray, shape (points,)
        Instants in s, increasing.
    position, velocity, acceleration : ndarray, shape (points,)
        Of the input: an angle in rad or a length in m, and its time derivatives.

    Raises
    ------
    ValueError
        If the instants do not increase, a number is not finite, or the shapes differ.
    """

    t: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray

    def __post_init__(self):
        for name in ("t", "position", "velocity", "acceleration"):
            object.__setattr__(self, name, require.finite(name, getattr(self, name)))
        shapes = {self.t.shape, self.position.shape, self.velocity.shape, self.acceleration.shape}
        if self.t.ndim != 1 or len(shapes) != 1:
            raise ValueError(f"t, position, velocity and acceleration must be (points,) alike, got {sorted(shapes)}")
        back = np.flatnonzero(np.diff(self.t) <= 0)
        if back.size:
            k = int(back[0])
            raise ValueError(f"t must increase, got {self.t[k]} before {self.t[k + 1]} at index {k + 1}")

    def __len__(self) -> int:
        return len(self.t)


@dataclass(frozen=True)
class MotorProfile:
    """The run-up of a motor: its acceleration rises, stays, falls, a third of the time each, and is zero from then on.

    Attributes
    ----------
    T : float
        Duration of the run-up, s.
    peak : float
        Largest angular acceleration, rad/s^2.

    Raises
    ------
    ValueError
        If one of them is not a positive number.

    References
    ----------
    Source A, section 4, eqs. (3) to (5).
    """

    T: float
    peak: float = 5.0

    def __post_init__(self):
        require.positive(T=self.T, peak=self.peak)

    @classmethod
    def through(cls, angle: float = 2 * np.pi, peak: float = 5.0) -> "MotorProfile":
        """The profile that turns through an angle in rad during its run-up: theta(T) = peak T^2/3.

        The speed at mirrored instants adds up to that at T, so the mean speed is half of it, peak T/3.
        """
        require.positive(angle=angle, peak=peak)
        return cls(float(np.sqrt(3 * angle / peak)), peak)

    def at(self, t: ArrayLike) -> Motion:
        """Angle, angular velocity and angular acceleration of the shaft, from rest at zero.

        Parameters
        ----------
        t : array_like, shape (points,)
            Instants in s, increasing; none before zero, where the motor is not defined.

        Returns
        -------
        Motion

        Raises
        ------
        ValueError
            If an instant is negative or not finite, or they do not increase.
        """
        t = require.finite("t", t)
        if (t < 0).any():
            raise ValueError(f"the motor starts at t = 0, got t = {t[t < 0].flat[0]}")
        ends = self.T / 3 * np.arange(5)  # the last piece goes on beyond its end
        slope = 3 * self.peak / self.T
        alpha = PPoly([[slope, 0, -slope, 0], [0, self.peak, self.peak, 0]], ends)
        omega = alpha.antiderivative()  # scipy carries the constants from piece to piece
        return Motion(t, omega.antiderivative()(t), omega(t), alpha(t))
