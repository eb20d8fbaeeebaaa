"""Check and picture object models straight from code, before anything is built.

``python -m grasp_bench.objects.preview NAME… --out sheet.png`` prints a line of checks an
object and renders each from two sides; names are objects, categories or families.
"""

from __future__ import annotations

import argparse
import sys

import mujoco
import numpy as np
from PIL import Image, ImageDraw

from grasp_bench.objects.model import REGISTRY, ObjectSpec, Part

TILE = 256


def rgb(color: str) -> tuple[float, float, float]:
    """``#rrggbb`` as floats in [0, 1]."""
    return tuple(int(color[i:i + 2], 16) / 255 for i in (1, 3, 5))  # type: ignore[return-value]


def parts_model(parts: list[Part], extent: float) -> mujoco.MjModel:
    """A MuJoCo model that shows ``parts`` (millimetres) on a grey floor, scaled to 1/``extent``."""
    spec = mujoco.MjSpec()
    spec.visual.global_.offwidth = spec.visual.global_.offheight = 2 * TILE
    spec.visual.headlight.ambient = [0.45, 0.45, 0.45]
    spec.visual.headlight.diffuse = [0.45, 0.45, 0.45]
    spec.visual.quality.shadowsize = 2048
    low = min(p.mesh.bounds[0][2] for p in parts) / extent
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[5, 5, 0.1], pos=[0, 0, low],
                            rgba=[0.93, 0.93, 0.91, 1])
    spec.worldbody.add_light(pos=[-1.5, -2, 4], dir=[0.35, 0.45, -0.9], diffuse=[0.5, 0.5, 0.5],
                             castshadow=True)
    for i, part in enumerate(parts):
        spec.add_mesh(name=f"p{i}", uservert=(np.asarray(part.mesh.vertices) / extent).ravel(),
                      userface=np.asarray(part.mesh.faces).ravel(),
                      inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=f"p{i}",
                                rgba=[*rgb(part.color), 1], contype=0, conaffinity=0)
    return spec.compile()


def render_parts(parts: list[Part], views: tuple[tuple[float, float], ...] = ((-35, 130), (-60, 220)),
                 size: int = TILE) -> list[Image.Image]:
    """Pictures (size × size) of ``parts`` from each (elevation, azimuth) in degrees."""
    corners = np.array([p.mesh.bounds for p in parts])
    low, high = corners[:, 0].min(0), corners[:, 1].max(0)
    extent = float(np.linalg.norm(high - low))
    model = parts_model(parts, extent)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    pictures = []
    with mujoco.Renderer(model, 2 * size, 2 * size) as renderer:
        for elevation, azimuth in views:
            camera = mujoco.MjvCamera()
            camera.lookat[:] = (low + high) / 2 / extent
            camera.distance, camera.elevation, camera.azimuth = 1.35, elevation, azimuth
            renderer.update_scene(data, camera)
            pictures.append(Image.fromarray(renderer.render()).resize((size, size), Image.Resampling.LANCZOS))
    return pictures


def check(spec: ObjectSpec, parts: list[Part]) -> str:
    """One line: size, faces, what is wrong."""
    corners = np.array([p.mesh.bounds for p in parts])
    size = corners[:, 1].max(0) - corners[:, 0].min(0)
    faces = sum(len(p.mesh.faces) for p in parts)
    faults = [f"part {i} not watertight" for i, p in enumerate(parts) if not p.mesh.is_watertight]
    faults += [f"part {i} inside out" for i, p in enumerate(parts) if p.mesh.volume <= 0]
    faults += [f"part {i} is {p.mesh.body_count} bodies" for i, p in enumerate(parts) if p.mesh.body_count > 1]
    if faces > 6000:
        faults.append(f"{faces} faces > 6000")
    volume = sum(p.mesh.volume for p in parts) / 1000
    return (f"{spec.name:28s} {size[0]:6.1f} x {size[1]:6.1f} x {size[2]:6.1f} mm  {faces:5d} faces "
            f"{volume:7.1f} cm3 {spec.mass:6.3f} kg  {'; '.join(faults) or 'ok'}")


def main() -> int:
    """Command line of the preview."""
    import grasp_bench.objects.household  # noqa: F401  (registers the objects)

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="objects, categories or families; all when none")
    parser.add_argument("--out", help="write a contact sheet (PNG)")
    parser.add_argument("--columns", type=int, default=4)
    args = parser.parse_args()
    specs = [s for s in REGISTRY.values()
             if not args.names or {s.name, s.category, s.family} & set(args.names)]
    tiles: list[Image.Image] = []
    for spec in specs:
        parts = spec.build()
        print(check(spec, parts), flush=True)
        if args.out:
            tile = Image.new("RGB", (2 * TILE, TILE + 18), "white")
            for i, picture in enumerate(render_parts(parts)):
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
