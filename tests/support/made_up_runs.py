"""Run folders made up for tests, without a trial being tried."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from grasp_bench.runs.folder import RunFolder
from grasp_bench.runs.info import RunInfo
from grasp_bench.runs.jobs import WHOLE, Shard, spread
from grasp_bench.runs.record import Timings, TrialRecord

OBJECTS = ("mug", "pan", "pot")
RUN: dict[str, Any] = {
    "format": 1,
    "command": ["grasp-bench", "run"],
    "predictor": "oracle",
    "scenario": {"name": "table4"},
    "seed": 4,
    "trials": 9,
    "objects": {o: {"object.json": o * 2} for o in OBJECTS},
    "weights": None,
    "versions": {"mujoco": "3.17"},
    "renderer": "raycast",
    "python": "3.11",
    "platform": "Linux x86_64",
    "cpu": "one",
    "git": None,
}


def record(trial: int, success: bool = True, objects: tuple[str, ...] = OBJECTS) -> dict[str, Any]:
    """A trial's record."""
    return {
        "trial": trial,
        "object": objects[trial % len(objects)],
        "category": "kitchen",
        "seed": 4,
        "outcome": "success" if success else "missed",
        "success": success,
        "detail": "" if success else "nothing held",
        "lift_height": 0.2 if success else 0.0,
    }


def write_run(
    folder: Path,
    trials: int = 9,
    wins: Callable[[int], bool] = lambda trial: True,
    shard: Shard = WHOLE,
    only: Iterable[int] | None = None,
    order: int = 1,
    change: Callable[[dict[str, Any]], dict[str, Any]] = lambda record: record,
    **run: Any,
) -> Path:
    """A run's folder: ``only`` these trials of ``shard``, written in ``order`` and not put in order."""
    content: dict[str, Any] = RUN | {"trials": trials} | run
    if shard != WHOLE:
        content["shard"] = str(shard)
    objects: tuple[str, ...] = tuple(content["objects"])
    seed = {"seed": content["seed"]}
    with RunFolder(folder) as results:
        results.start(RunInfo.read(content))
        wanted = None if only is None else set(only)
        for job in spread(objects, trials, shard)[::order]:
            if wanted is None or job.trial in wanted:
                line = TrialRecord.read(change(record(job.trial, wins(job.trial), objects) | seed))
                results.append(line, Timings.read({"trial": job.trial, "plan": 0.5}))
    return folder


def finish(folder: Path) -> Path:
    """Put a run's trials in order, as its end does."""
    with RunFolder(folder) as results:
        results.finish()
    return folder
