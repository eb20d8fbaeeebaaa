"""What is measured on an imported object once it can rest: its picture, its cavity, its footing."""

from __future__ import annotations

import heapq
import json
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from grasp_bench.objects.catalog import ObjectModel, load_details
from grasp_bench.planning.heightfield import CELL
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.builder import OBJECT, compile_mjcf, compose
from grasp_bench.scene.rendering import SHOWN_GROUPS
from grasp_bench.system.arrays import Floats
from grasp_bench.workshop.pictures import traced_picture
from grasp_bench.workshop.poses import measure_heights

HULL_GROUPS = np.array([0, 0, 0, 1, 0, 0], dtype=np.uint8)
PICTURE = "picture.jpg"


def finish(folder: Path) -> bool:
    """Add the picture and the measurements to an object whose rest stage is done; False when there."""
    path = folder / "object.json"
    details = json.loads(path.read_text())
    if "measured" in details and (folder / PICTURE).is_file():
        return False
    model = load_details(folder, details)
    details["measured"] = measure(model)
    traced_picture(model).save(folder / PICTURE, quality=88)
    path.write_text(json.dumps(details, indent=1))
    return True


def measure(model: ObjectModel) -> dict[str, Any]:
    """Measure footing and cavity of an object.

    Returns:
        ``footing``: in millimetres, the largest gap between table and scan in any resting pose,
        the deepest point of the scan below the table, and by how much the hulls' extents differ
        from the scan's along each axis. ``cavity``: what the scan and its hulls hold, standing as
        modelled [ml].
    """
    shown = np.vstack([p.vertices for p in model.visual])
    solid = np.vstack(model.hulls)
    lows = [1000 * (pose.height + float((shown @ pose.rotation[2]).min())) for pose in model.poses]
    scan, hulls = cavities(model)
    extents = 1000 * (np.ptp(solid, axis=0) - np.ptp(shown, axis=0))
    return {
        "footing": {
            "gap": round(max(lows, default=0.0), 2),
            "sunk": round(-min(lows, default=0.0), 2),
            "extents": np.round(extents, 2).tolist(),
        },
        "cavity": {"scan": round(1e6 * scan, 1), "hulls": round(1e6 * hulls, 1)},
    }


def cavities(model: ObjectModel) -> tuple[float, float]:
    """Return the volumes [m³] of water that the shown mesh, and the hulls, hold standing as modelled."""
    scenario = Scenario(name="measure")
    compiled = compile_mjcf(compose(scenario, model, robot=None))
    data = mujoco.MjData(compiled)
    x, y = scenario.table.center
    low = min(float(h[:, 2].min()) for h in model.hulls)
    at = compiled.joint(OBJECT).qposadr[0]
    data.qpos[at : at + 7] = (x, y, -low, 1, 0, 0, 0)
    mujoco.mj_forward(compiled, data)
    reach = max(0.05, float(np.abs(np.vstack(model.hulls)[:, :2]).max()) + 0.01)
    fields = [
        measure_heights(compiled, data, (x, y), (x, y), reach, groups).heights
        for groups in (SHOWN_GROUPS, HULL_GROUPS)
    ]
    first, second = (float((flood(h) - h).sum()) * CELL**2 for h in fields)
    return first, second


def flood(heights: NDArray[np.floating]) -> Floats:
    """Return the level (N, M) at which water over each cell runs off over the border.

    Cells are filled from the border inwards, lowest first (Barnes, Lehman and Mulla 2014,
    *Priority-flood*).
    """
    level = np.full(heights.shape, np.inf)
    rows, columns = heights.shape
    queue: list[tuple[float, int, int]] = []
    for r in range(rows):
        for c in range(columns) if r in (0, rows - 1) else (0, columns - 1):
            level[r, c] = heights[r, c]
            heapq.heappush(queue, (float(heights[r, c]), r, c))
    while queue:
        height, r, c = heapq.heappop(queue)
        for nr, nc in ((r - 1, c), (r + 1, c), (r, c - 1), (r, c + 1)):
            if 0 <= nr < rows and 0 <= nc < columns and level[nr, nc] == np.inf:
                level[nr, nc] = max(height, float(heights[nr, nc]))
                heapq.heappush(queue, (float(level[nr, nc]), nr, nc))
    return level
