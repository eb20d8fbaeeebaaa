"""Three pictures of a trial: what was seen, its depth, and where a grasp was wanted."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grasp_bench.camera import RgbdImage
from grasp_bench.grasps import Grasp, GraspMaps

Rgb = NDArray[np.uint8]
TILE = 224
"""Edge of a picture [px]."""
GREEN, RED, GREY = (40, 220, 60), (240, 40, 50), (170, 170, 170)
NO_DEPTH = (70, 20, 90)
"""Colour of pixels without a reading."""


@dataclass(frozen=True)
class Crop:
    """A square of an image that is shown, by its upper left corner and its edge [px]."""

    x: int
    y: int
    side: int

    @property
    def scale(self) -> float:
        """Shown pixels for one of the image."""
        return TILE / self.side

    def cut(self, image: NDArray[Any]) -> NDArray[Any]:
        """Return the crop of an (H, W[, C]) image at :data:`TILE` pixels; zeros outside the image."""
        height, width = image.shape[:2]
        rows = np.arange(self.y, self.y + self.side)
        columns = np.arange(self.x, self.x + self.side)
        part = image[np.clip(rows, 0, height - 1)][:, np.clip(columns, 0, width - 1)].copy()
        part[(rows < 0) | (rows >= height)] = 0
        part[:, (columns < 0) | (columns >= width)] = 0
        return cv2.resize(part, (TILE, TILE), interpolation=cv2.INTER_NEAREST)

    def place(self, grasp: Grasp) -> Grasp:
        """Return a grasp of the image in pixels of the shown crop."""
        return replace(
            grasp,
            x=(grasp.x - self.x) * self.scale,
            y=(grasp.y - self.y) * self.scale,
            width=grasp.width * self.scale,
        )


def crop_for(image: RgbdImage, grasps: list[Grasp]) -> Crop:
    """Return the middle square of the image, 224 px or as large as it must be to hold all grasps."""
    height, width = image.depth.shape
    middle = np.array([width, height]) / 2
    reach = max((float(np.abs(g.rectangle() - middle).max()) + 8 for g in grasps), default=0.0)
    side = int(2 * min(max(112.0, reach), max(width, height) / 2))
    return Crop((width - side) // 2, (height - side) // 2, side)


def close_to(image: RgbdImage, grasp: Grasp | None) -> Crop:
    """Return a square of the image around a grasp, half of :func:`crop_for`'s where that holds it."""
    if grasp is None:
        return crop_for(image, [])
    side = int(min(max(112.0, 1.6 * grasp.width + 32), min(image.depth.shape)))
    return Crop(round(grasp.x - side / 2), round(grasp.y - side / 2), side)


def draw_grasp(picture: Rgb, grasp: Grasp, thick: bool = True, color: tuple[int, int, int] = GREEN) -> None:
    """Draw a grasp's rectangle into ``picture``, the fingers in red when ``thick``."""
    corners = np.round((grasp.rectangle(min(grasp.width / 2, 24.0)) - 0.5) * 8).astype(np.int32)
    cv2.polylines(picture, [corners], True, color, 1, cv2.LINE_AA, 3)
    for a, b in ((1, 2), (3, 0)) if thick else ():
        cv2.line(picture, corners[a].tolist(), corners[b].tolist(), RED, 2, cv2.LINE_AA, 3)


def seen(image: RgbdImage, crop: Crop, grasp: Grasp | None) -> Rgb:
    """Draw what the camera saw, with the grasp that was carried out."""
    picture = crop.cut(image.rgb)
    if grasp is not None:
        draw_grasp(picture, crop.place(grasp))
    return picture


def depth(image: RgbdImage, crop: Crop, grasp: Grasp | None) -> Rgb:
    """Draw the measured depth, near is bright; purple where there is no reading."""
    measured = crop.cut(image.depth).astype(float)
    valid = measured > 0
    near, far = np.percentile(measured[valid], [0.5, 99.5]) if valid.any() else (0.0, 1.0)
    shade = 235 - 190 * np.clip((measured - near) / max(far - near, 0.01), 0, 1)
    picture = np.where(valid[..., None], shade[..., None], np.array(NO_DEPTH)).astype(np.uint8)
    if grasp is not None:
        draw_grasp(picture, crop.place(grasp))
    return picture


def proposed(
    image: RgbdImage,
    crop: Crop,
    grasps: list[Grasp],
    chosen: Grasp | None,
    maps: GraspMaps | None,
    origin: tuple[int, int] = (0, 0),
) -> Rgb:
    """Draw where a grasp was wanted: the network's quality over the picture, and all proposals.

    Args:
        image: what was seen.
        crop: what is shown of it.
        grasps: all proposals.
        chosen: the grasp carried out.
        maps: maps of a network, None for predictors without.
        origin: (x, y) of the maps' corner in the image [px].
    """
    grey = cv2.cvtColor(crop.cut(image.rgb), cv2.COLOR_RGB2GRAY)
    picture: Rgb = np.repeat(grey[..., None], 3, axis=2).astype(np.uint8)
    if maps is not None:
        rows, columns = image.depth.shape
        whole = np.zeros((rows, columns), np.float32)
        height, width = maps.quality.shape
        x, y = origin
        top, bottom = max(y, 0), min(y + height, rows)
        left, right = max(x, 0), min(x + width, columns)
        whole[top:bottom, left:right] = maps.quality[top - y : bottom - y, left - x : right - x]
        quality = np.clip(crop.cut(whole), 0, 1)
        heat = cv2.applyColorMap(np.round(255 * quality).astype(np.uint8), cv2.COLORMAP_INFERNO)[..., ::-1]
        picture = (0.35 * picture + 0.65 * np.asarray(heat)).astype(np.uint8)
    for other in reversed(grasps[:10]):
        if other != chosen:
            draw_grasp(picture, crop.place(other), thick=False, color=GREY)
    if chosen is not None:
        draw_grasp(picture, crop.place(chosen))
    return picture
