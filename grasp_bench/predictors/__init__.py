"""Grasp predictors by name: networks, controls, and anyone's own.

There are four ways in besides the shipped names: an entry point of an installed package (group
``grasp_bench.predictors``), ``module:Class``, the address of a server (``http://127.0.0.1:8000``),
and a command that starts one (``cmd: python my_server.py --port {port}``).
"""

from __future__ import annotations

import importlib
import sys
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import TYPE_CHECKING, Any

from grasp_bench.errors import PredictorError, UnknownNameError

if TYPE_CHECKING:
    from grasp_bench.predictors.protocol import Predictor

__all__ = ["BUILT_IN", "GROUP", "Entry", "installed", "load_predictor"]

GROUP = "grasp_bench.predictors"
"""Group of entry points in which packages offer predictors."""
COMMAND = "cmd:"
"""What a predictor's name begins with where the harness is to start its server."""
ADDRESSES = ("http://", "https://")
EXAMPLES = ("my_module:MyPredictor", "http://127.0.0.1:PORT", "cmd: COMMAND --port {port}")
"""How the other ways in are spelt, for messages."""


@dataclass(frozen=True)
class Entry:
    """A shipped predictor.

    Attributes:
        path: ``module:Class``, imported when first used.
        kind: ``network`` or ``control``.
        summary: one line for listings.
        arguments: given to the class, before the weights if it needs any.
        weights: name of those it needs under ``assets/weights``, if any.
    """

    path: str
    kind: str
    summary: str
    arguments: tuple[Any, ...] = ()
    weights: str | None = None

    @property
    def file(self) -> Path | None:
        """Where the weights it needs lie."""
        from grasp_bench.system.integrity import weights_path

        return None if self.weights is None else weights_path(self.weights)

    @property
    def available(self) -> bool:
        """Whether the weights it needs are there."""
        return self.file is None or self.file.is_file()


_CONTROLS = "grasp_bench.predictors.controls"
_NETWORK = "grasp_bench.predictors.network:NetworkPredictor"


def _network(name: str, summary: str, weights: str | None = None) -> Entry:
    return Entry(_NETWORK, "network", summary, (name,), weights or name)


BUILT_IN: dict[str, Entry] = {
    "htc-grasp": _network("htc-grasp", "HTC-Grasp, hybrid Transformer-CNN (Zhang et al., 2023)"),
    "htc-grasp-1000": _network("htc-grasp", "HTC-Grasp after 1,000 steps, as all below", "htc-grasp-1000"),
    "gg-cnn": _network("gg-cnn", "GG-CNN on depth (Morrison et al., 2018)"),
    "gg-cnn2": _network("gg-cnn2", "GG-CNN2 on depth (Morrison et al., 2020)"),
    "gr-convnet": _network("gr-convnet", "GR-ConvNet, 32 channels, RGB-D (Kumra et al., 2020)"),
    "gr-convnet-16": _network("gr-convnet-16", "GR-ConvNet, 16 channels, RGB-D (Kumra et al., 2020)"),
    "tf-grasp": _network("tf-grasp", "TF-Grasp, Swin Transformer, RGB-D (Wang et al., 2022)"),
    "htc-grasp-no-ea": _network("htc-grasp-no-ea", "HTC-Grasp's ablation: plain self-attention"),
    "htc-grasp-no-ca": _network("htc-grasp-no-ca", "HTC-Grasp's ablation: no channel attention"),
    "htc-grasp-plain": _network("htc-grasp-plain", "HTC-Grasp's ablation: neither"),
    "oracle": Entry(
        f"{_CONTROLS}:Oracle", "control", "reference grasps of the true mesh and pose: upper bound"
    ),
    "antipodal": Entry(f"{_CONTROLS}:Antipodal", "control", "opposite depth edges, after Dex-Net's sampling"),
    "centroid": Entry(f"{_CONTROLS}:Centroid", "control", "middle and shorter axis of the depth blob"),
    "random": Entry(f"{_CONTROLS}:Random", "control", "a random place and direction on the object"),
    "displaced": Entry(f"{_CONTROLS}:Displaced", "control", "the oracle's grasp 0.2 m beside: must fail"),
}


def installed() -> dict[str, list[EntryPoint]]:
    """Predictors that installed packages offer, by name; nothing is imported."""
    found: dict[str, list[EntryPoint]] = {}
    for point in entry_points(group=GROUP):
        found.setdefault(point.name, []).append(point)
    return dict(sorted(found.items()))


def load_predictor(name: str) -> Predictor:
    """A shipped predictor by name, or anyone's by one of the other ways in.

    ``module:Class`` is looked for on Python's path and in the current folder. A class or a
    function is called without arguments; what results must have
    ``predict(image) -> list[Grasp]``. A name that a shipped predictor has means that one,
    whatever packages are installed. A predictor with a method ``close`` shall be closed.

    Raises:
        UnknownNameError: for an unknown name.
        PredictorError: for one that cannot be imported or started, or that makes no predictor.
    """
    if name in BUILT_IN:
        entry = BUILT_IN[name]
        return _resolve(entry.path)(*entry.arguments, *([entry.file] if entry.file else []))
    if name.startswith(ADDRESSES):
        from grasp_bench.predictors.remote import RemotePredictor

        return RemotePredictor(name)
    if name.startswith(COMMAND):
        from grasp_bench.predictors.command import CommandPredictor

        return CommandPredictor(name.removeprefix(COMMAND))
    return _make(_resolve(python_path(name)), name)


def python_path(name: str) -> str:
    """``module:Class`` of a predictor's name, which is that already or an entry point's.

    Raises:
        UnknownNameError: for a name that no installed package offers.
        PredictorError: for a name that several offer.
    """
    if name in BUILT_IN:
        return BUILT_IN[name].path
    if ":" in name:
        return name
    offers = installed()
    if name not in offers:
        raise UnknownNameError("predictor", name, [*BUILT_IN, *offers, *EXAMPLES])
    values = sorted({point.value for point in offers[name]})
    if len(values) > 1:
        raise PredictorError(
            f"Several installed packages offer a predictor {name!r}: "
            f"{' and '.join(values)}. Name the one you mean by its module:Class."
        )
    return values[0]


def _make(maker: Any, name: str) -> Predictor:
    try:
        predictor = maker() if isinstance(maker, type) or not hasattr(maker, "predict") else maker
    except (Exception, SystemExit) as error:
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
    except (Exception, SystemExit) as error:  # whatever a foreign module raises while it is imported
        raise PredictorError(
            f"The module {module_name!r} of predictor {path!r} cannot be imported: "
            f"{type(error).__name__}: {error}"
        ) from error
    if not hasattr(module, attribute):
        names = [n for n in dir(module) if not n.startswith("_")]
        raise PredictorError(str(UnknownNameError(f"name in module {module_name!r}:", attribute, names)))
    return getattr(module, attribute)
