"""Why trials failed: planted faults are named, replays are exact, resumed and defended."""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from grasp_bench.camera import RgbdImage
from grasp_bench.errors import GraspBenchError, ResultsError, ScenarioError
from grasp_bench.execution.here import Here
from grasp_bench.execution.runner import run
from grasp_bench.grasps import Grasp, wrap_angle
from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.planning.heightfield import finger_room
from grasp_bench.predictors import load_predictor
from grasp_bench.predictors.controls import Antipodal
from grasp_bench.predictors.protocol import GroundTruth
from grasp_bench.predictors.trust import UntrustedError
from grasp_bench.robot.robot import EC66_PARALLEL_85
from grasp_bench.runs.folder import load_records
from grasp_bench.runs.jobs import Settings, spread
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.sections import Calibration, Execution, Scenario
from grasp_bench.scene.builder import OBJECT, compile_scene
from grasp_bench.scene.world import World
from grasp_bench.studies.why import examine as examining
from grasp_bench.studies.why.counterfactual import alter, easier, thinner
from grasp_bench.studies.why.explain import Study, explain
from grasp_bench.studies.why.replaced import Replaced, Turned, nearest
from grasp_bench.studies.why.told import Pages, sentence, tables, to_json
from tests.conftest import Ended

TRIALS = 15
NAMES = ["bar", "block", "pot"]


class Faulty(Antipodal):
    """The heuristic with a fault: all angles turned, or all widths too small. Nothing else is random."""

    def __init__(self, turn: float = 0.0, narrow: float = 1.0) -> None:
        self._turn, self._narrow = turn, narrow
        self.asked = 0

    def predict(self, image: RgbdImage) -> list[Grasp]:
        self.asked += 1
        return [
            replace(g, angle=wrap_angle(g.angle + self._turn), width=self._narrow * g.width)
            for g in super().predict(image)
        ]


@pytest.fixture(scope="module")
def alone(scenario: Scenario) -> Scenario:
    """Grasps are carried out as predicted."""
    return scenario.model_copy(update={"execution": Execution(protocol="as-predicted")})


@pytest.fixture(scope="module")
def run_of(toy_catalog: Path, tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """Makes a run of the toys with a predictor in this process."""

    def make(scenario: Scenario, predictor: Faulty, trials: int = TRIALS) -> Path:
        out = tmp_path_factory.mktemp("why") / "some run"
        settings = Settings(scenario, toy_catalog.resolve(), "antipodal", 3, "raycast")
        run(settings, spread(NAMES, trials), out, 1, executor=Here(predictor))
        return out

    return make


@pytest.fixture(scope="module")
def lifted(alone: Scenario, run_of: Callable[..., Path]) -> set[int]:
    """Trials in which the sound predictor succeeds."""
    found = {r.trial for r in load_records(run_of(alone, Faulty())) if r.success}
    assert len(found) >= TRIALS // 2
    return found


@pytest.fixture(scope="module")
def turned(alone: Scenario, run_of: Callable[..., Path], toy_catalog: Path) -> tuple[Path, Study]:
    """A run whose angles are 30° wrong, and its explanation."""
    predictor = Faulty(turn=math.radians(30))
    folder = run_of(alone, predictor)
    return folder, explain(folder, objects=toy_catalog, predictor=predictor)


def _named(study: Study, lifted: set[int], cause: str) -> tuple[int, int]:
    added = [e for e in study.explained if e.trial in lifted]
    return sum(study.first(e) == cause for e in added), len(added)


def test_a_planted_angle_is_named_first(turned: tuple[Path, Study], lifted: set[int]) -> None:
    folder, study = turned
    named, added = _named(study, lifted, "angle")
    assert added >= 4
    assert named >= 0.9 * added
    assert study.left_out == {}
    outcomes = {json.loads(line)["outcome"] for line in (folder / "why.jsonl").read_text().splitlines()}
    assert "success" in outcomes
    assert "error" not in outcomes  # as a replay that breaks ends


def test_a_planted_width_is_named_first(
    alone: Scenario, run_of: Callable[..., Path], toy_catalog: Path, lifted: set[int]
) -> None:
    predictor = Faulty(narrow=0.6)
    study = explain(run_of(alone, predictor), objects=toy_catalog, predictor=predictor)
    named, added = _named(study, lifted, "width")
    assert added >= 4
    assert named >= 0.9 * added


def test_a_planted_calibration_error_is_named_first(
    alone: Scenario, run_of: Callable[..., Path], toy_catalog: Path
) -> None:
    sound = Faulty()
    lifted = {r.trial for r in load_records(run_of(alone, sound, 20)) if r.success}
    planted = alone.model_copy(update={"calibration": Calibration(position_mm=10.0)})
    study = explain(run_of(planted, sound, 20), objects=toy_catalog, predictor=sound)
    named, added = _named(study, lifted, "calibration")
    assert added >= 3
    assert named >= 0.9 * added
    # Without the error a trial is the sound one, so that it succeeds just where that does.
    saved = {e.trial for e in study.explained if frozenset({"calibration"}) in e.sets}
    assert saved == {e.trial for e in study.explained if e.trial in lifted}


def test_it_goes_on_where_it_stopped_and_damage_costs_one_replay(
    turned: tuple[Path, Study], toy_catalog: Path, tmp_path: Path
) -> None:
    folder, study = turned
    lines = (folder / "why.jsonl").read_text().splitlines(keepends=True)
    file = tmp_path / "why.jsonl"
    file.write_text("".join(lines))
    idle = Faulty(turn=math.radians(30))
    assert explain(folder, out=file, objects=toy_catalog, predictor=idle).explained == study.explained
    assert idle.asked == 0
    assert file.read_text() == "".join(lines)
    stranger = json.loads(lines[1]) | {"of": "0" * 16, "outcome": "success"}
    noise = ["{}\n", "not JSON\n", "\xff\n", json.dumps(stranger) + "\n", lines[-1][:20]]
    file.write_text("".join([*lines[:-1], *noise]), encoding="latin-1")
    again = explain(folder, out=file, objects=toy_catalog, predictor=idle)
    assert again.explained == study.explained
    assert again.damaged == 4  # the stranger's line is sound, and of no use
    assert file.read_text(encoding="latin-1").endswith(f"{lines[-1][:20]}\n{lines[-1]}")


def test_a_trial_that_does_not_come_out_as_recorded_is_left_out(
    turned: tuple[Path, Study], toy_catalog: Path, tmp_path: Path
) -> None:
    folder, study = turned
    copy = tmp_path / "copy"
    shutil.copytree(folder, copy, ignore=shutil.ignore_patterns("why.jsonl"))
    kept = study.explained[0].trial
    records = [json.loads(line) for line in (copy / "trials.jsonl").read_text().splitlines()]
    chosen = [r for r in records if r["trial"] == kept]
    chosen[0]["contact_force"] += 1.0
    errors = [r for r in records if r["success"]][:1]
    errors[0] |= {"outcome": "error", "success": False}
    (copy / "trials.jsonl").write_text("".join(json.dumps(r) + "\n" for r in [*chosen, *errors]))
    again = explain(copy, objects=toy_catalog, predictor=Faulty(turn=math.radians(30)))
    assert again.explained == ()
    assert "not come out as recorded" in again.left_out[kept]
    assert "fault of the harness" in again.left_out[errors[0]["trial"]]
    said = tables(again)[0].lead
    assert f"not finished: 2 of {TRIALS} trials" in said
    assert "Left out: 1 (trial" in said
    assert sentence(again) == "None of 2 failures could be explained."


def test_clutter_other_definitions_and_strangers_are_refused(
    turned: tuple[Path, Study], toy_catalog: Path, tmp_path: Path
) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(turned[0], copy)
    before = (copy / "why.jsonl").read_bytes()
    info = json.loads((copy / "run.json").read_text())

    def changed(**values: Any) -> Path:
        (copy / "run.json").write_text(json.dumps(info | values))
        return copy

    with pytest.raises(GraspBenchError, match="episodes of clutter"):
        explain(changed(scenario=info["scenario"] | {"clutter": {"fewest": 5}}), objects=toy_catalog)
    with pytest.raises(ScenarioError, match="version 1 of the definition"):
        explain(changed(scenario=info["scenario"] | {"version": 1}), objects=toy_catalog)
    with pytest.raises(UntrustedError, match="--trust"):
        explain(changed(predictor="my_module:Mine"), objects=toy_catalog)
    with pytest.raises(ResultsError, match=r"no run\.json"):
        explain(tmp_path)
    assert (copy / "why.jsonl").read_bytes() == before


def test_a_link_in_the_place_of_the_file_is_refused(
    turned: tuple[Path, Study], toy_catalog: Path, tmp_path: Path
) -> None:
    link = tmp_path / "why.jsonl"
    link.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(ResultsError, match="is a link"):
        explain(turned[0], out=link, objects=toy_catalog, predictor=Faulty())


def test_what_is_told(turned: tuple[Path, Study]) -> None:
    folder, study = turned
    assert sum(study.shares.values()) == pytest.approx(len(study.explained))
    assert " % of your losses are angle" in sentence(study)
    pages = Pages(folder)
    data = to_json(study, pages)
    first = data["explanations"][0]
    assert first["page"] == f"{folder}/report.html#some%20run/{first['trial']}"
    assert sum(c["named_first"] for c in data["causes"]) == data["explained"] == len(study.explained)
    assert Pages(folder, folder.parent / "all.html").of(3) == f"{folder.parent}/all.html#some%20run/3"
    with pytest.raises(GraspBenchError, match="no report of"):
        Pages(folder, folder / "below" / "report.html")


def test_the_command_explains_a_run_on_worker_processes(
    alone: Scenario, toy_catalog: Path, tmp_path: Path, cli: Callable[[str], Ended]
) -> None:
    hard = alone.model_copy(update={"gripper": alone.gripper.model_copy(update={"friction_scale": 0.004})})
    settings = Settings(hard, toy_catalog.resolve(), "centroid", 3, "raycast")
    folder = tmp_path / "slippery"
    run(settings, spread(["bar"], 1), folder, 1, executor=Here(load_predictor("centroid")))
    done = cli(f"why {folder} --workers 1 --json --objects {toy_catalog}")
    assert done.code == 0, done.err
    data = json.loads(done.out)
    assert [(e["outcome"], e["first"]) for e in data["explanations"]] == [("slipped", "unexplained")]
    assert data["explanations"][0]["replays"] <= 81
    lines = [json.loads(line) for line in (folder / "why.jsonl").read_text().splitlines()]
    assert len(lines) == data["explanations"][0]["replays"]
    assert {x["outcome"] for x in lines} <= {"slipped", "dropped", "missed", "blocked", "approach_collision"}
    shown = cli(f"why {folder} --workers 1 --objects {toy_catalog}")
    assert shown.code == 0, shown.err
    assert "100 % of your losses are none of these" in shown.out
    assert f"{folder}/report.html#slippery/0" in shown.out


# ---------------------------------------------------------------- interventions


def test_a_replay_differs_in_what_was_removed_only(scenario: Scenario) -> None:
    lit = scenario.model_copy(
        update={
            "light": scenario.light.model_copy(update={"level": 0.3}),
            "calibration": Calibration(position_mm=5.0),
        }
    )
    same = easier(lit, frozenset())
    assert same == lit
    depth, colours = easier(lit, frozenset({"depth"})), easier(lit, frozenset({"colours"}))
    assert (depth.sensor.axial_sigma, depth.sensor.edge_dropout, depth.sensor.rgb_sigma) == (0, 0, 2.0)
    assert (colours.sensor.axial_sigma, colours.sensor.rgb_sigma, colours.light.level) == (0.0005, 0, 1.0)
    assert depth.light == lit.light
    assert easier(lit, frozenset({"calibration"})).calibration.exact
    assert not easier(lit, frozenset({"help"})).execution.assisted
    both = easier(lit, frozenset({"depth", "colours"})).sensor
    ideal = type(both)(preset="ideal")
    assert both.model_dump(exclude={"preset"}) == ideal.model_dump(exclude={"preset"})


def test_friction_mass_and_fingers_change_in_the_compiled_model(
    scenario: Scenario, models: dict[str, ObjectModel]
) -> None:
    robot, block = EC66_PARALLEL_85, models["block"]
    before, after = (compile_scene(scenario, block) for _ in range(2))
    alter(after, robot, frozenset({"friction", "mass", "fingers"}))
    pad = robot.gripper_prefix + robot.gripper.pads[0]
    assert after.geom(pad).friction[0] == pytest.approx(2 * before.geom(pad).friction[0])
    assert after.geom(pad).friction[1] == before.geom(pad).friction[1]
    assert after.body(OBJECT).mass[0] == pytest.approx(block.mass / 2)
    np.testing.assert_allclose(after.body(OBJECT).inertia, before.body(OBJECT).inertia / 2)
    np.testing.assert_array_equal(after.geom(pad).size, before.geom(pad).size)
    blade = robot.gripper_prefix + "left_blade"
    outside = [m.geom(blade).pos[0] + m.geom(blade).size[0] for m in (before, after)]
    assert outside == pytest.approx([0.008, 0.004])
    thin = thinner(robot)
    assert thin.gripper.finger_thickness == pytest.approx(outside[1])
    assert finger_room(thin.gripper) < finger_room(robot.gripper)
    World(after, scenario, robot=thin).settle  # noqa: B018 - it still is a world of the robot


def _grasp(x: float, y: float, angle: float, width: float) -> Grasp:
    return Grasp(x, y, angle, width)


def test_the_nearest_reference_is_nearest_in_what_stays() -> None:
    near, alike = _grasp(101, 100, 1.0, 40), _grasp(120, 100, 0.1, 40)
    asked = _grasp(100, 100, 0.1, 40)
    assert nearest(asked, [alike, near], frozenset({"angle"}), 1.7) == near
    assert nearest(asked, [alike, near], frozenset({"place"}), 1.7) == alike


def test_only_the_named_parts_are_replaced(models: dict[str, ObjectModel], scenario: Scenario) -> None:
    class Says:
        def predict(self, image: RgbdImage) -> list[Grasp]:
            return [_grasp(10, 10, 0.3, 12)]

    class Nothing:
        def predict(self, image: RgbdImage) -> list[Grasp]:
            return []

    block, camera = models["block"], scenario.camera
    pose = block.graspable_poses[0]
    position = np.array([0.5, 0.0, pose.height])
    truth = GroundTruth(block, position, pose.rotation, camera.pose, camera.intrinsics)
    size = camera.intrinsics
    image = RgbdImage(
        np.zeros((size.height, size.width, 3), np.uint8), np.ones((size.height, size.width), np.float32), size
    )
    parts = [frozenset({"place"}), frozenset({"angle"})]
    place, angle = (Replaced(Says(), p).predict_from_truth(image, truth)[0] for p in parts)
    assert (place.angle, place.width) == (0.3, 12)
    assert (angle.x, angle.y, angle.width) == (10, 10, 12)
    assert place.x != 10
    assert angle.angle != 0.3
    turned = Turned(Says(), 0.2).predict_from_truth(image, truth)
    assert [(g.x, g.y, g.angle, g.width) for g in turned] == [(10, 10, pytest.approx(0.5), 12)]
    whole = frozenset({"place", "angle", "width"})
    assert Replaced(Nothing(), frozenset({"place"})).predict_from_truth(image, truth) == []
    assert len(Replaced(Nothing(), whole).predict_from_truth(image, truth)) == len(pose.grasps)


def test_a_replay_that_breaks_saves_nothing(
    turned: tuple[Path, Study], toy_catalog: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, study = turned
    without = examining.Counterfactuals.without

    def broken(self: Any, removed: frozenset[str]) -> Any:
        if removed == {"angle"}:
            raise ZeroDivisionError
        return without(self, removed)

    monkeypatch.setattr(examining.Counterfactuals, "without", broken)
    copy = tmp_path / "copy"
    shutil.copytree(folder, copy, ignore=shutil.ignore_patterns("why.jsonl"))
    kept = next(e for e in study.explained if frozenset({"angle"}) in e.sets).trial
    records = [json.loads(line) for line in (copy / "trials.jsonl").read_text().splitlines()]
    text = "".join(json.dumps(r) + "\n" for r in records if r["trial"] == kept)
    (copy / "trials.jsonl").write_text(text)
    again = explain(copy, objects=toy_catalog, predictor=Faulty(turn=math.radians(30)))
    assert frozenset({"angle"}) not in again.explained[0].sets
    lines = [json.loads(line) for line in (copy / "why.jsonl").read_text().splitlines()]
    assert [x["outcome"] for x in lines if x["without"] == ["angle"]] == [Outcome.ERROR]
    assert again.broken == {kept: 1}
    assert f"1 replays of 1 trials ({kept}) could not be done" in tables(again)[0].note
    recalled = explain(copy, objects=toy_catalog, predictor=Faulty(turn=math.radians(30)))
    assert to_json(recalled, Pages(copy))["broken_replays"] == {str(kept): 1}
