"""Runs predictors with several grippers on the same objects, and prints the matrix of docs/robots.md.

``python scripts/make_hands.py --out results/hands`` prepares the grippers, runs what is not done yet (a
second call goes on), and prints the table as Markdown. Every predictor tries the objects that all of the
grippers can grasp, at the same places; how a thing lies is drawn among the poses that the gripper can grasp.
``--objects`` takes some of them.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

import grasp_bench as gb
from grasp_bench.api import select_objects
from grasp_bench.objects.fitted import graspable, is_reference
from grasp_bench.report.hands import Hands
from grasp_bench.report.tables import markdown
from grasp_bench.robot.facts import shipped
from grasp_bench.robot.grippers import load_gripper
from grasp_bench.runs.results import RunResults
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.scenario.robots import with_gripper
from grasp_bench.workshop.fitting import prepare

PREDICTORS = "oracle,displaced,centroid,antipodal,random"


def main() -> None:
    """Run and print, as the command line says."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--grippers", default=",".join(shipped("gripper")), help="names or folders")
    parser.add_argument("--predictors", default=PREDICTORS)
    parser.add_argument("--objects", default="all", help="all, or names or categories, comma-separated")
    parser.add_argument("--trials", type=int, default=None, help="of each run; each object once by default")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--out", type=Path, required=True)
    asked = parser.parse_args()
    grippers, predictors = asked.grippers.split(","), asked.predictors.split(",")
    catalog, names = select_objects(asked.objects)
    for name in grippers:
        gripper = load_gripper(name)
        if not is_reference(gripper):
            for _ in prepare(gripper, catalog.folder, names, asked.workers):
                pass
        names, _ = graspable(catalog, names, gripper)
    table4 = load_scenario("table4")
    folders = []
    for name in grippers:
        label = Path(name).name
        scenario = table4
        if not is_reference(load_gripper(name)):
            scenario = with_gripper(table4, name).model_copy(update={"name": f"table4-{label}"})
        for predictor in predictors:
            out = asked.out / f"{predictor}-{label}"
            gb.run(names, asked.trials, predictor, scenario, seed=asked.seed, workers=asked.workers, out=out)
            folders.append(out)
    matrix = Hands.of([RunResults(folder) for folder in folders])
    if matrix is not None:
        print(markdown([matrix.table()]))


if __name__ == "__main__":
    main()
