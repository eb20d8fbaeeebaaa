"""Repairs of meshes that somebody scanned or drew: what can be mended is, and is said.

Metres and z up. Nothing here changes the shape beyond what a finding names.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import mapbox_earcut
import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from shapely.geometry import Polygon

from grasp_bench.system.arrays import Floats, Ints
from grasp_bench.workshop.importing.folder import RefusedError

WELD = 1e-6
"""Vertices nearer than this share of the diagonal are one."""
SPECK = 0.03
"""Loose pieces smaller than this share of the diagonal, and than 0.2 % of the surface, are dropped."""
STRAY = 3.0
"""What is this many times the bulk's half-diagonal away from its middle is no part of the object."""
SMALL_HOLE = 0.02
"""Holes of at most this share of the surface are closed wherever they are."""
HOLES = ("auto", "fill", "keep")


@dataclass
class Mended:
    """A mesh under repair.

    Attributes:
        vertices: (V, 3) those of the mesh [m].
        faces: (F, 3).
        source: (F,) the face of the file each came from, −1 for added ones.
        notes: what was done, in plain words.
        open: (F,) faces of pieces that still have an open border.
    """

    vertices: Floats
    faces: Ints
    source: Ints
    notes: list[str] = field(default_factory=list)
    open: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool))

    def keep(self, mask: NDArray[np.bool_]) -> None:
        """Drop the faces that are not in ``mask`` (F,)."""
        self.faces, self.source = self.faces[mask], self.source[mask]


def mend(vertices: Floats, faces: Ints, holes: str = "auto") -> Mended:
    """Weld, clean, orient and close a mesh.

    Args:
        vertices: (V, 3) those of the mesh [m].
        faces: (F, 3).
        holes: ``fill`` closes every hole, ``keep`` none; ``auto`` closes small ones and the
            underside, and keeps others, such as the mouth of a bowl modelled as a bare surface.

    Raises:
        RefusedError: where no surface with an extent in three directions is left.
    """
    mesh = Mended(np.asarray(vertices, float), np.asarray(faces, np.int64), np.arange(len(faces)))
    drop_strays(mesh)
    weld(mesh)
    drop_bad_faces(mesh)
    drop_specks(mesh)
    if len(mesh.faces) < 4:
        raise RefusedError("no surface is left once degenerate and duplicate faces are dropped")
    orient(mesh)
    close_holes(mesh, holes)
    mesh.open = np.isin(pieces(mesh.faces), pieces(mesh.faces)[_border_faces(mesh.faces)])
    return mesh


# ---------------------------------------------------------------- single repairs


def drop_strays(mesh: Mended) -> None:
    """Drop faces with corners far from everything else: a scanner's slip or a unit mixed up."""
    used = mesh.vertices[np.unique(mesh.faces)]
    low, high = np.percentile(used, [1, 99], axis=0)
    centre, reach = (low + high) / 2, float(np.linalg.norm(high - low)) / 2
    if reach == 0:
        return
    far = np.linalg.norm(mesh.vertices - centre, axis=1) > STRAY * reach
    bad = far[mesh.faces].any(1)
    if 0 < bad.sum() <= 0.01 * len(bad):
        mesh.keep(~bad)
        mesh.notes.append(f"dropped {int(bad.sum())} faces that reach far outside the rest")


def weld(mesh: Mended) -> None:
    """Merge vertices at one place, which texture seams and STL files keep apart."""
    used, index = np.unique(mesh.faces, return_inverse=True)
    points = mesh.vertices[used]
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    step = max(WELD * diagonal, 1e-12)
    keys = np.round((points - points.min(0)) / step).astype(np.int64)
    _, first, merged = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    mesh.vertices = points[first]
    mesh.faces = merged.reshape(-1)[index].reshape(-1, 3)


def drop_bad_faces(mesh: Mended) -> None:
    """Drop faces without area, and faces that are there more than once.

    Two copies with opposite senses enclose nothing and both go; of copies with one sense, one stays.
    """
    f = mesh.faces
    flat = (f[:, 0] == f[:, 1]) | (f[:, 1] == f[:, 2]) | (f[:, 0] == f[:, 2])
    if flat.any():
        mesh.keep(~flat)
        mesh.notes.append(f"dropped {int(flat.sum())} degenerate faces")
    ordered = np.sort(mesh.faces, axis=1)
    _, index, count = np.unique(ordered, axis=0, return_inverse=True, return_counts=True)
    index = index.reshape(-1)
    if (count > 1).any():
        sense = np.where(_even(mesh.faces), 1, -1)
        balance = np.bincount(index, weights=sense)
        first = np.zeros(len(index), bool)
        # Where a sense prevails, the first copy with that sense stays.
        wanted = np.nonzero(sense == np.sign(balance[index]))[0]
        first[wanted[np.unique(index[wanted], return_index=True)[1]]] = True
        keep = np.where(count[index] == 1, True, first)
        mesh.notes.append(f"dropped {int((~keep).sum())} duplicate faces")
        mesh.keep(keep)


def _even(faces: Ints) -> NDArray[np.bool_]:
    """Return (F,) whether the corners of each face are an even permutation of the sorted ones."""
    a, b, c = faces.T
    return (a < b) ^ (b < c) ^ (a < c)


def _edges(faces: Ints) -> tuple[Ints, Ints, Ints]:
    """Return the faces' edges (3 F, 2), their numbers (3 F,) whatever the sense, and each one's count."""
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    _, index, count = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    return edges, index.reshape(-1), count


def _double_areas(mesh: Mended) -> Floats:
    """Return (F,) twice the area of each face [m²]."""
    corners = mesh.vertices[mesh.faces]
    return np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)


def _boxes(mesh: Mended, label: Ints) -> tuple[Floats, Floats]:
    """Return lower and upper corners (P, 3) of the box around each piece [m]."""
    corners = mesh.vertices[mesh.faces]
    low = np.full((int(label.max()) + 1, 3), np.inf)
    high = -low
    np.minimum.at(low, label, corners.min(1))
    np.maximum.at(high, label, corners.max(1))
    return low, high


def pieces(faces: Ints) -> Ints:
    """Return (F,) the number of the connected piece each face belongs to, by shared edges."""
    _, edge, count = _edges(faces)
    face = np.repeat(np.arange(len(faces)), 3)
    links = coo_matrix((np.ones(len(face), np.int8), (face, edge)), shape=(len(faces), len(count))).tocsr()
    return connected_components(links @ links.T, directed=False)[1]


def drop_specks(mesh: Mended) -> None:
    """Drop loose bits that a scan leaves in the air."""
    if not len(mesh.faces):
        return
    label = pieces(mesh.faces)
    total = np.bincount(label, weights=_double_areas(mesh) / 2)
    diagonal = np.linalg.norm(np.ptp(mesh.vertices[mesh.faces].reshape(-1, 3), axis=0))
    low, high = _boxes(mesh, label)
    speck = (total < 0.002 * total.sum()) & (np.linalg.norm(high - low, axis=1) < SPECK * diagonal)
    if speck.any():
        mesh.keep(~speck[label])
        mesh.notes.append(f"dropped {int(speck.sum())} loose specks")


def orient(mesh: Mended) -> None:
    """Make the faces of each piece agree, and point outwards."""
    tri = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    if not tri.is_winding_consistent:
        before = mesh.faces.copy()
        trimesh.repair.fix_winding(tri)
        mesh.faces = np.asarray(tri.faces, np.int64)
        turned = int((_even(before) != _even(mesh.faces)).sum())
        mesh.notes.append(f"turned {turned} faces to agree with their neighbours")
    label = pieces(mesh.faces)
    corners = mesh.vertices[mesh.faces] - mesh.vertices.mean(0)
    volume = np.bincount(
        label, weights=np.einsum("fi,fi->f", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    )
    closed = np.ones(len(volume), bool)
    closed[label[_border_faces(mesh.faces)]] = False
    inverted = (volume < 0) & ~_inside_another(mesh, label, closed)
    turn = inverted[label]
    if turn.any():
        mesh.faces[turn] = mesh.faces[turn][:, ::-1]
        mesh.notes.append(f"turned {int(inverted.sum())} inside-out pieces")


def _inside_another(mesh: Mended, label: Ints, closed: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which pieces are within another closed one's box: a cavity, which is meant to face inwards."""
    low, high = _boxes(mesh, label)
    within = np.zeros(len(closed), bool)
    for i in np.nonzero(closed)[0]:
        within |= (low > low[i]).all(1) & (high < high[i]).all(1)
    return within


# ---------------------------------------------------------------- holes


def border_loops(faces: Ints) -> list[Ints]:
    """Return closed chains of vertices along edges that belong to one face only, in those edges' sense."""
    edges, index, count = _edges(faces)
    single = edges[count[index] == 1]
    following: dict[int, list[int]] = {}
    for a, b in single.tolist():
        following.setdefault(a, []).append(b)
    loops = []
    while following:
        start = at = next(iter(following))
        chain, place = [start], {start: 0}
        while True:
            if at not in following:
                break  # the chain does not close: senses disagree here
            after = following[at].pop()
            if not following[at]:
                del following[at]
            if after in place:  # cut the loop off where the chain meets itself
                loop = chain[place[after] :]
                if len(loop) > 2:
                    loops.append(np.array(loop))
                for v in loop[1:]:
                    del place[v]
                del chain[place[after] + 1 :]
                at = after
                if at == start and at not in following:
                    break
                continue
            place[after] = len(chain)
            chain.append(after)
            at = after
    return loops


def _border_faces(faces: Ints) -> NDArray[np.bool_]:
    _, index, count = _edges(faces)
    return (count[index] == 1).reshape(-1, 3).any(1)


def close_holes(mesh: Mended, holes: str) -> None:
    """Close the holes that :func:`mend` says are closed."""
    loops = border_loops(mesh.faces)
    if not loops:
        return
    surface = _double_areas(mesh).sum() / 2
    low, height = mesh.vertices[:, 2].min(), np.ptp(mesh.vertices[:, 2])
    added: list[Ints] = []
    filled: list[str] = []
    extra: list[Floats] = []
    for loop in loops:
        points = mesh.vertices[loop]
        centre = points.mean(0)
        spokes = points - centre
        normal = np.cross(spokes, np.roll(spokes, -1, 0)).sum(0)
        area = np.linalg.norm(normal) / 2
        # The border of an underside is in one level at the bottom of all.
        under = points[:, 2].max() < low + max(0.05 * height, 0.003) and abs(normal[2]) > 1.8 * area
        small = area <= SMALL_HOLE * surface
        if holes == "keep" or not (holes == "fill" or small or under):
            mesh.notes.append(f"kept an opening of {1e4 * area:.1f} cm²: the surface around it gets a wall")
            continue
        faces, point = _fill(loop, points, normal, len(mesh.vertices) + len(extra))
        added.append(faces)
        if point is not None:
            extra.append(point)
        filled.append(f"{1e4 * area:.1f}")
    if added:
        new = np.concatenate(added)
        mesh.vertices = np.vstack([mesh.vertices, *extra])
        mesh.faces = np.concatenate([mesh.faces, new])
        mesh.source = np.concatenate([mesh.source, np.full(len(new), -1)])
        largest = f"{filled[0]} cm²" if len(filled) == 1 else f"the largest {max(filled, key=float)} cm²"
        mesh.notes.append(f"closed {len(filled)} hole{'s' * (len(filled) > 1)} ({largest})")


def _fill(loop: Ints, points: Floats, normal: Floats, free: int) -> tuple[Ints, Floats | None]:
    """Make faces over a loop: triangles of its plane figure where that is sound, else a fan about its
    middle."""
    backwards = loop[::-1]  # a border runs against the sense of the faces that close it
    if len(loop) == 3:
        return backwards[None], None
    z = normal / max(float(np.linalg.norm(normal)), 1e-30)
    x = np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
    x /= np.linalg.norm(x)
    flat = (points - points.mean(0))[::-1] @ np.column_stack([x, np.cross(z, x)])
    if Polygon(flat).is_valid:
        index = mapbox_earcut.triangulate_float64(flat, np.array([len(flat)], np.uint32))
        triangles = np.asarray(index, np.int64).reshape(-1, 3)
        if len(triangles) == len(loop) - 2:
            a, b, c = (flat[triangles[:, i]] for i in range(3))
            sense = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
            outline = flat[:, 0] @ np.roll(flat[:, 1], -1) - flat[:, 1] @ np.roll(flat[:, 0], -1)
            if sense.sum() * outline < 0:
                triangles = triangles[:, ::-1]
            return backwards[triangles], None
    following = np.roll(backwards, -1)
    return np.column_stack([backwards, following, np.full(len(loop), free)]), points.mean(0)
