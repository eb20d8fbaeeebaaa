"""``why.jsonl``: replays of a run's failed trials, a line each, so that an interrupted study goes on.

Lines are read with suspicion: one that is damaged, of a record that is no longer the run's, or of another
version of the package costs its replay only, which is done again.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path
from typing import Annotated

from pydantic import Field

from grasp_bench.errors import ResultsError
from grasp_bench.replay.verdict import Verdict
from grasp_bench.runs.lines import LONGEST_LINE
from grasp_bench.runs.record import TrialRecord
from grasp_bench.runs.schema import Count, Stored, Text, strict_json
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.studies.why.causes import KEYS, Removed
from grasp_bench.system.locking import Lock

WHY = "why.jsonl"
STUDY = 1
"""Version of the interventions: replays of another one are done again."""


class Replayed(Stored):
    """A line of ``why.jsonl``.

    Attributes:
        trial: its number in the run.
        without: keys of the causes that were removed; none for the trial as it was.
        outcome: how the replay ended.
        verdict: of a trial done again as it was, how that compares with its record; empty otherwise.
        of: digest of the record and of what replayed it.
    """

    trial: Count
    without: tuple[Text, ...]
    outcome: Annotated[Outcome, Field(description=f"one of {', '.join(map(str, Outcome))}")]
    verdict: Annotated[
        Verdict | None, Field(description=f"null or one of {', '.join(map(str, Verdict))}")
    ] = None
    of: Text

    @property
    def removed(self) -> Removed:
        """The causes that were removed."""
        return Removed(self.without)

    @property
    def success(self) -> bool:
        """Whether the trial succeeded then."""
        return self.outcome is Outcome.SUCCESS


def digest_of(record: TrialRecord) -> str:
    """Return a digest of a trial's record and of what its replays depend on beside it."""
    versions = [f"{name} {version(name)}" for name in ("grasp-bench", "mujoco")]
    return hashlib.sha256("\n".join([record.line(), str(STUDY), *versions]).encode()).hexdigest()[:16]


class Journal:
    """The file of a study's replays, locked while it is open.

    Args:
        path: created when the first line is written.

    Attributes:
        damaged: number of lines that could not be read.

    Raises:
        ResultsError: when it cannot be written, or another study is writing to it.
    """

    def __init__(self, path: Path) -> None:
        self.path, self.damaged = path, 0
        if path.is_symlink() or (path.exists() and not path.is_file()):
            raise ResultsError(f"{path} is a link or no file; name another one with --out.")
        busy = ResultsError(f"Another study is writing to {path}; wait for it.")
        try:
            self._lock = Lock(path.with_name(f".{path.name}.lock"), busy)
        except OSError as error:
            raise ResultsError(
                f"{path} cannot be written ({error.strerror}); name another one with --out."
            ) from error

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *_: object) -> None:
        self._lock.release()

    def read(self, wanted: Iterable[TrialRecord]) -> dict[int, dict[Removed, Replayed]]:
        """Return the replays of some trials that the file holds, by trial and by what was removed.

        Raises:
            ResultsError: when the file cannot be read.
        """
        digests = {r.trial: digest_of(r) for r in wanted}
        found: dict[int, dict[Removed, Replayed]] = {}
        try:
            with self.path.open("rb") as file:
                while raw := file.readline(LONGEST_LINE + 1):
                    try:
                        replayed = Replayed.read(strict_json(raw.decode()))
                    except ValueError:
                        self.damaged += 1
                        continue
                    known = replayed.removed <= set(KEYS)
                    if known and digests.get(replayed.trial) == replayed.of:
                        found.setdefault(replayed.trial, {})[replayed.removed] = replayed
        except FileNotFoundError:
            return {}
        except OSError as error:
            raise ResultsError(f"{self.path} cannot be read ({error.strerror}).") from error
        return found

    def append(self, replays: Iterable[Replayed]) -> None:
        """Append replays, so that they survive a kill.

        Raises:
            ResultsError: when the disk is full or the folder read-only.
        """
        text = "".join(json.dumps(r.to_json(), ensure_ascii=False) + "\n" for r in replays).encode()
        if not text:
            return
        try:
            with os.fdopen(
                os.open(self.path, os.O_RDWR | os.O_APPEND | os.O_CREAT | os.O_NOFOLLOW, 0o666), "r+b"
            ) as file:
                if (size := file.seek(0, os.SEEK_END)) > 0:
                    file.seek(size - 1)
                    text = text if file.read(1) == b"\n" else b"\n" + text  # a kill left half a line
                file.write(text)
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise ResultsError(
                f"{self.path} cannot be written ({error.strerror}). What was replayed is kept; the same "
                "command goes on."
            ) from error
