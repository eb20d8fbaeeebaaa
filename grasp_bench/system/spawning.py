"""Worker processes that run neither the caller's script a second time nor the files of the current folder.

Python's spawned processes import the parent's main module, so that a script which starts a run
outside of ``if __name__ == "__main__":`` would start it again in every worker. Workers need
nothing of it: a predictor that they use is named by its own module. And until they know the parent's
path they look for Python's own modules in the current folder first, where a ``socket.py`` may lie.
"""

from __future__ import annotations

import ctypes
import multiprocessing
import multiprocessing.context
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Pipe
from multiprocessing.process import BaseProcess
from multiprocessing.resource_tracker import ensure_running
from types import ModuleType
from typing import Any, NoReturn

SAFE_PATH = "PYTHONSAFEPATH"
DIED_WITH_0 = 256
"""Exit code told of a process that ended with status 0 before its work was done: no real one is so large."""


class _Process(multiprocessing.context.SpawnProcess):
    """A process whose exit code is 0 only where it came to the end of its work.

    Foreign code may end its process with status 0, as if a worker had nothing more to do.
    """

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._done, self._tell_done = Pipe(duplex=False)
        self._own_safe_path = os.environ.get(SAFE_PATH)

    def run(self) -> None:
        """Do the work, in the child."""
        if self._own_safe_path is None:  # what foreign code starts from here finds its modules as ever
            os.environ.pop(SAFE_PATH, None)
        super().run()
        self._tell_done.send_bytes(b"done")
        others = [t for t in threading.enumerate() if t is not threading.current_thread()]
        if multiprocessing.active_children() or not all(t.daemon for t in others):
            leave()  # Python would wait for what foreign code left running

    @property
    def exitcode(self) -> int | None:
        """Status with which it ended: negative for a signal, :data:`DIED_WITH_0`; None while it runs."""
        code = super().exitcode
        if code != 0:
            return code
        with suppress(OSError, EOFError):
            if self._done.poll():
                return 0
        return DIED_WITH_0

    @staticmethod
    def _Popen(process_obj: BaseProcess) -> Any:  # noqa: N802  (the library's name)
        main = sys.modules["__main__"]
        sys.modules["__main__"] = ModuleType("__main__")  # no file and no spec: nothing to import
        try:
            with _safe_path():
                return multiprocessing.context.SpawnProcess._Popen(process_obj)
        finally:
            sys.modules["__main__"] = main


class SpawnContext(multiprocessing.context.SpawnContext):
    """Like :func:`multiprocessing.get_context` of ``spawn``, without main module and current folder."""

    Process = _Process

    def __init__(self) -> None:
        super().__init__()
        with _safe_path():
            ensure_running()  # a process, too, started with the first lock otherwise


@contextmanager
def _safe_path() -> Iterator[None]:
    """Keep Python processes that start meanwhile from looking for modules in the current folder first."""
    before = os.environ.get(SAFE_PATH)
    os.environ[SAFE_PATH] = "1"
    try:
        yield
    finally:
        if before is None:
            os.environ.pop(SAFE_PATH, None)
        else:
            os.environ[SAFE_PATH] = before


def die_with_parent() -> None:
    """End this process when its parent ends, even where its work never returns from native code."""
    parent = multiprocessing.parent_process()
    if parent is None:
        return
    if sys.platform == "linux":
        with suppress(OSError, AttributeError):
            ctypes.CDLL(None).prctl(1, signal.SIGKILL)  # PR_SET_PDEATHSIG
        if os.getppid() != parent.pid:
            os._exit(1)

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True, name="watch-parent").start()


def leave() -> NoReturn:
    """End this process at once, whatever foreign code left running in it."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(Exception):  # it may be closed
            stream.flush()
    os._exit(0)


def print_to_stderr() -> None:
    """Send what this process and its children print to standard error: standard output is for results."""
    with suppress(Exception):
        sys.stdout.flush()
    with suppress(OSError):
        os.dup2(2, 1)
