"""Fingers on hinges: a closed linkage, swept once by its own actuator, tells where all of its joints are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from grasp_bench.errors import AssetError
from grasp_bench.robot.gripper_file import Commands
from grasp_bench.robot.solids import subtree
from grasp_bench.system.arrays import Floats

STEPS = 25
"""Openings at which the joints are noted; between them they are taken to be linear."""
SETTLING = 0.1
"""Time for each of them [s]; the first has five times as much."""
TURNED = np.radians(2.0)
"""Pads that turn further than this while they close are not parallel jaws [rad]."""


@dataclass(frozen=True)
class Linkage:
    """All joints of a gripper with hinges, over the travel of its fingers.

    Attributes:
        positions: (K,) a finger's positions, ascending from closed [m].
        angles: (K, N) positions of the joints there.
        drivers: columns of the joints that tell the left and the right finger's position.
    """

    positions: tuple[float, ...]
    angles: tuple[tuple[float, ...], ...]
    drivers: tuple[int, int]

    def joints_at(self, position: float) -> Floats:
        """Return the positions (N,) of all joints where both fingers' are ``position`` [m]."""
        return np.array([np.interp(position, self.positions, column) for column in np.transpose(self.angles)])

    def fingers(self, joints: Floats) -> Floats:
        """Return the fingers' positions (2,) [m] from those of all joints (N,)."""
        columns = np.transpose(self.angles)
        found = []
        for driver in self.drivers:
            column = columns[driver]
            order = 1 if column[-1] > column[0] else -1
            found.append(np.interp(order * joints[driver], order * column, self.positions))
        return np.array(found)


@dataclass(frozen=True)
class Swept:
    """What a sweep tells.

    Attributes:
        linkage: where the joints are.
        travel: of one finger [m].
        deepest: position of the fingers at which their tips reach furthest [m].
        ratio: force of the actuator for 1 N of each pad, half-way.
    """

    linkage: Linkage
    travel: float
    deepest: float
    ratio: float


def sweep(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    path: Path,
    actuator: int,
    commands: Commands,
    pads: list[int],
    gap: Callable[[], float],
) -> Swept:
    """Move a linkage from closed to open by its actuator, weightless.

    Args:
        path: named in errors.
        pads: geoms of the left and the right pad.
        gap: measures the distance between the pads [m] in ``data``.

    Raises:
        AssetError: where it does not move as parallel jaws do.
    """
    gravity = model.opt.gravity.copy()
    model.opt.gravity[:] = 0
    mujoco.mj_resetData(model, data)
    at = np.array([data.geom_xpos[p] for p in pads])
    gaps, angles, depths, lengths, turns = [], [], [], [], []
    for i, command in enumerate(np.linspace(commands.closed, commands.open, STEPS)):
        data.ctrl[actuator] = command
        mujoco.mj_step(model, data, round((SETTLING if i else 5 * SETTLING) / model.opt.timestep))
        if data.warning.number.any() or not np.isfinite(data.qpos).all():
            raise AssetError(f"{path}: the gripper is unstable when its actuator moves it.")
        mujoco.mj_forward(model, data)
        at = np.array([data.geom_xpos[p] for p in pads])
        gaps.append(gap())
        angles.append(data.qpos.copy())
        depths.append(float(at[:, 2].mean()))
        lengths.append(float(data.actuator_length[actuator]))
        turns.append(data.geom_xmat[pads].copy())
    model.opt.gravity[:] = gravity
    travel = gaps[-1] / 2
    if not (np.diff(gaps) > 0).all():
        raise AssetError(
            f"{path}: actuator {model.actuator(actuator).name!r} does not move the pads apart from its "
            "command for closed to that for open; see commands in gripper.yaml."
        )
    cosine = [float((a * b).sum() / 2 - 0.5) for a, b in zip(turns[0], turns[-1], strict=True)]
    turned = float(np.arccos(np.clip(min(cosine), -1, 1)))
    if turned > TURNED:
        raise AssetError(
            f"{path}: the pads turn by {np.degrees(turned):.0f}° while the fingers close; linkages whose "
            "pads stay parallel are supported."
        )
    positions = np.array(gaps) / 2
    positions[0] = max(positions[0], 0.0) if positions[1] > 0 else positions[0]
    middle = STEPS // 2
    ratio = (gaps[middle + 1] - gaps[middle - 1]) / abs(lengths[middle + 1] - lengths[middle - 1])
    linkage = Linkage(
        tuple(float(p) for p in positions),
        tuple(tuple(float(v) for v in q) for q in angles),
        _drivers(model, pads),
    )
    return Swept(linkage, travel, float(positions[int(np.argmax(depths))]), float(ratio))


def _drivers(model: mujoco.MjModel, pads: list[int]) -> tuple[int, int]:
    """Return the joints nearest to the base on the way to each pad."""
    found = []
    for pad in pads:
        owner = int(model.geom_bodyid[pad])
        chain = [j for j in range(model.njnt) if owner in subtree(model, int(model.jnt_bodyid[j]))]
        found.append(min(chain))
    return found[0], found[1]
