"""Objects that no pair of fingers from above can hold: narrow in the middle, wide and closed at the top.

Seen from above all of them are wider than 86 mm both ways, one millimetre more than the reference gripper
opens; what can be held lies below, between foot and top, where fingers come from the side. Sizes and masses
are those of common things of the kind, made up within what is usual; the benchmark's 180 objects stay as
they are.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from grasp_bench.workshop.build import build_shape
from grasp_bench.workshop.model import ObjectSpec, Part
from grasp_bench.workshop.poses import build_rest
from grasp_bench.workshop.shapes import Mesh, box, cylinder, move, sphere

SOURCE = "made up for grasps from the side, within the usual sizes of its kind"
Solid = tuple[Callable[[], Mesh], str, str]
"""A convex solid standing on z = 0, its colour and its material."""


def _round(radius: float, height: float, top: float | None = None) -> tuple[Callable[[], Mesh], float]:
    return lambda: cylinder(radius, height, top=top), height


def _square(x: float, y: float, height: float) -> tuple[Callable[[], Mesh], float]:
    return lambda: box(x, y, height), height


def _ball(radius: float) -> tuple[Callable[[], Mesh], float]:
    return lambda: move(sphere(radius), z=radius), 2 * radius


def _stacked(*solids: tuple[tuple[Callable[[], Mesh], float], str, str]) -> Callable[[], list[Part]]:
    """Return what builds solids one on top of the other, each half a millimetre into the one below."""

    def build() -> list[Part]:
        parts, z = [], 0.0
        for (make, height), color, material in solids:
            parts.append(Part(move(make(), z=max(z - 0.5, 0.0)), color, material, "convex"))
            z = max(z - 0.5, 0.0) + height
        return parts

    return build


def _thing(name: str, mass: float, material: str, build: Callable[[], list[Part]]) -> ObjectSpec:
    return ObjectSpec(name, name, "toys", mass, material, SOURCE, build)


STEEL, WOOD, WHITE, RED, BLUE, GREEN, GOLD, GREY = (
    "#8a8d91", "#b5824a", "#e8e6e1", "#b8322e", "#3562a8", "#3f7a4a", "#c9a13b", "#5b5e63",
)  # fmt: skip

THINGS: dict[str, ObjectSpec] = {
    thing.name: thing
    for thing in (
        _thing(
            "upright_dumbbell",
            0.6,
            "rubber",
            _stacked(
                (_round(46, 35), GREY, "rubber"),
                (_round(16, 85), STEEL, "rubber"),
                (_round(46, 35), GREY, "rubber"),
            ),
        ),
        _thing(
            "thread_spool",
            0.25,
            "plastic",
            _stacked(
                (_round(46, 12), WHITE, "plastic"),
                (_round(24, 90), RED, "plastic"),
                (_round(46, 12), WHITE, "plastic"),
            ),
        ),
        _thing(
            "cake_stand",
            0.5,
            "ceramic",
            _stacked(
                (_round(48, 14), WHITE, "ceramic"),
                (_round(15, 105), WHITE, "ceramic"),
                (_round(70, 10), WHITE, "ceramic"),
            ),
        ),
        _thing(
            "table_lamp",
            0.5,
            "ceramic",
            _stacked(
                (_round(50, 22), BLUE, "ceramic"),
                (_round(15, 105), BLUE, "ceramic"),
                (_round(62, 80, 47), WHITE, "paper"),
            ),
        ),
        _thing(
            "toadstool_lamp",
            0.35,
            "plastic",
            _stacked(
                (_round(46, 10), WHITE, "plastic"),
                (_round(22, 95), WHITE, "plastic"),
                (_round(55, 35, 44), RED, "plastic"),
            ),
        ),
        _thing(
            "toy_bar_stool",
            0.2,
            "wood",
            _stacked(
                (_round(46, 10), WOOD, "wood"), (_round(13, 100), WOOD, "wood"), (_round(46, 22), RED, "wood")
            ),
        ),
        _thing(
            "lidded_goblet",
            0.4,
            "aluminium",
            _stacked(
                (_round(46, 10), GOLD, "aluminium"),
                (_round(12, 90), GOLD, "aluminium"),
                (_round(40, 45, 46), GOLD, "aluminium"),
            ),
        ),
        _thing(
            "trophy",
            0.5,
            "aluminium",
            _stacked(
                (_square(90, 90, 30), GREY, "stone"),
                (_round(16, 85), GOLD, "aluminium"),
                (_square(95, 95, 40), GOLD, "aluminium"),
            ),
        ),
        _thing(
            "hourglass",
            0.3,
            "glass",
            _stacked(
                (_round(47, 12), WOOD, "wood"),
                (_round(34, 40, 15), WHITE, "glass"),
                (_round(15, 25), WHITE, "glass"),
                (_round(15, 40, 34), WHITE, "glass"),
                (_round(47, 12), WOOD, "wood"),
            ),
        ),
        _thing(
            "desk_globe",
            0.45,
            "plastic",
            _stacked(
                (_round(48, 18), WOOD, "wood"),
                (_round(14, 85), GOLD, "aluminium"),
                (_ball(52), BLUE, "plastic"),
            ),
        ),
        _thing(
            "desk_fan",
            0.5,
            "plastic",
            _stacked(
                (_round(50, 22), WHITE, "plastic"),
                (_round(16, 90), WHITE, "plastic"),
                (_square(110, 92, 90), WHITE, "plastic"),
            ),
        ),
        _thing(
            "small_loudspeaker",
            0.6,
            "wood",
            _stacked(
                (_square(110, 110, 14), GREY, "steel"),
                (_round(16, 95), GREY, "wood"),
                (_square(100, 95, 80), WOOD, "wood"),
            ),
        ),
        _thing(
            "bird_bath",
            0.6,
            "stone",
            _stacked(
                (_round(50, 16), GREY, "stone"),
                (_round(18, 90), GREY, "stone"),
                (_round(66, 22, 75), GREY, "stone"),
            ),
        ),
        _thing(
            "candle_on_stand",
            0.45,
            "brass",
            _stacked(
                (_round(48, 16), GOLD, "brass"),
                (_round(14, 85), GOLD, "brass"),
                (_round(46, 12), GOLD, "brass"),
                (_round(44, 60), WHITE, "wax"),
            ),
        ),
        _thing(
            "chess_queen",
            0.35,
            "wood",
            _stacked(
                (_round(46, 22), WOOD, "wood"),
                (_round(26, 90, 16), WOOD, "wood"),
                (_round(46, 40), WOOD, "wood"),
            ),
        ),
        _thing(
            "plant_on_pedestal",
            0.5,
            "ceramic",
            _stacked(
                (_round(48, 14), WHITE, "ceramic"),
                (_round(19, 90), WHITE, "ceramic"),
                (_round(45, 45, 55), GREEN, "ceramic"),
            ),
        ),
        _thing(
            "foot_television",
            0.5,
            "plastic",
            _stacked(
                (_square(110, 100, 14), GREY, "plastic"),
                (_square(34, 22, 85), GREY, "plastic"),
                (_square(130, 92, 80), GREY, "plastic"),
            ),
        ),
        _thing(
            "toy_letter_box",
            0.3,
            "wood",
            _stacked(
                (_square(100, 100, 12), GREEN, "wood"),
                (_square(26, 26, 95), WOOD, "wood"),
                (_square(130, 92, 70), RED, "wood"),
            ),
        ),
        _thing(
            "gumball_machine",
            0.6,
            "plastic",
            _stacked(
                (_round(50, 35), RED, "plastic"),
                (_round(26, 75), RED, "plastic"),
                (_ball(50), WHITE, "plastic"),
            ),
        ),
        _thing(
            "pedestal_table",
            0.35,
            "wood",
            _stacked(
                (_square(100, 100, 12), WOOD, "wood"),
                (_square(28, 28, 100), WOOD, "wood"),
                (_square(115, 115, 12), WOOD, "wood"),
            ),
        ),
        _thing(
            "hat_stand_bust",
            0.45,
            "fabric",
            _stacked(
                (_square(100, 100, 12), WOOD, "wood"),
                (_round(20, 85), WOOD, "wood"),
                (_round(50, 85, 44), WHITE, "foam"),
            ),
        ),
        _thing(
            "soda_fountain",
            0.5,
            "steel",
            _stacked(
                (_square(110, 92, 30), RED, "plastic"),
                (_square(40, 30, 85), STEEL, "steel"),
                (_square(110, 92, 35), RED, "plastic"),
            ),
        ),
    )
}


def build(name: str, folder: Path) -> bool:
    """Build one of :data:`THINGS` below ``folder``; False where it was up to date."""
    shaped = build_shape(THINGS[name], folder)
    return build_rest(folder / name) or shaped
