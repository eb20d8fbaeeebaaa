"""How good the best predicted grasp of held-out scenes is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from torch import nn

from grasp_bench.grasps import Grasp, GraspMaps, angle_difference, is_correct
from grasp_bench.learning.data.scenes import Scene
from grasp_bench.learning.training.augment import View, crop_scene
from grasp_bench.learning.training.held_out import HeldOut, count_held
from grasp_bench.networks.encoding import grasps_from_output, to_input
from grasp_bench.networks.spec import Kind


@dataclass(frozen=True)
class Accuracy:
    """Counts of scenes. Scenes whose crop has nothing to grasp are in neither total.

    Attributes:
        hits, scenes: best grasps that agree with the label maps (``is_hit``), of how many.
        correct, labelled: best grasps right by the rectangle metric, of how many scenes with
            listed grasps.
        held, tried: best grasps that held in physics, of how many held-out scenes.
    """

    hits: int = 0
    scenes: int = 0
    correct: int = 0
    labelled: int = 0
    held: int = 0
    tried: int = 0

    def __str__(self) -> str:
        told = f"top-1 {self.hits}/{self.scenes}, rectangle metric {self.correct}/{self.labelled}"
        return f"{told}, held {self.held}/{self.tried}" if self.tried else told


@dataclass(frozen=True)
class Judge:
    """Validates a network again and again.

    Attributes:
        scenes: judged by their labels.
        held_out: judged in physics.
        kind, crop: what the network is shown.
    """

    scenes: Sequence[Scene]
    held_out: Sequence[HeldOut]
    kind: Kind
    crop: int

    def __call__(self, network: nn.Module) -> Accuracy:
        """Judge the best grasps of a network."""
        accuracy = validate(network, self.scenes, self.kind, self.crop)
        held = count_held(network, self.held_out, self.kind)
        return replace(accuracy, held=held, tried=len(self.held_out))


def evenly(scenes: Sequence[Scene], most: int) -> Sequence[Scene]:
    """Return ``most`` scenes, evenly chosen; all where there are no more, or ``most`` is 0."""
    if not 0 < most < len(scenes):
        return scenes
    return [scenes[i * len(scenes) // most] for i in range(most)]


def is_hit(
    grasp: Grasp,
    labels: GraspMaps,
    *,
    quality: float = 0.5,
    angle: float = math.radians(20),
    width: float = 0.8,
) -> bool:
    """Tell whether a grasp agrees with the label at its pixel.

    The best label of the 3×3 neighbourhood must have at least ``quality``; the grasp must lie
    within ``angle`` [rad] of it and open at least ``width`` times as wide.
    """
    h, w = labels.quality.shape
    r, c = int(np.clip(grasp.y, 0, h - 1)), int(np.clip(grasp.x, 0, w - 1))
    rows, columns = slice(max(r - 1, 0), r + 2), slice(max(c - 1, 0), c + 2)
    near = labels.quality[rows, columns]
    i, j = np.unravel_index(near.argmax(), near.shape)
    at = (rows.start + i, columns.start + j)
    return bool(
        near.max() >= quality
        and angle_difference(grasp.angle, float(labels.angle[at])) <= angle
        and grasp.width >= width * labels.width[at]
    )


@torch.inference_mode()
def validate(network: nn.Module, scenes: Sequence[Scene], kind: Kind, crop: int = 224) -> Accuracy:
    """Judge the best grasp of the centre crop of each scene, without augmentation, by its labels."""
    was_training = network.training
    network.eval()
    device = next(network.parameters()).device
    hits = graspable = correct = labelled = 0
    for scene in scenes:
        rgb, depth, labels = crop_scene(scene, View(), crop)
        x = torch.from_numpy(to_input(rgb, depth, kind))[None]
        best = grasps_from_output(network(x.to(device, memory_format=torch.channels_last))[0], 1)
        truths = [View().grasp(g, scene.size, crop) for g in scene.truths()]
        truths = [g for g in truths if 0 <= g.x < crop and 0 <= g.y < crop]
        if labels.quality.max() >= 0.5:
            graspable += 1
            hits += bool(best) and is_hit(best[0], labels)
        if truths:
            labelled += 1
            correct += bool(best) and is_correct(best[0], truths)
    network.train(was_training)
    return Accuracy(hits, graspable, correct, labelled)
