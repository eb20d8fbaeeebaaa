"""Several shards' folders made into the folder that one machine would have written."""

from __future__ import annotations

import hashlib
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from grasp_bench.errors import GraspBenchError, ResultsError
from grasp_bench.runs.differences import listed
from grasp_bench.runs.folder import TIMINGS, TRIALS, RunFolder, join, load_run, write_run
from grasp_bench.runs.info import RUN, SAME_RUN, Group, RunInfo
from grasp_bench.runs.jobs import WHOLE, Jobs, Shard, spread
from grasp_bench.runs.limits import MOST_TRIALS
from grasp_bench.runs.lines import scan


@dataclass(frozen=True)
class Merged:
    """What :func:`merge` found.

    Attributes:
        folder: results of the whole run.
        trials, planned: number of trials in it, and that it should have.
        repeated: trials that were in more than one shard, each time the same.
        notes: what is worth knowing, in words.
    """

    folder: Path
    trials: int
    planned: int
    repeated: int
    notes: tuple[str, ...]


def merge(out: Path, shards: list[Path], partial: bool = False) -> Merged:
    """Write the trials of ``shards`` to ``out``, in trial order.

    Args:
        out: new folder.
        shards: folders of runs of the same settings, each of a part of the trials.
        partial: accept that trials are missing; ``grasp-bench run --out`` does them later.

    Raises:
        ResultsError: when the shards are not of one run, when two hold different records of a
            trial, when trials are missing, or when a folder cannot be read or written; it names
            which.
    """
    runs = [load_run(folder) for folder in shards]
    for folder, run in zip(shards[1:], runs[1:], strict=True):
        if found := runs[0].differences(run, *SAME_RUN, places=(f"in {shards[0]}", f"in {folder}")):
            raise ResultsError(f"{shards[0]} and {folder} are not of one run: {listed(found)}.")
    if (out / RUN).exists():
        raise ResultsError(f"{out} holds a run already; choose another folder to merge into.")
    if not runs[0].objects or not 0 < runs[0].trials <= MOST_TRIALS:
        raise ResultsError(
            f"{shards[0] / RUN} is damaged (it plans {runs[0].trials} trials on "
            f"{len(runs[0].objects)} objects)."
        )
    jobs = spread(runs[0].tried, runs[0].trials)
    owner, repeated = _collect(shards, runs, jobs)
    missing = np.flatnonzero(owner < 0)
    if len(missing) and not partial:
        raise ResultsError(_holes(missing, shards, runs, jobs))
    with RunFolder(out):
        for name in (TRIALS, TIMINGS):
            join([folder / name for folder in shards], out / name)
        whole = {"shard": None, "command": ("grasp-bench", *sys.argv[1:])}
        write_run(out / RUN, runs[0].model_copy(update=whole))
    return Merged(out, jobs.total - len(missing), jobs.total, repeated, tuple(_notes(shards, runs)))


def _collect(shards: list[Path], runs: list[RunInfo], jobs: Jobs) -> tuple[np.ndarray, int]:
    """Return which shard holds each trial (−1 none), and how many trials are in several."""
    owner = np.full(jobs.total, -1, dtype=np.int32)
    digests = np.zeros(jobs.total, dtype=np.uint64)
    repeated: set[int] = set()
    apart: list[str] = []
    for number, (folder, run) in enumerate(zip(shards, runs, strict=True)):
        part = _jobs_of(run, folder, jobs)
        for record, _, _ in scan(folder / TRIALS):
            trial = record.trial
            if not part.holds(trial) or jobs.job(trial).object != record.object:
                raise ResultsError(
                    f"{folder} holds trial {trial} on {record.object}, which is none of "
                    "its own; its files were mixed up."
                )
            if record.seed not in (None, run.seed):
                raise ResultsError(
                    f"{folder} holds trial {trial} of seed {record.seed}, but its {RUN} "
                    f"says {run.seed}; its files were mixed up."
                )
            digest = int.from_bytes(hashlib.blake2b(record.line().encode(), digest_size=8).digest(), "little")
            if owner[trial] < 0:
                owner[trial], digests[trial] = number, digest
            elif digests[trial] == digest:
                repeated.add(trial)
            else:
                apart.append(f"trial {trial} ({record.object}) in {shards[owner[trial]]} and {folder}")
    if apart:
        more = f" and {len(apart) - 5} more" if len(apart) > 5 else ""
        raise ResultsError(
            f"The shards disagree on {'; '.join(apart[:5])}{more}. The same trial must give "
            "the same record; `grasp-bench doctor FOLDER` tells which machine does not "
            "repeat."
        )
    return owner, len(repeated)


def _jobs_of(run: RunInfo, folder: Path, jobs: Jobs) -> Jobs:
    try:
        shard = WHOLE if run.shard is None else Shard.parse(run.shard)
    except GraspBenchError as error:
        raise ResultsError(f"{folder / RUN} is damaged (its shard is {run.shard!r}).") from error
    return Jobs(jobs.objects, jobs.total, shard)


def _holes(missing: np.ndarray, shards: list[Path], runs: list[RunInfo], jobs: Jobs) -> str:
    """Say which trials are missing, and what to do about it."""
    shown = ", ".join(map(str, missing[:8])) + (" …" if len(missing) > 8 else "")
    text = f"{len(missing)} of {jobs.total} trials are missing: {shown}."
    gone = set(missing.tolist())
    counts: dict[int, set[int]] = {}
    for folder, run in zip(shards, runs, strict=True):
        part = _jobs_of(run, folder, jobs)
        if part.shard != WHOLE:
            counts.setdefault(part.shard.count, set()).add(part.shard.index)
        if left := sum(1 for j in part if j.trial in gone):
            text += f" {folder} (shard {part.shard}) still has {left} to do: run its command again."
    for count, there in sorted(counts.items()):
        if absent := sorted(set(range(1, count + 1)) - there):
            text += f" Not among the folders: shard {', '.join(f'{i}/{count}' for i in absent[:8])}."
    return text + " With --partial, what is there is merged and `grasp-bench run --out` does the rest."


def _notes(shards: list[Path], runs: list[RunInfo]) -> list[str]:
    notes = []
    for folder, run in zip(shards[1:], runs[1:], strict=True):
        if found := runs[0].differences(run, Group.ORIGIN, places=(f"in {shards[0]}", f"in {folder}")):
            notes.append(
                f"Made in different places: {listed(found)}. A network's last digits may depend on "
                "the processor; `grasp-bench doctor` shows whether they do."
            )
    return notes
