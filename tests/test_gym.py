"""The Gymnasium environment: its contract, and that it is the benchmark's own trial."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import grasp_bench as gb
from grasp_bench.errors import GraspBenchError, UnknownNameError
from grasp_bench.grasps import angle_difference
from grasp_bench.predictors.controls import Oracle

gymnasium = pytest.importorskip("gymnasium", reason="the extra gym is not installed")

from gymnasium.utils.env_checker import check_env  # noqa: E402

from grasp_bench.gym import ENV_ID, GraspEnv  # noqa: E402


@pytest.fixture
def env(toy_catalog: Path, scenario: gb.Scenario) -> Iterator[GraspEnv]:
    made = gymnasium.make(ENV_ID, objects=toy_catalog, scenario=scenario, size=160, render_mode="rgb_array")
    yield made.unwrapped
    made.close()


def test_it_keeps_gymnasiums_contract(env: GraspEnv) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", "(?s).*unconventional shape")  # depth is a picture without channels
        check_env(env, skip_render_check=True)


def test_the_same_seed_shows_the_same_objects_in_the_same_noise(env: GraspEnv) -> None:
    first, where = env.reset(seed=5)
    again, there = env.reset(seed=5)
    other, elsewhere = env.reset()
    assert where == there != elsewhere
    assert all(np.array_equal(first[k], again[k]) for k in first)
    assert not np.array_equal(first["depth"], other["depth"])
    assert first["rgb"].shape == (160, 160, 3)
    assert 0.4 < float(np.median(first["depth"])) < 0.56


def test_a_good_grasp_is_rewarded_and_a_bad_one_is_not(
    env: GraspEnv, models: dict[str, gb.ObjectModel], scenario: gb.Scenario
) -> None:
    _, info = env.reset(seed=1, options={"object": "block"})
    bound = gb.run_trial(gb.Workcell(scenario), models["block"], Oracle(), attempt=info["attempt"])
    best = bound.grasps[0]
    seen, reward, terminated, truncated, record = env.step(env.action(best))
    assert (reward, terminated, truncated) == (1.0, True, False)
    assert record["outcome"] == "success"
    assert bound.image is not None
    assert np.array_equal(seen["depth"], bound.image.depth[40:200, 80:240])  # the same trial, to the bit
    assert record["lift_height"] == pytest.approx(bound.record.to_json()["lift_height"], abs=0.002)
    picture = env.render()
    assert picture is not None
    assert picture.shape == (240, 320, 3)

    env.reset(options={"object": "block", "attempt": info["attempt"]})
    beside = env.action(gb.Grasp(best.x + 60, best.y, best.angle, best.width))
    *_, record = env.step(beside)
    assert record["outcome"] != "success"
    with pytest.raises(gymnasium.error.ResetNeeded, match="one grasp an episode"):
        env.step(beside)


@pytest.mark.parametrize("angle", [-1.5, -0.7, 0.0, 0.3, 1.2, np.pi / 2])
def test_actions_and_grasps_are_each_others_inverse(env: GraspEnv, angle: float) -> None:
    grasp = gb.Grasp(123.0, 97.0, angle, 31.0)
    back = env.grasp(env.action(grasp))
    assert (back.x, back.y, back.width) == pytest.approx((grasp.x, grasp.y, grasp.width), abs=1e-4)
    assert angle_difference(back.angle, angle) < 1e-6
    assert env.action_space.contains(env.action(gb.Grasp(-500, 900, 0, 1e4)))


def test_a_scenarios_own_set_of_objects_is_meant(toy_catalog: Path, scenario: gb.Scenario) -> None:
    own = scenario.model_copy(
        update={"objects": scenario.objects.model_copy(update={"folder": str(toy_catalog)})}
    )
    assert GraspEnv(["block"], own, size=160).reset(seed=0)[1]["object"] == "block"


def test_wrong_settings_are_refused(toy_catalog: Path, scenario: gb.Scenario) -> None:
    with pytest.raises(GraspBenchError, match="between 1 and 240"):
        GraspEnv(toy_catalog, scenario, size=241)
    with pytest.raises(UnknownNameError, match="Did you mean coffee_mug"):
        GraspEnv("coffee_mugg")
