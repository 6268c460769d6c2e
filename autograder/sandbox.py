"""Starts workers at an isolation level.

At `namespaces` and `landlock` a parent imports the libraries once and forks a confined worker for each request; at
`limits` and `none` each worker is a process of its own, started cold.  `isolation` says what the levels mean.
"""

import base64
import json
import os
import select
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import weakref
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import suppress
from pathlib import Path

import psutil

from . import walls
from .channel import Worker, WorkerLost

LEVELS = ("namespaces", "landlock", "limits", "none")  # best first
CONFINED = LEVELS[:2]
WORKER = Path(__file__).resolve().parent / "worker"
NOBODY = 65534
DISK = 64 << 20
MOST_FILES = 10_000
STARTING = 60.0  # s, for imports on a slow or busy computer
DYING = 5.0  # s, for a killed process to be gone
HELD = b"held"
SCHEDULED = 2  # in the number of a clock, which Linux makes of a process's: the time that its threads have run

INTERPRETER = os.path.realpath(sys.executable)
ISOLATED = ("-P", "-s", "-S", "-B", "-X", "utf8")
BOOT = """
import json, runpy, sys
_, folder, sites, module, *rest = sys.argv
sys.path.insert(0, folder)
sys.path += json.loads(sites)
sys.argv = [module, *rest]
runpy.run_module(module, run_name="__main__")
"""
ENVIRONMENT = {
    "LANG": "C.UTF-8",
    "MPLBACKEND": "agg",
    "OPENBLAS_NUM_THREADS": "1",
    "OMP_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "NUMEXPR_NUM_THREADS": "1",
    "MALLOC_ARENA_MAX": "2",  # each arena takes 64 MiB of the address space
    "PYTHONHASHSEED": "0",
}


class IsolationError(Exception):
    """Code cannot be run as safely as was asked; the message is one sentence that says why and what to do."""


class Sandbox:
    """A place where submissions run, each in a worker of its own.

    Parameters
    ----------
    level : one of `LEVELS`

    Raises
    ------
    IsolationError
        If the level cannot be had on this computer.
    """

    def __init__(self, level: str):
        if level not in LEVELS:
            raise IsolationError(f"there is no isolation level {level!r}: choose one of {', '.join(LEVELS)}")
        self.level = level
        self._workers: weakref.WeakSet[Worker] = weakref.WeakSet()
        self._closed, self._lock = False, threading.Lock()
        self._parent = _Parent(level) if level in CONFINED else None
        self._aside, self._next, self._leaving = ThreadPoolExecutor(2), None, []

    def __enter__(self) -> "Sandbox":
        return self

    def __exit__(self, *_) -> None:
        self.close()

    def worker(self, modules: dict[str, str] | None = None) -> Worker:
        """A fresh process with fresh files and a fresh namespace.

        Parameters
        ----------
        modules : dict of str to str
            All that may be imported of the course: source text by path, as ``{"mechlib/newton.py": "..."}``.

        Raises
        ------
        IsolationError
            If the worker could not be started.
        """
        worker = self._forked() if self._parent else _cold_worker(self.level)
        with self._lock:
            self._workers.add(worker)
        if self._closed:  # by another thread, which may not have seen this worker
            worker.close()
        try:
            worker.start(modules or {}, STARTING)
        except WorkerLost as lost:
            why = _last_line(worker.output) or lost
            raise IsolationError(f"no worker starts at level {self.level}: {why}") from None
        return worker

    def _forked(self) -> Worker:
        with self._lock:
            ready, self._next = self._next, None
        return ready.result() if ready else self._parent.worker()

    def prepare(self) -> None:
        """Have the next worker begin, beside what is going on."""
        with self._lock:
            if self._parent and not self._next and not self._closed:
                self._next = self._aside.submit(self._parent.worker)

    def dismiss(self, worker: Worker) -> None:
        """End a worker, without waiting for its end."""
        with self._lock:
            if not self._closed:
                self._leaving = [end for end in self._leaving if not end.done()] + [self._aside.submit(worker.close)]

    def rest(self) -> None:
        """Take back what was prepared, and wait for the end of who was dismissed."""
        with self._lock:
            ready, self._next = self._next, None
        if ready and not ready.exception():
            ready.result().close()
        wait(self._leaving)

    def close(self) -> None:
        """End every worker, also those that other threads wait for."""
        with self._lock:
            self._closed = True
            workers = list(self._workers)
        for worker in workers:
            worker.close()
        if self._parent:
            self._parent.close()
        self.rest()
        self._aside.shutdown()


def probe(level: str) -> None:
    """Build the walls of a level and run against them from inside.

    Raises
    ------
    IsolationError
        If they cannot be built, or do not hold; the message is the reason alone.
    """
    if level in CONFINED:
        with tempfile.NamedTemporaryFile(prefix="canary-") as canary:
            os.chmod(canary.name, 0o644)
            parent = _Parent(level, canary.name)
            try:
                parent.probe()
            finally:
                parent.close()
        return
    if level == "limits":
        try:
            import resource  # noqa: F401
        except ImportError:
            raise IsolationError("this system has no resource limits") from None
    if _is_root():
        tried = subprocess.run(_as_nobody([INTERPRETER, "-c", ""], _interpreter()), capture_output=True, text=True)
        if tried.returncode:
            raise IsolationError(_last_line(tried.stderr))


class _Parent:
    """The judge's handle on a pre-imported parent.

    Parameters
    ----------
    level : one of `CONFINED`
    canary : path of a file for a probe, which does without the imports; left out, the workers answer
    """

    def __init__(self, level: str, canary: str | None = None):
        try:
            program = walls.system_calls()
        except (ImportError, OSError, RuntimeError) as error:
            raise IsolationError(f"system calls cannot be filtered ({error})") from None
        self.level, self.lock, self.errors = level, threading.Lock(), tempfile.TemporaryFile()
        self.folder = _folder_for_nobody(0o711) if level == "landlock" else None  # the other has its own, in memory
        self.control, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.control.settimeout(STARTING)
        try:
            with theirs:
                self.process = self._launch(theirs)
        except BaseException:
            self._remove()
            raise
        plan = {
            "probe": canary,
            "namespaces": level == "namespaces",
            "disk": f"size={DISK},nr_inodes={MOST_FILES},mode=700",
            "seccomp": base64.b64encode(program).decode(),
            "read": walls.readable(),
            "around_hidden": walls.readable_around_hidden(),
            "folder": self.folder,
        }
        try:
            with tempfile.TemporaryFile("w+") as file:  # it may be too long for a message
                json.dump(plan, file)
                file.seek(0)
                self._send(b"plan", [file.fileno()])
            self._expect(b"ready")
        except BaseException:
            self.close()
            raise

    def _launch(self, control: socket.socket) -> subprocess.Popen:
        needed = _interpreter()
        environment = ENVIRONMENT | {"PATH": "/usr/bin:/bin"}
        if self.level == "namespaces":
            program = shutil.which("bwrap")
            if program is None:
                raise IsolationError("bubblewrap is not installed")
            inside = environment | {"HOME": "/parent", "TMPDIR": "/parent"}
            command = walls.bubblewrap(program, INTERPRETER, str(WORKER), inside, str(DISK))
            command += _python("worker.parent", folder="/")
        else:
            home = _folder_for_nobody(0o700, self.folder)
            environment |= {"HOME": home, "TMPDIR": home}
            needed.append(self.folder)
            command = _python("worker.parent")
        if _is_root():
            command = _as_nobody(command, needed)
        quiet = subprocess.DEVNULL
        return subprocess.Popen(
            command, stdin=control, stdout=quiet, stderr=self.errors, env=environment, start_new_session=True
        )

    def _send(self, message: bytes, descriptors: list[int]) -> None:
        try:
            socket.send_fds(self.control, [message], descriptors)
        except OSError:
            pass  # the parent is gone, and where its answer is expected it will be said why

    def _expect(self, wanted: bytes) -> list[int]:
        """The parent's next message, and the descriptors that came with it."""
        try:
            message, descriptors, _, _ = socket.recv_fds(self.control, 1 << 12, 1, socket.MSG_CMSG_CLOEXEC)
        except TimeoutError:
            message, descriptors = b"it does not answer", []
        except OSError:
            message, descriptors = b"", []
        if message == wanted:
            return descriptors
        if not message:
            self._wait()
            self.errors.seek(0)
            message = self.errors.read()[-4_000:]
        said = _last_line(message.decode("utf-8", "replace")) or "it ended without a word"
        raise IsolationError(f"the parent of the workers fails: {said}")

    def fork(self, descriptors: list[int]) -> "_Forked":
        """Pass requests, replies and output to a new process."""
        if self.level == "namespaces":
            work, folder = "/job", None
        else:
            work = folder = _folder_for_nobody(0o700, self.folder)
        try:
            with self.lock:
                if self.control.fileno() < 0:
                    raise IsolationError("this sandbox is closed")
                self._send(work.encode(), descriptors)
                (handle,) = self._expect(b"started")
        finally:
            for fd in descriptors:
                os.close(fd)
        return _Forked(handle, folder)

    def worker(self) -> Worker:
        (requests, ask), (answer, replies), (output, prints) = os.pipe(), os.pipe(), os.pipe()
        try:
            process = self.fork([requests, replies, prints])
        except IsolationError:
            for fd in (ask, answer, output):
                os.close(fd)
            raise
        return Worker(ask, answer, output, process)

    def probe(self) -> None:
        output, prints = os.pipe()
        null = os.open(os.devnull, os.O_RDWR)
        with open(output, "rb") as printed:
            process = self.fork([null, os.dup(null), prints])
            said = printed.read()
        process.bury()
        if said != HELD:
            raise IsolationError(_last_line(said.decode("utf-8", "replace")) or "a worker ended without a word")

    def close(self) -> None:
        """End the parent, and with it every worker that is left."""
        try:
            self.control.shutdown(socket.SHUT_RDWR)  # wakes a thread that waits for a worker
        except OSError:
            pass  # closed before, or the parent is gone
        with self.lock:
            self.control.close()
            self._wait()
            self._remove()

    def _wait(self) -> None:
        """Let it end by itself, as it does when nobody can ask again; in time."""
        try:
            self.process.wait(DYING)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()

    def _remove(self) -> None:
        self.control.close()
        self.errors.close()
        if self.folder:
            _remove_folder(self.folder)


class _Forked:
    """A worker that a parent forked, held by a handle that stays true when its number is used again."""

    def __init__(self, handle: int, folder: str | None):
        self.handle, self.folder = handle, folder
        with open(f"/proc/self/fdinfo/{handle}") as about:
            self.number = next(int(line.split()[1]) for line in about if line.startswith("Pid:"))

    def computing_time(self) -> float:
        try:
            return time.clock_gettime(~self.number << 3 | SCHEDULED)
        except OSError:
            return 0.0  # it has ended, as the channel will see

    def excess(self) -> str | None:
        return _excess(self.folder) if self.folder else None

    def kill(self) -> None:
        try:
            signal.pidfd_send_signal(self.handle, signal.SIGKILL)
        except ProcessLookupError:
            pass

    def bury(self) -> None:
        select.select([self.handle], [], [], DYING)
        os.close(self.handle)
        if self.folder:
            _remove_folder(self.folder)


class _Cold:
    """A worker started by itself, and the folder it works in."""

    def __init__(self, process: subprocess.Popen, folder: str, rationed: bool):
        self.process, self.folder, self.rationed = process, folder, rationed

    def computing_time(self) -> float:
        try:
            times = psutil.Process(self.process.pid).cpu_times()
        except psutil.Error:
            return 0.0
        return times.user + times.system

    def excess(self) -> str | None:
        return _excess(self.folder) if self.rationed else None

    def kill(self) -> None:
        if hasattr(os, "killpg"):
            try:
                os.killpg(self.process.pid, signal.SIGKILL)
            except (ProcessLookupError, PermissionError):
                pass
        self.process.kill()

    def bury(self) -> None:
        self.process.wait()
        _remove_folder(self.folder)


def _remove_folder(folder: str) -> None:
    """Take a folder away, however deep and however closed what was left in it."""
    with suppress(RecursionError):
        shutil.rmtree(folder, ignore_errors=True)
    if os.name == "posix" and os.path.exists(folder):
        for command in (["chmod", "-R", "u+rwx"], ["rm", "-rf"]):
            subprocess.run([*command, "--", folder], stderr=subprocess.DEVNULL)


def _excess(folder: str) -> str | None:
    """Whether a folder on the disk holds more than one in memory could; what is in it may change, and be hostile."""
    folders, files, size = [folder], 0, 0
    while folders:
        try:
            with os.scandir(folders.pop()) as entries:
                for entry in entries:
                    files += 1
                    if entry.is_dir(follow_symlinks=False):
                        folders.append(entry.path)
                    else:
                        size += entry.stat(follow_symlinks=False).st_size
                    if size > DISK or files > MOST_FILES:
                        return f"more than {DISK >> 20} MiB, or {MOST_FILES} files, in its folder"
        except FileNotFoundError:
            pass  # it was there a moment ago
        except OSError as error:
            return f"a folder in its folder that nobody can look into ({error.strerror})"
    return None


def _cold_worker(level: str) -> Worker:
    folder = _folder_for_nobody(0o700)
    command = _python("worker", level)
    mine = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    if _is_root():
        mine = {"PATH": "/usr/bin:/bin", "HOME": folder}
        command = _as_nobody(command, [*_interpreter(), folder], folder)
    own = dict.fromkeys(("TMPDIR", "TEMP", "TMP"), folder) | {"IPYTHONDIR": os.path.join(folder, ".ipython")}
    process = subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        bufsize=0,
        cwd=folder,
        env=mine | ENVIRONMENT | own,
        start_new_session=os.name == "posix",
    )
    descriptors = []
    for stream in (process.stdin, process.stdout, process.stderr):
        with stream:
            descriptors.append(os.dup(stream.fileno()))
    return Worker(*descriptors, _Cold(process, folder, level == "limits"))


def _python(module: str, *arguments: str, folder: str = str(WORKER.parent)) -> list[str]:
    """The command that runs a module of the worker, with the installed packages and nothing else that is installed."""
    return [INTERPRETER, *ISOLATED, "-c", BOOT, folder, json.dumps(walls.sites()), module, *arguments]


def _interpreter() -> list[str]:
    """Folders without which no worker starts."""
    return [*walls.roots(), os.path.dirname(INTERPRETER), str(WORKER)]


def _is_root() -> bool:
    return hasattr(os, "geteuid") and os.geteuid() == 0


def _as_nobody(command: list[str], needed: list[str], folder: str = "/") -> list[str]:
    return [*_python("worker.unroot"), json.dumps([os.path.realpath(path) for path in needed]), folder, *command]


def _folder_for_nobody(mode: int, parent: str | None = None) -> str:
    """A new folder that the worker's user owns, or may pass through."""
    folder = os.path.realpath(tempfile.mkdtemp(prefix="worker-", dir=parent))
    os.chmod(folder, mode)
    if _is_root() and mode == 0o700:
        os.chown(folder, NOBODY, NOBODY)
    return folder


def _last_line(said: str) -> str:
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    return lines[-1] if lines else ""
