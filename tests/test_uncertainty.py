"""Spread of a result: against integrals, repeated draws, and the verified table of source D."""

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import scipy.stats
from hypothesis import given, settings
from hypothesis import strategies as st

from mechlib.fourbar import LENGTHS, FourBar
from mechlib.implicit import Quantities
from mechlib.laws import Correlated, Given, Independent, Normal, Uniform, tolerances
from mechlib.moments import Moments
from mechlib.uncertainty import OpenThrowsError, Varied, linear, monte_carlo, quasi_monte_carlo, throw

TABLE = np.loadtxt(Path(__file__).parents[1] / "book" / "data" / "fourbar_verified.csv", delimiter=",", skiprows=1)
THETA2, SIGMA = TABLE[:, 0], TABLE[:, 3:5]
VERIFIED = 1_000_000  # throws of the table
LINKAGE = FourBar()
POINT = Varied(LINKAGE, LENGTHS, partial(FourBar.coupler_point, theta2=THETA2[:, None], open_points="leave out"))
LAW = tolerances(POINT.nominal, 1e-5)


def derivatives(linkage=LINKAGE):
    quantities = Quantities.of(FourBar, FourBar.symbols["P"], FourBar.parameters[:6])
    return quantities.gradient(linkage, THETA2, linkage.position(THETA2))


# --- the four-bar linkage of source D


def test_source_d_deviations_are_those_of_the_verified_table_within_both_sampling_errors():
    throws = 200_000
    found = monte_carlo(POINT, LAW, throws).moments
    error = np.sqrt((found.kurtosis - 1) / 4 * (1 / throws + 1 / VERIFIED))  # of a deviation, in parts of it
    assert (np.abs(found.deviation / SIGMA - 1) < 5 * error).all()  # twenty of them: five is one chance in 1e5
    mean_error = SIGMA * np.sqrt(1 / throws + 1 / VERIFIED)
    assert (np.abs(found.mean - TABLE[:, 1:3]) < 5 * mean_error).all()


def test_linear_propagation_agrees_with_the_verified_table_to_four_digits():
    spread = linear(derivatives(), LAW)
    np.testing.assert_allclose(spread.deviation, TABLE[:, 5:], rtol=5e-5)
    np.testing.assert_allclose(spread.deviation, SIGMA, rtol=5 / np.sqrt(2 * VERIFIED))


def test_derivatives_are_differences_of_linkages_closed_anew():
    step = 1e-5
    found = derivatives()
    for k, name in enumerate(LENGTHS):
        before, after = (replace(LINKAGE, **{name: getattr(LINKAGE, name) + d}) for d in (-step, step))
        slope = (after.coupler_point(THETA2) - before.coupler_point(THETA2)) / (2 * step)
        np.testing.assert_allclose(found[..., k], slope, atol=1e-8)


def test_in_a_singular_position_the_unknowns_cannot_follow():
    flat = FourBar(r1=1.0, r2=0.5, r3=0.25, r4=0.25)
    quantities = Quantities.of(FourBar, FourBar.symbols["P"], FourBar.parameters[:4])
    with pytest.raises(ZeroDivisionError, match="singular position at point 0, theta_2 = 0"):
        quantities.gradient(flat, 0.0, flat.position(0.0))
    with pytest.raises(ValueError, match="omega_2 is no parameter and no position of FourBar"):
        Quantities.of(FourBar, [FourBar.closure.input.velocity], FourBar.parameters)


def test_each_length_has_its_share_of_the_variance():
    spread = linear(derivatives(), LAW)
    np.testing.assert_allclose(spread.shares.sum(axis=-1), 1, rtol=1e-14)
    for k, nominal in enumerate(POINT.nominal):
        without = Independent((*LAW.laws[:k], Uniform(nominal, 0.0), *LAW.laws[k + 1 :]))
        left = quasi_monte_carlo(POINT, without, 256, sets=2).deviation
        whole = quasi_monte_carlo(POINT, LAW, 256, sets=2).deviation
        np.testing.assert_allclose(spread.shares[..., k], 1 - (left / whole) ** 2, atol=5e-3)


# --- laws


@pytest.mark.parametrize(
    ("law", "distribution"),
    [
        (Uniform(2.0, 0.5), scipy.stats.uniform(1.5, 1.0)),
        (Normal(-1.0, 0.3), scipy.stats.norm(-1.0, 0.3)),
        (Given(scipy.stats.triang(0.2)), scipy.stats.triang(0.2)),
    ],
    ids=["uniform", "normal", "given"],
)
def test_a_law_has_the_mean_the_deviation_and_the_quantiles_it_says(law, distribution):
    unit = np.linspace(0.01, 0.99, 99)
    np.testing.assert_allclose(distribution.cdf(law.quantile(unit)), unit, atol=1e-12)
    middles = law.quantile((np.arange(200_000) + 0.5) / 200_000)
    assert middles.mean() == pytest.approx(law.mean, abs=1e-5)
    assert middles.std() == pytest.approx(law.deviation, rel=1e-4)


@pytest.mark.parametrize("law", [Normal(0, 1), Given(scipy.stats.norm()), Correlated([0.0], [[1.0]])])
def test_no_law_leaves_the_numbers_at_the_edge_of_the_cube(law):
    edge = np.array([[0.0], [1 - 2.0**-53]])
    thrown = law.throw(edge) if isinstance(law, Correlated) else law.quantile(edge)
    assert np.isfinite(thrown).all()


@given(st.integers(1, 5), st.integers(0, 2**32 - 1))
@settings(max_examples=25)
def test_correlated_throws_have_the_covariance_asked_for(k, seed):
    rng = np.random.default_rng(seed)
    mix = rng.standard_normal((k, k)) * 10.0 ** rng.integers(-4, 4, k)[:, None]
    mix[:, 0] *= rng.integers(0, 2)  # now and then without full rank
    covariance = mix @ mix.T
    law = Correlated(rng.standard_normal(k), (covariance + covariance.T) / 2)
    thrown = law.throw(scipy.stats.qmc.Sobol(k, rng=rng).random(4096))
    scale = np.sqrt(np.diag(law.covariance))
    scale = np.where(scale > 0, scale, 1.0)
    found, expected = (each / np.outer(scale, scale) for each in (np.cov(thrown.T).reshape(k, k), law.covariance))
    np.testing.assert_allclose(found, expected, atol=0.06)
    np.testing.assert_allclose((thrown.mean(axis=0) - law.mean) / scale, 0, atol=0.02)


def test_correlation_enters_the_linear_propagation_and_the_throws_alike():
    tied = LAW.covariance.copy()
    tied[:4, :4] = 1e-10 / 3 * (0.2 * np.eye(4) + 0.8)  # bars cut in one clamping
    law = Correlated(POINT.nominal, tied)
    found, expected = monte_carlo(POINT, law, 100_000).moments.deviation, linear(derivatives(), law)
    np.testing.assert_allclose(found, expected.deviation, rtol=5 / np.sqrt(2 * 100_000))
    assert np.abs(expected.deviation / linear(derivatives(), LAW).deviation - 1).max() > 0.1
    with pytest.raises(ValueError, match="depend on one another"):
        _ = expected.shares


# --- throws and their moments


def test_a_throw_is_the_same_whoever_makes_it_and_however_many_follow():
    seen = []

    def watched(parameters):
        seen.append(parameters)
        return parameters

    monte_carlo(watched, LAW, 5000, seed=3, block=1024)
    few = throw(LAW, 0, 5000, seed=3, block=1024)
    np.testing.assert_array_equal(np.concatenate(seen), few)
    np.testing.assert_array_equal(throw(LAW, 1000, 3000, seed=3, block=1024), few[1000:3000])
    assert not (throw(LAW, 0, 5000, seed=4, block=1024) == few).any()


def test_throws_are_independent_between_parameters_and_blocks():
    thrown = throw(tolerances(np.zeros(6), 1.0), 0, 1 << 16)
    spread = scipy.stats.kstest(thrown.ravel(), scipy.stats.uniform(-1, 2).cdf)
    assert spread.pvalue > 1e-6
    blocks = thrown.reshape(32, -1)  # of 2048 throws: no block may be like another
    assert np.abs(np.corrcoef(blocks) - np.eye(32)).max() < 6 / np.sqrt(blocks.shape[1])
    assert np.abs(np.corrcoef(thrown.T) - np.eye(6)).max() < 6 / np.sqrt(len(thrown))


@given(st.lists(st.integers(1, 40), min_size=1, max_size=6), st.integers(0, 2**32 - 1))
def test_moments_of_pieces_are_those_of_the_whole(sizes, seed):
    rng = np.random.default_rng(seed)
    pieces = [rng.exponential(size=(n, 2, 3)) + 1e4 * rng.random() for n in sizes]
    merged, whole = Moments.merged([Moments.of(piece) for piece in pieces]), np.concatenate(pieces)
    off = whole - whole.mean(axis=0)
    assert merged.throws == len(whole)
    np.testing.assert_allclose(merged.mean, whole.mean(axis=0), rtol=1e-14)
    for power, name in ((2, "second"), (3, "third"), (4, "fourth")):
        scale = (np.abs(off) ** power).sum(axis=0) + 1e-9 ** (power - 1)
        np.testing.assert_allclose(getattr(merged, name) / scale, (off**power).sum(axis=0) / scale, atol=1e-6)


def test_skewness_and_kurtosis_are_those_of_the_law():
    law = Independent((Given(scipy.stats.expon()), Uniform(0, 1), Normal(0, 1)))
    found = monte_carlo(lambda parameters: parameters, law, 1_000_000).moments
    np.testing.assert_allclose(found.skewness, [2, 0, 0], atol=0.05)
    np.testing.assert_allclose(found.kurtosis, [9, 9 / 5, 3], rtol=0.05)


def test_a_mean_of_large_numbers_with_small_deviations_loses_no_digits():
    found = monte_carlo(lambda parameters: 1e6 + parameters, tolerances([0.0], 1e-5), 100_000).moments
    assert found.deviation[0] == pytest.approx(1e-5 / np.sqrt(3), rel=0.01)


# --- intervals

LAWS = {
    "uniform": lambda rng, shape: rng.random(shape),
    "normal": lambda rng, shape: rng.standard_normal(shape),
    "sum of three uniform": lambda rng, shape: rng.random((3, *shape)).sum(axis=0),
    "triangular": lambda rng, shape: rng.triangular(0, 0.2, 1, shape),
}
TRUTH = {
    "uniform": (0.5, 1 / 12),
    "normal": (0, 1),
    "sum of three uniform": (1.5, 1 / 4),
    "triangular": (0.4, 0.84 / 18),
}


@pytest.mark.parametrize("throws", [100, 1000])
@pytest.mark.parametrize("law", LAWS)
def test_intervals_of_95_percent_hold_the_truth_in_95_percent_of_10_000_repetitions(law, throws):
    rng = np.random.default_rng(95)
    covered = np.zeros(2)
    for _ in range(10):
        moments = Moments.of(LAWS[law](rng, (throws, 1000)))
        mean, variance = TRUTH[law]
        for k, (true, (low, high)) in enumerate(
            ((mean, moments.mean_interval()), (np.sqrt(variance), moments.deviation_interval()))
        ):
            covered[k] += ((low <= true) & (true <= high)).sum()
    assert (np.abs(covered / 10_000 - 0.95) <= 0.01).all(), covered


def test_intervals_hold_the_coupler_point_of_source_d_in_95_percent_of_10_000_repetitions_of_its_100_throws():
    repetitions, truth = 10_000, quasi_monte_carlo(POINT, LAW, 1 << 14, sets=4)
    covered = np.zeros((2, len(THETA2), 2))
    for start in range(0, 100 * repetitions, 50_000):
        results = POINT(throw(LAW, start, start + 50_000, seed=12))
        moments = Moments.of(results.reshape(-1, 100, len(THETA2), 2).swapaxes(0, 1))
        for k, (true, (low, high)) in enumerate(
            ((truth.mean, moments.mean_interval()), (truth.deviation, moments.deviation_interval()))
        ):
            covered[k] += ((low <= true) & (true <= high)).sum(axis=0)
    assert (np.abs(covered / repetitions - 0.95) <= 0.01).all(), covered


def test_the_usual_interval_by_chi_squared_does_not_hold_for_uniform_results():
    moments = Moments.of(np.random.default_rng(1).random((100, 10_000)))
    low, high = (np.sqrt(99 * moments.deviation**2 / scipy.stats.chi2(99).ppf(p)) for p in (0.975, 0.025))
    assert ((low <= np.sqrt(1 / 12)) & (np.sqrt(1 / 12) <= high)).mean() > 0.99


# --- rates


def slope(n, errors):
    return np.polyfit(np.log(n), np.log(errors), 1)[0]


def test_the_error_falls_with_the_root_of_the_throws_and_nearly_with_the_points_of_sobol():
    exact = quasi_monte_carlo(POINT, LAW, 1 << 14, sets=8, seed=99).mean
    sizes = 2 ** np.arange(6, 12)
    by_chance = [
        np.sqrt(np.mean([(monte_carlo(POINT, LAW, n, s).moments.mean - exact) ** 2 for s in range(40)])) for n in sizes
    ]
    evenly = [np.sqrt(np.mean((quasi_monte_carlo(POINT, LAW, int(n), sets=12).means - exact) ** 2)) for n in sizes]
    assert slope(sizes, by_chance) == pytest.approx(-0.5, abs=0.07)
    assert slope(sizes, evenly) < -0.85
    assert evenly[-1] < by_chance[-1] / 10


def test_evenly_spread_points_know_how_sure_they_are():
    def volume(x):
        return np.prod(1 + x, axis=1, keepdims=True)

    law = tolerances(np.full(3, 0.5), 0.5)  # the unit cube
    covered = 0
    for seed in range(100):
        low, high = quasi_monte_carlo(volume, law, 64, seed=seed, sets=8).mean_interval()
        covered += int(low[0] <= 1.5**3 <= high[0])
    assert covered >= 82  # 95 % of 100, less six deviations of the count


# --- any mechanism


def test_a_tolerance_that_lets_the_loop_open_says_in_how_many_throws_and_in_which():
    near = replace(LINKAGE, r1=0.42259 + 0.964444 - 0.58781 + 0.26)
    point = replace(POINT, machine=near)
    law = tolerances(point.nominal, 0.15)
    with pytest.raises(OpenThrowsError) as caught:
        monte_carlo(point, law, 5000)
    open_throws = [n for n, lengths in enumerate(throw(law, 0, 5000)) if (FourBar(*lengths).gap(THETA2) > 0).any()]
    assert caught.value.count == len(open_throws) > 20
    assert list(caught.value.first) == open_throws[:10]
    assert str(caught.value).startswith(f"{len(open_throws)} of 5000 throws have no result")
    assert f"number {', '.join(map(str, open_throws[:10]))}, ..." in str(caught.value)
    left = monte_carlo(point, law, 5000, open_throws="leave out")
    assert (left.open, left.moments.throws) == (len(open_throws), 5000 - len(open_throws))
    assert np.isfinite(left.moments.deviation).all()
    with pytest.raises(OpenThrowsError):
        quasi_monte_carlo(point, law, 1024)


def test_where_no_throw_has_a_result_there_is_no_mean():
    with pytest.raises(OpenThrowsError, match="100 of 100 throws"):
        monte_carlo(lambda x: np.full(len(x), np.nan), LAW, 100, open_throws="leave out")


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Uniform(1.0, -0.1), "half_width must not be negative or without limit, got -0.1"),
        (lambda: Normal(np.nan, 0.1), "mean must be finite, got nan"),
        (lambda: Given(scipy.stats.cauchy()), "must be finite, got nan"),
        (lambda: Correlated([1.0, 2.0], np.eye(3)), r"covariance must be \(2, 2\), as the mean has it; got \(3, 3\)"),
        (lambda: Correlated([1.0, 2.0], [[1, 0.5], [0.4, 1]]), "symmetric, got 0.5 at 0, 1 and 0.4 at 1, 0"),
        (lambda: Correlated([1.0, 2.0], [[1, 2], [2, 1]]), "no sum of parameters a negative variance, got -1 for"),
        (lambda: Correlated([1.0], [[-1.0]]), "negative variance"),
        (lambda: Correlated([1.0], [[np.nan]]), "covariance must be finite, got nan at index 0, 0"),
        (lambda: monte_carlo(POINT, LAW, 0), "throws must be a positive whole number, got 0"),
        (lambda: monte_carlo(POINT, LAW, 10, block=0), "block must be a positive whole number, got 0"),
        (lambda: monte_carlo(lambda x: x.sum(), LAW, 10), r"throws as its first axis, 10; got the shape \(\)"),
        (
            lambda: monte_carlo(POINT, LAW, 10, open_throws="drop"),
            "open_throws must be 'refuse' or 'leave out', got 'drop'",
        ),
        (lambda: monte_carlo(POINT, tolerances(POINT.nominal, 1.0), 99), "r. must be a positive number, got -0"),
        (lambda: quasi_monte_carlo(POINT, LAW, 100), "points must be a power of two, got 100"),
        (lambda: quasi_monte_carlo(POINT, LAW, 128, sets=1), "sets must be at least 2, got 1"),
        (lambda: linear(np.zeros((2, 5)), LAW), r"\(..., results, 6 parameters\), got \(2, 5\)"),
        (lambda: monte_carlo(POINT, LAW, 9).moments.mean_interval(95), "level must be between 0 and 1, got 95"),
        (lambda: monte_carlo(POINT, LAW, 1).moments.mean_interval(), "at least 2 throws, got 1"),
    ],
)
def test_bad_input_is_refused_in_one_sentence_with_the_value(make, says):
    with pytest.raises(ValueError, match=says):
        make()
