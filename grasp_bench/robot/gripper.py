"""What the package knows of a gripper: its folder's facts, and what is measured from its model."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from grasp_bench.robot.facts import digest, files, model_file
from grasp_bench.robot.gripper_file import GripperFile, SuctionFile
from grasp_bench.system.arrays import Floats

if TYPE_CHECKING:
    from grasp_bench.robot.gripper_shape import GripperShape

if TYPE_CHECKING:  # type checkers do not see that a cached_property meets a property of a frozen class
    from builtins import property as cached_property
else:
    from functools import cached_property

P = TypeVar("P", float, Floats)


@dataclass(frozen=True)
class Gripper:
    """A parallel gripper of two coupled fingers.

    Its frame is the flange's: z is the approach, x the direction in which the jaws open, the left finger on
    its positive side. A finger's *position* is 0 where the pads touch, and the stroke where they are open.
    The TCP lies between the lowest ends of the finger tips. Pairs of names are of the left and the right
    side.

    Attributes:
        name: by which it is found: a shipped gripper's name, or a path.
        folder: where its files are.
        facts: the content of its ``gripper.yaml``.
        scope: its name in composed models; those of its elements begin with ``arm's scope/scope/``.
    """

    name: str
    folder: Path
    facts: GripperFile | SuctionFile
    scope: str = "gripper"

    @property
    def path(self) -> Path:
        """The MJCF file."""
        return self.folder / self.facts.model

    @cached_property
    def shape(self) -> GripperShape:
        """What is measured from the compiled model, when first asked for.

        Raises:
            AssetError: for a model that is not one of a parallel gripper.
        """
        from grasp_bench.robot.gripper_shape import measure

        files(self.folder)
        return measure(model_file(self.folder, self.facts.model), self.jaws)

    @property
    def jaws(self) -> GripperFile:
        """The content of its ``gripper.yaml``."""
        assert isinstance(self.facts, GripperFile)
        return self.facts

    @cached_property
    def digest(self) -> str:
        """SHA-256 over all files of its folder."""
        return digest(self.folder)

    @property
    def title(self) -> str:
        """What it is called in reports."""
        return self.facts.title

    @property
    def stroke(self) -> float:
        """Travel of one finger [m]."""
        return self.shape.stroke

    @property
    def opening(self) -> float:
        """Widest opening between the pads [m]."""
        return 2 * self.shape.stroke

    @property
    def finger_thickness(self) -> float:
        """Thickness of a finger and its pad near the tip, along the jaw direction [m]."""
        return self.shape.finger_thickness

    @property
    def finger_width(self) -> float:
        """Width of a finger across the jaw direction [m]."""
        return self.shape.finger_width

    @property
    def finger_length(self) -> float:
        """Distance from the tips up to the hand's underside [m]."""
        return self.shape.finger_length

    @property
    def pad(self) -> tuple[float, float, float]:
        """Thickness along the jaw direction, width across it and height of a pad [m]."""
        return self.shape.pad

    @property
    def palm(self) -> tuple[float, float]:
        """Extent of the hand's underside along and across the jaw direction [m]."""
        return self.shape.palm

    @property
    def flange_to_tcp(self) -> float:
        """Distance from the flange to the TCP, along the approach [m]."""
        return self.shape.flange_to_tcp

    @property
    def force_ratio(self) -> float:
        """Force of the actuator for a force of 1 N of each pad."""
        return self.shape.force_ratio

    @property
    def finger_joints(self) -> tuple[str, ...]:
        """Joints of the left and the right finger; all joints of a linkage."""
        return self.shape.joints

    @property
    def force(self) -> tuple[float, float]:
        """Least and greatest force of each pad [N]."""
        return self.jaws.force

    @property
    def speed(self) -> float:
        """Greatest speed of each finger [m/s]."""
        return self.facts.speed

    @property
    def squeeze(self) -> float:
        """How far inside the closed position a finger may be commanded [m]."""
        return self.facts.squeeze

    @property
    def actuator(self) -> str:
        """The actuator that moves the fingers."""
        return self.facts.actuator

    @property
    def fingers(self) -> tuple[str, str]:
        """Bodies of the fingers."""
        return self.facts.fingers

    @property
    def pads(self) -> tuple[str, str]:
        """Geoms that touch what is held."""
        return self.facts.pads

    @property
    def palm_body(self) -> str:
        """Body between flange and fingers."""
        return self.facts.palm

    @property
    def tcp(self) -> str:
        """Site at the TCP, axes as the gripper's."""
        return self.facts.tcp

    def actuator_range(self, force: float) -> list[float]:
        """Return the force range of the actuator, lower and upper [N], for ``force`` newtons of each pad."""
        return [-self.force_ratio * force, self.force_ratio * force]

    def pad_friction(self, friction: float, torsional: float) -> list[float]:
        """Return sliding, torsional and rolling friction of the pads' contacts.

        Args:
            friction: coefficient of sliding friction.
            torsional: that of turning about the contact's normal [m].
        """
        return [friction, torsional, 1e-4]

    def command(self, position: P) -> P:
        """Return the actuator's command for a finger's position [m], below 0 to squeeze."""
        commands = self.jaws.commands
        slope = (commands.open - commands.closed) / self.shape.stroke
        return commands.closed + slope * position

    def joints_at(self, position: float) -> Floats:
        """Return the positions (N,) of :attr:`finger_joints` with both fingers at ``position`` [m]."""
        if self.shape.linkage is not None:
            return self.shape.linkage.joints_at(position)
        return np.array(self.shape.closed) + np.array(self.shape.slopes) * position

    def positions(self, joints: Floats) -> Floats:
        """Return the fingers' positions (2,) [m] from those of :attr:`finger_joints` (N,)."""
        if self.shape.linkage is not None:
            return self.shape.linkage.fingers(joints)
        return (joints - np.array(self.shape.closed)) / np.array(self.shape.slopes)
