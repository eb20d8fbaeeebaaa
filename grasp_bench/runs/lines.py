"""Lines of ``trials.jsonl`` and ``timings.jsonl``: written always alike, read one by one and checked.

Files may be larger than memory: nothing here holds more than a line, except the trials' numbers.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple, TypeGuard

from grasp_bench.errors import ResultsError
from grasp_bench.scenario.outcomes import Outcome

LONGEST_LINE = 1 << 20
"""No line of a results file is longer than this [bytes]; what is longer was not written by grasp-bench."""
OUTCOMES = frozenset(map(str, Outcome))


class Line(NamedTuple):
    """A sound line of a results file: its content, and where it lies in the file [bytes]."""

    record: dict[str, Any]
    start: int
    length: int


def dump(record: dict[str, Any]) -> str:
    """One line of JSON, always the same for the same record."""
    return json.dumps(record, ensure_ascii=False, separators=(", ", ": "), allow_nan=False)


def check_trial(record: dict[str, Any]) -> None:
    """Raises ValueError, saying why, for what is not the record of a trial."""
    check_number_of_trial(record)
    for key, (kind, words) in _TRIAL_FIELDS.items():
        if key not in record:
            if key in _REQUIRED:
                raise ValueError(f"{key!r} is missing")
        elif not kind(record[key]):
            raise ValueError(f"{key!r} must be {words}, not {_shown(record[key])}")
    if record["success"] is not (record["outcome"] == "success"):
        raise ValueError(
            f"'success' is {_shown(record['success'])} where the outcome is {record['outcome']!r}"
        )


def check_timing(record: dict[str, Any]) -> None:
    """Raises ValueError, saying why, for what is not the timings of a trial."""
    check_number_of_trial(record)
    for key, value in record.items():
        if not _is_number(value):
            raise ValueError(f"{key!r} must be a number, not {_shown(value)}")


def check_number_of_trial(record: dict[str, Any]) -> None:
    """Raises ValueError unless ``trial`` is a whole number from 0."""
    if "trial" not in record:
        raise ValueError("'trial' is missing")
    if not _is_count(record["trial"]):
        raise ValueError(f"'trial' must be a whole number from 0, not {_shown(record['trial'])}")


def _is_count(value: Any) -> TypeGuard[int]:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


def _is_part(value: Any) -> bool:
    return value is None or isinstance(value, dict)


def _is_episode(value: Any) -> bool:
    if not isinstance(value, dict):
        return False
    objects, attempts, cleared = value.get("objects"), value.get("attempts"), value.get("cleared", -1)
    return (
        isinstance(objects, list)
        and len(objects) > 0
        and all(map(_is_text, objects))
        and _is_count(cleared)
        and cleared <= len(objects)
        and isinstance(attempts, list)
        and all(
            isinstance(a, dict)
            and isinstance(a.get("outcome"), str)
            and a["outcome"] in OUTCOMES
            and a.get("success") is (a["outcome"] == "success")
            for a in attempts
        )
    )


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 40 else text[:37] + "…"


_REQUIRED = frozenset({"object", "category", "outcome", "success"})
_TRIAL_FIELDS: dict[str, tuple[Callable[[Any], bool], str]] = {
    "object": (_is_text, "text"),
    "category": (_is_text, "text"),
    "seed": (_is_count, "a whole number from 0"),
    "outcome": (lambda v: isinstance(v, str) and v in OUTCOMES, f"one of {', '.join(map(str, Outcome))}"),
    "success": (lambda v: isinstance(v, bool), "true or false"),
    "detail": (_is_text, "text"),
    "grasp": (_is_part, "an object or null"),
    "pose": (_is_part, "an object or null"),
    "rank": (lambda v: v is None or _is_count(v), "a whole number from 0 or null"),
    "tcp_error": (_is_part, "an object or null"),
    "lift_height": (_is_number, "a number"),
    "contact_force": (_is_number, "a number"),
    "sim_steps": (_is_count, "a whole number from 0"),
    "clutter": (_is_episode, "an episode's objects, attempts and how many objects were cleared"),
}


def parse(line: bytes, check: Callable[[dict[str, Any]], None]) -> dict[str, Any]:
    """The record in a line.

    Raises:
        ValueError: for what is not one whole line with a sound record.
    """
    if not line.endswith(b"\n"):
        raise ValueError("no newline at its end" if len(line) <= LONGEST_LINE else "longer than 1 MiB")
    try:
        record = json.loads(line.decode(), parse_constant=_no_constant)
    except RecursionError as error:
        raise ValueError("nested too deeply") from error
    if not isinstance(record, dict):
        raise ValueError(f"{_shown(record)} is not a record")
    check(record)
    return record


def _no_constant(name: str) -> float:
    raise ValueError(f"{name} is no number")


def scan(
    path: Path, check: Callable[[dict[str, Any]], None] = check_trial, *, unique: bool = True
) -> Iterator[Line]:
    """The lines of a file, in its order; none where there is no file.

    A torn last line (without a newline, or not JSON), as a kill or a power cut leaves it, is
    left out: compare the last line's end with the file's size.

    Args:
        path: of the file.
        check: raises ValueError for a record that is not what it should be.
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
                    record = parse(raw, check)
                    if unique and record["trial"] in seen:
                        raise _WrongPlaceError(f"trial {record['trial']} is in it a second time")
                except ValueError as error:
                    if _may_be_torn(raw, error) and not file.read(1):
                        return
                    raise ResultsError(
                        f"{path}, line {number} is damaged ({error}). Restore the file, or delete that line "
                        "and run the same command again to repeat the trial."
                    ) from error
                if unique:
                    seen.add(record["trial"])
                yield Line(record, start, len(raw))
                start += len(raw)
    except OSError as error:
        raise ResultsError(f"{path} cannot be read ({error.strerror}).") from error


class _WrongPlaceError(ValueError):
    """A line that is sound in itself, but not where it is."""


def _may_be_torn(raw: bytes, error: ValueError) -> bool:
    """Whether a kill or power cut can leave such a last line: its end missing, or no JSON at all."""
    return len(raw) <= LONGEST_LINE and (
        not raw.endswith(b"\n") or isinstance(error, (json.JSONDecodeError, UnicodeDecodeError))
    )


def read_lines(
    path: Path, check: Callable[[dict[str, Any]], None] = check_trial, *, unique: bool = True
) -> tuple[list[dict[str, Any]], int]:
    """All records of a file, and the length in bytes of its sound part; see :func:`scan`."""
    records: list[dict[str, Any]] = []
    sound = 0
    for line in scan(path, check, unique=unique):
        records.append(line.record)
        sound = line.start + line.length
    return records, sound
