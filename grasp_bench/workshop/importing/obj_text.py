"""OBJ and MTL files as programs really write them, put into the form that the loader reads.

Byte order marks, UTF-16, old line ends, decimal commas, relative indices, and the options before a
picture's name in an MTL file (Wavefront's own description of both formats).
"""

from __future__ import annotations

import codecs
import re

import numpy as np

from grasp_bench.workshop.importing.folder import RefusedError

MARKS = ((codecs.BOM_UTF8, "utf-8"), (codecs.BOM_UTF16_LE, "utf-16-le"), (codecs.BOM_UTF16_BE, "utf-16-be"))
OPTIONS = {
    "-blendu": 1,
    "-blendv": 1,
    "-boost": 1,
    "-bm": 1,
    "-cc": 1,
    "-clamp": 1,
    "-imfchan": 1,
    "-mm": 2,
    "-texres": 1,
    "-type": 1,
}
"""Options of ``map_Kd`` with the number of their values; ``-o``, ``-s`` and ``-t`` have one to three."""
COMMA = re.compile(rb"^(v[tn]?\s[^\n]*\d),(\d)", re.MULTILINE)
RELATIVE = re.compile(rb"^f[^\n]*[\s/]-\d", re.MULTILINE)
ZERO = re.compile(rb"^f[^\n]*[\s/]0+(?=[\s/]|$)", re.MULTILINE)


def plain_text(content: bytes) -> bytes:
    """Return text as UTF-8 or Latin-1 without a byte order mark, with lines that end in a newline.

    Raises:
        RefusedError: for what is marked as UTF-16 and is not.
    """
    for mark, encoding in MARKS:
        if content.startswith(mark):
            try:
                content = content[len(mark) :].decode(encoding).encode()
            except UnicodeDecodeError as error:
                raise RefusedError(f"the file is marked as {encoding} but is not ({error.reason})") from error
    return content.replace(b"\r\n", b"\n").replace(b"\r", b"\n")


def plain_obj(content: bytes, notes: list[str]) -> bytes:
    """Return an OBJ file in its common form, and note what was read in another sense than written.

    Raises:
        RefusedError: for indices of 0, and relative ones that lead before the first vertex.
    """
    text = plain_text(content)
    if COMMA.search(text) and not re.search(rb"^v\s[^\n]*\d\.\d", text, re.MULTILINE):
        notes.append("decimal commas were read as points")
        text = b"\n".join(
            line.replace(b",", b".") if line.startswith((b"v ", b"vt ", b"vn ", b"v\t")) else line
            for line in text.split(b"\n")
        )
    if ZERO.search(text):
        raise RefusedError("a face has an index of 0; indices start from 1 (or, relative ones, from -1)")
    if RELATIVE.search(text):
        text = _absolute(re.sub(rb"\\[ \t]*\n", b" ", text))
    return text


def _absolute(text: bytes) -> bytes:
    """Replace relative indices, which count back from the line they are in."""
    counts = {b"v": 0, b"vt": 0, b"vn": 0}
    kinds = (b"v", b"vt", b"vn")
    lines = text.split(b"\n")
    for number, line in enumerate(lines):
        words = line.split()
        if not words:
            continue
        if words[0] in counts:
            counts[words[0]] += 1
        elif words[0] == b"f":
            corners = []
            for word in words[1:]:
                if word.startswith(b"#"):
                    break
                indices = []
                for kind, index in zip(kinds, word.split(b"/"), strict=False):
                    if index.startswith(b"-"):
                        place = counts[kind] + 1 + int(index)
                        if place < 1:
                            raise RefusedError(
                                f"line {number + 1}: an index of {int(index)} leads before the first"
                            )
                        index = b"%d" % place
                    indices.append(index)
                corners.append(b"/".join(indices))
            lines[number] = b"f " + b" ".join(corners)
    return b"\n".join(lines)


def map_options(value: str) -> tuple[str, np.ndarray, np.ndarray]:
    """Parse what follows ``map_Kd``: return the file's name, and the scale (2,) and offset (2,) of its
    texture coordinates."""
    scale, offset = np.ones(2), np.zeros(2)
    words = re.findall(r"\S+\s*", value)
    at = 0
    while at < len(words) and words[at].strip().lower() in {*OPTIONS, "-o", "-s", "-t"}:
        option = words[at].strip().lower()
        at += 1
        if option in OPTIONS:
            at += OPTIONS[option]
            continue
        numbers = []
        while at < len(words) - 1 and len(numbers) < 3:
            try:
                numbers.append(float(words[at]))
            except ValueError:
                break
            at += 1
        numbers = [n for n in numbers[:2] if np.isfinite(n)]
        if option == "-s":
            scale[: len(numbers)] = numbers
        elif option == "-o":
            offset[: len(numbers)] = numbers
    return "".join(words[at:]).strip().strip('"'), scale, offset
