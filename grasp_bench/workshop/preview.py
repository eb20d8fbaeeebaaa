"""Check and picture object models straight from code, before anything is built.

``python -m grasp_bench.workshop.preview NAME… --out sheet.png`` prints a line of checks an
object and renders each from two sides; names are objects, categories or families.
"""

from __future__ import annotations

import argparse
import sys

import numpy as np
from PIL import Image, ImageDraw

from grasp_bench.system.graphics import with_gl

with_gl()  # before anything imports MuJoCo

from grasp_bench.objects.catalog import VisualPart
from grasp_bench.workshop.model import REGISTRY, ObjectSpec, Part
from grasp_bench.workshop.pictures import TILE, render_parts


def rgb(color: str) -> tuple[float, float, float]:
    """``#rrggbb`` as floats in [0, 1]."""
    return tuple(int(color[i : i + 2], 16) / 255 for i in (1, 3, 5))  # type: ignore[return-value]


def visual_parts(parts: list[Part]) -> list[VisualPart]:
    """Parts in code as the catalog would load them, still in millimetres."""
    return [
        VisualPart(np.asarray(p.mesh.vertices), np.asarray(p.mesh.faces, np.int32), rgb(p.color), 0.5)
        for p in parts
    ]


def check(spec: ObjectSpec, parts: list[Part]) -> str:
    """One line: size, faces, what is wrong."""
    corners = np.array([p.mesh.bounds for p in parts])
    size = corners[:, 1].max(0) - corners[:, 0].min(0)
    faces = sum(len(p.mesh.faces) for p in parts)
    faults = [f"part {i} not watertight" for i, p in enumerate(parts) if not p.mesh.is_watertight]
    faults += [f"part {i} inside out" for i, p in enumerate(parts) if p.mesh.volume <= 0]
    faults += [
        f"part {i} is {p.mesh.body_count} bodies" for i, p in enumerate(parts) if p.mesh.body_count > 1
    ]
    if faces > 6000:
        faults.append(f"{faces} faces > 6000")
    volume = sum(p.mesh.volume for p in parts) / 1000
    return (
        f"{spec.name:28s} {size[0]:6.1f} x {size[1]:6.1f} x {size[2]:6.1f} mm  {faces:5d} faces "
        f"{volume:7.1f} cm3 {spec.mass:6.3f} kg  {'; '.join(faults) or 'ok'}"
    )


def main() -> int:
    """Command line of the preview."""
    import grasp_bench.workshop.household  # noqa: F401  (registers the objects)

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="objects, categories or families; all when none")
    parser.add_argument("--out", help="write a contact sheet (PNG)")
    parser.add_argument("--columns", type=int, default=4)
    args = parser.parse_args()
    specs = [
        s for s in REGISTRY.values() if not args.names or {s.name, s.category, s.family} & set(args.names)
    ]
    tiles: list[Image.Image] = []
    for spec in specs:
        parts = spec.build()
        print(check(spec, parts), flush=True)
        if args.out:
            tile = Image.new("RGB", (2 * TILE, TILE + 18), "white")
            for i, picture in enumerate(render_parts(visual_parts(parts))):
                tile.paste(picture, (i * TILE, 0))
            ImageDraw.Draw(tile).text((4, TILE + 3), f"{spec.name} ({spec.category})", fill="black")
            tiles.append(tile)
    if tiles:
        rows = -(-len(tiles) // args.columns)
        sheet = Image.new("RGB", (args.columns * 2 * TILE, rows * (TILE + 18)), "white")
        for i, tile in enumerate(tiles):
            sheet.paste(tile, (i % args.columns * 2 * TILE, i // args.columns * (TILE + 18)))
        sheet.save(args.out)
    return 0 if specs else 1


if __name__ == "__main__":
    sys.exit(main())
