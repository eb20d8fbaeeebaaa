"""Builds the objects and the scenario side-grasps: ``python scripts/make_side_objects.py``.

Writes assets/side-objects from the models in grasp_bench/workshop/side_objects.py, and
scenarios/side-grasps.yaml with the upright pose of each that cannot be grasped from above, if a
grasp from another direction held there.
"""

from __future__ import annotations

from pathlib import Path

from grasp_bench.objects.catalog import Catalog
from grasp_bench.predictors.reference import reference_poses
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.workshop.build import write_manifest
from grasp_bench.workshop.side_objects import THINGS, build

ROOT = Path(__file__).resolve().parents[1]
FOLDER, SCENARIO = ROOT / "assets" / "side-objects", ROOT / "scenarios" / "side-grasps.yaml"
UPRIGHT = 0.95
HEAD = """\
# Things that two fingers from above cannot hold: wide and closed at the top, narrow where a hand from the
# side gets at them. Each stands upright, in the pose of that number; on its side it could be held from above.
extends: table4
name: side-grasps
description: Things that only a hand from the side can hold, for grasps in six degrees of freedom.

objects:
  folder: side-objects
"""


def main() -> None:
    for name in THINGS:
        build(name, FOLDER)
    write_manifest(FOLDER)
    catalog, poses = Catalog(FOLDER), {}
    for name in catalog.names:
        model = catalog.load(name)
        for i, pose in enumerate(model.poses):
            if pose.rotation[2, 2] < UPRIGHT:
                continue
            held = len(reference_poses(model, i, PARALLEL_85))
            print(f"{name}: pose {i}, {len(pose.grasps)} grasps from above, {held} from any direction")
            if held and not pose.grasps:
                poses.setdefault(name, i)
    names = [f"    {name}: {' '.join(name.split('_'))}, to be held below its top\n" for name in poses]
    upright = [f"    {name}: [{i}]\n" for name, i in poses.items()]
    SCENARIO.write_text(f"{HEAD}  names:\n{''.join(names)}  poses:\n{''.join(upright)}", encoding="utf-8")
    print(f"{len(poses)} objects in {SCENARIO}")


if __name__ == "__main__":
    main()
