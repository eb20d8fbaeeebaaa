"""Predictors against robots: the same predictors with several grippers or arms, on the trials in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any

from grasp_bench.report.tables import TextTable
from grasp_bench.runs.comparison import scenes
from grasp_bench.runs.results import RunResults
from grasp_bench.runs.statistics import Rate

REFERENCE = ("ec66", "parallel-85")
"""Arm and gripper of runs that name none."""


@dataclass(frozen=True)
class Hands:
    """How predictors do with robots.

    Attributes:
        robots: what the columns are called, in the order of the runs.
        predictors: names of the rows, likewise.
        cells: rate of each pair that was run, on the trials that all pairs have in common.
        common: how many trials those are.
        left_out: how many trials of the runs are not among them.
    """

    robots: tuple[str, ...]
    predictors: tuple[str, ...]
    cells: dict[tuple[str, str], Rate]
    common: int
    left_out: int

    @classmethod
    def of(cls, runs: Sequence[RunResults]) -> Hands | None:
        """Return the matrix of the runs on single objects; None where they are all of one robot.

        Runs of the same predictor and robot count together.
        """
        chosen = [run for run in runs if len(run) and not run.info.cluttered]
        parts = [_robot(run) for run in chosen]
        if len(set(parts)) < 2:
            return None
        one_arm = len({arm for arm, _ in parts}) == 1
        names = [gripper if one_arm else f"{gripper} on {arm}" for arm, gripper in parts]
        tried: dict[tuple[str, str], dict[Any, bool]] = {}
        for run, name in zip(chosen, names, strict=True):
            cell = tried.setdefault((run.predictor, name), {})
            cell.update({scene: record.success for scene, record in scenes(run).items()})
        common = set.intersection(*({*cell} for cell in tried.values()))
        cells = {
            key: Rate(sum(won for scene, won in cell.items() if scene in common), len(common))
            for key, cell in tried.items()
        }
        left_out = sum(len(cell) for cell in tried.values()) - len(common) * len(tried)
        return cls(
            tuple(dict.fromkeys(names)),
            tuple(dict.fromkeys(r.predictor for r in chosen)),
            cells,
            len(common),
            left_out,
        )

    def table(self) -> TextTable:
        """Return predictors by robots, with what is compared and what is not."""
        rows = [
            [predictor, *(_cell(self.cells.get((predictor, robot))) for robot in self.robots)]
            for predictor in self.predictors
        ]
        note = (
            f"On the {self.common} trials (seed, object, attempt) that all of these have; {self.left_out} "
            "others are left out, such as those on objects that a gripper cannot grasp. – was not run. How "
            "an object rests is drawn from the poses that the gripper can grasp, so it may lie differently."
        )
        if not self.common:
            note = "These runs have no trial in common: take the same seed and objects for each."
        return TextTable(
            "Predictors and robots",
            ("Predictor", *self.robots),
            rows,
            note=note,
            numbers=tuple(range(1, len(self.robots) + 1)),
        )

    def to_json(self) -> dict[str, Any]:
        """Return plain data."""
        return {
            "robots": list(self.robots),
            "common_trials": self.common,
            "cells": [{"predictor": p, "robot": r, **rate.counts()} for (p, r), rate in self.cells.items()],
        }


def _robot(run: RunResults) -> tuple[str, str]:
    """Return the names of a run's arm and gripper; of folders of one's own, the last part."""
    robot = run.info.robot
    if robot is None:
        return REFERENCE
    arm, gripper = (PurePath(str(robot.get(kind, {}).get("name", "?"))).name for kind in ("arm", "gripper"))
    return arm, gripper


def _cell(rate: Rate | None) -> str:
    if rate is None or not rate.trials:
        return "–"
    low, high = rate.interval
    return f"{rate.successes}/{rate.trials} ({100 * low:.0f} – {100 * high:.0f} %)"
