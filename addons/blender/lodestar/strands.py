"""Strands: hair of particle systems and hair curves, as Cycles takes them from an evaluated scene."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, Optional

import numpy as np

from . import attributes, tubes
from .hashes import lookup3
from .meshes import Kept

# Radius of the points of hair curves that have none.
RADIUS = 0.005


@dataclass
class Strands:
    """Strands of one material, in the object's space."""

    # Places and radii of the points, and the numbers of points of the strands, two at least.
    points: np.ndarray
    counts: np.ndarray
    slot: int
    # Whether spheres at the points make them, and no splines.
    is_linear: bool
    # Numbers of the strands among all of the object, of which Cycles makes those by chance.
    numbers: np.ndarray
    # What looks up their data.
    source: Any
    # The points at evenly spaced times after the first, where they move while the shutter is open.
    later: list[np.ndarray] = field(default_factory=list)
    # Largest rounding of the places.
    rounding: float = 0.0
    # Cached places along the strands, from 0 to 1.
    _intercepts: Optional[np.ndarray] = field(default=None, repr=False)

    def intercepts(self) -> np.ndarray:
        """Share of the strand's length before each point."""
        if self._intercepts is None:
            steps = np.linalg.norm(np.diff(self.points[:, :3], axis=0, prepend=self.points[:1, :3]), axis=1)
            firsts = np.concatenate([[0], np.cumsum(self.counts)[:-1]])
            steps[firsts] = 0.0
            up_to = np.cumsum(steps)
            length = np.add.reduceat(steps, firsts)
            self._intercepts = (up_to - np.repeat(up_to[firsts], self.counts)) / np.repeat(np.maximum(length, 1e-300), self.counts)
        return self._intercepts

    def is_thick(self) -> bool:
        """Whether a strand's radius is more than a small share of its length."""
        firsts = np.cumsum(self.counts) - self.counts
        steps = np.linalg.norm(np.diff(self.points[:, :3], axis=0, prepend=self.points[:1, :3]), axis=1)
        steps[firsts] = 0.0
        return bool((np.maximum.reduceat(self.points[:, 3], firsts) >= tubes.THIN * np.add.reduceat(steps, firsts)).any())

    def randoms(self) -> np.ndarray:
        """Number by chance of each strand, from 0 to 1: Cycles' hash of its number."""
        return lookup3(self.numbers.astype(np.int64), 0) / 4294967295.0


def is_path(settings: Any) -> bool:
    """Whether a particle system is rendered as strands. Of one that is rendered as objects, the objects are instances."""
    return settings.type == "HAIR" and settings.render_type == "PATH"


def of_particles(owner: Any, slots: int, is_render: bool, is_linear: bool, kept: Optional[Kept]) -> Iterator[Strands]:
    """Strands of an evaluated object's particle systems, whose modifiers are on. Points that were kept are not looked up again."""
    number = 0
    for modifier in owner.modifiers:
        if modifier.type != "PARTICLE_SYSTEM" or not (modifier.show_render if is_render else modifier.show_viewport):
            continue
        system = modifier.particle_system
        settings = system.settings
        if not is_path(settings):
            continue
        parents, children = len(system.particles), len(system.child_particles)
        if not is_render:
            children = int(children * settings.display_percentage / 100.0)
        # Where there are children, Cycles leaves out their parents.
        first = parents if settings.child_type != "NONE" and children > 0 else 0
        count = parents + children - first
        if count == 0:
            continue
        steps = (1 << (settings.render_step if is_render else settings.display_step)) + 1
        if settings.kink == "SPIRAL":
            steps += settings.kink_extra_steps
        look_up = lambda: _places(system, owner, first, count, steps)  # noqa: E731
        places = look_up() if kept is None else kept.places(owner, (modifier.name, first, count, steps), look_up)
        radii = _radii(settings, places)
        made = _strands(np.concatenate([places, radii[..., None]], axis=2).reshape(-1, 4), np.full(count, steps), is_linear)
        if made is not None:
            points, counts, left = made
            roots = Roots(owner, system, modifier, first + left)
            slot = min(max(settings.material - 1, 0), slots - 1)
            yield Strands(points, counts, slot, is_linear, number + left, roots, rounding=_rounding(owner, points[:, :3]))
        number += count


def of_curves(owner: Any, is_linear: bool) -> Optional[Strands]:
    """Strands of an evaluated object of hair curves."""
    data = owner.data
    points, curves = len(data.points), len(data.curves)
    if curves == 0:
        return None
    places = np.empty(3 * points, np.float32)
    data.position_data.foreach_get("vector", places)
    offsets = np.empty(curves + 1, np.int32)
    data.curve_offset_data.foreach_get("value", offsets)
    radius = data.attributes.get("radius")
    radii = np.full(points, RADIUS, np.float32)
    if radius is not None and radius.domain == "POINT" and radius.data_type == "FLOAT":
        radius.data.foreach_get("value", radii)
    made = _strands(np.column_stack([places.reshape(-1, 3), radii]), np.diff(offsets), is_linear)
    return None if made is None else Strands(made[0], made[1], 0, is_linear, made[2], Curves(data, made[2]))


def is_poly(data: Any) -> bool:
    """Whether the first of an object's hair curves goes straight from point to point."""
    kinds = data.attributes.get("curve_type")
    return kinds is not None and len(kinds.data) > 0 and kinds.data[0].value == 1


def _places(system: Any, owner: Any, first: int, count: int, steps: int) -> np.ndarray:
    """Points of strands in the object's space."""
    place, every = system.co_hair, range(steps)
    flat = [place(owner, particle_no=strand, step=step) for strand in range(first, first + count) for step in every]
    world = np.array(flat, np.float64).reshape(count, steps, 3)
    # A strand that is shorter has no points beyond its end, for which Blender gives the origin.
    for step in range(1, steps):
        is_beyond = ~world[:, step].any(axis=1)
        world[is_beyond, step] = world[is_beyond, step - 1]
    inverse = np.array(owner.matrix_world.inverted_safe(), np.float64)
    return world @ inverse[:3, :3].T + inverse[:3, 3]


def _rounding(owner: Any, places: np.ndarray) -> float:
    """Largest rounding of places, in the object's space, that Blender gives in the world: eight of single precision."""
    matrix = np.array(owner.matrix_world, np.float64)
    farthest = np.abs(matrix[:3, 3]) + np.abs(matrix[:3, :3]) @ np.abs(places).max(axis=0, initial=0.0)
    inverse = np.array(owner.matrix_world.inverted_safe(), np.float64)[:3, :3]
    return float((np.abs(inverse) @ (8.0 * 2.0**-24 * farthest)).max())


def _radii(settings: Any, places: np.ndarray) -> np.ndarray:
    """Radii by the shape from the root to the tip."""
    along = np.linalg.norm(np.diff(places, axis=1, prepend=places[:, :1]), axis=2).cumsum(axis=1)
    left = 1.0 - along / np.maximum(along[:, -1:], 1e-300)
    shape = settings.shape
    if shape != 0.0:
        left = np.maximum(left, 0.0) ** (1.0 + shape if shape < 0.0 else 1.0 / max(1.0 - shape, 1e-9))
    scale = 0.5 * settings.radius_scale
    radii = scale * (left * (settings.root_radius - settings.tip_radius) + settings.tip_radius)
    if settings.use_close_tip:
        radii[:, -1] = 0.0
    return np.maximum(radii, 0.0)


def _strands(points: np.ndarray, counts: np.ndarray, is_linear: bool) -> Optional[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Points and their numbers, without strands that have no surface, and the numbers of the strands that are left. Spheres in one place
    count once."""
    owners = np.repeat(np.arange(len(counts)), counts)
    points = np.where(np.isfinite(points), points, 0.0)
    points[:, 3] = np.maximum(points[:, 3], 0.0)
    if is_linear:
        is_twin = np.zeros(len(points), bool)
        is_twin[1:] = (owners[1:] == owners[:-1]) & (points[1:, :3] == points[:-1, :3]).all(axis=1)
        points, owners = points[~is_twin], owners[~is_twin]
    steps = np.zeros(len(points))
    steps[1:] = np.where(owners[1:] == owners[:-1], np.linalg.norm(np.diff(points[:, :3], axis=0), axis=1), 0.0)
    length = np.bincount(owners, steps, len(counts))
    thickness = np.bincount(owners, points[:, 3], len(counts))
    left = np.flatnonzero((length > 0.0) & (thickness > 0.0))
    if len(left) == 0:
        return None
    is_left = np.zeros(len(counts), bool)
    is_left[left] = True
    kept = is_left[owners]
    return points[kept], np.bincount(owners[kept], minlength=len(counts))[left], left


class Roots:
    """Data of a particle system's strands: what the emitter has at their roots."""

    def __init__(self, owner: Any, system: Any, modifier: Any, strands: np.ndarray) -> None:
        self._owner, self._system, self._modifier, self._strands = owner, system, modifier, strands

    def uvs(self, name: Optional[str]) -> Optional[np.ndarray]:
        """Texture coordinates by a UV map, or by the one that renders show."""
        layers = self._owner.data.uv_layers
        at = next((at for at, layer in enumerate(layers) if (layer.name == name if name else layer.active_render)), None)
        return None if at is None else self._looked_up(self._system.uv_on_emitter, 2, uv_no=at)

    def colors(self, name: str) -> Optional[np.ndarray]:
        """Colors by an attribute. As in Cycles, colors of corners that are bytes are known at roots, and UV maps; all else is 0."""
        data = self._owner.data
        if name in data.uv_layers:
            uvs = self.uvs(name)
            return None if uvs is None else np.pad(uvs, ((0, 0), (0, 1)))
        layers = [each for each in data.attributes if each.data_type == "BYTE_COLOR" and each.domain == "CORNER"]
        at = next((at for at, layer in enumerate(layers) if layer.name == name), None)
        if at is None:
            return np.zeros((len(self._strands), 3))
        encoded = self._looked_up(self._system.mcol_on_emitter, 3, vcol_no=at)
        return np.where(encoded <= 0.04045, encoded / 12.92, (np.maximum(encoded, 0.0) + 0.055) ** 2.4 / 1.055**2.4)

    def _looked_up(self, look_up: Any, size: int, **layer: int) -> np.ndarray:
        particles, modifier = self._system.particles, self._modifier
        own, count = self._strands.tolist(), len(particles)
        # A child's own parent is not asked for.
        of = lambda number: particles[number] if number < count else particles[0]  # noqa: E731
        values = [look_up(modifier, particle=of(number), particle_no=number, **layer) for number in own]
        return np.array(values, np.float64).reshape(-1, size)

    def generated(self, points: np.ndarray) -> np.ndarray:
        """Generated coordinates of the roots at these points."""
        data = self._owner.data
        size, center = np.array(data.texspace_size), np.array(data.texspace_location)
        scale = np.divide(0.5, size, out=np.zeros(3), where=size != 0.0)
        return (points - center) * scale + 0.5


class Curves:
    """Data of hair curves."""

    def __init__(self, data: Any, strands: np.ndarray) -> None:
        self._data, self._strands = data, strands

    def uvs(self, name: Optional[str]) -> Optional[np.ndarray]:
        """Texture coordinates by an attribute of curves, or by the first one of two numbers."""
        found = self._data.attributes.get(name) if name else None
        if found is None:
            found = next((each for each in self._data.attributes if each.data_type == "FLOAT2" and each.domain == "CURVE"), None)
        if found is None or found.data_type != "FLOAT2" or found.domain != "CURVE":
            return None
        return attributes.numbers(found)[self._strands]

    def colors(self, name: str) -> Optional[np.ndarray]:
        """Colors of curves by an attribute; a missing one is 0. None where the attribute is of another kind."""
        found = self._data.attributes.get(name) if name else None
        if found is None:
            return np.zeros((len(self._strands), 3))
        if found.data_type not in attributes.MEMBERS or found.domain != "CURVE":
            return None
        return attributes.three(attributes.numbers(found))[self._strands]

