"""The description of a run that begins here, for ``run.json``."""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path
from typing import Any

from grasp_bench.objects.catalog import Catalog
from grasp_bench.predictors.names import parse
from grasp_bench.robot.robot import EC66_PARALLEL_85
from grasp_bench.runs.info import RunInfo
from grasp_bench.runs.jobs import WHOLE, Jobs, Settings
from grasp_bench.system.machine import cpu_name

PINNED = (
    "grasp-bench",
    "mujoco",
    "dm-control",
    "mink",
    "numpy",
    "scipy",
    "torch",
    "opencv-python-headless",
    "trimesh",
)
"""Distributions whose versions can change a result."""


NUMERIC = (
    "ONEDNN_MAX_CPU_ISA",
    "DNNL_MAX_CPU_ISA",
    "ONEDNN_DEFAULT_FPMATH_MODE",
    "ATEN_CPU_CAPABILITY",
    "MKL_CBWR",
    "MKL_ENABLE_INSTRUCTIONS",
    "MKL_DEBUG_CPU_TYPE",
    "OPENBLAS_CORETYPE",
    "NPY_DISABLE_CPU_FEATURES",
    "NPY_ENABLE_CPU_FEATURES",
    "OPENCV_CPU_DISABLE",
    "OPENCV_IPP",
    "GLIBC_TUNABLES",
    "CUDA_VISIBLE_DEVICES",
    "CUBLAS_WORKSPACE_CONFIG",
    "NVIDIA_TF32_OVERRIDE",
    "TORCH_ALLOW_TF32_CUBLAS_OVERRIDE",
)
"""Environment variables by which libraries choose instructions or precision: results may differ by them."""


def objects_of(settings: Settings, jobs: Jobs, catalog: Catalog) -> list[str]:
    """Return all objects that a run may meet: those of its jobs, or of clutter those that it draws from."""
    if settings.scenario.clutter is not None:
        return catalog.chosen(settings.scenario.objects.names)
    return jobs.used


def describe(
    settings: Settings, jobs: Jobs, catalog: Catalog, implementation: dict[str, Any] | None = None
) -> RunInfo:
    """Return the content of ``run.json``; ``implementation`` is what :func:`identify` returns."""
    weights = parse(settings.predictor).weights
    robot = settings.scenario.robot.loaded
    return RunInfo(
        command=("grasp-bench", *sys.argv[1:]),
        predictor=settings.predictor,
        implementation=implementation,
        scenario=settings.scenario.model_dump(mode="json"),
        seed=settings.seed,
        trials=jobs.total,
        shard=None if jobs.shard == WHOLE else str(jobs.shard),
        objects={n: catalog.entries[n]["files"] for n in objects_of(settings, jobs, catalog)},
        weights=None if weights is None else {weights.name: weights.digest},
        robot=None if robot == EC66_PARALLEL_85 else robot.described,
        versions={name: version(name) for name in PINNED},
        renderer=settings.renderer,
        python=platform.python_version(),
        platform=f"{platform.system()} {platform.machine()}",
        cpu=cpu_name(),
        git=_git_revision(),
        environment=_environment(),
        apart=parse(settings.predictor).apart,
    )


def _environment() -> dict[str, str] | None:
    """Return the environment variables that are set and may change the last digits of a result."""
    return {name: os.environ[name] for name in NUMERIC if name in os.environ} or None


def _git_revision() -> str | None:
    try:
        head = subprocess.run(
            ["git", "describe", "--always", "--dirty", "--abbrev=12"],
            cwd=Path(__file__).parent,
            text=True,
            capture_output=True,
            timeout=10,
            check=True,
        ).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return None
    return head or None
