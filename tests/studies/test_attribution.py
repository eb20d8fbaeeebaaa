"""First-success sets: what explains a failure, and what it has of each cause."""

from __future__ import annotations

from itertools import combinations
from math import factorial

import pytest

from grasp_bench.scenario.sections import Calibration, Execution, Scenario
from grasp_bench.scenario.sensors import Sensor
from grasp_bench.studies.why.attribution import UNEXPLAINED, Explanation, first_cause, first_success, shares
from grasp_bench.studies.why.causes import CAUSES, KEYS, Cause, Removed, applying, levels


def _of(*keys: str) -> Removed:
    return Removed(keys)


def _explained(*sets: Removed) -> Explanation:
    return Explanation(0, "mug", "missed", sets)


def _told(*saving: Removed) -> tuple[tuple[Removed, ...], int]:
    """The first sets where just the supersets of ``saving`` succeed."""
    return first_success(CAUSES, lambda removed: any(s <= removed for s in saving))


def test_no_trial_is_done_again_more_often_than_promised() -> None:
    found = [removed for level in levels(CAUSES) for removed in level]
    assert len(found) == len(set(found)) == 12 + 66 - 4
    assert all(1 <= len(removed) <= 2 for removed in found)
    assert _of("grasp", "width") not in found
    assert _of("depth", "height") not in found


def test_faults_come_before_remedies_and_singles_before_pairs() -> None:
    assert _told(_of("width"), _of("friction"))[0] == (_of("width"),)
    assert _told(_of("friction"), _of("place", "angle")) == ((_of("friction"),), 12)
    assert set(_told(_of("place", "angle"), _of("width", "mass"))[0]) == {_of("place", "angle")}
    assert _told(_of("width", "mass"))[0] == (_of("width", "mass"),)
    assert _told() == ((), 74)


def test_all_sets_of_the_first_level_share_a_failure() -> None:
    sets, _ = _told(_of("width"), _of("calibration"))
    assert set(sets) == {_of("calibration"), _of("width")}
    assert _explained(*sets).credit == {"calibration": 0.5, "width": 0.5}
    pair = _explained(_of("place", "angle"), _of("place", "mass"))
    assert pair.credit == {"place": 0.5, "angle": 0.25, "mass": 0.25}
    assert _explained().credit == {UNEXPLAINED: 1.0}


def test_a_whole_is_not_named_beside_its_own_part() -> None:
    def succeeds(removed: Removed) -> bool:
        return bool(removed & {"width", "grasp", "height", "depth"})

    assert set(first_success(CAUSES, succeeds)[0]) == {_of("width"), _of("height")}
    assert first_success(CAUSES, lambda removed: "grasp" in removed)[0] == (_of("grasp"),)

    def in_pairs(removed: Removed) -> bool:
        return "calibration" in removed and bool(removed & {"width", "grasp"})

    assert first_success(CAUSES, in_pairs)[0] == (_of("calibration", "width"),)


def test_ties_go_to_what_explains_most_of_the_run() -> None:
    clear = [_explained(_of("width"))] * 3
    tied = _explained(_of("place"), _of("width"))
    run = shares([*clear, tied])
    assert run == {"width": 3.5, "place": 0.5}
    assert first_cause(tied, run) == "width"
    assert first_cause(tied, shares([tied])) == "place"  # the order of the causes
    assert list(shares([_explained(), *clear])) == ["width", UNEXPLAINED]


def test_shapley_values_agree_where_one_cause_is_enough() -> None:
    """Where any set with one cause saves a trial, the Shapley value is 1 for that cause and 0 for others."""
    keys = ("calibration", "place", "width", "mass")

    def value(removed: Removed) -> float:
        return float("width" in removed)

    def shapley(key: str) -> float:
        others, n = [k for k in keys if k != key], len(keys)
        return sum(
            factorial(size) * factorial(n - size - 1) / factorial(n) * (value(_of(*s, key)) - value(_of(*s)))
            for size in range(n)
            for s in combinations(others, size)
        )

    sets, _ = first_success(CAUSES, lambda removed: value(removed) > 0)
    credit = _explained(*sets).credit
    assert {k: credit.get(k, 0.0) for k in keys} == pytest.approx({k: shapley(k) for k in keys})


def test_nothing_is_asked_that_changes_nothing(table4: Scenario) -> None:
    def keys(**changes: object) -> list[str]:
        return [c.key for c in applying(table4.model_copy(update=changes))]

    assert keys() == [k for k in KEYS if k != "calibration"]
    assert keys(sensor=Sensor(preset="ideal")) == [
        k for k in KEYS if k not in ("calibration", "depth", "colours", "height")
    ]
    assert keys(calibration=Calibration(rotation_deg=1.0)) == list(KEYS)

    def help_(execution: Execution) -> Cause:
        return next(
            c for c in applying(table4.model_copy(update={"execution": execution})) if c.key == "help"
        )

    assert help_(Execution()).loss == "the planner's help"
    assert help_(Execution(protocol="as-predicted")).loss == "no help by the planner"
