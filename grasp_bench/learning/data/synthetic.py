"""Synthetic training scenes: random objects at rest, seen by the noisy camera, with dense labels.

Labels come from the same analysis of true heights that finds reference grasps; good, poor and
wrong grasps are tried with the floating gripper, and what physics refutes is marked down. A scene
depends on (seed, index) and the parameters only. The format is that of
:mod:`grasp_bench.learning.data.scenes`, plus

    depth_true  uint16  (S, S)    0.1 mm, without noise
    tried       float32 (M, 6)    x, y [px], angle [rad], width [px], quality by analysis, held
    source      int8    (M,)      where each is from, see :data:`grasp_bench.learning.data.candidates.SOURCES`
    objects     int64   ()        how many there are
    intrinsics  float64 (4,)      fx, fy, cx, cy of the stored image [px]
    annotated   float32 (K, 6)    grasps that held as people draw them, see
                                  :mod:`grasp_bench.learning.data.stages.annotating`; not in plain scenes
    camera_position, camera_rotation   float64 (3,) [m] and (3, 3), columns are camera axes
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cache
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from grasp_bench.errors import GraspBenchError
from grasp_bench.learning.data import labels
from grasp_bench.learning.data.candidates import Candidates, propose
from grasp_bench.learning.data.random_shapes import RandomObject, random_color, random_object
from grasp_bench.learning.data.scenes import packed
from grasp_bench.learning.data.stages.annotating import annotated
from grasp_bench.learning.data.stages.owning import OBJECTS_ONLY, only_of_objects
from grasp_bench.learning.data.stages.plain import plain_shot
from grasp_bench.learning.data.stages.shot import Shot, shoot
from grasp_bench.learning.data.stages.staging import Stage, draw_stage, noisier
from grasp_bench.learning.data.stages.style import Style
from grasp_bench.planning import heightfield
from grasp_bench.planning.heightfield import CELL, HeightField
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.brief import BriefTries
from grasp_bench.scene.floating import FloatingGripper, compile_floating
from grasp_bench.scene.rendering import SHOWN_GROUPS, Picture
from grasp_bench.system.arrays import Floats
from grasp_bench.workshop.poses import measure_heights

Rng = np.random.Generator
Arrays = dict[str, NDArray]

LAYOUTS = 30
"""Random scenes drawn at most until one comes to rest in view."""
MARGIN = 0.06
"""Table analysed around the objects [m]."""
REACH = 0.13
"""Objects whose centre rolls farther than this from the table's are drawn anew [m]."""


@dataclass(frozen=True)
class SynthConfig:
    """Parameters of the scenes.

    Attributes:
        scenario: name of the scenario that is varied.
        size: side of the stored middle of the image [px].
        several: share of scenes with two or three objects.
        spread: half side of the square in which objects are put [m].
        tries: number of grasps tried in physics per scene.
        refuted: factor on the quality of what failed in physics.
        hopeless: share of the scenes without a grasp that held which is kept.
        style: how camera, surroundings, depth and colour are drawn; None for the scenario alone, a little
            varied.
    """

    scenario: str = "table4"
    size: int = 320
    several: float = 0.2
    spread: float = 0.07
    tries: int = 20
    refuted: float = 0.2
    hopeless: float = 0.3
    style: Style | None = None

    def described(self) -> dict[str, Any]:
        """Return the parameters as plain data; a plain style is left out, as older data sets have none."""
        values = {f.name: getattr(self, f.name) for f in fields(self)}
        style = values.pop("style")
        return values if style is None else values | {"style": style.model_dump(mode="json")}


def make_scene(seed: int, index: int, config: SynthConfig) -> Arrays:
    """Make the arrays of the ``index``-th scene of ``seed``."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, index]))
    for _ in range(LAYOUTS):
        laid = lay_out(config, rng)
        if laid is not None:
            scene = record(laid.gripper, laid.objects, config, rng, laid.shot)
            if config.tries == 0 or len(scene["grasps"]) or rng.random() < config.hopeless:
                return scene
    raise GraspBenchError(f"scene {index} of seed {seed}: nothing came to rest in {LAYOUTS} layouts")


class Laid(NamedTuple):
    """Objects at rest beside the parked gripper, and the picture of them."""

    gripper: FloatingGripper
    objects: list[RandomObject]
    shot: Shot


def lay_out(config: SynthConfig, rng: Rng) -> Laid | None:
    """Draw objects and a stage, let all come to rest and take the picture; None where it shows no object at
    rest."""
    stage = _staged(config, rng)
    scenario = stage.scenario
    count = int(rng.integers(2, 4)) if rng.random() < config.several else 1
    objects = [random_object(rng) for _ in range(count)]
    gripper = FloatingGripper(compile_floating(scenario, list(objects)), scenario, count)
    if not arrange(gripper, objects, config.spread, rng):
        return None
    if config.style is None:
        return Laid(gripper, objects, plain_shot(scenario, gripper.model, gripper.data, config.size, rng))
    mujoco.mj_forward(gripper.model, gripper.data)
    shot = shoot(stage, gripper.model, gripper.data, config.size, rng)
    return Laid(gripper, objects, shot) if shot.usable(gripper.model) else None


# ---------------------------------------------------------------- the scene

_base = cache(load_scenario)
"""Read once for all scenes of a process."""


def _staged(config: SynthConfig, rng: Rng) -> Stage:
    base = _base(config.scenario)
    if config.style is None:
        return Stage(jittered(base, rng))
    return draw_stage(base, config.style, config.size, rng)


def jittered(scenario: Scenario, rng: Rng) -> Scenario:
    """Move the camera a little, and draw another table colour and other sensor noise."""
    camera, roll = scenario.camera, np.radians(rng.uniform(-4, 4))
    up = np.array(camera.image_up) @ Rotation.from_euler("z", roll).as_matrix().T
    moved = camera.model_copy(
        update={
            "position": tuple(camera.position + rng.uniform(-0.01, 0.01, 3)),
            "target": tuple(camera.target + rng.uniform(-0.01, 0.01, 3) * [1, 1, 0]),
            "image_up": tuple(up),
        }
    )
    color = scenario.table.color if rng.random() < 0.4 else random_color(rng)
    table = scenario.table.model_copy(update={"color": tuple(np.clip(color + rng.normal(0, 0.03, 3), 0, 1))})
    return scenario.model_copy(
        update={"camera": moved, "table": table, "sensor": noisier(scenario.sensor, rng.uniform(0.3, 1.7))}
    )


def arrange(gripper: FloatingGripper, objects: list[RandomObject], spread: float, rng: Rng) -> bool:
    """Put the objects down at random and let them settle; return whether they came to rest in view."""
    centre = np.array(gripper.scenario.table.center)
    boxes: list[tuple[Floats, Floats]] = []
    for model, q in zip(objects, gripper.object_q, strict=True):
        turn = tipped(np.vstack(model.hulls), rng)
        cloud = np.vstack(model.hulls) @ turn.as_matrix().T
        low, high = cloud.min(0), cloud.max(0)
        for _ in range(8):  # beside the others where there is room, else on top of them
            place = centre + rng.uniform(-spread, spread, 2)
            below = [
                b for a, b in boxes if (low[:2] + place < b[:2]).all() and (high[:2] + place > a[:2]).all()
            ]
            if not below:
                break
        z = max((b[2] for b in below), default=0.0) + 0.001 - low[2]
        position = np.array([*place, z])
        boxes.append((low + position, high + position))
        gripper.data.qpos[q : q + 3], gripper.data.qpos[q + 3 : q + 7] = (
            position,
            turn.as_quat(scalar_first=True),
        )
    if not gripper.settle(2.0):
        return False
    ended = np.array([gripper.data.qpos[q : q + 3] for q in gripper.object_q])
    return bool((np.abs(ended[:, :2] - centre) < REACH).all() and (ended[:, 2] > 0).all())


def tipped(vertices: Floats, rng: Rng) -> Rotation:
    """Draw a rotation that lays the hull of ``vertices`` (N, 3) on a facet (by solid angle), at any yaw."""
    planes = ConvexHull(vertices).equations
    direction = rng.standard_normal(3)
    speed = planes[:, :3] @ direction
    normal = planes[np.argmin(np.where(speed > 1e-9, -planes[:, 3] / np.maximum(speed, 1e-9), np.inf)), :3]
    down, _ = Rotation.align_vectors([[0, 0, -1]], [normal])
    return Rotation.from_euler("z", rng.uniform(-np.pi, np.pi)) * down


# ---------------------------------------------------------------- picture and labels


def record(
    gripper: FloatingGripper, objects: list[RandomObject], config: SynthConfig, rng: Rng, shot: Shot
) -> Arrays:
    """Make the arrays of the scene at rest in ``gripper``, of which ``shot`` is the picture."""
    crop, pose, picture = shot.intrinsics, shot.pose, shot.truth
    view = labels.View(crop, pose, crop.rays() @ pose.rotation.T)

    centres = np.array([gripper.data.body(f"object{i}").xpos[:2] for i in range(len(objects))])
    field = _heights(gripper, objects)
    fixed = gripper.scenario.surroundings is not None
    yaws = heightfield.YAWS + rng.uniform(0, heightfield.YAWS[1])  # no direction is favoured
    found = labels.polished(heightfield.analyse(field, yaws, gripper=gripper.gripper))
    if len(objects) > 1:
        found = labels.balanced(found, field, view, _owner(gripper, picture, len(objects)), centres)
    if fixed:
        found = only_of_objects(found, field, _heights(gripper, objects, OBJECTS_ONLY))
    tried = propose(gripper, found, field, config.tries, rng)
    centre = np.column_stack(
        [field.origin[0] + tried.columns * CELL, field.origin[1] + tried.rows * CELL, tried.top]
    )
    held = _attempts(gripper, tried, centre)
    pixel, angle, width = view.grasps(centre, tried.yaw, tried.opening)
    listed = np.column_stack([pixel, angle, width, tried.quality, held]).astype(np.float32)
    grasps = listed[held, :5]
    grasps[:, 4] = 1
    maps = labels.dense(view, labels.refute(found, tried, held, config.refuted), field, picture)
    if fixed:
        maps = shot.masked(maps, gripper.model)
        grasps = grasps[shot.shows(grasps[:, :2])]
        maps["annotated"] = annotated(grasps, shot.objects(gripper.model), shot.scale)
    return {
        "rgb": shot.rgb,
        "depth": packed(shot.depth),
        "depth_true": packed(picture.depth),
        **maps,
        "grasps": grasps,
        "tried": listed,
        "source": tried.source,
        "objects": np.array(len(objects)),
        "intrinsics": np.array([crop.fx, crop.fy, crop.cx, crop.cy]),
        "camera_position": pose.position,
        "camera_rotation": pose.rotation,
    }


def _heights(
    gripper: FloatingGripper, objects: list[RandomObject], groups: NDArray[np.uint8] = SHOWN_GROUPS
) -> HeightField:
    """Measure true heights around the objects, of what is in ``groups``."""
    clouds = []
    for i, model in enumerate(objects):
        body = gripper.data.body(f"object{i}")
        clouds.append(np.vstack(model.hulls) @ body.xmat.reshape(3, 3).T + body.xpos)
    cloud = np.vstack(clouds)[:, :2]
    low, high = cloud.min(0), cloud.max(0)
    middle, first = (low + high) / 2, gripper.data.body("object0").xpos
    return measure_heights(
        gripper.model,
        gripper.data,
        (middle[0], middle[1]),
        (first[0], first[1]),
        float((high - low).max()) / 2 + MARGIN,
        groups,
    )


def _owner(gripper: FloatingGripper, picture: Picture, count: int) -> NDArray[np.int64]:
    """Return the (S, S) number of the object that each pixel shows, −1 for none."""
    number = np.full(gripper.model.nbody + 1, -1)
    number[[gripper.model.body(f"object{i}").id for i in range(count)]] = np.arange(count)
    return number[np.where(picture.geom >= 0, gripper.model.geom_bodyid[picture.geom], -1)]


def _attempts(gripper: FloatingGripper, tried: Candidates, centre: NDArray[np.floating]) -> NDArray[np.bool_]:
    """Try grasps about the world points ``centre`` (M, 3); return (M,) whether each held."""
    tries = BriefTries(gripper)
    return np.array(
        [
            tries.holds(np.array([x, y, tip]), float(yaw), float(opening))
            for (x, y, _), tip, yaw, opening in zip(centre, tried.tip, tried.yaw, tried.opening, strict=True)
        ],
        bool,
    )
