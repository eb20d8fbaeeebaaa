"""The Elite EC66: six joints, 914 mm reach, 6 kg payload.

Velocity, torque and position limits are those of the maker's URDF (github.com/Elite-Robots/ROS,
``ec66_description.urdf``); lengths are of the published DH table.
"""

from __future__ import annotations

import math

from grasp_bench.robot.arm import Arm


def _radians(*degrees: float) -> tuple[float, ...]:
    return tuple(math.radians(v) for v in degrees)


EC66 = Arm(
    name="Elite EC66",
    file="ec66/ec66.xml",
    joints=("joint1", "joint2", "joint3", "joint4", "joint5", "joint6"),
    velocity_limits=_radians(150, 150, 190, 260, 260, 260),
    torque_limits=(150.0, 150.0, 150.0, 28.0, 28.0, 28.0),
    position_limits=tuple((-v, v) for v in _radians(360, 360, 160, 360, 360, 360)),
    home=_radians(0, -125, 95, -60, 90, 0),  # folded upright, gripper 0.38 m above the base
    ready=_radians(0, -95, 100, -95, 90, 0),
    shoulder=0.122,
    flange="flange",
)
"""The benchmark's reference arm."""
