"""Training: data on disk, augmentation geometry, loss, the loop and its checkpoints."""

from __future__ import annotations

import errno
import json
import math
import resource
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import torch
from filelock import FileLock
from torch.nn import functional
from torch.utils._python_dispatch import TorchDispatchMode
from typer import Typer
from typer.testing import CliRunner

from grasp_bench.camera import Intrinsics, RgbdImage
from grasp_bench.cli.train import train_command
from grasp_bench.errors import AssetError, GraspBenchError
from grasp_bench.grasps import Grasp, GraspMaps, angle_difference
from grasp_bench.learning.data.scenes import Scene, load_scene, load_scenes, unpacked
from grasp_bench.learning.evaluation.evaluate import Question, evaluate
from grasp_bench.learning.training.augment import View, crop_scene, jitter_colour, jitter_depth, random_view
from grasp_bench.learning.training.batches import ROWS, make_batch, make_sample, scenes_of_step
from grasp_bench.learning.training.config import OF_MAPS, TrainConfig
from grasp_bench.learning.training.first_weights import first_weights
from grasp_bench.learning.training.loop import CHECKPOINT, _read, train
from grasp_bench.learning.training.loss import grasp_loss
from grasp_bench.learning.training.step import Learner, choose_device
from grasp_bench.learning.training.validate import is_hit, validate
from grasp_bench.networks.encoding import WIDTH_SCALE, targets_from_maps
from grasp_bench.networks.registry import build, info
from grasp_bench.networks.store import WeightsFile
from grasp_bench.networks.weights import load, save
from grasp_bench.predictors.names import load_predictor

SIZE, CROP = 320, 224


def draw_scene(grasps: list[Grasp], name: str = "0", seed: int = 0) -> Scene:
    """White bars, 6 cm high, on a dark table; each grasp closes across its bar."""
    rng = np.random.default_rng(seed)
    rgb = rng.integers(40, 60, (SIZE, SIZE, 3), dtype=np.uint8)
    depth = rng.normal(7000, 5, (SIZE, SIZE)).astype(np.uint16)
    for g in grasps:
        bar = np.zeros((SIZE, SIZE), np.uint8)
        corners = Grasp(g.x, g.y, g.angle, g.width - 16).rectangle(height=3 * g.width)
        cv2.fillPoly(bar, [np.round(corners - 0.5).astype(np.int32)], (1,))
        rgb[bar > 0], depth[bar > 0] = 220, 6400
    depth[rng.random(depth.shape) < 0.02] = 0
    maps = GraspMaps.from_grasps(grasps, (SIZE, SIZE))
    listed = np.array([[g.x, g.y, g.angle, g.width, 1] for g in grasps], np.float32).reshape(-1, 5)
    return Scene(
        name,
        rgb,
        depth,
        (maps.quality * 255).astype(np.uint8),
        maps.angle.astype(np.float16),
        maps.width.astype(np.float16),
        listed,
    )


def store_scene(path: Path, scene: Scene, **spoilt: np.ndarray) -> None:
    """Write a scene, some of its arrays replaced."""
    names = ("rgb", "depth", "quality", "angle", "width", "grasps")
    arrays = {name: getattr(scene, name) for name in names} | {"depth_true": scene.depth}
    np.savez_compressed(path, **(arrays | spoilt))  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Eight scenes, two of them for validation."""
    folder = tmp_path_factory.mktemp("synthetic")
    (folder / "scenes").mkdir()
    rng = np.random.default_rng(1)
    lines = []
    for k in range(8):
        x, y = rng.uniform(120, 200, 2)
        grasp = Grasp(x, y, rng.uniform(-1.5, 1.5), rng.uniform(40, 60))
        store_scene(folder / f"scenes/{k:06d}.npz", draw_scene([grasp], seed=k))
        lines.append(
            json.dumps(
                {"scene": f"{k:06d}", "file": f"scenes/{k:06d}.npz", "split": "val" if k >= 6 else "train"}
            )
        )
    (folder / "index.jsonl").write_text("\n".join(lines) + "\n")
    return folder


def test_rows_follow_the_picture_and_tell_of_failures() -> None:
    grasp, failed = Grasp(175.0, 150.0, 0.4, 48.0), Grasp(150.0, 160.0, -1.0, 40.0)
    row = [grasp.x, grasp.y, grasp.angle, grasp.width, 1, 1]
    wrong = [failed.x, failed.y, failed.angle, failed.width, 0.9, 0]
    scene = replace(draw_scene([grasp]), tried=np.array([row, wrong], np.float32))
    tables = {kind: make_sample(scene, "rgd", CROP, None, kind)[1] for kind in ("rectangles", "tries")}
    seen = View().grasp(grasp, SIZE, CROP)
    for table in tables.values():
        assert table.shape == (ROWS, 6)
        np.testing.assert_allclose(table[0], [seen.x, seen.y, 0.4, 48, 24, 1], rtol=1e-5)
    assert tables["rectangles"][1:, 5].max() == -1
    assert tables["tries"][1, 5] == 0
    assert tables["tries"][2:, 5].max() == -1


def test_a_share_of_the_scenes_keeps_its_labels() -> None:
    scenes = [draw_scene([Grasp(160.0, 160.0, 0.0, 40.0)], str(k)) for k in range(60)]
    tables = [make_sample(scene, "rgb", CROP, None, "rectangles", 0.3)[1] for scene in scenes]
    assert 8 < sum((table[:, 5] > 0).any() for table in tables) < 30


def test_half_of_a_batch_has_labels_where_few_scenes_have() -> None:
    scenes = [draw_scene([Grasp(160.0, 160.0, 0.0, 40.0)], str(k)) for k in range(60)]
    config = TrainConfig(network="laili-pairs-10", batch=8, augment=False)
    first, again = (make_batch(scenes, config, "rgb", CROP, 3)[1] for _ in range(2))
    there = np.any(first[..., 5] > 0, axis=1)
    assert there[::2].all()
    assert there.sum() < 8
    assert (first == again).all()


# --- augmentation -------------------------------------------------------------------------

VIEWS = [
    View(),
    View(rotation=math.radians(90)),
    View(rotation=math.radians(30)),
    View(rotation=math.radians(-140)),
    View(mirror=True),
    View(scale=1.1),
    View(scale=0.9),
    View(shift=(13.0, -7.0)),
    View(math.radians(70), True, 0.93, (-9.0, 11.0)),
]


@pytest.mark.parametrize("view", VIEWS, ids=str)
def test_labels_follow_the_picture(view: View) -> None:
    """The grasp found in the moved label maps, the moved grasp and the moved bar agree."""
    grasp = Grasp(175.0, 150.0, math.radians(25), 48.0)
    scene = draw_scene([grasp])
    rgb, depth, labels = crop_scene(scene, view, CROP)
    expected = view.grasp(grasp, SIZE, CROP)
    inside = labels.quality > 0

    rows, columns = np.nonzero(inside)
    assert columns.mean() + 0.5 == pytest.approx(expected.x, abs=0.7)
    assert rows.mean() + 0.5 == pytest.approx(expected.y, abs=0.7)
    assert max(angle_difference(float(a), expected.angle) for a in labels.angle[inside]) < 2e-3
    np.testing.assert_allclose(labels.width[inside], 48 * view.scale, rtol=1e-3)
    assert not labels.width[~inside].any()
    assert not labels.sin2[~inside].any()

    bar_rows, bar_columns = np.nonzero(rgb[..., 0] > 150)
    centred = np.stack([bar_columns + 0.5 - expected.x, bar_rows + 0.5 - expected.y])
    assert np.abs(centred.mean(1)).max() < 1.0
    axis = np.linalg.eigh(np.cov(centred))[1][:, 1]  # the bar's long axis, across the jaws
    along_jaws = math.atan2(axis[0], axis[1])  # perpendicular to it, image angles
    assert angle_difference(along_jaws, expected.angle) < math.radians(2)
    high = (depth > 0) & (depth < np.median(depth[depth > 0]) - 0.03)
    assert (high & (rgb[..., 0] > 150)).sum() > 0.9 * high.sum()


def test_quarter_turn_by_hand() -> None:
    """A quarter turn counter-clockwise takes what is right of the middle above it."""
    grasp = Grasp(160 + 40, 160.0, 0.0, 40.0)
    moved = View(rotation=math.pi / 2).grasp(grasp, SIZE, CROP)
    assert (moved.x, moved.y) == pytest.approx((112, 112 - 40))
    assert angle_difference(moved.angle, math.pi / 2) < 1e-9
    mirrored = View(mirror=True).grasp(Grasp(200.0, 150.0, 0.3, 40.0), SIZE, CROP)
    assert (mirrored.x, mirrored.y, mirrored.angle) == pytest.approx((72, 102, -0.3))


def test_magnifying_keeps_heights_and_metric_widths() -> None:
    scene = draw_scene([Grasp(160.0, 160.0, 0.0, 50.0)])
    (_, plain, _), (_, near, labels) = (crop_scene(scene, View(scale=s), CROP) for s in (1.0, 1.1))
    table, top = np.median(near[near > 0]), near[112, 112]
    assert table == pytest.approx(0.7 / 1.1, rel=1e-3)
    assert table - top == pytest.approx(np.median(plain[plain > 0]) - plain[112, 112], abs=2e-4)
    assert labels.width[112, 112] * table == pytest.approx(50 * 0.7, rel=2e-3)


def test_identity_is_the_centre_crop() -> None:
    scene = draw_scene([Grasp(150.0, 140.0, 0.4, 50.0)])
    rgb, depth, labels = crop_scene(scene, View(), CROP)
    middle = np.s_[48:272, 48:272]
    np.testing.assert_array_equal(rgb, scene.rgb[middle])
    np.testing.assert_array_equal(depth, scene.depth[middle].astype(np.float32) * np.float32(1e-4))
    np.testing.assert_array_equal(labels.quality * 255, scene.quality[middle])


def test_jitter_keeps_holes_and_types() -> None:
    rng = np.random.default_rng(0)
    depth = np.full((20, 20), 0.7, np.float32)
    depth[3, 4] = 0
    moved = jitter_depth(depth, rng)
    assert moved[3, 4] == 0
    assert moved.dtype == np.float32
    assert np.ptp(moved[moved > 0]) == 0
    rgb = rng.integers(0, 255, (20, 20, 3), dtype=np.uint8)
    assert jitter_colour(rgb, rng).dtype == np.uint8
    assert (jitter_colour(rgb, rng) != rgb).any()
    assert random_view(np.random.default_rng(4)) == random_view(np.random.default_rng(4))
    assert random_view(np.random.default_rng(4), 1.1) == random_view(np.random.default_rng(4))
    scales = np.array([random_view(np.random.default_rng(i), 2.0).scale for i in range(600)])
    assert ((scales >= 0.9) & (scales <= 2.0)).all()
    assert np.mean(scales > 1.1) == pytest.approx(1 / 3, abs=0.07)
    assert np.mean(scales[scales > 1.1]) == pytest.approx(1.55, abs=0.07)


# --- batches ------------------------------------------------------------------------------


def test_every_scene_once_an_epoch() -> None:
    seen = [k for step in range(4) for k in scenes_of_step(7, step, 5, 10)]
    assert sorted(seen[:10]) == sorted(seen[10:]) == list(range(10))
    assert seen[:10] != seen[10:]


def test_batches_depend_on_seed_and_step_only(folder: Path) -> None:
    scenes = load_scenes([folder])
    one, other = (make_batch(scenes.train, TrainConfig(batch=3, seed=s), "rgbd", CROP, 5) for s in (0, 1))
    again = make_batch(scenes.train, TrainConfig(batch=3, steps=9, workers=2), "rgbd", CROP, 5)
    assert one[0].shape == (3, 4, CROP, CROP)
    assert one[1].shape == (3, 4, CROP, CROP)
    np.testing.assert_array_equal(one[0], again[0])
    np.testing.assert_array_equal(one[1], again[1])
    assert not np.array_equal(one[0], other[0])


# --- loss ---------------------------------------------------------------------------------


def test_loss_by_hand() -> None:
    """Two pixels, one with a grasp."""
    target = torch.tensor([[1.0, 0.0], [0.6, 0.0], [0.8, 0.0], [0.5, 0.0]]).view(1, 4, 1, 2)
    output = torch.tensor([[0.8, 0.2], [0.0, 0.4], [0.8, 0.4], [2.5, 0.0]]).view(1, 4, 1, 2)
    quality = (0.5 * 0.2**2 + 0.5 * 0.2**2) / 2
    on, off = (0.5 * 0.6**2, 0.0, 2.0 - 0.5), (0.5 * 0.4**2, 0.5 * 0.4**2, 0.0)

    masked = grasp_loss(output, target, masked=True, geometry_weight=0.1)
    assert masked["loss"].item() == pytest.approx(quality + 0.1 * sum(on), rel=1e-5)
    assert [masked[k].item() for k in ("sin", "cos", "width")] == pytest.approx(on, rel=1e-5)
    paper = grasp_loss(output, target, masked=False)
    assert paper["loss"].item() == pytest.approx(quality + sum(on) / 2 + sum(off) / 2, rel=1e-5)
    stressed = grasp_loss(output, target, positive_weight=3.0)
    assert stressed["quality"].item() == pytest.approx(0.5 * 0.2**2 * (4 + 1) / 2, rel=1e-5)
    wider = grasp_loss(output, target, geometry_weight=0.1, width_weight=3.0)
    assert wider["loss"].item() == pytest.approx(quality + 0.1 * (on[0] + 3 * on[2]), rel=1e-5)
    assert wider["width"].item() == pytest.approx(on[2], rel=1e-5)


def test_expectile_of_the_width() -> None:
    """The constant that the loss likes best is the expectile: of 0.2 and 0.4, at τ = 0.8, 0.36."""
    target = torch.ones(1, 4, 1, 2)
    target[0, 3, 0] = torch.tensor([0.2, 0.4])
    width = torch.zeros((), requires_grad=True)
    optimizer = torch.optim.SGD([width], lr=0.5)
    for _ in range(100):
        optimizer.zero_grad()
        output = torch.cat([target[:, :3], width.expand(1, 1, 1, 2)], 1)
        grasp_loss(output, target, geometry_weight=1.0, width_expectile=0.8)["loss"].backward()
        optimizer.step()
    assert width.item() == pytest.approx(0.36, abs=1e-4)


@pytest.mark.parametrize("masked", [True, False])
@pytest.mark.parametrize("dtype", [torch.float32, torch.bfloat16])
def test_gradient_of_the_loss(masked: bool, dtype: torch.dtype) -> None:
    """Against automatic differentiation of equations 7 and 8 as they are written."""
    torch.manual_seed(0)
    target = torch.rand(3, 4, 8, 9) * (torch.rand(3, 1, 8, 9) < 0.2)
    output = (1.5 * torch.randn(3, 4, 8, 9)).to(dtype).requires_grad_()
    factor = 0.3 if masked else 1.0
    settings: dict[str, Any] = {"masked": masked, "geometry_weight": factor, "positive_weight": 2.0}
    settings |= {"width_weight": 5.0, "width_expectile": 0.8}
    (3 * grasp_loss(output, target, **settings)["loss"]).backward()
    found, output.grad = output.grad, None

    error = functional.smooth_l1_loss(output.float(), target, reduction="none")
    on = (target[:, :1] > 0).float()
    quality = (error[:, :1] * (1 + 2 * on)).mean()
    rest = error[:, 1:].clone()
    rest[:, 2] *= 5 * torch.where(output[:, 3] < target[:, 3], 1.6, 0.4)
    geometry = (rest * on).sum((0, 2, 3)) / on.sum() if masked else rest.mean((0, 2, 3))
    loss = quality + factor * geometry.sum()
    assert grasp_loss(output, target, **settings)["loss"].item() == pytest.approx(loss.item(), rel=1e-5)
    (3 * loss).backward()
    assert found is not None
    assert output.grad is not None
    torch.testing.assert_close(found, output.grad, rtol=1e-2 if dtype == torch.bfloat16 else 1e-5, atol=1e-7)


def test_loss_without_any_grasp() -> None:
    output = torch.ones(2, 4, 3, 3, requires_grad=True)
    loss = grasp_loss(output, torch.zeros(2, 4, 3, 3))["loss"]
    loss.backward()
    assert loss.item() == pytest.approx(0.5)
    assert output.grad is not None
    assert torch.isfinite(output.grad).all()


# --- validation ---------------------------------------------------------------------------


def test_hit() -> None:
    labels = GraspMaps.from_grasps([Grasp(30.0, 30.0, 0.5, 40.0)], (60, 60))
    assert is_hit(Grasp(30.5, 29.5, 0.6, 38.0), labels)
    assert is_hit(Grasp(30.0, 30.0, 0.5 + math.pi, 90.0), labels), "a wider opening is no fault"
    assert not is_hit(Grasp(30.0, 30.0, 0.5 + math.radians(21), 40.0), labels)
    assert not is_hit(Grasp(30.0, 30.0, 0.5, 31.0), labels)
    assert not is_hit(Grasp(55.0, 5.0, 0.5, 40.0), labels)


class Oracle(torch.nn.Module):
    """Answers with the labels of the scenes, in turn."""

    def __init__(self, scenes: list[Scene]) -> None:
        super().__init__()
        self.unused = torch.nn.Parameter(torch.zeros(1))
        self.answers = iter([targets_from_maps(crop_scene(s, View(), CROP)[2]) for s in scenes])

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return torch.from_numpy(next(self.answers))[None]


def test_labels_themselves_score_full_marks(folder: Path) -> None:
    scenes = [*load_scenes([folder]).train, draw_scene([])]
    accuracy = validate(Oracle(scenes), scenes, "rgbd")
    assert (accuracy.hits, accuracy.scenes, accuracy.correct, accuracy.labelled) == (6, 6, 6, 6)


# --- data on disk -------------------------------------------------------------------------


def test_reads_back_what_was_stored(folder: Path) -> None:
    scenes = load_scenes([folder])
    assert (len(scenes.train), len(scenes.val)) == (6, 2)
    scene = scenes.train[0]
    assert scene.depth.dtype == np.uint16
    assert scene.width.max() / WIDTH_SCALE < 1
    assert scene.truths()[0].width == pytest.approx(scene.grasps[0, 3])


def spoil_truncated(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def spoil_pickled(path: Path) -> None:
    store_scene(path, draw_scene([]), rgb=np.array([print], dtype=object))


def spoil_shape(path: Path) -> None:
    store_scene(path, draw_scene([]), rgb=draw_scene([]).rgb[:100])


def spoil_nan(path: Path) -> None:
    store_scene(path, draw_scene([]), angle=draw_scene([]).angle * np.float16("nan"))


def spoil_missing(path: Path) -> None:
    path.unlink()


def spoil_lacking(path: Path) -> None:
    np.savez(path, rgb=draw_scene([]).rgb)


def spoil_text(path: Path) -> None:
    path.write_text("not an archive")


def spoil_small(path: Path) -> None:
    scene, part = draw_scene([]), np.s_[:64, :64]
    maps = ("rgb", "depth", "quality", "angle", "width")
    store_scene(path, scene, **{name: getattr(scene, name)[part] for name in maps})


@pytest.mark.parametrize(
    "spoil",
    [
        spoil_truncated,
        spoil_pickled,
        spoil_shape,
        spoil_nan,
        spoil_missing,
        spoil_lacking,
        spoil_text,
        spoil_small,
    ],
)
def test_damaged_scenes_are_named(spoil, tmp_path: Path) -> None:
    path = tmp_path / "000007.npz"
    store_scene(path, draw_scene([]))
    spoil(path)
    with pytest.raises(AssetError, match=r"000007\.npz"):
        load_scene(path, CROP)


@pytest.mark.parametrize(
    "line",
    [
        "{",
        "3",
        '{"file": "a.npz"}',
        '{"file": "a.npz", "split": "test"}',
        '{"file": "../a.npz", "split": "train"}',
        '{"file": 4, "split": "train"}',
    ],
)
def test_damaged_index_is_named_with_its_line(line: str, tmp_path: Path) -> None:
    (tmp_path / "index.jsonl").write_text("\n" + line + "\n")
    with pytest.raises(AssetError, match=r"index\.jsonl, line 2"):
        load_scenes([tmp_path])


def test_many_scenes_are_read_when_needed(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    held = load_scenes([folder])
    monkeypatch.setattr("grasp_bench.learning.data.scenes.IN_MEMORY", 7)
    stored = load_scenes([folder])
    assert isinstance(held.train, list)
    assert not isinstance(stored.train, list)
    assert (len(stored.train), len(stored.val)) == (6, 2)
    assert stored.fingerprint == held.fingerprint
    for a, b in zip([*held.train, *held.val], [*stored.train, *stored.val], strict=True):
        assert a.name == b.name
        np.testing.assert_array_equal(a.depth, b.depth)
    (tmp_path / "index.jsonl").write_text((folder / "index.jsonl").read_text())
    with pytest.raises(AssetError, match="is missing"):
        load_scenes([tmp_path])


def test_no_data_at_all(tmp_path: Path) -> None:
    with pytest.raises(AssetError, match=r"index\.jsonl"):
        load_scenes([tmp_path / "nowhere"])
    (tmp_path / "index.jsonl").write_text("")
    with pytest.raises(AssetError, match="no scene"):
        load_scenes([tmp_path])


# --- loop ---------------------------------------------------------------------------------

FAST = {"network": "gg-cnn", "precision": "fp32", "threads": 1, "validate_every": 10_000, "warmup": 2}


def test_training_lowers_the_loss(folder: Path, tmp_path: Path) -> None:
    scenes, losses = load_scenes([folder]), []
    config = TrainConfig(**{**FAST, "network": "htc-grasp"}, steps=12, batch=2, augment=False)
    trained = train(config, scenes, tmp_path, lambda done, figures, accuracy: losses.append(figures["loss"]))
    assert np.mean(losses[-3:]) < 0.7 * np.mean(losses[:3])
    assert trained.accuracy.scenes == 2
    assert not trained.network.training
    assert json.loads((tmp_path / "log.jsonl").read_text().splitlines()[-2])["scenes"] == 2


class Killed(Exception):  # noqa: N818
    """Stands for kill −9: nothing after it runs."""


@pytest.mark.parametrize("network", ["gg-cnn", "gr-convnet-16", "redmon-multigrasp"])
def test_resumed_run_equals_unbroken_run(network: str, folder: Path, tmp_path: Path) -> None:
    scenes = load_scenes([folder])
    config = TrainConfig(**{**FAST, "network": network}, steps=6, batch=1, ema=0.9, checkpoint_every=3)

    def kill(done: int, figures: object, accuracy: object) -> None:
        if done == 4:
            raise Killed

    whole = train(config, scenes, tmp_path / "whole").network.state_dict()
    with pytest.raises(Killed):
        train(config, scenes, tmp_path / "broken", kill)
    steps: list[int] = []
    again = train(config, scenes, tmp_path / "broken", lambda done, *_: steps.append(done))
    resumed = again.network.state_dict()
    assert steps == [4, 5, 6]
    for name, value in whole.items():
        assert torch.equal(value, resumed[name]), name
    finished = train(config, scenes, tmp_path / "broken").network.state_dict()
    assert all(torch.equal(value, finished[name]) for name, value in whole.items())


def test_checkpoints_of_other_runs_are_refused(folder: Path, tmp_path: Path) -> None:
    scenes = load_scenes([folder])
    config = TrainConfig(**FAST, steps=1, batch=1)
    train(config, scenes, tmp_path)
    with pytest.raises(AssetError, match=r"seed was 0, is 5.*--out"):
        train(config.model_copy(update={"seed": 5}), scenes, tmp_path)
    train(config.model_copy(update={"workers": 2}), scenes, tmp_path)
    path = tmp_path / CHECKPOINT
    path.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(AssetError, match="truncated"):
        train(config, scenes, tmp_path)


def test_divergence_stops_the_run(folder: Path, tmp_path: Path) -> None:
    """At the step it happens, before anything of it is stored."""
    config = TrainConfig(**{**FAST, "warmup": 0}, steps=20, batch=1, lr=1e30, clip=0, checkpoint_every=1)
    good: list[int] = []
    with pytest.raises(GraspBenchError, match="diverged") as caught:
        train(config, load_scenes([folder]), tmp_path, lambda done, *_: good.append(done))
    assert f"at step {good[-1] + 1}: " in str(caught.value)


def test_the_first_of_several_unread_steps_is_named() -> None:
    def figures(loss: float) -> dict[str, torch.Tensor]:
        return {"loss": torch.tensor(loss), "gradient_norm": torch.tensor(1.0)}

    unread = [figures(x) for x in (3.0, 2.0)]
    assert _read(unread, 7) == {"loss": 2.0, "gradient_norm": 1.0}
    assert not unread
    with pytest.raises(GraspBenchError, match=r"The loss is nan, its gradient 1\.0 at step 6:"):
        _read([figures(x) for x in (1.0, math.nan, math.inf)], 7)


class NothingRead(TorchDispatchMode):
    """Refuses to turn a tensor into a Python number, for which a program would wait for a GPU."""

    def __torch_dispatch__(self, func, types, args=(), kwargs=None):
        assert func is not torch.ops.aten._local_scalar_dense.default
        return func(*args, **kwargs or {})


@pytest.mark.parametrize("network", ["htc-grasp", "gr-convnet-16", "gg-cnn", "tf-grasp"])
def test_a_step_waits_for_no_device(network: str) -> None:
    config = TrainConfig(**{**FAST, "network": network, "precision": "bf16"}, ema=0.9)
    learner = Learner.of(build(network), config, choose_device("cpu"))
    inputs, targets = torch.randn(2, info(network).channels, 64, 64), torch.rand(2, 4, 64, 64)
    before = [p.clone() for p in learner.final.parameters()]
    with NothingRead():
        parts = learner.step(0, inputs, targets, 1e-3)
    assert set(parts) == {"loss", "quality", "sin", "cos", "width", "gradient_norm"}
    assert any(not torch.equal(a, b) for a, b in zip(before, learner.final.parameters(), strict=True))


def test_device_is_chosen_and_free_to_change(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    assert choose_device("auto").type == choose_device("cpu").type == "cpu"
    with pytest.raises(GraspBenchError, match="--device cuda"):
        choose_device("cuda")
    scenes = load_scenes([folder])
    config = TrainConfig(**FAST, steps=1, batch=1)
    train(config, scenes, tmp_path)
    train(config.model_copy(update={"device": "cpu"}), scenes, tmp_path)
    monkeypatch.setattr(torch.cuda, "is_available", lambda: True)
    assert choose_device("auto").type == choose_device("cuda").type == "cuda"
    assert choose_device("cpu").type == "cpu"


def test_command_trains_and_writes_weights(folder: Path, tmp_path: Path) -> None:
    app = Typer()
    app.command()(train_command)
    result = CliRunner().invoke(
        app,
        [
            "--predictor",
            "gg-cnn",
            "--data",
            str(folder),
            "--out",
            str(tmp_path),
            "--steps",
            "1",
            "--batch",
            "1",
            "--threads",
            "1",
        ],
    )
    assert result.exit_code == 0, result.output
    assert "rectangle metric" in result.output
    assert "# gg-cnn" in (tmp_path / "gg-cnn.md").read_text()
    assert (tmp_path / "gg-cnn.safetensors").is_file()
    facts = json.loads((tmp_path / "training.json").read_text())
    assert facts == WeightsFile(tmp_path / "gg-cnn.safetensors").metadata()
    assert (facts["steps"], facts["ended"], facts["curve"][0]["step"]) == (1, "steps", 1)
    assert facts["flops"] > 6 * 62_420 * 56**2


def test_a_detector_is_trained_evaluated_and_asked(folder: Path, tmp_path: Path) -> None:
    config = TrainConfig(**{**FAST, "network": "redmon-multigrasp"}, steps=2, batch=2)
    trained = train(config, load_scenes([folder]), tmp_path)
    assert trained.accuracy.labelled == 2
    path = tmp_path / "redmon-multigrasp.safetensors"
    save(trained.network, path, {"network": "redmon-multigrasp", "input": "rgd 224"})
    for name in (f"redmon-multigrasp@{path}", "redmon-multigrasp"):
        done = evaluate(Question(name, "synthetic", folder, weights=path if "@" not in name else None))
        assert done.images == 2
    predictor = load_predictor(f"redmon-multigrasp@{path}")
    scene = load_scene(folder / "scenes/000000.npz")
    image = RgbdImage(scene.rgb, unpacked(scene.depth), Intrinsics.from_fov(SIZE, SIZE, 1.0))
    for grasp in predictor.predict(image):
        assert isinstance(grasp, Grasp)
        assert 48 <= grasp.x <= 272, "within the crop"
    with pytest.raises(GraspBenchError, match="gives grasps and no maps"):
        predictor.maps(image)  # type: ignore[attr-defined]


# The smaller file has eight bits a weight, the larger four.
@pytest.mark.parametrize(("other", "finer"), [("trunk-resnet50", 100), ("fcgn", 10)])
def test_a_network_begins_with_the_trunk_of_another(other: str, finer: int, tmp_path: Path) -> None:
    trunk = build(other, "rgb")
    path = tmp_path / "trunk.safetensors"
    save(trunk, path, {"network": other, "input": "rgb 224"})
    network = first_weights("kumra-resnet50", "rgb", path)
    wanted = trunk.state_dict()["trunk.stages.1.0.body.0.weight"].half().float()
    found = network.state_dict()["trunks.0.stages.1.0.body.0.weight"]
    assert (found - wanted).abs().max() <= wanted.abs().max() / finer, "but for rounding in the file"
    with pytest.raises(AssetError, match=f"weights of {other}, of whose trunk nothing fits gg-cnn"):
        first_weights("gg-cnn", "depth", path)


def test_export_installs_weights_card_and_hash(folder: Path, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("grasp_bench.networks.store.assets_dir", lambda: tmp_path / "assets")
    train_command([folder], tmp_path / "run", network="gg-cnn", steps=1, batch=1, threads=1, export=True)
    installed = tmp_path / "assets" / "weights"
    assert {p.name for p in installed.iterdir()} == {"gg-cnn.safetensors", "gg-cnn.md", "manifest.json"}
    _, metadata = load("gg-cnn")
    assert metadata["steps"] == 1
    assert metadata["data"]["train"] == 6
    assert metadata["accuracy"]["top1"][1] == 2


@pytest.mark.parametrize(("option", "value"), [("--precision", "fp8"), ("--lr", "0"), ("--ema", "1")])
def test_wrong_settings_are_named(option: str, value: str, folder: Path, tmp_path: Path) -> None:
    app = Typer()
    app.command()(train_command)
    result = CliRunner().invoke(
        app, ["--predictor", "gg-cnn", "-d", str(folder), "-o", str(tmp_path), option, value]
    )
    assert result.exit_code == 2
    assert option in result.output


def test_weights_of_maps_are_refused_where_there_are_none(folder: Path, tmp_path: Path) -> None:
    config = TrainConfig(network="redmon-direct", steps=1, batch=2, width_weight=10, width_expectile=0.7)
    with pytest.raises(GraspBenchError, match=r"has a loss of its own: leave out --width-weight\.$"):
        train(config, load_scenes([folder]), tmp_path)
    assert TrainConfig(width_weight=2).given(OF_MAPS) == ["--width-weight"]
    assert TrainConfig(lr=2e-3).given(OF_MAPS) == []


def test_learning_rate() -> None:
    config = TrainConfig(steps=110, warmup=10, lr=1.0)
    assert config.learning_rate(0) == pytest.approx(0.1)
    assert config.learning_rate(10) == 1.0
    assert config.learning_rate(60) == pytest.approx(0.5)
    assert config.model_copy(update={"cosine": False}).learning_rate(100) == 1.0


# ---------------------------------------------------------------- folders that cannot be written


def test_two_trainings_into_one_folder_are_refused(folder: Path, tmp_path: Path) -> None:
    with FileLock(tmp_path / ".lock"), pytest.raises(GraspBenchError, match="Another training is writing to"):
        train(TrainConfig(network="gg-cnn", steps=1, batch=2), load_scenes([folder]), tmp_path)


def test_a_disk_that_fills_up_while_training_costs_no_step_that_was_stored(
    folder: Path, tmp_path: Path
) -> None:
    """No file may grow beyond 100 kB from some step on: the checkpoint meets what a full disk does."""
    scenes = load_scenes([folder])
    config = TrainConfig(**FAST, steps=6, batch=1, ema=0.9, checkpoint_every=2)
    whole = train(config, scenes, tmp_path / "whole").network.state_dict()
    before = resource.getrlimit(resource.RLIMIT_FSIZE)

    def fill(done: int, figures: object, accuracy: object) -> None:
        if done == 3:
            resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, before[1]))

    try:
        with pytest.raises(GraspBenchError) as caught:
            train(config, scenes, tmp_path / "full", fill)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert "(File too large). Free some space; the last checkpoint is kept" in str(caught.value)
    assert sorted(p.name for p in (tmp_path / "full").iterdir() if p.is_file()) == [CHECKPOINT, "log.jsonl"]
    steps: list[int] = []
    again = train(config, scenes, tmp_path / "full", lambda done, *_: steps.append(done)).network.state_dict()
    assert steps == [3, 4, 5, 6]
    assert all(torch.equal(value, again[name]) for name, value in whole.items())


def test_a_full_disk_is_one_clear_error(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(path: Path, content: bytes) -> None:
        raise OSError(errno.ENOSPC, "No space left on device", str(path))

    monkeypatch.setattr("grasp_bench.learning.training.checkpoint.write_whole", full)
    with pytest.raises(GraspBenchError, match=r"\(No space left on device\)\. Free some space\.$"):
        train(TrainConfig(network="gg-cnn", steps=1, batch=2), load_scenes([folder]), tmp_path / "x")
    (tmp_path / "file").touch()
    with pytest.raises(GraspBenchError, match=r"written \(Not a directory\)\. Mend that, or choose"):
        train(TrainConfig(network="gg-cnn", steps=1, batch=2), load_scenes([folder]), tmp_path / "file" / "x")
