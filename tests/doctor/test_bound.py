"""Whether the oracle is an upper bound, told from finished runs."""

from __future__ import annotations

from pathlib import Path

from made_up_runs import write_run

from grasp_bench.doctor.bound import check_bound
from grasp_bench.doctor.checks import State


def test_it_is_one_where_it_lifts_everything(tmp_path: Path) -> None:
    oracle = write_run(tmp_path / "oracle")
    write_run(tmp_path / "rival", predictor="rival", wins=lambda t: t < 8)
    write_run(tmp_path / "elsewhere", predictor="elsewhere", seed=9)
    (check,) = check_bound(oracle)
    assert check.state is State.OK
    assert (
        check.detail == "the oracle lifts 9 of 9 and at least as much as 1 others of these trials: it is one"
    )


def test_it_is_none_where_another_lifts_more(tmp_path: Path) -> None:
    oracle = write_run(tmp_path / "oracle", wins=lambda t: t < 8)
    write_run(tmp_path / "rival", predictor="rival")
    (check,) = check_bound(oracle)
    assert check.state is State.BAD
    assert "rival more of the same trials" in check.detail


def test_what_it_loses_is_named(tmp_path: Path) -> None:
    (check,) = check_bound(write_run(tmp_path / "oracle", wins=lambda t: t != 1))
    assert check.state is State.NOTE
    assert check.detail.endswith("no bound for pan")


def test_other_predictors_are_not_asked(tmp_path: Path) -> None:
    assert check_bound(write_run(tmp_path / "rival", predictor="rival")) == []
