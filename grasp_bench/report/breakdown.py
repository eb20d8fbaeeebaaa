"""Success by what a trial was like, and predicted quality against what happened."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from typing import Any

from grasp_bench.objects.catalog import Catalog
from grasp_bench.report.table4 import rate_of

MASS_EDGES = (0.05, 0.1, 0.2, 0.4)
"""Kilograms."""
SIZE_EDGES = (0.06, 0.1, 0.15, 0.2)
"""Longest edge of an object's box [m]."""
UNKNOWN = "unknown"


def object_facts(run: Run, catalog: Catalog) -> dict[str, dict[str, Any]]:
    """``family``, ``mass`` [kg] and ``size`` (longest edge [m]) of the run's objects.

    Objects that the catalogue does not hold, or holds with other files, are left out.
    """
    facts = {}
    for name, files in (run.info.get("objects") or {}).items():
        entry = catalog.entries.get(name)
        if entry is not None and entry["files"] == files:
            facts[name] = {
                "family": str(entry.get("family") or UNKNOWN),
                "mass": float(entry["mass"]),
                "size": float(max(entry["extents"])),
            }
    return facts


def bin_labels(edges: Sequence[float], factor: float, unit: str) -> list[str]:
    """Names of the intervals between ``edges`` and beyond them, in ``factor`` times their unit."""
    shown = [f"{factor * e:g}" for e in edges]
    inner = [f"{a}–{b} {unit}" for a, b in pairwise(shown)]
    return [f"< {shown[0]} {unit}", *inner, f"≥ {shown[-1]} {unit}"]


def bin_of(value: float | None, edges: Sequence[float], labels: Sequence[str]) -> str:
    """The label of the interval that holds ``value``."""
    return UNKNOWN if value is None else labels[sum(value >= e for e in edges)]


def tally(pairs: Iterable[tuple[str, bool]]) -> dict[str, dict[str, Any]]:
    """Rate by label of (label, success) pairs."""
    counts: dict[str, list[int]] = {}
    for label, success in pairs:
        count = counts.setdefault(label, [0, 0])
        count[0] += success
        count[1] += 1
    return {label: rate_of(k, n) for label, (k, n) in counts.items()}


def noise_label(run: Run) -> str:
    """What a run's depth noise is called: scenario and the noise near the camera [mm]."""
    scenario = run.info["scenario"]
    sigma = (scenario.get("sensor") or {}).get("axial_sigma")
    level = "noise unknown" if sigma is None else f"σ {1000 * sigma:g} mm"
    return f"{scenario.get('name', 'scenario')}: {level}"


def breakdowns(runs: Sequence[Run], facts: Sequence[dict[str, dict[str, Any]]]) -> list[dict[str, Any]]:
    """Success by family, mass, size and noise, for each run.

    Returns:
        One dictionary a kind with ``key``, ``title``, ``labels`` in their order and ``runs``, a
        list with one dictionary a run from label to rate.
    """
    masses = bin_labels(MASS_EDGES, 1000, "g")
    sizes = bin_labels(SIZE_EDGES, 1000, "mm")

    def of(name: str, key: str, known: dict[str, dict[str, Any]]) -> Any:
        return known.get(name, {}).get(key)

    kinds: list[tuple[str, str, list[str], Callable[[str, dict[str, dict[str, Any]]], str]]] = [
        ("family", "kind of object", [], lambda n, f: of(n, "family", f) or UNKNOWN),
        ("mass", "mass", masses, lambda n, f: bin_of(of(n, "mass", f), MASS_EDGES, masses)),
        ("size", "size (longest edge)", sizes, lambda n, f: bin_of(of(n, "size", f), SIZE_EDGES, sizes)),
    ]
    found = []
    for key, title, order, label in kinds:
        by_run = [
            tally(
                (label(str(n), known), bool(s))
                for n, s in run.trials[["object", "success"]].itertuples(index=False)
            )
            for run, known in zip(runs, facts, strict=True)
        ]
        used = {name for row in by_run for name in row}
        labels = [name for name in order if name in used] or sorted(used - {UNKNOWN})
        labels += [UNKNOWN] if UNKNOWN in used and UNKNOWN not in labels else []
        found.append({"key": key, "title": title, "labels": labels, "runs": by_run})
    noises = [noise_label(r) for r in runs]
    rates = [{name: rate_of(r.successes, len(r))} for r, name in zip(runs, noises, strict=True)]
    labels = list(dict.fromkeys(noises))
    return [*found, {"key": "noise", "title": "noise of the depth image", "labels": labels, "runs": rates}]


def by_category(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """One row a category with a rate (or None) a run; those that failed most come first."""
    by_run = [
        tally((str(c), bool(s)) for c, s in run.trials[["category", "success"]].itertuples(index=False))
        for run in runs
    ]
    rows = []
    for name in {c for row in by_run for c in row}:
        cells = [row.get(name) for row in by_run]
        total = rate_of(sum(c["successes"] for c in cells if c), sum(c["trials"] for c in cells if c))
        rows.append({"category": name, "cells": cells, "all": total})
    return sorted(rows, key=lambda r: (r["all"]["rate"], -r["all"]["trials"], r["category"]))


def calibration(run: Run, bins: int = 10) -> dict[str, Any]:
    """Predicted quality of the grasps that were tried against how often they held.

    Returns:
        ``bins``: for each interval of quality with a trial in it the mean ``quality`` and the rate;
        ``trials`` with a grasp, ``error``: expected calibration error (Guo et al., ICML 2017: the
        mean over trials of |quality − rate| of their bins), ``brier``: mean squared difference of
        quality and outcome. Both are None where no trial has a grasp.
    """
    table = run.trials
    known = table[table["grasp_quality"].notna()] if "grasp_quality" in table else table.iloc[:0]
    if known.empty:
        return {"bins": [], "trials": 0, "error": None, "brier": None}
    quality = known["grasp_quality"].astype(float).clip(0, 1)
    success = known["success"].astype(bool)
    rows, error = [], 0.0
    for _, index in quality.groupby((quality * bins).astype(int).clip(upper=bins - 1)).groups.items():
        mean, count = float(quality[index].mean()), len(index)
        row = {"quality": mean, **rate_of(int(success[index].sum()), count)}
        rows.append(row)
        error += count * abs(mean - row["rate"])
    return {
        "bins": rows,
        "trials": len(known),
        "error": error / len(known),
        "brier": float(((quality - success) ** 2).mean()),
    }


def latency(run: Run) -> dict[str, Any]:
    """Mean seconds by ``phases``, and median and 95th percentile of predicting and of a whole trial."""
    table = run.timings
    phases = [c for c in table.columns if c != "trial"] if len(table) else []
    if not phases:
        return {"phases": {}, "predict": None, "total": None}
    spent = table[phases].fillna(0.0)

    def quantiles(values: Any) -> dict[str, float]:
        return {"median": float(values.median()), "p95": float(values.quantile(0.95))}

    return {
        "phases": {p: float(spent[p].mean()) for p in phases},
        "predict": quantiles(table["predict"].dropna()) if "predict" in table else None,
        "total": quantiles(spent.sum(axis=1)),
    }
