"""Clearing a cluttered table: many objects at once, taken away one after another.

The situation of Figure 6 of the HTC-Grasp paper, tried out in physics. An episode puts several objects
down and then makes attempts, each like that of a trial on one object, until the table is empty or too many in
a row have failed. What was carried away is removed; what was lost stays where it fell.

An episode is one trial of a run, so it is resumed, sharded and timed like any other; its record holds its
attempts under ``clutter``. Every attempt has a world of its own, of what is still on the table.
"""

from __future__ import annotations

import numpy as np

from grasp_bench.objects.catalog import Catalog
from grasp_bench.predictors.protocol import Predictor
from grasp_bench.runs.jobs import Job
from grasp_bench.runs.record import AttemptRecord, EpisodeRecord, TrialRecord
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scenario.seeding import Purpose, Streams
from grasp_bench.scene.world import UnstableError, World
from grasp_bench.trials.attempt import Table, Trial, attempt
from grasp_bench.trials.clock import Clock
from grasp_bench.trials.placing import Resting, lay_out, resting, world_of
from grasp_bench.trials.watching import Watch, unwatched, watched
from grasp_bench.trials.workcell import Workcell


def run_episode(
    cell: Workcell,
    catalog: Catalog,
    predictor: Predictor,
    job: Job,
    seed: int,
    clock: Clock | None = None,
    watch: Watch = unwatched,
) -> TrialRecord:
    """Clear one table.

    Args:
        catalog: holds the objects that may be on the table.
        job: number in the run, the object that is surely on the table (the others are drawn at random), and
            how many episodes of the run had it before.
        seed: the run's seed.
        clock: takes the times of all attempts together; a new one by default.
        watch: gives the watcher of the attempt of a number.
    """
    clock = clock or Clock()
    scenario = cell.scenario
    assert scenario.clutter is not None
    rng = Streams(seed, job.object, job.attempt)(Purpose.CLUTTER)
    names = drawn(job.object, catalog, scenario, rng)
    left: list[Resting] = []
    attempts: list[AttemptRecord] = []
    outcome, detail = Outcome.SUCCESS, ""
    failures = 0
    try:
        with clock.phase("settle"):
            left = lay_out([cell.fitted(catalog.load(n)) for n in names], scenario, rng)
        while left and failures < scenario.clutter.failures:
            number = len(attempts)
            done = watched(
                watch(number),
                predictor,
                lambda watcher, left=left, number=number: attempt(
                    cell,
                    _table(left, scenario),
                    predictor,
                    Streams(seed, f"{job.object}/{number}", job.attempt),
                    trial=job.trial,
                    clock=clock,
                    observer=watcher,
                ),
            )
            record = done.record
            left, removed = _after(done, left, scenario)
            attempts.append(record.as_attempt(number, removed))
            failures = 0 if record.success else failures + 1
            if not record.success:
                outcome, detail = record.outcome, record.detail
            if record.outcome in (Outcome.UNSTABLE, Outcome.ERROR):
                break
    except UnstableError as error:
        left = left or [Resting(catalog.load(n), np.zeros(3), np.zeros(4)) for n in names]
        outcome, detail = Outcome.UNSTABLE, str(error)
    if left:
        detail = f"{len(left)} of {len(names)} objects left; at last: {detail or outcome}"
    else:
        outcome, detail = Outcome.SUCCESS, ""
    return TrialRecord(
        trial=job.trial,
        object=job.object,
        category=catalog.entries[job.object]["category"],
        seed=seed,
        outcome=outcome,
        detail=detail,
        sim_steps=sum(a.sim_steps for a in attempts),
        clutter=EpisodeRecord(objects=names, cleared=len(names) - len(left), attempts=attempts),
    )


def drawn(lead: str, catalog: Catalog, scenario: Scenario, rng: np.random.Generator) -> list[str]:
    """Draw the names of an episode's objects: ``lead``, and others at random."""
    assert scenario.clutter is not None
    others = [n for n in catalog.chosen(scenario.objects.names) if n != lead]
    count = int(rng.integers(scenario.clutter.fewest, scenario.clutter.most + 1))
    more = min(count, len(others) + 1) - 1
    return [lead, *(others[i] for i in rng.permutation(len(others))[:more])]


def _table(left: list[Resting], scenario: Scenario) -> Table:
    return Table([r.model for r in left], lambda: world_of(left, scenario), World.settle)


def _after(done: Trial, before: list[Resting], scenario: Scenario) -> tuple[list[Resting], tuple[str, ...]]:
    """Return what is left on the table after an attempt, and the names of what it took away."""
    world, outcome = done.world, done.record.outcome
    if world is None or outcome in (Outcome.UNSTABLE, Outcome.ERROR):
        return before, ()
    now = resting(world, before)
    if outcome is not Outcome.SUCCESS:
        return now, ()
    lifted = scenario.success.minimum_lift
    gone = {i for i in range(len(before)) if i == world.target or world.rise(i) > lifted}
    left = [r for i, r in enumerate(now) if i not in gone]
    return left, tuple(before[i].model.name for i in sorted(gone))
