"""Shards: a run in parts, and the parts made into what one machine would have written."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_up_runs import finish, record, write_run

from grasp_bench.errors import GraspBenchError, ResultsError
from grasp_bench.runs.folder import RunFolder, load_records, load_run
from grasp_bench.runs.jobs import Shard, spread
from grasp_bench.runs.merge import merge


@given(st.integers(1, 12), st.integers(0, 300), st.integers(1, 9))
def test_the_shards_of_a_run_are_all_its_trials_once(count: int, trials: int, objects: int) -> None:
    names = [f"o{i}" for i in range(objects)]
    whole = list(spread(names, trials))
    parts = [spread(names, trials, Shard(i + 1, count)) for i in range(count)]
    assert sorted((j for p in parts for j in p), key=lambda j: j.trial) == whole
    assert sum(map(len, parts)) == len(whole)
    assert max(map(len, parts)) - min(map(len, parts)) <= 1
    for part in parts:
        assert all(part.holds(j.trial) and part.job(j.trial) == j for j in part)
        assert [part[i] for i in range(len(part))] == list(part) == part[:]


@pytest.mark.parametrize("text", ["0/4", "5/4", "1", "1/0", "-1/4", "a/b", "1/4/5", "1.5/4", "1/99999999"])
def test_impossible_shards_are_refused(text: str) -> None:
    with pytest.raises(GraspBenchError, match="--shard must be i/N"):
        Shard.parse(text)


def test_a_shard_is_read_as_it_is_written() -> None:
    assert Shard.parse(str(Shard(3, 7))) == Shard(3, 7)


@pytest.fixture
def whole(tmp_path: Path) -> Path:
    return finish(write_run(tmp_path / "whole", wins=lambda t: t % 4 != 1))


def parts(tmp_path: Path, count: int = 3) -> list[Path]:
    return [
        write_run(tmp_path / f"part{i}", wins=lambda t: t % 4 != 1, shard=Shard(i, count), order=-1)
        for i in range(1, count + 1)
    ]


@pytest.mark.parametrize("count", [1, 2, 3, 9])
def test_merged_shards_are_the_bytes_of_an_unbroken_run(tmp_path: Path, whole: Path, count: int) -> None:
    merged = merge(tmp_path / "merged", parts(tmp_path, count)[::-1])
    assert (merged.trials, merged.planned, merged.repeated, merged.notes) == (9, 9, 0, ())
    for name in ("trials.jsonl", "timings.jsonl"):
        assert (tmp_path / "merged" / name).read_bytes() == (whole / name).read_bytes()
    merged_run = load_run(tmp_path / "merged")
    assert merged_run.model_copy(update={"command": load_run(whole).command}) == load_run(whole)


def test_missing_trials_are_named_with_what_to_do(tmp_path: Path) -> None:
    folders = parts(tmp_path)
    broken = write_run(tmp_path / "broken", shard=Shard(2, 3), only=[1, 7])
    with pytest.raises(ResultsError) as caught:
        merge(tmp_path / "merged", [folders[0], broken])
    text = str(caught.value)
    assert "4 of 9 trials are missing: 2, 4, 5, 8." in text
    assert f"{broken} (shard 2/3) still has 1 to do: run its command again." in text
    assert "Not among the folders: shard 3/3." in text
    assert not (tmp_path / "merged").exists()


def test_a_part_may_be_merged_and_the_rest_done_later(tmp_path: Path, whole: Path) -> None:
    merged = merge(tmp_path / "merged", parts(tmp_path)[:2], partial=True)
    assert (merged.trials, merged.planned) == (6, 9)
    with RunFolder(tmp_path / "merged") as results:
        assert results.start(load_run(whole)) == {0, 1, 3, 4, 6, 7}


def test_a_trial_in_two_shards_with_the_same_record_is_kept_once(tmp_path: Path, whole: Path) -> None:
    again = write_run(tmp_path / "again", wins=lambda t: t % 4 != 1, only=[0, 5])
    assert merge(tmp_path / "merged", [*parts(tmp_path), again]).repeated == 2
    assert (tmp_path / "merged" / "trials.jsonl").read_bytes() == (whole / "trials.jsonl").read_bytes()


def test_a_trial_in_two_shards_with_other_records_is_refused(tmp_path: Path) -> None:
    other = write_run(
        tmp_path / "other", wins=lambda t: t % 4 != 1, only=[0, 3], change=lambda r: r | {"lift_height": 0.19}
    )
    with pytest.raises(ResultsError, match=r"disagree on trial 0 \(mug\) in .*part1 and .*other; trial 3"):
        merge(tmp_path / "merged", [*parts(tmp_path), other])
    assert not (tmp_path / "merged").exists()


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("seed", 5, r"the seed \(4 in .*part1, 5 in .*other\)"),
        ("versions", {"mujoco": "3.18"}, r"the software versions \(mujoco: 3\.17 in"),
        (
            "scenario",
            {"name": "table4", "gripper": {"force": 80}},
            r"the scenario \(gripper only in .*other\)",
        ),
        ("weights", {"w": "ab"}, "the weights"),
        ("trials", 12, "the number of trials"),
        ("renderer", "egl", "the renderer"),
    ],
)
def test_shards_of_other_settings_are_refused_by_what_differs(
    tmp_path: Path, key: str, value: Any, words: str
) -> None:
    other = write_run(tmp_path / "other", only=[], **{key: value})
    with pytest.raises(ResultsError, match=f"are not of one run: {words}"):
        merge(tmp_path / "merged", [*parts(tmp_path), other])


def test_shards_of_different_machines_are_merged_with_a_word(tmp_path: Path) -> None:
    folders = [*parts(tmp_path)[:2], write_run(tmp_path / "far", shard=Shard(3, 3), cpu="two")]
    (note,) = merge(tmp_path / "merged", folders).notes
    assert "the cpu (one in" in note
    assert "two in" in note


@pytest.mark.parametrize(
    ("shard", "change", "words"),
    [
        (Shard(1, 3), {"object": "pot"}, "holds trial 0 on pot, which is none of its own"),
        (Shard(1, 3), {"seed": 9}, "holds trial 0 of seed 9, but its run.json says 4"),
    ],
)
def test_a_folder_whose_files_were_mixed_up_is_refused(
    tmp_path: Path, shard: Shard, change: dict, words: str
) -> None:
    mixed = write_run(tmp_path / "mixed", shard=shard, change=lambda r: r | change)
    with pytest.raises(ResultsError, match=words):
        merge(tmp_path / "merged", [mixed])


def test_a_trial_of_another_shard_is_refused(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "part", shard=Shard(2, 3))
    run = load_run(folder).to_json() | {"shard": "1/3"}
    (folder / "run.json").write_text(json.dumps(run))
    with pytest.raises(ResultsError, match="which is none of its own"):
        merge(tmp_path / "merged", [folder])


@pytest.mark.parametrize(
    "change", [{"shard": "4/3"}, {"shard": 1}, {"trials": 0}, {"trials": 10**12}, {"objects": {}}]
)
def test_damaged_run_files_of_shards_are_refused(tmp_path: Path, change: dict) -> None:
    folder = write_run(tmp_path / "part", only=[])
    (folder / "run.json").write_text(json.dumps(load_run(folder).to_json() | change))
    with pytest.raises(ResultsError, match=r"run\.json is damaged"):
        merge(tmp_path / "merged", [folder])


def test_a_folder_that_holds_a_run_is_not_written_to(tmp_path: Path, whole: Path) -> None:
    with pytest.raises(ResultsError, match="holds a run already"):
        merge(whole, parts(tmp_path))


def test_a_shards_table_is_its_own_trials(tmp_path: Path) -> None:
    folder = write_run(tmp_path / "part", shard=Shard(2, 4))
    assert [r.trial for r in load_records(folder)] == [1, 5]
    assert record(3)["object"] == "mug"
