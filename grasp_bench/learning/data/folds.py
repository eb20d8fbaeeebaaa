"""Which samples are held out: image-wise at random, object-wise by objects or contiguous blocks."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from grasp_bench.errors import GraspBenchError
from grasp_bench.runs.evaluation import Split


@dataclass(frozen=True)
class Folds:
    """Test sets that together hold every sample once.

    Attributes:
        test: indices of each fold's test samples, ascending.
        how: a sentence on how they were made.
    """

    test: list[list[int]]
    how: str

    def train(self, fold: int) -> list[int]:
        """Return the indices of all samples that are not in the ``fold``-th (from 0) test set."""
        return sorted(i for k, part in enumerate(self.test) if k != fold for i in part)


def make_folds(objects: Sequence[str | None], count: int, split: Split, seed: int = 0) -> Folds:
    """Part samples into ``count`` test sets.

    Args:
        objects: what each sample shows, in the collection's order; None where it is unknown.
        count: number of test sets.
        split: 'image' parts at random, so that other views of a test object may be trained on.
            'object' keeps all views of an object together where every object is known;
            otherwise it makes contiguous blocks of the sorted samples, in which an object can be
            on both sides only where two blocks meet.
        seed: makes the random order of images or objects.

    Raises:
        GraspBenchError: when there are fewer samples or objects than folds.
    """
    known = all(o is not None for o in objects)
    groups = sorted({str(o) for o in objects}) if split == "object" and known else None
    if not 1 <= count <= len(groups or objects):
        raise GraspBenchError(
            f"{count} folds cannot be made of {len(groups or objects)} "
            f"{'objects' if groups else 'images'}; give --folds from 1 to "
            f"{len(groups or objects)}."
        )
    if split == "image":
        parts = np.array_split(np.random.default_rng(seed).permutation(len(objects)), count)
        how = f"{count} folds of images at random (seed {seed})"
    elif groups is None:
        parts = np.array_split(np.arange(len(objects)), count)
        how = (
            f"{count} contiguous blocks of the images in order, since this copy has no object ids: an "
            f"object whose views lie across a border is in two blocks"
        )
    else:
        shuffled = np.random.default_rng(seed).permutation(groups)
        sizes = {g: sum(o == g for o in objects) for g in groups}
        chosen: list[list[str]] = [[] for _ in range(count)]
        for group in sorted(shuffled, key=lambda g: -sizes[g]):  # to the fold with the fewest images
            min(chosen, key=lambda c: (sum(sizes[g] for g in c), len(c))).append(group)
        parts = [[i for i, o in enumerate(objects) if o in set(c)] for c in chosen]
        how = f"{count} folds of whole objects, {len(groups)} in all (seed {seed})"
    return Folds([sorted(int(i) for i in part) for part in parts], how)


def parse_holdout(text: str) -> tuple[int, int]:
    """Read '2/5' as (1, 5): index from 0 of the fold left out, and how many folds there are.

    Raises:
        GraspBenchError: for anything else.
    """
    found = re.fullmatch(r"(\d+)/(\d+)", text.strip())
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        raise GraspBenchError(f"--holdout takes FOLD/FOLDS with FOLD from 1, such as 2/5, not {text!r}.")
    return int(found[1]) - 1, int(found[2])
