"""A race of predictors on the same items: who is better than whom, and when that is known.

Each pair is decided by betting on the differences of their scores (:mod:`grasp_bench.runs.betting`), so that
one may look after every item. Family-wise: the probability that any order is claimed wrongly, however long
the race goes on, is at most α. Pairs are rejected one after another as by Holm; a pair that follows from
others (a over b, b over c) needs no test of its own and does not count among those that are left, since it
can only be wrong where one of the two was (J. P. Shaffer, “Modified sequentially rejective multiple test
procedures”, J. Am. Stat. Assoc. 81 (1986) 826–831).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np

from grasp_bench.runs.betting import Wagers, confidence_sequence
from grasp_bench.system.arrays import Floats


class Race:
    """Scores in [0, 1] of some predictors, item by item, and what follows from them.

    Items must be drawn independently, each as likely as any other: then the mean difference of a pair is that
    of the whole population of items, and the claim on it is exact.

    Args:
        names: the predictors, in the order in which ties are listed.
        alpha: largest probability that any pair is put in a wrong order.

    Attributes:
        items: number of items observed.
        scores: of each predictor, on the items that it did: the first ones, as it leaves once it is placed.
    """

    def __init__(self, names: Sequence[str], alpha: float = 0.05) -> None:
        if len(set(names)) < len(names) or len(names) < 2:
            raise ValueError("a race needs two different names or more")
        if not 0 < alpha < 1:
            raise ValueError(f"alpha must be in (0, 1), not {alpha}")
        self.names, self.alpha, self.items = tuple(names), alpha, 0
        self.scores: dict[str, list[float]] = {n: [] for n in names}
        self._pairs = list(combinations(range(len(names)), 2))
        self._wagers = Wagers(len(self._pairs))
        self._better = np.zeros((len(names), len(names)), bool)

    def observe(self, scores: Mapping[str, float]) -> None:
        """Take the scores of one more item from all predictors that are still :attr:`in_doubt`.

        Raises:
            ValueError: for a score that is missing or outside [0, 1].
        """
        racing = self.in_doubt
        for name in racing:
            if name not in scores or not 0 <= scores[name] <= 1:
                raise ValueError(f"{name} needs a score in [0, 1] on item {self.items}: {scores.get(name)}")
            self.scores[name].append(float(scores[name]))
        self.items += 1
        both = [p for p, (a, b) in enumerate(self._pairs) if {self.names[a], self.names[b]} <= set(racing)]
        values = [self.scores[n][-1] if n in racing else 0.0 for n in self.names]
        d = np.array([values[a] - values[b] for a, b in (self._pairs[p] for p in both)], float)
        self._wagers.observe(np.array(both, int), d)
        self._decide()

    def _decide(self) -> None:
        """Reject what can be rejected, one pair after another, each time with what follows from it."""
        p_values = self._wagers.p_values()
        while left := [p for p, (a, b) in enumerate(self._pairs) if not self._known(a, b)]:
            surest = min(left, key=lambda p: float(p_values[p].min()))
            first_better, second_better = p_values[surest] <= self.alpha / (2 * len(left))
            if not (first_better or second_better):
                return
            a, b = self._pairs[surest]
            self._place(a, b) if p_values[surest][0] <= p_values[surest][1] else self._place(b, a)

    def _known(self, a: int, b: int) -> bool:
        return bool(self._better[a, b] or self._better[b, a])

    def _place(self, better: int, worse: int) -> None:
        """Put one before another, and all that is before the one before all that is behind the other."""
        above = np.append(np.flatnonzero(self._better[:, better]), better)
        below = np.append(np.flatnonzero(self._better[worse]), worse)
        for one in above:
            self._better[one, below[~self._better[below, one]]] = True

    # ---------------------------------------------------------------- what follows

    def better(self, a: str, b: str) -> bool:
        """Tell whether it is known that ``a`` is better than ``b``."""
        return bool(self._better[self.names.index(a), self.names.index(b)])

    @property
    def in_doubt(self) -> list[str]:
        """Predictors that are not yet told from all others; only they go on."""
        known = self._better | self._better.T | np.eye(len(self.names), dtype=bool)
        return [n for n, row in zip(self.names, known, strict=True) if not row.all()]

    @property
    def separated(self) -> tuple[int, int]:
        """How many pairs are told apart, and how many there are."""
        return int(self._better.sum()), len(self._pairs)

    def places(self, name: str) -> tuple[int, int]:
        """Return the best and the worst place that a predictor may have, from 1."""
        i = self.names.index(name)
        return 1 + int(self._better[:, i].sum()), len(self.names) - int(self._better[i].sum())

    @property
    def groups(self) -> list[list[str]]:
        """The order as far as it is known: all of a group are better than all of the next.

        Within a group names are in the order of their places and means, which claims nothing.
        """
        order = sorted(self.names, key=lambda n: (sum(self.places(n)), -self.mean(n), self.names.index(n)))
        groups, current = [], [order[0]]
        for i, name in enumerate(order[1:], 1):
            if all(self.better(a, b) for a in order[:i] for b in order[i:]):
                groups.append(current)
                current = []
            current.append(name)
        return [*groups, current]

    def mean(self, name: str) -> float:
        """Return the mean score on the items that a predictor did; 0 for none."""
        return float(np.mean(self.scores[name])) if self.scores[name] else 0.0

    def differences(self, a: str, b: str) -> Floats:
        """Return the scores of ``a`` minus those of ``b`` on the items that both did."""
        return np.array([x - y for x, y in zip(self.scores[a], self.scores[b], strict=False)], float)

    def unseen(self) -> list[tuple[str, str, tuple[float, float]]]:
        """Return each pair that is not told apart, with the differences that the items leave possible.

        The interval is a confidence sequence of that pair alone: it covers with probability 1 − α.
        """
        return [
            (self.names[a], self.names[b], self._possible(self.names[a], self.names[b]))
            for a, b in self._pairs
            if not self._known(a, b)
        ]

    def _possible(self, a: str, b: str) -> tuple[float, float]:
        return confidence_sequence(self.differences(a, b), self.alpha)
