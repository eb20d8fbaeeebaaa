"""A replay as a film: the scene from the side, with what was seen and proposed set into it.

GIF and WebP are written by Pillow; everything else, MP4 above all, by ffmpeg, which comes with
the optional ``imageio-ffmpeg``.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from grasp_bench.errors import GraspBenchError
from grasp_bench.media.film import Filmer
from grasp_bench.media.takes import Take
from grasp_bench.replay.rebuild import Replay
from grasp_bench.scenario.sections import Scenario

Rgb = NDArray[np.uint8]
RATES = {".mp4": 25.0, ".webm": 25.0, ".mkv": 25.0, ".mov": 25.0, ".gif": 12.5, ".webp": 12.5}
"""Frames a second by kind of file; films run in real time."""
INSET = 0.36
"""Edge of an inset as a share of the film's height."""
LETTERS = 16
"""Height of captions [px]."""
LAST = 1.0
"""Seconds for which the last picture of a try stays."""


def check_kind(path: Path) -> float:
    """Return the frames a second of a film's kind.

    Raises:
        GraspBenchError: for a kind that cannot be written, or whose library is missing.
    """
    kind = path.suffix.lower()
    if kind not in RATES:
        raise GraspBenchError(f"{path}: films end in {', '.join(RATES)}, not {kind or 'nothing'}.")
    if kind not in (".gif", ".webp"):
        try:
            import imageio_ffmpeg  # noqa: F401
        except ImportError as error:
            raise GraspBenchError(
                f"{kind[1:]} films need ffmpeg: pip install 'grasp-bench[video]'; .gif and "
                ".webp need nothing."
            ) from error
    return RATES[kind]


def write_film(replay: Replay, path: Path, size: tuple[int, int] = (640, 480), opengl: bool = False) -> int:
    """Write the replay as a film, the attempts of an episode one after the other.

    Args:
        replay: a trial that has an image, or an episode, of which the attempts with an image are filmed.
        path: file to write, of the kind that its ending says.
        size: width and height [px], even numbers.
        opengl: draw with OpenGL; see :class:`~grasp_bench.media.film.Filmer`.

    Returns:
        The number of pictures.

    Raises:
        GraspBenchError: for a trial that ended before there was an image, a kind that cannot be
            written, or a file that cannot be written.
    """
    rate = check_kind(path)
    frames = _frames(replay, rate, size, opengl)
    try:
        if path.suffix.lower() in (".gif", ".webp"):
            return _write_pillow(frames, path, rate)
        return _write_ffmpeg(frames, path, rate, size)
    except OSError as error:
        raise GraspBenchError(f"{path} cannot be written ({error}).") from error


def _frames(replay: Replay, rate: float, size: tuple[int, int], opengl: bool) -> Iterator[Rgb]:
    """Yield one try after the other; the end of each is shown for a while."""
    for take in replay.seen():
        yield from _try(take, replay.scenario, rate, size, opengl)


def _try(take: Take, scenario: Scenario, rate: float, size: tuple[int, int], opengl: bool) -> Iterator[Rgb]:
    done, record = take.done, take.done.record
    assert done.world is not None
    shown = take.pictures(close=True)
    insets = {name: shown[name] for name in ("seen", "proposed")}
    caption = f"{record.object}, {take.name}"
    *before, end = take.moments
    due = take.start
    with Filmer(done.world.model, scenario, size, opengl=opengl) as filmer:
        for m in before:
            if m.time >= due - 1e-9:
                due += 1 / rate
                yield _compose(filmer.shoot(m.qpos), insets, f"{caption}   {m.time - take.start:.1f} s")
        text = f"{caption}   {end.time - take.start:.1f} s   {record.outcome}"
        last = _compose(filmer.shoot(end.qpos), insets, text)
    for _ in range(1 + round(rate * LAST)):
        yield last


def _compose(frame: Rgb, insets: dict[str, Rgb], caption: str) -> Rgb:
    """Return the frame with insets at its left edge and a caption at its foot."""
    picture = Image.fromarray(frame)
    draw = ImageDraw.Draw(picture)
    edge = round(INSET * picture.height)
    for i, (name, inset) in enumerate(insets.items()):
        left, top = 8, 8 + i * (edge + 8)
        draw.rectangle((left - 2, top - 2, left + edge + 1, top + edge + 1), fill="white")
        picture.paste(Image.fromarray(inset).resize((edge, edge)), (left, top))
        _label(draw, (left + 3, top + 3), name)
    _label(draw, (8, picture.height - 28), caption)
    return np.asarray(picture)


def _label(draw: ImageDraw.ImageDraw, at: tuple[int, int], text: str) -> None:
    font = ImageFont.load_default(LETTERS)
    draw.rectangle(tuple(np.add(draw.textbbox(at, text, font=font), (-3, -3, 3, 3))), fill="black")
    draw.text(at, text, fill="white", font=font)


def _write_pillow(frames: Iterator[Rgb], path: Path, rate: float) -> int:
    """Write all pictures at once, held in memory until then, and return their number."""
    first, *others = (Image.fromarray(f) for f in frames)
    if path.suffix.lower() == ".gif":
        first, *others = (i.quantize(64) for i in (first, *others))
    first.save(path, save_all=True, append_images=others, duration=round(1000 / rate), loop=0, quality=55)
    return 1 + len(others)


def _write_ffmpeg(frames: Iterator[Rgb], path: Path, rate: float, size: tuple[int, int]) -> int:
    """Write each picture as it is drawn, and return their number."""
    import imageio_ffmpeg

    first = next(frames)  # raises where there is nothing to show, before a file is begun
    writer = imageio_ffmpeg.write_frames(str(path), size, fps=rate, macro_block_size=2)
    writer.send(None)
    count = 0
    try:
        for frame in chain([first], frames):
            writer.send(np.ascontiguousarray(frame))
            count += 1
    finally:
        writer.close()
    return count
