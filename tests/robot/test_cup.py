"""A suction cup: on what its rim seals, what it holds, and files that are none."""

from __future__ import annotations

import math
import shutil
from pathlib import Path

import numpy as np
import pytest

from grasp_bench.errors import AssetError
from grasp_bench.robot.cup import SuctionCup
from grasp_bench.robot.gripper_trial import try_out
from grasp_bench.robot.grippers import load_gripper
from grasp_bench.robot.seal import AROUND, Seal

SEAL = Seal(0.01, 0.0015, 0.003, math.radians(15))
X, Y = SEAL.places.T


def cup() -> SuctionCup:
    made = load_gripper("suction-20")
    assert isinstance(made, SuctionCup)
    return made


def test_force_is_vacuum_times_area() -> None:
    assert cup().force == pytest.approx((20e3 * math.pi * 1e-4, 60e3 * math.pi * 1e-4))
    assert cup().pad_friction(0.7, 0.0) == pytest.approx([0.7, 0.007, 0.01])
    assert cup().opening == pytest.approx(0.02)
    assert cup().joints_at(0.01).tolist() == [0, 0]
    assert cup().command(np.array([0.01, 0.0, -0.01])).tolist() == [0, 0, 1]


@pytest.mark.parametrize(
    ("gaps", "words"),
    [
        (0 * X, ""),
        (math.tan(math.radians(14)) * X, ""),
        (math.tan(math.radians(16)) * Y, "tilted by 16°, not 15°"),
        ((X**2 + Y**2) / (2 * 0.02), ""),  # a ball of 40 mm
        ((X**2 + Y**2) / (2 * 0.012), "4.2 mm stand out into it"),
        (X**2 / (2 * 0.018), ""),  # a bar of 36 mm
        (X**2 / (2 * 0.012), "departs from the rim's plane by 2.1 mm"),
        (np.where(np.arange(len(X)) == 3, np.nan, 0), "not all of its rim is over the object"),
        (np.where(np.arange(len(X)) == AROUND, np.nan, 0), "not all of it is over the object"),  # a hole
    ],
)
def test_what_a_rim_seals_on(gaps: np.ndarray, words: str) -> None:
    said = SEAL.fault(gaps)
    assert words in said
    assert bool(said) == bool(words)


def test_a_plate_hangs_at_the_cup() -> None:
    try_out(cup())


@pytest.mark.parametrize(
    ("file", "old", "new", "words"),
    [
        ("gripper.yaml", "contact: touch", "contact: lip", "has no geom 'lip'; it has block_seen"),
        ("gripper.yaml", "actuator: vacuum", "actuator: pump", "has no actuator 'pump'; it has vacuum"),
        ("gripper.yaml", "rim: rim", "rim: touch", "the rim 'touch' must be a cylinder"),
        ("gripper.yaml", "contact: touch", "contact: bellows", "the only geom that collides in a body"),
        ("gripper.yaml", "60000.0]", "200000.0]", "vacuum cannot be more than the air's pressure"),
        ("gripper.yaml", "press: 0.005", "press: 0.05", "travels less than the 50 mm of press"),
        ("gripper.yaml", "kind: suction", "kind: jaws", "commands: Field required"),
        ("gripper.yaml", "plunger: plunger", "plunger: hand", "must have one slide joint"),
        ("gripper.xml", 'condim="6"', 'condim="3"', "must have condim 6"),
        ("gripper.xml", 'body="mouth" ctrl', 'body="hand" ctrl', "must be an <adhesion> of the body"),
        ("gripper.xml", 'gain="100"', 'gain="10"', "must be 18.8 N at least"),
    ],
)
def test_a_cup_that_is_none_is_told_in_one_line(
    tmp_path: Path, file: str, old: str, new: str, words: str
) -> None:
    folder = tmp_path / "part"
    shutil.copytree(cup().folder, folder)
    text = (folder / file).read_text()
    assert old in text
    (folder / file).write_text(text.replace(old, new))
    with pytest.raises(AssetError) as caught:
        try_out(load_gripper(str(folder)))
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)
