"""How a scene looks: lamps that cast shadows, highlights, and procedural textures.

A scenario without a ``look`` is drawn in the plain light of the reference (docs/definition.md, section 4).
Depth cameras bring their own light: a look changes colours only.
"""

from __future__ import annotations

from typing import Annotated, Literal, get_args

from pydantic import Field

from grasp_bench.scenario.fields import Fraction, NonNegative, Positive, Section, Vector

Color = tuple[Fraction, Fraction, Fraction]
Pattern = Literal["clouds", "speckles", "stripes", "checks", "grain", "marble", "patches"]
PATTERNS: tuple[str, ...] = get_args(Pattern)


class Texture(Section):
    """A pattern in space that a surface is cut out of, so that no mesh needs texture coordinates.

    Attributes:
        pattern: ``clouds`` (soft blotches), ``speckles`` (grains on a ground), ``stripes``, ``checks``,
            ``grain`` (wood), ``marble`` (veins), ``patches`` (areas with sharp borders, as print has).
        color: of the pattern; the ground has the surface's own.
        scale: size of its parts [m].
        contrast: how far the pattern hides the ground, 0 to 1.
        turn_deg: of its direction about the vertical.
        seed: of its random part.
    """

    pattern: Pattern = "clouds"
    color: Color = (0.3, 0.3, 0.3)
    scale: Positive = 0.02
    contrast: Fraction = 0.5
    turn_deg: float = 0.0
    seed: Annotated[int, Field(ge=0)] = 0


class Lamp(Section):
    """A small lamp.

    Attributes:
        position: in the world [m].
        color: share of red, green and blue in its light.
        strength: what it adds at the table's centre to a surface that faces it; ambient light and lamps of
            together 1 show a white surface just white.
    """

    position: Vector
    color: Color = (1.0, 1.0, 1.0)
    strength: NonNegative = 0.6


class Look(Section):
    """Lamps and textures.

    Attributes:
        lamps: each darkens what it does not reach.
        ambient: light from everywhere.
        ambient_color: its red, green and blue.
        shadow_blur: width of the half-shadow [px].
        highlights: strength of the lamps' mirror images in smooth surfaces.
        background: colour where there is nothing.
        table, floor: their textures.
        objects: textures of the objects' parts, taken in turn; empty for plain ones.
    """

    lamps: tuple[Lamp, ...] = ()
    ambient: NonNegative = 0.4
    ambient_color: Color = (1.0, 1.0, 1.0)
    shadow_blur: Annotated[float, Field(ge=0, le=20)] = 2.0
    highlights: Fraction = 0.3
    background: Color = (0.5, 0.5, 0.5)
    table: Texture | None = None
    floor: Texture | None = None
    objects: tuple[Texture, ...] = ()
