"""Exercise 12: a coupler point whose bars have tolerances, by throws and by derivatives."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from itertools import combinations, product
from math import sqrt

import numpy as np
from scipy.special import ndtri

from autograder.chance import FALSE_ALARM, Drawn
from autograder.checks.answers import array, arrays, refuses, said
from autograder.checks.e05_consecutive import TURN
from autograder.checks.plane import unit, xy
from autograder.compare import Tolerance, difference, disagreement, numbers
from autograder.outcome import Lost, Outcome, Raised, Value
from autograder.spec import Aspect, Case, Exercise, Task, Trial, Variant, readings
from mechlib.fourbar import LENGTHS, FourBar

SOURCE = np.array([getattr(FourBar, name) for name in LENGTHS])  # D's
SIDE = {"open": 1, "crossed": -1}  # of the way from A to O4 on which B lies, counted to the left
WELL = np.sin(np.deg2rad(25))  # the transmission angle is larger

EXACT = Tolerance(1e-9, "two ways to write it differ by round-off", absolute=1e-12)


def plane(points) -> np.ndarray:
    """Points of the plane as complex numbers."""
    return np.asarray(points) @ [1, 1j]


def four_bar(lengths) -> FourBar:
    """One linkage, or many; shape (..., 6)."""
    r1, r2, r3, r4, rcx, rcy = np.moveaxis(np.asarray(lengths, dtype=float), -1, 0)
    return FourBar(r1, r2, r3, r4, rcx, rcy)


def closes_well(lengths: np.ndarray, theta2) -> np.ndarray:
    q = four_bar(lengths).position(theta2, open_points="leave out")
    return np.sin(q[..., 1] - q[..., 0]) > WELL


def drawn_lengths(rng: np.random.Generator, theta2: float, linkages: int = 1) -> np.ndarray:
    """Lengths near those of source D, each linkage on its own, that close well at this crank angle."""
    tried = SOURCE * rng.uniform(0.85, 1.15, (3 * linkages + 3, 6))
    tried[:, 4:] *= rng.choice([-1, 1], (len(tried), 2))
    found = tried[closes_well(tried, theta2)][:linkages]
    return found if len(found) == linkages else drawn_lengths(rng, theta2, linkages)


def half_widths(rng: np.random.Generator, smallest: float) -> np.ndarray:
    """All different; the first is neither the smallest, nor the largest, nor near their mean."""
    sizes = smallest * 1.6 ** np.arange(6)
    first = rng.choice([1, 2, 4])
    return np.array([sizes[first], *rng.permutation(np.delete(sizes, first))])


def words(lengths: np.ndarray) -> str:
    return ", ".join(f"{name} = {length:.4g}" for name, length in zip(LENGTHS, lengths, strict=True)) + " m"


def without_size(value):
    """An answer in which all that is not finite, or so large that it stands for a division by zero, is the same."""
    if isinstance(value, (tuple, list)):
        return tuple(map(without_size, value))
    got = numbers(value)
    return value if isinstance(got, str) else np.where(np.abs(got) < 1e5, got, np.inf)


def but_for_size(agree: Callable[[Outcome, Outcome], str | None]) -> Callable[[Trial, Trial], bool]:
    """Whether two trials are the same answer, whatever came of a division by zero."""

    def alike(*trials: Trial) -> bool:
        outcomes = (each.outcome for each in trials)
        with np.errstate(invalid="ignore"):
            return agree(*(Value(without_size(o.value)) if isinstance(o, Value) else o for o in outcomes)) is None

    return alike


# --- coupler_point ----------------------------------------------------------------------------------------------------

FLAT = (0.0, 0.0, 0.0)


def placed(crank, arm, x0, y0, theta0) -> np.ndarray:
    """Crank and arm of the coupler point, in a frame that is turned and moved."""
    return (crank + arm) * unit(theta0) + x0 + 1j * y0


def from_the_rocker_joint(to_a, along, side, room: Callable = lambda cosine: cosine) -> np.ndarray:
    """theta3 of a unit vector with a given component along the way from O4 to A; none if that is too long."""
    return np.angle(to_a) - side * np.arccos(room(along / np.abs(to_a)))


def by_half_angle(room: Callable) -> Callable:
    """The same by the tangent of half of it, as source D has it, with the number under the root changed."""
    return lambda to_a, along, side: (
        2 * np.arctan2(to_a.imag - side * np.sqrt(room(np.abs(to_a) ** 2 - along**2)), to_a.real + along)
    )


def coupler_by(
    side: Callable = SIDE.get,
    angle: Callable = lambda theta: theta,
    order: Sequence[int] = range(6),
    denominator: Callable = lambda r2, r3: 2 * r2 * r3,
    arm: Callable = lambda e3, rcx, rcy: (rcx + 1j * rcy) * e3,
    place: Callable = placed,
    from_b: bool = False,
    of_rocker: bool = False,
    coupler_angle: Callable = from_the_rocker_joint,
    positive: bool = True,
) -> Callable:
    """The coupler point in the closed form of source D, with one of its parts exchanged."""

    def point(theta2, lengths, branch="open", frame=FLAT) -> np.ndarray:
        r1, r2, r3, r4, rcx, rcy = np.asarray(lengths)[:, list(order)].T
        if positive and (wrong := lengths[:, :4][lengths[:, :4] <= 0]).size:
            raise ValueError(f"a length of {wrong[0]} m")
        e2 = unit(angle(theta2))
        to_a = e2 - r1 / r2  # from O4, over r2
        constant = (r4**2 - r1**2 - r2**2 - r3**2) / denominator(r2, r3)
        e3 = unit(coupler_angle(to_a, constant + r1 / r3 * e2.real, side(branch)))
        crank = r2 * e2
        e4 = (crank + r3 * e3 - r1) / r4
        return xy(place(crank + from_b * r3 * e3, arm(e4 if of_rocker else e3, rcx, rcy), *frame))

    return point


coupler_point = coupler_by()


def printed_sign(e3, rcx, rcy) -> np.ndarray:
    """The arm with Py as source D prints it."""
    return (rcx + 1j * rcy) * e3 - 2j * rcy * e3.real


def mirrored(e3, rcx, rcy) -> np.ndarray:
    return (rcx - 1j * rcy) * e3


def of_other_bars(nominal: Callable) -> Callable:
    """With l3 as the program of source D has it."""

    def point(theta2, lengths, *rest):
        r2, r3 = nominal(lengths)[1:3]
        return coupler_by(denominator=lambda *_: 2 * r2 * r3)(theta2, lengths, *rest)

    return point


def point_cases(rng: np.random.Generator) -> list[Case]:
    def case(rows: int, kind: str, branch: str, frame: tuple = FLAT) -> Case:
        theta2 = rng.uniform(-TURN, TURN)
        lengths = drawn_lengths(rng, theta2, rows)
        label = f"{rows} linkages, theta2 = {theta2:.4g}, the {branch} branch"
        return Case((theta2, lengths, branch, frame), kind=kind, label=label + f", frame {frame}" * (frame != FLAT))

    def frame() -> tuple[float, float, float]:
        x0, y0, theta0 = rng.uniform(0.2, 1, 3) * rng.choice([-1, 1], 3)
        return float(x0), float(y0), float(theta0)

    def open_loop(branch: str) -> Case:
        """Some bars are too short, some too unequal, some long enough."""
        theta2 = rng.uniform(-TURN, TURN)
        lengths = drawn_lengths(rng, theta2, 12)
        diagonal = np.abs(lengths[:, 1] * unit(theta2) - lengths[:, 0])
        r3, r4 = lengths[:, 2:4].T.copy()
        short, unequal = rng.permutation(12)[:8].reshape(2, 4)
        lengths[short, 2:4] *= (diagonal / (r3 + r4) * rng.uniform(0.8, 0.95, 12))[short, None]
        lengths[unequal, 2] = (diagonal + r4)[unequal] * rng.uniform(1.05, 1.2, 4)
        return Case((theta2, lengths, branch), kind="open", label="some linkages cannot close")

    def negative(bar: int, length: float) -> Case:
        theta2 = rng.uniform(-TURN, TURN)
        lengths = drawn_lengths(rng, theta2, 5)
        lengths[rng.integers(5), bar] = length
        return Case((theta2, lengths), kind="negative", label=f"a length of {length:.4g} m")

    return [
        case(40, "normal", "open"),
        case(1, "normal", "open"),
        case(20, "normal", "crossed"),
        case(20, "frame", "open", frame()),
        case(20, "frame", "crossed", frame()),
        open_loop("open"),
        open_loop("crossed"),
        *(negative(bar, -rng.uniform(0.1, 0.5)) for bar in range(4)),
        negative(int(rng.integers(4)), 0.0),
    ]


def is_carried(trial: Trial, right: Trial) -> str | None:
    """Whether P hangs on rigid bars that close the loop on this side, from nothing but their lengths."""
    wanted = right.outcome.value
    got = array(trial, wanted.shape, "(linkages, 2)")
    if isinstance(got, str):
        return got
    theta2, lengths, branch, frame = (*trial.case.args, FLAT)[:4]
    r1, r2, r3, r4, rcx, rcy = lengths.T
    closes = ~np.isnan(wanted[:, 0])
    if (still := closes & np.isnan(got).any(axis=1)).any():
        return f"it is not a number at index {np.argmax(still)}, where the loop closes"
    if (at := ~closes & ~np.isnan(got).all(axis=1)).any():
        return f"it is a number at index {np.argmax(at)}, where the loop cannot close"
    P = (plane(got) - frame[0] - 1j * frame[1]) / unit(frame[2])  # back in the frame of the ground
    A = r2 * unit(theta2)
    B = A + (P - A) * r3 / (rcx + 1j * rcy)  # the coupler is rigid: where P is, B is known
    for name, off in (
        ("P is not hypot(rcx, rcy) from A", np.abs(P - A) - np.hypot(rcx, rcy)),
        ("the joint B that goes with P is not r4 from O4", np.abs(B - r1) - r4),
        ("the joint B that goes with P is on the other side of A-O4", SIDE[branch] * ((B - A) / (r1 - A)).imag < 0),
    ):
        if (wrong := closes & ~(np.abs(off) < 1e-8)).any():
            return f"{name} at index {np.argmax(wrong)}"
    return None


def on(branch: str) -> Callable:
    """Looks at the cases of this branch."""
    return lambda trial, right: is_carried(trial, right) if trial.case.args[2] == branch else None


COUPLER_POINT = Task(
    name="coupler_point",
    title="the coupler point on both branches, for many sets of lengths",
    function="coupler_point",
    reference=coupler_point,
    cases=point_cases,
    tolerance=EXACT,
    section="fourbar-coupler: Both assembly branches",
    aspects=(
        Aspect(
            "on the open branch the arm A-P is rigid, and the coupler that carries it closes the loop", 1.25, on("open")
        ),
        Aspect("so it is on the crossed branch", 0.75, on("crossed")),
        Aspect("in a frame that is turned and moved", 0.5, is_carried, kind="frame"),
        Aspect("nan where the loop cannot close, and there alone", 0.25, is_carried, kind="open"),
        Aspect(
            "it raises ValueError, with the length, where a bar is not positive",
            0.25,
            refuses(lambda theta2, lengths: (lengths[:, :4].min(),), EXACT),
            kind="negative",
        ),
    ),
    variants=(
        Variant(
            "The branches are exchanged",
            "On the open branch B lies to the left of the way from A to O4. On which side is yours?",
            coupler_by(side=lambda branch: -SIDE[branch]),
            share=0.5,
        ),
        Variant(
            "It is the open branch, whichever is asked for",
            "What does the other sign of the square root give?",
            coupler_by(side=lambda branch: 1),
            share=0.5,
        ),
        Variant(
            "It is the crossed branch, whichever is asked for",
            "What does the other sign of the square root give?",
            coupler_by(side=lambda branch: -1),
            share=0.25,
        ),
        Variant(
            "rcy cos(theta3) has a minus in Py",
            "So it is printed in source D. How far is your P from A, and how far should it be?",
            coupler_by(arm=printed_sign),
            share=0.25,
        ),
        Variant(
            "rcy sin(theta3) has a plus in Px",
            "Turn a vector (rcx, rcy) by theta3: which signs has the matrix?",
            coupler_by(arm=lambda e3, rcx, rcy: (rcx + 1j * rcy) * e3 + 2 * rcy * e3.imag),
            share=0.25,
        ),
        Variant(
            "P is on the other side of the coupler",
            "rcy counts to the left of the way from A to B.",
            coupler_by(arm=mirrored),
            share=0.25,
        ),
        Variant(
            "rcx and rcy are exchanged",
            "Which of the two lies along the coupler?",
            coupler_by(arm=lambda e3, rcx, rcy: (rcy + 1j * rcx) * e3),
            share=0.25,
        ),
        *readings(
            "Nominal bars stand in the denominator of l3",
            "So it is in the program of source D. Every set of lengths is another linkage: does its loop close?",
            *map(of_other_bars, (lambda lengths: SOURCE, lambda lengths: lengths[0], lambda lengths: lengths.mean(0))),
            share=0.25,
        ),
        Variant(
            "P turns with the rocker",
            "On which bar is P fixed, and which angle is that bar's?",
            coupler_by(of_rocker=True),
            share=0.25,
        ),
        Variant(
            "The arm begins in B",
            "rcx and rcy are counted from A.",
            coupler_by(from_b=True),
            share=0.25,
        ),
        Variant(
            "r3 and r4 are exchanged",
            "Which bar is the coupler?",
            coupler_by(order=(0, 1, 3, 2, 4, 5)),
            share=0.25,
        ),
        Variant(
            "The crank angle is taken for degrees",
            "It is in radians, and NumPy wants radians.",
            coupler_by(angle=np.deg2rad),
            share=0.25,
        ),
        Variant(
            "theta0 is subtracted from theta3",
            "So it is in the program of source D. If the ground turns, which way does the coupler?",
            coupler_by(place=lambda crank, arm, x0, y0, th0: crank * unit(th0) + arm * unit(-th0) + x0 + 1j * y0),
            share=0.75,
            kind="frame",
        ),
        Variant(
            "The arm is not turned with the frame",
            "If the ground turns, does the coupler stay?",
            coupler_by(place=lambda crank, arm, x0, y0, th0: crank * unit(th0) + arm + x0 + 1j * y0),
            share=0.75,
            kind="frame",
        ),
        Variant(
            "The crank is not turned with the frame",
            "From which line is theta2 counted?",
            coupler_by(place=lambda crank, arm, x0, y0, th0: crank + arm * unit(th0) + x0 + 1j * y0),
            share=0.75,
            kind="frame",
        ),
        Variant(
            "The frame is not turned",
            "From which line is theta2 counted?",
            coupler_by(place=lambda crank, arm, x0, y0, th0: crank + arm + x0 + 1j * y0),
            share=0.75,
            kind="frame",
        ),
        Variant(
            "The frame is not moved",
            "Where is O2?",
            coupler_by(place=lambda crank, arm, x0, y0, th0: (crank + arm) * unit(th0)),
            share=0.75,
            kind="frame",
        ),
        Variant(
            "The frame is not looked at",
            "Where is O2, and where does O4 lie from there?",
            coupler_by(place=lambda crank, arm, *_: crank + arm),
            share=0.75,
            kind="frame",
        ),
        Variant(
            "O2 is turned about the origin",
            "x0 and y0 tell where O2 is, however the ground is turned.",
            coupler_by(place=lambda crank, arm, x0, y0, th0: (crank + arm + x0 + 1j * y0) * unit(th0)),
            share=0.75,
            kind="frame",
        ),
        *readings(
            "A loop that cannot close gets a point",
            "Of a negative number there is no real root. What becomes of it in your formula?",
            coupler_by(coupler_angle=partial(from_the_rocker_joint, room=lambda cosine: np.clip(cosine, -1, 1))),
            coupler_by(coupler_angle=by_half_angle(lambda square: np.maximum(square, 0))),
            coupler_by(coupler_angle=by_half_angle(np.abs)),
            share=0.75,
            kind="open",
        ),
        Variant(
            "A bar that is not positive gets a point",
            "A bar of no length is no bar.",
            coupler_by(positive=False),
            share=0.75,
            kind="negative",
        ),
    ),
)

# --- propagate --------------------------------------------------------------------------------------------------------

# The judge evaluates the point, and so knows every throw. Its lengths can be held against their law, whose moments and
# bounds are exact, and what was made of the results against the results themselves, in which chance has no part.
THROWN = Drawn(mean=0, deviation=1 / sqrt(3), kurtosis=9 / 5, reach=1)  # in half widths: no throw lies outside
PRODUCT = Drawn(mean=0, deviation=1 / 3, kurtosis=81 / 25, reach=1)  # of two lengths that are thrown apart
PAIRS = tuple(combinations(range(6), 2))
ALARM = FALSE_ALARM / (2 * (6 + 6 + len(PAIRS)))  # all comparisons of both cases together: one in a million
STATISTIC = 1e-4  # of the deviation; n - 1 for n changes it by a six hundredth
MOST_CALLS = 1000  # that are looked into: some for each throw
SAME = 1e-6  # half widths
WIDTH = 0.23  # the logarithm of a length's spread: half of what two tolerances differ by, nine sigma of chance
ALL_WIDTHS = 0.08  # its mean over all lengths; five sigma of normal ones
OFF_CENTRE = 0.25  # half widths; lengths that only become longer are at 0.5
CALLS = 3  # "all at once", and one or two for a look


def sample_variance(y: np.ndarray) -> np.ndarray:
    """Not a number of a single throw, and no warning."""
    return np.divide(((y - y.mean(axis=0)) ** 2).sum(axis=0), len(y) - 1)


MEANS: dict[str, Callable] = {
    "mean": lambda y, nominal: y.mean(axis=0),
    "nominal": lambda y, nominal: nominal,
    "median": lambda y, nominal: np.median(y, axis=0),
    "of x and y together": lambda y, nominal: y.mean(),
}
SPREADS: dict[str, Callable] = {
    "sample": lambda y: np.sqrt(sample_variance(y)),
    "population": lambda y: y.std(axis=0),
    "standard error": lambda y: np.sqrt(sample_variance(y) / len(y)),
    "population's standard error": lambda y: y.std(axis=0) / sqrt(len(y)),
    "variance": sample_variance,
    "population's variance": lambda y: y.var(axis=0),
    "half range": lambda y: np.ptp(y, axis=0) / 2,
    "mean distance": lambda y: np.abs(y - y.mean(axis=0)).mean(axis=0),
    "of x and y together": lambda y: y.std(ddof=1),
    "population's of x and y together": lambda y: y.std(),
}


@dataclass(frozen=True)
class Throwing:
    """What a trial threw, as the judge saw it, and what it made of the results."""

    trial: Trial

    @cached_property
    def lengths(self) -> np.ndarray:
        """Those that were asked for, but the nominal ones, and what was asked twice once; shape (throws, 6)."""
        asked = {lengths.tobytes(): np.ravel(lengths) for (lengths,) in self.trial.evaluations[0][:MOST_CALLS]}
        rows = np.reshape(np.concatenate([[], *asked.values()]), (-1, 6))
        return rows[(rows != self.trial.case.args[1]).any(axis=1)]

    @cached_property
    def off(self) -> np.ndarray:
        """How far each length is from its nominal value, in half widths."""
        _, nominal, half_width, *_ = self.trial.case.args
        return (self.lengths - nominal) / half_width

    @cached_property
    def results(self) -> np.ndarray:
        return self.trial.case.args[0](self.lengths)

    @cached_property
    def _statistics(self) -> list[tuple[str, np.ndarray, np.ndarray]]:
        """Name, value, and how near an answer must be."""
        y, nominal = self.results, self.trial.case.args[0](self.trial.case.args[1])
        if len(y) < 2 or not np.isfinite(y).all():
            return []
        deviation = y.std(axis=0).min()
        means = ((f"mean: {name}", of(y, nominal), STATISTIC * deviation) for name, of in MEANS.items())
        spreads = ((f"deviation: {name}", right := of(y), STATISTIC * np.abs(right)) for name, of in SPREADS.items())
        return [*means, *spreads]

    def are(self, answer) -> frozenset[str]:
        """Which statistics of its results an answer is."""
        got = numbers(answer)
        if isinstance(got, str) or np.isnan(got).any():
            return frozenset({"no number"})
        return frozenset(
            name
            for name, right, allowed in self._statistics
            if got.shape == np.shape(right) and (np.abs(got - right) <= allowed).all()
        )

    @cached_property
    def made(self) -> tuple:
        """What was returned, in words that know no numbers."""
        match self.trial.outcome:
            case Value(value=(tuple() | list()) as parts):
                return tuple(self.are(part) for part in parts)
            case Raised(type=name):
                return (name,)
        return ()

    @cached_property
    def kind(self) -> tuple:
        """How the lengths were thrown, in what chance cannot change."""
        n = len(self.lengths)
        if n < 3:
            return (n,)
        spread = np.ptp(self.off, axis=0) > SAME
        if not spread.any():
            return (1,)
        moved = self.off[:, spread]
        beyond = bool(np.abs(moved).max() > 1 + SAME)
        squares = (moved - moved.mean(axis=0)) ** 2
        peak = ((squares**2).mean(axis=0) / squares.mean(axis=0) ** 2).mean()  # 1 of two values, 9/5 even, 3 normal
        return n, bool(spread.all()), self.shared, beyond, int(np.digitize(peak, (1.3, 2.3)))

    @cached_property
    def shared(self) -> bool:
        """Whether two lengths always change together."""
        first = self.off[:, :1]
        return bool((np.ptp(self.off[:, 1:] - first, axis=0) < SAME).any() and np.ptp(first) > SAME)

    def like(self, other: "Throwing") -> bool:
        if self.kind != other.kind:
            return False
        if self.kind in ((0,), (1,)) and self.trial.case.kind == "normal":
            return True  # whatever is made of it
        if self.made != other.made:
            return False
        if len(self.lengths) < 3:
            return True
        ours, theirs = (each.off.std(axis=0) for each in (self, other))
        both = (ours > SAME) & (theirs > SAME)
        ratio = np.log(ours[both] / theirs[both])
        together = WIDTH if self.shared else ALL_WIDTHS
        off_centre = abs(self.off.mean() - other.off.mean())
        return bool(np.abs(ratio).max() < WIDTH and abs(ratio.mean()) < together and off_centre < OFF_CENTRE)


@lru_cache(64)
def throwing(trial: Trial) -> Throwing:
    """Looked into once, however many mistakes and aspects ask."""
    return Throwing(trial)


def evenly(rng: np.random.Generator, throws: int) -> np.ndarray:
    """Throws from -1 to 1 without chance: the same for each length, in an order of its own, a little off centre."""
    middles = (2 * np.arange(throws) + 1) / max(throws, 1) - 1
    return rng.permuted(np.tile(middles + 0.05 * (1 - middles**2), (6, 1)), axis=1).T


def scaled(u, nominal, half_width) -> np.ndarray:
    return nominal + half_width * u


def normal(u, deviation: float) -> np.ndarray:
    return deviation * ndtri((u + 1) / 2)


def without_result(results, throws: int) -> np.ndarray:
    if no := np.isnan(results).any(axis=1).sum():
        raise ValueError(f"{no} of {throws} throws have no result")
    return results


def too_few(throws: int) -> None:
    if throws < 2:
        raise ValueError(f"{throws} throws have no deviation")


def propagated(
    lengths: Callable = scaled,
    mean: str = "mean",
    deviation: str = "sample",
    of_open: Callable = without_result,
    least: Callable = too_few,
    returned: Callable = lambda mean, deviation: (mean, deviation),
) -> Callable:
    """Throws that chance has no part in, so that it is the answer's alone, with one part exchanged."""

    def find(point, nominal, half_width, throws, seed=0):
        least(throws)
        thrown = lengths(evenly(np.random.default_rng(seed), throws), nominal, half_width)
        results = of_open(point(thrown), throws)
        return returned(MEANS[mean](results, point(nominal)), SPREADS[deviation](results))

    return find


propagate = propagated()


def thrown_by(change: Callable) -> Callable:
    return propagated(lengths=lambda u, nominal, half_width: scaled(change(u), nominal, half_width))


def points_of(theta2: float, branch: str) -> Callable:
    """The coupler point at one crank angle; not a number where the loop cannot close."""
    return lambda lengths: four_bar(lengths).coupler_point(theta2, branch, "leave out")


def throwing_cases(rng: np.random.Generator) -> list[Case]:
    def case(throws: int, kind: str = "normal") -> Case:
        theta2, branch = rng.uniform(-TURN, TURN), rng.choice(list(SIDE))
        (nominal,) = drawn_lengths(rng, theta2)
        half_width = half_widths(rng, 1e-4)
        if kind == "open":
            short = np.abs(nominal[1] * unit(theta2) - nominal[0]) - 0.2 * half_width.max()
            nominal[2:4] *= short / nominal[2:4].sum()  # some throws are long enough
        args = points_of(theta2, branch), nominal, half_width, throws, int(rng.integers(1000, 10_000))
        label = f"{throws} throws at theta2 = {theta2:.4g}, {words(nominal)}"
        return Case(args, kind=kind, label=label + ", of which some cannot close" * (kind == "open"))

    def many() -> int:
        return int(rng.integers(270, 321))  # six lengths each: what one evaluation may hold

    return [case(many()), case(many()), case(many(), "open"), case(many(), "open"), case(1, "few"), case(2, "few")]


def throws_by_the_law(trial: Trial, right: Trial) -> str | None:
    """Whether so many throws were made, and whether they may be even, independent ones within the tolerances."""
    if isinstance(trial.outcome, Raised):
        return f"it raised {trial.outcome.type}"
    off, throws = throwing(trial).off, trial.case.args[3]
    if len(off) != throws:
        return f"the point is asked for {len(off)} different sets of lengths, and not for one a throw"
    if not (np.abs(off) <= 1 + 1e-9).all():
        return "a length is thrown beyond its tolerance"
    for name, column in zip(LENGTHS, off.T, strict=True):
        mean_off = THROWN.mean_fault(column.mean(), throws, ALARM)
        if why := mean_off or THROWN.deviation_fault(column.std(ddof=1), throws, ALARM):
            return f"{name}: {why}"
    for i, j in PAIRS:
        if PRODUCT.mean_fault(np.mean(off[:, i] * off[:, j]), throws, ALARM):
            return f"{LENGTHS[i]} and {LENGTHS[j]} are not thrown apart"
    return None


PARTS = ("mean", "deviation")


def is_the_statistic(k: int, name: str) -> Callable:
    def fault(trial: Trial, right: Trial) -> str | None:
        found = arrays(trial.outcome, dict.fromkeys(PARTS, (2,)), "a pair (mean, deviation)")
        if isinstance(found, str):
            return found
        is_it = f"{PARTS[k]}: {name}" in throwing(trial).are(found[k])
        return None if is_it else f"it is not the {PARTS[k]} of the results at the lengths that were asked for"

    return fault


def throws_all_at_once(trial: Trial, right: Trial) -> str | None:
    calls = len(trial.evaluations[0])
    return None if calls <= CALLS else f"it asks for the points in {calls} calls"


def counts_the_open(trial: Trial, right: Trial) -> str | None:
    if why := disagreement(right.outcome, trial.outcome, EXACT):
        return why
    no_result = np.isnan(throwing(trial).results).any(axis=1).sum()
    return None if no_result in said(trial.outcome.message) else "its message does not tell how many have none"


def refuses_a_single_throw(trial: Trial, right: Trial) -> str | None:
    if isinstance(right.outcome, Raised):
        return refuses(lambda *args: (args[3],), EXACT)(trial, right)
    return None if isinstance(trial.outcome, Value) else "it refuses two throws"


PROPAGATE = Task(
    name="propagate",
    title="mean and sample deviation of a result, by throws",
    function="propagate",
    reference=propagate,
    cases=throwing_cases,
    alike=lambda one, other: throwing(one).like(throwing(other)),
    tolerance=EXACT,
    section="fourbar-monte-carlo: Throwing the lengths",
    aspects=(
        Aspect("the mean of the results of its throws", 0.5, is_the_statistic(0, "mean")),
        Aspect("the sample deviation of the results of its throws", 1.0, is_the_statistic(1, "sample")),
        Aspect("every length is thrown evenly within its tolerance, apart from the others", 1.5, throws_by_the_law),
        Aspect("the points of all throws are asked for at once", 0.5, throws_all_at_once),
        Aspect(
            "it raises ValueError, with how many there are, where throws have no result",
            0.25,
            counts_the_open,
            kind="open",
        ),
        Aspect(
            "it raises ValueError, with the number of throws, where that is less than two",
            0.25,
            refuses_a_single_throw,
            kind="few",
        ),
    ),
    variants=(
        Variant(
            "The deviation is that of a population: it divides by n",
            "The mean was found from the same throws: how many of their distances from it are free?",
            propagated(deviation="population"),
            share=0.75,
        ),
        *readings(
            "The standard error stands where the deviation belongs",
            "Throw four times as often: does the spread of the mechanisms you build become half as large?",
            propagated(deviation="standard error"),
            propagated(deviation="population's standard error"),
            share=0.5,
        ),
        *readings(
            "The variance stands where the deviation belongs",
            "The deviation is in metres. What is yours in?",
            propagated(deviation="variance"),
            propagated(deviation="population's variance"),
            share=0.5,
        ),
        Variant(
            "Half the range stands where the deviation belongs",
            "How far the farthest throw lies depends on how often you throw.",
            propagated(deviation="half range"),
            share=0.5,
        ),
        Variant(
            "The mean distance stands where the deviation belongs",
            "What is squared in a standard deviation?",
            propagated(deviation="mean distance"),
            share=0.5,
        ),
        *readings(
            "x and y are thrown together in one mean and one deviation",
            "Along which axis are the throws?",
            propagated(mean="of x and y together", deviation="of x and y together"),
            propagated(mean="of x and y together", deviation="population's of x and y together"),
            share=0.375,
        ),
        Variant(
            "The point of the nominal lengths stands where the mean belongs",
            "They are close, but not the same. Which is asked for?",
            propagated(mean="nominal"),
            share=0.75,
        ),
        Variant(
            "The median stands where the mean belongs",
            "They are close, but not the same. Which is asked for?",
            propagated(mean="median"),
            share=0.75,
        ),
        Variant(
            "Mean and deviation are exchanged",
            "In which order does the task ask for them?",
            propagated(returned=lambda mean, deviation: (deviation, mean)),
            share=0.5,
        ),
        Variant(
            "The lengths are thrown normally, with the half width as deviation",
            "A tolerance is a limit: which law of chance has one?",
            thrown_by(lambda u: normal(u, 1)),
            share=0.5,
        ),
        Variant(
            "The lengths are thrown normally, with the deviation of even ones",
            "The deviation is right. How many lengths are out of tolerance?",
            thrown_by(lambda u: normal(u, 1 / sqrt(3))),
            share=0.5,
        ),
        Variant(
            "The lengths are thrown evenly, with the half width as deviation",
            "How far from the nominal length may a length be at most?",
            thrown_by(lambda u: sqrt(3) * u),
            share=0.5,
        ),
        Variant(
            "The half width is taken for the full width",
            "The tolerance goes that far to either side.",
            thrown_by(lambda u: u / 2),
            share=0.5,
        ),
        Variant(
            "The lengths only become longer",
            "To how many sides does a tolerance go?",
            thrown_by(lambda u: (u + 1) / 2),
            share=0.5,
        ),
        Variant(
            "Every length is at one end of its tolerance",
            "Between the ends there is something.",
            thrown_by(np.sign),
            share=0.5,
        ),
        Variant(
            "Some lengths are not thrown",
            "Six lengths have tolerances: the ground and the two of the coupler point as well.",
            thrown_by(lambda u: u * (np.arange(6) > 0)),  # whichever they are
            share=0.5,
        ),
        Variant(
            "All lengths share one draw",
            "If the crank came out long, must the rocker be long as well?",
            thrown_by(lambda u: u[:, :1] + np.zeros(6)),
            share=0.5,
        ),
        Variant(
            "One throw serves for all",
            "How many different sets of lengths do you try?",
            thrown_by(lambda u: u[:1] + np.zeros_like(u)),
            share=0.25,
        ),
        Variant(
            "Nothing is thrown",
            "How many different sets of lengths do you try?",
            thrown_by(np.zeros_like),
        ),
        *readings(
            "One tolerance serves for all lengths",
            "`half_width` has a number for each.",
            *(
                propagated(lengths=lambda u, nominal, half_width, of=of: scaled(u, nominal, of(half_width)))
                for of in (lambda w: w[0], np.mean, np.max)
            ),
            share=0.5,
        ),
        Variant(
            "The tolerances are taken for relative ones",
            "They are in metres.",
            propagated(lengths=lambda u, nominal, half_width: nominal * (1 + half_width * u)),
            share=0.5,
        ),
        Variant(
            "Throws without a result are left out",
            "Who reads your mean should know that some of the mechanisms cannot be built.",
            propagated(of_open=lambda results, throws: results[~np.isnan(results).any(axis=1)]),
            share=0.875,
            kind="open",
        ),
        Variant(
            "Throws without a result go into mean and deviation",
            "What is the mean of numbers of which one is not a number?",
            propagated(of_open=lambda results, throws: results),
            share=0.875,
            kind="open",
        ),
        Variant(
            "A single throw gets a deviation",
            "One throw has no spread.",
            propagated(least=lambda throws: None),
            share=0.875,
            kind="few",
        ),
    ),
)

# --- linear_propagation -----------------------------------------------------------------------------------------------

SLOPES = Tolerance(1e-5, "central differences are right to 1e-9 here, and sensible ones to one side to 1e-6")
SPREAD = Tolerance(1e-4, "curvature changes the deviation by 1e-5 of it here")
ENDS = np.array([*product((-1, 1), repeat=6)]) / sqrt(
    3
)  # their mean and deviation are those of even throws, in half widths
STEP = 1e-5  # m


def moments_by_ends(theta2: np.ndarray, branch: str, lengths, half_width) -> np.ndarray:
    """Deviations by 64 throws that stand for all: exact for results up to third powers; shape (points, 2)."""
    thrown = four_bar(lengths + half_width * ENDS)
    return thrown.coupler_point(theta2[:, None], branch).std(axis=1)


def summed(G: np.ndarray, half_width) -> np.ndarray:
    """The root of the sum of the squares."""
    return np.sqrt(((G * half_width) ** 2).sum(axis=-1))


def sensitivity(
    follows: Callable = lambda by_q: by_q,
    bars: Sequence[float] = (1, 1, 1, 1, 1, 1),
    gradient: Callable = lambda G: G,
    combined: Callable = lambda G, half_width: summed(G, half_width / sqrt(3)),
    angle: Callable = lambda theta: theta,
    closes: bool = True,
    alive: bool = True,
    returned: Callable = lambda G, deviation: (G, deviation),
) -> Callable:
    """Derivatives of the coupler point by the six lengths, the coupler following, with one part exchanged."""

    def find(theta2, q, lengths, half_width):
        r1, r2, r3, r4, rcx, rcy = lengths
        theta3, theta4 = q.T
        e2, e3, e4 = (unit(angle(theta)) for theta in (theta2, theta3, theta4))
        one, none = np.ones_like(e2), np.zeros_like(e2)
        gap = np.abs(r2 * e2 + r3 * e3 - r1 - r4 * e4)
        across = np.sin(angle(theta4) - angle(theta3))
        for refuse, wrong, why in (
            (closes, gap > 1e-6, "the loop is open"),
            (alive, np.abs(across) < 1e-6, "dead point"),
        ):
            if refuse and wrong.any():
                raise ValueError(f"{why} at index {np.argmax(wrong)}")
        # how the loop opens by each bar; along the rocker it can be closed by turning the coupler alone
        opens = np.array([-one, e2, e3, -e4])
        theta3_by = -(opens / e4).real / (r3 * across)
        P_by = np.array([none, e2, none, none, e3, 1j * e3])
        P_by[:4] += (rcx + 1j * rcy) * 1j * e3 * follows(theta3_by)
        G = gradient(np.moveaxis(xy(P_by), 0, -1) * bars)  # (points, 2, 6)
        return returned(G, combined(G, half_width))

    return find


linear_propagation = sensitivity()


def by_step(step: Callable) -> Callable:
    """Differences to one side of the closed form."""

    def find(theta2, q, lengths, half_width):
        branch = str(FourBar(*lengths[:4]).branch(q[0]))
        h = np.broadcast_to(step(lengths, half_width), (6,))
        moved = four_bar(lengths + np.diag(h)).coupler_point(theta2[:, None], branch)
        G = (moved - four_bar(lengths).coupler_point(theta2, branch)[:, None]) / h[:, None]
        return G.swapaxes(1, 2), summed(G.swapaxes(1, 2), half_width / sqrt(3))

    return find


def linear_cases(rng: np.random.Generator) -> list[Case]:
    def drawn(n: int) -> tuple[np.ndarray, np.ndarray]:
        (lengths,) = drawn_lengths(rng, 0.0)
        theta2 = rng.uniform(-TURN, TURN, 4 * n)
        theta2 = theta2[closes_well(lengths, theta2)][:n]
        return (theta2, lengths) if len(theta2) == n else drawn(n)

    def of(theta2, lengths, q, words_: str, kind: str = "normal") -> Case:
        label = f"{len(theta2)} points, {words(lengths)}, {words_}"
        return Case((theta2, q, lengths, half_widths(rng, 1e-5)), kind=kind, label=label)

    def case(n: int, branch: str) -> Case:
        theta2, lengths = drawn(n)
        return of(theta2, lengths, four_bar(lengths).position(theta2, branch), f"the {branch} branch")

    def open_loop(branch: str, by: float) -> Case:
        theta2, lengths = drawn(6)
        q = four_bar(lengths).position(theta2, branch)
        q[rng.integers(1, 6)] += by * rng.uniform(1, 3, 2) * rng.choice([-1, 1])
        return of(theta2, lengths, q, "an open loop", "open")

    def dead(stretched: bool) -> Case:
        """Where A is farthest from O4, or nearest, coupler and rocker are in line."""
        theta2, lengths = drawn(6)
        diagonal = lengths[0] - lengths[1] * unit(theta2)
        away = np.abs(diagonal)
        k = int(away.argmax() if stretched else away.argmin())
        lengths[2] = away[k] - lengths[3] if stretched else away[k] + lengths[3]
        beside = np.delete(away, k) / away[k]
        if k == 0 or not 0.02 < np.abs(beside - 1).min() or (np.delete(away, k) > 0.98 * lengths[2:4].sum()).any():
            return dead(stretched)
        q = four_bar(lengths).position(theta2, open_points="leave out")
        q[k] = np.angle(diagonal[k]) + np.pi * np.array([0, stretched])
        return of(theta2, lengths, q, "a dead point", "dead")

    return [
        case(8, "open"),
        case(8, "crossed"),
        case(1, "open"),
        open_loop("open", 5e-5),
        open_loop("crossed", 0.05),
        dead(stretched=True),
        dead(stretched=False),
    ]


def of_no_derivative(theta2, q, lengths, half_width) -> tuple[int]:
    """The index of the point that is open or dead."""
    r1, r2, r3, r4, *_ = lengths
    gap = np.abs(r2 * unit(theta2) + r3 * unit(q[:, 0]) - r1 - r4 * unit(q[:, 1]))
    return (int(np.argmax((gap > 1e-6) | (np.abs(np.sin(q[:, 1] - q[:, 0])) < 1e-6))),)


def gradient_and_deviation(trial: Trial) -> tuple[np.ndarray, ...] | str:
    n = len(trial.case.args[0])
    shapes = {"gradient": (n, 2, 6), "deviation": (n, 2)}
    return arrays(trial.outcome, shapes, "a pair (gradient, deviation)")


def branch_of(trial: Trial) -> str:
    _, q, lengths, _ = trial.case.args
    return str(four_bar(lengths).branch(q[0]))


def is_the_difference(*columns: int) -> Callable:
    """Whether the derivatives are difference quotients of the closed form."""

    def fault(trial: Trial, right: Trial) -> str | None:
        found = gradient_and_deviation(trial)
        if isinstance(found, str):
            return found
        theta2, _, lengths, _ = trial.case.args
        moved = (four_bar(lengths + step * np.eye(6)) for step in (STEP, -STEP))
        after, before = (each.coupler_point(theta2[:, None], branch_of(trial)) for each in moved)
        for k in columns:
            if why := difference((after - before)[:, k] / (2 * STEP), found[0][..., k], SLOPES):
                return f"by {LENGTHS[k]}: {why}"
        return None

    return fault


def is_the_deviation_of_throws(trial: Trial, right: Trial) -> str | None:
    found = gradient_and_deviation(trial)
    if isinstance(found, str):
        return found
    theta2, _, lengths, half_width = trial.case.args
    return difference(moments_by_ends(theta2, branch_of(trial), lengths, half_width), found[1], SPREAD)


def same_gradient(expected: Outcome, got: Outcome) -> str | None:
    """Deviations are much smaller than derivatives: each on its own scale."""
    if isinstance(expected, Value) and isinstance(got, Value):
        if not isinstance(got.value, (tuple, list)) or len(got.value) != len(expected.value):
            return "it is not a pair (gradient, deviation)"
        parts = zip(expected.value, got.value, strict=True)
        return next(filter(None, (difference(right, answer, SLOPES) for right, answer in parts)), None)
    return disagreement(expected, got, SLOPES)


tells_the_index = refuses(of_no_derivative, SLOPES)

LINEAR_PROPAGATION = Task(
    name="linear_propagation",
    title="derivatives by the lengths, and the deviation that follows from them",
    function="linear_propagation",
    reference=linear_propagation,
    cases=linear_cases,
    agree=same_gradient,
    alike=but_for_size(same_gradient),
    tolerance=SLOPES,
    section="fourbar-monte-carlo: Linear propagation",
    aspects=(
        Aspect("the derivatives by the four bars, to which the coupler follows", 1.0, is_the_difference(0, 1, 2, 3)),
        Aspect("the derivatives by rcx and rcy", 0.25, is_the_difference(4, 5)),
        Aspect("the deviation agrees with that of throws", 1.25, is_the_deviation_of_throws),
        Aspect("it raises ValueError, with the index, at a dead point", 0.25, tells_the_index, kind="dead"),
        Aspect("it raises ValueError, with the index, where the loop is open", 0.25, tells_the_index, kind="open"),
    ),
    variants=(
        Variant(
            "theta3 is held",
            "If a bar grows, the loop does not close any more at the same angles. Which angles follow?",
            sensitivity(follows=lambda theta3_by: 0 * theta3_by),
            share=0.25,
        ),
        Variant(
            "theta3 follows with the wrong sign",
            "F(p, q(p)) = 0 is differentiated: on which side of the equation is F_p?",
            sensitivity(follows=lambda theta3_by: -theta3_by),
            share=0.25,
        ),
        Variant(
            "The ground is taken as exact",
            "It is a bar as the others are: in which equation does it stand?",
            sensitivity(bars=(0, 1, 1, 1, 1, 1)),
            share=0.5,
        ),
        Variant(
            "rcx and rcy are taken as exact",
            "They stand in no closure. Do they stand in the point?",
            sensitivity(bars=(1, 1, 1, 1, 0, 0)),
            share=0.5,
        ),
        *readings(
            "The derivatives are differences to one side with too coarse a step",
            "How does the error shrink with the step, and how would it if you stepped to both sides?",
            *(by_step(lambda lengths, half_width, h=h: h) for h in (1e-2, 1e-3, 1e-4)),
            *(by_step(lambda lengths, half_width, h=h: h * lengths) for h in (1e-2, 1e-3, 1e-4)),
            share=0.5,
        ),
        Variant(
            "The half width is taken for the deviation",
            "How large is the standard deviation of an even spread?",
            sensitivity(combined=summed),
            share=0.625,
        ),
        Variant(
            "The full width is taken for the half width",
            "The deviation of an even spread is its width over the root of twelve. Which width have you been given?",
            sensitivity(combined=lambda G, half_width: summed(G, half_width / sqrt(12))),
            share=0.625,
        ),
        Variant(
            "The half width is divided by 3, and not by its root",
            "The variance of an even spread is a third of the square of its half width. And the deviation?",
            sensitivity(combined=lambda G, half_width: summed(G, half_width / 3)),
            share=0.625,
        ),
        Variant(
            "The sizes are added",
            "That is the worst case. How do deviations of independent lengths add up?",
            sensitivity(combined=lambda G, half_width: np.abs(G * half_width).sum(axis=-1) / sqrt(3)),
            share=0.625,
        ),
        Variant(
            "The worst case is given: the sizes are added, with the half widths",
            "Hardly ever are all lengths at the worst ends of their tolerances. How do deviations add up?",
            sensitivity(combined=lambda G, half_width: np.abs(G * half_width).sum(axis=-1)),
            share=0.625,
        ),
        Variant(
            "The parts are added with their signs",
            "Independent lengths do not cancel each other. How do their deviations add up?",
            sensitivity(combined=lambda G, half_width: np.abs((G * half_width).sum(axis=-1)) / sqrt(3)),
            share=0.625,
        ),
        Variant(
            "The root is missing: it is the variance",
            "The deviation is in metres. What is yours in?",
            sensitivity(combined=lambda G, half_width: summed(G, half_width / sqrt(3)) ** 2),
            share=0.625,
        ),
        Variant(
            "The mean of the squares is taken, and not their sum",
            "If there were more lengths that vary, could the deviation be smaller?",
            sensitivity(combined=lambda G, half_width: summed(G, half_width / sqrt(18))),
            share=0.625,
        ),
        Variant(
            "One tolerance serves for all lengths",
            "`half_width` has a number for each.",
            sensitivity(combined=lambda G, half_width: summed(G, half_width[0] / sqrt(3))),
            share=0.625,
        ),
        Variant(
            "The derivatives are multiplied by the half widths",
            "A derivative says what a metre would do.",
            lambda theta2, q, lengths, w: (lambda G, s: (G * w, s))(*linear_propagation(theta2, q, lengths, w)),
            share=0.5,
        ),
        Variant(
            "The gradient has the shape (points, 6, 2)",
            "Its last axis holds the lengths.",
            sensitivity(returned=lambda G, deviation: (G.swapaxes(1, 2), deviation)),
            share=0.5,
        ),
        Variant(
            "Gradient and deviation are exchanged",
            "In which order does the task ask for them?",
            sensitivity(returned=lambda G, deviation: (deviation, G)),
            share=0.5,
        ),
        Variant(
            "The angles are taken for degrees",
            "They are in radians, and NumPy wants radians.",
            sensitivity(angle=np.deg2rad, closes=False),
        ),
        Variant(
            "A dead point gets derivatives",
            "Where coupler and rocker are in line, what is the determinant of the Jacobian?",
            sensitivity(alive=False),
            share=0.875,
            kind="dead",
        ),
        Variant(
            "Positions that leave the loop open get derivatives",
            "What follows the lengths where no linkage is?",
            sensitivity(closes=False),
            share=0.875,
            kind="open",
        ),
    ),
)

# --- convergence_rate -------------------------------------------------------------------------------------------------

RATE = Tolerance(1e-9, "a straight line through logarithms is right to round-off")


def root_mean_square(off: np.ndarray) -> np.ndarray:
    return np.sqrt((off**2).mean(axis=1))


def slope(x: np.ndarray, y: np.ndarray) -> float:
    """Of the straight line with the least squares; not a number through one point."""
    off = x - x.mean()
    return float(np.divide(off @ y, off @ off))


def rate_by(
    error: Callable = lambda estimates, truth: root_mean_square(estimates - truth),
    fit: Callable = slope,
    of_throws: Callable = np.log,
    of_error: Callable = np.log,
    few: bool = True,
    exact: bool = True,
) -> Callable:
    def find(throws, estimates, truth) -> float:
        if few and len(throws) < 2:
            raise ValueError(f"a slope needs two numbers of throws, got {len(throws)}")
        errors = error(estimates, truth)
        if exact and not errors.all():
            raise ValueError(f"no error with {throws[np.argmin(np.abs(errors))]} throws")
        return fit(of_throws(throws), of_error(errors))

    return find


convergence_rate = rate_by()


def between_the_ends(x, y) -> float:
    return float((y[-1] - y[0]) / (x[-1] - x[0]))


def through_the_origin(x, y) -> float:
    return float(x @ y / (x @ x))


SPOILT = {"few": "one number of throws is left", "exact": "all estimates are right with one number of throws"}


def rate_cases(rng: np.random.Generator) -> list[Case]:
    def case(kind: str, rate: float, scatter: float = 0.0, k: int = 0) -> Case:
        k, repetitions = k or int(rng.integers(5, 8)), int(rng.integers(12, 25))
        throws = np.unique(np.rint(10 ** (rng.uniform(1, 2) + np.cumsum(rng.uniform(0.2, 0.7, k)))))
        unit_errors = rng.normal(size=(k, repetitions)) + rng.uniform(0.6, 1) * rng.choice(
            [-1, 1]
        )  # estimates are biased
        unit_errors /= root_mean_square(unit_errors)[:, None]
        errors = rng.uniform(0.2, 5) * throws**rate * np.exp(scatter * rng.normal(size=k))
        truth = rng.uniform(0.3, 1)
        args = throws, truth + errors[:, None] * unit_errors, float(truth)
        return Case(args, kind=kind, label=f"{k} numbers of throws, each {repetitions} times, rate {rate:.3g}")

    def spoilt(kind: str, change: Callable) -> Case:
        throws, estimates, truth = case(kind, -0.5).args
        return Case(change(throws, estimates, truth), kind=kind, label=f"{SPOILT[kind]}, of {len(throws)}")

    def right_once(throws, estimates, truth):
        estimates[rng.integers(len(throws))] = truth
        return throws, estimates, truth

    return [
        case("law", -0.5),
        case("law", -rng.uniform(0.85, 1.1)),
        *(case("normal", rate, 0.4) for rate in (-0.5, -1.0, -rng.uniform(0.3, 1.5))),
        case("few", -0.5, k=2),
        spoilt("few", lambda throws, estimates, truth: (throws[:1], estimates[:1], truth)),
        case("exact", -0.5, 0.4),
        spoilt("exact", right_once),
    ]


def is_the_rate(trial: Trial, right: Trial) -> str | None:
    got = array(trial, ())
    return got if isinstance(got, str) else difference(right.outcome.value, got, RATE)


CONVERGENCE_RATE = Task(
    name="convergence_rate",
    title="how fast estimates converge",
    function="convergence_rate",
    reference=convergence_rate,
    cases=rate_cases,
    alike=but_for_size(partial(disagreement, tolerance=RATE)),
    tolerance=RATE,
    section="fourbar-monte-carlo: How fast it converges",
    aspects=(
        Aspect(
            "the exponent, where the errors are exactly a power of the number of throws", 0.5, is_the_rate, kind="law"
        ),
        Aspect("the straight line with the least squares, where they are not", 1.0, is_the_rate),
        Aspect(
            "it raises ValueError, with how many there are, where one number of throws is too few",
            0.25,
            refuses(lambda throws, *_: (len(throws),), RATE),
            kind="few",
        ),
        Aspect(
            "it raises ValueError, with the number of throws, where there is no error",
            0.25,
            refuses(lambda n, estimates, truth: tuple(n[(estimates == truth).all(axis=1)]), RATE),
            kind="exact",
        ),
    ),
    variants=(
        Variant(
            "The rate has the wrong sign",
            "Errors become smaller as the throws become more: which sign has the exponent?",
            lambda *args: -convergence_rate(*args),
            share=0.5,
        ),
        Variant(
            "The throws are fitted against the error",
            "Which of the two is the power of the other?",
            rate_by(fit=lambda x, y: slope(y, x)),
            share=0.25,
        ),
        Variant(
            "The logarithm of the estimates is fitted, and not that of their errors",
            "What should tend to zero?",
            rate_by(error=lambda estimates, truth: np.abs(estimates).mean(axis=1)),
            share=0.25,
        ),
        Variant(
            "The spread about their own mean is taken for the error",
            "Estimates can agree with one another and be wrong. From where are errors counted?",
            rate_by(error=lambda estimates, truth: estimates.std(axis=1)),
            share=0.25,
        ),
        Variant(
            "The squares are not rooted",
            "How fast does the square of something shrink, compared with the thing?",
            rate_by(error=lambda estimates, truth: ((estimates - truth) ** 2).mean(axis=1)),
            share=0.5,
        ),
        Variant(
            "The sizes are averaged, and not their squares",
            "Which mean does the task name?",
            rate_by(error=lambda estimates, truth: np.abs(estimates - truth).mean(axis=1)),
            share=0.5,
        ),
        Variant(
            "The errors are averaged with their signs",
            "What is the mean of an error up and an error down?",
            rate_by(error=lambda estimates, truth: np.abs((estimates - truth).mean(axis=1))),
            share=0.25,
        ),
        Variant(
            "Only the last estimate is looked at",
            "There are several for each number of throws.",
            rate_by(error=lambda estimates, truth: np.abs(estimates[:, -1] - truth)),
            share=0.25,
        ),
        Variant(
            "Only the first and the last number of throws are looked at",
            "What do the others say?",
            rate_by(fit=between_the_ends),
            share=0.25,
        ),
        Variant(
            "The line is led through the origin",
            "With a single throw, is the error one?",
            rate_by(fit=through_the_origin),
            share=0.25,
        ),
        Variant(
            "No logarithm is taken",
            "On which axes is a power a straight line?",
            rate_by(of_throws=np.asarray, of_error=np.asarray),
        ),
        Variant(
            "The throws have no logarithm",
            "On which axes is a power a straight line?",
            rate_by(of_throws=np.asarray),
        ),
        Variant(
            "The errors have no logarithm",
            "On which axes is a power a straight line?",
            rate_by(of_error=np.asarray),
        ),
        Variant(
            "The two logarithms are not to the same base",
            "Divide the one by the other: what is left of the base?",
            rate_by(of_throws=np.log10),
            share=0.25,
        ),
        Variant(
            "An error of zero gets a rate",
            "Which number is the logarithm of zero?",
            rate_by(exact=False),
            share=0.875,
            kind="exact",
        ),
        Variant(
            "A single number of throws gets a rate",
            "How many straight lines go through one point?",
            rate_by(few=False),
            share=0.875,
            kind="few",
        ),
    ),
)

# --- wrong_part -------------------------------------------------------------------------------------------------------

BARS = 1e-9  # m, as the task says
FIFTH = 0.2  # of the linear deviation, as the task says
ARM, LOOP, BRANCH = "arm", "loop", "branch"
Verdict = tuple[bool, str | None]


def bars_off(theta2: float, lengths, points) -> dict[str, np.ndarray]:
    """What does not fit of the point of each throw, and by how much; shape (throws,) each."""
    r1, r2, r3, r4, rcx, rcy = lengths.T
    A, P = r2 * unit(theta2), plane(points)
    B = A + (P - A) * r3 / (rcx + 1j * rcy)
    return {
        ARM: np.abs(np.abs(P - A) - np.hypot(rcx, rcy)),
        LOOP: np.abs(np.abs(B - r1) - r4),
        BRANCH: np.where(((B - A) / (r1 - A)).imag > 0, 0.0, 1.0),
    }


def deviations_off(points, linear) -> np.ndarray:
    """How far the deviations are from the linear ones, in parts of these; shape (2,)."""
    return np.abs(points.std(axis=0, ddof=1) / linear - 1)


def planted_by(
    parts: Sequence[str] = (ARM, LOOP, BRANCH),
    of_throws: Callable = np.max,
    least: float = BARS,
    sees: Callable = lambda off: off.max() > FIFTH,
    says: Callable = lambda seen, part: (seen, part),
) -> Callable:
    """The two witnesses, with a part of them exchanged."""

    def find(theta2, lengths, points, linear) -> Verdict:
        off = bars_off(theta2, lengths, points)
        part = next((part for part in parts if of_throws(off[part]) > least), None)
        return says(bool(sees(deviations_off(points, linear))), part)

    return find


wrong_part = planted_by()


def planting_cases(rng: np.random.Generator) -> list[Case]:
    def by(program: Callable) -> Callable:
        return lambda theta2, lengths, nominal: program(theta2, lengths)

    def source_d1(theta2, lengths, nominal):
        return of_other_bars(lambda _: nominal)(theta2, lengths)

    def typed_wrongly(bar: int, off: float) -> Callable:
        return by(lambda theta2, lengths: coupler_point(theta2, lengths + off * np.eye(6)[bar]))

    def not_thrown(*which: int) -> Callable:
        kept = np.isin(np.arange(6), which)
        return lambda theta2, lengths, nominal: coupler_point(theta2, np.where(kept, nominal, lengths))

    def bent(e3, rcx, rcy):
        return (rcx + 1j * rcy) * e3 * unit(0.02)

    def case(words: str, plant: Callable, verdict: Verdict, few: bool = False, above: int = 0) -> Case:
        """With deviations that tell clearly whether they see the mistake; the crank above the ground, or below."""
        while True:
            theta2 = (above or rng.choice([-1, 1])) * rng.uniform(0.3, np.pi - 0.3)
            (nominal,) = drawn_lengths(rng, theta2)
            half_width = half_widths(rng, 1e-5)
            lengths = nominal + half_width * rng.uniform(-1, 1, (300, 6))
            there = np.full(300, not few)
            there[rng.choice(np.arange(1, 300), 30, replace=False)] = True
            points = np.where(there[:, None], plant(theta2, lengths, nominal), coupler_point(theta2, lengths))
            (linear,) = moments_by_ends(np.array([theta2]), "open", nominal, half_width)
            clear = (np.abs(np.log(deviations_off(points, linear) / FIFTH)) > 0.4).all()
            args = theta2, lengths, points, linear
            if clear and wrong_part(*args) == verdict:
                return Case(args, label=words + " in some throws" * few)

    small, large = rng.uniform(3e-8, 1e-7), rng.uniform(2e-5, 5e-5)
    crossed = coupler_by(side=lambda branch: -1)
    return [
        case("a sign in Py", by(coupler_by(arm=printed_sign)), (True, ARM)),
        case("the nominal lengths", not_thrown(*range(6)), (True, ARM)),
        case("the nominal arm", not_thrown(4, 5), (False, ARM)),
        case("another r2", typed_wrongly(1, -small), (False, ARM)),
        case("another r2", typed_wrongly(1, large), (False, ARM), few=True),
        case("nominal bars in l3", source_d1, (True, LOOP)),
        case("the other side of the coupler", by(coupler_by(arm=mirrored)), (True, LOOP)),
        case("a bent coupler", by(coupler_by(arm=bent)), (False, LOOP)),
        case("another r4", typed_wrongly(3, -small), (False, LOOP)),
        case("another r4", typed_wrongly(3, -large), (False, LOOP), few=True),
        *(case("the other branch", by(crossed), (True, BRANCH), few=True, above=above) for above in (-1, 1)),
        *(case("no mistake", by(coupler_point), (False, None), above=above) for above in (-1, 1)),
    ]


def same_verdict(expected: Outcome, got: Outcome) -> str | None:
    match expected, got:
        case _, Lost(why=why):
            return why
        case _, Raised(type=name):
            return f"it raised {name}"
        case Value(value=(seen, part)), Value(value=answer):
            if not isinstance(answer, (tuple, list)) or len(answer) != 2:
                return "it is not a pair (seen, part)"
            said_seen, named = answer
            if not isinstance(seen, bool):  # of a known mistake
                return None if repr((said_seen, named)) == repr((seen, part)) else "it is something else"
            if not (isinstance(said_seen, (bool, np.bool_)) or (isinstance(said_seen, int) and said_seen in (0, 1))):
                return "its first part is neither True nor False"
            if named is not None and not (isinstance(named, str) and named in (ARM, LOOP, BRANCH)):
                return 'its second part is none of "arm", "loop", "branch" and None'
            if named != part:
                if part is None:
                    return "it names a part where nothing is wrong"
                return "it finds nothing where something is wrong" if named is None else "it names the wrong part"
            if bool(said_seen) != seen:
                return "the deviations see it" if seen else "the deviations do not see it"
    return None


def wherever(wrong: str | None) -> Callable:
    """Looks at the cases where this is wrong."""
    return lambda trial, right: same_verdict(right.outcome, trial.outcome) if right.outcome.value[1] == wrong else None


WRONG_PART = Task(
    name="wrong_part",
    title="find a planted mistake, and say whether the deviations see it",
    function="wrong_part",
    reference=wrong_part,
    cases=planting_cases,
    agree=same_verdict,
    tolerance=Tolerance(0.0, "a bar is rigid or not"),
    section="fourbar-monte-carlo: Linear propagation",
    aspects=(
        Aspect("it finds the arm that is not rigid, seen by the deviations or not", 0.5, wherever(ARM)),
        Aspect("it finds the loop that does not close, seen by the deviations or not", 0.75, wherever(LOOP)),
        Aspect("it finds the throws on the other branch", 0.25, wherever(BRANCH)),
        Aspect("it names nothing where nothing is wrong", 0.5, wherever(None)),
    ),
    variants=(
        Variant(
            "The bars are looked at only where the deviations are off",
            "A mistake that is the same in every throw spreads nothing. Which witness sees it?",
            planted_by(says=lambda seen, part: (seen, part if seen else None)),
            share=0.25,
        ),
        Variant(
            "The arm is not looked at",
            "If P is wrong, what does the joint B that goes with it say about the loop?",
            planted_by(parts=(LOOP, BRANCH)),
        ),
        Variant(
            "The loop is not looked at",
            "The arm can be rigid and still not be where the coupler is.",
            planted_by(parts=(ARM, BRANCH)),
            share=0.25,
        ),
        Variant(
            "The branch is not looked at",
            "The loop can close on both sides of the way from A to O4.",
            planted_by(parts=(ARM, LOOP)),
            share=0.75,
        ),
        Variant(
            "Only the first throw is looked at",
            "A mistake may be in some throws alone.",
            planted_by(of_throws=lambda off: off[0]),
            share=0.25,
        ),
        Variant(
            "Every difference from the linear deviations counts",
            "Throws have a spread that chance has a part in. How large a difference does the task name?",
            planted_by(sees=lambda off: True),
            share=0.25,
        ),
        Variant(
            "Only the deviation of x is looked at",
            "A mistake in Py leaves Px as it is.",
            planted_by(sees=lambda off: off[0] > FIFTH),
            share=0.25,
        ),
        Variant(
            "It is said whether the deviations agree, and not whether they see the mistake",
            "The first part is True where the deviations show that something is wrong.",
            planted_by(says=lambda seen, part: (not seen, part)),
            share=0.5,
        ),
        Variant(
            "The part comes first",
            "In which order does the task ask for the two?",
            planted_by(says=lambda seen, part: (part, seen)),
            share=0.5,
        ),
        Variant(
            "Round-off is taken for a mistake",
            "Numbers computed in two ways are hardly ever equal. From which size on are they different?",
            planted_by(least=0.0),
        ),
    ),
)

EXERCISE = Exercise(
    name="12_monte_carlo",
    title="A coupler point and its tolerances",
    tasks=(COUPLER_POINT, PROPAGATE, LINEAR_PROPAGATION, CONVERGENCE_RATE, WRONG_PART),
)
