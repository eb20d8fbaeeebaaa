"""Which of a predictor's grasps is carried out."""

from __future__ import annotations

import pytest
from test_planner import grasp_at, ground, look

from grasp_bench.grasps import Grasp
from grasp_bench.planning.choice import choose_grasp
from grasp_bench.planning.planner import Plan, Planner
from grasp_bench.planning.refusals import Refused
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.scenario.sections import Execution

BAR = (0.04, 0.04, 0.06)
SCENE = look(
    ground(
        (0.42, -0.10, *BAR),  # stands free
        (0.58, -0.10, 0.12, 0.12, 0.047),  # wider than the jaws
        (0.45, 0.10, *BAR),
        (0.45, 0.10, 0.12, 0.12, 0.047),  # on a plinth that keeps the tips 17 mm too high
        (0.58, 0.10, *BAR),
        (0.58, 0.10, 0.12, 0.12, 0.040),
    )
)  # on one that keeps them 10 mm too high
FREE, SHALLOW, LESS_SHALLOW = (
    grasp_at(x, y, 0.06, 0, 0.06) for x, y in [(0.42, -0.10), (0.45, 0.10), (0.58, 0.10)]
)
BLOCKED = grasp_at(0.58, -0.10, 0.047, 0, 0.06)
BARE = grasp_at(0.50, 0.25, 0, 0, 0.06)


@pytest.fixture(scope="module")
def planner() -> Planner:
    return Planner(load_scenario("table4"))


@pytest.mark.parametrize(
    ("grasps", "rank", "shortfall"),
    [
        ([FREE, SHALLOW], 0, 0.0),
        ([SHALLOW, FREE], 1, 0.0),
        ([SHALLOW, LESS_SHALLOW, FREE], 2, 0.0),
        ([SHALLOW, LESS_SHALLOW], 1, 0.010),
        ([LESS_SHALLOW, SHALLOW], 0, 0.010),
        ([SHALLOW, SHALLOW], 0, 0.017),
        ([BLOCKED, SHALLOW], 1, 0.017),
        ([BARE, FREE], 0, 0.0),
        ([SHALLOW, BARE], 1, 0.0),
    ],
)
def test_the_best_deep_grasp_or_else_the_least_shallow(
    planner: Planner, grasps: list[Grasp], rank: int, shortfall: float
) -> None:
    choice = choose_grasp(planner, SCENE, grasps)
    assert isinstance(choice.plan, Plan)
    assert (choice.rank, choice.plan.grasp) == (rank, grasps[rank])
    assert choice.plan.shortfall == pytest.approx(shortfall, abs=1e-3)
    assert choice.plan.deep == (shortfall == 0)


def under(**execution: object) -> Planner:
    return Planner(
        load_scenario("table4").model_copy(update={"execution": Execution.model_validate(execution)})
    )


def test_as_predicted_no_other_grasp_is_tried() -> None:
    alone = under(protocol="as-predicted")
    choice = choose_grasp(alone, SCENE, [SHALLOW, FREE])
    assert isinstance(choice.plan, Plan)
    assert (choice.rank, choice.plan.grasp) == (0, SHALLOW)
    refused = choose_grasp(alone, SCENE, [BLOCKED, FREE])
    assert isinstance(refused.plan, Refused)


def test_proposals_beyond_the_counted_ones_are_not_looked_at() -> None:
    last, beyond = ([*[BLOCKED] * n, FREE] for n in (2, 3))
    assert choose_grasp(under(proposals=3), SCENE, last).rank == 2
    assert isinstance(choose_grasp(under(proposals=3), SCENE, beyond).plan, Refused)


def test_where_none_can_be_done_the_first_ones_failure_tells(planner: Planner) -> None:
    choice = choose_grasp(planner, SCENE, [BLOCKED, BLOCKED])
    assert isinstance(choice.plan, Refused)
    assert (choice.rank, choice.plan.outcome) == (0, Outcome.BLOCKED)
    assert "something is under a finger; the arm did not move" in str(choice.plan)
