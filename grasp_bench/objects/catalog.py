"""The objects that can be benchmarked: a manifest, and what each object's files hold.

A folder of objects has a ``manifest.json`` and, per object, ``visual.glb`` (coloured closed
parts), ``collision.glb`` (convex hulls) and ``object.json``. Meshes are in metres, z up, with
the origin at the centre of mass.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from grasp_bench.errors import AssetError, UnknownNameError
from grasp_bench.system.arrays import Floats
from grasp_bench.system.integrity import MANIFEST, sha256
from grasp_bench.system.paths import assets_dir

if TYPE_CHECKING:  # type checkers do not see that a cached_property meets a protocol's property
    from builtins import property as cached_property
else:
    from functools import cached_property

FILES = ("visual.glb", "collision.glb", "object.json")
APART = ("grid",)
"""Families of objects that are tried only where they are asked for by name: ``all`` does not mean them."""
GRASPABLE = "graspable"
"""Entry of the manifest, false, of objects that no grasp fits the gripper on."""


@dataclass(frozen=True)
class VisualPart:
    """One coloured mesh, closed but in imported objects: vertices (V, 3) [m], faces (F, 3), rgb in
    [0, 1], roughness in [0, 1], and the material's name."""

    vertices: Floats
    faces: NDArray[np.int32]
    rgb: tuple[float, float, float]
    roughness: float
    material: str = "unknown"


@dataclass(frozen=True)
class ReferenceGrasp:
    """A top-down grasp known from the true mesh, in the object's frame.

    Attributes:
        tip: (3,) midpoint between the finger tips' ends [m].
        axis: (3,) unit jaw opening direction, horizontal when the object rests in its pose.
        width: opening of the jaws before closing [m].
        top: height above the table of what is grasped [m].
        score: larger is better; see :mod:`grasp_bench.workshop.poses`.
    """

    tip: Floats
    axis: Floats
    width: float
    top: float
    score: float


@dataclass(frozen=True)
class RestingPose:
    """A pose in which the object lies still on the table.

    Attributes:
        quaternion: (4,) w, x, y, z of the object in the world, free up to yaw.
        height: that of the centre of mass above the table [m].
        probability: chance of coming to rest so when dropped at random.
        grasps: reference grasps, best first; empty where none fits the gripper.
    """

    quaternion: Floats
    height: float
    probability: float
    grasps: tuple[ReferenceGrasp, ...]

    @property
    def rotation(self) -> Floats:
        """(3, 3) matrix of the quaternion, to the bits of MuJoCo's own."""
        import mujoco

        matrix = np.zeros(9)
        mujoco.mju_quat2Mat(matrix, self.quaternion)
        return matrix.reshape(3, 3)


@dataclass(frozen=True)
class ObjectModel:
    """Everything the simulation needs of an object.

    Attributes:
        name, category: as in the manifest.
        folder: where its files are.
        mass: kilograms.
        inertia: (3, 3) about the centre of mass, in the object's axes [kg m²].
        friction: sliding friction coefficient against the finger pads.
        poses: resting poses, most probable first.
        digest: SHA-256 over its files, as the manifest records them.
        put_in: numbers of the poses that trials use; empty for those in which some grasp fits the gripper.
    """

    name: str
    category: str
    folder: Path
    mass: float
    inertia: Floats
    friction: float
    poses: tuple[RestingPose, ...]
    digest: str
    put_in: tuple[int, ...] = ()

    @property
    def graspable_poses(self) -> tuple[RestingPose, ...]:
        """The poses that trials use: those chosen, or those in which some grasp fits the gripper."""
        return tuple(self.poses[i] for i in self.put_in) or tuple(p for p in self.poses if p.grasps)

    @cached_property
    def visual(self) -> list[VisualPart]:
        """The coloured parts."""
        scene = _load_glb(self.folder / "visual.glb")
        parts = []
        for name in sorted(scene.geometry):
            mesh = scene.geometry[name]
            material = mesh.visual.material
            red, green, blue = (float(c) / 255 for c in np.asarray(material.baseColorFactor)[:3])
            roughness = 0.5 if material.roughnessFactor is None else float(material.roughnessFactor)
            vertices, faces = np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int32)
            parts.append(VisualPart(vertices, faces, (red, green, blue), roughness))
        return parts

    @cached_property
    def hulls(self) -> list[Floats]:
        """Vertices (V, 3) of each convex piece [m]."""
        scene = _load_glb(self.folder / "collision.glb")
        return [np.asarray(scene.geometry[n].vertices, float) for n in sorted(scene.geometry)]


def _load_glb(path: Path) -> Any:
    import trimesh

    try:
        return trimesh.load_scene(path, process=False)
    except Exception as error:
        raise AssetError(
            f"{path} cannot be read as a GLB mesh ({error}). Run `grasp-bench objects verify`; "
            "restore the file or rebuild it with `grasp-bench objects build`."
        ) from error


def combined_digest(files: dict[str, str]) -> str:
    """Return one digest of an object's file digests."""
    return hashlib.sha256(json.dumps(files, sort_keys=True).encode()).hexdigest()


def folder_of(name: str) -> Path:
    """Return the folder of a shipped set of objects by its name, or of anyone's by its path."""
    shipped = assets_dir() / name
    return shipped if (shipped / MANIFEST).is_file() else Path(name)


class Catalog:
    """The objects of one folder.

    Args:
        folder: one with a ``manifest.json``; that of the shipped 180 objects by default.

    Raises:
        AssetError: when the manifest is missing, not readable, or lists nothing.
    """

    def __init__(self, folder: Path | None = None) -> None:
        self.folder = assets_dir() / "objects" if folder is None else Path(folder)
        path = self.folder / MANIFEST
        if not path.is_file():
            raise AssetError(
                f"{self.folder} has no {MANIFEST}; name a folder made by `grasp-bench objects build`."
            )
        try:
            manifest = json.loads(path.read_text())
            self.entries: dict[str, dict[str, Any]] = {e["name"]: e for e in manifest["objects"]}
        except (ValueError, KeyError, TypeError) as error:
            raise AssetError(
                f"{path} is not a valid manifest ({error}); restore it or run `grasp-bench objects build`."
            ) from error
        if not self.entries:
            raise AssetError(f"{path} lists no object: nothing was built or imported there.")

    @property
    def names(self) -> list[str]:
        """The names of what ``all`` means, in the manifest's order: all objects but those of :data:`APART`,
        where there are others."""
        household = [n for n, e in self.entries.items() if e.get("family") not in APART]
        return household or list(self.entries)

    @property
    def categories(self) -> list[str]:
        """All categories, sorted."""
        return sorted({self.entries[n]["category"] for n in self.names})

    @property
    def heaviest(self) -> float:
        """Mass of the heaviest of :attr:`names` [kg]."""
        return max(self.entries[n]["mass"] for n in self.names)

    @property
    def sets(self) -> list[str]:
        """Families of :data:`APART` that are there."""
        return [s for s in APART if any(e.get("family") == s for e in self.entries.values())]

    def select(self, what: str) -> list[str]:
        """Return the names meant by ``all``, or by comma-separated names, categories and :attr:`sets`.

        Raises:
            UnknownNameError: naming the nearest objects and categories.
        """
        if what == "all":
            return self.names
        chosen: list[str] = []
        for word in filter(None, (w.strip() for w in what.split(","))):
            found = [n for n, e in self.entries.items() if word in (n, e["category"])]
            if word in self.sets:
                found = [n for n, e in self.entries.items() if e.get("family") == word]
            if not found:
                known = [*self.entries, *self.categories, *self.sets]
                raise UnknownNameError("object or category", word, known)
            chosen += [n for n in found if n not in chosen]
        if not chosen:
            raise UnknownNameError("object or category", what, self.names)
        return chosen

    def ungraspable(self, names: Iterable[str]) -> list[str]:
        """Return those of ``names`` that are marked as having no grasp that fits the gripper."""
        return [n for n in names if self.entries[n].get(GRASPABLE) is False]

    def chosen(self, names: Iterable[str]) -> list[str]:
        """Return the named objects in the manifest's order, or all where none is named.

        Raises:
            UnknownNameError: for a name that the manifest does not have.
        """
        wanted = list(names)
        for name in wanted:
            if name not in self.entries:
                raise UnknownNameError("object", name, self.entries)
        return [n for n in self.entries if n in wanted] if wanted else self.names

    def faults(self, name: str) -> list[str]:
        """Return what is wrong with an object's files against the manifest; empty when all is well."""
        faults = []
        for file, digest in self.entries[name]["files"].items():
            path = self.folder / name / file
            if not path.is_file():
                faults.append(f"{path} is missing")
            elif sha256(path) != digest:
                faults.append(f"{path} differs from the manifest (SHA-256)")
        return faults

    def load(self, name: str) -> ObjectModel:
        """Load an object, its files verified against the manifest.

        Raises:
            UnknownNameError: for a name that is not in the manifest.
            AssetError: for files that are missing, changed or unreadable.
        """
        if name not in self.entries:
            raise UnknownNameError("object", name, self.entries)
        faults = self.faults(name)
        if faults:
            raise AssetError(
                f"{'; '.join(faults)}. Restore the files (git checkout) or rebuild them with "
                f"`grasp-bench objects build --only {name}`."
            )
        entry = self.entries[name]
        details = json.loads((self.folder / name / "object.json").read_text())
        return load_details(
            self.folder / name, details | {"category": entry["category"]}, combined_digest(entry["files"])
        )


def load_details(folder: Path, details: dict[str, Any], digest: str = "") -> ObjectModel:
    """Make the object of an ``object.json``'s content, whose other files are in ``folder``."""
    poses = tuple(
        RestingPose(
            np.array(p["quaternion"]),
            p["height"],
            p["probability"],
            tuple(
                ReferenceGrasp(np.array(g["tip"]), np.array(g["axis"]), g["width"], g["top"], g["score"])
                for g in p["grasps"]
            ),
        )
        for p in details["poses"]
    )
    return ObjectModel(
        details["name"],
        details["category"],
        folder,
        details["mass"],
        np.array(details["inertia"]),
        details["friction"],
        poses,
        digest,
    )
