"""The coupler point of source D thrown by mechlib, by a loop and by plain NumPy: the numbers, how long, what memory.

python tests/benchmarks/fourbar.py [--keep]

Exit code: 0 every bound is reached, 1 one is missed, 2 the numbers are not the same, and the comparison is void.
"""

import argparse
import datetime
import json
import multiprocessing
import random
import statistics
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from importlib.metadata import version
from math import atan2, cos, sin, sqrt
from pathlib import Path

import numpy as np
from measuring import MB, best, computer
from rich.console import Console
from rich.table import Table

from mechlib.fourbar import LENGTHS, FourBar
from mechlib.laws import tolerances
from mechlib.uncertainty import BLOCK, TASK, Varied, monte_carlo

ROOT = Path(__file__).resolve().parents[2]
KEPT = ROOT / "book" / "measured" / "fourbar.json"
VERIFIED = np.loadtxt(ROOT / "book" / "data" / "fourbar_verified.csv", delimiter=",", skiprows=1)

ANGLES, MEAN, DEVIATION = VERIFIED[:, 0], VERIFIED[:, 1:3], VERIFIED[:, 3:5]
REALISATIONS = 1_000_000  # of the verified table
NOMINAL = [getattr(FourBar(), name) for name in LENGTHS]
HALF = 1e-5  # m, of the tolerances
SEED = 1

FEW, MANY = 10_000, 10_000_000
TRIES = {FEW: 7, 1_000_000: 9, MANY: 3}  # throws: tries
AT = 1_000_000  # throws that the bounds are for
LONG = 100_000_000  # throws of one angle
MECHLIB, NUMPY, LOOP = "mechlib", "plain NumPy", "a loop, statistics"
BOTH = f"{MECHLIB}, two processes"
FASTER = {LOOP: 100.0, NUMPY: 6.0}
EXTRA = 10.0  # MB that so many throws may take more than one block
SURE = 5.0  # standard errors

Found = tuple[np.ndarray, np.ndarray]  # mean and deviation at each angle, (10, 2)


# --- the ways ---------------------------------------------------------------------------------------------------------


def by_mechlib(throws: int, angles: np.ndarray = ANGLES, executor: Executor | None = None) -> Found:
    point = partial(FourBar.coupler_point, theta2=angles[:, None], open_points="leave out")
    law = tolerances(NOMINAL, HALF)
    moments = monte_carlo(Varied(FourBar(), LENGTHS, point), law, throws, SEED, executor).moments
    return moments.mean, moments.deviation


def by_numpy(throws: int) -> Found:
    """All throws at once, by the formulas of source D: what most people would write."""
    rng = np.random.default_rng(SEED)
    r1, r2, r3, r4, rcx, rcy = (rng.uniform(length - HALF, length + HALF, (throws, 1)) for length in NOMINAL)
    c, s = np.cos(ANGLES), np.sin(ANGLES)
    l1, l2, l3 = r1 / r2, r1 / r3, (r4**2 - r1**2 - r2**2 - r3**2) / (2 * r2 * r3)
    ka, kb, kc = c - l1 + l2 * c + l3, -2 * s, l1 + (l2 - 1) * c + l3
    th3 = 2 * np.arctan2(-kb - np.sqrt(kb**2 - 4 * ka * kc), 2 * ka)
    x = r2 * c + rcx * np.cos(th3) - rcy * np.sin(th3)
    y = r2 * s + rcx * np.sin(th3) + rcy * np.cos(th3)
    mean, deviation = ([x.mean(axis=0), y.mean(axis=0)], [x.std(axis=0, ddof=1), y.std(axis=0, ddof=1)])
    return np.stack(mean, axis=-1), np.stack(deviation, axis=-1)


def one_point(r1: float, r2: float, r3: float, r4: float, rcx: float, rcy: float, th2: float) -> tuple[float, float]:
    l1, l2, l3 = r1 / r2, r1 / r3, (r4**2 - r1**2 - r2**2 - r3**2) / (2 * r2 * r3)
    ka, kb, kc = cos(th2) - l1 + l2 * cos(th2) + l3, -2 * sin(th2), l1 + (l2 - 1) * cos(th2) + l3
    th3 = 2 * atan2(-kb - sqrt(kb**2 - 4 * ka * kc), 2 * ka)
    x = r2 * cos(th2) + rcx * cos(th3) - rcy * sin(th3)
    y = r2 * sin(th2) + rcx * sin(th3) + rcy * cos(th3)
    return x, y


def points(throws: int) -> Iterator[list[float]]:
    """Of a throw after the other, x and y at each angle."""
    rng, angles = random.Random(SEED), ANGLES.tolist()
    for _ in range(throws):
        lengths = [rng.uniform(length - HALF, length + HALF) for length in NOMINAL]
        yield [number for th2 in angles for number in one_point(*lengths, th2)]


def by_loop(throws: int) -> Found:
    """With what Python brings."""
    columns = list(zip(*points(throws), strict=True))
    mean, deviation = ([of(column) for column in columns] for of in (statistics.fmean, statistics.stdev))
    return np.reshape(mean, (-1, 2)), np.reshape(deviation, (-1, 2))


def by_loop_into_array(throws: int) -> Found:
    """The quicker loop: `statistics` adds up without any rounding, which takes longer than the points."""
    numbers = np.reshape(list(points(throws)), (throws, -1, 2))
    return numbers.mean(axis=0), numbers.std(axis=0, ddof=1)


SERIAL = {MECHLIB: by_mechlib, NUMPY: by_numpy, LOOP: by_loop, "a loop, into an array": by_loop_into_array}


# --- what they take ---------------------------------------------------------------------------------------------------


def fresh(processes: int) -> ProcessPoolExecutor:
    return ProcessPoolExecutor(processes, multiprocessing.get_context("spawn"))


def of_ways(tries: dict[int, int], memory: dict[str, float]) -> dict[str, dict]:
    """Each way: seconds by the number of throws, and how far its numbers are from the verified table.

    The seconds are the median, and not the quickest: the kernel gives large arrays now large pages and now small ones,
    and plain NumPy takes once and a half as long with the small ones.

    A loop is timed with few throws only, and plain NumPy with many only if the computer has the memory for them.
    """
    found = {}
    with ThreadPoolExecutor(2) as threads, fresh(2) as processes:
        ways = SERIAL | {
            f"{MECHLIB}, two threads": partial(by_mechlib, executor=threads),
            BOTH: partial(by_mechlib, executor=processes),
        }
        for throws, times in tries.items():
            ready = {name: way for name, way in ways.items() if throws == FEW or "loop" not in name}
            if throws == MANY and available() < needed(memory):
                del ready[NUMPY]
            for name, way in ready.items():  # also so that the processes are there
                each = found.setdefault(name, {"seconds": {}, "off": 0.0})
                each["off"] = max(each["off"], off(*way(throws), throws))
            taken = [  # one after the other, so that what else the computer does slows all alike
                [best(partial(way, throws), tries=1) for way in ready.values()] for _ in range(times)
            ]
            for name, seconds in zip(ready, np.median(taken, axis=0), strict=True):
                found[name]["seconds"][str(throws)] = float(seconds)
    return found


def off(mean: np.ndarray, deviation: np.ndarray, throws: int) -> float:
    """The farthest from the verified table, in standard errors: those of normal results, which these nearly are."""
    error = DEVIATION * np.sqrt(1 / throws + 1 / REALISATIONS)
    return float(max(np.abs((mean - MEAN) / error).max(), np.abs((deviation - DEVIATION) * np.sqrt(2) / error).max()))


def of_memory() -> dict[str, float]:
    """The most that a fresh process holds, MB."""
    return {"one block": peak(by_mechlib, BLOCK), MECHLIB: peak(by_mechlib, AT), NUMPY: peak(by_numpy, AT)}


def peak(way: Callable[[int], Found], throws: int) -> float:
    """Of a process that does this and nothing else, MB."""
    with fresh(1) as alone:
        alone.submit(way, throws).result()
        return alone.submit(held).result()


def held() -> float:
    """The most that this process has held, MB."""
    return _kilobytes("/proc/self/status", "VmHWM") * 1024 / MB


def available() -> float:
    """What the computer can still give, MB."""
    return _kilobytes("/proc/meminfo", "MemAvailable") * 1024 / MB


def _kilobytes(file: str, name: str) -> int:
    return next(int(line.split()[1]) for line in Path(file).read_text().splitlines() if line.startswith(f"{name}:"))


def needed(memory: dict[str, float]) -> float:
    """What plain NumPy takes for many throws, MB."""
    return (memory[NUMPY] - memory["one block"]) * MANY / AT


def of_long(throws: int) -> dict[str, dict[str, float]]:
    """Very many throws of one angle: seconds, and the most that a process holds, MB."""
    work = partial(by_mechlib, throws, ANGLES[:1])
    with fresh(1) as alone, fresh(2) as both:
        by_mechlib(2 * BLOCK * TASK, executor=both)  # so that they are there
        return {
            "one process": {
                "seconds": alone.submit(best, work, tries=1).result(),
                "held": alone.submit(held).result(),
            },
            "two processes": {
                "seconds": best(partial(work, executor=both), tries=1),
                "held": max(both.submit(held).result() for _ in range(4)),
            },
        }


# --- the comparison ---------------------------------------------------------------------------------------------------


def rate(way: dict, throws: int) -> float:
    """Throws times angles in a second."""
    return throws * len(ANGLES) / way["seconds"][str(throws)]


def faster(ways: dict[str, dict], ours: str = MECHLIB) -> dict[str, float]:
    """How many times the rate of each other way that of mechlib is, with a million throws."""
    rate_of_ours = rate(ways[ours], AT)
    return {name: rate_of_ours / rate(ways[name], AT if str(AT) in ways[name]["seconds"] else FEW) for name in ways}


def missed(found: dict) -> list[str]:
    alone, both = (faster(found["ways"], ours) for ours in (MECHLIB, BOTH))
    extra = found["memory"][MECHLIB] - found["memory"]["one block"]
    return [
        f"mechlib is {alone[name]:.1f} times as fast as {name}, and {both[name]:.1f} times with two processes, "
        f"where {bound:g} was to be reached"
        for name, bound in FASTER.items()
        if max(alone[name], both[name]) < bound
    ] + [f"{AT} throws take {extra:.1f} MB more than a block, where {EXTRA:g} were allowed"] * (extra >= EXTRA)


def void(found: dict) -> list[str]:
    """Ways whose numbers are others."""
    return [
        f"{name} is {way['off']:.1f} standard errors off the verified table"
        for name, way in found["ways"].items()
        if not way["off"] < SURE
    ]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--keep", action="store_true", help=f"write {KEPT.relative_to(ROOT)}; some minutes")
    asked = parser.parse_args()
    memory = of_memory()
    found = {
        "date": datetime.date.today().isoformat(),
        "computer": computer(),
        "versions": {name: version(name) for name in ("numpy", "scipy")},
        "angles": len(ANGLES),
        "memory": memory,
        "ways": of_ways(TRIES, memory),
    }
    if asked.keep:
        found["long"] = of_long(LONG)

    console = Console(soft_wrap=True, highlight=False)
    table = Table("", "throws", "s", "throws x angles a second", title=f"{len(ANGLES)} angles")
    for name, way in found["ways"].items():
        for throws, seconds in way["seconds"].items():
            table.add_row(name, throws, f"{seconds:.3g}", f"{rate(way, int(throws)):.3g}")
    console.print(table)
    table = Table("", "mechlib faster, times", "with two processes", "off, standard errors", title=f"{AT} throws")
    alone, both = (faster(found["ways"], ours) for ours in (MECHLIB, BOTH))
    for name, way in found["ways"].items():
        table.add_row(name, f"{alone[name]:.3g}", f"{both[name]:.3g}", f"{way['off']:.1f}")
    console.print(table)
    console.print("held at most, MB:", "; ".join(f"{name}: {most:.1f}" for name, most in memory.items()))
    if str(MANY) not in found["ways"][NUMPY]["seconds"]:
        console.print(f"left out: {MANY} throws by {NUMPY}, which take {needed(memory):.0f} MB; there are not so many.")
    for name, long in found.get("long", {}).items():
        console.print(f"{LONG} throws x 1 angle, {name}: {long['seconds']:.3g} s, {long['held']:.1f} MB")
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
