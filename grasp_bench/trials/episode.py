"""Clearing a cluttered table: many objects at once, taken away one after another.

The situation of Figure 6 of the HTC-Grasp paper, tried out in physics. An episode puts several objects
down and then repeats the steps of a single trial (settle → sense → predict → plan → execute → judge) until
the table is empty or too many attempts in a row have failed. What was carried away is removed; what was lost
stays where it fell.

An episode is one trial of a run, so it is resumed, sharded and timed like any other; its record holds its
attempts under ``clutter``. To those who watch, an attempt is a trial: it has an image, grasps, a plan, and a
world of its own, of what is still on the table.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from grasp_bench.camera import RgbdImage
from grasp_bench.errors import PredictorError
from grasp_bench.grasps import Grasp
from grasp_bench.objects.catalog import Catalog, ObjectModel
from grasp_bench.planning.choice import choose_grasp
from grasp_bench.planning.seen import SeenScene
from grasp_bench.predictors.protocol import GroundTruth, Predictor, PrivilegedPredictor, answer, checked
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scenario.seeding import Purpose, stream
from grasp_bench.scene.builder import compile_mjcf, compose_many, object_name
from grasp_bench.scene.rendering import Picture, SceneCamera
from grasp_bench.scene.world import UnstableError, World
from grasp_bench.trials.attempt import Clock, Trial, TrialRecord, Workcell, execute, random_pose, take_picture

if TYPE_CHECKING:
    from grasp_bench.media.recorders import TrialRecorder

Floats = NDArray[np.float64]

LAYOUTS = 5
"""Layouts tried before an episode whose objects never come to rest is unstable."""
PLACES = 40
"""Places tried beside the others before an object is dropped onto them."""
GAP = 0.004
"""Room between footprints where there is some [m]."""


@dataclass(frozen=True)
class Resting:
    """An object on the table: position (3,) [m] and quaternion w, x, y, z."""

    model: ObjectModel
    position: Floats
    quaternion: Floats


@dataclass(frozen=True)
class Attempt:
    """A finished attempt: all that was made on its way, what is left on the table, and what it took away."""

    done: Trial
    left: list[Resting]
    removed: list[str]


@dataclass
class Episode:
    """A finished episode: its record as plain data, and the seconds of each phase."""

    record: dict[str, Any]
    clock: Clock


def run_episode(
    cell: Workcell,
    catalog: Catalog,
    predictor: Predictor,
    lead: str,
    *,
    trial: int,
    attempt: int,
    seed: int,
    watch: Callable[[int], TrialRecorder | None] = lambda number: None,
) -> Episode:
    """Clear one table.

    Args:
        cell: scenario, planner and camera.
        catalog: of all objects.
        predictor: proposes grasps.
        lead: an object that is on the table; the others are drawn at random.
        trial: number in the run.
        attempt: how many episodes of the run had this lead before.
        seed: of the run.
        watch: what shall watch the attempt of a number (from 0), and keep something of it as it ends.
    """
    scenario = cell.scenario
    assert scenario.clutter is not None
    clock = Clock()
    rng = stream(seed, lead, attempt, Purpose.CLUTTER)
    others = [n for n in catalog.chosen(scenario.objects.names) if n != lead]
    count = min(int(rng.integers(scenario.clutter.fewest, scenario.clutter.most + 1)), len(others) + 1)
    names = [lead, *(others[i] for i in rng.permutation(len(others))[: count - 1])]
    attempts: list[dict[str, Any]] = []
    steps = 0
    outcome, detail = Outcome.SUCCESS, ""
    left: list[Resting] = []
    try:
        with clock.phase("settle"):
            left = lay_out([catalog.load(n) for n in names], scenario, rng)
        failures = 0
        while left and failures < scenario.clutter.failures:
            recorder = watch(len(attempts))
            ended = _attempt(
                cell, left, predictor, clock, f"{lead}/{len(attempts)}", trial, attempt, seed, recorder
            )
            if recorder is not None:
                with clock.phase("media"):
                    recorder.keep(ended.done, predictor)
            left, record = ended.left, ended.done.record
            attempts.append({"attempt": len(attempts), **_shortened(record), "removed": ended.removed})
            steps += record.sim_steps
            failures = 0 if record.success else failures + 1
            if not record.success:
                outcome, detail = record.outcome, record.detail
            if record.outcome in (Outcome.UNSTABLE, Outcome.ERROR):
                break
    except UnstableError as error:
        left = left or [Resting(catalog.load(n), np.zeros(3), np.zeros(4)) for n in names]
        outcome, detail = Outcome.UNSTABLE, str(error)
    cleared = count - len(left)
    if not left:
        outcome, detail = Outcome.SUCCESS, ""
    else:
        detail = f"{len(left)} of {count} objects left; at last: {detail or outcome}"
    category = catalog.entries[lead]["category"]
    whole = TrialRecord(trial, lead, category, seed, outcome, detail, sim_steps=steps)
    told = {"objects": names, "cleared": cleared, "attempts": attempts}
    return Episode(whole.to_json() | {"clutter": told}, clock)


def _attempt(
    cell: Workcell,
    left: list[Resting],
    predictor: Predictor,
    clock: Clock,
    name: str,
    trial: int,
    attempt: int,
    seed: int,
    observer: Callable[[World], None] | None,
) -> Attempt:
    """Try to take something away, once."""
    scenario, nominal = cell.scenario, cell.camera
    camera = cell.true_camera(seed, name, attempt)
    with clock.phase("build"):
        world = _world(left, scenario)
    target = 0
    measured: dict[str, Any] = {}
    made: dict[str, Any] = {}

    def ended(outcome: Outcome, detail: str, after: list[Resting], removed: Sequence[str] = ()) -> Attempt:
        model = left[target].model
        record = TrialRecord(
            trial, model.name, model.category, seed, outcome, detail, sim_steps=world.steps, **measured
        )
        return Attempt(Trial(record, clock, world=world, **made), after, list(removed))

    try:
        with clock.phase("settle"):
            world.settle()
        at_rest = _resting(world, left)
        picture, image = take_picture(
            world, camera, scenario, stream(seed, name, attempt, Purpose.SENSOR), clock
        )
        made["image"] = image
        with clock.phase("predict"):
            grasps = propose(
                predictor, image, world, left, camera, stream(seed, name, attempt, Purpose.PREDICTOR)
            )
        made["grasps"] = grasps
        if not grasps:
            return ended(Outcome.NO_GRASP, "the predictor proposed no grasp", at_rest)
        with clock.phase("plan"):
            scene = SeenScene(image, nominal.pose, nominal.directions)
            rank, plan, outcome, why = choose_grasp(cell.planner, scene, grasps)
        target = _meant(grasps[rank], picture, world, camera)
        measured |= {"grasp": grasps[rank], "rank": rank}
        if plan is None:
            return ended(outcome, why, at_rest)
        made["plan"] = plan
        measured["pose"] = plan.pose
        world.aim(target)
        world.observer = observer
        with clock.phase("execute"):
            outcome, why = execute(world, plan, measured)
        target = world.target
        lifted = scenario.success.minimum_lift
        gone = [i for i in range(len(left)) if i == target or world.rise(i) > lifted]
        gone = gone if outcome == Outcome.SUCCESS else []
        after = [r for i, r in enumerate(_resting(world, left)) if i not in gone]
        return ended(outcome, why, after, [left[i].model.name for i in gone])
    except UnstableError as error:
        return ended(Outcome.UNSTABLE, str(error), left)
    except PredictorError as error:
        return ended(Outcome.ERROR, str(error), left)


def _world(left: list[Resting], scenario: Scenario) -> World:
    """The objects where they rest, and the arm at home."""
    model = compile_mjcf(compose_many(scenario, [r.model for r in left]))
    world = World(
        model, scenario, [object_name(i) for i in range(len(left))], [r.model.friction for r in left]
    )
    for i, resting in enumerate(left):
        world.aim(i)
        world.place_object(resting.position, resting.quaternion)
    return world


def _resting(world: World, left: list[Resting]) -> list[Resting]:
    return [
        Resting(r.model, world.data.xpos[body].copy(), world.data.xquat[body].copy())
        for r, body in zip(left, world.bodies, strict=True)
    ]


def lay_out(models: Sequence[ObjectModel], scenario: Scenario, rng: np.random.Generator) -> list[Resting]:
    """Objects at rest on the table, in graspable poses where they were put; piled where there was no room.

    Each is put down in a random graspable resting pose at a random place beside the others, or, when there
    is none, dropped onto them. Layouts that do not come to rest are drawn again.

    Raises:
        UnstableError: when none of several layouts came to rest.
    """
    why = ""
    for _ in range(LAYOUTS):
        placed = _placed(models, scenario, rng)
        world = _world(placed, scenario)
        try:
            world.settle()
        except UnstableError as error:
            why = str(error)
            continue
        return _resting(world, placed)
    raise UnstableError(f"in {LAYOUTS} layouts: {why}")


def _placed(models: Sequence[ObjectModel], scenario: Scenario, rng: np.random.Generator) -> list[Resting]:
    import mujoco
    from shapely import Polygon
    from shapely.affinity import translate

    assert scenario.clutter is not None
    centre, spread = np.array(scenario.table.center), np.array(scenario.clutter.workspace)
    placed: list[Resting] = []
    taken: list[tuple[Polygon, float]] = []
    matrix = np.zeros(9)
    for model in models:
        height, quaternion = random_pose(model, rng)
        mujoco.mju_quat2Mat(matrix, quaternion)
        cloud = np.vstack(model.hulls) @ matrix.reshape(3, 3).T
        outline = Polygon(cloud[ConvexHull(cloud[:, :2]).vertices, :2]).buffer(GAP)
        place, below = centre, [0.0]
        for _ in range(PLACES):
            place = centre + rng.uniform(-1, 1, 2) * spread
            here = translate(outline, *place)
            below = [top for other, top in taken if here.intersects(other)]
            if not below:
                break
        base = max(below, default=0.0)
        z = base + height + scenario.settling.clearance
        taken.append((translate(outline, *place), z + float(cloud[:, 2].max())))
        placed.append(Resting(model, np.array([*place, z]), quaternion))
    return placed


def propose(
    predictor: Predictor,
    image: RgbdImage,
    world: World,
    left: list[Resting],
    camera: SceneCamera,
    rng: np.random.Generator,
) -> list[Grasp]:
    """A predictor's grasps, best first.

    A control that sees the truth is asked about every object; its grasps are ranked round by round, the best
    of each object first, higher objects before lower ones.

    Raises:
        PredictorError: as :func:`grasp_bench.predictors.protocol.answer`.
    """
    truths = []
    for i, resting in enumerate(left):
        world.aim(i)
        truths.append(GroundTruth(resting.model, *world.object_pose, camera.pose, camera.intrinsics))
    if not isinstance(predictor, PrivilegedPredictor):
        return answer(predictor, image, truths[0], rng)
    begin = getattr(predictor, "begin", None)
    if begin is not None:
        begin(rng)
    size = image.intrinsics
    found: list[tuple[int, float, Grasp]] = []
    for truth in truths:
        inside = [
            g
            for g in predictor.predict_from_truth(image, truth)
            if 0 <= g.x <= size.width and 0 <= g.y <= size.height
        ]
        found += [(turn, -float(truth.position[2]), g) for turn, g in enumerate(inside)]
    return checked([g for *_, g in sorted(found, key=lambda f: f[:2])], size)


def _meant(grasp: Grasp, picture: Picture, world: World, camera: SceneCamera) -> int:
    """Index of the object under a grasp's centre, or of the nearest one where there is none."""
    height, width = picture.geom.shape
    row, column = min(int(grasp.y), height - 1), min(int(grasp.x), width - 1)
    geom = int(picture.geom[row, column])
    if geom >= 0 and (body := int(world.model.geom_bodyid[geom])) in world.bodies:
        return world.bodies.index(body)
    pixels = camera.intrinsics.project(camera.pose.to_camera(world.data.xpos[world.bodies]))
    return int(np.argmin(np.linalg.norm(pixels - [grasp.x, grasp.y], axis=1)))


def _shortened(record: TrialRecord) -> dict[str, Any]:
    """An attempt's record without what the episode says already."""
    return {k: v for k, v in record.to_json().items() if k not in ("trial", "seed")}
