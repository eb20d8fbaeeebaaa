"""Cornell and Jacquard: reading, level depth, frames, folds, and scenes to train on."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from real_samples import cornell_lines, real_samples, write_cornell, write_jacquard
from test_training import draw_scene, store_scene

from grasp_bench.errors import AssetError, GraspBenchError, UnknownNameError
from grasp_bench.grasps import Grasp, angle_difference
from grasp_bench.learning.data.cornell import Cornell
from grasp_bench.learning.data.folds import make_folds, parse_holdout
from grasp_bench.learning.data.framing import Frame, framed
from grasp_bench.learning.data.jacquard import Jacquard, corners_from_rows, row_from_grasp
from grasp_bench.learning.data.opening import open_collection
from grasp_bench.learning.data.pictures import sample_sheet
from grasp_bench.learning.data.real import RealScenes, scene_from_sample
from grasp_bench.learning.evaluation.evaluate import Question, evaluate
from grasp_bench.learning.evaluation.fold_training import Training
from grasp_bench.learning.training.augment import View, crop_scene
from grasp_bench.learning.training.batches import make_batch
from grasp_bench.learning.training.config import TrainConfig
from grasp_bench.learning.training.sources import Mixture, Source, gather
from grasp_bench.networks.encoding import encode_depth
from grasp_bench.predictors.tabletop import levelled, table_surface

GRASPS = [Grasp(300 + 5 * i, 250 - 4 * i, -1.2 + 0.4 * i, 60.0) for i in range(6)]
SMALL = [Grasp(120 + 3 * i, 130.0, 1.3 - 0.5 * i, 40.0) for i in range(6)]


# --- reading ------------------------------------------------------------------------------


@pytest.mark.parametrize("cloud", [False, True], ids=["tiff", "point cloud"])
def test_cornell(tmp_path: Path, cloud: bool) -> None:
    found = open_collection(write_cornell(tmp_path, GRASPS[:2], cloud=cloud))
    assert isinstance(found, Cornell)
    assert [e.name for e in found.entries] == ["pcd0100", "pcd0101"]
    assert not found.knows_objects
    assert "2 images of 885" in found.describe()
    assert "object ids not in this copy" in found.describe()
    first, second = map(found.load, found.entries)
    assert (first.dropped, len(first.rectangles), second.dropped) == (1, 1, 0)
    assert first.rgb.shape == (480, 640, 3)
    best = second.grasps()[0]
    assert (best.x, best.y, best.width) == pytest.approx((GRASPS[1].x, GRASPS[1].y, 60), abs=0.01)
    assert angle_difference(best.angle, GRASPS[1].angle) < 1e-3
    valid = second.depth > 0
    assert valid.mean() == pytest.approx(6 / 7 if cloud else 1, abs=1e-3)
    expected = 1 - 0.5 * (np.arange(480) / 480 - 0.5)
    np.testing.assert_allclose(second.depth[:, 0][valid[:, 0]], (expected - 0.0125)[valid[:, 0]], atol=1e-4)


def test_cornell_object_ids(tmp_path: Path) -> None:
    found = open_collection(write_cornell(tmp_path, GRASPS, objects=[7, 7, 7, 8, 8, 9]))
    assert [e.object for e in found.entries] == ["7", "7", "7", "8", "8", "9"]
    assert "3 objects" in found.describe()


def test_cornell_in_colour_only(tmp_path: Path) -> None:
    """JPEG or PNG; networks that need depth refuse it, naming files, and those of colour learn from it."""
    root = write_cornell(tmp_path / "cornell", GRASPS, objects=[7, 7, 7, 8, 8, 9])
    for i, path in enumerate(sorted(root.rglob("*r.png"))):
        if i % 2:
            path.rename(path.with_suffix(".jpg"))
    kept = next(root.rglob("*d.tiff"))
    for path in root.rglob("*d.tiff"):
        if path != kept:
            path.unlink()
    partly = open_collection(root)
    assert partly.has_depth
    assert (len(partly.entries), len(partly.missing)) == (1, 5), "a copy that lost files is no other copy"
    kept.unlink()
    found = open_collection(root)
    assert not found.has_depth
    assert (len(found.entries), found.missing) == (6, [])
    assert "Colour only" in found.describe()
    sample = found.load(found.entries[1])
    assert sample.depth.shape == sample.rgb.shape[:2]
    assert not sample.depth.any()
    scenes = gather([Source(root)], 224, holdout=(0, 3), kind="rgb")
    assert len(scenes.train) in (3, 4, 5)
    inputs, targets = make_batch(scenes.train, TrainConfig(batch=2, input="rgb"), "rgb", 224, 0)
    assert inputs.shape == (2, 3, 224, 224)
    assert targets[:, 0].max() == 1
    with pytest.raises(AssetError, match=r"rgbd.*colour only: 01/pcd0100d\.tiff.*3 more.*--input rgb"):
        gather([Source(root)], 224, kind="rgbd")
    with pytest.raises(AssetError, match="htc-grasp is shown rgbd"):
        evaluate(Question("htc-grasp", "cornell", root))
    with pytest.raises(AssetError, match="centroid is shown rgbd"):
        evaluate(Question("centroid", "cornell", root))


def test_a_network_of_colour_is_trained_and_evaluated_on_colour(tmp_path: Path) -> None:
    root = write_cornell(tmp_path / "cornell", GRASPS, objects=[7, 7, 7, 8, 8, 9])
    for path in root.rglob("*d.tiff"):
        path.unlink()
    settings = TrainConfig(steps=1, batch=1, threads=1, precision="fp32", input="rgb")
    training = Training(settings, None, [], 1.0, tmp_path / "runs")
    question = Question("gr-convnet-16", "cornell", root, folds=3, only=2)
    result = evaluate(question, training)
    assert result.images in (1, 2, 3)
    assert result.weights is not None
    assert result.weights.input == "rgb 224"


@pytest.mark.parametrize("depth", ["perfect", "stereo"])
@pytest.mark.parametrize("short", [False, True], ids=["long names", "short names"])
def test_jacquard(tmp_path: Path, depth: str, short: bool) -> None:
    root = write_jacquard(tmp_path, SMALL[:2], views=1 if short else 2, short=short)
    found = open_collection(root, depth=depth)
    assert isinstance(found, Jacquard)
    assert [e.object for e in found.entries] == (["obj0abc", "obj1abc"] if short else ["obj0abc"] * 2)
    sample = found.load(found.entries[1])
    assert len(sample.rectangles) == 2
    assert (sample.depth == 0).mean() == (0 if depth == "perfect" else 4 / 256)
    for grasp, rectangle, jaw in zip(sample.grasps(), sample.rectangles, (12, 20), strict=True):
        assert (grasp.x, grasp.y, grasp.width) == pytest.approx((123, 130, 40))
        assert angle_difference(grasp.angle, SMALL[1].angle) < 1e-6
        assert np.hypot(*(rectangle[2] - rectangle[1])) == pytest.approx(jaw)


def test_jacquard_angles_are_clockwise() -> None:
    """30° in the file: the jaws open to the right and *down* in the image."""
    corners = corners_from_rows(np.array([[100.0, 80.0, 30.0, 40.0, 10.0]]))[0]
    along = (corners[1] - corners[0]) / 40
    np.testing.assert_allclose(along, [math.cos(math.pi / 6), math.sin(math.pi / 6)], atol=1e-9)
    again = [float(v) for v in row_from_grasp(Grasp.from_rectangle(corners), 10).split(";")]
    assert again == pytest.approx([100, 80, 30, 40, 10])


def test_missing_files_are_named(tmp_path: Path) -> None:
    root = write_cornell(tmp_path, GRASPS[:3])
    (root / "01" / "pcd0101r.png").unlink()
    (root / "01" / "pcd0102d.tiff").unlink()
    found = open_collection(root)
    assert found.missing == ["01/pcd0101r.png", "01/pcd0102d.tiff"]
    assert "2 files missing: 01/pcd0101r.png" in found.describe()
    (root / "01" / "pcd0100r.png").unlink()
    with pytest.raises(AssetError, match=r"complete: 01/pcd0100r\.png"):
        open_collection(root)


def test_pictures_of_jacquard_without_grasps_are_named(tmp_path: Path) -> None:
    root = write_jacquard(tmp_path, GRASPS[:4])
    (root / "obj1abc" / "0_obj1abc_grasps.txt").unlink()
    found = open_collection(root)
    assert len(found.entries) == 3
    assert found.missing == ["obj1abc/0_obj1abc_grasps.txt"]


def test_a_training_names_what_a_copy_lacks(tmp_path: Path) -> None:
    root = write_cornell(tmp_path, GRASPS[:4])
    assert gather([Source(root)], 224, kind="rgbd").notes == ()
    (root / "01" / "pcd0101d.tiff").unlink()
    (root / "01" / "pcd0103cpos.txt").unlink()
    found = gather([Source(root)], 224, kind="rgbd")
    assert len(found.train) == 2
    (note,) = found.notes
    assert "Incomplete samples left out, 2 files missing: 01/pcd0101d.tiff, 01/pcd0103cpos.txt." in note
    for number in range(100, 103):
        (root / "01" / f"pcd0{number}cpos.txt").unlink()
    with pytest.raises(
        AssetError, match=r"is complete: 01/pcd0100cpos\.txt, 01/pcd0101cpos\.txt, 01/pcd0102"
    ):
        open_collection(root)


def test_folders_that_hold_nothing(tmp_path: Path) -> None:
    with pytest.raises(AssetError, match=r"no Cornell .* and no Jacquard"):
        open_collection(tmp_path)
    with pytest.raises(AssetError, match=r"not a folder; give the root of a Cornell"):
        open_collection(tmp_path / "nowhere")
    with pytest.raises(AssetError, match=r"no generated scenes \(index\.jsonl\), no Cornell .* no Jacquard"):
        sample_sheet(tmp_path, 1, tmp_path / "x.png")
    with pytest.raises(AssetError, match=r"no generated scenes .*`grasp-bench data synth`"):
        gather([Source(tmp_path)], 224, kind="depth")
    (tmp_path / "index.jsonl").touch()
    with pytest.raises(AssetError, match=r"no Jacquard .* files but generated scenes; give the root"):
        open_collection(tmp_path)
    with pytest.raises(AssetError, match="no Jacquard"):
        open_collection(write_cornell(tmp_path, GRASPS[:1]), "jacquard")
    with pytest.raises(UnknownNameError, match="stereo"):
        open_collection(tmp_path, "jacquard", depth="sterio")


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("pcd0101cpos.txt", b"1 2\n3 4\n5 6\n", "3 lines"),
        ("pcd0101cpos.txt", b"1 2\n3 four\n5 6\n7 8\n", "line 2: expected 2 numbers, got '3 four'"),
        ("pcd0101cpos.txt", b"1 2\n\xff\xfe\n", "cannot be read"),
        ("pcd0101r.png", b"\x89PNG nonsense", "not an image"),
        ("pcd0101d.tiff", b"II*\x00", "not a depth image"),
    ],
)
def test_damaged_files_are_named(tmp_path: Path, name: str, content: bytes, message: str) -> None:
    found = open_collection(write_cornell(tmp_path, GRASPS[:2]))
    (tmp_path / "01" / name).write_bytes(content)
    with pytest.raises(AssetError, match=message) as caught:
        found.load(found.entries[1])
    assert name in str(caught.value)


def test_damaged_clouds_are_named(tmp_path: Path) -> None:
    found = open_collection(write_cornell(tmp_path, GRASPS[:1], cloud=True))
    path = tmp_path / "01" / "pcd0100.txt"
    whole = path.read_text()
    for spoilt in (whole[:-60], whole.replace("FIELDS", "FELDS"), "nothing", whole + "1 2 3 4 999999\n"):
        path.write_text(spoilt)
        with pytest.raises(AssetError, match=r"pcd0100\.txt"):
            found.load(found.entries[0])


def test_depth_of_another_size_is_refused(tmp_path: Path) -> None:
    found = open_collection(write_jacquard(tmp_path, SMALL[:1]))
    import cv2

    cv2.imwrite(str(found.entries[0].depth), np.ones((10, 256), np.float32))
    with pytest.raises(AssetError, match=r"256×256.*\(10, 256\)"):
        found.load(found.entries[0])


# --- level depth --------------------------------------------------------------------------


def test_levelled_depth_shows_the_height_only(tmp_path: Path) -> None:
    """A table that falls by half a metre, with a wall behind and holes."""
    found = open_collection(write_cornell(tmp_path, GRASPS[:1]))
    depth = found.load(found.entries[0]).depth
    depth[:90] -= 0.2
    depth[::17, ::13] = 0
    level = levelled(depth, 320)
    table = np.median(level[level > 0])
    h = table - level[130:400, 170:470]
    valid = level[130:400, 170:470] > 0
    assert (level[depth == 0] == 0).all()
    on = valid & (h > 0.025)
    assert np.median(h[on]) == pytest.approx(0.05, abs=1e-3)
    assert np.abs(h[valid & ~on]).max() < 2e-3
    assert encode_depth(level[80:400, 160:480]).max() == pytest.approx(2.0, abs=0.2), "the wall"


def test_levelling_keeps_a_level_table() -> None:
    rng = np.random.default_rng(0)
    depth = (0.7 + rng.normal(0, 5e-4, (200, 200))).astype(np.float32)
    depth[80:120, 60:140] -= 0.04
    np.testing.assert_allclose(levelled(depth, 180), depth, atol=1e-3)


def test_nothing_measured_is_left_alone() -> None:
    empty = np.zeros((50, 50), np.float32)
    assert table_surface(empty, 40) is None
    assert levelled(empty, 40) is empty


# --- frames -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "frame",
    [
        Frame(320, 240, 320, 224),
        Frame(320, 240, 427, 299),
        Frame(301.5, 240.25, 220, 224),
        Frame(30, 470, 300, 210),
    ],
    ids=str,
)
def test_labels_follow_the_frame(tmp_path: Path, frame: Frame) -> None:
    found = open_collection(write_cornell(tmp_path, [GRASPS[0], Grasp(95, 400, 1.4, 60)]))
    sample = found.load(found.entries[frame.x < 100])
    seen = framed(sample, frame, round(0.75 * frame.side))
    assert seen.rgb.shape == (frame.side, frame.side, 3)
    assert seen.depth.dtype == np.float32
    grasp = Grasp.from_rectangle(seen.rectangles[0])
    truth, scale = sample.grasps()[0], frame.side / frame.extent
    back = (frame.x + (grasp.x - frame.side / 2) / scale, frame.y + (grasp.y - frame.side / 2) / scale)
    assert (*back, grasp.width / scale) == pytest.approx((truth.x, truth.y, truth.width))
    rows, columns = np.nonzero(seen.rgb[..., 0] > 150)
    assert (columns.mean() + 0.5, rows.mean() + 0.5) == pytest.approx((grasp.x, grasp.y), abs=1.2)


# --- folds --------------------------------------------------------------------------------


def test_folds_of_unknown_objects_are_contiguous() -> None:
    folds = make_folds([None] * 11, 4, "object")
    assert folds.test == [[0, 1, 2], [3, 4, 5], [6, 7, 8], [9, 10]]
    assert "contiguous blocks" in folds.how
    assert folds.train(1) == [0, 1, 2, 6, 7, 8, 9, 10]


def test_objects_stay_together() -> None:
    objects = [f"o{i % 7}" for i in range(30)]
    folds = make_folds(objects, 3, "object")
    assert sorted(i for part in folds.test for i in part) == list(range(30))
    for k, part in enumerate(folds.test):
        assert not {objects[i] for i in part} & {objects[i] for i in folds.train(k)}
        assert 8 <= len(part) <= 12
    assert "7 in all" in folds.how


def test_images_at_random() -> None:
    one, same, other = (make_folds(["a"] * 20, 5, "image", seed=s) for s in (1, 1, 2))
    assert one == same != other
    assert sorted(i for part in one.test for i in part) == list(range(20))


@pytest.mark.parametrize(
    ("objects", "count", "split"),
    [(["a", "a", "b"], 3, "object"), ([None] * 3, 4, "object"), ([None] * 3, 0, "image")],
)
def test_impossible_folds(objects: list, count: int, split) -> None:
    with pytest.raises(GraspBenchError, match="--folds from 1 to"):
        make_folds(objects, count, split)


def test_holdout_option() -> None:
    assert parse_holdout("2/5") == (1, 5)
    for wrong in ("0/5", "6/5", "2", "a/b", "-1/5"):
        with pytest.raises(GraspBenchError, match="2/5"):
            parse_holdout(wrong)


# --- scenes to train on -------------------------------------------------------------------


def test_scene_of_a_sample(tmp_path: Path) -> None:
    found = open_collection(write_jacquard(tmp_path, SMALL[2:3]))
    scene = scene_from_sample(found.load(found.entries[0]), 256, 224)
    assert (scene.size, scene.name) == (299, "0_obj0abc")
    rgb, depth, labels = crop_scene(scene, View(), 224)
    grasp = SMALL[2]
    expected = (np.array([grasp.x, grasp.y]) - 128) * 224 / 256 + 112
    rows, columns = np.nonzero(labels.quality == 1)
    assert (columns.mean() + 0.5, rows.mean() + 0.5) == pytest.approx(tuple(expected), abs=1.0)
    on = labels.quality > 0
    np.testing.assert_allclose(labels.width[on], 40 * 224 / 256, rtol=2e-3)
    assert max(angle_difference(float(a), grasp.angle) for a in labels.angle[on]) < 2e-3
    assert scene.truths()[0].width == pytest.approx(35)
    assert rgb[rows[0], columns[0], 0] > 150
    height = np.median(depth[depth > 0]) - depth[int(expected[1]), int(expected[0])]
    assert height == pytest.approx(0.05, abs=2e-3)


def test_mixture_draws_by_weight(tmp_path: Path) -> None:
    (tmp_path / "synth" / "scenes").mkdir(parents=True)
    for k in range(3):
        store_scene(tmp_path / f"synth/scenes/{k:06d}.npz", draw_scene([GRASPS[0]], seed=k))
    (tmp_path / "synth" / "index.jsonl").write_text(
        "".join(f'{{"file": "scenes/{k:06d}.npz", "split": "train"}}\n' for k in range(3))
    )
    root = write_cornell(tmp_path / "cornell", GRASPS)
    plain = gather([Source(tmp_path / "synth"), Source(root)], 224, holdout=(1, 3), kind="rgbd")
    assert (len(plain.train), len(plain.val)) == (3 + 4, 2)
    assert isinstance(plain.train, Mixture)
    assert plain.train.shares is None
    weighted = gather([Source(tmp_path / "synth", 1), Source(root, 3)], 224, kind="rgbd")
    assert isinstance(weighted.train, Mixture)
    draws = [weighted.train.draw(np.random.default_rng(i)) for i in range(600)]
    assert {*draws} == set(range(9))
    assert sum(d >= 3 for d in draws) / 600 == pytest.approx(0.75, abs=0.05)
    assert weighted.fingerprint != plain.fingerprint
    names = [s.name for s in weighted.train]
    assert names[2:4] == ["000002", "pcd0100"]
    x, y = make_batch(weighted.train, TrainConfig(batch=2), "rgbd", 224, 3)
    assert (x.shape, y.shape) == ((2, 4, 224, 224), (2, 4, 224, 224))
    again, _ = make_batch(weighted.train, TrainConfig(batch=2), "rgbd", 224, 3)
    np.testing.assert_array_equal(x, again)
    with pytest.raises(GraspBenchError, match="either all"):
        gather([Source(tmp_path / "synth", 1), Source(root)], 224, kind="rgbd")
    with pytest.raises(GraspBenchError, match="leaves out real images"):
        gather([Source(tmp_path / "synth")], 224, holdout=(0, 2), kind="rgbd")


def test_sources(tmp_path: Path) -> None:
    assert Source.parse("a/b") == Source(Path("a/b"))
    assert Source.parse("a/b:0.25") == Source(Path("a/b"), 0.25)
    assert Source.parse("c:d") == Source(Path("c:d"))
    (tmp_path / "x:2").mkdir()
    assert Source.parse(str(tmp_path / "x:2")) == Source(tmp_path / "x:2")
    for wrong in ("a:0", "a:-1", "a:inf", "a:nan"):
        with pytest.raises(GraspBenchError, match="positive"):
            Source.parse(wrong)


def test_samples_are_drawn(tmp_path: Path) -> None:
    import cv2

    from grasp_bench.learning.data.pictures import sample_sheet

    root = write_jacquard(tmp_path / "j", SMALL)
    assert sample_sheet(root, 2, tmp_path / "sheet.png") == ["0_obj0abc", "1_obj2abc"]
    sheet = cv2.imread(str(tmp_path / "sheet.png"))
    assert sheet is not None
    assert sheet.shape == (299, 10 * 299, 3)


# --- the real thing -----------------------------------------------------------------------


def test_real_cornell_samples() -> None:
    found = open_collection(real_samples("cornell"), "cornell")
    assert not found.missing
    samples = [found.load(e) for e in found.entries if e.name in ("pcd0100", "pcd0115", "pcd0132")]
    assert [s.dropped for s in samples] == [0, 0, 2]
    for sample in samples:
        level = levelled(sample.depth, found.window)
        middle = level[200:400, 160:480]
        table = np.median(level[80:400, 160:480])
        assert (np.abs(table - middle) < 0.006).mean() > 0.75, "the table is level"
    scenes = RealScenes(found, [0, 15], 224)
    assert [s.quality.max() for s in scenes] == [255, 255]


def test_real_jacquard_samples() -> None:
    found = open_collection(real_samples("jacquard"), "jacquard")
    assert found.knows_objects
    sample = found.load(found.entries[0])
    inside = [np.array([g.x, g.y]) for g in sample.grasps()]
    import cv2

    mask = cv2.imread(str(found.entries[0].labels).replace("grasps.txt", "mask.png"), cv2.IMREAD_GRAYSCALE)
    assert mask is not None
    near = cv2.dilate(mask, np.ones((25, 25), np.uint8))
    assert np.mean([near[int(y), int(x)] > 0 for x, y in inside]) > 0.95, "grasps lie on the object"


def test_nan_rectangles_alone(tmp_path: Path) -> None:
    root = write_cornell(tmp_path, GRASPS[:1])
    entry = open_collection(root).entries[0]
    (root / "01" / "pcd0100cpos.txt").write_text("NaN NaN\n" * 4 + cornell_lines([]))
    with pytest.raises(AssetError, match=r"1 images left out that have no usable label: 01/pcd0100cpos\.txt"):
        open_collection(root)
    sample = Cornell.open(root).load(entry)
    assert sample.rectangles.shape == (0, 4, 2)
    assert sample.dropped == 1
    assert scene_from_sample(sample, 320, 224).grasps.shape == (0, 5)
