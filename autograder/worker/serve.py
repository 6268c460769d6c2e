"""Answers the judge's questions, one at a time, with what the submission's functions give."""

import builtins
import os
import random
import sys
import threading
from collections.abc import Callable

import numpy as np

from . import course, shell, wire

SEED = 0
FIRST = "pass"  # a forked worker copies what a cell touches, and this one before anybody waits for it
# held here: a submission may well write np.random.seed = 1
GLOBAL_GENERATORS = random.seed, np.random.seed


def private_descriptors() -> tuple[int, int]:
    """Take requests and replies away from descriptors 0 and 1; what the code prints goes where 2 goes."""
    requests, replies = os.dup(0), os.dup(1)
    null = os.open(os.devnull, os.O_RDONLY)
    os.dup2(null, 0)
    os.dup2(2, 1)
    os.close(null)
    return requests, replies


class Server:
    """The worker's end of the channel.

    Parameters
    ----------
    requests, replies : file descriptors
    notebook : shell.Notebook
    """

    def __init__(self, requests: int, replies: int, notebook: shell.Notebook):
        self.requests, self.replies, self.notebook = wire.Source(requests), replies, notebook
        self.question = None  # the id of the question under way
        self.lock = threading.Lock()
        self.printed = sys.stdout, sys.stderr

    def serve(self) -> None:
        """Answer until the judge hangs up."""
        answers = {"start": self.start, "run": self.run, "call": self.call, "mark": self.mark}
        self.notebook.shell.run_cell(FIRST, store_history=False)
        reseed(SEED)
        while True:
            try:
                header, body = wire.receive(self.requests)
            except EOFError:
                return
            self.question = header["id"]
            reply, arrays = answers[header["ask"]](header, body)
            with self.lock:  # no thread of the submission asks between the reply and the end of the question
                self.flush()
                try:
                    wire.send(self.replies, {"id": self.question, **reply}, arrays)
                except ValueError as error:
                    wire.send(self.replies, {"id": self.question, "raised": describe(error)})
                self.question = None

    def start(self, header, body):
        sys.path.insert(0, os.getcwd())  # as in a notebook: files that a cell writes can be imported
        course.install(header["modules"])
        return {"ready": True}, b""

    def run(self, header, body):
        raised, note = self.notebook.run(header["source"])
        return {"raised": raised and describe(raised), "note": note}, b""

    def call(self, header, body):
        name = header["name"]
        reseed(header["seed"])
        try:
            arguments, options = wire.decode(header["arguments"], body, self.proxy)
            if name not in self.notebook.namespace:
                raise NameError(f"{name} is not defined")
            value, arrays = wire.encode(self.notebook.namespace[name](*arguments, **options), wire.name_only)
        except BaseException as error:  # SystemExit and KeyboardInterrupt too are the submission's
            return {"raised": describe(error)}, b""
        return {"value": value}, arrays

    def mark(self, header, body):
        """The judge sees where the output ends so far: what was printed was flushed after every answer."""
        try:
            os.write(2, f"\0{self.question}\0".encode())
        except OSError:
            pass  # closed by the submission
        return {}, b""

    def proxy(self, index: int) -> Callable:
        """The judge's function number `index`, to be called while the question that brought it is open."""
        question = self.question

        def function(*arguments, **options):
            code, arrays = wire.encode((arguments, options))
            with self.lock:
                if self.question != question:
                    raise RuntimeError("this function belonged to an earlier call, which is over")
                wire.send(self.replies, {"id": question, "evaluate": index, "arguments": code}, arrays)
                header, body = wire.receive(self.requests)
            if "raised" in header:
                raise builtin(*header["raised"])
            return wire.decode(header["value"], body)

        return function

    def flush(self) -> None:
        """Everything printed is on its way."""
        for stream in self.printed:
            try:
                stream.flush()
            except (OSError, ValueError):
                pass  # closed by the submission


def forget_ourselves() -> None:
    """Take our modules out of sight: they are loaded, but none of a submission's business."""
    for name in [name for name in sys.modules if f"{name}.".startswith(f"{__package__}.")]:
        del sys.modules[name]


def reseed(seed: int) -> None:
    for start in GLOBAL_GENERATORS:
        start(seed)


def builtin(type_name: str, message: str) -> Exception:
    kind = getattr(builtins, type_name, RuntimeError)
    try:
        return kind(message) if issubclass(kind, Exception) else RuntimeError(message)
    except TypeError:  # no exception, or one that wants more than a message
        return RuntimeError(message)


def describe(error: BaseException) -> list:
    """Type, base classes and message of an exception whose methods may do anything."""
    kind = type(error)
    try:
        where = isinstance(error, SyntaxError) and error.lineno  # the rest of its message is the name of no file
        message = f"{error.msg} (line {where})" if where else str(error)
    except BaseException:
        message = ""
    bases = [base.__name__ for base in kind.__mro__[1:] if base is not object]
    return [kind.__name__[:80], [name[:80] for name in bases[:20]], message[:2_000]]
