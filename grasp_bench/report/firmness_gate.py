"""A new graded run against a baseline: does it hold as firmly?

Verdicts, by the factors of the trials (:mod:`grasp_bench.runs.margins`), pair by pair:

- ``no regression``: a drop of the force to ``least`` times or below is excluded at level α, by the lower
  limit of the bootstrap interval of the geometric mean ratio, clustered by object;
- ``regression``: that is not so, and a drop is proven at level α (signed-rank test, one-sided, clustered);
- ``inconclusive``: neither.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from grasp_bench.errors import GraspBenchError
from grasp_bench.report.firmness import graded, octaves_apart
from grasp_bench.report.gate import Changed, NotComparableError, Verdict, check_same_trials, notes_on
from grasp_bench.runs.margins import Estimate, bounds, factor, signed_rank
from grasp_bench.runs.results import RunResults


@dataclass(frozen=True)
class CheckedFirmness:
    """A comparison of how firmly two runs hold.

    Attributes:
        new, baseline: folders of the runs.
        trials, objects: numbers of pairs, and of objects.
        least: ratio of the force to which a drop would matter.
        alpha: level of both tests.
        ratio: geometric mean of new over old factor, with its interval of confidence 1 − 2 α.
        p_worse: one-sided p-value of the signed-rank test that the new run holds less firmly.
        medians: median factors of the baseline and of the new run.
        changed: trials whose force became less than half or more than twice, most changed first.
        notes: what is worth knowing, in words.
    """

    verdict: Verdict
    new: Path
    baseline: Path
    trials: int
    objects: int
    least: float
    alpha: float
    ratio: Estimate
    p_worse: float
    medians: tuple[float, float]
    changed: tuple[Changed, ...]
    notes: tuple[str, ...]

    @property
    def failed(self) -> bool:
        """Whether this is a regression."""
        return self.verdict is Verdict.REGRESSION

    @property
    def meaning(self) -> str:
        """What the verdict means, in a sentence."""
        if self.verdict is Verdict.NO_REGRESSION:
            return f"A drop of the force to {self.least:g} times is excluded (it is {self._ratio})."
        if self.verdict is Verdict.REGRESSION:
            return f"Objects are held less firmly: {self._ratio} (p = {self.p_worse:.2g} ≤ {self.alpha:g})."
        return (
            f"No drop is proven (p = {self.p_worse:.2g}), but one to {self.ratio.low:.2f} times the force is "
            f"not excluded; these trials cannot tell {self.least:g} times from as much."
        )

    @property
    def figures(self) -> list[tuple[str, str]]:
        """What, and how much."""
        before, after = self.medians
        return [
            ("Baseline", f"bears {before:.3g} times the weight, median of {self.trials} trials"),
            ("New", f"bears {after:.3g} times the weight"),
            ("Force", f"{self._ratio}, {1 - 2 * self.alpha:.0%} interval by bootstrap over objects"),
            ("Is it a drop?", f"p = {self.p_worse:.3g} (signed-rank test, one-sided, by object)"),
            ("Pairs", f"{self.trials} trials of {self.objects} objects"),
        ]

    @property
    def _ratio(self) -> str:
        return f"{self.ratio.value:.2f} times, {self.ratio.low:.2f} – {self.ratio.high:.2f}"

    def to_json(self) -> dict[str, Any]:
        """Return plain data."""
        return dict(vars(self)) | {
            "new": str(self.new),
            "baseline": str(self.baseline),
            "ratio": self.ratio.to_json(),
            "changed": [vars(c) for c in self.changed],
        }


def check_firmness(new: Path, baseline: Path, least: float = 0.8, alpha: float = 0.05) -> CheckedFirmness:
    """Compare two graded runs of the same trials.

    Args:
        new, baseline: folders of the runs.
        least: ratio of the force to which a drop would matter, in (0, 1).
        alpha: level of both tests, in (0, 0.5).

    Raises:
        NotComparableError: when the runs are not of the same trials or not graded, saying why.
        ResultsError: when a folder cannot be read.
        GraspBenchError: for an impossible ratio or alpha.
    """
    if not 0 < least < 1:
        raise GraspBenchError(
            f"--firmness must be between 0 and 1, e.g. 0.8 for a drop by a fifth, not {least:g}."
        )
    if not 0 < alpha < 0.5:
        raise GraspBenchError(f"--alpha must be between 0 and 0.5, e.g. 0.05, not {alpha:g}.")
    old, now = RunResults(baseline), RunResults(new)
    for run in (old, now):
        if not graded(run.info):
            raise NotComparableError(
                f"{run.folder} did not measure how firmly objects are held; run it with --scenario graded."
            )
    check_same_trials(old, now)
    octaves, objects = octaves_apart(list(zip(now.records, old.records, strict=True)))
    low, high = bounds(octaves, objects, 1 - 2 * alpha)
    p_worse = signed_rank(octaves.tolist(), objects, worse=True)
    if 2**low > least:
        verdict = Verdict.NO_REGRESSION
    else:
        verdict = Verdict.REGRESSION if p_worse <= alpha else Verdict.INCONCLUSIVE
    medians = [float(np.median([factor(r) for r in run.records])) for run in (old, now)]
    return CheckedFirmness(
        verdict,
        new,
        baseline,
        len(objects),
        len(set(objects)),
        least,
        alpha,
        Estimate(float(2 ** octaves.mean()), float(2**low), float(2**high)),
        p_worse,
        (medians[0], medians[1]),
        _changed(old, now, octaves),
        tuple(notes_on(old, now, p_worse <= alpha and verdict is Verdict.NO_REGRESSION)),
    )


def _changed(old: RunResults, now: RunResults, octaves: Any) -> tuple[Changed, ...]:
    pairs = list(zip(old.records, now.records, strict=True))
    order = np.argsort(-np.abs(octaves), kind="stable")
    return tuple(
        Changed(b.trial, b.object, f"{factor(b):.3g}×", f"{factor(a):.3g}×", a.detail)
        for b, a in (pairs[i] for i in order if abs(octaves[i]) > 1)
    )
