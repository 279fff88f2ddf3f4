"""Writes the values that Cycles gives to nodes, and the programs that the add-on makes of them.

usage: python compare_nodes.py FOLDER [POINTS]

FOLDER gets `nodes.xml`, a scene with one disk for each case, and `values.bin`: 32-bit numbers, first of all points (position, texture
coordinates, normal, incoming direction), then of all cases the three numbers at each point. The test `blender_nodes` of the crate reads
both, from `tests/data/blender_nodes` and from the folder that LODESTAR_NODES names. It needs the package `bpy`.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import lodestar  # noqa: E402
from lodestar import camera, exr, xml  # noqa: E402
from lodestar.evaluator import Evaluator, convert  # noqa: E402
from lodestar.hashes import number_of_object  # noqa: E402
from lodestar.images import Images  # noqa: E402
from lodestar.nodes import Placed, Reader, Surroundings  # noqa: E402
from lodestar.report import Report  # noqa: E402

from node_cases import cases, node  # noqa: E402

SIDE = 64
DEFAULT_POINTS = 40
# Cases in one picture: a shader of Cycles holds a limited number of values.
AT_ONCE = 8


def scene() -> tuple[Any, Any]:
    """Scene with a tilted plane under a camera, and the plane."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    mesh = bpy.data.meshes.new("plane")
    mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
    mesh.uv_layers.new().uv.foreach_set("vector", [0, 0, 1, 0, 1, 1, 0, 1])
    plane = bpy.data.objects.new("Plane", mesh)
    scene.collection.objects.link(plane)
    plane.location, plane.rotation_euler, plane.scale = (0.3, -0.2, 0.4), (0.5, -0.7, 0.3), (3.0, 2.0, 1.0)
    plane.color, plane.pass_index = (0.2, 0.7, 0.4, 0.6), 3
    bpy.ops.object.camera_add(location=(0.5, -1.0, 5.0), rotation=(0.2, 0.1, 0.4))
    scene.camera = bpy.context.object
    scene.camera.data.lens = 45.0
    render, cycles = scene.render, scene.cycles
    render.engine, render.resolution_x, render.resolution_y, render.resolution_percentage = "CYCLES", SIDE, SIDE, 100
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising, cycles.device = 1, False, False, "CPU"
    image = render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "MULTI_LAYER_IMAGE"
    image.file_format, image.color_depth, image.exr_codec = "OPEN_EXR_MULTILAYER", "32", "ZIP"
    if hasattr(image, "use_exr_interleave"):
        image.use_exr_interleave = True
    return scene, plane


def values(scene: Any, plane: Any, builders: list[Any], folder: Path) -> tuple[list[np.ndarray], Any, list[Any]]:
    """Values of outputs at all pixels, the material, and the outputs."""
    material = bpy.data.materials.new("case")
    material.use_nodes, material.pass_index = True, 5
    tree = material.node_tree
    tree.nodes.clear()
    tree.links.new(node(tree, "Emission").outputs[0], node(tree, "OutputMaterial").inputs["Surface"])
    outputs = [build(tree) for build in builders]
    layer = scene.view_layers[0]
    while layer.aovs:
        layer.aovs.remove(layer.aovs[0])
    for at, output in enumerate(outputs):
        name = f"V{at}"
        layer.aovs.add().name = name
        aov = tree.nodes.new("ShaderNodeOutputAOV")
        aov.aov_name = name
        tree.links.new(output, aov.inputs["Color"])
    plane.data.materials.clear()
    plane.data.materials.append(material)
    scene.render.filepath = str(folder / "values.exr")
    bpy.ops.render.render(write_still=True)
    picture = exr.read(Path(scene.render.filepath))
    layers = [_layer(picture, f"V{at}") for at in range(len(outputs))]
    return layers, material, outputs


def _layer(picture: Any, name: str) -> np.ndarray:
    prefix = next(channel for channel in picture.channels if f".{name}." in channel or channel.startswith(f"{name}."))
    prefix = prefix.rsplit(".", 1)[0]
    suffixes = "RGB" if f"{prefix}.R" in picture.channels else "XYZ"
    found = picture.layer([f"{prefix}.{channel}" for channel in suffixes])
    assert found is not None
    return found.reshape(-1, 3)


def main(folder: Path, count: int) -> None:
    """Writes the two files."""
    folder.mkdir(parents=True, exist_ok=True)
    made, plane = scene()
    points = [lambda t, kind=kind, name=name: node(t, kind).outputs[name] for kind, name in (
        ("NewGeometry", "Position"), ("TexCoord", "UV"), ("NewGeometry", "True Normal"), ("NewGeometry", "Incoming"))]  # fmt: skip
    found, _, _ = values(made, plane, points, folder)
    inside = np.flatnonzero(np.linalg.norm(found[2], axis=1) > 0.5)
    chosen = inside[np.linspace(0, len(inside) - 1, min(count, len(inside))).astype(int)]
    place = np.concatenate([found[0], np.stack([found[1][:, 0], 1.0 - found[1][:, 1]], axis=1), found[2], found[3]], axis=1)[chosen]
    report, images = Report(), Images(folder, Report())
    root = xml.ElementTree.Element("scene", {"version": "3.0.0"})
    shapes, blocks = [], []
    all_cases = list(cases())
    for first in range(0, len(all_cases), AT_ONCE):
        some = all_cases[first : first + AT_ONCE]
        layers, material, outputs = values(made, plane, [build for _, build in some], folder)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        evaluated = plane.evaluated_get(depsgraph)
        placed = Placed(evaluated, evaluated.matrix_world.copy(), number_of_object(plane.name))
        seen = Surroundings(placed, depsgraph.scene_eval.camera, camera.projection(depsgraph.scene_eval.camera, made, depsgraph))
        reader = Reader("case", report, images, surroundings=seen, material_index=material.pass_index)
        for (name, _), layer, output in zip(some, layers, outputs):
            value = Evaluator(reader, images.graph).output(output.node, output, ())
            assert value is not None, f"{name} is not translated"
            value = convert(value, output.type, output.type)
            expected = layer[chosen]
            if value.is_constant:
                difference = np.abs(expected - np.array(value.constant)).max()
                assert difference < 1e-4, f"{name}: {value.constant} is not {expected[0]}"
                continue
            images.used_programs.add(images.graph.name(value))
            bsdf = xml.plugin("bsdf", "diffuse", id=name)
            xml.add(bsdf, "reflectance", images.graph.reference(value))
            shapes += [bsdf, xml.with_children(xml.plugin("shape", "disk"), xml.ElementTree.Element("ref", {"id": name}))]
            blocks.append(expected)
        bpy.data.materials.remove(material)
    assert not report.warnings, report.warnings
    sensor = xml.plugin("sensor", "perspective")
    xml.with_children(root, sensor, *images.graph.elements(images.used_programs), *shapes)
    (folder / "nodes.xml").write_text(xml.text_of(root), encoding="utf-8")
    numbers = np.concatenate([np.array([len(place), len(blocks)], np.float32), place.ravel(), *(block.ravel() for block in blocks)])
    numbers.astype("<f4").tofile(folder / "values.bin")
    (folder / "values.exr").unlink()
    print(f"{len(all_cases)} cases, {len(blocks)} programs, {len(place)} points")


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else DEFAULT_POINTS)
