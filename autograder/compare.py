"""Whether two answers are the same, and if not, why not: in words that do not give the answer away."""

import builtins
import re
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from autograder.outcome import Lost, Outcome, Raised, Value
from autograder.worker.wire import NotData


@dataclass(frozen=True)
class Tolerance:
    """How near is near enough: ``|got - expected| <= absolute + relative * max |expected|``.

    The scale is that of the whole array: an entry that cancels to zero cannot be held to its own size.
    """

    relative: float
    reason: str
    absolute: float = 0.0


# Names that are no submission's own.
KNOWN = {name for name, kind in vars(builtins).items() if isinstance(kind, type)}
KNOWN |= {"ConvergenceError", "LinAlgError", "OpenLoopError"}
SHAPE = re.compile(r"its shape is \([\d, ]*\)")

FACTORS = {
    -1.0: "the sign is turned round",
    180 / np.pi: "degrees where radians are asked for?",
    np.pi / 180: "radians taken for degrees?",
    1000.0: "millimetres where metres are asked for?",
    1e-3: "metres where millimetres are asked for?",
    2.0: "twice too large",
    0.5: "half of what it should be",
}


def disagreement(expected: Outcome, got: Outcome, tolerance: Tolerance) -> str | None:
    """Why an outcome is not the expected one.

    Parameters
    ----------
    expected, got : Value, Raised or Lost
    tolerance : Tolerance

    Returns
    -------
    str or None
        A sentence that holds no number of the expected answer; None where the two agree.
    """
    match expected, got:
        case _, Lost(why=why):
            return why
        case Value(value=right), Value(value=answer):
            return difference(right, answer, tolerance)
        case Value(), Raised(type=name):
            return f"it raised {name}"
        case Raised(type=name), Value():
            return f"it returned a value where {name} is right"
        case Raised(type=name), Raised():
            return None if got.is_a(name) else f"it raised {got.type} where {name} is right"


def difference(expected: Any, got: Any, tolerance: Tolerance) -> str | None:
    """Why an array of numbers is not the expected one; None where it is. See `disagreement`."""
    expected = np.asarray(expected)
    answer = numbers(got)
    if isinstance(answer, str):
        return answer
    if not expected.size and not answer.size:
        return None  # nothing is nothing, in whatever container
    if answer.shape != expected.shape:
        return wrong_shape(answer, expected.shape)
    undefined = np.isnan(answer) & ~np.isnan(expected)
    if undefined.any():
        return f"it is not a number at index {_first(undefined)}"
    right_nan = np.isnan(expected)
    if (right_nan & ~np.isnan(answer)).any():
        return f"it is a number at index {_first(right_nan & ~np.isnan(answer))}, where nan is right"
    finite = np.isfinite(expected)
    scale = np.abs(expected[finite]).max(initial=0.0)
    allowed = tolerance.absolute + tolerance.relative * scale
    with np.errstate(invalid="ignore"):
        off = np.where(right_nan | (expected == answer), 0.0, np.abs(answer - expected))
    if (off <= allowed).all():
        return None
    if scale and (words := _factor(expected, answer, allowed)):
        return words
    worst = np.unravel_index(np.argmax(np.nan_to_num(off, nan=np.inf)), off.shape)
    where = f" at index {_index(worst)}" if off.ndim else ""
    size = f"{off[worst] / scale:.1g} of the scale" if scale else f"{off[worst]:.1g}"
    return f"it is off by {size}{where}; {tolerance.reason}"


def _factor(expected: np.ndarray, answer: np.ndarray, allowed: float) -> str | None:
    largest = np.nanargmax(np.abs(expected))
    right, got = expected.flat[largest], answer.flat[largest]
    for factor, words in FACTORS.items():
        near = abs(factor) * allowed
        if abs(got - factor * right) <= near and (np.abs(answer - factor * expected) <= near).all():
            return words
    return None


def wrong_shape(got: np.ndarray, right: object) -> str:
    return f"its shape is {got.shape}, and not {right}"


def without_own_names(outcome: Outcome) -> Outcome:
    """An outcome without the names that a submission gave to its classes, for they may hold a hidden input."""
    match outcome:
        case Raised(type=name, bases=bases) if name not in KNOWN:
            known = next((base for base in bases if base in KNOWN), "Exception")
            return replace(outcome, type=known, bases=(name, *bases))
        case Value(value=NotData(type=name)) if name not in KNOWN and not re.fullmatch(r"array of [a-z]+\d{0,3}", name):
            plain = "array of something else" if name.startswith("array of") else "object of another class"
            return Value(NotData(plain))
    return outcome


def without_own_shape(fault: str) -> str:
    """A sentence without the shape that a submission gave to its answer, for it may be a hidden input."""
    return SHAPE.sub("its shape is another one", fault)


def numbers(value: Any) -> np.ndarray | str:
    """Data as an array of real numbers, or a sentence that says what it is instead."""
    try:
        array = np.asarray(value)
    except ValueError:
        return "its rows have different lengths"
    if array.dtype == object or array.dtype.kind not in "biuf":
        return f"it is {_kind(value)}, and not an array of real numbers"
    return array.astype(float)


def _kind(value: Any) -> str:
    if value is None:
        return "None (is a return missing?)"
    name = value.type if isinstance(value, NotData) else type(value).__name__
    return f"{'an' if name[0] in 'aeiou' else 'a'} {name}"


def _first(mask: np.ndarray) -> str:
    return _index(tuple(np.argwhere(mask)[0]))


def _index(index: tuple) -> str:
    return str(tuple(int(i) for i in index)) if len(index) != 1 else str(int(index[0]))
