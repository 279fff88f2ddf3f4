"""Scenes with hair, which Cycles and Lodestar both render."""

from __future__ import annotations

from typing import Any, Optional

import bpy
import numpy as np
import scenes


def lit(shape: str = "THICK") -> Any:
    """A scene with a lamp and a world, whose hair has a shape of Cycles."""
    scene = scenes.empty()
    scene.cycles_curves.shape = shape
    scenes.camera(scene, (0, -5, 3), (0, 0, 0.3), lens=55)
    scenes.world(scene, (0.4, 0.5, 0.7))
    scenes.lamp(scene, "AREA", (1.5, -1.5, 3), (0.5, 0.4, 0), energy=150, size=1.0)
    return scene


def furry(placed: Any, count: int, length: float, seed: int = 0, **settings: Any) -> Any:
    """Gives an object strands, and returns their settings. The radius is 0.04 at the root."""
    placed.modifiers.new("hair", "PARTICLE_SYSTEM")
    placed.particle_systems[-1].seed = seed
    made = placed.particle_systems[-1].settings
    made.type, made.count, made.hair_length, made.radius_scale = "HAIR", count, length, 0.08
    for name, value in settings.items():
        setattr(made, name, value)
    return made


def curves(scene: Any, name: str, strands: list[np.ndarray], radii: Optional[list[np.ndarray]], surface: Any, kind: str = "", **place: Any) -> Any:
    """Hair curves through points."""
    data = bpy.data.hair_curves.new(name)
    data.add_curves([len(strand) for strand in strands])
    data.position_data.foreach_set("vector", np.concatenate(strands).astype(np.float32).ravel())
    if radii is not None:
        data.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", np.concatenate(radii).astype(np.float32))
    if kind:
        data.set_types(type=kind)
    data.materials.append(surface)
    return scenes.add(scene, name, data, **place)


def bent(count: int, points: int = 6) -> list[np.ndarray]:
    """Strands that are bent, one beside the other."""
    z = np.linspace(0.0, 1.4, points)
    return [np.stack([x + 0.25 * np.sin(3.0 * z + x), 0.3 * np.cos(4.0 * z), z], axis=1) for x in np.linspace(-1.2, 1.2, count)]


def particles() -> Any:
    """Strands of two materials, thick ones without children and thin ones with children that curl."""
    scene = lit()
    plastic = scenes.simple("plastic", "ShaderNodeBsdfPrincipled", Base_Color=(0.2, 0.5, 0.3), Roughness=0.4)
    ground = scenes.plane(scene, "ground", 3.0, scenes.diffuse("sand", (0.6, 0.4, 0.2)))
    ground.data.materials.append(plastic)
    furry(ground, 60, 0.8, tip_radius=0.3, use_close_tip=False, material=2)
    furry(ground, 60, 0.4, child_type="INTERPOLATED", rendered_child_count=10, kink="CURL", kink_amplitude=0.1)
    return scene


def shapes_of_radii() -> Any:
    """Strands without their emitter, which is scaled unevenly: thick at the root, and at the tip."""
    scene = lit()
    scenes.plane(scene, "floor", 6.0, scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    ground = scenes.plane(scene, "ground", 3.0, scenes.diffuse("sand", (0.6, 0.4, 0.2)), scale=(1.0, 0.7, 0.9), location=(0, 0, 0.1))
    ground.show_instancer_for_render = False
    furry(ground, 40, 0.8, shape=0.6)
    furry(ground, 40, 0.6, shape=-0.5, root_radius=0.2, tip_radius=1.0, use_close_tip=False, seed=3)
    return scene


def hair_curves() -> Any:
    """Hair curves that are bent, with radii and without."""
    scene = lit()
    scenes.plane(scene, "floor", 6.0, scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    strands = bent(5)
    radii = [np.linspace(0.15, 0.05, len(strand)) for strand in strands]
    curves(scene, "thick", strands, radii, scenes.diffuse("sand", (0.6, 0.4, 0.2)))
    curves(scene, "thin", bent(60), None, scenes.diffuse("red", (0.7, 0.1, 0.1)), location=(0, -0.5, 0))
    return scene


def polylines() -> Any:
    """Hair curves that go straight from point to point."""
    scene = lit()
    scenes.plane(scene, "floor", 6.0, scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    strands = bent(5, 5)
    radii = [np.linspace(0.15, 0.05, len(strand)) for strand in strands]
    curves(scene, "straight", strands, radii, scenes.diffuse("sand", (0.6, 0.4, 0.2)), "POLY")
    return scene


def textured() -> Any:
    """Strands that have the colors of an image at their roots."""
    scene = lit()
    colors = np.zeros((4, 4, 3))
    colors[:, :, 0], colors[:, :, 1] = np.arange(4)[None, :] / 3.0, np.arange(4)[:, None] / 3.0
    surface = scenes.material("image", lambda tree: scenes.shader(tree, "ShaderNodeBsdfDiffuse", Color=_image(tree, colors)).outputs[0])
    ground = scenes.plane(scene, "ground", 3.0, surface)
    furry(ground, 150, 0.5, child_type="SIMPLE", rendered_child_count=8)
    return scene


def _image(tree: Any, colors: np.ndarray) -> Any:
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image, node.interpolation = scenes.image("colors", colors, "Non-Color"), "Closest"
    return node.outputs["Color"]


def info() -> Any:
    """Strands whose color follows the place along them, a number by chance, the image at their roots, and the roots' place."""
    scene = lit()

    def mixed(tree: Any) -> Any:
        node = tree.nodes.new("ShaderNodeHairInfo")
        colors = np.ones((2, 2, 3)) * np.array([[0.9, 0.2], [0.2, 0.9]])[:, :, None]
        color = tree.nodes.new("ShaderNodeCombineColor")
        for value, socket in zip((node.outputs["Intercept"], node.outputs["Random"], _image(tree, colors)), color.inputs):
            tree.links.new(value, socket)
        return scenes.shader(tree, "ShaderNodeBsdfDiffuse", Color=color.outputs[0]).outputs[0]

    def placed(tree: Any) -> Any:
        node = tree.nodes.new("ShaderNodeTexCoord")
        return scenes.shader(tree, "ShaderNodeBsdfDiffuse", Color=node.outputs["Generated"]).outputs[0]

    ground = scenes.plane(scene, "ground", 3.0, scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    ground.data.materials.append(scenes.material("mixed", mixed))
    ground.data.materials.append(scenes.material("placed", placed))
    furry(ground, 60, 0.9, material=2, tip_radius=0.5)
    furry(ground, 200, 0.4, material=3, seed=2)
    return scene


def attributes() -> Any:
    """Strands with colors of the emitter's corners at their roots, and hair curves with colors and texture coordinates of their own."""
    scene = lit()
    scenes.plane(scene, "floor", 6.0, scenes.diffuse("gray", (0.5, 0.5, 0.5)))

    def by_name(kind: str, name: str) -> Any:
        def build(tree: Any) -> Any:
            node = tree.nodes.new(kind)
            setattr(node, "layer_name" if kind == "ShaderNodeVertexColor" else "attribute_name", name)
            return scenes.shader(tree, "ShaderNodeBsdfDiffuse", Color=node.outputs["Color"]).outputs[0]

        return scenes.material(name, build)

    ground = scenes.plane(scene, "ground", 3.0, by_name("ShaderNodeVertexColor", "tint"), location=(0, 0, 0.05))
    tint = ground.data.color_attributes.new("tint", "BYTE_COLOR", "CORNER")
    for each, color in zip(tint.data, ((1, 0.1, 0.1), (0.1, 1, 0.1), (0.1, 0.1, 1), (0.5, 0.5, 0.5))):
        each.color = (*color, 1.0)
    furry(ground, 150, 0.4)
    own = curves(scene, "own", bent(40), None, by_name("ShaderNodeAttribute", "shade"), location=(0, -0.6, 0))
    shade = own.data.attributes.new("shade", "FLOAT_COLOR", "CURVE")
    for each, at in zip(shade.data, np.linspace(0.0, 1.0, 40)):
        each.color = (at, 0.5, 1.0 - at, 1.0)
    colors = np.repeat(np.linspace(0.1, 0.9, 8)[None, :, None], 3, axis=2) * np.array([1.0, 0.5, 0.2])
    mapped = scenes.material("mapped", lambda tree: scenes.shader(tree, "ShaderNodeBsdfDiffuse", Color=_image(tree, colors)).outputs[0])
    uv = curves(scene, "mapped", bent(40), None, mapped, location=(0, 0.6, 0)).data.attributes.new("surface_uv", "FLOAT2", "CURVE")
    uv.data.foreach_set("vector", np.column_stack([np.linspace(0.03, 0.97, 40), np.full(40, 0.5)]).astype(np.float32).ravel())
    return scene


def instances() -> Any:
    """A furry ball that is shown in three places, mirrored and scaled, and hair curves on points."""
    scene = lit()
    scenes.plane(scene, "floor", 6.0, scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    collection = bpy.data.collections.new("kept")
    ball = scenes.ball(scene, "ball", 0.3, scenes.diffuse("sand", (0.6, 0.4, 0.2)))
    furry(ball, 100, 0.25)
    for each in (ball, curves(scene, "curves", bent(12), None, scenes.diffuse("red", (0.7, 0.1, 0.1)), scale=(0.5, 0.5, 0.5))):
        scene.collection.objects.unlink(each)
        collection.objects.link(each)
    for at, scale in ((-1.2, (1, 1, 1)), (0.0, (-0.7, 0.7, 0.7)), (1.2, (1.2, 1.2, 1.2))):
        placed = scenes.add(scene, f"instance {at}", None, (at, 0, 0.4), (0, 0, at), scale)
        placed.instance_type, placed.instance_collection = "COLLECTION", collection
    return scene


def principled_hair(name: str, parametrization: str, **inputs: Any) -> Any:
    """Material of Principled Hair; underscores stand for spaces."""

    def build(tree: Any) -> Any:
        node = tree.nodes.new("ShaderNodeBsdfHairPrincipled")
        if hasattr(node, "model"):
            node.model = "CHIANG"
        node.parametrization = parametrization
        for each, value in inputs.items():
            socket = node.inputs[each.replace("_", " ")]
            socket.default_value = (*value, 1.0) if socket.type == "RGBA" else value
        return node.outputs[0]

    return scenes.material(name, build)


def fibers(parametrization: str, **inputs: Any) -> Any:
    """Bent strands of Principled Hair."""
    scene = lit()
    scenes.plane(scene, "floor", 6.0, scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    strands = bent(14)
    radii = [np.linspace(0.05, 0.03, len(strand)) for strand in strands]
    curves(scene, "fibers", strands, radii, principled_hair("fiber", parametrization, **inputs))
    return scene


ALL = {each.__name__: each for each in (particles, shapes_of_radii, hair_curves, polylines, textured, info, attributes, instances)}
