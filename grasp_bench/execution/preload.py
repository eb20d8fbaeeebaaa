"""The first thing that a worker does: import what every trial needs, and load predictors.

This module is light, so that a parent can name :func:`begin` to new workers before it has imported anything
that takes long itself.
"""

from __future__ import annotations

import ctypes
import gc
import os
import threading
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path

from grasp_bench.system.machine import THREADS
from grasp_bench.system.spawning import die_with_parent, print_to_stderr


def begin(predictors: tuple[str, ...], early: bool = False) -> None:
    """Make this process a worker that has these predictors; the first trial tells what is wrong.

    ``early`` loads shipped ones only, as nobody has checked yet what was asked for.
    """
    for name in THREADS:
        os.environ[name] = "1"
    gc.disable()  # what modules make is no garbage, and looking for some takes a tenth of the start
    linking = threading.Thread(target=_link_torch, daemon=True)
    linking.start()
    die_with_parent()
    print_to_stderr()
    from grasp_bench.execution import worker

    worker.import_all()
    linking.join()  # before the predictors, which need what it links
    worker.load(predictors, early)


def _link_torch() -> None:
    """Load the largest library of PyTorch beside the imports: linking does not need Python's lock.

    Where it fails, the import of PyTorch does the same, and tells what is wrong.
    """
    if (found := find_spec("torch")) and found.origin:
        with suppress(OSError):
            ctypes.CDLL(str(Path(found.origin).parent / "lib" / "libtorch_cpu.so"))
