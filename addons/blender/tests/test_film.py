"""Thin films beside Cycles, and as elements."""

from __future__ import annotations

import math
from pathlib import Path

import bpy
import film_scenes
import numpy as np
import pytest
import scenes
import support
from lodestar import export

pytestmark = pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="Blender 5.0 has films over all three nodes")

# Kind, samples, largest deviation of a block mean, and of the whole mean.
ROWS = [
    ("dielectric", 128, 0.03, 0.01),
    ("dielectric with a base", 128, 0.03, 0.01),
    ("metal", 128, 0.03, 0.01),
    ("Metallic", 128, 0.03, 0.01),
]
KINDS = [row[0] for row in ROWS] + ["glass", "Glass"]


@pytest.mark.parametrize("thickness", film_scenes.THICKNESSES)
@pytest.mark.parametrize("kind,samples,block,whole", ROWS, ids=[row[0] for row in ROWS])
def test_agrees_with_cycles(kind: str, samples: int, block: float, whole: float, thickness: float) -> None:
    scene = film_scenes.ball(kind, thickness)
    theirs, ours = (support.colors(support.render(scene, engine, samples, "film")) for engine in ("CYCLES", "LODESTAR"))
    found, ratio = support.deviation(ours, theirs), support.mean_ratio(ours, theirs)
    print(f"{kind}, {thickness} nm: largest deviation {found:.4f}, ratio of means {ratio:.4f}, colors {ours.mean((0, 1)) / theirs.mean((0, 1))}")
    assert found < block and abs(ratio - 1.0) < whole


def test_twin_a_thicker_film_is_found() -> None:
    """The comparison finds a film that is a tenth thicker."""
    scene = film_scenes.ball("metal", 350.0)
    theirs = support.colors(support.render(scene, "CYCLES", 64, "film"))
    bpy.data.materials["film"].node_tree.nodes["Principled BSDF"].inputs["Thin Film Thickness"].default_value = 385.0
    ours = support.colors(support.render(scene, "LODESTAR", 64, "film"))
    assert support.deviation(ours, theirs) > 0.03


def _reflected(engine: str, thickness: float, side: int) -> np.ndarray:
    """Light that a sheet of the surface of glass reflects, met at right angles from its front or from within the glass."""
    scene = scenes.empty()
    scene.render.resolution_x = scene.render.resolution_y = 16
    scenes.camera(scene, (0, -0.001, 10 * side), (0, 0, 0), lens=600)
    scenes.plane(scene, "sheet", 9, scenes.material("film", lambda tree: film_scenes.node(tree, "Glass", thickness)))
    lamp = scenes.material("lamp", lambda tree: scenes.shader(tree, "ShaderNodeEmission", Color=(1, 1, 1), Strength=1.0).outputs[0])
    # The front of the lamp faces the sheet.
    scenes.plane(scene, "lamp", 90, lamp, location=(0, 0, 20 * side), rotation=(math.pi if side > 0 else 0.0, 0, 0))
    return support.colors(support.render(scene, engine, 1024, "sheet")).mean((0, 1))


def test_glass_reflects_alike_from_both_sides() -> None:
    """As it must by energy. In Cycles 5.0, a film that is met from within the glass is thinner by the glass's index of refraction."""
    front = _reflected("LODESTAR", 350.0, 1)
    assert np.abs(_reflected("CYCLES", 350.0, 1) - front).max() < 0.005
    assert np.abs(_reflected("LODESTAR", 350.0, -1) - front).max() < 0.005
    assert np.abs(_reflected("CYCLES", 350.0, -1) - front).max() > 0.02
    assert np.abs(_reflected("CYCLES", 350.0, -1) - _reflected("LODESTAR", 350.0 / 1.5, 1)).max() < 0.005


def _text(scene: object, folder: Path) -> str:
    export.export(bpy.context.evaluated_depsgraph_get(), folder, export.Options())
    return "".join(file.read_text() for file in folder.glob("*.xml"))


@pytest.mark.parametrize("kind", KINDS)
def test_a_film_has_its_thickness_and_its_index(kind: str, tmp_path: Path) -> None:
    text = _text(film_scenes.ball(kind, 240.0), tmp_path)
    assert 'name="film_thickness" value="240"' in text.replace("240.0", "240") and 'name="film_eta" value="1.8' in text.replace("1.79999995", "1.8")


def test_a_film_of_no_thickness_is_none(tmp_path: Path) -> None:
    """Cycles takes a film of 0.1 nm for none."""
    assert "film_" not in _text(film_scenes.ball("metal", 0.1), tmp_path).replace('id="film', "")


def test_a_tint_under_a_film_is_reported(tmp_path: Path) -> None:
    scene = scenes.empty()
    scenes.camera(scene, (0, -4, 1.5), (0, 0, 0))
    film = {"Thin_Film_Thickness": 300.0, "Specular_Tint": (0.5, 0.6, 0.7)}
    made = scenes.material("film", lambda tree: scenes.shader(tree, "ShaderNodeBsdfPrincipled", **film).outputs[0])
    scenes.ball(scene, "ball", 1.0, made)
    exported = export.export(bpy.context.evaluated_depsgraph_get(), tmp_path, export.Options())
    assert any("Specular Tint under a thin film" in line for line in exported.report.warnings)
