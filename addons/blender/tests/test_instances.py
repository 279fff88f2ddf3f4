"""What a scene shows in several places: collections, particles, geometry nodes, and objects that share a mesh."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
import scenes
import support
from lodestar import export


def exported(folder: Path) -> tuple[export.Export, Any]:
    """Export, and the root of its scene file."""
    found = export.export(bpy.context.evaluated_depsgraph_get(), folder, export.Options())
    return found, export.xml.ElementTree.parse(found.scene_file).getroot()


def places(root: Any) -> list[str]:
    """What stands directly in the scene: the file of a mesh, or the group that an instance shows."""
    found = []
    for shape in root.findall("shape"):
        if shape.get("type") == "instance":
            found.append(shape.find("ref").get("id"))
        elif shape.get("type") == "ply":
            found.append(shape.find("string").get("value"))
    return found


def material_of(shape: Any) -> str:
    """Name of a shape's material."""
    return shape.find("ref").get("id").rpartition("#")[0]


def base() -> Any:
    scene = scenes.empty()
    scenes.camera(scene, (0, -7, 5), (0, 0, 0))
    scenes.world(scene, (0.5, 0.5, 0.5))
    scenes.plane(scene, "ground", 12, scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    return scene


def on_points(scene: Any, source: Any, points: np.ndarray) -> Any:
    """Geometry nodes that show an object at points."""
    mesh = bpy.data.meshes.new("points")
    mesh.vertices.add(len(points))
    mesh.vertices.foreach_set("co", np.asarray(points, np.float32).ravel())
    group = bpy.data.node_groups.new("on points", "GeometryNodeTree")
    for direction in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    kinds = ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeInstanceOnPoints", "GeometryNodeObjectInfo")
    start, end, instances, info = (group.nodes.new(kind) for kind in kinds)
    info.inputs["Object"].default_value, info.inputs["As Instance"].default_value = source, True
    group.links.new(start.outputs[0], instances.inputs["Points"])
    group.links.new(info.outputs["Geometry"], instances.inputs["Instance"])
    group.links.new(instances.outputs[0], end.inputs[0])
    placed = scenes.add(scene, "points", mesh)
    placed.modifiers.new("on points", "NODES").node_group = group
    return placed


def particles(scene: Any, source: Any, size: float, count: int) -> Any:
    """A plane that shows an object as particles."""
    emitter = scenes.plane(scene, "emitter", 2, scenes.diffuse("emitter", (0.3, 0.3, 0.3)), location=(0, 2.5, 0.05))
    emitter.modifiers.new("particles", "PARTICLE_SYSTEM")
    settings = emitter.particle_systems[0].settings
    settings.type, settings.count, settings.frame_start, settings.frame_end, settings.lifetime = "EMITTER", count, 0, 0, 100
    settings.physics_type, settings.render_type, settings.instance_object = "NO", "OBJECT", source
    settings.particle_size = size
    return emitter


def test_what_is_shown_in_several_places_is_written_once(tmp_path: Path) -> None:
    """Objects that share a mesh are instances of a group. One whose own material differs is a shape, and so is what stands alone."""
    scene = base()
    ball = scenes.ball(scene, "ball", 0.5, scenes.diffuse("red", (0.7, 0.2, 0.2)))
    for at in range(3):
        scenes.add(scene, f"copy {at}", ball.data, (at, 1, 0))
    other = scenes.add(scene, "other", ball.data, (0, 2, 0))
    other.material_slots[0].link = "OBJECT"
    other.material_slots[0].material = scenes.diffuse("blue", (0.1, 0.2, 0.8))
    found, root = exported(tmp_path)
    groups = [shape for shape in root.findall("shape") if shape.get("type") == "shapegroup"]
    assert [[material_of(child) for child in group] for group in groups] == [["red"]]
    shown = places(root)
    assert shown.count(groups[0].get("id")) == 4 and len(shown) == 6 and found.meshes_written == 2
    alone = [shape for shape in root.findall("shape") if shape.get("type") == "ply"]
    assert sorted(map(material_of, alone)) == ["blue", "gray"]
    assert all(shape.find("transform") is not None for shape in alone)


def test_every_kind_of_instance_is_one(tmp_path: Path) -> None:
    """Collections, particles and geometry nodes; a collection of two slots is a group of two shapes."""
    scene = scenes.instances()
    _, root = exported(tmp_path / "collections")
    groups = [shape for shape in root.findall("shape") if shape.get("type") == "shapegroup"]
    assert [len(group.findall("shape")) for group in groups] == [2] and places(root).count(groups[0].get("id")) == 3
    for name, build in (("particles", lambda ball: particles(scene, ball, 0.2, 40)), ("nodes", lambda ball: on_points(scene, ball, np.eye(3)))):
        scene = base()
        build(scenes.ball(scene, "ball", 0.5, scenes.diffuse("red", (0.7, 0.2, 0.2))))
        _, root = exported(tmp_path / name)
        groups = [shape.get("id") for shape in root.findall("shape") if shape.get("type") == "shapegroup"]
        assert len(groups) == 1 and places(root).count(groups[0]) == {"particles": 41, "nodes": 4}[name]


def test_instances_take_few_bytes(tmp_path: Path) -> None:
    """Ten thousand instances take at most 250 bytes each, so that a million is within the program's limit, and two meshes."""
    scene = base()
    count = 10_000
    ball = scenes.ball(scene, "ball", 0.5, scenes.diffuse("red", (0.7, 0.2, 0.2)))
    on_points(scene, ball, np.random.default_rng(0).uniform(-30, 30, (count, 3)))
    found, root = exported(tmp_path)
    assert len(places(root)) == count + 2 and found.meshes_written == 2
    assert found.scene_file.stat().st_size < 250 * count


def test_curves_are_shown_once(tmp_path: Path) -> None:
    """Blender gives a curve and the mesh of its surface; a material of the object goes with it. So does a metaball."""
    scene = base()
    metaball = bpy.data.metaballs.new("metaball")
    metaball.elements.new()
    metaball.materials.append(scenes.diffuse("drop", (0.2, 0.2, 0.8)))
    scenes.add(scene, "metaball", metaball, (0, 1, 0))
    for at, kind in enumerate(("FONT", "CURVE")):
        curve = bpy.data.curves.new(kind, kind)
        curve.extrude = 0.1
        if kind == "FONT":
            curve.body = "L"
        else:
            curve.dimensions = "3D"
            curve.splines.new("POLY").points.add(1)
            curve.splines[0].points[1].co = (1, 0, 0, 1)
        curve.materials.append(scenes.diffuse("yellow", (0.8, 0.7, 0.1)))
        placed = scenes.add(scene, kind, curve, (at, 0, 0))
        placed.material_slots[0].link, placed.material_slots[0].material = "OBJECT", scenes.diffuse(f"of {kind}", (0.1, 0.2, 0.8))
    _, root = exported(tmp_path)
    assert sorted(map(material_of, root.findall("shape"))) == ["drop", "gray", "of CURVE", "of FONT"]


def several_places() -> Any:
    """Mirrored, sheared and unevenly scaled instances, which shed light or have a material of their own, beside hidden ones."""
    scene = base()
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.2
    ball = scenes.ball(scene, "ball", 0.45, scenes.diffuse("red", (0.8, 0.3, 0.2)), location=(-2.4, -1.5, 0.5))
    scenes.add(scene, "mirrored", ball.data, (-1.2, -1.5, 0.5), (0.3, 0.2, 0.1), (-1, 1, 0.5))
    parent = scenes.add(scene, "parent", None, (0.1, -1.5, 0.5), scale=(1.4, 0.5, 1))
    scenes.add(scene, "sheared", ball.data, rotation=(0.2, 0, 0.8)).parent = parent
    blue = scenes.add(scene, "blue", ball.data, (1.4, -1.5, 0.5))
    blue.material_slots[0].link, blue.material_slots[0].material = "OBJECT", scenes.diffuse("blue", (0.1, 0.2, 0.8))
    scenes.add(scene, "hidden", ball.data, (2.4, -1.5, 0.5)).hide_render = True
    # Open and closed meshes that emit; the second of each is mirrored.
    glow = scenes.simple("glow", "ShaderNodeEmission", Color=(1.0, 0.8, 0.5), Strength=8.0)
    sheet = scenes.plane(scene, "sheet", 0.7, glow, location=(-2, 0.3, 1.2), rotation=(0.4, 0.3, 0))
    scenes.add(scene, "mirrored sheet", sheet.data, (-0.7, 0.3, 1.2), (0.4, -0.3, 0), (1, -1, 1))
    bulb = scenes.ball(scene, "bulb", 0.2, glow, location=(0.7, 0.3, 0.6))
    scenes.add(scene, "mirrored bulb", bulb.data, (1.9, 0.3, 0.6), scale=(1, 1, -1))
    # The source of particles and nodes is hidden; its instances are not.
    source = scenes.ball(scene, "source", 0.25, scenes.diffuse("green", (0.2, 0.7, 0.2)), location=(0, 0, 5))
    source.hide_render = True
    particles(scene, source, 0.8, 30)
    on_points(scene, source, np.array([(-2.6, 1.6, 0.3), (2.6, 1.6, 0.3), (2.8, 2.8, 0.3)]))
    return scene


def test_agrees_with_cycles() -> None:
    scene = several_places()
    theirs = support.colors(support.render(scene, "CYCLES", 512, "places"))
    ours = support.colors(support.render(scene, "LODESTAR", 512, "places"))
    found, ratio = support.deviation(ours, theirs), support.mean_ratio(ours, theirs)
    print(f"several_places: largest deviation {found:.4f}, ratio of means {ratio:.4f}")
    assert found < 0.03 and abs(ratio - 1.0) < 0.01
