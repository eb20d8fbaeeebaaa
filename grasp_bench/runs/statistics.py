"""Statistics of success counts, of one run and of two runs on the same trials.

Every command counts successes and few compare runs, so SciPy, slow to import, is left to those.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np


def wilson(successes: int, trials: int, confidence: float = 0.95) -> tuple[float, float]:
    """Return the Wilson score interval of a rate (Wilson 1927, without continuity correction).

    Raises:
        ValueError: unless 0 ≤ successes ≤ trials and trials > 0.
    """
    if trials <= 0 or not 0 <= successes <= trials:
        raise ValueError(f"need 0 ≤ successes ≤ trials and trials > 0, got {successes}/{trials}")
    z2 = NormalDist().inv_cdf((1 + confidence) / 2) ** 2
    failures = trials - successes
    middle = (successes + z2 / 2) / (trials + z2)
    half = math.sqrt(z2 * (successes * failures / trials + z2 / 4)) / (trials + z2)
    return middle - half if successes else 0.0, middle + half if failures else 1.0


@dataclass(frozen=True)
class Rate:
    """Successes among trials; for no trials the rate is 0 and its interval [0, 1]."""

    successes: int
    trials: int

    @property
    def rate(self) -> float:
        """Successes over trials."""
        return self.successes / self.trials if self.trials else 0.0

    @property
    def interval(self) -> tuple[float, float]:
        """95 % Wilson score interval."""
        return wilson(self.successes, self.trials) if self.trials else (0.0, 1.0)

    def __str__(self) -> str:
        low, high = self.interval
        return f"{self.successes}/{self.trials} = {self.rate:.1%} (95 % interval {low:.1%} – {high:.1%})"

    def to_json(self) -> dict[str, Any]:
        """Return plain data: the counts, the rate and its interval."""
        return self.counts() | {"rate": self.rate, "wilson95": list(self.interval)}

    def counts(self) -> dict[str, int]:
        """Return plain data: the counts alone."""
        return {"successes": self.successes, "trials": self.trials}


def mcnemar(first_only: int, second_only: int) -> float:
    """Return the two-sided exact p-value of McNemar's test for paired trials.

    Args:
        first_only, second_only: trials in which only the one or the other succeeded.
    """
    from scipy.stats import binomtest

    discordant = first_only + second_only
    return 1.0 if discordant == 0 else float(binomtest(first_only, discordant, 0.5).pvalue)


def mcnemar_worse(lost: int, gained: int) -> float:
    """Return the one-sided exact p-value of McNemar's test that a success became less likely.

    Among the trials in which exactly one of two runs succeeded, each is as likely as the other
    where nothing changed; the p-value is the probability of so many losses or more.

    Args:
        lost, gained: trials in which only the old run, and only the new run, succeeded.
    """
    from scipy.stats import binom

    return float(binom.sf(lost - 1, lost + gained, 0.5))


class Pairs(NamedTuple):
    """Pairs of trials of two runs: in how many only the old, and only the new run succeeded, and all."""

    lost: int
    gained: int
    trials: int

    @property
    def difference(self) -> float:
        """New rate minus old rate."""
        return (self.gained - self.lost) / self.trials


def tango_score(pairs: Pairs, difference: float) -> float:
    """Return Tango's score statistic that the rates differ by ``difference`` (new − old); N(0, 1) if so.

    T. Tango, “Equivalence test and confidence interval for the difference in proportions for the
    paired-sample design”, Statistics in Medicine 17 (1998) 891–908, eqs. (24)–(26): the variance
    is that of the maximum-likelihood estimate under the hypothesis, so that it stays honest where
    few pairs are discordant.

    Args:
        pairs: the counts.
        difference: a number in (−1, 1).
    """
    gained, lost, n = pairs.gained, pairs.lost, pairs.trials
    a = 2 * n
    b = -gained - lost + (2 * n - gained + lost) * difference
    c = -lost * difference * (1 - difference)
    only_old = max((math.sqrt(max(b * b - 4 * a * c, 0.0)) - b) / (2 * a), 0.0)
    variance = n * (2 * only_old + difference * (1 - difference))
    distance = gained - lost - n * difference
    if variance <= 0:
        return 0.0 if distance == 0 else math.copysign(math.inf, distance)
    return distance / math.sqrt(variance)


def paired_interval(pairs: Pairs, confidence: float = 0.95) -> tuple[float, float]:
    """Return Tango's score interval of the difference of paired rates (new − old).

    Its lower limit with confidence 1 − 2α decides the non-inferiority test at level α.

    Raises:
        ValueError: for counts that cannot be.
    """
    from scipy.optimize import brentq

    if pairs.trials <= 0 or min(pairs) < 0 or pairs.lost + pairs.gained > pairs.trials:
        raise ValueError(f"need 0 ≤ lost + gained ≤ trials and trials > 0, got {pairs}")
    z = NormalDist().inv_cdf((1 + confidence) / 2)
    edge = 1 - 1e-12
    estimate = pairs.difference

    def limit(sign: float) -> float:
        def excess(difference: float) -> float:
            return tango_score(pairs, difference) - sign * z

        end = -sign * edge
        if abs(estimate) >= edge and estimate * sign < 0:
            return -sign
        low, high = sorted((end, min(max(estimate, -edge), edge)))
        if excess(low) * excess(high) > 0:
            return -sign * 1.0
        return float(brentq(excess, low, high, xtol=1e-12))

    return limit(1.0), limit(-1.0)


def non_inferiority(pairs: Pairs, margin: float) -> float:
    """Return the one-sided p-value that the rate dropped by ``margin`` or more (Tango's score)."""
    return float(1 - NormalDist().cdf(tango_score(pairs, -margin)))


def holm(p_values: Sequence[float]) -> list[float]:
    """Return p-values adjusted for their number, in the order given.

    S. Holm, “A simple sequentially rejective multiple test procedure”, Scandinavian Journal of
    Statistics 6 (1979) 65–70.
    """
    adjusted, largest = [0.0] * len(p_values), 0.0
    for rank, i in enumerate(sorted(range(len(p_values)), key=lambda k: p_values[k])):
        largest = max(largest, min(1.0, (len(p_values) - rank) * p_values[i]))
        adjusted[i] = largest
    return adjusted


# ---------------------------------------------------------------- what a number of trials can see


def power_of_drop(trials: int, drop: float, gained: float, alpha: float = 0.05) -> float:
    """Return the probability that McNemar's exact one-sided test sees a drop.

    Args:
        trials: number of pairs.
        drop: old rate minus new rate.
        gained: share of pairs that only the new run wins; ``drop + gained`` are lost.
        alpha: level of the test.
    """
    from scipy.stats import binom

    lost = drop + gained
    discordant = lost + gained
    if min(lost, gained) < 0 or discordant > 1:
        raise ValueError(f"impossible shares: {lost} lost and {gained} gained")
    if discordant == 0:
        return 0.0
    middle, spread = trials * discordant, 10 * math.sqrt(trials * discordant * (1 - discordant)) + 10
    m = np.arange(max(0, int(middle - spread)), min(trials, int(middle + spread)) + 1)
    critical = binom.isf(alpha, m, 0.5) + 1  # losses from which on the test rejects
    return float(np.sum(binom.pmf(m, trials, discordant) * binom.sf(critical - 1, m, lost / discordant)))


def visible_drop(
    trials: int, rate: float, gained: float | None = None, alpha: float = 0.05, power: float = 0.8
) -> float | None:
    """Return the smallest drop of the rate that ``trials`` pairs show with probability ``power``; or None.

    Args:
        trials: number of pairs.
        rate: rate of the old run.
        gained: share of pairs that only the new run wins; by default that of two runs that have
            nothing to do with each other, which is the worst case of positively correlated ones.
        alpha, power: level and power of McNemar's exact one-sided test.
    """
    from scipy.optimize import brentq

    def reached(drop: float) -> float:
        new = rate - drop
        g = (1 - rate) * new if gained is None else min(gained, 1 - rate, new)
        return power_of_drop(trials, drop, max(g, 0.0), alpha) - power

    if rate <= 0 or reached(rate) < 0:
        return None
    return float(brentq(reached, 0.0, rate, xtol=1e-5))


def trials_to_distinguish(
    first_only: float, second_only: float, alpha: float = 0.05, power: float = 0.8
) -> int | None:
    """Return the pairs after which McNemar's two-sided test tells two rates apart with chance ``power``.

    R. J. Connor, “Sample size for testing differences in proportions for the paired-sample
    design”, Biometrics 43 (1987) 207–211. None where the shares are equal.

    Args:
        first_only, second_only: shares of the pairs in which only the one or the other succeeds.
        alpha, power: level and power of the test.

    Raises:
        ValueError: for shares that cannot be.
    """
    discordant, difference = first_only + second_only, first_only - second_only
    if min(first_only, second_only) < 0 or discordant > 1:
        raise ValueError(f"impossible shares: {first_only} and {second_only}")
    if difference == 0:
        return None
    quantile = NormalDist().inv_cdf
    reach = quantile(1 - alpha / 2) * math.sqrt(discordant) + quantile(power) * math.sqrt(
        discordant - difference**2
    )
    return math.ceil((reach / difference) ** 2)


def trials_to_exclude(
    margin: float, lost: float, gained: float, alpha: float = 0.05, power: float = 0.8
) -> int | None:
    """Return the pairs that exclude a drop of ``margin`` or more with probability ``power``; None if none do.

    By the normal approximation of the score test, with the shares of pairs lost and gained as given.
    """
    distance = margin - (lost - gained)
    if distance <= 0:
        return None
    quantile = NormalDist().inv_cdf
    variance = lost + gained - (lost - gained) ** 2
    at_margin = max(lost + gained, margin) - margin**2
    reach = quantile(1 - alpha) * math.sqrt(at_margin) + quantile(power) * math.sqrt(variance)
    return math.ceil((reach / distance) ** 2)
