"""Lines of ``trials.jsonl`` and ``timings.jsonl``, read one by one and checked.

Files may be larger than memory: nothing here holds more than a line, except the trials' numbers.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Generic, NamedTuple, TypeVar

from grasp_bench.errors import ResultsError
from grasp_bench.runs.record import Timings, TrialRecord
from grasp_bench.runs.schema import strict_json

LONGEST_LINE = 1 << 20
"""No line of a results file is longer than this [bytes]; what is longer was not written by grasp-bench."""


Kind = TypeVar("Kind", bound=TrialRecord | Timings)


class Line(NamedTuple, Generic[Kind]):
    """A sound line of a results file: its content, and its place and length in the file [bytes]."""

    record: Kind
    start: int
    length: int


def parse(line: bytes, kind: type[Kind]) -> Kind:
    """Return the record in a line; ValueError for what is not one whole line with a sound record."""
    if not line.endswith(b"\n"):
        raise ValueError("no newline at its end" if len(line) <= LONGEST_LINE else "longer than 1 MiB")
    return kind.read(strict_json(line.decode()))


def scan(path: Path, kind: type[Kind] = TrialRecord, *, unique: bool = True) -> Iterator[Line[Kind]]:
    """Yield the lines of a file, in its order; none where there is no file.

    A torn last line (without a newline, or not JSON), as a kill or a power cut leaves it, is
    left out: compare the last line's end with the file's size.

    Args:
        path: file to read.
        kind: class of its records.
        unique: refuse a trial that occurs twice.

    Raises:
        ResultsError: for a damaged, wrong or repeated line, with its number.
    """
    if not path.is_file():
        return
    start = 0
    seen: set[int] = set()
    try:
        with path.open("rb") as file:
            number = 0
            while raw := file.readline(LONGEST_LINE + 1):
                number += 1
                try:
                    record = parse(raw, kind)
                    if unique and record.trial in seen:
                        raise _WrongPlaceError(f"trial {record.trial} is in it a second time")
                except ValueError as error:
                    if _may_be_torn(raw, error) and not file.read(1):
                        return
                    raise ResultsError(
                        f"{path}, line {number} is damaged ({error}). Restore the file, or delete that line "
                        "and run the same command again to repeat the trial."
                    ) from error
                if unique:
                    seen.add(record.trial)
                yield Line(record, start, len(raw))
                start += len(raw)
    except OSError as error:
        raise ResultsError(f"{path} cannot be read ({error.strerror}).") from error


class _WrongPlaceError(ValueError):
    """A line that is sound in itself, but not where it is."""


def _may_be_torn(raw: bytes, error: ValueError) -> bool:
    """Return whether a kill or power cut can leave such a last line: its end missing, or no JSON at all."""
    return len(raw) <= LONGEST_LINE and (
        not raw.endswith(b"\n") or isinstance(error, (json.JSONDecodeError, UnicodeDecodeError))
    )


def read_lines(path: Path, kind: type[Kind] = TrialRecord, *, unique: bool = True) -> list[Kind]:
    """Return all records of a file; see :func:`scan`."""
    return [line.record for line in scan(path, kind, unique=unique)]
