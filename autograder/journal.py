"""What has been judged, on disk: a run that is broken off goes on at the task where it stopped."""

import json
import secrets
import sqlite3
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path

from autograder.judge import Assessment, Finding, Graded

SCHEMA = """
CREATE TABLE IF NOT EXISTS judged (
    student TEXT, exercise TEXT, digest TEXT, task TEXT, assessment TEXT, PRIMARY KEY (student, exercise, digest, task)
);
CREATE TABLE IF NOT EXISTS graded (
    student TEXT, exercise TEXT, digest TEXT, graded TEXT, PRIMARY KEY (student, exercise, digest)
);
CREATE TABLE IF NOT EXISTS secret (salt TEXT);
"""


class Journal:
    """The instructor's own file: it holds every result, and the salt that the hidden inputs are drawn from.

    A result counts for one digest: of exactly that submission, judged in exactly that way. The journal may be used by
    several threads, and by several runs at once.

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
        self._lock = threading.Lock()
        self._db = sqlite3.connect(path, timeout=60, isolation_level=None, check_same_thread=False)
        # a log beside the file: one write a task; no end of the program undoes it, a power cut may undo the last ones
        self._db.execute("PRAGMA journal_mode = WAL")
        self._db.execute("PRAGMA synchronous = NORMAL")
        self._db.executescript(SCHEMA)

    def __enter__(self) -> "Journal":
        return self

    def __exit__(self, *_) -> None:
        with self._lock:
            self._db.close()

    @contextmanager
    def _transaction(self) -> Iterator[sqlite3.Connection]:
        """All of it, or nothing; safe when it is over, whatever becomes of this program."""
        with self._lock, self._db:
            self._db.execute("BEGIN IMMEDIATE")
            yield self._db

    def salt(self) -> str:
        """The salt of this folder of grades: drawn once, then kept."""
        with self._transaction() as db:
            row = db.execute("SELECT salt FROM secret").fetchone()
            if row is None:
                row = (secrets.token_hex(16),)
                db.execute("INSERT INTO secret VALUES (?)", row)
        return row[0]

    def judged(self, student: str, exercise: str, digest: str) -> dict[str, Assessment]:
        """The tasks of a submission that are judged, by name."""
        found = self._rows(
            "SELECT task, assessment FROM judged WHERE student = ? AND exercise = ? AND digest = ? ORDER BY rowid",
            (student, exercise, digest),
        )
        return {task: _assessment(json.loads(stored)) for task, stored in found}

    def keep(self, student: str, exercise: str, digest: str, assessment: Assessment) -> None:
        """Keep one task; it is safe when this returns."""
        with self._transaction() as db:
            row = (student, exercise, digest, assessment.task, json.dumps(asdict(assessment)))
            db.execute("INSERT OR REPLACE INTO judged VALUES (?, ?, ?, ?, ?)", row)

    def get(self, student: str, exercise: str, digest: str) -> Graded:
        """The whole result of a submission; ValueError if there is none."""
        ((found,),) = self._rows(
            "SELECT graded FROM graded WHERE student = ? AND exercise = ? AND digest = ?", (student, exercise, digest)
        )
        stored = json.loads(found)
        assessments = tuple(_assessment(each) for each in stored["assessments"])
        return Graded(**{**stored, "assessments": assessments, "notes": tuple(stored["notes"])})

    def put(self, student: str, exercise: str, digest: str, graded: Graded) -> None:
        """Keep a whole result, in place of its tasks."""
        with self._transaction() as db:
            row = (student, exercise, digest, json.dumps(asdict(graded)))
            db.execute("INSERT OR REPLACE INTO graded VALUES (?, ?, ?, ?)", row)
            db.execute("DELETE FROM judged WHERE student = ? AND exercise = ? AND digest = ?", row[:3])

    def graded(self) -> set[tuple[str, str, str]]:
        """Student, exercise and digest of every whole result that there ever was."""
        return set(self._rows("SELECT student, exercise, digest FROM graded"))

    def _rows(self, question: str, values: tuple = ()) -> list[tuple]:
        with self._lock:
            return self._db.execute(question, values).fetchall()


def _assessment(stored: dict) -> Assessment:
    findings = tuple(Finding(**finding) for finding in stored["findings"])
    convergence = tuple(map(tuple, stored["convergence"]))
    return Assessment(**{**stored, "findings": findings, "convergence": convergence})
