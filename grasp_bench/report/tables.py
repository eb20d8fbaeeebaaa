"""Tables of text, as Markdown or on a terminal."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from io import StringIO
from textwrap import fill
from typing import TYPE_CHECKING

from grasp_bench.runs.statistics import Rate

if TYPE_CHECKING:
    from rich.console import Console

RATE_HEAD = ("Grasped", "Rate", "95 % interval")
"""Heads of the columns of :func:`rate_cells`."""
_SUPERSCRIPT = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")


@dataclass(frozen=True)
class TextTable:
    """A table to print.

    Attributes:
        title, head, rows: parts of the table; all cells are text, or :class:`Markdown`. Without a head, there
            is a title and a lead only.
        lead, note: paragraphs before and after it.
        footnotes: what the marks ¹, ², … in it stand for.
        numbers: columns set flush right.
        paper: rows that are quoted and not measured.
        marked: rows that stand out.
        level: level of the title among a page's headings.
    """

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    lead: str = ""
    note: str = ""
    footnotes: Sequence[str] = ()
    numbers: Sequence[int] = ()
    paper: frozenset[int] = frozenset()
    marked: frozenset[int] = frozenset()
    level: int = 2


class Markdown(str):
    """A cell that is Markdown already."""


class Footnotes(list[str]):
    """Footnotes of a table, in the order in which its rows first ask for their marks."""

    def mark(self, text: str) -> str:
        """Return the mark of a footnote; equal ones share theirs."""
        if text not in self:
            self.append(text)
        return _mark(self.index(text) + 1)


def _mark(number: int) -> str:
    return str(number).translate(_SUPERSCRIPT)


def rate_cells(rate: Rate) -> list[str]:
    """Return k/n, rate and Wilson interval."""
    low, high = rate.interval
    return [f"{rate.successes}/{rate.trials}", f"{rate.rate:.1%}", f"{low:.1%} – {high:.1%}"]


def escaped(text: str) -> str:
    """Return text that Markdown shows as it is: results files may hold anything.

    It cannot break out of its cell, nor bring markup or HTML of its own.
    """
    if isinstance(text, Markdown):
        return text
    plain = " ".join(text.split()).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return re.sub(r"[\\`*\[\]{}|~]|(?<![^\W_])_|_(?![^\W_])", r"\\\g<0>", plain)


def markdown(tables: Iterable[TextTable]) -> str:
    """Return GitHub-flavoured Markdown of tables."""
    return "\n\n".join("\n\n".join(_blocks(t)) for t in tables) + "\n"


def _blocks(table: TextTable) -> Iterable[str]:
    def line(cells: Iterable[str]) -> str:
        return f"| {' | '.join(cells)} |"

    if table.title:
        yield f"{'#' * table.level} {escaped(table.title)}"
    if table.lead:
        yield escaped(table.lead)
    if not table.head:
        return
    rule = ["---:" if i in table.numbers else "---" for i in range(len(table.head))]
    yield "\n".join([line(table.head), line(rule), *(line(map(escaped, row)) for row in table.rows)])
    if table.note:
        yield escaped(table.note)
    if table.footnotes:
        yield "\n".join(f"{i}. {escaped(note)}" for i, note in enumerate(table.footnotes, 1))


def show(tables: Iterable[TextTable], console: Console) -> None:
    """Print tables to a rich console."""
    from rich import box
    from rich.padding import Padding
    from rich.table import Table
    from rich.text import Text

    for t in tables:
        fit = _fit(t, console.width)
        table = Table(header_style="bold cyan", box=box.SIMPLE, pad_edge=False, collapse_padding=fit.tight)
        for i, name in enumerate(t.head):
            number = i in t.numbers
            table.add_column(
                Text(_number_head(name) if number else fit.folded(i, name)),
                justify="right" if number else "left",
                no_wrap=number,
                overflow="fold",
            )
        for i, row in enumerate(t.rows):
            table.add_row(
                *(Text(fit.folded(k, cell)) for k, cell in enumerate(row)),
                style="dim" if i in t.paper else "bold" if i in t.marked else "",
                end_section=i in t.paper and i + 1 not in t.paper,
            )
        if t.title:
            console.print(Text(t.title, style="bold"))
        if not t.head:  # commands, which are indented, are for the terminal to wrap; a blank line after all
            for line in t.lead.splitlines():
                whole = line.startswith(" ")
                if not whole:
                    line = fill(line, console.width, subsequent_indent="  ", break_on_hyphens=False)
                console.print(Text(line), soft_wrap=whole)
            console.print()
            continue
        if t.lead:
            console.print(Text(t.lead))
        console.print(table)
        below = [t.note, *(f"{_mark(i)} {note}" for i, note in enumerate(t.footnotes, 1))]
        if words := "\n".join(filter(None, below)):
            console.print(Padding(Text(words, style="dim"), (0, 1, 1, 1)))


def _number_head(name: str) -> str:
    """Return the head of a column of numbers, which keep one line, so that it may need several."""
    return fill(name, 8, break_long_words=False)


@dataclass(frozen=True)
class _Fit:
    """How a table gets into a terminal.

    Attributes:
        widths: of the columns of words that are folded, by their number.
        tight: whether the columns move closer together.
        hyphens: whether words are broken at hyphens.
    """

    widths: dict[int, int]
    tight: bool = False
    hyphens: bool = False

    def folded(self, column: int, text: str) -> str:
        """Return text in lines that fit its column."""
        if column not in self.widths:
            return text
        return fill(text, self.widths[column], break_long_words=False, break_on_hyphens=self.hyphens)


def _fit(table: TextTable, room: int) -> _Fit:
    """Share a terminal's ``room`` columns among a table's columns of words: the widest give first.

    None gets less than its longest word. Where that does not do, the table's columns move closer together,
    then words break at hyphens; where nothing does, Rich breaks words anywhere.
    """
    cells = [[name, *(row[i] for row in table.rows)] for i, name in enumerate(table.head)]
    # A table may say which columns hold numbers and have fewer columns today.
    numbers = [own for i, own in enumerate(cells) if i in table.numbers]
    taken = sum(_widest([_number_head(own[0]), *own[1:]]) for own in numbers)
    words = {i: own for i, own in enumerate(cells) if i not in table.numbers}
    widths = {i: _widest(own) for i, own in words.items()}
    for hyphens, tight in ((False, False), (False, True), (True, False), (True, True)):
        gap = 2 if tight else 3  # what Rich puts between two columns; one more at either end
        left = room - taken - gap * (len(cells) - 1) - 2
        if sum(widths.values()) <= left:
            return _Fit({}, tight)
        one = {"width": 1, "break_long_words": False, "break_on_hyphens": hyphens}
        least = {i: _widest(fill(cell, **one) for cell in own) for i, own in words.items()}
        if sum(least.values()) > left:
            continue
        while sum(widths.values()) > left:
            widths[max((i for i in words if widths[i] > least[i]), key=lambda i: widths[i])] -= 1
        return _Fit(widths, tight, hyphens)
    return _Fit({})


def _widest(texts: Iterable[str]) -> int:
    return max((len(line) for text in texts for line in text.splitlines()), default=0)


def as_text(tables: Iterable[TextTable], width: int = 120) -> str:
    """Return tables as a terminal of ``width`` columns would show them, without colour."""
    from rich.console import Console

    buffer = StringIO()
    show(tables, Console(file=buffer, width=width, no_color=True))
    return buffer.getvalue()
