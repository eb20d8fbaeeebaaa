"""Does a recorded trial again, and holds the result against its record."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from grasp_bench.errors import ResultsError
from grasp_bench.identity import ORIGIN, differences
from grasp_bench.jobs import Job, Settings, spread
from grasp_bench.media.recording import Recording
from grasp_bench.objects.catalog import Catalog
from grasp_bench.outcomes import HARNESS_FAULTS
from grasp_bench.predictors import load_predictor
from grasp_bench.predictors.identity import identify
from grasp_bench.records import dump, scan
from grasp_bench.results import TRIALS, load_run
from grasp_bench.runner import describe
from grasp_bench.scenario import Scenario, parse_scenario
from grasp_bench.trial import Trial, Workcell, run_trial

CAUSES = ("implementation", "objects", "weights", "versions", *ORIGIN)
"""Keys of ``run.json`` that a replay cannot take from the record, but only from this installation."""


@dataclass(frozen=True)
class Replay:
    """A trial that was done again.

    Attributes:
        run: content of its ``run.json``.
        stored: its record as the run wrote it.
        done: the trial as it went now.
        recording: its motion, with what the object touched.
        scenario: of the run.
        predictor: that was asked.
        differs: what is not as recorded, in words; empty when all is the same to the bit.
        causes: how this installation differs from the one that wrote the record.
    """

    run: dict[str, Any]
    stored: dict[str, Any]
    done: Trial
    recording: Recording
    scenario: Scenario
    predictor: Any
    differs: list[str]
    causes: list[str]

    @property
    def identical(self) -> bool:
        """The new record is the stored one, byte for byte."""
        return dump(self.done.record.to_json()) == dump(self.stored)


def rebuild(folder: Path, trial: int, objects: Path | None = None, every: int = 5) -> Replay:
    """Do a trial of the run in ``folder`` again.

    Args:
        folder: of the run.
        trial: its number.
        objects: folder of the objects' catalogue; the shipped ones by default.
        every: samples of the motion (4 ms in the shipped scenarios) from one kept state to the next.

    Raises:
        ResultsError: for a folder without a run, a trial it does not hold, or a record that is not
            of the trial which ``run.json`` plans under that number.
        GraspBenchError: for an object or a predictor that is not to be had here.
    """
    import cv2

    cv2.setNumThreads(1)  # as in a run's workers
    run = load_run(folder)
    stored = stored_record(folder, trial)
    settings, catalog = settings_of(run, folder, objects)
    job = job_of(run, stored, folder)
    model = catalog.load(job.object)
    predictor = load_predictor(settings.predictor)
    recording = Recording(every, touches=True)
    done = run_trial(Workcell(settings.scenario, settings.renderer), model, predictor, trial=trial,
                     attempt=job.attempt, seed=settings.seed, observer=recording)
    new = done.record.to_json()
    differs = [f"{key}: {_short(stored.get(key))} in the record, {_short(new.get(key))} now"
               for key in dict.fromkeys([*stored, *new])
               if dump({"": stored.get(key)}) != dump({"": new.get(key)})]
    causes = []
    if differs:
        here = describe(settings, spread([job.object], 1), catalog, identify(settings.predictor, predictor))
        there = run | {"objects": {job.object: run["objects"][job.object]}}
        keys = [k for k in CAUSES if k in run]
        causes = list(differences(there, here, keys, ("in the record", "here")).values())
        if stored["outcome"] in HARNESS_FAULTS:
            causes.append("time limits and crashed workers are not part of a replay")
    return Replay(run, stored, done, recording, settings.scenario, predictor, differs, causes)


def stored_record(folder: Path, trial: int) -> dict[str, Any]:
    """The record of a trial.

    Raises:
        ResultsError: when the run does not hold it.
    """
    numbers = []
    for line in scan(folder / TRIALS, unique=False):
        record = line.record
        if record["trial"] == trial:
            return record
        numbers.append(record["trial"])
    held = f"it holds {len(numbers)}, {min(numbers)} to {max(numbers)}" if numbers else "it holds none yet"
    raise ResultsError(f"{folder} has no trial {trial}; {held}.")


def settings_of(run: dict[str, Any], folder: Path, objects: Path | None) -> tuple[Settings, Catalog]:
    """How the run's trials are done, and its objects.

    Raises:
        ResultsError: for a run of cluttered tables.
    """
    catalog = Catalog(objects)
    scenario = parse_scenario(run["scenario"], str(folder / "run.json"))
    if scenario.clutter is not None:
        raise ResultsError(f"{folder} is of cluttered tables; replays are of trials on single objects only.")
    settings = Settings(scenario, catalog.folder.resolve(), run["predictor"], run["seed"], run["renderer"])
    return settings, catalog


def job_of(run: dict[str, Any], stored: dict[str, Any], folder: Path) -> Job:
    """The job that a record is of.

    Raises:
        ResultsError: when the record is of another object than the run plans for its number.
    """
    names = list(run["objects"])
    if not names:
        raise ResultsError(f"{folder / 'run.json'} names no objects; restore it.")
    job = spread(names, run["trials"]).job(stored["trial"])
    if job.object != stored["object"]:
        raise ResultsError(f"Trial {job.trial} of {folder} is of {stored['object']} in its record and of "
                           f"{job.object} in run.json; the files were mixed up.")
    return job


def _short(value: Any) -> str:
    text = dump({"": value})[5:-1]
    return text if len(text) <= 90 else f"{text[:89]}…"
