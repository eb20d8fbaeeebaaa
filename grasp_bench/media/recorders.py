"""Recorders that keep pictures and logs of a run's trials beside their records."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from grasp_bench.runs.jobs import Settings
from grasp_bench.scene.world import World
from grasp_bench.trials.attempt import Trial
from grasp_bench.trials.watching import Watcher


class Recorders:
    """Several recorders as one."""

    def __init__(self, recorders: Sequence[Watcher]) -> None:
        self._recorders = recorders

    def __call__(self, world: World) -> None:
        """See :class:`Watcher`."""
        for recorder in self._recorders:
            recorder(world)

    def keep(self, done: Trial, predictor: Any) -> None:
        """See :class:`Watcher`."""
        for recorder in self._recorders:
            recorder.keep(done, predictor)


def recorders_for(settings: Settings, attempt: int | None = None) -> Recorders | None:
    """Return what watches one trial, or one attempt of an episode; None where nothing is kept."""
    if not settings.keeps or settings.folder is None:
        return None
    found: list[Watcher] = []
    if settings.media != "none":
        from grasp_bench.media.store import PictureRecorder

        found.append(PictureRecorder(settings.folder, settings.media, settings.scenario, attempt))
    if settings.rerun:
        from grasp_bench.media.rerun_log import RerunRecorder

        found.append(RerunRecorder(settings.folder, settings.scenario, attempt))
    return Recorders(found)
