"""A loop closure, written once: its velocity and acceleration equations and its Jacobian are derived and compiled.

The equations F(q, u) = 0 tie the unknowns q to the input u. Their time derivatives are linear in what is new in them,

    J q' + F_u u' = 0,        J q'' + gamma = 0,        J = dF/dq,

with the same matrix J: once the position is known, a linear solve gives the velocity, and another the acceleration.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from mechlib import cramer


class OpenLoopError(ValueError):
    """A loop that cannot close.

    Attributes
    ----------
    points : ndarray of int, shape (k,)
        The points of the motion at which it stays open; counted over all axes if there are several.
    gaps : ndarray, shape (k,)
        By how much, m.
    """

    def __init__(self, what: str, inputs: ArrayLike, gaps: ArrayLike, limit: str = ""):
        inputs, gaps = np.ravel(inputs), np.ravel(gaps)
        self.points = np.flatnonzero(gaps > 0)
        self.gaps = gaps[self.points]
        first, others = self.points[0], len(self.points) - 1
        many = f" (and at {others} other point{'s' if others > 1 else ''})" if others else ""
        super().__init__(
            f"the loop cannot close at {what} = {inputs[first]:.6g}: {self.gaps[0]:.3g} m are missing{many}"
            + (f"; {limit}" if limit else "")
        )


class Coordinate(NamedTuple):
    """The symbols of a coordinate and of its first two time derivatives."""

    position: sp.Symbol
    velocity: sp.Symbol
    acceleration: sp.Symbol

    @classmethod
    def named(cls, names: str) -> "Coordinate":
        """From three names, as ``"theta_1 omega_1 alpha_1"``."""
        return cls(*sp.symbols(names))


@dataclass(frozen=True)
class Closure:
    """A loop closure in symbols, and what follows from it.

    Attributes
    ----------
    equations : tuple of n expressions
        Zero where the loop is closed.
    unknowns : tuple of n Coordinate
    input : Coordinate
    parameters : tuple of Symbol
        The lengths of the mechanism.
    """

    equations: tuple[sp.Expr, ...]
    unknowns: tuple[Coordinate, ...]
    input: Coordinate
    parameters: tuple[sp.Symbol, ...]

    @cached_property
    def position_equations(self) -> sp.Matrix:
        return sp.Matrix(self.equations)

    @cached_property
    def velocity_equations(self) -> sp.Matrix:
        return self.time_derivative(self.position_equations)

    @cached_property
    def acceleration_equations(self) -> sp.Matrix:
        return self.time_derivative(self.velocity_equations)

    @cached_property
    def jacobian(self) -> sp.Matrix:
        """Of the position equations by the positions; the velocity and acceleration equations have it too."""
        return self.position_equations.jacobian([q.position for q in self.unknowns])

    @cached_property
    def angles(self) -> tuple[bool, ...]:
        """Which unknowns are angles: a whole turn of them changes no equation."""
        equations = self.position_equations
        return tuple(equations.subs(q.position, q.position + 2 * sp.pi) == equations for q in self.unknowns)

    @cached_property
    def simultaneous_equations(self) -> sp.Matrix:
        """The equations of position, velocity and acceleration, as one system."""
        return sp.Matrix.vstack(self.position_equations, self.velocity_equations, self.acceleration_equations)

    @cached_property
    def simultaneous_jacobian(self) -> sp.Matrix:
        """By all positions, then all velocities, then all accelerations: J in the diagonal, and nothing above it."""
        return self.simultaneous_equations.jacobian(
            [symbol for order in zip(*self.unknowns, strict=True) for symbol in order]
        )

    def time_derivative(self, equations: sp.Matrix) -> sp.Matrix:
        """The chain rule: a position changes at its velocity, and a velocity at its acceleration."""
        total = sp.zeros(*equations.shape)
        for q in (*self.unknowns, self.input):
            total += equations.diff(q.position) * q.velocity + equations.diff(q.velocity) * q.acceleration
        return total.expand()

    @cached_property
    def _functions(self) -> dict[str, Callable]:
        positions, velocities, accelerations = (list(symbols) for symbols in zip(*self.unknowns, strict=True))
        u, du, ddu = self.input
        state = (*positions, *velocities, *accelerations, *self.input)
        return {
            "residual": compiled((*positions, u, *self.parameters), self.position_equations),
            "jacobian": compiled((*positions, u, *self.parameters), self.jacobian),
            "drive": compiled((*positions, u, du, *self.parameters), self.drive),
            "gamma": compiled((*positions, *velocities, u, du, ddu, *self.parameters), self.gamma),
            "newton step": compiled((*positions, u, *self.parameters), self._newton_step),
            "simultaneous residual": compiled((*state, *self.parameters), self.simultaneous_equations),
            "simultaneous jacobian": compiled((*state, *self.parameters), self.simultaneous_jacobian),
        }

    @cached_property
    def drive(self) -> sp.Matrix:
        """F_u u': the velocity equations without the velocities of the unknowns."""
        return self.velocity_equations.subs({q.velocity: 0 for q in self.unknowns})

    @cached_property
    def gamma(self) -> sp.Matrix:
        """The acceleration equations without the accelerations of the unknowns."""
        return self.acceleration_equations.subs({q.acceleration: 0 for q in self.unknowns})

    def solved(self, right: sp.Matrix) -> sp.Matrix:
        """J x = right by Cramer's rule, in symbols: most of it cancels or is shared; at most three unknowns."""
        determinant, adjugate = cramer.adjugate(self.jacobian.tolist())
        return sp.Matrix(cramer.times(adjugate, list(right))) / determinant

    @cached_property
    def _newton_step(self) -> sp.Matrix:
        return self.solved(self.position_equations)

    @cached_property
    def _step_at_one_point(self) -> Callable[..., list[float]]:
        """The same of floats: much faster than of arrays that hold one number."""
        arguments = (*(q.position for q in self.unknowns), self.input.position, *self.parameters)
        return sp.lambdify(arguments, list(self._newton_step), "math", cse=True)

    def loop(self, *parameters: float) -> "Loop":
        """The closure with numbers for its parameters, in their order."""
        if len(parameters) != len(self.parameters):
            raise ValueError(f"the closure has the parameters {self.parameters}, got {len(parameters)} numbers")
        return Loop(self, parameters)


@dataclass(frozen=True)
class Loop:
    """A loop closure in numbers: arrays in, arrays out, any leading axes.

    Attributes
    ----------
    closure : Closure
    parameters : tuple of float
    """

    closure: Closure
    parameters: tuple[float, ...]

    def residual(self, q: ArrayLike, u: ArrayLike) -> np.ndarray:
        """F(q, u): by how much the loop is open; shapes (..., n), (...) -> (..., n)."""
        return self._call("residual", *_columns(q), u)[..., 0]

    def jacobian(self, q: ArrayLike, u: ArrayLike) -> np.ndarray:
        """J(q, u) = dF/dq; shapes (..., n), (...) -> (..., n, n)."""
        return self._call("jacobian", *_columns(q), u)

    def newton_step(self, q: ArrayLike, u: ArrayLike) -> np.ndarray:
        """The step J d = F of Newton-Raphson, to be taken back from q; not finite where J is singular.

        Parameters
        ----------
        q : array_like, shape (..., n)
            n at most 3.
        u : array_like, shape (...)

        Returns
        -------
        ndarray, shape (..., n)
        """
        with np.errstate(divide="ignore", invalid="ignore"):
            return self._call("newton step", *_columns(q), u)[..., 0]

    def newton_step_at(self, q: Sequence[float], u: float) -> list[float]:
        """`newton_step` at one point, in plain floats; ZeroDivisionError where J is singular."""
        return self.closure._step_at_one_point(*q, u, *self.parameters)

    def drive(self, q: ArrayLike, u: ArrayLike, du: ArrayLike) -> np.ndarray:
        """F_u u': the part of the velocity equations that the input gives; shapes (..., n), (...) -> (..., n)."""
        return self._call("drive", *_columns(q), u, du)[..., 0]

    def velocity(self, q: ArrayLike, u: ArrayLike, du: ArrayLike) -> np.ndarray:
        """Velocities of the unknowns at a closed position, from J q' = -F_u u'.

        Parameters
        ----------
        q : array_like, shape (..., n)
            Positions that close the loop.
        u, du : array_like, shape (...)
            The input and its velocity.

        Returns
        -------
        ndarray, shape (..., n)

        Raises
        ------
        ZeroDivisionError
            In a singular position, where the velocity is not determined; the sentence says at which point.
        """
        return self._solver(q, u)(self._call("drive", *_columns(q), u, du))

    def acceleration(self, q: ArrayLike, v: ArrayLike, u: ArrayLike, du: ArrayLike, ddu: ArrayLike) -> np.ndarray:
        """Accelerations of the unknowns at a closed position, from J q'' = -gamma.

        Parameters
        ----------
        q, v : array_like, shape (..., n)
            Positions that close the loop, and their velocities.
        u, du, ddu : array_like, shape (...)
            The input, its velocity and its acceleration.

        Returns
        -------
        ndarray, shape (..., n)

        Raises
        ------
        ZeroDivisionError
            In a singular position; the sentence says at which point.
        """
        return self._solver(q, u)(self._call("gamma", *_columns(q), *_columns(v), u, du, ddu))

    def simultaneous_residual(self, state: ArrayLike, u: ArrayLike, du: ArrayLike, ddu: ArrayLike) -> np.ndarray:
        """All 3n equations at once.

        Parameters
        ----------
        state : array_like, shape (..., 3n)
            Positions, velocities and accelerations of the unknowns, in this order.
        u, du, ddu : array_like, shape (...)
            The input, its velocity and its acceleration.

        Returns
        -------
        ndarray, shape (..., 3n)

        References
        ----------
        Source A, section 5.2.2.
        """
        return self._call("simultaneous residual", *_columns(state), u, du, ddu)[..., 0]

    def simultaneous_jacobian(self, state: ArrayLike, u: ArrayLike, du: ArrayLike, ddu: ArrayLike) -> np.ndarray:
        """Derivatives of all 3n equations by all 3n unknowns; arguments as for `simultaneous_residual`.

        Returns
        -------
        ndarray, shape (..., 3n, 3n)

        References
        ----------
        Source A, appendix D.
        """
        return self._call("simultaneous jacobian", *_columns(state), u, du, ddu)

    def rates(self, q: ArrayLike, u: ArrayLike, du: ArrayLike, ddu: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """`velocity` and `acceleration`, of many points: the matrix that they share is computed once.

        Raises
        ------
        ZeroDivisionError
            In a singular position; the sentence says at which point.
        """
        solve = self._solver(q, u)
        v = solve(self._call("drive", *_columns(q), u, du))
        return v, solve(self._call("gamma", *_columns(q), *_columns(v), u, du, ddu))

    def _call(self, name: str, *arguments: ArrayLike) -> np.ndarray:
        return self.closure._functions[name](*arguments, *self.parameters)

    def _solver(self, q: ArrayLike, u: ArrayLike) -> Callable[[np.ndarray], np.ndarray]:
        """What solves J x + known = 0 at these points."""
        rows = np.moveaxis(self.jacobian(q, u), (-2, -1), (0, 1))
        determinant, adjugate = cramer.adjugate(rows)
        # Hadamard: no determinant is larger. By columns, of one unit each: in a flat position a whole row may vanish
        bound = np.sqrt((rows**2).sum(axis=0)).prod(axis=0)
        singular = np.abs(determinant) <= len(rows) * np.finfo(float).eps * bound
        if singular.any():
            point = int(np.flatnonzero(singular)[0])
            where = f"{self.closure.input.position} = {np.broadcast_to(u, singular.shape).flat[point]:.6g}"
            raise ZeroDivisionError(f"singular position at point {point}, {where}: no velocity is determined")

        def solve(known: np.ndarray) -> np.ndarray:
            return np.moveaxis(
                np.array(cramer.times(adjugate, np.moveaxis(known[..., 0], -1, 0))) / -determinant, 0, -1
            )

        return solve


def _columns(q: ArrayLike) -> list[np.ndarray]:
    """The coordinates one by one, each an array over the points."""
    q = np.asarray(q, dtype=float)
    return [q[..., i] for i in range(q.shape[-1])]


def compiled(arguments: tuple[sp.Symbol, ...], matrix: sp.Matrix) -> Callable[..., np.ndarray]:
    """A function of arrays that gives the matrix at every point; an entry may be constant."""
    moving = [k for k, entry in enumerate(matrix) if entry.free_symbols]
    constant = np.array([0.0 if entry.free_symbols else float(entry) for entry in matrix]).reshape(matrix.shape)
    entries = sp.lambdify(arguments, [matrix[k] for k in moving], "numpy", cse=True)

    def function(*values: ArrayLike) -> np.ndarray:
        shape = np.broadcast(*values).shape
        out = np.empty((len(matrix), *shape))  # each entry in one piece, over the points
        if len(moving) < len(matrix):
            out[:] = constant.reshape(-1, *[1] * len(shape))
        for k, entry in zip(moving, entries(*values), strict=True):
            out[k] = entry
        return np.moveaxis(out.reshape(*matrix.shape, *shape), (0, 1), (-2, -1))

    return function
