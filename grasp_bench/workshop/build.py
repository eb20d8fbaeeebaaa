"""Turns object models in code into shipped files: ``grasp-bench objects build``.

Two stages an object, each skipped when its inputs have not changed: *shape* (mass
properties, coloured visual mesh, CoACD hulls) and *rest* (resting poses and reference
grasps, tried in physics, and the difficulty of the grid's). A killed build goes on where it stopped.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, as_completed
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from pebble import ProcessPool
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from grasp_bench.objects.catalog import APART, FILES, GRASPABLE, VisualPart
from grasp_bench.objects.difficulty import DIFFICULTY
from grasp_bench.system.integrity import MANIFEST, sha256, write_whole
from grasp_bench.workshop.decompose import BOUNDS, compare, decompose
from grasp_bench.workshop.materials import MATERIALS
from grasp_bench.workshop.model import REGISTRY, ObjectSpec, Part
from grasp_bench.workshop.shapes import Mesh, union

MILLIMETRE = 1e-3
SHAPE_VERSION = 1
"""Raise this when the shape stage changes, so that all objects are built again."""
LISTED = (
    "name category family mass material friction source inertia extents faces hulls decomposition".split()
)
"""Entries of ``object.json`` that the manifest repeats."""


def _metres(parts: list[Part]) -> list[Part]:
    return [
        Part(
            Mesh(np.asarray(p.mesh.vertices) * MILLIMETRE, p.mesh.faces, process=False),
            p.color,
            p.material,
            p.threshold,
        )
        for p in parts
    ]


def mass_properties(parts: list[Part], mass: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the centre of mass (3,) [m] and inertia (3, 3) about it [kg m²] of parts (metres) whose material
    densities are scaled together so that they weigh ``mass`` [kg]."""
    weights = np.array([MATERIALS[p.material].density * p.mesh.volume for p in parts])
    shares = mass * weights / weights.sum()
    centres = np.array([p.mesh.center_mass for p in parts])
    centre = shares @ centres / mass
    inertia = np.zeros((3, 3))
    for part, share, own in zip(parts, shares, centres, strict=True):
        arm = own - centre
        inertia += part.mesh.moment_inertia * share / part.mesh.volume
        inertia += share * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return centre, inertia


def fingerprint(parts: list[Part], spec: ObjectSpec) -> str:
    """Digest all that the shape stage depends on."""
    digest = hashlib.sha256(f"{SHAPE_VERSION}|{spec.mass}|{spec.material}".encode())
    for part in parts:
        digest.update(np.round(np.asarray(part.mesh.vertices), 4).tobytes())
        digest.update(np.asarray(part.mesh.faces, np.int32).tobytes())
        digest.update(f"{part.color}|{part.material}|{part.threshold}".encode())
    return digest.hexdigest()


def build_shape(spec: ObjectSpec, folder: Path) -> bool:
    """Write ``visual.glb``, ``collision.glb`` and ``shape.json``; False when up to date.

    Raises:
        ValueError: for a part that is not watertight, too many faces or hulls, or convex pieces
            that stray beyond :data:`~grasp_bench.workshop.decompose.BOUNDS`.
    """
    raw = spec.build()
    mark = fingerprint(raw, spec)
    target = folder / spec.name
    done = target / "shape.json"
    if done.is_file() and json.loads(done.read_text()).get("fingerprint") == mark:
        return False
    faces = sum(len(p.mesh.faces) for p in raw)
    open_parts = [i for i, p in enumerate(raw) if not p.mesh.is_watertight or p.mesh.volume <= 0]
    if open_parts or faces > 6000:
        raise ValueError(f"{spec.name}: parts {open_parts} are not closed, or {faces} faces > 6000")
    hulls = [Mesh(np.asarray(h.vertices) * MILLIMETRE, h.faces, process=False) for h in decompose(raw)]
    parts = _metres(raw)
    solid = union(*(p.mesh for p in parts))
    error = compare(solid, hulls)
    beyond = [n for n, (low, high) in BOUNDS.items() if not low <= getattr(error, n) <= high]
    if beyond:
        raise ValueError(f"{spec.name}: the convex pieces stray too far from the shape: {error}")
    centre, inertia = mass_properties(parts, spec.mass)
    target.mkdir(parents=True, exist_ok=True)
    write_visual(_visual_parts(parts, centre), target / "visual.glb")
    write_hulls([Mesh(h.vertices - centre, h.faces, process=False) for h in hulls], target / "collision.glb")
    details = {
        "name": spec.name,
        "category": spec.category,
        "family": spec.family,
        "mass": spec.mass,
        "material": spec.material,
        "friction": MATERIALS[spec.material].friction,
        "source": spec.source,
        "inertia": rounded(inertia, 12),
        "extents": rounded(solid.extents, 5),
        "volume": round(float(solid.volume), 9),
        "faces": faces,
        "hulls": len(hulls),
        "decomposition": {k: round(v, 5) for k, v in asdict(error).items()},
        "fingerprint": mark,
    }
    done.write_text(json.dumps(details, indent=1))
    return True


def rounded(values: Any, digits: int) -> Any:
    """Return nested lists of rounded numbers, for JSON."""
    return np.round(np.asarray(values, float), digits).tolist()


def _visual_parts(parts: list[Part], centre: np.ndarray) -> list[VisualPart]:
    return [
        VisualPart(
            np.asarray(p.mesh.vertices) - centre,
            np.asarray(p.mesh.faces, np.int32),
            tuple(int(p.color[i : i + 2], 16) / 255 for i in (1, 3, 5)),  # type: ignore[arg-type]
            MATERIALS[p.material].roughness,
            p.material,
        )
        for p in parts
    ]


def write_visual(parts: list[VisualPart], path: Path) -> None:
    """Write coloured parts, about the centre of mass [m], as ``visual.glb``."""
    meshes = []
    for part in parts:
        mesh = Mesh(part.vertices, part.faces, process=False)
        rgba = [*(round(255 * c) for c in part.rgb), 255]
        mesh.visual = TextureVisuals(
            material=PBRMaterial(
                name=part.material, baseColorFactor=rgba, metallicFactor=0.0, roughnessFactor=part.roughness
            )
        )
        meshes.append(mesh)
    _write_scene(meshes, "part", path)


def write_hulls(hulls: list[Mesh], path: Path) -> None:
    """Write convex pieces, about the centre of mass [m], as ``collision.glb``."""
    _write_scene(hulls, "hull", path)


def _write_scene(meshes: list[Mesh], stem: str, path: Path) -> None:
    scene = trimesh.Scene()
    for i, mesh in enumerate(meshes):
        scene.add_geometry(mesh, geom_name=f"{stem}{i:02d}", node_name=f"{stem}{i:02d}")
    path.write_bytes(scene.export(file_type="glb"))  # type: ignore[arg-type]


@cache
def known() -> dict[str, ObjectSpec]:
    """Return what describes each object that can be built, by its name."""
    import grasp_bench.workshop.household  # noqa: F401  (registers the objects)
    from grasp_bench.workshop.grid import specs

    return REGISTRY | {spec.name: spec for spec in specs()}


def build_all(
    folder: Path, names: Iterable[str], workers: int = 2, stage: str = "all"
) -> Iterator[tuple[str, str]]:
    """Build objects on ``workers`` processes; yields (name, outcome) as each ends.

    Args:
        folder: where the objects' folders go, normally ``assets/objects``.
        names: those of the objects to build, of :func:`known`.
        stage: ``shape``, ``rest`` or ``all``.
    """
    chosen = list(names)
    with ProcessPool(max_workers=workers) as pool:
        futures: dict[Future[str], str] = {
            pool.submit(_build_one, 1800, name, folder, stage): name for name in chosen
        }
        for future in as_completed(futures):
            name = futures[future]
            try:
                yield name, future.result()
            except Exception as error:  # one bad object must not stop the others
                yield name, f"failed: {error}"


def _build_one(name: str, folder: Path, stage: str) -> str:
    spec = known()[name]
    graded = spec.family in APART
    built = build_shape(spec, folder) if stage in ("shape", "all") else False
    if stage in ("rest", "all"):
        from grasp_bench.workshop.difficulty import build_difficulty
        from grasp_bench.workshop.poses import build_rest

        built |= build_rest(folder / name, seen=graded)
        built |= graded and build_difficulty(folder / name)
    return "built" if built else "up to date"


def write_manifest(folder: Path) -> int:
    """Write the manifest of all complete objects in ``folder``, and return how many there are."""
    return Listing(folder).write()


class Listing:
    """The manifest of a folder that objects are being added to; files are read once.

    Args:
        folder: where the objects' folders are.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._known: dict[Path, tuple[int, dict[str, Any]]] = {}
        self._listed: list[dict[str, Any]] = []

    @property
    def graspable(self) -> int:
        """How many of the objects that were written last have a grasp that fits the gripper."""
        return sum(o.get(GRASPABLE, True) for o in self._listed)

    def write(self) -> int:
        """Write the manifest of all complete objects, and return how many there are."""
        self._listed = []
        for path in sorted(self.folder.glob("*/object.json")):
            changed = path.stat().st_mtime_ns
            if self._known.get(path, (0, {}))[0] != changed:
                entry = _manifest_entry(path)
                if entry is None:
                    continue
                self._known[path] = changed, entry
            self._listed.append(self._known[path][1])
        lines = ",\n".join("  " + json.dumps(o) for o in self._listed)
        text = '{"version": 1, "objects": [\n' + lines + "\n]}\n"
        write_whole(self.folder / MANIFEST, text.encode())
        return len(self._listed)


def _manifest_entry(path: Path) -> dict[str, Any] | None:
    """Return what the manifest says of an object; None where a kill left it in pieces."""
    try:
        details = json.loads(path.read_text())
        files = {f: sha256(path.parent / f) for f in FILES}
        entry = {k: details[k] for k in LISTED} | {"files": files}
        if DIFFICULTY in details:
            entry[DIFFICULTY] = details[DIFFICULTY]
    except (OSError, ValueError, KeyError, TypeError):
        return None
    if not any(p["grasps"] for p in details.get("poses", ())):
        entry[GRASPABLE] = False
    return entry
