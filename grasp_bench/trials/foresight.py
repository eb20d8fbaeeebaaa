"""Grasps tried out before one is chosen: what makes a control that knows the truth an upper bound.

A robot cannot do this. The grasps are planned on the true geometry, and each is carried out in a world of its
own, which comes out as the trial's would, until one succeeds. Where none does, as where objects have toppled
over and lie as no reference grasp is known for, those are tried that analysis of the true heights finds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import chain

import numpy as np
from numpy.typing import NDArray

from grasp_bench.grasps import Grasp, KnownGrasp
from grasp_bench.planning.analysed import analysed
from grasp_bench.planning.choice import Choice
from grasp_bench.planning.planner import Plan, Planner
from grasp_bench.planning.refusals import Refused
from grasp_bench.planning.seen import SeenScene
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scene.world import World
from grasp_bench.trials.execution import execute

MOST_TRIED = 20
"""Grasps that are tried out before those of analysis are, and of those again before the first that could be
planned is taken."""


def foresee(
    planner: Planner,
    truth: SeenScene,
    grasps: list[Grasp],
    fresh: Callable[[], World],
    meant: Callable[[Grasp], int],
    shows: NDArray[np.bool_] | None = None,
) -> Choice:
    """Choose the first of at least one grasp that succeeds; where none does, the first that can be planned.

    Known grasps are tried where they are known to be first, and then as a planner makes of them that sees
    perfectly; in the end those of analysis, which are added to ``grasps``.

    Args:
        truth: the scene as a camera without noise or error sees it.
        fresh: makes a world as the trial's is before the arm moves.
        meant: tells which object a grasp is for.
        shows: (H, W) whether a pixel of ``truth`` shows an object; None for known grasps alone.
    """
    refusal: Refused | None = None
    first: tuple[int, Plan] | None = None
    known = list(grasps)
    tries = [*enumerate(known), *((i, g.seen()) for i, g in enumerate(known) if isinstance(g, KnownGrasp))]

    def found() -> Iterator[tuple[int, Grasp]]:
        if shows is None:
            return
        for grasp in analysed(truth, shows, planner.robot.gripper, MOST_TRIED):
            grasps.append(grasp)
            yield len(grasps) - 1, grasp

    for rank, grasp in chain(tries[:MOST_TRIED], found()):
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
