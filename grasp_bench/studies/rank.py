"""Ranking predictors by a race on the same trials, until all are told apart or the budget is used up."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from pathlib import Path

from grasp_bench.errors import GraspBenchError, UnknownNameError
from grasp_bench.execution.describe import describe
from grasp_bench.execution.protocol import Round
from grasp_bench.execution.runner import check_inputs, owned
from grasp_bench.execution.together import can_share, try_together
from grasp_bench.objects.catalog import Catalog
from grasp_bench.objects.difficulty import check_graded
from grasp_bench.predictors.identity import identify
from grasp_bench.runs import margins
from grasp_bench.runs.folder import RunFolder
from grasp_bench.runs.jobs import Job, Settings
from grasp_bench.runs.limits import check_seed
from grasp_bench.runs.record import TrialRecord
from grasp_bench.scenario.sections import Scenario
from grasp_bench.studies.draw import draw, whole
from grasp_bench.studies.race import Race

BATCH = 8
"""Items that are tried before it is decided who goes on. Fixed, so that the result does not depend on the
number of workers."""

OnTrial = Callable[[str, TrialRecord, bool], None]
"""Called with a predictor's name, its record, and whether it was there before."""


@dataclass(frozen=True)
class Score:
    """What a trial counts: a number in [0, 1], by its name in tables."""

    what: str
    of: Callable[[TrialRecord], float]


SCORES = {
    "success": Score("success", lambda record: float(record.success)),
    "firmness": Score("firmness", margins.score),
}
"""Scores by name; ``firmness`` (:func:`grasp_bench.runs.margins.score`) needs a scenario with a margin."""
DIFFICULTY = "difficulty"
"""Name of the score that a lift of an object of so much difficulty counts, and a failure 0."""


def score_for(
    scenario: Scenario, name: str | None = None, catalog: Catalog | None = None, objects: Sequence[str] = ()
) -> Score:
    """Return a score by its name; by default the finest that the scenario measures.

    Args:
        scenario: of all trials.
        name: one of :data:`SCORES`, or :data:`DIFFICULTY`.
        catalog, objects: whose difficulties count.

    Raises:
        UnknownNameError: for a name that is none.
        GraspBenchError: for firmness where the scenario does not measure it, and for objects whose difficulty
            was not measured with its gripper.
    """
    chosen = name or ("success" if scenario.margin is None else "firmness")
    if chosen == DIFFICULTY:
        known = check_graded(scenario, catalog or Catalog(), objects)
        return Score("difficulty lifted", lambda record: known[record.object] * record.success)
    if chosen not in SCORES:
        raise UnknownNameError("score", chosen, [*SCORES, DIFFICULTY])
    if chosen == "firmness" and scenario.margin is None:
        raise GraspBenchError(
            f"Scenario {scenario.name} does not measure how firmly objects are held; use --score success, or "
            "--scenario graded or graded-as-predicted."
        )
    return SCORES[chosen]


@dataclass(frozen=True)
class Contest:
    """What is raced for.

    Attributes:
        predictors: names of those that race.
        scenario: of all trials; not of clutter.
        catalog, objects: catalogue of the objects, and the names of those that items are drawn from.
        score: what a trial counts.
        budget: most items for each predictor.
        alpha: chance at most that any pair is put in a wrong order.
        seed: of the items, and of their trials.
    """

    predictors: tuple[str, ...]
    scenario: Scenario
    catalog: Catalog
    objects: tuple[str, ...]
    score: Score
    budget: int = 180
    alpha: float = 0.05
    seed: int = 0


def rank(
    contest: Contest, folder: Path, workers: int, on_trial: OnTrial = lambda name, record, there: None
) -> Race:
    """Race until all predictors are told apart or the budget is used up; what is there already counts.

    Each predictor has an ordinary run in ``folder``, of which the items are trials; the same call goes on
    where a stopped one ended, also with a larger budget. The result depends on neither ``workers`` nor on
    how often it was stopped.

    Raises:
        GraspBenchError: before any trial starts, for anything wrong with the inputs.
    """
    check_seed(contest.seed)
    if len(set(contest.predictors)) < max(2, len(contest.predictors)):
        raise GraspBenchError("A ranking needs two predictors or more, each named once.")
    if contest.scenario.clutter is not None:
        raise GraspBenchError(
            f"Scenario {contest.scenario.name} clears tables, whose attempts depend on each other; rank on a "
            "scenario with one object at a time, e.g. table4."
        )
    for name in contest.predictors:
        if not can_share(name):
            raise GraspBenchError(
                f"{name} would share a process with the others, which its code might change. Give it one of "
                f'its own: "cmd: grasp-bench serve {name} --port {{port}}".'
            )
    try:
        items = draw(contest.objects, contest.budget, contest.seed)
    except ValueError as error:
        raise GraspBenchError(f"--budget: {error}; name more objects.") from error
    race = Race(contest.predictors, contest.alpha)
    jobs = whole(contest.objects)
    settings = Settings(
        contest.scenario, contest.catalog.folder.resolve(), contest.predictors[0], contest.seed, "raycast"
    )
    catalog = check_inputs(settings, jobs)
    names = contest.predictors
    facts = {name: identify(name) for name in names}
    with ExitStack() as stack:
        opened: dict[str, RunFolder] = {}
        scores: dict[str, dict[int, float]] = {name: {} for name in names}
        for name in names:
            path = folder / folder_name(name)

            def there(record: TrialRecord, _: bool, name: str = name) -> None:
                scores[name][record.trial] = contest.score.of(record)
                on_trial(name, record, True)

            run = opened[name] = stack.enter_context(RunFolder(path))
            one = replace(settings, predictor=name)
            info = describe(one, jobs, catalog, facts[name]).model_copy(update={"drawn": True})
            run.start(info, owned(path, jobs, there))
        rounds = _rounds(race, items, scores)
        with closing(try_together(settings, names, rounds, catalog, workers)) as ended:
            for tried in ended:
                opened[tried.predictor].append(tried.record, tried.timings)
                scores[tried.predictor][tried.record.trial] = contest.score.of(tried.record)
                on_trial(tried.predictor, tried.record, False)
        for run in opened.values():
            run.finish()
    return race


def _rounds(race: Race, items: Sequence[Job], scores: dict[str, dict[int, float]]) -> Iterator[Round | None]:
    """Yield what is to be tried next for those in doubt; None while it depends on trials under way."""
    for start in range(0, len(items), BATCH):
        batch, racing = items[start : start + BATCH], race.in_doubt
        for job in batch:
            if missing := tuple(n for n in racing if job.trial not in scores[n]):
                yield Round(job.trial, job.object, job.attempt, missing)
        while any(job.trial not in scores[n] for job in batch for n in racing):
            yield None
        for job in batch:
            if not race.in_doubt:
                return
            race.observe({n: scores[n][job.trial] for n in race.in_doubt})


def folder_name(predictor: str) -> str:
    """Return the name of a predictor's run in a ranking's folder."""
    return predictor.replace(":", "-").replace("/", "-")
