"""Three questions on Newton-Raphson, twice: as an exercise of ours and as an assignment of nbgrader's.

Run as a program it is the `autograder` command of a course that has this exercise: the package is not changed.
"""

import json
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from autograder.checks import EXERCISES, e01_newton_1d
from autograder.cli import main
from autograder.notebook import check
from autograder.spec import Exercise

NAME = "newton"
TASKS = {task.name: task for task in (e01_newton_1d.BRACKETS, e01_newton_1d.NEWTON_1D, e01_newton_1d.ORDER)}
EXERCISE: Exercise = replace(e01_newton_1d.EXERCISE, name=NAME, tasks=tuple(TASKS.values()))
SOLUTION = Path(__file__).parents[2] / "solutions" / "01_newton_1d.ipynb"
BEGIN, END, IMPORT = "### BEGIN SOLUTION", "### END SOLUTION", f"\n\nfrom {check.__module__} import check"

# The cell of a check in ours is a cell of tests in theirs.
TESTS = {
    "brackets": """
np.testing.assert_allclose(brackets(lambda x: x**2 - 2, 0, 3, 6), [[1.0, 1.5]])
### BEGIN HIDDEN TESTS
asked = []
def f(x):
    asked.append(np.size(x))
    return (x - 0.31) * (x - 0.52) * (x - 2.9)
grid = np.linspace(0, 3, 21)
expected = [(l, r) for l, r in zip(grid[:-1], grid[1:]) if f(l) * f(r) < 0]
asked.clear()
np.testing.assert_allclose(brackets(f, 0, 3, 20), expected)
assert sum(asked) <= 21
assert len(brackets(lambda x: np.cosh(x), -1, 1, 10)) == 0
for a, b, n in ((1, 0, 5), (0, 1, 0)):
    try:
        brackets(f, a, b, n)
    except ValueError:
        pass
    else:
        raise AssertionError("no ValueError")
### END HIDDEN TESTS
""",
    "newton_1d": """
history = newton_1d(lambda x: x**2 - 2, lambda x: 2 * x, 3.0)
assert history[0] == 3.0
np.testing.assert_allclose(history[-1], np.sqrt(2), rtol=1e-9)
### BEGIN HIDDEN TESTS
for scale in (1e3, 1e-3):
    for error in ("absolute", "relative"):
        tol = 1e-6
        f, df = lambda x: (x / scale) ** 3 - 8, lambda x: 3 * (x / scale) ** 2 / scale
        x = np.asarray(newton_1d(f, df, 2.5 * scale, tol, error))
        np.testing.assert_allclose(x[1:], x[:-1] - f(x[:-1]) / df(x[:-1]), rtol=1e-8)
        size = np.abs(np.diff(x)) / (np.abs(x[1:]) if error == "relative" else 1)
        assert size[-1] < tol
        assert (size[:-1] >= tol).all()
### END HIDDEN TESTS
""",
    "order": """
np.testing.assert_allclose(order(1 + 0.1 * 0.5 ** np.arange(8)), 1, rtol=1e-6)
### BEGIN HIDDEN TESTS
quadratic = 1.0 + np.array([1e-1, 1e-2, 1e-4, 1e-8, 0, 0])
s = np.abs(np.diff(quadratic))[:4]
np.testing.assert_allclose(order(quadratic), np.log(s[3] / s[2]) / np.log(s[2] / s[1]), rtol=1e-6)
assert np.isnan(order([2.0, 1.5]))
assert np.isnan(order(np.full(5, 3.0)))
### END HIDDEN TESTS
""",
}


@dataclass(frozen=True)
class Cell:
    """A code cell of the solution; `role` is given, solution, or test."""

    role: str
    name: str
    source: str


@dataclass(frozen=True)
class Answer:
    """How somebody answered: edits of the solution as (old, new) text; None leaves everything untouched."""

    name: str
    edits: tuple[tuple[str, str], ...] | None
    right: bool = False


LOOP = """found = []
    for left, right in zip(x[:-1], x[1:]):
        if y[list(x).index(left)] * y[list(x).index(right)] < 0:
            found.append((left, right))
    return found"""
WHOLE_GRID = ("y = np.array([f(point) for point in x])", "y = f(x) + 0 * x")

ANSWERS = (
    Answer("right", (), right=True),
    Answer("right, a loop", (("return np.column_stack((x[:-1], x[1:]))[change]", LOOP),), right=True),
    Answer("right, the whole grid at once", (WHOLE_GRID,), right=True),
    Answer("right, a list of iterates", (("return np.array(history)", "return history"),), right=True),
    Answer("n points for n subintervals", (("np.linspace(a, b, n + 1)", "np.linspace(a, b, n)"),)),
    Answer("only the ends are compared", (("np.linspace(a, b, n + 1)", "np.linspace(a, b, 2)"),)),
    Answer("the other sign", (("x = x - step", "x = x + step"),)),
    Answer("the slope of the seed", (("slope = df(x)", "slope = df(float(seed))"),)),
    Answer("absolute, whatever is asked", (('abs(step) / abs(x) if error == "relative" else abs(step)', "abs(step)"),)),
    Answer("the first three steps", (("steps[-3:]", "steps[:3]"),)),
    Answer("it raises", (("change = y[:-1] * y[1:] < 0", "change = y[:-1] * z[1:] < 0"),)),
    Answer("untouched", None),
)


@cache
def cells() -> tuple[Cell, ...]:
    """The code cells of the solution, but for the check of the task that is left out."""
    found = []
    for cell in json.loads(SOLUTION.read_text("utf-8"))["cells"]:
        source = "".join(cell["source"])
        if cell["cell_type"] != "code":
            continue
        if source.startswith("check("):
            name = source.split('"')[1]
            if name in TASKS:
                found.append(Cell("test", name, source))
        else:
            found.append(Cell("solution" if BEGIN in source else "given", f"cell-{len(found)}", source))
    return tuple(found)


def answered(answer: Answer) -> dict[str, str] | None:
    """The source of each solution cell by name; None if nothing was written.

    Raises
    ------
    ValueError
        If an edit finds nothing to change.
    """
    if answer.edits is None:
        return None
    sources = {cell.name: without_markers(cell.source) for cell in cells() if cell.role == "solution"}
    for old, new in answer.edits:
        if not any(old in source for source in sources.values()):
            raise ValueError(f"no cell of the solution holds {old!r} any more: mend ANSWERS")
        sources = {name: source.replace(old, new) for name, source in sources.items()}
    return sources


def without_markers(source: str) -> str:
    return "\n".join(line for line in source.splitlines() if line.strip() not in (BEGIN, END))


def without_solution(source: str) -> str:
    before = source.partition(BEGIN)[0]
    return before + ("raise NotImplementedError" if before.endswith(" ") else "")


def ours(answer: Answer) -> str:
    """A submission as a notebook of ours."""
    written = answered(answer)
    sources = [
        written[cell.name] if written and cell.role == "solution" else without_solution(cell.source) for cell in cells()
    ]
    return _notebook([_code(f"cell-{n}", source) for n, source in enumerate(sources)], mechanisms={"exercise": NAME})


def theirs_source() -> str:
    """The assignment as nbgrader's instructor writes it."""
    made = []
    for cell in cells():
        test, solution = cell.role == "test", cell.role == "solution"
        marks = {"grade": test, "solution": solution, "locked": not solution, "task": False, "schema_version": 3}
        marks |= {"grade_id": f"test-{cell.name}" if test else cell.name, "cell_type": "code"}
        marks |= {"points": TASKS[cell.name].points} if test else {}
        source = TESTS[cell.name].strip() if test else cell.source.replace(IMPORT, "")
        made.append(_code(marks["grade_id"], source, nbgrader=marks))
    return _notebook(made)


def theirs(answer: Answer, released: str) -> str:
    """A submission as a notebook of nbgrader's, written into what it hands out."""
    notebook, written = json.loads(released), answered(answer) or {}
    for cell in notebook["cells"]:
        name = cell["metadata"].get("nbgrader", {}).get("grade_id")
        if name in written:
            cell["source"] = written[name]
    return json.dumps(notebook)


def _code(name: str, source: str, **metadata) -> dict:
    return {
        "cell_type": "code",
        "id": name,
        "metadata": metadata,
        "source": source,
        "outputs": [],
        "execution_count": None,
    }


def _notebook(made: list[dict], **metadata) -> str:
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    metadata = {"kernelspec": kernel, "language_info": {"name": "python"}} | metadata
    return json.dumps({"cells": made, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5})


if __name__ == "__main__":
    EXERCISES[NAME] = EXERCISE
    main()
