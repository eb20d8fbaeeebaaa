"""Tiny data sets in the original layouts, and where real samples lie on a developer's machine."""

from __future__ import annotations

import os
from pathlib import Path

import cv2
import numpy as np
import pytest

from grasp_bench.grasps import Grasp

SAMPLES = Path(os.environ.get("GRASP_BENCH_SAMPLES", Path(__file__).resolve().parents[3] / "shared" / "data"))


def real_samples(name: str) -> Path:
    """Folder of real samples; skips the test where there are none."""
    folder = SAMPLES / name
    if not folder.is_dir():
        pytest.skip(f"no real samples: {folder} is missing (set GRASP_BENCH_SAMPLES)")
    return folder


def scene(
    shape: tuple[int, int], grasp: Grasp, tilt: float, height: float = 0.05
) -> tuple[np.ndarray, np.ndarray]:
    """RGB and tilted float32 depth of a bar that ``grasp`` closes on."""
    h, w = shape
    bar = np.zeros(shape, np.uint8)
    corners = Grasp(grasp.x, grasp.y, grasp.angle, 0.6 * grasp.width).rectangle(height=2.5 * grasp.width)
    cv2.fillPoly(bar, [np.round(corners - 0.5).astype(np.int32)], (1,))
    v, u = np.mgrid[0:h, 0:w].astype(np.float32)
    depth = 1 + tilt * (v / h - 0.5) + 0.1 * tilt * (u / w - 0.5) ** 2
    depth = np.where(bar > 0, depth - height, depth).astype(np.float32)
    rgb = np.where(bar[..., None] > 0, [200, 60, 30], [90, 90, 90]).astype(np.uint8)
    return rgb, depth


def cornell_lines(grasps: list[Grasp], height: float = 20.0) -> str:
    return "".join(f"{x:.3f} {y:.3f} \n" for g in grasps for x, y in g.rectangle(height=height))


def write_cornell(
    root: Path, grasps: list[Grasp], objects: list[int] | None = None, cloud: bool = False
) -> Path:
    """A Cornell copy with one grasp an image, two folders, and ``z.txt`` if objects are given."""
    for i, grasp in enumerate(grasps):
        folder = root / f"{i // 4 + 1:02d}"
        folder.mkdir(parents=True, exist_ok=True)
        stem = folder / f"pcd{100 + i:04d}"
        rgb, depth = scene((480, 640), grasp, -0.5)
        cv2.imwrite(f"{stem}r.png", rgb[..., ::-1])
        if cloud:
            write_cloud(Path(f"{stem}.txt"), depth)
        else:
            cv2.imwrite(f"{stem}d.tiff", depth)
        nan = "NaN NaN\n" + "1 2\n" * 3 if i == 0 else ""
        Path(f"{stem}cpos.txt").write_text(nan + cornell_lines([grasp]))
        Path(f"{stem}cneg.txt").write_text("1 1\n5 1\n5 9\n1 9\n")
    if objects is not None:
        (root / "processedData").mkdir()
        (root / "processedData" / "z.txt").write_text(
            "".join(f"{100 + i} {o} thing pcdb0002r.png\n" for i, o in enumerate(objects))
        )
    return root


def write_cloud(path: Path, distance: np.ndarray) -> None:
    """A PCD text file whose points lie at the given distances [m] of the origin; every 7th is missing."""
    index = np.arange(distance.size)
    kept = index % 7 != 3
    d = 1000 * distance.ravel()
    rows = zip(0.6 * d[kept], -0.8 * d[kept], index[kept], strict=True)
    header = (
        "# .PCD v.7 - Point Cloud Data file format\nVERSION .7\nFIELDS x y z rgb index\n"
        f"SIZE 4 4 4 4 4\nTYPE F F F F U\nPOINTS {kept.sum()}\nDATA ascii\n"
    )
    path.write_text(header + "\n".join(f"{x:.4f} {y:.4f} 0 2.1e-38 {i}" for x, y, i in rows) + "\n")


def write_jacquard(
    root: Path, grasps: list[Grasp], views: int = 2, size: int = 256, short: bool = False
) -> Path:
    """A Jacquard copy: a folder for each ``views`` grasps, short names if one view an object."""
    for i, grasp in enumerate(grasps):
        identifier = f"obj{i // views:x}abc"
        folder = root / identifier
        folder.mkdir(parents=True, exist_ok=True)
        prefix = "" if short else f"{i % views}_{identifier}_"
        rgb, depth = scene((size, size), grasp, -0.14)
        cv2.imwrite(str(folder / f"{prefix}RGB.png"), rgb[..., ::-1])
        cv2.imwrite(str(folder / f"{prefix}perfect_depth.tiff"), depth)
        stereo = depth.copy()
        stereo[:4] = -1
        cv2.imwrite(str(folder / f"{prefix}stereo_depth.tiff"), stereo)
        cv2.imwrite(str(folder / f"{prefix}mask.png"), (rgb[..., 0] > 150).astype(np.uint8) * 255)
        theta = -np.degrees(grasp.angle)
        (folder / f"{prefix}grasps.txt").write_text(
            "".join(f"{grasp.x};{grasp.y};{theta};{grasp.width};{jaw}\n" for jaw in (12.0, 20.0))
        )
    return root
