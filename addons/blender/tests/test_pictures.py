"""Six scenes made in code, rendered by Cycles and by Lodestar."""

from __future__ import annotations

import numpy as np
import pytest
import scenes
import support

# Scene, samples of both, largest deviation of a block mean, and of the whole mean. Most of a bound is noise; `glass` has a
# Principled surface, whose diffuse base differs (docs/blender.md).
ROWS = [
    ("lamps", 512, 0.04, 0.01),
    ("textures", 128, 0.02, 0.005),
    ("environment", 128, 0.03, 0.01),
    ("glass", 256, 0.02, 0.005),
    ("instances", 128, 0.03, 0.005),
    ("relief", 128, 0.01, 0.005),
]


@pytest.mark.parametrize("name,samples,block,whole", ROWS, ids=[row[0] for row in ROWS])
def test_agrees_with_cycles(name: str, samples: int, block: float, whole: float) -> None:
    scene = scenes.ALL[name]()
    theirs = support.colors(support.render(scene, "CYCLES", samples, name))
    ours = support.colors(support.render(scene, "LODESTAR", samples, name))
    assert ours.shape == theirs.shape
    found, ratio = support.deviation(ours, theirs), support.mean_ratio(ours, theirs)
    print(f"{name}: largest deviation {found:.4f}, ratio of means {ratio:.4f}")
    assert found < block and abs(ratio - 1.0) < whole


def test_twin_a_stronger_lamp_is_found() -> None:
    """The comparison finds a lamp with 5 % more power."""
    scene = scenes.relief()
    theirs = support.colors(support.render(scene, "CYCLES", 128, "twin"))
    scene.objects["area"].data.energy *= 1.05
    ours = support.colors(support.render(scene, "LODESTAR", 128, "twin"))
    _, _, block, whole = next(row for row in ROWS if row[0] == "relief")
    assert support.deviation(ours, theirs) > block
    assert abs(support.mean_ratio(ours, theirs) - 1.0) > whole


def test_passes() -> None:
    """Albedo, normal, depth and variance arrive in passes of these names."""
    scene = scenes.empty()
    scenes.camera(scene, (0, 0, 3), (0, 0, 0))
    scenes.plane(scene, "ground", 9, scenes.diffuse("red", (0.8, 0.2, 0.1)))
    scenes.world(scene, (1, 1, 1))
    picture = support.render(scene, "LODESTAR", 16, "passes")
    layer = lambda name, ids: picture.layer([f"ViewLayer.{name}.{each}" for each in ids])  # noqa: E731
    assert np.allclose(layer("Albedo", "RGB"), (0.8, 0.2, 0.1), atol=1e-3)
    assert np.allclose(layer("Normal", "XYZ"), (0, 0, 1), atol=1e-3)
    assert np.abs(layer("Depth", "Z")[31:33, 31:33] - 3.0).max() < 0.01
    assert (layer("Variance", "RGB") >= 0.0).all()


def test_border_without_crop() -> None:
    """A border that does not crop fills its window of the whole picture."""
    scene = scenes.empty()
    scenes.camera(scene, (0, 0, 3), (0, 0, 0))
    scenes.world(scene, (1, 1, 1))
    scene.render.use_border, scene.render.use_crop_to_border = True, False
    scene.render.border_min_x, scene.render.border_max_x = 0.5, 1.0
    scene.render.border_min_y, scene.render.border_max_y = 0.75, 1.0
    image = support.colors(support.render(scene, "LODESTAR", 4, "border"))
    assert image.shape == (64, 64, 3)
    assert np.allclose(image[:16, 32:], 1.0, atol=1e-3)
    assert not image[16:].any() and not image[:, :32].any()
