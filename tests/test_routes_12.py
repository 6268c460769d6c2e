"""Exercise 12: other right ways get full points, and ways that only look right do not."""

import math
import random
import statistics

import numpy as np
import pytest
from judging import answering, judged, paper
from scipy.optimize import fsolve
from scipy.stats import linregress, qmc

from autograder.checks import task
from autograder.checks.e12_monte_carlo import (
    ALARM,
    COUPLER_POINT,
    LINEAR_PROPAGATION,
    PAIRS,
    PROPAGATE,
    half_widths,
    moments_by_ends,
    throws_by_the_law,
    wrong_part,
)
from autograder.outcome import Value
from autograder.spec import Trial, recorded
from mechlib.fourbar import LENGTHS, FourBar
from mechlib.implicit import Quantities
from mechlib.laws import tolerances
from mechlib.uncertainty import quasi_monte_carlo

DRAWS = [f"route {n}" for n in range(10)]


def faults(assessment):
    return [finding.fault for finding in assessment.findings if finding.fault]


# --- coupler point


def refuse(lengths):
    short = lengths[:, :4].min(axis=1) <= 0
    if short.any():
        raise ValueError(f"bars of {lengths[short][0, :4].tolist()} m")


def by_mechlib(theta2, lengths, branch="open", frame=(0.0, 0.0, 0.0)):
    refuse(lengths)
    return FourBar(*lengths.T, *frame).coupler_point(theta2, branch, "leave out")


def by_circles(theta2, lengths, branch="open", frame=(0.0, 0.0, 0.0)):
    """B is where two circles meet; row by row, with plain floats."""
    refuse(lengths)
    x0, y0, theta0 = frame
    points = []
    for r1, r2, r3, r4, rcx, rcy in lengths.tolist():
        ax, ay = r2 * math.cos(theta2), r2 * math.sin(theta2)
        ux, uy = r1 - ax, -ay
        d = math.hypot(ux, uy)
        foot = (d * d + r3 * r3 - r4 * r4) / (2 * d)
        if abs(foot) > r3:
            points.append((math.nan, math.nan))
            continue
        height = math.sqrt(r3 * r3 - foot * foot) * (1 if branch == "open" else -1)
        tx, ty = (foot * ux - height * uy) / d / r3, (foot * uy + height * ux) / d / r3
        px, py = ax + rcx * tx - rcy * ty, ay + rcx * ty + rcy * tx
        c, s = math.cos(theta0), math.sin(theta0)
        points.append((x0 + c * px - s * py, y0 + s * px + c * py))
    return points


def by_newton(theta2, lengths, branch="open", frame=(0.0, 0.0, 0.0)):
    """From a start on the right side of the diagonal; the frame as a matrix."""
    refuse(lengths)
    points = np.full((len(lengths), 2), np.nan)
    turn = np.array([[np.cos(frame[2]), -np.sin(frame[2])], [np.sin(frame[2]), np.cos(frame[2])]])
    for point, (r1, r2, r3, r4, rcx, rcy) in zip(points, lengths, strict=True):
        A = r2 * np.array([np.cos(theta2), np.sin(theta2)])
        diagonal = np.array([r1, 0]) - A
        if not abs(r3 - r4) <= np.hypot(*diagonal) <= r3 + r4:
            continue

        def gap(B, A=A, r1=r1, r3=r3, r4=r4):
            return [np.hypot(*(B - A)) - r3, np.hypot(*(B - [r1, 0])) - r4]

        side = 1 if branch == "open" else -1
        start = A + diagonal / 2 + side * r4 * np.array([-diagonal[1], diagonal[0]]) / np.hypot(*diagonal)
        e = (fsolve(gap, start, xtol=1e-13) - A) / r3
        point[:] = turn @ (A + rcx * e + rcy * np.array([-e[1], e[0]])) + frame[:2]
    return points


# --- propagate


def enough(throws):
    if throws < 2:
        raise ValueError(f"throws = {throws}")


def all_closed(points):
    lost = np.isnan(np.asarray(points)[:, 0]).sum()
    if lost:
        raise ValueError(f"of {len(points)} machines {lost} cannot be built")


def by_an_old_generator(point, nominal, half_width, throws, seed=0):
    """Unseeded; x and y in two calls, and the deviation from the covariance."""
    enough(throws)
    thrown = nominal + half_width * (2 * np.random.rand(throws, 6) - 1)  # noqa: NPY002
    x, y = point(thrown)[:, 0], point(thrown)[:, 1]
    all_closed(np.column_stack((x, y)))
    return [x.mean(), y.mean()], np.sqrt(np.diag(np.cov(x, y)))


def by_the_standard_library(point, nominal, half_width, throws, seed=0):
    enough(throws)
    generator = random.Random(seed)
    rows = [[generator.uniform(a - w, a + w) for a, w in zip(nominal, half_width, strict=True)] for _ in range(throws)]
    points = np.asarray(point(np.array(rows))).tolist()
    all_closed(points)
    x, y = zip(*points, strict=True)
    return (statistics.fmean(x), statistics.fmean(y)), (statistics.stdev(x), statistics.stdev(y))


def by_a_latin_hypercube(point, nominal, half_width, throws, seed=0):
    """More even than chance; with a look at the nominal point, from which it counts so that nothing cancels."""
    enough(throws)
    unit = qmc.LatinHypercube(6, rng=np.random.default_rng(seed)).random(throws)
    points = point(qmc.scale(unit, nominal - half_width, nominal + half_width))
    all_closed(points)
    start = point(nominal)
    off = points - start
    square = (off**2).sum(axis=0) - throws * off.mean(axis=0) ** 2
    return start + off.mean(axis=0), (square / (throws - 1)) ** 0.5


def by_another_bit_generator(point, nominal, half_width, throws, seed=0):
    """Length by length, and in two blocks."""
    enough(throws)
    rng = np.random.Generator(np.random.Philox(seed))
    thrown = np.column_stack([rng.uniform(a - w, a + w, throws) for a, w in zip(nominal, half_width, strict=True)])
    points = np.vstack([point(thrown[: throws // 2]), point(thrown[throws // 2 :])])
    all_closed(points)
    return points.mean(axis=0), np.std(points, axis=0) * math.sqrt(throws / (throws - 1))


# --- linear propagation


def derivable(theta2, q, lengths):
    r1, r2, r3, r4, *_ = lengths
    for k, (t2, (t3, t4)) in enumerate(zip(theta2, q, strict=True)):
        x = r2 * math.cos(t2) + r3 * math.cos(t3) - r1 - r4 * math.cos(t4)
        y = r2 * math.sin(t2) + r3 * math.sin(t3) - r4 * math.sin(t4)
        if math.hypot(x, y) > 1e-6 or abs(math.sin(t4 - t3)) < 1e-6:
            raise ValueError(f"point {k} has no derivatives")


def combined(gradient, half_width):
    return gradient, np.linalg.norm(gradient * half_width / 3**0.5, axis=2)


def by_symbols(theta2, q, lengths, half_width):
    derivable(theta2, q, lengths)
    point = Quantities.of(FourBar, FourBar.symbols["P"], FourBar.parameters[:6])
    return combined(point.gradient(FourBar(*lengths), theta2, q), half_width)


def by_central_differences(theta2, q, lengths, half_width):
    derivable(theta2, q, lengths)
    branch = str(FourBar().branch(q[0]))
    columns = []
    for k in range(6):
        step = np.eye(6)[k] * 1e-6
        after, before = (FourBar(*(lengths + side * step)).coupler_point(theta2, branch) for side in (1, -1))
        columns.append((after - before) / 2e-6)
    return combined(np.stack(columns, axis=2), half_width)


def by_complex_steps(theta2, q, lengths, half_width):
    """One Newton step from a closed position is right to first order, and a complex one costs no digits."""
    derivable(theta2, q, lengths)
    gradient = np.empty((len(theta2), 2, 6))
    for i, (t2, (t3, t4)) in enumerate(zip(theta2, q, strict=True)):
        for k in range(6):
            r1, r2, r3, r4, rcx, rcy = lengths + 1e-30j * np.eye(6)[k]
            gap = np.array(
                [
                    r2 * np.cos(t2) + r3 * np.cos(t3) - r1 - r4 * np.cos(t4),
                    r2 * np.sin(t2) + r3 * np.sin(t3) - r4 * np.sin(t4),
                ]
            )
            J = np.array([[-r3 * np.sin(t3), r4 * np.sin(t4)], [r3 * np.cos(t3), -r4 * np.cos(t4)]])
            a = t3 - np.linalg.solve(J, gap)[0]
            gradient[i, 0, k] = (r2 * np.cos(t2) + rcx * np.cos(a) - rcy * np.sin(a)).imag / 1e-30
            gradient[i, 1, k] = (r2 * np.sin(t2) + rcx * np.sin(a) + rcy * np.cos(a)).imag / 1e-30
    return combined(gradient, half_width)


# --- convergence


def logarithms(throws, estimates, truth):
    if len(throws) == 1:
        raise ValueError("1 point is no line")
    rms = np.linalg.norm(np.asarray(estimates) - truth, axis=1) / math.sqrt(len(estimates[0]))
    for n, error in zip(throws, rms, strict=True):
        if error == 0:
            raise ValueError(f"n = {n:.0f}: no error")
    return np.log10(throws), np.log10(rms)


def by_regression(throws, estimates, truth):
    return linregress(*logarithms(throws, estimates, truth)).slope


def by_least_squares(throws, estimates, truth):
    x, y = logarithms(throws, estimates, truth)
    return np.linalg.lstsq(np.column_stack((x, np.ones_like(x))), y, rcond=None)[0][0]


def by_covariance(throws, estimates, truth):
    (var, cov), _ = np.cov(*logarithms(throws, estimates, truth))
    return [cov / var][0]


# --- wrong part


def by_the_triangle(theta2, lengths, points, linear):
    """All distances from B's place in the triangle A-P-B: its angle at A is known."""
    r1, r2, r3, r4, rcx, rcy = lengths.T
    A = np.column_stack((r2 * np.cos(theta2), r2 * np.sin(theta2)))
    arm = np.hypot(*(points - A).T)
    turn = np.arctan2(points[:, 1] - A[:, 1], points[:, 0] - A[:, 0]) - np.arctan2(rcy, rcx)
    B = A + (arm / np.hypot(rcx, rcy) * r3 * np.array([np.cos(turn), np.sin(turn)])).T
    wrong = {
        "arm": ~np.isclose(arm, np.hypot(rcx, rcy), rtol=0, atol=1e-9),
        "loop": ~np.isclose(np.hypot(B[:, 0] - r1, B[:, 1]), r4, rtol=0, atol=1e-9),
        "branch": (r1 - A[:, 0]) * (B[:, 1] - A[:, 1]) + A[:, 1] * (B[:, 0] - A[:, 0]) < 0,
    }
    ratio = np.sqrt(np.diag(np.cov(points.T))) / linear
    return np.any((ratio < 0.8) | (ratio > 1.2)), next((name for name, at in wrong.items() if at.any()), None)


def by_looking_at_each_throw(theta2, lengths, points, linear):
    found = set()
    for (r1, r2, r3, r4, rcx, rcy), (x, y) in zip(lengths.tolist(), points.tolist(), strict=True):
        A = r2 * complex(math.cos(theta2), math.sin(theta2))
        arm = complex(x, y) - A
        B = A + r3 * arm / complex(rcx, rcy)
        if abs(abs(arm) - math.hypot(rcx, rcy)) > 1e-9:
            found.add("arm")
        if abs(abs(B - r1) - r4) > 1e-9:
            found.add("loop")
        if ((B - A) * (r1 - A).conjugate()).imag < 0:
            found.add("branch")
    deviation = [statistics.stdev(column) for column in points.T.tolist()]
    seen = any(abs(ours - theirs) > theirs / 5 for ours, theirs in zip(deviation, linear, strict=True))
    return [int(seen), next((part for part in ("arm", "loop", "branch") if part in found), None)]


def by_the_library(theta2, lengths, points, linear):
    """With the library's point on both branches."""
    bars = FourBar(*lengths.T)
    mine, other = (bars.coupler_point(theta2, branch) for branch in ("open", "crossed"))
    seen = bool((np.abs(points.std(axis=0, ddof=1) / linear - 1) > 0.2).any())
    off, from_other = (np.hypot(*(points - these).T) for these in (mine, other))
    if not (np.minimum(off, from_other) > 1e-9).any():
        return seen, "branch" if (off > 1e-9).any() else None
    A = bars.r2[:, None] * [math.cos(theta2), math.sin(theta2)]
    arm = np.abs(np.hypot(*(points - A).T) - np.hypot(bars.rcx, bars.rcy))
    return seen, "arm" if arm.max() > 1e-9 else "loop"


ROUTES = {
    "coupler_point": (by_mechlib, by_circles, by_newton),
    "propagate": (by_an_old_generator, by_the_standard_library, by_a_latin_hypercube, by_another_bit_generator),
    "linear_propagation": (by_symbols, by_central_differences, by_complex_steps),
    "convergence_rate": (by_regression, by_least_squares, by_covariance),
    "wrong_part": (by_the_triangle, by_looking_at_each_throw, by_the_library),
}


@pytest.mark.parametrize(
    ("name", "route"), [(n, r) for n, routes in ROUTES.items() for r in routes], ids=lambda x: getattr(x, "__name__", x)
)
def test_another_right_way_gets_full_points(name, route):
    for student in DRAWS:
        assessment = judged(name, route, student)
        assert (assessment.verdict, assessment.points) == ("right", task(name).points), (student, assessment.diagnosis)


# --- what is drawn by chance


def thrown(route, student):
    """The first trial of a right way to throw."""
    case = paper(PROPAGATE, "salt", student).cases[0]
    args, evaluations = recorded(case)
    return Trial(case, Value(route(*args)), evaluations)


@pytest.mark.parametrize("draws", [100, pytest.param(1000, marks=pytest.mark.proof)])
def test_right_throws_raise_no_alarm_whatever_generator_made_them(draws):
    """Fewer than three in so many, with 95 % confidence; the bound says one in a million tasks."""
    for n in range(draws):
        for route in ROUTES["propagate"]:
            assert throws_by_the_law(thrown(route, f"alarm {n}"), None) is None


def test_all_comparisons_of_a_task_together_raise_one_alarm_in_a_million():
    throwing = [case for case in paper(PROPAGATE, "salt", "anyone").cases if case.kind == "normal"]
    assert len(throwing) * (2 * len(LENGTHS) + len(PAIRS)) * ALARM == pytest.approx(1e-6)


def test_the_ends_have_the_moments_of_even_throws():
    """64 throws at the ends of 1/sqrt(3) of the tolerances, against evenly spread ones by the thousand."""
    rng = np.random.default_rng(3)
    lengths, half_width = np.array([getattr(FourBar, name) for name in LENGTHS]), half_widths(rng, 1e-4)
    theta2 = np.array([1.0, 4.0])
    by_ends = moments_by_ends(theta2, "open", lengths, half_width)

    def point(thrown):
        return FourBar(*thrown.T[..., None]).coupler_point(theta2)

    even = quasi_monte_carlo(point, tolerances(lengths, half_width), 1024, sets=4)
    assert np.abs(by_ends / even.deviation - 1).max() < 2e-3


# --- the references, and where they are sharp


def test_the_references_are_those_of_the_library():
    for student in DRAWS:
        for t, route in ((COUPLER_POINT, by_mechlib), (LINEAR_PROPAGATION, by_symbols)):
            for trial in paper(t, "salt", student).expected:
                match trial.outcome, answering(route)(t.function, trial.case.args, {}, 1):
                    case Value(value=ours), Value(value=theirs):
                        one, other = (np.concatenate([np.ravel(part) for part in each]) for each in (ours, theirs))
                        assert np.allclose(one, other, rtol=1e-9, atol=1e-12, equal_nan=True)
                    case ours, theirs:
                        assert ours.type == theirs.type == "ValueError"


def test_a_loop_over_the_throws_loses_half_a_point_and_no_more():
    def one_by_one(point, nominal, half_width, throws, seed=0):
        def loop(thrown):
            return np.array([point(row) for row in thrown])

        return by_another_bit_generator(loop, nominal, half_width, throws, seed)

    for student in DRAWS[:3]:
        assessment = judged("propagate", one_by_one, student)
        (fault,) = faults(assessment)
        assert "calls" in fault
        assert assessment.points == 3.5


def test_throws_that_depend_on_one_another_are_not_right_although_each_looks_so():
    def in_pairs(point, nominal, half_width, throws, seed=0):
        enough(throws)
        u = np.random.default_rng(seed).uniform(-1, 1, (throws, 6))
        u[:, 3:] = -u[:, :3]
        points = point(nominal + half_width * u)
        all_closed(points)
        return points.mean(axis=0), points.std(axis=0, ddof=1)

    for student in DRAWS[:3]:
        assessment = judged("propagate", in_pairs, student)
        assert assessment.points == 2.5
        assert "are not thrown apart" in faults(assessment)[0]


def test_published_deviations_are_seen_to_be_wrong():
    """The slip of source D, at its own angles: the loop does not close, and the deviations show it."""
    lengths = np.array([getattr(FourBar, name) for name in LENGTHS])
    rng = np.random.default_rng(1)
    thrown = lengths + 1e-5 * rng.uniform(-1, 1, (500, 6))
    r1, r2, r3, r4, rcx, rcy = thrown.T
    for theta2 in (1.173308006, 4.187756579, 6.223366105):
        l1, l2 = r1 / r2, r1 / r3
        l3 = (r4**2 - r1**2 - r2**2 - r3**2) / (2 * lengths[1] * lengths[2])
        ka = (1 + l2) * np.cos(theta2) - l1 + l3
        kb, kc = -2 * np.sin(theta2), l1 + (l2 - 1) * np.cos(theta2) + l3
        theta3 = 2 * np.arctan2(-kb - np.sqrt(kb**2 - 4 * ka * kc), 2 * ka)
        x = r2 * np.cos(theta2) + rcx * np.cos(theta3) - rcy * np.sin(theta3)
        y = r2 * np.sin(theta2) + rcx * np.sin(theta3) + rcy * np.cos(theta3)
        (linear,) = moments_by_ends(np.array([theta2]), "open", lengths, np.full(6, 1e-5))
        assert wrong_part(theta2, thrown, np.column_stack((x, y)), linear) == (True, "loop")
