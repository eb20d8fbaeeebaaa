"""The OpenGL that MuJoCo may use, chosen before MuJoCo is imported.

MuJoCo binds to a graphics library when it is imported, by the environment variable
``MUJOCO_GL``, and fails there and then where that library is broken. grasp-bench measures
without OpenGL, so its commands keep it off unless they draw with it.
"""

from __future__ import annotations

import ctypes
import os
import sys
from contextlib import suppress

from grasp_bench.errors import GraspBenchError, UnknownNameError

VARIABLE = "MUJOCO_GL"
RENDERERS: tuple[str, ...] = ("auto", "raycast", "egl", "osmesa")
LIBRARIES = {"egl": "libEGL.so.1", "osmesa": "libOSMesa.so.8"}


def resolve_renderer(name: str) -> str:
    """Return the renderer that ``name`` stands for on this machine.

    Raises:
        UnknownNameError: for a name that is not in :data:`RENDERERS`.
    """
    if name not in RENDERERS:
        raise UnknownNameError("renderer", name, RENDERERS)
    return "raycast" if name == "auto" else name


def without_gl() -> None:
    """Keep MuJoCo from loading a graphics library, unless the user chose one."""
    os.environ.setdefault(VARIABLE, "off")


def prepare(renderer: str) -> None:
    """Have MuJoCo load the graphics library that a renderer draws with, and none where it needs none.

    Raises:
        GraspBenchError: as :func:`with_gl`.
    """
    if renderer in LIBRARIES:
        with_gl(renderer)
    without_gl()


def available() -> list[str]:
    """Return the off-screen backends whose library is installed."""
    found = []
    for name, library in LIBRARIES.items():
        with suppress(OSError):
            ctypes.CDLL(library)
            found.append(name)
    return found


def with_gl(backend: str | None = None) -> str:
    """Have MuJoCo draw off-screen with ``backend``, or with the first that is installed.

    Raises:
        GraspBenchError: when there is none, or MuJoCo is bound to another already.
    """
    chosen = os.environ.get(VARIABLE, "").lower()
    if chosen in ("", "off") and "mujoco" not in sys.modules:
        found = available()
        if backend not in found and (backend is not None or not found):
            raise GraspBenchError(
                f"OpenGL by {backend or 'EGL or OSMesa'} is not installed here (Debian: "
                "libegl1 or libosmesa6); --renderer raycast needs neither."
            )
        chosen = os.environ[VARIABLE] = backend or found[0]
    if chosen not in LIBRARIES or (backend is not None and chosen != backend):
        raise GraspBenchError(
            f"MuJoCo was started with {VARIABLE}={chosen or '(unset)'}; set "
            f"{VARIABLE}={backend or 'egl'} before Python starts."
        )
    return chosen
