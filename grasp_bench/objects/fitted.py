"""Objects as another gripper than the reference one can grasp them.

The shipped reference grasps are those of the reference gripper. For any other, `grasp-bench grippers prepare`
works out its own in the same resting poses, and keeps them in the user's cache, under the digests of gripper
and object.
"""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

from grasp_bench.errors import AssetError
from grasp_bench.objects.catalog import Catalog, ObjectModel, load_details
from grasp_bench.robot.gripper import Gripper
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.system import cache

VERSION = 1
"""Raise this when fitted grasps would come out differently: all are worked out again then."""
LISTED = 8
"""Names that a message lists at most."""


def is_reference(gripper: Gripper) -> bool:
    """Return whether the objects' own reference grasps are those of ``gripper``."""
    return gripper.folder.resolve() == PARALLEL_85.folder.resolve()


def fit_file(gripper: Gripper, model: ObjectModel) -> Path:
    """Return where the grasps of ``gripper`` on an object are kept."""
    mark = hashlib.sha256(f"{VERSION}|{gripper.digest}|{model.digest}".encode()).hexdigest()[:32]
    return cache.folder().parent / "grippers" / f"{mark}.json"


def write_fit(gripper: Gripper, model: ObjectModel, poses: list[dict[str, Any]]) -> None:
    """Keep the poses of an object, with the grasps that ``gripper`` has there."""
    path = fit_file(gripper, model)
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile("w", dir=path.parent, suffix=".part", delete=False) as file:
        json.dump({"gripper": gripper.name, "object": model.name, "poses": poses}, file, indent=1)
    os.replace(file.name, path)


def fitted(model: ObjectModel, gripper: Gripper) -> ObjectModel:
    """Return an object with the reference grasps that ``gripper`` has on it; none where it cannot grasp it.

    Raises:
        AssetError: where they were not worked out yet, or cannot be read.
    """
    if is_reference(gripper):
        return model
    path = fit_file(gripper, model)
    try:
        poses = json.loads(path.read_text())["poses"]
        facts = {k: getattr(model, k) for k in ("name", "category", "mass", "friction")}
        details = facts | {"inertia": model.inertia.tolist(), "poses": poses}
        return replace(model, poses=load_details(model.folder, details).poses)
    except FileNotFoundError:
        raise AssetError(unprepared(gripper, [model.name])) from None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise AssetError(f"{path} is damaged ({error}); remove it and prepare the gripper again.") from error


def graspable(catalog: Catalog, names: Iterable[str], gripper: Gripper) -> tuple[list[str], list[str]]:
    """Part objects into those that ``gripper`` can grasp in some resting pose, and those it cannot in any.

    Raises:
        AssetError: where some were not prepared.
    """
    chosen = list(names)
    if is_reference(gripper):
        return chosen, []
    models = [catalog.load(n) for n in chosen]
    if missing := [m.name for m in models if not fit_file(gripper, m).is_file()]:
        raise AssetError(unprepared(gripper, missing))
    can = {m.name for m in models if fitted(m, gripper).graspable_poses}
    return [n for n in chosen if n in can], [n for n in chosen if n not in can]


def unprepared(gripper: Gripper, names: list[str]) -> str:
    """Say that objects were not prepared for a gripper, and what to do."""
    shown = ", ".join(names[:LISTED]) + (" …" if len(names) > LISTED else "")
    which = "1 object is" if len(names) == 1 else f"{len(names)} objects are"
    return (
        f"{which} not prepared for gripper {gripper.name} yet ({shown}): its reference grasps on them are "
        f"unknown. Run `grasp-bench grippers prepare {gripper.name}`, with --objects as in the run."
    )
