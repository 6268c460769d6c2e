"""The stored measurement of the wiper's dynamics: what it must show, and that what is timed is the same motion."""

import json
import re
from copy import deepcopy
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[1]
STORED = ROOT / "book" / "measured" / "wiper.json"


@pytest.fixture(scope="module")
def measured():
    return json.loads(STORED.read_text("utf-8"))


@pytest.fixture(scope="module")
def wiper():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT / "tests" / "benchmarks")
        import wiper

        yield wiper


def test_the_stored_measurement_reached_every_bound_and_is_not_void(wiper, measured):
    assert wiper.missed(measured) == []
    assert wiper.void(measured) == []
    assert wiper.compared(measured["direct"]) == measured["compared"]


def test_a_measurement_that_misses_a_bound_or_has_other_numbers_is_told_with_its_figure(wiper, measured):
    slow = deepcopy(measured)
    slow["turn"]["mechlib, all points at once"]["seconds"] *= 1000
    slow["turn"]["a loop, closed form"]["off"] = 1e-3
    slow["direct"]["coasting"][wiper.EXUDYN][-1]["off"] = 0.01
    said = wiper.missed(slow) + wiper.void(slow)
    assert [re.sub(r"\d[\d.]*(e-\d+)?", "#", sentence) for sentence in said] == [
        "all points at once are # times as fast as a loop, scipy.optimize.root, where # was to be reached",
        "all points at once are # times as fast as a loop, closed form, where # was to be reached",
        "a loop, closed form is # off",
        "coasting: Exudyn is # off at its finest",
    ]


def test_a_way_counts_from_where_it_stays_within_the_error(wiper):
    runs = [{"motion a second": motion, "off": off} for motion, off in ((9, 2e-5), (8, 3e-3), (7, 2e-4), (6, 5e-5))]
    assert list(wiper.compared({"it": {"way": runs}}).values()) == [{"way": 7}, {"way": 6}, {"way": None}]


def test_fifteen_equations_written_out_by_hand_point_by_point_give_the_same_torque_and_forces(wiper):
    at_once, *loops = (way() for way in wiper.TURN.values())
    assert at_once.shape == (361, 15)
    for loop in loops:
        assert np.abs(loop - at_once).max() < 1e-11


@pytest.mark.parametrize(("name", "instants"), [("run_up", 21), ("coasting", 6)])
def test_what_is_timed_is_the_motion_of_the_stored_table(wiper, name, instants):
    case = wiper.cases()[name]
    stored = np.loadtxt(ROOT / "book" / "engine" / f"wiper_{name}.csv", delimiter=",")[:instants]
    for coordinates in ("input", "all"):
        np.testing.assert_allclose(case.by_mechlib(stored[:, 0], coordinates, 1e-6), stored[:, 2], rtol=3e-3, atol=1e-3)
    np.testing.assert_allclose(case.engine(case.steps[0])[:instants, 2], stored[:, 2], rtol=3e-2, atol=1e-3)
