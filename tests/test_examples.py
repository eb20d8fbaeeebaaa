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
POSES = f"cmd: {sys.executable} 08_pose_server.py --port {{port}}"


@pytest.mark.parametrize(
    "path",
    [
        "01_my_predictor:Highest",
        "05_opencv_predictor:Rectangle",
        "steepest_grasps:Steepest",
        "09_tsdf_predictor:Fused",
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


@pytest.mark.parametrize("name", ["06_server.py", "08_pose_server.py"])
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
