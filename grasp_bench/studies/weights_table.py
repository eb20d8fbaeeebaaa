"""What each network was trained on, how long, and what came of it: success against training compute."""

from __future__ import annotations

from typing import Any

from grasp_bench.errors import AssetError
from grasp_bench.networks.registry import build, parameter_count
from grasp_bench.networks.store import stored_input
from grasp_bench.predictors.shipped import SHIPPED
from grasp_bench.report import published
from grasp_bench.report.tables import TextTable

HEAD = ("Network", "Parameters", "Input", "Data", "Steps × batch", "Took", "Seed", "PFLOP")
NOTE = (
    "Flat: held-out grasps in physics got no better. Cut off by the clock: more training may still help; "
    "the model card has the command. PFLOP: operations of the training, in convolutions and products of "
    "matrices. Held-out: best grasps of training-like scenes that held, as predicted. Trials: those of "
    "Table 4. Networks of equal steps, equal time or equal operations can be compared."
)

CUT_OFF = f", {published.CUT_OFF}"
"""Of a network whose training was."""


def trained_on(predictor: str, used: dict[str, str | None] | None) -> dict[str, Any] | None:
    """Return the training of a shipped network by its weights' metadata.

    Args:
        predictor: name of the network.
        used: SHA-256 by file of the weights that a run used.

    Returns:
        Facts for the table; None for no network, or where other weights are installed than were used.
    """
    weights = SHIPPED[predictor].weights if predictor in SHIPPED else None
    if weights is None:
        return None
    try:
        if not used or used.get(weights.name) != weights.digest:
            return None
        facts = weights.metadata()
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
        "flops": facts.get("flops"),
        "ended": facts.get("ended"),
        "held_out": facts.get("accuracy", {}).get("held"),
        "scenes": data.get("train"),
        "folders": data.get("folders"),
        "fingerprint": data.get("fingerprint"),
        "begun_with": facts.get("begun_with"),
    }


def weights_table(comparison: dict[str, Any]) -> TextTable:
    """Return the training of each network beside what it achieved, of a comparison's rows."""
    rows = []
    for row in comparison["rows"]:
        if not (w := row["weights"]):
            if row["kind"] == "network":
                rows.append([row["predictor"], "", "", "of other weights than those installed", *6 * [""]])
            continue
        begun = f", begun with {w['begun_with']}" if w["begun_with"] else ""
        data = ", ".join(w["folders"] or ["?"]) + begun
        took = f"{w['minutes']} min" if w["minutes"] else "not recorded"
        took += {"flat": ", flat", "minutes": CUT_OFF}.get(w["ended"] or "", "")
        held, tried = w["held_out"] or (0, 0)
        rows.append(
            [
                row["predictor"],
                f"{w['parameters']:,}",
                str(w["input"] or "?"),
                f"{w['scenes'] or '?'} scenes of {data}",
                f"{w['steps'] or '?'} × {w['batch'] or '?'}",
                took,
                str(w["seed"]),
                f"{w['flops'] / 1e15:.1f}" if w["flops"] else "",
                f"{held}/{tried}" if tried else "",
                f"{row['successes']}/{row['trials']}",
            ]
        )
    head = (*HEAD, "Held-out", "Trials")
    return TextTable("What was trained on what", head, rows, note=NOTE, numbers=(1, 5, 6, 7, 8, 9))
