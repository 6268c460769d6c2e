"""Newton-Raphson in one and in many variables: follow the tangent to its zero until the step is small.

In many variables the step is solved for and never multiplied by an inverse: a solve costs a third of an inversion
and loses fewer digits.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True)
class Iteration:
    """The path of a Newton-Raphson iteration.

    Attributes
    ----------
    history : ndarray, shape (iterations + 1,) or (iterations + 1, n)
        Iterates, the seed first, the root last; units of the unknowns.
    errors : ndarray, shape (iterations,)
        The size of each step, absolute or relative as was asked for: source A, section 3.1.1, eq. (1).
    converged : bool
        Whether the last error fell below the tolerance.
    """

    history: np.ndarray
    errors: np.ndarray
    converged: bool

    @property
    def root(self) -> np.ndarray | float:
        return self.history[-1]

    @property
    def iterations(self) -> int:
        return len(self.errors)

    @property
    def evaluations(self) -> int:
        """Evaluations of the function, and as many of its derivative: one of each an iteration."""
        return self.iterations

    def order(self) -> float:
        """Observed order of convergence; see `order`."""
        return order(self.history)


class ConvergenceError(ArithmeticError):
    """The iteration gave no root; the message says at which point and why.

    Attributes
    ----------
    path : Iteration
        How far it came.
    """

    def __init__(self, why: str, path: Iteration):
        super().__init__(why)
        self.path = path


def order(history: ArrayLike) -> float:
    """Observed order of convergence, from the last three steps above round-off.

    Two means Newton; one means that the derivative is wrong, stale or singular at the root.

    Parameters
    ----------
    history : array_like, shape (iterations + 1,) or (iterations + 1, n)
        Iterates, the seed first.

    Returns
    -------
    float
        log(s3/s2) / log(s2/s1) for the last three steps s1, s2, s3 longer than 8 units of round-off at the root;
        nan where there are fewer than three.
    """
    iterates = np.asarray(history, dtype=float)
    iterates = iterates.reshape(len(iterates), -1)
    steps = np.linalg.norm(np.diff(iterates, axis=0), axis=1)
    round_off = 8 * np.finfo(float).eps * np.linalg.norm(iterates[-1])
    s = steps[steps > round_off][-3:]
    return float(np.log(s[2] / s[1]) / np.log(s[1] / s[0])) if len(s) == 3 else np.nan


def newton_1d(
    f: Callable[[float], float],
    df: Callable[[float], float],
    seed: float,
    tol: float = 1e-10,
    error: Literal["absolute", "relative"] = "absolute",
    max_iterations: int = 50,
) -> Iteration:
    """Zero of a function of one variable by Newton-Raphson, x - f(x)/f'(x).

    Parameters
    ----------
    f, df : callable, float -> float
        The function and its derivative.
    seed : float
        Where to start; near enough, and not where the derivative is zero.
    tol : float
        Stop when the error falls below it; units of x, or none if the error is relative.
    error : {"absolute", "relative"}
        The length of the step, or that length divided by the size of the new iterate.
    max_iterations : int

    Returns
    -------
    Iteration

    Raises
    ------
    ValueError
        If `tol` or `max_iterations` is not positive, `error` has another name, or the seed is not a finite number.
    ConvergenceError
        If the derivative is zero, an iterate is not finite, or the iterations run out.

    References
    ----------
    Source A, section 3.1.1; source B, section 2.
    """
    if np.ndim(seed) != 0:
        raise ValueError(f"seed must be one number, got {seed!r}; systems of equations are for newton")

    def step(x: float) -> float:
        slope = df(x)
        if slope == 0:
            raise ZeroDivisionError("zero derivative")
        return f(x) / slope

    return _iterate(step, seed, tol, error, max_iterations)


def newton(
    residual: Callable[[np.ndarray], ArrayLike],
    jacobian: Callable[[np.ndarray], ArrayLike],
    seed: ArrayLike,
    tol: float = 1e-10,
    error: Literal["absolute", "relative"] = "absolute",
    max_iterations: int = 50,
) -> Iteration:
    """Root of a system of equations by Newton-Raphson: solve J(x) d = F(x), step to x - d.

    Parameters
    ----------
    residual : callable, (n,) -> (n,)
    jacobian : callable, (n,) -> (n, n)
        ``jacobian(x)[i, j]`` is the derivative of ``residual(x)[i]`` by ``x[j]``.
    seed : array_like, shape (n,)
        Where to start; near enough, and on the assembly branch that is wanted.
    tol : float
        Stop when the error falls below it; units of the unknowns, or none if the error is relative.
    error : {"absolute", "relative"}
        The 2-norm of the step, or that norm divided by the norm of the new iterate.
    max_iterations : int

    Returns
    -------
    Iteration

    Raises
    ------
    ValueError
        If `tol` or `max_iterations` is not positive, `error` has another name, or the seed is not a finite vector.
    ConvergenceError
        If the Jacobian is singular, an iterate is not finite, or the iterations run out.

    References
    ----------
    Source A, section 3.1.2, eq. (2); source B, section 3 (left division).
    """
    if np.ndim(seed) != 1:
        raise ValueError(f"seed must be a vector, got {seed!r}")

    def step(x: np.ndarray) -> np.ndarray:
        try:
            return np.linalg.solve(jacobian(x), residual(x))
        except np.linalg.LinAlgError as mistake:
            if "ingular" not in str(mistake):  # not square, say: the caller's mistake and not the mathematics'
                raise ValueError(f"the Jacobian does not fit {x.size} unknowns: {mistake}") from None
            raise ZeroDivisionError("singular Jacobian") from None

    return _iterate(step, seed, tol, error, max_iterations)


def _iterate(step, seed, tol, error, max_iterations) -> Iteration:
    x = np.array(seed, dtype=float)[()]
    if not np.isfinite(x).all():
        raise ValueError(f"seed must be finite, got {seed!r}")
    if not tol > 0:
        raise ValueError(f"tol must be positive, got {tol}")
    if not max_iterations > 0:
        raise ValueError(f"max_iterations must be positive, got {max_iterations}")
    if error not in ("absolute", "relative"):
        raise ValueError(f"error must be 'absolute' or 'relative', got {error!r}")

    history, errors = [x], []

    def path(converged: bool) -> Iteration:
        return Iteration(np.array(history), np.array(errors), converged)

    for k in range(1, max_iterations + 1):
        try:
            with np.errstate(all="ignore"):  # what overflows or leaves the domain is said below, with the point
                d = step(x)
                length = np.linalg.norm(d)
        except ZeroDivisionError as why:
            raise ConvergenceError(f"{why} in iteration {k}, at x = {_short(x)}", path(False)) from None
        x = x - d
        if not np.isfinite(x).all():
            why = f"iteration {k} left the domain, from x = {_short(history[-1])} to {_short(x)}"
            raise ConvergenceError(why, path(False))
        size = np.linalg.norm(x) if error == "relative" else 1.0
        history.append(x)
        errors.append(length / size if size else np.inf)
        if errors[-1] < tol:
            return path(True)
    last = f"last {error} error {errors[-1]:.1e} at x = {_short(x)}, tol {tol:.1e}"
    raise ConvergenceError(f"no root after {max_iterations} iterations: {last}", path(False))


def _short(x: np.ndarray | float) -> str:
    """Six digits: a message is for people."""
    return f"{x:.6g}" if np.ndim(x) == 0 else np.array2string(x, precision=6)
