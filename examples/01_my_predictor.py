"""The smallest predictor: grasp what stands highest, jaws along the image's rows.

Run it with:  cd examples && grasp-bench run --trials 20 --predictor 01_my_predictor:Highest
It lifts 11 of 20: it knows one direction of the jaws only.
"""

import numpy as np

from grasp_bench import Grasp, RgbdImage


class Highest:
    """Grasps the highest point in the middle of the picture."""

    def predict(self, image: RgbdImage) -> list[Grasp]:
        w = image.depth.shape[1]
        depth = np.where(image.depth > 0, image.depth, np.inf)
        depth[:, : w // 2 - 112] = depth[:, w // 2 + 112 :] = np.inf
        row, column = np.unravel_index(np.argmin(depth), depth.shape)
        if np.isinf(depth[row, column]):
            return []
        opening = 0.08 * image.intrinsics.fx / depth[row, column]  # 80 mm in pixels at that depth
        return [
            Grasp(x=float(column) + 0.5, y=float(row) + 0.5, angle=0.0, width=float(opening), quality=0.5)
        ]
