"""Late reality: what comes in at night is graded for what is there, and whatever is odd about it is said."""

import html
import json
import os
import shutil
import zipfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from judging import answering
from typer.testing import CliRunner

from autograder import submissions
from autograder.checks import EXERCISES
from autograder.cli import app
from autograder.cohort import grade_cohort
from autograder.ingest import Refused
from autograder.isolation import survey
from autograder.judge import assess, drawn, undefined
from autograder.oddities import Text, look
from autograder.outcome import Raised
from autograder.sandbox import CONFINED
from autograder.spec import PUBLIC_SALT
from autograder.submissions import contents, find, identify, unpacked

ROOT = Path(__file__).parents[1]
NAME = "01_newton_1d"
SOLVED = json.loads((ROOT / "solutions" / f"{NAME}.ipynb").read_text("utf-8"))
GAP = "def f(x):\n    raise NotImplementedError\n"
F = "def f(x):\n    return x\n"


@pytest.mark.parametrize(
    ("cells", "notes"),
    [
        ([F], []),
        (["", F, " \n", "# Your trial:"], []),
        ([GAP, F], []),
        ([F, GAP], []),
        (["%matplotlib inline\n" + F, "f?", "!ls", "x = !ls", "%%bash\ndef f(", "await f(1)"], []),
        ([F, F], ["f is defined more than once, in code cells 1 and 2: the last one that runs counts"]),
        ([F, "", F, "%%time\nf = abs"], ["f is defined more than once, in code cells 1, 3 and 4: the last one that"]),
        ([F + F], ["f is defined more than once, in code cell 1: the last one that runs counts"]),
        (["if True:\n    def f(x): pass\nelse:\n    f = 1"], []),
        (["def F_(x): return x"], ["no cell defines f, but code cell 1 defines F_: is that it?"]),
        ([GAP, "def F(x): return x"], ["no cell defines f, but code cell 2 defines F: is that it?"]),
        (["def entirely_different(): pass"], []),
        (
            ["class A:\n    def f(self): pass"],
            ["code cell 1 defines f inside of something else: move it to the margin"],
        ),
        (["def f(:"], []),
        (["x = y", "y = 1", F], ["code cell 1 uses y, which only code cell 2 defines: cells run from top to bottom"]),
        (
            ["np.ones(plt)", F, "import numpy as np, matplotlib.pyplot as plt"],
            ["code cell 1 uses np and plt, which only"],
        ),
        (["def g(): return np", "import numpy as np", F], []),
        (["from numpy import *\nprint(pi)", "pi = 3", F], []),
        (["%pylab inline\nx = pi", "pi = 3", F], []),
        (["print(_, display, In)", "_ = display = In = 1", F], []),
        ([F, "from google.colab import drive"], ["code cell 2 imports google.colab, which only Colab has"]),
        (["-" * 40_000 + "1", "(" * 40_000, F], []),
        ([" " * 30_000 + "x", "\n" * 30_000 + "(", "a " * 15_000 + "(", F], []),
        (["x = 1\n" * 50_000], ["the notebook holds more than 100000 characters of code, and was not looked at"]),
    ],
)
def test_what_is_odd_about_cells_is_said_and_nothing_else(cells, notes):
    found = look(cells, [], ["f"])
    assert len(found) == len(notes), found
    assert all(said.startswith(note) for said, note in zip(found, notes, strict=True)), found


def test_an_answer_in_a_cell_that_is_no_code_is_pointed_at_unless_it_is_in_a_code_cell_too():
    text = Text(7, "Markdown", "My answer:\n" + F)
    assert look([GAP], [text], ["f"]) == ("cell 7 is Markdown and holds def f: make it a code cell",)
    assert look([F], [text], ["f"]) == ()


def solved(**changes):
    return json.dumps({**SOLVED, **changes}).encode()


def bare(*names):
    """The cells that define these functions, in a notebook that says nothing of itself."""
    sources = ["".join(cell["source"]) for cell in SOLVED["cells"] if cell["cell_type"] == "code"]
    cells = [source for source in sources if source.startswith(tuple(f"def {name}(" for name in names))]
    return json.dumps({"cells": [{"cell_type": "code", "source": source} for source in cells]}).encode()


def test_every_solution_is_without_oddities():
    for path in (*ROOT.glob("solutions/*.ipynb"), *ROOT.glob("exercises/*.ipynb")):
        assert identify(path)[1].notes == ()


@pytest.mark.parametrize("exercise", EXERCISES)
def test_a_renamed_notebook_without_metadata_is_known_by_what_it_defines(tmp_path, exercise):
    notebook = json.loads((ROOT / "solutions" / f"{exercise}.ipynb").read_text("utf-8"))
    (tmp_path / "Abgabe.ipynb").write_text(json.dumps({"cells": notebook["cells"]}), encoding="utf-8")
    found, read = identify(tmp_path / "Abgabe.ipynb")
    assert found.name == exercise
    assert read.notes == (f"the notebook does not say which exercise it is: taken for {exercise} by its functions",)


def put(folder, files):
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)


GOOD, BROKEN, UNTOUCHED = solved(), b"{", (ROOT / "exercises" / f"{NAME}.ipynb").read_bytes()
OTHER = (ROOT / "solutions" / "02_newton_nd.ipynb").read_bytes()

# What lies in the folder; then by student and exercise what is said, with the reason first where nothing is graded.
FOLDERS = {
    "as asked": ({f"zoe/{NAME}.ipynb": GOOD}, {("zoe", NAME): []}),
    "by metadata": (
        {"zoe/01_newton_1d_Muster.ipynb": GOOD, "zoe/ex.ipynb": OTHER},
        {
            ("zoe", NAME): ["the notebook was handed in as 01_newton_1d_Muster.ipynb"],
            ("zoe", "02_newton_nd"): ["the notebook was handed in as ex.ipynb"],
        },
    ),
    "a browser's copy": (
        {"zoe/01_newton_1d (1).ipynb": GOOD},
        {("zoe", NAME): ["the notebook was handed in as 01_newton_1d (1).ipynb"]},
    ),
    "a second": (
        {f"zoe/{NAME}.ipynb": GOOD, "zoe/01_newton_1d-Copy1.ipynb": UNTOUCHED},
        {("zoe", NAME): ["01_newton_1d-Copy1.ipynb was passed over (a second notebook): 01_newton_1d.ipynb counts"]},
    ),
    "a second that can be read": (
        {f"zoe/{NAME}.ipynb": BROKEN, "zoe/01_newton_1d-Copy1.ipynb": GOOD},
        {
            ("zoe", NAME): [
                "the notebook was handed in as 01_newton_1d-Copy1.ipynb",
                "01_newton_1d.ipynb was passed over (the file is not JSON",
            ]
        },
    ),
    "deeper": (
        {f"zoe/Abgabe/Woche 1/{NAME}.ipynb": GOOD},
        {("zoe", NAME): ["the notebook was handed in as Abgabe/Woche 1/01_newton_1d.ipynb"]},
    ),
    "two of a name": (
        {f"zoe/{NAME}.ipynb": GOOD, f"zoe/old/{NAME}.ipynb": GOOD},
        {("zoe", NAME): ["old/01_newton_1d.ipynb was passed over"]},
    ),
    "litter": (
        {
            f"zoe/{NAME}.ipynb": GOOD,
            f"zoe/.ipynb_checkpoints/{NAME}-checkpoint.ipynb": UNTOUCHED,
            f"zoe/._{NAME}.ipynb": b"\0\5\26\7",
            "zoe/.DS_Store": b"",
            f"__MACOSX/zoe/._{NAME}.ipynb": b"\0\5\26\7",
            ".DS_Store": b"",
            "grades.xlsx": b"",
        },
        {("zoe", NAME): []},
    ),
    "capitals": ({f"zoe/{NAME}.IPYNB": GOOD}, {("zoe", NAME): ["the notebook was handed in as 01_newton_1d.IPYNB"]}),
    "no notebook": (
        {"zoe/01_newton_1d.py": b"", "zoe/01_newton_1d.html": b"", "bo/x.ipynb.txt": b""},
        {
            ("zoe", ""): [
                "zoe handed in no notebook, but 01_newton_1d.html, 01_newton_1d.py: the .ipynb file is needed"
            ],
            ("bo", ""): ["bo handed in no notebook, but x.ipynb.txt: the .ipynb file is needed"],
        },
    ),
    "archives": (
        {"zoe/work.zip": b"PK", f"bo/{NAME}.ipynb": GOOD, "bo/work.zip": b"PK", "eve.zip": b"PK"},
        {
            ("zoe", ""): ["zoe handed in no notebook, but work.zip: the .ipynb file is needed"],
            ("bo", NAME): ["work.zip was not opened"],
            ("eve.zip", ""): ["eve.zip is an archive: unpack it first"],
        },
    ),
    "a lone notebook": (
        {f"zoe/{NAME}.ipynb": GOOD, f"{NAME}.ipynb": GOOD},
        {("zoe", NAME): [], (f"{NAME}.ipynb", ""): ["01_newton_1d.ipynb lies in no student's folder"]},
    ),
    "Moodle's folders": (
        {f"Zoé Müller_4711_assignsubmission_file_/{NAME}.ipynb": GOOD},
        {("Zoé Müller_4711_assignsubmission_file_", NAME): []},
    ),
    "Moodle's files": (
        {f"Zoé Müller_4711_assignsubmission_file_{NAME}.ipynb": GOOD, "Bo_12_assignsubmission_file_my.ipynb": OTHER},
        {
            ("Zoé Müller_4711_assignsubmission_file_", NAME): [],
            ("Bo_12_assignsubmission_file_", "02_newton_nd"): ["the notebook was handed in as my.ipynb"],
        },
    ),
    "a folder around all": (
        {f"Blatt 1/zoe/{NAME}.ipynb": GOOD, f"Blatt 1/bo/{NAME}.ipynb": GOOD, "__MACOSX/x": b""},
        {("zoe", NAME): [], ("bo", NAME): []},
    ),
    "letters of two kinds": (
        {f"zo\u0065\u0301/{NAME}.ipynb": GOOD, f"bj\u00f6rn/{NAME}.ipynb": GOOD},
        {("zo\u00e9", NAME): [], ("bj\u00f6rn", NAME): []},
    ),
    "strays of one name": (
        {"zoe/essay.ipynb": BROKEN, "zoe/old/essay.ipynb": BROKEN},
        {("zoe", "essay"): ["the file is not JSON"], ("zoe", "old-essay"): ["the file is not JSON"]},
    ),
}


def told(found):
    """By student and exercise, what is said of a submission."""
    said = {}
    for submission in found:
        c = contents(submission)
        said[submission.student, submission.exercise] = [*filter(None, (c.refused,)), *c.notes]
    assert len(said) == len(found)  # no two of them share a row
    return said


@pytest.mark.parametrize(("files", "expected"), FOLDERS.values(), ids=FOLDERS)
@pytest.mark.parametrize("packed", [False, True], ids=["folder", "zip"])
def test_whatever_was_handed_in_is_found_and_said(tmp_path, files, expected, packed):
    folder = tmp_path / "in"
    put(folder, files)
    if packed:
        folder = Path(shutil.make_archive(str(tmp_path / "all"), "zip", folder))
    with unpacked(folder) as here:
        said = told(find(here))
    assert said.keys() == expected.keys()
    for key, sentences in said.items():
        assert len(sentences) == len(expected[key]), sentences
        assert all(a.startswith(b) for a, b in zip(sentences, expected[key], strict=True)), sentences


def test_in_a_zip_of_zips_every_students_own_is_unpacked_and_a_bad_one_is_theirs_alone(tmp_path):
    for student in ("bo", "zoe"):
        put(tmp_path / student, {f"{NAME}.ipynb": GOOD})
        shutil.make_archive(str(tmp_path / "all" / student), "zip", tmp_path / student)
    put(tmp_path / "all", {"eve.zip": b"no zip", "kim/x.zip": (tmp_path / "all/bo.zip").read_bytes()})
    with zipfile.ZipFile(tmp_path / "all/max.zip", "w") as archive:
        archive.writestr("../zoe/02_newton_nd.ipynb", OTHER)
    with unpacked(Path(shutil.make_archive(str(tmp_path / "cohort"), "zip", tmp_path / "all"))) as here:
        assert told(find(here)) == {
            ("bo", NAME): [],
            ("zoe", NAME): [],
            ("kim", NAME): [f"the notebook was handed in as x/{NAME}.ipynb"],
            ("eve.zip", ""): ["eve.zip is an archive: unpack it first"],
            ("max.zip", ""): ["max.zip is an archive: unpack it first"],
        }


def test_nothing_is_written_where_the_submissions_lie(tmp_path):
    folder = tmp_path / "in"
    put(folder, {f"zoe/{NAME}.ipynb": GOOD, "zoe/work.zip": b"PK", "bo/x.ipynb": BROKEN})
    every = [folder, *sorted(folder.rglob("*"))]
    before = [(path, path.stat().st_mtime_ns) for path in every]
    for path in reversed(every):
        path.chmod(0o555 if path.is_dir() else 0o444)
    grade_cohort(folder, tmp_path / "out", "none", PUBLIC_SALT)
    assert [(path, path.stat().st_mtime_ns) for path in [folder, *sorted(folder.rglob("*"))]] == before
    for path in every:  # or nobody could remove them
        path.chmod(0o755)


def test_check_says_what_is_odd(tmp_path):
    put(tmp_path, {f"{NAME}.ipynb": b"\xef\xbb\xbf" + UNTOUCHED})
    said = CliRunner().invoke(app, ["check", str(tmp_path / f"{NAME}.ipynb"), "--isolation", "none"]).output
    assert "Note: the file begins with a byte order mark, which was passed over" in said


@pytest.mark.skipif(os.name != "posix", reason="names are text there")
def test_names_that_are_no_text_or_would_lead_elsewhere_are_made_readable_and_stay_apart(tmp_path):
    names = [b"zo\xe9", b"zo\xe8", "\u200f..".encode(), "a\u202eb".encode(), "o\u0308".encode(), "\u00f6".encode()]
    for name in names:
        try:
            put(
                Path(os.fsdecode(os.fsencode(tmp_path) + b"/" + name)),
                {f"{NAME}.ipynb": GOOD, "e\u200f.ipynb": BROKEN},
            )
        except OSError:
            pytest.skip("this file system takes text only")
    found = find(tmp_path)
    assert len({(s.student, s.exercise) for s in found}) == len(found) == 2 * len(names)
    for s in found:
        for name in (s.student, s.exercise):
            assert name.encode().decode().isprintable()
            assert Path(name).name == name
            assert name not in (".", "..")


def test_a_folder_that_cannot_be_opened_is_said(tmp_path, monkeypatch):
    put(tmp_path, {f"zoe/{NAME}.ipynb": GOOD, "zoe/closed/x.txt": b""})
    scan = os.scandir

    def closed(path):
        if str(path).endswith("closed"):
            raise PermissionError(13, "Permission denied", str(path))
        return scan(path)

    monkeypatch.setattr(os, "scandir", closed)
    assert told(find(tmp_path))["zoe", "closed"] == ["closed cannot be opened"]


def test_a_file_that_cannot_be_read_is_refused_in_a_sentence(tmp_path, monkeypatch):
    put(tmp_path, {f"zoe/{NAME}.ipynb": GOOD})

    def closed(*arguments):
        raise PermissionError(13, "Permission denied")

    (submission,) = find(tmp_path)
    monkeypatch.setattr(os, "open", closed)
    assert contents(submission).refused == "01_newton_1d.ipynb cannot be read: Permission denied"


def test_a_notebook_cannot_say_more_oddities_than_anyone_reads(tmp_path):
    cells = [{"cell_type": "code", "source": f"x{i} = y{i}"} for i in range(50)]
    cells += [{"cell_type": "code", "source": f"y{i} = 1"} for i in range(50)]
    put(tmp_path, {f"{NAME}.ipynb": solved(cells=cells)})
    notes = identify(tmp_path / f"{NAME}.ipynb")[1].notes
    assert len(notes) == submissions.MOST_NOTES + 1
    assert notes[-1] == "and 30 more of this kind"


def test_a_notebook_of_another_course_is_refused(tmp_path):
    put(tmp_path, {"x.ipynb": bare()})
    with pytest.raises(Refused, match="is no exercise of this course"):
        identify(tmp_path / "x.ipynb")


SOURCES = ["".join(cell["source"]) for cell in SOLVED["cells"] if cell["cell_type"] == "code"]
FUNCTIONS = sorted({task.function for task in EXERCISES[NAME].tasks})
NEEDED = [s for s in SOURCES if s.startswith(("import ", "class "))]  # whatever the answers lean on
WRITTEN = {name: next(s for s in SOURCES if s.startswith(f"def {name}(")) for name in FUNCTIONS}


@st.composite
def nights(draw):
    """The cells of the solved notebook in any order, some twice, some lost, some under another name."""
    cells = draw(st.permutations(SOURCES + draw(st.lists(st.sampled_from(SOURCES), max_size=4))))
    renamed = draw(st.sets(st.sampled_from(FUNCTIONS), max_size=2))
    for name in renamed:
        cells = [cell.replace(f"def {name}(", f"def {name}_1(") for cell in cells]
    return cells[draw(st.integers(0, 8)) :]


def in_this_process(cells):
    """How the grader reaches what the cells define, without a worker: one after the other, each for itself."""
    namespace = {"__name__": "__main__"}
    for cell in cells:
        if "def " in cell or "import " in cell or "class " in cell:
            try:
                exec(compile(cell, "cell", "exec"), namespace)
            except NameError:
                continue

    def call(function, args, kwargs, seconds):
        if function not in namespace:
            return Raised("NameError", (), undefined(function))
        return answering(namespace[function])(function, args, kwargs, seconds)

    return call


@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(nights())
def test_whatever_happens_to_the_cells_what_is_there_keeps_its_points(tmp_path, cells):
    listed = [{"cell_type": "code", "source": source} for source in cells]
    put(tmp_path, {f"{NAME}.ipynb": solved(cells=listed)})
    exercise, notebook = identify(tmp_path / f"{NAME}.ipynb")
    call = in_this_process(notebook.cells)
    for task in exercise.tasks:
        name = task.function
        judged = assess(drawn(task, PUBLIC_SALT, ""), call, public=True)
        if WRITTEN[name] not in cells:
            assert judged.why == f"not started: no cell defines {name}"
            other = any(f"def {name}_1(" in cell for cell in cells)
            assert other == any(f"no cell defines {name}, but" in note for note in notebook.notes)
        elif set(NEEDED) <= set(cells):
            assert judged.points == task.points, cells
        twice = cells.count(WRITTEN[name]) > 1
        assert twice == any(f"{name} is defined more than once" in note for note in notebook.notes)


@pytest.mark.parametrize("level", CONFINED)
def test_a_notebook_in_the_wrong_order_is_graded_in_a_worker_for_what_is_there(tmp_path, level):
    if not survey()[level].available:
        pytest.skip(f"isolation level {level}: {survey()[level].reason}")
    trial = "print(brackets(np.sin, 3.0, 4.0, 2))"
    renamed = WRITTEN["order"].replace("def order(", "def Order(")
    cells = [trial, WRITTEN["newton_1d"], *NEEDED, WRITTEN["brackets"], WRITTEN["newton_1d"], renamed]
    put(tmp_path, {"in/zoe/mine.ipynb": solved(cells=[{"cell_type": "code", "source": cell} for cell in cells])})
    ((student, found),) = grade_cohort(tmp_path / "in", tmp_path / "out", level, PUBLIC_SALT)
    assert student == "zoe"
    assert {a.task: a.verdict for a in found.assessments} == {
        "brackets": "right",
        "newton_1d": "right",
        "failures": "right",
        "order": "missing",
    }
    first = len(NEEDED) + 3
    expected = (
        "the notebook was handed in as mine.ipynb",
        f"newton_1d is defined more than once, in code cells 2 and {first + 1}: the last one that runs counts",
        f"no cell defines order, but code cell {first + 2} defines Order: is that it?",
        "code cell 1 uses np, which only code cell 3 defines: cells run from top to bottom",
        f"code cell 1 uses brackets, which only code cell {first} defines: cells run from top to bottom",
        "code cell 1 stopped with NameError: name 'brackets' is not defined",
    )
    assert set(expected) == set(found.notes)
    page = (tmp_path / "out/feedback/zoe" / f"{NAME}.html").read_text("utf-8")
    assert all(html.escape(note)[:40] in page for note in expected)


def test_what_comes_later_is_said_though_the_notebook_that_counts_stayed_as_it_was(tmp_path):
    put(tmp_path, {f"in/zoe/{NAME}.ipynb": GOOD})
    notes = []
    for later in ({}, {"in/zoe/mine.ipynb": UNTOUCHED}):
        put(tmp_path, later)
        ((_, found),) = grade_cohort(tmp_path / "in", tmp_path / "out", "none", PUBLIC_SALT)
        notes.append(found.notes)
    assert notes == [(), (f"mine.ipynb was passed over (a second notebook): {NAME}.ipynb counts",)]
