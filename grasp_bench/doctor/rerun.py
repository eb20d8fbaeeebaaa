"""Some trials of a finished run done again here, and compared byte for byte."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from grasp_bench.doctor.checks import Check, State
from grasp_bench.errors import ResultsError, UnknownNameError
from grasp_bench.execution.describe import describe
from grasp_bench.execution.protocol import Executor
from grasp_bench.execution.runner import carry_out
from grasp_bench.objects.catalog import Catalog, folder_of
from grasp_bench.predictors.names import parse
from grasp_bench.predictors.trust import require
from grasp_bench.runs.folder import TRIALS, load_run
from grasp_bench.runs.info import RUN, SAME_RUN, Group, RunInfo
from grasp_bench.runs.jobs import Jobs, Settings, spread
from grasp_bench.runs.lines import scan
from grasp_bench.runs.record import TrialRecord
from grasp_bench.scenario.outcomes import Outcome

MEANINGS = {
    "scenario": "this version reads the scenario differently: results of the two must not be mixed",
    "objects": "other shapes or masses: the trials are not the same",
    "weights": "another network: the rate may be another",
    "versions": "MuJoCo and its kin promise the same bits only for the same version: single trials may end "
    "otherwise, a rate over many hardly changes",
    "renderer": "other pixels, so that a network's grasps differ slightly",
    "cpu": "a network's last digits depend on the processor's instructions, and a grasp that is chosen by a "
    "hair may be another",
    "platform": "compilers and mathematical libraries differ: single trials may end otherwise",
    "python": "no known effect on results",
    "git": "other code of grasp-bench",
    "environment": "these choose other instructions or another precision: a network's last digits may differ",
    "apart": "a predictor within the harness's process could read the truth; one apart cannot",
}


@dataclass(frozen=True)
class Rerun:
    """What a rerun found.

    Attributes:
        checks: what differs between then and now, and whether the trials repeat.
        repeated, tried: number of trials with the same record, and of all that were done again.
    """

    checks: list[Check]
    repeated: int
    tried: int


def rerun(
    folder: Path, trials: int, executor: Executor, objects: Path | None = None, trust: bool = False
) -> Rerun:
    """Do some trials of a run again.

    Args:
        folder: the run's folder.
        trials: how many, spread evenly over those that it holds.
        executor: carries the trials out.
        objects: folder of the objects; by default the shipped ones.
        trust: start a predictor that is not shipped, too, though only the record names it.

    Raises:
        UntrustedError: for a predictor that is not shipped, unless it is trusted.
        ResultsError: when the folder cannot be read or holds no trial.
        GraspBenchError: when the predictor, the scenario or an object cannot be used here.
    """
    run = load_run(folder)
    require(run.predictor, folder, trust)
    scenario = run.parsed(str(folder / RUN))
    catalog = Catalog(objects or folder_of(scenario.objects.folder))
    names = run.tried
    for name in names:
        if name not in catalog.entries:
            where = UnknownNameError("object", name, catalog.names)
            raise ResultsError(
                f"{folder} is a run on objects that {catalog.folder} does not hold; name "
                f"their folder with --objects. {where}"
            )
    settings = Settings(scenario, catalog.folder.resolve(), run.predictor, run.seed, run.renderer)
    jobs = spread(names, run.trials)
    before = _chosen(folder, jobs, trials)
    here = describe(settings, jobs, catalog, run.implementation)
    checks = _stack(run, here)
    with closing(carry_out(settings, [jobs.job(t) for t in before], catalog, executor)) as ended:
        after = {record.trial: record for record, _ in ended}
    apart = [(before[t], after[t]) for t in before if before[t].line() != after[t].line()]
    explained = any(c.state is State.NOTE for c in checks)
    if (isolation := _isolation(run)) is not None:
        checks.append(isolation)
    return Rerun([*checks, _verdict(apart, len(before), explained)], len(before) - len(apart), len(before))


def _chosen(folder: Path, jobs: Jobs, count: int) -> dict[int, TrialRecord]:
    """Return records of trials spread evenly over a run; faults that depend on time are left out."""
    numbers = sorted(
        line.record.trial
        for line in scan(folder / TRIALS)
        if line.record.outcome not in (Outcome.TIMEOUT, Outcome.ERROR)
    )
    if not numbers:
        raise ResultsError(f"{folder} holds no trial that could be repeated.")
    step = max(1, len(numbers) // count)
    wanted = set(numbers[step // 2 :: step][:count])
    chosen = {}
    for line in scan(folder / TRIALS):
        record = line.record
        if record.trial in wanted:
            if record.trial >= jobs.total or jobs.job(record.trial).object != record.object:
                raise ResultsError(
                    f"{folder} holds trial {record.trial} on {record.object}, which is "
                    f"none of its {RUN}'s; its files were mixed up."
                )
            chosen[record.trial] = record
    return dict(sorted(chosen.items()))


def _stack(run: RunInfo, here: RunInfo) -> list[Check]:
    """Return what differs between then and now, and what that means."""
    found = run.differences(here, *SAME_RUN, Group.ORIGIN, places=("then", "now"))
    if not found:
        return [Check("Stack", State.OK, "objects, weights, versions, renderer and processor are the run's")]
    return [Check(key.capitalize(), State.NOTE, f"{words}: {MEANINGS[key]}") for key, words in found.items()]


def _isolation(run: RunInfo) -> Check | None:
    """Return whether a predictor that is not shipped could have read the truth; None for a shipped one."""
    apart = parse(run.predictor).apart
    if apart is None:
        return None
    if apart and run.apart is True:
        return Check("Process", State.OK, "the predictor ran, and runs now, in a process of its own")
    if apart:
        return Check(
            "Process", State.NOTE, "run.json does not say that the predictor had a process of its own"
        )
    return Check(
        "Process",
        State.NOTE,
        "the predictor runs in the harness's process, where its caller's frame holds the truth: such a run "
        "can be no row of the leaderboard; docs/leaderboard.md says how to run it apart",
    )


def _verdict(apart: list[tuple[TrialRecord, TrialRecord]], tried: int, explained: bool) -> Check:
    if not apart:
        return Check("Trials", State.OK, f"{tried} of {tried} gave the same bytes again")
    shown = "; ".join(f"trial {b.trial} ({b.object}): {_apart(b, a)}" for b, a in apart[:5])
    more = f"; and {len(apart) - 5} more" if len(apart) > 5 else ""
    ends = sum(b.outcome != a.outcome for b, a in apart)
    cause = (
        "the differences above can explain it"
        if explained
        else "nothing explains it: the files were edited, the predictor draws numbers of its own, or one of "
        "the machines computes wrongly"
    )
    return Check(
        "Trials",
        State.BAD,
        f"{len(apart)} of {tried} differ, {ends} in their outcome; {cause}. {shown}{more}",
    )


def _apart(before: TrialRecord, after: TrialRecord) -> str:
    if before.outcome != after.outcome:
        return f"{before.outcome} then, {after.outcome} now"
    was, now = before.to_json(), after.to_json()
    return ", ".join(k for k in dict.fromkeys([*was, *now]) if was.get(k) != now.get(k))
