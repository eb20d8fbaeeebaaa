"""Success by properties of the trials, and how long they took."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from grasp_bench.objects.catalog import Catalog
from grasp_bench.report.summary import tally
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import Rate

MASS_EDGES = (0.05, 0.1, 0.2, 0.4)
"""Masses between intervals [kg]."""
SIZE_EDGES = (0.06, 0.1, 0.15, 0.2)
"""Longest edges of an object's box between intervals [m]."""
UNKNOWN = "unknown"


@dataclass(frozen=True)
class ObjectFacts:
    """What the catalogue says of an object: family, mass [kg] and longest edge [m]."""

    family: str
    mass: float
    size: float


def object_facts(run: RunResults, catalog: Catalog) -> dict[str, ObjectFacts]:
    """Return facts of the run's objects by name.

    Objects that the catalogue does not hold, or holds with other files, are left out.
    """
    facts = {}
    for name, files in run.info.objects.items():
        entry = catalog.entries.get(name)
        if entry is not None and entry["files"] == files:
            family = str(entry.get("family") or UNKNOWN)
            facts[name] = ObjectFacts(family, float(entry["mass"]), float(max(entry["extents"])))
    return facts


def bin_labels(edges: Sequence[float], factor: float, unit: str) -> list[str]:
    """Return names of the intervals between ``edges`` and beyond them, in ``factor`` times their unit."""
    shown = [f"{factor * e:g}" for e in edges]
    inner = [f"{a}–{b} {unit}" for a, b in pairwise(shown)]
    return [f"< {shown[0]} {unit}", *inner, f"≥ {shown[-1]} {unit}"]


def bin_of(value: float | None, edges: Sequence[float], labels: Sequence[str]) -> str:
    """Return the label of the interval that holds ``value``."""
    return UNKNOWN if value is None else labels[sum(value >= e for e in edges)]


def noise_label(run: RunResults) -> str:
    """Return what a run's depth noise is called: scenario and the noise near the camera [mm]."""
    sigma = (run.info.scenario.get("sensor") or {}).get("axial_sigma")
    level = "noise unknown" if sigma is None else f"σ {1000 * sigma:g} mm"
    return f"{run.info.scenario_label}: {level}"


@dataclass(frozen=True)
class Breakdown:
    """Success by one property of the trials.

    Attributes:
        key, title: short and long name of the property.
        labels: its values or intervals, in their order.
        runs: rate by label, for each run.
    """

    key: str
    title: str
    labels: list[str]
    runs: list[dict[str, Rate]]


def breakdowns(runs: Sequence[RunResults], facts: Sequence[dict[str, ObjectFacts]]) -> list[Breakdown]:
    """Return success by family, mass, size and noise, for each run."""
    masses = bin_labels(MASS_EDGES, 1000, "g")
    sizes = bin_labels(SIZE_EDGES, 1000, "mm")
    kinds: list[tuple[str, str, list[str], Callable[[ObjectFacts | None], str]]] = [
        ("family", "kind of object", [], lambda o: o.family if o else UNKNOWN),
        ("mass", "mass", masses, lambda o: bin_of(o and o.mass, MASS_EDGES, masses)),
        ("size", "size (longest edge)", sizes, lambda o: bin_of(o and o.size, SIZE_EDGES, sizes)),
    ]
    found = []
    for key, title, order, label in kinds:
        by_run = [
            tally((label(known.get(r.object)), r.success) for r in run.records)
            for run, known in zip(runs, facts, strict=True)
        ]
        used = {name for row in by_run for name in row}
        labels = [name for name in order if name in used] or sorted(used - {UNKNOWN})
        labels += [UNKNOWN] if UNKNOWN in used and UNKNOWN not in labels else []
        found.append(Breakdown(key, title, labels, by_run))
    noises = [noise_label(r) for r in runs]
    rates = [{name: r.lifted} for r, name in zip(runs, noises, strict=True)]
    return [*found, Breakdown("noise", "noise of the depth image", list(dict.fromkeys(noises)), rates)]


@dataclass(frozen=True)
class Category:
    """Success at a category of objects: for each run that met it, and for all together."""

    category: str
    cells: list[Rate | None]
    all: Rate


def by_category(runs: Sequence[RunResults]) -> list[Category]:
    """Return success by category; those that failed most come first."""
    by_run = [tally((r.category, r.success) for r in run.records) for run in runs]
    rows = []
    for name in {c for row in by_run for c in row}:
        cells = [row.get(name) for row in by_run]
        total = Rate(sum(c.successes for c in cells if c), sum(c.trials for c in cells if c))
        rows.append(Category(name, cells, total))
    return sorted(rows, key=lambda r: (r.all.rate, -r.all.trials, r.category))


@dataclass(frozen=True)
class Quantiles:
    """Seconds: median and 95th percentile."""

    median: float
    p95: float


@dataclass(frozen=True)
class Latency:
    """Wall time of a run's trials.

    Attributes:
        phases: mean seconds by phase.
        predict, total: seconds of predicting, and of a whole trial; None where nothing is known.
    """

    phases: dict[str, float]
    predict: Quantiles | None
    total: Quantiles | None


def latency(run: RunResults) -> Latency:
    """Return how long a run's trials took."""
    table = run.timings
    phases = [c for c in table.columns if c != "trial"] if len(table) else []
    if not phases:
        return Latency({}, None, None)
    spent = table[phases].fillna(0.0)

    def quantiles(values: Any) -> Quantiles:
        return Quantiles(float(values.median()), float(values.quantile(0.95)))

    return Latency(
        {p: float(spent[p].mean()) for p in phases},
        quantiles(table["predict"].dropna()) if "predict" in table else None,
        quantiles(spent.sum(axis=1)),
    )
