"""Lights: Blender's lamps as emitters."""

from __future__ import annotations

import math
from typing import Any, Optional

from . import units, xml
from .report import Report

# Directional lights that stand for a sun with an angle, and points that stand for a lamp with a radius.
SUN_PARTS = BALL_PARTS = 64


def color_of(light: Any) -> tuple[float, float, float]:
    """Color of a lamp, with its temperature's tint."""
    color = tuple(light.color)
    if getattr(light, "use_temperature", False):
        color = tuple(a * b for a, b in zip(color, light.temperature_color))
    return color  # type: ignore[return-value]


def export(light: Any, course: xml.Course, name: str, report: Report) -> list[xml.Element]:
    """Emitters of a lamp."""
    place = f'light "{name}"'
    _report_unsupported(light, place, report)
    power = units.exposed(light.energy, getattr(light, "exposure", 0.0))
    tinted = _tinted(light, place, report)
    color = tinted(1.0)
    if power == 0.0 or max(color) == 0.0:
        return []
    if power < 0.0 or min(color) < 0.0:
        report.warn(place, "negative light is not supported; the light is left out")
        return []
    if light.type == "AREA":
        return _area(light, course, power, tinted, place, report)
    if is_facing(light):
        return _facing_disk(light, course, power, tinted, place, report)
    if light.type == "POINT" and light.shadow_soft_size > 0.0:
        ball = [_ball(light, course, power, tinted)]
        # Surfaces that scatter light do not find a lamp without Multiple Importance.
        return ball if is_found(light) else points(light, course, ball) or ball
    if course.keys:
        report.warn(place, _STANDS)
    if light.type == "SUN":
        return _sun(light, course.matrix, power, tinted)
    if light.type == "SPOT":
        return _spots(light, course.matrix, power, tinted, place, report)
    return [_point(course.matrix, power, tinted)]


def disks(light: Any, course: xml.Course, name: str, report: Report) -> list[xml.Element]:
    """Disk that faces what it lights, and that the camera does not see, for a lamp without Multiple Importance."""
    tinted = _tinted(light, f'light "{name}"', report)
    power = units.exposed(light.energy, getattr(light, "exposure", 0.0))
    return hide(_facing_disk(light, course, power, tinted, f'light "{name}"', report))


def hide(shapes: list[xml.Element]) -> list[xml.Element]:
    """Hides shapes from the camera."""
    return [xml.add(shape, "visible_to_camera", False) for shape in shapes]


def _tinted(light: Any, place: str, report: Report) -> Any:
    """Function that gives a lamp's color to a number."""
    color = tuple(a * b for a, b in zip(color_of(light), _shaded(light, place, report)))
    return lambda value: tuple(channel * value for channel in color)


_STANDS = "the motion of suns, spots and lamps of radius 0 is not supported; it stands still"


def corners(light: Any) -> list[tuple[float, float, float]]:
    """Corners that a lamp lies within, in its own space."""
    x = y = z = light.shadow_soft_size if light.type in ("POINT", "SPOT") else 0.0
    if light.type == "AREA":
        x, y = 0.5 * light.size, 0.5 * (light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size)
    return [(a * x, b * y, c * z) for a in (-1.0, 1.0) for b in (-1.0, 1.0) for c in (-1.0, 1.0)]


def is_soft(light: Any) -> bool:
    """Whether Cycles takes a lamp for a disk that faces each lit point."""
    return light.type in ("POINT", "SPOT") and light.shadow_soft_size > 0.0 and getattr(light, "use_soft_falloff", False)


def is_facing(light: Any) -> bool:
    """Whether a lamp becomes such a disk. Surfaces that scatter light would find it, so the lamp has Multiple Importance."""
    return is_soft(light) and is_found(light)


def is_found(light: Any) -> bool:
    """Whether rays of surfaces find a lamp, besides rays to it."""
    return getattr(getattr(light, "cycles", None), "use_multiple_importance_sampling", True)


def _report_unsupported(light: Any, place: str, report: Report) -> None:
    if not getattr(light, "normalize", True) and light.type in ("SUN", "SPOT") and not is_facing(light):
        report.warn(place, "a power that is not normalized by the area is not supported; it is taken as normalized")
    if getattr(light, "use_shadow", True) is False:
        report.warn(place, "light without shadows is not supported")


def _shaded(light: Any, place: str, report: Report) -> tuple[float, ...]:
    """Color by which a lamp's nodes multiply its light."""
    if not light.use_nodes or light.node_tree is None:
        return (1.0, 1.0, 1.0)
    output = light.node_tree.get_output_node("CYCLES") or light.node_tree.get_output_node("ALL")
    source = _source(output.inputs["Surface"]) if output is not None else None
    if source is None:
        return (0.0, 0.0, 0.0)
    if source.node.type == "EMISSION" and not source.node.mute:
        color, strength = (_constant(source.node.inputs[name]) for name in ("Color", "Strength"))
        if color is not None and strength is not None:
            return tuple(channel * strength[0] for channel in color)
    report.warn(place, "nodes of lights other than Emission with constants are not supported; color and power of the light are used")
    return (1.0, 1.0, 1.0)


def _source(socket: Any) -> Any:
    """Output that a socket is linked to, past reroutes; None where it has a value of its own."""
    while True:
        link = next((link for link in socket.links if link.is_valid and not link.is_muted), None)
        if link is None or link.from_node.type != "REROUTE":
            return link.from_socket if link is not None else None
        socket = link.from_node.inputs[0]


def _constant(socket: Any) -> Optional[tuple[float, ...]]:
    """Value of a socket, with one number or three; None where nodes that vary make it."""
    source = _source(socket)
    if source is not None and source.node.type == "BLACKBODY" and not source.node.mute:
        temperature = _constant(source.node.inputs["Temperature"])
        return units.blackbody(temperature[0]) if temperature is not None else None
    if source is not None and source.node.type == "LIGHT_FALLOFF" and source.name == "Quadratic" and not source.node.mute:
        # The falloff that light has by itself, unless it is smoothed.
        return _constant(source.node.inputs["Strength"]) if _constant(source.node.inputs["Smooth"]) == (0.0,) else None
    if source is not None and source.node.type not in ("RGB", "VALUE"):
        return None
    value = (source or socket).default_value
    return (float(value),) if isinstance(value, (int, float)) else tuple(float(channel) for channel in value[:3])


def _point(matrix: Any, power: float, tinted: Any) -> xml.Element:
    emitter = xml.plugin("emitter", "point")
    _add_point(emitter, "position", matrix.translation)
    return xml.add(emitter, "intensity", tinted(units.point_intensity(power)))


def _ball(light: Any, course: xml.Course, power: float, tinted: Any) -> xml.Element:
    """Point lamp with a radius, which no scale changes."""
    from mathutils import Matrix

    radius, center = light.shadow_soft_size, course.matrix.translation
    shape = xml.plugin("shape", "sphere")
    _add_point(shape, "center", center)
    xml.add(shape, "radius", float(radius))
    if course.keys:
        xml.add_course(shape, course.mapped(lambda matrix: Matrix.Translation(matrix.translation - center)))
    return _emitting(shape, tinted(_round_radiance(light, power)))


def _round_radiance(light: Any, power: float) -> float:
    """Radiance of a lamp with a radius: of a sphere, and of a disk that faces what it lights."""
    radius = light.shadow_soft_size
    if not getattr(light, "normalize", True):
        power *= 4.0 * math.pi * radius**2
    return units.sphere_radiance(power, radius)


def _facing_disk(light: Any, course: xml.Course, power: float, tinted: Any, place: str, report: Report) -> list[xml.Element]:
    """Lamp with soft falloff: a disk that faces what it lights. No scale changes its radius."""
    from mathutils import Matrix

    shape = xml.plugin("shape", "facingdisk")
    is_spot = light.type == "SPOT"
    emitter = xml.plugin("emitter", "spotarea" if is_spot else "area")
    if is_spot:
        if course.keys:
            report.warn(place, _STANDS)
        _report_scale(course.matrix, place, report)
        half_angle = 0.5 * light.spot_size
        xml.add(emitter, "cutoff_angle", math.degrees(half_angle))
        xml.add(emitter, "beam_width", math.degrees(units.smooth_beam(half_angle, light.spot_blend)))
        xml.add_matrix(shape, _facing(course.matrix, normalized=True))
    else:
        xml.add_course(shape, course.mapped(lambda matrix: Matrix.Translation(matrix.translation)))
    xml.add(shape, "radius", float(light.shadow_soft_size))
    return [xml.with_children(shape, xml.add(emitter, "radiance", tinted(_round_radiance(light, power))))]


def points(light: Any, course: xml.Course, emitters: list[xml.Element]) -> Optional[list[xml.Element]]:
    """Points without size, which no camera sees, in place of the emitters of a lamp with a radius; None where they cannot stand for it."""
    if light.type != "POINT" or course.keys:
        return None
    radiance = next(each for each in emitters[0].iter("rgb") if each.get("name") == "radiance").get("value", "")
    # A sphere of the radiance L has the intensity pi r^2 L.
    share = math.pi * light.shadow_soft_size**2 / BALL_PARTS
    intensity = tuple(float(channel) * share for channel in radiance.split())
    parts = []
    for place in units.ball_points(BALL_PARTS):
        emitter = xml.plugin("emitter", "point")
        _add_point(emitter, "position", course.matrix.translation + light.shadow_soft_size * _vector(place))
        xml.add(emitter, "intensity", intensity)
        parts.append(xml.add(emitter, "sampling_weight", 1.0 / BALL_PARTS))
    return parts


def _sun(light: Any, matrix: Any, power: float, tinted: Any) -> list[xml.Element]:
    """Directional lights that cover the sun's disk. One light where the disk is as good as a point."""
    count = SUN_PARTS if light.angle > math.radians(0.05) else 1
    parts = []
    rotation = matrix.to_3x3().normalized()
    irradiance = units.sun_irradiance(power, light.angle if count > 1 else 0.0)
    for direction in units.sun_directions(light.angle if count > 1 else 0.0, count):
        emitter = xml.plugin("emitter", "directional")
        _add_point(emitter, "direction", rotation @ _vector(direction), tag="vector")
        xml.add(emitter, "irradiance", tinted(irradiance / count))
        parts.append(xml.add(emitter, "sampling_weight", 1.0 / count))
    return parts


def _spots(light: Any, matrix: Any, power: float, tinted: Any, place: str, report: Report) -> list[xml.Element]:
    """Spot, or spots side by side that cover its ball. They all have its cone, as the points of Cycles' lamp have."""
    _report_scale(matrix, place, report)
    half_angle = 0.5 * light.spot_size
    beam = units.beam_width(half_angle, light.spot_blend)
    scale = units.spot_flux(half_angle, light.spot_blend) / units.linear_spot_flux(half_angle, beam)
    centers = units.ball_points(BALL_PARTS) if light.shadow_soft_size > 0.0 else [(0.0, 0.0, 0.0)]
    parts = []
    for center in centers:
        emitter = xml.plugin("emitter", "spot")
        xml.add(emitter, "cutoff_angle", math.degrees(half_angle))
        xml.add(emitter, "beam_width", math.degrees(beam))
        xml.add(emitter, "intensity", tinted(units.point_intensity(power) * scale / len(centers)))
        if len(centers) > 1:
            xml.add(emitter, "sampling_weight", 1.0 / len(centers))
        placed = _facing(matrix, normalized=True)
        placed.translation += light.shadow_soft_size * _vector(center)
        parts.append(xml.add_matrix(emitter, placed))
    return parts


def _report_scale(matrix: Any, place: str, report: Report) -> None:
    sides = [matrix.col[at].xyz.length for at in range(3)]
    if max(sides) > 1.001 * min(sides):
        report.warn(place, "a spot that is scaled unevenly is not supported; its cone is round")


def _area(light: Any, course: xml.Course, power: float, tinted: Any, place: str, report: Report) -> list[xml.Element]:
    if light.spread < math.pi - 1e-3:
        report.warn(place, "the spread of an area light is not supported; it shines to all sides")
    is_round = light.shape in ("DISK", "ELLIPSE")
    width = light.size
    height = light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else width
    x, y = (course.matrix.col[at].xyz.length * side for at, side in enumerate((width, height)))
    area = x * y * (0.25 * math.pi if is_round else 1.0)
    if area == 0.0:
        report.warn(place, "an area light of size 0 is not supported; it is left out")
        return []
    shape = xml.plugin("shape", "disk" if is_round else "rectangle")
    xml.add_course(shape, course.mapped(lambda matrix: _facing(matrix, (0.5 * width, 0.5 * height))))
    return [_emitting(shape, tinted(units.area_radiance(power, area if getattr(light, "normalize", True) else 1.0)))]


def _facing(matrix: Any, size: tuple[float, float] = (1.0, 1.0), normalized: bool = False) -> Any:
    """Transform of a lamp that shines along its own -z, for a shape that shines along +z: half a turn about x."""
    from mathutils import Matrix

    if normalized:
        matrix = Matrix.Translation(matrix.translation) @ matrix.to_3x3().normalized().to_4x4()
    return matrix @ Matrix.Diagonal((size[0], -size[1], -1.0, 1.0))


def _emitting(shape: xml.Element, radiance: Any) -> xml.Element:
    """Shape that shines, and lets all other light pass, as Blender's lamps do."""
    xml.with_children(shape, xml.plugin("bsdf", "null"))
    return xml.with_children(shape, xml.add(xml.plugin("emitter", "area"), "radiance", radiance))


def _add_point(parent: xml.Element, name: str, point: Any, tag: str = "point") -> None:
    values = {axis: xml.number(value) for axis, value in zip("xyz", point)}
    xml.with_children(parent, xml.ElementTree.Element(tag, {"name": name, **values}))


def _vector(values: tuple[float, float, float]) -> Any:
    from mathutils import Vector

    return Vector(values)
