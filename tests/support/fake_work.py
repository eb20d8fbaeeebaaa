"""What stands for a worker's start and trials in tests of the pool: quick, and as bad as asked for.

A job's object says what its trial does.
"""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

from grasp_bench.execution import worker
from grasp_bench.execution.processes import Processes, WorkerPool
from grasp_bench.execution.protocol import Answer
from grasp_bench.runs.jobs import Job, Settings
from grasp_bench.runs.record import Timings, TrialRecord
from grasp_bench.system.spawning import die_with_parent


def begin(predictors: tuple[str, ...], early: bool) -> None:
    die_with_parent()
    if "unstartable" in predictors:
        worker._broken["unstartable"] = "RuntimeError: no weights here"


def do(settings: Settings, job: Job) -> tuple[Answer, ...]:
    if worker._broken:
        raise worker.NotStarted(*worker._broken.values())
    what, _, argument = job.object.partition(":")
    if what == "segfault":
        ctypes.string_at(0)
    elif what == "exit":
        os._exit(7)
    elif what == "exit-0":
        os._exit(0)
    elif what == "abort":
        os.abort()
    elif what == "loop":
        while True:
            pass
    elif what == "stuck":  # ignores a polite end, as native code does
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        while True:
            time.sleep(1)
    elif what == "hoard":
        kept = []
        while True:
            kept.append(b"x" * (1 << 24))
            time.sleep(0.02)
    elif what == "child-hoards":
        code = "import time\nkept = [b'x' * (1 << 24) for _ in range(40)]\ntime.sleep(600)"
        subprocess.run([sys.executable, "-S", "-c", code], check=False)
    elif what == "killed-once":  # by somebody else, the first time
        mark = Path(argument)
        if not mark.exists():
            mark.write_text("")
            os.kill(os.getpid(), signal.SIGKILL)
    elif what == "late-once":  # on a machine that was busy, the first time
        mark = Path(argument)
        if not mark.exists():
            mark.write_text("")
            time.sleep(600)
    elif what == "wait":
        Path(argument).write_text(str(os.getpid()))
        time.sleep(600)
    time.sleep(float(os.environ.get("FAKE_WORK_SECONDS", "0")))
    answer = Answer(
        job,
        TrialRecord.read(
            {
                "trial": job.trial,
                "object": job.object,
                "category": "box",
                "outcome": "missed",
                "pid": os.getpid(),
                "threads": os.environ.get("OMP_NUM_THREADS"),
            }
        ),
        Timings(trial=job.trial),
    )
    return (answer,)


class FakePool(WorkerPool):
    _begin = staticmethod(begin)
    _do = staticmethod(do)


class FakeProcesses(Processes):
    _pool = FakePool


def until(holds: Callable[[], object], seconds: float = 300.0) -> None:
    """Wait until something holds, or fail."""
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.05)
