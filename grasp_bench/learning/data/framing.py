"""What of an image a network is shown: a square of it, resized, with the table level."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from grasp_bench.learning.data.rectangles import Sample
from grasp_bench.predictors.tabletop import levelled
from grasp_bench.system.arrays import Floats


@dataclass(frozen=True)
class Frame:
    """A square of an image, resized.

    Attributes:
        x, y: the square's middle in pixels of the image.
        extent: its side in pixels of the image.
        side: its side once resized.
    """

    x: float
    y: float
    extent: float
    side: int

    @classmethod
    def middle(cls, shape: tuple[int, ...], window: float, crop: int, side: int | None = None) -> Frame:
        """Return the square about the middle of an image of ``shape``, a ``window`` px becoming ``crop`` px.

        ``side`` px are kept, by default ``crop``: more leave a margin for random views.
        """
        side = crop if side is None else side
        return cls(shape[1] / 2, shape[0] / 2, window * side / crop, side)

    @property
    def scale(self) -> float:
        """Pixels of the frame a pixel of the image."""
        return self.side / self.extent

    def points(self, points: ArrayLike) -> Floats:
        """Turn pixels (…, 2) of the image into those of the frame."""
        return (np.asarray(points, float) - (self.x, self.y)) * self.scale + self.side / 2

    def cut(self, array: NDArray, fill: bool) -> NDArray:
        """Cut the square out of ``array``; outside the image there is its border (``fill``) or zeros.

        Colour (H, W, 3) is averaged where it shrinks; anything else takes its nearest value.
        """
        low = np.array([self.x, self.y]) - self.extent / 2
        first = np.floor(low).astype(int)
        last = np.ceil(low + self.extent).astype(int)
        h, w = array.shape[:2]
        before, after = np.maximum(-first, 0), np.maximum(last - (w, h), 0)
        if before.any() or after.any():
            rims = [(before[1], after[1]), (before[0], after[0]), (0, 0)][: array.ndim]
            array = np.pad(array, rims, mode="edge" if fill else "constant")
        first, last = first + before, last + before
        part = array[first[1] : last[1], first[0] : last[0]]
        if array.ndim == 3:
            kind = cv2.INTER_AREA if self.scale < 1 else cv2.INTER_LINEAR
        else:
            kind = cv2.INTER_NEAREST_EXACT
        return np.asarray(cv2.resize(part, (self.side, self.side), interpolation=kind))


@dataclass(frozen=True)
class Framed:
    """A sample as seen in a frame.

    Attributes:
        rgb: (S, S, 3) uint8.
        depth: (S, S) float32 metres, 0 = invalid; level unless it was asked for as it is.
        rectangles: (N, 4, 2) in pixels of the frame; some may be outside.
        frame: the square of the image that is shown.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    rectangles: Floats
    frame: Frame


def framed(sample: Sample, frame: Frame, crop: int | None) -> Framed:
    """Cut ``frame`` out of a sample, the table fitted in the middle ``crop`` px; None keeps the depth."""
    rgb = frame.cut(sample.rgb, fill=True)
    depth = frame.cut(sample.depth, fill=False)
    depth = depth if crop is None else levelled(depth, crop)
    return Framed(rgb, depth, frame.points(sample.rectangles).reshape(-1, 4, 2), frame)
