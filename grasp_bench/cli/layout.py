"""How help and lists are laid out, so that they read well in a terminal of 80 columns."""

from __future__ import annotations

import inspect
from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Any

import typer
from typer.core import TyperCommand, TyperGroup

if TYPE_CHECKING:
    from rich.table import Table


class LaidOut(TyperCommand):
    """A command whose help flows to the terminal's width, and whose switches take one column, not two."""

    def __init__(self, *args: Any, help: str | None = None, **settings: Any) -> None:
        super().__init__(*args, help=flowing(help), **settings)

    def make_context(self, *args: Any, **settings: Any) -> Any:
        """Parse what was typed; an error is in the words of who found it, without those of pydantic."""
        try:
            return super().make_context(*args, **settings)
        except typer.BadParameter as error:
            error.message = error.message.removeprefix("Value error, ")
            raise

    def format_help(self, *args: Any) -> None:
        """Print the help with ``--on, --off`` in one column: Typer gives the second a column of its own."""
        switches = [(p, p.opts, p.secondary_opts) for p in self.params if p.secondary_opts]
        for param, on, off in switches:
            param.opts, param.secondary_opts = [*on, *(f" {name}" for name in off)], []  # may be broken there
        try:
            super().format_help(*args)
        finally:
            for param, on, off in switches:
                param.opts, param.secondary_opts = on, off


class LaidOutGroup(TyperGroup):
    """A group of commands whose help flows to the terminal's width."""

    def __init__(self, *args: Any, help: str | None = None, **settings: Any) -> None:
        super().__init__(*args, help=flowing(help), **settings)


def flowing(text: str | None) -> str | None:
    """Join the lines of each paragraph: Typer shows all but the first as they are broken in the source."""
    if text is None:
        return None
    return "\n\n".join(" ".join(p.split()) for p in inspect.cleandoc(text).split("\n\n"))


def lay_out(app: typer.Typer) -> None:
    """Let all commands of an app and of those below it be laid out so."""
    for command in app.registered_commands:
        command.cls = LaidOut
    for group in app.registered_groups:
        group.cls = LaidOutGroup
        if group.typer_instance is not None:
            lay_out(group.typer_instance)


def listing(head: Sequence[str], left: Collection[str], title: str = "") -> Table:
    """Return an empty table for things by their names, of which no letter is lost where space is short.

    Args:
        head: names of the columns; the first holds what is typed to choose one, and is never broken.
        left: those of words; the others hold numbers.
    """
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    table = Table(header_style="bold", box=box.SIMPLE, pad_edge=False, title=title or None)
    for i, name in enumerate(head):
        table.add_column(
            escape(name), justify="left" if name in left else "right", no_wrap=i == 0, overflow="fold"
        )
    return table
