"""What the export writes, and what it reports."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import bpy
import lodestar
import numpy as np
import pytest
import scenes
import support
from lodestar import camera, engine, export, images, panels, process, report


def exported(folder: Path) -> export.Export:
    return export.export(bpy.context.evaluated_depsgraph_get(), folder, export.Options())


def minimal(surface: Any) -> Any:
    scene = scenes.empty()
    scenes.camera(scene)
    scenes.plane(scene, "ground", 4, surface())
    scenes.world(scene, (1, 1, 1))
    return scene


def test_registration_twice() -> None:
    """The engine comes, goes and comes again, with its panels' engine names."""
    for _ in range(2):
        lodestar.unregister()
        assert not hasattr(bpy.types.Scene, "lodestar")
        lodestar.register()
        assert hasattr(bpy.types.Scene, "lodestar")
    missing = panels.BORROWED - {panel.__name__ for panel in panels._shared_panels()}
    assert not missing and all("LODESTAR" in panel.COMPAT_ENGINES for panel in panels._shared_panels())
    bpy.context.scene.render.engine = "LODESTAR"
    assert bpy.context.scene.render.engine == "LODESTAR"


def test_unchanged_meshes_are_not_written_again(tmp_path: Path) -> None:
    scene = minimal(lambda: scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    ball = scenes.ball(scene, "ball", 1, scenes.diffuse("red", (0.7, 0.1, 0.1)))
    assert exported(tmp_path).meshes_written == 2
    times = {path: path.stat().st_mtime_ns for path in tmp_path.glob("*.ply")}
    ball.location.x = 1.0
    assert exported(tmp_path).meshes_written == 0
    assert times == {path: path.stat().st_mtime_ns for path in tmp_path.glob("*.ply")}
    ball.data.vertices[0].co.z += 0.5
    ball.data.update()
    assert exported(tmp_path).meshes_written == 1
    assert len(list(tmp_path.glob("*.ply"))) == 2, "the mesh that was replaced is removed"


def test_faces_in_the_same_place_are_noted(tmp_path: Path) -> None:
    """A mesh with a copy of a face, of which the corners have another order, has a note, and no warning."""
    scene = minimal(lambda: scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    scenes.ball(scene, "ball", 1, scenes.diffuse("red", (0.7, 0.1, 0.1)))
    assert exported(tmp_path).report.notes == []
    mesh = bpy.data.meshes.new("twins")
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 1)]
    mesh.from_pydata([*corners[:3], *corners[:3], corners[3]], [], [(0, 1, 2), (4, 3, 5), (0, 1, 6)])
    scenes.add(scene, "twins", mesh)
    found = exported(tmp_path).report
    assert not found.warnings and len(found.notes) == 1
    assert found.notes[0].startswith('object "twins": 1 of its 3 triangles lie where others do')


def occlusion(tree: Any) -> Any:
    """A node that no program can say, below one that it can."""
    node, math = tree.nodes.new("ShaderNodeAmbientOcclusion"), tree.nodes.new("ShaderNodeMath")
    tree.links.new(node.outputs["AO"], math.inputs[0])
    return scenes.shader(tree, "ShaderNodeBsdfDiffuse", Color=math.outputs[0]).outputs[0]


def shared_noise(tree: Any) -> Any:
    """A noise that two sockets take, through other nodes."""
    texture, gamma = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeGamma")
    gamma.inputs["Gamma"].default_value = 2.0
    tree.links.new(texture.outputs[0], gamma.inputs["Color"])
    inputs = {"Base_Color": gamma.outputs[0], "Roughness": texture.outputs[0]}
    return scenes.shader(tree, "ShaderNodeBsdfPrincipled", **inputs).outputs[0]


def computed_emission(tree: Any) -> Any:
    """Light whose color is computed."""
    texture = tree.nodes.new("ShaderNodeTexNoise")
    return scenes.shader(tree, "ShaderNodeEmission", Color=texture.outputs["Color"]).outputs[0]


def pointiness(tree: Any) -> Any:
    """An output that is not translated, of a node of which others are."""
    geometry = tree.nodes.new("ShaderNodeNewGeometry")
    return scenes.shader(tree, "ShaderNodeBsdfDiffuse", Color=geometry.outputs["Pointiness"]).outputs[0]


def attribute_as_number(tree: Any) -> Any:
    """An attribute where a number is needed."""
    attribute = tree.nodes.new("ShaderNodeAttribute")
    attribute.attribute_name = "wear"
    return scenes.shader(tree, "ShaderNodeBsdfPrincipled", Roughness=attribute.outputs[2]).outputs[0]


def toon(tree: Any) -> Any:
    return scenes.shader(tree, "ShaderNodeBsdfToon").outputs[0]


def grouped(tree: Any) -> Any:
    """A Diffuse node in a group, with its color as the group's input."""
    group = bpy.data.node_groups.new("group", "ShaderNodeTree")
    group.interface.new_socket("Tint", in_out="INPUT", socket_type="NodeSocketColor")
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    inner, outer = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    diffuse = group.nodes.new("ShaderNodeBsdfDiffuse")
    group.links.new(inner.outputs["Tint"], diffuse.inputs["Color"])
    group.links.new(diffuse.outputs[0], outer.inputs[0])
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    node.inputs["Tint"].default_value = (0.25, 0.5, 0.75, 1)
    return node.outputs[0]


def wide_bump(tree: Any) -> Any:
    """A bump map whose slope is that over four pixels."""
    texture, bump = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeBump")
    texture.image = scenes.image("heights", scenes.np.full((4, 4, 3), 0.5))
    bump.inputs["Filter Width"].default_value = 4.0
    tree.links.new(texture.outputs["Color"], bump.inputs["Height"])
    return scenes.shader(tree, "ShaderNodeBsdfDiffuse", Normal=bump.outputs["Normal"]).outputs[0]


UNSUPPORTED = [
    (occlusion, '"Ambient Occlusion" (Ambient Occlusion)'),
    (pointiness, 'the output Pointiness of the node "Geometry"'),
    (attribute_as_number, 'the attribute "wear" as a number is not supported; Roughness'),
    (toon, "Toon BSDF"),
    (computed_emission, "a computed Color of emitted light"),
]
# Blender before 4.5 has no Filter Width.
if bpy.app.version >= (4, 5, 0):
    UNSUPPORTED.append((wide_bump, "Filter Width 4"))


@pytest.mark.parametrize("build,text", UNSUPPORTED)
def test_unsupported_nodes_are_named(tmp_path: Path, build: Any, text: str) -> None:
    minimal(lambda: scenes.material("strange", build))
    warnings = exported(tmp_path).report.warnings
    assert any('material "strange"' in warning and text in warning for warning in warnings), warnings


def test_supported_nodes_are_not_reported(tmp_path: Path) -> None:
    minimal(lambda: scenes.material("grouped", grouped))
    found = exported(tmp_path)
    assert found.report.warnings == []
    assert 'value="0.25 0.5 0.75"' in found.scene_file.read_text()


def test_parts_of_programs_are_written_once(tmp_path: Path) -> None:
    minimal(lambda: scenes.material("shared", shared_noise))
    found = exported(tmp_path)
    assert found.report.warnings == []
    assert found.scene_file.read_text().count('type="noise_3d"') == 1


def large_graph(tree: Any) -> Any:
    """A chain of 300 different noises."""
    value = None
    for at in range(300):
        noise, add = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeMath")
        noise.inputs["Scale"].default_value = 1.0 + at
        tree.links.new(noise.outputs[0], add.inputs[0])
        if value is not None:
            tree.links.new(value, add.inputs[1])
        value = add.outputs[0]
    return scenes.shader(tree, "ShaderNodeBsdfDiffuse", Color=value).outputs[0]


def graph_of_vectors(tree: Any) -> Any:
    """A chain of 65 noises whose W and Detail are computed. The renderer makes a vector of both by another operation for each noise."""
    geometry, separate = tree.nodes.new("ShaderNodeNewGeometry"), tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(geometry.outputs["Position"], separate.inputs[0])
    value = None
    for at in range(65):
        noise, shift, add = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexNoise", "Math", "Math"))
        noise.noise_dimensions, noise.inputs["Scale"].default_value, shift.inputs[1].default_value = "4D", 1.0, at + 1.0
        tree.links.new(separate.outputs[0], shift.inputs[0])
        for name, output in (("Vector", geometry.outputs["Position"]), ("W", shift.outputs[0]), ("Detail", separate.outputs[1])):
            tree.links.new(output, noise.inputs[name])
        tree.links.new(noise.outputs[0], add.inputs[0])
        if value is not None:
            tree.links.new(value, add.inputs[1])
        value = add.outputs[0]
    return scenes.shader(tree, "ShaderNodeBsdfDiffuse", Color=value).outputs[0]


@pytest.mark.parametrize("build", [large_graph, graph_of_vectors], ids=lambda build: build.__name__)
def test_graphs_that_are_too_large_are_named(tmp_path: Path, build: Any) -> None:
    """The report names the socket, and the program takes the scene."""
    scene = minimal(lambda: scenes.material("large", build))
    found = exported(tmp_path)
    assert "needs more than 256 operations; Color takes its default value" in found.report
    assert 'type="noise_' not in found.scene_file.read_text()
    support.render(scene, "LODESTAR", 1, "too-large")


def test_each_object_has_its_own_coordinates(tmp_path: Path) -> None:
    """Generated coordinates differ from object to object, and a constant material does not."""
    scene = minimal(lambda: scenes.material("shared", shared_noise))
    scenes.plane(scene, "other", 2, bpy.data.materials["shared"], location=(0, 0, 1))
    text = exported(tmp_path).scene_file.read_text()
    assert len(re.findall('<bsdf [^>]*id="shared#', text)) == 2 and text.count('type="noise_3d"') == 2


def test_a_computed_world_is_named(tmp_path: Path) -> None:
    scene = minimal(lambda: scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    tree = scene.world.node_tree
    noise, background = tree.nodes.new("ShaderNodeTexNoise"), next(n for n in tree.nodes if n.type == "BACKGROUND")
    tree.links.new(noise.outputs["Color"], background.inputs["Color"])
    assert "a computed color of the world is not supported" in exported(tmp_path).report


def test_objects_without_surfaces_are_named(tmp_path: Path) -> None:
    scene = minimal(lambda: scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    scenes.add(scene, "smoke", bpy.data.volumes.new("smoke"))
    report = exported(tmp_path).report
    assert 'object "smoke"' in report


def test_cameras_that_are_refused(tmp_path: Path) -> None:
    scene = minimal(lambda: scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    scene.camera.data.type = "PANO"
    with pytest.raises(camera.Unsupported, match="as Equirectangular"):
        exported(tmp_path)
    scene.camera = None
    with pytest.raises(camera.Unsupported, match="no camera"):
        exported(tmp_path)


def test_every_shader_renders() -> None:
    """The program accepts each material that the export writes, with few samples."""
    scene = scenes.empty()
    scene.render.resolution_percentage = 25
    scenes.camera(scene)
    scenes.world(scene, (1, 1, 1))
    texture = scenes.image("picture", scenes.np.full((4, 4, 3), 0.5))

    def textured(kind: str, *names: str) -> Any:
        def build(tree: Any) -> Any:
            node = tree.nodes.new("ShaderNodeTexImage")
            node.image = texture
            return scenes.shader(tree, kind, **{name: node.outputs["Color"] for name in names}).outputs[0]

        return scenes.material(" ".join((kind, *names)), build)

    def mixed(*kinds: str) -> Any:
        return scenes.material(" ".join(kinds), lambda tree: scenes.mixed(tree, *(scenes.shader(tree, kind) for kind in kinds)))

    simple, p = scenes.simple, "ShaderNodeBsdfPrincipled"
    # Blender 4.2 has no Metallic BSDF.
    has_metallic = bpy.app.version >= (4, 3, 0)
    surfaces = [
        simple("coat", p, Coat_Weight=0.5, Coat_Tint=(0.9, 0.5, 0.5)),
        simple("rough coat", p, Coat_Weight=1.0, Coat_Roughness=0.5, Transmission_Weight=0.5),
        simple("tinted layers", p, Specular_Tint=(0.2, 0.5, 0.9), Metallic=0.5, Coat_Weight=1.0, Coat_Tint=(0.9, 0.5, 0.5)),
        textured(p, "Base_Color", "Coat_Weight", "Coat_Tint"),
        textured(p, "Specular_Tint", "Roughness"),
        simple("sheen", p, Sheen_Weight=0.5),
        simple("sheen over all", p, Sheen_Weight=0.5, Alpha=0.5, Transmission_Weight=0.3, Metallic=0.2, Subsurface_Weight=0.5),
        simple("sheen over nothing bent", p, Sheen_Weight=0.5, Transmission_Weight=0.5, IOR=1.0),
        simple("fibers", "ShaderNodeBsdfSheen"),
        textured(p, "Sheen_Weight", "Sheen_Tint", "Sheen_Roughness"),
        simple("half metal", p, Metallic=0.5, Anisotropic=0.5),
        simple("half glass", p, Transmission_Weight=0.5, Alpha=0.5),
        simple("clear", p, Transmission_Weight=1.0, Roughness=0.0),
        simple("smooth", p, Roughness=0.0),
        simple("dull", p, Specular_IOR_Level=0.0),
        textured(p, "Base_Color", "Roughness", "Metallic", "Alpha"),
        *([textured(p, "Diffuse_Roughness"), simple("chalk", p, Diffuse_Roughness=0.5)] if has_metallic else []),
        textured(p, "Transmission_Weight", "Roughness", "Base_Color"),
        textured("ShaderNodeEmission", "Color"),
        textured("ShaderNodeBsdfGlass", "Color", "Roughness"),
        textured("ShaderNodeBsdfAnisotropic", "Color", "Roughness"),
        *([simple("metallic", "ShaderNodeBsdfMetallic")] if has_metallic else []),
        simple("refraction", "ShaderNodeBsdfRefraction", Roughness=0.2),
        simple("rough", "ShaderNodeBsdfDiffuse", Roughness=0.5),
        simple("wax", p, Subsurface_Weight=1.0, Roughness=0.0),
        simple("half wax", p, Subsurface_Weight=0.5, Alpha=0.5, Transmission_Weight=0.3, Metallic=0.2),
        simple("dull wax", p, Subsurface_Weight=1.0, Specular_IOR_Level=0.0),
        textured(p, "Subsurface_Weight", "Base_Color", "Roughness"),
        simple("skin", "ShaderNodeSubsurfaceScattering"),
        simple("leaf", "ShaderNodeBsdfTranslucent"),
        mixed("ShaderNodeBsdfTranslucent", "ShaderNodeSubsurfaceScattering"),
        mixed("ShaderNodeBsdfTransparent", "ShaderNodeSubsurfaceScattering"),
        simple("tinted", "ShaderNodeBsdfTransparent", Color=(0.5, 0.6, 0.7)),
    ]
    for at, surface in enumerate(surfaces):
        scenes.ball(scene, surface.name, 0.3, surface, location=(at % 5 - 2.0, at // 5 - 2.0, 0.3))
    image = support.colors(support.render(scene, "LODESTAR", 4, "shaders"))
    assert image.mean() > 0.1


def test_stopping_keeps_the_picture(tmp_path: Path) -> None:
    """A stopped program ends with its picture."""
    minimal(lambda: scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    scene = exported(tmp_path).scene_file
    line = ["render", str(scene), "--width", "16", "--height", "16", "--spp", "1000000000", "-o", engine.PICTURE, "--log", "json"]
    running = process.Process(process.find(""), line, tmp_path, engine.PICTURE)
    stopped = False
    for event in running.events():
        if event is not None and event["event"] == "step" and not stopped:
            running.stop()
            stopped = True
    assert stopped and running.failure is None and running.picture() is not None


def test_missing_program() -> None:
    with pytest.raises(FileNotFoundError, match="preferences"):
        process.find("/nowhere/lodestar")


def test_a_fault_of_the_add_on_ends_the_render_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """An exception that nobody expects is an error of the render, with its kind."""
    scene = minimal(lambda: scenes.diffuse("gray", (0.5, 0.5, 0.5)))

    def fail(*arguments: Any) -> Any:
        raise KeyError("socket")

    monkeypatch.setattr(engine.export, "export", fail)
    with pytest.raises(RuntimeError, match="fault of the add-on, KeyError: 'socket'"):
        support.render(scene, "LODESTAR", 1)


def test_bytes_of_images_are_decoded_by_the_curve() -> None:
    """A table of the 256 values of bytes is the sRGB curve."""
    scenes.empty()
    values = np.arange(256, dtype=np.float32).reshape(16, 16, 1) / 255.0
    made = scenes.image("bytes", np.repeat(values, 3, axis=2))
    found = images.pixels(made, report.Report())[:, :, :3]
    assert np.abs(np.sort(found[:, :, 0].ravel()) - images.linear_from_srgb(values.ravel())).max() < 1e-6
