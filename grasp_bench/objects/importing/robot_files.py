"""Objects described in MJCF or URDF, with convex parts ready: the parts are kept as they are.

The XML is read by defusedxml, stripped to what describes one rigid body, its mesh files are read
by this project's own readers from inside the folder, and only then MuJoCo compiles it: poses,
defaults, primitives and inertias mean exactly what they mean there.
"""

from __future__ import annotations

import io
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import PurePosixPath

import mujoco
import numpy as np
import trimesh
from defusedxml import ElementTree as SafeTree
from defusedxml.common import DefusedXmlException
from numpy.typing import NDArray
from PIL import Image

from grasp_bench.objects.catalog import VisualPart
from grasp_bench.objects.decompose import MAX_HULLS, compare, reduce_hull
from grasp_bench.objects.importing import paint as painting
from grasp_bench.objects.importing.convex import beyond, decompose_whole
from grasp_bench.objects.importing.folder import Folder, RefusedError, check_image
from grasp_bench.objects.importing.importer import Body, Options
from grasp_bench.objects.importing.paint import Paint
from grasp_bench.objects.importing.readers import Scan, read_mesh
from grasp_bench.objects.importing.repair import mend
from grasp_bench.objects.importing.solid import solidify
from grasp_bench.objects.importing.units import LONGEST, check_size
from grasp_bench.objects.shapes import Mesh, hull, union
from grasp_bench.scene.builder import stl_bytes

Floats = NDArray[np.float64]

MAX_XML = 20_000_000
MAX_ELEMENTS = 20_000
KEPT = {"mujoco", "compiler", "default", "asset", "mesh", "material", "worldbody", "body", "frame", "geom",
        "inertial", "joint", "freejoint",
        "robot", "link", "visual", "collision", "origin", "geometry", "box", "sphere", "cylinder", "color",
        "mass", "inertia", "parent", "child"}
"""Elements that describe a rigid object; others are left out."""
FOREIGN = {"include", "plugin", "extension", "attach", "model", "composite", "flexcomp", "replicate",
           "hfield", "skin"}
"""Elements that pull in other files or code, or make what is no rigid body."""
COMPILER = {"angle", "eulerseq", "autolimits", "balanceinertia", "boundmass", "boundinertia", "settotalmass",
            "inertiafromgeom", "inertiagrouprange", "exactmeshinertia"}
CONVEX = 1.10
"""A part whose hull is this much larger than it is decomposed."""


@dataclass(frozen=True)
class _Piece:
    """One geom in world coordinates: vertices, faces, its paint, and whether it collides or is shown."""

    vertices: Floats
    faces: NDArray[np.int64]
    paint: Paint
    collides: bool


def import_robot_file(folder: Folder, name: str, options: Options) -> Body:
    """The rigid object of an MJCF or URDF file.

    Raises:
        RefusedError: with the reason, for what cannot be imported.
    """
    tree = _parse(folder.read(name), name)
    notes: list[str] = []
    textures = _textures(tree, folder) if tree.tag == "mujoco" else {}
    files = _Meshes(tree, folder, textures)
    _check_rigid(tree)
    if tree.tag == "robot":
        _free_urdf(tree)
    _strip(tree, notes)
    try:
        text = ET.tostring(tree, encoding="unicode")
        model = mujoco.MjSpec.from_string(text, assets=files.assets).compile()
    except ValueError as error:
        raise RefusedError(f"MuJoCo does not compile {name}: {str(error)[:200]}") from error
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    pieces = [_piece(model, data, g, files) for g in range(model.ngeom)]
    if not pieces:
        raise RefusedError(f"{name} describes no shape")
    shown = [p for p in pieces if not p.collides] or pieces
    solid_ones = [p for p in pieces if p.collides] or pieces
    extents = np.ptp(np.vstack([p.vertices for p in pieces]), axis=0)
    if not LONGEST[0] <= extents.max() <= LONGEST[1]:
        raise RefusedError(f"{1000 * extents.max():.3g} mm long; objects of {1000 * LONGEST[0]:.0f} to "
                           f"{1000 * LONGEST[1]:.0f} mm are imported (both formats are in metres)")
    check_size(extents)
    hulls = _hulls(solid_ones, notes)
    solid = _solid(shown, hulls, notes, options)
    error = compare(solid, hulls)
    stray = beyond(error, solid)
    if stray:
        notes.append(f"the convex parts stray from what is shown (up to {1000 * error.max_distance:.1f} mm): "
                     "kept as they are")
    body = Body(_visual(shown), solid, hulls, error, notes, facts={"unit": "m", "format": tree.tag})
    if any(e.tag == "inertial" or (e.tag == "geom" and {"mass", "density"} & set(e.keys()))
           for e in tree.iter()):
        body.mass, body.centre, body.inertia = _mass_properties(model, data)
    return body


def _parse(content: bytes, name: str) -> ET.Element:
    if len(content) > MAX_XML:
        raise RefusedError(f"{name} has {len(content) / 1e6:.0f} MB; at most {MAX_XML / 1e6:.0f} MB of XML "
                           "are read")
    try:
        tree = SafeTree.fromstring(content, forbid_dtd=True)
    except DefusedXmlException as error:
        raise RefusedError(f"{name} declares entities or a document type, which are not read") from error
    except (ET.ParseError, ValueError) as error:
        raise RefusedError(f"{name} is not valid XML ({error})") from error
    except RecursionError as error:
        raise RefusedError(f"{name} is nested too deeply") from error
    if tree.tag not in ("mujoco", "robot"):
        raise RefusedError(f"{name} is neither MJCF (<mujoco>) nor URDF (<robot>), but "
                           f"<{str(tree.tag)[:40]}>")
    elements = list(tree.iter())
    if len(elements) > MAX_ELEMENTS:
        raise RefusedError(f"{name} has {len(elements)} elements; at most {MAX_ELEMENTS} are read")
    for element in elements:
        if element.tag in FOREIGN and not (tree.tag == "robot" and element.tag == "model"):
            raise RefusedError(f"{name} uses <{element.tag}>, which is not read: only one rigid object, "
                               "whole in its file, is imported")
    return tree


def _check_rigid(tree: ET.Element) -> None:
    if tree.tag == "robot":
        moving = [j for j in tree.findall("joint") if j.get("type") not in ("fixed", "floating")]
        kinds = [str(j.get("type")) for j in moving]
    else:
        world = tree.find("worldbody")
        bodies = [] if world is None else list(world.iter("body"))
        top = [] if world is None else world.findall("body")
        if len(top) > 1:
            raise RefusedError(f"it describes {len(top)} bodies side by side; import one object a file")
        kinds = [str(j.get("type", "hinge")) for b in bodies for j in b.findall("joint")
                 if j.get("type") != "free"]
    if kinds:
        raise RefusedError(f"it has a joint ({kinds[0]}); only rigid objects are imported")


def _free_urdf(tree: ET.Element) -> None:
    """Hang the root link on a free joint, without which MuJoCo would make it part of the world."""
    children = {c.get("link") for j in tree.findall("joint") for c in j.findall("child")}
    roots = [link for link in tree.findall("link") if link.get("name") not in children]
    if len(roots) != 1:
        raise RefusedError(f"its links make {len(roots)} trees; one is imported")
    ET.SubElement(tree, "link", name="grasp_bench_world")
    joint = ET.SubElement(tree, "joint", name="grasp_bench_free", type="floating")
    ET.SubElement(joint, "parent", link="grasp_bench_world")
    ET.SubElement(joint, "child", link=str(roots[0].get("name")))
    for extra in tree.findall("mujoco"):
        tree.remove(extra)
    # Where a file gives inertias, a link without one has none.
    given = "false" if any(True for _ in tree.iter("inertial")) else "auto"
    ET.SubElement(ET.SubElement(tree, "mujoco"), "compiler", discardvisual="false", fusestatic="true",
                  strippath="true", balanceinertia="true", inertiafromgeom=given)


def _strip(tree: ET.Element, notes: list[str]) -> None:
    """Leave out what does not describe the rigid body."""
    left = set()

    def walk(element: ET.Element) -> None:
        for child in list(element):
            if child.tag not in KEPT:
                element.remove(child)
                left.add(str(child.tag))
                continue
            if child.tag == "compiler" and tree.tag == "mujoco":
                for key in set(child.keys()) - COMPILER:
                    del child.attrib[key]
            if child.tag == "material":
                for key in ("texture", "class"):
                    child.attrib.pop(key, None)
            walk(child)

    walk(tree)
    left -= {"option", "visual", "statistic", "size", "texture", "key", "site", "light", "camera", "layer"}
    if left:
        notes.append(f"left out: {', '.join(f'<{t}>' for t in sorted(left)[:8])}")


def _textures(tree: ET.Element, folder: Folder) -> dict[str, Image.Image]:
    """Pictures by material name."""
    compiler = _settings(tree)
    base = compiler.get("texturedir", compiler.get("assetdir", ""))
    files = {t.get("name", PurePosixPath(t.get("file", "")).stem): t.get("file")
             for t in tree.iter("texture") if t.get("file") and t.get("type", "cube") == "2d"}
    pictures = {}
    for material in tree.iter("material"):
        name = material.get("texture")
        file = files.get(name) if name is not None else None
        if file is None:
            continue
        try:
            content = folder.read(str(PurePosixPath(base) / file))
        except FileNotFoundError:
            continue
        check_image(content, file)
        pictures[str(material.get("name"))] = Image.open(io.BytesIO(content))
    return pictures


def _settings(tree: ET.Element) -> dict[str, str]:
    found: dict[str, str] = {}
    for compiler in tree.findall("compiler"):
        found |= dict(compiler.items())
    return found


class _Meshes:
    """The mesh files of a description, read by this project's readers; renames them in the tree.

    Attributes:
        assets: STL bytes by new name, for MuJoCo.
        scans: by mesh name (MJCF) or new name's stem (URDF).
    """

    def __init__(self, tree: ET.Element, folder: Folder, textures: dict[str, Image.Image]) -> None:
        self.assets: dict[str, bytes] = {}
        self.scans: dict[str, Scan] = {}
        self._folder = folder
        compiler = _settings(tree)
        base = compiler.get("meshdir", compiler.get("assetdir", "")) if tree.tag == "mujoco" else ""
        key = "file" if tree.tag == "mujoco" else "filename"
        used_with = {g.get("mesh"): textures.get(str(g.get("material"))) for g in tree.iter("geom")}
        for i, element in enumerate(e for e in list(tree.iter("mesh")) if e.get(key) is not None):
            given = str(element.get(key))
            label = element.get("name", PurePosixPath(given).stem) if tree.tag == "mujoco" else f"mesh{i}"
            scan = self._read(PurePosixPath(base), given, used_with.get(label))
            new = f"mesh{i}.stl"
            self.assets[new] = stl_bytes(scan.vertices, scan.faces)
            element.set(key, new)
            if tree.tag == "mujoco":
                element.set("name", label)
                element.attrib.pop("content_type", None)
            self.scans[label] = scan

    def _read(self, base: PurePosixPath, given: str, picture: Image.Image | None) -> Scan:
        if given.startswith("package://"):
            rest = PurePosixPath(given.removeprefix("package://"))
            tries = [str(rest), str(PurePosixPath(*rest.parts[1:]))]
        else:
            tries = [str(base / given)]
        for name in tries:
            if self._folder.path(name).is_file():
                return read_mesh(self._folder, name, picture)
        raise RefusedError(f"the mesh file {given!r} is not inside the folder")


def _piece(model: mujoco.MjModel, data: mujoco.MjData, geom: int, files: _Meshes) -> _Piece:
    kind, size = model.geom_type[geom], model.geom_size[geom]
    rgb = model.geom_rgba[geom, :3] if model.geom_matid[geom] < 0 else \
        model.mat_rgba[model.geom_matid[geom], :3]
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
            vertices = np.asarray(model.mesh_vert[first:first + count], float)
            first, count = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
            faces = np.asarray(model.mesh_face[first:first + count], np.int64)
    else:
        shape = _primitive(kind, size)
        vertices, faces = np.asarray(shape.vertices, float), np.asarray(shape.faces, np.int64)
    if paint is None:
        paint = Paint(np.ones((len(faces), 3, 3)) * rgb, np.full((len(faces), 3, 2), np.nan),
                      np.full(len(faces), -1), [])
    collides = bool(model.geom_contype[geom] or model.geom_conaffinity[geom])
    return _Piece(vertices @ rotation.T + position, faces, paint, collides)


def _primitive(kind: int, size: Floats) -> trimesh.Trimesh:
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
    raise RefusedError(f"a geom of type {mujoco.mjtGeom(kind).name[7:].lower()} is not a solid part")


def _hulls(pieces: list[_Piece], notes: list[str]) -> list[Mesh]:
    """The convex parts; those that are not convex are decomposed."""
    hulls: list[Mesh] = []
    cut = 0
    for piece in pieces:
        mesh = Mesh(piece.vertices, piece.faces, process=True)
        outer = hull(mesh)
        if mesh.is_watertight and outer.volume > CONVEX * abs(mesh.volume) and mesh.volume != 0:
            try:
                hulls += decompose_whole(solidify(mend(piece.vertices, piece.faces)))[0]
                cut += 1
                continue
            except RefusedError:
                pass  # taken as its hull, as MuJoCo would
        hulls.append(reduce_hull(piece.vertices))
    if cut:
        notes.append(f"{cut} of its parts are not convex: decomposed")
    if len(hulls) > MAX_HULLS:
        notes.append(f"{len(hulls)} convex parts: decomposed anew into at most {MAX_HULLS}")
        return decompose_whole(union(*hulls))[0]
    return hulls


def _solid(shown: list[_Piece], hulls: list[Mesh], notes: list[str], options: Options) -> Mesh:
    """What the shown parts enclose; the hulls where they enclose nothing."""
    start = np.cumsum([0, *(len(p.vertices) for p in shown)])
    vertices = np.vstack([p.vertices for p in shown])
    faces = np.concatenate([p.faces + s for p, s in zip(shown, start, strict=False)])
    try:
        mesh = mend(vertices, faces, options.holes)
        solid = solidify(mesh)
        notes += mesh.notes
        return solid
    except RefusedError:
        notes.append("what is shown encloses no volume: the convex parts are the solid")
        return union(*hulls)


def _visual(shown: list[_Piece]) -> list[VisualPart]:
    parts: list[VisualPart] = []
    for piece in shown:
        parts += painting.bake(piece.vertices, piece.faces, np.arange(len(piece.faces)), piece.paint)
    return parts


def _mass_properties(model: mujoco.MjModel, data: mujoco.MjData,
                     ) -> tuple[float | None, Floats | None, Floats | None]:
    """Mass, centre and inertia about it of all bodies as one."""
    masses = np.asarray(model.body_mass)
    mass = float(masses.sum())
    if mass <= 0:
        return None, None, None
    centre = masses @ data.xipos / mass
    inertia = np.zeros((3, 3))
    for i, m in enumerate(masses):
        rotation, arm = data.ximat[i].reshape(3, 3), data.xipos[i] - centre
        inertia += rotation @ np.diag(model.body_inertia[i]) @ rotation.T
        inertia += m * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return mass, centre, inertia
