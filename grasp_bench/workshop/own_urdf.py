"""A user's URDF as MuJoCo reads it: meshes found in packages, unreadable drawings left out."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco

from grasp_bench.errors import AssetError
from grasp_bench.robot.facts import parse
from grasp_bench.workshop.own_meshes import MESH_KINDS, inside, package_of

PACKAGE = "package://"


def read_urdf(path: Path) -> mujoco.MjSpec:
    """Read a URDF. Every link stays a body of its own, such as a ``tool0`` without mass.

    Meshes are looked for in the URDF's folder, below it in a folder that is called as their package, and in
    the package around it.

    Raises:
        AssetError: in one line, for xacro, and for meshes that collide and cannot be found or read.
        ValueError: for what MuJoCo refuses.
    """
    tree = parse(path)
    for element in tree.iter():
        if "xacro" in element.tag:
            raise AssetError(f"{path} is a xacro; expand it first: `xacro {path.name} > robot.urdf`.")
    for own in tree.findall("mujoco"):
        tree.remove(own)  # its compiler could name other folders
    for link in tree.iter("link"):
        for part in [*link.findall("visual"), *link.findall("collision")]:
            mesh = part.find("geometry/mesh")
            if mesh is None:
                continue
            found = _mesh(path, mesh.get("filename") or "")
            if isinstance(found, Path):
                mesh.set("filename", str(found))
            elif part.tag == "visual":
                link.remove(part)
            else:
                raise AssetError(f"{path}: link {link.get('name')!r} {found}")
    extension = ET.SubElement(tree, "mujoco")
    ET.SubElement(
        extension,
        "compiler",
        strippath="false",
        discardvisual="false",
        fusestatic="false",
        balanceinertia="true",
    )
    return mujoco.MjSpec.from_string(ET.tostring(tree, encoding="unicode"))


def _mesh(path: Path, name: str) -> Path | str:
    """Return where a mesh is, or what is wrong with it."""
    rest = name.removeprefix("file://")
    places = [path.parent / rest]
    if name.startswith(PACKAGE):
        package, _, rest = name.removeprefix(PACKAGE).partition("/")
        places = [path.parent / rest, path.parent / package / rest]
        if (around := package_of(path)) is not None:
            places.append(around / rest)
    if Path(rest).suffix.lower() not in MESH_KINDS:
        return f"collides by {name}, which is no STL, OBJ or MSH file; convert it."
    found = next((p.resolve() for p in places if p.is_file()), None)
    if found is None:
        asked = ", ".join(str(p) for p in places)
        return f"names the mesh {name}, which is not there; it was looked for as {asked}."
    if not inside(found, path):
        return f"names {name}, which lies outside of {path.parent}; copy it into the folder."
    return found
