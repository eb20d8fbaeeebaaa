"""A run's folder: ``run.json``, ``trials.jsonl`` and ``timings.jsonl``.

Each trial is appended, flushed and synced as it ends, so a killed run loses at most the
trials in flight. When the run is complete the lines are put in trial order, which makes the
file the same whatever the number of workers.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from filelock import FileLock, Timeout

from grasp_bench.errors import ResultsError

if TYPE_CHECKING:
    import pandas as pd

RUN, TRIALS, TIMINGS = "run.json", "trials.jsonl", "timings.jsonl"
IDENTITY = ("predictor", "scenario", "seed", "trials", "objects", "weights", "versions", "renderer")
"""Keys of ``run.json`` that must agree before a run may be resumed."""


def dump(record: dict[str, Any]) -> str:
    """One line of JSON, always the same for the same record."""
    return json.dumps(record, ensure_ascii=False, separators=(", ", ": "), allow_nan=False)


def read_lines(path: Path) -> tuple[list[dict[str, Any]], int]:
    """Records of a jsonlines file, and the length in bytes of its sound part.

    A torn last line, as a kill leaves it, is left out.

    Raises:
        ResultsError: for a damaged line before the last.
    """
    if not path.is_file():
        return [], 0
    raw = path.read_bytes()
    records: list[dict[str, Any]] = []
    sound = 0
    for number, line in enumerate(raw.splitlines(keepends=True), 1):
        try:
            if not line.endswith(b"\n"):
                raise ValueError("no newline at its end")
            record = json.loads(line)
            if not isinstance(record, dict) or "trial" not in record:
                raise ValueError("not a trial")
        except ValueError as error:
            if sound + len(line) == len(raw):
                break
            raise ResultsError(f"{path}, line {number} is damaged ({error}). Restore the file, or delete "
                               "that line and run the same command again to repeat the trial.") from error
        records.append(record)
        sound += len(line)
    return records, sound


class RunFolder:
    """The folder a run writes to, locked while it is open.

    Args:
        path: created when missing.

    Raises:
        ResultsError: when it cannot be written, or another run is writing to it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            path.mkdir(parents=True, exist_ok=True)
            self._lock = FileLock(path / ".lock")
            self._lock.acquire(timeout=0)
        except Timeout as error:
            raise ResultsError(f"Another run is writing to {path}; wait for it or choose --out.") from error
        except OSError as error:
            raise ResultsError(f"{path} cannot be written ({error.strerror}); "
                               "choose another --out.") from error
        self._files: dict[str, Any] = {}
        self.repaired = False

    def __enter__(self) -> RunFolder:
        return self

    def __exit__(self, *_: object) -> None:
        for file in self._files.values():
            file.close()
        (self.path / ".lock").unlink(missing_ok=True)
        self._lock.release()

    def start(self, run: dict[str, Any]) -> set[int]:
        """Begin or resume ``run``; the numbers of trials already done.

        Raises:
            ResultsError: when the folder holds another run, naming what differs.
        """
        path = self.path / RUN
        if path.is_file():
            before = load_run(self.path)
            differs = [k for k in IDENTITY if before.get(k) != json.loads(json.dumps(run.get(k)))]
            if differs:
                raise ResultsError(f"{self.path} holds another run: {', '.join(map(_named, differs))} "
                                   f"differ{'s' if len(differs) == 1 else ''}. Choose another --out, or "
                                   "delete the folder if its results are not wanted.")
        else:
            _write_synced(path, json.dumps(run, indent=1, ensure_ascii=False) + "\n")
        done = set()
        for name in (TRIALS, TIMINGS):
            records, sound = read_lines(self.path / name)
            if name == TRIALS:
                done = {r["trial"] for r in records}
            target = self.path / name
            if target.is_file() and target.stat().st_size > sound:
                self.repaired = True
                with target.open("r+b") as file:
                    file.truncate(sound)
        return done

    def append(self, record: dict[str, Any], timings: dict[str, Any]) -> None:
        """Write one trial, so that it survives a kill.

        Raises:
            ResultsError: when the disk is full or the folder has become read-only.
        """
        for name, line in ((TIMINGS, timings), (TRIALS, record)):
            try:
                if name not in self._files:
                    self._files[name] = (self.path / name).open("ab")
                file = self._files[name]
                file.write((dump(line) + "\n").encode())
                file.flush()
                os.fsync(file.fileno())
            except OSError as error:
                raise ResultsError(f"{self.path / name} cannot be written ({error.strerror}). What was "
                                   "measured is kept; free some space and run the same command "
                                   "again.") from error

    def finish(self) -> None:
        """Put trials and timings in trial order; files that are so already are left alone."""
        for file in self._files.values():
            file.close()
        self._files.clear()
        for name in (TRIALS, TIMINGS):
            path = self.path / name
            records, _ = read_lines(path)
            ordered = sorted({r["trial"]: r for r in records}.values(), key=lambda r: r["trial"])
            text = "".join(dump(r) + "\n" for r in ordered)
            if not path.is_file() or path.read_bytes() != text.encode():
                _write_synced(path, text)


def _named(key: str) -> str:
    return {"objects": "the objects or their files", "weights": "the weights",
            "versions": "the software versions", "trials": "the number of trials"}.get(key, f"the {key}")


def _write_synced(path: Path, text: str) -> None:
    try:
        temporary = path.with_name(path.name + ".tmp")
        with temporary.open("w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    except OSError as error:
        raise ResultsError(f"{path} cannot be written ({error.strerror}).") from error


def load_run(folder: Path) -> dict[str, Any]:
    """The content of ``run.json``.

    Raises:
        ResultsError: when it is missing or damaged.
    """
    path = folder / RUN
    try:
        run = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(run, dict) or "predictor" not in run:
            raise ValueError("it does not describe a run")
        return run
    except FileNotFoundError as error:
        raise ResultsError(f"{folder} holds no {RUN}; name a folder written by `grasp-bench run`.") from error
    except ValueError as error:
        raise ResultsError(f"{path} is damaged ({error}); "
                           "restore it or run again into a new folder.") from error


def find_runs(root: Path) -> list[Path]:
    """Run folders at or below ``root``, sorted.

    Raises:
        ResultsError: when there is none.
    """
    if not root.is_dir():
        raise ResultsError(f"{root} is not a folder; name a results folder, e.g. results/.")
    found = sorted(p.parent for p in root.rglob(RUN))
    if not found:
        raise ResultsError(f"No run in {root}: run `grasp-bench run` first, or name another folder.")
    return found


def load_trials(folder: Path) -> pd.DataFrame:
    """The trials of a run, one row each, in trial order.

    Raises:
        ResultsError: when the file is damaged.
    """
    import pandas as pd

    records, _ = read_lines(folder / TRIALS)
    return pd.DataFrame(sorted(records, key=lambda r: r["trial"]))


def iter_timings(folder: Path) -> Iterator[dict[str, Any]]:
    """Records of ``timings.jsonl``."""
    yield from read_lines(folder / TIMINGS)[0]
