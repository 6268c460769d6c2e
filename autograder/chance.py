"""Answers drawn by chance: how far a right one may lie from the truth, at a stated rate of false alarms.

The bounds are Bernstein's inequality, which holds for every bounded distribution and every number of draws, where the
normal approximation promises nothing so far out in the tails. They know no generator and no seed.
"""

from dataclasses import dataclass
from math import isfinite, log, sqrt

FALSE_ALARM = 1e-6  # of one comparison, at most


@dataclass(frozen=True)
class Drawn:
    """The truth about one draw.

    Attributes
    ----------
    mean, deviation : float
        In units of the draw.
    kurtosis : float
        Fourth central moment over the fourth power of the deviation: 9/5 for a uniform draw, 3 for a normal one.
    reach : float
        No draw lies further from the mean.
    """

    mean: float
    deviation: float
    kurtosis: float
    reach: float

    def mean_allowance(self, draws: int, alarm: float = FALSE_ALARM) -> float:
        """How far the mean of so many draws may lie from the true one."""
        return bernstein(self.deviation**2, self.reach, draws, alarm)

    def variance_allowance(self, draws: int, alarm: float = FALSE_ALARM) -> float:
        """How far the variance of so many draws, divided by their number less one, may lie from the true one.

        It is the mean of the squared distances from the true mean, which is bounded as any mean is, less the square of
        the mean's own error; each of the two takes half of the false alarms.
        """
        spread = self.deviation**4 * (self.kurtosis - 1)
        squares = bernstein(spread, max(self.reach**2, self.deviation**2), draws, alarm / 2)
        error_of_mean = self.mean_allowance(draws, alarm / 2)
        return (draws * (squares + error_of_mean**2) + self.deviation**2) / (draws - 1)

    def mean_fault(self, answer: float, draws: int, alarm: float = FALSE_ALARM) -> str | None:
        """Why an answer is not the mean of so many draws; None if it may be."""
        off = abs(answer - self.mean)
        if isfinite(off) and off <= self.mean_allowance(draws, alarm):
            return None
        off /= self.deviation
        return f"its mean is off by {off:.2g} standard deviations, more than chance does with {draws} draws"

    def deviation_fault(self, answer: float, draws: int, alarm: float = FALSE_ALARM) -> str | None:
        """Why an answer is not the standard deviation of so many draws; None if it may be."""
        off = abs(answer**2 - self.deviation**2)
        if isfinite(off) and answer >= 0 and off <= self.variance_allowance(draws, alarm):
            return None
        return (
            f"its standard deviation is {answer / self.deviation:.2g} times the true one, "
            f"more than chance does with {draws} draws"
        )


def bernstein(variance: float, reach: float, draws: int, alarm: float) -> float:
    """What the mean of bounded, independent draws exceeds, to either side, with a probability of `alarm` at most.

    Parameters
    ----------
    variance : float
        Of one draw.
    reach : float
        Largest distance of a draw from the mean.
    draws : int
    alarm : float

    Returns
    -------
    float
        The positive solution t of draws t^2 = 2 L (variance + reach t / 3), with L = log(2 / alarm).

    References
    ----------
    S. Boucheron, G. Lugosi, P. Massart, Concentration Inequalities, 2013, corollary 2.11.
    """
    share = log(2 / alarm) / draws
    return share * reach / 3 + sqrt((share * reach / 3) ** 2 + 2 * share * variance)
