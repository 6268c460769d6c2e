"""The same names in book and mechlib: the page on notation is looked up, row by row."""

import importlib
import inspect
import re
from dataclasses import fields, is_dataclass
from pathlib import Path

import pytest
import sympy as sp

from mechlib.cylinder import Cylinder
from mechlib.fourbar import FourBar
from mechlib.hacksaw import Hacksaw
from mechlib.wiper import Wiper

BOOK = Path(__file__).parents[1] / "book"


def code(page: str) -> str:
    text = (BOOK / f"{page}.md").read_text("utf-8")
    cells = re.findall(r"```\{code-cell\} ipython3\n(?::tags:[^\n]*\n)?(.*?)```", text, re.DOTALL)
    return "\n".join(cells)


@pytest.fixture(scope="module")
def page():
    """What the cells of the page define."""
    names: dict = {}
    exec(compile(code("notation"), "notation.md", "exec"), names)
    return names


def looked_up(name: str):
    """What a name of the page is in mechlib.

    Raises
    ------
    LookupError
        If there is no such module, attribute, field or argument.
    """
    path, _, arguments = name.rstrip(")").partition("(")
    module, _, rest = path.partition(".")
    found = importlib.import_module(f"mechlib.{module}")
    for part, index in re.findall(r"(\w+)(?:\[(\d+)\])?", rest):
        if hasattr(found, part):
            found = getattr(found, part)
        elif is_dataclass(found) and part in {field.name for field in fields(found)}:
            return None  # a field without a default: it exists, and has no value yet
        else:
            raise LookupError(f"{name}: {found!r} has no {part}")
        found = found[int(index)] if index else found
    for argument in filter(None, arguments.split(", ")):
        if argument not in inspect.signature(found).parameters:
            raise LookupError(f"{name}: {found!r} takes no {argument}")
    return found


@pytest.mark.parametrize(
    "name", ["hacksaw.Hacksaw.r4", "hacksaw.Hacksaw.gap(theta1)", "closure.Closure.inputs", "motion.Motion.time"]
)
def test_a_name_that_is_not_there_would_be_seen(name):
    with pytest.raises(LookupError):
        looked_up(name)


def test_every_mechlib_name_of_the_page_exists(page):
    names = [
        *(row[-1] for row in page["shared"] if row[-1]),
        *(f"hacksaw.Hacksaw.{row[-1]}" for row in page["hacksaw"]),
        *(f"wiper.Wiper.{row[-1]}" for row in page["wiper"]),
        *(f"cylinder.Cylinder.{row[-1]}" for row in page["cylinder"] if row[-1]),
        *(f"fourbar.FourBar.{row[-1]}" for row in page["fourbar"] if row[-1]),
    ]
    assert len(names) > 30
    for name in names:
        looked_up(name)


def test_every_parameter_and_coordinate_of_the_hacksaw_is_in_the_table_under_its_own_symbol(page):
    closure = Hacksaw.closure
    rows = {row[0]: row[-1] for row in page["hacksaw"]}
    for symbol in closure.parameters:
        name = rows.pop(f"${sp.latex(symbol)}$")
        assert name == str(symbol).replace("_", "")
        assert isinstance(looked_up(f"hacksaw.Hacksaw.{name}"), float)
    for coordinate in (*closure.unknowns, closure.input):
        for symbol in coordinate:
            assert looked_up(f"hacksaw.Hacksaw.{rows.pop(f'${sp.latex(symbol)}$')}") == symbol
    assert list(rows) == ["$O$, $A$, $B$", "left, right"]


def test_the_units_of_the_hacksaw_follow_from_its_equations(page):
    """What stands in a sine is an angle; the other coordinate is a length, as the parameters are."""
    closure = Hacksaw.closure
    functions = closure.position_equations.atoms(sp.cos, sp.sin)
    angles = set().union(*(f.free_symbols for f in functions))
    units = {row[0]: row[2] for row in page["hacksaw"]}
    for coordinate in (*closure.unknowns, closure.input):
        unit = "rad" if coordinate.position in angles else "m"
        assert [units[f"${sp.latex(symbol)}$"] for symbol in coordinate] == [unit, f"{unit}/s", f"{unit}/s²"]
    assert {units[f"${sp.latex(symbol)}$"] for symbol in closure.parameters} == {"m"}


def test_every_symbol_of_the_page_has_one_meaning_within_its_table(page):
    for table in ("shared", "hacksaw", "wiper", "cylinder", "fourbar"):
        symbols = [row[0] for row in page[table]]
        assert len(set(symbols)) == len(symbols)


def test_every_length_of_the_wiper_is_in_the_table_under_its_own_symbol(page):
    rows = {row[0]: row[-1] for row in page["wiper"]}
    for k, symbol in enumerate(Wiper.parameters[:7]):
        assert rows[f"${sp.latex(symbol).replace('{', '').replace('}', '')}$"] == f"r{k}"


@pytest.mark.parametrize("machine", [Wiper, Cylinder, FourBar])
def test_every_coordinate_is_in_the_table_under_its_own_symbol_and_in_its_unit(page, machine):
    name = machine.__name__
    rows = {row[0]: row[2:] for row in page[name.lower()]}
    angles = dict(zip(machine.closure.unknowns, machine.closure.angles, strict=True)) | {
        Wiper.closure.input: True,
        FourBar.closure.input: True,
    }
    for coordinate in (*machine.closure.unknowns, machine.closure.input):
        unit = "rad" if angles.get(coordinate) else "m"
        for symbol, per in zip(coordinate, ("", "/s", "/s²"), strict=True):
            told, place = rows[f"${sp.latex(symbol)}$"]
            assert told == unit + per
            assert looked_up(f"{name.lower()}.{name}.{place}") == symbol


def test_every_parameter_of_the_cylinder_has_a_row_that_names_it(page):
    named = {symbol.strip("$") for row in page["cylinder"] for symbol in row[0].split(", ")}
    assert {sp.latex(symbol).replace("{", "").replace("}", "") for symbol in Cylinder.parameters} <= named


def test_every_length_of_the_four_bar_is_in_the_table_under_its_own_symbol(page):
    rows = {row[0]: row[-1] for row in page["fourbar"]}
    for symbol, constant in zip(FourBar.parameters, FourBar().constants, strict=True):
        assert looked_up(f"fourbar.FourBar.{rows[f'${sp.latex(symbol)}$']}") == constant
