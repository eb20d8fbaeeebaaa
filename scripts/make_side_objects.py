"""Builds the objects of the scenario side-grasps: ``python scripts/make_side_objects.py``.

Writes assets/side-objects from the models in grasp_bench/workshop/side_objects.py, and says in which resting
poses each can be grasped with six degrees of freedom only.
"""

from __future__ import annotations

from pathlib import Path

from grasp_bench.objects.catalog import Catalog
from grasp_bench.predictors.reference import find
from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.workshop.build import write_manifest
from grasp_bench.workshop.side_objects import THINGS, build

FOLDER = Path(__file__).resolve().parents[1] / "assets" / "side-objects"


def main() -> None:
    for name in THINGS:
        build(name, FOLDER)
    write_manifest(FOLDER)
    catalog = Catalog(FOLDER)
    for name in catalog.names:
        model = catalog.load(name)
        for i, pose in enumerate(model.poses):
            if not pose.grasps:
                aside = len(find(model, i, PARALLEL_85))
                print(
                    f"{name}: pose {i} of {len(model.poses)}, no grasp from above, {aside} from any direction"
                )


if __name__ == "__main__":
    main()
