"""The error of the TCP against its plan, moving and loaded.

The controller knows the weight of arm and gripper, not that of what it holds: a payload m pulls the TCP
down by J K⁻¹ Jᵀ m g, with J the Jacobian of the TCP and K the position gains of the servos. What is left
after that is the error of motion.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from grasp_bench.doctor.physics.check import Check, below, equals
from grasp_bench.doctor.physics.rig import block
from grasp_bench.objects.catalog import Catalog
from grasp_bench.planning.depth import SIDE_CLEARANCE
from grasp_bench.planning.planner import Plan
from grasp_bench.predictors import load_predictor
from grasp_bench.robot.robot import EC66_PARALLEL_85, Robot
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.builder import compile_mjcf, compose
from grasp_bench.scene.world import World
from grasp_bench.trials.trial import run_trial
from grasp_bench.trials.workcell import Workcell

Floats = NDArray[np.float64]

LOADS = (0.0, 1.0, 6.0)
"""Payloads [kg]; 6 kg is the EC66's greatest."""
FREE = 5.0
"""Greatest error of a motion through free space [mm]."""
OBJECT = "coffee_mug"


@dataclass(frozen=True)
class Tracking:
    """A reference trial's motion with a payload at the TCP.

    Attributes:
        load: payload [kg].
        error: (T, 3) error of the TCP at every sample [m], world frame.
        droop: (T, 3) the closed form of the payload's static share [m].
        joints: (T, 6) deviation of the joints from the motion [rad].
    """

    load: float
    error: Floats
    droop: Floats
    joints: Floats


def reference_plan(scenario: Scenario) -> Plan:
    """Return the motion of a trial of the oracle."""
    trial = run_trial(
        Workcell(scenario), Catalog().load(OBJECT), load_predictor("oracle"), trial=0, attempt=0, seed=0
    )
    assert trial.plan is not None
    return trial.plan


def track(scenario: Scenario, plan: Plan, load: float, robot: Robot = EC66_PARALLEL_85) -> Tracking:
    """Follow a plan's motion with nothing in the gripper, but ``load`` [kg] fixed to it at the TCP."""
    root: Any = compose(scenario, block((0.04, 0.04, 0.04), 0.1, 0.7), robot)
    hand, gripper = robot.gripper_prefix, robot.gripper
    if load:
        weight = root.find("body", hand + gripper.palm_body).add(
            "body", name="load", pos=[0, 0, gripper.flange_to_tcp]
        )
        weight.add("inertial", mass=load, pos=[0, 0, 0], diaginertia=[load * 1e-3] * 3)
    world = World(compile_mjcf(root), scenario, robot=robot)
    model, data = world.model, world.data
    world.place_object(np.array([-0.5, -0.5, 0.02]), np.array([1.0, 0, 0, 0]))  # out of the way
    site = model.site(hand + gripper.tcp).id
    names = [robot.arm_prefix + n for n in robot.arm.joints]
    dofs = np.array([model.joint(n).dofadr[0] for n in names])
    places = np.array([model.joint(n).qposadr[0] for n in names])
    gains = np.array([model.actuator(n).gainprm[0] for n in names])
    ideal = mujoco.MjData(model)
    error, droop, joints = [], [], []
    jacobian = np.zeros((3, model.nv))
    for motion in (plan.reach, plan.approach, plan.lift, plan.carry):
        wanted = iter(motion.positions)

        def compare(world: World) -> None:
            ideal.qpos[:] = data.qpos
            ideal.qpos[places] = q = next(wanted)  # noqa: B023  (called before the next motion begins)
            joints.append(data.qpos[places] - q)
            mujoco.mj_kinematics(model, ideal)
            mujoco.mj_comPos(model, ideal)
            mujoco.mj_kinematics(model, data)  # poses are otherwise those before the last step
            error.append(data.site_xpos[site] - ideal.site_xpos[site])
            mujoco.mj_jacSite(model, ideal, jacobian, None, site)
            j = jacobian[:, dofs]
            droop.append(j @ (j.T @ (load * model.opt.gravity) / gains))

        if motion is plan.reach:
            world.step(round(0.5 / model.opt.timestep))  # the payload comes to hang at home
        world.observer = compare
        world.follow(motion, gripper.stroke)
    return Tracking(load, np.array(error), np.array(droop), np.array(joints))


def tracking(scenario: Scenario) -> list[Check]:
    """Check errors of the TCP over a trial's motion, without and with payloads [mm]."""
    plan = reference_plan(scenario)
    down = len(plan.reach.positions)
    grasp = down + len(plan.approach.positions)
    checks = []
    for load in LOADS:
        run = track(scenario, plan, load)
        moving = 1000 * np.linalg.norm(run.error - run.droop, axis=1)
        if load == 0:
            checks += [
                below(
                    "TCP error at the grasp",
                    float(moving[grasp - 1]),
                    1000 * scenario.motion.tcp_tolerance,
                    "mm",
                    "the plan; a trial's own limit (motion.tcp_tolerance)",
                ),
                below(
                    "TCP error on the way down",
                    float(moving[down:grasp].max()),
                    1000 * SIDE_CLEARANCE,
                    "mm",
                    "the plan; the room beside a finger",
                ),
            ]
        else:
            checks.append(
                equals(
                    f"droop of the TCP under {load:g} kg, at rest",
                    1000 * float(-run.droop[-1, 2]),
                    1000 * float(-run.error[-1, 2]),
                    "mm",
                    0.05,
                    "J K⁻¹ Jᵀ m g of the position servos",
                )
            )
        words = "" if load == 0 else " beyond its droop"
        checks.append(
            below(
                f"TCP error in any motion with {load:g} kg{words}",
                float(moving.max()),
                FREE,
                "mm",
                "the plan; nothing is nearer than 30 mm to a free motion",
            )
        )
    return checks
