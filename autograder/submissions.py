"""What students handed in: which file is whose, and which exercise it is; nothing is passed over in silence."""

import os
import re
import shutil
import tempfile
import unicodedata
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from autograder.channel import printable
from autograder.checks import EXERCISES
from autograder.ingest import LITTER, Notebook, Refused, parse, read, unzip
from autograder.oddities import answers, look
from autograder.spec import Exercise

MOST_NOTES = 20
DEEPEST = 4  # folders below a student's
MOODLE = re.compile(r"(?P<student>.+_\d+_assignsubmission_file_).+\.ipynb", re.IGNORECASE)  # as it names single files


@dataclass(frozen=True)
class Submission:
    """One notebook of one student; why it cannot be graded, if that is known from outside; how it was handed in."""

    student: str
    exercise: str
    path: Path
    refused: str = ""
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Contents:
    """All that leaves the folder: what to grade, or why that cannot be done, and what was odd."""

    exercise: str
    cells: tuple[str, ...]
    refused: str = ""
    notes: tuple[str, ...] = ()


def identify(path: Path) -> tuple[Exercise, Notebook]:
    """Which exercise a file is, by its own word, by its name or by what it defines; its cells, and what is odd.

    Raises
    ------
    Refused
        If it cannot be read, or belongs to another course.
    """
    notebook = parse(read(path))
    by_itself, by_name = EXERCISES.get(notebook.exercise or ""), EXERCISES.get(path.stem)
    exercise = by_itself or by_name or _by_answers(notebook)
    if exercise is None:
        raise Refused(f"{readable(path.name)} is no exercise of this course: there are {', '.join(EXERCISES)}")
    names = _functions(exercise)
    if not by_itself and not any(name in text for text in _texts(notebook) for name in names):
        raise Refused(f"{readable(path.name)} holds none of {', '.join(names)}: is it a notebook of another course?")
    notes = list(notebook.notes)
    if not by_itself:
        how = "name" if by_name else "functions"
        notes.append(f"the notebook does not say which exercise it is: taken for {exercise.name} by its {how}")
    notes += look(notebook.cells, notebook.texts, names)
    if len(notes) > MOST_NOTES:
        notes[MOST_NOTES:] = [f"and {len(notes) - MOST_NOTES} more of this kind"]
    return exercise, replace(notebook, notes=tuple(notes))


def _functions(exercise: Exercise) -> list[str]:
    return list(dict.fromkeys(task.function for task in exercise.tasks))


def _texts(notebook: Notebook) -> list[str]:
    return [*notebook.cells, *(text.source for text in notebook.texts)]


def _by_answers(notebook: Notebook) -> Exercise | None:
    """The one exercise of whose functions it defines most; None if there is no such one."""
    counts = {exercise.name: answers(notebook.cells, _functions(exercise)) for exercise in EXERCISES.values()}
    most = max(counts.values())
    best = [name for name, count in counts.items() if count == most]
    return EXERCISES[best[0]] if most and len(best) == 1 else None


def find(folder: Path) -> list[Submission]:
    """The submissions of a cohort: ``folder/<student>/<exercise>.ipynb``, sorted.

    A notebook under another name, or in a folder further down, counts for the exercise that it says it is, unless that
    one is there by name. Moodle's single files and one folder around all students are understood, too.

    Raises
    ------
    Refused
        If the folder is missing, or holds no students.
    """
    if not folder.is_dir():
        raise Refused(f"{folder} is not a folder of submissions: it must hold <student>/<exercise>.ipynb")
    folder = _within(folder)
    there = _visible(folder)
    folders = [path for path in there if path.is_dir()]
    lone = [path for path in there if path.suffix.lower() in (".ipynb", ".zip") and not path.is_dir()]
    found = [s for path, name in zip(folders, _names(folders), strict=True) for s in _of_student(path, name)]
    singles: dict[str, list[Path]] = {}
    for path in lone:
        if moodle := MOODLE.fullmatch(path.name):
            singles.setdefault(readable(moodle["student"]), []).append(path)
        elif folders:
            why = "is an archive: unpack it first" if path.suffix.lower() == ".zip" else "lies in no student's folder"
            found.append(_stray(readable(path.name), path, why))
    for student, paths in singles.items():
        found += _counted(student, [(path, path.name.removeprefix(student)) for path in paths])
    if not found:
        raise Refused(f"{folder} holds no <student>/<exercise>.ipynb; the exercises are {', '.join(EXERCISES)}")
    return sorted(found, key=lambda s: (s.student, s.exercise))


def _visible(folder: Path) -> list[Path]:
    return sorted(path for path in folder.iterdir() if _handed_in(path.name))


def _handed_in(name: str) -> bool:
    return not name.startswith(".") and name not in LITTER


def _within(folder: Path) -> Path:
    """The folder of students, where it is the only thing in the folder that was named."""
    there = _visible(folder)
    if len(there) != 1 or there[0].is_symlink() or not there[0].is_dir():
        return folder
    below = _visible(there[0])
    students = [path for path in below if path.is_dir() or MOODLE.fullmatch(path.name)]
    loose = [path for path in below if path.suffix.lower() == ".ipynb" and path not in students]
    return there[0] if len(students) > 1 and not loose else folder


def readable(name: str) -> str:
    """A name that can be stored, printed and used for a file of ours, whatever a student made of it."""
    stored = os.fsencode(name).decode("utf-8", "replace")
    return printable(unicodedata.normalize("NFC", stored)).lstrip(". ") or "nameless"


def _names(paths: Iterable[Path]) -> Iterator[str]:
    """Readable names; where two would be one, the second says so."""
    taken: Counter[str] = Counter()
    for path in paths:
        taken[name := readable(path.name)] += 1
        yield name if taken[name] == 1 else f"{name} ({taken[name]})"


def _stray(student: str, path: Path, why: str, exercise: str = "") -> Submission:
    return Submission(student, exercise, path, f"{readable(path.name)} {why}")


def _of_student(folder: Path, student: str) -> list[Submission]:
    if folder.is_symlink():
        return [_stray(student, folder, "is a link: hand in the folder itself")]
    files, closed = _files(folder)
    notebooks = [(path, where) for path, where in files if path.suffix.lower() == ".ipynb"]
    found = _counted(student, notebooks)
    found += [_stray(student, path, "cannot be opened", readable(path.name)) for path in closed]
    if not found:
        others = ", ".join(where for _, where in files[:3])
        why = f"handed in no notebook, but {others}: the .ipynb file is needed" if others else "handed in no notebook"
        return [Submission(student, "", folder, f"{student} {why}")]
    archives = tuple(f"{where} was not opened" for path, where in files if path.suffix.lower() == ".zip")
    return [replace(s, notes=(*s.notes, *archives)) for s in found]


def _files(folder: Path) -> tuple[list[tuple[Path, str]], list[Path]]:
    """What a student handed in, with its place, the least deep first; and the folders that cannot be opened."""
    files: list[tuple[Path, str]] = []
    closed: list[Path] = []
    for above, folders, names in os.walk(folder, onerror=lambda error: closed.append(Path(error.filename))):
        posing = [name for name in folders if name.lower().endswith(".ipynb")]
        here = Path(above)
        for name in filter(_handed_in, [*names, *posing]):
            files.append((here / name, "/".join(map(readable, (here / name).relative_to(folder).parts))))
        deep = len(here.relative_to(folder).parts) >= DEEPEST
        folders[:] = [] if deep else sorted(name for name in folders if _handed_in(name) and name not in posing)
    return sorted(files, key=lambda file: (file[1].count("/"), file[1])), closed


def _counted(student: str, notebooks: list[tuple[Path, str]]) -> list[Submission]:
    """Which of a student's notebooks counts for which exercise, and why the others count for none."""
    groups: dict[str, list[tuple[Path, str]]] = {}
    strays: dict[str, Submission] = {}
    for path, where in sorted(notebooks, key=lambda file: _stem(file[1]) not in EXERCISES):
        try:
            name = _stem(where) if _stem(where) in EXERCISES else identify(path)[0].name
        except Refused as why:
            name = where.replace("/", "-").removesuffix(".ipynb")
            strays[name] = Submission(student, name, path, str(why))
            continue
        groups.setdefault(name, []).append((path, where))
    return [*(_first(student, name, group) for name, group in groups.items()), *strays.values()]


def _stem(where: str) -> str:
    return Path(where).stem


def _first(student: str, exercise: str, group: list[tuple[Path, str]]) -> Submission:
    """The first notebook of an exercise that can be graded, and what is to be said of the others."""
    notes = []
    counts = group[0]
    if len(group) > 1:
        whys = [contents(Submission(student, exercise, path)).refused for path, _ in group]
        counts = group[next((i for i, why in enumerate(whys) if not why), 0)]
        for (_, where), why in zip(group, whys, strict=True):
            if where != counts[1]:
                notes.append(f"{where} was passed over ({why or 'a second notebook'}): {counts[1]} counts")
    if counts[1] != f"{exercise}.ipynb":
        notes.insert(0, f"the notebook was handed in as {counts[1]}")
    return Submission(student, exercise, counts[0], notes=tuple(notes))


@contextmanager
def unpacked(path: Path):
    """The folder of submissions, unpacked first if it is a zip file, and with it the students' own in it."""
    if path.suffix.lower() != ".zip":
        yield path
        return
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        unzip(path, folder)
        for archive in [path for path in folder.rglob("*") if path.suffix.lower() == ".zip" and path.is_file()]:
            _unpack_beside(archive)
        yield folder


def _unpack_beside(archive: Path) -> None:
    """An archive becomes a folder of its name; one that cannot be unpacked stays, to be spoken of."""
    target = archive.with_suffix("")
    if target.exists():
        return
    try:
        unzip(archive, target)
    except Refused:
        shutil.rmtree(target, ignore_errors=True)
    else:
        archive.unlink()


def contents(submission: Submission) -> Contents:
    """What is to be graded of a submission, or why nothing is."""
    exercise, refused = submission.exercise, submission.refused
    notes, cells = submission.notes, ()
    if not refused:
        try:
            found, notebook = identify(submission.path)
        except Refused as refusal:
            refused = str(refusal)
        else:
            cells, notes = notebook.cells, (*notes, *notebook.notes)
            if found.name != exercise:
                refused = f"{readable(submission.path.name)} says that it is {found.name}"
    return Contents(exercise, () if refused else cells, refused, notes)
