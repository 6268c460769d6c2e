"""What source A gets wrong about the hacksaw (A5 to A8, A10, A11), proven in symbols and numbers, without mechlib."""

import numpy as np
import pytest
import sympy as sp
from sympy import cos, cot, sin, tan

t = sp.Symbol("t")
r1y, r2, r3 = sp.symbols("r_1y r_2 r_3", positive=True)
r1, th1, th2, th3 = sp.symbols("r_1 theta_1:4")
vr, w1, w2, w3 = sp.symbols("v_r omega_1:4")
ar, al1, al2, al3 = sp.symbols("a_r alpha_1:4")
UNKNOWNS = (r1, th1, th3, vr, w1, w3, ar, al1, al3)
LENGTHS = {r1y: sp.Rational(45, 1000), r2: sp.Rational(75, 1000), r3: sp.Rational(170, 1000)}
SEED = [-0.1, -0.5, 3, 0.5, 0, -0.5, 0.5, 0, -0.5]  # (16)

FX = -r1 * cos(th1) + r2 * cos(th2) + r3 * cos(th3)  # (7)
FY = r1 * sin(th1) - r2 * sin(th2) - r3 * sin(th3)  # (8)
FC = r1 * sin(th1) - r1y  # (9)


def dot(f):
    """The time derivative."""
    chain = ((r1, vr), (th1, w1), (th2, w2), (th3, w3), (vr, ar), (w1, al1), (w2, al2), (w3, al3))
    return sum(f.diff(x) * dx for x, dx in chain)


def eliminated(f):
    """With r1 = r1y / sin(theta1), as the programs of the source have the position equations."""
    return f.subs(r1, r1y / sin(th1))


POSITION = (FC, eliminated(FX), eliminated(FY))
APPENDIX_D = (*POSITION, dot(FX), dot(FY), dot(FC), dot(dot(FC)), dot(dot(FX)), dot(dot(FY)))  # its rows


def printed_d():
    s1 = -r1 * cos(th1) * w1**2 - 2 * vr * sin(th1) * w1 + ar * cos(th1) - al1 * r1 * sin(th1)
    s2 = 2 * vr * cos(th1) - 2 * w1 * r1 * sin(th1)
    s3 = al1 * cos(th1) - w1**2 * sin(th1)
    s4, s5 = -r3 * sin(th3), -r3 * cos(th3)
    s6 = vr * cos(th1) - w1 * r1 * sin(th1)
    s7 = 2 * w1 * cos(th1)
    along = -r1 * sin(th1) * w1**2 + 2 * vr * cos(th1) * w1 + ar * sin(th1) + al1 * r1 * cos(th1)
    return sp.Matrix(
        [
            [sin(th1), r1 * cos(th1), 0, 0, 0, 0, 0, 0, 0],
            [0, r1y * (cot(th1) ** 2 + 1), s4, 0, 0, 0, 0, 0, 0],
            [0, 0, s5, 0, 0, 0, 0, 0, 0],
            [w1 * sin(th1), vr * sin(th1) + w1 * r1 * cos(th1), w3 * s5, -cos(th1), r1 * sin(th1), s4, 0, 0, 0],
            [w1 * cos(th1), s6, -w3 * s4, sin(th1), r1 * cos(th1), s5, 0, 0, 0],
            [w1 * cos(th1), s6, 0, sin(th1), r1 * cos(th1), 0, 0, 0, 0],
            [s3, s1, 0, s7, s2, 0, s7, cos(th1), 0],
            [
                cos(th1) * w1**2 + al1 * sin(th1),
                along,
                w3**2 * r3 * sin(th3) - al3 * r3 * cos(th3),
                2 * w1 * sin(th1),
                2 * vr * sin(th1) + 2 * w1 * r1 * cos(th1),
                -2 * w3 * r3 * cos(th3),
                -cos(th1),
                r1 * sin(th1),
                s4,
            ],
            [s3, s1, -(s5 * w3**2 + al3 * s4), s7, s2, -2 * w3 * s4, sin(th1), r1 * cos(th1), s5],
        ]
    )  # fmt: skip


def numeric(expressions, symbols=(*UNKNOWNS, th2, w2, al2)):
    return sp.lambdify(symbols, sp.Matrix(expressions).subs(LENGTHS), "numpy")


def differing(printed, right, states=8):
    """Entries that are not the same at random states, counted from one."""
    rng = np.random.default_rng(7)
    f, g = numeric(printed), numeric(right)
    found = set()
    for _ in range(states):
        x = rng.uniform(0.3, 1.3, 12) * rng.choice([-1, 1], 12)
        found |= {(int(i) + 1, int(j) + 1) for i, j in zip(*np.nonzero(np.abs(f(*x) - g(*x)) > 1e-9), strict=True)}
    return found


def iterations(equations, jacobian, unknowns, seed, known, tol=1e-6):
    """How many steps of Newton-Raphson until one is shorter than tol, and where they end."""
    symbols = (*unknowns, *known)
    f, j = numeric(equations, symbols), numeric(jacobian, symbols)
    x = np.array(seed, dtype=float)
    for count in range(1, 51):
        d = np.linalg.solve(j(*x, *known.values()), f(*x, *known.values()).ravel())
        x = x - d
        if np.linalg.norm(d) < tol:
            return count, x
    raise ArithmeticError("no root")


def by_stages(position, jacobian):
    """Iterations of position, velocity, acceleration and of all nine at once, at rest from the seed of the source."""
    rest = {th2: 0.0, w2: 0.0, al2: 0.0}
    first, q = iterations(position, jacobian, UNKNOWNS[:3], SEED[:3], rest)
    known, counts = rest | dict(zip(UNKNOWNS[:3], q, strict=True)), [first]
    rates = [dot(f) for f in (FX, FY, FC)]
    for stage, equations in enumerate((rates, [dot(f) for f in rates]), start=1):
        now = UNKNOWNS[3 * stage : 3 * stage + 3]
        equations = [f.subs(dict.fromkeys(UNKNOWNS[3 * stage + 3 :], 0)) for f in equations]
        count, x = iterations(
            equations, sp.Matrix(equations).jacobian(now), now, SEED[3 * stage : 3 * stage + 3], known
        )
        known |= dict(zip(now, x, strict=True))
        counts.append(count)
    everything = [*position, *rates, *(dot(f) for f in rates)]
    counts.append(iterations(everything, sp.Matrix(everything).jacobian(UNKNOWNS), UNKNOWNS, SEED, rest)[0])
    return counts


def exact_motion():
    """The nine unknowns as functions of time, for an arbitrary motion of the crank, from the geometry alone."""
    crank = sp.Rational(7, 5) * t**2 + t + sp.Rational(2, 5)
    coupler = sp.pi - sp.asin((r1y - r2 * sin(crank)) / r3)
    x = r2 * cos(crank) + r3 * cos(coupler)
    length, angle = -sp.sqrt(x**2 + r1y**2), sp.atan(r1y / x)
    nine = [q.diff(t, n) for n in range(3) for q in (length, angle, coupler)]
    values = [*nine, crank, crank.diff(t), crank.diff(t, 2)]
    return {
        s: v.subs(LENGTHS).subs(t, sp.Rational(1, 7)).evalf(30)
        for s, v in zip((*UNKNOWNS, th2, w2, al2), values, strict=True)
    }


def test_a5_and_a10_4_2_2_and_5_iterations_with_r1_eliminated_or_not():
    plain = (FX, FY, FC)
    assert by_stages(plain, sp.Matrix(plain).jacobian(UNKNOWNS[:3])) == [4, 2, 2, 5]
    assert by_stages(POSITION, sp.Matrix(POSITION).jacobian(UNKNOWNS[:3])) == [4, 2, 2, 5]


CLOSED_FORM = {  # section 5.3, as printed
    20: (th3, sp.pi - sp.asin((r1y - r2 * sin(th2)) / r3)),
    21: (th1, sp.acot((r2 * cos(th2) + r3 * cos(th3)) / r1y)),
    22: (r1, -w2 * r2 * cos(th2) / (r3 * cos(th3))),
    23: (w3, sp.acot((r2 * cos(th2) + r3 * cos(th3)) / r1y)),
    24: (w1, -vr * tan(th1) / r1),
    25: (vr, -cos(th1) * (w2 * r2 * sin(th2) + w3 * r3 * sin(th3))),
    26: (al3, (r2 * sin(th2) * w2**2 + r3 * sin(th3) * w3**2 - al2 * r2 * cos(th2)) / (r3 * cos(th3))),
    27: (al1, w1**2 * tan(th1) - (2 * vr * w1 + ar * tan(th1)) / r1),
    28: (
        ar,
        r1 * w1**2
        - r2 * cos(th1) * cos(th2) * w2**2
        - r3 * cos(th1) * cos(th3) * w3**2
        - al2 * r2 * cos(th1) * sin(th2)
        - al3 * r3 * cos(th1) * sin(th3),
    ),
}


@pytest.mark.parametrize("number", CLOSED_FORM)
def test_a6_of_the_closed_form_only_equations_22_and_23_are_wrong(number):
    named, formula = CLOSED_FORM[number]
    motion = exact_motion()
    off = abs((formula - named).subs(LENGTHS).subs(motion).evalf(30))
    assert (off < 1e-20) == (number not in (22, 23))


def test_a6_equation_22_gives_omega_3_and_23_gives_theta_1_and_r1_is_missing():
    motion = exact_motion()
    for number, meant in ((22, w3), (23, th1)):
        assert abs((CLOSED_FORM[number][1] - meant).subs(LENGTHS).subs(motion).evalf(30)) < 1e-20
    assert abs((r1y / sin(th1) - r1).subs(LENGTHS).subs(motion).evalf(30)) < 1e-20


def test_a6_the_units_of_equation_22_are_those_of_a_speed_of_turning():
    """Take all lengths k times and all times c times: a length grows k times, an angular velocity falls c times."""
    k, c = sp.symbols("k c", positive=True)
    formula = CLOSED_FORM[22][1]
    scaled = formula.subs({r2: k * r2, r3: k * r3, w2: w2 / c}, simultaneous=True)
    assert sp.simplify(scaled / formula) == 1 / c


def test_a7_finite_differences_of_the_system_find_two_wrong_entries_in_row_7_of_appendix_d():
    rng = np.random.default_rng(3)
    f, printed = numeric(APPENDIX_D), numeric(printed_d())
    wrong = set()
    for _ in range(5):
        x, h = rng.uniform(0.3, 1.3, 12) * rng.choice([-1, 1], 12), 1e-5
        rises = [(f(*(x + h * e)) - f(*(x - h * e))).ravel() / (2 * h) for e in np.eye(12)[:9]]
        off = np.abs(printed(*x) - np.array(rises).T)
        wrong |= {(int(i) + 1, int(j) + 1) for i, j in zip(*np.nonzero(off > 1e-6), strict=True)}
    assert wrong == {(7, 7), (7, 8)}


def test_a7_in_place_of_sigma_7_and_cos_theta_1_stand_sin_theta_1_and_r1_cos_theta_1():
    right = sp.Matrix(APPENDIX_D).jacobian(UNKNOWNS)
    assert differing(printed_d(), right) == {(7, 7), (7, 8)}
    assert sp.simplify(right[6, 6] - sin(th1)) == sp.simplify(right[6, 7] - r1 * cos(th1)) == 0
    assert sp.simplify(printed_d()[6, 6] - 2 * w1 * cos(th1)) == sp.simplify(printed_d()[6, 7] - cos(th1)) == 0


@pytest.mark.parametrize("crank", [(0.0, 0.0, 0.0), (1.0, 6.0, 5.0)], ids=["at rest", "moving"])
def test_a7_with_the_printed_matrix_the_accelerations_diverge(crank):
    """One row is wrong, so the error grows along one direction, by 1 - det K / det B an iteration."""
    f, printed, right = (numeric(m) for m in (APPENDIX_D, printed_d(), sp.Matrix(APPENDIX_D).jacobian(UNKNOWNS)))
    known = dict(zip((th2, w2, al2), crank, strict=True))
    _, root = iterations(APPENDIX_D, sp.Matrix(APPENDIX_D).jacobian(UNKNOWNS), UNKNOWNS, SEED, known)
    growth = 1 - np.linalg.det(right(*root, *crank)) / np.linalg.det(printed(*root, *crank))
    assert growth > 1
    x, steps = root + 1e-7, []
    for _ in range(30):
        d = np.linalg.solve(printed(*x, *crank), f(*x, *crank).ravel())
        x, steps = x - d, [*steps, np.linalg.norm(d)]
    assert steps[-1] / steps[-2] == pytest.approx(growth, rel=1e-3)


def test_a10_matrix_17_and_appendix_c1_belong_to_the_system_with_r1_eliminated():
    printed = sp.Matrix(
        [
            [sin(th1), r1 * cos(th1), 0],
            [0, r1y * (cot(th1) ** 2 + 1), -r3 * sin(th3)],
            [0, 0, -r3 * cos(th3)],
        ]
    )
    assert differing(printed, sp.Matrix(POSITION).jacobian(UNKNOWNS[:3])) == set()
    for rows in ((FC, FX, FY), (FC, FY, FX), (FX, FY, FC), (FX, FC, FY), (FY, FX, FC), (FY, FC, FX)):
        assert differing(printed, sp.Matrix(rows).jacobian(UNKNOWNS[:3])) != set()
    s1 = cot(th1) ** 2 + 1
    first = r1 * cos(th1) / (r1y * sin(th1) * s1)
    inverse = sp.Matrix(
        [
            [1 / sin(th1), -first, first * sin(th3) / cos(th3)],
            [0, 1 / (r1y * s1), -sin(th3) / (r1y * cos(th3) * s1)],
            [0, 0, -1 / (r3 * cos(th3))],
        ]
    )  # fmt: skip
    assert differing(inverse * printed, sp.eye(3)) == set()
