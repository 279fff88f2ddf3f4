"""Nodes that pass values on or do nothing, clipped images, and what else of real files needs no warning: beside Cycles."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
import scenes
import support
from lodestar import export


def stage() -> Any:
    """A square that a lamp lights from the side, and a camera above it."""
    scene = scenes.empty()
    scene.render.resolution_percentage = 50
    scenes.camera(scene, (0, 0, 4), (0, 0.001, 0))
    scenes.world(scene, (0.2, 0.2, 0.2))
    scenes.lamp(scene, "SUN", (0, 0, 3), (0.8, 0.3, 0.0), energy=2.0, angle=0.0)
    return scene


def with_square(make: Callable[..., Any], *arguments: Any) -> Any:
    """The square with a material that is made after the scene."""
    scene = stage()
    scenes.plane(scene, "square", 8, make(*arguments))
    return scene


def slopes() -> Any:
    """Image of normals that lean to the sides."""
    x = np.linspace(0.0, 1.0, 32)
    parts = np.broadcast_arrays(0.5 + 0.3 * np.sin(9.0 * x)[None, :], 0.4 + 0.3 * x[:, None], 0.9)
    return scenes.image("slopes", np.stack(parts, axis=-1), "Non-Color")


def relief(scale: float | None = 1.0) -> Any:
    """Diffuse surface with a normal map, whose normals are taken apart, scaled, joined and normalized; without a scale, directly."""

    def build(tree: Any) -> Any:
        new = lambda kind: tree.nodes.new(f"ShaderNode{kind}")  # noqa: E731
        image, normals, surface = new("TexImage"), new("NormalMap"), scenes.shader(tree, "ShaderNodeBsdfDiffuse")
        image.image = slopes()
        tree.links.new(image.outputs["Color"], normals.inputs["Color"])
        made = normals.outputs[0]
        if scale is not None:
            parts, joined, unit = new("SeparateXYZ"), new("CombineXYZ"), new("VectorMath")
            unit.operation = "NORMALIZE"
            tree.links.new(made, parts.inputs[0])
            for at in range(3):
                output = parts.outputs[at]
                if at < 2:
                    times = new("Math")
                    times.operation = "MULTIPLY"
                    times.inputs[1 - at].default_value = scale
                    tree.links.new(output, times.inputs[at])
                    output = times.outputs[0]
                tree.links.new(output, joined.inputs[at])
            tree.links.new(joined.outputs[0], unit.inputs[0])
            made = unit.outputs[0]
        tree.links.new(made, surface.inputs["Normal"])
        return surface.outputs[0]

    return scenes.material("relief", build)


def passed_normals() -> Any:
    return with_square(relief)


def falloff(smooth: float = 0.0) -> Callable[[], Any]:
    """A lamp whose strength comes from a Light Falloff node."""

    def quadratic_falloff() -> Any:
        scene = with_square(scenes.diffuse, "gray", (0.6, 0.6, 0.6))
        data = scenes.lamp(scene, "POINT", (0.5, 0, 1.5), energy=10.0, shadow_soft_size=0.0).data
        data.use_nodes = True
        tree = data.node_tree
        emission, node = next(each for each in tree.nodes if each.type == "EMISSION"), tree.nodes.new("ShaderNodeLightFalloff")
        node.inputs["Strength"].default_value, node.inputs["Smooth"].default_value = 4.0, smooth
        tree.links.new(node.outputs["Quadratic"], emission.inputs["Strength"])
        return scene

    return quadratic_falloff


def picture(scale: float, shift: float, space: str = "Non-Color") -> Any:
    """Surface with the color and the alpha of an image at scaled and shifted coordinates."""

    def build(tree: Any) -> Any:
        rows, columns = np.mgrid[0:16, 0:16] / 15.0
        image, place, coordinates = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexImage", "Mapping", "TexCoord"))
        image.image = scenes.image("picture", np.stack([0.2 + 0.7 * rows, 0.9 - 0.6 * columns, 0.5 + 0.0 * rows], axis=-1), space)
        image.extension = "CLIP"
        place.inputs["Scale"].default_value, place.inputs["Location"].default_value = (scale,) * 3, (shift, 0.5 * shift, 0.0)
        tree.links.new(coordinates.outputs["UV"], place.inputs["Vector"])
        tree.links.new(place.outputs[0], image.inputs["Vector"])
        surface = scenes.shader(tree, "ShaderNodeBsdfPrincipled", Roughness=0.8)
        tree.links.new(image.outputs["Color"], surface.inputs["Base Color"])
        tree.links.new(image.outputs["Alpha"], surface.inputs["Alpha"])
        return surface.outputs[0]

    return scenes.material("picture", build)


def clipped_image() -> Any:
    return with_square(picture, 2.0, -0.4)


def clipped_colors() -> Any:
    """An image of colors whose alpha is a mask, with an edge as wide as a block."""
    return with_square(picture, 2.0, -0.4, "sRGB")


def clipped_missing_image() -> Any:
    """An image that cannot be loaded: one magenta texel, which fades to its sides."""
    scene = with_square(picture, 2.0, -0.4, "sRGB")
    image = bpy.data.images["picture"]
    image.source, image.filepath = "FILE", "/nowhere/gone.png"
    return scene


def image_within() -> Any:
    return with_square(picture, 0.5, 0.2)


def skin(scale: float, kind: str = "ShaderNodeBsdfPrincipled") -> Any:
    """Surface with subsurface by Christensen and Burley's method below a texture of colors."""

    def build(tree: Any) -> Any:
        image = tree.nodes.new("ShaderNodeTexImage")
        image.image = scenes.image("colors", np.random.default_rng(2).random((4, 4, 3)), "Non-Color")
        if kind == "ShaderNodeBsdfPrincipled":
            surface = scenes.shader(tree, kind, Subsurface_Weight=1.0, Subsurface_Scale=scale)
            surface.subsurface_method = "BURLEY"
            tree.links.new(image.outputs["Color"], surface.inputs["Base Color"])
        else:
            surface = scenes.shader(tree, kind, Scale=scale)
            surface.falloff = "BURLEY"
            tree.links.new(image.outputs["Color"], surface.inputs["Color"])
        return surface.outputs[0]

    return scenes.material("skin", build)


def no_radius() -> Any:
    return with_square(skin, 0.0)


def no_radius_of_subsurface() -> Any:
    return with_square(skin, 0.0, "ShaderNodeSubsurfaceScattering")


def relief_below_normal_map() -> Any:
    """A displacement that is relief, below a normal map, which alone counts."""
    scene = with_square(relief, None)
    tree = bpy.data.materials["relief"].node_tree
    noise, height = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeDisplacement")
    output = next(each for each in tree.nodes if each.type == "OUTPUT_MATERIAL")
    tree.links.new(noise.outputs[0], height.inputs["Height"])
    tree.links.new(height.outputs[0], output.inputs["Displacement"])
    return scene


def area_without_mis() -> Any:
    """An area light without Multiple Importance in front of the camera, above a glossy surface that is no mirror."""
    scene = with_square(scenes.simple, "glossy", "ShaderNodeBsdfGlossy")
    light = scenes.lamp(scene, "AREA", (0.8, 0, 1.5), (0.0, 0.6, 0.0), energy=30.0, size=0.6)
    light.data.cycles.use_multiple_importance_sampling = False
    return scene


def transparent_film(x: float = 3.5) -> Any:
    """A transparent film, and a lamp with a radius and an emitting square, both beside the picture."""
    scene = with_square(scenes.diffuse, "gray", (0.6, 0.6, 0.6))
    scene.render.film_transparent = True
    scenes.lamp(scene, "POINT", (x, 0, 2), energy=300.0, shadow_soft_size=0.3)
    scenes.plane(scene, "source", 1.0, scenes.simple("light", "ShaderNodeEmission", Strength=20.0), location=(-x, 0, 0.5), rotation=(0, 1.4, 0))
    return scene


class UnknownNode(bpy.types.ShaderNode):
    bl_idname, bl_label = "UnknownNode", "Unknown"

    def init(self, context: Any) -> None:
        self.outputs.new("NodeSocketColor", "Color")


def node_of_missing_addon() -> Any:
    """A color by a node whose add-on is not there."""

    def build(tree: Any) -> Any:
        surface = scenes.shader(tree, "ShaderNodeBsdfDiffuse", Color=(0.7, 0.4, 0.2))
        tree.links.new(tree.nodes.new("UnknownNode").outputs[0], surface.inputs["Color"])
        return surface.outputs[0]

    def make() -> Any:
        bpy.utils.register_class(UnknownNode)
        made = scenes.material("unknown", build)
        bpy.utils.unregister_class(UnknownNode)
        return made

    return with_square(make)


BUILDS = [
    passed_normals, falloff(), clipped_image, clipped_colors, clipped_missing_image, image_within, no_radius, no_radius_of_subsurface,
    node_of_missing_addon, relief_below_normal_map, area_without_mis, transparent_film,
]  # fmt: skip


@pytest.mark.parametrize("build", BUILDS, ids=[build.__name__ for build in BUILDS])
def test_agrees_with_cycles(tmp_path: Path, build: Callable[[], Any]) -> None:
    scene = build()
    assert exported(tmp_path).report.warnings == []
    theirs = support.colors(support.render(scene, "CYCLES", 256, build.__name__))
    ours = support.colors(support.render(scene, "LODESTAR", 256, build.__name__))
    found, ratio = support.deviation(ours, theirs, 8), support.mean_ratio(ours, theirs)
    print(f"{build.__name__}: largest deviation {found:.4f}, ratio of means {ratio:.4f}")
    assert found < 0.03 and abs(ratio - 1.0) < 0.01


def exported(folder: Path) -> export.Export:
    return export.export(bpy.context.evaluated_depsgraph_get(), folder, export.Options())


def test_passed_normals_are_those_of_the_map(tmp_path: Path) -> None:
    files = []
    for name, scale in (("direct", None), ("passed", 1.0), ("scaled", 0.5)):
        with_square(relief, scale)
        found = exported(tmp_path / name)
        files.append((found.scene_file.read_text(), found.report.warnings))
    assert files[0] == files[1]
    assert files[2][1] == ['material "relief": the node "Vector Math" (Vector Math) is not supported; the surface keeps its normals']


def test_blender_draws_strokes_itself(tmp_path: Path) -> None:
    """Grease Pencil is drawn over the picture of any engine, if Blender has graphics here."""
    scene = with_square(scenes.diffuse, "gray", (0.5, 0.5, 0.5))
    plain = support.colors(support.render(scene, "CYCLES", 16, "plain"))
    add = getattr(bpy.ops.object, "grease_pencil_add", None) or bpy.ops.object.gpencil_add
    add(type="MONKEY", location=(0, 0, 1), rotation=(-1.57, 0, 0))
    assert exported(tmp_path).report.warnings == []
    theirs = support.colors(support.render(scene, "CYCLES", 64, "strokes"))
    if support.deviation(theirs, plain, 8) > 0.1:
        assert support.deviation(support.colors(support.render(scene, "LODESTAR", 64, "strokes")), theirs, 8) < 0.03


def test_light_probes_are_not_named(tmp_path: Path) -> None:
    """Probes serve EEVEE alone."""
    scene = with_square(scenes.diffuse, "gray", (0.5, 0.5, 0.5))
    bpy.ops.object.lightprobe_add(type="SPHERE" if bpy.app.version >= (4, 1, 0) else "CUBEMAP")
    assert any(each.type == "LIGHT_PROBE" for each in scene.objects)
    assert exported(tmp_path).report.warnings == []


def test_what_still_differs_is_named(tmp_path: Path) -> None:
    """The twins of the scenes above: a smooth falloff, subsurface with a radius, a weaker normal map, and lamps in view."""
    relief_below_normal_map()
    next(each for each in bpy.data.materials["relief"].node_tree.nodes if each.type == "NORMAL_MAP").inputs["Strength"].default_value = 0.5
    assert len(exported(tmp_path).report.warnings) == 1
    falloff(1.0)()
    assert len(exported(tmp_path).report.warnings) == 1
    transparent_film(1.0)
    assert len(exported(tmp_path).report.warnings) == 1
    for kind in ("ShaderNodeBsdfPrincipled", "ShaderNodeSubsurfaceScattering"):
        with_square(skin, 0.2, kind)
        assert len(exported(tmp_path).report.warnings) == 2


def test_images_are_computed_where_they_are_clipped(tmp_path: Path) -> None:
    """An image within which all coordinates lie is an image; another one is computed, and so is one of a mesh that a modifier changes."""
    for scale, modifier, is_computed in ((0.5, None, False), (2.0, None, True), (0.5, "ARRAY", True), (0.5, "SUBSURF", False)):
        scene = with_square(picture, scale, 0.0)
        if modifier is not None:
            scene.objects["square"].modifiers.new("modifier", modifier)
        text = exported(tmp_path).scene_file.read_text()
        assert ('type="minimum"' in text) == is_computed, (scale, modifier)
