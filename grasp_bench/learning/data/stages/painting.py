"""Random colours, textures and lamps."""

from __future__ import annotations

import colorsys

import numpy as np

from grasp_bench.learning.data.random_shapes import random_color
from grasp_bench.learning.data.stages.style import ColourStyle
from grasp_bench.scenario.look import PATTERNS, Color, Lamp, Look, Pattern, Texture

Rng = np.random.Generator

ON_TABLES: tuple[Pattern, ...] = (
    "clouds",
    "grain",
    "grain",
    "speckles",
    "speckles",
    "marble",
    "checks",
    "stripes",
)
ON_OBJECTS: tuple[Pattern, ...] = ("stripes", "checks", "patches", "patches", "clouds", "speckles")


def near(color: Color, rng: Rng, sigma: float = 0.02) -> Color:
    """Return a colour like ``color``."""
    r, g, b = np.clip(np.asarray(color) + rng.normal(0, sigma, 3) + rng.normal(0, sigma), 0, 1)
    return float(r), float(g), float(b)


def surface_color(rng: Rng, white: float, vivid: float = 1.0) -> Color:
    """Draw the colour of a surface: with chance ``white`` nearly white, else with chance ``vivid`` any, else
    as furniture and walls are: grey, brown or pale."""
    if rng.random() < white:
        return near((0.9, 0.89, 0.87), rng, 0.03)
    r, g, b = random_color(rng)
    if rng.random() >= vivid:
        hue, value = (
            rng.uniform(0.02, 0.65) if rng.random() < 0.3 else rng.uniform(0.05, 0.12),
            rng.uniform(0.15, 0.9),
        )
        r, g, b = colorsys.hsv_to_rgb(hue, rng.uniform(0, 0.5) * rng.random(), value)
    return float(r), float(g), float(b)


def texture(rng: Rng, color: Color, kinds: tuple[str, ...] = PATTERNS, finest: float = 0.003) -> Texture:
    """Draw a texture for a surface of ``color``; the pattern's is a like one, or any."""
    faint = rng.random() < (0.85 if kinds == ON_TABLES else 0.5)
    return Texture.model_validate(
        {
            "pattern": str(rng.choice(list(kinds))),
            "color": near(color, rng, 0.12) if faint else surface_color(rng, 0.1),
            "scale": float(np.exp(rng.uniform(np.log(finest), np.log(0.08)))),
            "contrast": float(rng.uniform(0.2, 0.7) if faint else rng.uniform(0.1, 1.0)),
            "turn_deg": float(rng.uniform(0, 180)),
            "seed": int(rng.integers(1 << 20)),
        }
    )


def look(rng: Rng, style: ColourStyle, center: tuple[float, float], table: Color) -> Look:
    """Draw lamps around and above ``center``, and textures for a table of colour ``table``."""
    count = int(rng.integers(style.lamps[0], style.lamps[1] + 1))
    ambient = float(rng.uniform(*style.ambient))
    strengths = rng.dirichlet(np.full(count, 2.0)) * (1.05 - ambient)
    lamps = []
    for strength in strengths:
        elevation, azimuth = np.radians(rng.uniform(25, 88)), rng.uniform(0, 2 * np.pi)
        away = rng.uniform(0.8, 2.5)
        flat = away * np.cos(elevation)
        lamps.append(
            Lamp(
                position=(
                    float(center[0] + flat * np.cos(azimuth)),
                    float(center[1] + flat * np.sin(azimuth)),
                    float(away * np.sin(elevation)),
                ),
                color=_tinted(rng, style.tint),
                strength=float(strength / max(np.sin(elevation), 0.5)),
            )
        )
    parts = tuple(
        texture(rng, surface_color(rng, 0.3), ON_OBJECTS)
        for _ in range(int(rng.integers(1, 4)) if rng.random() < style.object_texture else 0)
    )
    return Look(
        lamps=tuple(lamps),
        ambient=ambient,
        ambient_color=_tinted(rng, style.tint / 2),
        shadow_blur=float(rng.uniform(0.5, 6)),
        highlights=float(rng.uniform(0, 0.6)),
        background=surface_color(rng, 0.2),
        table=texture(rng, table, ON_TABLES) if rng.random() < style.table_texture else None,
        floor=texture(rng, table, ON_TABLES, finest=0.01) if rng.random() < 0.5 else None,
        objects=parts,
    )


def _tinted(rng: Rng, tint: float) -> Color:
    r, g, b = 1 - rng.uniform(0, tint, 3)
    return float(r), float(g), float(b)
