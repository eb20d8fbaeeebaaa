"""What the package knows of a gripper; it is written nowhere else.

A gripper is a file of this room with one :class:`Gripper` in it; ``tests/robot/test_facts.py`` holds it
against its model.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from grasp_bench.system.paths import assets_dir


@dataclass(frozen=True, kw_only=True)
class Gripper:
    """A parallel gripper of two coupled fingers.

    Its frame is the flange's: z is the approach, x the direction in which the jaws open, the left finger on
    its positive side. A finger's joint is 0 where the pads touch. The TCP lies between the lowest ends of the
    finger tips. Pairs of names are of the left and the right side.

    Attributes:
        name: what the gripper is called in reports.
        file: MJCF file below the assets folder.
        scope: its name in composed models; those of its elements begin with ``arm's scope/scope/``.
        stroke: travel of one finger [m].
        finger_thickness: thickness of a finger and its pad near the tip, along the jaw direction [m].
        finger_width: width of a finger across the jaw direction [m].
        finger_length: distance from the tips up to the hand's underside [m].
        pad: thickness along the jaw direction, width across it and height of a pad, whose lower end is the
            finger's [m].
        palm: extent of the hand's underside along and across the jaw direction [m].
        flange_to_tcp: distance from the flange to the TCP, along the approach [m].
        force: least and greatest force of each pad [N].
        force_ratio: force of the actuator for a force of 1 N of each pad.
        speed: greatest speed of each finger [m/s].
        squeeze: how far inside the closed position a finger may be commanded [m].
        actuator: moves the fingers; its command is the position of each [m].
        finger_joints, fingers, pads: joints, bodies and geoms that touch what is held.
        palm_body: body between flange and fingers.
        tcp: site at the TCP, axes as the gripper's.
    """

    name: str
    file: str
    scope: str = "gripper"
    stroke: float
    finger_thickness: float
    finger_width: float
    finger_length: float
    pad: tuple[float, float, float]
    palm: tuple[float, float]
    flange_to_tcp: float
    force: tuple[float, float]
    force_ratio: float
    speed: float
    squeeze: float
    actuator: str
    finger_joints: tuple[str, str]
    fingers: tuple[str, str]
    pads: tuple[str, str]
    palm_body: str
    tcp: str

    @property
    def path(self) -> Path:
        """The MJCF file; its meshes are in the folder ``meshes`` beside it."""
        return assets_dir() / self.file

    @property
    def opening(self) -> float:
        """Widest opening between the pads [m]."""
        return 2 * self.stroke

    def actuator_range(self, force: float) -> list[float]:
        """Return the force range of the actuator, lower and upper [N], for ``force`` newtons of each pad."""
        return [-self.force_ratio * force, self.force_ratio * force]
