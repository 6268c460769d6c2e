"""What hostile code could harm, and watches that tell from outside whether it did.

Nothing but the walls protects these things: the files belong to the worker's own user and are open to all, the
stand-in for the judge runs as that user and lets itself be traced, and the sockets answer anybody.
"""

import array
import contextlib
import ctypes
import fcntl
import os
import secrets
import signal
import socket
import stat
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from autograder import sandbox, walls
from autograder.worker import harden

CANARY = f"canary-{secrets.token_hex(8)}"
MARK = f"mark-{secrets.token_hex(4)}"  # in the name of whatever is left where others leave things, too
KEY = secrets.randbits(30)  # the same, where names are numbers
KEPT = "user.kept"
SOLUTION = Path(__file__).resolve().parents[2] / "solutions" / "01_newton_1d.ipynb"
PR_SET_CHILD_SUBREAPER = 36
GETFLAGS = 0x80086601
NETLINK_USERSOCK = 2
IOPRIO_GET = {"x86_64": 252, "aarch64": 31}.get(os.uname().machine)
MEBIBYTE = 1 << 20
RARE = ("anon_inode:[io_uring]", "anon_inode:[userfaultfd]", "anon_inode:bpf", "anon_inode:[perf_event]", "/memfd:")

VICTIM = """
import ctypes, os, signal, sys
signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
ctypes.CDLL(None).prctl(0x59616D61, -1, 0, 0, 0)  # whoever may, may trace it
secret = ctypes.create_string_buffer(sys.argv[1].encode())
memory = ctypes.create_string_buffer(b'as it was')
held = os.open(sys.argv[2], os.O_RDONLY)
print(ctypes.addressof(secret), ctypes.addressof(memory), held, flush=True)
sys.stdin.read()
"""

WATCHES: dict[str, Callable[["World"], object]] = {}


AFTERWARDS = set()


def watch(look: Callable[["World"], object]) -> Callable:
    """Make a detector: it looks at one thing, and fires when that is not what it was."""
    WATCHES[look.__name__.replace("_", " ")] = look
    return look


def watch_afterwards(look: Callable[["World"], object]) -> Callable:
    """The same for what a worker may well have as long as it lives."""
    AFTERWARDS.add(look.__name__.replace("_", " "))
    return watch(look)


class World:
    """Things to harm, and what they were like before.

    Attributes
    ----------
    seen : list of str
        All that a judge, a student or an instructor gets to read of the attack.
    pages : list of str
        The part of it that is HTML.
    points : float
        What it was given.
    hung : bool
        Whether the judge waited for it longer than a judge should.
    """

    def __init__(self):
        self.seen: list[str] = []
        self.pages: list[str] = []
        self.points, self.hung, self.signals = 0.0, False, 0
        self._closing = contextlib.ExitStack()
        self._temporary()
        self._files()
        self._listeners()
        self._victim()
        self._judge()
        self.begin()

    def __enter__(self) -> "World":
        return self

    def __exit__(self, *_) -> None:
        self._closing.close()

    def _temporary(self) -> None:
        """A place of our own for what the sandbox puts on disk, so that what is left there is seen."""
        self.temporary = Path(self._closing.enter_context(tempfile.TemporaryDirectory(prefix="temporary-")))
        self.temporary.chmod(0o755)
        before, tempfile.tempdir = tempfile.tempdir, str(self.temporary)
        self._closing.callback(setattr, tempfile, "tempdir", before)

    def _files(self) -> None:
        place = Path(self._closing.enter_context(tempfile.TemporaryDirectory(dir=self.temporary.parent)))
        place.chmod(0o755)
        self.folder, self.site = place / "folder", place / "lib" / "site-packages"
        self.file, self.library, self.secret = self.folder / "file", self.site / "library.py", self.folder / "secret"
        for folder in (self.folder, self.site):
            folder.mkdir(parents=True)
        self.secret.write_text(CANARY)
        (self.folder / CANARY).touch()
        (self.folder / "link").symlink_to(f"/{CANARY}")
        for path in (self.file, self.library):
            path.write_text("# as it was\n")
            with contextlib.suppress(OSError):  # not every file system has such attributes
                os.setxattr(path, KEPT, CANARY.encode())
        for path in (self.folder, self.site, self.file, self.library, self.secret):
            path.chmod(0o777 if path.is_dir() else 0o666)
            if os.geteuid() == 0:
                os.chown(path, sandbox.NOBODY, sandbox.NOBODY)
            os.utime(path, (1e9, 1e9))

    def _listeners(self) -> None:
        def listen(kind, address, family=socket.AF_UNIX, protocol=0):
            listener = self._closing.enter_context(socket.socket(family, kind, protocol))
            listener.bind(address)
            listener.setblocking(False)
            if kind == socket.SOCK_STREAM:
                listener.listen()
            if isinstance(address, str) and address.startswith("/"):
                os.chmod(address, 0o777)
            return listener

        stream, datagram = socket.SOCK_STREAM, socket.SOCK_DGRAM
        self.listeners = {
            "tcp": listen(stream, ("127.0.0.1", 0), socket.AF_INET),
            "udp": listen(datagram, ("127.0.0.1", 0), socket.AF_INET),
            "local stream": listen(stream, str(self.folder / "stream")),
            "local datagram": listen(datagram, str(self.folder / "datagram")),
            "abstract stream": listen(stream, f"\0{self.temporary.name}-stream"),
            "abstract datagram": listen(datagram, f"\0{self.temporary.name}-datagram"),
            "netlink": listen(datagram, (0, 0), socket.AF_NETLINK, NETLINK_USERSOCK),
        }
        self.received = dict.fromkeys(self.listeners, 0)

    def _victim(self) -> None:
        command = [sandbox.INTERPRETER, *sandbox.ISOLATED, "-c", VICTIM, CANARY, str(self.secret)]
        if sandbox._is_root():
            command = sandbox._as_nobody(command, sandbox._interpreter())
        self.victim = self._closing.enter_context(
            subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        )
        self._closing.callback(self.victim.kill)
        self.secret_address, self.address, self.held = map(int, self.victim.stdout.readline().split())

    def _judge(self) -> None:
        """Count signals to this process, and become the parent of whatever outlives its own."""

        def count(*_):
            self.signals += 1

        self._closing.callback(signal.signal, signal.SIGURG, signal.signal(signal.SIGURG, count))
        harden.prctl(PR_SET_CHILD_SUBREAPER, 1)
        self._closing.callback(harden.prctl, PR_SET_CHILD_SUBREAPER, 0)

    def begin(self) -> None:
        """Forget the last attack: what is seen from now on is the next one's."""
        self.seen.clear()
        self.pages.clear()
        self.points, self.hung = 0.0, False
        Path("/proc/self/clear_refs").write_text("5")  # the most memory so far is the memory now
        self.memory = highest()
        self.family = descendants()
        self.before = {name: look(self) for name, look in WATCHES.items()}

    def aim(self) -> str:
        """Source text that tells an attack where everything is, but for the canary."""
        places = {
            "FILE": str(self.file),
            "LIBRARY": str(self.library),
            "FILES": [str(self.file), str(self.library)],
            "FOLDER": str(self.folder),
            "FOLDERS": [str(self.folder), str(self.site)],
            "SECRET": str(self.secret),
            "SOLUTION": str(SOLUTION),
            "MARK": MARK,
            "KEY": KEY,
            "VICTIM": self.victim.pid,
            "JUDGE": os.getpid(),
            "SECRET_ADDRESS": self.secret_address,
            "ADDRESS": self.address,
            "HELD": self.held,
            "KEPT": KEPT,
            "URGENT": int(signal.SIGURG),
        } | {name.upper().replace(" ", "_"): at.getsockname() for name, at in self.listeners.items()}
        return "".join(f"{name} = {value!r}\n" for name, value in places.items())

    def harm(self) -> set[str]:
        """The names of the watches that see something else than before, while the worker lives."""
        return self._changed(WATCHES.keys() - AFTERWARDS)

    def lasting_harm(self, settling: float) -> set[str]:
        """The same, once all that is ending has ended, or after so many seconds."""
        ending = time.monotonic() + settling
        while self._changed(AFTERWARDS) and time.monotonic() < ending:
            time.sleep(0.02)
        return self._changed(WATCHES.keys())

    def _changed(self, names: Iterable[str]) -> set[str]:
        return {name for name in names if WATCHES[name](self) != self.before[name]}


@contextlib.contextmanager
def sandbox_in(world: World, level: str) -> Iterator[sandbox.Sandbox]:
    """A sandbox, started while environment and library hold something to reach for."""
    import pytest

    cached = (walls.sites, walls.roots, walls.hidden)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CANARY", CANARY)
        patch.syspath_prepend(str(world.site))
        for function in cached:
            function.cache_clear()
        try:
            place = sandbox.Sandbox(level)
            with place:
                yield place
        finally:
            for function in cached:
                function.cache_clear()


# --- files ------------------------------------------------------------------------------------------------------------


@watch
def content(world):
    return [path.read_bytes() if path.exists() else None for path in (world.file, world.library)]


@watch
def names(world):
    return [[(e.name, stat.S_IFMT(e.stat(follow_symlinks=False).st_mode)) for e in sorted(os.scandir(folder), key=str)]
            for folder in (world.folder, world.site)]  # fmt: skip


@watch
def links(world):
    return [path.stat().st_nlink for path in (world.file, world.library) if path.exists()]


@watch
def mode(world):
    return [path.stat().st_mode for path in (world.file, world.library, world.folder) if path.exists()]


@watch
def times(world):
    return [(s.st_mtime, s.st_size) for path in (world.file, world.library) if path.exists() for s in [path.stat()]]


@watch
def attributes(world):
    found = []
    for path in (world.file, world.library):
        with contextlib.suppress(OSError):
            found += [(name, os.getxattr(path, name)) for name in os.listxattr(path)]
    return found


@watch
def flags_of_an_inode(world):
    found = []
    for path in (world.file, world.library):
        flags = array.array("l", [0])
        with contextlib.suppress(OSError), open(path, "rb") as file:
            fcntl.ioctl(file, GETFLAGS, flags)
            found.append(flags[0])
    return found


@watch
def leases(world):
    """Whether somebody makes whoever opens a file wait."""
    found = []
    for path in (world.file, world.library):
        try:
            os.close(os.open(path, os.O_WRONLY | os.O_NONBLOCK))
        except BlockingIOError:
            found.append(path)
        except OSError:
            pass
    return found


@watch_afterwards
def left_behind(world):
    """What is still there when its owner is gone, in memory or on disk."""
    found = {str(path) for pattern in ("*", "*/*") for path in world.temporary.glob(pattern)}
    found |= {name for folder in ("/dev/shm", "/tmp", "/var/tmp") for name in os.listdir(folder) if MARK in name}
    for kind in ("shm", "msg", "sem"):
        with contextlib.suppress(OSError):
            found |= {
                f"{kind} {KEY}"
                for line in Path("/proc/sysvipc", kind).read_text().splitlines()
                if line.split()[0] == str(KEY)
            }
    return found


# --- secrets, points, patience ----------------------------------------------------------------------------------------


@watch
def leak(world):
    return any(CANARY in text for text in world.seen)


@watch
def control_characters(world):
    """That move a cursor or turn the direction of reading."""
    return any(not (char.isprintable() or char in "\n\t") for text in world.seen for char in text)


@watch
def markup(world):
    return any("<script" in page for page in world.pages)


@watch
def points(world):
    return world.points


@watch
def patience(world):
    return world.hung


# --- the network ------------------------------------------------------------------------------------------------------


def _arrivals(name):
    def arrived(world):
        listener = world.listeners[name]
        with contextlib.suppress(BlockingIOError):
            while True:
                if listener.type == socket.SOCK_STREAM:
                    listener.accept()[0].close()
                else:
                    listener.recv(1 << 16)
                world.received[name] += 1
        return world.received[name]

    arrived.__name__ = name
    return watch(arrived)


for _name in ("tcp", "udp", "local stream", "local datagram", "abstract stream", "abstract datagram", "netlink"):
    _arrivals(_name)


# --- other processes --------------------------------------------------------------------------------------------------


def status(pid) -> dict[str, str]:
    """The lines of a process in /proc; none where it is gone."""
    try:
        lines = Path("/proc", str(pid), "status").read_text().splitlines()
    except OSError:
        return {}
    return {name: value.strip() for name, _, value in (line.partition(":") for line in lines)}


@watch
def signal_to_the_judge(world):
    found = status(world.victim.pid)
    return world.signals, found.get("SigPnd"), found.get("ShdPnd"), found.get("State", "Z")[0] in "TXZ"


@watch
def tracer(world):
    return status(world.victim.pid).get("TracerPid")


@watch
def memory_of_the_judge(world):
    with contextlib.suppress(OSError), open(f"/proc/{world.victim.pid}/mem", "rb") as memory:
        memory.seek(world.address)
        return memory.read(9)


@watch
def processors(world):
    return [status(pid).get("Cpus_allowed") for pid in (world.victim.pid, os.getpid())]


@watch
def limits(world):
    return [Path("/proc", str(pid), "limits").read_text() for pid in (world.victim.pid, os.getpid())]


@watch
def priority(world):
    return [(os.getpriority(os.PRIO_PROCESS, pid), os.sched_getscheduler(pid)) for pid in (world.victim.pid, 0)]


@watch
def priority_on_disk(world):
    return [ctypes.CDLL(None).syscall(IOPRIO_GET, 1, pid) for pid in (world.victim.pid, 0)] if IOPRIO_GET else None


def descendants() -> set[int]:
    """The processes that this one started, and theirs."""
    found, waiting = set(), [os.getpid()]
    while waiting:
        with contextlib.suppress(OSError):  # it has ended
            for children in Path("/proc", str(waiting.pop()), "task").glob("*/children"):
                mine = set(map(int, children.read_text().split()))
                waiting += mine - found
                found |= mine
    return found


@watch_afterwards
def processes(world):
    """What outlives the worker is left to us, who made ourselves its reaper."""
    fresh = descendants() - world.family  # one that was there may end whenever it likes
    dead = {pid for pid in fresh if status(pid).get("State", "Z")[:1] == "Z"}
    for pid in dead:
        with contextlib.suppress(ChildProcessError):
            os.waitpid(pid, os.WNOHANG)
    return fresh - dead


@watch
def capabilities(world):
    found = _capable(world)
    if found:
        time.sleep(0.5)  # who forks a worker into its namespaces has some, and is about to end
    return found & _capable(world)


def _capable(world) -> set[int]:
    return {pid for pid in descendants() - world.family if int(status(pid).get("CapEff", "0"), 16)}


@watch
def kernel_objects(world):
    found = set()
    for pid in descendants() - {world.victim.pid}:
        with contextlib.suppress(OSError):
            for name in os.listdir(f"/proc/{pid}/fd"):
                kind = os.readlink(f"/proc/{pid}/fd/{name}")
                if kind.startswith(RARE):
                    found.add((pid, kind))
    return found


@watch
def personality(world):
    found = set()
    for pid in descendants():
        with contextlib.suppress(OSError):
            if int(Path("/proc", str(pid), "personality").read_text(), 16):
                found.add(pid)
    return found


@watch
def keys(world):
    """Whether the kernel keeps a key of the worker's: it tells whoever has the worker's user for its files."""
    libc = ctypes.CDLL(None)
    if sandbox._is_root():
        libc.setfsuid(sandbox.NOBODY)  # of this thread alone
    try:
        return MARK in Path("/proc/keys").read_text()
    finally:
        libc.setfsuid(os.geteuid())


CROWD = 5_000
ADDRESSES = 3 << 20  # KiB


@watch
def threads(world):
    return sum(int(status(pid).get("Threads", 0)) for pid in descendants()) > CROWD


@watch
def address_space(world):
    return any(int(status(pid).get("VmPeak", "0 kB").split()[0]) > ADDRESSES for pid in descendants())


def highest() -> int:
    """The most memory of this process since it was last forgotten."""
    return int(status(os.getpid())["VmHWM"].split()[0]) << 10


@watch
def memory_without_a_limit(world):
    """Memory with a name, which other processes could map as well."""
    return any(int(status(pid).get("RssShmem", "0 kB").split()[0]) > 200 << 10 for pid in descendants())


@watch
def memory_of_the_grader(world):
    return highest() - world.memory > 400 * MEBIBYTE


@watch
def disk_of_a_worker(world):
    """Whether its files are more than there is room for in memory."""
    places = [path for pattern in ("worker-*", "worker-*/worker-*") for path in world.temporary.glob(pattern)]
    places += [Path("/proc", str(pid), "root", "job") for pid in descendants()]
    for place in places:
        with contextlib.suppress(OSError), os.scandir(place) as entries:
            sizes = [entry.stat(follow_symlinks=False).st_size for entry in entries]
            if len(sizes) > 25_000 or sum(sizes) > 80 * MEBIBYTE:
                return True
    return False


@watch
def descriptors(world):
    found = 0
    for pid in descendants():
        with contextlib.suppress(OSError):
            found = max(found, len(os.listdir(f"/proc/{pid}/fd")))
    return found > 1_000


@watch
def asynchronous_reading(world):
    """Whether a worker has taken of what all programs of the computer together have little."""
    found = set()
    for pid in descendants():
        with contextlib.suppress(OSError):
            if "/[aio]" in Path("/proc", str(pid), "maps").read_text():
                found.add(pid)
    return found
