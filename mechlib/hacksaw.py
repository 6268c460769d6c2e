"""The power hacksaw: a crank drives a saw along a straight guide, through a coupler.

The crank turns about O and carries the pin A. The coupler joins A to the slider B, which runs on the line y = r1y. The
vector r1 goes from O to B: r1 = r2 + r3.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike
from sympy import cos, sin

from mechlib import require
from mechlib.closure import Closure, Coordinate, Loop, OpenLoopError

Branch = Literal["left", "right"]


def _closure() -> Closure:
    length = Coordinate.named("r_1 v_r a_r")
    line = Coordinate.named("theta_1 omega_1 alpha_1")
    crank = Coordinate.named("theta_2 omega_2 alpha_2")
    coupler = Coordinate.named("theta_3 omega_3 alpha_3")
    r1, th1, th2, th3 = length.position, line.position, crank.position, coupler.position
    r1y, r2, r3 = sp.symbols("r_1y r_2 r_3", positive=True)
    return Closure(
        equations=(
            -r1 * cos(th1) + r2 * cos(th2) + r3 * cos(th3),
            r1 * sin(th1) - r2 * sin(th2) - r3 * sin(th3),
            r1 * sin(th1) - r1y,
        ),
        unknowns=(length, line, coupler),
        input=crank,
        parameters=(r1y, r2, r3),
    )


@dataclass(frozen=True)
class Hacksaw:
    """A power hacksaw; the lengths are those of source A, section 5.2.

    Attributes
    ----------
    r1y : float
        Height of the guide above the shaft of the crank, m.
    r2, r3 : float
        Lengths of the crank O-A and the coupler A-B, m.

    Raises
    ------
    ValueError
        If a length is not a positive number.

    References
    ----------
    Source A, section 5.1, eqs. (6) to (15).
    """

    r1y: float = 0.045
    r2: float = 0.075
    r3: float = 0.170

    closure: ClassVar[Closure] = _closure()

    def __post_init__(self):
        require.positive(r1y=self.r1y, r2=self.r2, r3=self.r3)

    @cached_property
    def loop(self) -> Loop:
        """The closure with these lengths: unknowns (r1, theta1, theta3), input theta2."""
        return self.closure.loop(self.r1y, self.r2, self.r3)

    def gap(self, theta2: ArrayLike) -> np.ndarray:
        """By how much the coupler is too short to reach the guide, m; not positive where the loop closes.

        Parameters
        ----------
        theta2 : array_like, shape (...)
            Crank angle, rad.

        Returns
        -------
        ndarray, shape (...)
        """
        return np.abs(self.r1y - self.r2 * np.sin(theta2)) - self.r3

    def position(self, theta2: ArrayLike, branch: Branch = "left") -> np.ndarray:
        """The unknowns in closed form, on one of the two assembly branches.

        The coupler reaches the guide to the left of the crank pin or to the right of it. The saw of source A is on
        the left, where its r1 is negative and theta1 lies near zero; on the right r1 is positive.

        Parameters
        ----------
        theta2 : array_like, shape (...)
            Crank angle, rad.
        branch : {"left", "right"}

        Returns
        -------
        ndarray, shape (..., 3)
            r1 in m, theta1 and theta3 in rad.

        Raises
        ------
        ValueError
            If an angle is not finite, or the branch has another name.
        OpenLoopError
            If the loop cannot close at one of the angles; says which, and by how much.

        References
        ----------
        Source A, section 5.3.
        """
        theta2 = require.finite("theta2", theta2)
        require.one_of("branch", branch, ("left", "right"))
        if (self.gap(theta2) > 0).any():
            raise OpenLoopError("theta_2", theta2, self.gap(theta2))
        reach = np.arcsin((self.r1y - self.r2 * np.sin(theta2)) / self.r3)
        theta3 = np.pi - reach if branch == "left" else reach
        side = -1.0 if branch == "left" else 1.0
        x = self.r2 * np.cos(theta2) + self.r3 * np.cos(theta3)
        return np.stack((side * np.hypot(x, self.r1y), np.arctan2(side * self.r1y, side * x), theta3), axis=-1)

    def closed_form(
        self, theta2: ArrayLike, omega2: ArrayLike, alpha2: ArrayLike, branch: Branch = "left"
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Position, velocity and acceleration in closed form: no iteration, and no system of equations.

        Parameters
        ----------
        theta2, omega2, alpha2 : array_like, shape (...)
            Angle of the crank in rad, its angular velocity and acceleration.
        branch : {"left", "right"}

        Returns
        -------
        position, velocity, acceleration : ndarray, shape (..., 3)
            Of r1, theta1, theta3, in m, rad and s.

        Raises
        ------
        ValueError, OpenLoopError
            As for `position`.
        ZeroDivisionError
            Where the coupler stands upright and the velocities are not determined.

        References
        ----------
        Source A, section 5.3.
        """
        q = self.position(theta2, branch)
        r1, theta1, theta3 = np.moveaxis(q, -1, 0)
        across, up = self.r3 * np.cos(theta3), self.r3 * np.sin(theta3)
        if (across == 0).any():
            raise ZeroDivisionError("the coupler stands upright: no velocity is determined")
        c2, s2 = self.r2 * np.cos(theta2), self.r2 * np.sin(theta2)
        omega3 = -omega2 * c2 / across
        alpha3 = (up * omega3**2 + s2 * omega2**2 - c2 * alpha2) / across
        # the slider runs along x; r1 turns, so that its parts along x and across are those of polar coordinates
        dx = -s2 * omega2 - up * omega3
        ddx = -c2 * omega2**2 - s2 * alpha2 - across * omega3**2 - up * alpha3
        cos1, sin1 = np.cos(theta1), np.sin(theta1)
        v_r, omega1 = dx * cos1, -dx * sin1 / r1
        a_r, alpha1 = ddx * cos1 + r1 * omega1**2, -(ddx * sin1 + 2 * v_r * omega1) / r1
        return q, np.stack((v_r, omega1, omega3), axis=-1), np.stack((a_r, alpha1, alpha3), axis=-1)

    def branch(self, q: ArrayLike) -> np.ndarray:
        """The assembly branch of closed positions: "left" where the coupler points to the left.

        Parameters
        ----------
        q : array_like, shape (..., 3)
            r1, theta1, theta3.

        Returns
        -------
        ndarray of str, shape (...)
        """
        return np.where(np.cos(np.asarray(q)[..., 2]) < 0, "left", "right")

    def points(self, theta2: ArrayLike, q: ArrayLike) -> np.ndarray:
        """The joints O, A and B, to draw.

        Parameters
        ----------
        theta2 : array_like, shape (...)
            Crank angle, rad.
        q : array_like, shape (..., 3)
            r1, theta1, theta3.

        Returns
        -------
        ndarray, shape (..., 3, 2)
            x and y of each, m.
        """
        theta2, q = np.asarray(theta2), np.asarray(q)
        pin = self.r2 * np.stack((np.cos(theta2), np.sin(theta2)), axis=-1)
        slider = q[..., :1] * np.stack((np.cos(q[..., 1]), np.sin(q[..., 1])), axis=-1)
        return np.stack((np.zeros_like(pin), pin, slider), axis=-2)
