"""Colours of a scene under lamps: shadows, highlights and textures.

Light is added up in linear colour (display colours to the power 2.2), each lamp by Lambert's law with the
inverse square of its distance, and by Blinn's and Phong's highlight where the surface is smooth. A shadow ray
a lamp goes to every second pixel both ways; what lies between is blended.
"""

from __future__ import annotations

import cv2
import mujoco
import numpy as np
from numpy.typing import NDArray

from grasp_bench.scenario.look import Lamp, Look, Texture
from grasp_bench.scenario.sections import Scenario
from grasp_bench.scene.builder import FLOOR, TABLE
from grasp_bench.scene.rendering import SHOWN_GROUPS, Draw, Hits, Picture, cast
from grasp_bench.scene.surfaces import geom_colors, surfaces
from grasp_bench.scene.surroundings import fixture_name
from grasp_bench.scene.textures import amount
from grasp_bench.system.arrays import Floats

GAMMA = 2.2
SHADOW_STRIDE = 2
SHARPEST = 0.3
"""Smoother surfaces have the highlights of this roughness: sharper ones fall between the pixels."""
LIT = 0.995
"""A shadow ray that gets so far of its way reaches the surface."""


def drawer(scenario: Scenario) -> Draw | None:
    """Return what draws pictures with the scenario's look; None where it has none."""
    if scenario.look is None:
        return None

    def draw(model: mujoco.MjModel, data: mujoco.MjData, origin: Floats, directions: Floats) -> Picture:
        return Shader(scenario, model).picture(data, origin, directions)

    return draw


class Shader:
    """Draws pictures of one scenario's look.

    Args:
        scenario: has a ``look``.
        model: compiled from it.
    """

    def __init__(self, scenario: Scenario, model: mujoco.MjModel) -> None:
        assert scenario.look is not None
        self.look: Look = scenario.look
        self.model = model
        self._center = np.array([*scenario.table.center, 0.0])
        self._colors = geom_colors(model) ** GAMMA
        self._roughness = surfaces(model).roughness
        self._textures = self._assigned(scenario)

    def _assigned(self, scenario: Scenario) -> dict[int, Texture]:
        model, look = self.model, self.look
        found: dict[int, Texture] = {}
        for name, texture in ((TABLE, look.table), (FLOOR, look.floor)):
            if texture is not None:
                found[model.geom(name).id] = texture
        if scenario.surroundings is not None:
            for i, fixture in enumerate(scenario.surroundings.fixtures):
                if fixture.texture is not None:
                    found[model.geom(fixture_name(i)).id] = fixture.texture
        if look.objects:
            parts = [
                g
                for g in range(model.ngeom)
                if SHOWN_GROUPS[model.geom_group[g]]
                and model.body(model.geom_bodyid[g]).name.startswith("object")
            ]
            for i, geom in enumerate(parts):
                found[geom] = look.objects[i % len(look.objects)]
        return found

    def picture(self, data: mujoco.MjData, origin: Floats, directions: Floats) -> Picture:
        """Cast rays (H, W, 3), each with z = 1 in its camera's frame, from ``origin`` (3,)."""
        shape = directions.shape[:2]
        rays = np.ascontiguousarray(directions.reshape(-1, 3))
        hits = cast(self.model, data, origin, rays)
        hit = hits.geom >= 0
        cosine = np.einsum("ij,ij->i", hits.normal, rays) / np.linalg.norm(rays, axis=1)
        normal = hits.normal * -np.sign(cosine)[:, None]
        points = origin + rays * hits.distance[:, None]
        color = self._surface(data, hits, points)
        light, gloss = self._light(data, origin, rays, points, normal, hits, shape)
        seen = np.where(hit[:, None], color * light + gloss, np.power(self.look.background, GAMMA))
        rgb = np.rint(255 * np.clip(seen, 0, 1) ** (1 / GAMMA)).astype(np.uint8)
        return Picture(
            rgb.reshape(*shape, 3),
            np.where(hit, hits.distance, 0).astype(np.float32).reshape(shape),
            np.where(hit, np.abs(cosine), 0).astype(np.float32).reshape(shape),
            hits.geom.reshape(shape),
        )

    def _surface(self, data: mujoco.MjData, hits: Hits, points: Floats) -> NDArray[np.float32]:
        """Return the (N, 3) linear base colours, textures included."""
        color = self._colors[hits.geom].astype(np.float32)
        for geom, texture in self._textures.items():
            at = np.flatnonzero(hits.geom == geom)
            if len(at):
                local = (points[at] - data.geom_xpos[geom]) @ data.geom_xmat[geom].reshape(3, 3)
                share = amount(texture, local)[:, None]
                ink = np.float32(np.power(texture.color, GAMMA))
                color[at] += share * (ink - color[at])
        return color

    def _light(
        self,
        data: mujoco.MjData,
        origin: Floats,
        rays: Floats,
        points: Floats,
        normal: Floats,
        hits: Hits,
        shape: tuple[int, ...],
    ) -> tuple[Floats, Floats]:
        """Return light that falls on (N, 3) and is mirrored by (N, 3) the surfaces."""
        look = self.look
        light = np.tile(look.ambient * np.array(look.ambient_color), (len(points), 1))
        gloss = np.zeros_like(light)
        smooth = np.append(1 - self._roughness, 0.0)[hits.geom]
        exponent = 2 / np.clip(np.append(self._roughness, 1.0)[hits.geom], SHARPEST, 1) ** 4
        view = -rays / np.linalg.norm(rays, axis=1)[:, None]
        for lamp in look.lamps:
            way = np.array(lamp.position) - points
            distance = np.linalg.norm(way, axis=1)
            way /= distance[:, None]
            reference = np.linalg.norm(np.array(lamp.position) - self._center)
            facing = np.einsum("ij,ij->i", normal, way)
            reaches = lamp.strength * np.minimum((reference / distance) ** 2, 4.0)
            reaches *= self._reached(data, lamp, points, hits, shape) * (facing > 0)
            light += (reaches * facing)[:, None] * np.array(lamp.color)
            if look.highlights and smooth.any():
                half = way + view
                half /= np.linalg.norm(half, axis=1)[:, None]
                peak = np.clip(np.einsum("ij,ij->i", normal, half), 0, 1) ** exponent
                gloss += (look.highlights * reaches * smooth * peak)[:, None] * np.array(lamp.color)
        return light, gloss

    def _reached(
        self, data: mujoco.MjData, lamp: Lamp, points: Floats, hits: Hits, shape: tuple[int, ...]
    ) -> NDArray[np.float32]:
        """Return the (N,) share of a lamp's light that nothing is in the way of."""
        height, width = shape
        every = np.ix_(range(0, height, SHADOW_STRIDE), range(0, width, SHADOW_STRIDE))
        index = np.arange(height * width).reshape(shape)[every]
        away = points[index.ravel()] - lamp.position
        met = cast(self.model, data, np.array(lamp.position), np.ascontiguousarray(away))
        lit = ((met.geom < 0) | (met.distance > LIT) | (hits.geom[index.ravel()] < 0)).astype(np.float32)
        whole = cv2.resize(lit.reshape(index.shape), (width, height), interpolation=cv2.INTER_LINEAR)
        if self.look.shadow_blur:
            whole = cv2.GaussianBlur(whole, (0, 0), self.look.shadow_blur)
        return np.asarray(whole, np.float32).ravel()
