"""The cost of a run's pictures and clips in time and on disk."""

from __future__ import annotations

from pathlib import Path

from grasp_bench.media.store import FOLDER, faults
from grasp_bench.runs.folder import load_timings


def describe_cost(run: Path) -> str:
    """Say in a sentence or two: seconds a trial and their share, files and megabytes, and what failed."""
    timings = [t for t in load_timings(run) if "media" in t.seconds]
    spent = sum(t.seconds["media"] for t in timings)
    total = sum(t.total for t in timings)
    files = sorted((run / FOLDER).glob("*.webp"))
    clips = sum(f.stem.endswith("-clip") for f in files)
    size = sum(f.stat().st_size for f in files) / 1e6
    tries = "attempts" if any("-" in f.stem.removesuffix("-clip") for f in files) else "trials"
    text = (
        f"Media: pictures of {len(files) - clips} {tries} and {clips} clips, {size:.1f} MB in {run / FOLDER}"
    )
    if timings:
        text += (
            f"; {spent / len(timings):.2f} s a trial, {spent / total:.0%} of its time "
            f"(mean of {len(timings)} trials)."
        )
    failed = faults(run)
    if failed:
        number, why = next(iter(failed.items()))
        text += f" Those of {len(failed)} trials could not be made; trial {number}: {why}"
    return text
