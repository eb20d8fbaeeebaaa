"""``gripper.yaml``: what a gripper's maker states, and what its model calls its parts."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from grasp_bench.robot.facts import Facts

Positive = Annotated[float, Field(gt=0)]
Pair = tuple[str, str]
ATMOSPHERE = 101325.0
"""The air's pressure [Pa]."""


class Commands(Facts):
    """Commands of the actuator at which the jaws are widest ``open`` and just ``closed``, pads touching.

    A command for a finger's position between them is linear between them.
    """

    open: float
    closed: float

    @model_validator(mode="after")
    def _two(self) -> Commands:
        if self.open == self.closed:
            raise ValueError("open and closed are the same command")
        return self


class GripperFile(Facts):
    """The content of ``gripper.yaml`` of a gripper with jaws.

    Attributes:
        kind: what it is; a file that does not say has jaws.
        title: what the gripper is called in reports.
        source: where its numbers are from.
        model: its MJCF, a file of the same folder.
        actuator: the one that moves the fingers.
        commands: its commands for open and closed.
        fingers: bodies of the left finger (where x is positive) and of the right one.
        pads: geoms that touch what is held, of the left and the right finger.
        palm: body between flange and fingers.
        tcp: site midway between the lowest ends of the finger tips, axes as the gripper's.
        force: least and greatest force of each pad [N].
        speed: greatest speed of each finger [m/s].
        squeeze: how far inside the closed position a finger may be commanded [m].
    """

    kind: Literal["jaws"] = "jaws"
    title: str
    source: str = ""
    model: str
    actuator: str
    commands: Commands
    fingers: Pair
    pads: Pair
    palm: str
    tcp: str
    force: tuple[Positive, Positive]
    speed: Positive
    squeeze: Annotated[float, Field(ge=0)]

    @model_validator(mode="after")
    def _ordered(self) -> GripperFile:
        if self.force[0] > self.force[1]:
            raise ValueError("force must be the least and then the greatest force of a pad")
        return self


class SuctionFile(Facts):
    """The content of ``gripper.yaml`` of a suction cup.

    Attributes:
        kind: what it is.
        title: what the gripper is called in reports.
        source: where its numbers are from.
        model: its MJCF, a file of the same folder.
        actuator: MuJoCo's ``adhesion`` of the body that has ``contact``.
        plunger: body that carries the cup, on one slide joint along the approach.
        rim: cylinder whose end is the rim that seals; its radius is the cup's.
        contact: geom at the cup's middle that touches what is held, alone in its body.
        palm: body between flange and cup.
        tcp: site at the middle of the rim where the plunger is out, axes as the gripper's.
        vacuum: least and greatest pressure below the air's [Pa].
        press: how far the plunger is pushed in on a grasp [m].
        compliance: how far the rim follows a surface that is not plane [m].
        hollow: how far what is held may stand out into the cup [m].
        tilt_deg: how far the rim tilts to lie on a surface [°].
    """

    kind: Literal["suction"]
    title: str
    source: str = ""
    model: str
    actuator: str
    plunger: str
    rim: str
    contact: str
    palm: str
    tcp: str
    vacuum: tuple[Positive, Positive]
    press: Positive
    compliance: Positive
    hollow: Positive
    tilt_deg: Annotated[float, Field(gt=0, lt=60)]

    @model_validator(mode="after")
    def _ordered(self) -> SuctionFile:
        if self.vacuum[0] > self.vacuum[1]:
            raise ValueError("vacuum must be the least and then the greatest")
        if self.vacuum[1] > ATMOSPHERE:
            raise ValueError(f"vacuum cannot be more than the air's pressure, {ATMOSPHERE:g} Pa")
        return self

    @property
    def fingers(self) -> Pair:
        """The plunger, on both sides."""
        return self.plunger, self.plunger

    @property
    def pads(self) -> Pair:
        """The geom that touches, on both sides."""
        return self.contact, self.contact

    @property
    def speed(self) -> float:
        """No limit: a pump has no fingers."""
        return math.inf

    @property
    def squeeze(self) -> float:
        """No limit, likewise."""
        return math.inf
