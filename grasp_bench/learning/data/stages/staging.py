"""A random stage: the scenario of one scene, and what becomes of its picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np

from grasp_bench.errors import GraspBenchError
from grasp_bench.learning.data.stages.around import Place, surroundings
from grasp_bench.learning.data.stages.painting import look, near, surface_color
from grasp_bench.learning.data.stages.style import CameraStyle, ColourStyle, DepthStyle, Style
from grasp_bench.scenario.cameras import Camera
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scenario.sensors import Preset, Sensor

Rng = np.random.Generator

DRAWS = 1000
"""Cameras drawn at most until one suits the style."""


@dataclass(frozen=True)
class Stage:
    """How a scene is set up and pictured.

    Attributes:
        scenario: camera, sensor, light and surroundings.
        detrended: whether a tilted view stays tilted and only its depth is made level.
        origin: (3,) point from which depth is measured, in the camera's frame [m]; None for the camera's
            own depth.
    """

    scenario: Scenario
    detrended: bool = False
    origin: tuple[float, float, float] | None = None


def draw_stage(base: Scenario, style: Style, size: int, rng: Rng) -> Stage:
    """Draw a stage.

    Args:
        base: what is varied.
        size: side of the stored picture [px].

    Raises:
        GraspBenchError: where no camera is in the style's ranges.
    """
    center = np.array(base.table.center)
    camera, scale = draw_camera(base.camera, style.camera, center, rng)
    color = near(surface_color(rng, style.colour.white, style.colour.vivid), rng)
    place = Place(center, np.array(camera.position), size / 2 / scale, color)
    detrended = bool(rng.random() < style.camera.detrended)
    around = surroundings(rng, style.surroundings, style.colour, place)
    center_xy = (float(center[0]), float(center[1]))
    scenario = base.model_copy(
        update={
            "camera": camera,
            "sensor": draw_sensor(style.depth, style.colour, rng),
            "table": base.table.model_copy(update={"color": color}),
            "surroundings": around,
            "look": look(rng, style.colour, center_xy, color),
        }
    )
    foreign = rng.random() < style.depth.foreign_origin
    origin = foreign_origin(camera, rng)
    return Stage(scenario, detrended, origin if detrended and foreign else None)


def draw_camera(base: Camera, style: CameraStyle, center: np.ndarray, rng: Rng) -> tuple[Camera, float]:
    """Draw a camera, and how many pixels it gives a metre at the table's middle."""
    for _ in range(DRAWS):
        height, fov = rng.uniform(*style.height), np.radians(rng.uniform(*style.fov_deg))
        tilt = np.radians(0.0 if rng.random() < style.straight else rng.uniform(*style.tilt_deg))
        scale = float(np.exp(rng.uniform(*np.log(style.pixels_per_metre))))
        focal = scale * height / np.cos(tilt)
        width = 2 * focal * np.tan(fov / 2)
        if style.width[0] <= width <= style.width[1]:
            break
    else:
        raise GraspBenchError(
            "No camera of the style's heights, tilts and fields of view is as wide as it asks."
        )
    azimuth, roll = rng.uniform(0, 2 * np.pi), np.radians(rng.uniform(*style.roll_deg))
    target = np.array([*center + rng.uniform(-style.off_centre, style.off_centre, 2), 0.0])
    back = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    position = target + height * (np.tan(tilt) * back + [0, 0, 1])
    up = np.cos(roll) * -back + np.sin(roll) * np.array([-back[1], back[0], 0.0])
    columns = round(width)
    focal = scale * np.linalg.norm(position - target)
    return base.model_copy(
        update={
            "width": columns,
            "height": round(0.75 * columns),
            "horizontal_fov_deg": float(np.degrees(2 * np.arctan(columns / 2 / focal))),
            "position": tuple(position.tolist()),
            "target": tuple(target.tolist()),
            "image_up": tuple(up.tolist()),
        }
    ), scale


def draw_sensor(depth: DepthStyle, colour: ColourStyle, rng: Rng) -> Sensor:
    """Draw a depth and colour camera."""
    names = list(depth.presets)
    shares = np.array([depth.presets[n] for n in names])
    preset = cast(Preset, names[int(rng.choice(len(names), p=shares / shares.sum()))])
    sensor = noisier(Sensor(preset=preset), rng.uniform(*depth.strength))
    return sensor.model_copy(
        update={
            "filled": bool(rng.random() < depth.filled),
            "multipath": sensor.multipath * rng.uniform(0, 2),
            "window_px": int(rng.integers(0, 3)) if sensor.window_px else 0,
            "minimum_range": min(sensor.minimum_range, 0.35),
            "rgb_sigma": float(rng.uniform(*colour.grain)),
            "rgb_shot_noise": float(rng.uniform(0, 0.1)),
            "auto_exposure": float(rng.uniform(*colour.brightness)),
            "white_balance_sigma": colour.balance,
            "rgb_blur_px": float(rng.uniform(*colour.blur)),
            "jpeg_quality": int(rng.uniform(*colour.jpeg_quality)) if rng.random() < colour.jpeg else 0,
        }
    )


def noisier(sensor: Sensor, strength: float) -> Sensor:
    """Return the sensor with all its noise and losses ``strength`` times as strong."""
    sizes = ("axial_sigma", "axial_sigma_per_metre", "lateral_sigma_px", "rgb_sigma")
    sizes += ("axial_sigma_per_metre2",) if sensor.axial_sigma_per_metre2 else ()
    shares = ["mixed_pixels", "edge_dropout", "grazing_dropout", "speckle_dropout"]
    shares += [s for s in ("dark_dropout", "shiny_dropout", "textureless_dropout") if getattr(sensor, s)]
    return sensor.model_copy(
        update={k: strength * getattr(sensor, k) for k in sizes}
        | {k: min(strength * getattr(sensor, k), 1.0) for k in shares}
    )


def foreign_origin(camera: Camera, rng: Rng) -> tuple[float, float, float]:
    """Draw the origin of a robot's coordinates, in the camera's frame [m]: where Cornell's depth is from."""
    direction, away = rng.uniform(0, 2 * np.pi), rng.uniform(0.2, 1.0)
    base = np.array(
        [camera.target[0] + away * np.cos(direction), camera.target[1] + away * np.sin(direction), 0]
    )
    base[2] = rng.uniform(0.5, 1.2)  # above: what is higher is nearer to it
    x, y, z = camera.pose.to_camera(base).tolist()
    return x, y, z
