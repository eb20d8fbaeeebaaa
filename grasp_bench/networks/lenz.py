"""Lenz, Lee & Saxena, Deep Learning for Detecting Robotic Grasps (RSS 2013; IJRR 34(4), 2015): two sparse
auto-encoders that judge rectangles, and a search through all of them.

    4032 features of a rectangle → K sigmoid units → K sigmoid units → grasp or not
    search: 12 directions, 45 shapes, places 7 px apart → the 100 that K = 50 likes best → K = 200 decides

Certain, from the authors' code: features, whitening, mask scaling, both layers' pre-training one after the
other by L-BFGS (sparsity, the structured penalty that keeps a unit to few kinds of features), the rescaling
after it, the search, the score. The cascade's sizes are of the paper; the code has no cascade.
204,302 and 847,202 weights.
Ours: :mod:`grasp_bench.networks.lenz_features` on what differs in the features. Both networks are tuned
together by the same steps as all networks here (AdamW) instead of 150 iterations of L-BFGS. Sizes of 10 to
90 px of 320 are 7 to 63 of 224.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn
from torch.nn import functional

from grasp_bench.networks.lenz_features import FEATURES, MODES, candidates, features, prepared
from grasp_bench.networks.rows import Detector
from grasp_bench.networks.tries import examples

UNITS = (50, 200)
TOP = 100
EACH = 16
CHUNK = 512
"""Rectangles judged at a time."""
SPARSITY, EPSILON, SHRINKAGE, STRUCTURE = 3.0, 1e-5, 3e-4, 0.01
SMALL = 1e-7
ITERATIONS = 200
DEVIATION, ACTIVITY = 1.5, 0.15
"""Of a unit's input, and a unit's output for the mean of its input, after pre-training."""
REGULARISATION = 1e-6


class AutoEncoder(nn.Module):
    """Two layers of sigmoid units and two classes.

    Args:
        units: of each layer.
    """

    def __init__(self, units: int) -> None:
        super().__init__()
        self.first = nn.Linear(FEATURES, units)
        self.second = nn.Linear(units, units)
        self.judge = nn.Linear(units, 2)
        for layer in (self.first, self.second, self.judge):
            nn.init.normal_(layer.weight, std=0.01)
            nn.init.zeros_(layer.bias)

    def forward(self, x: Tensor) -> Tensor:
        """Map whitened features (N, 4032) to logits (N, 2), of failing and holding."""
        return self.judge(self.second(self.first(x).sigmoid()).sigmoid()).float()

    def penalty(self) -> Tensor:
        """Return what is added to a case's cross-entropy, for all weights."""
        shrink = sum((layer.weight.square() + SMALL).sqrt().sum() for layer in (self.first, self.second))
        structured = structure(self.first.weight, 300, 5e4)
        return REGULARISATION * (self.judge.weight.square().sum() + shrink + structured)

    def pretrain(self, x: Tensor, mask: Tensor, iterations: int = ITERATIONS) -> None:
        """Learn both layers by what they can rebuild of unlabelled cases.

        Args:
            x: whitened features (N, 4032), zero where masked.
            mask: scaled mask (N, 4032), what errors weigh.
        """
        n = len(x)

        def first_cost(weight: Tensor) -> Tensor:
            hidden = functional.linear(x, weight).sigmoid()
            error = 0.5 * (mask * (hidden @ weight - x).square()).sum()
            shrink = SHRINKAGE * (weight.square() + SMALL).sqrt().sum()
            return error + _sparsity(hidden) + n * (shrink + STRUCTURE * structure(weight, 200, 1e15))

        with torch.no_grad():
            self.first.weight.copy_(functional.normalize(torch.randn_like(self.first.weight)))
        _minimise(first_cost, [self.first.weight], iterations)
        _rescale(self.first, x)
        hidden = self.first(x).sigmoid().detach()
        back = hidden.new_zeros(hidden.shape[1], requires_grad=True)

        def second_cost(weight: Tensor, bias: Tensor, back: Tensor) -> Tensor:
            above = functional.linear(hidden, weight, bias).sigmoid()
            error = 0.5 * ((above @ weight + back).sigmoid() - hidden).square().sum()
            return error + _sparsity(above) + n * SHRINKAGE * (weight.square() + SMALL).sqrt().sum()

        with torch.no_grad():
            self.second.weight.copy_(functional.normalize(torch.randn_like(self.second.weight)))
        _minimise(second_cost, [self.second.weight, self.second.bias, back], iterations)
        _rescale(self.second, hidden)


def structure(weight: Tensor, sharpness: float, steepness: float) -> Tensor:
    """Return nearly the number of (unit, mode) pairs with any weight that is not zero, as a smooth function.

    Args:
        weight: (K, 4032), modes one after the other.
        sharpness: of the soft maximum; ``steepness``: of the count.
    """
    size = (weight.unflatten(1, (MODES, -1)).square() + SMALL).sqrt()
    largest = torch.logsumexp(sharpness * size, dim=2) / sharpness
    none = math.log(size.shape[2]) / sharpness + math.sqrt(SMALL)
    return (1 + steepness * (largest - none).square()).log().sum()


def _sparsity(hidden: Tensor) -> Tensor:
    return SPARSITY * (EPSILON + hidden.square()).sqrt().sum()


def _minimise(cost, values: list[Tensor], iterations: int) -> None:
    optimizer = torch.optim.LBFGS(values, max_iter=iterations, history_size=10, line_search_fn="strong_wolfe")

    def closure() -> Tensor:
        optimizer.zero_grad()
        value = cost(*values)
        value.backward()
        return value

    optimizer.step(closure)
    optimizer.zero_grad()


@torch.no_grad()
def _rescale(layer: nn.Linear, x: Tensor) -> None:
    before = functional.linear(x, layer.weight)
    layer.weight *= (DEVIATION / before.std(0).clamp(min=1e-6))[:, None]
    mean = functional.linear(x, layer.weight).mean(0)
    layer.bias.copy_(math.log(ACTIVITY / (1 - ACTIVITY)) - mean)


class Lenz(Detector):
    """204,302 and 847,202 parameters.

    Args:
        inputs: 4, depth first.
        units: of the network that searches and of the one that decides.
        iterations: of pre-training, a layer.
    """

    warm_up = 8
    mean: Tensor
    deviation: Tensor

    def __init__(self, inputs: int = 4, units: tuple[int, int] = UNITS, iterations: int = ITERATIONS) -> None:
        super().__init__()
        if inputs != 4:
            raise ValueError(f"Lenz's features are of colour and depth, not of {inputs} channels.")
        self.iterations = iterations
        self.small, self.large = (AutoEncoder(k) for k in units)
        self.register_buffer("mean", torch.zeros(FEATURES))
        self.register_buffer("deviation", torch.ones(MODES))

    def whitened(self, images: Tensor, rows: Tensor) -> tuple[Tensor, Tensor]:
        """Return features (B · K, 4032) and the scaled mask of rectangles (B, K, ≥ 5); images prepared."""
        found, mask = features(images, rows)
        scale = 1 / mask.mean(2, keepdim=True).clamp(min=0.6)
        whitened = (found.flatten(1) - self.mean).view_as(found) / self.deviation[:, None]
        weight = mask * scale
        return (whitened * weight).flatten(1), weight.flatten(1)

    @torch.no_grad()
    def prepare(self, inputs: Tensor, targets: Tensor) -> None:
        """Take what whitens from the first data, and pre-train both networks on it."""
        rows, _, known = examples(targets, EACH)
        images = prepared(inputs)
        found, mask = features(images, rows)
        found, mask = found[known.flatten()], mask[known.flatten()]
        if not len(found):
            return
        number = mask.sum(0).clamp(min=1)
        self.mean.copy_(((found * mask).sum(0) / number).flatten())
        rest = (found - self.mean.view(MODES, -1)) * mask
        self.deviation.copy_(
            (rest.square().sum((0, 2)) / mask.sum((0, 2)).clamp(min=1)).sqrt().clamp(min=1e-3)
        )
        x, weight = self.whitened(images, rows)
        with torch.enable_grad():
            for network in (self.small, self.large):
                network.pretrain(x[known.flatten()], weight[known.flatten()], self.iterations)

    def loss(self, inputs: Tensor, targets: Tensor) -> dict[str, Tensor]:
        """Return both networks' cross-entropy with their penalties."""
        rows, label, known = examples(targets, EACH)
        x, _ = self.whitened(prepared(inputs), rows)
        wanted, known = label.flatten().long(), known.flatten()
        parts = {}
        for name, network in (("small", self.small), ("large", self.large)):
            entropy = functional.cross_entropy(network(x), wanted, reduction="none")
            parts[name] = (entropy * known).sum() / known.sum().clamp(min=1) + network.penalty()
        return {"loss": parts["small"] + parts["large"], **parts}

    def forward(self, x: Tensor) -> Tensor:
        """Map (B, 4, H, W) to rows (B, 100, 6)."""
        return torch.stack([self._searched(image[None]) for image in x])

    def _score(self, network: AutoEncoder, image: Tensor, rows: Tensor) -> Tensor:
        """Return the output of the class that holds (N,): what the search ranks by is no probability."""
        parts = [network(self.whitened(image, part[None])[0])[:, 1] for part in rows.split(CHUNK)]
        return torch.cat(parts)

    def _searched(self, image: Tensor) -> Tensor:
        table = image.new_zeros(TOP, 6)
        rows = candidates(image)
        if len(rows):
            picture = prepared(image)
            best = self._score(self.small, picture, rows).topk(min(TOP, len(rows)))[1]
            score = self._score(self.large, picture, rows[best]).sigmoid()
            table[: len(best)] = torch.cat([rows[best], score[:, None]], dim=1)
        return table
