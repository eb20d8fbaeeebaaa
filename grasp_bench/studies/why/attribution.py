"""Which cause a failure is put down to: first-success sets.

Causes are removed level by level (:func:`grasp_bench.studies.why.causes.levels`), and the sets of the first
level after which the trial succeeds explain it. Each of these sets gets the same share of the failure, each
cause of a set the same share of the set's. docs/why.md says why this and not Shapley values.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from grasp_bench.studies.why.causes import CAUSES, KEYS, Cause, Removed, levels, ordered

UNEXPLAINED = "unexplained"
"""Stands in for a cause where no set of at most two saved the trial."""


@dataclass(frozen=True)
class Explanation:
    """What a failed trial is put down to.

    Attributes:
        trial, object, outcome: as in its record.
        sets: the first sets of causes without which it succeeds; empty where none was found.
        replays: how often it was done again.
    """

    trial: int
    object: str
    outcome: str
    sets: tuple[Removed, ...]
    replays: int = 0

    @property
    def credit(self) -> dict[str, float]:
        """The failure's share of each cause, adding up to 1; all of it :data:`UNEXPLAINED` without a set."""
        if not self.sets:
            return {UNEXPLAINED: 1.0}
        shares = dict.fromkeys(KEYS, 0.0)
        for removed in self.sets:
            for key in removed:
                shares[key] += 1 / len(self.sets) / len(removed)
        return {key: share for key, share in shares.items() if share}


def first_success(
    causes: Sequence[Cause], succeeds: Callable[[Removed], bool]
) -> tuple[tuple[Removed, ...], int]:
    """Return the first sets without which a trial succeeds, and how many were tried.

    A cause is left out where one of its parts is enough.

    Args:
        causes: those that there are.
        succeeds: does the trial again without a set of them.
    """
    tried = 0
    for level in levels(causes):
        won = [removed for removed in level if succeeds(removed)]
        tried += len(level)
        if won:
            return tuple(r for r in won if not _needless(r, won)), tried
    return (), tried


def _needless(removed: Removed, won: Sequence[Removed]) -> bool:
    """Whether one of the other sets is the same but for a part in the place of a whole."""
    wholes = [c for c in CAUSES if c.key in removed and c.parts]
    return any((removed - {whole.key}) | {part} in won for whole in wholes for part in whole.parts)


def shares(explained: Iterable[Explanation]) -> dict[str, float]:
    """Return how many failures fall to each cause, the greatest first; ties in the order of the causes."""
    total = dict.fromkeys([*KEYS, UNEXPLAINED], 0.0)
    for explanation in explained:
        for key, share in explanation.credit.items():
            total[key] += share
    found = [(key, share) for key, share in total.items() if share]
    return dict(sorted(found, key=lambda item: -round(item[1], 9)))


def first_cause(explanation: Explanation, run: Mapping[str, float]) -> str:
    """Return the cause that is named first for a failure: the one with its greatest share.

    Of several it is the one to which most failures of the run fall: what explains many is likelier than a
    coincidence.

    Args:
        run: what :func:`shares` says of the whole run.
    """
    order = [*KEYS, UNEXPLAINED]
    credit = explanation.credit
    return min(credit, key=lambda k: (-round(credit[k], 9), -round(run.get(k, 0.0), 9), order.index(k)))


def named(sets: Sequence[Removed]) -> list[list[str]]:
    """Return sets as lists of keys, in the order of the causes."""
    return sorted(([*ordered(s)] for s in sets), key=lambda s: [KEYS.index(k) for k in s])
