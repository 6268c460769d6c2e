"""Claims of the chapter on uncertainty: what its cells compute, against circles that meet and laws of probability."""

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import sympy as sp
from executed import BOOK, executed

from mechlib.dynamics import inverse_dynamics
from mechlib.motion import Motion
from mechlib.sweep import consecutive
from mechlib.wiper import Wiper

TEXT = (BOOK / "fourbar-monte-carlo.md").read_text("utf-8")
SIX = np.array([1.08913, 0.42259, 0.964444, 0.58781, 0.39137, 0.42950])  # m, source D, table 1
BY_PROGRAM = np.array([1.08913, 0.42255, 0.96444, 0.58781, 0.39137, 0.42950])
HALF = 1e-5
SIGMA = HALF / np.sqrt(3)
PRINTED = np.genfromtxt(BOOK / "data" / "fourbar_published.csv", delimiter=",", skip_header=1)
VERIFIED = np.genfromtxt(BOOK / "data" / "fourbar_verified.csv", delimiter=",", skip_header=1)
ANGLES = PRINTED[:, 0]


@pytest.fixture(scope="module")
def chapter():
    return executed("fourbar-monte-carlo")


def rows(chapter, header):
    """The cells of the table that has this in its first line, without the stars of bold ones."""
    (table,) = (t for t in chapter["tables"] if header in t.splitlines()[0])
    return [[cell.strip(" *") for cell in line.strip("|").split("|")] for line in table.splitlines()[2:]]


def point(lengths, angles=ANGLES):
    """P as a complex number: B where the circles about A and O4 meet, left of A-O4; shapes (n, 6) -> (n, angles)."""
    r1, r2, r3, r4, rcx, rcy = np.atleast_2d(lengths).T[:, :, None]
    A = r2 * np.exp(1j * angles)
    far = np.abs(r1 - A)
    towards = (r1 - A) / far
    B = A + r3 * towards * np.exp(1j * np.arccos((r3**2 + far**2 - r4**2) / (2 * r3 * far)))
    return A + (B - A) / r3 * (rcx + 1j * rcy)


def derivatives(lengths=SIX, angles=ANGLES, h=1e-5):
    """By each length, central differences; shape (angles, 2, 6)."""
    d = (point(lengths + h * np.eye(6), angles) - point(lengths - h * np.eye(6), angles)).T / (2 * h)
    return np.stack((d.real, d.imag), axis=1)


def moments(lengths, half=HALF, of=point, n=100_000):
    """Deviation and kurtosis of x and y from throws of NumPy's own generator; shapes (angles, 2)."""
    p = of(lengths + np.random.default_rng(11).uniform(-half, half, (n, 6)))
    off = np.stack((p.real, p.imag), axis=-1)
    off -= off.mean(axis=0)
    variance = (off**2).mean(axis=0)
    return np.sqrt(variance), (off**4).mean(axis=0) / variance**2


@pytest.fixture(scope="module")
def by_chance():
    return moments(SIX)


def mistaken(thrown, nominal=SIX):
    """A nominal denominator in l3 is the right linkage with another rocker."""
    r1, r2, r3, r4 = thrown.T[:4]
    share = r2 * r3 / (nominal[1] * nominal[2])
    other = thrown.copy()
    other[:, 3] = np.sqrt(r1**2 + r2**2 + r3**2 + (r4**2 - r1**2 - r2**2 - r3**2) * share)
    return point(other)


# --- the failure, and its cause


def test_the_printed_sigma_x_is_up_to_2_9_times_too_large_and_sigma_y_up_to_24_percent_too_small(chapter, by_chance):
    sigma, kurtosis = by_chance
    error = np.sqrt((kurtosis - 1) / 4 * (1 / 1e5 + 1 / 1e6))
    assert (np.abs(chapter["million"].deviation / sigma - 1) < 5 * error).all()
    np.testing.assert_allclose(chapter["million"].deviation, VERIFIED[:, 3:5], rtol=4e-3)
    ratio = PRINTED[:, 3:] / VERIFIED[:, 3:5]
    np.testing.assert_allclose(chapter["ratio"], ratio, rtol=4e-3)
    assert 2.8 < ratio[:, 0].max() < 2.9
    assert 0.235 < 1 - ratio[:, 1].min() < 0.245


def test_chance_moves_a_deviation_of_100_throws_by_some_6_percent(chapter, by_chance):
    _, kurtosis = by_chance
    expected = np.sqrt((kurtosis[0] - 1) / 400)
    np.testing.assert_allclose(chapter["chance"].std(axis=0), expected, rtol=0.08)
    assert (np.abs(expected - 0.06) < 0.005).all()
    assert chapter["chance"].max() < 1.4


def test_a_nominal_denominator_lengthens_the_rocker_by_up_to_56_micrometres(chapter):
    r1, r2, r3, r4, R2, R3 = sp.symbols("r1:5 R2 R3", positive=True)
    other = sp.sqrt(r1**2 + r2**2 + r3**2 + (r4**2 - r1**2 - r2**2 - r3**2) * r2 * r3 / (R2 * R3))
    at_nominal = {R2: r2, R3: r3}
    nominal = r1**2 + r2**2 + r3**2 - r4**2
    as_a_whole = [sp.simplify(other.diff(x).subs(at_nominal) + nominal / (2 * r4 * x)) for x in (r2, r3)]
    assert as_a_whole == [0, 0]  # equation (eq-extra): what the right linkage's rocker does not do
    slope = (SIX[0] ** 2 + SIX[1] ** 2 + SIX[2] ** 2 - SIX[3] ** 2) / (2 * SIX[3])
    corner = HALF * slope * (1 / SIX[1] + 1 / SIX[2])
    assert 56e-6 < corner < 57e-6
    found = np.abs(chapter["too_long"]["nominal"]).max()
    assert 5 * HALF < 0.98 * corner < found < 1.001 * corner
    assert np.abs(chapter["too_long"]["thrown"]).max() < 1e-14


def test_with_the_mistake_the_printed_table_comes_out_within_two_sampling_errors(chapter):
    sigma, kurtosis = moments(SIX, of=mistaken)
    np.testing.assert_allclose(chapter["mistaken"].deviation, sigma, rtol=0.012)
    np.testing.assert_allclose(chapter["predicted"], sigma, rtol=0.01)
    off = (PRINTED[:, 3:] / sigma - 1) / np.sqrt((kurtosis - 1) / 400)
    np.testing.assert_allclose(chapter["in_errors"], off, atol=0.3)
    assert np.abs(off).max() < 2


def test_the_ellipses_are_those_of_the_right_and_of_the_mistaken_cloud(chapter):
    k = chapter["widest"]
    assert f"{ANGLES[k]:.3f}" == "6.223"
    thrown = SIX + np.random.default_rng(12).uniform(-HALF, HALF, (50_000, 6))
    for (_, covariance, _), of in zip(chapter["clouds"], (mistaken, point), strict=True):
        p = of(thrown)[:, k]
        found = np.cov(p.real, p.imag)
        np.testing.assert_allclose(covariance, found, atol=0.03 * np.abs(found).max())
        v = chapter["ellipse"](covariance, 2)
        np.testing.assert_allclose(np.einsum("in,ij,jn->n", v, np.linalg.inv(covariance), v), 4, rtol=1e-9)


# --- throws


def test_a_throw_is_the_same_alone_and_for_any_number_of_workers(chapter):
    assert "the same throw: True" in chapter["said"]
    assert [f"{n} workers, the same bits: True" for n in (1, 2, 3)] == [
        line for line in chapter["said"] if "workers" in line
    ]


def test_the_naive_variance_fails_far_from_the_origin_and_the_merged_one_does_not(chapter):
    told = [line.split("percent: ")[1] for line in chapter["said"] if "right to a percent" in line]
    assert told == [*["textbook True, merged True"] * 2, "textbook False, merged True"]
    spacing = np.spacing(1e5 * 1000.45**2)  # of the sum of squares, and so of what the subtraction leaves
    assert spacing > 2 * 1e5 * SIGMA**2 * 0.99


def test_with_n_the_variance_of_four_throws_is_three_quarters_and_with_n_less_one_it_is_right(chapter):
    told = [float(line.split()[-5]) for line in chapter["said"] if line.startswith("divided by")]
    assert told == pytest.approx([0.75, 1.0], abs=0.015)


def test_only_the_interval_that_asks_the_kurtosis_holds_for_every_law(chapter):
    table = {row[0]: row[1:] for row in rows(chapter, r"by $\kappa$, 800")}
    uniform, p, normal, laplace = table.values()
    assert [row[0] for row in table.values()] == ["1.8", "2.5", "3.0", "4.1"]
    for row in table.values():
        mean, _, few, _, many = (float(cell.rstrip("%")) for cell in row[1:])
        assert abs(mean - 95) < 1.5
        assert 92.5 < few < 96
        assert abs(many - 95) < 2.5
    for column in (2, 4):
        assert float(uniform[column].rstrip("%")) > 99
        assert float(p[column].rstrip("%")) > 96
        assert abs(float(normal[column].rstrip("%")) - 95) < 2.2
        assert float(laplace[column].rstrip("%")) < 90


# --- derivatives


def test_the_derivatives_by_hand_are_differences_of_the_closed_form(chapter):
    np.testing.assert_allclose(chapter["gradient"], derivatives(), atol=1e-8)


def test_linear_propagation_has_the_verified_deviations_to_four_digits(chapter):
    expected = SIGMA * np.sqrt((derivatives() ** 2).sum(axis=-1))
    np.testing.assert_allclose(chapter["spread"].deviation, expected, rtol=1e-7)
    np.testing.assert_allclose(chapter["spread"].deviation, VERIFIED[:, 5:7], rtol=5e-5)


def test_a_common_error_of_the_bars_takes_up_to_29_percent_from_sigma_x(chapter):
    d = derivatives()
    for rho, found in chapter["columns"].items():
        if rho != "throws":
            alone, common = (d**2).sum(axis=-1), d[..., :4].sum(axis=-1) ** 2  # errors of one's own, and a shared one
            own = (1 - rho) * (d[..., :4] ** 2).sum(axis=-1) + (d[..., 4:] ** 2).sum(axis=-1)
            np.testing.assert_allclose(found, SIGMA * np.sqrt(own + rho * common), rtol=1e-6)
            assert rho or np.allclose(own, alone)
    np.testing.assert_allclose(chapter["columns"]["throws"], chapter["columns"][0.9], rtol=0.02)
    change = chapter["columns"][0.9] / chapter["columns"][0] - 1
    assert change[:, 0].min() == pytest.approx(-0.29, abs=0.005)
    assert (change[:, 1] > 0).any()


def test_curvature_moves_the_mean_and_only_where_the_linkage_is_stretched(chapter):
    flat, half = np.array([*ANGLES[[0, 2]], np.pi]), 0.003
    h = 1e-3 * np.eye(6)
    second = (point(SIX + h, flat) - 2 * point(SIX, flat) + point(SIX - h, flat)) / 1e-6
    shift = (half**2 / 6 * second.sum(axis=0)).real
    sigma = half / np.sqrt(3) * np.sqrt((derivatives(angles=flat)[:, 0] ** 2).sum(axis=-1))
    np.testing.assert_allclose(chapter["bent"][3][1], shift / sigma, atol=5e-4)
    wider, moved = chapter["bent"][10]
    assert np.abs((wider[:2], moved[:2])).max() < 0.01
    assert wider[2] > 0.02
    assert moved[2] > 0.05
    assert np.abs(chapter["bent"][0.01]).max() < 1e-3


def test_near_a_dead_point_the_linear_deviation_grows_like_one_over_a_root_and_the_real_one_does_not(chapter):
    r1, r2, r3, r4 = 1.08913, 0.5, 0.964444, 0.58781
    assert chapter["dead"] == pytest.approx(np.arccos((r1**2 + r2**2 - (r3 + r4) ** 2) / (2 * r1 * r2)), rel=1e-12)
    sigma = [float(row[1]) for row in rows(chapter, "from dead point")]
    for before, after in pairwise(sigma[1:4]):
        assert after / before == pytest.approx(np.sqrt(10), rel=0.02)
    ratio, share_open = np.array(list(chapter["near"].values())).T
    assert (np.abs(ratio[:3] - 1) < 0.02).all()
    assert ratio[-1] < 0.5
    assert (share_open[:3] == 0).all()
    assert share_open[-1] == pytest.approx(0.4, abs=0.03)


# --- shares


def test_a_share_is_what_the_variance_loses_without_the_length(chapter):
    turn = np.deg2rad(np.arange(0, 361, 6))
    d = derivatives(angles=turn) ** 2
    np.testing.assert_allclose(chapter["around"].shares, d / d.sum(axis=-1, keepdims=True), atol=1e-7)
    total = d[:-1].sum(axis=(0, 1)) / d[:-1].sum()
    table = rows(chapter, "half the tolerance")
    assert [row[1] for row in table] == [f"{share:.0%}" for share in total]
    sigma = HALF * np.ones(6)
    for k, (_, _, told) in enumerate(table):
        halved = sigma.copy()
        halved[k] /= 2
        change = np.sqrt((d[:-1] @ halved**2).sum() / (d[:-1] @ sigma**2).sum()) - 1
        assert told == f"{100 * change:+.0f} %"
        assert change > -0.1
    assert 100 * total.min() < 9 < 23 < 100 * total.max()
    sigma_x, sigma_y = SIGMA * np.sqrt(d.sum(axis=-1)).T
    assert 5e-6 < min(sigma_x.min(), sigma_y.min())
    assert max(sigma_x.max(), sigma_y.max()) < 12.5e-6
    assert sigma_x.argmax() in (29, 30, 31) and sigma_y.argmax() in (29, 30, 31)  # of sixty, six degrees each


def torque(wiper, theta1):
    """By the fifteen equations."""
    motion = Motion(theta1, theta1, np.full_like(theta1, 35 * 2 * np.pi / 60), np.zeros_like(theta1))
    return inverse_dynamics(wiper, consecutive(wiper, motion, wiper.position(theta1[0]), tol=1e-13)).torque


def test_the_torque_of_the_wiper_and_its_derivatives_are_those_of_the_fifteen_equations(chapter):
    wiper, some, h = Wiper(), np.deg2rad(np.arange(5, 360, 50)), 1e-6
    of_motor = chapter["motor"]
    np.testing.assert_allclose(
        of_motor.values(wiper, some, wiper.position(some))[:, 0], torque(wiper, some), atol=1e-10
    )
    gradient = of_motor.gradient(wiper, some, wiper.position(some))[:, 0]
    for k, name in enumerate(("r0", "r1", "r2", "r3")):
        low, high = (replace(wiper, **{name: getattr(wiper, name) + step}) for step in (-h, h))
        slope = (torque(high, some) - torque(low, some)) / (2 * h)
        np.testing.assert_allclose(gradient[:, k], slope, rtol=1e-5, atol=1e-5)


def test_the_throws_of_the_wiper_agree_and_its_crank_matters_most(chapter):
    thrown, by_slope = chapter["wiper_thrown"].deviation, chapter["of_motor"].deviation[::3]
    assert (np.abs(thrown / by_slope - 1) < 0.05).all()
    shares = chapter["of_motor"].shares[:-1, 0]
    assert (shares.argmax(axis=1) == 1).mean() > 0.5
    assert shares[240 // 10].argmax() == 3
    assert 0.0007 < chapter["of_motor"].deviation.min() < 0.0012
    assert chapter["of_motor"].deviation[:, 0].argmax() in (0, 36)
    assert 0.007 < chapter["of_motor"].deviation.max() < 0.008


# --- rates


def test_monte_carlo_converges_like_a_root_and_even_points_about_like_their_number(chapter):
    assert chapter["rates"]["Monte Carlo"] == pytest.approx(-0.5, abs=0.06)
    assert -1.6 < chapter["rates"]["Sobol"] < -0.95
    assert "means of Sobol's sets: apart by less than 1e-6: True" in chapter["said"]


def test_even_points_have_the_deviation_of_the_derivatives_within_their_interval(chapter):
    exact = SIGMA * np.sqrt((derivatives(angles=ANGLES[:1])[0] ** 2).sum(axis=-1))
    low, high = chapter["quasi_monte_carlo"](chapter["at_first"], chapter["law"], 4096, seed=1).deviation_interval()
    middle, half = (low + high) / 2, (high - low) / 2
    assert (np.abs(middle - exact) < 2 * half).all()
    assert (half < 1 / 4096 / 4 * exact).all()  # sure enough to see a divisor of n - 1


# --- what opens, and what is rare


def test_the_throws_that_open_are_too_short_and_as_many_as_the_law_says(chapter):
    room = SIX[2] + SIX[3] - SIX[0] - SIX[1]
    for mm in (10, 12, 15, 20, 40):
        grid, step = np.linspace(-1, 1, 2001, retstep=True)
        box = np.full(len(grid), 1.0)
        box[[0, -1]] = 0.5
        box /= box.sum()
        law = np.convolve(np.convolve(box, box), np.convolve(box, box))
        errors = step * (np.arange(len(law)) - len(law) // 2) * mm / 1000
        chance = law[errors > room].sum()
        assert chapter["chance_open"](mm / 1000) == pytest.approx(chance, rel=0.02, abs=1e-12)
        assert abs(chapter["counted"][mm] - 1e5 * chance) < 5 * np.sqrt(1e5 * chance + 1)
    assert 0.9e-6 < chapter["chance_open"](0.0105) < 1.1e-6
    for number, *lengths, short in rows(chapter, "too short by"):
        r1, r2, r3, r4 = map(float, lengths)
        assert int(number) in chapter["opened"].first
        assert float(short) == pytest.approx(r1 + r2 - r3 - r4, abs=0.21)
        assert float(short) > 0
    others, linear = map(float, rows(chapter, "of the others")[-1][3:])
    assert others < linear


# --- the source


def test_the_means_are_those_of_the_programs_lengths_and_the_deviations_those_of_the_mistake(chapter):
    means = rows(chapter, "mean, D (m)")
    assert [row[-1] for row in means].count("agrees") == 18
    assert [row[-1] for row in means].count("agrees, to 3 digits") == 2
    exact = point(BY_PROGRAM)[0]
    here = np.array([float(row[3]) for row in means]).reshape(10, 2)
    np.testing.assert_allclose(here, np.stack((exact.real, exact.imag), axis=1), atol=2e-7)
    verdicts = [(row[4], row[6]) for row in rows(chapter, "with the mistake")]
    assert all(said == "agrees" for _, said in verdicts)
    assert all(said == "differs" for said, _ in verdicts[::2])  # every sigma_x


def test_the_printed_means_need_the_lengths_of_the_program():
    sharp = np.delete(PRINTED[:, 1] + 1j * PRINTED[:, 2], [3, 8])
    by_table, by_program = (np.abs(np.delete(point(six)[0], [3, 8]) - sharp).max() for six in (SIX, BY_PROGRAM))
    assert by_program < 3.4e-6 < 40e-6 < by_table


def test_the_captions_of_the_source_cut_the_angles_off(chapter):
    for row, angle in zip(rows(chapter, "its caption"), ANGLES, strict=True):
        assert row[2] == f"{np.floor(100 * angle) / 100:.2f}"
        assert (row[3] == "agrees") == (row[2] == f"{angle:.2f}")


def test_the_mistake_of_source_d_stands_in_a_box_of_its_own():
    """D1."""
    boxes = re.findall(r":::\{admonition\} (Source D.*?)\n:class: warning", TEXT)
    assert len([box for box in boxes if "listing, l3" in box]) == len(boxes) == 1


@pytest.mark.parametrize("figure", ["figure 2", "figures 3 to 12"])
def test_a_figure_of_source_d_has_a_counterpart_with_alt_text(figure):
    heads = re.findall(r"```\{code-cell\} ipython3\n---\n(.*?)\n---\n", TEXT, re.DOTALL)
    (told,) = (head for head in heads if f"Counterpart of source D, {figure}." in head)
    assert re.search(r"^    name: fig-", told, re.MULTILINE)
    assert re.search(r"^    alt: ", told, re.MULTILINE)
