"""Newton's and Euler's equations of a mechanism, assembled from bodies and joints that are called by their names.

Each body gives three equations, each joint two unknown forces.  The equations are linear in the forces, in the torque
of the motor and in the accelerations.  Which of them are known makes the difference between inverse dynamics (the
motion is given) and direct dynamics (the torque is given, and the closure adds its acceleration equations).
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy as sp

from mechlib import require
from mechlib.closure import Closure, Coordinate, compiled

Point = tuple[sp.Expr, sp.Expr]
GROUND = "ground"


def steiner(inertia: float, mass: float, distance: float) -> float:
    """Moment of inertia about an axis that does not go through the centre of mass.

    Parameters
    ----------
    inertia : float
        About the parallel axis through the centre of mass, kg m^2.
    mass : float
        kg.
    distance : float
        Between the two axes, m.

    Returns
    -------
    float
        kg m^2.
    """
    return inertia + mass * distance**2


@dataclass(frozen=True)
class MassProperties:
    """Mass, moment of inertia and centre of mass of a bar.

    Attributes
    ----------
    mass : float
        kg.
    inertia : float
        About the centre of mass, kg m^2.
    centre : float
        Distance of the centre of mass from the joint or the end at which the bar begins, m.
    """

    mass: float
    inertia: float
    centre: float

    def __post_init__(self):
        require.positive(mass=self.mass, inertia=self.inertia, centre=self.centre)

    @classmethod
    def about_joint(cls, mass: float, inertia: float, centre: float) -> "MassProperties":
        """With the moment of inertia about the joint, from which the centre of mass is so far; see `steiner`."""
        return cls(mass, steiner(inertia, -mass, centre), centre)

    @classmethod
    def slender(cls, mass: float, length: float, centre: float) -> "MassProperties":
        """Of a thin, straight bar of that length, alike all along."""
        return cls(mass, mass * length**2 / 12, centre)


@dataclass(frozen=True)
class Body:
    """A rigid body in the plane.

    Attributes
    ----------
    name : str
    mass, inertia : Symbol
        The moment of inertia about the centre of mass.
    centre : Point
        The centre of mass, in the coordinates of the closure.
    angle : Coordinate or None
        What it turns with; None if it moves in translation.
    about : str
        The joint about which its moments are taken.
    """

    name: str
    mass: sp.Symbol
    inertia: sp.Symbol
    centre: Point
    angle: Coordinate | None
    about: str


@dataclass(frozen=True)
class Joint:
    """A pin that joins two bodies.

    Attributes
    ----------
    name : str
    at : Point
    on, by : str
        Its force acts on the first as it is, and on the second with the opposite sign; either may be "ground".
    """

    name: str
    at: Point
    on: str
    by: str

    @property
    def unknowns(self) -> tuple[sp.Symbol, sp.Symbol]:
        """What is not known of its force and of its moment."""
        return sp.symbols(f"{self.name}_x {self.name}_y")

    @property
    def force(self) -> tuple[sp.Expr, sp.Expr]:
        """On the first body, along x and y."""
        return self.unknowns

    @property
    def moment(self) -> sp.Expr:
        """On the first body, beside that of the force; a pin has none."""
        return sp.S.Zero


@dataclass(frozen=True)
class Slide(Joint):
    """A straight guide: two bodies slide along a line that turns with them, and cannot turn against each other.

    Its unknowns are the force across the line and the moment.

    Attributes
    ----------
    along : Coordinate
        The angle of the line; a quarter turn on from it the force across is positive.
    """

    along: Coordinate

    @property
    def unknowns(self) -> tuple[sp.Symbol, sp.Symbol]:
        return sp.symbols(f"{self.name}_n {self.name}_m")

    @property
    def force(self) -> tuple[sp.Expr, sp.Expr]:
        across, angle = self.unknowns[0], self.along.position
        return -across * sp.sin(angle), across * sp.cos(angle)

    @property
    def moment(self) -> sp.Expr:
        return self.unknowns[1]

    def push(self, size: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
        """A force of that size along the line, along x and y."""
        return size * sp.cos(self.along.position), size * sp.sin(self.along.position)


@dataclass(frozen=True)
class Load:
    """A force that is known, at the centre of mass of a body.

    Attributes
    ----------
    on : str
    force : pair of Symbol
    """

    on: str
    force: tuple[sp.Symbol, sp.Symbol]


@dataclass(frozen=True)
class LinearSystem:
    """matrix x = right, in symbols, with a name for each row and each column.

    Attributes
    ----------
    rows : tuple of str
    columns : tuple of str
    matrix, right : Matrix
    """

    rows: tuple[str, ...]
    columns: tuple[str, ...]
    matrix: sp.Matrix
    right: sp.Matrix

    def compiled(self, arguments: tuple[sp.Symbol, ...]) -> Callable[..., np.ndarray]:
        """Its solution x at many points at once, as a function of these arguments: (...) each -> (..., n)."""
        matrix, right = compiled(arguments, self.matrix), compiled(arguments, self.right)
        return lambda *values: np.linalg.solve(matrix(*values), right(*values))[..., 0]


@dataclass(frozen=True)
class RigidBodies:
    """A mechanism with its masses.

    Attributes
    ----------
    closure : Closure
        How its coordinates hang together.
    bodies : tuple of Body
    joints : tuple of Joint
    loads : tuple of Load
    motor : str
        The body on which the torque of the motor acts; the motor stands on the ground.  Or the slide along which a
        cylinder pushes the first body away from the second.
    """

    closure: Closure
    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    loads: tuple[Load, ...]
    motor: str

    torque, thrust = sp.symbols("M Q")
    gravity = sp.Symbol("g")

    @cached_property
    def drive(self) -> sp.Symbol:
        """What drives the mechanism: the torque of a motor, or the thrust of a cylinder."""
        return self.thrust if self.motor in {joint.name for joint in self.joints} else self.torque

    @cached_property
    def forces(self) -> tuple[sp.Symbol, ...]:
        """The unknowns of the joints, joint after joint."""
        return tuple(unknown for joint in self.joints for unknown in joint.unknowns)

    def transmitted(self, joint: Joint) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        """Force along x and y and moment on the first body of a joint, with the thrust of the cylinder in it."""
        x, y = joint.push(self.thrust) if joint.name == self.motor else (0, 0)
        return joint.force[0] + x, joint.force[1] + y, joint.moment

    @cached_property
    def accelerations(self) -> tuple[sp.Symbol, ...]:
        """Of the input and of the unknowns of the closure."""
        return tuple(c.acceleration for c in (self.closure.input, *self.closure.unknowns))

    @cached_property
    def equations(self) -> dict[str, sp.Expr]:
        """Newton in x and y and Euler for each body, by their names; zero where they hold."""
        found = {}
        for body in self.bodies:
            found |= self._of(body)
        return found

    def _of(self, body: Body) -> dict[str, sp.Expr]:
        acting, moment = [], sp.S.Zero
        for joint in self.joints:
            if body.name in (joint.on, joint.by):
                x, y, m = (part if body.name == joint.on else -part for part in self.transmitted(joint))
                acting.append((joint.at, (x, y)))
                moment += m
        acting += [(body.centre, load.force) for load in self.loads if load.on == body.name]
        acting += [(body.centre, (0, -body.mass * self.gravity))]
        inertial = tuple(-body.mass * a for a in self.acceleration(body.centre))
        about = next(joint.at for joint in self.joints if joint.name == body.about)
        moment += sum(_moment(at, about, force) for at, force in (*acting, (body.centre, inertial)))
        if body.angle is not None:
            moment -= body.inertia * body.angle.acceleration
        if body.name == self.motor:
            moment += self.torque
        names = f"{body.name}, x", f"{body.name}, y", f"{body.name}, moment about {body.about}"
        sums = (sum(f[i] for _, f in acting) + inertial[i] for i in (0, 1))
        return dict(zip(names, (*sums, moment), strict=True))

    def velocity(self, point: Point) -> sp.Matrix:
        return self.closure.time_derivative(sp.Matrix(point))

    def acceleration(self, point: Point) -> sp.Matrix:
        return self.closure.time_derivative(self.velocity(point))

    @cached_property
    def inverse(self) -> LinearSystem:
        """The motion is given: what drives and the joint forces are unknown."""
        return _linear(self.equations, (self.drive, *self.forces))

    @cached_property
    def direct(self) -> LinearSystem:
        """What drives is given: accelerations and joint forces are unknown, and the closure adds its equations."""
        closed = {f"closure {k}": e for k, e in enumerate(self.closure.acceleration_equations, start=1)}
        return _linear(self.equations | closed, (*self.accelerations, *self.forces))

    @cached_property
    def kinetic_energy(self) -> sp.Expr:
        total = sp.S.Zero
        for body in self.bodies:
            total += body.mass * sum(v**2 for v in self.velocity(body.centre)) / 2
            if body.angle is not None:
                total += body.inertia * body.angle.velocity**2 / 2
        return total

    @cached_property
    def potential_energy(self) -> sp.Expr:
        return sum(body.mass * self.gravity * body.centre[1] for body in self.bodies)

    @cached_property
    def power(self) -> sp.Expr:
        """What drives gives: the energies' rate of change, less what the loads give."""
        energy = sp.Matrix([self.kinetic_energy + self.potential_energy])
        centres = {body.name: body.centre for body in self.bodies}
        of_loads = sum((sp.Matrix(load.force).dot(self.velocity(centres[load.on])) for load in self.loads), sp.S.Zero)
        return self.closure.time_derivative(energy)[0] - of_loads


def _moment(at: Point, about: Point, force: tuple) -> sp.Expr:
    return (at[0] - about[0]) * force[1] - (at[1] - about[1]) * force[0]


def _linear(equations: dict[str, sp.Expr], unknowns: tuple[sp.Symbol, ...]) -> LinearSystem:
    column = sp.Matrix(list(equations.values()))
    matrix = column.jacobian(unknowns)
    right = -column.subs(dict.fromkeys(unknowns, 0))
    return LinearSystem(tuple(equations), tuple(str(symbol) for symbol in unknowns), matrix, right)
