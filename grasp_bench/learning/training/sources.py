"""The folders a network is trained on: synthetic scenes, Cornell, Jacquard, or a mixture."""

from __future__ import annotations

import hashlib
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path

import numpy as np

from grasp_bench.errors import GraspBenchError
from grasp_bench.learning.data.folds import make_folds
from grasp_bench.learning.data.opening import open_collection
from grasp_bench.learning.data.real import RealScenes
from grasp_bench.learning.data.rectangles import Collection
from grasp_bench.learning.data.scenes import Scene, SceneSet, StoredScenes, is_generated, load_scenes
from grasp_bench.networks.spec import Kind
from grasp_bench.runs.evaluation import Split


@dataclass(frozen=True)
class Source:
    """A folder and its share of the samples.

    Attributes:
        folder: one with synthetic scenes, or the root of a Cornell or Jacquard copy.
        weight: share of what is seen, relative to the other folders'; None for the folder's
            number of scenes, so that all scenes are seen equally often.
    """

    folder: Path
    weight: float | None = None

    @classmethod
    def parse(cls, text: str) -> Source:
        """Read ``DIR`` or ``DIR:WEIGHT``; GraspBenchError when the weight is no positive number."""
        folder, colon, weight = text.rpartition(":")
        if not colon or Path(text).exists():
            return cls(Path(text))
        try:
            value = float(weight)
        except ValueError:
            return cls(Path(text))
        if not 0 < value < float("inf"):
            raise GraspBenchError(f"--data {text}: the weight after the colon must be a positive number.")
        return cls(Path(folder), value)


class Mixture(Sequence[Scene]):
    """Scenes of several folders one after the other.

    Args:
        parts: scenes of each folder.
        weights: relative shares of what is trained on; None draws every scene equally often.

    Attributes:
        ends: where each part ends.
        shares: cumulative shares of the parts, the last is 1; None for equal frequency.
    """

    def __init__(self, parts: Sequence[Sequence[Scene]], weights: Sequence[float] | None = None) -> None:
        self._parts = [p for p in parts if len(p)]
        self.ends = list(accumulate(len(p) for p in self._parts))
        self.shares: list[float] | None = None
        if weights is not None:
            present = [w for w, p in zip(weights, parts, strict=True) if len(p)]
            self.shares = [s / sum(present) for s in accumulate(present)]

    def draw(self, rng: np.random.Generator) -> int:
        """Draw the index of a scene: of a part drawn by the shares, any of its scenes."""
        assert self.shares is not None
        part = min(bisect_right(self.shares, rng.random()), len(self.ends) - 1)
        return int(rng.integers(self.ends[part - 1] if part else 0, self.ends[part]))

    def __len__(self) -> int:
        return self.ends[-1] if self.ends else 0

    def __getitem__(self, index: int) -> Scene:
        index = range(len(self))[index]  # negative ones count from the end, others raise IndexError
        part = bisect_right(self.ends, index)
        return self._parts[part][index - (self.ends[part - 1] if part else 0)]


def mixed_with_real(
    synthetic: Sequence[Path], collection: Collection, indices: Sequence[int], real_share: float, crop: int
) -> SceneSet:
    """Mix some samples of a collection with synthetic scenes, of which ``1 - real_share`` is drawn.

    Nothing is validated on. Raises GraspBenchError unless 0 < ``real_share`` < 1 where there are
    synthetic folders.
    """
    if synthetic and not 0 < real_share < 1:
        raise GraspBenchError(f"--real-share must be between 0 and 1, not {real_share}.")
    stored = [StoredScenes.training(folder, crop) for folder in synthetic]
    total = sum(map(len, stored))
    weights = [real_share, *((1 - real_share) * len(s) / total for s in stored)] if stored else None
    names = " ".join(collection.entries[i].name for i in indices)
    digest = hashlib.sha256(f"{names} {real_share} {[f.name for f in synthetic]} {total}".encode())
    real = RealScenes(collection, indices, crop)
    return SceneSet(Mixture([real, *stored], weights), [], digest.hexdigest()[:16])


def gather(
    sources: Sequence[Source],
    crop: int,
    holdout: tuple[int, int] | None = None,
    split: Split = "object",
    seed: int = 0,
    *,
    kind: Kind,
) -> SceneSet:
    """Gather the scenes of all folders.

    Args:
        sources: folders with their shares.
        crop: side of the network's input [px].
        holdout: (fold from 0, folds) of the real images that are left out of the training; they
            are validated on, which chooses nothing.
        kind: what the network is shown.
        split, seed: how folds are made, see :func:`grasp_bench.learning.data.folds.make_folds`.

    Raises:
        AssetError: when a folder holds nothing usable, or no depth for an input of ``kind``.
        GraspBenchError: when there are fewer images or objects than folds, or nothing to hold out.
    """
    if len({s.weight is None for s in sources}) > 1:
        raise GraspBenchError("Give either all --data folders a weight (DIR:WEIGHT) or none.")
    if all(is_generated(s.folder) or not s.folder.is_dir() for s in sources):
        if holdout is not None:
            raise GraspBenchError(
                "--holdout leaves out real images, but no Cornell or Jacquard folder is among the data."
            )
        if all(s.weight is None for s in sources):
            return load_scenes([s.folder for s in sources], crop)
    train: list[Sequence[Scene]] = []
    val: list[Sequence[Scene]] = []
    notes: list[str] = []
    digest = hashlib.sha256(f"{holdout} {split} {seed}".encode())
    for source in sources:
        if is_generated(source.folder):
            scenes = load_scenes([source.folder], crop)
            train.append(scenes.train)
            val.append(scenes.val)
            digest.update(scenes.fingerprint.encode())
        else:
            collection = open_collection(source.folder, generated=True)
            collection.require(kind, "The network")
            if collection.missing or collection.notes:
                notes.append(collection.describe())
            chosen, tested = list(range(len(collection.entries))), []
            if holdout is not None:
                folds = make_folds([e.object for e in collection.entries], holdout[1], split, seed)
                chosen, tested = folds.train(holdout[0]), folds.test[holdout[0]]
            train.append(RealScenes(collection, chosen, crop))
            val.append(RealScenes(collection, tested, crop))
            digest.update("".join(f"{collection.entries[i].name}\n" for i in chosen).encode())
        digest.update(f"{source.weight}".encode())
    weights = [s.weight for s in sources if s.weight is not None]
    return SceneSet(Mixture(train, weights or None), Mixture(val), digest.hexdigest()[:16], tuple(notes))
