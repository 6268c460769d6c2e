"""A file nobody has vetted gives cells, or one sentence; never anything else, and never late."""

import io
import json
import os
import stat
import time
import zipfile

import pytest
from hypothesis import given
from hypothesis import strategies as st

from autograder.ingest import MAX_BYTES, Notebook, Refused, parse, read, unzip


def notebook(*cells, **metadata):
    code = [{"cell_type": "code", "source": source, "metadata": {}, "outputs": []} for source in cells]
    return json.dumps({"cells": code, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}).encode()


JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.text(),
    lambda children: (
        st.lists(children)
        | st.dictionaries(st.sampled_from(["cells", "source", "cell_type", "metadata", "x"]), children)
    ),
    max_leaves=20,
)


@given(st.binary() | JSON.map(lambda value: json.dumps(value).encode()))
def test_any_bytes_give_cells_or_one_sentence(content):
    try:
        found = parse(content)
    except Refused as refusal:
        assert "\n" not in str(refusal)
    else:
        assert isinstance(found, Notebook)
        assert all(isinstance(cell, str) for cell in found.cells)


@given(st.lists(st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"))))
def test_the_text_of_every_code_cell_comes_back_with_line_ends_as_python_reads_them(cells):
    assert list(parse(notebook(*cells)).cells) == [io.StringIO(cell, newline=None).read() for cell in cells]


def test_lines_byte_order_mark_and_missing_metadata_are_no_obstacle():
    plain = {"cells": [{"cell_type": "code", "source": ["x = 1\n", "y = 2"]}, {"cell_type": "markdown", "source": 3}]}
    assert parse(b"\xef\xbb\xbf" + json.dumps(plain).encode()).cells == ("x = 1\ny = 2",)


SOUND = json.loads(notebook("x = 1\ny = 2", "z = 3"))
FORMAT_3 = {
    "nbformat": 3,
    "metadata": {"name": ""},
    "worksheets": [
        {"cells": [{"cell_type": "code", "input": ["x = 1\n", "y = 2"]}, {"cell_type": "heading", "source": "h"}]},
        {"cells": [{"cell_type": "code", "input": "z = 3"}, {"cell_type": "markdown", "source": "m"}]},
    ],
}
COLAB = {"colab": {"provenance": []}, "widgets": {"application/vnd.jupyter.widget-state+json": {"a": {"state": {}}}}}


def changed(**cell):
    return {**SOUND, "cells": [{**c, **cell} for c in SOUND["cells"]]}


@pytest.mark.parametrize(
    ("content", "note"),
    [
        (json.dumps(SOUND).encode(), None),
        (b"\xef\xbb\xbf" + json.dumps(SOUND).encode(), "byte order mark"),
        (json.dumps(SOUND, indent=1).replace("\n", "\r\n").encode(), None),
        (json.dumps(SOUND).replace("\\n", "\\r\\n").encode(), "Windows line ends"),
        (json.dumps(FORMAT_3).encode(), "old format 3"),
        (json.dumps({"cells": SOUND["cells"]}).encode(), None),
        (json.dumps({**SOUND, "metadata": None, "nbformat": "4"}).encode(), None),
        (json.dumps({**changed(metadata={"id": "x", "colab": {"height": 4}}), "metadata": COLAB}).encode(), None),
        (json.dumps(changed(metadata={"vscode": {"languageId": "python"}}, execution_count="7")).encode(), None),
        (json.dumps(changed(id=7, outputs=None)).encode(), None),
    ],
    ids=["sound", "BOM", "lines of the file", "lines of a cell", "3", "bare", "torn", "Colab", "VS Code", "odd ids"],
)
def test_the_cells_of_a_notebook_from_anywhere_are_read_and_what_is_odd_is_said(content, note):
    found = parse(content)
    assert found.cells == ("x = 1\ny = 2", "z = 3")
    assert [note in said for said in found.notes] == ([True] if note else [])


def test_the_exercise_is_read_from_the_metadata_if_it_is_there():
    assert parse(notebook(mechanisms={"exercise": "01_newton_1d"})).exercise == "01_newton_1d"
    assert parse(notebook(mechanisms=["01_newton_1d"])).exercise is None


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "the file is empty"),
        (b"\n \n", "the file is empty"),
        (b"{", "not JSON"),
        (notebook("x").replace(b"}]", b"},]"), "not JSON"),
        (notebook("x").replace(b'"source"', b"'source'"), "not JSON"),
        ("café".encode("latin-1"), "not UTF-8 text (byte 3)"),
        (b"[" * 100_000, "nested too deeply"),
        (b'{"cells": ' + b"9" * 10_000 + b"}", "no list of cells"),
        (b"[]", "no list of cells"),
        (b'{"cells": 3}', "no list of cells"),
        (notebook(*["x"] * 3000), "3000 cells"),
        (notebook("x" * (2 << 20)), "more than 1 MB of code"),
        (notebook("a\0b"), "cell 1 holds no readable text"),
        (b'{"cells": [{"cell_type": "code", "source": "\\ud800"}]}', "cell 1 holds no readable text"),
        (b'{"cells": [{"cell_type": "code", "source": 7}]}', "cell 1 holds no readable text"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_is_no_notebook_is_refused_in_a_moment(content, says):
    begin = time.perf_counter()
    with pytest.raises(Refused) as refusal:
        parse(content)
    assert says in str(refusal.value)
    assert time.perf_counter() - begin < 5  # loose: that nothing is endless, not how fast it is


def test_a_file_that_is_missing_a_folder_a_link_or_a_pipe_is_refused(tmp_path):
    (tmp_path / "folder.ipynb").mkdir()
    (tmp_path / "real.ipynb").write_bytes(notebook())
    says = {"absent": "does not exist", "folder": "is a folder"}
    if hasattr(os, "mkfifo"):
        (tmp_path / "link.ipynb").symlink_to(tmp_path / "real.ipynb")
        os.mkfifo(tmp_path / "pipe.ipynb")
        says |= {"link": "is a link", "pipe": "not a regular file"}
    for name, sentence in says.items():
        with pytest.raises(Refused, match=sentence):
            read(tmp_path / f"{name}.ipynb")
    assert read(tmp_path / "real.ipynb") == notebook()


def test_a_hundred_megabytes_are_refused_without_being_read(tmp_path):
    large = tmp_path / "large.ipynb"
    with open(large, "wb") as file:
        file.truncate(100 << 20)
    with pytest.raises(Refused, match=f"has 100 MB, and {MAX_BYTES >> 20} MB is the limit"):
        read(large)


def zipped(tmp_path, *entries):
    archive = tmp_path / "cohort.zip"
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
        for name, content, mode in entries:
            entry = zipfile.ZipInfo(name)
            entry.external_attr = mode << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            file.writestr(entry, content)
    return archive


@pytest.mark.parametrize("name", ["zoé/01_newton_1d.ipynb", "zo\u0065\u0301/01_newton_1d.ipynb", "a b/c/Größe.ipynb"])
def test_an_archive_is_unpacked_as_it_was_packed(tmp_path, name):
    unzip(zipped(tmp_path, (name, b"{}", 0o644)), tmp_path / "out")
    assert (tmp_path / "out" / name).read_bytes() == b"{}"


class Plain(zipfile.ZipInfo):
    """An entry whose name is packed as these bytes, and says nothing of an encoding."""

    def _encodeFilenameFlags(self):
        return self.filename.encode("cp437"), self.flag_bits


@pytest.mark.parametrize(
    ("packed", "name"),
    [
        (b"zo\xc3\xa9\\x.ipynb", "zoé/x.ipynb"),
        (b"zo\x82/x.ipynb", "zoé/x.ipynb"),
        (b"a\\b\\x.ipynb", "a/b/x.ipynb"),
    ],
    ids=["UTF-8 unsaid", "code page 437", "backslashes"],
)
def test_names_from_windows_and_macos_are_understood(tmp_path, packed, name):
    with zipfile.ZipFile(tmp_path / "cohort.zip", "w") as file:
        file.writestr(Plain(packed.decode("cp437")), b"{}")
    unzip(tmp_path / "cohort.zip", tmp_path / "out")
    assert [p.relative_to(tmp_path / "out").as_posix() for p in (tmp_path / "out").rglob("*.ipynb")] == [name]


def test_a_folder_without_files_is_unpacked_and_litter_is_not(tmp_path):
    litter = ["__MACOSX/a/._x.ipynb", "a/.DS_Store", "a/.ipynb_checkpoints/x-checkpoint.ipynb"]
    entries = [("a/x.ipynb", b"", 0), ("b/", b"", 0), *((name, b"", 0) for name in litter)]
    unzip(zipped(tmp_path, *entries), tmp_path / "out")
    out = tmp_path / "out"
    assert sorted(path.relative_to(out).as_posix() for path in out.rglob("*")) == ["a", "a/x.ipynb", "b"]


@pytest.mark.parametrize(
    ("entries", "says"),
    [
        ([("../out.ipynb", b"", 0)], "not safe"),
        ([("/etc/out.ipynb", b"", 0)], "not safe"),
        ([("a\\..\\out.ipynb", b"", 0)], "not safe"),
        ([("a//out.ipynb", b"", 0)], "not safe"),
        ([("C:out.ipynb", b"", 0)], "not safe"),
        ([("a/link.ipynb", b"/etc/passwd", stat.S_IFLNK | 0o777)], "not a regular file"),
        ([("A/x.ipynb", b"", 0), ("a/x.ipynb", b"", 0)], "two files of one name"),
        ([("a/bomb.ipynb", bytes(20 << 20), 0)], "times its size"),
    ],
    ids=["up", "absolute", "backslash", "empty part", "drive", "link", "same name", "bomb"],
)
def test_a_hostile_archive_is_refused_and_writes_nothing_outside(tmp_path, entries, says):
    inside = tmp_path / "inside"
    inside.mkdir()
    with pytest.raises(Refused, match=says):
        unzip(zipped(tmp_path, *entries), inside / "out")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["cohort.zip", "inside"]


def test_what_is_no_archive_is_refused(tmp_path):
    (tmp_path / "cohort.zip").write_bytes(b"not a zip")
    with pytest.raises(Refused, match=r"cohort\.zip cannot be unpacked"):
        unzip(tmp_path / "cohort.zip", tmp_path / "out")
