"""Mistakes of exercise 11 as students write them; see `students`."""

from examination.student import Student

CYLINDER_ANGLES = Student(
    """
def cylinder_angles(a, lengths):
    o2, o4, b, l = lengths
    for length in lengths:
        if length <= 0:
            raise ValueError(f"{length} m is no length")
    result = []
    d = math.sqrt(o2**2 + o4**2)
    alpha = math.atan(o4 / o2)
    side2, side4 = 1, 1
    sign = 1
    for stroke in a:
        s = stroke + l
        c4 = sign * (d * d + b * b - s * s) / (2 * d * b)
        c2 = sign * (d * d + s * s - b * b) / (2 * d * s)
        if abs(c4) > 1:
            raise ValueError(f"cannot close at a = {stroke}")
        phi, psi = math.acos(c4), math.acos(c2)
        th2 = math.pi - alpha - side2 * psi
        th4 = side4 * phi - alpha
        result.append([th2, th4])
    return np.array(result)
""",
    {
        "It is the other branch: A lies on the left": (("side2, side4 = 1, 1", "side2, side4 = -1, -1"),),
        "theta2 is that of the other branch": (("side2, side4 = 1, 1", "side2, side4 = -1, 1"),),
        "theta4 is that of the other branch": (("side2, side4 = 1, 1", "side2, side4 = 1, -1"),),
        "The stroke is taken for the length O2-A": (("s = stroke + l", "s = stroke"),),
        "The direction of O2-O4 is forgotten": (("alpha = math.atan(o4 / o2)", "alpha = 0"),),
        "The direction of O2-O4 is measured from the vertical": (("math.atan(o4 / o2)", "math.atan(o2 / o4)"),),
        "The direction of O2-O4 has the wrong sign": (("math.atan(o4 / o2)", "-math.atan(o4 / o2)"),),
        "The angles of the triangle at O2 and O4 are exchanged": (("phi, psi = math", "psi, phi = math"),),
        "The cosines have the wrong sign": (("sign = 1", "sign = -1"),),
        "The arc sine is taken of a cosine": (("math.acos(c4), math.acos(c2)", "math.asin(c4), math.asin(c2)"),),
        "theta2 points from A to O2": (("th2 = math.pi - alpha", "th2 = -alpha"),),
        "theta4 points from A to O4": (("th4 = side4 * phi - alpha", "th4 = side4 * phi - alpha + math.pi"),),
        "The angles are returned in degrees": (("np.array(result)", "np.degrees(result)"),),
        "theta4 comes first": (("[th2, th4]", "[th4, th2]"),),
        "Rows and columns are exchanged": (("np.array(result)", "np.array(result).T"),),
        "A triangle that cannot close gets angles": (
            ("abs(c4) > 1:", "False:"),
            ("= math.acos(c4), math.acos(c2)", "= np.arccos(c4), np.arccos(c2)"),
        ),
        "A length that is not positive gets angles": (("if length <= 0:", "if False:"),),
    },
)

CYLINDER_RATIOS = Student(
    """
def cylinder_ratios(a, angles, lengths):
    b, l = lengths[2], lengths[3]
    k, h = [], []
    for stroke, (th2, th4) in zip(a, angles):
        D = th2 - th4
        s = stroke + l
        S, C = math.sin(D), math.cos(D)
        if abs(S) < 1e-6:
            raise ValueError(f"flat at {stroke}")
        # the closure once: 1 along the cylinder, and nothing across it
        k4 = 1 / (b * S)
        k2 = C / (s * S)
        # and twice
        coriolis = 2 * k2
        n2, n4 = s * k2**2, b * k4**2
        h4 = (n4 * C - n2) / (b * S)
        h2 = (b * h4 * C + n4 * S - coriolis) / s
        k.append([k2, k4])
        h.append([h2, h4])
    k, h = np.array(k), np.array(h)
    return np.array([k, h])
""",
    {
        "The velocity is projected, and not divided by sin D": (
            ("k4 = 1 / (b * S)", "k4 = S / b"),
            ("k2 = C / (s * S)", "k2 = S * C / s"),
            ("h4 = (n4 * C - n2) / (b * S)", "h4 = C * (k2 - k4) / b"),
            ("h2 = (b * h4 * C + n4 * S - coriolis) / s", "h2 = math.cos(2 * D) * (k2 - k4) / s - S * C / s**2"),
        ),
        "The velocity is projected, and h2 has cos D where the derivative of sin 2D / 2 has cos 2D": (
            ("k4 = 1 / (b * S)", "k4 = S / b"),
            ("k2 = C / (s * S)", "k2 = S * C / s"),
            ("h4 = (n4 * C - n2) / (b * S)", "h4 = C * (k2 - k4) / b"),
            ("h2 = (b * h4 * C + n4 * S - coriolis) / s", "h2 = C * (k2 - k4) / s - S * C / s**2"),
        ),
        "The Coriolis term is missing, or 1/s is differentiated with the wrong sign": (
            ("coriolis = 2 * k2", "coriolis = 0"),
        ),
        "The Coriolis term is half of what it should be, or the change of s is forgotten": (
            ("coriolis = 2 * k2", "coriolis = k2"),
        ),
        "The Coriolis term has the wrong sign": (("coriolis = 2 * k2", "coriolis = -2 * k2"),),
        "Both centripetal terms are missing": (("n2, n4 = s * k2**2, b * k4**2", "n2, n4 = 0, 0"),),
        "The centripetal term of the cylinder is missing": (("n2, n4 = s * k2**2, b", "n2, n4 = 0, b"),),
        "The centripetal term of the rocker is missing, or D changes with theta2 alone": (
            ("n2, n4 = s * k2**2, b * k4**2", "n2, n4 = s * k2**2, 0"),
        ),
        "The centripetal terms have the wrong sign": (("n2, n4 = s * k2**2, b", "n2, n4 = -s * k2**2, -b"),),
        "D is taken for constant in h": (
            ("h4 = (n4 * C - n2) / (b * S)", "h4 = 0"),
            ("h2 = (b * h4 * C + n4 * S - coriolis) / s", "h2 = -C / (s**2 * S)"),
        ),
        "D changes with theta4 alone": (
            ("h4 = (n4 * C - n2) / (b * S)", "h4 = C * k4 / (b * S**2)"),
            ("h2 = (b * h4 * C + n4 * S - coriolis) / s", "h2 = k4 / (s * S**2) - k2 / s"),
        ),
        "The change of D has the wrong sign": (
            ("h4 = (n4 * C - n2) / (b * S)", "h4 = C * (k2 - k4) / (b * S**2)"),
            ("h2 = (b * h4 * C + n4 * S - coriolis) / s", "h2 = (k2 - k4) / (s * S**2) - k2 / s"),
        ),
        "The changes of the two angles are added": (
            ("h4 = (n4 * C - n2) / (b * S)", "h4 = -C * (k2 + k4) / (b * S**2)"),
            ("h2 = (b * h4 * C + n4 * S - coriolis) / s", "h2 = -(k2 + k4) / (s * S**2) - k2 / s"),
        ),
        "D has the wrong sign": (
            ("D = th2 - th4", "D = th4 - th2"),
            ("h4 = (n4 * C - n2) / (b * S)", "h4 = C * (k4 - k2) / (b * S**2)"),
            ("h2 = (b * h4 * C + n4 * S - coriolis) / s", "h2 = (k4 - k2) / (s * S**2) - k2 / s"),
        ),
        "The stroke is taken for the length O2-A": (("s = stroke + l", "s = stroke"),),
        "Sine and cosine of D are exchanged": (
            ("S, C = math.sin(D), math.cos(D)", "S, C = math.cos(D), math.sin(D)"),
            ("abs(S) < 1e-6", "abs(C) < 1e-6"),
        ),
        "The lengths b and s are exchanged": (("s = stroke + l", "b, s = stroke + l, lengths[2]"),),
        "The angles are taken for degrees": (
            ("S, C = math.sin(D)", "flat, D = abs(math.sin(D)), math.radians(D)\n        S, C = math.sin(D)"),
            ("abs(S) < 1e-6", "flat < 1e-6"),
        ),
        "theta4 comes first": (("return np.array([k, h])", "return np.array([k[:, ::-1], h[:, ::-1]])"),),
        "The ratio h comes first, and k second": (("return np.array([k, h])", "return np.array([h, k])"),),
        "The angles come before the points": (("return np.array([k, h])", "return np.array([k.T, h.T])"),),
        "A flat triangle gets ratios": (("abs(S) < 1e-6", "S is None"),),
    },
)

VIRTUAL_POWER = Student(
    """
def virtual_power(stroke, angles, ratios, lengths, bodies):
    g2, g3, g4 = bodies[:, 0]
    m2, m3, m4 = bodies[:, 1]
    for m in (m2, m3, m4):
        if m <= 0:
            raise ValueError(f"mass {m}")
    b, l = lengths[2], lengths[3]
    long2, long3, long4 = 2 * g2, l, 2 * g4
    part = 12
    I2, I3, I4 = m2 * long2**2 / part, m3 * long3**2 / part, m4 * long4**2 / part
    Q = []
    g = 9.80665
    side = 1
    for i in range(len(angles)):
        a, v, acc = stroke[:, i]
        th2, th4 = angles[i]
        k2, k4 = ratios[0, i]
        h2, h4 = ratios[1, i]
        w2, w4 = k2 * v, k4 * v
        eps2 = k2 * acc + h2 * v**2
        eps4 = k4 * acc + h4 * v**2
        c2, s2, c4, s4 = math.cos(th2), math.sin(th2), math.cos(th4), math.sin(th4)
        r = a + g3
        slide, slide_acc = 1, acc
        coriolis = 2 * w2 * v
        inward2, inward4 = w2**2, w4**2
        # velocities of G2, G3, G4 for one metre a second
        u2 = (-g2 * k2 * s2, g2 * k2 * c2)
        u3 = (slide * c2 - r * k2 * s2, slide * s2 + r * k2 * c2)
        u4 = (-g4 * k4 * s4, g4 * k4 * c4)
        a2 = (-g2 * eps2 * s2 - g2 * inward2 * c2, g2 * eps2 * c2 - g2 * inward2 * s2)
        along, across = slide_acc - r * inward2, r * eps2 + coriolis
        a3 = (along * c2 - across * s2, along * s2 + across * c2)
        a4 = (-g4 * eps4 * s4 - g4 * inward4 * c4, g4 * eps4 * c4 - g4 * inward4 * s4)
        total = 0
        inertial, turning = 1, 1
        for m, u, acceleration in ((m2, u2, a2), (m3, u3, a3), (m4, u4, a4)):
            total += m * (inertial * acceleration[0] * u[0] + (inertial * acceleration[1] + g) * u[1])
        more2, more3, more4 = 0, 0, 0
        total += turning * ((I2 + more2 + I3 + more3) * eps2 * k2 + (I4 + more4) * eps4 * k4)
        Q.append(side * total)
    return np.array(Q)
""",
    {
        "The power of the motion is divided by its velocity": (("Q.append(side * total)", "Q.append(total * v / v)"),),
        "The power is returned, and not the force": (("Q.append(side * total)", "Q.append(total * v)"),),
        "The weight is forgotten": (("g = 9.80665", "g = 0"),),
        "The weight is counted twice": (("g = 9.80665", "g = 2 * 9.80665"),),
        "The weight has the wrong sign": (("g = 9.80665", "g = -9.80665"),),
        "The term m a has the wrong sign": (("inertial, turning = 1, 1", "inertial, turning = -1, 1"),),
        "The bodies have no moments of inertia": (("inertial, turning = 1, 1", "inertial, turning = 1, 0"),),
        "The term I eps has the wrong sign": (("inertial, turning = 1, 1", "inertial, turning = 1, -1"),),
        "The rocker's moment of inertia has the mass of the barrel": (("m4 * long4**2", "m2 * long4**2"),),
        "The moments of inertia are about the ends of the bars": (("part = 12", "part = 3"),),
        "The moments of inertia are about O2 and O4": (
            ("more2, more3, more4 = 0, 0, 0", "more2, more3, more4 = m2 * g2**2, m3 * r**2, m4 * g4**2"),
        ),
        "Barrel and rocker are half as long in their moments of inertia": (
            ("long2, long3, long4 = 2 * g2, l, 2 * g4", "long2, long3, long4 = g2, l, g4"),
        ),
        "The rod is 2 g3 long in its moment of inertia": (
            ("long2, long3, long4 = 2 * g2, l, 2", "long2, long3, long4 = 2 * g2, 2 * g3, 2"),
        ),
        "The Coriolis acceleration is missing": (("coriolis = 2 * w2 * v", "coriolis = 0"),),
        "The Coriolis acceleration is half of what it should be": (("coriolis = 2 * w2 * v", "coriolis = w2 * v"),),
        "The Coriolis acceleration has the wrong sign": (("coriolis = 2 * w2 * v", "coriolis = -2 * w2 * v"),),
        "The centripetal accelerations are missing": (("inward2, inward4 = w2**2, w4**2", "inward2 = inward4 = 0"),),
        "The centripetal accelerations point outwards": (
            ("inward2, inward4 = w2**2, w4**2", "inward2, inward4 = -(w2**2), -(w4**2)"),
        ),
        "The rod does not slide: its centre of mass only turns about O2": (
            ("slide, slide_acc = 1, acc", "slide, slide_acc = 0, 0"),
            ("coriolis = 2 * w2 * v", "coriolis = 0"),
        ),
        "The sliding is missing from the velocity of the rod": (("slide, slide_acc = 1,", "slide, slide_acc = 0,"),),
        "The acceleration of the stroke is missing from that of the rod": (("= 1, acc", "= 1, 0"),),
        "The length O2-A stands where the stroke belongs": (("r = a + g3", "r = a + l + g3"),),
        "The centre of mass of the rod stays at g3 from O2": (("r = a + g3", "r = g3"),),
        "The ratio h is forgotten in the angular accelerations": (
            ("+ h2 * v**2", ""),
            ("+ h4 * v**2", ""),
        ),
        "The velocity is not squared beside h": (
            ("h2 * v**2", "h2 * v"),
            ("h4 * v**2", "h4 * v"),
        ),
        "The ratio k stands where h belongs": (("h2, h4 = ratios[1, i]", "h2, h4 = ratios[0, i]"),),
        "Sine and cosine are exchanged": (("c2, s2, c4, s4 = math.cos(th2),", "s2, c2, s4, c4 = math.cos(th2),"),),
        "The angles are taken for degrees": (("th2, th4 = angles[i]", "th2, th4 = np.radians(angles[i])"),),
        "Cylinder and rocker exchange their ratios": (
            ("k2, k4 = ratios[0, i]", "k4, k2 = ratios[0, i]"),
            ("h2, h4 = ratios[1, i]", "h4, h2 = ratios[1, i]"),
        ),
        "The force has the wrong sign": (("side = 1", "side = -1"),),
        "A mass that is not positive gets a force": (("if m <= 0:", "if False:"),),
    },
)

LAGRANGE_TERMS = Student(
    """
def lagrange_terms(stroke, angles, ratios, lengths, bodies):
    a, v, acc = stroke
    l = lengths[3]
    for i in range(len(a)):
        if np.isnan(angles[i]).any():
            raise ValueError(f"nan at a = {a[i]}")
    g2, g3, g4 = bodies[:, 0]
    m2, m3, m4 = bodies[:, 1]
    k2, k4 = ratios[0, :, 0], ratios[0, :, 1]
    h2, h4 = ratios[1, :, 0], ratios[1, :, 1]
    th2, th4 = angles[:, 0], angles[:, 1]
    th2, th4 = 1 * th2, 1 * th4
    G, half = 9.80665, 0.5
    r = a + g3
    dr = 1
    slide, rise = 1, 1
    IO2 = m2 * g2**2 / 3 + m2 * g2**2
    IO4 = m4 * g4**2 / 3 + m4 * g4**2
    IG3 = m3 * l**2 / 12
    turning = m3 * r**2
    # T = 1/2 M v^2
    K2, K4 = k2**2, k4**2
    M = IO2 * K2 + (IG3 + turning) * K2 + slide * m3 + IO4 * K4
    dM = 2 * IO2 * k2 * h2 + 2 * (IG3 + turning) * k2 * h2 + 2 * dr * m3 * r * k2**2 + 2 * IO4 * k4 * h4
    D, s = angles[:, 0] - angles[:, 1], a + l
    by_turning = k2
    cos2, sin2, cos4 = np.cos(th2), np.sin(th2), np.cos(th4)
    dV = G * (m2 * g2 * cos2 * k2 + m3 * (rise * sin2 + r * cos2 * by_turning) + m4 * g4 * cos4 * k4)
    inertia = 2 * half * M * acc
    change = 2 * half * dM * v**2
    momentum = inertia + change
    by_stroke = half * dM * v**2
    return np.array([momentum, by_stroke, dV])
""",
    {
        "In d/dt(dT/dv) half of the term with v^2 is missing": (
            ("momentum = inertia + change", "momentum = inertia + change / 2"),
        ),
        "In d/dt(dT/dv) the change of the inertia is forgotten": (
            ("momentum = inertia + change", "momentum = inertia"),
        ),
        "The term dT/da is left out": (("by_stroke = half * dM * v**2", "by_stroke = 0 * v"),),
        "The term dT/da is twice too large": (("by_stroke = half * dM", "by_stroke = 2 * half * dM"),),
        "The term dT/da has the wrong sign": (("by_stroke = half * dM", "by_stroke = -half * dM"),),
        "T has lost its half": (("half = 9.80665, 0.5", "half = 9.80665, 1.0"),),
        "The first two terms are exchanged": (("[momentum, by_stroke, dV]", "[by_stroke, momentum, dV]"),),
        "The potential energy comes first": (("[momentum, by_stroke, dV]", "[dV, momentum, by_stroke]"),),
        "The force is returned, and not its three terms": (
            ("return np.array([momentum, by_stroke, dV])", "return momentum - by_stroke + dV"),
        ),
        "Rows and columns are exchanged": (
            ("np.array([momentum, by_stroke, dV])", "np.column_stack([momentum, by_stroke, dV])"),
        ),
        "The weight is forgotten": (("G, half = 9.80665,", "G, half = 0,"),),
        "The weight is counted twice": (("G, half = 9.80665,", "G, half = 2 * 9.80665,"),),
        "The weight has the wrong sign": (("G, half = 9.80665,", "G, half = -9.80665,"),),
        "The gravity term of the rod has sin^2 D and cos^2 D where the ratio of the cylinder belongs": (
            ("by_turning = k2", "by_turning = (np.cos(D)**2 - np.sin(D)**2) / s"),
        ),
        "The rod is not lifted by its sliding": (("slide, rise = 1, 1", "slide, rise = 1, 0"),),
        "The sliding is missing from the kinetic energy of the rod": (("slide, rise = 1, 1", "slide, rise = 0, 1"),),
        "The arm of the rod is taken for constant in the slope of the inertia": (("dr = 1", "dr = 0"),),
        "The rod does not slide: its centre of mass stays where it is on the cylinder": (
            ("slide, rise = 1, 1", "slide, rise = 0, 0"),
            ("dr = 1", "dr = 0"),
        ),
        "The length O2-A stands where the stroke belongs": (("r = a + g3", "r = a + l + g3"),),
        "The centre of mass of the rod stays at g3 from O2": (("r = a + g3", "r = g3 + 0 * a"),),
        "Barrel and rocker have their moments of inertia about the centres of mass": (
            ("IO2 = m2 * g2**2 / 3 + m2 * g2**2", "IO2 = m2 * g2**2 / 3"),
            ("IO4 = m4 * g4**2 / 3 + m4 * g4**2", "IO4 = m4 * g4**2 / 3"),
        ),
        "Steiner's term is counted twice": (
            ("IO2 = m2 * g2**2 / 3 + m2 * g2**2", "IO2 = 4 * m2 * g2**2 / 3 + m2 * g2**2"),
            ("IO4 = m4 * g4**2 / 3 + m4 * g4**2", "IO4 = 4 * m4 * g4**2 / 3 + m4 * g4**2"),
        ),
        "The rod has its moment of inertia about its end": (("m3 * l**2 / 12", "m3 * l**2 / 3"),),
        "The rod has no arm in its kinetic energy": (
            ("turning = m3 * r**2", "turning = 0"),
            ("dr = 1", "dr = 0"),
        ),
        "The rocker's moment of inertia has the mass of the barrel": (
            ("IO4 = m4 * g4**2 / 3", "IO4 = m2 * g4**2 / 3"),
        ),
        "The ratios are not squared in the inertia": (("K2, K4 = k2**2, k4**2", "K2, K4 = k2, k4"),),
        "Sine and cosine are exchanged in the potential energy": (
            ("np.cos(th2), np.sin(th2), np.cos(th4)", "np.sin(th2), np.cos(th2), np.sin(th4)"),
        ),
        "The angles are taken for degrees": (("1 * th2, 1 * th4", "np.radians(th2), np.radians(th4)"),),
        "nan goes through": (("if np.isnan(angles[i]).any():", "if False:"),),
    },
)

WRONG_TERM = Student(
    """
def wrong_term(t, stroke, kinetic, potential, terms):
    TERMS = ("d/dt dT/dv", "dT/da", "dV/da")
    BODIES = ("barrel", "rod", "rocker")
    v = stroke[1]
    moving = abs(v) > 0.2 * abs(v).max()
    h = t[1] - t[0]

    def slope(x):
        return (np.roll(x, -1) - np.roll(x, 1)) / (2 * h)

    worst, name, allowed = 0, None, 0.1
    for body in range(3):
        first, second, third = terms[:, body]
        momentum = np.where(v == 0, 0, 2 * kinetic[body] / np.where(v == 0, 1, v))
        # p v = 2 T, differentiated
        rate = (2 * slope(kinetic[body]) - momentum * stroke[2]) / np.where(v == 0, 1, v)
        loss = slope(kinetic[body]) / np.where(v == 0, 1, v)
        weight = slope(potential[body]) / np.where(v == 0, 1, v)
        looked_at = ((0, first, rate), (1, second, rate - loss), (2, third, weight))
        for term, got, expected in looked_at:
            off = abs(got - expected)[moving].max() / abs(got).max()
            if off > worst:
                worst, name = off, (term, body)
    if worst > allowed:
        term, body = name
        return TERMS[term], BODIES[body]
    return None
""",
    {
        "Whichever kinetic term is wrong, d/dt dT/dv is named": (
            ("        return TERMS[term], BODIES[body]", "        return TERMS[2 * (term == 2)], BODIES[body]"),
        ),
        "Whichever kinetic term is wrong, dT/da is named": (
            ("        return TERMS[term], BODIES[body]", "        return TERMS[1 + (term == 2)], BODIES[body]"),
        ),
        "The two kinetic terms are exchanged": (
            ("(0, first, rate), (1, second, rate - loss)", "(1, first, rate), (0, second, rate - loss)"),
        ),
        "The kinetic terms are not looked at": (
            ("looked_at = ((0, first, rate), (1, second, rate - loss), (2,", "looked_at = ((2,"),
            ("third, weight))", "third, weight),)"),
        ),
        "The largest term is named": (
            ("off = abs(got - expected)[moving].max() / abs(got).max()", "off = abs(got).max()"),
            ("allowed = 0, None, 0.1", "allowed = 0, None, 0"),
        ),
        "The body comes first": (("return TERMS[term], BODIES[body]", "return BODIES[body], TERMS[term]"),),
        "Numbers are returned, and not names": (("return TERMS[term], BODIES[body]", "return term, body"),),
        "A wrong weight is not seen": ((", (2, third, weight))", ")"),),
        "The errors of differences are taken for a mistake": (("allowed = 0, None, 0.1", "allowed = 0, None, 1e-9"),),
    },
)

STUDENTS = {
    "cylinder_angles": CYLINDER_ANGLES,
    "cylinder_ratios": CYLINDER_RATIOS,
    "virtual_power": VIRTUAL_POWER,
    "lagrange_terms": LAGRANGE_TERMS,
    "wrong_term": WRONG_TERM,
}
