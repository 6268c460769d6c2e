"""The hacksaw along the motion of source A, in every way of the course and in others': the same numbers, and how long.

python tests/benchmarks/sweeps.py [--keep]

Two other programs are installed into an environment of their own, on demand. Exit code: 0 every bound is reached, 1 one
is missed, 2 the numbers are not the same, and the comparison is void.
"""

import argparse
import datetime
import json
import subprocess
import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

import numpy as np
import peers
import scipy.optimize
import sympy as sp
from measuring import best, computer
from rich.console import Console
from rich.table import Table

from mechlib.batched import batched
from mechlib.hacksaw import Hacksaw
from mechlib.motion import Motion, MotorProfile
from mechlib.newton import newton
from mechlib.sweep import consecutive, simultaneous

ROOT = Path(__file__).resolve().parents[2]
THEIRS = ROOT / "_build" / "benchmarks" / "peers"
PEERS = {"pylinkage": "1.3.0", "mechanism": "1.1.10"}
KEPT = ROOT / "book" / "measured" / "hacksaw.json"

SAW, POINTS, SYMBOLIC_POINTS = Hacksaw(), 1000, 20
SHORT = 0.10  # m, a coupler that does not reach the guide at some points
R1Y, R2, R3 = SAW.r1y, SAW.r2, SAW.r3
SEED = np.array([-0.0997, -0.4684, 2.8737])  # as the programs of the source have it
TOL, PRECISE = 1e-6, 1e-9  # that of source A leaves some 1e-12, and that is not the same number
SAME = 1e-12
FASTER, SLOWER = 50.0, 20.0  # times the loop over scipy.optimize.root; times the closed form
SIZES = (10_000, 100_000, 1_000_000)


def run_up(points: int) -> Motion:
    profile = MotorProfile.through()
    return profile.at(np.linspace(0, 2 * profile.T, points))


# --- one way each: motion -> (points, 9) ------------------------------------------------------------------------------


def by_closed_form(motion: Motion) -> np.ndarray:
    return np.hstack(SAW.closed_form(motion.position, motion.velocity, motion.acceleration))


def nine(sweep) -> np.ndarray:
    return np.hstack((sweep.position, sweep.velocity, sweep.acceleration))


def by_batched(motion: Motion) -> np.ndarray:
    return nine(batched(SAW, motion, SEED, PRECISE))


def by_consecutive(motion: Motion) -> np.ndarray:
    return nine(consecutive(SAW, motion, SEED, PRECISE))


def by_simultaneous(motion: Motion) -> np.ndarray:
    return nine(simultaneous(SAW, motion, [*SEED, *np.zeros(6)], PRECISE))


def by_scipy(motion: Motion) -> np.ndarray:
    """`scipy.optimize.root` point after point, and two linear solves: what most people would write first."""
    found, x = [], SEED
    for th2, w2, al2 in zip(motion.position, motion.velocity, motion.acceleration, strict=True):
        x = scipy.optimize.root(loop, x, args=(th2,), tol=1e-13).x
        r1, th1, th3 = x
        c1, s1, c2, s2, c3, s3 = np.cos(th1), np.sin(th1), np.cos(th2), np.sin(th2), np.cos(th3), np.sin(th3)
        J = [[-c1, r1 * s1, -R3 * s3], [s1, r1 * c1, -R3 * c3], [s1, r1 * c1, 0]]
        vr, w1, w3 = v = np.linalg.solve(J, [R2 * s2 * w2, R2 * c2 * w2, 0])
        guide = 2 * vr * w1 * c1 - r1 * w1**2 * s1
        along = 2 * vr * w1 * s1 + r1 * w1**2 * c1 - R2 * (al2 * s2 + w2**2 * c2) - R3 * w3**2 * c3
        across = guide - R2 * (al2 * c2 - w2**2 * s2) + R3 * w3**2 * s3
        found.append([*x, *v, *np.linalg.solve(J, [-along, -across, -guide])])
    return np.array(found)


def loop(x, th2):
    r1, th1, th3 = x
    return [
        -r1 * np.cos(th1) + R2 * np.cos(th2) + R3 * np.cos(th3),
        r1 * np.sin(th1) - R2 * np.sin(th2) - R3 * np.sin(th3),
        r1 * np.sin(th1) - R1Y,
    ]


# --- the two solvers of source A, in three forms ----------------------------------------------------------------------


def stages() -> tuple[list[tuple], tuple]:
    """Equations and unknowns of the three stages, and of all in one, with the lengths of the saw."""
    closure = Hacksaw.closure
    lengths = dict(zip(closure.parameters, (R1Y, R2, R3), strict=True))
    equations = (closure.position_equations, closure.velocity_equations, closure.acceleration_equations)
    unknowns = tuple(zip(*closure.unknowns, strict=True))
    three = [(e.subs(lengths), q, e.subs(lengths).jacobian(q)) for e, q in zip(equations, unknowns, strict=True)]
    everything = closure.simultaneous_equations.subs(lengths)
    flat = tuple(q for order in unknowns for q in order)
    return three, (everything, flat, everything.jacobian(flat))


def substituted(expressions: sp.Matrix, symbols, known: dict) -> Callable[[np.ndarray], np.ndarray]:
    """By symbolic substitution, as the programs of the source do it."""

    def function(x: np.ndarray) -> np.ndarray:
        values = expressions.subs(known | dict(zip(symbols, x, strict=True)))
        return np.array(values, dtype=float).reshape(expressions.shape if expressions.cols > 1 else -1)

    return function


def source_a(solve_stage, motion: Motion, together: bool) -> list[float]:
    """Seconds from the first point to the end of each, by the consecutive or the simultaneous solver of the source.

    `solve_stage(stage, seed, known)` is Newton-Raphson on one stage: 0 to 2, or 3 for all in one.
    """
    x, seconds, begin = np.concatenate((SEED, np.zeros(6))), [], time.perf_counter()
    for crank in zip(motion.position, motion.velocity, motion.acceleration, strict=True):
        if together:
            x = solve_stage(3, x, crank, ())
        else:
            q = solve_stage(0, x[:3], crank, ())
            v = solve_stage(1, x[3:6], crank, (q,))
            x = np.concatenate((q, v, solve_stage(2, x[6:], crank, (q, v))))
        seconds.append(time.perf_counter() - begin)
    return seconds


def symbolic() -> Callable:
    three, one = stages()
    u = Hacksaw.closure.input
    unknowns = [q for _, q, _ in three]

    def solve_stage(stage, seed, crank, before):
        equations, symbols, jacobian = (*three, one)[stage]
        known = dict(zip(u, crank, strict=True))
        for names, values in zip(unknowns, before, strict=False):
            known |= dict(zip(names, values, strict=True))
        return newton(substituted(equations, symbols, known), substituted(jacobian, symbols, known), seed, TOL).root

    return solve_stage


def compiled(linear: bool = False) -> Callable:
    """The same, compiled once; `linear` solves the stages that are linear, and does not iterate them."""
    three, one = stages()
    u, unknowns = list(Hacksaw.closure.input), [list(q) for _, q, _ in three]
    functions = []
    for stage, (equations, symbols, jacobian) in enumerate((*three, one)):
        arguments = [*symbols, *u, *(q for names in unknowns[: stage % 3] for q in names)]
        functions.append([sp.lambdify(arguments, m, cse=True) for m in (equations, jacobian)])

    def solve_stage(stage, seed, crank, before):
        residual, jacobian = functions[stage]
        known = (*crank, *(value for values in before for value in values))
        if linear and stage in (1, 2):
            return np.linalg.solve(jacobian(0, 0, 0, *known), -residual(0, 0, 0, *known).ravel())
        return newton(lambda x: residual(*x, *known).ravel(), lambda x: jacobian(*x, *known), seed, TOL).root

    return solve_stage


def parts() -> dict[str, float]:
    """Microseconds of what an iteration is made of, at one point in motion."""
    three, one = stages()
    u = Hacksaw.closure.input
    at = run_up(POINTS)
    k = POINTS // 3
    crank = (at.position[k], at.velocity[k], at.acceleration[k])
    state = by_closed_form(at)[k]
    found = {}
    for name, (equations, symbols, jacobian), x in (("3 x 3", three[0], state[:3]), ("9 x 9", one, state)):
        known = dict(zip(u, crank, strict=True))
        residual, matrix = (sp.lambdify([*symbols, *u], m, cse=True) for m in (equations, jacobian))
        F, J = residual(*x, *crank).ravel(), matrix(*x, *crank)
        found |= {
            f"{name}: equations by substitution": best(lambda: substituted(equations, symbols, known)(x), 3),  # noqa: B023
            f"{name}: Jacobian by substitution": best(lambda: substituted(jacobian, symbols, known)(x), 3),  # noqa: B023
            f"{name}: equations, compiled": best(lambda: residual(*x, *crank), 300),  # noqa: B023
            f"{name}: Jacobian, compiled": best(lambda: matrix(*x, *crank), 300),  # noqa: B023
            f"{name}: linear solve": best(lambda: np.linalg.solve(J, F), 300),  # noqa: B023
        }
    return {name: 1e6 * seconds for name, seconds in found.items()}


# --- measuring --------------------------------------------------------------------------------------------------------


def ways(motion: Motion) -> dict[str, dict]:
    """Each way: seconds for all points, and how far it is from the closed form."""
    exact = by_closed_form(motion)
    found = {}
    for name, way, calls in (
        ("closed form", by_closed_form, 100),
        ("batched Newton", by_batched, 30),
        ("scalar consecutive", by_consecutive, 1),
        ("scalar simultaneous", by_simultaneous, 1),
        ("scipy.optimize.root, a loop", by_scipy, 1),
    ):
        off = np.abs(way(motion) - exact).max()
        found[name] = {"seconds": best(lambda: way(motion), calls), "off": off, "gives": "all nine"}  # noqa: B023
    few = Motion(
        *(
            column[:: POINTS // SYMBOLIC_POINTS]
            for column in (motion.t, motion.position, motion.velocity, motion.acceleration)
        )
    )
    for name, together in (("symbolic, consecutive", False), ("symbolic, simultaneous", True)):
        seconds = source_a(symbolic(), few, together)[-1] * POINTS / len(few)
        found[name] = {"seconds": seconds, "gives": f"all nine; from {len(few)} points"}
    return found


def of_peers(motion: Motion) -> tuple[dict, dict]:
    """The two other programs: seconds, and what they do where the loop cannot close."""
    python = THEIRS / "bin" / "python"
    if not python.exists():
        uv = [sys.executable, "-m", "uv"]
        subprocess.run([*uv, "venv", "--quiet", "--python", sys.executable, THEIRS], check=True)
        packages = [
            f"{name}=={number}" for name, number in (PEERS | {n: version(n) for n in ("numpy", "scipy")}).items()
        ]
        subprocess.run([*uv, "pip", "install", "--quiet", "--python", python, *packages], check=True)
    exact, found, astray = by_closed_form(motion), {}, {}
    short = Hacksaw(r3=SHORT)
    open_ = short.gap(motion.position) > 0
    along = short.position(motion.position[~open_])
    along = along[:, 0] * np.cos(along[:, 1])
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "crank.npy"
        np.save(file, [motion.position, motion.velocity, motion.acceleration])
        run = lambda r3: json.loads(subprocess.check_output([python, peers.__file__, file, str(r3)]))
        for name, of in run(R3).items():
            off = np.abs(np.array(of["slider"][0]) - exact[:, 0] * np.cos(exact[:, 1])).max()
            found[name] = {"seconds": of["seconds"], "off": off, "gives": "the slider", "version": PEERS[name]}
        for name, of in run(SHORT).items():
            if isinstance(of["slider"], str):
                astray[name] = {"refuses": of["slider"].partition(":")[0]}
                continue
            x = np.array(of["slider"][0], dtype=float)
            elsewhere = ~(np.abs(x[~open_] - along) < 1e-6)
            astray[name] = {
                "numbers where it is open": int(np.isfinite(x[open_]).sum()),
                "elsewhere": int(elsewhere.sum()),
            }
    left_out = batched(short, motion, SEED, PRECISE, open_points="leave out")
    q = left_out.position
    elsewhere = ~(np.abs(q[~open_, 0] * np.cos(q[~open_, 1]) - along) < 1e-6)
    astray["mechlib"] = {
        "numbers where it is open": int(np.isfinite(q[open_]).any(axis=1).sum()),
        "elsewhere": int(elsewhere.sum()),
    }
    return found, {"open": int(open_.sum()), "closed": int((~open_).sum()), **astray}


def growth() -> list[dict[str, float]]:
    """Time and memory of the batched sweep, for ever more points."""
    found = []
    for points in SIZES:
        motion = run_up(points)
        seconds = best(lambda: batched(SAW, motion, SEED, PRECISE), tries=3)  # noqa: B023
        tracemalloc.start()
        sweep = batched(SAW, motion, SEED, PRECISE)
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        kept = nine(sweep).nbytes + sweep.iterations.nbytes + sweep.errors.nbytes
        found.append(
            {"points": points, "seconds": seconds, "result, MB": kept / 1e6, "beside it, MB": (peak - kept) / 1e6}
        )
    return found


def figure_14(motion: Motion) -> dict[str, dict[str, list[float]]]:
    """Cumulative seconds of both solvers, at each tenth point."""
    forms = {
        "compiled, three stages iterated": (compiled(), False),
        "compiled, linear stages solved once": (compiled(linear=True), False),
        "compiled, simultaneous": (compiled(), True),
    }
    runs = {name: [source_a(solve, motion, together) for _ in range(3)] for name, (solve, together) in forms.items()}
    return {name: min(tried, key=lambda seconds: seconds[-1])[9::10] for name, tried in runs.items()}


def missed(found: dict) -> list[str]:
    seconds = {name: way["seconds"] for name, way in found["ways"].items()}
    batch, sizes = seconds["batched Newton"], found["growth"]
    faster, slower = seconds["scipy.optimize.root, a loop"] / batch, batch / seconds["closed form"]
    a_point = [1e6 * size["seconds"] / size["points"] for size in sizes]
    more = [size["beside it, MB"] - size["points"] * 9e-6 for size in sizes]  # which points: an index and a mark each
    said = []
    if faster < FASTER:
        said.append(f"batched Newton is {faster:.1f} times as fast as the loop, where {FASTER:g} was to be reached")
    if slower > SLOWER:
        said.append(f"batched Newton takes {slower:.1f} times as long as the closed form, where {SLOWER:g} is allowed")
    if max(a_point) > 2 * min(a_point):
        said.append(f"the time is not in proportion: {min(a_point):.2f} to {max(a_point):.2f} us a point")
    if more[-1] > more[0] + 10:
        said.append(f"the memory beside the result grows from {more[0]:.0f} to {more[-1]:.0f} MB")
    return said


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--keep", action="store_true", help=f"write {KEPT.relative_to(ROOT)}")
    asked = parser.parse_args()
    motion = run_up(POINTS)
    found = {
        "date": datetime.date.today().isoformat(),
        "computer": computer(),
        "versions": {name: version(name) for name in ("numpy", "scipy", "sympy")} | PEERS,
        "points": POINTS,
        "ways": ways(motion),
        "cumulative": figure_14(motion),
        "parts, us": parts(),
        "growth": growth(),
    }
    theirs, found["open"] = of_peers(motion)
    found["ways"] |= theirs

    console = Console(soft_wrap=True, highlight=False)
    table = Table("", "ms", "times the closed form", "off", "gives", title=f"{POINTS} points")
    exact = found["ways"]["closed form"]["seconds"]
    for name, way in found["ways"].items():
        off = f"{way['off']:.0e}" if "off" in way else ""
        table.add_row(name, f"{1e3 * way['seconds']:.3g}", f"{way['seconds'] / exact:.3g}", off, way["gives"])
    console.print(table)
    for title, rows in (
        ("cumulative, s", {n: s[-1] for n, s in found["cumulative"].items()}),
        ("us", found["parts, us"]),
    ):
        console.print(title, *(f"  {name}: {value:.3g}" for name, value in rows.items()), sep="\n", markup=False)
    for row in (*found["growth"], found["open"], found["computer"]):
        console.print(
            *(f"{k}: {v:.3g}" if isinstance(v, float) else f"{k}: {v}" for k, v in row.items()), sep=", ", markup=False
        )

    void = [name for name, way in found["ways"].items() if not way.get("off", 0) < SAME]
    for name in void:
        console.print(f"void: {name} is {found['ways'][name]['off']:.1e} off")
    lacking = missed(found)
    for sentence in lacking:
        console.print(f"missed: {sentence}")
    if asked.keep and not void:
        KEPT.parent.mkdir(exist_ok=True)
        KEPT.write_text(json.dumps(found, indent=1) + "\n", "utf-8")
    return 2 if void else 1 if lacking else 0


if __name__ == "__main__":
    sys.exit(main())
