"""A run's folder: appended, resumed, repaired, refused."""

from __future__ import annotations

import errno
import json
import os
from pathlib import Path
from typing import Any

import pytest

from grasp_bench.errors import ResultsError
from grasp_bench.results import RunFolder, dump, find_runs, iter_timings, load_run, load_trials, read_lines

RUN: dict[str, Any] = {
    "format": 1, "predictor": "oracle", "scenario": {"name": "table4", "gripper": {"force": 60.0}}, "seed": 0,
    "trials": 4, "objects": {"mug": {"object.json": "ab"}}, "weights": None, "versions": {"mujoco": "3.17"},
    "renderer": "raycast"}


def line(trial: int, success: bool = True) -> dict[str, Any]:
    return {"trial": trial, "object": "mug", "category": "mug", "outcome": "success" if success else "missed",
            "success": success}


def write(folder: Path, trials: list[int], run: dict[str, Any] = RUN, finish: bool = False) -> None:
    with RunFolder(folder) as results:
        results.start(run)
        for trial in trials:
            results.append(line(trial), {"trial": trial, "plan": 0.5})
        if finish:
            results.finish()


def test_what_is_appended_is_read_back(tmp_path: Path) -> None:
    write(tmp_path / "run", [0, 1, 2])
    records, sound = read_lines(tmp_path / "run" / "trials.jsonl")
    assert records == [line(0), line(1), line(2)]
    assert sound == (tmp_path / "run" / "trials.jsonl").stat().st_size
    assert load_run(tmp_path / "run") == RUN
    assert [t["plan"] for t in iter_timings(tmp_path / "run")] == [0.5] * 3


def test_each_trial_is_on_disk_before_the_next(tmp_path: Path) -> None:
    with RunFolder(tmp_path) as results:
        results.start(RUN)
        results.append(line(0), {"trial": 0})
        assert (tmp_path / "trials.jsonl").read_text() == dump(line(0)) + "\n"


def test_resuming_tells_what_was_done(tmp_path: Path) -> None:
    write(tmp_path, [0, 2])
    with RunFolder(tmp_path) as results:
        assert results.start(RUN) == {0, 2}
        assert not results.repaired


def test_a_finished_run_is_in_trial_order_without_repetitions(tmp_path: Path) -> None:
    write(tmp_path, [2, 0, 1, 0], finish=True)
    assert [r["trial"] for r in read_lines(tmp_path / "trials.jsonl")[0]] == [0, 1, 2]
    assert [r["trial"] for r in iter_timings(tmp_path)] == [0, 1, 2]
    assert not list(tmp_path.glob("*.tmp"))


@pytest.mark.parametrize("torn", ['{"trial": 3, "obj', '{"trial": 3}', "\x00\x00\x00", '{"other": 1}\n'])
def test_a_torn_last_line_is_cut_off_and_the_trial_done_again(tmp_path: Path, torn: str) -> None:
    write(tmp_path, [0, 1])
    with (tmp_path / "trials.jsonl").open("a") as file:
        file.write(torn)
    with RunFolder(tmp_path) as results:
        assert results.start(RUN) == {0, 1}
        assert results.repaired
        results.append(line(3), {"trial": 3})
    assert [r["trial"] for r in read_lines(tmp_path / "trials.jsonl")[0]] == [0, 1, 3]


def test_a_torn_line_of_timings_is_repaired_too(tmp_path: Path) -> None:
    write(tmp_path, [0, 1])
    with (tmp_path / "timings.jsonl").open("a") as file:
        file.write('{"tri')
    with RunFolder(tmp_path) as results:
        assert results.start(RUN) == {0, 1}
        assert results.repaired
    assert (tmp_path / "timings.jsonl").read_text().endswith("}\n")


def test_a_damaged_line_in_the_middle_is_refused_by_its_number(tmp_path: Path) -> None:
    write(tmp_path, [0, 1, 2])
    path = tmp_path / "trials.jsonl"
    lines = path.read_text().splitlines(keepends=True)
    path.write_text(lines[0] + lines[1][:20] + "\n" + lines[2])
    before = path.read_bytes()
    with RunFolder(tmp_path) as results, pytest.raises(ResultsError, match=r"trials\.jsonl, line 2 is dam"):
        results.start(RUN)
    assert path.read_bytes() == before
    with pytest.raises(ResultsError, match="line 2"):
        load_trials(tmp_path)


@pytest.mark.parametrize(("key", "value", "named"), [
    ("scenario", {"name": "table4", "gripper": {"force": 80.0}}, "the scenario"),
    ("predictor", "random", "the predictor"),
    ("seed", 1, "the seed"),
    ("trials", 9, "the number of trials"),
    ("objects", {"mug": {"object.json": "cd"}}, "the objects or their files"),
    ("weights", {"w": "ef"}, "the weights"),
    ("versions", {"mujoco": "3.18"}, "the software versions"),
    ("renderer", "egl", "the renderer"),
])
def test_another_run_in_the_folder_is_refused_by_what_differs(
        tmp_path: Path, key: str, value: Any, named: str) -> None:
    write(tmp_path, [0])
    with RunFolder(tmp_path) as results, pytest.raises(ResultsError) as caught:
        results.start(RUN | {key: value})
    assert f"holds another run: {named} differ" in str(caught.value)
    assert str(tmp_path) in str(caught.value)
    assert "--out" in str(caught.value)
    assert len(read_lines(tmp_path / "trials.jsonl")[0]) == 1


def test_all_that_differs_is_named(tmp_path: Path) -> None:
    write(tmp_path, [0])
    with RunFolder(tmp_path) as results, pytest.raises(ResultsError, match="the predictor, the seed differ"):
        results.start(RUN | {"seed": 5, "predictor": "random"})


def test_what_may_differ_between_calls_does_not_hinder_resuming(tmp_path: Path) -> None:
    write(tmp_path, [0], RUN | {"command": ["grasp-bench", "run"], "git": "abc"})
    with RunFolder(tmp_path) as results:
        assert results.start(RUN | {"command": ["other"], "git": None}) == {0}


def test_a_second_run_into_the_same_folder_is_refused(tmp_path: Path) -> None:
    with RunFolder(tmp_path), pytest.raises(ResultsError, match="Another run is writing"):
        RunFolder(tmp_path)
    with RunFolder(tmp_path):
        pass  # free again


def test_the_lock_leaves_no_file_behind(tmp_path: Path) -> None:
    write(tmp_path, [0])
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run.json", "timings.jsonl", "trials.jsonl"]


def test_a_folder_below_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(ResultsError, match="cannot be written"):
        RunFolder(tmp_path / "file" / "run")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write to read-only folders")
def test_a_read_only_folder_is_refused(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(ResultsError, match="cannot be written"):
        RunFolder(tmp_path)


def test_a_full_disk_is_told_and_costs_nothing_that_was_measured(
        tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with RunFolder(tmp_path) as results:
        results.start(RUN)
        results.append(line(0), {"trial": 0})

        def full(descriptor: int) -> None:
            raise OSError(errno.ENOSPC, "No space left on device")

        monkeypatch.setattr("os.fsync", full)
        with pytest.raises(ResultsError, match=r"No space left.*free some space"):
            results.append(line(1), {"trial": 1})
        monkeypatch.undo()
    with RunFolder(tmp_path) as results:
        assert 0 in results.start(RUN)


def test_numbers_that_are_not_finite_are_never_written() -> None:
    with pytest.raises(ValueError, match="JSON"):
        dump({"trial": 0, "x": float("nan")})


@pytest.mark.parametrize("content", ["", "[]", "{}", "{broken"])
def test_a_damaged_run_file_is_refused(tmp_path: Path, content: str) -> None:
    (tmp_path / "run.json").write_text(content)
    with pytest.raises(ResultsError, match=r"run\.json is damaged"):
        load_run(tmp_path)


def test_a_folder_without_a_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ResultsError, match=r"holds no run\.json"):
        load_run(tmp_path)
    with pytest.raises(ResultsError, match="No run in"):
        find_runs(tmp_path)
    with pytest.raises(ResultsError, match="is not a folder"):
        find_runs(tmp_path / "missing")


def test_runs_are_found_at_any_depth_in_order(tmp_path: Path) -> None:
    for name in ("b", "a/deep"):
        write(tmp_path / name, [0])
    assert find_runs(tmp_path) == [tmp_path / "a" / "deep", tmp_path / "b"]
    assert find_runs(tmp_path / "b") == [tmp_path / "b"]


def test_trials_load_as_a_table_in_trial_order(tmp_path: Path) -> None:
    write(tmp_path, [2, 0, 1])
    table = load_trials(tmp_path)
    assert list(table["trial"]) == [0, 1, 2]
    assert table["success"].sum() == 3


def test_a_run_before_its_first_trial_is_an_empty_table(tmp_path: Path) -> None:
    write(tmp_path, [])
    assert load_trials(tmp_path).empty


def test_lines_hold_text_as_it_is(tmp_path: Path) -> None:
    record = line(0) | {"detail": "the “grasp” — 3 µm"}
    with RunFolder(tmp_path) as results:
        results.start(RUN)
        results.append(record, {"trial": 0})
    assert "“grasp” — 3 µm" in (tmp_path / "trials.jsonl").read_text(encoding="utf-8")
    assert json.loads((tmp_path / "trials.jsonl").read_bytes()) == record
