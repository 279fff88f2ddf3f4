"""World: the background as a constant, an image of the environment or a sky."""

from __future__ import annotations

from typing import Any, Optional

from . import sky, sky_fits, volumes, xml
from .images import MISSING, Images, Texture
from .nodes import Reader
from .report import Report
from .volumes import Volume

# Columns are the axes of Mitsuba's environment in Blender's: its y is up, and the middle of its image lies along Blender's +x.
ENVIRONMENT = ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))


def export(world: Any, images: Images, report: Report) -> Optional[xml.Element]:
    """Emitter of a world; None where it is black."""
    if world is None:
        return None
    reader = Reader(f'world "{world.name}"', report, images)
    if world.node_tree is None or not world.use_nodes:
        return _constant(tuple(world.color))
    output = world.node_tree.get_output_node("CYCLES") or world.node_tree.get_output_node("ALL")
    if output is None:
        return None
    source = reader.source(output.inputs["Surface"], ())
    if source is None or source.node is None:
        return None
    node, groups = source.node, source.groups
    if node.type != "BACKGROUND":
        reader.warn(f'the node "{node.name}" ({node.bl_label}) is not supported; the world is black')
        return None
    strength = reader.constant(node.inputs["Strength"], groups)
    if strength <= 0.0:
        return None
    color = reader.source(node.inputs["Color"], groups)
    kinds = {"TEX_ENVIRONMENT": _environment, "TEX_SKY": _sky}
    is_picture = color is not None and color.node is not None and color.node.type in kinds
    if is_picture:
        found = kinds[color.node.type](color.node, color.groups, strength, reader)
        if found is not None:
            return found
        reader.unsupported(color.node, "Color")
    value = tuple(node.inputs["Color"].default_value)[:3]
    if not is_picture:
        value = reader.color(node.inputs["Color"], groups)
    if isinstance(value, Texture):
        kind = "an image without the projection of an environment" if value.program is None else "a computed color of the world"
        reader.warn(f"{kind} is not supported; the default value is used")
        value = tuple(node.inputs["Color"].default_value)[:3]
    return _constant(tuple(channel * strength for channel in value))


def volume(world: Any, images: Images, report: Report) -> Volume:
    """Volume that fills the space between all objects."""
    if world is None or world.node_tree is None or not world.use_nodes:
        return Volume()
    output = world.node_tree.get_output_node("CYCLES") or world.node_tree.get_output_node("ALL")
    reader = Reader(f'world "{world.name}"', report, images)
    return (output and volumes.translate(reader, output.inputs["Volume"], None)) or Volume()


def _constant(color: tuple[float, ...]) -> Optional[xml.Element]:
    if max(color) <= 0.0:
        return None
    return xml.add(xml.plugin("emitter", "constant"), "radiance", color)


def constant_color(environment: Optional[xml.Element]) -> Optional[tuple[float, ...]]:
    """Color of a world that has one color; None where it has more."""
    if environment is None:
        return (0.0, 0.0, 0.0)
    if environment.get("type") != "constant":
        return None
    return tuple(float(channel) for channel in next(child.get("value", "") for child in environment).split())


def of_picture(path: str) -> xml.Element:
    """Emitter of a picture as Sky Textures have it."""
    from mathutils import Matrix

    return _picture(path, 1.0, Matrix.Identity(3))


def _environment(node: Any, groups: tuple[Any, ...], strength: float, reader: Reader) -> Optional[xml.Element]:
    """`envmap` of an Environment Texture; None where it cannot be translated."""
    image = node.image
    if reader.is_missing(node):
        return _constant(tuple(channel * strength for channel in MISSING))
    if image.source not in ("FILE", "GENERATED") or node.projection != "EQUIRECTANGULAR":
        return None
    rotation = _rotation(node.inputs["Vector"], groups, reader)
    if rotation is None:
        return None
    path, _ = reader.images.file(image, ("color", "environment"))
    return _picture(path, strength, rotation)


def _sky(node: Any, groups: tuple[Any, ...], strength: float, reader: Reader) -> Optional[xml.Element]:
    """`envmap` of a Sky Texture; None where it cannot be translated."""
    from mathutils import Matrix

    fit = sky_fits.of_node(node)
    if fit is not None:
        rotation = _rotation(node.inputs["Vector"], groups, reader)
        if rotation is None:
            return None
        return _picture(reader.images.written(sky_fits.picture(fit)), strength, rotation)
    found = sky.of_node(node)
    if found is None:
        return None
    return _picture(reader.images.written(sky.picture(found)), strength, Matrix.Identity(3))


def _picture(path: str, strength: float, rotation: Any) -> xml.Element:
    emitter = xml.add(xml.plugin("emitter", "envmap"), "filename", path)
    xml.add(emitter, "scale", strength)
    return xml.add_matrix(emitter, [[*row, 0.0] for row in to_world(rotation)] + [[0.0, 0.0, 0.0, 1.0]])


def to_world(rotation: Any) -> Any:
    """Turn of the environment whose image is looked up along `rotation` times a direction."""
    from mathutils import Matrix

    return rotation.transposed() @ Matrix(ENVIRONMENT)


def _rotation(socket: Any, groups: tuple[Any, ...], reader: Reader) -> Any:
    """Turn of directions by Mapping nodes; None where other nodes make the coordinates."""
    from mathutils import Matrix

    matrix = Matrix.Identity(3)
    source = reader.source(socket, groups)
    while source is not None and source.node is not None and source.node.type == "MAPPING":
        step = reader.mapping_matrix(source.node, source.groups)
        if step is None:
            return None
        linear = step.to_3x3()
        turn = linear.normalized()
        is_turn = max(abs(value - other) for a, b in zip(linear, turn) for value, other in zip(a, b)) < 1e-4
        if not is_turn or step.translation.length > 1e-6:
            reader.warn("location and scale of an environment's Mapping are not supported; its rotation is used")
        matrix = matrix @ turn
        source = reader.source(source.node.inputs["Vector"], source.groups)
    if source is None:
        return matrix
    is_direction = source.node is not None and source.node.type in ("TEX_COORD", "NEW_GEOMETRY")
    return matrix if is_direction and source.socket.name in ("Generated", "Position") else None
