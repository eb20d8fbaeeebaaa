"""The cache: what was used longest ago goes first, and several processes may use it."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path

import pytest
from typer.testing import CliRunner

from grasp_bench.cli import app
from grasp_bench.errors import GraspBenchError
from grasp_bench.system import cache


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache of its own, which may hold three of :func:`put`'s files."""
    monkeypatch.setenv("GRASP_BENCH_CACHE", str(tmp_path))
    monkeypatch.setenv("GRASP_BENCH_CACHE_MB", "3")
    found = cache.folder()
    found.mkdir(parents=True)
    return found


def put(folder: Path, name: str, hours: float) -> Path:
    """A megabyte that was used that long ago."""
    path = folder / name
    path.write_bytes(bytes(10**6))
    when = time.time() - 3600 * hours
    os.utime(path, (when, when))
    return path


def names(folder: Path) -> set[str]:
    return {p.name for p in folder.iterdir()}


def test_what_was_used_longest_ago_goes_first(folder: Path) -> None:
    for i, name in enumerate("abcde"):
        put(folder, name, 10 - i)
    assert cache.used(folder / "a")
    cache.trim()
    assert names(folder) == {"a", "d", "e"}
    assert [e.path.name for e in cache.entries()] == ["a", "e", "d"]


def test_within_the_limit_nothing_goes(folder: Path) -> None:
    for name in "abc":
        put(folder, name, 1000)
    cache.trim()
    assert names(folder) == {"a", "b", "c"}


def test_nothing_is_kept_where_nothing_may(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GRASP_BENCH_CACHE_MB", "0")
    put(folder, "a", 0)
    cache.trim()
    assert names(folder) == set()


def test_what_a_killed_process_was_writing_goes_when_it_is_old(folder: Path) -> None:
    for name, hours in (("old", 2), ("new", 0)):
        (folder / name).mkdir()
        put(folder / name, "model.mjb", 0)
        when = time.time() - 3600 * hours
        os.utime(folder / name, (when, when))
    cache.trim()
    assert names(folder) == {"new"}
    assert cache.entries() == []
    cache.clear()
    assert names(folder) == set()


def test_files_that_vanish_meanwhile_are_no_fault(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    gone = put(folder, "gone", 5)
    kept = [put(folder, name, 1) for name in "abc"]
    listed = cache.entries()
    gone.unlink()
    monkeypatch.setattr(cache, "entries", lambda: listed)
    cache.trim()
    assert not cache.used(gone)
    assert {e.path for e in cache.clear()} == set(kept)


def test_a_folder_that_is_not_there_holds_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GRASP_BENCH_CACHE", str(tmp_path / "nowhere"))
    assert cache.entries() == cache.clear() == []
    cache.trim()


@pytest.mark.parametrize("wrong", ["much", "-1", "1.5", ""])
def test_a_limit_that_is_none_is_refused(wrong: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GRASP_BENCH_CACHE_MB", wrong)
    with pytest.raises(GraspBenchError, match="GRASP_BENCH_CACHE_MB must be a whole number of megabytes"):
        cache.limit()


def test_the_command_shows_and_clears(folder: Path) -> None:
    for name, hours in (("a", 1), ("b", 30), ("c", 30)):
        put(folder, name, hours)
    shown = CliRunner().invoke(app, ["cache"])
    assert shown.output.splitlines() == [
        f"{folder}: 3 models, 3 MB of at most 3 MB",
        "  used today: 1 model, 1 MB",
        "  used this week: 2 models, 2 MB",
    ]
    told = json.loads(CliRunner().invoke(app, ["cache", "--json"]).output)
    assert (told["folder"], told["models"], told["bytes"]) == (str(folder), 3, 3 * 10**6)
    assert (told["limit_bytes"], told["last_used"]["this week"]) == (
        3 * 10**6,
        {"models": 2, "at_rest": 0, "bytes": 2 * 10**6},
    )
    removed = CliRunner().invoke(app, ["cache", "clear"])
    assert removed.output == f"Removed 3 models, 3 MB from {folder}\n"
    assert names(folder) == set()
    assert json.loads(CliRunner().invoke(app, ["cache", "clear", "--json"]).output)["models"] == 0


def test_the_command_tells_objects_at_rest_from_models(folder: Path) -> None:
    for name in ("a.mjb", "b.rest", "c.seen"):
        put(folder, name, 1)
    assert CliRunner().invoke(app, ["cache"]).output.splitlines()[0] == (
        f"{folder}: 1 model, 2 of objects at rest, 3 MB of at most 3 MB"
    )
    told = json.loads(CliRunner().invoke(app, ["cache", "--json"]).output)
    assert (told["models"], told["at_rest"], told["bytes"]) == (1, 2, 3 * 10**6)
    removed = CliRunner().invoke(app, ["cache", "clear"])
    assert removed.output == f"Removed 1 model, 2 of objects at rest, 3 MB from {folder}\n"


def test_writing_keeps_the_folder_within_the_limit(folder: Path) -> None:
    for name in "abc":
        put(folder, name, 5)
    cache.put(folder / "d", lambda fresh: fresh.write_bytes(bytes(10**6)))
    assert len(names(folder)) == 3
    assert "d" in names(folder)


def test_a_folder_that_cannot_be_written_is_no_fault(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    cache.put(tmp_path / "file" / "a", lambda fresh: fresh.write_bytes(b"a"))
