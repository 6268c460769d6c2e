"""A cohort is graded as it was foretold, and nobody's work harms anybody else's."""

import csv
import json
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from handing_in import GOOD_ORDER, exercise, hand_in

from autograder.checks import EXERCISES
from autograder.cohort import grade_cohort
from autograder.ingest import Refused
from autograder.isolation import survey

ROOT = Path(__file__).parents[1]
COHORT = ROOT / "tests" / "cohort"
SALT = (COHORT / "salt").read_text("utf-8").strip()
CONFINED = ("namespaces", pytest.param("landlock", marks=pytest.mark.proof))


@pytest.fixture(params=CONFINED)
def level(request):
    found = survey()[request.param]
    if not found.available:
        pytest.skip(f"isolation level {request.param}: {found.reason}")
    return request.param


def graded(folder, out, level, **options):
    grade_cohort(folder, out, level, SALT, **options)
    with open(out / "grades.csv", encoding="utf-8", newline="") as file:
        return {(row["student"], row["task"]): row for row in csv.DictReader(file)}


def test_the_cohort_gets_what_was_foretold_twice_with_the_same_bytes(tmp_path, level):
    rows = graded(COHORT / "submissions", tmp_path / "one", level, jobs=2)
    graded(COHORT / "submissions", tmp_path / "two", level, jobs=1)
    with open(COHORT / "expected.csv", encoding="utf-8", newline="") as file:
        expected = {(row["student"], row["task"]): row for row in csv.DictReader(file)}

    assert rows.keys() == expected.keys()
    for key, row in rows.items():
        foretold = expected[key]
        assert [row[c] for c in ("points", "max", "verdict")] == [foretold[c] for c in ("points", "max", "verdict")], (
            key
        )
        assert foretold["mistake"] in row["diagnosis"], key
        assert row["isolation"] == level
    pages = sorted(p.relative_to(tmp_path / "one") for p in (tmp_path / "one").rglob("*.html"))
    assert len(pages) == 17
    assert (tmp_path / "one/grades.csv").read_bytes() == (tmp_path / "two/grades.csv").read_bytes()
    for page in pages:
        assert (tmp_path / "one" / page).read_bytes() == (tmp_path / "two" / page).read_bytes(), page


@pytest.mark.proof
def test_a_loaded_computer_changes_no_byte(tmp_path, level, busy):
    graded(COHORT / "submissions", tmp_path / "idle", level, jobs=2)
    with busy(2):
        graded(COHORT / "submissions", tmp_path / "loaded", level, jobs=2)
    for path in [*(tmp_path / "idle").rglob("*.html"), tmp_path / "idle/grades.csv"]:
        twin = tmp_path / "loaded" / path.relative_to(tmp_path / "idle")
        assert path.read_bytes() == twin.read_bytes(), path.name


def test_solutions_get_full_points_and_untouched_exercises_none(tmp_path, level):
    for kind in ("solutions", "exercises"):
        for path in (ROOT / kind).glob("*.ipynb"):
            hand_in(tmp_path / "in", kind, path.stem, path.read_bytes())
    rows = graded(tmp_path / "in", tmp_path / "out", level)
    assert len(rows) == 2 * sum(len(e.tasks) for e in EXERCISES.values())
    for (student, _), row in rows.items():
        full = student == "solutions"
        assert (row["verdict"], row["points"]) == (("right", row["max"]) if full else ("missing", "0"))
        assert row["diagnosis"] == ("" if full else "not started")


def test_an_endless_loop_costs_its_own_task_and_nothing_else(tmp_path, level):
    hand_in(
        tmp_path / "in", "loop", "01_newton_1d", exercise("01_newton_1d", brackets="while True: pass", order=GOOD_ORDER)
    )
    rows = graded(tmp_path / "in", tmp_path / "out", level)
    assert rows["loop", "brackets"]["verdict"] == "timeout"
    assert "does a loop never end?" in rows["loop", "brackets"]["diagnosis"]
    assert rows["loop", "order"]["verdict"] == "right"


def test_an_endless_loop_in_a_cell_of_its_own_costs_that_cell(tmp_path, level, monkeypatch):
    hasty = replace(EXERCISES["01_newton_1d"], cell_seconds=2.0)
    monkeypatch.setitem(EXERCISES, "01_newton_1d", hasty)
    own = "import numpy as np\nwhile True:\n    pass"
    hand_in(tmp_path / "in", "loop", "01_newton_1d", exercise("01_newton_1d", own=own, order=GOOD_ORDER))
    rows = graded(tmp_path / "in", tmp_path / "out", level)
    assert rows["loop", "order"]["verdict"] == "right"
    assert "code cell 1 did not end in time (2 s of computing, 8 s by the clock)" in (
        tmp_path / "out/feedback/loop/01_newton_1d.html"
    ).read_text("utf-8")


def test_a_warning_on_stderr_informs_and_costs_nothing(tmp_path, level):
    own = "import warnings, sys\nwarnings.warn('this is only a warning')\nprint('and this an error?', file=sys.stderr)"
    hand_in(tmp_path / "in", "warned", "01_newton_1d", exercise("01_newton_1d", own=own, order=GOOD_ORDER))
    rows = graded(tmp_path / "in", tmp_path / "out", level)
    assert (rows["warned", "order"]["verdict"], rows["warned", "order"]["points"]) == ("right", "2")
    printed = tmp_path / "out/feedback/warned/01_newton_1d.txt"
    assert f'href="{printed.name}"' in printed.with_suffix(".html").read_text("utf-8")
    assert "this is only a warning" in printed.read_text("utf-8")
    assert "and this an error?" in printed.read_text("utf-8")


def test_a_cell_that_fails_does_not_take_other_tasks_down(tmp_path, level):
    own = "this is not Python"
    hand_in(
        tmp_path / "in",
        "typo",
        "01_newton_1d",
        exercise("01_newton_1d", own=own, order=GOOD_ORDER, brackets="return 1/0"),
    )
    rows = graded(tmp_path / "in", tmp_path / "out", level)
    assert rows["typo", "brackets"]["verdict"] == "error"
    assert rows["typo", "order"]["verdict"] == "right"


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"{", "not JSON"),
        ("café".encode("latin-1"), "not UTF-8"),
        (b"", "the file is empty"),
        (
            json.dumps({"cells": [{"cell_type": "code", "source": "print(1)"}], "metadata": {}}).encode(),
            "another course",
        ),
        (100 << 20, "has 100 MB"),
        ("link", "is a link"),
        ("folder", "is a folder"),
    ],
    ids=["not JSON", "not UTF-8", "empty", "another course", "100 MB", "link", "folder"],
)
def test_a_file_that_cannot_be_graded_gets_a_row_with_the_reason_and_harms_nobody(tmp_path, level, content, says):
    hand_in(tmp_path / "in", "neighbour", "01_newton_1d", exercise("01_newton_1d", order=GOOD_ORDER))
    bad = tmp_path / "in/bad/01_newton_1d.ipynb"
    bad.parent.mkdir()
    if content == "link":
        bad.symlink_to(tmp_path / "in/neighbour/01_newton_1d.ipynb")
    elif content == "folder":
        bad.mkdir()
    elif isinstance(content, int):
        with open(bad, "wb") as file:
            file.truncate(content)
    else:
        bad.write_bytes(content)
    rows = graded(tmp_path / "in", tmp_path / "out", level)
    assert all(says in rows["bad", t]["diagnosis"] for t in ("brackets", "newton_1d", "failures", "order"))
    assert rows["neighbour", "order"]["verdict"] == "right"


def test_nothing_that_a_student_handed_in_is_passed_over_in_silence(tmp_path, level):
    hand_in(tmp_path / "in", "renamed", "my best work", exercise("01_newton_1d", order=GOOD_ORDER))
    hand_in(tmp_path / "in", "other", "essay", b"{}")
    (tmp_path / "in/nothing").mkdir()
    (tmp_path / "in/linked").symlink_to(tmp_path / "in/renamed")
    rows = graded(tmp_path / "in", tmp_path / "out", level)
    assert rows["renamed", "order"]["verdict"] == "right"
    assert "no list of cells" in rows["other", ""]["diagnosis"]
    assert "handed in no notebook" in rows["nothing", ""]["diagnosis"]
    assert "is a link" in rows["linked", ""]["diagnosis"]


def test_a_zip_file_is_graded_like_the_folder_in_it(tmp_path, level):
    hand_in(tmp_path / "in", "zoé", "01_newton_1d", exercise("01_newton_1d", order=GOOD_ORDER))
    archive = Path(shutil.make_archive(str(tmp_path / "all"), "zip", tmp_path / "in"))
    assert graded(archive, tmp_path / "out", level) == graded(tmp_path / "in", tmp_path / "out2", level)


def test_a_dask_cluster_gives_the_same_bytes(tmp_path, level):
    distributed = pytest.importorskip("distributed")
    for student in ("a", "b", "c"):
        hand_in(tmp_path / "in", student, "01_newton_1d", exercise("01_newton_1d", order=GOOD_ORDER))
    graded(tmp_path / "in", tmp_path / "here", level)
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        graded(tmp_path / "in", tmp_path / "there", level, scheduler=cluster.scheduler_address)
    for path in ("grades.csv", "index.html", *(f"feedback/{student}/01_newton_1d.html" for student in "abc")):
        assert (tmp_path / "here" / path).read_bytes() == (tmp_path / "there" / path).read_bytes()


def test_a_scheduler_that_does_not_answer_is_refused(tmp_path):
    pytest.importorskip("distributed")
    hand_in(tmp_path / "in", "a", "01_newton_1d", b"")
    with pytest.raises(Refused, match="no Dask scheduler answers at nowhere"):
        grade_cohort(tmp_path / "in", tmp_path / "out", "none", SALT, scheduler="nowhere:1:2")


def test_the_journal_with_the_salt_is_the_instructors_alone(tmp_path):
    hand_in(tmp_path / "in", "a", "01_newton_1d", b"")
    grade_cohort(tmp_path / "in", tmp_path / "out", "none")
    assert (tmp_path / "out/journal.sqlite").stat().st_mode & 0o077 == 0


def test_an_output_among_the_submissions_is_refused(tmp_path):
    hand_in(tmp_path / "in", "a", "01_newton_1d", b"")
    for out in (tmp_path / "in", tmp_path / "in/a"):
        with pytest.raises(Refused, match="lies inside the submissions"):
            grade_cohort(tmp_path / "in", out, "none")


def test_an_empty_folder_is_refused(tmp_path):
    (empty := tmp_path / "in").mkdir()
    with pytest.raises(Refused, match=r"holds no <student>/<exercise>\.ipynb"):
        grade_cohort(empty, tmp_path / "out", "none", SALT)


SEARCH = """
import gc, glob, os, sys

DRANOC = {backwards!r}  # backwards, so that the search does not find itself

for path in {paths!r} + glob.glob("/proc/*/environ") + glob.glob("/proc/*/cmdline"):
    try:
        content = open(path, "rb").read().decode("utf-8", "replace")
    except OSError:
        continue
    if DRANOC in content[::-1]:
        print("LEAK file", path)

texts, frame = list(os.environ.values()), sys._getframe()
while frame:
    texts += [*frame.f_globals.values(), *frame.f_locals.values()]
    frame = frame.f_back
for thing in gc.get_objects():
    if type(thing) in (list, tuple):
        texts += thing
    elif type(thing) is dict:
        texts += thing.values()
if any(type(text) is str and DRANOC in text[::-1] for text in texts):
    print("LEAK memory")
print("searched")
"""


def searched(tmp_path, level, planted=""):
    """What a submission finds that looks for the salt, the journal and the executed solutions."""
    canary = "canary-in-the-coal-mine-4711"
    secrets = [tmp_path / "salt", tmp_path / "out/journal.sqlite", tmp_path / "solutions/01_newton_1d.ipynb"]
    for path in (secrets[0], secrets[2]):
        path.parent.mkdir(exist_ok=True)
        path.write_text(canary, encoding="utf-8")
    for folder in (tmp_path, *tmp_path.parents):  # nothing but the sandbox shall stand in the way
        if folder.stat().st_mode & 0o005 != 0o005:
            folder.chmod(folder.stat().st_mode | 0o005)
    own = planted + SEARCH.format(paths=[str(path) for path in secrets], backwards=canary[::-1])
    hand_in(tmp_path / "in", "spy", "01_newton_1d", exercise("01_newton_1d", own=own))
    grade_cohort(tmp_path / "in", tmp_path / "out", level, canary)
    return (tmp_path / "out/feedback/spy/01_newton_1d.txt").read_text("utf-8")


def test_salt_journal_and_solutions_cannot_be_read_from_inside(tmp_path, level):
    page = searched(tmp_path, level)
    assert "searched" in page
    assert "LEAK" not in page


def test_the_search_for_secrets_finds_them_where_nothing_is_confined(tmp_path):
    page = searched(
        tmp_path, "none", planted="planted = ['canary-in-the-coal-mine', '-4711']; planted = [''.join(planted)]\n"
    )
    assert page.count("LEAK file") >= 2
    assert "LEAK memory" in page


def test_only_the_modules_that_an_exercise_allows_can_be_imported(level):
    from autograder.judge import sources
    from autograder.sandbox import Sandbox

    with Sandbox(level) as sandbox:
        with sandbox.worker(modules=sources(("newton",))) as worker:
            assert worker.run("from mechlib.newton import newton_1d", seconds=20).raised is None
            refused = worker.run("import mechlib.basins", seconds=20).raised
            assert refused.is_a("ImportError")
            assert "mechlib.newton" in refused.message
            assert worker.run("import autograder.checks", seconds=20).raised.is_a("ImportError")
            assert worker.run("import autograder.spec", seconds=20).raised.is_a("ImportError")
        with sandbox.worker(modules=sources(())) as worker:
            assert worker.run("from mechlib.newton import newton_1d", seconds=20).raised.is_a("ImportError")
