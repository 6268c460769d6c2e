"""Known mistakes as students write them: from the text of a task and the name of the mistake alone.

A student's right solution of each task, in a way of its own, and what is edited in it. None of it was taken from the
reference or from the variants of the checks. Edits of two mistakes can be made at once where they do not meet.
"""

from examination import (
    students_03,
    students_04,
    students_05,
    students_06,
    students_07,
    students_08,
    students_09,
    students_10,
    students_11,
    students_12,
)
from examination.student import Student

SOLVER = """
class ConvergenceError(ArithmeticError):
    pass
"""

BRACKETS = Student(
    """
def brackets(f, a, b, n):
    if a >= b:
        raise ValueError(f"a = {a} is not less than b = {b}")
    if n < 1:
        raise ValueError(f"n = {n} is too small")
    h = (b - a) / n
    points = [a + i * h for i in range(n + 1)]
    values = [f(point) for point in points]
    found = []
    for i in range(n):
        if values[i] * values[i + 1] < 0:
            found.append((points[i], points[i + 1]))
    return np.array(found).reshape(-1, 2)
""",
    {
        "The grid has n points, and not n subintervals": (
            ("h = (b - a) / n", "h = (b - a) / (n - 1)"),
            ("range(n + 1)", "range(n)"),
            ("for i in range(n):", "for i in range(n - 1):"),
        ),
        "Only the ends of the whole interval are compared": (
            ("    h = (b - a) / n\n", "    return np.array([[a, b]] if f(a) * f(b) < 0 else []).reshape(-1, 2)\n"),
        ),
        "The subintervals without a change of sign": (("values[i + 1] < 0", "values[i + 1] > 0"),),
        "The last subinterval is left out": (("    for i in range(n):", "    for i in range(n - 1):"),),
    },
)

NEWTON_1D = Student(
    SOLVER
    + """
def newton_1d(f, df, seed, tol=1e-10, error="absolute", max_iterations=50):
    xs = [seed]
    while len(xs) <= max_iterations:
        x = xs[-1]
        slope = df(x)
        if slope == 0:
            raise ConvergenceError(f"no way on from x = {x}")
        new = x - f(x) / slope
        if not np.isfinite(new):
            raise ConvergenceError(f"x = {x} leads out of the domain")
        xs.append(new)
        change = abs(new - x)
        if error == "relative":
            change = change / abs(new)
        if change < tol:
            return np.array(xs)
    raise ConvergenceError(f"still at x = {xs[-1]}")
""",
    {
        "The step has the wrong sign": (("x - f(x) / slope", "x + f(x) / slope"),),
        "The slope of the seed is used in every step": (("slope = df(x)", "slope = df(seed)"),),
        "It stops when f is small, and not when the step is": (("if change < tol", "if abs(f(new)) < tol"),),
        "The absolute error is used whichever error is asked for": (("change = change / abs(new)", "pass"),),
        "The relative error is used whichever error is asked for": (('if error == "relative":', "if True:"),),
        "One iteration too many": (
            ("    xs = [seed]\n", "    xs = [seed]\n    done = False\n"),
            ("        xs.append(new)\n", "        xs.append(new)\n        if done:\n            return np.array(xs)\n"),
            ("            return np.array(xs)\n    raise", "            done = True\n    raise"),
        ),
        "The seed is missing from the history": (("return np.array(xs)", "return np.array(xs[1:])"),),
        "The last iterate is missing from the history": (("return np.array(xs)", "return np.array(xs[:-1])"),),
        "The root alone is returned": (("return np.array(xs)", "return xs[-1]"),),
    },
)

FAILURES = Student(
    NEWTON_1D.right,
    {
        "Where the iterations run out, the history is returned": (
            ('    raise ConvergenceError(f"still at x = {xs[-1]}")', "    return np.array(xs)"),
        ),
    },
)

ORDER = Student(
    """
def order(history):
    x = list(history)
    noise = 8 * np.finfo(float).eps * abs(x[-1])
    steps = []
    for k in range(1, len(x)):
        step = abs(x[k] - x[k - 1])
        if step > noise:
            steps.append(step)
    if len(steps) < 3:
        return float("nan")
    s1, s2, s3 = steps[-3:]
    return math.log(s3 / s2) / math.log(s2 / s1)
""",
    {
        "Steps of the size of round-off are counted in": (("if step > noise:", "if step > 0:"),),
        "The first three steps are used": (("steps[-3:]", "steps[:3]"),),
        "The ratio of the logarithms is upside down": (
            ("math.log(s3 / s2) / math.log(s2 / s1)", "math.log(s2 / s1) / math.log(s3 / s2)"),
        ),
        "The rate of convergence, and not its order": (("math.log(s3 / s2) / math.log(s2 / s1)", "s3 / s2"),),
    },
)

NEWTON = Student(
    SOLVER
    + """
def newton(residual, jacobian, seed, tol=1e-10, max_iterations=50):
    x = np.asarray(seed, dtype=float)
    xs = [x]
    for k in range(max_iterations):
        J = np.array(jacobian(x))
        F = np.array(residual(x))
        try:
            d = np.linalg.solve(J, -F)
        except np.linalg.LinAlgError as why:
            raise ConvergenceError(f"{why} at {x}")
        x = x + d
        xs.append(x)
        if not np.all(np.isfinite(x)):
            break
        if math.sqrt(sum(d**2)) < tol:
            return np.array(xs)
    raise ConvergenceError(f"no root, last at {x}")
""",
    {
        "The Jacobian is transposed": (("np.array(jacobian(x))", "np.array(jacobian(x)).T"),),
        "The Jacobian of the seed is used in every step": (("jacobian(x)", "jacobian(seed)"),),
        "The step has the wrong sign": (("np.linalg.solve(J, -F)", "np.linalg.solve(J, F)"),),
        "It stops when the residual is small, and not when the step is": (
            ("math.sqrt(sum(d**2)) < tol", "np.linalg.norm(residual(x)) < tol"),
        ),
        "The largest entry of the step is compared with tol, and not its 2-norm": (
            ("math.sqrt(sum(d**2)) < tol", "max(abs(d)) < tol"),
        ),
        "The seed is missing from the history": (("xs = [x]", "xs = []"),),
        "The last iterate is missing from the history": (
            ("        xs.append(x)\n", ""),
            ("            return np.array(xs)\n", "            return np.array(xs)\n        xs.append(x)\n"),
        ),
        "The root alone is returned": (("return np.array(xs)", "return x"),),
    },
)

JACOBIAN_FD = Student(
    """
def jacobian_fd(residual, x):
    columns = []
    for j in range(len(x)):
        h = 1e-6 * max(1, abs(x[j]))
        ahead, behind = np.array(x, dtype=float), np.array(x, dtype=float)
        ahead[j] += h
        behind[j] -= h
        difference = np.array(residual(ahead)) - np.array(residual(behind))
        columns.append(difference / (2 * h))
    return np.array(columns).T
""",
    {
        "The Jacobian is transposed": (("np.array(columns).T", "np.array(columns)"),),
        "The difference is divided by h, and spans 2 h": (("/ (2 * h)", "/ h"),),
        "The difference has the wrong sign": (
            (
                "np.array(residual(ahead)) - np.array(residual(behind))",
                "np.array(residual(behind)) - np.array(residual(ahead))",
            ),
        ),
    },
)

JACOBIAN_ERRORS = Student(
    JACOBIAN_FD.right
    + """
def jacobian_errors(residual, jacobian, x):
    mine, theirs = jacobian_fd(residual, x), np.array(jacobian(x))
    wrong = []
    for i in range(mine.shape[0]):
        largest = max(abs(mine[i]))
        for j in range(mine.shape[1]):
            if abs(theirs[i, j] - mine[i, j]) > 1e-4 * largest:
                wrong.append((i, j))
    return wrong
""",
    {
        "Column and row are exchanged": (("wrong.append((i, j))", "wrong.append((j, i))"),),
        "The entries are counted from one": (("wrong.append((i, j))", "wrong.append((i + 1, j + 1))"),),
        "Only the first wrong entry is named": (("wrong.append((i, j))", "return [(i, j)]"),),
        "The right entries are named": (("> 1e-4 * largest", "<= 1e-4 * largest"),),
    },
)

BASIN_MAP = Student(
    NEWTON.right
    + """
def basin_map(residual, jacobian, xs, ys, roots):
    basins = []
    for y in ys:
        row = []
        for x in xs:
            index = -1
            try:
                root = newton(residual, jacobian, (x, y))[-1]
            except ConvergenceError:
                root = (np.inf, np.inf)
            for k, known in enumerate(roots):
                if math.hypot(root[0] - known[0], root[1] - known[1]) < 1e-5:
                    index = k
            row.append(index)
        basins.append(row)
    return np.array(basins)
""",
    {
        "The map is transposed": (("return np.array(basins)", "return np.array(basins).T"),),
        "The roots are counted from one": (("enumerate(roots)", "enumerate(roots, 1)"), ("index = -1", "index = 0")),
        "The root nearest to the seed, and not the one that the iteration finds": (
            ("            index = -1\n", "            distances = [math.hypot(x - r[0], y - r[1]) for r in roots]\n"),
            ("            row.append(index)\n", "            row.append(distances.index(min(distances)))\n"),
        ),
    },
)

STUDENTS = {
    "brackets": BRACKETS,
    "newton_1d": NEWTON_1D,
    "failures": FAILURES,
    "order": ORDER,
    "newton": NEWTON,
    "jacobian_fd": JACOBIAN_FD,
    "jacobian_errors": JACOBIAN_ERRORS,
    "basin_map": BASIN_MAP,
    **students_03.STUDENTS,
    **students_04.STUDENTS,
    **students_05.STUDENTS,
    **students_06.STUDENTS,
    **students_07.STUDENTS,
    **students_08.STUDENTS,
    **students_09.STUDENTS,
    **students_10.STUDENTS,
    **students_11.STUDENTS,
    **students_12.STUDENTS,
}
