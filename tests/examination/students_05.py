"""Mistakes of exercise 05 as students write them; see `students`."""

from examination.student import Student

ITERATE = """
class ConvergenceError(ArithmeticError):
    pass


def iterate(residual, jacobian, theta2, start, tol):
    q = start
    for _ in range(50):
        matrix = np.array(jacobian(q, theta2), dtype=float)
        gap = np.array(residual(q, theta2), dtype=float)
        try:
            step = np.linalg.solve(matrix, -gap)
        except np.linalg.LinAlgError:
            raise ConvergenceError(f"the Jacobian is singular at q = {q}")
        if not np.all(np.isfinite(step)):
            raise ConvergenceError(f"the step is not finite at q = {q}")
        q = q + step
        if np.linalg.norm(step) < tol:
            break
    else:
        raise ConvergenceError(f"no position found at theta2 = {theta2}")
    return q
"""

SAW_POSITION = Student(
    ITERATE
    + """

def saw_position(residual, jacobian, theta2, seed, tol=1e-6):
    start = np.array(seed, dtype=float)
    r1, theta1, theta3 = iterate(residual, jacobian, theta2, start, tol)
    return np.array([r1, theta1, theta3])
""",
    {
        "The step has the wrong sign": (("-gap", "gap"),),
        "The Jacobian is transposed": (("solve(matrix,", "solve(matrix.T,"),),
        "The Jacobian of the seed is used in every step": (("jacobian(q, theta2)", "jacobian(start, theta2)"),),
        "A single step is taken": (
            ("range(50)", "range(1)"),
            ('        raise ConvergenceError(f"no position found at theta2 = {theta2}")\n', "        pass\n"),
        ),
        "It stops when the residual is small, and not when the step is": (
            ("        try:\n", "        if np.linalg.norm(gap) < tol:\n            break\n        try:\n"),
            (
                "        q = q + step\n        if np.linalg.norm(step) < tol:\n            break\n",
                "        q = q + step\n",
            ),
        ),
        "The last step is not taken": (
            (
                "        q = q + step\n        if np.linalg.norm(step) < tol:\n            break\n",
                "        if np.linalg.norm(step) < tol:\n            break\n        q = q + step\n",
            ),
        ),
        "The crank angle is taken for degrees": (
            ("    start = np.array(seed", "    theta2 = np.radians(theta2)\n    start = np.array(seed"),
        ),
        "The angles are returned in degrees": (("theta1, theta3])", "np.degrees(theta1), np.degrees(theta3)])"),),
        "The angles are brought into one turn, from 0 to 2 pi": (
            (
                "    return np.array([",
                "    theta1 = theta1 % (2 * np.pi)\n    theta3 = theta3 % (2 * np.pi)\n    return np.array([",
            ),
        ),
        "The angles are brought into one turn, from -pi to pi": (
            (
                "    return np.array([",
                "    theta1 = (theta1 + np.pi) % (2 * np.pi) - np.pi\n"
                "    theta3 = (theta3 + np.pi) % (2 * np.pi) - np.pi\n"
                "    return np.array([",
            ),
        ),
        "r1 is made positive": (("[r1,", "[abs(r1),"),),
    },
)

SAW_RATES = Student(
    """
def closure(q, theta2, lengths):
    r1y, r2, r3 = lengths
    r1, th1, th3 = q
    x = -r1 * np.cos(th1) + r2 * np.cos(theta2) + r3 * np.cos(th3)
    y = r1 * np.sin(th1) - r2 * np.sin(theta2) - r3 * np.sin(th3)
    return np.array([x, y, r1 * np.sin(th1) - r1y])


def saw_rates(q, crank, lengths):
    _, r2, r3 = lengths
    velocities, accelerations = [], []
    for i in range(len(q)):
        th2, omega2, alpha2 = crank[0, i], crank[1, i], crank[2, i]
        gap = np.linalg.norm(closure(q[i], th2, lengths))
        if not gap <= 1e-6:
            raise ValueError(f"point {i}: the loop is open by {gap} m")

        r1, th1, th3 = q[i]
        s1, c1 = np.sin(th1), np.cos(th1)
        s2, c2 = np.sin(th2), np.cos(th2)
        s3, c3 = np.sin(th3), np.cos(th3)
        J = np.array([[-c1, r1 * s1, -r3 * s3], [s1, r1 * c1, -r3 * c3], [s1, r1 * c1, 0]])

        by_theta2 = np.array([-r2 * s2, -r2 * c2, 0])
        v = np.linalg.solve(J, -by_theta2 * omega2)

        coriolis = 2 * v[0] * v[1]
        n1 = r1 * v[1]**2
        n2 = r2 * omega2**2
        n3 = r3 * v[2]**2
        t2 = r2 * alpha2
        gamma_x = coriolis * s1 + n1 * c1 - n2 * c2 - t2 * s2 - n3 * c3
        gamma_y = coriolis * c1 - n1 * s1 + n2 * s2 - t2 * c2 + n3 * s3
        gamma_guide = coriolis * c1 - n1 * s1
        gamma = np.array([gamma_x, gamma_y, gamma_guide])
        a = np.linalg.solve(J, -gamma)

        velocities.append(v)
        accelerations.append(a)
    rates = np.array([velocities, accelerations])
    return rates
""",
    {
        "The Coriolis term is forgotten": (("2 * v[0] * v[1]", "0"),),
        "The Coriolis term is counted once": (("2 * v[0] * v[1]", "v[0] * v[1]"),),
        "The centripetal term of the crank is forgotten": (("r2 * omega2**2", "0"),),
        "The centripetal term of the coupler is forgotten": (("r3 * v[2]**2", "0"),),
        "The centripetal term of r1 is forgotten": (("r1 * v[1]**2", "0"),),
        "The angular acceleration of the crank is forgotten": (("r2 * alpha2", "0"),),
        "The angular velocities are not squared in the centripetal terms": (
            ("r1 * v[1]**2", "r1 * v[1]"),
            ("r2 * omega2**2", "r2 * omega2"),
            ("r3 * v[2]**2", "r3 * v[2]"),
        ),
        "Every term with a product of velocities is forgotten": (
            ("2 * v[0] * v[1]", "0"),
            ("r1 * v[1]**2", "0"),
            ("r2 * omega2**2", "0"),
            ("r3 * v[2]**2", "0"),
        ),
        "The right side of the velocities has the wrong sign": (("-by_theta2", "by_theta2"),),
        "The right side of the accelerations has the wrong sign": (("-gamma", "gamma"),),
        "The right sides of both systems have the wrong sign": (("-by_theta2", "by_theta2"), ("-gamma", "gamma")),
        "The velocities are returned where the accelerations are asked for": (
            ("[velocities, accelerations]", "[velocities, velocities]"),
        ),
        "Velocities and accelerations are exchanged": (("[velocities, accelerations]", "[accelerations, velocities]"),),
        "The Jacobian is transposed": (("[s1, r1 * c1, 0]])", "[s1, r1 * c1, 0]]).T"),),
        "The angular velocity of the crank is taken as 1 rad/s": (("crank[1, i]", "1.0"),),
        "The angular rates are returned in degrees": (
            ("    return rates\n", "    rates[:, :, 1:] = np.degrees(rates[:, :, 1:])\n    return rates\n"),
        ),
        "The crank angle is taken for degrees": (
            ("np.sin(th2), np.cos(th2)", "np.sin(np.radians(th2)), np.cos(np.radians(th2))"),
        ),
    },
)

SAW_SWEEP = Student(
    ITERATE
    + """

def saw_sweep(residual, jacobian, theta2, seed, tol=1e-6):
    guess = np.array(seed, dtype=float)
    found = []
    for i, angle in enumerate(theta2):
        try:
            guess = iterate(residual, jacobian, angle, guess, tol)
        except ConvergenceError:
            raise ConvergenceError(f"the loop cannot close at index {i}")
        found.append(guess)
    r1, theta1, theta3 = np.reshape(found, (-1, 3)).T
    return np.stack((r1, theta1, theta3), axis=-1)
""",
    {
        "Every point starts from the seed": (("angle, guess, tol", "angle, np.array(seed, dtype=float), tol"),),
        "One step is taken at each point": (
            ("range(50)", "range(1)"),
            ('        raise ConvergenceError(f"no position found at theta2 = {theta2}")\n', "        pass\n"),
        ),
        "The last point is missing": (("enumerate(theta2)", "enumerate(theta2[:-1])"),),
        "The seed is returned as the first point, and all others are late by one": (
            ("found = []", "found = [guess]"),
            ("np.reshape(found,", "np.reshape(found[:-1],"),
        ),
        "The seed is returned in front of the positions": (("found = []", "found = [guess]"),),
        "Rows and columns are exchanged": (("axis=-1", "axis=0"),),
        "The crank angle is taken for degrees": (
            ("    guess = np.array(seed", "    theta2 = np.radians(theta2)\n    guess = np.array(seed"),
        ),
        "The angles are returned in degrees": (("theta1, theta3),", "np.degrees(theta1), np.degrees(theta3)),"),),
        "The angles are brought into one turn, from 0 to 2 pi": (
            (
                "    return np.stack(",
                "    theta1 = theta1 % (2 * np.pi)\n    theta3 = theta3 % (2 * np.pi)\n    return np.stack(",
            ),
        ),
        "The angles are brought into one turn, from -pi to pi": (
            (
                "    return np.stack(",
                "    theta1 = (theta1 + np.pi) % (2 * np.pi) - np.pi\n"
                "    theta3 = (theta3 + np.pi) % (2 * np.pi) - np.pi\n"
                "    return np.stack(",
            ),
        ),
        "r1 is made positive": (("((r1,", "((abs(r1),"),),
    },
)

STUDENTS = {
    "saw_position": SAW_POSITION,
    "saw_rates": SAW_RATES,
    "saw_sweep": SAW_SWEEP,
}
