"""A plain parallel gripper of 85 mm stroke and 1 kg, a design of our own.

Its dimensions are drawn in :mod:`grasp_bench.workshop.gripper_meshes`; force and opening are those of common
electric grippers of this size, 20 to 235 N and 85 mm.
"""

from __future__ import annotations

from grasp_bench.robot.gripper import Gripper

PARALLEL_85 = Gripper(
    name="parallel gripper, 85 mm",
    file="ec66/gripper.xml",
    stroke=0.0425,
    finger_thickness=0.008,
    finger_width=0.020,
    finger_length=0.065,
    pad=(0.003, 0.020, 0.024),
    palm=(0.132, 0.050),
    flange_to_tcp=0.165,
    force=(20.0, 235.0),
    force_ratio=2.0,  # the actuator's tendon averages both finger positions: each finger gets half its force
    speed=0.15,
    squeeze=0.03,
    actuator="gripper",
    finger_joints=("left_finger_joint", "right_finger_joint"),
    fingers=("left_finger", "right_finger"),
    pads=("left_pad", "right_pad"),
    palm_body="gripper",
    tcp="tcp",
)
"""The benchmark's reference gripper."""
