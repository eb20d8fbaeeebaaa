"""The rectangle metric, both protocols, evaluation with and without training for each fold, the tables."""

from __future__ import annotations

import json
import math
import re
import shutil
from pathlib import Path
from typing import Any, get_args

import cv2
import numpy as np
import pytest
import torch
from committed import RESULTS
from real_samples import write_cornell, write_jacquard
from test_real_data import GRASPS, SMALL
from test_training import folder  # noqa: F401 (eight synthetic scenes)
from typer.testing import CliRunner

from grasp_bench.cli import app
from grasp_bench.errors import AssetError, GraspBenchError
from grasp_bench.grasps import Grasp, GraspMaps, rectangle_iou
from grasp_bench.learning.data.opening import open_collection
from grasp_bench.learning.evaluation.evaluate import Question, evaluate
from grasp_bench.learning.evaluation.fold_training import Training
from grasp_bench.learning.evaluation.metric import judge, legacy_best, raster_iou
from grasp_bench.learning.evaluation.protocols import CONVENTIONS, best_grasp, make_case
from grasp_bench.learning.training.config import TrainConfig
from grasp_bench.networks.registry import NETWORKS
from grasp_bench.networks.store import WeightsFile, shipped_file
from grasp_bench.networks.weights import with_facts
from grasp_bench.report.accuracy import accuracy_table
from grasp_bench.report.paper import TABLE_1, TABLE_2
from grasp_bench.report.published import FAR, PUBLISHED, published_table
from grasp_bench.report.since import SINCE, since_table
from grasp_bench.report.tables import markdown
from grasp_bench.runs.evaluation import Evaluation, Verdict


class Bar:
    """Finds the reddish bar of the tests' images by its colour, and closes across it."""

    def predict(self, image) -> list[Grasp]:
        rows, columns = np.nonzero(image.rgb[..., 0] > 150)
        points = np.stack([columns + 0.5, rows + 0.5])
        axis = np.linalg.eigh(np.cov(points))[1][:, 0]  # the short axis
        x, y = points.mean(axis=1)
        spread = np.ptp(axis @ (points - [[x], [y]]))
        return [Grasp(float(x), float(y), math.atan2(-axis[1], axis[0]), float(spread / 0.6))]


class Beside(Bar):
    """The same, a bar's length away."""

    def predict(self, image) -> list[Grasp]:
        grasp = super().predict(image)[0]
        return [Grasp(min(grasp.x + 70, 223), grasp.y, grasp.angle, grasp.width)]


class Blind:
    """Never finds anything."""

    def predict(self, image) -> list[Grasp]:
        return []


# --- metric -------------------------------------------------------------------------------

LABEL = Grasp(100, 100, 0.3, 40).rectangle(height=20)[None]


def test_verdicts() -> None:
    assert judge(Grasp(100, 100, 0.3, 40), LABEL).iou == pytest.approx(1.0)
    assert judge(Grasp(100, 100, 0.3 + math.radians(29), 40), LABEL).verdict == "correct"
    off = judge(Grasp(100, 100, 0.3 + math.radians(31), 40), LABEL)
    assert (off.verdict, off.iou) == ("wrong_angle", 0.0)
    assert math.degrees(off.angle) == pytest.approx(31)
    assert judge(Grasp(100, 100, 0.3 + math.pi, 40), LABEL).verdict == "correct", "a half turn"
    assert judge(Grasp(160, 100, 0.3, 40), LABEL).verdict == "elsewhere"
    assert judge(None, LABEL).verdict == "none"
    assert judge(Grasp(1, 1, 0, 4), np.zeros((0, 4, 2))).verdict == "elsewhere"


def test_overlap_must_be_above_a_quarter_strictly() -> None:
    """Four congruent rectangles in a row: one in four overlaps by exactly 1/4 of the union."""
    grasp = Grasp(50, 50, 0.0, 40)  # 40 × 20
    quarter = np.array([[[30, 40], [190, 40], [190, 60], [30, 60]]], float)  # holds it, four times as large
    assert judge(grasp, quarter).iou == pytest.approx(0.25)
    assert judge(grasp, quarter).verdict == "elsewhere"
    assert judge(grasp, quarter * [0.999, 1]).verdict == "correct"


def test_labels_keep_their_height() -> None:
    flat = Grasp(100, 100, 0, 40).rectangle(height=4)[None]
    assert judge(Grasp(100, 100, 0, 40), flat).iou == pytest.approx(4 / 20)


@pytest.mark.parametrize("shift", [0, 7, 20, 80])
def test_counted_pixels_are_near_the_area(shift: float) -> None:
    one, two = Grasp(50, 50, 0.4, 60).rectangle(), Grasp(50 + shift, 55, 0.1, 50).rectangle()
    assert raster_iou(one, two) == pytest.approx(rectangle_iou(one, two), abs=0.05)


def test_legacy_peak_smears_the_seam() -> None:
    """At ±90° the lineage's filter averages +89° and −89° to nothing; sine and cosine do not."""
    quality = np.exp(-((np.mgrid[0:80, 0:80] - 40) ** 2).sum(0) / 50).astype(np.float32)
    angle = np.where(np.arange(80) % 2, 1.55, -1.55)[None].repeat(80, 0)
    maps = GraspMaps(
        quality,
        np.sin(2 * angle).astype(np.float32),
        np.cos(2 * angle).astype(np.float32),
        np.full((80, 80), 30, np.float32),
    )
    legacy = legacy_best(maps)
    assert legacy is not None
    assert (legacy.x, legacy.y, legacy.width) == pytest.approx((40.5, 40.5, 30))
    assert abs(legacy.angle) < 0.2
    assert abs(abs(maps.smoothed().peaks()[0].angle) - math.pi / 2) < 0.05
    assert legacy_best(GraspMaps(0.15 * quality, *(quality,) * 3)) is None, "below the threshold"
    border = np.roll(quality, 30, 0) * (np.arange(80) > 61)[:, None]
    assert legacy_best(GraspMaps(border, *(quality,) * 3)) is None, "too near the border"


# --- protocols ----------------------------------------------------------------------------


def test_strict_does_not_look_at_labels(tmp_path: Path) -> None:
    found = open_collection(write_cornell(tmp_path, GRASPS[:2]))
    before = make_case(found, 1, 224, "strict")
    path = found.entries[1].labels
    path.write_text("1 1\n9 1\n9 5\n1 5\n")
    after = make_case(found, 1, 224, "strict")
    np.testing.assert_array_equal(before.rgb, after.rgb)
    np.testing.assert_array_equal(before.depth, after.depth)
    assert not np.array_equal(make_case(found, 1, 224, "legacy").rgb, before.rgb)
    with_others = make_case(found, 1, 224, "strict").rectangles
    np.testing.assert_allclose(with_others[0, 0], (np.array([1, 1]) - (160, 80)) * 0.7)


@pytest.mark.parametrize("dataset", ["cornell", "jacquard"])
def test_labels_follow_the_legacy_view(tmp_path: Path, dataset: str) -> None:
    """Whatever turn and zoom are drawn, the bar in the picture is where its label says."""
    root = write_cornell(tmp_path, GRASPS) if dataset == "cornell" else write_jacquard(tmp_path, SMALL)
    found = open_collection(root)
    widths = []
    for i in range(len(found.entries)):
        case = make_case(found, i, 224, "legacy")
        grasp = Bar().predict(case)[0]
        label = Grasp.from_rectangle(case.rectangles[0])
        widths.append(label.width)
        assert judge(grasp, case.rectangles).verdict == "correct" or label.width > 60, i
    assert len({round(w) for w in widths}) > 1, "zoomed"


def test_legacy_needs_maps(tmp_path: Path) -> None:
    found = open_collection(write_cornell(tmp_path, GRASPS[:1]))
    with pytest.raises(GraspBenchError, match="strict"):
        best_grasp(Bar(), make_case(found, 0, 224, "legacy"), "legacy", np.random.default_rng(0))


def test_legacy_is_native_and_not_levelled(tmp_path: Path) -> None:
    """The lineage cuts 224 px out of Cornell's 640 for a network of 224, and 300 for one of 300."""
    found = open_collection(write_cornell(tmp_path, GRASPS))
    for crop in (224, 300):
        for i, entry in enumerate(found.entries):
            case, sample = make_case(found, i, crop, "legacy"), found.load(entry)
            zoom = Grasp.from_rectangle(case.rectangles[0]).width / sample.grasps()[0].width
            assert 1 - 1e-9 <= zoom <= 2 + 1e-9, "no other scale than the lineage's zoom of 1 to 2"
            assert set(np.unique(case.depth)) <= set(np.unique(sample.depth)), "measured values only"


class Maps(Bar):
    """Has maps as the extended protocol wants them, or not quite."""

    crop = 96
    says: Any = None

    def maps(self, image) -> Any:
        assert image.depth.shape == (96, 96)
        return self.says


class Raises(Bar):
    """Fails on its second image, like many a script."""

    def __init__(self) -> None:
        self.shown = 0

    def predict(self, image) -> list[Grasp]:
        self.shown += 1
        if self.shown == 2:
            raise SystemExit(3)
        return super().predict(image)


def test_a_failure_costs_one_image(tmp_path: Path) -> None:
    root = write_cornell(tmp_path, GRASPS)
    result = invoke(
        "evaluate", "--dataset", "cornell", "--root", root, "--predictor", "test_evaluation:Raises"
    )
    assert result.exit_code == 0, result.output
    assert "failed on 1 of 6 images" in " ".join(result.output.split())
    records = evaluate(Question("test_evaluation:Raises", "cornell", root)).records
    assert [r.verdict for r in records] == ["correct", "error", *["correct"] * 4]


@pytest.mark.parametrize(
    ("says", "error"),
    [(None, "got NoneType"), (GraspMaps(*(np.zeros((9, 9), np.float32),) * 4), r"of \(9, 9\) px")],
)
def test_maps_are_checked(tmp_path: Path, says: Any, error: str) -> None:
    found = open_collection(write_cornell(tmp_path, GRASPS[:1]))
    predictor = Maps()
    predictor.says = says
    answer = best_grasp(predictor, make_case(found, 0, 96, "legacy"), "legacy", np.random.default_rng(0))
    assert re.search(error, str(answer.error))


def test_the_rim_may_be_left_out(tmp_path: Path) -> None:
    class Rim:
        def predict(self, image) -> list[Grasp]:
            return [Grasp(9, 100, 0.0, 20), Grasp(100, 200, 0.0, 20), Grasp(50, 50, 0.0, 20)]

    found = open_collection(write_cornell(tmp_path, GRASPS[:1]))
    case = make_case(found, 0, 224, "strict")
    xs = [best_grasp(Rim(), case, "strict", np.random.default_rng(0), rim).grasp for rim in (0, 20, 30)]
    assert [g.x for g in xs if g] == [9, 100, 50]
    common = ("evaluate", "--dataset", "cornell", "--root", tmp_path, "--rim", 3, "--protocol", "legacy")
    assert "--rim is for" in str(invoke(*common).exception)
    asked = Question("test_evaluation:Bar", "cornell", tmp_path, rim=20)
    assert evaluate(asked).conventions["rim"].startswith("grasps within 20 px")


def test_pictures_of_failures(tmp_path: Path) -> None:
    root = write_cornell(tmp_path / "c", GRASPS)
    common = ("evaluate", "--dataset", "cornell", "--root", root, "--pictures")
    said = invoke(*common, tmp_path / "p", "--predictor", "test_evaluation:Beside").output
    assert "6 pictures" in said
    drawn = [cv2.imread(str(p)) for p in sorted((tmp_path / "p").iterdir())]
    assert [d.shape for d in drawn if d is not None] == [(24 + 3 * 224, 2 * 3 * 224, 3)] * 6
    assert all(((d[..., 2] > 200) & (d[..., 1] < 60)).sum() > 100 for d in drawn if d is not None)
    invoke(*common, tmp_path / "none", "--predictor", "test_evaluation:Bar")
    assert not (tmp_path / "none").exists()


# --- evaluation ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("predictor", "verdict"), [("Bar", "correct"), ("Beside", "elsewhere"), ("Blind", "none")]
)
@pytest.mark.parametrize("dataset", ["cornell", "jacquard"])
def test_evaluate(tmp_path: Path, dataset: Any, predictor: str, verdict: str) -> None:
    root = write_cornell(tmp_path, GRASPS) if dataset == "cornell" else write_jacquard(tmp_path, SMALL)
    result = evaluate(Question(f"test_evaluation:{predictor}", dataset, root, folds=3))
    assert result.verdicts == dict.fromkeys(get_args(Verdict), 0) | {verdict: 6}
    assert [f.images for f in result.folds] == [2, 2, 2]
    assert (result.correct, result.images) == (6 * (verdict == "correct"), 6)
    assert result.dropped_rectangles == (dataset == "cornell")
    assert ("contiguous" in result.how) == (dataset == "cornell")
    one = evaluate(Question(f"test_evaluation:{predictor}", dataset, root, folds=3, only=2))
    assert [r.image for r in one.records] == [r.image for r in result.records if r.fold == 2]
    result.write(tmp_path / "r.json")
    assert Evaluation.read(tmp_path / "r.json") == result


def test_evaluate_synthetic(folder: Path) -> None:  # noqa: F811
    class White(Bar):
        def predict(self, image) -> list[Grasp]:
            image.rgb[..., 0] = np.where(image.rgb[..., 0] > 150, 200, 0)
            return [Grasp(g.x, g.y, g.angle, g.width) for g in super().predict(image)]

    import test_evaluation

    test_evaluation.White = White  # type: ignore[attr-defined]
    result = evaluate(Question("test_evaluation:White", "synthetic", folder))
    assert (result.correct, result.images) == (2, 2)
    with pytest.raises(GraspBenchError, match="one protocol"):
        evaluate(Question("test_evaluation:White", "synthetic", folder, folds=2))


def test_a_model_is_trained_for_each_fold(tmp_path: Path, folder: Path) -> None:  # noqa: F811
    root = write_jacquard(tmp_path / "jacquard", SMALL, views=2)
    config = TrainConfig(network="gg-cnn", steps=2, batch=2, threads=1, precision="fp32")
    training = Training(config, None, [folder], 0.5, tmp_path / "runs")
    question = Question("gg-cnn", "jacquard", root, folds=3)
    result = evaluate(question, training)
    assert [f.trained.real_images for f in result.folds if f.trained] == [4, 4, 4]
    assert result.trained is not None
    assert result.trained.scenes == 4 + 6
    tested = {r.image: r.fold for r in result.records}
    for fold in (1, 2, 3):
        metadata = WeightsFile(tmp_path / f"runs/fold-{fold}-of-3/gg-cnn.safetensors").metadata()
        assert sorted(metadata["left_out"]) == sorted(n for n, f in tested.items() if f == fold)
    again = evaluate(question, training)
    assert [r.iou for r in again.records] == [r.iou for r in result.records]
    other = Training(config.model_copy(update={"lr": 0.5}), None, [folder], 0.5, tmp_path / "runs")
    with pytest.raises(AssetError, match=r"lr was 0.001, is 0.5.*another --runs"):
        evaluate(question, other)
    table = markdown([accuracy_table("jacquard", [result])])
    assert "gg-cnn, trained per fold" in table
    assert "2 steps of 2 on the other folds and" in table
    begun = Training(config, tmp_path / "runs/fold-1-of-3/gg-cnn.safetensors", [], 1.0, tmp_path / "more")
    facts = evaluate(Question("gg-cnn", "jacquard", root, folds=3, only=1), begun).trained
    assert facts is not None
    assert str(facts.begun_with).startswith("gg-cnn.safetensors ")
    assert facts.real_share == 1.0


def test_training_starts_from_given_weights(tmp_path: Path) -> None:
    """With a rate of almost nothing the fine-tuned weights are those begun with."""
    from grasp_bench.learning.training.loop import train
    from grasp_bench.learning.training.sources import Source, gather
    from grasp_bench.networks.registry import build
    from grasp_bench.networks.weights import load, save

    torch.manual_seed(3)
    save(build("gg-cnn"), tmp_path / "start.safetensors", {"network": "gg-cnn", "input": "depth 224"})
    start, _ = load("gg-cnn", tmp_path / "start.safetensors")
    scenes = gather([Source(write_jacquard(tmp_path / "j", SMALL[:2]))], 224, kind="rgbd")
    config = TrainConfig(network="gg-cnn", steps=1, batch=1, threads=1, lr=1e-12, precision="fp32", init="x")
    ended = train(config, scenes, tmp_path / "run", None, tmp_path / "start.safetensors").network
    fresh = train(config.model_copy(update={"init": None}), scenes, tmp_path / "fresh").network
    for (name, a), b, c in zip(start.named_parameters(), ended.parameters(), fresh.parameters(), strict=True):
        torch.testing.assert_close(a, b, msg=name)
        if a.dim() > 1:
            assert not torch.allclose(a, c), name
    with pytest.raises(GraspBenchError, match="give --input depth"):
        train(
            config.model_copy(update={"input": "rgbd"}),
            scenes,
            tmp_path / "w",
            None,
            tmp_path / "start.safetensors",
        )


# --- command and tables -------------------------------------------------------------------


def invoke(*arguments: object) -> Any:
    return CliRunner().invoke(app, [str(a) for a in arguments])


def test_command(tmp_path: Path) -> None:
    root = write_jacquard(tmp_path / "j", SMALL)
    common = ("evaluate", "--dataset", "jacquard", "--root", root, "--predictor", "test_evaluation:Bar")
    result = invoke(*common, "--out", tmp_path / "deep" / "r.json")
    assert result.exit_code == 0, result.output
    assert "100.0%" in result.output
    assert "6/6" in result.output
    for name in CONVENTIONS["strict"]:
        assert name in result.output
    stored = json.loads((tmp_path / "deep" / "r.json").read_text())
    assert stored["correct"] == 6
    table = invoke(*common, "--format", "markdown").output
    assert "| HTC-Grasp (HTC-Grasp authors) | RGB-D |  |  | 95.8% |" in table
    assert "| test_evaluation:Bar" in table
    assert "6 of 54485 strict" in table
    assert json.loads(invoke(*common, "--format", "json").stdout)["images"] == 6


def test_weights_of_ones_own_need_no_name(tmp_path: Path) -> None:
    """They say themselves of which network they are."""
    root = write_jacquard(tmp_path / "j", SMALL)
    mine = tmp_path / "mine.safetensors"
    shutil.copy(shipped_file("gg-cnn").path, mine)
    result = invoke(
        "evaluate", "--dataset", "jacquard", "--root", root, "--weights", mine, "--format", "json"
    )
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["predictor"] == "gg-cnn"


def test_weights_that_do_not_say_their_network_need_its_name(tmp_path: Path) -> None:
    root = write_jacquard(tmp_path / "j", SMALL)
    mine = tmp_path / "mine.safetensors"
    shutil.copy(shipped_file("gg-cnn").path, mine)
    file = WeightsFile(mine)
    with_facts(file, {key: value for key, value in file.metadata().items() if key != "network"})
    common = ("evaluate", "--dataset", "jacquard", "--root", root, "--weights", mine)
    with pytest.raises(AssetError, match=r"mine\.safetensors does not say of which network it is"):
        raise invoke(*common).exception or AssertionError
    with pytest.raises(GraspBenchError, match="--weights is for networks; oracle is none"):
        raise invoke(*common, "--predictor", "oracle").exception or AssertionError
    assert invoke(*common, "--predictor", "gg-cnn").exit_code == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--root", "nowhere"), "nowhere is not a folder"),
        (("--folds", "99"), "99 folds cannot be made"),
        (("--fold", "3", "--folds", "2"), "--fold must be from 1 to 2"),
        (("--predictor", "oracle"), "needs the simulator's truth"),
        (("--predictor", "htc-grsp"), "Did you mean htc-grasp"),
        (("--predictor", "antipodal", "--train-steps", "3"), "Unknown network"),
        (("--protocol", "legacy", "--predictor", "antipodal"), "--protocol strict"),
        (("--protocol", "legacy", "--predictor", "lenz-sae"), "lenz-sae gives grasps and no maps"),
    ],
)
def test_bad_questions(tmp_path: Path, arguments: tuple[str, ...], message: str) -> None:
    root = write_jacquard(tmp_path / "j", SMALL)
    result = invoke("evaluate", "--dataset", "jacquard", "--root", root, *arguments)
    assert isinstance(result.exception, GraspBenchError)
    assert message in str(result.exception)


def test_paper_rows() -> None:
    assert [r.image_wise for r in TABLE_1] == [73.9, 88, 89.2, 73, 96, 90.2, 97.7, 97.99, 98.3]
    assert [r.object_wise for r in TABLE_1] == [75.6, 87.1, 88.9, 69, 96.1, 90.6, 96.6, 96.7, 96.9]
    assert [r.image_wise for r in TABLE_2] == [84, 94.6, 94.6, 95.8]
    table = accuracy_table("cornell", [])
    assert len(table.rows) == len(table.paper) == 18
    assert "13.5 s" in table.note
    assert not {round(100 * k / n, 1) for n in (88, 89) for k in range(n)} & {98.3}, "as the note says"
    assert round(100 * 174 / 177, 1) == 98.3
    since = since_table()
    assert len(since.rows) == len(since.paper) == len(SINCE) >= 12
    assert {later.here for later in SINCE} - {""} <= set(NETWORKS)
    assert all(later.source for later in SINCE)
    ours = {"SE-ResUNet (2022)": "se-resunet", "SKGNet (2023)": "skgnet"}
    assert {row[0]: row[-1] for row in since.rows if row[-1]} == ours


def test_what_was_published_stands_beside_ours() -> None:
    results = [Evaluation.read(p) for p in sorted((RESULTS / "evaluation").glob("*.json"))]
    table = published_table(results, cut_off=["gr-convnet"])
    rows = {row[0]: row for row in table.rows}
    assert set(rows) <= set(NETWORKS)
    assert {known.cornell for known in PUBLISHED} >= {87.1, 96.1, 90.6, 96.6, 96.7, 96.9}, "of Table 1"
    for row in rows.values():
        ours = [c for c in (row[3], row[4], row[7]) if c]
        far = [p for p in (row[5], row[8]) if p and abs(float(p)) > FAR]
        assert bool(row[-1]) == bool(far or not ours), row
    zero_shot = Evaluation.read(RESULTS / "evaluation" / "cornell-gr-convnet-zero-shot-strict.json")
    assert rows["gr-convnet"][5] == f"{100 * zero_shot.rate - 96.6:+.1f}"
    assert "cut off by the clock" in rows["gr-convnet"][-1]
    assert "cut off" not in rows["htc-grasp"][-1]
    fold = Evaluation.read(RESULTS / "evaluation" / "cornell-htc-grasp-rgb-object-strict.json")
    assert rows["htc-grasp"][5] == f"{100 * fold.rate - 96.9:+.1f}", "what was trained alike comes first"


def test_misprints_are_told_with_the_tables() -> None:
    told = accuracy_table("cornell", []).note
    for what in ("13.5 s", "98.3 % is no k/88 or k/89", "MultiGrasp", "three channels", "two grasps matches"):
        assert what in told
