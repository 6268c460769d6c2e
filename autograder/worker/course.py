"""The course's own modules as a submission may import them: from text, and no others."""

import sys
from importlib.abc import InspectLoader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_loader
from types import ModuleType

STAND_IN = {
    "autograder/__init__.py": "",
    "autograder/notebook.py": "def check(task, *others, **options):\n    'Does nothing: the checks run outside.'\n",
}


class Course(MetaPathFinder, InspectLoader):
    """Imports the given modules, and says which they are when another is asked for.

    Parameters
    ----------
    files : dict of str to str
        Source text by path, as ``{"mechlib/newton.py": "..."}``.
    """

    def __init__(self, files: dict[str, str]):
        self.allowed = sorted(_module(path) for path in files if not path.endswith("__init__.py"))
        self.sources = {_module(path): text for path, text in (files | STAND_IN).items()}
        self.packages = {"mechlib"} | {_module(path) for path in files | STAND_IN if path.endswith("__init__.py")}
        for name in self.allowed:  # a folder without __init__.py is a package all the same
            while name := name.rpartition(".")[0]:
                self.packages.add(name)

    def find_spec(self, name: str, path=None, target=None) -> ModuleSpec | None:
        top = name.partition(".")[0]
        if top not in self.packages:
            return None
        if name in self.sources or (name in self.packages and self.allowed):
            return spec_from_loader(name, self, origin=f"{name.replace('.', '/')}.py", is_package=name in self.packages)
        if top == "autograder":
            raise ImportError(f"{name} is not there while a notebook is checked", name=name)
        may = f"you may import {', '.join(self.allowed)}" if self.allowed else f"this exercise uses nothing of {top}"
        raise ImportError(f"{name} is not part of this exercise: {may}", name=name)

    def is_package(self, name: str) -> bool:
        return name in self.packages

    def get_source(self, name: str) -> str:
        return self.sources.get(name, "")

    def exec_module(self, module: ModuleType) -> None:
        name = module.__spec__.name
        exec(compile(self.get_source(name), module.__spec__.origin, "exec"), module.__dict__)


def _module(path: str) -> str:
    return path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def install(files: dict[str, str]) -> None:
    sys.meta_path.insert(0, Course(files))
