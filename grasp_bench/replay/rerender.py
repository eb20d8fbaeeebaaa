"""Pictures and clips of a finished run that stored none, made by doing its trials again."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

from grasp_bench.errors import UnknownNameError
from grasp_bench.execution.executors import make_executor
from grasp_bench.execution.runner import carry_out
from grasp_bench.media.store import Media, faults, find, remove, wanted
from grasp_bench.replay.rebuild import job_of, settings_of
from grasp_bench.replay.verdict import Verdict, verdict
from grasp_bench.runs.folder import TRIALS, load_run
from grasp_bench.runs.jobs import Job
from grasp_bench.runs.lines import scan
from grasp_bench.runs.record import TrialRecord
from grasp_bench.scenario.outcomes import HARNESS_FAULTS


@dataclass(frozen=True)
class Rerendered:
    """What :func:`rerender` did.

    Attributes:
        made: number of trials that have pictures now.
        differing: numbers of trials that did not end as recorded; they got none.
        failed: why pictures of a trial could not be made, by its number.
    """

    made: int
    differing: tuple[int, ...]
    failed: dict[int, str]


def missing(folder: Path, mode: str) -> dict[int, TrialRecord]:
    """Return records, by number, of the trials that lack pictures or clips which ``mode`` wants.

    Tries that end in a fault of the harness have no pictures. An episode lacks some where one of its
    attempts does.
    """
    lacking = {}
    for line in scan(folder / TRIALS, unique=False):
        record = line.record
        if any(
            wanted(mode, t.success)
            and t.outcome not in HARNESS_FAULTS
            and _lacks(find(folder, record.trial, number), moved=t.pose is not None)
            for number, t in record.tries
        ):
            lacking[record.trial] = record
    return lacking


def _lacks(media: Media, moved: bool) -> bool:
    return media.sheet is None or (moved and media.clip is None)


def rerender(
    folder: Path,
    mode: str,
    objects: Path | None = None,
    workers: int = 0,
    progress: Callable[[TrialRecord], None] = lambda record: None,
    trust: bool = False,
) -> Rerendered:
    """Do trials of a run again to have their pictures and clips; its records are not touched.

    Args:
        folder: the run's folder.
        mode: ``failures`` or ``all``.
        objects: folder of the objects' catalogue; the shipped ones by default.
        workers: number of processes; 0 takes one for each core.
        progress: called with the new record of each trial.
        trust: start a predictor that is not shipped, too, though only the record names it.

    Raises:
        GraspBenchError: for a run that cannot be done again here.
    """
    run, lacking = load_run(folder), missing(folder, mode)
    if not lacking:
        return Rerendered(0, (), {})
    settings, catalog = settings_of(run, folder, objects, trust)
    settings = replace(settings, media=mode, folder=folder)
    jobs: list[Job] = [job_of(run, record, folder) for record in lacking.values()]
    for job in jobs:
        if job.object not in catalog.entries:
            raise UnknownNameError("object", job.object, catalog.names)
    differing = []
    executor = make_executor("process", min(workers, len(jobs)))
    with closing(carry_out(settings, jobs, catalog, executor)) as ended:
        for record, _ in ended:
            if verdict(lacking[record.trial], record) is Verdict.DIFFERENT:
                differing.append(record.trial)
                remove(folder, record.trial)
            progress(record)
    failed = {n: why for n, why in faults(folder).items() if n in lacking}
    return Rerendered(len(jobs) - len(differing) - len(failed), tuple(sorted(differing)), failed)
