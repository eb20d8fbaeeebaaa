"""Several predictors' maps and best grasps of the same images, as in the paper's Figures 4 to 6.

Images are samples of a Cornell or Jacquard copy, generated scenes, or what the camera saw in a recorded
trial, clutter included. Every predictor is shown the same picture, as it is in evaluation or in trials.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grasp_bench.camera import Intrinsics, RgbdImage
from grasp_bench.errors import GraspBenchError
from grasp_bench.grasps import GraspMaps
from grasp_bench.learning.data.opening import open_collection
from grasp_bench.learning.data.pictures import CROP, spread
from grasp_bench.learning.data.scenes import is_generated, load_scene, read_index
from grasp_bench.learning.evaluation.protocols import as_image, make_case
from grasp_bench.learning.training.augment import View, crop_scene
from grasp_bench.media.pictures import TILE, Crop, Rgb, crop_for, seen
from grasp_bench.predictors.network import Level, NetworkPredictor
from grasp_bench.predictors.protocol import Predictor, PrivilegedPredictor, ask
from grasp_bench.replay.rebuild import rebuild
from grasp_bench.runs.info import RUN

WIDEST = 100.0
"""Width that is drawn brightest [px]."""
LEAST_QUALITY = 0.1
"""Angle and width are dimmed where the quality is less."""
COLUMNS = ("best grasp", "quality, 0 to 1", "angle by hue", f"width, 0 to {WIDEST:.0f} px")
BAR, INK, NOTHING = 20, (20, 20, 20), 225


@dataclass(frozen=True)
class Shown:
    """An image that predictors are shown.

    Attributes:
        name: what it is called.
        image: what they get; depth is 0 everywhere where there is none.
        level: how networks take a tilted table, as in
            :class:`grasp_bench.predictors.network.NetworkPredictor`.
    """

    name: str
    image: RgbdImage
    level: Level


def images(folder: Path, count: int, trial: int | None = None) -> Iterator[Shown]:
    """Give ``count`` images spread over the data set in ``folder``, or those of a trial of the run there.

    Raises:
        AssetError, ResultsError: when the folder holds neither, or what it holds is damaged.
        GraspBenchError: for a trial of something that is no run.
    """
    if (folder / RUN).is_file():
        number = trial or 0
        for take in rebuild(folder, number).seen():
            name = f"{folder.name}, trial {number}"
            name += "" if take.attempt is None else f", attempt {take.attempt}"
            assert take.done.image is not None
            yield Shown(name, take.done.image, "camera")
        return
    if trial is not None:
        raise GraspBenchError(f"--trial is for a run's folder; {folder} has no {RUN}.")
    if is_generated(folder):
        entries = read_index(folder)
        for i in spread(len(entries), count):
            scene = load_scene(folder / entries[i]["file"], CROP)
            rgb, depth, _ = crop_scene(scene, View(), CROP)
            image = RgbdImage(rgb, depth, Intrinsics.from_fov(CROP, CROP, np.radians(60.0)))
            yield Shown(f"{folder.name} {scene.name}", image, "none")
        return
    collection = open_collection(folder, generated=True)
    for i in spread(len(collection.entries), count):
        case = make_case(collection, i, CROP, "strict")
        yield Shown(f"{collection.name} {case.name}", as_image(case), "table")


def compare(shown: Sequence[Shown], predictors: dict[str, Predictor]) -> Rgb:
    """Draw a sheet: for each image and predictor the best grasp on the picture, quality, angle and width.

    Args:
        shown: images.
        predictors: by the names to be written.

    Raises:
        GraspBenchError: for a control that knows the truth, or a network of depth where there is none.
    """
    rows = []
    for one in shown:
        rows.append(_bar(one.name, [""] * len(COLUMNS)))
        rows += [_row(one, name, predictor) for name, predictor in predictors.items()]
    return np.vstack([_bar("", COLUMNS), *rows])


def _row(one: Shown, name: str, predictor: Predictor) -> Rgb:
    if isinstance(predictor, PrivilegedPredictor):
        raise GraspBenchError(f"{name} knows the simulator's truth and is asked for no image.")
    if isinstance(predictor, NetworkPredictor):
        predictor.level = one.level
        if predictor.kind != "rgb" and not one.image.valid.any():
            raise GraspBenchError(f"{name} is shown {predictor.kind}, and {one.name} has no depth.")
    best = next(iter(ask(predictor, one.image, np.random.default_rng(0))), None)
    crop = crop_for(one.image, [])
    maps = getattr(predictor, "last_maps", None)
    tiles = [seen(one.image, crop, best), *_maps(maps, getattr(predictor, "crop_origin", (0, 0)), crop, one)]
    words = name if best is None else f"{name}: {best.quality:.2f}"
    (wide, _), _ = cv2.getTextSize(words, cv2.FONT_HERSHEY_SIMPLEX, 0.45, 1)
    cv2.rectangle(tiles[0], (0, 0), (wide + 10, 20), (255, 255, 255), cv2.FILLED)
    cv2.putText(tiles[0], words, (5, 15), cv2.FONT_HERSHEY_SIMPLEX, 0.45, INK, 1, cv2.LINE_AA)
    return np.hstack(tiles)


def _maps(maps: Any, origin: tuple[int, int], crop: Crop, one: Shown) -> list[Rgb]:
    """Draw quality, angle and width; grey where there are no maps."""
    if not isinstance(maps, GraspMaps):
        return [np.full((TILE, TILE, 3), NOTHING, np.uint8) for _ in COLUMNS[1:]]
    whole = [
        _placed(values, origin, one.image.depth.shape) for values in (maps.quality, maps.angle, maps.width)
    ]
    quality, angle, width = (crop.cut(values) for values in whole)
    sure = np.where(quality >= LEAST_QUALITY, 1.0, 0.35)
    hue = np.mod(np.degrees(angle), 180).astype(np.uint8)
    full = np.full_like(hue, 230)
    hues = cv2.cvtColor(np.dstack([hue, full, (255 * sure).astype(np.uint8)]), cv2.COLOR_HSV2RGB)
    widths = _heat(width / WIDEST, cv2.COLORMAP_VIRIDIS) * sure[..., None]
    return [_heat(quality, cv2.COLORMAP_INFERNO), np.asarray(hues, np.uint8), widths.astype(np.uint8)]


def _placed(
    values: NDArray[np.floating], origin: tuple[int, int], shape: tuple[int, ...]
) -> NDArray[np.float32]:
    """Put a map whose corner is at ``origin`` (x, y) into an image of ``shape``, zeros around it."""
    whole = np.zeros(shape[:2], np.float32)
    (x, y), (h, w) = origin, values.shape
    rows, columns = slice(max(y, 0), min(y + h, shape[0])), slice(max(x, 0), min(x + w, shape[1]))
    whole[rows, columns] = values[rows.start - y : rows.stop - y, columns.start - x : columns.stop - x]
    return whole


def _heat(values: NDArray[np.floating], colours: int) -> Rgb:
    scaled = np.round(255 * np.clip(values, 0, 1)).astype(np.uint8)
    return np.ascontiguousarray(cv2.applyColorMap(scaled, colours)[..., ::-1]).astype(np.uint8)


def _bar(title: str, words: Sequence[str]) -> Rgb:
    bar = np.full((BAR, TILE * len(words), 3), 255, np.uint8)
    for x, text in ((0, title), *((TILE * i, word) for i, word in enumerate(words))):
        cv2.putText(bar, text, (x + 5, 14), cv2.FONT_HERSHEY_SIMPLEX, 0.42, INK, 1, cv2.LINE_AA)
    return bar
