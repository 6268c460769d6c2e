"""The judge's end of a worker: questions with a deadline, answers as data.

The asker answers the worker's own questions on the way to its answer.  Beside it one thread reads what the worker
prints, and another ends the worker when its time is over.
"""

import os
import re
import secrets
import select
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

from .outcome import Raised, Value
from .worker import wire
from .worker.wire import NotData, ProtocolError, WorkerLost

__all__ = [
    "Excess",
    "NotData",
    "OutputFlood",
    "ProtocolError",
    "Raised",
    "Ran",
    "TimeLimit",
    "Value",
    "Worker",
    "WorkerDied",
    "WorkerLost",
]

POSIX = os.name == "posix"
ARGUMENTS_MOST = 4 << 20  # bytes; what the judge makes of them may be far larger
OUTPUT_KEPT = 64 << 10
OUTPUT_MOST = 4 << 20
WALL = 4  # times the limit of computing time: by the clock ends what sleeps; a busy computer ends nothing
LOOK = 0.1  # s between two looks at the computing time
SETTLING = 0.25  # s, for what was printed to arrive: only a worker that closed its output makes us wait that long
DYING = 1.0  # s, for the last output of a killed worker: only a process that outlives it makes us wait that long
COLOURS = re.compile(r"\x1b\[[0-?]*[ -/]*[@-~]")
ADDRESS = re.compile(r"\b0x[0-9a-fA-F]{6,}\b")
CONTROLS = re.compile("[\0-\b\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")


class WorkerDied(WorkerLost):
    """The worker ended by itself, or was ended by a limit of the system."""


class TimeLimit(WorkerLost):
    """The worker computed, or kept us waiting, for longer than it may."""


class OutputFlood(WorkerLost):
    """The worker printed more than anybody could read."""


class Excess(WorkerLost):
    """The worker took more of the disk than it may."""


@dataclass(frozen=True)
class Ran:
    """A cell has run; `raised` is what ended it early, `note` what the reader of a report should know."""

    raised: Raised | None
    note: str | None


class Process(Protocol):
    """What a channel must be able to do to the process at its other end."""

    def kill(self) -> None: ...

    def computing_time(self) -> float:
        """Seconds that its threads have computed, together."""

    def excess(self) -> str | None:
        """What it has too much of, where the system itself does not ration it."""

    def bury(self) -> None:
        """Wait for its end, and remove its files."""


class Worker:
    """One submission's process.

    Every question has a limit in seconds of computing time, so that a busy computer changes no verdict; by the clock
    the worker may take `WALL` times as long.

    Parameters
    ----------
    requests, replies, output : file descriptors, which the worker takes over
    process : Process
    """

    def __init__(self, requests: int, replies: int, output: int, process: Process):
        self._requests, self._replies = requests, wire.Source(replies, partial(self._wait, replies))
        self._process = process
        self._gone, self._talking, self._ending = False, False, threading.Lock()
        self._output, self._watch = _Output(output, self._kill), _Watch(process, self._kill)
        if POSIX:
            os.set_blocking(requests, False)  # it may be full, and the worker may not read

    def __enter__(self) -> "Worker":
        return self

    def __exit__(self, *_) -> None:
        self.close()

    def start(self, modules: dict[str, str], seconds: float) -> None:
        """Hand over the modules that may be imported, as source text by path; to be called once, before all else."""

        def ready(header, body):
            if header.get("ready") is not True:
                raise ProtocolError("not ready")

        self._ask({"ask": "start", "modules": modules}, b"", seconds, (), ready)

    def run(self, source: str, seconds: float) -> Ran:
        """Run one cell.

        Raises
        ------
        WorkerLost
            If the worker did not get through it; it cannot be used any more.
        """

        def ran(header, body):
            note = header.get("note")
            return Ran(_raised(header), None if note is None else printable(wire.text(note, 1_000)))

        return self._ask({"ask": "run", "source": source}, b"", seconds, (), ran)

    def call(
        self,
        name: str,
        arguments: Sequence = (),
        options: dict[str, Any] | None = None,
        *,
        seconds: float,
        seed: int = 0,
    ) -> Value | Raised:
        """Call a function of the submission.

        Parameters
        ----------
        arguments, options
            Data, or functions, at any depth.  A function stays here: the worker asks for its values one by one.
        seed : int
            Where the global random generators begin, so that no call depends on the draws of an earlier one.

        Raises
        ------
        WorkerLost
            If there was no proper answer in time; the worker cannot be used any more.
        """
        functions = []

        def refer(value):
            if not callable(value):
                wire.refuse(value)
            functions.append(value)
            return ["function", len(functions) - 1]

        code, arrays = wire.encode((tuple(arguments), dict(options or {})), refer)

        def answer(header, body):
            return _raised(header) or Value(wire.decode(header.get("value"), body))

        question = {"ask": "call", "name": name, "arguments": code, "seed": seed}
        return self._ask(question, arrays, seconds, functions, answer)

    @property
    def output(self) -> str:
        """What the code has printed so far: the first 64 KiB, without control characters."""
        if not self._gone:
            with suppress(WorkerLost):
                self._output.settle(self._ask({"ask": "mark"}, b"", SETTLING, (), lambda header, body: header["id"]))
        return printable(COLOURS.sub("", self._output.kept().decode("utf-8", "replace")))

    def close(self) -> None:
        """End the worker; its files go with it."""
        with self._ending:
            if self._gone:
                return
            self._gone = True
            self._watch.over.set()
            self._process.kill()
            self._process.bury()
            if not self._talking:
                self._hang_up()
        self._output.join(DYING)

    def _hang_up(self) -> None:
        """Close the pipes; never under a thread that still reads them, for their numbers are soon another worker's."""
        os.close(self._requests)
        os.close(self._replies.fd)

    def _kill(self) -> None:
        with self._ending:
            if not self._gone:
                self._process.kill()

    def _ask(self, question, body, seconds, functions, read):
        """Put a question, and give what `read` makes of the answer."""
        with self._ending:
            if self._gone:
                raise WorkerDied("this worker is gone")
            self._talking = True
        found, error = None, None
        try:
            with self._watch.limit(seconds):
                found = self._converse(question, body, functions, read)
        except (EOFError, OSError):
            error = WorkerDied("the process ended before it answered")
        except BaseException as other:
            error = other
        with self._ending:
            self._talking = False
            if self._gone:
                self._hang_up()
        if error is None:
            return found
        self.close()
        if self._output.flooded:
            raise OutputFlood(f"more than {OUTPUT_MOST >> 20} MiB of output") from None
        raise self._watch.verdict or error

    def _converse(self, question, body, functions, read):
        identity = secrets.token_hex(8)
        self._send({"id": identity, **question}, body)
        while True:
            header, body = wire.receive(self._replies)
            if header.get("id") != identity:
                raise ProtocolError("an answer to a question that nobody asked")
            if "evaluate" not in header:
                return read(header, body)
            reply, arrays = _evaluate(functions, header, body)
            self._send({"id": identity, **reply}, arrays)

    def _send(self, header: dict, body: bytes) -> None:
        wire.send(self._requests, header, body, partial(self._wait, self._requests, writing=True))

    def _wait(self, fd: int, writing: bool = False) -> None:
        """Until something can be read or written; a killed process may leave others behind that hold the pipe open.

        Where nothing can wait for a pipe, no process inherits one.
        """
        while POSIX and not any(select.select([fd][writing:], [fd][: int(writing)], [], LOOK)):
            if self._gone or self._watch.verdict or self._output.flooded:
                raise EOFError


class _Watch(threading.Thread):
    """Looks ten times a second whether a question takes longer than it may, or the worker has too much of something."""

    def __init__(self, process: Process, kill: Callable[[], None]):
        super().__init__(daemon=True)
        self.process, self.kill = process, kill
        self.over, self.lock = threading.Event(), threading.Lock()
        self.ends: tuple[float, float, float] | None = None  # by computing time, by the clock, and what was allowed
        self.verdict: WorkerLost | None = None
        self.start()

    def run(self) -> None:
        while not self.over.wait(LOOK):
            with self.lock:  # no question ends between the look and the kill
                if self.ends and (verdict := self._excess() or self._late(*self.ends)):
                    self.verdict = verdict
                    self.kill()
                    return

    @contextmanager
    def limit(self, seconds: float) -> Iterator[None]:
        """Hold the worker to so many seconds of computing, and `WALL` times as many by the clock."""
        if excess := self._excess():
            raise excess
        self.ends = self.process.computing_time() + seconds, time.monotonic() + WALL * seconds, seconds
        yield
        with self.lock:
            self.ends = None
        if self.verdict:
            raise self.verdict

    def _excess(self) -> Excess | None:
        excess = self.process.excess()
        return Excess(excess) if excess else None

    def _late(self, computed: float, clock: float, seconds: float) -> TimeLimit | None:
        if self.process.computing_time() < computed and time.monotonic() < clock:
            return None
        return TimeLimit(f"no answer within {seconds:g} s")


class _Output(threading.Thread):
    """Reads what the worker prints, all the time, so that it never has to wait for us."""

    def __init__(self, fd: int, kill: Callable[[], None]):
        super().__init__(daemon=True)
        self.fd, self.kill = fd, kill
        self.data, self.ended, self.flooded = bytearray(), False, False
        self.changed = threading.Condition()
        self.start()

    def run(self) -> None:
        while part := self._read():
            with self.changed:
                if not self.flooded:
                    self.data += part
                    self.flooded = len(self.data) > OUTPUT_MOST
                self.changed.notify_all()
            if self.flooded:
                self.kill()
        with self.changed:
            self.ended = True
            self.changed.notify_all()
        os.close(self.fd)

    def _read(self) -> bytes:
        try:
            return os.read(self.fd, 1 << 16)
        except OSError:
            return b""

    def settle(self, identity: str) -> None:
        """Wait until everything is here that was printed before a mark, and take the mark away."""
        mark = f"\0{identity}\0".encode()
        with self.changed:
            self.changed.wait_for(lambda: self.ended or mark in self.data, SETTLING)
            self.data = self.data.replace(mark, b"", 1)

    def kept(self) -> bytes:
        with self.changed:
            return bytes(self.data[:OUTPUT_KEPT])


def printable(string: str) -> str:
    """Without the characters that move a cursor or turn the direction of reading, or differ from run to run."""
    return ADDRESS.sub("0x...", CONTROLS.sub("", string))


def _evaluate(functions, header, body) -> tuple[dict, bytes]:
    """One value of one of the judge's functions, as the worker asked for it."""
    index = header["evaluate"]
    if type(index) is not int or not 0 <= index < len(functions):
        raise ProtocolError("a function that was never given")
    if len(body) > ARGUMENTS_MOST:
        return {"raised": ["ValueError", f"a function was called with more than {ARGUMENTS_MOST >> 20} MiB"]}, b""
    called = wire.decode(header.get("arguments"), body)
    if type(called) is not tuple or len(called) != 2 or type(called[0]) is not tuple or type(called[1]) is not dict:
        raise ProtocolError("arguments that are none")
    arguments, options = called
    if not all(type(name) is str for name in options):
        raise ProtocolError("an argument whose name is no text")
    try:
        value = functions[index](*arguments, **options)
    except Exception as error:
        return {"raised": [type(error).__name__, str(error)]}, b""
    code, arrays = wire.encode(value)
    return {"value": code}, arrays


def _raised(header: dict) -> Raised | None:
    found = header.get("raised")
    if found is None:
        return None
    if type(found) is not list or len(found) != 3 or type(found[1]) is not list or len(found[1]) > 20:
        raise ProtocolError("an exception that is none")
    kind, bases, message = found
    return Raised(
        printable(wire.text(kind, 80)),
        tuple(printable(wire.text(base, 80)) for base in bases),
        printable(wire.text(message, 2_000)),
    )
