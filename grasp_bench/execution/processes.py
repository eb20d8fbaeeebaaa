"""Trials in worker processes of this machine, each with a time and a memory limit, by Pebble.

A worker that dies, hangs or takes too much memory costs at most its own trial, and is replaced.
A trial whose worker died or took too long is tried once more on a new one: a stray kill or a machine that
was busy then costs nothing, and a trial that does so by itself does so again and is recorded.

Time limits go by the monotonic clock, which neither stands still nor jumps when somebody sets the time, and
which on Linux does not go on while a laptop sleeps.
"""

from __future__ import annotations

import time
from collections.abc import Generator, Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from itertools import chain, islice
from types import TracebackType
from typing import Any

from pebble import ProcessExpired

from grasp_bench.errors import GraspBenchError
from grasp_bench.execution import preload, worker
from grasp_bench.execution.crew import RECYCLE, Crew, take_crew
from grasp_bench.execution.memory import MemoryGuard, fair_share
from grasp_bench.execution.protocol import Answer, Fault, Round
from grasp_bench.runs.jobs import Job, Settings
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.system.apart import how_it_ended
from grasp_bench.system.texts import raised

TRIES = 2
"""Tries of a trial whose worker dies or takes too long."""
LOOK = 0.2
"""Seconds between two looks at how long trials take."""
STALL = 120.0
"""Seconds beyond a trial's own timeout after which a pool without any answer is started anew."""


class WorkerPool:
    """Worker processes of one run: every job submitted ends as an answer or a fault.

    Args:
        settings: settings of the run.
        workers: number of processes.
        memory_limit: most memory of each [bytes].
        recycle: tasks after which a worker is replaced; 0 never.
        predictors: names of those that workers load; by default the settings' only.
    """

    _begin = staticmethod(preload.begin)
    _do = staticmethod(worker.do)

    def __init__(
        self,
        settings: Settings,
        workers: int,
        memory_limit: int,
        recycle: int = RECYCLE,
        predictors: tuple[str, ...] = (),
    ) -> None:
        self._settings, self._workers, self._recycle = settings, workers, recycle
        self._predictors = predictors or (settings.predictor,)
        self._waiting: dict[Future[tuple[Answer, ...]], Job] = {}
        self._tries: dict[tuple[int, tuple[str, ...]], int] = {}
        self._begun: dict[Future[tuple[Answer, ...]], float] = {}
        self._late: set[Future[tuple[Answer, ...]]] = set()
        self._stalls = 0
        self._stack = ExitStack()
        self._guard = MemoryGuard(memory_limit)
        self._crew: Crew | None = None

    def __enter__(self) -> WorkerPool:
        self._stack.enter_context(self._guard)
        self._start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop()
        self._stack.close()

    @property
    def pending(self) -> int:
        """Number of jobs under way."""
        return len(self._waiting)

    @property
    def room(self) -> int:
        """Number of jobs that may be submitted: one under way and one ready for each worker."""
        return max(0, 2 * self._workers - self.pending)

    def submit(self, job: Job) -> None:
        """Begin a trial as soon as a worker is free."""
        assert self._crew is not None
        try:
            future: Any = self._crew.pool.schedule(self._do, (self._settings, job))
        except RuntimeError as error:  # the pool broke since it was last looked at
            future = Future()
            future.set_exception(BrokenProcessPool(str(error)))
        self._waiting[future] = job

    def wait(self) -> list[Answer | Fault]:
        """Block until some trials have ended; may be empty where one is tried again.

        Raises:
            GraspBenchError: when workers cannot start.
        """
        limit = self._settings.time_limit + STALL
        ended: set[Future[tuple[Answer, ...]]] = set()
        deadline = time.monotonic() + limit
        while not ended and time.monotonic() < deadline:
            self._stop_late()
            ended, _ = wait(self._waiting, timeout=LOOK, return_when=FIRST_COMPLETED)
        if not ended:
            return self._start_anew(f"no answer from any worker within {limit:g} s")
        answers: list[Answer | Fault] = []
        for future in sorted(ended, key=lambda f: self._waiting[f].trial):
            try:
                ended_as = self._result(future, self._waiting[future])
            except BrokenProcessPool:
                return answers + self._start_anew("all workers died")
            job = self._waiting.pop(future)
            self._begun.pop(future, None)
            self._late.discard(future)
            if ended_as is None:
                self.submit(job)
            else:
                self._stalls = 0
                self._tries.pop(_named(job), None)
                answers += ended_as
        return answers

    def _stop_late(self) -> None:
        """End the workers of trials that take longer than they may."""
        now = time.monotonic()
        for future in self._waiting:
            if not future.running():
                continue
            if now - self._begun.setdefault(future, now) > self._settings.time_limit:
                self._late.add(future)
                future.cancel()

    def _result(self, future: Future[tuple[Answer, ...]], job: Job) -> Sequence[Answer | Fault] | None:
        """Return how a trial ended; None when it is to be tried again."""
        try:
            return future.result()
        except BrokenProcessPool:
            raise
        except worker.NotStarted as error:
            raise GraspBenchError(f"A worker could not start: {error}") from error
        except (ProcessExpired, CancelledError) as error:
            reason = self._guard.reason(getattr(error, "pid", 0) or 0)
            tries = self._tries[_named(job)] = self._tries.get(_named(job), 0) + 1
            if tries < TRIES and reason is None:
                return None
            if future in self._late and reason is None:
                limit = self._settings.scenario.trial_timeout
                return [Fault(job, Outcome.TIMEOUT, f"no answer within {limit:g} s")]
            code = getattr(error, "exitcode", None)
            return [Fault(job, Outcome.ERROR, reason or f"the worker process died ({how_it_ended(code)})")]
        except Exception as error:  # an answer that cannot be sent, or anything beside the trial itself
            return [Fault(job, Outcome.ERROR, raised(error))]

    def _start_anew(self, why: str) -> list[Answer | Fault]:
        """Replace a pool that will give no more answers; its trials are begun again."""
        self._stalls += 1
        if self._stalls > TRIES:
            last = f" ({self._guard.last})" if self._guard.last else ""
            raise GraspBenchError(
                f"Workers do not work here: {why}, {self._stalls} times in a row{last}. "
                "See what they print, or try --workers 1."
            )
        jobs = sorted(self._waiting.values(), key=lambda j: j.trial)
        for known in (self._waiting, self._begun, self._late):
            known.clear()
        self._stop()
        self._start()
        for job in jobs:
            self.submit(job)
        return []

    def _start(self) -> None:
        self._crew = take_crew(self._predictors, self._workers, self._recycle, self._begin)

    def _stop(self) -> None:
        if self._crew is not None:
            self._crew.close()
            self._crew = None


def _named(job: Job) -> tuple[int, tuple[str, ...]]:
    """Return what tells a job from all others of a run."""
    return job.trial, job.predictors if isinstance(job, Round) else ()


class Processes:
    """Executor on worker processes of this machine.

    Args:
        workers: number of processes.
        memory_limit: most memory of each [bytes]; by default its share of 80 % of the machine's.
        recycle: trials after which a worker is replaced; 0 never.
    """

    _pool = WorkerPool

    def __init__(self, workers: int, memory_limit: int | None = None, recycle: int = RECYCLE) -> None:
        self.workers, self.memory_limit, self.recycle = workers, memory_limit, recycle

    def run(self, settings: Settings, jobs: Iterable[Job]) -> Generator[Answer | Fault, None, None]:
        """See :class:`~grasp_bench.execution.protocol.Executor`."""
        source = iter(jobs)
        first = list(islice(source, 2 * self.workers))
        workers = min(self.workers, len(first))  # no more than there is to do
        if not workers:
            return
        limit = self.memory_limit or fair_share(self.workers)
        with self._pool(settings, workers, limit, self.recycle) as pool:
            source = chain(first, source)
            while True:
                for job in islice(source, pool.room):
                    pool.submit(job)
                if not pool.pending:
                    return
                yield from pool.wait()
