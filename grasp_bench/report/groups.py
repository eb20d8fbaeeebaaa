"""The runs of a folder in order: grouped by what they tried, best first, controls last."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TypeVar

from grasp_bench.predictors.shipped import SHIPPED
from grasp_bench.report.compare import REFERENCE
from grasp_bench.report.summary import Summary
from grasp_bench.runs.folder import TRIALS
from grasp_bench.runs.info import RunInfo
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import Rate

T = TypeVar("T")
PAPERS = "table4"
"""Scenario that stands beside the paper's Table 4."""
DEVELOPED_ON = 0
"""Seed of that scenario on whose trials the planner and the shipped weights were developed."""
LATER = 10.0
"""Seconds by which a run must be newer than all others to be the one that was made last."""


@dataclass(frozen=True)
class Group:
    """Runs that stand in one table.

    Attributes:
        title: what all of them tried.
        scenario: label of their scenario; None where they have several.
        runs: their positions in the list, best first, controls last.
        seeds: their seeds, in order.
        pooled: successes of each predictor's runs together, best first, where all of them tried the same with
            the same several seeds; else empty.
        alike: whether all are of the same scenario, seed, objects and number of trials.
        of_the_paper: whether the rows of the paper's Table 4 belong above these.
    """

    title: str
    scenario: str | None
    runs: tuple[int, ...]
    seeds: tuple[int, ...]
    pooled: Mapping[str, Rate]
    alike: bool
    of_the_paper: bool


def is_control(predictor: str) -> bool:
    """Return whether a predictor is a control: a bound or a heuristic, no contestant."""
    return predictor in SHIPPED and SHIPPED[predictor].kind == "control"


def beside_the_paper(run: RunInfo) -> bool:
    """Return whether a run's rate belongs below the rows of the paper's Table 4."""
    return run.scenario_name == PAPERS and not run.cluttered


def grouped(runs: Sequence[Summary], first: int | None = None) -> list[Group]:
    """Return all runs in groups, the one that holds run ``first`` leading, larger ones before smaller.

    Runs of the same scenario, seed, objects and number of trials are a group, and such groups of the same
    predictors with other seeds are one; those that would stand alone are put together by scenario, and what
    is left then is the last group.
    """
    alike = _by(range(len(runs)), lambda i: _tried(runs[i]))
    groups = [g for g in alike if len(g) > 1 or g[0] == first]
    groups = [
        [i for g in of_seeds for i in g] for of_seeds in _by(groups, lambda g: _but_for_seed(g, runs, first))
    ]
    rest = [g[0] for g in alike if len(g) == 1 and g[0] != first]
    alone = []
    for found in _by(rest, lambda i: runs[i].info.scenario_label):
        label = runs[found[0]].info.scenario_label
        if len(found) > 1 or label in {runs[g[0]].info.scenario_label for g in groups}:
            groups.append(found)
        else:
            alone += found
    groups.sort(key=lambda g: (first not in g, not _same(g, runs), -len(g), runs[g[0]].run))
    return [_group(g, runs) for g in [*groups, *([alone] if alone else [])]]


def _group(found: Sequence[int], runs: Sequence[Summary]) -> Group:
    labels = list(dict.fromkeys(runs[i].info.scenario_label for i in found))
    seeds = tuple(sorted({runs[i].info.seed for i in found}))
    pooled = _pooled(found, runs) if len(labels) == 1 and len(seeds) > 1 else {}
    standing = list(pooled)

    def place(i: int) -> tuple[object, ...]:
        predictor, rate = runs[i].info.predictor, runs[i].lifted.rate
        together = standing.index(predictor) if pooled else 0
        return is_control(predictor), together, -rate, runs[i].run

    order = sorted(found, key=place)
    counts = sorted({_planned(runs[i]) for i in order})
    if len(counts) > 1:
        trials = f"{counts[0]} to {counts[-1]} trials"
    else:
        trials = f"{counts[0]} {_unit(runs[order[0]])}{' each' if len(seeds) + len(labels) > 2 else ''}"
    scenario = labels[0] if len(labels) == 1 else f"{len(labels)} scenarios"
    of_the_paper = all(beside_the_paper(runs[i].info) for i in order)
    developed = "development " if of_the_paper and seeds == (DEVELOPED_ON,) else ""
    return Group(
        f"{scenario}, {developed}{_seeds(seeds)}, {trials}",
        labels[0] if len(labels) == 1 else None,
        tuple(order),
        seeds,
        pooled,
        _same(order, runs),
        of_the_paper,
    )


def _pooled(found: Sequence[int], runs: Sequence[Summary]) -> dict[str, Rate]:
    """Return each predictor's successes of all seeds, best first, controls last; nothing unless each has one
    run with each seed."""
    seeds = {runs[i].info.seed for i in found}
    by = {runs[g[0]].info.predictor: g for g in _by(found, lambda i: runs[i].info.predictor)}
    if any(len(g) != len(seeds) or {runs[i].info.seed for i in g} != seeds for g in by.values()):
        return {}
    summed = {
        predictor: Rate(sum(runs[i].lifted.successes for i in g), sum(runs[i].lifted.trials for i in g))
        for predictor, g in by.items()
    }
    return dict(sorted(summed.items(), key=lambda item: (is_control(item[0]), -item[1].rate, item[0])))


def _but_for_seed(group: list[int], runs: Sequence[Summary], first: int | None) -> tuple[object, ...]:
    """Return what groups share that differ in nothing but the seed: scenario, objects and predictors.

    The group of run ``first``, and one with two runs of a predictor, share it with none.
    """
    predictors = sorted(runs[i].info.predictor for i in group)
    if first in group or len(predictors) != len(set(predictors)):
        return tuple(group)
    scenario, _, *tried = _tried(runs[group[0]])
    return scenario, *tried, *predictors


def _tried(run: Summary) -> tuple[object, ...]:
    """Return what makes the trials of two runs the same ones."""
    count = max(run.info.trials, run.lifted.trials)  # of a race's, whoever left it when
    return run.info.scenario_label, run.info.seed, count, *run.info.tried[:count]


def _same(found: Sequence[int], runs: Sequence[Summary]) -> bool:
    return len({_tried(runs[i]) for i in found}) == 1


def _by(found: Iterable[T], key: Callable[[T], object]) -> list[list[T]]:
    """Return things by a key, in the order in which the keys first come."""
    groups: dict[object, list[T]] = {}
    for i in found:
        groups.setdefault(key(i), []).append(i)
    return list(groups.values())


def _planned(run: Summary) -> int:
    return max(run.planned, run.lifted.trials)


def _unit(run: Summary) -> str:
    if run.clutter is not None:
        return "tables"
    return "trial" if _planned(run) == 1 else "trials"


def _seeds(seeds: Sequence[int]) -> str:
    if len(seeds) == 1:
        return f"seed {seeds[0]}"
    whole = all(b - a == 1 for a, b in pairwise(seeds))
    return f"seeds {seeds[0]} to {seeds[-1]}" if whole else f"seeds {', '.join(map(str, seeds))}"


# ---------------------------------------------------------------- which run is looked at


def made_last(runs: Sequence[RunResults], names: Sequence[str]) -> int | None:
    """Return the position of the run that a person has just made, None where none stands out.

    Runs in folders of their own below the root (``reference/oracle``) are collections and do not count. A
    fresh copy of files, all as new as each other, has no such run unless it is the only one.
    """
    own = [i for i, name in enumerate(names) if "/" not in name]
    if len(runs) == 1:
        return 0
    if not own:
        return None
    ages = sorted(((_written(runs[i].folder), i) for i in own), reverse=True)
    others = [_written(run.folder) for i, run in enumerate(runs) if i != ages[0][1]]
    return ages[0][1] if ages[0][0] > max(others) + LATER else None


def leading(groups: Sequence[Group]) -> list[int]:
    """Return the runs of the first group, and where it is one run, those of the largest of its scenario."""
    lead, *rest = groups
    if len(lead.runs) > 1 or lead.scenario is None:
        return list(lead.runs)
    others = [g for g in rest if g.scenario == lead.scenario and g.alike]
    return [*lead.runs, *(max(others, key=lambda g: len(g.runs)).runs if others else ())]


def newest(
    runs: Sequence[RunResults], names: Sequence[str], groups: Sequence[Group], count: int = 4
) -> list[int]:
    """Return the runs to show first: those made last, then the best of :func:`leading`."""
    mine = made_last(runs, names)
    own = sorted(
        (i for i, name in enumerate(names) if "/" not in name), key=lambda i: -_written(runs[i].folder)
    )
    order = own if mine is not None else []
    lead = reference(runs, groups)
    return list(dict.fromkeys([*order, lead, *leading(groups)]))[:count]


def reference(runs: Sequence[RunResults], groups: Sequence[Group]) -> int:
    """Return the run that others are compared with at first: htc-grasp's, or the leading group's best."""
    found = [i for i in groups[0].runs if runs[i].predictor == REFERENCE]
    return found[0] if found else groups[0].runs[0]


def _written(folder: Path) -> float:
    try:
        return (folder / TRIALS).stat().st_mtime
    except OSError:
        return 0.0
