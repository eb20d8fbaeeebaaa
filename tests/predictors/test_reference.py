"""Reference grasps from any direction: geometry in closed form, and what physics holds."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.predictors import reference
from grasp_bench.predictors.antipodes import Union, approaches, pairs
from grasp_bench.robot.parallel_85 import PARALLEL_85

UP = np.array([0.0, 0.0, 1.0])


def block(x: float, y: float, z: float, at: tuple[float, float, float] = (0, 0, 0)) -> np.ndarray:
    corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
    return corners * [x / 2, y / 2, z / 2] + at


def test_a_line_leaves_a_union_where_it_should() -> None:
    shape = Union(
        [block(0.04, 0.04, 0.04), block(0.04, 0.04, 0.04, (0.03, 0, 0)), block(0.01, 1, 1, (0.2, 0, 0))]
    )
    ends = shape.through(np.array([-0.02, 0.001, 0.002]), np.array([1.0, 0, 0]))
    assert [d for d, _ in ends] == pytest.approx([0.07, 0.225], abs=1e-9)
    np.testing.assert_allclose([n for _, n in ends], [[1, 0, 0], [1, 0, 0]], atol=1e-9)
    assert shape.through(np.array([0, 2.0, 0]), np.array([1.0, 0, 0])) == []


def test_only_the_outer_surface_is_looked_at() -> None:
    shape = Union([block(0.04, 0.04, 0.04), block(0.04, 0.04, 0.04, (0.03, 0, 0))])
    points, normals = shape.surface(2000, np.random.default_rng(0))
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1)
    inside = (np.abs(points - [0.015, 0, 0]) < [0.0349, 0.0199, 0.0199]).all(1)
    assert not inside.any()


def test_pairs_of_a_block_are_its_sides_that_fit() -> None:
    found = pairs(Union([block(0.05, 0.12, 0.2)]), 0.085, UP, np.random.default_rng(1))
    assert found
    assert all(p.width == pytest.approx(0.05) for p in found)
    assert all(abs(p.axis[0]) == pytest.approx(1) for p in found)
    assert all(abs(p.middle[0]) < 1e-9 for p in found)


def test_approaches_are_square_to_the_jaws_and_begin_downwards() -> None:
    axis = np.array([math.cos(0.3), math.sin(0.3), 0.0])
    ways = approaches(axis, UP, 12)
    np.testing.assert_allclose(ways[0], -UP, atol=1e-12)
    assert np.abs(np.array(ways) @ axis).max() < 1e-12
    assert np.linalg.norm(ways, axis=1) == pytest.approx(1)
    assert np.abs(np.array(approaches(UP, UP, 8))[:, 2]).max() < 1e-12


def test_what_held_is_kept_and_read_again(
    models: dict[str, ObjectModel], monkeypatch: pytest.MonkeyPatch
) -> None:
    model = models["block"]
    found = reference.reference_poses(model, 0, PARALLEL_85)
    assert 5 <= len(found) <= reference.KEPT
    steep = [float((model.poses[0].rotation @ g.rotation)[2, 2]) for g, _ in found]
    assert min(steep) < -0.99, "from above"
    assert max(steep) > -0.6, "and from aside"
    for grasp, height in found:
        assert np.linalg.det(grasp.rotation) == pytest.approx(1)
        assert 0 < grasp.opening <= PARALLEL_85.opening
        assert height > 0
    monkeypatch.setattr(reference, "find", lambda *_: pytest.fail("worked out again"))
    again = reference.reference_poses(model, 0, PARALLEL_85)
    assert [g for g, _ in again] == [g for g, _ in found]
    file = reference._file(model, 0, PARALLEL_85)
    assert json.loads(file.read_text())["object"] == "block"
    file.write_text("{")
    monkeypatch.setattr(reference, "find", lambda *_: [])
    assert reference.reference_poses(model, 0, PARALLEL_85) == []
