"""The reference solutions as students see them: the functions of `solutions/*.md`, which can be changed and run."""

import ast
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import jupytext

from autograder.checks import EXERCISES
from autograder.spec import Task

FOLDER = Path(__file__).parents[2] / "solutions"


@dataclass(frozen=True)
class Solution:
    """One function of a solved notebook.

    Attributes
    ----------
    exercise : name of the notebook.
    source : the function's text, with its docstring.
    tasks : those that look at it.
    """

    exercise: str
    source: str
    tasks: tuple[Task, ...]

    @property
    def function(self) -> str:
        return self.tasks[0].function

    @property
    def name(self) -> str:
        return " and ".join(task.name for task in self.tasks)

    def made(self, source: str = "") -> Callable:
        """The function, or another of that name, among the definitions of its notebook."""
        space = dict(_definitions(self.exercise))
        exec(compile(source or self.source, f"<{self.function}>", "exec"), space)
        return space[self.function]


@cache
def solutions() -> tuple[Solution, ...]:
    """Every function that a task asks for, once."""
    found = []
    for exercise in EXERCISES.values():
        for function in dict.fromkeys(task.function for task in exercise.tasks):
            (source,) = [
                ast.unparse(node)
                for node in _statements(exercise.name)
                if isinstance(node, ast.FunctionDef) and node.name == function
            ]
            tasks = tuple(task for task in exercise.tasks if task.function == function)
            found.append(Solution(exercise.name, source, tasks))
    return tuple(found)


def solution(task: str) -> Solution:
    (found,) = [s for s in solutions() if task in [t.name for t in s.tasks]]
    return found


@cache
def _statements(exercise: str) -> tuple[ast.stmt, ...]:
    cells = [cell.source for cell in jupytext.read(FOLDER / f"{exercise}.md").cells if cell.cell_type == "code"]
    return tuple(statement for cell in cells for statement in ast.parse(cell).body)


@cache
def _definitions(exercise: str) -> dict:
    """Imports, functions, classes and constants; neither trials nor figures."""
    space: dict = {}
    for statement in _statements(exercise):
        match statement:
            case ast.Import() | ast.ImportFrom() | ast.FunctionDef() | ast.ClassDef():
                wanted = True
            case ast.Assign(targets=[ast.Name(name)]):
                wanted = name.isupper()
            case _:
                wanted = False
        if wanted:
            exec(compile(ast.Module([statement], []), f"<{exercise}>", "exec"), space)
    return space
