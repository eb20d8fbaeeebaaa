"""Synthetic scenes in Jacquard's file layout, for other people's trainers.

A folder a scene with ``0_ID_RGB.png``, ``0_ID_perfect_depth.tiff`` (without noise),
``0_ID_stereo_depth.tiff`` (what the noisy sensor saw, −1 where it saw nothing), ``0_ID_mask.png``
and ``0_ID_grasps.txt`` (the grasps that held in physics). The lossless scenes remain what
`grasp-bench train` reads: here, analysis and refuted grasps are left out and images are resized.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from grasp_bench.errors import AssetError, GraspBenchError
from grasp_bench.grasps import Grasp
from grasp_bench.learning.data.jacquard import row_from_grasp
from grasp_bench.learning.data.scenes import load_scene, read_index, unpacked
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.system.arrays import Floats

SIZE = 1024
"""Side of Jacquard's images; trainers of the GG-CNN lineage take it for granted [px]."""
ON_TABLE = 0.002
"""What is less high is table [m]."""


def export_jacquard(folder: Path, out: Path, size: int = SIZE, limit: int | None = None) -> tuple[int, int]:
    """Write the scenes of ``folder`` that have grasps into ``out``.

    Args:
        folder: data set made by `grasp-bench data synth`.
        out: folder to make or to add to; finished scenes there are kept.
        size: side of the images [px].
        limit: greatest number of scenes written; None for all.

    Returns:
        scenes in ``out`` after all, and scenes left out because nothing held in them.

    Raises:
        AssetError: when the folder's index or a scene is missing or damaged.
        GraspBenchError: when ``out`` cannot be written.
    """
    written = empty = 0
    for entry in read_index(folder):
        if written == limit:
            break
        name = Path(entry["file"]).stem
        target = out / name
        done = (target / f"0_{name}_grasps.txt").is_file()
        if done or _export(folder / entry["file"], target, name, size):
            written += 1
        else:
            empty += 1
    return written, empty


def _export(path: Path, target: Path, name: str, size: int) -> bool:
    scene = load_scene(path)
    if not len(scene.grasps):
        return False
    try:
        with np.load(path, allow_pickle=False) as file:
            true = unpacked(file["depth_true"])
            focal, rotation, position = file["intrinsics"], file["camera_rotation"], file["camera_position"]
    except (KeyError, ValueError) as error:
        raise AssetError(f"Scene {path} lacks what an export needs ({error}); generate it again.") from error
    scale = size / scene.size
    sensed = unpacked(scene.depth)
    mask = np.where(heights(true, focal, rotation, position) > ON_TABLE, 255, 0).astype(np.uint8)
    rows = []
    for g in scene.truths():
        r, c = (int(np.clip(v, 0, scene.size - 1)) for v in (g.y, g.x))
        rows.append(
            row_from_grasp(
                Grasp(g.x * scale, g.y * scale, g.angle, g.width * scale),
                scale * PARALLEL_85.finger_width * float(focal[0]) / max(float(true[r, c]), 1e-3),
            )
        )
    prefix = f"{target}/0_{name}_"
    square = (size, size)
    nearest = cv2.INTER_NEAREST_EXACT
    try:
        target.mkdir(parents=True, exist_ok=True)
        files = {
            "RGB.png": cv2.resize(scene.rgb, square, interpolation=cv2.INTER_LINEAR)[..., ::-1],
            "perfect_depth.tiff": cv2.resize(true, square, interpolation=nearest),
            "stereo_depth.tiff": cv2.resize(
                np.where(sensed > 0, sensed, np.float32(-1)), square, interpolation=nearest
            ),
            "mask.png": cv2.resize(mask, square, interpolation=nearest),
        }
        for ending, image in files.items():
            if not cv2.imwrite(prefix + ending, image):
                raise OSError(f"{prefix + ending} was refused")
        Path(prefix + "grasps.txt").write_text("\n".join(rows) + "\n")  # last: its presence says "finished"
    except (OSError, cv2.error) as error:
        raise GraspBenchError(f"{target} cannot be written ({error}).") from error
    return True


def heights(depth: NDArray[np.float32], intrinsics: Floats, rotation: Floats, position: Floats) -> Floats:
    """Return the (S, S) height above the table [m] of what each pixel sees.

    Args:
        depth: (S, S) z-depth [m].
        intrinsics: fx, fy, cx, cy [px].
        rotation, position: of the camera in the world; columns of the rotation are camera axes.
    """
    fx, fy, cx, cy = intrinsics
    v, u = np.indices(depth.shape) + 0.5
    rays = np.stack([(u - cx) / fx, (v - cy) / fy, np.ones_like(u)], axis=-1)
    return position[2] + depth * (rays @ rotation[2])
