"""Reference grasps of another gripper on objects whose resting poses are known."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from concurrent.futures import Future, as_completed
from pathlib import Path
from typing import Any

from pebble import ProcessPool

from grasp_bench.objects.catalog import Catalog, ObjectModel
from grasp_bench.objects.fitted import fit_file, fitted, write_fit
from grasp_bench.robot.gripper import Gripper
from grasp_bench.robot.grippers import load_gripper
from grasp_bench.scenario.robots import with_gripper
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.floating import compile_floating
from grasp_bench.scene.floating_cup import floating as floating_of
from grasp_bench.system.spawning import SpawnContext
from grasp_bench.workshop.poses import reference_grasps, stand

TIME_LIMIT = 1800.0
"""Seconds that an object may take."""


def fit(model: ObjectModel, gripper: Gripper) -> list[dict[str, Any]]:
    """Return an object's resting poses as in ``object.json``, with the grasps that ``gripper`` has there.

    As with imported objects, only grasps count that open so wide that a noisy image shows it: things that
    just fit between the jaws are no grasp of that gripper.
    """
    scenario = with_gripper(Scenario(name="reference"), gripper.name)
    floating = floating_of(compile_floating(scenario, [model], gripper), scenario, 1, gripper)
    poses = []
    for pose in model.poses:
        placed = stand(floating, pose)
        grasps = [] if placed is None else reference_grasps(floating, *placed, seen=True)
        known = {"quaternion": pose.quaternion.tolist(), "height": pose.height}
        poses.append(known | {"probability": pose.probability, "grasps": grasps})
    return poses


def prepare(
    gripper: Gripper, folder: Path, names: Iterable[str], workers: int = 2
) -> Iterator[tuple[str, str]]:
    """Work out the grasps of ``gripper`` on the named objects of ``folder``; yields (name, outcome) as each
    ends. What was done before, by anyone, is not done again."""
    catalog = Catalog(folder)
    todo = []
    for name in names:
        model = catalog.load(name)
        if fit_file(gripper, model).is_file():
            yield name, _told(fitted(model, gripper))
        else:
            todo.append(name)
    if not todo:
        return
    _ = gripper.shape  # what is wrong with it is told now
    with ProcessPool(max_workers=min(workers, len(todo)), context=SpawnContext()) as pool:
        futures: dict[Future[str], str] = {
            pool.submit(_fit_one, TIME_LIMIT, gripper.name, folder, name): name for name in todo
        }
        for future in as_completed(futures):
            name = futures[future]
            try:
                yield name, future.result()
            except Exception as error:  # one bad object must not stop the others
                yield name, f"failed: {error}"


def _fit_one(gripper_name: str, folder: Path, name: str) -> str:
    gripper, model = load_gripper(gripper_name), Catalog(folder).load(name)
    write_fit(gripper, model, fit(model, gripper))
    return _told(fitted(model, gripper))


def _told(model: ObjectModel) -> str:
    poses = len(model.graspable_poses)
    return f"{poses} of {len(model.poses)} poses" if poses else "cannot be grasped"
