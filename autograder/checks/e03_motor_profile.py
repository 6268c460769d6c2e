"""Exercise 3: the run-up of a motor."""

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.polynomial import polyder, polyval
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import PPoly

from autograder.checks.answers import array, refuses
from autograder.compare import Tolerance, difference, disagreement, numbers
from autograder.outcome import Lost, Outcome, Raised, Value
from autograder.spec import Aspect, Case, Exercise, Task, Trial, Variant, readings
from mechlib.motion import MotorProfile

ROUND_OFF = Tolerance(1e-8, "exact integration leaves round-off, some 1e-15 of the scale")

# --- integrate_pieces -------------------------------------------------------------------------------------------------


def joined(k: int, rows: np.ndarray, ends: np.ndarray) -> float:
    """The constant that makes piece k begin where the piece before it ends."""
    return polyval(ends[k], rows[k - 1]) - polyval(ends[k], rows[k]) if k else 0.0


def forgotten(k: int, rows: np.ndarray, ends: np.ndarray) -> float:
    return 0.0


def ended_where_the_last_does(k: int, rows: np.ndarray, ends: np.ndarray) -> float:
    return (polyval(ends[k + 1], rows[k - 1]) if k else 0.0) - polyval(ends[k + 1], rows[k])


def joined_at_the_far_end(k: int, rows: np.ndarray, ends: np.ndarray) -> float:
    """The same, but for the first piece, which begins at zero."""
    return ended_where_the_last_does(k, rows, ends) if k else 0.0


def own_value_left_in(k: int, rows: np.ndarray, ends: np.ndarray) -> float:
    return polyval(ends[k], rows[k - 1]) if k else 0.0


def antiderivative(ends: np.ndarray, pieces: np.ndarray, constant: Callable = joined) -> np.ndarray:
    """Ascending coefficients of the integral of polynomial pieces, a row each."""
    rows = np.column_stack((np.zeros(len(pieces)), pieces / np.arange(1, pieces.shape[1] + 1)))
    for k in range(len(rows)):
        rows[k, 0] = constant(k, rows, ends)
    return rows


def integrated(ends, alpha, of_omega=joined, of_theta=joined) -> tuple[np.ndarray, np.ndarray]:
    ends, alpha = np.asarray(ends), np.asarray(alpha)
    omega = antiderivative(ends, alpha, of_omega)
    return omega, antiderivative(ends, omega, of_theta)


def undivided(ends, alpha):
    """The power is raised, and the coefficient left as it is."""

    def raised(pieces):
        return antiderivative(ends, pieces * np.arange(1, pieces.shape[1] + 1))

    omega = raised(alpha)
    return omega, raised(omega)


def shifted(rows: np.ndarray, by: np.ndarray) -> np.ndarray:
    """Ascending coefficients in t of polynomials in t + by, a row each."""
    whole = [Polynomial(row)(Polynomial([shift, 1.0])).coef for row, shift in zip(rows, by, strict=False)]
    return np.array([np.pad(row, (0, rows.shape[1] - len(row))) for row in whole])


def in_local_time(ends, alpha):
    """Right, but each row counts the time from the start of its piece."""
    return tuple(shifted(rows, ends) for rows in integrated(ends, alpha))


def read_in_local_time(ends, alpha):
    return integrated(ends, shifted(alpha, -ends))


def all_in_local_time(ends, alpha):
    """What scipy's PPoly makes of the coefficients: to it they are powers of the time since the start of the piece."""
    omega = PPoly(alpha[:, ::-1].T, ends).antiderivative()
    return omega.c[::-1].T, omega.antiderivative().c[::-1].T


def read_in_descending_order(ends, alpha):
    omega, theta = integrated(ends, alpha[:, ::-1])
    return omega[:, ::-1], theta[:, ::-1]


def piece_cases(rng: np.random.Generator) -> list[Case]:
    cases = []
    for pieces, k in ((3, 2), (4, 3), (2, 2)):
        ends = np.concatenate(([0.0], np.cumsum(rng.uniform(0.4, 1.2, pieces))))
        alpha = rng.uniform(0.5, 3, (pieces, k)) * rng.choice([-1, 1], (pieces, k))
        cases.append(Case((ends, alpha), label=f"{pieces} pieces of degree {k - 1}, ends at {ends.round(3)}"))
    return cases


def pair(answer: object, pieces: int) -> tuple[np.ndarray, np.ndarray] | str:
    """Omega and theta as they were returned, or a sentence that says what came instead."""
    if not isinstance(answer, (tuple, list)) and not (isinstance(answer, np.ndarray) and answer.ndim):
        return "it is not a pair (omega, theta)"
    if len(answer) != 2:
        return f"it has {len(answer)} parts, and not the two of (omega, theta)"
    found = []
    for name, part in zip(("omega", "theta"), answer, strict=True):
        rows = numbers(part)
        if isinstance(rows, str):
            return f"{name}: {rows}"
        if rows.ndim != 2 or len(rows) != pieces:
            return f"{name}: its shape is {rows.shape}, and it needs a row for each of the {pieces} pieces"
        if not np.isfinite(rows).all():
            return f"{name}: a coefficient is not finite"
        found.append(rows)
    return found[0], found[1]


def same_pieces(expected: Outcome, got: Outcome) -> str | None:
    """Both polynomials of every piece; a power that does not occur may have a coefficient of zero."""
    if not (isinstance(expected, Value) and isinstance(got, Value)):
        return disagreement(expected, got, ROUND_OFF)
    answer = pair(got.value, len(expected.value[0]))
    if isinstance(answer, str):
        return answer
    for name, right, rows in zip(("omega", "theta"), expected.value, answer, strict=True):
        width = max(right.shape[1], rows.shape[1])
        right, rows = (np.pad(each, ((0, 0), (0, width - each.shape[1]))) for each in (right, rows))
        if fault := difference(right, rows, ROUND_OFF):
            return f"{name}: {fault}"
    return None


def found_pair(trial: Trial) -> tuple[np.ndarray, np.ndarray] | str:
    if isinstance(trial.outcome, Raised):
        return f"it raised {trial.outcome.type}"
    assert isinstance(trial.outcome, Value)
    return pair(trial.outcome.value, len(trial.case.args[1]))


def differentiates_back(trial: Trial, right: Trial) -> str | None:
    answer = found_pair(trial)
    if isinstance(answer, str):
        return answer
    ends, alpha = trial.case.args
    for name, rows, of, derivative in (("omega", answer[0], "alpha", alpha), ("theta", answer[1], "omega", answer[0])):
        for k, (row, wanted) in enumerate(zip(rows, derivative, strict=True)):
            instants = np.linspace(ends[k], ends[k + 1], 7)
            if difference(polyval(instants, wanted), polyval(instants, polyder(row)), ROUND_OFF):
                return f"the derivative of {name} is not {of} in piece {k}"
    return None


def has_no_jump(trial: Trial, right: Trial, which: int) -> str | None:
    answer = found_pair(trial)
    if isinstance(answer, str):
        return answer
    ends, rows = trial.case.args[0], answer[which]
    scale = max(np.abs(polyval(ends[k : k + 2], row)).max() for k, row in enumerate(rows))
    before = [0.0, *(polyval(end, row) for end, row in zip(ends[1:-1], rows, strict=False))]
    for k, (row, value) in enumerate(zip(rows, before, strict=True)):
        if abs(polyval(ends[k], row) - value) > 1e-8 * scale:
            return "it does not begin at zero" if k == 0 else f"it jumps from piece {k - 1} to piece {k}"
    return None


INTEGRATE_PIECES = Task(
    name="integrate_pieces",
    title="integrate an acceleration that is given in pieces",
    function="integrate_pieces",
    reference=integrated,
    cases=piece_cases,
    agree=same_pieces,
    tolerance=ROUND_OFF,
    section="motor-profile: Integrate piece by piece",
    aspects=(
        Aspect("in each piece the derivative of omega is alpha, and that of theta is omega", 1.0, differentiates_back),
        Aspect("omega begins at zero and does not jump", 1.0, partial(has_no_jump, which=0)),
        Aspect("theta begins at zero and does not jump", 1.0, partial(has_no_jump, which=1)),
    ),
    variants=(
        Variant(
            "The constants of integration are forgotten",
            "Each piece has a constant of its own. What must be true of the speed where two pieces meet?",
            lambda *args: integrated(*args, of_omega=forgotten, of_theta=forgotten),
            share=0.25,
        ),
        Variant(
            "The angle has no constants of integration",
            "The speed is continuous here. Is the angle?",
            lambda *args: integrated(*args, of_theta=forgotten),
            share=0.5,
        ),
        Variant(
            "The speed has no constants of integration",
            "The angle is continuous here. Is the speed that it is integrated from?",
            lambda *args: integrated(*args, of_omega=forgotten),
            share=0.25,
        ),
        *readings(
            "The pieces are joined at the wrong end",
            "At which instant does a piece meet the one before it?",
            lambda *args: integrated(*args, joined_at_the_far_end, joined_at_the_far_end),
            lambda *args: integrated(*args, ended_where_the_last_does, ended_where_the_last_does),
            share=0.25,
        ),
        Variant(
            "The value at the end of the last piece is added, whatever the new piece has there already",
            "At its start the antiderivative of a piece need not be zero. What must its constant make up for?",
            lambda *args: integrated(*args, own_value_left_in, own_value_left_in),
            share=0.25,
        ),
        Variant(
            "The results are polynomials of the time since the start of the piece",
            "The task counts t from the start of the motion in every piece.",
            in_local_time,
            share=0.5,
        ),
        Variant(
            "Acceleration and results are polynomials of the time since the start of the piece",
            "The task counts t from the start of the motion in every piece. SciPy's PPoly does not.",
            all_in_local_time,
            share=0.25,
        ),
        Variant(
            "The acceleration is read as a polynomial of the time since the start of the piece",
            "The task counts t from the start of the motion in every piece. SciPy's PPoly does not.",
            read_in_local_time,
            share=0.25,
        ),
        Variant(
            "The results are in descending order",
            "Where does the constant stand? `sp.Poly(...).all_coeffs()` begins with the highest power.",
            lambda *args: tuple(rows[:, ::-1] for rows in integrated(*args)),
            share=0.5,
        ),
        Variant(
            "The coefficients are read and returned in descending order",
            "The task gives the constant first. NumPy's `polyint` and `poly1d` want it last.",
            read_in_descending_order,
            share=0.25,
        ),
        *readings(
            "It is integrated once",
            "The acceleration is the second derivative of the angle.",
            lambda ends, alpha: (alpha, integrated(ends, alpha)[0]),
            lambda ends, alpha: (integrated(ends, alpha)[0],) * 2,
            share=0.25,
        ),
        Variant(
            "Theta comes first, and omega second",
            "In which order does the task ask for them?",
            lambda *args: integrated(*args)[::-1],
            share=0.5,
        ),
        Variant(
            "The coefficients are not divided by the new power",
            "Differentiate t^2: which factor comes down?",
            undivided,
        ),
    ),
)

# --- first_turn -------------------------------------------------------------------------------------------------------


def turn_cases(rng: np.random.Generator) -> list[Case]:
    cases = []
    for turns in (1.0, float(rng.integers(2, 9)), rng.uniform(0.2, 0.8)):
        peak = rng.uniform(6, 20)  # the source has 5
        cases.append(Case((peak, turns), label=f"turns = {turns:.3g}, peak = {peak:.3g} rad/s^2"))
    peak, turns = rng.uniform(1, 9, 2)
    slow = rng.uniform(0.2, 0.8)
    cases.append(Case((slow, turns), label=f"turns = {turns:.3g}, peak = {slow:.3g} rad/s^2"))
    bad = ((-peak, turns), "a negative peak"), ((0.0, turns), "no peak"), ((peak, 0.0), "no turn")
    bad += (((peak, -turns), "turns backwards"),)
    return [*cases, *(Case(args, kind="bad", label=label) for args, label in bad)]


def first_turn(peak: float, turns: float) -> float:
    if not turns > 0:
        raise ValueError(f"turns must be positive, got {turns}")
    return MotorProfile.through(2 * np.pi * turns, peak).T


FIRST_TURN = Task(
    name="first_turn",
    title="the duration of a run-up that turns through so many turns",
    function="first_turn",
    reference=first_turn,
    cases=turn_cases,
    tolerance=Tolerance(1e-6, "a formula is right to round-off, a root-finder to its tolerance"),
    section="motor-profile: How long is one turn?",
    aspects=(
        Aspect("the run-up of that duration turns through that angle", 0.75),
        Aspect(
            "it refuses a peak or a number of turns that is not positive with a ValueError that holds the value",
            0.25,
            refuses(lambda *args: tuple(arg for arg in args if arg <= 0), ROUND_OFF),
            kind="bad",
        ),
    ),
    variants=(
        Variant(
            "The turns are taken for radians",
            "The formulas of the angle hold in radians. How many has one turn?",
            lambda peak, turns: np.sqrt(3 * turns / peak),
            share=0.25,
        ),
        Variant(
            "The turns are made degrees",
            "The acceleration is in rad/s^2. How many radians has one turn?",
            lambda peak, turns: np.sqrt(3 * 360 * turns / peak),
            share=0.25,
        ),
        Variant(
            "The acceleration is at its peak all the time",
            "Peak T^2/2 is the angle of a constant acceleration. How much does the trapezoid lose?",
            lambda peak, turns: np.sqrt(4 * np.pi * turns / peak),
        ),
        Variant(
            "The shaft has its final speed all the time",
            "It starts from rest. What is the mean speed of the run-up?",
            lambda peak, turns: np.sqrt(3 * np.pi * turns / peak),
        ),
        Variant(
            "The speed at T is set to the angle",
            "Read the condition again: of which quantity is it?",
            lambda peak, turns: 3 * np.pi * turns / peak,
        ),
        Variant(
            "The square root is missing",
            "Peak is in rad/s^2: what are the units of an angle divided by it?",
            lambda peak, turns: 6 * np.pi * turns / peak,
            share=0.25,
        ),
        Variant(
            "The negative root",
            "The equation for T has two solutions. Which of them is a duration?",
            lambda peak, turns: -np.sqrt(6 * np.pi * turns / peak),
            share=0.5,
        ),
        Variant(
            "The peak is 5 rad/s^2 whichever is asked for",
            "Is the number of the source still in the formula?",
            lambda peak, turns: np.sqrt(6 * np.pi * turns / 5),
            share=0.25,
        ),
        Variant(
            "The number of turns is not used",
            "The formula of the source holds for one turn.",
            lambda peak, turns: np.sqrt(6 * np.pi / peak),
            share=0.25,
        ),
    ),
)

# --- motor_profile ----------------------------------------------------------------------------------------------------


def motor_profile(t, T, peak) -> np.ndarray:
    instants, place = np.unique(t, return_inverse=True)
    motion = MotorProfile(T, peak).at(instants)
    return np.column_stack((motion.acceleration, motion.velocity, motion.position))[place]


def run_up(T: float, peak: float) -> tuple[np.ndarray, np.ndarray]:
    """Ends of the four pieces, and the coefficients of the acceleration."""
    slope = 3 * peak / T
    return T / 3 * np.arange(5), np.array([[0, slope], [peak, 0], [3 * peak, -slope], [0, 0]])


def exchanged(alpha=None, omega=None, theta=None, of_omega=joined, of_theta=joined) -> Callable:
    """The profile with some of its rows exchanged: each argument is a function of T and peak that gives rows by piece.

    A row of alpha is integrated like a right one; a row of omega or theta stands as it is.
    """

    def change(rows, changes, T, peak):
        for k, row in changes(T, peak).items() if changes else ():
            rows[k] = row

    def profile(t, T, peak):
        t = np.asarray(t)
        ends, of_alpha = run_up(T, peak)
        change(of_alpha, alpha, T, peak)
        speed, angle = integrated(ends, of_alpha, of_omega, of_theta)
        change(speed, omega, T, peak)
        change(angle, theta, T, peak)
        piece = np.clip(np.searchsorted(ends, t, side="right") - 1, 0, 3)
        columns = [
            (rows[piece] * t[:, None] ** np.arange(rows.shape[1])).sum(axis=1) for rows in (of_alpha, speed, angle)
        ]
        return np.column_stack(columns)

    return profile


# The pieces of source A's equation (5), with its 5 rad/s^2 as the peak
PRINTED: dict[int, Callable] = {
    0: lambda T, peak: [0, 0, 0, peak / 6],
    1: lambda T, peak: [peak * T**2 / 6, -peak * T / 6, peak / 2, 0],
    2: lambda T, peak: [peak * T**2 / 6, -5 * peak * T / 6, 3 * peak / (2 * T), -peak / (6 * T)],
}


def printed(*pieces: int) -> Callable:
    return exchanged(theta=lambda T, peak: {k: PRINTED[k](T, peak) for k in pieces})


def after(value: Callable, late: np.ufunc = np.greater) -> Callable:
    """The profile, with what comes after T exchanged: three columns from t - T and the row at T."""

    def profile(t, T, peak):
        those = late(t, T)
        found = motor_profile(np.append(t, T), T, peak)
        found, end = found[:-1], found[-1]
        found[those] = np.transpose(np.broadcast_arrays(*value(np.asarray(t)[those] - T, end)))
        return found

    return profile


def last_condition_wins(t, T, peak):
    """numpy.piecewise with the conditions of the source's listing: where several are true, the last one counts."""
    t, found = np.asarray(t), motor_profile(t, T, peak)
    steady = 2 * peak * T / 3
    found[:, 1] = np.where(t <= T, steady, 0)
    found[:, 2] = np.where(t <= T, steady * t - peak * T**2 / 3, 0)
    return found


def steady_before_the_end(t, T, peak):
    t, steady = np.asarray(t), 2 * peak * T / 3
    before = t < T
    return np.column_stack((0 * t, steady * before, (steady * t - peak * T**2 / 3) * before))


def between_two_pieces(t, T, peak):
    gap = np.isin(t, run_up(T, peak)[0][1:4])
    return np.where(gap[:, None], 0.0, motor_profile(t, T, peak))


def turned_in_the_third_piece(t, T, peak):
    """The other sign in the formula of alpha, and in no other."""
    t, found = np.asarray(t), motor_profile(t, T, peak)
    found[(t >= 2 * T / 3) & (t < T), 0] *= -1
    return found


def summed_in_steps(t, T, peak):
    """The sums of a loop, with the value at the end of each step."""
    step, alpha = np.diff(t, prepend=0), motor_profile(t, T, peak)[:, 0]
    omega = np.cumsum(alpha * step)
    return np.column_stack((alpha, omega, np.cumsum(omega * step)))


def summed_up(t, T, peak):
    alpha = motor_profile(t, T, peak)[:, 0]
    omega = cumulative_trapezoid(alpha, t, initial=0)
    return np.column_stack((alpha, omega, cumulative_trapezoid(omega, t, initial=0)))


def profile_cases(rng: np.random.Generator) -> list[Case]:
    cases = []
    for most, T in zip((2.0, 1.3, 4.0), rng.permutation([rng.integers(10, 20), *rng.integers(30, 80, 2)]), strict=True):
        T = 3 * T / 64  # T/3 is exact: no rounding puts an end of a piece on its other side
        peak = rng.uniform(6, 12)
        inside = (np.arange(3)[:, None] + [*rng.uniform(0.1, 0.9, 2), rng.uniform(0.95, 0.99)]).ravel() * T / 3
        ends = T / 3 * np.arange(4)
        t = np.concatenate((inside, ends, rng.uniform(1.05, most, 4) * T))
        label = f"{len(t)} instants up to {t.max():.3g} s, T = {T:.4g} s, peak = {peak:.3g} rad/s^2"
        cases.append(Case((np.sort(t) if most == 2 else rng.permutation(t), T, peak), label=label))
    t = rng.uniform(0.1, 3, 4)
    for bad in (-0.1, np.nan, np.inf):
        cases.append(Case((np.append(t, bad), T, peak), kind="bad", label=f"an instant t = {bad}"))
    return [*cases, *(Case((t, bad, peak), kind="bad", label=f"T = {bad}") for bad in (0.0, -1.5))]


def right_rows(trial: Trial, right: Trial, where: Callable) -> str | None:
    """Whether the rows agree at the instants for which where(t, ends) is true."""
    (t, T, peak), expected = trial.case.args, right.outcome.value
    found = array(trial, expected.shape, "(points, 3)")
    if isinstance(found, str):
        return found
    rows = where(t, run_up(T, peak)[0][:4])
    for name, got, wanted in zip(("alpha", "omega", "theta"), found.T, expected.T, strict=True):
        # held to the scale of the whole column: after T alpha is zero
        with_scale = np.append(wanted[rows], np.abs(wanted).max())
        if fault := difference(with_scale, np.append(got[rows], with_scale[-1]), ROUND_OFF):
            return f"{name}: {fault.split(' at index')[0].split(';')[0]}"
    return None


def inside_a_piece(t, ends):
    return (t < ends[-1]) & ~np.isin(t, ends)


def past_the_run_up(t, ends):
    return t > ends[-1]


MOTOR_PROFILE = Task(
    name="motor_profile",
    title="acceleration, speed and angle at any instants",
    function="motor_profile",
    reference=motor_profile,
    cases=profile_cases,
    tolerance=ROUND_OFF,
    section="motor-profile: The profile in numbers",
    aspects=(
        Aspect("alpha, omega and theta are right during the run-up", 2.0, partial(right_rows, where=inside_a_piece)),
        Aspect("from T on the speed stays, and the angle grows", 1.0, partial(right_rows, where=past_the_run_up)),
        Aspect("0, T/3, 2T/3 and T belong to a piece, too", 0.5, partial(right_rows, where=np.isin)),
        Aspect(
            "a negative or not finite t, and a T that is not positive, get a ValueError that holds the value",
            0.5,
            refuses(lambda t, T, peak: (T,) if T <= 0 else (t[-1],), ROUND_OFF),
            kind="bad",
        ),
    ),
    variants=(
        Variant(
            "The angle of the first piece is that of the printed equation (5)",
            "What are the units of that piece? Differentiate it, and compare with omega.",
            printed(0),
            share=0.5,
        ),
        Variant(
            "The angle of the second piece is that of the printed equation (5)",
            "Its derivative is right. Does it begin where the first piece ends?",
            printed(1),
            share=0.5,
        ),
        Variant(
            "The angle of the third piece is that of the printed equation (5)",
            "What are the units of each term? Differentiate it, and compare with omega.",
            printed(2),
            share=0.5,
        ),
        Variant(
            "The angle is that of the printed equation (5)",
            "Differentiate each piece and compare with omega; then see whether the pieces meet.",
            printed(0, 1, 2),
            share=0.5,
        ),
        *readings(
            "After T speed and angle are zero",
            "The motor goes on at the speed it has reached. What does `np.select` give where no condition is true?",
            after(lambda dt, end: (0, 0, 0 * dt)),
            after(lambda dt, end: (0, 0, 0 * dt), np.greater_equal),
            share=0.5,
        ),
        *readings(
            "After T speed and angle are not a number",
            "Which condition of the last piece is true after T?",
            after(lambda dt, end: (0, np.nan, np.nan * dt)),
            after(lambda dt, end: (0, np.nan, np.nan * dt), np.greater_equal),
            share=0.5,
        ),
        Variant(
            "After T the angle stands still",
            "Acceleration zero does not mean speed zero.",
            after(lambda dt, end: (0, end[1], end[2] + 0 * dt)),
            share=0.5,
        ),
        *readings(
            "After T the angle begins again at zero",
            "The last piece has a constant of integration, too.",
            after(lambda dt, end: (0, end[1], end[1] * dt)),
            after(lambda dt, end: (0, end[1], end[1] * dt), np.greater_equal),
            share=0.5,
        ),
        Variant(
            "The third piece goes on after T",
            "From T on the acceleration is zero, and not negative.",
            exchanged(alpha=lambda T, peak: {3: [3 * peak, -3 * peak / T]}),
            share=0.5,
        ),
        *readings(
            "The last piece is used before T, and nothing after it",
            "Its condition is true too early. In `np.piecewise` the last condition that is true counts, in `np.select` "
            "the first.",
            last_condition_wins,
            steady_before_the_end,
        ),
        *readings(
            "The acceleration of the third piece has the wrong sign",
            "Put 2T/3 and T into it: it must fall from the peak to zero.",
            exchanged(alpha=lambda T, peak: {2: [-3 * peak, 3 * peak / T]}),
            turned_in_the_third_piece,
        ),
        Variant(
            "The fall begins at the peak at t = 0, and not at 2T/3",
            "Put 2T/3 into the third piece: is it the peak?",
            exchanged(alpha=lambda T, peak: {2: [peak, -3 * peak / T]}),
        ),
        Variant(
            "A sign in the speed of the third piece",
            "Differentiate the third piece of omega: does its acceleration fall?",
            exchanged(omega=lambda T, peak: {2: [-5 * peak * T / 6, 3 * peak, 3 * peak / (2 * T)]}),
            share=0.25,
        ),
        Variant(
            "The constants of integration are forgotten",
            "Where two pieces meet, speed and angle must not jump.",
            exchanged(of_omega=forgotten, of_theta=forgotten),
        ),
        Variant(
            "The angle has no constants of integration",
            "The speed is right. Is the angle continuous where two pieces meet?",
            exchanged(of_theta=forgotten),
            share=0.25,
        ),
        *readings(
            "The acceleration rises as if it had all of T, and not a third",
            "Put T/3 into the first piece: is it the peak?",
            exchanged(
                alpha=lambda T, peak: {0: [0, peak / T], 2: [peak, -peak / T]},
            ),
            exchanged(alpha=lambda T, peak: {0: [0, peak / T]}),
        ),
        Variant(
            "Degrees where radians are asked for",
            "The peak is in rad/s^2.",
            lambda *args: np.rad2deg(motor_profile(*args)),
            share=0.5,
        ),
        Variant(
            "The peak is 5 rad/s^2 whichever is asked for",
            "Is the number of the source still in a piece?",
            lambda t, T, peak: motor_profile(t, T, 5.0),
            share=0.25,
        ),
        Variant(
            "The columns are in the order theta, omega, alpha",
            "The task asks for alpha first.",
            lambda *args: motor_profile(*args)[:, ::-1],
            share=0.5,
        ),
        Variant(
            "Rows and columns are exchanged",
            "A row is an instant: along which axis are the three put together?",
            lambda *args: motor_profile(*args).T,
            share=0.5,
        ),
        *readings(
            "The acceleration is summed up over the instants that are asked for",
            "They may be few, far apart and in any order: use the formulas of the pieces.",
            summed_up,
            summed_in_steps,
        ),
        Variant(
            "An instant at which two pieces meet belongs to neither",
            "t < T/3 and t > T/3 leave a gap.",
            between_two_pieces,
            share=0.5,
        ),
    ),
)

# --- misprint ---------------------------------------------------------------------------------------------------------

Pieces = np.ndarray  # (4, powers of t)
Answer = tuple[str, int] | None


def function_of(rows: Pieces, T: float) -> Callable:
    """A function in four pieces, of an instant or an array of them; the first piece serves before zero as well."""
    starts = T / 3 * np.arange(4)

    def evaluate(t):
        t = np.asarray(t, dtype=float)
        piece = np.clip(np.searchsorted(starts, t, side="right") - 1, 0, 3)
        return (rows[piece] * t[..., None] ** np.arange(rows.shape[1])).sum(axis=-1)

    return evaluate


def planted_cases(rng: np.random.Generator) -> list[Case]:
    def scale(rows: Pieces, T: float) -> float:
        return np.abs(function_of(rows, T)(np.linspace(0, 2 * T, 100))).max()

    def coefficient(rows: Pieces, k: int, T: float) -> Pieces:
        """A wrong power or factor, as in a misprint; it shows in the middle of the piece."""
        slope = polyder(rows.T).T
        while True:
            spoilt = rows.copy()
            n = rng.choice(1 + np.flatnonzero(rows[k, 1:]))
            spoilt[k, n] *= rng.choice([1 / T, T, 1 / 3, 3, -1, 1 / 2, 2])
            off = polyval(T / 3 * (k + np.array([0.4, 0.5, 0.6])), polyder(spoilt[k] - rows[k]))
            if np.abs(off).min() > 0.03 * scale(slope, T):
                return spoilt

    def pivot(rows: Pieces, k: int, T: float) -> Pieces:
        """A wrong slope that still joins the piece before."""
        spoilt = rows.copy()
        c = rng.choice([-1, 1]) * rng.uniform(0.15, 0.6) * scale(polyder(rows.T).T, T)
        spoilt[k, :2] += [-c * T / 3 * k, c]
        return spoilt

    def constant(rows: Pieces, k: int, T: float) -> Pieces:
        spoilt = rows.copy()
        spoilt[k, 0] += rng.choice([-1, 1]) * rng.uniform(0.1, 0.6) * scale(rows, T)
        return spoilt

    def case(name: str, k: int, spoil: Callable | None, kind: str) -> Case:
        # an error is small and a right profile large: no number is a measure of an error but a share of the largest
        T = 3 * rng.integers(15, 80) / 64 * 2.0 ** rng.integers(-3, 4)
        peak = rng.uniform(2, 9) * (1e-4 if spoil else 1e4)
        ends, alpha = run_up(T, peak)
        curves = dict(zip(("omega", "theta"), integrated(ends, alpha), strict=True))
        if spoil:
            curves[name] = spoil(curves[name], k, T)
        functions = (function_of(rows, T) for rows in (alpha, *curves.values()))
        label = f"{spoil.__name__} of piece {k} of {name} is wrong" if spoil else "nothing is wrong"
        return Case((*functions, T), kind=kind, label=f"{label}, T = {T:.4g} s")

    either = partial(rng.choice, ["omega", "theta"])
    one, other = rng.choice(3, 2, replace=False)
    names = rng.permutation(["omega", "theta", either()])
    return [
        case("omega", int(one), coefficient, "normal"),
        case("theta", int(other), coefficient, "normal"),
        case(either(), int(rng.integers(3)), pivot, "normal"),
        case(either(), 3, pivot, "normal"),
        *(case(n, k, constant, "constant") for n, k in zip(names, (0, int(rng.integers(1, 3)), 3), strict=True)),
        case("", 0, None, "right"),
        case("", 0, None, "right"),
    ]


def wrong_slopes(function: Callable, derivative: Callable, T: float) -> list[int]:
    """The pieces in whose middle the difference quotient is not the derivative."""
    h = 1e-5 * T
    instants = T / 3 * (np.arange(4)[:, None] + np.linspace(0.3, 0.7, 5))
    off = np.abs((function(instants + h) - function(instants - h)) / (2 * h) - derivative(instants)).max(axis=1)
    return np.flatnonzero(off > 1e-3 * np.abs(derivative(instants)).max()).tolist()


def breaks(function: Callable, T: float) -> list[int]:
    """The pieces at whose start the function jumps; piece 0, if it does not begin at zero."""
    starts = T / 3 * np.arange(4)
    before = function(starts - 1e-9 * T)
    before[0] = 0.0
    after = function(starts + 1e-9 * T)
    return np.flatnonzero(np.abs(after - before) > 1e-3 * np.abs(after).max()).tolist()


def misprint(alpha, omega, theta, T) -> Answer:
    # omega first: an error in it makes theta look wrong, but not the other way round
    for name, function, derivative in (("omega", omega, alpha), ("theta", theta, omega)):
        # a wrong constant breaks the start of its own piece first, then that of the next
        if wrong := wrong_slopes(function, derivative, T) or breaks(function, T):
            return name, wrong[0]
    return None


def by_slopes_alone(alpha, omega, theta, T) -> Answer:
    for name, function, derivative in (("omega", omega, alpha), ("theta", theta, omega)):
        if wrong := wrong_slopes(function, derivative, T):
            return name, wrong[0]
    return None


def by_jumps(alpha, omega, theta, T, choose=lambda jumps: jumps[0]) -> Answer:
    for name, function in (("omega", omega), ("theta", theta)):
        if jumps := breaks(function, T):
            return name, choose(jumps)
    return None


def by_theta_alone(alpha, omega, theta, T) -> Answer:
    wrong = wrong_slopes(theta, omega, T) or breaks(theta, T)
    return ("theta", wrong[0]) if wrong else None


def omega_for_either(alpha, omega, theta, T) -> Answer:
    wrong = wrong_slopes(theta, omega, T)
    return ("omega", wrong[0]) if wrong else misprint(alpha, omega, theta, T)


def constants_by(choose: Callable) -> Callable:
    """Right where a slope is wrong; where there are only jumps, another piece is named."""

    def find(alpha, omega, theta, T) -> Answer:
        if wrong_slopes(omega, alpha, T) or (not breaks(omega, T) and wrong_slopes(theta, omega, T)):
            return misprint(alpha, omega, theta, T)
        return by_jumps(alpha, omega, theta, T, choose)

    return find


def first_inside(jumps: list[int]) -> int:
    return next(jump for jump in jumps if jump)


def same_place(expected: Outcome, got: Outcome) -> str | None:
    match expected, got:
        case _, Lost(why=why):
            return why
        case _, Raised(type=name):
            return f"it raised {name}"
        case Value(value=right), Value(value=answer):
            if answer is None:
                return None if right is None else "it finds nothing wrong where something is"
            if not (isinstance(answer, (tuple, list)) and len(answer) == 2 and isinstance(answer[0], str)):
                return 'it is neither None nor a pair such as ("omega", 0)'
            piece = numbers(answer[1])
            if isinstance(piece, str) or piece.ndim or float(piece) not in range(5):
                return "its second part is not the number of a piece"
            if right is None:
                return "it finds something wrong where nothing is"
            if answer[0] != right[0]:
                return "it names the wrong function"
            return None if piece == right[1] else "it names the wrong piece"


MISPRINT = Task(
    name="misprint",
    title="find the misprint in a profile",
    function="misprint",
    reference=misprint,
    cases=planted_cases,
    agree=same_place,
    tolerance=Tolerance(0.0, "a piece is right or wrong"),
    section="motor-profile: Find the misprint",
    aspects=(
        Aspect("it names the function and the piece whose slope is wrong", 1.0),
        Aspect("it names the function and the piece whose constant alone is wrong", 0.5, kind="constant"),
        Aspect("it returns None where nothing is wrong", 0.5, kind="right"),
    ),
    variants=(
        Variant(
            "Only the derivatives are compared",
            "A constant has the derivative zero. Where does a wrong one show?",
            by_slopes_alone,
            share=0.5,
            kind="constant",
        ),
        Variant(
            "Only the jumps are looked at",
            "A wrong slope need not lead to a jump at the start of its piece, or to any. What else must agree?",
            by_jumps,
            share=0.25,
        ),
        Variant(
            "An error of omega is put down to theta",
            "If omega is wrong, the derivative of theta does not fit it either. Does omega fit alpha?",
            by_theta_alone,
            share=0.25,
        ),
        Variant(
            "An error of theta is put down to omega",
            "The derivative of theta does not fit omega. Does the derivative of omega fit alpha?",
            omega_for_either,
            share=0.25,
        ),
        Variant(
            "The pieces are counted from one",
            "Python counts from zero, and so does the task.",
            lambda *args: (found := misprint(*args)) and (found[0], found[1] + 1),
            share=0.5,
        ),
        Variant(
            "A wrong constant is put down to the piece before its jump",
            "A wrong constant lifts its whole piece: where does the lifted part begin, and where does it end?",
            constants_by(lambda jumps: first_inside(jumps) - 1),
            share=0.5,
            kind="constant",
        ),
        Variant(
            "A wrong constant is put down to the piece after its last jump",
            "A wrong constant lifts its whole piece: where does the lifted part begin, and where does it end?",
            constants_by(lambda jumps: jumps[-1]),
            share=0.5,
            kind="constant",
        ),
        Variant(
            "A wrong constant of the first piece is put down to the second",
            "The motor starts from rest at the angle zero. Does the function?",
            constants_by(first_inside),
            share=0.5,
            kind="constant",
        ),
        Variant(
            "Round-off is taken for an error",
            "Numbers computed in two ways are hardly ever equal. From which difference on are they different?",
            lambda *args: ("omega", 0),
        ),
    ),
)

EXERCISE = Exercise(
    name="03_motor_profile",
    title="The run-up of a motor",
    tasks=(INTEGRATE_PIECES, FIRST_TURN, MOTOR_PROFILE, MISPRINT),
)
