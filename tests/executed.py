"""The cells of a chapter, executed: what they define and the tables that they print."""

import re
from pathlib import Path

import IPython.display
import matplotlib.pyplot as plt
import pytest

BOOK = Path(__file__).parents[1] / "book"


def executed(page: str) -> dict:
    """What the cells of a page define, and under "tables" and "said" what they print.

    Cells that serve the built page only are left out: numbers for its sentences, and what its exercise asks.
    """
    names, tables, said = {}, [], []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(IPython.display, "Markdown", tables.append)
        patch.chdir(BOOK)
        patch.setattr(plt, "show", lambda: plt.close("all"))
        patch.setattr("builtins.print", lambda *words: said.append(" ".join(map(str, words))))
        for cell in re.findall(r"```\{code-cell\} ipython3\n(.*?)```", (BOOK / f"{page}.md").read_text("utf-8"), re.S):
            code = re.sub(r"\A(---\n.*?\n---\n|:tags:.*\n)", "", cell, flags=re.S if cell.startswith("---") else 0)
            if "import glue" not in code and "task_table" not in code:
                exec(re.sub(r"^%.*$", "", code, flags=re.M), names)
    return names | {"tables": tables, "said": said}


def rows(chapter: dict, first: str) -> list[list[str]]:
    """The cells of the table whose first title is this."""
    (table,) = (t for t in chapter["tables"] if t.startswith(f"| {first} |"))
    return [[cell.strip() for cell in line.strip("|").split(" | ")] for line in table.splitlines()[2:]]
