"""The mechanisms as the book shows them: which joints, bodies, traces and surroundings the figure to drag has."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from mechlib.cylinder import Cylinder
from mechlib.dynamics import trace
from mechlib.fourbar import FourBar
from mechlib.moving import Arrows, Moving, Quantity
from mechlib.sweep import Sweep
from mechlib.wiper import Wiper

ROOM = 0.1  # m, of glass beside the blades and above them
BULGE = 0.05  # m, by which the upper edge of the glass is higher in the middle
SLANT = 0.08  # m, by which it is shorter at each end than the lower one; less than the room
SUBSCRIPTS = str.maketrans("24", "₂₄")


def wiper(
    machine: Wiper, sweep: Sweep, values: Sequence[Quantity] = (), arrows: Sequence[Arrows] = (), **more
) -> Moving:
    """The windscreen wiper on its glass, with the paths of the ends of its blades.

    Parameters
    ----------
    machine : Wiper
    sweep : Sweep
        Its motion: a frame for each point. Over a whole turn, leave out the last point, which is the first again.
    values : sequence of Quantity
        Shown beside the picture, below the crank angle.
    arrows : sequence of Arrows
        To be shown on demand, at the joints O, A to H.
    **more
        Passed on to `Moving`, and before what is said here.

    Returns
    -------
    Moving
    """
    paths = {name: trace(machine, sweep, name).position for name in "OABCDEFGH"}
    fixed = {name: paths[name][0] for name in "OCF"}
    usual = {
        "joints": paths | fixed,
        "bodies": {"crank": "OA", "coupler": "AB", "first blade": "CBDG", "second blade": "FEH", "bar": "DE"},
        "ground": "OCF",
        "backdrop": windscreen(machine, sweep),
        "traces": "GH",
        "input": Quantity("θ₁", np.rad2deg(sweep.motion.position), "°"),
        "values": values,
        "arrows": arrows,
        "cyclic": True,
        "alt": (
            "A crank turns about O. Through the coupler from A to B it swings the first blade, from C over B and D to "
            "G, to and fro over a windscreen. The bar from D to E takes the second blade along, from F over E to H."
        ),
    }
    return Moving(**usual | more)


def cylinder(
    machine: Cylinder, sweep: Sweep, values: Sequence[Quantity] = (), arrows: Sequence[Arrows] = (), **more
) -> Moving:
    """The hydraulic cylinder and the rocker that it swings, with the paths of A and of the rocker's centre of mass.

    Parameters
    ----------
    machine : Cylinder
    sweep : Sweep
        Its motion, as `Cylinder.sweep` gives it: a frame for each point.
    values : sequence of Quantity
        Shown beside the picture, below the stroke.
    arrows : sequence of Arrows
        To be shown on demand, at the joints O2, P, A, O4, G4.
    **more
        Passed on to `Moving`, and before what is said here.

    Returns
    -------
    Moving
    """
    paths = {_letter(name): trace(machine, sweep, name).position for name in ("O2", "P", "A", "O4", "G4")}
    fixed = {name: paths[name][0] for name in ("O₂", "O₄")}
    line = sweep.position[:, :1]
    mouth = fixed["O₂"] + machine.ls * np.concatenate((np.cos(line), np.sin(line)), axis=1)
    usual = {
        "joints": paths | fixed | {"_mouth": mouth},
        "bodies": {"barrel": ("O₂", "_mouth"), "rod": ("P", "A"), "rocker": ("O₄", "A", "G₄")},
        "ground": ("O₂", "O₄"),
        "barrels": ("barrel",),
        "traces": ("A", "G₄"),
        "input": Quantity("a", sweep.motion.position - machine.l, "m", 3),
        "values": values,
        "arrows": _at_letters(arrows),
        "alt": (
            "The barrel of a hydraulic cylinder turns about O2. The rod slides out of it, from the piston P to A, and "
            "swings the rocker about O4. The rocker goes on beyond A, to its centre of mass G4."
        ),
    }
    return Moving(**usual | more)


def fourbar(
    linkage: FourBar,
    sweep: Sweep,
    values: Sequence[Quantity] = (),
    arrows: Sequence[Arrows] = (),
    throws: ArrayLike = (),
    enlarged: float = 5000,
    **more,
) -> Moving:
    """The four-bar linkage with the curve that the point P of its coupler draws.

    Parameters
    ----------
    linkage : FourBar
    sweep : Sweep
        Its motion: a frame for each point. Over a whole turn, leave out the last point, which is the first again.
    values : sequence of Quantity
        Shown beside the picture, below the crank angle.
    arrows : sequence of Arrows
        To be shown on demand, at the joints O2, A, B, O4, P.
    throws : array_like, shape (throws, angles, 2)
        P of linkages with thrown lengths at some crank angles, m: a cloud at each angle, which stays where it is.
    enlarged : float
        How many times larger each cloud is drawn, about its mean.
    **more
        Passed on to `Moving`, and before what is said here.

    Returns
    -------
    Moving
    """
    paths = {_letter(name): trace(linkage, sweep, name).position for name in ("O2", "A", "B", "O4", "P")}
    usual = {
        "joints": paths | {name: paths[name][0] for name in ("O₂", "O₄")},
        "bodies": {"crank": ("O₂", "A"), "coupler": "ABPA", "rocker": ("O₄", "B")},
        "ground": ("O₂", "O₄"),
        "traces": "P",
        "input": Quantity("θ₂", np.rad2deg(sweep.motion.position), "°"),
        "values": values,
        "arrows": _at_letters(arrows),
        "cyclic": True,
        "alt": (
            "A crank turns about O2. The coupler, a triangle with the corners A, B and P, joins it to a rocker that "
            "swings about O4. The point P draws a closed curve."
        ),
    }
    if np.size(throws):
        means = np.mean(throws, axis=0)
        usual["cloud"] = np.reshape(means + enlarged * (throws - means), (-1, 2))
    return Moving(**usual | more)


def windscreen(machine: Wiper, sweep: Sweep) -> np.ndarray:
    """Outline of a glass as large as the blades need along a motion, m; shape (points, 2). No source gives one."""
    ends = np.concatenate([trace(machine, sweep, name).position for name in "GH"])
    (left, low), (right, high) = ends.min(axis=0) - ROOM, ends.max(axis=0) + ROOM
    along = np.linspace(-1, 1, 25)
    middle, half = (left + right) / 2, (right - left) / 2
    top = np.column_stack((middle + (half - SLANT) * along, high - BULGE * along**2))
    return np.concatenate(([(right, low), (left, low)], top))


def _letter(name: str) -> str:
    """As it stands beside a joint."""
    return name.translate(SUBSCRIPTS)


def _at_letters(arrows: Sequence[Arrows]) -> list[Arrows]:
    return [replace(each, vectors={_letter(name): v for name, v in each.vectors.items()}) for each in arrows]
