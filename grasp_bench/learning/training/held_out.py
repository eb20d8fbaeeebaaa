"""Held-out grasps tried in physics: how good a network is while it is trained.

The label metric is a poor guide: it hardly moves while trials are won. So the best grasp of held-out scenes
is carried out as predicted, at its own centre, angle and width, by the gripper without an arm, which takes
some hundredths of a second. How deep it goes is decided from the same noisy picture, as in trials. The scenes
are drawn by the generator of training data from a seed of their own, plain ones with the reference scenario's
camera, and are the same in all trainings, whatever these learn from. Some show nothing that can be held.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import nn

from grasp_bench.camera import RgbdImage
from grasp_bench.errors import GraspBenchError
from grasp_bench.grasps import Grasp
from grasp_bench.learning.data.synthetic import LAYOUTS, SynthConfig, lay_out
from grasp_bench.networks.encoding import grasps_from_output, to_input
from grasp_bench.networks.spec import Kind
from grasp_bench.planning.depth import grasp_pose
from grasp_bench.planning.heightfield import TABLE_NOISE
from grasp_bench.planning.refusals import Refused
from grasp_bench.planning.seen import SeenScene
from grasp_bench.scenario.sections import Execution
from grasp_bench.scene.brief import BriefTries
from grasp_bench.scene.floating import FloatingGripper
from grasp_bench.system.arrays import Floats

SEED = 907_210_033
"""With a third number beside it, so that no data set has these scenes."""
LEAST_PIXELS = 200
"""Pixels above the table that are seen at least."""
AS_PREDICTED = Execution(protocol="as-predicted")


@dataclass(frozen=True)
class HeldOut:
    """A scene at rest, and the picture of it.

    Attributes:
        gripper: parked beside the objects.
        rest: its state then, from which every try starts.
        image: the middle of the picture, as large as the network's input.
        seen: the same, for the planner.
    """

    gripper: FloatingGripper
    rest: tuple[Floats, Floats]
    image: RgbdImage
    seen: SeenScene

    def holds(self, grasp: Grasp) -> bool:
        """Carry out a grasp in pixels of the image."""
        gripper = self.gripper
        try:
            pose, _ = grasp_pose(
                self.seen, grasp, gripper.scenario.motion, gripper.gripper, execution=AS_PREDICTED
            )
        except Refused:
            return False
        # The jaws open along the first axis of the tool.
        yaw = math.atan2(pose.rotation[1, 0], pose.rotation[0, 0])
        gripper.data.qpos[:], gripper.data.qvel[:] = self.rest
        return BriefTries(gripper).holds(pose.position, yaw, pose.opening)


def held_out_scenes(count: int, crop: int) -> list[HeldOut]:
    """Make the first ``count`` held-out scenes, pictures of ``crop`` px (about a tenth of a second each)."""
    return list(held_out_from(0, count, crop))


def held_out_from(first: int, count: int, crop: int) -> Iterator[HeldOut]:
    """Make ``count`` held-out scenes one by one, from the one of index ``first``."""
    return (_held_out(index, crop) for index in range(first, first + count))


def _held_out(index: int, crop: int) -> HeldOut:
    rng = np.random.default_rng(np.random.SeedSequence([SEED, index, 1]))
    for _ in range(LAYOUTS):
        laid = lay_out(SynthConfig(size=crop), rng)
        if laid is None:
            continue
        image = RgbdImage(laid.shot.rgb, laid.shot.depth, laid.shot.intrinsics)
        seen = SeenScene(image, laid.shot.pose)
        if (seen.heights > TABLE_NOISE).sum() >= LEAST_PIXELS:  # objects may lie beyond the middle
            return HeldOut(laid.gripper, laid.gripper.state(), image, seen)
    raise GraspBenchError(f"held-out scene {index}: nothing came to rest in {LAYOUTS} layouts")


@torch.inference_mode()
def count_held(network: nn.Module, scenes: Sequence[HeldOut], kind: Kind) -> int:
    """Return in how many scenes the network's best grasp holds."""
    was_training = network.training
    network.eval()
    held = 0
    for scene in scenes:
        best = answered(network, scene, kind, 1)
        held += bool(best) and scene.holds(best[0])
    network.train(was_training)
    return held


def answered(network: nn.Module, scene: HeldOut, kind: Kind, count: int) -> list[Grasp]:
    """Return a network's ``count`` best grasps of a scene, in pixels of its image."""
    device = next(network.parameters()).device
    x = torch.from_numpy(to_input(scene.image.rgb, scene.image.depth, kind))[None]
    output = network(x.to(device, memory_format=torch.channels_last))[0]
    return grasps_from_output(output, count)
