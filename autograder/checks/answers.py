"""What came back from a student's function, as the array that an aspect looks into."""

import numpy as np

from autograder.compare import numbers
from autograder.outcome import Raised, Value
from autograder.spec import Trial


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
    return got if got.shape == shape else f"its shape is {got.shape}, and not {f'{named} = ' if named else ''}{shape}"
