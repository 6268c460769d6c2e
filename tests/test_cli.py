"""The commands do what they promise: exit codes, one sentence for what is wrong, and no traceback."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


def autograder(*arguments, cwd=ROOT, prelude="", **environment):
    command = [sys.executable, "-c", f"{prelude}\nfrom autograder.cli import main\nmain()", *map(str, arguments)]
    env = {**os.environ, "COLUMNS": "200", **environment}
    return subprocess.run(
        command, cwd=cwd, env=env, capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=300
    )


def sentence(done):
    """The one line on stderr."""
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    return line


def test_check_gives_zero_for_full_points_and_one_for_missing_ones():
    full = autograder("check", "solutions/01_newton_1d.ipynb", "--json")
    none = autograder("check", "exercises/02_newton_nd.ipynb", "--json")
    assert (full.returncode, none.returncode) == (0, 1), full.stderr + none.stderr
    report = json.loads(full.stdout)
    assert list(report) == ["exercise", "points", "max", "isolation", "tasks"]
    assert (report["exercise"], report["points"], report["max"]) == ("01_newton_1d", 10, 10)
    assert list(report["tasks"][0]) == ["task", "points", "max", "verdict", "diagnosis"]
    assert {t["verdict"] for t in json.loads(none.stdout)["tasks"]} == {"missing"}


def test_check_says_in_words_what_was_looked_at():
    done = autograder("check", "exercises/01_newton_1d.ipynb")
    assert "brackets: not started, 0 of 2 points" in done.stdout
    assert "0 of 10 points" in done.stdout
    assert not done.stderr


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("absent.ipynb", None, "does not exist"),
        ("text.ipynb", b"hello", "not JSON"),
        ("latin.ipynb", "é".encode("latin-1"), "not UTF-8"),
        ("empty.ipynb", b"", "the file is empty"),
        ("large.ipynb", 100 << 20, "has 100 MB"),
        (
            "essay.ipynb",
            b'{"cells": []}',
            "essay.ipynb is no exercise of this course: there are 01_newton_1d, 02_newton_nd",
        ),
        ("01_newton_1d.ipynb", b'{"cells": []}', "is it a notebook of another course?"),
        ("link.ipynb", "link", "is a link"),
        ("folder.ipynb", "folder", "is a folder"),
    ],
)
def test_check_of_what_cannot_be_graded_is_one_sentence_and_two(tmp_path, name, content, says):
    path = tmp_path / name
    if content == "link":
        path.symlink_to(ROOT / "exercises/01_newton_1d.ipynb")
    elif content == "folder":
        path.mkdir()
    elif isinstance(content, int):
        with open(path, "wb") as file:
            file.truncate(content)
    elif content is not None:
        path.write_bytes(content)
    assert says in sentence(autograder("check", path))


def test_an_unknown_isolation_level_is_answered_with_those_there_are():
    assert "namespaces, landlock, limits" in sentence(
        autograder("check", "exercises/01_newton_1d.ipynb", "--isolation", "docker")
    )


PAGE = "feedback/someone/01_newton_1d.html"
UNCONFINED = """
from autograder import isolation
from autograder.isolation import Level, Survey
missing = [Level(name, False, "tried, and refused", "get it") for name in ("namespaces", "landlock")]
there = Survey((*missing, Level("limits", True), Level("none", True)))
isolation.survey = lambda: there
"""


def test_grading_others_is_refused_below_landlock_unless_asked_for_by_name(tmp_path):
    folder = tmp_path / "in/someone"
    folder.mkdir(parents=True)
    (folder / "01_newton_1d.ipynb").write_bytes(b"")
    arguments = ("grade", tmp_path / "in", "--out", tmp_path / "out")
    refused = sentence(autograder(*arguments, prelude=UNCONFINED))
    assert "--isolation limits" in refused
    assert not (tmp_path / "out").exists()
    by_name = autograder(*arguments, "--isolation", "limits", prelude=UNCONFINED)
    assert by_name.returncode == 0, by_name.stderr
    assert "limits" in (tmp_path / "out/grades.csv").read_text("utf-8")
    reports = (by_name.stdout, *((tmp_path / "out" / f).read_text("utf-8") for f in ("index.html", PAGE)))
    for report in reports:  # the level, why it is no better, and what would raise it
        assert "Isolation: limits. namespaces cannot be had: tried, and refused; get it." in report
    more = sentence(autograder(*arguments, "--isolation", "namespaces", prelude=UNCONFINED))
    assert "namespaces" in more


def test_grade_of_nothing_is_refused(tmp_path):
    assert "is not a folder of submissions" in sentence(
        autograder("grade", tmp_path / "absent", "--out", tmp_path / "out")
    )
    assert "holds no <student>" in sentence(autograder("grade", tmp_path, "--out", tmp_path.parent / "out"))


def test_a_journal_that_is_none_is_one_sentence(tmp_path):
    (tmp_path / "in/someone").mkdir(parents=True)
    (tmp_path / "in/someone/01_newton_1d.ipynb").write_bytes(b"")
    (tmp_path / "out").mkdir()
    (tmp_path / "out/journal.sqlite").write_bytes(b"not a database, and long enough to be sure of it" * 10)
    done = autograder("grade", tmp_path / "in", "--out", tmp_path / "out", "--isolation", "none")
    assert done.returncode == 2
    assert "the journal cannot be used" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_salt_that_is_missing_or_empty_is_one_sentence(tmp_path):
    (tmp_path / "empty").touch()
    for name, says in (("absent", "cannot be read"), ("empty", "is empty")):
        done = autograder(
            "grade", tmp_path, "--out", tmp_path / "out", "--salt", tmp_path / name, "--isolation", "none"
        )
        assert says in sentence(done)


def test_release_outside_the_course_is_one_sentence(tmp_path):
    assert "in the folder of the course" in sentence(autograder("release", cwd=tmp_path))


def test_isolation_names_every_level():
    words, data = autograder("isolation"), autograder("isolation", "--json")
    assert all(level in words.stdout for level in ("namespaces", "landlock", "limits", "none"))
    assert len(json.loads(data.stdout)["levels"]) == 4


# A computer with Windows has none of these; one with macOS lacks some.
ELSEWHERE = """
import importlib.abc, os, sys
import psutil  # has code of its own for every system

class Absent(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name in ("fcntl", "resource", "pyseccomp", "termios", "pwd", "grp"):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

for name in ("fcntl", "resource", "pyseccomp", "termios", "pwd", "grp"):
    sys.modules.pop(name, None)
sys.meta_path.insert(0, Absent())
for name in ("fork", "forkpty", "killpg", "setsid", "geteuid", "getuid", "pidfd_open", "mkfifo"):
    if hasattr(os, name):
        delattr(os, name)
"""


def test_check_works_without_anything_that_only_linux_has():
    done = autograder("check", "solutions/01_newton_1d.ipynb", "--json", "--isolation", "none", prelude=ELSEWHERE)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["isolation"] == "none"
    untouched = autograder("check", "exercises/01_newton_1d.ipynb", "--isolation", "none", prelude=ELSEWHERE)
    assert untouched.returncode == 1, untouched.stderr


def test_the_best_level_elsewhere_is_found_without_being_asked_for():
    done = autograder("check", "exercises/01_newton_1d.ipynb", "--json", prelude=ELSEWHERE)
    assert done.returncode == 1, done.stderr
    assert json.loads(done.stdout)["isolation"] == "none"


def test_check_in_a_notebook_works_without_anything_that_only_linux_has():
    code = f"{ELSEWHERE}\nfrom autograder.notebook import check\nprint(check('brackets'))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert "brackets: not started" in done.stdout, done.stderr


def test_an_endless_loop_ends_at_level_none_too(tmp_path):
    notebook = json.loads((ROOT / "exercises/01_newton_1d.ipynb").read_text("utf-8"))
    for cell in notebook["cells"]:
        cell["source"] = "".join(cell["source"]).replace(
            'raise NotImplementedError("brackets is not written yet")', "while True: pass"
        )
    (tmp_path / "01_newton_1d.ipynb").write_text(json.dumps(notebook), encoding="utf-8")
    done = autograder("check", tmp_path / "01_newton_1d.ipynb", "--json", "--isolation", "none", prelude=ELSEWHERE)
    verdicts = {t["task"]: t["verdict"] for t in json.loads(done.stdout)["tasks"]}
    assert verdicts == {"brackets": "timeout", "newton_1d": "missing", "failures": "missing", "order": "missing"}
