"""A file nobody has vetted becomes a list of code cells, or one clear refusal.

It reads the cells' text and the name of the exercise, and nothing else. The usual reader is not used here: it follows
links, waits on pipes, loses the code of a notebook without a version, and takes seconds over a large one.
"""

import json
import os
import re
import stat
import unicodedata
import zipfile
from codecs import BOM_UTF8
from dataclasses import dataclass
from pathlib import Path

from autograder.oddities import Text

MAX_BYTES, MAX_CELLS, MAX_CODE = 10 << 20, 2000, 1 << 20
SAYS_UTF8 = 0x800
LITTER = {"__MACOSX", ".DS_Store", ".ipynb_checkpoints"}  # of systems and programs: nobody handed it in
LINE_END = re.compile("\r\n?")
MAX_FILES, MAX_UNZIPPED, MAX_RATIO = 20_000, 2 << 30, 200


class Refused(Exception):
    """The file cannot be graded; the message is one sentence that says why."""


@dataclass(frozen=True)
class Notebook:
    """What is read of a submission.

    Attributes
    ----------
    cells : the text of the code cells, in order.
    exercise : the exercise that the notebook says it is, or None.
    texts : the other cells.
    notes : what was odd, one sentence each.
    """

    cells: tuple[str, ...]
    exercise: str | None
    texts: tuple[Text, ...] = ()
    notes: tuple[str, ...] = ()


def read(path: Path) -> bytes:
    """The bytes of a regular file of sensible size; never what a link or a pipe stands for.

    Raises
    ------
    Refused
        If it is missing, unreadable, a link, a folder or a device, or too large.
    """
    try:
        kind = os.lstat(path).st_mode
        if stat.S_ISLNK(kind):
            raise Refused(f"{path.name} is a link: hand in the file itself")
        if stat.S_ISDIR(kind):
            raise Refused(f"{path.name} is a folder, and not a notebook")
        if not stat.S_ISREG(kind):
            raise Refused(f"{path.name} is not a regular file")
        flags = os.O_RDONLY | getattr(os, "O_BINARY", 0) | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
        with os.fdopen(os.open(path, flags), "rb") as file:
            content = file.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise Refused(f"{path} does not exist") from None
    except OSError as error:
        raise Refused(f"{path.name} cannot be read: {error.strerror}") from None
    if len(content) > MAX_BYTES:
        size = os.lstat(path).st_size
        raise Refused(
            f"{path.name} has {size / 2**20:.0f} MB, and {MAX_BYTES >> 20} MB is the limit: clear its outputs"
        )
    return content


def parse(content: bytes) -> Notebook:
    """The code cells of a notebook.

    Raises
    ------
    Refused
        If it is empty, not UTF-8, not JSON, no notebook, or holds more than a notebook of the course ever does.
    """
    if not content.strip():
        raise Refused("the file is empty")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise Refused(f"the file is not UTF-8 text (byte {error.start}): save it as .ipynb from Jupyter") from None
    try:
        notebook = json.loads(text, parse_int=float, parse_constant=lambda _: None)
    except RecursionError:
        raise Refused("the file is nested too deeply for a notebook") from None
    except ValueError as error:
        raise Refused(f"the file is not JSON, so it is no notebook ({str(error)[:80]})") from None
    cells = _listed(notebook)
    if not isinstance(cells, list):
        raise Refused("the file holds no list of cells, so it is no notebook")
    if len(cells) > MAX_CELLS:
        raise Refused(f"the notebook has {len(cells)} cells, and {MAX_CELLS} is the limit")
    code, texts = [], []
    for number, cell in enumerate(cells, 1):
        kind = cell.get("cell_type") if isinstance(cell, dict) else None
        if kind == "code":
            code.append(_source(number, cell))
        elif kind in ("markdown", "raw") and (text := _text(cell)) is not None:
            texts.append(Text(number, kind.replace("markdown", "Markdown"), text))
    if sum(map(len, code)) > MAX_CODE:
        raise Refused(f"the notebook holds more than {MAX_CODE >> 20} MB of code")
    odd = {
        "the file begins with a byte order mark, which was passed over": content.startswith(BOM_UTF8),
        "the notebook is of the old format 3, and was read all the same": "cells" not in notebook,
        "there are Windows line ends in the cells, and they change nothing": any("\r" in source for source in code),
    }
    return Notebook(
        tuple(LINE_END.sub("\n", source) for source in code),
        _exercise(notebook.get("metadata")),
        tuple(texts),
        tuple(note for note, applies in odd.items() if applies),
    )


def _listed(notebook) -> list | None:
    """The cells, which format 3 kept in worksheets."""
    if not isinstance(notebook, dict):
        return None
    sheets = notebook.get("worksheets")
    if "cells" in notebook or not isinstance(sheets, list):
        return notebook.get("cells")
    found = [sheet.get("cells") if isinstance(sheet, dict) else None for sheet in sheets]
    return [cell for cells in found for cell in cells] if all(isinstance(cells, list) for cells in found) else None


def _text(cell: dict) -> str | None:
    source = cell.get("source", cell.get("input", ""))
    if isinstance(source, list) and all(isinstance(line, str) for line in source):
        source = "".join(source)
    readable = isinstance(source, str) and "\0" not in source and not any("\ud800" <= c <= "\udfff" for c in source)
    return source if readable else None


def _source(number: int, cell: dict) -> str:
    source = _text(cell)
    if source is None:
        raise Refused(f"cell {number} holds no readable text")
    return source


def _exercise(metadata) -> str | None:
    ours = metadata.get("mechanisms") if isinstance(metadata, dict) else None
    name = ours.get("exercise") if isinstance(ours, dict) else None
    return name if isinstance(name, str) else None


def unzip(archive: Path, folder: Path) -> None:
    """Unpack an archive of submissions; a name that leads elsewhere is refused rather than repaired.

    Raises
    ------
    Refused
        If it is no zip file, or a name in it leaves the folder, occurs twice, or unpacks to more than makes sense.
    """
    try:
        with zipfile.ZipFile(archive) as zipped:
            named = [(_name(entry), entry) for entry in zipped.infolist()]
            named = [(name, entry) for name, entry in named if not LITTER.intersection(name.split("/"))]
            if len(named) > MAX_FILES:
                raise Refused(f"{archive.name} holds {len(named)} files, and {MAX_FILES} is the limit")
            if sum(entry.file_size for _, entry in named) > MAX_UNZIPPED:
                raise Refused(f"{archive.name} unpacks to more than {MAX_UNZIPPED >> 30} GB")
            for name, entry in named:
                _vet(name, entry)
            files = [(name, entry) for name, entry in named if not name.endswith("/")]
            folded = {unicodedata.normalize("NFC", name).casefold() for name, _ in files}
            if len(folded) < len(files):
                raise Refused(f"{archive.name} holds two files of one name")
            for name, _ in named:
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                if name.endswith("/"):  # whoever handed in nothing is to be told so
                    (folder / name).mkdir(exist_ok=True)
            for name, entry in files:
                with zipped.open(entry) as packed, open(folder / name, "xb") as file:
                    # never more than the archive's own table of contents promised
                    file.write(packed.read(min(entry.file_size, MAX_BYTES + 1)))
    except (zipfile.BadZipFile, NotImplementedError, RuntimeError, EOFError, OSError) as error:
        raise Refused(f"{archive.name} cannot be unpacked: {error}") from None


def _name(entry: zipfile.ZipInfo) -> str:
    """The path of an entry: Windows may write backslashes, and macOS UTF-8 without saying so."""
    name = entry.filename
    if not entry.flag_bits & SAYS_UTF8:
        try:
            name = name.encode("cp437").decode("utf-8")
        except UnicodeError:
            pass  # it was cp437 indeed
    return name.replace("\\", "/")


def _vet(name: str, entry: zipfile.ZipInfo) -> None:
    parts, mode = name.removesuffix("/").split("/"), entry.external_attr >> 16
    odd = any(part in ("", ".", "..") for part in parts) or any(c in name for c in ":\0") or not name.isprintable()
    if odd or len(name) > 255:
        raise Refused(f"the name {name[:80]!r} in the archive is not safe")
    if stat.S_IFMT(mode) not in (0, stat.S_IFDIR if name.endswith("/") else stat.S_IFREG):
        raise Refused(f"{name!r} in the archive is not a regular file")
    if entry.file_size > 1 << 20 and entry.file_size > MAX_RATIO * max(entry.compress_size, 1):
        raise Refused(f"{name!r} in the archive unpacks to {MAX_RATIO} times its size or more")
