"""Settings of real files, each in a small scene that Cycles renders, too."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
import scenes
import support
from lodestar import camera, export, lights, units
from mathutils import Matrix

GRAY = (0.7, 0.7, 0.7)


def base(world: Any = (1, 1, 1), **settings: Any) -> Any:
    """Ground and a ball."""
    scene = scenes.empty()
    scene.render.resolution_percentage = 50
    scenes.camera(scene, **settings)
    if world is not None:
        scenes.world(scene, world)
    scenes.plane(scene, "ground", 8, scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    scenes.ball(scene, "ball", 0.6, scenes.diffuse("red", (0.7, 0.3, 0.3)), location=(0, 0, 0.6))
    return scene


def lamp(scene: Any, kind: str, energy: float, location: Any = (1.5, -1.5, 3), rotation: Any = (0, 0, 0), **settings: Any) -> Any:
    data = bpy.data.lights.new("lamp", kind)
    data.energy = energy
    for name, value in settings.items():
        setattr(data, name, value)
    placed = scenes.add(scene, "lamp", data, location, rotation)
    placed.visible_camera = False
    return placed


def from_above(surface: Callable[[], Any]) -> Any:
    """A square that fills the picture. `surface` makes its material."""
    scene = scenes.empty()
    scene.render.resolution_percentage = 50
    scenes.camera(scene, (0, 0, 2.5), (0, 0, 0))
    scenes.world(scene, (0.5, 0.5, 0.5))
    scenes.plane(scene, "square", 3, surface())
    return scene


def half_clear() -> Any:
    """Image whose left half is transparent."""
    made = bpy.data.images.new("half", 4, 4, alpha=True)
    texels = np.tile(np.array([0.8, 0.4, 0.2, 1.0], np.float32), (4, 4, 1))
    texels[:, :2, 3] = 0.25
    made.pixels.foreach_set(texels.ravel())
    made.pack()
    return made


def textured(kind: str, *links: tuple[str, str], **inputs: Any) -> Any:
    def build(tree: Any) -> Any:
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image, node.interpolation = half_clear(), "Closest"
        return scenes.shader(tree, kind, **inputs, **{to: node.outputs[name] for name, to in links}).outputs[0]

    return scenes.material("textured", build)


def portal() -> Any:
    scene = base()
    lamp(scene, "AREA", 50, (0, 0, 3), size=2.0).data.cycles.is_portal = True
    return scene


def film_exposure() -> Any:
    scene = base()
    scene.cycles.film_exposure = 2.0
    return scene


def no_world_in_layer() -> Any:
    scene = base()
    lamp(scene, "SUN", 2.0, angle=0.0)
    scene.view_layers[0].use_sky = False
    return scene


def no_material() -> Any:
    scene = base()
    scene.objects["ball"].data.materials.clear()
    return scene


def wide_sun() -> Any:
    scene = base(None)
    lamp(scene, "SUN", 3.0, rotation=(0.3, 0.2, 0.0), angle=1.8)
    return scene


def unlinked_alpha() -> Any:
    return from_above(lambda: textured("ShaderNodeBsdfDiffuse", ("Color", "Color")))


def linked_alpha() -> Any:
    links = (("Color", "Base_Color"), ("Alpha", "Alpha"))
    return from_above(lambda: textured("ShaderNodeBsdfPrincipled", *links, Specular_IOR_Level=0.0))


def emission_under_alpha() -> Any:
    sockets = dict(Base_Color=(0, 0, 0), Alpha=0.4, Emission_Color=(1, 0.5, 0.2), Emission_Strength=2.0, Specular_IOR_Level=0.0)
    return from_above(lambda: scenes.simple("lit", "ShaderNodeBsdfPrincipled", **sockets))


def emission_under_texture() -> Any:
    links = (("Color", "Emission_Color"), ("Alpha", "Alpha"))
    sockets = dict(Base_Color=(0, 0, 0), Emission_Strength=2.0, Specular_IOR_Level=0.0)
    return from_above(lambda: textured("ShaderNodeBsdfPrincipled", *links, **sockets))


def values_as_shaders() -> Any:
    """A color and a number in the place of a shader: Cycles emits them."""
    scene = from_above(lambda: scenes.material("color", lambda tree: _with_default(tree.nodes.new("ShaderNodeRGB"), (0.9, 0.4, 0.1, 1.0))))
    number = scenes.material("number", lambda tree: _with_default(tree.nodes.new("ShaderNodeValue"), 1.7))
    scenes.plane(scene, "number", 1, number, location=(0, 0, 0.1))
    return scene


def _with_default(node: Any, value: Any) -> Any:
    node.outputs[0].default_value = value
    return node.outputs[0]


def emission_by_image() -> Any:
    """Emission that an image mixes with a surface, from both sides of the Mix Shader, by the image's own alpha, and a strength that is an image."""

    def build(kind: str) -> Any:
        def surface(tree: Any) -> Any:
            node = tree.nodes.new("ShaderNodeTexImage")
            node.image, node.interpolation = half_clear(), "Closest"
            out = node.outputs
            if kind == "strength":
                return scenes.shader(tree, "ShaderNodeEmission", Color=(1.0, 0.5, 0.3), Strength=out["Color"]).outputs[0]
            light = scenes.shader(tree, "ShaderNodeEmission", Color=out["Color"] if kind == "own" else (1.0, 0.5, 0.3), Strength=2.0)
            parts = [light, scenes.shader(tree, "ShaderNodeBsdfDiffuse", Color=(0.3, 0.3, 0.3))]
            made = scenes.mixed(tree, *(parts if kind == "first" else reversed(parts)))
            tree.links.new(out["Alpha"] if kind == "own" else out["Color"], made.node.inputs[0])
            return made

        return scenes.material(kind, surface)

    scene = from_above(lambda: build("first"))
    for at, kind in enumerate(("second", "own", "strength")):
        scenes.plane(scene, kind, 1, build(kind), location=(0.6 * at - 0.6, 0.4 * at - 0.4, 0.05 + 0.05 * at))
    return scene


def second_colors() -> Any:
    """A mesh with two color attributes, of which renders show the second."""

    def build(tree: Any) -> Any:
        node = tree.nodes.new("ShaderNodeVertexColor")
        return scenes.shader(tree, "ShaderNodeBsdfDiffuse", Color=node.outputs["Color"]).outputs[0]

    scene = from_above(lambda: scenes.material("colored", build))
    attributes = scene.objects["square"].data.color_attributes
    for name, color in (("edited", (0.8, 0.1, 0.1, 1.0)), ("shown", (0.1, 0.3, 0.8, 1.0))):
        attribute = attributes.new(name, "FLOAT_COLOR", "POINT")
        for each in attribute.data:
            each.color = color
    attributes.active_color_index, attributes.render_color_index = 0, 1
    return scene


def overridden() -> Any:
    """A view layer whose material replaces all others."""
    scene = base()
    scene.view_layers[0].material_override = scenes.diffuse("blue", (0.2, 0.3, 0.7))
    return scene


def no_surfaces_in_layer() -> Any:
    scene = base()
    scene.view_layers[0].use_solid = False
    return scene


def lamp_with_nodes() -> Any:
    """A lamp whose nodes multiply its light by a color of a temperature."""
    scene = base(None)
    data = lamp(scene, "AREA", 60, size=0.5).data
    data.use_nodes = True
    tree = data.node_tree
    emission, blackbody = next(node for node in tree.nodes if node.type == "EMISSION"), tree.nodes.new("ShaderNodeBlackbody")
    emission.inputs["Strength"].default_value, blackbody.inputs["Temperature"].default_value = 1.5, 3000.0
    tree.links.new(blackbody.outputs[0], emission.inputs["Color"])
    return scene


def unnormalized_lamps() -> Any:
    """Lamps whose power is not divided by their area, which Blender has since 4.5."""
    scene = base(None)
    lamp(scene, "AREA", 40, size=0.5, normalize=False)
    lamp(scene, "POINT", 30, (-2, -1, 2), shadow_soft_size=0.3, use_soft_falloff=False, normalize=False)
    return scene


def world_of_layer() -> Any:
    """A view layer with a world of its own, which Blender has since 5.0."""
    scene = base()
    first = scene.world
    scenes.world(scene, (0.2, 0.3, 0.7))
    scene.view_layers[0].world_override, scene.world = scene.world, first
    return scene


def attribute_of(name: str, kind: str, socket: str) -> Any:
    """A square with the attribute "wear" of its face, of which the material shows the one with a name."""

    def build(tree: Any) -> Any:
        node = tree.nodes.new("ShaderNodeAttribute")
        node.attribute_name = name
        return scenes.shader(tree, kind, **{socket: node.outputs["Color"]}).outputs[0]

    scene = from_above(lambda: scenes.material("colored", build))
    scene.objects["square"].data.attributes.new("wear", "FLOAT", "FACE").data[0].value = 0.6
    return scene


def number_of_a_face() -> Any:
    """An attribute that is a number of each face."""
    return attribute_of("wear", "ShaderNodeBsdfDiffuse", "Color")


def missing_attribute() -> Any:
    """An attribute that the mesh does not have is 0."""
    return attribute_of("dirt", "ShaderNodeBsdfPrincipled", "Base_Color")


def beckmann() -> Any:
    """Metal and glass with Beckmann's facets."""

    def build(kind: str) -> Any:
        def made(tree: Any) -> Any:
            output = scenes.shader(tree, kind, Color=(0.8, 0.7, 0.5), Roughness=0.6).outputs[0]
            output.node.distribution = "BECKMANN"
            return output

        return made

    scene = base((0.05, 0.05, 0.05))
    scene.objects["ball"].data.materials[0] = scenes.material("metal", build("ShaderNodeBsdfGlossy"))
    scenes.ball(scene, "glass ball", 0.5, scenes.material("glass", build("ShaderNodeBsdfGlass")), location=(-1.2, -0.6, 0.5))
    lamp(scene, "AREA", 150, (2, -2, 3), (0.75, 0, 0.79), size=2.0)
    return scene


def missing_images() -> Any:
    """Images that cannot be loaded, and a node without one: color, alpha, within a program, and the world."""

    def build(tree: Any) -> Any:
        empty = tree.nodes.new("ShaderNodeTexImage")
        gray = tree.nodes.new("ShaderNodeMixRGB")
        gray.inputs["Fac"].default_value, gray.inputs["Color2"].default_value = 0.7, (0.5, 0.5, 0.5, 1.0)
        tree.links.new(empty.outputs["Color"], gray.inputs["Color1"])
        sockets = dict(Base_Color=gray.outputs["Color"], Alpha=empty.outputs["Alpha"], Specular_IOR_Level=0.0)
        return scenes.shader(tree, "ShaderNodeBsdfPrincipled", **sockets).outputs[0]

    scene = from_above(lambda: scenes.material("lost", build))
    lost_world(scene)
    return scene


def lamp_in_view(is_soft: bool = False) -> Any:
    """A lamp that the camera must not see, under a sky that it sees."""
    scene = base((0.6, 0.6, 0.6))
    lamp(scene, "POINT", 60, (0.6, 1.0, 2.2), shadow_soft_size=0.2, use_soft_falloff=is_soft)
    return scene


def area_lamps_in_view() -> Any:
    """Area lamps under a sky: one that the camera does not see, and one that it sees. A mirror shows both."""
    scene = base((0.6, 0.6, 0.6))
    scene.objects["ball"].data.materials[0] = scenes.simple("mirror", "ShaderNodeBsdfGlossy", Color=(0.8, 0.8, 0.8), Roughness=0.2)
    lamp(scene, "AREA", 20, (-0.6, 1.4, 1.6), (-1.2, 0.0, 0.0), size=1.0)
    lamp(scene, "AREA", 10, (0.9, 1.4, 1.6), (-1.2, 0.0, 0.0), size=0.6, shape="DISK").visible_camera = True
    return scene


def rough_diffuse() -> Any:
    """A ball and a floor of rough diffuse surfaces, of which one has a texture of roughness, under a lamp."""
    scene = base((0.2, 0.2, 0.2))
    scene.objects["ball"].data.materials[0] = scenes.simple("chalk", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.5, 0.2), Roughness=1.0)
    made = scenes.simple("clay", "ShaderNodeBsdfDiffuse", Color=(0.5, 0.5, 0.5))
    tree = made.node_tree
    checker = tree.nodes.new("ShaderNodeTexChecker")
    tree.links.new(checker.outputs["Fac"], next(n for n in tree.nodes if n.type in ("BSDF_DIFFUSE", "DIFFUSE_BSDF")).inputs["Roughness"])
    scene.objects["ground"].data.materials[0] = made
    lamp(scene, "AREA", 60, (1.5, -1.0, 3.0), (0.3, 0.5, 0.0), size=1.0)
    return scene


def hidden_instances() -> Any:
    """One mesh that the camera sees and does not see, and a collection that an empty shows without the camera's seeing it."""
    scene = base((0.6, 0.6, 0.6))
    red = scenes.simple("red", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.1, 0.1))
    wall = scenes.plane(scene, "wall", 0.7, red, location=(-0.9, -1.0, 0.5), rotation=(1.4, 0, 0))
    twin = wall.copy()
    scene.collection.objects.link(twin)
    twin.location, twin.visible_camera = (0.4, -1.0, 0.5), False
    shown = bpy.data.collections.new("shown")
    shown.objects.link(scenes.ball(bpy.data.scenes.new("other"), "shown ball", 0.3, red))
    empty = scenes.add(scene, "instancer", None, location=(0.9, -0.9, 1.0))
    empty.instance_type, empty.instance_collection, empty.visible_camera = "COLLECTION", shown, False
    return scene


def hidden_objects() -> Any:
    """Objects that the camera does not see: a wall before the ball, and a ball that glows."""
    scene = base((0.6, 0.6, 0.6))
    wall = scenes.plane(scene, "wall", 1.0, scenes.simple("red", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.1, 0.1)), location=(0.3, -1.3, 0.7), rotation=(1.4, 0, 0))
    glowing = scenes.ball(scene, "glowing", 0.3, scenes.simple("glow", "ShaderNodeEmission", Strength=5.0))
    glowing.location = (-0.9, -0.8, 0.9)
    for each in (wall, glowing):
        each.visible_camera = False
    return scene


def soft_lamp_in_view() -> Any:
    """The same with soft falloff, beside a lamp that the camera sees."""
    scene = lamp_in_view(True)
    lamp(scene, "POINT", 5, (-1.2, 0.8, 1.2), shadow_soft_size=0.3).visible_camera = True
    return scene


def soft_lamps() -> Any:
    """Lamps with soft falloff: one whose radius reaches into ground and ball, a spot, and one that is not normalized."""
    scene = base(None)
    lamp(scene, "POINT", 20, (0.9, -0.5, 0.4), shadow_soft_size=0.7)
    lamp(scene, "SPOT", 60, (-1.4, -0.8, 1.4), (0.3, -0.5, 0.0), shadow_soft_size=0.4, spot_size=1.4, spot_blend=0.6)
    if "normalize" in bpy.types.Light.bl_rna.properties:
        lamp(scene, "POINT", 30, (-1.0, 1.5, 1.0), shadow_soft_size=0.3, normalize=False)
    return scene


def soft_lamp_in_mirrors() -> Any:
    """A smooth ball that shows a soft spot and a soft lamp, which faces the ball."""
    scene = base(None)
    scene.objects["ball"].data.materials[0] = scenes.simple("mirror", "ShaderNodeBsdfGlossy", Color=(0.8, 0.8, 0.8), Roughness=0.1)
    lamp(scene, "POINT", 20, (0.4, -1.6, 1.2), shadow_soft_size=0.6)
    lamp(scene, "SPOT", 60, (-1.4, -0.8, 1.8), (0.3, -0.5, 0.0), shadow_soft_size=0.5, spot_size=1.4, spot_blend=0.3)
    return scene


def lamp_without_mis() -> Any:
    """A smooth ball that does not show a lamp without Multiple Importance."""
    scene = base((0.6, 0.6, 0.6))
    scene.objects["ball"].data.materials[0] = scenes.simple("mirror", "ShaderNodeBsdfGlossy", Color=(0.8, 0.8, 0.8), Roughness=0.0)
    hidden = lamp(scene, "POINT", 40, (0.4, -1.6, 2.0), shadow_soft_size=0.3, use_soft_falloff=False)
    hidden.data.cycles.use_multiple_importance_sampling = False
    return scene


def soft_lamps_without_mis() -> Any:
    """Lamps with soft falloff and without Multiple Importance, next to ground and ball."""
    scene = soft_lamps()
    for each in bpy.data.lights:
        each.cycles.use_multiple_importance_sampling = False
    return scene


def spot_with_radius() -> Any:
    """A spot whose shadow is soft, and whose cone is wider than the picture."""
    scene = base(None)
    lamp(scene, "SPOT", 300, (1.2, -0.6, 2.4), (0.25, 0.45, 0.0), shadow_soft_size=0.4, use_soft_falloff=False, spot_size=2.0, spot_blend=0.0)
    return scene


def suns_behind_glass() -> Any:
    """Suns beside the picture: glass lets the light of the one with Multiple Importance pass, and a mirror shows that one."""
    scene = base((0.2, 0.3, 0.4))
    scene.objects["ball"].data.materials[0] = scenes.simple("glass", "ShaderNodeBsdfGlass", Roughness=0.0, IOR=1.3)
    mirror = scenes.simple("mirror", "ShaderNodeBsdfAnisotropic", Roughness=0.0)
    scenes.plane(scene, "mirror", 1.5, mirror, location=(-1.8, 0.5, 0.8), rotation=(0.9, 0.5, 0.0))
    lamp(scene, "SUN", 2.0, rotation=(0.5, 0.4, 0.0), angle=0.5)
    lamp(scene, "SUN", 1.0, rotation=(-0.5, 0.4, 0.0), angle=0.4).data.cycles.use_multiple_importance_sampling = False
    return scene


def nodes_of_eevee() -> Any:
    """Shader to RGB, before a color, behind a ramp and in the place of a shader, and the Specular BSDF of EEVEE: Cycles knows neither."""

    def surface(kind: str) -> Any:
        def build(tree: Any) -> Any:
            if kind == "specular":
                return tree.nodes.new("ShaderNodeEeveeSpecular").outputs[0]
            made = tree.nodes.new("ShaderNodeShaderToRGB").outputs["Color"]
            if kind == "ramp":
                ramp = tree.nodes.new("ShaderNodeValToRGB")
                ramp.inputs[0].default_value = 0.25
                tree.links.new(made, ramp.inputs[0])
                made = ramp.outputs[0]
            if kind == "surface":
                return made
            node = scenes.shader(tree, "ShaderNodeBsdfDiffuse", Color=(0.8, 0.4, 0.2))
            tree.links.new(made, node.inputs["Color"])
            return node.outputs[0]

        return scenes.material(kind, build)

    scene = from_above(lambda: surface("color"))
    for at, kind in enumerate(("ramp", "surface", "specular")):
        scenes.plane(scene, kind, 0.5, surface(kind), location=(0.6 * at - 0.6, 0, 0.1))
    return scene


def displaced() -> Any:
    """Displacement as relief, of an object that is scaled, alone and over a bump map; and a normal map whose image is missing."""
    scene = scenes.empty()
    scene.render.resolution_percentage = 50
    scenes.camera(scene, (0, -0.1, 7), (0, 0, 0))
    v, u = np.mgrid[0:64, 0:64] / 64.0 * 2.0 * math.pi
    waves = [scenes.image(name, np.repeat((0.5 + 0.5 * np.sin(3 * t))[:, :, None], 3, axis=2), "Non-Color", True) for name, t in (("u", u), ("v", v))]

    def surface(name: str, is_displaced: bool, relief: str) -> Any:
        made = scenes.simple(name, "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8))
        tree = made.node_tree
        shader, output = (next(n for n in tree.nodes if n.type == kind) for kind in ("BSDF_DIFFUSE", "OUTPUT_MATERIAL"))
        textures = [tree.nodes.new("ShaderNodeTexImage") for _ in waves]
        for texture, wave in zip(textures, waves):
            texture.image = wave
        if is_displaced:
            node = tree.nodes.new("ShaderNodeDisplacement")
            node.inputs["Scale"].default_value = 0.06
            tree.links.new(textures[0].outputs["Color"], node.inputs["Height"])
            tree.links.new(node.outputs[0], output.inputs["Displacement"])
        if relief == "bump":
            node = tree.nodes.new("ShaderNodeBump")
            node.inputs["Distance"].default_value = 0.05
            tree.links.new(textures[1].outputs["Color"], node.inputs["Height"])
            tree.links.new(node.outputs[0], shader.inputs["Normal"])
        if relief == "missing":
            node = tree.nodes.new("ShaderNodeNormalMap")
            tree.links.new(tree.nodes.new("ShaderNodeTexImage").outputs["Color"], node.inputs["Color"])
            tree.links.new(node.outputs[0], shader.inputs["Normal"])
        return made

    for at, (is_displaced, relief) in enumerate(((True, ""), (True, "bump"), (False, "missing"))):
        scenes.plane(scene, f"square {at}", 1, surface(f"{at}", is_displaced, relief), location=(1.6 * at - 1.6, 0, 0), scale=(1.5, 1.5, 1.5))
    lamp(scene, "SUN", 3.0, rotation=(0.3, -0.8, 0.0), angle=0.0)
    return scene


def white_room(*surfaces: Callable[[], Any]) -> Any:
    """Balls side by side in a white world. `surfaces` make their materials."""
    scene = scenes.empty()
    scene.render.resolution_percentage = 50
    scenes.camera(scene, (0, -4, 0), (0, 0, 0))
    scenes.world(scene, (1, 1, 1))
    for at, surface in enumerate(surfaces):
        scenes.ball(scene, f"ball {at}", 0.48, surface(), location=(at - 0.5 * (len(surfaces) - 1), 0, 0))
    return scene


def faceted(kind: str, distribution: str, texture: str = "", **inputs: Any) -> Callable[[], Any]:
    """Maker of a rough surface, of which a gradient gives one socket."""

    def build(tree: Any) -> Any:
        node = scenes.shader(tree, kind, **inputs)
        node.distribution = distribution
        if texture:
            place, gradient = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeTexGradient")
            tree.links.new(place.outputs["UV"], gradient.inputs["Vector"])
            tree.links.new(gradient.outputs["Color"], node.inputs[texture])
        return node.outputs[0]

    return lambda: scenes.material("rough", build)


def rough_metals() -> Any:
    glossy = "ShaderNodeBsdfAnisotropic"
    inputs = dict(Color=(0.9, 0.5, 0.1), Roughness=0.6)
    kinds = (("MULTI_GGX", ""), ("MULTI_GGX", "Color"), ("MULTI_GGX", "Roughness"), ("BECKMANN", ""))
    return white_room(*(faceted(glossy, kind, texture, **inputs) for kind, texture in kinds))


def rough_principled_metals() -> Any:
    inputs = dict(Base_Color=(0.9, 0.5, 0.1), Metallic=1.0)
    kinds = (("MULTI_GGX", 0.6, ""), ("MULTI_GGX", 0.6, "Base Color"), ("GGX", 1.0, ""))
    kind = "ShaderNodeBsdfPrincipled"
    return white_room(*(faceted(kind, name, texture, Roughness=roughness, **inputs) for name, roughness, texture in kinds))


def rough_glass() -> Any:
    kinds = (("MULTI_GGX", 1.5), ("GGX", 1.5), ("BECKMANN", 0.85))
    return white_room(*(faceted("ShaderNodeBsdfGlass", kind, Color=(0.9, 0.7, 0.3), Roughness=0.6, IOR=ior) for kind, ior in kinds))


# Scene, largest deviation of a block mean, and of the whole mean; `no_material` has Disney's diffuse base (docs/blender.md).
ROWS: list[tuple[Callable[[], Any], float, float]] = [
    (portal, 0.03, 0.01),
    (film_exposure, 0.03, 0.01),
    (no_world_in_layer, 0.03, 0.01),
    (no_material, 0.03, 0.01),
    (wide_sun, 0.05, 0.01),
    (unlinked_alpha, 0.03, 0.01),
    (linked_alpha, 0.03, 0.01),
    (emission_under_alpha, 0.03, 0.01),
    (emission_under_texture, 0.03, 0.01),
    (number_of_a_face, 0.03, 0.01),
    (missing_attribute, 0.03, 0.01),
    (second_colors, 0.03, 0.01),
    (overridden, 0.03, 0.01),
    (no_surfaces_in_layer, 0.03, 0.01),
    (lamp_with_nodes, 0.03, 0.01),
    (beckmann, 0.03, 0.01),
    (missing_images, 0.03, 0.01),
    (lamp_in_view, 0.03, 0.01),
    (area_lamps_in_view, 0.03, 0.01),
    (hidden_objects, 0.03, 0.01),
    (hidden_instances, 0.03, 0.01),
    (soft_lamp_in_view, 0.03, 0.01),
    (soft_lamps, 0.03, 0.01),
    (soft_lamp_in_mirrors, 0.03, 0.01),
    (lamp_without_mis, 0.03, 0.01),
    (soft_lamps_without_mis, 0.03, 0.01),
    (spot_with_radius, 0.03, 0.01),
    (values_as_shaders, 0.03, 0.01),
    (emission_by_image, 0.03, 0.01),
    (displaced, 0.03, 0.01),
    (suns_behind_glass, 0.03, 0.01),
    (nodes_of_eevee, 0.02, 0.005),
    (rough_metals, 0.02, 0.003),
    (rough_principled_metals, 0.02, 0.003),
    (rough_glass, 0.02, 0.003),
]
if "normalize" in bpy.types.Light.bl_rna.properties:
    ROWS.append((unnormalized_lamps, 0.03, 0.01))
if bpy.app.version >= (4, 3, 0):
    # Cycles' rough diffuse surface was another one before.
    ROWS.append((rough_diffuse, 0.03, 0.01))
if "world_override" in bpy.types.ViewLayer.bl_rna.properties:
    ROWS.append((world_of_layer, 0.03, 0.01))


# Samples per pixel of rows whose noise would hide the bound; 256 of all others.
SAMPLES = {soft_lamp_in_mirrors: 1024}


@pytest.mark.parametrize("build,block,whole", ROWS, ids=[row[0].__name__ for row in ROWS])
def test_agrees_with_cycles(build: Any, block: float, whole: float) -> None:
    scene, samples = build(), SAMPLES.get(build, 256)
    theirs = support.colors(support.render(scene, "CYCLES", samples, build.__name__))
    ours = support.colors(support.render(scene, "LODESTAR", samples, build.__name__))
    found, ratio = support.deviation(ours, theirs, 8), support.mean_ratio(ours, theirs)
    print(f"{build.__name__}: largest deviation {found:.4f}, ratio of means {ratio:.4f}")
    assert found < block and abs(ratio - 1.0) < whole


def exported(folder: Path) -> export.Export:
    return export.export(bpy.context.evaluated_depsgraph_get(), folder, export.Options())


def sharp_orthographic(scene: Any) -> None:
    scene.camera.data.type, scene.camera.data.dof.use_dof = "ORTHO", True


def linked_light(scene: Any) -> None:
    lamp(scene, "SUN", 1.0).light_linking.receiver_collection = bpy.data.collections.new("lit")


def without_mis(scene: Any) -> None:
    scene.objects["ball"].data.materials[0] = scenes.simple("mirror", "ShaderNodeBsdfGlossy", Roughness=0.0)
    lamp(scene, "AREA", 1.0, (0, -9, 3)).data.cycles.use_multiple_importance_sampling = False


def few_bounces(scene: Any) -> None:
    lamp(scene, "SUN", 1.0).data.cycles.max_bounces = 0


def textured_lamp(scene: Any) -> None:
    data = lamp(scene, "AREA", 1.0).data
    data.use_nodes = True
    emission, texture = (next(n for n in data.node_tree.nodes if n.type == "EMISSION"), data.node_tree.nodes.new("ShaderNodeTexChecker"))
    data.node_tree.links.new(texture.outputs["Color"], emission.inputs["Color"])


def uneven_spot(scene: Any) -> None:
    lamp(scene, "SPOT", 1.0, shadow_soft_size=0.0).scale.x = 2.0


def invisible_world(scene: Any) -> None:
    scene.world.cycles_visibility.camera = False


def transparent_glass(scene: Any) -> None:
    scene.render.film_transparent = scene.cycles.film_transparent_glass = True


def held_out(scene: Any) -> None:
    scene.collection.children.link(bpy.data.collections.new("masks"))
    scene.view_layers[0].layer_collection.children["masks"].holdout = True


def indirect(scene: Any) -> None:
    scene.collection.children.link(bpy.data.collections.new("sources"))
    scene.view_layers[0].layer_collection.children["sources"].indirect_only = True


def sun_in_view(scene: Any) -> None:
    scene.camera.rotation_euler = (math.pi / 2, 0.0, 0.0)
    lamp(scene, "SUN", 1.0, rotation=(-math.pi / 2, 0.0, 0.0), angle=0.1).visible_camera = True


def colors_beside_relief(scene: Any) -> None:
    """A mesh's colors, and a relief that is computed from places. The relief has slopes along texture coordinates."""
    made = scenes.simple("painted", "ShaderNodeBsdfDiffuse")
    tree = made.node_tree
    surface = next(node for node in tree.nodes if node.type in ("BSDF_DIFFUSE", "DIFFUSE_BSDF"))
    colors, noise, bump, places = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("VertexColor", "TexNoise", "Bump", "TexCoord"))
    tree.links.new(colors.outputs["Color"], surface.inputs["Color"])
    tree.links.new(places.outputs["Object"], noise.inputs["Vector"])
    tree.links.new(noise.outputs[0], bump.inputs["Height"])
    tree.links.new(bump.outputs["Normal"], surface.inputs["Normal"])
    scene.objects["ball"].data.color_attributes.new("colors", "FLOAT_COLOR", "POINT")
    scene.objects["ball"].data.materials[0] = made


def lost_world(scene: Any) -> None:
    gone = bpy.data.images.new("gone", 4, 4)
    gone.source, gone.filepath = "FILE", "/nowhere/gone.hdr"
    tree = scene.world.node_tree
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = gone
    tree.links.new(texture.outputs["Color"], next(n for n in tree.nodes if n.type == "BACKGROUND").inputs["Color"])


def ashikhmin(scene: Any) -> None:
    made = scenes.simple("grained", "ShaderNodeBsdfGlossy", Roughness=0.5)
    next(n for n in made.node_tree.nodes if n.type == "BSDF_GLOSSY").distribution = "ASHIKHMIN_SHIRLEY"
    scene.objects["ball"].data.materials[0] = made


def without_caustics(scene: Any) -> None:
    scene.cycles.caustics_refractive = False


def coat_with_normals(scene: Any) -> None:
    made = scenes.simple("coated", "ShaderNodeBsdfPrincipled", Coat_Weight=1.0)
    tree = made.node_tree
    surface = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    tree.links.new(tree.nodes.new("ShaderNodeNewGeometry").outputs["Normal"], surface.inputs["Coat Normal"])
    scene.objects["ball"].data.materials[0] = made


def whole_shadows(scene: Any) -> None:
    made = scenes.simple("leaf", "ShaderNodeBsdfPrincipled", Alpha=0.5)
    made.use_transparent_shadow = False
    scene.objects["ball"].data.materials[0] = made


def fast_gi(scene: Any) -> None:
    scene.cycles.use_fast_gi = True


@pytest.mark.parametrize(
    "change,text",
    [
        (without_caustics, "scene: light that passes glass onto rough surfaces is rendered"),
        (whole_shadows, 'material "leaf": Transparent Shadows that are off'),
        (fast_gi, "scene: Fast GI Approximation"),
        (coat_with_normals, 'material "coated": Coat Normal is not supported'),
        (sharp_orthographic, 'camera "camera": depth of field of an orthographic camera'),
        (linked_light, 'object "lamp": light linking'),
        (without_mis, 'light "lamp": an area light without Multiple Importance'),
        (few_bounces, 'light "lamp": a limit of its bounces'),
        (textured_lamp, 'light "lamp": nodes of lights other than Emission'),
        (uneven_spot, 'light "lamp": a spot that is scaled unevenly'),
        (invisible_world, 'world "world": its invisibility to camera rays'),
        (transparent_glass, "scene: transparent glass"),
        (held_out, 'collection "masks": a holdout'),
        (colors_beside_relief, 'material "painted": a color attribute beside other textures'),
        (sun_in_view, 'light "lamp": a sun that the camera sees'),
        (indirect, 'collection "sources": Indirect Only'),
        (ashikhmin, 'material "grained": facets of Ashikhmin and Shirley'),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_what_is_not_rendered_is_named(tmp_path: Path, change: Callable[[Any], None], text: str) -> None:
    """Settings without a counterpart have a sentence of their own, and the same scene without them has none."""
    scene = base()
    assert exported(tmp_path).report.warnings == []
    change(scene)
    warnings = exported(tmp_path).report.warnings
    assert len(warnings) == 1 and warnings[0].startswith(text), warnings


def test_displaced_materials_differ_between_scales_only(tmp_path: Path) -> None:
    """Displacement is scaled with the object, so objects of one scale share a material."""
    scene = displaced()
    square = scene.objects["square 0"]
    for at, scale in enumerate((1.5, 1.5, 2.0)):
        other = square.copy()
        other.location, other.scale = (0, 3 + at, 0), (scale, scale, scale)
        scene.collection.objects.link(other)
    root = export.xml.ElementTree.parse(exported(tmp_path).scene_file).getroot()
    names = {name for each in root.iter("bsdf") if (name := each.get("id", "")).startswith("0#")}
    assert len(names) == 2, names


def test_missing_images_are_noted(tmp_path: Path) -> None:
    """A missing image looks as in Cycles, so it is no warning."""
    scene = base()
    assert exported(tmp_path).report.notes == []
    lost_world(scene)
    report = exported(tmp_path).report
    assert report.warnings == []
    assert report.notes == ['world "world": the image "gone" cannot be loaded; it is magenta, as in Cycles']


@pytest.mark.parametrize(
    "kind,settings,has_warning",
    [
        ("POINT", dict(shadow_soft_size=0.0), False),
        ("SPOT", dict(shadow_soft_size=0.0), False),
        ("SUN", dict(angle=0.0), False),
        # The sun is a disk of the environment, unless it stands in the picture.
        ("SUN", dict(angle=0.01), False),
        ("SUN", dict(angle=0.01, rotation=(-1.75, 0.0, 0.0)), True),
        ("SPOT", dict(shadow_soft_size=0.2, use_soft_falloff=False), True),
    ],
)
def test_lamps_behind_glass(tmp_path: Path, kind: str, settings: Any, has_warning: bool) -> None:
    """Neither Cycles nor Lodestar finds a lamp without size through glass; Cycles finds one with a size."""
    scene = base()
    scene.objects["ball"].data.materials[0] = scenes.simple("glass", "ShaderNodeBsdfGlass", Roughness=0.0)
    lamp(scene, kind, 10.0, **settings)
    assert any("does not pass glass" in warning for warning in exported(tmp_path).report.warnings) == has_warning


@pytest.mark.parametrize(
    "height,settings,text",
    [
        (1.0, dict(), "soft falloff without Multiple Importance is not supported; the nearest surface, 2.0 radii away, gets 25 % more light than in Cycles"),
        (0.2, dict(), "soft falloff without Multiple Importance is not supported; surfaces within its radius get other light than in Cycles"),
        (2.1, dict(), None),
        (1.0, dict(use_soft_falloff=False), None),
    ],
)
def test_soft_falloff_is_named_where_it_shows(tmp_path: Path, height: float, settings: Any, text: str | None) -> None:
    """Points stand for a lamp without Multiple Importance. The distance of the nearest surface decides, and no corner of the ground is near."""
    scene = scenes.empty()
    scenes.camera(scene)
    scenes.plane(scene, "ground", 8, scenes.diffuse("gray", (0.5, 0.5, 0.5)), location=(1, 1, 0), scale=(2, 2, 2))
    light = lamp(scene, "POINT", 10, (0, 0, height), shadow_soft_size=0.5, **settings).data
    assert exported(tmp_path).report.warnings == []
    light.cycles.use_multiple_importance_sampling = False
    light.update_tag()
    # Where nothing is a mirror, a disk stands for the lamp.
    assert exported(tmp_path).report.warnings == []
    mirror = scenes.simple("mirror", "ShaderNodeBsdfGlossy", Roughness=0.0)
    scenes.plane(scene, "mirror", 0.1, mirror, location=(5, 5, 0))
    expected = [f'light "lamp": {text}'] if text is not None else []
    assert exported(tmp_path).report.warnings == expected
    # The highlights of a smooth metal are as sharp.
    metal = scenes.simple("metal", "ShaderNodeBsdfPrincipled", Metallic=1.0, Roughness=0.0)
    scene.objects["mirror"].data.materials[0] = metal
    assert exported(tmp_path).report.warnings == expected


def test_soft_falloff_has_the_figure_of_its_warning() -> None:
    """Below a lamp, at twice its radius, a soft lamp has 1 / 1.25 of a ball's light, and points stand for the ball roughly."""
    scene = scenes.empty()
    scene.render.resolution_percentage = 25
    scenes.camera(scene, (0, 0, 2.5), (0, 0, 0), lens=400)
    scenes.plane(scene, "ground", 8, scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    radius = 0.5
    light = lamp(scene, "POINT", 10, (0, 0, 1), shadow_soft_size=radius).data
    ours, theirs = (support.colors(support.render(scene, engine, 256)) for engine in ("LODESTAR", "CYCLES"))
    light.cycles.use_multiple_importance_sampling = False
    light.update_tag()
    scenes.plane(scene, "mirror", 0.1, scenes.simple("mirror", "ShaderNodeBsdfGlossy", Roughness=0.0), location=(3.9, 3.9, 0.01))
    points = support.colors(support.render(scene, "LODESTAR", 256))
    # Irradiance of the points, over that of one point in the middle.
    places = [(radius * x, radius * y, 1.0 + radius * z) for x, y, z in units.ball_points(lights.BALL_PARTS)]
    of_points = sum(z / (x * x + y * y + z * z) ** 1.5 for x, y, z in places) / len(places)
    assert abs(of_points - 1.0) < 0.03
    assert abs(support.mean_ratio(ours, theirs) - 1.0) < 0.01
    assert abs(support.mean_ratio(points, theirs) / (1.25 * of_points) - 1.0) < 0.01


def matrices(found: export.Export) -> list[list[float]]:
    root = export.xml.ElementTree.parse(found.scene_file).getroot()
    return [[float(value) for value in matrix.get("value").split()] for matrix in root.iter("matrix")]


def test_rounded_matrices_end_in_1(tmp_path: Path) -> None:
    """Parents of parents round the last entry of an object's matrix."""
    scene = base()
    rounded = Matrix.Identity(4)
    rounded[3][3] = 0.99999994
    ball = scene.objects["ball"]
    ball.parent = scenes.add(scene, "parent", None)
    ball.matrix_parent_inverse = rounded
    assert bpy.context.evaluated_depsgraph_get().id_eval_get(ball).matrix_world[3][3] != 1.0
    assert all(matrix[12:] == [0.0, 0.0, 0.0, 1.0] for matrix in matrices(exported(tmp_path)))


def test_nodes_of_eevee_are_notes(tmp_path: Path) -> None:
    """What Cycles does not know either is no warning."""
    nodes_of_eevee()
    report = exported(tmp_path).report
    assert not report.warnings and sum("as in Cycles" in note for note in report.notes) == 4


def test_glass_beside_a_color_attribute(tmp_path: Path) -> None:
    """No program of glass stands beside a color attribute, which would lose its colors."""
    scene = base()

    def build(tree: Any) -> Any:
        attribute = scenes.shader(tree, "ShaderNodeBsdfDiffuse", Color=tree.nodes.new("ShaderNodeVertexColor").outputs[0])
        return scenes.mixed(tree, attribute, scenes.shader(tree, "ShaderNodeBsdfGlass", Roughness=0.0))

    scene.objects["ball"].data.materials[0] = scenes.material("both", build)
    found = exported(tmp_path)
    assert not any("color attribute beside" in warning for warning in found.report.warnings)
    assert "mesh_attribute" in found.scene_file.read_text()


@pytest.mark.parametrize("kind,has_warning", [("ShaderNodeVolumeAbsorption", False), ("ShaderNodeVolumePrincipled", True)])
def test_smoke_is_reported_where_a_volume_may_ask_for_it(tmp_path: Path, kind: str, has_warning: bool) -> None:
    """The absorption of a fluid domain is the same everywhere, unless its density is a grid."""
    scene = base()
    ball = scene.objects["ball"]
    tree = ball.data.materials[0].node_tree
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    tree.links.new(tree.nodes.new(kind).outputs[0], output.inputs["Volume"])
    modifier = ball.modifiers.new("smoke", "FLUID")
    modifier.fluid_type, modifier.show_render, modifier.show_viewport = "DOMAIN", False, False
    found = exported(tmp_path)
    assert any("smoke" in warning for warning in found.report.warnings) == has_warning
    assert ("<medium" in found.scene_file.read_text()) != has_warning


def test_cameras_of_no_size_are_refused(tmp_path: Path) -> None:
    """The sentence names the camera."""
    base().camera.scale = (0.0, 0.0, 0.0)
    with pytest.raises(camera.Unsupported, match='camera "camera": its scale is 0'):
        exported(tmp_path)


def test_sheared_cameras_are_upright(tmp_path: Path) -> None:
    """A parent that is scaled unevenly shears its camera; the export does not, and says so."""
    scene = base()
    parent = scenes.add(scene, "parent", None, scale=(1, 2, 1))
    scene.camera.parent = parent
    found = exported(tmp_path)
    assert any("shear" in warning for warning in found.report.warnings)
    rows = np.array(matrices(found)[0]).reshape(4, 4)[:3, :3]
    assert np.abs(rows.T @ rows - np.eye(3)).max() < 1e-5
