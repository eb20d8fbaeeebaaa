"""The folder of what can be made again, such as compiled models, kept below a size.

What was used longest ago goes first.

Several processes may use it at a time. A file is there whole or not at all, and one that vanishes while it is
looked for is as good as one that never was there.
"""

from __future__ import annotations

import os
import shutil
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from grasp_bench.errors import GraspBenchError

LIMIT = "GRASP_BENCH_CACHE_MB"
"""Environment variable: megabytes that the folder may take; 0 keeps nothing."""
AT_REST = (".rest", ".seen")
"""Endings of the files of objects at rest, and of what a camera sees of them; all others are models."""
SHARE = 0.01
"""Share of the limit that a process writes between two looks at whether the folder is too large."""
LEFT_BEHIND = 3600.0
"""Seconds after which what a killed process was writing is removed."""
_written = [0]
"""Bytes that this process wrote since it looked."""


@dataclass(frozen=True)
class Entry:
    """A file of the cache: where, its size [bytes], and the seconds since it was used."""

    path: Path
    size: int
    age: float


def folder() -> Path:
    """The folder: below ``$GRASP_BENCH_CACHE`` or the user's cache folder."""
    base = os.environ.get("GRASP_BENCH_CACHE") or os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "grasp-bench" / "models"


def limit() -> int:
    """Bytes that the folder may take.

    Raises:
        GraspBenchError: where :data:`LIMIT` is no number.
    """
    told = os.environ.get(LIMIT, "2000")
    if not told.isdecimal():
        raise GraspBenchError(f"{LIMIT} must be a whole number of megabytes, not {told!r}.")
    return int(told) * 10**6


def first_use() -> str | None:
    """Return what to tell of the first models that are kept; None where some are there, or none are kept.

    Raises:
        GraspBenchError: where :data:`LIMIT` is no number.
    """
    most = limit()
    if not most or entries():
        return None
    return (
        f"Compiled models go to {folder()}: some 6 MB for each object and scenario, 1 to 2 GB with time, at "
        f"most {most / 1e9:g} GB. {LIMIT}=500 in the environment allows 500; `grasp-bench cache` shows them."
    )


def entries() -> list[Entry]:
    """Files of the cache, those used last first."""
    found, now = [], time.time()
    try:
        with os.scandir(folder()) as names:
            for name in names:
                try:
                    if name.is_file(follow_symlinks=False):
                        stat = name.stat(follow_symlinks=False)
                        found.append(Entry(Path(name.path), stat.st_size, max(0.0, now - stat.st_mtime)))
                except OSError:
                    continue  # another process removed it
    except OSError:
        return []
    return sorted(found, key=lambda e: (e.age, e.path.name))


def used(path: Path) -> bool:
    """Whether a file is there; from now on it is the one that was used last."""
    try:
        os.utime(path)
    except FileNotFoundError:
        return False
    except OSError:  # a read-only folder: it is there, and nothing is removed from it
        return path.is_file()
    return True


def put(path: Path, write: Callable[[Path], object]) -> None:
    """Put a file into the folder, whole or not at all; a full or read-only disk costs time, not the trial.

    Args:
        path: the file.
        write: writes it, under another name.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=path.parent) as unfinished:
            fresh = Path(unfinished) / path.name
            write(fresh)
            _written[0] += fresh.stat().st_size
            fresh.replace(path)
        if _written[0] >= SHARE * limit():
            _written[0] = 0
            trim()
    except OSError:
        pass


def trim() -> None:
    """Remove what was used longest ago until the rest is within the limit, and what killed processes left."""
    total, most = 0, limit()
    for entry in entries():
        total += entry.size
        if total > most:
            _remove(entry.path)
    for left in _unfinished():
        try:
            if time.time() - left.stat().st_mtime > LEFT_BEHIND:
                shutil.rmtree(left, ignore_errors=True)
        except OSError:
            continue


def clear() -> list[Entry]:
    """Remove all files; those that were removed."""
    removed = [e for e in entries() if _remove(e.path)]
    for left in _unfinished():
        shutil.rmtree(left, ignore_errors=True)
    return removed


def _remove(path: Path) -> bool:
    try:
        path.unlink()
    except OSError:
        return False
    return True


def _unfinished() -> list[Path]:
    """Folders in which models are written before they are put into place."""
    try:
        return [p for p in folder().iterdir() if p.is_dir()]
    except OSError:
        return []
