"""GG-CNN and GG-CNN2 (Morrison et al., RSS 2018 and IJRR 2020), written anew from the
published layer tables. The four output layers of the original are one convolution here, which
computes the same; maps come in the order quality, sin 2θ, cos 2θ, width."""

from __future__ import annotations

from torch import Tensor, nn
from torch.nn import functional

from grasp_bench.networks.fit import fit


def _xavier(network: nn.Module) -> None:
    for module in network.modules():
        if isinstance(module, nn.Conv2d | nn.ConvTranspose2d):
            nn.init.xavier_uniform_(module.weight)


class GGCNN(nn.Module):
    """Three strided convolutions and three transposed ones; 62,420 parameters on depth."""

    def __init__(self, inputs: int = 1) -> None:
        super().__init__()
        self.encoder = nn.ModuleList(
            [nn.Conv2d(inputs, 32, 9, 3, 3), nn.Conv2d(32, 16, 5, 2, 2), nn.Conv2d(16, 8, 3, 2, 1)]
        )
        self.decoder = nn.ModuleList(
            [
                nn.ConvTranspose2d(8, 8, 3, 2, 1, output_padding=1),
                nn.ConvTranspose2d(8, 16, 5, 2, 2, output_padding=1),
                nn.ConvTranspose2d(16, 32, 9, 3, 3, output_padding=1),
            ]
        )
        self.head = nn.Conv2d(32, 4, 2)
        _xavier(self)

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C, H, W) to (B, 4, H, W). At 300 px sizes come out even, at 224 px 4 are cut."""
        size = x.shape[2:]
        for layer in (*self.encoder, *self.decoder):
            x = functional.relu(layer(x))
        return fit(self.head(x), size)


class GGCNN2(nn.Module):
    """Pooling and dilated convolutions instead of strides; 66,676 parameters on depth."""

    def __init__(self, inputs: int = 1) -> None:
        super().__init__()

        def block(before: int, after: int, kernel: int, dilation: int = 1) -> list[nn.Module]:
            return [
                nn.Conv2d(before, after, kernel, padding=kernel // 2 * dilation, dilation=dilation),
                nn.ReLU(inplace=True),
            ]

        def double() -> nn.Module:
            return nn.Upsample(scale_factor=2, mode="bilinear", align_corners=False)

        self.body = nn.Sequential(
            *block(inputs, 16, 11),
            *block(16, 16, 5),
            nn.MaxPool2d(2, ceil_mode=True),
            *block(16, 16, 5),
            *block(16, 16, 5),
            nn.MaxPool2d(2, ceil_mode=True),
            *block(16, 32, 5, dilation=2),
            *block(32, 32, 5, dilation=4),
            double(),
            *block(32, 16, 3),
            double(),
            *block(16, 16, 3),
        )
        self.head = nn.Conv2d(16, 4, 1)
        _xavier(self)

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C, H, W) to (B, 4, H, W)."""
        return fit(self.head(self.body(x)), x.shape[2:])
