"""Progress bars, that of a run with its success rate so far; a plain line in notebooks."""

from __future__ import annotations

import sys
import time
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from rich.console import Console

EVERY = 0.5
"""Seconds from one state of the plain line to the next."""


def counting(console: Console) -> Any:
    """Return a Rich progress bar for ``with``, whose tasks have a description and a field ``state``."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    description = TextColumn("{task.description}", markup=False)
    state = TextColumn("{task.fields[state]}", markup=False)
    columns = (description, BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), state)
    return Progress(*columns, console=console)


class Tried(Protocol):
    """What is counted of a trial's record."""

    @property
    def success(self) -> bool:
        """Whether the trial succeeded."""
        ...


class _Drawn(Protocol):
    """What shows the state of a run."""

    def start(self) -> None: ...

    def update(self, done: int, rate: str, resumed: bool) -> None: ...

    def stop(self, begun: bool) -> None: ...


class _Bar:
    """Rich progress bar on a console, quiet where that is."""

    def __init__(self, total: int, console: Console) -> None:
        from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
        from rich.progress import Progress as Bar

        self._bar = Bar(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[rate]}"),
            TimeRemainingColumn(),
            console=console,
            disable=console.quiet,
        )
        self._task = self._bar.add_task("Grasping", total=total, rate="")

    def start(self) -> None:
        self._bar.start()

    def update(self, done: int, rate: str, resumed: bool) -> None:
        self._bar.update(self._task, completed=done, rate=rate)

    def stop(self, begun: bool) -> None:
        if not begun:
            self._bar.live.transient = True  # leave no empty bar behind
        self._bar.stop()


class _Line:
    """One line of text that is written over: all that a notebook's output needs, and no widgets."""

    def __init__(self, total: int) -> None:
        self._total, self._text, self._shown, self._before = total, "", 0, 0
        self._begun = self._last = 0.0

    def start(self) -> None:
        self._begun = time.monotonic()

    def update(self, done: int, rate: str, resumed: bool) -> None:
        now, end = time.monotonic(), ""
        self._before += resumed
        took, made = now - self._begun, done - self._before
        if done == self._total:
            end = f", {_duration(took)}"
        elif made:
            end = f", about {_duration(took / made * (self._total - done))} to go"
        self._text = f"Grasping {done}/{self._total}, lifted {rate}{end}"
        if done in (1, self._total) or now - self._last >= EVERY:
            self._write()
            self._last = now

    def stop(self, begun: bool) -> None:
        if self._text:
            self._write()
            sys.stdout.write("\n")

    def _write(self) -> None:
        sys.stdout.write(f"\r{self._text:<{self._shown}}")  # blanks over what was longer
        sys.stdout.flush()
        self._shown = len(self._text)


def _duration(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min"


class Progress:
    """Progress of a run to be used with ``with``: a bar on a terminal, a line of text in a notebook.

    Args:
        total: number of trials.
        console: where to draw; standard error by default, which leaves standard output to results.
    """

    def __init__(self, total: int, console: Console | None = None) -> None:
        from rich.console import Console

        shown = console or Console(stderr=True)
        self._drawn: _Drawn = _Line(total) if shown.is_jupyter and not shown.quiet else _Bar(total, shown)
        self._done = self._won = 0

    def __enter__(self) -> Progress:
        self._drawn.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self._drawn.stop(kind is None or self._done > 0)  # not where it was refused before the first trial

    def update(self, record: Tried, resumed: bool = False) -> None:
        """Count one trial by its record."""
        self._done += 1
        self._won += record.success
        self._drawn.update(self._done, f"{self._won}/{self._done} = {self._won / self._done:.0%}", resumed)
