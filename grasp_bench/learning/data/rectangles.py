"""Real and rendered images with labelled grasp rectangles: what Cornell and Jacquard have in common.

A :class:`Collection` knows what a folder holds without reading the images; a
:class:`Sample` is one image, read when asked for. Rectangles are (N, 4, 2) corners in
pixels (edge of the image = 0), their first edge along the jaws' opening direction.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from grasp_bench.camera import FARTHEST
from grasp_bench.errors import AssetError
from grasp_bench.grasps import Grasp
from grasp_bench.networks.spec import Kind
from grasp_bench.runs.evaluation import DatasetName
from grasp_bench.system.arrays import Floats


@dataclass(frozen=True)
class Sample:
    """One labelled image.

    Attributes:
        name: identifies the image in its collection.
        rgb: (H, W, 3) uint8.
        depth: (H, W) float32 metres, 0 where invalid, and everywhere in a copy without depth. What it is
            measured from differs between data sets (see their modules);
            :func:`grasp_bench.predictors.tabletop.levelled` makes them alike.
        rectangles: (N, 4, 2) corners of the labelled good grasps [px].
        dropped: labelled rectangles that were left out because they hold NaN, have no area or lie outside.
    """

    name: str
    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    rectangles: Floats
    dropped: int = 0

    def grasps(self) -> list[Grasp]:
        """Return the rectangles as grasps; their heights, which grasps lack, are lost."""
        return [Grasp.from_rectangle(r) for r in self.rectangles]


@dataclass(frozen=True)
class Entry:
    """The files of one sample.

    Attributes:
        name: identifies the sample in its collection.
        object: what it shows, by the copy's own identifiers; None where the copy has none.
        labels, rgb, depth: the files it is read from; no depth in a copy that has colour only.
    """

    name: str
    object: str | None
    labels: Path
    rgb: Path
    depth: Path | None


@dataclass(frozen=True)
class Collection(ABC):
    """A copy of a data set, whole or in part.

    Attributes:
        root: folder of the copy.
        entries: complete samples, in order of their names.
        missing: files without which a labelled sample is incomplete, relative to ``root``.
        notes: what else was left out, in sentences.
        window: side of the square about the image's middle that is looked at [px]. Fixed for
            each data set, so that it does not depend on where the object is.
        native: side of the square that the lineage's loaders give a network of any input size [px]; None
            where they cut out that size without resizing.
    """

    root: Path
    entries: list[Entry]
    missing: list[str]
    window: int
    native: int | None = None

    name: DatasetName = "cornell"
    images_in_full: int = 0
    notes: tuple[str, ...] = ()

    @abstractmethod
    def load(self, entry: Entry) -> Sample:
        """Read one sample; AssetError names a file that is damaged."""

    def samples(self) -> Iterator[tuple[Entry, Sample | None, str]]:
        """Read all samples; yields each entry with its sample, or None and what is wrong with its files."""
        for entry in self.entries:
            try:
                yield entry, self.load(entry), ""
            except AssetError as error:
                yield entry, None, str(error)

    @property
    def has_depth(self) -> bool:
        """Whether there is depth; a copy either has it for all its samples, or for none."""
        return all(e.depth is not None for e in self.entries)

    def require(self, kind: Kind, who: str) -> None:
        """Refuse to show ``who`` a copy without depth, where its input of that kind needs it.

        Raises:
            AssetError: naming the files that are missing.
        """
        if self.has_depth or kind == "rgb":
            return
        files = ", ".join(f"{e.rgb.relative_to(self.root).parent / e.name}d.tiff" for e in self.entries[:3])
        raise AssetError(
            f"{who} is shown {kind}, and {self.root} holds colour only: {files} and "
            f"{max(len(self.entries) - 3, 0)} more are missing. Fetch them, or train a network with "
            "--input rgb where it was published so."
        )

    @property
    def knows_objects(self) -> bool:
        """Whether the copy says which images show the same object."""
        return bool(self.entries) and all(e.object is not None for e in self.entries)

    def describe(self) -> str:
        """Say in one or two sentences what was found."""
        objects = (
            f"{len({e.object for e in self.entries})} objects"
            if self.knows_objects
            else "object ids not in this copy"
        )
        full = self.images_in_full
        part = "" if len(self.entries) == full else f" of {full} in the full set"
        text = f"{self.name} in {self.root.name}: {len(self.entries)} images{part}, {objects}."
        if not self.has_depth:
            text += " Colour only, without depth."
        if self.missing:
            shown = ", ".join(self.missing[:5]) + (", …" if len(self.missing) > 5 else "")
            text += f" Incomplete samples left out, {len(self.missing)} files missing: {shown}."
        return " ".join((text, *self.notes))


@dataclass(frozen=True)
class Holding:
    """What a copy holds that can be used.

    Attributes:
        entries: samples that are complete, there once, and have a usable label.
        missing: files that others lack, relative to the root.
        notes: how many were left out for which reason, in sentences.
    """

    entries: list[Entry]
    missing: list[str]
    notes: tuple[str, ...]


def hold(root: Path, found: Iterable[Entry], labelled: Callable[[Path], Floats]) -> Holding:
    """Sort out what a copy holds.

    Args:
        root: folder of the copy.
        found: every labelled sample, whether its images are there or not.
        labelled: reads the usable rectangles (N, 4, 2) of a file of labels.
    """
    entries: dict[str, Entry] = {}
    missing: list[str] = []
    twice: list[str] = []
    bare: list[str] = []
    for entry in found:
        files = (entry.rgb, *([entry.depth] if entry.depth else []))
        absent = [p.relative_to(root).as_posix() for p in files if not p.is_file()]
        missing += absent
        if absent:
            continue
        if entry.name in entries:
            twice.append(entry.labels.relative_to(root).as_posix())
            continue
        try:
            usable = bool(len(labelled(entry.labels)))
        except AssetError:
            usable = True  # damaged, and said so when it is read
        if usable:
            entries[entry.name] = entry
        else:
            bare.append(entry.labels.relative_to(root).as_posix())
    notes = [
        f"{len(files)} {why}: {', '.join(files[:5])}{', …' if len(files) > 5 else ''}."
        for files, why in (
            (twice, "images left out that lie in the copy a second time"),
            (bare, "images left out that have no usable label"),
        )
        if files
    ]
    return Holding(list(entries.values()), missing, tuple(notes))


def first_there(*paths: Path) -> Path:
    """Return the first path that is a file; the first of all where none is."""
    return next((p for p in paths if p.is_file()), paths[0])


def own_files(root: Path, pattern: str) -> list[Path]:
    """Return the files below ``root`` that match, without what other systems leave beside them."""
    return [
        p
        for p in sorted(root.rglob(pattern))
        if not p.name.startswith("._") and "__MACOSX" not in p.relative_to(root).parts
    ]


def without_labels(root: Path, pattern: str, picture: re.Pattern[str], ending: str) -> list[str]:
    """Return the files of labels that lack beside pictures, relative to the root.

    Args:
        root: folder of the copy.
        pattern: of files among which the pictures are.
        picture: of a picture's name, whose first group with ``ending`` is the name of its labels.
        ending: of files of labels.
    """
    found = ((path, picture.match(path.name)) for path in own_files(root, pattern))
    labels = {path.with_name(name[1] + ending) for path, name in found if name}
    return [path.relative_to(root).as_posix() for path in sorted(labels) if not path.is_file()]


# ---------------------------------------------------------------- reading


def read_rgb(path: Path) -> NDArray[np.uint8]:
    """Read (H, W, 3) of an image file; AssetError when it is none."""
    image = cv2.imread(str(path), cv2.IMREAD_COLOR)
    if image is None:
        raise AssetError(f"{path} is truncated or not an image; fetch it again.")
    return np.ascontiguousarray(image[..., ::-1]).astype(np.uint8, copy=False)


def read_depth(path: Path, shape: tuple[int, ...]) -> NDArray[np.float32]:
    """Read (H, W) metres of a TIFF with floating-point depth; negative, NaN and infinite become 0.

    Raises:
        AssetError: when it is damaged or not of the given shape.
    """
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if image is None:
        raise AssetError(f"{path} is truncated or not a depth image; fetch it again.")
    if image.ndim != 2 or image.shape != shape or image.dtype.kind != "f":
        raise AssetError(
            f"{path} must hold floating-point depth of {shape[1]}×{shape[0]} px like its colour "
            f"image, but is {image.dtype} of shape {image.shape}."
        )
    with np.errstate(invalid="ignore", over="ignore"):
        depth = np.where(np.isfinite(image) & (image > 0), image, 0).astype(np.float32)
    return measured(depth, path)


def measured(depth: NDArray[np.float32], path: Path) -> NDArray[np.float32]:
    """Return ``depth`` (H, W) if it is one in metres.

    Raises:
        AssetError: where nothing was measured, or the values are millimetres'.
    """
    valid = depth[depth > 0]
    if not valid.size:
        raise AssetError(f"{path} holds no measured depth: every pixel is NaN, infinite, 0 or less.")
    middle = float(np.median(valid))
    if middle > FARTHEST:
        raise AssetError(
            f"{path} holds a depth of {middle:.4g} in the middle of its values, not metres but, it seems, "
            "millimetres; divide it by 1000."
        )
    return depth


def read_numbers(path: Path, columns: int, separator: str | None = None) -> Floats:
    """Read the rows (N, columns) of a text file; AssetError names the line that is otherwise."""
    rows: list[list[float]] = []
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise AssetError(f"{path} cannot be read ({error}).") from error
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        try:
            row = [float(v) for v in line.split(separator) if v.strip()]
        except ValueError:
            row = []
        if len(row) != columns:
            raise AssetError(f"{path}, line {number}: expected {columns} numbers, got {line.strip()[:40]!r}.")
        rows.append(row)
    return np.array(rows, float).reshape(-1, columns)


def usable_rectangles(rectangles: Floats, shape: tuple[int, ...] | None = None) -> tuple[Floats, int]:
    """Return the rectangles (N, 4, 2) that are finite, have an area and their middle within an image of
    ``shape`` (if given), and how many do not."""
    finite = np.isfinite(rectangles).all(axis=(1, 2))
    a, b = rectangles[:, 1] - rectangles[:, 0], rectangles[:, 2] - rectangles[:, 1]
    with np.errstate(invalid="ignore"):
        sound = finite & (np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) > 1e-6)
        if shape is not None:
            middle = rectangles.mean(axis=1)
            sound &= ((middle >= 0) & (middle < [shape[1], shape[0]])).all(axis=1)
    return rectangles[sound], int((~sound).sum())
