"""One source makes the exercise and the executed solution; nothing of the solution reaches a student."""

import json
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import nbformat
import pytest

from autograder.checks import EXERCISES
from autograder.release import ReleaseError, Source, canonical, hand_out, project, sources, with_gaps

ROOT = Path(__file__).parents[1]
SOURCES = sources(ROOT)


def test_every_exercise_has_a_source_and_every_source_an_exercise():
    assert [s.path.stem for s in SOURCES] == list(EXERCISES)


@pytest.mark.parametrize("source", SOURCES, ids=lambda s: s.path.stem)
def test_the_notebooks_are_what_their_source_says(source):
    assert source.stale() == []


@pytest.mark.parametrize("source", SOURCES, ids=lambda s: s.path.stem)
def test_the_exercise_is_made_with_the_same_bytes_anywhere(source, tmp_path):
    copy = Source(tmp_path / "elsewhere" / "solutions" / source.path.name)
    copy.path.parent.mkdir(parents=True)
    shutil.copy(source.path, copy.path)
    shutil.copy(source.solution, copy.solution)  # fresh, so that it need not be executed
    assert copy.release() == [copy.exercise]
    assert copy.exercise.read_bytes() == source.exercise.read_bytes()
    assert b"\r" not in copy.exercise.read_bytes()


@pytest.mark.parametrize("source", SOURCES, ids=lambda s: s.path.stem)
def test_no_line_of_a_solution_is_in_the_exercise(source):
    inside = re.findall(r"### BEGIN SOLUTION\n(.*?)### END SOLUTION", source.path.read_text("utf-8"), re.DOTALL)
    # what also stands outside of a gap gives nothing away
    outside = re.sub(r"### BEGIN SOLUTION\n.*?### END SOLUTION", "", source.path.read_text("utf-8"), flags=re.DOTALL)
    secret = {line.strip() for gap in inside for line in gap.splitlines()} - {
        line.strip() for line in outside.splitlines()
    }
    handed_out = "\n".join(cell.source for cell in nbformat.read(source.exercise, as_version=4).cells)
    assert len(secret) > 20
    assert [line for line in secret if re.search(r"\w", line) and line in handed_out] == []
    assert "SOLUTION" not in handed_out


@pytest.mark.parametrize("source", SOURCES, ids=lambda s: s.path.stem)
def test_each_task_has_its_function_and_its_check_in_the_notebook(source):
    code = "\n".join(cell.source for cell in canonical(source.path).cells)
    for task in EXERCISES[source.path.stem].tasks:
        assert f"def {task.function}(" in code
        assert f'check("{task.name}")' in code
    written = re.findall(r"^## Task \d+: .* \(([\d.]+) points?\)$", code, re.MULTILINE)
    assert [float(p) for p in written] == [t.points for t in EXERCISES[source.path.stem].tasks]


def test_a_changed_source_makes_both_notebooks_stale(tmp_path):
    source = Source(tmp_path / "solutions" / SOURCES[0].path.name)
    source.path.parent.mkdir()
    text = SOURCES[0].path.read_text("utf-8")
    source.path.write_text(text.replace("Follow the tangent", "Follow it"), encoding="utf-8")
    for path in (source.solution, source.exercise):
        path.parent.mkdir(exist_ok=True)
        shutil.copy(SOURCES[0].solution.parents[1] / path.parent.name / path.name, path)
    assert source.stale() == [source.solution, source.exercise]


def test_a_marker_without_a_partner_is_refused(tmp_path):
    path = tmp_path / "lost.md"
    head = SOURCES[0].path.read_text("utf-8").split("\n# ")[0]
    path.write_text(head + "\n\n```{code-cell} ipython3\n### BEGIN SOLUTION\nx = 1\n```\n", encoding="utf-8")
    with pytest.raises(ReleaseError, match=r"lost\.md, cell-01: a BEGIN SOLUTION"):
        with_gaps(canonical(path), path)


def test_the_project_is_found_from_a_folder_inside_it():
    assert project(ROOT / "autograder" / "checks") == ROOT


def test_the_hand_out_holds_the_exercises_and_nothing_secret(tmp_path):
    names = hand_out(ROOT, tmp_path / "one.zip")
    hand_out(ROOT, tmp_path / "two.zip")
    assert (tmp_path / "one.zip").read_bytes() == (tmp_path / "two.zip").read_bytes()
    assert {"exercises/01_newton_1d.ipynb", "mechlib/newton.py", "autograder/notebook.py", "pyproject.toml"} <= set(
        names
    )
    assert not any(name.startswith(("solutions", "tests", "_build", ".")) for name in names)
    salt = (ROOT / "tests/cohort/salt").read_bytes().strip()
    with zipfile.ZipFile(tmp_path / "one.zip") as archive:
        contents = [archive.read(name) for name in archive.namelist()]
    assert not any(salt in content for content in contents)
    assert not any(
        b"BEGIN SOLUTION" in c for name, c in zip(names, contents, strict=True) if name.startswith("exercises")
    )


def test_a_changed_stored_number_in_a_checked_cell_is_noticed(tmp_path):
    def nbval(path):
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--nbval-lax", str(path)]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)

    notebook = json.loads(SOURCES[0].solution.read_text("utf-8"))
    checked = [c for c in notebook["cells"] if "nbval-check-output" in c["metadata"].get("tags", [])]
    assert checked
    (tmp_path / "as_stored.ipynb").write_text(json.dumps(notebook), encoding="utf-8")
    output = checked[0]["outputs"][0]
    changed = re.sub(r"\d", lambda digit: str((int(digit[0]) + 1) % 10), "".join(output["text"]), count=1)
    assert changed != "".join(output["text"])
    output["text"] = changed
    (tmp_path / "changed.ipynb").write_text(json.dumps(notebook), encoding="utf-8")
    right, wrong = nbval(tmp_path / "as_stored.ipynb"), nbval(tmp_path / "changed.ipynb")
    assert right.returncode == 0, right.stdout
    assert wrong.returncode == 1, wrong.stdout
    assert "1 failed" in wrong.stdout
