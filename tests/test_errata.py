"""What the sources get wrong, proven with exact numbers and without mechlib."""

import numpy as np
import pytest
import sympy as sp

# --- source A, section 4: the run-up of the motor

t, T = sp.symbols("t T", positive=True)
ENDS = (sp.Integer(0), T / 3, 2 * T / 3, T, 2 * T)
EQUATION_3 = (15 * t / T, sp.Integer(5), 15 - 15 * t / T, sp.Integer(0))
EQUATION_4 = (15 * t**2 / (2 * T), 5 * t - 5 * T / 6, 15 * t - 25 * T / 6 - 15 * t**2 / (2 * T), 10 * T / 3)
EQUATION_5 = (
    5 * t**3 / 6,
    5 * T**2 / 6 - 5 * t * (T - 3 * t) / 6,
    5 * T**2 / 6 - 25 * T * t / 6 + 15 * t**2 / (2 * T) - 5 * t**3 / (6 * T),
    10 * T * t / 3 - 5 * T**2 / 3,
)
MENDED = (
    5 * t**3 / (2 * T),
    5 * t**2 / 2 - 5 * T * t / 6 + 5 * T**2 / 54,
    15 * t**2 / 2 - 25 * T * t / 6 - 5 * t**3 / (2 * T) + 5 * T**2 / 6,
    EQUATION_5[3],
)
TURN = sp.sqrt(6 * sp.pi / 5)


def slopes_fit(pieces, derivatives):
    return [sp.expand(f.diff(t) - df) == 0 for f, df in zip(pieces, derivatives, strict=True)]


def jumps(pieces):
    """From zero before the start, and from each piece to the next."""
    before = (sp.Integer(0), *pieces[:-1])
    return [sp.expand((f - g).subs(t, end)) for f, g, end in zip(pieces, before, ENDS[:-1], strict=True)]


def deviations(k):
    """Printed minus mended on piece k of equation (5), at the T of the source."""
    instants = np.linspace(*(float(end.subs(T, TURN)) for end in ENDS[k : k + 2]), 100_001)
    return sp.lambdify(t, (EQUATION_5[k] - MENDED[k]).subs(T, TURN))(instants)


def test_equations_3_and_4_of_source_a_are_right():
    assert slopes_fit(EQUATION_4, EQUATION_3) == [True] * 4
    assert jumps(EQUATION_4) == [0] * 4
    assert jumps(EQUATION_3) == [0] * 4
    assert EQUATION_3[1] == 5


def test_equation_5_of_source_a_once_mended_fits_its_speed_and_makes_one_turn():
    assert slopes_fit(MENDED, EQUATION_4) == [True] * 4
    assert jumps(MENDED) == [0] * 4
    assert MENDED[2].subs(t, T).subs(T, TURN) - 2 * sp.pi == 0
    assert sp.expand(MENDED[3].subs(t, 2 * T).subs(T, TURN)) == 6 * sp.pi
    assert f"{float(TURN):.3f}" == "1.942"


def test_a1_the_first_piece_has_another_derivative_and_is_off_by_0_123_rad():
    assert not slopes_fit(EQUATION_5, EQUATION_4)[0]
    off = np.abs(deviations(0))
    assert off.argmax() == len(off) - 1
    assert f"{off.max():.3f}" == "0.123"


def test_a2_the_second_piece_has_the_right_derivative_and_is_off_by_8_pi_over_9():
    assert slopes_fit(EQUATION_5, EQUATION_4)[1]
    assert sp.expand(EQUATION_5[1] - MENDED[1]).subs(T, TURN) == 8 * sp.pi / 9
    mended_before = (MENDED[0], *EQUATION_5[1:])
    assert jumps(mended_before)[1].subs(T, TURN) == 8 * sp.pi / 9
    assert EQUATION_5[1].subs(t, 0) == MENDED[2].subs(t, 0)  # the constant of the third piece


def test_a3_the_third_piece_has_another_derivative_and_is_off_by_7_43_rad():
    assert not slopes_fit(EQUATION_5, EQUATION_4)[2]
    assert f"{np.abs(deviations(2)).max():.2f}" == "7.43"


def test_a3_the_third_piece_as_printed_never_completes_a_turn():
    at_the_end = sp.expand(EQUATION_5[2].subs(t, T))
    (best,) = sp.solve(at_the_end.diff(T), T)
    assert at_the_end.diff(T, 2) < 0
    assert at_the_end.subs(T, best) < 2 * sp.pi


def test_a1_and_one_term_of_a3_have_wrong_units_and_no_other_term_has():
    """An angle is 5 rad/s^2 times a time squared."""
    scale = sp.Symbol("lambda", positive=True)
    wrong = []
    for k, piece in enumerate(EQUATION_5):
        for term in sp.Add.make_args(sp.expand(piece)):
            if sp.simplify(term.subs({t: scale * t, T: scale * T}) / term - scale**2) != 0:
                wrong.append((k, term))
    assert wrong == [(0, 5 * t**3 / 6), (2, 15 * t**2 / (2 * T))]


def test_a4_the_final_speed_is_6_472_rad_per_s_which_is_62_rpm_and_not_6_45():
    speed = EQUATION_4[3].subs(T, TURN)
    area = 5 * (TURN / 3 + TURN) / 2  # of the trapezoid
    assert sp.simplify(speed - area) == 0
    assert f"{float(speed):.3f}" == "6.472"
    assert f"{float(speed * 30 / sp.pi):.1f}" == "61.8"
    assert f"{float(speed):.2f}" != "6.45"


def test_a4_no_rounding_of_t_gives_6_45_either():
    rounded = [round(float(TURN), digits) for digits in range(7)]
    assert "6.45" not in [f"{10 * value / 3:.2f}" for value in rounded]


@pytest.mark.parametrize("pieces", [EQUATION_4, MENDED], ids=["speed", "angle"])
def test_a9_with_the_listing_s_last_condition_nothing_is_true_after_t(pieces):
    def profile(last):
        conditions = (t < T / 3, t < 2 * T / 3, t < T, last)
        return sp.Piecewise(*zip(pieces, conditions, strict=True)).subs(T, 3)

    printed, mended = profile(t <= T), profile(t >= T)
    for instant in (sp.Rational(1, 2), sp.Rational(3, 2), sp.Rational(5, 2), sp.Integer(3)):
        assert printed.subs(t, instant) == mended.subs(t, instant)
    for instant in (sp.Rational(31, 10), sp.Integer(6)):
        assert printed.subs(t, instant) is sp.nan
        assert mended.subs(t, instant) == pieces[3].subs({t: instant, T: 3})
