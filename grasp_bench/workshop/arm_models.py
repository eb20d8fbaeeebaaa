"""MJCF of the shipped arms that are made of capsules.

Kinematics are the published tables of Denavit and Hartenberg; masses are published, too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from grasp_bench.workshop.mjcf_text import OPTION, numbers

Capsule = tuple[float, float, float, float, float, float, float]
"""Both ends of the axis, and the radius [m]."""


@dataclass(frozen=True)
class Link:
    """A link and the joint that moves it.

    Attributes:
        before: a, alpha, d from the frame of the link before to this joint's frame: translation by d along z
            and by a along x, and rotation by alpha about x, in the order of the arm's convention [m, rad].
        mass: of the link [kg].
        capsules: its outline in its own frame, the joint's axis being z.
        limits: lower and upper end of the joint's range [rad].
        torque: greatest of the joint [N m].
        gains: position gain and damping of its servo [N m/rad, N m s/rad].
    """

    before: tuple[float, float, float]
    mass: float
    capsules: tuple[Capsule, ...]
    limits: tuple[float, float]
    torque: float
    gains: tuple[float, float]


@dataclass(frozen=True)
class Chain:
    """An arm.

    Attributes:
        modified: the table is of Craig's convention (rotation about x before the translation along z), not of
            Denavit's and Hartenberg's own.
        base_turn: angle about z by which its base is turned, so that it looks along x at joint angle 0 [rad].
        flange: a, alpha, d from the last joint's frame to the flange.
    """

    name: str
    comment: str
    modified: bool
    base_turn: float
    base: tuple[float, tuple[Capsule, ...]]
    links: tuple[Link, ...]
    flange: tuple[float, float, float]


def _step(modified: bool, a: float, alpha: float, d: float) -> str:
    """Return MJCF's ``pos`` and ``quat`` of a step of a table of Denavit and Hartenberg."""
    y, z = (-d * math.sin(alpha), d * math.cos(alpha)) if modified else (0.0, d)
    return f'pos="{numbers(a, y, z)}" quat="{numbers(math.cos(alpha / 2), math.sin(alpha / 2), 0, 0)}"'


UR_LIMIT, UR_ELBOW = math.radians(360), math.radians(180)
UR5E = Chain(
    "ur5e",
    "Universal Robots UR5e, 6 axes, 850 mm reach, 5 kg. Kinematics and masses: the maker's published DH "
    "parameters; torques: its published greatest joint torques.",
    False,
    math.pi,
    (4.0, ((0, 0, 0.015, 0, 0, 0.035, 0.072),)),
    (
        Link(
            (0, 0, 0),
            3.761,
            ((0, 0, 0.10, 0, 0, 0.165, 0.058), (0, 0, 0.1625, 0, -0.06, 0.1625, 0.056)),
            (-UR_LIMIT, UR_LIMIT),
            150,
            (4000, 280),
        ),
        Link(
            (0, math.pi / 2, 0.1625),
            8.058,
            (
                (0, 0, 0.08, 0, 0, 0.15, 0.058),
                (-0.03, 0, 0.138, -0.40, 0, 0.138, 0.050),
                (-0.425, 0, 0.06, -0.425, 0, 0.15, 0.050),
            ),
            (-UR_LIMIT, UR_LIMIT),
            150,
            (4000, 280),
        ),
        Link(
            (-0.425, 0, 0),
            2.846,
            (
                (0, 0, 0.0, 0, 0, 0.03, 0.050),
                (-0.03, 0, 0.010, -0.37, 0, 0.010, 0.042),
                (-0.3922, 0, 0.0, -0.3922, 0, 0.07, 0.040),
            ),
            (-UR_ELBOW, UR_ELBOW),
            150,
            (4000, 150),
        ),
        Link(
            (-0.3922, 0, 0), 1.37, ((0, 0, 0.09, 0, 0, 0.1333, 0.040),), (-UR_LIMIT, UR_LIMIT), 28, (1000, 30)
        ),
        Link(
            (0, math.pi / 2, 0.1333),
            1.3,
            ((0, 0, 0.02, 0, 0, 0.0997, 0.040),),
            (-UR_LIMIT, UR_LIMIT),
            28,
            (1000, 25),
        ),
        Link(
            (0, -math.pi / 2, 0.0997),
            0.365,
            ((0, 0, 0.02, 0, 0, 0.0646, 0.035),),
            (-UR_LIMIT, UR_LIMIT),
            28,
            (1000, 20),
        ),
    ),
    (0, 0, 0.0996),
)
"""DH: https://www.universal-robots.com, "DH Parameters for calculations of kinematics and dynamics"."""

PANDA = Chain(
    "panda",
    "Franka Emika Panda, 7 axes, 855 mm reach, 3 kg. Kinematics and limits: the maker's control "
    "documentation (modified DH); masses: Gaz et al., IEEE RA-L 4(4), 2019.",
    True,
    0.0,
    (2.9, ((-0.06, 0, 0.06, 0.0, 0, 0.06, 0.060),)),
    (
        Link(
            (0, 0, 0.333), 4.970684, ((0, 0, -0.17, 0, 0, -0.02, 0.058),), (-2.8973, 2.8973), 87, (4000, 280)
        ),
        Link(
            (0, -math.pi / 2, 0),
            0.646926,
            ((0, 0, -0.05, 0, 0, 0.05, 0.058), (0, 0, 0, 0, -0.13, 0, 0.055)),
            (-1.7628, 1.7628),
            87,
            (4000, 280),
        ),
        Link(
            (0, math.pi / 2, 0.316),
            3.228604,
            ((0, 0, -0.13, 0, 0, -0.03, 0.055), (0, 0, -0.03, 0.0825, 0, 0, 0.052)),
            (-2.8973, 2.8973),
            87,
            (4000, 200),
        ),
        Link(
            (0.0825, math.pi / 2, 0),
            3.587895,
            ((0, 0, -0.05, 0, 0, 0.05, 0.052), (0, 0, 0, -0.0825, 0.11, 0, 0.050)),
            (-3.0718, -0.0698),
            87,
            (4000, 150),
        ),
        Link(
            (-0.0825, -math.pi / 2, 0.384),
            1.225946,
            ((0, 0, -0.22, 0, 0, -0.04, 0.045),),
            (-2.8973, 2.8973),
            12,
            (1000, 30),
        ),
        Link(
            (0, math.pi / 2, 0),
            1.666555,
            ((0, 0, -0.04, 0, 0, 0.03, 0.045), (0, 0, 0, 0.088, 0, 0, 0.042)),
            (-0.0175, 3.7525),
            12,
            (1000, 25),
        ),
        Link(
            (0.088, math.pi / 2, 0),
            0.735522,
            ((0, 0, 0.0, 0, 0, 0.065, 0.042),),
            (-2.8973, 2.8973),
            12,
            (1000, 20),
        ),
    ),
    (0, 0, 0.107),
)
"""DH: https://frankaemika.github.io/docs/control_parameters.html."""


def arm_mjcf(chain: Chain) -> str:
    """Return the MJCF of an arm."""
    lines = [
        f'<mujoco model="{chain.name}">',
        f"  <!-- {chain.comment} -->",
        "  <!-- Written by grasp_bench.workshop.robot_models; outlines are its own, armature, damping and "
        "gains estimates. -->",
        '  <compiler angle="radian" autolimits="true"/>',
        OPTION,
        "  <default>",
        '    <default class="arm">',
        '      <joint axis="0 0 1" damping="1.5"/>',
        '      <default class="visual">',
        '        <geom type="capsule" group="2" contype="0" conaffinity="0" mass="0" '
        'rgba="0.86 0.87 0.88 1"/>',
        "      </default>",
        "      <!-- Links meet objects, table and gripper, not each other. -->",
        '      <default class="collision">',
        '        <geom type="capsule" group="3" conaffinity="0" rgba="0.9 0.5 0.2 0.5"/>',
        "      </default>",
        "    </default>",
        "  </default>",
        "  <worldbody>",
    ]
    turn = f"{numbers(math.cos(chain.base_turn / 2), 0, 0, math.sin(chain.base_turn / 2))}"
    lines.append(f'    <body name="base" childclass="arm" quat="{turn}" gravcomp="1">')
    mass, outline = chain.base
    lines += _outline("base", mass, outline, "      ")
    before = (0.0, 0.0, 0.0)
    indent = "      "
    for i, link in enumerate(chain.links, 1):
        name, torque = f"link{i}", link.torque
        before = link.before
        lines.append(f'{indent}<body name="{name}" {_step(chain.modified, *before)} gravcomp="1">')
        indent += "  "
        armature = 0.3 if torque > 50 else 0.1
        lines.append(
            f'{indent}<joint name="joint{i}" range="{link.limits[0]!r} {link.limits[1]!r}" '
            f'armature="{armature}"/>'
        )
        lines += _outline(name, link.mass, link.capsules, indent)
    a, alpha, d = chain.flange
    lines.append(f'{indent}<site name="flange" {_step(chain.modified, a, alpha, d)} size="0.004" group="4"/>')
    for _ in range(len(chain.links) + 1):
        indent = indent[:-2]
        lines.append(f"{indent}</body>")
    lines += ["  </worldbody>", "  <actuator>"]
    for i, link in enumerate(chain.links, 1):
        kp, kv = link.gains
        lines.append(
            f'    <position name="joint{i}" joint="joint{i}" kp="{kp:g}" kv="{kv:g}" '
            f'ctrlrange="{link.limits[0]!r} {link.limits[1]!r}" '
            f'forcerange="{-link.torque:g} {link.torque:g}"/>'
        )
    lines += ["  </actuator>", "</mujoco>", ""]
    return "\n".join(lines)


def _outline(name: str, mass: float, capsules: Sequence[Capsule], indent: str) -> Iterator[str]:
    sizes = [math.dist(c[:3], c[3:6]) + 4 / 3 * c[6] for c in capsules]
    for j, (capsule, size) in enumerate(zip(capsules, sizes, strict=True)):
        shape = f'fromto="{numbers(*capsule[:6])}" size="{numbers(capsule[6])}"'
        yield f'{indent}<geom name="{name}_seen{j}" class="visual" {shape}/>'
        share = mass * size / sum(sizes)
        yield f'{indent}<geom name="{name}_solid{j}" class="collision" {shape} mass="{numbers(share)}"/>'
