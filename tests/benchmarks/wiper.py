"""The wiper's turn beside loops over its points, and its motions beside a multibody engine: the numbers, and how long.

python tests/benchmarks/wiper.py [--keep]

Exit code: 0 every bound is reached, 1 one is missed, 2 the numbers are not the same, and the comparison is void.
"""

import argparse
import datetime
import json
import runpy
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from itertools import takewhile
from math import cos, sin
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import scipy.optimize
from measuring import best, computer
from rich.console import Console
from rich.table import Table

from mechlib.direct import Loads, Torque, rubbing, simulate
from mechlib.motor import Motor
from mechlib.wiper import Wiper

ROOT = Path(__file__).resolve().parents[2]
KEPT = ROOT / "book" / "measured" / "wiper.json"
sys.path.append(str(ROOT / "book" / "engine"))  # for what the script there imports
ENGINE = SimpleNamespace(**runpy.run_path(str(ROOT / "book" / "engine" / "wiper.py")))

WIPER, FRICTION, SPEED = Wiper(), ENGINE.FRICTION, ENGINE.SPEED
THETA1 = np.linspace(0, 2 * np.pi, ENGINE.DEGREES + 1)
O, A, B, C, D, E, F = range(1, 15, 2)  # columns of the joints' forces; the first is the torque
SAME = 1e-9  # N m and N, of torques up to 5 and forces up to 60
FASTER = 3.0  # times each loop over points
TRIES = 7  # of which the quickest counts
TIGHT = 1e-11
RTOL = 1e-5, 1e-6, 1e-7, 1e-8
WITHIN = 1e-3, 1e-4, 1e-5  # of the range of the speed; the first is what every way must reach
EXUDYN = "Exudyn"
DIRECT = {"mechlib, the crank alone": "input", "mechlib, all coordinates": "all", EXUDYN: None}


# --- the turn: torque and joint forces at each degree, (361, 15) -----------------------------------------------------


def by_mechlib() -> np.ndarray:
    return ENGINE.turn_by_mechlib(WIPER, FRICTION)


def by_root() -> np.ndarray:
    """Point after point by `scipy.optimize.root`, from the point before: what most people would write first."""
    r0, r1, r2, r3 = WIPER.r0, WIPER.r1, WIPER.r2, WIPER.r3

    def loop(q, th1):
        th2, th3 = q
        return [
            r0 - r1 * cos(th1) - r2 * cos(th2) + r3 * cos(th3),
            r1 * sin(th1) + r2 * sin(th2) - r3 * sin(th3),
        ]

    found, q = [], np.deg2rad([55, 125])
    for th1 in THETA1:
        q = scipy.optimize.root(loop, q, args=(th1,), tol=1e-13).x
        found.append(one_point(th1, *q))
    return np.array(found)


def by_closed_form() -> np.ndarray:
    """Point after point, but for the positions, which are found in closed form and all at once: the quickest loop."""
    return np.array([one_point(*q) for q in np.column_stack((THETA1, WIPER.position(THETA1))).tolist()])


def one_point(th1: float, th2: float, th3: float) -> np.ndarray:
    """Velocities, accelerations and the fifteen equations, written out for this wiper at 35 rpm."""
    r1, r2, r3, r4, r5, w1 = WIPER.r1, WIPER.r2, WIPER.r3, WIPER.r4, WIPER.r5, SPEED
    c1, s1, c2, s2, c3, s3 = cos(th1), sin(th1), cos(th2), sin(th2), cos(th3), sin(th3)
    J = np.array([[r2 * s2, -r3 * s3], [r2 * c2, -r3 * c3]])
    w2, w3 = np.linalg.solve(J, [-r1 * s1 * w1, -r1 * c1 * w1])
    along = r1 * c1 * w1**2 + r2 * c2 * w2**2 - r3 * c3 * w3**2
    across = r1 * s1 * w1**2 + r2 * s2 * w2**2 - r3 * s3 * w3**2
    al2, al3 = np.linalg.solve(J, [-along, across])

    bars = WIPER.masses
    g1, g2, g3, g4, g5 = (bar.centre for bar in bars)
    swing_x, swing_y = (
        -(al3 * s3 + w3**2 * c3),
        al3 * c3 - w3**2 * s3,
    )  # acceleration of a blade, a metre from its joint
    ax, ay = -r1 * c1 * w1**2, -r1 * s1 * w1**2  # of A
    accelerations = (
        (ax * g1 / r1, ay * g1 / r1),
        (ax - g2 * (al2 * s2 + w2**2 * c2), ay + g2 * (al2 * c2 - w2**2 * s2)),
        (g3 * swing_x, g3 * swing_y),
        (g4 * swing_x, g4 * swing_y),
        (r4 * swing_x, r4 * swing_y),
    )
    against = -FRICTION * (1 if w3 > 0 else -1)
    friction = (0.0, 0.0), (0.0, 0.0), (-against * s3, against * c3), (-against * s3, against * c3), (0.0, 0.0)
    turning = 0.0, al2, al3, al3, 0.0
    pins = (  # of each bar: which, with which sign its force acts, and where it is from the centre of mass
        ((O, 1, -g1 * c1, -g1 * s1), (A, 1, (r1 - g1) * c1, (r1 - g1) * s1)),
        ((A, -1, -g2 * c2, -g2 * s2), (B, 1, (r2 - g2) * c2, (r2 - g2) * s2)),
        (
            (B, -1, (r3 - g3) * c3, (r3 - g3) * s3),
            (C, 1, -g3 * c3, -g3 * s3),
            (D, 1, (r4 - g3) * c3, (r4 - g3) * s3),
        ),
        ((E, -1, (r4 - g4) * c3, (r4 - g4) * s3), (F, 1, -g4 * c3, -g4 * s3)),
        ((D, -1, -g5, 0.0), (E, 1, r5 - g5, 0.0)),
    )
    matrix, right = np.zeros((15, 15)), np.zeros(15)
    matrix[2, 0] = 1  # the motor turns the crank
    for k, bar in enumerate(bars):
        x, y, moment = 3 * k, 3 * k + 1, 3 * k + 2
        right[x] = bar.mass * accelerations[k][0] - friction[k][0]
        right[y] = bar.mass * (accelerations[k][1] + WIPER.g) - friction[k][1]
        right[moment] = bar.inertia * turning[k]
        for pin, sign, px, py in pins[k]:
            matrix[x, pin] = matrix[y, pin + 1] = sign
            matrix[moment, pin], matrix[moment, pin + 1] = -sign * py, sign * px
    return np.linalg.solve(matrix, right)


TURN = {
    "mechlib, all points at once": by_mechlib,
    "a loop, scipy.optimize.root": by_root,
    "a loop, closed form": by_closed_form,
}


def of_turn() -> dict[str, dict[str, float]]:
    """Each way: seconds for a turn, and how far it is from mechlib."""
    expected = by_mechlib()
    found = {name: {"seconds": np.inf, "off": float(np.abs(way() - expected).max())} for name, way in TURN.items()}
    for _ in range(TRIES):  # one after the other, so that what else the computer does slows all alike
        for name, way in TURN.items():
            found[name]["seconds"] = min(found[name]["seconds"], best(way, 3, 1))
    return found


# --- direct dynamics: two motions, each in three ways, ever finer -----------------------------------------------------


@dataclass(frozen=True)
class Case:
    """A motion of the wiper from zero, and how the engine makes it.

    Attributes
    ----------
    torque, omega, loads : as `simulate` has them; omega is where the speed begins.
    engine : number of steps -> (instants, 3), time, angle and speed.
    steps : how fine the engine is tried.
    before : s of motion that the engine computes too, before it gets there.
    """

    torque: Torque
    omega: float
    loads: Loads | None
    engine: Callable[[int], np.ndarray]
    steps: tuple[int, ...]
    before: float

    def by_mechlib(self, t: np.ndarray, coordinates: str, rtol: float) -> np.ndarray:
        """Speeds."""
        run = simulate(WIPER, self.torque, (0.0, self.omega), t, self.loads, coordinates=coordinates, rtol=rtol)
        return run.velocity[:, 0]


def cases() -> dict[str, Case]:
    """By the name of the engine's table."""
    motor, friction = ENGINE.through_mean(), rubbing(WIPER, FRICTION, ENGINE.WIDTH)
    return {
        "run_up": Case(Motor(*motor), 0.0, friction, partial(ENGINE.run_up, *motor), (5, 10, 20, 40), 0.0),
        "coasting": Case(lambda *_: 0.0, ENGINE.SPEED, None, ENGINE.coasting, (50, 100, 200), ENGINE.TURN),
    }


def of_motion(name: str, case: Case) -> dict[str, list[dict[str, float]]]:
    """Each way, ever finer: seconds, seconds of motion in a second, and the largest error in the range of the speed."""
    t = np.loadtxt(ROOT / "book" / "engine" / f"wiper_{name}.csv", delimiter=",")[:, 0]
    tight = case.by_mechlib(t, "input", TIGHT)
    found = {way: [] for way in DIRECT}
    for way, runs in found.items():
        for fine in case.steps if way == EXUDYN else RTOL:
            if way == EXUDYN:
                run = lambda: case.engine(fine)[:, 2]  # noqa: B023
            else:
                run = lambda: case.by_mechlib(t, DIRECT[way], fine)  # noqa: B023
            off = float(np.abs(run() - tight).max() / np.ptp(tight))
            seconds, motion = best(run, tries=3), t[-1] + (case.before if way == EXUDYN else 0.0)
            runs.append({"fine": fine, "seconds": seconds, "motion a second": motion / seconds, "off": off})
    return found


def compared(direct: dict[str, dict[str, list[dict[str, float]]]]) -> dict[str, dict[str, dict[str, float | None]]]:
    """Seconds of motion in a second, of each way from where it stays within each error; None where it never does."""

    def quickest(runs, error):
        within = takewhile(lambda run: run["off"] < error, reversed(runs))
        return max((run["motion a second"] for run in within), default=None)

    return {
        f"{name}, within {error:g}": {way: quickest(runs, error) for way, runs in ways.items()}
        for name, ways in direct.items()
        for error in WITHIN
    }


# --- the comparison ---------------------------------------------------------------------------------------------------


def faster(turn: dict[str, dict[str, float]]) -> dict[str, float]:
    """How many times as long as mechlib each loop takes."""
    ours, *loops = turn
    return {name: turn[name]["seconds"] / turn[ours]["seconds"] for name in loops}


def missed(found: dict) -> list[str]:
    return [
        f"all points at once are {times:.1f} times as fast as {name}, where {FASTER:g} was to be reached"
        for name, times in faster(found["turn"]).items()
        if times < FASTER
    ]


def void(found: dict) -> list[str]:
    """Ways whose numbers are others."""
    return [f"{name} is {way['off']:.1e} off" for name, way in found["turn"].items() if not way["off"] < SAME] + [
        f"{name}: {way} is {least:.1e} off at its finest"
        for name, ways in found["direct"].items()
        for way, runs in ways.items()
        if not (least := runs[-1]["off"]) < WITHIN[0]
    ]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--keep", action="store_true", help=f"write {KEPT.relative_to(ROOT)}")
    asked = parser.parse_args()
    found = {
        "date": datetime.date.today().isoformat(),
        "computer": computer(),
        "versions": {name: version(name) for name in ("numpy", "scipy", "sympy", "exudyn")},
        "points": len(THETA1),
        "turn": of_turn(),
        "direct": {name: of_motion(name, case) for name, case in cases().items()},
    }
    found["compared"] = compared(found["direct"])

    console = Console(soft_wrap=True, highlight=False)
    table = Table("", "ms", "times as long", "off", title=f"a turn, {len(THETA1)} points, kinematics and 15 equations")
    times = faster(found["turn"])
    for name, way in found["turn"].items():
        table.add_row(name, f"{1e3 * way['seconds']:.3g}", f"{times.get(name, 1):.3g}", f"{way['off']:.0e}")
    console.print(table)
    for name, ways in found["direct"].items():
        table = Table(
            "", "rtol, or steps", "s", "s of motion a second", "off", title=f"{name}, off in parts of the range"
        )
        for way, runs in ways.items():
            for run in runs:
                table.add_row(way, *(f"{value:.3g}" for value in run.values()))
        console.print(table)
    for name, ways in found["compared"].items():
        reached = (f"{way}: {motion:.3g}" if motion else f"{way}: not reached" for way, motion in ways.items())
        console.print(f"{name}, s of motion a second:", "; ".join(reached))
    console.print(*(f"{name}: {value}" for name, value in found["computer"].items()), sep=", ")
    for sentence in (why := void(found)):
        console.print(f"void: {sentence}")
    for sentence in (lacking := missed(found)):
        console.print(f"missed: {sentence}")
    if asked.keep and not why:
        KEPT.parent.mkdir(exist_ok=True)
        KEPT.write_text(json.dumps(found, indent=1) + "\n", "utf-8")
    return 2 if why else 1 if lacking else 0


if __name__ == "__main__":
    sys.exit(main())
