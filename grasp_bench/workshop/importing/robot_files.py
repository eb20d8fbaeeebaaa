"""Objects described in MJCF or URDF, with convex parts ready: the parts are kept as they are.

The XML is read by defusedxml, stripped to what describes one rigid body, its mesh files are read
by this project's own readers from inside the folder, and only then MuJoCo compiles it: poses,
defaults, primitives and inertias mean exactly what they mean there.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import replace

import mujoco
import numpy as np

from grasp_bench.objects.catalog import VisualPart
from grasp_bench.system.arrays import Floats
from grasp_bench.workshop.decompose import MAX_HULLS, compare, reduce_hull
from grasp_bench.workshop.importing import paint as painting
from grasp_bench.workshop.importing.body import Body, Options
from grasp_bench.workshop.importing.convex import beyond, decompose_whole
from grasp_bench.workshop.importing.folder import Folder, RefusedError
from grasp_bench.workshop.importing.plausible import check_inertia
from grasp_bench.workshop.importing.repair import mend
from grasp_bench.workshop.importing.robot_inertia import drop_masses, settle_inertials
from grasp_bench.workshop.importing.robot_parts import MeshFiles, Piece, piece_of, textures_of
from grasp_bench.workshop.importing.robot_xml import check_rigid, free_urdf, gather_world, parse, strip
from grasp_bench.workshop.importing.solid import solidify
from grasp_bench.workshop.importing.textures import Textures
from grasp_bench.workshop.importing.units import check_length, check_size
from grasp_bench.workshop.shapes import Mesh, hull, union

CONVEX = 1.10
"""A part whose hull is this much larger than it is decomposed."""


def import_robot_file(folder: Folder, name: str, options: Options) -> Body:
    """Import the rigid object of an MJCF or URDF file.

    Raises:
        RefusedError: with the reason, for what cannot be imported.
    """
    tree = parse(folder.read(name), name)
    notes: list[str] = []
    pictures = Textures(folder)
    textures = textures_of(tree, pictures) if tree.tag == "mujoco" else {}
    files = MeshFiles(tree, folder, textures)
    notes += [*pictures.notes, *files.notes]
    check_rigid(tree)
    inertials = settle_inertials(tree, notes)
    if tree.tag == "robot":
        free_urdf(tree)
    else:
        gather_world(tree, notes)
    strip(tree, notes)
    model = _compile(tree, files, name, notes)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    factor = 1.0 if options.scale is None else options.scale
    pieces = [piece_of(model, data, g, files) for g in range(model.ngeom)]
    if not pieces:
        raise RefusedError(f"{name} describes no shape")
    shown = [p for p in pieces if not p.collides] or list(pieces)
    solid_ones = [p for p in pieces if p.collides] or list(pieces)
    extents = np.ptp(np.vstack([p.vertices for p in pieces]), axis=0)
    if options.length is not None:
        factor = options.length / float(extents.max())
    if factor != 1:
        for group in (shown, solid_ones):
            group[:] = [replace(p, vertices=p.vertices * factor) for p in group]
        extents = extents * factor
    check_length(
        float(extents.max()), "(both formats are in metres; --scale 0.001 for meshes in millimetres)"
    )
    check_size(extents)
    hulls = _hulls(solid_ones, notes)
    solid = _solid(shown, hulls, notes, options)
    error = compare(solid, hulls)
    stray = beyond(error, solid)
    if stray:
        notes.append(
            f"the convex parts stray from what is shown (up to {1000 * error.max_distance:.1f} mm): "
            "kept as they are"
        )
    parts: list[VisualPart] = []
    for piece in shown:
        parts += painting.bake(piece.vertices, piece.faces, np.arange(len(piece.faces)), piece.paint)
    body = Body(parts, solid, hulls, error, notes, facts={"unit": "m", "format": tree.tag})
    if any(
        e.tag == "inertial" or (e.tag == "geom" and {"mass", "density"} & set(e.keys())) for e in tree.iter()
    ):
        body.mass, body.centre, body.inertia = _mass_properties(model, data)
        if body.centre is not None and body.inertia is not None:
            body.centre, body.inertia = body.centre * factor, body.inertia * factor**2
        for mass, inertia in inertials.suspects:
            check_inertia(mass, np.asarray(solid.center_mass), inertia * factor**2, solid)
        if inertials.spread or inertials.suspects:
            body.centre = body.inertia = None
    return body


def _compile(tree: ET.Element, files: MeshFiles, name: str, notes: list[str]) -> mujoco.MjModel:
    """Compile a stripped description; a mass of 0 altogether is taken as not given."""
    for last in (False, True):
        try:
            text = ET.tostring(tree, encoding="unicode")
            return mujoco.MjSpec.from_string(text, assets=files.assets).compile()
        except ValueError as error:
            if "mjMINVAL" in str(error) and not last:
                notes.append("its mass or inertia is 0: taken as not given")
                drop_masses(tree)
                continue
            plain = " ".join(str(error).split())
            raise RefusedError(f"MuJoCo does not compile {name}: {plain[:200]}") from error
    raise AssertionError("unreachable")


def _hulls(pieces: list[Piece], notes: list[str]) -> list[Mesh]:
    """Return the convex parts; those that are not convex are decomposed."""
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


def _solid(shown: list[Piece], hulls: list[Mesh], notes: list[str], options: Options) -> Mesh:
    """Return what the shown parts enclose; the hulls where they enclose nothing."""
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


def _mass_properties(
    model: mujoco.MjModel, data: mujoco.MjData
) -> tuple[float | None, Floats | None, Floats | None]:
    """Return mass, centre and inertia about it of all bodies as one."""
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
