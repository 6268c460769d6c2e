"""The drawing of errors against iterations."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from autograder.decay import FRAME, MOST_TICKS, decay

LEFT, RIGHT, TOP, BOTTOM = FRAME
ERRORS = st.lists(st.one_of(st.just(0.0), st.floats(min_value=5e-324, max_value=1e308)), min_size=1, max_size=30)


@given(answer=ERRORS, right=ERRORS, seed=st.floats(min_value=1e-300, max_value=1e300))
def test_whatever_the_errors_are_the_drawing_stays_in_its_frame(answer, right, seed):
    drawn = decay([[seed, *answer], right])
    for curve in drawn.curves:
        assert all(LEFT <= x <= RIGHT and TOP <= y <= BOTTOM for x, y in curve)
    assert all(LEFT <= x <= RIGHT for x, _ in drawn.iterations)
    assert all(TOP <= y <= BOTTOM for y, _ in drawn.decades)
    assert len(drawn.iterations) <= MOST_TICKS
    assert 1 <= len(drawn.decades) <= MOST_TICKS


def test_order_one_is_a_straight_line():
    ((curve, _)) = decay([0.5 ** np.arange(10), [1.0]]).curves
    x, y = np.transpose(curve)
    assert np.polyfit(x, y, 1, full=True)[1] == pytest.approx(0, abs=10 * 0.05**2)  # places are rounded to 0.1


def test_a_tick_stands_where_an_error_of_its_size_would():
    errors = [1e-3, 1e2, 1e-9]
    drawn = decay([errors, errors])
    heights = {power: y for y, power in drawn.decades}
    assert heights[-3] == drawn.curves[0][0][1]
    assert heights[-9] == drawn.curves[0][2][1]


def test_an_error_of_zero_is_left_out_and_the_next_keeps_its_place():
    (curve, _) = decay([[1.0, 0.0, 1e-2], [1.0, 0.1, 0.0]]).curves
    assert [x for x, _ in curve] == [LEFT, RIGHT]
