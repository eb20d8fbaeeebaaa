"""Reading files that somebody else wrote: sizes, kinds and places are checked before any parser sees them.

A mesh may name other files (materials, textures, convex parts). They are read only from inside
the folder that is imported, whatever the names say; nothing is fetched, unpacked or followed out.
"""

from __future__ import annotations

import io
import os
import stat
import warnings
from pathlib import Path
from urllib.parse import unquote, urlparse

from PIL import Image

from grasp_bench.errors import GraspBenchError

MAX_FILE = 200_000_000
"""Largest file that is read [bytes]."""
MAX_PIXELS = 8192 * 8192
"""Largest texture."""
IMAGE_FORMATS = ("PNG", "JPEG", "BMP", "TGA", "WEBP")
MESH_SUFFIXES = (".glb", ".obj", ".ply", ".stl")
ROBOT_SUFFIXES = (".urdf", ".xml", ".mjcf")
ARCHIVES = {
    b"PK\x03\x04": "ZIP",
    b"\x1f\x8b": "gzip",
    b"7z\xbc\xaf": "7z",
    b"Rar!": "RAR",
    b"BZh": "bzip2",
    b"\xfd7zX": "xz",
}
GENERIC = frozenset(
    """
    textured textured_simple textured_vertices nontextured model mesh visual object scan scene meshes
    google_16k google_64k google_512k poisson tsdf
    """.split()
)
"""Names of files and folders that say nothing: the name of the folder above is the object's."""


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

    def path(self, name: str) -> Path:
        """Return where a referenced file is.

        Raises:
            RefusedError: for a URL, an absolute path, or one that leads outside (also by a link).
        """
        plain = unquote(name).replace("\\", "/")
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
        path = Path(name).resolve() if absolute else self.path(name)
        if not path.is_relative_to(self.root):
            raise RefusedError(f"{name!r} leads outside the imported folder")
        key = path.relative_to(self.root).as_posix()
        if key not in self.read_files:
            self.read_files[key] = read_plain(path)
        return self.read_files[key]


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


def check_image(content: bytes, name: str) -> None:
    """Refuse what is not a picture, or too large a one, from its header alone.

    Raises:
        RefusedError: with the reason.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)  # refused below
            with Image.open(io.BytesIO(content), formats=IMAGE_FORMATS) as picture:
                width, height = picture.size
    except Image.DecompressionBombError as error:
        raise RefusedError(
            f"the texture {name} is too large; at most {MAX_PIXELS} pixels are read"
        ) from error
    except Exception as error:
        raise RefusedError(
            f"the texture {name} is not a readable picture ({', '.join(IMAGE_FORMATS)})"
        ) from error
    if width * height > MAX_PIXELS:
        raise RefusedError(f"the texture {name} has {width} × {height} pixels; at most {MAX_PIXELS} are read")


MAX_DEPTH = 4
MAX_OBJECTS = 5000


def find_objects(path: Path) -> list[tuple[str, Path, Path]]:
    """Return the objects in a file or folder as (name, file, root of what it may read).

    In a folder, a URDF or MJCF file stands for the whole folder, as does a mesh with a name that
    says nothing (``textured.obj``; the folder's name is the object's); otherwise every mesh is an
    object of its own. Where one object is there in several formats, GLB is taken before OBJ, PLY
    and STL. Linked folders are not entered.

    Raises:
        RefusedError: where there is nothing to import, or the format is not read.
    """
    if not path.exists():
        raise RefusedError(f"{path} does not exist")
    if not path.is_dir():
        if path.suffix.lower() not in MESH_SUFFIXES + ROBOT_SUFFIXES:
            packed = path.suffix.lower() in (".zip", ".gz", ".tgz", ".tar", ".7z")
            hint = "; unpack archives first" if packed else ""
            raise RefusedError(
                f"{path.name}: the format {path.suffix or '(none)'} is not read; choose "
                f"from {', '.join(MESH_SUFFIXES + ROBOT_SUFFIXES)}{hint}"
            )
        return [(_name(path), path, path.parent)]
    found: list[tuple[str, Path, Path]] = []
    _walk(path, found, 0)
    if not found:
        raise RefusedError(f"{path} holds no {', '.join(MESH_SUFFIXES + ROBOT_SUFFIXES)} file")
    return _unique(found)


def _walk(folder: Path, found: list[tuple[str, Path, Path]], depth: int) -> None:
    if len(found) > MAX_OBJECTS:
        raise RefusedError(f"more than {MAX_OBJECTS} objects; import them in several folders")
    entries = sorted(folder.iterdir())
    files = [p for p in entries if not p.is_dir()]
    robots = [p for p in files if p.suffix.lower() in ROBOT_SUFFIXES]
    meshes = sorted(
        (p for p in files if p.suffix.lower() in MESH_SUFFIXES),
        key=lambda p: (MESH_SUFFIXES.index(p.suffix.lower()), p.name),
    )
    if robots:
        found += [(_name(p), p, folder) for p in robots]
        return  # its meshes are parts of it
    generic = [p for p in meshes if p.stem.lower() in GENERIC]
    if generic:
        textured = [p for p in generic if p.stem.lower().startswith("textured")]
        best = (textured or generic)[0]
        found.append((_name(best), best, folder))
    else:
        first = {p.stem.lower(): p for p in reversed(meshes)}
        found += [(_name(p), p, folder) for p in sorted(first.values())]
    for entry in entries:
        if entry.is_dir() and not entry.is_symlink() and depth < MAX_DEPTH:
            _walk(entry, found, depth + 1)


def _name(path: Path) -> str:
    names = [path.stem, *(p.name for p in path.resolve().parents)]
    return clean_name(next((n for n in names if n.lower() not in GENERIC), path.stem))


def clean_name(name: str) -> str:
    """Make a folder name of ``name``: lower case letters, digits and underscores, at most 60.

    Raises:
        RefusedError: where nothing is left.
    """
    letters = "".join(c if c.isascii() and c.isalnum() else "_" for c in name.lower()).strip("_")[:60]
    if not letters:
        raise RefusedError(f"{name!r} makes no name; give one with --name")
    return letters


def _unique(found: list[tuple[str, Path, Path]]) -> list[tuple[str, Path, Path]]:
    """Put their folder's name before objects of one name, then a number behind."""
    names = [n for n, _, _ in found]
    taken: set[str] = set()
    result = []
    for name, path, root in found:
        label = name
        if names.count(name) > 1:
            label = clean_name(f"{path.resolve().parent.name}_{name}")
        base, i = label, 1
        while label in taken:
            i += 1
            label = f"{base}_{i}"
        taken.add(label)
        result.append((label, path, root))
    return result
