"""Where the errors of iterates lie on a drawing with a logarithmic scale.

Every wrong iteration of a cohort gets such a drawing, in the colours of the page that it stands on; a plotting library
takes longer for one than the grader for a submission.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, floor, log10

FRAME = LEFT, RIGHT, TOP, BOTTOM = 50, 350, 32, 190
MOST_TICKS = 6

Point = tuple[float, float]


@dataclass(frozen=True)
class Decay:
    """What a drawing shows: curves as points of it, ticks as (place, number).

    Attributes
    ----------
    iterations, decades : ticks of the axes; a decade is the power of ten.
    frame : left, right, top, bottom.
    """

    curves: tuple[tuple[Point, ...], ...]
    iterations: tuple[tuple[float, int], ...]
    decades: tuple[tuple[float, int], ...]
    frame: tuple[int, int, int, int] = FRAME


def decay(curves: Sequence[Sequence[float]]) -> Decay:
    """Lay out errors against iterations.

    Parameters
    ----------
    curves : sequence of the errors of iterates, of which one at least is not 0
        An error of 0 has no place on the scale and is left out.
    """
    exponents = [log10(error) for errors in curves for error in errors if error > 0]
    low, high = floor(min(exponents)), ceil(max(exponents))
    high = max(high, low + 1)
    last = max(1, max(map(len, curves)) - 1)

    def x(iteration: int) -> float:
        return round(LEFT + (RIGHT - LEFT) * iteration / last, 1)

    def y(exponent: float) -> float:
        return round(TOP + (BOTTOM - TOP) * (high - exponent) / (high - low), 1)

    return Decay(
        tuple(tuple((x(n), y(log10(error))) for n, error in enumerate(errors) if error > 0) for errors in curves),
        tuple((x(n), n) for n in _ticks(0, last)),
        tuple((y(n), n) for n in _ticks(low, high)),
    )


def _ticks(first: int, last: int) -> range:
    return range(first, last + 1, ceil((last - first + 1) / MOST_TICKS))
