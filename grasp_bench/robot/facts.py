"""Facts of a robot's parts as their makers state them: a YAML file in the part's folder.

A part is a folder with ``gripper.yaml`` or ``arm.yaml`` and the MJCF that it names. Everything that the part
is made of lies inside that folder. What geometry tells is not in the file; it is measured from the model.
"""

from __future__ import annotations

import hashlib
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any, TypeVar

from defusedxml import ElementTree as SafeTree
from defusedxml.common import DefusedXmlException
from pydantic import BaseModel, ConfigDict, ValidationError

from grasp_bench.errors import AssetError, UnknownNameError
from grasp_bench.system.files import read_text
from grasp_bench.system.paths import assets_dir
from grasp_bench.system.yaml_text import read_yaml

MAX_YAML = 100_000
MAX_XML = 5_000_000
"""Most bytes of a part's YAML and of its MJCF."""
MAX_FOLDER = 200_000_000
MAX_FILES = 2000
"""Most bytes and files of a part's folder."""
FOREIGN = frozenset("include plugin extension attach model flexcomp flex skin hfield composite".split())
"""Elements of MJCF that pull in other files or code, or are none of a rigid part's."""

BESIDE = {"ec66": "ec66", "parallel-85": "ec66"}
"""Shipped parts whose folder below the assets has another place than ``arms/NAME`` or ``grippers/NAME``."""


class Facts(BaseModel):
    """Validated content of a part's file: frozen, no unknown keys, no NaN, no infinity."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


F = TypeVar("F", bound=Facts)


def shipped(kind: str) -> list[str]:
    """Return the names of the shipped parts of a ``kind``, ``arm`` or ``gripper``, sorted."""
    beside = [n for n, folder in BESIDE.items() if kind == ("arm" if n == folder else "gripper")]
    return sorted({*beside, *(p.parent.name for p in (assets_dir() / f"{kind}s").glob(f"*/{kind}.yaml"))})


def name_beside(kind: str, name: str) -> str:
    """Return how a scenario in the working directory names a part: paths have a slash, shipped names none."""
    return name if name in shipped(kind) or "/" in name or "\\" in name else f"./{name}"


def folder_of(kind: str, name: str) -> Path:
    """Return the folder of a shipped part by name, or of anyone's by path.

    A name with a slash, or that of a folder with the part's file, is a path.

    Raises:
        UnknownNameError: for a name that is neither.
        AssetError: for a path without the part's file.
    """
    if name in shipped(kind):
        return assets_dir() / (BESIDE.get(name) or f"{kind}s/{name}")
    path = Path(name)
    if path.name == f"{kind}.yaml":
        path = path.parent
    if (path / f"{kind}.yaml").is_file():
        return path
    if "/" in name or "\\" in name or path.exists():
        raise AssetError(
            f"{name} is no folder with {kind}.yaml; make one of your model with "
            f"`grasp-bench {kind}s import MODEL.xml --out FOLDER`, or see docs/robots.md."
        )
    raise UnknownNameError(kind, name, shipped(kind))


def kind_of(path: Path) -> str:
    """Return what a part's YAML file says of its ``kind``; empty where it says nothing.

    Raises:
        AssetError: for a file that cannot be read as YAML.
    """
    content = _content(path)
    return str(content.get("kind", "")) if isinstance(content, dict) else ""


def read(path: Path, kind: type[F]) -> F:
    """Read and validate a part's YAML file.

    Raises:
        AssetError: in one line, naming the file, the key and what is wrong with it.
    """
    content = _content(path)
    try:
        return kind.model_validate(content)
    except ValidationError as error:
        wrong = "; ".join(
            f"{'.'.join(str(k) for k in e['loc']) or 'the file'}: {e['msg']}" for e in error.errors()[:4]
        )
        valid = ", ".join(kind.model_fields)
        raise AssetError(f"{path}: {wrong}. Keys are {valid}; docs/robots.md explains them.") from error


def _content(path: Path) -> Any:
    try:
        if path.stat().st_size > MAX_YAML:
            raise AssetError(f"{path} is larger than {MAX_YAML // 1000} kB; it holds a few facts only.")
        return read_yaml(read_text(path))
    except (OSError, ValueError) as error:
        raise AssetError(f"{path} cannot be read as YAML ({' '.join(str(error).split())}).") from error


def files(folder: Path) -> list[Path]:
    """Return all files of a part's folder, sorted.

    Raises:
        AssetError: for a folder that is too large for a part of a robot.
    """
    found, size = [], 0
    for path in folder.rglob("*"):
        if path.is_file():
            found.append(path)
            size += path.stat().st_size
        if len(found) > MAX_FILES or size > MAX_FOLDER:
            raise AssetError(
                f"{folder} holds more than {MAX_FILES} files or {MAX_FOLDER // 10**6} MB; "
                "keep a robot's part in a folder of its own."
            )
    return sorted(found)


def digest(folder: Path) -> str:
    """Return the SHA-256 over names and content of all files of a part's folder."""
    found = hashlib.sha256()
    for path in files(folder):
        found.update(f"{path.relative_to(folder).as_posix()}|{path.stat().st_size}|".encode())
        found.update(path.read_bytes())
    return found.hexdigest()


def model_file(folder: Path, name: str) -> Path:
    """Return a part's MJCF, after looking that neither it nor what it names lies outside of ``folder``.

    Raises:
        AssetError: naming what is missing, outside, or not read.
    """
    path = _inside(folder, folder, name, "the model")
    tree = parse(path)
    if tree.tag != "mujoco":
        raise AssetError(f"{path} is not MJCF (<mujoco>), but <{str(tree.tag)[:40]}>.")
    compiler: dict[str, str] = {}
    for element in tree.findall("compiler"):
        compiler |= dict(element.items())
    base = path.parent
    for element in tree.iter():
        where = compiler.get("meshdir" if element.tag == "mesh" else "texturedir") or compiler.get("assetdir")
        for key, value in element.items():
            if key.startswith("file") and element.tag in ("mesh", "texture"):
                file = Path(value).name if compiler.get("strippath") == "true" else value
                _inside(folder, base / (where or ""), file, f"<{element.tag}> of {path.name}")
    return path


def parse(path: Path) -> ET.Element:
    """Parse a part's XML safely.

    Raises:
        AssetError: for what is too large, no XML, or pulls in what is not in the file.
    """
    try:
        if path.stat().st_size > MAX_XML:
            raise AssetError(f"{path} is larger than {MAX_XML // 10**6} MB of XML.")
        tree = SafeTree.fromstring(path.read_bytes(), forbid_dtd=True)
    except DefusedXmlException as error:
        raise AssetError(f"{path} declares entities or a document type, which are not read.") from error
    except (OSError, ET.ParseError, ValueError, RecursionError) as error:
        raise AssetError(f"{path} cannot be read as XML ({error}).") from error
    for element in tree.iter():
        if unset := [
            key for key, value in element.items() if key != "name" and "nan" in value.lower().split()
        ]:
            raise AssetError(f"{path} has a <{element.tag}> whose {unset[0]} is not a number (nan).")
        if element.tag in FOREIGN:
            raise AssetError(
                f"{path} uses <{element.tag}>, which is not read: write the part whole into one MJCF file "
                "(MuJoCo's `simulate` saves it so: Save xml)."
            )
    return tree


def _inside(folder: Path, base: Path, name: str, what: str) -> Path:
    path, root = (base / name).resolve(), folder.resolve()
    if not path.is_relative_to(root):
        raise AssetError(f"{what} names {name}, which lies outside of {folder}; copy it into the folder.")
    if not path.is_file():
        raise AssetError(f"{what} names {name}, which is not in {folder.resolve()}.")
    return path
