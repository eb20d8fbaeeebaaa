"""``grasp-bench objects grasps``: reference grasps from any direction, as an isaac_grasp file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def grasps_command(
    name: Annotated[str, typer.Argument(help="An object's name.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="YAML file to write.")],
    folder: Annotated[
        Path | None, typer.Option("--folder", help="A folder of objects; the shipped 180 by default.")
    ] = None,
    pose: Annotated[int, typer.Option(min=0, help="Number of the resting pose, from 0.")] = 0,
    gripper: Annotated[str, typer.Option(help="A gripper's name, or its folder.")] = "parallel-85",
) -> None:
    """Write the grasps that held in physics, from any direction, in NVIDIA's isaac_grasp format.

    They are worked out when first asked for (seconds), and kept in the cache.
    Example: grasp-bench objects grasps coffee_mug --out coffee_mug.yaml
    """
    from grasp_bench.errors import AssetError
    from grasp_bench.objects.catalog import Catalog
    from grasp_bench.objects.isaac_grasp import write_isaac_grasps
    from grasp_bench.predictors.reference import reference_poses
    from grasp_bench.robot.grippers import load_gripper

    hand, model = load_gripper(gripper), Catalog(folder).load(name)
    if pose >= len(model.poses):
        raise AssetError(f"{name} has {len(model.poses)} resting poses, counted from 0; there is no {pose}.")
    grasps = [grasp for grasp, _ in reference_poses(model, pose, hand)]
    write_isaac_grasps(out, grasps, hand, name)
    typer.echo(f"{len(grasps)} grasps of {name} in pose {pose} in {out}.")
