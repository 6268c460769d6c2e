"""Mistakes of exercise 08 as students write them; see `students`."""

from examination.student import Student

GRASHOF_CLASS = Student(
    """
def grashof_class(ground, crank, coupler, rocker):
    lengths = [ground, crank, coupler, rocker]
    for length in lengths:
        if not length > 0:
            raise ValueError(f"the length {length} is not positive")
    S = min(lengths)
    L = max(lengths)
    if 2 * L >= sum(lengths):
        raise ValueError(f"the longest, {L}, is as long as all the others")
    PQ = sum(lengths) - S - L
    SL = S + L
    deciding = S
    if deciding == ground:
        turning = "double-crank"
    elif deciding == crank:
        turning = "crank-rocker"
    elif deciding == rocker:
        turning = "rocker-crank"
    else:
        turning = "double-rocker"
    if abs(SL - PQ) < 1e-9 * PQ:
        return "change-point"
    if SL < PQ:
        return turning
    return "triple-rocker"
""",
    {
        "The place of the shortest bar is ignored": (("        return turning\n", '        return "crank-rocker"\n'),),
        "The place of the longest bar decides": (("deciding = S", "deciding = L"),),
        "The shortest and the longest bar are not compared together with the other two": (
            ("    PQ = sum(lengths) - S - L\n", "    middle = sorted(lengths)[1:3]\n    PQ = L + middle[1]\n"),
            ("SL = S + L", "SL = S + middle[0]"),
        ),
        "The bars are not sorted: the crank is taken for the shortest and the ground for the longest": (
            ("PQ = sum(lengths) - S - L", "PQ = coupler + rocker"),
            ("SL = S + L", "SL = crank + ground"),
        ),
        "The inequality is turned round": (("if SL < PQ:", "if SL > PQ:"),),
        "Double-crank and double-rocker are exchanged": (
            ("if deciding == ground:", "if deciding == 1 * coupler:"),
            ("    else:\n        turning =", "    elif deciding == ground:\n        turning ="),
        ),
        "Crank-rocker and rocker-crank are exchanged": (
            ("elif deciding == crank:", "elif deciding == 1 * rocker:"),
            ("elif deciding == rocker:", "elif deciding == crank:"),
        ),
        "A rocker-crank is called a crank-rocker": (('turning = "rocker-crank"', 'turning = "crank-" + "rocker"'),),
        "A triple-rocker is called a double-rocker": (('return "triple-rocker"', 'return "double-rocker"'),),
        "The two sums must be equal to the last digit": (
            ("PQ = sum(lengths) - S - L", "PQ = sum(sorted(lengths)[1:3])"),
            ("abs(SL - PQ) < 1e-9 * PQ", "SL == PQ"),
        ),
        "Sums that are not the same are taken for a change point": (
            ("abs(SL - PQ) < 1e-9 * PQ", "np.isclose(SL, PQ)"),
        ),
        "A change point is given another class": (
            ('    if abs(SL - PQ) < 1e-9 * PQ:\n        return "change-point"\n', ""),
            ("PQ = sum(lengths) - S - L", "PQ = sum(sorted(lengths)[1:3])"),
        ),
        "Bars that cannot be joined get a class": (("2 * L >= sum(lengths)", "False"),),
        "Bars that can only lie flat get a class": (("2 * L >= sum(lengths)", "2 * L > sum(lengths)"),),
        "A length that is not positive gets a class": (("if not length > 0:", "if False:"),),
    },
)

WIPER_POSITIONS = Student(
    """
def wiper_positions(residual, theta1, lengths, seed, tol=1e-9, warm=False):
    seed = np.array(seed, dtype=float)
    guess = seed
    angles, counts = [], []
    for i in range(len(theta1)):
        crank = theta1[i]
        q = guess.copy()
        count = 0
        while True:
            F = residual(q, crank)
            if np.linalg.norm(F) < tol:
                break
            if count == 50:
                raise ArithmeticError(f"index {i}: not closed")
            at = q
            coupler, rocker = lengths[2], lengths[3]
            s2, c2 = np.sin(at[0]), np.cos(at[0])
            s3, c3 = np.sin(at[1]), np.cos(at[1])
            J = np.array([[coupler * s2, -rocker * s3], [coupler * c2, -rocker * c3]])
            d = np.linalg.solve(J, -F)
            q = q + d
            count = count + 1
        angles.append(q)
        counts.append(count)
        if warm:
            guess = q
    angles = np.array(angles)
    return angles, np.array(counts)
""",
    {
        "The step has the wrong sign": (("solve(J, -F)", "solve(J, F)"),),
        "The Jacobian is transposed": (("solve(J, -F)", "solve(J.T, -F)"),),
        "The Jacobian of the seed is used in every step": (("at = q", "at = guess"),),
        "A sign of the Jacobian is wrong": (("-rocker * s3", "rocker * s3"),),
        "Sine and cosine are exchanged in the Jacobian": (
            ("s2, c2 = np.sin(at[0]), np.cos(at[0])", "s2, c2 = np.cos(at[0]), np.sin(at[0])"),
            ("s3, c3 = np.sin(at[1]), np.cos(at[1])", "s3, c3 = np.cos(at[1]), np.sin(at[1])"),
        ),
        "The lengths of coupler and rocker are exchanged in the Jacobian": (
            ("lengths[2], lengths[3]", "lengths[3], lengths[2]"),
        ),
        "The angles of the Jacobian are taken for degrees": (("at = q", "at = np.radians(q)"),),
        "The crank angle is taken for degrees": (("crank = theta1[i]", "crank = np.radians(theta1[i])"),),
        "The seed is taken for degrees": (("    guess = seed\n", "    seed = np.radians(seed)\n    guess = seed\n"),),
        "The seed of source B is used, whatever seed is given": (
            ("np.array(seed, dtype=float)", "np.radians([55.0, 125.0])"),
        ),
        "theta3 and theta2 are exchanged in the seed, which leads to the other branch": (
            ("np.array(seed, dtype=float)", "np.array([seed[1], seed[0]], dtype=float)"),
        ),
        "A single step is taken": (("            if np.linalg.norm(F) < tol:\n", "            if count == 1:\n"),),
        "It stops when the step is small, and not when the residual is": (
            ("            if np.linalg.norm(F) < tol:\n                break\n", ""),
            (
                "            count = count + 1\n",
                "            count += 1\n            if np.sqrt(d @ d) < tol:\n                break\n",
            ),
        ),
        "The tolerance of source B is used, whatever tol is given": (("norm(F) < tol", "norm(F) < 1e-9"),),
        "There is one iteration too many in the count": (("counts.append(count)", "counts.append(count + 1)"),),
        "There is one iteration too few in the count": (("counts.append(count)", "counts.append(count - 1)"),),
        "The count goes on from one angle to the next": (
            (
                "        count = 0\n",
                "        count, start = (counts[-1] if counts else 0), (counts[-1] if counts else 0)\n",
            ),
            ("count == 50", "count - start == 50"),
        ),
        "theta3 comes first": (("    return angles,", "    return angles[:, [1, 0]],"),),
        "Rows and columns are exchanged": (("    return angles,", "    return np.transpose(angles),"),),
        "The iterations come first, and the positions second": (
            ("return angles, np.array(counts)", "return np.array(counts), angles"),
        ),
        "The angles are returned in degrees": (("angles = np.array(angles)", "angles = np.degrees(angles)"),),
        "The angles are brought into one turn, from 0 to 2 pi": (
            ("angles = np.array(angles)", "angles = np.mod(angles, 2 * np.pi)"),
        ),
        "The angles are brought into one turn, from -pi to pi": (
            ("angles = np.array(angles)", "angles = np.arctan2(np.sin(angles), np.cos(angles))"),
        ),
        "Every angle starts from the position before, whatever `warm` says": (("if warm:", "if True:"),),
        "Every angle starts from the seed, whatever `warm` says": (("if warm:", "if False:"),),
        "Where the linkage cannot close, the last iterate is returned": (
            ('                raise ArithmeticError(f"index {i}: not closed")\n', "                break\n"),
        ),
    },
)

WIPER_RATES = Student(
    """
def wiper_rates(q, crank, lengths):
    r0, r1, r2, r3 = lengths
    result = np.zeros((2, len(q), 2))
    for i in range(len(q)):
        (th2, th3), (th1, w1, al1) = q[i], crank[:, i]
        dx = r0 - r1 * np.cos(th1) - r2 * np.cos(th2) + r3 * np.cos(th3)
        dy = r1 * np.sin(th1) + r2 * np.sin(th2) - r3 * np.sin(th3)
        if math.hypot(dx, dy) > 1e-6:
            raise ValueError(f"open at index {i}")
        if abs(math.sin(th3 - th2)) < 1e-6:
            raise ValueError(f"dead: index {i}")
        s1, c1 = np.sin(th1), np.cos(th1)
        s2, c2 = np.sin(th2), np.cos(th2)
        s3, c3 = np.sin(th3), np.cos(th3)
        b2, b3 = r2, r3
        J = np.array([[b2 * s2, -b3 * s3], [b2 * c2, -b3 * c3]])
        right = np.array([-r1 * s1 * w1, -r1 * c1 * w1])
        w2, w3 = np.linalg.solve(J, right)
        n1 = r1 * w1**2
        n2 = r2 * w2**2
        n3 = r3 * w3**2
        t1 = r1 * al1
        gx = t1 * s1 + n1 * c1 + n2 * c2 - n3 * c3
        gy = t1 * c1 - n1 * s1 - n2 * s2 + n3 * s3
        al2, al3 = np.linalg.solve(J, [-gx, -gy])
        result[0, i] = w2, w3
        result[1, i] = al2, al3
    return result
""",
    {
        "The centripetal term of the crank is forgotten": (("n1 = r1 * w1**2", "n1 = 0"),),
        "The centripetal term of the coupler is forgotten": (("n2 = r2 * w2**2", "n2 = 0"),),
        "The centripetal term of the rocker is forgotten": (("n3 = r3 * w3**2", "n3 = 0"),),
        "The centripetal term of the crank has the wrong sign": (("+ n1 * c1", "- n1 * c1"),),
        "The centripetal term of the coupler has the wrong sign": (("- n2 * s2", "+ n2 * s2"),),
        "The centripetal term of the rocker has the wrong sign": (
            ("- n3 * c3", "+ n3 * c3"),
            ("+ n3 * s3", "- n3 * s3"),
        ),
        "The centripetal terms are forgotten, or their angular velocities are not squared": (
            ("w1**2", "w1"),
            ("w2**2", "w2"),
            ("w3**2", "w3"),
        ),
        "The angular acceleration of the crank is forgotten": (("t1 = r1 * al1", "t1 = 0"),),
        "The right side of the velocities has the wrong sign": (
            ("np.array([-r1 * s1 * w1, -r1 * c1 * w1])", "np.array([r1 * s1 * w1, r1 * c1 * w1])"),
        ),
        "The right side of the accelerations has the wrong sign": (("[-gx, -gy]", "[gx, gy]"),),
        "The right sides of both systems have the wrong sign": (
            ("np.array([-r1 * s1 * w1, -r1 * c1 * w1])", "np.array([r1 * s1 * w1, r1 * c1 * w1])"),
            ("[-gx, -gy]", "[gx, gy]"),
        ),
        "A sign of the Jacobian is wrong": (("[b2 * c2, -b3 * c3]", "[b2 * c2, b3 * c3]"),),
        "The Jacobian is transposed": (("-b3 * c3]])", "-b3 * c3]]).T"),),
        "Sine and cosine are exchanged in the Jacobian": (
            ("[[b2 * s2, -b3 * s3], [b2 * c2, -b3 * c3]]", "[[b2 * c2, -b3 * c3], [b2 * s2, -b3 * s3]]"),
        ),
        "Sine and cosine of the crank are exchanged in the velocity equations": (
            ("[-r1 * s1 * w1, -r1 * c1 * w1]", "[-r1 * c1 * w1, -r1 * s1 * w1]"),
        ),
        "The lengths of coupler and rocker are exchanged in the Jacobian": (("b2, b3 = r2, r3", "b2, b3 = r3, r2"),),
        "The crank angle is taken for degrees": (
            ("s1, c1 = np.sin(th1), np.cos(th1)", "s1, c1 = np.sin(np.radians(th1)), np.cos(np.radians(th1))"),
        ),
        "The angular velocity of the crank is taken as 1 rad/s": (
            ("        s1, c1 =", "        w1 = 1.0\n        s1, c1 ="),
        ),
        "The angular velocity of the crank is taken for revolutions per minute": (
            ("        s1, c1 =", "        w1 = w1 * 2 * np.pi / 60\n        s1, c1 ="),
        ),
        "The angular rates are returned in degrees": (("return result", "return np.degrees(result)"),),
        "The velocities are returned where the accelerations are asked for": (
            ("result[1, i] = al2, al3", "result[1, i] = w2, w3"),
        ),
        "Velocities and accelerations are exchanged": (
            ("result[0, i] = w2, w3", "result[1, i] = w2, w3 "),
            ("result[1, i] = al2, al3", "result[0, i] = al2, al3"),
        ),
        "The rates of theta3 come first": (
            ("result[0, i] = w2, w3", "result[0, i] = w3, w2"),
            ("result[1, i] = al2, al3", "result[1, i] = al3, al2"),
        ),
        "The points are along the last axis": (("return result", "return np.moveaxis(result, 2, 1)"),),
        "Positions that leave the loop open get rates": (("math.hypot(dx, dy) > 1e-6", "False"),),
        "A dead point gets rates": (
            (
                '        if abs(math.sin(th3 - th2)) < 1e-6:\n            raise ValueError(f"dead: index {i}")\n',
                "",
            ),
        ),
    },
)

WIPER_POINTS = Student(
    """
def wiper_points(theta1, q, rates, lengths):
    for length in lengths:
        if length <= 0:
            raise ValueError(f"there is a length of {length}")
    r0, r1, r2, r3, r4, r5, r6 = lengths
    xs, ys = [], []
    for th1, (th2, th3) in zip(theta1, q):
        c1, s1 = math.cos(th1), math.sin(th1)
        blade = th3
        c3, s3 = math.cos(blade), math.sin(blade)
        c = r0
        f = r0 + r5
        b = r3
        d = r4
        e = r4
        g = r6
        h = r6
        xs.append([r1 * c1, c + b * c3, c, c + d * c3, f + e * c3, f, c + g * c3, f + h * c3])
        ys.append([r1 * s1, b * s3, 0, d * s3, e * s3, 0, g * s3, h * s3])
    points = np.stack((np.transpose(xs), np.transpose(ys)), axis=-1)
    w, al = rates[0, :, 1], rates[1, :, 1]
    speed = r6 * np.sqrt(w**2)
    tangential = r6 * al
    normal = r6 * w**2
    acceleration = np.sqrt(tangential**2 + normal**2)
    return points, speed, acceleration
""",
    {
        "The second blade begins in C": (("f + e * c3, f,", "c + e * c3, f,"), ("f + h * c3", "c + h * c3")),
        "F is r5 from O, and not from C": (("f = r0 + r5", "f = r5"),),
        "r3 stands where r4 belongs: it is the point B": (("d = r4", "d = r3"), ("e = r4", "e = r3")),
        "r4 stands where r3 belongs: it is the point D": (("b = r3", "b = r4"),),
        "D is counted from B, and not from C": (("d = r4", "d = r3 + r4"), ("e = r4", "e = r3 + r4")),
        "G and H are counted from D and E": (("g = r6", "g = r4 + r6"), ("h = r6", "h = r4 + r6")),
        "r4 stands where r6 belongs: the blades end in D and E": (("g = r6", "g = r4"), ("h = r6", "h = r4")),
        "C is put in O": (("        c = r0\n", "        c = 0\n"),),
        "The angle of the coupler is taken for that of the blades": (("blade = th3", "blade = th2"),),
        "The rates of the coupler are taken for those of the blades": (
            ("rates[0, :, 1], rates[1, :, 1]", "rates[0, :, 0], rates[1, :, 0]"),
        ),
        "Sine and cosine are exchanged": (
            ("c1, s1 = math.cos(th1), math.sin(th1)", "c1, s1 = math.sin(th1), math.cos(th1)"),
            ("c3, s3 = math.cos(blade), math.sin(blade)", "c3, s3 = math.sin(blade), math.cos(blade)"),
        ),
        "y points down": (("np.transpose(ys)", "-np.transpose(ys)"),),
        "The angles are taken for degrees": (
            ("        c1, s1 =", "        th1 = math.radians(th1)\n        c1, s1 ="),
            ("blade = th3", "blade = math.radians(th3)"),
        ),
        "The speed of H keeps the sign of omega3": (("r6 * np.sqrt(w**2)", "r6 * w"),),
        "The speed is that of E": (("r6 * np.sqrt(w**2)", "r4 * np.sqrt(w**2)"),),
        "The acceleration is that of D": (("tangential = r6", "tangential = r4"), ("normal = r6", "normal = r4")),
        "The centripetal part of the acceleration is forgotten": (("+ normal**2", ""),),
        "The tangential part of the acceleration is forgotten": (("tangential**2 + ", ""),),
        "The angular velocity is not squared in the centripetal part": (("normal = r6 * w**2", "normal = r6 * w"),),
        "The two parts of the acceleration are added as if they had one direction": (
            ("np.sqrt(tangential**2 + normal**2)", "tangential + normal"),
        ),
        "Speed and acceleration are exchanged": (("points, speed, acceleration", "points, acceleration, speed"),),
        "The points have the shape (points, 8, 2)": (("return points,", "return np.moveaxis(points, 0, 1),"),),
        "The points have the shape (8, 2, points)": (("axis=-1", "axis=1"),),
        "A length that is not positive is drawn": (("if length <= 0:", "if False:"),),
    },
)

STUDENTS = {
    "grashof_class": GRASHOF_CLASS,
    "wiper_positions": WIPER_POSITIONS,
    "wiper_rates": WIPER_RATES,
    "wiper_points": WIPER_POINTS,
}
