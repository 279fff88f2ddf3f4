"""Skies of Preetham and of Hosek and Wilkie: functions of the angles from the zenith and from the sun."""

from __future__ import annotations

import base64
import math
from functools import lru_cache
from typing import Any, NamedTuple, Optional

import numpy as np

from .hosek_table import TEXT
from .sky import color

# Sides of the picture. The horizon is a row.
WIDTH, HEIGHT = 1024, 513
# Cycles' radiance of a sky of Hosek and Wilkie in their units, and of one of Preetham in kilocandelas.
SCALE_OF_HOSEK, SCALE_OF_PREETHAM = 2.0 * math.pi / 683.0, 0.06
# Least elevation in radians at which the sky is looked up: below it, the ground is as bright as the horizon.
LOWEST = 0.001
# Preetham's five parameters of Y, x and y by the turbidity: slopes and constants.
SLOPES = np.array([
    [0.1787, -0.3554, -0.0227, 0.1206, -0.0670],
    [-0.0193, -0.0665, -0.0004, -0.0641, -0.0033],
    [-0.0167, -0.0950, -0.0079, -0.0441, -0.0109],
])  # fmt: skip
CONSTANTS = np.array([
    [-1.4630, 0.4275, 5.3251, -2.5771, 0.3703],
    [-0.2592, 0.0008, 0.2125, -0.8989, 0.0452],
    [-0.2608, 0.0092, 0.2102, -1.6537, 0.0529],
])  # fmt: skip
# Polynomials of x and y at the zenith: rows by powers of the turbidity, columns by powers of the sun's angle, the highest first.
ZENITH_X = np.array([
    [0.00166, -0.00375, 0.00209, 0.0],
    [-0.02903, 0.06377, -0.03202, 0.00394],
    [0.11693, -0.21196, 0.06052, 0.25886],
])  # fmt: skip
ZENITH_Y = np.array([
    [0.00275, -0.00610, 0.00317, 0.0],
    [-0.04214, 0.08970, -0.04153, 0.00516],
    [0.15346, -0.26756, 0.06670, 0.26688],
])  # fmt: skip


class Fit(NamedTuple):
    """What a Sky Texture node of these models says."""

    kind: str
    sun: tuple[float, float, float]
    turbidity: float
    albedo: float


def of_node(node: Any) -> Optional[Fit]:
    """Sky of a node; None where it is of another model."""
    if node.sky_type not in ("PREETHAM", "HOSEK_WILKIE"):
        return None
    sun = np.array(node.sun_direction, float)
    sun /= max(float(np.linalg.norm(sun)), 1e-20)
    if node.sky_type == "HOSEK_WILKIE" and sun[2] < 0.0:
        # Cycles puts a sun that has set on the horizon.
        azimuth = math.atan2(sun[0], sun[1])
        sun = np.array([math.sin(azimuth), math.cos(azimuth), 0.0])
    return Fit(node.sky_type, tuple(float(value) for value in sun), node.turbidity, node.ground_albedo)


@lru_cache(maxsize=1)
def picture(fit: Fit) -> np.ndarray:
    """Linear colors of the environment as Blender's pictures have it, but the first and the last row are the poles."""
    elevation = math.pi * (0.5 - np.arange(HEIGHT) / (HEIGHT - 1))[:, None]
    azimuth = 2.0 * math.pi * ((np.arange(WIDTH) + 0.5) / WIDTH - 0.25)[None, :]
    x, y, z = np.cos(elevation) * np.sin(azimuth), np.cos(elevation) * np.cos(azimuth), np.sin(elevation)
    to_sun = np.arccos(np.clip(x * fit.sun[0] + y * fit.sun[1] + z * fit.sun[2], -1.0, 1.0))
    height = np.sin(np.maximum(elevation, LOWEST)) * np.ones_like(to_sun)
    model = _hosek if fit.kind == "HOSEK_WILKIE" else _preetham
    return np.maximum(model(fit, height, to_sun), 0.0).astype(np.float32)


def _preetham(fit: Fit, height: np.ndarray, to_sun: np.ndarray) -> np.ndarray:
    """Colors by the sine of the elevation and the angle from the sun."""
    angle = math.acos(min(max(fit.sun[2], -1.0), 1.0))
    turbidity = fit.turbidity
    chi = (4.0 / 9.0 - turbidity / 120.0) * (math.pi - 2.0 * angle)
    luminance = (4.0453 * turbidity - 4.9710) * math.tan(chi) - 0.2155 * turbidity + 2.4192
    of_turbidity = turbidity ** np.arange(2, -1, -1)
    at_zenith = [SCALE_OF_PREETHAM * luminance, *(np.polyval(of_turbidity @ table, angle) for table in (ZENITH_X, ZENITH_Y))]
    parts = []
    for zenith, (a, b, c, d, e) in zip(at_zenith, SLOPES * turbidity + CONSTANTS):
        perez = lambda up, near: (1.0 + a * np.exp(b / up)) * (1.0 + c * np.exp(d * near) + e * np.cos(near) ** 2)  # noqa: B023, E731
        parts.append(zenith * perez(height, to_sun) / perez(1.0, angle))
    luminances, u, v = parts
    return color(np.stack([u / v, np.ones_like(u), (1.0 - u - v) / v], axis=-1) * luminances[..., None])


def _hosek(fit: Fit, height: np.ndarray, to_sun: np.ndarray) -> np.ndarray:
    """Colors by the sine of the elevation and the angle from the sun."""
    table = np.frombuffer(base64.b64decode(TEXT), "<f4").astype(float)
    parameters, radiances = table[:3240].reshape(3, 2, 10, 6, 9), table[3240:].reshape(3, 2, 10, 6)
    cosine = np.cos(to_sun)
    channels = []
    for numbers, radiance in zip(parameters, radiances):
        a, b, c, d, e, f, g, h, i = _interpolated(fit, numbers)
        glow = (1.0 + cosine**2) / (1.0 + i * i - 2.0 * i * cosine) ** 1.5
        bright = c + d * np.exp(e * to_sun) + f * cosine**2 + g * glow + h * np.sqrt(height)
        channels.append(_interpolated(fit, radiance) * (1.0 + a * np.exp(b / (height + 0.01))) * bright)
    return SCALE_OF_HOSEK * color(np.stack(channels, axis=-1))


def _interpolated(fit: Fit, table: np.ndarray) -> Any:
    """Numbers of one channel for the albedo, the turbidity and the sun's elevation."""
    turbidity, albedo = min(max(fit.turbidity, 1.0), 10.0), min(max(fit.albedo, 0.0), 1.0)
    low = min(int(turbidity), 9)
    share = turbidity - low
    of_albedo = (1.0 - albedo) * table[0] + albedo * table[1]
    points = (1.0 - share) * of_albedo[low - 1] + share * of_albedo[low]
    t = (max(math.asin(min(max(fit.sun[2], -1.0), 1.0)), 0.0) / (0.5 * math.pi)) ** (1.0 / 3.0)
    weights = [math.comb(5, at) * t**at * (1.0 - t) ** (5 - at) for at in range(6)]
    return np.tensordot(weights, points, (0, 0))
