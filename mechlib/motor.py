"""A mechanism that a motor starts from rest: its run-up, its turns, and how unevenly it then runs."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicHermiteSpline

from mechlib import eksergian, require
from mechlib.direct import Run, Torque, load_velocities, rubbing, simulate
from mechlib.dynamics import Machine


class StallError(ArithmeticError):
    """A torque that cannot turn the mechanism on."""


@dataclass(frozen=True)
class Motor:
    """A direct-current motor with its gear: the faster it turns, the less torque it has.

    Attributes
    ----------
    stall_torque : float
        At standstill, N m.
    no_load_speed : float
        At which no torque is left, rad/s.

    Raises
    ------
    ValueError
        If a number is not positive.
    """

    stall_torque: float
    no_load_speed: float

    def __post_init__(self):
        require.positive(stall_torque=self.stall_torque, no_load_speed=self.no_load_speed)

    def __call__(self, t: float, theta: float, omega: ArrayLike) -> np.ndarray:
        """Torque at this speed, N m; against the motion beyond the no-load speed."""
        return self.stall_torque * (1 - np.asarray(omega) / self.no_load_speed)

    @classmethod
    def through(cls, speed: float, torque: float, stall_torque: float) -> "Motor":
        """The motor that has this torque at this speed.

        Raises
        ------
        ValueError
            If a number is not positive, or the torque not below that at standstill.
        """
        require.positive(speed=speed, torque=torque, stall_torque=stall_torque)
        if torque >= stall_torque:
            raise ValueError(f"torque must be below the {stall_torque} N m of standstill, got {torque}")
        return cls(stall_torque, speed / (1 - torque / stall_torque))


@dataclass(frozen=True)
class Turns:
    """The whole turns of a motion.

    Attributes
    ----------
    begin : ndarray, shape (turns,)
        When each begins, s.
    speed : ndarray, shape (turns,)
        The mean over each turn, rad/s.
    ripple : ndarray, shape (turns,)
        Largest less smallest speed of a turn, in parts of its mean: the coefficient of speed fluctuation.
    """

    begin: np.ndarray
    speed: np.ndarray
    ripple: np.ndarray

    @classmethod
    def of(cls, run: Run) -> "Turns":
        """From a motion looked at so often that its speed is smooth from one instant to the next."""
        angle, speed = run.position[:, 0], run.velocity[:, 0]
        path = CubicHermiteSpline(run.t, angle, speed)
        whole = int((angle[-1] - angle[0]) / (2 * np.pi))
        ends = [run.t[0], *(path.solve(angle[0] + 2 * np.pi * k, extrapolate=False)[0] for k in range(1, whole + 1))]
        within = [speed[(begin <= run.t) & (run.t <= end)] for begin, end in pairwise(ends)]
        mean = 2 * np.pi / np.diff(ends)
        return cls(np.array(ends[:-1]), mean, np.array([np.ptp(speeds) for speeds in within]) / mean)


def run_up(
    machine: Machine,
    motor: Torque,
    t: ArrayLike,
    friction: float = 0.0,
    v0: float = 0.01,
    theta: float = 0.0,
    rtol: float = 1e-9,
) -> Run:
    """Start a mechanism from rest against its weight and dry friction.

    Parameters
    ----------
    machine : Machine
    motor : callable
        (t, input, velocity of the input) -> N m, as `Motor`.
    t : array_like, shape (points,)
        Instants to look at, s; at the first it is at rest.
    friction, v0 : float
        At the centres of mass that carry loads: its size in N, and the speed in m/s below which it fades.
    theta : float
        Where it starts.
    rtol : float
        Of the integrator.

    Returns
    -------
    Run

    Raises
    ------
    StallError
        If it comes to rest, or turns back; says where, and which torque would turn it on.
    OpenLoopError
        If the linkage cannot be turned all the way round; says where it stays open.
    ValueError
        If a number is not finite, or friction has no width.
    """
    require.positive(v0=v0)
    reach = _reach(machine)
    run = simulate(machine, motor, (theta, 0.0), t, rubbing(machine, friction, v0), rtol=rtol)
    speed = run.velocity[:, 0]
    back = np.flatnonzero(speed[1:] <= 0) + 1
    # Where true friction would hold it, friction that fades lets it creep: at 3 v0 it is whole but for half a percent.
    if back.size or speed[-1] < 3 * v0 / reach:
        k = back[0] if back.size else len(speed) - 1
        q, given = run.position[k], float(motor(run.t[k], *run.position[k, :1], 0.0))
        raise StallError(
            f"the motor stalls at {machine.rigid.closure.input.position} = {q[0]:.6g}: to turn on from there takes "
            f"{turning_torque(machine, q, friction):.6g} N m, and it gives {given:.6g} N m"
        )
    return run


def turning_torque(machine: Machine, position: np.ndarray, friction: float = 0.0) -> float:
    """The torque that just turns a mechanism on from rest, against its weight and dry friction, N m.

    Parameters
    ----------
    machine : Machine
    position : ndarray, shape (1 + n,)
        The input, then the unknowns.
    friction : float
        At the centres of mass that carry loads, N.
    """
    u, q = float(position[0]), position[1:]
    onwards = np.array([[1.0, *eksergian.ratios(machine, u, q)[0]]])
    terms = eksergian.terms(machine, u, q, 0.0, rubbing(machine, friction, 0.0)(position[None], onwards)[0])
    return terms.inertial - terms.load


def _reach(machine: Machine) -> float:
    """The largest speed of a centre that carries a load, over a turn of the input at 1 rad/s; m."""
    u = np.linspace(0, 2 * np.pi, 361)
    q = machine.position(u)
    v = machine.loop.velocity(q, u, np.ones_like(u))
    at_centres = load_velocities(machine, np.column_stack((u, q)), np.column_stack((np.ones_like(u), v)))
    return float(np.linalg.norm(at_centres, axis=-1).max())
