"""What this computer can do to keep a submission to itself, found out by doing it.

`namespaces`
    Own user, process, network, mount and message namespaces (bubblewrap), a work folder in memory, Landlock where the
    kernel has it, filtered system calls, limits.
`landlock`
    Landlock, filtered system calls, limits: files and network are closed; the disk is
    rationed by looking at it, ten times a second.
`limits`
    Memory, time and file size are limited; the code can read what you can read, and use the network.
`none`
    A process of its own and a wall clock.
"""

import os
import platform
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path

from .sandbox import LEVELS, IsolationError, probe

__all__ = ["LEVELS", "IsolationError", "Level", "Survey", "choose", "survey"]

FOR_OTHERS = "landlock"  # the least that other people's work is run under, unless asked for by name
APPARMOR = "/proc/sys/kernel/apparmor_restrict_unprivileged_userns"
PROFILE = Path(__file__).resolve().parent / "data" / "bwrap.apparmor"


@dataclass(frozen=True)
class Level:
    """One level on this computer; `reason` says why it cannot be had, `advice` what would help."""

    name: str
    available: bool
    reason: str = ""
    advice: str = ""


@dataclass(frozen=True)
class Survey:
    """All levels, best first."""

    levels: tuple[Level, ...]

    @property
    def best(self) -> str | None:
        """The best level there is; None where not even a plain process can be had."""
        return next((level.name for level in self.levels if level.available), None)

    def __getitem__(self, name: str) -> Level:
        return next(level for level in self.levels if level.name == name)

    def as_dict(self) -> dict:
        return {"best": self.best, "levels": [asdict(level) for level in self.levels]}


@cache
def survey() -> Survey:
    """Try every level, once in a process."""
    return Survey(tuple(_try(name) for name in LEVELS))


def choose(floor: str | None = None, others: bool = False) -> str:
    """The level to run under: always the best there is.

    Parameters
    ----------
    floor : one of `LEVELS`, or None
        The least that will do. Left out, it is `landlock` for other people's code, and `none` for your own.
    others : bool
        Whether the code is other people's.

    Raises
    ------
    IsolationError
        If the best is not good enough.
    """
    if floor is not None and floor not in LEVELS:
        raise IsolationError(f"there is no isolation level {floor!r}: choose one of {', '.join(LEVELS)}")
    found = survey()
    best = found.best or LEVELS[-1]
    if floor is None and others and LEVELS.index(best) > LEVELS.index(FOR_OTHERS):
        raise IsolationError(
            f"this computer offers no isolation better than {best} ({_why(found[FOR_OTHERS])}), too little for "
            f"other people's work: --isolation {best} runs it all the same"
        )
    needed = found[floor or LEVELS[-1]]
    if LEVELS.index(best) > LEVELS.index(needed.name) or not found[best].available:
        raise IsolationError(f"isolation {needed.name} cannot be had on this computer: {_why(needed)}")
    return best


def statement(level: str) -> str:
    """What a report says of the level that it was made under: why it is not a better one, and what would raise it."""
    said = [f"Isolation: {level}."]
    for name in LEVELS[: LEVELS.index(level)]:
        better = survey()[name]
        said.append(f"{name} can be had as well." if better.available else f"{name} cannot be had: {_why(better)}.")
    return " ".join(said)


def _why(level: Level) -> str:
    return "; ".join(filter(None, (level.reason, level.advice)))


def _try(name: str) -> Level:
    if platform.system() != "Linux" and name in ("namespaces", "landlock"):
        return Level(name, False, f"{platform.system()} has no such thing", "grade on Linux, or in WSL 2 on Windows")
    try:
        probe(name)
    except IsolationError as error:
        return Level(name, False, str(error), _advice(name, str(error)))
    return Level(name, True)


def _advice(name: str, reason: str) -> str:
    """What a person could do about it; empty where we do not know."""
    if "pyseccomp" in reason:
        return 'in the folder of the course, pip install -c requirements.lock -e ".[grade]"'
    if "filtered" in reason:
        return "install libseccomp: sudo apt install libseccomp2"
    if "not installed" in reason:
        return "sudo apt install bubblewrap"
    if "nknown option" in reason:
        return "bubblewrap 0.8 or later is needed"
    if "become nobody" in reason:
        return "run it as an ordinary user"
    if name == "namespaces" and _one_in(APPARMOR):
        return f"let bubblewrap make user namespaces by an AppArmor profile (untried): {PROFILE}"
    if name == "namespaces" and (os.path.exists("/.dockerenv") or os.path.exists("/run/.containerenv")):
        return "a container forbids namespaces, unless it is started with --security-opt seccomp=unconfined"
    return ""


def _one_in(path: str) -> bool:
    try:
        return Path(path).read_text().strip() == "1"
    except OSError:
        return False
