"""Claims of the chapter that checks the hacksaw, proven without the code that the chapter calls."""

import re
from functools import cache
from pathlib import Path

import mpmath
import numpy as np
import pytest
import scipy.optimize
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

BOOK = Path(__file__).parents[1] / "book"
R1Y, R2, R3 = 0.045, 0.075, 0.170  # m, source A
SHORT = 0.100  # m, the coupler of the first failure
SEED = np.array([-0.0997, -0.4684, 2.8737])
T = np.sqrt(6 * np.pi / 5)
TIMES = np.linspace(0, 2 * T, 1000)
lengths = st.floats(0.01, 1.0)


def crank(t):
    """theta2, omega2, alpha2 of the motor: the acceleration by hand, the others from its antiderivatives."""
    pieces = [t < T / 3, (t >= T / 3) & (t < 2 * T / 3), (t >= 2 * T / 3) & (t < T)]
    alpha = np.select(pieces, [15 * t / T, np.full_like(t, 5), 15 - 15 * t / T], 0)
    omega = np.select(
        pieces,
        [15 * t**2 / (2 * T), 5 * t - 5 * T / 6, 15 * t - 25 * T / 6 - 15 * t**2 / (2 * T)],
        10 * T / 3,
    )
    theta = np.select(
        pieces,
        [
            5 * t**3 / (2 * T),
            5 * t**2 / 2 - 5 * T * t / 6 + 5 * T**2 / 54,
            15 * t**2 / 2 - 25 * T * t / 6 - 5 * t**3 / (2 * T) + 5 * T**2 / 6,
        ],
        10 * T * t / 3 - 5 * T**2 / 3,
    )
    return theta, omega, alpha


CRANK = THETA2, OMEGA2, ALPHA2 = crank(TIMES)


def by_sines(u, w, a, r1y=R1Y, r2=R2, r3=R3, m=np):
    """The nine quantities as the chapter derives them, in the numbers of `m`: NumPy's or fifty digits."""
    asin, atan2 = (m.arcsin, m.arctan2) if m is np else (m.asin, m.atan2)
    th3 = m.pi - asin((r1y - r2 * m.sin(u)) / r3)
    across, up = r3 * m.cos(th3), r3 * m.sin(th3)
    x = r2 * m.cos(u) + across
    r1, th1 = -m.sqrt(x**2 + r1y**2), atan2(-r1y, -x)
    w3 = -w * r2 * m.cos(u) / across
    al3 = (r2 * m.sin(u) * w**2 + up * w3**2 - a * r2 * m.cos(u)) / across
    dx = -r2 * m.sin(u) * w - up * w3
    ddx = -r2 * (m.cos(u) * w**2 + m.sin(u) * a) - across * w3**2 - up * al3
    vr, w1 = dx * m.cos(th1), -dx * m.sin(th1) / r1
    return [r1, th1, th3, vr, w1, w3, ddx * m.cos(th1) + r1 * w1**2, -(ddx * m.sin(th1) + 2 * vr * w1) / r1, al3]


NINE = np.array(by_sines(*CRANK)).T
SPAN = np.ptp(NINE, axis=0)


def loop(q, theta2, r3=R3):
    z = R2 * np.exp(1j * theta2) + r3 * np.exp(1j * q[2]) - q[0] * np.exp(1j * q[1])
    return np.array([z.real, -z.imag, q[0] * np.sin(q[1]) - R1Y])


# --- a check that cannot fail


def test_a_least_squares_solver_reports_success_at_all_points_and_181_of_them_cannot_close():
    closed = np.abs(R1Y - R2 * np.sin(THETA2)) <= SHORT
    q, found = SEED, []
    for theta2 in THETA2:
        solved = scipy.optimize.root(loop, q, args=(theta2, SHORT), method="lm")
        assert solved.success
        q = solved.x
        found.append(q)
    found = np.array(found)
    residual = np.abs([loop(q, theta2, SHORT) for q, theta2 in zip(found, THETA2, strict=True)]).max(axis=1)
    assert (~closed).sum() == 181
    assert residual[~closed].max() == pytest.approx(0.010, abs=1e-4)
    assert residual[closed].max() < 1e-6
    assert (np.cos(found[closed, 2]) > 0).sum() > 100  # behind a gap it is in the other assembly


# --- the closed form


@given(lengths, lengths, lengths, st.floats(-10, 10))
def test_the_closed_form_closes_the_loop_on_the_left_of_the_pin(r1y, r2, reach, u):
    r3 = abs(r1y - r2 * np.sin(u)) + reach
    r1, th1, th3, *_ = by_sines(u, 0.0, 0.0, r1y, r2, r3)
    z = r2 * np.exp(1j * u) + r3 * np.exp(1j * th3)
    assert abs(z - r1 * np.exp(1j * th1)) < 4e-15 * (r2 + r3)
    assert z.imag == pytest.approx(r1y, abs=4e-15 * (r2 + r3))
    assert np.cos(th3) < 0 > r1


@given(lengths, lengths, st.floats(1e-6, 1.0))
def test_a_saw_whose_crank_turns_all_the_way_round_never_passes_its_shaft(r1y, r2, more):
    """It must reach the guide with the pin at its lowest."""
    u = np.linspace(0, 2 * np.pi, 721)
    r3 = r1y + r2 + more
    x = r2 * np.cos(u) - np.sqrt(r3**2 - (r1y - r2 * np.sin(u)) ** 2)
    assert (x < 0).all()


def test_the_quotient_of_the_source_leaps_by_half_a_turn_where_the_short_saw_passes_its_shaft():
    closed = THETA2[np.abs(R1Y - R2 * np.sin(THETA2)) <= SHORT]
    r1, th1, th3, *_ = by_sines(closed, 0.0, 0.0, r3=SHORT)
    x = R2 * np.cos(closed) + SHORT * np.cos(th3)
    quotient = np.arctan(R1Y / x)
    np.testing.assert_allclose(quotient - th1, np.where(x > 0, np.pi, 0), atol=1e-14)
    assert (x > 0).sum() == 56
    length = R1Y / np.sin(quotient)  # the loop stays closed, with the other sign of the length
    np.testing.assert_allclose(length, np.where(x > 0, -r1, r1), rtol=1e-13)


@pytest.mark.parametrize("k", [100, 333, 700])
def test_the_rates_are_the_derivatives_of_the_position_in_fifty_digits(k):
    with mpmath.workdps(50):
        u, w, a = (mpmath.mpf(float(c[k])) for c in CRANK)
        nine = by_sines(u, w, a, *map(mpmath.mpf, (R1Y, R2, R3)), m=mpmath)
        for i in range(3):

            def moved(t, i=i):
                return by_sines(u + w * t + a * t**2 / 2, 0, 0, *map(mpmath.mpf, (R1Y, R2, R3)), m=mpmath)[i]

            assert abs(mpmath.diff(moved, 0) - nine[3 + i]) < 1e-20
            assert abs(mpmath.diff(moved, 0, 2) - nine[6 + i]) < 1e-10


def test_of_equations_20_to_28_only_the_names_of_22_and_23_are_wrong_and_none_gives_r1():
    r1, th1, th3, vr, w1, w3, ar, _, al3 = NINE.T
    s2, c2, s3, c3 = R2 * np.sin(THETA2), R2 * np.cos(THETA2), R3 * np.sin(th3), R3 * np.cos(th3)
    acot = np.arctan(R1Y / (c2 + c3))
    printed = {
        20: ("th3", np.pi - np.arcsin((R1Y - s2) / R3)),
        21: ("th1", acot),
        22: ("r1", -OMEGA2 * c2 / c3),
        23: ("w3", acot),
        24: ("w1", -vr * np.tan(th1) / r1),
        25: ("vr", -np.cos(th1) * (OMEGA2 * s2 + w3 * s3)),
        26: ("al3", (s2 * OMEGA2**2 + s3 * w3**2 - ALPHA2 * c2) / c3),
        27: ("al1", w1**2 * np.tan(th1) - (2 * vr * w1 + ar * np.tan(th1)) / r1),
        28: ("ar", r1 * w1**2 - np.cos(th1) * (c2 * OMEGA2**2 + c3 * w3**2 + ALPHA2 * s2 + al3 * s3)),
    }
    names = "r1 th1 th3 vr w1 w3 ar al1 al3".split()
    gives = {}
    for number, (_, side) in printed.items():
        (k,) = np.flatnonzero((np.abs(NINE - side[:, None]) / SPAN).max(axis=0) < 1e-12)
        gives[number] = names[k]
    assert {n: gives[n] for n in printed if gives[n] != printed[n][0]} == {22: "w3", 23: "th1"}
    assert "r1" not in gives.values()


# --- whose error it is, and what the time is made of


@cache
def system():
    """The nine equations and their Jacobian, from the loop in SymPy, with functions of the time."""
    t = sp.Symbol("t")
    q = [sp.Function(name)(t) for name in ("r1", "th1", "th3")]
    u = sp.Function("u")(t)
    r1, th1, th3 = q
    closure = sp.Matrix(
        [
            -r1 * sp.cos(th1) + R2 * sp.cos(u) + R3 * sp.cos(th3),
            r1 * sp.sin(th1) - R2 * sp.sin(u) - R3 * sp.sin(th3),
            r1 * sp.sin(th1) - R1Y,
        ]
    )
    everything = sp.Matrix.vstack(closure, closure.diff(t), closure.diff(t, 2))
    functions = [f.diff(t, n) if n else f for n in range(3) for f in (*q, u)]
    symbols = sp.symbols(f"s:{len(functions)}")
    everything = everything.subs(dict(reversed(list(zip(functions, symbols, strict=True)))))
    state, given_ = [s for i, s in enumerate(symbols) if i % 4 != 3], symbols[3::4]
    arguments = (*state, *given_)
    return tuple(sp.lambdify(arguments, m, cse=True) for m in (everything, everything.jacobian(state)))


def iterate(residual, jacobian, x, tol):
    for n in range(1, 20):
        step = np.linalg.solve(jacobian(x), residual(x))
        x = x - step
        if np.linalg.norm(step) < tol:
            return x, n
    raise ArithmeticError("no root")


@cache
def together():
    """The simultaneous solver at 1000 points: results, and iterations in all."""
    equations, jacobian = system()
    x, found, iterations = np.concatenate((SEED, np.zeros(6))), [], 0
    for given_ in zip(*CRANK, strict=True):
        x, n = iterate(
            lambda x, g=given_: equations(*x, *g).ravel(), lambda x, g=given_: jacobian(*x, *g).astype(float), x, 1e-6
        )
        found.append(x)
        iterations += n
    return np.array(found), iterations


def test_a11_the_simultaneous_solver_has_errors_of_the_order_that_source_a_says_and_its_axis_cuts_many_off():
    errors = np.abs(together()[0] - NINE)
    position, velocity, acceleration = errors.max(axis=0).reshape(3, 3).max(axis=1)
    assert 1e-16 < position < 1e-15
    assert 1e-16 < velocity < 1e-14
    assert 1e-15 < acceleration < 1e-13
    assert min((errors[:, 7:] > 1e-15).sum(axis=0)) > 100


def test_the_consecutive_solver_leaves_the_square_of_its_last_step_until_the_tolerance_is_smaller():
    def jacobian(q):
        slide, coupler = np.exp(1j * q[1]), R3 * 1j * np.exp(1j * q[2])
        across = 1j * q[0] * slide
        rows = [-slide.real, -across.real, coupler.real], [slide.imag, across.imag, -coupler.imag]
        return np.array([*rows, [slide.imag, across.imag, 0]])

    for tol, least, most in ((1e-6, 1e-13, 1e-11), (1e-9, 0, 1e-15)):
        q, off, iterations = SEED, [], 0
        for theta2, exact in zip(THETA2, NINE, strict=True):
            q, n = iterate(lambda q, u=theta2: loop(q, u), jacobian, q, tol)
            off.append(np.abs(q - exact[:3]).max())
            iterations += n
        assert least < max(off) < most
        if tol == 1e-6:
            assert iterations == pytest.approx(2879, abs=3)
    assert together()[1] == pytest.approx(3023, abs=3)


def test_in_fifty_digits_the_closed_form_is_no_nearer_to_the_truth_than_the_solver():
    sample = np.arange(10, 1000, 20)
    off = {}
    with mpmath.workdps(50):
        true = [
            by_sines(*(mpmath.mpf(float(c[k])) for c in (*CRANK,)), *map(mpmath.mpf, (R1Y, R2, R3)), m=mpmath)
            for k in sample
        ]
        for name, found in (("formulas", NINE), ("solver", together()[0])):
            distances = [
                [abs(mpmath.mpf(float(c)) - t) for c, t in zip(found[k], row, strict=True)]
                for k, row in zip(sample, true, strict=True)
            ]
            off[name] = np.array(distances, dtype=float) / np.spacing(np.abs(NINE).max(axis=0))
    assert off["formulas"].max() < 30  # spacings
    assert off["solver"].max() < 30
    assert off["formulas"].mean() > 0.8 * off["solver"].mean()


def test_the_condition_of_nine_equations_is_mostly_the_choice_of_the_second():
    _, jacobian = system()
    matrices = np.array([jacobian(*x, *g) for x, g in zip(NINE, zip(*CRANK, strict=True), strict=True)], dtype=float)
    small = matrices[:, :3, :3]
    np.testing.assert_allclose(np.linalg.det(matrices), np.linalg.det(small) ** 3, rtol=1e-9)
    assert (matrices[:, :3, 3:] == 0).all()
    assert (matrices[:, 3:6, 6:] == 0).all()
    scale = np.repeat(OMEGA2[-1] ** np.arange(3), 3)
    ranges = [(c.min(), c.max()) for c in map(np.linalg.cond, (small, matrices, matrices * scale / scale[:, None]))]
    assert ranges[0] == (pytest.approx(9.07, abs=0.01), pytest.approx(18.35, abs=0.01))
    assert ranges[1] == (pytest.approx(14.5, abs=0.1), pytest.approx(8824, abs=10))
    assert ranges[2][1] < 40


# --- the engine


def stored(name):
    return np.loadtxt(BOOK / "engine" / f"{name}.csv", delimiter=",")


def test_the_engine_s_motion_is_that_of_the_formulas_within_what_is_demanded():
    parts = np.abs(stored("hacksaw")[:, 1:] - NINE).max(axis=0) / SPAN
    assert (parts < np.repeat([1e-14, 1e-6, 1e-5], 3)).all()


def test_the_difference_that_is_left_falls_with_the_square_of_the_engine_s_step():
    steps = stored("hacksaw_steps")
    orders = np.log(steps[:-1, 4:] / steps[1:, 4:]) / np.log(steps[:-1, :1] / steps[1:, :1])
    np.testing.assert_allclose(orders, 2, atol=0.05)


@pytest.mark.parametrize(("wrong", "by_eye"), [(1e-3, True), (1e-4, False), (1e-5, False), (1e-9, False)])
def test_the_eye_misses_a_tenth_of_a_millimetre_and_the_number_sees_a_nanometre(wrong, by_eye):
    other = np.array(by_sines(*CRANK, r3=R3 + wrong)[:3]).T
    off = (np.abs(other - NINE[:, :3]) / SPAN[:3]).max()
    assert (off > 0.01) == by_eye
    assert off > 1e-9


# --- the page itself

PAGE = (BOOK / "hacksaw-validation.md").read_text("utf-8")


@pytest.mark.parametrize("number", [12, *range(14, 21), *range(25, 29)])
def test_a_figure_of_source_a_has_a_counterpart_here_with_alt_text_and_a_row_in_the_table(number):
    cells = re.findall(r"```\{code-cell\} ipython3\n---\n(.*?)\n---\n", PAGE, re.DOTALL)
    (told,) = (cell for cell in cells if re.search(rf"ounterpart of source A, figure {number}\b", cell))
    assert re.search(r"^    alt: ", told, re.MULTILINE)
    name = re.search(r"^    name: (fig-\S+)", told, re.MULTILINE)[1]
    (row,) = (line for line in PAGE.splitlines() if re.match(rf"\| [\d, ]*\b{number}\b[\d, ]*, ", line))
    assert f"{{numref}}`{name}`" in row


def test_each_of_the_28_figures_of_source_a_has_one_row_in_the_table_and_its_counterparts_exist():
    rows = re.findall(r"^\| ([\d, ]+), [^|]*\| (\{numref\}.*?) \|$", PAGE, re.MULTILINE)
    told = sorted(int(number) for numbers, _ in rows for number in numbers.split(", "))
    assert told == list(range(1, 29))
    named = set(
        re.findall(r"^    name: (fig-\S+)", "\n".join(p.read_text("utf-8") for p in BOOK.glob("*.md")), re.MULTILINE)
    )
    assert {name for _, here in rows for name in re.findall(r"`(fig-[\w-]+)`", here)} <= named


@pytest.mark.parametrize("place", ["equation (22)", "7.1", "7.2"])
def test_a_mistake_of_source_a_stands_in_a_box_of_its_own(place):
    """A6, A8, A11."""
    boxes = re.findall(r":::\{admonition\} (Source A.*?)\n:class: warning", PAGE)
    assert len([box for box in boxes if place in box]) == 1


def test_the_sections_have_the_names_that_the_checks_send_to():
    headings = re.findall(r"^## (.*)$", PAGE, re.MULTILINE)
    assert headings[1:-1] == [
        "The closed form",
        "All nine in closed form",
        "Whose error is it?",
        "An independent engine",
        "What the time is made of",
        "All points at once",
        "What the source printed",
        "The exercise",
    ]
