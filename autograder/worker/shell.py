"""Cells as IPython runs them, without a kernel, a history, a screen or a way out to the system's shell."""

import ast
import builtins
import site
import sys
import warnings
from dataclasses import dataclass, field
from types import FunctionType

import matplotlib
from IPython.core.error import UsageError
from IPython.core.interactiveshell import InteractiveShell
from traitlets.config import Config

from .gaps import is_gap

PACKAGE_MAGICS = set("pip conda mamba micromamba uv".split())
SYSTEM_MAGICS = set("system sx sc ! !! script bash sh cmd perl ruby python python2 python3 pypy".split())
# By the module of the standard library that was at work when a cell was refused something.
UNRELIABLE = {"subprocess": "other programs", "multiprocessing": "other processes", "socket": "the network"}


class _Shell(InteractiveShell):
    def enable_gui(self, gui=None):
        pass

    def enable_matplotlib(self, gui=None):
        return "agg", "agg"

    def _format_exception_for_storage(self, *exception, **options):
        return {}  # nobody reads it, and it calls what the submission's own exceptions define

    def ask_exit(self):
        raise SystemExit

    def system(self, cmd):
        print(f"!{cmd}: commands of the system are off while a notebook is checked")

    system_piped = system_raw = system

    def getoutput(self, cmd, split=True, depth=0):
        self.system(cmd)
        return [] if split else ""

    def run_line_magic(self, magic_name, line, _stack_depth=1):
        if self._off("%", magic_name):
            return None
        absent = ModuleNotFoundError if magic_name == "load_ext" else UsageError
        try:
            return super().run_line_magic(magic_name, _briefly(magic_name, line), _stack_depth + 1)
        except (UsageError, absent) as why:  # an extension of theirs; the rest of the cell may well be an answer
            print(f"%{magic_name} is passed over while a notebook is checked: {why}")

    def run_cell_magic(self, magic_name, line, cell):
        if not self._off("%%", magic_name):
            return super().run_cell_magic(magic_name, _briefly(magic_name, line), cell)

    def _off(self, sign, name):
        off = name in PACKAGE_MAGICS | SYSTEM_MAGICS
        if off:
            print(f"{sign}{name} is off while a notebook is checked")
        return off


def _briefly(magic: str, line: str) -> str:
    """A magic's options; nobody reads a time here, and measuring well takes as long as a cell may run."""
    if magic != "timeit":
        return line
    return " ".join([f"{option}1" for option in ("-n", "-r") if option not in line] + [line])


def _no_input(prompt="", /):
    raise RuntimeError("input() waits for somebody to type, and nobody does here: write the value into the cell")


def _unreliable(error: BaseException | None) -> str | None:
    """What an error of the system comes from that a cell may rely on in Jupyter, but not here."""
    while isinstance(error, OSError):
        trace = error.__traceback__
        while trace:
            what = UNRELIABLE.get(trace.tb_frame.f_globals.get("__name__", "").partition(".")[0])
            if what:
                return f"a notebook that is checked cannot rely on {what}"
            trace = trace.tb_next
        error = error.__context__
    return None


@dataclass
class Notebook:
    """One namespace, and the cells that ran in it."""

    shell: InteractiveShell
    gaps: dict[str, FunctionType] = field(default_factory=dict)

    @property
    def namespace(self) -> dict:
        return self.shell.user_ns

    def run(self, source: str) -> tuple[BaseException | None, str | None]:
        """Run one cell: the exception that ended it, and a note for the reader of a report."""
        definitions = self._definitions(source)
        gaps = [d.name for d in definitions if is_gap(d)]
        if gaps and len(gaps) == len(definitions) and all(self._really_defined(name) for name in gaps):
            return None, f"an untouched copy of the cell for {', '.join(gaps)} was passed over"
        before = {name: self.namespace.get(name) for name in gaps}
        try:
            result = self.shell.run_cell(source, store_history=True)
            raised = result.error_before_exec or result.error_in_exec
        except BaseException as error:  # what a cell does to IPython is that cell's error, too
            raised = error
        if "matplotlib.pyplot" in sys.modules:
            sys.modules["matplotlib.pyplot"].close("all")
        self.gaps |= {name: self.namespace[name] for name in gaps if self.namespace.get(name) is not before[name]}
        return raised, _unreliable(raised)

    def _definitions(self, source: str) -> list[ast.stmt]:
        try:
            return ast.parse(source).body
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            return []  # magics, or nothing that Python reads: IPython says which

    def _really_defined(self, name: str) -> bool:
        function = self.namespace.get(name)
        return callable(function) and function is not self.gaps.get(name)


def notebook() -> Notebook:
    """A fresh notebook, ready to run."""
    config = Config()
    config.HistoryManager.enabled = False  # on disk: In, Out and _ are there
    config.InteractiveShell.colors = "nocolor"
    config.InteractiveShell.xmode = "Minimal"
    builtins.input = _no_input
    site.sethelper()  # help(), which the isolated interpreter leaves out
    warnings.filterwarnings("ignore", "FigureCanvasAgg is non-interactive")
    matplotlib.use = lambda backend, **options: None  # "TkAgg" would open windows, or fail where there are none
    shell = _Shell.instance(config=config)
    shell.db = {}  # what %cd and %bookmark write down
    return Notebook(shell)
