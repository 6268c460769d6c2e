"""The stored measurement of the hacksaw's sweeps: what it must show, and that the page can show it."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[1]
STORED = ROOT / "book" / "measured" / "hacksaw.json"


@pytest.fixture(scope="module")
def measured():
    return json.loads(STORED.read_text("utf-8"))


@pytest.fixture(scope="module")
def sweeps():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT / "tests" / "benchmarks")
        import sweeps

        yield sweeps


def seconds(measured):
    return {name: way["seconds"] for name, way in measured["ways"].items()}


def test_the_stored_measurement_reached_every_bound(sweeps, measured):
    assert sweeps.missed(measured) == []
    assert all(way["off"] < 1e-12 for way in measured["ways"].values() if "off" in way)


def test_a_measurement_that_misses_a_bound_is_told_with_its_figure(sweeps, measured):
    slow = json.loads(json.dumps(measured))
    slow["ways"]["batched Newton"]["seconds"] *= 1000
    slow["growth"][-1]["seconds"] *= 10
    slow["growth"][-1]["beside it, MB"] += 500
    said = sweeps.missed(slow)
    assert [re.sub(r"[\d.]+", "#", sentence) for sentence in said] == [
        "batched Newton is # times as fast as the loop, where # was to be reached",
        "batched Newton takes # times as long as the closed form, where # is allowed",
        "the time is not in proportion: # to # us a point",
        "the memory beside the result grows from # to # MB",
    ]


def test_every_way_gives_the_same_nine_numbers(sweeps):
    motion = sweeps.run_up(60)
    exact = sweeps.by_closed_form(motion)
    for way in (sweeps.by_batched, sweeps.by_consecutive, sweeps.by_simultaneous, sweeps.by_scipy):
        assert np.abs(way(motion) - exact).max() < 1e-12


@pytest.mark.parametrize("form", ["symbolic", "compiled", "linear"])
def test_both_solvers_of_source_a_find_the_motion_in_every_form_that_is_timed(sweeps, form):
    solve = {"symbolic": sweeps.symbolic, "compiled": sweeps.compiled, "linear": lambda: sweeps.compiled(linear=True)}
    motion = sweeps.run_up(2 if form == "symbolic" else 40)
    ends = []

    def spy(solve_stage):
        def solved(stage, *rest):
            found = solve_stage(stage, *rest)
            ends.append((stage, found))
            return found

        return solved

    exact = sweeps.by_closed_form(motion)
    for together in (False, True):
        ends.clear()
        spent = sweeps.source_a(spy(solve[form]()), motion, together)
        assert len(spent) == len(motion)
        assert (np.diff(spent) > 0).all()
        found = (
            [x for stage, x in ends if stage == 3]
            if together
            else np.split(np.concatenate([x for _, x in ends]), len(motion))
        )
        np.testing.assert_allclose(found, exact, atol=1e-9)


def test_a8_twelve_per_cent_are_no_property_of_the_simultaneous_solver(measured):
    """By substitution it takes several times as long; compiled it gains only where linear systems are iterated."""
    way, total = seconds(measured), {name: curve[-1] for name, curve in measured["cumulative"].items()}
    assert way["symbolic, simultaneous"] > 2 * way["symbolic, consecutive"]
    assert total["compiled, simultaneous"] > total["compiled, linear stages solved once"]


def test_where_the_loop_cannot_close_mechlib_gives_no_number_and_stays_on_its_branch(measured):
    found = measured["open"]
    assert (found["open"], found["closed"]) == (181, 819)
    assert found["mechlib"] == {"numbers where it is open": 0, "elsewhere": 0}
    assert any(other.get("elsewhere") for name, other in found.items() if isinstance(other, dict) and name != "mechlib")
