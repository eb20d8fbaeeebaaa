"""How objects are imported, and what one is before it is written."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from grasp_bench.objects.catalog import VisualPart
from grasp_bench.system.arrays import Floats
from grasp_bench.workshop.decompose import DecompositionError
from grasp_bench.workshop.shapes import Mesh

FRICTION = 0.6
"""Friction against the pads where none is given: that of the shipped plastic, ceramic and glass objects."""


@dataclass(frozen=True)
class Options:
    """How objects are imported.

    Attributes:
        units: ``m``, ``cm``, ``mm``, ``in`` or ``auto``.
        up: the file's upward axis: ``y``, ``z`` or ``auto`` (y for GLB, as glTF 2.0 has it, for DAE what it
            says; else z).
        mass: that of the object [kg]; None where it is not given.
        density: for objects without a mass [kg/m³]; None where it is not given.
        friction: sliding friction coefficient against the finger pads.
        inertia: ``solid`` or ``shell``, how the mass is spread.
        holes: ``auto``, ``fill`` or ``keep``; see :func:`~grasp_bench.workshop.importing.repair.mend`.
        category: what the objects are; their name when None.
        source: where size and mass come from, for the manifest.
        length: the longest side that the object is scaled to [m]; None where its unit tells.
        scale: metres that the file's unit is; None where ``units`` or ``length`` tells.
    """

    units: str = "auto"
    up: str = "auto"
    mass: float | None = None
    density: float | None = None
    friction: float = FRICTION
    inertia: str = "solid"
    holes: str = "auto"
    category: str | None = None
    source: str = ""
    length: float | None = None
    scale: float | None = None


@dataclass
class Body:
    """An object before it is written; metres, z up.

    Attributes:
        visual: the coloured parts.
        solid: what they enclose.
        hulls: the convex pieces.
        error: how far the hulls stray from the solid.
        notes: findings and repairs.
        mass, centre, inertia: mass properties known from the file, about ``centre``; None if not.
        facts: further entries of ``import`` in ``object.json``.
    """

    visual: list[VisualPart]
    solid: Mesh
    hulls: list[Mesh]
    error: DecompositionError
    notes: list[str]
    mass: float | None = None
    centre: Floats | None = None
    inertia: Floats | None = None
    facts: dict[str, Any] = field(default_factory=dict)
