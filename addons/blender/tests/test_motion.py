"""Motion blur: what moves while the shutter is open, and what the report says of the rest."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import hair_scenes
import numpy as np
import pytest
import scenes
import support
from lodestar import export, motion


def drive(owner: Any, path: str, index: int, expression: str) -> None:
    """Makes a number of an object depend on the frame, which has a fraction."""
    curve = owner.driver_add(path, index) if index >= 0 else owner.driver_add(path)
    curve.driver.expression = expression


def base(position: str = "CENTER", duration: float = 1.0) -> Any:
    """Ground under a lamp, whose shutter is open about the frame 5."""
    scene = scenes.empty()
    scenes.camera(scene, (0, -7, 5), (0, 0, 0))
    scenes.world(scene, (0.5, 0.5, 0.5))
    scenes.plane(scene, "ground", 12, scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    scene.render.use_motion_blur, scene.render.motion_blur_shutter, scene.render.motion_blur_position = True, duration, position
    scene.frame_set(5)
    return scene


def moving_ball(scene: Any, expression: str = "2 * frame") -> Any:
    ball = scenes.ball(scene, "ball", 0.6, scenes.diffuse("red", (0.7, 0.2, 0.2)), location=(0, 0, 0.6))
    drive(ball, "location", 0, expression)
    return ball


def exported(folder: Path) -> tuple[export.Export, Any]:
    """Export, and the root of its scene file."""
    found = export.export(bpy.context.evaluated_depsgraph_get(), folder, export.Options())
    return found, export.xml.ElementTree.parse(found.scene_file).getroot()


def keys(root: Any) -> list[list[tuple[float, float]]]:
    """Times and places along x of all that moves."""
    place = lambda key: float(key.find("matrix").get("value").split()[3])  # noqa: E731
    return [[(float(key.get("time")), place(key)) for key in motion] for motion in root.iter("animation")]


@pytest.mark.parametrize("position,places", [("START", (10, 10.5, 11)), ("CENTER", (9.5, 10, 10.5)), ("END", (9, 9.5, 10))])
def test_the_shutter_is_open_about_the_frame(tmp_path: Path, position: str, places: Any) -> None:
    scene = base(position, 0.5)
    moving_ball(scene)
    found, root = exported(tmp_path)
    assert found.report.warnings == []
    assert keys(root) == [[pytest.approx(pair) for pair in zip((0.0, 0.5, 1.0), places)]]
    assert [element.get("value") for element in root.find("sensor") if element.get("name", "").startswith("shutter")] == ["0", "1"]
    assert (scene.frame_current, scene.frame_subframe) == (5, 0.0) and scene.objects["ball"].location.x == 10.0


def test_what_stands_is_written_as_without_blur(tmp_path: Path) -> None:
    scene = base()
    ball = moving_ball(scene)
    scenes.add(scene, "copy", ball.data, (0, 2, 1))
    for each in (ball, *scene.objects):
        each.cycles.use_motion_blur = False
    texts = []
    for scene.render.use_motion_blur in (True, False):
        found, _ = exported(tmp_path)
        texts.append(found.scene_file.read_text())
    assert texts[0] == texts[1] and "animation" not in texts[0] and "shutter" not in texts[0]


def test_instances_and_steps(tmp_path: Path) -> None:
    """What an object instances moves with it, and has as many steps as the one of both that has more."""
    scene = base()
    kept = bpy.data.collections.new("kept")
    ball = scenes.ball(scene, "ball", 0.3, scenes.diffuse("red", (0.7, 0.2, 0.2)))
    scene.collection.objects.unlink(ball)
    kept.objects.link(ball)
    for at in range(3):
        placed = scenes.add(scene, f"copy {at}", None, (0, at, 0))
        placed.instance_type, placed.instance_collection = "COLLECTION", kept
        placed.cycles.motion_steps = at + 1
        if at > 0:
            drive(placed, "location", 0, "frame")
    _, root = exported(tmp_path)
    assert [len(motion) for motion in keys(root)] == [5, 9]
    assert len([shape for shape in root.findall("shape") if shape.get("type") == "instance"]) == 3


def test_an_object_that_is_named_camera_stands(tmp_path: Path) -> None:
    """Only the camera moves, and neither takes the keys of the other."""
    scene = base()
    drive(scene.camera, "location", 0, "2 * frame")
    scene.camera.name = "eye"
    scenes.ball(scene, "camera", 0.6, scenes.diffuse("red", (0.7, 0.2, 0.2)), location=(0.25, 0, 0.6))
    found, root = exported(tmp_path)
    assert found.report.warnings == []
    assert keys(root) == [[pytest.approx(pair) for pair in zip((0.0, 0.5, 1.0), (9.0, 10.0, 11.0))]]
    assert root.find("sensor").find("animation") is not None
    matrices = [shape.find("transform/matrix").get("value").split() for shape in root.findall("shape")]
    assert sorted(float(matrix[3]) for matrix in matrices) == [0.0, 0.25]


def two_meshes(scene: Any) -> Any:
    """Geometry nodes of one object that show a cube and a sphere at each of 20 points."""
    group = bpy.data.node_groups.new("two meshes", "GeometryNodeTree")
    for direction in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    start, end, join = (group.nodes.new(kind) for kind in ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeJoinGeometry"))
    for kind in ("GeometryNodeMeshCube", "GeometryNodeMeshUVSphere"):
        mesh, shown = group.nodes.new(kind), group.nodes.new("GeometryNodeInstanceOnPoints")
        group.links.new(start.outputs[0], shown.inputs["Points"])
        group.links.new(mesh.outputs[0], shown.inputs["Instance"])
        group.links.new(shown.outputs[0], join.inputs[0])
    group.links.new(join.outputs[0], end.inputs[0])
    points = bpy.data.meshes.new("points")
    points.from_pydata([(at, 0, 0) for at in range(20)], [], [])
    placed = scenes.add(scene, "points", points)
    placed.modifiers.new("two meshes", "NODES").node_group = group
    return placed


def test_each_instance_is_compared_with_itself(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two meshes of one object are no change of its shape. The vertices of both are read twice: at the start and at the end."""
    read: list[bool] = []
    numbers = motion._numbers

    def counted(owner: Any) -> np.ndarray:
        read.append(owner.type == "MESH")
        return numbers(owner)

    monkeypatch.setattr(motion, "_numbers", counted)
    drive(two_meshes(base()), "location", 1, "frame")
    found, root = exported(tmp_path)
    assert found.report.warnings == []
    assert len(keys(root)) == 40 and sum(read) == 4


def test_an_instance_that_changes_is_named(tmp_path: Path) -> None:
    """Geometry nodes that change the mesh that they show in many places."""
    scene = base()
    group = two_meshes(scene).modifiers[0].node_group
    cube = next(node for node in group.nodes if node.bl_idname == "GeometryNodeMeshCube")
    curve = cube.inputs["Size"].driver_add("default_value", 0)
    curve.driver.expression = "frame"
    found, _ = exported(tmp_path)
    assert len(found.report.warnings) == 1 and found.report.warnings[0].startswith('object "points": its shape changes')


def test_what_an_object_instances_has_its_own_shape(tmp_path: Path) -> None:
    """A sheet whose points move, and a still sheet with as many points that it shows beside itself."""
    sheet = scenes.plane(base(), "sheet", 2, scenes.diffuse("red", (0.7, 0.2, 0.2)), location=(0, 0, 1), rotation=(0.5, 0, 0))
    for point in sheet.data.vertices:
        point.co.z = point.co.x
    sheet.modifiers.new("lean", "NODES").node_group = lean("frame - 5")
    group = bpy.data.node_groups.new("beside", "GeometryNodeTree")
    for direction in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    kinds = ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeJoinGeometry", "GeometryNodeMeshGrid", "GeometryNodeInstanceOnPoints")
    start, end, join, grid, shown = (group.nodes.new(kind) for kind in kinds)
    grid.inputs["Vertices X"].default_value = grid.inputs["Vertices Y"].default_value = 2
    for source, target in (
        (start.outputs[0], join.inputs[0]),
        (start.outputs[0], shown.inputs["Points"]),
        (grid.outputs[0], shown.inputs["Instance"]),
        (shown.outputs[0], join.inputs[0]),
        (join.outputs[0], end.inputs[0]),
    ):
        group.links.new(source, target)
    sheet.modifiers.new("beside", "NODES").node_group = group
    found, _ = exported(tmp_path)
    assert found.report.warnings == []
    has_sets = [b"position2_x" in path.read_bytes() for path in tmp_path.glob("mesh-*.ply")]
    assert sorted(has_sets) == [False, False, True], "the ground, the instanced sheet and the sheet"


def test_strands_of_what_moves_as_a_whole_are_written_once(tmp_path: Path) -> None:
    """A ground with strands far from the origin, which turns and does not bend."""
    scene = base()
    ground = scenes.plane(scene, "mat", 2, scenes.diffuse("red", (0.7, 0.2, 0.2)), location=(30, 20, 1), rotation=(0.5, 0, 0))
    hair_scenes.furry(ground, 40, 0.6)
    drive(ground, "rotation_euler", 2, "0.7 * (frame - 5)")
    found, root = exported(tmp_path)
    assert found.report.warnings == [] and len(list(root.iter("animation"))) > 0
    assert not any(b"position1_x" in path.read_bytes() for path in tmp_path.glob("mesh-*.ply"))


def warnings_of(change: Callable[[Any], None], folder: Path) -> list[str]:
    scene = base()
    change(scene)
    found, _ = exported(folder)
    support.render(scene, "LODESTAR", 1, "accepted")
    return found.report.warnings


def growing(scene: Any) -> None:
    ball = scenes.ball(scene, "ball", 0.6, scenes.diffuse("red", (0.7, 0.2, 0.2)))
    drive(ball.modifiers.new("more", "ARRAY"), "count", -1, "2 * frame - 8")


def appearing(scene: Any) -> None:
    ball = scenes.ball(scene, "ball", 0.6, scenes.diffuse("red", (0.7, 0.2, 0.2)))
    ball.shape_key_add(name="Basis")
    ball.shape_key_add(name="tall").data[0].co.z = 2.0
    drive(ball.data.shape_keys.key_blocks["tall"], "value", -1, "frame - 4.5")
    for name in ("hide_viewport", "hide_render"):
        drive(ball, name, -1, "frame < 4.75")


def flattening(scene: Any) -> None:
    drive(moving_ball(scene), "scale", 2, "frame - 4.5")


def mirrored_on_the_way(scene: Any) -> None:
    drive(moving_ball(scene), "scale", 2, "frame - 4.8")


def small_lamp(scene: Any) -> None:
    drive(scenes.lamp(scene, "POINT", shadow_soft_size=0.0), "location", 0, "frame")


def zooming(scene: Any) -> None:
    drive(scene.camera.data, "lens", -1, "40 + frame")


def many_steps(scene: Any) -> None:
    moving_ball(scene).cycles.motion_steps = 6


def rolling(scene: Any) -> None:
    moving_ball(scene)
    scene.cycles.rolling_shutter_type = "TOP"


def textured(scene: Any) -> None:
    def build(tree: Any) -> Any:
        texture = tree.nodes.new("ShaderNodeTexChecker")
        return scenes.shader(tree, "ShaderNodeBsdfDiffuse", Color=texture.outputs["Color"]).outputs[0]

    moving_ball(scene).data.materials[0] = scenes.material("checked", build)


@pytest.mark.parametrize(
    "change,text",
    [
        (growing, 'object "ball": its vertices become more or fewer'),
        (appearing, 'object "ball": its shape changes, but it is not shown at all times'),
        (flattening, 'object "ball": it is flat'),
        (mirrored_on_the_way, 'object "ball": it is flat'),
        (small_lamp, 'light "point": the motion of suns'),
        (zooming, 'camera "camera": its lens changes'),
        (many_steps, 'object "ball": more than 4 steps'),
        (rolling, "scene: a rolling shutter"),
        (textured, 'object "ball": its material asks for its place'),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_what_cannot_move_is_named(tmp_path: Path, change: Any, text: str) -> None:
    """The report has one sentence, and the program takes the scene."""
    warnings = warnings_of(change, tmp_path)
    assert len(warnings) == 1 and warnings[0].startswith(text), warnings


def things() -> Any:
    """A ball that moves, a bar that turns by 120 degrees, instances on a moving parent, and an emitting sheet that moves and grows."""
    scene = base("START", 0.8)
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.3
    ball = moving_ball(scene, "1.5 * (frame - 5) - 2.5")
    ball.location.y = -1.5
    bar = scenes.plane(scene, "bar", 1, scenes.diffuse("blue", (0.1, 0.2, 0.8)), location=(1.5, -1.2, 0.3), scale=(2.4, 0.4, 1))
    bar.cycles.motion_steps = 2
    drive(bar, "rotation_euler", 2, "(frame - 5) * 2.6")
    small = scenes.ball(scene, "small", 0.35, scenes.diffuse("green", (0.2, 0.7, 0.2)), location=(-1, 1, 0.4))
    parent = scenes.add(scene, "parent", None)
    drive(parent, "location", 1, "1.2 * (frame - 5)")
    for at in range(3):
        scenes.add(scene, f"copy {at}", small.data, (at, 1, 0.4), scale=(1, 1, 0.7)).parent = parent
    glow = scenes.simple("glow", "ShaderNodeEmission", Color=(1.0, 0.8, 0.5), Strength=6.0)
    sheet = scenes.plane(scene, "sheet", 0.8, glow, location=(0, 0.5, 2), rotation=(0.5, 0.2, 0))
    drive(sheet, "location", 0, "2 * (frame - 5)")
    drive(sheet, "scale", 0, "1 + (frame - 5)")
    return scene


def shapes() -> Any:
    """A smooth ball that swells by a shape key, a bar that a modifier bends while its object moves, instances of both, and an emitting
    sheet whose corners move."""
    scene = base("START", 0.8)
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.3
    ball = scenes.ball(scene, "ball", 0.6, scenes.diffuse("red", (0.7, 0.2, 0.2)), location=(-1.5, -1, 0.6))
    ball.shape_key_add(name="Basis")
    for point in ball.shape_key_add(name="wide").data:
        point.co = (2.2 * point.co[0], 0.8 * point.co[1], 0.5 * point.co[2] + 0.6)
    drive(ball.data.shape_keys.key_blocks["wide"], "value", -1, "1.25 * (frame - 5)")
    bar = scenes.plane(scene, "bar", 1, scenes.diffuse("blue", (0.1, 0.2, 0.8)), location=(1.4, -1.0, 0.5), scale=(2.0, 0.6, 1))
    bar.modifiers.new("fine", "SUBSURF").subdivision_type = "SIMPLE"
    bar.modifiers["fine"].render_levels = bar.modifiers["fine"].levels = 4
    bend = bar.modifiers.new("bend", "SIMPLE_DEFORM")
    bend.deform_method, bend.deform_axis = "BEND", "Y"
    bar.cycles.motion_steps = 2
    drive(bend, "angle", -1, "2.6 * (frame - 5)")
    drive(bar, "location", 1, "(frame - 5) - 1.0")
    both = bpy.data.collections.new("both")
    for each in (ball, bar):
        both.objects.link(each)
    for at, place in enumerate([(0.5, 2.0, 0.0), (-2.5, 2.5, 0.5)]):
        copy = scenes.add(scene, f"copy {at}", None, place)
        copy.instance_type, copy.instance_collection = "COLLECTION", both
    glow = scenes.simple("glow", "ShaderNodeEmission", Color=(1.0, 0.8, 0.5), Strength=6.0)
    sheet = scenes.plane(scene, "sheet", 0.8, glow, location=(0, 0.5, 2), rotation=(0.5, 0.2, 0))
    sheet.shape_key_add(name="Basis")
    for point in sheet.shape_key_add(name="open").data:
        point.co = (2.0 * point.co[0] + 1.0, point.co[1], 0.4)
    drive(sheet.data.shape_keys.key_blocks["open"], "value", -1, "frame - 5")
    return scene


def fur() -> Any:
    """Strands on a ground that a shape key bends, and hair curves that geometry nodes lean over while their object moves."""
    scene = hair_scenes.lit()
    scene.render.use_motion_blur, scene.render.motion_blur_shutter, scene.render.motion_blur_position = True, 1.0, "START"
    scene.frame_set(5)
    scenes.plane(scene, "floor", 6.0, scenes.diffuse("gray", (0.5, 0.5, 0.5)))
    ground = scenes.plane(scene, "ground", 2.0, scenes.diffuse("sand", (0.6, 0.4, 0.2)), location=(-1.0, 0, 0.1))
    ground.shape_key_add(name="Basis")
    for point in ground.shape_key_add(name="bent").data:
        point.co = (0.9 * point.co[0], point.co[1], point.co[2] + 0.8 * (point.co[0] > 0.0))
    drive(ground.data.shape_keys.key_blocks["bent"], "value", -1, "frame - 5")
    hair_scenes.furry(ground, 60, 0.6, tip_radius=0.3, use_close_tip=False)
    strands = hair_scenes.bent(4)
    radii = [np.linspace(0.12, 0.05, len(strand)) for strand in strands]
    leaning = hair_scenes.curves(scene, "leaning", strands, radii, scenes.diffuse("red", (0.7, 0.1, 0.1)), location=(1.0, -0.5, 0), scale=(0.6,) * 3)
    leaning.modifiers.new("lean", "NODES").node_group = lean("0.8 * (frame - 5)")
    drive(leaning, "location", 1, "0.5 * (frame - 5) - 0.5")
    return scene


def lean(expression: str) -> Any:
    """Geometry nodes that move points along x by their height times a number."""
    group = bpy.data.node_groups.new("lean", "GeometryNodeTree")
    for direction in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    start, end, place, position = (group.nodes.new(kind) for kind in ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeSetPosition", "GeometryNodeInputPosition"))
    parts, scaled, whole = (group.nodes.new(kind) for kind in ("ShaderNodeSeparateXYZ", "ShaderNodeMath", "ShaderNodeCombineXYZ"))
    scaled.operation = "MULTIPLY"
    scaled.inputs[1].driver_add("default_value").driver.expression = expression
    for source, target in (
        (start.outputs[0], place.inputs["Geometry"]),
        (position.outputs[0], parts.inputs[0]),
        (parts.outputs["Z"], scaled.inputs[0]),
        (scaled.outputs[0], whole.inputs["X"]),
        (whole.outputs[0], place.inputs["Offset"]),
        (place.outputs[0], end.inputs[0]),
    ):
        group.links.new(source, target)
    return group


def camera() -> Any:
    """A camera that moves and turns."""
    scene = base("END", 0.5)
    scenes.ball(scene, "ball", 0.8, scenes.diffuse("red", (0.7, 0.2, 0.2)), location=(0, 0, 0.8))
    scenes.ball(scene, "other", 0.5, scenes.diffuse("blue", (0.1, 0.2, 0.8)), location=(1.6, 1, 0.5))
    drive(scene.camera, "location", 0, "1.5 * (frame - 5)")
    scene.camera.rotation_mode = "XYZ"
    tilt = scene.camera.rotation_euler.z
    drive(scene.camera, "rotation_euler", 2, f"{tilt} - 0.3 * (frame - 5)")
    return scene


def lamp() -> Any:
    """Lamps that move: a rectangle and a ball. The world is black, so that the camera sees no lamp."""
    scene = base("CENTER", 1.0)
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
    scenes.ball(scene, "ball", 0.8, scenes.diffuse("red", (0.7, 0.2, 0.2)), location=(0, 0, 0.8))
    lamps = [
        scenes.lamp(scene, "AREA", (0, 1.5, 2.5), (-0.3, 0, 0), energy=60, shape="RECTANGLE", size=0.8, size_y=0.4),
        scenes.lamp(scene, "POINT", (-2, -1, 1.5), energy=40, shadow_soft_size=0.2),
    ]
    for each in lamps:
        each.visible_camera = False
    drive(lamps[0], "location", 0, "3 * (frame - 5)")
    drive(lamps[0], "rotation_euler", 1, "-1.2 * (frame - 5)")
    drive(lamps[1], "location", 2, "1.5 + 1.5 * (frame - 5)")
    return scene


def deviations(ours: np.ndarray, theirs: np.ndarray) -> tuple[float, float]:
    return support.deviation(ours, theirs), abs(support.mean_ratio(ours, theirs) - 1.0)


@pytest.mark.parametrize("build", [things, shapes, fur, camera], ids=lambda build: build.__name__)
def test_agrees_with_cycles(build: Callable[[], Any]) -> None:
    """Blurred pictures agree, and a picture that is not blurred does not."""
    scene = build()
    theirs = support.colors(support.render(scene, "CYCLES", 256, build.__name__))
    ours = support.colors(support.render(scene, "LODESTAR", 256, build.__name__))
    scene.render.use_motion_blur = False
    still = support.colors(support.render(scene, "LODESTAR", 64, build.__name__))
    found, whole = deviations(ours, theirs)
    print(f"{build.__name__}: largest deviation {found:.4f}, of the mean {whole:.4f}; not blurred {deviations(still, theirs)[0]:.4f}")
    assert found < 0.03 and whole < 0.01
    assert deviations(still, theirs)[0] > 0.06


def test_lamps_that_move_are_the_mean_of_still_ones() -> None:
    """Cycles does not move lamps. Its pictures at eight times have the mean that the blurred picture has."""
    scene = lamp()
    ours = support.colors(support.render(scene, "LODESTAR", 512, "lamp"))
    scene.render.use_motion_blur = False
    times = [(at + 0.5) / 8.0 - 0.5 for at in range(8)]
    pictures = []
    for time in times:
        frame = 5.0 + time
        scene.frame_set(math.floor(frame), subframe=frame - math.floor(frame))
        pictures.append(support.colors(support.render(scene, "CYCLES", 64, "lamp")))
    found, whole = deviations(ours, np.mean(pictures, axis=0))
    print(f"lamp: largest deviation {found:.4f}, of the mean {whole:.4f}")
    assert found < 0.03 and whole < 0.01
    assert deviations(ours, pictures[4])[0] > 0.06
