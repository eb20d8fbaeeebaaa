"""Draws the rooms of the package and the imports between them: ``python scripts/make_structure.py``.

Writes docs/images/structure.svg and the table of rooms in docs/design.md, from the layers that import-linter
holds (pyproject.toml), the first sentence of every room, and the imports as they are.
"""

from __future__ import annotations

import ast
import tomllib
from html import escape
from pathlib import Path

import grimp
from make_tables import replace

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = "grasp_bench"
ROW, BOX, GAP, LEFT = 62, 34, 18, 24


def layers() -> list[list[str]]:
    """Rooms of each layer, from the top."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["importlinter"]["contracts"]
    (found,) = [c["layers"] for c in contracts if c["type"] == "layers"]
    return [[room.strip() for room in layer.split("|")] for layer in found]


def sentence(room: str) -> str:
    """What a room is for: the first line of its docstring."""
    module = ROOT / PACKAGE / room
    file = module / "__init__.py" if module.is_dir() else module.with_suffix(".py")
    return (ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or "").split("\n")[0]


def arrows() -> dict[tuple[str, str], int]:
    """How many modules of the first room import something of the second."""
    graph = grimp.build_graph(PACKAGE)
    counted: dict[tuple[str, str], int] = {}
    for importer in graph.modules:
        for imported in graph.find_modules_directly_imported_by(importer):
            above, below = (m.split(".")[1] if "." in m else "" for m in (importer, imported))
            if above and below and above != below:
                counted[above, below] = counted.get((above, below), 0) + 1
    return counted


def as_svg(rows: list[list[str]], imports: dict[tuple[str, str], int]) -> str:
    """The rooms in their layers; arrows run down from those that import to those that are imported."""
    widths = {room: 26 + 8.2 * len(room) for row in rows for room in row}
    total = max(sum(widths[r] + GAP for r in row) for row in rows)
    width, height = 2 * LEFT + max(total, 640), 2 * LEFT + ROW * (len(rows) - 1) + BOX
    places: dict[str, tuple[float, float]] = {}
    for level, row in enumerate(rows):
        free = width - sum(widths[r] for r in row)
        x = free / (len(row) + 1)
        for room in row:
            places[room] = (x, LEFT + ROW * level)
            x += widths[room] + free / (len(row) + 1)
    lines = []
    for (above, below), count in sorted(imports.items()):
        if above not in places or below not in places:
            continue
        (x0, y0), (x1, y1) = places[above], places[below]
        start, end = x0 + widths[above] / 2, x1 + widths[below] / 2
        bend = (start + end) / 2 + (60 if (y1 - y0) > 1.5 * ROW else 0) * (1 if start <= end else -1)
        path = f"M{start:.0f},{y0 + BOX:.0f} Q{bend:.0f},{(y0 + y1 + BOX) / 2:.0f} {end:.0f},{y1:.0f}"
        shade = min(0.14 + 0.04 * count, 0.6)
        title = f"<title>{above} → {below}: {count}</title>"
        lines.append(f'<path d="{path}" stroke-opacity="{shade:.2f}">{title}</path>')
    boxes = [
        f'<g><title>{escape(sentence(room))}</title><rect x="{x:.0f}" y="{y}" width="{widths[room]:.0f}" '
        f'height="{BOX}" rx="6"/><text x="{x + widths[room] / 2:.0f}" y="{y + 22}">{room}</text></g>'
        for room, (x, y) in places.items()
    ]
    style = (
        "svg{background:#fff}path{fill:none;stroke:#0b6e99;stroke-width:1.4}"
        "rect{fill:#eef6f9;stroke:#0b6e99}text{font:14px sans-serif;text-anchor:middle;fill:#123}"
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height}" role="img" '
        f'aria-label="The rooms of grasp-bench, every import running down"><style>{style}</style>'
        + "\n".join([*lines, *boxes])
        + "</svg>\n"
    )


def main() -> None:
    rows, imports = layers(), arrows()
    (ROOT / "docs" / "images" / "structure.svg").write_text(as_svg(rows, imports), encoding="utf-8")
    table = ["| room | what it is for |", "|---|---|"]
    table += [f"| `{room}` | {sentence(room)} |" for row in rows for room in row]
    replace(ROOT / "docs" / "design.md", "rooms", "\n".join(table) + "\n")
    print(f"{sum(map(len, rows))} rooms on {len(rows)} floors, {len(imports)} arrows, all running down.")


if __name__ == "__main__":
    main()
