"""Meshes: evaluated objects as binary PLY files, one per material slot, named by a hash of their content.

A mesh that has not changed has the same name as before, and its file is there already.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Hashable, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Optional

import numpy as np

from . import attributes
from .motion import Vertices
from .report import Report


class Part(NamedTuple):
    """Triangles of one material slot."""

    slot: int
    file: str
    # The mesh's other side, where it emits and has one: emitters shine from their front only.
    back: Optional[str]

    @property
    def files(self) -> list[str]:
        return [self.file] if self.back is None else [self.file, self.back]


class Wanted(NamedTuple):
    """Data that a slot's material looks up."""

    uv_map: Optional[str]
    color_attribute: Optional[str]
    emits: bool


class Kept:
    """Parts of objects' meshes, and points of their strands, that one export leaves to the next."""

    def __init__(self) -> None:
        self._parts: dict[Any, tuple[Any, list[Part]]] = {}
        # Points of strands.
        self._places: dict[Any, np.ndarray] = {}
        self._asked: set[Any] = set()

    def forget(self, numbers: set[int]) -> None:
        """Forgets meshes of objects and of data with these numbers (`session_uid`), which have changed."""
        self._parts = {key: kept for key, kept in self._parts.items() if not numbers.intersection(key[:2])}
        self._places = {key: kept for key, kept in self._places.items() if not numbers.intersection(key[:2])}

    def find(self, owner: Any, wanted: list[Wanted], folder: Path) -> Optional[list[Part]]:
        """Parts of an object that has not changed; None where none are known."""
        key = _key(owner, wanted)
        self._asked.add(key)
        shape, parts = self._parts.get(key, (None, []))
        is_here = shape == _shape(owner) and all((folder / file).exists() for part in parts for file in part.files)
        return parts if is_here else None

    def keep(self, owner: Any, wanted: list[Wanted], parts: list[Part]) -> None:
        """Keeps parts of an object."""
        self._parts[_key(owner, wanted)] = (_shape(owner), parts)

    def places(self, owner: Any, about: Hashable, look_up: Callable[[], np.ndarray]) -> np.ndarray:
        """Points of an object's strands, which are looked up where they are not known."""
        key = owner.original.session_uid, owner.original.data.session_uid, about
        self._asked.add(key)
        if key not in self._places:
            self._places[key] = look_up()
        return self._places[key]

    def drop_others(self) -> None:
        """Drops what no export has asked for since the last call, such as parts of objects that are gone."""
        self._parts = {key: kept for key, kept in self._parts.items() if key in self._asked}
        self._places = {key: kept for key, kept in self._places.items() if key in self._asked}
        self._asked.clear()


def _key(owner: Any, wanted: list[Wanted]) -> Any:
    original = owner.original
    return original.session_uid, original.data.session_uid, tuple(wanted)


def _shape(owner: Any) -> Any:
    mesh = owner.data
    return len(mesh.vertices), len(mesh.loops), len(mesh.polygons)


class Meshes:
    """Mesh files of one export."""

    def __init__(self, folder: Path, report: Report, kept: Optional[Kept] = None) -> None:
        self.folder, self.report, self._kept = folder, report, kept
        self.used: set[str] = set()
        self.written = 0

    def export(self, instance: Any, wanted: list[Wanted], is_kept: bool, sets: Sequence[Vertices] = ()) -> list[Part]:
        """Writes the parts of an evaluated object in its own space, unless they are kept from before. `sets` are its vertices at times of
        the shutter, where its shape changes."""
        if self._kept is None or not is_kept:
            return self._export(instance, wanted, sets)
        parts = self._kept.find(instance, wanted, self.folder)
        if parts is None:
            parts = self._export(instance, wanted, sets)
            self._kept.keep(instance, wanted, parts)
        self.used.update(file for part in parts for file in part.files)
        return parts

    def _export(self, instance: Any, wanted: list[Wanted], sets: Sequence[Vertices]) -> list[Part]:
        mesh = instance.to_mesh()
        try:
            return [] if mesh is None else self._parts(mesh, wanted, f'object "{instance.name}"', sets)
        finally:
            instance.to_mesh_clear()

    def _parts(self, mesh: Any, wanted: list[Wanted], place: str, sets: Sequence[Vertices]) -> list[Part]:
        mesh.calc_loop_triangles()
        count = len(mesh.loop_triangles)
        if count == 0:
            return []
        loops = _get(mesh.loop_triangles, "loops", 3 * count, np.int32).reshape(count, 3)
        slots = np.clip(_get(mesh.loop_triangles, "material_index", count, np.int32), 0, len(wanted) - 1)
        positions = _get(mesh.vertices, "co", 3 * len(mesh.vertices), np.float32).reshape(-1, 3)
        vertex_of_loop = _get(mesh.loops, "vertex_index", len(mesh.loops), np.int32)
        normals = _get(mesh.corner_normals, "vector", 3 * len(mesh.loops), np.float32).reshape(-1, 3)
        if sets and (sets[0].positions.shape != positions.shape or sets[0].normals.shape != normals.shape):
            self.report.warn(place, "the mesh that is written is another than the one that changes its shape, which is not supported; it keeps its shape")
            sets = ()
        sets = sets or [Vertices(positions, normals)]
        _note_twins(positions, vertex_of_loop[loops], place, self.report)
        # Of a flat face that is not plane, each triangle is flat in Cycles, unless the mesh has normals of its own.
        is_flat = ~_get(mesh.loop_triangles, "use_smooth", count, bool) & (not mesh.has_custom_normals)
        parts = []
        for slot in np.unique(slots):
            corners = loops[slots == slot].ravel()
            of_sets = [_columns(each, corners, vertex_of_loop, is_flat[slots == slot].repeat(3)) for each in sets]
            columns, names = [of_sets[0]], ["x", "y", "z", "nx", "ny", "nz"]
            for values, of in (
                (_uvs(mesh, wanted[slot].uv_map, place, self.report), ("u", "v")),
                (_colors(mesh, wanted[slot].color_attribute, vertex_of_loop, place, self.report), ("r", "g", "b")),
            ):
                if values is not None:
                    columns.append(values[corners])
                    names.extend(of)
            columns.extend(of_sets[1:])
            names.extend(set_names(len(sets) - 1))
            vertices = np.ascontiguousarray(np.concatenate(columns, axis=1), np.float32)
            file = self._write(names, vertices)
            is_open = wanted[slot].emits and not _is_closed(vertex_of_loop[corners].reshape(-1, 3))
            parts.append(Part(int(slot), file, self._write(names, _turned(vertices, len(sets) - 1)) if is_open else None))
        return parts

    def _write(self, names: list[str], corners: np.ndarray) -> str:
        digest = hashlib.blake2b(repr(names).encode() + corners.tobytes(), digest_size=12).hexdigest()
        return self.write_named(f"mesh-{digest}.ply", lambda: (names, *_unique(corners)))

    def write_named(self, name: str, build: Callable[[], tuple[list[str], np.ndarray, np.ndarray]]) -> str:
        """Writes a file unless it is there. `build` makes the names of the vertices' numbers, the vertices and the triangles."""
        self.used.add(name)
        path = self.folder / name
        if not path.exists():
            whole = path.with_suffix(".part")
            whole.write_bytes(ply(*build()))
            whole.replace(path)
            self.written += 1
        return name


def _note_twins(positions: np.ndarray, triangles: np.ndarray, place: str, report: Report) -> None:
    """Notes how many triangles lie where another one of the mesh lies."""
    size = max(float(np.ptp(positions, axis=0).max()), 1e-30)
    corners = _hashes(np.rint(positions / np.float32(1e-5 * size)) + np.float32(0.0))
    # The sum does not depend on the order of the corners.
    twins = len(triangles) - len(np.unique(corners[triangles].sum(axis=1)))
    if twins > 0:
        report.note(place, f"{twins} of its {len(triangles)} triangles lie where others do; Cycles has dark spots there, which are not rendered")


def _flat(places: np.ndarray, of_corners: np.ndarray) -> np.ndarray:
    """Normals of triangles, for each of their corners. A triangle without an area keeps its corners' normals, and so does one that lies in
    its face's plane, so that triangles share corners."""
    a, b, c = np.moveaxis(places.reshape(-1, 3, 3), 1, 0)
    normals = np.cross((b - a).astype(np.float64), (c - a).astype(np.float64)).repeat(3, axis=0)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    is_other = np.sum(normals * of_corners, axis=1, keepdims=True) < (1.0 - 1e-7) * lengths
    return np.where(is_other, normals / np.maximum(lengths, 1e-300), of_corners).astype(np.float32)


def set_names(count: int) -> list[str]:
    """Names of the places and normals of later sets of vertices in a PLY file."""
    return [f"{kind}{at}_{axis}" for at in range(1, count + 1) for kind in ("position", "normal") for axis in "xyz"]


def _columns(vertices: Vertices, corners: np.ndarray, vertex_of_loop: np.ndarray, is_flat: np.ndarray) -> np.ndarray:
    """Places and normals of triangles' corners."""
    places, of_corners = vertices.positions[vertex_of_loop[corners]], vertices.normals[corners]
    return np.concatenate([places, np.where(is_flat[:, None], _flat(places, of_corners), of_corners)], axis=1)


def _turned(corners: np.ndarray, later_sets: int) -> np.ndarray:
    """Triangles that face the other way, a little behind the given ones. The last columns have later sets of places and normals."""
    turned = corners.reshape(-1, 3, corners.shape[1])[:, ::-1].reshape(corners.shape).copy()
    for first in [0, *(corners.shape[1] - 6 * (at + 1) for at in range(later_sets))]:
        places, normals = turned[:, first : first + 3], turned[:, first + 3 : first + 6]
        places -= 1e-5 * np.linalg.norm(np.ptp(corners[:, first : first + 3], axis=0)) * normals
        normals *= -1.0
    return turned


def _get(collection: Any, name: str, size: int, dtype: type) -> np.ndarray:
    data = np.empty(size, dtype)
    collection.foreach_get(name, data)
    return data


def _uvs(mesh: Any, name: Optional[str], place: str, report: Report) -> Optional[np.ndarray]:
    layer = mesh.uv_layers.get(name) if name else next((l for l in mesh.uv_layers if l.active_render), None)
    if layer is None:
        if name:
            report.warn(place, f'the UV map "{name}" is missing')
        return None
    uvs = _get(layer.uv, "vector", 2 * len(mesh.loops), np.float32).reshape(-1, 2)
    # Rows of images run downwards in Mitsuba.
    uvs[:, 1] = 1.0 - uvs[:, 1]
    return uvs


def _colors(
    mesh: Any, name: Optional[str], vertex_of_loop: np.ndarray, place: str, report: Report
) -> Optional[np.ndarray]:
    if name is None:
        return None
    found = attributes.colors(mesh, name, vertex_of_loop)
    if found is None:
        report.warn(place, f'the attribute "{name}" has a type or a domain that is not supported; the surface is white')
        return np.ones((len(vertex_of_loop), 3), np.float32)
    return found


def _is_closed(triangles: np.ndarray) -> bool:
    """Whether each edge has two triangles."""
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    _, counts = np.unique(edges, axis=0, return_counts=True)
    return bool((counts == 2).all())


def _unique(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Different corners, and the index of each corner among them."""
    # Numbers sort several times faster than rows do.
    _, first, inverse = np.unique(_hashes(corners), return_index=True, return_inverse=True)
    bits = corners.view(np.uint32)
    if not np.array_equal(bits[first][inverse], bits):
        rows = corners.view([("", np.void, corners.shape[1] * 4)]).ravel()
        _, first, inverse = np.unique(rows, return_index=True, return_inverse=True)
    return corners[first], inverse.reshape(-1, 3).astype("<i4")


def _hashes(corners: np.ndarray) -> np.ndarray:
    """A number of 64 bits for the bits of each corner."""
    hashes = np.zeros(len(corners), np.uint64)
    for column in corners.view(np.uint32).T:
        hashes ^= column
        hashes *= np.uint64(0x9E3779B97F4A7C15)
        hashes ^= hashes >> np.uint64(29)
    return hashes


def ply(names: list[str], vertices: np.ndarray, triangles: np.ndarray) -> bytes:
    """Binary PLY file."""
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}"]
    header += [f"property float {name}" for name in names]
    header += [f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header", ""]
    faces = np.empty(len(triangles), np.dtype([("count", "u1"), ("at", "<i4", 3)]))
    faces["count"], faces["at"] = 3, triangles
    return "\n".join(header).encode() + vertices.astype("<f4").tobytes() + faces.tobytes()
