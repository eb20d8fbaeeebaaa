"""Whether files are those that were shipped: SHA-256, and the manifest of the weights."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path

from grasp_bench.errors import AssetError
from grasp_bench.system.paths import assets_dir

MANIFEST = "manifest.json"


def sha256(path: Path) -> str:
    """Hex digest of a file's bytes."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def weights_path(network: str) -> Path:
    """Where the shipped weights of a network lie."""
    return assets_dir() / "weights" / f"{network}.safetensors"


def missing_weights(path: Path) -> AssetError:
    """What to say of weights that are not there."""
    return AssetError(
        f"Weights {path} are missing; train them with `grasp-bench train --predictor "
        f"{path.stem} --export`, or give the path of a .safetensors file."
    )


def check_manifest(path: Path) -> bool:
    """Compares a file with the manifest beside it.

    Returns:
        whether the manifest lists it, and it is as listed.

    Raises:
        AssetError: when it differs, or the manifest is not readable.
    """
    manifest = path.with_name(MANIFEST)
    if not (manifest.is_file() and path.is_file()):
        return False
    try:
        expected = json.loads(manifest.read_text(encoding="utf-8")).get(path.name)
    except (ValueError, AttributeError) as error:
        raise AssetError(f"{manifest} is not a JSON object of file: sha256 ({error}); restore it.") from error
    if expected is not None and sha256(path) != expected:
        raise AssetError(
            f"{path} does not have the SHA-256 in {manifest.name} ({str(expected)[:9]}…): "
            f"it was altered or only partly fetched; restore it, e.g. reinstall grasp-bench."
        )
    return expected is not None


def add_to_manifest(path: Path) -> None:
    """Records the SHA-256 of ``path`` in the manifest beside it."""
    manifest = path.with_name(MANIFEST)
    known = json.loads(manifest.read_text(encoding="utf-8")) if manifest.is_file() else {}
    known[path.name] = sha256(path)
    manifest.write_text(json.dumps(known, indent=2, sort_keys=True) + "\n", encoding="utf-8")


def write_whole(path: Path, content: bytes) -> None:
    """Writes a file at once or not at all: a kill leaves the old one."""
    partial = path.with_name(path.name + ".part")
    with partial.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    os.replace(partial, path)
