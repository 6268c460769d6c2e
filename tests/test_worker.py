"""Claims about cells: they run as in a notebook, fail one by one, and import what the exercise allows."""

import textwrap

import psutil
import pytest

from autograder.channel import Value
from autograder.isolation import survey
from autograder.sandbox import Sandbox

NEWTON = {
    "mechlib/newton.py": "from .tolerance import TOL\n\n\ndef tol():\n    return TOL\n",
    "mechlib/tolerance.py": "TOL = 1e-9\n",
}


@pytest.fixture(scope="module", params=["best", "none"])
def sandbox(request):
    with Sandbox(survey().best if request.param == "best" else "none") as sandbox:
        yield sandbox


@pytest.fixture
def worker(sandbox):
    with sandbox.worker(NEWTON) as worker:
        yield worker


def run(worker, source):
    return worker.run(textwrap.dedent(source), seconds=30)


@pytest.mark.parametrize(
    ("source", "printed"),
    [
        ("1 + 1", "2"),
        ("%matplotlib inline\nimport matplotlib.pyplot as plt\nplt.plot([1, 2])\nplt.show()", ""),
        ("%timeit -n1 -r1 sum(range(3))", "1 loop each"),
        ("import asyncio\nawait asyncio.sleep(0)\nprint('awaited')", "awaited"),
        ("%%writefile helper.py\nA = 4", "Writing helper.py"),
        ("!ls", "off"),
        ("found = !ls\nassert found == []", "off"),
        ("%pip install numpy", "off"),
        ("%%bash\nls", "off"),
        ("%no_such_magic\nx = 1\nprint(x)", "%no_such_magic is passed over"),
        ("%load_ext line_profiler\nprint(1)", "%load_ext is passed over"),
        ("%timeit sum(range(3))", "1 run, 1 loop each"),
        ("%%timeit -n3\nsum(range(3))", "1 run, 3 loops each"),
        ("import warnings\nwarnings.warn('mind the step')", "mind the step"),
        ("help(len)", "number of items"),
        ("from autograder.notebook import check\ncheck('newton_1d')", ""),
    ],
    ids=lambda text: text.partition("\n")[0],
)
def test_a_cell_does_as_in_a_notebook(worker, source, printed):
    assert run(worker, source).raised is None
    assert printed in worker.output


@pytest.mark.parametrize(
    ("source", "error"),
    [
        ("def f(:", "SyntaxError"),
        ("  x = 1\n y = 2", "IndentationError"),
        ("1 / 0", "ZeroDivisionError"),
        ("import sys; sys.exit(0)", "SystemExit"),
        ("exit()", "SystemExit"),
        ("raise KeyboardInterrupt", "KeyboardInterrupt"),
        ("def f(): return f()\nf()", "RecursionError"),
        ("(" * 300, "SyntaxError"),
        ("%%no_such_magic\nx = 1", "UsageError"),
    ],
)
def test_an_error_is_that_cells_alone(worker, source, error):
    before, failed, after = run(worker, "x = 1"), run(worker, source), run(worker, "assert x == 1")
    assert (before.raised, after.raised) == (None, None)
    assert failed.raised.type == error


def test_input_is_refused_with_a_sentence(worker):
    assert "nobody" in run(worker, "input('x = ')").raised.message


def test_an_exception_whose_methods_raise_is_reported_all_the_same(worker):
    found = run(worker, "class E(ValueError):\n    def __str__(self): raise TypeError\nraise E").raised
    assert (found.type, found.bases[0], found.message) == ("E", "ValueError", "")


def test_figures_do_not_pile_up(worker):
    run(worker, "import matplotlib.pyplot as plt\nfor _ in range(30): plt.figure()")
    run(worker, "assert plt.get_fignums() == []")
    assert run(worker, "assert plt.get_fignums() == []").raised is None


def test_random_numbers_are_the_same_in_every_worker(sandbox):
    draws = "import random\nimport numpy as np\ndef draw(): return random.random(), np.random.rand(), list({'a', 'b'})"
    found = []
    for _ in range(2):
        with sandbox.worker() as worker:
            run(worker, draws)
            found.append(worker.call("draw", seconds=20))
    assert found[0] == found[1]


def test_a_worker_that_was_begun_ahead_is_as_fresh_as_any(sandbox):
    for _ in range(3):
        sandbox.prepare()
        with sandbox.worker() as worker:
            assert run(worker, "assert 'left' not in globals()\nleft = 1\nopen('left', 'x').close()").raised is None


def test_a_sandbox_at_rest_holds_no_worker(sandbox):
    sandbox.rest()
    there = {process.pid for process in psutil.Process().children(recursive=True)}
    for _ in range(3):
        worker = sandbox.worker()
        sandbox.prepare()
        sandbox.dismiss(worker)
    sandbox.rest()
    assert {process.pid for process in psutil.Process().children(recursive=True)} == there


def test_an_allowed_module_is_imported_with_what_it_needs(worker):
    run(worker, "from mechlib.newton import tol\nimport mechlib.newton, inspect")
    assert worker.call("tol", seconds=20) == Value(1e-9)
    assert run(worker, "assert 'return TOL' in inspect.getsource(mechlib.newton.tol)").raised is None


@pytest.mark.parametrize(
    "source", ["import mechlib.hacksaw", "from mechlib import hacksaw", "from mechlib.hacksaw import f"]
)
def test_another_module_is_refused_in_a_sentence_that_names_the_allowed(worker, source):
    found = run(worker, source).raised
    assert (found.type, found.message) == (
        "ImportError",
        "mechlib.hacksaw is not part of this exercise: you may import mechlib.newton, mechlib.tolerance",
    )


def test_an_exercise_that_allows_none_says_so(sandbox):
    with sandbox.worker() as worker:
        for name in ("mechlib", "mechlib.newton"):
            message = run(worker, f"import {name}").raised.message
            assert message == "mechlib is not part of this exercise: this exercise uses nothing of mechlib"


@pytest.mark.parametrize("name", ["autograder.spec", "autograder.checks", "autograder.worker.wire"])
def test_nothing_else_of_the_autograder_is_there(worker, name):
    assert run(worker, f"import {name}").raised.type == "ImportError"
    assert run(worker, "import sys\nassert not [m for m in sys.modules if m.startswith('worker')]").raised is None


GAP = '''
def f(x):
    """What f gives.

    Returns
    -------
    float
    """
    raise NotImplementedError("f is yours to write")
'''


def test_an_untouched_copy_after_the_real_thing_is_passed_over(worker):
    run(worker, GAP)
    assert worker.call("f", (1.0,), seconds=20).type == "NotImplementedError"
    assert run(worker, "def f(x):\n    return 2 * x").note is None
    assert run(worker, GAP).note == "an untouched copy of the cell for f was passed over"
    assert worker.call("f", (1.0,), seconds=20) == Value(2.0)


@pytest.mark.parametrize(
    "again",
    [
        "x = 1\n" + GAP,
        GAP + "\ndef g():\n    return 1",
        GAP + "\ndef unheard_of():\n    raise NotImplementedError",
        "def f(x):\n    print(x)\n    raise NotImplementedError",
        "def f(x):\n    raise ValueError",
        "def f(x):\n    'a docstring alone'",
    ],
)
def test_any_other_second_definition_counts(worker, again):
    run(worker, "def f(x):\n    return 2 * x")
    assert run(worker, again).note is None
    assert worker.call("f", (1.0,), seconds=20) != Value(2.0)


def test_a_gap_after_a_gap_is_not_passed_over_and_a_failed_cell_keeps_the_real_thing_real(worker):
    assert (run(worker, GAP).note, run(worker, GAP).note) == (None, None)
    run(worker, "f = lambda x: 3 * x")
    assert run(worker, "1 / 0\n" + GAP).raised.type == "ZeroDivisionError"
    assert run(worker, GAP).note is not None
    assert worker.call("f", (1.0,), seconds=20) == Value(3.0)
