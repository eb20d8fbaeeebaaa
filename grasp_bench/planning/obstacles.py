"""Whether hand and arm keep clear of the table, of each other and of what the camera saw.

Solid geoms count as the boxes around them, and seen points as points: so many must lie inside one that they
are no stray readings. Nothing here knows what the camera did not see.
"""

from __future__ import annotations

from functools import lru_cache

import mujoco
import numpy as np

from grasp_bench.camera import CameraPose, Intrinsics
from grasp_bench.grasps import GraspPose
from grasp_bench.planning.seen import STRAYS, STRAYS_UNDER_HAND
from grasp_bench.robot.robot import Robot
from grasp_bench.robot.solids import subtree
from grasp_bench.system.arrays import Floats

HAND = "hand/"
TABLE = "table"
DEEP = 5e-4
"""Solids are in each other's way when they overlap by more than this [m]."""
EVERY = 4
"""One of so many seen points is held against the arm's links, which are large."""


@lru_cache
def solid_model(robot: Robot) -> mujoco.MjModel:
    """Compile arm, gripper and table with all that is solid and nothing else; everything collides."""
    arm, hand = (mujoco.MjSpec.from_file(str(part.path)) for part in (robot.arm, robot.gripper))
    for spec in (arm, hand):
        for unseen in [g for g in spec.geoms if not (g.contype or g.conaffinity)]:
            spec.delete(unseen)
        solid = {g.meshname for g in spec.geoms}
        for unseen in [m for m in spec.meshes if m.name not in solid]:
            spec.delete(unseen)
        for geom in spec.geoms:
            geom.contype = geom.conaffinity = 1
        for key in list(spec.keys):
            spec.delete(key)
    for name in ("timestep", "integrator", "solver", "jacobian", "cone", "impratio", "noslip_iterations"):
        setattr(hand.option, name, getattr(arm.option, name))
    arm.attach(hand, prefix=HAND, site=arm.site(robot.arm.flange))
    arm.worldbody.add_geom(
        name=TABLE, type=mujoco.mjtGeom.mjGEOM_PLANE, size=[3, 3, 0.1], contype=1, conaffinity=1
    )
    return arm.compile()


class Obstacles:
    """What a robot may be in the way of; holds a model of its solids, and no state of a trial."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.model = model = solid_model(robot)
        self.data = mujoco.MjData(model)
        gripper = robot.gripper
        self._arm = np.array([model.joint(n).qposadr[0] for n in robot.arm.joints])
        self._fingers = np.array([model.joint(HAND + n).qposadr[0] for n in gripper.finger_joints])
        self._tcp = model.site(HAND + gripper.tcp).id
        bodies = model.geom_bodyid
        names = [model.body(i).name for i in bodies]
        self._of_hand = np.array([n.startswith(HAND) for n in names])
        fingers = [np.isin(bodies, subtree(model, model.body(HAND + f).id)) for f in gripper.fingers]
        self._parts = [*fingers, self._of_hand & ~fingers[0] & ~fingers[1]]
        moved = {int(model.jnt_bodyid[model.joint(n).id]) for n in robot.arm.joints[:2]}
        below = subtree(model, max(moved))  # what is before the second joint never meets anything
        self._links = np.flatnonzero(np.isin(bodies, below) & ~self._of_hand)
        self._usual: set[tuple[int, int]] = set()
        for q in (robot.arm.home, robot.arm.ready):
            self._usual |= self._overlaps(np.asarray(q), gripper.opening)

    # ------------------------------------------------------------ the hand alone

    def hand(self, points: Floats, pose: GraspPose, retreat: float) -> str:
        """Return what the open hand meets on its straight way to a grasp, empty where that is nothing.

        Args:
            points: (N, 3) seen points that stand on the table, in the world [m].
            pose: the grasp, whose opening counts.
            retreat: how far before the grasp the way begins [m].
        """
        low, high = self._boxes(pose.opening)
        corners = np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, 8).T
        at = np.where(corners, high[:, None], low[:, None]) @ pose.rotation[2] + pose.position[2]
        deepest = float(min(at.min(), at.min() - retreat * pose.approach[2]))
        if deepest < 0:
            return f"the table, {_mm(-deepest)} mm under whose top it would be"
        local = (points - pose.position) @ pose.rotation
        inside = (
            ((local[:, None, :2] > low[:, :2]) & (local[:, None, :2] < high[:, :2])).all(2)
            & (local[:, None, 2] > low[:, 2] - retreat)
            & (local[:, None, 2] < high[:, 2])
        )
        for part, least in zip(self._parts, (STRAYS, STRAYS, STRAYS_UNDER_HAND), strict=True):
            met = inside[:, part[self._of_hand]].any(1)
            if met.sum() >= least:
                where = local[met, 2]
                what = "the hand" if part is self._parts[2] else "a finger"
                return (
                    f"what was seen {_mm(abs(float(np.median(where))))} mm from the grasp, which {what} meets"
                )
        return ""

    def drop(self, pose: GraspPose) -> float:
        """Return how far the open hand reaches below the TCP of a pose [m]."""
        low, high = self._boxes(pose.opening)
        down = -pose.rotation[2]
        return float(np.maximum(low * down, high * down).sum(1).max())

    def _boxes(self, opening: float) -> tuple[Floats, Floats]:
        """Return the corners (G, 3) of boxes around the hand's geoms, square to the TCP's frame."""
        self._put(np.asarray(self.robot.arm.home), opening)
        model, data = self.model, self.data
        mujoco.mj_kinematics(model, data)
        frame = data.site_xmat[self._tcp].reshape(3, 3)
        chosen = np.flatnonzero(self._of_hand)
        turns = frame.T @ data.geom_xmat[chosen].reshape(-1, 3, 3)
        centres = (data.geom_xpos[chosen] - data.site_xpos[self._tcp]) @ frame
        centres += np.einsum("gij,gj->gi", turns, model.geom_aabb[chosen, :3])
        half = np.einsum("gij,gj->gi", np.abs(turns), model.geom_aabb[chosen, 3:])
        return centres - half, centres + half

    # ------------------------------------------------------------ the whole arm

    def arm(self, points: Floats, q: Floats, opening: float) -> str:
        """Return what the robot meets at joint angles ``q`` (N,), empty where that is nothing.

        Of the hand only what it does to table and arm counts; see :meth:`hand` for what was seen.
        """
        for first, second in sorted(self._overlaps(q, opening) - self._usual):
            names = [self.model.body(b).name.removeprefix(HAND) for b in (first, second)]
            return f"the table with {names[1]}" if first == 0 else f"itself, {names[0]} and {names[1]}"
        data, chosen = self.data, self._links
        turns = data.geom_xmat[chosen].reshape(-1, 3, 3)
        boxes = self.model.geom_aabb[chosen]
        centres = data.geom_xpos[chosen] + np.einsum("gij,gj->gi", turns, boxes[:, :3])
        few = points[::EVERY]
        near = few[(few[:, 2] > (centres[:, 2] - np.linalg.norm(boxes[:, 3:], axis=1)).min())]
        for turn, centre, half in zip(turns, centres, boxes[:, 3:], strict=True):
            if ((np.abs((near - centre) @ turn) < half).all(1)).sum() >= STRAYS_UNDER_HAND / EVERY:
                return "what was seen with its arm"
        return ""

    def in_view(self, q: Floats, camera: CameraPose, intrinsics: Intrinsics) -> bool:
        """Return whether a camera sees the arm's links at joint angles ``q`` (N,), the hand aside."""
        self._put(q, self.robot.gripper.opening)
        mujoco.mj_kinematics(self.model, self.data)
        corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
        boxes = self.model.geom_aabb[self._links]
        places = boxes[:, None, :3] + corners * boxes[:, None, 3:]
        turns = self.data.geom_xmat[self._links].reshape(-1, 3, 3)
        world = np.einsum("gij,gkj->gki", turns, places) + self.data.geom_xpos[self._links][:, None]
        seen = camera.to_camera(world).reshape(-1, 3)
        u, v = intrinsics.project(seen[seen[:, 2] > 0.01]).T
        return bool(((u > 0) & (u < intrinsics.width) & (v > 0) & (v < intrinsics.height)).any())

    def _overlaps(self, q: Floats, opening: float) -> set[tuple[int, int]]:
        """Return the pairs of bodies that overlap, the lower number first; 0 is the table."""
        self._put(q, opening)
        mujoco.mj_fwdPosition(self.model, self.data)
        contact = self.data.contact
        pairs = np.sort(self.model.geom_bodyid[contact.geom[contact.dist < -DEEP]], axis=1)
        return {(int(a), int(b)) for a, b in pairs if not (self._in_hand(a) and self._in_hand(b))}

    def _in_hand(self, body: int) -> bool:
        return self.model.body(int(body)).name.startswith(HAND)

    def _put(self, q: Floats, opening: float) -> None:
        self.data.qpos[self._arm] = q
        self.data.qpos[self._fingers] = self.robot.gripper.joints_at(opening / 2)


def _mm(metres: float) -> int:
    return round(1000 * metres)
