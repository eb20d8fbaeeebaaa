"""What the compiled model of an arm tells: its joints' limits, and how its base turns."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from grasp_bench.errors import AssetError
from grasp_bench.robot.arm_file import ArmFile
from grasp_bench.system.arrays import Floats

TILT = np.radians(1.0)
"""How far from straight down the tool may point in the postures of the file [rad]."""


@dataclass(frozen=True)
class ArmShape:
    """Measures of an arm of N joints that stands at the world's origin.

    Attributes:
        position_limits: (N, 2) joint ranges, lower and upper [rad].
        torque_limits: (N,) greatest torques [N m].
        shoulder: how far to the left of the base's axis, as it looks in its ready posture, the flange passes
            [m].
        ahead: direction in which the plane of upper arm and forearm looks in its ready posture, from x
            towards y [rad].
        turn: +1 where the first joint turns counter-clockwise as seen from above, −1 otherwise.
        wrist: +1 where the last joint turns about the direction out of the flange, −1 otherwise.
        reach: greatest distance of the flange from the first joint's axis, arm stretched out: an upper bound,
            the sum of the links [m].
        mass: of the whole arm [kg].
    """

    position_limits: tuple[tuple[float, float], ...]
    torque_limits: tuple[float, ...]
    shoulder: float
    ahead: float
    turn: int
    wrist: int
    reach: float
    mass: float


def measure(path: Path, facts: ArmFile) -> ArmShape:
    """Measure the arm whose MJCF is ``path``.

    Raises:
        AssetError: in one line, for a part that is not found, limits that are missing, or a wrong posture.
    """
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        raise AssetError(f"{path} is refused by MuJoCo: {' '.join(str(error).split())}") from error
    names = [model.joint(i).name for i in range(model.njnt)]
    motors = [model.actuator(i).name for i in range(model.nu)]
    for kind, found in (("joints", names), ("position actuators", motors)):
        if found != list(facts.joints):
            raise AssetError(
                f"{path}: its {kind} must be {', '.join(facts.joints)}; they are {', '.join(found)}."
            )
    if (model.jnt_type != mujoco.mjtJoint.mjJNT_HINGE).any():
        raise AssetError(f"{path}: only arms whose joints are all hinges are supported.")
    free = [n for n, limited in zip(names, model.jnt_limited, strict=True) if not limited]
    weak = [n for n, limited in zip(motors, model.actuator_forcelimited, strict=True) if not limited]
    if free or weak:
        what = f"joint {free[0]!r} has no range" if free else f"actuator {weak[0]!r} has no forcerange"
        raise AssetError(f"{path}: an arm without limits: {what}; write it into the model.")
    site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, facts.flange)
    if site < 0:
        sites = ", ".join(model.site(i).name for i in range(model.nsite)) or "none"
        raise AssetError(f"{path} has no site (flange) {facts.flange!r}; it has {sites}.")
    data = mujoco.MjData(model)
    for name, degrees in (("home_deg", facts.home_deg), ("ready_deg", facts.ready_deg)):
        q = np.radians(degrees)
        outside = [
            n for n, v, (low, high) in zip(names, q, model.jnt_range, strict=True) if not low <= v <= high
        ]
        if outside:
            raise AssetError(f"{path}: {name} is outside the range of joint {outside[0]!r}.")
        data.qpos[:] = q
        mujoco.mj_forward(model, data)
        if data.site_xmat[site][8] > -np.cos(TILT):
            raise AssetError(f"{path}: in {name} the flange {facts.flange!r} does not point straight down.")
    axes = data.xaxis
    if abs(axes[0][2]) < np.cos(TILT) or np.abs(data.xanchor[0][:2]).max() > 1e-3:
        raise AssetError(f"{path}: the first joint's axis must be the vertical through the world's origin.")
    at = data.site_xpos[site]
    if np.hypot(*at[:2]) < 0.1:
        raise AssetError(f"{path}: in ready_deg the flange is not ahead of the base, but above it.")
    ahead = _ahead(axes[1], at)
    links = [*np.diff(data.xanchor, axis=0), at - data.xanchor[-1]]
    return ArmShape(
        position_limits=tuple((float(low), float(high)) for low, high in model.jnt_range),
        torque_limits=tuple(float(v) for v in model.actuator_forcerange[:, 1]),
        shoulder=round(float(ahead[0] * at[1] - ahead[1] * at[0]), 6) + 0.0,
        ahead=round(float(np.arctan2(ahead[1], ahead[0])), 9) + 0.0,
        turn=1 if axes[0][2] > 0 else -1,
        wrist=1 if axes[-1] @ data.site_xmat[site].reshape(3, 3)[:, 2] > 0 else -1,
        reach=round(float(sum(np.linalg.norm(v) for v in links)), 6),
        mass=round(float(model.body_mass.sum()), 6),
    )


def _ahead(second: Floats, flange: Floats) -> Floats:
    """Return the horizontal unit direction (2,) in which an arm reaches whose second joint turns about
    ``second`` (3,); that of the flange (3,) where this is not horizontal."""
    if abs(second[2]) > np.sin(TILT):
        return flange[:2] / np.hypot(*flange[:2])
    across = np.array([-second[1], second[0]])
    return across / np.hypot(*across) * (1 if across @ flange[:2] > 0 else -1)
