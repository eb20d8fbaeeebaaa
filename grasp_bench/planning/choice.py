"""Which of a predictor's grasps is carried out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from grasp_bench.grasps import Grasp
from grasp_bench.planning.planner import Plan, Planner
from grasp_bench.planning.refusals import Refused
from grasp_bench.planning.seen import SeenScene
from grasp_bench.scenario.sections import Execution


@dataclass(frozen=True)
class Choice:
    """The grasp to carry out.

    Attributes:
        rank: place among the predictor's grasps, from 0.
        plan: its motion, or what refuses the best grasp where none can be planned.
    """

    rank: int
    plan: Plan | Refused


def choose_grasp(planner: Planner, scene: SeenScene, grasps: Sequence[Grasp]) -> Choice:
    """Choose the best of at least one grasp in which the tips get deep enough.

    Where none does, it is the one whose tips stay least above their wanted depth: rather a shallow grasp
    than none. Where the scenario has grasps carried out as predicted, it is the first or none.
    """
    refusal: Refused | None = None
    shallow: tuple[int, Plan] | None = None
    for rank, grasp in enumerate(grasps[: counted(planner.scenario.execution)]):
        try:
            plan = planner.plan(scene, grasp)
        except Refused as error:
            refusal = refusal or error
            continue
        if plan.deep:
            return Choice(rank, plan)
        if shallow is None or plan.shortfall < shallow[1].shortfall:
            shallow = rank, plan
    if shallow is not None:
        return Choice(*shallow)
    assert refusal is not None
    return Choice(0, refusal)


def counted(execution: Execution) -> int:
    """Return how many of a predictor's grasps are looked at."""
    return execution.proposals if execution.assisted else 1
