"""The windscreen wiper: a crank drives a rocker through a coupler, and a bar between two blades makes a parallelogram.

The crank O-A, the coupler A-B and the rocker C-B are a four-bar linkage on the ground O-C.  The rocker goes on through
B to D and carries a blade to its end G.  The bar D-E takes the second blade F-E along, which stays parallel to the
first and ends in H.
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
from mechlib.rigidbody import GROUND, Body, Joint, Load, MassProperties, RigidBodies

Branch = Literal["open", "crossed"]
CRANK, COUPLER, FIRST, SECOND, BAR = BODIES = ("crank", "coupler", "first blade", "second blade", "bar")

_crank, _coupler, _rocker = (Coordinate.named(f"theta_{k} omega_{k} alpha_{k}") for k in (1, 2, 3))
_lengths = sp.symbols("r_0:7", positive=True)
_centres = sp.symbols("r_G1:6", positive=True)
_masses, _inertias = sp.symbols("m_1:6", positive=True), sp.symbols("I_1:6", positive=True)


def _points() -> dict[str, tuple[sp.Expr, sp.Expr]]:
    r0, r1, _, r3, r4, r5, r6 = _lengths

    def along(start, length, coordinate):
        x, y = start
        return x + length * cos(coordinate.position), y + length * sin(coordinate.position)

    O, C, F = (sp.S.Zero, sp.S.Zero), (r0, sp.S.Zero), (r0 + r5, sp.S.Zero)
    A, B, D = along(O, r1, _crank), along(C, r3, _rocker), along(C, r4, _rocker)
    E, G, H = along(F, r4, _rocker), along(C, r6, _rocker), along(F, r6, _rocker)
    g1, g2, g3, g4, g5 = _centres
    centres = {
        "G1": along(O, g1, _crank),
        "G2": along(A, g2, _coupler),
        "G3": along(C, g3, _rocker),
        "G4": along(F, g4, _rocker),
        "G5": (D[0] + g5, D[1]),  # the bar stays parallel to the ground
    }
    return {"O": O, "A": A, "B": B, "C": C, "D": D, "E": E, "F": F, "G": G, "H": H} | centres


def _closure() -> Closure:
    r0, r1, r2, r3 = _lengths[:4]
    th1, th2, th3 = (c.position for c in (_crank, _coupler, _rocker))
    return Closure(
        equations=(
            r0 - r1 * cos(th1) - r2 * cos(th2) + r3 * cos(th3),
            r1 * sin(th1) + r2 * sin(th2) - r3 * sin(th3),
        ),
        unknowns=(_coupler, _rocker),
        input=_crank,
        parameters=(r0, r1, r2, r3),
    )


def _rigid(closure: Closure, points: dict) -> RigidBodies:
    turning = (_crank, _coupler, _rocker, _rocker, None)
    about = ("O", "A", "C", "F", "D")
    return RigidBodies(
        closure=closure,
        bodies=tuple(
            Body(name, m, inertia, points[f"G{k}"], angle, joint)
            for k, (name, m, inertia, angle, joint) in enumerate(
                zip(BODIES, _masses, _inertias, turning, about, strict=True), start=1
            )
        ),
        joints=tuple(
            Joint(name, points[name], on, by)
            for name, on, by in (
                ("O", CRANK, GROUND),
                ("A", CRANK, COUPLER),
                ("B", COUPLER, FIRST),
                ("C", FIRST, GROUND),
                ("D", FIRST, BAR),
                ("E", BAR, SECOND),
                ("F", SECOND, GROUND),
            )
        ),
        loads=(Load(FIRST, sp.symbols("f_3x f_3y")), Load(SECOND, sp.symbols("f_4x f_4y"))),
        motor=CRANK,
    )


@dataclass(frozen=True)
class Wiper:
    """A windscreen wiper; lengths and masses are those of source B's program.

    Attributes
    ----------
    r0 : float or ndarray
        Ground O-C, m. Arrays are many wipers at once: they must broadcast with the angles that a method is given.
    r1, r2, r3 : float or ndarray
        Crank O-A, coupler A-B, and C-B on the first blade, m.
    r4 : float or ndarray
        C-D and F-E, m.
    r5 : float or ndarray
        Bar D-E, which is C-F, m.
    r6 : float or ndarray
        C-G and F-H, from the joints to the ends of the blades, m.
    masses : tuple of 5 MassProperties
        Of the crank, the coupler, the first blade, the second blade and the bar.
    g : float
        m/s^2.

    Raises
    ------
    ValueError
        If a number is not positive.
    """

    r0: float = 0.245
    r1: float = 0.105
    r2: float = 0.220
    r3: float = 0.150
    r4: float = 0.300
    r5: float = 0.300
    r6: float = 0.645
    masses: tuple[MassProperties, ...] = (
        MassProperties.about_joint(0.08821, 0.0003443403325, 0.0525),
        MassProperties.about_joint(0.17773, 0.002934475, 0.110),
        MassProperties.about_joint(0.43452, 0.050703593, 0.29047),
        MassProperties.about_joint(0.43758, 0.050773125, 0.28949),
        MassProperties(0.24013, 1.91677341e-3, 0.150),
    )
    g: float = 9.81

    closure: ClassVar[Closure] = _closure()
    symbols: ClassVar[dict[str, tuple[sp.Expr, sp.Expr]]] = _points()
    rigid: ClassVar[RigidBodies] = _rigid(closure, symbols)
    parameters: ClassVar[tuple[sp.Symbol, ...]] = (*_lengths, *_centres, *_masses, *_inertias, RigidBodies.gravity)

    def __post_init__(self):
        require.all_positive(**{f"r{k}": getattr(self, f"r{k}") for k in range(7)})
        require.positive(g=self.g)
        if len(self.masses) != len(BODIES):
            raise ValueError(f"masses must be {len(BODIES)}, of {', '.join(BODIES)}; got {len(self.masses)}")

    @cached_property
    def constants(self) -> tuple[float, ...]:
        """Numbers for the parameters, in their order."""
        lengths = (getattr(self, f"r{k}") for k in range(7))
        of_bars = (getattr(bar, name) for name in ("centre", "mass", "inertia") for bar in self.masses)
        return (*lengths, *of_bars, self.g)

    @cached_property
    def loop(self) -> Loop:
        """The closure with these lengths: unknowns (theta2, theta3), input theta1."""
        return self.closure.loop(self.r0, self.r1, self.r2, self.r3)

    @property
    def grashof(self) -> GrashofClass:
        """The class of the linkage that the crank drives."""
        return grashof(self.r0, self.r1, self.r2, self.r3)

    def gap(self, theta1: ArrayLike) -> np.ndarray:
        """By how much coupler and rocker are too short or too unequal to meet, m; shapes (...) -> (...)."""
        distance = np.hypot(self.r0 - self.r1 * np.cos(theta1), self.r1 * np.sin(theta1))
        return np.maximum(distance - (self.r2 + self.r3), np.abs(self.r2 - self.r3) - distance)

    def position(self, theta1: ArrayLike, branch: Branch = "open") -> np.ndarray:
        """The unknowns in closed form, on one of the two assembly branches.

        Parameters
        ----------
        theta1 : array_like, shape (...)
            Crank angle, rad.
        branch : {"open", "crossed"}
            The wiper is built open: the rocker is ahead of the coupler by less than half a turn.

        Returns
        -------
        ndarray, shape (..., 2)
            theta2 and theta3, rad.

        Raises
        ------
        ValueError
            If an angle is not finite, or the branch has another name.
        OpenLoopError
            If the loop cannot close at one of the angles; says which, and by how much.
        """
        theta1 = require.finite("theta1", theta1)
        require.one_of("branch", branch, ("open", "crossed"))
        if ((gap := self.gap(theta1)) > 0).any():
            raise OpenLoopError("theta_1", np.broadcast_to(theta1, gap.shape), gap)
        x, y = self.r0 - self.r1 * np.cos(theta1), -self.r1 * np.sin(theta1)  # from A to C
        distance = np.hypot(x, y)
        at_c = np.arccos((distance**2 + self.r3**2 - self.r2**2) / (2 * distance * self.r3))
        theta3 = np.arctan2(y, x) + np.pi + (-at_c if branch == "open" else at_c)
        theta2 = np.arctan2(y + self.r3 * np.sin(theta3), x + self.r3 * np.cos(theta3))
        return np.stack((theta2, theta3), axis=-1)

    def branch(self, q: ArrayLike) -> np.ndarray:
        """The assembly branch of closed positions; shapes (..., 2) -> (...)."""
        q = np.asarray(q)
        return np.where(np.sin(q[..., 1] - q[..., 0]) > 0, "open", "crossed")

    def transmission_angle(self, q: ArrayLike) -> np.ndarray:
        """Between coupler and rocker, 0 to pi/2 rad: how well the coupler turns it; shapes (..., 2) -> (...)."""
        q = np.asarray(q)
        return np.arccos(np.abs(np.cos(q[..., 1] - q[..., 0])))
