"""What a training or an evaluation is given and cannot use: one line on stderr, exit code 2, no traceback."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from conftest import Ended
from real_samples import write_cornell
from test_real_data import GRASPS
from test_training import folder  # noqa: F401 (eight synthetic scenes)

from grasp_bench.learning.training.loop import CHECKPOINT

Cli = Callable[[str], Ended]


def refused(ended: Ended, *words: str) -> None:
    """Bad input by the table of exit codes, in one line, with these words."""
    assert ended.code == 2, ended
    lines = ended.err.strip().splitlines()
    told = [line for line in lines if line.startswith("Error: ")]
    assert len(told) == 1, ended.err
    assert told[0] is lines[-1], "and nothing after it"
    assert "Traceback" not in ended.out + ended.err
    for word in words:
        assert word in told[0]


@pytest.mark.parametrize("kept", [0.0, 0.001, 0.5, 0.999])
def test_a_truncated_checkpoint(cli: Cli, folder: Path, kept: float) -> None:  # noqa: F811
    line = f"train --predictor gg-cnn --data {folder} --out run --batch 1 --threads 1 --steps"
    first = cli(f"{line} 1")
    assert first.code == 0, first.err
    path = Path("run") / CHECKPOINT
    whole = path.read_bytes()
    path.write_bytes(whole[: int(kept * len(whole))])
    refused(cli(f"{line} 2"), f"run/{CHECKPOINT} is truncated or not one", "delete it to start anew")
    assert path.stat().st_size == int(kept * len(whole)), "nothing was lost besides"


@pytest.mark.parametrize(
    ("line", "valid"),
    [
        ("train --predictor gg-cnn --input rgb --data DATA --out new", "Valid: depth, rgbd"),
        ("train --predictor htc-grasp --input depth --data DATA --out new", "Valid: rgb, rgbd"),
        (
            "evaluate --dataset cornell --root DATA --predictor gg-cnn --input rgb --train-steps 1",
            "depth, rgbd",
        ),
        ("evaluate --dataset cornell --root DATA --input rgb", "--input is for --train-steps"),
    ],
)
def test_an_input_that_a_network_was_not_made_for(cli: Cli, tmp_path: Path, line: str, valid: str) -> None:
    root = write_cornell(tmp_path / "copy", GRASPS[:2])
    refused(cli(line.replace("DATA", str(root))), valid)
    assert not Path("new").exists()


@pytest.mark.parametrize(
    "line", ["train --predictor htc-grasp --data DATA --out new", "evaluate --dataset cornell --root DATA"]
)
def test_colour_alone_for_a_network_that_needs_depth(cli: Cli, tmp_path: Path, line: str) -> None:
    root = write_cornell(tmp_path / "copy", GRASPS[:3])
    for path in root.rglob("*d.tiff"):
        path.unlink()
    refused(cli(line.replace("DATA", str(root))), "shown rgbd", "colour only", "pcd0100d.tiff", "--input rgb")
    assert not Path("new").exists()


@pytest.mark.parametrize("lost", ["r.png", "d.tiff", "cpos.txt"])
def test_half_of_a_copy(cli: Cli, tmp_path: Path, lost: str) -> None:
    """What is whole is used, as of any part of a set; what lacks is named, in trainings and evaluations."""
    root = write_cornell(tmp_path / "copy", GRASPS)
    for path in sorted(root.rglob(f"*{lost}"))[::2]:
        path.unlink()
    told = f"3 files missing: 01/pcd0100{lost}, 01/pcd0102{lost}, 02/pcd0104{lost}."
    judged = cli(f"evaluate --dataset cornell --root {root} --predictor centroid --format json --out e.json")
    assert judged.code == 0, judged.err
    found = json.loads(Path("e.json").read_text())
    assert found["images"] == 3
    assert told in found["found"]
    trained = cli(f"train --predictor gg-cnn --data {root} --out run --steps 1 --batch 1 --threads 1")
    assert trained.code == 0, trained.err
    assert told in " ".join(trained.out.split())
    for path in root.rglob(f"*{lost}"):
        path.unlink()
    rest = cli(f"train --predictor htc-grasp --data {root} --out new --steps 1")
    refused(rest, "pcd0100" + lost)


def test_scenes_that_are_gone(cli: Cli, folder: Path, tmp_path: Path) -> None:  # noqa: F811
    half = tmp_path / "half"
    (half / "scenes").mkdir(parents=True)
    (half / "index.jsonl").write_bytes((folder / "index.jsonl").read_bytes())
    for path in sorted(folder.glob("scenes/*.npz"))[1::2]:
        (half / "scenes" / path.name).write_bytes(path.read_bytes())
    for line in (f"train --predictor gg-cnn --data {half} --out run --steps 1", f"data show {half}"):
        refused(cli(line), "is missing though its index lists it; generate the data again")
