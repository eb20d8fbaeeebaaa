"""A guard that ends worker processes which take too much memory, before the system ends something else."""

from __future__ import annotations

import threading
from contextlib import suppress
from types import TracebackType

import psutil

PERIOD = 0.5
"""Seconds between two looks."""


def fair_share(workers: int) -> int:
    """Return the memory [bytes] a worker may take by default: its share of 80 % of the machine's."""
    return int(0.8 * psutil.virtual_memory().total / workers)


class MemoryGuard:
    """Watch over the children of this process, each with its own descendants.

    Args:
        limit: resident memory of a child and its descendants [bytes].

    Attributes:
        last: why the last process was ended, in words; None if none was.
    """

    def __init__(self, limit: int) -> None:
        self.limit = limit
        self.last: str | None = None
        self._ended: dict[int, str] = {}
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True, name="memory-guard")

    def __enter__(self) -> MemoryGuard:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop.set()
        self._thread.join()

    def reason(self, pid: int) -> str | None:
        """Return why this guard ended a process, in words; None when it did not."""
        return self._ended.pop(pid, None)

    def _watch(self) -> None:
        me = psutil.Process()
        while not self._stop.wait(PERIOD):
            for child, family in _families(me).items():
                used = sum(map(_resident, family))
                if used > self.limit:
                    self.last = (
                        f"the worker took {used / 2**30:.1f} GiB of memory, more than the "
                        f"{self.limit / 2**30:.1f} GiB allowed"
                    )
                    self._ended[child] = self.last
                    for process in family:
                        _kill(process)


def _families(parent: psutil.Process) -> dict[int, list[psutil.Process]]:
    """Return a process's children, each with its descendants, by the child's id, in one look at all."""
    families: dict[int, list[psutil.Process]] = {}
    child_of: dict[int, int] = {}
    for process in parent.children(recursive=True):  # parents come before their children
        try:
            above = process.ppid()
        except psutil.Error:
            continue
        child_of[process.pid] = process.pid if above == parent.pid else child_of.get(above, process.pid)
        families.setdefault(child_of[process.pid], []).append(process)
    return families


def _resident(process: psutil.Process) -> int:
    try:
        return process.memory_info().rss
    except psutil.Error:
        return 0


def _kill(process: psutil.Process) -> None:
    with suppress(psutil.Error):
        process.kill()
