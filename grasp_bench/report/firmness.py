"""How firmly is it held? The share of trials that bear a multiple of the weight, and runs compared by it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np

from grasp_bench.report.compare import SharedTrials
from grasp_bench.report.tables import TextTable
from grasp_bench.runs.info import RunInfo
from grasp_bench.runs.margins import (
    LEAST,
    MOST,
    OCTAVES,
    Estimate,
    bounds,
    estimate,
    factor,
    score_of,
    signed_rank,
)
from grasp_bench.runs.record import TrialRecord
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import Rate, holm
from grasp_bench.system.arrays import Floats

AT = (1.0, 2.0, 5.0)
"""Multiples of the weight with a column of their own."""
GRID = tuple(float(f) for f in np.geomspace(LEAST, MOST, 41))
"""Multiples of the weight at which the curve is drawn, four an octave."""
SHOWN = 20
"""Pairs that the table shows."""


@dataclass(frozen=True)
class Point:
    """A point of a curve: the share of trials that bear ``factor`` times the weight besides it."""

    factor: float
    share: Estimate


@dataclass(frozen=True)
class Firmness:
    """How firmly a run holds; failures count as 0 throughout.

    Attributes:
        trials: number of trials, all of them.
        held: trials that bear 1, 2 and 5 times the weight besides it.
        median: median factor of the trials.
        area: mean score: area under the curve over the logarithm of the factor, 0 to 1.
        curve: share over factor, with intervals clustered by object.
    """

    trials: int
    held: Mapping[float, Rate]
    median: float
    area: Estimate
    curve: tuple[Point, ...]

    @classmethod
    def of(cls, records: Sequence[TrialRecord]) -> Firmness:
        """Return the figures of at least one trial, all of a graded run."""
        factors = np.array([factor(r) for r in records])
        objects = [r.object for r in records]
        shares = (factors[:, None] >= np.array(GRID)).astype(float)
        return cls(
            len(records),
            {at: Rate(int((factors >= at).sum()), len(records)) for at in AT},
            float(np.median(factors)),
            estimate(np.array([score_of(f) for f in factors]), objects),
            tuple(
                Point(f, Estimate(float(s), float(low), float(high)))
                for f, s, low, high in zip(GRID, shares.mean(0), *bounds(shares, objects), strict=True)
            ),
        )

    def to_json(self) -> dict[str, Any]:
        """Return plain data."""
        return {
            "trials": self.trials,
            "held": {f"{at:g}": rate.to_json() for at, rate in self.held.items()},
            "median_factor": self.median,
            "area": self.area.to_json(),
            "curve": [{"factor": p.factor, **p.share.to_json()} for p in self.curve],
        }


@dataclass(frozen=True)
class FirmnessPair:
    """Two runs compared by how firmly they hold, on the trials of both.

    Attributes:
        first, second: positions of the runs in their list.
        trials, objects: how many they have in common.
        ratio: how many times the force the first bears: geometric mean over trials of the ratio of factors,
            which are cut to between a quarter and 256 (:mod:`grasp_bench.runs.margins`).
        p_value: that of the signed-rank test, clustered by object.
        adjusted: the same after Holm's correction for the number of pairs compared.
    """

    first: int
    second: int
    trials: int
    objects: int
    ratio: Estimate
    p_value: float
    adjusted: float

    def to_json(self) -> dict[str, Any]:
        """Return plain data."""
        return dict(vars(self)) | {"ratio": self.ratio.to_json()}


def graded(info: RunInfo) -> bool:
    """Return whether a run measured margins, of single objects."""
    return bool(info.scenario.get("margin")) and not info.cluttered


def firmness(run: RunResults) -> Firmness | None:
    """Return how firmly a run holds; None where it did not measure that or has no trial yet."""
    return Firmness.of(run.records) if graded(run.info) and len(run) else None


def compare_firmness(runs: Sequence[RunResults]) -> list[FirmnessPair]:
    """Compare all graded runs on the trials that they share, whatever number these have in each."""
    shared, pairs = SharedTrials(runs), []
    for i, j in combinations([i for i, run in enumerate(runs) if graded(run.info)], 2):
        if not (common := shared.common(i, j)):
            continue
        octaves, objects = octaves_apart(common)
        ratio = estimate(octaves, objects)
        p = signed_rank(octaves.tolist(), objects)
        times = Estimate(2**ratio.value, 2**ratio.low, 2**ratio.high)
        pairs.append(FirmnessPair(i, j, len(objects), len(set(objects)), times, p, 1.0))
    adjusted = holm([p.p_value for p in pairs])
    return [replace(p, adjusted=a) for p, a in zip(pairs, adjusted, strict=True)]


def octaves_apart(common: Sequence[tuple[TrialRecord, TrialRecord]]) -> tuple[Floats, list[str]]:
    """Return how many doublings more the first of each pair (N,) bears, and the objects of the pairs."""
    apart = [OCTAVES * (score_of(factor(a)) - score_of(factor(b))) for a, b in common]
    return np.array(apart), [a.object for a, _ in common]


def firmness_table(rows: Sequence[tuple[str, Firmness]]) -> TextTable:
    """Return the table of named runs."""
    head = ("Run", *(f"Held at {at:g}×" for at in AT), "Median", "Area", "95 % interval")
    cells = [
        [
            name,
            *(f"{r.successes}/{r.trials}" for r in f.held.values()),
            f"{f.median:.3g}×",
            f"{f.area.value:.3f}",
            f"{f.area.low:.3f} – {f.area.high:.3f}",
        ]
        for name, f in rows
    ]
    return TextTable(
        "How firmly is it held?",
        head,
        cells,
        note="Held at 2×: trials in which no force of twice the object's weight, in any direction of the "
        "gripper, broke the grip besides the weight itself; failures hold at none. Area: a tenth a doubling "
        f"from {LEAST:g} to {MOST:g} times the weight, averaged; intervals by bootstrap over objects.",
        numbers=range(1, len(head)),
    )


def pairs_table(names: Sequence[str], pairs: Sequence[FirmnessPair]) -> TextTable:
    """Return the table of compared runs, the surest differences first."""
    head = ("First", "Second", "Trials", "Force", "95 % interval", "p", "Holm")
    sure = sorted(pairs, key=lambda p: (p.adjusted, p.p_value))
    cells = [
        [
            names[p.first],
            names[p.second],
            str(p.trials),
            f"{p.ratio.value:.2f}×",
            f"{p.ratio.low:.2f} – {p.ratio.high:.2f}",
            f"{p.p_value:.2g}",
            f"{p.adjusted:.2g}",
        ]
        for p in sure[:SHOWN]
    ]
    more = f" {len(pairs) - SHOWN} more pairs are in the JSON." if len(pairs) > SHOWN else ""
    apart = sum(p.adjusted <= 0.05 for p in pairs)
    return TextTable(
        "Which holds more firmly?",
        head,
        cells,
        note=f"{apart} of {len(pairs)} pairs differ at 5 % after Holm's correction. Force: how many times as "
        "much the first bears as the second, geometric mean over common trials; signed-rank test of the "
        f"logarithms, clustered by object.{more}",
        numbers=range(2, len(head)),
        level=3,
    )
