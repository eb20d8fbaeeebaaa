"""Completion of names in the shell: predictors, scenarios, objects and categories."""

from __future__ import annotations

from collections.abc import Iterable

from grasp_bench.errors import GraspBenchError


def _starting(incomplete: str, names: Iterable[str]) -> list[str]:
    return [n for n in sorted(set(names)) if n.startswith(incomplete)]


def predictors(incomplete: str) -> list[str]:
    """Return the shipped predictors that begin with ``incomplete``."""
    from grasp_bench.predictors.shipped import SHIPPED

    return _starting(incomplete, SHIPPED)


def scenarios(incomplete: str) -> list[str]:
    """Return the shipped scenarios that begin with ``incomplete``."""
    from grasp_bench.scenario.reading import scenario_names

    return _starting(incomplete, scenario_names())


def objects(incomplete: str) -> list[str]:
    """Return the objects and categories that complete the last word of a comma-separated list."""
    from grasp_bench.objects.catalog import Catalog

    before, comma, last = incomplete.rpartition(",")
    try:
        catalog = Catalog()
    except GraspBenchError:
        return []
    return [
        before + comma + n
        for n in _starting(last, ["all", *catalog.names, *catalog.categories, *catalog.sets])
    ]
