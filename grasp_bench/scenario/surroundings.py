"""What stands around the table's middle and is not to be grasped: walls, bins, shelves, other things."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from grasp_bench.scenario.fields import Fraction, Positive, Section, Vector
from grasp_bench.scenario.look import Color, Texture


class Fixture(Section):
    """A fixed thing.

    Attributes:
        shape: ``box``, ``cylinder`` (along its z), ``capsule`` (along its z) or ``ellipsoid``.
        size: edges of the box around it [m].
        position: of its middle in the world [m].
        turn_deg: turns about the world's x, y and z axes, in this order.
        color: of its surface.
        roughness: 0 (mirror) to 1 (matt).
        texture: pattern on it.
        solid: whether it can be touched; other things are only seen.
    """

    shape: Literal["box", "cylinder", "capsule", "ellipsoid"] = "box"
    size: tuple[Positive, Positive, Positive]
    position: Vector
    turn_deg: Vector = (0.0, 0.0, 0.0)
    color: Color = (0.7, 0.7, 0.7)
    roughness: Fraction = 0.8
    texture: Texture | None = None
    solid: bool = True


class Surroundings(Section):
    """All that is fixed besides the robot and the plane that carries the objects.

    Attributes:
        fixtures: walls, rims, things on the table.
        table: least x and y and greatest x and y of the table top that is seen [m]; None for the whole of
            ``table.size``. Objects are carried beyond its edges, too.
        floor_height: height of the floor [m].
        floor_color: its colour.
    """

    fixtures: Annotated[tuple[Fixture, ...], Field(max_length=200)] = ()
    table: tuple[float, float, float, float] | None = None
    floor_height: Annotated[float, Field(ge=-3, le=-0.06)] = -0.75
    floor_color: Color = (0.35, 0.36, 0.38)

    @model_validator(mode="after")
    def _consistent(self) -> Surroundings:
        if self.table is not None and not (self.table[0] < self.table[2] and self.table[1] < self.table[3]):
            raise ValueError("surroundings.table: give least x, least y, greatest x, greatest y")
        return self
