"""A mechanism that a hydraulic cylinder moves: the cylinder stands on the ground at O2 and swings a rocker about O4.

The barrel turns about O2.  In it slides the rod, which carries the piston P at one end and is joined to the rocker at
the other, A.  The length O2-A is s = a + l: the stroke a, which is where the piston is, and the length l of the rod.
The rocker goes from O4, the origin, to A and beyond.
"""

from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import ClassVar, Literal

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike
from sympy import cos, sin

from mechlib import dynamics, require
from mechlib.closure import Closure, Coordinate, Loop, OpenLoopError, compiled
from mechlib.eksergian import velocity_ratios
from mechlib.motion import Motion
from mechlib.rigidbody import GROUND, Body, Joint, MassProperties, RigidBodies, Slide
from mechlib.sweep import Sweep

Branch = Literal["right", "left"]
BARREL, ROD, ROCKER = BODIES = ("barrel", "rod", "rocker")

_length = Coordinate.named("s v_s a_s")
_line, _rocker = (Coordinate.named(f"theta_{k} omega_{k} alpha_{k}") for k in (2, 4))
_o2, _o4, _b, _l = _lengths = sp.symbols("o_2 o_4 b l", positive=True)
_centres = sp.symbols("g_2:5", positive=True)
_masses, _inertias = sp.symbols("m_2:5", positive=True), sp.symbols("I_2:5", positive=True)


def _points() -> dict[str, tuple[sp.Expr, sp.Expr]]:
    def on_line(distance):
        return _o2 + distance * cos(_line.position), -_o4 + distance * sin(_line.position)

    def on_rocker(distance):
        return distance * cos(_rocker.position), distance * sin(_rocker.position)

    stroke, (g2, g3, g4) = _length.position - _l, _centres
    joints = {"O2": on_line(0), "O4": on_rocker(0), "P": on_line(stroke), "A": on_line(_length.position)}
    return joints | {"G2": on_line(g2), "G3": on_line(stroke + g3), "G4": on_rocker(g4)}


def _closure(points: dict) -> Closure:
    end_of_rod, end_of_rocker = points["A"], (_b * cos(_rocker.position), _b * sin(_rocker.position))
    return Closure(
        equations=tuple(p - q for p, q in zip(end_of_rod, end_of_rocker, strict=True)),
        unknowns=(_line, _rocker),
        input=_length,
        parameters=(_o2, _o4, _b),
    )


def _rigid(closure: Closure, points: dict) -> RigidBodies:
    barrel, rod, rocker = zip(BODIES, _masses, _inertias, (points[f"G{k}"] for k in (2, 3, 4)), strict=True)
    return RigidBodies(
        closure=closure,
        bodies=(Body(*barrel, _line, "O2"), Body(*rod, _line, "A"), Body(*rocker, _rocker, "O4")),
        joints=(
            Joint("O2", points["O2"], BARREL, GROUND),
            Slide("P", points["P"], ROD, BARREL, _line),
            Joint("A", points["A"], ROD, ROCKER),
            Joint("O4", points["O4"], ROCKER, GROUND),
        ),
        loads=(),
        motor="P",
    )


@dataclass(frozen=True)
class Swing:
    """A stroke that goes to and fro: a = middle + amplitude sin(2 pi frequency t); the numbers are those of source C.

    Attributes
    ----------
    middle, amplitude : float
        m.
    frequency : float
        1/s.

    Raises
    ------
    ValueError
        If one of them is not a positive number.
    """

    middle: float = 0.6
    amplitude: float = 0.02
    frequency: float = 1.0

    def __post_init__(self):
        require.positive(middle=self.middle, amplitude=self.amplitude, frequency=self.frequency)

    def at(self, t: ArrayLike) -> Motion:
        """The stroke and its rates at increasing instants; shape (points,)."""
        t, w = require.finite("t", t), 2 * np.pi * self.frequency
        swung, rate = self.amplitude * np.sin(w * t), self.amplitude * w * np.cos(w * t)
        return Motion(t, self.middle + swung, rate, -(w**2) * swung)


@dataclass(frozen=True)
class Cylinder:
    """A mechanism moved by a hydraulic cylinder; the numbers are those of source C, but for the inertia of the rocker.

    Attributes
    ----------
    o2, o4 : float
        O4 is the origin, and O2 lies at (o2, -o4), m.
    b : float
        O4-A on the rocker, m.
    l : float
        Length of the rod, m.
    li, ls : float
        Where the room of the piston begins and ends in the barrel, from O2, m.
    e : float
        Thickness of the piston, m; its middle is at the stroke a.
    piston_radius, rod_radius : float
        m.
    masses : tuple of 3 MassProperties
        Of the barrel (measured from O2), the rod (from P) and the rocker (from O4).
    g : float
        m/s^2.

    Raises
    ------
    ValueError
        If a number is not positive, the piston or the rod does not fit, or stops and triangle leave no stroke.

    References
    ----------
    Source C, geometrical parameters.
    """

    o2: float = 0.25
    o4: float = 1.0
    b: float = 0.25
    l: float = 0.4
    li: float = 0.4
    ls: float = 0.8
    e: float = 0.010
    piston_radius: float = 0.016
    rod_radius: float = 0.008
    masses: tuple[MassProperties, ...] = (
        MassProperties.slender(5.0, 2 * 0.3, 0.3),
        MassProperties.slender(2.0, 0.4, 0.2),
        MassProperties.slender(1.0, 2 * 0.6, 0.6),
    )
    g: float = 9.80665

    symbols: ClassVar[dict[str, tuple[sp.Expr, sp.Expr]]] = _points()
    closure: ClassVar[Closure] = _closure(symbols)
    rigid: ClassVar[RigidBodies] = _rigid(closure, symbols)
    parameters: ClassVar[tuple[sp.Symbol, ...]] = (*_lengths, *_centres, *_masses, *_inertias, RigidBodies.gravity)

    def __post_init__(self):
        names = ("o2", "o4", "b", "l", "li", "ls", "e", "piston_radius", "rod_radius", "g")
        require.positive(**{name: getattr(self, name) for name in names})
        if len(self.masses) != len(BODIES):
            raise ValueError(f"masses must be {len(BODIES)}, of {', '.join(BODIES)}; got {len(self.masses)}")
        if self.rod_radius >= self.piston_radius:
            raise ValueError(f"the rod must be thinner than the piston, {self.piston_radius} m, got {self.rod_radius}")
        if self.li + self.e >= self.ls:
            raise ValueError(f"a piston of {self.e} m has no stroke between li = {self.li} and ls = {self.ls} m")
        low, high = self.stroke
        if low >= high:
            raise ValueError(
                f"no stroke: the stops leave {_span(self.stops)}, and the triangle {_span(self.reach, -self.l)}"
            )

    @cached_property
    def constants(self) -> tuple[float, ...]:
        """Numbers for the parameters, in their order."""
        of_bodies = (getattr(body, name) for name in ("centre", "mass", "inertia") for body in self.masses)
        return (self.o2, self.o4, self.b, self.l, *of_bodies, self.g)

    @cached_property
    def loop(self) -> Loop:
        """The closure with these lengths: unknowns (theta2, theta4), input s."""
        return self.closure.loop(self.o2, self.o4, self.b)

    @property
    def d(self) -> float:
        """O2-O4, m."""
        return float(np.hypot(self.o2, self.o4))

    @property
    def stops(self) -> tuple[float, float]:
        """Smallest and largest stroke a at which the piston stands at the end of its room, m."""
        return self.li + self.e / 2, self.ls - self.e / 2

    @property
    def reach(self) -> tuple[float, float]:
        """Smallest and largest length s that closes the triangle, m; there it is flat: no velocity is determined."""
        return abs(self.d - self.b), self.d + self.b

    @property
    def stroke(self) -> tuple[float, float]:
        """Smallest and largest stroke a that stops and triangle allow, m."""
        (first, last), (short, long) = self.stops, self.reach
        return max(first, short - self.l), min(last, long - self.l)

    @property
    def areas(self) -> tuple[float, float]:
        """Of the piston on the side of O2, and of the ring that the rod leaves on the other side, m^2."""
        whole, rod = np.pi * self.piston_radius**2, np.pi * self.rod_radius**2
        return whole, whole - rod

    def gap(self, s: ArrayLike) -> np.ndarray:
        """By how much the cylinder is too short or too long for the triangle, m; shapes (...) -> (...)."""
        short, long = self.reach
        return np.maximum(short - np.asarray(s), np.asarray(s) - long)

    def position(self, s: ArrayLike, branch: Branch = "right") -> np.ndarray:
        """The unknowns in closed form, on one of the two assembly branches.

        Parameters
        ----------
        s : array_like, shape (...)
            Length O2-A, m.
        branch : {"right", "left"}
            The side on which A lies, seen from O2 towards O4; that of source C is the right.

        Returns
        -------
        ndarray, shape (..., 2)
            theta2 and theta4, rad.

        Raises
        ------
        ValueError
            If a length is not positive and finite, or the branch has another name.
        OpenLoopError
            If the triangle cannot close at one of the lengths; says which, and what the limits are.

        References
        ----------
        Source C, geometry.
        """
        s = require.finite("s", s)
        require.one_of("branch", branch, ("right", "left"))
        if (s <= 0).any():
            raise ValueError(f"s must be positive, got {s[s <= 0].flat[0]}")
        if (self.gap(s) > 0).any():
            raise OpenLoopError("s", s, self.gap(s), f"the triangle closes {_span(self.reach)}")
        short, long = self.reach
        # the half angle, and the other angle from it: near a flat triangle an inverse cosine keeps half of the digits
        # only, of two of them each its own half, so that they leave the loop open; and it may get more than one
        phi = 2 * np.arctan2(np.sqrt((s - short) * (s + short)), np.sqrt((long - s) * (long + s)))
        psi = np.arctan2(self.b * np.sin(phi), self.d - self.b * np.cos(phi))
        beta, side = np.arctan2(self.o4, self.o2), 1 if branch == "right" else -1
        return np.stack((np.pi - beta - side * psi, side * phi - beta), axis=-1)

    def branch(self, q: ArrayLike) -> np.ndarray:
        """The assembly branch of closed positions; shapes (..., 2) -> (...)."""
        q = np.asarray(q)
        return np.where(np.sin(q[..., 0] - q[..., 1]) > 0, "right", "left")

    def ratios(self, s: ArrayLike, q: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """What the angles change by with the length: k = dq/ds and h = dk/ds; shapes (...), (..., 2) -> twice (..., 2).

        At any motion q' = k v and q'' = k acc + h v^2.

        Raises
        ------
        ZeroDivisionError
            Where the triangle is flat.
        """
        return self.loop.rates(q, s, 1.0, 0.0)

    def length(self, stroke: Motion) -> Motion:
        """The length s = a + l along a motion of the stroke a: what `sweep` takes."""
        return replace(stroke, position=stroke.position + self.l)

    def sweep(self, motion: Motion, branch: Branch = "right") -> Sweep:
        """The angles and their rates along a motion, the positions in closed form.

        Parameters
        ----------
        motion : Motion
            Of the length s.
        branch : {"right", "left"}

        Returns
        -------
        Sweep

        Raises
        ------
        ValueError
            If the piston meets a stop; says when, and what the limits are.
        OpenLoopError
            If the triangle cannot close.
        ZeroDivisionError
            Where the triangle is flat.
        """
        s, (first, last) = motion.position, self.stops
        beyond = np.flatnonzero((s < first + self.l) | (s > last + self.l))
        if beyond.size:
            k = beyond[0]
            raise ValueError(
                f"the piston meets its stop at t = {motion.t[k]:.6g} s, a = {s[k] - self.l:.6g} m: "
                f"it can move {_span(self.stops)}"
            )
        q = self.position(s, branch)
        rates = self.loop.rates(q, s, motion.velocity, motion.acceleration)
        return Sweep(motion, q, *rates, np.zeros(len(s), int), np.zeros(len(s)))

    def pressures(self, force: ArrayLike, back: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """Pressures in the two chambers, above that of the air.

        One chamber carries the load. The other is open to the return line, whose pressure is constant: below it falls
        neither of them, in whichever direction the piston moves. Friction of the seals is left out.

        Parameters
        ----------
        force : array_like, shape (...)
            Q of the cylinder, positive where it pushes, N.
        back : float
            Pressure of the return line, Pa.

        Returns
        -------
        piston, rod : ndarray, shape (...)
            On the side of the whole piston and on the side of the rod, Pa.

        Raises
        ------
        ValueError
            If a force is not finite, or the pressure of the return line is negative.
        """
        force, (whole, ring) = require.finite("force", force), self.areas
        if not 0 <= back < np.inf:
            raise ValueError(f"back must not be negative, got {back}")
        return np.maximum((force + back * ring) / whole, back), np.maximum((back * whole - force) / ring, back)


def virtual_power(cylinder: Cylinder, sweep: Sweep) -> np.ndarray:
    """Force of the cylinder, by the power of all forces at a virtual velocity of one metre a second.

    The virtual velocity need not be that of the motion: nothing is divided by a velocity that passes zero.

    Parameters
    ----------
    cylinder : Cylinder
    sweep : Sweep
        Its motion, as `Cylinder.sweep` gives it.

    Returns
    -------
    ndarray, shape (points,)
        Q, positive where the cylinder pushes, N.

    References
    ----------
    Source C, inverse dynamics.
    """
    motion = sweep.motion
    k, _ = cylinder.ratios(motion.position, sweep.position)
    virtual = replace(sweep, motion=replace(motion, velocity=np.ones(len(motion))), velocity=k)
    Q, lift = np.zeros(len(motion)), np.array([0.0, cylinder.g])
    for body, centre, turning in zip(cylinder.masses, ("G2", "G3", "G4"), (0, 0, 1), strict=True):
        force = body.mass * (dynamics.trace(cylinder, sweep, centre).acceleration + lift)
        Q += (force * dynamics.trace(cylinder, virtual, centre).velocity).sum(axis=1)
        Q += body.inertia * sweep.acceleration[:, turning] * k[:, turning]
    return Q


def lagrange_equation(rigid: RigidBodies) -> sp.Expr:
    """d/dt(dT/dv) - dT/du + dV/du of a mechanism with the one input u, in symbols.

    The unknowns move with u: q' = k v turns the kinetic energy into one of u and v, and a derivative by u follows them.
    Of the cylinder u is s; by the stroke a = s - l all derivatives are the same.
    """
    u, unknowns = rigid.closure.input, rigid.closure.unknowns
    k, _ = velocity_ratios(rigid.closure)
    T = rigid.kinetic_energy.subs({q.velocity: ratio * u.velocity for q, ratio in zip(unknowns, k, strict=True)})
    V = rigid.potential_energy

    def by_input(f: sp.Expr) -> sp.Expr:
        return f.diff(u.position) + sum(f.diff(q.position) * ratio for q, ratio in zip(unknowns, k, strict=True))

    momentum = T.diff(u.velocity)
    in_time = by_input(momentum) * u.velocity + momentum.diff(u.velocity) * u.acceleration
    return in_time - by_input(T) + by_input(V)


def lagrange(cylinder: Cylinder, sweep: Sweep) -> np.ndarray:
    """Force of the cylinder by Lagrange's equation; as for `virtual_power`.

    References
    ----------
    Source C, direct dynamics.
    """
    return _lagrange(type(cylinder))(*dynamics.values(cylinder, sweep))[..., 0, 0]


def newton_euler(cylinder: Cylinder, sweep: Sweep) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Force of the cylinder and of all joints, from Newton's and Euler's nine equations of the three bodies.

    Parameters
    ----------
    cylinder, sweep
        As for `virtual_power`.

    Returns
    -------
    Q : ndarray, shape (points,)
        N.
    forces : dict of str to ndarray, shape (points, 2)
        Force along x and y on the barrel at O2, on the rod at A, on the rocker at O4, N. At P the barrel's force on the
        rod across its line, N, and its moment about the middle of the piston, N m.
    """
    found = dynamics.inverse_dynamics(cylinder, sweep)
    return found.torque, found.forces


def energies(cylinder: Cylinder, sweep: Sweep) -> tuple[np.ndarray, np.ndarray]:
    """Kinetic and potential energy along a motion, J; the potential energy is zero at the height of O4."""
    kinetic, potential = _energies(type(cylinder))(*dynamics.values(cylinder, sweep))[..., 0].T
    return kinetic, potential


@cache
def _lagrange(machine: type[Cylinder]):
    return compiled(dynamics.arguments(machine), sp.Matrix([lagrange_equation(machine.rigid)]))


@cache
def _energies(machine: type[Cylinder]):
    rigid = machine.rigid
    return compiled(dynamics.arguments(machine), sp.Matrix([rigid.kinetic_energy, rigid.potential_energy]))


def _span(limits: tuple[float, float], shift: float = 0.0) -> str:
    low, high = (limit + shift for limit in limits)
    return f"from {low:.6g} to {high:.6g} m"
