"""Hostile files: notebooks that are none, and archives that unpack elsewhere."""

import json
import os
import stat
import zipfile

CELL = {"cell_type": "code", "source": "print(1)", "metadata": {}, "outputs": []}


def _notebook(content):
    """Makes a file of these bytes, or of a notebook with these cells."""

    def make(folder, world):
        path = folder / "handed-in.ipynb"
        path.write_bytes(content if isinstance(content, bytes) else json.dumps({"cells": content}).encode())
        return path

    return make


def _in_place(create):
    def make(folder, world):
        create(path := folder / "handed-in.ipynb", world)
        return path

    return make


def _archive(*names, content=b"{}", mode=0, says=None):
    def make(folder, world):
        path = folder / "handed-in.zip"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for name in names:
                entry = zipfile.ZipInfo(name.format(outside=world.folder))
                entry.external_attr, entry.compress_type = mode << 16, zipfile.ZIP_DEFLATED
                archive.writestr(entry, content if content is not None else str(world.secret))
        if says is not None:  # in the table of contents; the bytes are as many as they were
            size = len(content).to_bytes(4, "little")
            path.write_bytes(path.read_bytes().replace(size, says.to_bytes(4, "little")))
        return path

    return make


NOTEBOOKS = {
    "a link to a secret": _in_place(lambda path, world: path.symlink_to(world.secret)),
    "a link to a device": _in_place(lambda path, world: path.symlink_to("/dev/zero")),
    "a pipe": _in_place(lambda path, world: os.mkfifo(path)),
    "a folder": _in_place(lambda path, world: path.mkdir()),
    "ten gigabytes of nothing": _in_place(lambda path, world: (path.touch(), os.truncate(path, 10 << 30))),
    "too deep": _notebook(b'{"cells": ' + b"[" * 1_000_000),
    "deep in its metadata": _notebook(b'{"cells": [], "metadata": ' + b'{"a":' * 100_000 + b"1" + b"}" * 100_001),
    "not UTF-8": _notebook("é".encode("latin-1") * 1000),
    "UTF-16": _notebook(json.dumps({"cells": [CELL]}).encode("utf-16")),
    "half a character": _notebook(b'{"cells": [{"cell_type": "code", "source": "\\ud800"}]}'),
    "cells without end": _notebook([CELL] * 50_000),
    "a cell without end": _notebook([CELL | {"source": "#" * (9 << 20)}]),
    "a number without end": _notebook(b'{"cells": [], "nbformat": ' + b"9" * (5 << 20) + b"}"),
    "cells that are none": _notebook([None, 1, [], {}, {"cell_type": "code"}, {"cell_type": "code", "source": {}}]),
    "metadata that is none": _notebook(b'{"cells": [], "metadata": {"mechanisms": {"exercise": {"points": 99}}}}'),
    "keys without end": _notebook(json.dumps(dict.fromkeys(map(str, range(300_000)), 0)).encode()),
}

ARCHIVES = {
    "up and out": _archive("../escaped.ipynb"),
    "far up and out": _archive("a/../../../escaped.ipynb"),
    "an absolute name": _archive("{outside}/escaped.ipynb"),
    "backslashes": _archive("..\\escaped.ipynb"),
    "a link and a file through it": _archive("a", "a/x.ipynb", content=None, mode=stat.S_IFLNK | 0o777),
    "a device": _archive("a/x.ipynb", mode=stat.S_IFCHR | 0o666),
    "one name twice": _archive("a/x.ipynb", "A/X.ipynb"),
    "control characters": _archive("a/\x1b[2J\u202e.ipynb"),
    "a bomb": _archive("a/x.ipynb", content=bytes(50 << 20)),
    "a bomb that lies about its size": _archive("a/x.ipynb", content=bytes(50 << 20), says=10),
    "files without end": _archive(*(f"{k}/x.ipynb" for k in range(21_000)), content=b""),
}
