"""How predictors are asked: with a copy, behind a guard, and about many objects at once."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from grasp_bench.camera import CameraPose, Intrinsics, RgbdImage
from grasp_bench.errors import PredictorError
from grasp_bench.grasps import Grasp
from grasp_bench.predictors.protocol import GroundTruth, PrivilegedPredictor, ask

SIZE = Intrinsics.from_fov(40, 30, math.pi / 2)
IMAGE = RgbdImage(np.zeros((30, 40, 3), np.uint8), np.ones((30, 40), np.float32), SIZE)


def rng() -> np.random.Generator:
    return np.random.default_rng(3)


def truth(height: float) -> GroundTruth:
    pose = CameraPose(np.zeros(3), np.eye(3))
    model: Any = None
    return GroundTruth(model, np.array([0, 0, height]), np.eye(3), pose, SIZE)


class Told(PrivilegedPredictor):
    """Answers by the height of the object it is told of; spoils every image it is given."""

    def __init__(self, answer: Callable[[float], Any]) -> None:
        self.answer = answer
        self.seen: list[float] = []
        self.begun: list[float] = []

    def begin(self, rng: np.random.Generator) -> None:
        self.begun.append(rng.random())

    def predict_from_truth(self, image: RgbdImage, truth: GroundTruth) -> list[Grasp]:
        self.seen.append(float(image.depth.sum()))
        image.depth[:] = 0
        return self.answer(float(truth.position[2]))


def at(x: float, y: float = 5) -> Grasp:
    return Grasp(x, y, 0, 4)


def test_grasps_of_many_objects_take_turns_higher_objects_first() -> None:
    answers = {0.1: [at(1), at(2), at(3)], 0.3: [at(-1), at(10), at(11, 31), at(12)], 0.2: [at(20)], 0.0: []}
    control = Told(answers.__getitem__)
    grasps = ask(control, IMAGE, rng(), [truth(z) for z in answers])
    assert [g.x for g in grasps] == [10, 20, 1, 12, 2, 3]
    assert control.begun == [rng().random()], "once for all objects"


def test_objects_of_one_height_keep_their_order() -> None:
    numbers = iter(range(3))
    control = Told(lambda height: [at(next(numbers))])
    assert [g.x for g in ask(control, IMAGE, rng(), [truth(0.1)] * 3)] == [0, 1, 2]


def test_every_question_has_an_image_of_its_own() -> None:
    control = Told(lambda height: [at(1)])
    ask(control, IMAGE, rng(), [truth(0.1), truth(0.2)])
    assert control.seen == [1200] * 2
    assert IMAGE.depth.all()


@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        (lambda height: [][1], "the predictor raised IndexError"),
        (lambda height: exit(3), "the predictor raised SystemExit: 3"),
        (lambda height: [Grasp(1, 1, 0, -1)], "width of -1"),
        (lambda height: [at(1)] * 1001, "are too many"),
    ],
)
def test_what_goes_wrong_is_told_as_a_predictor_error(answer: Callable[[float], Any], reason: str) -> None:
    with pytest.raises(PredictorError, match=reason):
        ask(Told(answer), IMAGE, rng(), [truth(0.1)])


def test_a_stream_that_a_predictor_cannot_take_is_its_own_fault() -> None:
    class Unready(Told):
        def begin(self, rng: np.random.Generator) -> None:
            raise RuntimeError("no licence")

    with pytest.raises(PredictorError, match="the predictor raised RuntimeError: no licence"):
        ask(Unready(lambda height: []), IMAGE, rng())


def test_a_predictor_that_sees_the_image_alone_is_asked_once() -> None:
    class Blind:
        asked = 0

        def predict(self, image: RgbdImage) -> list[Grasp]:
            self.asked += 1
            return [at(7)]

    blind = Blind()
    assert ask(blind, IMAGE, rng(), [truth(0.1)] * 3) == [at(7)]
    assert ask(blind, IMAGE, rng(), [truth(0.1)]) == [at(7)]
    assert blind.asked == 2


def test_a_control_needs_the_truth() -> None:
    with pytest.raises(PredictorError, match="Told is a control that needs the simulator's truth"):
        ask(Told(lambda height: []), IMAGE, rng())
