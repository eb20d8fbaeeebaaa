"""The last lines of a run: why trials failed, and a hint that fits the predictor."""

from __future__ import annotations

from pathlib import Path

from made_up_runs import write_run

from grasp_bench.report.ending import ending
from grasp_bench.runs.results import RunResults


def told(folder: Path) -> str:
    return "\n".join(ending(RunResults(folder)))


def test_a_reason_is_that_of_most_failures_only_where_it_is(tmp_path: Path) -> None:
    alike = told(write_run(tmp_path / "alike", wins=lambda t: t > 2))
    assert "Most failures (3 of 3): missed: nothing held (trial 0)" in alike
    kinds = told(
        write_run(
            tmp_path / "kinds",
            wins=lambda t: t > 2,
            change=lambda r: r if r["success"] else r | {"detail": "abc"[r["trial"]] * 3},
        )
    )
    assert "Commonest failure (1 of 3): missed: aaa (trial 0)" in kinds
    assert "Nothing was lifted" not in kinds


def test_whoever_wrote_the_predictor_is_told_how_to_check_it(tmp_path: Path) -> None:
    mine = told(write_run(tmp_path / "mine", wins=lambda t: False, predictor="mine:Mine"))
    assert "`grasp-bench predictors check mine:Mine` finds the usual slips" in mine
    shipped = told(write_run(tmp_path / "shipped", wins=lambda t: False, predictor="displaced"))
    assert "Nothing was lifted. `grasp-bench report" in shipped
    assert "predictors check" not in shipped
