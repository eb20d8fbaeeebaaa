"""The floating gripper in any direction, for reference grasps in six degrees of freedom."""

from __future__ import annotations

import mujoco
import numpy as np

from grasp_bench.grasps import GraspPose
from grasp_bench.robot.gripper import Gripper
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.builder import SceneObject
from grasp_bench.scene.floating import REFERENCE, WRIST, Attempt, FloatingGripper, Routine, compile_floating
from grasp_bench.system.arrays import Floats

HALF_TURN = np.diag([1.0, -1.0, -1.0])
"""Of the flange on the carrier: untilted, the gripper points down."""


class TiltingGripper(FloatingGripper):
    """A floating gripper whose wrist is set to any rotation before a try.

    Args:
        scenario: with the gripper's force and the table.
        model: the object that is grasped.
        gripper: the gripper.
    """

    def __init__(self, scenario: Scenario, model: SceneObject, gripper: Gripper = PARALLEL_85) -> None:
        compiled = compile_floating(scenario, [model], gripper, tilting=True)
        self._wrist = compiled.body(WRIST).id
        super().__init__(compiled, scenario, 1, gripper)

    def tilt(self, rotation: Floats) -> None:
        """Set the rotation (3, 3) of the gripper in the world."""
        wrist = np.ascontiguousarray(rotation @ HALF_TURN.T)
        mujoco.mju_mat2Quat(self.model.body_quat[self._wrist], wrist.ravel())

    def reaches(self, state: tuple[Floats, Floats], pose: GraspPose, back: float = 0.0) -> bool:
        """Return whether nothing is in the open gripper's way where it is ``back`` metres before ``pose``."""
        self.restore(state)
        self.put(self._carrier(pose, back), pose.opening)
        mujoco.mj_forward(self.model, self.data)
        return not self.penetrates()

    def attempt_pose(
        self, state: tuple[Floats, Floats], pose: GraspPose, routine: Routine = REFERENCE
    ) -> Attempt:
        """Try a grasp from a saved state: appear open at ``pose`` in the world, close, lift and shake."""
        self.restore(state)
        return self.grasp(self._carrier(pose), pose.opening, routine)

    def _carrier(self, pose: GraspPose, back: float = 0.0) -> Floats:
        """Turn the wrist as a pose wants it, and return where the carrier must be (4,)."""
        self.tilt(pose.rotation)
        flange = pose.position - (self.gripper.flange_to_tcp + back) * pose.approach
        return np.array([*flange, 0.0])
