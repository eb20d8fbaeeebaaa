"""Cornell and Jacquard samples as scenes to train on, next to synthetic ones.

An image's window (see :class:`grasp_bench.learning.data.rectangles.Collection`) becomes the
network's input, so that jaws open 15 to 60 px in Cornell and 3 to 43 px in Jacquard; a margin
around it leaves room for random views. The third in the middle of each rectangle is labelled
with quality 1 (GG-CNN's convention), the rest with 0.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from grasp_bench.grasps import GraspMaps
from grasp_bench.learning.data.framing import Frame, framed
from grasp_bench.learning.data.rectangles import Collection, Sample
from grasp_bench.learning.data.scenes import Scene, packed

MARGIN = 4 / 3
"""Side of a scene over side of the network's input."""
KEPT = 1500
"""Scenes of one folder kept in memory (0.8 MB each); others are read again each time."""


def scene_from_sample(sample: Sample, window: int, crop: int) -> Scene:
    """Make a scene of the middle of a sample, ``window`` px becoming ``crop`` px."""
    side = round(crop * MARGIN)
    seen = framed(sample, Frame.middle(sample.depth.shape, window, crop, side), crop)
    maps = GraspMaps.from_rectangles(seen.rectangles, (side, side))
    along = seen.rectangles[:, 1] - seen.rectangles[:, 0]
    centre = seen.rectangles.mean(axis=1)
    angle = np.arctan2(-along[:, 1], along[:, 0])
    grasps = np.column_stack([centre, angle, np.hypot(*along.T), np.ones(len(along))])
    return Scene(
        sample.name,
        seen.rgb,
        packed(seen.depth),
        np.rint(255 * maps.quality).astype(np.uint8),
        maps.angle.astype(np.float16),
        maps.width.astype(np.float16),
        grasps.astype(np.float32),
    )


class RealScenes(Sequence[Scene]):
    """Scenes of some samples of a collection, read when first needed.

    Args:
        collection: copy of a data set that holds the samples.
        indices: which of its samples are meant.
        crop: side of the network's input [px].
    """

    def __init__(self, collection: Collection, indices: Sequence[int], crop: int) -> None:
        self._collection, self._indices, self._crop = collection, list(indices), crop
        self._kept: dict[int, Scene] = {}

    def __len__(self) -> int:
        return len(self._indices)

    def __getitem__(self, index: int) -> Scene:
        index = range(len(self))[index]  # negative ones count from the end, others raise IndexError
        if index not in self._kept:
            sample = self._collection.load(self._collection.entries[self._indices[index]])
            scene = scene_from_sample(sample, self._collection.window, self._crop)
            if len(self._kept) >= KEPT:
                return scene
            self._kept[index] = scene
        return self._kept[index]
