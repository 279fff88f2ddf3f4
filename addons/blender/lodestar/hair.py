"""Hair: strands as files of tubes, for each material slot of an object."""

from __future__ import annotations

import hashlib
from typing import Any, NamedTuple, Optional

import numpy as np

from . import layouts, strands, tubes
from .layouts import Layout
from .materials import Material
from .meshes import Kept, Meshes, set_names
from .report import Report
from .strands import Strands

# Largest ratio of an object's scales at which its strands count as round.
EVEN = 1.001


class Wanted(NamedTuple):
    """Data that a material of strands looks up."""

    uv_map: Optional[str]
    color_attribute: Optional[str]
    layout: Optional[Layout]
    is_fiber: bool
    reads_uv: bool


def shows_hair(instance: Any, layer: Any) -> bool:
    """Whether an instance of a depsgraph shows strands on a view layer."""
    owner = instance.object
    if not layer.use_strand:
        return False
    if owner.type == "CURVES":
        return instance.show_self
    return instance.show_particles and any(strands.is_path(system.settings) for system in getattr(owner, "particle_systems", []))


def is_open(group: Strands, material: Material, has_open_roots: bool) -> bool:
    """Whether strands are so thick that one sees their inside through their ends. That of transparent ones light does not meet."""
    if group.is_linear or material.is_glass or material.is_fiber or not group.is_thick():
        return False
    return has_open_roots or bool((group.points[np.cumsum(group.counts) - 1, 3] > 0.0).any())


def is_dynamic(owner: Any) -> bool:
    """Whether hair of an object's particle systems is simulated."""
    return any(strands.is_path(system.settings) and system.use_hair_dynamics for system in getattr(owner, "particle_systems", []))


def wanted(material: Material) -> Wanted:
    """Data that a material looks up on strands."""
    reads_uv = material.layout is None and material.asks_for_uv
    return Wanted(material.uv_map, material.color_attribute, material.layout, material.is_fiber, reads_uv)


def groups(owner: Any, is_render: bool, scene: Any, kept: Optional[Kept]) -> list[Strands]:
    """Strands of an evaluated object by their material slots."""
    slots = max(len(owner.material_slots), 1)
    settings = getattr(scene, "cycles_curves", None)
    is_linear = "LINEAR" in getattr(settings, "shape", "")
    if owner.type != "CURVES":
        return list(strands.of_particles(owner, slots, is_render, is_linear, kept))
    # A Blender whose Cycles has a shape of straight pieces shows polylines so.
    knows_linear = settings is not None and any("LINEAR" in each.identifier for each in settings.bl_rna.properties["shape"].enum_items)
    found = strands.of_curves(owner, is_linear or (knows_linear and strands.is_poly(owner.data)))
    return [] if found is None else [found]


class Files:
    """Files of tubes of one export."""

    def __init__(self, meshes: Meshes, report: Report) -> None:
        self._meshes, self._report = meshes, report

    def write(self, group: Strands, wanted: Wanted, place: str, stretch: Optional[np.ndarray]) -> str:
        """Writes strands. `stretch` is the linear part of a transform that is uneven, with which the tubes are round in the world."""
        points, *later = (_stretched(each, stretch) for each in (group.points, *group.later))
        shape = (tubes.Polylines if group.is_linear else tubes.Splines)(points, group.counts)
        later_shapes = [tubes.Splines(each, group.counts) for each in later]
        quality = shape.quality(*later_shapes)
        if quality.is_coarse:
            message = f"its {len(group.counts)} strands are tubes of {quality.sides} sides, {quality.triangles} triangles in all, because they are many"
            self._report.note(place, message)
        data = self._data(group, wanted, place)
        digest = hashlib.blake2b(repr((wanted, group.is_linear, quality.sides)).encode(), digest_size=12)
        for each in (points, *later, group.counts, stretch, *data.values()):
            digest.update(b"" if each is None else np.ascontiguousarray(each).tobytes())

        def made() -> tuple[list[str], np.ndarray, np.ndarray]:
            return self._made(group, wanted, [shape, *later_shapes], quality, data, stretch)

        return self._meshes.write_named(f"mesh-{digest.hexdigest()}.ply", made)

    def _data(self, group: Strands, wanted: Wanted, place: str) -> dict[str, np.ndarray]:
        """Numbers of each strand that the material looks up, by their names."""
        numbers = set() if wanted.layout is None else set(wanted.layout.numbers)
        data: dict[str, np.ndarray] = {}
        if wanted.reads_uv or "u" in numbers:
            uvs = group.source.uvs(wanted.uv_map)
            if uvs is None and wanted.uv_map:
                self._report.warn(place, f'its strands have no UV map "{wanted.uv_map}"')
            if uvs is not None:
                data["u"], data["v"] = uvs.T
        if "random" in numbers:
            data["random"] = group.randoms()
        if "generated x" in numbers:
            roots = group.points[np.concatenate([[0], np.cumsum(group.counts)[:-1]]), :3]
            data.update(zip(("generated x", "generated y", "generated z"), group.source.generated(roots).T))
        if wanted.color_attribute is not None:
            colors = group.source.colors(wanted.color_attribute)
            if colors is None:
                message = f'the attribute "{wanted.color_attribute}" of its strands has a type or a domain that is not supported; they are white'
                self._report.warn(place, message)
                colors = np.ones((len(group.counts), 3))
            data["color"] = colors
        return data

    def _made(
        self, group: Strands, wanted: Wanted, shapes: list[Any], quality: tubes.Quality, data: dict[str, np.ndarray], stretch: Optional[np.ndarray]
    ) -> tuple[list[str], np.ndarray, np.ndarray]:
        """Names of the columns of a PLY file, its vertices and its triangles. `shapes` are those of several times."""
        first, *later = shapes
        names = ["x", "y", "z", "nx", "ny", "nz"]
        names += ["u", "v"] if self._has_uvs(wanted, data) else []
        names += ["r", "g", "b"] if "color" in data else []
        names += set_names(len(later))
        vertices, triangles, count = [], [], 0
        for rings in tubes.parts(first.rings(quality)):
            across, moved = tubes.frames(rings), [shape.rings_like(rings) for shape in later]
            is_point = np.logical_and.reduce([each.radius <= 0.0 for each in (rings, *moved)])
            made = tubes.mesh(rings, across, quality.sides, wanted.is_fiber, is_point)
            columns = [_unstretched(made, stretch)]
            if self._has_uvs(wanted, data):
                columns.append(self._uvs(group, wanted, made, data))
            if "color" in data:
                columns.append(data["color"][made.strand])
            for each in moved:
                of_set = tubes.mesh(each, tubes.frames_like(across, each), quality.sides, wanted.is_fiber, is_point)
                columns.append(_unstretched(of_set, stretch))
            vertices.append(np.concatenate(columns, axis=1).astype(np.float32))
            is_mirrored = stretch is not None and np.linalg.det(stretch) < 0.0
            triangles.append((made.triangles[:, ::-1] if is_mirrored else made.triangles) + np.int32(count))
            count += len(made.positions)
        return names, np.concatenate(vertices), np.concatenate(triangles)

    @staticmethod
    def _has_uvs(wanted: Wanted, data: dict[str, np.ndarray]) -> bool:
        return wanted.layout is not None or wanted.is_fiber or "u" in data

    @staticmethod
    def _uvs(group: Strands, wanted: Wanted, made: tubes.Tubes, data: dict[str, np.ndarray]) -> np.ndarray:
        """Texture coordinates of vertices."""
        along = group.intercepts()
        begin = (np.cumsum(group.counts) - group.counts)[made.strand] + made.segment
        intercept = along[begin] + made.u * (along[begin + 1] - along[begin])
        if wanted.layout is not None:
            values = {name: numbers[made.strand] for name, numbers in data.items() if name != "color"}
            return wanted.layout.coordinates(values, intercept, made.around if wanted.is_fiber else np.zeros_like(made.around))
        if "u" not in data:
            # Nothing else reads them.
            return np.column_stack([made.around, intercept])
        uvs = np.column_stack([data["u"], data["v"]])[made.strand]
        return layouts.plain(uvs, intercept, made.around if wanted.is_fiber else None)


def _stretched(points: np.ndarray, stretch: Optional[np.ndarray]) -> np.ndarray:
    """Points with radii as they are in the world. As in Cycles, the mean of the scales thickens them."""
    if stretch is None:
        return points
    thicker = abs(float(np.linalg.det(stretch))) ** (1.0 / 3.0)
    return np.column_stack([points[:, :3] @ stretch.T, points[:, 3] * thicker])


def _unstretched(made: tubes.Tubes, stretch: Optional[np.ndarray]) -> np.ndarray:
    """Places and normals of tubes in the object's space."""
    positions, normals = made.positions, made.normals
    if stretch is not None:
        positions, normals = positions @ np.linalg.inv(stretch).T, normals @ stretch
        normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    return np.concatenate([positions, normals], axis=1)


def stretch(matrix: Any) -> Optional[np.ndarray]:
    """Linear part of a transform that is not even, or that has no inverse."""
    linear = np.array(matrix.to_3x3(), np.float64)
    scales = np.linalg.svd(linear, compute_uv=False)
    return linear if scales[-1] > 0.0 and scales[0] > EVEN * scales[-1] else None
