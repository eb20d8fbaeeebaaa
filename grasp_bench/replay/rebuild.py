"""A recorded trial, or a whole episode of clutter, done again and compared with its record."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grasp_bench.errors import GraspBenchError, ResultsError
from grasp_bench.execution.describe import describe
from grasp_bench.media.recording import Recording
from grasp_bench.media.takes import Take
from grasp_bench.objects.catalog import Catalog, folder_of
from grasp_bench.predictors.identity import identify
from grasp_bench.predictors.trust import require
from grasp_bench.predictors.use import in_use
from grasp_bench.replay.verdict import Verdict, verdict
from grasp_bench.runs.folder import TRIALS, load_run
from grasp_bench.runs.info import RUN, Group, RunInfo
from grasp_bench.runs.jobs import Job, Settings, spread
from grasp_bench.runs.lines import scan
from grasp_bench.runs.record import TrialRecord
from grasp_bench.scenario.outcomes import HARNESS_FAULTS
from grasp_bench.scenario.sections import Scenario
from grasp_bench.trials.attempt import Trial
from grasp_bench.trials.job import do_job
from grasp_bench.trials.workcell import Workcell


@dataclass(frozen=True)
class Replay:
    """A trial that was done again.

    Attributes:
        run: content of its ``run.json``.
        stored, record: the record that the run wrote, and that of the trial done now.
        takes: what there is to show: the trial, or the attempts of its episode.
        scenario: scenario of the run.
        differs: what is not as recorded, in words; empty when all is the same to the bit.
        causes: how this installation differs from the one that wrote the record.
    """

    run: RunInfo
    stored: TrialRecord
    record: TrialRecord
    takes: tuple[Take, ...]
    scenario: Scenario
    differs: list[str]
    causes: list[str]

    @property
    def identical(self) -> bool:
        """Whether the new record is the stored one, byte for byte."""
        return self.verdict is Verdict.SAME

    @property
    def verdict(self) -> Verdict:
        """How the new record compares with the stored one."""
        return verdict(self.stored, self.record)

    def seen(self) -> list[Take]:
        """Return the takes that have an image; GraspBenchError where none has."""
        if found := [take for take in self.takes if take.seen]:
            return found
        raise GraspBenchError(
            f"Trial {self.record.trial} ended before there was an image "
            f"({self.record.outcome}); there is nothing to show."
        )


class _Camera(Recording):
    """A recording of one try, kept as a take of the replay."""

    def __init__(self, takes: list[Take], every: int, attempt: int | None) -> None:
        super().__init__(every, touches=True)
        self._takes, self._attempt = takes, attempt

    def keep(self, done: Trial, predictor: Any) -> None:
        self._takes.append(Take.of(done, self, predictor, self._attempt))


def rebuild(
    folder: Path,
    trial: int,
    objects: Path | None = None,
    every: int = 5,
    attempt: int | None = None,
    trust: bool = False,
) -> Replay:
    """Do a trial of the run in ``folder`` again.

    Args:
        folder: the run's folder.
        trial: number of the trial.
        objects: folder of the objects' catalogue; the shipped ones by default.
        every: samples of the motion (4 ms in the shipped scenarios) from one kept state to the next.
        attempt: the only attempt of an episode to show; all are done again nevertheless.
        trust: start a predictor that is not shipped, too, though only the record names it.

    Raises:
        UntrustedError: for a predictor that is not shipped, unless it is trusted.
        ResultsError: for a folder without a run, a trial or an attempt it does not hold, or a record that is
            not of the trial which ``run.json`` plans under that number.
        GraspBenchError: for an object or a predictor that is not available here.
    """
    import cv2

    cv2.setNumThreads(1)  # as in a run's workers
    run = load_run(folder)
    stored = stored_record(folder, trial)
    if attempt is not None:
        check_attempt(stored, attempt)
    settings, catalog = settings_of(run, folder, objects, trust)
    job = job_of(run, stored, folder)
    takes: list[Take] = []

    def watch(number: int | None) -> _Camera | None:
        return _Camera(takes, every, number) if attempt in (None, number) else None

    cell = Workcell(settings.scenario, settings.renderer)
    with in_use(settings.predictor) as predictor:
        new = do_job(cell, catalog, predictor, job, settings.seed, watch).record
    differs = list(_differences(stored.to_json(), new.to_json()))
    causes = []
    if differs:
        here = describe(settings, spread([job.object], 1), catalog, identify(settings.predictor))
        there = run.model_copy(update={"objects": {name: run.objects.get(name) for name in here.objects}})
        groups = (Group.INSTALLED, Group.ORIGIN)
        causes = [
            words
            for key, words in there.differences(here, *groups, places=("in the record", "here")).items()
            if key in run.model_fields_set  # older runs do not say all
        ]
        if stored.outcome in HARNESS_FAULTS:
            causes.append("time limits and crashed workers are not part of a replay")
    return Replay(run, stored, new, tuple(takes), settings.scenario, differs, causes)


def _differences(stored: dict[str, Any], new: dict[str, Any], where: str = "") -> Iterator[str]:
    """Yield what two records differ in, in words; attempts of an episode one by one."""
    for key in dict.fromkeys([*stored, *new]):
        was, now = stored.get(key), new.get(key)
        if was == now:
            continue
        if key == "clutter" and was and now:
            yield from _differences(
                {k: v for k, v in was.items() if k != "attempts"},
                {k: v for k, v in now.items() if k != "attempts"},
            )
            for number, (one, other) in enumerate(zip(was["attempts"], now["attempts"], strict=False)):
                yield from _differences(one, other, f"attempt {number}, ")
            if len(was["attempts"]) != len(now["attempts"]):
                yield f"attempts: {len(was['attempts'])} in the record, {len(now['attempts'])} now"
        else:
            yield f"{where}{key}: {_short(was)} in the record, {_short(now)} now"


def stored_record(folder: Path, trial: int) -> TrialRecord:
    """Read the record of a trial; ResultsError when the run does not hold it."""
    numbers = []
    for line in scan(folder / TRIALS, unique=False):
        record = line.record
        if record.trial == trial:
            return record
        numbers.append(record.trial)
    held = f"it holds {len(numbers)}, {min(numbers)} to {max(numbers)}" if numbers else "it holds none yet"
    raise ResultsError(f"{folder} has no trial {trial}; {held}.")


def check_attempt(stored: TrialRecord, attempt: int) -> None:
    """Raise ResultsError for an attempt that a trial's record does not hold, saying which it holds."""
    if stored.clutter is None:
        raise ResultsError(f"Trial {stored.trial} is not an episode of clutter; leave --attempt out.")
    count = len(stored.clutter.attempts)
    if attempt >= count:
        there = f"it has {count}, 0 to {count - 1}" if count else "it came to none"
        raise ResultsError(f"Trial {stored.trial} has no attempt {attempt}; {there}.")


def settings_of(run: RunInfo, folder: Path, objects: Path | None, trust: bool) -> tuple[Settings, Catalog]:
    """Return the settings of the run's trials, and its objects.

    Raises:
        UntrustedError: for a predictor that is not shipped, unless ``trust``.
        GraspBenchError: for objects, a predictor or a scenario that are not available here.
    """
    require(run.predictor, folder, trust)
    scenario = run.parsed(str(folder / RUN))
    catalog = Catalog(objects or folder_of(scenario.objects.folder))
    settings = Settings(scenario, catalog.folder.resolve(), run.predictor, run.seed, run.renderer)
    return settings, catalog


def job_of(run: RunInfo, stored: TrialRecord, folder: Path) -> Job:
    """Return the job of a record; ResultsError when the run plans another object for its number."""
    names = run.tried
    if not names:
        raise ResultsError(f"{folder / 'run.json'} names no objects; restore it.")
    job = spread(names, run.trials).job(stored.trial)
    if job.object != stored.object:
        raise ResultsError(
            f"Trial {job.trial} of {folder} is of {stored.object} in its record and of "
            f"{job.object} in run.json; the files were mixed up."
        )
    return job


def _short(value: Any) -> str:
    text = json.dumps(value, ensure_ascii=False)
    return text if len(text) <= 90 else f"{text[:89]}…"
