"""The runs that are committed, whatever else a checkout's results folder holds meanwhile."""

from __future__ import annotations

from pathlib import Path

from grasp_bench.runs.folder import find_runs

RESULTS = Path(__file__).parents[2] / "results"
KINDS = ("baseline", "reference", "seeds", "suites")


def committed_runs() -> list[Path]:
    """Return their folders, sorted."""
    return sorted(run for kind in KINDS for run in find_runs(RESULTS / kind))
