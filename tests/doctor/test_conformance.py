"""The conformance check finds what is wrong with a predictor, and nothing wrong with a sound one."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import count
from typing import Any

import numpy as np
import pytest

from grasp_bench.camera import RgbdImage
from grasp_bench.doctor.conformance import Row, Sample, check, jaw_direction, samples
from grasp_bench.errors import PredictorError
from grasp_bench.grasps import Grasp, angle_difference
from grasp_bench.predictors import load_predictor


@pytest.fixture(scope="module")
def images() -> list[Sample]:
    return samples()


class Told:
    """A predictor that is one function; a sound one by default."""

    def __init__(self, answer: Callable[[RgbdImage], Any]) -> None:
        self._answer = answer

    def predict(self, image: RgbdImage) -> list[Grasp]:
        return self._answer(image)


def middle(image: RgbdImage) -> list[Grasp]:
    """Across the blob that stands out, in the middle half."""
    h, w = image.depth.shape
    near = np.zeros((h, w), bool)
    box = slice(h // 4, 3 * h // 4), slice(w // 4, 3 * w // 4)
    near[box] = (image.depth[box] > 0) & (image.depth[box] < 0.545)
    if near.sum() < 20:
        return []
    rows, columns = np.nonzero(near)
    return [Grasp(float(np.median(columns)), float(np.median(rows)), jaw_direction(near), 60.0, 0.9)]


def changed(**to: Callable[[Grasp, RgbdImage], float]) -> Told:
    """The sound predictor with some numbers spoilt."""
    return Told(lambda image: [replace(g, **{k: f(g, image) for k, f in to.items()}) for g in middle(image)])


def words(rows: list[Row], level: str) -> str:
    return " ".join(f.text for row in rows for f in row.findings if f.level == level)


def frozen() -> float:
    """A clock that stands still."""
    return 0.0


@pytest.mark.parametrize("name", ["random", "antipodal", "centroid"])
def test_the_shipped_heuristics_pass_without_a_remark(name: str, images: list[Sample]) -> None:
    rows = check(load_predictor(name), images, frozen)
    assert [r.findings for r in rows] == [[]] * len(images)
    assert rows[0].grasps


def test_the_rendered_scene_shows_a_long_object_askew(images: list[Sample]) -> None:
    mask = images[0].mask
    assert mask is not None
    assert 500 < mask.sum() < 20_000
    across = jaw_direction(mask)
    askew = min(abs(across), angle_difference(across, math.pi / 2))
    assert askew > math.radians(15), "clockwise would not show"
    assert {s.image.depth.shape for s in images} >= {(480, 640), (32, 40), (424, 240)}
    assert not images[2].image.depth.any()


def test_a_sound_predictor_passes(images: list[Sample]) -> None:
    assert not words(check(Told(middle), images, frozen), "failure")
    assert not words(check(Told(middle), images, frozen), "remark")


def mutate(image: RgbdImage) -> list[Grasp]:
    image.depth[image.depth == 0] = 1
    return []


def waver(image: RgbdImage, calls: Any = count()) -> list[Grasp]:  # noqa: B008
    return [replace(g, width=50.0 + next(calls)) for g in middle(image)]


@pytest.mark.parametrize(
    ("predictor", "text"),
    [
        (Told(lambda image: None), "must return a list of Grasp or GraspPose, got NoneType"),
        (Told(lambda image: np.zeros((3, 5))), "got ndarray"),
        (Told(lambda image: (g for g in middle(image))), "got generator"),
        (Told(lambda image: [(1, 2, 3, 4, 5)]), "grasp 0 is a tuple"),
        (Told(lambda image: 1 / 0), "raises ZeroDivisionError"),
        (Told(lambda image: exit()), "raises SystemExit"),
        (changed(x=lambda g, i: math.nan), "NaN or infinity"),
        (changed(quality=lambda g, i: math.inf), "NaN or infinity"),
        (changed(x=lambda g, i: 10_000), "outside the"),
        (changed(y=lambda g, i: -1), "outside the"),
        (changed(width=lambda g, i: 0), "must be positive"),
        (changed(width=lambda g, i: -30), "must be positive"),
        (changed(angle=lambda g, i: "30"), "not a number"),  # pyright: ignore[reportArgumentType]
        (changed(angle=lambda g, i: 40.0), "look like degrees"),
        (changed(x=lambda g, i: g.y, y=lambda g, i: g.x), "exchanged|outside"),
        (
            changed(x=lambda g, i: g.x / i.intrinsics.width, y=lambda g, i: g.y / i.intrinsics.height),
            "fractions of the image",
        ),
        (Told(lambda image: middle(image) * 1001), "are too many"),
        (Told(mutate), "changes the image"),
        (Told(waver), "answers differently"),
    ],
)
def test_a_break_of_the_protocol_fails(predictor: Told, text: str, images: list[Sample]) -> None:
    rows = check(predictor, images, frozen)
    assert any(r.failed for r in rows)
    found = words(rows, "failure")
    assert any(t in found for t in text.split("|"))


@pytest.mark.parametrize(
    ("predictor", "text"),
    [
        (changed(angle=lambda g, i: -g.angle), "clockwise"),
        (changed(angle=lambda g, i: g.angle + math.pi / 2), "close along the object"),
        (changed(angle=lambda g, i: g.angle + math.pi), "are wrapped"),
        (changed(quality=lambda g, i: 7), "clipped"),
        (changed(width=lambda g, i: 0.05), "are they metres"),
        (changed(x=lambda g, i: 8, y=lambda g, i: 8), "misses the only object"),
        (
            Told(lambda image: [replace(g, quality=q) for g in middle(image) for q in (0.2, 0.8)]),
            "do not descend",
        ),
    ],
)
def test_what_deserves_a_look_is_remarked_upon_and_passes(
    predictor: Told, text: str, images: list[Sample]
) -> None:
    rows = check(predictor, images, frozen)
    assert text in words(rows, "remark")
    assert not words(rows, "failure")


@pytest.mark.parametrize(("seconds", "level"), [(0.5, None), (3.0, "remark"), (25.0, "failure")])
def test_slowness_is_seen(seconds: float, level: str | None, images: list[Sample]) -> None:
    ticks = count()
    rows = check(Told(middle), images[:1], lambda: next(ticks) * seconds)
    assert [f.level for f in rows[0].findings] == ([level] if level else [])
    assert rows[0].seconds == seconds


def test_a_privileged_control_cannot_be_checked(images: list[Sample]) -> None:
    with pytest.raises(PredictorError, match="Oracle is a control that needs the simulator's truth"):
        check(load_predictor("oracle"), images)
