"""The chapter on the four-bar linkage: what its cells claim, against geometry that shares nothing with mechlib."""

import re

import numpy as np
import pytest
from executed import BOOK, executed, rows

TEXT = (BOOK / "fourbar-coupler.md").read_text("utf-8")
R1, R2, R3, R4, RCX, RCY = 1.08913, 0.42259, 0.964444, 0.58781, 0.39137, 0.42950  # m, source D, table 1
DEGREES = np.arange(361)
TURN = np.deg2rad(DEGREES)


@pytest.fixture(scope="module")
def chapter():
    return executed("fourbar-coupler")


def assembled(crank, side=1, lengths=(R1, R2, R3, R4, RCX, RCY)):
    """A, B and P: B where the circles about A and O4 meet, left of A-O4 or (side -1) right of it."""
    r1, r2, r3, r4, rcx, rcy = lengths
    A = r2 * np.exp(1j * np.asarray(crank))
    far = np.abs(r1 - A)
    along = (r1 - A) / far * np.exp(side * 1j * np.arccos((r3**2 + far**2 - r4**2) / (2 * r3 * far)))
    return A, A + r3 * along, A + (rcx + 1j * rcy) * along


def rate(values):
    """Derivative of a periodic function on an even grid of the turn."""
    n = len(values)
    return np.fft.ifft(1j * np.fft.fftfreq(n, 1 / n) * np.fft.fft(values))


# --- the failure


def test_the_printed_arm_changes_its_length_and_the_true_one_does_not(chapter):
    A, B, P = assembled(TURN)
    th3 = np.angle(B - A)
    square = RCX**2 + RCY**2 - 2 * RCX * RCY * np.sin(2 * th3)
    np.testing.assert_allclose(chapter["arm"] ** 2, square, atol=1e-14)
    assert np.ptp(chapter["arm"]) > 0.4
    np.testing.assert_allclose(chapter["right"], P, atol=1e-13)
    assert np.abs(P - A) == pytest.approx(np.hypot(RCX, RCY))


def test_the_expanded_product_has_a_plus_in_its_second_line(chapter):
    a, b, th = (chapter[name] for name in ("a", "b", "th"))
    real, imaginary = chapter["product"].as_real_imag()
    for part, sine in ((real, -1), (imaginary, 1)):
        assert part.coeff(b).subs(th, 0.0 if part is imaginary else np.pi / 2) == pytest.approx(sine)
    assert imaginary.coeff(a).subs(th, np.pi / 2) == pytest.approx(1)


# --- both branches


@pytest.mark.parametrize(("name", "side"), [("open", 1), ("crossed", -1)])
def test_triangle_half_angle_and_newton_give_the_branch_they_name(chapter, name, side):
    A, B, P = assembled(TURN, side)
    np.testing.assert_allclose(chapter["coupler_bar"](TURN, side), B - A, atol=1e-13)
    np.testing.assert_allclose(chapter["coupler_point"](TURN, side), P, atol=1e-13)
    X, Y = chapter["half_pair"](chapter["linkage"], TURN, -side)
    np.testing.assert_allclose((X + 1j * Y) ** 2 / (X**2 + Y**2), (B - A) / R3, atol=1e-13)
    (line,) = (each for each in chapter["said"] if each.startswith(name) and "closed" in each)
    assert line.count("True") == 2
    (line,) = (each for each in chapter["said"] if each.startswith(name) and "iterations" in each)
    assert line.endswith("agrees to 1e-13: True")


def test_the_derivation_of_freudenstein_s_equation_holds(chapter):
    assert "the same: True" in chapter["said"]
    assert "ka Y² + kb X Y + kc X² = 0: True" in chapter["said"]
    A, B, _ = assembled(TURN)
    th3 = np.angle(B - A)
    l1, l2, l3 = R1 / R2, R1 / R3, (R4**2 - R1**2 - R2**2 - R3**2) / (2 * R2 * R3)
    left = np.cos(TURN - th3) - l1 * np.cos(th3) - l2 * np.cos(TURN) - l3
    np.testing.assert_allclose(left, 0, atol=1e-13)


def test_the_half_angle_loses_its_digits_where_ka_is_zero_and_source_d_never_comes_there(chapter):
    lost = list(chapter["lost"].values())
    assert lost[0] < 1e-13 and lost[1] > 1e-12 and lost[2] > 1e-8
    X, _ = chapter["half_pair"](chapter["double_crank"], chapter["where"], -1)
    assert abs(X) < 1e-14
    assert (chapter["half_pair"](chapter["linkage"], TURN, -1)[0] < -5).all()


# --- the curve


def test_the_table_of_ten_points_has_both_branches(chapter):
    table = rows(chapter, "")
    assert len(table) == 10
    for _, theta2, *found in table:
        points = [assembled(float(theta2), side)[2] for side in (1, -1)]
        np.testing.assert_allclose(
            [float(each) for each in found], np.ravel([[z.real, z.imag] for z in points]), atol=6e-7
        )
    ten = np.array([float(row[1]) for row in table])
    _, _, P = assembled(ten)
    assert np.sum((P.real < 0) & (P.imag < 0.25)) == 5  # half of them on the lower left
    speed = np.abs(rate(assembled(TURN[:-1])[2]))
    assert np.interp(ten[P.imag < 0.25], TURN[:-1], speed).max() < np.median(speed)


# --- classes and dead points


def test_the_table_of_grounds_says_where_the_crank_turns(chapter):
    table = rows(chapter, "$r_1$ (m)")
    assert [row[3] for row in table] == [
        "double-crank", "triple-rocker", "change-point", "crank-rocker", "crank-rocker", "crank-rocker", "change-point",
        "triple-rocker",
    ]  # fmt: skip
    for ground, sums, others, kind, turns, dead in table:
        r1 = float(ground)
        bars = sorted((r1, R2, R3, R4))
        assert (float(sums), float(others)) == pytest.approx((bars[0] + bars[3], bars[1] + bars[2]), abs=1e-4)
        far = np.abs(r1 - R2 * np.exp(1j * TURN[:-1]))
        closes = (far <= R3 + R4 + 1e-4) & (far >= abs(R3 - R4) - 1e-4)
        assert turns == ("round" if closes.all() else f"{closes.sum()}°")
        assert bool(dead) == (kind in ("triple-rocker", "change-point"))
        if dead:
            reach = abs(r1 - R2 * np.exp(1j * np.deg2rad(float(dead.rstrip("°")))))
            assert min(abs(reach - R3 - R4), abs(reach - abs(R3 - R4))) < 1e-3


def test_source_d_lies_40_mm_from_a_change_point(chapter):
    assert "room for r1: 40.53 mm to the change point" in chapter["said"]
    assert 1000 * (R3 + R4 - R2 - R1) == pytest.approx(40.534, abs=1e-3)
    before, close, there, beyond = chapter["apart"]
    assert there < 1e-3 < 1 < close < before
    assert close == pytest.approx(beyond, rel=1e-6)


def test_the_rocker_turns_back_where_crank_and_coupler_are_in_line(chapter):
    table = rows(chapter, r"$\theta_2$")
    assert [row[2] for row in table].count("open") == 2 and all(row[4] == "True" for row in table)
    fine = np.linspace(-np.pi, np.pi, 360_001)
    for side, name in ((1, "open"), (-1, "crossed")):
        _, B, _ = assembled(fine, side)
        th4 = np.angle(B - R1)
        for k, bars in ((np.abs(th4).argmin(), "stretched"), (np.abs(th4).argmax(), "folded")):
            (row,) = (r for r in table if r[2] == name and r[1] == bars)
            assert float(row[0][:-1]) == pytest.approx(np.rad2deg(fine[k]), abs=2e-3)
            assert float(row[3][:-1]) == pytest.approx(np.rad2deg(th4[k]), abs=1e-4)


def test_the_transmission_angle_is_least_with_the_crank_in_line_with_the_ground(chapter):
    for k, far in ((0, R1 - R2), (180, R1 + R2)):
        least = np.rad2deg(np.arccos(abs(R3**2 + R4**2 - far**2) / (2 * R3 * R4)))
        assert chapter["mu"][k] == pytest.approx(least, rel=1e-12)
    assert chapter["mu"].argmin() == 180
    assert chapter["mu"][180] < 30


# --- velocity


def test_the_velocity_is_the_derivative_of_the_curve(chapter):
    turn = TURN[:-1]
    A, B, P = assembled(turn)
    np.testing.assert_allclose(chapter["v"][:-1], rate(P), atol=1e-10)
    np.testing.assert_allclose(chapter["omega3"][:-1], (rate(B - A) / (1j * (B - A))).real, atol=1e-10)
    np.testing.assert_allclose(chapter["order"], 2, atol=0.02)
    assert "as mechlib's: omega3 True, velocity of P True" in chapter["said"]
    assert "v = i omega3 (P - centre): True" in chapter["said"]
    assert chapter["meets"].sum() > 300


def test_the_slowest_and_the_fastest_place_are_the_extremes_of_the_speed(chapter):
    n = 3600
    speed = np.abs(rate(assembled(2 * np.pi * np.arange(n) / n)[2]))
    for k, extreme, at in ((chapter["slow"], np.argmin, np.min), (chapter["fast"], np.argmax, np.max)):
        assert np.rad2deg(chapter["fine"][k]) == pytest.approx(extreme(speed) / 10, abs=0.11)
        assert chapter["speed"][k] == pytest.approx(at(speed), rel=1e-6)
    assert speed.min() > 0.19


# --- the source


def test_the_verdicts_on_the_formulas(chapter):
    assert [row[1] for row in rows(chapter, "source D")] == ["agrees", "agrees", "**differs**", "agrees", "**differs**"]


def test_the_six_lengths_explain_every_published_mean(chapter):
    published = np.loadtxt(BOOK / "data" / "fourbar_published.csv", delimiter=",", skiprows=1)
    thrown = chapter["thrown"]
    z = assembled(published[:, 0], lengths=thrown)[2]
    left = np.abs(np.stack((z.real, z.imag), axis=-1) - published[:, 1:3])
    left[[3, 8], 0] -= 5e-5  # three digits
    assert left.max() < 1e-9
    assert [row[3] for row in rows(chapter, "point")] == ["agrees, every digit"] * 2
    aside = {row[0]: row[2:] for row in rows(chapter, "length")}
    program, table = np.transpose([[float(each) for each in row] for row in aside.values()])
    assert (np.abs(np.delete(program, 3)) < 1.5).all() and program[3] == pytest.approx(-4.2)
    assert table[1] == pytest.approx(-68.1) and table[2] == pytest.approx(-7.0)
    four = [float(row[2]) for row in rows(chapter, "$r_2$ (m)")]
    assert min(four[:2]) > 40 > 3.4 > max(four[2:])


def test_the_bent_coupler_is_rigid_and_another_one(chapter):
    A, B, P = (z * np.exp(0.5j) for z in assembled(TURN))
    arm = (chapter["bent"] - A) / (B - A) * R3
    np.testing.assert_allclose(arm, (RCX + 1j * RCY) * np.exp(-1j), atol=1e-13)
    assert np.abs(chapter["bent"] - P).max() > 0.5
    assert "bent by -2 theta0 at every angle: True" in chapter["said"]
    assert "|P - A| and |P - B| constant: True" in chapter["said"]


def test_no_drawn_theta4_closes_the_loop(chapter):
    theta2, theta4 = chapter["both"]
    needed = np.abs(R1 + R4 * np.exp(1j * theta4) - R2 * np.exp(1j * theta2))
    np.testing.assert_allclose(chapter["needed"], needed)
    assert np.abs(needed - R3).min() > 0.02


def test_source_d_s_figure_2_has_a_counterpart_with_alt_text():
    told = [
        head
        for head in re.findall(r"```\{code-cell\} ipython3\n---\n(.*?)\n---\n", TEXT, re.DOTALL)
        if "counterpart of source D's Figure 2" in head
    ]
    assert len(told) == 1
    assert re.search(r"^    alt: ", told[0], re.MULTILINE)
