"""Exercise 8: other right ways get full points, and ways that only look right do not."""

import math

import numpy as np
import pytest
from judging import judged

from autograder.checks import task
from autograder.checks.e08_wiper_kinematics import RIGHT, iterated
from mechlib.wiper import Wiper

DRAWS = [f"route {n}" for n in range(12)]


def faults(assessment):
    return [finding.fault for finding in assessment.findings if finding.fault]


# --- class


def refuse(*lengths):
    if any(length <= 0 for length in lengths):
        raise ValueError(f"lengths: {', '.join(map(str, lengths))}")
    if any(2 * length >= math.fsum(lengths) for length in lengths):
        raise ValueError(f"{max(lengths):.4g} is too long")


def by_excess(ground, crank, coupler, rocker):
    """Where the shortest and the longest are left out of the whole, the other two remain."""
    lengths = np.array([ground, crank, coupler, rocker])
    refuse(*lengths)
    excess = 2 * (lengths.min() + lengths.max()) - lengths.sum()
    if abs(excess) < 1e-9 * lengths.sum():
        return "change-point"
    words = np.array(["double-crank", "crank-rocker", "double-rocker", "rocker-crank"])
    return str(words[lengths.argmin()]) if excess < 0 else "triple-rocker"


def by_reach(ground, crank, coupler, rocker):
    """A bar at the ground turns round if the other two close the gap at both ends of its turn."""
    refuse(ground, crank, coupler, rocker)
    near, far = 1 - 1e-9, 1 + 1e-9

    def turns(a, b, c, d, slack):
        """Whether the bar a turns round against b, which it is joined to."""
        return (a + b) <= (c + d) * slack and abs(c - d) <= abs(a - b) * slack + (slack - 1) * (a + b + c + d)

    bars = (("crank", crank, ground, coupler, rocker), ("rocker", rocker, ground, coupler, crank))
    surely = tuple(name for name, *four in bars if turns(*four, near))
    maybe = tuple(name for name, *four in bars if turns(*four, far))
    inner = [turns(coupler, crank, rocker, ground, slack) for slack in (near, far)]
    if surely != maybe or inner[0] != inner[1]:
        return "change-point"
    if len(surely) == 1:
        return "crank-rocker" if surely == ("crank",) else "rocker-crank"
    return "double-crank" if surely else "double-rocker" if inner[0] else "triple-rocker"


def by_signs(ground, crank, coupler, rocker):
    """Barker's three sums: the class is in their signs."""
    refuse(ground, crank, coupler, rocker)
    sums = (ground + coupler - crank - rocker, ground + rocker - crank - coupler, coupler + rocker - crank - ground)
    if min(map(abs, sums)) < 1e-9 * (crank + ground + coupler + rocker) / 2:
        return "change-point"
    return {
        (True, True, True): "crank-rocker",
        (True, False, False): "rocker-crank",
        (False, False, True): "double-crank",
        (False, True, False): "double-rocker",
    }.get(tuple(value > 0 for value in sums), "triple-rocker")


# --- positions


def matrix(q, lengths):
    (a, b), (_, _, r2, r3) = q, lengths
    return np.array([[r2 * math.sin(a), -r3 * math.sin(b)], [r2 * math.cos(a), -r3 * math.cos(b)]])


def by_determinants(residual, theta1, lengths, seed, tol=1e-9, warm=False):
    """Lists and plain floats; it looks once more at where it arrived."""
    found, counts, start = [], [], list(seed)
    for k, angle in enumerate(theta1):
        q = list(start)
        for n in range(51):
            x, y = (float(part) for part in residual(np.array(q), float(angle)))
            if math.hypot(x, y) < tol:
                counts.append(n)
                break
            (a, b), (c, d) = matrix(q, lengths)
            q = [q[0] - (d * x - b * y) / (a * d - b * c), q[1] - (a * y - c * x) / (a * d - b * c)]
        else:
            raise OverflowError(f"the linkage stays open at theta1[{k}] = {angle:.3f}")
        residual(q, angle)
        found.append(q)
        start = q if warm else start
    return found, counts


def by_recursion(residual, theta1, lengths, seed, tol=1e-9, warm=False):
    """A least-squares solve in a function that calls itself, and tuples in place of arrays."""

    def step_on(q, angle, k, taken=0):
        gap = np.array(residual(q, angle))
        if gap @ gap < tol**2:
            return q, taken
        if taken == 50:
            raise ArithmeticError(f"no way to close number {k}")
        return step_on(q - np.linalg.lstsq(matrix(q, lengths), gap, rcond=None)[0], angle, k, taken + 1)

    results = []
    for k, angle in enumerate(theta1):
        results.append(step_on(results[-1][0] if warm and results else np.array(seed), angle, k))
    return tuple(zip(*results, strict=True))


def all_at_once(residual, theta1, lengths, seed, tol=1e-9, warm=False):
    """All crank angles in one array where they do not wait for each other."""
    if warm:
        q, counts = np.empty((len(theta1), 2)), np.empty(len(theta1))
        for k in range(len(theta1)):
            try:
                q[k : k + 1], counts[k : k + 1] = all_at_once(
                    residual, theta1[k : k + 1], lengths, q[k - 1] if k else seed, tol
                )
            except ArithmeticError:
                raise ArithmeticError(f"index {k}") from None
        return q, counts
    q, counts = np.tile(np.asarray(seed, dtype=float), (len(theta1), 1)), np.zeros(len(theta1))
    for _ in range(51):
        gap = np.asarray(residual(q, theta1))
        going = ~(np.linalg.norm(gap, axis=1) < tol)
        if not going.any():
            return q, counts
        matrices = np.array([matrix(row, lengths) for row in q[going]])
        q[going] -= np.linalg.solve(matrices, gap[going][..., None])[..., 0]
        counts += going
    raise ArithmeticError(f"index {np.flatnonzero(going)[0]} has not converged")


# --- rates


def closed(q, theta1, lengths):
    (r0, r1, r2, r3), (th2, th3) = lengths, np.transpose(q)
    gap = r1 * np.exp(1j * theta1) + r2 * np.exp(1j * th2) - r0 - r3 * np.exp(1j * th3)
    for wrong, why in ((np.abs(gap) > 1e-6, "open"), (np.abs(np.sin(th3 - th2)) < 1e-6, "dead")):
        if wrong.any():
            raise ValueError(f"point {np.flatnonzero(wrong)[0]} is {why}")
    return th2, th3


def by_formulas(q, crank, lengths):
    """The textbook's quotients of sines, from the closure turned into the direction of one bar."""
    (th1, w1, al1), (_, r1, r2, r3) = crank, lengths
    th2, th3 = closed(q, th1, lengths)
    w2 = w1 * r1 * np.sin(th3 - th1) / (r2 * np.sin(th2 - th3))
    w3 = w1 * r1 * np.sin(th2 - th1) / (r3 * np.sin(th2 - th3))
    along3 = r1 * w1**2 * np.cos(th1 - th3) + r1 * al1 * np.sin(th1 - th3) + r2 * w2**2 * np.cos(th2 - th3) - r3 * w3**2
    along2 = r1 * w1**2 * np.cos(th1 - th2) + r1 * al1 * np.sin(th1 - th2) + r2 * w2**2 - r3 * w3**2 * np.cos(th3 - th2)
    al2 = -along3 / (r2 * np.sin(th2 - th3))
    al3 = along2 / (r3 * np.sin(th3 - th2))
    return np.array([[w2, w3], [al2, al3]]).transpose(0, 2, 1)


def by_loops(q, crank, lengths):
    closed(q, crank[0], lengths)
    _, r1, r2, r3 = lengths
    velocities, accelerations = [], []
    for (th2, th3), th1, w1, al1 in zip(q, *crank, strict=True):
        inverse = np.linalg.inv(matrix((th2, th3), lengths))
        w2, w3 = inverse @ [-r1 * math.sin(th1) * w1, -r1 * math.cos(th1) * w1]
        x = r1 * al1 * math.sin(th1) + sum(
            r * w * w * math.cos(th) for r, w, th in ((r1, w1, th1), (r2, w2, th2), (-r3, w3, th3))
        )
        y = r1 * al1 * math.cos(th1) - sum(
            r * w * w * math.sin(th) for r, w, th in ((r1, w1, th1), (r2, w2, th2), (-r3, w3, th3))
        )
        velocities.append([w2, w3])
        accelerations.append(list(-inverse @ [x, y]))
    return velocities, accelerations


def by_complex_numbers(q, crank, lengths):
    """r1 e^(i th1) + r2 e^(i th2) = r0 + r3 e^(i th3), with real and imaginary parts as the two equations."""
    (th1, w1, al1), (_, r1, r2, r3) = crank, lengths
    th2, th3 = closed(q, th1, lengths)
    a, b, c = r1 * np.exp(1j * th1), r2 * np.exp(1j * th2), r3 * np.exp(1j * th3)

    def solve(right):
        """b x - c y = right, for real x and y."""
        area = (b.conj() * c).imag
        return (right.conj() * c).imag / area, (right.conj() * b).imag / area

    w2, w3 = solve(-a * w1)
    al2, al3 = solve(-a * al1 - 1j * (a * w1**2 + b * w2**2 - c * w3**2))
    return [np.stack((w2, w3), axis=1), np.stack((al2, al3), axis=1)]


# --- points


def positive(lengths):
    wrong = [length for length in lengths if not length > 0]
    if wrong:
        raise ValueError(f"no bar has {wrong[0]} m")


def by_chain(theta1, q, rates, lengths):
    """From joint to joint through the coupler; the speed from its components, the acceleration as a complex number."""
    positive(lengths)
    r0, r1, r2, r3, r4, r5, r6 = lengths
    th2, th3 = q[:, 0], q[:, 1]
    (_, w), (_, al) = (rate.T for rate in rates)
    A = r1 * np.exp(1j * theta1)
    B = A + r2 * np.exp(1j * th2)
    C = np.full_like(A, r0)
    D, G = C + (B - C) * r4 / r3, C + (B - C) * r6 / r3
    found = np.array([A, B, C, D, D + r5, C + r5, G, G + r5])
    vx, vy = -r6 * w * np.sin(th3), r6 * w * np.cos(th3)
    return np.stack((found.real, found.imag), axis=-1), np.sqrt(vx**2 + vy**2), abs(r6 * (1j * al - w**2))


def by_lists(theta1, q, rates, lengths):
    positive(lengths)
    r0, r1, _, r3, r4, r5, r6 = lengths
    at = {"A": [], "B": [], "C": [], "D": [], "E": [], "F": [], "G": [], "H": []}
    for th1, (_, th3) in zip(theta1, q, strict=True):
        c, s = math.cos(th3), math.sin(th3)
        at["A"].append((r1 * math.cos(th1), r1 * math.sin(th1)))
        for name, foot, arm in (("B", 0, r3), ("C", 0, 0), ("D", 0, r4), ("E", r5, r4), ("F", r5, 0), ("G", 0, r6)):
            at[name].append((r0 + foot + arm * c, arm * s))
        at["H"].append((r0 + r5 + r6 * c, r6 * s))
    speed = [abs(r6 * w) for _, w in rates[0]]
    return list(at.values()), speed, [r6 * math.hypot(al, w * w) for (_, w), (_, al) in zip(*rates, strict=True)]


def by_matrices(theta1, q, rates, lengths):
    """A turned frame for each bar; velocity and acceleration by the cross product in space."""
    positive(lengths)
    r0, r1, _, r3, r4, r5, r6 = lengths

    def turned(angle, x):
        frame = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        return np.einsum("ijp,j->pi", frame, [x, 0.0])

    C, F = np.tile([r0, 0.0], (len(q), 1)), np.tile([r0 + r5, 0.0], (len(q), 1))
    th3 = q[:, 1]
    found = [turned(theta1, r1), C + turned(th3, r3), C, C + turned(th3, r4), F + turned(th3, r4), F]
    found += [C + turned(th3, r6), F + turned(th3, r6)]
    arm = np.column_stack((turned(th3, r6), np.zeros(len(q))))
    spin, rise = (np.column_stack((0 * rate, 0 * rate, rate)) for rate in (rates[0, :, 1], rates[1, :, 1]))
    velocity = np.cross(spin, arm)
    acceleration = np.cross(rise, arm) + np.cross(spin, velocity)
    return np.stack(found), np.linalg.norm(velocity, axis=1), np.linalg.norm(acceleration, axis=1)


ROUTES = {
    "grashof_class": (by_excess, by_reach, by_signs),
    "wiper_positions": (by_determinants, by_recursion, all_at_once),
    "wiper_rates": (by_formulas, by_loops, by_complex_numbers),
    "wiper_points": (by_chain, by_lists, by_matrices),
}


@pytest.mark.parametrize(
    ("name", "route"), [(n, r) for n, routes in ROUTES.items() for r in routes], ids=lambda x: getattr(x, "__name__", x)
)
def test_another_right_way_gets_full_points(name, route):
    for student in DRAWS:
        assessment = judged(name, route, student)
        assert (assessment.verdict, assessment.points) == ("right", task(name).points), (student, assessment.diagnosis)


def test_the_references_are_the_wiper_of_the_library():
    wiper, theta1 = Wiper(), np.linspace(0.1, 6.2, 20)
    lengths = (wiper.r0, wiper.r1, wiper.r2, wiper.r3)
    q = wiper.position(theta1)
    found, _ = iterated(wiper.loop.residual, theta1, lengths, np.deg2rad([55, 125]), 1e-13)
    assert np.abs(found - q).max() < 1e-12
    rates = RIGHT(q, np.stack((theta1, 3 + 0 * theta1, 0.5 + 0 * theta1)), lengths)
    assert np.allclose(rates, wiper.loop.rates(q, theta1, 3.0, 0.5), rtol=0, atol=1e-11)


def test_a_position_that_was_polished_loses_the_count_alone():
    def polished(residual, theta1, lengths, seed, tol=1e-9, warm=False):
        return iterated(residual, theta1, lengths, seed, 1e-12, warm)

    for student in DRAWS:
        assessment = judged("wiper_positions", polished, student)
        assert [fault for fault in faults(assessment) if "steps than" not in fault] == []
        assert 1.5 <= assessment.points <= 2.25  # a warm start is often as near after as many steps


def test_an_open_linkage_without_the_index_in_the_message_loses_half_a_point():
    def mute(residual, *rest):
        try:
            return by_determinants(residual, *rest)
        except ArithmeticError:
            raise ArithmeticError("the linkage stays open") from None

    for student in DRAWS:
        assert judged("wiper_positions", mute, student).points == 2.5


def test_velocities_alone_earn_their_part():
    def no_accelerations(q, crank, lengths):
        velocities, _ = by_complex_numbers(q, crank, lengths)
        return velocities, 0 * velocities

    for student in DRAWS:
        assert judged("wiper_rates", no_accelerations, student).points == 1.75


def test_a_dead_point_is_not_left_to_the_solver_to_find():
    def trusting(q, crank, lengths):
        gap = np.abs(Wiper(*lengths).loop.residual(q, crank[0])).max(axis=-1)
        if gap.max() > 1e-6:
            raise ValueError(f"open at {gap.argmax()}")
        return Wiper(*lengths).loop.rates(q, *crank)

    for student in DRAWS:
        assessment = judged("wiper_rates", trusting, student)
        assert assessment.points <= 2.5, assessment.diagnosis
