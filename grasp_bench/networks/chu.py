"""Chu, Xu & Vela, Real-World Multiobject, Multigrasp Detection (RA-L 3(4), 2018): Faster R-CNN whose classes
are orientations.

    input (B, 3, S, S), red, green and depth → doubled → ResNet-50 to stride 16: (B, 1024, S/8, S/8)
      → proposals on boxes of a grasp's own width and height, not turned
      → regions of 7×7 → the trunk's last stage → mean → 20 classes and 20·4 offsets

Certain, from the authors' code: the network, 28,459,738 weights with norms; classes of 10° from −90° to 90°
and one for "no grasp", which competes with all of them; four losses of weight 1, offsets in units of
(0.1, 0.1, 0.2, 0.2); a class's own offsets, suppression at 0.3 within a class. Their scripts draw grasps in
steps of 9°, here they are in the labels' steps of 10°. Classes 1 and 19 are the same direction; here labels
of 19 are 1.
Ours, as there are no ImageNet weights: everything learns; 224 px become 448 instead of 600; anchors are 32,
64 and 128 px of the doubled picture, as grasps are smaller here. For CPUs, 16 regions
of an image are drawn in training instead of 256, and the best 32 proposals are looked at in use instead of
300: most of the work is the head's, which is done for each region.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import torch
from torch import Tensor, nn
from torch.nn import functional

from grasp_bench.networks.boxes import aligned, box_offsets, moved, overlaps, suppressed
from grasp_bench.networks.proposals import Proposals, pick, with_wanted
from grasp_bench.networks.resnet import RESNET_50, Trunk, stage, start_kaiming
from grasp_bench.networks.rows import Detector

CLASSES = 19
STEP = math.radians(10)
ENLARGED = 2
SCALES = (32.0, 64.0, 128.0)
UNITS = (0.1, 0.1, 0.2, 0.2)
LEAST_SCORE, OVERLAP, MOST = 0.02, 0.3, 100


def orientation(angle: Tensor) -> Tensor:
    """Return the class 1 … 18 of jaw directions [rad]."""
    c = ((angle + math.pi / 2) / STEP).round().long() + 1
    return torch.where(c == CLASSES, 1, c)


def upright(rows: Tensor) -> Tensor:
    """Return boxes (…, 4) of a grasp's width and height about its centre, not turned."""
    half = rows[..., 3:5] / 2
    return torch.cat([rows[..., :2] - half, rows[..., :2] + half], dim=-1)


class Chu(Detector):
    """28,459,738 parameters.

    Args:
        inputs: number of channels of the image.
        blocks, width: of the trunk, the last of whose four stages is the head.
        regions: drawn of each image, a quarter of them with a grasp where there are as many.
    """

    def __init__(
        self, inputs: int = 3, blocks: Sequence[int] = RESNET_50, width: int = 64, regions: int = 16
    ) -> None:
        super().__init__()
        self.regions = regions
        self.trunk = Trunk(inputs, blocks[:3], width=width)
        self.proposals = Proposals(16 * width, 16, SCALES, after=(200, 32))
        self.head = stage(16 * width, 8 * width, blocks[3], 1)
        start_kaiming(self.head)
        self.classify = nn.Linear(32 * width, CLASSES + 1)
        self.refine = nn.Linear(32 * width, 4 * (CLASSES + 1))
        nn.init.normal_(self.classify.weight, std=0.01)
        nn.init.normal_(self.refine.weight, std=0.001)
        nn.init.zeros_(self.classify.bias)
        nn.init.zeros_(self.refine.bias)

    def features(self, x: Tensor) -> Tensor:
        """Map (B, C, S, S) to the trunk's features of the enlarged picture."""
        large = functional.interpolate(x, scale_factor=ENLARGED, mode="bilinear", align_corners=False)
        return self.trunk(large)[-1]

    def judged(self, features: Tensor, boxes: Tensor) -> tuple[Tensor, Tensor]:
        """Return logits (B, K, 20) and offsets (B, K, 20, 4) of regions (B, K, 4)."""
        b, k = boxes.shape[:2]
        found = self.head(aligned(features, boxes, 16).flatten(0, 1).to(features.dtype)).mean((2, 3))
        logits, offsets = self.classify(found).float(), self.refine(found).float()
        return logits.view(b, k, -1), offsets.view(b, k, -1, 4)

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C, S, S) to rows (B, 100, 6)."""
        features = self.features(x)
        side = ENLARGED * x.shape[2], ENLARGED * x.shape[3]
        proposed, objectness = self.proposals.propose(self.proposals(features), side)
        logits, offsets = self.judged(features, proposed)
        scores = logits.softmax(-1)[..., 1:] * (objectness > 0)[..., None]
        boxes = moved(proposed[..., None, :], offsets[..., 1:, :] * offsets.new_tensor(UNITS))
        rows = boxes.new_zeros(len(x), MOST, 6)
        for b in range(len(x)):
            self._fill(rows[b], boxes[b], scores[b])
        return rows

    @staticmethod
    def _fill(rows: Tensor, boxes: Tensor, scores: Tensor) -> None:
        found = []
        for c in range(CLASSES):
            likely = (scores[:, c] > LEAST_SCORE).nonzero()[:, 0]
            kept = likely[suppressed(boxes[likely, c], scores[likely, c], OVERLAP, MOST)]
            box = boxes[kept, c] / ENLARGED
            angle = box.new_full((len(box), 1), STEP * c - math.pi / 2)
            middle, side = (box[:, :2] + box[:, 2:]) / 2, box[:, 2:] - box[:, :2]
            found.append(torch.cat([middle, angle, side, scores[kept, c, None]], dim=1))
        table = torch.cat(found)
        table = table[table[:, 5].argsort(descending=True)[:MOST]]
        rows[: len(table)] = table

    def loss(self, inputs: Tensor, targets: Tensor) -> dict[str, Tensor]:
        """Return both stages' cross-entropy and smooth L1."""
        features = self.features(inputs)
        wanted, there = ENLARGED * upright(targets), targets[..., 5] > 0
        first = self.proposals(features)
        objectness, boxes = self.proposals.loss(first, wanted, there)
        side = ENLARGED * inputs.shape[2], ENLARGED * inputs.shape[3]
        proposed = with_wanted(self.proposals.propose(first, side)[0], wanted, there)
        shared = overlaps(proposed, wanted).masked_fill(~there[:, None], 0.0)
        best, which = shared.max(2)
        positive = pick(best >= 0.5, self.regions // 4)
        chosen = positive | pick(best < 0.5, self.regions - positive.sum(1))
        index = chosen.float().topk(self.regions, dim=1)[1]

        def of_chosen(values: Tensor) -> Tensor:
            return values.gather(1, index if values.ndim == 2 else index[..., None].expand(-1, -1, 4))

        regions, positive, which = of_chosen(proposed), of_chosen(positive), of_chosen(which)
        classes = orientation(targets[..., 2]).gather(1, which) * positive
        logits, offsets = self.judged(features, regions)
        entropy = functional.cross_entropy(logits.flatten(0, 1), classes.flatten())
        aim = box_offsets(regions, wanted.gather(1, which[..., None].expand(-1, -1, 4)))
        own = offsets.gather(2, classes[..., None, None].expand(-1, -1, 1, 4))[:, :, 0]
        error = functional.smooth_l1_loss(own, aim / aim.new_tensor(UNITS), reduction="none").sum(-1)
        refined = (error * positive).sum() / positive.numel()
        return {
            "loss": objectness + boxes + entropy + refined,
            "proposal": objectness,
            "proposal_box": boxes,
            "orientation": entropy,
            "box": refined,
        }
