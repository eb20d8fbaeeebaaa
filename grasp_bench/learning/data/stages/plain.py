"""The plain picture of a scene: the scenario's own camera, no shadows, a light that varies a little."""

from __future__ import annotations

import cv2
import mujoco
import numpy as np
from numpy.typing import NDArray

from grasp_bench.camera import Intrinsics
from grasp_bench.learning.data.stages.shot import Shot
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.builder import TABLE
from grasp_bench.scene.rendering import Picture, raycast
from grasp_bench.scene.sensor import sense

Rng = np.random.Generator


def plain_shot(scenario: Scenario, model: mujoco.MjModel, data: mujoco.MjData, size: int, rng: Rng) -> Shot:
    """Take the middle ``size`` px of the picture of the scenario's own camera, in a plain light."""
    mujoco.mj_forward(model, data)
    full, pose = scenario.camera.intrinsics, scenario.camera.pose
    left, upper = (full.width - size) // 2, (full.height - size) // 2
    crop = Intrinsics(size, size, full.fx, full.fy, full.cx - left, full.cy - upper)
    picture = raycast(model, data, pose.position, crop.rays() @ pose.rotation.T)
    image = sense(picture._replace(rgb=photo(model, picture, rng)), crop, scenario.sensor, rng)
    return Shot(image.rgb, image.depth, picture, crop, pose, np.ones(picture.depth.shape, bool))


def photo(model: mujoco.MjModel, picture: Picture, rng: Rng) -> NDArray[np.uint8]:
    """Put the picture under random light, its table perhaps speckled or grained."""
    h, w = picture.geom.shape
    grain = int(rng.integers(3))
    coarse = rng.standard_normal([(2, 2), (h // 4, w // 4), (3, w // 3)][grain]).astype(np.float32)
    coarse = coarse.T if rng.random() < 0.5 else coarse
    pattern = 1 + rng.uniform(0.02, 0.1) * cv2.resize(coarse, (w, h), interpolation=cv2.INTER_CUBIC)
    light = rng.uniform(0.7, 1.3) * (1 + rng.uniform(-0.07, 0.07, 3))
    slope = rng.uniform(-0.2, 0.2, 2)
    shade = 1 + slope[0] * np.linspace(-1, 1, h)[:, None] + slope[1] * np.linspace(-1, 1, w)
    shade = np.where(picture.geom == model.geom(TABLE).id, shade * pattern, shade)
    return np.clip(picture.rgb * shade[..., None] * light, 0, 255).astype(np.uint8)
