"""300 students hand in all notebooks each: how long it takes, and whether memory grows with their number.

python tests/benchmarks/cohort_of_300.py [--students N] [--exercises NAME ...] [-j N]
"""

import argparse
import csv
import json
import os
import random
import statistics
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

from measuring import AUTOGRADER, MB, Cost, computer, cost
from rich.console import Console
from rich.table import Table

ROOT = Path(__file__).parents[2]
SOLUTIONS = ROOT / "solutions"
SHARE = 1 / 3  # of the notebooks, with a mistake
GROWTH, SLACK, ENOUGH = 0.10, 20.0, 20  # what memory may grow by, or by so many MB; students to tell it from the start
OVER = 0.97  # part of the run after which the workers go

# One edit of a solution each: a mistake that costs points, whoever makes it.
MISTAKES = {
    "01_newton_1d": (
        ("np.linspace(a, b, n + 1)", "np.linspace(a, b, n)"),
        ("x = x - step", "x = x + step"),
        ('abs(step) / abs(x) if error == "relative" else abs(step)', "abs(step)"),
        ("slope = df(x)", "slope = df(float(seed))"),
        ("s1, s2, s3 = steps[-3:]", "s1, s2, s3 = steps[:3]"),
        ("change = y[:-1] * y[1:] < 0", "change = y[:-1] * z[1:] < 0"),
    ),
    "02_newton_nd": (
        ("np.linalg.solve(jacobian(x), residual(x))", "np.linalg.solve(jacobian(x).T, residual(x))"),
        ("x = x - step", "x -= step"),
        ("return np.column_stack(columns)", "return np.array(columns)"),
        ("found[j, i] = distance.argmin()", "found[i, j] = distance.argmin()"),
        ("except np.linalg.LinAlgError:", "except ZeroDivisionError:"),
    ),
    "03_motor_profile": (
        ("primitive += value - primitive.subs(t, start)", "pass"),
        ("np.sqrt(3 * 2 * np.pi * turns / peak)", "np.sqrt(3 * turns / peak)"),
        ("t**3 / 6]", "t**3 / 3]"),
        ("return name, int(np.argmax(wrong))", "return name, int(np.argmax(wrong)) + 1"),
    ),
    "04_hacksaw_closure": (
        ("ar * c1 - 2 * vr * w1 * s1", "ar * c1 - vr * w1 * s1"),
        ("return np.array([of_fx, of_fy, of_fc])", "return np.array([of_fx, of_fy, of_fc]).T"),
        ("(np.pi - np.arcsin(sine), np.arcsin(sine))", "(np.arcsin(sine), np.pi - np.arcsin(sine))"),
        ("if abs(sine) > 1:", "if sine > 1:"),
    ),
    "05_consecutive": (
        ("coriolis = 2 * v_r * w1", "coriolis = v_r * w1"),
        ("for k, angle in enumerate(theta2):", "for k, angle in enumerate(theta2[:-1]):"),
        ("q = saw_position(residual, jacobian, angle, q, tol)", "q = saw_position(residual, jacobian, angle, seed)"),
    ),
    "06_simultaneous": (
        ("transverse = r1 * al1 + 2 * v_r * w1  # with", "transverse = r1 * al1 + v_r * w1  # with"),
        ("[of_acceleration, 2 * of_velocity, own]", "[of_acceleration, of_velocity, own]"),
        ("if error < tol:", "if np.linalg.norm(step[:3]) < tol:"),
        ("one_point(residual, jacobian, crank[:, k], state, tol)", "one_point(residual, jacobian, crank[:, k], seed)"),
    ),
    "07_closed_form": (
        ("np.pi - np.arcsin(sine)", "np.pi + np.arcsin(sine)"),
        ("cannot = np.abs(sine) > 1", "cannot = sine > 1"),
        ("2 * v_r * omega1", "v_r * omega1"),
        ("errors.max(axis=1)", "errors.mean(axis=1)"),
    ),
    "08_wiper_kinematics": (
        ("longest >= shortest + p + q", "longest > shortest + p + q"),
        ("np.stack((r2 * np.sin(theta2), -r3 * np.sin(theta3))", "np.stack((r2 * np.sin(theta2), r3 * np.sin(theta3))"),
        ("iterations.append(steps)", "iterations.append(steps + 1)"),
        ("x1 * n1 + x2 * n2 - x3 * n3", "x1 * n1 + x2 * n2 + x3 * n3"),
        ("F + r4 * blade, F,", "C + r4 * blade, F,"),
    ),
    "09_wiper_inverse_dynamics": (
        ("central + mass * wanted**2", "inertia + mass * wanted**2"),
        ("lengths[4] * rocker", "lengths[3] * rocker"),
        ("needed = bars[:, 1, None] * (accelerations + [0, G])", "needed = bars[:, 1, None] * accelerations"),
        ("system(-size * direction)", "system(size * direction)"),
        ("return x[:, 0],", "return np.abs(x[:, 0]),"),
        ("of_motor + of_loads - moved", "of_motor - of_loads - moved"),
        ("(1, plus[k]), (-1, minus[k])", "(1, plus[k]), (1, minus[k])"),
    ),
    "10_wiper_direct_dynamics": (
        ("right[2] -= torque", "right[2] += torque"),
        ("matrix[moment, min(k, 2)] -= inertia", "matrix[moment, min(k, 2)] -= inertia + mass"),
        ('"DOP853", t, rtol=1e-11, atol=1e-12)', "t_eval=t)"),
        ("GRAVITY * height @ mass", "GRAVITY * height[:, :4] @ mass[:4]"),
        ("np.tanh(speed / v0)", "np.minimum(speed / v0, 1)"),
    ),
    "11_cylinder": (
        ("np.pi - beta - at_o2, at_o4 - beta", "np.pi - beta + at_o2, -at_o4 - beta"),
        ("k2, k4 = cos / (s * sin), 1 / (b * sin)", "k2, k4 = cos * sin / s, sin / b"),
        ("2 * omega2 * v) * across2", "omega2 * v) * across2"),
        ("slope * v**2 / 2, G * lifted", "0 * v, G * lifted"),
        ("if off[term, body] > 0.1 else None", "if off[term, body] > 1e-9 else None"),
    ),
    "12_monte_carlo": (
        ("(rcx + 1j * rcy) * coupler)", "(rcx - 1j * rcy) * coupler)"),
        ("results.std(axis=0, ddof=1)", "results.std(axis=0)"),
        (
            "rng.uniform(nominal - half_width, nominal + half_width, (throws, 6))",
            "rng.normal(nominal, half_width, (throws, 6))",
        ),
        ("np.sum((gradient * half_width) ** 2, axis=2) / 3", "np.sum((gradient * half_width) ** 2, axis=2)"),
        ("np.polyfit(np.log(throws), np.log(error), 1)", "np.polyfit(np.log(error), np.log(throws), 1)"),
        ("if ((coupler / (r1 - A)).imag < 0).any():", "if ((coupler / (r1 - A)).imag < -1).any():"),
    ),
}


def hand_in(folder: Path, students: int, exercises: list[str]) -> set[tuple[str, str]]:
    """Write the submissions; those with a mistake, as (student, exercise)."""
    rng = random.Random(300)
    mistaken = set()
    for exercise in exercises:
        text = (SOLUTIONS / f"{exercise}.ipynb").read_text("utf-8")
        for number in range(students):
            student, handed_in = f"student{number:03d}", text
            if rng.random() < SHARE:
                mistaken.add((student, exercise))
                handed_in = edited(text, *rng.choice(MISTAKES[exercise]))
            (folder / student).mkdir(parents=True, exist_ok=True)
            (folder / student / f"{exercise}.ipynb").write_text(handed_in, "utf-8")
    return mistaken


def edited(notebook: str, right: str, wrong: str) -> str:
    """A notebook with a piece of its code exchanged."""
    right, wrong = (json.dumps(code, ensure_ascii=False)[1:-1] for code in (right, wrong))
    if right not in notebook:
        raise ValueError(f"no solution holds {right!r} any more: mend MISTAKES")
    return notebook.replace(right, wrong)


def lost_points(grades: Path) -> set[tuple[str, str]]:
    """Whose notebook is worth less than it could be, as (student, exercise)."""
    missing = defaultdict(float)
    with open(grades, encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            missing[row["student"], row["exercise"]] += float(row["max"]) - float(row["points"])
    return {key for key, points in missing.items() if points}


def growth(run: Cost) -> tuple[float, float]:
    """Usual MB of the tree in the second fifth of a run, and in the last."""
    early, late = run.between(0.2, 0.4), run.between(0.8, OVER)
    return tuple(statistics.median(sample.tree for sample in part) for part in (early, late))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--students", type=int, default=300)
    parser.add_argument("--exercises", nargs="+", choices=MISTAKES, default=list(MISTAKES))
    parser.add_argument("-j", dest="jobs", type=int, default=2 * len(os.sched_getaffinity(0)))
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        submissions, out = Path(scratch, "submissions"), Path(scratch, "out")
        mistaken = hand_in(submissions, asked.students, asked.exercises)
        command = [*AUTOGRADER, "grade", submissions, "--out", out, "--isolation", "namespaces", "-j", str(asked.jobs)]
        run = cost(list(map(str, command)))
        found = lost_points(out / "grades.csv")
        journal = (out / "journal.sqlite").stat().st_size / MB

    notebooks = asked.students * len(asked.exercises)
    early, late = growth(run)
    table = Table("", "measured", title=f"{asked.students} students, {notebooks} notebooks, -j {asked.jobs}")
    table.add_row("time", f"{run.seconds:.0f} s")
    table.add_row("rate", f"{notebooks / run.seconds:.2f} notebooks/s")
    for percent in (10, 50, 100):
        last = run.between(0, min(percent / 100, OVER))[-1]
        table.add_row(f"memory after {percent} %", f"{last.tree:.0f} MB, of which the judge {last.root:.0f} MB")
    table.add_row("most memory", f"{run.peak:.0f} MB")
    table.add_row("usual memory, second fifth and last", f"{early:.0f} MB, {late:.0f} MB")
    table.add_row("journal", f"{journal:.1f} MB")
    console = Console(soft_wrap=True, highlight=False)
    console.print(table)
    console.print(*(f"{name}: {value}" for name, value in computer().items()), sep=", ")

    void = [
        *(f"{who} made a mistake in {what}, and got full points" for who, what in sorted(mistaken - found)),
        *(f"{who} made no mistake in {what}, and lost points" for who, what in sorted(found - mistaken)),
    ]
    if asked.students >= ENOUGH and late > early + max(GROWTH * early, SLACK):
        void.append(f"memory grew by {late - early:.0f} MB from the second fifth of the run to the last")
    for sentence in void:
        console.print(sentence)
    return 1 if void else 0


if __name__ == "__main__":
    sys.exit(main())
