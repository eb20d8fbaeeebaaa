"""grasp-bench: how often does a grasp predictor really lift the object?

The names below are the public API; they are imported when first used, so that
``import grasp_bench`` stays quick.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from grasp_bench.api import load as load
    from grasp_bench.api import load_object as load_object
    from grasp_bench.api import run as run
    from grasp_bench.camera import CameraPose as CameraPose
    from grasp_bench.camera import Intrinsics as Intrinsics
    from grasp_bench.camera import RgbdImage as RgbdImage
    from grasp_bench.errors import GraspBenchError as GraspBenchError
    from grasp_bench.grasps import Grasp as Grasp
    from grasp_bench.grasps import GraspMaps as GraspMaps
    from grasp_bench.grasps import GraspPose as GraspPose
    from grasp_bench.objects.catalog import Catalog as Catalog
    from grasp_bench.objects.catalog import ObjectModel as ObjectModel
    from grasp_bench.predictors import load_predictor as load_predictor
    from grasp_bench.predictors.protocol import Predictor as Predictor
    from grasp_bench.report.run import Run as Run
    from grasp_bench.runs.comparison import Comparison as Comparison
    from grasp_bench.runs.record import TrialRecord as TrialRecord
    from grasp_bench.scenario.outcomes import Outcome as Outcome
    from grasp_bench.scenario.reading import load_scenario as load_scenario
    from grasp_bench.scenario.sections import Scenario as Scenario
    from grasp_bench.trials.attempt import Trial as Trial
    from grasp_bench.trials.trial import run_trial as run_trial
    from grasp_bench.trials.workcell import Workcell as Workcell

# fmt: off
_HOME = {
    "CameraPose": "camera", "Catalog": "objects.catalog", "Comparison": "runs.comparison", "Grasp": "grasps",
    "GraspBenchError": "errors", "GraspMaps": "grasps", "GraspPose": "grasps", "Intrinsics": "camera",
    "ObjectModel": "objects.catalog", "Outcome": "scenario.outcomes", "Predictor": "predictors.protocol",
    "RgbdImage": "camera", "Run": "report.run", "Scenario": "scenario.sections", "Trial": "trials.attempt",
    "TrialRecord": "runs.record", "Workcell": "trials.workcell",
    "load": "api", "load_object": "api", "load_predictor": "predictors", "load_scenario": "scenario.reading",
    "run": "api", "run_trial": "trials.trial",
}
__all__ = [
    "CameraPose", "Catalog", "Comparison", "Grasp", "GraspBenchError", "GraspMaps", "GraspPose", "Intrinsics",
    "ObjectModel", "Outcome", "Predictor", "RgbdImage", "Run", "Scenario", "Trial", "TrialRecord", "Workcell",
    "load", "load_object", "load_predictor", "load_scenario", "run", "run_trial",
]
# fmt: on


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)
    if name == "__version__":
        from importlib.metadata import version

        return version("grasp-bench")
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}; it offers {', '.join(__all__)}")


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
