"""Views of regions as cameras: points lie where Blender's matrices put them."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
import pytest
from lodestar import view_camera
from lodestar.view_camera import View
from mathutils import Matrix, Vector

WIDTH, HEIGHT = 301, 200
POINTS = [Vector(point) for point in ((0, 0, 0), (1, 0.2, 0.4), (-0.7, 1, -0.5), (0.3, -0.8, 0.9))]


def seen(sensor: dict[str, Any], film: tuple[int, int], point: Vector) -> np.ndarray:
    """Place of a point in a film, in pixels from the top left, by the renderer's rule for its cameras."""
    x, y, z, _ = np.linalg.inv(np.array(sensor["to_world"])) @ (*point, 1.0)
    width, height = film
    if sensor["type"] == "orthographic":
        tangents, offset = (1.0, height / width), (0.0, 0.0)
    else:
        x, y = x / z, y / z
        tangent = math.tan(0.5 * math.radians(sensor["fov"]))
        tangents = (tangent, tangent * height / width)
        offset = (sensor["principal_point_offset_x"], sensor["principal_point_offset_y"])
    return np.array([(0.5 * (1.0 - x / tangents[0]) - offset[0]) * width, (0.5 * (1.0 - y / tangents[1]) - offset[1]) * height])


def in_region(view: Any, point: Vector) -> np.ndarray:
    """Place of a point in a region, in pixels from the bottom left, by Blender's matrices."""
    clip = view.window_matrix @ view.view_matrix @ point.to_4d()
    return np.array([(0.5 + 0.5 * clip[0] / clip[3]) * WIDTH, (0.5 + 0.5 * clip[1] / clip[3]) * HEIGHT])


def check(view: View, of_blender: Any, pixel: int = 1) -> None:
    x, y, _, height = view.covered(pixel)
    for point in POINTS:
        column, row = seen(view.sensor(pixel), view.film(pixel), point) * pixel
        assert np.allclose((x + column, y + height - row), in_region(of_blender, point), atol=2e-2), (point, pixel)


@pytest.fixture
def scene() -> Any:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 320, 180
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    camera.matrix_world = Matrix.Translation((2, -5, 3)) @ Vector((2, -5, 3)).to_track_quat("Z", "Y").to_matrix().to_4x4()
    scene.camera = camera
    return scene


def region() -> Any:
    return SimpleNamespace(width=WIDTH, height=HEIGHT)


def space(**values: Any) -> Any:
    known = {"use_local_camera": False, "camera": None, "use_render_border": False, "clip_start": 0.01, "clip_end": 100.0}
    return SimpleNamespace(**{**known, **values})


def free_view(projection: Matrix, place: Any) -> Any:
    return SimpleNamespace(window_matrix=projection, view_matrix=place.inverted(), view_perspective="PERSP")


def perspective(scene: Any) -> Any:
    """View that looks along a camera with the lens of a region, off the middle as that of a camera view."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    projection = scene.camera.calc_matrix_camera(depsgraph, x=WIDTH, y=HEIGHT)
    shifted = Matrix.Translation((0.2, -0.3, 0.0)) @ Matrix.Diagonal((1.4, 1.4, 1.0, 1.0)) @ projection
    return free_view(shifted, scene.camera.matrix_world)


@pytest.mark.parametrize("pixel", [1, 2, 7])
@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
@pytest.mark.parametrize("fit", ["AUTO", "HORIZONTAL", "VERTICAL"])
def test_points_lie_where_blender_puts_them(scene: Any, kind: str, fit: str, pixel: int) -> None:
    camera = scene.camera.data
    camera.type, camera.sensor_fit, camera.shift_x, camera.shift_y, camera.ortho_scale = kind, fit, 0.1, -0.2, 7.0
    of_blender = perspective(scene)
    view = view_camera.of_region(region(), of_blender, space(), bpy.context.evaluated_depsgraph_get())
    assert view.kind == {"PERSP": "perspective", "ORTHO": "orthographic"}[kind]
    assert (view.window, view.lens) == ((0, 0, WIDTH, HEIGHT), None)
    check(view, of_blender, pixel)


def test_an_orthographic_view_sees_what_lies_before_its_place(scene: Any) -> None:
    """A view that no camera has reaches as far backward as forward."""
    projection = Matrix(((0.25, 0, 0, 0), (0, 0.4, 0, 0), (0, 0, -0.01, 0), (0, 0, 0, 1)))
    view = view_camera.of_region(region(), free_view(projection, scene.camera.matrix_world), space(), bpy.context.evaluated_depsgraph_get())
    assert np.allclose(view.clip, (-100.0, 100.0))
    sensor = view.sensor()
    eye, forward = (np.array(sensor["to_world"])[:3, column] for column in (3, 2))
    nearest = eye + sensor["near_clip"] * forward / np.linalg.norm(forward)
    assert sensor["near_clip"] > 0.0 and sensor["far_clip"] > sensor["near_clip"]
    assert np.allclose(nearest, np.array(scene.camera.matrix_world @ Vector((0, 0, 100)))[:3], atol=1e-3)


@pytest.mark.parametrize("pixel", [1, 5])
def test_a_border_is_a_part_of_the_view(scene: Any, pixel: int) -> None:
    of_blender = perspective(scene)
    border = {"render_border_min_x": 0.25, "render_border_min_y": 0.1, "render_border_max_x": 0.75, "render_border_max_y": 0.6}
    depsgraph = bpy.context.evaluated_depsgraph_get()
    view = view_camera.of_region(region(), of_blender, space(use_render_border=True, **border), depsgraph)
    assert view.window == (75, 20, 151, 100)
    assert view.film(1) == (151, 100)
    check(view, of_blender, pixel)


def test_the_border_of_a_camera_lies_in_its_frame(scene: Any) -> None:
    of_blender = perspective(scene)
    of_blender.view_perspective = "CAMERA"
    render = scene.render
    render.use_border, render.border_min_x, render.border_min_y, render.border_max_x, render.border_max_y = True, 0.3, 0.2, 0.6, 0.7
    # The border of the region is for other views.
    view = view_camera.of_region(region(), of_blender, space(use_render_border=True), bpy.context.evaluated_depsgraph_get())
    frame = [scene.camera.matrix_world @ corner for corner in scene.camera.data.view_frame(scene=scene)]
    places = np.array([in_region(of_blender, corner) for corner in frame])
    low, size = places.min(axis=0), np.ptp(places, axis=0)
    x, y, width, height = view.window
    wanted = np.concatenate([low + (0.3, 0.2) * size, low + (0.6, 0.7) * size])
    assert np.abs(np.array((x, y, x + width, y + height)) - np.maximum(wanted, 0.0)).max() <= 1.0
    check(view, of_blender)
    render.use_border = False
    assert view_camera.of_region(region(), of_blender, space(), bpy.context.evaluated_depsgraph_get()).window == (0, 0, WIDTH, HEIGHT)


def test_a_camera_view_has_the_camera_s_lens_and_planes(scene: Any) -> None:
    camera = scene.camera.data
    camera.dof.use_dof, camera.dof.aperture_fstop, camera.dof.focus_distance = True, 2.0, 4.0
    camera.clip_start, camera.clip_end = 0.5, 50.0
    of_blender = perspective(scene)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    assert view_camera.of_region(region(), of_blender, space(), depsgraph).clip == (0.01, 100.0)
    of_blender.view_perspective = "CAMERA"
    view = view_camera.of_region(region(), of_blender, space(), depsgraph)
    assert view.clip == (0.5, 50.0) and view.kind == "thinlens"
    assert view.lens is not None and np.allclose(view.lens, (0.5 * 0.05 / 2.0, 4.0))
    check(view, of_blender)
    # A view may have a camera of its own.
    other = bpy.data.objects.new("other", bpy.data.cameras.new("other"))
    view = view_camera.of_region(region(), of_blender, space(use_local_camera=True, camera=other), depsgraph)
    assert view.lens is None


def test_a_sheared_camera_looks_without_its_shear(scene: Any) -> None:
    of_blender = perspective(scene)
    of_blender.view_matrix = (scene.camera.matrix_world @ Matrix.Shear("XY", 4, (0.3, 0.1))).inverted()
    view = view_camera.of_region(region(), of_blender, space(), bpy.context.evaluated_depsgraph_get())
    axes = np.array(view.place)[:3, :3]
    assert np.allclose(axes.T @ axes, np.eye(3), atol=1e-6)


def test_a_lens_is_shifted_in_final_renders_too(scene: Any) -> None:
    from lodestar import camera, xml
    from lodestar.report import Report

    data, report = scene.camera.data, Report()
    data.dof.use_dof, data.shift_x, data.shift_y = True, 0.1, -0.2
    element = camera.export(scene.camera, xml.Course(scene.camera.matrix_world), scene, "box", report)
    values = {child.get("name"): child.get("value") for child in element}
    assert element.get("type") == "thinlens" and not report.warnings
    assert (values["principal_point_offset_x"], values["principal_point_offset_y"]) == (xml.number(data.shift_x), xml.number(-data.shift_y * 320 / 180))
