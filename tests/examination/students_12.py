"""Mistakes of exercise 12 as students write them; see `students`."""

from examination.student import Student

COUPLER_POINT = Student(
    """
def coupler_point(theta2, lengths, branch="open", frame=(0.0, 0.0, 0.0)):
    for row in lengths:
        for length in row[:4]:
            if length <= 0:
                raise ValueError(f"a bar cannot be {length} m long")
    r1, r2, r3, r4, rcx, rcy = (lengths[:, k] for k in range(6))
    x0, y0, theta0 = frame
    t2 = theta2
    sign = {"open": -1, "crossed": 1}
    d2, d3 = r2, r3
    l1, l2 = r1 / r2, r1 / r3
    l3 = (r4**2 - r1**2 - r2**2 - r3**2) / (2 * d2 * d3)
    ka = np.cos(t2) - l1 + l2 * np.cos(t2) + l3
    kb = -2 * np.sin(t2)
    kc = l1 + (l2 - 1) * np.cos(t2) + l3
    inside = kb**2 - 4 * ka * kc
    t3 = 2 * np.arctan2(-kb + sign[branch] * np.sqrt(inside), 2 * ka)
    along, across = rcx, rcy
    ax, ay = r2 * np.cos(t2), r2 * np.sin(t2)
    px = along * np.cos(t3) - across * np.sin(t3)
    py = along * np.sin(t3) + across * np.cos(t3)
    c0, s0 = np.cos(theta0), np.sin(theta0)
    x = x0 + c0 * ax - s0 * ay + c0 * px - s0 * py
    y = y0 + s0 * ax + c0 * ay + s0 * px + c0 * py
    return np.column_stack((x, y))
""",
    {
        "The branches are exchanged": (('{"open": -1, "crossed": 1}', '{"open": 1, "crossed": -1}'),),
        "It is the open branch, whichever is asked for": (("sign[branch]", 'sign["open"]'),),
        "It is the crossed branch, whichever is asked for": (("sign[branch]", 'sign["crossed"]'),),
        "rcy cos(theta3) has a minus in Py": (("np.sin(t3) + across", "np.sin(t3) - across"),),
        "rcy sin(theta3) has a plus in Px": (("np.cos(t3) - across", "np.cos(t3) + across"),),
        "P is on the other side of the coupler": (("along, across = rcx, rcy", "along, across = rcx, -rcy"),),
        "rcx and rcy are exchanged": (("along, across = rcx, rcy", "along, across = rcy, rcx"),),
        "Nominal bars stand in the denominator of l3": (("d2, d3 = r2, r3", "d2, d3 = 0.42259, 0.964444"),),
        "P turns with the rocker": (
            (
                "    along, across",
                "    t3 = np.arctan2(r2 * np.sin(t2) + r3 * np.sin(t3), r2 * np.cos(t2) + r3 * np.cos(t3) - r1)\n"
                "    along, across",
            ),
        ),
        "The arm begins in B": (
            (
                "ax, ay = r2 * np.cos(t2), r2 * np.sin(t2)",
                "ax = r2 * np.cos(t2) + r3 * np.cos(t3)\n    ay = r2 * np.sin(t2) + r3 * np.sin(t3)",
            ),
        ),
        "r3 and r4 are exchanged": (("r1, r2, r3, r4, rcx", "r1, r2, r4, r3, rcx"),),
        "The crank angle is taken for degrees": (("t2 = theta2", "t2 = theta2 * np.pi / 180"),),
        "theta0 is subtracted from theta3": (
            ("+ c0 * px - s0 * py", "+ c0 * px + s0 * py"),
            ("+ s0 * px + c0 * py", "- s0 * px + c0 * py"),
        ),
        "The arm is not turned with the frame": (
            ("+ c0 * px - s0 * py", "+ px"),
            ("+ s0 * px + c0 * py", "+ py"),
        ),
        "The crank is not turned with the frame": (
            ("+ c0 * ax - s0 * ay", "+ ax"),
            ("+ s0 * ax + c0 * ay", "+ ay"),
        ),
        "The frame is not turned": (("np.cos(theta0), np.sin(theta0)", "1.0, 0.0"),),
        "The frame is not moved": (("x = x0 +", "x ="), ("y = y0 +", "y =")),
        "The frame is not looked at": (("x0, y0, theta0 = frame", "x0, y0, theta0 = 0, 0, 0"),),
        "O2 is turned about the origin": (
            ("x = x0 +", "x = c0 * x0 - s0 * y0 +"),
            ("y = y0 +", "y = s0 * x0 + c0 * y0 +"),
        ),
        "A loop that cannot close gets a point": (("np.sqrt(inside)", "np.sqrt(np.maximum(inside, 0))"),),
        "A bar that is not positive gets a point": (("if length <= 0:", "if False:"),),
    },
)

PROPAGATE = Student(
    """
def propagate(point, nominal, half_width, throws, seed=0):
    if throws < 2:
        raise ValueError(f"{throws} throws are not enough")
    rng = np.random.default_rng(seed)
    w = half_width
    u = rng.uniform(-1, 1, size=(throws, 6))
    lengths = nominal + u * w
    p = point(lengths)
    bad = np.isnan(p[:, 0])
    if bad.sum() > 0:
        raise ValueError(f"{bad.sum()} of the throws cannot be built")
    n = len(p)
    mean = np.sum(p, axis=0) / n
    variance = np.sum((p - mean) ** 2, axis=0) / (n - 1)
    deviation = np.sqrt(variance)
    centre = mean
    return centre, deviation
""",
    {
        "The deviation is that of a population: it divides by n": (("/ (n - 1)", "/ n"),),
        "The standard error stands where the deviation belongs": (
            ("deviation = np.sqrt(variance)", "deviation = np.sqrt(variance / n)"),
        ),
        "The variance stands where the deviation belongs": (("deviation = np.sqrt(variance)", "deviation = variance"),),
        "Half the range stands where the deviation belongs": (
            ("deviation = np.sqrt(variance)", "deviation = (p.max(axis=0) - p.min(axis=0)) / 2"),
        ),
        "The mean distance stands where the deviation belongs": (
            ("deviation = np.sqrt(variance)", "deviation = np.mean(abs(p - mean), axis=0)"),
        ),
        "x and y are thrown together in one mean and one deviation": (
            ("return centre, deviation", "return np.mean(p), np.std(p, ddof=1)"),
        ),
        "The point of the nominal lengths stands where the mean belongs": (
            ("centre = mean", "centre = point(nominal)"),
        ),
        "The median stands where the mean belongs": (("centre = mean", "centre = np.median(p, axis=0)"),),
        "Mean and deviation are exchanged": (("return centre, deviation", "return deviation, centre"),),
        "The lengths are thrown normally, with the half width as deviation": (
            ("rng.uniform(-1, 1, size=(throws, 6))", "rng.normal(size=(throws, 6))"),
        ),
        "The lengths are thrown normally, with the deviation of even ones": (
            ("rng.uniform(-1, 1, size=(throws, 6))", "rng.normal(0, 1 / np.sqrt(3), size=(throws, 6))"),
        ),
        "The lengths are thrown evenly, with the half width as deviation": (
            ("rng.uniform(-1, 1, size=(throws, 6))", "rng.uniform(-np.sqrt(3), np.sqrt(3), size=(throws, 6))"),
        ),
        "The half width is taken for the full width": (("w = half_width", "w = half_width / 2"),),
        "The lengths only become longer": (("rng.uniform(-1, 1, size=(throws, 6))", "rng.random((throws, 6))"),),
        "Every length is at one end of its tolerance": (
            ("rng.uniform(-1, 1, size=(throws, 6))", "rng.choice([-1, 1], size=(throws, 6))"),
        ),
        "Some lengths are not thrown": (
            ("lengths = nominal + u * w", "lengths = nominal + u * w\n    lengths[:, 4:] = nominal[4:]"),
        ),
        "All lengths share one draw": (("size=(throws, 6)", "size=(throws, 1)"),),
        "One throw serves for all": (
            ("rng.uniform(-1, 1, size=(throws, 6))", "np.tile(rng.uniform(-1, 1, 6), (throws, 1))"),
        ),
        "Nothing is thrown": (("lengths = nominal + u * w", "lengths = np.tile(nominal, (throws, 1))"),),
        "One tolerance serves for all lengths": (("w = half_width", "w = half_width[0]"),),
        "The tolerances are taken for relative ones": (("w = half_width", "w = half_width * nominal"),),
        "Throws without a result are left out": (("if bad.sum() > 0:", "p = p[~bad]\n    if False:"),),
        "Throws without a result go into mean and deviation": (("if bad.sum() > 0:", "if False:"),),
        "A single throw gets a deviation": (
            ("if throws < 2:", "if throws < 1:"),
            ("/ (n - 1)", "/ np.float64(n - 1)"),
        ),
    },
)

LINEAR_PROPAGATION = Student(
    """
def closed_form(theta2, lengths, left):
    r1, r2, r3, r4, rcx, rcy = lengths
    dx, dy = r1 - r2 * np.cos(theta2), -r2 * np.sin(theta2)
    d = np.hypot(dx, dy)
    a = (d**2 + r3**2 - r4**2) / (2 * d)
    h = np.sqrt(r3**2 - a**2) * (1 if left else -1)
    c, s = (a * dx - h * dy) / d / r3, (a * dy + h * dx) / d / r3
    return np.array([r2 * np.cos(theta2) + rcx * c - rcy * s, r2 * np.sin(theta2) + rcx * s + rcy * c])


def linear_propagation(theta2, q, lengths, half_width):
    r1, r2, r3, r4, rcx, rcy = lengths
    w = half_width
    factor = 1 / np.sqrt(3)
    gradients, deviations = [], []
    for i in range(len(theta2)):
        t2, t3, t4 = theta2[i], q[i, 0], q[i, 1]
        c2, s2 = math.cos(t2), math.sin(t2)
        c3, s3 = math.cos(t3), math.sin(t3)
        c4, s4 = math.cos(t4), math.sin(t4)
        gap = math.hypot(r2 * c2 + r3 * c3 - r1 - r4 * c4, r2 * s2 + r3 * s3 - r4 * s4)
        if gap > 1e-6:
            raise ValueError(f"point {i}: open")
        det = s4 * c3 - c4 * s3
        if abs(det) < 1e-6:
            raise ValueError(f"point {i}: coupler and rocker in line")
        # from the closure, with the rocker's angle eliminated
        t3_by = np.array([c4, -(c2 * c4 + s2 * s4), -(c3 * c4 + s3 * s4), 1, 0, 0]) / (r3 * det)
        x_by_t3, y_by_t3 = -rcx * s3 - rcy * c3, rcx * c3 - rcy * s3
        G = np.array([
            [x_by_t3 * t3_by[0], y_by_t3 * t3_by[0]],
            [x_by_t3 * t3_by[1] + c2, y_by_t3 * t3_by[1] + s2],
            [x_by_t3 * t3_by[2], y_by_t3 * t3_by[2]],
            [x_by_t3 * t3_by[3], y_by_t3 * t3_by[3]],
            [c3, s3],
            [-s3, c3],
        ]).T
        parts = G * w * factor
        deviation = np.sqrt((parts**2).sum(axis=1))
        gradients.append(G)
        deviations.append(deviation)
    gradients, deviations = np.array(gradients), np.array(deviations)
    return gradients, deviations
""",
    {
        "theta3 is held": (("/ (r3 * det)", "* 0"),),
        "theta3 follows with the wrong sign": (("/ (r3 * det)", "/ -(r3 * det)"),),
        "The ground is taken as exact": (("        parts =", "        G[:, 0] = 0\n        parts ="),),
        "rcx and rcy are taken as exact": (
            ("            [c3, s3],\n            [-s3, c3],\n", "            [0, 0],\n            [0, 0],\n"),
        ),
        "The derivatives are differences to one side with too coarse a step": (
            (
                "        parts =",
                "        left = math.sin(t4 - t3) > 0\n"
                "        P = closed_form(t2, lengths, left)\n"
                "        for k in range(6):\n"
                "            longer = np.array(lengths)\n"
                "            longer[k] += 0.001\n"
                "            G[:, k] = (closed_form(t2, longer, left) - P) / 0.001\n"
                "        parts =",
            ),
        ),
        "The half width is taken for the deviation": (("factor = 1 / np.sqrt(3)", "factor = 1"),),
        "The full width is taken for the half width": (("factor = 1 / np.sqrt(3)", "factor = 1 / np.sqrt(12)"),),
        "The half width is divided by 3, and not by its root": (("factor = 1 / np.sqrt(3)", "factor = 1 / 3"),),
        "The sizes are added": (("np.sqrt((parts**2).sum(axis=1))", "abs(parts).sum(axis=1)"),),
        "The worst case is given: the sizes are added, with the half widths": (
            ("np.sqrt((parts**2).sum(axis=1))", "abs(G * w).sum(axis=1)"),
        ),
        "The parts are added with their signs": (("np.sqrt((parts**2).sum(axis=1))", "abs(parts.sum(axis=1))"),),
        "The root is missing: it is the variance": (("np.sqrt((parts**2).sum(axis=1))", "(parts**2).sum(axis=1)"),),
        "The mean of the squares is taken, and not their sum": (("(parts**2).sum(axis=1)", "(parts**2).mean(axis=1)"),),
        "One tolerance serves for all lengths": (("w = half_width", "w = half_width[0]"),),
        "The derivatives are multiplied by the half widths": (
            ("gradients.append(G)", "gradients.append(G * half_width)"),
        ),
        "The gradient has the shape (points, 6, 2)": (("gradients.append(G)", "gradients.append(G.T)"),),
        "Gradient and deviation are exchanged": (("return gradients, deviations", "return deviations, gradients"),),
        "The angles are taken for degrees": (
            ("t2, t3, t4 = theta2[i], q[i, 0], q[i, 1]", "t2, t3, t4 = np.radians([theta2[i], q[i, 0], q[i, 1]])"),
            ("if gap > 1e-6:", "if False:"),
        ),
        "A dead point gets derivatives": (("if abs(det) < 1e-6:", "if False:"),),
        "Positions that leave the loop open get derivatives": (("if gap > 1e-6:", "if gap > 1e6:"),),
    },
)

CONVERGENCE_RATE = Student(
    """
def convergence_rate(throws, estimates, truth):
    k = len(throws)
    if k < 2:
        raise ValueError(f"{k} is too few")
    x, y = [], []
    for n, row in zip(throws, estimates):
        off = row - truth
        error = np.sqrt(np.mean(off**2))
        if error == 0:
            raise ValueError(f"the error with {n} throws is zero")
        x.append(np.log(n))
        y.append(np.log(error))
    x, y = np.array(x), np.array(y)
    top = k * np.sum(x * y) - np.sum(x) * np.sum(y)
    rate = top / (k * np.sum(x * x) - np.sum(x) ** 2)
    return rate
""",
    {
        "The rate has the wrong sign": (("return rate", "return -rate"),),
        "The throws are fitted against the error": (("    top =", "    x, y = y, x\n    top ="),),
        "The logarithm of the estimates is fitted, and not that of their errors": (
            ("error = np.sqrt(np.mean(off**2))", "error = np.mean(abs(row))"),
        ),
        "The spread about their own mean is taken for the error": (("off = row - truth", "off = row - row.mean()"),),
        "The squares are not rooted": (("error = np.sqrt(np.mean(off**2))", "error = np.mean(off**2)"),),
        "The sizes are averaged, and not their squares": (
            ("error = np.sqrt(np.mean(off**2))", "error = np.mean(np.abs(off))"),
        ),
        "The errors are averaged with their signs": (
            ("error = np.sqrt(np.mean(off**2))", "error = abs(np.mean(off))"),
        ),
        "Only the last estimate is looked at": (("off = row - truth", "off = row[-1] - truth"),),
        "Only the first and the last number of throws are looked at": (
            ("return rate", "return (y[-1] - y[0]) / (x[-1] - x[0])"),
        ),
        "The line is led through the origin": (
            ("rate = top / (k * np.sum(x * x) - np.sum(x) ** 2)", "rate = sum(x * y) / sum(x * x)"),
        ),
        "No logarithm is taken": (("np.log(n)", "n"), ("np.log(error)", "error")),
        "The throws have no logarithm": (("np.log(n)", "float(n)"),),
        "The errors have no logarithm": (("np.log(error)", "float(error)"),),
        "The two logarithms are not to the same base": (("np.log(n)", "np.log10(n)"),),
        "An error of zero gets a rate": (("if error == 0:", "if False:"),),
        "A single number of throws gets a rate": (("if k < 2:", "if False:"),),
    },
)

WRONG_PART = Student(
    """
def wrong_part(theta2, lengths, points, linear):
    sigma = np.std(points, axis=0, ddof=1)
    off_x = abs(sigma[0] - linear[0]) > 0.2 * linear[0]
    off_y = abs(sigma[1] - linear[1]) > 0.2 * linear[1]
    seen = bool(off_x or off_y)
    limit = 1e-9
    r1, r2, r3, r4, rcx, rcy = lengths.T
    x, y = points.T
    ax, ay = r2 * math.cos(theta2), r2 * math.sin(theta2)
    long = np.hypot(x - ax, y - ay)
    theta3 = np.arctan2(y - ay, x - ax) - np.arctan2(rcy, rcx)
    scale = long / np.hypot(rcx, rcy)
    bx, by = ax + scale * r3 * np.cos(theta3), ay + scale * r3 * np.sin(theta3)
    arm = abs(long - np.hypot(rcx, rcy)) > limit
    loop = abs(np.hypot(bx - r1, by) - r4) > limit
    branch = (r1 - ax) * (by - ay) + ay * (bx - ax) < 0
    part = None
    if any(arm):
        part = "arm"
    elif any(loop):
        part = "loop"
    elif any(branch):
        part = "branch"
    return seen, part
""",
    {
        "The bars are looked at only where the deviations are off": (
            ("    return seen", "    if not seen:\n        part = None\n    return seen"),
        ),
        "The arm is not looked at": (("any(arm)", "False"),),
        "The loop is not looked at": (("any(loop)", "False"),),
        "The branch is not looked at": (("any(branch)", "False"),),
        "Only the first throw is looked at": (
            ("= lengths.T", "= lengths[:1].T"),
            ("= points.T", "= points[:1].T"),
        ),
        "Every difference from the linear deviations counts": (
            ("0.2 * linear[0]", "1e-9 * linear[0]"),
            ("0.2 * linear[1]", "1e-9 * linear[1]"),
        ),
        "Only the deviation of x is looked at": (("off_x or off_y", "off_x"),),
        "It is said whether the deviations agree, and not whether they see the mistake": (
            ("seen, part", "not seen, part"),
        ),
        "The part comes first": (("return seen, part", "return part, seen"),),
        "Round-off is taken for a mistake": (("limit = 1e-9", "limit = 0.0"),),
    },
)

STUDENTS = {
    "coupler_point": COUPLER_POINT,
    "propagate": PROPAGATE,
    "linear_propagation": LINEAR_PROPAGATION,
    "convergence_rate": CONVERGENCE_RATE,
    "wrong_part": WRONG_PART,
}
