"""Enclosures: bodies that hold volumes, and which of them lie within which.

Blender's volumes add up where they overlap. The renderer's rays have the medium that the last boundary tells, so a boundary tells the sum of
all volumes on each of its sides. This is exact where bodies lie within each other or apart.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Optional

from . import volumes, xml
from .report import Report
from .volumes import Volume

# Points of a body by which it lies within another one.
POINTS = 24
# Size of what the world's volume fills, in scene units.
SIZE_OF_WORLD = 1000.0
# Direction of the rays that count how often a point is enclosed. It lies along no edge of usual meshes.
DIRECTION = (0.5193, 0.2911, 0.8034)


class Region:
    """Space that a mesh encloses, in the mesh's own coordinates."""

    def __init__(self, mesh: Any) -> None:
        from mathutils.bvhtree import BVHTree

        vertices = [vertex.co.copy() for vertex in mesh.vertices]
        self.tree = BVHTree.FromPolygons(vertices, [tuple(face.vertices) for face in mesh.polygons])
        step = max(len(vertices) // POINTS, 1)
        self.points = vertices[::step][:POINTS]
        low = [min(v[axis] for v in vertices) for axis in range(3)]
        high = [max(v[axis] for v in vertices) for axis in range(3)]
        self.corners = [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]

    def holds(self, point: Any) -> bool:
        """Whether a point is enclosed: a ray from it meets an odd number of faces."""
        from mathutils import Vector

        direction, count, origin = Vector(DIRECTION), 0, point.copy()
        while count < 10_000:
            place, _, _, distance = self.tree.ray_cast(origin, direction)
            if place is None:
                break
            count += 1
            origin = place + direction * max(1e-5 * distance, 1e-6)
        return count % 2 == 1


class Box:
    """Unit cube, as the region of a grid."""

    def __init__(self) -> None:
        from mathutils import Vector

        self.corners = [(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)]
        self.points = [Vector(corner) for corner in self.corners]

    def holds(self, point: Any) -> bool:
        """Whether a point lies in the cube."""
        return all(0.0 <= coordinate <= 1.0 for coordinate in point)


@dataclass
class Body:
    """Object with media on the sides of its surfaces."""

    name: str
    region: Any
    matrix: Any
    # Volume that fills the body, as others see it that lie in it; None where there is none.
    volume: Optional[Volume]
    # Shows the body's shapes, given the volume around it.
    show: Callable[[Volume], None] = field(repr=False)

    def __post_init__(self) -> None:
        from mathutils import Vector

        corners = [self.matrix @ Vector(corner) for corner in self.region.corners]
        self.low = [min(corner[axis] for corner in corners) for axis in range(3)]
        self.high = [max(corner[axis] for corner in corners) for axis in range(3)]
        self.inverse = self.matrix.inverted_safe()

    @property
    def size(self) -> float:
        """Length of the diagonal of the body's box."""
        return sum((high - low) ** 2 for low, high in zip(self.low, self.high)) ** 0.5

    @property
    def points(self) -> list[Any]:
        """Some points of the surface."""
        return [self.matrix @ point for point in self.region.points]

    def meets_box_of(self, other: Body) -> bool:
        """Whether the boxes of two bodies meet."""
        return all(a <= d and c <= b for a, b, c, d in zip(self.low, self.high, other.low, other.high))

    def holds(self, point: Any) -> bool:
        """Whether a point of the scene lies within the body."""
        return all(low <= x <= high for low, x, high in zip(self.low, point, self.high)) and self.region.holds(self.inverse @ point)


class Enclosures:
    """Bodies of a scene, and the media that are made of their volumes."""

    def __init__(self, report: Report) -> None:
        self.report = report
        self.world = Volume()
        self.bodies: list[Body] = []
        self.regions: dict[Any, Region] = {}
        self.elements: list[xml.Element] = []
        self._ids: dict[Volume, str] = {}

    def region(self, owner: Any) -> Optional[Region]:
        """Region of an evaluated object; None where it has no faces."""
        key = owner.data.as_pointer()
        if key not in self.regions:
            mesh = owner.to_mesh()
            try:
                if mesh is None or len(mesh.polygons) == 0:
                    return None
                self.regions[key] = Region(mesh)
            finally:
                owner.to_mesh_clear()
        return self.regions[key]

    def show(self) -> None:
        """Shows all bodies, each with the media on its sides."""
        for body in self.bodies:
            around = self.world
            for other in self.bodies:
                if other is not body and other.volume is not None and other.meets_box_of(body):
                    inside = sum(map(other.holds, body.points))
                    if 0 < inside < len(body.points):
                        self._warn_of_overlap(body, other)
                    elif inside:
                        around = around.plus(other.volume, self._warner(body.name))
            body.show(around)

    def at(self, point: Any, name: str) -> Optional[str]:
        """Name of the medium at a point of the scene; None where there is none."""
        total = self.world
        for body in self.bodies:
            if body.volume is not None and body.holds(point):
                total = total.plus(body.volume, self._warner(name))
        return self.medium(total, SIZE_OF_WORLD)

    def medium(self, volume: Volume, size: float) -> Optional[str]:
        """Name of the medium of a volume; None for an empty one."""
        if volume.is_empty:
            return None
        if volume not in self._ids:
            name = self._ids[volume] = f"medium {len(self._ids)}"
            element = volumes.element(volume, size, lambda message: self.report.warn(name, message))
            element.set("id", name)
            self.elements.append(element)
        return self._ids[volume]

    def sides(self, inside: Volume, outside: Volume, size: float) -> list[xml.Element]:
        """References to the media on the two sides of a surface."""
        both = [("interior", self.medium(inside, size)), ("exterior", self.medium(outside, SIZE_OF_WORLD))]
        return [xml.ElementTree.Element("ref", {"id": name, "name": side}) for side, name in both if name is not None]

    def _warner(self, name: str) -> Callable[[str], None]:
        return lambda message: self.report.warn(f'object "{name}"', message)

    def _warn_of_overlap(self, body: Body, other: Body) -> None:
        names = " and ".join(sorted(f'"{name}"' for name in (body.name, other.name)))
        self.report.warn(
            f"objects {names}", "volumes that overlap in part are not supported; a ray has the volume of the surface that it has met last"
        )
