"""Grippers by name or path."""

from __future__ import annotations

from functools import lru_cache

from grasp_bench.robot.cup import SuctionCup
from grasp_bench.robot.facts import folder_of, kind_of, read
from grasp_bench.robot.gripper import Gripper
from grasp_bench.robot.gripper_file import GripperFile, SuctionFile


@lru_cache
def load_gripper(name: str) -> Gripper:
    """Load a gripper: a shipped one by name, or anyone's by the path of its folder.

    Raises:
        UnknownNameError: for a name that is neither.
        AssetError: for a folder or a file that is not one of a gripper.
    """
    folder = folder_of("gripper", name)
    path = folder / "gripper.yaml"
    if kind_of(path) == "suction":
        return SuctionCup(name, folder, read(path, SuctionFile))
    return Gripper(name, folder, read(path, GripperFile))
