"""A mechanism along a motion, point after point."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from mechlib import require
from mechlib.closure import Loop, OpenLoopError
from mechlib.motion import Motion
from mechlib.newton import ConvergenceError, newton


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
    iterations : ndarray of int, shape (points,)
        Newton-Raphson iterations of each position.
    errors : ndarray, shape (points,)
        The last step of each position, its 2-norm.
    """

    motion: Motion
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    iterations: np.ndarray
    errors: np.ndarray


def consecutive(
    mechanism: Mechanism, motion: Motion, seed: ArrayLike, tol: float = 1e-6, max_iterations: int = 50
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
        If a position is not found, or is found on another branch than the first; says at which point.

    References
    ----------
    Source A, section 5.2.1 and listing E.4.
    """
    if (gap := mechanism.gap(motion.position)).max() > 0:
        raise OpenLoopError(str(mechanism.loop.closure.input.position), motion.position, gap)
    loop, q = mechanism.loop, require.finite("seed", seed)
    paths = []
    for k, u in enumerate(motion.position):
        try:
            path = newton(
                lambda q, u=u: loop.residual(q, u),
                lambda q, u=u: loop.jacobian(q, u),
                q,
                tol,
                max_iterations=max_iterations,
            )
        except ConvergenceError as why:
            raise ConvergenceError(f"point {k}, t = {motion.t[k]:.6g} s: {why}", why.path) from None
        q = path.root
        paths.append(path)

    position = np.array([path.root for path in paths])
    branch = mechanism.branch(position)
    if (left := np.flatnonzero(branch != branch[0])).size:
        k = int(left[0])
        why = f"point {k}, t = {motion.t[k]:.6g} s, is on the branch {branch[k]!r}, and point 0 on {branch[0]!r}"
        raise ConvergenceError(f"{why}: take more points", paths[k])
    velocity = loop.velocity(position, motion.position, motion.velocity)
    acceleration = loop.acceleration(position, velocity, motion.position, motion.velocity, motion.acceleration)
    iterations = np.array([path.iterations for path in paths])
    errors = np.array([path.errors[-1] for path in paths])
    return Sweep(motion, position, velocity, acceleration, iterations, errors)
