"""What a command or a call costs: seconds, and a command the memory of every process that it starts. Linux only."""

import gc
import os
import platform
import subprocess
import sys
import tempfile
import threading
import time
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

INTERVAL = 0.2  # s, between two looks at the memory
AUTOGRADER = [sys.executable, "-m", "autograder.cli"]
MB = 1e6


@dataclass(frozen=True)
class Sample:
    """Memory at one moment.

    Attributes
    ----------
    seconds : since the command began.
    tree : MB of the command and all that it started (PSS: what processes share is counted once).
    root : MB of the command's own process.
    """

    seconds: float
    tree: float
    root: float


@dataclass(frozen=True)
class Cost:
    """What a command took, and what it said."""

    seconds: float
    samples: tuple[Sample, ...]
    said: str

    @property
    def peak(self) -> float:
        """The most that the whole tree held, MB."""
        return max(sample.tree for sample in self.samples)

    def between(self, begin: float, end: float) -> list[Sample]:
        """The samples of a part of the run, given as fractions of its time."""
        return [s for s in self.samples if begin <= s.seconds / self.seconds <= end]


def cost(command: list[str], cwd: Path | None = None, env: dict[str, str] | None = None) -> Cost:
    """Run a command to its end, and look at its memory all the while.

    Raises
    ------
    RuntimeError
        If it fails; the message is the end of what it said.
    """
    samples, over = [], threading.Event()

    def look():
        while not over.is_set():
            tree, root = memory(process.pid)
            samples.append(Sample(time.perf_counter() - begin, tree / MB, root / MB))
            over.wait(INTERVAL)

    with tempfile.TemporaryFile("w+", errors="replace") as said:
        begin = time.perf_counter()
        process = subprocess.Popen(command, cwd=cwd, env=env, stdout=said, stderr=subprocess.STDOUT)
        watch = threading.Thread(target=look, daemon=True)
        watch.start()
        code = process.wait()
        seconds = time.perf_counter() - begin
        over.set()
        watch.join()
        said.seek(0)
        text = said.read()
    if code:
        raise RuntimeError(f"{' '.join(map(str, command))} ended with {code}:\n{text[-2_000:]}")
    return Cost(seconds, tuple(s for s in samples if s.tree), text)


def memory(root: int) -> tuple[int, int]:
    """Bytes of a process with all its descendants, and of itself alone."""
    held = {pid: _bytes(pid) for pid in tree(root)}
    return sum(held.values()), held[root]


def tree(root: int) -> list[int]:
    """A process and its descendants, whatever namespace they are in."""
    children = defaultdict(list)
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            stat = Path("/proc", name, "stat").read_text(errors="replace")
        except OSError:
            continue  # it has ended
        children[int(stat.rpartition(")")[2].split()[1])].append(int(name))
    found = [root]
    for pid in found:
        found += children[pid]
    return found


def _bytes(pid: int) -> int:
    """Proportional share of the memory; all that is resident where only root may know the share; 0 if it is gone."""
    try:
        with open(f"/proc/{pid}/smaps_rollup") as rollup:
            return next(1024 * int(line.split()[1]) for line in rollup if line.startswith("Pss:"))
    except PermissionError:
        pass
    except (OSError, StopIteration):
        return 0
    try:
        return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return 0


def best(work: Callable[[], object], calls: int = 1, tries: int = 5) -> float:
    """Seconds of one call: the best of some tries, for other work on the computer only ever adds."""
    seconds = []
    gc.disable()
    for _ in range(tries):
        begin = time.perf_counter()
        for _ in range(calls):
            work()
        seconds.append((time.perf_counter() - begin) / calls)
    gc.enable()
    return min(seconds)


def computer() -> dict[str, str | int | float]:
    """The computer that a figure was measured on, and how busy it is: with more to do than cores, times mean little."""
    names = [line for line in Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("model name")]
    return {
        "processor": names[0].partition(":")[2].strip() if names else platform.machine(),
        "cores": len(os.sched_getaffinity(0)),
        "memory, GB": round(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 1e9),
        "system": f"{platform.system()} {platform.release()}",
        "python": platform.python_version(),
        "load": os.getloadavg()[0],
    }
