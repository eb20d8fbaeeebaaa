"""Grasps of objects told from grasps of what stands around them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import grey_dilation

from grasp_bench.planning.heightfield import GraspField, HeightField
from grasp_bench.scene.builder import VISUAL_GROUP

OBJECTS_ONLY = (np.arange(6) == VISUAL_GROUP).astype(np.uint8)
"""Groups of geoms by which heights of objects alone are measured."""
ABOVE = 0.003
"""What is higher than the objects around it by more is something else [m]."""
AROUND = 11
"""Side of the square of cells in which objects are looked for: what lies between the jaws is not far from
their middle."""


def only_of_objects(found: GraspField, field: HeightField, objects: HeightField) -> GraspField:
    """Return the field without grasps of rims and other fixtures.

    Args:
        found: the analysis of ``field``.
        field: true heights of all there is.
        objects: those of the objects alone, on the same cells.
    """
    foreign = field.heights > objects.heights + ABOVE
    highest = grey_dilation(objects.heights, size=(AROUND, AROUND))
    keep = ~foreign & (found.top <= highest + ABOVE)
    return replace(found, quality=np.where(keep, found.quality, 0).astype(np.float32))
