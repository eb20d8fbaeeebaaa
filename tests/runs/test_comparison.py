"""Runs compared on their common trials: those of the same seed, object and attempt."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from html_runs import OBJECTS, record, write_run

from grasp_bench.errors import ResultsError
from grasp_bench.report.compare import SharedTrials
from grasp_bench.runs.comparison import Comparison, scenes
from grasp_bench.runs.folder import find_runs
from grasp_bench.runs.results import RunResults
from grasp_bench.studies.bench_table import compare, run_folders

RESULTS = Path(__file__).parents[2] / "results"
FILES = {name: {"visual.glb": name} for name in OBJECTS}


def renumbered(folder: Path, tried: list[tuple[str, str]], names: list[str] | None = None) -> RunResults:
    """A run that tried objects in an order of its own; (object, outcome) each."""
    objects = {n: FILES[n] for n in names or dict.fromkeys(o for o, _ in tried)}
    write_run(folder, folder.name, ["success"] * len(tried), objects=objects)
    lines = [json.dumps(record(i, outcome, object=name)) for i, (name, outcome) in enumerate(tried)]
    (folder / "trials.jsonl").write_text("\n".join(lines) + "\n")
    return RunResults(folder)


def test_trials_are_matched_by_object_and_attempt_not_by_number(tmp_path: Path) -> None:
    a, b = OBJECTS[:2]
    first = renumbered(tmp_path / "a", [(a, "success"), (b, "missed"), (a, "missed"), (b, "success")])
    second = renumbered(tmp_path / "b", [(b, "success"), (a, "success"), (b, "success")], [b, a])
    pair = Comparison.of(first, second)
    assert (pair.both, pair.first_only, pair.second_only, pair.neither) == (2, 0, 1, 0)
    assert [(x.trial, y.trial) for x, y in pair.discordant] == [(1, 0)]
    assert pair.differing == (b,)
    (versus,) = SharedTrials([first, second]).against(0)
    assert (versus.run, versus.pairs) == (1, pair)
    numbers = [SharedTrials([first, second]).numbers(i) for i in (0, 1)]
    assert numbers[0][1] == numbers[1][0]
    assert numbers[0][3] == numbers[1][2]
    assert len({*numbers[0].values(), *numbers[1].values()}) == 4


def test_the_attempt_of_a_shards_trial_counts_those_of_other_shards(tmp_path: Path) -> None:
    run = renumbered(tmp_path / "a", [(OBJECTS[0], "success")] * 4)
    lines = (run.folder / "trials.jsonl").read_text().splitlines(keepends=True)
    (run.folder / "trials.jsonl").write_text(lines[1] + lines[3])
    assert [s.attempt for s in scenes(RunResults(run.folder))] == [1, 3]


def test_runs_of_other_seeds_have_nothing_in_common() -> None:
    first, second = (RunResults(RESULTS / "seeds" / f"htc-grasp-seed{i}") for i in (5, 6))
    with pytest.raises(ResultsError, match="no trial in common"):
        Comparison.of(first, second)


@pytest.fixture(scope="module")
def committed() -> tuple[list[str], SharedTrials]:
    folders = find_runs(RESULTS)
    names = [f.relative_to(RESULTS).as_posix() for f in folders]
    return names, SharedTrials([RunResults(f) for f in folders])


def test_the_baseline_is_compared_on_all_trials_that_it_shares(
    committed: tuple[list[str], SharedTrials],
) -> None:
    names, shared = committed
    found = {names[v.run]: v for v in shared.against(names.index("reference/gr-convnet"))}
    assert found["baseline/htc-grasp"].pairs.trials == 24
    assert found["baseline/htc-grasp"].adjusted is None, "reference/htc-grasp has more in common"
    assert found["reference/htc-grasp"].pairs.trials == 180
    others = [n for n in found if n.startswith(("seeds/", "suites/"))]
    assert others == ["suites/htc-grasp-adversarial"]  # chosen objects, tried as in table4
    assert found[others[0]].adjusted is None


def test_holms_correction_is_that_of_the_results_page(committed: tuple[list[str], SharedTrials]) -> None:
    names, shared = committed
    found = {names[v.run]: v.adjusted for v in shared.against(names.index("reference/htc-grasp"))}
    assert found.pop("baseline/htc-grasp") is None
    told = compare(run_folders(RESULTS / "reference"))
    for row in told["rows"]:
        if row["predictor"] != told["reference"]:
            assert found[f"reference/{row['predictor']}"] == pytest.approx(row["p_holm"])


def test_a_scenarios_choice_of_objects_does_not_change_a_trial(tmp_path: Path) -> None:
    one = renumbered(tmp_path / "a", [(OBJECTS[0], "success")])
    two = renumbered(tmp_path / "b", [(OBJECTS[0], "missed")])
    info = json.loads((two.folder / "run.json").read_text())
    for change, common in (({"names": {OBJECTS[0]: "round"}}, 1), ({"mass_scale": 2.0}, 0)):
        info["scenario"]["objects"] = change
        (two.folder / "run.json").write_text(json.dumps(info))
        assert len(SharedTrials([one, RunResults(two.folder)]).against(0)) == common
