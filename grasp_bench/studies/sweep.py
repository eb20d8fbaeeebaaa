"""Runs for several values of one scenario parameter, each in a resumable folder of its own.

All values see the same objects in the same places with the same random numbers, so a value is compared with
the scenario's own trial by trial: which were lost, which were gained, and how likely that is by chance.
"""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from grasp_bench import api
from grasp_bench.errors import ScenarioError
from grasp_bench.runs.folder import load_records
from grasp_bench.runs.record import TrialRecord
from grasp_bench.runs.statistics import mcnemar, wilson
from grasp_bench.scenario.reading import with_value
from grasp_bench.scenario.sections import Scenario
from grasp_bench.system.yaml_text import read_yaml

REFERENCE = "reference"
"""Folder of the run whose value is the scenario's own; shared by sweeps over other parameters."""


@dataclass(frozen=True)
class Point:
    """One value of a sweep, for one predictor.

    Attributes:
        low, high: 95 % Wilson interval of the rate.
        lost, gained: trials that the scenario's own value won and this one did not, and the reverse; None
            where the sweep does not hold the own value.
        p: two-sided exact McNemar p-value of that difference.
        folder: the run's folder, below the sweep's.
    """

    predictor: str
    value: Any
    successes: int
    trials: int
    rate: float
    low: float
    high: float
    lost: int | None
    gained: int | None
    p: float | None
    folder: str


@dataclass(frozen=True)
class Sweep:
    """A finished sweep.

    Attributes:
        parameter: dotted name, such as ``gripper.force``.
        scenario, own: name of the scenario that was varied, and its own value.
        seed: seed of all runs.
        points: results by predictor, then in the order of the values.
    """

    parameter: str
    scenario: str
    own: Any
    seed: int
    points: tuple[Point, ...]

    @property
    def predictors(self) -> list[str]:
        """Names, in order."""
        return list(dict.fromkeys(p.predictor for p in self.points))

    def as_json(self) -> str:
        """Return all of it as JSON."""
        return json.dumps(asdict(self), indent=1, ensure_ascii=False) + "\n"

    def as_csv(self) -> str:
        """Return the points as comma-separated values."""
        text = io.StringIO()
        table = csv.writer(text, lineterminator="\n")
        counts, rates = ("successes", "trials"), ("rate", "low", "high")
        table.writerow(["parameter", "value", "predictor", *counts, *rates, "lost", "gained", "p"])
        for p in self.points:
            shares = (f"{share:.4f}" for share in (p.rate, p.low, p.high))
            chance = None if p.p is None else f"{p.p:.3g}"
            own = (self.parameter, p.value, p.predictor, p.successes, p.trials)
            table.writerow([*own, *shares, p.lost, p.gained, chance])
        return text.getvalue()


def read_values(text: str) -> list[Any]:
    """Read values from ``0,0.001,0.002`` or ``[0.5, 0, 0.5],[0.5, 0, 0.6]``, as YAML reads them.

    Raises:
        ScenarioError: for what is not such a list, holds nothing, or a value twice.
    """
    try:
        values = read_yaml(f"[{text}]")
    except ValueError as error:
        raise ScenarioError(f"--values must be like 0,0.001,0.002, not {text!r}.") from error
    values = [
        float(v) if isinstance(v, str) and re.fullmatch(r"[+-]?\d+(\.\d*)?[eE][+-]?\d+", v) else v
        for v in values
    ]  # YAML 1.1 takes 1e-3 for text
    if not values or any(v is None for v in values):
        raise ScenarioError(f"--values must name at least one value, and no empty one, not {text!r}.")
    if len({str(v) for v in values}) < len(values):
        raise ScenarioError(f"--values names a value twice: {text}.")
    return values


def varied(base: Scenario, parameter: str, values: Sequence[Any]) -> dict[str, tuple[Any, Scenario]]:
    """Return folder name → value and scenario, all validated; the scenario's own value is ``reference``.

    Raises:
        UnknownNameError: for an unknown parameter.
        ScenarioError: for a value that is not valid.
    """
    found: dict[str, tuple[Any, Scenario]] = {}
    for value in values:
        scenario = with_value(base, parameter, value)
        if scenario.model_copy(update={"name": base.name}) == base:
            found[REFERENCE] = value, base
        else:
            found[f"{parameter}={re.sub(r'[^A-Za-z0-9.+-]+', '_', str(value))}"] = value, scenario
    return found


def sweep(
    parameter: str,
    values: Sequence[Any],
    base: Scenario,
    out: Path,
    *,
    predictors: Sequence[str] = ("htc-grasp",),
    objects: Any = None,
    trials: int | None = None,
    seed: int = 0,
    workers: int | None = None,
    progress: Callable[[str, TrialRecord, bool], None] | None = None,
) -> Sweep:
    """Run every value for every predictor, and put the figures together.

    Args:
        parameter: dotted name of a scenario's value.
        values: values to try.
        base: scenario of all other values.
        out: folder; holds ``PREDICTOR/VALUE/`` and may be shared by sweeps of the same scenario.
        predictors, objects, trials, seed, workers: as :func:`grasp_bench.api.run` takes them.
        progress: called with predictor and value in words, each record, and whether it was there before.

    Raises:
        GraspBenchError: before the first trial, for anything wrong with the inputs.
    """
    scenarios = varied(base, parameter, values)
    points: list[Point] = []
    for predictor in predictors:
        label = re.sub(r"[^A-Za-z0-9.-]+", "-", predictor)
        won: dict[str, dict[int, bool]] = {}
        for name, (value, scenario) in scenarios.items():
            words = f"{predictor}, {parameter} = {value}"
            api.run(
                objects,
                trials,
                predictor,
                scenario,
                seed=seed,
                workers=workers,
                out=out / label / name,
                progress=False
                if progress is None
                else lambda record, resumed, words=words: progress(words, record, resumed),
            )
            won[name] = {r.trial: r.success for r in load_records(out / label / name)}
        points += [
            _point(predictor, value, won[name], won.get(REFERENCE), f"{label}/{name}")
            for name, (value, _) in scenarios.items()
        ]
    own: Any = base.model_dump(mode="json")
    for key in parameter.split("."):
        own = None if own is None else own[key]
    return Sweep(parameter, base.name, own, seed, tuple(points))


def _point(
    predictor: str, value: Any, won: dict[int, bool], reference: dict[int, bool] | None, folder: str
) -> Point:
    successes, trials = sum(won.values()), len(won)
    lost = gained = p = None
    if reference is not None:
        lost = sum(reference[t] and not won[t] for t in won)
        gained = sum(won[t] and not reference[t] for t in won)
        p = mcnemar(lost, gained)
    rate, (low, high) = successes / trials, wilson(successes, trials)
    return Point(predictor, value, successes, trials, rate, low, high, lost, gained, p, folder)
