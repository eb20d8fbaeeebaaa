"""Foreign code behind a guard: whatever it raises is its own fault, and is kept for the log of errors."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from types import TracebackType

import numpy as np

from grasp_bench.errors import PredictorError
from grasp_bench.system import interrupts
from grasp_bench.system.texts import place, raised, said

_caught: ContextVar[list[BaseException] | None] = ContextVar("caught", default=None)


class Guard:
    """Around a call of foreign code: all it raises becomes a PredictorError; only the user's Ctrl-C passes.

    What the code does to NumPy's handling of floating-point errors and to Python's recursion limit ends here.

    Args:
        what: begin of the message, before the exception's type and text.
    """

    def __init__(self, what: str = "the predictor raised") -> None:
        self._what = what

    def __enter__(self) -> Guard:
        self._depth, self._floats = sys.getrecursionlimit(), np.geterr()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if sys.getrecursionlimit() != self._depth:
            sys.setrecursionlimit(self._depth)
        if np.geterr() != self._floats:
            np.seterr(**self._floats)
        if error is None or interrupts.by_user(error):
            return
        found = _caught.get()
        if found is not None and error.__cause__ not in found:  # an inner guard's is there already
            found.append(error)
        if not isinstance(error, PredictorError):
            where = place(error)
            told = f"{self._what} {raised(error)}" + (f" ({where})" if where else "")
            raise PredictorError(told) from error
        if not _is_ours(error):
            raise PredictorError(said(error)) from error


def _is_ours(error: PredictorError) -> bool:
    """Return whether an error is of a class of this package, and its message as it should be."""
    if type(error).__module__.partition(".")[0] != "grasp_bench":
        return False
    return len(error.args) == 1 and type(error.args[0]) is str and error.args[0] == said(error)


@contextmanager
def catching() -> Iterator[list[BaseException]]:
    """Gather the exceptions that guards turn into PredictorErrors meanwhile."""
    found: list[BaseException] = []
    token = _caught.set(found)
    try:
        yield found
    finally:
        _caught.reset(token)
