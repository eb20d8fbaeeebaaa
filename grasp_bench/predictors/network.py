"""A trained network as a predictor: centre crop, forward pass, peaks of the quality map or best rows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from grasp_bench.camera import RgbdImage
from grasp_bench.errors import GraspBenchError, PredictorError
from grasp_bench.grasps import Grasp, GraspMaps
from grasp_bench.networks.calibration import calibration_of
from grasp_bench.networks.encoding import grasps_from_output, maps_from_output, to_input
from grasp_bench.networks.registry import info, input_kind
from grasp_bench.networks.spec import Kind
from grasp_bench.networks.store import stored_input
from grasp_bench.predictors.level import level_view
from grasp_bench.predictors.surroundings import surroundings
from grasp_bench.predictors.tabletop import levelled

if TYPE_CHECKING:
    import torch

Level = Literal["camera", "table", "none"]


class NetworkPredictor:
    """Grasps by a network of ``grasp_bench.networks``, on CUDA where there is one.

    The middle of the image is looked at, in a square of the network's input size. An image
    that is smaller is padded, colour by its border and depth by holes (which are then filled
    from the border); grasps are not centred in the padding.

    Args:
        name: a registered network.
        weights: safetensors file; by default the shipped one.
        peaks: greatest number of grasps returned.
        level: 'camera' shows the network a tilted camera's picture as one from straight above; 'table'
            takes a fitted surface off the depth in the crop, for depth that no pinhole camera measured such
            as Cornell's (see :mod:`grasp_bench.predictors.tabletop`); 'none' shows pictures as they are.
        surrounded: whether walls, floors and their feet are told from what may be grasped, so that no grasp
            is centred there (:mod:`grasp_bench.predictors.surroundings`).
        tta: test-time augmentation: the mean of what the network says of a picture and of three turned and
            mirrored copies, for four times the time (:mod:`grasp_bench.networks.symmetries`).

    Raises:
        AssetError: for weights that are missing or damaged.
        PredictorError: ``tta`` was asked of a detector, which has no maps to average.

    Attributes:
        crop_origin: (x, y) of the crop's corner in the last image [px], negative if padded.
        last_maps: maps of the last image at ``crop_origin``, not smoothed; None after a tilted camera's, and
            of a detector.
        metadata: facts stored with the weights.
        calibration: stored with the weights: how much wider to open, how likely grasps of a quality hold.
        kind, crop: kind and side [px] of the network's input.
    """

    def __init__(
        self,
        name: str = "htc-grasp",
        weights: Path | None = None,
        peaks: int = 10,
        level: Level = "camera",
        surrounded: bool = True,
        tta: bool = False,
    ) -> None:
        import torch

        from grasp_bench.networks.folding import folded
        from grasp_bench.networks.rows import Detector
        from grasp_bench.networks.symmetries import Averaged
        from grasp_bench.networks.weights import load

        self.name, self.peaks, self.level, self.surrounded = name, peaks, level, surrounded
        self.crop_origin = (0, 0)
        self.last_maps: GraspMaps | None = None
        self.crop = info(name).crop
        self._device = torch.device("cuda" if torch.cuda.is_available() else "cpu")
        network, self.metadata = load(name, weights)
        self.kind: Kind = input_kind(name, stored_input(self.metadata))
        self.calibration = calibration_of(self.metadata, str(weights or name))
        if tta and isinstance(network, Detector):
            raise PredictorError(f"{name} gives grasps and no maps, which test-time augmentation averages.")
        # Channels last is the fastest layout of every network here once its norms are folded.
        ready = folded(network).to(self._device).to(memory_format=torch.channels_last)  # pyright: ignore[reportCallIssue]
        self._network = Averaged(ready) if tta else ready

    def predict(self, image: RgbdImage) -> list[Grasp]:
        """Return grasps in pixels of the whole image, best first; empty if the network sees none.

        Networks are trained on tables seen from straight above; see :mod:`grasp_bench.predictors.level` for
        what becomes of others.
        """
        view = level_view(image) if self.level == "camera" else None
        if view is None:
            return self._predict(image)
        grasps = view.inside(self._predict(view.image))
        self.last_maps = None  # they are of another picture
        return grasps

    def _predict(self, image: RgbdImage) -> list[Grasp]:
        output, allowed = self._answer(image)
        ox, oy = self.crop_origin
        if output.ndim == 2:  # a detector's rows
            found = grasps_from_output(output, self.peaks)
            within = [g for g in found if _at(allowed, g)]
        else:
            self.last_maps = raw = maps_from_output(output)
            maps = raw.smoothed()
            within = replace(maps, quality=maps.quality * allowed).peaks(count=self.peaks)
        return [self.calibration.judged(replace(g, x=g.x + ox, y=g.y + oy)) for g in within]

    def maps(self, image: RgbdImage) -> GraspMaps:
        """Return the network's maps of the crop at ``crop_origin``, not smoothed.

        Raises:
            GraspBenchError: the network is a detector, which has none.
        """
        output, allowed = self._answer(image)
        if output.ndim == 2:
            raise GraspBenchError(
                f"{self.name} gives grasps and no maps, so that it cannot be asked for its maps; "
                "evaluate it by --protocol strict."
            )
        maps = maps_from_output(output)
        return replace(maps, quality=maps.quality * allowed)

    def _answer(self, image: RgbdImage) -> tuple[torch.Tensor, NDArray[np.bool_]]:
        """Return maps (4, H, W) or a detector's rows (N, 6), and where in the crop (H, W) grasps may be."""
        rgb, depth, self.crop_origin = centre_crop(image, self.crop)
        if self.level == "table":
            depth = levelled(depth, self.crop)
        allowed = ~surroundings(depth) if self.surrounded else np.ones(depth.shape, bool)
        (ox, oy), (height, width) = self.crop_origin, image.depth.shape
        allowed[: max(-oy, 0)] = allowed[height - oy :] = False  # not in the padding
        allowed[:, : max(-ox, 0)] = allowed[:, width - ox :] = False
        return self.calibration.widened(self._forward(to_input(rgb, depth, self.kind))), allowed

    def _forward(self, x: np.ndarray) -> torch.Tensor:
        import torch

        # One thread: trials run in parallel processes, and timings must not depend on the number of cores.
        threads = torch.get_num_threads()
        if self._device.type == "cpu" and threads != 1:
            torch.set_num_threads(1)
        try:
            with torch.inference_mode():
                batch = torch.from_numpy(x)[None].to(self._device, memory_format=torch.channels_last)
                return self._network(batch)[0]
        finally:
            if torch.get_num_threads() != threads:
                torch.set_num_threads(threads)


def centre_crop(image: RgbdImage, size: int) -> tuple[np.ndarray, np.ndarray, tuple[int, int]]:
    """Return (size, size, 3) rgb and (size, size) depth of the image's middle, and the crop's corner."""
    height, width = image.depth.shape
    ox, oy = (width - size) // 2, (height - size) // 2
    rgb = image.rgb[max(oy, 0) : max(oy, 0) + size, max(ox, 0) : max(ox, 0) + size]
    depth = image.depth[max(oy, 0) : max(oy, 0) + size, max(ox, 0) : max(ox, 0) + size]
    if ox < 0 or oy < 0:
        before = (max(-oy, 0), max(-ox, 0))
        pad = [(b, size - b - n) for b, n in zip(before, depth.shape, strict=True)]
        rgb = np.pad(rgb, [*pad, (0, 0)], mode="edge")
        depth = np.pad(depth, pad)
    return rgb, depth, (ox, oy)


def _at(allowed: NDArray[np.bool_], grasp: Grasp) -> bool:
    """Return whether a grasp's centre is at a pixel that is allowed."""
    row, column = int(grasp.y), int(grasp.x)
    inside = 0 <= row < allowed.shape[0] and 0 <= column < allowed.shape[1]
    return inside and bool(allowed[row, column])
