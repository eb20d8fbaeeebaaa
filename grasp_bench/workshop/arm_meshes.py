"""Visual meshes of the EC66 arm, authored from its outer dimensions.

Each link is a set of turned parts: joint housings with rounded shoulders, slender
hour-glass tubes between them, and separate dark end caps and joint collars. Dimensions
are those of the maker's public model, read as diameters and lengths; the shapes are our
own. All solids are drawn in millimetres in the link frames of the arm's URDF chain (see
``assets/ec66/ec66.xml``) and written in metres.

``python -m grasp_bench.workshop.arm_meshes`` rewrites ``assets/ec66/meshes``.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator

from grasp_bench.robot.ec66 import EC66
from grasp_bench.workshop import shapes as s
from grasp_bench.workshop.gripper_meshes import gripper_meshes, joined

SEGMENTS = 60
LARGE, MEDIUM, SMALL = 59.0, 48.5, 38.0  # housing radii: shoulder, elbow, wrist (mm)
CAP = 8.0  # height of an end cap (mm)
COLLAR = 3.5  # length of the dark collar where two links meet (mm)

Profile = Sequence[tuple[float, float]]


# ---------------------------------------------------------------- parts

def turned(profile: Profile, fillet: float = 0.0) -> s.Mesh:
    """Make a solid of revolution about z; ``profile`` lists (r, z) from axis to axis.

    The profile is rounded together with its mirror image, so that ``fillet`` (mm)
    rounds the rim and leaves the axis alone.
    """
    right = np.asarray(profile, dtype=float)
    outline = s.polygon(np.vstack([right, right[-2:0:-1] * [-1, 1]]))
    if fillet:
        outline = s.rounded(outline, fillet, segments=3)
    ring = np.asarray(outline.exterior.coords)
    right = s.polygon(np.column_stack([np.maximum(ring[:, 0], 0), ring[:, 1]])).buffer(0)
    return s.revolve(right, SEGMENTS)


def drum(radius: float, start: float, stop: float, fillet: float = 3.0) -> s.Mesh:
    """Make a cylinder about z from ``start`` to ``stop`` with rounded rims."""
    return turned([(0, start), (radius, start), (radius, stop), (0, stop)], fillet)


def cap(radius: float, at: float, sense: int) -> s.Mesh:
    """Make the end cap of a housing of ``radius``: a rounded lid that ends at ``at``, seen from ``sense``.

    A shallow annular groove and a slightly sunk centre catch the light as on the real lid.
    """
    r, h = radius - 1.5, CAP
    lid = [(0, -6), (r, -6), (r, h - 4.5), (r - 0.7, h - 2.6), (r - 2.2, h - 1.0), (r - 4.5, h),
           (0.74 * r, h), (0.72 * r, h - 1.2), (0.68 * r, h - 1.2), (0.66 * r, h - 0.3), (0, h - 0.3)]
    solid = turned(lid)
    solid = solid if sense > 0 else s.rotate(solid, x=180)
    return s.move(solid, z=at - sense * CAP)


def housing(radius: float, joint: float, end: float) -> tuple[s.Mesh, s.Mesh]:
    """Make a joint housing about z from its ``joint`` face to its capped ``end``: (body, dark parts)."""
    sense = 1 if end > joint else -1
    body = drum(radius, *sorted((joint + sense * COLLAR, end - sense * CAP)))
    return body, joined(collar(radius, joint, sense), cap(radius, end, sense))


def collar(radius: float, face: float, sense: int) -> s.Mesh:
    """Make the recessed dark ring about z between ``face``, where two links meet, and the housing."""
    return drum(radius - 2.0, *sorted((face, face + sense * (COLLAR + 1))), fillet=0.0)


def tube(stations: Sequence[tuple[float, float, float]], steps: int = 24) -> s.Mesh:
    """Make a round tube along z through ``stations`` of (z, radius, y of the axis), smoothly blended."""
    z, r, y = np.asarray(stations, dtype=float).T
    fine = np.linspace(z[0], z[-1], steps + 1)
    turn = np.linspace(0, 2 * np.pi, SEGMENTS, endpoint=False)
    radius, centre = PchipInterpolator(z, r)(fine), PchipInterpolator(z, y)(fine)
    return s.loft([np.column_stack([a * np.cos(turn), b + a * np.sin(turn), np.full(SEGMENTS, c)])
                   for a, b, c in zip(radius, centre, fine, strict=True)])


def along_y(mesh: s.Mesh, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> s.Mesh:
    """Turn a part drawn about +z so that it points along +y, then move it."""
    return s.move(s.rotate(mesh, x=-90), x, y, z)


# ---------------------------------------------------------------- links

Parts = dict[str, s.Mesh]


def base_link() -> Parts:
    """Make the foot: bolting flange of 150 mm, shoulder of 118 mm at 20 mm, 28 mm high."""
    foot = turned([(0, 0), (75, 0), (75, 8), (73.5, 9.5), (66, 11), (61, 14.5), (LARGE, 20), (LARGE, 28),
                   (0, 28)])
    bolt = s.move(s.cylinder(4.5, 4.5, 16), x=67, z=9)
    return {"body": foot, "dark": joined(*s.spin(s.rotate(bolt, z=45), 4))}


def link1() -> Parts:
    """Make the upright shoulder housing with a stub of the same bore towards the upper arm (+y)."""
    body, dark = housing(LARGE, -68, 81.7)
    stub = along_y(turned([(0, 0), (LARGE, 0), (LARGE, 70 - COLLAR), (0, 70 - COLLAR)]))
    return {"body": joined(body, stub), "dark": joined(dark, along_y(collar(LARGE, 70, -1)))}


def link2() -> Parts:
    """Make the upper arm, 418 mm: shoulder drum, waisted tube at y = 16 mm, elbow drum."""
    shoulder, shoulder_dark = housing(LARGE, -52, 97.7)
    elbow, elbow_dark = housing(MEDIUM, -44, 82)
    waist = ((0, 58.9), (60, 58.9), (80, 58.2), (150, 48), (210, 41.5), (250, 42.2), (300, 46), (350, 48.4),
             (418, 48.4))
    arm = tube([(z, r, 16) for z, r in waist])
    return {"body": joined(along_y(shoulder), arm, along_y(elbow, z=418)),
            "dark": joined(along_y(shoulder_dark), along_y(elbow_dark, z=418))}


def link3() -> Parts:
    """Make the forearm, 398 mm: elbow drum, waisted tube at y = 24 mm, first wrist drum."""
    elbow, elbow_dark = housing(MEDIUM, 78, -3.5)
    wrist, wrist_dark = housing(SMALL, 73.5, -29.5)
    arm = tube([(0, 34.5, 39), (30, 34.9, 39), (52, 35.8, 36), (70, 36.8, 29), (100, 35.5, 24.5),
                (130, 34, 24), (200, 31.5, 24), (300, 35, 24), (350, 37.8, 24), (398, 37.9, 24)], steps=32)
    return {"body": joined(along_y(elbow), arm, along_y(wrist, z=398)),
            "dark": joined(along_y(elbow_dark), along_y(wrist_dark, z=398))}


def wrist_link() -> Parts:
    """Make the second or third wrist: a capped drum on a stub of equal bore.

    Drawn about z with the stub towards -y, the drum's centre on the origin.
    """
    body, dark = housing(SMALL, 49.5, -55)
    length = 48.5
    stub = s.rotate(turned([(0, 0), (SMALL, 0), (SMALL, length - COLLAR), (0, length - COLLAR)]), x=90)
    ring = s.rotate(collar(SMALL, length, -1), x=90)
    return {"body": joined(body, stub), "dark": joined(dark, ring)}


def link4() -> Parts:
    """Make wrist 2: drum about z at y = 122 mm, stub from y = 73.5 mm."""
    return {name: s.move(part, y=122) for name, part in wrist_link().items()}


def link5() -> Parts:
    """Make wrist 3: drum about y at z = 98 mm, stub from z = 49.5 mm."""
    return {name: s.move(s.rotate(part, x=90), z=98) for name, part in wrist_link().items()}


def link6() -> Parts:
    """Make the tool flange: disc of 76 mm, then a hub of 63 mm whose face has four holes on 50 mm."""
    disc = s.rotate(drum(SMALL, 49.5 + COLLAR, 70), x=90)
    neck = s.rotate(collar(SMALL, 49.5, 1), x=90)
    hub = turned([(0, 66), (31.5, 66), (31.5, 82), (0, 82)])
    holes = [s.move(s.cylinder(3, 9, 16), 17.68 * i, 17.68 * j, -1) for i in (-1, 1) for j in (-1, 1)]
    plate = s.move(s.difference(s.cylinder(31, 7, SEGMENTS), *holes), z=82)
    return {"body": disc, "dark": neck, "flange": s.rotate(joined(hub, plate), x=90)}


# ---------------------------------------------------------------- files

def arm_meshes() -> dict[str, s.Mesh]:
    """Return all visual meshes of the arm by file stem, in millimetres and link frames."""
    links = (base_link, link1, link2, link3, link4, link5, link6)
    return {f"{link.__name__}_{name}": part for link in links for name, part in link().items()}


def write_meshes(folder: Path) -> list[Path]:
    """Write every mesh of arm and gripper to ``folder`` as binary STL in metres."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for name, mesh in {**arm_meshes(), **gripper_meshes()}.items():
        paths.append(folder / f"{name}.stl")
        s.scale(mesh, 1e-3).export(paths[-1])
    return paths


def main() -> None:
    """Rewrite the shipped meshes, as the command line says."""
    parser = argparse.ArgumentParser(description="Rewrite the EC66 and gripper meshes.")
    parser.add_argument("--out", type=Path, default=EC66.path.parent / "meshes", help="output folder")
    for path in write_meshes(parser.parse_args().out):
        print(path)


if __name__ == "__main__":
    main()
