"""What several predictors find alike on one trial: made for the first, and found again by all others."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Any

from grasp_bench.camera import RgbdImage
from grasp_bench.objects.catalog import ObjectModel
from grasp_bench.scenario.seeding import Streams
from grasp_bench.scene.rendering import Picture
from grasp_bench.scene.world import UnstableError, World
from grasp_bench.trials.attempt import Table, take_first_picture
from grasp_bench.trials.clock import Clock
from grasp_bench.trials.trial import own_table
from grasp_bench.trials.workcell import Workcell


class SharedTable:
    """The table of a trial on one object that several predictors try in turn, each as if alone.

    The world is built, the object comes to rest and the picture is taken once; the next one finds all to the
    bit as the first one did. Attempts must not overlap: all are made in the same world.

    Args:
        cell, model: as for a trial.
        attempt, seed: those of the trial.
    """

    def __init__(self, cell: Workcell, model: ObjectModel, attempt: int = 0, seed: int = 0) -> None:
        self._cell, self._streams = cell, Streams(seed, model.name, attempt)
        self._own = own_table(cell, model, self._streams)
        self._world: World | None = None
        self._restore: Callable[[], None] | None = None
        self._unstable: UnstableError | None = None
        self._taken: tuple[Picture, RgbdImage] | None = None

    @property
    def table(self) -> Table:
        """What an attempt finds."""
        found = replace(self._own, build=self._build, settle=self._settle, take=self._take)
        return replace(found, another=self._own.fresh)

    def prepared(self) -> Table:
        """Build, settle and take the picture now, before anybody asks for it."""
        world = self._build()
        with suppress(UnstableError):  # every attempt is told again
            self._settle(world)
            take_first_picture(self._cell, self.table, world, self._streams, Clock())
        return self.table

    def _build(self) -> World:
        if self._world is None:
            self._world = self._own.build()
        return self._world

    def _settle(self, world: World) -> None:
        if self._unstable is not None:
            raise self._unstable
        if self._restore is not None:
            self._restore()
            return
        try:
            self._own.settle(world)
        except UnstableError as error:
            self._unstable = error
            raise
        self._restore = world.keep()

    def _take(self, *args: Any, **more: Any) -> tuple[Picture, RgbdImage]:
        if self._taken is None:
            self._taken = self._own.take(*args, **more)
        return self._taken
