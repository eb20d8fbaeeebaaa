"""A glTF file of text, with its buffers and pictures beside it, as the binary file that holds the same.

Khronos, *glTF 2.0 Specification*, sections 3.6.1 (buffers), 3.8.3 (images) and 4.4 (binary files).
"""

from __future__ import annotations

import base64
import binascii
import json
import struct
from typing import Any
from urllib.parse import unquote_to_bytes

from grasp_bench.workshop.importing.folder import MAX_FILE, Folder, RefusedError
from grasp_bench.workshop.importing.textures import Textures


def packed(content: bytes, folder: Folder, textures: Textures) -> bytes:
    """Return a binary glTF file with everything that ``content`` names.

    Args:
        content: JSON of a ``.gltf`` file.
        folder: where its buffers are read.
        textures: finds its pictures, and takes notes of those that are not there: they are left out.

    Raises:
        RefusedError: for what is no glTF, and for a buffer that is not there, too short or outside.
    """
    try:
        tree = json.loads(content)
        if not isinstance(tree, dict) or not isinstance(tree.get("asset"), dict):
            raise ValueError("no glTF object")
        binary, starts = bytearray(), []
        for buffer in tree.get("buffers", ()):
            binary += bytes(-len(binary) % 4)
            starts.append(len(binary))
            binary += _buffer(buffer, folder)
            if len(binary) > MAX_FILE:
                raise RefusedError(f"its buffers have more than {MAX_FILE / 1e6:.0f} MB, which are not read")
        for view in tree.get("bufferViews", ()):
            view["byteOffset"] = view.get("byteOffset", 0) + starts[view.get("buffer", 0)]
            view["buffer"] = 0
        for image in tree.get("images", ()):
            _embed(image, tree, binary, textures)
    except (ValueError, TypeError, AttributeError, IndexError, RecursionError) as error:
        raise RefusedError(f"the glTF cannot be read ({str(error)[:120]})") from error
    binary += bytes(-len(binary) % 4)
    tree["buffers"] = [{"byteLength": len(binary)}]
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary))
    return b"".join(
        (
            head,
            struct.pack("<I4s", len(text), b"JSON"),
            text,
            struct.pack("<I4s", len(binary), b"BIN\0"),
            binary,
        )
    )


def _buffer(buffer: dict[str, Any], folder: Folder) -> bytes:
    """Return the bytes of a buffer."""
    uri, length = buffer.get("uri"), buffer["byteLength"]
    if not isinstance(uri, str) or not isinstance(length, int):
        raise RefusedError("the glTF has a buffer without a file")
    data = _inline(uri)
    if data is None:
        try:
            data = folder.read(uri)
        except FileNotFoundError:
            raise RefusedError(f"{uri[:80]}, which the glTF names, is not there; put it beside it") from None
    if not 0 <= length <= len(data):
        raise RefusedError(f"a buffer of the glTF has {len(data)} bytes and promises {length}")
    return data[:length]


def _embed(image: dict[str, Any], tree: dict[str, Any], binary: bytearray, textures: Textures) -> None:
    """Put a picture that an image names into the binary part; without one, the image is left empty."""
    uri = image.pop("uri", None)
    if not isinstance(uri, str):
        return
    data = _inline(uri)
    if data is None:
        data = textures.find(uri)
    if data is None or len(binary) + len(data) > MAX_FILE:
        return
    binary += bytes(-len(binary) % 4)
    views = tree.setdefault("bufferViews", [])
    image["bufferView"] = len(views)
    views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
    binary += data


def _inline(uri: str) -> bytes | None:
    """Return what a data address holds; None for any other reference."""
    if not uri.startswith("data:"):
        return None
    kind, comma, data = uri.partition(",")
    if not comma:
        raise RefusedError("the glTF holds a data address without data")
    try:
        return base64.b64decode(data, validate=True) if kind.endswith(";base64") else unquote_to_bytes(data)
    except binascii.Error as error:
        raise RefusedError(f"the glTF holds a data address that is not base64 ({error})") from error
