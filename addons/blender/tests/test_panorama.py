"""Panoramic cameras beside Cycles."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import scenes
import support


def room(limits: tuple[float, float, float, float]) -> Any:
    """Colored balls and a lamp around an equirectangular camera that is turned."""
    scene = scenes.empty()
    scene.render.resolution_x, scene.render.resolution_y = 64, 32
    placed = scenes.camera(scene, (0.2, 0, 0.1), (1, 0.4, 0.3), type="PANO")
    settings = placed.data if hasattr(placed.data, "panorama_type") else placed.data.cycles
    settings.panorama_type = "EQUIRECTANGULAR"
    for name, degrees in zip(("longitude_min", "longitude_max", "latitude_min", "latitude_max"), limits):
        setattr(settings, name, math.radians(degrees))
    for at, color in (((2, 0, 0), (0.8, 0.1, 0.1)), ((0, 2, 0), (0.1, 0.8, 0.1)), ((-2, 0, 0), (0.1, 0.1, 0.8)), ((0, -2, 0.5), (0.8, 0.8, 0.1))):
        scenes.ball(scene, f"ball {at}", 0.8, scenes.diffuse(f"color {at}", color), location=at)
    scenes.plane(scene, "floor", 12, scenes.diffuse("floor", (0.6, 0.6, 0.6)), location=(0, 0, -1))
    scenes.lamp(scene, "AREA", (0, 0, 3), energy=200, size=1.0)
    scenes.world(scene, (0.2, 0.3, 0.5))
    return scene


@pytest.mark.parametrize("limits", [(-180, 180, -90, 90), (-60, 100, -30, 70)], ids=str)
def test_agrees_with_cycles(limits: tuple[float, float, float, float]) -> None:
    scene = room(limits)
    theirs, ours = (support.colors(support.render(scene, engine, 64, "panorama")) for engine in ("CYCLES", "LODESTAR"))
    found, ratio = support.deviation(ours, theirs), support.mean_ratio(ours, theirs)
    print(f"{limits}: largest deviation {found:.4f}, ratio of means {ratio:.4f}")
    assert found < 0.03 and abs(ratio - 1.0) < 0.01
    # The twin: a mirrored picture is another.
    assert support.deviation(np.ascontiguousarray(ours[:, ::-1]), theirs) > 0.1
