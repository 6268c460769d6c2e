"""Claims of the chapter on the wiper's direct dynamics, proven without the code that the chapter calls.

The plane is that of complex numbers.  Velocities are per radian of the crank, and energies tell the rest.
"""

import re
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import quad, solve_ivp

from mechlib import draw

BOOK = Path(__file__).parents[1] / "book"
PAGE = (BOOK / "wiper-direct-dynamics.md").read_text("utf-8")
R0, R1, R2, R3, R4, R5 = 0.245, 0.105, 0.220, 0.150, 0.300, 0.300  # m, source B
M1, M2, M3, M4, M5 = 0.08821, 0.17773, 0.43452, 0.43758, 0.24013  # kg
G1, G2, G3, G4, G5 = R1 / 2, R2 / 2, 0.29047, 0.28949, R5 / 2
I_O, I_A, I_C, I_F = 0.0003443403325, 0.002934475, 0.050703593, 0.050773125  # about the turning ends
G, OMEGA, RUBBING, RPM = 9.81, 35 * 2 * np.pi / 60, 4.5, 60 / (2 * np.pi)
BLADES = I_C + I_F + M5 * R4**2  # all that turns with the blades, or is carried by them
TURN = np.linspace(0, 2 * np.pi, 1441)


def cross(u, v):
    return (u.conjugate() * v).imag


def dot(u, v):
    return (u * v.conjugate()).real


def geometry(th1):
    """Directions of coupler and blades, and their velocities per velocity of the crank."""
    e1 = np.exp(1j * th1)
    d = R0 - R1 * e1
    e2 = d / abs(d) * np.exp(1j * np.arccos((R2**2 + abs(d) ** 2 - R3**2) / (2 * R2 * abs(d))))
    e3 = (R2 * e2 - d) / R3
    return e2, e3, -R1 * cross(e3, e1) / (R2 * cross(e3, e2)), R1 * cross(e2, e1) / (R3 * cross(e2, e3))


def reduced(th1):
    """Reduced inertia, potential energy and its slope, and what friction takes a radian."""
    e2, e3, k2, k3 = geometry(th1)
    e1 = np.exp(1j * th1)
    inertia = I_O + M2 * abs(R1 * e1 + k2 * G2 * e2) ** 2 + (I_A - M2 * G2**2) * k2**2 + BLADES * k3**2
    lifted = ((M1 * G1 + M2 * R1) * e1, M2 * G2 * e2, (M3 * G3 + M4 * G4 + M5 * R4) * e3)
    slope = sum(k * term.real for k, term in zip((1, k2, k3), lifted, strict=True))
    return inertia, G * sum(lifted).imag, G * slope, RUBBING * (G3 + G4) * abs(k3)


J, V, SLOPE, TAKEN = reduced(TURN)


def acceleration(th1, omega, torque):
    """From the reduced equation, the inertia differentiated numerically."""
    rises = (reduced(th1 + 1e-5)[0] - reduced(th1 - 1e-5)[0]) / 2e-5
    inertia, _, slope, _ = reduced(th1)
    return (torque - slope - rises * omega**2 / 2) / inertia


# --- coasting, with the loop closed and with the loop let go


def test_the_verified_digits_of_the_coasting_wiper_follow_from_the_energy_alone():
    energy = reduced(0.0)[0] * OMEGA**2 / 2 + reduced(0.0)[1]

    def speed(th1):
        inertia, potential, *_ = reduced(th1)
        return np.sqrt(2 * (energy - potential) / inertia)

    time, _ = quad(lambda th1: 1 / speed(th1), 0, 13.743612113, epsrel=1e-12, limit=500)
    assert time == pytest.approx(2, abs=1e-9)
    assert f"{speed(13.743612113):.8f}" == "3.76830092"
    assert '"13.74361211", "3.76830092"' in PAGE
    fastest = speed(TURN)
    assert 70 < fastest.max() < 75
    peak = fastest.argmax()
    before = np.flatnonzero(fastest[:peak] < fastest[peak] / 10)[-1]
    assert np.trapezoid(1 / fastest[before : peak + 1], TURN[before : peak + 1]) < 0.1  # s, and tenfold


def test_a_loop_that_only_its_accelerations_know_of_opens_and_the_integrator_reports_success():
    """Lagrange's equations of the three angles, with two multipliers for the loop."""

    def slope(_, y):
        e1, e2, e3 = np.exp(1j * y[:3])
        w1, w2, w3 = y[3:]
        couples, turns = M2 * R1 * G2 * dot(e1, e2), M2 * R1 * G2 * cross(e2, e1)
        mass = [[I_O + M2 * R1**2, couples, 0], [couples, I_A, 0], [0, 0, BLADES]]
        pins = 1j * np.array([R1 * e1, R2 * e2, -R3 * e3])
        ties = np.array([pins.real, pins.imag])
        away = R1 * e1 * w1**2 + R2 * e2 * w2**2 - R3 * e3 * w3**2
        weight = G * np.array(
            [(M1 * G1 + M2 * R1) * e1.real, M2 * G2 * e2.real, (M3 * G3 + M4 * G4 + M5 * R4) * e3.real]
        )
        acting = np.array([-turns * w2**2, turns * w1**2, 0]) - weight
        matrix = np.block([[np.array(mass), ties.T], [ties, np.zeros((2, 2))]])
        return [w1, w2, w3, *np.linalg.solve(matrix, [*acting, away.real, away.imag])[:3]]

    e2, e3, k2, k3 = geometry(0.0)
    y = [0, np.angle(e2), np.angle(e3), OMEGA, k2 * OMEGA, k3 * OMEGA]
    found = solve_ivp(slope, (0, 2), y)
    th1, th2, th3 = found.y[:3, -1]
    opening = abs(R1 * np.exp(1j * th1) + R2 * np.exp(1j * th2) - R0 - R3 * np.exp(1j * th3))
    assert found.success
    assert 0.005 < opening < 0.02
    closed = solve_ivp(slope, (0, 2), y, "DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    assert (closed[0], closed[3]) == (pytest.approx(13.74361211, abs=1e-7), pytest.approx(3.76830092, abs=1e-6))


def test_baumgarte_s_equation_lets_an_opening_die_out_at_its_rate_and_without_it_one_keeps_growing():
    t, beta, open_, opens = sp.symbols("t beta F_0 v_0", positive=True)
    F = sp.Function("F")(t)
    begin = {F.subs(t, 0): open_, F.diff(t).subs(t, 0): opens}
    held = sp.dsolve(F.diff(t, 2) + 2 * beta * F.diff(t) + beta**2 * F, F, ics=begin).rhs
    assert sp.simplify(held - (open_ + (opens + beta * open_) * t) * sp.exp(-beta * t)) == 0
    assert sp.expand(sp.dsolve(F.diff(t, 2), F, ics=begin).rhs - open_ - opens * t) == 0


def test_the_reduced_inertia_has_its_two_humps_and_nearly_vanishes_where_the_blades_stand_still():
    degrees = np.rad2deg(TURN)
    humps = [k for k in range(1, 1440) if J[k - 1] < J[k] > J[k + 1]]
    assert [(round(degrees[k]), round(J[k], 3)) for k in humps] == [(112, 0.065), (340, 0.125)]
    k3 = geometry(TURN)[3]
    turns_back = degrees[:-1][np.diff(np.sign(k3)) != 0]
    np.testing.assert_allclose(turns_back, [26, 206], atol=0.5)
    assert J.max() / J.min() > 100
    assert (J - BLADES * k3**2).max() < 0.04 * J.max()


# --- friction


def test_friction_stops_the_coasting_wiper_after_0_13_s_and_lets_it_creep_in_proportion_to_its_width():
    creeps = []
    for v0 in (0.003, 0.001):

        def slope(_, y, v0=v0):
            k3 = geometry(y[0])[3]
            fading = sum(arm * np.tanh(arm * k3 * y[1] / v0) for arm in (G3, G4))
            return [y[1], acceleration(y[0], y[1], -RUBBING * k3 * fading)]

        run = solve_ivp(slope, (0, 0.2), [0, OMEGA], "LSODA", rtol=1e-8, atol=1e-10, dense_output=True)
        t = np.linspace(0, 0.2, 2001)
        assert t[np.argmax(run.sol(t)[1] < 0)] == pytest.approx(0.133, abs=2e-3)
        th1, omega = run.y[:, -1]
        _, _, pulls, whole = reduced(th1)
        assert -omega == pytest.approx(v0 * np.arctanh(pulls / whole) / (G3 * abs(geometry(th1)[3])), rel=0.01)
        assert np.rad2deg(th1) == pytest.approx(37, abs=0.5)
        creeps.append(omega)
    assert creeps[0] / creeps[1] == pytest.approx(3, rel=0.02)


def test_with_fixed_steps_coulomb_friction_chatters_about_rest():
    th1, omega, step, signs = 0.64, 0.0, 1e-3, []
    for _ in range(300):
        signs.append(np.sign(omega))
        alpha = acceleration(th1, omega, -signs[-1] * reduced(th1)[3])
        th1, omega = th1 + step * omega, omega + step * alpha
    for part in (signs[10:155], signs[155:]):  # it does not die out
        assert np.count_nonzero(np.diff(part)) > len(part) / 6


def test_where_the_widest_friction_lets_it_sink_to_nothing_pulls():
    near = (TURN > 0) & (TURN < 1)
    lowest = TURN[near][np.abs(SLOPE[near]).argmin()]
    assert np.rad2deg(lowest) == pytest.approx(21.3, abs=0.2)


# --- motors


def test_a_motor_of_3_newton_metres_is_below_the_peak_that_turns_it_on_and_one_of_4_above():
    needed = SLOPE + TAKEN
    degrees = np.rad2deg(TURN)
    assert 3 < needed.max() < 3.7 < 4
    assert degrees[needed.argmax()] == pytest.approx(325, abs=1)
    assert needed[degrees < 180].max() == pytest.approx(1.72, abs=0.02)
    by_itself = degrees[needed < 0]
    assert by_itself.min() == pytest.approx(143, abs=3)
    assert by_itself.max() == pytest.approx(208, abs=4)


def started(stall, t):
    """Angle and speed of the crank from rest, by a motor that has the mean torque of a turn at 35 rpm."""
    needed = np.gradient(J, TURN) * OMEGA**2 / 2 + SLOPE + TAKEN
    no_load = OMEGA / (1 - np.trapezoid(needed, TURN) / (2 * np.pi) / stall)

    def slope(_, y):
        k3 = geometry(y[0])[3]
        rubs = RUBBING * k3 * sum(arm * np.tanh(arm * k3 * y[1] / 0.01) for arm in (G3, G4))
        return [y[1], acceleration(y[0], y[1], stall * (1 - y[1] / no_load) - rubs)]

    return solve_ivp(slope, (0, t[-1]), [0, 0], "LSODA", t, rtol=1e-7, atol=1e-9).y


@pytest.mark.parametrize(
    ("stall", "rpm", "ripple", "least", "most"),
    [(30, 34.90, 0.1834, 31, 38), (10, 33.95, 0.606, 24, 45), (5, 29.02, 1.711, 12, 62)],
)
def test_the_weaker_the_motor_the_larger_the_ripple_and_from_the_second_turn_on_all_are_alike(
    stall, rpm, ripple, least, most
):
    t = np.linspace(0, 6.4, 6401)
    th1, omega = started(stall, t)
    ends = np.interp(2 * np.pi * np.arange(4), th1, t)
    speeds = 2 * np.pi / np.diff(ends)
    turns = [omega[(begin <= t) & (t <= end)] for begin, end in pairwise(ends)]
    ripples = [np.ptp(turn) / speed for turn, speed in zip(turns, speeds, strict=True)]
    assert speeds[1] * RPM == pytest.approx(rpm, rel=1e-3)
    assert speeds[2] == pytest.approx(speeds[1], rel=1e-4)
    assert ripples[1:] == [pytest.approx(ripple, rel=5e-3)] * 2
    assert turns[2].min() * RPM == pytest.approx(least, abs=0.7)  # as the alternative text of the figure says
    assert turns[2].max() * RPM == pytest.approx(most, abs=0.7)


def test_the_stored_run_up_of_the_engine_is_this_one_within_1e_4_of_35_rpm_and_closer_the_shorter_its_step():
    t, th1, omega = np.loadtxt(BOOK / "engine" / "wiper_run_up.csv", delimiter=",").T
    found = started(30, t)
    assert np.abs(omega - found[1]).max() < 1e-4 * OMEGA
    assert np.abs(th1 - found[0]).max() < 1e-4 * 2 * np.pi
    steps = np.loadtxt(BOOK / "engine" / "wiper_steps.csv", delimiter=",")
    orders = np.log2(steps[:-1, [3, 6, 8]] / steps[1:, [3, 6, 8]])
    np.testing.assert_allclose(orders, 2, atol=0.15)


# --- the seventeen printed equations


def chain(rng, n):
    """Random states with any acceleration, and the forces that go with them, bar by bar from the end of the chain."""
    th1, w, al, torque = rng.uniform(0, 6, n), rng.uniform(-8, 8, n), rng.uniform(-9, 9, n), rng.uniform(-5, 5, n)
    loads = rng.uniform(-5, 5, (n, 2, 2))
    e2, e3, k2, k3 = geometry(th1)
    e1, w2, w3 = np.exp(1j * th1), k2 * w, k3 * w
    known = R1 * e1 * (1j * al - w**2) - R2 * e2 * w2**2 + R3 * e3 * w3**2  # + i al2 R2 e2 = i al3 R3 e3
    al2, al3 = cross(e3, 1j * known) / (R2 * cross(e3, e2)), cross(e2, 1j * known) / (R3 * cross(e3, e2))

    def at(e, w, al):
        return e * (1j * al - w**2)

    def needs(m, a, load=0):
        return m * (a + 1j * G) - load

    f3, f4 = (loads[:, k, 0] + 1j * loads[:, k, 1] for k in (0, 1))
    blade, of_a = at(e3, w3, al3), R1 * at(e1, w, al)
    five, four = needs(M5, R4 * blade), needs(M4, G4 * blade, f4)
    three, two = needs(M3, G3 * blade, f3), needs(M2, of_a + G2 * at(e2, w2, al2))
    one = needs(M1, G1 * at(e1, w, al))
    e_y = cross(G5, five) / R5
    moment = (I_F - M4 * G4**2) * al3 + cross(G4 * e3, four)  # of -E on the second blade about F
    e_x = (moment / R4 + e3.real * e_y) / e3.imag
    E = e_x + 1j * e_y
    D, F = E - five, four + E
    of_b = cross(R4 * e3, D) - (I_C - M3 * G3**2) * al3 - cross(G3 * e3, three)  # B on the first blade is -B
    on_b = (I_A - M2 * G2**2) * al2 + cross(G2 * e2, two)
    along2, along3 = on_b / R2, of_b / R3  # cross(e2, B), cross(e3, B)
    B = (along3 * e2 - along2 * e3) / cross(e3, e2)
    A, C = B - two, three + B - D
    O = one - A
    torque = (I_O - M1 * G1**2) * al + cross(G1 * e1, one) - cross(R1 * e1, A)
    pairs = {name: np.column_stack((z.real, z.imag)) for name, z in zip("OABCDEF", (O, A, B, C, D, E, F), strict=True)}
    states = np.column_stack((th1, np.angle(e2), np.angle(e3))), np.column_stack((w, w2, w3))
    return states, torque, loads, SimpleNamespace(accelerations=np.column_stack((al, al2, al3)), forces=pairs)


def test_b13_of_the_seventeen_equations_of_source_b_the_solved_form_of_2_and_12_are_wrong_as_printed():
    states, torque, loads, found = chain(np.random.default_rng(9), 50)
    (cell,) = (c for c in re.findall(r"```\{code-cell\} ipython3\n(.*?)```", PAGE, re.DOTALL) if "printed = {" in c)
    bars = zip((M1, M2, M3, M4, M5), (G1, G2, G3, G4, G5), (I_O, I_A, I_C, I_F, 0), strict=True)
    masses = [SimpleNamespace(mass=m, centre=c, inertia=i - m * c**2) for m, c, i in bars]
    names = {
        "np": np, "sin": np.sin, "cos": np.cos, "draw": draw, "Markdown": str, "states": states, "M": torque,
        "f": loads,
        "wiper": SimpleNamespace(r1=R1, r2=R2, r3=R3, r4=R4, r5=R5, g=G, masses=masses),
        "direct_dynamics": lambda *_: found,
    }  # fmt: skip
    exec(cell.removeprefix(":tags: [hide-input]\n"), names)
    verdicts = {row[0].split()[0]: row[1:] for row in names["rows"]}
    assert len(verdicts) == 17
    wrong = {number: cells for number, cells in verdicts.items() if "**differs**" in cells}
    assert wrong == {"(2)": ("agrees", "**differs**"), "(12)": ("**differs**", "**differs**")}


# --- the page itself


@pytest.mark.parametrize("place", ["equation 2:", "equations 9 and 12"])
def test_a_mistake_of_source_b_stands_in_a_box_of_its_own(place):
    boxes = re.findall(r":::\{admonition\} (Source B.*?)\n:class: warning", PAGE)
    assert len([box for box in boxes if place in box]) == 1


def test_every_figure_has_a_name_a_caption_and_alternative_text():
    heads = re.findall(r"```\{code-cell\} ipython3\n---\n(.*?)\n---\n", PAGE, re.DOTALL)
    assert len(heads) == PAGE.count("plt.show()") + PAGE.count("drawn.wiper(")
    for head in heads:
        assert re.search(r"^    name: fig-\S+\n    caption: >-", head, re.MULTILINE)
        assert re.search(r"^    alt: ", head, re.MULTILINE) or "fig-run-up-moving" in head  # that has its own


def test_the_sections_have_the_names_that_the_checks_send_to():
    headings = re.findall(r"^## (.*)$", PAGE, re.MULTILINE)
    assert headings == [
        "A failure first",
        "Seventeen equations",
        "The motion that a torque makes",
        "Energy as a witness",
        "Friction that comes to rest",
        "From rest to 35 turns a minute",
        "An independent engine",
        "What the source printed",
        "The exercise",
        "Further reading",
    ]
