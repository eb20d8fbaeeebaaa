"""A reconstruction of the idea of Laili et al., Custom Grasping (IEEE T-ASE 20(1), 2023), after one sentence
on it in the HTC-Grasp paper. Not their network: neither code nor text could be read.

Known: it is region-based, puts out pairs of grasping points, and learns from few labels by consistency.
The rest is a choice: a ResNet-18 with a pyramid's map of stride 8, proposals of objects, regions of 14×14,
maps of 28×28 of a contact's heat and the vector from it to its partner; a pair is a peak and the peak that
its vector hits. Consistency: what the network says of an image, without gradient, is what it shall say of
the image's mirrored copy; that counts more and more over the first 300 steps, for images without labels, too,
which say nothing of where objects are not: proposals learn from the others.
"""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn
from torch.nn import functional

from grasp_bench.networks.boxes import aligned
from grasp_bench.networks.oriented import cell_middles
from grasp_bench.networks.proposals import Found, Proposals
from grasp_bench.networks.resnet import RESNET_18, Pyramid, start_kaiming
from grasp_bench.networks.roi_gd import objects
from grasp_bench.networks.rows import Detector

CELLS = 28
SCALES = (32.0, 64.0, 128.0)
SPREAD = 1.0
"""Standard deviation of a contact's heat [cells]."""
NEAR = 2.0
"""A peak this near [cells] to where a vector points is the partner."""
PEAKS, REGIONS, LEARNT = 16, 4, 4
RAMP = 300
JITTER = 0.15
"""Sides of an object's box are moved by up to this share in training, as proposals are not exact."""


class Laili(Detector):
    """Pairs of contacts in regions; 12,910,841 parameters.

    Args:
        inputs: number of channels of the image.
        blocks, width: of the trunk.
    """

    steps: Tensor

    def __init__(self, inputs: int = 3, blocks: Sequence[int] = RESNET_18, width: int = 64) -> None:
        super().__init__()
        channels = 2 * width
        self.pyramid = Pyramid(inputs, channels, blocks, width)
        self.proposals = Proposals(channels, Pyramid.stride, SCALES, before=(600, 300), after=(20, REGIONS))
        # Regions of a step are few, and not as those in use: norms of each, not of the batch.
        layers: list[nn.Module] = []
        for _ in range(4):
            layers += [nn.Conv2d(channels, channels, 3, padding=1, bias=False)]
            layers += [nn.GroupNorm(8, channels), nn.ReLU(inplace=True)]
        self.body = nn.Sequential(
            *layers, nn.ConvTranspose2d(channels, channels, 4, 2, 1), nn.ReLU(inplace=True)
        )
        start_kaiming(self.body)
        self.head = nn.Conv2d(channels, 3, 1)
        nn.init.normal_(self.head.weight, std=0.01)
        nn.init.zeros_(self.head.bias)  # pyright: ignore[reportArgumentType]
        self.register_buffer("steps", torch.zeros(()))

    def maps(self, features: Tensor, boxes: Tensor) -> tuple[Tensor, Tensor]:
        """Return heat (R, 28, 28) and partners (R, 2, 28, 28), in sides, of boxes (B, K, 4); R = B · K."""
        regions = aligned(features, boxes, Pyramid.stride, CELLS // 2)
        found = self.head(self.body(regions.flatten(0, 1).to(features.dtype))).float()
        return found[:, 0], found[:, 1:]

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C, H, W) to rows (B, regions · 16, 6)."""
        features = self.pyramid(x)
        boxes, objectness = self.proposals.propose(self.proposals(features), (x.shape[2], x.shape[3]))
        heat, partner = self.maps(features, boxes)
        heat = heat.clamp(0, 1)
        top = heat * (heat == functional.max_pool2d(heat[:, None], 3, 1, 1)[:, 0])
        score, place = top.flatten(1).topk(PEAKS, dim=1)
        points = cell_middles(CELLS, CELLS, x.device)[place] / CELLS  # (R, P, 2)
        vectors = partner.flatten(2).gather(2, place[:, None].expand(-1, 2, -1)).transpose(1, 2)
        miss = (points[:, :, None] + vectors[:, :, None] - points[:, None]).norm(dim=-1)
        other = miss.argmin(2)
        hit = miss.amin(2) <= NEAR / CELLS

        def partners(values: Tensor) -> Tensor:
            return values.gather(1, other[..., None].expand(-1, -1, values.shape[-1]))

        doubt = (vectors + partners(vectors)).square().sum(-1)
        value = (score * score.gather(1, other)).sqrt() * (-doubt).exp() * hit
        flat = boxes.flatten(0, 1)
        side, corner = (flat[:, 2:] - flat[:, :2])[:, None], flat[:, None, :2]
        a, b = corner + side * points, corner + side * partners(points)
        along = b - a
        width = along.norm(dim=-1)
        angle = torch.atan2(-along[..., 1], along[..., 0])
        value = value * objectness.flatten()[:, None] * (width > 1)
        middle = (a + b) / 2
        rows = torch.cat([middle, torch.stack([angle, width, width / 2, value], dim=-1)], dim=-1)
        return rows.view(len(x), -1, 6)

    def loss(self, inputs: Tensor, targets: Tensor) -> dict[str, Tensor]:
        """Return losses of proposals, heat, partners, and consistency with the mirrored image."""
        features = self.pyramid(inputs)
        boxes, first = objects(targets)
        found = self.proposals(features)
        logits, offsets, fixed = found
        known = first.any(1)
        if known.any():
            objectness, edges = self.proposals.loss(
                (logits[known], offsets[known], fixed), boxes[known], first[known]
            )
        else:
            objectness, edges = 0 * logits.sum(), 0 * offsets.sum()
        some, chosen = first.float().topk(LEARNT, dim=1)
        regions = boxes.gather(1, chosen[..., None].expand(-1, -1, 4))
        side = (regions[..., 2:] - regions[..., :2]).repeat(1, 1, 2)
        regions = regions + JITTER * side * (2 * torch.rand_like(side) - 1)
        regions = torch.where(some[..., None] > 0, regions, regions.new_tensor([0.0, 0.0, 16.0, 16.0]))
        heat, partner = self.maps(features, regions)
        wanted, vector, on = contact_maps(regions.flatten(0, 1), targets.repeat_interleave(LEARNT, 0))
        there = (some > 0).flatten()[:, None, None]
        # Contacts are few: their cells count ten times.
        errors = (heat - wanted).square() * (1 + 9 * wanted) * there
        heats = errors.sum() / (CELLS * there.sum()).clamp(min=1)
        on = on & there
        vectors = ((partner - vector).abs().sum(1) * on).sum() / on.sum().clamp(min=1)
        same = self._consistency(inputs, features, found)
        loss = objectness + edges + heats + vectors + same
        return {"loss": loss, "proposal": objectness, "heat": heats, "partner": vectors, "consistency": same}

    def _consistency(self, inputs: Tensor, features: Tensor, found: Found) -> Tensor:
        """Return the squared difference of heat in the best proposals and in the mirrored image."""
        self.steps += 1
        boxes = self.proposals.propose(found, (inputs.shape[2], inputs.shape[3]))[0][:, :2]
        with torch.no_grad():
            teacher = self.maps(features.detach(), boxes)[0].flip(2)
        wide = float(inputs.shape[3])
        mirrored = torch.stack([wide - boxes[..., 2], boxes[..., 1], wide - boxes[..., 0], boxes[..., 3]], -1)
        student = self.maps(self.pyramid(inputs.flip(3)), mirrored)[0]
        return (student - teacher).square().mean() * (self.steps / RAMP).clamp(max=1)


def contact_maps(boxes: Tensor, rows: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """Return heat (R, 28, 28), vectors to partners (R, 2, 28, 28) in sides, and where these count.

    Args:
        boxes: (R, 4).
        rows: labels (R, M, 6); contacts are the ends of their openings.
    """
    half = rows[..., 3, None] / 2 * torch.stack([rows[..., 2].cos(), -rows[..., 2].sin()], dim=-1)
    ends = torch.cat([rows[..., :2] - half, rows[..., :2] + half], dim=1)
    others = torch.cat([2 * half, -2 * half], dim=1)
    side = (boxes[:, 2:] - boxes[:, :2]).clamp(min=1)[:, None]
    ends, others = (ends - boxes[:, None, :2]) / side, others / side
    there = (rows[..., 5] > 0).repeat(1, 2) & ((ends >= 0) & (ends <= 1)).all(-1)
    cells = cell_middles(CELLS, CELLS, boxes.device) / CELLS
    apart = CELLS * (cells[None, :, None] - ends[:, None]).norm(dim=-1)
    apart = apart.masked_fill(~there[:, None], torch.inf)
    nearest, which = apart.min(2)
    heat = (-nearest.square() / (2 * SPREAD**2)).exp()
    vector = others.gather(1, which[..., None].expand(-1, -1, 2)).transpose(1, 2)
    return (
        heat.unflatten(1, (CELLS, CELLS)),
        vector.unflatten(2, (CELLS, CELLS)),
        (nearest <= 1).unflatten(1, (CELLS, CELLS)),
    )
