"""The 49 objects of graded difficulty: what they are, that the generator makes them, and who tries them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from grasp_bench import api
from grasp_bench.errors import GraspBenchError
from grasp_bench.objects.catalog import Catalog
from grasp_bench.objects.difficulty import check_graded, difficulty_of
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.scenario.reading import load_scenario, parse_scenario
from grasp_bench.scenario.robots import with_gripper
from grasp_bench.studies.rank import score_for
from grasp_bench.trials.trial import run_trial
from grasp_bench.trials.workcell import Workcell
from grasp_bench.workshop import difficulty, grid
from grasp_bench.workshop.build import fingerprint

NAMES = Catalog().select("grid")


def test_there_are_seven_sizes_of_seven_grades() -> None:
    catalog = Catalog()
    assert sorted(NAMES) == [f"grid_{g}{s}" for g in grid.GRADES for s in range(1, 8)]
    assert [len(row) for row in grid.DRAWS] == [7] * 7
    for name in NAMES:
        size = int(name[-1]) - 1
        smallest = min(catalog.entries[name]["extents"])
        assert smallest == pytest.approx(PARALLEL_85.opening * grid.SIZES[size], abs=1e-3), name
    assert (grid.SIZES[0], grid.SIZES[-1]) == (0.40, 0.95)


def test_all_and_table4_do_not_mean_them() -> None:
    catalog = Catalog()
    assert len(catalog.names) == 180
    assert catalog.select("all") == catalog.names == catalog.chosen([])
    assert not set(catalog.names) & set(NAMES)
    assert catalog.chosen(["grid_a1", "apple"]) == ["apple", "grid_a1"]
    assert len(catalog.select("grade_a,apple")) == 8
    assert api.select_objects(list(load_scenario("grid").objects.names))[1] == NAMES
    assert api.select_objects(list(load_scenario("table4").objects.names) or "all")[1] == catalog.names


def test_a_folder_of_nothing_else_means_them_all(tmp_path: Path) -> None:
    text = (Catalog().folder / "manifest.json").read_text().splitlines()
    lines = [line.rstrip(",") for line in text if '"name": "grid_' in line]
    (tmp_path / "manifest.json").write_text('{"version": 1, "objects": [' + ",".join(lines) + "]}")
    assert Catalog(tmp_path).names == NAMES


def test_their_files_are_small_and_as_the_manifest_says() -> None:
    catalog = Catalog()
    assert [f for n in NAMES for f in catalog.faults(n)] == []
    files = [f for n in NAMES for f in (catalog.folder / n).iterdir()]
    assert sum(f.stat().st_size for f in files) < 10e6


@pytest.mark.parametrize("name", ["grid_a1", "grid_d4", "grid_g7"])
def test_the_generator_makes_them_again(name: str) -> None:
    import json

    size, grade = int(name[-1]) - 1, grid.GRADES.index(name[-2])
    spec = grid.spec(size, grade, grid.DRAWS[size][grade])
    assert spec.name == name
    details = json.loads((Catalog().folder / name / "object.json").read_text())
    assert spec.mass == details["mass"]
    assert spec.source == details["source"]
    assert float(min(np.ptp(spec.build()[0].mesh.vertices, axis=0))) == pytest.approx(
        1000 * min(details["extents"]), abs=0.02
    )
    assert len(fingerprint(spec.build(), spec)) == 64


def test_they_differ_by_difficulty() -> None:
    known = {n: difficulty_of(Catalog().entries[n]) for n in NAMES}
    failing = np.array([d.failing for d in known.values() if d])
    assert len(failing) == 49
    assert failing.min() < grid.AIMS[0]
    assert failing.max() > 0.9
    assert np.ptp(failing) > 0.6
    assert all(d and d.tried >= difficulty.TRIES / 2 and d.gripper == "parallel-85" for d in known.values())


def test_a_difficulty_is_measured_alike_again() -> None:
    model, told = Catalog().load("grid_a1"), difficulty_of(Catalog().entries["grid_a1"])
    assert told is not None
    again = difficulty.measure(model)
    # Physics differs in the last digits between processors, so that single tries may end otherwise.
    assert again["tried"] == told.tried
    assert again["held"] == pytest.approx(told.held, abs=6)


def test_the_oracle_lifts_one() -> None:
    from grasp_bench.predictors import load_predictor

    cell = Workcell(load_scenario("grid"))
    assert run_trial(cell, Catalog().load("grid_a1"), load_predictor("oracle")).record.success


def test_a_gripper_that_did_not_measure_is_refused(tmp_path: Path) -> None:
    other = with_gripper(load_scenario("grid"), "parallel-50")
    with pytest.raises(
        GraspBenchError, match=r"measured with gripper parallel-85, and tells nothing of parallel-50"
    ):
        api.run(scenario=other, predictor="oracle", out=tmp_path / "run", progress=False)
    assert not (tmp_path / "run").exists()


def test_objects_without_a_difficulty_are_refused(tmp_path: Path) -> None:
    with pytest.raises(
        GraspBenchError, match=r"difficulty of apple and 1 more was not measured.*--objects grid"
    ):
        api.run(
            ["grid_a1", "apple", "banana"], scenario="grid", predictor="oracle", out=tmp_path, progress=False
        )
    with pytest.raises(GraspBenchError, match="difficulty of apple was not measured"):
        score_for(load_scenario("table4"), "difficulty", Catalog(), ["apple"])


def test_difficulty_as_a_score() -> None:
    from made_up_runs import record

    from grasp_bench.runs.record import TrialRecord

    score = score_for(load_scenario("grid"), "difficulty", Catalog(), NAMES)
    known = check_graded(load_scenario("grid"), Catalog(), NAMES)
    hardest = max(known, key=lambda n: known[n])
    won, lost = (TrialRecord.read(record(0, success, (hardest,))) for success in (True, False))
    assert score.of(won) == known[hardest]
    assert score.of(lost) == 0


def test_the_scenario_is_table4_otherwise() -> None:
    plain, made = (load_scenario(n).model_dump() for n in ("table4", "grid"))
    assert {k for k in plain if plain[k] != made[k]} == {"name", "description", "objects"}
    older = load_scenario("table4").model_dump(mode="json")
    del older["objects"]["graded"]
    assert parse_scenario(older, "run.json") == load_scenario("table4")
