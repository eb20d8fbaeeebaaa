"""Pieces of MJCF that the models made here share."""

from __future__ import annotations

from textwrap import indent

OPTION = """  <option timestep="0.002" integrator="implicitfast" solver="Newton" jacobian="dense"
          cone="elliptic" impratio="10" noslip_iterations="3"/>"""
"""What a file has for viewing it alone; the scenario's settings are in force in a trial."""


def numbers(*values: float) -> str:
    """Return numbers as an attribute's value."""
    return " ".join(f"{round(v, 9) + 0.0:.10g}" for v in values)


def seen_and_solid(rubber: str, depth: int) -> str:
    """Return the default classes of what is seen, of what collides, and of pads with their contacts.

    Args:
        rubber: colour of pads, as an attribute's value.
        depth: spaces before each line.
    """
    classes = f"""<default class="visual">
  <geom type="box" group="2" contype="0" conaffinity="0" mass="0"/>
</default>
<default class="collision">
  <geom type="box" group="3" mass="0" rgba="0.9 0.5 0.2 0.5"/>
  <default class="pad">
    <geom rgba="{rubber}" condim="4" priority="1" friction="0.9 0.005 0.0001" solref="0.004 1"
          solimp="0.995 0.999 0.0005"/>
  </default>
</default>"""
    return indent(classes, depth * " ")
