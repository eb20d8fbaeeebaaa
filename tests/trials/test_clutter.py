"""Clearing a table of the three toys: what an episode does, records and reports."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull
from shapely import Polygon

from grasp_bench import api
from grasp_bench.camera import RgbdImage
from grasp_bench.grasps import Grasp
from grasp_bench.objects.catalog import Catalog, ObjectModel
from grasp_bench.predictors.controls import Oracle
from grasp_bench.report.clutter import attempts_in_words, clutter_table, in_words, summarise_clutter
from grasp_bench.report.table4 import build_report
from grasp_bench.report.tables import markdown
from grasp_bench.runs.jobs import Job
from grasp_bench.runs.record import EpisodeRecord
from grasp_bench.runs.statistics import Rate
from grasp_bench.scenario.reading import with_value
from grasp_bench.scenario.sections import Clutter, Scenario
from grasp_bench.scene.builder import compile_mjcf, compose_many, object_name
from grasp_bench.scene.world import UnstableError, World
from grasp_bench.trials import placing
from grasp_bench.trials.episode import run_episode
from grasp_bench.trials.placing import Resting, lay_out
from grasp_bench.trials.workcell import Workcell


@pytest.fixture(scope="module")
def crowd(scenario: Scenario) -> Scenario:
    """Two or three objects, two failures allowed."""
    small = Clutter(fewest=2, most=3, workspace=(0.08, 0.08), failures=2)
    return scenario.model_copy(update={"clutter": small})


def episode(crowd: Scenario, folder: Path, predictor: Any, **more: int) -> dict[str, Any]:
    asked = {"trial": 4, "attempt": 0, "seed": 1} | more
    job = Job(asked["trial"], "bar", asked["attempt"])
    return run_episode(Workcell(crowd), Catalog(folder), predictor, job, asked["seed"]).to_json()


class Nothing:
    def predict(self, image: RgbdImage) -> list[Grasp]:
        return []


class Beside:
    """Always grasps the same bare corner of the table."""

    def predict(self, image: RgbdImage) -> list[Grasp]:
        return [Grasp(30, 30, 0.0, 40, 1.0)]


def test_the_oracle_clears_the_table_and_does_it_alike_again(crowd: Scenario, toy_catalog: Path) -> None:
    record = episode(crowd, toy_catalog, Oracle())
    told = record["clutter"]
    assert (record["trial"], record["object"], record["outcome"]) == (4, "bar", "success")
    assert told["objects"][0] == "bar"
    assert len(set(told["objects"])) == len(told["objects"]) in (2, 3)
    assert told["cleared"] == len(told["objects"])
    removed = [n for a in told["attempts"] for n in a["removed"]]
    assert sorted(removed) == sorted(told["objects"])
    assert [a["attempt"] for a in told["attempts"]] == list(range(len(told["attempts"])))
    won = [a for a in told["attempts"] if a["success"]]
    assert all(a["object"] in a["removed"] and a["lift_height"] > 0.19 for a in won)
    assert record["sim_steps"] == sum(a["sim_steps"] for a in told["attempts"])
    assert json.dumps(episode(crowd, toy_catalog, Oracle())) == json.dumps(record)


def test_an_episode_ends_after_so_many_failures_in_a_row(crowd: Scenario, toy_catalog: Path) -> None:
    for predictor, outcome in ((Nothing(), "no_grasp"), (Beside(), "missed")):
        record = episode(crowd, toy_catalog, predictor)
        told = record["clutter"]
        assert [a["outcome"] for a in told["attempts"]] == [outcome, outcome]
        assert (record["outcome"], record["success"], told["cleared"]) == (outcome, False, 0)
        assert f"{len(told['objects'])} of {len(told['objects'])} objects left" in record["detail"]


def test_who_is_there_depends_on_lead_attempt_and_seed_alone(crowd: Scenario, toy_catalog: Path) -> None:
    drawn = [
        tuple(episode(crowd, toy_catalog, Nothing(), attempt=a, seed=s, trial=t)["clutter"]["objects"])
        for t, a, s in ((0, 0, 0), (9, 0, 0), (0, 1, 0), (0, 2, 0), (0, 0, 1), (0, 0, 2))
    ]
    assert drawn[0] == drawn[1]
    assert len(set(drawn)) > 1


def test_a_predictor_that_fails_ends_the_episode_as_an_error(crowd: Scenario, toy_catalog: Path) -> None:
    class Broken:
        def predict(self, image: RgbdImage) -> list[Grasp]:
            raise ZeroDivisionError("by nought")

    record = episode(crowd, toy_catalog, Broken())
    assert record["outcome"] == "error"
    assert "by nought" in record["detail"]
    assert len(record["clutter"]["attempts"]) == 1


def test_objects_that_never_rest_make_an_episode_unstable(crowd: Scenario, toy_catalog: Path) -> None:
    hasty = with_value(crowd, "settling.timeout", 0.021)
    record = episode(hasty, toy_catalog, Oracle())
    assert record["outcome"] == "unstable"
    assert f"in {placing.LAYOUTS} layouts" in record["detail"]
    assert (record["clutter"]["cleared"], record["clutter"]["attempts"]) == (0, [])


# ---------------------------------------------------------------- layouts


def outline(resting: Resting) -> Polygon:
    """Footprint of an object where it lies."""
    w, x, y, z = resting.quaternion
    turn = trimesh.transformations.quaternion_matrix([w, x, y, z])[:3, :3]
    cloud = (np.vstack(resting.model.hulls) @ turn.T + resting.position)[:, :2]
    return Polygon(cloud[ConvexHull(cloud).vertices])


def test_objects_are_put_beside_each_other_where_there_is_room(
    crowd: Scenario, models: dict[str, ObjectModel]
) -> None:
    wide = crowd.model_copy(update={"clutter": Clutter(workspace=(0.2, 0.2))})
    for seed in range(20):
        placed = placing._placed(list(models.values()), wide, np.random.default_rng(seed))
        prints = [outline(p) for p in placed]
        assert not any(a.intersects(b) for i, a in enumerate(prints) for b in prints[:i])
        for p in placed:
            assert np.abs(p.position[:2] - wide.table.center).max() <= 0.2


def test_objects_without_room_are_dropped_onto_the_others_and_come_to_rest(
    crowd: Scenario, models: dict[str, ObjectModel]
) -> None:
    narrow = crowd.model_copy(update={"clutter": Clutter(workspace=(0.0, 0.0))})
    rng = np.random.default_rng(3)
    placed = placing._placed(list(models.values()), narrow, rng)
    heights = [p.position[2] for p in placed]
    assert heights == sorted(heights)
    assert heights[2] > heights[0] + 0.05
    resting = lay_out(list(models.values()), narrow, rng)
    assert all(0.005 < r.position[2] < 0.2 for r in resting)


def test_a_layout_that_never_rests_is_refused(crowd: Scenario, models: dict[str, ObjectModel]) -> None:
    with pytest.raises(UnstableError, match="not at rest"):
        lay_out([models["pot"]], with_value(crowd, "settling.timeout", 0.021), np.random.default_rng(0))


def test_a_kept_table_is_as_one_compiled_anew_whatever_was_done_to_it(
    crowd: Scenario, models: dict[str, ObjectModel]
) -> None:
    left = [
        Resting(models[n], np.array([0.5, y, 0.1]), np.eye(4)[0]) for n, y in (("bar", -0.1), ("pot", 0.1))
    ]
    placing._compiled.cache_clear()
    first = placing.world_of(left, crowd)
    first.model.geom_friction[:] = 9.0
    again = placing.world_of(left, crowd)
    kept = placing._compiled.cache_info()
    assert (kept.misses, kept.hits) == (1, 1)
    fresh = compile_mjcf(compose_many(crowd, [r.model for r in left]))
    other = World(fresh, crowd, [object_name(i) for i in range(2)], [r.model.friction for r in left])
    for i in range(2):
        other.aim(i)
    np.testing.assert_array_equal(again.model.geom_friction, other.model.geom_friction)
    assert not (first.model.geom_friction == again.model.geom_friction).all()
    for others, scenario in ((left[::-1], crowd), (left, with_value(crowd, "gripper.friction_scale", 0.5))):
        misses = placing._compiled.cache_info().misses
        placing.world_of(others, scenario)
        assert placing._compiled.cache_info().misses == misses + 1, "another order, another scenario"


def test_pads_take_on_the_friction_of_the_target(crowd: Scenario, models: dict[str, ObjectModel]) -> None:
    pair = [models["bar"], models["block"]]
    world = World(
        compile_mjcf(compose_many(crowd, pair)),
        crowd,
        [object_name(0), object_name(1)],
        [m.friction for m in pair],
    )
    pads = world.model.geom_priority > 0
    assert pads.sum() >= 2
    for which, model in enumerate(pair):
        world.aim(which)
        assert world.model.geom_friction[pads, 0] == pytest.approx(model.friction)
        np.testing.assert_allclose(world.object_pose[0], world.data.xpos[world.bodies[which]])


# ---------------------------------------------------------------- runs and reports


def test_runs_of_clutter_are_recorded_resumed_and_reported(
    crowd: Scenario, toy_catalog: Path, tmp_path: Path
) -> None:
    out = tmp_path / "run"
    first = api.run(toy_catalog, 2, Nothing(), crowd, out=out, progress=False)
    lines = (out / "trials.jsonl").read_text()
    again = api.run(toy_catalog, 2, Nothing(), crowd, out=out, progress=False)
    assert (first.summary.added, again.summary.added, again.summary.resumed) == (2, 0, 2)
    assert (out / "trials.jsonl").read_text() == lines
    assert set(again.info.objects) == {"bar", "block", "pot"}
    report = build_report([out], tmp_path)
    assert [row for row in report.rows if row.source == "simulation"] == []
    figures = report.runs[0].clutter
    assert figures is not None
    assert figures.attempts.trials == 4
    assert "tables emptied 0/2 = 0.0%" in markdown(report.tables())


def test_figures_over_episodes_are_added_up() -> None:
    attempts = [
        {"attempt": i, "object": "a", "category": "toys", "outcome": outcome}
        for i, outcome in enumerate(["success", "success", "success", "missed"])
    ]
    figures = summarise_clutter(
        [
            EpisodeRecord.read({"objects": list("abc"), "cleared": 3, "attempts": attempts}),
            EpisodeRecord.read({"objects": list("abcde"), "cleared": 1, "attempts": attempts[2:]}),
        ],
        3,
    )
    assert (figures.attempts, figures.cleared, figures.emptied) == (Rate(4, 6), Rate(4, 8), Rate(1, 3))
    assert figures.by_attempt == (Rate(2, 2), Rate(1, 2), Rate(1, 1), Rate(0, 1))
    assert attempts_in_words(figures) == "1: 2/2, 2: 1/2, 3: 1/1, 4: 0/1"
    assert figures.outcomes == {"success": 4, "missed": 2}
    low, high = figures.cleared_interval
    assert low <= 1 / 5, "a table is worth one draw, however many objects it has"
    assert high == 1.0
    assert f"objects cleared 4/8 = 50.0% ({low:.1%} – {high:.1%})" in in_words(figures)
    assert summarise_clutter([], 2).attempts == Rate(0, 0)


def test_intervals_are_as_wide_as_tables_differ() -> None:
    def episode(outcomes: str) -> EpisodeRecord:
        attempts = [
            {"attempt": i, "object": "a", "category": "toys", "outcome": "success" if o == "+" else "missed"}
            for i, o in enumerate(outcomes)
        ]
        return EpisodeRecord.read(
            {"objects": ["a"] * 4, "cleared": outcomes.count("+"), "attempts": attempts}
        )

    alike = summarise_clutter([episode("++-+-")] * 20, 20)
    apart = summarise_clutter([episode("++++")] * 12 + [episode("-----")] * 8, 20)
    assert alike.attempts_interval == pytest.approx(alike.attempts.interval), "never narrower than Wilson's"
    low, high = apart.attempts_interval
    assert high - low > 1.5 * (apart.attempts.interval[1] - apart.attempts.interval[0])
    rows = clutter_table([("alike", alike), ("apart", apart)]).rows
    assert [(row[0], row[1], row[4]) for row in rows] == [
        ("alike", "60/100", "60/80"),
        ("apart", "48/88", "48/80"),
    ]
