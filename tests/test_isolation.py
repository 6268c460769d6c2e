"""Claims about the walls, tried from inside; at level `none` the same act succeeds, so its failing says something."""

import contextlib
import os
import secrets
import shutil
import socket
import subprocess
import sys
import tempfile
import textwrap
import time
from pathlib import Path

import pytest

from autograder import isolation, sandbox, walls
from autograder.channel import Excess, TimeLimit, Value, WorkerDied
from autograder.isolation import IsolationError, Level, Survey, choose, survey
from autograder.sandbox import CONFINED, Sandbox

REPOSITORY = Path(isolation.__file__).resolve().parents[1]
SECRET = secrets.token_hex(16)


@contextlib.contextmanager
def place(level):
    """A sandbox, started while the environment holds a secret."""
    if not survey()[level].available:
        pytest.skip(f"isolation level {level}: {survey()[level].reason}")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("CANARY", SECRET)
        sandbox = Sandbox(level)
    with sandbox:
        yield sandbox


@pytest.fixture(scope="module", params=CONFINED)
def confined(request):
    with place(request.param) as sandbox:
        yield sandbox


@pytest.fixture(scope="module")
def unconfined():
    with place("none") as sandbox:
        yield sandbox


@pytest.fixture
def outside():
    """A folder that every user of this computer may read."""
    with tempfile.TemporaryDirectory() as name:
        os.chmod(name, 0o755)
        yield Path(name)


def leave(path, text=SECRET):
    path.parent.mkdir(mode=0o755, parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(0o644)
    return str(path)


def act(sandbox, source, *arguments, seconds=20):
    """The value of a function `act` inside a fresh worker."""
    with sandbox.worker({"mechlib/newton.py": "ROOT = 1.5"}) as worker:
        raised = worker.run(textwrap.dedent(source), seconds=seconds).raised
        assert raised is None, raised
        return worker.call("act", arguments, seconds=seconds)


def succeeds(answer):
    return isinstance(answer, Value) and answer.value is not False


READ = """
def act(paths):
    found = []
    for path in paths:
        try:
            with open(path, 'rb') as file:
                found.append(path if file.read() is not None else None)
        except OSError:
            pass
    return found
"""


def test_no_file_outside_can_be_read(confined, unconfined, outside):
    canaries = [leave(outside / "canary.txt"), leave(outside / "solutions" / "01_newton_1d.ipynb")]
    assert act(unconfined, READ, canaries) == Value(canaries)
    assert act(confined, READ, canaries) == Value([])


def test_nothing_of_this_project_can_be_read(confined, unconfined):
    skipped = {".venv", ".git", "_build"}
    files = [
        str(path)
        for path in REPOSITORY.rglob("*")
        if path.is_file() and not skipped & set(path.relative_to(REPOSITORY).parts)
    ]
    assert act(unconfined, READ, files) != Value([])
    assert act(confined, READ, files) == Value([])


def test_neither_installed_copies_of_ours_nor_links_to_them_can_be_read(confined, outside, monkeypatch):
    site = outside / "lib" / "site-packages"
    ours = [
        leave(site / "mechlib" / "hacksaw.py"),
        leave(site / "autograder" / "spec.py"),
        leave(site / "__editable___course_finder.py"),
        leave(site / "course.pth"),
        leave(site / "course-1.dist-info" / "direct_url.json"),
    ]
    others = [leave(site / "innocent.py", "A = 1"), leave(site / "package" / "inner.py", "B = 2")]
    monkeypatch.syspath_prepend(str(site))
    with fresh_walls(), Sandbox(confined.level) as sandbox:
        assert act(sandbox, READ, ours + others) == Value(others)
        use = "def act():\n    import innocent, package.inner as p\n    return innocent.A + p.B"
        assert act(sandbox, use) == Value(3)
        assert act(sandbox, "def act():\n    import mechlib.hacksaw").type == "ImportError"


@contextlib.contextmanager
def fresh_walls():
    cached = (walls.sites, walls.roots, walls.hidden)
    for function in cached:
        function.cache_clear()
    try:
        yield
    finally:
        for function in cached:
            function.cache_clear()


PROC = """
import glob
def act():
    found = []
    for path in glob.glob('/proc/*/environ') + glob.glob('/proc/*/cmdline') + ['/proc/self/status']:
        try:
            found.append(open(path, 'rb').read())
        except OSError:
            pass
    return len(found)
"""


def test_proc_says_nothing(confined, unconfined):
    assert act(unconfined, PROC).value > 0
    assert act(confined, PROC) == Value(0)


SEARCH = """
import gc, os, sys
planted = PLANTED
def texts():
    frame = sys._getframe()
    roots = gc.get_objects() + [dict(os.environ)]
    while frame:
        roots.append(dict(frame.f_locals))
        frame = frame.f_back
    for thing in roots:
        yield from (thing,) if isinstance(thing, (str, bytes)) else ()
        for inner in gc.get_referents(thing):
            if isinstance(inner, (str, bytes)):
                yield inner
def act(f, half, other):
    f(1.0)
    wanted = half + other
    return sum(wanted in (t if isinstance(t, str) else t.decode('latin-1')) for t in texts() if t is not wanted)
"""


def test_no_secret_of_the_judge_lies_in_memory_or_environment(confined):
    def f(x, hidden=SECRET):
        return x * len(hidden)

    halves = SECRET[:16], SECRET[16:]
    assert act(confined, SEARCH.replace("PLANTED", "None"), f, *halves) == Value(0)
    assert act(confined, SEARCH.replace("PLANTED", f"['{SECRET}']"), f, *halves).value > 0


CONNECT = """
import socket
def act(family, address):
    with socket.socket(family) as s:
        s.settimeout(5)
        s.connect(tuple(address) if isinstance(address, list) else address)
    return True
"""


def test_no_connection_is_made(confined, unconfined, outside):
    with socket.create_server(("127.0.0.1", 0)) as tcp, socket.socket(socket.AF_UNIX) as local:
        local.bind(str(outside / "socket"))
        os.chmod(outside / "socket", 0o777)
        local.listen()
        for server in (tcp, local):
            address = server.getsockname()
            address = list(address) if isinstance(address, tuple) else address
            assert succeeds(act(unconfined, CONNECT, int(server.family), address))
            assert act(confined, CONNECT, int(server.family), address).type == "PermissionError"


ATTEMPTS = {
    "a process by fork": "if os.fork() == 0: os._exit(0)",
    "a process by exec": "subprocess.run(['/bin/true'], check=True)",
    "a signal": "os.kill(os.getpid(), 0)",
    "a signal by fcntl": "import fcntl; r, w = os.pipe(); fcntl.fcntl(r, fcntl.F_SETOWN, os.getpid())",
    "a priority": "os.setpriority(os.PRIO_PROCESS, 0, os.getpriority(os.PRIO_PROCESS, 0))",
    "a file in memory": "os.close(os.memfd_create('m'))",
    "a datagram socket": "[s.close() for s in socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)]",
    "a raw handle on a process": "os.close(os.pidfd_open(os.getpid()))",
    "emptying a file opened to be read": "open('f', 'w').close(); os.close(os.open('f', os.O_RDONLY | os.O_TRUNC))",
}


@pytest.mark.parametrize("attempt", ATTEMPTS.values(), ids=ATTEMPTS)
def test_a_worker_cannot_get(confined, unconfined, attempt):
    source = f"import os, socket, subprocess\ndef act():\n    {attempt}\n    return True"
    assert act(unconfined, source) == Value(True)
    assert act(confined, source).type in ("PermissionError", "BlockingIOError")


def test_the_judge_can_be_neither_seen_nor_signalled(confined):
    source = "import os\ndef act(pid):\n    os.kill(pid, 0)"
    assert act(confined, source, os.getpid()).type in ("PermissionError", "ProcessLookupError")
    if confined.level == "namespaces":
        assert act(confined, "import os\ndef act(): return os.getpid(), os.getppid()") == Value((1, 0))


def test_a_worker_is_not_root_and_has_no_capability(confined):
    source = """
    import ctypes, os, struct
    def act():
        header, sets = struct.pack('<Ii', 0x20080522, 0), ctypes.create_string_buffer(24)
        assert ctypes.CDLL(None).capget(header, sets) == 0
        return os.getuid() != 0, sets.raw == bytes(24)
    """
    assert act(confined, source) == Value((True, True))


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid(), reason="not root")
@pytest.mark.parametrize("level", ["limits", "none"])
def test_root_runs_no_submission_at_any_level(level):
    with place(level) as sandbox:
        assert act(sandbox, "import os\ndef act(): return os.getuid(), os.getgroups()") == Value((65534, []))


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid(), reason="not root")
def test_nobody_reaches_what_it_needs_behind_a_closed_door_and_nothing_beside_it(outside):
    behind = outside / "closed"
    needed, other = leave(behind / "needed" / "file", "needed"), leave(behind / "other" / "file", "other")
    behind.chmod(0o700)
    command = ["/bin/sh", "-c", f"id -u; cat {needed} {other}"]
    ran = subprocess.run(
        sandbox._as_nobody(command, [*sandbox._interpreter(), str(behind / "needed")]), capture_output=True, text=True
    )
    assert ran.stdout == "65534\nneeded"
    assert behind.stat().st_mode & 0o777 == 0o700
    assert Path(other).read_text() == "other"


def test_threads_work(confined):
    source = """
    from concurrent.futures import ThreadPoolExecutor
    def act():
        with ThreadPoolExecutor(8) as pool:
            return list(pool.map(abs, range(-20, 0)))
    """
    assert act(confined, source) == Value(list(range(20, 0, -1)))


def test_memory_is_limited(confined, unconfined):
    reserve = "import numpy\ndef act(): return numpy.empty(3 << 27).size"  # 3 GiB, asked for and never touched
    assert act(unconfined, reserve) == Value(3 << 27)
    assert act(confined, reserve).type in ("MemoryError", "_ArrayMemoryError")
    use = "import numpy\ndef act(): return numpy.ones(1 << 26).size"  # 512 MiB is all right
    assert act(confined, use) == Value(1 << 26)
    bomb = "def act():\n    a = []\n    while True: a.append(bytearray(1 << 24))"
    with contextlib.suppress(WorkerDied):
        assert act(confined, bomb).type == "MemoryError"


def test_a_file_is_limited_in_size(confined, unconfined):
    source = "def act():\n    with open('f', 'wb') as f:\n        return f.write(bytes(20 << 20))"
    assert act(unconfined, source) == Value(20 << 20)
    assert act(confined, source).message.startswith("[Errno 27]")  # EFBIG


FILL = """
import os
def act(how):
    if how == "files of 8 MiB":
        for k in range(100):
            with open(f"{k}", "wb") as f:
                for _ in range(8): f.write(bytes(1 << 20))
    elif how == "empty files":
        for k in range(200_000): open(f"{k}", "wb").close()
    elif how == "folders in folders":
        while True:
            os.mkdir("a" * 200)
            os.chdir("a" * 200)
    elif how == "a folder without leave to read":
        os.mkdir("closed", 0o300)
        for k in range(100): open(f"closed/{k}", "wb").write(bytes(8 << 20))
"""


@pytest.mark.parametrize(
    "how", ["files of 8 MiB", "empty files", "folders in folders", "a folder without leave to read"]
)
def test_the_work_folder_is_limited(confined, how):
    if confined.level == "landlock":
        with pytest.raises(Excess):
            act(confined, FILL, how)
    else:
        assert act(confined, FILL, how).message.startswith("[Errno 28]")
    assert succeeds(act(confined, "def act():\n    open('f', 'wb').write(bytes(1 << 20)); return True"))


def test_an_endless_loop_costs_its_time_and_the_next_worker_nothing(confined):
    began = time.monotonic()
    swallow = """
    def act():
        while True:
            try:
                while True: pass
            except BaseException: pass
    """
    with pytest.raises(TimeLimit):
        act(confined, swallow, seconds=0.5)
    assert time.monotonic() - began < 2.5  # 0.5 s, a start, and a busy computer
    assert act(confined, "def act(): return 1") == Value(1)


def test_what_one_worker_did_to_its_libraries_and_files_the_next_does_not_see(confined):
    poison = """
    import builtins, numpy
    def act():
        numpy.float64, builtins.sorted, numpy.linalg.solve = None, None, None
        open('left', 'w').write('x')
        return True
    """
    look = """
    import numpy, os
    def act():
        return sorted('ba'), float(numpy.linalg.solve([[2.0]], [1.0])[0]), os.listdir('.')
    """
    assert act(confined, poison) == Value(True)
    assert act(confined, look) == Value((["a", "b"], 0.5, []))


def test_workers_at_the_same_time_cannot_reach_each_others_files(confined):
    with confined.worker() as first, confined.worker() as second:
        first.run("import os\nopen('mine', 'w').write('x')\ndef act(): return os.path.abspath('mine')", seconds=20)
        path = first.call("act", seconds=20).value
        second.run(textwrap.dedent(READ), seconds=20)
        assert first.run("open('mine').read()", seconds=20).raised is None
        assert second.call("act", ([path],), seconds=20) == Value([])


def test_files_are_gone_with_the_worker(confined, unconfined):
    leave_behind = "import os\ndef act():\n    open('file', 'w').write('x')\n    return os.path.abspath('file')"
    for place in (confined, unconfined):
        path = Path(act(place, leave_behind).value)
        assert not path.exists()
        assert place.level == "namespaces" or not path.parent.exists()


def test_folders_too_deep_for_any_path_are_gone_with_the_worker(confined):
    with confined.worker() as worker:
        worker.run("import os\nfor _ in range(1500): os.mkdir('a'); os.chdir('a')", seconds=20)
        folder = worker._process.folder
    assert folder is None or not Path(folder).exists()


def test_a_link_left_behind_takes_nothing_else_away(confined, outside):
    canary = leave(outside / "kept.txt")
    act(confined, "import os\ndef act(folder): os.symlink(folder, 'link')", str(outside))
    assert Path(canary).read_text() == SECRET


def test_a_sandbox_takes_its_folder_and_its_processes_with_it(confined):
    with Sandbox(confined.level) as sandbox:
        folder, parent = sandbox._parent.folder, sandbox._parent.process
        worker = sandbox.worker()
    assert parent.poll() is not None
    assert (folder is None) == (confined.level == "namespaces")
    assert folder is None or not Path(folder).exists()
    with worker, pytest.raises(WorkerDied):
        worker.run("1", seconds=20)


def test_a_dead_parent_is_one_sentence(confined):
    with Sandbox(confined.level) as sandbox:
        sandbox._parent.control.shutdown(socket.SHUT_RDWR)
        with pytest.raises(IsolationError, match="the parent of the workers fails"):
            sandbox.worker()


def test_a_probe_finds_a_wall_that_is_missing(confined, monkeypatch):
    pyseccomp = pytest.importorskip("pyseccomp", reason="isolation level landlock: needs pyseccomp")
    with tempfile.TemporaryFile() as file:
        pyseccomp.SyscallFilter(pyseccomp.ALLOW).export_bpf(file)
        file.seek(0)
        program = file.read()
    monkeypatch.setattr(walls, "system_calls", lambda: program)
    with pytest.raises(IsolationError, match="could still open a socket, start a process"):
        sandbox.probe(confined.level)


def test_a_missing_bubblewrap_or_libseccomp_is_said_with_what_to_do(monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda _: None)
    monkeypatch.setattr(isolation.platform, "system", lambda: "Linux")
    assert isolation._try("namespaces") == Level(
        "namespaces", False, "bubblewrap is not installed", "sudo apt install bubblewrap"
    )
    monkeypatch.setitem(sys.modules, "pyseccomp", None)
    walls.system_calls.cache_clear()
    found = isolation._try("landlock")
    assert not found.available
    assert "pip install" in found.advice


def computer(best):
    """A survey of a computer whose best level this is."""
    levels = isolation.LEVELS
    return Survey(tuple(Level(name, levels.index(name) >= levels.index(best), "it is an old one") for name in levels))


@pytest.mark.parametrize(
    ("best", "wanted", "others", "chosen"),
    [
        ("namespaces", None, True, "namespaces"),
        ("namespaces", "none", True, "namespaces"),
        ("landlock", None, True, "landlock"),
        ("landlock", "limits", True, "landlock"),
        ("limits", None, False, "limits"),
        ("limits", "limits", True, "limits"),
        ("none", None, False, "none"),
        ("namespaces", "flatpak", False, "no isolation level 'flatpak'"),
        ("landlock", "namespaces", False, "namespaces cannot be had on this computer: it is an old one"),
        ("limits", None, True, "--isolation limits runs it all the same"),
        ("none", None, True, "--isolation none runs it all the same"),
    ],
)
def test_the_level_is_the_best_there_is_if_it_is_good_enough_or_a_sentence(monkeypatch, best, wanted, others, chosen):
    monkeypatch.setattr(isolation, "survey", lambda: computer(best))
    if chosen in isolation.LEVELS:
        assert choose(wanted, others) == chosen
    else:
        with pytest.raises(IsolationError, match=chosen) as refusal:
            choose(wanted, others)
        assert "\n" not in str(refusal.value)


def test_a_report_says_which_level_why_no_better_one_and_what_would_raise_it(monkeypatch):
    levels = [Level("namespaces", False, "bubblewrap is not installed", "sudo apt install bubblewrap")]
    levels += [Level(name, True) for name in isolation.LEVELS[1:]]
    monkeypatch.setattr(isolation, "survey", lambda: Survey(tuple(levels)))
    missing = " namespaces cannot be had: bubblewrap is not installed; sudo apt install bubblewrap."
    assert isolation.statement("namespaces") == "Isolation: namespaces."
    assert isolation.statement("landlock") == "Isolation: landlock." + missing
    assert isolation.statement("limits") == "Isolation: limits." + missing + " landlock can be had as well."


def test_a_judge_that_is_killed_leaves_no_process_behind(confined, outside):
    script = f"""
import re
from autograder.sandbox import Sandbox
sandbox = Sandbox({confined.level!r})
worker = sandbox.worker()
handle = open(f"/proc/self/fdinfo/{{worker._process.handle}}").read()
print(sandbox._parent.process.pid, re.search(r"Pid:\\s*(\\d+)", handle)[1], flush=True)
worker.run("while True: pass", seconds=60)
"""
    inside = os.environ | {"TMPDIR": str(outside)}
    with subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, text=True, env=inside) as judge:
        processes = judge.stdout.readline().split()
        assert len(processes) == 2
        assert all(Path("/proc", pid).exists() for pid in processes)
        judge.kill()
    ending = time.monotonic() + 10  # s, for a busy computer; it takes milliseconds
    while time.monotonic() < ending and any(Path("/proc", pid).exists() for pid in processes):
        time.sleep(0.02)
    assert not any(Path("/proc", pid).exists() for pid in processes)
