"""The findings of a self-check: a few lines, each with a state and what it means."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console


class State(StrEnum):
    """Verdict of a check."""

    OK = "ok"
    NOTE = "note"
    """Worth knowing; results may differ from those of others, but nothing is broken."""
    BAD = "bad"


@dataclass(frozen=True)
class Check:
    """One finding: what was looked at, its state, and what that means where it is not ok."""

    name: str
    state: State
    detail: str

    def to_json(self) -> dict[str, Any]:
        """Return plain data."""
        return asdict(self)


def healthy(checks: list[Check]) -> bool:
    """Return whether nothing is bad."""
    return all(c.state is not State.BAD for c in checks)


def show(title: str, checks: list[Check], console: Console) -> None:
    """Print checks as a table."""
    from rich.table import Table
    from rich.text import Text

    styles = {State.OK: "green", State.NOTE: "yellow", State.BAD: "bold red"}
    table = Table(
        title=title, title_justify="left", title_style="bold", show_header=False, box=None, padding=(0, 2)
    )
    for check in checks:
        table.add_row(Text(str(check.state), style=styles[check.state]), Text(check.name), Text(check.detail))
    console.print(table)
