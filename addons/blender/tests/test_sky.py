"""Models of the sky."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import scenes
import support
from lodestar import sky_fits
from lodestar.sky_models import Air, MultipleScattering, SingleScattering


@pytest.mark.parametrize("model", [MultipleScattering, SingleScattering], ids=lambda model: model.__name__)
@pytest.mark.parametrize("air", [Air(0, 1, 0, 1), Air(0, 0, 0, 1), Air(0, 0, 0, 0), Air(59_000, 10, 10, 10)], ids=str)
def test_colors_are_finite_for_a_sun_below_the_horizon(model: Any, air: Air) -> None:
    """Paths to a sun that the planet hides go through the planet."""
    found = model(air)
    for elevation in (-1.5, -0.9, -0.6, -0.1, 0.0):
        colors = found.half_table(elevation, 8, 16)
        assert np.isfinite(colors).all() and (colors >= 0.0).all(), elevation
        assert np.isfinite(found.sun(elevation)).all(), elevation


def both_skies(kind: str, sun: Any, turbidity: float, albedo: float) -> tuple[np.ndarray, np.ndarray]:
    """The add-on's and Cycles' colors of the whole sky, whose middle is along +x, in 64 x 32 pixels."""
    scene = scenes.empty()
    scene.render.resolution_y = 32
    placed = scenes.camera(scene, (0, 0, 0), (1, 0, 0), type="PANO")
    placed.rotation_euler = (0.5 * math.pi, 0, -0.5 * math.pi)
    settings = placed.data if hasattr(placed.data, "panorama_type") else placed.data.cycles
    settings.panorama_type = "EQUIRECTANGULAR"
    scenes.world(scene, (0, 0, 0))
    tree = scene.world.node_tree
    node = tree.nodes.new("ShaderNodeTexSky")
    node.sky_type, node.sun_direction, node.turbidity, node.ground_albedo = kind, sun, turbidity, albedo
    tree.links.new(node.outputs["Color"], next(n for n in tree.nodes if n.type == "BACKGROUND").inputs["Color"])
    found = support.colors(support.render(scene, "CYCLES", 16, kind))
    fit = sky_fits.of_node(node)
    assert fit is not None
    # A pixel has 16 rows of the picture and, by half, those at its edges.
    rows = sky_fits.picture(fit).reshape(513, 64, 16, 3).mean(axis=2)
    pixels = 0.5 * (rows[:-1] + rows[1:])
    return pixels.reshape(32, 16, 64, 3).mean(axis=1), found


@pytest.mark.parametrize("kind", ["PREETHAM", "HOSEK_WILKIE"])
@pytest.mark.parametrize(
    "sun,turbidity,albedo",
    [
        *[((0, 0, 1), 2.2, 0.3), ((0.5, 0.3, 0.8), 2.2, 0.3), ((0.9, -0.2, 0.2), 5.5, 0.8), ((0.2, 0.7, 0.05), 9.7, 1.0)],
        *[((0.6, 0, 0.4), 3.1, 0.1), ((-0.9, 0.1, -0.3), 2.2, 0.3)],
    ],
)
def test_fits_are_those_of_cycles(kind: str, sun: Any, turbidity: float, albedo: float) -> None:
    ours, theirs = both_skies(kind, sun, turbidity, albedo)
    of_channels = ours[:16].mean(axis=(0, 1)) / theirs[:16].mean(axis=(0, 1)) - 1.0
    of_halves = [ours[half].mean() / theirs[half].mean() - 1.0 for half in (slice(16), slice(16, 32))]
    print(f"{kind} {sun}: channels {of_channels}, above and below {of_halves}")
    assert np.abs(of_channels).max() < 0.002 and np.abs(of_halves).max() < 0.002
