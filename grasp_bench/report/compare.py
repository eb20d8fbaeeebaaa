"""Runs compared with one of them, on the trials that they have in common."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from grasp_bench.runs.comparison import Comparison, Scene, scenes
from grasp_bench.runs.record import TrialRecord
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import holm

REFERENCE = "htc-grasp"
"""Predictor that others are compared with unless another is chosen."""

Identity = tuple[str, Scene, str]
"""What makes trials of two runs the same: conditions, scene, and the object's files."""


@dataclass(frozen=True)
class Versus:
    """A run compared with the reference.

    Attributes:
        run: position of the run in the list.
        pairs: the reference (first) and the run (second) on their common trials.
        adjusted: p-value after Holm's correction over the predictors that were compared with the reference;
            None for a repetition: a run of the reference's own predictor, or a predictor's run beside another
            of its runs that has more trials in common.
    """

    run: int
    pairs: Comparison
    adjusted: float | None


class SharedTrials:
    """Which trials of several runs are the same: same scenario, renderer, seed, object, files and attempt.

    Numbers of trials do not matter, nor other trials beside. Runs that are not finished are compared on what
    they have so far.
    """

    def __init__(self, runs: Sequence[RunResults]) -> None:
        self._runs = runs
        self._trials = [_identified(run) for run in runs]
        self._numbers: dict[Identity, int] = {}
        for trials in self._trials:
            for identity in trials:
                self._numbers.setdefault(identity, len(self._numbers))

    def numbers(self, run: int) -> dict[int, int]:
        """Return a number for each trial of a run, which equal trials of all runs share."""
        return {record.trial: self._numbers[key] for key, record in self._trials[run].items()}

    def common(self, first: int, second: int) -> list[tuple[TrialRecord, TrialRecord]]:
        """Return the records of both runs of each trial that they share, in the first's trial order."""
        theirs = self._trials[second]
        return [(record, theirs[key]) for key, record in self._trials[first].items() if key in theirs]

    def against(self, reference: int) -> list[Versus]:
        """Compare all runs that have trials in common with the run at position ``reference``."""
        name = self._runs[reference].predictor
        compared: list[tuple[int, Comparison]] = []
        for i, run in enumerate(self._runs):
            if i != reference and (pairs := self.common(reference, i)):
                compared.append((i, Comparison.counted(name, run.predictor, pairs)))
        counted: dict[str, tuple[int, float]] = {}
        for i, pairs in sorted(compared, key=lambda c: -c[1].trials):
            counted.setdefault(_made(self._runs[i]), (i, pairs.p_value))
        counted.pop(_made(self._runs[reference]), None)
        corrected = holm([p for _, p in counted.values()])
        adjusted = {i: p for (i, _), p in zip(counted.values(), corrected, strict=True)}
        return [Versus(i, pairs, adjusted.get(i)) for i, pairs in compared]


def _identified(run: RunResults) -> dict[Identity, TrialRecord]:
    """Return a run's records by what makes their trials the same as another run's."""
    info = run.info
    scenario = dict(info.comparable().scenario)
    if not info.cluttered and isinstance(chosen := scenario.get("objects"), dict):
        scenario["objects"] = {k: v for k, v in chosen.items() if k != "names"}  # which were chosen, not how
    conditions = _dumped([scenario, info.renderer])
    files = {name: _dumped(found or {}) for name, found in info.objects.items()}
    all_files = _dumped(info.objects) if info.cluttered else None
    return {
        (conditions, scene, all_files or files.get(scene.object, "{}")): record
        for scene, record in scenes(run).items()
    }


def _made(run: RunResults) -> str:
    """Return what identifies the predictor of a run."""
    return _dumped([run.predictor, run.info.weights, run.info.implementation])


def _dumped(content: Any) -> str:
    return json.dumps(content, sort_keys=True)
