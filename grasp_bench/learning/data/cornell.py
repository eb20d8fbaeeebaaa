"""The Cornell grasping data set (Jiang, Moseson & Saxena, ICRA 2011; Lenz et al. 2013) as distributed.

Anywhere below the root: ``pcdNNNNr.png`` or ``.jpg`` (640×480), ``pcdNNNNcpos.txt`` (four lines ``x y`` a
rectangle) and depth, either ``pcdNNNNd.tiff`` as GG-CNN's converter writes it, or the original point cloud
``pcdNNNN.txt``. A copy in which no image has depth is one of colour only. ``z.txt`` (image number, object
number, description …) tells which images show the same object; without it views of an object are only known
to have consecutive numbers.

The points are relative to the base of the robot that took the images, not to its camera (the
set's own readme). What GG-CNN's converter stores, and what is made of the text file here, is
their distance from that origin: a smooth function over the table, but no depth of a camera.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from grasp_bench.errors import AssetError
from grasp_bench.learning.data.rectangles import (
    Collection,
    Entry,
    Sample,
    first_there,
    hold,
    measured,
    own_files,
    read_depth,
    read_numbers,
    read_rgb,
    usable_rectangles,
    without_labels,
)
from grasp_bench.runs.evaluation import DatasetName
from grasp_bench.system.arrays import Floats

_LABELS = re.compile(r"pcd(\d{4,})cpos\.txt$")
_PICTURE = re.compile(r"(pcd\d{4,})r\.(png|jpe?g)$")
MILLIMETRE = 1e-3


@dataclass(frozen=True)
class Cornell(Collection):
    """A copy of the Cornell set."""

    name: DatasetName = "cornell"
    images_in_full: int = 885

    @classmethod
    def open(cls, root: Path) -> Cornell:
        """Find what ``root`` holds."""
        objects = _object_ids(root)
        entries = []
        for labels in sorted(own_files(root, "pcd*cpos.txt"), key=lambda p: p.name):
            found = _LABELS.match(labels.name)
            if found is None:
                continue
            number = found[1]
            rgb = first_there(*(labels.with_name(f"pcd{number}r.{end}") for end in ("png", "jpg", "jpeg")))
            cloud = labels.with_name(f"pcd{number}.txt")
            tiff = first_there(*(labels.with_name(f"pcd{number}d.{end}") for end in ("tiff", "tif")))
            depth = tiff if tiff.is_file() or not cloud.is_file() else cloud
            entries.append(Entry(f"pcd{number}", objects.get(int(number)), labels, rgb, depth))
        if not any(e.depth is not None and e.depth.is_file() for e in entries):
            entries = [replace(e, depth=None) for e in entries]
        held = hold(root, entries, lambda labels: usable_rectangles(read_corners(labels))[0])
        missing = [*held.missing, *without_labels(root, "pcd*r.*", _PICTURE, "cpos.txt")]
        return cls(root, held.entries, missing, window=320, notes=held.notes)

    def load(self, entry: Entry) -> Sample:
        """Read one sample; AssetError names a file that is damaged."""
        corners = read_corners(entry.labels)
        rgb = read_rgb(entry.rgb)
        shape = rgb.shape[:2]
        rectangles, dropped = usable_rectangles(corners, shape)
        if entry.depth is None:
            depth = np.zeros(shape, np.float32)
        elif entry.depth.suffix in (".tiff", ".tif"):
            depth = read_depth(entry.depth, shape)
        else:
            depth = distance_from_cloud(entry.depth, shape)
        return Sample(entry.name, rgb, depth, rectangles, dropped)


def read_corners(path: Path) -> Floats:
    """Read the rectangles (N, 4, 2) of a file of labels, NaN as it is there.

    Raises:
        AssetError: for a line that is no two numbers, or an incomplete rectangle.
    """
    corners = read_numbers(path, 2)
    if len(corners) % 4:
        raise AssetError(f"{path}: {len(corners)} lines are no whole number of rectangles (four lines each).")
    return corners.reshape(-1, 4, 2)


def _object_ids(root: Path) -> dict[int, str]:
    """Read the object of each image number from the first ``z.txt`` at or below ``root``, if any."""
    for path in own_files(root, "z.txt"):
        ids: dict[int, str] = {}
        for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
            words = line.split()
            if len(words) >= 2 and words[0].isdigit() and words[1].isdigit():
                ids[int(words[0])] = words[1]
        return ids
    return {}


def distance_from_cloud(path: Path, shape: tuple[int, ...]) -> NDArray[np.float32]:
    """Read (H, W) metres from the origin of a point cloud in PCD text format, 0 where there is no point.

    Lines are x, y, z in millimetres, a colour and the pixel's index, row by row.

    Raises:
        AssetError: when the file is no PCD text file or has indices outside the image.
    """
    try:
        header, _, body = path.read_text(encoding="ascii").partition("DATA ascii")
        fields = next(line.split()[1:] for line in header.splitlines() if line.startswith("FIELDS"))
        points = np.array(body.split(), dtype=np.float64).reshape(-1, len(fields))
        x, y, z, index = (points[:, fields.index(n)] for n in ("x", "y", "z", "index"))
    except (OSError, ValueError, StopIteration) as error:
        raise AssetError(f"{path} is truncated or not a point cloud in PCD text format ({error}).") from error
    flat = np.zeros(int(np.prod(shape)), np.float32)
    place = index.astype(np.int64)
    if len(place) and (place.min() < 0 or place.max() >= flat.size):
        raise AssetError(f"{path} has pixel indices outside of {shape[1]}×{shape[0]} px.")
    flat[place] = np.sqrt(x**2 + y**2 + z**2) * MILLIMETRE
    flat[~np.isfinite(flat)] = 0
    return measured(flat.reshape(shape), path)
