"""Verdicts over a record and the same trial done again."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from grasp_bench.replay.verdict import Verdict, verdict
from grasp_bench.runs.record import TrialRecord

RUN = Path(__file__).parents[2] / "results" / "reference" / "htc-grasp"
GRASP = {"x": 307.5, "y": 252.5, "angle": -0.391686, "width": 37.17, "quality": 0.67394}


def changed(**changes: Any) -> tuple[TrialRecord, TrialRecord]:
    """A committed record with :data:`GRASP`, and that with other values; ``a__b`` is key ``b`` of ``a``."""
    line = json.loads((RUN / "trials.jsonl").read_text().splitlines()[2]) | {"grasp": GRASP}
    return differing(line, **changes)


def differing(line: dict[str, Any], **changes: Any) -> tuple[TrialRecord, TrialRecord]:
    other = json.loads(json.dumps(line))
    for key, value in changes.items():
        *above, last = key.split("__")
        part = other
        for name in above:
            part = part[name]
        part[last] = value
    return TrialRecord.read(line), TrialRecord.read(other)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({}, Verdict.SAME),
        ({"grasp__angle": -0.391687}, Verdict.ROUNDING),  # trial 2 with SSE 4.1 instead of AVX-512
        ({"grasp__angle": -0.39169, "grasp__quality": 0.67391}, Verdict.ROUNDING),
        ({"grasp__angle": -0.3910}, Verdict.DIFFERENT),
        ({"lift_height": 0.0}, Verdict.DIFFERENT),
        ({"rank": 1}, Verdict.DIFFERENT),
        ({"sim_steps": 3000}, Verdict.DIFFERENT),
        ({"pose": None, "grasp": None}, Verdict.DIFFERENT),
        ({"object": "arcade_joystick_2"}, Verdict.DIFFERENT),
        ({"outcome": "slipped", "success": False}, Verdict.DIFFERENT),
    ],
)
def test_three_verdicts(changes: dict[str, Any], expected: Verdict) -> None:
    assert verdict(*changed(**changes)) is expected


def test_numbers_in_the_reason_may_be_rounded_to_another_one() -> None:
    slipped = {"outcome": "slipped", "success": False, "lift_height": 0.01102}
    told = {"detail": "lost while lifting, 11 mm above its place"}
    line = json.loads((RUN / "trials.jsonl").read_text().splitlines()[2]) | slipped | told
    stored, new = differing(line, detail="lost while lifting, 12 mm above its place", lift_height=0.01099)
    assert verdict(stored, new) is Verdict.ROUNDING
    assert verdict(*differing(line, detail="lost while carried")) is Verdict.DIFFERENT
