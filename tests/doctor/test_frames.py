"""The conformance check names the usual slips of grasps in six degrees of freedom."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from test_conformance import Told, words

from grasp_bench.camera import RgbdImage
from grasp_bench.doctor.conformance import Sample, check, rendered_scene
from grasp_bench.grasps import GraspPose


@pytest.fixture(scope="module")
def scene() -> Sample:
    return rendered_scene()


def sound(image: RgbdImage) -> list[GraspPose]:
    """From above on the middle of what stands out, jaws across it."""
    points, _ = image.cloud((image.depth > 0) & (image.depth < 0.542))
    if len(points) < 20:
        return []
    middle = np.median(points, 0).astype(float)
    spread = np.cov((points - middle)[:, :2].T)
    across = np.linalg.eigh(spread)[1][:, 0]
    x = np.array([*across, 0.0])
    z = np.array([0.0, 0.0, 1.0])
    return [GraspPose(middle + [0, 0, 0.005], np.column_stack([x, np.cross(z, x), z]), 0.06, 0.9)]


def spoilt(by: Callable[[GraspPose], GraspPose]) -> Told:
    return Told(lambda image: [by(g) for g in sound(image)])


def test_a_sound_one_passes(scene: Sample) -> None:
    (row,) = check(spoilt(lambda g: g), [scene])
    assert row.grasps == 1
    assert row.findings == []


def test_each_slip_is_named(scene: Sample) -> None:
    camera = scene.camera
    assert camera is not None
    slips: list[tuple[Callable[[GraspPose], GraspPose], str]] = [
        (lambda g: replace(g, rotation=g.rotation[:, [2, 0, 1]]), "approach seems to run along x"),
        (lambda g: replace(g, rotation=g.rotation * [1, -1, -1]), "approach points away"),
        (lambda g: replace(g, position=g.position - 0.165 * g.rotation[:, 2]), "hand or flange"),
        (lambda g: replace(g, position=g.position - 0.1034 * g.rotation[:, 2]), "hand or flange"),
        (lambda g: replace(g, position=1000 * g.position), "millimetres"),
        (lambda g: replace(g, opening=1000 * g.opening), "millimetres"),
        (lambda g: g.moved(camera.rotation, camera.position), "world's frame"),
        (lambda g: g.moved(np.diag([1.0, -1, -1]), np.zeros(3)), "behind the camera.*OpenGL"),
        (lambda g: replace(g, rotation=g.rotation * [1, -1, 1]), "mirrored"),
    ]
    for slip, name in slips:
        rows = check(spoilt(slip), [scene])
        assert re.search(name, words(rows, "failure")), (name, rows)
        assert rows[0].failed


def test_a_grasp_beside_the_object_is_a_remark(scene: Sample) -> None:
    rows = check(spoilt(lambda g: replace(g, position=g.position + [0.2, 0, 0])), [scene])
    assert not rows[0].failed
    assert "mm from the only object" in words(rows, "remark")
