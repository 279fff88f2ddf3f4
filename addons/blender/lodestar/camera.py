"""Camera: perspective with shift and depth of field, orthographic, and equirectangular."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from . import units, xml
from .report import Report


class Unsupported(Exception):
    """Something without which no picture can be right."""


class Film(NamedTuple):
    """Size of the whole picture in pixels, and the window that is rendered: x, y from the top left, width, height."""

    width: int
    height: int
    window: tuple[int, int, int, int]

    @property
    def is_cropped(self) -> bool:
        return self.window != (0, 0, self.width, self.height)


def film(render: Any) -> Film:
    """Film of Blender's resolution, percentage and border."""
    share = render.resolution_percentage / 100.0
    width, height = max(int(render.resolution_x * share), 1), max(int(render.resolution_y * share), 1)
    if not render.use_border:
        return Film(width, height, (0, 0, width, height))
    # Blender rounds the border's sides towards 0, and has y upwards.
    left, right = int(render.border_min_x * width), int(render.border_max_x * width)
    bottom, top = int(render.border_min_y * height), int(render.border_max_y * height)
    return Film(width, height, (left, height - top, max(right - left, 1), max(top - bottom, 1)))


def horizontal_sensor(camera: Any, render: Any, size: Film) -> tuple[bool, float]:
    """Whether the sensor's size is that of the picture's width, and that size in millimeters."""
    wide = size.width * render.pixel_aspect_x >= size.height * render.pixel_aspect_y
    fit = camera.sensor_fit
    if fit == "AUTO":
        return wide, camera.sensor_width
    return fit == "HORIZONTAL", camera.sensor_width if fit == "HORIZONTAL" else camera.sensor_height


def export(camera_object: Any, course: xml.Course, scene: Any, filter_name: str, report: Report) -> xml.Element:
    """`<sensor>` of a scene's camera."""
    camera, render, size = camera_object.data, scene.render, film(scene.render)
    place = f'camera "{camera_object.name}"'
    if camera.type not in ("PERSP", "ORTHO", "PANO"):
        raise Unsupported(f"{place}: only perspective, orthographic and panoramic cameras are supported, not {camera.type}")
    if render.pixel_aspect_x != render.pixel_aspect_y:
        report.warn(place, "pixels that are not square are not supported; they are taken as square")
    is_horizontal, sensor = horizontal_sensor(camera, render, size)
    # Blender measures the shift by the side that the sensor fits.
    side = size.width if is_horizontal else size.height
    shift = (camera.shift_x * side / size.width, camera.shift_y * side / size.height)
    course = course.mapped(lambda matrix: _upright(matrix, place, report))
    if camera.type == "ORTHO":
        if camera.dof.use_dof:
            report.warn(place, "depth of field of an orthographic camera is not supported; the picture is sharp")
        element = _orthographic(camera, course, size, is_horizontal)
    elif camera.type == "PANO":
        element = _panorama(camera, course, place, report)
    else:
        element = _perspective(camera, camera_object, course, is_horizontal, sensor, shift, place, report)
    xml.add(xml.add(element, "near_clip", max(camera.clip_start, 1e-6)), "far_clip", float(camera.clip_end))
    return xml.with_children(element, _film(size, filter_name))


def _upright(matrix: Any, place: str, report: Report) -> Any:
    """Turn and place of a camera, without the scale and the shear that its parents give it."""
    from mathutils import Matrix

    if min(matrix.col[at].xyz.length for at in range(3)) == 0.0:
        raise Unsupported(f"{place}: its scale is 0, so it looks nowhere; give it another scale")
    turned = matrix.normalized()
    axes = [turned.col[at].xyz for at in range(3)]
    if max(abs(axes[a].dot(axes[b])) for a, b in ((0, 1), (1, 2), (2, 0))) < 1e-4:
        return turned
    report.warn(place, "its parents are scaled unevenly and shear it, which is not supported; the picture is not sheared")
    location, rotation, _ = matrix.decompose()
    return Matrix.Translation(location) @ rotation.to_matrix().to_4x4()


def may_see(camera_object: Any, scene: Any, points: list[Any], margin: float = 0.1) -> bool:
    """Whether a part of the hull of some points may lie within the picture. A share more on each side allows for blur."""
    camera = camera_object.data
    if camera.type == "PANO":
        return True
    view = camera_object.matrix_world.normalized().inverted_safe()
    frame = camera.view_frame(scene=scene)
    seen = [view @ point for point in points]
    is_flat = camera.type == "ORTHO"
    if not is_flat and all(point.z >= 0.0 for point in seen):
        return False
    for axis in (0, 1):
        low, high = min(corner[axis] for corner in frame), max(corner[axis] for corner in frame)
        low, high = low - margin * (high - low), high + margin * (high - low)
        reach = [1.0 if is_flat else point.z / frame[0].z for point in seen]
        if all(point[axis] < low * far for point, far in zip(seen, reach)):
            return False
        if all(point[axis] > high * far for point, far in zip(seen, reach)):
            return False
    return True


def _looking(matrix: Any) -> Any:
    """Transform of Mitsuba's camera, which looks along +z with +x to the left."""
    from mathutils import Matrix

    return matrix @ Matrix.Diagonal((-1.0, 1.0, -1.0, 1.0))


def _perspective(
    camera: Any, owner: Any, course: xml.Course, is_horizontal: bool, sensor: float, shift: tuple[float, float], place: str, report: Report
) -> xml.Element:
    dof = camera.dof
    has_lens = dof.use_dof and dof.aperture_fstop > 0.0 and camera.lens > 0.0
    element = xml.plugin("sensor", "thinlens" if has_lens else "perspective")
    xml.add(element, "fov", units.field_of_view(sensor, camera.lens))
    xml.add(element, "fov_axis", "x" if is_horizontal else "y")
    if has_lens:
        if dof.aperture_blades > 2 or dof.aperture_ratio != 1.0:
            report.warn(place, "blades and ratio of the aperture are not supported; it is round")
        xml.add(element, "aperture_radius", units.aperture_radius(camera.lens, dof.aperture_fstop))
        xml.add(element, "focus_distance", focus(dof, owner))
    if shift != (0.0, 0.0):
        # Mitsuba's offset moves the picture, Blender's shift the view.
        xml.add(element, "principal_point_offset_x", shift[0])
        xml.add(element, "principal_point_offset_y", -shift[1])
    return xml.add_course(element, course.mapped(_looking))


def focus(dof: Any, owner: Any) -> float:
    """Distance of the plane in focus along the view."""
    if dof.focus_object is None:
        return max(float(dof.focus_distance), 1e-6)
    view = owner.matrix_world.normalized().inverted() @ dof.focus_object.matrix_world.translation
    return max(-view.z, 1e-6)


def _panorama(camera: Any, course: xml.Course, place: str, report: Report) -> xml.Element:
    """Panorama whose rows and columns are latitudes and longitudes."""
    # Before Blender 5.0 the settings are those of Cycles.
    settings = camera if hasattr(camera, "panorama_type") else camera.cycles
    if settings.panorama_type != "EQUIRECTANGULAR":
        raise Unsupported(f"{place}: panoramas are supported as Equirectangular, not as {settings.panorama_type}")
    if camera.dof.use_dof:
        report.warn(place, "depth of field of a panoramic camera is not supported; the picture is sharp")
    element = xml.plugin("sensor", "spherical")
    for name in ("longitude_min", "longitude_max", "latitude_min", "latitude_max"):
        xml.add(element, name, math.degrees(getattr(settings, name)))
    return xml.add_course(element, course.mapped(_looking))


def _orthographic(camera: Any, course: xml.Course, size: Film, is_horizontal: bool) -> xml.Element:
    from mathutils import Matrix

    width = camera.ortho_scale if is_horizontal else camera.ortho_scale * size.width / size.height
    shift = _shift(camera)
    scale = Matrix.Diagonal((0.5 * width, 0.5 * width, 1.0, 1.0))
    return xml.add_course(xml.plugin("sensor", "orthographic"), course.mapped(lambda matrix: _looking(matrix @ shift) @ scale))


def _shift(camera: Any) -> Any:
    """Way of an orthographic camera to the place by which its shift moves it."""
    from mathutils import Matrix

    return Matrix.Translation((camera.shift_x * camera.ortho_scale, camera.shift_y * camera.ortho_scale, 0.0))


def place(owner: Any) -> Any:
    """Matrix of the point from which a camera measures distances."""
    matrix = owner.matrix_world.normalized()
    return matrix @ _shift(owner.data) if owner.data.type == "ORTHO" else matrix


def _film(size: Film, filter_name: str) -> xml.Element:
    element = xml.add(xml.add(xml.plugin("film", "hdrfilm"), "width", size.width), "height", size.height)
    if size.is_cropped:
        for name, value in zip(("crop_offset_x", "crop_offset_y", "crop_width", "crop_height"), size.window):
            xml.add(element, name, value)
    return xml.with_children(element, xml.plugin("rfilter", filter_name))


def projection(owner: Any, scene: Any, depsgraph: Any) -> Any:
    """Matrix from the world to the picture, whose sides are -1 and 1."""
    render = scene.render
    size = {"x": render.resolution_x, "y": render.resolution_y, "scale_x": render.pixel_aspect_x, "scale_y": render.pixel_aspect_y}
    return owner.calc_matrix_camera(depsgraph, **size) @ owner.matrix_world.normalized().inverted_safe()
