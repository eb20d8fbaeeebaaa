"""A check that a predictor keeps to the protocol: a few canned images, and what is wrong with its answers.

How well it grasps is not judged here: that takes a run.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field, replace
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from grasp_bench.camera import CameraPose, Intrinsics, RgbdImage
from grasp_bench.doctor.frames import slips
from grasp_bench.errors import PredictorError
from grasp_bench.grasps import Grasp, SpatialGrasp, angle_difference, wrap_angle
from grasp_bench.objects.catalog import Catalog
from grasp_bench.predictors.guard import Guard
from grasp_bench.predictors.names import PythonPath, parse
from grasp_bench.predictors.protocol import Predictor, PrivilegedPredictor, begin, checked
from grasp_bench.predictors.use import in_use
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.scenario.seeding import Purpose, stream
from grasp_bench.system.apart import DiedError, Tell, TooLateError, answers

Mask = NDArray[np.bool_]

OBJECT = "flat_screwdriver"
"""Shipped object of the rendered scene: long, so that its grasps have one direction."""
TABLE_DEPTH = 0.55
SLOW, TOO_SLOW = 1.0, 20.0
"""Seconds for one image that are a remark, and that are a failure: a third less than the harness's limit."""
LIMIT = 120.0
"""Seconds that a predictor may take to be made, and for an image shown twice, before it is stopped."""


@dataclass(frozen=True)
class Sample:
    """A canned image.

    Attributes:
        name: name in the table.
        image: what the predictor is given.
        mask: (H, W) where the object is, if there is one.
        camera: where the camera stands, if it stands anywhere.
    """

    name: str
    image: RgbdImage
    mask: Mask | None = None
    camera: CameraPose | None = None


@dataclass(frozen=True)
class Finding:
    """A finding on an answer: a ``failure`` breaks the protocol, a ``remark`` deserves a look."""

    level: Literal["failure", "remark"]
    text: str


@dataclass
class Row:
    """The findings on one image, worst first.

    Attributes:
        sample: the image's name.
        grasps: how many were proposed; None where the answer is unusable.
        seconds: duration of the quicker of two calls.
    """

    sample: str
    grasps: int | None = None
    seconds: float = 0.0
    findings: list[Finding] = field(default_factory=list)

    @property
    def failed(self) -> bool:
        """Whether the protocol is broken."""
        return any(f.level == "failure" for f in self.findings)


# ---------------------------------------------------------------- images


def samples() -> list[Sample]:
    """Return the images: a rendered scene, and what a camera may deliver on a bad day."""
    return [rendered_scene(), *plain_samples()]


def plain_samples() -> list[Sample]:
    """Return the images that are drawn and not rendered."""
    rng = np.random.default_rng(7)
    return [
        _plain("empty table", rng, 480, 640),
        _plain("no depth at all", rng, 480, 640, holes=1.0),
        _plain("60 % holes, a box", rng, 480, 640, holes=0.6, box=True),
        _plain("tiny, 40×32", rng, 32, 40, box=True),
        _plain("upright, 240×424", rng, 424, 240, box=True),
    ]


def rendered_scene() -> Sample:
    """Return a screwdriver on the table as the scenario ``table4`` sees it, noise included."""
    from grasp_bench.scene.builder import compile_scene
    from grasp_bench.scene.rendering import SceneCamera
    from grasp_bench.scene.sensor import sense
    from grasp_bench.scene.world import World
    from grasp_bench.trials.placing import put_down

    scenario, model = load_scenario("table4"), Catalog().load(OBJECT)
    world = World(compile_scene(scenario, model), scenario)
    put_down(world, model, scenario, stream(0, OBJECT, 0, Purpose.POSE))
    camera = SceneCamera(scenario.camera.intrinsics, scenario.camera.pose, "raycast")
    picture = camera.picture(world.model, world.data)
    image = sense(picture, camera.intrinsics, scenario.sensor, stream(0, OBJECT, 0, Purpose.SENSOR))
    mask = (picture.geom >= 0) & (world.model.geom_bodyid[picture.geom] == world.object_body)
    return Sample("rendered scene", image, mask, camera.pose)


def _plain(
    name: str, rng: np.random.Generator, height: int, width: int, holes: float = 0.0, box: bool = False
) -> Sample:
    depth = rng.normal(TABLE_DEPTH, 5e-4, (height, width)).astype(np.float32)
    rgb = rng.integers(140, 150, (height, width, 3), dtype=np.uint8)
    mask = np.zeros((height, width), bool)
    if box:
        mask[int(height * 0.4) : int(height * 0.6), int(width * 0.45) : int(width * 0.55)] = True
        depth[mask] -= 0.04
        rgb[mask] = (180, 60, 40)
    depth[rng.random((height, width)) < holes] = 0
    return Sample(name, RgbdImage(rgb, depth, Intrinsics.from_fov(width, height, math.pi / 2)))


# ---------------------------------------------------------------- checks


def check(
    predictor: Predictor, images: list[Sample], clock: Callable[[], float] = time.perf_counter
) -> list[Row]:
    """Show every image to the predictor twice, with the same random stream.

    Raises:
        PredictorError: for a control that needs the simulator's truth.
    """
    if isinstance(predictor, PrivilegedPredictor):
        raise PredictorError(
            f"{type(predictor).__name__} is a control that needs the simulator's truth; "
            "only predictors that see an image alone can be checked."
        )
    return [_check(predictor, sample, clock) for sample in images]


def check_named(name: str) -> list[Row]:
    """Check a predictor by its name; foreign code is shown the images in a process of its own.

    Where that process ends or hangs, the last row says so, and no further image is shown.

    Raises:
        PredictorError: for a predictor that cannot be made, or a control that needs the simulator's truth.
    """
    if not isinstance(parse(name), PythonPath):
        with in_use(name) as predictor:
            return check(predictor, samples())
    rows: list[Row] = []
    names = ["making it"]
    try:
        for told in answers(_check_there, name, seconds=LIMIT):
            if isinstance(told, list):
                names = told
            else:
                findings = [Finding(**f) for f in told.pop("findings")]
                rows.append(Row(findings=findings, **told))
    except (DiedError, TooLateError) as error:
        how = "ends its process" if isinstance(error, DiedError) else "hangs"
        rows.append(Row(names[len(rows)], findings=[Finding("failure", f"{how} ({error})")]))
    return rows


def _check_there(tell: Tell, name: str) -> None:
    """Check a predictor, in a process of its own: tell the names of the images, and each image's row."""
    with in_use(name) as predictor:
        check(predictor, [])
        images = samples()
        tell([sample.name for sample in images])
        for sample in images:
            tell(asdict(check(predictor, [sample])[0]))


def _check(predictor: Predictor, sample: Sample, clock: Callable[[], float]) -> Row:
    row = Row(sample.name)

    def fail(text: str) -> None:
        row.findings.append(Finding("failure", text))

    image = sample.image
    said: list[Any] = []
    seconds: list[float] = []
    for _ in range(2):
        own = replace(image, rgb=image.rgb.copy(), depth=image.depth.copy())
        start = clock()
        try:
            with Guard("raises"):
                begin(predictor, np.random.default_rng(11))
                said.append(predictor.predict(own))
        except PredictorError as error:
            fail(str(error))
            return row
        seconds.append(clock() - start)
        if not (np.array_equal(own.rgb, image.rgb) and np.array_equal(own.depth, image.depth)):
            fail("changes the image it is given; work on a copy")
            return row
    row.seconds = min(seconds)
    try:
        grasps, again = (checked(a, image.intrinsics) for a in said)
    except PredictorError as error:
        fail(str(error))
        return row
    row.grasps = len(grasps)
    if grasps != again:
        fail(
            "answers differently to the same image; take random numbers from begin(rng), and make the "
            "network deterministic"
        )
    if row.seconds > TOO_SLOW:
        fail(f"takes {row.seconds:.1f} s for an image; a remote predictor has 30 s with its turn waited for")
    elif row.seconds > SLOW:
        row.findings.append(Finding("remark", f"takes {row.seconds:.1f} s for an image"))
    with Guard():
        row.findings += _frames(list(said[0]), grasps, sample)
    row.findings.sort(key=lambda f: f.level != "failure")
    return row


def _frames(raw: list[Any], sound: list[Grasp], sample: Sample) -> list[Finding]:
    """Return what is odd about the units and axes of the numbers."""
    if not raw:
        return []
    failures, remarks = [], []
    flat = [g for g, known in zip(raw, sound, strict=True) if not isinstance(known, SpatialGrasp)]
    steepest = max((abs(float(g.angle)) for g in flat), default=0.0)
    if steepest > 2 * math.pi:
        failures.append(f"an angle of {steepest:.1f}: these look like degrees; angles are radians")
    elif any(wrap_angle(float(g.angle)) != float(g.angle) for g in flat):
        remarks.append("angles outside (−π/2, π/2] are wrapped: a half turn is the same grasp")
    if any(not 0 <= float(g.quality) <= 1 for g in raw):
        remarks.append("qualities outside [0, 1] are clipped")
    if any(float(a.quality) < float(b.quality) for a, b in pairwise(raw)):
        remarks.append("qualities do not descend; the first grasp is taken as the best")
    if flat and max(float(g.width) for g in flat) < 2:
        remarks.append("all openings are narrower than 2 px: are they metres, or fractions of the image?")
    found = [Finding("failure", text) for text in failures] + [Finding("remark", text) for text in remarks]
    if sample.mask is None:
        return found
    if isinstance(best := sound[0], SpatialGrasp):
        assert sample.camera is not None
        found += [
            Finding(level, text)
            for level, text in slips(
                best.pose, sample.image.cloud(sample.mask)[0].astype(np.float64), sample.camera
            )
        ]
        return found
    return found + _on_object(best, sample.mask)


def _on_object(best: Grasp, mask: Mask) -> list[Finding]:
    """Return what is odd about the place and angle of the best grasp on the only object in the picture."""
    if not _hits(mask, best.x, best.y):
        if _hits(mask, best.y, best.x):
            return [Finding("failure", "x and y seem exchanged: x runs along the columns, y down the rows")]
        if _hits(mask, best.x * mask.shape[1], best.y * mask.shape[0]):
            return [Finding("failure", "x and y seem to be fractions of the image; they are pixels")]
        text = f"the best grasp, at ({best.x:.0f}, {best.y:.0f}) px, misses the only object"
        return [Finding("remark", text)]
    across = jaw_direction(mask)
    off = angle_difference(best.angle, across)
    if off > math.radians(60):
        if angle_difference(-best.angle, across) < math.radians(25):
            return [Finding("remark", "the angle seems to run clockwise; it is counter-clockwise as seen")]
        text = "the jaws seem to close along the object: the angle is the direction in which they open"
        return [Finding("remark", text)]
    return []


def _hits(mask: Mask, x: float, y: float, margin: int = 10) -> bool:
    row, column = int(y), int(x)
    rows = slice(max(row - margin, 0), max(row + margin + 1, 0))
    columns = slice(max(column - margin, 0), max(column + margin + 1, 0))
    return bool(mask[rows, columns].any())


def jaw_direction(mask: Mask) -> float:
    """Return the angle [rad] of a blob's shorter principal axis, along which jaws would open across it."""
    rows, columns = np.nonzero(mask)
    _, vectors = np.linalg.eigh(np.cov(np.stack([columns, rows])))
    return wrap_angle(math.atan2(-vectors[1, 0], vectors[0, 0]))
