"""Many trials: spread over objects, run on workers, written as they end, resumed when killed."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grasp_bench.errors import GraspBenchError
from grasp_bench.objects.catalog import Catalog, sha256
from grasp_bench.paths import assets_dir
from grasp_bench.predictors import BUILT_IN, load_predictor
from grasp_bench.results import RunFolder
from grasp_bench.scenario import Scenario

if TYPE_CHECKING:
    from grasp_bench.predictors.protocol import Predictor
    from grasp_bench.trial import Workcell

PINNED = ("grasp-bench", "mujoco", "dm-control", "mink", "numpy", "scipy", "torch", "opencv-python-headless",
          "trimesh")
"""Distributions whose versions can change a result."""


@dataclass(frozen=True)
class Job:
    """One trial to do: its number, object, and how many tries that object had before."""

    trial: int
    object: str
    attempt: int


@dataclass(frozen=True)
class Settings:
    """What a worker needs to know of the run."""

    scenario: Scenario
    objects: Path
    predictor: str
    seed: int
    renderer: str


def spread(objects: list[str], trials: int) -> list[Job]:
    """Trials spread evenly over objects: every object once, then every object again."""
    return [Job(i, objects[i % len(objects)], i // len(objects)) for i in range(trials)]


def describe(settings: Settings, jobs: list[Job], catalog: Catalog) -> dict[str, Any]:
    """The content of ``run.json``."""
    entry = BUILT_IN.get(settings.predictor)
    weights = None
    if entry is not None and entry.weights is not None:
        path = assets_dir() / "weights" / entry.weights
        weights = {entry.weights: sha256(path)} if path.is_file() else {entry.weights: None}
    names = list(dict.fromkeys(j.object for j in jobs))
    return {
        "format": 1,
        "command": ["grasp-bench", *sys.argv[1:]],
        "predictor": settings.predictor,
        "scenario": settings.scenario.model_dump(mode="json"),
        "seed": settings.seed,
        "trials": len(jobs),
        "objects": {n: catalog.entries[n]["files"] for n in names},
        "weights": weights,
        "versions": {name: version(name) for name in PINNED},
        "renderer": settings.renderer,
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
        "git": _git_revision(),
    }


def _git_revision() -> str | None:
    folder = Path(__file__).parent
    try:
        head = subprocess.run(["git", "describe", "--always", "--dirty", "--abbrev=12"], cwd=folder,
                              text=True, capture_output=True, timeout=10, check=True).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return None
    return head or None


# ---------------------------------------------------------------- inside a worker

_worker: dict[str, Any] = {}


def _start_worker(settings: Settings) -> None:
    """Load once what all trials of a worker share."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[name] = "1"  # one core a worker: threads of two workers would only meet
    import cv2

    from grasp_bench.trial import Workcell

    cv2.setNumThreads(1)
    _worker.update(settings=settings, catalog=Catalog(settings.objects),
                   cell=Workcell(settings.scenario, settings.renderer),
                   predictor=load_predictor(settings.predictor))


def _do(job: Job) -> tuple[dict[str, Any], dict[str, Any]]:
    """One trial in a worker: its record and its timings."""
    return _try(job, **_worker)


def _try(job: Job, settings: Settings, catalog: Catalog, cell: Workcell, predictor: Predictor,
         ) -> tuple[dict[str, Any], dict[str, Any]]:
    from grasp_bench.trial import Outcome, TrialRecord, run_trial

    category = catalog.entries[job.object]["category"]
    try:
        model = catalog.load(job.object)
        done = run_trial(cell, model, predictor, trial=job.trial, attempt=job.attempt, seed=settings.seed)
        record, seconds = done.record, done.clock.seconds
    except Exception as error:  # whatever goes wrong belongs to this trial alone
        detail = f"{type(error).__name__}: {error}"
        record = TrialRecord(job.trial, job.object, category, settings.seed, Outcome.ERROR, detail)
        seconds = {}
    return record.to_json(), {"trial": job.trial} | {k: round(v, 6) for k, v in seconds.items()}


# ---------------------------------------------------------------- in the parent

def failed(job: Job, settings: Settings, category: str, outcome: str, detail: str) -> dict[str, Any]:
    """Record of a trial whose worker did not answer."""
    from grasp_bench.trial import Outcome, TrialRecord

    return TrialRecord(job.trial, job.object, category, settings.seed, Outcome(outcome), detail).to_json()


def run(settings: Settings, jobs: list[Job], out: Path, workers: int,
        progress: Callable[[dict[str, Any], bool], None] = lambda record, resumed: None,
        predictor: Predictor | None = None) -> RunSummary:
    """Do all ``jobs`` that ``out`` does not hold yet.

    Args:
        settings: of the run.
        jobs: all its trials.
        out: results folder.
        workers: processes; 1 runs them in one worker process, too.
        progress: called with each record, and whether it was there before.
        predictor: used in this process, trial after trial, instead of loading ``settings.predictor``
            on workers; for one that no other process can make.

    Raises:
        GraspBenchError: before any trial starts, for anything wrong with the inputs.
    """
    catalog = Catalog(settings.objects)
    for name in dict.fromkeys(j.object for j in jobs):
        model = catalog.load(name)  # every mesh is checked before the first trial
        if not model.graspable_poses:
            raise GraspBenchError(f"{name} has no resting pose in which a grasp fits the gripper")
    if predictor is None:
        load_predictor(settings.predictor)
    with RunFolder(out) as folder:
        done = folder.start(describe(settings, jobs, catalog))
        if done:
            from grasp_bench.results import TRIALS, read_lines

            for record in read_lines(out / TRIALS)[0]:
                progress(record, True)
        todo = [j for j in jobs if j.trial not in done]
        if predictor is not None:
            _run_here(settings, todo, catalog, folder, predictor, progress)
        elif todo:
            _run_pool(settings, todo, catalog, folder, workers, progress)
        folder.finish()  # also where a run was killed after its last trial, before this
        return RunSummary(out, len(done), len(todo), folder.repaired)


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


def _run_here(settings: Settings, jobs: list[Job], catalog: Catalog, folder: RunFolder, predictor: Predictor,
              progress: Callable[[dict[str, Any], bool], None]) -> None:
    from grasp_bench.trial import Workcell

    cell = Workcell(settings.scenario, settings.renderer)
    for job in jobs:
        record, timings = _try(job, settings, catalog, cell, predictor)
        folder.append(record, timings)
        progress(record, False)


def _run_pool(settings: Settings, jobs: list[Job], catalog: Catalog, folder: RunFolder, workers: int,
              progress: Callable[[dict[str, Any], bool], None]) -> None:
    from pebble import ProcessExpired, ProcessPool

    from grasp_bench.spawning import SpawnContext

    context = SpawnContext()
    with ProcessPool(max_workers=min(workers, len(jobs)), initializer=_start_worker, initargs=(settings,),
                     context=context) as pool:
        waiting: dict[Future[tuple[dict[str, Any], dict[str, Any]]], Job] = {
            pool.submit(_do, settings.scenario.trial_timeout, job): job for job in jobs}
        try:
            while waiting:
                ended, _ = wait(waiting, return_when=FIRST_COMPLETED)
                for future in sorted(ended, key=lambda f: waiting[f].trial):
                    job = waiting.pop(future)
                    category = catalog.entries[job.object]["category"]
                    timings: dict[str, Any] = {"trial": job.trial}
                    try:
                        record, timings = future.result()
                    except TimeoutError:
                        record = failed(job, settings, category, "timeout",
                                        f"no answer within {settings.scenario.trial_timeout:g} s")
                    except (ProcessExpired, CancelledError) as error:
                        code = getattr(error, "exitcode", "?")
                        record = failed(job, settings, category, "error",
                                        f"the worker process died (exit code {code})")
                    folder.append(record, timings)
                    progress(record, False)
        except BaseException:
            pool.stop()
            raise
