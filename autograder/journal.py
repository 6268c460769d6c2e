"""What has been graded, on disk: a run that is broken off goes on where it stopped."""

import json
import secrets
import sqlite3
from dataclasses import asdict
from pathlib import Path

from autograder.judge import Assessment, Finding, Graded

SCHEMA = """
CREATE TABLE IF NOT EXISTS graded (
    student TEXT, exercise TEXT, digest TEXT, graded TEXT, PRIMARY KEY (student, exercise)
);
CREATE TABLE IF NOT EXISTS secret (salt TEXT);
"""


class Journal:
    """The instructor's own file: it holds every result, and the salt that the hidden inputs are drawn from.

    Parameters
    ----------
    path : Path
        An SQLite file; made if it is missing.

    Raises
    ------
    sqlite3.DatabaseError
        If the file is something else.
    """

    def __init__(self, path: Path):
        path.touch(mode=0o600)  # the salt is nobody else's
        self._db = sqlite3.connect(path, timeout=30)
        self._db.executescript(SCHEMA)

    def __enter__(self) -> "Journal":
        return self

    def __exit__(self, *_) -> None:
        self._db.close()

    def salt(self) -> str:
        """The salt of this folder of grades: drawn once, then kept."""
        with self._db:
            self._db.execute("BEGIN IMMEDIATE")
            row = self._db.execute("SELECT salt FROM secret").fetchone()
            if row is None:
                row = (secrets.token_hex(16),)
                self._db.execute("INSERT INTO secret VALUES (?)", row)
        return row[0]

    def get(self, student: str, exercise: str, digest: str) -> Graded | None:
        """The result for exactly this submission, graded in exactly this way; None if there is none."""
        found = self._db.execute(
            "SELECT graded FROM graded WHERE student = ? AND exercise = ? AND digest = ?", (student, exercise, digest)
        ).fetchone()
        return _graded(json.loads(found[0])) if found else None

    def put(self, student: str, exercise: str, digest: str, graded: Graded) -> None:
        """Keep a result; it is on disk when this returns."""
        with self._db:
            self._db.execute(
                "INSERT OR REPLACE INTO graded VALUES (?, ?, ?, ?)",
                (student, exercise, digest, json.dumps(asdict(graded))),
            )


def _graded(stored: dict) -> Graded:
    assessments = tuple(
        Assessment(**{**a, "findings": tuple(Finding(**f) for f in a["findings"])}) for a in stored["assessments"]
    )
    return Graded(**{**stored, "assessments": assessments, "notes": tuple(stored["notes"])})
