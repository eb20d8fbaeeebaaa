"""MJCF of the shipped gripper with a closed linkage: two parallelograms of hinges."""

from __future__ import annotations

from collections.abc import Sequence

from grasp_bench.workshop.mjcf_text import OPTION, numbers, seen_and_solid

STROKE = 0.0425
"""Travel of one finger [m]."""
LINK = 0.070
"""Length of the links [m]; they stand straight where the jaws are half open."""
PIVOTS = ((0.050, 0.060), (0.034, 0.068))
"""x and z of the outer and the inner link's hinge in the base [m]: the inner link stays behind the pad."""
TIP = 0.045
"""From the outer link's far hinge to the tips [m]."""
FINGER, PAD = (0.0085, 0.022), (0.003, 0.020, 0.024)
"""Thickness and width of a finger with its pad; thickness, width and height of the pad [m]."""
UNDER = 0.074
"""Distance of the base's underside from the flange [m]."""
BEHIND = 0.020
"""The tendon between the fingers ends so far behind the pads' faces [m]: it must not shrink to nothing."""


def linkage_mjcf(name: str) -> str:
    """Return the MJCF of the gripper; the joints are 0 where the jaws are half open."""
    length = PIVOTS[0][1] + LINK + TIP
    face = STROKE / 2 - PIVOTS[0][0]  # of the pad, from the outer link's far hinge
    dark, steel, rubber = "0.20 0.21 0.23 1", "0.72 0.73 0.75 1", "0.13 0.13 0.14 1"
    thick, wide = FINGER
    half = wide / 2

    def box(part: str, low: Sequence[float], high: Sequence[float], rgba: str) -> list[str]:
        place = numbers(*((a + b) / 2 for a, b in zip(low, high, strict=True)))
        size = numbers(*((b - a) / 2 for a, b in zip(low, high, strict=True)))
        return [
            f'<geom name="{part}_seen" class="visual" pos="{place}" size="{size}" rgba="{rgba}"/>',
            f'<geom name="{part}" class="collision" pos="{place}" size="{size}"/>',
        ]

    def link(part: str) -> list[str]:
        return box(part, (-0.005, -half, -0.004), (0.005, half, LINK + 0.004), steel)

    pad = f'pos="{numbers(face + PAD[0] / 2, 0, TIP - PAD[2] / 2)}" size="{numbers(*(v / 2 for v in PAD))}"'
    inner = PIVOTS[1][0] - PIVOTS[0][0], PIVOTS[1][1] - PIVOTS[0][1]
    lines = []
    for side, turned in (("left", ""), ("right", ' quat="0 0 0 1"')):
        sign = 1 if side == "left" else -1
        outer_at, inner_at = (numbers(sign * x, 0, z) for x, z in PIVOTS)
        lines += [
            f'<body name="{side}_outer" pos="{outer_at}"{turned} gravcomp="1">',
            f'  <joint name="{side}_outer" class="driver"/>',
            f'  <inertial mass="0.05" pos="{numbers(0, 0, LINK / 2)}" diaginertia="2e-5 2e-5 4e-6"/>',
            *(f"  {g}" for g in link(f"{side}_outer")),
            f'  <body name="{side}_finger" pos="{numbers(0, 0, LINK)}" gravcomp="1">',
            f'    <joint name="{side}_finger" class="follower"/>',
            f'    <inertial mass="0.06" pos="{numbers(face / 2, 0, TIP / 3)}" '
            'diaginertia="2.5e-5 2.5e-5 8e-6"/>',
            *(
                f"    {g}"
                for g in (
                    *box(f"{side}_knuckle", (face + PAD[0], -half, -0.008), (0.006, half, 0.010), steel),
                    *box(f"{side}_blade", (face + PAD[0], -half, 0.010), (face + thick, half, TIP), steel),
                )
            ),
            f'    <geom name="{side}_pad_seen" class="visual" {pad} rgba="{rubber}"/>',
            f'    <geom name="{side}_pad" class="pad" {pad}/>',
            f'    <site name="{side}_grip" pos="{numbers(face + BEHIND, 0, TIP - PAD[2] / 2)}" size="0.001" '
            'group="4"/>',
            "  </body>",
            "</body>",
            f'<body name="{side}_inner" pos="{inner_at}"{turned} gravcomp="1">',
            f'  <joint name="{side}_inner" class="follower"/>',
            f'  <inertial mass="0.03" pos="{numbers(0, 0, LINK / 2)}" diaginertia="1.2e-5 1.2e-5 2e-6"/>',
            *(f"  {g}" for g in link(f"{side}_inner")),
            "</body>",
        ]
    bodies = "\n".join(f"      {line}" for line in lines)
    palm = "\n".join(
        f"      {g}" for g in box("base", (-0.076, -0.035, UNDER - 0.030), (0.076, 0.035, UNDER), dark)
        + box("motor", (-0.038, -0.038, 0), (0.038, 0.038, UNDER - 0.030), dark)
    )  # fmt: skip
    parts = [
        "base",
        *(f"{side}_{part}" for side in ("left", "right") for part in ("outer", "finger", "inner")),
    ]
    excludes = "\n".join(
        f'    <exclude body1="{a}" body2="{b}"/>' for i, a in enumerate(parts) for b in parts[i + 1 :]
    )
    loops = "\n".join(
        f'    <connect name="{side}_loop" body1="{side}_inner" body2="{side}_finger" '
        f'anchor="{numbers(0, 0, LINK)}" solref="0.004 1" solimp="0.999 0.9995 0.001"/>'
        for side in ("left", "right")
    )
    assert abs(inner[0]) > 0.01, "a parallelogram that is flat does not hold the finger"
    return f"""<mujoco model="{name}">
  <!-- A gripper of two closed linkages, of the kind of Robotiq's 2F-85: outer and inner link keep the finger
       parallel. It does not wrap fingers around things. -->
  <!-- Written by grasp_bench.workshop.robot_models. Frame: the flange's; z is the approach, x the jaw
       opening direction. The tendon "grip" is the distance between the fingers, {2000 * BEHIND:g} mm more
       than that of the pads, and pulls both pads with the actuator's force at every opening. -->
  <compiler angle="radian" autolimits="true"/>
{OPTION}
  <default>
    <default class="driver">
      <joint type="hinge" axis="0 1 0" range="-0.42 0.42" damping="0.018" armature="0.0007"
             solreflimit="0.004 1" solimplimit="0.95 0.99 0.001"/>
    </default>
    <default class="follower">
      <joint type="hinge" axis="0 1 0" damping="0.0005" armature="0.00005"/>
    </default>
{seen_and_solid(rubber, 4)}
  </default>
  <worldbody>
    <body name="base" gravcomp="1">
      <inertial mass="0.70" pos="{numbers(0, 0, UNDER / 2)}" diaginertia="6e-4 9e-4 9e-4"/>
{palm}
      <site name="tcp" pos="{numbers(0, 0, length)}" size="0.003" group="4"/>
{bodies}
    </body>
  </worldbody>
  <contact>
{excludes}
  </contact>
  <tendon>
    <spatial name="grip" width="0.0001" rgba="0 0 0 0">
      <site site="left_grip"/>
      <site site="right_grip"/>
    </spatial>
  </tendon>
  <equality>
{loops}
    <joint name="fingers" joint1="right_outer" joint2="left_outer" polycoef="0 1 0 0 0" solref="0.004 1"
           solimp="0.95 0.99 0.001"/>
  </equality>
  <actuator>
    <position name="gripper" tendon="grip" kp="6250" kv="60" ctrlrange="-0.02 0.13" forcerange="-240 240"/>
  </actuator>
</mujoco>
"""
