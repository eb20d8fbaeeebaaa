"""Two ways to ask for the best grasp of a labelled image: without, and with, the lineage's habits."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from grasp_bench.camera import Intrinsics, RgbdImage
from grasp_bench.errors import GraspBenchError, PredictorError
from grasp_bench.grasps import Grasp, GraspMaps
from grasp_bench.learning.data.framing import Frame, Framed, framed
from grasp_bench.learning.data.rectangles import Collection, Sample
from grasp_bench.learning.evaluation.metric import Judged, judge, legacy_best
from grasp_bench.predictors.protocol import PrivilegedPredictor, ask, begin
from grasp_bench.runs.evaluation import Protocol
from grasp_bench.system.arrays import Floats

CONVENTIONS: dict[Protocol, dict[str, str]] = {
    "strict": {
        "window": "the same square about the middle of every image; the labels are not looked at",
        "no augmentation": "images are evaluated as they are",
        "last step": "weights of the training's last step; the test fold chooses nothing",
        "levelled": "the table, fitted by a polynomial of second degree, is taken off the depth",
        "best grasp": "one grasp an image, the highest of the quality map",
        "exact overlap": "areas of polygons, IoU > 0.25, angle within 30°",
    },
    "legacy": {
        "label-centred crop": "the window is centred on the mean of the labelled corners, within the image",
        "native scale": "Cornell's pixels are not resized to the network's side; Jacquard's whole image is",
        "depth as it is": "the table is not taken off; a network of this project does so itself",
        "augmented": "a random quarter turn and zoom by 1 to 2, as GG-CNN's and GR-ConvNet's code validate",
        "angle smoothed": "a Gaussian filter on the wrapped angle map, across its ±90° seam",
        "peak": "best maximum above 0.2, 20 px from the border; none counts as wrong",
        "rasterised overlap": "pixels are counted, IoU > 0.25, angle within 30°",
    },
}
"""What each protocol does, by name. The lineage's choice of the epoch that is best on the test
images, and TF-Grasp's best of two grasps, are not copied."""


@dataclass(frozen=True)
class Case:
    """One image as a predictor is shown it, with labels in its pixels.

    Attributes:
        name: identifies the sample in its collection.
        object: what it shows, if known.
        rgb, depth: as in :class:`grasp_bench.learning.data.framing.Framed`; level in 'strict' only.
        rectangles: (N, 4, 2) labels in pixels of the case.
        dropped: number of labels that held NaN.
    """

    name: str
    object: str | None
    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    rectangles: Floats
    dropped: int = 0


def make_case(collection: Collection, index: int, crop: int, protocol: Protocol, seed: int = 0) -> Case:
    """Show the ``index``-th sample of a collection as the protocol does, ``crop`` px a side."""
    entry = collection.entries[index]
    sample = collection.load(entry)
    if protocol == "strict":
        seen = framed(sample, Frame.middle(sample.depth.shape, collection.window, crop), crop)
    else:
        seen = _legacy_view(sample, collection.native or crop, crop, np.random.default_rng([seed, index]))
    return Case(sample.name, entry.object, seen.rgb, seen.depth, seen.rectangles, sample.dropped)


def _legacy_view(sample: Sample, window: int, crop: int, rng: np.random.Generator) -> Framed:
    h, w = sample.depth.shape
    middle = sample.rectangles.mean(axis=(0, 1)) if len(sample.rectangles) else np.array([w / 2, h / 2])
    x, y = (
        float(np.clip(m, min(window, n) / 2, n - min(window, n) / 2))
        for m, n in zip(middle, (w, h), strict=True)
    )
    seen = framed(sample, Frame(x, y, window * rng.uniform(0.5, 1.0), crop), None)
    turns = int(rng.integers(4))
    points = seen.rectangles
    for _ in range(turns):  # np.rot90 takes (x, y) to (y, S − x)
        points = np.stack([points[..., 1], crop - points[..., 0]], axis=-1)
    return replace(
        seen,
        rgb=np.ascontiguousarray(np.rot90(seen.rgb, turns)),
        depth=np.ascontiguousarray(np.rot90(seen.depth, turns)),
        rectangles=points,
    )


@dataclass(frozen=True)
class Answer:
    """What a predictor said of one image.

    Attributes:
        grasp: the best, in pixels of the case; None for none.
        seconds, cpu: what it took on the clock, and on a processor.
        error: what the predictor raised, or why its answer is unusable; None where all is well.
    """

    grasp: Grasp | None
    seconds: float
    cpu: float
    error: str | None = None


def best_grasp(
    predictor: Any, case: Case, protocol: Protocol, rng: np.random.Generator, rim: int = 0
) -> Answer:
    """Ask for the best grasp of a case.

    Args:
        predictor: whom; for 'legacy' it must have ``maps(image) -> GraspMaps``.
        rng: the image's random stream, for a predictor that has ``begin``.
        rim: grasps whose centres are nearer than this to the picture's edge do not count in 'strict' [px].

    Raises:
        GraspBenchError: when the predictor cannot be evaluated on images, or not by this protocol.
    """
    image = as_image(case)
    if isinstance(predictor, PrivilegedPredictor):
        raise GraspBenchError(
            f"{type(predictor).__name__} needs the simulator's truth and cannot be evaluated on a data set."
        )
    if protocol == "legacy" and not hasattr(predictor, "maps"):
        raise GraspBenchError(
            "--protocol legacy filters a network's maps; this predictor gives grasps only (no maps()). "
            "Use --protocol strict."
        )
    began = _clocks()
    found, error = None, None
    try:
        if protocol == "strict":
            grasps = ask(predictor, image, rng)
            h, w = case.depth.shape
            grasps = [g for g in grasps if rim <= g.x <= w - rim and rim <= g.y <= h - rim]
            found = grasps[0] if grasps else None
        else:
            found = legacy_best(_maps(predictor, image, rng))
    except PredictorError as raised:
        error = str(raised)
    seconds, cpu = (_clocks() - began).tolist()
    return Answer(found, seconds, cpu, error)


def _maps(predictor: Any, image: RgbdImage, rng: np.random.Generator) -> GraspMaps:
    try:
        begin(predictor, rng)
        maps = predictor.maps(image)
    except GraspBenchError:  # of a server: this image's; of a detector, which has no maps: of all
        raise
    except (Exception, SystemExit) as error:  # anything a foreign predictor may raise
        raise PredictorError(f"maps() raised {type(error).__name__}: {str(error)[:1000]}") from error
    if not isinstance(maps, GraspMaps) or maps.quality.shape != image.depth.shape:
        raise PredictorError(
            f"maps() must return GraspMaps of {image.depth.shape} px, got {type(maps).__name__}"
            + (f" of {maps.quality.shape} px" if isinstance(maps, GraspMaps) else "")
        )
    return maps


def _clocks() -> Floats:
    """Read the seconds on the clock, and of this thread on a processor."""
    return np.array([time.perf_counter(), time.thread_time()])


def as_image(case: Case) -> RgbdImage:
    """Make of a case what predictors get; its camera is unknown, and taken to be one of 60° field of view."""
    h, w = case.depth.shape
    return RgbdImage(case.rgb, case.depth, Intrinsics.from_fov(w, h, np.radians(60.0)))


def judge_answer(answer: Answer, case: Case, protocol: Protocol) -> Judged:
    """Judge the best grasp by the protocol's metric; an error is a verdict of its own."""
    if answer.error is not None:
        return Judged("error")
    return judge(answer.grasp, case.rectangles, rasterised=protocol == "legacy")
