"""Pieces of MJCF that the models made here share."""

from __future__ import annotations

OPTION = """  <option timestep="0.002" integrator="implicitfast" solver="Newton" jacobian="dense"
          cone="elliptic" impratio="10" noslip_iterations="3"/>"""
"""What a file has for viewing it alone; the scenario's settings are in force in a trial."""


def numbers(*values: float) -> str:
    """Return numbers as an attribute's value."""
    return " ".join(f"{round(v, 9) + 0.0:.10g}" for v in values)
