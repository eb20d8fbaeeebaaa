"""How a benchmark object is described in code, and the register of all of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from grasp_bench.workshop.materials import MATERIALS
from grasp_bench.workshop.shapes import Mesh

FAMILIES = ("kitchen", "utensils", "food", "tools", "office", "toys")
"""Themes the object modules are grouped by."""


@dataclass(frozen=True)
class Part:
    """One closed body of an object.

    Attributes:
        mesh: watertight mesh in millimetres.
        color: ``#rrggbb``.
        material: key of :data:`~grasp_bench.workshop.materials.MATERIALS`; its density
            shares the object's mass out over the parts.
        threshold: CoACD concavity for this part; ``None`` takes the build's default,
            ``"convex"`` uses the part's own hull (for parts that are convex already).
    """

    mesh: Mesh
    color: str
    material: str
    threshold: float | str | None = None

    def __post_init__(self) -> None:
        if self.material not in MATERIALS:
            raise ValueError(f"unknown material {self.material!r}; choose from {', '.join(MATERIALS)}")


@dataclass(frozen=True)
class ObjectSpec:
    """A household object: name, true mass and size, and the code that models it.

    Attributes:
        name: unique, in snake_case.
        category: what it is (mug, pliers, …); at most four objects share one.
        family: one of :data:`FAMILIES`.
        mass: kilograms.
        material: what the fingers mostly touch; sets the friction.
        source: where size and mass come from.
        build: returns the parts, modelled in millimetres, z up.
    """

    name: str
    category: str
    family: str
    mass: float
    material: str
    source: str
    build: Callable[[], list[Part]] = field(repr=False)


REGISTRY: dict[str, ObjectSpec] = {}


def household(
    *, category: str, family: str, mass: float, material: str, source: str, name: str | None = None
) -> Callable[[Callable[[], list[Part]]], Callable[[], list[Part]]]:
    """Register the decorated function as the model of a household object.

    The object's name is the function's unless ``name`` is given.

    Raises:
        ValueError: for a name used twice, an unknown family or material.
    """

    def register(build: Callable[[], list[Part]]) -> Callable[[], list[Part]]:
        key = name or build.__name__
        if key in REGISTRY:
            raise ValueError(f"object {key!r} is registered twice")
        if family not in FAMILIES:
            raise ValueError(f"unknown family {family!r}; choose from {', '.join(FAMILIES)}")
        if material not in MATERIALS:
            raise ValueError(f"unknown material {material!r}; choose from {', '.join(MATERIALS)}")
        REGISTRY[key] = ObjectSpec(key, category, family, mass, material, source, build)
        return build

    return register
