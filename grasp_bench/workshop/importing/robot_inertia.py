"""Masses and inertias that a description gives, before MuJoCo compiles it: zeros and impossible ones."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass, field

import numpy as np

from grasp_bench.system.arrays import Floats
from grasp_bench.workshop.importing.folder import RefusedError


@dataclass
class Inertials:
    """What was found wrong with the inertias of a description.

    Attributes:
        spread: whether centre and inertia must come from the shape.
        suspects: (mass [kg], inertia (3, 3) [kg m²]) that no body has.
    """

    spread: bool = False
    suspects: list[tuple[float, Floats]] = field(default_factory=list)


def settle_inertials(tree: ET.Element, notes: list[str]) -> Inertials:
    """Leave out masses of 0, stand in for inertias that MuJoCo would not compile, and say which.

    Raises:
        RefusedError: for masses that are negative or no numbers.
    """
    found = Inertials()
    for owner in list(tree.iter("link" if tree.tag == "robot" else "body")):
        given = owner.find("inertial")
        if given is None:
            continue
        name = f"{owner.tag} {owner.get('name', '')!r}"
        mass, inertia = _given_inertia(given, name)
        if mass == 0:
            owner.remove(given)
            notes.append(f"the {name} has a mass of 0: taken as not given")
            continue
        moments = np.linalg.eigvalsh(inertia)
        if not inertia.any():
            found.spread = True
            notes.append(f"the {name} has no inertia: that of the shape is taken")
        elif moments[0] > 0 and moments[2] <= (moments[0] + moments[1]) * (1 + 1e-9):
            continue
        else:
            found.suspects.append((mass, inertia))
        _stand_in(given, mass)
    return found


def _given_inertia(given: ET.Element, name: str) -> tuple[float, Floats]:
    """Return mass and inertia (3, 3) of an ``inertial`` element; zeros where it gives none."""
    try:
        if (part := given.find("mass")) is not None:
            mass = float(part.get("value", "0"))
        else:
            mass = float(given.get("mass", "0"))
        if (part := given.find("inertia")) is not None:
            xx, xy, xz, yy, yz, zz = (float(part.get(f"i{k}", "0")) for k in "xx xy xz yy yz zz".split())
        elif given.get("fullinertia"):
            xx, yy, zz, xy, xz, yz = (float(v) for v in given.get("fullinertia", "").split())
        else:
            (xx, yy, zz), (xy, xz, yz) = (
                (float(v) for v in given.get("diaginertia", "0 0 0").split()),
                (0, 0, 0),
            )
    except ValueError as error:
        raise RefusedError(f"the mass or inertia of the {name} is no number ({error})") from error
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if not np.isfinite([mass, *inertia.ravel()]).all() or mass < 0:
        raise RefusedError(f"the {name} has a mass of {mass:g} kg, or an inertia that is not finite")
    return mass, inertia


def _stand_in(given: ET.Element, mass: float) -> None:
    """Replace an inertia by that of a ball of 2 cm, which compiles."""
    moment = repr(0.4 * mass * 0.01**2)
    if (part := given.find("inertia")) is not None:
        for key in ("ixx", "iyy", "izz"):
            part.set(key, moment)
        for key in ("ixy", "ixz", "iyz"):
            part.set(key, "0")
    elif given.find("mass") is not None:
        ET.SubElement(given, "inertia", ixx=moment, iyy=moment, izz=moment, ixy="0", ixz="0", iyz="0")
    else:
        given.attrib.pop("fullinertia", None)
        given.set("diaginertia", f"{moment} {moment} {moment}")


def drop_masses(tree: ET.Element) -> None:
    """Take all masses, densities and inertias out."""
    for owner in list(tree.iter()):
        for given in owner.findall("inertial"):
            owner.remove(given)
        if owner.tag == "geom":
            for key in ("mass", "density"):
                owner.attrib.pop(key, None)
        if owner.tag == "compiler":
            owner.set("inertiafromgeom", "auto")
