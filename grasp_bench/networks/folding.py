"""Networks made cheaper for inference: the same function from fewer passes over memory.

A batch norm that only uses its running statistics is a scale and a shift of each channel. Both go into the
convolution before it.
"""

from __future__ import annotations

from copy import deepcopy

import torch
from torch import Tensor, nn

from grasp_bench.networks.grconvnet import GRConvNet
from grasp_bench.networks.htc_grasp import Fuse

Convolution = nn.Conv2d | nn.ConvTranspose2d


@torch.no_grad()
def folded(network: nn.Module) -> nn.Module:
    """A copy of ``network`` without batch norms, equal up to rounding; it is not for training.

    Raises:
        ValueError: the network is in training mode, in which norms are none of fixed scales.
    """
    if network.training:
        raise ValueError("batch norms can only be folded in evaluation mode: call network.eval() first")
    network = deepcopy(network)
    for module in list(network.modules()):
        if isinstance(module, nn.Sequential):
            _fold_sequence(module)
        elif isinstance(module, Fuse):
            scale, shift = _affine(module.norm)
            for convolution in module.merge:
                _scale_outputs(convolution, scale)  # pyright: ignore[reportArgumentType]
            _shift_outputs(module.merge[0], shift)  # pyright: ignore[reportArgumentType]
            module.norm = nn.Identity()  # pyright: ignore[reportAttributeAccessIssue]
        elif isinstance(module, GRConvNet):
            _join_heads(module)
    return network.requires_grad_(False)


def _fold_sequence(sequence: nn.Sequential) -> None:
    """Fold every norm that follows a convolution, or a convolution and a pixel shuffle."""
    before: nn.Module | None = None
    spread = 1
    for name, module in sequence.named_children():
        if isinstance(module, nn.BatchNorm2d) and isinstance(before, Convolution):
            scale, shift = (value.repeat_interleave(spread) for value in _affine(module))
            _scale_outputs(before, scale)
            _shift_outputs(before, shift)
            setattr(sequence, name, nn.Identity())
        if isinstance(module, nn.PixelShuffle):  # makes a channel of the output of factor² consecutive ones
            spread = module.upscale_factor**2
        else:
            before, spread = module, 1


def _affine(norm: nn.BatchNorm2d) -> tuple[Tensor, Tensor]:
    """Scale and shift (C,) of each channel."""
    assert norm.running_var is not None
    assert norm.running_mean is not None
    weight = norm.weight if norm.affine else torch.ones_like(norm.running_mean)
    bias = norm.bias if norm.affine else torch.zeros_like(norm.running_mean)
    scale = weight / torch.sqrt(norm.running_var + norm.eps)
    return scale, bias - norm.running_mean * scale


def _scale_outputs(convolution: Convolution, scale: Tensor) -> None:
    """Multiply what a convolution without groups puts out by ``scale`` (C,)."""
    transposed = isinstance(convolution, nn.ConvTranspose2d)
    convolution.weight.mul_(scale.view((1, -1, 1, 1) if transposed else (-1, 1, 1, 1)))
    if convolution.bias is not None:
        convolution.bias.mul_(scale)


def _shift_outputs(convolution: Convolution, shift: Tensor) -> None:
    """Add ``shift`` (C,) to what a convolution puts out."""
    if convolution.bias is None:
        convolution.bias = nn.Parameter(shift.clone())
    else:
        convolution.bias.add_(shift)


def _join_heads(network: GRConvNet) -> None:
    """Four convolutions of the same features, which training drops from apart, as one."""
    heads = [head[-1] for head in network.heads]  # pyright: ignore[reportIndexIssue]
    joint = deepcopy(heads[0])
    joint.out_channels = len(heads)
    joint.weight = nn.Parameter(torch.cat([head.weight for head in heads]))
    joint.bias = nn.Parameter(torch.cat([head.bias for head in heads]))
    network.heads = nn.ModuleList([joint])
