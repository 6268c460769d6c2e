"""Exercise 6: positions, velocities and accelerations of the power hacksaw as one system of nine equations."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from autograder.checks import e04_hacksaw_closure as closure
from autograder.checks import e05_consecutive as consecutive
from autograder.checks.answers import array, arrays
from autograder.checks.e04_hacksaw_closure import RIGHT, either_sign, everywhere, slanted, with_vectors
from autograder.checks.e05_consecutive import TURN, random_saw
from autograder.checks.iteration import MOST_DRAWN
from autograder.compare import Tolerance, difference, disagreement
from autograder.outcome import Lost, Outcome, Raised, Value
from autograder.spec import Aspect, Case, Exercise, Task, Trial, Variant, readings
from mechlib.hacksaw import Hacksaw
from mechlib.newton import ConvergenceError, newton

NAMES = ("Fx", "Fy", "Fc", "Fx'", "Fy'", "Fc'", "Fx''", "Fy''", "Fc''")


def numbers_of(rng: np.random.Generator, r1: float) -> Case:
    """Numbers that close no loop: each term is there to be seen, and so is its absence."""
    q = np.array([r1, slanted(rng) - TURN, slanted(rng)])
    state = np.concatenate((q, either_sign(rng, 0.5, 3, 6)))
    crank = np.array([slanted(rng), *either_sign(rng, 1.5, 3, 2)])
    lengths = np.array([rng.uniform(0.2, 0.4), rng.uniform(0.5, 0.9), rng.uniform(1.1, 2)])
    label = f"r1 = {r1:.3g}, theta1 = {q[1]:.3g}, theta3 = {q[2]:.3g}, theta2 = {crank[0]:.3g}"
    return Case((state, crank, lengths), label=label)


def system_cases(rng: np.random.Generator) -> list[Case]:
    return [
        numbers_of(rng, -rng.uniform(0.5, 0.8)),
        numbers_of(rng, rng.uniform(0.5, 0.8)),
        numbers_of(rng, -rng.uniform(1.3, 2)),
    ]


def interleaved(state: np.ndarray) -> np.ndarray:
    """What (r1, v_r, a_r, theta1, ...) is in our order."""
    return np.reshape(state, (3, 3)).T.ravel()


def with_angles_in_degrees(state: np.ndarray) -> np.ndarray:
    return state * np.array([1, np.pi / 180, np.pi / 180, 1, 1, 1, 1, 1, 1])


# --- nine_equations ---------------------------------------------------------------------------------------------------


def rows_by(residuals: Callable) -> Callable:
    """(state, crank, lengths) -> a row of Fx, Fy, Fc a level, from the functions of exercise 4."""
    return lambda state, crank, lengths: residuals(*np.split(state, 3), crank, lengths)


def nine_by(residuals: Callable) -> Callable:
    return lambda *args: rows_by(residuals)(*args).ravel()


rows, nine_equations = rows_by(closure.residuals), nine_by(closure.residuals)


def level(k: int) -> Callable:
    """Looks at the three equations of one level, and says which are off."""
    three = slice(3 * k, 3 * k + 3)

    def fault(trial: Trial, right: Trial) -> str | None:
        got = array(trial, (9,))
        if isinstance(got, str):
            return got
        expected, got = right.outcome.value[three], got[three]
        if (why := difference(expected, got, closure.ROUND_OFF)) is None:
            return None
        off = ~(np.abs(got - expected) <= closure.ROUND_OFF.relative * np.abs(expected).max())
        wrong = ", ".join(name for name, is_off in zip(NAMES[three], off, strict=True) if is_off)
        return f"wrong: {wrong}" + ("" if why.startswith("it is off") else f"; {why}")

    return fault


NINE_EQUATIONS = Task(
    name="nine_equations",
    title="the nine equations",
    function="nine_equations",
    reference=nine_equations,
    cases=system_cases,
    tolerance=closure.ROUND_OFF,
    section="hacksaw-simultaneous: Nine equations at once",
    aspects=(
        Aspect("entries 0 to 2 are the position equations Fx, Fy, Fc", 0.25, level(0)),
        Aspect("entries 3 to 5 are their first time derivatives", 0.5, level(1)),
        Aspect("entries 6 to 8 are their second time derivatives, with every term", 0.75, level(2)),
    ),
    variants=(
        Variant(
            "The Coriolis term is missing",
            "The length and the angle of r1 both change: how often does v_r omega1 appear in the second derivative?",
            nine_by(with_vectors(replace(RIGHT, coriolis=0))),
            share=0.5,
        ),
        Variant(
            "The Coriolis term is there once",
            "It comes from two places: from the change of v_r's direction, and from the change of r1 in omega1 r1.",
            nine_by(with_vectors(replace(RIGHT, coriolis=0.5))),
            share=0.625,
        ),
        Variant(
            "The Coriolis term has the wrong sign",
            "Differentiate v_r cos(theta1) by the product rule, and keep the sign that the cosine brings.",
            nine_by(with_vectors(replace(RIGHT, coriolis=-1))),
            share=0.625,
        ),
        Variant(
            "The centripetal term of the crank is missing",
            "A crank at constant speed still accelerates its pin: towards what?",
            nine_by(with_vectors(pin=replace(RIGHT, centripetal=0))),
            share=0.625,
        ),
        Variant(
            "The centripetal term of the coupler is missing",
            "omega3 sin(theta3) is a product of two things that change in time.",
            nine_by(with_vectors(coupler=replace(RIGHT, centripetal=0))),
            share=0.625,
        ),
        Variant(
            "The centripetal term of r1 is missing",
            "omega1 r1 sin(theta1) is a product of three things that change in time.",
            nine_by(with_vectors(replace(RIGHT, centripetal=0))),
            share=0.625,
        ),
        Variant(
            "Every centripetal term is missing",
            "omega sin(theta) is a product of two things that change in time.",
            nine_by(everywhere(replace(RIGHT, centripetal=0))),
            share=0.5,
        ),
        Variant(
            "The centripetal terms point outwards",
            "A cosine that is differentiated twice comes back with which sign?",
            nine_by(everywhere(replace(RIGHT, centripetal=-1))),
            share=0.5,
        ),
        Variant(
            "The angular acceleration of the crank is forgotten",
            "The motor speeds up: alpha2 is given, and it is not zero.",
            nine_by(with_vectors(pin=replace(RIGHT, tangential=0))),
            share=0.625,
        ),
        Variant(
            "The angular velocity of the crank is forgotten",
            "The crank turns while theta2 is read: which terms of the derivatives does it bring?",
            lambda state, crank, lengths: nine_equations(state, np.array(crank) * [1, 0, 1], lengths),
            share=0.25,
        ),
        Variant(
            "The crank does not move in the derivatives",
            "theta2 is known, and it changes in time.",
            nine_by(closure.crank_at_rest),
            share=0.25,
        ),
        Variant(
            "The height of the guide is still there in the derivatives",
            "What is the time derivative of a constant?",
            nine_by(closure.height_in_the_derivatives),
            share=0.25,
        ),
        Variant(
            "The coupler has the wrong sign in Fy",
            "r1 = r2 + r3, for the vertical components too: which vectors stand on the same side?",
            nine_by(closure.coupler_with_the_other_sign),
            share=0.25,
        ),
        Variant(
            "Fx has the opposite sign",
            "It closes the same loop, but the task states the sign of each equation: the Jacobian must fit to it.",
            lambda *args: (rows(*args) * [-1, 1, 1]).ravel(),
            share=0.75,
        ),
        Variant(
            "The equations of each level are in the order Fc, Fx, Fy",
            "Which equation belongs to which entry?",
            lambda *args: rows(*args)[:, [2, 0, 1]].ravel(),
            share=0.75,
        ),
        Variant(
            "Each equation is followed by its derivatives",
            "First come all position equations, then all velocity equations, then all acceleration equations.",
            lambda *args: rows(*args).T.ravel(),
            share=0.75,
        ),
        Variant(
            "The acceleration equations come first, and the position equations last",
            "First come all position equations, then all velocity equations, then all acceleration equations.",
            lambda *args: rows(*args)[::-1].ravel(),
            share=0.75,
        ),
        Variant(
            "The unknowns are unpacked in the order r1, v_r, a_r, theta1 and so on",
            "The state holds three positions, then three velocities, then three accelerations.",
            lambda state, *rest: nine_equations(interleaved(state), *rest),
            share=0.5,
        ),
        Variant(
            "The result is a matrix of three rows",
            "A solver wants one vector of nine.",
            rows,
            share=0.75,
        ),
        Variant(
            "The angles are taken for degrees",
            "They are in radians, and NumPy wants radians.",
            nine_by(everywhere(replace(RIGHT, unit=lambda th: np.exp(1j * np.deg2rad(th))))),
            share=0.25,
        ),
        Variant(
            "The lengths are unpacked in the order r2, r3, r1y",
            "The order of the lengths is stated in the task.",
            lambda state, crank, lengths: nine_equations(state, crank, np.roll(lengths, 1)),
            share=0.5,
        ),
    ),
)

# --- nine_jacobian ----------------------------------------------------------------------------------------------------


def parts(length: Sequence, angle: Sequence, coriolis: float = 1.0, centripetal: float = 1.0) -> np.ndarray:
    """Derivatives of a vector r e^(i theta) and of its two time derivatives by (r, theta, v_r, omega, a_r, alpha).

    The factors multiply a term: 1 is right, 0 forgets it. Shape (3, 6), complex.
    """
    (r, dr, ddr), (th, w, al) = length, angle
    c, k = centripetal, coriolis
    along, across = ddr - c * r * w**2, r * al + 2 * k * dr * w
    derivatives = [
        [1, 1j * r, 0, 0, 0, 0],
        [1j * w, 1j * dr - r * w, 1, 1j * r, 0, 0],
        [1j * al - c * w**2, 1j * along - across, 2j * k * w, 2j * k * dr - 2 * c * r * w, 1, 1j * r],
    ]
    return np.array(derivatives) * np.exp(1j * th)


def blocks(state, crank, lengths, of_line: dict | None = None, of_coupler: dict | None = None) -> np.ndarray:
    """Indices: level of the equation, equation, level of the unknown, unknown; shape (3, 3, 3, 3)."""
    (r1, th1, th3), (vr, w1, w3), (ar, al1, al3) = np.split(np.asarray(state), 3)
    line = parts((r1, vr, ar), (th1, w1, al1), **(of_line or {})).reshape(3, 3, 2)
    coupler = parts((lengths[2], 0, 0), (th3, w3, al3), **(of_coupler or {}))[:, 1::2]
    nine = np.zeros((3, 3, 3, 3))
    nine[:, 0, :, :2], nine[:, 0, :, 2] = -line.real, coupler.real
    nine[:, 1, :, :2], nine[:, 1, :, 2] = line.imag, -coupler.imag
    nine[:, 2, :, :2] = line.imag
    return nine


def nine_jacobian(*args, **forgotten: dict) -> np.ndarray:
    return blocks(*args, **forgotten).reshape(9, 9)


def without(*places: tuple[int, int]) -> Callable:
    """The Jacobian with some blocks left zero: (level of the equations, level of the unknowns)."""

    def matrix(*args) -> np.ndarray:
        nine = blocks(*args)
        for equations, unknowns in places:
            nine[equations, :, unknowns] = 0
        return nine.reshape(9, 9)

    return matrix


def the_same_block_twice(*args) -> np.ndarray:
    nine = blocks(*args)
    nine[2, :, 1] = nine[1, :, 0]
    return nine.reshape(9, 9)


def of_appendix_d(state, crank, lengths) -> np.ndarray:
    """Source A's matrix in our order, with its row of the guide's acceleration."""
    matrix = nine_jacobian(state, crank, lengths)
    matrix[8, 6:8] = 2 * state[4] * np.cos(state[1]), np.cos(state[1])
    return matrix


def diagonal_and_above(trial: Trial, right: Trial) -> str | None:
    got = array(trial, (9, 9))
    if isinstance(got, str):
        return got
    below = np.kron(np.tri(3, k=-1), np.ones((3, 3))) == 1
    return difference(np.where(below, 0, right.outcome.value), np.where(below, 0, got), closure.DIFFERENCES)


def block(equations: int, unknowns: int) -> Callable:
    place = np.s_[3 * equations : 3 * equations + 3, 3 * unknowns : 3 * unknowns + 3]

    def fault(trial: Trial, right: Trial) -> str | None:
        got = array(trial, (9, 9))
        return got if isinstance(got, str) else difference(right.outcome.value[place], got[place], closure.DIFFERENCES)

    return fault


FORGOTTEN = "Compare with differences of your nine equations: which entries are off, and which equations are right?"

NINE_JACOBIAN = Task(
    name="nine_jacobian",
    title="their Jacobian",
    function="nine_jacobian",
    reference=nine_jacobian,
    cases=system_cases,
    tolerance=closure.DIFFERENCES,
    section="hacksaw-simultaneous: The Jacobian, block by block",
    aspects=(
        Aspect("the three blocks in the diagonal are right, and those above it are zero", 0.75, diagonal_and_above),
        Aspect("the velocity equations are differentiated by the positions", 0.5, block(1, 0)),
        Aspect("the acceleration equations are differentiated by the velocities", 0.5, block(2, 1)),
        Aspect("the acceleration equations are differentiated by the positions", 0.75, block(2, 0)),
    ),
    variants=(
        Variant(
            "The Jacobian is transposed",
            "A row is an equation, a column an unknown.",
            lambda *args: nine_jacobian(*args).T,
            share=0.5,
        ),
        Variant(
            "Only the blocks in the diagonal are there",
            "Newton-Raphson still converges, two iterations later. Does a velocity equation hold no position?",
            without((1, 0), (2, 0), (2, 1)),
            share=0.375,
        ),
        Variant(
            "The accelerations are not differentiated by the positions",
            "Newton-Raphson still converges, only later. Which angles and lengths stand in an acceleration equation?",
            without((2, 0)),
            share=0.625,
        ),
        Variant(
            "The acceleration equations are differentiated by the accelerations alone",
            "Which positions and velocities stand in an acceleration equation?",
            without((2, 0), (2, 1)),
            share=0.5,
        ),
        Variant(
            "The block of accelerations by velocities is that of velocities by positions",
            "A square or a product of two velocities is differentiated by one of them: which factor comes out?",
            the_same_block_twice,
            share=0.75,
        ),
        Variant(
            "The Coriolis term is missing in the derivatives",
            FORGOTTEN,
            lambda *args: nine_jacobian(*args, of_line={"coriolis": 0}),
            share=0.5,
        ),
        Variant(
            "The Coriolis term is there once in the derivatives",
            FORGOTTEN,
            lambda *args: nine_jacobian(*args, of_line={"coriolis": 0.5}),
            share=0.5,
        ),
        Variant(
            "The centripetal term of r1 is missing in the derivatives",
            FORGOTTEN,
            lambda *args: nine_jacobian(*args, of_line={"centripetal": 0}),
            share=0.5,
        ),
        Variant(
            "The centripetal term of the coupler is missing in the derivatives",
            FORGOTTEN,
            lambda *args: nine_jacobian(*args, of_coupler={"centripetal": 0}),
            share=0.5,
        ),
        Variant(
            "The guide's acceleration row is that of source A's appendix D",
            "Two of its entries are derivatives of something else. Compare the row with differences.",
            of_appendix_d,
            share=0.7,
        ),
        Variant(
            "Every sign is turned round",
            "Which signs have the equations? Differentiate them as they stand.",
            lambda *args: -nine_jacobian(*args),
            share=0.5,
        ),
        Variant(
            "The equations of each level are in the order Fc, Fx, Fy",
            "Which row belongs to which equation?",
            lambda *args: blocks(*args)[:, [2, 0, 1]].reshape(9, 9),
            share=0.75,
        ),
        Variant(
            "The rows of an equation and of its derivatives follow each other",
            "First come the rows of all position equations, then those of all velocity equations.",
            lambda *args: blocks(*args).transpose(1, 0, 2, 3).reshape(9, 9),
            share=0.75,
        ),
        Variant(
            "The columns of an unknown and of its derivatives follow each other",
            "First come the columns of all positions, then those of all velocities.",
            lambda *args: blocks(*args).transpose(0, 1, 3, 2).reshape(9, 9),
            share=0.75,
        ),
        Variant(
            "The columns of the accelerations come first, and those of the positions last",
            "The order of the columns is that of the state.",
            lambda *args: blocks(*args)[:, :, ::-1].reshape(9, 9),
            share=0.75,
        ),
        Variant(
            "The unknowns are unpacked in the order r1, v_r, a_r, theta1 and so on",
            "The state holds three positions, then three velocities, then three accelerations.",
            lambda state, *rest: nine_jacobian(interleaved(state), *rest),
            share=0.5,
        ),
        Variant(
            "The length of the crank stands where that of the coupler belongs",
            "Which length turns with theta3?",
            lambda state, crank, lengths: nine_jacobian(state, crank, np.array(lengths)[[0, 2, 1]]),
            share=0.5,
        ),
        Variant(
            "The angles are taken for degrees",
            "They are in radians, and NumPy wants radians.",
            lambda state, *rest: nine_jacobian(with_angles_in_degrees(state), *rest),
            share=0.25,
        ),
    ),
)

# --- what the two solvers tell ----------------------------------------------------------------------------------------


def equations(saw: Hacksaw) -> tuple[Callable, Callable]:
    """The nine equations and their Jacobian at one state: several times cheaper than those of `saw.loop`."""
    r1y, r2, r3 = saw.r1y, saw.r2, saw.r3

    def residual(state, crank):
        r1, th1, th3, vr, w1, w3, ar, al1, al3 = np.asarray(state, dtype=float).tolist()
        th2, w2, al2 = np.asarray(crank, dtype=float).tolist()
        s1, s2, s3 = np.sin((th1, th2, th3)).tolist()
        c1, c2, c3 = np.cos((th1, th2, th3)).tolist()
        along, across = ar - r1 * w1 * w1, r1 * al1 + 2 * vr * w1
        x, y = r2 * c2 + r3 * c3, r2 * s2 + r3 * s3
        vx, vy = -r2 * w2 * s2 - r3 * w3 * s3, r2 * w2 * c2 + r3 * w3 * c3
        ax = -r2 * (al2 * s2 + w2 * w2 * c2) - r3 * (al3 * s3 + w3 * w3 * c3)
        ay = r2 * (al2 * c2 - w2 * w2 * s2) + r3 * (al3 * c3 - w3 * w3 * s3)
        height, rise, lift = r1 * s1, vr * s1 + r1 * w1 * c1, along * s1 + across * c1
        position = (x - r1 * c1, height - y, height - r1y)
        velocity = (vx - vr * c1 + r1 * w1 * s1, rise - vy, rise)
        return np.array([*position, *velocity, ax - along * c1 + across * s1, lift - ay, lift])

    def jacobian(state, crank):
        r1, th1, th3, vr, w1, w3, ar, al1, al3 = np.asarray(state, dtype=float).tolist()
        (s1, s3), (c1, c3) = np.sin((th1, th3)).tolist(), np.cos((th1, th3)).tolist()
        along, across = ar - r1 * w1 * w1, r1 * al1 + 2 * vr * w1
        own = (-c1, r1 * s1, -r3 * s3), (s1, r1 * c1, -r3 * c3), (s1, r1 * c1, 0.0)
        x1, xt, x3 = w1 * s1, vr * s1 + r1 * w1 * c1, -r3 * w3 * c3  # of the velocity equations, by the positions
        y1, yt, y3 = w1 * c1, vr * c1 - r1 * w1 * s1, r3 * w3 * s3
        ax1, axt, ax3 = al1 * s1 + w1 * w1 * c1, along * s1 + across * c1, -r3 * (al3 * c3 - w3 * w3 * s3)
        ay1, ayt, ay3 = al1 * c1 - w1 * w1 * s1, along * c1 - across * s1, r3 * (al3 * s3 + w3 * w3 * c3)
        zero = (0.0, 0.0, 0.0)
        return np.array(
            [
                *((*row, *zero, *zero) for row in own),
                (x1, xt, x3, *own[0], *zero),
                (y1, yt, y3, *own[1], *zero),
                (y1, yt, 0.0, *own[2], *zero),
                (ax1, axt, ax3, 2 * x1, 2 * xt, 2 * x3, *own[0]),
                (ay1, ayt, ay3, 2 * y1, 2 * yt, 2 * y3, *own[1]),
                (ay1, ayt, 0.0, 2 * y1, 2 * yt, 0.0, *own[2]),
            ]
        )

    return residual, jacobian


def state_of(saw: Hacksaw, crank: np.ndarray) -> np.ndarray:
    """Shapes (3,) or (3, points) -> (..., 9)."""
    return np.concatenate(saw.closed_form(*crank), axis=-1)


Told = tuple[np.ndarray, np.ndarray, np.ndarray]  # state, iterations, last error; of one point or many


def told(trial: Trial, shape: tuple[int, ...]) -> Told | str:
    """What was returned, or a sentence that says what came instead."""
    return three(trial.outcome, (shape, shape[:-1], shape[:-1]))


def three(outcome: Outcome, shapes: tuple[tuple[int, ...], ...]) -> Told | str:
    named = dict(zip(("the state", "the iterations", "the error"), shapes, strict=True))
    return arrays(outcome, named, "three things: state, iterations, error")


def same_effort(expected: Outcome, got: Outcome) -> str | None:
    """Whether two outcomes of a solver are one: the states nearly, the iterations exactly, the errors in their size."""
    if isinstance(got, Lost) or not (isinstance(expected, Value) and isinstance(got, Value)):
        return disagreement(expected, got, SETTLED)
    states, iterations, last = expected.value
    answer = three(got, tuple(map(np.shape, expected.value)))
    if isinstance(answer, str):
        return answer
    if why := difference(states, answer[0], SETTLED):
        return why
    if not np.array_equal(iterations, answer[1]):
        return "it takes another number of iterations"
    return None if np.allclose(last, answer[2], rtol=1e-3, atol=1e-9) else "the last error is another one"


SETTLED = Tolerance(1e-9, "two ways to write a step differ by round-off", absolute=1e-8)


def fault_of_the_effort(looked: list[np.ndarray], state, iterations: float, error: float, tol: float) -> str | None:
    """Iterations and last error against the states at which the equations were evaluated, whatever the start was."""
    path = [x for k, x in enumerate(looked) if not k or not np.array_equal(x, looked[k - 1])]
    if not path:
        return "the equations are never evaluated there"
    if not np.array_equal(path[-1], state):  # one more look, at the end, is forgiven
        path.append(state)
    steps = [float(np.linalg.norm(b - a)) for a, b in pairwise(path)]
    if len(steps) != iterations:
        return f"it takes {len(steps)} steps, and tells {iterations:g} iterations"
    if not steps or not abs(error - steps[-1]) <= 1e-3 * steps[-1] + 1e-10:
        return "the error that it tells is not the 2-norm of its last step"
    early, late = steps[-1] > tol * (1 + 1e-6), any(step < tol * (1 - 1e-6) for step in steps[:-1])
    return (
        f"it stops {'before' if early else 'after'} the first step whose 2-norm is below tol" if early or late else None
    )


def states_changed(solver: Callable, change: Callable) -> Callable:
    """A solver whose states are changed before they are returned."""

    def changed(*args):
        state, iterations, error = solver(*args)
        return change(state), iterations, error

    return changed


def in_degrees(state: np.ndarray) -> np.ndarray:
    return state * np.tile([1, 180 / np.pi, 180 / np.pi], 3)


def wrapped_from(low: float) -> Callable:
    def change(state: np.ndarray) -> np.ndarray:
        return np.concatenate((consecutive.wrapped_from(low, state[..., :3]), state[..., 3:]), axis=-1)

    return change


def slips_of_the_states(solver: Callable) -> tuple[Variant, ...]:
    turn = "Newton-Raphson stays on the turn of its seed, and an angle that does not leap can be differentiated."
    return (
        Variant(
            "The angles and their rates are returned in degrees",
            "Angles are in rad until they are plotted.",
            states_changed(solver, in_degrees),
            share=0.5,
        ),
        Variant(
            "The angles are brought into one turn, from 0 to 2 pi",
            turn,
            states_changed(solver, wrapped_from(0.0)),
            share=0.5,
        ),
        Variant(
            "The angles are brought into one turn, from -pi to pi",
            turn,
            states_changed(solver, wrapped_from(-np.pi)),
            share=0.5,
        ),
        Variant(
            "The positions alone are returned",
            "The state holds nine numbers: what of the velocities and accelerations?",
            states_changed(solver, lambda state: state[..., :3]),
            share=0.5,
        ),
    )


# --- one_point --------------------------------------------------------------------------------------------------------


def one_point(residual, jacobian, crank, seed, tol=1e-6) -> tuple[np.ndarray, int, float]:
    path = newton(lambda x: residual(x, crank), lambda x: jacobian(x, crank), seed, tol)
    return path.root, path.iterations, path.errors[-1]


def random_crank(rng: np.random.Generator) -> np.ndarray:
    return np.array([rng.uniform(-TURN, 2 * TURN), *either_sign(rng, 2, 6, 1), *either_sign(rng, 5, 20, 1)])


def point_case(
    rng: np.random.Generator, size: float, last_step: tuple[float, float], next_step: float = 0.0, turns: int = 0
) -> Case:
    """A point whose tolerance lies well between two steps: no rounding decides when to stop.

    A small saw looks closed a step too early, and a large one does not: that tells a stop on the residual from a last
    step that is not taken. The positions alone of a small saw are found a step too early.
    """
    while True:
        saw, crank = random_saw(rng, size), random_crank(rng)
        away = np.concatenate((rng.uniform(0.1, 0.6, 3) * [saw.r3, 1, 1], rng.uniform(1, 9, 6))) * rng.choice(
            [-1, 1], 9
        )
        whole_turns = np.array([0, turns * TURN, turns * TURN, 0, 0, 0, 0, 0, 0])
        seed = state_of(saw, crank) + away + whole_turns
        residual, jacobian = equations(saw)
        path = path_or_none(residual, jacobian, crank, seed)
        if path is None or np.abs(path.root - seed + away).max() > 1e-7:  # not home
            continue
        for k in range(2, min(path.iterations - 1, 7)):
            before, last, after = path.errors[k - 1 : k + 2]
            open_by = np.linalg.norm(residual(path.history[k], crank))
            clear = open_by < 1.5 * last if size < 1 else open_by > 6 * last  # half of tol, and twice tol
            of_positions = np.linalg.norm((path.history[k] - path.history[k - 1])[:3])
            fits = last_step[0] < last < last_step[1] and before > 9 * last and next_step < after < 0.03 * last
            if fits and clear and (size > 1 or of_positions < last):
                return labelled(saw, crank, seed, 3 * last, turns)


def between_two_lengths(rng: np.random.Generator, turns: int) -> Case:
    """A tolerance between the largest entry of a step and its 2-norm."""
    while True:
        saw, crank = random_saw(rng), random_crank(rng)
        whole_turns = np.array([0, turns * TURN, turns * TURN, 0, 0, 0, 0, 0, 0])
        seed = state_of(saw, crank) * rng.uniform(0.8, 1.2, 9) + whole_turns
        path = path_or_none(*equations(saw), crank, seed)
        if path is None or np.abs(path.root - whole_turns - state_of(saw, crank)).max() > 1e-7:
            continue
        for k in range(2, path.iterations - 1):
            norm, largest = path.errors[k], np.abs(path.history[k + 1] - path.history[k]).max()
            tol = float(np.sqrt(norm * largest))
            if norm > 1.3 * largest and path.errors[k - 1] > 3 * tol and 1e-8 < path.errors[k + 1] < tol / 3:
                return labelled(saw, crank, seed, tol, turns)


def path_or_none(residual, jacobian, crank, seed):
    try:
        return newton(lambda x: residual(x, crank), lambda x: jacobian(x, crank), seed, 1e-10, max_iterations=12)
    except ConvergenceError:
        return None


def labelled(saw: Hacksaw, crank: np.ndarray, seed: np.ndarray, tol: float, turns: int) -> Case:
    label = f"a crank of {saw.r2:.3g} m at {crank[0]:.3f} rad, the seed {turns} turns on, tol = {tol:.1e}"
    return Case((*equations(saw), crank, seed, tol), label=label)


def nearly_dependent(rng: np.random.Generator) -> Case:
    """Linear, condition 1e10, from the origin: the first iterate is the first step itself."""
    u, v = (np.linalg.qr(rng.normal(size=(9, 9)))[0] for _ in range(2))
    matrix = u @ np.diag(np.logspace(0, -10, 9)) @ v
    right = matrix @ rng.uniform(1, 2, 9)
    args = (lambda x, crank: matrix @ x - right, lambda x, crank: matrix, random_crank(rng), np.zeros(9), 1e-2)
    return Case(args, kind="ill", label="nine equations that are nearly dependent, from the origin")


def point_cases(rng: np.random.Generator) -> list[Case]:
    saw, short = random_saw(rng), random_saw(rng)
    short = Hacksaw(short.r1y, short.r2, r3=(short.r1y + short.r2) * rng.uniform(0.6, 0.8))
    crank = random_crank(rng)
    normal = []
    while len({tuple(rule(*case.args)[1] for case in normal) for rule in OTHER_RULES}) < len(OTHER_RULES):
        normal = [
            point_case(rng, 0.075, (5e-3, 1e-1), next_step=2e-6),  # two iterations fewer than with the default tol
            point_case(rng, 7.5, (1e-7, 1e-4)),
            between_two_lengths(rng, turns=int(rng.choice([-1, 1]))),
        ]
    lowest = np.array([-TURN / 4 + rng.uniform(-0.1, 0.1), *crank[1:]])  # the crank pin is furthest from the guide
    seed = np.concatenate((np.array([-short.r2, -0.5, 2.5]) * rng.uniform(0.9, 1.1, 3), rng.uniform(-1, 1, 6)))
    upright = state_of(saw, crank) * ([0] + [1] * 8)
    return [
        *normal,
        nearly_dependent(rng),
        Case((*equations(short), lowest, seed, 1e-6), kind="failing", label="a loop that is open"),
        Case((*equations(saw), crank, upright, 1e-6), kind="failing", label="a seed with r1 = 0, a singular Jacobian"),
    ]


def is_the_state(trial: Trial, right: Trial) -> str | None:
    got = told(trial, (9,))
    if isinstance(got, str):
        return got
    near = Tolerance(0.0, "the state is known to about tol", absolute=10 * trial.case.args[4])
    return difference(right.outcome.value[0], got[0], near)


def stops_on_the_step(trial: Trial, right: Trial) -> str | None:
    got = told(trial, (9,))
    if isinstance(got, str):
        return got
    more = consecutive.looks(trial) - consecutive.looks(right)
    if more < 0 or more > 1:  # one more look, at the end, is forgiven
        return f"it looks at {abs(more)} state{'s' * (abs(more) > 1)} {'more' if more > 0 else 'fewer'}"
    # what the last step leaves is far less
    taken = np.abs(got[0] - right.outcome.value[0]).max() < 0.05 * trial.case.args[4]
    return None if taken else "the step that proves convergence is not taken"


def tells_its_effort(trial: Trial, right: Trial) -> str | None:
    got = told(trial, (9,))
    if isinstance(got, str):
        return got
    looked = [np.asarray(x) for x, *_ in trial.evaluations[0] if np.shape(x) == (9,)]
    # how the stop is chosen is looked at elsewhere
    return fault_of_the_effort(looked, *got, tol=np.nan)


def solves_and_does_not_invert(trial: Trial, right: Trial) -> str | None:
    got = told(trial, (9,))
    if isinstance(got, str):
        return got
    residual, jacobian, crank, seed, _ = trial.case.args
    path = [x for x in trial.path() if x.shape == (9,)]
    if len(path) < 2 or not np.isfinite(path[1]).all():
        return "there is no second look, from which the first step could be seen"
    matrix, step = jacobian(seed, crank), seed - path[1]
    left = np.linalg.norm(matrix @ step - residual(seed, crank)) / (np.linalg.norm(matrix) * np.linalg.norm(step))
    # elimination leaves some 1e-16 of this whatever the condition; an inverse leaves 1e-16 times the condition, 1e-6
    if left < 1e-11:
        return None
    return f"the first step leaves {left:.0e} of the scale, where a solve leaves less than 1e-15: is an inverse formed?"


def fails_aloud(trial: Trial, right: Trial) -> str | None:
    match trial.outcome:
        case Raised() as raised if raised.is_a("ArithmeticError"):
            return None
        case Raised(type=name):
            return f"it raised {name}, which is no ArithmeticError"
        case _:
            return "it returned a value where there is no state to be found"


def errors(trial: Trial, right: Trial) -> np.ndarray | None:
    """Distance of each state that was looked at from the right one; None where there are none."""
    looked = [x for x in trial.path(MOST_DRAWN) if x.shape == (9,)]
    if isinstance(right.outcome, Raised) or len(looked) < 2:
        return None
    with np.errstate(all="ignore"):
        return np.linalg.norm(looked - right.outcome.value[0], axis=1)


def iterated(until: Callable, told_error: Callable | None = None, count_from: int = 0) -> Callable:
    """A solver with a stopping rule and a report of its own.

    until : (step, residual before it, residual behind it, tol) -> whether this was the last step
    told_error : (step, residual before it) -> the error that is told; left out, the 2-norm of the step
    """

    def solver(residual, jacobian, crank, seed, tol=1e-6):
        x = np.array(seed, dtype=float)
        for k in range(1, 51):
            before = residual(x, crank)
            step = np.linalg.solve(jacobian(x, crank), before)
            x = x - step
            if until(step, before, lambda at=x: residual(at, crank), tol):
                error = told_error(step, before) if told_error else np.linalg.norm(step)
                return x, k + count_from, error
        raise ConvergenceError("no state", None)

    return solver


def by_the_step(step, before, behind, tol) -> bool:
    return np.linalg.norm(step) < tol


def on_the_residual(residual, jacobian, crank, seed, tol=1e-6):
    """It looks before it steps, and tells the residual that it stops on."""
    x = np.array(seed, dtype=float)
    for k in range(50):
        size = np.linalg.norm(residual(x, crank))
        if size < tol:
            return x, k, size
        x = x - np.linalg.solve(jacobian(x, crank), residual(x, crank))
    raise ConvergenceError("no state", None)


on_the_residual_behind = iterated(lambda step, before, behind, tol: np.linalg.norm(behind()) < tol)
by_the_largest_entry = iterated(lambda step, before, behind, tol: np.abs(step).max() < tol)
by_the_positions = iterated(lambda step, before, behind, tol: np.linalg.norm(step[:3]) < tol)
OTHER_RULES = (on_the_residual_behind, by_the_largest_entry, by_the_positions)  # each must stop somewhere else


def without_the_last_step(residual, jacobian, crank, seed, tol=1e-6):
    path = newton(lambda x: residual(x, crank), lambda x: jacobian(x, crank), seed, tol)
    return path.history[-2], path.iterations, path.errors[-1]


ONE_POINT = Task(
    name="one_point",
    title="one point, all nine unknowns together",
    function="one_point",
    reference=one_point,
    cases=point_cases,
    agree=same_effort,
    tolerance=SETTLED,
    section="hacksaw-simultaneous: One point",
    errors=errors,
    aspects=(
        Aspect("it is the state on the branch and the turn of the seed", 1.0, is_the_state),
        Aspect("it stops at the first step whose 2-norm is below tol, and takes that step", 0.75, stops_on_the_step),
        Aspect("iterations and error are the number of its steps and the 2-norm of the last", 0.5, tells_its_effort),
        Aspect("each step is solved for, and no inverse is formed", 0.25, solves_and_does_not_invert, kind="ill"),
        Aspect(
            "it raises ConvergenceError where the loop cannot close or the Jacobian is singular",
            0.5,
            fails_aloud,
            kind="failing",
        ),
    ),
    variants=(
        Variant(
            "The step has the wrong sign",
            "J d = F gives the step that must be taken from the state.",
            lambda f, j, *rest: one_point(f, lambda *at: -j(*at), *rest),
            by_path=True,
        ),
        Variant(
            "The Jacobian is transposed",
            "Row i belongs to equation i: which index is the unknown's?",
            lambda f, j, *rest: one_point(f, lambda *at: j(*at).T, *rest),
            by_path=True,
        ),
        Variant(
            "The Jacobian of the seed is used in every step",
            "Where must the Jacobian be evaluated in each step?",
            lambda f, j, crank, seed, *rest: one_point(f, lambda *at: j(seed, crank), crank, seed, *rest),
            share=0.25,
            by_path=True,
        ),
        Variant(
            "The blocks outside of the diagonal are left out of the Jacobian",
            "It converges, two iterations later. The three levels are one system: solve it as it is given.",
            lambda f, j, *rest: one_point(f, lambda *at: j(*at) * np.kron(np.eye(3), np.ones((3, 3))), *rest),
            share=0.25,
            by_path=True,
        ),
        Variant(
            "A single step is taken",
            "One step solves a linear system. Are all nine equations linear?",
            iterated(lambda *_: True),
        ),
        *readings(
            "It stops when the residual is small, and not when the step is",
            "The residual holds lengths of the loop and their rates, and tol bounds a step of the unknowns.",
            on_the_residual,
            on_the_residual_behind,
            share=0.5,
        ),
        Variant(
            "The largest entry of the step is compared with tol, and not its 2-norm",
            "Which length of a vector does the task ask for?",
            by_the_largest_entry,
            share=0.5,
        ),
        Variant(
            "The step of the positions alone is compared with tol",
            "When the positions have come to rest, the velocities and accelerations still move.",
            by_the_positions,
            share=0.5,
        ),
        Variant(
            "The last step is not taken",
            "The step that proves convergence is known: its end is far nearer to the state.",
            without_the_last_step,
            share=0.5,
        ),
        Variant(
            "The iterations are counted from zero",
            "Each step is an iteration, the last one too: how many are there after the first?",
            iterated(by_the_step, count_from=-1),
            share=0.75,
        ),
        Variant(
            "The norm of the residual is returned where that of the step is asked for",
            "The error is a length of the step. What does `residual` give?",
            iterated(by_the_step, lambda step, before: np.linalg.norm(before)),
            share=0.75,
        ),
        *slips_of_the_states(one_point),
    ),
)

# --- all_points -------------------------------------------------------------------------------------------------------


def along(solver: Callable) -> Callable:
    """The sweep that solves each point from the one before."""

    def sweep(residual, jacobian, crank, seed, tol=1e-6) -> Told:
        found = []
        for k, at in enumerate(np.transpose(crank)):
            try:
                found.append(solver(residual, jacobian, at, found[-1][0] if found else seed, tol))
            except ConvergenceError as why:
                raise ConvergenceError(f"point {k}: {why}", why.path) from None
        return columns(found)

    return sweep


def columns(points: list[tuple]) -> Told:
    return tuple(np.array(column) for column in zip(*points, strict=True))


all_points = along(one_point)


def cold(residual, jacobian, crank, seed, tol=1e-6) -> Told:
    return columns([one_point(residual, jacobian, at, seed, tol) for at in np.transpose(crank)])


one_step_everywhere = along(iterated(lambda *_: True))


def one_step_each(residual, jacobian, crank, seed, tol=1e-6) -> Told:
    first = one_point(residual, jacobian, crank[:, 0], seed, tol)
    rest = one_step_everywhere(residual, jacobian, crank[:, 1:], first[0])
    return tuple(np.concatenate(([one], others)) for one, others in zip(first, rest, strict=True))


def motion(rng: np.random.Generator, theta2: np.ndarray) -> np.ndarray:
    """Constant angular acceleration through these angles, in the direction in which they run; shape (3, points)."""
    direction = np.sign(theta2[-1] - theta2[0])
    alpha2 = direction * rng.uniform(2, 5)
    omega2 = direction * np.sqrt(rng.uniform(2, 4) ** 2 + 2 * alpha2 * (theta2 - theta2[0]))
    return np.stack((theta2, omega2, np.full_like(theta2, alpha2)))


def lost_when_cold(rng: np.random.Generator) -> Case:
    """A seed that is good at the first point and leads astray further on.

    A cold start ends elsewhere at some of the points, and a change of the seed by round-off does not change where. No
    step, warm or cold, is so near to the tolerance that rounding decides when to stop.
    """
    n, tol = int(rng.integers(9, 12)), 10 ** rng.uniform(-5, -4)
    while True:
        saw = random_saw(rng)
        turned = rng.choice([-1, 1]) * np.linspace(0, rng.uniform(0.7, 0.9) * TURN, n)
        theta2 = rng.uniform(-TURN / 2, TURN / 2) + turned
        right = saw.position(theta2)
        r1, theta1, _ = right[0]
        seed = np.array([r1 * rng.uniform(0.8, 1.2), theta1 + rng.uniform(-0.2, 0.2), rng.uniform(1.9, 2.3)])
        found, *shifted = consecutive.ends(saw, theta2, np.outer((1, 1 - 1e-9, 1 + 1e-9), seed))
        astray = (np.abs(found - right).max(axis=1) > 1e-3).sum()
        sure = all(np.abs(other - found).max() < 1e-6 for other in shifted)  # nan is not
        if np.abs(found[0] - right[0]).max() > 1e-9 or astray < 3 or not sure:
            continue
        crank, seed = motion(rng, theta2), np.concatenate((seed, rng.uniform(-1, 1, 6)))
        residual, jacobian = equations(saw)
        states, _, last = all_points(residual, jacobian, crank, seed, tol)
        starts = np.vstack((seed, states[:-1], np.tile(seed, (n, 1))))
        paths = [path_or_none(residual, jacobian, *pair) for pair in zip([*crank.T, *crank.T], starts, strict=True)]
        if any(p is None or (np.abs(np.log(p.errors / tol)) < 0.1).any() for p in paths):
            continue
        another_tol_shows = last.max() > 3e-6
        if another_tol_shows and np.abs(states - state_of(saw, crank)).max() < tol:
            label = f"{n} crank angles, a crank of {saw.r2:.4f} m; a cold start is astray at {astray} of them"
            return Case((residual, jacobian, crank, seed, tol), label=label)


def opens_on_the_way(rng: np.random.Generator) -> Case:
    """A coupler that is too short for some crank angles; each angle is clearly on one side."""
    while True:
        saw = random_saw(rng)
        saw = Hacksaw(saw.r1y, saw.r2, r3=(saw.r1y + saw.r2) * rng.uniform(0.8, 0.95))
        theta2 = TURN / 4 + np.linspace(0, TURN / 2, 32) + rng.uniform(0, 0.05)
        first = int(np.argmax(saw.gap(theta2) > 0))
        last = saw.gap(theta2[first - 1]) / saw.r3
        # no number of iterations, and none of unknowns, is taken for the index
        if last < -0.015 and saw.gap(theta2[first]) / saw.r3 > 0.01 and first > 10 and first % 5:
            crank = motion(rng, theta2)
            seed = state_of(saw, crank[:, 0]) * rng.uniform(0.95, 1.05, 9)
            args = (*equations(saw), crank, seed, 1e-6)
            return Case(args, kind="open", label="a loop that opens on the way")


def sweep_cases(rng: np.random.Generator) -> list[Case]:
    return [lost_when_cold(rng), opens_on_the_way(rng)]


def follows_the_saw(trial: Trial, right: Trial) -> str | None:
    got = told(trial, right.outcome.value[0].shape)
    if isinstance(got, str):
        return got
    near = Tolerance(0.0, "each state is known to about tol", absolute=10 * trial.case.args[4])
    return difference(right.outcome.value[0], got[0], near)


def looked_at(trial: Trial) -> list[list[np.ndarray]]:
    """The states at which the equations were evaluated, for each point of the motion."""
    crank = trial.case.args[2]
    log = [(x, at) for x, *rest in trial.evaluations[0] for at in rest if np.shape(x) == (9,) and np.shape(at) == (3,)]
    return [[x for x, at in log if np.abs(at - point).max() < 1e-9] for point in crank.T]


def tells_every_effort(trial: Trial, right: Trial) -> str | None:
    got = told(trial, right.outcome.value[0].shape)
    if isinstance(got, str):
        return got
    for k, (looked, *point) in enumerate(zip(looked_at(trial), *got, strict=True)):
        if why := fault_of_the_effort(looked, *point, tol=trial.case.args[4]):
            return f"at index {k}: {why}"
    return None


def starts_warm(trial: Trial, right: Trial) -> str | None:
    """Each point is begun about as near to its position as the one before is, or nearer.

    A line through the last two positions misses by a second difference, which is no more than twice a first one. The
    velocities and accelerations follow from any start: they stand in the system linearly.
    """
    positions = right.outcome.value[0][:, :3]
    steps = np.linalg.norm(np.diff(positions, axis=0), axis=1)
    for k, looked in enumerate(looked_at(trial)):
        if not looked:
            return f"the equations are never evaluated for the crank of index {k}"
        if k and np.linalg.norm(looked[0][:3] - positions[k]) > 2 * steps[max(k - 2, 0) : k].max():
            return f"the iteration at index {k} starts far from the position before it"
    return None


def counted(change: Callable) -> Callable:
    """The sweep with another count of iterations."""

    def sweep(*args) -> Told:
        states, iterations, last = all_points(*args)
        return states, change(iterations), last

    return sweep


ALL_POINTS = Task(
    name="all_points",
    title="along a motion, with iterations and errors",
    function="all_points",
    reference=all_points,
    cases=sweep_cases,
    agree=same_effort,
    tolerance=SETTLED,
    section="hacksaw-simultaneous: Along the motion",
    aspects=(
        Aspect("a state for every point, all on the branch and the turn of the first", 1.25, follows_the_saw),
        Aspect(
            "iterations and last error of each point are told, and each stops at the first step below tol",
            0.75,
            tells_every_effort,
        ),
        Aspect("each point starts from the position before it, or from a better guess", 0.5, starts_warm),
        Aspect(
            "it raises ConvergenceError, with the index, where the loop opens", 0.5, consecutive.says_where, kind="open"
        ),
    ),
    variants=(
        Variant(
            "Every point starts from the seed",
            "Only the first point starts from the seed. What is known when the second begins?",
            cold,
            share=0.25,
        ),
        *readings(
            "One step is taken at each point",
            "A small step of the crank needs few iterations. Does one of them reach tol?",
            one_step_each,
            one_step_everywhere,
            share=0.25,
        ),
        Variant(
            "The last point is missing",
            "There are as many states as columns of the crank.",
            lambda *args: tuple(column[:-1] for column in all_points(*args)),
            share=0.5,
        ),
        Variant(
            "The seed is returned as the first state, and all others are late by one",
            "The seed is a guess. Is the state stored before it is solved for?",
            lambda f, j, crank, seed, *rest: states_changed(all_points, lambda x: np.vstack((seed, x[:-1])))(
                f, j, crank, seed, *rest
            ),
            share=0.5,
        ),
        Variant(
            "Rows and columns are exchanged in the states",
            "A row holds one state.",
            states_changed(all_points, np.transpose),
            share=0.5,
        ),
        Variant(
            "The iterations are counted from zero",
            "Each step is an iteration, the last one too: how many are there after the first?",
            counted(lambda iterations: iterations - 1),
            share=0.75,
        ),
        Variant(
            "The count of iterations is not set back between the points",
            "The iterations of each point are asked for. What is the count when a point begins?",
            counted(np.cumsum),
            share=0.75,
        ),
        Variant(
            "The errors are norms of the residual, and not of the step",
            "The error is a length of the last step. What does `residual` give?",
            along(iterated(by_the_step, lambda step, before: np.linalg.norm(before))),
            share=0.75,
        ),
        *slips_of_the_states(all_points),
    ),
)

EXERCISE = Exercise(
    name="06_simultaneous",
    title="The power hacksaw, all nine unknowns at once",
    tasks=(NINE_EQUATIONS, NINE_JACOBIAN, ONE_POINT, ALL_POINTS),
    imports=("motion", "newton", "require"),  # the motor's profile needs the last
)
