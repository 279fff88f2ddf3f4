"""Sky: Blender's Sky Texture as a picture of the environment, with its sun."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple, Optional, Union

import numpy as np

from .sky_models import Air, MultipleScattering, SingleScattering

Model = Union[MultipleScattering, SingleScattering]
# Sides of the table of a model; rows are denser at the horizon. It holds half a turn; the other half is its mirror image.
COLUMNS, ROWS = 128, 128
# Sides of the picture. The horizon is a row.
WIDTH, HEIGHT = 2048, 1025
# Points of the sun's disk that are put into the picture.
SUN_POINTS = 40_000
# Dimming of the sun's disk at its edge.
LIMB = 0.6
RGB_FROM_XYZ = np.array([
    [3.2404542, -1.5371385, -0.4985314],
    [-0.9692660, 1.8760108, 0.0415560],
    [0.0556434, -0.2040259, 1.0572252],
])  # fmt: skip


class Sky(NamedTuple):
    """What a Sky Texture node says. Angles are in radians."""

    model: type[Model]
    air: Air
    elevation: float
    rotation: float
    # Angular diameter and brightness of the sun; 0 where there is no disk.
    diameter: float
    intensity: float


def of_node(node: Any) -> Optional[Sky]:
    """Sky of a node; None where its model is not known."""
    models = {"MULTIPLE_SCATTERING": MultipleScattering, "SINGLE_SCATTERING": SingleScattering, "NISHITA": SingleScattering}
    if node.sky_type not in models:
        return None
    aerosols = node.aerosol_density if hasattr(node, "aerosol_density") else node.dust_density
    air = Air(node.altitude, node.air_density, aerosols, node.ozone_density)
    # Elevations beyond the zenith are those on its other side.
    elevation = math.remainder(node.sun_elevation, 2.0 * math.pi)
    rotation = node.sun_rotation
    if abs(elevation) > 0.5 * math.pi:
        elevation, rotation = math.copysign(math.pi, elevation) - elevation, rotation + math.pi
    diameter = node.sun_size if node.sun_disc else 0.0
    return Sky(models[node.sky_type], air, elevation, rotation, diameter, node.sun_intensity)


def color(xyz: np.ndarray) -> np.ndarray:
    """Linear colors of the screen; what lies outside its gamut is clamped."""
    return np.maximum(xyz @ RGB_FROM_XYZ.T, 0.0)


def _looked_up(half: np.ndarray, azimuth: np.ndarray, elevation: np.ndarray) -> np.ndarray:
    """Colors of a table at the angles of columns and of rows, in radians."""
    table = np.concatenate([half, half[:, ::-1]], axis=1)
    x = np.mod(azimuth / (2.0 * math.pi), 1.0) * table.shape[1] - 0.5
    y = (np.copysign(np.sqrt(np.abs(elevation) * (2.0 / math.pi)), elevation) * 0.5 + 0.5) * len(table) - 0.5
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    s, t = (x - column)[None, :, None], (y - row)[:, None, None]
    across = (1.0 - s) * table[:, np.mod(column, table.shape[1])] + s * table[:, np.mod(column + 1, table.shape[1])]
    return (1.0 - t) * across[np.clip(row, 0, len(table) - 1)] + t * across[np.clip(row + 1, 0, len(table) - 1)]


@lru_cache(maxsize=1)
def picture(sky: Sky) -> np.ndarray:
    """Linear colors of the environment as Blender's pictures have it, but the first and the last row are the poles."""
    model = sky.model(sky.air)
    elevation = math.pi * (0.5 - np.arange(HEIGHT) / (HEIGHT - 1))
    # Azimuths of Blender's environments run from +y to +x, and their middle is +x.
    azimuth = 2.0 * math.pi * ((np.arange(WIDTH) + 0.5) / WIDTH - 0.25) - sky.rotation
    colors = color(_looked_up(model.half_table(sky.elevation, COLUMNS, ROWS), azimuth, elevation))
    if sky.diameter > 0.0 and sky.intensity > 0.0:
        _add_sun(colors, sky, model)
    return colors.astype(np.float32)


def _add_sun(colors: np.ndarray, sky: Sky, model: Model) -> None:
    """Adds the sun's disk: the light of each of its points goes to the four texels around it."""
    half = 0.5 * sky.diameter
    bottom, top = (model.sun(sky.elevation + side * half) for side in (-1.0, 1.0))
    at = np.arange(SUN_POINTS)
    # Even in solid angle, on a sunflower spiral.
    cosine = 1.0 - (1.0 - math.cos(half)) * (at + 0.5) / SUN_POINTS
    turn, sine = at * math.pi * (3.0 - math.sqrt(5.0)), np.sqrt(1.0 - cosine * cosine)
    c, s = math.cos(sky.elevation), math.sin(sky.elevation)
    # Axes: to the sun, to the side, and up along the disk.
    side, up = sine * np.cos(turn), sine * np.sin(turn)
    x, z = cosine * c - up * s, cosine * s + up * c
    elevation = np.arcsin(np.clip(z, -1.0, 1.0))
    share = ((elevation - sky.elevation) / sky.diameter + 0.5)[:, None]
    limb = 1.0 - LIMB * (1.0 - np.sqrt(np.maximum(1.0 - (np.arccos(cosine) / half) ** 2, 0.0)))
    # The irradiances of the ends are those of a disk that is as bright everywhere.
    light = color((bottom + share * (top - bottom)) * limb[:, None] * (sky.intensity / SUN_POINTS))
    light[elevation <= _horizon(sky.air.altitude)] = 0.0
    add_light(colors, np.arctan2(side, x) + sky.rotation, elevation, light)


def add_light(colors: np.ndarray, azimuth: np.ndarray, elevation: np.ndarray, light: np.ndarray) -> None:
    """Adds light from some directions to a picture of the sky: the irradiance of each goes to the four texels around it."""
    column = (azimuth / (2.0 * math.pi) + 0.25) * WIDTH - 0.5
    row = (0.5 - elevation / math.pi) * (HEIGHT - 1)
    i, j = np.floor(column).astype(int), np.floor(row).astype(int)
    solid_angles = _solid_angles()
    for right, below in ((0, 0), (1, 0), (0, 1), (1, 1)):
        weight = (column - i if right else 1.0 - (column - i)) * (row - j if below else 1.0 - (row - j))
        y = np.clip(j + below, 0, HEIGHT - 1)
        np.add.at(colors, (y, np.mod(i + right, WIDTH)), light * (weight / solid_angles[y])[:, None])


def _horizon(altitude: float) -> float:
    """Elevation in radians below which the planet hides the sun."""
    return math.asin(6371.0 / (6371.0 + altitude / 1000.0)) - 0.5 * math.pi


def _solid_angles() -> np.ndarray:
    """Solid angles over which a texel of each row counts, between which colors are linear."""
    step = math.pi / (HEIGHT - 1)
    angles = 2.0 * (1.0 - math.cos(step)) / step * np.sin(step * np.arange(HEIGHT))
    angles[0] = angles[-1] = 1.0 - math.sin(step) / step
    return angles * (2.0 * math.pi / WIDTH)
