"""Measures all shipped predictors side by side: `python scripts/measure_all.py PART`, where PART is

- `rank`: the race that tells who is better, up to 180 items.
- `physics`: whether that order would survive in 30 other worlds, 60 trials of each predictor in each.
- `clutter`: 50 tables each.
- `suites`: the other scenarios, each object once.
- `seeds`: the five best on the seeds that nobody tuned on, with help and without.

Every part goes on where it was stopped, by Ctrl-C or after `--minutes`. Runs are kept in `results/measured`;
when a part is complete its tables go to `results/measured/PART.md`, and with `--publish` into the docs. Rows
of `clutter` and `suites` are kept in `PART.json`, so that a call with some of the predictors adds theirs;
remove that file where trials or weights have changed since.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace as changed
from pathlib import Path

from make_tables import ROOT, replace
from rich.console import Console

from grasp_bench import api
from grasp_bench.predictors.shipped import SHIPPED, SPATIAL
from grasp_bench.report.clutter import clutter_table, summarise_clutter
from grasp_bench.report.tables import RATE_HEAD, TextTable, markdown, rate_cells
from grasp_bench.runs.comparison import Comparison
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import Rate, holm, mcnemar
from grasp_bench.scenario.reading import load_scenario, scenario_names
from grasp_bench.studies.bench_table import bench
from grasp_bench.studies.rank import Contest, folder_name, rank, score_for
from grasp_bench.studies.ranking import ranking_table, unseen_table
from grasp_bench.studies.worlds import in_worlds, worlds_table
from grasp_bench.system.graphics import prepare
from grasp_bench.system.machine import usable_cores
from grasp_bench.system.progress import counting

OUT = ROOT / "results" / "measured"
SCENARIO = "graded-as-predicted"
BUDGET, WORLDS, WORLD_TRIALS, TABLES = 180, 30, 60, 50
PARTS = ("rank", "physics", "clutter", "suites", "seeds")
BEST = ("htc-grasp", "gr-convnet", "htc-grasp-no-ca", "gg-cnn2", "htc-grasp-1000")
"""The five that lift most with help on the development seed."""
SEEDS = range(5, 10)
"""Of trials that neither planner nor networks were changed for."""
Tick = Callable[..., None]
"""Called after every trial, whatever its arguments."""


class OutOfTime(Exception):  # noqa: N818 - not an error: the same command goes on
    """The minutes are used up."""


def planar(helped: bool) -> list[str]:
    """Return the shipped predictors of grasps from above, but for the one that must fail.

    Args:
        helped: with the planner's help; without, a tenth proposal is never looked at.
    """
    names = [n for n, e in SHIPPED.items() if e.available and SPATIAL not in e.path and n != "displaced"]
    return [n for n in names if helped or n != "random-10"]


def suite_names() -> list[str]:
    """Return the scenarios of the same protocol and objects as the reference, one object at a time."""
    plain = load_scenario("table4")
    known = {n: load_scenario(n) for n in scenario_names() if n != plain.name}
    return [
        n
        for n, s in known.items()
        if not (s.clutter or s.margin)
        and (s.execution, s.objects.folder) == (plain.execution, plain.objects.folder)
    ]


class Measuring:
    """What all parts are given.

    Args:
        names: predictors, or None for all of a part.
        out: where runs are kept.
        workers: number of processes.
        tick: called after every trial.
    """

    def __init__(self, names: Sequence[str] | None, out: Path, workers: int, tick: Tick) -> None:
        self._names, self._out, self._workers, self._tick = names, out, workers, tick

    def _contest(self, budget: int) -> Contest:
        scenario = load_scenario(SCENARIO)
        catalog, objects, _ = api.objects_for(scenario)
        names = tuple(self._names or planar(helped=False))
        return Contest(names, scenario, catalog, tuple(objects), score_for(scenario), budget)

    def rank(self, budget: int = BUDGET) -> list[TextTable]:
        """Race until all are told apart or the budget is used up."""
        contest = self._contest(budget)
        race = rank(contest, self._out / "rank", self._workers, self._tick)
        unseen = unseen_table(race)
        return [ranking_table(race, contest.score.what), *([unseen] if unseen else [])]

    def physics(self, worlds: int = WORLDS, trials: int = WORLD_TRIALS) -> list[TextTable]:
        """Repeat the same trials in other worlds."""
        contest, folder = self._contest(BUDGET), self._out / "rank"
        return [worlds_table(in_worlds(contest, worlds, trials, folder, self._workers, self._tick))]

    def clutter(self, tables: int = TABLES) -> list[TextTable]:
        """Clear tables."""
        names, folder = self._names or planar(helped=True), self._out / "clutter"
        bench(folder, names, tables, "clutter", workers=self._workers, on_trial=self._tick)
        rows = []
        for name in names:
            run = RunResults(folder / folder_name(name))
            episodes = [r.clutter for r in run.records if r.clutter is not None]
            rows.append((name, summarise_clutter(episodes, len(run))))
        return [self._with_earlier(clutter_table(rows), "clutter", lambda row: -float(row[5].rstrip("%")))]

    def suites(self, count: int | None = None) -> list[TextTable]:
        """Try objects of each scenario once: all, or ``count`` at equal distances in the catalogue."""
        names, scenarios = self._names or planar(helped=True), suite_names()
        rows = [[name] for name in names]
        for scenario in scenarios:
            folder = self._out / "suites" / scenario
            _, objects, _ = api.objects_for(load_scenario(scenario))
            tried = evenly(objects, count or len(objects))
            bench(folder, names, None, scenario, workers=self._workers, on_trial=self._tick, objects=tried)
            for row, name in zip(rows, names, strict=True):
                lifted = RunResults(folder / folder_name(name)).lifted
                row.append(f"{lifted.successes}/{lifted.trials}")
        table = TextTable(
            "All predictors in the other scenarios",
            ("Predictor", *scenarios),
            rows,
            note="Lifted of tried, with the planner's help, seed 0; each object once.",
            numbers=range(1, len(scenarios) + 1),
        )
        known = list(SHIPPED)
        return [self._with_earlier(table, "suites", lambda row: known.index(row[0]))]

    def seeds(self, trials: int | None = None) -> list[TextTable]:
        """Try every object once a seed, assisted and as predicted."""
        names = self._names or BEST
        rows = [[name] for name in names]
        for scenario in ("table4", "as-predicted"):
            folders = [self._out / "seeds" / f"{scenario}-{seed}" for seed in SEEDS]
            for folder, seed in zip(folders, SEEDS, strict=True):
                bench(folder, names, trials, scenario, seed, self._workers, self._tick)
            runs = {name: [RunResults(folder / folder_name(name)) for folder in folders] for name in names}
            for row, name, p in zip(rows, names, ["", *self._p_values(runs)], strict=True):
                lifted = [run.lifted for run in runs[name]]
                whole = Rate(sum(r.successes for r in lifted), sum(r.trials for r in lifted))
                row += [", ".join(str(r.successes) for r in lifted), *rate_cells(whole), p]
        return [
            TextTable(
                f"The five best on seeds {SEEDS[0]} to {SEEDS[-1]}",
                ("Predictor", *("Assisted", *RATE_HEAD, "p"), *("As predicted", *RATE_HEAD, "p")),
                rows,
                note="Each object once a seed; nothing was changed for these trials. "
                f"p: McNemar's exact test against {names[0]} on the same trials, Holm-corrected over rows.",
                numbers=range(1, 11),
            )
        ]

    @staticmethod
    def _p_values(runs: Mapping[str, Sequence[RunResults]]) -> list[str]:
        """Return each p-value but the first's, of runs on the same seeds against the first's."""
        first, *others = runs.values()
        found = []
        for other in others:
            pairs = [Comparison.of(a, b) for a, b in zip(first, other, strict=True)]
            found.append(mcnemar(sum(p.first_only for p in pairs), sum(p.second_only for p in pairs)))
        return [f"{p:.2g}" for p in holm(found)]

    def _with_earlier(
        self, table: TextTable, part: str, place: Callable[[Sequence[str]], float]
    ) -> TextTable:
        """Return a table with the rows that earlier calls kept for other predictors, and keep all."""
        path, rows = self._out / f"{part}.json", [list(row) for row in table.rows]
        if path.is_file():
            kept = json.loads(path.read_text(encoding="utf-8"))
            if kept["head"] == list(table.head):
                measured = {row[0] for row in rows}
                rows += [row for row in kept["rows"] if row[0] not in measured]
        rows.sort(key=place)
        path.write_text(
            json.dumps({"head": list(table.head), "rows": rows}, indent=1) + "\n", encoding="utf-8"
        )
        return changed(table, rows=rows)


def evenly(names: Sequence[str], count: int) -> list[str]:
    """Return ``count`` of the names at equal distances, or all where there are no more."""
    step = max(len(names) / count, 1)
    return [names[int(i * step)] for i in range(min(count, len(names)))]


def publish(out: Path) -> None:
    """Put all tables that are complete into docs/results.md."""
    parts = [out / f"{part}.md" for part in PARTS]
    text = "\n".join(p.read_text(encoding="utf-8") for p in parts if p.is_file())
    replace(ROOT / "docs" / "results.md", "all", text)


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("part", choices=PARTS)
    parser.add_argument("--predictors", help="comma-separated; by default all that are shipped")
    parser.add_argument("--minutes", type=float, help="stop after so long; the same command goes on")
    parser.add_argument("--size", type=int, help="items, worlds, tables, objects or trials, instead of all")
    parser.add_argument("--workers", type=int, default=0, help="processes; 0 takes one for each core")
    parser.add_argument("--world-trials", type=int, default=WORLD_TRIALS, help="of a predictor in a world")
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--publish", action="store_true", help="write complete tables into docs/results.md")
    asked = parser.parse_args()
    begun = time.monotonic()
    prepare("raycast")
    with counting(Console(stderr=True)) as bar:
        task = bar.add_task(asked.part, total=None, state="")

        def tick(*_: object) -> None:
            bar.update(task, advance=1)
            if asked.minutes is not None and time.monotonic() - begun > 60 * asked.minutes:
                raise OutOfTime

        names = asked.predictors.split(",") if asked.predictors else None
        measuring = Measuring(names, asked.out, asked.workers or usable_cores(), tick)
        try:
            measure = getattr(measuring, asked.part)
            size = [] if asked.size is None else [asked.size]
            tables = measure(*size, **({"trials": asked.world_trials} if asked.part == "physics" else {}))
        except OutOfTime:
            raise SystemExit(f"{asked.minutes:g} minutes are over; the same command goes on.") from None
    text = markdown(tables)
    asked.out.mkdir(parents=True, exist_ok=True)
    (asked.out / f"{asked.part}.md").write_text(text, encoding="utf-8")
    print(text)
    if asked.publish:
        publish(asked.out)


if __name__ == "__main__":
    main()
