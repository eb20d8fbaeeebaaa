"""Names of imported objects: plain ones, and each only once."""

from __future__ import annotations

import re
import unicodedata
from pathlib import Path

from grasp_bench.workshop.importing.folder import RefusedError


def plain_name(name: str) -> str:
    """Return lower-case ASCII letters, digits and underscores: accents are dropped, letters of other
    scripts become their code point (``u676f``); empty where nothing is left."""
    letters = []
    for c in unicodedata.normalize("NFKD", name.lower().replace("ß", "ss")).lower():
        if c.isascii() and c.isalnum():
            letters.append(c)
        elif unicodedata.combining(c):
            continue
        elif c.isalnum():
            letters.append(f"_u{ord(c):04x}_")
        else:
            letters.append("_")
    text = "".join(letters)
    return (
        re.sub(r"__+(?=u[0-9a-f]{4,5}_)|(?<=[0-9a-f])__+(?=[a-z0-9])", "_", text).strip("_")[:60].strip("_")
    )


def clean_name(name: str) -> str:
    """Make a folder name of ``name``: lower case letters, digits and underscores, at most 60.

    Raises:
        RefusedError: where nothing is left.
    """
    letters = plain_name(name)
    if not letters:
        raise RefusedError(f"{name!r} makes no name; give one with --name")
    return letters


def unique_names(found: list[tuple[str, Path]], root: Path, notes: list[str]) -> list[tuple[str, Path, Path]]:
    """Put their folder's name before objects of one name, then a number behind, and say so."""
    names = [n for n, _ in found]
    taken: set[str] = set()
    result = []
    for name, path in found:
        label = name
        twins = [p for n, p in found if n == name]
        if len(twins) > 1 and len({p.parent for p in twins}) > 1:
            label = clean_name(f"{path.resolve().parent.name}_{name}")
        base, i = label, 1
        while label in taken or (label != name and label in names):
            i += 1
            label = f"{base}_{i}"
        if label != name:
            notes.append(
                f"{path.relative_to(root).as_posix()} is called {label}: {name} is the name of {len(twins)}"
            )
        taken.add(label)
        result.append((label, path, root))
    return result
