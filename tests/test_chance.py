"""A right answer drawn by chance is never called wrong, whatever generator drew it; a wrong one is."""

import numpy as np
import pytest

from autograder.chance import FALSE_ALARM, Drawn, bernstein

DISTRIBUTIONS = {
    "uniform": (lambda rng, size: rng.uniform(-1, 1, size), Drawn(0, 1 / np.sqrt(3), 9 / 5, 1)),
    "triangular": (
        lambda rng, size: rng.random(size) + rng.random(size) - 1,
        Drawn(0, 1 / np.sqrt(6), 12 / 5, 1),
    ),
    "a coin that is often heads": (
        lambda rng, size: (rng.random(size) < 0.9) * 1.0,
        Drawn(0.9, 0.3, (1 - 3 * 0.09) / 0.09, 0.9),
    ),
    "a square, skewed": (lambda rng, size: rng.random(size) ** 2, Drawn(1 / 3, np.sqrt(4 / 45), 15 / 7, 2 / 3)),
}
GENERATORS = (np.random.PCG64, np.random.MT19937, np.random.Philox)
EACH = pytest.mark.parametrize("draw, truth", DISTRIBUTIONS.values(), ids=DISTRIBUTIONS)
SUBMISSIONS = [2_000, pytest.param(100_000, marks=pytest.mark.proof)]


@EACH
def test_the_truth_about_a_draw_is_the_truth(draw, truth):
    x = draw(np.random.default_rng(1), 1_000_000)
    assert abs(x.mean() - truth.mean) < 5 * truth.deviation / 1e3
    central = x - truth.mean
    assert np.mean(central**2) == pytest.approx(truth.deviation**2, rel=0.02)
    assert np.mean(central**4) == pytest.approx(truth.kurtosis * truth.deviation**4, rel=0.02)
    assert np.abs(central).max() <= truth.reach


@EACH
@pytest.mark.parametrize("draws", [10, 100, 1000])
@pytest.mark.parametrize("submissions", SUBMISSIONS)
def test_a_right_answer_raises_no_alarm(draw, truth, draws, submissions):
    alarms = 0
    for generator in GENERATORS:
        rng = np.random.Generator(generator(draws))
        for _ in range(10):  # in blocks, for the sake of memory
            x = draw(rng, (submissions // 10, draws))
            alarms += (np.abs(x.mean(1) - truth.mean) > truth.mean_allowance(draws)).sum()
            alarms += (np.abs(x.var(1, ddof=1) - truth.deviation**2) > truth.variance_allowance(draws)).sum()
    assert alarms == 0  # with 95 % confidence fewer than three in so many submissions


@EACH
def test_the_bound_is_a_bound_and_not_a_licence(draw, truth):
    """At a rate that can be seen, the alarms are fewer than stated, and the allowance is not much too wide."""
    rng, draws, rate = np.random.default_rng(2), 200, 0.02
    x = draw(rng, (20_000, draws))
    of_mean = np.mean(np.abs(x.mean(1) - truth.mean) > truth.mean_allowance(draws, rate))
    of_variance = np.mean(np.abs(x.var(1, ddof=1) - truth.deviation**2) > truth.variance_allowance(draws, rate))
    assert of_mean <= rate
    assert of_variance <= rate
    normal = 4.89 * truth.deviation / np.sqrt(draws)  # what a normal approximation would allow, at the same rate
    assert truth.mean_allowance(draws) < 1.5 * normal


@EACH
def test_the_mistakes_of_the_source_raise_an_alarm(draw, truth):
    """Its deviation was up to 2.9 times too large, or a quarter too small; the standard error is another quantity."""
    draws = 10_000
    x = draw(np.random.default_rng(3), draws)
    assert truth.mean_fault(x.mean(), draws) is None
    assert truth.deviation_fault(x.std(ddof=1), draws) is None
    for factor in (2.9, 0.75, 1 / np.sqrt(draws), np.nan, -1):
        assert "standard deviation is" in truth.deviation_fault(factor * x.std(ddof=1), draws)
    for off in (truth.deviation, np.nan, np.inf):
        assert "more than chance does with 10000 draws" in truth.mean_fault(x.mean() + off, draws)


def test_bernstein_solves_its_equation():
    t = bernstein(0.3, 2.0, 50, FALSE_ALARM)
    assert 50 * t**2 == pytest.approx(2 * np.log(2 / FALSE_ALARM) * (0.3 + 2.0 * t / 3))
