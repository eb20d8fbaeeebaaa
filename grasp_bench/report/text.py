"""The report as a terminal table and as markdown."""

from __future__ import annotations

from typing import Any

from rich.console import Console, Group
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from grasp_bench.report.clutter import attempts_in_words, in_words
from grasp_bench.report.table4 import worst_objects

HEAD = ("Authors", "System", "Grasped", "Rate", "95 % interval", "Printed", "Source")


def rate_cells(row: dict[str, Any]) -> tuple[str, str, str]:
    """``k/n``, rate and Wilson interval, for any row with those keys."""
    low, high = row["wilson95"]
    return f"{row['successes']}/{row['trials']}", f"{row['rate']:.1%}", f"{low:.1%} – {high:.1%}"


def _cells(row: dict[str, Any]) -> list[str]:
    printed = "" if row["printed_rate"] is None else f"{row['printed_rate']:.1f} %"
    source = "paper, real robot" if row["source"] == "paper" else row["run"]
    return [row["authors"], row["system"], *rate_cells(row), printed, source]


def _breakdown(run: dict[str, Any]) -> list[list[str]]:
    return [
        [outcome, str(count), f"{count / run['trials']:.1%}"] for outcome, count in run["outcomes"].items()
    ]


def _title(run: dict[str, Any]) -> str:
    missing = run["planned_trials"] - run["trials"]
    partial = f", {missing} to go" if missing else ""
    return (
        f"{run['run']}: {run['predictor']} on {run['scenario']}, seed {run['seed']}, "
        f"{run['renderer']}{partial}"
    )


def _clutter(run: dict[str, Any]) -> str:
    figures = run["clutter"]
    return (
        f"Clutter, {figures['episodes']} tables: {in_words(figures)}. "
        f"Lifted, by the number of the attempt: {attempts_in_words(figures)}. Outcomes of whole tables:"
    )


def _worst(run: dict[str, Any]) -> str:
    return ", ".join(f"{n} {k}/{t}" for n, k, t in worst_objects(run)) or "none failed"


def as_terminal(report: dict[str, Any]) -> Group:
    """Rich renderable of the report."""
    table = Table(title="Table 4, re-measured", title_style="bold", header_style="bold")
    for i, name in enumerate(HEAD):
        table.add_column(name, justify="right" if 2 <= i <= 5 else "left", overflow="fold")
    for i, row in enumerate(report["table4"]):
        style = "dim" if row["source"] == "paper" else ""
        last = i + 1 < len(report["table4"]) and report["table4"][i + 1]["source"] != row["source"]
        table.add_row(*_cells(row), style=style, end_section=last)
    parts: list[Any] = [table, Padding(Text(report["note"], style="dim"), (0, 1, 1, 1))]
    for run in report["runs"]:
        outcomes = Table(
            title=_title(run),
            title_justify="left",
            title_style="bold",
            box=None,
            show_header=False,
            padding=(0, 2),
        )
        for line in _breakdown(run):
            outcomes.add_row(*line, style="" if line[0] == "success" else "yellow")
        if run["clutter"] is not None:
            parts.append(Padding(Text(_clutter(run)), (0, 1, 0, 2)))
        parts += [outcomes, Padding(Text(f"Hardest objects: {_worst(run)}"), (0, 1, 1, 2))]
    return Group(*parts)


def as_markdown(report: dict[str, Any]) -> str:
    """The report as GitHub-flavoured markdown."""
    rule = _row("---:" if 2 <= i <= 5 else "---" for i in range(len(HEAD)))
    lines = ["## Table 4, re-measured", "", _row(HEAD), rule]
    lines += [_row(_cells(row)) for row in report["table4"]]
    lines += ["", report["note"], ""]
    for run in report["runs"]:
        lines += [f"### {_title(run)}", ""]
        if run["clutter"] is not None:
            lines += [_clutter(run), ""]
        lines += [_row(("Outcome", "Trials", "Share")), _row(("---", "---:", "---:"))]
        lines += [_row(line) for line in _breakdown(run)]
        lines += ["", f"Hardest objects: {_worst(run)}", ""]
    return "\n".join(lines)


def _row(cells: Any) -> str:
    return "| " + " | ".join(str(c).replace("|", "\\|") for c in cells) + " |"


def show(report: dict[str, Any], console: Console) -> None:
    """Print the report to a terminal."""
    console.print(as_terminal(report))
