"""What came back from a student's function, as the array that an aspect looks into."""

import re
from collections.abc import Callable

import numpy as np

from autograder.compare import Tolerance, disagreement, numbers, wrong_shape
from autograder.outcome import Outcome, Raised, Value
from autograder.spec import Trial

NUMBER = re.compile(r"[-+]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|\b(?:nan|inf)\b)")


def array(trial: Trial, shape: tuple[int, ...], named: str = "") -> np.ndarray | str:
    """The numbers that were returned, or a sentence that says what came instead.

    Parameters
    ----------
    trial : Trial
        One that was not lost.
    shape : tuple of int
        The shape that is right.
    named : str
        What its axes are, as ``"(points, 3)"``.
    """
    if isinstance(trial.outcome, Raised):
        return f"it raised {trial.outcome.type}"
    assert isinstance(trial.outcome, Value)
    got = numbers(trial.outcome.value)
    if isinstance(got, str):
        return got
    return got if got.shape == shape else wrong_shape(got, f"{named} = {shape}" if named else shape)


def arrays(outcome: Outcome, shapes: dict[str, tuple[int, ...]], named: str) -> tuple[np.ndarray, ...] | str:
    """The arrays of an answer in several parts, or a sentence that says what came instead.

    Parameters
    ----------
    outcome : Outcome
        One that was not lost.
    shapes : dict of str to tuple of int
        By the name of each part: the shape that is right.
    named : str
        What all of them are, as ``"a pair (matrix, right)"``.
    """
    if isinstance(outcome, Raised):
        return f"it raised {outcome.type}"
    assert isinstance(outcome, Value)
    if not isinstance(outcome.value, (tuple, list)) or len(outcome.value) != len(shapes):
        return f"it is not {named}"
    found = []
    for (name, shape), part in zip(shapes.items(), outcome.value, strict=True):
        got = numbers(part)
        if isinstance(got, str):
            return f"{name}: {got}"
        if got.shape != shape:
            return f"{name}: {wrong_shape(got, shape)}"
        found.append(got)
    return tuple(found)


def said(message: str) -> list[float]:
    """The numbers in a message."""
    return [float(number) for number in NUMBER.findall(message)]


def refuses(wrong: Callable[..., tuple[float, ...]], tolerance: Tolerance) -> Callable:
    """Looks for the exception that is right, and for the value that is wrong in its message, to three digits.

    Parameters
    ----------
    wrong : callable
        The arguments of the case -> the values of which one must be told.
    tolerance : Tolerance
        For good input at the edge of the bad, which must not be refused.
    """

    def fault(trial: Trial, right: Trial) -> str | None:
        if why := disagreement(right.outcome, trial.outcome, tolerance):
            return why
        if not isinstance(trial.outcome, Raised):
            return None
        told = np.array(said(trial.outcome.message))
        if any(np.isclose(told, value, rtol=1e-2, equal_nan=True).any() for value in wrong(*trial.case.args)):
            return None
        return "its message does not hold the value that is wrong"

    return fault
