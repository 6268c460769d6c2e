"""A function judged as the grader judges a student's, without a worker between them."""

from functools import lru_cache

import numpy as np

from autograder.checks import task
from autograder.judge import Assessment, assess, drawn
from autograder.outcome import Raised, Value
from autograder.spec import Task

paper = lru_cache(8)(drawn)  # many functions are judged on the same paper, one after another


def answering(function):
    """A submission whose every function is this one, called as the grader calls it."""

    def call(name, args, kwargs, seconds):
        try:
            with np.errstate(all="ignore"):
                return Value(function(*args, **kwargs))
        except Exception as mistake:
            return Raised.of(mistake)

    return call


def judged(t: Task | str, function, student: str, public: bool = False, salt: str = "salt") -> Assessment:
    """What is said of a function that answers a task, given itself or by name."""
    t = task(t) if isinstance(t, str) else t
    return assess(paper(t, salt, student), answering(function), public)
