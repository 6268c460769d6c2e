"""Inverse dynamics of a mechanism along a motion: the torque that drives it, and the forces in its joints."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from itertools import chain
from typing import Protocol

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from mechlib import require
from mechlib.closure import Closure, compiled
from mechlib.rigidbody import Joint, LinearSystem, Point, RigidBodies
from mechlib.sweep import Mechanism, Sweep


class Linkage(Mechanism, Protocol):
    """A mechanism whose points have names."""

    closure: Closure
    symbols: dict[str, tuple[sp.Expr, sp.Expr]]
    parameters: tuple[sp.Symbol, ...]
    constants: tuple[float, ...]


class Machine(Linkage, Protocol):
    """A mechanism with masses."""

    rigid: RigidBodies


@dataclass(frozen=True)
class Trace:
    """A point of a mechanism along a motion.

    Attributes
    ----------
    position, velocity, acceleration : ndarray, shape (points, 2)
        m, m/s, m/s^2.
    """

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray


@dataclass(frozen=True)
class Reactions:
    """What inverse dynamics finds.

    Attributes
    ----------
    torque : ndarray, shape (points,)
        Of the motor, N m; the thrust in N where a cylinder drives.
    forces : dict of str to ndarray, shape (points, 2)
        By the name of the joint: the force on the body that its `Joint` names first, N; of a `Slide`, the force across
        it and the moment, N m.
    """

    torque: np.ndarray
    forces: dict[str, np.ndarray]


def trace(linkage: Linkage, sweep: Sweep, point: str) -> Trace:
    """Position, velocity and acceleration of a point by its name.

    Raises
    ------
    KeyError
        If the mechanism has no such point.
    """
    return _trace(linkage, sweep, linkage.symbols[point])


def friction(velocity: ArrayLike, size: float, v0: float = 0.0) -> np.ndarray:
    """Dry friction: a force of constant size against the velocity.

    Parameters
    ----------
    velocity : array_like, shape (..., 2)
        m/s.
    size : float
        N.
    v0 : float
        Below some such speed the force fades, as tanh(speed/v0); zero leaves Coulomb's law with its leap at rest, where
        the force is taken as zero.

    Returns
    -------
    ndarray, shape (..., 2)
        N.

    Raises
    ------
    ValueError
        If `size` or `v0` is negative.
    """
    if not (size >= 0 and v0 >= 0):
        raise ValueError(f"size and v0 must not be negative, got {size} and {v0}")
    velocity = np.asarray(velocity, dtype=float)
    speed = np.linalg.norm(velocity, axis=-1, keepdims=True)
    moving = np.where(speed > 0, speed, 1.0)
    return -size * velocity / moving * (np.tanh(speed / v0) if v0 else 1.0)


def inverse_dynamics(
    machine: Machine, sweep: Sweep, loads: ArrayLike | None = None, system: LinearSystem | None = None
) -> Reactions:
    """Torque and joint forces along a motion, from one linear system a point.

    Parameters
    ----------
    machine : Machine
    sweep : Sweep
        Its motion.
    loads : array_like, shape (points, number of loads, 2), optional
        The known forces at the centres of mass, in the order of `RigidBodies.loads`, N; none if left out.
    system : LinearSystem, optional
        The equations, with the columns of `RigidBodies.inverse`; those of the machine if left out.

    Returns
    -------
    Reactions

    Raises
    ------
    ValueError
        If the loads have another shape.

    References
    ----------
    Source B, inverse dynamics, 15 equations.
    """
    solution = system.compiled(arguments(type(machine))) if system else _solution(type(machine))
    found = solution(*values(machine, sweep, loads))
    pairs = found[:, 1:].reshape(len(found), -1, 2)
    return Reactions(found[:, 0], {joint.name: pairs[:, k] for k, joint in enumerate(machine.rigid.joints)})


def power(machine: Machine, sweep: Sweep, loads: ArrayLike | None = None) -> np.ndarray:
    """The power that the motor must give, from the energies and the loads alone: no joint force enters, W.

    Parameters are those of `inverse_dynamics`; returns shape (points,).
    """
    return _power(type(machine))(*values(machine, sweep, loads))[..., 0, 0]


def residuals(machine: Machine, sweep: Sweep, reactions: Reactions, loads: ArrayLike | None = None) -> np.ndarray:
    """By how much Newton's and Euler's equations of each body about its own centre of mass do not hold.

    Of the assembled system nothing is used, and the forces are those that are given: unlike a power balance this sees
    each of them.

    Parameters
    ----------
    machine, sweep, loads
        As for `inverse_dynamics`.
    reactions : Reactions

    Returns
    -------
    ndarray, shape (points, bodies, 3)
        Forces along x and y in N, and the moment about the centre of mass in N m.
    """
    rigid, at, loads = machine.rigid, values(machine, sweep), at_points(machine, len(sweep.motion), loads)
    value = dict(zip(machine.parameters, machine.constants, strict=True))
    turning = dict(zip(rigid.accelerations, (sweep.motion.acceleration, *sweep.acceleration.T), strict=True))
    weight = np.array([0.0, -value[rigid.gravity]])
    found = np.zeros((len(sweep.motion), len(rigid.bodies), 3))
    for k, body in enumerate(rigid.bodies):
        centre, force, moment = _trace(machine, sweep, body.centre), found[:, k, :2], found[:, k, 2]
        force += value[body.mass] * (weight - centre.acceleration)
        if body.angle is not None:
            moment -= value[body.inertia] * turning[body.angle.acceleration]
        if body.name == rigid.motor:
            moment += reactions.torque
        for joint in rigid.joints:
            if body.name in (joint.on, joint.by):
                given = _transmitted(type(machine), joint)(*at, reactions.torque, *reactions.forces[joint.name].T)
                x, y, m = given[..., 0].T * (1 if body.name == joint.on else -1)
                arm = _trace(machine, sweep, joint.at).position - centre.position
                force += np.stack((x, y), axis=-1)
                moment += arm[:, 0] * y - arm[:, 1] * x + m
        for n, load in enumerate(rigid.loads):
            if load.on == body.name:
                force += loads[:, n]
    return found


def _trace(linkage: Linkage, sweep: Sweep, point: Point) -> Trace:
    at = (*_states(sweep), *linkage.constants)
    return Trace(*(function(*at)[..., 0] for function in _point(type(linkage), point)))


def values(machine: Machine, sweep: Sweep, loads: ArrayLike | None = None) -> tuple:
    """Numbers for `arguments`: columns over the points, and constants."""
    components = at_points(machine, len(sweep.motion), loads).reshape(len(sweep.motion), -1).T
    return (*_states(sweep), *machine.constants, *components)


def arguments(machine: type[Machine]) -> tuple[sp.Symbol, ...]:
    """What the equations of a mechanism depend on: coordinates and rates, parameters, and components of the loads."""
    loads = (component for load in machine.rigid.loads for component in load.force)
    return (*_coordinates(machine.closure), *machine.parameters, *loads)


def _coordinates(closure: Closure) -> Iterator[sp.Symbol]:
    return chain.from_iterable(zip(closure.input, *closure.unknowns, strict=True))


def _states(sweep: Sweep) -> Iterator[np.ndarray]:
    """Columns over the points, for `_coordinates`."""
    motion = sweep.motion
    for of_input, of_unknowns in (
        (motion.position, sweep.position),
        (motion.velocity, sweep.velocity),
        (motion.acceleration, sweep.acceleration),
    ):
        yield from (of_input, *of_unknowns.T)


def at_points(machine: Machine, points: int, loads: ArrayLike | None) -> np.ndarray:
    """The loads as an array, (points, number of loads, 2); zeros for none, ValueError for another shape."""
    shape = (points, len(machine.rigid.loads), 2)
    if loads is None:
        return np.zeros(shape)
    loads = require.finite("loads", loads)
    if loads.shape != shape:
        raise ValueError(f"loads must be {shape}, (points, loads, 2), got {loads.shape}")
    return loads


@cache
def _point(linkage: type[Linkage], point: Point) -> tuple[Callable[..., np.ndarray], ...]:
    closure, position = linkage.closure, sp.Matrix(point)
    velocity = closure.time_derivative(position)
    of_time = position, velocity, closure.time_derivative(velocity)
    symbols = (*_coordinates(closure), *linkage.parameters)
    return tuple(compiled(symbols, expressions) for expressions in of_time)


@cache
def _transmitted(machine: type[Machine], joint: Joint) -> Callable[..., np.ndarray]:
    rigid = machine.rigid
    return compiled((*arguments(machine), rigid.drive, *joint.unknowns), sp.Matrix(rigid.transmitted(joint)))


@cache
def _solution(machine: type[Machine]) -> Callable[..., np.ndarray]:
    return machine.rigid.inverse.compiled(arguments(machine))


@cache
def _power(machine: type[Machine]) -> Callable[..., np.ndarray]:
    return compiled(arguments(machine), sp.Matrix([machine.rigid.power]))
