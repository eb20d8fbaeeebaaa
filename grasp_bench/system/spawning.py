"""Worker processes that do not run the caller's script a second time.

Python's spawned processes import the parent's main module, so that a script which starts a run
outside of ``if __name__ == "__main__":`` would start it again in every worker. Workers need
nothing of it: a predictor that they use is named by its own module.
"""

from __future__ import annotations

import multiprocessing.context
import sys
from multiprocessing.process import BaseProcess
from types import ModuleType
from typing import Any


class _Process(multiprocessing.context.SpawnProcess):
    @staticmethod
    def _Popen(process_obj: BaseProcess) -> Any:  # noqa: N802  (the library's name)
        main = sys.modules["__main__"]
        sys.modules["__main__"] = ModuleType("__main__")  # no file and no spec: nothing to import
        try:
            return multiprocessing.context.SpawnProcess._Popen(process_obj)
        finally:
            sys.modules["__main__"] = main


class SpawnContext(multiprocessing.context.SpawnContext):
    """Like :func:`multiprocessing.get_context` of ``spawn``, without importing the main module."""

    Process = _Process
