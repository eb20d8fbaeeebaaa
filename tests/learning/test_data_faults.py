"""Copies of Cornell and Jacquard with the faults that people report: said, left out, never counted."""

from __future__ import annotations

import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
from real_samples import write_cornell, write_jacquard
from typer.testing import CliRunner

from grasp_bench.cli import app
from grasp_bench.errors import AssetError
from grasp_bench.grasps import Grasp
from grasp_bench.learning.data.folds import make_folds
from grasp_bench.learning.data.opening import open_collection
from grasp_bench.learning.evaluation.evaluate import Question, evaluate

GRASPS = [Grasp(300 + 5 * i, 250 - 4 * i, -1.2 + 0.4 * i, 60.0) for i in range(6)]
SMALL = [Grasp(120 + 3 * i, 130.0, 1.3 - 0.5 * i, 40.0) for i in range(4)]
NAN = "NaN NaN\n" * 4
AWAY = "-500 -500\n-440 -500\n-440 -470\n-500 -470\n"


def test_an_image_that_lies_twice_is_there_once(tmp_path: Path) -> None:
    root = write_cornell(tmp_path, GRASPS)
    shutil.copytree(root / "01", root / "copy of 01")
    found = open_collection(root)
    names = [e.name for e in found.entries]
    assert names == [f"pcd{100 + i:04d}" for i in range(6)]
    assert (
        "4 images left out that lie in the copy a second time: copy of 01/pcd0100cpos.txt" in found.describe()
    )
    for split in ("image", "object"):
        folds = make_folds([e.object for e in found.entries], 3, split)
        for k, part in enumerate(folds.test):
            assert not {names[i] for i in part} & {names[i] for i in folds.train(k)}


def test_a_copy_that_lacks_its_pictures_does_not_hide_the_whole_one(tmp_path: Path) -> None:
    root = write_cornell(tmp_path, GRASPS[:2])
    shutil.copytree(root / "01", root / "00")
    (root / "00" / "pcd0100r.png").unlink()
    found = open_collection(root)
    assert [e.labels.parent.name for e in found.entries] == ["01", "00"]
    assert found.missing == ["00/pcd0100r.png"]


def test_jacquard_images_that_lie_twice_are_there_once(tmp_path: Path) -> None:
    root = write_jacquard(tmp_path, SMALL[:2])
    shutil.copytree(next(p for p in root.iterdir() if p.is_dir()), root / "zz copy")
    found = open_collection(root)
    assert len({e.name for e in found.entries}) == len(found.entries)
    assert "a second time" in found.describe()


@pytest.mark.parametrize("labels", ["", "\n\n", NAN, AWAY.replace("-440", "-500")])
def test_images_without_a_usable_label_are_left_out_and_said(tmp_path: Path, labels: str) -> None:
    root = write_cornell(tmp_path, GRASPS[:3])
    (root / "01" / "pcd0101cpos.txt").write_text(labels)
    found = open_collection(root)
    assert [e.name for e in found.entries] == ["pcd0100", "pcd0102"]
    assert "1 images left out that have no usable label: 01/pcd0101cpos.txt." in found.describe()


@pytest.mark.parametrize("labels", [NAN, AWAY])
def test_images_without_a_usable_label_are_no_failures(tmp_path: Path, labels: str) -> None:
    root = write_cornell(tmp_path, GRASPS[:3])
    (root / "01" / "pcd0101cpos.txt").write_text(labels)
    result = evaluate(Question("centroid", "cornell", root))
    assert result.images == 2
    assert {r.image for r in result.records} == {"pcd0100", "pcd0102"}


def test_labels_outside_of_the_picture_are_dropped(tmp_path: Path) -> None:
    root = write_cornell(tmp_path, GRASPS[1:2])
    path = root / "01" / "pcd0100cpos.txt"
    found = open_collection(root)
    before = found.load(found.entries[0])
    path.write_text(AWAY + path.read_text())
    sample = found.load(found.entries[0])
    assert (len(sample.rectangles), sample.dropped) == (len(before.rectangles), before.dropped + 1)


@pytest.mark.parametrize(
    "row", ["120;130;30;-80;20", "120;130;30;0;20", "120;130;30;80;0", "nan;130;30;80;20"]
)
def test_jacquard_rows_that_are_no_grasp_are_dropped(tmp_path: Path, row: str) -> None:
    root = write_jacquard(tmp_path, SMALL[:1])
    path = open_collection(root).entries[0].labels
    good = len(open_collection(root).load(open_collection(root).entries[0]).rectangles)
    path.write_text(f"{row}\n{path.read_text()}")
    sample = open_collection(root).load(open_collection(root).entries[0])
    assert (len(sample.rectangles), sample.dropped) == (good, 1)


@pytest.mark.parametrize(
    ("value", "why"),
    [
        (np.nan, "holds no measured depth"),
        (np.inf, "holds no measured depth"),
        (0.0, "holds no measured depth"),
        (-1.0, "holds no measured depth"),
        (700.0, "it seems, millimetres"),
    ],
)
def test_depth_that_is_none_is_one_line(tmp_path: Path, value: float, why: str) -> None:
    root = write_cornell(tmp_path, GRASPS[:2])
    cv2.imwrite(str(root / "01" / "pcd0100d.tiff"), np.full((480, 640), value, np.float32))
    found = open_collection(root)
    with pytest.raises(AssetError, match=rf"pcd0100d\.tiff holds .*{why}|{why}"):
        found.load(found.entries[0])
    for command in (["data", "info", str(root), "--folds", "2"], ["data", "show", str(root)]):
        result = CliRunner().invoke(
            app, [*command, *(["--out", str(tmp_path / "a.png")] if "show" in command else [])]
        )
        assert result.exit_code == 1
        assert result.exception is None or isinstance(result.exception, (SystemExit, AssetError))


def test_every_bad_file_is_named(tmp_path: Path) -> None:
    root = write_cornell(tmp_path, GRASPS[:4])
    (root / "01" / "pcd0100r.png").write_bytes(b"\x89PNG nonsense")
    (root / "01" / "pcd0101cpos.txt").write_text("1 2\n3 four\n5 6\n7 8\n")
    (root / "01" / "pcd0103d.tiff").write_bytes(b"II*\x00")
    result = CliRunner().invoke(app, ["data", "info", str(root), "--folds", "2"])
    assert result.exit_code == 1
    for name in ("pcd0100r.png", "pcd0101cpos.txt, line 2", "pcd0103d.tiff"):
        assert name in result.output
    assert "3 of 4 images cannot be read" in result.output
    assert "1 rectangles" in result.output


def test_what_other_systems_leave_is_no_data(tmp_path: Path) -> None:
    root = write_cornell(tmp_path / "c", GRASPS[:2])
    (root / "01" / "._pcd0100cpos.txt").write_bytes(b"\0\5\26\7junk")
    (root / "__MACOSX").mkdir()
    shutil.copy(root / "01" / "pcd0100cpos.txt", root / "__MACOSX" / "pcd0199cpos.txt")
    assert len(open_collection(root).entries) == 2
    assert not open_collection(root).missing
    root = write_jacquard(tmp_path / "j", SMALL[:1])
    labels = open_collection(root).entries[0].labels
    labels.with_name("._" + labels.name).write_bytes(b"\0\5\26\7")
    assert len(open_collection(root).entries) == 1
    assert not open_collection(root).missing


def test_numbers_of_five_digits_and_short_endings_are_read(tmp_path: Path) -> None:
    root = write_cornell(tmp_path, GRASPS[:1])
    for path in list((root / "01").glob("pcd0100*")):
        path.rename(path.with_name(path.name.replace("pcd0100", "pcd10001").replace(".tiff", ".tif")))
    found = open_collection(root)
    assert [e.name for e in found.entries] == ["pcd10001"]
    assert found.load(found.entries[0]).depth.max() > 0


def test_colours_may_be_jpeg(tmp_path: Path) -> None:
    cornell, jacquard = write_cornell(tmp_path / "c", GRASPS[:2]), write_jacquard(tmp_path / "j", SMALL[:2])
    for root in (cornell, jacquard):
        before = open_collection(root)
        sharp = [before.load(e).rgb for e in before.entries]
        for entry in before.entries:
            picture = cv2.imread(str(entry.rgb))
            assert picture is not None
            cv2.imwrite(str(entry.rgb.with_suffix(".jpg")), picture, [cv2.IMWRITE_JPEG_QUALITY, 98])
            entry.rgb.unlink()
        found = open_collection(root)
        assert [e.name for e in found.entries] == [e.name for e in before.entries]
        assert found.missing == []
        for entry, rgb in zip(found.entries, sharp, strict=True):
            assert np.abs(found.load(entry).rgb.astype(int) - rgb).mean() < 5
