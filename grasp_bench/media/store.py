"""A trial's pictures and clip as files of its run: ``media/00017.webp``, ``media/00017-clip.webp``.

The picture is a sheet of four squares: what was seen and its depth above, what was proposed and
how it ended below; see :mod:`grasp_bench.media.pictures`. The clip is an animated WebP. An episode
of clutter has both of each attempt: ``media/00017-02.webp``, ``media/00017-02-clip.webp``.
"""

from __future__ import annotations

import io
import os
import re
import stat
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from grasp_bench.media.film import Filmer
from grasp_bench.media.pictures import TILE, Rgb
from grasp_bench.media.recording import Recording
from grasp_bench.media.takes import Take
from grasp_bench.scenario.sections import Scenario
from grasp_bench.system import interrupts
from grasp_bench.system.files import read_text
from grasp_bench.system.integrity import write_whole
from grasp_bench.system.texts import LONGEST, legible, raised
from grasp_bench.trials.attempt import Trial

FOLDER = "media"
CLIP_SIZE = (320, 240)
CLIP_INTERVAL = 0.32
"""Simulated seconds from one frame to the next."""
CLIP_RATE = 8.0
"""Frames a second, which shows trials at two and a half times their speed."""


@dataclass(frozen=True)
class Media:
    """The files of one try; None where there is none."""

    sheet: Path | None
    clip: Path | None


def stem(trial: int, attempt: int | None = None) -> str:
    """Return what the names of the files of a trial, or of an attempt of an episode, begin with."""
    return f"{trial:05}" if attempt is None else f"{trial:05}-{attempt:02}"


def find(run: Path, trial: int, attempt: int | None = None) -> Media:
    """Return what is stored of a trial, or of an attempt of an episode."""
    sheet, clip = _paths(run, trial, attempt)
    return Media(sheet if _is_picture(sheet) else None, clip if _is_picture(clip) else None)


def _is_picture(path: Path) -> bool:
    """Return whether a file is a WebP of the run itself, and no link, which may lead anywhere."""
    if path.is_symlink() or path.parent.is_symlink():
        return False
    try:
        handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOFOLLOW | os.O_CLOEXEC)
    except OSError:
        return False
    with os.fdopen(handle, "rb") as file:
        if not stat.S_ISREG(os.fstat(handle).st_mode):
            return False
        head = file.read(12)
    return head[:4] == b"RIFF" and head[8:] == b"WEBP"


def remove(run: Path, trial: int) -> None:
    """Delete what is stored of a trial and all its attempts."""
    for pattern in (f"{stem(trial)}.webp", f"{stem(trial)}-*.webp"):
        for path in (run / FOLDER).glob(pattern):
            path.unlink()


def wanted(mode: str, success: bool) -> bool:
    """Return whether a try that ended like this gets a clip."""
    return mode == "all" or (mode == "failures" and not success)


class PictureRecorder(Recording):
    """A recording of one try, stored as pictures and a clip.

    Args:
        run: the run's folder.
        mode: one of :data:`~grasp_bench.media.modes.MODES`, not ``none``.
        scenario: scenario of the trial.
        attempt: number of the try in its episode, None for a single trial.
    """

    def __init__(self, run: Path, mode: str, scenario: Scenario, attempt: int | None = None) -> None:
        period = scenario.physics.timestep * scenario.physics.control_steps
        super().__init__(max(1, round(CLIP_INTERVAL / period)))
        self._run, self._mode, self._scenario, self._attempt = run, mode, scenario, attempt

    def keep(self, done: Trial, predictor: Any) -> None:
        """Store the pictures of a try, and its clip where the mode wants one.

        Nothing is stored of a try that ended before there was an image. Whatever goes wrong is written into
        a text file beside, and does not touch the trial. A predictor's ``last_maps`` and ``crop_origin``
        are drawn if it has them.
        """
        if done.image is None or done.world is None:
            return
        number = done.record.trial
        try:
            sheet, clip = _paths(self._run, number, self._attempt)
            sheet.parent.mkdir(parents=True, exist_ok=True)
            take = Take.of(done, self, predictor, self._attempt)
            write_whole(sheet, _webp([self._sheet(take)], 72))
            if wanted(self._mode, done.record.success) and take.moved:
                with Filmer(done.world.model, self._scenario, CLIP_SIZE) as filmer:
                    write_whole(clip, _webp([filmer.shoot(m.qpos) for m in take.moments], 42))
        except BaseException as error:  # a full disk, a foreign predictor's odd maps
            if interrupts.by_user(error):
                raise
            note_fault(self._run, number, error, self._attempt)

    def _sheet(self, take: Take) -> Rgb:
        """Return (2 · TILE, 2 · TILE, 3) pictures of a try."""
        assert take.done.world is not None
        shown = take.pictures()
        with Filmer(take.done.world.model, self._scenario, (TILE, TILE)) as filmer:
            last = filmer.shoot(take.moments[-1].qpos)
        return np.vstack([np.hstack([shown["seen"], shown["depth"]]), np.hstack([shown["proposed"], last])])


def faults(run: Path) -> dict[int, str]:
    """Return trials whose media could not be made, and why; of an episode, its first such attempt."""
    found: dict[int, str] = {}
    for path in sorted((run / FOLDER).glob("*.txt")):
        name = re.fullmatch(r"([0-9]{5,9})(?:-([0-9]{2,9}))?", path.stem)
        if name is None or path.is_symlink():
            continue  # somebody's notes, or a way elsewhere
        try:
            why = legible(read_text(path).strip(), LONGEST)
        except (OSError, ValueError) as error:
            why = f"{path.name} cannot be read ({raised(error)})"
        found.setdefault(int(name[1]), f"attempt {int(name[2])}: {why}" if name[2] else why)
    return found


def note_fault(run: Path, trial: int, error: BaseException, attempt: int | None = None) -> None:
    """Write down why something of a try could not be stored, if that can be written."""
    with suppress(OSError):
        write_whole(run / FOLDER / f"{stem(trial, attempt)}.txt", f"{raised(error)}\n".encode())


def _paths(run: Path, trial: int, attempt: int | None) -> tuple[Path, Path]:
    name = stem(trial, attempt)
    return run / FOLDER / f"{name}.webp", run / FOLDER / f"{name}-clip.webp"


def _webp(frames: list[Rgb], quality: int) -> bytes:
    """Return one picture, or an endless animation whose last frame stays a second."""
    buffer = io.BytesIO()
    first, *others = (Image.fromarray(f) for f in frames)
    if not others:
        first.save(buffer, "WEBP", quality=quality, method=3)
    else:
        period = round(1000 / CLIP_RATE)
        first.save(
            buffer,
            "WEBP",
            quality=quality,
            method=2,
            save_all=True,
            append_images=others,
            loop=0,
            duration=[period] * len(others) + [1000],
            kmin=999,
            kmax=1000,
        )
    return buffer.getvalue()
