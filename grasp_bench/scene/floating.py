"""The gripper without the arm: tries a grasp in physics in a few hundredths of a second.

The same gripper, contacts and grip force as in a trial, carried by four stiff slides (x, y,
z and yaw) instead of the arm. It verifies reference grasps and labels training data.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from grasp_bench.robot.gripper import Gripper
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.robot.solids import subtree
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.builder import SceneObject, add_object, add_table, new_world, object_name
from grasp_bench.scene.contacts import touching
from grasp_bench.scene.mounting import set_gripper
from grasp_bench.system.arrays import Floats

PREFIX = "carrier/"
WRIST = "wrist"
"""Body between the carrier and a gripper that can be tilted."""
PARK = 1.0
"""How far beside and above the table's edge the gripper waits, out of the way of all rays [m]."""
SHAKE = 5.0
"""Acceleration of the shake along each axis [m/s²]."""

FOR_VIEWING = ("timestep", "integrator", "solver", "jacobian", "cone", "impratio", "noslip_iterations")
"""Options that a gripper's file has for viewing it alone; the scenario's are in force."""


@dataclass(frozen=True)
class Routine:
    """How a grasp is tried.

    Attributes:
        closing_speed: speed of each finger [m/s].
        lift: height to which the object is lifted [m].
        lift_speed: speed of the lift [m/s].
        shake_hz: frequency of the shake, one period along each axis.
        pause: time of standing still after closing and at the end [s].
    """

    closing_speed: float = 0.15
    lift: float = 0.10
    lift_speed: float = 0.25
    shake_hz: float = 4.0
    pause: float = 0.1


REFERENCE = Routine()
"""For reference grasps, of which there are few."""
QUICK = Routine(closing_speed=0.3, lift=0.05, lift_speed=0.4, shake_hz=8.0, pause=0.05)
"""For training data: a third of the simulated time."""


@dataclass(frozen=True)
class Attempt:
    """How a floating grasp ended.

    Attributes:
        held: lifted and still held by both fingers after the shake.
        why: ``held``, ``collision``, ``missed``, ``slipped`` or ``unstable``.
        slide: how far the object moved against the gripper between closing and the end [m].
    """

    held: bool
    why: str
    slide: float = 0.0


def compile_floating(
    scenario: Scenario, objects: list[SceneObject], gripper: Gripper = PARALLEL_85, tilting: bool = False
) -> mujoco.MjModel:
    """Compile a model of a table with ``objects`` and the floating ``gripper``; ``tilting`` for one of
    :class:`~grasp_bench.scene.tilting.TiltingGripper`.

    The gripper is read and attached by MuJoCo itself: dm_control needs 28 ms to read its file alone, and
    one such model is made for each scene of training data.
    """
    root = new_world(scenario)
    add_table(root, scenario)
    mount = root.worldbody.add("body", name="mount", pos=[0, 0, 0], gravcomp=1)
    mount.add("inertial", mass=0.5, pos=[0, 0, 0], diaginertia=[1e-3, 1e-3, 1e-3])
    for name, kind, axis in (
        ("x", "slide", [1, 0, 0]),
        ("y", "slide", [0, 1, 0]),
        ("z", "slide", [0, 0, 1]),
        ("yaw", "hinge", [0, 0, 1]),
    ):
        joint = mount.add("joint", name=name, type=kind, axis=axis, armature=0.05)
        stiff = 30000 if kind == "slide" else 300
        root.actuator.add("position", name=name, joint=joint, kp=stiff, kv=stiff / 60)
    carrier = mount.add("body", name=WRIST) if tilting else mount
    carrier.add("site", name="flange", quat=[0, 1, 0, 0])
    for i, model in enumerate(objects):
        add_object(root, model, scenario, object_name(i))

    hand = mujoco.MjSpec.from_file(str(gripper.path))
    set_gripper(
        gripper,
        [hand.geom(name) for name in dict.fromkeys(gripper.pads)],
        hand.actuator(gripper.actuator),
        scenario,
        max((o.friction for o in objects), default=1.0),
    )
    for unseen in [g for g in hand.geoms if not (g.contype or g.conaffinity)]:
        hand.delete(unseen)
    solid = {g.meshname for g in hand.geoms}
    for unseen in [m for m in hand.meshes if m.name not in solid]:
        hand.delete(unseen)
    spec = mujoco.MjSpec.from_string(root.to_xml_string(), assets=root.get_assets())
    for name in FOR_VIEWING:
        setattr(hand.option, name, getattr(spec.option, name))
    with warnings.catch_warnings():  # meshes of a hand are files, found where they are
        warnings.filterwarnings("ignore", "Attaching a child without asset dict")
        spec.attach(hand, prefix=PREFIX, site=spec.site("flange"))
    return spec.compile()


class FloatingGripper:
    """Tries grasps on the objects of one scene.

    Args:
        model: compiled by :func:`compile_floating`.
        scenario: the one the model was compiled with.
        count: number of objects in the model.
        gripper: the one the model was compiled with.

    Attributes:
        carrier_q, carrier_v, carrier_u: (4,) addresses of x, y, z and yaw in ``qpos``, ``qvel`` and ``ctrl``.
        jaw, fingers: address of the fingers' command in ``ctrl``, and (N,) of their joints in ``qpos``.
        object_q, object_v: address of each object's free joint in ``qpos`` and ``qvel``.
        left, right: (geoms,) whether a geom belongs to that finger.
        body: (geoms,) number of the object that a geom belongs to, −1 for none.
    """

    def __init__(
        self, model: mujoco.MjModel, scenario: Scenario, count: int = 1, gripper: Gripper = PARALLEL_85
    ) -> None:
        self.model, self.scenario, self.data = model, scenario, mujoco.MjData(model)
        self.gripper = gripper
        self.carrier_q = np.array([model.joint(n).qposadr[0] for n in ("x", "y", "z", "yaw")])
        self.carrier_v = np.array([model.joint(n).dofadr[0] for n in ("x", "y", "z", "yaw")])
        self.carrier_u = np.array([model.actuator(n).id for n in ("x", "y", "z", "yaw")])
        self.jaw = model.actuator(PREFIX + gripper.actuator).id
        self.fingers = np.array([model.joint(PREFIX + n).qposadr[0] for n in gripper.finger_joints])
        joints = [model.joint(object_name(i)) for i in range(count)]
        self.object_q = [int(joint.qposadr[0]) for joint in joints]
        self.object_v = [int(joint.dofadr[0]) for joint in joints]
        bodies = [model.body(i).name for i in model.geom_bodyid]
        self.left, self.right = (
            np.isin(model.geom_bodyid, subtree(model, model.body(PREFIX + f).id)) for f in gripper.fingers
        )
        self._gripper = np.array([b.startswith(PREFIX) for b in bodies])
        self.body = np.array([int(b[6:]) if b.startswith("object") else -1 for b in bodies])
        self._tcp = model.site(PREFIX + gripper.tcp).id
        self.park()

    def park(self) -> None:
        """Move the gripper out of the way, open."""
        self.put([PARK, 0, PARK, 0], self.gripper.opening)

    def put(self, carrier: Any, opening: float) -> None:
        """Put the gripper at ``carrier`` (4,) [m, rad] with its jaws ``opening`` wide [m], at rest there."""
        self.data.qpos[self.carrier_q] = self.data.ctrl[self.carrier_u] = carrier
        self.data.qpos[self.fingers] = self.gripper.joints_at(opening / 2)
        self.data.ctrl[self.jaw] = self.gripper.command(opening / 2)

    def settle(self, seconds: float) -> bool:
        """Let the objects come to rest with the gripper parked, and return whether they did."""
        # At rest is what is slower than 1 cm/s and 0.01 rad/s along and about every axis at three looks in a
        # row. Trials have the limits of their scenario; labels and shipped objects were made with these.
        chunk, still = 20, 0
        for _ in range(int(seconds / (chunk * self.model.opt.timestep))):
            mujoco.mj_step(self.model, self.data, chunk)
            if self.data.warning.number.any():
                return False
            speed = [np.abs(self.data.qvel[v : v + 6]).max() for v in self.object_v]
            still = still + 1 if max(speed) < 0.01 else 0
            if still == 3:
                return True
        return False

    def state(self) -> tuple[Floats, Floats]:
        """Return positions and velocities, for :meth:`attempt`."""
        return self.data.qpos.copy(), self.data.qvel.copy()

    def attempt(
        self,
        state: tuple[Floats, Floats],
        tip: Floats,
        yaw: float,
        opening: float,
        routine: Routine = REFERENCE,
    ) -> Attempt:
        """Try a grasp from a saved state: appear open at ``tip``, close, lift and shake.

        Args:
            state: positions and velocities, from :meth:`state`.
            tip: (3,) TCP position [m].
            yaw: jaw direction in the world [rad].
            opening: distance between the pads before closing [m].
            routine: how fast and how far.
        """
        self.restore(state)
        height = tip[2] + self.gripper.flange_to_tcp
        return self.grasp(np.array([*tip[:2], height, yaw]), opening, routine)

    def restore(self, state: tuple[Floats, Floats]) -> None:
        """Put everything as it was saved by :meth:`state`."""
        mujoco.mj_resetData(self.model, self.data)
        self.data.qpos[:], self.data.qvel[:] = state

    def grasp(self, carrier: Floats, opening: float, routine: Routine = REFERENCE) -> Attempt:
        """Appear open at ``carrier`` (4,) [m, rad], close, lift and shake."""
        model, data, height = self.model, self.data, float(carrier[2])
        dt = model.opt.timestep
        chunk = 5
        if fault := self.take(carrier, opening, routine):
            return Attempt(False, fault)
        mujoco.mj_step(model, data, int(routine.pause / dt))
        grip = self.held()
        if grip is None:
            return Attempt(False, "missed")
        start = self._relative(grip)
        for z in np.arange(0, routine.lift, routine.lift_speed * dt * chunk):
            data.ctrl[self.carrier_u[2]] = height + z
            mujoco.mj_step(model, data, chunk)
        if self.held() != grip:
            return Attempt(False, "slipped")
        # A full sine of acceleration along each axis, amplitude SHAKE.
        omega = 2 * np.pi * routine.shake_hz
        rest = data.ctrl[self.carrier_u[:3]].copy()
        for axis in range(3):
            for t in np.arange(0, 1 / routine.shake_hz, dt * chunk):
                data.ctrl[self.carrier_u[axis]] = rest[axis] + SHAKE / omega**2 * np.sin(omega * t)
                mujoco.mj_step(model, data, chunk)
        data.ctrl[self.carrier_u[:3]] = rest
        mujoco.mj_step(model, data, int(routine.pause / dt))
        if data.warning.number.any():
            return Attempt(False, "unstable")
        slide = float(np.linalg.norm(self._relative(grip) - start))
        return Attempt(self.held() == grip, "held" if self.held() == grip else "slipped", slide)

    def take(self, carrier: Floats, opening: float, routine: Routine) -> str:
        """Appear at ``carrier`` (4,) [m, rad], jaws ``opening`` apart [m], and close; say what hindered it,
        if anything."""
        self.put(carrier, opening)
        mujoco.mj_forward(self.model, self.data)
        if self.penetrates():
            return "collision"
        squeeze = -self.scenario.gripper.squeeze
        chunk = 5
        step = routine.closing_speed * self.model.opt.timestep * chunk
        for jaw in np.arange(opening / 2, squeeze, -step):
            self.data.ctrl[self.jaw] = self.gripper.command(float(jaw))
            mujoco.mj_step(self.model, self.data, chunk)
        self.data.ctrl[self.jaw] = self.gripper.command(squeeze)
        return ""

    def penetrates(self, depth: float = 5e-4) -> bool:
        """Return whether the gripper is more than ``depth`` inside something [m]."""
        ours = touching(self.data, self._gripper, ~self._gripper)
        return bool((self.data.contact.dist[ours] < -depth).any())

    def held(self) -> int | None:
        """Return the number of the object that both fingers touch, if any."""
        # A contact is enough for a quick try, whatever force it carries; a trial's judge wants a positive one
        # (:attr:`grasp_bench.scene.touch.Touch.held`). Labels and shipped objects were made like this.
        pairs = self.data.contact.geom
        fingers = (self.body[pairs[touching(self.data, f)]].max(1) for f in (self.left, self.right))
        left, right = ({int(b) for b in bodies if b >= 0} for bodies in fingers)
        both = left & right
        return min(both) if both else None

    def _relative(self, which: int) -> Floats:
        q = self.object_q[which]
        return self.data.qpos[q : q + 3] - self.data.site_xpos[self._tcp]
