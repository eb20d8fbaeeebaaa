"""MJCF of the shipped suction cup."""

from __future__ import annotations

from grasp_bench.workshop.mjcf_text import OPTION, numbers

RADIUS = 0.010
"""Of the rim [m]."""
LENGTH = 0.120
"""From the flange to the rim, plunger out [m]."""
STROKE = 0.015
"""Travel of the plunger [m]."""
RECESS = 0.0035
"""The bellows, as it collides, begins behind the rim: what is bulged is touched at the middle first [m]."""
TOUCH = 0.003
"""Radius of what touches at the middle of the rim [m]."""
# The plunger's stop is as soft as bellows are: a hard one would tear off what is lifted with a jerk.
BELLOWS, BODY, STEM = 0.016, (0.032, 0.045), 0.005
"""Length of the bellows, radius and height of the valve block, radius of the plunger's stem [m]."""


def suction_mjcf(name: str) -> str:
    """Return the MJCF of the suction cup of 20 mm."""
    under = BODY[1]  # the hand's underside

    def along(*ends: float) -> str:
        low, high = min(ends), max(ends)
        return f'pos="{numbers(0, 0, (low + high) / 2)}"'

    def cylinder(radius: float, *ends: float) -> str:
        low, high = min(ends), max(ends)
        return f'{along(low, high)} size="{numbers(radius, (high - low) / 2)}"'

    fold = BELLOWS / 4
    rubber, steel, dark = "0.55 0.20 0.12 1", "0.72 0.73 0.75 1", "0.20 0.21 0.23 1"
    rings = "\n".join(
        f'        <geom name="ring{i}" class="visual" {cylinder(r, -fold * (i + 1), -fold * i)} '
        f'rgba="{rubber}"/>'
        for i, r in enumerate((0.0085, RADIUS, 0.0075, RADIUS - 0.001))
        if i
    )
    return f"""<mujoco model="{name}">
  <!-- One suction cup on a plunger with a spring. -->
  <!-- Written by grasp_bench.workshop.robot_models. Frame: the flange's; z is the approach. MuJoCo's adhesion
       holds what "touch" touches, one contact at the middle of the rim that bears shear, torsion and
       peeling as docs/robots.md says; its command is the vacuum, off or on. -->
  <compiler angle="radian" autolimits="true"/>
{OPTION}
  <default>
    <default class="visual">
      <geom type="cylinder" group="2" contype="0" conaffinity="0" mass="0"/>
    </default>
    <default class="collision">
      <geom type="cylinder" group="3" mass="0" rgba="0.9 0.5 0.2 0.5"/>
    </default>
  </default>
  <worldbody>
    <body name="hand" gravcomp="1">
      <inertial mass="0.35" pos="{numbers(0, 0, under / 2)}" diaginertia="2.6e-4 2.6e-4 2.2e-4"/>
      <geom name="block_seen" class="visual" {cylinder(BODY[0], 0, under)} rgba="{dark}"/>
      <geom name="block" class="collision" {cylinder(BODY[0], 0, under)}/>
      <site name="tcp" pos="{numbers(0, 0, LENGTH)}" size="0.003" group="4"/>
      <body name="plunger" pos="{numbers(0, 0, LENGTH)}" gravcomp="1">
        <joint name="plunger" type="slide" axis="0 0 1" range="{numbers(-STROKE, 0)}" damping="3"
               stiffness="150" springref="0.010" armature="0.05" solreflimit="0.03 1"
               solimplimit="0.95 0.99 0.001"/>
        <inertial mass="0.03" pos="{numbers(0, 0, -0.03)}" diaginertia="1.5e-5 1.5e-5 1e-6"/>
        <geom name="stem_seen" class="visual" {cylinder(STEM, -BELLOWS, under - LENGTH)} rgba="{steel}"/>
        <geom name="stem" class="collision" {cylinder(STEM, -BELLOWS, under - LENGTH)}/>
{rings}
        <geom name="rim" class="visual" {cylinder(RADIUS, -BELLOWS / 4, 0)} rgba="{rubber}"/>
        <geom name="bellows" class="collision" {cylinder(RADIUS - 0.001, -BELLOWS, -RECESS)}/>
        <body name="mouth">
          <inertial mass="0.005" pos="0 0 0" diaginertia="1e-6 1e-6 1e-6"/>
          <geom name="touch" class="collision" type="sphere" pos="{numbers(0, 0, -TOUCH)}" size="{TOUCH:g}"
                condim="6" priority="1" friction="0.9 0.009 0.01" solref="0.004 1"
                solimp="0.995 0.999 0.0005" gap="0.001"/>
        </body>
      </body>
    </body>
  </worldbody>
  <contact>
    <exclude name="plunger" body1="hand" body2="plunger"/>
    <exclude name="mouth" body1="hand" body2="mouth"/>
  </contact>
  <actuator>
    <adhesion name="vacuum" body="mouth" ctrlrange="0 1" gain="100" forcerange="-100 100"/>
  </actuator>
</mujoco>
"""
