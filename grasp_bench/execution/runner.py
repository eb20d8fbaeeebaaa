"""Many trials: spread over objects, given to an executor, written as they end, resumed when killed."""

from __future__ import annotations

import platform
import subprocess
import sys
from collections.abc import Callable, Generator, Iterable
from contextlib import closing
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grasp_bench.errors import GraspBenchError, ResultsError
from grasp_bench.execution.executors import Executor, Fault, Here, make_executor
from grasp_bench.objects.catalog import Catalog
from grasp_bench.predictors.identity import identify
from grasp_bench.predictors.names import parse
from grasp_bench.runs.folder import FORMAT, RunFolder
from grasp_bench.runs.jobs import WHOLE, Job, Jobs, Settings, Shard, spread
from grasp_bench.system.machine import cpu_name

if TYPE_CHECKING:
    from grasp_bench.predictors.protocol import Predictor

__all__ = ["PINNED", "Job", "Jobs", "RunSummary", "Settings", "Shard", "describe", "run", "spread"]

PINNED = (
    "grasp-bench",
    "mujoco",
    "dm-control",
    "mink",
    "numpy",
    "scipy",
    "torch",
    "opencv-python-headless",
    "trimesh",
)
"""Distributions whose versions can change a result."""


@dataclass(frozen=True)
class RunSummary:
    """What a call of :func:`run` did.

    Attributes:
        folder: of the results.
        resumed: trials found done.
        added: trials done now.
        repaired: a torn last line was cut off.
    """

    folder: Path
    resumed: int
    added: int
    repaired: bool


def objects_of(settings: Settings, jobs: Jobs, catalog: Catalog) -> list[str]:
    """All objects that a run may meet: those of its jobs, and in clutter those that episodes draw from."""
    if settings.scenario.clutter is not None:
        return catalog.chosen(settings.scenario.objects.names)
    return jobs.used


def describe(
    settings: Settings, jobs: Jobs, catalog: Catalog, implementation: dict[str, Any] | None = None
) -> dict[str, Any]:
    """The content of ``run.json``; ``implementation`` is what :func:`identify` says of the predictor."""
    weights = parse(settings.predictor).weights
    shard = {} if jobs.shard == WHOLE else {"shard": str(jobs.shard)}
    return {
        "format": FORMAT,
        "command": ["grasp-bench", *sys.argv[1:]],
        "predictor": settings.predictor,
        "implementation": implementation,
        "scenario": settings.scenario.model_dump(mode="json"),
        "seed": settings.seed,
        "trials": jobs.total,
        **shard,
        "objects": {n: catalog.entries[n]["files"] for n in objects_of(settings, jobs, catalog)},
        "weights": None if weights is None else {weights.name: weights.digest},
        "versions": {name: version(name) for name in PINNED},
        "renderer": settings.renderer,
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
        "cpu": cpu_name(),
        "git": _git_revision(),
    }


def _git_revision() -> str | None:
    folder = Path(__file__).parent
    try:
        head = subprocess.run(
            ["git", "describe", "--always", "--dirty", "--abbrev=12"],
            cwd=folder,
            text=True,
            capture_output=True,
            timeout=10,
            check=True,
        ).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return None
    return head or None


def run(
    settings: Settings,
    jobs: Jobs,
    out: Path,
    workers: int,
    progress: Callable[[dict[str, Any], bool], None] = lambda record, resumed: None,
    predictor: Predictor | None = None,
    executor: Executor | None = None,
) -> RunSummary:
    """Do all ``jobs`` that ``out`` does not hold yet.

    Args:
        settings: of the run.
        jobs: all its trials.
        out: results folder.
        workers: processes; 1 runs them in one worker process, too.
        progress: called with each record, and whether it was there before.
        predictor: used in this process, trial after trial, instead of loading ``settings.predictor``
            on workers; for one that no other process can make.
        executor: what carries the trials out; worker processes of this machine by default.

    Raises:
        GraspBenchError: before any trial starts, for anything wrong with the inputs.
    """
    catalog = Catalog(settings.objects)
    for name in objects_of(settings, jobs, catalog):
        model = catalog.load(name)  # every mesh is checked before the first trial
        if not model.graspable_poses:
            raise GraspBenchError(f"{name} has no resting pose in which a grasp fits the gripper")
    implementation = identify(settings.predictor, predictor)

    def found(record: dict[str, Any]) -> None:
        trial = record["trial"]
        if not jobs.holds(trial) or jobs.job(trial).object != record["object"]:
            raise ResultsError(
                f"{out} holds trial {trial} on {record['object']}, which is none of this run; "
                "its files were mixed up. Restore them, or choose another --out."
            )
        progress(record, True)

    with RunFolder(out) as folder:
        done = folder.start(describe(settings, jobs, catalog, implementation), found)
        todo = len(jobs) - len(done)
        if todo:
            chosen = executor or (
                make_executor("process", min(workers, todo)) if predictor is None else Here(predictor)
            )
            left = (j for j in jobs if j.trial not in done)
            with closing(carry_out(settings, left, catalog, chosen)) as ended:
                for record, timings in ended:
                    folder.append(record, timings)
                    progress(record, False)
        folder.finish()  # also where a run was killed after its last trial, before this
        return RunSummary(out, len(done), todo, folder.repaired)


def carry_out(
    settings: Settings, jobs: Iterable[Job], catalog: Catalog, executor: Executor
) -> Generator[tuple[dict[str, Any], dict[str, Any]], None, None]:
    """Records and timings of ``jobs``, as they end; faults become records of their kind."""
    with closing(executor.run(settings, jobs)) as answers:
        for answer in answers:
            if isinstance(answer, Fault):
                category = catalog.entries[answer.job.object]["category"]
                yield failed(answer, settings, category), {"trial": answer.job.trial}
            else:
                yield answer.record, answer.timings


def failed(fault: Fault, settings: Settings, category: str) -> dict[str, Any]:
    """Record of a trial whose worker did not answer."""
    from grasp_bench.trials.attempt import TrialRecord

    job = fault.job
    return TrialRecord(job.trial, job.object, category, settings.seed, fault.outcome, fault.detail).to_json()
