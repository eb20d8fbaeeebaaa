"""Pictures of what a predictor got wrong on labelled images."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from grasp_bench.grasps import Grasp
from grasp_bench.learning.data.pictures import write_picture
from grasp_bench.learning.evaluation.protocols import Case
from grasp_bench.runs.evaluation import Record

ENLARGED = 3
"""Pixels of a picture a pixel of the image."""
GREEN, RED, INK = (40, 200, 60), (230, 30, 40), (20, 20, 20)
SHOWN = 0.1
"""Heights drawn from black to white: this much below and above the median depth [m]."""


def draw_failure(record: Record, case: Case, folder: Path) -> Path:
    """Write colour and depth of an image side by side as PNG, with labels in green and the best grasp in red.

    Args:
        record: what became of the image; its verdict and overlap are written over it.
        case: what was shown.
        folder: made where it is missing; the file is named after fold and image.
    """
    near = np.median(case.depth[case.depth > 0]) - case.depth if (case.depth > 0).any() else case.depth
    grey = np.where(case.depth > 0, np.clip(128 + 127 * near / SHOWN, 0, 255), 0).astype(np.uint8)
    sides = [_marked(picture, record, case) for picture in (case.rgb, np.dstack([grey] * 3))]
    head = np.full((24, sum(s.shape[1] for s in sides), 3), 255, np.uint8)
    words = f"{record.image}: {record.verdict.replace('_', ' ')}, IoU {record.iou:.2f}"
    cv2.putText(head, words, (6, 17), cv2.FONT_HERSHEY_SIMPLEX, 0.5, INK, 1, cv2.LINE_AA)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"fold{record.fold}-{record.image.replace('/', '-')}.png"
    write_picture(path, np.vstack([head, np.hstack(sides)]))
    return path


def _marked(picture: NDArray[np.uint8], record: Record, case: Case) -> NDArray[np.uint8]:
    large = cv2.resize(picture, None, fx=ENLARGED, fy=ENLARGED, interpolation=cv2.INTER_NEAREST)
    drawn = [(r, GREEN, 1) for r in case.rectangles]
    if record.grasp is not None:
        x, y, angle, width = record.grasp
        drawn.append((Grasp(x, y, angle, width).rectangle(), RED, 2))
    for corners, colour, thickness in drawn:
        points = np.round(np.asarray(corners) * ENLARGED).astype(np.int32)
        cv2.polylines(large, [points], True, colour, thickness, cv2.LINE_AA)
    return np.asarray(large, np.uint8)
