"""Trials in this process, one after the other: no time limit, and a crash is the caller's."""

from __future__ import annotations

from collections.abc import Generator, Iterable

from grasp_bench.execution.protocol import Answer
from grasp_bench.execution.worker import attempt
from grasp_bench.objects.catalog import Catalog
from grasp_bench.predictors.protocol import Predictor
from grasp_bench.runs.jobs import Job, Settings


class Here:
    """Executor for a predictor that no other process can make; it is used for every trial.

    With ``raises``, the first exception of the predictor ends the run, and is raised as it is.
    """

    def __init__(self, predictor: Predictor, raises: bool = False) -> None:
        self.predictor, self.raises = predictor, raises

    def run(self, settings: Settings, jobs: Iterable[Job]) -> Generator[Answer, None, None]:
        """See :class:`~grasp_bench.execution.protocol.Executor`."""
        from grasp_bench.trials.workcell import Workcell

        catalog, cell = Catalog(settings.objects), Workcell(settings.scenario, settings.renderer)
        for job in jobs:
            yield attempt(job, settings, catalog, cell, self.predictor, raises=self.raises)
