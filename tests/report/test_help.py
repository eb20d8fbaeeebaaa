"""As predicted and assisted side by side: which runs belong together, and what the help changed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from made_up_runs import RUN, write_run

from grasp_bench.report.help import Help, Merit, merits
from grasp_bench.report.table4 import build_report
from grasp_bench.report.tables import as_text, markdown
from grasp_bench.runs.record import TrialRecord
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import Rate, mcnemar

CURRENT = {"name": "table4", "version": 2}
ALONE = {"name": "as-predicted", "version": 2, "execution": {"protocol": "as-predicted"}}


def with_help(record: dict[str, Any]) -> dict[str, Any]:
    """Trial 0 needed another grasp, trials 1 and 2 wider jaws, trial 3 got no plan, the others no help."""
    trial = record["trial"]
    if trial == 3:
        return record | {"outcome": "blocked", "success": False}
    widening = 8.0 if trial in (1, 2) else 0.01
    return record | {"rank": int(trial == 0), "widening_mm": widening, "shortfall_mm": 0.0}


@pytest.fixture
def runs(tmp_path: Path) -> list[Path]:
    write_run(tmp_path / "helped", scenario=CURRENT, wins=lambda t: t != 8, change=with_help)
    write_run(tmp_path / "alone", scenario=ALONE, wins=lambda t: t in (1, 4, 5, 6, 7, 8))
    write_run(tmp_path / "other-seed", scenario=ALONE, seed=5)
    write_run(tmp_path / "tilted", scenario=ALONE | {"camera": {"position": [0.5, 0.1, 0.55]}})
    write_run(tmp_path / "before", scenario={"name": "table4", "version": 1})
    return sorted(tmp_path.iterdir())


def found(folders: list[Path]) -> list[Merit]:
    return merits([RunResults(f) for f in folders])


def test_runs_that_differ_in_the_protocol_alone_belong_together(runs: list[Path]) -> None:
    both = [m for m in found(runs) if m.pairs is not None]
    assert len(both) == 1
    merit = both[0]
    assert (merit.predicted, merit.assisted) == (Rate(6, 9), Rate(7, 9))
    assert merit.pairs == (1, 2, 9)  # 8 lost; 0 and 2 gained
    assert merit.pairs is not None
    assert merit.pairs.difference == pytest.approx(1 / 9)
    assert merit.p_value == mcnemar(1, 2)
    alone = [m for m in found(runs) if m.pairs is None]
    assert [(m.predicted, m.assisted) for m in alone] == [(Rate(9, 9), None)] * 2


def test_of_runs_alike_the_longest_counts(tmp_path: Path) -> None:
    short = write_run(tmp_path / "baseline", 3, scenario=CURRENT, change=with_help)
    whole = write_run(tmp_path / "whole", 9, scenario=CURRENT, change=with_help)
    silent = write_run(tmp_path / "silent", 30, scenario=CURRENT)
    for folders in ([short, whole, silent], [silent, whole, short]):
        (merit,) = found(folders)
        assert merit.assisted == Rate(8, 9)
        assert merit.runs == (folders.index(whole),)


def test_help_is_counted_from_the_records(runs: list[Path]) -> None:
    merit = next(m for m in found(runs) if m.pairs is not None)
    assert merit.help == Help(trials=9, known=8, other=1, wider=2, alone=4)  # 4 to 7; 8 was missed


def test_records_without_these_keys_are_read_and_say_nothing(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "old", scenario=CURRENT)
    assert found([folder]) == []
    line = RunResults(folder).records[0]
    assert (line.widening_mm, line.shortfall_mm) == (None, None)
    assert "widening_mm" not in line.to_json()
    assert Help.of([line]) == Help(1, 0, 0, 0, 0)


def test_millimetres_are_rounded_and_never_minus_nought() -> None:
    content = {"trial": 0, "object": "mug", "category": "mug", "outcome": "missed"}
    record = TrialRecord.read(content | {"widening_mm": 3.14159, "shortfall_mm": -1e-14})
    assert '"widening_mm": 3.14, "shortfall_mm": 0.0,' in record.line()


def test_the_report_shows_both_and_the_difference(runs: list[Path]) -> None:
    report = build_report(runs)
    pages = [as_text(report.tables()), markdown(report.tables())]
    for page in pages:
        assert "Whose merit is it?" in page
        assert "6/9" in page
        assert "7/9" in page
        assert "+11.1%" in page
    told = next(m for m in report.to_json()["merit"] if m["pairs"])
    assert told["as_predicted"]["successes"] == 6
    assert told["difference"] == pytest.approx(1 / 9)
    assert told["help"]["wider"] == 2
    assert RUN["predictor"] == told["predictor"]


def test_a_report_of_runs_without_help_keys_has_no_such_table(tmp_path: Path) -> None:
    report = build_report([write_run(tmp_path / "old", scenario=CURRENT)])
    assert "Whose merit" not in markdown(report.tables())
    assert report.to_json()["merit"] == []
