"""A mechanism along a motion, all points at once."""

from collections.abc import Iterator
from math import hypot

import numpy as np
from numpy.typing import ArrayLike

from mechlib.closure import Loop
from mechlib.motion import Motion
from mechlib.newton import ConvergenceError, Iteration
from mechlib.sweep import Mechanism, OpenPoints, Sweep, closed_points, consecutive, follow

COARSE = 24  # points of the first coarse sweep
FINER = 8  # times as many where they were too few
BLOCK = 1 << 13  # points at a time: what is worked on stays small, and near the processor
LEAP = 0.25  # of the range of an unknown, where the velocities lead elsewhere


def batched(
    mechanism: Mechanism,
    motion: Motion,
    seed: ArrayLike,
    tol: float = 1e-6,
    max_iterations: int = 50,
    open_points: OpenPoints = "refuse",
) -> Sweep:
    """Position, velocity and acceleration at every point of a motion, many points together.

    A coarse sweep goes from point to point. Every other point starts between its neighbours in the coarse sweep, and
    all are iterated at once. If a point then lies on another branch, or if a position leaps where the velocities lead
    elsewhere, the coarse sweep was too coarse: a finer one is made, and `consecutive` is the finest.

    Parameters
    ----------
    mechanism : Mechanism
        With at most three unknowns.
    motion : Motion
        Of its input.
    seed : array_like, shape (n,)
        Near the first position, and on the assembly branch that is wanted.
    tol : float
        A position is found when the 2-norm of a step falls below it.
    max_iterations : int
        For one position.
    open_points : {"refuse", "leave out"}
        As for `consecutive`.

    Returns
    -------
    Sweep
        The work goes on in blocks: beside the result little memory is needed.

    Raises
    ------
    ValueError, OpenLoopError, ConvergenceError
        As for `consecutive`.
    """
    closed = closed_points(mechanism, motion, open_points)
    points, wanted = np.flatnonzero(closed), COARSE
    while 2 * len(coarse := _coarse(points, wanted)) < len(points):
        try:
            columns = _all_at_once(mechanism, motion, closed, points, coarse, seed, tol, max_iterations)
            return Sweep.of(motion, closed, *columns)
        except (ConvergenceError, ZeroDivisionError):
            wanted *= FINER
    return consecutive(mechanism, motion, seed, tol, max_iterations, open_points)


def _coarse(points: np.ndarray, wanted: int) -> np.ndarray:
    """Which of the points a coarse sweep takes: evenly many, and the ends of each run without a gap."""
    behind_gaps = np.flatnonzero(np.diff(points) > 1) + 1
    evenly = np.linspace(0, len(points) - 1, wanted).astype(int)
    return np.unique(np.concatenate((behind_gaps - 1, behind_gaps, evenly)))


def _all_at_once(mechanism, motion, closed, points, coarse, seed, tol, max_iterations) -> tuple[np.ndarray, ...]:
    loop, n, size = mechanism.loop, len(mechanism.loop.closure.unknowns), len(points)

    def solve(k: int, start: np.ndarray) -> Iteration:
        return _at_one_point(loop, float(motion.position[k]), start, tol, max_iterations)

    paths = follow(mechanism, motion, closed, points[coarse], solve, seed)
    known = np.array([path.root for path in paths])
    branch, leap = mechanism.branch(known[0]), LEAP * np.ptp(known, axis=0)
    q, v, a = (np.empty((n, size)).T for _ in range(3))
    iterations, errors = np.empty(size, int), np.empty(size)
    for block in _blocks(size):
        here = points[block]
        t, u, du, ddu = motion.t[here], motion.position[here], motion.velocity[here], motion.acceleration[here]
        start = np.array([np.interp(np.arange(block.start, block.stop), coarse, column) for column in known.T]).T
        q[block], iterations[block], errors[block] = _at_many_points(loop, u, start, tol, max_iterations)
        v[block], a[block] = loop.rates(q[block], u, du, ddu)
        along = np.diff(t)[:, None] * (v[block][1:] + v[block][:-1]) / 2
        off = np.abs(np.diff(q[block], axis=0) - along) > leap
        if (mechanism.branch(q[block]) != branch).any() or off[np.diff(here) == 1].any():
            raise ConvergenceError("too coarse a sweep", paths[0])
    return q, v, a, iterations, errors


def _blocks(size: int) -> Iterator[slice]:
    """Each begins with the last point of the one before, so that no leap is overlooked."""
    for begin in range(0, max(size - 1, 1), BLOCK - 1):
        yield slice(begin, min(begin + BLOCK, size))


def _at_many_points(loop: Loop, u, q, tol, max_iterations) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Newton-Raphson at all points: until the last has converged, the others go on improving."""
    iterations, errors = np.zeros(len(u), int), np.full(len(u), np.inf)
    for _ in range(max_iterations):
        step = loop.newton_step(q, u)
        q = q - step
        going = ~(errors < tol)
        iterations += going
        errors[going] = np.sqrt((step.T**2).sum(axis=0))[going]
        if (errors < tol).all():
            return q, iterations, errors
    raise ConvergenceError("a point has not converged", Iteration(q[None], errors[None], False))


def _at_one_point(loop: Loop, u: float, start: np.ndarray, tol, max_iterations) -> Iteration:
    """Newton-Raphson in plain floats, several times faster than `newton` in arrays of three numbers."""
    q = start.tolist()
    try:
        for _ in range(max_iterations):
            step = loop.newton_step_at(q, u)
            q = [x - d for x, d in zip(q, step, strict=True)]
            if hypot(*step) < tol:
                return Iteration(np.array([start, q]), np.array([hypot(*step)]), True)
    except (ZeroDivisionError, ValueError, OverflowError):  # a singular position, or a sine of what is not finite
        pass
    raise ConvergenceError("no root", Iteration(np.array([start, q]), np.array([np.inf]), False))
