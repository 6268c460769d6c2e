"""What can be said of a Newton-Raphson iteration from its history, and from where it evaluated the function."""

from collections.abc import Callable

import numpy as np

from autograder.checks.answers import said
from autograder.compare import Tolerance, difference, numbers, wrong_shape
from autograder.outcome import Raised, Value
from autograder.spec import Trial, Variant

MOST_DRAWN = 30  # iterates in a figure
ROUND_OFF = Tolerance(1e-8, "two ways to write a step differ by round-off, some 1e-15 of the scale")


def history(trial: Trial) -> np.ndarray | str:
    """The iterates that were returned, or a sentence that says what came instead."""
    if isinstance(trial.outcome, Raised):
        return f"it raised {trial.outcome.type}"
    assert isinstance(trial.outcome, Value)
    iterates = numbers(trial.outcome.value)
    if isinstance(iterates, str):
        return iterates
    seed = np.asarray(trial.case.args[2])
    if iterates.ndim != seed.ndim + 1 or iterates.shape[1:] != seed.shape:
        return wrong_shape(iterates, f"(iterations + 1{''.join(f', {n}' for n in seed.shape)})")
    return iterates if len(iterates) else "it is empty"


def errors(trial: Trial, right: Trial) -> np.ndarray | None:
    """Distance of each iterate from the root; None where there is neither a history nor a path."""
    iterates = history(trial) if isinstance(trial.outcome, Value) else ""
    if isinstance(iterates, str):
        iterates = [x for x in trial.path(MOST_DRAWN) if x.shape == np.shape(trial.case.args[2])]
    if isinstance(right.outcome, Raised) or len(iterates) < 2:
        return None
    off = np.array(iterates[:MOST_DRAWN]) - right.outcome.value[-1]
    with np.errstate(all="ignore"):
        return np.abs(off) if off.ndim == 1 else np.linalg.norm(off, axis=1)


def ends_on_the_root(trial: Trial, right: Trial) -> str | None:
    iterates = history(trial)
    if isinstance(iterates, str):
        return iterates
    # as near as the tolerance that was asked for, with room for a slower right way
    near = Tolerance(1e-6, "the last iterate must be the root", absolute=10 * trial.case.args[3])
    return difference(right.outcome.value[-1], iterates[-1], near)


def takes_newtons_steps(trial: Trial, right: Trial) -> str | None:
    iterates = history(trial)
    if isinstance(iterates, str):
        return iterates
    newton = right.outcome.value
    for k, (got, expected) in enumerate(zip(iterates, newton, strict=False)):
        if difference(expected, got, ROUND_OFF):
            return "the first entry is not the seed" if k == 0 else f"step {k} is not Newton's"
    return "there is no step" if len(iterates) == 1 else None


def stops_when_asked(trial: Trial, right: Trial) -> str | None:
    iterates = history(trial)
    if isinstance(iterates, str):
        return iterates
    more = len(iterates) - len(right.outcome.value)
    if not more:
        return None
    return f"it stops {abs(more)} iteration{'s' if abs(more) > 1 else ''} too {'late' if more > 0 else 'early'}"


def evaluates_once_an_iteration(trial: Trial, right: Trial) -> str | None:
    iterates = history(trial)
    if isinstance(iterates, str):
        return iterates
    for name, asked in zip(("the function", "the derivative"), trial.evaluations, strict=True):
        if len(asked) > len(iterates):  # one more than iterations: a look at the root is forgiven
            return f"it evaluates {name} {len(asked)} times in {len(iterates) - 1} iterations"
    return None


def fails_aloud(trial: Trial, right: Trial) -> str | None:
    match trial.outcome:
        case Raised(type="ZeroDivisionError"):
            return "it raised ZeroDivisionError, which is Python's own word, and not ConvergenceError"
        case Raised() as raised if raised.is_a("ArithmeticError"):
            pairs = zip(trial.evaluations, right.evaluations, strict=True)
            tried = any(asked and len(asked) >= len(needed) for asked, needed in pairs)
            return None if tried else "it gives up before the iterations run out"
        case Raised(type=name):
            return f"it raised {name}, which is no ArithmeticError"
        case _:
            return "it returned a value where there is no root to be found"


def says_where(trial: Trial, right: Trial) -> str | None:
    if not isinstance(trial.outcome, Raised):
        return "it returned a value where there is no root to be found"
    told = said(trial.outcome.message)
    f, df, *_ = trial.case.args
    seen = [float(np.ravel(asked[0])[0]) for log in trial.evaluations for asked in log[-2:] if np.size(asked[0]) == 1]
    ahead = [x - f(x) / df(x) for x in seen if df(x)]
    # three digits of the point are enough: the message is for people
    if any(np.isclose(told, x, rtol=1e-2, atol=1e-9).any() for x in [*seen, *ahead] if np.isfinite(x)):
        return None
    return "its message does not tell the x at which it failed"


def slips_of_the_history(iterates: Callable) -> tuple[Variant, ...]:
    """Mistakes in what is kept of a right iteration, whose reference returns its iterates."""
    return (
        Variant(
            "The seed is missing from the history",
            "The history begins before the first step.",
            lambda *args: iterates(*args)[1:],
            share=0.5,
        ),
        Variant(
            "The last iterate is missing from the history",
            "The step that proves convergence is taken: its end is the root.",
            lambda *args: iterates(*args)[:-1],
            share=0.5,
        ),
        Variant(
            "The root alone is returned",
            "The history holds every iterate: the order of convergence is read from it.",
            lambda *args: iterates(*args)[-1],
            share=0.25,
        ),
    )
