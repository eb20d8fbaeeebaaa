"""The numbered examples are predictors that work."""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from grasp_bench.camera import Intrinsics, RgbdImage
from grasp_bench.doctor.conformance import check, plain_samples
from grasp_bench.grasps import angle_difference
from grasp_bench.predictors import load_predictor
from grasp_bench.predictors.names import installed
from grasp_bench.predictors.protocol import checked

EXAMPLES = Path(__file__).parents[1] / "examples"


SERVER = f"cmd: {sys.executable} 06_server.py --port {{port}}"
POSES = f"cmd: {sys.executable} 09_pose_server.py --port {{port}}"


@pytest.mark.parametrize(
    "path",
    [
        "01_my_predictor:Highest",
        "05_opencv_predictor:Rectangle",
        "steepest_grasps:Steepest",
        "10_tsdf_predictor:Fused",
        SERVER,
        POSES,
    ],
)
def test_an_example_grasps_what_stands_out_and_keeps_to_the_protocol(
    path: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(EXAMPLES)
    monkeypatch.syspath_prepend(EXAMPLES / "07_package")
    intrinsics = Intrinsics.from_fov(640, 480, np.pi / 2)
    depth = np.full((480, 640), 0.55, np.float32)
    depth[200:230, 300:360] = 0.5
    image = RgbdImage(np.zeros((480, 640, 3), np.uint8), depth, intrinsics)
    predictor = load_predictor(path)
    best = checked(predictor.predict(image), intrinsics)[0]
    assert 295 <= best.x <= 365
    assert 195 <= best.y <= 235
    if "Highest" not in path:  # which knows one direction only
        assert angle_difference(best.angle, np.pi / 2) < 0.1 or "Steepest" in path
    assert not any(row.failed for row in check(predictor, plain_samples(), lambda: 0.0))
    getattr(predictor, "close", lambda: None)()


@pytest.mark.parametrize("name", ["06_server.py", "09_pose_server.py"])
def test_the_server_needs_no_grasp_bench(name: str) -> None:
    imported = re.findall(r"^(?:from|import) (\w+)", (EXAMPLES / name).read_text(), re.MULTILINE)
    assert set(imported) <= {"argparse", "io", "json", "http", "numpy", "importlib", "collections"}


def test_the_package_declares_what_its_module_holds(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.syspath_prepend(EXAMPLES / "07_package")
    project = tomllib.loads((EXAMPLES / "07_package" / "pyproject.toml").read_text())["project"]
    info = tmp_path / "steepest_grasps-0.1.dist-info"  # as pip would install it
    info.mkdir()
    (info / "METADATA").write_text(f"Name: {project['name']}\nVersion: {project['version']}\n")
    (info / "entry_points.txt").write_text(
        "".join(
            f"[{group}]\n" + "".join(f"{k} = {v}\n" for k, v in entries.items())
            for group, entries in project["entry-points"].items()
        )
    )
    monkeypatch.syspath_prepend(tmp_path)
    assert list(installed()) == ["steepest"]
    assert type(load_predictor("steepest")).__name__ == "Steepest"


def test_published_maps_are_shown_at_the_scale_of_their_data_and_answer_in_pixels_of_the_picture(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """A stand-in that finds height and says direction and width, of a crop twice as wide as its input."""
    (tmp_path / "loaded.py").write_text(
        "import torch\n"
        "def network():\n"
        "    def run(x):\n"
        "        assert x.shape == (1, 4, 100, 100) and abs(float(x.mean())) < 1e-5\n"
        "        one = torch.ones_like(x[:, :1])\n"
        "        return (-x[:, :1] * 10).clamp(0, 1), 0.5 * one, 0.5 * 3**0.5 * one, 0.2 * one\n"
        "    return run\n"
    )
    monkeypatch.chdir(tmp_path)
    intrinsics = Intrinsics.from_fov(640, 480, np.pi / 2)  # 320 px a metre at 1 m: 3.125 mm a pixel
    depth = np.full((480, 640), 1.0, np.float32)
    depth[260:280, 340:360] = 0.9
    depth[300:310, 300:310] = 0  # a hole
    image = RgbdImage(np.full((480, 640, 3), 90, np.uint8), depth, intrinsics)
    words = [
        sys.executable,
        str(EXAMPLES / "08_published_maps.py"),
        "--make",
        "loaded:network",
        "--side",
        "100",
    ]
    predictor = load_predictor(f"cmd: {' '.join(words)} --mm-per-pixel 6.25 --port {{port}}")
    try:
        best = checked(predictor.predict(image), intrinsics)[0]
    finally:
        getattr(predictor, "close", lambda: None)()
    assert (best.x, best.y) == (pytest.approx(350, abs=3), pytest.approx(270, abs=3))
    assert best.angle == pytest.approx(np.pi / 6, abs=1e-3)
    assert best.width == pytest.approx(0.2 * 150 * 2, rel=1e-3)
