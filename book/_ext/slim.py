"""Make the figures of the built pages small: Matplotlib writes an SVG with a date, comments and six decimals."""

import re
from pathlib import Path

from sphinx.application import Sphinx


def slim(svg: str) -> str:
    """The same picture: no remarks, no names of groups, no needless space, and no more than thousandths of a point."""
    svg = re.sub(r"<!--.*?-->|<metadata>.*?</metadata>|<!DOCTYPE.*?>", "", svg, flags=re.DOTALL)
    svg = re.sub(r"\d+\.\d{4,}", lambda number: f"{float(number[0]):.3f}".rstrip("0").rstrip("."), svg)
    svg = re.sub(r'(?<=<g) id="[^"]*"', "", svg)  # nothing refers to a group
    svg = re.sub(r'(?<= d=")[^"]*', lambda path: re.sub(r"\s*([A-Za-z])\s*", r"\1", path[0]), svg)
    svg = re.sub(r'(?<=style=")[^"]*', lambda style: re.sub(r"([:;])\s+", r"\1", style[0]), svg)
    return re.sub(r"\s+", " ", re.sub(r">\s+<", "><", svg)).strip() + "\n"


def slim_all(app: Sphinx, error: Exception | None) -> None:
    for path in Path(app.outdir, "_images").glob("*.svg"):
        text = path.read_text(encoding="utf-8")
        if "Matplotlib" in text:  # once: what is slim says so no more
            path.write_text(slim(text), encoding="utf-8", newline="\n")


def setup(app: Sphinx) -> dict:
    app.connect("build-finished", slim_all)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
