"""What is simulated in which phase of a trial."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from grasp_bench.errors import ScenarioError
from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.predictors.controls import Oracle
from grasp_bench.scenario.outcomes import Outcome
from grasp_bench.scenario.reading import with_value
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.world import World
from grasp_bench.trials.trial import run_trial
from grasp_bench.trials.workcell import Workcell

SLEEP = int(mujoco.mjtEnableBit.mjENBL_SLEEP)


class Notes:
    """Keeps of every sample: no-slip iterations, whether sleep is allowed, the object's place, the grip."""

    def __init__(self) -> None:
        self.samples: list[tuple[int, bool, np.ndarray, bool]] = []

    def __call__(self, world: World) -> None:
        option = world.model.opt
        place = world.object_pose[0]
        touched = bool(world.touch().held)
        self.samples.append((option.noslip_iterations, bool(option.enableflags & SLEEP), place, touched))


@pytest.fixture(scope="module")
def watched(scenario: Scenario, models: dict[str, ObjectModel]) -> Notes:
    notes = Notes()
    done = run_trial(Workcell(scenario), models["block"], Oracle(), observer=notes)
    assert done.record.outcome is Outcome.SUCCESS
    return notes


def test_no_slip_iterations_begin_when_the_fingers_have_closed(watched: Notes) -> None:
    iterations = [n for n, *_ in watched.samples]
    begin = iterations.index(3)
    assert set(iterations[:begin]) == {0}
    assert set(iterations[begin:]) == {3}
    assert watched.samples[begin - 1][3], "the object is held before it is lifted"


def test_what_lies_untouched_sleeps_until_the_fingers_close(watched: Notes) -> None:
    asleep = [sleeps for _, sleeps, *_ in watched.samples]
    begin = asleep.index(False)
    assert all(asleep[:begin])
    assert not any(asleep[begin:])
    places = [place for *_, place, _ in watched.samples]
    still = [bool(np.array_equal(p, places[40])) for p in places]
    first = still.index(False, 41)
    assert all(still[40:first])
    assert first > 200, "not one bit of its place changes while the arm comes"


def test_without_sleep_a_trial_ends_alike(scenario: Scenario, models: dict[str, ObjectModel]) -> None:
    awake = with_value(scenario, "physics.sleep", False)
    for name, model in models.items():
        asleep, other = (run_trial(Workcell(s), model, Oracle()).record for s in (scenario, awake))
        assert asleep.outcome == other.outcome, name
        assert asleep.lift_height == pytest.approx(other.lift_height, abs=0.002)


def test_trials_of_an_earlier_definition_are_refused(scenario: Scenario) -> None:
    with pytest.raises(ScenarioError, match=r"version 1 of the definition.*carries out version 2"):
        Workcell(scenario.model_copy(update={"version": 1}))
