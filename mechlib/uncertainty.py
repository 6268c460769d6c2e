"""What the spread of parameters does to a result: by throwing them, by spreading them evenly, and by derivatives.

Throws are made in blocks, each from its own stretch of a counter-based generator, and blocks are merged in their order.
So throw number i is the same whoever makes it and however many follow, memory does not grow with the throws, and any
number of workers gives the same bits.
"""

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain, islice
from typing import Generic, TypeVar

import numpy as np
from scipy.special import stdtrit
from scipy.stats import qmc

from mechlib import require
from mechlib.laws import Independent, JointLaw
from mechlib.moments import Moments
from mechlib.sweep import OpenPoints

Result = Callable[[np.ndarray], np.ndarray]  # of parameters, (throws, k) -> (throws, ...)
Machine = TypeVar("Machine")
BLOCK = 2048  # throws at a time: what is worked on stays near the processor
TASK = 64  # blocks that a worker is asked for at once
AHEAD = 64  # tasks asked for before the first of them must be there
TOLD = 10  # throws named, of those without a result


class OpenThrowsError(ValueError):
    """Throws that have no result, since the loop cannot close.

    Attributes
    ----------
    count : int
    first : tuple of int
        The numbers of the first of them; `throw` shows their parameters.
    """

    def __init__(self, count: int, first: tuple[int, ...], throws: int):
        self.count, self.first = count, first
        more = ", ..." if count > len(first) else ""
        super().__init__(
            f"{count} of {throws} throws have no result, as of a loop that cannot close: "
            f"number {', '.join(map(str, first))}{more}"
        )


@dataclass(frozen=True)
class Thrown:
    """What the throws gave.

    Attributes
    ----------
    moments : Moments
        Of the throws with a result.
    open : int
        How many have none.
    first_open : tuple of int
        The numbers of the first of these.
    """

    moments: Moments | None
    open: int = 0
    first_open: tuple[int, ...] = ()

    @classmethod
    def merged(cls, pieces: "Sequence[Thrown]") -> "Thrown":
        """In their order."""
        moments = [piece.moments for piece in pieces if piece.moments is not None]
        return cls(
            Moments.merged(moments) if moments else None,
            sum(piece.open for piece in pieces),
            tuple(islice(chain.from_iterable(piece.first_open for piece in pieces), TOLD)),
        )


@dataclass(frozen=True)
class Varied(Generic[Machine]):
    """A result of a mechanism as a function of some of its parameters, for many throws at once.

    Attributes
    ----------
    machine : dataclass
        The mechanism with its nominal parameters; those that vary may be arrays.
    names : tuple of k str
        Of the parameters that vary.
    result : callable, mechanism -> (..., throws, m)
        Given arrays of shape (throws,) for these parameters; the axis of the throws is the last but one.
    """

    machine: Machine
    names: tuple[str, ...]
    result: Callable[[Machine], np.ndarray]

    def __call__(self, parameters: np.ndarray) -> np.ndarray:
        """Shapes (throws, k) -> (throws, ..., m)."""
        results = self.result(replace(self.machine, **dict(zip(self.names, parameters.T, strict=True))))
        throws = results.ndim - 2
        return results.transpose(throws, *range(throws), throws + 1)

    @property
    def nominal(self) -> np.ndarray:
        """The parameters that vary, as they are in the drawing; shape (k,)."""
        return np.array([getattr(self.machine, name) for name in self.names])


def monte_carlo(
    result: Result,
    law: JointLaw,
    throws: int,
    seed: int = 0,
    executor: Executor | None = None,
    open_throws: OpenPoints = "refuse",
    block: int = BLOCK,
) -> Thrown:
    """Mean, deviation and higher moments of a result whose parameters are thrown.

    Parameters
    ----------
    result : callable, (throws, k) -> (throws, ...)
        Not a number where there is none. With processes, one that can be sent there.
    law : JointLaw
        Of the parameters.
    throws : int
    seed : int
        Another one gives other throws.
    executor : Executor, optional
        Anything with the `submit` of `concurrent.futures`: threads, processes, a client of Dask. The bits do not
        depend on it.
    open_throws : {"refuse", "leave out"}
        Where a throw has no result: an error that says how many and which, or they are counted apart.
    block : int
        Throws at a time. The last bits depend on it.

    Returns
    -------
    Thrown

    Raises
    ------
    ValueError
        If the number of throws or the block is not positive, an option has another name, or the result has no axis of
        throws.
    OpenThrowsError
        If throws have no result; also if none has one.

    References
    ----------
    Source D.
    """
    for name, number in {"throws": throws, "block": block}.items():
        if number < 1 or number != int(number):
            raise ValueError(f"{name} must be a positive whole number, got {number}")
    require.one_of("open_throws", open_throws, ("refuse", "leave out"))
    size = block * TASK
    tasks = ((start, min(start + size, throws)) for start in range(0, throws, size))
    thrown = _merged(partial(_blocks, result, law, seed, block), tasks, executor)
    if thrown.open and (open_throws == "refuse" or thrown.moments is None):
        raise OpenThrowsError(thrown.open, thrown.first_open, throws)
    return thrown


def throw(law: JointLaw, start: int, stop: int, seed: int = 0, block: int = BLOCK) -> np.ndarray:
    """The parameters of the throws from one number to before another, as `monte_carlo` has them; (throws, k)."""
    pieces = [unit[first:last] for _, unit, first, last in _units(len(law.mean), seed, block, start, stop)]
    return law.throw(np.concatenate(pieces))


def _units(k: int, seed: int, block: int, start: int, stop: int) -> Iterator[tuple[int, np.ndarray, int, int]]:
    """Number of the first throw, points of the unit cube of one block, and which of them are asked for."""
    philox = np.random.Philox(key=np.random.SeedSequence(seed).generate_state(2, np.uint64))
    generator, state = np.random.Generator(philox), philox.state
    for number in range(start // block, -(-stop // block)):
        state["state"]["counter"][:] = 0, number, 0, 0
        philox.state = state  # where a new generator would begin, which takes longer to make
        begin = number * block
        yield begin, generator.random((k, block)).T, max(start - begin, 0), min(stop - begin, block)


@contextmanager
def _short_rows() -> Iterator[None]:
    """For arrays whose rows are as short as a block: in its usual buffer NumPy would copy each that it repeats."""
    with np.errstate():  # which puts the usual buffer back
        np.setbufsize(BLOCK)
        yield


@_short_rows()
def _blocks(result: Result, law: JointLaw, seed: int, block: int, start: int, stop: int) -> Thrown:
    return Thrown.merged(
        [
            _gathered(_results(result, law.throw(unit[first:last])), begin + first)
            for begin, unit, first, last in _units(len(law.mean), seed, block, start, stop)
        ]
    )


def _results(result: Result, parameters: np.ndarray) -> np.ndarray:
    results = np.asarray(result(parameters), dtype=float)
    if results.shape[:1] != parameters.shape[:1]:
        raise ValueError(
            f"the result must have the throws as its first axis, {len(parameters)}; got the shape {results.shape}"
        )
    return results


def _gathered(results: np.ndarray, number: int) -> Thrown:
    moments = Moments.of(results)
    if np.isfinite(moments.second).all():
        return Thrown(moments)
    closed = np.isfinite(results).all(axis=tuple(range(1, results.ndim)))
    open_throws = np.flatnonzero(~closed)
    first = tuple((number + open_throws[:TOLD]).tolist())
    return Thrown(Moments.of(results[closed]) if closed.any() else None, len(open_throws), first)


def _merged(work: Callable[..., Thrown], tasks: Iterable[tuple], executor: Executor | None) -> Thrown:
    """In the order of the tasks, and never more than a few of them at a time."""
    found = (work(*task) for task in tasks) if executor is None else _asked(work, tasks, executor)
    total = next(found)
    for each in found:
        total = Thrown.merged((total, each))
    return total


def _asked(work: Callable[..., Thrown], tasks: Iterable[tuple], executor: Executor) -> Iterator[Thrown]:
    tasks = iter(tasks)
    ahead = deque(executor.submit(work, *task) for task in islice(tasks, AHEAD))
    while ahead:
        yield ahead.popleft().result()
        ahead.extend(executor.submit(work, *task) for task in islice(tasks, 1))


@dataclass(frozen=True)
class Even:
    """What evenly spread points gave: independent sets of them, each with its own result.

    Attributes
    ----------
    means : ndarray, shape (sets, ...)
    deviations : ndarray, shape (sets, ...)
        Over the number of points, not less one: the mean of even points is no accident of theirs. The sets would
        share that error, and their intervals could not see it.
    """

    means: np.ndarray
    deviations: np.ndarray

    @property
    def mean(self) -> np.ndarray:
        return self.means.mean(axis=0)

    @property
    def deviation(self) -> np.ndarray:
        return np.sqrt((self.deviations**2).mean(axis=0))

    def mean_interval(self, level: float = 0.95) -> tuple[np.ndarray, np.ndarray]:
        """Where the true mean lies, from how far the sets are apart; shapes (...)."""
        return self._interval(self.mean, self.means, level)

    def deviation_interval(self, level: float = 0.95) -> tuple[np.ndarray, np.ndarray]:
        """Where the true deviation lies; shapes (...)."""
        return self._interval(self.deviation, self.deviations, level)

    def _interval(self, middle: np.ndarray, sets: np.ndarray, level: float) -> tuple[np.ndarray, np.ndarray]:
        half = stdtrit(len(sets) - 1, (1 + level) / 2) * sets.std(axis=0, ddof=1) / np.sqrt(len(sets))
        return middle - half, middle + half


def quasi_monte_carlo(
    result: Result,
    law: JointLaw,
    points: int,
    seed: int = 0,
    sets: int = 16,
    executor: Executor | None = None,
    block: int = BLOCK,
) -> Even:
    """As `monte_carlo`, with points that fill the cube of the parameters evenly: Sobol's, scrambled.

    Parameters
    ----------
    result, law, seed, executor, block
        As for `monte_carlo`.
    points : int
        Of a set: a power of two, since only then they are even.
    sets : int
        Independently scrambled sets of points: how far they are apart tells how sure the result is.

    Returns
    -------
    Even

    Raises
    ------
    ValueError
        If the number of points is not a power of two, or there are fewer than two sets.
    OpenThrowsError
        If points have no result; a number counts on from set to set.

    References
    ----------
    A. B. Owen, Randomly permuted (t,m,s)-nets and (t,s)-sequences, 1995.
    """
    if points < 2 or points & (points - 1):
        raise ValueError(f"points must be a power of two, got {points}")
    if sets < 2:
        raise ValueError(f"sets must be at least 2, got {sets}")
    work = partial(_set, result, law, points, min(block, points))
    seeds = list(enumerate(np.random.SeedSequence(seed).spawn(sets)))
    found = [work(*each) for each in seeds] if executor is None else list(_asked(work, seeds, executor))
    if (whole := Thrown.merged(found)).open:
        raise OpenThrowsError(whole.open, whole.first_open, points * sets)
    means, seconds = (np.array([getattr(each.moments, name) for each in found]) for name in ("mean", "second"))
    return Even(means, np.sqrt(seconds / points))


@_short_rows()
def _set(result: Result, law: JointLaw, points: int, block: int, number: int, seed: np.random.SeedSequence) -> Thrown:
    sequence = qmc.Sobol(len(law.mean), bits=53, rng=np.random.default_rng(seed))
    return Thrown.merged(
        [
            _gathered(_results(result, law.throw(sequence.random(block))), number * points + begin)
            for begin in range(0, points, block)
        ]
    )


@dataclass(frozen=True)
class Linear:
    """What the first derivatives say.

    Attributes
    ----------
    covariance : ndarray, shape (..., m, m)
        Of the results, those of the last axis with one another.
    parts : ndarray, shape (..., m, k)
        What each parameter alone does to the deviation, with its sign.
    independent : bool
        Whether the parameters are.
    """

    covariance: np.ndarray
    parts: np.ndarray
    independent: bool

    @property
    def deviation(self) -> np.ndarray:
        """Shape (..., m)."""
        return np.sqrt(np.diagonal(self.covariance, axis1=-2, axis2=-1))

    @property
    def shares(self) -> np.ndarray:
        """Which part of the variance each parameter brings; shape (..., m, k), with the sum one.

        Raises
        ------
        ValueError
            If the parameters are not independent: then a part belongs to two at once.
        """
        if not self.independent:
            raise ValueError("the shares of parameters that depend on one another are not defined")
        return self.parts**2 / (self.parts**2).sum(axis=-1, keepdims=True)


def linear(gradient: np.ndarray, law: JointLaw) -> Linear:
    """The spread of results by their derivatives at the mean of the parameters.

    It is exact if the results are linear, whatever the laws are, and else as good as the curvature over the width of
    the spread is small.

    Parameters
    ----------
    gradient : ndarray, shape (..., m, k)
        Of m results by k parameters, as `implicit.Quantities.gradient` has it.
    law : JointLaw

    Returns
    -------
    Linear

    Raises
    ------
    ValueError
        If there is not a derivative by each parameter.
    """
    gradient, covariance = np.asarray(gradient, dtype=float), law.covariance
    if gradient.ndim < 2 or gradient.shape[-1] != len(covariance):
        raise ValueError(f"gradient must be (..., results, {len(covariance)} parameters), got {gradient.shape}")
    return Linear(
        gradient @ covariance @ np.swapaxes(gradient, -1, -2),
        gradient * np.sqrt(np.diag(covariance)),
        isinstance(law, Independent),
    )
