"""A mechanism along a motion, point after point: first the position and then its rates, or all at once."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike

from mechlib import require
from mechlib.closure import Loop, OpenLoopError
from mechlib.motion import Motion
from mechlib.newton import ConvergenceError, Iteration, newton

OpenPoints = Literal["refuse", "leave out"]


class Mechanism(Protocol):
    """What a sweep asks of a mechanism."""

    loop: Loop

    def gap(self, u: ArrayLike) -> np.ndarray:
        """By how much the loop stays open at the input u, m; not positive where it closes."""

    def branch(self, q: ArrayLike) -> np.ndarray:
        """The name of the assembly branch of closed positions."""


@dataclass(frozen=True)
class Sweep:
    """The unknowns of a mechanism along a motion.

    Attributes
    ----------
    motion : Motion
    position, velocity, acceleration : ndarray, shape (points, n)
        Not a number where the loop cannot close.
    iterations : ndarray of int, shape (points,)
        Newton-Raphson iterations of each point.
    errors : ndarray, shape (points,)
        The last step of each point, its 2-norm.
    """

    motion: Motion
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    iterations: np.ndarray
    errors: np.ndarray

    @classmethod
    def of(cls, motion: Motion, closed: np.ndarray, *columns: np.ndarray) -> "Sweep":
        """From the columns at the points where the loop closes; elsewhere there is no number, and no iteration."""
        if closed.all():
            return cls(motion, *columns)
        whole = []
        for column in columns:
            everywhere = np.full(
                (len(motion), *column.shape[1:]), 0 if column.dtype.kind == "i" else np.nan, column.dtype
            )
            everywhere[closed] = column
            whole.append(everywhere)
        return cls(motion, *whole)

    @property
    def open_points(self) -> np.ndarray:
        """The points at which the loop cannot close."""
        return np.flatnonzero(np.isnan(self.errors))


def consecutive(
    mechanism: Mechanism,
    motion: Motion,
    seed: ArrayLike,
    tol: float = 1e-6,
    max_iterations: int = 50,
    open_points: OpenPoints = "refuse",
) -> Sweep:
    """Position, velocity and acceleration one after the other, at every point of a motion.

    The position is found by Newton-Raphson, from the position of the point before. The velocities and accelerations
    are linear in the unknowns, and are solved for once, all points together.

    Parameters
    ----------
    mechanism : Mechanism
    motion : Motion
        Of its input.
    seed : array_like, shape (n,)
        Near the first position, and on the assembly branch that is wanted.
    tol : float
        A position is found when the 2-norm of a step falls below it.
    max_iterations : int
        For one position.
    open_points : {"refuse", "leave out"}
        What to do where the loop cannot close. Left out, such a point has no number, and the sweep goes on behind it
        on the same branch.

    Returns
    -------
    Sweep

    Raises
    ------
    ValueError
        If the seed is not a finite vector, or `tol` or `max_iterations` is not positive.
    OpenLoopError
        If the loop cannot close somewhere along the motion; before anything is solved.
    ConvergenceError
        If a position is not found on the branch of the first; says at which point.

    References
    ----------
    Source A, section 5.2.1 and listing E.4.
    """
    closed, loop, u = closed_points(mechanism, motion, open_points), mechanism.loop, motion.position

    def solve(k: int, seed: np.ndarray) -> Iteration:
        at = u[k]
        residual, jacobian = (lambda q: loop.residual(q, at)), (lambda q: loop.jacobian(q, at))
        return newton(residual, jacobian, seed, tol, max_iterations=max_iterations)

    paths = follow(mechanism, motion, closed, np.flatnonzero(closed), solve, seed)
    q = np.array([path.root for path in paths])
    rates = loop.rates(q, u[closed], motion.velocity[closed], motion.acceleration[closed])
    return Sweep.of(motion, closed, q, *rates, *_effort(paths))


def simultaneous(
    mechanism: Mechanism,
    motion: Motion,
    seed: ArrayLike,
    tol: float = 1e-6,
    max_iterations: int = 50,
    open_points: OpenPoints = "refuse",
) -> Sweep:
    """Position, velocity and acceleration together, as one system of 3n equations, at every point of a motion.

    Parameters, returns and errors are those of `consecutive`, but for the seed.

    Parameters
    ----------
    seed : array_like, shape (3n,)
        Positions, velocities and accelerations, near the first point.

    References
    ----------
    Source A, section 5.2.2 and listing E.4.
    """
    closed, loop = closed_points(mechanism, motion, open_points), mechanism.loop
    crank = np.stack((motion.position, motion.velocity, motion.acceleration), axis=-1)

    def solve(k: int, seed: np.ndarray) -> Iteration:
        at = crank[k]
        residual = lambda state: loop.simultaneous_residual(state, *at)
        jacobian = lambda state: loop.simultaneous_jacobian(state, *at)
        return newton(residual, jacobian, seed, tol, max_iterations=max_iterations)

    paths = follow(mechanism, motion, closed, np.flatnonzero(closed), solve, seed)
    state = np.array([path.root for path in paths])
    return Sweep.of(motion, closed, *np.split(state, 3, axis=1), *_effort(paths))


def closed_points(mechanism: Mechanism, motion: Motion, open_points: OpenPoints = "refuse") -> np.ndarray:
    """Where along a motion the loop can close, as a mask; OpenLoopError if it must everywhere, or does nowhere."""
    require.one_of("open_points", open_points, ("refuse", "leave out"))
    gap = mechanism.gap(motion.position)
    closed = gap <= 0
    if not (closed.all() or (open_points == "leave out" and closed.any())):
        raise OpenLoopError(str(mechanism.loop.closure.input.position), motion.position, gap)
    return closed


def follow(
    mechanism: Mechanism,
    motion: Motion,
    closed: np.ndarray,
    points: np.ndarray,
    solve: Callable[[int, np.ndarray], Iteration],
    seed: ArrayLike,
) -> list[Iteration]:
    """Solve point after point, each from the one before, and stay on the branch and the turn of the first.

    Where the step before is too near to a singular position, an iteration may end anywhere; then earlier ones are
    tried. Behind a gap an angle is counted on the turn that is nearest to its last value.

    Parameters
    ----------
    closed : ndarray of bool, shape (motion points,)
        Where the loop can close.
    points : ndarray of int
        The points to solve, in their order.
    solve : callable, (point, seed) -> Iteration
        Its root begins with the position.

    Raises
    ------
    ConvergenceError
        If a point is not found, or only on another branch or turn; says which.
    """
    seed, paths = require.finite("seed", seed), []
    try:
        for k in points:
            paths.append(solve(k, paths[-1].root if paths else seed))
    except ConvergenceError:
        return _follow_with_care(mechanism, motion, closed, points, solve, seed)
    n, angles = len(mechanism.loop.closure.unknowns), np.flatnonzero(mechanism.loop.closure.angles)
    q = np.array([path.root[:n] for path in paths])
    branches, turned = mechanism.branch(q), np.abs(np.diff(q[:, angles], axis=0)).max(initial=0)
    if (branches == branches[0]).all() and turned < np.pi / 2 and closed[points[0] : points[-1]].all():
        return paths
    return _follow_with_care(mechanism, motion, closed, points, solve, seed)


def _follow_with_care(mechanism, motion, closed, points, solve, seed) -> list[Iteration]:
    """`follow`, with a look at each point before the next."""
    loop = mechanism.loop
    n, angles = len(loop.closure.unknowns), np.flatnonzero(loop.closure.angles)
    paths, branch, side = [], None, None
    for k in points:
        behind_a_gap = paths and not closed[k - 1]
        failure = None
        for start in _starts(paths, seed):
            try:
                path = solve(k, start)
            except ConvergenceError as why:
                failure = failure or ConvergenceError(f"{_where(motion, k)}: {why}", why.path)
                continue
            found = mechanism.branch(path.root[:n]).item()
            branch = branch or found
            turned = (path.root - start)[angles]
            if found != branch:
                why = f"is on the branch {found!r}, and point {points[0]} on {branch!r}"
            elif behind_a_gap and _side(loop, path.root[:n], motion.position[k]) != side:
                why = "is beyond a singular position"
            elif paths and not behind_a_gap and np.abs(turned).max(initial=0) > np.pi / 2:
                why = "turns an angle by more than a quarter turn"
            else:
                break
            failure = failure or ConvergenceError(f"{_where(motion, k)}, {why}: take more points", path)
        else:
            raise failure
        if behind_a_gap:
            path.history[:, angles] -= 2 * np.pi * np.round(turned / (2 * np.pi))
        if side is None:
            side = _side(loop, path.root[:n], motion.position[k])
        paths.append(path)
    return paths


def _side(loop: Loop, q: np.ndarray, u: float) -> float:
    """The sign of det J: it changes at singular positions only."""
    return np.linalg.slogdet(loop.jacobian(q, u)).sign


def _where(motion: Motion, k: int) -> str:
    return f"point {k}, t = {motion.t[k]:.6g} s"


def _starts(paths: list[Iteration], seed: np.ndarray) -> Iterator[np.ndarray]:
    """The last position, and earlier ones in ever longer steps back."""
    if not paths:
        yield seed
    back = 1
    while back <= len(paths):
        yield paths[-back].root
        back *= 2


def _effort(paths: list[Iteration]) -> tuple[np.ndarray, np.ndarray]:
    return np.array([path.iterations for path in paths]), np.array([path.errors[-1] for path in paths])
