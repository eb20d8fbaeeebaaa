"""What makes a grasp in six degrees of freedom usable: a check that names the usual slips."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from grasp_bench.errors import PredictorError
from grasp_bench.grasps import GraspPose
from grasp_bench.system.arrays import Floats
from grasp_bench.system.texts import shown

FARTHEST = 10.0
"""Greatest distance of a grasp from the camera [m]; beyond it, numbers are taken for millimetres."""
WIDEST_JAWS = 1.0
"""Greatest opening [m]: no gripper here opens a quarter as wide."""
ORTHONORMAL = 1e-3
"""Greatest deviation of a rotation's RᵀR from the identity that is taken for rounding."""
EXACT = 1e-12
"""Deviation below which a rotation is used to the bit."""


def checked_pose(i: int, pose: GraspPose) -> GraspPose:
    """Return the ``i``-th grasp of an answer as plain numbers, its rotation made orthonormal.

    Raises:
        PredictorError: for a pose that is none in front of the camera, in one line that says why.
    """
    position = _numbers(i, pose, "position", (3,))
    rotation = _numbers(i, pose, "rotation", (3, 3))
    opening = float(_numbers(i, pose, "opening", ()))
    quality = float(_numbers(i, pose, "quality", ()))
    if not 0 < opening <= WIDEST_JAWS:
        hint = "; are these millimetres?" if opening > WIDEST_JAWS else ""
        raise PredictorError(
            f"grasp {i} has an opening of {opening:.6g} m; it must be positive, and at most "
            f"{WIDEST_JAWS:g} m{hint}"
        )
    if np.linalg.norm(position) > FARTHEST:
        raise PredictorError(
            f"grasp {i} is {np.linalg.norm(position):.6g} m from the camera; positions are metres: are these "
            "millimetres?"
        )
    if position[2] <= 0:
        raise PredictorError(
            f"grasp {i} at {_vector(position)} m lies behind the camera: positions are in the camera's "
            "frame, x right, y down, z forward (OpenGL's has y up and z backward)"
        )
    return GraspPose(position, _rotation(i, rotation), opening, min(1.0, max(0.0, quality)))


def _numbers(i: int, pose: GraspPose, name: str, shape: tuple[int, ...]) -> Floats:
    value: Any = getattr(pose, name)
    try:
        if isinstance(value, (str, bytes)):
            raise TypeError("text")
        numbers = np.array(value, dtype=np.float64)
    except Exception as error:  # arrays of other libraries raise what they like
        raise PredictorError(f"grasp {i}: its {name} is not made of numbers: {shown(value, 200)}") from error
    if numbers.shape != shape:
        raise PredictorError(f"grasp {i}: its {name} must have the shape {shape}, got {numbers.shape}")
    if not np.isfinite(numbers).all():
        raise PredictorError(f"grasp {i}: its {name} holds NaN or infinity")
    return numbers


def _rotation(i: int, rotation: Floats) -> Floats:
    off = float(np.abs(rotation.T @ rotation - np.eye(3)).max())
    if off > ORTHONORMAL:
        raise PredictorError(
            f"grasp {i}: its rotation is none: RᵀR differs from the identity by {off:.3g}; its columns must "
            "be unit vectors at right angles: x = jaws, y, z = approach"
        )
    if np.linalg.det(rotation) < 0:
        raise PredictorError(f"grasp {i}: its rotation is mirrored (determinant −1): y must be z × x")
    if off < EXACT:
        return rotation
    left, _, right = np.linalg.svd(rotation)
    return left @ right


def _vector(values: Floats) -> str:
    return "(" + ", ".join(f"{v + 0.0:.3f}" for v in values) + ")" if math.isfinite(values.sum()) else "NaN"
