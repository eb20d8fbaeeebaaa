"""Reference grasps from any direction: geometry in closed form, and what physics holds."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from grasp_bench.grasps import GraspPose
from grasp_bench.objects.catalog import Catalog, ObjectModel
from grasp_bench.predictors import reference
from grasp_bench.predictors.antipodes import Union, approaches, pairs
from grasp_bench.robot.parallel_85 import PARALLEL_85

UP = np.array([0.0, 0.0, 1.0])
CONE = math.radians(18)


def rod(flats: float, length: float, lift: float = 0.0) -> np.ndarray:
    """A hexagonal rod along y that lies on one of its faces, ``flats`` from face to face."""
    turns = math.pi / 3 * np.arange(6)
    ring = flats / math.sqrt(3) * np.column_stack([np.cos(turns), np.zeros(6), np.sin(turns)])
    return np.concatenate([ring + [0, y, flats / 2 + lift] for y in (-length / 2, length / 2)])


def block(x: float, y: float, z: float, at: tuple[float, float, float] = (0, 0, 0)) -> np.ndarray:
    corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
    return corners * [x / 2, y / 2, z / 2] + at


def test_a_line_leaves_a_union_where_it_should() -> None:
    shape = Union(
        [block(0.04, 0.04, 0.04), block(0.04, 0.04, 0.04, (0.03, 0, 0)), block(0.01, 1, 1, (0.2, 0, 0))]
    )
    ends = shape.through(np.array([-0.02, 0.001, 0.002]), np.array([1.0, 0, 0]))
    assert [d for d, _ in ends] == pytest.approx([0.07, 0.225], abs=1e-9)
    assert [piece for _, piece in ends] == [1, 2]
    assert shape.through(np.array([0, 2.0, 0]), np.array([1.0, 0, 0])) == []


def test_only_the_outer_surface_is_looked_at() -> None:
    shape = Union([block(0.04, 0.04, 0.04), block(0.04, 0.04, 0.04, (0.03, 0, 0))])
    points, normals, pieces = shape.surface(2000, np.random.default_rng(0))
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1)
    inside = (np.abs(points - [0.015, 0, 0]) < [0.0349, 0.0199, 0.0199]).all(1)
    assert not inside.any()
    assert (points[pieces == 1, 0] > 0.0099).all()


def test_pairs_of_a_block_are_its_sides_that_fit() -> None:
    found = pairs(Union([block(0.05, 0.12, 0.2)]), 0.085, CONE, UP, np.random.default_rng(1))
    assert found
    assert all(p.width == pytest.approx(0.05) for p in found)
    assert all(abs(p.axis[0]) == pytest.approx(1) for p in found)
    assert all(abs(p.middle[0]) < 1e-9 for p in found)


def test_at_an_edge_a_flat_pad_feels_all_normals_between_its_faces() -> None:
    shape = Union([block(0.04, 0.04, 0.04)])
    diagonal = np.array([1.0, 0, 1]) / math.sqrt(2)
    side = np.array([0.02, 0.0, 0.0])
    assert shape.facing(side, 0, diagonal) == pytest.approx(math.sqrt(0.5))
    assert shape.facing(side, 0, np.array([-1.0, 0, 0])) == 0
    assert shape.facing(np.array([0.02, 0, 0.0195]), 0, diagonal) == pytest.approx(1)
    along = np.array([0, 1.0, 0])
    assert shape.facing(np.array([0.02, 0, 0.0195]), 0, along) == pytest.approx(0, abs=1e-9)


def test_a_rod_on_one_of_its_faces_is_held_by_two_of_its_edges() -> None:
    found = pairs(Union([rod(0.01, 0.1)]), 0.085, CONE, UP, np.random.default_rng(1))
    level = [p for p in found if abs(p.axis[0]) > 1 - 1e-9]
    assert len(level) > 20
    assert all(0.0103 < p.width <= 0.02 / math.sqrt(3) + 1e-9 for p in level)
    assert all(abs(p.middle[2] - 0.005) < 0.0011 for p in level)


def test_the_table_draws_the_tips_back_and_no_farther_than_still_holds() -> None:
    down = np.diag([1.0, -1.0, -1.0])
    high, flat, sheet = ([0.0, 0.0, z] for z in (0.1, 0.005, 0.0009))

    def depth(middle: list[float], rotation: np.ndarray) -> float | None:
        return reference._depth(np.array(middle), rotation, 0.03, 0.012, PARALLEL_85)

    assert depth(high, down) == 0.012
    assert depth(flat, down) == pytest.approx(0.003), "2 mm above the table"
    assert depth(sheet, down) is None
    c, s = math.cos(math.radians(60)), math.sin(math.radians(60))
    tilted = np.array([[1.0, 0, 0], [0, -c, s], [0, -s, -c]])
    assert depth(flat, tilted) is None, "a corner of the finger would be in the table"
    assert depth(high, tilted) == 0.012


def test_hands_of_a_sector_come_from_all_places_in_turn() -> None:
    down = np.diag([1.0, -1.0, -1.0])

    def hand(x: float, score: float) -> tuple[GraspPose, float]:
        return GraspPose(np.array([x, 0.001, 0.05]), down, 0.05), score

    crowd = [hand(0.001 + 0.001 * i, 0.9 - 0.01 * i) for i in range(9)]
    (sector,) = reference._sectors([*crowd, hand(0.1, 0.2)]).values()
    assert [score for _, score in sector][:3] == [0.9, 0.2, 0.89]


@pytest.mark.parametrize(
    "name", ["hex_key", "pencil_sharpener", "mixing_bowl", "pet_bowl", "iced_donut", "magnifying_glass"]
)
def test_what_is_flat_edged_sloping_or_crowded_has_grasps_in_the_first_of_its_poses(name: str) -> None:
    model = Catalog().load(name)
    assert len(reference.find(model, 0, PARALLEL_85)) >= 12


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
