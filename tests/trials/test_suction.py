"""Trials with a suction cup."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import grasp_bench as gb
from grasp_bench.grasps import Grasp
from grasp_bench.objects.catalog import Catalog
from grasp_bench.planning.refusals import Blocked
from grasp_bench.planning.seen import SeenScene
from grasp_bench.planning.suction import cup_pose
from grasp_bench.robot.cup import SuctionCup
from grasp_bench.robot.grippers import load_gripper
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.workshop.fitting import fit, prepare

SCENARIO = "extends: table4\nname: cup\nrobot: {gripper: suction-20}\ngripper: {force: 18.8}\n"


@pytest.fixture(autouse=True)
def _own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GRASP_BENCH_CACHE", str(tmp_path / "cache"))


def cup() -> SuctionCup:
    made = load_gripper("suction-20")
    assert isinstance(made, SuctionCup)
    return made


def test_a_cup_holds_a_box_and_not_a_key() -> None:
    catalog = Catalog()
    assert any(p["grasps"] for p in fit(catalog.load("juice_box"), cup()))
    assert not any(p["grasps"] for p in fit(catalog.load("hex_key"), cup()))


def test_the_oracle_lifts_and_the_displaced_cup_finds_nothing(tmp_path: Path) -> None:
    path = tmp_path / "cup.yaml"
    path.write_text(SCENARIO)
    list(prepare(cup(), Catalog().folder, ["juice_box"], workers=1))
    outcomes = {}
    for name in ("oracle", "displaced"):
        run = gb.run("juice_box", 2, name, str(path), out=tmp_path / name, progress=False, workers=1)
        outcomes[name] = {r.outcome for r in run.records}
    assert outcomes["oracle"] == {Outcome.SUCCESS}
    assert Outcome.SUCCESS not in outcomes["displaced"]


def test_of_a_planar_grasp_the_centre_counts() -> None:
    camera = load_scenario("table4").camera
    depth = np.full((camera.height, camera.width), 0.55, np.float32)
    depth[200:280, 280:360] = 0.50  # a plateau of 5 cm under the image's middle
    image = gb.RgbdImage(np.zeros((*depth.shape, 3), np.uint8), depth, camera.intrinsics)
    motion = load_scenario("table4").motion
    scene = SeenScene(image, camera.pose)
    poses = [
        cup_pose(scene, Grasp(320.0, 240.0, 0.3, width), motion, cup())[0] for width in (5.0, 40.0, 400.0)
    ]
    for pose in poses:
        np.testing.assert_allclose(pose.position, [0.5, 0.0, 0.05 - cup().cup.press], atol=1e-3)
        np.testing.assert_allclose(pose.rotation, poses[0].rotation, atol=1e-9)
    depth[230:250, 310:330] = 0
    with pytest.raises(Blocked, match="no depth was measured where the cup would go"):
        cup_pose(SeenScene(image, camera.pose), Grasp(320.0, 240.0, 0.3, 40.0), motion, cup())


def test_a_hand_stays_above_what_stands_beside_the_cup() -> None:
    camera = load_scenario("table4").camera
    depth = np.full((camera.height, camera.width), 0.55, np.float32)
    depth[200:280, 330:360] = 0.40  # a wall of 15 cm beside a place on the table
    image = gb.RgbdImage(np.zeros((*depth.shape, 3), np.uint8), depth, camera.intrinsics)
    motion = load_scenario("table4").motion
    with pytest.raises(Blocked, match="the hand would meet what is seen under it"):
        cup_pose(SeenScene(image, camera.pose), Grasp(310.0, 240.0, 0.0, 40.0), motion, cup())
