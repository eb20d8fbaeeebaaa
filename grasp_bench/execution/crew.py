"""Worker processes that are begun before it is known what they will do.

They import and load while their parent still reads and checks what it was asked for; without them, the one
waits for the other. This module imports little, for the same reason.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

from pebble import ProcessPool

from grasp_bench.execution import preload
from grasp_bench.system.graphics import prepare
from grasp_bench.system.machine import THREADS, usable_cores
from grasp_bench.system.spawning import SpawnContext

RECYCLE = 1000
"""Tasks after which a worker is replaced by a new one, whatever a library may have leaked."""


class Crew:
    """Worker processes with the same predictors, in a Pebble pool that starts at once.

    Args:
        predictors: names of those that every worker loads.
        workers: number of processes.
        recycle: tasks after which a worker is replaced; 0 never.
        begin: what a new worker does first.
        early: load shipped predictors only.

    Attributes:
        pool: the running :class:`pebble.ProcessPool`.
    """

    def __init__(
        self,
        predictors: tuple[str, ...],
        workers: int,
        recycle: int = RECYCLE,
        begin: Any = preload.begin,
        early: bool = False,
    ) -> None:
        self.predictors, self.workers, self.recycle, self.begin = predictors, workers, recycle, begin
        self._before = {n: os.environ.get(n) for n in THREADS}
        _set_environment(dict.fromkeys(THREADS, "1"))  # before a worker imports NumPy
        self.pool = ProcessPool(
            max_workers=workers,
            max_tasks=recycle,
            initializer=begin,
            initargs=(predictors, early),
            context=SpawnContext(),
        )
        try:
            _ = self.pool.active  # starts the processes
        except BaseException:
            self.close()
            raise

    def serves(self, predictors: tuple[str, ...], workers: int, recycle: int, begin: Any) -> bool:
        """Return whether this is as good as a new crew of these arguments."""
        return (
            set(predictors) <= set(self.predictors)
            and (workers <= self.workers, recycle, begin) == (True, self.recycle, self.begin)
            and bool(self.pool.active)
        )

    def close(self) -> None:
        """End all workers, whatever they do."""
        self.pool.stop()
        self.pool.join()
        _set_environment(self._before)


_early: ContextVar[list[Crew] | None] = ContextVar("early", default=None)
"""The crew that waits for its run, if any; a list that it is taken out of."""


@contextmanager
def early_crew(
    predictors: tuple[str, ...], workers: int = 0, tasks: int | None = None, renderer: str = "auto"
) -> Iterator[None]:
    """Begin workers now that a run within this block takes over; within another such block do nothing.

    Only shipped predictors are served: the code of others runs when everything else has been checked.

    Args:
        predictors: names of those that will be asked.
        workers: number of processes; 0 for one a core.
        tasks: how many tasks there are at most, as far as it is known: no more workers are begun.
        renderer: one of :data:`grasp_bench.system.graphics.RENDERERS`.

    Raises:
        GraspBenchError: for a renderer that is not installed.
    """
    if _early.get() is not None or any(":" in p for p in predictors):
        yield
        return
    prepare(renderer)
    count = workers or usable_cores()
    waiting = [Crew(predictors, count if tasks is None else max(1, min(count, tasks)), early=True)]
    token = _early.set(waiting)
    try:
        yield
    finally:
        _early.reset(token)
        while waiting:
            waiting.pop().close()


def take_crew(predictors: tuple[str, ...], workers: int, recycle: int, begin: Any) -> Crew:
    """Return the crew that was begun early, if it serves; otherwise a new one. The caller closes it."""
    from grasp_bench.predictors.shipped import SHIPPED

    waiting = _early.get()
    if waiting:
        crew = waiting.pop()
        if crew.serves(predictors, workers, recycle, begin) and all(p in SHIPPED for p in predictors):
            return crew
        crew.close()
    return Crew(predictors, workers, recycle, begin)


def _set_environment(values: dict[str, str | None]) -> None:
    for name, value in values.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value
