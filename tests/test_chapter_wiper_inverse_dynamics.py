"""Claims of the chapter on the torque and the forces of the wiper, proven without the code that the chapter calls."""

import re
from pathlib import Path

import numpy as np
import pytest
from wiper_by_hand import (
    BARS,
    OMEGA,
    R1,
    R2,
    R3,
    R4,
    R5,
    RUBBING,
    STRAIGHT_ON,
    Bars,
    friction,
    friction_as_printed,
    imbalances,
    motion,
    places,
    rate,
    reactions,
    span,
    torque_by_power,
)

BOOK = Path(__file__).parents[1] / "book"
UNKNOWNS = ("M", *(f"{joint}_{axis}" for joint in "OABCDEF" for axis in "xy"))


def printed_matrix():
    """Rows of source B's program: x, y and moments of bodies 1 to 5; shape (points, 15, 15)."""
    (th1, *_), (th2, *_), (th3, *_) = motion()
    A = np.zeros((len(th1), 15, 15))
    column = {name: k for k, name in enumerate(UNKNOWNS)}
    for body, ends in enumerate(("+O+A", "-A+B", "-B+C+D", "-E+F", "-D+E")):
        for sign, joint in re.findall("([+-])(.)", ends):
            for k, axis in enumerate("xy"):
                A[:, 3 * body + k, column[f"{joint}_{axis}"]] = float(f"{sign}1")
    for row, joint, length, angle in (
        (2, "A", R1, th1), (5, "B", R2, th2), (8, "B", -R3, th3), (8, "D", R4, th3), (11, "E", -R4, th3),
    ):  # fmt: skip
        A[:, row, column[f"{joint}_x"]] = -length * np.sin(angle)
        A[:, row, column[f"{joint}_y"]] = length * np.cos(angle)
    A[:, 2, 0] = 1
    A[:, 14, column["E_y"]] = R5
    return A


def without_friction(*blade):
    return 0 * friction(*blade)


@pytest.fixture(scope="module")
def right():
    return reactions()


# --- the system


def test_the_system_of_the_source_has_the_forces_that_the_bars_give_one_by_one(right):
    """Its matrix on the forces is the inertia and weight on its right side: each row of moments about its joint."""
    joints, centres, angles = places()
    x = np.stack([right["M"], *(part for j in "OABCDEF" for part in (right[j].real, right[j].imag))], axis=-1)
    sides = np.einsum("kij,kj->ki", printed_matrix(), x)
    given = 0, 0, friction(*motion()[2]), friction(*motion()[2]), 0
    for body, about in enumerate("OACFD"):
        demand = BARS.m[body] * (rate(rate(centres[body])) + 9.81j) - given[body]
        arm = centres[body] - joints[about]
        moment = (arm.conjugate() * demand).imag
        if angles[body] is not None:
            own = BARS.i[body] - BARS.m[body] * BARS.rg[body] ** 2
            moment = moment + own * rate((rate(e := np.exp(1j * angles[body])) / (1j * e)).real).real
        np.testing.assert_allclose(sides[:, 3 * body : 3 * body + 2], np.c_[demand.real, demand.imag], atol=1e-8)
        np.testing.assert_allclose(sides[:, 3 * body + 2], moment, atol=1e-8)


def test_the_moments_of_the_bar_reach_c_d_e_and_f_and_never_the_torque():
    reach = np.abs(np.linalg.inv(printed_matrix())).max(axis=0) > 1e-9
    reached = {UNKNOWNS[k] for k in np.flatnonzero(reach[:, 14])}
    assert reached == {f"{joint}_{axis}" for joint in "CDEF" for axis in "xy"}
    assert [reach[UNKNOWNS.index(name)].sum() for name in ("M", "E_x", "E_y")] == [8, 2, 1]


def test_the_condition_number_lies_between_38_and_67():
    condition = np.linalg.cond(printed_matrix())
    assert span(condition) == [pytest.approx(38.6, abs=0.05), pytest.approx(66.9, abs=0.05)]


# --- masses and accelerations


def test_from_joint_to_joint_steiner_leads_over_the_centre_of_mass():
    """The moments of a rod, summed over small pieces."""
    x, length, mass = (np.arange(100_000) + 0.5) * 1e-5, 1.0, 2.0
    about = [mass * np.mean((x * length - d) ** 2) for d in (0.0, 0.5, 0.7)]
    assert about[0] == pytest.approx(about[1] + mass * 0.5**2)
    assert about[2] == pytest.approx(about[1] + mass * 0.2**2)
    assert about[2] < about[0] < about[0] + mass * 0.7**2


def test_the_acceleration_of_bar_5_as_programmed_is_half_of_what_it_should_be():
    joints, centres, _ = places()
    np.testing.assert_allclose(rate(rate(joints["B"])), rate(rate(centres[4])) / 2, atol=1e-10)
    largest = [abs(rate(rate(c))).max() for c in centres]
    assert largest == pytest.approx([0.7053, 2.4709, 6.9368, 6.9134, 7.1644], abs=5e-5)


# --- over a turn


def test_over_a_turn_the_motor_gives_what_friction_takes(right):
    way = 2 * np.ptp(motion(np.linspace(0, 2 * np.pi, 36_001))[2][0]) * (BARS.rg[2] + BARS.rg[3])
    assert RUBBING * way == pytest.approx(8.09, abs=5e-3)
    assert right["M"][:-1].mean() * 2 * np.pi == pytest.approx(RUBBING * way, rel=1e-3)
    assert reactions(rub=without_friction)["M"][:-1].mean() == pytest.approx(0, abs=1e-12)


def test_at_rest_the_forces_of_the_joints_leap_and_the_torque_does_not(right):
    turns_back = np.flatnonzero(np.diff(np.sign(motion()[2][1])))
    assert turns_back.tolist() == [25, 205]
    for joint in "OABC":
        assert abs(np.diff(right[joint]))[turns_back].min() > 10
    assert abs(np.diff(right["E"].real))[turns_back].min() > 8
    steps = abs(np.diff(right["M"]))
    assert steps[turns_back].max() < steps.max()


def test_friction_does_not_reach_the_force_at_e_along_y(right):
    np.testing.assert_allclose(reactions(rub=without_friction)["E"].imag, right["E"].imag, atol=1e-15)


def test_the_shaft_bears_up_to_63_newtons(right):
    largest = [abs(right[joint]).max() for joint in "OABCDEF"]
    assert largest == pytest.approx([62.80, 62.35, 61.40, 46.94, 32.44, 32.28, 32.30], abs=0.01)


# --- the mistakes


def exchanged():
    swap = (0, 1, 3, 2, 4)
    return Bars(*(tuple(triple[k] for k in swap[: len(triple)]) for triple in (BARS.m, BARS.rg, BARS.i)))


@pytest.mark.parametrize(
    ("mistake", "off"),
    [
        ({"arm5": R5}, (0, 4.0621, 1.5047)),
        ({"g5_on": R3}, (0.1570, 0.4198, 0.2419)),
        ({"rub": friction_as_printed}, (1.2760, 6.4937, 0)),
        ({"bars": exchanged()}, (0, 0.0917, 0)),
        ({"arm4": R4 + STRAIGHT_ON}, (0.6658, 9.4166, 0)),
    ],
    ids=["B1", "B2", "B3", "B4", "B8"],
)
def test_what_each_mistake_does_on_its_own(right, mistake, off):
    wrong = reactions(**mistake)
    dE = wrong["E"] - right["E"]
    found = [abs(part).max() for part in (wrong["M"] - right["M"], dE.real, dE.imag)]
    assert found == pytest.approx(off, abs=5e-5)


@pytest.mark.parametrize(
    ("bars", "rub"), [(BARS, friction_as_printed), (exchanged(), friction)], ids=["friction", "blades exchanged"]
)
def test_neither_witness_sees_a_wrong_load_or_wrong_masses(bars, rub):
    wrong = reactions(bars=bars, rub=rub)
    assert abs(wrong["M"] - torque_by_power(bars, rub)).max() < 1e-10
    assert imbalances(wrong, bars, rub).max() < 1e-9


def test_as_programmed_the_largest_forces_and_the_torque_without_friction_are_those_of_the_table():
    programmed = reactions(arm5=R5, g5_on=R3, rub=friction_as_printed)
    assert abs(programmed["E"].real).max() == pytest.approx(42.0709, abs=5e-5)
    assert abs(programmed["E"].imag).max() == pytest.approx(2.6826, abs=5e-5)
    smooth = reactions(arm5=R5, g5_on=R3, rub=without_friction)["M"]
    assert span(smooth) == pytest.approx([-2.102, 2.306], abs=5e-4)


def test_no_force_of_a_joint_that_the_arm_of_bar_5_adds_gives_power_to_any_body(right):
    joints, *_ = places()
    delta = reactions(arm5=R5)["E"] - right["E"]
    power = (delta * rate(joints["E"]).conjugate()).real
    assert abs(delta).max() == pytest.approx(4.316, abs=5e-4)
    assert abs(power).max() < 1e-11 * OMEGA


# --- the page itself

PAGE = (BOOK / "wiper-inverse-dynamics.md").read_text("utf-8")


@pytest.mark.parametrize(
    ("figure", "name"), [("motor torque", "torque"), ("forces at E", "force-e"), ("friction", "friction")]
)
def test_a_figure_of_source_b_has_a_counterpart_here_with_alt_text_and_a_row_in_the_table(figure, name):
    cells = re.findall(r"```\{code-cell\} ipython3\n---\n(.*?)\n---\n", PAGE, re.DOTALL)
    (told,) = (cell for cell in cells if re.search(rf"ounterpart of source B, {figure}", cell))
    assert f"name: fig-{name}\n" in told
    assert re.search(r"^    alt: ", told, re.MULTILINE)
    assert f"| {figure} | {{numref}}`fig-{name}` |" in PAGE


def test_each_of_the_seven_figures_of_source_b_has_a_row_in_the_table_and_its_counterpart_exists():
    rows = re.findall(r"^\| [^|]* \| \{numref\}`(fig-[\w-]+)` \|$", PAGE, re.MULTILINE)
    pages = "\n".join(path.read_text("utf-8") for path in BOOK.glob("*.md"))
    assert len(set(rows)) == 7
    assert set(rows) <= set(re.findall(r"^    name: (fig-\S+)", pages, re.MULTILINE))


@pytest.mark.parametrize(
    "place",
    [
        *("last row of the system", "gammaabsG5", "FrG3 and FrG4", "have changed places", "x_G2 to x_G5"),
        *("for body 5", "plot of the motor torque", "equation 12", "plot of the friction"),
    ],
    ids=[f"B{k}" for k in range(1, 10)],
)
def test_a_mistake_of_source_b_stands_in_a_box_of_its_own(place):
    boxes = re.findall(r":::\{admonition\} (Source B.*?)\n:class: warning", PAGE)
    assert len([box for box in boxes if place in box]) == 1


def test_the_sections_have_the_names_that_the_checks_send_to():
    headings = re.findall(r"^## (.*)$", PAGE, re.MULTILINE)
    agreed = (
        "Mass properties by Steiner",
        "How the centres of mass accelerate",
        "Fifteen equations",
        "Torque and forces over a turn",
        "Two witnesses",
        "What the source printed",
        "The exercise",
    )
    assert [heading for heading in headings if heading in agreed] == list(agreed)
