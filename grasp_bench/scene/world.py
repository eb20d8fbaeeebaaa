"""A compiled scene in motion: placing the object, moving the arm, and reading contacts."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence

import mujoco
import numpy as np
from mujoco.rollout import Rollout

from grasp_bench.grasps import GraspPose
from grasp_bench.robot.cup import SuctionCup
from grasp_bench.robot.robot import Robot
from grasp_bench.robot.trajectory import Trajectory
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.builder import OBJECT
from grasp_bench.scene.sealing import Sealing
from grasp_bench.scene.touch import Feeling, Touch
from grasp_bench.system.arrays import Floats

LAST = 10
"""Steps between two looks at whether the objects are at rest."""
_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS
INTEGRATION = mujoco.mjtState.mjSTATE_INTEGRATION
ROLLOUT = Rollout(nthread=0)
"""Steps in the calling thread. It has no state; one for each motion would cost as much as a step."""


class UnstableError(RuntimeError):
    """The simulation diverged, or the object never came to rest."""


class World:
    """State of one trial.

    There may be several objects; one of them is the target, of which ``object_pose``, ``touch`` and
    ``rise`` tell.

    Args:
        model: compiled by :func:`grasp_bench.scene.builder.compile_scene`, robot included.
        scenario: the one the model was compiled with.
        objects: names of the objects' bodies; the first is the target at the start.
        friction: each object's friction against the pads, which take on the target's; without it they stay as
            compiled.
        robot: the one the model was compiled with; that of the scenario by default.

    Attributes:
        target: index of the object that is tried.
        pads: (2,) ids of the geoms of the left and the right pad.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        scenario: Scenario,
        objects: Sequence[str] = (OBJECT,),
        friction: Sequence[float] | None = None,
        robot: Robot | None = None,
    ) -> None:
        robot = robot or scenario.robot.loaded
        self.model, self.scenario, self.robot = model, scenario, robot
        arm, hand, gripper = robot.arm_prefix, robot.gripper_prefix, robot.gripper
        self.data = mujoco.MjData(model)
        joints = [model.joint(arm + n) for n in robot.arm.joints]
        self._arm_q = np.array([j.qposadr[0] for j in joints])
        self._arm_v = np.array([j.dofadr[0] for j in joints])
        self._arm_ctrl = np.array([model.actuator(arm + n).id for n in robot.arm.joints])
        self._jaw_ctrl = model.actuator(hand + gripper.actuator).id
        fingers = [model.joint(hand + n) for n in gripper.finger_joints]
        self._finger_q = np.array([j.qposadr[0] for j in fingers])
        # A position servo lags by kv/kp times the speed; adding that to the command cancels it.
        gain = model.actuator_gainprm[self._arm_ctrl, 0]
        self._lead = -model.actuator_biasprm[self._arm_ctrl, 2] / gain
        self._tcp = model.site(hand + gripper.tcp).id
        self.bodies = [model.body(n).id for n in objects]
        self._places = [model.joint(n).qposadr[0] for n in objects]
        self._speeds = [model.joint(n).dofadr[0] for n in objects]
        self._friction = friction
        self._feeling = Feeling(model, robot, self.bodies)
        self.pads = np.array([model.geom(hand + n).id for n in gripper.pads])
        self._sealing = Sealing(model, gripper, hand) if isinstance(gripper, SuctionCup) else None
        self.steps = 0
        self.observer: Callable[[World], None] | None = None
        """Called after every sample of a motion: for films and logs, never to act."""
        self._starts = [0.0] * len(objects)
        self.aim(0)
        self.go_home()

    # ------------------------------------------------------------ setting up

    def go_home(self, opening: float | None = None) -> None:
        """Put the resting arm at its home posture, jaws ``opening`` apart [m], or as wide as they go."""
        opening = self.robot.gripper.opening if opening is None else opening
        self.data.qpos[self._arm_q] = self.data.ctrl[self._arm_ctrl] = self.robot.arm.home
        self.data.qpos[self._finger_q] = self.robot.gripper.joints_at(opening / 2)
        self.data.ctrl[self._jaw_ctrl] = self.robot.gripper.command(opening / 2)

    def place_object(self, position: Floats, quaternion: Floats) -> None:
        """Put the resting object at a world pose."""
        q, v = self._object_q, self._object_v
        self.data.qpos[q : q + 3], self.data.qpos[q + 3 : q + 7] = position, quaternion
        self.data.qvel[v : v + 6] = 0

    def aim(self, which: int) -> None:
        """Make the ``which``-th object the target."""
        self.target = which
        self.object_body = self.bodies[which]
        self._object_q, self._object_v = self._places[which], self._speeds[which]
        if self._friction is not None:  # sliding friction of a pair is that of the pads, which have priority
            sliding = self._friction[which] * self.scenario.gripper.friction_scale
            self.model.geom_friction[self.pads, 0] = sliding
            if self._sealing is not None:
                self.model.geom_friction[self.pads] = self.robot.gripper.pad_friction(sliding, 0.0)

    def aim_at_held(self) -> None:
        """Make the object that both fingers hold the target; the old one stays where there is none."""
        if len(self.bodies) == 1:
            return
        before = self.target
        for which in [before, *(i for i in range(len(self.bodies)) if i != before)]:
            self.aim(which)
            if self.touch().held:
                return
        self.aim(before)

    def mark(self) -> None:
        """Take the objects' heights now as those they rise from."""
        self._starts = [float(self.data.xpos[body][2]) for body in self.bodies]

    def rise(self, which: int | None = None) -> float:
        """Return how far an object, by default the target, is above where it was marked [m]."""
        chosen = self.target if which is None else which
        return float(self.data.xpos[self.bodies[chosen]][2]) - self._starts[chosen]

    def settle(self) -> Floats:
        """Step until all objects have been still for ``settling.still_time``.

        Returns:
            The state :data:`LAST` steps before, from which as many come to the same rest, to the bit.

        Raises:
            UnstableError: when one is not at rest before ``settling.timeout``.
        """
        # The limits are the scenario's: they are part of a trial's definition. The floating gripper has its
        # own, with which labels and shipped objects were made.
        settling = self.scenario.settling
        period = LAST * self.model.opt.timestep
        still = 0.0
        for _ in range(int(settling.timeout / period)):
            before = self.integration
            self.step(LAST)
            moving = [self.data.qvel[v : v + 6] for v in self._speeds]
            quiet = all(
                np.linalg.norm(v[:3]) < settling.linear_speed
                and np.linalg.norm(v[3:]) < settling.angular_speed
                for v in moving
            )
            still = still + period if quiet else 0.0
            if still >= settling.still_time:
                return before
        raise UnstableError(f"the object was not at rest {settling.timeout:g} s after it was put down")

    @property
    def integration(self) -> Floats:
        """All that the next step depends on, besides the model."""
        state = np.empty(mujoco.mj_stateSize(self.model, INTEGRATION))
        mujoco.mj_getState(self.model, self.data, state, INTEGRATION)
        return state

    def keep(self) -> Callable[[], None]:
        """Return a function that puts everything back, to the bit, as it is now; it may be called again."""
        data, option = copy.copy(self.data), copy.copy(self.model.opt)
        steps, target, starts = self.steps, self.target, list(self._starts)

        def restore() -> None:
            mujoco.mj_copyData(self.data, self.model, data)
            self.model.opt.noslip_iterations = option.noslip_iterations
            self.model.opt.enableflags = option.enableflags
            self.steps, self.observer, self._starts = steps, None, list(starts)
            self.aim(target)

        return restore

    def spare(self) -> None:
        """From now on simulate no more than an untouched table needs.

        What lies still sleeps until something touches it, where the scenario says so, and there are no
        no-slip iterations, which keep what is *held* from creeping.
        """
        self.model.opt.noslip_iterations = 0
        if self.scenario.physics.sleep:
            self.model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_SLEEP)

    def hold(self) -> None:
        """From now on simulate what a held object needs: no-slip iterations, and nothing sleeps."""
        self.model.opt.noslip_iterations = self.scenario.physics.noslip_iterations
        self.model.opt.enableflags &= ~int(mujoco.mjtEnableBit.mjENBL_SLEEP)

    # ------------------------------------------------------------ moving

    def step(self, count: int) -> None:
        """Advance by ``count`` physics steps.

        Raises:
            UnstableError: on any MuJoCo warning (divergence, contact or constraint overflow).
        """
        mujoco.mj_step(self.model, self.data, count)
        self.steps += count
        if self.data.warning.number.any():
            which = int(np.argmax(self.data.warning.number > 0))
            raise UnstableError(f"MuJoCo warning {mujoco.mjtWarning(which).name[7:].lower()}")

    def command(self, q: Floats, velocity: Floats, jaw: float) -> None:
        """Set the servos: joint angles (N,) [rad] moving at ``velocity``, finger position [m]."""
        self.data.ctrl[self._arm_ctrl] = q + self._lead * velocity
        self.data.ctrl[self._jaw_ctrl] = self.robot.gripper.command(jaw)

    def follow(self, motion: Trajectory, jaw: float | Floats) -> None:
        """Run a whole trajectory; ``jaw`` is the finger command [m], fixed or one a sample."""
        jaws = np.broadcast_to(np.asarray(jaw, dtype=float), len(motion.positions))
        if self.observer is None and self._roll(motion, jaws):
            return
        for q, velocity, finger in zip(motion.positions, motion.velocities, jaws, strict=True):
            self.command(q, velocity, float(finger))
            self.step(self.scenario.physics.control_steps)
            if self.observer is not None:
                self.observer(self)

    def _roll(self, motion: Trajectory, jaws: Floats) -> bool:
        """Run a trajectory in one call, to the same bits as sample by sample.

        Returns:
            False where something was to warn of: all is then as before, for a run that finds out when.
        """
        data, repeat = self.data, self.scenario.physics.control_steps
        before = np.empty(mujoco.mj_stateSize(self.model, _STATE))
        mujoco.mj_getState(self.model, data, before, _STATE)
        warmstart = data.qacc_warmstart.copy()
        controls = np.repeat(data.ctrl[None], len(motion.positions), axis=0)
        controls[:, self._arm_ctrl] = motion.positions + self._lead * motion.velocities
        controls[:, self._jaw_ctrl] = self.robot.gripper.command(jaws)
        ROLLOUT.rollout(
            [self.model],
            [data],
            before[None],
            np.repeat(controls, repeat, axis=0)[None],
            skip_checks=True,  # shapes are right by construction; states on the way are not asked for
            nstep=repeat * len(controls),
            initial_warmstart=warmstart[None],
        )
        if data.warning.number.any():
            data.warning.number[:] = 0
            mujoco.mj_setState(self.model, data, before, _STATE)
            data.qacc_warmstart[:] = warmstart
            return False
        self.steps += repeat * len(controls)
        return True

    # ------------------------------------------------------------ reading

    @property
    def object_pose(self) -> tuple[Floats, Floats]:
        """Position (3,) [m] and rotation (3, 3) of the object."""
        return self.data.xpos[self.object_body].copy(), self.data.xmat[self.object_body].reshape(3, 3).copy()

    @property
    def tcp(self) -> GraspPose:
        """Where the TCP is now."""
        opening = float(self.robot.gripper.positions(self.data.qpos[self._finger_q]).sum())
        return GraspPose(
            self.data.site_xpos[self._tcp].copy(),
            self.data.site_xmat[self._tcp].reshape(3, 3).copy(),
            opening,
        )

    @property
    def joint_torques(self) -> Floats:
        """(N,) torques of the arm's motors [N m]: the servos', and the compensation of the arm's weight."""
        return self.data.qfrc_actuator[self._arm_v] + self.data.qfrc_gravcomp[self._arm_v]

    @property
    def joint_velocities(self) -> Floats:
        """(N,) velocities of the arm's joints [rad/s]."""
        return self.data.qvel[self._arm_v].copy()

    def seal_fault(self) -> str:
        """Say why a suction cup does not seal on any object; empty where it does, and for fingers."""
        return "" if self._sealing is None else self._sealing.fault(self.data, self.bodies)

    def touch(self) -> Touch:
        """Return what the object touches now, and how hard."""
        return self._feeling.touch(self.data, self.object_body, self.rise)

    def collision_force(self) -> tuple[float, str]:
        """Return the greatest normal force [N] of the robot against object or table, and what it meets."""
        return self._feeling.collision(self.data)
