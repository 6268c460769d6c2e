"""How a quantity of a mechanism changes with its parameters, exactly: the theorem of implicit functions.

A quantity g(u, q, p) depends on the parameters p, such as the lengths, in two ways: they stand in it, and the unknowns
q follow them, since the closure F(u, q, p) = 0 holds with the new lengths too.  At a held input u

    dg/dp = g_p + g_q q_p,        J q_p = -F_p,        J = dF/dq,

with the matrix J that Newton-Raphson has.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from mechlib.closure import Closure, compiled
from mechlib.dynamics import Linkage


@dataclass(frozen=True)
class Quantities:
    """Quantities of one kind of mechanism, in symbols and in numbers.

    Attributes
    ----------
    linkage : type of Linkage
    expressions : tuple of m Expr
        In the positions of input and unknowns, and in the parameters; no velocity.
    by : tuple of k Symbol
        The parameters that may change.
    """

    linkage: type[Linkage]
    expressions: tuple[sp.Expr, ...]
    by: tuple[sp.Symbol, ...]

    @classmethod
    def of(cls, linkage: type[Linkage], expressions: Sequence[sp.Expr], by: Sequence[sp.Symbol]) -> "Quantities":
        """With a check that the parameters are those of the mechanism.

        Raises
        ------
        ValueError
            If it has no such parameter, or an expression depends on something else.
        """
        closure = linkage.closure
        known = {closure.input.position, *(q.position for q in closure.unknowns), *linkage.parameters}
        for symbol in (*by, *sp.Matrix(expressions).free_symbols):
            if symbol not in known:
                raise ValueError(f"{symbol} is no parameter and no position of {linkage.__name__}")
        return cls(linkage, tuple(expressions), tuple(by))

    @cached_property
    def derivative(self) -> sp.Matrix:
        """dg/dp, shape (m, k)."""
        g, closure = sp.Matrix(self.expressions), self.linkage.closure
        q, F = [each.position for each in closure.unknowns], closure.position_equations
        follow = sp.Matrix.hstack(*(-closure.solved(F.diff(p)) for p in self.by))
        return g.jacobian(self.by) + g.jacobian(q) * follow

    def values(self, linkage: Linkage, u: ArrayLike, q: ArrayLike) -> np.ndarray:
        """The quantities at closed positions.

        Parameters
        ----------
        linkage : Linkage
            Its parameters may be arrays that broadcast with the points.
        u : array_like, shape (...)
            The input.
        q : array_like, shape (..., n)
            The unknowns.

        Returns
        -------
        ndarray, shape (..., m)
        """
        return self._value(u, *np.moveaxis(np.asarray(q), -1, 0), *linkage.constants)[..., 0]

    def gradient(self, linkage: Linkage, u: ArrayLike, q: ArrayLike) -> np.ndarray:
        """Their derivatives by the parameters, the unknowns following; as `values`, shape (..., m, k).

        Raises
        ------
        ZeroDivisionError
            In a singular position, where the unknowns can follow neither the parameters nor the input; says where.
        """
        linkage.loop.velocity(q, u, 1.0)
        return self._gradient(u, *np.moveaxis(np.asarray(q), -1, 0), *linkage.constants)

    @cached_property
    def _value(self):
        return compiled(self._arguments, sp.Matrix(self.expressions))

    @cached_property
    def _gradient(self):
        return compiled(self._arguments, self.derivative)

    @property
    def _arguments(self) -> tuple[sp.Symbol, ...]:
        closure: Closure = self.linkage.closure
        return (closure.input.position, *(q.position for q in closure.unknowns), *self.linkage.parameters)
