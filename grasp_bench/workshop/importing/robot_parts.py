"""The parts of an MJCF or URDF file: its mesh files and textures, and its geoms in world coordinates.

Files are read by this project's own readers from inside the folder; poses and primitives are those of the
compiled model.
"""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from dataclasses import dataclass, replace
from pathlib import PurePosixPath

import mujoco
import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image

from grasp_bench.scene.builder import stl_bytes
from grasp_bench.system.arrays import Floats
from grasp_bench.workshop.importing.discovery import locate_mesh
from grasp_bench.workshop.importing.folder import Folder, RefusedError
from grasp_bench.workshop.importing.paint import Paint
from grasp_bench.workshop.importing.readers import Scan, read_mesh
from grasp_bench.workshop.importing.robot_xml import mesh_folder, settings
from grasp_bench.workshop.importing.textures import Textures

MAX_MESH_FACES = 200_000
"""What MuJoCo reads of one mesh file at most."""


@dataclass(frozen=True)
class Piece:
    """One geom in world coordinates: vertices, faces, its paint, and whether it collides or is shown."""

    vertices: Floats
    faces: NDArray[np.int64]
    paint: Paint
    collides: bool


def textures_of(tree: ET.Element, textures: Textures) -> dict[str, Image.Image]:
    """Read the pictures by material name; those that cannot be read are noted."""
    compiler = settings(tree)
    base = compiler.get("texturedir", compiler.get("assetdir", ""))
    files = {
        t.get("name", PurePosixPath(t.get("file", "")).stem): t.get("file")
        for t in tree.iter("texture")
        if t.get("file") and t.get("type", "cube") == "2d"
    }
    pictures = {}
    for material in tree.iter("material"):
        name = material.get("texture")
        file = files.get(name) if name is not None else None
        if file is None:
            continue
        content = textures.find(str(PurePosixPath(base) / file))
        picture = None if content is None else textures.image(content, file)
        if picture is not None:
            pictures[str(material.get("name"))] = picture
    return pictures


class MeshFiles:
    """The mesh files of a description, read by this project's readers; renames them in the tree.

    Attributes:
        assets: STL bytes by new name, for MuJoCo.
        scans: the meshes by their name (MJCF) or new name's stem (URDF).
        notes: what was found elsewhere, or is missing.
    """

    def __init__(self, tree: ET.Element, folder: Folder, textures: dict[str, Image.Image]) -> None:
        self.assets: dict[str, bytes] = {}
        self.scans: dict[str, Scan] = {}
        self.notes: list[str] = []
        self._folder = folder
        base = mesh_folder(tree)
        key = "file" if tree.tag == "mujoco" else "filename"
        used_with = {g.get("mesh"): textures.get(str(g.get("material"))) for g in tree.iter("geom")}
        for i, element in enumerate(e for e in list(tree.iter("mesh")) if e.get(key) is not None):
            given = str(element.get(key))
            label = element.get("name", PurePosixPath(given).stem) if tree.tag == "mujoco" else f"mesh{i}"
            scan = self._read(base, given, used_with.get(label))
            new = f"mesh{i}.stl"
            self.assets[new] = stl_bytes(scan.vertices, scan.faces)
            element.set(key, new)
            if tree.tag == "mujoco":
                element.set("name", label)
                element.attrib.pop("content_type", None)
            self.scans[label] = scan

    def _read(self, base: str, given: str, picture: Image.Image | None) -> Scan:
        found = locate_mesh(self._folder, base, given)
        if found is None:
            raise RefusedError(
                f"the mesh file {given!r} is not inside the imported folder; import one that holds both"
            )
        path, note = found
        scan = read_mesh(self._folder, os.path.relpath(path, self._folder.base), picture)
        self.notes += [n for n in (note, *scan.notes) if n and n not in self.notes]
        if len(scan.faces) > MAX_MESH_FACES:
            raise RefusedError(
                f"{path.name} has {len(scan.faces)} faces; at most {MAX_MESH_FACES} are read of a mesh "
                "that is part of a description: simplify it first"
            )
        # As in RViz and Gazebo: a DAE file's unit counts, its upward axis does not.
        return replace(scan, vertices=scan.vertices * scan.metres) if scan.metres else scan


def piece_of(model: mujoco.MjModel, data: mujoco.MjData, geom: int, files: MeshFiles) -> Piece:
    """Return a geom of the compiled model; meshes as they were read.

    Raises:
        RefusedError: for a kind of geom that is no solid.
    """
    kind, size = mujoco.mjtGeom(int(model.geom_type[geom])), model.geom_size[geom]
    rgb = (
        model.geom_rgba[geom, :3]
        if model.geom_matid[geom] < 0
        else model.mat_rgba[model.geom_matid[geom], :3]
    )
    rotation, position = data.geom_xmat[geom].reshape(3, 3), data.geom_xpos[geom]
    paint: Paint | None = None
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        scan = files.scans.get(model.mesh(mesh).name)
        if scan is not None:
            own = np.zeros(9)
            mujoco.mju_quat2Mat(own, model.mesh_quat[mesh])
            # MuJoCo moves meshes to their centre and principal axes, and keeps how.
            vertices = (scan.vertices * model.mesh_scale[mesh] - model.mesh_pos[mesh]) @ own.reshape(3, 3)
            faces = scan.faces
            paint = scan.paint if scan.paint.varied else None
        else:  # written out in the XML
            first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
            vertices = np.asarray(model.mesh_vert[first : first + count], float)
            first, count = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
            faces = np.asarray(model.mesh_face[first : first + count], np.int64)
    else:
        shape = _primitive(kind, size)
        vertices, faces = np.asarray(shape.vertices, float), np.asarray(shape.faces, np.int64)
    if paint is None:
        paint = Paint(
            np.ones((len(faces), 3, 3)) * rgb,
            np.full((len(faces), 3, 2), np.nan),
            np.full(len(faces), -1),
            [],
        )
    collides = bool(model.geom_contype[geom] or model.geom_conaffinity[geom])
    return Piece(vertices @ rotation.T + position, faces, paint, collides)


def _primitive(kind: mujoco.mjtGeom, size: Floats) -> trimesh.Trimesh:
    shapes = mujoco.mjtGeom
    if kind == shapes.mjGEOM_BOX:
        return trimesh.creation.box(2 * size)
    if kind in (shapes.mjGEOM_SPHERE, shapes.mjGEOM_ELLIPSOID):
        ball = trimesh.creation.icosphere(2)
        ball.apply_scale(size if kind == shapes.mjGEOM_ELLIPSOID else np.repeat(size[0], 3))
        return ball
    if kind == shapes.mjGEOM_CYLINDER:
        return trimesh.creation.cylinder(size[0], 2 * size[1], sections=32)
    if kind == shapes.mjGEOM_CAPSULE:
        ball = trimesh.creation.uv_sphere(size[0], count=(8, 16)).vertices
        return trimesh.convex.convex_hull(np.vstack([ball + [0, 0, size[1]], ball - [0, 0, size[1]]]))
    raise RefusedError(f"a geom of type {kind.name[7:].lower()} is not a solid part")
