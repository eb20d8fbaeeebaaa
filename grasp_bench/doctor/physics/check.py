"""The verdict of a self-test."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class Check:
    """One quantity of the physics, as expected and as measured.

    Attributes:
        name: what was tested.
        expected: value [``unit``] of a closed form; 0 for what should vanish, or only be bounded.
        measured: value in the simulation [``unit``].
        error, tolerance: error, and greatest error that passes; relative or in ``unit``.
        relative: whether ``error`` and ``tolerance`` are relative.
        source: the closed form or limit, and its origin.
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
        """Whether the error is within the tolerance; NaN never is."""
        return bool(self.error <= self.tolerance)

    def to_json(self) -> dict[str, Any]:
        """Return plain data."""
        *others, source = asdict(self).items()
        return dict([*others, ("passed", self.passed), source])


def equals(name: str, expected: float, measured: float, unit: str, tolerance: float, source: str) -> Check:
    """Check a value that a closed form gives; ``tolerance`` is relative."""
    error = abs(measured - expected) / abs(expected)
    return Check(name, float(expected), float(measured), unit, float(error), tolerance, True, source)


def below(name: str, measured: float, limit: float, unit: str, source: str) -> Check:
    """Check a magnitude that should vanish and must stay within ``limit``."""
    return Check(name, 0.0, float(measured), unit, float(abs(measured)), limit, False, source)
