"""What a confined worker may see of the file system, and which system calls it may make."""

import errno
import os
import struct
import sys
import tempfile
from collections.abc import Iterable, Iterator
from functools import cache
from glob import glob
from os.path import exists, isdir, isfile, join, realpath

OURS = ("autograder", "mechlib")
SYSTEM_FOLDERS = ("/usr/lib", "/usr/lib32", "/usr/lib64", "/usr/share", "/lib", "/lib32", "/lib64")
SYSTEM_FILES = ("/etc/ld.so.cache", "/etc/localtime", "/etc/fonts", "/etc/alternatives")
DEVICES = ("/dev/urandom", "/dev/random", "/dev/zero")
NEWER = 440  # of Linux 5.10; such numbers are the same on every architecture


@cache
def sites() -> tuple[str, ...]:
    """Folders of installed packages on the judge's path."""
    return tuple(path for path in sys.path if path.endswith(("site-packages", "dist-packages")) and isdir(path))


@cache
def roots() -> tuple[str, ...]:
    """Folders that Python and its libraries are made of, none inside another."""
    base = (join(sys.base_prefix, "lib"), join(sys.base_prefix, "lib64"))
    found = sorted({realpath(path) for path in (*SYSTEM_FOLDERS, *base, *sites()) if isdir(path)})
    return tuple(path for path in found if not any(path.startswith(f"{other}/") for other in found))


@cache
def hidden() -> tuple[str, ...]:
    """What lies in the roots and is ours, or tells where ours is; and packages that the judge's Python does not use."""
    ours = {realpath(site) for site in sites()}
    others = {
        realpath(path)
        for root in roots()
        for name in ("site-packages", "dist-packages")
        for path in glob(join(root, "python3*", name))
    }
    return tuple(sorted((others - ours) | {e.path for folder in ours for e in os.scandir(folder) if _is_ours(e)}))


def _is_ours(entry: os.DirEntry) -> bool:
    name = entry.name
    return (
        name.partition(".")[0] in OURS
        or name.startswith("__editable__")
        or name.endswith((".pth", ".egg-link"))
        or name == "__pycache__"  # holds the editable finder, too
        or exists(join(entry.path, "direct_url.json"))
    )


def around(folders: Iterable[str], holes: Iterable[str]) -> Iterator[tuple[str, bool]]:
    """Cover folders without their holes, since Landlock can give but not take back.

    Yields
    ------
    (str, bool)
        A path, and whether all below it is meant (or else its list of names only).
    """
    for folder in folders:
        inside = [hole for hole in holes if hole.startswith(f"{folder}/")]
        yield folder, not inside
        if inside:
            children = (join(folder, name) for name in os.listdir(folder))
            yield from around((child for child in children if child not in inside), inside)


def readable() -> list[str]:
    """What may be read, the hidden included, where something else hides it."""
    return [*roots(), *SYSTEM_FILES, *DEVICES]


def readable_around_hidden() -> tuple[list[str], list[str]]:
    """What may be read, the hidden left out; and folders whose names may be listed, but no more."""
    found = list(around(readable(), hidden()))
    return [path for path, whole in found if whole], [path for path, whole in found if not whole]


def bubblewrap(program: str, python: str, worker: str, environment: dict[str, str], disk: str) -> list[str]:
    """The command that runs what follows it in namespaces of its own.

    Parameters
    ----------
    program, python : paths of bubblewrap and of the interpreter
    worker : folder that appears as ``/worker``
    environment : all variables that there are inside
    disk : bytes of each folder in memory
    """
    command = [program, "--unshare-user", "--unshare-pid", "--unshare-net", "--unshare-ipc", "--unshare-uts"]
    command += ["--unshare-cgroup-try", "--new-session", "--uid", "65534", "--gid", "65534", "--disable-userns"]
    command += ["--as-pid-1"]  # the parent's end is the end of everything inside
    # The parent makes namespaces for its workers, who give this capability back before they read a submission.
    command += ["--cap-drop", "ALL", "--cap-add", "CAP_SYS_ADMIN", "--clearenv", "--hostname", "worker"]
    for name, value in environment.items():
        command += ["--setenv", name, value]
    for path in (*roots(), *filter(exists, SYSTEM_FILES), python):
        command += ["--ro-bind", path, path]
    for link in SYSTEM_FOLDERS:
        if os.path.islink(link):
            command += ["--symlink", os.readlink(link), link]
    for path in hidden():
        if isfile(path):
            command += ["--ro-bind", "/dev/null", path]
        else:
            command += ["--size", "4096", "--tmpfs", path, "--remount-ro", path]
    command += ["--ro-bind", worker, "/worker", "--proc", "/proc", "--dev", "/dev"]
    for folder in ("/parent", "/job"):  # names of our own: Python may well live below /tmp
        command += ["--size", disk, "--tmpfs", folder]
    return [*command, "--remount-ro", "/", "--chdir", "/", "--"]


@cache
def system_calls() -> bytes:
    """A program for seccomp that denies what a numerical notebook has no use for.

    Raises
    ------
    ImportError, OSError, RuntimeError
        If libseccomp or its Python module is missing.
    """
    import pyseccomp as sc

    filter = sc.SyscallFilter(sc.ALLOW)
    denied, unknown, pretended = sc.ERRNO(errno.EPERM), sc.ERRNO(errno.ENOSYS), sc.ERRNO(0)
    no_attributes, no_link = sc.ERRNO(errno.ENOTSUP), sc.ERRNO(errno.EINVAL)

    def rule(action, names, when=()):
        for name in names.split():
            try:
                filter.add_rule(action, name, *when)
            except (ValueError, OSError, RuntimeError):
                pass  # no such call on this architecture, or too new for this libseccomp

    def command(argument, number):
        """The kernel reads 32 bits of a command; a comparison of all 64 could be passed by."""
        return (sc.Arg(argument, sc.MASKED_EQ, 0xFFFFFFFF, number),)

    # Other processes, and the kernel itself.
    rule(denied, "ptrace process_vm_readv process_vm_writev process_madvise kcmp pidfd_getfd pidfd_open")
    rule(denied, "kill tkill tgkill rt_sigqueueinfo rt_tgsigqueueinfo pidfd_send_signal")
    rule(denied, "setpriority ioprio_set sched_setscheduler sched_setattr")
    rule(denied, "prlimit64 sched_setaffinity sched_setparam setpgid", when=(sc.Arg(0, sc.NE, 0),))
    rule(denied, "perf_event_open bpf userfaultfd io_uring_setup io_uring_enter io_uring_register")
    rule(denied, "io_setup inotify_init inotify_init1 fanotify_mark")  # all users together have only so many
    rule(denied, "keyctl add_key request_key init_module finit_module delete_module kexec_load kexec_file_load")
    rule(denied, "reboot swapon swapoff acct quotactl quotactl_fd syslog lookup_dcookie nfsservctl personality")
    rule(denied, "settimeofday clock_settime adjtimex clock_adjtime sethostname setdomainname")
    rule(denied, "iopl ioperm modify_ldt vm86 vm86old")
    for set_owner in (8, 10, 15):  # F_SETOWN, F_SETSIG, F_SETOWN_EX: any signal to any process
        rule(denied, "fcntl", when=command(1, set_owner))
    rule(denied, "fcntl", when=command(1, 1024))  # F_SETLEASE: whoever opens the file then waits
    # Past terminals and pipes: owners of sockets, flags of files that may only be read, and what drivers think of.
    rule(denied, "ioctl", when=(sc.Arg(1, sc.GE, 0x5480),))
    for request in (0x5412, 0x541C):  # TIOCSTI, TIOCLINUX: typing
        rule(denied, "ioctl", when=command(1, request))
    for option in (1, 4):  # PR_SET_PDEATHSIG, PR_SET_DUMPABLE: set, and to stay so
        rule(denied, "prctl", when=command(0, option))

    # Namespaces, mounts, identity, files by handle.
    rule(denied, "mount umount umount2 pivot_root chroot move_mount open_tree fsopen fsconfig fsmount fspick")
    rule(denied, "mount_setattr unshare setns name_to_handle_at open_by_handle_at fanotify_init mknod mknodat")
    rule(denied, "setuid setgid setreuid setregid setresuid setresgid setgroups setfsuid setfsgid")

    # Threads, but no processes. clone3 has its flags where no filter sees them: without it the C library takes clone.
    clone_thread = 0x10000
    rule(unknown, "clone3")
    rule(denied, "fork vfork execve execveat")
    rule(denied, "clone", when=(sc.Arg(0, sc.MASKED_EQ, clone_thread, 0),))

    # Memory that no limit counts.
    rule(denied, "memfd_create memfd_secret shmget shmat shmctl msgget semget mq_open")
    rule(denied, "mbind migrate_pages move_pages vmsplice")

    # The network. A pair of stream sockets stays, which asyncio needs; a datagram one could send to a path.
    rule(denied, "socket connect bind listen accept accept4")
    rule(denied, "socketpair", when=(sc.Arg(0, sc.NE, 1),))
    for kind in {*range(16)} - {1}:  # a raw one is a datagram one by another name
        rule(denied, "socketpair", when=(sc.Arg(1, sc.MASKED_EQ, 0xF, kind),))

    # Landlock does not see metadata, and before its version 3 not that a file opened for reading is emptied.
    # Metadata: a lie instead of a refusal, or copying a file would fail.
    rule(pretended, "chmod fchmod fchmodat fchmodat2 chown fchown lchown fchownat utime utimes futimesat utimensat")
    rule(pretended, "setxattr lsetxattr fsetxattr removexattr lremovexattr fremovexattr")
    rule(no_attributes, "getxattr lgetxattr fgetxattr listxattr llistxattr flistxattr")
    rule(no_link, "readlink readlinkat")
    rule(denied, "truncate")
    for name, flags in (("open", 1), ("openat", 2)):
        rule(denied, name, when=(sc.Arg(flags, sc.MASKED_EQ, os.O_TRUNC | os.O_ACCMODE, os.O_TRUNC),))
        rule(denied, name, when=(sc.Arg(flags, sc.MASKED_EQ, os.O_ACCMODE, os.O_ACCMODE),))  # for nothing but ioctl
    rule(unknown, "openat2")  # its flags are out of sight; callers take openat

    with tempfile.TemporaryFile() as file:
        filter.export_bpf(file)
        file.seek(0)
        return _nothing_newer() + file.read()


def _nothing_newer() -> bytes:
    """The beginning of a program: calls that libseccomp may not know yet do not exist, whatever they do."""
    load_number, jump_unless_less, answer = 0x20, 0x35, 0x06  # of the kernel's classic packet filter
    refused = 0x50000 | errno.ENOSYS
    program = ((load_number, 0, 0, 0), (jump_unless_less, 0, 1, NEWER), (answer, 0, 0, refused))
    return b"".join(struct.pack("=HBBI", *instruction) for instruction in program)
