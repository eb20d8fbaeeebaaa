"""Runs a command until the harness is gone: ``python guardian.py COMMAND …``.

A worker that is killed cannot stop the server that it started. This process stands between: the
worker holds the other end of its standard input, which ends with the worker however it dies; then
the command and all it started are stopped. Only the standard library, so that it starts at once.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import subprocess
import sys
import time

GRACE = 3.0
"""Seconds between asking a command to stop and killing it."""


def main(command: list[str]) -> int:
    """Run ``command``; its exit status, 128 + N where signal N ended it."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    child = subprocess.Popen(command, stdin=subprocess.DEVNULL, start_new_session=True)
    try:
        while child.poll() is None:
            ready, _, _ = select.select([0], [], [], 0.1)
            if ready and not os.read(0, 4096):
                break
    finally:
        stop(child)
    status = child.wait()
    return status if status >= 0 else 128 - status


def stop(child: subprocess.Popen[bytes]) -> None:
    """Stop the child and what it started, which is its process group."""
    for number in (signal.SIGTERM, signal.SIGKILL):
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(child.pid, number)
        deadline = time.monotonic() + GRACE
        while child.poll() is None and time.monotonic() < deadline:
            time.sleep(0.02)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
