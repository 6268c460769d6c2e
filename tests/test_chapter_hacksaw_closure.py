"""Claims of the chapter on the loop closure, proven by complex numbers and plane geometry."""

import re
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from mechlib.hacksaw import Hacksaw
from mechlib.motion import MotorProfile

R1Y, R2, R3 = 0.045, 0.075, 0.170  # m, source A
TEXT = (Path(__file__).parents[1] / "book" / "hacksaw-closure.md").read_text("utf-8")


def slider(theta2, side, r3=R3):
    """x of the point where the circle about the crank pin meets the guide, on one side of the pin."""
    return R2 * np.cos(theta2) + side * np.sqrt(r3**2 - (R1Y - R2 * np.sin(theta2)) ** 2)


def at(t, side=-1):
    """r1, theta1, theta3 along the motion of the motor, r1 < 0, by the geometry alone."""
    theta2 = MotorProfile.through().at(t).position
    z = slider(theta2, side) + 1j * R1Y
    coupler = z - R2 * np.exp(1j * theta2)
    return np.stack((side * np.abs(z), np.angle(side * z), np.unwrap(np.angle(coupler) % (2 * np.pi))), axis=-1)


def cell(words):
    (found,) = (c for c in re.findall(r"```\{code-cell\} ipython3\n(.*?)```", TEXT, re.DOTALL) if words in c)
    return found


def test_the_hand_derivation_lacks_the_coriolis_terms_and_nothing_else():
    names: dict = {"np": np, "cos": np.cos, "sin": np.sin, "saw": Hacksaw()}
    exec(cell("def second_derivatives_by_hand"), names)
    rng = np.random.default_rng(4)
    q, v, a = rng.uniform(-2, 2, (3, 50, 3))
    crank = MotorProfile.through().at(np.sort(rng.uniform(0, 4, 50)))
    one = (a[:, 0] - q[:, 0] * v[:, 1] ** 2 + 1j * (q[:, 0] * a[:, 1] + 2 * v[:, 0] * v[:, 1])) * np.exp(1j * q[:, 1])
    two = R2 * (1j * crank.acceleration - crank.velocity**2) * np.exp(1j * crank.position)
    three = R3 * (1j * a[:, 2] - v[:, 2] ** 2) * np.exp(1j * q[:, 2])
    right = np.stack(((-one + two + three).real, (one - two - three).imag, one.imag), axis=-1)
    coriolis = 2j * v[:, 0] * v[:, 1] * np.exp(1j * q[:, 1])
    missing = np.stack((-coriolis.real, coriolis.imag, coriolis.imag), axis=-1)
    np.testing.assert_allclose(names["second_derivatives_by_hand"](q, v, a, crank) + missing, right, atol=1e-12)


def test_without_the_coriolis_terms_alpha_1_is_off_by_2_v_omega_over_r1_and_nothing_else_is():
    r1, th1, th3, r3, vr, w1 = sp.symbols("r1 th1 th3 r3 vr w1")
    jacobian = sp.Matrix(
        [
            [-sp.cos(th1), r1 * sp.sin(th1), -r3 * sp.sin(th3)],
            [sp.sin(th1), r1 * sp.cos(th1), -r3 * sp.cos(th3)],
            [sp.sin(th1), r1 * sp.cos(th1), 0],
        ]
    )
    forgotten = 2 * vr * w1 * sp.Matrix([sp.sin(th1), sp.cos(th1), sp.cos(th1)])
    assert sp.simplify(jacobian * sp.Matrix([0, 2 * vr * w1 / r1, 0]) - forgotten) == sp.zeros(3, 1)
    assert sp.simplify(jacobian.det() + r1 * r3 * sp.cos(th3)) == 0  # so the solution is the only one


def test_the_mistake_is_as_large_as_the_acceleration_itself():
    """Up to 9.5 rad/s^2, where alpha1 reaches 11.2; by differences of the geometry."""
    t, h = np.linspace(0.01, 2 * MotorProfile.through().T, 2001), 1e-4
    before, now, after = at(t - h), at(t), at(t + h)
    v, a = (after - before) / (2 * h), (after - 2 * now + before) / h**2
    off = 2 * v[:, 0] * v[:, 1] / now[:, 0]
    assert np.abs(off).max() == pytest.approx(9.53, abs=0.01)
    assert np.abs(a[:, 1]).max() == pytest.approx(11.17, abs=0.01)


def test_a_vector_accelerates_by_four_terms():
    """Equation (eq-polar), by a power series of r(t) e^(i theta(t))."""
    r, v, a, th, w, al, t = sp.symbols("r v a theta omega alpha t", real=True)
    z = (r + v * t + a * t**2 / 2) * sp.exp(sp.I * (th + w * t + al * t**2 / 2))
    turned = sp.expand(z.diff(t, 2).subs(t, 0) * sp.exp(-sp.I * th))
    assert sp.simplify(turned - (a - w**2 * r + sp.I * (al * r + 2 * v * w))) == 0
    assert sp.simplify(sp.expand(z.diff(t).subs(t, 0) * sp.exp(-sp.I * th)) - (v + sp.I * w * r)) == 0


def test_a12_source_a_s_equations_are_the_derivatives_of_its_closure():
    """By functions of time and SymPy's own derivative: the printed (10) to (15) as the chapter has them."""
    t = sp.Symbol("t")
    symbols = [sp.symbols(names) for names in ("r_1 v_r a_r", *(f"theta_{k} omega_{k} alpha_{k}" for k in (1, 2, 3)))]
    moving = [sp.Function(f"f{k}")(t) for k in range(4)]
    back = [(f.diff(t, n), symbols[k][n]) for n in (2, 1, 0) for k, f in enumerate(moving)]
    names: dict = {"sp": sp, "levels": {}, "Markdown": id, "draw": type("", (), {"table": lambda *args: None})}
    for name, triple in zip(("length", "line", "turn", "coupler"), symbols, strict=True):
        names[name] = triple
    names |= dict(zip(("r1", "th1", "th2", "th3"), (triple[0] for triple in symbols), strict=True))
    names |= dict(zip(("r1y", "r2", "r3"), sp.symbols("r_1y r_2 r_3"), strict=True))
    exec(cell('"(13)"'), names)
    printed = list(names["printed"].values())
    assert len(printed) == 9
    forward = list(zip((triple[0] for triple in symbols), moving, strict=True))
    for level in (1, 2):
        for F, expected in zip(printed[:3], printed[3 * level : 3 * level + 3], strict=True):
            assert sp.expand(F.subs(forward).diff(t, level).subs(back) - expected) == 0


def test_the_slider_stays_on_its_side_of_the_shaft_at_every_crank_angle():
    """So on the left branch theta1 lies between -90 and 0 degrees, and the branches never meet."""
    theta2 = np.linspace(0, 2 * np.pi, 100_001)
    assert slider(theta2, -1).max() < 0 < slider(theta2, 1).min()
    # a bound for every angle: the pin is never as far from (0, r1y) as the coupler is long
    assert R1Y + R2 < R3


def test_the_ranges_of_both_branches():
    theta2 = np.linspace(0, 2 * np.pi, 100_001)
    for side, x_range, th1_range, th3_range in (
        (-1, (-0.241, -0.084), (-28.3, -10.6), (135.1, 190.2)),
        (1, (0.084, 0.241), (10.6, 28.3), (-10.2, 44.9)),
    ):
        x = slider(theta2, side)
        th3 = np.rad2deg(np.angle((x + 1j * R1Y - R2 * np.exp(1j * theta2)) * (-1 if side < 0 else 1)))
        th3 = th3 + 180 if side < 0 else th3
        th1 = np.rad2deg(np.arctan(R1Y / x))
        for values, expected in ((x, x_range), (th1, th1_range), (th3, th3_range)):
            digits = 3 if values is x else 1
            assert (round(values.min(), digits), round(values.max(), digits)) == expected


def test_the_assemblies_are_mirror_images_in_the_vertical_through_the_pin():
    theta2 = np.linspace(0, 2 * np.pi, 101)
    saw = Hacksaw()
    left, right = (saw.points(theta2, saw.position(theta2, branch)) for branch in ("left", "right"))
    np.testing.assert_allclose(left[:, 2, 0] + right[:, 2, 0], 2 * left[:, 1, 0], atol=1e-15)
    np.testing.assert_allclose(left[:, 2, 1], right[:, 2, 1], atol=1e-15)


def test_the_short_coupler_reaches_the_guide_up_to_227_and_from_313_degrees_and_lacks_20_mm():
    theta2 = np.linspace(0, 2 * np.pi, 360_001)
    with np.errstate(invalid="ignore"):
        open_ = np.isnan(slider(theta2, 1, r3=0.10))
    ends = np.rad2deg(theta2[open_])
    assert (round(ends.min(), 1), round(ends.max(), 1)) == (227.2, 312.8)
    below = R1Y + R2  # the pin at its lowest, below the guide
    assert (below - 0.10, below - R3) == (pytest.approx(0.02), pytest.approx(-0.05))


def test_the_coupler_turns_faster_without_bound_towards_the_border():
    """omega3 sqrt(d) tends to -sqrt(r2 |cos theta2| / (2 r3)) at the border, by a series of the closed form."""
    border = np.pi - np.arcsin((R1Y - 0.10) / R2)
    limit = -np.sqrt(R2 * abs(np.cos(border)) / (2 * 0.10))
    assert limit == pytest.approx(-0.505, abs=5e-4)
    d, h = 1e-6, 1e-10
    th3 = [np.pi - np.arcsin((R1Y - R2 * np.sin(border - d + step)) / 0.10) for step in (-h, h)]
    assert (th3[1] - th3[0]) / (2 * h) * np.sqrt(d) == pytest.approx(limit, rel=2e-3)


def test_the_saw_never_comes_near_a_singular_position():
    theta2 = np.linspace(0, 2 * np.pi, 100_001)
    cosine = (slider(theta2, -1) - R2 * np.cos(theta2)) / R3
    assert np.abs(cosine).min() == pytest.approx(0.708, abs=5e-4)
    assert (R1Y + R2) / R3 == pytest.approx(0.706, abs=5e-4)


@pytest.mark.parametrize(("coriolis", "order"), [(True, 2), (False, 0)])
def test_a_right_derivative_shows_order_two_and_a_wrong_one_order_zero(coriolis, order):
    """d^2/dt^2 of theta1 from the geometry at hand, against the acceleration from the velocities and positions."""
    motor, hs = MotorProfile.through(), 0.02 / 2 ** np.arange(4)
    t = motor.T * np.array([0.2, 0.5, 0.8, 1.3, 1.6])
    tiny = 1e-3
    fourth = {-2: -1, -1: 16, 0: -30, 1: 16, 2: -1}  # second derivative to order four
    true = sum(c * at(t + k * tiny)[:, 1] for k, c in fourth.items()) / (12 * tiny**2)
    if not coriolis:
        q, v = at(t), (at(t + 1e-5) - at(t - 1e-5)) / 2e-5
        true = true + 2 * v[:, 0] * v[:, 1] / q[:, 0]

    def velocity(t):
        return (at(t + 1e-5)[:, 1] - at(t - 1e-5)[:, 1]) / 2e-5

    errors = np.array([np.abs((velocity(t + h) - velocity(t - h)) / (2 * h) - true).max() for h in hs])
    np.testing.assert_allclose(np.log2(errors[:-1] / errors[1:]), order, atol=0.05)


def test_a13_listing_e2_as_printed_in_our_copy_has_a_singular_jacobian():
    r1, th1, th3, r3 = sp.symbols("r1 th1 th3 r3")
    guide = [sp.sin(th1), r1 * sp.cos(th1), 0]
    assert sp.Matrix([guide, [sp.sin(th1), r1 * sp.cos(th1), -r3 * sp.cos(th3)], guide]).det() == 0
