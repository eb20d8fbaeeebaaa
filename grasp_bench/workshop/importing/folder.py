"""Reading files that somebody else wrote: sizes, kinds and places are checked before any parser sees them.

A mesh may name other files (materials, textures, convex parts). They are read only from inside
the folder that is imported, whatever the names say; nothing is fetched, unpacked or followed out.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path, PurePosixPath
from urllib.parse import unquote, urlparse

from grasp_bench.errors import GraspBenchError

MAX_FILE = 200_000_000
"""Largest file that is read [bytes]."""
MESH_SUFFIXES = (".glb", ".gltf", ".obj", ".dae", ".ply", ".stl")
ROBOT_SUFFIXES = (".urdf", ".xml", ".mjcf", ".xacro")
ARCHIVES = {
    b"PK\x03\x04": "ZIP",
    b"\x1f\x8b": "gzip",
    b"7z\xbc\xaf": "7z",
    b"Rar!": "RAR",
    b"BZh": "bzip2",
    b"\xfd7zX": "xz",
}
MAX_INDEX = 20_000
"""Files among which a reference is looked for by its base name."""


class RefusedError(GraspBenchError):
    """An input that is not imported; the message says why, and what would be."""


class Folder:
    """The files of one folder, as bytes.

    Args:
        root: nothing outside it is read.
        base: folder inside ``root`` that relative names start from.
    """

    def __init__(self, root: Path, base: Path | None = None) -> None:
        self.root = root.resolve()
        self.base = self.root if base is None else base.resolve()
        self.read_files: dict[str, bytes] = {}
        self.missing: set[str] = set()
        self._index: list[Path] | None = None

    def path(self, name: str) -> Path:
        """Return where a referenced file is, its name decoded as in an address.

        Raises:
            RefusedError: for a URL, an absolute path, or one that leads outside (also by a link).
        """
        return self._inside(unquote(name))

    def _inside(self, name: str) -> Path:
        plain = name.replace("\\", "/")
        if "\0" in plain:
            raise RefusedError("a file name holds a zero byte")
        if urlparse(plain).scheme or plain.startswith("//"):
            raise RefusedError(
                f"the reference {name!r} is an address or an absolute path; only files inside "
                "the imported folder are read"
            )
        path = (self.base / plain).resolve()
        if plain.startswith(("/", "~")) or not path.is_relative_to(self.root):
            raise RefusedError(
                f"the reference {name!r} leads outside the imported folder; copy that file into the folder"
            )
        return path

    def read(self, name: str, absolute: bool = False) -> bytes:
        """Read a referenced file; of one at an ``absolute`` path inside the root, if so.

        Raises:
            RefusedError: see :meth:`path`; also for what is not a plain file, or too large.
            FileNotFoundError: where there is none.
        """
        path = Path(name).resolve() if absolute else self._inside(name)
        if not absolute and not path.is_file():
            path = self.path(name)
        if not path.is_relative_to(self.root):
            raise RefusedError(f"{name!r} leads outside the imported folder")
        key = path.relative_to(self.root).as_posix()
        if key not in self.read_files:
            try:
                self.read_files[key] = read_plain(path)
            except FileNotFoundError:
                self.missing.add(key)
                raise
        return self.read_files[key]

    @property
    def asked(self) -> list[str]:
        """The files that were read or looked for in vain, relative to the root."""
        return sorted(self.missing.union(self.read_files))

    def find(self, reference: str) -> tuple[Path, str]:
        """Return the file that a reference means, and a note where it is not at the very place named.

        What leads outside, is absolute, an address, or not there is looked for by its base name,
        whatever its case: beside the file that names it, below, and then in the folder above where
        that is inside the root too.

        Raises:
            RefusedError: where it leads outside, and nothing inside has its name.
            FileNotFoundError: where there is none, or several that differ.
        """
        refusal: RefusedError | None = None
        for name in dict.fromkeys((reference, unquote(reference))):
            try:
                path = self._inside(name)
            except RefusedError as error:
                refusal = error
                continue
            if path.is_file():
                return path, ""
            self.missing.add(path.relative_to(self.root).as_posix())
        base_name = PurePosixPath(unquote(reference).replace("\\", "/")).name.lower()
        found = [p for p in self._listing() if p.name.lower() == base_name] if base_name else []
        near = [p for p in found if p.is_relative_to(self.base)] or found
        if near and len({read_plain(p) for p in near}) == 1:
            return near[0], f"{near[0].relative_to(self.root).as_posix()} taken for {reference!r}"
        if near:
            raise FileNotFoundError(f"{reference} may be any of {len(near)} files")
        if refusal is not None:
            raise refusal
        raise FileNotFoundError(reference)

    def _listing(self) -> list[Path]:
        """Return the plain files below the base, and below the folder above it where that is inside."""
        if self._index is None:
            top = self.base if self.base == self.root else self.base.parent
            self._index = []
            for folder, folders, names in os.walk(top):
                folders.sort()
                if len(Path(folder).relative_to(top).parts) >= 4:
                    folders.clear()
                paths = (Path(folder) / n for n in sorted(names))
                self._index += [p for p in paths if p.is_file() and not p.is_symlink()]
                if len(self._index) > MAX_INDEX:
                    break
        return self._index


def read_plain(path: Path) -> bytes:
    """Read a regular file of at most :data:`MAX_FILE` bytes.

    Raises:
        RefusedError: for devices, pipes, folders, archives and what is too large.
        FileNotFoundError: where there is none.
    """
    try:
        # Without waiting: a named pipe would otherwise block for ever.
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))
    except FileNotFoundError:
        raise
    except OSError as error:
        raise RefusedError(f"{path.name} cannot be read ({error.strerror})") from error
    with os.fdopen(handle, "rb") as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode):
            raise RefusedError(f"{path.name} is not a plain file")
        if status.st_size > MAX_FILE:
            raise RefusedError(
                f"{path.name} has {status.st_size / 1e6:.0f} MB; at most {MAX_FILE / 1e6:.0f} MB are read"
            )
        content = file.read(MAX_FILE + 1)
    if not content:
        raise RefusedError(f"{path.name} is empty")
    for magic, kind in ARCHIVES.items():
        if content.startswith(magic):
            raise RefusedError(f"{path.name} is a {kind} archive; unpack it and import the folder")
    return content
