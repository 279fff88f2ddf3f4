"""Scenes made in code, rendered by Cycles and by Lodestar."""

from __future__ import annotations

import math
from typing import Any

import bpy
import numpy as np
import pytest
import scenes
import support
from lodestar import exr

# Scene, samples of both, largest deviation of a block mean, and of the whole mean. Most of a bound is noise.
ROWS = [
    ("lamps", 512, 0.04, 0.01),
    ("textures", 128, 0.02, 0.005),
    ("environment", 128, 0.03, 0.01),
    ("glass", 256, 0.02, 0.005),
    ("instances", 128, 0.03, 0.005),
    ("relief_from_above", 32, 0.005, 0.002),
    ("computed", 128, 0.02, 0.005),
]
# Blender before 5 has one sky of the two.
ROWS += [(name, 256, 0.03, 0.01) for name in ("sky", "sky_of_one_scattering") if name != "sky" or bpy.app.version >= (5, 0, 0)]
# Cycles before 4.5 darkens slopes more (scenes.relief_from_above).
if bpy.app.version >= (4, 5, 0):
    ROWS.append(("relief", 128, 0.01, 0.005))


def deviation(scene: Any, ours: np.ndarray, theirs: np.ndarray) -> float:
    """Largest difference of the means of blocks, of which a picture without a border has 4 x 4."""
    return support.deviation(ours, theirs, support.BLOCK * scene.render.resolution_percentage // 100)


def assert_agrees(scene: Any, name: str, samples: int, block: float, whole: float) -> None:
    """Asserts that blocks of Lodestar's picture differ from Cycles' by less than `block`, and the means by less than `whole`."""
    theirs = support.colors(support.render(scene, "CYCLES", samples, "beside"))
    ours = support.colors(support.render(scene, "LODESTAR", samples, "beside"))
    assert ours.shape == theirs.shape
    found, ratio = deviation(scene, ours, theirs), support.mean_ratio(ours, theirs)
    print(f"{name}: largest deviation {found:.4f}, ratio of means {ratio:.4f}")
    assert found < block and abs(ratio - 1.0) < whole


@pytest.mark.parametrize("name,samples,block,whole", ROWS, ids=[row[0] for row in ROWS])
def test_agrees_with_cycles(name: str, samples: int, block: float, whole: float) -> None:
    assert_agrees(scenes.ALL[name](), name, samples, block, whole)


def test_twin_a_stronger_lamp_is_found() -> None:
    """The comparison finds a lamp with 5 % more power."""
    _, samples, block, whole = next(row for row in ROWS if row[0] == "relief_from_above")
    scene = scenes.relief_from_above()
    theirs = support.colors(support.render(scene, "CYCLES", samples, "twin"))
    scene.objects["area"].data.energy *= 1.05
    ours = support.colors(support.render(scene, "LODESTAR", samples, "twin"))
    assert deviation(scene, ours, theirs) > block
    assert abs(support.mean_ratio(ours, theirs) - 1.0) > whole


def test_the_vector_of_a_group_is_a_constant() -> None:
    """A texture whose vector is an input of its group, without a link, has the value at the input's number, as in Cycles."""
    for engine in ("CYCLES", "LODESTAR"):
        scene = scenes.empty()
        scene.render.resolution_percentage = 25
        scenes.camera(scene, (0, 0, 3), (0, 0, 0))
        scenes.plane(scene, "ground", 9, scenes.material("grouped", scenes.grouped_place))
        scenes.world(scene, (1, 1, 1))
        image = support.colors(support.render(scene, engine, 16, "group"))
        assert abs(image.mean() - 0.3) < 0.005 and np.abs(image - 0.3).max() < 0.1, engine


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


@pytest.mark.parametrize("roughness", [0.0, 0.1, 0.16, 0.17, 0.2, 0.3, 0.5, 1.0])
def test_principled_sphere(roughness: float) -> None:
    """A Principled sphere in a white world has the brightness that it has in Cycles."""
    pictures = {}
    for engine in ("CYCLES", "LODESTAR"):
        scene = scenes.empty()
        scene.render.resolution_percentage = 25
        scenes.camera(scene, (0, -5, 0), (0, 0, 0), type="ORTHO", ortho_scale=1.9)
        scenes.world(scene, (1, 1, 1))
        surface = scenes.simple("white", "ShaderNodeBsdfPrincipled", Base_Color=(0.7, 0.7, 0.7), Roughness=roughness)
        scenes.ball(scene, "ball", 1.0, surface)
        pictures[engine] = support.colors(support.render(scene, engine, 128, "sphere"))
    ratio = support.mean_ratio(pictures["LODESTAR"], pictures["CYCLES"])
    center = support.mean_ratio(pictures["LODESTAR"][6:10, 6:10], pictures["CYCLES"][6:10, 6:10])
    print(f"roughness {roughness}: ratio of means {ratio:.4f}, in the center {center:.4f}")
    assert abs(ratio - 1.0) < 0.025 and abs(center - 1.0) < 0.06


# Sockets of a Principled surface; `distribution` is a property. The test has 128 samples, and allows differences of 3 % of a block and
# 1 % of the mean.
LAYERS = {
    "smooth coat": dict(Base_Color=(0.7, 0.1, 0.1), Coat_Weight=1.0, Coat_Roughness=0.03),
    "rough coat": dict(Base_Color=(0.1, 0.1, 0.1), Coat_Weight=0.7, Coat_Roughness=0.7, Coat_IOR=2.0),
    "tinted coat": dict(Base_Color=(0.8, 0.8, 0.8), Coat_Weight=1.0, Coat_Roughness=0.2, Coat_Tint=(1.0, 0.3, 0.1)),
    "tinted coat on metal": dict(
        Base_Color=(0.8, 0.6, 0.3), Metallic=1.0, Roughness=0.3, Coat_Weight=1.0, Coat_Roughness=0.2, Coat_Tint=(0.3, 0.6, 0.9)
    ),
    "tinted metal": dict(Base_Color=(0.8, 0.6, 0.3), Metallic=1.0, Roughness=0.3, Specular_Tint=(0.2, 0.5, 0.9)),
    "tinted dielectric": dict(Base_Color=(0.1, 0.1, 0.1), Roughness=0.3, Specular_Tint=(0.1, 0.5, 1.0), IOR=2.0),
    "dielectric": dict(Base_Color=(0.8, 0.8, 0.8), Roughness=0.5, IOR=1.45),
    "dull dielectric": dict(Base_Color=(0.8, 0.8, 0.8), Roughness=1.0, IOR=1.8),
    "dielectric of all reflections": dict(Base_Color=(0.8, 0.8, 0.8), Roughness=0.8, IOR=1.8, distribution="MULTI_GGX"),
    "sheen over a coat": dict(
        Base_Color=(0.7, 0.2, 0.1), Roughness=0.7, Coat_Weight=1.0, Coat_Roughness=0.2, Sheen_Weight=0.8, Sheen_Roughness=0.5
    ),
    "sheen over glass": dict(Base_Color=(0.9, 0.9, 0.9), Transmission_Weight=0.5, Roughness=0.3, Sheen_Weight=1.0, Sheen_Roughness=0.5),
    "dielectric of a level": dict(Base_Color=(0.8, 0.8, 0.8), Roughness=0.4, IOR=1.5, Specular_IOR_Level=1.0),
}


def layered(sockets: dict[str, Any]) -> Any:
    """Principled material."""
    surface = scenes.simple("layers", "ShaderNodeBsdfPrincipled", **{name: each for name, each in sockets.items() if name != "distribution"})
    node = next(each for each in surface.node_tree.nodes if each.type == "BSDF_PRINCIPLED")
    node.distribution = sockets.get("distribution", "GGX")
    return surface


def patches(tree: Any) -> Any:
    """Two roughnesses, which an image gives."""
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = scenes.image("roughness", np.repeat([[[0.25], [0.9]]], 3, axis=2), "Non-Color", True)
    texture.interpolation = "Closest"
    sockets = {"Base_Color": (0.8, 0.8, 0.8), "Roughness": texture.outputs["Color"], "IOR": 1.8}
    return scenes.shader(tree, "ShaderNodeBsdfPrincipled", **sockets).outputs[0]


@pytest.mark.parametrize("name", [*LAYERS, "patches"])
def test_principled_layers(name: str) -> None:
    """Layers of a Principled ball on a ground have the brightness that they have in Cycles."""
    scene = scenes.empty()
    scene.render.resolution_percentage = 50
    scenes.camera(scene, (0, -4, 1.5), (0, 0, 0.5))
    scenes.world(scene, (0.5, 0.5, 0.5))
    scenes.plane(scene, "ground", 8, scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    surface = layered(LAYERS[name]) if name in LAYERS else scenes.material(name, patches)
    scenes.ball(scene, "ball", 0.6, surface, location=(0, 0, 0.6))
    assert_agrees(scene, name, 128, 0.03, 0.01)


# Sockets of a Sheen node, and of a Principled one with sheen.
SHEENS = {
    "smooth fibers": dict(Color=(0.9, 0.9, 0.9), Roughness=0.2),
    "fibers": dict(Color=(0.9, 0.5, 0.3), Roughness=0.5),
    "rough fibers": dict(Color=(0.9, 0.9, 0.9), Roughness=1.0),
    "sheen": dict(Base_Color=(0.6, 0.1, 0.1), Roughness=0.6, Sheen_Weight=1.0, Sheen_Roughness=0.3),
    "rough sheen": dict(Base_Color=(0.1, 0.3, 0.7), Roughness=0.4, Sheen_Weight=0.7, Sheen_Roughness=0.9, Sheen_Tint=(1.0, 0.6, 0.2)),
    "sheen over metal": dict(Base_Color=(0.8, 0.6, 0.3), Metallic=1.0, Roughness=0.4, Sheen_Weight=1.0, Sheen_Roughness=0.6),
}


@pytest.mark.parametrize("name", SHEENS)
def test_sheen_under_a_lamp(name: str) -> None:
    """A ball with a sheen under a lamp and a dim sky has the brightness that it has in Cycles, to 2 % of a block and 0.7 % of the mean."""
    sockets = SHEENS[name]
    kind = "ShaderNodeBsdfPrincipled" if "Sheen_Weight" in sockets else "ShaderNodeBsdfSheen"
    scene = scenes.empty()
    scene.render.resolution_percentage = 50
    scenes.camera(scene, (0, -4, 1.2), (0, 0, 0.0), type="ORTHO", ortho_scale=1.3)
    scenes.world(scene, (0.2, 0.2, 0.2))
    scenes.lamp(scene, "AREA", (-2.0, 1.0, 2.5), (0.6, -0.9, 0.0), energy=150.0, size=1.5)
    scenes.ball(scene, "ball", 0.6, scenes.simple(name, kind, **sockets))
    assert_agrees(scene, name, 256, 0.02, 0.007)


@pytest.mark.skipif(bpy.app.version < (4, 3, 0), reason="Blender 4.2 has no Diffuse Roughness")
@pytest.mark.parametrize("roughness,level", [(0.3, 0.5), (1.0, 0.5), (1.0, 0.0)])
def test_a_rough_base_under_a_lamp(roughness: float, level: float) -> None:
    """Diffuse Roughness of a Principled ball under a lamp is that of Cycles, to 2 % of a block and 0.7 % of the mean."""
    scene = scenes.empty()
    scene.render.resolution_percentage = 50
    scenes.camera(scene, (0, -4, 0.0), (0, 0, 0.0), type="ORTHO", ortho_scale=1.3)
    scenes.world(scene, (0.1, 0.1, 0.1))
    scenes.lamp(scene, "SUN", (0.0, -4.0, 2.0), (1.3, 0.0, 0.3), energy=3.0, angle=0.0)
    sockets = dict(Base_Color=(0.8, 0.5, 0.3), Roughness=0.5, Diffuse_Roughness=roughness, Specular_IOR_Level=level)
    scenes.ball(scene, "ball", 0.6, scenes.simple("chalk", "ShaderNodeBsdfPrincipled", **sockets))
    assert_agrees(scene, f"roughness {roughness}, level {level}", 128, 0.02, 0.007)


@pytest.mark.parametrize("roughness", [0.2, 0.5, 1.0])
def test_a_dielectric_under_a_lamp(roughness: float) -> None:
    """A Principled ball that fills the picture has the brightness that it has in Cycles under a lamp."""
    scene = scenes.empty()
    scene.render.resolution_percentage = 50
    scenes.camera(scene, (0, -5, 0), (0, 0, 0), type="ORTHO", ortho_scale=1.3)
    scenes.world(scene, (0, 0, 0))
    scenes.lamp(scene, "POINT", (1.5, -3, 2), energy=300, shadow_soft_size=0.3, use_soft_falloff=True)
    scenes.ball(scene, "ball", 1.0, layered(dict(Base_Color=(0.8, 0.8, 0.8), Roughness=roughness, IOR=1.45)))
    assert_agrees(scene, f"roughness {roughness}", 128, 0.03, 0.01)


@pytest.mark.parametrize("kind", ["all flat", "one smooth", "custom normals"])
def test_flat_faces_that_are_not_plane(kind: str) -> None:
    """A lamp lights flat faces of four corners that do not lie in a plane as in Cycles: by the normals of their triangles, or of corners."""
    scene = scenes.empty()
    scene.render.resolution_percentage = 50
    scenes.camera(scene, (0, 0, 4), (0, 0, 0), type="ORTHO", ortho_scale=3.6)
    scenes.lamp(scene, "SUN", (0, 0, 4), (0.9, 0.0, 0.4), energy=3.0, angle=0.0)
    hills = scenes.plane(scene, "hills", 4, scenes.diffuse("gray", (0.7, 0.7, 0.7)))
    mesh = bpy.data.meshes.new("hills")
    places = [(x - 2, y - 2, 0.3 * (7 * x + 3 * y + x * y) % 0.4) for y in range(5) for x in range(5)]
    mesh.from_pydata(places, [], [(at, at + 1, at + 6, at + 5) for at in range(20) if at % 5 < 4])
    mesh.materials.append(hills.data.materials[0])
    mesh.shade_flat()
    if kind == "one smooth":
        mesh.polygons[0].use_smooth = True
    if kind == "custom normals":
        mesh.normals_split_custom_set([(0.0, 0.0, 1.0)] * len(mesh.loops))
    hills.data = mesh
    assert_agrees(scene, kind, 256, 0.01, 0.006)


# Glass: a node, values of its sockets, and the largest deviations of a block and of the mean. Facets of rough glass differ a little.
GLASSES = {
    "smooth": ("ShaderNodeBsdfGlass", dict(Color=(0.9, 0.8, 0.7), Roughness=0.0, IOR=1.5), 0.02, 0.005),
    "rough": ("ShaderNodeBsdfGlass", dict(Color=(0.9, 0.8, 0.7), Roughness=0.5, IOR=1.5), 0.09, 0.025),
    "thinner than air": ("ShaderNodeBsdfGlass", dict(Color=(0.9, 0.8, 0.7), Roughness=0.3, IOR=0.85), 0.09, 0.025),
    "principled": ("ShaderNodeBsdfPrincipled", dict(Base_Color=(0.9, 0.8, 0.7), Roughness=0.4, IOR=1.45, Transmission_Weight=1.0), 0.06, 0.02),
}


@pytest.mark.parametrize("name", GLASSES)
def test_light_that_leaves_glass_alone(name: str) -> None:
    """A lamp within glass is as bright as in Cycles, where the radiance of light that leaves glass does not fall by the square of the index."""
    kind, sockets, block, whole = GLASSES[name]
    scene = scenes.empty()
    scene.render.resolution_percentage = 50
    scenes.camera(scene, (0, -4, 0.0), (0, 0, 0.0), type="ORTHO", ortho_scale=1.5)
    scenes.world(scene, (0.1, 0.1, 0.1))
    scenes.ball(scene, "shell", 0.7, scenes.simple(name, kind, **sockets))
    scenes.ball(scene, "core", 0.3, scenes.simple("core", "ShaderNodeEmission", Color=(1.0, 0.8, 0.6), Strength=1.0))
    assert_agrees(scene, name, 256, block, whole)


# Surfaces without a diffuse part: a node, values of its sockets, and the largest deviations of a block and of the mean.
GLOSSY = {
    "glossy": ("ShaderNodeBsdfAnisotropic", dict(Color=(0.9, 0.7, 0.5), Roughness=0.3), 0.01, 0.003),
    "mirror": ("ShaderNodeBsdfAnisotropic", dict(Color=(0.9, 0.7, 0.5), Roughness=0.0), 0.01, 0.003),
    "metal": ("ShaderNodeBsdfPrincipled", dict(Base_Color=(0.9, 0.7, 0.5), Roughness=0.3, Metallic=1.0), 0.01, 0.003),
}


def glossy_waves(name: str) -> Any:
    """A plane that is seen from a low angle, with steep waves of a normal map, below a world that is brighter near the horizon."""
    kind, sockets, _, _ = GLOSSY[name]
    scene = scenes.empty()
    scene.render.resolution_percentage = 50
    scenes.camera(scene, (0, -6, 1.2), (0, 0, 0.0), lens=60)
    rows, columns = np.mgrid[0:64, 0:64] * (2 * math.pi / 64)
    normals = np.dstack([np.sin(4 * columns) * 0.6, np.cos(4 * rows) * 0.6, np.full((64, 64), 0.5)])
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)

    def build(tree: Any) -> Any:
        node = tree.nodes.new("ShaderNodeNormalMap")
        texture = tree.nodes.new("ShaderNodeTexImage")
        texture.image = scenes.image("waves", 0.5 * (normals + 1.0), "Non-Color", is_float=True)
        tree.links.new(texture.outputs["Color"], node.inputs["Color"])
        return scenes.shader(tree, kind, **sockets, Normal=node.outputs["Normal"]).outputs[0]

    scenes.plane(scene, "waves", 4, scenes.material(name, build))
    scenes.world(scene, (0.6, 0.8, 1.0))
    scenes.ball(scene, "ball", 0.5, scenes.diffuse("red", (0.8, 0.1, 0.1)), location=(0, 0.5, 0.5))
    return scene


@pytest.mark.skipif(bpy.app.version < (4, 5), reason="before Blender 4.5, Cycles corrects bumps otherwise")
@pytest.mark.parametrize("name", GLOSSY)
def test_normals_of_glossy_surfaces_are_raised(name: str) -> None:
    """Where a normal map would mirror light into a glossy surface, both renderers bend the normal back."""
    _, _, block, whole = GLOSSY[name]
    assert_agrees(glossy_waves(name), name, 256, block, whole)


def test_frames_of_an_animation() -> None:
    """Each frame is rendered with its own scene."""
    scene = scenes.empty()
    scene.render.resolution_percentage = 25
    scenes.camera(scene, (0, 0, 3), (0, 0, 0))
    scenes.world(scene, (1, 1, 1))
    moving = scenes.plane(scene, "plane", 9, scenes.diffuse("black", (0.0, 0.0, 0.0)))
    for frame, height in ((1, 0.0), (2, 9.0)):
        moving.location.z = height
        moving.keyframe_insert("location", frame=frame)
    scene.frame_start, scene.frame_end = 1, 2
    scene.render.engine, scene.render.filepath = "LODESTAR", str(support.FOLDER / "frame-")
    scene.lodestar.samples = 4
    bpy.ops.render.render(animation=True)
    means = [support.colors(exr.read(path)).mean() for path in sorted(support.FOLDER.glob("frame-*.exr"))]
    assert means == pytest.approx([0.0, 1.0], abs=1e-3)
