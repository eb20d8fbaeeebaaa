"""Objects put down on the table: one for a trial, several beside and on top of each other for an episode."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import mujoco
import numpy as np
from shapely import Polygon
from shapely.affinity import translate

from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.builder import NOT_IN_THE_MODEL, compile_mjcf, compose_many, object_name
from grasp_bench.scene.kept import settle
from grasp_bench.scene.world import UnstableError, World
from grasp_bench.system.arrays import Floats

LAYOUTS = 5
"""Layouts tried before an episode whose objects never come to rest is unstable."""
PLACES = 40
"""Places tried beside the others before an object is dropped onto them."""
GAP = 0.004
"""Room between footprints where there is some [m]."""
KEPT = 12
"""Compiled tables that a process keeps: an attempt after a failed one finds the same objects, and all
predictors that clear a table begin with the same."""


@dataclass(frozen=True)
class Resting:
    """An object on the table: position (3,) [m] and quaternion w, x, y, z."""

    model: ObjectModel
    position: Floats
    quaternion: Floats


def put_down(
    world: World, model: ObjectModel, scenario: Scenario, rng: np.random.Generator, scene: str = ""
) -> None:
    """Put the object down in a random graspable resting pose and let it come to rest.

    Poses are drawn by their probability among those in which some grasp fits the gripper,
    with uniform yaw and a uniform place in the workspace.

    Args:
        scene: digest of the world's model, under which the rest is kept; it is not where there is none.
    """
    height, quaternion = random_pose(model, rng)
    x, y = rng.uniform(-1, 1, 2) * scenario.table.workspace + scenario.table.center
    world.place_object(np.array([x, y, height + scenario.settling.clearance]), quaternion)
    if scene:
        settle(world, scene)
    else:
        world.settle()


def random_pose(model: ObjectModel, rng: np.random.Generator) -> tuple[float, Floats]:
    """Draw the height of the centre of mass [m] and quaternion of a graspable resting pose at any yaw."""
    poses = model.graspable_poses
    weights = np.array([p.probability for p in poses])
    pose = poses[rng.choice(len(poses), p=weights / weights.sum())]
    yaw = rng.uniform(-math.pi, math.pi)
    turn = np.array([math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)])
    return pose.height, multiply_quaternions(turn, pose.quaternion)


def multiply_quaternions(a: Floats, b: Floats) -> Floats:
    """Return the Hamilton product of quaternions w, x, y, z."""
    product = np.zeros(4)
    mujoco.mju_mulQuat(product, np.asarray(a, float), np.asarray(b, float))
    return product


def world_of(left: list[Resting], scenario: Scenario) -> World:
    """Make the world of the objects where they rest, and the arm at home."""
    models = tuple(r.model for r in left)
    settings = scenario.model_dump_json(exclude=NOT_IN_THE_MODEL)
    kept = _compiled(_Objects(settings, tuple(m.digest for m in models), scenario, models))
    world = World(
        copy.copy(kept),
        scenario,
        [object_name(i) for i in range(len(left))],
        [r.model.friction for r in left],
    )
    for i, place in enumerate(left):
        world.aim(i)
        world.place_object(place.position, place.quaternion)
    return world


@dataclass(frozen=True)
class _Objects:
    """What a compiled model is made of; the same where settings and digests are."""

    settings: str
    digests: tuple[str, ...]
    scenario: Scenario = field(compare=False)
    models: tuple[ObjectModel, ...] = field(compare=False)


@lru_cache(KEPT)
def _compiled(objects: _Objects) -> mujoco.MjModel:
    return compile_mjcf(compose_many(objects.scenario, objects.models))


def resting(world: World, left: list[Resting]) -> list[Resting]:
    """Return where the objects of a world are now."""
    return [
        Resting(r.model, world.data.xpos[body].copy(), world.data.xquat[body].copy())
        for r, body in zip(left, world.bodies, strict=True)
    ]


def lay_out(models: Sequence[ObjectModel], scenario: Scenario, rng: np.random.Generator) -> list[Resting]:
    """Put objects down at rest on the table, in graspable poses where they were put; piled where there was no
    room.

    Each is put down in a random graspable resting pose at a random place beside the others, or, when there
    is none, dropped onto them. Layouts that do not come to rest are drawn again.

    Raises:
        UnstableError: when none of several layouts came to rest.
    """
    why = ""
    for _ in range(LAYOUTS):
        placed = _placed(models, scenario, rng)
        world = world_of(placed, scenario)
        try:
            world.settle()
        except UnstableError as error:
            why = str(error)
            continue
        return resting(world, placed)
    raise UnstableError(f"in {LAYOUTS} layouts: {why}")


def _placed(models: Sequence[ObjectModel], scenario: Scenario, rng: np.random.Generator) -> list[Resting]:
    from scipy.spatial import ConvexHull

    assert scenario.clutter is not None
    centre, spread = np.array(scenario.table.center), np.array(scenario.clutter.workspace)
    placed: list[Resting] = []
    taken: list[tuple[Polygon, float]] = []
    matrix = np.zeros(9)
    for model in models:
        height, quaternion = random_pose(model, rng)
        mujoco.mju_quat2Mat(matrix, quaternion)
        cloud = np.vstack(model.hulls) @ matrix.reshape(3, 3).T
        outline = Polygon(cloud[ConvexHull(cloud[:, :2]).vertices, :2]).buffer(GAP)
        place, below = centre, [0.0]
        for _ in range(PLACES):
            place = centre + rng.uniform(-1, 1, 2) * spread
            here = translate(outline, *place)
            below = [top for other, top in taken if here.intersects(other)]
            if not below:
                break
        base = max(below, default=0.0)
        z = base + height + scenario.settling.clearance
        taken.append((translate(outline, *place), z + float(cloud[:, 2].max())))
        placed.append(Resting(model, np.array([*place, z]), quaternion))
    return placed
