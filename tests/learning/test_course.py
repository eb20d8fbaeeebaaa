"""When a training ends, and the held-out grasps in physics that decide it."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
import torch
from test_training import FAST, folder  # noqa: F401 (eight synthetic scenes)
from torch import Tensor, nn

from grasp_bench.grasps import Grasp
from grasp_bench.learning.data.scenes import load_scenes
from grasp_bench.learning.training import loop
from grasp_bench.learning.training.config import TrainConfig
from grasp_bench.learning.training.course import Course
from grasp_bench.learning.training.held_out import HeldOut, count_held, held_out_scenes
from grasp_bench.learning.training.loop import train
from grasp_bench.learning.training.validate import Accuracy, evenly

SHARES = [20, 60, 80, 81, 79, 82, 80, 95]


def run(config: TrainConfig, shares: list[int], minutes: float = 1.0) -> Course:
    """Go through a run of a validation each ten steps, each of which takes ``minutes``."""
    course = Course(config)
    for i, held in enumerate(shares, 1):
        course.reached(10 * i, 60 * minutes * i)
        course.validated(10 * i, 60 * minutes * i, Accuracy(held=held, tried=100))
    return course


def test_a_run_is_flat_once_nothing_above_the_noise_is_gained() -> None:
    """80 of 100 have a standard error of 4."""
    config = TrainConfig(steps=10_000, until_flat=True, patience=3, warmup=0, lr=1.0)
    assert [run(config, SHARES[:n]).falling for n in range(1, 8)] == [None] * 5 + [60, 60]
    course = run(config, SHARES[:6])
    assert (course.why, course.end) == ("flat", 75)
    assert course.rate(59) == 1.0
    assert [course.rate(i) for i in (60, 67.5, 75)] == pytest.approx([1, 0.5, 0])  # type: ignore[arg-type]
    assert run(config, [60, 65, 70, 75, 80, 85]).falling is None
    assert run(config, [0, 0, 0, 0, 0, 0]).falling is None, "what has not begun is not flat"
    assert "75 steps" in course.told()
    assert "3 validations" in course.told()


def test_the_clock_and_the_steps_leave_room_for_the_fall() -> None:
    config = TrainConfig(steps=10_000, max_minutes=10, warmup=0)
    course = run(config, SHARES)
    assert (course.falling, course.why, course.end) == (80, "minutes", 100)
    assert "not known to have flattened" in course.told()
    course = run(config.model_copy(update={"steps": 80}), SHARES)
    assert (course.falling, course.why, course.end) == (70, "steps", 80)
    assert Course(TrainConfig(steps=80)).end == 80


def test_a_run_of_given_steps_has_its_cosine() -> None:
    config = TrainConfig(steps=100, warmup=10)
    course = run(config, SHARES, minutes=100)
    assert course.falling is None
    assert [course.rate(s) for s in range(100)] == [config.learning_rate(s) for s in range(100)]


def test_evenly() -> None:
    assert evenly(range(10), 0) == evenly(range(10), 10) == range(10)  # type: ignore[arg-type]
    assert evenly(range(10), 3) == [0, 3, 6]  # type: ignore[arg-type,comparison-overlap]


# --- grasps in physics --------------------------------------------------------------------


@pytest.fixture(scope="module")
def scenes() -> list[HeldOut]:
    return held_out_scenes(6, 224)


def best_grasp(scene: HeldOut) -> Grasp:
    """Find across what the camera sees of the highest object at the middle of it."""
    heights = np.nan_to_num(scene.seen.heights)
    rows, columns = np.nonzero(heights > 0.008)
    cloud = np.column_stack([columns, rows]).astype(float)
    middle = cloud.mean(0)
    along = np.linalg.eigh(np.cov((cloud - middle).T))[1][:, 0]  # the shorter axis
    width = 2 * np.abs((cloud - middle) @ along).max() + 10
    return Grasp(middle[0], middle[1], math.atan2(-along[1], along[0]), float(width))


def test_held_out_scenes_are_the_same_each_time_and_no_training_scenes(scenes: list[HeldOut]) -> None:
    again = held_out_scenes(1, 224)[0]
    np.testing.assert_array_equal(again.image.depth, scenes[0].image.depth)
    assert len({scene.image.depth.tobytes() for scene in scenes}) == 6


def test_a_sound_grasp_holds_and_one_of_the_air_does_not(scenes: list[HeldOut]) -> None:
    held = [scene.holds(best_grasp(scene)) for scene in scenes]
    assert sum(held) >= 2
    assert held == [scene.holds(best_grasp(scene)) for scene in scenes], "a try leaves no trace"
    assert not any(scene.holds(Grasp(12.0, 12.0, 0.3, 40.0)) for scene in scenes)


class Answers(nn.Module):
    """Puts out the rows that belong to pictures, in order."""

    def __init__(self, grasps: list[Grasp]) -> None:
        super().__init__()
        self.weight = nn.Parameter(torch.zeros(1))
        self.rows = [torch.tensor([[g.x, g.y, g.angle, g.width, g.width / 2, 0.9]]) for g in grasps]

    def forward(self, x: Tensor) -> Tensor:
        return self.rows.pop(0)[None]


def test_a_network_is_asked_for_its_best_grasp(scenes: list[HeldOut]) -> None:
    grasps = [best_grasp(scene) for scene in scenes]
    assert count_held(Answers(grasps), scenes, "depth") == sum(
        scene.holds(grasp) for scene, grasp in zip(scenes, grasps, strict=True)
    )


def test_training_until_flat_ends_resumes_and_says_so(
    folder: Path,  # noqa: F811
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With a judge that finds no progress after the second validation."""
    found = iter([5, 9, 9, 9, 9, 9, 9, 9, 9])

    class Judge:
        def __init__(self, *_: object) -> None:
            pass

        def __call__(self, network: nn.Module) -> Accuracy:
            return Accuracy(held=next(found), tried=10)

    monkeypatch.setattr(loop, "Judge", Judge)
    settings = {**FAST, "validate_every": 2, "checkpoint_every": 4, "held_out": 0}
    config = TrainConfig(**settings, steps=100, batch=1, until_flat=True, patience=2)

    class Killed(Exception):  # noqa: N818
        pass

    def kill(done: int, *_: object) -> None:
        if done == 5:
            raise Killed

    with pytest.raises(Killed):
        train(config, load_scenes([folder]), tmp_path, kill)
    course = train(config, load_scenes([folder]), tmp_path).course
    assert (course.falling, course.end, course.why) == (8, 10, "flat")
    assert [(p.step, p.held) for p in course.curve] == [(2, 5), (4, 9), (6, 9), (8, 9), (10, 9)]
    last = json.loads((tmp_path / "log.jsonl").read_text().splitlines()[-1])
    assert (last["step"], last["ended"]) == (10, "flat")
    assert course.seconds > 0
    assert course.flops > 1e8


def test_held_out_tries_are_logged(folder: Path, tmp_path: Path) -> None:  # noqa: F811
    config = TrainConfig(**FAST, steps=1, batch=1, held_out=2)
    accuracy = train(config, load_scenes([folder]), tmp_path).accuracy
    assert accuracy.tried == 2
    line = json.loads((tmp_path / "log.jsonl").read_text().splitlines()[-2])
    assert (line["tried"], line["scenes"]) == (2, 2)
