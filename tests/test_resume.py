"""A run may end at any moment, in any way: what it has judged is kept, and the next run ends as if nothing had been."""

import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from functools import partial

import pytest
from handing_in import GOOD, GOOD_ORDER, ROOT, code, exercise, hand_in

from autograder import cohort, judge
from autograder.cohort import grade_cohort
from autograder.journal import Journal
from autograder.publish import sweep

SALT = "a pinch"
NAME = "01_newton_1d"
TASKS = ("brackets", "newton_1d", "failures", "order")


def cohort_of(folder, students):
    """Right answers, wrong ones and none, in short notebooks; the same in each call."""
    kinds = (
        {"brackets": GOOD["brackets"], "order": GOOD_ORDER},
        {"brackets": "return []", "order": "return 2.0"},
        {"newton_1d": "return 1 / 0"},
        {},
    )
    for k in range(students):
        hand_in(folder, f"student{k:02d}", NAME, code(exercise(NAME, **kinds[k % len(kinds)])))
    return folder


def files(out):
    """Everything that people read, byte by byte."""
    return {p.relative_to(out): p.read_bytes() for p in out.rglob("*") if p.is_file() and "journal" not in p.name}


def journalled(out):
    """Tasks and whole submissions that another process finds in a journal."""
    if not (out / "journal.sqlite").exists():
        return 0, 0
    with sqlite3.connect(f"file:{out / 'journal.sqlite'}?mode=ro", uri=True, timeout=60) as db:
        try:
            counts = [db.execute(f"SELECT count(*) FROM {table}").fetchone()[0] for table in ("judged", "graded")]
        except sqlite3.OperationalError:  # killed before the tables were made
            counts = [0, 0]
    db.close()
    return tuple(counts)


def asked(monkeypatch, also=lambda student_task: None):
    """The tasks that are judged from here on, in turn."""
    tasks = []
    real = judge.assess

    def assess(paper, *rest):
        also(paper.task.name)
        tasks.append(paper.task.name)
        return real(paper, *rest)

    monkeypatch.setattr(judge, "assess", assess)
    return tasks


def test_every_task_is_on_disk_before_the_next_begins(tmp_path, monkeypatch):
    cohort_of(tmp_path / "in", 1)
    seen = []
    tasks = asked(monkeypatch, lambda task: seen.append(journalled(tmp_path / "out")))
    grade_cohort(tmp_path / "in", tmp_path / "out", "none", SALT)
    assert tuple(tasks) == TASKS
    assert seen == [(0, 0), (1, 0), (2, 0), (3, 0)]
    assert journalled(tmp_path / "out") == (0, 1)


@pytest.mark.parametrize("reached", TASKS)
def test_a_broken_run_goes_on_at_the_task_where_it_stopped(tmp_path, monkeypatch, reached):
    cohort_of(tmp_path / "in", 1)
    grade_cohort(tmp_path / "in", tmp_path / "undisturbed", "none", SALT)

    def power_cut(task):
        if task == reached:
            raise OSError("the power is gone")

    with monkeypatch.context() as patch, pytest.raises(OSError, match="the power is gone"):
        asked(patch, power_cut)
        grade_cohort(tmp_path / "in", tmp_path / "out", "none", SALT)
    tasks = asked(monkeypatch)
    grade_cohort(tmp_path / "in", tmp_path / "out", "none", SALT)
    assert tuple(tasks) == TASKS[TASKS.index(reached) :]
    assert files(tmp_path / "out") == files(tmp_path / "undisturbed")


def test_a_run_cut_off_between_the_last_task_and_the_end_still_knows_the_notes(tmp_path, monkeypatch):
    hand_in(tmp_path / "in", "a", NAME, exercise(NAME, own="1 / 0"))
    grade_cohort(tmp_path / "in", tmp_path / "undisturbed", "none", SALT)

    def cut(*_):
        raise OSError("cut off")

    with monkeypatch.context() as patch, pytest.raises(OSError, match="cut off"):
        patch.setattr(Journal, "put", cut)
        grade_cohort(tmp_path / "in", tmp_path / "out", "none", SALT)
    grade_cohort(tmp_path / "in", tmp_path / "out", "none", SALT)
    assert files(tmp_path / "out") == files(tmp_path / "undisturbed")
    assert b"stopped with ZeroDivisionError" in (tmp_path / f"out/feedback/a/{NAME}.html").read_bytes()


def test_what_is_graded_already_is_not_graded_again_unless_it_changed(tmp_path, monkeypatch):
    read = []
    real = cohort.contents
    monkeypatch.setattr(cohort, "contents", lambda s: read.append(s.student) or real(s))
    for student in ("a", "b"):
        hand_in(tmp_path / "in", student, NAME, b"")
    for expected in (["a", "b"], []):
        grade_cohort(tmp_path / "in", tmp_path / "out", "none")
        assert sorted(read) == expected
        read.clear()
    hand_in(tmp_path / "in", "b", NAME, b"{")
    grade_cohort(tmp_path / "in", tmp_path / "out", "none")
    assert read == ["b"]


def test_what_was_withdrawn_leaves_no_feedback_behind(tmp_path):
    cohort_of(tmp_path / "in", 2)
    grade_cohort(tmp_path / "in", tmp_path / "out", "none", SALT)
    note = tmp_path / "out/feedback/student01/by hand.txt"
    note.write_text("see me")
    (tmp_path / f"in/student01/{NAME}.ipynb").unlink()
    (tmp_path / "in/student01").rmdir()
    grade_cohort(tmp_path / "in", tmp_path / "out", "none", SALT)
    assert not (tmp_path / f"out/feedback/student01/{NAME}.html").exists()
    assert note.exists()  # what others put there is theirs
    assert (tmp_path / f"out/feedback/student00/{NAME}.html").exists()


def test_no_draw_depends_on_what_was_judged_before(tmp_path, monkeypatch):
    own = "import numpy as np\nimport random"
    chance = "return [float(np.random.random()), random.random()]"
    hand_in(tmp_path / "in", "a", NAME, exercise(NAME, own=own, brackets=chance, order="return np.random.random()"))
    drawn = []
    real = judge.Session._call

    def call(self, function, *rest):
        drawn.append((function, outcome := real(self, function, *rest)))
        return outcome

    monkeypatch.setattr(judge.Session, "_call", call)
    grade_cohort(tmp_path / "in", tmp_path / "whole", "none", SALT)
    whole = [outcome for function, outcome in drawn if function == "order"]
    assert len({repr(outcome) for outcome in whole}) == len(whole) > 1  # each draw is another
    drawn.clear()
    monkeypatch.setattr(Journal, "judged", lambda *_: {"brackets": judge._missing(judge_task("brackets"), "")})
    grade_cohort(tmp_path / "in", tmp_path / "rest", "none", SALT)
    assert [outcome for function, outcome in drawn if function == "order"] == whole


def judge_task(name):
    from autograder.checks import EXERCISES

    return next(task for task in EXERCISES[NAME].tasks if task.name == name)


def run(folder, out, jobs=2, **options):
    command = (sys.executable, "-m", "autograder.cli", "grade", folder, "--out", out, "--salt", folder.parent / "salt")
    return subprocess.Popen([*command, "-j", str(jobs)], cwd=ROOT, stdout=subprocess.DEVNULL, **options)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "salt").write_text(SALT)
    return cohort_of(tmp_path / "in", 40)


def wait_for(condition, process, seconds=120):
    ending = time.monotonic() + seconds
    while not condition():
        assert process.poll() is None, "it was over too soon"
        assert time.monotonic() < ending, "it does not get there"
        time.sleep(0.01)


def test_the_stop_key_leaves_a_journal_that_the_same_command_goes_on_from(tmp_path, folder):
    out = tmp_path / "out"
    # a shell has its background jobs ignore the key, and these their children
    heeding = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    stopped = run(folder, out, stderr=subprocess.PIPE, text=True, preexec_fn=heeding)
    wait_for(lambda: journalled(out)[1] >= 3, stopped)
    stopped.send_signal(signal.SIGINT)
    _, said = stopped.communicate(timeout=60)
    assert stopped.returncode == 130
    assert "of 40 submissions are graded and kept" in said
    assert "Traceback" not in said
    assert 3 <= journalled(out)[1] < 40
    assert run(folder, out).wait() == 0
    assert run(folder, tmp_path / "undisturbed").wait() == 0
    assert files(out) == files(tmp_path / "undisturbed")


def test_two_runs_at_once_on_one_folder_do_no_harm(tmp_path, folder):
    both = [run(folder, tmp_path / "out") for _ in range(2)]
    assert [process.wait() for process in both] == [0, 0]
    assert run(folder, tmp_path / "undisturbed").wait() == 0
    assert files(tmp_path / "out") == files(tmp_path / "undisturbed")


def test_what_a_killed_run_left_half_written_is_swept_and_what_another_run_is_writing_stays(tmp_path):
    with subprocess.Popen([sys.executable, "-c", ""]) as ended:
        pass
    half, being_written = (tmp_path / "a" / f".part-{pid}-x.html" for pid in (ended.pid, os.getpid()))
    half.parent.mkdir()
    half.touch()
    being_written.touch()
    sweep(tmp_path)
    assert [*half.parent.iterdir()] == [being_written]


def kill_and_run_again(folder, out, moment):
    """What was in the journal when the run was killed."""
    killed = run(folder, out, stderr=subprocess.DEVNULL)
    try:
        killed.wait(moment)
    except subprocess.TimeoutExpired:
        os.kill(killed.pid, signal.SIGKILL)
        killed.wait()
    found = journalled(out)
    assert run(folder, out, stderr=subprocess.DEVNULL).wait() == 0
    return found


def killed_and_compared(tmp_path, folder, times):
    """How many of the runs were killed in the middle; each of them ends with the bytes of an undisturbed run."""
    began = time.monotonic()
    assert run(folder, tmp_path / "undisturbed").wait() == 0
    whole, undisturbed = time.monotonic() - began, files(tmp_path / "undisturbed")
    draw = random.Random(times)
    middle = 0
    for k in range(times):
        found = kill_and_run_again(folder, out := tmp_path / f"out{k}", draw.uniform(0.3, 1.0) * whole)
        assert files(out) == undisturbed, k
        middle += found != (0, 0) and found[1] < 40
    return middle


def test_a_killed_run_ends_with_the_same_bytes_when_it_is_run_again(tmp_path, folder):
    killed_and_compared(tmp_path, folder, 2)


@pytest.mark.proof
def test_a_run_killed_at_fifty_random_moments_ends_with_the_same_bytes_fifty_times(tmp_path, folder):
    middle = killed_and_compared(tmp_path, folder, 50)
    print(f"killed 50 times, {middle} of them between the first task and the last")
    assert middle >= 10  # the start takes its share of a short run
