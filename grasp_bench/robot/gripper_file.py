"""``gripper.yaml``: what a gripper's maker states, and what its model calls its parts."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from grasp_bench.robot.facts import Facts

Positive = Annotated[float, Field(gt=0)]
Pair = tuple[str, str]


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
    """The content of ``gripper.yaml``.

    Attributes:
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
