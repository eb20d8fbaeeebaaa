"""The section of a scenario that says where its cameras are."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from grasp_bench.camera import CameraPose, Intrinsics
from grasp_bench.scenario.fields import Section, Vector


class Viewpoint(Section):
    """Where another fixed camera of the same kind stands."""

    position: Vector
    target: Vector = (0.5, 0.0, 0.0)
    image_up: Vector = (1.0, 0.0, 0.0)

    @property
    def pose(self) -> CameraPose:
        """Pose in the world."""
        return CameraPose.look_at(self.position, self.target, self.image_up)


class Camera(Section):
    """A pinhole camera, fixed beside the table or on the arm's wrist.

    Attributes:
        mount: ``fixed``, or ``wrist``: the arm brings the camera to where it is to see from, and it is the
            transform between hand and eye that the calibration's error is of.
        views: pictures that a wrist camera takes, the first from ``position``, others from a dome about
            ``target``.
        dome_deg: how far the others stand from the vertical.
        hand_eye: optical centre of a wrist camera in the flange's frame, whose axes are the camera's [m].
        more: other fixed cameras, with errors of calibration of their own.
    """

    mount: Literal["fixed", "wrist"] = "fixed"
    views: Annotated[int, Field(ge=1, le=8)] = 1
    dome_deg: Annotated[float, Field(gt=0, lt=80)] = 20.0
    hand_eye: Vector = (0.0, -0.075, 0.02)
    more: Annotated[tuple[Viewpoint, ...], Field(max_length=7)] = ()

    width: Annotated[int, Field(ge=64, le=4096)] = 640
    height: Annotated[int, Field(ge=64, le=4096)] = 480
    horizontal_fov_deg: Annotated[float, Field(gt=5, lt=170)] = 90.0
    position: Vector = (0.5, 0.0, 0.55)
    target: Vector = (0.5, 0.0, 0.0)
    image_up: Vector = (1.0, 0.0, 0.0)

    @property
    def intrinsics(self) -> Intrinsics:
        """Pinhole intrinsics."""
        return Intrinsics.from_fov(self.width, self.height, math.radians(self.horizontal_fov_deg))

    @property
    def pose(self) -> CameraPose:
        """Pose in the world; of a wrist camera that of its first view."""
        return CameraPose.look_at(self.position, self.target, self.image_up)

    @property
    def dome(self) -> list[CameraPose]:
        """Poses of all views of a wrist camera."""
        target, tilt = np.array(self.target), math.radians(self.dome_deg)
        radius = float(np.linalg.norm(np.array(self.position) - target))
        poses = [self.pose]
        for i in range(self.views - 1):
            around = 2 * math.pi * (i + 0.5) / (self.views - 1)
            way = [math.sin(tilt) * math.cos(around), math.sin(tilt) * math.sin(around), math.cos(tilt)]
            poses.append(CameraPose.look_at(target + radius * np.array(way), target, self.image_up))
        return poses

    @model_validator(mode="after")
    def _either(self) -> Camera:
        if self.mount == "fixed" and self.views > 1:
            raise ValueError("camera.views is for camera.mount: wrist; name other fixed ones in camera.more")
        if self.mount == "wrist" and self.more:
            raise ValueError("camera.more is for camera.mount: fixed; a wrist camera has camera.views")
        return self
