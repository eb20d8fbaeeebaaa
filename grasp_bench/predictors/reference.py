"""Reference grasps from any direction: sampled on the true shape, tried in physics, kept by hash.

What :mod:`grasp_bench.workshop.poses` does from above, here over all directions above the table: pairs of
places that face each other (:mod:`grasp_bench.predictors.antipodes`), hands around them that meet nothing
on their straight way, and of these the ones that a floating gripper lifted and held through a shake. They
are worked out when first asked for, an object in one resting pose at a time, and kept in the user's cache.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from grasp_bench.errors import PredictorError
from grasp_bench.grasps import GraspPose
from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.predictors.antipodes import Pair, Union, approaches, pairs
from grasp_bench.robot.cup import SuctionCup
from grasp_bench.robot.gripper import Gripper
from grasp_bench.scenario.robots import with_gripper
from grasp_bench.scenario.sections import Motion, Scenario
from grasp_bench.scene.tilting import TiltingGripper
from grasp_bench.system import cache
from grasp_bench.system.arrays import Floats

Hand = tuple[GraspPose, float]
"""A hand in the world, and how good it looks."""
VERSION = 2
"""Raise this when reference grasps would come out differently: all are worked out again then."""
WAYS = 12
"""Directions of approach around the jaws' axis."""
STEEPEST = 0.15
"""Greatest rise of the approach: the hand comes from above or from the side, hardly from below."""
DEPTHS = (0.6, 0.3)
"""How far the tips reach beyond what is held, in heights of a pad."""
ROOMS = (0.010, 0.005)
"""Room between each open pad and what it closes on, where the gripper opens so wide [m]."""
LEAST_DEPTH = -0.001
"""How far the tips must reach beyond the middle of what is held, where the table draws them back [m]."""
WAY = (0.02, 0.045, 0.07, 0.10)
"""Places before the grasp at which the hand must meet nothing [m]."""
TRIED, KEPT = 72, 24
"""Grasps tried in physics, and those that held after which no more are tried."""
AROUND = 8
"""Sectors of the approach around the vertical; hands are tried in turn by sector, to keep some of all."""
PATIENCE = 120
"""Hands in a row that meet something after which a sector is given up."""
SPREAD = 0.015
"""Hands of a sector are taken in turn from cubes of this size, lest all be of one crowded place [m]."""
LEVER = 0.06
"""Distance of a grasp from the centre of mass at which its score has fallen to 1/e [m]."""


def reference_poses(model: ObjectModel, index: int, gripper: Gripper) -> list[tuple[GraspPose, float]]:
    """Return grasps that held, best first, in the object's frame, and how high each TCP is [m].

    Args:
        model: the object.
        index: which of its resting poses it lies in.
        gripper: the gripper.
    """
    path = _file(model, index, gripper)
    try:
        rows = json.loads(path.read_text())["grasps"]
    except (OSError, ValueError, KeyError, TypeError):  # not there yet, or damaged
        rows = find(model, index, gripper)
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile("w", dir=path.parent, suffix=".part", delete=False) as file:
            json.dump({"object": model.name, "pose": index, "gripper": gripper.name, "grasps": rows}, file)
        os.replace(file.name, path)
    return [
        (GraspPose(np.array(r["position"]), np.array(r["rotation"]), r["opening"], r["score"]), r["height"])
        for r in rows
    ]


def _file(model: ObjectModel, index: int, gripper: Gripper) -> Path:
    mark = hashlib.sha256(f"{VERSION}|{gripper.digest}|{model.digest}|{index}".encode()).hexdigest()[:32]
    return cache.folder().parent / "reference-6dof" / f"{mark}.json"


def find(model: ObjectModel, index: int, gripper: Gripper) -> list[dict[str, Any]]:
    """Work out the grasps of :func:`reference_poses`.

    Raises:
        PredictorError: for a suction cup, whose places are no pairs.
    """
    if isinstance(gripper, SuctionCup):
        raise PredictorError(f"oracle-6dof knows grasps of two jaws only; {gripper.name} is a suction cup.")
    scenario = with_gripper(Scenario(name="reference"), gripper.name)
    floating = TiltingGripper(scenario, model, gripper)
    pose = model.poses[index]
    data, q = floating.data, floating.object_q[0]
    mujoco.mj_resetData(floating.model, data)
    floating.park()
    data.qpos[q : q + 3] = (*scenario.table.center, pose.height)
    data.qpos[q + 3 : q + 7] = pose.quaternion
    if not floating.settle(2.0):
        return []
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, data.qpos[q + 3 : q + 7])
    place, turn = data.qpos[q : q + 3].copy(), matrix.reshape(3, 3)
    state = floating.state()
    rng = np.random.default_rng(int(hashlib.sha256(f"{model.digest}|{index}".encode()).hexdigest()[:8], 16))
    shape = Union([h @ turn.T + place for h in model.hulls])
    up = np.array([0.0, 0.0, 1.0])
    found = pairs(shape, gripper.opening - 0.002, math.atan(model.friction), up, rng)
    sectors = _sectors(_candidates(found, place, gripper))
    kept: list[dict[str, Any]] = []
    tried = 0
    while sectors and tried < TRIED and len(kept) < KEPT:
        for key in list(sectors):
            if tried == TRIED or len(kept) == KEPT:
                break
            hand, score = _next(sectors[key], lambda h: _free(floating, state, h))
            if hand is None:
                del sectors[key]
                continue
            tried += 1
            attempt = floating.attempt_pose(state, hand)
            if attempt.held:
                score *= math.exp(-attempt.slide / 0.01)
                kept.append(_row(hand, score, place, turn))
    return sorted(kept, key=lambda g: -g["score"])


def _free(floating: TiltingGripper, state: tuple[Floats, Floats], hand: GraspPose) -> bool:
    """Return whether the hand meets nothing on its straight way."""
    return all(floating.reaches(state, hand, back) for back in (0.0, *WAY))


def _next(sector: Iterator[Hand], free: Callable[[GraspPose], bool]) -> tuple[GraspPose | None, float]:
    """Return the next hand of a sector that meets nothing, None where there is none soon."""
    for hand, score in islice(sector, PATIENCE):
        if free(hand):
            return hand, score
    return None, 0.0


def _row(hand: GraspPose, score: float, place: Floats, turn: Floats) -> dict[str, Any]:
    """Return a grasp as it is kept, in the frame of the object at ``place`` (3,) and ``turn`` (3, 3)."""
    return {
        "position": np.round(turn.T @ (hand.position - place), 6).tolist(),
        "rotation": (turn.T @ hand.rotation).tolist(),
        "opening": round(hand.opening, 5),
        "score": round(float(score), 4),
        "height": round(float(hand.position[2]), 5),
    }


def _candidates(found: list[Pair], centre: Floats, gripper: Gripper) -> list[Hand]:
    """Return hands around pairs of places, and how good they look."""
    up = np.array([0.0, 0.0, 1.0])
    hands = []
    for pair in found:
        lever = float(np.linalg.norm(pair.middle - centre))
        for approach in approaches(pair.axis, up, WAYS):
            if approach[2] > STEEPEST:
                continue
            rotation = np.column_stack([pair.axis, np.cross(approach, pair.axis), approach])
            for room in ROOMS:
                opening = min(pair.width + 2 * room, gripper.opening)
                depths = {_depth(pair.middle, rotation, opening, s * gripper.pad[2], gripper) for s in DEPTHS}
                for depth in sorted(d for d in depths if d is not None):
                    tip = pair.middle + depth * approach
                    deep = min(1.0, max(0.0, depth / (DEPTHS[0] * gripper.pad[2])))
                    roomy = 0.9 + 0.1 * room / ROOMS[0]
                    score = pair.alignment * math.exp(-lever / LEVER) * (0.8 + 0.2 * deep) * roomy
                    hands.append((GraspPose(tip, rotation, opening), score))
    return hands


def _depth(middle: Floats, rotation: Floats, opening: float, wanted: float, gripper: Gripper) -> float | None:
    """Return how far beyond ``middle`` (3,) the tips get before a finger is too near the table [m],
    ``wanted`` at most; None where that is not far enough to hold."""
    outer = opening / 2 + gripper.finger_thickness
    reach = outer * abs(rotation[2, 0]) + gripper.finger_width / 2 * abs(rotation[2, 1])
    room = float(middle[2]) - reach - Motion().table_clearance  # between the lowest corner and the table
    steep = -float(rotation[2, 2])
    if room - wanted * steep >= 0:
        return wanted
    depth = room / steep if steep > 0 else -math.inf
    return depth if depth >= LEAST_DEPTH else None


def _sectors(hands: list[Hand]) -> dict[tuple[int, int], Iterator[Hand]]:
    """Return hands by the sector of their approach, the best of each place first; steep ones come first."""
    sectors: dict[tuple[int, int], list[tuple[int, Hand]]] = {}
    before: Counter[tuple[int, ...]] = Counter()
    for hand, score in sorted(hands, key=lambda h: -h[1]):
        x, y, z = hand.approach
        around = int(AROUND * (math.atan2(y, x) / (2 * math.pi) + 0.5)) % AROUND if z > -0.95 else 0
        sector = min(int(3 * (1 + z)), 3), around
        place = *sector, *np.floor(hand.position / SPREAD).astype(int).tolist()
        sectors.setdefault(sector, []).append((before[place], (hand, score)))
        before[place] += 1
    return {
        key: iter([hand for _, hand in sorted(sectors[key], key=lambda h: h[0])]) for key in sorted(sectors)
    }
