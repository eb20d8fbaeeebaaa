"""Models of robots' parts as users have them, rewritten as the folders that grasp-bench reads.

What is a matter of drawing and of the maker's own simulation is left out: textures, lights, cameras, sensors,
keyframes. Meshes are copied. Nothing outside of the model's folder is read.
"""

from __future__ import annotations

import shutil
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

import mujoco
import numpy as np

from grasp_bench.errors import AssetError
from grasp_bench.robot.facts import FOREIGN, model_file, parse
from grasp_bench.workshop.own_meshes import MESH_KINDS, inside
from grasp_bench.workshop.own_urdf import read_urdf

SHOWN, SOLID = 2, 3
"""Geom groups of what is seen and of what collides."""


LARGE = 10.0
"""Parts that are larger were drawn in millimetres [m]."""


@contextmanager
def making(out: Path, model: str, source: Path) -> Iterator[None]:
    """Make the folder ``out``, which must not hold anything yet; what fails leaves nothing in it.

    Args:
        out: the folder.
        model: file in it that ``source`` is rewritten as; errors name ``source`` instead.
        source: the user's file.

    Raises:
        AssetError: where it is not empty.
    """
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise AssetError(f"{out} exists and is not empty; choose another --out.")
    out.mkdir(parents=True, exist_ok=True)
    try:
        yield
    except BaseException as error:
        made = str((out / model).resolve())
        shutil.rmtree(out, ignore_errors=True)
        if isinstance(error, AssetError) and made in str(error):
            raise AssetError(str(error).replace(made, str(source))) from error
        raise


def read_model(path: Path, radian: bool = False) -> mujoco.MjSpec:
    """Read a user's MJCF or URDF.

    Args:
        path: the file.
        radian: whether its angles are radians, though it does not say so.

    Raises:
        AssetError: in one line, for what is not read, lies outside of its folder, or what MuJoCo refuses.
    """
    if not path.is_file():
        raise AssetError(f"{path} is no file; name the MJCF or URDF of the part.")
    if parse(path).tag == "mujoco":
        model_file(path.parent, path.name)
    elif parse(path).tag != "robot":
        raise AssetError(f"{path} is neither MJCF (<mujoco>) nor URDF (<robot>).")
    try:
        spec = read_urdf(path) if parse(path).tag == "robot" else mujoco.MjSpec.from_file(str(path))
        if radian:
            spec.compiler.degree = False
        model = spec.compile()
    except ValueError as error:
        raise AssetError(
            f"{path} is refused by MuJoCo {mujoco.__version__}: {' '.join(str(error).split())}. Correct the "
            "file until `python -m mujoco.viewer --mjcf=FILE` shows it."
        ) from error
    if model.stat.extent > LARGE:
        raise AssetError(
            f"{path} is {model.stat.extent:.0f} m large: lengths are metres; scale positions, sizes, ranges "
            "of slides and meshes by 0.001."
        )
    return spec


def strip(spec: mujoco.MjSpec, keep_joints: Iterable[str]) -> None:
    """Leave of a model bodies, the joints named, and geoms: seen and solid ones in two groups."""
    kept = set(keep_joints)
    for kind in (
        spec.actuators, spec.sensors, spec.keys, spec.tendons, spec.equalities, spec.excludes, spec.pairs,
        spec.cameras, spec.lights, spec.textures, spec.numerics, spec.texts, spec.tuples, spec.sites,
    ):  # fmt: skip
        for element in list(kind):
            spec.delete(element)
    for geom in spec.geoms:
        solid = bool(geom.contype or geom.conaffinity)
        geom.group = SOLID if solid else SHOWN
        if not solid:
            geom.mass = 0.0
    if not any(g.group == SHOWN for g in spec.geoms):
        for geom in spec.geoms:
            geom.group = SHOWN  # what collides is all that there is to be seen
    for material in spec.materials:
        material.textures = [""] * len(material.textures)
    for joint in list(spec.joints):
        if joint.name not in kept:
            spec.delete(joint)
    for body in spec.bodies[1:]:
        body.gravcomp = 1.0


def fix_inertia(spec: mujoco.MjSpec, model: mujoco.MjModel) -> None:
    """Write into every body the mass and inertia that it had when compiled as its maker meant it."""
    for body in spec.bodies[1:]:
        i = model.body(body.name).id
        if model.body_mass[i] <= 0:
            continue
        body.explicitinertial = True
        body.fullinertia = np.full(6, np.nan)
        body.mass = float(model.body_mass[i])
        body.ipos, body.iquat = model.body_ipos[i].copy(), model.body_iquat[i].copy()
        body.inertia = model.body_inertia[i].copy()


def name_all(spec: mujoco.MjSpec) -> None:
    """Give every body and geom a name that has none."""
    for kind, elements in (("body", spec.bodies[1:]), ("geom", spec.geoms)):
        for i, element in enumerate(elements):
            if not element.name:
                element.name = f"{kind}{i}"


def write_model(spec: mujoco.MjSpec, source: Path, out: Path, name: str) -> Path:
    """Write a model and copies of its meshes into the folder ``out``.

    Raises:
        AssetError: where a mesh cannot be found.
    """
    spec.compile()
    tree = ET.fromstring(spec.to_xml())
    compiler = tree.find("compiler")
    if compiler is None:
        compiler = ET.SubElement(tree, "compiler")
    folder = source.parent / (compiler.get("meshdir") or compiler.get("assetdir") or "")
    meshes = out / "meshes"
    taken: dict[str, str] = {}
    for i, mesh in enumerate(tree.iter("mesh")):
        file = mesh.get("file")
        if file is None:
            continue
        found = next(
            (p for p in (folder / file, source.parent / file, folder / Path(file).name) if p.is_file()), None
        )
        if found is None:
            raise AssetError(f"{source} names the mesh {file}, which is not in {folder}.")
        if found.suffix.lower() not in MESH_KINDS or not inside(found, source):
            raise AssetError(
                f"{source} names {file}, which is no STL, OBJ or MSH file inside of {source.parent}."
            )
        if file not in taken:
            taken[file] = f"{i:03d}_{found.name}"
            meshes.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(found, meshes / taken[file])
        mesh.set("file", taken[file])
        mesh.attrib.pop("content_type", None)
    for key in ("texturedir", "assetdir", "strippath"):
        compiler.attrib.pop(key, None)
    compiler.set("meshdir", "meshes")
    for element in list(tree):
        if element.tag in ("size", "visual", "statistic") or element.tag in FOREIGN:
            tree.remove(element)
    ET.indent(tree)
    path = out / name
    path.write_text(ET.tostring(tree, encoding="unicode") + "\n")
    return path
