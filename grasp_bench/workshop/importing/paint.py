"""Colours of a mesh from textures, vertices or materials, baked to parts of one colour each.

The simulation's ray caster and the catalog's files know one colour a part. A textured mesh is
therefore split into faces of at most about the camera's resolution (1.7 mm a pixel on the
table), each face takes the texture's mean colour over it, and faces of like colour, out of at
most :data:`MAX_COLORS`, become a part.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import trimesh
from numpy.typing import NDArray
from PIL import Image
from scipy.spatial import cKDTree

from grasp_bench.objects.catalog import VisualPart
from grasp_bench.system.arrays import Floats, Ints
from grasp_bench.workshop.importing.obj_text import map_options
from grasp_bench.workshop.importing.textures import Textures

MAX_COLORS = 28
MAX_FACES = 60_000
"""Greatest number of faces of the coloured mesh, after splitting."""
DETAIL = 0.0025
"""Edges of painted faces are split to this length [m], or longer to keep below :data:`MAX_FACES`."""
LEAST_AREA, LEAST_SHARE = 25e-6, 0.01
"""Colours of less area than this [m²], and of less than this share of all, go to the nearest other colour."""
CHUNK = 60_000
"""Greatest number of faces of a part: MuJoCo reads meshes of at most 200 000."""
WEIGHED = 50_000
"""Pixels by which the colours of the whole surface are weighed."""
PLAIN = (0.62, 0.62, 0.60)
"""Colour of a mesh without colours, in [0, 1]."""
SAMPLES = np.array([[1, 1, 1], [4, 1, 1], [1, 4, 1], [1, 1, 4]], float) / [[3], [6], [6], [6]]
"""Barycentric places on a face whose mean is its colour."""


@dataclass(frozen=True)
class Paint:
    """The colours of F faces.

    Attributes:
        corner_rgb: (F, 3, 3) colour at each corner in [0, 1]; multiplies the texture.
        corner_uv: (F, 3, 2) texture coordinates, origin at the picture's lower left; NaN without.
        texture: (F,) index into ``pictures``, −1 for none.
        pictures: (H, W, 3) uint8 textures.
        roughness: 0 to 1.
    """

    corner_rgb: Floats
    corner_uv: Floats
    texture: Ints
    pictures: list[NDArray[np.uint8]]
    roughness: float = 0.5

    @property
    def varied(self) -> bool:
        """Whether some face has more than one colour."""
        return bool((self.texture >= 0).any() or (np.ptp(self.corner_rgb, axis=1) > 0.02).any())

    def at(self, face: Ints, places: Floats) -> Floats:
        """Return colours (N, 3) at barycentric ``places`` (N, 3) of ``face`` (N,)."""
        rgb = np.einsum("nc,nck->nk", places, self.corner_rgb[face])
        for i, picture in enumerate(self.pictures):
            which = np.nonzero(self.texture[face] == i)[0]
            uv = np.einsum("nc,nck->nk", places[which], self.corner_uv[face[which]])
            height, width = picture.shape[:2]
            # Pictures repeat, but a face that ends on an edge of the picture must not cross it.
            corners = self.corner_uv[face[which]]
            low, high = corners.min(1), corners.max(1)
            uv -= np.floor(np.where((high - low < 1e-6) & (low > 0.5), low - 1e-6, low + 1e-6))
            across = uv > 1 + 1e-5
            u, v = np.where(across, uv % 1, np.clip(uv, 0, 1)).T
            column = np.floor(u * width).astype(int).clip(0, width - 1)
            row = np.floor((1 - v) * height).astype(int).clip(0, height - 1)
            rgb[which] *= picture[row, column] / 255
        return rgb


def read_paint(mesh: trimesh.Trimesh, textures: Textures, picture: Image.Image | None = None) -> Paint:
    """Read the colours of a loaded mesh, whose pictures are tokens of ``textures``; ``picture`` is its
    texture where it has coordinates but no texture.
    """
    count = len(mesh.faces)
    corner_rgb = np.ones((count, 3, 3)) * PLAIN
    uv = np.full((count, 3, 2), np.nan)
    texture, pictures, roughness = np.full(count, -1), [], 0.5
    visual: Any = mesh.visual
    if visual.kind == "texture":
        material = visual.material
        image = getattr(material, "baseColorTexture", None)
        image = getattr(material, "image", None) if image is None else image
        if getattr(image, "format", None) is None:  # trimesh's own grey square where there is no picture
            image = picture
        factor = getattr(material, "baseColorFactor", None)
        if factor is None and image is None:
            factor = getattr(material, "diffuse", None)
        if factor is not None:
            corner_rgb[:] = _unit(np.asarray(factor)[:3])
        if isinstance(getattr(material, "roughnessFactor", None), (int, float)):
            roughness = float(np.clip(material.roughnessFactor, 0, 1))
        coordinates = getattr(visual, "uv", None)
        if image is not None and coordinates is not None and len(coordinates) == len(mesh.vertices):
            found = np.asarray(coordinates, float)[mesh.faces][..., :2]
            if np.isfinite(found).all():
                _, scale, offset = map_options(str(image.info.get("file_path", "")))
                uv, texture[:] = found * scale + offset, 0
                own = image is picture
                pictures.append(np.asarray(image.convert("RGB")) if own else textures.behind(image))
                if factor is None:
                    corner_rgb[:] = 1.0
    elif visual.kind == "vertex":
        corner_rgb = np.asarray(visual.vertex_colors)[mesh.faces][..., :3] / 255
    elif visual.kind == "face":
        corner_rgb = np.repeat(np.asarray(visual.face_colors)[:, None, :3] / 255, 3, axis=1)
    return Paint(np.clip(corner_rgb, 0, 1), uv, texture, pictures, roughness)


def _unit(color: NDArray) -> Floats:
    return np.asarray(color, float) / (255 if color.dtype.kind in "iu" or color.max() > 1 else 1)


def join(paints: list[Paint]) -> Paint:
    """Return the paint of meshes put one after the other."""
    pictures: list[NDArray[np.uint8]] = []
    texture = []
    for paint in paints:
        texture.append(np.where(paint.texture >= 0, paint.texture + len(pictures), -1))
        pictures += paint.pictures
    counts = np.array([max(len(p.texture), 1) for p in paints], float)
    return Paint(
        np.concatenate([p.corner_rgb for p in paints]),
        np.concatenate([p.corner_uv for p in paints]),
        np.concatenate(texture),
        pictures,
        float(np.average([p.roughness for p in paints], weights=counts)),
    )


def bake(vertices: Floats, faces: Ints, source: Ints, paint: Paint) -> list[VisualPart]:
    """Make parts of one colour each.

    Args:
        vertices: (V, 3) those of the mesh [m].
        faces: (F, 3) those of the mesh.
        source: (F,) the painted face each came from, −1 for one that was added in repair.
        paint: the colours of the source faces.
    """
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    origin = np.arange(len(faces))
    if paint.varied:
        # A triangle of edge e has an area of about e²/3 once longest edges are halved.
        edge = max(DETAIL, float(np.sqrt(3 * mesh.area / MAX_FACES)))
        while True:
            divided: Any = trimesh.remesh.subdivide_to_size(
                mesh.vertices, mesh.faces, edge, max_iter=30, return_index=True
            )
            fine, split, origin = divided
            if len(split) <= max(MAX_FACES, 1.2 * len(faces)):
                break
            edge *= 1.3
        vertices, faces = np.asarray(fine), np.asarray(split)
    corners = np.asarray(mesh.vertices)[mesh.faces[origin]]
    rgb = np.zeros((len(faces), 3))
    painted = np.nonzero(source[origin] >= 0)[0]
    for sample in SAMPLES:
        points = np.einsum("c,fck->fk", sample, vertices[faces[painted]])
        places = trimesh.triangles.points_to_barycentric(corners[painted], points)
        places = np.clip(np.nan_to_num(places, nan=1 / 3), 0, 1)
        places /= places.sum(1, keepdims=True)
        rgb[painted] += paint.at(source[origin[painted]], places) / len(SAMPLES)
    added = np.nonzero(source[origin] < 0)[0]
    if len(added):
        # What closes a hole takes the colour of the nearest painted face.
        centres = vertices[faces].mean(1)
        nearest = cKDTree(centres[painted]).query(centres[added])[1] if len(painted) else None
        rgb[added] = PLAIN if nearest is None else rgb[painted[nearest]]
    corners = vertices[faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    return [
        VisualPart(*_compact(vertices, faces[label[i : i + CHUNK]]), color, paint.roughness)
        for color, label in _palette(rgb, areas)
        for i in range(0, len(label), CHUNK)
    ]


def _compact(vertices: Floats, faces: Ints) -> tuple[Floats, NDArray[np.int32]]:
    used, index = np.unique(faces, return_inverse=True)
    return vertices[used], index.reshape(-1, 3).astype(np.int32)


def _palette(rgb: Floats, areas: Floats) -> list[tuple[tuple[float, float, float], Ints]]:
    """Return colours, and the faces of each, the largest area first."""
    pixels = np.round(rgb * 255).astype(np.uint8)
    kinds, index = np.unique(pixels, axis=0, return_inverse=True)
    index = index.reshape(-1)
    total = float(areas.sum()) or 1.0
    if len(kinds) > MAX_COLORS:
        # A face counts by its area, not as one: large faces of a plain colour are few.
        counts = np.maximum(1, np.round(WEIGHED * areas / total)).astype(int)
        weighed = Image.fromarray(np.repeat(pixels, counts, axis=0)[None])
        quantized = weighed.quantize(MAX_COLORS, Image.Quantize.MEDIANCUT, kmeans=3)
        index = np.asarray(quantized)[0][np.cumsum(counts) - counts]
    area = {k: float(areas[index == k].sum()) for k in np.unique(index).tolist()}
    labels = sorted(area, key=lambda k: -area[k])
    means = {k: rgb[index == k].mean(0) for k in labels}
    large = [k for k in labels if area[k] >= min(LEAST_AREA, LEAST_SHARE * total)] or labels[:1]
    into = {
        k: k if k in large else min(large, key=lambda m: float(np.abs(means[m] - means[k]).sum()))
        for k in labels
    }
    merged = np.array([into[k] for k in index.tolist()])
    return [
        ((float(c[0]), float(c[1]), float(c[2])), np.nonzero(merged == k)[0])
        for k in large
        for c in [rgb[merged == k].mean(0)]
    ]
