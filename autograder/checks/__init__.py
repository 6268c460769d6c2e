"""The exercises of the course, one module a notebook."""

from autograder.checks import (
    e01_newton_1d,
    e02_newton_nd,
    e03_motor_profile,
    e04_hacksaw_closure,
    e05_consecutive,
    e06_simultaneous,
    e07_closed_form,
    e08_wiper_kinematics,
    e09_wiper_inverse_dynamics,
    e10_wiper_direct_dynamics,
    e11_cylinder,
    e12_monte_carlo,
)
from autograder.spec import Exercise, Task

_MODULES = (
    e01_newton_1d,
    e02_newton_nd,
    e03_motor_profile,
    e04_hacksaw_closure,
    e05_consecutive,
    e06_simultaneous,
    e07_closed_form,
    e08_wiper_kinematics,
    e09_wiper_inverse_dynamics,
    e10_wiper_direct_dynamics,
    e11_cylinder,
    e12_monte_carlo,
)
EXERCISES: dict[str, Exercise] = {module.EXERCISE.name: module.EXERCISE for module in _MODULES}


def exercise(name: str) -> Exercise:
    """The exercise of that name.

    Raises
    ------
    LookupError
        If there is none; the sentence lists those that exist.
    """
    if name not in EXERCISES:
        raise LookupError(f"there is no exercise {name!r}: there are {', '.join(EXERCISES)}")
    return EXERCISES[name]


def task(name: str) -> Task:
    """The task of that name; the names are different in all exercises.

    Raises
    ------
    LookupError
        If there is none; the sentence lists those that exist.
    """
    tasks = {t.name: t for e in EXERCISES.values() for t in e.tasks}
    if name not in tasks:
        raise LookupError(f"there is no task {name!r}: there are {', '.join(tasks)}")
    return tasks[name]
