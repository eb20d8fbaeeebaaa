"""The paper's Table 4, and the rows of our runs beside it."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grasp_bench.report.clutter import summarise_clutter
from grasp_bench.runs.folder import iter_timings, load_records, load_run
from grasp_bench.runs.statistics import wilson

NOTE = (
    "Rows marked “paper” are real-robot results as printed in Table 4 of the HTC-Grasp paper: other "
    "robots, other objects, other success rules. They are not directly comparable with the simulated "
    "rows, nor with each other: their 95 % Wilson intervals all overlap, so no order can be "
    "claimed from them."
)


@dataclass(frozen=True)
class PaperRow:
    """A row of the paper's Table 4."""

    authors: str
    system: str
    successes: int
    trials: int
    printed_rate: float


PAPER = (
    PaperRow("Lenz", "SAE", 89, 100, 89.0),
    PaperRow("Morrison", "GG-CNN", 110, 120, 92.0),  # 110/120 is 91.7 %; the paper prints 92.0 %
    PaperRow("Chu", "ResNet-50", 89, 100, 89.0),
    PaperRow("Wang", "TF-Grasp", 152, 165, 92.1),
    PaperRow("HTC-Grasp authors", "HTC-Grasp", 168, 180, 93.3),
)


def rate_of(successes: int, trials: int) -> dict[str, Any]:
    """A rate as all rows have it: ``successes``, ``trials``, ``rate`` and ``wilson95``."""
    low, high = wilson(successes, trials)
    return {"successes": successes, "trials": trials, "rate": successes / trials, "wilson95": [low, high]}


def summarise(folder: Path, root: Path | None = None) -> dict[str, Any] | None:
    """Figures of one run, named by its path below ``root``; None when it holds no trial yet."""
    run, trials = load_run(folder), load_records(folder)
    if not trials:
        return None
    timings = list(iter_timings(folder))
    phases = sorted({k for t in timings for k in t} - {"trial"})
    seconds = {p: round(sum(t.get(p, 0.0) for t in timings) / len(timings), 5) for p in phases}
    episodes = [t["clutter"] for t in trials if t.get("clutter") is not None]
    return {
        "clutter": summarise_clutter(episodes, len(trials)) if run["scenario"].get("clutter") else None,
        "run": folder.name if root in (None, folder) else folder.relative_to(root).as_posix(),
        "predictor": run["predictor"],
        "scenario": run["scenario"]["name"],
        "seed": run["seed"],
        "renderer": run["renderer"],
        "weights": run.get("weights"),
        "planned_trials": run["trials"],
        **rate_of(sum(t["success"] for t in trials), len(trials)),
        "outcomes": dict(sorted(Counter(t["outcome"] for t in trials).items(), key=lambda o: (-o[1], o[0]))),
        "by_category": _by(trials, "category"),
        "by_object": _by(trials, "object"),
        "timings": seconds,
    }


def _by(trials: list[dict[str, Any]], key: str) -> dict[str, dict[str, int]]:
    """Successes and trials of each group, sorted by name."""
    count = Counter(t[key] for t in trials)
    won = Counter(t[key] for t in trials if t["success"])
    return {name: {"successes": won[name], "trials": count[name]} for name in sorted(count)}


def build_report(folders: list[Path], root: Path | None = None) -> dict[str, Any]:
    """All runs below ``root`` with their figures, and Table 4 with a row for each."""
    runs = [s for s in (summarise(f, root) for f in folders) if s is not None]
    table: list[dict[str, Any]] = [
        {
            "authors": row.authors,
            "system": row.system,
            **rate_of(row.successes, row.trials),
            "printed_rate": row.printed_rate,
            "source": "paper",
            "run": None,
        }
        for row in PAPER
    ]
    table += [
        {
            "authors": "grasp-bench",
            "system": r["predictor"],
            **{k: r[k] for k in ("successes", "trials", "rate", "wilson95")},
            "printed_rate": None,
            "source": "simulation",
            "run": r["run"],
        }
        for r in runs
        if r["clutter"] is None
    ]
    return {"note": NOTE, "runs": runs, "table4": table}


def worst_objects(run: dict[str, Any], count: int = 10) -> list[tuple[str, int, int]]:
    """Objects that failed most: (name, successes, trials)."""
    failures = [
        (n, o["successes"], o["trials"]) for n, o in run["by_object"].items() if o["successes"] < o["trials"]
    ]
    return sorted(failures, key=lambda o: (o[1] / o[2], -o[2], o[0]))[:count]
