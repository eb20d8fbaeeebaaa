"""Objects prepared for another gripper, and runs with it."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

import grasp_bench as gb
from grasp_bench.cli import main
from grasp_bench.errors import AssetError, GraspBenchError, ScenarioError
from grasp_bench.objects.catalog import Catalog, ObjectModel
from grasp_bench.objects.fitted import fit_file, fitted, graspable
from grasp_bench.robot.grippers import load_gripper
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.workshop.fitting import fit, prepare

OTHER = """
extends: table4
name: other
robot: {gripper: parallel-50}
"""


@pytest.fixture(autouse=True)
def _own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GRASP_BENCH_CACHE", str(tmp_path / "cache"))


@pytest.fixture
def scenario(tmp_path: Path) -> str:
    path = tmp_path / "other.yaml"
    path.write_text(OTHER)
    return str(path)


def test_the_reference_gripper_takes_the_objects_as_they_are(models: dict[str, ObjectModel]) -> None:
    assert fitted(models["block"], PARALLEL_85) is models["block"]
    assert graspable(Catalog(), ["coffee_mug"], PARALLEL_85) == (["coffee_mug"], [])


def test_fitted_grasps_open_no_wider_than_the_gripper() -> None:
    gripper, model = load_gripper("parallel-50"), Catalog().load("coffee_mug")
    poses = fit(model, gripper)
    assert [p["height"] for p in poses] == [p.height for p in model.poses]
    widths = [g["width"] for p in poses for g in p["grasps"]]
    assert widths
    assert max(widths) <= gripper.opening + 1e-6


def test_a_run_says_what_is_missing_then_what_it_leaves_out(
    tmp_path: Path, scenario: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    catalog, out = Catalog(), tmp_path / "run"
    thin, thick = "hex_key", "juice_box"
    names = f"{thin},{thick}"
    with pytest.raises(AssetError, match="2 objects are not prepared for gripper parallel-50 yet"):
        gb.run(names, 2, "oracle", scenario, out=out, progress=False)
    gripper = load_gripper("parallel-50")
    assert dict(prepare(gripper, catalog.folder, [thin], workers=1)).keys() == {thin}
    model = catalog.load(thick)
    poses = [
        {"quaternion": list(p.quaternion), "height": p.height, "probability": p.probability, "grasps": []}
        for p in model.poses
    ]
    path = fit_file(gripper, model)
    path.write_text(json.dumps({"poses": poses}))
    monkeypatch.setattr(
        "sys.argv",
        ["grasp-bench", *"run --trials 1 --predictor oracle --workers 1 --objects".split(), names]
        + ["--scenario", scenario, "--out", str(out)],
    )
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 0
    said = capsys.readouterr().out
    assert "Left out" in said
    assert thick in said
    run = gb.load(out)
    assert [r.object for r in run.records] == [thin]
    assert run.lifted.successes == 1
    assert run.info.robot is not None
    assert run.info.robot["gripper"] == {"name": "parallel-50", "digest": gripper.digest}
    assert run.records[0].pose is not None
    assert run.records[0].pose.opening <= gripper.opening
    with pytest.raises(GraspBenchError, match=f"parallel-50 can grasp none of {thick}"):
        gb.run(thick, 1, "oracle", scenario, out=tmp_path / "none", progress=False)
    path.write_text("{")
    with pytest.raises(AssetError, match="is damaged"):
        gb.run(thick, 1, "oracle", scenario, out=tmp_path / "none", progress=False)


def test_preparing_resumes_and_a_changed_gripper_is_another(tmp_path: Path) -> None:
    gripper, catalog = load_gripper("parallel-50"), Catalog()
    first = dict(prepare(gripper, catalog.folder, ["hex_key"], workers=1))
    path = fit_file(gripper, catalog.load("hex_key"))
    before = path.stat().st_mtime_ns
    assert dict(prepare(gripper, catalog.folder, ["hex_key"], workers=1)) == first
    assert path.stat().st_mtime_ns == before
    shutil.copytree(gripper.folder, tmp_path / "mine")
    same = load_gripper(str(tmp_path / "mine"))
    assert fit_file(same, catalog.load("hex_key")) == path
    facts = tmp_path / "mine" / "gripper.yaml"
    facts.write_text(facts.read_text().replace("speed: 0.15", "speed: 0.14"))
    load_gripper.cache_clear()
    assert fit_file(load_gripper(str(tmp_path / "mine")), catalog.load("hex_key")) != path


def test_a_workspace_out_of_reach_is_refused_with_numbers(tmp_path: Path) -> None:
    far = tmp_path / "far.yaml"
    far.write_text("extends: table4\ntable: {center: [0.9, 0]}\n")
    with pytest.raises(ScenarioError, match=r"reaches only 0 of 40 places .* from x = 0\.15 to 0\.80 m"):
        gb.run("hex_key", 1, "oracle", str(far), out=tmp_path / "run", progress=False)
    assert not (tmp_path / "run").exists()


def test_paths_in_a_scenario_are_relative_to_its_file(tmp_path: Path) -> None:
    shutil.copytree(load_gripper("parallel-140").folder, tmp_path / "mine")
    path = tmp_path / "own.yaml"
    path.write_text("extends: table4\nrobot: {gripper: ./mine}\n")
    assert load_scenario(str(path)).robot.loaded.gripper.opening == 0.14
