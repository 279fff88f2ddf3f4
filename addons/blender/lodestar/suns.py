"""Suns: suns with an angle as disks of the environment, which glass and mirrors show.

Directional lights stand for a sun, and only shadow rays find them. In a world of one color, the sun may as well be a disk in a picture of
the environment, where light that glass bends and mirrors reflect finds it, as in Cycles. By default, the camera sees no sun in
Cycles. So none of the suns may stand in the picture, unless the camera sees no environment.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from . import camera, lights, sky, xml

# Points of a sun's disk for each texel that it covers, fewest and most.
POINTS_OF_TEXEL, LEAST_POINTS, MOST_POINTS = 16.0, 40_000, 1_000_000
# Distance of points that stand for directions.
FAR = 1e6


class Sun(NamedTuple):
    """A sun with an angle: the direction to its middle, its angular diameter and its irradiance, and the emitters that stand for it."""

    direction: Any
    angle: float
    irradiance: tuple[float, ...]
    emitters: list[xml.Element]


def sun(light: Any, matrix: Any, emitters: list[xml.Element]) -> "Sun | None":
    """The sun that directional lights stand for; None where it is another lamp, or rays of surfaces do not find it."""
    if light.type != "SUN" or len(emitters) < 2 or not lights.is_found(light):
        return None
    part = next(child.get("value", "") for child in emitters[0] if child.get("name") == "irradiance")
    irradiance = tuple(float(channel) * len(emitters) for channel in part.split())
    return Sun(matrix.to_3x3().normalized().col[2].copy(), light.angle, irradiance, emitters)


def is_in_view(each: Sun, owner: Any, scene: Any) -> bool:
    """Whether a camera may see a part of a sun, if nothing hides it."""
    if owner.data.type != "PERSP":
        return True
    side = each.direction.orthogonal().normalized()
    other = each.direction.cross(side)
    # A square that holds the disk. From a half angle of 60 degrees on, it would be too large.
    if each.angle > math.radians(120.0):
        return True
    reach = math.tan(0.5 * each.angle)
    eye = owner.matrix_world.translation
    corners = [eye + FAR * (each.direction + reach * (x * side + y * other)) for x in (-1.0, 1.0) for y in (-1.0, 1.0)]
    # The lens may see farther to the side than its middle.
    return camera.may_see(owner, scene, corners, 0.5 if owner.data.dof.use_dof else 0.1)


def picture(color: tuple[float, ...], suns: list[Sun]) -> np.ndarray:
    """Environment of one color with suns, with the places of texels that a Sky Texture has."""
    colors = np.tile(np.array(color, np.float64), (sky.HEIGHT, sky.WIDTH, 1))
    for each in suns:
        _add(colors, each)
    return colors.astype(np.float32)


def _add(colors: np.ndarray, each: Sun) -> None:
    half = 0.5 * each.angle
    texels = 2.0 * math.pi * (1.0 - math.cos(half)) / (math.pi / (sky.HEIGHT - 1)) ** 2
    # A disk that needs more has many texels, and each of them gets a few.
    count = min(max(int(POINTS_OF_TEXEL * texels), LEAST_POINTS), MOST_POINTS)
    at = np.arange(count)
    # Even in solid angle, on a sunflower spiral.
    cosine = 1.0 - (1.0 - math.cos(half)) * (at + 0.5) / count
    turn, sine = at * math.pi * (3.0 - math.sqrt(5.0)), np.sqrt(1.0 - cosine * cosine)
    side = each.direction.orthogonal().normalized()
    other = each.direction.cross(side)
    axes = zip((cosine, sine * np.cos(turn), sine * np.sin(turn)), (each.direction, side, other))
    x, y, z = sum(share[None, :] * np.array(axis)[:, None] for share, axis in axes)
    light = np.tile(np.array(each.irradiance) / count, (count, 1))
    sky.add_light(colors, np.arctan2(x, y), np.arcsin(np.clip(z, -1.0, 1.0)), light)
