"""Mistakes of exercise 10 as students write them; see `students`."""

from examination.student import Student

DIRECT_SYSTEM = Student(
    """
def direct_system(position, velocity, torque, loads, lengths, bars):
    g = 9.81
    r0, r1, r2, r3, r4, r5, r6 = lengths
    (d1, m1, J1), (d2, m2, J2), (d3, m3, J3), (d4, m4, J4), (d5, m5, J5) = bars
    t1, t2, t3 = position
    w1, w2, w3 = velocity
    c1, c2, c3 = np.cos(t1), np.cos(t2), np.cos(t3)
    s1, s2, s3 = np.sin(t1), np.sin(t2), np.sin(t3)
    (f3x, f3y), (f4x, f4y) = loads
    M = torque
    q1, q2, q3 = w1**2, w2**2, w3**2
    p1, p2, p3 = w1**2, w2**2, w3**2
    L = r4
    back = -1
    own = [m1 * d1**2, m2 * d2**2, m3 * d3**2, m4 * d4**2]
    I1, I2, I3, I4 = J1 + own[0], J2 + own[1], J3 + own[2], J4 + own[3]
    W1, W2, W3, W4, W5 = [m * g for m in (m1, m2, m3, m4, m5)]
    T1, T2, T3, T4, T5 = W1, W2, W3, W4, W5
    n3x, n3y, n4x, n4y = f3x, f3y, f4x, f4y
    d = d5
    turning = 0.0
    carried = 1.0

    K = np.zeros((17, 17))
    k = np.zeros(17)
    al1, al2, al3, Ox, Oy, Ax, Ay, Bx, By, Cx, Cy, Dx, Dy, Ex, Ey, Fx, Fy = range(17)
    # crank
    K[0, [al1, Ox, Ax]] = m1 * d1 * s1, 1, 1
    k[0] = -m1 * d1 * c1 * q1
    K[1, [al1, Oy, Ay]] = -m1 * d1 * c1, 1, 1
    k[1] = W1 - m1 * d1 * s1 * q1
    K[2, [al1, Ax, Ay]] = -I1, -r1 * s1, r1 * c1
    k[2] = T1 * d1 * c1 - M
    # coupler
    K[3, [al1, al2, Ax, Bx]] = m2 * r1 * s1, m2 * d2 * s2, back, 1
    k[3] = -m2 * (r1 * c1 * q1 + d2 * c2 * q2)
    K[4, [al1, al2, Ay, By]] = -m2 * r1 * c1, -m2 * d2 * c2, back, 1
    k[4] = W2 - m2 * (r1 * s1 * q1 + d2 * s2 * q2)
    K[5, [al1, al2, Bx, By]] = -carried * m2 * d2 * r1 * (c1 * c2 + s1 * s2), -I2, -r2 * s2, r2 * c2
    k[5] = T2 * d2 * c2 - carried * m2 * d2 * r1 * (c2 * s1 - s2 * c1) * q1
    # first blade
    K[6, [al3, Bx, Cx, Dx]] = m3 * d3 * s3, back, 1, 1
    k[6] = -f3x - m3 * d3 * c3 * q3
    K[7, [al3, By, Cy, Dy]] = -m3 * d3 * c3, back, 1, 1
    k[7] = -f3y + W3 - m3 * d3 * s3 * q3
    K[8, [al3, Bx, By, Dx, Dy]] = -I3, -back * r3 * s3, back * r3 * c3, -r4 * s3, r4 * c3
    k[8] = T3 * d3 * c3 - d3 * (c3 * n3y - s3 * n3x)
    # second blade
    K[9, [al3, Ex, Fx]] = m4 * d4 * s3, back, 1
    k[9] = -f4x - m4 * d4 * c3 * q3
    K[10, [al3, Ey, Fy]] = -m4 * d4 * c3, back, 1
    k[10] = -f4y + W4 - m4 * d4 * s3 * q3
    K[11, [al3, Ex, Ey]] = -I4, -back * r4 * s3, back * r4 * c3
    k[11] = T4 * d4 * c3 - d4 * (c3 * n4y - s3 * n4x)
    # bar
    K[12, [al3, Dx, Ex]] = m5 * L * s3, back, 1
    k[12] = -m5 * L * c3 * q3
    K[13, [al3, Dy, Ey]] = -m5 * L * c3, back, 1
    k[13] = W5 - m5 * L * s3 * q3
    K[14, [al3, Ey]] = -m5 * d * L * c3 - turning, r5
    k[14] = d * (T5 - m5 * L * s3 * q3)
    # closure
    K[15, [al1, al2, al3]] = r1 * s1, r2 * s2, -r3 * s3
    k[15] = -(r1 * c1 * p1 + r2 * c2 * p2 - r3 * c3 * p3)
    K[16, [al1, al2, al3]] = r1 * c1, r2 * c2, -r3 * c3
    k[16] = r1 * s1 * p1 + r2 * s2 * p2 - r3 * s3 * p3
    return K, k
""",
    {
        "The matrix is transposed": (("return K, k", "return K.T, k"),),
        "The centripetal terms of the closure are missing": (("p1, p2, p3 = w1**2, w2**2, w3**2", "p1 = p2 = p3 = 0"),),
        "The centripetal terms of the closure have the wrong sign": (
            ("p1, p2, p3 = w1**2, w2**2, w3**2", "p1, p2, p3 = -(w1**2), -(w2**2), -(w3**2)"),
        ),
        "The centripetal terms of the bodies are missing": (("q1, q2, q3 = w1**2, w2**2, w3**2", "q1 = q2 = q3 = 0"),),
        "The centripetal terms of the bodies have the wrong sign": (
            ("q1, q2, q3 = w1**2, w2**2, w3**2", "q1, q2, q3 = -(w1**2), -(w2**2), -(w3**2)"),
        ),
        "All centripetal terms are missing": (("w1, w2, w3 = velocity", "w1, w2, w3 = 0, 0, 0"),),
        "All centripetal terms have the wrong sign": (
            ("q1, q2, q3 = w1**2, w2**2, w3**2", "q1, q2, q3 = -w1 * w1, -w2 * w2, -w3 * w3"),
            ("p1, p2, p3 = w1**2, w2**2, w3**2", "p1, p2, p3 = q1, q2, q3"),
        ),
        "The torque is missing": (("M = torque", "M = 0.0"),),
        "The torque has the wrong sign": (("M = torque", "M = -torque"),),
        "The weight is forgotten": (("g = 9.81", "g = 0.0"),),
        "The weight is doubled": (("g = 9.81", "g = 2 * 9.81"),),
        "The weight has the wrong sign": (("g = 9.81", "g = -9.81"),),
        "The moments of the weights are forgotten": (
            ("T1, T2, T3, T4, T5 = W1, W2, W3, W4, W5", "T1 = T2 = T3 = T4 = T5 = 0"),
        ),
        "The loads are forgotten": (("= loads", "= np.zeros((2, 2))"),),
        "The loads have the wrong sign": (("= loads", "= -loads"),),
        "The moments of the loads are forgotten": (
            ("n3x, n3y, n4x, n4y = f3x, f3y, f4x, f4y", "n3x = n3y = n4x = n4y = 0"),
        ),
        "The moments of inertia about the centres of mass stand where those about the joints belong": (
            ("own = [m1 * d1**2, m2 * d2**2, m3 * d3**2, m4 * d4**2]", "own = [0, 0, 0, 0]"),
        ),
        "The distance from the joint is in the moment of inertia twice": (
            ("own = [m1 * d1**2, m2 * d2**2, m3 * d3**2, m4 * d4**2]", "own = [2 * m * d**2 for d, m, _ in bars]"),
        ),
        "The moments of the coupler are taken as if A were fixed": (("carried = 1.0", "carried = 0.0"),),
        "The mass of the bar is at its end": (("    d = d5\n", "    d = r5\n"),),
        "The bar accelerates like B": (("L = r4", "L = r3"),),
        "The bar turns with the blades": (("turning = 0.0", "turning = J5"),),
        "A joint acts on both of its bodies with the same sign": (("back = -1", "back = 1"),),
        "The forces come before the accelerations": (("return K, k", "return np.hstack((K[:, 3:], K[:, :3])), k"),),
        "The two equations of the closure come first": (
            ("return K, k", "return np.vstack((K[15:], K[:15])), np.append(k[15:], k[:15])"),
        ),
        "The equations are grouped: all of x, all of y, all moments": (
            (
                "return K, k",
                "rows = [*range(0, 15, 3), *range(1, 15, 3), *range(2, 15, 3), 15, 16]\n    return K[rows], k[rows]",
            ),
        ),
        "Every equation has the opposite sign": (("return K, k", "return -K, -k"),),
        "The right side has the wrong sign": (("return K, k", "return K, -k"),),
        "The angles are taken for degrees": (("t1, t2, t3 = position", "t1, t2, t3 = np.radians(position)"),),
        "The two blades are exchanged": (("(d3, m3, J3), (d4, m4, J4)", "(d4, m4, J4), (d3, m3, J3)"),),
    },
)

DRIVEN_MOTION = Student(
    """
import math

def angles(theta1, lengths):
    r0, r1, r2, r3 = lengths[:4]
    ax, ay = r1 * math.cos(theta1), r1 * math.sin(theta1)
    distance = math.sqrt((r0 - ax) ** 2 + ay**2)
    bend = (r2**2 + distance**2 - r3**2) / (2 * r2 * distance)
    if bend > 1 or bend < -1:
        raise ArithmeticError(f"no position at {theta1}")
    theta2 = math.atan2(-ay, r0 - ax) + math.acos(bend)
    bx, by = ax + r2 * math.cos(theta2), ay + r2 * math.sin(theta2)
    return np.array([theta1, theta2, math.atan2(by, bx - r0)])

def driven_motion(acceleration, torque, start, t, lengths):
    if not np.all(np.isfinite(start)) or not np.all(np.isfinite(t)):
        raise ValueError(f"not finite: {start}, {t}")
    for i in range(1, len(t)):
        if not t[i] > t[i - 1]:
            raise ValueError(f"t goes from {t[i - 1]} to {t[i]}")
    theta, omega = start
    result = [(theta, omega)]
    first = angles(theta, lengths)
    instants = list(t)
    for i in range(len(t) - 1):
        h = instants[i + 1] - instants[i]
        now = instants[i]
        begun = angles(theta, lengths)
        old = (now, theta, omega)

        def rate(at, th, w):
            M = torque(at, th, w)
            return w, acceleration(angles(th, lengths), w, M)

        a1, b1 = rate(now, theta, omega)
        a2, b2 = rate(now + 0.5 * h, theta + 0.5 * h * a1, omega + 0.5 * h * b1)
        a3, b3 = rate(now + 0.5 * h, theta + 0.5 * h * a2, omega + 0.5 * h * b2)
        a4, b4 = rate(now + h, theta + h * a3, omega + h * b3)
        theta = theta + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        omega = omega + h / 6 * (b1 + 2 * b2 + 2 * b3 + b4)
        result.append((theta, omega))
    return np.array(result)
""",
    {
        "It is Euler's method": (
            ("h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)", "h * a1"),
            ("h / 6 * (b1 + 2 * b2 + 2 * b3 + b4)", "h * b1"),
        ),
        "The method is of second order": (
            ("h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)", "h * a2"),
            ("h / 6 * (b1 + 2 * b2 + 2 * b3 + b4)", "h * b2"),
        ),
        "A stage of Runge and Kutta's method begins in the wrong place": (
            ("theta + 0.5 * h * a2, omega + 0.5 * h * b2", "theta + 0.5 * h * a1, omega + 0.5 * h * b1"),
        ),
        "The slopes of Runge and Kutta's method have equal weights": (
            ("h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)", "h / 4 * (a1 + a2 + a3 + a4)"),
            ("h / 6 * (b1 + 2 * b2 + 2 * b3 + b4)", "h / 4 * (b1 + b2 + b3 + b4)"),
        ),
        "The torque is frozen from one instant to the next": (("M = torque(at, th, w)", "M = torque(*old)"),),
        "The torque is that of the start": (("M = torque(at, th, w)", "M = torque(t[0], *start)"),),
        "The time is counted from the first instant": (("torque(at, th, w)", "torque(at - t[0], th, w)"),),
        "The torque is forgotten": (("M = torque(at, th, w)", "M = 0.0"),),
        "The torque has the wrong sign": (("M = torque(at, th, w)", "M = -torque(at, th, w)"),),
        "The initial speed is lost": (("theta, omega = start\n", "theta, omega = start[0], 0.0\n"),),
        "The initial angle is lost": (("theta, omega = start\n", "theta, omega = 0.0, start[1]\n"),),
        "The start is taken for degrees": (("theta, omega = start\n", "theta, omega = np.radians(start)\n"),),
        "The initial speed is taken for revolutions per minute": (
            ("theta, omega = start\n", "theta, omega = start[0], start[1] * 2 * math.pi / 60\n"),
        ),
        "Angles and speeds are returned in degrees": (("return np.array(result)", "return np.degrees(result)"),),
        "Coupler and blades stay where they were at the start": (
            ("acceleration(angles(th, lengths), w, M)", "acceleration(np.array([th, first[1], first[2]]), w, M)"),
        ),
        "The loop is closed only once a step": (
            ("acceleration(angles(th, lengths), w, M)", "acceleration(begun, w, M)"),
        ),
        "The loop is closed on the other branch": (("+ math.acos(bend)", "- math.acos(bend)"),),
        "The instants are taken as evenly spaced": (
            ("instants = list(t)", "instants = [t[0] + k * (t[1] - t[0]) for k in range(len(t))]"),
        ),
        "The integrator keeps its default accuracy": (
            (
                "    for i in range(len(t) - 1):\n",
                "    from scipy.integrate import solve_ivp\n"
                "    f = lambda t, y: [y[1], acceleration(angles(y[0], lengths), y[1], torque(t, y[0], y[1]))]\n"
                "    return solve_ivp(f, [t[0], t[-1]], [theta, omega], t_eval=t).y.T\n"
                "    for i in range(len(t) - 1):\n",
            ),
        ),
        "Rows and columns are exchanged": (("return np.array(result)", "return np.array(list(zip(*result)))"),),
        "The speed comes before the angle": (
            ("result = [(theta, omega)]", "result = [(omega, theta)]"),
            ("result.append((theta, omega))", "result.append((omega, theta))"),
        ),
        "The start is missing": (("result = [(theta, omega)]", "result = []"),),
        "The last instant is missing": (("for i in range(len(t) - 1):", "for i in range(len(t) - 2):"),),
        "Where the loop cannot close, nan is returned": (
            ('raise ArithmeticError(f"no position at {theta1}")', "return np.full(3, np.nan)"),
        ),
        "Where the loop cannot close, the motion goes on": (
            ('raise ArithmeticError(f"no position at {theta1}")', "bend = np.sign(bend)"),
        ),
        "A start and instants that cannot be are not refused": (
            ('raise ValueError(f"not finite: {start}, {t}")', "pass"),
            ('raise ValueError(f"t goes from {t[i - 1]} to {t[i]}")', "pass"),
        ),
    },
)

ENERGY_DRIFT = Student(
    """
def energy_drift(t, position, velocity, torque, loads, lengths, bars):
    n = len(t)
    if any(len(x) != n for x in (position, velocity, torque, loads)):
        raise ValueError("not as many")
    t1, t2, t3 = [position[:, i] for i in range(3)]
    w1, w2, w3 = [velocity[:, i] for i in range(3)]
    r1, r3, r4 = lengths[1], lengths[3], lengths[4]
    d, m, J = bars[:, 0], bars[:, 1], bars[:, 2]
    g = 9.81
    carried = r1
    hung = r4
    vx = [0] * 5
    vy = [0] * 5
    vx[0], vy[0] = -d[0] * w1 * np.sin(t1), d[0] * w1 * np.cos(t1)
    vx[1] = -carried * w1 * np.sin(t1) - d[1] * w2 * np.sin(t2)
    vy[1] = carried * w1 * np.cos(t1) + d[1] * w2 * np.cos(t2)
    vx[2], vy[2] = -d[2] * w3 * np.sin(t3), d[2] * w3 * np.cos(t3)
    vx[3], vy[3] = -d[3] * w3 * np.sin(t3), d[3] * w3 * np.cos(t3)
    vx[4], vy[4] = -hung * w3 * np.sin(t3), hung * w3 * np.cos(t3)
    x = [d[0] * np.cos(t1), r1 * np.cos(t1) + d[1] * np.cos(t2), lengths[0] + d[2] * np.cos(t3)]
    x += [lengths[0] + lengths[5] + d[3] * np.cos(t3), lengths[0] + d[4] + r4 * np.cos(t3)]
    y = [d[0] * np.sin(t1), r1 * np.sin(t1) + d[1] * np.sin(t2)]
    y += [d[2] * np.sin(t3), d[3] * np.sin(t3), r4 * np.sin(t3)]
    spin = [w1, w2, w3, w3, 0 * w3]
    number = 5
    E = np.zeros(n)
    for i in range(number):
        E += 1 / 2 * m[i] * (vx[i] ** 2 + vy[i] ** 2)
        E += 1 / 2 * J[i] * spin[i] ** 2
        lift = m[i] * g * y[i]
        E += lift
    P_motor = torque * w1
    P_loads = np.zeros(n)
    for i in (2, 3):
        P_loads += loads[:, i - 2, 0] * vx[i] + loads[:, i - 2, 1] * vy[i]
    P = P_motor + P_loads
    W = np.zeros(n)
    for i in range(1, n):
        h = t[i] - t[i - 1]
        W[i] = W[i - 1] + h * (P[i] + P[i - 1]) / 2
    E0 = E[0]
    drift = E - E0 - W
    return drift
""",
    {
        "The energy at the start is not subtracted": (("E0 = E[0]", "E0 = 0"),),
        "The drift is relative": (("return drift", "return drift / E[0]"),),
        "The drift has no sign": (("return drift", "return abs(drift)"),),
        "The potential energy has the wrong sign": (("E += lift", "E -= lift"),),
        "The potential energy is forgotten": (("E += lift", "pass"),),
        "The potential energy is taken from x": (("g * y[i]", "g * x[i]"),),
        "The bar has no potential energy": (("r4 * np.sin(t3)]", "0]"),),
        "The bar is left out": (("number = 5", "number = 4"),),
        "The rotation is missing in the kinetic energy": (("        E += 1 / 2 * J[i] * spin[i] ** 2\n", ""),),
        "The translation is missing in the kinetic energy": (
            ("        E += 1 / 2 * m[i] * (vx[i] ** 2 + vy[i] ** 2)\n", ""),
        ),
        "The translation is counted twice in the kinetic energy": (
            ("1 / 2 * J[i] * spin", "1 / 2 * (J[i] + m[i] * d[i] ** 2) * spin"),
        ),
        "The kinetic energy has no factor of one half": (
            ("1 / 2 * m[i]", "m[i]"),
            ("1 / 2 * J[i]", "J[i]"),
        ),
        "The coupler moves as if A were fixed": (("carried = r1", "carried = 0"),),
        "The bar moves like B": (("hung = r4", "hung = r3"),),
        "The bar turns with the blades": (("0 * w3]", "w3]"),),
        "The work has the wrong sign": (("E - E0 - W", "E - E0 + W"),),
        "The work is forgotten": (("E - E0 - W", "E - E0"),),
        "The work of the torque is forgotten": (("P_motor = torque * w1", "P_motor = 0 * w1"),),
        "The work of the torque has the wrong sign": (("P_motor = torque * w1", "P_motor = -torque * w1"),),
        "The work of the loads is forgotten": (("P = P_motor + P_loads", "P = P_motor"),),
        "The work of the loads has the wrong sign": (("P = P_motor + P_loads", "P = P_motor - P_loads"),),
        "The power is summed up without trapezoids": (("h * (P[i] + P[i - 1]) / 2", "h * P[i]"),),
        "The instants are taken as evenly spaced": (("h = t[i] - t[i - 1]", "h = t[1] - t[0]"),),
        "The whole work is subtracted at every instant": (("E - E0 - W", "E - E0 - W[-1]"),),
        "The power is subtracted, and not the work": (("E - E0 - W", "E - E0 - P"),),
        "The angles are taken for degrees": (
            ("t1, t2, t3 = [position[:, i]", "t1, t2, t3 = [np.radians(position[:, i])"),
        ),
        "Arrays of unequal length are paired by force": (
            (
                "    if any(len(x) != n for x in (position, velocity, torque, loads)):\n"
                '        raise ValueError("not as many")\n',
                "    n = min(map(len, (t, position, velocity, torque, loads)))\n"
                "    t, position, velocity = t[:n], position[:n], velocity[:n]\n"
                "    torque, loads = torque[:n], loads[:n]\n",
            ),
        ),
    },
)

SMOOTH_FRICTION = Student(
    """
def smooth_friction(velocity, size, v0):
    if v0 <= 0 or size < 0:
        raise ValueError(f"v0 = {v0}, size = {size}")
    velocity = np.asarray(velocity, float)
    v = np.hypot(velocity[..., 0], velocity[..., 1])
    s = v / v0
    tiny = v == 0
    divisor = np.where(tiny, 1.0, v)
    fading = np.tanh(s)
    direction = velocity / divisor[..., np.newaxis]
    force = -size * direction * fading[..., np.newaxis]
    return force
""",
    {
        "The friction is along the motion": (("force = -size", "force = size"),),
        "The friction is taken component by component": (("return force", "return -size * np.tanh(velocity / v0)"),),
        "It is source B's formula, as printed in our copy": (
            ("return force", "return size * (-np.sign(velocity)) - velocity / divisor[..., np.newaxis]"),
        ),
        "The friction does not fade near rest": (("fading = np.tanh(s)", "fading = 0 * s + 1"),),
        "It fades in a straight line": (("np.tanh(s)", "np.clip(s, 0, 1)"),),
        "It fades by another law": (("np.tanh(s)", "s / np.sqrt(s**2 + 1)"),),
        "It grows with the speed": (("fading = np.tanh(s)", "fading = s"),),
        "The speed is multiplied by the width, and not divided": (("s = v / v0", "s = v * v0"),),
        "The size of the friction is missing": (("force = -size * direction", "force = -direction"),),
        "The width is missing": (("np.tanh(s)", "np.tanh(v)"),),
        "One norm is taken over all points": (
            ("v = np.hypot(velocity[..., 0], velocity[..., 1])", "v = np.linalg.norm(velocity) + 0 * velocity[..., 0]"),
        ),
        "The length of the velocity is the sum of its components": (
            ("np.hypot(velocity[..., 0], velocity[..., 1])", "np.abs(velocity[..., 0]) + np.abs(velocity[..., 1])"),
        ),
        "Only its size is returned": (("return force", "return size * fading"),),
        "At rest it is not a number": (("np.where(tiny, 1.0, v)", "v"),),
        "A size and a width that cannot be are not refused": (
            ('        raise ValueError(f"v0 = {v0}, size = {size}")\n', "        pass\n"),
        ),
    },
)

STUDENTS = {
    "direct_system": DIRECT_SYSTEM,
    "driven_motion": DRIVEN_MOTION,
    "energy_drift": ENERGY_DRIFT,
    "smooth_friction": SMOOTH_FRICTION,
}
