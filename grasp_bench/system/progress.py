"""Progress bars, that of a run with its success rate so far."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from rich.console import Console


def counting(console: Console) -> Any:
    """Return a Rich progress bar for ``with``, whose tasks have a description and a field ``state``."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    description, state = TextColumn("{task.description}"), TextColumn("{task.fields[state]}")
    columns = (description, BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), state)
    return Progress(*columns, console=console)


class Tried(Protocol):
    """What is counted of a trial's record."""

    @property
    def success(self) -> bool:
        """Whether the trial succeeded."""
        ...


class Progress:
    """Rich progress bar to be used with ``with``; quiet where the console is.

    Args:
        total: number of trials.
        console: where to draw; standard error by default, which leaves standard output to results.
    """

    def __init__(self, total: int, console: Console | None = None) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
        from rich.progress import Progress as Bar

        shown = console or Console(stderr=True)
        self._bar = Bar(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[rate]}"),
            TimeRemainingColumn(),
            console=shown,
            disable=shown.quiet,
        )
        self._task = self._bar.add_task("Grasping", total=total, rate="")
        self._done = self._won = 0

    def __enter__(self) -> Progress:
        self._bar.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is not None and self._done == 0:
            self._bar.live.transient = True  # refused before the first trial: leave no empty bar behind
        self._bar.stop()

    def update(self, record: Tried, resumed: bool = False) -> None:
        """Count one trial by its record."""
        self._done += 1
        self._won += record.success
        rate = f"{self._won}/{self._done} = {self._won / self._done:.0%}"
        self._bar.update(self._task, advance=1, rate=rate)
