"""The rows of the report's grid of trials, and their pictures."""

from __future__ import annotations

import base64
from dataclasses import dataclass
from itertools import zip_longest
from math import degrees
from typing import Any

from grasp_bench.media.store import find
from grasp_bench.runs.folder import iter_timings, load_trials


def rows_of(index: int, run: Run, facts: dict[str, dict[str, Any]]) -> list[dict[str, Any]]:
    """One dictionary a trial of the run at position ``index``, without what a trial has not.

    Lengths are in millimetres, angles in degrees: what people read. An episode of clutter has
    such a dictionary for each of its ``attempts``.
    """
    seconds = {t["trial"]: sum(v for k, v in t.items() if k != "trial") for t in iter_timings(run.folder)}
    rows = []
    for record in load_trials(run.folder).to_dict("records"):
        row = {
            "run": index,
            "trial": int(record["trial"]),
            **_numbers(record, facts),
            "seconds": _scaled(seconds.get(record["trial"]), 1, 3),
        }
        episode = _part(record, "clutter")
        if episode:
            row |= {
                "objects": episode["objects"],
                "cleared": episode["cleared"],
                "attempts": [
                    _known(_numbers(a, facts) | {"removed": a.get("removed") or None})
                    for a in episode["attempts"]
                ],
            }
        rows.append(_known(row))
    return rows


def _numbers(record: dict[Any, Any], facts: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """What is shown of one try; None for what it did not come to."""
    grasp, pose, error = (_part(record, k) for k in ("grasp", "pose", "tcp_error"))
    known = facts.get(str(record.get("object")), {})
    row: dict[str, Any] = {
        "object": record.get("object"),
        "category": record.get("category"),
        "outcome": record["outcome"],
        "success": bool(record["success"]),
        "detail": record.get("detail") or None,
        "family": known.get("family"),
        "mass": _scaled(known.get("mass"), 1000, 1),
        "size": _scaled(known.get("size"), 1000, 1),
        "rank": record.get("rank"),
        "lift": _scaled(record.get("lift_height"), 1000, 1),
        "force": _scaled(record.get("contact_force"), 1, 2),
        "steps": record.get("sim_steps"),
    }
    if grasp:
        row |= {
            "quality": grasp["quality"],
            "x": grasp["x"],
            "y": grasp["y"],
            "width": grasp["width"],
            "angle": round(degrees(grasp["angle"]), 2),
        }
    if pose:
        row |= {
            "position": [round(1000 * p, 2) for p in pose["position"]],
            "opening": _scaled(pose["opening"], 1000, 2),
        }
    if error:
        row |= {"tcp_mm": _scaled(error["position"], 1000, 3), "tcp_deg": round(degrees(error["angle"]), 3)}
    return row


def _known(row: dict[str, Any]) -> dict[str, Any]:
    """A row without what is None, or NaN as pandas has it."""
    return {k: v for k, v in row.items() if v is not None and v == v}


def tries_of(row: dict[str, Any]) -> list[tuple[int | None, dict[str, Any]]]:
    """The tries that a trial's row tells of, with their numbers: itself (None), or an episode's attempts."""
    return list(enumerate(row["attempts"])) if "attempts" in row else [(None, row)]


def _part(record: dict[str, Any], key: str) -> dict[str, Any] | None:
    """A nested record; pandas fills what is missing with NaN."""
    value = record.get(key)
    return value if isinstance(value, dict) else None


def _scaled(value: float | None, factor: float, digits: int) -> float | None:
    return None if value is None else round(factor * value, digits)


@dataclass(frozen=True)
class Embedded:
    """Pictures to put into the page.

    Attributes:
        media: by a try's name in the page (``0-17`` is trial 17 of the first run, ``0-17-2`` its third
            attempt): base64 of ``sheet`` and ``clip``.
        found: number of pictures and clips there are.
        left_out: how many of them did not fit.
    """

    media: dict[str, dict[str, str]]
    found: int
    left_out: int


def embed(runs: list[Run], rows: list[dict[str, Any]], budget: int) -> Embedded:
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
        name = f"{run}-{trial}" if number is None else f"{run}-{trial}-{number}"
        media.setdefault(name, {})[kind] = base64.b64encode(path.read_bytes()).decode()
    return Embedded(media, found, left_out)
