"""One source becomes two notebooks: the exercise that students get, and the executed solution.

`solutions/NN_name.md` is the source. What stands between BEGIN SOLUTION and END SOLUTION is the gap of the exercise.
"""

import re
import zipfile
from dataclasses import dataclass
from pathlib import Path

import jupytext
import nbformat
from nbclient import NotebookClient
from nbformat import NotebookNode

GAP = re.compile(r"^(?P<indent>[ \t]*)### BEGIN SOLUTION\n.*?^[ \t]*### END SOLUTION[ \t]*$", re.MULTILINE | re.DOTALL)
HANDED_OUT = ("pyproject.toml", "requirements.lock", "README.md", "LICENSE", "exercises/*.ipynb")
PACKAGES = ("mechlib", "autograder")


class ReleaseError(ValueError):
    """A source that cannot be released; the message says which and why."""


@dataclass(frozen=True)
class Source:
    """One exercise in the project's folder."""

    path: Path

    @property
    def solution(self) -> Path:
        return self.path.with_suffix(".ipynb")

    @property
    def exercise(self) -> Path:
        return self.path.parent.parent / "exercises" / self.solution.name

    def stale(self) -> list[Path]:
        """The notebooks that are not what the source says; outputs are not looked at."""
        solution = canonical(self.path)
        wanted = {self.solution: _written(solution), self.exercise: _written(with_gaps(solution, self.path))}
        return [path for path, text in wanted.items() if not path.exists() or _without_outputs(path) != text]

    def release(self) -> list[Path]:
        """Write what is stale, and return it; a solution is executed."""
        solution, stale = canonical(self.path), self.stale()
        if self.exercise in stale:
            self.exercise.parent.mkdir(exist_ok=True)
            _write(self.exercise, _written(with_gaps(solution, self.path)))
        if self.solution in stale:
            _write(self.solution, _written(executed(solution, self.path.parent)))
        return stale


def project(start: Path) -> Path:
    """The folder at or above `start` that holds the solutions."""
    for folder in (start, *start.parents):
        if any(folder.glob("solutions/*.md")):
            return folder
    raise ReleaseError(f"there is no solutions/*.md at or above {start}: call it in the folder of the course")


def sources(folder: Path) -> list[Source]:
    """The exercises of the project, in order."""
    return [Source(path) for path in sorted(folder.glob("solutions/*.md"))]


def canonical(path: Path) -> NotebookNode:
    """A source as a notebook that is the same on every computer: fixed metadata, ids by position, no outputs."""
    notebook = jupytext.read(path)
    for number, cell in enumerate(notebook.cells, 1):
        cell.id = f"cell-{number:02d}"
        cell.metadata = NotebookNode({"tags": cell.metadata.tags}) if cell.metadata.get("tags") else NotebookNode()
        if cell.cell_type == "code":
            cell.outputs, cell.execution_count = [], None
    notebook.metadata = NotebookNode(
        kernelspec={"display_name": "Python 3", "language": "python", "name": "python3"},
        language_info={"name": "python"},
        mechanisms={"exercise": path.stem},
    )
    notebook.nbformat, notebook.nbformat_minor = 4, 5
    return notebook


def with_gaps(solution: NotebookNode, path: Path) -> NotebookNode:
    """The exercise: every solution is taken out.

    Raises
    ------
    ReleaseError
        If a marker has no partner.
    """
    exercise = nbformat.from_dict(solution)
    for cell in exercise.cells:
        if cell.cell_type == "code":
            cell.source = GAP.sub(_gap, cell.source)
            if "### BEGIN SOLUTION" in cell.source or "### END SOLUTION" in cell.source:
                raise ReleaseError(f"{path.name}, {cell.id}: a BEGIN SOLUTION or END SOLUTION has no partner")
    return exercise


def _gap(found: re.Match) -> str:
    indent = found["indent"]
    functions = re.findall(r"^def (\w+)", found.string[: found.start()], re.MULTILINE)
    return f'{indent}raise NotImplementedError("{functions[-1]} is not written yet")' if indent else "# Your trial:"


def executed(notebook: NotebookNode, folder: Path) -> NotebookNode:
    """The notebook with its outputs."""
    run = nbformat.from_dict(notebook)
    NotebookClient(run, timeout=300, record_timing=False, resources={"metadata": {"path": str(folder)}}).execute()
    for cell in run.cells:
        for output in cell.get("outputs", []):
            output.pop("transient", None)
    run.metadata = notebook.metadata  # the kernel writes its version into it
    return run


def _written(notebook: NotebookNode) -> str:
    return nbformat.writes(notebook, version=4) + "\n"


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")


def _without_outputs(path: Path) -> str:
    notebook = nbformat.read(path, as_version=4)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.outputs, cell.execution_count = [], None
    return _written(notebook)


def hand_out(folder: Path, archive: Path) -> list[str]:
    """What students get, as a zip file of the same bytes everywhere: no solutions, no tests, no salt.

    Returns
    -------
    list of str
        The names in the archive.
    """
    patterns = (*HANDED_OUT, *(f"{p}/**/*" for p in PACKAGES))
    paths = {path for pattern in patterns for path in folder.glob(pattern) if path.is_file()}
    names = sorted(p.relative_to(folder).as_posix() for p in paths if "__pycache__" not in p.parts)
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as zipped:
        for name in names:
            entry = zipfile.ZipInfo(f"mechanisms/{name}", date_time=(1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            zipped.writestr(entry, (folder / name).read_bytes())
    return names
