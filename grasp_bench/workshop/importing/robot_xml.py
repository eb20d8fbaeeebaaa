"""The XML of an MJCF or URDF file: read by defusedxml, and stripped to what describes one rigid body."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET

from defusedxml import ElementTree as SafeTree
from defusedxml.common import DefusedXmlException

from grasp_bench.workshop.importing.folder import RefusedError

MAX_XML = 20_000_000
MAX_ELEMENTS = 20_000
HINTS = {
    "sdf": "; SDF is not read: import its mesh, or convert it to URDF",
    "mujocoinclude": ", a part of another file: import the file that includes it, written out as one",
}
KEPT = frozenset(
    """
    mujoco compiler default asset mesh material worldbody body frame geom inertial joint freejoint robot
    link visual collision origin geometry box sphere cylinder color mass inertia parent child
    """.split()
)
"""Elements that describe a rigid object; others are left out."""
FOREIGN = frozenset("include plugin extension attach model composite flexcomp replicate hfield skin".split())
"""Elements that pull in other files or code, or make what is no rigid body."""
COMPILER = frozenset(
    """
    angle eulerseq autolimits balanceinertia boundmass boundinertia settotalmass inertiafromgeom
    inertiagrouprange exactmeshinertia
    """.split()
)


def parse(content: bytes, name: str) -> ET.Element:
    """Parse an MJCF or URDF file.

    Raises:
        RefusedError: for what is too large, not XML, or asks for anything beyond one file.
    """
    if len(content) > MAX_XML:
        raise RefusedError(
            f"{name} has {len(content) / 1e6:.0f} MB; at most {MAX_XML / 1e6:.0f} MB of XML are read"
        )
    try:
        tree = SafeTree.fromstring(content, forbid_dtd=True)
    except DefusedXmlException as error:
        raise RefusedError(f"{name} declares entities or a document type, which are not read") from error
    except (ET.ParseError, ValueError) as error:
        if b"xacro:" in content:
            raise RefusedError(_xacro(name)) from error
        raise RefusedError(f"{name} is not valid XML ({error})") from error
    except RecursionError as error:
        raise RefusedError(f"{name} is nested too deeply") from error
    if tree.tag not in ("mujoco", "robot"):
        hint = HINTS.get(str(tree.tag), "")
        raise RefusedError(
            f"{name} is neither MJCF (<mujoco>) nor URDF (<robot>), but <{str(tree.tag)[:40]}>{hint}"
        )
    elements = list(tree.iter())
    if any(
        "xacro}" in str(e.tag) or any("${" in v or "$(" in v for v in e.attrib.values()) for e in elements
    ):
        raise RefusedError(_xacro(name))
    if len(elements) > MAX_ELEMENTS:
        raise RefusedError(f"{name} has {len(elements)} elements; at most {MAX_ELEMENTS} are read")
    for element in elements:
        if element.tag in FOREIGN and not (tree.tag == "robot" and element.tag == "model"):
            raise RefusedError(
                f"{name} uses <{element.tag}>, which is not read: only one rigid object, "
                "whole in its file, is imported"
            )
    return tree


def _xacro(name: str) -> str:
    plain = name.removesuffix(".xacro").removesuffix(".urdf")
    plain += "_expanded" if name == f"{plain}.urdf" else ""
    return f"{name} is a xacro template, not yet a URDF: write one with `xacro {name} > {plain}.urdf`"


def mesh_references(content: bytes) -> list[tuple[str, str]]:
    """Return the folder that names start from, and the name, of each mesh file of a description, also of
    one that will be refused."""
    try:
        tree = parse(content, "it")
    except RefusedError:
        names = re.findall(rb"<mesh\b[^>]*\bfile(?:name)?\s*=\s*[\"']([^\"'$]+)[\"']", content[:MAX_XML])
        return [("", name.decode(errors="replace")) for name in names]
    key = "file" if tree.tag == "mujoco" else "filename"
    return [(mesh_folder(tree), str(e.get(key))) for e in tree.iter("mesh") if e.get(key)]


def mesh_folder(tree: ET.Element) -> str:
    """Return what MJCF puts before the names of mesh files; empty in URDF."""
    compiler = settings(tree)
    return compiler.get("meshdir", compiler.get("assetdir", "")) if tree.tag == "mujoco" else ""


def check_rigid(tree: ET.Element) -> None:
    """Refuse what is several bodies or has moving joints.

    Raises:
        RefusedError: saying which.
    """
    if tree.tag == "robot":
        moving = [j for j in tree.findall("joint") if j.get("type") not in ("fixed", "floating")]
        kinds = [str(j.get("type")) for j in moving]
    else:
        world = tree.find("worldbody")
        bodies = [] if world is None else list(world.iter("body"))
        top = [] if world is None else world.findall("body")
        if len(top) > 1:
            raise RefusedError(f"it describes {len(top)} bodies side by side; import one object a file")
        kinds = [
            str(j.get("type", "hinge")) for b in bodies for j in b.findall("joint") if j.get("type") != "free"
        ]
    if kinds:
        raise RefusedError(f"it has a joint ({kinds[0]}); only rigid objects are imported")


def free_urdf(tree: ET.Element) -> None:
    """Hang the root link on a free joint, without which MuJoCo would make it part of the world."""
    rename_world(tree)
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
    ET.SubElement(
        ET.SubElement(tree, "mujoco"),
        "compiler",
        discardvisual="false",
        fusestatic="true",
        strippath="true",
        balanceinertia="false",
        inertiafromgeom=given,
    )


def rename_world(tree: ET.Element) -> None:
    """Call the link ``world`` of ROS descriptions otherwise: MuJoCo takes it for its own fixed world."""
    for element in tree.iter():
        for key in ("name", "link"):
            if element.tag in ("link", "parent", "child") and element.get(key) == "world":
                element.set(key, "grasp_bench_root")


def gather_world(tree: ET.Element, notes: list[str]) -> None:
    """Put the geoms of an MJCF file's world into a body that moves, where it has no body; else leave
    them out, as the ground and what stands on it."""
    world = tree.find("worldbody")
    if world is None:
        return
    loose = world.findall("geom")
    ground = [g for g in loose if g.get("type") == "plane"]
    for geom in ground:
        world.remove(geom)
    loose = [g for g in loose if g not in ground]
    left = len(ground)
    if loose and any(True for _ in world.iter("body")):
        for geom in loose:
            world.remove(geom)
        left += len(loose)
    elif loose:
        body = ET.SubElement(world, "body")
        ET.SubElement(body, "freejoint")
        for geom in loose:
            world.remove(geom)
            body.append(geom)
    if left:
        notes.append(f"left out {left} geoms that belong to the world, not to a body (the ground)")


def strip(tree: ET.Element, notes: list[str]) -> None:
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


def settings(tree: ET.Element) -> dict[str, str]:
    """Return the attributes of all ``compiler`` elements, later ones first."""
    found: dict[str, str] = {}
    for compiler in tree.findall("compiler"):
        found |= dict(compiler.items())
    return found
