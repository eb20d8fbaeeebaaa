"""The Jacquard data set (Depierre, Dellandréa & Chen, IROS 2018) as distributed.

A folder an object, anywhere below the root, with ``N_ID_RGB.png`` (1024×1024; or ``.jpg``),
``N_ID_perfect_depth.tiff``, ``N_ID_stereo_depth.tiff`` (holes are −1), ``N_ID_mask.png`` and
``N_ID_grasps.txt``: lines ``x;y;theta;opening;jaw size`` in pixels and degrees, clockwise as
seen in the image. Shorter names without ``N_ID_`` are read as well.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from grasp_bench.errors import UnknownNameError
from grasp_bench.grasps import Grasp
from grasp_bench.learning.data.rectangles import (
    Collection,
    Entry,
    Sample,
    first_there,
    hold,
    own_files,
    read_depth,
    read_numbers,
    read_rgb,
    usable_rectangles,
    without_labels,
)
from grasp_bench.runs.evaluation import DatasetName
from grasp_bench.system.arrays import Floats

ENDING = "grasps.txt"
_PICTURE = re.compile(r"(.*)RGB\.(png|jpe?g)$")
DEPTHS = ("perfect", "stereo")


@dataclass(frozen=True)
class Jacquard(Collection):
    """A copy of the Jacquard set."""

    name: DatasetName = "jacquard"
    images_in_full: int = 54_485

    @classmethod
    def open(cls, root: Path, depth: str = "perfect") -> Jacquard:
        """Find what ``root`` holds.

        Raises:
            UnknownNameError: when ``depth`` is neither 'perfect' nor 'stereo'.
        """
        if depth not in DEPTHS:
            raise UnknownNameError("Jacquard depth", depth, DEPTHS)
        entries = []
        for labels in own_files(root, f"*{ENDING}"):
            prefix = labels.name.removesuffix(ENDING)
            rgb = first_there(*(labels.with_name(f"{prefix}RGB.{end}") for end in ("png", "jpg", "jpeg")))
            tiff = first_there(*(labels.with_name(f"{prefix}{depth}_depth.{end}") for end in ("tiff", "tif")))
            name = prefix.rstrip("_") or labels.parent.relative_to(root).as_posix()
            entries.append(Entry(name, _object(labels, prefix, root), labels, rgb, tiff))
        held = hold(root, entries, lambda labels: usable_rectangles(read_rows(labels))[0])
        missing = [*held.missing, *without_labels(root, "*RGB.*", _PICTURE, ENDING)]
        return cls(root, held.entries, missing, window=1024, native=1024, notes=held.notes)

    def load(self, entry: Entry) -> Sample:
        """Read one sample; AssetError names a file that is damaged."""
        corners = read_rows(entry.labels)
        rgb = read_rgb(entry.rgb)
        assert entry.depth is not None
        rectangles, dropped = usable_rectangles(corners, rgb.shape[:2])
        return Sample(entry.name, rgb, read_depth(entry.depth, rgb.shape[:2]), rectangles, dropped)


def _object(labels: Path, prefix: str, root: Path) -> str | None:
    """Return the identifier in the file's name, else its folder's name, else none."""
    _, _, identifier = prefix.rstrip("_").partition("_")
    return identifier or (labels.parent.name if labels.parent != root else None)


def read_rows(path: Path) -> Floats:
    """Read the corners (N, 4, 2) of a grasps file; AssetError names the line that is no row of one."""
    return corners_from_rows(read_numbers(path, 5, ";"))


def corners_from_rows(rows: Floats) -> Floats:
    """Turn rows (N, 5) of a grasps file into corners (N, 4, 2), the first edge along the opening; NaN
    where an opening or jaw is not positive."""
    corners = [
        Grasp(x, y, -np.radians(theta), opening).rectangle(height=jaw)
        if opening > 0 and jaw > 0
        else np.full((4, 2), np.nan)
        for x, y, theta, opening, jaw in rows
    ]
    return np.array(corners, float).reshape(-1, 4, 2)


def row_from_grasp(grasp: Grasp, jaw: float) -> str:
    """Return the line of a grasps file for a grasp with jaws ``jaw`` pixels wide."""
    return f"{grasp.x:.5f};{grasp.y:.5f};{-np.degrees(grasp.angle):.4f};{grasp.width:.4f};{jaw:.4f}"
