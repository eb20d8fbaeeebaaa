"""The numbered examples that are scripts run and print what they promise."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("02_from_python.py", ["coffee_mug", "2/4 = 50%, 95 % interval", "On 4 common trials"]),
        ("03_one_trial_by_hand.py", ["coffee_mug: 330 g", "grasps proposed", "success: lifted"]),
        ("04_gymnasium.py", ["random: 0 of 5", "looking: 4 of 5"]),
    ],
)
def test_an_example_script_runs(name: str, words: list[str], tmp_path: Path) -> None:
    if "gymnasium" in name:
        pytest.importorskip("gymnasium", reason="the extra gym is not installed")
    done = subprocess.run(
        [sys.executable, EXAMPLES / name], cwd=tmp_path, text=True, capture_output=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    for word in words:
        assert word in done.stdout
    assert not list(tmp_path.iterdir())  # nothing is left behind
