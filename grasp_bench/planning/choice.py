"""Which of a predictor's grasps is carried out."""

from __future__ import annotations

from grasp_bench.grasps import Grasp
from grasp_bench.planning.planner import Plan, Planner
from grasp_bench.planning.refusals import Blocked, Unreachable
from grasp_bench.planning.seen import SeenScene
from grasp_bench.scenario.outcomes import Outcome


def choose_grasp(
    planner: Planner, scene: SeenScene, grasps: list[Grasp]
) -> tuple[int, Plan | None, Outcome, str]:
    """Rank and plan of the grasp to carry out: the best in which the tips get deep enough.

    Where none does, it is the one whose tips stay least above their wanted depth: rather a shallow
    grasp than none.
    Where none can be planned at all, the plan is None and the outcome tells why the best one cannot.
    """
    first: tuple[Outcome, str] | None = None
    shallow: tuple[int, Plan] | None = None
    for rank, grasp in enumerate(grasps):
        try:
            plan = planner.plan(scene, grasp)
        except Unreachable as error:
            first = first or (Outcome.IK_FAILED, str(error))
        except Blocked as error:
            first = first or (Outcome.APPROACH_COLLISION, str(error))
        else:
            if plan.deep:
                return rank, plan, Outcome.SUCCESS, ""
            if shallow is None or plan.shortfall < shallow[1].shortfall:
                shallow = rank, plan
    if shallow is not None:
        return *shallow, Outcome.SUCCESS, ""
    assert first is not None
    outcome, why = first
    return 0, None, outcome, why
