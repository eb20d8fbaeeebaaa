"""Resting poses of an object, and the reference grasps that fit the gripper in each.

Poses come from the facets of the convex hull on which the centre of mass is supported
(Goldberg et al. 1999, as in trimesh), are let go in physics, and are kept as they came to
rest. Reference grasps come from the height field of the true shape and are then tried with
the floating gripper: only those that lifted and held through a shake are kept.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import trimesh
from numpy.typing import NDArray

from grasp_bench.objects.catalog import RestingPose, load_details
from grasp_bench.planning import heightfield, suction
from grasp_bench.planning.depth import SIDE_CLEARANCE
from grasp_bench.planning.heightfield import CELL, HeightField
from grasp_bench.robot.cup import SuctionCup
from grasp_bench.robot.gripper import Gripper
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.builder import SceneObject
from grasp_bench.scene.floating import FloatingGripper, compile_floating
from grasp_bench.scene.rendering import SHOWN_GROUPS
from grasp_bench.system.arrays import Floats

REST_VERSION = 3
"""Raise this when resting poses or reference grasps would come out differently: all are built again then."""
SEEN_VERSION = 2
"""The same for what is built with ``seen`` alone."""
MAX_POSES = 5
LEAST_PROBABILITY = 0.04
SAME_POSE = np.radians(20)
"""Resting directions nearer than this are one pose (the facets of a round can)."""
TRIED = 10
"""Candidate grasps tried in physics for each pose at most."""
KEPT = 6
"""Reference grasps after which no more are tried."""
SOLID_GROUPS = np.array([1, 1, 1, 1, 0, 0], dtype=np.uint8)
"""Geom groups that are shown or collide."""
ROOM_BESIDE = 0.002
"""Room at the sides of a finger on its way down [m]: what the shipped objects were built with, half of the
planner's :data:`SIDE_CLEARANCE`."""
SEEN_ROOM = SIDE_CLEARANCE + 0.001
"""What the planner wants beside a finger, and half a pixel on the table [m]."""
STANDING = 2.0
"""Seconds in which an object put down in its known pose comes to rest."""
STARS = 1e3
"""Height from which rays are cast so far down that they are parallel [m]."""


def resting_directions(model: SceneObject) -> list[tuple[Floats, float]]:
    """Return world-from-object rotations (3, 3) at rest and their probabilities, most probable first."""
    cloud = trimesh.convex.convex_hull(np.vstack(model.hulls))
    transforms, chances = trimesh.poses.compute_stable_poses(
        cloud, center_mass=np.zeros(3), sigma=0, n_samples=1, threshold=0.0, seed=0
    )
    kept: list[tuple[Floats, float]] = []
    for transform, chance in sorted(zip(transforms, chances, strict=True), key=lambda p: -p[1]):
        down = transform[2, :3]
        for i, (other, total) in enumerate(kept):
            if np.arccos(np.clip(other[2] @ down, -1, 1)) < SAME_POSE:
                kept[i] = (other, total + float(chance))
                break
        else:
            kept.append((transform[:3, :3], float(chance)))
    kept.sort(key=lambda p: -p[1])
    likely = [p for p in kept if p[1] >= LEAST_PROBABILITY][:MAX_POSES]
    # As it was modelled is how people put it down, however seldom it would fall so.
    upright = [p for p in kept if p[0][2, 2] > np.cos(SAME_POSE)]
    return likely + [p for p in upright if not any(p is q for q in likely)][:1]


def measure_heights(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    centre: tuple[float, float],
    centre_of_mass: tuple[float, float],
    half: float = 0.20,
    groups: NDArray[np.uint8] = SHOWN_GROUPS,
) -> HeightField:
    """Measure the height field of what stands within ``half`` metres of ``centre``, by vertical rays at
    ``groups``."""
    count = int(2 * half / CELL)
    origin = (centre[0] - half + CELL / 2, centre[1] - half + CELL / 2)
    x, y = np.meshgrid(origin[0] + CELL * np.arange(count), origin[1] + CELL * np.arange(count))
    start = np.array([*centre, STARS])
    rays = np.column_stack([x.ravel(), y.ravel(), np.zeros(count * count)]) - start
    distance = np.zeros(count * count)
    geom = np.zeros(count * count, np.int32)
    mujoco.mj_multiRay(
        model, data, start, rays.ravel(), groups, True, -1, geom, distance, None, count * count, 2 * STARS
    )
    heights = np.where(geom >= 0, STARS * (1 - distance), 0).reshape(count, count)
    return HeightField(np.clip(heights, 0, None).astype(np.float32), origin, centre_of_mass)


def rest(gripper: FloatingGripper, rotation: Floats, model: SceneObject) -> tuple[Floats, Floats] | None:
    """Let the object go with ``rotation`` at the table's centre; its position (3,) and quaternion at
    rest, or None when it rolled over, away or on."""
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation).ravel())
    low = min(float((h @ rotation.T)[:, 2].min()) for h in model.hulls)
    data, q = gripper.data, gripper.object_q[0]
    mujoco.mj_resetData(gripper.model, data)
    gripper.park()
    data.qpos[q : q + 3], data.qpos[q + 3 : q + 7] = (*gripper.scenario.table.center, 0.001 - low), quaternion
    if not gripper.settle(4.0):
        return None
    ended = np.zeros(9)
    mujoco.mju_quat2Mat(ended, data.qpos[q + 3 : q + 7])
    if ended.reshape(3, 3)[2] @ rotation[2] < np.cos(np.radians(15)):
        return None
    return data.qpos[q : q + 3].copy(), data.qpos[q + 3 : q + 7].copy()


def stand(gripper: FloatingGripper, pose: RestingPose) -> tuple[Floats, Floats] | None:
    """Put the object down at the table's centre in a pose that it is known to rest in, the gripper parked.

    Its position (3,) [m] and rotation (3, 3), or None when it did not come to rest.
    """
    data, q = gripper.data, gripper.object_q[0]
    mujoco.mj_resetData(gripper.model, data)
    gripper.park()
    data.qpos[q : q + 3] = (*gripper.scenario.table.center, pose.height)
    data.qpos[q + 3 : q + 7] = pose.quaternion
    if not gripper.settle(STANDING):
        return None
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, data.qpos[q + 3 : q + 7])
    return data.qpos[q : q + 3].copy(), matrix.reshape(3, 3)


def reference_grasps(
    gripper: FloatingGripper, position: Floats, rotation: Floats, seen: bool = False
) -> list[dict[str, Any]]:
    """Return grasps of the resting object that held in physics, best first, in the object's frame.

    Those down to which the fingers come with room at their sides, and all where none has it.

    Args:
        gripper: parked beside the object at rest.
        position, rotation: the object's pose in the world, (3,) [m] and (3, 3).
        seen: only grasps for which the jaws open so wide that a camera's image shows it; see
            :func:`opens_visibly`.
    """
    # With the hulls: where they stand out of the true shape, a finger would meet them on its way down.
    field = measure_heights(
        gripper.model,
        gripper.data,
        (position[0], position[1]),
        (position[0], position[1]),
        groups=SOLID_GROUPS,
    )
    hand = gripper.gripper
    cup = isinstance(hand, SuctionCup)
    found = suction.analyse(field, hand) if cup else heightfield.analyse(field, gripper=hand)
    state = gripper.state()
    kept = []
    tried = 0
    for row, column in heightfield.maxima(found, 4 * TRIED if seen else TRIED):
        tip = np.array(
            [field.origin[0] + column * CELL, field.origin[1] + row * CELL, found.tip[row, column]]
        )
        yaw, opening = float(found.yaw[row, column]), float(found.opening[row, column])
        hidden = seen and not cup and not opens_visibly(field, tip, yaw, opening, hand)
        if tried == TRIED or hidden:
            continue
        tried += 1
        attempt = gripper.attempt(state, tip, yaw, opening)
        if attempt.held:
            score = float(found.quality[row, column]) * float(np.exp(-attempt.slide / 0.01))
            axis = np.array([np.cos(yaw), np.sin(yaw), 0.0])
            kept.append(
                {
                    "tip": np.round(rotation.T @ (tip - position), 5).tolist(),
                    "axis": np.round(rotation.T @ axis, 5).tolist(),
                    "width": round(opening, 4),
                    "top": round(float(found.top[row, column]), 4),
                    "score": round(score, 4),
                }
            )
            if len(kept) == KEPT:
                break
    kept.sort(key=lambda g: -g["score"])
    if cup:
        return kept
    return [g for g in kept if has_room(g, field, position, rotation, hand)] or kept


def has_room(
    grasp: dict[str, Any], field: HeightField, position: Floats, rotation: Floats, gripper: Gripper
) -> bool:
    """Return whether the open fingers come down to a reference grasp without meeting anything of ``field``
    within :data:`ROOM_BESIDE` of their sides."""
    tip = rotation @ np.asarray(grasp["tip"]) + position
    axis = rotation @ np.asarray(grasp["axis"])
    half = gripper.finger_width / 2 + ROOM_BESIDE
    under = heightfield.ground_of_fingers(field, tip[:2], axis[:2], grasp["width"], half, gripper)
    return under <= max(float(tip[2]), heightfield.TABLE_NOISE)


def opens_visibly(
    field: HeightField, tip: Floats, yaw: float, opening: float, gripper: Gripper = PARALLEL_85
) -> bool:
    """Return whether at some opening from ``opening`` on, the fingers pass what they grasp with
    :data:`SEEN_ROOM` to spare: with less, the planner takes the object's edges in a noisy image for the
    ground under the fingers."""
    axis = np.array([np.cos(yaw), np.sin(yaw)])
    free = max(float(tip[2]), heightfield.TABLE_NOISE)
    for wider in np.arange(opening, gripper.opening + 1e-9, CELL):
        under = (
            heightfield.ground_of_fingers(
                field, tip[:2], axis, wider - inwards, gripper.finger_width / 2, gripper
            )
            for inwards in (0.0, 2 * SEEN_ROOM)
        )
        if max(under) <= free:
            return True
    return False


def build_rest(folder: Path, seen: bool = False) -> bool:
    """Write ``object.json`` of an object whose shape stage is done; False when up to date.

    Args:
        folder: the object's folder.
        seen: whether reference grasps must be visible; see :func:`reference_grasps`.
    """
    details = json.loads((folder / "shape.json").read_text())
    version = f"{REST_VERSION}{f'+seen{SEEN_VERSION}' if seen else ''}"
    mark = hashlib.sha256(f"{version}|{details['fingerprint']}".encode()).hexdigest()
    done = folder / "object.json"
    if done.is_file() and json.loads(done.read_text()).get("rest_fingerprint") == mark:
        return False
    model = load_details(folder, details | {"poses": []}, mark)
    scenario = Scenario(name="reference")
    gripper = FloatingGripper(compile_floating(scenario, [model]), scenario)
    poses = []
    for rotation, chance in resting_directions(model):
        rested = rest(gripper, rotation, model)
        if rested is None:
            continue
        position, quaternion = rested
        matrix = np.zeros(9)
        mujoco.mju_quat2Mat(matrix, quaternion)
        poses.append(
            {
                "quaternion": np.round(quaternion, 6).tolist(),
                "height": round(float(position[2]), 5),
                "probability": round(chance, 4),
                "grasps": reference_grasps(gripper, position, matrix.reshape(3, 3), seen),
            }
        )
    done.write_text(json.dumps(details | {"poses": poses, "rest_fingerprint": mark}, indent=1))
    return True
