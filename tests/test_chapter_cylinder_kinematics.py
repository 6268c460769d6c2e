"""Claims of the chapter on the cylinder's kinematics: what its cells compute, against circles that meet and series."""

import re
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from executed import BOOK, executed, rows
from numpy.polynomial import Chebyshev

TEXT = (BOOK / "cylinder-kinematics.md").read_text("utf-8")
O2, B, L = 0.25 - 1j, 0.25, 0.4  # m, source C; O4 is the origin
G2, G3, G4 = 0.3, 0.2, 0.6
STOPS = 0.405, 0.795
SECOND = np.arange(1000) / 1000


@pytest.fixture(scope="module")
def chapter():
    return executed("cylinder-kinematics")


def pin(s, side=1, b=B):
    """A: where the circles about O4 and O2 meet, right of the line from O2 to O4, or left of it (side -1)."""
    d = abs(O2)
    return b * O2 / d * np.exp(side * 1j * np.arccos((d**2 + b**2 - np.asarray(s) ** 2) / (2 * d * b)))


def angles(s, side=1):
    """theta2 and theta4, without leaps for the cylinder of source C between its stops."""
    A = pin(s, side)
    return np.angle(A - O2), np.angle(A)


def ratios(s, order):
    """Derivative of both angles by the length, from their Chebyshev series."""
    ends = [each + L for each in STOPS]
    series = (Chebyshev.interpolate(lambda s, k=k: angles(s)[k], 80, ends) for k in range(2))
    return np.stack([each.deriv(order)(s) for each in series], axis=-1)


def rate(values, period=1.0):
    """Derivative by time of what repeats, from its Fourier series."""
    waves = 2j * np.pi * np.fft.fftfreq(len(values), period / len(values))
    return np.fft.ifft(waves * np.fft.fft(values))


def source(t=SECOND, amplitude=0.02):
    """The length, and the angles, along the motion of source C."""
    s = 0.6 + amplitude * np.sin(2 * np.pi * t) + L
    return s, *angles(s)


# --- the failure


def test_the_printed_formula_is_right_at_one_stroke_and_misses_nearly_a_quarter_of_the_whole_swing(chapter):
    s = np.linspace(*STOPS, 391) + L
    th2, th4 = angles(s)
    assert chapter["turned"] == pytest.approx(np.rad2deg(th4[-1] - th4[0]))
    over_v = Chebyshev.interpolate(lambda s: np.sin(np.subtract(*angles(s))) / B, 80, [s[0], s[-1]]).integ()
    missing = 1 - np.rad2deg(over_v(s[-1]) - over_v(s[0])) / chapter["turned"]
    assert 0.23 < missing < 0.25
    assert np.sin(th2 - th4).argmax() == 195  # at a = 0.6
    np.testing.assert_allclose(chapter["w4_C"], 0.1 * np.sin(th2 - th4) / B, atol=1e-14)
    assert np.sin(np.subtract(*angles(1.0))) == pytest.approx(1, abs=1e-14)
    true = 0.1 * ratios(s, 1)[:, 1]
    np.testing.assert_allclose(chapter["differences"][1:-1], true[1:-1], atol=2e-3)
    assert [round(x, 1) for x in (*true[[0, 195]], *chapter["w4_C"][[0, 195]])] == [0.8, 0.4, 0.2, 0.4]


def test_along_the_motion_of_the_source_it_is_at_most_0_653_percent_too_low(chapter):
    s, th2, th4 = source()
    (_, w4), v = (rate(each).real for each in (th2, th4)), rate(s).real
    moving = np.abs(v) > 1e-3
    low = 1 - (v * np.sin(th2 - th4) / B)[moving] / w4[moving]
    assert f"{100 * chapter['too_slow'].max():.3f}" == "0.653"
    assert low.max() == pytest.approx(chapter["too_slow"].max(), rel=1e-3)


# --- the triangle


@pytest.mark.parametrize("side", [1, -1])
def test_both_ways_give_the_point_where_two_circles_meet_on_their_side(chapter, side):
    s = np.linspace(0.79, 1.27, 97)
    for way in ("by_two_cosines", "by_half_angle"):
        th2, th4 = chapter[way](s, side).T
        np.testing.assert_allclose(B * np.exp(1j * th4), pin(s, side), atol=1e-13)
        np.testing.assert_allclose(O2 + s * np.exp(1j * th2), pin(s, side), atol=1e-13)
        across = ((-O2).conjugate() * (pin(s, side) - O2)).imag
        assert (across < 0 if side == 1 else across > 0).all()


def test_near_the_flat_triangle_two_cosines_open_the_loop_and_the_half_angle_does_not(chapter):
    for name, opens in (("two cosines", True), ("half angle", False)):
        nearest = chapter["opening"][name][chapter["from_the_end"] < 1e-12]
        assert (nearest.max() > 1e-10) == opens
        assert chapter["opening"][name][-1] < 1e-14
    assert chapter["opening"]["half angle"].max() < 1e-15


def test_half_of_the_digits_of_the_angle_are_gone_and_the_last_digit_of_the_length_is_to_blame_too(chapter):
    def exact(s):
        d = mpmath.sqrt(mpmath.mpf(1) + mpmath.mpf(1) / 16)
        return mpmath.acos((d**2 + mpmath.mpf(1) / 16 - mpmath.mpf(s) ** 2) / (d / 2))

    beta = np.arctan2(1, 0.25)
    with mpmath.workdps(40):
        for distance in (1e-14, 1e-12, 1e-10, 1e-8):
            s = chapter["cylinder"].reach[0] + distance * np.linspace(1, 2, 20)
            digit = max(abs(exact(np.nextafter(each, 2)) - exact(each)) for each in s)
            for way in ("by_two_cosines", "by_half_angle"):
                phi = chapter[way](s)[:, 1] + beta
                off = max(abs(exact(each) - found) for each, found in zip(s, phi, strict=True))
                assert digit / 30 < off < 30 * digit
                assert distance > 1e-13 or 1e-10 < off < 1e-8


def test_the_formula_of_the_half_angle_is_the_law_of_cosines():
    d, b, third = np.random.default_rng(0).uniform(0.1, 1, (3, 1000))
    short, long = np.abs(d - b), d + b
    s = short + third * (long - short)
    phi = np.arccos((d**2 + b**2 - s**2) / (2 * d * b))
    half = (s - short) * (s + short) / ((long - s) * (long + s))
    np.testing.assert_allclose(np.tan(phi / 2) ** 2, half, rtol=1e-9)


# --- the stroke


def test_the_table_of_limits_says_which_binds(chapter):
    sizes = [(0.4, 0.8, 0.25, 0.4), (0.35, 0.9, 0.25, 0.4), (0.4, 0.8, 0.15, 0.4), (0.4, 0.8, 0.25, 0.35)]
    table = rows(chapter, "mechanism (m)")
    assert len(table) == len(sizes)
    for row, (li, ls, b, l) in zip(table, sizes, strict=True):
        stops, reach = (li + 0.005, ls - 0.005), (abs(O2) - b - l, abs(O2) + b - l)
        assert row[1:3] == [f"{low:.3f} to {high:.3f}" for low, high in (stops, reach)]
        stop = stops[0] > reach[0], stops[1] < reach[1]
        assert row[3] == ", ".join("stop" if each else "triangle" for each in stop)
        for a, by_stop, leverage in zip((0, 1), stop, row[-1].split(", "), strict=True):
            A = pin(stops[a] + l, b=b) if by_stop else O2 / 2  # in line with O2 and O4
            sine = ((A - O2).conjugate() * A).imag / abs(A - O2) / abs(A)
            assert leverage == f"{abs(sine):.2f}"


def test_c7_hi_is_0_195_and_with_the_printed_one_five_millimetres_are_left_over(chapter):
    a, e, li, ls = map(Fraction, ("0.6", "0.01", "0.4", "0.8"))
    assert chapter["hi"] == a - e / 2 - li == Fraction("0.195")
    assert chapter["hs"] == ls - e / 2 - a == Fraction("0.195")
    assert ls - li - (Fraction("0.19") + e + Fraction("0.195")) == Fraction("0.005")
    assert f"{chapter['in_binary']:.2f}" == "0.19"


# --- ratios


def test_the_ratios_are_derivatives_of_the_angles_where_two_circles_meet(chapter):
    s = np.linspace(*STOPS, 391) + L
    for order, numbers in enumerate(chapter["numbers"], start=1):
        expected = ratios(s, order)
        np.testing.assert_allclose(numbers, expected, atol=1e-9 * np.abs(expected).max() * 100**order)
    k, h = chapter["numbers"]
    assert [round(x) for x in (k[195, 1], k[0, 1], k[-1, 1], k[0, 0])] == [4, 8, 6, -2]
    assert [round(x) for x in h[0]] == [58, -156]


def test_the_pin_is_never_slower_than_the_piston_and_the_arm_is_that_of_the_line():
    s = np.linspace(*STOPS, 391) + L
    k4 = ratios(s, 1)[:, 1]
    assert (B * k4 > 1 - 1e-10).all()
    line = (pin(s) - O2) / s
    np.testing.assert_allclose(1 / k4, np.abs((line.conjugate() * -O2).imag), atol=1e-9)


def test_the_short_formulas_of_the_second_ratios_are_what_sympy_finds(chapter):
    assert chapter["sp"].simplify(chapter["of_one_angle"]).is_zero_matrix
    difference = chapter["h"] - chapter["by_hand"]
    rng = np.random.default_rng(4)
    for _ in range(5):
        point = dict(zip(difference.free_symbols, rng.uniform(0.3, 2, len(difference.free_symbols)), strict=True))
        assert abs(float(difference.subs(point).norm())) < 1e-9 * float(chapter["h"].subs(point).norm())


def test_differences_in_time_converge_with_order_two(chapter):
    np.testing.assert_allclose(chapter["order"], 2, atol=0.02)


def test_c5_and_c1_one_by_one_to_the_printed_decimals(chapter):
    s, th2, th4 = source()
    D, (v, dv) = th2 - th4, (rate(s).real, rate(rate(s)).real)
    alpha2 = rate(rate(th2)).real
    w2, w4 = rate(th2).real, rate(th4).real
    wrong = v * np.sin(D) * np.cos(D) / s, v * np.sin(D) / B
    own = rate(wrong[0]).real
    table = rows(chapter, r"$\varepsilon_2$ (rad/s²)")
    for row, c, rates in zip(table, (np.cos(D), np.cos(2 * D), np.cos(2 * D)), (wrong, wrong, (w2, w4)), strict=True):
        eps2 = (dv / s - v**2 / s**2) * np.sin(2 * D) / 2 + v / s * (rates[0] - rates[1]) * c
        assert row[1:] == [f"{np.abs(eps2 - each).max():.6f}" for each in (own, alpha2)]
    assert np.abs(alpha2).max() == pytest.approx(np.abs(chapter["alpha2"]).max(), rel=1e-6)
    assert float(table[0][2]) > 0.95 * np.abs(alpha2).max()  # almost the whole
    assert [table[2][1], table[1][2]] == ["0.000000", table[2][2]]
    assert f"{chapter['ratio_off']:.5f}" == "0.00129"


# --- points


def test_velocities_and_accelerations_of_the_centres_are_derivatives_of_their_paths(chapter):
    t = np.arange(800) / 800
    s, th2, th4 = source(t, 0.19)
    paths = {"G2": O2 + G2 * np.exp(1j * th2), "G3": O2 + (s - L + G3) * np.exp(1j * th2), "G4": G4 * np.exp(1j * th4)}
    for name, z in paths.items():
        for found, expected in zip(chapter["found"][name], (rate(z, 4), rate(rate(z, 4), 4)), strict=True):
            np.testing.assert_allclose(found[:-1] @ (1, 1j), expected[::20], atol=1e-8)


def test_the_parts_of_the_acceleration_are_those_of_the_path_at_a_steady_speed(chapter):
    a = np.linspace(*STOPS, 391)
    path = [Chebyshev.interpolate(f, 60, STOPS) for f in (lambda a: place(a).real, lambda a: place(a).imag)]
    acceleration = 0.1**2 * (path[0].deriv(2)(a) + 1j * path[1].deriv(2)(a))
    turned = acceleration * np.exp(-1j * angles(a + L)[0])
    parts = chapter["parts"]
    np.testing.assert_allclose(parts["centripetal"], turned.real, atol=1e-6)
    np.testing.assert_allclose(parts["tangential"] + parts["Coriolis"], turned.imag, atol=1e-6)
    assert [f"{parts[name][0]:.3f}" for name in ("tangential", "Coriolis", "centripetal")] == [
        "0.352", "-0.045", "-0.030",
    ]  # fmt: skip


def place(a):
    return O2 + (a + G3) * np.exp(1j * angles(a + L)[0])


def test_c6_the_printed_speed_of_the_rod_leaves_the_sliding_out(chapter):
    speed = np.abs(rate(place(source()[0] - L)))
    np.testing.assert_allclose(chapter["speed_G3"], speed, atol=1e-11)
    assert f"{speed[0]:.4f}" == "0.1257"
    assert chapter["turning_only"][0] < 1e-12
    assert chapter["turning_only"].max() < 0.05 * speed.max()


def test_each_sentence_sees_the_mistakes_of_its_own_body(chapter):
    seen = {row[0]: [cell != "0" for cell in row[1:]] for row in rows(chapter, "rates")}
    assert seen == {
        "right": [False] * 4,
        "velocities of source C": [True] * 4,
        r"no Coriolis in $\alpha_2$": [False, True, False, False],
        "no $h v^2$": [False, True, False, True],
    }


# --- the source


def test_of_the_printed_numbers_only_hi_differs(chapter):
    table = {row[0]: row[1:] for row in rows(chapter, "quantity")}
    assert {name for name, row in table.items() if row[-1] != "agrees, every digit"} == {"$h_i$ (m)"}
    assert len(table) == 8
    s, th2, th4 = source()
    numbers = (abs(O2), rate(s).real[0], 0.195, 0.195, th2[0], th4[0], rate(th2).real[0], rate(th4).real[0])
    for (name, row), number in zip(table.items(), numbers, strict=True):
        assert float(row[1]) == pytest.approx(number, abs=1e-6), name


def test_of_the_formulas_the_projection_what_follows_from_it_and_one_speed_differ(chapter):
    verdicts = {row[0]: row[1] for row in rows(chapter, "formula of source C")}
    assert [name for name, verdict in verdicts.items() if verdict == "**differs**"] == [
        r"$\omega_4$", r"$\omega_2$", r"$\varepsilon_4$", r"$\varepsilon_2$", "$v_{G3}$, its size",
    ]  # fmt: skip
    assert len(verdicts) == 11


def test_a_formula_with_a_term_changed_would_not_pass_whatever_the_signs(chapter):
    for name, formulas in chapter["printed"].items():
        for terms, derived in formulas:
            right = chapter["agrees"](terms, derived)
            for k, term in enumerate(terms):
                if float(chapter["sp"].sympify(term).subs(chapter["somewhere"])):
                    changed = [*terms[:k], 1.01 * term, *terms[k + 1 :]]
                    assert not (right and chapter["agrees"](changed, derived)), name


@pytest.mark.parametrize("place", ["velocities", "eps2", "vg3", "hi"])
def test_a_mistake_of_source_c_stands_in_a_box_of_its_own(place):
    """C1, C5, C6 and the misprint."""
    boxes = re.findall(r":::\{admonition\} Source C, (\w+):.*\n:class: warning", TEXT)
    assert boxes.count(place) == 1
