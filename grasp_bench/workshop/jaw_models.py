"""MJCF of the shipped grippers that are made of boxes: two coupled fingers on slides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from grasp_bench.workshop.mjcf_text import OPTION, numbers, seen_and_solid


@dataclass(frozen=True)
class Jaws:
    """A gripper of two coupled slides, all lengths in metres.

    Attributes:
        stroke: travel of one finger.
        length: distance from the flange to the tips.
        finger: length, thickness at the tip with the pad, and width of a finger.
        pad: thickness, width and height of a pad.
        palm: extent of the hand's underside along and across the jaws, and its height.
        motor: extents of what is between flange and palm.
        mass: of the hand, and of one finger [kg].
    """

    name: str
    comment: str
    stroke: float
    length: float
    finger: tuple[float, float, float]
    pad: tuple[float, float, float]
    palm: tuple[float, float, float]
    motor: tuple[float, float]
    mass: tuple[float, float]


GRIPPERS = (
    Jaws(
        "parallel-50",
        "A plain parallel gripper of 50 mm stroke, the opening for which EGAD's objects are scaled "
        "(Morrison et al., IEEE RA-L 5(3), 2020).",
        0.025,
        0.135,
        (0.055, 0.007, 0.016),
        (0.003, 0.016, 0.022),
        (0.096, 0.044, 0.028),
        (0.070, 0.060),
        (0.55, 0.05),
    ),
    Jaws(
        "parallel-140",
        "A plain parallel gripper of 140 mm stroke.",
        0.070,
        0.195,
        (0.085, 0.010, 0.022),
        (0.003, 0.020, 0.024),
        (0.196, 0.056, 0.036),
        (0.090, 0.076),
        (0.95, 0.11),
    ),
    Jaws(
        "panda-hand",
        "A hand of the measures of Franka Emika's: 80 mm travel, thin fingers with pads of 17 x 17 mm.",
        0.040,
        0.1121,
        (0.0537, 0.010, 0.020),
        (0.004, 0.017, 0.017),
        (0.204, 0.063, 0.040),
        (0.080, 0.060),
        (0.70, 0.015),
    ),
)


def gripper_mjcf(jaws: Jaws) -> str:
    """Return the MJCF of a gripper."""
    long, thick, wide = jaws.finger
    pad_thick, pad_wide, pad_high = jaws.pad
    under = jaws.length - long
    palm_x, palm_y, palm_z = jaws.palm

    def box(name: str, low: Sequence[float], high: Sequence[float], rgba: str) -> list[str]:
        place = numbers(*((a + b) / 2 for a, b in zip(low, high, strict=True)))
        size = numbers(*((b - a) / 2 for a, b in zip(low, high, strict=True)))
        shape = f'pos="{place}" size="{size}"'
        return [
            f'<geom name="{name}_seen" class="visual" {shape} rgba="{rgba}"/>',
            f'<geom name="{name}" class="collision" {shape}/>',
        ]

    dark, steel, rubber = "0.20 0.21 0.23 1", "0.72 0.73 0.75 1", "0.13 0.13 0.14 1"
    hand = [
        *box("motor", (-jaws.motor[0] / 2, -jaws.motor[1] / 2, 0),
             (jaws.motor[0] / 2, jaws.motor[1] / 2, under - palm_z), dark),
        *box("hand", (-palm_x / 2, -palm_y / 2, under - palm_z), (palm_x / 2, palm_y / 2, under), dark),
    ]  # fmt: skip
    half = wide / 2
    waist = long - pad_high - 0.006
    where = f'pos="{numbers(pad_thick / 2, 0, long - pad_high / 2)}"'
    size = f'size="{numbers(pad_thick / 2, pad_wide / 2, pad_high / 2)}"'
    fingers = []
    for side, turned in (("left", ""), ("right", ' quat="0 0 0 1"')):
        fingers += [
            f'<body name="{side}_finger" pos="{numbers(0, 0, under)}"{turned} gravcomp="1">',
            f'  <joint name="{side}_finger_joint"/>',
            *(
                f"  {g}"
                for g in (
                    *box(f"{side}_foot", (pad_thick, -half, 0), (thick + 0.010, half, 0.010), steel),
                    *box(f"{side}_shank", (pad_thick, -half, 0.010), (thick + 0.004, half, waist), steel),
                    *box(f"{side}_blade", (pad_thick, -half, waist), (thick, half, long), steel),
                )
            ),
            f'  <geom name="{side}_pad_seen" class="visual" {where} {size} rgba="{rubber}"/>',
            f'  <geom name="{side}_pad" class="pad" {where} {size}/>',
            "</body>",
        ]
    share = jaws.mass
    body = [
        '<body name="hand" childclass="hand" gravcomp="1">',
        f'  <inertial mass="{numbers(share[0])}" pos="{numbers(0, 0, under / 2)}" '
        f'diaginertia="{numbers(*_box_inertia(share[0], palm_x, palm_y, under))}"/>',
        *(f"  {g}" for g in hand),
        f'  <site name="tcp" pos="{numbers(0, 0, jaws.length)}" size="0.003" group="4"/>',
        *(f"  {line}" for line in fingers),
        "</body>",
    ]
    inertia = numbers(*_box_inertia(share[1], thick, wide, long))
    middle = numbers(thick / 2, 0, long / 2)
    weight = f'    <inertial mass="{numbers(share[1])}" pos="{middle}" diaginertia="{inertia}"/>'
    text = "\n".join(f"    {line}" for line in body)
    for side in ("left", "right"):
        joint = f'<joint name="{side}_finger_joint"/>'
        text = text.replace(joint, f"{joint}\n    {weight}")
    return f"""<mujoco model="{jaws.name}">
  <!-- {jaws.comment} -->
  <!-- Written by grasp_bench.workshop.robot_models. Frame: the flange's; z is the approach, x the jaw
       opening direction. The tendon "grip" measures the mean of both fingers' positions, so half of the
       actuator's force reaches each finger; its command is that position in metres. -->
  <compiler angle="radian" autolimits="true"/>
{OPTION}
  <default>
    <default class="hand">
      <joint type="slide" axis="1 0 0" range="0 {jaws.stroke:g}" damping="5" armature="0.2"
             solreflimit="0.004 1" solimplimit="0.95 0.99 0.001"/>
{seen_and_solid(rubber, 6)}
    </default>
  </default>
  <worldbody>
{text}
  </worldbody>
  <contact>
    <exclude name="fingers" body1="left_finger" body2="right_finger"/>
    <exclude name="left_finger_hand" body1="hand" body2="left_finger"/>
    <exclude name="right_finger_hand" body1="hand" body2="right_finger"/>
  </contact>
  <tendon>
    <fixed name="grip">
      <joint joint="left_finger_joint" coef="0.5"/>
      <joint joint="right_finger_joint" coef="0.5"/>
    </fixed>
  </tendon>
  <equality>
    <joint name="fingers" joint1="right_finger_joint" joint2="left_finger_joint" polycoef="0 1 0 0 0"
           solref="0.004 1" solimp="0.95 0.99 0.001"/>
  </equality>
  <actuator>
    <position name="gripper" tendon="grip" kp="25000" kv="240" ctrlrange="-0.03 {jaws.stroke + 0.0025:g}"
              forcerange="-120 120"/>
  </actuator>
</mujoco>
"""


def _box_inertia(mass: float, x: float, y: float, z: float) -> tuple[float, float, float]:
    return mass / 12 * (y * y + z * z), mass / 12 * (x * x + z * z), mass / 12 * (x * x + y * y)
