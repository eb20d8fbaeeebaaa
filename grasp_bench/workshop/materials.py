"""Materials: density, and friction against the rubber pads of a gripper.

The friction coefficients are rounded middles of the ranges engineering handbooks give
for dry rubber on each material (The Engineering ToolBox, *Friction coefficients*;
Persson, *Sliding Friction*, 2000), lowered for glossy or greasy surfaces; robot makers
assume 0.3 for silicone on oily steel as the worst case (Robotiq Hand-E manual, p. 72).
They are leads, not measurements of these objects: sweep them to see what depends on them.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Material:
    """A material an object is made of.

    Attributes:
        density: shares an object's measured mass out over its parts [kg/m³].
        friction: sliding friction coefficient against the gripper's rubber pads.
        roughness: 0 (mirror) to 1 (matt); how depth cameras see it.
    """

    density: float
    friction: float
    roughness: float


MATERIALS: dict[str, Material] = {
    "steel": Material(7850, 0.55, 0.3),
    "aluminium": Material(2700, 0.55, 0.35),
    "brass": Material(8500, 0.55, 0.3),
    "iron": Material(7200, 0.65, 0.7),
    "glass": Material(2500, 0.60, 0.1),
    "ceramic": Material(2400, 0.60, 0.3),
    "plastic": Material(1050, 0.60, 0.5),
    "polyethylene": Material(950, 0.50, 0.6),
    "rubber": Material(1200, 0.95, 0.9),
    "silicone": Material(1150, 0.90, 0.8),
    "wood": Material(650, 0.70, 0.8),
    "cork": Material(240, 0.80, 0.9),
    "cardboard": Material(350, 0.65, 0.9),
    "paper": Material(800, 0.65, 0.9),
    "fabric": Material(400, 0.75, 1.0),
    "leather": Material(900, 0.75, 0.8),
    "foam": Material(60, 0.80, 1.0),
    "bristle": Material(300, 0.60, 0.9),
    "fruit": Material(950, 0.65, 0.6),
    "bread": Material(350, 0.70, 0.9),
    "chocolate": Material(1300, 0.55, 0.6),
    "wax": Material(900, 0.50, 0.6),
    "soap": Material(1050, 0.45, 0.5),
    "stone": Material(2600, 0.65, 0.8),
    "oiled_plastic": Material(1050, 0.30, 0.3),
    "liquid": Material(1000, 0.60, 0.5),
}
