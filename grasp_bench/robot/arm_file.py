"""``arm.yaml``: what an arm's maker states, and what its model calls its parts."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from grasp_bench.robot.facts import Facts

Degrees = tuple[float, ...]
Speeds = tuple[Annotated[float, Field(gt=0)], ...]


class ArmFile(Facts):
    """The content of ``arm.yaml``; N is the number of joints.

    Attributes:
        title: what the arm is called in reports.
        source: where its numbers are from.
        model: its MJCF, a file of the same folder.
        joints: (N,) from base to flange, names of joints and of their position actuators.
        flange: site on the flange; z points out of it.
        velocity_deg: (N,) greatest speeds [°/s].
        home_deg: (N,) where it waits, outside the camera's view, the tool pointing down [°].
        ready_deg: (N,) elbow up, tool down, ahead of the base: where inverse kinematics starts [°].
    """

    title: str
    source: str = ""
    model: str
    joints: tuple[str, ...]
    flange: str
    velocity_deg: Speeds
    home_deg: Degrees
    ready_deg: Degrees

    @model_validator(mode="after")
    def _as_many(self) -> ArmFile:
        count = len(self.joints)
        if count < 6:
            raise ValueError("joints: an arm needs six or more to reach any grasp")
        for key in ("velocity_deg", "home_deg", "ready_deg"):
            if len(getattr(self, key)) != count:
                raise ValueError(f"{key} must have {count} values, one for each joint")
        return self
