"""Checks of machine and installation: what could make numbers differ, and whether files are intact."""

from __future__ import annotations

import os
import platform
import re
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version

from grasp_bench.doctor.checks import Check, State
from grasp_bench.errors import AssetError
from grasp_bench.execution.describe import PINNED
from grasp_bench.networks.registry import all_weights
from grasp_bench.networks.store import shipped_file
from grasp_bench.objects.catalog import Catalog
from grasp_bench.system import cache
from grasp_bench.system.graphics import VARIABLE, available
from grasp_bench.system.machine import cpu_name, usable_cores
from grasp_bench.system.paths import constraints_file


def check_environment() -> list[Check]:
    """Return all that can be said without running a trial."""
    return [_python(), _machine(), *_versions(), _graphics(), _cache(), _objects(), _weights()]


def tested_versions() -> dict[str, str]:
    """Return the versions of the tested stack by normalised name; AssetError when their list is missing."""
    lines = constraints_file().read_text(encoding="utf-8").splitlines()
    pairs = [line.split("#")[0].strip().split("==") for line in lines]
    return {normalised(p[0]): p[1] for p in pairs if len(p) == 2}


def normalised(name: str) -> str:
    """Return a distribution's name as package indexes compare it (PEP 503)."""
    return re.sub(r"[-_.]+", "-", name).lower()


def _python() -> Check:
    return Check(
        "Python", State.OK, f"{platform.python_version()} on {platform.system()} {platform.machine()}"
    )


def _machine() -> Check:
    detail = f"{usable_cores()} cores of {cpu_name()}"
    with suppress(ValueError, OSError, AttributeError):
        memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
        detail += f", {memory / 2**30:.1f} GiB of memory"
    return Check("Machine", State.OK, detail)


def _versions() -> list[Check]:
    try:
        tested = tested_versions()
    except AssetError as error:
        return [Check("Tested stack", State.BAD, str(error))]
    checks, same = [], []
    for name in PINNED:
        wanted = tested.get(normalised(name))
        try:
            found = version(name)
        except PackageNotFoundError:
            checks.append(Check(name, State.BAD, "not installed"))
            continue
        if wanted is None or _public(found) == _public(wanted):
            same.append(f"{name} {found}")
        else:
            checks.append(
                Check(
                    name,
                    State.NOTE,
                    f"{found}, tested with {wanted}: rates remain valid, but "
                    "records need not be byte-identical to published ones",
                )
            )
    return [Check("Tested stack", State.OK, ", ".join(same)), *checks]


def _public(text: str) -> str:
    """Return a version without its local part: ``2.13.0+cpu`` and ``2.13.0`` are the same release."""
    return text.partition("+")[0]


def _graphics() -> Check:
    libraries = available()
    detail = (
        f"raycast (what auto means), {', '.join(libraries)}"
        if libraries
        else "raycast (what auto means); no off-screen OpenGL, so no pictures, films or --renderer egl/osmesa"
    )
    if chosen := os.environ.get(VARIABLE, ""):
        detail += f"; {VARIABLE}={chosen}"
    return Check("Renderers", State.OK if libraries else State.NOTE, detail)


def _cache() -> Check:
    folder, state = cache.folder(), State.NOTE
    try:
        folder.mkdir(parents=True, exist_ok=True)
        files = [f.stat().st_size for f in folder.iterdir() if f.is_file()]
        if os.access(folder, os.W_OK):
            state, detail = State.OK, f"{folder}, {len(files)} models, {sum(files) / 1e6:.0f} MB"
        else:
            detail = f"{folder} is read-only: scenes that are not in it are compiled anew each time"
    except OSError as error:
        detail = (
            f"{folder} cannot be used ({error.strerror}): every trial compiles its scene anew, which is slow"
        )
    return Check("Model cache", state, detail)


def _objects() -> Check:
    try:
        catalog = Catalog()
    except AssetError as error:
        return Check("Objects", State.BAD, str(error))
    faults = [f for name in catalog.entries for f in catalog.faults(name)]
    if faults:
        more = f" and {len(faults) - 3} more" if len(faults) > 3 else ""
        return Check("Objects", State.BAD, f"{'; '.join(faults[:3])}{more}. Restore the files.")
    return Check("Objects", State.OK, f"{len(catalog.entries)}, every file as the manifest says")


def _weights() -> Check:
    needed = sorted(map(shipped_file, all_weights()), key=lambda file: file.path)
    missing = [file.name for file in needed if not file.present]
    altered = []
    for file in needed:
        try:
            file.intact()
        except AssetError as error:
            altered.append(str(error))
    if altered:
        return Check("Weights", State.BAD, " ".join(altered))
    if missing:
        return Check("Weights", State.NOTE, f"not there: {', '.join(missing)}")
    digests = ", ".join(f"{file.name} {str(file.digest)[:9]}…" for file in needed)
    return Check("Weights", State.OK, digests)
