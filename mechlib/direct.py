"""Direct dynamics: the torque is given, and the mechanism moves.

The mechanism has one degree of freedom: the input and its velocity are the whole state, the closure gives the rest, and
one equation moves it.  One can also integrate all coordinates; then nothing holds the loop closed but its acceleration
equations, and it drifts open.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike
from scipy.integrate import solve_ivp

from mechlib import eksergian, require
from mechlib.closure import compiled
from mechlib.dynamics import Machine, at_points, friction
from mechlib.newton import newton

Torque = Callable[[float, float, float], float]
Loads = Callable[[np.ndarray, np.ndarray], ArrayLike]


@dataclass(frozen=True)
class Accelerations:
    """What direct dynamics finds.

    Attributes
    ----------
    accelerations : ndarray, shape (points, 1 + n)
        Of the input, then of the unknowns.
    forces : dict of str to ndarray, shape (points, 2)
        By the name of the joint, N.
    """

    accelerations: np.ndarray
    forces: dict[str, np.ndarray]


@dataclass(frozen=True)
class Run:
    """A motion that a torque has made.

    Attributes
    ----------
    t : ndarray, shape (points,)
    position, velocity : ndarray, shape (points, 1 + n)
        Of the input, then of the unknowns.
    energy : ndarray, shape (points,)
        Kinetic and potential, J.
    work : ndarray, shape (points,)
        What the torque and the loads have given since the start, J.
    opening : ndarray, shape (points,)
        By how much the loop is open, the 2-norm of the closure, m.
    """

    t: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    energy: np.ndarray
    work: np.ndarray
    opening: np.ndarray

    @property
    def drift(self) -> np.ndarray:
        """Energy that came from nowhere, J: zero, but for what the integration leaves."""
        return self.energy - self.energy[0] - self.work


def direct_dynamics(
    machine: Machine, position: ArrayLike, velocity: ArrayLike, torque: ArrayLike, loads: ArrayLike | None = None
) -> Accelerations:
    """Accelerations and joint forces at given states and torques, from one linear system a point.

    Parameters
    ----------
    machine : Machine
    position, velocity : array_like, shape (points, 1 + n)
        Of the input, then of the unknowns; closed, and fitting each other.
    torque : array_like, shape (points,)
        Of the motor, N m.
    loads : array_like, shape (points, number of loads, 2), optional
        The known forces at the centres of mass, N; none if left out.

    Returns
    -------
    Accelerations

    References
    ----------
    Source B, direct dynamics, 17 equations.
    """
    position, velocity = require.finite("position", position), require.finite("velocity", velocity)
    found = np.linalg.solve(*_system(machine, position, velocity, torque, loads))[..., 0]
    n = position.shape[1]
    pairs = found[:, n:].reshape(len(found), -1, 2)
    return Accelerations(found[:, :n], {joint.name: pairs[:, k] for k, joint in enumerate(machine.rigid.joints)})


def rubbing(machine: Machine, size: float, v0: float) -> Loads:
    """Dry friction at every centre of mass that carries a load, for `simulate`.

    Parameters
    ----------
    machine : Machine
    size, v0 : float
        As for `dynamics.friction`: its size in N, and the speed in m/s below which it fades.  Without a width v0 an
        integrator cannot pass a point of rest.
    """
    return lambda q, v: friction(load_velocities(machine, q, v), size, v0)


def load_velocities(machine: Machine, position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Of the centres of mass that carry loads, m/s; shapes (points, 1 + n) twice -> (points, number of loads, 2)."""
    return _velocities(type(machine))(*position.T, *velocity.T, *machine.constants)


def simulate(
    machine: Machine,
    torque: Torque,
    start: tuple[float, float],
    t: ArrayLike,
    loads: Loads | None = None,
    coordinates: Literal["input", "all"] = "input",
    stabilise: float = 0.0,
    position_tol: float | None = None,
    rtol: float = 1e-12,
    max_evaluations: int = 200_000,
) -> Run:
    """Move a mechanism by the torque of its motor.

    Parameters
    ----------
    machine : Machine
    torque : callable
        (t, input, velocity of the input) -> N m.
    start : (float, float)
        The input and its velocity at ``t[0]``.
    t : array_like, shape (points,)
        Instants to look at, s.
    loads : callable, optional
        (position, velocity), each of shape (points, 1 + n) -> (points, number of loads, 2), N.
    coordinates : {"input", "all"}
        What is integrated.  The input alone, by Eksergian's equation: the loop stays closed.  Or all, by the linear
        system of `direct_dynamics`: the loop drifts open, unless that is held back.
    stabilise : float
        Only with "all": Baumgarte's rate in 1/s, at which an opening of the loop is made to die out.
    position_tol : float, optional
        Only with "input": solve the position by Newton-Raphson to this residual in place of the closed form, from the
        position before.
    rtol : float
        Of the integrator, of order eight.
    max_evaluations : int
        How often the accelerations may be asked for.

    Returns
    -------
    Run

    Raises
    ------
    ValueError
        If a number is not finite, or a choice has another name.
    OpenLoopError
        If the motion leads to where the loop cannot close.
    ArithmeticError
        If the motion meets a singular position, or the integrator gives up; says where.
    """
    t = require.finite("t", t)
    require.one_of("coordinates", coordinates, ("input", "all"))
    theta, omega = (float(require.finite(name, value)) for name, value in zip(("theta", "omega"), start, strict=True))
    q = machine.position(theta)
    way = _Input(machine, q, position_tol) if coordinates == "input" else _All(machine, stabilise)
    asked = 0

    def slope(now: float, state: np.ndarray) -> np.ndarray:
        nonlocal asked
        asked += 1
        if asked > max_evaluations:
            where = f"t = {now:.6g} s, {machine.rigid.closure.input.position} = {state[0]:.6g}"
            raise ArithmeticError(f"the motion gets no further than {where} in {max_evaluations} evaluations")
        q, v = way.full(state[:-1])
        acting = None if loads is None else np.asarray(loads(q[None], v[None]), dtype=float)
        M = float(require.finite("torque", torque(now, q[0], v[0])))
        of_loads = 0.0 if acting is None else float((load_velocities(machine, q[None], v[None]) * acting).sum())
        return np.array([*way.slope(q, v, M, acting), M * v[0] + of_loads])

    begin = [theta, omega] if coordinates == "input" else [theta, *q, omega, *machine.loop.velocity(q, theta, omega)]
    found = solve_ivp(slope, (t[0], t[-1]), [*begin, 0.0], "DOP853", t, rtol=rtol, atol=1e-2 * rtol)
    if not found.success:
        raise ArithmeticError(f"the motion ends at t = {found.t[-1]:.6g} s: {found.message}")
    q, v = (np.array(column) for column in zip(*(way.full(state[:-1]) for state in found.y.T), strict=True))
    opening = np.linalg.norm(machine.loop.residual(q[:, 1:], q[:, 0]), axis=-1)
    return Run(found.t, q, v, _energy(type(machine))(*q.T, *v.T, *machine.constants)[..., 0, 0], found.y[-1], opening)


class _Input:
    """The input and its velocity are the state, and the closure gives the rest."""

    def __init__(self, machine: Machine, q: np.ndarray, tol: float | None):
        self.machine, self.last, self.tol = machine, q, tol

    def full(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        theta, omega = state
        if self.tol is None:
            q = self.machine.position(theta)
        else:
            q = self.last = _within(self.machine.loop, theta, self.last, self.tol)
        k = eksergian.ratios(self.machine, theta, q)[0]
        return np.array([theta, *q]), omega * np.array([1.0, *k])

    def slope(self, q: np.ndarray, v: np.ndarray, M: float, loads: np.ndarray | None) -> list[float]:
        J, inertial, Q = eksergian.terms(self.machine, q[0], q[1:], v[0], None if loads is None else loads[0])
        return [v[0], (M + Q - inertial) / J]


class _All:
    """All positions and velocities are the state, and nothing but the acceleration equations knows of the loop."""

    def __init__(self, machine: Machine, rate: float):
        self.machine, self.rate = machine, rate

    def full(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        q, v = np.split(state, 2)
        return q, v

    def slope(self, q: np.ndarray, v: np.ndarray, M: float, loads: np.ndarray | None) -> list[float]:
        matrix, right = _system(self.machine, q[None], v[None], np.array([M]), loads)
        if self.rate:
            loop = self.machine.loop
            opens = loop.jacobian(q[1:], q[0]) @ v[1:] + loop.drive(q[1:], q[0], v[0])
            right[0, -len(opens) :, 0] -= 2 * self.rate * opens + self.rate**2 * loop.residual(q[1:], q[0])
        return [*v, *np.linalg.solve(matrix, right)[0, : len(q), 0]]


def _within(loop, theta: float, seed: np.ndarray, tol: float) -> np.ndarray:
    q = np.array(seed)
    for _ in range(50):
        residual = loop.residual(q, theta)
        if np.linalg.norm(residual) < tol:
            return q
        q = q - np.linalg.solve(loop.jacobian(q, theta), residual)
    return newton(lambda q: loop.residual(q, theta), lambda q: loop.jacobian(q, theta), seed, tol).root


def _system(machine: Machine, q, v, torque, loads) -> tuple[np.ndarray, np.ndarray]:
    loads = at_points(machine, len(q), loads)
    values = (*q.T, *v.T, require.finite("torque", torque), *machine.constants, *loads.reshape(len(q), -1).T)
    matrix, right = _functions(type(machine))
    return matrix(*values), right(*values)


def _state(machine: type[Machine]) -> tuple[sp.Symbol, ...]:
    closure = machine.rigid.closure
    coordinates = (closure.input, *closure.unknowns)
    return (*(c.position for c in coordinates), *(c.velocity for c in coordinates))


@cache
def _functions(machine: type[Machine]) -> tuple[Callable[..., np.ndarray], Callable[..., np.ndarray]]:
    rigid = machine.rigid
    loads = (component for load in rigid.loads for component in load.force)
    arguments = (*_state(machine), rigid.drive, *machine.parameters, *loads)
    return compiled(arguments, rigid.direct.matrix), compiled(arguments, rigid.direct.right)


@cache
def _velocities(machine: type[Machine]) -> Callable[..., np.ndarray]:
    """Of the centres at which loads act."""
    rigid = machine.rigid
    centres = {body.name: body.centre for body in rigid.bodies}
    rows = [rigid.velocity(centres[load.on]).T for load in rigid.loads]
    return compiled((*_state(machine), *machine.parameters), sp.Matrix.vstack(*rows))


@cache
def _energy(machine: type[Machine]) -> Callable[..., np.ndarray]:
    rigid = machine.rigid
    energy = sp.Matrix([rigid.kinetic_energy + rigid.potential_energy])
    return compiled((*_state(machine), *machine.parameters), energy)
