"""Cramer's rule for one, two or three unknowns: a handful of products, done for all points of a motion at once.

Elimination with pivoting is the better rule for one large system.  Many small ones have no use for it: the choice of
a pivot costs more than the solution, and where they are well conditioned the digits are the same.
"""

from collections.abc import Sequence

import numpy as np

Number = float | np.ndarray


def adjugate(matrix: Sequence[Sequence[Number]]) -> tuple[Number, tuple[tuple[Number, ...], ...]]:
    """Determinant and adjugate: the inverse is the adjugate divided by the determinant, where that is not zero.

    Parameters
    ----------
    matrix : n rows of n entries, n at most 3
        Each entry a number, an array over the points, or an expression.

    Returns
    -------
    determinant : number, array or expression
    adjugate : n rows of n of them

    Raises
    ------
    ValueError
        If there are more than three unknowns.
    """
    match len(matrix):
        case 1:
            ((a,),) = matrix
            return a, ((1.0,),)
        case 2:
            (a, b), (c, d) = matrix
            return a * d - b * c, ((d, -b), (-c, a))
        case 3:
            (a, b, c), (d, e, f), (g, h, i) = matrix
            A, B, C = e * i - f * h, c * h - b * i, b * f - c * e
            D, E, F = f * g - d * i, a * i - c * g, c * d - a * f
            G, H, I = d * h - e * g, b * g - a * h, a * e - b * d
            return a * A + b * D + c * G, ((A, B, C), (D, E, F), (G, H, I))
    raise ValueError(f"Cramer's rule is for one to three unknowns here, got {len(matrix)}")


def times(matrix: Sequence[Sequence[Number]], vector: Sequence[Number]) -> list[Number]:
    """A matrix times a vector, entry by entry."""
    return [sum(a * x for a, x in zip(row[1:], vector[1:], strict=True)) + row[0] * vector[0] for row in matrix]
