"""Zhou et al., Fully Convolutional Grasp Detection Network with Oriented Anchor Box (IROS 2018).

    input (B, 3, S, S), colour → ResNet-101 to stride 16: (B, 1024, S/16, S/16)
      → a 3×3 convolution to 5 offsets and one to 2 scores for each of k = 4 anchors at each cell

Certain, from the code of the paper's group: trunk, heads and 27,793,500 weights (stride 16, k = 4), anchors
at ±22.5° and ±67.5°, matching, offsets in units of (0.1, 0.1, 0.2, 0.2, 0.2), loss of positives with the
hardest three negatives each, weight 2 of the offsets. (The paper's own table is of stride 32 and k = 6.)
Ours: an anchor of 38 px, the paper's 54 of 320 px for 224; the nearest of several labels instead of their
mean; norms learn, and a start of the scores at −2, as there are no ImageNet weights.
"""

from __future__ import annotations

from collections.abc import Sequence

from torch import Tensor, nn

from grasp_bench.networks.oriented import Oriented, cell_middles
from grasp_bench.networks.resnet import RESNET_101, Trunk
from grasp_bench.networks.rows import Detector

STRIDE = 16
SIZE = 38.0
ANCHORS = Oriented(4, (0.1, 0.1, 0.2, 0.2, 0.2))
OFFSET_WEIGHT = 2.0


class FCGN(Detector):
    """27,793,500 parameters.

    Args:
        inputs: number of channels of the image.
        blocks, width: of the trunk, three stages.
    """

    def __init__(self, inputs: int = 3, blocks: Sequence[int] = RESNET_101[:3], width: int = 64) -> None:
        super().__init__()
        self.trunk = Trunk(inputs, blocks, width=width)
        self.offset = nn.Conv2d(16 * width, 5 * ANCHORS.number, 3, padding=1)
        self.score = nn.Conv2d(16 * width, 2 * ANCHORS.number, 3, padding=1)
        start_heads(self.score, self.offset)

    def found(self, x: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Map (B, C, H, W) to logits (B, N, 2), offsets (B, N, 5) and anchors (1, N, 5)."""
        features = self.trunk(x)[-1]
        h, w = features.shape[2:]
        anchors = ANCHORS.anchors(STRIDE * cell_middles(h, w, x.device), SIZE)
        return listed(self.score(features), 2), listed(self.offset(features), 5), anchors[None]

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C, H, W) to rows (B, 4 · cells, 6)."""
        logits, offsets, anchors = self.found(x)
        return ANCHORS.decode(anchors.expand(len(x), -1, -1), offsets, logits.softmax(-1)[..., 1])

    def loss(self, inputs: Tensor, targets: Tensor) -> dict[str, Tensor]:
        """Return cross-entropy and smooth L1 of the anchors."""
        logits, offsets, anchors = self.found(inputs)
        cell = inputs.new_full((), STRIDE)
        entropy, shift = ANCHORS.loss(logits, offsets, anchors, cell, targets)
        return {"loss": entropy + OFFSET_WEIGHT * shift, "score": entropy, "offset": shift}


def listed(maps: Tensor, numbers: int) -> Tensor:
    """Turn (B, k · numbers, H, W) into (B, H · W · k, numbers)."""
    return maps.permute(0, 2, 3, 1).reshape(len(maps), -1, numbers).float()


def start_heads(score: nn.Conv2d, offset: nn.Conv2d) -> None:
    """Begin with small offsets, and with scores that say "none"."""
    nn.init.normal_(score.weight, std=0.01)
    nn.init.normal_(offset.weight, std=0.001)
    for layer in (score, offset):
        assert layer.bias is not None
        nn.init.zeros_(layer.bias)
    assert score.bias is not None
    score.bias.data[1::2] = -2.0
