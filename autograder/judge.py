"""The judge: asks, compares, names the mistake, gives the points. It never runs a student's code itself."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cache, cached_property, partial
from importlib.resources import files
from itertools import count
from types import MappingProxyType

import numpy as np

from autograder.compare import without_own_names, without_own_shape
from autograder.outcome import Lost, Outcome, Raised, Value
from autograder.spec import MOST_EVALUATIONS, Aspect, Case, Exercise, Task, Trial, Variant, attempt, recorded

Call = Callable[[str, tuple, dict, float], Outcome]

RIGHT, PARTLY, WRONG, ERROR, TIMEOUT, MISSING = "right", "partly", "wrong", "error", "timeout", "missing"

# One sentence, whichever limit is met first: a fast computer meets that of the evaluations, a slow one the clock's.
ENDLESS = Lost("it did not end in time: does a loop never end?", timeout=True)


@dataclass(frozen=True)
class Finding:
    """What one aspect of a task showed; no fault, full points."""

    says: str
    points: float
    fault: str | None

    @property
    def earned(self) -> float:
        return 0.0 if self.fault else self.points


@dataclass(frozen=True)
class Assessment:
    """A task, judged.

    Attributes
    ----------
    mistake : the known mistake that it is, and where to look; empty if it is none of them.
    why : why there is nothing to look at; empty if there is.
    section : chapter and section of the book to go back to.
    convergence : errors of the answer's iterates, and of the right ones, where a wrong answer iterates.
    """

    task: str
    title: str
    points: float
    max: float
    verdict: str
    findings: tuple[Finding, ...]
    section: str
    mistake: str = ""
    why: str = ""
    convergence: tuple[tuple[float, ...], ...] = ()

    @property
    def granted(self) -> float:
        """Points for what is right beside a known mistake, above what the findings earned."""
        return self.points - sum(finding.earned for finding in self.findings)

    @property
    def diagnosis(self) -> str:
        """What is wrong, in a sentence or two; empty if nothing is."""
        if self.mistake or self.why:
            return self.mistake or self.why
        worst = next((finding for finding in self.findings if finding.fault), None)
        return f"Looked for: {worst.says}. Found: {stopped(worst.fault)}" if worst else ""


def stopped(text: str) -> str:
    """With a full stop, unless it ends in a mark of its own."""
    return text if text.endswith((".", "?", "!")) else f"{text}."


class Paper:
    """What is asked in one task: the cases, the right answers, and the answers that known mistakes give.

    Each is worked out once, when it is first asked for.

    Attributes
    ----------
    task : Task
    cases : sequence of Case
    """

    def __init__(self, task: Task, cases: Sequence[Case]):
        self.task, self.cases = task, cases
        self._imitations: dict[tuple[Variant, int], Trial] = {}

    @cached_property
    def expected(self) -> list[Trial]:
        """The right answers."""
        return [attempt(self.task.reference, case) for case in self.cases]

    def imitation(self, variant: Variant, k: int) -> Trial:
        """What a known mistake answers to a case."""
        if (variant, k) not in self._imitations:
            self._imitations[variant, k] = attempt(variant.function, self.cases[k])
        return self._imitations[variant, k]


def drawn(task: Task, salt: str, student: str) -> Paper:
    """The paper of one student, with the right answers."""
    paper = Paper(task, task.draw(salt, student))
    paper.expected  # noqa: B018  # now, while nobody waits for it
    return paper


def assess(paper: Paper, call: Call, public: bool) -> Assessment:
    """Judge one task; an answer that the check itself cannot digest is an error of that task alone.

    Parameters
    ----------
    paper : Paper
    call : callable
        (function name, args, kwargs, seconds) -> outcome; how the student's function is reached.
    public : bool
        Whether the student may see what was tried, and what an exception said. Never for hidden cases.

    Returns
    -------
    Assessment
    """
    try:
        return _assess(paper, call, public)
    except Exception as mistake:  # a student's answer may be anything: its neighbours go on
        why = f"the check does not understand this answer ({type(mistake).__name__}): show it to your instructor"
        return replace(_missing(paper.task, why), verdict=ERROR)


def _assess(paper: Paper, call: Call, public: bool) -> Assessment:
    task, trials = paper.task, []
    for case in paper.cases:
        args, evaluations = recorded(case)
        gave_up = next((t.outcome for t in trials if isinstance(t.outcome, Lost)), None)
        outcome = gave_up or call(task.function, args, case.kwargs, task.seconds)
        outcome = outcome if public else without_own_names(outcome)
        if any(len(asked) >= MOST_EVALUATIONS for asked in evaluations):
            outcome = ENDLESS
        if why := _absent(task, outcome):
            return _missing(task, why)
        trials.append(Trial(case, outcome, evaluations))
    expected = paper.expected

    first, *further = task.aspects
    findings = [_look(task, first, trials, expected, public)]
    for aspect in further:
        waits = Finding(aspect.says, aspect.points, "it counts once the first holds")
        findings.append(waits if findings[0].fault else _look(task, aspect, trials, expected, public))
    earned = sum(finding.earned for finding in findings)
    judged = partial(Assessment, task.name, task.title, findings=tuple(findings), section=task.section, max=task.points)
    if earned == task.points:
        return judged(earned, verdict=RIGHT)
    lost = next((t.outcome.why for t in trials if isinstance(t.outcome, Lost)), "")
    if mistake := recognise(paper, trials):
        earned = max(earned, mistake.share * task.points)
    verdict = _verdict([trial.outcome for trial in trials], earned)
    said = f"{mistake.name}. {mistake.advice}" if mistake else ""
    return judged(earned, verdict=verdict, mistake=said, why=lost, convergence=_convergence(task, trials, expected))


def _convergence(task: Task, trials: Sequence[Trial], expected: Sequence[Trial]) -> tuple[tuple[float, ...], ...]:
    """Errors against iterations of the first wrong answer that shows any, and of the right one."""
    for trial, right in zip(trials, expected, strict=True):
        if task.errors is None or not task.disagreement(right.outcome, trial.outcome):
            continue
        errors = task.errors(trial, right)
        if errors is not None and ((errors > 0) & np.isfinite(errors)).any():
            return tuple(
                tuple(float(e) if np.isfinite(e) else 0.0 for e in each) for each in (errors, task.errors(right, right))
            )
    return ()


def recognise(paper: Paper, trials: Sequence[Trial]) -> Variant | None:
    """The known mistake that explains every trial; None unless it is the only one that does."""
    explains = [variant for variant in paper.task.variants if _explains(variant, paper, trials)]
    return explains[0] if len(explains) == 1 else None


def _explains(variant: Variant, paper: Paper, trials: Sequence[Trial]) -> bool:
    """Whether a known mistake does what was done in every trial, and in one of them not what is right."""
    task = paper.task
    same = _same_path if variant.by_path else task.same
    tells = False
    for k, (trial, right) in enumerate(zip(trials, paper.expected, strict=True)):
        if trial.case.kind == variant.kind:
            imitation = paper.imitation(variant, k)
            if not same(imitation, trial):
                return False
            tells = tells or not same(imitation, right)
    return tells


def _same_path(a: Trial, b: Trial) -> bool:
    one, other = a.path(), b.path()
    enough = min(len(one), len(other)) >= 3
    return enough and all(
        p.shape == q.shape and np.allclose(p, q, rtol=1e-6, atol=1e-9, equal_nan=True)
        for p, q in zip(one, other, strict=False)
    )


def _look(task: Task, aspect: Aspect, trials: Sequence[Trial], expected: Sequence[Trial], public: bool) -> Finding:
    for trial, right in zip(trials, expected, strict=True):
        if trial.case.kind != aspect.kind:
            continue
        if aspect.fault is None or isinstance(trial.outcome, Lost):
            fault = task.disagreement(right.outcome, trial.outcome)
        else:
            with np.errstate(all="ignore"):  # a diverging answer may overflow a norm
                fault = aspect.fault(trial, right)
        if fault and not public:
            fault = without_own_shape(fault)
        if fault and public and isinstance(trial.outcome, Raised):
            fault += f", which says: {trial.outcome.message}" if trial.outcome.message else ""
        if fault and public and trial.case.label:
            fault += f" (tried: {trial.case.label})"
        if fault:
            return Finding(aspect.says, aspect.points, fault)
    return Finding(aspect.says, aspect.points, None)


def _absent(task: Task, outcome: Outcome) -> str | None:
    match outcome:
        case Raised(type="NotImplementedError"):
            return "not started"
        case Raised(type="NameError", message=message) if message == undefined(task.function):
            return f"not started: no cell defines {task.function}"
    return None


def undefined(function: str) -> str:
    """What is said of a function that no cell defines."""
    return f"{function} is not defined"


def _missing(task: Task, why: str) -> Assessment:
    findings = tuple(Finding(aspect.says, aspect.points, why) for aspect in task.aspects)
    return Assessment(task.name, task.title, 0.0, task.points, MISSING, findings, task.section, why=why)


def _verdict(outcomes: Sequence[Outcome], earned: float) -> str:
    if any(isinstance(outcome, Lost) and outcome.timeout for outcome in outcomes):
        return TIMEOUT
    if earned:
        return PARTLY
    return WRONG if any(isinstance(outcome, Value) for outcome in outcomes) else ERROR


@dataclass(frozen=True)
class Graded:
    """A notebook, judged: its tasks, and what was odd about it."""

    exercise: str
    assessments: tuple[Assessment, ...]
    notes: tuple[str, ...] = ()
    output: str = ""
    isolation: str = ""

    @property
    def points(self) -> float:
        return sum(a.points for a in self.assessments)

    @property
    def max(self) -> float:
        return sum(a.max for a in self.assessments)


def ungraded(name: str, exercise: Exercise | None, why: str, isolation: str, notes: Sequence[str] = ()) -> Graded:
    """A submission of which nothing can be graded, and why."""
    tasks = tuple(_missing(task, why) for task in exercise.tasks) if exercise else ()
    stray = Assessment("", name, 0.0, 0.0, MISSING, (), "", why=why)
    return Graded(name, tasks or (stray,), (why, *notes), "", isolation)


def grade(
    exercise: Exercise,
    cells: Sequence[str],
    sandbox,
    salt: str,
    student: str,
    public: bool = False,
    notes: Sequence[str] = (),
    known: Mapping[str, Assessment] = MappingProxyType({}),
    keep: Callable[[Assessment], None] = lambda assessment: None,
) -> Graded:
    """Judge a notebook in a worker of the sandbox.

    Parameters
    ----------
    exercise : Exercise
    cells : sequence of str
        The code cells, in order.
    sandbox : Sandbox
    salt, student : str
        What the cases are drawn from.
    public : bool
        Whether the student may see what was tried.
    notes : sequence of str
        What was odd before a cell ran.
    known : mapping of str to Assessment
        Tasks that were judged before a run was broken off; they are not judged again.
    keep : callable
        Gets every further assessment before the next task begins.

    Returns
    -------
    Graded
    """
    assessments = dict(known)
    left = [task for task in exercise.tasks if task.name not in known]
    with ThreadPoolExecutor(1) as beside:
        papers = [beside.submit(drawn, task, salt, student) for task in left]  # while the cells run
        with Session(exercise, cells, sandbox) as session:
            for task, paper in zip(left, papers, strict=True):
                judged = assess(paper.result(), session.caller(), public)
                keep(assessment := _explain(judged, session))
                assessments[task.name] = assessment
            said, output = (*notes, *session.notes), session.output
    return Graded(exercise.name, tuple(assessments[t.name] for t in exercise.tasks), said, output, sandbox.level)


def _explain(assessment: Assessment, session: "Session") -> Assessment:
    """A function is missing because its cell failed: say so where the student looks."""
    if assessment.verdict != MISSING or not session.failed:
        return assessment
    return replace(assessment, why=f"{assessment.why}; {session.failed[0]}")


class Session:
    """A submission whose cells have run in a worker; one that is lost is replaced, without the cell that lost it."""

    def __init__(self, exercise: Exercise, cells: Sequence[str], sandbox):
        self.exercise, self.cells, self.sandbox = exercise, cells, sandbox
        self.notes: list[str] = []
        self.failed: list[str] = []
        self.output = ""
        self._worker = None
        self._skip: set[int] = set()

    def __enter__(self) -> "Session":
        self._ready()
        self.output = self._worker.output
        return self

    def __exit__(self, *_) -> None:
        self._drop()

    def caller(self) -> Call:
        """How the functions of one task are called; a draw depends on its turn in the task and on no other task."""
        turn = count()
        return lambda function, args, kwargs, seconds: self._call(function, args, kwargs, seconds, next(turn))

    def _call(self, function: str, args: tuple, kwargs: dict, seconds: float, seed: int) -> Outcome:
        from autograder.channel import TimeLimit, WorkerLost

        try:
            return self._ready().call(function, args, kwargs, seconds=seconds, seed=seed)
        except TimeLimit:
            self._drop()
            return ENDLESS
        except WorkerLost as lost:
            self._drop()
            return Lost(str(lost))

    def _ready(self):
        """A worker in which every cell has run."""
        from autograder.channel import WALL, TimeLimit, WorkerLost

        seconds = self.exercise.cell_seconds
        while self._worker is None:
            self._worker = self.sandbox.worker(modules=sources(self.exercise.imports))
            for i, cell in enumerate(self.cells):
                if i in self._skip:
                    continue
                try:
                    ran = self._worker.run(cell, seconds)
                except WorkerLost as lost:
                    limit = f"did not end in time ({seconds:g} s of computing, {WALL * seconds:g} s by the clock)"
                    why = limit if isinstance(lost, TimeLimit) else f"ended the process: {lost}"
                    self._skip.add(i)
                    self._fail(f"code cell {i + 1} {why}, and was left out")
                    self._drop()
                    break
                if ran.note:
                    self._note(f"code cell {i + 1}: {ran.note}")
                if ran.raised:
                    self._fail(f"code cell {i + 1} stopped with {ran.raised.type}: {ran.raised.message}")
            self.sandbox.prepare()  # not before: a fork holds up the cells, which touch much memory for the first time
        return self._worker

    def _note(self, note: str) -> None:
        if note not in self.notes:
            self.notes.append(note)

    def _fail(self, note: str) -> None:
        if note not in self.failed:
            self.failed.append(note)
        self._note(note)

    def _drop(self) -> None:
        if self._worker is not None:
            self.sandbox.dismiss(self._worker)
            self._worker = None


@cache
def sources(modules: tuple[str, ...]) -> dict[str, str]:
    """The files of mechlib that a submission may import, by name."""
    names = ["__init__", *modules] if modules else []
    return {f"mechlib/{name}.py": files("mechlib").joinpath(f"{name}.py").read_text("utf-8") for name in names}
