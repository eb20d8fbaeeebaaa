"""What the page says: figures of all runs, for the templates and for the page's script."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from grasp_bench.objects.catalog import Catalog
from grasp_bench.report import breakdown, help
from grasp_bench.report.clutter import attempts_in_words, in_words
from grasp_bench.report.compare import SharedTrials, Versus
from grasp_bench.report.firmness import AT, FirmnessPair
from grasp_bench.report.groups import DEVELOPED_ON, grouped, is_control, made_last, newest, reference
from grasp_bench.report.html import figures
from grasp_bench.report.html.trials import rows_of
from grasp_bench.report.table4 import NOTE, PAPER, Report
from grasp_bench.runs.results import RunResults

DEFINITIONS = (
    (
        f"development seed {DEVELOPED_ON}",
        "planner and shipped weights were developed on its trials: quote the rates of fresh seeds.",
    ),
    ("95 % interval", "Wilson score interval of k/n: rates as far apart as its ends fit the trials as well."),
    (
        "control",
        "a bound or a heuristic, no contestant: it shows what a scenario gives away, and that one can fail.",
    ),
)
"""Terms of the page and what they mean, in the order of the page."""


def content(runs: list[RunResults], root: Path | None, catalog: Catalog) -> dict[str, Any]:
    """Return all that the page shows of ``runs``, each of which holds a trial, but its pictures."""
    report = Report.of(runs, root)
    names = [r.run for r in report.runs]
    groups = grouped(report.runs, made_last(runs, names))
    shared = SharedTrials(runs)
    facts = [breakdown.object_facts(run, catalog) for run in runs]
    rows = [row for i, run in enumerate(runs) for row in rows_of(i, run, facts[i], shared.numbers(i))]
    labels = _short(names)
    kinds = breakdown.breakdowns(runs, facts)
    quality = [r.trust.calibration for r in report.runs]
    firm = [r.firmness for r in report.runs]
    firmer = [_firmer(i, report.pairs) for i in range(len(runs))]
    times = [breakdown.latency(run) for run in runs]
    first = reference(runs, groups)
    versus = [[_told(v) for v in shared.against(i)] for i in range(len(runs))]
    controls = [is_control(run.predictor) for run in runs]
    hard = [r.managed for r in report.runs]
    return {
        "in_words": in_words,
        "attempts_in_words": attempts_in_words,
        "note": NOTE,
        "definitions": DEFINITIONS,
        "paper": PAPER,
        "groups": groups,
        "titled": next((i for i, g in enumerate(groups) if g.of_the_paper), None),
        "runs": report.runs,
        "controls": controls,
        "names": names,
        "labels": labels,
        "reference": first,
        "versus": versus,
        "kinds": kinds,
        "categories": breakdown.by_category(runs),
        "merits": report.merits,
        "merit_note": help.NOTE,
        "held_at": AT,
        "graded": any(firm),
        "firmer": firmer,
        "times": times,
        "charts": {
            "outcomes": figures.outcomes(report.runs, labels),
            **{f"by-{k.key}": figures.success_by(k, labels) for k in kinds},
            **({"firmness": figures.firmness(firm, labels)} if any(firm) else {}),
            **({"difficulty": figures.over_difficulty(hard, labels)} if any(hard) else {}),
            "calibration": figures.calibration(quality, labels),
            "coverage": figures.risk_coverage(quality, labels),
            "seconds": figures.seconds(times, labels),
        },
        "data": {
            "runs": [
                {
                    "name": name,
                    "label": label,
                    "predictor": run.predictor,
                    "control": control,
                    "path": name if run.folder.is_absolute() else run.folder.as_posix(),
                }
                for name, label, run, control in zip(names, labels, runs, controls, strict=True)
            ],
            "shown": newest(runs, names, groups),
            "reference": first,
            "versus": versus,
            "firmer": firmer,
            "outcomes": figures.OUTCOMES,
            "trials": rows,
        },
        "count": len(rows),
    }


def _short(names: list[str]) -> list[str]:
    """Return the last part of each name, or all of it where another run has the same last part."""
    last = [name.rpartition("/")[2] for name in names]
    return [part if last.count(part) == 1 else name for part, name in zip(last, names, strict=True)]


def _told(versus: Versus) -> list[Any]:
    """Return a comparison as a row: the run, counts (trials, both, first, second, neither), p, adjusted p."""
    pairs = versus.pairs
    counts = [pairs.trials, pairs.both, pairs.first_only, pairs.second_only, pairs.neither]
    adjusted = None if versus.adjusted is None else p_value(versus.adjusted)
    return [versus.run, *counts, p_value(pairs.p_value), adjusted]


def _firmer(reference: int, pairs: Sequence[FirmnessPair]) -> list[list[Any]]:
    """Return a row for each run compared with the reference by how firmly it holds.

    The run, trials, objects, how many times the reference's force it bears, interval, p, adjusted p.
    """
    rows = []
    for pair in pairs:
        if reference in (pair.first, pair.second):
            run, ratio = pair.first, pair.ratio
            value, low, high = ratio.value, ratio.low, ratio.high
            if run == reference:
                run, (value, low, high) = pair.second, (1 / value, 1 / high, 1 / low)
            interval = f"{low:.2f} – {high:.2f}"
            told = [f"{value:.2f}×", interval, p_value(pair.p_value), p_value(pair.adjusted)]
            rows.append([run, pair.trials, pair.objects, *told])
    return rows


def p_value(value: float) -> str:
    """Return a p-value as it is shown."""
    return "< 0.0001" if value < 1e-4 else f"{value:.2g}"
