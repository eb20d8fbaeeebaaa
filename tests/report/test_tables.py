"""The one table writer: Markdown that nothing in a cell can break, and text on a terminal."""

from __future__ import annotations

import pytest

from grasp_bench.report.tables import Footnotes, Markdown, TextTable, as_text, escaped, markdown, rate_cells
from grasp_bench.runs.statistics import Rate


def test_a_table_is_its_title_lead_rows_note_and_footnotes() -> None:
    table = TextTable(
        "Title", ("Name", "Rate"), [["a", "1"]], lead="Before.", note="After.", footnotes=["first", "second"],
        numbers=(1,), level=3,
    )  # fmt: skip
    assert markdown([table]) == (
        "### Title\n\nBefore.\n\n| Name | Rate |\n| --- | ---: |\n| a | 1 |\n\n"
        "After.\n\n1. first\n2. second\n"
    )
    lines = [line.strip() for line in as_text([table]).splitlines() if line.strip()]
    assert (lines[:2], lines[-3:]) == (["Title", "Before."], ["After.", "¹ first", "² second"])


def test_several_tables_are_apart() -> None:
    table = TextTable("", ("a",), [["b"]])
    assert markdown([table, table]) == "| a |\n| --- |\n| b |\n\n| a |\n| --- |\n| b |\n"


def test_the_same_footnote_has_the_same_mark() -> None:
    notes = Footnotes()
    assert [notes.mark(text) for text in "abaacdefghijk"] == list("¹²¹¹³⁴⁵⁶⁷⁸⁹") + ["¹⁰", "¹¹"]
    assert notes == list("abcdefghijk")


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("a|b", "a\\|b"),
        ("<b>&", "&lt;b&gt;&amp;"),
        ("[x](javascript:1)", "\\[x\\](javascript:1)"),
        ("two\nlines\t here", "two lines here"),
        ("coffee_mug", "coffee_mug"),
        ("_a_ __b__ *c* `d` ~~e~~", "\\_a\\_ \\_\\_b\\_\\_ \\*c\\* \\`d\\` \\~\\~e\\~\\~"),
        ("back\\|slash", "back\\\\\\|slash"),
        ("{: onclick=x}", "\\{: onclick=x\\}"),
        (Markdown("[a](<b>)"), "[a](<b>)"),
    ],
)
def test_text_is_shown_as_it_is(text: str, shown: str) -> None:
    assert escaped(text) == shown


def test_a_rate_is_counts_rate_and_interval() -> None:
    assert rate_cells(Rate(168, 180)) == ["168/180", "93.3%", "88.7% – 96.1%"]


def rows_as_shown(table: TextTable, width: int) -> list[str]:
    lines = as_text([table], width).splitlines()
    assert max(map(len, lines)) <= width
    return lines


METHODS = TextTable(
    "",
    ("Method", "Correct", "95 % interval", "On"),
    [
        ["gr-convnet-16, zero-shot", "25/40", "47.0% – 75.8%", "40 of 885 strict\u00a0¹"],
        ["HTC-Grasp (HTC-Grasp authors)", "", "", "paper"],
    ],
    numbers=(1, 2),
)


@pytest.mark.parametrize(
    ("width", "first"),
    [
        (120, "gr-convnet-16, zero-shot"),
        (80, "gr-convnet-16, zero-shot"),
        (60, "gr-convnet-16,"),
        (48, "gr-"),
    ],
)
def test_words_are_whole_where_a_table_is_folded(width: int, first: str) -> None:
    """What gives is the room between words, then that between columns, then hyphens."""
    lines = rows_as_shown(METHODS, width)
    column = [line[1:].split("  ")[0].strip() for line in lines]
    assert first in column
    words = set(" ".join(column).replace("- ", "-").split())
    assert {"gr-convnet-16,", "zero-shot", "HTC-Grasp", "(HTC-Grasp", "authors)"} <= words
    assert not any(line.strip().startswith("¹") for line in lines)
    assert any("47.0% – 75.8%" in line for line in lines)


def test_a_terminal_too_narrow_for_words_still_shows_every_letter() -> None:
    table = TextTable("", ("Method",), [["abcdefghijklmnopqrstuvwxyz"]])
    assert "".join(rows_as_shown(table, 12)[2:]).replace(" ", "").endswith("abcdefghijklmnopqrstuvwxyz")
