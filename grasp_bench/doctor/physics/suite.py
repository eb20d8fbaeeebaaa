"""All self-tests in order, and their table."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from grasp_bench.doctor.physics.check import Check
from grasp_bench.doctor.physics.creep import creep
from grasp_bench.doctor.physics.falling import falling
from grasp_bench.doctor.physics.incline import incline
from grasp_bench.doctor.physics.jacobian import jacobian
from grasp_bench.doctor.physics.margin import margin
from grasp_bench.doctor.physics.penetration import penetration
from grasp_bench.doctor.physics.reference import Watched, halved, loads, time_step, watch
from grasp_bench.doctor.physics.slip import slip
from grasp_bench.doctor.physics.suction import suction
from grasp_bench.doctor.physics.torsion import torsion
from grasp_bench.doctor.physics.tracking import tracking
from grasp_bench.robot.cup import SuctionCup
from grasp_bench.robot.gripper import Gripper
from grasp_bench.scenario.sections import Scenario

if TYPE_CHECKING:
    from rich.table import Table

Test = Callable[[Scenario], list[Check]]
QUICK: tuple[Test, ...] = (slip, incline, torsion, margin, creep, falling, jacobian, penetration, tracking)
"""Checks that take seconds each."""
OF_GRIPPER: tuple[Test, ...] = (slip, torsion, creep, jacobian, penetration)
"""Those of them that another gripper can change."""

OF_CUP: tuple[Test, ...] = (suction, creep, jacobian)
"""Those of a suction cup."""


def tests_of(gripper: Gripper) -> tuple[Test, ...]:
    """Return the checks that ``gripper`` can change."""
    return OF_CUP if isinstance(gripper, SuctionCup) else OF_GRIPPER


@dataclass(frozen=True)
class Trials:
    """The oracle's trials at the scenario's time step, and at half of it."""

    whole: list[Watched]
    half: list[Watched]


def trials(
    scenario: Scenario,
    workers: int,
    objects: list[str] | None = None,
    progress: Callable[[], None] = lambda: None,
) -> Trials:
    """Do the reference trials twice; ``progress`` is called after each."""
    return Trials(
        *(watch(s, objects, workers=workers, progress=progress) for s in (scenario, halved(scenario)))
    )


def judged(done: Trials) -> list[Check]:
    """Return the checks of the reference trials."""
    return [*loads(done.whole), time_step(done.whole, done.half)]


def table(checks: list[Check]) -> Table:
    """Return the checks as a table for the terminal."""
    from rich.table import Table
    from rich.text import Text

    title = "Physics against closed forms"
    shown = Table(title=title, title_justify="left", title_style="bold", box=None, padding=(0, 1))
    for name in ("", "Check"):
        shown.add_column(name)
    for name in ("Expected", "Measured", "Error", "Allowed"):
        shown.add_column(name, justify="right")
    for check in checks:
        mark = Text("ok", style="green") if check.passed else Text("bad", style="bold red")
        shown.add_row(mark, Text(check.name), *(Text(cell) for cell in cells(check)))
    return shown


def cells(check: Check) -> tuple[str, str, str, str]:
    """Return expected, measured, error and tolerance as they are read."""
    unit = f" {check.unit}" if check.unit else ""
    if check.relative:
        return (
            f"{check.expected:.4g}{unit}",
            f"{check.measured:.4g}{unit}",
            f"{check.error:.2%}",
            f"{check.tolerance:.2%}",
        )
    return "0", f"{check.measured:.3g}{unit}", f"{check.error:.3g}{unit}", f"{check.tolerance:.3g}{unit}"


def markdown(checks: list[Check]) -> str:
    """Return the checks as a table for the documentation."""
    lines = [
        "| check | closed form or limit | expected | measured | error | allowed | |",
        "|---|---|--:|--:|--:|--:|---|",
    ]
    for check in checks:
        lines.append(
            f"| {check.name} | {check.source.replace('|', chr(92) + '|')} | "
            f"{' | '.join(cells(check))} | {'passed' if check.passed else '**failed**'} |"
        )
    return "\n".join(lines) + "\n"
