"""Residual trunks (He et al., Deep Residual Learning for Image Recognition, CVPR 2016), shared by detectors.

The originals of the detectors here begin with weights learnt on ImageNet and keep norms, and the first
stage, as they are. Nothing from outside is used here, so that all learns: norms too, each block's last norm
begins at zero (the block as identity), and a trunk can be trained first on this project's own dense labels
(:class:`DenseTrunk`) and given to a detector by ``--init``.
"""

from __future__ import annotations

from collections.abc import Sequence

from torch import Tensor, nn
from torch.nn import functional

RESNET_18, RESNET_50, RESNET_101 = (2, 2, 2, 2), (3, 4, 6, 3), (3, 4, 23, 3)
"""Blocks of the four stages."""


def convolved(
    inputs: int, outputs: int, kernel: int, stride: int = 1, slope: float | None = 0.0
) -> list[nn.Module]:
    """Return convolution, norm and ReLU, leaky by ``slope``; None leaves the ReLU out."""
    layers: list[nn.Module] = [
        nn.Conv2d(inputs, outputs, kernel, stride, kernel // 2, bias=False),
        nn.BatchNorm2d(outputs),
    ]
    if slope is not None:
        layers.append(nn.LeakyReLU(slope, inplace=True) if slope else nn.ReLU(inplace=True))
    return layers


class Block(nn.Module):
    """Two 3×3 convolutions (``basic``), or a bottleneck of 1×1, 3×3 and 1×1, added to their input."""

    def __init__(
        self, inputs: int, width: int, stride: int = 1, *, basic: bool = False, slope: float = 0.0
    ) -> None:
        super().__init__()
        outputs = width if basic else 4 * width
        if basic:
            body = [*convolved(inputs, width, 3, stride, slope), *convolved(width, width, 3, slope=None)]
        else:
            body = [
                *convolved(inputs, width, 1, slope=slope),
                *convolved(width, width, 3, stride, slope),
                *convolved(width, outputs, 1, slope=None),
            ]
        self.body = nn.Sequential(*body)
        same = inputs == outputs and stride == 1
        self.shortcut = nn.Sequential(*([] if same else convolved(inputs, outputs, 1, stride, None)))
        self.slope = slope
        norm = body[-1]
        assert isinstance(norm, nn.BatchNorm2d)
        nn.init.zeros_(norm.weight)

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, inputs, H, W) to (B, outputs, H / stride, W / stride), rounded up."""
        y = self.shortcut(x) + self.body(x)
        if self.slope:
            return functional.leaky_relu(y, self.slope, inplace=True)
        return functional.relu(y, inplace=True)


def stage(inputs: int, width: int, blocks: int, stride: int, **how) -> nn.Sequential:
    """Return some blocks of which the first takes the stride."""
    outputs = width if how.get("basic") else 4 * width
    return nn.Sequential(
        *(Block(outputs if i else inputs, width, 1 if i else stride, **how) for i in range(blocks))
    )


class Trunk(nn.Module):
    """The first stages of a residual network: strides 4, 8, 16 and 32.

    Args:
        inputs: number of channels of the image.
        blocks: of each stage, as many as are given.
        basic: blocks of two convolutions, as in ResNet-18.
        slope: of leaky ReLUs; 0 for ReLUs.
        width: of the first stage.

    Attributes:
        channels: of each stage's output.
    """

    def __init__(
        self, inputs: int, blocks: Sequence[int], *, basic: bool = False, slope: float = 0.0, width: int = 64
    ) -> None:
        super().__init__()
        self.stem = nn.Sequential(*convolved(inputs, width, 7, 2, slope), nn.MaxPool2d(3, 2, 1))
        self.channels = [width * 2**i * (1 if basic else 4) for i in range(len(blocks))]
        before = [width, *self.channels]
        self.stages = nn.ModuleList(
            stage(before[i], width * 2**i, n, 2 if i else 1, basic=basic, slope=slope)
            for i, n in enumerate(blocks)
        )
        start_kaiming(self)

    def forward(self, x: Tensor) -> list[Tensor]:
        """Map (B, inputs, H, W) to the outputs of all stages."""
        x, found = self.stem(x), []
        for part in self.stages:
            x = part(x)
            found.append(x)
        return found


class Pyramid(nn.Module):
    """A ResNet-18 whose coarser maps are enlarged and added to that of stride 8 (Lin et al., CVPR 2017).

    Args:
        inputs: number of channels of the image.
        outputs: number of channels of the map.
        blocks, width: of the trunk.
    """

    stride = 8

    def __init__(self, inputs: int, outputs: int, blocks: Sequence[int], width: int = 64) -> None:
        super().__init__()
        self.trunk = Trunk(inputs, blocks, basic=True, width=width)
        self.beside = nn.ModuleList(nn.Conv2d(c, outputs, 1) for c in self.trunk.channels[1:])
        self.smooth = nn.Sequential(*convolved(outputs, outputs, 3))
        start_kaiming(self.beside)
        start_kaiming(self.smooth)

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, inputs, H, W) to (B, outputs, H/8, W/8), rounded up."""
        maps = [beside(m) for beside, m in zip(self.beside, self.trunk(x)[1:], strict=True)]
        found = maps[-1]
        for finer in reversed(maps[:-1]):
            found = finer + functional.interpolate(found, size=finer.shape[2:], mode="nearest")
        return self.smooth(found)


def start_kaiming(module: nn.Module) -> None:
    """Give all convolutions He's start."""
    for part in module.modules():
        if isinstance(part, nn.Conv2d):
            nn.init.kaiming_normal_(part.weight, mode="fan_out", nonlinearity="relu")
            if part.bias is not None:
                nn.init.zeros_(part.bias)


class DenseTrunk(nn.Module):
    """A trunk with the smallest head that gives maps: a 1×1 convolution of its last stage, enlarged.

    Its purpose is to be trained a while on dense labels; the trunk then begins a detector.

    Args:
        inputs: number of channels of the image.
        blocks: of each stage.
    """

    def __init__(self, inputs: int = 3, blocks: Sequence[int] = RESNET_50[:3]) -> None:
        super().__init__()
        self.trunk = Trunk(inputs, blocks)
        self.head = nn.Conv2d(self.trunk.channels[-1], 4, 1)
        nn.init.normal_(self.head.weight, std=0.01)
        nn.init.zeros_(self.head.bias)  # pyright: ignore[reportArgumentType]

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C, H, W) to (B, 4, H, W): quality, sin 2θ, cos 2θ, width."""
        maps = self.head(self.trunk(x)[-1])
        return functional.interpolate(maps, size=x.shape[2:], mode="bilinear", align_corners=False)


def begin_with_trunk(network: nn.Module, other: nn.Module) -> int:
    """Give every trunk within ``network`` the stem and blocks that fit of the trunk within another; how many
    tensors that was. Where that has two, the last counts, which is that of colour in Kumra's.

    A stem for another number of channels keeps its start, and so does what the trunk lacks: of a ResNet-50,
    17 blocks of a ResNet-101, which are identities then.
    """
    known = next((m.state_dict() for m in reversed(list(other.modules())) if isinstance(m, Trunk)), {})
    given = 0
    for trunk in network.modules():
        if not isinstance(trunk, Trunk):
            continue
        parts = {"stem": trunk.stem} | {n: m for n, m in trunk.named_modules() if isinstance(m, Block)}
        for name, part in parts.items():
            own = part.state_dict()
            found = {k: known[f"{name}.{k}"] for k in own if f"{name}.{k}" in known}
            if len(found) == len(own) and all(found[k].shape == own[k].shape for k in own):
                part.load_state_dict(found)
                given += len(found)
    return given
