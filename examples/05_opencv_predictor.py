"""A classical predictor with OpenCV: the smallest rectangle around a thing, grasped across.

Check and run it with:  cd examples
                        grasp-bench predictors check 05_opencv_predictor:Rectangle
                        grasp-bench run --trials 20 --predictor 05_opencv_predictor:Rectangle
It lifts 17 of 20.
"""

import math

import cv2
import numpy as np

from grasp_bench import Grasp, RgbdImage
from grasp_bench.grasps import wrap_angle


class Rectangle:
    """Segments by height above the table, and closes the jaws over the shorter side."""

    def predict(self, image: RgbdImage) -> list[Grasp]:
        if not image.valid.any():
            return []
        table = float(np.median(image.depth[image.valid]))
        above = (image.valid & (image.depth < table - 0.006)).astype(np.uint8)  # 6 mm: above the noise
        above = cv2.morphologyEx(above, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
        outlines, _ = cv2.findContours(above, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        grasps = []
        for outline in sorted(outlines, key=cv2.contourArea, reverse=True)[:3]:
            if cv2.contourArea(outline) < 50:
                break
            corners = cv2.boxPoints(cv2.minAreaRect(outline)) + 0.5  # pixel centres lie at + 0.5
            sides = np.diff(corners[:3], axis=0)
            dx, dy = min(sides, key=np.linalg.norm)  # the jaws open along the shorter side
            x, y = corners.mean(0)
            angle = wrap_angle(math.atan2(-dy, dx))  # rows grow downwards, angles run counter-clockwise
            grasps.append(Grasp(float(x), float(y), angle, float(math.hypot(dx, dy)) + 14, 0.5))
        return grasps
