"""Constants of the Elite EC66 arm and the benchmark's parallel gripper, for planning.

SI units and radians. Velocity, torque and position limits are those of the maker's URDF
(github.com/Elite-Robots/ROS, ``ec66_description.urdf``).
"""

from __future__ import annotations

import math

JOINT_NAMES = ("joint1", "joint2", "joint3", "joint4", "joint5", "joint6")
"""Joints from base to flange; the position actuators carry the same names."""

VELOCITY_LIMITS = tuple(math.radians(v) for v in (150.0, 150.0, 190.0, 260.0, 260.0, 260.0))
"""Greatest joint speeds (rad/s)."""

TORQUE_LIMITS = (150.0, 150.0, 150.0, 28.0, 28.0, 28.0)
"""Greatest joint torques (N m), equal to the actuators' force ranges."""

POSITION_LIMITS = tuple(
    (-math.radians(v), math.radians(v)) for v in (360.0, 360.0, 160.0, 360.0, 360.0, 360.0)
)
"""Joint ranges (rad), lower and upper."""

HOME = tuple(math.radians(v) for v in (0.0, -125.0, 95.0, -60.0, 90.0, 0.0))
"""Folded upright, gripper pointing down 0.38 m above the base, outside the camera's view (rad).

Keyframe ``home`` of ``ec66.xml`` holds the same values.
"""

FLANGE_TO_TCP = 0.165
"""Distance from the flange to the point between the finger tips, along the approach (m)."""

FINGER_STROKE = 0.0425
"""Travel of one finger (m); the jaws open to twice that."""
