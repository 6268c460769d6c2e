"""The stored measurement of the thrown coupler point: what it must show, and that the same throwing is timed."""

import json
import re
from copy import deepcopy
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[1]
STORED = ROOT / "book" / "measured" / "fourbar.json"


@pytest.fixture(scope="module")
def fourbar():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(ROOT / "tests" / "benchmarks")
        import fourbar

        yield fourbar


@pytest.fixture
def found(fourbar):
    """A measurement that just reaches every bound."""
    took = {"mechlib": 1.8, "mechlib, two processes": 1.0, "plain NumPy": 6.1, "a loop, statistics": 1.01}
    return {
        "memory": {"one block": 100.0, "mechlib": 109.9, "plain NumPy": 900.0},
        "ways": {
            name: {"seconds": {str(fourbar.FEW if "loop" in name else fourbar.AT): seconds}, "off": 4.9}
            for name, seconds in took.items()
        },
    }


def test_the_stored_measurement_reached_every_bound_and_is_not_void(fourbar):
    measured = json.loads(STORED.read_text("utf-8"))
    assert fourbar.missed(measured) == []
    assert fourbar.void(measured) == []
    assert measured["long"].keys() == {"one process", "two processes"}


def test_a_loop_of_few_throws_counts_as_if_it_had_made_as_many(fourbar, found):
    times = fourbar.faster(found["ways"], "mechlib, two processes")
    expected = {"mechlib": 1.8, "mechlib, two processes": 1, "plain NumPy": 6.1, "a loop, statistics": 101}
    assert times == pytest.approx(expected)
    assert fourbar.faster(found["ways"])["plain NumPy"] == pytest.approx(6.1 / 1.8)
    assert fourbar.missed(found) == fourbar.void(found) == []


def test_a_measurement_that_misses_a_bound_or_has_other_numbers_is_told_with_its_figure(fourbar, found):
    bad = deepcopy(found)
    bad["ways"]["mechlib, two processes"]["seconds"] = {str(fourbar.AT): 1.1}
    bad["ways"]["plain NumPy"]["off"] = np.nan
    bad["ways"]["mechlib"]["off"] = 5.1
    bad["memory"]["mechlib"] = 111.0
    assert [re.sub(r"\d[\d.]*", "#", sentence) for sentence in fourbar.missed(bad) + fourbar.void(bad)] == [
        "mechlib is # times as fast as a loop, statistics, and # times with two processes, where # was to be reached",
        "mechlib is # times as fast as plain NumPy, and # times with two processes, where # was to be reached",
        "# throws take # MB more than a block, where # were allowed",
        "mechlib is # standard errors off the verified table",
        "plain NumPy is nan standard errors off the verified table",
    ]


def test_every_way_throws_the_lengths_of_source_d(fourbar):
    for way in fourbar.SERIAL.values():
        mean, deviation = way(500)
        assert mean.shape == deviation.shape == (10, 2)
        assert fourbar.off(mean, deviation, 500) < fourbar.SURE


def test_a_sigma_with_the_mistake_of_source_d_would_make_it_void(fourbar):
    published = np.loadtxt(ROOT / "book" / "data" / "fourbar_published.csv", delimiter=",", skiprows=1)
    assert fourbar.off(fourbar.MEAN, published[:, 3:5], 100) > fourbar.SURE


def test_the_memory_of_a_fresh_process_is_its_own(fourbar):
    assert fourbar.peak(fourbar.by_numpy, 200_000) - fourbar.peak(fourbar.by_mechlib, 200_000) > 50


@pytest.mark.parametrize(("worse", "code"), [({}, 0), ({"memory": 120.0}, 1), ({"off": 6.0}, 2)])
def test_the_exit_code_says_what_came_of_it(fourbar, found, monkeypatch, capsys, tmp_path, worse, code):
    found["memory"]["mechlib"] = worse.get("memory", 109.9)
    found["ways"]["mechlib"]["off"] = worse.get("off", 1.0)
    monkeypatch.setattr(fourbar, "of_memory", lambda: found["memory"])
    monkeypatch.setattr(fourbar, "of_ways", lambda *_: found["ways"])
    monkeypatch.setattr(fourbar, "of_long", lambda _: {"one process": {"seconds": 20.0, "held": 150.0}})
    monkeypatch.setattr(fourbar, "ROOT", tmp_path)
    monkeypatch.setattr(fourbar, "KEPT", tmp_path / "measured" / "fourbar.json")
    monkeypatch.setattr("sys.argv", ["fourbar.py", "--keep"])
    assert fourbar.main() == code
    assert fourbar.KEPT.exists() == (code < 2)
    assert "left out: 10000000 throws by plain NumPy" in capsys.readouterr().out
