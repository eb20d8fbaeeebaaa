"""The usual slips of frames and units in grasps of six degrees of freedom, told from one sure scene.

Each slip is a hypothesis: where would the grasp be, had this been mixed up? One that brings a grasp that is
nowhere near the object onto it is named.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from grasp_bench.camera import CameraPose
from grasp_bench.grasps import GraspPose
from grasp_bench.system.arrays import Floats

Slip = tuple[Literal["failure", "remark"], str]

NEAR = 0.025
"""A TCP this near to the object's seen points is at the object [m]."""
BEHIND = np.arange(0.04, 0.241, 0.005)
"""How far behind the finger tips the origins of hands and flanges lie [m]."""
ALONG = 0.7
"""Cosine from which two directions count as one."""
OPENGL = np.diag([1.0, -1.0, -1.0])


def slips(pose: GraspPose, points: Floats, camera: CameraPose) -> list[Slip]:
    """Return what is odd about the best grasp on the only object in a picture.

    Args:
        pose: in the camera's frame.
        points: (N, 3) what was seen of the object, in the camera's frame [m].
        camera: where the camera stands above the table.
    """
    down = camera.rotation.T @ [0.0, 0.0, -1.0]
    x, y, z = (float(axis @ down) for axis in pose.rotation.T)
    place = _place(pose, points, camera)
    found: list[Slip] = [place] if place else []
    if z > -0.3 and max(z, abs(x), abs(y)) == z:
        return found
    if z < -ALONG:
        found.append(
            ("failure", "the approach points away from the object: z runs from the hand to what is held")
        )
    elif x > ALONG:
        found.append(
            ("failure", "the approach seems to run along x (GraspNet's axes): z is the approach, x the jaws")
        )
    elif max(abs(x), abs(y)) > ALONG:
        axis = "x" if abs(x) > abs(y) else "y"
        found.append(
            ("remark", f"the approach runs along the table, and {axis} up or down: is z the approach?")
        )
    return found


def _place(pose: GraspPose, points: Floats, camera: CameraPose) -> Slip | None:
    if _gap(pose.position, points) <= NEAR:
        return None
    for what, there in (("world's", camera.to_camera(pose.position)), ("OpenGL's", OPENGL @ pose.position)):
        if _gap(there, points) <= NEAR:
            if what == "world's":
                return "failure", "the position is right in the world's frame: poses are in the camera's"
            return (
                "failure",
                "the position is right with OpenGL's axes: the camera's y is down, its z forward",
            )
    for axis, name in ((2, "z"), (0, "x")):
        gaps = [_gap(pose.position + d * pose.rotation[:, axis], points) for d in BEHIND]
        if min(gaps) <= NEAR:
            behind = BEHIND[int(np.argmin(gaps))]
            return "failure", (
                f"the position is about {1000 * behind:.0f} mm behind the object along {name}, as if it were "
                "that of the hand or flange: it is the TCP's, midway between the ends of the finger tips"
            )
    return "remark", f"the best grasp is {1000 * _gap(pose.position, points):.0f} mm from the only object"


def _gap(place: Floats, points: Floats) -> float:
    return float(np.linalg.norm(points - place, axis=1).min())
