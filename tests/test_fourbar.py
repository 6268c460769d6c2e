"""The four-bar linkage of source D: its verified table, and oracles that share nothing with its closed form."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mechlib.closure import OpenLoopError
from mechlib.dynamics import trace
from mechlib.fourbar import LENGTHS, FourBar
from mechlib.grashof import grashof
from mechlib.motion import Motion
from mechlib.sweep import consecutive

TABLE = np.loadtxt(Path(__file__).parents[1] / "book" / "data" / "fourbar_verified.csv", delimiter=",", skiprows=1)
THETA2 = TABLE[:, 0]
TURN = np.linspace(-np.pi, np.pi, 73)
BRANCHES = "open", "crossed"
length = st.floats(0.05, 5)


@pytest.fixture
def linkage():
    return FourBar()


def joints(linkage, theta2, branch):
    """A, B and P as complex numbers, from the angles alone."""
    th3, th4 = np.moveaxis(linkage.position(theta2, branch), -1, 0)
    A, e3 = linkage.r2 * np.exp(1j * theta2), np.exp(1j * th3)
    return A, linkage.r1 + linkage.r4 * np.exp(1j * th4), A + (linkage.rcx + 1j * linkage.rcy) * e3, A + linkage.r3 * e3


def test_source_d_coupler_points_are_those_of_the_verified_table(linkage):
    np.testing.assert_allclose(linkage.coupler_point(THETA2), TABLE[:, 1:3], atol=5e-8)  # six errors of its mean


def test_the_formulas_of_source_d_are_the_open_branch(linkage):
    r1, r2, r3, r4 = linkage.r1, linkage.r2, linkage.r3, linkage.r4
    l1, l2, l3 = r1 / r2, r1 / r3, (r4**2 - r1**2 - r2**2 - r3**2) / (2 * r2 * r3)
    c, kb = np.cos(TURN), -2 * np.sin(TURN)
    ka, kc = c - l1 + l2 * c + l3, l1 + (l2 - 1) * c + l3
    root = np.sqrt(kb**2 - 4 * ka * kc)
    for branch, sign in (("open", -1), ("crossed", 1)):
        th3 = 2 * np.arctan2(-kb + sign * root, 2 * ka)
        apart = np.exp(1j * (th3 - linkage.position(TURN, branch)[:, 0]))
        np.testing.assert_allclose(apart, 1, atol=1e-13)


@pytest.mark.parametrize("branch", BRANCHES)
def test_newton_raphson_on_the_closure_finds_the_closed_form(linkage, branch):
    motion = Motion(TURN, TURN, np.ones_like(TURN), np.zeros_like(TURN))
    found = consecutive(linkage, motion, linkage.position(TURN[0], branch) + 0.05, tol=1e-12)
    np.testing.assert_allclose(np.exp(1j * found.position), np.exp(1j * linkage.position(TURN, branch)), atol=1e-13)
    assert set(linkage.branch(found.position)) == {branch}


@given(length, length, length, length, st.floats(-7, 7), st.sampled_from(BRANCHES))
def test_every_closed_position_has_rigid_bars_on_its_side_and_an_open_one_no_number(r1, r2, r3, r4, theta2, branch):
    linkage = FourBar(r1, r2, r3, r4)
    gap = linkage.gap(theta2)
    assume(abs(gap) > 1e-9)
    if gap > 0:
        with pytest.raises(OpenLoopError, match="theta_2"):
            linkage.coupler_point(theta2, branch)
        assert np.isnan(linkage.coupler_point(theta2, branch, "leave out")).all()
        assert np.isnan(linkage.position(theta2, branch, "leave out")).all()
        return
    A, B, P, along = joints(linkage, theta2, branch)
    scale = max(r1, r2, r3, r4)
    square = abs(r1 - A) ** 2
    assume(square > 1e-3 * scale**2)  # where A meets O4 every direction of the rocker closes the loop
    assert abs(along - B) < 1e-12 * scale**3 / square
    assert complex(*linkage.coupler_point(theta2, branch)) == pytest.approx(P, abs=1e-12 * scale)
    left = ((r1 - A).conjugate() * (B - A)).imag
    assume(abs(left) > 1e-6 * scale**2)
    assert (left > 0) == (branch == "open")
    assert linkage.branch(linkage.position(theta2, branch)) == branch


def test_p_is_fixed_on_the_coupler_and_the_frame_only_turns_and_shifts_it(linkage):
    A, B, P, _ = joints(linkage, TURN, "open")
    assert np.abs(np.abs(P - A) - np.hypot(linkage.rcx, linkage.rcy)).max() < 1e-14
    np.testing.assert_allclose((P - A) / (B - A) * linkage.r3, linkage.rcx + 1j * linkage.rcy, atol=1e-13)
    moved = replace(linkage, x0=0.3, y0=-0.2, theta0=0.7).coupler_point(TURN)
    np.testing.assert_allclose(moved @ [1, 1j], 0.3 - 0.2j + P * np.exp(0.7j), atol=1e-14)


def test_the_coupler_point_moves_at_the_rate_of_its_curve(linkage):
    n = 256
    turn = np.arange(n) * 2 * np.pi / n
    turned = replace(linkage, theta0=0.4, x0=1.0)
    sweep = consecutive(turned, Motion(turn, turn, np.ones(n), np.zeros(n)), turned.position(0.0), tol=1e-13)
    path = trace(turned, sweep, "P")
    np.testing.assert_allclose(path.position, turned.coupler_point(turn), atol=1e-14)
    modes = 1j * np.fft.fftfreq(n, 1 / n)
    curve = np.fft.fft(turned.coupler_point(turn) @ [1, 1j])
    np.testing.assert_allclose(path.velocity @ [1, 1j], np.fft.ifft(modes * curve), atol=1e-11)
    np.testing.assert_allclose(path.acceleration @ [1, 1j], np.fft.ifft(modes**2 * curve), atol=1e-9)


@pytest.mark.parametrize("names", [LENGTHS, *((name,) for name in LENGTHS)])
def test_many_linkages_at_once_are_each_of_them_alone(linkage, names):
    rng = np.random.default_rng(10)
    lengths = {name: getattr(linkage, name) * (1 + 0.01 * rng.standard_normal(7)) for name in names}
    together = replace(linkage, **lengths).coupler_point(THETA2[:, None])
    for k in range(7):
        alone = replace(linkage, **{name: values[k] for name, values in lengths.items()})
        np.testing.assert_allclose(together[:, k], alone.coupler_point(THETA2), atol=1e-15)


@given(length, length, length, length)
def test_a_crank_turns_round_where_grashof_says_and_stops_at_its_dead_points_elsewhere(r1, r2, r3, r4):
    bars = sorted((r1, r2, r3, r4))
    excess = bars[0] + bars[3] - bars[1] - bars[2]
    assume(bars[3] < sum(bars[:3]) and abs(excess) > 1e-6)
    linkage = FourBar(r1, r2, r3, r4)
    turns_round = grashof(r1, r2, r3, r4) in ("crank-rocker", "double-crank")
    assert len(linkage.dead_points()) == 0 if turns_round else len(linkage.dead_points()) in (2, 4)
    for theta2 in linkage.dead_points():
        assert abs(linkage.gap(theta2)) < 1e-12
        assert np.prod(np.sign(linkage.gap(theta2 + np.array([-1e-7, 1e-7])))) == -1


def test_at_the_dead_points_of_the_rocker_it_turns_back(linkage):
    assert linkage.grashof == "crank-rocker"
    still = linkage.dead_points("rocker")
    assert len(still) == 4
    for branch, of_branch in (("open", still[[0, 2]]), ("crossed", still[[1, 3]])):
        q = linkage.position(of_branch, branch)
        assert np.abs(linkage.loop.velocity(q, of_branch, np.ones(2))[:, 1]).max() < 1e-14
        around = linkage.position(of_branch[:, None] + [-1e-3, 0, 1e-3], branch)[..., 1]
        assert (np.sign(np.diff(around, axis=1)).sum(axis=1) == 0).all()


def test_the_transmission_angle_is_the_one_between_coupler_and_rocker(linkage):
    A, B, *_ = joints(linkage, TURN, "open")
    cosine = ((B - A) * (B - linkage.r1).conjugate()).real / (linkage.r3 * linkage.r4)
    angle = linkage.transmission_angle(linkage.position(TURN))
    np.testing.assert_allclose(np.cos(angle), np.abs(cosine), atol=1e-13)
    assert angle.max() <= np.pi / 2


@pytest.mark.parametrize(
    ("bad", "sentence"),
    [
        ({"r2": -0.4}, "r2 must be a positive number, got -0.4"),
        ({"r3": np.nan}, "r3 must be a positive number, got nan"),
        ({"r1": np.array([1.0, 0.0])}, "r1 must be a positive number, got 0.0 at index 1"),
        ({"rcy": np.inf}, "rcy must be finite, got inf"),
    ],
)
def test_a_length_that_cannot_be_is_named(bad, sentence):
    with pytest.raises(ValueError, match=sentence):
        FourBar(**bad)


def test_a_linkage_that_cannot_close_says_where_and_by_how_much():
    with pytest.raises(OpenLoopError, match=r"theta_2 = 0: 0.1 m are missing"):
        FourBar(r1=1.0, r2=0.4, r3=0.2, r4=0.3).position(0.0)


def test_where_a_meets_o4_no_direction_of_the_rocker_is_determined():
    rhombus = FourBar(r1=1.0, r2=1.0, r3=0.5, r4=0.5)
    with pytest.raises(ZeroDivisionError, match="A lies on O4 at point 1"):
        rhombus.position([0.1, 0.0])
    assert np.isnan(rhombus.position([0.1, 0.0], open_points="leave out")).any(axis=-1).tolist() == [False, True]
