"""Random surroundings: what stands on and around the table and is not to be grasped.

Each function gives the fixtures of one kind. ``Place`` says where the objects are and from where they are
seen: nothing comes between them and the camera on purpose, and nothing stands where they are put down.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from grasp_bench.learning.data.stages.painting import ON_TABLES, near, surface_color, texture
from grasp_bench.learning.data.stages.style import ColourStyle, SurroundingsStyle
from grasp_bench.scenario.look import Color
from grasp_bench.scenario.surroundings import Fixture, Surroundings
from grasp_bench.system.arrays import Floats

Rng = np.random.Generator

CLEAR = 0.17
"""Nothing solid but rims stands nearer to the table's middle [m]."""
LEAST_DISTANCE = 0.13
"""Of walls and edges from the table's middle [m]."""
WALL = 0.04
"""Thickness of walls [m]."""


@dataclass(frozen=True)
class Place:
    """Where things may stand.

    Attributes:
        center: (2,) the table's middle [m].
        camera: (3,) its position [m].
        view: half side of the stored picture on the table [m].
        table: the table's colour.
    """

    center: Floats
    camera: Floats
    view: float
    table: Color

    @property
    def far(self) -> float:
        """Direction from the camera towards the table's middle and beyond [rad]; any, seen from above."""
        x, y = self.center - self.camera[:2]
        return float(np.arctan2(y, x))

    def at(self, distance: float, direction: float, z: float) -> tuple[float, float, float]:
        """Return the point at a distance from the middle."""
        x, y = self.center + distance * np.array([np.cos(direction), np.sin(direction)])
        return float(x), float(y), float(z)


def surroundings(rng: Rng, style: SurroundingsStyle, colour: ColourStyle, place: Place) -> Surroundings:
    """Draw all that stands around."""
    fixtures: list[Fixture] = []
    if rng.random() < style.wall:
        fixtures += walls(rng, style, colour, place)
    rim = rng.random()
    if rim < style.bin + style.tray:
        fixtures += rims(rng, place, high=rim < style.bin)
    for share, kind in (
        (style.shelf, shelf),
        (style.things, things),
        (style.large, large_things),
        (style.robot, robot_links),
        (style.flat, flat_things),
    ):
        if rng.random() < share:
            fixtures += kind(rng, place)
    return Surroundings(
        fixtures=tuple(fixtures),
        table=table_edges(rng, style, place) if rng.random() < style.edge else _wide(place),
        floor_height=float(-rng.uniform(0.35, 1.1)),
        floor_color=surface_color(rng, 0.15, colour.vivid),
    )


def _wide(place: Place) -> tuple[float, float, float, float]:
    (x, y), reach = place.center, 1.6
    return float(x - reach), float(y - reach), float(x + reach), float(y + reach)


def table_edges(rng: Rng, style: SurroundingsStyle, place: Place) -> tuple[float, float, float, float]:
    """Draw a table that ends near the objects on one to three sides."""
    reach = np.full(4, 1.6)
    sides = rng.permutation(4)[: int(rng.integers(1, 4))]
    reach[sides] = np.maximum(rng.uniform(*style.edge_distance, len(sides)) * place.view, LEAST_DISTANCE)
    x, y = place.center
    return float(x - reach[0]), float(y - reach[1]), float(x + reach[2]), float(y + reach[3])


def walls(rng: Rng, style: SurroundingsStyle, colour: ColourStyle, place: Place) -> list[Fixture]:
    """Draw a wall, mostly on the far side, perhaps another at a right angle to it."""
    facing = place.far + rng.normal(0, 0.5)
    directions = [facing, facing + rng.choice([-1, 1]) * np.pi / 2][: 2 if rng.random() < style.corner else 1]
    paint = place.table if rng.random() < style.same_color else surface_color(rng, 0.4, colour.vivid)
    found = []
    for direction in directions:
        distance = max(rng.uniform(*style.wall_distance) * place.view, LEAST_DISTANCE)
        outward = np.array([np.cos(direction), np.sin(direction)])
        if (place.camera[:2] - place.center) @ outward > distance - 0.05:
            continue  # the camera would stand behind it
        height = rng.uniform(0.08, 0.3) if rng.random() < 0.25 else rng.uniform(0.4, 1.5)
        below = 0.5 if rng.random() < 0.5 else 0.0  # stands on the floor, or on the table
        color = near(paint, rng, 0.01)
        found.append(
            Fixture(
                size=(WALL, 3.0, height + below),
                position=place.at(distance + WALL / 2, direction, (height - below) / 2),
                turn_deg=(0, 0, float(np.degrees(direction))),
                color=color,
                roughness=float(rng.uniform(0.4, 1)),
                texture=texture(rng, color, ON_TABLES) if rng.random() < colour.wall_texture else None,
            )
        )
    return found


def rims(rng: Rng, place: Place, high: bool) -> list[Fixture]:
    """Draw a bin (``high``) or a tray around the objects."""
    inner = rng.uniform([0.28, 0.24], [0.5, 0.42])
    height = rng.uniform(0.04, 0.11) if high else rng.uniform(0.008, 0.03)
    thick = rng.uniform(0.003, 0.015)
    yaw = rng.uniform(0, np.pi)
    shift = rng.uniform(-0.03, 0.03, 2)
    color = surface_color(rng, 0.2)
    roughness = float(rng.uniform(0.4, 1))
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    found = []
    for axis in (0, 1):
        for side in (-1, 1):
            offset, size = np.zeros(2), np.full(2, thick)
            offset[axis] = side * (inner[axis] + thick) / 2
            size[1 - axis] = inner[1 - axis] + 2 * thick
            x, y = place.center + shift + turn @ offset
            found.append(
                Fixture(
                    size=(float(size[0]), float(size[1]), float(height)),
                    position=(float(x), float(y), float(height) / 2),
                    turn_deg=(0, 0, float(np.degrees(yaw))),
                    color=color,
                    roughness=roughness,
                )
            )
    x, y = place.center + shift
    bottom = Fixture(
        size=(float(inner[0]), float(inner[1]), 0.01),
        position=(float(x), float(y), -0.0045),
        turn_deg=(0, 0, float(np.degrees(yaw))),
        color=near(color, rng, 0.01),
        roughness=roughness,
        solid=False,
    )
    return [*found, bottom]


def shelf(rng: Rng, place: Place) -> list[Fixture]:
    """Draw boards behind the objects, with things on them."""
    direction = place.far + rng.normal(0, 0.3)
    distance, depth, width = rng.uniform(0.3, 0.55), rng.uniform(0.15, 0.3), rng.uniform(0.4, 1.0)
    color, yaw = surface_color(rng, 0.3), float(np.degrees(direction))
    if np.hypot(*(place.camera[:2] - place.center)) > distance and abs(direction - place.far) > np.pi / 2:
        return []
    found = []
    height = 0.0
    for _ in range(int(rng.integers(1, 4))):
        height += rng.uniform(0.12, 0.3)
        found.append(
            Fixture(
                size=(float(depth), float(width), 0.018),
                position=place.at(distance + depth / 2, direction, height),
                turn_deg=(0, 0, yaw),
                color=color,
            )
        )
        for _ in range(int(rng.integers(0, 4))):
            size = rng.uniform(0.04, 0.12, 3)
            along = rng.uniform(-0.4, 0.4) * width
            base = np.array(place.at(distance + depth / 2, direction, height + 0.009 + size[2] / 2))
            base[:2] += along * np.array([-np.sin(direction), np.cos(direction)])
            found.append(_thing(rng, size, base))
    for side in (-0.5, 0.5):
        post = np.array(place.at(distance + depth / 2, direction, height / 2))
        post[:2] += side * width * np.array([-np.sin(direction), np.cos(direction)])
        found.append(
            Fixture(
                size=(float(depth), 0.018, float(height)),
                position=(float(post[0]), float(post[1]), float(post[2])),
                turn_deg=(0, 0, yaw),
                color=color,
            )
        )
    return found


def _thing(rng: Rng, size: Floats, position: Floats) -> Fixture:
    color = surface_color(rng, 0.2)
    return Fixture.model_validate(
        {
            "shape": str(rng.choice(["box", "box", "cylinder", "ellipsoid", "capsule"])),
            "size": size.tolist(),
            "position": position.tolist(),
            "turn_deg": (0, 0, float(rng.uniform(0, 360))),
            "color": color,
            "roughness": float(rng.uniform(0.1, 1)),
            "texture": texture(rng, color) if rng.random() < 0.3 else None,
        }
    )


def things(rng: Rng, place: Place) -> list[Fixture]:
    """Draw things at the edge of the picture and behind, cut off by it or nearly so."""
    found = []
    for _ in range(int(rng.integers(1, 5))):
        size = rng.uniform(0.03, 0.15, 3)
        distance = max(place.view * rng.uniform(0.8, 1.6), CLEAR) + np.hypot(size[0], size[1]) / 2
        direction = place.far + rng.normal(0, 1.2)
        found.append(_thing(rng, size, np.array(place.at(distance, direction, size[2] / 2))))
    return found


def large_things(rng: Rng, place: Place) -> list[Fixture]:
    """Draw things that no gripper spans: cartons, books, monitors."""
    found = []
    for _ in range(int(rng.integers(1, 3))):
        size = np.array([rng.uniform(0.11, 0.3), rng.uniform(0.11, 0.4), rng.uniform(0.02, 0.35)])
        distance = CLEAR + np.hypot(size[0], size[1]) / 2 + rng.uniform(0, 0.25)
        direction = place.far + rng.normal(0, 0.9)
        thing = _thing(rng, size, np.array(place.at(distance, direction, size[2] / 2)))
        found.append(thing.model_copy(update={"shape": "box"}))
    return found


def robot_links(rng: Rng, place: Place) -> list[Fixture]:
    """Draw one to three links of an arm that reach into the picture from one side, seen only."""
    direction = rng.uniform(0, 2 * np.pi)
    color = near([(0.9, 0.9, 0.9), (0.15, 0.15, 0.16), (0.9, 0.45, 0.1)][int(rng.integers(3))], rng)
    radius = rng.uniform(0.03, 0.06)
    points = [
        np.array(place.at(place.view * rng.uniform(0.75, 1.1) + 0.1, direction, rng.uniform(0.05, 0.25)))
    ]
    for _ in range(int(rng.integers(1, 4))):
        out = np.array([np.cos(direction), np.sin(direction), 0]) * rng.uniform(0.15, 0.35)
        points.append(points[-1] + out + [*rng.normal(0, 0.08, 2), rng.uniform(-0.05, 0.25)])
    found = []
    for first, second in itertools.pairwise(points):
        middle, way = (first + second) / 2, second - first
        length = float(np.linalg.norm(way))
        pitch = float(np.degrees(np.arccos(way[2] / length)))
        yaw = float(np.degrees(np.arctan2(way[1], way[0])))
        x, y, z = (float(v) for v in middle)
        found.append(
            Fixture(
                shape="capsule",
                size=(float(2 * radius), float(2 * radius), length + 2 * float(radius)),
                position=(x, y, max(z, 0.0)),
                turn_deg=(0, pitch, yaw),
                color=color,
                roughness=0.35,
                solid=False,
            )
        )
    return found


def flat_things(rng: Rng, place: Place) -> list[Fixture]:
    """Draw sheets of paper, stickers and marks on the table, too flat to be grasped."""
    found = []
    for _ in range(int(rng.integers(1, 5))):
        size = np.exp(rng.uniform(np.log(0.015), np.log(0.3), 2))
        thick = rng.uniform(0.0002, 0.0015)
        distance, direction = rng.uniform(0, place.view * 1.2), rng.uniform(0, 2 * np.pi)
        color = surface_color(rng, 0.4)
        found.append(
            Fixture(
                shape="box" if rng.random() < 0.7 else "cylinder",
                size=(float(size[0]), float(size[1]), 0.004),
                position=place.at(distance, direction, thick - 0.002),
                turn_deg=(0, 0, float(rng.uniform(0, 360))),
                color=color,
                texture=texture(rng, color) if rng.random() < 0.4 else None,
                solid=False,
            )
        )
    return found
