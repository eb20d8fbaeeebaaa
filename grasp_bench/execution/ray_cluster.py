"""Trials on a Ray cluster, or on Ray on this machine.

Ray decides where a trial is done and does it again elsewhere when a node dies. On a node a
trial runs in a worker process of the same kind as without Ray, with the same limits and the
same faults, so that the records are the same, too. A node whose objects, weights or versions
differ from this machine's refuses to work.
"""

from __future__ import annotations

import os
import platform
import uuid
from collections.abc import Generator, Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any

from grasp_bench.errors import GraspBenchError
from grasp_bench.execution.describe import describe
from grasp_bench.execution.memory import fair_share
from grasp_bench.execution.processes import WorkerPool
from grasp_bench.execution.protocol import Answer, Fault
from grasp_bench.objects.catalog import Catalog
from grasp_bench.runs.differences import listed
from grasp_bench.runs.info import Group, RunInfo
from grasp_bench.runs.jobs import Job, Settings, spread
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.system.machine import usable_cores

RETRIES = 5
"""Times that Ray begins a trial again whose node or process is gone."""


@dataclass(frozen=True)
class _Task:
    """What a node needs to know of a run.

    Attributes:
        key: name of the run's pools.
        settings: settings on the driver.
        shipped: whether the objects are those that travel with the package.
        stack: objects, weights and versions on the driver.
        memory_limit: most memory of a worker [bytes].
        folder: the driver's current folder, which may hold the user's predictor.
    """

    key: str
    settings: Settings
    shipped: bool
    stack: RunInfo
    memory_limit: int | None
    folder: str


@dataclass(frozen=True)
class _Refusal:
    """A node that cannot work, and why."""

    why: str


class RayCluster:
    """Executor on Ray.

    Args:
        workers: trials at a time at most; 0 takes all cores of the machine or cluster.
        address: ``auto`` or ``HOST:PORT`` of a running cluster; without one, Ray is started here.
        memory_limit: most memory of a worker [bytes]; by default its share of 80 % of its machine's.

    Raises:
        GraspBenchError: when Ray is not installed.
    """

    def __init__(self, workers: int = 0, address: str | None = None, memory_limit: int | None = None) -> None:
        self.workers, self.address, self.memory_limit = workers, address, memory_limit
        self._ray = _import_ray()

    def run(self, settings: Settings, jobs: Iterable[Job]) -> Generator[Answer | Fault, None, None]:
        """See :class:`~grasp_bench.execution.protocol.Executor`."""
        ray = self._ray
        ours = not ray.is_initialized()
        if ours:
            self._connect()
        waiting: dict[Any, Job] = {}
        try:
            task = ray.put(_task(settings, self.memory_limit))
            trial = ray.remote(num_cpus=1, max_retries=RETRIES, scheduling_strategy="SPREAD")(_trial)
            source = iter(jobs)
            while True:
                for job in islice(source, max(0, self._window() - len(waiting))):
                    waiting[trial.remote(task, job)] = job
                if not waiting:
                    return
                ready, _ = ray.wait(list(waiting), num_returns=1)
                for reference in ready:
                    yield self._result(reference, waiting.pop(reference))
        finally:
            with suppress(Exception):  # the cluster may be gone
                for reference in waiting:
                    ray.cancel(reference, force=True)
            if ours:
                ray.shutdown()

    def _connect(self) -> None:
        quiet: dict[str, Any] = {"log_to_driver": False, "logging_level": "ERROR"}
        try:
            if self.address is None:
                self._ray.init(
                    address="local", num_cpus=self.workers or None, include_dashboard=False, **quiet
                )
            else:
                self._ray.init(address=self.address, **quiet)
        except (ConnectionError, RuntimeError, ValueError, TimeoutError) as error:
            where = "on this machine" if self.address is None else f"at {self.address}"
            raise GraspBenchError(
                f"Ray cannot be reached {where} ({str(error).splitlines()[0]}). Start it "
                "with `ray start --head`, and give --ray-address auto or "
                "HOST:PORT."
            ) from error

    def _window(self) -> int:
        """Return how many trials to have under way: one for each core of the cluster now, and one ready."""
        cores = max(1, int(self._ray.cluster_resources().get("CPU", 1)))
        return 2 * min(cores, self.workers or cores)

    def _result(self, reference: Any, job: Job) -> Answer | Fault:
        from ray.exceptions import RayError

        try:
            answer = self._ray.get(reference)
        except RayError as error:
            return Fault(
                job,
                Outcome.ERROR,
                f"no node finished the trial in {RETRIES + 1} tries ({type(error).__name__})",
            )
        if isinstance(answer, _Refusal):
            raise GraspBenchError(answer.why)
        return answer


def _import_ray() -> Any:
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
    try:
        import ray
    except ImportError as error:
        raise GraspBenchError(
            "--executor ray needs Ray, which is not installed here; install it with "
            "`pip install 'grasp-bench[ray]'`."
        ) from error
    return ray


def _task(settings: Settings, memory_limit: int | None) -> _Task:
    shipped = settings.objects == Catalog().folder.resolve()
    return _Task(uuid.uuid4().hex, settings, shipped, _stack(settings), memory_limit, str(Path.cwd()))


def _stack(settings: Settings) -> RunInfo:
    """Return what must be the same on every node."""
    catalog = Catalog(settings.objects)
    return describe(settings, spread(catalog.names, len(catalog.names)), catalog)


# ---------------------------------------------------------------- on a node

_pools: dict[str, WorkerPool] = {}


def _trial(task: _Task, job: Job) -> Answer | Fault | _Refusal:
    """Do one trial, in this node process's own worker."""
    try:
        if task.key not in _pools:
            _pools[task.key] = _open_pool(task)
        pool = _pools[task.key]
        pool.submit(job)
        while True:
            if answers := pool.wait():
                return answers[0]
    except GraspBenchError as error:
        return _Refusal(f"On node {platform.node()}: {error}")


def _open_pool(task: _Task) -> WorkerPool:
    with suppress(OSError):
        os.chdir(task.folder)
    settings = replace(task.settings, objects=Catalog().folder.resolve()) if task.shipped else task.settings
    places = ("where the run was started", "on this node")
    if found := task.stack.differences(_stack(settings), Group.INSTALLED, places=places):
        raise GraspBenchError(f"{listed(found)}. Install the same grasp-bench and the same stack there.")
    return WorkerPool(settings, 1, task.memory_limit or fair_share(usable_cores())).__enter__()
