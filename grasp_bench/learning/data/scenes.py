"""Folders of synthetic scenes.

A folder has ``index.jsonl``, one scene a line: {"scene": "000123",
"file": "scenes/000123.npz", "split": "train" | "val", …}. Each npz holds, for S×S pixels:

    rgb         uint8   (S, S, 3)
    depth       uint16  (S, S)    0.1 mm, 0 = invalid: what the noisy sensor saw
    quality     uint8   (S, S)    0..255 = chance of success of the best grasp centred here
    angle       float16 (S, S)    of that grasp [rad], convention of ``grasp_bench.grasps``
    width       float16 (S, S)    of that grasp [px]
    grasps      float32 (N, 5)    good ones: x, y [px], angle [rad], width [px], quality

and may hold

    annotated   float32 (K, 6)    x, y [px], angle [rad], width, height [px], quality: as people draw grasps
    tried       float32 (M, 6)    x, y [px], angle [rad], width [px], quality, whether it held in physics

and more, such as ``depth_true``, which is not read.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from grasp_bench.errors import AssetError
from grasp_bench.grasps import Grasp, wrap_angle

INDEX = "index.jsonl"
DEPTH_UNIT = 1e-4
"""Metres per step of the stored depth."""
IN_MEMORY = 3000
"""Scenes that are held in memory at most, a megabyte each."""

_ARRAYS = {
    "rgb": np.uint8,
    "depth": np.uint16,
    "quality": np.uint8,
    "angle": np.float16,
    "width": np.float16,
    "grasps": np.float32,
}


def packed(depth: NDArray[np.floating]) -> NDArray[np.uint16]:
    """Turn metres into steps of :data:`DEPTH_UNIT`."""
    return np.clip(np.rint(depth / DEPTH_UNIT), 0, 65535).astype(np.uint16)


def unpacked(depth: NDArray[np.uint16]) -> NDArray[np.float32]:
    """Turn steps of :data:`DEPTH_UNIT` into metres."""
    return depth.astype(np.float32) * np.float32(DEPTH_UNIT)


@dataclass(frozen=True)
class Scene:
    """One scene as stored; the arrays are those listed at the top of this module, None what it lacks.

    ``tried`` is empty where nothing was tried.
    """

    name: str
    rgb: NDArray[np.uint8]
    depth: NDArray[np.uint16]
    quality: NDArray[np.uint8]
    angle: NDArray[np.float16]
    width: NDArray[np.float16]
    grasps: NDArray[np.float32]
    annotated: NDArray[np.float32] | None = None
    tried: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 6), np.float32))

    @property
    def size(self) -> int:
        """Side S in pixels."""
        return self.depth.shape[0]

    def truths(self) -> list[Grasp]:
        """Return the good grasps, in pixels of the scene."""
        return [_grasp(row) for row in self.grasps]

    def tries(self) -> list[tuple[Grasp, bool]]:
        """Return the grasps tried in physics, in pixels of the scene, and whether each held."""
        return [(_grasp(row), bool(row[5])) for row in self.tried]


def _grasp(row: NDArray[np.float32]) -> Grasp:
    x, y, angle, width, quality = (float(v) for v in row[:5])
    return Grasp(x, y, wrap_angle(angle), width, quality)


@dataclass(frozen=True)
class SceneSet:
    """Scenes to train on and to validate on.

    Attributes:
        train, val: scenes in order of the index.
        fingerprint: changes whenever a scene is added, dropped or moved to another split.
        notes: what of the folders could not be used, in sentences.
    """

    train: Sequence[Scene]
    val: Sequence[Scene]
    fingerprint: str
    notes: tuple[str, ...] = ()


class StoredScenes(Sequence[Scene]):
    """Scenes that are read when they are needed, in 3 ms each.

    Args:
        files: the scenes' npz.
        crop: side that they have at least [px].
    """

    def __init__(self, files: Sequence[Path], crop: int) -> None:
        self._files, self._crop = files, crop

    @classmethod
    def training(cls, folder: Path, crop: int) -> Self:
        """Return the scenes of split 'train' in a folder."""
        return cls([folder / e["file"] for e in read_index(folder) if e["split"] == "train"], crop)

    def __len__(self) -> int:
        return len(self._files)

    def __getitem__(self, index: int) -> Scene:
        return load_scene(self._files[index], self._crop)


def load_scenes(folders: Iterable[Path], crop: int = 224) -> SceneSet:
    """Gather all scenes of some folders: up to :data:`IN_MEMORY` are read at once, of more each when needed.

    Raises:
        AssetError: naming the file, when one is missing, or one that was read truncated or not as described
            above.
    """
    split: dict[str, list[Path]] = {"train": [], "val": []}
    digest = hashlib.sha256()
    for folder in map(Path, folders):
        for entry in read_index(folder):
            split[entry["split"]].append(folder / entry["file"])
            digest.update(f"{entry['file']} {entry['split']}\n".encode())
    if not split["train"]:
        raise AssetError("The data folders given hold no scene of split 'train'; generate some first.")
    train, val = (StoredScenes(files, crop) for files in split.values())
    if len(train) + len(val) > IN_MEMORY:
        for path in (*split["train"], *split["val"]):
            _present(path)
        return SceneSet(train, val, digest.hexdigest()[:16])
    return SceneSet(list(train), list(val), digest.hexdigest()[:16])


def load_scene(path: Path, crop: int = 0) -> Scene:
    """Read one npz; AssetError when it is not what it should be or smaller than ``crop``."""
    _present(path)
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in _ARRAYS}
            annotated = file.get("annotated")
            if "tried" in file:
                arrays["tried"] = np.asarray(file["tried"], np.float32).reshape(-1, 6)
    except Exception as error:  # damaged archives raise nearly anything, even tokenizer errors
        raise AssetError(
            f"Scene {path} is truncated or lacks an array ({type(error).__name__}: {error}); "
            f"delete it and generate it again."
        ) from error
    _check(path, arrays, crop)
    if annotated is not None and (annotated.ndim != 2 or annotated.shape[1] != 6):
        raise AssetError(f"Scene {path}: annotated must be (K, 6), is {annotated.shape}; generate it again.")
    return Scene(path.stem, **arrays, annotated=annotated)


def _present(path: Path) -> None:
    if not path.is_file():
        raise AssetError(f"Scene {path} is missing though its index lists it; generate the data again.")


def _check(path: Path, arrays: dict[str, NDArray], crop: int) -> None:
    size = arrays["depth"].shape[0] if arrays["depth"].ndim else 0
    shapes = {"rgb": (size, size, 3), "grasps": (len(arrays["grasps"]) if arrays["grasps"].ndim else 0, 5)}
    for name, dtype in _ARRAYS.items():
        array, shape = arrays[name], shapes.get(name, (size, size))
        if array.dtype != dtype or array.shape != shape:
            raise AssetError(
                f"Scene {path}: {name} must be {np.dtype(dtype)} {shape}, is {array.dtype} "
                f"{array.shape}; generate it again."
            )
        if array.dtype.kind == "f" and not np.isfinite(array).all():
            raise AssetError(f"Scene {path}: {name} has values that are not finite; generate it again.")
    if size < max(crop, 1):
        raise AssetError(
            f"Scene {path} has {size} px a side, but the network needs {crop}; render it larger."
        )


def is_generated(folder: Path) -> bool:
    """Tell whether a folder holds generated scenes, and is no copy of Cornell or Jacquard."""
    return (folder / INDEX).is_file()


def read_index(folder: Path) -> list[dict[str, str]]:
    """Read the entries of a folder's index; AssetError names the line that is damaged."""
    path = folder / INDEX
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise AssetError(
            f"Index {path} cannot be read ({error}); give a folder of generated scenes."
        ) from error
    entries = []
    for number, line in enumerate(lines, 1):
        if not line.strip():
            continue
        try:
            entry = json.loads(line)
            file, split = entry["file"], entry["split"]
        except (ValueError, TypeError, KeyError) as error:
            raise AssetError(
                f"{path}, line {number}: not a JSON object with 'file' and 'split' ({error!r}); "
                f"delete the line or generate the data again."
            ) from error
        if split not in ("train", "val") or not isinstance(file, str) or _leaves(file):
            raise AssetError(
                f"{path}, line {number}: 'split' must be train or val and 'file' a path inside "
                f"the folder, got {split!r} and {file!r}."
            )
        entries.append(entry)
    return entries


def _leaves(file: str) -> bool:
    return Path(file).is_absolute() or ".." in Path(file).parts
