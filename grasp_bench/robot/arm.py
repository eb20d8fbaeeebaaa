"""What the package knows of an arm: its folder's facts, and what is measured from its model."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from grasp_bench.robot.arm_file import ArmFile
from grasp_bench.robot.facts import files, folder_of, model_file, read

if TYPE_CHECKING:
    from grasp_bench.robot.arm_shape import ArmShape

if TYPE_CHECKING:  # type checkers do not see that a cached_property meets a property of a frozen class
    from builtins import property as cached_property
else:
    from functools import cached_property


@dataclass(frozen=True)
class Arm:
    """An arm of N joints that stands at the world's origin.

    Attributes:
        name: by which it is found: a shipped arm's name, or a path.
        folder: where its files are.
        facts: the content of its ``arm.yaml``.
        scope: its name in composed models; those of its elements begin with ``scope/``.
    """

    name: str
    folder: Path
    facts: ArmFile
    scope: str = "arm"

    @property
    def path(self) -> Path:
        """The MJCF file."""
        return self.folder / self.facts.model

    @cached_property
    def shape(self) -> ArmShape:
        """What is measured from the compiled model, when first asked for.

        Raises:
            AssetError: for a model that is not one of an arm.
        """
        from grasp_bench.robot.arm_shape import measure

        files(self.folder)
        return measure(model_file(self.folder, self.facts.model), self.facts)

    @property
    def title(self) -> str:
        """What it is called in reports."""
        return self.facts.title

    @property
    def joints(self) -> tuple[str, ...]:
        """(N,) names from base to flange, of joints and of their position actuators."""
        return self.facts.joints

    @property
    def flange(self) -> str:
        """Site on the flange; z points out of it."""
        return self.facts.flange

    @property
    def velocity_limits(self) -> tuple[float, ...]:
        """(N,) greatest speeds [rad/s]."""
        return _radians(self.facts.velocity_deg)

    @property
    def home(self) -> tuple[float, ...]:
        """(N,) where it waits, outside the camera's view, gripper pointing down [rad]."""
        return _radians(self.facts.home_deg)

    @property
    def ready(self) -> tuple[float, ...]:
        """(N,) elbow up, tool down, ahead of the base: where inverse kinematics starts [rad]."""
        return _radians(self.facts.ready_deg)

    @property
    def torque_limits(self) -> tuple[float, ...]:
        """(N,) greatest torques [N m]."""
        return self.shape.torque_limits

    @property
    def position_limits(self) -> tuple[tuple[float, float], ...]:
        """(N, 2) joint ranges, lower and upper [rad]."""
        return self.shape.position_limits


def _radians(degrees: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(math.radians(v) for v in degrees)


@lru_cache
def load_arm(name: str) -> Arm:
    """Load an arm: a shipped one by name, or anyone's by the path of its folder.

    Raises:
        UnknownNameError: for a name that is neither.
        AssetError: for a folder or a file that is not one of an arm.
    """
    folder = folder_of("arm", name)
    return Arm(name, folder, read(folder / "arm.yaml", ArmFile))
