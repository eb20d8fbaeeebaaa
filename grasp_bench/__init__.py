"""grasp-bench: how often does a grasp predictor really lift the object?

The names below are the public API; they are imported when first used, so that
``import grasp_bench`` stays quick.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from grasp_bench.camera import CameraPose as CameraPose
    from grasp_bench.camera import Intrinsics as Intrinsics
    from grasp_bench.camera import RgbdImage as RgbdImage
    from grasp_bench.errors import GraspBenchError as GraspBenchError
    from grasp_bench.grasps import Grasp as Grasp
    from grasp_bench.grasps import GraspMaps as GraspMaps
    from grasp_bench.grasps import GraspPose as GraspPose
    from grasp_bench.predictors import load_predictor as load_predictor
    from grasp_bench.scenario import Scenario as Scenario
    from grasp_bench.scenario import load_scenario as load_scenario

__version__ = "0.1.0"

_HOME = {
    "CameraPose": "camera", "Intrinsics": "camera", "RgbdImage": "camera", "GraspBenchError": "errors",
    "Grasp": "grasps", "GraspMaps": "grasps", "GraspPose": "grasps", "load_predictor": "predictors",
    "Scenario": "scenario", "load_scenario": "scenario",
}
__all__ = [
    "CameraPose", "Grasp", "GraspBenchError", "GraspMaps", "GraspPose", "Intrinsics", "RgbdImage",
    "Scenario", "load_predictor", "load_scenario",
]


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}; it offers {', '.join(__all__)}")
