"""What is odd about a notebook, seen without running it: one sentence each, which names the cell."""

import ast
import builtins
import re
import symtable
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property

from autograder.worker.gaps import is_gap

PYTHON_MAGICS = ("%%time", "%%timeit", "%%capture", "%%prun")
UNSEEN = re.compile(r"import \*|^[ \t]*%(?:pylab|run|load)\b", re.MULTILINE)  # names that no look at the cell tells
COLAB = re.compile(r"^[ \t]*(?:from|import)[ \t]+google\.colab\b", re.MULTILINE)
THERE = {*dir(builtins), "In", "Out", "display", "get_ipython", "exit", "quit"}
ALIKE = 0.8
MOST = 100_000  # characters; what takes longer to look at than to grade is nobody's answer


@dataclass(frozen=True)
class Text:
    """A cell that holds no code: its number among all cells, its kind, its text."""

    number: int
    kind: str
    source: str


@dataclass(frozen=True)
class Cell:
    """A code cell, read and not run.

    Parameters
    ----------
    number : int
        Among the code cells, from 1.
    source : str
    """

    number: int
    source: str

    @cached_property
    def _read(self) -> tuple[str | None, ast.Module]:
        magic, _, below = self.source.partition("\n")
        plain = self.source
        if magic.startswith("%%"):
            plain = f"pass\n{below}" if magic.split()[0] in PYTHON_MAGICS else ""
        for text in (plain, "\n".join(map(_without_magic, plain.split("\n")))):
            try:
                with warnings.catch_warnings(action="ignore"):
                    return text, ast.parse(text)
            except (SyntaxError, ValueError, RecursionError, MemoryError):
                continue
        return None, ast.Module([], [])

    @property
    def python(self) -> str | None:
        """Its text without the magics; None if that is not Python."""
        return self._read[0]

    @property
    def tree(self) -> ast.Module:
        return self._read[1]

    @cached_property
    def defines(self) -> dict[str, int]:
        """How often it defines each name at its margin, gaps left out."""
        functions = [s for s in _statements(self.tree.body) if isinstance(s, ast.FunctionDef | ast.AsyncFunctionDef)]
        written = [function.name for function in functions if not is_gap(function)]
        gaps = {function.name for function in functions} - set(written)
        return {name: max(written.count(name), 1) for name in sorted(self.names[0] - gaps)}

    @cached_property
    def names(self) -> tuple[set[str], set[str]]:
        """The names that it binds, and those that it uses without having bound them, both outside of functions."""
        try:
            with warnings.catch_warnings(action="ignore"):
                symbols = symtable.symtable(self.python or "", "cell", "exec").get_symbols()
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            return set(), set()
        bound = {s.get_name() for s in symbols if s.is_assigned() or s.is_imported()}
        return bound, {s.get_name() for s in symbols if s.is_referenced()} - bound

    def hides(self, name: str) -> bool:
        """Whether a function of this name is defined inside of something else."""
        return any(isinstance(node, ast.FunctionDef) and node.name == name for node in ast.walk(self.tree))


def _without_magic(line: str) -> str:
    """A line of Python, or a line of as little as possible in place of one that only IPython reads."""
    code = line.strip()
    asks = code.endswith("?") and not set(code) & set("#'\"")
    magic = code.startswith(("%", "!", "?")) or code.partition("=")[2].lstrip().startswith(("%", "!"))
    return f"{line[: len(line) - len(line.lstrip())]}pass" if asks or magic else line


def _statements(body: Sequence[ast.stmt]) -> Iterator[ast.stmt]:
    """All statements that run when the cell runs, those of its ifs, loops and withs included."""
    for statement in body:
        yield statement
        if not isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            for block in ("body", "orelse", "finalbody"):
                yield from _statements(getattr(statement, block, []))
            for handler in getattr(statement, "handlers", []):
                yield from _statements(handler.body)


def look(cells: Sequence[str], texts: Sequence[Text], functions: Sequence[str]) -> tuple[str, ...]:
    """What a reader of the feedback should know of these cells.

    Parameters
    ----------
    cells : sequence of str
        The code cells, in order.
    texts : sequence of Text
        The other cells.
    functions : sequence of str
        The functions that the exercise asks for.

    Returns
    -------
    tuple of str
        Sentences without a capital and a full stop.
    """
    if sum(map(len, cells)) > MOST:
        return (f"the notebook holds more than {MOST} characters of code, and was not looked at for oddities",)
    read = [Cell(number, source) for number, source in enumerate(cells, 1)]
    found = [note for name in dict.fromkeys(functions) for note in _of_function(name, read, texts, functions)]
    found += _out_of_order(read)
    found += [
        f"code cell {c.number} imports google.colab, which only Colab has" for c in read if COLAB.search(c.source)
    ]
    return tuple(found)


def answers(cells: Sequence[str], functions: Sequence[str]) -> int:
    """How many of the functions the cells define, written or as gaps."""
    text = "\n".join(cells)
    return sum(_def(name).search(text) is not None for name in set(functions))


def _def(name: str) -> re.Pattern:
    return re.compile(rf"^[ \t]*(?:async )?def {name}\b", re.MULTILINE)


def _of_function(name: str, read: list[Cell], texts: Sequence[Text], functions: Sequence[str]) -> Iterator[str]:
    there = [cell for cell in read if name in cell.defines]
    if len(there) > 1 or any(cell.defines[name] > 1 for cell in there):
        yield f"{name} is defined more than once, in {_cells(there)}: the last one that runs counts"
    if there or any(cell.python is None and _def(name).search(cell.source) for cell in read):
        return  # what is not Python is told by the error that it stops with
    inside = [cell for cell in read if cell.hides(name) and name not in cell.names[0]]
    if inside:
        yield f"{_cells(inside)} defines {name} inside of something else: move it to the margin"
    for text in texts:
        if _def(name).search(text.source):
            yield f"cell {text.number} is {text.kind} and holds def {name}: make it a code cell"
    near = {_plain(other): (other, cell) for cell in read for other in _functions(cell) if other not in functions}
    for alike in get_close_matches(_plain(name), near, 1, ALIKE):
        other, cell = near[alike]
        yield f"no cell defines {name}, but code cell {cell.number} defines {other}: is that it?"


def _functions(cell: Cell) -> list[str]:
    return [s.name for s in _statements(cell.tree.body) if isinstance(s, ast.FunctionDef) and s.name in cell.defines]


def _plain(name: str) -> str:
    return name.replace("_", "").casefold()


def _out_of_order(read: list[Cell]) -> Iterator[str]:
    """A cell that uses what only a later one gives it."""
    known = set(THERE)
    givers: dict[str, list[int]] = {}
    for cell in read:
        for name in cell.names[0]:
            givers.setdefault(name, []).append(cell.number)
    for cell in read:
        if UNSEEN.search(cell.source):
            return
        bound, used = cell.names
        late: dict[int, list[str]] = {}
        for name in sorted(used & givers.keys() - known):
            if not name.startswith("_"):
                late.setdefault(givers[name][0], []).append(name)
        for number, names in sorted(late.items()):
            yield (
                f"code cell {cell.number} uses {_list(names)}, which only code cell {number} defines: "
                "cells run from top to bottom"
            )
        known |= bound


def _cells(cells: Sequence[Cell]) -> str:
    return f"code cell{'s' if len(cells) > 1 else ''} {_list([str(cell.number) for cell in cells])}"


def _list(words: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))
