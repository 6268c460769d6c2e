"""The four-bar linkage: a crank drives a rocker through a coupler, and a point of the coupler draws a curve.

The crank O2-A turns about O2, the rocker O4-B about O4, and the coupler joins A to B.  The point P is fixed on the
coupler: rcx along A-B and rcy across it, to the left.  Points of the plane are complex numbers in here, so that a
bar is its length times a unit vector, and to turn is to multiply.
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
from mechlib.grashof import GrashofClass, grashof
from mechlib.sweep import OpenPoints

Branch = Literal["open", "crossed"]
LENGTHS = ("r1", "r2", "r3", "r4", "rcx", "rcy")

_crank, _coupler, _rocker = (Coordinate.named(f"theta_{k} omega_{k} alpha_{k}") for k in (2, 3, 4))
_bars = sp.symbols("r_1:5", positive=True)
_frame = sp.symbols("r_cx r_cy x_0 y_0 theta_0")


def _closure() -> Closure:
    r1, r2, r3, r4 = _bars
    th2, th3, th4 = (c.position for c in (_crank, _coupler, _rocker))
    return Closure(
        equations=(
            r2 * cos(th2) + r3 * cos(th3) - r1 - r4 * cos(th4),
            r2 * sin(th2) + r3 * sin(th3) - r4 * sin(th4),
        ),
        unknowns=(_coupler, _rocker),
        input=_crank,
        parameters=_bars,
    )


def _points() -> dict[str, tuple[sp.Expr, sp.Expr]]:
    (r1, r2, _, r4), (rcx, rcy, x0, y0, th0) = _bars, _frame

    def along(start, length, angle):
        x, y = start
        return x + length * cos(angle + th0), y + length * sin(angle + th0)

    O2 = x0, y0
    A, O4 = along(O2, r2, _crank.position), along(O2, r1, 0)
    P = along(along(A, rcx, _coupler.position), rcy, _coupler.position + sp.pi / 2)
    return {"O2": O2, "A": A, "B": along(O4, r4, _rocker.position), "O4": O4, "P": P}


@dataclass(frozen=True)
class FourBar:
    """A four-bar linkage with a point on its coupler; the numbers are those of source D, table 1.

    Attributes
    ----------
    r1, r2, r3, r4 : float or ndarray
        Ground O2-O4, crank O2-A, coupler A-B and rocker O4-B, m. Arrays are many linkages at once: they must
        broadcast with the angles that a method is given.
    rcx, rcy : float or ndarray
        P from A, along the coupler and across it, m.
    x0, y0 : float
        Where O2 is, m.
    theta0 : float
        Direction of the ground, from O2 to O4, rad; the angles of the bars are counted from it.

    Raises
    ------
    ValueError
        If a length of a bar is not positive, or another number not finite.

    References
    ----------
    Source D, section 1.
    """

    r1: ArrayLike = 1.08913
    r2: ArrayLike = 0.42259
    r3: ArrayLike = 0.964444
    r4: ArrayLike = 0.58781
    rcx: ArrayLike = 0.39137
    rcy: ArrayLike = 0.42950
    x0: float = 0.0
    y0: float = 0.0
    theta0: float = 0.0

    closure: ClassVar[Closure] = _closure()
    symbols: ClassVar[dict[str, tuple[sp.Expr, sp.Expr]]] = _points()
    parameters: ClassVar[tuple[sp.Symbol, ...]] = (*_bars, *_frame)

    def __post_init__(self):
        require.all_positive(r1=self.r1, r2=self.r2, r3=self.r3, r4=self.r4)
        for name in ("rcx", "rcy", "x0", "y0", "theta0"):
            require.finite(name, getattr(self, name))

    @cached_property
    def constants(self) -> tuple[ArrayLike, ...]:
        """Numbers for the parameters, in their order."""
        return (*(getattr(self, name) for name in LENGTHS), self.x0, self.y0, self.theta0)

    @cached_property
    def loop(self) -> Loop:
        """The closure with these lengths: unknowns (theta3, theta4), input theta2."""
        return self.closure.loop(self.r1, self.r2, self.r3, self.r4)

    @property
    def grashof(self) -> GrashofClass:
        """The class of the linkage that the crank drives."""
        return grashof(self.r1, self.r2, self.r3, self.r4)

    def gap(self, theta2: ArrayLike) -> np.ndarray:
        """By how much coupler and rocker are too short or too unequal to meet, m; shapes (...) -> (...)."""
        diagonal = np.abs(self.r1 - self.r2 * np.exp(1j * np.asarray(theta2)))
        return np.maximum(diagonal - (self.r3 + self.r4), np.abs(self.r3 - self.r4) - diagonal)

    @np.errstate(divide="ignore", invalid="ignore")
    def position(self, theta2: ArrayLike, branch: Branch = "open", open_points: OpenPoints = "refuse") -> np.ndarray:
        """The unknowns in closed form, on one of the two assembly branches.

        Parameters
        ----------
        theta2 : array_like, shape (...)
            Crank angle, rad.
        branch : {"open", "crossed"}
            On which side of the diagonal from A to O4 the joint B lies: to the left, as source D has it, or to
            the right.
        open_points : {"refuse", "leave out"}
            Where the loop cannot close: an error, or no number.

        Returns
        -------
        ndarray, shape (..., 2)
            theta3 and theta4, rad.

        Raises
        ------
        ValueError
            If an angle is not finite, or an option has another name.
        OpenLoopError
            If the loop cannot close at one of the angles; says which, and by how much.
        ZeroDivisionError
            If A lies on O4, about which coupler and rocker of one length then turn freely.

        References
        ----------
        Source D, section 1: the equations for theta3.
        """
        crank, coupler = self._bars(theta2, branch, open_points)
        return np.stack((np.angle(coupler), np.angle(crank + coupler - self.r1)), axis=-1)

    @np.errstate(divide="ignore", invalid="ignore")
    def coupler_point(
        self, theta2: ArrayLike, branch: Branch = "open", open_points: OpenPoints = "refuse"
    ) -> np.ndarray:
        """P in closed form, without an angle of the coupler; arguments and errors are those of `position`.

        Returns
        -------
        ndarray, shape (..., 2)
            m.

        References
        ----------
        Source D, section 1: the equations for Px and Py.
        """
        crank, coupler = self._bars(theta2, branch, open_points)
        point = coupler * (self.rcx / self.r3 + 1j * (self.rcy / self.r3))
        point += crank
        if self.theta0:
            point *= np.exp(1j * self.theta0)
        if self.x0 or self.y0:
            point += self.x0 + 1j * self.y0
        return np.asarray(point)[..., None].view(float)

    def _bars(self, theta2: ArrayLike, branch: Branch, open_points: OpenPoints) -> tuple[np.ndarray, np.ndarray]:
        """Crank O2-A and coupler A-B in the frame of the ground: two sides of a triangle on the diagonal A-O4."""
        require.one_of("branch", branch, ("open", "crossed"))
        require.one_of("open_points", open_points, ("refuse", "leave out"))
        theta2 = require.finite("theta2", theta2)
        if open_points == "refuse" and ((gap := self.gap(theta2)) > 0).any():
            raise OpenLoopError("theta_2", np.broadcast_to(theta2, gap.shape), gap)
        turned = np.exp(1j * theta2)
        coupler = self._from_diagonal(turned.real, branch, open_points)
        crank = (self.r2 + 0j) * turned
        coupler *= (self.r1 + 0j) - crank
        return crank, coupler

    def _from_diagonal(self, cosine: np.ndarray, branch: Branch, open_points: OpenPoints) -> np.ndarray:
        """What turns and stretches the diagonal from A to O4 into the coupler."""
        square = (self.r1**2 + self.r2**2) - (2 * self.r1 * self.r2) * cosine  # of the diagonal
        room = (self.r3 + self.r4) ** 2 - square
        room *= square - (self.r3 - self.r4) ** 2  # Heron: 16 times the square of the area
        if open_points == "refuse":
            room = np.maximum(room, 0.0)  # a flat triangle, rounded
            if not np.all(square):
                point = np.flatnonzero(square == 0)[0]
                raise ZeroDivisionError(f"A lies on O4 at point {point}: no direction of the rocker is determined")
        factor = np.empty(np.shape(room), complex)
        half = 0.5 / square
        np.add(half * (self.r3**2 - self.r4**2), 0.5, out=factor.real)
        np.multiply(np.sqrt(room), half if branch == "open" else -half, out=factor.imag)
        return factor

    def branch(self, q: ArrayLike) -> np.ndarray:
        """The assembly branch of closed positions; shapes (..., 2) -> (...)."""
        q = np.asarray(q)
        return np.where(np.sin(q[..., 1] - q[..., 0]) > 0, "open", "crossed")

    def transmission_angle(self, q: ArrayLike) -> np.ndarray:
        """Between coupler and rocker, 0 to pi/2 rad: how well the coupler turns it; shapes (..., 2) -> (...)."""
        q = np.asarray(q)
        return np.arccos(np.abs(np.cos(q[..., 1] - q[..., 0])))

    def dead_points(self, driver: Literal["crank", "rocker"] = "crank") -> np.ndarray:
        """Crank angles at which a driver cannot move the linkage, since the two other bars lie in one line.

        Parameters
        ----------
        driver : {"crank", "rocker"}
            The crank does not move the rocker where coupler and rocker are in line, and the linkage does not close
            beyond. The rocker does not move the crank where crank and coupler are in line: there the rocker turns
            back.

        Returns
        -------
        ndarray, shape (k,)
            theta2 from -pi to pi, rad, in order; none where the driver turns all the way round.
        """
        require.one_of("driver", driver, ("crank", "rocker"))
        if driver == "crank":
            stretched_and_folded = np.array([self.r3 + self.r4, self.r3 - self.r4])
            cosine = (self.r1**2 + self.r2**2 - stretched_and_folded**2) / (2 * self.r1 * self.r2)
        else:
            stretched_and_folded = np.array([self.r2 + self.r3, self.r2 - self.r3])
            with np.errstate(divide="ignore", invalid="ignore"):
                cosine = (self.r1**2 + stretched_and_folded**2 - self.r4**2) / (2 * self.r1 * stretched_and_folded)
        angle = np.arccos(cosine[np.abs(cosine) <= 1])
        return np.unique(np.concatenate((-angle, angle)))
