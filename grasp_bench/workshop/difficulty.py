"""How difficult an object is, measured: the share of random antipodal tries that do not hold.

No contestant sets its own exam: the tries come from the true surface (:mod:`grasp_bench.workshop.antipodal`),
and the floating gripper tells which of them hold.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np

from grasp_bench.objects.catalog import ObjectModel, load_details
from grasp_bench.planning import heightfield
from grasp_bench.planning.heightfield import CELL
from grasp_bench.robot.gripper import Gripper
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.brief import BriefTries
from grasp_bench.scene.floating import compile_floating
from grasp_bench.scene.floating_cup import floating as floating_of
from grasp_bench.workshop.antipodal import Jaws, antipodal
from grasp_bench.workshop.poses import measure_heights, stand

VERSION = 1
"""Raise this when a difficulty would come out differently: all are measured again then."""
TRIES = 300
"""Tries of an object, shared out over its graspable resting poses by how often trials draw them."""
ROUNDS = 12
"""Times that pairs are looked for, where there are few."""


def measure(model: ObjectModel, gripper: Gripper = PARALLEL_85, tries: int = TRIES) -> dict[str, Any]:
    """Try random antipodal grasps of an object; returns what ``object.json`` says of its difficulty.

    Raises:
        ValueError: where fewer than half as many pairs as wanted are found that the jaws span.
    """
    rng = np.random.default_rng(int.from_bytes(hashlib.sha256(model.name.encode()).digest()[:8], "big"))
    scenario = Scenario(name="reference")
    floating = floating_of(compile_floating(scenario, [model], gripper), scenario, 1, gripper)
    poses = model.graspable_poses
    chances = np.array([p.probability for p in poses])
    held = tried = 0
    for pose, share in zip(poses, chances / chances.sum(), strict=True):
        placed = stand(floating, pose)
        if placed is None:
            continue
        (x, y, _), _ = placed
        field = measure_heights(floating.model, floating.data, (x, y), (x, y))
        pairs: list[Jaws] = []
        for _ in range(ROUNDS):
            pairs += antipodal(floating, field, round(tries * share) - len(pairs), rng)
        attempts = BriefTries(floating)
        for row, column, yaw in pairs:
            at = np.array([row]), np.array([column])
            found = heightfield.grasps_at(field, *at, yaw, gripper)
            tip = [field.origin[0] + column * CELL, field.origin[1] + row * CELL, float(found["tip"][0])]
            held += attempts.holds(np.array(tip), yaw, float(found["opening"][0]))
        tried += len(pairs)
    if tried < tries / 2:
        raise ValueError(f"{model.name}: only {tried} antipodal pairs fit between the jaws")
    return {"held": held, "tried": tried, "gripper": gripper.name, "force": scenario.gripper.force}


def build_difficulty(folder: Path) -> bool:
    """Write the difficulty of an object into the ``object.json`` of its rest stage; False when up to date."""
    path = folder / "object.json"
    details = json.loads(path.read_text())
    mark = hashlib.sha256(f"{VERSION}|{TRIES}|{details['rest_fingerprint']}".encode()).hexdigest()
    if details.get("difficulty_fingerprint") == mark:
        return False
    measured = measure(load_details(folder, details))
    path.write_text(json.dumps(details | {"difficulty": measured, "difficulty_fingerprint": mark}, indent=1))
    return True
