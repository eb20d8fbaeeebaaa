"""Evaluations beside the paper's rows, for the terminal and as markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from grasp_bench.report.paper import TABLE_3, TABLES
from grasp_bench.runs.evaluation import Evaluation
from grasp_bench.runs.statistics import wilson

HEAD = ("Method", "Input", "Split", "Accuracy", "Correct", "95 % interval", "ms", "On")
NUMBERS = (3, 4, 5, 6)
TITLES = {
    "cornell": "Table 1, re-measured: Cornell",
    "jacquard": "Table 2, re-measured: Jacquard",
    "synthetic": "Held-out synthetic scenes",
}
NOTE = (
    "Paper rows are as printed: the full data set, counts unknown, times on each author's hardware. "
    "Rows of grasp-bench are measured on the images present here, with the 95 % Wilson interval of k/n, "
    "and the processor time from image to grasps on one core of this machine."
)


@dataclass(frozen=True)
class TextTable:
    """A table to print.

    Attributes:
        title, head, rows, note: its parts; all cells are text.
        numbers: columns set flush right.
        paper: rows that are quoted and not measured.
    """

    title: str
    head: Sequence[str]
    rows: list[list[str]]
    note: str = ""
    numbers: Sequence[int] = ()
    paper: frozenset[int] = frozenset()


def markdown(tables: Iterable[TextTable]) -> str:
    """GitHub-flavoured markdown of tables."""

    def line(cells: Iterable[str]) -> str:
        return "| " + " | ".join(c.replace("|", "\\|") for c in cells) + " |"

    parts = []
    for t in tables:
        rule = ["---:" if i in t.numbers else "---" for i in range(len(t.head))]
        parts.append(
            "\n".join(
                [
                    f"## {t.title}",
                    "",
                    line(t.head),
                    line(rule),
                    *map(line, t.rows),
                    *(["", t.note] if t.note else []),
                ]
            )
        )
    return "\n\n".join(parts) + "\n"


def show(tables: Iterable[TextTable], console: Any) -> None:
    """Print tables to a rich console."""
    from textwrap import fill

    from rich import box
    from rich.padding import Padding
    from rich.table import Table
    from rich.text import Text

    for t in tables:
        table = Table(
            title=t.title,
            title_style="bold",
            title_justify="left",
            header_style="bold",
            box=box.SIMPLE,
            pad_edge=False,
        )
        for i, name in enumerate(t.head):  # numbers keep one line, so their heads may need several
            number = i in t.numbers
            table.add_column(
                fill(name, 8) if number else name,
                justify="right" if number else "left",
                no_wrap=number,
                overflow="fold",
            )
        for i, row in enumerate(t.rows):
            table.add_row(
                *map(Text, row),
                style="dim" if i in t.paper else "",
                end_section=i in t.paper and i + 1 not in t.paper,
            )
        console.print(table)
        if t.note:
            console.print(Padding(Text(t.note, style="dim"), (0, 1, 1, 1)))


def as_text(tables: Iterable[TextTable], width: int = 120) -> str:
    """Tables as a terminal of ``width`` columns would show them, without colour."""
    from io import StringIO

    from rich.console import Console

    buffer = StringIO()
    show(tables, Console(file=buffer, width=width, no_color=True))
    return buffer.getvalue()


# ---------------------------------------------------------------- Tables 1 and 2


def rate_cells(correct: int, total: int) -> list[str]:
    """Rate, k/n and Wilson interval."""
    low, high = wilson(correct, total)
    return [f"{correct / total:.1%}", f"{correct}/{total}", f"{low:.1%} – {high:.1%}"]


def accuracy_table(dataset: str, results: Sequence[Evaluation]) -> TextTable:
    """Table 1 or 2 of the paper with our rows below; synthetic scenes have only ours."""
    rows = []
    for row in TABLES.get(dataset, ()):
        time = "" if row.milliseconds is None else f"{row.milliseconds:g}"
        for split, rate in (("image", row.image_wise), ("object", row.object_wise)):
            if rate is not None:
                rows.append(
                    [
                        f"{row.method} ({row.authors})",
                        row.input,
                        split if dataset == "cornell" else "",
                        f"{rate:g}%",
                        "",
                        "",
                        time,
                        "paper",
                    ]
                )
    paper = frozenset(range(len(rows)))
    rows += [_ours(r) for r in results]
    how = "; ".join(dict.fromkeys(f"{r.predictor}: {conditions(r)}" for r in results))
    return TextTable(TITLES[dataset], HEAD, rows, f"{NOTE} {how}." if how else NOTE, NUMBERS, paper)


def _ours(result: Evaluation) -> list[str]:
    weights, trained = result.weights, result.trained
    kind = str(weights.input).split(" ")[0] if weights else ""
    how = (
        ", trained per fold"
        if trained
        else ""
        if weights is None or not weights.model_fields_set
        else ", weights that saw real images"
        if weights.saw_real_images
        else ", zero-shot"
    )
    return [
        result.predictor + how,
        {"rgbd": "RGB-D", "rgb": "RGB", "depth": "D"}.get(kind, ""),
        result.split if trained else "",
        *rate_cells(result.correct, result.images),
        f"{result.latency_ms.cpu_median:.0f}",
        f"{result.images} of {result.images_in_full} {result.protocol}",
    ]


def conditions(result: Evaluation) -> str:
    """How a result came about: folds, training, protocol."""
    parts = [result.how]
    if trained := result.trained:
        parts.append(
            f"trained for each fold from {trained.begun_with or 'random weights'} by "
            f"{trained.steps} steps of {trained.batch} on the other folds"
            + (
                f" and {', '.join(trained.synthetic)} (real share {trained.real_share:g})"
                if trained.synthetic
                else ""
            )
        )
    elif result.weights and (data := result.weights.data):
        steps = result.weights.steps
        parts.append(
            f"weights trained on {', '.join(data.folders)} only, {'?' if steps is None else steps} steps"
        )
    parts.append(f"protocol {result.protocol} ({', '.join(result.conventions)})")
    return ", ".join(parts)


def summary(result: Evaluation) -> list[str]:
    """What to say before the table: the data, folds and verdicts."""
    verdicts = ", ".join(f"{k.replace('_', ' ')} {v}" for k, v in result.verdicts.items() if v)
    lines = [result.found, f"Labels dropped because of NaN or no area: {result.dropped_rectangles}."]
    if len(result.folds) > 1 or result.trained:
        lines.append(f"{result.how}: {', '.join(f'{f.correct}/{f.images}' for f in result.folds)}.")
    lines.append(f"Protocol {result.protocol}:")
    lines += [f"  {name}: {meaning}" for name, meaning in result.conventions.items()]
    latency, machine = result.latency_ms, result.machine
    lines += [
        f"Best grasps: {verdicts}.",
        f"Latency, image to grasps, one thread of {machine.processor}, float32: "
        f"{latency.cpu_median} ms of processor time; on the clock median {latency.median}, "
        f"95th percentile {latency.p95} ms at a load of {machine.load:.1f}.",
    ]
    return lines


# ---------------------------------------------------------------- Table 3


def ablation_table(results: Sequence[Evaluation]) -> TextTable:
    """Table 3 of the paper with what was measured of the same networks beside it."""
    rows = []
    for row in TABLE_3:
        for dataset, printed in (("cornell", row.cornell), ("jacquard", row.jacquard)):
            found = [
                r for name in row.predictors for r in results if r.predictor == name and r.dataset == dataset
            ]
            for r in found or [None]:
                measured = rate_cells(r.correct, r.images) if r else ["not measured", "", ""]
                rows.append(
                    [
                        dataset.capitalize(),
                        "✓" if row.external_attention else "",
                        "✓" if row.channel_attention else "",
                        f"{printed:g}%",
                        *measured,
                        conditions(r) if r else "",
                    ]
                )
    rows.sort(key=lambda r: r[0])
    return TextTable(
        "Table 3, re-measured: ablations",
        (
            "Data set",
            "External attention",
            "Channel attention",
            "Paper",
            "Here",
            "Correct",
            "95 % interval",
            "How",
        ),
        rows,
        "Without external attention, blocks have multi-head self-attention (the paper's equation 3). " + NOTE,
        (3, 4, 5, 6),
    )
