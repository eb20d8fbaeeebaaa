"""Work on foreign code in a process of its own, which cannot end or hold the command; data come back."""

from __future__ import annotations

import json
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any

from grasp_bench.errors import AssetError, GraspBenchError, PredictorError, ResultsError, ScenarioError
from grasp_bench.system.spawning import DIED_WITH_0, SpawnContext, die_with_parent, leave, print_to_stderr
from grasp_bench.system.texts import raised, said

MOST_BYTES = 2**22
"""Largest piece of data that is taken from such a process."""
GRACE = 5.0
"""Seconds that it may take to tidy up after its last answer."""

Tell = Callable[[Any], None]
_ERRORS = {k.__name__: k for k in (GraspBenchError, PredictorError, AssetError, ScenarioError, ResultsError)}


class DiedError(GraspBenchError):
    """The process ended before its work was done; the message says how."""


class TooLateError(GraspBenchError):
    """The process gave no answer in time; the message says in which."""


def answers(work: Callable[..., None], *args: Any, seconds: float) -> Iterator[Any]:
    """Call ``work(tell, *args)`` in a process of its own, and yield what it tells.

    Args:
        work: a function of a module; its first argument takes JSON-able data.
        args: its other arguments.
        seconds: how long each answer may take, and the end after the last one.

    Raises:
        GraspBenchError: of the type and message that the work raised; PredictorError for what is none.
        DiedError, TooLateError: for a process that ends or hangs.
    """
    context = SpawnContext()
    hear, tell = context.Pipe(duplex=False)
    process = context.Process(target=_inside, args=(work, args, tell), name="apart")
    process.start()
    tell.close()
    patience = GRACE
    try:
        while True:
            kind, content = _next(process, hear, seconds)
            if kind == "end":
                return
            if kind == "error":
                raise _ERRORS[content[0]](content[1])
            yield content
    except (DiedError, TooLateError):
        patience = 0.0
        raise
    finally:
        process.join(patience)
        with suppress(OSError, ValueError):
            process.kill()
        process.join()
        hear.close()


def how_it_ended(code: int | None) -> str:
    """Say how a process ended, by its exit code."""
    if code is not None and code < 0:
        with suppress(ValueError):
            return f"killed by {signal.Signals(-code).name}"
    return f"exit code {'?' if code is None else code % DIED_WITH_0}"


def _next(process: BaseProcess, hear: Connection, seconds: float) -> tuple[str, Any]:
    deadline = time.monotonic() + seconds
    while True:
        ended = process.exitcode  # looked at first: what it said before it ended is heard
        try:
            if hear.poll(0.05):
                kind, content = json.loads(hear.recv_bytes(MOST_BYTES))
                return kind, content
        except (EOFError, OSError, ValueError):
            process.join(1.0)
            raise DiedError(how_it_ended(process.exitcode)) from None
        if ended is not None:
            raise DiedError(how_it_ended(ended))
        if time.monotonic() > deadline:
            raise TooLateError(f"no answer within {seconds:g} s")


def _inside(work: Callable[..., None], args: tuple[Any, ...], pipe: Connection) -> None:
    """Do the work, in the child."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent ends it
    die_with_parent()
    print_to_stderr()

    def tell(kind: str, content: Any) -> None:
        data = json.dumps([kind, content], allow_nan=False).encode()
        if len(data) > MOST_BYTES:
            raise PredictorError(f"it says more of itself than {MOST_BYTES} bytes")
        pipe.send_bytes(data)

    try:
        work(lambda content: tell("answer", content), *args)
        tell("end", None)
    except GraspBenchError as error:
        kind = next(k.__name__ for k in type(error).__mro__ if _ERRORS.get(k.__name__) is k)
        tell("error", [kind, said(error)])
    except BaseException as error:
        tell("error", [PredictorError.__name__, raised(error)])
    finally:
        leave()
