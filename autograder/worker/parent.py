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
import threading
from collections.abc import Callable
from functools import partial
from typing import NoReturn

from . import harden, pages, probe

GIB = 1 << 30
HIDDEN_FROM_WORKERS = ("/proc", "/worker", "/parent", "/dev/shm")  # in a namespace of the worker's own
DESCRIPTORS = 3
REHEARSED = (  # what cells do in any notebook of the course
    "import matplotlib.pyplot as plt\nimport numpy as np",
    "def residual(x):\n    return np.array([x[0] ** 2 - 2.0])\n\nresidual(np.ones(1))",
    "1 / 0",
    "figure, axes = plt.subplots()\naxes.plot([0, 1], label='$x$')\naxes.set(xlabel='x')\naxes.legend()\nplt.show()",
)


def main() -> None:
    gc.disable()  # what it freed would leave holes, and a worker that fills one copies the page around it
    control = socket.socket(fileno=os.dup(0))
    sys.path.remove(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    _, (file,), _, _ = socket.recv_fds(control, 1 << 8, 1)
    with open(file) as plan:
        plan = json.load(plan)
    work, rehearse = answering() if plan["probe"] is None else trying(plan["probe"])
    threads = len(os.listdir("/proc/self/task"))
    if threads != 1:
        sys.exit(f"the parent has {threads} threads, and only one of them would survive a fork")
    plan["address_space"] = harden.mapped_bytes() + GIB
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # the kernel buries the workers
    sys.stdout.flush()  # or every worker would print what is waiting here
    sys.stderr.flush()
    gc.freeze()
    plan["written"] = pages.written_by(rehearse)
    read, listed = plan.pop("around_hidden")
    if not plan["namespaces"]:  # there, mounts hide the hidden, and Landlock would forbid the mounts still to be made
        harden.landlock(read, listed, [plan["folder"], "/dev/null"])
    control.send(b"ready")
    while True:
        message, descriptors, _, _ = socket.recv_fds(control, 1 << 16, DESCRIPTORS)
        if not message:
            return
        begin = partial(start, plan, message.decode(), descriptors, control, work)
        if plan["namespaces"]:
            aside(begin)
        else:
            begin()
        for fd in descriptors:
            os.close(fd)


Work = tuple[Callable[[], None], Callable[[], None]]  # and its rehearsal, which reads no question


def trying(canary: str) -> Work:
    """The work of a probe."""
    return lambda: os.write(2, probe.report(canary).encode()), lambda: None


def answering() -> Work:
    """The work of a worker, with all that it imports."""
    notebook = warm()
    from . import serve

    serve.forget_ourselves()
    return (
        lambda: serve.Server(*serve.private_descriptors(), notebook).serve(),
        lambda: [notebook.run(cell) for cell in REHEARSED],
    )


def warm():
    """Import what a course needs, and run each of its slow first times now."""
    import io

    import matplotlib.pyplot as plt
    import scipy.integrate
    import scipy.linalg
    import scipy.optimize
    import scipy.sparse.linalg  # noqa: F401
    import sympy  # noqa: F401

    from . import shell

    figure, axes = plt.subplots()
    axes.plot([0, 1], label="$x$")
    axes.legend()
    figure.savefig(io.BytesIO(), format="png")
    plt.close("all")
    notebook = shell.notebook()
    notebook.shell.run_cell("1 / 0", store_history=False)
    return notebook


def aside(begin: Callable[[], None]) -> None:
    """In a thread, for namespaces belong to a thread: with it they go, and the next worker gets others."""
    thread = threading.Thread(target=begin, name="MainThread")  # which it is in the worker
    thread.start()
    thread.join()


def start(plan, folder, descriptors, control, work) -> None:
    """Fork a worker, in namespaces of its own."""
    try:
        if plan["namespaces"]:
            harden.unshare(harden.CLONE_NEWPID | harden.CLONE_NEWNS | harden.CLONE_NEWIPC)
            harden.mount("none", "/", flags=harden.MS_REC | harden.MS_SLAVE)
        child = os.fork()
        if child == 0:
            run(plan, folder, descriptors, work)
        handle = os.pidfd_open(child)  # by it the judge can kill this process, whatever its number
        socket.send_fds(control, [b"started"], [handle])
        os.close(handle)
    except OSError as error:
        control.send(str(error).encode())


def run(plan, folder, descriptors, work) -> NoReturn:
    """In the fork: build the walls, and work behind them."""
    try:
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        gc.enable()
        pages.copy(plan["written"])
        settle(plan, folder, descriptors)
        work()
    except BaseException as error:
        os.write(2, f"{type(error).__name__}: {error}".encode())
    os._exit(0)


def settle(plan, folder, descriptors) -> None:
    """Requests, replies and output for input, output and errors, and nothing else of the parent's."""
    for target, fd in enumerate(descriptors):
        os.dup2(fd, target + 60)
    for target in range(DESCRIPTORS):
        os.dup2(target + 60, target)
    os.closerange(DESCRIPTORS, os.sysconf("SC_OPEN_MAX"))
    os.setsid()
    confine(plan, folder)


def confine(plan, folder: str) -> None:
    """All walls, in the order in which they can be built."""
    if plan["namespaces"]:
        harden.mount("tmpfs", folder, "tmpfs", harden.MS_NOSUID | harden.MS_NODEV, plan["disk"])
        for hidden in HIDDEN_FROM_WORKERS:
            harden.mount("tmpfs", hidden, "tmpfs", harden.MS_RDONLY, "size=4k")
        harden.drop_capabilities()
    else:
        harden.prctl(harden.PR_SET_PDEATHSIG, signal.SIGKILL)
    os.chdir(folder)
    os.environ.update(HOME=folder, TMPDIR=folder, IPYTHONDIR=folder)
    harden.prctl(harden.PR_SET_DUMPABLE, 0)
    harden.limit(plan["address_space"])
    if harden.landlock_abi() or not plan["namespaces"]:
        harden.landlock(plan["read"], write=[folder, "/dev/null"])
    harden.seccomp(base64.b64decode(plan["seccomp"]))


if __name__ == "__main__":
    main()
