"""Writes the measured tables into README.md, docs/results.md and docs/leaderboard.md.

``python scripts/make_tables.py``
"""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

from grasp_bench.report.leaderboard import as_markdown, load_row
from grasp_bench.report.table4 import build_report
from grasp_bench.report.tables import Markdown, TextTable, markdown, rate_cells
from grasp_bench.runs.comparison import Comparison
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
    replace(ROOT / "README.md", "table4", markdown([dataclasses.replace(table, title="")]))
    compared, evaluations = compare(run_folders(reference)), read_evaluations(ROOT / "results" / "evaluation")
    replace(ROOT / "docs" / "results.md", "measured", markdown(tables(compared, evaluations)))
    replace(ROOT / "docs" / "results.md", "runs", markdown(runs))
    replace(ROOT / "docs" / "leaderboard.md", "leaderboard", leaderboard())
    replace(ROOT / "docs" / "scenarios.md", "suites", suites())
    for page in ("README.md", "docs/index.md", "docs/leaderboard.md", "docs/results.md"):
        replace(ROOT / page, "headline", headline())


def headline() -> str:
    """The figure to quote: the shipped network with fresh seeds, pooled."""
    report = build_report(find_runs(ROOT / "results" / "seeds"))
    (group,) = report.groups
    assert group.pooled is not None
    counts, rate, interval = rate_cells(group.pooled)
    predictor = report.runs[0].info.predictor
    return (
        f"**`{predictor}` lifts {counts} = {rate}** (95 % interval {interval}; seeds {group.seeds[0]} to "
        f"{group.seeds[-1]}, each of the 180 objects once a seed)."
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
