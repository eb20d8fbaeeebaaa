"""Makes the pictures of README and docs.

``python scripts/make_images.py [arm trial objects grid side gallery figures]``
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from grasp_bench.system.graphics import with_gl

with_gl()  # before anything imports MuJoCo

import cv2  # noqa: E402
import mujoco  # noqa: E402
import numpy as np  # noqa: E402
from PIL import Image, ImageDraw  # noqa: E402

from grasp_bench.learning.evaluation.compare import compare, images  # noqa: E402
from grasp_bench.objects.catalog import Catalog, folder_of  # noqa: E402
from grasp_bench.predictors import load_predictor  # noqa: E402
from grasp_bench.predictors.shipped import SHIPPED  # noqa: E402
from grasp_bench.scenario.reading import load_scenario  # noqa: E402
from grasp_bench.scene.builder import compile_scene  # noqa: E402
from grasp_bench.scene.world import World  # noqa: E402
from grasp_bench.trials.trial import run_trial  # noqa: E402
from grasp_bench.trials.workcell import Workcell  # noqa: E402
from grasp_bench.workshop.gallery import gallery_sheet  # noqa: E402
from grasp_bench.workshop.model import FAMILIES  # noqa: E402
from grasp_bench.workshop.pictures import contact_sheet  # noqa: E402

ROOT = Path(__file__).parents[1]
IMAGES = ROOT / "docs" / "images"
FIGURE_TRIALS = (12, 37, 100, 151)
"""Trials of the reference run of ``htc-grasp`` whose pictures ``figures`` shows."""


class Photographer:
    """Takes pictures of a world from a fixed side view."""

    def __init__(
        self,
        size: tuple[int, int],
        lookat: tuple[float, float, float],
        distance: float,
        azimuth: float = 140,
        elevation: float = -22,
    ) -> None:
        self.size = size
        self.camera = mujoco.MjvCamera()
        self.camera.lookat[:] = lookat
        self.camera.distance, self.camera.azimuth, self.camera.elevation = distance, azimuth, elevation
        self._renderer: mujoco.Renderer | None = None

    def shoot(self, world: World) -> Image.Image:
        """One picture."""
        renderer = self._renderer
        if renderer is None:
            width, height = self.size
            glob = world.model.vis.global_
            glob.offwidth, glob.offheight = 2 * width, 2 * height
            world.model.vis.headlight.ambient[:] = 0.35
            renderer = self._renderer = mujoco.Renderer(world.model, 2 * height, 2 * width)
        option = mujoco.MjvOption()
        option.geomgroup[:] = [1, 1, 1, 0, 0, 0]
        renderer.update_scene(world.data, self.camera, option)
        return Image.fromarray(renderer.render()).resize(self.size, Image.Resampling.LANCZOS)


def arm() -> None:
    """The EC66 with its gripper."""
    scenario = load_scenario("table4")
    world = World(compile_scene(scenario, Catalog().load("coffee_mug")), scenario)
    world.data.qpos[:6] = np.radians([-15, -70, 90, -110, 90, 15])
    world.place_object(np.array([0.55, 0.18, 0.05]), np.array([1.0, 0, 0, 0]))
    mujoco.mj_forward(world.model, world.data)
    Photographer((720, 540), (0.25, 0.05, 0.25), 1.35).shoot(world).save(IMAGES / "arm.png")


def trial() -> None:
    """A trial in five pictures: what the camera saw, then approach, grip, lift and hold."""
    scenario = load_scenario("table4")
    model = Catalog().load("coffee_mug")
    photographer = Photographer((640, 533), (0.42, 0.1, 0.14), 1.05, 150)
    frames: list[Image.Image] = []
    count = 0

    def observe(world: World) -> None:
        nonlocal count
        if count % 25 == 0:
            frames.append(photographer.shoot(world))
        count += 1

    done = run_trial(
        Workcell(scenario), model, load_predictor("htc-grasp"), trial=0, attempt=0, seed=0, observer=observe
    )
    assert done.image is not None
    assert done.record.grasp is not None
    corners = np.round(done.record.grasp.rectangle(16)).astype(np.int32)
    seen = cv2.polylines(done.image.rgb.copy(), [corners], True, (230, 40, 40), 1, cv2.LINE_AA)
    views = [Image.fromarray(seen[90:390, 140:500])]
    shown = [frames[round(share * (len(frames) - 1))] for share in (0.2, 0.42, 0.62, 1.0)]
    views += [f.resize((360, 300), Image.Resampling.LANCZOS) for f in shown]
    strip = Image.new("RGB", (sum(v.width for v in views) + 8 * 4, 324), "white")
    draw = ImageDraw.Draw(strip)
    for i, (view, name) in enumerate(
        zip(views, ("seen, with its grasp", "approach", "grip", "lift", "hold"), strict=True)
    ):
        strip.paste(view, (i * 368, 0))
        draw.text((i * 368 + 6, 306), name, fill="black")
    strip.save(IMAGES / "trial.png")
    # every second picture, all in the colours of one that shows everything
    palette = frames[len(frames) // 2].quantize(96)
    film = [f.quantize(palette=palette, dither=Image.Dither.NONE) for f in frames[::2]]
    film[0].save(IMAGES / "trial.gif", save_all=True, append_images=film[1:], duration=200, loop=0)


def objects() -> None:
    """Contact sheet of all objects."""
    catalog = Catalog()
    sheet = contact_sheet([catalog.load(n) for n in catalog.names], columns=12)
    sheet.convert("RGB").save(IMAGES / "objects.jpg", quality=85)


def grid() -> None:
    """Contact sheet of the objects of graded difficulty: a row a size, a column a grade."""
    catalog = Catalog()
    names = sorted(catalog.select("grid"), key=lambda n: (n[-1], n))
    sheet = contact_sheet([catalog.load(n) for n in names], columns=7)
    sheet.convert("RGB").save(IMAGES / "grid.jpg", quality=85)


def side() -> None:
    """Contact sheet of the things that only a hand from the side can hold, upright as in side-grasps."""
    catalog = Catalog(folder_of("side-objects"))
    sheet = contact_sheet([catalog.load(n) for n in catalog.names], columns=6)
    sheet.convert("RGB").save(IMAGES / "side-objects.jpg", quality=85)


def gallery() -> None:
    """Every object from two sides with its convex pieces and its grasp, a sheet a family."""
    catalog = Catalog()
    for family in FAMILIES:
        names = sorted(
            (n for n, e in catalog.entries.items() if e["family"] == family),
            key=lambda n: (catalog.entries[n]["category"], n),
        )
        sheet = gallery_sheet([catalog.load(n) for n in names])
        sheet.save(IMAGES / f"gallery-{family}.webp", quality=82, method=6)


def figures() -> None:
    """The paper's Figures 4 to 6: maps and best grasps of three networks on a dozen images.

    Four recorded trials, three generated scenes of either style, and two attempts of an episode of clutter;
    no real image, as those may not be passed on.
    """
    last = "tf-grasp" if SHIPPED["tf-grasp"].available else "tf-grasp-release"
    used = {name: load_predictor(name) for name in ("htc-grasp", "gr-convnet", last)}
    command = [sys.executable, "-m", "grasp_bench.cli"]
    with TemporaryDirectory() as folder:
        home = Path(folder)
        shown = {
            "trials": [s for n in FIGURE_TRIALS for s in images(ROOT / "results/reference/htc-grasp", 1, n)]
        }
        for style in ("plain", "camera-like"):
            synth = ["data", "synth", "--scenes", "3", "--seed", "77", "--tries", "1", "--style", style]
            subprocess.run([*command, *synth, "--out", home / style], check=True)
            shown[style] = list(images(home / style, 3))
        run = ["run", "--scenario", "clutter", "--trials", "1", "--quiet", "--workers", "1"]
        subprocess.run([*command, *run, "--out", home / "clutter"], check=True)
        shown["clutter"] = list(images(home / "clutter", 1, 0))[:4:2]
        for kind, of_kind in shown.items():
            sheet = Image.fromarray(compare(of_kind, used))
            sheet.save(IMAGES / f"figure-{kind}.webp", quality=75, method=6)


if __name__ == "__main__":
    IMAGES.mkdir(exist_ok=True)
    makers = {m.__name__: m for m in (arm, trial, objects, grid, side, gallery, figures)}
    for name in sys.argv[1:] or makers:
        makers[name]()
