"""Zhang et al., ROI-based Robotic Grasp Detection for Object Overlapping Scenes (IROS 2019): ROI-GD.

    input (B, 3, S, S) → doubled → ResNet-101 to stride 16 → proposals of objects
      → regions of 7×7 → three bottlenecks → oriented anchors in each region's 7×7 cells

Certain, from the group's code: trunk, proposals, 35,891,858 weights without the branch that names objects;
k = 4 anchors, whose cells are the region's; matching within the region; hard negatives; offsets in units of
0.4; the grasp losses count 0.2 beside the proposals'. A region's score is the proposal's.
Ours: 448 px instead of 800; anchors of 48 px of the doubled picture instead of 12, which are far from any
grasp here; norms learn, as there are no ImageNet weights. Objects are labelled by nothing but their grasps:
an object's box is that of the grasps that lie within 40 px of each other, which joins objects that touch.
"""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn
from torch.nn import functional

from grasp_bench.networks.boxes import aligned, overlaps
from grasp_bench.networks.fcgn import listed, start_heads
from grasp_bench.networks.oriented import Oriented, cell_middles
from grasp_bench.networks.proposals import Proposals, pick, with_wanted
from grasp_bench.networks.resnet import RESNET_101, Trunk, stage, start_kaiming
from grasp_bench.networks.rows import NONE, Detector

ENLARGED = 2
SCALES = (64.0, 128.0, 256.0)
CELLS = 7
SIZE = 48.0
ANCHORS = Oriented(4, (0.4, 0.4, 0.4, 0.4, 0.4))
REGIONS = 16
GRASP_WEIGHT = 0.2
TOGETHER = 40.0
"""Grasps with a chain of others between them that are nearer than this [px] are one object's."""


def objects(rows: Tensor) -> tuple[Tensor, Tensor]:
    """Return an object's box (B, M, 4) for each label (B, M, 6), and which of them are to be wanted (B, M):
    that of each object's first label."""
    there = rows[..., 5] > 0
    both = there[:, :, None] & there[:, None, :]
    joined = ((rows[:, :, None, :2] - rows[:, None, :, :2]).norm(dim=-1) < TOGETHER) & both
    reach = joined.float()
    for _ in range(max(rows.shape[1] - 1, 1).bit_length()):
        reach = ((reach @ reach) > 0).float()
    half = torch.stack(
        [
            rows[..., 3] * rows[..., 2].cos().abs() + rows[..., 4] * rows[..., 2].sin().abs(),
            rows[..., 3] * rows[..., 2].sin().abs() + rows[..., 4] * rows[..., 2].cos().abs(),
        ],
        dim=-1,
    )
    low, high = rows[..., :2] - half / 2, rows[..., :2] + half / 2
    apart = reach[..., None] == 0
    corner = low[:, None].masked_fill(apart, torch.inf).amin(2)
    opposite = high[:, None].masked_fill(apart, -torch.inf).amax(2)
    boxes = torch.cat([corner, opposite], dim=-1).masked_fill(~there[..., None], 0.0)
    return boxes, there & (reach.argmax(2) == torch.arange(rows.shape[1], device=rows.device))


class RoiGD(Detector):
    """35,891,858 parameters.

    Args:
        inputs: number of channels of the image.
        blocks, width: of the trunk, three stages.
        regions: proposals whose grasps are looked at, in use.
    """

    def __init__(
        self, inputs: int = 3, blocks: Sequence[int] = RESNET_101[:3], width: int = 64, regions: int = 20
    ) -> None:
        super().__init__()
        channels = 16 * width
        self.trunk = Trunk(inputs, blocks, width=width)
        self.proposals = Proposals(channels, 16, SCALES, before=(600, 300), after=(40, regions))
        self.body = stage(channels, channels // 4, 3, 1)
        start_kaiming(self.body)
        self.offset = nn.Conv2d(channels, 5 * ANCHORS.number, 3, padding=1)
        self.score = nn.Conv2d(channels, 2 * ANCHORS.number, 3, padding=1)
        start_heads(self.score, self.offset)

    def features(self, x: Tensor) -> Tensor:
        """Map (B, C, S, S) to the trunk's features of the enlarged picture."""
        large = functional.interpolate(x, scale_factor=ENLARGED, mode="bilinear", align_corners=False)
        return self.trunk(large)[-1]

    def in_regions(self, features: Tensor, boxes: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Return logits (R, N, 2), offsets, anchors (R, N, 5) and cells (R, 1, 1, 2) of boxes (B, K, 4),
        R = B · K."""
        found = self.body(aligned(features, boxes, 16, CELLS).flatten(0, 1).to(features.dtype))
        flat = boxes.flatten(0, 1)
        cell = (flat[:, 2:] - flat[:, :2])[:, None] / CELLS
        centres = flat[:, None, :2] + cell * cell_middles(CELLS, CELLS, boxes.device)
        return (
            listed(self.score(found), 2),
            listed(self.offset(found), 5),
            ANCHORS.anchors(centres, SIZE),
            cell[:, None],
        )

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C, S, S) to rows (B, regions, 6): of each region the best grasp."""
        features = self.features(x)
        side = ENLARGED * x.shape[2], ENLARGED * x.shape[3]
        boxes, objectness = self.proposals.propose(self.proposals(features), side)
        logits, offsets, anchors, _ = self.in_regions(features, boxes)
        score, best = logits.softmax(-1)[..., 1].max(1)
        one = torch.arange(len(best), device=x.device)
        rows = ANCHORS.decode(anchors[one, best], offsets[one, best], score * objectness.flatten())
        rows = torch.cat([rows[:, :2] / ENLARGED, rows[:, 2:3], rows[:, 3:5] / ENLARGED, rows[:, 5:]], dim=1)
        return rows.view(*boxes.shape[:2], 6)

    def loss(self, inputs: Tensor, targets: Tensor) -> dict[str, Tensor]:
        """Return the proposals' losses and those of anchors in regions that overlap an object by half."""
        features = self.features(inputs)
        rows = targets * targets.new_tensor([ENLARGED, ENLARGED, 1, ENLARGED, ENLARGED, 1])
        boxes, first = objects(targets)
        boxes = ENLARGED * boxes
        found = self.proposals(features)
        objectness, edges = self.proposals.loss(found, boxes, first)
        side = ENLARGED * inputs.shape[2], ENLARGED * inputs.shape[3]
        proposed = with_wanted(self.proposals.propose(found, side)[0], boxes, first)
        shared = overlaps(proposed, boxes).masked_fill(~first[:, None], 0.0)
        best, which = shared.max(2)
        chosen = pick(best >= 0.5, REGIONS).float().topk(REGIONS, dim=1)[1]
        best, which = best.gather(1, chosen), which.gather(1, chosen)
        regions = proposed.gather(1, chosen[..., None].expand(-1, -1, 4))
        # Of each region, the labels of its own object; none where it overlaps no object by half.
        own = (boxes.gather(1, which[..., None].expand(-1, -1, 4))[:, :, None] == boxes[:, None]).all(-1)
        labels = rows[:, None].expand(-1, REGIONS, -1, -1).clone()
        labels[..., 5] = torch.where(own & (best >= 0.5)[..., None], labels[..., 5], NONE)
        logits, offsets, anchors, cell = self.in_regions(features, regions)
        entropy, shift = ANCHORS.loss(logits, offsets, anchors, cell, labels.flatten(0, 1))
        return {
            "loss": objectness + edges + GRASP_WEIGHT * (entropy + shift),
            "proposal": objectness,
            "proposal_box": edges,
            "score": entropy,
            "offset": shift,
        }
