"""Claims of the chapter on the force of the cylinder: what its cells compute, against the formulas by hand."""

import re

import numpy as np
import pytest
from executed import BOOK, executed, rows
from test_errata_cylinder import (
    G2,
    G3,
    G4,
    I4,
    I4_PRINTED,
    M2,
    M3,
    M4,
    PERIOD,
    B,
    G,
    L,
    angles,
    by_lagrange,
    by_virtual_power,
    difference_of_squares,
    published_lagrange,
    published_virtual_power,
    rate,
    stroke,
    turning,
    unbalanced,
)

TEXT = (BOOK / "cylinder-force.md").read_text("utf-8")
AS_PRINTED = {"projected": True, "simple_angle": True}
SCALE = 60.0  # N, a little above every force


@pytest.fixture(scope="module")
def chapter():
    return executed("cylinder-force")


def shown(number):
    return f"{number:.5f}" if number > 1e-9 else "< 1e-9"


# --- the source


def test_every_printed_result_is_found_to_every_digit(chapter):
    table = rows(chapter, "method")
    assert len(table) == 6
    assert {row[3] for row in table} == {"agrees, every digit"}
    for method, at, printed, _, computed in table:
        by_hand = published_lagrange if method == "Lagrange" else published_virtual_power
        assert computed == f"{by_hand(float(at)):.9f}"
        assert float(computed) == pytest.approx(float(printed), abs=0.5 * 10.0 ** -len(printed.partition(".")[2]))
    assert [row[2] for row in rows(chapter, "quantity")[:6]] == 6 * ["agrees, every digit"]


@pytest.mark.parametrize(
    ("name", "power", "lagrange"),
    [
        ("source", lambda t: by_virtual_power(t, I4_PRINTED, **AS_PRINTED), published_lagrange),
        ("one_cosine", published_virtual_power, published_lagrange),
        (
            "moving_right",
            lambda t: by_virtual_power(t, I4_PRINTED),
            lambda t: by_lagrange(t, I4_PRINTED, lambda D: np.cos(2 * D)),
        ),
        ("agreed", lambda t: by_virtual_power(t, I4_PRINTED), lambda t: by_lagrange(t, I4_PRINTED)),
        ("right", by_virtual_power, by_lagrange),
    ],
)
def test_the_switches_of_the_listing_are_the_mistakes_and_nothing_else(chapter, name, power, lagrange):
    listing = chapter[name]
    np.testing.assert_allclose(listing.virtual_power(PERIOD), power(PERIOD), atol=1e-12 * SCALE)
    np.testing.assert_allclose(listing.lagrange(PERIOD), lagrange(PERIOD), atol=1e-12 * SCALE)


def test_the_error_curve_has_its_largest_value_its_dips_and_its_zeros_where_the_figure_says():
    t = np.arange(2000) / 2000
    curve = published_lagrange(t) - by_virtual_power(t, I4_PRINTED, **AS_PRINTED)
    assert (f"{curve.max():.7f}", t[curve.argmax()]) == ("0.0132088", 0.25)
    assert f"{curve[1500]:.4f}" == "0.0116"
    assert curve[[0, 1000]] == pytest.approx(0, abs=1e-12)
    low, high = curve[1000:1500], curve[1500:]
    for dip in (low, high):
        assert f"{dip.min():.4f}" == "-0.0015"
    assert curve[:1000].min() > -1e-12


def test_without_the_wrong_cosine_the_difference_dips_no_more(chapter):
    apart = [line.split(": ")[1] for line in chapter["said"] if ": apart from " in line]
    assert apart == ["apart from -0.0015 to 0.0132 N", *2 * ["apart from 0.0000 to 0.0132 N"]]
    assert (published_lagrange(PERIOD) - published_virtual_power(PERIOD)).min() > -1e-9


def test_the_spectrum_is_above_round_off_up_to_mode_10_and_falls_by_a_factor_of_twenty_or_so(chapter):
    modes = chapter["modes"]
    assert (modes[:4] > 1e-3).all()
    assert (modes[:4] < 1e-2).all()
    assert 10 < (modes[3] / modes[10]) ** (1 / 7) < 40
    assert modes[10] > 5 * chapter["unit"] > 5 * np.abs(modes[13:]).max()


# --- the three methods


def test_all_methods_of_the_chapter_give_the_right_force(chapter):
    for name in ("by_power", "by_lagrange", "by_newton"):
        np.testing.assert_allclose(chapter[name], by_virtual_power(PERIOD), atol=1e-12 * SCALE)
    np.testing.assert_allclose(chapter["there"], by_lagrange(0.25), atol=1e-12 * SCALE)
    assert [line for line in chapter["said"] if line.endswith("False")] == []


def test_an_error_of_the_velocity_divided_by_the_rounded_cosine_is_a_force_of_tonnes(chapter):
    assert "v rounded: right" in chapter["said"]
    assert "v exactly 0: off by nan N" in chapter["said"]
    (line,) = (line for line in chapter["said"] if line.startswith("w off by 1e-12: off by"))
    # both angular velocities are off by 1e-12, and with them the centres of mass
    a, v, acc = stroke(0.25)
    th2, th4 = angles(0.25)
    (k2, _), (k4, _) = turning(0.25)
    eps2, eps4 = k2 * acc, k4 * acc  # v is zero
    about2 = (G2**2 * M2 / 3 + M2 * G2**2 + L**2 * M3 / 12 + M3 * (a + G3) ** 2) * eps2
    power = about2 + G * np.cos(th2) * (M2 * G2 + M3 * (a + G3))
    power += (I4 + M4 * G4**2) * eps4 + M4 * G * G4 * np.cos(th4)
    assert float(line.split()[-2]) == pytest.approx(1e-12 * power / v, rel=0.1)


def test_the_terms_of_lagrange_are_weights_of_43_newtons_and_inertia_of_8(chapter):
    th2, th4 = angles(PERIOD)
    lifted = M2 * G2 * np.sin(th2) + M3 * (stroke(PERIOD)[0] + G3) * np.sin(th2) + M4 * G4 * np.sin(th4)
    v = stroke(PERIOD)[1]
    np.testing.assert_allclose(chapter["of_weights"] * v, G * rate(lifted).real, atol=1e-10)
    assert np.abs(chapter["of_weights"] - 43.15).max() < 0.15
    assert 7.5 < np.abs(chapter["of_inertia"]).max() < 8
    assert np.abs(chapter["of_change"]).max() < 0.2


def test_the_reactions_carry_the_whole_mechanism_and_turn_the_rocker(chapter):
    (a, *_), (th2, th4) = stroke(PERIOD), angles(PERIOD)
    e2, e4 = np.exp(1j * th2), np.exp(1j * th4)
    demand = [m * (rate(rate(z)) + 1j * G) for m, z in ((M2, G2 * e2), (M3, (a + G3) * e2), (M4, G4 * e4))]
    O2, A, O4 = (chapter["forces"][name] @ (1, 1j) for name in ("O2", "A", "O4"))
    np.testing.assert_allclose(O2 + O4, sum(demand), atol=1e-8)
    turns = I4 * rate(rate(th4)).real + G4 * (e4.conjugate() * demand[2]).imag
    np.testing.assert_allclose(B * (e4.conjugate() * -A).imag, turns, atol=1e-8)
    Q = by_virtual_power(PERIOD)
    assert (np.abs(A) < Q).all()
    assert (np.abs(O2) > Q).all()
    table = {row[0]: row[1:] for row in rows(chapter, "reaction")}
    assert table[r"$\|A\|$ (N)"] == [f"{np.abs(A).min():.3f}", f"{np.abs(A).max():.3f}"]


# --- the case


def test_the_witness_says_no_to_both_methods_and_what_it_says_of_each_step(chapter):
    steps = (
        (lambda t: by_virtual_power(t, I4_PRINTED, **AS_PRINTED), published_lagrange),
        (published_virtual_power, published_lagrange),
        (
            lambda t: by_virtual_power(t, I4_PRINTED),
            lambda t: by_lagrange(t, I4_PRINTED, difference_of_squares),
        ),
        (lambda t: by_virtual_power(t, I4_PRINTED), lambda t: by_lagrange(t, I4_PRINTED)),
        (by_virtual_power, by_lagrange),
    )
    table = rows(chapter, "mended, one after the other")
    for row, (power, lagrange) in zip(table, steps, strict=True):
        P, Q = power(PERIOD), lagrange(PERIOD)
        expected = [np.abs(x).max() for x in (Q - P, unbalanced(P), unbalanced(Q))]
        assert row[1:] == [f"{power(0.25):.5f}", *map(shown, expected)]
    assert table[0][3] > "0.3"
    assert table[3][2] == "< 1e-9"
    assert table[3][3] == table[3][4] > "0.3"


def test_no_angular_velocity_of_the_source_is_that_of_its_angle_and_two_mendings_make_them_so(chapter):
    truth = [rate(angle).real for angle in angles(PERIOD)]
    truth += [rate(each).real for each in truth]
    table = rows(chapter, "off by")
    for row, wrong in zip(table, (AS_PRINTED, {"projected": True}, {}), strict=True):
        _, v, acc = stroke(PERIOD)
        pairs = turning(PERIOD, **wrong)
        rates = [k * v for k, _ in pairs] + [k * acc + dk * v for k, dk in pairs]
        off = [np.abs(x - y).max() for x, y in zip(rates, truth, strict=True)]
        assert row[1:] == [f"{x:.5f}" if x > 1e-8 else "< 1e-8" for x in off]
    assert table[-1][1:] == 4 * ["< 1e-8"]


def test_only_the_weight_of_the_rod_keeps_the_difference(chapter):
    th2, th4 = angles(PERIOD)
    D, a = th2 - th4, stroke(PERIOD)[0]
    term = M3 * G * (a + G3) / (a + L) * np.cos(th2) * (difference_of_squares(D) - 1 / np.tan(D))
    found = dict(rows(chapter, "switched off"))
    expected = shown(np.abs(term).max())
    assert found == {
        "nothing": expected,
        "the weights": "< 1e-9",
        "all but the barrel": "< 1e-9",
        "all but the rod": expected,
        "all but the rocker": "< 1e-9",
    }


def test_one_candidate_alone_gives_the_printed_digits_and_another_makes_the_methods_agree(chapter):
    table = rows(chapter, "in the brackets")
    assert [row[3] for row in table] == ["**yes**", "no", "no", "no", "no"]
    assert [row[4] == "< 1e-9" for row in table] == [False, False, False, False, True]
    assert table[-1][0] == r"$\sin D\,\cos D$"


def test_told_the_same_wrong_inertia_every_method_and_the_witness_agree(chapter):
    off = by_virtual_power(PERIOD, I4_PRINTED) - by_virtual_power(PERIOD)
    for force in chapter["wrong"]:
        np.testing.assert_allclose(force, by_virtual_power(PERIOD, I4_PRINTED), atol=1e-12 * SCALE)
    assert np.abs(unbalanced(by_virtual_power(PERIOD, I4_PRINTED), I4_PRINTED)).max() < 1e-9
    assert f"and all of them wrong by {np.abs(off).max():.2f} N" in chapter["said"]


def test_the_two_great_mistakes_leave_no_difference_and_the_two_small_ones_make_it(chapter):
    table = {row[0]: row[1:] for row in rows(chapter, "mistake")}
    C1, C2, C3, C5 = (table[name] for name in ("C1", "C2", "C3", "C5"))
    Q = by_virtual_power(PERIOD)
    assert C1[2] == C3[2] == "0"
    assert C1[0] == C1[1] == f"{np.abs(by_virtual_power(PERIOD, projected=True) - Q).max():.4f}"
    assert C3[0] == C3[1] == f"{np.abs(by_virtual_power(PERIOD, I4_PRINTED) - Q).max():.4f}"
    assert C2 == ["0", "0.0132", "0.0132"]
    wrong = by_virtual_power(PERIOD, **AS_PRINTED) - by_virtual_power(PERIOD, projected=True)
    assert C5 == [f"{np.abs(wrong).max():.4f}", "0", f"{np.abs(wrong).max():.4f}"]


def test_the_numbers_in_the_boxes(chapter):
    off = np.abs(published_virtual_power(PERIOD) - by_virtual_power(PERIOD)).max()
    assert off / 0.0132088 == pytest.approx(462, abs=0.5)
    assert M2 / M4 == 5
    assert (f"{I4 + M4 * G4**2:.2f}", f"{I4_PRINTED + M4 * G4**2:.2f}") == ("0.48", "0.96")
    assert rows(chapter, "of")[2][2:] == ["0.96", "agrees, every digit", "**0.480**"]


# --- pressures


def test_at_2_bar_the_chambers_carry_by_turns_twice_a_second_and_the_return_line_holds_them_up(chapter):
    Q, whole, rod = by_virtual_power(PERIOD), np.pi * 0.016**2, np.pi * 0.008**2
    carried = {row[0]: row[3] for row in rows(chapter, "$p_0$ (bar)")}
    assert carried == {"0": "lower", "1": "lower", "2": "by turns", "3": "upper"}
    for bar, by in carried.items():
        needs_more = Q > float(bar) * 1e5 * rod
        assert {"lower": needs_more.all(), "upper": not needs_more.any()}.get(by, 0 < needs_more.mean() < 1)
        p_1, p_2, *_ = chapter["carried_by"](float(bar) * 1e5)
        np.testing.assert_allclose(p_1 * whole - p_2 * (whole - rod), Q, atol=1e-9)
    assert np.abs(np.diff(Q > 2e5 * rod)).sum() == 2


# --- the page itself


@pytest.mark.parametrize("figure", ["both forces", "error"])
def test_a_figure_of_source_c_has_a_counterpart(figure):
    assert "Counterparts of source C, both forces and error." in TEXT
    assert f"| {figure} | {{numref}}`fig-source-force` |" in TEXT


@pytest.mark.parametrize("place", ["weight of the rod", "Ig4", "comparison of the results"], ids=["C2", "C3", "C4"])
def test_a_mistake_of_source_c_stands_in_a_box_of_its_own(place):
    boxes = re.findall(r":::\{admonition\} (Source C.*?)\n:class: warning", TEXT)
    assert len([box for box in boxes if place in box]) == 1


def test_the_sections_have_the_names_that_the_checks_send_to():
    agreed = (
        "Virtual power",
        "Lagrange's equation",
        "Newton and Euler, and the reactions",
        "Why the two methods differed",
        "Pressure in the chambers",
        "What the source printed",
        "The exercise",
    )
    headings = re.findall(r"^## (.*)$", TEXT, re.MULTILINE)
    assert [heading for heading in headings if heading in agreed] == list(agreed)
