"""What `run.json` says: groups of keys, versions, and the deprecated way to read it."""

from __future__ import annotations

from pathlib import Path

import pytest
from made_up_runs import RUN, write_run

from grasp_bench.report.table4 import build_report
from grasp_bench.report.tables import as_text
from grasp_bench.runs.info import RESUMABLE, SAME_RUN, Group, RunInfo
from grasp_bench.scenario.sections import VERSION


def info(**changes: object) -> RunInfo:
    return RunInfo.read(RUN | changes)


def test_every_key_but_notes_belongs_to_a_group() -> None:
    grouped = set(RunInfo.keys(*Group))
    assert set(RunInfo.model_fields) - grouped == {"format", "command"}


def test_what_may_differ_depends_on_the_question() -> None:
    one, other = info(cpu="one", seed=4), info(cpu="two", seed=4, shard="1/2")
    assert one.differences(other, *SAME_RUN) == {}
    assert list(one.differences(other, *RESUMABLE)) == ["shard"]
    assert list(one.differences(other, Group.ORIGIN)) == ["cpu"]
    assert list(one.differences(info(seed=5), Group.TRIALS)) == ["seed"]


def test_unknown_keys_of_a_later_version_are_kept() -> None:
    assert info(later={"a": 1}).to_json()["later"] == {"a": 1}


def test_keys_can_still_be_asked_for_as_before() -> None:
    with pytest.warns(DeprecationWarning, match="use .predictor"):
        assert info()["predictor"] == "oracle"


@pytest.mark.parametrize(("version", "label"), [(None, "table4 (definition 1)"), (VERSION, "table4")])
def test_runs_of_an_earlier_definition_are_marked(tmp_path: Path, version: int | None, label: str) -> None:
    scenario = {"name": "table4"} | ({} if version is None else {"version": version})
    folder = write_run(tmp_path / "run", scenario=scenario)
    assert info(scenario=scenario).scenario_label == label
    text = " ".join(as_text(build_report([folder], tmp_path).tables(), 200).split())
    assert label in text
    assert ("definition 1" in text) == (version is None)
