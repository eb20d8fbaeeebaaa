"""The verdict of a self-test."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Check:
    """One quantity that the physics should have, and what it has.

    Attributes:
        name: what was tested.
        expected: by a closed form; for a quantity that should vanish, or only be bounded, 0.
        measured: in the same ``unit``.
        unit: of both.
        error: relative where ``relative``, otherwise in ``unit``.
        tolerance: greatest error that passes, in the same measure.
        relative: how ``error`` and ``tolerance`` are to be read.
        source: the closed form or limit, and where it is from.
    """

    name: str
    expected: float
    measured: float
    unit: str
    error: float
    tolerance: float
    relative: bool
    source: str

    @property
    def passed(self) -> bool:
        """The error is within the tolerance; NaN never is."""
        return bool(self.error <= self.tolerance)

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "name": self.name,
            "expected": self.expected,
            "measured": self.measured,
            "unit": self.unit,
            "error": self.error,
            "tolerance": self.tolerance,
            "relative": self.relative,
            "passed": self.passed,
            "source": self.source,
        }


def equals(name: str, expected: float, measured: float, unit: str, tolerance: float, source: str) -> Check:
    """Check of a value that a closed form gives; ``tolerance`` is relative."""
    error = abs(measured - expected) / abs(expected)
    return Check(name, float(expected), float(measured), unit, float(error), tolerance, True, source)


def below(name: str, measured: float, limit: float, unit: str, source: str) -> Check:
    """Check of a magnitude that should vanish and must stay within ``limit``."""
    return Check(name, 0.0, float(measured), unit, float(abs(measured)), limit, False, source)
