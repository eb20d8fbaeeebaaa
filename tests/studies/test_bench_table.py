"""Paired comparisons, the tables of all predictors, and synthetic scenes in Jacquard's layout."""

from __future__ import annotations

import json
import math
import re
import shutil
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from scipy.stats import binom
from typer.testing import CliRunner

from grasp_bench.cli import app
from grasp_bench.errors import AssetError, GraspBenchError, ResultsError
from grasp_bench.grasps import angle_difference
from grasp_bench.learning.data.export import export_jacquard, heights
from grasp_bench.learning.data.generate import generate
from grasp_bench.learning.data.opening import open_collection
from grasp_bench.learning.data.scenes import load_scenes
from grasp_bench.learning.data.synthetic import SynthConfig
from grasp_bench.predictors import load_predictor
from grasp_bench.predictors.shipped import SHIPPED
from grasp_bench.report.accuracy import accuracy_table
from grasp_bench.report.run import Run
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.runs.evaluation import Evaluation
from grasp_bench.runs.statistics import mcnemar, trials_to_distinguish
from grasp_bench.studies import bench_table
from grasp_bench.studies.bench_table import UNABLATED, bench, compare, read_evaluations, tables
from grasp_bench.studies.weights_table import trained_on

REFERENCE = Path(__file__).resolve().parents[2] / "results" / "reference"
EVALUATIONS = REFERENCE.with_name("evaluation")


# --- statistics ---------------------------------------------------------------------------


@pytest.mark.parametrize(("first", "second"), [(0.10, 0.05), (0.06, 0.02), (0.2, 0.1)])
def test_connors_number_of_trials_has_the_power(first: float, second: float) -> None:
    """The exact power of McNemar's test at that number is near 80 %."""
    n = trials_to_distinguish(first, second)
    assert n is not None
    discordant, share = first + second, first / (first + second)
    power = 0.0
    for m in range(n + 1):
        weight = binom.pmf(m, n, discordant)
        if weight > 1e-9:
            sees = [k for k in range(m + 1) if mcnemar(k, m - k) <= 0.05]
            power += weight * sum(binom.pmf(k, m, share) for k in sees)
    assert power == pytest.approx(0.8, abs=0.07)


def test_connor_by_hand() -> None:
    psi, d = 0.15, 0.05
    expected = (1.959964 * math.sqrt(psi) + 0.841621 * math.sqrt(psi - d * d)) ** 2 / d**2
    assert trials_to_distinguish(0.10, 0.05) == math.ceil(expected) == trials_to_distinguish(0.05, 0.10)
    assert trials_to_distinguish(0.1, 0.1) is None
    with pytest.raises(ValueError, match="impossible"):
        trials_to_distinguish(0.7, 0.6)


# --- tables -------------------------------------------------------------------------------


def test_reference_runs_compared() -> None:
    found = compare(sorted(REFERENCE.iterdir()))
    rows = {r["predictor"]: r for r in found["rows"]}
    assert found["reference"] == "htc-grasp"
    kinds = [SHIPPED[r["predictor"]].kind for r in found["rows"]]
    assert kinds == sorted(kinds, reverse=True), "networks first"
    assert "p_value" not in rows["htc-grasp"]
    displaced = rows["displaced"]
    assert (displaced["reference_only"], displaced["this_only"]) == (rows["htc-grasp"]["successes"], 0)
    assert all(r["p_value"] <= r["p_holm"] <= 1 for r in found["rows"] if "p_value" in r)
    table = tables(found, [])[0]
    assert len(table.rows) == 5 + len(found["rows"])
    line = next(r for r in table.rows if r[1] == "displaced (control)")
    assert line[2:5] == ["0/180", "0.0%", "0.0% – 2.1%"]
    told = (
        "input",
        "steps",
        "batch",
        "seed",
        "minutes",
        "flops",
        "held_out",
        "scenes",
        "folders",
        "begun_with",
    )
    for name, ended in (("gg-cnn", "minutes"), ("gr-convnet", "flat")):
        rows[name]["weights"] = {"parameters": 1, "ended": ended} | dict.fromkeys(told)
    names = [r[1] for r in tables({**found, "rows": [rows["gg-cnn"], rows["gr-convnet"]]}, [])[0].rows]
    assert names[-2:] == ["gg-cnn, cut off by the clock", "gr-convnet"]


def test_ablations_are_compared_with_the_network_of_their_budget() -> None:
    found = compare([REFERENCE / name for name in ("htc-grasp", UNABLATED, "oracle")])
    whole, *others = found["ablations"]
    assert (whole["predictor"], whole["trials"]) == (UNABLATED, 180)
    assert "p_value" not in whole
    assert [r["predictor"] for r in others] == ["htc-grasp-no-ea", "htc-grasp-no-ca", "htc-grasp-plain"]
    assert not any("trials" in r for r in others), "not among these runs"
    assert [r[:4] for r in tables(found, [])[-1].rows[1:3]] == [
        ["htc-grasp-no-ea", "", "✓", "not measured"],
        ["htc-grasp-no-ca", "✓", "", "not measured"],
    ]


def test_an_ablation_counts_what_only_one_lifted(tmp_path: Path) -> None:
    for name, run in ((UNABLATED, "oracle"), ("htc-grasp-no-ca", "random"), ("htc-grasp-plain", "displaced")):
        shutil.copytree(REFERENCE / run, tmp_path / name)
        info = json.loads((tmp_path / name / "run.json").read_text())
        (tmp_path / name / "run.json").write_text(json.dumps(info | {"predictor": name}))
    oracle, random = (Run(REFERENCE / n) for n in ("oracle", "random"))
    pairs = oracle.compare(random)
    rows = {r["predictor"]: r for r in compare(sorted(tmp_path.iterdir()))["ablations"]}
    row = rows["htc-grasp-no-ca"]
    assert (row["whole_only"], row["this_only"]) == (pairs.first_only, pairs.second_only)
    assert row["p_value"] == pytest.approx(row["p_holm"]) == pairs.p_value, "the larger of two"
    other = rows["htc-grasp-plain"]
    assert other["p_holm"] == pytest.approx(2 * other["p_value"])


def test_weights_of_another_budget_are_told_apart() -> None:
    for name, steps in (("htc-grasp", 3400), (UNABLATED, 1000)):
        weights = SHIPPED[name].weights
        assert weights is not None
        told = trained_on(name, {weights.name: weights.digest})
        assert told is not None
        assert (told["steps"], told["parameters"]) == (steps, 2_434_004)


def test_without_the_reference_nothing_is_compared() -> None:
    found = compare([REFERENCE / "oracle", REFERENCE / "random"])
    assert found["reference"] is None
    assert not any("p_value" in r for r in found["rows"])


def test_other_trials_are_refused(tmp_path: Path) -> None:
    for name in ("htc-grasp", "oracle"):
        shutil.copytree(REFERENCE / name, tmp_path / name)
    lines = (tmp_path / "oracle" / "trials.jsonl").read_text().splitlines()
    (tmp_path / "oracle" / "trials.jsonl").write_text("\n".join(lines[:-1]) + "\n")
    with pytest.raises(ResultsError, match="did not try the same"):
        compare([tmp_path / "htc-grasp", tmp_path / "oracle"])


def evaluation(**changes: Any) -> Evaluation:
    """A committed result with other figures."""
    shipped = Evaluation.read(EVALUATIONS / "cornell-htc-grasp-zero-shot-strict.json")
    figures = {
        "correct": 30,
        "images": 40,
        "weights": {"input": "rgbd 224"},
        "latency_ms": {"median": 50.0, "p95": 60.0, "cpu_median": 48.0},
    }
    return Evaluation.model_validate(shipped.model_dump() | figures | changes)


def test_command_prints_what_is_there(tmp_path: Path) -> None:
    (tmp_path / "e").mkdir()
    evaluation().write(tmp_path / "e" / "a.json")
    other = evaluation(predictor="htc-grasp-no-ca", dataset="jacquard")
    other.write(tmp_path / "e" / "b.json")
    common = ["bench-table", "--no-run", "--folder", str(REFERENCE), "--evaluations", str(tmp_path / "e")]
    text = CliRunner().invoke(app, [*common, "--format", "markdown"]).stdout
    for title in (
        "Table 4, re-measured: table4, seed 0",
        "What was trained on what",
        "Table 1, re-measured",
        "Table 2, re-measured",
        "Published accuracy, and ours",
        "Since then, and beside",
        "Table 3, re-measured",
        "Table 3's ablations on the",
    ):
        assert f"## {title}" in text
    assert (
        "| htc-grasp, zero-shot | RGB-D |  | 30/40 | 75.0% | 59.8% – 85.8% | 48 | 40 of 885 strict ¹ |"
        in text
    )
    assert "| Cornell | ✓ | ✓ | 98.3% | 30/40 | 75.0% |" in text
    assert "| Jacquard | ✓ |  | 94.2% | 30/40 | 75.0% |" in text
    assert len(re.findall(r"\n1\. all images once, .*protocol strict", text)) == 3, "below Tables 1, 2 and 3"
    out = tmp_path / "deep" / "table.txt"
    assert CliRunner().invoke(app, [*common, "--out", str(out)]).exit_code == 0
    assert "Alone" in out.read_text()
    stored = json.loads(CliRunner().invoke(app, [*common, "--format", "json"]).stdout)
    assert [e["predictor"] for e in stored["evaluations"]] == ["htc-grasp", "htc-grasp-no-ca"]


def test_only_table4_stands_beside_the_paper() -> None:
    titles = {}
    for folder in ("reference", "as-predicted"):
        found = compare(sorted((REFERENCE.parent / folder).iterdir()))
        compared, *_, ablations = tables(found, [])
        titles[folder] = compared.title, ablations.title
        assert (
            ("HTC-Grasp" in str(compared.rows))
            == ("printed rate" in compared.note)
            == (folder == "reference")
        )
    assert titles["reference"] == (
        "Table 4, re-measured: table4, seed 0",
        "Table 3's ablations on the trials of Table 4",
    )
    assert titles["as-predicted"] == (
        "All predictors: as-predicted, seed 0",
        "Table 3's ablations on the same trials",
    )
    found["scenario"] = "clutter"
    assert tables(found, [])[0].title == "All predictors: clutter, seed 0"


def test_only_weights_that_saw_nothing_real_are_called_zero_shot() -> None:
    seen = [
        {"input": "rgbd 224", "data": {"folders": ["synth", "cornell"], "real": ["cornell"]}, "steps": 5},
        {"input": "rgbd 224", "trained": {"real_images": 32}},
    ]
    for weights in seen:
        row = accuracy_table("cornell", [evaluation(weights=weights)]).rows[-1]
        assert row[0] == "htc-grasp, weights that saw real images"


def test_rows_of_the_same_conditions_share_a_footnote() -> None:
    table = accuracy_table(
        "synthetic", [evaluation(), evaluation(protocol="legacy"), evaluation(predictor="gg-cnn")]
    )
    assert [row[-1][-1] for row in table.rows] == ["¹", "²", "¹"]
    assert [note.split(" (")[0] for note in table.footnotes] == [
        "all images once, protocol strict",
        "all images once, protocol legacy",
    ]


def test_bad_folders(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["bench-table", "--no-run", "--folder", str(tmp_path)])
    assert isinstance(result.exception, GraspBenchError)
    assert "holds no run yet" in str(result.exception)
    assert read_evaluations(tmp_path / "nowhere") == []
    for content in ("{", "[]", '{"kind": "run", "format": 1}', '{"kind": "evaluation", "format": 2}'):
        (tmp_path / "x.json").write_text(content)
        with pytest.raises(ResultsError, match=r"x\.json"):
            read_evaluations(tmp_path)


def test_bench_runs_what_is_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    alone, together = [], []
    monkeypatch.setattr("grasp_bench.api.run", lambda **settings: alone.append(settings))
    monkeypatch.setattr(bench_table, "run_together", lambda *asked: together.append(asked))
    monkeypatch.setattr(bench_table, "early_crew", lambda *_: nullcontext())
    left_out = bench(tmp_path, ["oracle", "mine:Own", "gg-cnn"], trials=7, seed=3)
    assert [(a["predictor"], a["out"]) for a in alone] == [("mine:Own", tmp_path / "mine-Own")]
    assert {(a["trials"], a["seed"], a["scenario"]) for a in alone} == {(7, 3, "table4")}
    ((settings, folders, jobs, *_),) = together
    assert folders == {"oracle": tmp_path / "oracle", "gg-cnn": tmp_path / "gg-cnn"}
    assert (settings.seed, settings.scenario.name, len(jobs)) == (3, "table4", 7)
    together.clear()
    bench(tmp_path)
    assert set(together[0][1]) == {n for n, e in SHIPPED.items() if e.available}
    assert set(left_out) == {n for n, e in SHIPPED.items() if not e.available}


def test_a_network_without_weights_says_how_to_get_them(monkeypatch, tmp_path: Path) -> None:
    (tmp_path / "weights").mkdir()
    monkeypatch.setattr("grasp_bench.networks.store.assets_dir", lambda: tmp_path)
    with pytest.raises(AssetError, match="grasp-bench train --predictor gg-cnn --data"):
        load_predictor("gg-cnn")


def test_weights_that_were_replaced_are_not_told_of() -> None:
    assert trained_on("htc-grasp", {"htc-grasp.safetensors": "00"}) is None
    assert trained_on("oracle", None) is None


# --- export -------------------------------------------------------------------------------


def test_exported_scenes_read_back_as_jacquard(tmp_path: Path) -> None:
    made = generate(tmp_path / "synth", 3, 4, SynthConfig(tries=8), workers=1)
    assert not made.failed
    written, empty = export_jacquard(tmp_path / "synth", tmp_path / "out", size=640)
    loaded = load_scenes([tmp_path / "synth"])
    scenes = {s.name: s for s in (*loaded.train, *loaded.val)}
    assert written == sum(len(s.grasps) > 0 for s in scenes.values()) > 0
    assert written + empty == 3
    found = open_collection(tmp_path / "out", "jacquard")
    noisy = open_collection(tmp_path / "out", "jacquard", depth="stereo")
    assert len(found.entries) == written
    for entry, same in zip(found.entries, noisy.entries, strict=True):
        sample, scene = found.load(entry), scenes[str(entry.object)]
        assert sample.rgb.shape == (640, 640, 3)
        np.testing.assert_allclose(noisy.load(same).depth[1::2, 1::2], scene.depth * 1e-4, atol=1e-6)
        truth = {(round(2 * g.x), round(2 * g.y), round(2 * g.width)): g for g in scene.truths()}
        mask = cv2.imread(str(entry.labels).replace("grasps.txt", "mask.png"), cv2.IMREAD_GRAYSCALE)
        assert mask is not None
        assert 0 < (mask > 0).mean() < 0.5
        with np.load(tmp_path / "synth" / "scenes" / f"{entry.object}.npz") as file:
            focal, true = file["intrinsics"][0], file["depth_true"] * 1e-4
            assert (true[::7, ::7][mask[::14, ::14] > 0] < np.median(true)).all(), "higher than the table"
        for grasp, rectangle in zip(sample.grasps(), sample.rectangles, strict=True):
            original = truth[round(grasp.x), round(grasp.y), round(grasp.width)]
            assert angle_difference(grasp.angle, original.angle) < 1e-4
            jaw = np.hypot(*(rectangle[2] - rectangle[1]))
            assert jaw == pytest.approx(2 * PARALLEL_85.finger_width * focal / np.median(true), rel=0.35)
    marks = {p: p.stat().st_mtime_ns for p in (tmp_path / "out").rglob("*")}
    assert export_jacquard(tmp_path / "synth", tmp_path / "out", size=640)[0] == written
    assert marks == {p: p.stat().st_mtime_ns for p in (tmp_path / "out").rglob("*")}, "scenes are kept"
    lines = CliRunner().invoke(app, ["data", "info", str(tmp_path / "out")]).stdout
    assert f"jacquard in out: {written} images" in lines


def test_heights_of_a_tilted_camera() -> None:
    """A plane at z = 0.1 seen obliquely is 0.1 high everywhere."""
    from grasp_bench.camera import CameraPose, Intrinsics

    intrinsics = Intrinsics.from_fov(40, 40, 0.8)
    pose = CameraPose.look_at((0.1, 0.2, 0.7), (0.2, 0.1, 0.0), (1.0, 0.0, 0.0))
    rays = intrinsics.rays() @ pose.rotation.T
    depth = ((0.1 - pose.position[2]) / rays[..., 2]).astype(np.float32)
    k = np.array([intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy])
    np.testing.assert_allclose(heights(depth, k, pose.rotation, pose.position), 0.1, atol=1e-6)


def test_what_cannot_be_exported(tmp_path: Path) -> None:
    with pytest.raises(AssetError, match=r"index\.jsonl"):
        export_jacquard(tmp_path, tmp_path / "out")
