"""Is a predictor's quality the probability of success? And how many picks an hour does it make?

Both follow from what a run has recorded. The quality is that of the grasp carried out; a trial in which none
was carried out has none, and is counted apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from grasp_bench.report.reliability import Bin, binned, calibration_error, intervals
from grasp_bench.report.tables import RATE_HEAD, TextTable, rate_cells
from grasp_bench.runs.record import Attempted, Timings
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import Rate
from grasp_bench.system.arrays import Floats

BINS = 10
COVERAGES = tuple(k / 20 for k in range(1, 21))
"""Shares of the most confident grasps of which the rate is told."""
DRAWS = 999
"""Outcomes drawn of a run to see what chance makes of its calibration error."""
MOST = 20_000_000
"""Numbers drawn at most: of long runs fewer outcomes are drawn, a tenth at least."""
SURE = 0.01
"""Level at which a predictor is called over- or under-confident."""
COMPUTING = ("predict", "plan")
"""Phases of a trial that cost a robot's time, besides motion."""


@dataclass(frozen=True)
class Calibration:
    """Quality of grasps against their success.

    Attributes:
        bins: grasps by quality, in :data:`BINS` equal intervals of it; empty ones are left out.
        mean_quality: of all grasps.
        held: successes among them.
        error: expected calibration error (:func:`~grasp_bench.report.reliability.calibration_error`).
        by_chance: mean of that error over outcomes drawn with probability = quality: what as few grasps
            show of a predictor that is right about itself.
        p_value: that the quality is the probability of success: share of such draws with an error as large
            (consistency resampling, J. Bröcker & L. Smith, Weather and Forecasting 22 (2007) 651–661).
        brier: mean squared difference of quality and outcome (G. W. Brier, Monthly Weather Review 78 (1950)
            1–3).
        coverage: success among the most confident share of grasps, by that share.
        area: mean failure rate over all coverages (area under the risk–coverage curve; El-Yaniv & Wiener,
            JMLR 11 (2010) 1605–1641).
    """

    bins: tuple[Bin, ...]
    mean_quality: float
    held: Rate
    error: float
    by_chance: float
    p_value: float
    brier: float
    coverage: dict[float, Rate]
    area: float

    @property
    def verdict(self) -> str:
        """What the grasps say of the quality, in a word or two."""
        if self.p_value > SURE:
            return "in keeping with a probability"
        gap = self.mean_quality - self.held.rate
        if abs(gap) < self.error / 2:
            return "no probability: too high here, too low there"
        return "over-confident" if gap > 0 else "under-confident"

    def to_json(self) -> dict[str, Any]:
        """Return plain data."""
        return {
            "bins": [{"mean_quality": b.quality, **b.held.to_json()} for b in self.bins],
            "mean_quality": self.mean_quality,
            "held": self.held.to_json(),
            "expected_calibration_error": self.error,
            "error_by_chance": self.by_chance,
            "p_value": self.p_value,
            "brier": self.brier,
            "verdict": self.verdict,
            "coverage": {f"{share:g}": rate.to_json() for share, rate in self.coverage.items()},
            "risk_coverage_area": self.area,
        }


def calibration(quality: Floats, success: Sequence[bool]) -> Calibration | None:
    """Hold qualities (n,) in [0, 1] against success; None without any grasp, or where all qualities are one.

    A predictor that gives every grasp the same quality says nothing of them.
    """
    q, y = np.asarray(quality, float), np.asarray(success, bool)
    if len(q) == 0 or np.ptp(q) == 0:
        return None
    index = intervals(q, BINS)
    rng, draws = np.random.default_rng(0), max(DRAWS // 10, min(DRAWS, MOST // len(q)))
    error = calibration_error(q, y, index)
    by_chance = np.array([calibration_error(q, rng.random(len(q)) < q, index) for _ in range(draws)])
    order = np.argsort(-q, kind="stable")
    failed = np.cumsum(~y[order]) / np.arange(1, len(q) + 1)
    return Calibration(
        tuple(binned(q, y, index)),
        float(q.mean()),
        _rate(y),
        error,
        float(by_chance.mean()),
        float((1 + (by_chance >= error).sum()) / (1 + draws)),
        float(((q - y) ** 2).mean()),
        {share: _rate(y[order[: max(1, round(share * len(q)))]]) for share in COVERAGES},
        float(failed.mean()),
    )


def _rate(success: np.ndarray) -> Rate:
    return Rate(int(success.sum()), len(success))


@dataclass(frozen=True)
class Picks:
    """Objects lifted in an hour of a robot's time: simulated motion, and computing of predictor and planner.

    Attributes:
        lifted: successes.
        motion, computing: seconds of all trials, failed ones included.
    """

    lifted: int
    motion: float
    computing: float

    @property
    def an_hour(self) -> float:
        """Objects lifted in an hour; 0 where nothing took any time."""
        seconds = self.motion + self.computing
        return 3600 * self.lifted / seconds if seconds else 0.0

    def to_json(self) -> dict[str, float]:
        """Return plain data."""
        return {
            "picks_an_hour": round(self.an_hour, 1),
            "motion_seconds": round(self.motion, 2),
            "computing_seconds": round(self.computing, 2),
        }


@dataclass(frozen=True)
class Trust:
    """What a run tells of its predictor's own word, and of its pace.

    Attributes:
        calibration: None where the predictor's qualities say nothing, or no grasp was carried out.
        without: attempts in which no grasp was carried out.
        picks: objects lifted in an hour.
    """

    calibration: Calibration | None
    without: int
    picks: Picks

    @classmethod
    def of(cls, run: RunResults, timings: Sequence[Timings]) -> Trust:
        """Return it of a run, from its records and timings alone."""
        tries: list[Attempted] = [t for r in run.records for _, t in r.tries]
        grasps = [(t.grasp.quality, t.success) for t in tries if t.grasp is not None]
        step = float((run.info.scenario.get("physics") or {}).get("timestep", 0.002))
        computing = sum(t.seconds.get(p, 0.0) for t in timings for p in COMPUTING)
        return cls(
            calibration(np.array([q for q, _ in grasps]).clip(0, 1), [s for _, s in grasps]),
            len(tries) - len(grasps),
            Picks(sum(t.success for t in tries), step * sum(t.sim_steps for t in tries), computing),
        )

    def to_json(self) -> dict[str, Any]:
        """Return plain data."""
        found = None if self.calibration is None else self.calibration.to_json()
        return {"calibration": found, "no_grasp_carried_out": self.without, **self.picks.to_json()}


def trust_table(runs: Sequence[tuple[str, Trust]]) -> TextTable:
    """Return what each run's predictor, by the run's name, says of its grasps, beside what became of them."""
    rows = []
    for name, run in runs:
        found = run.calibration
        pace = f"{run.picks.an_hour:.0f}"
        if found is None:
            rows.append([name, *[""] * 6, "gives no qualities", pace])
            continue
        half = found.coverage[0.5]
        cells = [f"{found.mean_quality:.2f}", *rate_cells(found.held), f"{half.rate:.1%}"]
        rows.append([name, *cells, f"{found.error:.2f} ({found.by_chance:.2f})", found.verdict, pace])
    return TextTable(
        "Is its quality a probability?",
        ("Run", "Mean quality", *RATE_HEAD, "Surer half", "Error (by chance)", "Quality is", "Picks/h"),
        rows,
        note="Of the grasps carried out. Error: expected calibration error over ten bins, and what chance "
        "alone would make of it; it is called over- or under-confident at 1 %. Surer half: success among the "
        "half of the grasps with the higher quality. Picks/h: objects lifted in an hour of simulated motion "
        "and of measured computing (network and planner on the run's machine), failures included.",
        numbers=(1, 2, 3, 4, 5, 6, 8),
    )
