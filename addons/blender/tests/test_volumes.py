"""Volumes and subsurface: pictures beside those of Cycles, what the export writes, and what it reports."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import bpy
import numpy as np
import pytest
import scenes
import support
import volume_scenes
from lodestar import export, subsurface, volumes

# Side of the blocks whose means are compared, in pixels.
BLOCK = 8
# Bounces of both. Boundaries of volumes are edges of Lodestar's paths, not bounces of Cycles'.
BOUNCES = 128
# Scene, samples of both, largest deviation of a block mean, and of the whole mean. Most of a bound is noise.
ROWS = [
    ("bodies", 256, 0.03, 0.01),
    ("mixes", 256, 0.03, 0.01),
    ("fog", 256, 0.06, 0.01),  # much noise: 4.1 %, and 1.8 % with 1,024 samples
    ("within", 256, 0.03, 0.01),
    ("smoke", 256, 0.03, 0.01),
    ("wax", 1024, 0.03, 0.01),
]


def picture(scene: Any, engine: str, samples: int, name: str) -> np.ndarray:
    return support.colors(support.render(scene, engine, samples, name, BOUNCES))


def made(name: str) -> Any:
    return volume_scenes.smoke(support.FOLDER) if name == "smoke" else getattr(volume_scenes, name)()


@pytest.mark.parametrize("name,samples,block,whole", ROWS, ids=[row[0] for row in ROWS])
def test_agrees_with_cycles(name: str, samples: int, block: float, whole: float) -> None:
    scene = made(name)
    theirs, ours = (picture(scene, engine, samples, name) for engine in ("CYCLES", "LODESTAR"))
    found, ratio = support.deviation(ours, theirs, BLOCK), support.mean_ratio(ours, theirs)
    print(f"{name}: largest deviation {found:.4f}, ratio of means {ratio:.4f}")
    assert found < block and abs(ratio - 1.0) < whole


def test_skin_has_the_figure_of_its_warning(tmp_path: Path) -> None:
    """A ball of skin is darker than in Cycles, by at most as much as the report says."""
    volume_scenes.skin()
    assert "up to 9 % darker than in Cycles" in "\n".join(exported(tmp_path)[1])
    theirs, ours = (picture(volume_scenes.skin(), engine, 256, "skin")[12:20, 12:20] for engine in ("CYCLES", "LODESTAR"))
    ratios = ours.mean(axis=(0, 1)) / theirs.mean(axis=(0, 1))
    print(f"skin: {ratios}")
    assert (ratios < 0.97).all() and (ratios > 0.90).all()


def exported(folder: Path) -> tuple[ElementTree.Element, list[str]]:
    """Scene file and warnings of the current scene."""
    found = export.export(bpy.context.evaluated_depsgraph_get(), folder, export.Options())
    return ElementTree.parse(found.scene_file).getroot(), found.report.warnings


def coefficients(root: ElementTree.Element, reference: Any, name: str) -> list[float]:
    medium = next(m for m in root.iter("medium") if m.get("id") == reference.get("id"))
    element = next(child for child in medium if child.get("name") == name)
    return [float(value) for value in element.get("value", "").split()]


def test_volumes_within_each_other_add_up(tmp_path: Path) -> None:
    """The inner ball has the sum of both volumes inside, and the outer ball's volume outside."""
    scene = volume_scenes.mixes()
    root, warnings = exported(tmp_path)
    assert not warnings
    sides = [{ref.get("name"): ref for ref in shape.iter("ref") if ref.get("name")} for shape in root.iter("shape")]
    inner = next(side for side in sides if len(side) == 2)
    assert coefficients(root, inner["interior"], "sigma_a") == pytest.approx([1.6, 1.0, 0.2])
    assert coefficients(root, inner["exterior"], "sigma_a") == pytest.approx([0.0] * 3)
    for side in inner.values():
        assert coefficients(root, side, "sigma_s") == pytest.approx([0.63] * 3)
    # A shift lets the two surfaces cross.
    scene.objects["inner"].location.x += 0.8
    assert any("overlap in part" in warning and '"inner" and "outer"' in warning for warning in exported(tmp_path)[1])


def test_the_camera_has_a_medium(tmp_path: Path) -> None:
    """The camera's medium is that of the body that it stands in."""
    scene = volume_scenes.within()
    root, _ = exported(tmp_path)
    reference = root.find("sensor/ref")
    assert coefficients(root, reference, "sigma_s") == pytest.approx([0.07, 0.08, 0.09])
    scene.objects["around"].location.y += 20.0
    assert exported(tmp_path)[0].find("sensor/ref") is None


def test_what_is_not_supported_is_reported(tmp_path: Path) -> None:
    def build(tree: Any) -> Any:
        noise = tree.nodes.new("ShaderNodeTexNoise")
        return volume_scenes.scattering(tree, density=noise.outputs[0])

    scene = volume_scenes.stage()
    scenes.ball(scene, "cloud", 0.5, volume_scenes.volume("cloud", build))
    textured = lambda t: scenes.shader(t, "ShaderNodeBsdfPrincipled", Subsurface_Weight=1.0, Base_Color=t.nodes.new("ShaderNodeTexNoise").outputs[1]).outputs[0]  # noqa: E731
    scenes.ball(scene, "skin", 0.5, scenes.material("skin", textured))
    kinds = "ShaderNodeBsdfTransparent", "ShaderNodeSubsurfaceScattering"
    scenes.ball(scene, "holes", 0.5, scenes.material("holes", lambda t: scenes.mixed(t, *(scenes.shader(t, kind) for kind in kinds))))
    root, warnings = exported(tmp_path)
    report = "\n".join(warnings)
    assert "subsurface beside holes is not supported; the surface is diffuse" in report
    assert sum(bsdf.get("type") == "difftrans" for bsdf in root.iter("bsdf")) == 1
    assert "a density that is computed from place to place is not supported; it is 1 everywhere" in report
    assert "subsurface is a medium of the albedo 0.9" in report


@pytest.mark.parametrize("kind,name", [("ShaderNodeBsdfPrincipled", "subsurface_method"), ("ShaderNodeSubsurfaceScattering", "falloff")])
def test_sockets_that_a_method_hides_are_not_read(tmp_path: Path, kind: str, name: str) -> None:
    """Christensen and Burley's method has no anisotropy, and the export of it ends with a medium."""
    scene = volume_scenes.stage()
    made = scenes.simple("skin", kind, **({"Subsurface_Weight": 1.0} if name == "subsurface_method" else {}))
    setattr(next(n for n in made.node_tree.nodes if hasattr(n, name)), name, "BURLEY")
    scenes.ball(scene, "ball", 0.5, made)
    root, warnings = exported(tmp_path)
    assert any("Burley's subsurface is rendered as a random walk" in warning for warning in warnings)
    assert root.find("medium") is not None


def test_phase_functions() -> None:
    """Mean cosines are those of numeric integrals, and the shares that are scattered backwards those that are asked for."""
    cosines = np.linspace(-1.0, 1.0, 200_001)
    for g, alpha in ((0.3, 2.0), (0.7, 0.5), (0.6, 100.0)):
        draine = (1.0 + alpha * cosines**2) / (1.0 + g * g - 2.0 * g * cosines) ** 1.5
        assert volumes.draine_cosine(g, alpha) == pytest.approx((draine * cosines).sum() / draine.sum(), rel=1e-3)
    for share in (0.02, 0.1, 0.4):
        g = volumes.cosine_of_backscatter(share)
        lobe = (1.0 - g * g) / (1.0 + g * g - 2.0 * g * cosines) ** 1.5
        assert lobe[cosines < 0.0].sum() / lobe.sum() == pytest.approx(share, rel=1e-3)


def test_media_below_surfaces() -> None:
    """A brighter surface scatters more, and a larger radius has a longer way. Where there is no radius, there is no medium."""
    dark, bright = (subsurface.medium((c, c, c), (1.0, 1.0, 1.0), 0.0, "RANDOM_WALK", 1.4) for c in (0.2, 0.8))
    assert dark.absorption[0] > bright.absorption[0] > 0.0
    way = 1.0 / (bright.absorption[0] + bright.scattering[0][1][0])
    assert way == pytest.approx(0.25 / np.pi, rel=1e-6)
    assert subsurface.medium((0.5, 0.5, 0.5), (0.0, 0.0, 0.0), 0.0, "RANDOM_WALK", 1.4) is None
