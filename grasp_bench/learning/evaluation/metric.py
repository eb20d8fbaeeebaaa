"""The rectangle metric (paper, section 4.1(c), equation 9), exact and as the GG-CNN lineage computes it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.ndimage import gaussian_filter

from grasp_bench.grasps import Grasp, GraspMaps, angle_difference, rectangle_iou, wrap_angle
from grasp_bench.runs.evaluation import Verdict
from grasp_bench.system.arrays import Floats

ANGLE = math.radians(30)
IOU = 0.25


@dataclass(frozen=True)
class Judged:
    """A grasp against the labels.

    Attributes:
        verdict: 'correct'; 'wrong_angle' when a label overlaps enough but none within 30°;
            'elsewhere' when none overlaps enough; 'none' when there was no grasp; 'error' when the
            predictor failed.
        iou: largest intersection over union with a label within 30°.
        angle: between the grasp and the label that overlaps most [rad]; NaN where none overlaps.
    """

    verdict: Verdict
    iou: float = 0.0
    angle: float = math.nan


def judge(grasp: Grasp | None, rectangles: Floats, *, rasterised: bool = False) -> Judged:
    """Tell whether a grasp is within 30° of, and overlaps by more than 0.25 with, a labelled rectangle.

    The predicted rectangle is half as high as wide, as the lineage has it, since these networks
    predict no jaw size; labelled rectangles (N, 4, 2) keep theirs.

    Args:
        grasp: the best prediction; None counts as wrong.
        rectangles: labels in the same pixels, first edges along the opening.
        rasterised: count pixels as GG-CNN's code does, instead of exact areas.
    """
    if grasp is None:
        return Judged("none")
    corners = grasp.rectangle()
    overlap = raster_iou if rasterised else rectangle_iou
    iou = np.array([overlap(corners, r) for r in rectangles])
    off = np.array([angle_difference(grasp.angle, Grasp.from_rectangle(r).angle) for r in rectangles])
    if not len(iou) or iou.max() <= 0:
        return Judged("elsewhere")
    aligned = np.where(off <= ANGLE, iou, 0.0)
    verdict = "correct" if aligned.max() > IOU else "wrong_angle" if iou.max() > IOU else "elsewhere"
    return Judged(verdict, float(aligned.max()), float(off[iou.argmax()]))


def raster_iou(first: Floats, second: Floats) -> float:
    """Return the intersection over union of two convex quadrilaterals (4, 2) in whole pixels."""
    both = np.concatenate([first, second])
    low = np.floor(both.min(axis=0)) - 1
    width, height = (np.ceil(both.max(axis=0)) - low + 2).astype(int)
    masks = []
    for corners in (first, second):
        mask = np.zeros((height, width), np.uint8)
        cv2.fillConvexPoly(mask, np.round(corners - low - 0.5).astype(np.int32), (1,))
        masks.append(mask > 0)
    union = (masks[0] | masks[1]).sum()
    return float((masks[0] & masks[1]).sum() / union) if union else 0.0


def legacy_best(maps: GraspMaps, min_distance: int = 20, threshold: float = 0.2) -> Grasp | None:
    """Find the lineage's best grasp: Gaussian filters of 2, 2 and 1 px on quality, *angle* and width.

    The angle is filtered as it is, which smears across the ±π/2 seam. Maxima within
    ``min_distance`` of the border or not above ``threshold`` do not count.
    """
    quality, angle = gaussian_filter(maps.quality, 2.0), gaussian_filter(maps.angle, 2.0)
    width = gaussian_filter(maps.width, 1.0)
    inner = quality[min_distance:-min_distance, min_distance:-min_distance]
    if not inner.size or inner.max() <= threshold:
        return None
    r, c = (int(i) + min_distance for i in np.unravel_index(int(inner.argmax()), inner.shape))
    return Grasp(
        c + 0.5,
        r + 0.5,
        wrap_angle(float(angle[r, c])),
        max(float(width[r, c]), 1.0),
        float(np.clip(quality[r, c], 0, 1)),
    )
