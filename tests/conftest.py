"""What the tests share: three tiny objects, built once, and no graphics library."""

from __future__ import annotations

import math
import os
import shlex
import shutil
import signal
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

os.environ.setdefault("MUJOCO_GL", "off")  # before anything imports MuJoCo
CACHE = os.environ["GRASP_BENCH_CACHE"] = tempfile.mkdtemp(prefix="grasp-bench-tests-")

import pytest
from html_browsing import BROWSER, PATIENCE
from hypothesis import settings

from grasp_bench.cli import main
from grasp_bench.objects.catalog import Catalog, ObjectModel
from grasp_bench.planning.planner import Planner
from grasp_bench.scenario.cameras import Camera
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.scenario.sections import Scenario
from grasp_bench.workshop import poses
from grasp_bench.workshop.build import build_shape, write_manifest
from grasp_bench.workshop.model import ObjectSpec, Part
from grasp_bench.workshop.poses import build_rest
from grasp_bench.workshop.shapes import box, cylinder, move, sphere

# A shell's background job ignores Ctrl-C, and so would all that the tests start and then interrupt.
signal.signal(signal.SIGINT, signal.default_int_handler)

settings.register_profile("quick", deadline=None, derandomize=True, max_examples=50)
settings.load_profile("quick")


def pytest_unconfigure() -> None:
    """Remove the compiled models of these tests, some hundred megabytes a process."""
    shutil.rmtree(CACHE, ignore_errors=True)


def _block() -> list[Part]:
    """A box of 40 x 80 x 30 mm."""
    return [Part(box(40, 80, 30), "#3366cc", "wood", "convex")]


def _bar() -> list[Part]:
    """A lying bar, 20 mm wide on one half and 36 mm on the other."""
    return [
        Part(move(box(60, 20, 24), x=-30), "#cc8833", "aluminium", "convex"),
        Part(move(box(60, 36, 24), x=30), "#aaaaaa", "aluminium", "convex"),
    ]


def _pot() -> list[Part]:
    """A round pot, wider than it is high, with a knob on its lid."""
    return [
        Part(cylinder(32, 38, segments=40), "#aa3333", "ceramic", "convex"),
        Part(move(sphere(9, segments=16), z=45), "#eeeeee", "ceramic", "convex"),
    ]


TOYS = (
    ObjectSpec("block", "box", "toys", 0.08, "wood", "made up", _block),
    ObjectSpec("bar", "bar", "tools", 0.18, "aluminium", "made up", _bar),
    ObjectSpec("pot", "pot", "kitchen", 0.22, "ceramic", "made up", _pot),
)


class Ended(NamedTuple):
    code: int
    out: str
    err: str


@pytest.fixture
def cli(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> Callable[[str], Ended]:
    """Runs ``grasp-bench`` with a line of arguments in this process, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")

    def call(line: str) -> Ended:
        monkeypatch.setattr("sys.argv", ["grasp-bench", *shlex.split(line)])
        with pytest.raises(SystemExit) as caught:
            main()
        code = caught.value.code
        printed = capsys.readouterr()
        return Ended(code if isinstance(code, int) else 0, printed.out, printed.err)

    return call


@pytest.fixture(scope="session")
def toy_catalog(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of three objects, as ``grasp-bench objects build`` makes them; do not change its files."""
    folder = tmp_path_factory.mktemp("toys")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(poses, "TRIED", 6)  # candidates a pose tried in physics; a few are enough here
        for spec in TOYS:
            build_shape(spec, folder)
            build_rest(folder / spec.name)
    write_manifest(folder)
    return folder


@pytest.fixture(scope="session")
def models(toy_catalog: Path) -> dict[str, ObjectModel]:
    """The three objects by name."""
    catalog = Catalog(toy_catalog)
    return {name: catalog.load(name) for name in catalog.names}


@pytest.fixture(scope="session")
def table4() -> Scenario:
    """The shipped scenario."""
    return load_scenario("table4")


@pytest.fixture(scope="session")
def scenario(table4: Scenario) -> Scenario:
    """The shipped scenario seen through the middle quarter of its image: four times as quick."""
    whole = table4.camera
    focal = whole.intrinsics.fx
    camera = Camera(
        width=320,
        height=240,
        horizontal_fov_deg=math.degrees(2 * math.atan(160 / focal)),
        position=whole.position,
        target=whole.target,
        image_up=whole.image_up,
    )
    return table4.model_copy(update={"camera": camera})


@pytest.fixture(scope="session")
def planner(table4: Scenario) -> Planner:
    """Planner of the shipped scenario; it keeps no state of what it planned."""
    return Planner(table4)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Chromium for the tests of the HTML report; they are skipped where there is none."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
    if BROWSER is None:
        pytest.skip("no Chromium is installed (Debian: chromium)")
    with sync_api.sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=BROWSER, args=["--no-sandbox"], timeout=PATIENCE)
        yield started
        started.close()
