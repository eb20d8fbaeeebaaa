"""Trials in worker processes of this machine, each with a time and a memory limit, by Pebble.

A worker that dies, hangs or takes too much memory costs at most its own trial, and is replaced.
A trial whose worker died is tried once more on a new one: a stray kill then costs nothing, and a
trial that kills its worker by itself does so again and is recorded as an error.
"""

from __future__ import annotations

import os
from collections.abc import Generator, Iterable
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from itertools import chain, islice
from types import TracebackType
from typing import Any

from pebble import ProcessExpired, ProcessPool

from grasp_bench.errors import GraspBenchError
from grasp_bench.execution import worker
from grasp_bench.execution.memory import MemoryGuard, fair_share
from grasp_bench.execution.protocol import Answer, Fault
from grasp_bench.runs.jobs import Job, Settings
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.system.apart import how_it_ended
from grasp_bench.system.machine import THREADS
from grasp_bench.system.spawning import SpawnContext
from grasp_bench.system.texts import raised

TRIES = 2
"""Tries of a trial whose worker dies."""
STALL = 120.0
"""Seconds beyond a trial's own timeout after which a pool without any answer is started anew."""
RECYCLE = 1000
"""Trials after which a worker is replaced by a new one, whatever a library may have leaked."""


class WorkerPool:
    """Worker processes of one run: every job submitted ends as an answer or a fault.

    Args:
        settings: settings of the run.
        workers: number of processes.
        memory_limit: most memory of each [bytes].
        recycle: trials after which a worker is replaced; 0 never.
    """

    _begin = staticmethod(worker.start)
    _do = staticmethod(worker.do)

    def __init__(self, settings: Settings, workers: int, memory_limit: int, recycle: int = RECYCLE) -> None:
        self._settings, self._workers, self._recycle = settings, workers, recycle
        self._waiting: dict[Future[Answer], Job] = {}
        self._tries: dict[int, int] = {}
        self._stalls = 0
        self._stack = ExitStack()
        self._guard = MemoryGuard(memory_limit)
        self._pool: Any = None

    def __enter__(self) -> WorkerPool:
        self._stack.callback(_set_environment, {n: os.environ.get(n) for n in THREADS})
        _set_environment(dict.fromkeys(THREADS, "1"))  # before a worker imports NumPy
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
        try:
            future = self._pool.schedule(self._do, (job,), timeout=self._settings.time_limit)
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
        ended, _ = wait(self._waiting, timeout=limit, return_when=FIRST_COMPLETED)
        if not ended:
            return self._start_anew(f"no answer from any worker within {limit:g} s")
        answers = []
        for future in sorted(ended, key=lambda f: self._waiting[f].trial):
            try:
                answer = self._result(future, self._waiting[future])
            except BrokenProcessPool:
                return answers + self._start_anew("all workers died")
            job = self._waiting.pop(future)
            if answer is None:
                self.submit(job)
            else:
                self._stalls = 0
                self._tries.pop(job.trial, None)
                answers.append(answer)
        return answers

    def _result(self, future: Future[Answer], job: Job) -> Answer | Fault | None:
        """Return how a trial ended; None when it is to be tried again."""
        try:
            return future.result()
        except BrokenProcessPool:
            raise
        except TimeoutError:
            limit = self._settings.scenario.trial_timeout
            return Fault(job, Outcome.TIMEOUT, f"no answer within {limit:g} s")
        except worker.NotStarted as error:
            raise GraspBenchError(f"A worker could not start: {error}") from error
        except (ProcessExpired, CancelledError) as error:
            reason = self._guard.reason(getattr(error, "pid", 0) or 0)
            tries = self._tries[job.trial] = self._tries.get(job.trial, 0) + 1
            if tries < TRIES and reason is None:
                return None
            code = getattr(error, "exitcode", None)
            return Fault(job, Outcome.ERROR, reason or f"the worker process died ({how_it_ended(code)})")
        except Exception as error:  # an answer that cannot be sent, or anything beside the trial itself
            return Fault(job, Outcome.ERROR, raised(error))

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
        self._waiting.clear()
        self._stop()
        self._start()
        for job in jobs:
            self.submit(job)
        return []

    def _start(self) -> None:
        self._pool = ProcessPool(
            max_workers=self._workers,
            max_tasks=self._recycle,
            initializer=self._begin,
            initargs=(self._settings,),
            context=SpawnContext(),
        )

    def _stop(self) -> None:
        if self._pool is not None:
            self._pool.stop()
            self._pool.join()
            self._pool = None


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


def _set_environment(values: dict[str, str | None]) -> None:
    for name, value in values.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value
