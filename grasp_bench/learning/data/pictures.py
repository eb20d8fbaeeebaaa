"""Pictures of training scenes with their labels."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from grasp_bench.errors import AssetError
from grasp_bench.grasps import Grasp, wrap_angle
from grasp_bench.learning.data.opening import open_collection
from grasp_bench.learning.data.real import RealScenes
from grasp_bench.learning.data.scenes import Scene, is_generated, load_scene, read_index, unpacked
from grasp_bench.networks.encoding import encode_depth
from grasp_bench.system.files import prepare_picture
from grasp_bench.system.integrity import write_whole

CROP = 224
"""Side of the network's input for which real images are framed [px]."""


def sample_sheet(folder: Path, count: int, out: Path) -> list[str]:
    """Draw ``count`` scenes spread over the data set in ``folder`` into a PNG, and return their names.

    Images of a Cornell or Jacquard copy are drawn as the scenes that training makes of them.

    Raises:
        AssetError: when the folder holds neither, or a scene is damaged.
    """
    if is_generated(folder):
        entries = read_index(folder)
        scenes = [load_scene(folder / entries[i]["file"]) for i in spread(len(entries), count)]
    else:
        collection = open_collection(folder, generated=True)
        scenes = list(RealScenes(collection, spread(len(collection.entries), count), CROP))
    if not scenes:
        raise AssetError(f"{folder} holds no scene yet; generate some with `grasp-bench data synth`.")
    sheet = two_a_row([_strip(scene, scene.name) for scene in scenes])
    write_picture(out, sheet)
    return [scene.name for scene in scenes]


def write_picture(path: Path, rgb: NDArray[np.uint8]) -> None:
    """Write an (H, W, 3) picture in the format of the file's ending, into a folder that is made if need be.

    Raises:
        GraspBenchError: the ending is that of no picture.
        OSError: the file cannot be written.
    """
    prepare_picture(path)
    write_whole(path, cv2.imencode(path.suffix.lower(), np.ascontiguousarray(rgb[..., ::-1]))[1].tobytes())


def two_a_row(strips: list[NDArray[np.uint8]]) -> NDArray[np.uint8]:
    """Put strips of one shape two in a row; the last row is filled up in white, one strip stays as it is."""
    if len(strips) == 1:
        return strips[0]
    if len(strips) % 2:
        strips = [*strips, np.full_like(strips[0], 255)]
    return np.vstack([np.hstack(pair) for pair in zip(strips[::2], strips[1::2], strict=True)])


def spread(number: int, count: int) -> list[int]:
    """Return up to ``count`` indices below ``number``, spread evenly."""
    if not number:
        return []
    return [int(i) for i in np.unique(np.linspace(0, number - 1, count).astype(int))]


def _strip(scene: Scene, title: str) -> NDArray[np.uint8]:
    """Draw five pictures (S, 5·S, 3) of one scene side by side: colour with the grasps that held, colour with
    them as people draw them, height as a network is shown it (holes red), quality and angle."""
    drawn = scene.rgb.copy()
    for x, y, angle, width, height, _ in scene.annotated if scene.annotated is not None else ():
        box = Grasp(float(x), float(y), wrap_angle(float(angle)), float(width)).rectangle(float(height))
        corners = np.round((box - 0.5) * 8).astype(np.int32)
        cv2.polylines(drawn, [corners], True, (255, 200, 0), 1, cv2.LINE_AA, 3)
    photo = scene.rgb.copy()
    for grasp in scene.truths():
        corners = np.round((grasp.rectangle(height=12) - 0.5) * 8).astype(np.int32)
        cv2.polylines(photo, [corners], True, (40, 220, 60), 1, cv2.LINE_AA, 3)
        for a, b in ((1, 2), (3, 0)):  # the fingers
            cv2.line(photo, corners[a].tolist(), corners[b].tolist(), (230, 30, 40), 2, cv2.LINE_AA, 3)
    cv2.putText(photo, title, (4, 14), cv2.FONT_HERSHEY_SIMPLEX, 0.45, (128, 0, 128), 1, cv2.LINE_AA)
    height = encode_depth(unpacked(scene.depth))
    grey = np.dstack([np.clip(60 + 120 * height, 0, 255).astype(np.uint8)] * 3)
    grey[scene.depth == 0] = (110, 0, 0)
    heat = cv2.applyColorMap(scene.quality, cv2.COLORMAP_INFERNO)[..., ::-1]
    hue = np.mod(scene.angle.astype(float) * 180 / np.pi, 180).astype(np.uint8)
    on = np.where(scene.quality > 12, 255, 0).astype(np.uint8)
    hues = cv2.cvtColor(np.dstack([hue, on, np.maximum(on, 40)]), cv2.COLOR_HSV2RGB)
    return np.asarray(np.hstack([photo, drawn, grey, heat, hues]), np.uint8)
