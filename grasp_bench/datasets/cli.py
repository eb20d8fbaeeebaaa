"""``grasp-bench data``: generates synthetic training scenes and shows samples of them."""

from __future__ import annotations

import json
import multiprocessing
import os
import platform
from collections.abc import Callable
from concurrent.futures import Future, as_completed
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray

from grasp_bench.errors import GraspBenchError
from grasp_bench.graphics import without_gl

if TYPE_CHECKING:
    from grasp_bench.datasets.synthetic import SynthConfig

FORMAT = 1
"""Raise when the same seed would give other scenes."""
TIMEOUT = 60
"""Seconds after which a scene is given up."""
VALIDATION = 20
"""Every so manieth scene is for validation."""
SAVE_EVERY = 250
"""Scenes after which the index is written anew, so that training may begin."""
Entry = dict[str, Any]


@dataclass(frozen=True)
class Produced:
    """What :func:`generate` made: index entries in order, and what failed, by scene number."""

    entries: list[Entry]
    failed: dict[int, str]


def generate(out: Path, scenes: int, seed: int, config: SynthConfig, workers: int = 2,
             report: Callable[[Entry | None], None] = lambda entry: None) -> Produced:
    """Generate scenes 0 … ``scenes`` − 1 into ``out``, keeping those already there.

    Args:
        out: folder of the data set.
        scenes: how many it shall have.
        seed: of the set.
        config: parameters; must be those of the scenes already there.
        workers: processes.
        report: called with each scene's index entry, or None for one that failed.

    Raises:
        GraspBenchError: when the folder was generated with another seed or parameters.
    """
    from pebble import ProcessPool

    without_gl()
    (out / "scenes").mkdir(parents=True, exist_ok=True)
    _check_config(out, seed, config)
    entries = {i: e for i in range(scenes) if (e := _entry(out, i, seed)) is not None}
    for entry in entries.values():
        report(entry)
    failed: dict[int, str] = {}
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[name] = "1"  # inherited by the workers, which are started afresh
    with ProcessPool(workers, max_tasks=200, context=multiprocessing.get_context("spawn")) as pool:
        futures: dict[Future[Entry], int] = {pool.submit(_produce, TIMEOUT, out, i, seed, config): i
                                             for i in range(scenes) if i not in entries}
        try:
            for future in as_completed(futures):
                index = futures[future]
                try:
                    entries[index] = future.result()
                except Exception as error:  # one bad scene must not stop the others
                    failed[index] = f"{type(error).__name__}: {error}"
                report(entries.get(index))
                if (len(entries) + len(failed)) % SAVE_EVERY == 0:
                    _write_index(out, entries)
        finally:  # when interrupted, do not wait for all that was submitted
            pool.stop()
            _write_index(out, entries)
    return Produced([entries[i] for i in sorted(entries)], failed)


def _check_config(out: Path, seed: int, config: SynthConfig) -> None:
    import mujoco

    wanted = {"format": FORMAT, "seed": seed, "config": asdict(config)}
    path = out / "config.json"
    if path.is_file():
        found = {k: v for k, v in json.loads(path.read_text()).items() if k in wanted}
        if found != wanted:
            raise GraspBenchError(f"{out} holds scenes made with {found}, not with {wanted}; "
                                  "choose another folder.")
    versions = {"python": platform.python_version(), "numpy": np.__version__, "mujoco": mujoco.__version__}
    _write(path, (json.dumps(wanted | {"versions": versions}, indent=1) + "\n").encode())


def _file(index: int) -> str:
    return f"scenes/{index:06d}.npz"


def _entry(out: Path, index: int, seed: int) -> Entry | None:
    """Index entry of a stored scene, None when it is missing or does not load."""
    import zipfile

    try:
        with np.load(out / _file(index), allow_pickle=False) as file:
            tried, objects = file["tried"], int(file["objects"])
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None
    return {"scene": f"{index:06d}", "file": _file(index), "split": "train" if index % VALIDATION else "val",
            "seed": seed, "objects": objects, "tried": len(tried), "held": int(tried[:, 5].sum())}


def _produce(out: Path, index: int, seed: int, config: SynthConfig) -> Entry:
    """Make and store one scene (in a worker)."""
    import io

    import cv2

    from grasp_bench.datasets.synthetic import make_scene

    cv2.setNumThreads(1)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **make_scene(seed, index, config))  # type: ignore[arg-type]
    _write(out / _file(index), buffer.getvalue())
    entry = _entry(out, index, seed)
    assert entry is not None
    return entry


def _write_index(out: Path, entries: dict[int, Entry]) -> None:
    _write(out / "index.jsonl", "".join(json.dumps(entries[i]) + "\n" for i in sorted(entries)).encode())


def _write(path: Path, content: bytes) -> None:
    """Write a file whole or not at all."""
    fresh = path.with_name(f".{path.name}.{os.getpid()}")
    fresh.write_bytes(content)
    fresh.replace(path)


def calibration(out: Path, entries: list[Entry], bins: int = 10) -> list[tuple[float, int, float]]:
    """How well analysis predicts physics: (upper edge of quality, grasps tried, share held) of each bin."""
    tried = [np.load(out / e["file"])["tried"] for e in entries]
    quality, held = np.vstack([np.zeros((0, 6)), *tried])[:, 4:].T
    which = np.clip((quality * bins).astype(int), 0, bins - 1)
    return [((i + 1) / bins, int((which == i).sum()), float(held[which == i].mean()))
            for i in range(bins) if (which == i).any()]


# ---------------------------------------------------------------- commands

def synth_command(
    scenes: Annotated[int, typer.Option(help="Scenes that the folder shall hold.", min=1)] = 1000,
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder of the data set.")] = Path("data/synth"),
    seed: Annotated[int, typer.Option(help="Seed; the same seed gives the same scenes.", min=0)] = 1,
    workers: Annotated[int, typer.Option(help="Processes.", min=1)] = 2,
    tries: Annotated[int, typer.Option(help="Grasps tried in physics per scene.", min=0)] = 8,
) -> None:
    """Generate synthetic training scenes of random shapes.

    The same command goes on where a stopped one ended; scenes already there are kept.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    from grasp_bench.datasets.synthetic import SynthConfig

    console = Console()
    columns = (TextColumn("scenes"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(),
               TextColumn("{task.fields[state]}"))
    tally = {"made": 0, "tries": 0}
    config = SynthConfig(tries=tries)
    with Progress(*columns, console=console) as progress:
        task = progress.add_task("", total=scenes, state="")

        def report(entry: Entry | None) -> None:
            tally["made"] += entry is not None
            tally["tries"] += entry["tried"] if entry else 0
            seconds = max(progress.tasks[task].elapsed or 0, 1e-3)
            progress.update(task, advance=1, state=f"{3600 * tally['made'] / seconds:.0f} scenes/h, "
                                                   f"{tally['tries'] / seconds:.1f} tries/s")
            if not console.is_terminal and tally["made"] % 50 == 0:
                console.print(f"{tally['made']} of {scenes}: {progress.tasks[task].fields['state']}")

        made = generate(out, scenes, seed, config, workers, report)
    for index, reason in made.failed.items():
        console.print(f"[red]scene {index} failed: {reason}[/red]")
    console.print(f"{len(made.entries)} scenes in {out}. Grasps that held, by quality of the analysis:")
    for edge, count, share in calibration(out, made.entries):
        console.print(f"  up to {edge:.1f}: {100 * share:5.1f} % of {count}")


def show_command(
    folder: Annotated[Path, typer.Argument(help="Folder of a data set.")],
    count: Annotated[int, typer.Option(help="Scenes to show.", min=1)] = 8,
    out: Annotated[Path, typer.Option("--out", "-o", help="PNG to write.")] = Path("samples.png"),
) -> None:
    """Draw samples of a data set: colour with good grasps, depth, quality and angle."""
    import cv2

    from grasp_bench.training.dataset import load_scene

    lines = [json.loads(line) for line in (folder / "index.jsonl").read_text().splitlines()]
    chosen = [lines[i] for i in np.unique(np.linspace(0, len(lines) - 1, count).astype(int))]
    strips = [_strip(load_scene(folder / e["file"]), e["scene"]) for e in chosen]
    if len(strips) > 1:  # two scenes a row
        strips = [np.hstack(pair) for pair in zip(strips[::2], strips[1::2], strict=False)]
    cv2.imwrite(str(out), np.vstack(strips)[..., ::-1])
    typer.echo(f"{out}: scenes {', '.join(e['scene'] for e in chosen)}")


def _strip(scene: Any, title: str) -> NDArray[np.uint8]:
    """Four pictures (S, 4·S, 3) of one scene side by side."""
    import cv2

    photo = scene.rgb.copy()
    for grasp in scene.truths():
        corners = np.round((grasp.rectangle(height=12) - 0.5) * 8).astype(np.int32)
        cv2.polylines(photo, [corners], True, (40, 220, 60), 1, cv2.LINE_AA, 3)
        for a, b in ((1, 2), (3, 0)):  # the fingers
            cv2.line(photo, corners[a].tolist(), corners[b].tolist(), (230, 30, 40), 2, cv2.LINE_AA, 3)
    cv2.putText(photo, title, (4, 14), cv2.FONT_HERSHEY_SIMPLEX, 0.45, (128, 0, 128), 1, cv2.LINE_AA)
    depth = scene.depth.astype(float)
    near, far = np.percentile(depth[depth > 0], [0.5, 99.5])
    shade = 230 - 200 * np.clip((depth - near) / max(far - near, 1), 0, 1)
    grey = np.where(depth > 0, shade, 0).astype(np.uint8)
    heat = cv2.applyColorMap(scene.quality, cv2.COLORMAP_INFERNO)[..., ::-1]
    hue = np.mod(scene.angle.astype(float) * 180 / np.pi, 180).astype(np.uint8)
    on = np.where(scene.quality > 12, 255, 0).astype(np.uint8)
    angle = cv2.cvtColor(np.dstack([hue, on, np.maximum(on, 40)]), cv2.COLOR_HSV2RGB)
    return np.asarray(np.hstack([photo, np.dstack([grey] * 3), heat, angle]), np.uint8)


if __name__ == "__main__":
    app = typer.Typer()
    app.command("synth")(synth_command)
    app.command("show")(show_command)
    app()
