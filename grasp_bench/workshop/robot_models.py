"""MJCF of the shipped arms and grippers that are made of boxes and capsules.

``python -m grasp_bench.workshop.robot_models`` writes the files anew.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from grasp_bench.system.paths import assets_dir
from grasp_bench.workshop.arm_models import PANDA, UR5E, arm_mjcf
from grasp_bench.workshop.cup_models import suction_mjcf
from grasp_bench.workshop.jaw_models import GRIPPERS, gripper_mjcf
from grasp_bench.workshop.linkage_models import linkage_mjcf


def write_models(folder: Path) -> list[Path]:
    """Write all models below the assets ``folder``, and return their paths."""
    texts = {folder / "arms" / c.name / "arm.xml": arm_mjcf(c) for c in (UR5E, PANDA)}
    texts |= {folder / "grippers" / j.name / "gripper.xml": gripper_mjcf(j) for j in GRIPPERS}
    texts[folder / "grippers" / "suction-20" / "gripper.xml"] = suction_mjcf("suction-20")
    texts[folder / "grippers" / "adaptive-85" / "gripper.xml"] = linkage_mjcf("adaptive-85")
    for path, text in texts.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return list(texts)


def main() -> None:
    """Rewrite the shipped models, as the command line says."""
    parser = argparse.ArgumentParser(description="Rewrite the models of arms and grippers made here.")
    parser.add_argument("--out", type=Path, default=assets_dir(), help="assets folder")
    for path in write_models(parser.parse_args().out):
        print(path)


if __name__ == "__main__":
    main()
