"""The whole examination on every core, and what came of it as data, from which a figure can be drawn."""

import json
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from examination.mutants import Mutant, mutants
from examination.solutions import Solution, solution, solutions
from examination.trial import Judged, equivalents, judge

FILE = Path(__file__).parents[2] / "_build" / "examination.json"
AT_ONCE = 30  # mutants in one job of a process
TOGETHER = 6  # survivors that share the draws of their inputs

# Why a mutant may keep its points although it is not the reference, by function and by what is in the mutant's name.
WAIVED: dict[tuple[str, str], str] = {
    ("propagate", "seed -> throws"): "any seed will do",
    ("newton", "message"): "the task asks for nothing in the message",
    ("assemblies", "message"): "the task asks for nothing in the message",
    ("jacobian_fd", "constant, line 20: 1.0"): "a step that is a little wider is as good",
    ("jacobian_fd", "minus, line 20"): "so is the same step to the other side",
    ("integrate_pieces", "line 28: range(len(piece) + 1)"): "a power too many has the coefficient zero",
    ("integrate_pieces", "line 28: 1 -> 2"): "a power too many has the coefficient zero",
    ("integrate_pieces", "line 20: 't'"): "a symbol may have any name",
    ("integrate_pieces", "ends[:-1] -> ends"): "zip ends with the shortest",
    ("integrate_pieces", "line 25: sp.integrate"): "there is one symbol to integrate by",
    ("integrate_pieces", "np.asarray(alpha, dtype=float)"): "the numbers are floats already",
    ("absolute_errors", "message"): "the task asks for nothing in the message",
    ("driven_motion", "line 45: 1e-1"): "a tolerance that is a little wider is as good",
    ("driven_motion", "'DOP853', t, rtol=1e-11)"): "the absolute tolerance of SciPy is as good",
    ("energy_drift", "message"): "the task asks for nothing in the message",
    ("saw_position", "theta2 -> seed"): "the Jacobian of this loop does not depend on theta2",
    ("one_point", "crank -> seed"): "the Jacobian of this loop does not depend on the crank",
    ("one_point", "message"): "the task asks for nothing in the message",
    ("one_point", "range(1, 51)"): "the task leaves open after how many iterations to give up",
    ("fifteen_equations", "message"): "the task asks for nothing in the message",
    ("power_residual", "message"): "the task asks for nothing in the message",
    ("body_residuals", "message"): "the task asks for nothing in the message",
    ("body_residuals", "line 36: alpha -> forces"): "the forces are compared with all others as well",
    ("one_point", "51 -> 5"): "the task leaves open after how many iterations to give up",
}


def judged(task: str, some: Sequence[Mutant]) -> list[Judged]:
    return [judge(solution(task), mutant) for mutant in some]


def compared(task: str, survivors: Sequence[Mutant]) -> dict[Mutant, str]:
    return equivalents(solution(task), survivors)


def examined(of: Sequence[Solution] = ()) -> list[dict]:
    """Every mutant of the solutions, counted and told apart; a row for each function that tasks ask for."""
    of = of or solutions()
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        made = {s: mutants(s.source) for s in of}
        jobs = {
            s: [pool.submit(judged, s.tasks[0].name, some[i : i + AT_ONCE]) for i in range(0, len(some), AT_ONCE)]
            for s, some in made.items()
        }
        results = {s: [result for job in each for result in job.result()] for s, each in jobs.items()}
        survivors = {
            s: [m for m, result in zip(made[s], results[s], strict=True) if not result.lost and not waived(s, m)]
            for s in of
        }
        comparisons = {
            s: [pool.submit(compared, s.tasks[0].name, some[i : i + TOGETHER]) for i in range(0, len(some), TOGETHER)]
            for s, some in survivors.items()
        }
        differs = {s: dict(pair for job in each for pair in job.result().items()) for s, each in comparisons.items()}
        return [_row(s, made[s], results[s], differs[s]) for s in of]


def waived(of: Solution, mutant: Mutant) -> str:
    """Why this mutant may keep its points; empty if it may not."""
    reasons = (why for (function, slip), why in WAIVED.items() if of.function == function and slip in str(mutant))
    return next(reasons, "")


def _row(of: Solution, made: list[Mutant], results: list[Judged], differs: dict[Mutant, str]) -> dict:
    def number(condition: Callable[[Judged], bool]) -> int:
        return sum(map(condition, results))

    return {
        "tasks": [task.name for task in of.tasks],
        "mutants": len(made),
        "killed": number(lambda r: r.lost),
        "by an exception alone": number(lambda r: r.lost and r.verdicts <= {"error", "missing"}),
        "timeouts": number(lambda r: "timeout" in r.verdicts),
        "equivalent": [str(mutant) for mutant, where in differs.items() if not where],
        "waived": {str(m): waived(of, m) for m, r in zip(made, results, strict=True) if not r.lost and waived(of, m)},
        "survivors": {str(mutant): where for mutant, where in differs.items() if where},
    }


def write(rows: list[dict]) -> None:
    FILE.parent.mkdir(exist_ok=True)
    FILE.write_text(json.dumps({"mutants": rows}, indent=1, ensure_ascii=False) + "\n", "utf-8")
