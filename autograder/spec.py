"""What an exercise asks, and how an answer is looked at: plain dataclasses, filled in by `autograder.checks`.

A task is examined on cases. Each case is a call of the student's function; the functions that it is handed are
evaluated by the judge, who keeps the arguments. An aspect looks at the trials of one kind and is worth points.
"""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from autograder.compare import Tolerance, disagreement
from autograder.outcome import Outcome, Raised, Value

MOST_EVALUATIONS = 20_000  # of one function in one case; what needs more does not converge
MOST_NUMBERS = 2_000  # in one evaluation: a matrix of their size still fits into the judge

PUBLIC_SALT = "public"  # the cases that a student's own check draws; a cohort is graded with a salt of its own


@dataclass(frozen=True)
class Case:
    """One call of the student's function.

    Attributes
    ----------
    args, kwargs : the arguments; functions among them are evaluated by the judge.
    label : what is tried, in words; shown to a student for public cases only.
    kind : which aspects look at it.
    """

    args: tuple
    kwargs: dict[str, Any] = field(default_factory=dict)
    label: str = ""
    kind: str = "normal"


@dataclass(frozen=True, eq=False)
class Trial:
    """A case, what came back, and every evaluation of the case's functions, in order of the arguments."""

    case: Case
    outcome: Outcome
    evaluations: tuple[list[tuple], ...]

    def path(self, most: int = 6) -> list[np.ndarray]:
        """The first different points, in turn, at which the first function was evaluated."""
        points: list[np.ndarray] = []
        for asked in self.evaluations[0] if self.evaluations else []:
            point = np.asarray(asked[0])
            if not points or point.shape != points[-1].shape or (point != points[-1]).any():
                points.append(point)
            if len(points) == most:
                break
        return points


@dataclass(frozen=True)
class Aspect:
    """One thing that is looked at, worth `points` if `fault` finds nothing in any trial of the kind.

    Attributes
    ----------
    says : what is looked at, as a statement that is true of a right answer.
    fault : (trial, expected) -> sentence, or None where there is no fault; left out, the outcomes must agree.
    """

    says: str
    points: float
    fault: Callable[[Trial, Trial], str | None] | None = None
    kind: str = "normal"


@dataclass(frozen=True)
class Variant:
    """A known mistake, as a change of the reference.

    Attributes
    ----------
    name : the mistake in a few words.
    advice : where to look, without the answer.
    function : the wrong solution, called like the right one.
    share : part of the task's points that are given for it at least.
    by_path : recognise it by the points at which it evaluates the first function, not by what it returns.
    kind : the cases on which it is recognised.
    """

    name: str
    advice: str
    function: Callable
    share: float = 0.0
    by_path: bool = False
    kind: str = "normal"


def readings(name: str, advice: str, *functions: Callable, **more: Any) -> tuple[Variant, ...]:
    """One mistake that can be made in several ways."""
    return tuple(Variant(name, advice, function, **more) for function in functions)


@dataclass(frozen=True)
class Task:
    """One function that a student writes, and how it is looked at.

    Attributes
    ----------
    aspects : what is worth points. The first must hold for the others to count: a function that always raises, or
        always returns nothing, refuses bad input as well.
    cases : random generator -> cases; solvable by construction.
    agree : (expected, got) -> sentence or None; whether two outcomes are the same answer.
    alike : (trial, trial) -> bool; whether two trials show the same mistake, where the outcomes alone cannot tell, as
        where chance has a part in them.
    errors : (trial, expected) -> error of each iterate, for a task that iterates; a wrong answer gets a figure of them.
    seconds : time limit of one case.
    section : chapter and section of the book to go back to.
    """

    name: str
    title: str
    function: str
    reference: Callable
    cases: Callable[[np.random.Generator], list[Case]]
    aspects: tuple[Aspect, ...]
    tolerance: Tolerance
    section: str
    variants: tuple[Variant, ...] = ()
    agree: Callable[[Outcome, Outcome], str | None] | None = None
    alike: Callable[[Trial, Trial], bool] | None = None
    errors: Callable[[Trial, Trial], np.ndarray | None] | None = None
    seconds: float = 5.0

    @property
    def points(self) -> float:
        return sum(aspect.points for aspect in self.aspects)

    def disagreement(self, expected: Outcome, got: Outcome) -> str | None:
        """Why two outcomes are not the same answer; None if they are."""
        return self.agree(expected, got) if self.agree else disagreement(expected, got, self.tolerance)

    def same(self, one: Trial, other: Trial) -> bool:
        """Whether two trials show the same answer."""
        if self.alike:
            return self.alike(one, other)
        return self.disagreement(one.outcome, other.outcome) is None

    def draw(self, salt: str, student: str) -> list[Case]:
        """The cases of one student: the same on any computer, unknown without the salt."""
        seed = hashlib.sha256("\0".join((salt, student, self.name)).encode()).digest()
        return self.cases(np.random.default_rng(np.frombuffer(seed, dtype="<u4")))


@dataclass(frozen=True)
class Exercise:
    """One notebook.

    Attributes
    ----------
    name : name of the notebook without its ending.
    imports : the modules of mechlib that a submission may import.
    cell_seconds : time limit of one cell.
    """

    name: str
    title: str
    tasks: tuple[Task, ...]
    imports: tuple[str, ...] = ()
    cell_seconds: float = 10.0

    @property
    def points(self) -> float:
        return sum(task.points for task in self.tasks)


def attempt(function: Callable, case: Case) -> Trial:
    """Call a function of our own (a reference or a variant) on a case, as the judge calls a student's."""
    args, evaluations = recorded(case)
    try:
        with np.errstate(all="ignore"):
            outcome: Outcome = Value(function(*args, **case.kwargs))
    except (ArithmeticError, ValueError, IndexError) as mistake:
        outcome = Raised.of(mistake)
    return Trial(case, outcome, evaluations)


def recorded(case: Case) -> tuple[tuple, tuple[list[tuple], ...]]:
    """The arguments of a case with every function replaced by one that notes what it is asked."""
    evaluations = []

    def record(function: Callable) -> Callable:
        asked: list[tuple] = []
        evaluations.append(asked)

        def evaluate(*args):
            # copies: the caller may step on in place
            point = tuple(np.array(arg, dtype=float)[()] for arg in args)
            if sum(map(np.size, point)) > MOST_NUMBERS:
                raise ValueError(f"a function takes at most {MOST_NUMBERS} numbers at once")
            if len(asked) >= MOST_EVALUATIONS:
                raise RuntimeError(f"the function was evaluated {MOST_EVALUATIONS} times")
            with np.errstate(all="ignore"):
                value = function(*args)
            asked.append(point)
            return value

        return evaluate

    args = tuple(
        record(arg) if callable(arg) else np.copy(arg) if isinstance(arg, np.ndarray) else arg for arg in case.args
    )
    return args, tuple(evaluations)


def task_table(exercise: Exercise) -> str:
    """What an exercise asks and how it is looked at, as a Markdown table."""
    rows = ["| task | points | what the checks look at |", "|---|---:|---|"]
    for task in exercise.tasks:
        rows.append(f"| **`{task.name}`**: {task.title} | **{task.points:g}** | |")
        rows += [f"| | {aspect.points:g} | {aspect.says} |" for aspect in task.aspects]
    return "\n".join([*rows, f"| together | **{exercise.points:g}** | |"])
