"""Tests by betting: evidence on a mean that stays valid however often one looks and whenever one stops.

A gambler who does not believe that the mean of independent numbers d in [−1, 1] is at most m stakes a share
of the capital on every one. Where the mean is m or less the game is not in the gambler's favour, so that the
capital, a non-negative supermartingale that begins at 1, ever reaches 1/α with probability α at most (J.
Ville, “Étude critique de la notion de collectif”, 1939). I. Waudby-Smith & A. Ramdas, “Estimating means of
bounded random variables by betting”, J. R. Stat. Soc. B 86 (2024) 1–27, make tests (sections 2 and 4) and
confidence sequences of it. The stakes here are a mixture of fixed ones, which needs no tuning and does not
depend on the order of the numbers.

A stake of λ is the best one where the mean is λ times the mean square, and then pays off after some
2 log(2/α)/(λ · mean) numbers. In races of a few hundred items that is stakes of 0.3 and more: there, the
mixture's density is proportional to the stake (:class:`Wagers`). A confidence sequence has to do with all
means, many of them near to the true one, and mixes uniformly.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from grasp_bench.system.arrays import Floats

STAKES = 12
"""Number of stakes that are mixed."""
MEANS = 801
"""Number of means in [−1, 1] that a confidence sequence decides on."""


@cache
def _stakes() -> tuple[Floats, Floats]:
    """Return (L,) stakes in (0, 1) and the logarithms of their weights: a uniform prior by Gauss–Legendre."""
    nodes, weights = np.polynomial.legendre.leggauss(STAKES)
    return np.asarray((nodes + 1) / 2, float), np.asarray(np.log(weights / 2), float)


class Wagers:
    """Capital of gamblers against 'the mean of d is at most 0' and 'it is at least 0', for many series.

    Attributes:
        best: (N, 2) logarithm of the largest capital so far, of gamblers on a positive and a negative mean.

    The prior of the stakes has the density 2λ.
    """

    def __init__(self, series: int) -> None:
        self._log = np.zeros((series, 2, STAKES))
        self.best = np.zeros((series, 2))

    def observe(self, which: np.ndarray, d: Floats) -> None:
        """Pay out on one more number of some series.

        Args:
            which: (M,) numbers of the series, each once.
            d: (M,) their next values in [−1, 1].

        Raises:
            ValueError: for values that are outside.
        """
        if (np.abs(d) > 1).any():
            raise ValueError("betting needs numbers in [−1, 1]")
        stakes, weights = _stakes()
        signed = np.stack([d, -d], axis=1)
        self._log[which] += np.log1p(stakes * signed[..., None])
        prior = weights + np.log(2 * stakes)
        capital = np.logaddexp.reduce(self._log[which] + prior, axis=-1)
        self.best[which] = np.maximum(self.best[which], capital)

    def p_values(self) -> Floats:
        """Return (N, 2) p-values, valid at any time: of a mean of at most 0, and of one of at least 0."""
        return np.exp(-self.best)


def confidence_sequence(d: Floats, alpha: float = 0.05) -> tuple[float, float]:
    """Return the means that all looks so far leave possible; all of them cover with probability 1 − α.

    Args:
        d: (n,) numbers in [−1, 1], in the order in which they came.
        alpha: probability that the true mean is ever left out.
    """
    means = np.linspace(-1, 1, MEANS)[:, None]
    stakes, weights = _stakes()
    # 1 + stake · (d − mean) stays above 0; a mean of ±1 is left out by nearly any other number.
    up, down = stakes / np.maximum(1 + means, 1e-9), stakes / np.maximum(1 - means, 1e-9)
    capital = np.zeros((2, MEANS, STAKES))
    low, high = -1.0, 1.0
    for value in np.asarray(d, float):
        capital[0] += np.log1p(up * (value - means))
        capital[1] += np.log1p(-down * (value - means))
        worth = np.logaddexp.reduce(capital + weights, axis=-1)
        bound = np.log(2 / alpha)
        below, above = worth[0] >= bound, worth[1] >= bound  # too low a mean, too high a mean
        if below.any():
            low = max(low, float(means[np.flatnonzero(below)[-1], 0]))
        if above.any():
            high = min(high, float(means[np.flatnonzero(above)[0], 0]))
    return min(low, high), max(low, high)
