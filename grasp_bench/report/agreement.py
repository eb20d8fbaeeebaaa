"""Does the order that physics puts networks in hold on real images?

Success in simulated trials against the rectangle metric on labelled real images, over predictors, by the
measures of SIMPLER (Li et al., Evaluating Real-World Robot Manipulation Policies in Simulation, CoRL 2024,
section 3): Pearson's correlation, and the mean maximum rank violation,

    MMRV = mean over i of max over j of |real_i − real_j| · [sim and real disagree on who of i, j is better].
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from grasp_bench.errors import ResultsError
from grasp_bench.report.tables import TextTable
from grasp_bench.runs.comparison import Scene, scenes
from grasp_bench.runs.evaluation import Evaluation, Record
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import Rate
from grasp_bench.system.arrays import Floats

FEWEST = 3
"""Predictors below which no correlation is reported."""
RESAMPLES = 2000

Found = TypeVar("Found", RunResults, Evaluation)
Key = TypeVar("Key", Scene, tuple[str, str])


@dataclass(frozen=True)
class Measure:
    """A measure with the middle 95 % of what resampled trials and images give; NaN where undefined."""

    value: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.value:.2f} ({self.low:.2f} – {self.high:.2f})"


@dataclass(frozen=True)
class Both:
    """A predictor's successes in trials, and its right best grasps on images."""

    predictor: str
    physics: Rate
    real: Rate


@dataclass(frozen=True)
class Agreement:
    """How two ways of measuring the same predictors agree.

    Attributes:
        scenario: scenario of the trials, all the same ones for all predictors.
        dataset, protocol: of the images, likewise.
        points: predictors, best in physics first.
        pearson: Pearson's correlation of the two rates.
        mmrv: mean maximum rank violation of the rates, 0 at best.
        left_out: predictors that were measured in one way only.
    """

    scenario: str
    dataset: str
    protocol: str
    points: tuple[Both, ...]
    pearson: Measure
    mmrv: Measure
    left_out: tuple[str, ...]

    def to_json(self) -> dict[str, Any]:
        """Return plain data; an undefined measure is None."""
        measures = {
            name: {k: None if np.isnan(v) else float(v) for k, v in vars(measure).items()}
            for name, measure in (("pearson", self.pearson), ("mmrv", self.mmrv))
        }
        points = [
            {"predictor": p.predictor, "physics": p.physics.to_json(), "real": p.real.to_json()}
            for p in self.points
        ]
        told = {"scenario": self.scenario, "dataset": self.dataset, "protocol": self.protocol}
        return told | measures | {"predictors": points, "left_out": list(self.left_out)}


def agreement(runs: Sequence[RunResults], evaluations: Sequence[Evaluation]) -> Agreement:
    """Compare runs of one scenario with evaluations on one data set by one protocol.

    Counted are the trials and the images that all of the predictors tried that are in both. The intervals
    resample objects of the trials and, independently, objects of the images (images where their objects are
    not known), 2,000 times, so that what the predictors have in common stays in common.

    Raises:
        ResultsError: when there are fewer than three such predictors, when a predictor comes twice, or when
            scenarios, data sets or protocols are mixed.
    """
    run_by = _by_name(runs, "run")
    images_by = _by_name(evaluations, "evaluation")
    scenario = _one({r.info.scenario_name for r in runs}, "runs of several scenarios", "scenario")
    dataset = _one({e.dataset for e in evaluations}, "evaluations on several data sets", "data set")
    protocol = _one({e.protocol for e in evaluations}, "evaluations by several protocols", "protocol")
    names = sorted(run_by.keys() & images_by.keys())
    if len(names) < FEWEST:
        raise ResultsError(
            f"only {len(names)} predictors have both a run of {scenario} and an evaluation on {dataset} "
            f"({', '.join(names) or 'none'}); a correlation takes at least {FEWEST}. Measure more of: "
            f"{', '.join(sorted(run_by.keys() ^ images_by.keys())) or 'any'}."
        )
    tried = [{k: r.success for k, r in scenes(run_by[n]).items()} for n in names]
    seen = [{_key(r): r.verdict == "correct" for r in images_by[n].records} for n in names]
    physics, objects = _common(tried, lambda key: key.object)
    real, shown = _common(seen, lambda key: key[0])
    rng = np.random.default_rng(0)
    drawn = [(_rates(physics, objects, rng), _rates(real, shown, rng)) for _ in range(RESAMPLES)]
    a, b = physics.mean(1), real.mean(1)
    points = [Both(n, _counted(p), _counted(r)) for n, p, r in zip(names, physics, real, strict=True)]
    return Agreement(
        scenario,
        dataset,
        protocol,
        tuple(sorted(points, key=lambda p: (-p.physics.rate, p.predictor))),
        _measure(pearson, a, b, drawn),
        _measure(mmrv, a, b, drawn),
        tuple(sorted(run_by.keys() ^ images_by.keys())),
    )


def pearson(simulated: Floats, real: Floats) -> float:
    """Return Pearson's correlation of two rates over predictors; NaN where one is the same for all."""
    if np.ptp(simulated) == 0 or np.ptp(real) == 0:
        return float("nan")
    return float(np.corrcoef(simulated, real)[0, 1])


def mmrv(simulated: Floats, real: Floats) -> float:
    """Return the mean maximum rank violation of simulated rates (N,) against real ones (N,)."""
    worse_simulated = simulated[:, None] < simulated
    worse_real = real[:, None] < real
    gap = np.abs(real[:, None] - real) * (worse_simulated != worse_real)
    return float(gap.max(1).mean())


def agreement_table(found: Agreement) -> TextTable:
    """Return a row a predictor, and the measures in the note."""
    rows = [
        [
            p.predictor,
            *(cell for r in (p.physics, p.real) for cell in (f"{r.successes}/{r.trials}", f"{r.rate:.1%}")),
        ]
        for p in found.points
    ]
    left = f" Measured in one way only, and left out: {', '.join(found.left_out)}." if found.left_out else ""
    return TextTable(
        f"Physics ({found.scenario}) and real images ({found.dataset}, {found.protocol})",
        ("Predictor", "Lifted", "Rate", "Right", "Accuracy"),
        rows,
        note=f"Pearson's correlation {found.pearson}, mean maximum rank violation {found.mmrv}; intervals: "
        f"the middle 95 % of {RESAMPLES} resamples of objects, in trials and images.{left}",
        numbers=(1, 2, 3, 4),
    )


def _by_name(found: Sequence[Found], what: str) -> dict[str, Found]:
    by_name: dict[str, Found] = {}
    for one in found:
        if one.predictor in by_name:
            raise ResultsError(
                f"{one.predictor} has more than one {what}; leave one, to compare like with like."
            )
        by_name[one.predictor] = one
    return by_name


def _one(found: set[str], problem: str, what: str) -> str:
    if len(found) != 1:
        raise ResultsError(
            f"{problem}: {', '.join(sorted(found))}; choose those of one {what}."
            if found
            else f"nothing there to take a {what} from."
        )
    return found.pop()


def _key(record: Record) -> tuple[str, str]:
    return record.object or record.image, record.image


def _common(
    found: Sequence[dict[Key, bool]], cluster: Callable[[Key], str]
) -> tuple[NDArray[np.bool_], NDArray]:
    """Return (predictors, items) verdicts on the items in all, and the number of each one's cluster."""
    keys = sorted(reduce(lambda a, b: a & b, (f.keys() for f in found)))
    if not keys:
        raise ResultsError("the predictors have no trial or image in common; measure all on the same.")
    clusters = np.unique([cluster(k) for k in keys], return_inverse=True)[1]
    return np.array([[f[k] for k in keys] for f in found]), clusters


def _rates(verdicts: NDArray[np.bool_], clusters: NDArray, rng: np.random.Generator) -> Floats:
    """Return the rates (predictors,) of one resample of clusters."""
    count = int(clusters.max()) + 1
    weight = np.bincount(rng.integers(count, size=count), minlength=count)[clusters]
    return verdicts @ weight / weight.sum()


def _counted(verdicts: NDArray[np.bool_]) -> Rate:
    return Rate(int(verdicts.sum()), len(verdicts))


def _measure(
    of: Callable[[Floats, Floats], float], a: Floats, b: Floats, drawn: Sequence[tuple[Floats, Floats]]
) -> Measure:
    values = np.array([of(x, y) for x, y in drawn])
    values = values[~np.isnan(values)]
    low, high = np.quantile(values, [0.025, 0.975]) if len(values) else (np.nan, np.nan)
    return Measure(of(a, b), float(low), float(high))
