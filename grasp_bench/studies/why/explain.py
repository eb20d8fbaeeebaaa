"""The failures of a run explained: each trial done again without causes of its failure."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

from grasp_bench.errors import GraspBenchError, UnknownNameError
from grasp_bench.execution.protocol import Executor, Fault
from grasp_bench.predictors.protocol import Predictor
from grasp_bench.replay.rebuild import job_of, settings_of
from grasp_bench.replay.verdict import Verdict
from grasp_bench.runs.folder import TRIALS, load_run
from grasp_bench.runs.info import RunInfo
from grasp_bench.runs.lines import scan
from grasp_bench.runs.record import TrialRecord
from grasp_bench.scenario.outcomes import HARNESS_FAULTS
from grasp_bench.scenario.reading import check_current
from grasp_bench.studies.why.attribution import Explanation, first_cause, shares
from grasp_bench.studies.why.causes import Cause, applying
from grasp_bench.studies.why.examine import (
    MOST_REPLAYS,
    Examined,
    ExaminerHere,
    Examiners,
    Question,
    recalled,
)
from grasp_bench.studies.why.journal import WHY, Journal
from grasp_bench.system.machine import usable_cores


@dataclass(frozen=True)
class Study:
    """What the failures of a run are put down to.

    Attributes:
        folder, run: the run.
        done: number of its trials that are done.
        failed: number of those that failed.
        causes: those that there can be in its scenario.
        explained: the failures that could be done again.
        left_out: why others were not, by trial.
        rounded: trials that came out the same only within rounding.
        broken: replays that could not be done and count as not saved, by trial.
        damaged: lines of ``why.jsonl`` that could not be read.
    """

    folder: Path
    run: RunInfo
    done: int
    failed: int
    causes: tuple[Cause, ...]
    explained: tuple[Explanation, ...]
    left_out: dict[int, str]
    rounded: tuple[int, ...]
    broken: dict[int, int]
    damaged: int

    @property
    def shares(self) -> dict[str, float]:
        """How many of the explained failures fall to each cause, the greatest first."""
        return shares(self.explained)

    def first(self, explanation: Explanation) -> str:
        """Return the cause that is named first for a failure."""
        return first_cause(explanation, self.shares)

    @property
    def planned(self) -> int:
        """Trials that the run's folder is to hold."""
        count = int(self.run.shard.rpartition("/")[2]) if self.run.shard else 1
        first = int(self.run.shard.partition("/")[0]) if self.run.shard else 1
        return len(range(first - 1, self.run.trials, count))


def explain(
    folder: Path,
    *,
    out: Path | None = None,
    objects: Path | None = None,
    workers: int = 0,
    trust: bool = False,
    predictor: Predictor | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Study:
    """Explain the failures of a run; the same call again goes on where it stopped.

    Args:
        folder: the run's folder; its records are not touched.
        out: file of the replays; ``why.jsonl`` in the folder by default.
        objects: folder of the objects' catalogue; the shipped ones by default.
        workers: number of processes; 0 takes one for each core.
        trust: start a predictor that is not shipped, too, though only the record names it.
        predictor: used in this process instead of the one that the run names, which it must be.
        progress: called with the number of failures examined, and of all.

    Raises:
        UntrustedError: for a predictor that is not shipped, unless it is trusted or given.
        ScenarioError: for a run of another version of the definition.
        GraspBenchError: for a run of clutter, or one that cannot be done again here.
    """
    run = load_run(folder)
    if run.cluttered:
        raise GraspBenchError(
            f"{folder} holds episodes of clutter, in which an attempt changes what the next one finds; "
            "`grasp-bench why` explains runs of single objects."
        )
    settings, catalog = settings_of(run, folder, objects, trust or predictor is not None)
    check_current(settings.scenario)
    done, failures, left_out = 0, list[TrialRecord](), dict[int, str]()
    for line in scan(folder / TRIALS):
        done += 1
        if line.record.outcome in HARNESS_FAULTS:
            left_out[line.record.trial] = f"it ended in {line.record.outcome}, a fault of the harness"
        elif not line.record.success:
            failures.append(line.record)
    failures.sort(key=lambda r: r.trial)
    for record in failures:
        if record.object not in catalog.entries:
            raise UnknownNameError("object", record.object, catalog.names)
    failed = len(failures) + len(left_out)
    explained, rounded, broken = list[Explanation](), list[int](), dict[int, int]()
    limit = settings.scenario.trial_timeout * MOST_REPLAYS
    patient = replace(settings, scenario=settings.scenario.model_copy(update={"trial_timeout": limit}))
    with Journal(out or folder / WHY) as journal:
        known = journal.read(failures)
        asked: list[Question] = []
        for record in failures:
            job = job_of(run, record, folder)
            question = Question(job.trial, job.object, job.attempt, record, known.get(job.trial, {}))
            answer = recalled(question, settings.scenario)
            if answer is None:
                asked.append(question)
            else:
                _sort_in(answer, explained, rounded, broken, left_out)
        told = len(failures) - len(asked)
        progress(told, len(failures))
        count = min(workers or usable_cores(), max(len(asked), 1))
        executor: Executor = Examiners(count) if predictor is None else ExaminerHere(predictor)
        with closing(executor.run(patient, asked)) as answers:
            for number, answer in enumerate(answers, told + 1):
                if isinstance(answer, Fault):
                    left_out[answer.job.trial] = f"it could not be done again: {answer.detail}"
                else:
                    assert isinstance(answer, Examined)
                    journal.append(answer.new)
                    _sort_in(answer, explained, rounded, broken, left_out)
                progress(number, len(failures))
        damaged = journal.damaged
    return Study(
        folder,
        run,
        done,
        failed,
        tuple(applying(settings.scenario)),
        tuple(sorted(explained, key=lambda e: e.trial)),
        dict(sorted(left_out.items())),
        tuple(sorted(rounded)),
        dict(sorted(broken.items())),
        damaged,
    )


def _sort_in(
    answer: Examined,
    explained: list[Explanation],
    rounded: list[int],
    broken: dict[int, int],
    left_out: dict[int, str],
) -> None:
    """Put an examined trial to those that are explained, or to those that are left out."""
    record = answer.record
    if answer.verdict is Verdict.DIFFERENT:
        left_out[record.trial] = "done again unchanged, it does not come out as recorded"
        return
    if answer.verdict is Verdict.ROUNDING:
        rounded.append(record.trial)
    if answer.broken:
        broken[record.trial] = answer.broken
    outcome = str(record.outcome)
    explained.append(Explanation(record.trial, record.object, outcome, answer.sets, answer.tried + 1))
