"""Networks with losses of their own: what they learn, and what they say of it."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
import torch
from torch import Tensor, nn

from grasp_bench.grasps import Grasp, angle_difference
from grasp_bench.networks.asif import Asif
from grasp_bench.networks.chu import Chu
from grasp_bench.networks.encoding import WIDTH_SCALE, grasps_from_output
from grasp_bench.networks.fcgn import FCGN
from grasp_bench.networks.gqcnn import GQCNN
from grasp_bench.networks.kumra import Kumra
from grasp_bench.networks.laili import Laili
from grasp_bench.networks.lenz import Lenz
from grasp_bench.networks.redmon import Redmon
from grasp_bench.networks.roi_gd import RoiGD
from grasp_bench.networks.rows import NONE, Detector
from grasp_bench.networks.wu import Wu

torch.set_num_threads(1)

SIZE = 96
BARS = ((38.0, 44.0, 0.3), (58.0, 50.0, -1.1))
"""Middle and direction of the opening across a bar of each image."""
OPENING, LENGTH = 24.0, 44.0


def scenes(size: int) -> tuple[Tensor, Tensor, Tensor]:
    """Images (2, 4, S, S) of a bar each, rows (2, 6, 6), three that hold and one that fails, and maps."""
    scale = size / SIZE
    images, maps = torch.zeros(2, 4, size, size), torch.zeros(2, 4, size, size)
    rows = torch.zeros(2, 6, 6)
    rows[..., 5] = NONE
    axis = torch.arange(size) + 0.5
    y, x = torch.meshgrid(axis, axis, indexing="ij")
    for i, (cx, cy, angle) in enumerate(BARS):
        cx, cy = cx * scale, cy * scale
        u = (x - cx) * math.cos(angle) - (y - cy) * math.sin(angle)
        v = (x - cx) * math.sin(angle) + (y - cy) * math.cos(angle)
        bar = (u.abs() < 6 * scale) & (v.abs() < LENGTH / 2 * scale)
        images[i, 0][bar] = 0.4
        images[i, 1:, bar] = 0.5
        for k, off in enumerate((0.0, -10.0, 10.0)):
            off *= scale
            place = cx + off * math.sin(angle), cy + off * math.cos(angle)
            rows[i, k] = torch.tensor([*place, angle, OPENING * scale, OPENING * scale / 2, 1])
        rows[i, 3] = torch.tensor([cx, cy, angle + 1.4, OPENING * scale, OPENING * scale / 2, 0])
        label = (1.0, math.sin(2 * angle), math.cos(2 * angle), OPENING * scale / WIDTH_SCALE)
        maps[i][:, bar & (v.abs() < 14 * scale)] = torch.tensor(label)[:, None]
    return images, rows, maps


def right(grasp: Grasp, image: int, scale: float) -> bool:
    """Whether a grasp lies across the image's bar."""
    cx, cy, angle = BARS[image]
    dx, dy = grasp.x / scale - cx, grasp.y / scale - cy
    across = dx * math.cos(angle) - dy * math.sin(angle)
    along = dx * math.sin(angle) + dy * math.cos(angle)
    return (
        abs(across) < 7
        and abs(along) < LENGTH / 2
        and angle_difference(grasp.angle, angle) < math.radians(25)
        and 0.6 * OPENING < grasp.width / scale < 1.7 * OPENING
    )


LEARNERS: dict[str, tuple[Callable[[], Detector], int, int, int]] = {
    "redmon-direct": (lambda: Redmon(dropout=0.0, side=SIZE), 3, 80, SIZE),
    "redmon-multigrasp": (lambda: Redmon(multiple=True, dropout=0.0, side=SIZE), 3, 50, SIZE),
    "kumra-resnet50": (lambda: Kumra(blocks=(1, 1, 1, 1), width=16, dropout=0.0), 3, 40, SIZE),
    "kumra-resnet50x2": (lambda: Kumra(4, blocks=(1, 1, 1), width=16, dropout=0.0), 4, 40, SIZE),
    "fcgn": (lambda: FCGN(blocks=(1, 1, 1), width=16), 3, 50, SIZE),
    "chu-resnet50": (lambda: Chu(blocks=(1, 1, 1, 1), width=8, regions=16), 3, 70, SIZE),
    "roi-gd": (lambda: RoiGD(blocks=(1, 1, 1), width=8, regions=6), 3, 40, SIZE),
    "wu-anchor-free": (lambda: Wu(blocks=(1, 1, 1, 1), width=16), 3, 50, SIZE),
    "laili-pairs": (lambda: Laili(blocks=(1, 1, 1, 1), width=32), 3, 120, SIZE),
    "asif-graspnet": (Asif, 3, 40, SIZE),
    "gq-cnn": (lambda: GQCNN(each=4), 1, 8, SIZE),
    "lenz-sae": (lambda: Lenz(iterations=8), 4, 25, SIZE),
}
"""What makes each with a smaller trunk and without dropout, its channels, steps, and side of the image."""


@pytest.mark.parametrize("name", LEARNERS)
def test_a_handful_of_scenes_is_learnt(name: str) -> None:
    make, channels, steps, size = LEARNERS[name]
    torch.manual_seed(1)
    network = make().train()
    images, rows, maps = scenes(size)
    inputs = {4: images, 3: images[:, 1:], 1: images[:, :1]}[channels]
    targets = maps if name == "asif-graspnet" else rows
    network.prepare(inputs, targets)
    optimizer = torch.optim.AdamW(network.parameters(), lr=1e-3)
    losses: list[float] = []
    for step in range(steps):
        for group in optimizer.param_groups:
            group["lr"] = 1e-3 * min(1, (step + 1) / 8)
        parts = network.loss(inputs, targets)
        optimizer.zero_grad()
        parts["loss"].backward()
        if not step:
            for parameter, value in network.named_parameters():
                assert value.grad is not None, parameter
        nn.utils.clip_grad_norm_(network.parameters(), 5.0)
        optimizer.step()
        losses.append(parts["loss"].item())
    assert all(math.isfinite(loss) for loss in losses)
    assert min(losses[-3:]) < 0.7 * losses[0]
    # Norms have seen a few steps only: those of the two images are what they were taught with.
    for module in network.modules():
        if isinstance(module, nn.BatchNorm2d):
            module.momentum = None
            module.reset_running_stats()
    with torch.no_grad():
        for _ in range(2):
            network.loss(inputs, targets)
    network.eval()
    with torch.inference_mode():
        outputs = network(inputs)
    for i, output in enumerate(outputs):
        best = grasps_from_output(output, 3)
        assert best, "nothing was found"
        assert right(best[0], i, size / SIZE), (best, BARS[i], losses[0], losses[-1])
