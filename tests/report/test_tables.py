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
