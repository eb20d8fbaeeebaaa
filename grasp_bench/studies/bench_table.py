"""All networks and controls on the same trials: Table 4, re-measured, with paired comparisons."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from grasp_bench import api
from grasp_bench.errors import GraspBenchError, ResultsError
from grasp_bench.execution.crew import early_crew
from grasp_bench.execution.together import can_share, run_together
from grasp_bench.networks.registry import all_weights, family
from grasp_bench.predictors.shipped import SHIPPED
from grasp_bench.report.accuracy import ablation_table, accuracy_table
from grasp_bench.report.compare import REFERENCE
from grasp_bench.report.groups import PAPERS
from grasp_bench.report.published import published_table
from grasp_bench.report.since import since_table
from grasp_bench.report.table4 import PAPER, ROBOTS, TITLE, Row, table_4
from grasp_bench.report.tables import RATE_HEAD, TextTable, rate_cells
from grasp_bench.runs.comparison import Comparison
from grasp_bench.runs.evaluation import Evaluation
from grasp_bench.runs.info import RUN
from grasp_bench.runs.jobs import Settings, spread
from grasp_bench.runs.record import TrialRecord
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import Rate, holm, trials_to_distinguish
from grasp_bench.scenario.reading import load_scenario
from grasp_bench.studies.rank import folder_name
from grasp_bench.studies.weights_table import CUT_OFF, trained_on, weights_table
from grasp_bench.system.graphics import prepare, resolve_renderer
from grasp_bench.system.machine import usable_cores

UNABLATED = "htc-grasp-1000"
"""HTC-Grasp trained as long as its ablations."""
SWITCHES = ("external_attention", "channel_attention")
"""Parts that the paper's Table 3 leaves out, as arguments of the network."""
FORMAT = 1

OF_THE_PAPER = f"Rows with a printed rate {ROBOTS} "
NOTE = (
    "All rows of grasp-bench are of the same trials. Alone: trials in which only the reference, and only "
    "this system, succeeded; p: McNemar's exact two-sided test against the reference, Holm-corrected over "
    "all rows; trials to tell: after how many such trials the two would be told apart at 5 % with 80 % power "
    "if the observed shares were true (Connor, Biometrics 43, 1987)."
)


def bench(
    folder: Path,
    predictors: Sequence[str] | None = None,
    trials: int | None = None,
    scenario: str = "table4",
    seed: int = 0,
    workers: int | None = None,
    on_trial: Callable[[str, TrialRecord, bool], None] = lambda name, record, resumed: None,
    objects: Sequence[str] | None = None,
) -> list[str]:
    """Try predictors on the same trials, each into its own folder; what is done is kept.

    Worlds and pictures are made once for all predictors that may share a process; the records are those of
    :func:`grasp_bench.run` with each of them.

    Args:
        folder: holds a run for each predictor, named after it.
        predictors: names; by default all shipped ones whose weights are there.
        trials: number of trials for each; by default one for each object.
        scenario, seed, workers: as for :func:`grasp_bench.run`.
        on_trial: called with each predictor's name, record, and whether it was there before.
        objects: names; by default those of the scenario.

    Returns:
        Names of shipped networks left out because their weights are missing.
    """
    names = chosen(predictors)
    folders = {name: folder / folder_name(name) for name in names}
    shared = {name: path for name, path in folders.items() if can_share(name)}
    if shared:
        prepare("auto")
        read = load_scenario(scenario)
        catalog, tried, _ = api.objects_for(read, objects)
        renderer = resolve_renderer("auto")
        settings = Settings(read, catalog.folder.resolve(), next(iter(shared)), seed, renderer)
        jobs = spread(tried, len(tried) if trials is None else trials)
        with early_crew(tuple(shared), workers or 0, len(jobs)):
            run_together(settings, shared, jobs, workers or usable_cores(), on_trial)
    for name in folders.keys() - shared.keys():
        api.run(
            objects=objects,
            trials=trials,
            predictor=name,
            scenario=scenario,
            seed=seed,
            workers=workers,
            out=folders[name],
            progress=partial(on_trial, name),
        )
    return [n for n, e in SHIPPED.items() if not e.available and n not in names]


def chosen(predictors: Sequence[str] | None = None) -> list[str]:
    """Return the names that :func:`bench` tries."""
    return list(predictors) if predictors else [n for n, e in SHIPPED.items() if e.available]


def compare(folders: Sequence[Path], reference: str = REFERENCE) -> dict[str, Any]:
    """Return rows of the runs, each compared with the reference's trial by trial.

    Raises:
        ResultsError: when a run is damaged or empty, or did other trials than the reference.
    """
    runs = [RunResults(f) for f in folders]
    against = next((r for r in runs if r.predictor == reference), None)
    rows: list[dict[str, Any]] = []
    for run in sorted(runs, key=lambda r: (_kind(r.predictor) == "control", -r.successes, r.predictor)):
        row: dict[str, Any] = {
            "predictor": run.predictor,
            "kind": _kind(run.predictor),
            "run": run.folder.name,
            **run.lifted.to_json(),
            "planned_trials": run.info.planned(len(run)),
            "weights": trained_on(run.predictor, run.info.weights),
        }
        if against is not None and run is not against:
            pairs = _compared_whole(against, run)
            shares = pairs.first_only / pairs.trials, pairs.second_only / pairs.trials
            row |= _paired("reference", pairs) | {"trials_to_tell": trials_to_distinguish(*shares)}
        rows.append(row)
    _correct(rows)
    first = (against or runs[0]).info if runs else None
    return {
        "format": FORMAT,
        "kind": "bench-table",
        "reference": reference if against else None,
        "scenario": first.scenario_name if first else None,
        "seed": first.seed if first else None,
        "rows": rows,
        "ablations": _ablations(runs),
    }


def _ablations(runs: Sequence[RunResults]) -> list[dict[str, Any]]:
    """Compare the runs of HTC-Grasp's ablations with :data:`UNABLATED` trial by trial."""
    by_name = {r.predictor: r for r in runs}
    whole, rows = by_name.get(UNABLATED), []
    for name in family(UNABLATED):
        arguments = all_weights()[name][0].arguments
        row: dict[str, Any] = {"predictor": name, **{s: arguments.get(s, True) for s in SWITCHES}}
        if (run := by_name.get(name)) is not None:
            row |= run.lifted.counts()
            if whole is not None and run is not whole:
                row |= _paired("whole", _compared_whole(whole, run))
        rows.append(row)
    _correct(rows)
    return rows


def _compared_whole(first: RunResults, second: RunResults) -> Comparison:
    """Compare two runs whose trials are all the same; ResultsError where they are not."""
    pairs = Comparison.of(first, second)
    if not pairs.trials == len(first) == len(second):
        raise ResultsError(
            f"{first.folder} and {second.folder} did not try the same: {pairs.trials} trials are in both, of "
            f"{len(first)} and {len(second)}. Run both with the same objects, trials and seed."
        )
    return pairs


def _paired(first: str, pairs: Comparison) -> dict[str, Any]:
    counts = {f"{first}_only": pairs.first_only, "this_only": pairs.second_only}
    return counts | {"p_value": pairs.p_value}


def _correct(rows: list[dict[str, Any]]) -> None:
    """Add Holm's ``p_holm`` to all rows that have a ``p_value``."""
    compared = [r for r in rows if "p_value" in r]
    for row, corrected in zip(compared, holm([r["p_value"] for r in compared]), strict=True):
        row["p_holm"] = corrected


def _kind(predictor: str) -> str:
    return SHIPPED[predictor].kind if predictor in SHIPPED else "own"


def read_evaluations(folder: Path) -> list[Evaluation]:
    """Read results that ``grasp-bench evaluate --out`` left in a folder, by name; none without a folder.

    Raises:
        ResultsError: naming a file that is not one.
    """
    return [Evaluation.read(path) for path in sorted(folder.glob("*.json"))]


# ---------------------------------------------------------------- tables


def tables(comparison: dict[str, Any], evaluations: Sequence[Evaluation]) -> list[TextTable]:
    """Return Table 4, what was trained on what, and Tables 1 to 3, all re-measured."""
    found = [
        accuracy_table(name, chosen)
        for name in ("cornell", "jacquard", "synthetic")
        if (chosen := [e for e in evaluations if e.dataset == name])
    ]
    weights = weights_table(comparison)
    cut_off = [r["predictor"] for r in comparison["rows"] if _cut_off(r)]
    ablations = [e for e in evaluations if e.predictor in (REFERENCE, *family(UNABLATED))]
    return [
        _compared(comparison),
        *([weights] if weights.rows else []),
        *found,
        *([published_table(evaluations, cut_off), since_table()] if found else []),
        *([ablation_table(ablations)] if ablations else []),
        _ablations_in_physics(comparison),
    ]


def _compared(comparison: dict[str, Any]) -> TextTable:
    """Return Table 4, with how each row compares with the reference; without the paper where it tells of
    another scenario."""
    beside = _beside_the_paper(comparison)
    paper = PAPER if beside else ()
    rows, alone, p, tell = list(paper), *([""] * len(paper) for _ in range(3))
    for row in comparison["rows"]:
        missing = row["planned_trials"] - row["trials"]
        name = row["predictor"] + (" (control)" if row["kind"] == "control" else "")
        name += f", {missing} to go" if missing else ""
        name += CUT_OFF if _cut_off(row) else ""
        rows.append(Row("grasp-bench", name, Rate(row["successes"], row["trials"]), run=row["run"]))
        compared = "p_value" in row
        alone.append(f"{row['reference_only']} : {row['this_only']}" if compared else "")
        p.append(f"{row['p_holm']:.2g}" if compared else "")
        tell.append(str(row["trials_to_tell"] or "∞") if compared else "")
    title = TITLE if beside else "All predictors"
    if comparison["scenario"]:
        title += f": {comparison['scenario']}, seed {comparison['seed']}"
    reference = f" Reference: {comparison['reference']}." if comparison["reference"] else ""
    note = OF_THE_PAPER + NOTE if beside else NOTE
    more = {"Alone": alone, "p (Holm)": p, "Trials to tell": tell}
    return table_4(rows, more, title, note + reference, numbers=range(3))


def _cut_off(row: dict[str, Any]) -> bool:
    return (row["weights"] or {}).get("ended") == "minutes"


def _beside_the_paper(comparison: dict[str, Any]) -> bool:
    return comparison["scenario"] in (PAPERS, None)


def _ablations_in_physics(comparison: dict[str, Any]) -> TextTable:
    """Return the switches of the paper's Table 3 against success in physics."""
    rows = []
    for row in comparison["ablations"]:
        cells, against = ["not measured", "", ""], ["", ""]
        if "trials" in row:
            cells = rate_cells(Rate(row["successes"], row["trials"]))
        if "p_value" in row:
            against = [f"{row['whole_only']} : {row['this_only']}", f"{row['p_holm']:.2g}"]
        marks = ["✓" if row[switch] else "" for switch in SWITCHES]
        rows.append([row["predictor"], *marks, *cells, *against])
    note = (
        f"What each was trained on stands in its row above. Alone: trials in which only {UNABLATED}, and "
        "only this one, succeeded; p: McNemar's exact two-sided test, Holm-corrected over these rows."
    )
    trials = "the trials of Table 4" if _beside_the_paper(comparison) else "the same trials"
    return TextTable(
        f"Table 3's ablations on {trials}",
        ("Predictor", "External attention", "Channel attention", *RATE_HEAD, "Alone", "p (Holm)"),
        rows,
        note=note,
        numbers=range(3, 8),
    )


def run_folders(folder: Path) -> list[Path]:
    """Return the runs directly in ``folder``; GraspBenchError when there is none."""
    found = sorted(p.parent for p in folder.glob(f"*/{RUN}"))
    if not found:
        raise GraspBenchError(f"{folder} holds no run yet; leave out --no-run to make them.")
    return found
