"""Ctrl-C, and SIGTERM with which batch systems end a job: the user's, told from what foreign code raises."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


class Interrupted(KeyboardInterrupt):
    """The user, or the system, wants this process to end."""


def by_user(error: BaseException) -> bool:
    """Return whether an exception is the user's wish to end, and not one that foreign code made up."""
    if isinstance(error, Interrupted):
        return True
    return (
        isinstance(error, KeyboardInterrupt)
        and threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    )


@contextmanager
def told_apart(*numbers: signal.Signals) -> Iterator[None]:
    """Raise :class:`Interrupted` where one of some signals is received; SIGINT by default.

    A signal that is ignored, or that somebody else handles, stays so.
    """
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread may say what signals do
        return

    def interrupt(number: int, frame: FrameType | None) -> None:
        raise Interrupted

    usual = (signal.SIG_DFL, signal.default_int_handler)
    before = {n: signal.getsignal(n) for n in numbers or (signal.SIGINT,)}
    for number, handler in before.items():
        if handler in usual:
            signal.signal(number, interrupt)
    try:
        yield
    finally:
        for number, handler in before.items():
            if handler in usual:
                signal.signal(number, handler)
