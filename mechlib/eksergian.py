"""One equation for a mechanism of one degree of freedom, after Eksergian (1928).

All velocities are in a fixed ratio to the input's: q' = k u', and so q'' = k u'' + h u'^2 with h = dk/du.  Put into the
balance of power, the joint forces are gone before they appear, the input's velocity cancels, and what is left is

    J(u) u'' + J'(u)/2 u'^2 + V'(u) = M + Q,

with the reduced inertia J, the potential energy V, the torque M and the reduced load Q.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import sympy as sp
from numpy.typing import ArrayLike

from mechlib.closure import Closure
from mechlib.dynamics import Machine, at_points
from mechlib.rigidbody import RigidBodies


@dataclass(frozen=True)
class ReducedEquation:
    """The terms of the one equation, in symbols.

    Attributes
    ----------
    inertia : Expr
        J, kg m^2.
    inertial : Expr
        J'/2 u'^2 + V', N m.
    load : Expr
        Q, N m.
    k, h : tuple of n Symbol
        They stand for the velocity ratios of the unknowns and for their derivatives; see `velocity_ratios`.
    """

    inertia: sp.Expr
    inertial: sp.Expr
    load: sp.Expr
    k: tuple[sp.Symbol, ...]
    h: tuple[sp.Symbol, ...]

    @classmethod
    def of(cls, rigid: RigidBodies) -> "ReducedEquation":
        """From the balance of power of a mechanism."""
        u, unknowns = rigid.closure.input, rigid.closure.unknowns
        k, h = (sp.symbols(f"{letter}_1:{len(unknowns) + 1}") for letter in "kh")
        tied = {}
        for q, ratio, change in zip(unknowns, k, h, strict=True):
            tied[q.velocity] = ratio * u.velocity
            tied[q.acceleration] = ratio * u.acceleration + change * u.velocity**2
        torque = (rigid.power.subs(tied) / u.velocity).expand()
        unloaded = torque.subs({component: 0 for load in rigid.loads for component in load.force})
        return cls(unloaded.coeff(u.acceleration), unloaded.subs(u.acceleration, 0), (unloaded - torque).expand(), k, h)


def velocity_ratios(closure: Closure) -> tuple[sp.Matrix, sp.Matrix]:
    """The ratios k = dq/du and their derivatives h = dk/du, in symbols.

    Parameters
    ----------
    closure : Closure
        Of at most three unknowns.

    Returns
    -------
    k, h : Matrix, shape (n, 1)
    """
    unit = {closure.input.velocity: 1, closure.input.acceleration: 0}
    k = -closure.solved(closure.drive.subs(unit))
    moving = dict(zip((q.velocity for q in closure.unknowns), k, strict=True))
    return k, -closure.solved(closure.gamma.subs(unit).subs(moving))


def torque(rigid: RigidBodies) -> sp.Expr:
    """What must drive a mechanism, in symbols: of the input's motion, the positions, the parameters and the loads.

    No velocity of an unknown is in it, so at a given motion it is a function of the position alone, as a place is.
    """
    equation, u = ReducedEquation.of(rigid), rigid.closure.input
    k, h = velocity_ratios(rigid.closure)
    tied = dict(zip((*equation.k, *equation.h), (*k, *h), strict=True))
    return (equation.inertia * u.acceleration + equation.inertial - equation.load).subs(tied)


class Terms(NamedTuple):
    """The terms at one instant: J, J'/2 u'^2 + V', and Q."""

    inertia: float
    inertial: float
    load: float


def ratios(machine: Machine, u: float, q: ArrayLike) -> tuple[list[float], list[float]]:
    """The velocity ratios k and their derivatives h at one closed position.

    Raises
    ------
    ZeroDivisionError
        In a singular position, where they are not determined; says where.
    """
    try:
        return _functions(type(machine))[0](u, *q, *machine.constants)
    except ZeroDivisionError:
        name = machine.rigid.closure.input.position
        raise ZeroDivisionError(f"singular position at {name} = {u:.6g}: no velocity is determined") from None


def terms(machine: Machine, u: float, q: ArrayLike, du: float, loads: ArrayLike | None = None) -> Terms:
    """The terms of the equation at one instant, in plain floats: much faster than arrays that hold one number.

    Parameters
    ----------
    machine : Machine
    u, du : float
        The input and its velocity.
    q : array_like, shape (n,)
        The unknowns, which close the loop.
    loads : array_like, shape (number of loads, 2), optional
        The known forces at the centres of mass, N; none if left out.

    Returns
    -------
    Terms

    Raises
    ------
    ZeroDivisionError
        In a singular position; says where.
    """
    k, h = ratios(machine, u, q)
    components = at_points(machine, 1, None if loads is None else [loads]).ravel()
    return Terms(*_functions(type(machine))[1](u, *q, du, *k, *h, *machine.constants, *components))


@cache
def _functions(machine: type[Machine]) -> tuple[Callable, Callable]:
    rigid, closure = machine.rigid, machine.rigid.closure
    equation = ReducedEquation.of(rigid)
    position = (closure.input.position, *(q.position for q in closure.unknowns))
    loads = (component for load in rigid.loads for component in load.force)
    k, h = (list(column) for column in velocity_ratios(closure))
    arguments = (*position, closure.input.velocity, *equation.k, *equation.h, *machine.parameters, *loads)
    terms = [equation.inertia, equation.inertial, equation.load]
    return tuple(
        sp.lambdify(symbols, expressions, "math", cse=True)
        for symbols, expressions in (((*position, *machine.parameters), [k, h]), (arguments, terms))
    )
