"""``grasp-bench objects import``: from somebody's mesh to an object that can be benchmarked.

The stages are those of the shipped objects (:mod:`grasp_bench.workshop.build`): *shape*, read
from a file instead of modelled, and *rest*, the same code. A killed import goes on where it stopped.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Future, TimeoutError, as_completed
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from pebble import ProcessExpired, ProcessPool

from grasp_bench.objects.catalog import VisualPart
from grasp_bench.system.arrays import Floats
from grasp_bench.workshop.build import rounded, write_hulls, write_visual
from grasp_bench.workshop.importing import paint as painting
from grasp_bench.workshop.importing.body import Body, Options
from grasp_bench.workshop.importing.convex import decompose_whole
from grasp_bench.workshop.importing.folder import ROBOT_SUFFIXES, Folder, RefusedError
from grasp_bench.workshop.importing.readers import read_mesh
from grasp_bench.workshop.importing.repair import mend
from grasp_bench.workshop.importing.robot_files import import_robot_file
from grasp_bench.workshop.importing.solid import solidify
from grasp_bench.workshop.importing.units import UNITS, check_size, choose_unit
from grasp_bench.workshop.shapes import Mesh, hull

IMPORT_VERSION = 2
"""Raise this when imports would come out differently: all are made again then."""
MASSES = (0.001, 5.0)
"""What the arm can carry, gripper aside, and what contacts are stable with [kg]."""
DENSITY = 500.0
"""Assumed where no mass is given [kg/m³]: between hollow plastic and wood."""
FAMILY = "imported"


@dataclass(frozen=True)
class Job:
    """One object to import: its name, file, folder that may be read, and options."""

    name: str
    path: Path
    root: Path
    options: Options


@dataclass(frozen=True)
class Report:
    """What came of one object.

    Attributes:
        status: ``imported``, ``up to date`` or ``failed``.
        why: the reason of a failure.
        details: the content of ``object.json``; empty after a failure.
    """

    name: str
    status: str
    why: str = ""
    details: dict[str, Any] = field(default_factory=dict)


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
    is_glb = name.lower().endswith(".glb")
    unit, note = choose_unit(
        extents,
        "m" if options.units == "auto" and is_glb else options.units,
        options.mass,
        _hull_volume(points),
    )
    notes += [note] if note else []
    vertices = scan.vertices * UNITS[unit]
    if options.up == "y" or (options.up == "auto" and is_glb):
        vertices = vertices @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]], float)
    mesh = mend(vertices, scan.faces, options.holes)
    check_size(np.ptp(mesh.vertices[np.unique(mesh.faces)], axis=0))
    solid = solidify(mesh)
    hulls, error = decompose_whole(solid)
    parts = painting.bake(mesh.vertices, mesh.faces, mesh.source, scan.paint)
    return Body(parts, solid, hulls, error, notes + mesh.notes, facts={"unit": unit})


def _hull_volume(points: Floats) -> float:
    try:
        return float(hull(Mesh(points, np.zeros((0, 3), int), process=False)).volume)
    except Exception:  # flat: refused later, with its thickness
        return 0.0


def import_shape(job: Job, out: Path) -> bool:
    """Write ``visual.glb``, ``collision.glb`` and ``shape.json``; False when up to date.

    Raises:
        RefusedError: with the reason, for what cannot be imported.
    """
    options, target = job.options, out / job.name
    folder = Folder(job.root, job.path.parent)
    done = target / "shape.json"
    if _up_to_date(done, options, folder):
        return False
    if job.path.suffix.lower() in ROBOT_SUFFIXES:
        body = import_robot_file(folder, job.path.name, options)
    else:
        body = import_body(folder, job.path.name, options)
    mass, why = _mass(body, options)
    body.notes += [why] if why else []
    centre, inertia = body.centre, body.inertia
    if centre is None or inertia is None:
        centre, inertia = spread_mass(body.solid, mass, options.inertia)
    elif body.mass:
        inertia = inertia * mass / body.mass
    target.mkdir(parents=True, exist_ok=True)
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
        "fingerprint": _mark(options, folder, folder.read_files),
        "import": {"files": sorted(folder.read_files), "spread": options.inertia, "notes": body.notes}
        | body.facts,
    }
    done.write_text(json.dumps(details, indent=1))
    return True


def spread_mass(solid: Mesh, mass: float, how: str) -> tuple[Floats, Floats]:
    """Return the centre of mass (3,) [m] and inertia (3, 3) about it [kg m²].

    Args:
        solid: closed mesh [m].
        how: ``solid``, evenly over the volume; ``shell``, evenly over the surface.
    """
    if how == "solid":
        return np.asarray(solid.center_mass), np.asarray(solid.moment_inertia) * mass / solid.volume
    a, b, c = np.moveaxis(np.asarray(solid.vertices)[solid.faces], 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    # The mean of a quadratic over a triangle is that over its edges' midpoints.
    middles = np.stack([a + b, b + c, c + a], axis=1) / 2
    weights = np.repeat(area / 3, 3) * mass / area.sum()
    points = middles.reshape(-1, 3)
    centre = weights @ points / mass
    offset = points - centre
    second = (weights[:, None] * offset).T @ offset
    return centre, np.trace(second) * np.eye(3) - second


def _mass(body: Body, options: Options) -> tuple[float, str]:
    note = ""
    if options.mass is not None:
        mass = options.mass
    elif options.density is not None:
        mass = options.density * float(body.solid.volume)
    elif body.mass is not None:
        mass = body.mass
    else:
        mass = DENSITY * float(body.solid.volume)
        note = f"no mass given: {1000 * mass:.0f} g assumed, from {DENSITY:.0f} kg/m³"
    if not MASSES[0] <= mass <= MASSES[1]:
        raise RefusedError(
            f"a mass of {1000 * mass:.3g} g; {1000 * MASSES[0]:.0f} g to {MASSES[1]:.0f} kg "
            "can be lifted and simulated: give --mass"
        )
    return mass, note


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


def _up_to_date(done: Path, options: Options, folder: Folder) -> bool:
    """Return whether the shape stage was done with these options from these very files."""
    try:
        before = json.loads(done.read_text())
        return _mark(options, folder, before["import"]["files"]) == before["fingerprint"]
    except (OSError, ValueError, KeyError, TypeError):
        return False  # not there, or torn by a kill: made again


def import_one(job: Job, out: Path) -> Report:
    """Do both stages, picture and measurements of one object.

    Raises:
        RefusedError: with the reason, for what cannot be imported.
    """
    from grasp_bench.workshop.importing.measure import finish
    from grasp_bench.workshop.poses import build_rest

    fresh = import_shape(job, out)
    fresh |= build_rest(out / job.name, seen=True)
    fresh |= finish(out / job.name)
    details = json.loads((out / job.name / "object.json").read_text())
    if not any(p["grasps"] for p in details["poses"]):
        raise RefusedError(f"no grasp fits the gripper in any of its {len(details['poses'])} resting poses")
    return Report(job.name, "imported" if fresh else "up to date", details=details)


def import_all(jobs: Sequence[Job], out: Path, workers: int, timeout: float) -> Iterator[Report]:
    """Import on ``workers`` processes; yields reports as objects end, failed ones too.

    Args:
        out: folder that the objects' folders go to.
        workers: number of processes.
        timeout: time after which an object fails, alone [s].
    """
    out.mkdir(parents=True, exist_ok=True)
    with ProcessPool(max_workers=workers) as pool:
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
                (out / name / "object.json").unlink(missing_ok=True)  # of an earlier, sounder file
                yield Report(name, "failed", why)
        except BaseException:  # interrupted: leaving the pool would wait for all that is queued
            pool.stop()
            raise
