"""Mutants before the judge: which lose points, and which of the others are no mistakes at all."""

import signal
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count

import numpy as np
from judging import answering, paper

from autograder.judge import ENDLESS, Assessment, assess
from autograder.outcome import Outcome, Value
from autograder.spec import Case, Task, Trial, recorded
from examination.mutants import Mutant
from examination.solutions import Solution

SALT = "examination"
STUDENTS = ("first", "second")  # a mutant must lose points with both
INPUTS = 10_000  # on which an equivalent mutant is the reference
SECONDS = 5.0  # for one case
ROUND_OFF = 1e-12

# Where an aspect looks at the points of evaluation as well, or counts them.
BY_EVALUATIONS = {"brackets", "newton_1d", "failures", "newton", "jacobian_fd"}
BY_EVALUATIONS |= {"saw_position", "saw_sweep", "one_point", "all_points", "torque_and_forces"}
BY_EVALUATIONS |= {"saw_position", "saw_sweep", "one_point", "all_points", "driven_motion", "propagate"}


class Endless(BaseException):
    """The time is up; no `except Exception` of a mutant's may catch it."""


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    def stop(*_):
        raise Endless

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def calling(function: Callable, limit: float = SECONDS) -> Callable:
    """A submission whose every function is this one; it warns nobody, and its time is limited."""
    answer = answering(function)

    def call(*question) -> Outcome:
        try:
            with warnings.catch_warnings(), time_limit(limit):
                warnings.simplefilter("ignore")
                return answer(*question)
        except Endless:
            return ENDLESS

    return call


@dataclass(frozen=True)
class Judged:
    """What became of a mutant.

    Attributes
    ----------
    lost : it lost points with every student.
    verdicts : of the judge, on each task and student.
    """

    lost: bool
    verdicts: frozenset[str]


def judge(of: Solution, mutant: Mutant, seconds: float = SECONDS) -> Judged:
    call = calling(of.made(mutant.source), seconds)
    verdicts, losses = set(), []
    for student in STUDENTS:
        assessments = [_assessed(task, call, student) for task in of.tasks]
        verdicts |= {a.verdict for a in assessments}
        losses.append(any(a.points < a.max for a in assessments))
    return Judged(all(losses), frozenset(verdicts))


def _assessed(task: Task, call: Callable, student: str) -> Assessment:
    return assess(paper(task, SALT, student), call, public=False)


# What a case of a task computes apart from the rest: each is an input.
PARTS: dict[str, Callable[..., int]] = {
    "brackets": lambda f, a, b, n: max(n, 1),  # subintervals
    "basin_map": lambda f, j, xs, ys, roots: len(xs) * len(ys),  # seeds
    "motor_profile": lambda t, T, peak: len(t),  # instants
    "misprint": lambda *args: 8,  # curves
    "saw_rates": lambda q, crank, lengths: len(q),  # points
    "saw_sweep": lambda f, j, theta2, *rest: len(theta2),  # crank angles
    "all_points": lambda f, j, crank, *rest: len(crank[0]),  # points of the motion
    "closed_position": lambda theta2, *rest: np.size(theta2),  # crank angles
    "closed_form": lambda theta2, *rest: len(theta2),  # points
    "absolute_errors": lambda computed, exact: computed.size,  # numbers
    "wiper_positions": lambda f, theta1, *rest: len(theta1),  # crank angles
    "wiper_rates": lambda q, crank, lengths: len(q),  # points
    "wiper_points": lambda theta1, *rest: len(theta1),  # points
    "steiner": lambda inertia, *rest: len(inertia),  # bodies
    "centre_accelerations": lambda motion, *rest: motion.shape[1],  # points
    "fifteen_equations": lambda motion, *rest: motion.shape[1],  # points
    "torque_and_forces": lambda system, velocities, size: len(velocities),  # points
    "power_residual": lambda motion, *rest: motion.shape[1],  # points
    "body_residuals": lambda motion, *rest: motion.shape[1],  # points
    "planted_mistake": lambda motion, *rest: motion.shape[1],  # points
    "direct_system": lambda *args: 17,  # equations
    "driven_motion": lambda acceleration, torque, start, t, lengths: len(t),  # instants
    "energy_drift": lambda t, *rest: len(t),  # instants
    "smooth_friction": lambda velocity, size, v0: velocity.size,  # components
    "cylinder_angles": lambda a, lengths: len(a),  # strokes
    "cylinder_ratios": lambda a, angles, lengths: len(a),  # strokes
    "virtual_power": lambda stroke, *rest: stroke.shape[1],  # points
    "lagrange_terms": lambda stroke, *rest: stroke.shape[1],  # points
    "wrong_term": lambda t, *rest: len(t),  # points
    "coupler_point": lambda theta2, lengths, *rest: len(lengths),  # linkages
    "propagate": lambda point, nominal, half_width, throws, *rest: throws,
    "linear_propagation": lambda theta2, *rest: len(theta2),  # points
    "wrong_part": lambda theta2, lengths, *rest: len(lengths),  # throws
}


def inputs(task: Task, case: Case) -> int:
    return PARTS[task.name](*case.args) if task.name in PARTS else 1


def equivalents(of: Solution, survivors: Iterable[Mutant], inputs_wanted: int = INPUTS) -> dict[Mutant, str]:
    """The first input on which each mutant differs from the reference; empty where it does on none of many.

    All are tried on the same inputs, drawn as a student's are, and together cost one draw and one reference.
    """
    differs = dict.fromkeys(survivors, "")
    left = {mutant: calling(of.made(mutant.source)) for mutant in differs}
    reference = calling(of.made())
    for task in of.tasks:
        tried = 0
        for n in count():
            for case in task.draw(f"{SALT} of equals", f"student {n}"):
                right = _trial(reference, case)
                for mutant, call in list(left.items()):
                    if not same(right, _trial(call, case), task.name in BY_EVALUATIONS):
                        differs[mutant] = f"student {n}: {case.label}"
                        del left[mutant]
                tried += inputs(task, case)
            if tried >= inputs_wanted or not left:
                break
    return differs


def _trial(call: Callable, case: Case) -> Trial:
    args, evaluations = recorded(case)
    return Trial(case, call("", args, case.kwargs, SECONDS), evaluations)


def same(a: Trial, b: Trial, by_evaluations: bool) -> bool:
    """Whether two trials are the same but for round-off."""
    if by_evaluations and not alike([*map(list, a.evaluations)], [*map(list, b.evaluations)]):
        return False
    match a.outcome, b.outcome:
        case Value(value=one), Value(value=other):
            return alike(one, other)
        case one, other:
            return one == other


def alike(one, other) -> bool:
    if isinstance(one, (tuple, list)) and isinstance(other, (tuple, list)):
        return len(one) == len(other) and all(map(alike, one, other))
    try:
        one, other = np.asarray(one), np.asarray(other)
    except ValueError:
        return False
    if one.dtype.kind not in "biuf" or other.dtype.kind not in "biuf":
        return one.shape == other.shape and bool((one == other).all())
    scale = np.abs(one[np.isfinite(one)]).max(initial=0.0)
    return one.shape == other.shape and np.allclose(one, other, rtol=0, atol=ROUND_OFF * scale, equal_nan=True)
