"""What source B gets wrong about the wiper (B1 to B9, B12), proven without mechlib."""

import numpy as np
import pytest
from wiper_by_hand import (
    BARS,
    R0,
    R1,
    R2,
    R3,
    R4,
    R5,
    RUBBING,
    STRAIGHT_ON,
    Bars,
    G,
    cross,
    friction,
    friction_as_printed,
    imbalances,
    motion,
    places,
    rate,
    reactions,
    span,
    torque_by_power,
    turned,
)


@pytest.fixture(scope="module")
def right():
    return reactions()


# --- the instrument itself


def test_the_loop_is_closed_and_its_rates_are_derivatives_of_its_angles():
    (th1, *_), coupler, blade = motion()
    closed = turned(turned(0, R1, th1), R2, coupler[0]) - turned(R0, R3, blade[0])
    assert abs(closed).max() < 1e-15
    for angle, omega, alpha in (coupler, blade):
        np.testing.assert_allclose(rate(angle), omega, atol=1e-11)
        np.testing.assert_allclose(rate(omega), alpha, atol=1e-10)


@pytest.mark.parametrize(
    ("rub", "torque"),
    [(friction, [-0.7824455265, 4.5923100587]), (lambda *blade: 0 * friction(*blade), [-2.1396116335, 2.3845747939])],
    ids=["friction", "no friction"],
)
def test_without_mistakes_both_witnesses_are_content(rub, torque):
    found = reactions(rub=rub)
    assert span(found["M"]) == pytest.approx(torque, abs=2e-8)
    assert abs(found["M"] - torque_by_power(rub=rub)).max() < 1e-10
    assert imbalances(found, rub=rub).max() < 1e-9


def test_the_largest_forces_at_e(right):
    assert abs(right["E"].real).max() == pytest.approx(32.24432821, abs=2e-8)
    assert abs(right["E"].imag).max() == pytest.approx(1.50472315, abs=2e-8)


# --- the mistakes


def test_b1_an_arm_of_r5_doubles_e_y_and_leaves_the_torque_as_it_is(right):
    printed = reactions(arm5=R5)
    np.testing.assert_allclose(printed["E"].imag, 2 * right["E"].imag, rtol=1e-14)
    assert abs(printed["E"].imag).max() == pytest.approx(3.0094, abs=5e-5)
    assert abs(printed["E"].real).max() == pytest.approx(36.239, abs=5e-4)
    assert abs(printed["M"] - right["M"]).max() < 1e-13
    assert abs(printed["M"] - torque_by_power()).max() < 1e-10


def test_b1_is_seen_by_the_moments_of_bar_5_about_its_own_centre_and_by_nothing_else(right):
    left = imbalances(reactions(arm5=R5))
    assert np.argwhere(left > 1e-9).tolist() == [[4, 1]]
    m5 = BARS.m[4]
    a_y = rate(rate(places()[1][4])).imag
    np.testing.assert_allclose(right["E"].imag, m5 * (G + a_y) / 2, atol=1e-10)


def test_b1_forces_along_the_chain_that_do_no_work_are_free_in_a_power_balance(right):
    """D, E, F and C change, B and A do not: what is added at D and E moves with one velocity and adds up to nothing."""
    printed = reactions(arm5=R5)
    joints, *_ = places()
    np.testing.assert_allclose(rate(joints["D"]), rate(joints["E"]), atol=1e-12)
    changed = {j for j in "OABCDEF" if abs(printed[j] - right[j]).max() > 1e-9}
    assert changed == set("CDEF")
    np.testing.assert_allclose(printed["D"] - right["D"], printed["E"] - right["E"], atol=1e-13)
    assert abs(cross(joints["D"] - R0, printed["D"] - right["D"])).max() < 1e-13  # along the blade


def test_b2_the_acceleration_of_b_instead_of_d_breaks_the_power_balance_by_up_to_0_157016(right):
    printed = reactions(g5_on=R3)
    assert abs(printed["M"] - torque_by_power()).max() == pytest.approx(0.157016, abs=5e-7)
    left = imbalances(printed)
    assert {int(k) for k in np.argwhere(left > 1e-9)[:, 0]} == {4}
    d_to_g5 = places()[1][4] - places()[0]["D"]
    np.testing.assert_allclose(d_to_g5, BARS.rg[4], atol=1e-15)  # G5 is D and a constant: its acceleration is that of D


def test_b3_the_printed_friction_has_neither_the_size_nor_the_direction():
    blade = motion()[2]
    printed, right = friction_as_printed(*blade), friction(*blade)
    assert span(abs(printed)) == pytest.approx([7.11, 7.36], abs=5e-3)
    assert span(abs(right)) == pytest.approx([4.5, 4.5], abs=1e-14)
    away = np.rad2deg(np.angle(printed / right))
    assert 39 < abs(away).max() < np.rad2deg(np.arctan2(4.5, 5.5))  # the end of that range is at a blade upright


def test_b4_with_the_blades_exchanged_the_torque_is_the_same_and_the_reactions_are_not(right):
    def exchanged(triple):
        return tuple(triple[k] for k in (0, 1, 3, 2, 4)[: len(triple)])

    table = Bars(exchanged(BARS.m), exchanged(BARS.rg), exchanged(BARS.i))
    assert table.m[2:4] == (0.43758, 0.43452)
    assert table.rg[2:4] == (0.28949, 0.29047)
    other = reactions(table)
    assert abs(other["M"] - right["M"]).max() < 1e-13
    off = {j: abs(other[j] - right[j]).max() for j in "OABCDEF"}
    assert max(off[j] for j in "OAB") < 1e-12
    assert min(off[j] for j in "CDEF") > 1e-3


def test_b4_and_b6_the_table_of_steiner_and_the_moments_of_the_program():
    """g mm^2.  The program has the end for bars 1 to 4, 3 and 4 the other way round, and the centre for bar 5."""
    rows = (
        (101211.52, 88.21, 52.5, 344340.3325),
        (783941.91, 177.73, 110.0, 2934474.91),
        (14101969.44, 437.58, 289.49, 50773125),
        (14041914.46, 434.52, 290.47, 50703593),
        (1916773.41, 240.13, 150.0, 7319698.41),
    )
    for about_centre, m, d, end in rows:
        assert about_centre + m * d**2 == pytest.approx(end, abs=0.5)
    program = np.array(BARS.i) * 1e9
    np.testing.assert_allclose(program, [rows[k][3] for k in (0, 1, 3, 2)], rtol=1e-6)
    assert 0.00191677341 * 1e9 == pytest.approx(rows[4][0], abs=1e-6)


def test_b5_the_centres_of_mass_lie_elsewhere_than_the_source_places_them():
    _, (th2, *_), (th3, *_) = motion()
    joints, centres, _ = places()
    placed = (
        turned(joints["A"], R3 / 2, th2),
        turned(joints["C"], R4 / 2, th3),
        turned(joints["F"], R4 / 2, th3),
        turned(joints["D"], R5 / 2, th3),
    )
    off = [abs(p - c) for p, c in zip(placed, centres[1:], strict=True)]
    np.testing.assert_allclose(off[0], R2 / 2 - R3 / 2)
    np.testing.assert_allclose(off[1], BARS.rg[2] - R4 / 2)
    np.testing.assert_allclose(off[2], BARS.rg[3] - R4 / 2)
    np.testing.assert_allclose(off[3], R5 * np.sin(th3 / 2))  # the chord of the angle of the blades
    assert off[3].max() > 0.29


def test_b5_an_index_that_names_one_entry_of_a_matrix_takes_a_number_and_not_a_point():
    """As printed in our copy, x_A(i) without a colon: columns are counted through, odd i give x and even i give y."""
    points = np.array([[1.0, 2.0, 3.0], [10.0, 20.0, 30.0]])
    assert points.ravel(order="F")[:4].tolist() == [1.0, 10.0, 2.0, 20.0]


def test_b6_bar_5_does_not_turn():
    joints, *_ = places()
    direction = joints["E"] - joints["D"]
    np.testing.assert_allclose(direction, R5, atol=1e-15)
    assert abs(rate(direction)).max() < 1e-13


def test_b7_the_torque_has_a_sign_that_its_norm_loses(right):
    plotted = abs(right["M"])
    assert right["M"].min() == pytest.approx(-0.782, abs=5e-4)
    assert plotted.min() >= 0
    assert 10 < (right["M"] < 0).sum() < 200


def test_b7_as_programmed_the_torque_is_minus_0_205_to_5_787():
    programmed = reactions(arm5=R5, g5_on=R3, rub=friction_as_printed)
    assert span(programmed["M"]) == pytest.approx([-0.205, 5.787], abs=5e-4)


def test_b8_the_arm_of_e_about_f_is_r4_which_contains_a_already(right):
    assert pytest.approx(R3 + STRAIGHT_ON) == R4
    joints, *_ = places()
    np.testing.assert_allclose(abs(joints["E"] - joints["F"]), R4, rtol=1e-14)
    printed = reactions(arm4=R4 + STRAIGHT_ON)
    left = imbalances(printed)
    assert np.argwhere(left > 1e-9).tolist() == [[3, 1]]
    assert abs(printed["M"] - torque_by_power()).max() > 0.1


def test_b9_the_x_component_of_a_force_of_constant_size_is_not_constant():
    force = friction(*motion()[2])
    assert abs(force.real).min() < 0.5 * RUBBING < abs(force.real).max()
    np.testing.assert_allclose(abs(force), RUBBING)


def test_b12_the_350th_point_is_at_349_degrees_and_a_letter_stands_farther_off_than_the_wiper_is_wide():
    assert np.linspace(0, 360, 361)[350 - 1] == pytest.approx(349)
    joints, *_ = places()
    drawn = np.concatenate([np.atleast_1d(joint) for joint in joints.values()])
    assert np.ptp(drawn.real) < 2 < abs(1 - 3j)
