"""What the chapters draw: figures that stay readable on a phone and on a dark page, and tables in Markdown."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import cycle

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike

BLUE, RED, GREEN, PURPLE, GREY = "#0061a8", "#c2410c", "#047857", "#86198f", "#57606a"

STYLE = {
    "figure.figsize": (4.6, 3.2),  # inches; shrunk to a phone's 320 pixels, the text is still 9 points high
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "figure.constrained_layout.use": True,
    "font.size": 12.5,
    "axes.labelsize": 12.5,
    "legend.fontsize": 12.5,
    "legend.frameon": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#d8dee4",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.prop_cycle": plt.cycler(color=[BLUE, RED, GREEN, PURPLE]),
    "lines.linewidth": 2.0,
    "lines.markersize": 5.0,
    "svg.hashsalt": "mechlib",  # the same figure is the same file
}


def tangents(
    f: Callable[[np.ndarray], ArrayLike],
    df: Callable[[float], float],
    seed: float,
    steps: int,
    window: tuple[float, float],
    ax: Axes | None = None,
) -> Figure:
    """The tangent construction: from the curve along its tangent to the axis, and up to the curve again.

    Parameters
    ----------
    f, df : callable
        The function, of an array, and its derivative, of a number.
    seed : float
        Where the first tangent touches.
    steps : int
        Number of tangents; fewer are drawn where one of them is horizontal.
    window : (float, float)
        Ends of the axis that is shown.
    ax : Axes, optional
        Where to draw; a new figure if none is given.

    Returns
    -------
    Figure
    """
    ax = plt.subplots()[1] if ax is None else ax
    grid = np.linspace(*window, 500)
    ax.plot(grid, f(grid), color=BLUE)
    ax.axhline(0, color="black", linewidth=1)
    ax.set(xlim=window, xlabel="$x$", ylabel="$f(x)$")
    ax.set_autoscale_on(False)

    x = float(seed)
    for n in range(steps + 1):
        y = float(f(x))
        ax.plot([x, x], [0, y], color=GREY, linestyle=":")
        ax.plot(x, y, "o", color=BLUE)
        if window[0] <= x <= window[1]:
            ax.annotate(
                f"$x_{{{n}}}$", (x, 0), (0, -5 if y >= 0 else 5), textcoords="offset points", ha="center",
                va="top" if y >= 0 else "bottom",
            )  # fmt: skip
        if n == steps or df(x) == 0:
            break
        foot = x - y / df(x)
        ax.plot([x, foot], [y, 0], color=RED, linewidth=1.5)
        x = foot
    return ax.figure


def convergence(errors: Mapping[str, ArrayLike], ylabel: str, ax: Axes | None = None) -> Figure:
    """Errors against iterations on a logarithmic scale: order 1 is a straight line, a higher order falls ever faster.

    Parameters
    ----------
    errors : mapping of label to array_like, shape (iterations,)
        An error that is zero or nan has no place on the scale and is left out.
    ylabel : str
    ax : Axes, optional
        Where to draw; a new figure if none is given.

    Returns
    -------
    Figure
    """
    ax = plt.subplots()[1] if ax is None else ax
    for (label, sizes), marker in zip(errors.items(), "os^Dv", strict=False):
        sizes = np.asarray(sizes, dtype=float)
        n = np.flatnonzero(sizes > 0)
        ax.semilogy(n, sizes[n], marker=marker, label=label)
    ax.set(xlabel="iteration", ylabel=ylabel)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.legend()
    return ax.figure


def panels(x: ArrayLike, curves: Mapping[str, ArrayLike], xlabel: str, colors: Sequence[str] = (BLUE,)) -> Figure:
    """Several quantities over one axis, a panel each, one below the other.

    Parameters
    ----------
    x : array_like, shape (points,)
    curves : mapping of label to array_like, shape (points,)
        The labels are written above the panels: symbol and unit.
    xlabel : str
    colors : sequence of str
        Of the curves in turn, over and over.

    Returns
    -------
    Figure
    """
    width = STYLE["figure.figsize"][0]
    fig, axes = plt.subplots(len(curves), sharex=True, squeeze=False, figsize=(width, 0.6 + 1.5 * len(curves)))
    for ax, (label, values), color in zip(axes[:, 0], curves.items(), cycle(colors), strict=False):
        ax.plot(x, values, color=color)
        ax.set_title(label, loc="left", fontsize=STYLE["font.size"])
        ax.margins(x=0)
    axes[-1, 0].set_xlabel(xlabel)
    return fig


def bound(size: float) -> str:
    """A power of ten that is not reached: of a round-off, which another computer would change."""
    return f"< 1e{int(np.floor(np.log10(size))) + 1}"


def verdict(printed: str, computed: float) -> str:
    """Whether a number agrees with a printed one: rounded to as many decimals, it has the same digits.

    Parameters
    ----------
    printed : str
        As it stands in the source, with a decimal point.
    computed : float

    Returns
    -------
    str
        In Markdown.
    """
    decimals = len(printed.partition(".")[2])
    rounded = round(float(computed), decimals) + 0.0  # no minus zero
    return "agrees, every digit" if f"{rounded:.{decimals}f}" == printed else "**differs**"


def table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A Markdown table.

    Parameters
    ----------
    header : sequence of str
    rows : iterable of sequences
        One cell for each title of the header.

    Returns
    -------
    str

    Raises
    ------
    ValueError
        If a row has more or fewer cells than the header.
    """
    lines = [header, ["---"] * len(header), *rows]
    for row in lines:
        if len(row) != len(header):
            raise ValueError(f"a row needs {len(header)} cells, got {len(row)}: {row}")
    return "\n".join("| " + " | ".join(str(cell).replace("|", r"\|") for cell in row) + " |" for row in lines)
