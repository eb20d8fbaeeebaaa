"""An arm with a gripper at its flange."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from grasp_bench.robot.arm import Arm
from grasp_bench.robot.ec66 import EC66
from grasp_bench.robot.gripper import Gripper
from grasp_bench.robot.parallel_85 import PARALLEL_85


@dataclass(frozen=True)
class Robot:
    """What carries out grasps."""

    arm: Arm
    gripper: Gripper

    @property
    def arm_prefix(self) -> str:
        """Prefix of the names of the arm's and the gripper's elements in composed models."""
        return f"{self.arm.scope}/"

    @property
    def gripper_prefix(self) -> str:
        """Prefix of the names of the gripper's elements in composed models."""
        return f"{self.arm.scope}/{self.gripper.scope}/"

    @property
    def files(self) -> list[Path]:
        """All files that its models are made of, sorted."""
        folders = {self.arm.path.parent, self.gripper.path.parent}
        return sorted(path for folder in folders for path in folder.rglob("*") if path.is_file())


EC66_PARALLEL_85 = Robot(EC66, PARALLEL_85)
"""The robot of the benchmark's definition, and of all that is not given another."""
