"""Nodes that bring values in: coordinates, geometry, facts of the object, images and constants."""

from __future__ import annotations

from typing import Any, Optional

from .evaluator import Evaluator, Groups, Handler
from .images import MISSING
from .programs import (
    Expression, absolute, clamp, dot, less, maximum, minimum, normalized, permuted, positive, power, select, square_root,
)

# Blender's v runs upwards, that of the renderer downwards.
FLIP = ((1.0, 0.0, 0.0, 0.0), (0.0, -1.0, 0.0, 1.0), (0.0, 0.0, 1.0, 0.0))


def _rows(matrix: Any) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(float(value) for value in row) for row in matrix[:3])


def uv(e: Evaluator) -> Expression:
    """Coordinates of the UV map; those of its root on a strand."""
    found = e.reader.of_strands("uv")
    if found is not None:
        return found
    return e.graph.transformed(e.graph.source("uv"), FLIP)


def position(e: Evaluator) -> Expression:
    """Position in the world."""
    return e.graph.source("position")


def incoming(e: Evaluator) -> Expression:
    """Direction to where the surface is seen from."""
    return e.graph.source("incoming")


def backfacing(e: Evaluator) -> Expression:
    """1 where the back of the surface is seen, else 0."""
    return less(dot(e.graph.source("normal"), incoming(e)), 0.0)


def normal(e: Evaluator, source: str = "shading_normal") -> Expression:
    """Normal on the side that is seen."""
    return e.graph.source(source) * (1.0 - 2.0 * backfacing(e))


def in_object(e: Evaluator, other: Any = None) -> Optional[Expression]:
    """Coordinates in an object's space; None where there is no object."""
    place = other if other is not None else e.reader.placed()
    if place is None:
        return None
    matrix = place.matrix_world if other is not None else place.matrix
    return e.graph.transformed(position(e), _rows(matrix.inverted_safe()))


def generated(e: Evaluator) -> Expression:
    """Coordinates from 0 to 1 in the object's texture space; the position where there is no object."""
    place = e.reader.placed()
    if place is None:
        return position(e)
    if place.has_strands:
        return _generated_of_strands(e, place.owner)
    data = place.owner.data
    center = getattr(data, "texspace_location", (0.0, 0.0, 0.0))
    sizes = getattr(data, "texspace_size", (1.0, 1.0, 1.0))
    scales = [0.5 / size if size != 0.0 else 0.0 for size in sizes]
    rows = tuple(
        tuple(scales[row] if column == row else 0.0 for column in range(3)) + (0.5 - center[row] * scales[row],) for row in range(3)
    )
    return e.graph.transformed(e.graph.transformed(position(e), _rows(place.matrix.inverted_safe())), rows)


def _generated_of_strands(e: Evaluator, owner: Any) -> Expression:
    """Coordinates of the root. In Cycles, hair curves have those in the object's space."""
    if owner.type == "CURVES":
        return in_object(e)  # type: ignore[return-value]
    found = e.reader.of_strands("generated")
    if found is None and e.reader.layout is not None:
        e.reader.warn("Generated coordinates of strands beside image textures and numbers by chance are not supported; they are 0.5")
    return found if found is not None else e.graph.constant(0.5)


def _hair_info(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    e.reader.asks_for_strands = True
    has_strands = e.reader.has_strands
    if output.name == "Is Strand" or not has_strands:
        return e.graph.constant(1.0 if has_strands else 0.0)
    if output.name not in ("Intercept", "Random"):
        return None
    found = e.reader.of_strands(output.name.lower())
    # Before it is known what is asked for, any value does.
    return e.graph.constant(0.5) if found is None and e.reader.layout is None else found


def _texture_coordinate(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    if node.from_instancer:
        return None
    name = output.name
    if name == "UV":
        return uv(e)
    if name == "Generated":
        return generated(e)
    if name == "Object":
        return in_object(e, node.object)
    if name == "Normal" and e.reader.placed() is not None:
        turned = e.graph.transformed(normal(e), _rows(e.reader.placed().matrix.to_3x3().transposed().to_4x4()))
        return normalized(turned)
    if name == "Camera":
        return _in_camera(e)
    if name == "Window":
        return _in_window(e)
    if name == "Reflection":
        n = normal(e)
        return n * (2.0 * dot(n, incoming(e))) - incoming(e)
    return None


def _in_camera(e: Evaluator) -> Optional[Expression]:
    camera = e.reader.surroundings.camera
    if camera is None:
        return None
    rows = _rows(camera.matrix_world.normalized().inverted_safe())
    return e.graph.transformed(position(e), (rows[0], rows[1], tuple(-value for value in rows[2])))


def _in_window(e: Evaluator) -> Optional[Expression]:
    projection = e.reader.surroundings.projection
    if projection is None:
        return None
    x, y, w = (tuple(float(value) for value in projection[row]) for row in (0, 1, 3))
    clip = e.graph.transformed(position(e), (x, y, w))
    return clip / permuted(clip, (2, 2, 2)) * (0.5, 0.5, 0.0) + (0.5, 0.5, 0.0)


def _geometry(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    values = {
        "Position": lambda: position(e),
        "Normal": lambda: normal(e),
        "True Normal": lambda: normal(e, "normal"),
        "Incoming": lambda: incoming(e),
        "Backfacing": lambda: backfacing(e),
    }
    return values[output.name]() if output.name in values else None


def _uv_map(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    if node.from_instancer:
        return None
    if node.uv_map:
        e.reader.uv_maps.add(node.uv_map)
    return uv(e)


def _object_info(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    place = e.reader.placed()
    if place is None:
        return None
    owner = place.owner
    values = {
        "Location": lambda: list(place.matrix.translation),
        "Color": lambda: list(owner.color)[:3],
        "Alpha": lambda: owner.color[3],
        "Object Index": lambda: float(owner.pass_index),
        "Material Index": lambda: float(e.reader.material.pass_index if e.reader.material is not None else 0),
        "Random": lambda: (place.random_id & 0xFFFFFFFF) / 4294967295.0,
    }
    return e.graph.constant(values[output.name]()) if output.name in values else None


def _camera_data(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    view = _in_camera(e)
    if view is None:
        return None
    if output.name == "View Z Depth":
        return absolute(view.z)
    if output.name == "View Distance":
        return square_root(dot(view, view))
    return normalized(view) if output.name == "View Vector" else None


def _fresnel_of(cosine: Expression, eta: Expression) -> Expression:
    """Reflectance of a dielectric."""
    c = absolute(cosine)
    squared = eta * eta - 1.0 + c * c
    g = square_root(squared)
    a = (g - c) / (g + c)
    b = (c * (g + c) - 1.0) / (c * (g - c) + 1.0)
    return select(positive(squared), 0.5 * a * a * (1.0 + b * b), 1.0)


def _has_normal(e: Evaluator, node: Any, groups: Groups) -> bool:
    socket = node.inputs.get("Normal")
    return socket is not None and e.reader.source(socket, groups) is not None


def _fresnel(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    if _has_normal(e, node, groups):
        e.reader.warn(f'the node "{node.name}" ({node.bl_label}) takes the normal of the surface, not that of its Normal socket')
    eta = maximum(e.input(node, groups, "IOR"), 1e-5)
    return _fresnel_of(dot(normal(e), incoming(e)), select(backfacing(e), 1.0 / eta, eta))


def _layer_weight(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    if _has_normal(e, node, groups):
        e.reader.warn(f'the node "{node.name}" ({node.bl_label}) takes the normal of the surface, not that of its Normal socket')
    blend = e.input(node, groups, "Blend")
    cosine = dot(normal(e), incoming(e))
    if output.name == "Fresnel":
        eta = maximum(1.0 - blend, 1e-5)
        return _fresnel_of(cosine, select(backfacing(e), eta, 1.0 / eta))
    bounded = maximum(blend, 0.0)
    bounded = bounded.graph.of("minimum", a=bounded, b=1.0 - 1e-5)
    exponent = select(less(bounded, 0.5), 2.0 * bounded, 0.5 / (1.0 - bounded))
    return 1.0 - power(absolute(cosine), exponent)


def _image(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    if e.reader.is_missing(node):
        found = e.graph.constant(1.0 if output.name == "Alpha" else MISSING)
        is_clipped = node.image is not None and node.extension == "CLIP"
        return found * _within(node, output, e.value(node.inputs["Vector"], groups, lambda: uv(e))) if is_clipped else found
    texture = e.reader.plain_image(node, "alpha" if output.name == "Alpha" else "color")
    if texture is None:
        return None
    at = e.value(node.inputs["Vector"], groups, lambda: uv(e))
    key = (texture.image.name_full, texture.operations, texture.wrap, texture.interpolation)
    found = e.graph.bitmap(key, e.reader.images.element(texture), e.graph.transformed(at, FLIP))
    return found * _within(node, output, at) if node.extension == "CLIP" else found


def _within(node: Any, output: Any, at: Expression) -> Expression:
    """1 within an image that is clipped, and 0 outside. Between texels inside and outside, an interpolated image fades."""
    if node.interpolation == "Closest":
        outside = maximum(less(at, 0.0), less(at.graph.constant(1.0), at))
        return 1.0 - maximum(outside.x, outside.y)
    # In Cycles, an image that is missing has one texel.
    size = at.graph.constant([max(side, 1.0) for side in node.image.size] + [1.0])
    edges = clamp(minimum(at * size + 0.5, (1.0 - at) * size + 0.5))
    found = edges.x * edges.y
    # Cycles divides colors by an alpha that is linked, but those of data.
    is_divided = output.name == "Color" and node.outputs["Alpha"].is_linked
    if is_divided and node.image.colorspace_settings.name not in ("Non-Color", "Raw") and node.image.alpha_mode in ("STRAIGHT", "PREMUL"):
        return less(at.graph.constant(0.0), found)
    return found


def _constant(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    return e.default(output)


HANDLERS: dict[str, Handler] = {
    "TEX_COORD": _texture_coordinate,
    "NEW_GEOMETRY": _geometry,
    "UVMAP": _uv_map,
    "OBJECT_INFO": _object_info,
    "CAMERA": _camera_data,
    "HAIR_INFO": _hair_info,
    "FRESNEL": _fresnel,
    "LAYER_WEIGHT": _layer_weight,
    "TEX_IMAGE": _image,
    "RGB": _constant,
    "VALUE": _constant,
}
