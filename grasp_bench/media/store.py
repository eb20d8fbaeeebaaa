"""A trial's pictures and clip as files of its run: ``media/00017.webp``, ``media/00017-clip.webp``.

The picture is a sheet of four squares: what was seen and its depth above, what was proposed and
how it ended below; see :mod:`grasp_bench.media.pictures`. The clip is an animated WebP.
"""

from __future__ import annotations

import io
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from grasp_bench.media.film import Filmer
from grasp_bench.media.pictures import TILE, crop_for, depth, proposed, seen
from grasp_bench.media.recording import Moment, Recording, moment
from grasp_bench.outcomes import Outcome
from grasp_bench.scenario import Scenario
from grasp_bench.scene.world import World
from grasp_bench.trial import Trial

FOLDER = "media"
CLIP_SIZE = (208, 156)
CLIP_INTERVAL = 0.32
"""Simulated seconds from one frame to the next."""
CLIP_RATE = 8.0
"""Frames a second, which shows trials at two and a half times their speed."""


@dataclass(frozen=True)
class Media:
    """The files of one trial; None where there is none."""

    sheet: Path | None
    clip: Path | None


def find(run: Path, trial: int) -> Media:
    """What is stored of a trial."""
    sheet, clip = _paths(run, trial)
    return Media(sheet if sheet.is_file() else None, clip if clip.is_file() else None)


def remove(run: Path, trial: int) -> None:
    """Delete what is stored of a trial."""
    for path in _paths(run, trial):
        path.unlink(missing_ok=True)


def wanted(mode: str, success: bool) -> bool:
    """Whether a trial that ended so gets a clip."""
    return mode == "all" or (mode == "failures" and not success)


class PictureRecorder:
    """Watches one trial as its observer, and stores its pictures and clip afterwards.

    Args:
        run: the run's folder.
        mode: one of :data:`~grasp_bench.media.modes.MODES`, not ``none``.
        scenario: of the trial.
    """

    def __init__(self, run: Path, mode: str, scenario: Scenario) -> None:
        self._run, self._mode, self._scenario = run, mode, scenario
        period = scenario.physics.timestep * scenario.physics.control_steps
        self._recording = Recording(max(1, round(CLIP_INTERVAL / period)))

    def __call__(self, world: World) -> None:
        """Called after every sample of the arm's motion."""
        self._recording(world)

    def keep(self, done: Trial, predictor: Any) -> None:
        """Store the pictures of a trial, and its clip where the mode wants one.

        Nothing is stored of a trial that ended before there was an image. Whatever goes wrong
        is written into a text file beside, and does not touch the trial.

        Args:
            done: the trial.
            predictor: that was asked; its ``last_maps`` and ``crop_origin`` are drawn if it has them.
        """
        if done.image is None or done.world is None:
            return
        number = done.record.trial
        try:
            files = _paths(self._run, number)
            files[0].parent.mkdir(parents=True, exist_ok=True)
            end = moment(done.world)
            _write(files[0], _webp([self._sheet(done, end, predictor)], 72))
            moments = self._recording.moments
            if wanted(self._mode, done.record.success) and moments:
                with Filmer(done.world.model, self._scenario, CLIP_SIZE) as filmer:
                    _write(files[1], _webp([filmer.shoot(m.qpos) for m in [*moments, end]], 42))
        except Exception as error:  # a full disk, a foreign predictor's odd maps
            note_fault(self._run, number, error)

    def _sheet(self, done: Trial, end: Moment, predictor: Any) -> np.ndarray:
        """(2 · TILE, 2 · TILE, 3) pictures of a trial."""
        assert done.image is not None
        assert done.world is not None
        with Filmer(done.world.model, self._scenario, (TILE, TILE)) as filmer:
            last = filmer.shoot(end.qpos)
        image, grasp = done.image, done.record.grasp
        crop = crop_for(image, [] if grasp is None else [grasp])
        failed = done.record.outcome == Outcome.ERROR  # what a predictor has then is of an earlier image
        maps = None if failed else getattr(predictor, "last_maps", None)
        origin = getattr(predictor, "crop_origin", (0, 0))
        wanted_at = proposed(image, crop, done.grasps, grasp, maps, origin)
        return np.vstack([np.hstack([seen(image, crop, grasp), depth(image, crop, grasp)]),
                          np.hstack([wanted_at, last])])


def faults(run: Path) -> dict[int, str]:
    """Trials whose media could not be made, and why."""
    return {int(p.stem): p.read_text(encoding="utf-8").strip() for p in sorted((run / FOLDER).glob("*.txt"))}


def note_fault(run: Path, trial: int, error: Exception) -> None:
    """Write down why something of a trial could not be stored, if that can be."""
    with suppress(OSError):
        (run / FOLDER / f"{trial:05}.txt").write_text(f"{type(error).__name__}: {error}\n", encoding="utf-8")


def _paths(run: Path, trial: int) -> tuple[Path, Path]:
    return run / FOLDER / f"{trial:05}.webp", run / FOLDER / f"{trial:05}-clip.webp"


def _webp(frames: list[np.ndarray], quality: int) -> bytes:
    """One picture, or an endless animation whose last frame stays a second."""
    buffer = io.BytesIO()
    first, *others = (Image.fromarray(f) for f in frames)
    if not others:
        first.save(buffer, "WEBP", quality=quality, method=3)
    else:
        period = round(1000 / CLIP_RATE)
        first.save(buffer, "WEBP", quality=quality, method=2, save_all=True, append_images=others, loop=0,
                   duration=[period] * len(others) + [1000], kmin=999, kmax=1000)
    return buffer.getvalue()


def _write(path: Path, content: bytes) -> None:
    temporary = path.with_suffix(".tmp")
    temporary.write_bytes(content)
    temporary.replace(path)
