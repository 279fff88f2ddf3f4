"""Scenes made in code, which Cycles and Lodestar both render."""

from __future__ import annotations

import math
from typing import Any

import bpy
import numpy as np

SIZE = 64


def empty() -> Any:
    """A scene with nothing in it."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    render = scene.render
    render.resolution_x = render.resolution_y = SIZE
    render.resolution_percentage = 100
    if hasattr(render.image_settings, "media_type"):
        render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    if hasattr(render.image_settings, "use_exr_interleave"):
        render.image_settings.use_exr_interleave = True
    render.image_settings.color_depth = "32"
    return scene


def add(scene: Any, name: str, data: Any, location: Any = (0, 0, 0), rotation: Any = (0, 0, 0), scale: Any = (1, 1, 1)) -> Any:
    """Object in the scene."""
    added = bpy.data.objects.new(name, data)
    added.location, added.rotation_euler, added.scale = location, rotation, scale
    scene.collection.objects.link(added)
    return added


def camera(scene: Any, location: Any = (0, -6, 2.5), target: Any = (0, 0, 0.6), **settings: Any) -> Any:
    """Camera that looks at a point."""
    from mathutils import Vector

    data = bpy.data.cameras.new("camera")
    for name, value in settings.items():
        setattr(data, name, value)
    placed = add(scene, "camera", data, location)
    placed.rotation_euler = (Vector(target) - Vector(location)).to_track_quat("-Z", "Y").to_euler()
    scene.camera = placed
    return placed


def material(name: str, build: Any) -> Any:
    """Material of which `build(tree)` returns the shader's socket."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(build(tree), output.inputs["Surface"])
    return made


def shader(tree: Any, kind: str, **inputs: Any) -> Any:
    """Shader node with values of its sockets; underscores stand for spaces."""
    node = tree.nodes.new(kind)
    for name, value in inputs.items():
        socket = node.inputs[name.replace("_", " ")]
        if isinstance(value, bpy.types.NodeSocket):
            tree.links.new(value, socket)
        else:
            socket.default_value = (*value, 1.0) if socket.type == "RGBA" and len(value) == 3 else value
    if hasattr(node, "distribution") and kind not in ("ShaderNodeBsdfHair", "ShaderNodeBsdfSheen"):
        # Cycles' default adds light that single reflections lose. Lodestar does not.
        node.distribution = "GGX"
    return node


def mixed(tree: Any, first: Any, second: Any) -> Any:
    """Socket of a mixture of two shader nodes in equal parts."""
    node = tree.nodes.new("ShaderNodeMixShader")
    for part, socket in zip((first, second), node.inputs[1:]):
        tree.links.new(part.outputs[0], socket)
    return node.outputs[0]


def simple(name: str, kind: str, **inputs: Any) -> Any:
    """Material of one shader node."""
    return material(name, lambda tree: shader(tree, kind, **inputs).outputs[0])


def diffuse(name: str, color: Any) -> Any:
    return simple(name, "ShaderNodeBsdfDiffuse", Color=color)


def plane(scene: Any, name: str, size: float, surface: Any, **place: Any) -> Any:
    """Square with UVs."""
    mesh = bpy.data.meshes.new(name)
    s = 0.5 * size
    mesh.from_pydata([(-s, -s, 0), (s, -s, 0), (s, s, 0), (-s, s, 0)], [], [(0, 1, 2, 3)])
    layer = mesh.uv_layers.new(name="UVMap")
    for at, uv in enumerate([(0, 0), (1, 0), (1, 1), (0, 1)]):
        layer.data[at].uv = uv
    mesh.materials.append(surface)
    return add(scene, name, mesh, **place)


def ball(scene: Any, name: str, radius: float, surface: Any, smooth: bool = True, **place: Any) -> Any:
    """Sphere of quads with UVs."""
    import bmesh

    mesh, work = bpy.data.meshes.new(name), bmesh.new()
    bmesh.ops.create_uvsphere(work, u_segments=48, v_segments=24, radius=radius, calc_uvs=True)
    work.loops.layers.uv.verify()
    work.to_mesh(mesh)
    work.free()
    if smooth:
        mesh.shade_smooth()
    mesh.materials.append(surface)
    return add(scene, name, mesh, **place)


def image(name: str, colors: np.ndarray, space: str = "sRGB", is_float: bool = False) -> Any:
    """Generated image from rows, the first at the bottom."""
    height, width = colors.shape[:2]
    made = bpy.data.images.new(name, width, height, float_buffer=is_float, alpha=False)
    made.colorspace_settings.name = space
    whole = np.ones((height, width, 4), np.float32)
    whole[:, :, :3] = colors
    made.pixels.foreach_set(whole.ravel())
    made.update()
    return made


def lamp(scene: Any, kind: str, location: Any = (0, 0, 3), rotation: Any = (0, 0, 0), **settings: Any) -> Any:
    """Lamp."""
    data = bpy.data.lights.new(kind.lower(), kind)
    if kind == "POINT":
        data.use_soft_falloff = False
    for name, value in settings.items():
        setattr(data, name, value)
    return add(scene, kind.lower(), data, location, rotation)


def world(scene: Any, color: Any = None, environment: Any = None, rotation: Any = (0, 0, 0), strength: float = 1.0) -> None:
    """World of a color or of an image."""
    made = bpy.data.worlds.new("world")
    scene.world = made
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    background, output = tree.nodes.new("ShaderNodeBackground"), tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    background.inputs["Strength"].default_value = strength
    if color is not None:
        background.inputs["Color"].default_value = (*color, 1.0)
    if environment is not None:
        texture, mapping = tree.nodes.new("ShaderNodeTexEnvironment"), tree.nodes.new("ShaderNodeMapping")
        coordinates = tree.nodes.new("ShaderNodeTexCoord")
        texture.image = environment
        mapping.inputs["Rotation"].default_value = rotation
        tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
        tree.links.new(mapping.outputs[0], texture.inputs["Vector"])
        tree.links.new(texture.outputs["Color"], background.inputs["Color"])


# ------------------------------------------------------------------------------------------------------- the six


def lamps() -> Any:
    """Lamps of every kind over a gray ground with a ball."""
    scene = empty()
    camera(scene, (0, -7, 4), (0, 0, 0), shift_x=0.1, shift_y=-0.05)
    plane(scene, "ground", 12, diffuse("gray", (0.6, 0.6, 0.6)))
    ball(scene, "ball", 0.7, diffuse("red", (0.7, 0.2, 0.1)), location=(0, 0, 0.8))
    lamp(scene, "POINT", (-2.5, -1, 2), energy=60, shadow_soft_size=0.15, color=(1.0, 0.8, 0.6))
    lamp(scene, "POINT", (2.5, 2, 1.5), energy=20, shadow_soft_size=0.0)
    lamp(scene, "SPOT", (2.5, -1, 3), (0, 0.4, 0), energy=150, spot_size=0.9, spot_blend=0.4, shadow_soft_size=0.0)
    lamp(scene, "AREA", (-1, 2, 3), (0.3, 0, 0), energy=50, shape="RECTANGLE", size=1.0, size_y=0.4, color=(0.6, 0.7, 1.0))
    lamp(scene, "AREA", (1, -3, 3), (-0.4, 0.1, 0), energy=40, shape="ELLIPSE", size=0.8, size_y=0.5)
    lamp(scene, "SUN", (0, 0, 5), (0.5, 0.3, 0), energy=0.4, angle=0.1)
    return scene


def textures() -> Any:
    """Image textures with mapped UVs, a color attribute, and mixed shaders, in a constant world."""
    scene = empty()
    camera(scene, (0, -5, 4), (0, 0, 0))
    world(scene, (0.9, 1.0, 1.1))
    rng = np.random.default_rng(1)
    picture = image("picture", rng.uniform(0.1, 0.9, (8, 16, 3)))

    def mapped(tree: Any) -> Any:
        texture, mapping = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeMapping")
        uv = tree.nodes.new("ShaderNodeUVMap")
        texture.image, texture.interpolation = picture, "Closest"
        mapping.inputs["Location"].default_value = (0.1, 0.2, 0)
        mapping.inputs["Rotation"].default_value = (0, 0, 0.3)
        mapping.inputs["Scale"].default_value = (1.5, 0.7, 1)
        tree.links.new(uv.outputs[0], mapping.inputs["Vector"])
        tree.links.new(mapping.outputs[0], texture.inputs["Vector"])
        return shader(tree, "ShaderNodeBsdfDiffuse", Color=texture.outputs["Color"]).outputs[0]

    plane(scene, "ground", 5, material("mapped", mapped))

    def colored(tree: Any) -> Any:
        attribute = tree.nodes.new("ShaderNodeVertexColor")
        attribute.layer_name = "Col"
        return shader(tree, "ShaderNodeBsdfDiffuse", Color=attribute.outputs["Color"]).outputs[0]

    painted = ball(scene, "painted", 0.7, material("painted", colored), location=(-1, 0, 0.9))
    colors = painted.data.color_attributes.new("Col", "FLOAT_COLOR", "POINT")
    for at, vertex in enumerate(painted.data.vertices):
        colors.data[at].color = (0.5 + 0.4 * vertex.co.x, 0.5 - 0.4 * vertex.co.z, 0.3, 1.0)

    def mixed(tree: Any) -> Any:
        mix = tree.nodes.new("ShaderNodeMixShader")
        mix.inputs[0].default_value = 0.4
        first = shader(tree, "ShaderNodeBsdfDiffuse", Color=(0.1, 0.6, 0.2))
        second = shader(tree, "ShaderNodeBsdfTransparent", Color=(0.9, 0.5, 0.5))
        tree.links.new(first.outputs[0], mix.inputs[1])
        tree.links.new(second.outputs[0], mix.inputs[2])
        return mix.outputs[0]

    ball(scene, "mixed", 0.7, material("mixed", mixed), location=(1, 0, 0.9))
    return scene


def environment() -> Any:
    """A turned image of the environment, seen by a camera whose sensor fits its height."""
    scene = empty()
    camera(scene, (0, -5, 1), (0, 0, 0.6), sensor_fit="VERTICAL", sensor_height=24, lens=20)
    scene.render.resolution_x = SIZE * 3 // 2
    v, u = np.mgrid[0:32, 0:64]
    colors = np.stack([0.2 + u / 64, 0.5 + 0.5 * np.sin(v / 5), 0.3 + ((u // 8) % 2)], axis=-1)
    world(scene, environment=image("sky", colors, "Linear Rec.709", True), rotation=(0.2, 0.1, 0.7), strength=0.8)
    ball(scene, "ball", 1.0, diffuse("white", (0.8, 0.8, 0.8)), location=(0, 0, 0.6))
    ball(scene, "mirror", 0.5, simple("mirror", "ShaderNodeBsdfAnisotropic", Color=(0.9, 0.9, 0.9), Roughness=0.3), location=(1.5, -0.5, 0.6))
    return scene


def glass() -> Any:
    """Glass, metal and a Principled surface of each kind in a constant world, over an emitting plane."""
    scene = empty()
    camera(scene, (0, -7, 3.0), (0, 0, 0.5))
    world(scene, (0.7, 0.8, 1.0))
    plane(scene, "ground", 9, diffuse("gray", (0.5, 0.5, 0.5)))
    plane(scene, "lamp", 1.0, simple("lamp", "ShaderNodeEmission", Color=(1.0, 0.7, 0.4), Strength=6.0), location=(0, 2, 2), rotation=(0.9, 0, 0))
    ball(scene, "glass", 0.6, simple("glass", "ShaderNodeBsdfGlass", Color=(0.9, 1.0, 0.9), Roughness=0.3, IOR=1.45), location=(-2, 0, 0.7))
    ball(scene, "metal", 0.6, simple("metal", "ShaderNodeBsdfPrincipled", Base_Color=(0.9, 0.6, 0.3), Metallic=1.0, Roughness=0.3), location=(-0.7, 0, 0.7))
    ball(scene, "plastic", 0.6, simple("plastic", "ShaderNodeBsdfPrincipled", Base_Color=(0.2, 0.3, 0.7), Roughness=0.4), location=(0.7, 0, 0.7))
    ball(scene, "masked", 0.6, simple("masked", "ShaderNodeBsdfPrincipled", Base_Color=(0.7, 0.2, 0.2), Roughness=0.6, Alpha=0.5), location=(2, 0, 0.7))
    return scene


def instances() -> Any:
    """Instances of a collection, a modifier, a curve and two material slots under an orthographic camera with a border."""
    scene = empty()
    camera(scene, (4, -6, 5), (0, 0, 0.3), type="ORTHO", ortho_scale=6.0)
    world(scene, (1, 1, 1))
    plane(scene, "ground", 9, diffuse("gray", (0.5, 0.5, 0.5)))
    kept = bpy.data.collections.new("kept")
    mesh = bpy.data.meshes.new("cube")
    corners = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    mesh.from_pydata(corners, [], [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)])
    for color in ((0.8, 0.1, 0.1), (0.1, 0.2, 0.8)):
        mesh.materials.append(diffuse(str(color), color))
    mesh.polygons[1].material_index = 1
    cube = bpy.data.objects.new("cube", mesh)
    kept.objects.link(cube)
    for at, place in enumerate([(-2, 0, 0), (0, 0, 0), (1.5, 0.5, 0)]):
        copied = add(scene, f"copy {at}", None, place, (0, 0, 0.4 * at), (1, 1, 0.5 + 0.4 * at))
        copied.instance_type, copied.instance_collection = "COLLECTION", kept
    array = ball(scene, "row", 0.3, diffuse("green", (0.1, 0.6, 0.2)), location=(-2, -1.5, 0.3))
    modifier = array.modifiers.new("array", "ARRAY")
    modifier.count = 4
    curve = bpy.data.curves.new("letter", "FONT")
    curve.body, curve.extrude = "L", 0.1
    curve.materials.append(diffuse("yellow", (0.8, 0.7, 0.1)))
    add(scene, "letter", curve, (0.5, -2.5, 0.1))
    scene.render.use_border, scene.render.use_crop_to_border = True, True
    scene.render.border_min_x, scene.render.border_max_x = 0.125, 1.0
    scene.render.border_min_y, scene.render.border_max_y = 0.0, 0.75
    return scene


def relief() -> Any:
    """Bump and normal maps, and depth of field."""
    scene = empty()
    placed = camera(scene, (0, -5, 3), (0, 0, 0), lens=40)
    placed.data.dof.use_dof, placed.data.dof.aperture_fstop, placed.data.dof.focus_distance = True, 0.2, 5.0
    v, u = np.mgrid[0:64, 0:64] / 64.0 * 2.0 * math.pi
    heights = np.repeat((0.5 + 0.5 * np.sin(3 * u))[:, :, None], 3, axis=2)
    slope = np.stack([np.cos(2 * u) * 0.5, np.cos(4 * v) * 0.3, np.ones_like(u)], axis=-1)
    slope /= np.linalg.norm(slope, axis=2, keepdims=True)
    maps = {"bump": image("heights", heights, "Non-Color", True), "normal": image("normals", slope * 0.5 + 0.5, "Non-Color", True)}

    def with_relief(kind: str) -> Any:
        def build(tree: Any) -> Any:
            texture = tree.nodes.new("ShaderNodeTexImage")
            texture.image = maps[kind]
            if kind == "bump":
                node = tree.nodes.new("ShaderNodeBump")
                node.inputs["Distance"].default_value = 0.1
                tree.links.new(texture.outputs["Color"], node.inputs["Height"])
            else:
                node = tree.nodes.new("ShaderNodeNormalMap")
                node.inputs["Strength"].default_value = 0.8
                tree.links.new(texture.outputs["Color"], node.inputs["Color"])
            return shader(tree, "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8), Normal=node.outputs["Normal"]).outputs[0]

        return build

    plane(scene, "bump", 3, material("bump", with_relief("bump")), location=(-1.6, 0, 0))
    plane(scene, "normal", 3, material("normal", with_relief("normal")), location=(1.6, 0, 0))
    lamp(scene, "AREA", (-4, 1, 3), (0, -0.9, 0), energy=300, size=0.5)
    return scene


def relief_from_above() -> Any:
    """The same under a high lamp, with pixels of a quarter's width and without Cycles' Bump Map Correction.

    So every version renders it alike. Before 4.5, the correction also darkens slopes that the lamp lights well. Before 4.4, the slope
    of a bump map is taken over a whole pixel.
    """
    scene = relief()
    scene.render.resolution_percentage = 400
    light = scene.objects["area"]
    light.location, light.rotation_euler = (0, 0, 6), (0, 0, 0)
    for each in bpy.data.materials:
        each.cycles.use_bump_map_correction = False
    return scene


def grouped_place(tree: Any) -> Any:
    """Gradient in a group, along the group's input without a link."""
    group = bpy.data.node_groups.new("group", "ShaderNodeTree")
    group.interface.new_socket("Place", in_out="INPUT", socket_type="NodeSocketVector")
    group.interface.new_socket("Shade", in_out="OUTPUT", socket_type="NodeSocketFloat")
    inner, outer = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    gradient = group.nodes.new("ShaderNodeTexGradient")
    group.links.new(inner.outputs["Place"], gradient.inputs["Vector"])
    group.links.new(gradient.outputs[1], outer.inputs[0])
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    node.inputs["Place"].default_value = (0.3, 0.1, 0.2)
    return shader(tree, "ShaderNodeBsdfDiffuse", Color=node.outputs[0]).outputs[0]


def computed() -> Any:
    """Textures that are computed, in colors, a weight and heights; coordinates and numbers of objects."""
    scene = empty()
    camera(scene, (0, -6, 4), (0, 0, 0.3))
    world(scene, (1, 1, 1))

    def node(tree: Any, kind: str, **settings: Any) -> Any:
        made = tree.nodes.new(f"ShaderNode{kind}")
        for name, value in settings.items():
            if name in made.inputs:
                made.inputs[name].default_value = value
            else:
                setattr(made, name, value)
        return made

    def ground(tree: Any) -> Any:
        noise, ramp = node(tree, "TexNoise", Scale=3.0, Detail=3.0), node(tree, "ValToRGB")
        ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[0].color = 0.35, (0.05, 0.2, 0.6, 1)
        ramp.color_ramp.elements[1].position, ramp.color_ramp.elements[1].color = 0.65, (0.9, 0.7, 0.3, 1)
        tree.links.new(noise.outputs[0], ramp.inputs[0])
        return shader(tree, "ShaderNodeBsdfDiffuse", Color=ramp.outputs[0]).outputs[0]

    def tiles(tree: Any) -> Any:
        voronoi, checker = node(tree, "TexVoronoi", Scale=4.0), node(tree, "TexChecker", Scale=5.0)
        place = tree.nodes.new("ShaderNodeTexCoord")
        tree.links.new(place.outputs["Object"], voronoi.inputs["Vector"])
        tree.links.new(place.outputs["UV"], checker.inputs["Vector"])
        mixed = node(tree, "Mix", data_type="RGBA", blend_type="MULTIPLY")
        mixed.inputs["Factor"].default_value = 0.8
        a, b = (next(s for s in mixed.inputs if s.identifier == name) for name in ("A_Color", "B_Color"))
        tree.links.new(voronoi.outputs["Color"], a)
        tree.links.new(checker.outputs["Color"], b)
        result = next(s for s in mixed.outputs if s.identifier == "Result_Color")
        first = shader(tree, "ShaderNodeBsdfDiffuse", Color=result)
        second = shader(tree, "ShaderNodeBsdfDiffuse", Color=(0.9, 0.2, 0.1))
        wave, mix = node(tree, "TexWave", Scale=0.7), tree.nodes.new("ShaderNodeMixShader")
        tree.links.new(wave.outputs["Fac" if "Fac" in wave.outputs else "Factor"], mix.inputs[0])
        tree.links.new(first.outputs[0], mix.inputs[1])
        tree.links.new(second.outputs[0], mix.inputs[2])
        return mix.outputs[0]

    def numbered(tree: Any) -> Any:
        info, hsv = tree.nodes.new("ShaderNodeObjectInfo"), node(tree, "HueSaturation", Color=(0.8, 0.2, 0.2, 1))
        tree.links.new(info.outputs["Random"], hsv.inputs["Hue"])
        return shader(tree, "ShaderNodeBsdfDiffuse", Color=hsv.outputs[0]).outputs[0]

    def bumps(tree: Any) -> Any:
        """Two bump maps over each other."""
        fine, coarse = node(tree, "TexMagic", Scale=2.0), node(tree, "TexWave", Scale=0.6, wave_type="RINGS")
        below, above = node(tree, "Bump", Distance=0.03), node(tree, "Bump", Distance=0.05)
        tree.links.new(coarse.outputs[1], below.inputs["Height"])
        tree.links.new(fine.outputs[1], above.inputs["Height"])
        tree.links.new(below.outputs[0], above.inputs["Normal"])
        return shader(tree, "ShaderNodeBsdfDiffuse", Color=(0.7, 0.7, 0.7), Normal=above.outputs[0]).outputs[0]

    plane(scene, "ground", 3, material("ground", ground), location=(-1.6, 0, 0))
    plane(scene, "tiles", 3, material("tiles", tiles), location=(1.6, 0, 0), rotation=(0.2, 0.1, 0))
    numbers = material("numbers", numbered)
    for at in range(3):
        ball(scene, f"ball {at}", 0.3, numbers, location=(at - 1, -1.6, 0.3))
    plane(scene, "bumps", 2, material("bumps", bumps), location=(0, 2.2, 0.6), rotation=(1.0, 0, 0))
    lamp(scene, "SUN", rotation=(0.6, 0.3, 0), energy=2.0, angle=0.0)
    return scene


def sky(kind: str = "MULTIPLE_SCATTERING", rotation: float = 0.7) -> Any:
    """A plane and a ball under a sky with a large sun."""
    scene = empty()
    camera(scene)
    plane(scene, "ground", 9, diffuse("gray", (0.5, 0.5, 0.5)))
    ball(scene, "ball", 0.8, diffuse("red", (0.7, 0.3, 0.2)), location=(0.3, 0, 0.8))
    world(scene, (1, 1, 1), strength=0.2)
    tree = scene.world.node_tree
    texture, background = tree.nodes.new("ShaderNodeTexSky"), next(n for n in tree.nodes if n.type == "BACKGROUND")
    texture.sky_type, texture.sun_rotation, texture.sun_elevation, texture.sun_size = kind, rotation, 0.5, 0.2
    texture.air_density, texture.altitude = 1.3, 800.0
    tree.links.new(texture.outputs[0], background.inputs["Color"])
    return scene


def sky_of_one_scattering() -> Any:
    """Blender's older sky, which versions before 5 call Nishita."""
    return sky("SINGLE_SCATTERING" if bpy.app.version >= (5, 0, 0) else "NISHITA", -1.9)


ALL = {each.__name__: each for each in (lamps, textures, environment, glass, instances, relief, relief_from_above, computed, sky, sky_of_one_scattering)}
