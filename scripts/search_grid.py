"""Looks for the shapes of the objects `grid`: `python scripts/search_grid.py POOL.jsonl`.

For each size and grade, shapes are drawn in turn, built and measured, until the difficulty of one comes near
the grade's aim. What was measured is kept in the pool, so that a killed search goes on. A shape counts if the
oracle lifts it six times of six; no other predictor is asked. Prints the table for
`grasp_bench/workshop/grid.py`.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

from grasp_bench.objects.catalog import load_details
from grasp_bench.predictors import load_predictor
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.trials.trial import run_trial
from grasp_bench.trials.workcell import Workcell
from grasp_bench.workshop import difficulty, grid
from grasp_bench.workshop.build import build_shape
from grasp_bench.workshop.poses import build_rest

NEAR = 0.05
TRIES = 150
MOST = 400
"""Draws after which a cell that has none yet is given up."""
LIFTS = 6
"""Trials of the oracle, all of which must lift."""
SEED = 85


def candidate(cell: Workcell, oracle: Any, size: int, grade: int, draw: int) -> dict[str, Any]:
    """Build and measure a shape; says why it does not count where it does not."""
    found = {"size": size, "grade": grade, "draw": draw}
    spec = grid.spec(size, grade, draw)
    with tempfile.TemporaryDirectory() as folder:
        try:
            build_shape(spec, Path(folder))
            build_rest(Path(folder) / spec.name, seen=True)
            details = json.loads((Path(folder) / spec.name / "object.json").read_text())
            model = load_details(Path(folder) / spec.name, details, details["fingerprint"])
            if not model.graspable_poses:
                return found | {"why": "no grasp"}
            measured = difficulty.measure(model, tries=TRIES)
        except ValueError as error:
            return found | {"why": str(error)}
        lifted = sum(
            run_trial(cell, model, oracle, attempt=i, seed=SEED).record.success for i in range(LIFTS)
        )
    return found | {"failing": 1 - measured["held"] / measured["tried"], "oracle": lifted}


def best(pool: list[dict[str, Any]], size: int, grade: int) -> dict[str, Any] | None:
    """Return the shape that comes nearest to the grade's aim."""
    fit = [c for c in pool if (c["size"], c["grade"]) == (size, grade) and c.get("oracle") == LIFTS]
    return min(fit, key=lambda c: abs(c["failing"] - grid.AIMS[grade]), default=None)


def main() -> None:
    """Search, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("pool", type=Path)
    parser.add_argument("--draws", type=int, default=24)
    parser.add_argument("--sizes", help="only these, by index; by default all")
    asked = parser.parse_args()
    sizes = [int(s) for s in asked.sizes.split(",")] if asked.sizes else list(range(len(grid.SIZES)))
    asked.pool.touch()
    pool = [json.loads(line) for line in asked.pool.read_text().splitlines()]
    known = {(c["size"], c["grade"], c["draw"]) for c in pool}
    cell, oracle = Workcell(load_scenario("table4")), load_predictor("oracle")

    def look(size: int, grade: int, draw: int) -> None:
        if (size, grade, draw) not in known:
            known.add((size, grade, draw))
            pool.append(candidate(cell, oracle, size, grade, draw))
            with asked.pool.open("a") as file:
                file.write(json.dumps(pool[-1]) + "\n")

    cells = [(size, grade) for size in sizes for grade in range(len(grid.GRADES))]
    for size, grade in cells:  # one at least
        draws = iter(range(MOST))
        while best(pool, size, grade) is None:
            look(size, grade, next(draws))
    for draw in range(asked.draws):
        for size, grade in cells:
            found = best(pool, size, grade)
            if found is None or abs(found["failing"] - grid.AIMS[grade]) > NEAR:
                look(size, grade, draw)
    for size in sizes:
        row = [best(pool, size, grade) for grade in range(len(grid.GRADES))]
        draws = ", ".join(str(c["draw"]) if c else "None" for c in row)
        print(f"    ({draws}),  # " + " ".join(f"{c['failing']:.2f}" if c else "-" for c in row))


if __name__ == "__main__":
    main()
