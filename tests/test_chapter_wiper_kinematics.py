"""Claims of the chapter on the wiper's kinematics: what its cells compute, against complex numbers and triangles."""

import re

import numpy as np
import pytest
from executed import BOOK, executed, rows

TEXT = (BOOK / "wiper-kinematics.md").read_text("utf-8")
R0, R1, R2, R3, R4, R5, R6 = 0.245, 0.105, 0.220, 0.150, 0.300, 0.300, 0.645  # m, source B
OMEGA = 35 * 2 * np.pi / 60
DEGREE = np.deg2rad(1)


@pytest.fixture(scope="module")
def chapter():
    return executed("wiper-kinematics")


def assembled(crank, r0=R0, r1=R1, r2=R2, r3=R3, side=1):
    """Angles of coupler and rocker: B where the circles about A and C meet, left of A-C or (side -1) right of it."""
    A = r1 * np.exp(1j * np.asarray(crank))
    far = np.abs(r0 - A)
    B = A + r2 * (r0 - A) / far * np.exp(side * 1j * np.arccos((r2**2 + far**2 - r3**2) / (2 * r2 * far)))
    return np.angle(B - A), np.angle(B - r0)


def by_series(crank):
    """theta3 and its first two derivatives in time, by the Fourier series of a smooth periodic function."""
    n = 512
    grid = np.linspace(0, 2 * np.pi, n, endpoint=False)
    c = np.fft.rfft(assembled(grid)[1]) / n
    c[1:] *= 2
    k = np.arange(len(c))
    waves = np.exp(1j * np.outer(np.asarray(crank), k))
    return [((waves * (1j * k * OMEGA) ** order) @ c).real for order in range(3)]


# --- the failure, and the rule


def test_the_longer_crank_jams_before_half_a_turn_though_five_positions_a_fifth_apart_close(chapter):
    border = np.arccos((R0**2 + 0.130**2 - (R2 + R3) ** 2) / (2 * R0 * 0.130))  # coupler and rocker stretched
    assert 160 * DEGREE < border < 161 * DEGREE
    left_open = np.flatnonzero(chapter["bad"])
    assert (left_open == np.arange(161, 200)).all()
    assert not set(range(0, 360, 72)) & set(left_open)
    assert R0 + 0.130 - (R2 + R3) == pytest.approx(0.005)


def test_the_crank_turns_round_if_the_rule_holds_and_the_shortest_bar_is_crank_or_frame():
    """A million linkages, without ties; equation (eq-turns) is the triangle inequality at both ends of A's distance."""
    bars = np.random.default_rng(0).uniform(0.1, 1, (1_000_000, 4))
    r0, r1, r2, r3 = bars.T
    turns = (r0 + r1 <= r2 + r3) & (np.abs(r0 - r1) >= np.abs(r2 - r3))
    rule = bars.min(axis=1) + bars.max(axis=1) <= bars.sum(axis=1) / 2
    assert (turns == (rule & (bars.argmin(axis=1) <= 1))).all()
    three = (r1 + r0 <= r2 + r3) & (r1 + r2 <= r0 + r3) & (r1 + r3 <= r0 + r2)
    assert (turns[r1 < r0] == three[r1 < r0]).all()


def share(r0, r1, r2, r3):
    """Of 360 crank angles, how many leave a triangle A B C."""
    far = np.abs(r0 - r1 * np.exp(1j * DEGREE * np.arange(360)))
    return np.sum((far <= r2 + r3 + 1e-9) & (far >= abs(r2 - r3) - 1e-9))


def test_the_table_of_classes_says_what_the_bars_can_do(chapter):
    table = rows(chapter, "bars")
    assert [row[-1] for row in table] == [
        "crank-rocker", "rocker-crank", "double-crank", "double-rocker", "triple-rocker", "change-point",
    ]  # fmt: skip
    for _, mm, shortest_longest, others, crank, rocker, _ in table:
        r0, r1, r2, r3 = bars = [int(each) for each in mm.split(", ")]
        assert (int(shortest_longest), int(others)) == (min(bars) + max(bars), sum(bars) - min(bars) - max(bars))
        for said, computed in ((crank, share(r0, r1, r2, r3)), (rocker, share(r0, r3, r2, r1))):
            assert said == ("round" if computed == 360 else f"{computed}°")


def test_the_random_linkages_do_not_contradict_the_rule(chapter):
    assert chapter["contradictions"] == 0
    assert sum(chapter["counted"].values()) == 500
    assert min(n for kind, n in chapter["counted"].items() if kind != "change-point") > 20


def test_a_grashof_linkage_whose_crank_turns_round_never_has_coupler_and_rocker_in_line():
    """The sine of the angle at B stays away from zero, at either end of A's distance and so in between."""
    r0, r1, r2, r3 = np.random.default_rng(1).uniform(0.1, 1, (100_000, 4)).T
    turns = (r0 + r1 < r2 + r3) & (np.abs(r0 - r1) > np.abs(r2 - r3))
    for far in (r0 + r1, np.abs(r0 - r1)):
        assert (np.abs(r2**2 + r3**2 - far**2)[turns] < (2 * r2 * r3)[turns]).all()


# --- positions


def test_the_closed_form_is_where_two_circles_meet(chapter):
    crank = DEGREE * np.arange(361)
    for name, side in ((-1, 1), (1, -1)):
        q = np.stack(assembled(crank, side=side), axis=-1)
        np.testing.assert_allclose(np.exp(1j * chapter["assembled"](crank, name)), np.exp(1j * q), atol=1e-13)


def test_what_each_seed_costs_and_finds(chapter):
    table = {row[0]: row[1:] for row in rows(chapter, "seed")}
    assert table["source B's seed"] == ["1662", "3 to 5", "361", "0", "0"]
    warm = table["each from the one before"]
    assert warm[2:] == ["361", "0", "0"]
    assert 2 * int(warm[0]) < 1662
    inside, mirrored = table["30°, 150°"], table["−55°, −125°"]
    assert all(int(n) > 0 for n in inside[2:])
    assert mirrored == ["1662", "3 to 5", "0", "361", "0"]
    low, high = chapter["built"].min(axis=0), chapter["built"].max(axis=0)
    assert (low < np.deg2rad([30, 150])).all() and (np.deg2rad([30, 150]) < high).all()
    upper, lower = (np.exp(1j * np.stack(assembled(DEGREE * np.arange(361), side=s), axis=-1)) for s in (1, -1))
    found = np.exp(1j * chapter["runs"]["30°, 150°"][0])
    counts = [np.sum(np.abs(found - each).max(axis=1) < 1e-6) for each in (upper, lower)]
    assert [str(n) for n in counts] == inside[2:4]


def test_the_end_positions_are_the_extremes_of_a_fine_grid(chapter):
    fine = np.linspace(0, 2 * np.pi, 1_000_001)
    theta3 = assembled(fine)[1]
    for (crank, angle), k in ((chapter["far"], theta3.argmin()), (chapter["near"], theta3.argmax())):
        assert angle == pytest.approx(theta3[k], abs=1e-10)
        assert crank == pytest.approx(fine[k], abs=1e-4)  # a flat extreme
    grid = theta3[:: len(fine) // 360]
    assert np.rad2deg(max(grid.min() - theta3.min(), theta3.max() - grid.max())) < 1e-3
    forth = np.rad2deg(chapter["near"][0] - chapter["far"][0])
    assert 179.5 < forth < 180


# --- rates, points


def test_rates_and_points_are_derivatives_of_the_geometry(chapter):
    theta3, omega3, alpha3 = by_series(DEGREE * np.arange(361))
    np.testing.assert_allclose(chapter["v"][:, 1], omega3, atol=1e-10)
    np.testing.assert_allclose(chapter["a"][:, 1], alpha3, atol=1e-8)
    for name, start, r in (("B", R0, R3), ("D", R0, R4), ("E", R0 + R5, R4), ("G", R0, R6), ("H", R0 + R5, R6)):
        z = r * np.exp(1j * theta3)
        expected = start + z, 1j * omega3 * z, (1j * alpha3 - omega3**2) * z
        for what, vector in zip(("position", "velocity", "acceleration"), expected, strict=True):
            found = getattr(chapter["at"][name], what) @ (1, 1j)
            np.testing.assert_allclose(found, vector, atol=1e-8, err_msg=f"{what} of {name}")


def test_the_extremes_are_where_texts_and_captions_say(chapter):
    _, omega3, alpha3 = by_series(DEGREE * np.arange(361))
    speed, acceleration = R6 * np.abs(omega3), R6 * np.hypot(alpha3, omega3**2)
    assert (speed.argmax(), acceleration.argmax()) == (341, 11)
    assert round(speed.max(), 1) == 2.4
    assert (speed[26:206].argmax() + 26, round(speed[26:206].max(), 1)) == (112, 1.7)
    assert (omega3.argmax(), omega3.argmin()) == (112, 341)
    assert abs(np.abs(alpha3[100:300]).argmax() + 100 - 180) < 3
    table = {row[0]: row[1:] for row in rows(chapter, "of point")}
    assert table["$G$"] == table["$H$"] == ["2.3569", "341°", "15.4034", "11°"]
    assert table["$D$"] == table["$E$"]
    assert table["$A$"][0] == f"{R1 * OMEGA:.4f}"
    assert table["$A$"][2] == f"{R1 * OMEGA**2:.4f}"


def test_at_an_end_position_a_blade_stands_still_and_accelerates_across_itself(chapter):
    for crank, _ in (chapter["far"], chapter["near"]):
        _, omega3, alpha3 = by_series([crank])
        assert abs(omega3[0]) < 1e-9 < 1 < abs(alpha3[0])


def test_the_transmission_angle_is_least_where_the_crank_is_in_line_with_the_frame(chapter):
    least = [np.arccos(abs(R2**2 + R3**2 - far**2) / (2 * R2 * R3)) for far in (R0 - R1, R0 + R1)]
    np.testing.assert_allclose(chapter["mu"][[0, 180]], np.rad2deg(least), rtol=1e-12)
    assert chapter["mu"].min() == pytest.approx(np.rad2deg(min(least)), rel=1e-12)
    assert max(np.rad2deg(least)) < 40
    right_angle = np.arccos((R0**2 + R1**2 - R2**2 - R3**2) / (2 * R0 * R1))  # A C is the hypotenuse
    assert 0 < right_angle < np.pi  # and once more on the way back: 90 degrees twice in a turn


# --- the wiped area, and its price


def test_the_wiped_areas_are_those_of_a_raster(chapter):
    low, high = chapter["far"][1], chapter["near"][1]
    side = 1000
    x, dx = np.linspace(-R6, R5 + R6, 2 * side, endpoint=False, retstep=True)
    y, dy = np.linspace(0, R6, side, endpoint=False, retstep=True)
    z = (x + dx / 2) + 1j * (y + dy / 2)[:, None]
    first, second = ((np.abs(p) < R6) & (np.angle(p) > low) & (np.angle(p) < high) for p in (z, z - R5))
    for computed, hit in ((chapter["one"], first), (chapter["both"], first | second)):
        assert computed == pytest.approx(hit.sum() * dx * dy, rel=1e-3)
    assert 2 * chapter["one"] - chapter["both"] == pytest.approx((first & second).sum() * dx * dy, rel=1e-3)
    assert chapter["one"] == pytest.approx(chapter["sector"], rel=1e-6)


def test_a_longer_crank_sweeps_wider_and_drives_worse(chapter):
    table = rows(chapter, "crank (mm)")
    sweeps, least = {}, {}
    for mm, kind, sweep, _, mu in table:
        r1 = int(mm) / 1000
        assert kind == ("crank-rocker" if r1 < 0.125 else "change-point" if r1 == 0.125 else "triple-rocker")
        if kind == "crank-rocker":
            theta3 = assembled(np.linspace(0, 2 * np.pi, 36_001), r1=r1)[1]
            sweeps[int(mm)] = np.rad2deg(np.ptp(theta3))
            cosines = [(R2**2 + R3**2 - far**2) / (2 * R2 * R3) for far in (R0 - r1, R0 + r1)]
            least[int(mm)] = np.rad2deg(np.arccos(np.abs(cosines).max()))
            assert (sweep, mu) == (f"{sweeps[int(mm)]:.1f}°", f"{least[int(mm)]:.1f}°")
    assert sweeps[105] - sweeps[95] == pytest.approx(10, abs=0.5)
    assert sweeps[115] - sweeps[105] == pytest.approx(11.5, abs=0.5)
    falls = -np.diff([least[mm] for mm in (95, 105, 115)])
    assert falls[1] > falls[0] > 0
    assert R0 + 0.125 == pytest.approx(R2 + R3)  # nothing left: coupler and rocker in line


# --- the checks, and the source


def test_only_the_coupler_gives_the_forgotten_term_away(chapter):
    assert (chapter["not_rigid"](chapter["at"]) < 1e-12).all()
    wrong = {name: chapter["trace"](chapter["wiper"], chapter["wrong"], name) for name in "OABCDEFGH"}
    for pair in chapter["lengths"]:
        d, dd, ddd = (
            getattr(wrong[pair[1]], what) - getattr(wrong[pair[0]], what)
            for what in ("position", "velocity", "acceleration")
        )
        off = np.abs(np.sum(d * ddd + dd * dd, axis=1)).max()
        assert (off > 0.1) == (pair == "AB")


def test_differences_of_the_positions_converge_with_order_two(chapter):
    np.testing.assert_allclose(chapter["order"], 2, atol=0.02)


def test_the_numbers_behind_the_plots_to_the_verified_digits(chapter):
    table = {row[0]: row[1:] for row in rows(chapter, "quantity")}
    source = [table[name][0] for name in table]
    assert source == [
        "3 to 5", "1662", "9.244160602", "66.259135816", "71.682304059", "160.536790827", "2.3569008807",
        "15.4033537305",
    ]  # fmt: skip
    crank = DEGREE * np.arange(361)
    theta2, theta3 = map(np.rad2deg, assembled(crank))
    _, omega3, alpha3 = by_series(crank)
    angles = [theta2.min(), theta2.max(), theta3.min(), theta3.max()]
    exact = [float(row[1]) for row in table.values() if row[1]]
    np.testing.assert_allclose(exact[:4], angles, atol=6e-10)
    np.testing.assert_allclose(
        exact[4:], [R6 * np.abs(omega3).max(), R6 * np.hypot(alpha3, omega3**2).max()], rtol=1e-9
    )


def test_the_listings_say_what_the_geometry_says(chapter):
    """The printed systems in numbers, with rates that satisfy r1'' + r2'' = r3'' as complex vectors."""
    assert [row[2] for row in rows(chapter, "source B")] == ["agrees"] * 7
    rng = np.random.default_rng(3)
    th1, th2, th3, w1, w2, w3, al1 = rng.uniform(-2, 2, 7)
    A = np.array([[-R2 * np.sin(th2), R3 * np.sin(th3)], [-R2 * np.cos(th2), R3 * np.cos(th3)]])
    values = dict(zip(chapter["closure"].parameters, (R0, R1, R2, R3), strict=True))
    values |= dict(zip((chapter["th1"], chapter["th2"], chapter["th3"]), (th1, th2, th3), strict=True))
    values |= dict(zip((chapter["w1"], chapter["w2"], chapter["w3"], chapter["al1"]), (w1, w2, w3, al1), strict=True))

    def number(name):
        return np.array(chapter[name].subs(values), dtype=float)

    np.testing.assert_allclose(number("A_printed"), A, atol=1e-14)
    w2_, w3_ = np.linalg.solve(A, number("B_velocity")[:, 0])
    turned = 1j * (w1 * R1 * np.exp(1j * th1) + w2_ * R2 * np.exp(1j * th2) - w3_ * R3 * np.exp(1j * th3))
    assert abs(turned) < 1e-13
    al2, al3 = np.linalg.solve(A, number("B_acceleration")[:, 0])
    bars = ((R1, th1, w1, al1), (R2, th2, w2, al2), (-R3, th3, w3, al3))
    assert abs(sum(r * (1j * al - w**2) * np.exp(1j * th) for r, th, w, al in bars)) < 1e-13


def test_b11_source_b_s_test_lets_linkages_pass_whose_crank_does_not_turn(chapter):
    verdicts = {kind: (test, turns) for kind, test, turns in rows(chapter, "linkage")}
    assert [kind for kind, pair in verdicts.items() if pair == ("goes on", "no")] == ["rocker-crank", "double-rocker"]


@pytest.mark.parametrize("figure", ["the trajectories", "the speed of $H$", "the acceleration of $G$"])
def test_a_figure_of_source_b_has_a_counterpart_with_alt_text(figure):
    told = [
        head
        for head in re.findall(r"```\{code-cell\} ipython3\n---\n(.*?)\n---\n", TEXT, re.DOTALL)
        if f"counterpart of source B's figure of {figure}" in head
    ]
    assert len(told) == 1
    assert re.search(r"^    name: fig-", told[0], re.MULTILINE)
    assert re.search(r"^    alt: ", told[0], re.MULTILINE)
