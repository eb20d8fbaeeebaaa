"""The Elite EC66: six joints, 914 mm reach, 6 kg payload; its facts are in its folder."""

from __future__ import annotations

from grasp_bench.robot.arm import load_arm

EC66 = load_arm("ec66")
"""The benchmark's reference arm."""
