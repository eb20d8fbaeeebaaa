"""``grasp-bench objects import``: from somebody's mesh to an object that can be benchmarked.

The stages are those of the shipped objects (:mod:`grasp_bench.workshop.build`): *shape*, read
from a file instead of modelled, and *rest*, the same code. A killed import goes on where it stopped.
"""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Future, TimeoutError, as_completed
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from pebble import ProcessExpired, ProcessPool

from grasp_bench.errors import GraspBenchError
from grasp_bench.objects.catalog import VisualPart
from grasp_bench.system.arrays import Floats
from grasp_bench.system.integrity import sha256, write_whole
from grasp_bench.system.locking import Lock
from grasp_bench.workshop.build import rounded, write_hulls, write_visual
from grasp_bench.workshop.importing import paint as painting
from grasp_bench.workshop.importing.body import Body, Options
from grasp_bench.workshop.importing.convex import decompose_whole
from grasp_bench.workshop.importing.folder import ROBOT_SUFFIXES, Folder, RefusedError
from grasp_bench.workshop.importing.masses import DENSITY, choose_mass, spread_mass
from grasp_bench.workshop.importing.plausible import check_density, check_inertia
from grasp_bench.workshop.importing.readers import Scan, read_mesh
from grasp_bench.workshop.importing.repair import mend
from grasp_bench.workshop.importing.robot_files import import_robot_file
from grasp_bench.workshop.importing.solid import solidify
from grasp_bench.workshop.importing.units import (
    LONGEST,
    REMEDY,
    UNITS,
    check_length,
    check_size,
    choose_unit,
    figure,
)
from grasp_bench.workshop.shapes import Mesh, hull

IMPORT_VERSION = 3
"""Raise this when imports would come out differently: all are made again then."""
FAMILY = "imported"
UPRIGHT = {
    "z": np.eye(3),
    "y": np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]], float),
    "x": np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]], float),
}
"""What turns row vectors of a file so that its upward axis becomes z."""
STAGING = ".importing"
"""Folder in the target where objects are until they are whole."""


@dataclass(frozen=True)
class Job:
    """One object to import: its name, file, folder that may be read, options, and the file as the user named
    it."""

    name: str
    path: Path
    root: Path
    options: Options
    place: str = ""


@dataclass(frozen=True)
class Report:
    """What came of one object.

    Attributes:
        status: ``imported``, ``up to date`` or ``failed``.
        why: the reason of a failure.
        details: the content of ``object.json``; empty after a failure.
        replaced: the other file that the object of this name was imported from before; empty if none.
    """

    name: str
    status: str
    why: str = ""
    details: dict[str, Any] = field(default_factory=dict)
    replaced: str = ""

    @property
    def graspable(self) -> bool:
        """Whether some grasp fits the gripper in some resting pose."""
        return any(p["grasps"] for p in self.details.get("poses", ()))


def import_body(folder: Folder, name: str, options: Options) -> Body:
    """Read, mend and decompose a mesh file.

    Raises:
        RefusedError: with the reason, for what cannot be imported.
    """
    scan = read_mesh(folder, name)
    notes = list(scan.notes)
    points = scan.vertices[np.unique(scan.faces)]
    low, high = np.percentile(points, [0.1, 99.9], axis=0)  # a stray vertex must not decide on the unit
    extents = high - low
    if not extents.max() > 0:
        raise RefusedError("all its vertices are at one place")
    factor, unit, note = _metres(scan, extents, points, options)
    notes += [note] if note else []
    vertices = scan.vertices * factor
    vertices = vertices @ UPRIGHT[scan.up or "z" if options.up == "auto" else options.up]
    mesh = mend(vertices, scan.faces, options.holes)
    check_size(np.ptp(mesh.vertices[np.unique(mesh.faces)], axis=0))
    solid = solidify(mesh)
    hulls, error = decompose_whole(solid)
    parts = painting.bake(mesh.vertices, mesh.faces, mesh.source, scan.paint)
    separate = len(solid.split(only_watertight=False))
    if separate > 1:
        notes.append(f"{separate} separate pieces: taken as one rigid object; import them one by one if not")
    return Body(parts, solid, hulls, error, notes + mesh.notes, facts={"unit": unit})


def _metres(scan: Scan, extents: Floats, points: Floats, options: Options) -> tuple[float, str, str]:
    """Return metres per unit of the file, the unit's name, and a note on where it is from."""
    longest = float(extents.max())
    part = f" (its longest part is {scan.longest!r})" if scan.longest else ""
    if options.scale is not None:
        check_length(longest * options.scale, f"with --scale {options.scale:g}{part}")
        return options.scale, f"{options.scale:g} m", ""
    if options.length is not None:
        factor = options.length / longest
        return factor, f"{factor:.6g} m", f"scaled to a length of {1000 * options.length:.4g} mm"
    if options.units == "auto" and scan.metres is not None:
        if scan.up is not None and not LONGEST[0] <= longest * scan.metres <= LONGEST[1] and scan.metres != 1:
            raise RefusedError(
                f"{figure(1000 * longest * scan.metres)} mm long in the file's own unit{part}; objects of "
                f"{1000 * LONGEST[0]:.0f} to {1000 * LONGEST[1]:.0f} mm are imported: {REMEDY}"
            )
        check_length(longest * scan.metres, f"in the file's unit, {scan.metres:g} m{part}")
        return scan.metres, "m" if scan.metres == 1 else f"{scan.metres:g} m", ""
    unit, note = choose_unit(extents, options.units, options.mass, _hull_volume(points))
    return UNITS[unit], unit, note


def _hull_volume(points: Floats) -> float:
    try:
        return float(hull(Mesh(points, np.zeros((0, 3), int), process=False)).volume)
    except Exception:  # flat: refused later, with its thickness
        return 0.0


@np.errstate(divide="ignore", invalid="ignore")  # trimesh's warnings of shapes that are refused
def import_shape(job: Job, out: Path) -> bool:
    """Write ``visual.glb``, ``collision.glb`` and ``shape.json``; False when up to date.

    Raises:
        RefusedError: with the reason, for what cannot be imported.
    """
    options, target = job.options, out / job.name
    folder = Folder(job.root, job.path.parent)
    done = target / "shape.json"
    if _up_to_date(target, options, folder):
        return False
    if job.path.suffix.lower() in ROBOT_SUFFIXES:
        body = import_robot_file(folder, job.path.name, options)
    else:
        body = import_body(folder, job.path.name, options)
    mass, why = choose_mass(body, options)
    body.notes += [why] if why else []
    if options.density is None:
        longest = float(np.ptp(body.solid.vertices, axis=0).max())
        check_density(mass, float(hull(body.solid).volume), longest, DENSITY * float(body.solid.volume))
    centre, inertia = body.centre, body.inertia
    if centre is None or inertia is None:
        centre, inertia = spread_mass(body.solid, mass, options.inertia)
    elif body.mass:
        inertia = inertia * mass / body.mass
    check_inertia(mass, centre, inertia, body.solid)
    target.mkdir(parents=True, exist_ok=True)
    for file in (done, target / "object.json"):  # a kill from here on must leave nothing that looks whole
        file.unlink(missing_ok=True)
    write_visual(
        [VisualPart(p.vertices - centre, p.faces, p.rgb, p.roughness) for p in body.visual],
        target / "visual.glb",
    )
    write_hulls(
        [Mesh(h.vertices - centre, h.faces, process=False) for h in body.hulls], target / "collision.glb"
    )
    shown = np.vstack([p.vertices for p in body.visual])
    details = {
        "name": job.name,
        "category": options.category or job.name,
        "family": FAMILY,
        "mass": round(mass, 6),
        "material": "unknown",
        "friction": options.friction,
        "source": options.source or f"imported from {job.path.name}",
        "inertia": rounded(inertia, 12),
        "extents": rounded(np.ptp(shown, axis=0), 5),
        "volume": round(float(body.solid.volume), 9),
        "faces": sum(len(p.faces) for p in body.visual),
        "hulls": len(body.hulls),
        "decomposition": {k: round(v, 5) for k, v in asdict(body.error).items()},
        "fingerprint": _mark(options, folder, folder.asked),
        "import": {"files": folder.asked, "place": job.place, "spread": options.inertia, "notes": body.notes}
        | {"meshes": {f: sha256(target / f) for f in ("visual.glb", "collision.glb")}}
        | body.facts,
    }
    write_whole(done, json.dumps(details, indent=1).encode())
    return True


def _mark(options: Options, folder: Folder, names: Iterable[str]) -> str:
    """Digest the options and the named files as they are now."""
    digest = hashlib.sha256(f"{IMPORT_VERSION}|{options}".encode())
    for name in sorted(names):
        try:
            content = folder.read(str(folder.root / name), absolute=True)
        except (RefusedError, FileNotFoundError):
            content = b""
        digest.update(f"{name}|{hashlib.sha256(content).hexdigest()}".encode())
    return digest.hexdigest()


def _up_to_date(target: Path, options: Options, folder: Folder) -> bool:
    """Return whether the shape stage was done with these options from these very files, and whole."""
    try:
        before = json.loads((target / "shape.json").read_text())
        meshes = before["import"]["meshes"]
        return _mark(options, folder, before["import"]["files"]) == before["fingerprint"] and all(
            sha256(target / file) == digest for file, digest in meshes.items()
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return False  # not there, or torn by a kill: made again


def import_one(job: Job, out: Path) -> Report:
    """Do both stages, picture and measurements of one object.

    It is made in :data:`STAGING` and takes its place in ``out`` when it is whole, so that a kill leaves
    the object that was there before, or none.

    Raises:
        RefusedError: with the reason, for what cannot be imported.
    """
    from grasp_bench.workshop.importing.measure import finish
    from grasp_bench.workshop.poses import build_rest

    target, made = out / job.name, out / STAGING / job.name
    before = _details(target)
    if before is not None and _up_to_date(target, job.options, Folder(job.root, job.path.parent)):
        fresh = build_rest(target, seen=True) | finish(target)
        return Report(job.name, "imported" if fresh else "up to date", details=_details(target) or before)
    if _details(made) is None:
        (made / "object.json").unlink(missing_ok=True)  # torn
    import_shape(job, out / STAGING)
    build_rest(made, seen=True)
    finish(made)
    if target.exists():
        shutil.rmtree(target)
    made.rename(target)
    details = json.loads((target / "object.json").read_text())
    was = "" if before is None else str(before.get("import", {}).get("place", ""))
    replaced = was if was and job.place and was != job.place else ""
    return Report(job.name, "imported", details=details, replaced=replaced)


def _details(folder: Path) -> dict[str, Any] | None:
    """Return the content of a folder's ``object.json``; None where it is not there, or torn."""
    try:
        found = json.loads((folder / "object.json").read_text())
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) else None


def import_all(jobs: Sequence[Job], out: Path, workers: int, timeout: float) -> Iterator[Report]:
    """Import on ``workers`` processes; yields reports as objects end, failed ones too.

    Args:
        out: folder that the objects' folders go to.
        workers: number of processes.
        timeout: time after which an object fails, alone [s].

    Raises:
        GraspBenchError: another import writes to ``out``.
    """
    out.mkdir(parents=True, exist_ok=True)
    busy = GraspBenchError(f"Another import is writing to {out}; wait for it or choose another --out.")
    with Lock(out / ".lock", busy), ProcessPool(max_workers=workers) as pool:
        futures: dict[Future[Report], Job] = {pool.submit(import_one, timeout, j, out): j for j in jobs}
        try:
            for future in as_completed(futures):
                name = futures[future].name
                try:
                    yield future.result()
                    continue
                except TimeoutError:
                    why = f"not done after {timeout:.0f} s; raise --timeout, or simplify it"
                except ProcessExpired as error:
                    why = f"its process died ({error.exitcode}): the mesh upset a library"
                except Exception as error:  # one bad object must not stop the others
                    why = str(error) or type(error).__name__
                for folder in (out, out / STAGING):
                    (folder / name / "object.json").unlink(missing_ok=True)  # of an earlier, sounder file
                yield Report(name, "failed", why)
        except BaseException:  # interrupted: leaving the pool would wait for all that is queued
            pool.stop()
            raise
        shutil.rmtree(out / STAGING, ignore_errors=True)
