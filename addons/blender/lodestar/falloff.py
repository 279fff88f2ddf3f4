"""Falloff: surfaces so near to a lamp of points that its soft falloff would show.

Points stand for a lamp with a radius but without Multiple Importance, because mirrors must not show it. Cycles takes it for a disk that faces
each lit point. At a distance d, a disk of the radius r gives 1 / (1 + (r / d)^2) of the points' light. So a disk stands for the lamp where
surfaces are near and there are no mirrors: all other surfaces get the same light, whether their rays may meet the lamp or not.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NamedTuple, Optional

from . import lights, xml

# Distance in radii beyond which the two differ by less than 1/17.
REACH = 4.0


# BSDFs that scatter into single directions. Those of `thindielectric` and `null`, as they are exported, go straight on.
MIRRORS = {"conductor", "dielectric", "plastic", "coating"}
# Roughness of a `principled` below which its highlights show a lamp.
SHARP = 0.05


class SoftLamp(NamedTuple):
    """A lamp of points with soft falloff."""

    name: str
    center: Any
    radius: float


def soft_lamp(owner: Any, center: Any) -> Optional[SoftLamp]:
    """The lamp, if Cycles takes it for a disk and points stand for it."""
    light = owner.data
    of_points = lights.is_soft(light) and not lights.is_facing(light)
    return SoftLamp(owner.name, center.copy(), light.shadow_soft_size) if of_points else None


def is_mirror(bsdf: xml.Element) -> bool:
    """Whether a BSDF shows lamps as a mirror does, or may do so."""
    if bsdf.get("type") != "principled":
        return bsdf.get("type") in MIRRORS
    roughness = [child.get("value") for child in bsdf if child.get("name") == "roughness"]
    # A texture has no value. A metal of the roughness 0 has facets here whose highlights are as sharp as a mirror's.
    return any(value is None or float(value) < SHARP for value in roughness)


def near_surfaces(lamps: list[SoftLamp], instances: Iterable[Any]) -> dict[str, float]:
    """Names of the lamps that have a surface within reach, and the distances in radii."""
    nearest: dict[str, float] = {}
    for instance in instances if lamps else ():
        owner = instance.object
        if owner.type != "MESH" or not instance.show_self or not owner.data.polygons:
            continue
        matrix = instance.matrix_world
        corners = owner.bound_box
        low, high = ([choose(corner[axis] for corner in corners) for axis in range(3)] for choose in (min, max))
        scale = max(matrix.to_scale(), key=abs)
        middle = matrix @ _vector([0.5 * (a + b) for a, b in zip(low, high)])
        size = 0.5 * abs(scale) * _vector([b - a for a, b in zip(low, high)]).length
        for lamp in lamps:
            reach = REACH * lamp.radius
            if (middle - lamp.center).length - size > reach:
                continue
            found, place, _, _ = owner.closest_point_on_mesh(matrix.inverted_safe() @ lamp.center)
            distance = (matrix @ place - lamp.center).length if found else reach
            if distance < reach:
                nearest[lamp.name] = min(nearest.get(lamp.name, REACH), distance / lamp.radius)
    return nearest


def warning(radii: float) -> str:
    """What is said of a lamp whose nearest surface is at a distance in radii."""
    if radii <= 1.0:
        return "soft falloff without Multiple Importance is not supported; surfaces within its radius get other light than in Cycles"
    more = 100.0 / radii**2
    return f"soft falloff without Multiple Importance is not supported; the nearest surface, {radii:.1f} radii away, gets {more:.0f} % more light than in Cycles"


def _vector(values: Any) -> Any:
    from mathutils import Vector

    return Vector(values)
