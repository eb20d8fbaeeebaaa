"""Published weights as a client: a network of the GG-CNN lineage, served from its own environment.

This file needs NumPy and torch, and no grasp-bench. Put it beside a checkout of the network's code, with a
module that loads the published weights there (your environment, your trust),

    # loaded.py: a torch.nn.Module that gives quality, cos 2θ, sin 2θ and width
    def network():
        return torch.load("their-weights", weights_only=False)

and let the harness start it with that environment's Python (GG-CNN wants --side 300 --input d besides):

    grasp-bench run --predictor 'cmd: python 08_published_maps.py --make loaded:network --port {port}'

What decides whether published weights look good or bad is the scale: objects must be as large in pixels as
those of the data they were trained on. A pixel of Cornell's images is about 1.4 mm wide on its table; the
crop is as wide here as SIDE such pixels, and is resized to SIDE. Depth is in metres less its mean, clipped
to ±1, holes filled; colour is in [0, 1] less its mean; depth comes first; width is in units of 150 px.
"""

import argparse
import io
import json
import sys
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, HTTPServer
from importlib import import_module
from pathlib import Path

import numpy as np
import torch
from torch.nn.functional import grid_sample, max_pool2d, pad

Network = Callable[[torch.Tensor], tuple[torch.Tensor, ...]]


class Published:
    """Image in, grasps out: crop to Cornell's scale, normalise, run, take the best maxima."""

    def __init__(
        self,
        network: Network,
        side: int,
        kind: str,
        mm_per_pixel: float,
        unit: float,
        scale: float | None = None,
    ) -> None:
        self.network, self.side, self.kind = network, side, kind
        self.mm_per_pixel, self.unit, self.scale = mm_per_pixel, unit, scale

    def predict(self, rgb: np.ndarray, depth: np.ndarray, K: np.ndarray) -> list[dict]:
        if not (depth > 0).any():
            return []
        table = float(np.median(depth[depth > 0]))
        # Pixels of the picture for each of the network's, so that both are as wide on the table.
        scale = self.scale or self.mm_per_pixel / 1000 / (table / K[0, 0])
        colour = torch.from_numpy(rgb.astype(np.float32) / 255).permute(2, 0, 1)
        x = self.cropped(torch.cat([filled(depth)[None], colour]), scale)
        x[0] = (x[0] - x[0].mean()).clamp(-1, 1)
        x[1:] -= x[1:].mean()
        shown = x[:1] if self.kind == "d" else x[1:] if self.kind == "rgb" else x
        with torch.inference_mode():
            quality, cos, sin, width = (
                smooth(m.reshape(1, 1, self.side, self.side)) for m in self.network(shown[None])
            )
        angle = 0.5 * torch.atan2(sin, cos)
        height, wide = depth.shape
        grasps = []
        for row, column in maxima(quality[0, 0], 10):
            grasps.append(
                {
                    "x": (column + 0.5 - self.side / 2) * scale + wide / 2,
                    "y": (row + 0.5 - self.side / 2) * scale + height / 2,
                    "angle": float(angle[0, 0, row, column]),
                    "width": float(width[0, 0, row, column].clamp(0, 1)) * self.unit * scale,
                    "quality": float(quality[0, 0, row, column].clamp(0, 1)),
                }
            )
        return [g for g in grasps if 0 <= g["x"] < wide and 0 <= g["y"] < height and g["width"] > 0]

    def cropped(self, image: torch.Tensor, scale: float) -> torch.Tensor:
        """The square about the middle, ``side × scale`` pixels wide, sampled with ``side`` pixels."""
        height, width = image.shape[1:]
        at = (torch.arange(self.side) + 0.5 - self.side / 2) * scale
        y, x = torch.meshgrid(at * 2 / height, at * 2 / width, indexing="ij")
        grid = torch.stack([x, y], -1)[None]
        return grid_sample(image[None], grid, padding_mode="border", align_corners=False)[0]


def filled(depth: np.ndarray) -> torch.Tensor:
    """Depth whose holes have the mean of what is measured about them."""
    d = torch.from_numpy(np.array(depth, np.float32))[None, None]
    while not bool((d > 0).all()):
        known = (d > 0).float()
        near = torch.nn.functional.avg_pool2d(pad(d * known, (2, 2, 2, 2)), 5, 1)
        count = torch.nn.functional.avg_pool2d(pad(known, (2, 2, 2, 2)), 5, 1)
        d = torch.where(known > 0, d, near / count.clamp(min=1e-6))
    return d[0, 0]


def smooth(maps: torch.Tensor, sigma: float = 2.0) -> torch.Tensor:
    """A Gaussian filter."""
    at = torch.arange(-6, 7, dtype=torch.float32)
    line = torch.exp(-(at**2) / (2 * sigma**2))
    kernel = (line / line.sum())[:, None] * (line / line.sum())[None]
    return torch.nn.functional.conv2d(pad(maps.float(), (6, 6, 6, 6), mode="replicate"), kernel[None, None])


def maxima(quality: torch.Tensor, count: int, apart: int = 10) -> list[tuple[int, int]]:
    """Rows and columns of the highest local maxima."""
    highest = max_pool2d(quality[None, None], 2 * apart + 1, 1, apart)[0, 0]
    at = torch.nonzero(quality >= highest)
    order = quality[at[:, 0], at[:, 1]].argsort(descending=True)[:count]
    return [(int(r), int(c)) for r, c in at[order]]


class Handler(BaseHTTPRequestHandler):
    predictor: Published
    told: dict

    def do_GET(self) -> None:
        self.answer(200, {"protocol": 1, **self.told})

    def do_POST(self) -> None:
        body = self.rfile.read(int(self.headers["Content-Length"]))
        try:
            sent = np.load(io.BytesIO(body), allow_pickle=False)
            self.answer(200, {"grasps": self.predictor.predict(sent["rgb"], sent["depth"], sent["K"])})
        except Exception as error:
            self.answer(500, {"error": f"{type(error).__name__}: {error}"})

    def answer(self, status: int, content: dict) -> None:
        body = json.dumps(content).encode()
        self.send_response(status)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: object) -> None:
        """Not a line for every image."""


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--make", required=True, help="MODULE:FUNCTION that returns the network")
    parser.add_argument("--side", type=int, default=224, help="side of the network's input [px]")
    parser.add_argument(
        "--input", choices=("d", "rgb", "drgb"), default="drgb", help="channels, in this order"
    )
    parser.add_argument(
        "--mm-per-pixel", type=float, default=1.4, help="of the training images, on the table"
    )
    parser.add_argument(
        "--scale", type=float, help="pixels of the picture for one of the network's, whatever they show"
    )
    parser.add_argument("--width-unit", type=float, default=150.0, help="pixels for a width of 1")
    parser.add_argument("--port", type=int, default=8000)
    given = parser.parse_args()
    sys.path.insert(0, str(Path.cwd()))
    module, _, function = given.make.partition(":")
    made = getattr(import_module(module), function)()
    if hasattr(made, "eval"):
        made.eval()
    Handler.predictor = Published(
        made, given.side, given.input, given.mm_per_pixel, given.width_unit, given.scale
    )
    Handler.told = {
        "predictor": given.make,
        "side": given.side,
        "input": given.input,
        "mm": given.mm_per_pixel,
    }
    HTTPServer(("127.0.0.1", given.port), Handler).serve_forever()
