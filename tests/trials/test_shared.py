"""What several predictors find alike: each record is, to the byte, the one made alone."""

from __future__ import annotations

from typing import Any

import pytest

from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.predictors.controls import Antipodal, Centroid, Displaced, Oracle, Random
from grasp_bench.scenario.sections import Scenario
from grasp_bench.trials.shared import SharedTable
from grasp_bench.trials.trial import run_trial
from grasp_bench.trials.workcell import Workcell

MAKERS = (Displaced, Oracle, Random, Antipodal, Oracle, Centroid)


@pytest.mark.parametrize("ahead", [False, True])
@pytest.mark.parametrize("name", ["bar", "pot"])
def test_records_are_those_made_alone(
    table4: Scenario, models: dict[str, ObjectModel], name: str, ahead: bool
) -> None:
    cell = Workcell(table4)
    shared = SharedTable(cell, models[name], attempt=2, seed=5)
    table = shared.prepared() if ahead else shared.table
    ways: dict[str, Any] = {"attempt": 2, "seed": 5, "trial": 7}
    together = [run_trial(cell, models[name], make(), table=table, **ways).record.line() for make in MAKERS]
    alone = [run_trial(Workcell(table4), models[name], make(), **ways).record.line() for make in MAKERS]
    assert together == alone
    assert len(set(alone)) == len(MAKERS) - 1  # the oracle twice


def test_an_object_that_never_rests_is_unstable_for_all(
    table4: Scenario, models: dict[str, ObjectModel]
) -> None:
    restless = table4.settling.model_copy(update={"timeout": 0.1, "still_time": 5.0})
    scenario = table4.model_copy(update={"settling": restless})
    cell = Workcell(scenario)
    table = SharedTable(cell, models["bar"]).prepared()
    lines = {run_trial(cell, models["bar"], make(), table=table).record.line() for make in MAKERS}
    assert lines == {run_trial(Workcell(scenario), models["bar"], Oracle()).record.line()}
    assert '"outcome": "unstable"' in lines.pop()
