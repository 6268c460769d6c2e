"""Whether two answers agree, and what is said when they do not."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from autograder.compare import Tolerance, difference, disagreement
from autograder.outcome import Lost, Raised, Value

NEAR = Tolerance(1e-6, "six digits are asked for")
FLOATS = arrays(float, (3,), elements=st.floats(-1e6, 1e6).filter(lambda x: abs(x) > 1e-3))


@given(FLOATS)
def test_an_answer_agrees_with_itself_in_any_container(right):
    assert difference(right, right, NEAR) is None
    assert difference(right, right.tolist(), NEAR) is None
    assert difference(right, tuple(right), NEAR) is None


@given(FLOATS, st.integers(0, 2), st.floats(2e-6, 0.4))
def test_an_entry_that_is_off_by_more_than_the_tolerance_of_the_scale_is_named(right, index, off):
    answer = right.copy()
    answer[index] += off * np.abs(right).max()
    said = difference(right, answer, NEAR)
    assert said is not None
    assert f"index {index}" in said or said in (
        "twice too large",
        "half of what it should be",
        "the sign is turned round",
    )


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        (None, "is a return missing?"),
        ("1, 2, 3", "a str"),
        ({"x": 1}, "a dict"),
        ([1, [2, 3]], "rows have different lengths"),
        ([1j, 2, 3], "not an array of real numbers"),
        ([1.0, 2.0], "its shape is (2,), and not (3,)"),
        ([1.0, np.nan, 3.0], "not a number at index 1"),
        ([1.0, np.inf, 3.0], "index 1"),
        ([-1.0, -2.0, -3.0], "the sign is turned round"),
        (np.degrees([1.0, 2.0, 3.0]), "degrees where radians are asked for?"),
        ([2.0, 4.0, 6.0], "twice too large"),
    ],
)
def test_what_is_wrong_is_said_in_words(answer, says):
    assert says in difference([1.0, 2.0, 3.0], answer, NEAR)


@given(FLOATS, FLOATS)
def test_no_number_of_the_right_answer_is_given_away(right, answer):
    said = difference(right, answer, NEAR) or ""
    assert not any(f"{abs(x):.6g}" in said for x in right if abs(x) != round(abs(x)))


def test_nan_is_right_where_nan_is_expected_and_nowhere_else():
    assert difference(np.nan, np.nan, NEAR) is None
    assert "where nan is right" in difference(np.nan, 1.0, NEAR)
    assert "not a number" in difference(1.0, np.nan, NEAR)


def test_nothing_is_nothing_in_whatever_container():
    assert difference(np.empty((0, 2)), [], NEAR) is None
    assert difference(np.empty((0, 2)), [[1.0, 2.0]], NEAR) is not None


def test_an_exception_is_judged_by_its_family():
    expected = Raised("ArithmeticError", ("Exception",), "")
    assert disagreement(expected, Raised("ConvergenceError", ("ArithmeticError", "Exception"), "x"), NEAR) is None
    assert "KeyError" in disagreement(expected, Raised("KeyError", ("LookupError",), "x"), NEAR)
    assert "returned a value" in disagreement(expected, Value(1.0), NEAR)
    assert "raised KeyError" in disagreement(Value(1.0), Raised("KeyError", (), "x"), NEAR)
    assert disagreement(Value(1.0), Lost("no answer within 1 s"), NEAR) == "no answer within 1 s"
