"""Objects at rest, and how a camera sees them, kept in the cache for other predictors and later runs.

What is kept is what would come out, to the bit: an entry's name is a digest of all that it depends on. One
that is damaged is made again.
"""

from __future__ import annotations

import hashlib
import platform
import zlib
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError
from safetensors.numpy import load as from_bytes
from safetensors.numpy import save as to_bytes

from grasp_bench.scene.world import INTEGRATION, LAST, World
from grasp_bench.system import cache

Arrays = dict[str, NDArray]
REST, SEEN = cache.AT_REST
_CODE = ("kept", "world", "rendering", "surfaces")
"""Modules beside this one that decide what is kept, besides those that decide a world's model."""
_CHECK = 4
"""Bytes of the checksum before the arrays."""


def settle(world: World, scene: str) -> None:
    """Bring the objects of a world to rest by :meth:`World.settle`, or put them where it brought them before.

    Args:
        world: with the objects put down.
        scene: digest of the world's model.

    Raises:
        UnstableError: as :meth:`World.settle`; that is kept of no world.
    """
    limits = world.scenario.settling.model_dump_json().encode()
    path = _path(REST, scene, limits + world.integration.tobytes())
    if (found := _read(path)) is not None:
        mujoco.mj_setState(world.model, world.data, found["before"], INTEGRATION)
        world.step(LAST)  # what follows from a state, such as poses and contacts, is one step behind it
        world.steps += found["steps"].item() - LAST
        return
    steps = world.steps
    before = world.settle()
    _write(path, {"before": before, "steps": np.array([world.steps - steps])})


def seen(scene: str, view: bytes, look: Callable[[], Arrays]) -> Arrays:
    """Return what a camera sees, looking only where that is not kept.

    Args:
        scene: digest of the world's model.
        view: all that it depends on besides.
        look: looks.
    """
    path = _path(SEEN, scene, view)
    if (found := _read(path)) is not None:
        return found
    made = look()
    _write(path, made)
    return made


def _path(kind: str, scene: str, state: bytes) -> Path:
    digest = hashlib.sha256(f"{_fixed_digest()}|{scene}|".encode() + state)
    return cache.folder() / f"{digest.hexdigest()[:32]}{kind}"


@lru_cache
def _fixed_digest() -> str:
    """Digest what no trial of a process changes: versions, the kind of machine, and the code at work."""
    digest = hashlib.sha256(f"{mujoco.__version__}|{np.__version__}|{platform.machine()}|".encode())
    for name in _CODE:
        digest.update(Path(__file__).with_name(f"{name}.py").read_bytes())
    return digest.hexdigest()


def _read(path: Path) -> Arrays | None:
    """Return what is kept; None where it is not there or damaged."""
    if not cache.used(path):
        return None
    try:
        content = path.read_bytes()
        if zlib.crc32(content[_CHECK:]).to_bytes(_CHECK, "little") != content[:_CHECK]:
            return None
        return from_bytes(content[_CHECK:])
    except (OSError, SafetensorError):  # another process may have removed it meanwhile
        return None


def _write(path: Path, arrays: Arrays) -> None:
    if cache.limit():
        content = to_bytes({name: np.ascontiguousarray(values) for name, values in arrays.items()})
        check = zlib.crc32(content).to_bytes(_CHECK, "little")
        cache.put(path, lambda fresh: fresh.write_bytes(check + content))
