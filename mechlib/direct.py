"""Direct dynamics: the torque is given, and the mechanism moves.

The mechanism has one degree of freedom, so the input and its velocity are the whole state, and the closure gives the
rest.  One can also integrate all coordinates; then nothing holds the loop closed but its acceleration equations, and it
drifts open.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike
from scipy.integrate import solve_ivp

from mechlib import require
from mechlib.closure import compiled
from mechlib.dynamics import Machine, at_points
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
        What is integrated. With "input" the loop stays closed; with "all" it drifts, unless that is held back.
    stabilise : float
        Only with "all": Baumgarte's rate in 1/s, at which an opening of the loop is made to die out.
    position_tol : float, optional
        Only with "input": solve the position by Newton-Raphson to this residual in place of the closed form, from the
        position before.
    rtol : float
        Of the integrator, of order eight.

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
        If the integrator gives up; says where.
    """
    t = require.finite("t", t)
    require.one_of("coordinates", coordinates, ("input", "all"))
    theta, omega = (require.finite(name, value) for name, value in zip(("theta", "omega"), start, strict=True))
    loop = machine.loop
    last = machine.position(theta)

    def closed(theta: np.ndarray) -> np.ndarray:
        """The unknowns that close the loop."""
        nonlocal last
        if position_tol is None:
            return machine.position(theta)
        last = _within(loop, theta, last, position_tol)
        return last

    def full(state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """All positions and velocities of one state."""
        if coordinates == "all":
            q, v = np.split(state[:-1], 2)
            return q, v
        q = closed(state[0])
        return np.array([state[0], *q]), np.array([state[1], *loop.velocity(q, *state[:2])])

    def slope(now: float, state: np.ndarray) -> np.ndarray:
        q, v = full(state)
        M = float(torque(now, q[0], v[0]))
        acting = None if loads is None else np.asarray(loads(q[None], v[None]))
        matrix, right = _system(machine, q[None], v[None], np.array([M]), acting)
        if stabilise and coordinates == "all":
            rate = loop.jacobian(q[1:], q[0]) @ v[1:] + loop.drive(q[1:], q[0], v[0])
            right[0, -len(rate) :, 0] -= 2 * stabilise * rate + stabilise**2 * loop.residual(q[1:], q[0])
        a = np.linalg.solve(matrix, right)[0, : len(q), 0]
        given = M * v[0] + (0.0 if acting is None else _load_power(machine, q, v, acting))
        return np.array([*v, *a, given]) if coordinates == "all" else np.array([v[0], a[0], given])

    first = closed(theta)
    begin = [theta, *first, omega, *loop.velocity(first, theta, omega)] if coordinates == "all" else [theta, omega]
    found = solve_ivp(slope, (t[0], t[-1]), [*begin, 0.0], "DOP853", t, rtol=rtol, atol=1e-2 * rtol)
    if not found.success:
        raise ArithmeticError(f"the motion ends at t = {found.t[-1]:.6g} s: {found.message}")
    states = [full(state) for state in found.y.T]
    q, v = (np.array(column) for column in zip(*states, strict=True))
    opening = np.linalg.norm(loop.residual(q[:, 1:], q[:, 0]), axis=-1)
    return Run(found.t, q, v, _energy(type(machine))(*q.T, *v.T, *machine.constants)[..., 0, 0], found.y[-1], opening)


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


def _load_power(machine: Machine, q, v, loads) -> float:
    velocities = _velocities(type(machine))(*q, *v, *machine.constants)
    return float((velocities * loads[0]).sum())


def _state(machine: type[Machine]) -> tuple[sp.Symbol, ...]:
    closure = machine.rigid.closure
    coordinates = (closure.input, *closure.unknowns)
    return (*(c.position for c in coordinates), *(c.velocity for c in coordinates))


@cache
def _functions(machine: type[Machine]) -> tuple[Callable[..., np.ndarray], Callable[..., np.ndarray]]:
    rigid = machine.rigid
    loads = (component for load in rigid.loads for component in load.force)
    arguments = (*_state(machine), rigid.torque, *machine.parameters, *loads)
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
