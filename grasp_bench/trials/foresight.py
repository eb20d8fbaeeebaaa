"""Grasps tried out before one is chosen: what makes a control that knows the truth an upper bound.

A robot cannot do this. The grasps are planned on the true geometry, and each is carried out in a world of its
own, which comes out as the trial's would, until one succeeds.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from grasp_bench.grasps import Grasp, KnownGrasp
from grasp_bench.planning.choice import Choice
from grasp_bench.planning.planner import Plan, Planner
from grasp_bench.planning.refusals import Refused
from grasp_bench.planning.seen import SeenScene
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scene.world import World
from grasp_bench.trials.execution import execute

MOST_TRIED = 20
"""Grasps that are tried out before the first that could be planned is taken."""


def foresee(
    planner: Planner,
    truth: SeenScene,
    grasps: Sequence[Grasp],
    fresh: Callable[[], World],
    meant: Callable[[Grasp], int],
) -> Choice:
    """Choose the first of at least one grasp that succeeds; where none does, the first that can be planned.

    Known grasps are tried where they are known to be first, and then as a planner makes of them that sees
    perfectly.

    Args:
        truth: the scene as a camera without noise or error sees it.
        fresh: makes a world as the trial's is before the arm moves.
        meant: tells which object a grasp is for.
    """
    refusal: Refused | None = None
    first: tuple[int, Plan] | None = None
    tries = [*enumerate(grasps), *((i, g.seen()) for i, g in enumerate(grasps) if isinstance(g, KnownGrasp))]
    for rank, grasp in tries[:MOST_TRIED]:
        try:
            plan = planner.plan(truth, grasp)
        except Refused as error:
            refusal = refusal or error
            continue
        first = first or (rank, plan)
        world = fresh()
        world.aim(meant(grasp))
        if execute(world, plan).outcome is Outcome.SUCCESS:
            return Choice(rank, plan)
    if first is not None:
        return Choice(*first)
    assert refusal is not None
    return Choice(0, refusal)
