"""A record beside that of the same trial done again: same to the bit, within rounding, or different."""

from __future__ import annotations

import re
from enum import StrEnum
from typing import Any

from grasp_bench.runs.record import TrialRecord

ROUNDING = 1e-4
"""Difference that rounding explains: a tenth of a millimetre, or a ten-thousandth of the larger number."""
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?")


class Verdict(StrEnum):
    """How a trial that was done again compares with its record."""

    SAME = "the same to the bit"
    ROUNDING = "the same within rounding"
    DIFFERENT = "different"


def verdict(stored: TrialRecord, new: TrialRecord) -> Verdict:
    """Compare the records of a trial.

    Another kind of processor adds in another order, so a network's last digits differ there, and with them
    those of the grasp and of the motion. A trial at its edge may end otherwise for that reason alone.
    """
    if stored.line() == new.line():
        return Verdict.SAME
    return Verdict.ROUNDING if _close(stored.to_json(), new.to_json()) else Verdict.DIFFERENT


def _close(a: Any, b: Any) -> bool:
    """Whether two values are the same but for rounding; numbers in the words of ``detail`` may be any."""
    if isinstance(a, bool) or isinstance(b, bool) or a is None or b is None:
        return a is b
    if isinstance(a, int | float) and isinstance(b, int | float):
        return abs(a - b) <= ROUNDING * max(1.0, abs(a), abs(b))
    if isinstance(a, dict) and isinstance(b, dict):
        return a.keys() == b.keys() and all(
            _NUMBER.sub("#", a[key]) == _NUMBER.sub("#", b[key])
            if key == "detail"
            else _close(a[key], b[key])
            for key in a
        )
    if isinstance(a, list | tuple) and isinstance(b, list | tuple):
        return len(a) == len(b) and all(map(_close, a, b))
    return a == b
