"""Mistakes of exercise 06 as students write them; see `students`."""

from examination.student import Student

NINE_EQUATIONS = Student(
    """
def nine_equations(state, crank, lengths=(0.045, 0.075, 0.170)):
    r1y, r2, r3 = lengths
    r1, theta1, theta3, vr, omega1, omega3, ar, alpha1, alpha3 = state
    theta2, omega2, alpha2 = crank
    sin1, cos1 = np.sin(theta1), np.cos(theta1)
    sin2, cos2 = np.sin(theta2), np.cos(theta2)
    sin3, cos3 = np.sin(theta3), np.cos(theta3)

    F = np.zeros(9)
    F[0] = -r1 * cos1 + r2 * cos2 + r3 * cos3
    F[1] = r1 * sin1 - r2 * sin2 - r3 * sin3
    F[2] = r1 * sin1 - r1y

    F[3] = -vr * cos1 + r1 * omega1 * sin1 - r2 * omega2 * sin2 - r3 * omega3 * sin3
    F[4] = vr * sin1 + r1 * omega1 * cos1 - r2 * omega2 * cos2 - r3 * omega3 * cos3
    F[5] = vr * sin1 + r1 * omega1 * cos1

    coriolis = 2 * vr * omega1
    n1 = r1 * omega1**2
    n2 = r2 * omega2**2
    n3 = r3 * omega3**2
    t2 = r2 * alpha2
    F[6] = -ar * cos1 + coriolis * sin1 + r1 * alpha1 * sin1 + n1 * cos1
    F[6] += -t2 * sin2 - n2 * cos2 - r3 * alpha3 * sin3 - n3 * cos3
    F[7] = ar * sin1 + coriolis * cos1 + r1 * alpha1 * cos1 - n1 * sin1
    F[7] += -t2 * cos2 + n2 * sin2 - r3 * alpha3 * cos3 + n3 * sin3
    F[8] = ar * sin1 + coriolis * cos1 + r1 * alpha1 * cos1 - n1 * sin1
    return F
""",
    {
        "The Coriolis term is missing": (("2 * vr * omega1", "0"),),
        "The Coriolis term is there once": (("2 * vr * omega1", "vr * omega1"),),
        "The Coriolis term has the wrong sign": (("2 * vr * omega1", "-2 * vr * omega1"),),
        "The centripetal term of the crank is missing": (("r2 * omega2**2", "0"),),
        "The centripetal term of the coupler is missing": (("r3 * omega3**2", "0"),),
        "The centripetal term of r1 is missing": (("r1 * omega1**2", "0"),),
        "Every centripetal term is missing": (
            ("r1 * omega1**2", "0"),
            ("r2 * omega2**2", "0"),
            ("r3 * omega3**2", "0"),
        ),
        "The centripetal terms point outwards": (
            ("n1 = r1", "n1 = -r1"),
            ("n2 = r2", "n2 = -r2"),
            ("n3 = r3", "n3 = -r3"),
        ),
        "The angular acceleration of the crank is forgotten": (("t2 = r2 * alpha2", "t2 = 0"),),
        "The angular velocity of the crank is forgotten": (
            ("theta2, omega2, alpha2 = crank\n", "theta2, omega2, alpha2 = crank[0], 0.0, crank[2]\n"),
        ),
        "The crank does not move in the derivatives": (
            ("theta2, omega2, alpha2 = crank\n", "theta2, omega2, alpha2 = crank[0], 0.0, 0.0\n"),
        ),
        "The height of the guide is still there in the derivatives": (
            ("F[5] = vr * sin1 + r1 * omega1 * cos1", "F[5] = vr * sin1 + r1 * omega1 * cos1 - r1y"),
            ("    return F\n", "    F[8] -= r1y\n    return F\n"),
        ),
        "The coupler has the wrong sign in Fy": (
            ("- r2 * sin2 - r3 * sin3", "- r2 * sin2 + r3 * sin3"),
            ("- r2 * omega2 * cos2 - r3 * omega3 * cos3", "- r2 * omega2 * cos2 + r3 * omega3 * cos3"),
            ("- r3 * alpha3 * cos3 + n3 * sin3", "+ r3 * alpha3 * cos3 - n3 * sin3"),
        ),
        "Fx has the opposite sign": (("    return F\n", "    F[[0, 3, 6]] *= -1\n    return F\n"),),
        "The equations of each level are in the order Fc, Fx, Fy": (
            ("    return F\n", "    return F[[2, 0, 1, 5, 3, 4, 8, 6, 7]]\n"),
        ),
        "Each equation is followed by its derivatives": (
            ("    return F\n", "    return np.array([F[0], F[3], F[6], F[1], F[4], F[7], F[2], F[5], F[8]])\n"),
        ),
        "The acceleration equations come first, and the position equations last": (
            ("    return F\n", "    return np.concatenate((F[6:], F[3:6], F[:3]))\n"),
        ),
        "The unknowns are unpacked in the order r1, v_r, a_r, theta1 and so on": (
            (
                "r1, theta1, theta3, vr, omega1, omega3, ar, alpha1, alpha3 = state",
                "r1, vr, ar, theta1, omega1, alpha1, theta3, omega3, alpha3 = state",
            ),
        ),
        "The result is a matrix of three rows": (("    return F\n", "    return [F[:3], F[3:6], F[6:]]\n"),),
        "The angles are taken for degrees": (
            (
                "    sin1, cos1",
                "    theta1, theta2, theta3 = np.radians([theta1, theta2, theta3])\n    sin1, cos1",
            ),
        ),
        "The lengths are unpacked in the order r2, r3, r1y": (("r1y, r2, r3 = lengths", "r2, r3, r1y = lengths"),),
    },
)

BY_HAND = """
def nine_jacobian(state, crank, lengths=(0.045, 0.075, 0.170)):
    r1, theta1, theta3, vr, omega1, omega3, ar, alpha1, alpha3 = state
    _, _, r3 = lengths
    sin1, cos1 = np.sin(theta1), np.cos(theta1)
    sin3, cos3 = np.sin(theta3), np.cos(theta3)
    J = np.zeros((9, 9))
    for k in range(0, 9, 3):
        J[k, k:k + 3] = -cos1, r1 * sin1, -r3 * sin3
        J[k + 1, k:k + 3] = sin1, r1 * cos1, -r3 * cos3
        J[k + 2, k:k + 3] = sin1, r1 * cos1, 0

    J[3, 0:3] = omega1 * sin1, vr * sin1 + r1 * omega1 * cos1, -r3 * omega3 * cos3
    J[4, 0:3] = omega1 * cos1, vr * cos1 - r1 * omega1 * sin1, r3 * omega3 * sin3
    J[5, 0:3] = omega1 * cos1, vr * cos1 - r1 * omega1 * sin1, 0

    two = 2
    dc_by_v, dc_by_w = two * omega1, two * vr
    dn1_by_r, dn1_by_w = omega1**2, 2 * r1 * omega1
    dn3_by_w = 2 * r3 * omega3
    J[6, 3:6] = dc_by_v * sin1, dc_by_w * sin1 + dn1_by_w * cos1, -dn3_by_w * cos3
    J[7, 3:6] = dc_by_v * cos1, dc_by_w * cos1 - dn1_by_w * sin1, dn3_by_w * sin3
    J[8, 3:6] = dc_by_v * cos1, dc_by_w * cos1 - dn1_by_w * sin1, 0

    c, n1, n3 = two * vr * omega1, dn1_by_r * r1, dn3_by_w * omega3 / 2
    t1, t3 = r1 * alpha1, r3 * alpha3
    J[6, 0:3] = alpha1 * sin1 + dn1_by_r * cos1, ar * sin1 + (c + t1) * cos1 - n1 * sin1, -t3 * cos3 + n3 * sin3
    J[7, 0:3] = alpha1 * cos1 - dn1_by_r * sin1, ar * cos1 - (c + t1) * sin1 - n1 * cos1, t3 * sin3 + n3 * cos3
    J[8, 0:3] = alpha1 * cos1 - dn1_by_r * sin1, ar * cos1 - (c + t1) * sin1 - n1 * cos1, 0
    return J
"""

NINE_JACOBIAN = Student(
    BY_HAND,
    {
        "The Jacobian is transposed": (("    return J\n", "    return J.T\n"),),
        "Only the blocks in the diagonal are there": (
            ("    return J\n", "    J[3:, :3] = 0\n    J[6:, 3:6] = 0\n    return J\n"),
        ),
        "The accelerations are not differentiated by the positions": (
            ("    return J\n", "    J[6:9, 0:3] = 0\n    return J\n"),
        ),
        "The acceleration equations are differentiated by the accelerations alone": (
            ("    return J\n", "    J[6:, :6] = 0\n    return J\n"),
        ),
        "The block of accelerations by velocities is that of velocities by positions": (
            ("    return J\n", "    J[6:9, 3:6] = J[3:6, 0:3]\n    return J\n"),
        ),
        "The Coriolis term is missing in the derivatives": (("two = 2", "two = 0"),),
        "The Coriolis term is there once in the derivatives": (("two = 2", "two = 1"),),
        "The centripetal term of r1 is missing in the derivatives": (
            ("dn1_by_r, dn1_by_w = omega1**2, 2 * r1 * omega1", "dn1_by_r, dn1_by_w = 0, 0"),
        ),
        "The centripetal term of the coupler is missing in the derivatives": (
            ("dn3_by_w = 2 * r3 * omega3", "dn3_by_w = 0"),
        ),
        "Every sign is turned round": (("    return J\n", "    return -J\n"),),
        "The equations of each level are in the order Fc, Fx, Fy": (
            ("    return J\n", "    return J[[2, 0, 1, 5, 3, 4, 8, 6, 7]]\n"),
        ),
        "The rows of an equation and of its derivatives follow each other": (
            ("    return J\n", "    return J[[0, 3, 6, 1, 4, 7, 2, 5, 8], :]\n"),
        ),
        "The columns of an unknown and of its derivatives follow each other": (
            ("    return J\n", "    return J[:, [0, 3, 6, 1, 4, 7, 2, 5, 8]]\n"),
        ),
        "The columns of the accelerations come first, and those of the positions last": (
            ("    return J\n", "    return np.hstack((J[:, 6:9], J[:, 3:6], J[:, 0:3]))\n"),
        ),
        "The unknowns are unpacked in the order r1, v_r, a_r, theta1 and so on": (
            (
                "r1, theta1, theta3, vr, omega1, omega3, ar, alpha1, alpha3 = state",
                "r1, vr, ar, theta1, omega1, alpha1, theta3, omega3, alpha3 = state",
            ),
        ),
        "The length of the crank stands where that of the coupler belongs": (
            ("_, _, r3 = lengths", "_, r3, _ = lengths"),
        ),
        "The angles are taken for degrees": (
            ("    sin1, cos1", "    theta1, theta3 = np.radians(theta1), np.radians(theta3)\n    sin1, cos1"),
        ),
    },
)

ITERATE = """
class ConvergenceError(ArithmeticError):
    pass


def iterate(residual, jacobian, crank, seed, tol):
    start = np.array(seed, dtype=float)
    x = start
    count = 0
    while count < 40:
        J = np.array(jacobian(x, crank))
        F = np.array(residual(x, crank))
        try:
            d = np.linalg.solve(J, -F)
        except np.linalg.LinAlgError:
            raise ConvergenceError(f"singular matrix at {x}")
        x = x + d
        count += 1
        size = np.sqrt(np.sum(d**2))
        if size < tol:
            break
    else:
        raise ConvergenceError(f"no convergence, x = {x}")
    return x, count, size
"""

WRAPPED = {
    "The angles are brought into one turn, from 0 to 2 pi": "x[..., 1:3] = x[..., 1:3] % (2 * np.pi)",
    "The angles are brought into one turn, from -pi to pi": (
        "x[..., 1:3] = np.arctan2(np.sin(x[..., 1:3]), np.cos(x[..., 1:3]))"
    ),
    "The angles and their rates are returned in degrees": (
        "x[..., [1, 2, 4, 5, 7, 8]] = np.degrees(x[..., [1, 2, 4, 5, 7, 8]])"
    ),
    "The positions alone are returned": "x = x[..., :3]",
}
LAST_LINE = "    return x, iterations, error\n"
SLIPS = {name: ((LAST_LINE, f"    {line}\n{LAST_LINE}"),) for name, line in WRAPPED.items()}

SMALL = "        if size < tol:\n            break\n"
NEVER = '        raise ConvergenceError(f"no convergence, x = {x}")\n'

ONE_POINT = Student(
    ITERATE
    + """

def one_point(residual, jacobian, crank, seed, tol=1e-6):
    x, iterations, error = iterate(residual, jacobian, crank, seed, tol)
    return x, iterations, error
""",
    {
        "The step has the wrong sign": (("solve(J, -F)", "solve(J, F)"),),
        "The Jacobian is transposed": (("solve(J, -F)", "solve(J.T, -F)"),),
        "The Jacobian of the seed is used in every step": (("jacobian(x, crank)", "jacobian(start, crank)"),),
        "The blocks outside of the diagonal are left out of the Jacobian": (
            ("        F = np.array", "        J[3:, :3] = 0\n        J[6:, :6] = 0\n        F = np.array"),
        ),
        "A single step is taken": (("count < 40", "count < 1"), (NEVER, "        pass\n")),
        "It stops when the residual is small, and not when the step is": (
            (SMALL, "        if np.linalg.norm(residual(x, crank)) < tol:\n            break\n"),
        ),
        "The largest entry of the step is compared with tol, and not its 2-norm": (
            ("if size < tol", "if max(abs(d)) < tol"),
        ),
        "The step of the positions alone is compared with tol": (("if size < tol", "if np.linalg.norm(d[0:3]) < tol"),),
        "The last step is not taken": (
            ("        x = x + d\n", ""),
            (SMALL, f"{SMALL}        x = x + d\n"),
        ),
        "The iterations are counted from zero": (("return x, count, size", "return x, count - 1, size"),),
        "The norm of the residual is returned where that of the step is asked for": (
            ("return x, count, size", "return x, count, np.linalg.norm(F)"),
        ),
        **SLIPS,
    },
)

ALL_POINTS = Student(
    ITERATE
    + """

def all_points(residual, jacobian, crank, seed, tol=1e-6):
    n = crank.shape[1]
    x, iterations, error = np.zeros((n, 9)), np.zeros(n), np.zeros(n)
    guess = np.array(seed, dtype=float)
    total = 0
    for i in range(n):
        total = 0
        try:
            guess, count, size = iterate(residual, jacobian, crank[:, i], guess, tol)
        except ConvergenceError:
            raise ConvergenceError(f"the saw cannot close at index {i}")
        total += count
        x[i], iterations[i], error[i] = guess, total, size
    return x, iterations, error
""",
    {
        "Every point starts from the seed": (("crank[:, i], guess, tol", "crank[:, i], seed, tol"),),
        "One step is taken at each point": (("count < 40", "count < 1"), (NEVER, "        pass\n")),
        "The last point is missing": (("n = crank.shape[1]", "n = crank.shape[1] - 1"),),
        "The seed is returned as the first state, and all others are late by one": (
            (LAST_LINE, f"    x = np.concatenate(([seed], x[:-1]))\n{LAST_LINE}"),
        ),
        "Rows and columns are exchanged in the states": ((LAST_LINE, f"    x = x.T\n{LAST_LINE}"),),
        "The iterations are counted from zero": (("return x, count, size", "return x, count - 1, size"),),
        "The count of iterations is not set back between the points": (
            ("        total = 0\n        try", "        try"),
        ),
        "The errors are norms of the residual, and not of the step": (
            ("return x, count, size", "return x, count, np.linalg.norm(F)"),
        ),
        **SLIPS,
    },
)

STUDENTS = {
    "nine_equations": NINE_EQUATIONS,
    "nine_jacobian": NINE_JACOBIAN,
    "one_point": ONE_POINT,
    "all_points": ALL_POINTS,
}
