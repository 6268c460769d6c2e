"""What a process takes from itself before it reads the first byte of a student: nothing here can be undone by it.

Linux only, by system calls; each wall raises OSError where it cannot be built.
"""

import ctypes
import os
import struct
from collections.abc import Iterable
from functools import cache

CLONE_NEWNS, CLONE_NEWIPC, CLONE_NEWPID = 0x20000, 0x08000000, 0x20000000
MS_RDONLY, MS_NOSUID, MS_NODEV, MS_BIND, MS_REC, MS_SLAVE = 1, 2, 4, 0x1000, 0x4000, 0x80000
PR_SET_PDEATHSIG, PR_SET_DUMPABLE, PR_SET_SECCOMP, PR_CAPBSET_DROP, PR_SET_NO_NEW_PRIVS, PR_CAP_AMBIENT = (
    1, 4, 22, 24, 38, 47,
)  # fmt: skip
LANDLOCK_CREATE_RULESET, LANDLOCK_ADD_RULE, LANDLOCK_RESTRICT_SELF = 444, 445, 446  # the same on every architecture
WRITE_FILE, READ_FILE, READ_DIR, TRUNCATE, IOCTL_DEV = 1 << 1, 1 << 2, 1 << 3, 1 << 14, 1 << 15
RIGHTS_OF_A_FILE = WRITE_FILE | READ_FILE | TRUNCATE | IOCTL_DEV


@cache
def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None, use_errno=True)


def _call(name: str, *arguments) -> int:
    """A C function by name; Python integers go over as longs, so that no argument is cut to 32 bits."""
    function = getattr(_libc(), name)
    function.restype = ctypes.c_long
    result = function(*(ctypes.c_long(a) if isinstance(a, int) else a for a in arguments))
    if result < 0:
        error = ctypes.get_errno()
        raise OSError(error, f"{name}: {os.strerror(error)}")
    return result


def prctl(option: int, *values: int) -> None:
    _call("prctl", option, *values, *[0] * (4 - len(values)))


def unshare(namespaces: int) -> None:
    _call("unshare", namespaces)


def mount(source: str, target: str, kind: str = "", flags: int = 0, options: str = "") -> None:
    _call("mount", source.encode(), target.encode(), kind.encode(), flags, options.encode() or None)


def private_mounts() -> None:
    """From here on, what is mounted stays in this process and its children."""
    unshare(CLONE_NEWNS)
    mount("none", "/", flags=MS_REC | MS_SLAVE)


def landlock_abi() -> int:
    """Version of Landlock in this kernel, 0 where there is none."""
    try:
        return _call("syscall", LANDLOCK_CREATE_RULESET, None, 0, 1)
    except OSError:
        return 0


def landlock(read: Iterable[str] = (), listed: Iterable[str] = (), write: Iterable[str] = ()) -> None:
    """Close the file system, TCP, abstract sockets and signals, but for these paths and what lies below them.

    Parameters
    ----------
    read, write : paths to read from; paths to do anything to
    listed : folders whose names may be listed, while their files stay closed
    """
    abi = landlock_abi()
    if not abi:
        raise OSError("this kernel has no Landlock, or has it switched off")
    files = (1 << {1: 13, 2: 14, 3: 15, 4: 15}.get(abi, 16)) - 1
    ports, scopes = (3 if abi >= 4 else 0), (3 if abi >= 6 else 0)
    attributes = struct.pack("<QQQ", files, ports, scopes)[: 8 if abi < 4 else 16 if abi < 6 else 24]
    ruleset = _call("syscall", LANDLOCK_CREATE_RULESET, attributes, len(attributes), 0)
    for paths, rights in ((read, READ_FILE | READ_DIR), (listed, READ_DIR), (write, files)):
        for path in paths:
            try:
                fd = os.open(path, os.O_PATH | os.O_CLOEXEC)
            except OSError:
                continue  # what is not there needs no leave
            allowed = rights & files & (~0 if os.path.isdir(path) else RIGHTS_OF_A_FILE)
            _call("syscall", LANDLOCK_ADD_RULE, ruleset, 1, struct.pack("<Qi", allowed, fd), 0)
            os.close(fd)
    prctl(PR_SET_NO_NEW_PRIVS, 1)
    _call("syscall", LANDLOCK_RESTRICT_SELF, ruleset, 0)
    os.close(ruleset)


def seccomp(program: bytes) -> None:
    """Install a filter of system calls, compiled beforehand."""
    buffer = ctypes.create_string_buffer(program, len(program))
    header = struct.pack("@HP", len(program) // 8, ctypes.addressof(buffer))
    prctl(PR_SET_NO_NEW_PRIVS, 1)
    _call("prctl", PR_SET_SECCOMP, 2, header, 0, 0)


def drop_capabilities() -> None:
    for capability in range(64):
        try:
            prctl(PR_CAPBSET_DROP, capability)
        except OSError:
            break
    _call("capset", struct.pack("<Ii", 0x20080522, 0), bytes(24))
    prctl(PR_CAP_AMBIENT, 4)


def mapped_bytes() -> int:
    """Address space of this process; 0 where the system does not tell."""
    try:
        with open("/proc/self/statm") as statm:
            return int(statm.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    except (OSError, AttributeError):
        return 0


def limit(address_space: int | None) -> None:
    """Resource limits, as far as this system knows them.

    Parameters
    ----------
    address_space : bytes, or None for no limit
    """
    import resource

    wanted = {
        "RLIMIT_AS": address_space,
        "RLIMIT_CPU": 900,  # s; a backstop: the judge's clock is the limit
        "RLIMIT_FSIZE": 16 << 20,
        "RLIMIT_NOFILE": 128,
        "RLIMIT_NPROC": 4096,  # threads of this user, all workers together: what they take, the computer goes without
        "RLIMIT_CORE": 0,
        "RLIMIT_MEMLOCK": 0,
    }
    for name, most in wanted.items():
        kind = getattr(resource, name, None)
        if kind is None or most is None:
            continue
        hard = resource.getrlimit(kind)[1]
        most = most if hard == resource.RLIM_INFINITY else min(most, hard)
        try:
            resource.setrlimit(kind, (most, most))
        except (OSError, ValueError):
            if os.uname().sysname == "Linux":
                raise  # elsewhere some limits exist in name only
