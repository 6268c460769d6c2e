"""What source B gets wrong about the wiper (B1 to B9), proven body by body in NumPy, without mechlib.

The plane is that of complex numbers.  `reactions` goes from the last bar of the chain to the crank, as one does by
hand, and solves no system of 15 equations; its keywords plant the mistakes of the source.  Two witnesses share nothing
with it: their accelerations, and the rate of the energy, are derivatives of Fourier series of the positions.
"""

from dataclasses import dataclass

import numpy as np
import pytest

R0, R1, R2, R3, R4, R5 = 0.245, 0.105, 0.220, 0.150, 0.300, 0.300  # m
STRAIGHT_ON = 0.150  # m, B-D: r4 = r3 + a
G, OMEGA, RUBBING = 9.81, 35 * 2 * np.pi / 60, 4.5  # m/s^2, rad/s, N
TURN = np.linspace(0, 2 * np.pi, 361)


@dataclass(frozen=True)
class Bars:
    """Masses, centres of mass, and moments of inertia about the turning ends, as the program has them."""

    m: tuple = (0.08821, 0.17773, 0.43452, 0.43758, 0.24013)  # kg
    rg: tuple = (R1 / 2, R2 / 2, 0.29047, 0.28949, R5 / 2)  # m
    i: tuple = (0.0003443403325, 0.002934475, 0.050703593, 0.050773125)  # kg m^2


BARS = Bars()


def dot(u, v):
    return (u * v.conjugate()).real


def cross(u, v):
    return (u.conjugate() * v).imag


def turned(about, length, angle):
    """A point on a bar."""
    return about + length * np.exp(1j * angle)


def swung(angle, omega, alpha, length):
    """Velocity and acceleration of the end of a bar against its beginning."""
    arm = length * np.exp(1j * angle)
    return 1j * omega * arm, (1j * alpha - omega**2) * arm


def motion(th1=TURN):
    """Angles, angular velocities and angular accelerations of crank, coupler and blades, by the law of cosines."""
    a = turned(0, R1, th1)
    d = abs(R0 - a)
    b = a + R2 * (R0 - a) / d * np.exp(1j * np.arccos((R2**2 + d**2 - R3**2) / (2 * R2 * d)))
    th2, th3 = np.angle(b - a), np.angle(b - R0)
    e2, e3 = 1j * R2 * np.exp(1j * th2), 1j * R3 * np.exp(1j * th3)

    def split(z):
        """x, y with x e2 - y e3 + z = 0."""
        return -cross(e3, z) / cross(e3, e2), cross(e2, z) / cross(e2, e3)

    w2, w3 = split(1j * OMEGA * a)
    al2, al3 = split(-(OMEGA**2) * a + 1j * w2**2 * e2 - 1j * w3**2 * e3)
    constant = np.full_like(th1, OMEGA), np.zeros_like(th1)
    return (th1, *constant), (th2, w2, al2), (th3, w3, al3)


def friction(th, w, _, size=RUBBING):
    """On a blade, against its velocity."""
    return -size * np.sign(w) * 1j * np.exp(1j * th)


def friction_as_printed(th, w, _):
    v = np.sign(w) * 1j * np.exp(1j * th)
    x, y = (-RUBBING * np.sign(part) - part for part in (v.real, v.imag))
    return x + 1j * y


def reactions(bars=BARS, arm5=None, g5_on=R4, rub=friction, arm4=R4):
    """Torque and forces: each on the body that comes first in the chain crank, coupler, blades; E on the bar 5."""
    crank, coupler, blade = motion()
    (m1, m2, m3, m4, m5), (g1, g2, g3, g4, g5), (_, i2, i3, i4) = bars.m, bars.rg, bars.i
    arm5 = g5 if arm5 is None else arm5
    f3 = f4 = rub(*blade)
    lift = 1j * G
    a_A = swung(*crank, R1)[1]

    # bar 5 does not turn; its moments about D give E_y
    a5 = swung(*blade, g5_on)[1]
    E_y = m5 * arm5 * (G + a5.imag) / R5
    # blade 4 about F gives E_x
    th3, _, al3 = blade
    pull = i4 * al3 + cross(turned(0, g4, th3), m4 * lift - f4)
    E = (pull / arm4 + E_y * np.cos(th3)) / np.sin(th3) + 1j * E_y
    F = m4 * (swung(*blade, g4)[1] + lift) - f4 + E
    D = E - m5 * (a5 + lift)
    # blade 3 about C and the coupler about A give B
    th2, _, al2 = coupler
    across3 = i3 * al3 + cross(turned(0, g3, th3), m3 * lift - f3) - cross(turned(0, R4, th3), D)
    across2 = i2 * al2 + m2 * cross(turned(0, g2, th2), a_A + lift)
    e2, e3 = np.exp(1j * th2), np.exp(1j * th3)
    B = (across2 / R2 * e3 + across3 / R3 * e2) / cross(e2, e3)
    C = m3 * (swung(*blade, g3)[1] + lift) - f3 + B - D
    A = B - m2 * (a_A + swung(*coupler, g2)[1] + lift)
    O = m1 * (swung(*crank, g1)[1] + lift) - A
    th1 = crank[0]
    M = m1 * g1 * G * np.cos(th1) - cross(turned(0, R1, th1), A)
    return {"M": M, "O": O, "A": A, "B": B, "C": C, "D": D, "E": E, "F": F}


# --- witnesses


def rate(values):
    """Derivative by time of what repeats with every turn; the last point is the first again."""
    n = len(values) - 1
    modes = np.fft.fftfreq(n, 1 / n) * OMEGA
    found = np.fft.ifft(1j * modes * np.fft.fft(values[:-1]))
    return np.append(found, found[0])


def places(bars=BARS):
    """Joints and centres of mass."""
    (th1, *_), (th2, *_), (th3, *_) = motion()
    a, d = turned(0, R1, th1), turned(R0, R4, th3)
    joints = {"O": 0 * a, "A": a, "B": turned(R0, R3, th3), "C": 0 * a + R0, "D": d, "E": d + R5, "F": 0 * a + R0 + R5}
    g1, g2, g3, g4, g5 = bars.rg
    centres = turned(0, g1, th1), turned(a, g2, th2), turned(R0, g3, th3), turned(R0 + R5, g4, th3), d + g5
    return joints, centres, (th1, th2, th3, th3, None)


def about_centres(bars):
    """Moments of inertia about the centres of mass, by Steiner backwards."""
    return [i - m * r**2 for i, m, r in zip(bars.i, bars.m, bars.rg, strict=False)]


def torque_by_power(bars=BARS, rub=friction):
    """From the energies alone."""
    _, centres, angles = places(bars)
    energy = sum(m * (abs(rate(c)) ** 2 / 2 + G * c.imag) for m, c in zip(bars.m, centres, strict=True))
    for i, angle in zip(about_centres(bars), angles, strict=False):
        energy = energy + i * abs(rate(np.exp(1j * angle))) ** 2 / 2
    force = rub(*motion()[2])
    return (rate(energy).real - sum(dot(force, rate(c)) for c in centres[2:4])) / OMEGA


ENDS = ({"O": 1, "A": 1}, {"A": -1, "B": 1}, {"B": -1, "C": 1, "D": 1}, {"E": -1, "F": 1}, {"D": -1, "E": 1})


def imbalances(found, bars=BARS, rub=friction):
    """Of each bar, from the forces alone: what Newton leaves over, and Euler about the centre of mass."""
    joints, centres, angles = places(bars)
    force = rub(*motion()[2])
    left = []
    for k, (ends, centre, angle) in enumerate(zip(ENDS, centres, angles, strict=True)):
        given = force if k in (2, 3) else 0
        newton = sum(s * found[j] for j, s in ends.items()) + given - bars.m[k] * (rate(rate(centre)) + 1j * G)
        euler = sum(cross(joints[j] - centre, s * found[j]) for j, s in ends.items()) + (found["M"] if k == 0 else 0)
        if angle is not None:
            e = np.exp(1j * angle)
            euler = euler - about_centres(bars)[k] * rate((rate(e) / (1j * e)).real).real
        left.append((abs(newton).max(), abs(euler).max()))
    return np.array(left)


def span(values):
    return [values.min(), values.max()]


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
