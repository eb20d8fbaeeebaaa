"""The rows of the report's grid of trials, and their pictures."""

from __future__ import annotations

import base64
from dataclasses import dataclass
from itertools import zip_longest
from math import degrees
from typing import Any

from grasp_bench.media.store import find
from grasp_bench.report.breakdown import ObjectFacts
from grasp_bench.runs.folder import load_timings
from grasp_bench.runs.record import Attempted
from grasp_bench.runs.results import RunResults


def rows_of(
    index: int, run: RunResults, facts: dict[str, ObjectFacts], same: dict[int, int]
) -> list[dict[str, Any]]:
    """Return one dictionary a trial of the run at position ``index``, without keys for what is unknown.

    ``same`` holds by trial what equal trials of all runs share. Lengths are in millimetres, angles in
    degrees: what people read. An episode of clutter has such a dictionary for each of its ``attempts``.
    """
    seconds = {t.trial: round(t.total, 3) for t in load_timings(run.folder)}
    rows = []
    for record in run.records:
        row = {
            "run": index,
            "trial": record.trial,
            "same": same.get(record.trial),
            **_numbers(record, facts),
            "seconds": seconds.get(record.trial),
        }
        if episode := record.clutter:
            row |= {
                "objects": episode.objects,
                "cleared": episode.cleared,
                "attempts": [
                    _known(_numbers(a, facts) | {"removed": a.removed or None}) for a in episode.attempts
                ],
            }
        rows.append(_known(row))
    return rows


def _numbers(record: Attempted, facts: dict[str, ObjectFacts]) -> dict[str, Any]:
    """Return what is shown of one try; None for what it did not come to."""
    known = facts.get(record.object)
    row: dict[str, Any] = {
        "object": record.object,
        "category": record.category,
        "outcome": record.outcome,
        "success": record.success,
        "detail": record.detail or None,
        "family": known and known.family,
        "mass": known and round(1000 * known.mass, 1),
        "size": known and round(1000 * known.size, 1),
        "rank": record.rank,
        "widening": record.widening_mm,
        "shortfall": record.shortfall_mm,
        "lift": round(1000 * record.lift_height, 1),
        "force": round(record.contact_force, 2),
        "steps": record.sim_steps,
    }
    if grasp := record.grasp:
        row |= {
            "quality": grasp.quality,
            "x": grasp.x,
            "y": grasp.y,
            "width": grasp.width,
            "angle": round(degrees(grasp.angle), 2),
        }
    if pose := record.pose:
        row |= {
            "position": [round(1000 * p, 2) for p in pose.position.tolist()],
            "opening": round(1000 * pose.opening, 2),
        }
    if record.success and (margin := record.margin):
        row |= {
            "margin": round(margin.force, 2),
            "factor": round(margin.factor, 2),
            "direction": margin.direction,
            "torque": margin.torque,
        }
    if error := record.tcp_error:
        row |= {"tcp_mm": round(1000 * error.position, 3), "tcp_deg": round(degrees(error.angle), 3)}
    return row


def _known(row: dict[str, Any]) -> dict[str, Any]:
    """Return a row without what is None."""
    return {k: v for k, v in row.items() if v is not None}


def tries_of(row: dict[str, Any]) -> list[tuple[int | None, dict[str, Any]]]:
    """Return the tries of a trial's row with their numbers: itself (None), or an episode's attempts."""
    return list(enumerate(row["attempts"])) if "attempts" in row else [(None, row)]


def name_of(run: int, trial: int, number: int | None) -> str:
    """Return the name of a try in the page: ``0-17`` is trial 17 of the first run, ``0-17-2`` an attempt."""
    return f"{run}-{trial}" if number is None else f"{run}-{trial}-{number}"


@dataclass(frozen=True)
class Embedded:
    """Pictures to put into the page.

    Attributes:
        media: base64 of ``sheet`` and ``clip``, by a try's name in the page (:func:`name_of`).
        found, left_out: number of all pictures and clips, and of those that did not fit.
    """

    media: dict[str, dict[str, str]]
    found: int
    left_out: int


def embed(runs: list[RunResults], rows: list[dict[str, Any]], budget: int) -> Embedded:
    """Choose the pictures that fit into ``budget`` bytes of base64.

    Failures come first, their sheets before their clips; runs take turns.
    """
    tries = [
        (row["run"], row["trial"], number, one["success"]) for row in rows for number, one in tries_of(row)
    ]
    queue: list[tuple[int, int, int | None, str]] = []
    for success, kind in ((False, "sheet"), (False, "clip"), (True, "sheet"), (True, "clip")):
        by_run = [[t for t in tries if t[0] == i and t[3] is success] for i in range(len(runs))]
        queue += [(t[0], t[1], t[2], kind) for turn in zip_longest(*by_run) for t in turn if t is not None]
    media: dict[str, dict[str, str]] = {}
    found = left_out = 0
    for run, trial, number, kind in queue:
        path = getattr(find(runs[run].folder, trial, number), kind)
        if path is None:
            continue
        found += 1
        size = -(-path.stat().st_size // 3) * 4
        if size > budget:
            left_out += 1
            continue
        budget -= size
        media.setdefault(name_of(run, trial, number), {})[kind] = base64.b64encode(path.read_bytes()).decode()
    return Embedded(media, found, left_out)
