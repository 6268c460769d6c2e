"""The pre-imported parent: imports the libraries once, then forks one hardened worker for each request.

Trusted until it forks: it sees no submission, no secret and no answer, only descriptors that it passes on.  Its
standard input is the control socket; when that closes, the judge is gone, and the parent goes with every worker.
"""

import base64
import gc
import json
import os
import signal
import socket
import sys

from . import harden, probe

GIB = 1 << 30
HIDDEN_FROM_WORKERS = ("/proc", "/worker", "/parent", "/dev/shm")  # in a namespace of the worker's own
DESCRIPTORS = 3


def main() -> None:
    control = socket.socket(fileno=os.dup(0))
    sys.path.remove(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    _, (file,), _, _ = socket.recv_fds(control, 1 << 8, 1)
    with open(file) as plan:
        plan = json.load(plan)
    ready = None if plan["probe"] else warm()
    threads = len(os.listdir("/proc/self/task"))
    if threads != 1:
        sys.exit(f"the parent has {threads} threads, and only one of them would survive a fork")
    plan["address_space"] = harden.mapped_bytes() + GIB
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # the kernel buries the workers
    sys.stdout.flush()  # or every worker would print what is waiting here
    sys.stderr.flush()
    gc.collect()
    gc.freeze()
    read, listed = plan.pop("around_hidden")
    if not plan["namespaces"]:  # there, mounts hide the hidden, and Landlock would forbid the mounts still to be made
        harden.landlock(read, listed, [plan["folder"], "/dev/null"])
    control.send(b"ready")
    while True:
        message, descriptors, _, _ = socket.recv_fds(control, 1 << 16, DESCRIPTORS)
        if not message:
            return
        if os.fork() == 0:
            start(plan, message.decode(), descriptors, control, ready)
        for fd in descriptors:
            os.close(fd)


def warm():
    """Import what a course needs, and run each of its slow first times now."""
    import io

    import matplotlib.pyplot as plt
    import scipy.integrate
    import scipy.linalg
    import scipy.optimize
    import scipy.sparse.linalg  # noqa: F401
    import sympy  # noqa: F401

    from . import serve, shell  # noqa: F401

    figure, axes = plt.subplots()
    axes.plot([0, 1], label="$x$")
    axes.legend()
    figure.savefig(io.BytesIO(), format="png")
    plt.close("all")
    notebook = shell.notebook()
    notebook.shell.run_cell("1 / 0", store_history=False)
    return notebook


def start(plan, work, descriptors, control, notebook) -> None:
    """In the first fork: become the worker, or fork it into namespaces of its own; never returns."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    try:
        if plan["namespaces"]:
            harden.unshare(harden.CLONE_NEWPID | harden.CLONE_NEWNS | harden.CLONE_NEWIPC)
            harden.mount("none", "/", flags=harden.MS_REC | harden.MS_SLAVE)
            if os.fork():
                os._exit(0)
        handle = os.pidfd_open(os.getpid())  # by it the judge can kill this process, whatever its number
    except OSError as error:
        control.send(str(error).encode())
        os._exit(70)
    socket.send_fds(control, [b"started"], [handle])
    try:
        worker(plan, work, descriptors, notebook)
    except BaseException as error:
        os.write(2, f"{type(error).__name__}: {error}".encode())
    os._exit(0)


def worker(plan, work, descriptors, notebook) -> None:
    for target, fd in enumerate(descriptors):
        os.dup2(fd, target + 60)
    for target in range(DESCRIPTORS):
        os.dup2(target + 60, target)
    os.closerange(DESCRIPTORS, os.sysconf("SC_OPEN_MAX"))
    os.setsid()
    confine(plan, work)
    if notebook is None:
        os.write(2, probe.report(plan["probe"]).encode())
        return
    from .serve import Server, private_descriptors

    Server(*private_descriptors(), notebook).serve()


def confine(plan, work: str) -> None:
    """All walls, in the order in which they can be built."""
    if plan["namespaces"]:
        harden.mount("tmpfs", work, "tmpfs", harden.MS_NOSUID | harden.MS_NODEV, plan["disk"])
        for folder in HIDDEN_FROM_WORKERS:
            harden.mount("tmpfs", folder, "tmpfs", harden.MS_RDONLY, "size=4k")
        harden.drop_capabilities()
    else:
        harden.prctl(harden.PR_SET_PDEATHSIG, signal.SIGKILL)
    os.chdir(work)
    os.environ.update(HOME=work, TMPDIR=work, IPYTHONDIR=work)
    harden.prctl(harden.PR_SET_DUMPABLE, 0)
    harden.limit(plan["address_space"])
    if harden.landlock_abi() or not plan["namespaces"]:
        harden.landlock(plan["read"], write=[work, "/dev/null"])
    harden.seccomp(base64.b64decode(plan["seccomp"]))


if __name__ == "__main__":
    main()
