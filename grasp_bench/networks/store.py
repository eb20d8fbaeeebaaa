"""Files of weights: where they are, whether they are those shipped, and what they say of themselves.

Nothing here imports torch; :mod:`grasp_bench.networks.weights` reads and writes the tensors.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from safetensors import SafetensorError, safe_open

from grasp_bench.errors import AssetError
from grasp_bench.system.integrity import MANIFEST, sha256, write_whole
from grasp_bench.system.paths import assets_dir, rivals_dirs

LARGEST = 12_000_000
"""Bytes from which on a weight file is packed."""
LARGEST_HERE = 6_000_000
"""Bytes beyond which a weight file is for ``grasp-bench-rivals``, so that the wheel stays below 40 MB."""
LARGEST_APART = 30_000_000
"""Bytes that a weight file may have there."""
FACTS = "grasp_bench"
"""Key in a file's header under which its metadata are, as JSON."""


@dataclass(frozen=True)
class WeightsFile:
    """A file of weights, and what can be said of it without its tensors.

    Attributes:
        path: ``….safetensors``; it may be missing.
        network: the network they are of, where that is known.
    """

    path: Path
    network: str = "htc-grasp"

    @property
    def name(self) -> str:
        """Name of the file."""
        return self.path.name

    @property
    def card(self) -> str:
        """Where the model card of shipped weights is to be read, for messages."""
        folder = "assets/weights" if self._here else "rivals/grasp_bench_rivals/weights"
        return f"{folder}/{self.path.stem}.md"

    @property
    def _here(self) -> bool:
        """Whether it belongs to what grasp-bench itself is shipped with."""
        return self.path.parent == assets_dir() / "weights"

    @property
    def present(self) -> bool:
        """Whether the file is there."""
        return self.path.is_file()

    @property
    def digest(self) -> str | None:
        """Hex SHA-256 of the file; None where it is missing."""
        return sha256(self.path) if self.present else None

    def require(self) -> None:
        """Refuse a file that is missing with an AssetError that says how to get it."""
        if not self.present:
            large = (
                "`pip install grasp-bench-rivals` if they are among its large ones, " if self._here else ""
            )
            raise AssetError(
                f"Weights {self.path} are missing; {large}name a .safetensors file that is there, or train "
                "them: `grasp-bench data synth --scenes 2000 --out scenes` makes scenes, and `grasp-bench "
                f"train --predictor {self.network} --data scenes --out runs/mine` writes "
                f"runs/mine/{self.network}.safetensors."
            )

    def described(self) -> str:
        """Return name and first digits of the SHA-256; AssetError when the file is missing."""
        self.require()
        return f"{self.name} {sha256(self.path)[:16]}"

    def intact(self) -> bool:
        """Compare the file with the manifest beside it.

        Returns:
            whether the manifest lists it, and it is as listed.

        Raises:
            AssetError: when it differs, or the manifest is not readable.
        """
        manifest = self.path.with_name(MANIFEST)
        if not (manifest.is_file() and self.present):
            return False
        try:
            expected = json.loads(manifest.read_text(encoding="utf-8")).get(self.name)
        except (ValueError, AttributeError) as error:
            raise AssetError(
                f"{manifest} is not a JSON object of file: sha256 ({error}); restore it."
            ) from error
        if expected is not None and sha256(self.path) != expected:
            raise AssetError(
                f"{self.path} does not have the SHA-256 in {manifest.name} ({str(expected)[:9]}…): "
                f"it was altered or only partly fetched; restore it, e.g. reinstall grasp-bench."
            )
        return expected is not None

    def enter_in_manifest(self) -> None:
        """Record the file's SHA-256 in the manifest beside it."""
        manifest = self.path.with_name(MANIFEST)
        known = json.loads(manifest.read_text(encoding="utf-8")) if manifest.is_file() else {}
        known[self.name] = sha256(self.path)
        write_whole(manifest, (json.dumps(known, indent=2, sort_keys=True) + "\n").encode())

    @contextmanager
    def opened(self, framework: str) -> Iterator[tuple[Any, dict[str, Any]]]:
        """Open the file of safetensors, for tensors of ``framework``, and give it with the metadata in it.

        Raises:
            AssetError: the file is missing or damaged, also where that shows while it is open.
        """
        self.require()
        try:
            with safe_open(self.path, framework=framework) as file:
                metadata = json.loads((file.metadata() or {}).get(FACTS, "{}"))
                if not isinstance(metadata, dict):
                    raise ValueError(f"its metadata {FACTS!r} is no JSON object")
                yield file, metadata
        except (SafetensorError, OSError, ValueError, RecursionError) as error:
            raise AssetError(
                f"{self.path} is truncated or not a safetensors file ({error}); fetch or train it again."
            ) from error

    def metadata(self) -> dict[str, Any]:
        """Return the facts stored with the weights; AssetError where the file is missing or damaged."""
        with self.opened("numpy") as (_, metadata):
            return metadata


def shipped_file(name: str, network: str = "") -> WeightsFile:
    """Return the file of the weights shipped under ``name``, by default of the network of that name.

    It is the package's own, or where that is not there, one of ``grasp-bench-rivals``.
    """
    own = WeightsFile(assets_dir() / "weights" / f"{name}.safetensors", network or name)
    places = [] if own.present else [folder / own.name for folder in rivals_dirs()]
    return replace(own, path=next((place for place in places if place.is_file()), own.path))


def place_to_ship(name: str, size: int) -> WeightsFile:
    """Return where the weights ``name`` belong, of ``size`` bytes.

    Raises:
        AssetError: when they are for ``grasp-bench-rivals``, whose folder is not there, or too large for it.
    """
    own = WeightsFile(assets_dir() / "weights" / f"{name}.safetensors", name)
    if size <= LARGEST_HERE:
        return own
    apart = next(iter(rivals_dirs()), None)
    if size > LARGEST_APART or apart is None:
        why = f"which takes {LARGEST_APART:,}" if size > LARGEST_APART else "and no folder of that is here"
        raise AssetError(
            f"{own.name} has {size:,} bytes, and only {LARGEST_HERE:,} may travel with grasp-bench; "
            f"larger ones are for grasp-bench-rivals, {why}. Give the file with --weights."
        )
    return replace(own, path=apart / own.name)


def stored_input(metadata: dict[str, Any]) -> str | None:
    """Return 'rgbd', 'rgb' or 'depth' as the weights' metadata say; None where they do not."""
    return str(metadata["input"]).split()[0] if metadata.get("input") else None
