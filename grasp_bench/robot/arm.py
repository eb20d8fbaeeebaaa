"""What the package knows of an arm; it is written nowhere else.

An arm is a file of this room with one :class:`Arm` in it; ``tests/robot/test_facts.py`` holds it against its
model. Its joints, in order from the base, are moved by position actuators of the same names.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from grasp_bench.system.paths import assets_dir


@dataclass(frozen=True, kw_only=True)
class Arm:
    """An arm of N joints that stands at the world's origin.

    Attributes:
        name: what the arm is called in reports.
        file: MJCF file below the assets folder.
        scope: its name in composed models; those of its elements begin with ``scope/``.
        joints: (N,) names from base to flange, of joints and of their position actuators.
        velocity_limits: (N,) greatest speeds [rad/s].
        torque_limits: (N,) greatest torques, equal to the actuators' force ranges [N m].
        position_limits: (N, 2) joint ranges, lower and upper [rad].
        home: (N,) where it waits, outside the camera's view, gripper pointing down; keyframe ``home`` of its
            file [rad].
        ready: (N,) elbow up, tool down, above the middle of the table: where inverse kinematics starts [rad].
        shoulder: distance by which the plane of upper arm and forearm passes the base's axis [m].
        flange: site on the flange; z points out of it.
    """

    name: str
    file: str
    scope: str = "arm"
    joints: tuple[str, ...]
    velocity_limits: tuple[float, ...]
    torque_limits: tuple[float, ...]
    position_limits: tuple[tuple[float, float], ...]
    home: tuple[float, ...]
    ready: tuple[float, ...]
    shoulder: float
    flange: str

    @property
    def path(self) -> Path:
        """The MJCF file; its meshes are in the folder ``meshes`` beside it."""
        return assets_dir() / self.file
