"""Mahler et al., Dex-Net 2.0 (RSS 2017): a network that judges a grasp by the depth picture about it, and a
search for the grasp it judges best.

    32×32 depth about the centre, closing axis along x → four convolutions → 1024
    depth of the finger tips → 16
      → 1024 of both → holds or not

Certain: layers, local response norms, 18,025,826 weights (one pooling, as in the paper; today's published
configuration has a second), rotations and flips in training, and the search: antipodal pairs of depth edges,
then three rounds by the cross-entropy method with 50 samples each and a quarter of them kept.
Ours: labels are this project's tries in physics, failures included, instead of a robust quality. Depth is
the height over the table that all networks here are shown; the patch is 2.5 times as wide as the grasp
opens, since the gripper opens as wide as a grasp says; the tips are 25 mm below the highest point between
the jaws, or at 3 mm, as the planner's rule decides about depth, so that there is nothing to search in it.
Samples scatter about the ones that are kept, a Gaussian each, where the original fits fewer of them.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn
from torch.nn import functional

from grasp_bench.networks.rows import Detector, cut_out
from grasp_bench.networks.tries import examples

SIZE = 32
VIEW = 2.5
"""Side of the patch over the opening."""
BELOW, LOWEST = 0.25, 0.03
"""Of the finger tips, in units of 0.1 m."""
EDGE = 0.04
"""Least slope of an edge, in units of 0.1 m a pixel."""
CONE = math.cos(math.atan(0.8))
"""Least cosine between the jaws' direction and an edge's normal (friction 0.8)."""
EDGES, SEEDS, SAMPLES, ROUNDS = 512, 250, 50, 3
KEPT = 0.25
OPENING = (6.0, 80.0)
"""Distances of edges that make a pair [px]."""
MARGIN = 1.25
"""Opening over the distance of the edges."""


def _layer(inputs: int, outputs: int, kernel: int) -> list[nn.Module]:
    return [nn.Conv2d(inputs, outputs, kernel, padding="same"), nn.ReLU(inplace=True)]


class GQCNN(Detector):
    """18,025,826 parameters.

    Args:
        inputs: 1, the height.
        each: grasps that hold, and that do not, drawn of an image.
    """

    warm_up = 8
    centre: Tensor
    spread: Tensor

    def __init__(self, inputs: int = 1, each: int = 16) -> None:
        super().__init__()
        self.each = each
        self.picture = nn.Sequential(
            *_layer(inputs, 64, 7),
            *_layer(64, 64, 5),
            nn.MaxPool2d(2),
            nn.LocalResponseNorm(5, alpha=1e-4, beta=0.75, k=1.0),
            *_layer(64, 64, 3),
            *_layer(64, 64, 3),
            nn.LocalResponseNorm(5, alpha=1e-4, beta=0.75, k=1.0),
            nn.Flatten(),
            nn.Linear(64 * (SIZE // 2) ** 2, 1024),
            nn.ReLU(inplace=True),
        )
        self.pose = nn.Sequential(nn.Linear(1, 16), nn.ReLU(inplace=True))
        self.merge = nn.Sequential(nn.Linear(1040, 1024), nn.ReLU(inplace=True))
        self.judge = nn.Linear(1024, 2)
        for module in self.modules():
            if isinstance(module, nn.Conv2d | nn.Linear):
                nn.init.kaiming_normal_(module.weight)
                nn.init.zeros_(module.bias)  # pyright: ignore[reportArgumentType]
        self.register_buffer("centre", torch.zeros(2))
        self.register_buffer("spread", torch.ones(2))

    def patches(self, images: Tensor, rows: Tensor) -> tuple[Tensor, Tensor]:
        """Return patches (B, K, 1, 32, 32) and tips (B, K) of grasps (B, K, ≥ 5), both in units of 0.1 m."""
        square = rows[..., :5].clone()
        square[..., 3:5] = VIEW * rows[..., 3, None]
        found = cut_out(images, square, SIZE)
        low = round(SIZE * (0.5 - 0.5 / VIEW))
        between = found[..., 0, SIZE // 2 - 2 : SIZE // 2 + 2, low : SIZE - low]
        return found, (between.amax((-1, -2)) - BELOW).clamp(min=LOWEST)

    def judged(self, patches: Tensor, tips: Tensor) -> Tensor:
        """Return logits (N, 2), of failing and holding, of patches (N, 1, 32, 32) and tips (N,)."""
        x = self.picture((patches - self.centre[0]) / self.spread[0])
        z = self.pose((tips[:, None] - self.centre[1]) / self.spread[1])
        return self.judge(self.merge(torch.cat([x, z], dim=1))).float()

    def prepare(self, inputs: Tensor, targets: Tensor) -> None:
        """Take mean and deviation of patches and tips from the first data."""
        rows, _, known = examples(targets, self.each)
        patches, tips = self.patches(inputs, rows)
        for i, values in enumerate((patches[known], tips[known])):
            if values.numel() > 1:
                self.centre[i], self.spread[i] = values.mean(), values.std().clamp(min=1e-3)

    def loss(self, inputs: Tensor, targets: Tensor) -> dict[str, Tensor]:
        """Return the cross-entropy of grasps that held and that did not."""
        rows, label, known = examples(targets, self.each)
        patches, tips = self.patches(inputs, rows)
        flips = torch.rand(2, *rows.shape[:2], 1, 1, 1, device=inputs.device) < 0.5
        patches = torch.where(flips[0], patches.flip(-1), patches)
        patches = torch.where(flips[1], patches.flip(-2), patches)
        logits = self.judged(patches.flatten(0, 1), tips.flatten())
        entropy = functional.cross_entropy(logits, label.flatten().long(), reduction="none")
        known = known.flatten()
        right = ((logits.argmax(1) == label.flatten().long()) & known).sum() / known.sum().clamp(min=1)
        return {"loss": (entropy * known).sum() / known.sum().clamp(min=1), "accuracy": right.detach()}

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, 1, H, W) to rows (B, 300, 6): what was judged last, and the pairs it began with."""
        return torch.stack([self._searched(image[None]) for image in x])

    def _scored(self, image: Tensor, rows: Tensor) -> Tensor:
        patches, tips = self.patches(image, rows[None])
        chance = self.judged(patches[0], tips[0]).softmax(1)[:, 1]
        return torch.cat([rows[:, :5], chance[:, None]], dim=1)

    def _searched(self, image: Tensor) -> Tensor:
        chance = torch.Generator(device=image.device).manual_seed(0)
        table = image.new_zeros(SEEDS + SAMPLES, 6)
        rows = antipodal_pairs(image[0, 0], SEEDS, chance)
        if not len(rows):
            return table
        seeds = rows = self._scored(image, rows)
        scale = rows.new_tensor([2.0, 2.0, math.radians(6), 2.0])
        for _ in range(ROUNDS):
            elite = rows[rows[:, 5].argsort(descending=True)[: max(1, math.ceil(KEPT * len(rows)))]]
            which = torch.randint(len(elite), (SAMPLES,), generator=chance, device=image.device)
            noise = torch.randn(SAMPLES, 4, generator=chance, device=image.device)
            drawn = elite[which, :5]
            drawn[:, :4] += scale * noise
            drawn[:, 3] = drawn[:, 3].clamp(min=OPENING[0], max=MARGIN * OPENING[1])
            drawn[:, 4] = drawn[:, 3] / 2
            rows = self._scored(image, drawn)
        found = torch.cat([rows, seeds])
        table[: len(found)] = found
        return table


def antipodal_pairs(height: Tensor, count: int, chance: torch.Generator) -> Tensor:
    """Return at most ``count`` rows (N, 5): pairs of depth edges (H, W) whose slopes face each other.

    Args:
        height: in units of 0.1 m.
        chance: draws edges, and pairs where there are more.
    """
    smooth = functional.avg_pool2d(height[None, None].float(), 3, 1, 1)[0, 0]
    down, right = (torch.zeros_like(smooth) for _ in range(2))
    down[1:-1] = (smooth[2:] - smooth[:-2]) / 2
    right[:, 1:-1] = (smooth[:, 2:] - smooth[:, :-2]) / 2
    slope = torch.stack([right, down], dim=-1)
    steep = slope.norm(dim=-1)
    steep[:3], steep[-3:], steep[:, :3], steep[:, -3:] = 0, 0, 0, 0
    y, x = (steep > EDGE).nonzero(as_tuple=True)
    if len(y) > EDGES:
        some = torch.randperm(len(y), generator=chance, device=y.device)[:EDGES]
        y, x = y[some], x[some]
    point = torch.stack([x, y], dim=-1).float() + 0.5
    normal = slope[y, x] / steep[y, x, None].clamp(min=1e-9)
    apart = point[None] - point[:, None]
    distance = apart.norm(dim=-1).clamp(min=1e-6)
    axis = apart / distance[..., None]
    facing = ((axis * normal[:, None]).sum(-1) >= CONE) & ((axis * normal[None]).sum(-1) <= -CONE)
    pairs = (facing & (distance >= OPENING[0]) & (distance <= OPENING[1])).triu(1).nonzero()
    pairs = pairs[torch.randperm(len(pairs), generator=chance, device=y.device)[:count]]
    first, second = point[pairs[:, 0]], point[pairs[:, 1]]
    along = second - first
    width = MARGIN * along.norm(dim=-1)
    angle = torch.atan2(-along[:, 1], along[:, 0])
    return torch.cat([(first + second) / 2, torch.stack([angle, width, width / 2], dim=-1)], dim=-1)
