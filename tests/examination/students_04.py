"""Mistakes of exercise 04 as students write them; see `students`."""

from examination.student import Student

CLOSURE_EQUATIONS = Student(
    """
def turned(along, across, angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([along * c - across * s, along * s + across * c])


def closure_equations(q, v, a, crank, lengths):
    r1, theta1, theta3 = q
    v_r, omega1, omega3 = v
    a_r, alpha1, alpha3 = a
    theta2, omega2, alpha2 = crank
    r1y, r2, r3 = lengths
    # position, velocity and acceleration of each vector, along it and across it
    p1 = turned(r1, 0, theta1)
    p2 = turned(r2, 0, theta2)
    p3 = turned(r3, 0, theta3)
    v1 = turned(v_r, r1 * omega1, theta1)
    v2 = turned(0, r2 * omega2, theta2)
    v3 = turned(0, r3 * omega3, theta3)
    a1 = turned(a_r - r1 * omega1**2, r1 * alpha1 + 2 * v_r * omega1, theta1)
    a2 = turned(-r2 * omega2**2, r2 * alpha2, theta2)
    a3 = turned(-r3 * omega3**2, r3 * alpha3, theta3)
    rows = []
    for one, two, three, height in [(p1, p2, p3, r1y), (v1, v2, v3, 0), (a1, a2, a3, 0)]:
        x = -one[0] + two[0] + three[0]
        y = one[1] - two[1] - three[1]
        c = one[1] - height
        rows.append([x, y, c])
    return np.array(rows)
""",
    {
        "The Coriolis term is missing": ((" + 2 * v_r * omega1", ""),),
        "The Coriolis term is there once": (("2 * v_r * omega1", "v_r * omega1"),),
        "The Coriolis term has the wrong sign": (("+ 2 * v_r * omega1", "- 2 * v_r * omega1"),),
        "The centripetal term of the crank is missing": (("-r2 * omega2**2", "0"),),
        "The centripetal term of the coupler is missing": (("-r3 * omega3**2", "0"),),
        "The centripetal term of r1 is missing": (("a_r - r1 * omega1**2", "a_r"),),
        "The centripetal terms are missing": (
            ("a_r - r1 * omega1**2", "a_r"),
            ("-r2 * omega2**2", "0"),
            ("-r3 * omega3**2", "0"),
        ),
        "Every term with a product of two velocities is missing": (
            ("a_r - r1 * omega1**2", "a_r"),
            (" + 2 * v_r * omega1", ""),
            ("-r2 * omega2**2", "0"),
            ("-r3 * omega3**2", "0"),
        ),
        "The centripetal terms point outwards": (
            ("a_r - r1 * omega1**2", "a_r + r1 * omega1**2"),
            ("-r2 * omega2**2", "r2 * omega2**2"),
            ("-r3 * omega3**2", "r3 * omega3**2"),
        ),
        "The angular velocity in the centripetal terms is not squared": (
            ("omega1**2", "omega1"),
            ("omega2**2", "omega2"),
            ("omega3**2", "omega3"),
        ),
        "The angular acceleration of the crank is missing": (("r2 * alpha2", "0"),),
        "theta2 is held constant": (("theta2, omega2, alpha2 = crank", "theta2, omega2, alpha2 = crank[0], 0, 0"),),
        "r1 is held constant": (
            ("v_r, omega1, omega3 = v", "v_r, omega1, omega3 = 0, v[1], v[2]"),
            ("a_r, alpha1, alpha3 = a", "a_r, alpha1, alpha3 = 0, a[1], a[2]"),
        ),
        "theta1 is held constant": (
            ("    p1 = turned(r1, 0, theta1)\n", "    omega1 = alpha1 = 0\n    p1 = turned(r1, 0, theta1)\n"),
        ),
        "The derivative of the cosine has the wrong sign": (
            ("along * c - across * s", "along * c + across * s"),
            ("a_r - r1 * omega1**2", "a_r + r1 * omega1**2"),
            ("-r2 * omega2**2", "r2 * omega2**2"),
            ("-r3 * omega3**2", "r3 * omega3**2"),
        ),
        "The height is still there in the derivatives": (
            ("(v1, v2, v3, 0)", "(v1, v2, v3, r1y)"),
            ("(a1, a2, a3, 0)", "(a1, a2, a3, r1y)"),
        ),
        "The coupler has the wrong sign in Fy": (("- three[1]", "+ three[1]"),),
        "Fx has the opposite sign": (("-one[0] + two[0] + three[0]", "one[0] - two[0] - three[0]"),),
        "The equations are in the order Fc, Fx, Fy": (("[x, y, c]", "[c, x, y]"),),
        "Sine and cosine are exchanged": (("    c, s = ", "    s, c = "),),
        "The angles are taken for degrees": (
            ("across, angle):\n", "across, angle):\n    angle = np.radians(angle)\n"),
        ),
        "The lengths are unpacked in the order r2, r3, r1y": (("r1y, r2, r3 = lengths", "r2, r3, r1y = lengths"),),
        "The result is transposed": (("return np.array(rows)", "return np.array(rows).T"),),
    },
)

CLOSURE_JACOBIAN = Student(
    """
def closure_jacobian(q, lengths):
    FX, FY, FC = 0, 1, 2
    R1, THETA1, THETA3 = 0, 1, 2
    r1, theta1, theta3 = q
    r1y, r2, r3 = lengths
    c1, s1 = np.cos(theta1), np.sin(theta1)
    c3, s3 = np.cos(theta3), np.sin(theta3)
    J = np.zeros((3, 3))
    J[FX, R1] = -c1
    J[FX, THETA1] = r1 * s1
    J[FX, THETA3] = -r3 * s3
    J[FY, R1] = s1
    J[FY, THETA1] = r1 * c1
    J[FY, THETA3] = -r3 * c3
    J[FC, R1] = s1
    J[FC, THETA1] = r1 * c1
    return J
""",
    {
        "The Jacobian is transposed": (("J\n", "J.T\n"),),
        "r1 is eliminated from Fx and Fy": (
            ("J[FX, R1] = -c1", "J[FX, R1] = 0"),
            ("J[FX, THETA1] = r1 * s1", "J[FX, THETA1] = r1y / s1**2"),
            ("J[FY, R1] = s1", "J[FY, R1] = 0"),
            ("J[FY, THETA1] = r1 * c1", "J[FY, THETA1] = 0"),
        ),
        "The rows are in the order Fc, Fx, Fy": (("FX, FY, FC = 0, 1, 2", "FC, FX, FY = 0, 1, 2"),),
        "The columns are in the order theta1, theta3, r1": (
            ("R1, THETA1, THETA3 = 0, 1, 2", "THETA1, THETA3, R1 = 0, 1, 2"),
        ),
        "Every sign is turned round": (("return ", "return -"),),
        "The derivative of the cosine has the wrong sign": (
            ("J[FX, THETA1] = ", "J[FX, THETA1] = -"),
            ("J[FX, THETA3] = -", "J[FX, THETA3] = "),
        ),
        "The coupler has the wrong sign in Fy": (("J[FY, THETA3] = -", "J[FY, THETA3] = "),),
        "The length of the crank stands where that of the coupler belongs": (
            ("r3 * s3", "r2 * s3"),
            ("r3 * c3", "r2 * c3"),
        ),
        "The factor r1 is missing in the derivatives by theta1": (
            ("r1 * s1", "s1"),
            ("J[FY, THETA1] = r1 * c1", "J[FY, THETA1] = c1"),
            ("J[FC, THETA1] = r1 * c1", "J[FC, THETA1] = c1"),
        ),
        "The column of r1 is zero": (
            ("    J[FX, R1] = -c1\n", ""),
            ("    J[FY, R1] = s1\n", ""),
            ("    J[FC, R1] = s1\n", ""),
        ),
        "Sine and cosine are exchanged": (("c1, s1 = ", "s1, c1 = "), ("c3, s3 = ", "s3, c3 = ")),
        "The angles are taken for degrees": (
            ("    r1, theta1, theta3 = q\n", "    r1, theta1, theta3 = q[0], np.radians(q[1]), np.radians(q[2])\n"),
        ),
    },
)

ASSEMBLIES = Student(
    """
def assemblies(theta2, lengths):
    r1y, r2, r3 = lengths
    xa = r2 * np.cos(theta2)
    ya = r2 * np.sin(theta2)
    sine = (r1y - ya) / r3
    if abs(sine) > 1:
        raise ValueError(f"the loop cannot close at theta2 = {theta2}: the sine of theta3 would be {sine}")
    right = np.arcsin(sine)
    left = np.pi - right
    rows = []
    for theta3 in (left, right):
        # the slider as seen from O
        x = xa + r3 * np.cos(theta3)
        y = r1y
        r1 = np.hypot(x, y)
        theta1 = np.arctan2(y, x)
        rows.append([r1, theta1, theta3])
    return np.array(rows)
""",
    {
        "The assemblies are in the other order": (("in (left, right)", "in (right, left)"),),
        "Both rows hold the same assembly": (("in (left, right)", "in (left, left)"),),
        "Both rows hold the same assembly, the one with the coupler to the right": (
            ("in (left, right)", "in (right, right)"),
        ),
        "The second solution of the sine is taken at pi plus the first": (("np.pi - right", "np.pi + right"),),
        "The height of the guide is missing from the angle of the coupler": (("(r1y - ya) / r3", "-ya / r3"),),
        "The height of the crank pin is added where it is to be subtracted": (("r1y - ya", "r1y + ya"),),
        "The sine of the coupler has the wrong sign": (("np.arcsin(sine)", "np.arcsin(-sine)"),),
        "theta1 lies in the wrong quadrant": (("np.arctan2(y, x)", "np.arctan(y / x)"),),
        "The sign of r1 is taken from the assembly, and not from where the slider is": (
            ("np.hypot(x, y)", "np.sign(np.cos(theta3)) * np.hypot(x, y)"),
            ("np.arctan2(y, x)", "np.arctan(y / x)"),
        ),
        "r1 is the x of the slider, and not its distance from O": (("np.hypot(x, y)", "x"),),
        "r1 begins at the crank pin, and not at O": (
            ("x = xa + r3 * np.cos(theta3)", "x = r3 * np.cos(theta3)"),
            ("        y = r1y\n", "        y = r1y - ya\n"),
        ),
        "The columns are in the order r1, theta3, theta1": (("[r1, theta1, theta3]", "[r1, theta3, theta1]"),),
        "The angles are returned in degrees": (
            ("return np.array(rows)", "return np.array(rows) * [1, 180 / np.pi, 180 / np.pi]"),
        ),
        "theta2 is taken for degrees": (
            ("    r1y, r2, r3 = lengths\n", "    r1y, r2, r3 = lengths\n    theta2 = np.radians(theta2)\n"),
        ),
        "Where the loop cannot close, it is closed by force": (
            (
                'raise ValueError(f"the loop cannot close at theta2 = {theta2}: the sine of theta3 would be {sine}")',
                "sine = max(-1, min(1, sine))",
            ),
        ),
        "Only a crank pin too far below the guide is refused": (("abs(sine) > 1", "sine > 1"),),
    },
)

STUDENTS = {
    "closure_equations": CLOSURE_EQUATIONS,
    "closure_jacobian": CLOSURE_JACOBIAN,
    "assemblies": ASSEMBLIES,
}
