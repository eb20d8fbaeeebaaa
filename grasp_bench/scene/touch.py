"""What objects and robot touch, and how hard."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from grasp_bench.robot.robot import Robot
from grasp_bench.robot.solids import subtree
from grasp_bench.scene.builder import GROUND
from grasp_bench.scene.contacts import touching


@dataclass(frozen=True)
class Touch:
    """What the object touches.

    Attributes:
        left, right: summed normal force of each finger [N]; 0 where there is no contact.
        elsewhere: names of what else it touches; the palm between the fingers does not count.
    """

    left: float
    right: float
    elsewhere: tuple[str, ...]

    @property
    def held(self) -> bool:
        """Both fingers press on the object.

        The judge wants a positive normal force: a contact alone may carry none, as when the object is about
        to leave a pad. The floating gripper, which decides more coarsely, is content with the contact.
        """
        return self.left > 0 and self.right > 0


class Feeling:
    """Reads the forces of contacts in a compiled scene.

    Args:
        model: compiled by :func:`grasp_bench.scene.builder.compile_scene`.
        robot: the one that the model was compiled with.
        bodies: ids of the objects' bodies.
    """

    def __init__(self, model: mujoco.MjModel, robot: Robot, bodies: Sequence[int]) -> None:
        self._model, self._bodies, self._prefix = model, list(bodies), robot.arm_prefix
        owner, names = model.geom_bodyid, [model.body(i).name for i in model.geom_bodyid]
        self._is_object = {body: owner == body for body in bodies}
        self._is_any_object = np.isin(owner, self._bodies)
        self._is_left, self._is_right = (
            np.isin(owner, subtree(model, model.body(robot.gripper_prefix + f).id))
            for f in robot.gripper.fingers
        )
        is_hand = np.array([n.startswith(robot.gripper_prefix) for n in names])
        self._is_palm = is_hand & ~(self._is_left | self._is_right)
        self._is_robot = np.array([n.startswith(robot.arm_prefix) for n in names])
        self._is_table = np.array([model.geom(i).name == GROUND for i in range(model.ngeom)])

    def touch(self, data: mujoco.MjData, body: int, rise: Callable[[int | None], float]) -> Touch:
        """Return what an object touches now, and how hard.

        Args:
            body: the object's.
            rise: tells how far an object, by its number, or the one asked for (None) has been lifted [m]:
                what was lifted with it does not count as touched.
        """
        force = np.zeros(6)
        left = right = 0.0
        elsewhere: set[str] = set()
        is_object = self._is_object[body]
        for i in touching(data, is_object):
            first, second = data.contact.geom[i]
            other = second if is_object[first] else first
            mujoco.mj_contactForce(self._model, data, int(i), force)
            if force[0] <= 0:
                continue
            if self._is_left[other] or self._is_right[other]:  # a cup is both
                left += force[0] * self._is_left[other]
                right += force[0] * self._is_right[other]
            elif self._is_any_object[other]:
                if rise(self._bodies.index(self._model.geom_bodyid[other])) < rise(None) / 2:
                    elsewhere.add("another object")
            elif not self._is_palm[other]:
                name = self._model.geom(int(other)).name
                elsewhere.add("table" if name == GROUND else name.removeprefix(self._prefix))
        return Touch(left, right, tuple(sorted(elsewhere)))

    def collision(self, data: mujoco.MjData) -> tuple[float, str]:
        """Return the greatest normal force [N] of the robot against an object or the table, and which."""
        force = np.zeros(6)
        worst, name = 0.0, ""
        for i in touching(data, self._is_robot, self._is_any_object | self._is_table):
            mujoco.mj_contactForce(self._model, data, int(i), force)
            if force[0] > worst:
                worst = float(force[0])
                name = "object" if self._is_any_object[data.contact.geom[i]].any() else "table"
        return worst, name
