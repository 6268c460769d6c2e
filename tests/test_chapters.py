"""Claims that the chapters make and a reader could dispute, proven without the code that the chapters call."""

import re
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import matplotlib
import mpmath
import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st
from mpmath import iv

from autograder.checks import EXERCISES
from mechlib import draw

matplotlib.use("Agg")
BOOK = Path(__file__).parents[1] / "book"
EPSILON = np.finfo(float).eps


# --- one variable


def zeros_proven(f, df, a, b) -> int:
    """Number of zeros on [a, b] by interval arithmetic: no subinterval is left undecided."""
    interval = iv.mpf([a, b])
    if 0 not in f(interval):
        return 0
    if 0 not in df(interval):  # monotonic: the ends decide
        return int(mpmath.sign(f(iv.mpf(a)).mid) != mpmath.sign(f(iv.mpf(b)).mid))
    assert b - a > 1e-12, f"undecided at {a}"
    middle = (a + b) / 2
    return zeros_proven(f, df, a, middle) + zeros_proven(f, df, middle, b)


def third(x):
    return x * iv.sin(1 / x) - iv.exp(-x) / 5


def slope_of_third(x):
    return iv.sin(1 / x) - iv.cos(1 / x) / x + iv.exp(-x) / 5


@pytest.mark.parametrize(
    ("f", "df", "intervals", "zeros"),
    [
        # outside, |sin x| <= 1 rules a zero out
        (lambda x: iv.sin(x) + x - 1, lambda x: iv.cos(x) + 1, [(-0.3, 2.3)], 1),
        (lambda x: x**5 + x - 1, lambda x: 5 * x**4 + 1, [(-2.1, 2.3)], 1),
        # |x sin(1/x)| <= |x| rules out |x| < 0.1, and x sin(1/x) <= 1 < 0.2 e^-x rules out x < -1.7
        (third, slope_of_third, [(-1.7, -0.1)], 2),
        (third, slope_of_third, [(0.1, 9.7)], 1),
        # e^x > 6 x for x <= 0, and e^x > x^2 > 6 x for x > 6
        (lambda x: iv.exp(x) - 6 * x, lambda x: iv.exp(x) - 6, [(-0.3, 6.4)], 2),
    ],
    ids=["sin x + x = 1", "x^5 + x = 1", "x sin(1/x) = 0.2 e^-x, x < 0", "x sin(1/x) = 0.2 e^-x, x > 0", "e^x = 6x"],
)
def test_source_b_s_equations_have_as_many_solutions_as_the_theorems_say(f, df, intervals, zeros):
    assert sum(zeros_proven(f, df, *interval) for interval in intervals) == zeros


def test_the_third_equation_has_no_solution_far_to_the_right():
    """Beyond 9.7, x sin(1/x) > 1 - 1/(6 x^2) > 0.99 and the right side is below 0.2."""
    assert 1 - 1 / (6 * 9.7**2) > 0.99 > 0.2 > 0.2 * np.exp(-9.7)


def test_x5_plus_x_minus_1_factors_and_its_real_zero_belongs_to_the_cubic():
    x = sp.Symbol("x")
    assert sp.expand((x**2 - x + 1) * (x**3 + x**2 - 1)) == x**5 + x - 1
    assert sp.discriminant(x**2 - x + 1, x) < 0


def test_zero_and_one_form_a_cycle_of_x3_minus_2x_plus_2_that_attracts():
    def step(x):
        return x - (x**3 - 2 * x + 2) / (3 * x**2 - 2)

    assert step(Fraction(0)) == 1
    assert step(Fraction(1)) == 0
    for x in np.linspace(-0.1, 0.1, 21):
        for _ in range(20):
            x = step(step(x))
        assert abs(x) < 1e-12


def mirrored(x):
    """Positive while the step of arctan falls short of its mirror image."""
    return 2 * x - (1 + x**2) * mpmath.atan(x)


FRONTIER = mpmath.findroot(mirrored, (1.3, 1.5), solver="anderson")
GUARANTEED = mpmath.findroot(lambda r: 3 * mpmath.sqrt(3) / 8 * r * (1 + r**2) - 2, (1, 2), solver="anderson")


def arctan_path(x, steps):
    for _ in range(steps):
        yield x
        x = x - mpmath.atan(x) * (1 + x**2)


@pytest.mark.parametrize(("factor", "grows"), [(1 - 1e-6, False), (1 + 1e-6, True)])
def test_newton_on_arctan_turns_from_convergence_to_divergence_at_the_frontier(factor, grows):
    sizes = [abs(x) for x in arctan_path(FRONTIER * factor, 12)]
    assert all((after > before) == grows for before, after in pairwise(sizes))


@given(st.floats(0.01, 0.999))
def test_the_local_theorem_bounds_every_error_of_arctan(share):
    """C |e_n| <= (C rho)^(2^n) with rho the seed's own distance."""
    rho = GUARANTEED * share
    largest_curvature = 3 * mpmath.sqrt(3) / 8
    c = largest_curvature * (1 + rho**2) / 2
    for n, x in enumerate(arctan_path(rho, 6)):
        assert c * abs(x) <= (c * rho) ** (2**n) * (1 + mpmath.mpf(10) ** -9)


@given(st.floats(0.2, 6), st.floats(0.1, 10))
def test_near_a_power_the_error_is_multiplied_by_one_minus_one_over_p(p, e):
    step = e**p / (p * e ** (p - 1))
    assert e - step == pytest.approx((1 - 1 / p) * e, abs=1e-13 * e)  # a few units of round-off of e


def test_a_step_times_the_multiplicity_brings_order_two_back():
    x = sp.Symbol("x")
    for p in (2, 3, 5):
        f = (x - 1) ** p * (x + 2)
        error = sp.series((x - p * f / f.diff(x)).subs(x, x + 1) - 1, x, 0, 3).removeO()
        assert error.coeff(x, 1) == 0
        assert error.coeff(x, 2) != 0


@given(st.floats(1e-3, 30))
def test_every_seed_right_of_ln_6_runs_down_to_the_larger_zero_of_exp_minus_6x(distance):
    larger = -mpmath.lambertw(mpmath.mpf(-1) / 6, -1).real
    x = mpmath.log(6) + distance
    with mpmath.workdps(30):
        for n in range(7000):  # from 1e-3 the first step goes to about 1800
            x, before = x - (mpmath.exp(x) - 6 * x) / (mpmath.exp(x) - 6), x
            assert n == 0 or larger - 1e-12 <= x <= before + 1e-12
            if abs(x - before) < 1e-15:
                break
    assert abs(x - larger) < 1e-12


def test_round_off_hides_half_of_the_digits_of_a_double_zero():
    """f is computed as exactly zero over a stretch of about sqrt(eps)."""
    x = 1 + np.geomspace(1e-12, 1e-4, 400)
    zero = x[x**3 - 3 * x + 2 == 0] - 1
    assert 1e-9 < zero.max() < 1e-7


# --- several variables

R0, R1, R2, R3 = 0.245, 0.105, 0.220, 0.150  # m, source B
SEED = np.deg2rad([55.0, 125.0])


def loop(q, crank):
    a = R1 * np.exp(1j * crank) + R2 * np.exp(1j * q[0]) - R0 - R3 * np.exp(1j * q[1])
    return np.array([-a.real, a.imag])


def loop_jacobian(q):
    return np.array([[R2 * np.sin(q[0]), -R3 * np.sin(q[1])], [R2 * np.cos(q[0]), -R3 * np.cos(q[1])]])


def assemblies(crank):
    """Both assemblies by the law of cosines: the joint B above and below the line from A to C."""
    a, c = R1 * np.exp(1j * crank), complex(R0)
    d = abs(c - a)
    for side in (1, -1):
        b = a + R2 * (c - a) / d * np.exp(side * 1j * np.arccos((R2**2 + d**2 - R3**2) / (2 * R2 * d)))
        yield np.angle([b - a, b - c])


def test_the_wiper_has_two_assemblies_at_every_crank_angle():
    for crank in np.linspace(0, 2 * np.pi, 361):
        for q in assemblies(crank):
            np.testing.assert_allclose(loop(q, crank), 0, atol=4 * EPSILON)


def test_b10_source_b_s_rule_takes_1662_iterations_and_leaves_less_than_the_bound():
    counts, bound, worst = [], 0.0, 0.0
    for crank in np.linspace(0, 2 * np.pi, 361):
        q = SEED
        counts.append(0)
        while np.linalg.norm(loop(q, crank)) > 1e-9:
            q = q - np.linalg.solve(loop_jacobian(q), loop(q, crank))
            counts[-1] += 1
        bound = max(bound, 1e-9 / np.linalg.svd(loop_jacobian(q), compute_uv=False)[-1])
        worst = max(worst, min(np.linalg.norm(np.angle(np.exp(1j * (q - true)))) for true in assemblies(crank)))
    assert (min(counts), max(counts), sum(counts)) == (3, 5, 1662)
    assert bound / 3 < worst < bound


def test_a_wrong_jacobian_converges_at_the_rate_of_the_largest_eigenvalue():
    crank = np.deg2rad(240)
    for matrix in (lambda q: loop_jacobian(q).T, lambda q: loop_jacobian(SEED)):
        q, steps = SEED, []
        for _ in range(120):
            d = np.linalg.solve(matrix(q), loop(q, crank))
            q = q - d
            steps.append(np.linalg.norm(d))
        np.testing.assert_allclose(loop(q, crank), 0, atol=1e-12)  # the right answer, whatever the matrix
        rho = np.abs(np.linalg.eigvals(np.eye(2) - np.linalg.solve(matrix(q), loop_jacobian(q)))).max()
        last = [s for s in steps if s > 1e-11][-8:]
        rate = (last[-1] / last[0]) ** (1 / (len(last) - 1))
        assert rate == pytest.approx(rho, rel=0.01)  # eigenvectors die out at the ratio of the eigenvalues


def test_the_transposed_jacobian_is_repelled_by_the_wanted_assembly():
    upper = next(assemblies(np.deg2rad(240)))
    factor = np.eye(2) - np.linalg.solve(loop_jacobian(upper).T, loop_jacobian(upper))
    assert np.abs(np.linalg.eigvals(factor)).max() > 1


def test_the_border_between_the_basins_shows_more_changes_however_far_one_zooms():
    crank = np.deg2rad(240)
    upper, lower = (np.exp(1j * q) for q in assemblies(crank))
    low, high = np.deg2rad([20, 90])
    for _ in range(10):
        th3 = np.linspace(low, high, 401)
        q = np.stack((np.full_like(th3, -np.pi / 4), th3), axis=-1)
        for _ in range(60):
            jacobian = np.moveaxis(loop_jacobian(q.T), -1, 0)
            q = q - np.linalg.solve(jacobian, loop(q.T, crank).T[..., None])[..., 0]
        at_upper, at_lower = (np.abs(np.exp(1j * q) - root).max(axis=1) < 1e-9 for root in (upper, lower))
        assert np.all(at_upper | at_lower)
        changes = np.flatnonzero(np.diff(at_upper.astype(int)))
        assert len(changes) > 20
        middle, width = th3[changes[len(changes) // 2]], (high - low) / 10
        low, high = middle - width / 2, middle + width / 2


@pytest.fixture
def saw():
    """Unknowns, closure and Jacobian of the power hacksaw, and source A's matrix (17)."""
    q = r1, th1, th3 = sp.symbols("r1 th1 th3")
    th2, height, r2, r3 = sp.symbols("th2 height r2 r3")
    closure = sp.Matrix(
        [
            r1 * sp.sin(th1) - height,
            -r1 * sp.cos(th1) + r2 * sp.cos(th2) + r3 * sp.cos(th3),
            r1 * sp.sin(th1) - r2 * sp.sin(th2) - r3 * sp.sin(th3),
        ]
    )
    printed = sp.Matrix(
        [
            [sp.sin(th1), r1 * sp.cos(th1), 0],
            [0, height * (sp.cot(th1) ** 2 + 1), -r3 * sp.sin(th3)],
            [0, 0, -r3 * sp.cos(th3)],
        ]
    )
    rest = {th2: 0, height: 0.045, r2: 0.075, r3: 0.170}
    return q, closure, closure.jacobian(q), printed, height, rest


def test_the_saw_is_singular_where_the_slider_is_at_the_origin_or_the_coupler_upright(saw):
    (r1, _, th3), _, jacobian, *_ = saw
    r3 = sp.Symbol("r3")
    assert sp.simplify(jacobian.det() + r1 * r3 * sp.cos(th3)) == 0


def test_with_matrix_17_the_linear_error_dies_in_two_steps(saw):
    """(I - B^-1 J)^2 = 0 at every solution, while I - B^-1 J is not zero."""
    (r1, th1, _), _, jacobian, printed, height, _ = saw
    at_a_solution = {height: r1 * sp.sin(th1)}
    factor = sp.simplify((sp.eye(3) - printed.inv() * jacobian).subs(at_a_solution))
    assert factor != sp.zeros(3)
    assert sp.simplify(factor**2) == sp.zeros(3)


def test_matrix_17_with_the_original_equations_misses_the_printed_digits(saw):
    q, closure, jacobian, printed, _, rest = saw
    residual = sp.lambdify(q, closure.subs(rest))
    found = {}
    for name, matrix in (("own", jacobian), ("printed", printed)):
        slope = sp.lambdify(q, matrix.subs(rest))
        x, steps = np.array([-0.1, -0.5, 3.0]), []
        while not steps or steps[-1] >= 1e-6:
            d = np.linalg.solve(slope(*x), residual(*x).ravel())
            x = x - d
            steps.append(np.linalg.norm(d))
        found[name] = len(steps), [f"{value:.6f}" for value in x]
    assert found["own"] == (4, ["-0.099672", "-0.468422", "2.873694"])
    assert found["printed"] == (5, ["-0.099673", "-0.468420", "2.873695"])


@pytest.mark.parametrize(("kind", "power"), [("forward", 1 / 2), ("central", 1 / 3)])
def test_the_best_step_of_a_difference_is_a_power_of_round_off(kind, power):
    hs = np.logspace(-14, -1, 261)
    x = np.linspace(0.5, 2.5, 50)[:, None]
    rise = {"forward": (np.sin(x + hs) - np.sin(x)) / hs, "central": (np.sin(x + hs) - np.sin(x - hs)) / (2 * hs)}
    worst = np.abs(rise[kind] - np.cos(x)).max(axis=0)
    assert abs(np.log10(hs[worst.argmin()] / EPSILON**power)) < 1  # within a decade: the constants are not 1
    assert abs(np.log10(worst.min() / EPSILON ** (1 - power if kind == "forward" else 2 * power))) < 1.5


def test_a15_the_backward_error_of_the_inverse_grows_with_the_condition_and_that_of_the_solve_does_not():
    rng = np.random.default_rng(20)
    solved, inverted = [], []
    for condition in (1e2, 1e6, 1e10, 1e14):
        u, v = (np.linalg.qr(rng.normal(size=(9, 9)))[0] for _ in range(2))
        a = u @ np.diag(np.geomspace(1, 1 / condition, 9)) @ v
        b = a @ rng.normal(size=9)
        exact = sp.Matrix(9, 9, [sp.Rational(value) for value in a.ravel()])
        for x, errors in ((np.linalg.solve(a, b), solved), (np.linalg.inv(a) @ b, inverted)):
            gap = sp.Matrix([sp.Rational(value) for value in b]) - exact * sp.Matrix([sp.Rational(v) for v in x])
            size = np.linalg.norm(a, 2) * np.linalg.norm(x) + np.linalg.norm(b)
            errors.append(float(gap.norm()) / size)
    assert max(solved) < 4 * EPSILON
    assert all(after > 100 * before for before, after in pairwise(inverted))


def test_the_backward_error_of_the_inverse_is_small_where_the_solution_is_large():
    rng = np.random.default_rng(21)
    u, v = (np.linalg.qr(rng.normal(size=(9, 9)))[0] for _ in range(2))
    a, b = u @ np.diag(np.geomspace(1, 1e-12, 9)) @ v, rng.normal(size=9)
    x = np.linalg.inv(a) @ b
    assert np.linalg.norm(a @ x - b) < 4 * EPSILON * np.linalg.norm(a, 2) * np.linalg.norm(x)


def code_cells(chapter):
    return re.findall(r"```\{code-cell\} ipython3\n(.*?)```", (BOOK / f"{chapter}.md").read_text("utf-8"), re.DOTALL)


@pytest.mark.parametrize("n", [2, 3, 9, 15])
def test_the_chapter_counts_a_solve_at_a_third_of_an_inverse(n):
    namespace = {"np": np}
    (cell,) = (cell for cell in code_cells("newton-nd") if "class Counted" in cell)
    exec(cell, namespace)
    counted = np.vectorize(namespace["Counted"], otypes=[object])
    a, b = np.random.default_rng(n).uniform(-1, 1, (n, n)) + n * np.eye(n), np.ones(n)
    counts = []
    for algorithm in (namespace["solve"], lambda a, b: namespace["invert"](a) @ b):
        namespace["Counted"].operations = 0
        x = algorithm(counted(a), counted(b))
        np.testing.assert_allclose([c.value for c in x], np.linalg.solve(a, b), rtol=1e-12)
        counts.append(namespace["Counted"].operations)
    assert counts == [(n**3 + 3 * n**2 - n) // 3, n**3 + n**2]


# --- the pages themselves


@pytest.mark.parametrize("task", [task for e in EXERCISES.values() for task in e.tasks], ids=lambda task: task.name)
def test_a_check_sends_the_student_to_a_section_that_exists(task):
    chapter, _, section = task.section.partition(": ")
    headings = re.findall(r"^#+ (.*)$", (BOOK / f"{chapter}.md").read_text("utf-8"), re.MULTILINE)
    assert section in headings


def test_the_tangents_are_drawn_through_the_iterates_of_newton():
    ax = draw.tangents(lambda x: x**2 - 2, lambda x: 2 * x, seed=2.0, steps=2, window=(0.5, 2.5)).axes[0]
    feet = [line.get_xdata()[1] for line in ax.lines if line.get_color() == draw.RED]
    assert feet == [Fraction(3, 2), pytest.approx(float(Fraction(17, 12)))]


def test_a_horizontal_tangent_is_not_drawn():
    ax = draw.tangents(lambda x: x**2 - 2, lambda x: 2 * x, seed=0.0, steps=3, window=(-1, 1)).axes[0]
    assert not [line for line in ax.lines if line.get_color() == draw.RED]


def test_the_text_of_a_figure_is_at_least_nine_points_high_on_a_phone():
    shrunk = 320 / (96 * draw.STYLE["figure.figsize"][0])  # pixels of a phone's column, CSS pixels of the figure
    assert draw.STYLE["font.size"] * shrunk >= 9


@pytest.mark.parametrize(
    ("printed", "computed", "agrees"),
    [("1.942", 1.94163, True), ("1.941", 1.94163, False), ("0", -1e-18, True), ("62", 61.804, True), ("4", 2, False)],
)
def test_a_verdict_compares_the_printed_digits(printed, computed, agrees):
    assert draw.verdict(printed, computed) == ("agrees, every digit" if agrees else "**differs**")


def test_a_table_escapes_bars_and_refuses_a_ragged_row():
    assert draw.table(("a", "b"), [(1, "|x|")]).splitlines()[-1] == r"| 1 | \|x\| |"
    with pytest.raises(ValueError, match="needs 2 cells, got 1"):
        draw.table(("a", "b"), [(1,)])


@pytest.mark.parametrize("number", [*range(2, 12), 13, *range(21, 25)])
def test_a_figure_of_source_a_has_a_numbered_counterpart_with_alt_text(number):
    cells = re.findall(r"```\{code-cell\} ipython3\n---\n(.*?)\n---\n", _chapters(), re.DOTALL)
    told = [cell for cell in cells if re.search(rf"ounterpart of source A, figure {number}\b", cell)]
    assert len(told) == 1
    assert re.search(r"^    name: fig-", told[0], re.MULTILINE)
    assert re.search(r"^    alt: ", told[0], re.MULTILINE)


@pytest.mark.parametrize(
    "place",
    [
        *("equation (5), first", "equation (5), second", "equation (5), third", "final speed", "listing E.1", "5.2.1"),
        *("appendix D", "figure 9"),
    ],
)
def test_a_mistake_of_source_a_stands_in_a_box_of_its_own(place):
    """A1 to A3, A4, A9, A5; A7, A11."""
    boxes = re.findall(r":::\{admonition\} (Source A.*?)\n:class: warning", _chapters())
    assert any(place in box for box in boxes), boxes


def _chapters():
    return "\n".join(path.read_text("utf-8") for path in sorted(BOOK.glob("*.md")))
