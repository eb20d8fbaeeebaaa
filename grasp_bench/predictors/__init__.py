"""Grasp predictors by name: networks, controls, and anyone's own by Python path."""

from __future__ import annotations

import importlib
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grasp_bench.errors import PredictorError, UnknownNameError
from grasp_bench.predictors.protocol import Predictor

__all__ = ["BUILT_IN", "Entry", "Predictor", "load_predictor"]


@dataclass(frozen=True)
class Entry:
    """A shipped predictor.

    Attributes:
        path: ``module:Class``, imported when first used.
        kind: ``network`` or ``control``.
        summary: one line for listings.
        arguments: given to the class.
        weights: file under ``assets/weights`` it needs, if any.
    """

    path: str
    kind: str
    summary: str
    arguments: tuple[Any, ...] = ()
    weights: str | None = None


_CONTROLS = "grasp_bench.predictors.controls"
_NETWORK = "grasp_bench.predictors.network:NetworkPredictor"

BUILT_IN: dict[str, Entry] = {
    "htc-grasp": Entry(_NETWORK, "network", "HTC-Grasp, hybrid Transformer-CNN (Zhang et al., 2023)",
                       ("htc-grasp",), "htc-grasp.safetensors"),
    "oracle": Entry(f"{_CONTROLS}:Oracle", "control",
                    "reference grasps of the true mesh and pose: upper bound"),
    "antipodal": Entry(f"{_CONTROLS}:Antipodal", "control", "opposite depth edges, after Dex-Net's sampling"),
    "centroid": Entry(f"{_CONTROLS}:Centroid", "control", "middle and shorter axis of the depth blob"),
    "random": Entry(f"{_CONTROLS}:Random", "control", "a random place and direction on the object"),
    "displaced": Entry(f"{_CONTROLS}:Displaced", "control", "the oracle's grasp 0.2 m beside: must fail"),
}


def load_predictor(name: str) -> Predictor:
    """A shipped predictor by name, or anyone's by ``module:Class`` (or ``module:function``).

    The module is looked for on Python's path and in the current folder. A class is called
    without arguments; what results must have ``predict(image) -> list[Grasp]``.

    Raises:
        UnknownNameError: for an unknown name.
        PredictorError: for a path that cannot be imported or does not make a predictor.
    """
    if name in BUILT_IN:
        entry = BUILT_IN[name]
        return _resolve(entry.path)(*entry.arguments)
    if ":" not in name:
        raise UnknownNameError("predictor", name, [*BUILT_IN, "my_module:MyPredictor"])
    made = _resolve(name)
    try:
        predictor = made() if isinstance(made, type) or not hasattr(made, "predict") else made
    except Exception as error:
        raise PredictorError(f"{name} could not be made: {type(error).__name__}: {error}") from error
    if not callable(getattr(predictor, "predict", None)):
        raise PredictorError(f"{name} has no method predict(image: RgbdImage) -> list[Grasp]")
    return predictor


def _resolve(path: str) -> Any:
    module_name, _, attribute = path.partition(":")
    folder = str(Path.cwd())
    if folder not in sys.path:
        sys.path.append(folder)
    try:
        module = importlib.import_module(module_name)
    except Exception as error:  # whatever a foreign module raises while it is imported
        raise PredictorError(f"The module {module_name!r} of predictor {path!r} cannot be imported: "
                             f"{type(error).__name__}: {error}") from error
    if not hasattr(module, attribute):
        names = [n for n in dir(module) if not n.startswith("_")]
        raise PredictorError(str(UnknownNameError(f"name in module {module_name!r}:", attribute, names)))
    return getattr(module, attribute)
