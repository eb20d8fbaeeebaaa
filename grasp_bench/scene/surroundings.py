"""Fixtures of a scene, as MJCF."""

from __future__ import annotations

from typing import Any

from grasp_bench.scenario.sections import Scenario
from grasp_bench.scenario.surroundings import Fixture

SEEN_GROUP = 1
"""Of table, floor and fixtures, which are all that this group holds."""
UNTOUCHED = {"contype": 0, "conaffinity": 0}
"""Attributes of geoms that are only seen."""
FIXTURE = "fixture"
"""What the names of fixtures' geoms begin with."""


def fixture_name(which: int) -> str:
    """Return the name of the geom of the ``which``-th fixture."""
    return f"{FIXTURE}{which}"


def table_top(scenario: Scenario) -> tuple[list[float], list[float]]:
    """Return the size in x and y of the table top that is seen, and its centre [m]."""
    around, table = scenario.surroundings, scenario.table
    if around is None or around.table is None:
        return list(table.size), list(table.center)
    x0, y0, x1, y1 = around.table
    return [x1 - x0, y1 - y0], [(x0 + x1) / 2, (y0 + y1) / 2]


def add_fixtures(root: Any, scenario: Scenario) -> None:
    """Add what the scenario has around its table to an MJCF model."""
    if scenario.surroundings is not None:
        for i, fixture in enumerate(scenario.surroundings.fixtures):
            root.worldbody.add("geom", name=fixture_name(i), **_geom(fixture))


def _geom(fixture: Fixture) -> dict[str, Any]:
    from scipy.spatial.transform import Rotation

    x, y, z = fixture.size
    size = {
        "box": [x / 2, y / 2, z / 2],
        "ellipsoid": [x / 2, y / 2, z / 2],
        "cylinder": [x / 2, z / 2],
        "capsule": [x / 2, max(z - x, 1e-3) / 2],
    }[fixture.shape]
    turn = Rotation.from_euler("xyz", fixture.turn_deg, degrees=True)
    return {
        "type": fixture.shape,
        "size": size,
        "pos": list(fixture.position),
        "quat": turn.as_quat(scalar_first=True).tolist(),
        "rgba": [*fixture.color, 1],
        "user": [max(fixture.roughness, 0.01)],
        "group": SEEN_GROUP,
        **({} if fixture.solid else UNTOUCHED),
    }
