"""The trials of a run as a plain Parquet data set, to train on: image, grasp, outcome, margin.

One row a trial on one object. Images are made again from the run's seed, as the trial had them, and stored
as PNG in the layout that Hugging Face's ``datasets`` (and so LeRobot's readers) takes for an image: a
struct of ``bytes`` and ``path``. Depth is a 16-bit PNG in tenths of a millimetre, 0 where nothing was
measured.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from grasp_bench.camera import CameraPose, RgbdImage
from grasp_bench.errors import GraspBenchError, ResultsError
from grasp_bench.objects.catalog import Catalog, folder_of
from grasp_bench.runs.info import RUN
from grasp_bench.runs.jobs import spread
from grasp_bench.runs.record import TrialRecord
from grasp_bench.runs.results import RunResults
from grasp_bench.scenario.seeding import Streams
from grasp_bench.trials.attempt import take_first_picture
from grasp_bench.trials.clock import Clock
from grasp_bench.trials.trial import own_table
from grasp_bench.trials.views import take_views
from grasp_bench.trials.workcell import Workcell

DEPTH_UNIT = 1e-4
"""Metres that one step of the stored depth is."""
GROUP = 32
"""Rows that are written at a time."""


def export_trials(
    folder: Path, out: Path, objects: Path | None = None, progress: Callable[[int], None] | None = None
) -> int:
    """Write a run's trials into a Parquet file, and return how many there are.

    Args:
        folder: the run's folder.
        out: file to write.
        objects: folder of the objects; by default the scenario's.
        progress: called with the number of rows after each.

    Raises:
        GraspBenchError: where pyarrow is missing, or the file cannot be written.
        ResultsError: for a run of clutter, whose pictures depend on what was done before.
    """
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError as error:
        raise GraspBenchError(
            "Parquet needs pyarrow, which is not installed here: `pip install 'grasp-bench[parquet]'`."
        ) from error
    run = RunResults(folder)
    if run.info.cluttered:
        raise ResultsError(f"{folder} is a run of clutter; trials on one object can be exported.")
    schema = _schema(pa)
    rows, count = _rows(run, folder, objects), 0
    part = out.with_name(out.name + ".part")
    try:
        with pq.ParquetWriter(part, schema, compression="zstd") as writer:
            while group := list(islice(rows, GROUP)):
                writer.write_table(pa.Table.from_pylist(group, schema))
                count += len(group)
                if progress is not None:
                    progress(count)
        part.replace(out)
    except OSError as error:
        raise GraspBenchError(f"{out} cannot be written ({error.strerror or error}).") from error
    finally:
        part.unlink(missing_ok=True)
    return count


def _schema(pa: Any) -> Any:
    image = pa.struct([("bytes", pa.binary()), ("path", pa.string())])
    number, numbers = pa.float64(), pa.list_(pa.float64())
    fields = {
        "trial": pa.int64(), "object": pa.string(), "category": pa.string(), "seed": pa.int64(),
        "rgb": image, "depth": image, "intrinsics": numbers, "camera_position": numbers,
        "camera_rotation": numbers, "grasp_x": number, "grasp_y": number, "grasp_angle": number,
        "grasp_width": number, "quality": number, "rank": pa.int64(), "tcp_position": numbers,
        "tcp_rotation": numbers, "tcp_position_camera": numbers, "tcp_rotation_camera": numbers,
        "opening": number, "outcome": pa.string(), "success": pa.bool_(), "detail": pa.string(),
        "margin_force": number, "margin_torque": number,
    }  # fmt: skip
    features = {
        name: {"_type": "Image"} if name in ("rgb", "depth") else _feature(kind)
        for name, kind in ((n, str(k)) for n, k in fields.items())
    }
    told = {"huggingface": json.dumps({"info": {"features": features}}), "depth_unit_m": str(DEPTH_UNIT)}
    return pa.schema(list(fields.items()), metadata=told)


def _feature(kind: str) -> dict[str, Any]:
    plain = {"double": "float64"}
    if kind.startswith("list"):
        return {"_type": "Sequence", "feature": {"_type": "Value", "dtype": "float64"}}
    return {"_type": "Value", "dtype": plain.get(kind, kind)}


def _rows(run: RunResults, folder: Path, objects: Path | None) -> Iterator[dict[str, Any]]:
    scenario = run.info.parsed(str(folder / RUN))
    catalog = Catalog(objects or folder_of(scenario.objects.folder))
    cell = Workcell(scenario, run.info.renderer)
    jobs = spread(run.info.tried, run.info.trials)
    for record in run.records:
        job = jobs.job(record.trial)
        model = catalog.load(job.object)
        streams = Streams(run.info.seed, model.name, job.attempt)
        table, clock = own_table(cell, model, streams), Clock()
        world = table.build()
        table.settle(world)
        first = partial(take_first_picture, cell, table, world, streams, clock)
        view = take_views(cell, world, streams, clock, first)[0]
        yield _row(record, view.image, view.believed)


def _row(record: TrialRecord, image: RgbdImage, camera: CameraPose) -> dict[str, Any]:
    k = image.intrinsics
    row: dict[str, Any] = {
        "trial": record.trial,
        "object": record.object,
        "category": record.category,
        "seed": record.seed,
        "rgb": _png(image.rgb[..., ::-1], f"{record.trial:06d}_rgb.png"),
        "depth": _png(np.rint(image.depth / DEPTH_UNIT).clip(0, 65535).astype(np.uint16), "depth.png"),
        "intrinsics": [k.fx, k.fy, k.cx, k.cy],
        "camera_position": camera.position.tolist(),
        "camera_rotation": camera.rotation.ravel().tolist(),
        "rank": record.rank,
        "outcome": str(record.outcome),
        "success": record.success,
        "detail": record.detail,
    }
    if grasp := record.grasp:
        row |= {f"grasp_{name}": getattr(grasp, name) for name in ("x", "y", "angle", "width")}
        row["quality"] = grasp.quality
    if pose := record.pose:
        seen = pose.moved(camera.rotation.T, -camera.rotation.T @ camera.position)
        row |= {
            "tcp_position": pose.position.tolist(),
            "tcp_rotation": pose.rotation.ravel().tolist(),
            "tcp_position_camera": seen.position.tolist(),
            "tcp_rotation_camera": seen.rotation.ravel().tolist(),
            "opening": pose.opening,
        }
    if margin := record.margin:
        row |= {"margin_force": margin.force, "margin_torque": margin.torque}
    return row


def _png(image: NDArray[Any], name: str) -> dict[str, Any]:
    ok, data = cv2.imencode(".png", image)
    assert ok
    return {"bytes": data.tobytes(), "path": name}
