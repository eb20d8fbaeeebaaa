"""What a process that trains asks of the C library and of OpenMP. To be called before torch is imported."""

from __future__ import annotations

import ctypes
import os
import sys

_TRIM_THRESHOLD, _TOP_PAD, _MMAP_MAX = -1, -2, -4
"""glibc's numbers of ``mallopt``'s parameters."""


def prepare_process() -> None:
    """Keep freed memory, and let threads that wait for others sleep soon.

    glibc gives large buffers back to the system at every step and faults them in again. OpenMP's threads spin
    for milliseconds where another process, or a thread that prepares batches, pushed out the one they wait
    for: on a busy machine of two cores three quarters of the processor time of two threads went there.
    Results do not change, and a variable that is set already stays.
    """
    os.environ.setdefault("GOMP_SPINCOUNT", "3000")  # about 5 µs: read when torch loads OpenMP
    if sys.platform == "linux" and hasattr(libc := ctypes.CDLL(None), "mallopt"):
        libc.mallopt(_MMAP_MAX, 0)
        libc.mallopt(_TRIM_THRESHOLD, -1)  # never
        libc.mallopt(_TOP_PAD, 2**28)
