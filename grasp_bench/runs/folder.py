"""A run's folder: ``run.json``, ``trials.jsonl`` and ``timings.jsonl``.

Each trial is appended, flushed and synced as it ends, so a killed run loses at most the
trials in flight. When the run is complete the lines are put in trial order, which makes the
file the same whatever the number of workers.
"""

from __future__ import annotations

import json
import os
from array import array
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import numpy as np

from grasp_bench.errors import ResultsError
from grasp_bench.runs.differences import listed
from grasp_bench.runs.info import RESUMABLE, RUN, RunInfo
from grasp_bench.runs.lines import read_lines, scan
from grasp_bench.runs.record import Timings, TrialRecord
from grasp_bench.runs.schema import strict_json
from grasp_bench.system.files import read_text
from grasp_bench.system.integrity import replacing, sync_folder, write_whole
from grasp_bench.system.locking import Lock

TRIALS, TIMINGS = "trials.jsonl", "timings.jsonl"
ERRORS = "errors.log"
"""Tracebacks of what a predictor raised, to be read by people."""
MOST_ERRORS = 2**22
"""Bytes after which no further traceback is kept."""


class RunFolder:
    """Folder that a run writes to, locked while it is open.

    Args:
        path: created when missing.

    Raises:
        ResultsError: when it cannot be written, or another run is writing to it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        busy = ResultsError(f"Another run is writing to {path}; wait for it or choose --out.")
        try:
            path.mkdir(parents=True, exist_ok=True)
            self._lock = Lock(path / ".lock", busy)
        except OSError as error:
            raise ResultsError(
                f"{path} cannot be written ({error.strerror}); choose another --out."
            ) from error
        self._files: dict[str, int] = {}
        self._raised: dict[str, int] = {}
        self.repaired = False

    def __enter__(self) -> RunFolder:
        return self

    def __exit__(self, *_: object) -> None:
        self._close()
        self._lock.release()

    def _close(self) -> None:
        for file in self._files.values():
            with suppress(OSError):  # all was synced when it was written
                os.close(file)
        self._files.clear()

    def start(self, run: RunInfo, found: Callable[[TrialRecord], None] = lambda record: None) -> set[int]:
        """Begin or resume ``run``, and return the numbers of trials already done.

        Args:
            run: content of ``run.json``.
            found: called with the record of every trial already done.

        Raises:
            ResultsError: when the folder holds another run, naming what differs.
        """
        path = self.path / RUN
        if path.is_file():
            if differs := load_run(self.path).differences(run, *RESUMABLE):
                raise ResultsError(
                    f"{self.path} holds another run: {listed(differs)}. Choose another --out, "
                    "or delete the folder if its results are not wanted."
                )
        elif (self.path / TRIALS).is_file():
            raise ResultsError(
                f"{self.path} holds {TRIALS} without {RUN}, so nobody can tell what was "
                "measured; choose another --out."
            )
        else:
            write_run(path, run)
        for name in (TRIALS, TIMINGS):
            if (self.path / name).is_symlink():
                raise ResultsError(f"{self.path / name} is a link; put its file there to go on with the run.")
        done: set[int] = set()
        sound = 0
        for line in scan(self.path / TRIALS):
            found(line.record)
            done.add(line.record.trial)
            sound = line.start + line.length
        self._cut(TRIALS, sound)
        sound = 0
        for line in scan(self.path / TIMINGS, Timings, unique=False):
            sound = line.start + line.length
        self._cut(TIMINGS, sound)
        return done

    def _cut(self, name: str, sound: int) -> None:
        """Cut off what a kill left behind the last sound line."""
        target = self.path / name
        with _telling(target):
            if target.is_file() and target.stat().st_size > sound:
                self.repaired = True
                with target.open("r+b") as file:
                    file.truncate(sound)
                    os.fsync(file.fileno())

    def append(self, record: TrialRecord, timings: Timings) -> None:
        """Append one trial, so that it survives a kill.

        Raises:
            ResultsError: when the disk is full or the folder has become read-only; what was
                written before is left as it was.
        """
        for name, line in ((TIMINGS, timings), (TRIALS, record)):
            path = self.path / name
            try:
                if name not in self._files:
                    is_new = not path.exists()
                    self._files[name] = os.open(
                        path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_NOFOLLOW, 0o666
                    )
                    if is_new:
                        sync_folder(self.path)
                _append_whole(self._files[name], (line.line() + "\n").encode())
            except OSError as error:
                raise ResultsError(
                    f"{path} cannot be written ({error.strerror}). What was "
                    "measured is kept; free some space and run the same command "
                    "again."
                ) from error

    def note(self, record: TrialRecord, tracebacks: Sequence[str]) -> None:
        """Append what foreign code raised in a trial to ``errors.log``, each traceback once; never raises."""
        path = self.path / ERRORS
        lines = [f"Trial {record.trial} ({record.object}): {record.detail}\n"]
        for text in tracebacks:
            first = self._raised.setdefault(text, record.trial)
            lines.append(text if first == record.trial else f"  as in trial {first}\n")
        with suppress(OSError):
            file = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_NOFOLLOW, 0o666)
            try:
                if os.fstat(file).st_size < MOST_ERRORS:
                    os.write(file, ("".join(lines) + "\n").encode())
            finally:
                os.close(file)

    def finish(self) -> None:
        """Put trials and timings in trial order; files in order are left alone.

        Raises:
            ResultsError: when they cannot be written; the unordered ones are kept.
        """
        self._close()
        join([self.path / TRIALS], self.path / TRIALS)
        join([self.path / TIMINGS], self.path / TIMINGS)


def _append_whole(file: int, line: bytes) -> None:
    """Append and sync a line, or leave the file as it was."""
    before = os.fstat(file).st_size
    try:
        left = memoryview(line)
        while left:
            left = left[os.write(file, left) :]
        os.fsync(file)
    except OSError:
        with suppress(OSError):
            os.ftruncate(file, before)
        raise


def join(sources: Sequence[Path], target: Path) -> None:
    """Write the lines of ``sources`` to ``target`` in trial order, byte for byte.

    Where a trial occurs more than once the last line of the last source is taken. A target
    in order is left alone. Takes 32 bytes of memory a line.

    Raises:
        ResultsError: for a damaged source, or a target that cannot be written.
    """
    kind = Timings if target.name == TIMINGS else TrialRecord
    numbers = array("q")  # trial, source, start, length of each line
    for number, path in enumerate(sources):
        for line in scan(path, kind, unique=False):
            numbers.extend((line.record.trial, number, line.start, line.length))
    lines = np.frombuffer(numbers, dtype=np.int64).reshape(-1, 4)
    if list(sources) == [target] and target.is_file() and bool(np.all(np.diff(lines[:, 0]) > 0)):
        return
    lines = lines[np.argsort(lines[:, 0], kind="stable")]
    is_last = np.ones(len(lines), dtype=bool)
    is_last[:-1] = lines[1:, 0] != lines[:-1, 0]
    lines = lines[is_last]
    with _telling(target), ExitStack() as stack:
        new = stack.enter_context(replacing(target))
        files = [stack.enter_context(p.open("rb")) if p.is_file() else None for p in sources]
        for _, number, start, length in lines.tolist():
            file = files[number]
            assert file is not None
            file.seek(start)
            new.write(file.read(length))


@contextmanager
def _telling(path: Path) -> Iterator[None]:
    """Turn what keeps ``path`` from being written into a ResultsError."""
    try:
        yield
    except OSError as error:
        raise ResultsError(f"{path} cannot be written ({error.strerror}).") from error


def write_run(path: Path, run: RunInfo) -> None:
    """Write ``run.json``.

    Raises:
        ResultsError: when it cannot be written.
    """
    with _telling(path):
        content = json.dumps(run.to_json(), indent=1, ensure_ascii=False, allow_nan=False)
        write_whole(path, (content + "\n").encode())


def load_run(folder: Path) -> RunInfo:
    """Read ``run.json``.

    Raises:
        ResultsError: when it is missing or damaged.
    """
    path = folder / RUN
    try:
        return RunInfo.read(strict_json(read_text(path)))
    except FileNotFoundError as error:
        raise ResultsError(f"{folder} holds no {RUN}; name a folder written by `grasp-bench run`.") from error
    except OSError as error:
        raise ResultsError(f"{path} cannot be read ({error.strerror}).") from error
    except ValueError as error:
        raise ResultsError(
            f"{path} is damaged ({error}); restore it or run again into a new folder."
        ) from error


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


def load_records(folder: Path) -> list[TrialRecord]:
    """Read the trials' records of a run, in trial order.

    Raises:
        ResultsError: when the file is damaged.
    """
    return sorted(read_lines(folder / TRIALS), key=lambda r: r.trial)


def load_timings(folder: Path) -> list[Timings]:
    """Read the timings of a run, one for each trial, in trial order.

    A trial that a kill cut off between its two files has timings of a try that was repeated:
    the last are taken.

    Raises:
        ResultsError: when the file is damaged.
    """
    last = {t.trial: t for t in read_lines(folder / TIMINGS, Timings, unique=False)}
    return [last[trial] for trial in sorted(last)]
