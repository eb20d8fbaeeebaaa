"""Grasps on an object in NVIDIA's isaac_grasp YAML, format version 1.0, written and read.

The format (Isaac Sim's documentation, “Grasp Editor”; Isaac ROS's, “Isaac Grasp File”) gives the pose of a
gripper's frame in the object's, position in metres and a quaternion w, xyz, with the gripper's joints
before and at the grasp. Which frame is meant is for people to say: here it is the flange's, with z the
approach and x the jaws.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
import yaml
from scipy.spatial.transform import Rotation

from grasp_bench.errors import AssetError
from grasp_bench.grasps import GraspPose
from grasp_bench.robot.gripper import Gripper
from grasp_bench.system.yaml_text import read_yaml

FORMAT, VERSION = "isaac_grasp", 1.0
MOST = 10_000
"""Most grasps that a file is read with."""


def write_isaac_grasps(path: Path, grasps: Sequence[GraspPose], gripper: Gripper, object_frame: str) -> None:
    """Write grasps of ``gripper`` on an object.

    Args:
        path: file to write.
        grasps: TCP poses in the object's frame.
        gripper: whose flange is the gripper's frame; its finger joints are those of its model.
        object_frame: what the object's frame is called.
    """
    rows = {}
    for i, grasp in enumerate(grasps):
        flange = grasp.position - gripper.flange_to_tcp * grasp.approach
        x, y, z, w = Rotation.from_matrix(grasp.rotation).as_quat()
        rows[f"grasp_{i}"] = {
            "confidence": float(grasp.quality),
            "position": _plain(flange),
            "orientation": {"w": round(float(w), 9), "xyz": _plain([x, y, z])},
            "cspace_position": _joints(gripper, 0.0),
            "pregrasp_cspace_position": _joints(gripper, grasp.opening),
        }
    content = {
        "format": FORMAT,
        "format_version": VERSION,
        "object_frame": object_frame,
        "gripper_frame": f"{gripper.name}/flange",
        "grasps": rows,
    }
    path.write_text(yaml.safe_dump(content, sort_keys=False, default_flow_style=None), encoding="utf-8")


def read_isaac_grasps(path: Path, gripper: Gripper, jaws: Literal["x", "y"] = "x") -> list[GraspPose]:
    """Return the grasps of a file as TCP poses in the object's frame, most confident first.

    Args:
        path: an isaac_grasp file.
        gripper: its flange is taken for the file's gripper frame, z the approach; its opening counts where
            the file's joints before the grasp are not its own.
        jaws: axis of that frame along which the jaws open; ``y`` for the Panda's hand.

    Raises:
        AssetError: in one line, for what is no such file.
    """
    try:
        content = read_yaml(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        why = " ".join(str(error).split())
        raise AssetError(f"{path} cannot be read as an isaac_grasp file ({why}).") from error
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise AssetError(f"{path} is no isaac_grasp file: its first line must be 'format: {FORMAT}'.")
    if str(content.get("format_version")) != str(VERSION):
        told = content.get("format_version")
        raise AssetError(f"{path}: isaac_grasp version {told!r} is not known; {VERSION} is.")
    rows = content.get("grasps")
    if not isinstance(rows, dict) or len(rows) > MOST:
        raise AssetError(f"{path}: 'grasps' must hold up to {MOST} grasps by name.")
    turn = np.eye(3) if jaws == "x" else Rotation.from_euler("z", 90, degrees=True).as_matrix()
    found = [_pose(path, str(name), row, gripper, turn) for name, row in rows.items()]
    return sorted(found, key=lambda g: -g.quality)


def _pose(path: Path, name: str, row: Any, gripper: Gripper, turn: np.ndarray) -> GraspPose:
    try:
        at = np.array([float(v) for v in row["position"]])
        orientation = row["orientation"]
        quaternion = np.array([*(float(v) for v in orientation["xyz"]), float(orientation["w"])])
        confidence = float(row.get("confidence", 1.0))
        opening = _opening(gripper, row.get("pregrasp_cspace_position"))
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
        raise AssetError(
            f"{path}: {name} must have position [x, y, z] and orientation {{w, xyz}} in numbers."
        ) from error
    length = float(np.linalg.norm(quaternion))
    if at.shape != (3,) or quaternion.shape != (4,) or not math.isfinite(at.sum() + length + confidence):
        raise AssetError(f"{path}: {name} must have position [x, y, z] and orientation {{w, xyz}}, finite.")
    if abs(length - 1) > 1e-2:
        raise AssetError(f"{path}: {name} has an orientation of length {length:.3g}; it must be 1.")
    rotation = Rotation.from_quat(quaternion).as_matrix() @ turn
    return GraspPose(at + gripper.flange_to_tcp * rotation[:, 2], rotation, opening, confidence)


def _joints(gripper: Gripper, opening: float) -> dict[str, float]:
    return dict(zip(gripper.finger_joints, _plain(gripper.joints_at(opening / 2)), strict=True))


def _opening(gripper: Gripper, joints: Any) -> float:
    names = gripper.finger_joints
    if not isinstance(joints, dict) or not set(names) <= set(joints):
        return gripper.opening
    told = float(gripper.positions(np.array([float(joints[n]) for n in names])).sum())
    return min(max(told, 1e-3), gripper.opening)


def _plain(values: Any) -> list[float]:
    return [round(float(v), 9) + 0.0 for v in values]
