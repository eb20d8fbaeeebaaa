"""Other physics that would be as plausible: what nobody measured to better than this."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, cast

import numpy as np

from grasp_bench.scenario.sections import Scenario
from grasp_bench.scenario.sensors import Sensor


@dataclass(frozen=True)
class Ranges:
    """How far a world may differ from a scenario's. Factors are drawn evenly in their logarithm.

    Attributes:
        friction: share by which friction at pads and table, each by itself, may be more; or as much less.
        mass: the same of all masses.
        centre_of_mass_mm: greatest shift of the centres of mass along each axis of the object [mm].
        timesteps: from which the physics' step is drawn, evenly in its logarithm [s].
        cones: kinds of friction cone.
        pad_stiffness: greatest factor, or divisor, of the pads' stiffness.
        sensors: presets of the depth camera, besides the scenario's own.
        calibration_mm: greatest error of the camera's place [mm], drawn anew each trial.
    """

    friction: float = 0.3
    mass: float = 0.2
    centre_of_mass_mm: float = 5.0
    timesteps: tuple[float, float] = (0.001, 0.004)
    cones: tuple[str, ...] = ("elliptic", "pyramidal")
    pad_stiffness: float = 2.0
    sensors: tuple[str, ...] = ("femto-w", "azure-kinect", "structured-light")
    calibration_mm: float = 3.0


PLAUSIBLE = Ranges()


def plausible(base: Scenario, index: int, seed: int = 0, ranges: Ranges = PLAUSIBLE) -> Scenario:
    """Return the ``index``-th world drawn about a scenario; number 0 is the scenario itself.

    A world depends on ``seed`` and ``index`` only. Its name is the base's with ``-w`` and the number.
    """
    if index == 0:
        return base
    rng = np.random.default_rng([seed, index])
    spread = np.log1p(ranges.friction)
    pads, table = np.exp(rng.uniform(-spread, spread, 2)).tolist()
    mass = float(np.exp(rng.uniform(-1, 1) * np.log1p(ranges.mass)))
    shift = np.round(rng.uniform(-1, 1, 3) * ranges.centre_of_mass_mm, 3).tolist()
    timestep = float(np.exp(rng.uniform(*np.log(ranges.timesteps))))
    cone = cast(Literal["elliptic", "pyramidal"], str(rng.choice(ranges.cones)))
    stiffness = float(np.exp(rng.uniform(-1, 1) * np.log(ranges.pad_stiffness)))
    chosen = str(rng.choice([base.sensor.preset, *(s for s in ranges.sensors if s != base.sensor.preset)]))
    sensor = base.sensor if chosen == base.sensor.preset else Sensor.model_validate({"preset": chosen})
    error = float(rng.uniform(0, ranges.calibration_mm))
    changes: dict[str, dict[str, Any]] = {
        "table": {"friction": round(base.table.friction * table, 4)},
        "gripper": {
            "friction_scale": round(base.gripper.friction_scale * pads, 4),
            "pad_stiffness": round(base.gripper.pad_stiffness * stiffness, 4),
        },
        "objects": {
            "mass_scale": round(base.objects.mass_scale * mass, 4),
            "centre_of_mass_mm": tuple(shift),
        },
        "physics": {"timestep": round(timestep, 5), "cone": cone},
        "calibration": {"position_mm": round(base.calibration.position_mm + error, 3)},
    }
    sections = {name: getattr(base, name).model_copy(update=values) for name, values in changes.items()}
    name = f"{base.name}-w{index}"
    drawn = base.model_copy(update={**sections, "sensor": sensor, "name": name})
    return Scenario.model_validate(drawn.model_dump())  # within the limits of every key
