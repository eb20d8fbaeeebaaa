"""A plain parallel gripper of 85 mm stroke and 1 kg, a design of our own; its facts are in its folder.

Its dimensions are drawn in :mod:`grasp_bench.workshop.gripper_meshes`.
"""

from __future__ import annotations

from grasp_bench.robot.grippers import load_gripper

PARALLEL_85 = load_gripper("parallel-85")
"""The benchmark's reference gripper."""
