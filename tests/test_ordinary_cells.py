"""Ordinary cells run in a worker as they would in Jupyter, and what cannot be had there is refused kindly."""

import json
import math
import textwrap

import pytest

from autograder.isolation import survey
from autograder.sandbox import CONFINED, Sandbox

SECONDS = 60  # for a busy computer
PNG, PDF, SVG, GIF = "89504e470d0a1a0a", b"%PDF-".hex(), b"<?xml".hex(), b"GIF8".hex()

# Title, cell, and what it leaves in `value`, by mathematics or by the definition of the thing itself.
CELLS = [
    (
        "eigenvalues",
        """
        import numpy as np
        n = 8
        A = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
        value = np.linalg.eigvalsh(A).tolist()
        """,
        [2 - 2 * math.cos(k * math.pi / 9) for k in range(1, 9)],
    ),
    (
        "singular values",
        """
        import numpy as np
        value = np.linalg.svd(np.array([[3.0, 0.0], [4.0, 5.0]]), compute_uv=False).tolist()
        """,
        [math.sqrt(45), math.sqrt(5)],
    ),
    (
        "least squares",
        """
        import numpy as np
        x = np.arange(5.0)
        value = np.linalg.lstsq(np.vander(x, 2), 3 * x - 1)[0].tolist()
        """,
        [3.0, -1.0],
    ),
    (
        "a stiff system by BDF and Radau",
        """
        import numpy as np
        from scipy.integrate import solve_ivp
        value = [
            solve_ivp(lambda t, y: 1e6 * (np.cos(t) - y) - np.sin(t), (0, 1), [1], method).y[0, -1].item()
            for method in ("BDF", "Radau")
        ]
        """,
        [math.cos(1)] * 2,
    ),
    (
        "a pendulum by solve_ivp with an event",
        """
        import numpy as np
        from scipy.integrate import solve_ivp
        down = lambda t, y: y[0]
        down.terminal = True
        path = solve_ivp(lambda t, y: (y[1], -y[0]), (0, 10), [1.0, 0.0], events=down, rtol=1e-10, atol=1e-12)
        value = float(path.t[-1])
        """,
        math.pi / 2,
    ),
    ("quad", "from scipy.integrate import quad\nvalue = quad(lambda x: x**-0.5, 0, 1)[0]", 2.0),
    (
        "dsolve",
        """
        from sympy import Eq, Function, dsolve, symbols, sin
        t, y = symbols("t"), Function("y")
        found = dsolve(Eq(y(t).diff(t, 2) + y(t), 0), y(t), ics={y(0): 0, y(t).diff(t).subs(t, 0): 1})
        value = str(found.rhs)
        """,
        "sin(t)",
    ),
    (
        "symbols, solved and made into a function",
        """
        import numpy as np
        import sympy as sp
        x = sp.symbols("x")
        roots = sp.solve(x**2 - 2, x)
        value = np.sort([sp.lambdify(x, x**3 / 2)(float(r)) for r in roots]).tolist()
        """,
        [-math.sqrt(2), math.sqrt(2)],
    ),
    (
        "symbols, printed",
        """
        import sympy as sp
        sp.init_printing()
        x = sp.symbols("x")
        display(sp.sqrt(x) / 2)
        value = [sp.latex(sp.sqrt(x) / 2), sp.pretty(x**2, use_unicode=False)]
        """,
        [r"\frac{\sqrt{x}}{2}", " 2\nx "],
    ),
    (
        "a sparse system",
        """
        import numpy as np
        from scipy.sparse import diags
        from scipy.sparse.linalg import spsolve
        A = diags([-np.ones(99), 2 * np.ones(100), -np.ones(99)], [-1, 0, 1], format="csc")
        value = float(spsolve(A, np.ones(100))[0])
        """,
        50.0,
    ),
    (
        "fft",
        """
        import numpy as np
        t = np.arange(64) / 64
        value = int(np.argmax(np.abs(np.fft.rfft(np.sin(2 * np.pi * 5 * t)))))
        """,
        5,
    ),
    (
        "curve_fit",
        """
        import numpy as np
        from scipy.optimize import curve_fit
        x = np.linspace(0, 2, 20)
        value = curve_fit(lambda x, a, b: a * np.exp(b * x), x, 2 * np.exp(-x), p0=(1, -0.5))[0].tolist()
        """,
        [2.0, -1.0],
    ),
    (
        "minimize",
        """
        from scipy.optimize import minimize, rosen
        value = minimize(rosen, [-1.2, 1.0], tol=1e-12, method="Nelder-Mead").x.tolist()
        """,
        [1.0, 1.0],
    ),
    (
        "root",
        """
        from scipy.optimize import root
        value = root(lambda p: (p[0] ** 2 + p[1] ** 2 - 25, p[0] - p[1] + 1), (1, 2)).x.tolist()
        """,
        [3.0, 4.0],
    ),
    (
        "interpolation",
        """
        import numpy as np
        from scipy.interpolate import CubicSpline
        x = np.arange(4.0)
        value = float(CubicSpline(x, x**3)(1.5))
        """,
        3.375,
    ),
    (
        "random numbers with a seed",
        """
        import numpy as np
        one, two = (np.random.default_rng(7).normal(size=5) for _ in range(2))
        value = bool((one == two).all() and one.std() > 0)
        """,
        True,
    ),
    (
        "plots to png, pdf and svg",
        """
        import io
        import matplotlib.pyplot as plt
        fig, ax = plt.subplots()
        ax.plot([0, 1], [1, 0], label="x")
        ax.legend()
        value = []
        for kind in ("png", "pdf", "svg"):
            fig.savefig(f"figure.{kind}")
            with open(f"figure.{kind}", "rb") as file:
                value.append(file.read(5).hex())
        plt.show()
        """,
        [PNG[:10], PDF, SVG],
    ),
    (
        "mathematics in a plot",
        r"""
        import io
        import matplotlib.pyplot as plt
        plt.title(r"$\ddot\varphi + \frac{g}{l}\sin\varphi = 0$, Größe")
        picture = io.BytesIO()
        plt.savefig(picture)
        value = picture.getvalue()[:8].hex()
        """,
        PNG,
    ),
    (
        "a surface and an image",
        """
        import io
        import matplotlib.pyplot as plt
        import numpy as np
        X, Y = np.meshgrid(*[np.linspace(-1, 1, 9)] * 2)
        fig = plt.figure()
        fig.add_subplot(121, projection="3d").plot_surface(X, Y, X * Y, cmap="viridis")
        image = fig.add_subplot(122).imshow(X * Y)
        fig.colorbar(image)
        fig.tight_layout()
        picture = io.BytesIO()
        fig.savefig(picture)
        value = picture.getvalue()[:8].hex()
        """,
        PNG,
    ),
    (
        "an animation",
        """
        import matplotlib.pyplot as plt
        from matplotlib.animation import FuncAnimation, PillowWriter
        fig, ax = plt.subplots(figsize=(1, 1))
        (line,) = ax.plot([0], [0])
        moving = FuncAnimation(fig, lambda i: line.set_data([0, i], [0, i]), frames=3)
        moving.save("moving.gif", writer=PillowWriter(fps=10))
        with open("moving.gif", "rb") as file:
            value = [file.read(4).hex(), "data:image/png;base64," in moving.to_jshtml()]
        """,
        [GIF, True],
    ),
    (
        "things displayed",
        """
        from IPython.display import HTML, Latex, Markdown, Math, Image, clear_output, display
        shown = [HTML("<b>x</b>"), Math("x^2"), Markdown("*x*"), Latex("$x$")]
        display(*shown)
        clear_output(wait=True)
        value = [thing.data for thing in shown]
        """,
        ["<b>x</b>", "x^2", "*x*", "$x$"],
    ),
    (
        "a display that is updated",
        """
        handle = display("one", display_id=True)
        handle.update("two")
        value = True
        """,
        True,
    ),
    (
        "threads",
        """
        from concurrent.futures import ThreadPoolExecutor
        with ThreadPoolExecutor(4) as threads:
            value = list(threads.map(lambda x: x**2, range(6)))
        """,
        [0, 1, 4, 9, 16, 25],
    ),
    (
        "await at the top level",
        """
        import asyncio
        async def later(x):
            await asyncio.sleep(0.01)
            return x
        value = await asyncio.gather(*(later(x) for x in range(3)))
        """,
        [0, 1, 2],
    ),
    (
        "a thread for a slow call, awaited",
        "import asyncio\nvalue = await asyncio.to_thread(sum, range(5))",
        10,
    ),
    ("%timeit", "best = %timeit -o -q -n2 -r2 sum(range(9))\nvalue = len(best.timings)", 2),
    ("%%time", "%%time\nvalue = 6 * 7", 42),
    (
        "settings of figures",
        """
        %matplotlib inline
        %config InlineBackend.figure_format = "retina"
        import matplotlib.pyplot as plt
        plt.switch_backend("agg")
        plt.plot([1, 2])
        value = len(plt.gca().lines)
        plt.show()
        """,
        1,
    ),
    ("%load_ext autoreload", "%load_ext autoreload\n%autoreload 2\nvalue = 1", 1),
    ("%%capture", "%%capture said\nprint('said')\nvalue = 1", 1),
    ("%whos", "a = 3\n%whos\n%who\nvalue = a", 3),
    ("help", "len?\nvalue = 1", 1),
    (
        "%run and %%writefile",
        "from pathlib import Path\nPath('part.py').write_text('b = 5')\n%run part.py\nvalue = b",
        5,
    ),
    (
        "temporary files and folders",
        """
        import tempfile
        from pathlib import Path
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / "Größe.txt").write_text("µ", encoding="utf-8")
            with tempfile.NamedTemporaryFile("w+") as file:
                file.write("x")
            value = [[path.name for path in Path(folder).iterdir()], Path(folder, "Größe.txt").read_text()]
        value.append(Path(folder).exists())
        """,
        [["Größe.txt"], "µ", False],
    ),
    (
        "a round trip through csv, json, npy, npz and text",
        """
        import csv, json
        import numpy as np
        a = np.arange(3.0)
        np.save("a.npy", a)
        np.savez("a.npz", a=a)
        np.savetxt("a.txt", a)
        with open("a.csv", "w", newline="") as file:
            csv.writer(file).writerow(a)
        with open("a.csv", newline="") as file:
            (row,) = csv.reader(file)
        back = json.loads(json.dumps(a.tolist()))
        value = [x.tolist() for x in (np.load("a.npy"), np.load("a.npz")["a"], np.loadtxt("a.txt"))]
        value += [[float(x) for x in row], back]
        """,
        [[0, 1, 2]] * 5,
    ),
    ("an array of 500 MB", "import numpy as np\nvalue = float(np.ones(62_500_000).sum())", 62_500_000),
    (
        "the source of a function",
        """
        import inspect
        def double(x):
            return 2 * x
        value = inspect.getsource(double)
        """,
        "def double(x):\n    return 2 * x\n",
    ),
    (
        "a traceback of one's own",
        """
        import traceback
        try:
            1 / 0
        except ZeroDivisionError:
            value = "1 / 0" in traceback.format_exc()
        """,
        True,
    ),
    (
        "dataclasses, enums and types",
        """
        from __future__ import annotations
        from dataclasses import dataclass, astuple
        from enum import Enum
        from typing import NamedTuple, Protocol
        class Kind(Enum):
            SLIDER = "slider"
        @dataclass(frozen=True)
        class Bar:
            length: float
            kind: Kind = Kind.SLIDER
        value = [astuple(Bar(2.0))[0], Bar(2.0).kind.value]
        """,
        [2.0, "slider"],
    ),
    (
        "generators and context managers",
        """
        from contextlib import contextmanager, redirect_stdout
        from itertools import accumulate
        import io
        @contextmanager
        def open_door():
            said.append("in")
            yield
            said.append("out")
        said = []
        with open_door(), redirect_stdout(io.StringIO()) as text:
            print("through")
        value = [*said, text.getvalue(), list(accumulate(range(4)))]
        """,
        ["in", "out", "through\n", [0, 1, 3, 6]],
    ),
    (
        "warnings and logs",
        """
        import logging, warnings
        logging.basicConfig()
        logging.getLogger("mine").warning("mind the step")
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            warnings.warn("mind the gap")
        value = [str(w.message) for w in caught]
        """,
        ["mind the gap"],
    ),
    (
        "the clock",
        """
        import time
        from datetime import datetime, timedelta
        begin = time.perf_counter()
        time.sleep(0.05)
        value = [time.perf_counter() - begin >= 0.05, datetime.now() > datetime(2024, 1, 1)]
        value.append((datetime(2024, 2, 28) + timedelta(days=2)).isoformat())
        """,
        [True, True, "2024-03-01T00:00:00"],
    ),
    (
        "letters of all alphabets",
        """
        import locale, sys
        φ, größe = 1.5, "Länge"
        print("φ →", φ)
        value = [φ, größe, "é".encode().hex(), sys.stdout.encoding.lower(), open("ü.txt", "w").encoding.lower()]
        """,
        [1.5, "Länge", "c3a9", "utf-8", "utf-8"],
    ),
    (
        "files copied and moved",
        """
        import shutil
        from pathlib import Path
        Path("one").mkdir()
        Path("one/a.txt").write_text("a")
        shutil.copy("one/a.txt", "b.txt")
        shutil.copytree("one", "two")
        shutil.move("two/a.txt", "c.txt")
        value = [Path("b.txt").read_text(), Path("c.txt").read_text(), sorted(p.name for p in Path("two").glob("*"))]
        """,
        ["a", "a", []],
    ),
    (
        "copies, caches and pickles",
        """
        import copy, pickle
        from functools import lru_cache
        @lru_cache
        def fib(n):
            return n if n < 2 else fib(n - 1) + fib(n - 2)
        class Point:
            def __init__(self, x):
                self.x = x
        p = Point([1])
        q, r = copy.deepcopy(p), pickle.loads(pickle.dumps(p))
        p.x.append(2)
        value = [fib(60), q.x, r.x, copy.copy(p).x]
        """,
        [1548008755920, [1], [1], [1, 2]],
    ),
    (
        "a slider",
        """
        import ipywidgets as widgets
        from ipywidgets import interact, interactive
        slider = widgets.FloatSlider(value=2.5, min=0, max=10)
        seen = []
        slider.observe(lambda change: seen.append(change["new"]), names="value")
        slider.value = 4
        found = interact(lambda x=3: seen.append(x))
        display(slider, interactive(lambda k: k, k=(0, 5)))
        value = [slider.value, seen]
        """,
        [4, [4, 3]],
    ),
    ("what came before", "5 + 5\n# %%\nvalue = [_, _ + 1, In[-2]]", [10, 11, "5 + 5"]),
    ("a number of a cell", "import math\n# %%\nmath.pi\n# %%\nvalue = list(Out.values())[-1]", math.pi),
    ("precision of what is shown", "%precision 3\nvalue = 1 / 8", 0.125),
    ("an environment variable", "%env COURSE=mechanisms\nimport os\nvalue = os.environ['COURSE']", "mechanisms"),
    (
        "folders",
        "import os\nos.mkdir('deep')\n%cd -q deep\nvalue = os.path.basename(os.getcwd())\n%cd -q ..",
        "deep",
    ),
    ("a name in a format", "k = 3\nvalue = f'{k:>4} {k!r:<2}|{k = }'", "   3 3 |k = 3"),
    ("profiling", "%prun -q total = sum(range(9))\nvalue = total", 36),
]

IDS = [title for title, *_ in CELLS]

# What cannot be had where strangers' code runs: the cell, the error if it ends the cell, and the words about it.
WITHOUT = [
    ("!ls", None, "!ls: commands of the system are off"),
    ("files = !ls", None, "!ls: commands of the system are off"),
    ("%pip install numpy", None, "%pip is off while a notebook is checked"),
    ("%conda install numpy", None, "%conda is off while a notebook is checked"),
    ("input('x = ')", "RuntimeError", "input() waits for somebody to type"),
    ("breakpoint()", "RuntimeError", "input() waits for somebody to type"),
    ("import pandas", "ModuleNotFoundError", "No module named 'pandas'"),
    ("import subprocess\nsubprocess.run(['ls'])", "PermissionError", "cannot rely on other programs"),
    ("import multiprocessing\nmultiprocessing.Pool(2)", "OSError", "cannot rely on other processes"),
    (
        "from concurrent.futures import ProcessPoolExecutor\nlist(ProcessPoolExecutor().map(abs, [1]))",
        "OSError",
        "cannot rely on other processes",
    ),
    ("import urllib.request\nurllib.request.urlopen('http://localhost')", "URLError", "cannot rely on the network"),
]


@pytest.fixture(scope="module", params=CONFINED)
def sandbox(request):
    found = survey()[request.param]
    if not found.available:
        pytest.skip(f"isolation level {request.param}: {found.reason}")
    with Sandbox(request.param) as sandbox:
        yield sandbox


def parts(source):
    """The cells of a source in percent format."""
    return textwrap.dedent(source).strip().split("\n# %%\n")


def same(value, expected):
    """Equal, but for the rounding of a float; lists item by item."""
    if isinstance(expected, list):
        return isinstance(value, list) and len(value) == len(expected) and all(map(same, value, expected))
    return value == pytest.approx(expected, rel=1e-6) if isinstance(expected, float) else value == expected


@pytest.mark.parametrize(("title", "source", "expected"), CELLS, ids=IDS)
def test_an_ordinary_cell_gives_its_value(sandbox, title, source, expected):
    with sandbox.worker() as worker:
        for cell in [*parts(source), "def left():\n    return value"]:
            ran = worker.run(cell, SECONDS)
            assert (ran.raised, ran.note) == (None, None)
        assert same(worker.call("left", seconds=SECONDS).value, expected)


def test_jupyter_itself_leaves_the_same_values(tmp_path):
    """One kernel for all, in one notebook, so that it starts once."""
    nbclient = pytest.importorskip("nbclient")
    from nbformat.v4 import new_code_cell, new_notebook

    tell = "import json as _json; print(_json.dumps(value))"
    cells = [cell for _, source, _ in CELLS for cell in (*parts(source), tell)]
    notebook = new_notebook(cells=[new_code_cell(cell) for cell in cells])
    nbclient.NotebookClient(
        notebook, timeout=SECONDS, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}
    ).execute()
    told = [json.loads(cell.outputs[0].text) for cell in notebook.cells if cell.source == tell]
    for (title, _, expected), value in zip(CELLS, told, strict=True):
        assert same(value, expected), title


@pytest.mark.parametrize(
    ("source", "error", "says"), WITHOUT, ids=[source.partition("\n")[0] for source, *_ in WITHOUT]
)
def test_what_cannot_be_had_is_refused_in_words(sandbox, source, error, says):
    with sandbox.worker() as worker:
        ran = worker.run(source, SECONDS)
        assert (ran.raised and error in (ran.raised.type, *ran.raised.bases)) == (error and True)
        assert says in f"{ran.note} {ran.raised and ran.raised.message} {worker.output}"
        assert worker.run("x = 1", SECONDS).raised is None
