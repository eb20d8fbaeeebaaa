"""A run's folder: appended, resumed, repaired, refused."""

from __future__ import annotations

import errno
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from grasp_bench.errors import ResultsError
from grasp_bench.runs.folder import RunFolder, find_runs, load_records, load_run, load_timings
from grasp_bench.runs.info import RunInfo
from grasp_bench.runs.lines import read_lines, scan
from grasp_bench.runs.record import Timings, TrialRecord
from grasp_bench.runs.results import RunResults

RUN: dict[str, Any] = {
    "format": 1,
    "predictor": "oracle",
    "scenario": {"name": "table4", "gripper": {"force": 60.0}},
    "seed": 0,
    "trials": 4,
    "objects": {"mug": {"object.json": "ab"}},
    "weights": None,
    "versions": {"mujoco": "3.17"},
    "renderer": "raycast",
}


def info(**changes: Any) -> RunInfo:
    return RunInfo.read(RUN | changes)


def line(trial: int, **changes: Any) -> TrialRecord:
    return TrialRecord.read(
        {"trial": trial, "object": "mug", "category": "mug", "outcome": "success"} | changes
    )


def timings(trial: int, **seconds: float) -> Timings:
    return Timings.read({"trial": trial, **seconds})


def write(folder: Path, trials: list[int], finish: bool = False, **changes: Any) -> None:
    with RunFolder(folder) as results:
        results.start(info(**changes))
        for trial in trials:
            results.append(line(trial), timings(trial, plan=0.5))
        if finish:
            results.finish()


def numbers(folder: Path) -> list[int]:
    """Of the trials in a folder, in the order of the file."""
    return [record.trial for record in read_lines(folder / "trials.jsonl")]


def test_what_is_appended_is_read_back(tmp_path: Path) -> None:
    write(tmp_path / "run", [0, 1, 2])
    path = tmp_path / "run" / "trials.jsonl"
    assert read_lines(path) == [line(0), line(1), line(2)]
    *_, last = scan(path)
    assert last.start + last.length == path.stat().st_size
    assert load_run(tmp_path / "run") == info()
    assert [t.seconds for t in load_timings(tmp_path / "run")] == [{"plan": 0.5}] * 3


def test_each_trial_is_on_disk_before_the_next(tmp_path: Path) -> None:
    with RunFolder(tmp_path) as results:
        results.start(info())
        results.append(line(0), timings(0))
        assert (tmp_path / "trials.jsonl").read_text() == line(0).line() + "\n"


def test_resuming_tells_what_was_done(tmp_path: Path) -> None:
    write(tmp_path, [0, 2])
    with RunFolder(tmp_path) as results:
        assert results.start(info()) == {0, 2}
        assert not results.repaired


def test_a_finished_run_is_in_trial_order(tmp_path: Path) -> None:
    write(tmp_path, [2, 0, 1], finish=True)
    assert numbers(tmp_path) == [0, 1, 2]
    assert [t.trial for t in read_lines(tmp_path / "timings.jsonl", Timings)] == [0, 1, 2]
    assert not list(tmp_path.glob("*.part"))


def test_a_run_without_timings_is_finished_all_the_same(tmp_path: Path) -> None:
    write(tmp_path, [1, 0])
    (tmp_path / "timings.jsonl").unlink()
    write(tmp_path, [], finish=True)
    assert numbers(tmp_path) == [0, 1]
    assert (tmp_path / "timings.jsonl").read_bytes() == b""


def test_of_timings_of_a_repeated_trial_the_last_are_kept(tmp_path: Path) -> None:
    write(tmp_path, [1])
    with (tmp_path / "timings.jsonl").open("a") as file:  # a kill between the two files
        file.write('{"trial": 0, "plan": 1.5}\n')
    write(tmp_path, [0], finish=True)
    assert (tmp_path / "timings.jsonl").read_text().splitlines() == [
        '{"trial": 0, "plan": 0.5}',
        '{"trial": 1, "plan": 0.5}',
    ]
    assert [t.seconds["plan"] for t in load_timings(tmp_path)] == [0.5, 0.5]


@pytest.mark.parametrize("torn", ['{"trial": 3, "obj', '{"trial": 3}', "\x00\x00\x00", "\x00\x00\n", "{\n"])
def test_a_torn_last_line_is_cut_off_and_the_trial_done_again(tmp_path: Path, torn: str) -> None:
    write(tmp_path, [0, 1])
    with (tmp_path / "trials.jsonl").open("a") as file:
        file.write(torn)
    with RunFolder(tmp_path) as results:
        assert results.start(info()) == {0, 1}
        assert results.repaired
        results.append(line(3), timings(3))
    assert numbers(tmp_path) == [0, 1, 3]


def test_a_torn_line_of_timings_is_repaired_too(tmp_path: Path) -> None:
    write(tmp_path, [0, 1])
    with (tmp_path / "timings.jsonl").open("a") as file:
        file.write('{"tri')
    with RunFolder(tmp_path) as results:
        assert results.start(info()) == {0, 1}
        assert results.repaired
    assert (tmp_path / "timings.jsonl").read_text().endswith("}\n")


def test_a_damaged_line_in_the_middle_is_refused_by_its_number(tmp_path: Path) -> None:
    write(tmp_path, [0, 1, 2])
    path = tmp_path / "trials.jsonl"
    lines = path.read_text().splitlines(keepends=True)
    path.write_text(lines[0] + lines[1][:20] + "\n" + lines[2])
    before = path.read_bytes()
    with RunFolder(tmp_path) as results, pytest.raises(ResultsError, match=r"trials\.jsonl, line 2 is dam"):
        results.start(info())
    assert path.read_bytes() == before
    with pytest.raises(ResultsError, match="line 2"):
        load_records(tmp_path)


@pytest.mark.parametrize(
    ("key", "value", "named"),
    [
        (
            "scenario",
            {"name": "table4", "gripper": {"force": 80.0}},
            "the scenario (gripper.force: 60.0 there, 80.0 here)",
        ),
        ("predictor", "random", "the predictor (oracle there, random here)"),
        ("seed", 1, "the seed (0 there, 1 here)"),
        ("trials", 9, "the number of trials (4 there, 9 here)"),
        (
            "objects",
            {"mug": {"object.json": "cd"}},
            "the objects or their files (mug.object.json: ab there, cd here)",
        ),
        ("objects", {"mug": {"object.json": "ab"}, "pan": {}}, "the objects or their files (pan only here)"),
        ("weights", {"w": "ef" * 32}, 'the weights (none there, {"w": "efef'),
        ("versions", {"mujoco": "3.18"}, "the software versions (mujoco: 3.17 there, 3.18 here)"),
        ("renderer", "egl", "the renderer (raycast there, egl here)"),
        ("shard", "2/4", "the shard (none there, 2/4 here)"),
    ],
)
def test_another_run_in_the_folder_is_refused_by_what_differs(
    tmp_path: Path, key: str, value: Any, named: str
) -> None:
    write(tmp_path, [0])
    with RunFolder(tmp_path) as results, pytest.raises(ResultsError) as caught:
        results.start(info(**{key: value}))
    assert f"holds another run: {named}" in str(caught.value)
    assert "differs. Choose another --out" in str(caught.value)
    assert str(tmp_path) in str(caught.value)
    assert numbers(tmp_path) == [0]


def test_all_that_differs_is_named(tmp_path: Path) -> None:
    write(tmp_path, [0])
    with (
        RunFolder(tmp_path) as results,
        pytest.raises(ResultsError, match=r"the predictor \(.*\), the seed \(.*\) differ\."),
    ):
        results.start(info(seed=5, predictor="random"))


def test_objects_in_another_order_are_another_run(tmp_path: Path) -> None:
    two = {"mug": {"a": "1"}, "pan": {"a": "2"}}
    write(tmp_path, [0], objects=two)
    with RunFolder(tmp_path) as results, pytest.raises(ResultsError, match="in another order"):
        results.start(info(objects=dict(reversed(two.items()))))


def test_many_differences_are_counted(tmp_path: Path) -> None:
    write(tmp_path, [0], versions={f"v{i}": "1" for i in range(9)})
    with RunFolder(tmp_path) as results, pytest.raises(ResultsError, match="v3: 1 there, 2 here; and 5 more"):
        results.start(info(versions={f"v{i}": "2" for i in range(9)}))


def test_what_may_differ_between_calls_does_not_hinder_resuming(tmp_path: Path) -> None:
    write(tmp_path, [0], command=["grasp-bench", "run"], git="abc")
    with RunFolder(tmp_path) as results:
        assert results.start(info(command=["other"], git=None)) == {0}


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


def test_a_failing_disk_is_told_and_costs_nothing_that_was_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with RunFolder(tmp_path) as results:
        results.start(info())
        results.append(line(0), timings(0))

        def fails(descriptor: int) -> None:
            raise OSError(errno.EIO, "Input/output error")

        monkeypatch.setattr("os.fsync", fails)
        with pytest.raises(ResultsError, match=r"Input/output error.*free some space"):
            results.append(line(1), timings(1))
        monkeypatch.undo()
    with RunFolder(tmp_path) as results:
        assert results.start(info()) == {0}
        assert not results.repaired


FULL = """
import json, resource, signal, sys
from pathlib import Path
from grasp_bench.errors import ResultsError
from grasp_bench.runs.folder import RunFolder
from grasp_bench.runs.info import RunInfo
from grasp_bench.runs.record import Timings, TrialRecord
folder, run, record = Path(sys.argv[1]), json.loads(sys.argv[2]), json.loads(sys.argv[3])
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
with RunFolder(folder) as results:
    results.start(RunInfo.read(run))
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
    for trial in range(100):
        try:
            results.append(TrialRecord.read(record | {"trial": trial}), Timings(trial=trial))
        except ResultsError as error:
            print(trial, error)
            break
"""


def test_when_no_more_can_be_written_whole_lines_stay_and_the_run_goes_on_later(tmp_path: Path) -> None:
    """A process that may write files of 1000 bytes only meets what a full disk does: half a line."""
    done = subprocess.run(
        [sys.executable, "-c", FULL, tmp_path, json.dumps(RUN), line(0).line()],
        text=True,
        capture_output=True,
        timeout=60,
        check=True,
    )
    trial, _, message = done.stdout.partition(" ")
    assert "trials.jsonl cannot be written (File too large)" in message
    assert "What was measured is kept" in message
    assert numbers(tmp_path) == list(range(int(trial)))
    *_, last = scan(tmp_path / "trials.jsonl")
    assert last.start + last.length == (tmp_path / "trials.jsonl").stat().st_size
    with RunFolder(tmp_path) as results:
        assert results.start(info()) == set(range(int(trial)))
        assert not results.repaired
        results.append(line(int(trial)), timings(int(trial)))


def test_a_full_disk_at_the_end_keeps_the_unordered_trials(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path, [1, 0])
    before = (tmp_path / "trials.jsonl").read_bytes()

    def full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with RunFolder(tmp_path) as results:
        results.start(info())
        monkeypatch.setattr("os.fsync", full)
        with pytest.raises(ResultsError, match=r"trials\.jsonl cannot be written \(No space left"):
            results.finish()
        monkeypatch.undo()
    assert (tmp_path / "trials.jsonl").read_bytes() == before
    assert not list(tmp_path.glob("*.part"))


def brief(trial: int) -> str:
    """A line with the keys that none lacks, and no others."""
    content = {
        "trial": trial, "object": "mug", "category": "mug", "outcome": "success", "success": True
    }  # fmt: skip
    return json.dumps(content) + "\n"


SOUND = brief(0) + brief(1)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (SOUND + brief(1) + brief(2), "line 3 is damaged (trial 1 is in it a second"),
        (SOUND + brief(0), "line 3 is damaged (trial 0 is in it a second time)"),
        (SOUND + '{"other": 1}\n', "line 3 is damaged ('trial' is missing)"),
        (SOUND.replace('"trial": 1', '"trial": NaN'), "line 2 is damaged (NaN is no number)"),
        (SOUND.replace('"trial": 1', '"trial": -1'), "'trial' must be a whole number from 0, not -1"),
        (SOUND.replace('"trial": 1', '"trial": 1.0'), "'trial' must be a whole number from 0, not 1.0"),
        (SOUND.replace('"trial": 1', '"trial": true'), "'trial' must be a whole number from 0, not True"),
        (SOUND.replace('"trial": 1', '"trial": "1"'), "'trial' must be a whole number from 0, not '1'"),
        (SOUND.replace('"trial": 1', '"lift_height": Infinity, "trial": 1'), "Infinity is no number"),
        (
            SOUND.replace('"trial": 1', '"lift_height": "a", "trial": 1'),
            "'lift_height' must be a number, not",
        ),
        (
            SOUND.replace('"trial": 1', '"rank": -1, "trial": 1'),
            "'rank' must be a whole number from 0 or null",
        ),
        (SOUND.replace('"trial": 1', '"grasp": [], "trial": 1'), "'grasp' must be an object or null, not []"),
        (SOUND.replace('"object": "mug"', '"object": 7'), "line 1 is damaged ('object' must be text, not 7)"),
        (SOUND.replace('"category": "mug", ', ""), "line 1 is damaged ('category' is missing)"),
        (
            SOUND.replace('"outcome": "success"', '"outcome": "won"'),
            "'outcome' must be one of success, no_grasp",
        ),
        (SOUND.replace('"outcome": "success"', '"outcome": ["success"]'), "'outcome' must be one of"),
        (SOUND.replace("true", '"yes"'), "'success' must be true or false, not 'yes'"),
        (SOUND.replace("true", "false"), "'success' is False where the outcome is 'success'"),
        ("[1, 2]\n" + SOUND, "line 1 is damaged ([1, 2] is not a record)"),
        ("5\n", "line 1 is damaged (5 is not a record)"),
        ("\n" + SOUND, "line 1 is damaged"),
        ("\udcff\n" + SOUND, "line 1 is damaged"),
        ("[" * 100_000 + "\n" + SOUND, "line 1 is damaged (nested too deeply)"),
        (" " * (1 << 21) + SOUND, "line 1 is damaged (longer than 1 MiB)"),
    ],
    ids=range(24),
)
def test_a_wrong_line_is_one_clear_error_wherever_it_is_read(
    tmp_path: Path, content: str, message: str
) -> None:
    write(tmp_path, [])
    path = tmp_path / "trials.jsonl"
    path.write_bytes(content.encode(errors="surrogateescape"))
    before = path.read_bytes()
    with pytest.raises(ResultsError) as caught:
        load_records(tmp_path)
    assert str(path) in str(caught.value)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)
    with RunFolder(tmp_path) as results, pytest.raises(ResultsError, match="is damaged"):
        results.start(info())
    assert path.read_bytes() == before


@pytest.mark.parametrize("content", ['{"trial": 0, "plan": "a"}\n', '{"plan": 1}\n', '{"trial": NaN}\n'])
def test_wrong_timings_are_one_clear_error(tmp_path: Path, content: str) -> None:
    write(tmp_path, [0])
    (tmp_path / "timings.jsonl").write_text(content)
    with pytest.raises(ResultsError, match=r"timings\.jsonl, line 1 is damaged"):
        load_timings(tmp_path)


def test_trials_without_a_run_are_never_added_to(tmp_path: Path) -> None:
    write(tmp_path, [0])
    (tmp_path / "run.json").unlink()
    with RunFolder(tmp_path) as results, pytest.raises(ResultsError, match=r"without run\.json"):
        results.start(info())


def test_numbers_that_are_not_finite_are_never_written() -> None:
    with pytest.raises(ValueError, match="JSON"):
        line(0, x=float("nan")).line()


@pytest.mark.parametrize(
    "content",
    [
        "",
        "[]",
        "{}",
        "{broken",
        "\x00" * 40,
        "[" * 100_000,
        json.dumps(RUN | {"seed": "0"}),
        json.dumps(RUN | {"trials": True}),
        json.dumps(RUN | {"scenario": "table4"}),
        json.dumps(RUN | {"scenario": {}}),
        json.dumps(RUN | {"objects": []}),
        json.dumps(RUN | {"format": 2}),
        json.dumps({k: v for k, v in RUN.items() if k != "renderer"}),
    ],
    ids=range(13),
)
def test_a_damaged_run_file_is_refused(tmp_path: Path, content: str) -> None:
    (tmp_path / "run.json").write_text(content)
    with pytest.raises(ResultsError, match=r"run\.json is damaged"):
        load_run(tmp_path)


def test_a_run_file_that_cannot_be_read_is_refused(tmp_path: Path) -> None:
    (tmp_path / "run.json").mkdir()
    with pytest.raises(ResultsError, match=r"run\.json cannot be read"):
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
    table = RunResults(tmp_path).trials
    assert list(table["trial"]) == [0, 1, 2]
    assert table["success"].sum() == 3


def test_a_run_before_its_first_trial_is_an_empty_table(tmp_path: Path) -> None:
    write(tmp_path, [])
    assert RunResults(tmp_path).trials.empty


def test_lines_hold_text_as_it_is(tmp_path: Path) -> None:
    record = line(0, detail="the “grasp” — 3 µm")
    with RunFolder(tmp_path) as results:
        results.start(info())
        results.append(record, timings(0))
    assert "“grasp” — 3 µm" in (tmp_path / "trials.jsonl").read_text(encoding="utf-8")
    assert json.loads((tmp_path / "trials.jsonl").read_bytes()) == record.to_json()
