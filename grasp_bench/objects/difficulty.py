"""How difficult objects are, as it was measured when they were made: part of the manifest.

An object's difficulty is the share of random antipodal tries on it that do not hold
(``grasp_bench/workshop/difficulty.py``), of one gripper. Household objects have none.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from grasp_bench.errors import GraspBenchError
from grasp_bench.objects.catalog import Catalog
from grasp_bench.scenario.sections import Scenario

DIFFICULTY = "difficulty"
"""Entry of the manifest."""


@dataclass(frozen=True)
class Difficulty:
    """What random antipodal tries on an object came to.

    Attributes:
        held, tried: how many held, and how many there were.
        gripper: name of the gripper that tried.
    """

    held: int
    tried: int
    gripper: str

    @property
    def failing(self) -> float:
        """The difficulty: share that did not hold, 0 to 1."""
        return 1 - self.held / self.tried


def difficulty_of(entry: dict[str, Any]) -> Difficulty | None:
    """Return the difficulty that a manifest's entry tells; None where none was measured."""
    told = entry.get(DIFFICULTY)
    return None if told is None else Difficulty(told["held"], told["tried"], told["gripper"])


def check_graded(scenario: Scenario, catalog: Catalog, names: Iterable[str]) -> dict[str, float]:
    """Return the difficulty of each named object, 0 to 1.

    Raises:
        GraspBenchError: where one was not measured with the scenario's gripper.
    """
    gripper = scenario.robot.loaded.gripper.name
    known = {name: difficulty_of(catalog.entries[name]) for name in names}
    if without := [name for name, told in known.items() if told is None]:
        more = f" and {len(without) - 1} more" if len(without) > 1 else ""
        raise GraspBenchError(
            f"The difficulty of {without[0]}{more} was not measured: scenario {scenario.name} needs objects "
            f"of graded difficulty, as --objects {' or '.join(catalog.sets or Catalog().sets)}."
        )
    if others := sorted({told.gripper for told in known.values() if told and told.gripper != gripper}):
        raise GraspBenchError(
            f"The difficulty of these objects was measured with gripper {others[0]}, and tells nothing of "
            f"{gripper}: leave the scenario's robot.gripper at {others[0]}, or take --scenario table4."
        )
    return {name: told.failing for name, told in known.items() if told}
