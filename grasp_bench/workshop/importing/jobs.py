"""What an import command asks for, checked and turned into one job an object."""

from __future__ import annotations

import csv
import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from grasp_bench.errors import GraspBenchError, UnknownNameError
from grasp_bench.objects.catalog import MANIFEST
from grasp_bench.workshop.importing.body import Options
from grasp_bench.workshop.importing.discovery import find_objects
from grasp_bench.workshop.importing.folder import RefusedError, read_plain
from grasp_bench.workshop.importing.importer import FAMILY, Job
from grasp_bench.workshop.importing.masses import MASSES
from grasp_bench.workshop.importing.naming import clean_name
from grasp_bench.workshop.importing.repair import HOLES
from grasp_bench.workshop.importing.units import LONGEST, UNITS

FRICTIONS = (0.05, 2.0)


@dataclass(frozen=True)
class Plan:
    """The objects to import, and what is to be said of those that are left out or renamed."""

    jobs: list[Job]
    notes: list[str]


def plan_jobs(
    path: Path, out: Path, *, name: str | None = None, masses: Path | None = None, **settings: Any
) -> Plan:
    """Plan the jobs for a file or folder.

    Args:
        path: file or folder to import.
        out: where the objects go; it must not be a folder of modelled objects.
        name: what a single object is to be called.
        masses: CSV file with columns ``name`` and ``mass_kg``.
        settings: fields of :class:`~grasp_bench.workshop.importing.body.Options`.

    Raises:
        GraspBenchError: for settings, files and folders that make no sense, with the remedy.
    """
    options = Options(**settings)
    _check(options, masses)
    _check_target(out)
    found = find_objects(path, name)
    count = len(found.objects)
    if options.mass is not None and count > 1:
        raise GraspBenchError(
            f"--mass is for one object, but {path} holds {count}; give --masses or --density."
        )
    if options.length is not None and count > 1:
        raise GraspBenchError(f"--length is for one object, but {path} holds {count}; give --scale.")
    table = {} if masses is None else read_masses(masses)
    names = [n for n, _, _ in found.objects]
    unknown = [n for n in table if n not in names]
    if unknown:
        raise UnknownNameError(f"object in {masses}, line {table[unknown[0]].line}:", unknown[0], names)
    notes = list(found.notes)
    without = [n for n in names if n not in table]
    if table and without:
        shown = ", ".join(without[:8]) + (" …" if len(without) > 8 else "")
        notes.append(f"{masses} has no mass for {shown}: assumed")
    return Plan(
        [
            Job(
                label,
                file,
                root,
                replace(options, mass=table[label].mass if label in table else options.mass),
                str(file),
            )
            for label, file, root in found.objects
        ],
        notes,
    )


def _check(options: Options, masses: Path | None) -> None:
    for kind, value, valid in (
        ("unit", options.units, (*UNITS, "auto")),
        ("upward axis", options.up, ("y", "z", "auto")),
        ("inertia", options.inertia, ("solid", "shell")),
        ("way with holes", options.holes, HOLES),
    ):
        if value not in valid:
            raise UnknownNameError(kind, value, valid)
    if sum(x is not None for x in (options.mass, options.density, masses)) > 1:
        raise GraspBenchError("Give one of --mass, --masses and --density.")
    if options.mass is not None and not MASSES[0] <= options.mass <= MASSES[1]:
        raise GraspBenchError(
            f"--mass {options.mass:g}: {MASSES[0]:g} to {MASSES[1]:g} kg can be lifted and simulated."
        )
    if options.density is not None and not 1 <= options.density <= 25_000:
        raise GraspBenchError(f"--density {options.density:g} is not that of a solid; 1 to 25000 kg/m³.")
    if sum((options.units != "auto", options.length is not None, options.scale is not None)) > 1:
        raise GraspBenchError("Give one of --units, --length and --scale.")
    if options.length is not None and not LONGEST[0] <= options.length <= LONGEST[1]:
        metres = f"; {options.length:g} mm are {options.length / 1000:g}" if options.length > 1 else ""
        raise GraspBenchError(
            f"--length {options.length:g} is not between {LONGEST[0]:g} and {LONGEST[1]:g} metres{metres}."
        )
    if options.scale is not None and not 1e-6 <= options.scale <= 1e6:
        raise GraspBenchError(
            f"--scale {options.scale:g}: the metres that the file's unit is, 0.001 for millimetres."
        )
    if not FRICTIONS[0] <= options.friction <= FRICTIONS[1]:
        raise GraspBenchError(
            f"--friction {options.friction:g} is not between {FRICTIONS[0]:g} and {FRICTIONS[1]:g}."
        )


def _check_target(out: Path) -> None:
    """Refuse a folder that holds anything but imported objects."""
    manifest = out / MANIFEST
    if out.exists() and not out.is_dir():
        raise GraspBenchError(f"--out {out} is not a folder.")
    if manifest.is_file():
        try:
            families = {e["family"] for e in json.loads(manifest.read_text())["objects"]}
        except (ValueError, KeyError, TypeError) as error:
            raise GraspBenchError(f"{manifest} is not a valid manifest; choose another --out.") from error
        if families - {FAMILY}:
            raise GraspBenchError(f"{out} holds objects that were not imported; choose another --out.")


@dataclass(frozen=True)
class Weighed:
    """A mass [kg] and the line of the table that gives it."""

    mass: float
    line: int


def read_masses(path: Path) -> dict[str, Weighed]:
    """Read masses by object name.

    Raises:
        GraspBenchError: naming the line at fault.
    """
    try:
        text = read_plain(path).decode("utf-8-sig")
    except FileNotFoundError:
        raise GraspBenchError(f"--masses {path} does not exist.") from None
    except (UnicodeDecodeError, RefusedError) as error:
        raise GraspBenchError(f"--masses {path} cannot be read ({error}).") from error
    rows = csv.DictReader(text.splitlines())
    if not {"name", "mass_kg"} <= set(rows.fieldnames or ()):
        raise GraspBenchError(f"{path} must start with the line name,mass_kg.")
    table: dict[str, Weighed] = {}
    for row in rows:
        try:
            mass = float(row["mass_kg"])
            if not MASSES[0] <= mass <= MASSES[1]:
                raise ValueError(f"{MASSES[0]:g} to {MASSES[1]:g} kg can be lifted and simulated")
            name = clean_name(row["name"])
            if name in table:
                raise ValueError(f"{name} is there twice, first in line {table[name].line}")
            table[name] = Weighed(mass, rows.line_num)
        except (TypeError, ValueError, AttributeError, RefusedError) as error:
            raise GraspBenchError(f"{path}, line {rows.line_num}: {error}.") from error
    return table
