"""Mistakes of exercise 03 as students write them; see `students`."""

from examination.student import Student

INTEGRATE_PIECES = Student(
    """
def value(coefficients, t):
    return sum(coefficients[j] * t**j for j in range(len(coefficients)))


def joined(ends, pieces):
    rows = []
    before = [0.0]
    for k in range(len(pieces)):
        row = [0.0]
        for j in range(len(pieces[k])):
            row.append(pieces[k][j] / (j + 1))
        joint = ends[k]
        row[0] = value(before, joint) - value(row, joint)
        rows.append(row)
        before = row
    return rows


def integrate_pieces(ends, alpha):
    ends = np.array(ends, dtype=float)
    alpha = np.array(alpha, dtype=float)
    speed = joined(ends, alpha)
    angle = joined(ends, speed)
    omega = np.array(speed)
    theta = np.array(angle)
    return omega, theta
""",
    {
        "The constants of integration are forgotten": (
            ("        row[0] = value(before, joint) - value(row, joint)\n", ""),
        ),
        "The angle has no constants of integration": (
            (
                "    omega = np.array(speed)",
                "    for row in angle:\n        row[0] = 0.0\n    omega = np.array(speed)",
            ),
        ),
        "The speed has no constants of integration": (
            ("    angle = joined(", "    for row in speed:\n        row[0] = 0.0\n    angle = joined("),
        ),
        "The pieces are joined at the wrong end": (("joint = ends[k]", "joint = ends[k + 1]"),),
        "The value at the end of the last piece is added, whatever the new piece has there already": (
            ("value(before, joint) - value(row, joint)", "value(before, joint)"),
        ),
        "The results are polynomials of the time since the start of the piece": (
            (
                "    omega = np.array(speed)",
                "    for rows in (speed, angle):\n"
                "        for k in range(len(rows)):\n"
                "            row, s = rows[k], ends[k]\n"
                "            moved = [0.0] * len(row)\n"
                "            for j in range(len(row)):\n"
                "                for i in range(j + 1):\n"
                "                    moved[i] += row[j] * math.comb(j, i) * s ** (j - i)\n"
                "            rows[k] = moved\n"
                "    omega = np.array(speed)",
            ),
        ),
        "The acceleration is read as a polynomial of the time since the start of the piece": (
            (
                "    speed = joined(",
                "    given = alpha\n"
                "    alpha = np.zeros(given.shape)\n"
                "    for k in range(given.shape[0]):\n"
                "        for j in range(given.shape[1]):\n"
                "            for i in range(j + 1):\n"
                "                alpha[k, i] += given[k, j] * math.comb(j, i) * (-ends[k]) ** (j - i)\n"
                "    speed = joined(",
            ),
        ),
        "Acceleration and results are polynomials of the time since the start of the piece": (
            (
                "    speed = joined(",
                "    given = alpha\n"
                "    alpha = np.zeros(given.shape)\n"
                "    for k in range(given.shape[0]):\n"
                "        for j in range(given.shape[1]):\n"
                "            for i in range(j + 1):\n"
                "                alpha[k, i] += given[k, j] * math.comb(j, i) * (-ends[k]) ** (j - i)\n"
                "    speed = joined(",
            ),
            (
                "    omega = np.array(speed)",
                "    for rows in (speed, angle):\n"
                "        for k in range(len(rows)):\n"
                "            row, s = rows[k], ends[k]\n"
                "            moved = [0.0] * len(row)\n"
                "            for j in range(len(row)):\n"
                "                for i in range(j + 1):\n"
                "                    moved[i] += row[j] * math.comb(j, i) * s ** (j - i)\n"
                "            rows[k] = moved\n"
                "    omega = np.array(speed)",
            ),
        ),
        "The results are in descending order": (
            ("np.array(speed)", "np.array(speed)[:, ::-1]"),
            ("np.array(angle)", "np.array(angle)[:, ::-1]"),
        ),
        "The coefficients are read and returned in descending order": (
            ("np.array(alpha, dtype=float)", "np.array(alpha, dtype=float)[:, ::-1]"),
            ("np.array(speed)", "np.array(speed)[:, ::-1]"),
            ("np.array(angle)", "np.array(angle)[:, ::-1]"),
        ),
        "It is integrated once": (("joined(ends, speed)", "joined(ends, alpha)"),),
        "Theta comes first, and omega second": (("return omega, theta", "return theta, omega"),),
        "The coefficients are not divided by the new power": (("pieces[k][j] / (j + 1)", "pieces[k][j]"),),
    },
)

FIRST_TURN = Student(
    """
def first_turn(peak, turns):
    if not peak > 0:
        raise ValueError(f"peak = {peak} is not positive")
    if not turns > 0:
        raise ValueError(f"turns = {turns} is not positive")
    angle = 2 * math.pi * turns
    # The angle at T is this share of T^2.
    share = peak / 3
    return math.sqrt(angle / share)
""",
    {
        "The turns are taken for radians": (("2 * math.pi * turns", "turns"),),
        "The turns are made degrees": (("2 * math.pi * turns", "360 * turns"),),
        "The acceleration is at its peak all the time": (("share = peak / 3", "share = peak / 2"),),
        "The shaft has its final speed all the time": (("share = peak / 3", "share = 2 * peak / 3"),),
        "The speed at T is set to the angle": (("math.sqrt(angle / share)", "angle / (2 * peak / 3)"),),
        "The square root is missing": (("math.sqrt(angle / share)", "angle / share"),),
        "The negative root": (("return math.sqrt(", "return -math.sqrt("),),
        "The peak is 5 rad/s^2 whichever is asked for": (("    angle = ", "    peak = 5.0\n    angle = "),),
        "The number of turns is not used": (("2 * math.pi * turns", "2 * math.pi"),),
    },
)

MOTOR_PROFILE = Student(
    """
def motor_profile(t, T, peak):
    t = np.array(t, dtype=float)
    if not T > 0:
        raise ValueError(f"T = {T} is not positive")
    for instant in t:
        if not np.isfinite(instant) or instant < 0:
            raise ValueError(f"there is no profile at t = {instant}")
    slope = 3 * peak / T
    starts = [0.0, T / 3, 2 * T / 3, T]
    stops = [T / 3, 2 * T / 3, T, math.inf]
    # The acceleration is a + b t in each piece.
    pieces = [(0.0, slope), (peak, 0.0), (3 * peak, -slope), (0.0, 0.0)]
    profile = np.zeros((len(t), 3))
    a = b = c = d = 0.0
    for k in range(4):
        start, stop = starts[k], stops[k]
        # Speed and angle where the piece before ends
        speed = c + a * start + b * start**2 / 2
        angle = d + c * start + a * start**2 / 2 + b * start**3 / 6
        a, b = pieces[k]
        c = speed - (a * start + b * start**2 / 2)
        d = angle - (c * start + a * start**2 / 2 + b * start**3 / 6)
        inside = (t >= start) & (t < stop)
        now = t[inside]
        profile[inside, 0] = a + b * now
        profile[inside, 1] = c + a * now + b * now**2 / 2
        profile[inside, 2] = d + c * now + a * now**2 / 2 + b * now**3 / 6
    return profile
""",
    {
        "After T speed and angle are zero": (("range(4)", "range(3)"),),
        "After T speed and angle are not a number": (
            ("    return profile", "    profile[t >= T, 1:] = np.nan\n    return profile"),
        ),
        "After T the angle stands still": (
            ("    return profile", "    profile[t >= T, 2] = angle\n    return profile"),
        ),
        "After T the angle begins again at zero": (
            ("    return profile", "    profile[t >= T, 2] -= angle\n    return profile"),
        ),
        "The third piece goes on after T": (
            ("stops = [T / 3, 2 * T / 3, T, math.inf]", "stops = [T / 3, 2 * T / 3, math.inf]"),
            ("range(4)", "range(3)"),
        ),
        "The last piece is used before T, and nothing after it": (
            ("        now = t[inside]", "        if k == 3:\n            inside = t < T\n        now = t[inside]"),
        ),
        "The acceleration of the third piece has the wrong sign": (
            ("profile[inside, 0] = a + b * now", "profile[inside, 0] = -a - b * now if k == 2 else a + b * now"),
        ),
        "The fall begins at the peak at t = 0, and not at 2T/3": (("(3 * peak, -slope)", "(peak, -slope)"),),
        "A sign in the speed of the third piece": (
            (
                "profile[inside, 1] = c + a * now + b * now**2 / 2",
                "profile[inside, 1] = c + a * now + (-b if k == 2 else b) * now**2 / 2",
            ),
        ),
        "The constants of integration are forgotten": (
            ("c = speed - (a * start + b * start**2 / 2)", "c = 0.0"),
            ("d = angle - (c * start + a * start**2 / 2 + b * start**3 / 6)", "d = 0.0"),
        ),
        "The angle has no constants of integration": (
            ("d = angle - (c * start + a * start**2 / 2 + b * start**3 / 6)", "d = 0.0"),
        ),
        "The acceleration rises as if it had all of T, and not a third": (("(0.0, slope)", "(0.0, peak / T)"),),
        "Degrees where radians are asked for": (
            ("    return profile", "    profile = np.degrees(profile)\n    return profile"),
        ),
        "The peak is 5 rad/s^2 whichever is asked for": (("    slope = ", "    peak = 5.0\n    slope = "),),
        "The columns are in the order theta, omega, alpha": (("return profile", "return profile[:, ::-1]"),),
        "Rows and columns are exchanged": (("return profile", "return profile.T"),),
        "The acceleration is summed up over the instants that are asked for": (
            (
                "    return profile",
                "    steps = np.diff(t, prepend=0.0)\n"
                "    profile[:, 1] = np.cumsum(profile[:, 0] * steps)\n"
                "    profile[:, 2] = np.cumsum(profile[:, 1] * steps)\n"
                "    return profile",
            ),
        ),
        "An instant at which two pieces meet belongs to neither": (("t >= start", "t > start"),),
    },
)

MISPRINT = Student(
    """
def misprint(alpha, omega, theta, T):
    starts = np.array([0.0, T / 3, 2 * T / 3, T])
    stops = np.array([T / 3, 2 * T / 3, T, 2 * T])
    everywhere = np.linspace(0, 2 * T, 1001)
    h = 1e-3 * T
    tiny = 1e-9 * T
    tolerance = 1e-3

    def wrong_piece(f, slope):
        steepest = max(abs(np.array(slope(everywhere))))
        largest = max(abs(np.array(f(everywhere))))
        for k in range(4):
            inside = np.linspace(starts[k] + 2 * h, stops[k] - 2 * h, 101)
            difference = (np.array(f(inside + h)) - np.array(f(inside - h))) / (2 * h)
            if max(abs(difference - np.array(slope(inside)))) > tolerance * steepest:
                return k
        before = np.append(0.0, f(starts[1:] - tiny))
        after = np.array(f(starts + tiny))
        jumps = [k for k in range(0, 4) if abs(after[k] - before[k]) > tolerance * largest]
        if jumps:
            return jumps[0]
        return None

    for name, f, slope in [("omega", omega, alpha), ("theta", theta, omega)]:
        piece = wrong_piece(f, slope)
        if piece is not None:
            return name, piece
    return None
""",
    {
        "Only the derivatives are compared": (("        if jumps:\n            return jumps[0]\n", ""),),
        "Only the jumps are looked at": (
            (
                "            if max(abs(difference - np.array(slope(inside)))) > tolerance * steepest:\n"
                "                return k\n",
                "",
            ),
        ),
        "An error of omega is put down to theta": (('("omega", omega, alpha)', '("theta", omega, alpha)'),),
        "An error of theta is put down to omega": (('("theta", theta, omega)', '("omega", theta, omega)'),),
        "The pieces are counted from one": (("return name, piece", "return name, piece + 1"),),
        "A wrong constant is put down to the piece before its jump": (
            ("return jumps[0]", "return max(jumps[0] - 1, 0)"),
        ),
        "A wrong constant is put down to the piece after its last jump": (("return jumps[0]", "return jumps[-1]"),),
        "A wrong constant of the first piece is put down to the second": (("range(0, 4)", "range(1, 4)"),),
        "Round-off is taken for an error": (("tolerance = 1e-3", "tolerance = 0.0"),),
    },
)

STUDENTS = {
    "integrate_pieces": INTEGRATE_PIECES,
    "first_turn": FIRST_TURN,
    "motor_profile": MOTOR_PROFILE,
    "misprint": MISPRINT,
}
