"""Runs compared on the trials that they have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import holm, mcnemar


@dataclass(frozen=True)
class Pair:
    """Two runs on the same trials.

    Attributes:
        first, second: positions of the runs in their list.
        both, first_only, second_only, neither: number of trials in which they succeeded.
        p_value: p-value of McNemar's exact two-sided test.
        adjusted: the same after Holm's correction for the number of pairs compared.
        discordant: numbers of the trials in which exactly one succeeded.
    """

    first: int
    second: int
    both: int
    first_only: int
    second_only: int
    neither: int
    p_value: float
    adjusted: float
    discordant: tuple[int, ...]

    @property
    def trials(self) -> int:
        """Number of trials in common."""
        return self.both + self.first_only + self.second_only + self.neither


def same_conditions(first: RunResults, second: RunResults) -> bool:
    """Return whether equal trial numbers mean the same scene: scenario, seed and renderer agree."""

    def conditions(run: RunResults) -> list[Any]:
        scenario = {k: v for k, v in run.info.scenario.items() if k != "description"}
        return [scenario, run.info.seed, run.info.renderer]

    return conditions(first) == conditions(second)


def compare_all(runs: Sequence[RunResults]) -> list[Pair]:
    """Compare all runs that share trials: same number, object and object files under the same conditions.

    Runs that are not finished are compared on what they have so far.
    """
    results = [_results(r) for r in runs]
    pairs = []
    for i, j in combinations(range(len(runs)), 2):
        if not same_conditions(runs[i], runs[j]):
            continue
        common = sorted(results[i].keys() & results[j].keys())
        if not common:
            continue
        ends = [(results[i][key], results[j][key]) for key in common]
        only, other = ends.count((True, False)), ends.count((False, True))
        both, neither = ends.count((True, True)), ends.count((False, False))
        discordant = tuple(key[0] for key, (a, b) in zip(common, ends, strict=True) if a != b)
        pairs.append(Pair(i, j, both, only, other, neither, mcnemar(only, other), 1.0, discordant))
    adjusted = holm([p.p_value for p in pairs])
    return [replace(p, adjusted=a) for p, a in zip(pairs, adjusted, strict=True)]


def _results(run: RunResults) -> dict[tuple[int, str, str], bool]:
    """Return success by trial number, object and the object's files."""
    files = {name: str(sorted((found or {}).items())) for name, found in run.info.objects.items()}
    return {(r.trial, r.object, files.get(r.object, "[]")): r.success for r in run.records}
