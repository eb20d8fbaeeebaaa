"""From a grasp in the image to a motion of the arm.

Nothing here knows the simulator: the planner sees what the camera saw, and the arm's
kinematics. Its policy for the depth of a grasp is part of the benchmark's definition.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import cv2
import numpy as np
from numpy.typing import NDArray

from grasp_bench.camera import CameraPose, RgbdImage
from grasp_bench.grasps import Grasp, GraspPose
from grasp_bench.planning.heightfield import FINGER, LEAST_INSERTION, TABLE_NOISE
from grasp_bench.robot.ec66 import FINGER_STROKE, HOME, VELOCITY_LIMITS
from grasp_bench.robot.kinematics import InverseKinematics
from grasp_bench.robot.shake import amplitude, shaken
from grasp_bench.robot.trajectory import Trajectory, through
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.sections import Motion, Scenario, Table

Floats = NDArray[np.float64]

JAW = 0.020
"""Width of a finger across the jaw direction [m]."""
PALM = (0.132, 0.050)
"""Extent of the hand's underside along and across the jaw direction [m]."""
FINGER_LENGTH = 0.065
"""From the tips up to the hand's underside [m]."""
SIDE_CLEARANCE = 0.004
"""Room that a finger or the hand on its way down wants beside it [m]."""
STRAYS = 3
"""So many points are a thing and not noise; of a thin rod under a finger's corner no more may be seen."""
STRAYS_UNDER_HAND = 20
"""The same for the hand, under which some 3,000 pixels see."""
WIDENING_STEP = 0.004
WIDENING_GAIN = 0.004
"""The jaws are opened wider than predicted until the tips come this near to the wanted depth [m]."""
WAYPOINT = 0.025
"""Spacing of waypoints on straight lines [m]."""


class Refused(Exception):
    """A grasp that cannot be planned, and the outcome of a trial that has no other."""

    outcome: ClassVar[Outcome]


class Unreachable(Refused):
    """The arm cannot carry out a grasp."""

    outcome = Outcome.IK_FAILED


class Blocked(Refused):
    """The fingers cannot get down to a grasp."""

    outcome = Outcome.APPROACH_COLLISION


@dataclass(frozen=True)
class Plan:
    """A grasp turned into motions.

    Attributes:
        grasp: the image-plane grasp planned for.
        pose: TCP pose at the grasp.
        top: height of what is grasped, above the table [m].
        shortfall: how far above their wanted depth the tips are kept by what is seen under them [m].
        reach: from home to above the grasp.
        approach, lift: straight down and up.
        carry: to the place of the hold.
        shake: bursts along the axes of the TCP, between lift and carry; empty where there are none.
    """

    grasp: Grasp
    pose: GraspPose
    top: float
    shortfall: float
    reach: Trajectory
    approach: Trajectory
    lift: Trajectory
    carry: Trajectory
    shake: tuple[Trajectory, ...] = ()

    @property
    def deep(self) -> bool:
        """Whether the tips get down to the wanted depth, or so near that no wider opening was tried."""
        return self.shortfall <= WIDENING_GAIN + 1e-6


class SeenScene:
    """What a depth image shows of the heights on the table.

    Args:
        image: RGB-D image.
        camera: pose of the camera that took it.
        directions: (H, W, 3) world directions of the pixels' rays, where they are at hand.
    """

    def __init__(self, image: RgbdImage, camera: CameraPose, directions: Floats | None = None) -> None:
        self.image, self.camera = image, camera
        self._rays = image.intrinsics.rays() @ camera.rotation.T if directions is None else directions
        self.heights = camera.position[2] + image.depth * self._rays[..., 2]
        self.heights[~image.valid] = np.nan

    def highest(self, table: Table) -> float:
        """Height of the highest thing seen on the table, robust against single pixels [m].

        What is seen beside the table top, such as the arm's own base, is not in the way.
        """
        tall = self.heights > TABLE_NOISE
        places = self.camera.position[:2] + self._rays[tall][:, :2] * self.image.depth[tall][:, None]
        seen = self.heights[tall][(np.abs(places - table.center) <= np.array(table.size) / 2).all(1)]
        return max(highest(seen, STRAYS_UNDER_HAND), 0.0)

    def on_plane(self, pixel: Floats, height: float) -> Floats:
        """World point where the ray through ``pixel`` (2,) meets the plane z = ``height``."""
        ray = self.camera.rotation @ self.image.intrinsics.deproject(pixel, np.ones(()))
        if ray[2] > -1e-6:
            raise Blocked(f"the ray through pixel ({pixel[0]:.0f}, {pixel[1]:.0f}) does not meet the table")
        return self.camera.position + ray * (height - self.camera.position[2]) / ray[2]

    def _depth_of_table(self, grasp: Grasp) -> float:
        """Depth at which the ray through a grasp's centre meets the table [m]; seen from above, the
        camera's height."""
        ray = self.camera.rotation[2] @ self.image.intrinsics.deproject([grasp.x, grasp.y], np.ones(()))
        return float(self.camera.position[2] / max(-ray, 0.1))

    def heights_in(self, grasp: Grasp) -> Floats:
        """Heights [m] of the points seen inside the grasp's rectangle, jaws 16 mm wide."""
        across = 0.8 * JAW * self.image.intrinsics.fx / max(self._depth_of_table(grasp) - 0.03, 0.1)
        inside_image = min(grasp.width, 2.0 * sum(self.heights.shape))  # of absurd widths, no more is in view
        corners = np.round(replace(grasp, width=inside_image).rectangle(height=across) - 0.5).astype(np.int32)
        window = self._window(corners.min(0), corners.max(0) + 1)
        heights = self.heights[window]
        mask = np.zeros(heights.shape, np.uint8)
        if mask.size:
            cv2.fillPoly(mask, [corners - [window[1].start, window[0].start]], (1,))
        inside = heights[mask > 0]
        return inside[np.isfinite(inside)]

    def local(self, centre: Floats, axis: Floats, reach: float = 0.08) -> tuple[Floats, Floats]:
        """Points within ``reach`` of ``centre`` as (N, 2) offsets along and across ``axis``, and
        their heights (N,)."""
        low = max(float(centre[2]) - 0.15, 0.0)
        corners = centre[:2] + reach * np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]])
        cloud = np.array([[*c, z] for c in corners for z in (low, float(centre[2]) + 0.05)])
        pixels = self.image.intrinsics.project(self.camera.to_camera(cloud))
        window = self._window(np.floor(pixels.min(0)).astype(int), np.ceil(pixels.max(0)).astype(int))
        heights = self.heights[window].ravel()
        points = self.camera.position[:2] + (
            self._rays[window][..., :2] * self.image.depth[window][..., None]
        ).reshape(-1, 2)
        offset = points - centre[:2]
        near = np.isfinite(heights) & (np.abs(offset).max(1) < reach)
        across = np.array([-axis[1], axis[0]])
        return np.column_stack([offset[near] @ axis[:2], offset[near] @ across]), heights[near]

    def _window(self, low: NDArray[np.intp], high: NDArray[np.intp]) -> tuple[slice, slice]:
        """Rows and columns between two pixels, clipped to the image."""
        h, w = self.heights.shape
        (left, top), (right, bottom) = np.clip([low, high], 0, [w, h])
        return slice(int(top), int(bottom)), slice(int(left), int(right))


def grasp_pose(scene: SeenScene, grasp: Grasp, motion: Motion) -> tuple[GraspPose, float]:
    """World pose of an image-plane grasp, and the height of what it holds [m].

    The height of the object under the grasp is the 95th percentile of the heights seen
    inside the grasp's rectangle, the plane on which its centre and ends are deprojected. The
    tips go ``motion.insertion`` below it, never nearer to the table than
    ``motion.table_clearance``, and never so deep that the hand would meet what is seen under it, or the open
    fingers what is under them; where the latter would keep them up, the jaws are opened wider than predicted.

    Raises:
        Blocked: where nothing was measured, or the fingers cannot get below the top of it.
    """
    heights = scene.heights_in(grasp)
    if len(heights) < 4:
        raise Blocked("no depth was measured inside the grasp")
    top = float(np.percentile(heights, 95))
    empty = top < TABLE_NOISE  # nothing but table: carried out all the same, to close on nothing
    top = 0.0 if empty else top
    centre = scene.on_plane(np.array([grasp.x, grasp.y]), top)
    first, second = (scene.on_plane(end, top) for end in grasp.ends())
    span = second - first
    axis = span / max(float(np.linalg.norm(span)), 1e-9)
    wanted = wanted_tip(top, motion)
    offset, height = scene.local(centre, axis)
    under_hand = (np.abs(offset) < np.array(PALM) / 2 + SIDE_CLEARANCE).all(1)
    obstacle = highest(height[under_hand], STRAYS_UNDER_HAND)
    floor = max(wanted, obstacle - FINGER_LENGTH + motion.table_clearance)
    under_jaws = np.abs(offset[:, 1]) < JAW / 2 + SIDE_CLEARANCE
    along, height = offset[under_jaws, 0], height[under_jaws]
    tip, opening = np.inf, 0.0
    for trial in openings(float(np.linalg.norm(span[:2]))):
        lowest = max(
            floor,
            *(ground_under(side * along - trial / 2, height) + motion.table_clearance for side in (-1, 1)),
        )
        if lowest < tip - 1e-6:
            tip, opening = lowest, trial
        if tip <= floor + WIDENING_GAIN:
            break
    if top - tip < LEAST_INSERTION and not empty:
        raise Blocked(f"the fingers reach only {1000 * (top - tip):.1f} mm below the top of the object")
    yaw = math.atan2(axis[1], axis[0])
    return GraspPose.top_down([centre[0], centre[1], tip], yaw, opening), top


def wanted_tip(top: float, motion: Motion) -> float:
    """Height at which the tips hold best what is ``top`` high [m]."""
    return max(top - motion.insertion, motion.table_clearance)


def openings(predicted: float) -> list[float]:
    """Openings to try [m]: the predicted one, then wider ones up to the gripper's stroke."""
    most = 2 * FINGER_STROKE
    first = min(predicted, most)
    return [first, *np.arange(first + WIDENING_STEP, most, WIDENING_STEP).tolist(), most]


def ground_under(beyond: Floats, height: Floats) -> float:
    """Height [m] of what is seen under one open finger, −inf where that is table or nothing.

    Args:
        beyond: (N,) distance of the seen points outwards from the finger's pad [m].
        height: (N,) their heights [m].
    """
    ground = highest(height[(beyond > -SIDE_CLEARANCE) & (beyond < FINGER)])
    return ground if ground > TABLE_NOISE else -np.inf


def highest(heights: Floats, strays: int = STRAYS) -> float:
    """Height of the highest thing among seen points (N,) [m], −inf where there are fewer than ``strays``."""
    return float(np.partition(heights, -strays)[-strays]) if len(heights) >= strays else -np.inf


def straight(start: Floats, end: Floats) -> list[Floats]:
    """Points on a line every :data:`WAYPOINT`, without the start."""
    count = max(1, int(np.ceil(np.linalg.norm(end - start) / WAYPOINT)))
    return [start + (end - start) * i / count for i in range(1, count + 1)]


class Planner:
    """Plans motions for grasps; keeps the IK solver between trials."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.ik = InverseKinematics()

    def plan(self, scene: SeenScene, grasp: Grasp) -> Plan:
        """Motion for one grasp.

        Raises:
            Blocked: when the fingers cannot get down to it.
            Unreachable: when the arm cannot carry it out.
        """
        motion = self.scenario.motion
        pose, top = grasp_pose(scene, grasp, motion)
        period = self.scenario.physics.timestep * self.scenario.physics.control_steps
        above = max(pose.position[2] + motion.approach_height, scene.highest(self.scenario.table) + 0.03)
        raised = np.array([*pose.position[:2], above])
        lifted = pose.position + [0, 0, motion.lift_height]
        target = np.array([*motion.carry_to[:2], lifted[2] + motion.carry_to[2]])
        for candidate, q in self.ik.solve_grasp(pose):

            def chain(
                start: Floats, end: Floats, from_q: Floats, rotation: Floats = candidate.rotation
            ) -> list[Floats] | None:
                return self.ik.follow([GraspPose(p, rotation, 0.0) for p in straight(start, end)], from_q)

            up = chain(pose.position, raised, q)
            lift = chain(pose.position, lifted, q)
            carry = chain(lifted, target, lift[-1]) if lift else None
            if not (up and lift and carry):
                continue
            shake = self.shake(GraspPose(lifted, candidate.rotation, 0.0), lift[-1], period)
            if shake is None:
                continue
            fraction = motion.speed_fraction
            reach = through([np.asarray(HOME), up[-1]], period, fraction)
            down = through([*up[::-1], q], period, fraction, above - pose.position[2], motion.approach_speed)
            return Plan(
                grasp,
                candidate,
                top,
                pose.position[2] - wanted_tip(top, motion),
                reach,
                down,
                through([q, *lift], period, fraction, motion.lift_height, motion.lift_speed),
                through(
                    [lift[-1], *carry],
                    period,
                    fraction,
                    float(np.linalg.norm(target - lifted)),
                    motion.carry_speed,
                ),
                shake,
            )
        x, y, z = pose.position
        raise Unreachable(
            f"no joint angles for the TCP at ({x:.3f}, {y:.3f}, {z:.3f}) m and the motion from it"
        )

    def shake(self, pose: GraspPose, q: Floats, period: float) -> tuple[Trajectory, ...] | None:
        """Bursts along the axes of the TCP at ``pose``, reached with joints ``q``; empty where the scenario
        has none, None where the arm cannot do them."""
        shake = self.scenario.motion.shake
        if shake.acceleration == 0:
            return ()
        bursts = []
        for axis in pose.rotation.T:
            ends = [
                self.ik.follow(
                    [GraspPose(pose.position + side * amplitude(shake) * axis, pose.rotation, 0.0)], q
                )
                for side in (-1, 1)
            ]
            if ends[0] is None or ends[1] is None:
                return None
            bursts.append(shaken((ends[0][0], ends[1][0]), q, shake, period))
            if (np.abs(bursts[-1].velocities) > VELOCITY_LIMITS).any():
                return None
        return tuple(bursts)
