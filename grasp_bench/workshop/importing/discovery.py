"""Which files of a folder are objects, what they are called, and what is left out: all of it is said."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

from grasp_bench.workshop.importing.folder import MESH_SUFFIXES, ROBOT_SUFFIXES, Folder, RefusedError
from grasp_bench.workshop.importing.naming import clean_name, plain_name, unique_names
from grasp_bench.workshop.importing.robot_xml import mesh_references

GENERIC = frozenset(
    """
    textured textured_simple textured_vertices nontextured model mesh visual object scan scene meshes
    google_16k google_64k google_512k poisson tsdf model_normalized models urdf
    """.split()
)
"""Names of files and folders that say nothing: the name of the folder above is the object's."""
MAX_DEPTH = 4
MAX_OBJECTS = 5000
OTHER_FORMATS = frozenset(
    ".fbx .3ds .off .blend .usd .usda .usdc .usdz .sdf .step .stp .3mf .wrl .x3d".split()
)
"""Formats of shapes that are not read; files of these are named where they are left out."""
SAID = 8
"""Names that a note lists at most."""


@dataclass
class Found:
    """What a folder holds.

    Attributes:
        objects: (name, file, root of what it may read) of each.
        notes: what was left out or renamed, and why.
    """

    objects: list[tuple[str, Path, Path]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def find_objects(path: Path, name: str | None = None) -> Found:
    """Find the objects in a file or folder.

    In a folder, every URDF or MJCF file is an object, and the meshes it refers to are parts of it. Where
    all meshes of a folder have names that say nothing (``textured.obj``), they are one object, called as
    the folder; otherwise every mesh is an object of its own. Where one is there in several formats, GLB is
    taken before glTF, OBJ, DAE, PLY and STL. Linked folders are not entered. Whatever is in the folder may be
    read by whatever is in it.

    Args:
        path: file or folder.
        name: what a single object is to be called.

    Raises:
        RefusedError: where there is nothing to import, or the format is not read.
    """
    if not path.exists():
        raise RefusedError(f"{path} does not exist")
    wanted = None if name is None else clean_name(name)
    if not path.is_dir():
        _check_format(path)
        return Found([(wanted or _name(path), path, path.parent)])
    walk = _Walk(path)
    walk.enter(path, 0)
    if not walk.files:
        left = f"; {'; '.join(walk.notes)}" if walk.notes else ""
        raise RefusedError(f"{path} holds no {', '.join(MESH_SUFFIXES + ROBOT_SUFFIXES)} object{left}")
    if wanted is not None:
        if len(walk.files) > 1:
            raise RefusedError(f"--name is for one object, but {path} holds {len(walk.files)}")
        return Found([(wanted, walk.files[0][1], path)], walk.notes)
    objects = unique_names(walk.files, path, walk.notes)
    return Found(objects, walk.notes)


def _check_format(path: Path) -> None:
    suffix = path.suffix.lower()
    if suffix in MESH_SUFFIXES + ROBOT_SUFFIXES:
        return
    hint = ""
    if suffix in (".zip", ".gz", ".tgz", ".tar", ".7z"):
        hint = "; unpack archives first"
    elif suffix in OTHER_FORMATS:
        hint = "; export it as GLB or OBJ"
    raise RefusedError(
        f"{path.name}: the format {suffix or '(none)'} is not read; choose "
        f"from {', '.join(MESH_SUFFIXES + ROBOT_SUFFIXES)}{hint}"
    )


class _Walk:
    """A walk over the named folder; ``files`` are (name, file) of the objects."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.files: list[tuple[str, Path]] = []
        self.notes: list[str] = []
        self.parts: set[Path] = set()
        """Resolved files that some description refers to."""
        self.robots: dict[Path, list[Path]] = {}
        self._find_robots(root, 0)

    def _find_robots(self, folder: Path, depth: int) -> None:
        for entry in _entries(folder):
            if entry.is_dir():
                if not entry.is_symlink() and depth < MAX_DEPTH:
                    self._find_robots(entry, depth + 1)
                continue
            suffix = entry.suffix.lower()
            if suffix not in ROBOT_SUFFIXES or entry.name.startswith("._"):
                continue
            tag = root_tag(entry)
            if suffix == ".urdf" or tag in ("robot", "mujoco"):
                self.robots.setdefault(folder, []).append(entry)
                self._add_parts(entry)
            else:
                kind = f"<{tag}>" if tag else "no XML"
                self.notes.append(f"{self._at(entry)}: no robot description but {kind}, left out")

    def _add_parts(self, robot: Path) -> None:
        inside = Folder(self.root, robot.parent)
        try:
            for base, reference in mesh_references(inside.read(str(robot.resolve()), absolute=True)):
                part = locate_mesh(inside, base, reference)
                if part is not None:
                    self.parts.add(part[0])
        except (RefusedError, OSError):
            pass  # said when it is imported

    def enter(self, folder: Path, depth: int) -> None:
        """Add the objects in a folder and those below."""
        entries = _entries(folder)
        files = [p for p in entries if not p.is_dir() and not p.name.startswith("._")]
        for robot in self.robots.get(folder, ()):
            self._add(_name(robot), robot)
        meshes = [p for p in files if p.suffix.lower() in MESH_SUFFIXES]
        parts = [p for p in meshes if p.resolve() in self.parts]
        free = sorted(
            (p for p in meshes if p not in parts),
            key=lambda p: (MESH_SUFFIXES.index(p.suffix.lower()), p.name),
        )
        if parts or folder in self.robots:
            # The same part in another format, or what lies beside the parts in a folder of their own.
            stems = {p.stem for p in parts} | {r.stem for r in self.robots.get(folder, ())}
            spare = [p for p in free if p.stem in stems or folder not in self.robots]
            free = [p for p in free if p not in spare]
            self._leave(spare, "no robot description refers to them", folder)
        self._add_meshes(free, folder)
        others = [p for p in files if p.suffix.lower() in OTHER_FORMATS]
        self._leave(others, "of a format that is not read", folder)
        for entry in entries:
            if entry.is_dir() and entry.is_symlink():
                self.notes.append(f"{self._at(entry)}: a linked folder, not entered")
            elif entry.is_dir() and depth < MAX_DEPTH:
                self.enter(entry, depth + 1)
            elif entry.is_dir():
                self.notes.append(f"{self._at(entry)}: more than {MAX_DEPTH} folders deep, not entered")

    def _add_meshes(self, meshes: list[Path], folder: Path) -> None:
        if not meshes:
            return
        if all(p.stem.lower() in GENERIC for p in meshes):
            textured = [p for p in meshes if p.stem.lower().startswith("textured")]
            best = (textured or meshes)[0]
            self._add(_name(best), best)
            self._leave([p for p in meshes if p != best], f"{best.name} is taken for {folder.name}", folder)
            return
        first: dict[str, Path] = {}
        for mesh in meshes:
            first.setdefault(mesh.stem, mesh)
        self._leave(
            [p for p in meshes if p not in first.values()], "another format of one that is taken", folder
        )
        for mesh in sorted(first.values()):
            self._add(plain_name(mesh.stem) or "object", mesh)

    def _add(self, name: str, path: Path) -> None:
        if len(self.files) >= MAX_OBJECTS:
            raise RefusedError(f"more than {MAX_OBJECTS} objects; import them in several folders")
        self.files.append((name, path))

    def _leave(self, paths: list[Path], why: str, folder: Path) -> None:
        if paths:
            names = sorted(p.name for p in paths)
            shown = ", ".join(names[:SAID]) + (f" and {len(names) - SAID} more" if len(names) > SAID else "")
            where = "" if folder == self.root else f"{self._at(folder)}: "
            self.notes.append(f"{where}left out {shown}: {why}")

    def _at(self, path: Path) -> str:
        return path.relative_to(self.root).as_posix()


def _entries(folder: Path) -> list[Path]:
    try:
        return sorted(p for p in folder.iterdir() if p.name not in ("__MACOSX", ".git"))
    except OSError as error:
        raise RefusedError(f"{folder} cannot be read ({error.strerror})") from error


def root_tag(path: Path) -> str:
    """Return the first element's name of an XML file, from its beginning; empty where it is none."""
    try:
        if not path.is_file():  # a pipe would block
            return ""
        with path.open("rb") as file:
            start = file.read(65_536)
    except OSError:
        return ""
    text = start.decode("utf-16" if start[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8", "replace")
    plain = re.sub(r"<!--.*?-->|<\?.*?\?>|<!DOCTYPE[^>\[]*(\[.*?\])?\s*>", "", text, flags=re.DOTALL)
    found = re.match(r"[\s\ufeff]*<\s*([A-Za-z_][\w.:-]*)", plain)
    return found[1][:60] if found else ""


def locate_mesh(folder: Folder, base: str, reference: str) -> tuple[Path, str] | None:
    """Return the mesh file inside the folder that a description means, with a note where it is not at the
    very place named; None where there is none.

    Args:
        folder: the root, and where the description is.
        base: what MJCF's ``meshdir`` or ``assetdir`` puts before names.
        reference: the name as it is written; ``package://PACKAGE/PATH`` is looked for in every folder
            from the description's up to the root, with and without the package's name.

    Raises:
        RefusedError: for a reference that leads outside, where nothing inside has its name.
    """
    if reference.startswith("package://"):
        rest = [p for p in reference.removeprefix("package://").split("/") if p]
        above = folder.base
        while True:
            for parts in (rest[1:], rest):
                path = above.joinpath(*parts).resolve()
                if path.is_file() and path.is_relative_to(folder.root):
                    return path, ""
            if above == folder.root:
                break
            above = above.parent
        reference = "/".join(rest[1:] or rest)
        base = ""
    name = f"{base}/{reference}" if base and not reference.startswith(("/", "file:")) else reference
    try:
        return folder.find(name)
    except FileNotFoundError:
        return None


def _name(path: Path) -> str:
    names = [path.name.split(".")[0] if path.suffix == ".xacro" else path.stem]
    names += [p.name for p in path.resolve().parents]
    good = next((n for n in names if n.lower() not in GENERIC and plain_name(n)), path.stem)
    return plain_name(good) or "object"
