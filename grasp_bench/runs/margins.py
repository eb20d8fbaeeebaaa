"""Margins of records as numbers, their curve, and two runs compared by them; for graded runs only.

The *factor* of a trial is the least force that broke the grip as a multiple of the object's weight, 0 for a
failure. Its logarithm is what is averaged and compared: twice as much is as much better at 2 as at 20 times
the weight. Trials of one object are not independent: intervals and tests go by object.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from statistics import NormalDist

import numpy as np

from grasp_bench.errors import ResultsError
from grasp_bench.runs.record import Attempted
from grasp_bench.system.arrays import Floats

LEAST, MOST = 0.25, 256.0
"""Factors below the first count as lost, those above the second as the second."""
OCTAVES = math.log2(MOST / LEAST)
DRAWS = 2000
"""Bootstrap samples."""
EXACT = 12
"""Up to so many objects the signed-rank test goes through all signs."""


def factor(record: Attempted) -> float:
    """Return the least force that broke the grip, as a multiple of the object's weight; 0 for a failure.

    Raises:
        ResultsError: for a success whose margin was not measured.
    """
    if record.margin is None:
        if not record.success:
            return 0.0
        raise ResultsError(
            f"The record of {record.object} has no margin; run with the scenario graded, or with a margin "
            "section of your own."
        )
    return record.margin.factor if record.success else 0.0


def score(record: Attempted) -> float:
    """Return how firmly a trial held, from 0 (lost, or a quarter of the weight broke it) to 1 (256 times).

    Linear in the logarithm of the factor: a tenth for every doubling. The mean over trials is the area under
    the curve of the share that holds.

    Raises:
        ResultsError: for a success whose margin was not measured.
    """
    return score_of(factor(record))


def score_of(times: float) -> float:
    """Return the score of a factor."""
    return min(max(math.log2(max(times, LEAST) / LEAST) / OCTAVES, 0.0), 1.0)


@dataclass(frozen=True)
class Estimate:
    """A number and its 95 % interval."""

    value: float
    low: float
    high: float

    def to_json(self) -> dict[str, float]:
        """Return plain data."""
        return dict(vars(self))


def resampled(values: Floats, clusters: Sequence[str]) -> Floats:
    """Return the mean of bootstrap samples of whole clusters, (:data:`DRAWS`, ...).

    Ratio estimates of the mean (sum over sum), so that clusters of any size may be drawn. The draws are the
    same for the same clusters.

    Args:
        values: (N, ...) one of each trial.
        clusters: N names of what trials share.
    """
    names, index = np.unique(np.asarray(clusters, dtype=str), return_inverse=True)
    sums = np.zeros((len(names), *values.shape[1:]))
    np.add.at(sums, index, values)
    sizes = np.bincount(index).astype(float)
    share = np.full(len(names), 1 / len(names))
    drawn = np.random.default_rng(0).multinomial(len(names), share, size=DRAWS).astype(float)
    total = drawn @ sums.reshape(len(names), -1)
    return (total / (drawn @ sizes)[:, None]).reshape(DRAWS, *values.shape[1:])


def bounds(values: Floats, clusters: Sequence[str], confidence: float = 0.95) -> Floats:
    """Return the (2, ...) lower and upper bootstrap limits of the mean of values (N, ...), clustered.

    T. Hesterberg, “What teachers should know about the bootstrap”, The American Statistician 69 (2015)
    371–386: percentiles, so far out that the interval of a normal mean is that of Student's t.
    """
    from scipy.stats import norm, t

    count = len(set(clusters))
    out = (
        norm.cdf(math.sqrt(count / (count - 1)) * t.ppf((1 - confidence) / 2, count - 1))
        if count > 1
        else 0.0
    )
    return np.percentile(resampled(values, clusters), [100 * out, 100 * (1 - out)], axis=0)


def estimate(values: Floats, clusters: Sequence[str]) -> Estimate:
    """Return a mean with its bootstrap interval, clustered."""
    low, high = bounds(values, clusters)
    return Estimate(float(values.mean()), float(low), float(high))


def signed_rank(differences: Sequence[float], clusters: Sequence[str], worse: bool = False) -> float:
    """Return the p-value of the signed-rank test for paired trials that share objects.

    B. Rosner, R. J. Glynn and M.-L. T. Lee, “The Wilcoxon signed rank test for paired comparisons of
    clustered data”, Biometrics 62 (2006) 185–192: signed ranks are summed within each cluster, and the sums
    change sign together. Up to :data:`EXACT` clusters all signs are gone through; beyond, the sum is taken to
    be normal. With one trial an object it is Wilcoxon's test. Equal pairs are left out.

    Args:
        differences: one of each pair.
        clusters: the name that pairs share, of each.
        worse: one-sided, that differences are negative, instead of two-sided.
    """
    from scipy.stats import rankdata

    d = np.asarray(differences, dtype=float)
    kept = d != 0
    if not kept.any():
        return 1.0
    ranks = np.sign(d[kept]) * rankdata(np.abs(d[kept]))
    _, index = np.unique(np.asarray(clusters, dtype=str)[kept], return_inverse=True)
    sums = np.bincount(index, weights=ranks)
    total = float(sums.sum())
    if len(sums) <= EXACT:
        signs = np.array(list(product((-1.0, 1.0), repeat=len(sums))))
        every = signs @ np.abs(sums)
        reached = every <= total + 1e-9 if worse else np.abs(every) >= abs(total) - 1e-9
        return float(reached.mean())
    z = total / math.sqrt(float((sums**2).sum()))
    return NormalDist().cdf(z) if worse else 2 * NormalDist().cdf(-abs(z))
