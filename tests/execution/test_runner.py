"""Runs: spread over objects, the same on any number of workers, resumed, and never lost to one trial."""

from __future__ import annotations

import json
import shutil
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grasp_bench.errors import AssetError, GraspBenchError, PredictorError, ResultsError
from grasp_bench.execution.describe import describe
from grasp_bench.execution.runner import run
from grasp_bench.objects.catalog import Catalog
from grasp_bench.runs.info import RunInfo
from grasp_bench.runs.jobs import Job, Settings, spread
from grasp_bench.scenario.sections import Scenario

OBJECTS = ["bar", "block", "pot"]


@given(st.integers(1, 30), st.integers(1, 200))
def test_trials_are_spread_evenly_and_number_each_objects_attempts(objects: int, trials: int) -> None:
    names = [f"o{i}" for i in range(objects)]
    jobs = spread(names, trials)
    assert [j.trial for j in jobs] == list(range(trials))
    counts = Counter(j.object for j in jobs)
    assert max(counts.values()) - min(counts[n] for n in names) <= 1
    for name, count in counts.items():
        assert [j.attempt for j in jobs if j.object == name] == list(range(count))


def test_an_added_object_changes_no_other_objects_attempts() -> None:
    assert spread(["a", "b"], 4)[2] == Job(2, "a", 1)
    assert spread(["a", "b", "c"], 6)[3] == Job(3, "a", 1)


@pytest.fixture(scope="module")
def settings(scenario: Scenario, toy_catalog: Path) -> Settings:
    return Settings(scenario, toy_catalog, "antipodal", 3, "raycast")


@pytest.fixture(scope="module")
def unbroken(settings: Settings, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of six trials on one worker."""
    out = tmp_path_factory.mktemp("unbroken")
    summary = run(settings, spread(OBJECTS, 6), out, 1)
    assert (summary.added, summary.resumed, summary.repaired) == (6, 0, False)
    return out


def lines(folder: Path) -> list[dict]:
    return [json.loads(line) for line in (folder / "trials.jsonl").read_text().splitlines()]


def test_a_run_has_one_line_a_trial_in_order(unbroken: Path) -> None:
    records = lines(unbroken)
    assert [r["trial"] for r in records] == list(range(6))
    assert [r["object"] for r in records] == OBJECTS * 2
    assert sum(r["success"] for r in records) >= 4
    assert {r["outcome"] for r in records}.isdisjoint({"error", "timeout", "unstable"})
    assert len((unbroken / "timings.jsonl").read_text().splitlines()) == 6


def test_two_attempts_on_an_object_are_not_the_same(unbroken: Path) -> None:
    first, second = (r for r in lines(unbroken) if r["object"] == "bar")
    assert first["grasp"] != second["grasp"]


def test_two_workers_write_the_same_bytes_as_one(settings: Settings, unbroken: Path, tmp_path: Path) -> None:
    seen: list[int] = []
    run(settings, spread(OBJECTS, 6), tmp_path, 2, lambda record, resumed: seen.append(record.trial))
    assert sorted(seen) == list(range(6))
    assert (tmp_path / "trials.jsonl").read_bytes() == (unbroken / "trials.jsonl").read_bytes()


def test_a_killed_run_resumes_to_the_same_bytes(settings: Settings, unbroken: Path, tmp_path: Path) -> None:
    out = tmp_path / "killed"
    shutil.copytree(unbroken, out)
    whole = (out / "trials.jsonl").read_text().splitlines(keepends=True)
    # As two workers leave it when they are killed: out of order, the last line torn.
    (out / "trials.jsonl").write_text(whole[2] + whole[0] + whole[4] + whole[1][:50])
    seen: dict[int, bool] = {}
    summary = run(
        settings, spread(OBJECTS, 6), out, 1, lambda record, resumed: seen.update({record.trial: resumed})
    )
    assert (summary.resumed, summary.added, summary.repaired) == (3, 3, True)
    assert seen == {0: True, 1: False, 2: True, 3: False, 4: True, 5: False}
    assert (out / "trials.jsonl").read_bytes() == (unbroken / "trials.jsonl").read_bytes()


def test_a_run_killed_after_its_last_trial_is_put_in_order(
    settings: Settings, unbroken: Path, tmp_path: Path
) -> None:
    out = tmp_path / "killed"
    shutil.copytree(unbroken, out)
    whole = (out / "trials.jsonl").read_text().splitlines(keepends=True)
    (out / "trials.jsonl").write_text("".join(whole[::-1]))
    assert run(settings, spread(OBJECTS, 6), out, 1).added == 0
    assert (out / "trials.jsonl").read_bytes() == (unbroken / "trials.jsonl").read_bytes()


def test_a_finished_run_is_left_as_it_is(settings: Settings, unbroken: Path) -> None:
    before = {p.name: (p.read_bytes(), p.stat().st_mtime_ns) for p in unbroken.iterdir()}
    summary = run(settings, spread(OBJECTS, 6), unbroken, 1)
    assert (summary.resumed, summary.added) == (6, 0)
    assert {p.name: (p.read_bytes(), p.stat().st_mtime_ns) for p in unbroken.iterdir()} == before


def test_another_object_changes_no_other_trial(settings: Settings, unbroken: Path, tmp_path: Path) -> None:
    run(settings, spread(["bar", "block"], 3), tmp_path / "fewer", 1)

    def without_number(records: list[dict]) -> list[dict]:
        return [{k: v for k, v in r.items() if k != "trial"} for r in records]

    more = [r for r in lines(unbroken) if r["object"] != "pot"]
    assert without_number(lines(tmp_path / "fewer")) == without_number(more)[:3]


def test_a_run_that_differs_is_refused(settings: Settings, unbroken: Path) -> None:
    with pytest.raises(ResultsError, match="number of trials"):
        run(settings, spread(OBJECTS, 7), unbroken, 1)


def test_a_trial_that_hangs_or_kills_its_worker_is_recorded_and_the_run_goes_on(
    settings: Settings, scenario: Scenario, tmp_path: Path
) -> None:
    quick = scenario.model_copy(update={"trial_timeout": 25.0})
    harsh = Settings(quick, settings.objects, "fake_predictors:ByColour", 0, "raycast")
    run(harsh, spread(["block", "pot", "bar"], 3), tmp_path, 1)
    hung, died, fine = lines(tmp_path)
    assert (hung["object"], hung["outcome"], hung["detail"]) == ("block", "timeout", "no answer within 25 s")
    assert (died["object"], died["outcome"]) == ("pot", "error")
    assert "worker process died (exit code 7)" in died["detail"]
    assert (fine["object"], fine["outcome"]) == ("bar", "no_grasp")
    assert set(hung) == set(died) == set(fine)
    assert [hung["category"], died["category"]] == ["box", "pot"]


def test_what_defines_a_run_is_described(settings: Settings) -> None:
    catalog = Catalog(settings.objects)
    described = describe(settings, spread(OBJECTS, 6), catalog)
    assert RunInfo.read(json.loads(json.dumps(described.to_json()))) == described
    assert described.objects["pot"] == catalog.entries["pot"]["files"]
    assert described.scenario["camera"]["width"] == 320
    assert described.versions["mujoco"]
    assert (described.predictor, described.seed, described.trials) == ("antipodal", 3, 6)


# ---------------------------------------------------------------- refused before the first trial


@pytest.mark.parametrize(
    ("predictor", "message"),
    [
        ("fake_predictors:Unbuildable", "no weights here"),
        ("fake_predictors:Silent", "no method predict"),
        ("fake_predictors:Silnt", "Did you mean Silent"),
        ("no_such_module:Thing", "no_such_module"),
    ],
)
def test_an_unusable_predictor_is_refused(
    settings: Settings, tmp_path: Path, predictor: str, message: str
) -> None:
    bad = Settings(settings.scenario, settings.objects, predictor, 0, "raycast")
    with pytest.raises(PredictorError, match=message):
        run(bad, spread(OBJECTS, 3), tmp_path / "out", 1)
    assert not (tmp_path / "out").exists()


def test_damaged_objects_are_refused(settings: Settings, tmp_path: Path) -> None:
    shutil.copytree(settings.objects, tmp_path / "toys")
    (tmp_path / "toys" / "pot" / "collision.glb").write_bytes(b"glTF")
    bad = Settings(settings.scenario, tmp_path / "toys", "oracle", 0, "raycast")
    with pytest.raises(AssetError, match=r"pot.collision\.glb"):
        run(bad, spread(OBJECTS, 3), tmp_path / "out", 1)


def test_an_object_that_cannot_be_grasped_in_any_pose_is_refused(
    settings: Settings, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    load = Catalog.load
    monkeypatch.setattr(Catalog, "load", lambda self, name: replace(load(self, name), poses=()))
    with pytest.raises(GraspBenchError, match="bar has no resting pose"):
        run(settings, spread(OBJECTS, 3), tmp_path / "out", 1)
