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
    def force(self) -> tuple[sp.Symbol, sp.Symbol]:
        return sp.symbols(f"{self.name}_x {self.name}_y")


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
        The body on which the torque of the motor acts; the motor stands on the ground.
    """

    closure: Closure
    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    loads: tuple[Load, ...]
    motor: str

    torque = sp.Symbol("M")
    gravity = sp.Symbol("g")

    @cached_property
    def forces(self) -> tuple[sp.Symbol, ...]:
        """The components of the joint forces, joint after joint."""
        return tuple(component for joint in self.joints for component in joint.force)

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
        acting = [(j.at, j.force) for j in self.joints if j.on == body.name]
        acting += [(j.at, tuple(-f for f in j.force)) for j in self.joints if j.by == body.name]
        acting += [(body.centre, load.force) for load in self.loads if load.on == body.name]
        acting += [(body.centre, (0, -body.mass * self.gravity))]
        inertial = tuple(-body.mass * a for a in self.acceleration(body.centre))
        about = next(joint.at for joint in self.joints if joint.name == body.about)
        moment = sum(_moment(at, about, force) for at, force in (*acting, (body.centre, inertial)))
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
        """The motion is given: torque of the motor and joint forces are unknown."""
        return _linear(self.equations, (self.torque, *self.forces))

    @cached_property
    def direct(self) -> LinearSystem:
        """The torque is given: accelerations and joint forces are unknown, and the closure adds its equations."""
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
        """What the motor gives: the energies' rate of change, less what the loads give."""
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
