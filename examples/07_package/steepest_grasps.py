"""Grasps the edge where depth changes most, across it.

`pip install ./07_package`, then `grasp-bench run --trials 20 --predictor steepest`: it lifts 9 of 20.
"""

import numpy as np
from scipy.ndimage import gaussian_filter

from grasp_bench import Grasp, RgbdImage
from grasp_bench.grasps import wrap_angle


class Steepest:
    def predict(self, image: RgbdImage) -> list[Grasp]:
        table = float(np.median(image.depth[image.valid])) if image.valid.any() else 0.0
        dy, dx = np.gradient(gaussian_filter(np.where(image.valid, image.depth, table), 2))
        steep = np.hypot(dx, dy)
        near = [np.abs(np.arange(n) - n / 2) < 112 for n in steep.shape]
        steep *= np.outer(*near)  # further out are the table's edges
        row, column = np.unravel_index(np.argmax(steep), steep.shape)
        angle = wrap_angle(float(np.arctan2(-dy[row, column], dx[row, column])))
        return [Grasp(x=float(column) + 0.5, y=float(row) + 0.5, angle=angle, width=40, quality=0.5)]

    def info(self) -> dict[str, str]:  # optional: written to run.json, and must agree on resume
        return {"method": "steepest depth edge"}
