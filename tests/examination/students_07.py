"""Mistakes of exercise 07 as students write them; see `students`."""

from examination.student import Student

CLOSED_POSITION = Student(
    """
def closed_position(theta2, lengths, branch="left"):
    r1y, r2, r3 = lengths
    theta2 = np.asarray(theta2, dtype=float)
    pin_x, pin_y = r2 * np.cos(theta2), r2 * np.sin(theta2)
    s = (r1y - pin_y) / r3
    too_low = s > 1
    too_high = s < -1
    bad = too_low | too_high
    if np.any(bad):
        index = list(np.ravel(bad)).index(True)
        raise ValueError(f"The saw cannot close at index {index}")
    if branch == "left":
        theta3 = np.pi - np.arcsin(s)
        sign = -1
    else:
        theta3 = np.arcsin(s)
        sign = 1
    x = pin_x + r3 * np.cos(theta3)
    length = np.sqrt(x**2 + r1y**2)
    r1 = sign * length
    # the direction of the slider, seen from O, lies between 0 and pi
    direction = np.arctan2(r1y, x)
    theta1 = direction - np.pi if branch == "left" else direction
    return np.stack([r1, theta1, theta3], axis=-1)
""",
    {
        "The branches are exchanged": (
            (
                "    theta2 = np.asarray",
                "    branch = 'right' if branch == 'left' else 'left'\n    theta2 = np.asarray",
            ),
        ),
        "The coupler always points to the right": (
            ("    theta2 = np.asarray", "    branch = 'right'\n    theta2 = np.asarray"),
        ),
        "The coupler always points to the left": (
            ("    theta2 = np.asarray", "    branch = 'left'\n    theta2 = np.asarray"),
        ),
        "The second solution of the sine is taken at pi plus the first": (
            ("np.pi - np.arcsin(s)", "np.pi + np.arcsin(s)"),
        ),
        "The height of the guide is missing from the angle of the coupler": (("s = (r1y - pin_y)", "s = (-pin_y)"),),
        "The height of the guide has the wrong sign": (("s = (r1y - pin_y)", "s = (-r1y - pin_y)"),),
        "The height of the crank pin is added where it is to be subtracted": (("r1y - pin_y", "r1y + pin_y"),),
        "The sine of the coupler has the wrong sign": (("s = (r1y - pin_y)", "s = (pin_y - r1y)"),),
        "Sine and cosine are exchanged": (
            (
                "pin_x, pin_y = r2 * np.cos(theta2), r2 * np.sin(theta2)",
                "pin_x, pin_y = r2 * np.sin(theta2), r2 * np.cos(theta2)",
            ),
            ("r3 * np.cos(theta3)", "r3 * np.sin(theta3)"),
        ),
        "r1 is made positive": (("np.stack([r1,", "np.stack([abs(r1),"),),
        "r1 is positive on both branches, and theta1 points to the slider": (
            ("r1 = sign * length", "r1 = length"),
            ('direction - np.pi if branch == "left" else direction', "direction"),
        ),
        "theta1 is half a turn off on the left branch": (
            ('direction - np.pi if branch == "left" else direction', "direction"),
        ),
        "theta1 has the wrong sign": (("theta1, theta3]", "-theta1, theta3]"),),
        "theta1 is measured from the vertical": (
            ('theta1 = direction - np.pi if branch == "left" else direction', "theta1 = np.arctan(x / r1y)"),
        ),
        "r1 is the x of the slider, and not its distance from O": (("r1 = sign * length", "r1 = x"),),
        "theta1 is the arc tangent of r1y/x, and leaps where the slider passes the shaft": (
            ('theta1 = direction - np.pi if branch == "left" else direction', "theta1 = np.arctan(r1y / x)"),
        ),
        "The angles are brought into one turn, from 0 to 2 pi": (
            ("theta1, theta3]", "np.mod(theta1, 2 * np.pi), np.mod(theta3, 2 * np.pi)]"),
        ),
        "The angles are brought into one turn, from -pi to pi": (
            ("theta1, theta3]", "theta1, np.arctan2(np.sin(theta3), np.cos(theta3))]"),
        ),
        "The angles are returned in degrees": (("theta1, theta3]", "np.degrees(theta1), np.degrees(theta3)]"),),
        "theta2 is taken for degrees": (("np.asarray(theta2, dtype=float)", "np.radians(theta2)"),),
        "The columns are in the order theta3, theta1, r1": (("[r1, theta1, theta3]", "[theta3, theta1, r1]"),),
        "Rows and columns are exchanged": (
            ("np.stack([r1, theta1, theta3], axis=-1)", "np.array([r1, theta1, theta3])"),
        ),
        "Where the loop cannot close, nan is returned": (("if np.any(bad):", "if False:"),),
        "Where the loop cannot close, it is closed by force": (
            ("if np.any(bad):", "if False:"),
            ("s = (r1y - pin_y) / r3", "s = np.maximum(-1, np.minimum(1, (r1y - pin_y) / r3))"),
        ),
        "Only a crank pin too far below the guide is refused": (("bad = too_low | too_high", "bad = too_low"),),
        "Only a crank pin too far above the guide is refused": (("bad = too_low | too_high", "bad = too_high"),),
    },
)

CLOSED_FORM = Student(
    """
def closed_form(theta2, omega2, alpha2, lengths):
    r1y, r2, r3 = lengths
    omega, alpha = omega2, alpha2
    S2, C2 = np.sin(theta2), np.cos(theta2)
    h = r1y - r2 * S2
    if np.any(np.abs(h) > r3):
        raise ValueError("the loop cannot close at " + str(np.where(np.abs(h) > r3)[0]))
    reach = np.sqrt(r3**2 - h**2)
    side = -1
    S3, C3 = h / r3, side * reach / r3
    theta3 = np.arctan2(h, reach) if side > 0 else np.pi - np.arctan2(h, reach)
    x = r2 * C2 + r3 * C3
    r1 = side * np.hypot(x, r1y)
    C1, S1 = x / r1, r1y / r1
    theta1 = np.arctan2(S1, C1)

    omega3 = -omega * r2 * C2 / (r3 * C3)
    u = -r2 * S2 * omega - r3 * S3 * omega3
    square2, square3 = omega**2, omega3**2
    crank = r2 * square2
    coupler = r3 * square3
    drive = r2 * alpha
    alpha3 = (crank * S2 + coupler * S3 - drive * C2) / (r3 * C3)
    a = -crank * C2 - drive * S2 - coupler * C3 - r3 * S3 * alpha3

    along, across = u * C1, -u * S1
    omega1 = across / r1
    coriolis = 2 * along * omega1
    alpha1 = (-a * S1 - coriolis) / r1
    square1 = omega1**2
    turning = r1 * square1
    a_r = a * C1 + turning
    v_r = along

    position = np.stack([r1, theta1, theta3], axis=-1)
    velocity = np.stack([v_r, omega1, omega3], axis=-1)
    acceleration = np.stack([a_r, alpha1, alpha3], axis=-1)
    result = np.array([position, velocity, acceleration])
    return result
""",
    {
        "The centripetal term of the crank is forgotten": (("crank = r2 * square2", "crank = 0"),),
        "The centripetal term of the coupler is forgotten": (("coupler = r3 * square3", "coupler = 0"),),
        "The angular acceleration of the crank is forgotten": (("drive = r2 * alpha", "drive = 0"),),
        "The centripetal term of r1 is forgotten": (("turning = r1 * square1", "turning = 0"),),
        "The centripetal term of r1 has the wrong sign": (("a * C1 + turning", "a * C1 - turning"),),
        "The Coriolis term has the wrong sign": (("-a * S1 - coriolis", "-a * S1 + coriolis"),),
        "The Coriolis term is forgotten": (("2 * along * omega1", "0"),),
        "The Coriolis term is counted once": (("2 * along * omega1", "along * omega1"),),
        "The angular velocities are not squared": (
            ("omega**2, omega3**2", "omega, omega3"),
            ("square1 = omega1**2", "square1 = omega1"),
        ),
        "omega3 has the wrong sign": (("omega3 = -omega * r2", "omega3 = omega * r2"),),
        "The slider's motion along the guide is taken for that along r1": (
            ("a_r = a * C1 + turning", "a_r = a"),
            ("v_r = along", "v_r = u"),
        ),
        "The coupler points to the right": (("side = -1", "side = 1"),),
        "omega2 is taken for revolutions per minute": (
            ("omega, alpha = omega2,", "omega, alpha = omega2 * 2 * np.pi / 60,"),
        ),
        "omega2 and alpha2 are taken for degrees": (
            ("omega, alpha = omega2, alpha2", "omega, alpha = np.radians(omega2), np.radians(alpha2)"),
        ),
        "theta2 is taken for degrees": (
            ("np.sin(theta2), np.cos(theta2)", "np.sin(np.radians(theta2)), np.cos(np.radians(theta2))"),
        ),
        "omega2 is taken as 1 rad/s": (("omega, alpha = omega2,", "omega, alpha = 1.0,"),),
        "The angles and their derivatives are returned in degrees": (
            ("    return result\n", "    result[:, :, 1:] = np.degrees(result[:, :, 1:])\n    return result\n"),
        ),
        "Velocities and accelerations are exchanged": (
            ("[position, velocity, acceleration]", "[position, acceleration, velocity]"),
        ),
        "The points are along the last axis": (
            ("    return result\n", "    return np.transpose(result, (0, 2, 1))\n"),
        ),
        "The nine are side by side in one row": (
            (
                "result = np.array([position, velocity, acceleration])",
                "result = np.hstack([position, velocity, acceleration])",
            ),
        ),
        "Where the loop cannot close, nan is returned": (("if np.any(np.abs(h) > r3):", "if False:"),),
    },
)

ABSOLUTE_ERRORS = Student(
    """
def absolute_errors(computed, exact):
    computed, exact = np.array(computed), np.array(exact)
    if computed.shape != exact.shape:
        raise ValueError(f"{computed.shape} and {exact.shape}")
    points = computed.shape[1]
    exact = exact[:, :points]
    errors = np.empty(exact.shape)
    for level in range(3):
        for j in range(3):
            gap = computed[level, :, j] - exact[level, :, j]
            scale = 1
            if level == 0 and j > 0:
                gap = np.angle(np.exp(1j * gap))
            errors[level, :, j] = abs(gap) / scale
    largest = np.max(errors, axis=1)
    return errors, largest
""",
    {
        "The errors are relative": (("scale = 1", "scale = abs(exact[level, :, j])"),),
        "The errors keep their sign": (("abs(gap)", "gap"),),
        "The errors are squared": (("abs(gap)", "gap**2"),),
        "Small errors of the angles are lost in a cosine": (("np.angle(np.exp(1j * gap))", "np.arccos(np.cos(gap))"),),
        "Angles that are whole turns apart are different": (("np.angle(np.exp(1j * gap))", "gap"),),
        "Whole turns are left out of more than the angles": (("if level == 0 and j > 0:", "if True:"),),
        "The mean is taken in place of the largest": (("np.max(", "np.mean("),),
        "The norm over the points is taken in place of the largest": (("np.max(", "np.linalg.norm("),),
        "The three quantities of a level are thrown together": (("axis=1)", "axis=(1, 2))"),),
        "The largest is taken over the quantities, and not over the points": (("axis=1)", "axis=2)"),),
        "The angles and their derivatives are returned in degrees": (
            ("    largest = ", "    errors[:, :, 1:] = np.degrees(errors[:, :, 1:])\n    largest = "),
        ),
        "The largest come first, and the errors second": (("return errors, largest", "return largest, errors"),),
        "A point without a number is passed over": (("np.max(", "np.nanmax("),),
        "Unequal numbers of points are paired by force": (
            (
                '        raise ValueError(f"{computed.shape} and {exact.shape}")\n    points = computed.shape[1]\n',
                "        pass\n    points = min(computed.shape[1], exact.shape[1])\n",
            ),
            ("    exact = exact[:, :points]", "    computed, exact = computed[:, :points], exact[:, :points]"),
        ),
    },
)

STUDENTS = {
    "closed_position": CLOSED_POSITION,
    "closed_form": CLOSED_FORM,
    "absolute_errors": ABSOLUTE_ERRORS,
}
