"""An arm with a gripper at its flange."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from grasp_bench.robot.arm import Arm, load_arm
from grasp_bench.robot.ec66 import EC66
from grasp_bench.robot.facts import digest, files
from grasp_bench.robot.gripper import Gripper
from grasp_bench.robot.grippers import load_gripper
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
    def described(self) -> dict[str, dict[str, str]]:
        """Names and digests of both parts, for records."""
        return {
            kind: {"name": part.name, "digest": digest(part.folder)}
            for kind, part in (("arm", self.arm), ("gripper", self.gripper))
        }

    @property
    def files(self) -> list[Path]:
        """All files that its models are made of, sorted."""
        return sorted(path for folder in {self.arm.folder, self.gripper.folder} for path in files(folder))


EC66_PARALLEL_85 = Robot(EC66, PARALLEL_85)
"""The robot of the benchmark's definition, and of all that is not given another."""


def load_robot(arm: str, gripper: str) -> Robot:
    """Load an arm and a gripper by name or path; see :func:`load_arm` and :func:`load_gripper`."""
    return Robot(load_arm(arm), load_gripper(gripper))
