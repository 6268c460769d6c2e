"""Mistakes of exercise 09 as students write them; see `students`."""

from examination.student import Student

STEINER = Student(
    """
def steiner(inertia, mass, given, wanted):
    result = []
    for I, m, d1, d2 in zip(inertia, mass, given, wanted):
        factor, power = m, 2
        down = factor * d1**power
        up = factor * d2**power
        I_G = I - down
        if I_G <= 0:
            raise ValueError(f"the moment about the centre of mass would be {I_G}")
        result.append(I_G + up)
    return np.array(result)
""",
    {
        "The given moments are taken for those about the centre of mass": (("down = factor * d1**power", "down = 0"),),
        "The moments about the centre of mass are returned": (("up = factor * d2**power", "up = 0"),),
        "The distance between the two axes is squared": (
            ("down = factor * d1**power", "down = 0"),
            ("up = factor * d2**power", "up = factor * (d1 - d2)**power"),
        ),
        "m d^2 is added on the way to the centre of mass": (("I_G = I - down", "I_G = I + down"),),
        "m d^2 is subtracted on the way from the centre of mass": (("I_G + up", "I_G - up"),),
        "m d^2 is added and subtracted the wrong way round": (
            ("I_G = I - down", "I_G = I + down"),
            ("I_G + up", "I_G - up"),
        ),
        "The distances are not squared": (("power = m, 2", "power = m, 1"), ("I_G <= 0", "I_G <= -1e9")),
        "The weight stands where the mass belongs": (
            ("factor, power = m", "factor, power = m * 9.81"),
            ("<= 0", "< -99"),
        ),
        "The mass is missing from the second term": (
            ("factor, power = m", "factor, power = 1"),
            ("I_G <= 0:", "False:"),
        ),
        "A moment that no body can have goes through": (("if I_G <= 0", "if I_G != I_G"),),
    },
)

CENTRE_ACCELERATIONS = Student(
    """
def centre_accelerations(motion, lengths, bars):
    theta, omega, alpha = motion
    n = len(theta)
    gravity = 0
    for i in range(n):
        if not np.all(np.isfinite(motion[:, i])):
            raise ValueError(f"not a number at point {i}")

    def circle(r, k):
        w, al = omega[:, k], alpha[:, k]
        angle = theta[:, k]
        c, s = np.cos(angle), np.sin(angle)
        tangential = r * al
        inward = r * w**2
        return np.array([-tangential * s - inward * c, tangential * c - inward * s])

    r1, r3, r4, r5 = lengths[1], lengths[3], lengths[4], lengths[5]
    d1, d2, d3, d4, d5 = bars[:, 0]
    crank, coupler, rocker = 0, 1, 2
    of_a = circle(r1, crank)
    of_the_bar = circle(r4, rocker)
    a = np.zeros((n, 5, 2))
    a[:, 0] = circle(d1, crank).T
    a[:, 1] = (of_a + circle(d2, coupler)).T
    a[:, 2] = circle(d3, rocker).T
    a[:, 3] = circle(d4, rocker).T
    a[:, 4] = of_the_bar.T
    a[:, :, 1] += gravity
    return a
""",
    {
        "The centripetal terms are missing": (("inward = r * w**2", "inward = 0"),),
        "The centripetal terms point outwards": (("inward = r * w**2", "inward = -r * w**2"),),
        "The tangential terms are missing": (("tangential = r * al", "tangential = 0"),),
        "The tangential terms have the wrong sign": (("tangential = r * al", "tangential = -r * al"),),
        "The angular velocities are not squared": (("inward = r * w**2", "inward = r * w"),),
        "The acceleration of A is missing from G2": (("of_a + circle(d2, coupler)", "circle(d2, coupler)"),),
        "The centripetal acceleration of A is missing from G2": (
            (
                "of_a = circle(r1, crank)",
                "of_a = r1 * alpha[:, 0] * np.array([-np.sin(theta[:, 0]), np.cos(theta[:, 0])])",
            ),
        ),
        "The bar has the acceleration of B, and not that of D": (
            ("of_the_bar = circle(r4,", "of_the_bar = circle(r3,"),
        ),
        "The bar turns": (("a[:, 4] = of_the_bar.T", "a[:, 4] = (of_the_bar + circle(d5, rocker)).T"),),
        "The centres of mass are taken at the middles of the bars": (
            ("= bars[:, 0]\n", "= r1 / 2, lengths[2] / 2, r4 / 2, r4 / 2, r5 / 2\n"),
        ),
        "The centres of mass of the two blades are exchanged": (("d1, d2, d3, d4, d5", "d1, d2, d4, d3, d5"),),
        "Coupler and rocker exchange their angles": (
            ("crank, coupler, rocker = 0, 1, 2", "crank, rocker, coupler = 0, 1, 2"),
        ),
        "Sine and cosine are exchanged": (("np.cos(angle), np.sin(angle)", "np.sin(angle), np.cos(angle)"),),
        "The angles are taken for degrees": (("angle = theta[:, k]", "angle = np.radians(theta[:, k])"),),
        "The velocities are returned": (
            (
                "return np.array([-tangential * s - inward * c, tangential * c - inward * s])",
                "return r * w * np.array([-s, c])",
            ),
        ),
        "Gravity is added": (("gravity = 0", "gravity = 9.81"),),
        "The sizes are returned, and not the vectors": (
            ("    return a\n", "    return np.hypot(a[..., 0], a[..., 1])\n"),
        ),
        "The bars come first, and the points second": (("    return a\n", "    return a.transpose(1, 0, 2)\n"),),
        "nan goes through": (("if not np.all(np.isfinite(motion[:, i])):", "if False:"),),
    },
)

FIFTEEN_EQUATIONS = Student(
    """
def fifteen_equations(motion, accelerations, loads, lengths, bars):
    theta, omega, alpha = motion
    points = len(theta)
    if np.shape(loads) != (points, 2, 2):
        raise ValueError("loads must be (points, 2, 2)")
    r0, r1, r2, r3, r4, r5, r6 = lengths
    rG, m, I_G = bars[:, 0], bars[:, 1], bars[:, 2]
    theta = 1.0 * theta
    g = 9.81
    up, down = 1, -1
    cos, sin = np.cos(theta), np.sin(theta)
    c1, c2, c3 = cos.T
    s1, s2, s3 = sin.T
    al1, al2, al3 = alpha.T
    f3, f4 = loads[:, 0], loads[:, 1]
    f3x, f3y, f4x, f4y = f3[:, 0], f3[:, 1], f4[:, 0], f4[:, 1]

    A = np.zeros((points, 15, 15))
    b = np.zeros((points, 15))
    # forces
    for row, columns in ((0, {1: up, 3: up}), (3, {3: down, 5: up}), (6, {5: down, 7: up, 9: up})):
        for column, sign in columns.items():
            A[:, row, column] = sign
            A[:, row + 1, column + 1] = sign
    for row, columns in ((9, {11: down, 13: up}), (12, {9: down, 11: up})):
        for column, sign in columns.items():
            A[:, row, column] = sign
            A[:, row + 1, column + 1] = sign
    # moments
    at_d, at_e, on_the_bar = r4, r4, r5
    A[:, 2, 0] = 1
    A[:, 2, 3], A[:, 2, 4] = -r1 * s1, r1 * c1
    A[:, 5, 5], A[:, 5, 6] = -r2 * s2, r2 * c2
    A[:, 8, 5], A[:, 8, 6] = -down * r3 * s3, down * r3 * c3
    A[:, 8, 9], A[:, 8, 10] = -at_d * s3, at_d * c3
    A[:, 11, 11], A[:, 11, 12] = -down * at_e * s3, down * at_e * c3
    A[:, 14, 12] = on_the_bar

    # right side
    mass = m
    inertia = mass * 1.0
    for k in range(5):
        b[:, 3 * k] = inertia[k] * accelerations[:, k, 0]
        b[:, 3 * k + 1] = inertia[k] * accelerations[:, k, 1] + mass[k] * g
    b[:, 6] -= f3x
    b[:, 7] -= f3y
    b[:, 9] -= f4x
    b[:, 10] -= f4y
    # Steiner, and the acceleration of A
    turning = I_G * 1.0
    more = mass * rG**2
    I_O, I_A, I_C, I_F = (turning + more)[:4]
    a2x, a2y = accelerations[:, 1].T
    own = mass[1] * rG[1]**2 * al2
    carried = mass[1] * rG[1] * (c2 * a2y - s2 * a2x) - own
    to_the_bar = rG[4]
    b[:, 2] = I_O * al1 + mass[0] * g * rG[0] * c1
    b[:, 5] = I_A * al2 + carried + mass[1] * g * rG[1] * c2
    b[:, 8] = I_C * al3 + mass[2] * g * rG[2] * c3 - rG[2] * (c3 * f3y - s3 * f3x)
    b[:, 11] = I_F * al3 + mass[3] * g * rG[3] * c3 - rG[3] * (c3 * f4y - s3 * f4x)
    b[:, 14] = mass[4] * to_the_bar * (accelerations[:, 4, 1] + g)
    return A, b
""",
    {
        "I_G stands where the moment about the joint belongs": (("more = mass * rG**2", "more = 0"),),
        "Steiner's term is counted twice": (("more = mass * rG**2", "more = 2 * mass * rG**2"),),
        "The acceleration of A is missing from the moments about A": (("I_A * al2 + carried", "I_A * al2"),),
        "The weight is forgotten": (("g = 9.81", "g = 0"),),
        "The weight is counted twice": (("g = 9.81", "g = 2 * 9.81"),),
        "The weight pulls upwards": (("g = 9.81", "g = -9.81"),),
        "The loads are forgotten": (("f3, f4 = loads[:, 0], loads[:, 1]", "f3 = f4 = np.zeros((points, 2))"),),
        "The loads have the wrong sign": (
            ("f3, f4 = loads[:, 0], loads[:, 1]", "f3, f4 = -loads[:, 0], -loads[:, 1]"),
        ),
        "m a and I alpha have the wrong sign": (
            ("inertia = mass * 1.0", "inertia, accelerated = -mass, -accelerations"),
            ("turning = I_G * 1.0", "turning = -I_G"),
            ("more = mass * rG**2", "more = -mass * rG**2"),
            ("- own\n", "- own\n    carried = -carried\n"),
            ("(accelerations[:, 4, 1] + g)", "(accelerated[:, 4, 1] + g)"),
        ),
        "The centre of mass of the bar has the arm r5": (("to_the_bar = rG[4]", "to_the_bar = r5"),),
        "E has half of the bar as its arm": (("on_the_bar = r4, r4, r5", "on_the_bar = r4, r4, r5 / 2"),),
        "E has the arm r4 + a on the second blade": (
            ("at_d, at_e,", "at_d, at_e, _ = r4, 2 * r4 - r3, 0\n    at_d, _,"),
        ),
        "D has the arm r3 on the first blade": (("on_the_bar = r4, r4, r5", "on_the_bar = r3, r4, r5"),),
        "The bar has an angular acceleration": (
            ("(accelerations[:, 4, 1] + g)\n", "(accelerations[:, 4, 1] + g) + I_G[4] * al3\n"),
        ),
        "The centres of mass are taken at the middles of the bars": (
            ("rG, m, I_G = bars[:, 0],", "rG, m, I_G = np.array([r1, r2, r4, r4, r5]) / 2,"),
        ),
        "A joint force acts on both bodies with the same sign": (("up, down = 1, -1", "up, down = 1, 1"),),
        "Every joint force has the opposite sign": (("    return A, b\n", "    A[:, :, 1:] *= -1\n    return A, b\n"),),
        "The moments count clockwise": (
            ("    return A, b\n", "    A[:, 2::3] *= -1\n    b[:, 2::3] *= -1\n    return A, b\n"),
        ),
        "All equations have the opposite sign": (("    return A, b\n", "    return -A, -b\n"),),
        "The torque has the wrong sign": (("A[:, 2, 0] = 1", "A[:, 2, 0] = -1"),),
        "Sine and cosine are exchanged in the arms": (
            ("np.cos(theta), np.sin(theta)", "np.sin(theta), np.cos(theta)"),
        ),
        "The angles are taken for degrees": (("theta = 1.0 * theta", "theta = np.radians(theta)"),),
        "First come all rows of x, then those of y, then the moments": (
            (
                "    return A, b\n",
                "    order = np.arange(15).reshape(5, 3).T.ravel()\n    return A[:, order], b[:, order]\n",
            ),
        ),
        "The five moments come after the ten forces": (
            (
                "    return A, b\n",
                "    order = [0, 1, 3, 4, 6, 7, 9, 10, 12, 13, 2, 5, 8, 11, 14]\n    return A[:, order], b[:, order]\n",
            ),
        ),
        "The torque is the last unknown": (
            ("    return A, b\n", "    return np.concatenate((A[:, :, 1:], A[:, :, :1]), axis=2), b\n"),
        ),
        "All components along x come before those along y": (
            (
                "    return A, b\n",
                "    return np.concatenate((A[:, :, :1], A[:, :, 1::2], A[:, :, 2::2]), axis=2), b\n",
            ),
        ),
        "The matrix is transposed": (("    return A, b\n", "    return A.transpose(0, 2, 1), b\n"),),
        "The right side is a matrix of one column": (("    return A, b\n", "    return A, b[:, :, np.newaxis]\n"),),
        "Loads of another shape go through": (
            (
                'if np.shape(loads) != (points, 2, 2):\n        raise ValueError("loads must be (points, 2, 2)")\n',
                "loads = loads + np.zeros((points, 2, 2))\n",
            ),
        ),
    },
)

TORQUE_AND_FORCES = Student(
    """
def torque_and_forces(system, velocities, size):
    points = len(velocities)
    loads = np.zeros((points, 2, 2))
    for i in range(points):
        for blade in (0, 1):
            vx, vy = velocities[i, blade]
            v = math.sqrt(vx**2 + vy**2)
            if v > 0:
                loads[i, blade] = [-size * vx / v, -size * vy / v]
    loads = 1 * loads
    matrix, right = system(loads)
    torque, forces = np.zeros(points), np.zeros((points, 7, 2))
    for i in range(points):
        if not np.linalg.cond(matrix[i]) < 1e12:
            raise ValueError(f"singular at point {i}")
        here = i
        x = np.linalg.solve(matrix[i], right[i])
        torque[i] = x[0]
        forces[i] = x[1:].reshape(7, 2)
    return torque, forces
""",
    {
        "The friction is along the motion": (("loads = 1 * loads", "loads = -loads"),),
        "The friction is taken component by component": (
            ("[-size * vx / v, -size * vy / v]", "[-size * np.sign(vx), -size * np.sign(vy)]"),
        ),
        "The friction has an x component only": (("-size * vy / v]", "0]"),),
        "The friction grows with the speed": (("[-size * vx / v, -size * vy / v]", "[-size * vx, -size * vy]"),),
        "Only one blade is rubbed": (("for blade in (0, 1):", "for blade in (0,):"),),
        "Each blade has half of the friction": (("loads = 1 * loads", "loads = loads / 2"),),
        "There is no friction": (("loads = 1 * loads", "loads = 0 * loads"),),
        "Each point has the friction of the point before": (
            ("loads = 1 * loads", "loads = np.array([loads[max(i - 1, 0)] for i in range(points)])"),
        ),
        "The matrix of the first point serves for all": (("np.linalg.solve(matrix[i]", "np.linalg.solve(matrix[0]"),),
        "Every point has the solution of the last": (
            (
                "    return torque, forces\n",
                "    return np.full(points, torque[-1]), np.array([forces[-1]] * points)\n",
            ),
        ),
        "Each point has the solution of the point before": (
            (
                "x = np.linalg.solve(matrix[i], right[i])",
                "x, new = (np.zeros(15) if i == 0 else new), np.linalg.solve(matrix[i], right[i])",
            ),
        ),
        "The norm of the torque is returned": (("torque[i] = x[0]", "torque[i] = np.linalg.norm(x[:1])"),),
        "The torque is taken from the last unknown": (
            ("torque[i] = x[0]", "torque[i] = x[14]"),
            ("x[1:].reshape(7, 2)", "x[:14].reshape(7, 2)"),
        ),
        "The forces are cut into x and y in the wrong order": (("x[1:].reshape(7, 2)", "x[1:].reshape(2, 7).T"),),
        "The forces are in one row": (
            ("    return torque, forces\n", "    return torque, forces.reshape(points, 14)\n"),
        ),
        "The forces come first, and the torque second": (
            ("    return torque, forces\n", "    return forces, torque\n"),
        ),
        "A blade that stands still gets nan": (("if v > 0:", "if True:"), ("v = math.sqrt(", "v = np.sqrt(")),
    },
)

POWER_RESIDUAL = Student(
    """
def power_residual(motion, velocities, accelerations, loads, bars, torque):
    points = motion.shape[1]
    for array in (velocities, accelerations, loads, torque):
        if np.shape(array)[0] != points:
            raise ValueError("another number of points")
    omega, alpha = motion[1], motion[2]
    rG, m, I = bars.T
    g, both = 9.81, (0, 1)
    with_a, inertia = 1, I
    watts = torque * omega[:, 0]
    for blade in both:
        fx, fy = loads[:, blade].T
        vx, vy = velocities[:, blade + 2].T
        friction = fx * vx + fy * vy
        watts = watts + friction
    for k in range(5):
        ax, ay = with_a * accelerations[:, k].T
        vx, vy = velocities[:, k].T
        watts = watts - m[k] * (ax * vx + (ay + g) * vy)
    turning = {0: 0, 1: 1, 2: 2, 3: 2}
    for body, angle in turning.items():
        watts = watts - inertia[body] * alpha[:, angle] * omega[:, angle]
    return watts
""",
    {
        "The weight is forgotten": (("g, both = 9.81", "g, both = 0"),),
        "The weight is counted twice": (("g, both = 9.81", "g, both = 2 * 9.81"),),
        "The weight has the wrong sign": (("g, both = 9.81", "g, both = -9.81"),),
        "The friction is forgotten": (("friction = fx * vx + fy * vy", "friction = 0"),),
        "The friction has the wrong sign": (("watts = watts + friction", "watts = watts - friction"),),
        "The friction of one blade is forgotten": (("9.81, (0, 1)", "9.81, (0,)"),),
        "The energy of turning is forgotten": (("turning = {0: 0, 1: 1, 2: 2, 3: 2}", "turning = {}"),),
        "The moments of inertia are those about the joints": (
            ("with_a, inertia = 1, I", "with_a, inertia = 1, I + m * rG**2"),
        ),
        "The bar turns": (("3: 2}", "3: 2, 4: 2}"),),
        "The energy of translation is forgotten": (("with_a, inertia = 1,", "with_a, inertia = 0,"),),
        "The norm of the torque is taken": (("watts = torque * omega", "watts = np.abs(torque) * omega"),),
        "The torque is not multiplied by the angular velocity": (("watts = torque * omega[:, 0]", "watts = torque"),),
        "The residual has the wrong sign": (("    return watts\n", "    return -watts\n"),),
        "It is divided by the angular velocity of the crank": (
            ("    return watts\n", "    return watts / omega[:, 0]\n"),
        ),
        "The number of points is not looked at": (("if np.shape(array)[0] != points:", "if False:"),),
    },
)

RESIDUALS = """
def body_residuals(motion, places, accelerations, loads, bars, torque, forces):
    points = motion.shape[1]
    for array in (places, accelerations, loads, torque, forces):
        if np.shape(array)[0] != points:
            raise ValueError("another number of points")
    alpha = motion[2]
    rG, m, I = bars.T
    g, minus, a_sign, load_sign, alpha_sign = 9.81, -1, 1, 1, 1
    O, A, B, C, D, E, F = range(7)
    on_blades = [[(B, minus), (C, 1), (D, 1)], [(E, minus), (F, 1)]]
    acting = [[(O, 1), (A, 1)], [(A, minus), (B, 1)], *on_blades, [(D, minus), (E, 1)]]
    motors = [0]
    angles = [0, 1, 2, 2, None]
    about = [7, 8, 9, 10, 11]
    result = []
    for k in range(5):
        sx = -a_sign * m[k] * accelerations[:, k, 0]
        sy = -a_sign * m[k] * accelerations[:, k, 1] - m[k] * g
        moment = np.zeros(points)
        centre = places[:, about[k]]
        for joint, sign in acting[k]:
            fx, fy = sign * forces[:, joint].T
            dx, dy = (places[:, joint] - centre).T
            sx = sx + fx
            sy = sy + fy
            moment = moment + dx * fy - dy * fx
        if k in motors:
            moment = moment + torque
        if k == 2 or k == 3:
            sx = sx + load_sign * loads[:, k - 2, 0]
            sy = sy + load_sign * loads[:, k - 2, 1]
        if angles[k] is not None:
            moment = moment - alpha_sign * I[k] * alpha[:, angles[k]]
        result.append(np.stack([sx, sy, moment], axis=1))
    return np.stack(result, axis=1)
"""

BODY_RESIDUALS = Student(
    RESIDUALS,
    {
        "A joint force acts on both bodies with the same sign": (
            ("load_sign, alpha_sign = 9.81, -1,", "load_sign, alpha_sign = 9.81, 1,"),
        ),
        "Every joint force has the opposite sign": (("sign * forces[:, joint].T", "-sign * forces[:, joint].T"),),
        "The weight is forgotten": (("- m[k] * g\n", "\n"),),
        "The weight is counted twice": (("- m[k] * g\n", "- 2 * m[k] * g\n"),),
        "The weight pulls upwards": (("- m[k] * g\n", "+ m[k] * g\n"),),
        "The loads are forgotten": (("if k == 2 or k == 3:", "if False:"),),
        "The loads have the wrong sign": (("-1, 1, 1, 1\n", "-1, 1, -1, 1\n"),),
        "m a has the wrong sign": (("-1, 1, 1, 1\n", "-1, -1, 1, 1\n"),),
        "I alpha has the wrong sign": (("-1, 1, 1, 1\n", "-1, 1, 1, -1\n"),),
        "I alpha is forgotten": (("-1, 1, 1, 1\n", "-1, 1, 1, 0\n"),),
        "The bar turns": (("2, 2, None]", "2, 2, 2]"),),
        "The torque is forgotten": (("motors = [0]", "motors = []"),),
        "The torque acts on every body": (("motors = [0]", "motors = range(5)"),),
        "The moments are about the joints": (("about = [7, 8, 9, 10, 11]", "about = [O, A, C, F, D]"),),
        "The arms lead from the joints to the centre of mass": (
            ("(places[:, joint] - centre).T", "(centre - places[:, joint]).T"),
        ),
        "x and y are exchanged in the moments": (("dx * fy - dy * fx", "dy * fy - dx * fx"),),
        "All residuals have the opposite sign": (
            ("np.stack([sx, sy, moment], axis=1)", "-np.stack([sx, sy, moment], axis=1)"),
        ),
        "The number of points is not looked at": (("if np.shape(array)[0] != points:", "if False:"),),
    },
)

PLANTED_MISTAKE = Student(
    POWER_RESIDUAL.right
    + RESIDUALS
    + """

def planted_mistake(motion, places, velocities, accelerations, loads, bars, torque, forces):
    watts = power_residual(motion, velocities, accelerations, loads, bars, torque)
    sums = body_residuals(motion, places, accelerations, loads, bars, torque, forces)
    least = 1e-3
    seen = bool(max(abs(watts)) > least * max(abs(torque * motion[1][:, 0])))
    scale_f, scale_m = np.max(abs(forces)), np.max(abs(torque))
    body = None
    for k in range(5):
        off_f = np.max(abs(sums[:, k, :2])) / scale_f
        off_m = np.max(abs(sums[:, k, 2])) / scale_m
        if off_f > least or off_m > least:
            body = k
    return seen, body
""",
    {
        "The bodies are looked at only where the power balance does not hold": (
            ("    for k in range(5):\n        off_f", "    for k in range(5) if seen else []:\n        off_f"),
        ),
        "Only the sums of the forces are looked at": (("if off_f > least or off_m > least:", "if off_f > least:"),),
        "The bodies are counted from one": (("body = k", "body = k + 1"),),
        "The body with the largest force is named": (
            (
                "    return seen, body\n",
                "    if body is not None:\n"
                "        largest = np.max(abs(forces), axis=(0, 2))\n"
                "        joints = ('OA', 'AB', 'BCD', 'EF', 'DE')\n"
                "        of_bodies = [max(largest['OABCDEF'.index(j)] for j in names) for names in joints]\n"
                "        body = of_bodies.index(max(of_bodies))\n"
                "    return seen, body\n",
            ),
        ),
        "The power balance is said to see every mistake": (("    return seen,", "    return body is not None,"),),
        "It is said whether the power balance holds, and not whether it sees the mistake": (
            ("    return seen,", "    return not seen,"),
        ),
        "The body comes first": (("    return seen, body\n", "    return body, seen\n"),),
        "Round-off is taken for a mistake": (
            ("    least = 1e-3\n", "    least = 0.0\n"),
            ("    body = None\n", "    largest = []\n"),
            ("            body = k\n", "            largest.append((max(off_f, off_m), k))\n"),
            ("    return seen, body\n", "    return seen, max(largest)[1]\n"),
        ),
    },
)

STUDENTS = {
    "steiner": STEINER,
    "centre_accelerations": CENTRE_ACCELERATIONS,
    "fifteen_equations": FIFTEEN_EQUATIONS,
    "torque_and_forces": TORQUE_AND_FORCES,
    "power_residual": POWER_RESIDUAL,
    "body_residuals": BODY_RESIDUALS,
    "planted_mistake": PLANTED_MISTAKE,
}
