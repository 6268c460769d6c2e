"""What students handed in: which file is whose, and which exercise it is; nothing is passed over in silence."""

import tempfile
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from autograder.checks import EXERCISES
from autograder.ingest import Notebook, Refused, parse, read, unzip
from autograder.spec import Exercise


@dataclass(frozen=True)
class Submission:
    """One notebook of one student; why it cannot be graded, if that is known from outside."""

    student: str
    exercise: str
    path: Path
    refused: str = ""


def identify(path: Path) -> tuple[Exercise, Notebook]:
    """Which exercise a file is, by its own word or by its name, and its cells.

    Raises
    ------
    Refused
        If it cannot be read, or belongs to another course.
    """
    notebook = parse(read(path))
    exercise = EXERCISES.get(notebook.exercise or "") or EXERCISES.get(path.stem)
    if exercise is None:
        raise Refused(f"{path.name} is no exercise of this course: there are {', '.join(EXERCISES)}")
    names = dict.fromkeys(task.function for task in exercise.tasks)
    if notebook.exercise != exercise.name and not any(name in cell for cell in notebook.cells for name in names):
        raise Refused(f"{path.name} holds none of {', '.join(names)}: is it a notebook of another course?")
    return exercise, notebook


def find(folder: Path) -> list[Submission]:
    """The submissions of a cohort: ``folder/<student>/<exercise>.ipynb``, sorted.

    A notebook under another name counts for the exercise that it says it is, unless that one is there by name.

    Raises
    ------
    Refused
        If the folder is missing, or holds no students.
    """
    if not folder.is_dir():
        raise Refused(f"{folder} is not a folder of submissions: it must hold <student>/<exercise>.ipynb")
    students = sorted(path for path in folder.iterdir() if path.is_dir() and not path.name.startswith("."))
    found = [submission for student in students for submission in _of_student(student)]
    if not found:
        raise Refused(f"{folder} holds no <student>/<exercise>.ipynb; the exercises are {', '.join(EXERCISES)}")
    return sorted(found, key=lambda s: (s.student, s.exercise))


def _of_student(student: Path) -> list[Submission]:
    if student.is_symlink():
        return [Submission(student.name, "", student, f"{student.name} is a link: hand in the folder itself")]
    notebooks = sorted(student.glob("*.ipynb"), key=lambda path: (path.stem not in EXERCISES, path.name))
    found: dict[str, Submission] = {}
    strays = []
    for path in notebooks:
        try:
            name = path.stem if path.stem in EXERCISES else identify(path)[0].name
        except Refused as why:
            strays.append(Submission(student.name, path.stem, path, str(why)))
            continue
        found.setdefault(name, Submission(student.name, name, path))
    if not notebooks:
        strays.append(Submission(student.name, "", student, f"{student.name} handed in no notebook"))
    return [*found.values(), *strays]


@contextmanager
def unpacked(path: Path):
    """The folder of submissions, unpacked first if it is a zip file."""
    if path.suffix.lower() != ".zip":
        yield path
        return
    with tempfile.TemporaryDirectory() as folder:
        unzip(path, Path(folder))
        yield Path(folder)


def contents(submission: Submission) -> tuple[str, tuple[str, ...], str]:
    """Exercise, cells, and why they cannot be graded: all that leaves the folder."""
    if submission.refused:
        return submission.exercise, (), submission.refused
    try:
        exercise, notebook = identify(submission.path)
    except Refused as refusal:
        return submission.exercise, (), str(refusal)
    if exercise.name != submission.exercise:
        return submission.exercise, (), f"{submission.path.name} says that it is {exercise.name}"
    return exercise.name, notebook.cells, ""
