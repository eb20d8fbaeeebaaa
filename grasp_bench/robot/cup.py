"""A suction cup, in the terms of a gripper."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from grasp_bench.robot.facts import files, model_file
from grasp_bench.robot.gripper import Gripper, P
from grasp_bench.robot.gripper_file import SuctionFile
from grasp_bench.robot.seal import Seal
from grasp_bench.system.arrays import Floats

if TYPE_CHECKING:
    from grasp_bench.robot.gripper_shape import GripperShape

if TYPE_CHECKING:  # type checkers do not see that a cached_property meets a property of a frozen class
    from builtins import property as cached_property
else:
    from functools import cached_property


@dataclass(frozen=True)
class SuctionCup(Gripper):
    """One cup on a plunger with a spring, which vacuum holds to what its rim seals on.

    What is held is held by vacuum times area, as one contact at the cup's middle with the limit surface
    (s / μ)² + (τ / μ r)² + (m / r)² = (V − p)², of shear s, torsion τ, peeling moment m and pull p: Coulomb's
    friction under the rim, and a rigid ring of radius r that tips about its edge. These are the limits of
    the quasi-static model of Dex-Net 3.0 (Mahler et al., ICRA 2018, section IV) but for the moment, which
    there is that of an elastic ring. Whether it seals at all, :class:`~grasp_bench.robot.seal.Seal` says.

    In the terms of a gripper it has jaws that are as wide as the cup and do not move: vacuum is on where
    they are commanded to squeeze.
    """

    @property
    def cup(self) -> SuctionFile:
        """The content of its ``gripper.yaml``."""
        assert isinstance(self.facts, SuctionFile)
        return self.facts

    @cached_property
    def shape(self) -> GripperShape:
        """What is measured from the compiled model, when first asked for.

        Raises:
            AssetError: for a model that is not one of a suction cup.
        """
        from grasp_bench.robot.cup_shape import measure

        files(self.folder)
        return measure(model_file(self.folder, self.facts.model), self.cup)

    @property
    def radius(self) -> float:
        """Radius of the rim [m]."""
        return self.shape.pad[1] / 2

    @property
    def seal(self) -> Seal:
        """On what its rim seals."""
        cup = self.cup
        return Seal(self.radius, cup.compliance, cup.hollow, math.radians(cup.tilt_deg))

    @property
    def force(self) -> tuple[float, float]:
        """Least and greatest force that pulls it off [N]: vacuum times area."""
        area = math.pi * self.radius**2
        return self.cup.vacuum[0] * area, self.cup.vacuum[1] * area

    def pad_friction(self, friction: float, torsional: float) -> list[float]:
        """Return friction of the contact at the cup's middle; ``torsional`` is that of fingers."""
        return [friction, friction * self.radius, self.radius]

    def command(self, position: P) -> P:
        """Return the command of the vacuum, 0 or 1: on where jaws would squeeze."""
        return np.where(np.asarray(position) < 0, 1.0, 0.0)  # type: ignore[return-value]

    @property
    def opening(self) -> float:
        """Diameter of the rim [m]: what a grasp is wide."""
        return 2 * self.radius

    def joints_at(self, position: float) -> Floats:
        """Return zeros (2,): the plunger is out."""
        return np.zeros(2)

    def positions(self, joints: Floats) -> Floats:
        """Return zeros (2,): a cup does not open."""
        return np.zeros(2)
