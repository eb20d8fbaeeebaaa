"""All networks and controls on the same trials: Table 4, re-measured, with paired comparisons."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from grasp_bench.errors import AssetError, GraspBenchError
from grasp_bench.networks import build, parameter_count
from grasp_bench.networks.weights import read_metadata, stored_input
from grasp_bench.predictors import BUILT_IN
from grasp_bench.report.accuracy import TextTable, ablation_table, accuracy_table, rate_cells
from grasp_bench.report.table4 import PAPER
from grasp_bench.runs.evaluation import Evaluation
from grasp_bench.runs.run import Run
from grasp_bench.runs.statistics import holm, trials_to_distinguish, wilson
from grasp_bench.system.integrity import sha256

REFERENCE = "htc-grasp"
UNABLATED = "htc-grasp-1000"
"""HTC-Grasp trained as long as its ablations."""
ABLATIONS = {
    UNABLATED: (True, True),
    "htc-grasp-no-ea": (False, True),
    "htc-grasp-no-ca": (True, False),
    "htc-grasp-plain": (False, False),
}
"""External and channel attention: the paper's Table 3, and one without either."""
FORMAT = 1

NOTE = (
    "Paper rows are real-robot results as printed, on other robots and other objects; they are not "
    "directly comparable. All rows of grasp-bench are of the same trials. Alone: trials in which only "
    "the reference, and only this system, succeeded; p: McNemar's exact two-sided test against the "
    "reference, Holm-corrected over all rows; trials to tell: after how many such trials the two would "
    "be told apart at 5 % with 80 % power if the observed shares were true (Connor, Biometrics 43, "
    "1987)."
)


def bench(
    folder: Path,
    predictors: Sequence[str] | None = None,
    trials: int | None = None,
    scenario: str = "table4",
    seed: int = 0,
    workers: int | None = None,
    on_run: Callable[[str], Any] = lambda name: True,
) -> list[str]:
    """Tries predictors on the same trials, each into its own folder; finished ones are kept.

    Args:
        folder: holds a run for each predictor, named after it.
        predictors: names; by default all shipped ones whose weights are there.
        trials: of each; by default one for each object.
        scenario, seed, workers: as of ``grasp-bench run``.
        on_run: called with each predictor's name, returns what :func:`grasp_bench.run` takes as
            ``progress``.

    Returns:
        names of shipped networks left out because their weights are missing.
    """
    from grasp_bench import api

    names = list(predictors) if predictors else [n for n, e in BUILT_IN.items() if e.available]
    for name in names:
        api.run(
            trials=trials,
            predictor=name,
            scenario=scenario,
            seed=seed,
            workers=workers,
            out=folder / name.replace(":", "-").replace("/", "-"),
            progress=on_run(name),
        )
    return [n for n, e in BUILT_IN.items() if not e.available and n not in names]


def compare(folders: Sequence[Path], reference: str = REFERENCE) -> dict[str, Any]:
    """Rows of the runs, each compared with the reference's trial by trial.

    Raises:
        ResultsError: when a run is damaged or empty, or did other trials than the reference.
    """
    runs = [Run(f) for f in folders]
    against = next((r for r in runs if r.predictor == reference), None)
    rows: list[dict[str, Any]] = []
    for run in sorted(runs, key=lambda r: (_kind(r.predictor) == "control", -r.successes, r.predictor)):
        row: dict[str, Any] = {
            "predictor": run.predictor,
            "kind": _kind(run.predictor),
            "run": run.folder.name,
            "successes": run.successes,
            "trials": len(run),
            "rate": run.rate,
            "wilson95": list(run.interval),
            "planned_trials": run.info["trials"],
            "weights": trained_on(run.predictor, run.info["weights"]),
        }
        if against is not None and run is not against:
            pairs = against.compare(run)
            shares = pairs.first_only / pairs.trials, pairs.second_only / pairs.trials
            row |= {
                "reference_only": pairs.first_only,
                "this_only": pairs.second_only,
                "p_value": pairs.p_value,
                "trials_to_tell": trials_to_distinguish(*shares),
            }
        rows.append(row)
    _correct(rows)
    first = (against or runs[0]).info if runs else {}
    return {
        "format": FORMAT,
        "kind": "bench-table",
        "reference": reference if against else None,
        "scenario": first.get("scenario", {}).get("name"),
        "seed": first.get("seed"),
        "rows": rows,
        "ablations": _ablations(runs),
    }


def _ablations(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """The runs of HTC-Grasp and its ablations, these compared with :data:`UNABLATED` trial by trial."""
    by_name = {r.predictor: r for r in runs}
    whole, rows = by_name.get(UNABLATED), []
    for name, (external, channel) in ABLATIONS.items():
        row: dict[str, Any] = {
            "predictor": name,
            "external_attention": external,
            "channel_attention": channel,
        }
        if (run := by_name.get(name)) is not None:
            row |= {"successes": run.successes, "trials": len(run)}
            if whole is not None and run is not whole:
                pairs = whole.compare(run)
                row |= {
                    "whole_only": pairs.first_only,
                    "this_only": pairs.second_only,
                    "p_value": pairs.p_value,
                }
        rows.append(row)
    _correct(rows)
    return rows


def _correct(rows: list[dict[str, Any]]) -> None:
    """Adds Holm's ``p_holm`` to all rows that have a ``p_value``."""
    compared = [r for r in rows if "p_value" in r]
    for row, corrected in zip(compared, holm([r["p_value"] for r in compared]), strict=True):
        row["p_holm"] = corrected


def _kind(predictor: str) -> str:
    return BUILT_IN[predictor].kind if predictor in BUILT_IN else "own"


def trained_on(predictor: str, used: dict[str, str | None] | None) -> dict[str, Any] | None:
    """Training of a shipped network by its weights' metadata.

    Args:
        predictor: name.
        used: SHA-256 by file of the weights that a run used. Where those installed are others, there
            is nothing to tell: None.
    """
    path = BUILT_IN[predictor].file if predictor in BUILT_IN else None
    if path is None:
        return None
    try:
        if not used or used.get(path.name) != sha256(path):
            return None
        facts = read_metadata(path)
    except (AssetError, OSError):
        return None
    data = facts.get("data", {})
    network = build(facts["network"], stored_input(facts))
    return {
        "parameters": parameter_count(network),
        "input": facts.get("input"),
        "steps": facts.get("steps"),
        "batch": facts.get("config", {}).get("batch"),
        "seed": facts.get("seed"),
        "minutes": round(facts["seconds"] / 60) if facts.get("seconds") else None,
        "scenes": data.get("train"),
        "folders": data.get("folders"),
        "fingerprint": data.get("fingerprint"),
        "begun_with": facts.get("begun_with"),
    }


def read_evaluations(folder: Path) -> list[Evaluation]:
    """Results that ``grasp-bench evaluate --out`` left in a folder, by name; none if there is no folder.

    Raises:
        ResultsError: naming a file that is not one.
    """
    return [Evaluation.read(path) for path in sorted(folder.glob("*.json"))]


# ---------------------------------------------------------------- tables


def tables(comparison: dict[str, Any], evaluations: Sequence[Evaluation]) -> list[TextTable]:
    """Table 4, what was trained on what, and Tables 1 to 3, all re-measured."""
    found = [
        accuracy_table(name, chosen)
        for name in ("cornell", "jacquard", "synthetic")
        if (chosen := [e for e in evaluations if e.dataset == name])
    ]
    weights = _weights_table(comparison)
    ablations = [e for e in evaluations if e.predictor.startswith("htc-grasp")]
    return [
        table_4(comparison),
        *([weights] if weights.rows else []),
        *found,
        *([ablation_table(ablations)] if ablations else []),
        _ablations_in_physics(comparison),
    ]


def table_4(comparison: dict[str, Any]) -> TextTable:
    """The paper's rows, then ours."""
    rows = []
    for row in PAPER:
        low, high = wilson(row.successes, row.trials)
        rows.append(
            [
                f"{row.system} ({row.authors}, real robot)",
                f"{row.successes}/{row.trials}",
                f"{row.printed_rate:.1f}%",
                f"{low:.1%} – {high:.1%}",
                "",
                "",
                "",
            ]
        )
    for row in comparison["rows"]:
        rate, counted, interval = rate_cells(row["successes"], row["trials"])
        name = row["predictor"] + (" (control)" if row["kind"] == "control" else "")
        missing = row["planned_trials"] - row["trials"]
        alone = p = tell = ""
        if "p_value" in row:
            alone, p = f"{row['reference_only']} : {row['this_only']}", f"{row['p_holm']:.2g}"
            tell = "∞" if row["trials_to_tell"] is None else str(row["trials_to_tell"])
        name += f", {missing} to go" if missing else ""
        rows.append([name, counted, rate, interval, alone, p, tell])
    title = "Table 4, re-measured"
    if comparison["scenario"]:
        title += f": {comparison['scenario']}, seed {comparison['seed']}"
    reference = f" Reference: {comparison['reference']}." if comparison["reference"] else ""
    head = ("System", "Grasped", "Rate", "95 % interval", "Alone", "p (Holm)", "Trials to tell")
    return TextTable(title, head, rows, NOTE + reference, range(1, 7), frozenset(range(len(PAPER))))


def _weights_table(comparison: dict[str, Any]) -> TextTable:
    rows = []
    for row in comparison["rows"]:
        if not (w := row["weights"]):
            if row["kind"] == "network":
                rows.append([row["predictor"], "", "", "of other weights than those installed", *3 * [""]])
            continue
        begun = f", begun with {w['begun_with']}" if w["begun_with"] else ""
        data = ", ".join(w["folders"] or ["?"]) + begun
        took = f"{w['minutes']} min" if w["minutes"] else "not recorded"
        rows.append(
            [
                row["predictor"],
                f"{w['parameters']:,}",
                str(w["input"] or "?"),
                f"{w['scenes'] or '?'} scenes of {data}",
                f"{w['steps'] or '?'} × {w['batch'] or '?'}",
                took,
                str(w["seed"]),
            ]
        )
    head = ("Network", "Parameters", "Input", "Data", "Steps × batch", "Took", "Seed")
    return TextTable("What was trained on what", head, rows, "", (1, 5, 6))


def _ablations_in_physics(comparison: dict[str, Any]) -> TextTable:
    """The switches of the paper's Table 3 against success in physics."""
    rows = []
    for row in comparison["ablations"]:
        cells = (
            rate_cells(row["successes"], row["trials"]) if "successes" in row else ["not measured", "", ""]
        )
        against = (
            [f"{row['whole_only']} : {row['this_only']}", f"{row['p_holm']:.2g}"]
            if "p_value" in row
            else ["", ""]
        )
        rows.append(
            [
                row["predictor"],
                "✓" if row["external_attention"] else "",
                "✓" if row["channel_attention"] else "",
                *cells,
                *against,
            ]
        )
    note = (
        f"All trained with the same budget. Alone: trials in which only {UNABLATED}, and only this one, "
        "succeeded; p: McNemar's exact two-sided test, Holm-corrected over these rows."
    )
    return TextTable(
        "Table 3's ablations on the trials of Table 4",
        (
            "Predictor",
            "External attention",
            "Channel attention",
            "Rate",
            "Grasped",
            "95 % interval",
            "Alone",
            "p (Holm)",
        ),
        rows,
        note,
        range(3, 8),
    )


def run_folders(folder: Path) -> list[Path]:
    """Runs directly in ``folder``; GraspBenchError when there is none."""
    from grasp_bench.runs.folder import RUN

    found = sorted(p.parent for p in folder.glob(f"*/{RUN}"))
    if not found:
        raise GraspBenchError(f"{folder} holds no run yet; leave out --no-run to make them.")
    return found
