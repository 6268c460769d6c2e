"""Claims about the channel: the judge's functions stay with it, and no worker hangs it or answers for another."""

import math
import subprocess
import sys
import textwrap
import time

import numpy as np
import pytest

from autograder.channel import (
    OUTPUT_KEPT,
    NotData,
    OutputFlood,
    ProtocolError,
    Raised,
    TimeLimit,
    Value,
    WorkerDied,
    WorkerLost,
)
from autograder.sandbox import Sandbox

MARGIN = 2.0  # s, for a busy computer to notice that time is over; the limits below are a fraction of it


@pytest.fixture(scope="module")
def sandbox():
    with Sandbox("none") as sandbox:
        yield sandbox


@pytest.fixture
def worker(sandbox):
    with sandbox.worker() as worker:
        yield worker


def define(worker, source):
    assert worker.run(textwrap.dedent(source), seconds=20).raised is None


def test_a_function_stays_with_the_judge_which_sees_every_evaluation_as_it_happens(worker):
    seen = []

    def f(x):
        seen.append(x)
        return x**2 - 2

    define(worker, "def bisect(f, a, b):\n    return [f(a), f((a + b) / 2), f(b)]")
    assert worker.call("bisect", (f, 0.0, 2.0), seconds=20) == Value([-2.0, -1.0, 2.0])
    assert seen == [0.0, 1.0, 2.0]


def test_functions_and_arrays_cross_at_any_depth(worker):
    define(worker, "def both(pair, *, by):\n    f, x = pair\n    return {'f': f(x, scale=2), 'g': by['g'](x)}")
    x = np.array([[1.0, 2.0]])
    found = worker.call("both", ((lambda x, scale: x * scale, x),), {"by": {"g": np.sum}}, seconds=20).value
    np.testing.assert_array_equal(found["f"], 2 * x)
    assert found["g"] == 3


@pytest.mark.parametrize(
    ("error", "arrives"),
    [
        (ZeroDivisionError("by nought"), "ZeroDivisionError"),
        (ValueError("not here"), "ValueError"),
        (np.linalg.LinAlgError("singular"), "RuntimeError"),
        (UnicodeDecodeError("utf-8", b"", 0, 1, "odd"), "RuntimeError"),
    ],
    ids=lambda e: type(e).__name__ if isinstance(e, Exception) else e,
)
def test_an_exception_of_the_judges_function_arises_in_the_worker(worker, error, arrives):
    def f(x):
        raise error

    define(
        worker,
        """
        def attempt(f):
            try:
                f(1.0)
            except Exception as error:
                return type(error).__name__, str(error)
        """,
    )
    assert worker.call("attempt", (f,), seconds=20) == Value((arrives, str(error)))
    assert worker.call("attempt", (math.sqrt,), seconds=20) == Value(None)  # and the channel goes on


def test_a_function_called_with_what_is_no_data_says_so(worker):
    define(worker, "import sympy\ndef symbolic(f):\n    return f(sympy.Symbol('x'))")
    found = worker.call("symbolic", (math.sin,), seconds=20)
    assert (found.type, found.message) == (
        "TypeError",
        "a number, a text or an array was expected, not sympy.core.symbol.Symbol",
    )


def test_a_function_called_with_more_than_a_judge_should_chew_says_so(worker):
    define(worker, "import numpy as np\ndef grid(f, n):\n    return f(np.zeros(n)).size")
    assert worker.call("grid", (np.cos, 100_000), seconds=20) == Value(100_000)
    assert worker.call("grid", (np.cos, 1_000_000), seconds=20).type == "ValueError"


def test_a_function_kept_after_its_call_cannot_be_called(worker):
    define(worker, "kept = []\ndef keep(f): kept.append(f)\ndef use(): return kept[0](1.0)")
    worker.call("keep", (math.sin,), seconds=20)
    found = worker.call("use", seconds=20)
    assert (found.type, "earlier call" in found.message) == ("RuntimeError", True)


def test_threads_that_call_at_once_get_each_their_own_answer(worker):
    define(
        worker,
        """
        from concurrent.futures import ThreadPoolExecutor
        def table(f, n):
            with ThreadPoolExecutor(8) as pool:
                return list(pool.map(f, range(n)))
        """,
    )
    assert worker.call("table", (lambda k: k * k, 400), seconds=30) == Value([k * k for k in range(400)])


def test_numpy_settings_of_the_judge_hold_for_its_functions(worker):
    define(worker, "def at(f, x):\n    return f(x)")
    with np.errstate(divide="raise"):
        assert worker.call("at", (lambda x: np.float64(1) / x, 0.0), seconds=20).type == "FloatingPointError"


def test_an_exception_comes_with_its_base_classes(worker):
    define(worker, "class ConvergenceError(ArithmeticError): pass\ndef f(): raise ConvergenceError('no root')")
    assert worker.call("f", seconds=20) == Raised(
        "ConvergenceError", ("ArithmeticError", "Exception", "BaseException"), "no root"
    )
    assert worker.call("g", seconds=20) == Raised("NameError", ("Exception", "BaseException"), "g is not defined")


def test_an_answer_that_is_no_data_is_named_and_not_sent(worker):
    define(worker, "import sympy\ndef f(): return 1, sympy.Integer(2)")
    assert worker.call("f", seconds=20) == Value((1, NotData("sympy.core.numbers.Integer")))


def test_an_answer_too_large_is_an_error_of_that_call_alone(worker):
    define(worker, "import numpy\ndef f(): return numpy.zeros(1 << 24)\ndef g(): return 'x' * (1 << 24)")
    define(worker, "def h(): return 1")
    assert worker.call("f", seconds=20).type == "ValueError"
    assert worker.call("g", seconds=20).type == "ValueError"
    assert worker.call("h", seconds=20) == Value(1)


def test_what_a_judge_gives_and_cannot_be_sent_is_an_error_of_the_judge(worker):
    define(worker, "def f(g): return g()")
    with pytest.raises(TypeError, match="not object"):
        worker.call("f", (object(),), seconds=20)
    with pytest.raises(TypeError, match="not object"):
        worker.call("f", (object,), seconds=20)


def test_output_of_both_streams_is_there_when_the_cell_is_done_and_harmless(worker):
    define(worker, r"import sys; print('one\x1b[31m red\x1b[0m \u202e'); print('two\x07', file=sys.stderr)")
    assert sorted(worker.output.split("\n")) == ["", "one red ", "two"]
    define(worker, "print('x' * 200_000)")
    assert OUTPUT_KEPT - 20 < len(worker.output) < OUTPUT_KEPT  # shorter by the characters that were taken out


@pytest.mark.parametrize("source", ["while True: pass", "import time; time.sleep(1e6)"], ids=["busy", "asleep"])
def test_a_cell_without_an_end_costs_its_time_limit(worker, source):
    began = time.monotonic()
    with pytest.raises(TimeLimit, match=r"within 0\.4 s"):
        worker.run(source, seconds=0.4)
    assert time.monotonic() - began < 0.4 + MARGIN


COMPUTE = """
import time
def compute(seconds):
    end = time.process_time() + seconds
    while time.process_time() < end:
        pass
"""


def test_the_limit_counts_what_the_worker_computes(worker):
    define(worker, COMPUTE)
    before = worker._process.computing_time()
    worker.call("compute", (0.5,), seconds=20)
    assert worker._process.computing_time() - before == pytest.approx(0.5, abs=0.1)  # the kernel counts in hundredths
    with pytest.raises(TimeLimit):
        worker.call("compute", (2.0,), seconds=0.5)


def test_sleep_is_no_computing(worker):
    define(worker, "import time\ndef f():\n    time.sleep(0.6)\n    return 1")
    assert worker.call("f", seconds=0.4) == Value(1)


def test_a_busy_computer_ends_nothing(worker, busy):
    define(worker, COMPUTE)
    began = time.monotonic()
    with busy(4):  # on each core, so that the worker gets a fifth of one
        assert worker.call("compute", (0.6,), seconds=1.5) == Value(None)
    assert time.monotonic() - began > 1.5, "the computer was not busy: this shows nothing"


def test_time_spent_in_the_judges_function_counts(worker):
    define(worker, "def f(g): return g()")
    with pytest.raises(TimeLimit):
        worker.call("f", (lambda: time.sleep(3),), seconds=0.4)  # by the clock four times as long is allowed


def test_a_worker_that_does_not_read_cannot_hang_the_judge(worker):
    define(worker, "import os, time\nos.read = lambda *_: time.sleep(1e6)")
    began = time.monotonic()
    with pytest.raises(TimeLimit):
        worker.run("#" * (1 << 22), seconds=0.4)
    assert time.monotonic() - began < 0.4 + MARGIN


@pytest.mark.skipif(not hasattr(__import__("os"), "fork"), reason="needs fork")
def test_a_process_that_outlives_the_worker_with_its_pipes_cannot_hang_the_judge(worker):
    define(worker, "import os, time\nif os.fork() == 0:\n    os.setsid()\n    time.sleep(8)\n    os._exit(0)")
    began = time.monotonic()
    with pytest.raises(TimeLimit):
        worker.run("while True: pass", seconds=0.4)
    assert time.monotonic() - began < 0.4 + 2 * MARGIN


def test_a_flood_of_output_ends_the_worker(worker):
    with pytest.raises(OutputFlood, match="4 MiB"):
        worker.run("while True: print('x' * 1000)", seconds=30)
    assert len(worker.output) == OUTPUT_KEPT


@pytest.mark.parametrize("source", ["os._exit(0)", "os.abort()", "import ctypes; ctypes.string_at(0)"])
def test_a_process_that_ends_itself_is_a_worker_that_died(worker, source):
    with pytest.raises(WorkerDied):
        worker.run(f"import os; {source}", seconds=20)


FORGE = """
import os, struct
for fd in range(3, 40):
    try:
        os.write(fd, {frame})
    except OSError:
        pass
"""
HEADER = b'{"id": "0123456789abcdef", "value": 1, "raised": null, "note": null}'


@pytest.mark.parametrize(
    "frame",
    [
        b"stray",
        b"MBC1" + bytes(12),
        b"MBC1" + bytes([len(HEADER), 0, 0, 0]) + bytes(8) + HEADER,
        b"MBC1" + b"\xff" * 12,
    ],
    ids=["stray bytes", "empty header", "another identity", "huge"],
)
def test_bytes_that_no_question_asked_for_end_the_worker(worker, frame):
    with pytest.raises(ProtocolError):
        for _ in range(2):
            worker.run(FORGE.format(frame=frame), seconds=20)


def test_after_its_loss_a_worker_is_gone_and_the_next_is_fine(sandbox):
    with sandbox.worker() as lost:
        with pytest.raises(WorkerLost):
            lost.run("import os; os._exit(1)", seconds=20)
        with pytest.raises(WorkerDied, match="gone"):
            lost.call("f", seconds=20)
    with sandbox.worker() as next_one:
        assert next_one.run("1", seconds=20).raised is None


def test_worker_and_judge_need_nothing_that_windows_does_not_have():
    """Stands in for Windows: in judge and worker alike what it lacks is taken away."""
    without = """
import os, select, sys
for name in ("fcntl", "resource", "pyseccomp"):
    sys.modules[name] = None
for name in ("fork", "geteuid", "killpg", "setsid", "pidfd_open"):
    vars(os).pop(name, None)
vars(select).pop("poll", None)
"""
    script = f"""
import psutil  # has code of its own for every system
{without}
import math, subprocess
real = subprocess.Popen.__init__
def init(self, *arguments, pass_fds=(), preexec_fn=None, **options):
    assert not pass_fds and preexec_fn is None
    real(self, *arguments, **options)
subprocess.Popen.__init__ = init
from autograder import sandbox
from autograder.isolation import choose, survey
sandbox.BOOT = {without!r} + sandbox.BOOT
with sandbox.Sandbox(choose("none", others=True)) as place, place.worker({{"mechlib/a.py": "A = 2"}}) as worker:
    assert worker.run("from mechlib.a import A\\ndef f(g): return A * g(4.0)", seconds=60).raised is None
    assert worker.call("f", (math.sqrt,), seconds=60).value == 4
    print(survey()["limits"].reason)
"""
    ran = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120)
    assert ran.returncode == 0, ran.stderr
    assert "no resource limits" in ran.stdout
