"""A gripper alone, opened and closed by its actuator: whether it does what its file says."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from grasp_bench.errors import AssetError
from grasp_bench.robot.cup import SuctionCup
from grasp_bench.robot.facts import model_file
from grasp_bench.robot.gripper import Gripper

SECONDS = 3.0
PLATE = (0.03, 0.03, 0.005)
"""Half the sizes of what a cup must hold [m]."""
G = 9.81
OFF = 0.001
"""How far from where it was commanded to a finger may end [m]."""


@dataclass(frozen=True)
class Moved:
    """Openings between the pads [m] that the actuator's commands for open and closed lead to."""

    opened: float
    closed: float


def hold_plate(cup: SuctionCup) -> None:
    """Let a plate of half the weight that the cup's force bears hang at it, and switch the vacuum off.

    Raises:
        AssetError: where it does not hang, or hangs without vacuum.
    """
    weight = cup.force[1] / 2
    for on in (True, False):
        spec = mujoco.MjSpec.from_file(str(model_file(cup.folder, cup.facts.model)))
        plate = spec.worldbody.add_body(name="grasp_bench_plate", pos=[0, 0, cup.flange_to_tcp + PLATE[2]])
        plate.add_freejoint()
        plate.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=PLATE, mass=weight / G)
        model = spec.compile()
        model.opt.gravity[:] = 0, 0, G  # z is the approach
        model.actuator_forcerange[model.actuator(cup.actuator).id] = cup.actuator_range(cup.force[1])
        data = mujoco.MjData(model)
        data.ctrl[model.actuator(cup.actuator).id] = cup.command(-1.0 if on else 1.0)
        mujoco.mj_step(model, data, round(1.0 / model.opt.timestep))
        hangs = data.body("grasp_bench_plate").xpos[2] < cup.flange_to_tcp + PLATE[2] + 0.005
        if hangs != on:
            what = "does not hold" if on else "holds without vacuum"
            raise AssetError(f"{cup.path}: the cup {what} a plate of {weight:.1f} N, half of what it should.")


def try_out(gripper: Gripper) -> Moved:
    """Open and close a gripper in weightlessness; let a plate hang at a suction cup.

    Raises:
        AssetError: where the fingers do not get to where the file says, or the actuator is too weak.
    """
    if isinstance(gripper, SuctionCup):
        hold_plate(gripper)
        return Moved(0.0, 0.0)
    shape = gripper.shape
    if shape.strongest < gripper.force[1]:
        raise AssetError(
            f"{gripper.path}: squeezed by {1000 * gripper.squeeze:g} mm, the actuator presses each pad with "
            f"{shape.strongest:.0f} N at most, and gripper.yaml says {gripper.force[1]:g} N; raise the "
            "actuator's kp or squeeze, or lower force."
        )
    model = mujoco.MjModel.from_xml_path(str(model_file(gripper.folder, gripper.facts.model)))
    model.opt.gravity[:] = 0
    actuator = model.actuator(gripper.actuator).id
    model.actuator_forcerange[actuator] = gripper.actuator_range(gripper.force[1])
    addresses = [model.joint(n).qposadr[0] for n in gripper.finger_joints]
    data = mujoco.MjData(model)
    ends = []
    for position in (gripper.stroke, 0.0):
        data.ctrl[actuator] = gripper.command(position)
        mujoco.mj_step(model, data, round(SECONDS / model.opt.timestep))
        reached = gripper.positions(data.qpos[addresses])
        if data.warning.number.any() or not np.isfinite(reached).all():
            raise AssetError(f"{gripper.path}: the gripper is unstable when its actuator moves it.")
        if np.abs(reached - position).max() > OFF:
            what = "open" if position else "closed"
            raise AssetError(
                f"{gripper.path}: commanded {what} ({gripper.command(position):g}), the fingers get to "
                f"{1000 * reached[0]:.1f} and {1000 * reached[1]:.1f} mm, not to {1000 * position:.1f} mm; "
                "correct commands in gripper.yaml."
            )
        ends.append(float(reached.sum()))
    return Moved(*ends)
