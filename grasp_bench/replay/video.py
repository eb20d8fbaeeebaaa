"""A replay as a film: the scene from beside, with what was seen and proposed set into it.

GIF and WebP are written by Pillow; everything else, MP4 above all, by ffmpeg, which comes with
the optional ``imageio-ffmpeg``.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from grasp_bench.errors import GraspBenchError
from grasp_bench.media.film import Filmer
from grasp_bench.media.pictures import crop_for, proposed, seen
from grasp_bench.media.recording import moment
from grasp_bench.replay.rebuild import Replay

Rgb = NDArray[np.uint8]
RATES = {".mp4": 25.0, ".webm": 25.0, ".mkv": 25.0, ".mov": 25.0, ".gif": 12.5, ".webp": 12.5}
"""Frames a second by kind of file; films run in real time."""
INSET = 0.27
"""Edge of an inset as a share of the film's height."""


def check_kind(path: Path) -> float:
    """Frames a second of a film's kind.

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
            raise GraspBenchError(f"{kind[1:]} films need ffmpeg: pip install 'grasp-bench[video]'; .gif and "
                                  ".webp need nothing.") from error
    return RATES[kind]


def write_film(replay: Replay, path: Path, size: tuple[int, int] = (640, 480), opengl: bool = False) -> int:
    """Write the replay as a film; its last picture stays a second.

    Args:
        replay: of a trial that was seen at least.
        path: file to write; its ending says which kind.
        size: width and height in pixels, even numbers.
        opengl: draw with OpenGL; see :class:`~grasp_bench.media.film.Filmer`.

    Returns:
        The number of pictures.

    Raises:
        GraspBenchError: for a trial that ended before there was an image, a kind that cannot be
            written, or a file that cannot be written.
    """
    rate = check_kind(path)
    frames = list(_frames(replay, rate, size, opengl))
    frames += [frames[-1]] * round(rate)
    try:
        if path.suffix.lower() in (".gif", ".webp"):
            _write_pillow(frames, path, rate)
        else:
            _write_ffmpeg(frames, path, rate)
    except OSError as error:
        raise GraspBenchError(f"{path} cannot be written ({error}).") from error
    return len(frames)


def _frames(replay: Replay, rate: float, size: tuple[int, int], opengl: bool) -> Iterator[Rgb]:
    done = replay.done
    if done.world is None or done.image is None:
        raise GraspBenchError(f"Trial {done.record.trial} ended before there was an image "
                              f"({done.record.outcome}); there is nothing to show.")
    record = done.record
    crop = crop_for(done.image, [] if record.grasp is None else [record.grasp])
    maps = getattr(replay.predictor, "last_maps", None)
    origin = getattr(replay.predictor, "crop_origin", (0, 0))
    insets = {"seen": seen(done.image, crop, record.grasp),
              "proposed": proposed(done.image, crop, done.grasps, record.grasp, maps, origin)}
    moments = replay.recording.moments
    start = moments[0].time if moments else 0.0
    due = start
    caption = f"{record.object}, trial {record.trial}"
    with Filmer(done.world.model, replay.scenario, size, opengl=opengl) as filmer:
        for m in moments:
            if m.time >= due - 1e-9:
                due += 1 / rate
                yield _compose(filmer.shoot(m.qpos), insets, f"{caption}   {m.time - start:.1f} s")
        end = moment(done.world)
        text = f"{caption}   {end.time - start:.1f} s   {record.outcome}"
        yield _compose(filmer.shoot(end.qpos), insets, text)


def _compose(frame: Rgb, insets: dict[str, Rgb], caption: str) -> Rgb:
    """The frame with insets at its left edge and a caption at its foot."""
    picture = Image.fromarray(frame)
    draw = ImageDraw.Draw(picture)
    edge = round(INSET * picture.height)
    for i, (name, inset) in enumerate(insets.items()):
        left, top = 8, 8 + i * (edge + 8)
        draw.rectangle((left - 2, top - 2, left + edge + 1, top + edge + 1), fill="white")
        picture.paste(Image.fromarray(inset).resize((edge, edge)), (left, top))
        _label(draw, (left + 3, top + 3), name)
    _label(draw, (8, picture.height - 20), caption)
    return np.asarray(picture)


def _label(draw: ImageDraw.ImageDraw, at: tuple[int, int], text: str) -> None:
    draw.rectangle(tuple(np.add(draw.textbbox(at, text), (-2, -2, 2, 2))), fill="black")
    draw.text(at, text, fill="white")


def _write_pillow(frames: list[Rgb], path: Path, rate: float) -> None:
    first, *others = (Image.fromarray(f) for f in frames)
    if path.suffix.lower() == ".gif":
        first, *others = (i.quantize(64) for i in (first, *others))
    first.save(path, save_all=True, append_images=others, duration=round(1000 / rate), loop=0, quality=55)


def _write_ffmpeg(frames: list[Rgb], path: Path, rate: float) -> None:
    import imageio_ffmpeg

    height, width = frames[0].shape[:2]
    writer = imageio_ffmpeg.write_frames(str(path), (width, height), fps=rate, macro_block_size=2)
    writer.send(None)
    try:
        for frame in frames:
            writer.send(np.ascontiguousarray(frame))
    finally:
        writer.close()
