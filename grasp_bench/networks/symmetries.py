"""Test-time augmentation: the mean of what a network says of turned and mirrored copies of a picture.

The copies are symmetries of a square, which move pixels onto pixels, so that nothing is lost by
resampling. A network has learnt to treat them alike, and yet errs on each a little differently.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce

import torch
from torch import Tensor, nn

SYMMETRIES = tuple((turns, mirror) for mirror in (False, True) for turns in range(4))
"""Quarter turns counter-clockwise, of the picture or of its mirror image: all eight of the square."""
USED = tuple((turns, mirror) for turns, mirror in SYMMETRIES if turns % 2 == 0)
"""Those that keep rows as rows. In trials these four gave as much as all eight (docs/results.md)."""


def moved(planes: Tensor, turns: int, mirror: bool) -> Tensor:
    """Exchange left and right if asked to, then turn (…, S, S) by quarters, counter-clockwise."""
    return torch.rot90(planes.flip(-1) if mirror else planes, turns, (-2, -1))


def moved_back(maps: Tensor, turns: int, mirror: bool) -> Tensor:
    """Return what maps (B, 4, S, S) of a moved picture say of the picture itself.

    A quarter turn adds π to twice the angle, which changes the sign of its sine and its cosine; the mirror
    changes the sign of the angle.
    """
    quality, sin2, cos2, width = torch.rot90(maps, -turns, (-2, -1)).unbind(1)
    quarter = -1 if turns % 2 else 1
    own = torch.stack([quality, quarter * sin2, quarter * cos2, width], dim=1)
    if mirror:
        own = own.flip(-1)
        own[:, 1].neg_()
    return own


def answers(network: nn.Module, x: Tensor, symmetries: Sequence[tuple[int, bool]]) -> list[Tensor]:
    """Return what a network says of images (B, C, S, S) by each of their copies, as their maps (B, 4, S, S).

    It is asked about one copy at a time, as the memory of one suffices.
    """

    def copied(turns: int, mirror: bool) -> Tensor:
        return moved(x, turns, mirror).contiguous(memory_format=torch.channels_last)

    return [moved_back(network(copied(*symmetry)), *symmetry) for symmetry in symmetries]


class Averaged(nn.Module):
    """Maps of a network, averaged over symmetries of the square.

    Sine and cosine are averaged as such: where views disagree on the angle, the vector gets shorter, and its
    direction lies between theirs.

    Args:
        network: maps images (B, C, S, S) to maps (B, 4, S, S).
        symmetries: some of :data:`SYMMETRIES`.
    """

    def __init__(self, network: nn.Module, symmetries: tuple[tuple[int, bool], ...] = USED) -> None:
        super().__init__()
        self.network, self.symmetries = network, symmetries

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, C, S, S) to (B, 4, S, S)."""
        found = answers(self.network, x, self.symmetries)
        return reduce(torch.add, found) / len(found)
