"""Writes the measured tables into README.md, docs/results.md and docs/leaderboard.md.

``python scripts/make_tables.py``
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Sequence
from pathlib import Path

from grasp_bench.report.agreement import agreement, agreement_table
from grasp_bench.report.agreement_chart import as_svg
from grasp_bench.report.firmness import firmness_table, pairs_table
from grasp_bench.report.help import TITLE as MERIT
from grasp_bench.report.help import Merit, merit_table
from grasp_bench.report.leaderboard import as_markdown, load_row
from grasp_bench.report.table4 import build_report
from grasp_bench.report.tables import Markdown, TextTable, markdown, rate_cells
from grasp_bench.runs.comparison import Comparison
from grasp_bench.runs.evaluation import Evaluation
from grasp_bench.runs.folder import find_runs
from grasp_bench.runs.results import RunResults
from grasp_bench.studies.bench_table import compare, read_evaluations, run_folders, tables

ROOT = Path(__file__).resolve().parents[1]


def replace(path: Path, marker: str, text: str) -> None:
    """Put ``text`` between ``<!-- marker -->`` and ``<!-- /marker -->``."""
    content = path.read_text(encoding="utf-8")
    pattern = re.compile(rf"(<!-- {marker} -->\n).*?(<!-- /{marker} -->)", re.DOTALL)
    if not pattern.search(content):
        raise SystemExit(f"{path} has no marker {marker!r}")
    path.write_text(pattern.sub(lambda m: m[1] + text.strip() + "\n" + m[2], content), encoding="utf-8")


def main() -> None:
    reference = ROOT / "results" / "reference"
    table, *runs = build_report(find_runs(reference), reference).tables()
    alone = ROOT / "results" / "as-predicted"
    merits = build_report([*find_runs(reference), *find_runs(alone)]).merits
    replace(ROOT / "README.md", "table4", markdown([with_predicted(table, merits)]))
    replace(ROOT / "docs" / "results.md", "merit", markdown([merit_table(merits)]))
    replace(ROOT / "docs" / "results.md", "graded", markdown(graded(ROOT / "results" / "graded")))
    compared, evaluations = compare(run_folders(reference)), read_evaluations(ROOT / "results" / "evaluation")
    replace(ROOT / "docs" / "results.md", "agreement", agreements([reference, alone], evaluations))
    replace(ROOT / "docs" / "results.md", "measured", markdown(tables(compared, evaluations)))
    replace(ROOT / "docs" / "results.md", "runs", markdown(endings(runs)))
    replace(ROOT / "docs" / "leaderboard.md", "leaderboard", leaderboard())
    replace(ROOT / "docs" / "scenarios.md", "suites", suites())
    for page in ("README.md", "docs/index.md", "docs/leaderboard.md", "docs/results.md"):
        replace(ROOT / page, "headline", headline())


def headline() -> str:
    """The figures to quote: shipped networks with fresh seeds, pooled, with help and without."""
    told: dict[str, list[str]] = {}
    seeds: list[int] = []
    for folder, how in (("seeds", "with the planner's help"), ("seeds-as-predicted", "exactly as predicted")):
        (group,) = build_report(find_runs(ROOT / "results" / folder)).groups
        seeds = list(group.seeds)
        for predictor in sorted(group.pooled):
            counts, rate, interval = rate_cells(group.pooled[predictor])
            told.setdefault(predictor, []).append(f"**{counts} = {rate}** {how} (95 % interval {interval})")
    figures = "; ".join(f"**`{predictor}` lifts** {' and '.join(both)}" for predictor, both in told.items())
    return f"{figures}; seeds {seeds[0]} to {seeds[-1]}, each of the 180 objects once a seed."


def with_predicted(table: TextTable, merits: Sequence[Merit]) -> TextTable:
    """Put what each predictor lifts without help beside its row, and leave out the title."""
    alone = {m.predictor: m.predicted for m in merits if m.predicted is not None}
    at = table.head.index("Printed")
    rows = []
    for row in table.rows:
        rate = alone.get(row[1].removesuffix(" (control)")) if row[0] == "grasp-bench" else None
        cell = f"{rate.successes}/{rate.trials} = {rate.rate:.1%}" if rate else ""
        rows.append([*row[:at], cell, *row[at:]])
    head = [*table.head[:at], "As predicted", *table.head[at:]]
    numbers = (*(n + (n >= at) for n in table.numbers), at)
    return dataclasses.replace(table, title="", head=head, rows=rows, numbers=numbers)


def endings(tables: Sequence[TextTable]) -> list[TextTable]:
    """What the reference runs say of their qualities, then their ends; merit takes both protocols."""
    pages = [t for t in tables if t.title != MERIT]
    summaries, runs = ([t for t in pages if (t.level > 2) == deep] for deep in (False, True))
    return [*summaries, TextTable("How each run ended", (), ()), *runs]


def graded(folder: Path) -> list[TextTable]:
    """How firmly all predictors hold, each as it predicted, and which pairs that tells apart."""
    report = build_report(find_runs(folder), folder)
    told = [(r.run, r.firmness) for r in report.runs if r.firmness is not None]
    return [firmness_table(told), pairs_table([r.run for r in report.runs], report.pairs)]


def agreements(folders: Sequence[Path], evaluations: Sequence[Evaluation]) -> str:
    """Physics against real images, in each protocol; the last one's picture."""
    strict = [e for e in evaluations if (e.dataset, e.protocol) == ("cornell", "strict") and not e.trained]
    found = [agreement([RunResults(run) for run in find_runs(f)], strict) for f in folders]
    svg = ROOT / "docs" / "images" / "agreement.svg"
    svg.write_text(as_svg(found[-1]), encoding="utf-8")
    return (
        markdown(map(agreement_table, found))
        + f"\n![{found[-1].scenario} against Cornell](images/{svg.name})\n"
    )


def suites() -> str:
    """What the shipped network reaches in each scenario, paired with its trials of table4."""
    usual = RunResults(ROOT / "results" / "reference" / "htc-grasp")
    rows = [[Markdown("`table4`"), *rate_cells(usual.lifted), "", ""]]
    for run in map(RunResults, find_runs(ROOT / "results" / "suites")):
        same = [(r.object, r.seed) for r in run.records] == [(r.object, r.seed) for r in usual.records]
        pairs = Comparison.of(usual, run) if same else None
        told = (
            [f"{pairs.first_only} / {pairs.second_only}", f"{pairs.p_value:.2g}"]
            if pairs
            else ["its own objects", ""]
        )
        rows.append([Markdown(f"`{run.info.scenario_name}`"), *rate_cells(run.lifted), *told])
    head = ("Scenario", "Lifted", "Rate", "95 % interval", "− / +", "p")
    return markdown([TextTable("", head, rows, numbers=(1, 2, 3, 4, 5))])


def leaderboard() -> str:
    """Rows of the reference runs and of those that were handed in."""
    submitted = ROOT / "results" / "leaderboard"
    folders = find_runs(ROOT / "results" / "reference") + (find_runs(submitted) if submitted.is_dir() else [])
    return as_markdown([load_row(folder) for folder in folders])


if __name__ == "__main__":
    main()
