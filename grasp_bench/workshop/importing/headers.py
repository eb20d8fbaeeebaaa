"""What the headers of mesh files promise, checked against the files' sizes before anything is allocated."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable
from typing import Any
from xml.etree.ElementTree import ParseError

from defusedxml import ElementTree as SafeTree
from defusedxml.common import DefusedXmlException

from grasp_bench.workshop.importing.folder import RefusedError
from grasp_bench.workshop.importing.gltf import (
    GLTF_EXTENSIONS,
    INSTANCING,
    MAX_NODES,
    glb_parts,
    natural,
    nodes_shown,
)
from grasp_bench.workshop.importing.obj_text import plain_text

MAX_FACES = 1_000_000
MAX_VERTICES = 2_000_000
MAX_DAE = 50_000_000
"""Greatest size of a DAE file, whose XML is kept in memory [bytes]."""


def _check_obj(content: bytes) -> None:
    faces = content.count(b"\nf ") + content.startswith(b"f ")
    if faces > MAX_FACES or content.count(b"\nv ") > MAX_VERTICES:
        raise RefusedError(
            f"{faces} faces; at most {MAX_FACES} faces and {MAX_VERTICES} vertices are read: "
            "simplify the mesh first"
        )
    if b"\0" in content:
        raise RefusedError("not an OBJ file: it holds binary data")


def _check_dae(content: bytes) -> None:
    if len(content) > MAX_DAE:
        raise RefusedError(
            f"the DAE file has {len(content) / 1e6:.0f} MB; at most {MAX_DAE / 1e6:.0f} MB are read"
        )
    try:
        tree = SafeTree.fromstring(content, forbid_dtd=True)
    except DefusedXmlException as error:
        raise RefusedError("the DAE file declares entities or a document type, which are not read") from error
    except (ParseError, ValueError, RecursionError) as error:
        raise RefusedError(f"the DAE file is not valid XML ({str(error)[:120]})") from error
    if str(tree.tag).endswith("COLLADA") and not any(
        str(e.tag).endswith("}instance_geometry") for e in tree.iter()
    ):
        raise RefusedError("the DAE file shows no geometry")
    if not str(tree.tag).endswith("COLLADA"):
        raise RefusedError(f"the DAE file is not COLLADA, but <{str(tree.tag)[:40]}>")
    counts = [int(e.get("count", "0")) for e in tree.iter() if str(e.tag).endswith(("triangles", "polylist"))]
    if sum(counts) > MAX_FACES:
        raise RefusedError(f"{sum(counts)} faces; at most {MAX_FACES} are read: simplify the mesh first")
    nodes = sum(str(e.tag).endswith(("}node", "}instance_node", "}instance_geometry")) for e in tree.iter())
    if nodes > MAX_NODES:
        raise RefusedError(f"the DAE file has {nodes} nodes; at most {MAX_NODES} are read")
    if any(str(e.tag).endswith("}instance_node") for e in tree.iter()):
        raise RefusedError("the DAE file shows nodes more than once (<instance_node>); export it as one mesh")


def plain_stl(content: bytes, notes: list[str]) -> bytes:
    """Return an STL file with a right count and lower-case keywords, and note what was not so."""
    if len(content) >= 84:
        count, rest = struct.unpack("<I", content[80:84])[0], len(content) - 84
        if rest == 50 * count:
            return content
        if not _is_ascii_stl(content):
            if count and 0 < rest - 50 * count < 50 * (count + 1):
                notes.append(f"{rest - 50 * count} bytes after the last face were left out")
                return content[: 84 + 50 * count]
            if count == 0 and rest and rest % 50 == 0:
                notes.append(f"the header promises no faces, but the file holds {rest // 50}: read")
                return content[:80] + struct.pack("<I", rest // 50) + content[84:]
    return plain_text(content).lower() if _is_ascii_stl(content) else content


def _is_ascii_stl(content: bytes) -> bool:
    start = content[:2000].lower()
    return start.lstrip(b"\xef\xbb\xbf \t\r\n")[:5] == b"solid" and b"facet" in start and b"\0" not in start


def _check_stl(content: bytes) -> None:
    if _is_ascii_stl(content):
        if content.count(b"endfacet") > MAX_FACES:
            raise RefusedError(f"more than {MAX_FACES} faces: simplify the mesh first")
        return
    if len(content) < 84:
        raise RefusedError("the STL file is truncated")
    count = struct.unpack("<I", content[80:84])[0]
    if 84 + 50 * count != len(content) or not count:
        raise RefusedError(
            f"the STL file promises {count} faces but its size is that of {(len(content) - 84) / 50:.1f}"
        )


def _check_ply(content: bytes) -> None:
    end = content.find(b"end_header")
    if not content.startswith(b"ply") or not 0 < end < 100_000:
        raise RefusedError("the PLY file has no header")
    for kind, number in re.findall(rb"^element\s+(\S+)\s+(\S+)\s*$", content[:end], re.MULTILINE):
        if not number.isdigit() or int(number) > min(MAX_VERTICES, len(content)):
            raise RefusedError(
                f"the PLY header promises {number[:20].decode(errors='replace')} "
                f"{kind[:20].decode(errors='replace')} elements, more than the file can hold "
                f"or are read ({MAX_VERTICES})"
            )


def _check_glb(content: bytes) -> None:
    tree, binary = glb_parts(content)
    required = set(tree.get("extensionsRequired", ())) - GLTF_EXTENSIONS
    if required:
        raise RefusedError(
            f"the GLB requires the extension {sorted(required)[0]}, which is not read; export "
            "it without compression"
        )
    for key in ("buffers", "images"):
        for entry in tree.get(key, ()):
            if entry.get("uri") is not None:
                raise RefusedError(
                    "the GLB refers to another file or address; export it with everything embedded"
                )
    for accessor in tree.get("accessors", ()):
        if natural(accessor.get("count", 0)) > MAX_VERTICES + 3 * MAX_FACES:
            raise RefusedError("the GLB's accessors promise more than is read")
    for view in tree.get("bufferViews", ()):
        if natural(view.get("byteOffset", 0)) + natural(view["byteLength"]) > len(binary):
            raise RefusedError("the GLB's buffer views promise more than the file holds")
    _check_nodes(tree)


def _check_nodes(tree: dict[str, Any]) -> None:
    """Refuse nodes that form no trees, or that show too many faces together."""
    nodes, meshes, accessors = (tree.get(k, []) for k in ("nodes", "meshes", "accessors"))
    if len(nodes) > MAX_NODES:
        raise RefusedError(f"the GLB has {len(nodes)} nodes; at most {MAX_NODES} are read")
    children = [c for n in nodes for c in n.get("children", ())]
    if len(children) != len(set(children)):
        raise RefusedError("the GLB's nodes are not a tree")
    above = {c: i for i, n in enumerate(nodes) for c in n.get("children", ())}
    for node in range(len(nodes)):
        steps, at = 0, node
        while at in above:
            at, steps = above[at], steps + 1
            if steps > 100:
                raise RefusedError("the GLB's nodes are nested in a circle, or more than 100 deep")
    for root in nodes_shown(tree):
        natural(root)
    shown = 0
    for node in nodes:
        if "mesh" in node:
            given = node.get("extensions", {}).get(INSTANCING, {}).get("attributes", {})
            copies = min((natural(accessors[a]["count"]) for a in given.values()), default=1)
            if copies > MAX_NODES:
                raise RefusedError(f"the GLB makes {copies} copies of a mesh; at most {MAX_NODES} are read")
            for primitive in meshes[node["mesh"]]["primitives"]:
                which = primitive.get("indices", primitive.get("attributes", {}).get("POSITION"))
                if which is not None:
                    count = natural(accessors[which]["count"])
                    shown += copies * (count // 3 if primitive.get("mode", 4) == 4 else count)
    if shown > MAX_FACES:
        raise RefusedError(f"the GLB's scene shows {shown} faces; at most {MAX_FACES} are read")


def _guarded(check: Callable[[bytes], None]) -> Callable[[bytes], None]:
    """Let a header check run on anything at all: what trips it is not a file of that kind."""

    def run(content: bytes) -> None:
        try:
            check(content)
        except RefusedError:
            raise
        except (KeyError, IndexError, TypeError, AttributeError, ValueError, struct.error) as error:
            raise RefusedError(
                f"the file's structure is broken ({type(error).__name__}: {str(error)[:80]})"
            ) from error

    return run


CHECKS = {
    ".dae": _guarded(_check_dae),
    ".obj": _guarded(_check_obj),
    ".stl": _guarded(_check_stl),
    ".ply": _guarded(_check_ply),
    ".glb": _guarded(_check_glb),
    ".gltf": _guarded(_check_glb),  # once it is packed into a GLB
}
