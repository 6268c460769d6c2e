"""The commands: check one notebook, grade a cohort, release the exercises, say what isolation there is."""

import json
import os
import sqlite3
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, ProgressColumn, TextColumn, TimeRemainingColumn
from rich.table import Table
from rich.text import Text

from autograder import isolation, judge
from autograder.ingest import Refused
from autograder.judge import Graded
from autograder.report import card_text, points
from autograder.sandbox import Sandbox
from autograder.spec import PUBLIC_SALT

FULL_POINTS, POINTS_MISSING, CANNOT = 0, 1, 2
INTERRUPTED = 130  # as a shell says it

app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False, help=__doc__)
out = Console(soft_wrap=True, highlight=False)
err = Console(stderr=True, soft_wrap=True, highlight=False)

Level = Annotated[
    str | None,
    typer.Option("--isolation", metavar="LEVEL", help="The least that will do: namespaces, landlock, limits or none."),
]


@app.command()
def check(
    file: Annotated[Path, typer.Argument(help="The notebook.")],
    as_json: Annotated[bool, typer.Option("--json", help="For programs.")] = False,
    level: Level = None,
) -> None:
    """Look at a whole notebook, as a grader would. Exit code: 0 full points, 1 points missing, 2 cannot be graded."""
    from autograder.submissions import identify

    exercise, notebook = identify(file)
    with Sandbox(isolation.choose(level, others=False)) as sandbox:
        graded = judge.grade(exercise, notebook.cells, sandbox, PUBLIC_SALT, "", True, notebook.notes)
    if as_json:
        print(json.dumps(_as_dict(graded), indent=2))
    else:
        for assessment in graded.assessments:
            out.print(escape(card_text(assessment)), end="\n\n")
        for note in graded.notes:
            out.print(escape(f"Note: {note}"))
        out.print(escape(f"{exercise.title}: {points(graded.points)} of {points(graded.max)} points"))
        out.print(escape(isolation.statement(graded.isolation)))
    raise typer.Exit(FULL_POINTS if graded.points == graded.max else POINTS_MISSING)


def _as_dict(graded: Graded) -> dict:
    return {
        "exercise": graded.exercise,
        "points": graded.points,
        "max": graded.max,
        "isolation": graded.isolation,
        "tasks": [
            {key: getattr(a, key) for key in ("task", "points", "max", "verdict", "diagnosis")}
            for a in graded.assessments
        ],
    }


@app.command()
def grade(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="<student>/<exercise>.ipynb, or a zip file of it.")],
    to: Annotated[Path, typer.Option("--out", help="Folder for grades, feedback and journal.")],
    jobs: Annotated[int, typer.Option("-j", min=1, help="Submissions at a time.")] = 2 * (os.cpu_count() or 1),
    level: Level = None,
    scheduler: Annotated[
        str | None, typer.Option(help="Address of a Dask scheduler, tcp://computer:8786, whose workers grade.")
    ] = None,
    salt: Annotated[
        Path | None,
        typer.Option(help="File that the hidden inputs are drawn from. Left out: drawn once, kept in the journal."),
    ] = None,
    book: Annotated[str, typer.Option(metavar="URL", help="Where the built book is, for links to its sections.")] = "",
) -> None:
    """Grade a folder of submissions. Exit code: 0 all graded, whatever the marks; 2 refused or nothing to grade."""
    from autograder.cohort import grade_cohort

    chosen = isolation.choose(level, others=True)
    seasoning = _read_salt(salt) if salt else None
    columns = (TextColumn("grading"), BarColumn(), MofNCompleteColumn(), _Rate(), TimeRemainingColumn())
    with ExitStack() as shown:
        bar = Progress(*columns, console=err)
        task = bar.add_task("", total=None)

        def progress(done: int, of: int) -> None:
            if not bar.live.is_started:  # what is refused is refused without a bar
                shown.enter_context(bar)
            bar.update(task, completed=done, total=of)

        try:
            results = grade_cohort(folder, to, chosen, seasoning, jobs, scheduler, progress, book)
        except KeyboardInterrupt:
            shown.close()
            kept = f"{bar.tasks[task].completed:.0f} of {bar.tasks[task].total or 0:.0f} submissions"
            err.print(
                f"Stopped: {kept} are graded and kept in {to}. The same command goes on from there.", markup=False
            )
            raise typer.Exit(INTERRUPTED) from None
    out.print(_table(results))
    out.print(isolation.statement(chosen), markup=False)
    for name, path in (("Grades", to / "grades.csv"), ("Feedback", to / "index.html")):
        out.print(f"{name}: {path.resolve()}", markup=False)


class _Rate(ProgressColumn):
    """Submissions a second, as of late."""

    def render(self, task) -> Text:
        speed = task.finished_speed or task.speed
        return Text(f"{speed:.1f}/s" if speed else "")


def _read_salt(path: Path) -> str:
    try:
        salt = path.read_text("utf-8").strip()
    except (OSError, UnicodeDecodeError) as error:
        raise Refused(f"the salt {path} cannot be read: {error}") from None
    if not salt:
        raise Refused(f"the salt {path} is empty: put some random characters in it")
    return salt


def _table(results: list[tuple[str, Graded]]) -> Table:
    table = Table("student", "exercise", "points", "of", "verdicts")
    for student, g in results:
        verdicts = ", ".join(f"{a.task} {a.verdict}".strip() for a in g.assessments)
        table.add_row(*(escape(text) for text in (student, g.exercise, points(g.points), points(g.max), verdicts)))
    return table


@app.command()
def release(
    check_only: Annotated[bool, typer.Option("--check", help="Only say what is out of date.")] = False,
    archive: Annotated[Path | None, typer.Option("--zip", help="Write the students' hand-out.")] = None,
) -> None:
    """Make exercises and executed solutions of solutions/*.md. Exit code: 0, or 1 if --check finds something stale."""
    from autograder.release import hand_out, project, sources

    folder = project(Path.cwd())
    touched = [path for source in sources(folder) for path in (source.stale() if check_only else source.release())]
    for path in touched:
        out.print(f"{'out of date' if check_only else 'written'}: {path.relative_to(folder)}", markup=False)
    if check_only and touched:
        err.print("To write them: autograder release")
        raise typer.Exit(1)
    if archive:
        names = hand_out(folder, archive)
        out.print(f"{len(names)} files in {archive}", markup=False)


@app.command(name="isolation")
def show_isolation(as_json: Annotated[bool, typer.Option("--json", help="For programs.")] = False) -> None:
    """Say how well this computer can keep a submission apart from everything else, and how to get more."""
    found = isolation.survey()
    if as_json:
        print(json.dumps(found.as_dict(), indent=2))
    else:
        for level in found.levels:
            mark = "used" if level.name == found.best else "there" if level.available else "missing"
            why = "".join(f"; {text}" for text in (level.reason, level.advice) if text)
            out.print(f"{level.name:<10}  {mark}{why}", markup=False)


def main() -> None:
    """Run a command; whatever goes wrong ends in one sentence."""
    try:
        app()
    except (Refused, isolation.IsolationError) as refusal:
        sentence = str(refusal)
    except sqlite3.DatabaseError as error:
        sentence = f"the journal cannot be used ({error}): move journal.sqlite away to begin anew"
    except ImportError as error:
        sentence = f'{error.name} is not installed: pip install -c requirements.lock -e ".[grade]"'
    except OSError as error:
        sentence = f"{error.filename or 'a file'} cannot be used: {error.strerror or error}"
    except Exception as mistake:
        if os.environ.get("AUTOGRADER_TRACEBACK"):
            raise
        sentence = f"{type(mistake).__name__}: {mistake} (AUTOGRADER_TRACEBACK=1 shows where)"
    else:
        return
    err.print(escape(sentence))
    sys.exit(CANNOT)


if __name__ == "__main__":
    main()
