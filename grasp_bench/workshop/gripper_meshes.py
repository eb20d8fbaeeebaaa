"""Visual meshes of :data:`~grasp_bench.robot.parallel_85.PARALLEL_85`, a design of our own.

Gripper frame: z is the approach direction with z = 0 on the arm's flange, x is the jaw
opening direction. A finger is drawn at jaw position 0 (pads touching in the plane x = 0),
its frame being the gripper frame moved to the palm, z = 100 mm. All in millimetres.
"""

from __future__ import annotations

import numpy as np

from grasp_bench.robot.parallel_85 import PARALLEL_85
from grasp_bench.workshop import shapes as s


def _mm(metres: float) -> float:
    return round(1000 * metres, 3)


FINGER = _mm(PARALLEL_85.finger_length)  # palm to finger tip
PALM = _mm(PARALLEL_85.flange_to_tcp) - FINGER  # flange to palm
PALM_SIZE = _mm(PARALLEL_85.palm[0]), _mm(PARALLEL_85.palm[1])
PAD = tuple(_mm(v) for v in PARALLEL_85.pad)  # thickness (x), width (y), height (z)
THICK, WIDTH = _mm(PARALLEL_85.finger_thickness), _mm(PARALLEL_85.finger_width)


def housing() -> dict[str, s.Mesh]:
    """Make adapter disc, motor body and the rail block with the slot in which the jaws run."""
    adapter = s.prism(s.circle(36, segments=56), 11, 1.0)
    motor = s.move(s.prism(s.rect(84, 60, 14), 66, 2.5), z=10)
    rail = s.move(s.prism(s.rect(*PALM_SIZE, 7), 36, 2.0), z=PALM - 36)
    slot = s.move(s.box(140, 25, 12), z=PALM - 10)
    plug = s.move(s.rotate(s.cylinder(6.5, 9, 24), x=90), y=-28, z=30)
    window = s.move(s.rounded_box(46, 2, 16, 0.9), y=30, z=34)
    screw = s.move(s.cylinder(3.2, 1.2, 16), z=PALM - 1)
    screws = [s.move(screw, x, y) for x in (-58, 58) for y in (-18.5, 18.5)]
    return {"body": joined(motor, s.difference(rail, slot)),
            "metal": joined(adapter, plug, *screws), "accent": window}


def finger() -> dict[str, s.Mesh]:
    """Make the left finger (+x side): carriage in the slot, foot, tapering blade, rubber pad."""
    carriage = s.move(s.box(20, 24, 9.8), x=11, z=-9.8)
    side = s.polygon([(PAD[0], 0.3), (20, 0.3), (20, 8), (14.5, 8.6), (12.5, 11), (THICK, 35),
                      (THICK, FINGER - 1), (THICK - 1, FINGER), (PAD[0], FINGER)])
    # The side view is drawn in x and z: extruded upwards, then tipped over about x.
    blade = s.move(s.rotate(s.extrude(side, WIDTH), x=90), y=WIDTH / 2)
    screws = [s.move(s.cylinder(2.8, 2.0, 16), x=17, y=y, z=7.5) for y in (-5.5, 5.5)]
    pad = s.move(s.rotate(s.prism(s.rect(PAD[2], PAD[1], 0.8), PAD[0], 0.5), y=90), z=FINGER - PAD[2] / 2)
    return {"steel": blade, "carriage": joined(carriage, *screws), "pad": pad}


def gripper_meshes() -> dict[str, s.Mesh]:
    """Return all visual meshes by file stem; the right finger is the left one turned about z."""
    return {**{f"gripper_{name}": part for name, part in housing().items()},
            **{f"finger_{name}": part for name, part in finger().items()}}


def joined(*meshes: s.Mesh) -> s.Mesh:
    """Put separate solids into one mesh, overlaps left as they are: each keeps its own smooth shading."""
    first = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, first, strict=False)]
    return s.Mesh(np.vstack([mesh.vertices for mesh in meshes]), np.vstack(faces), process=False)
