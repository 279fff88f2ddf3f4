"""Nodes: following links through reroutes, groups and muted nodes, and reading what a socket gives."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, Optional, Union

from . import clipping
from .evaluator import Evaluator, convert
from .images import MISSING, Images, Texture, has_alpha
from .layouts import Layout
from .limits import excess
from .programs import Expression
from .report import Report

Color = tuple[float, float, float]
Value = Union[float, Color, Texture]
# Types of nodes of which each output is a quantity of its own.
QUANTITIES = {"TEX_COORD", "NEW_GEOMETRY", "OBJECT_INFO", "CAMERA", "HAIR_INFO"}
# Types of nodes that EEVEE alone knows. In Cycles, a socket that they are linked to takes its default value.
OF_EEVEE = {"SHADERTORGB", "EEVEE_SPECULAR"}


def is_unknown(node: Any) -> bool:
    """Whether Cycles does not know a node: one of EEVEE, or of an add-on that is not there."""
    return node.type in OF_EEVEE or node.bl_idname == "NodeUndefined"


class Source(NamedTuple):
    """Output of a node, with the group nodes that lead to it, from the outermost."""

    node: Any
    socket: Any
    groups: tuple[Any, ...]


class Placed(NamedTuple):
    """Object that has the material, in one place."""

    owner: Any
    matrix: Any
    random_id: int
    # Whether strands of the object have it.
    has_strands: bool = False


@dataclass
class Surroundings:
    """What nodes may ask for besides the material."""

    placed: Optional[Placed] = None
    camera: Any = None
    # Matrix from the world to the picture, whose sides are -1 and 1.
    projection: Any = None


@dataclass
class Reader:
    """Reads the sockets of one material or world."""

    place: str
    report: Report
    images: Images
    groups: tuple[Any, ...] = ()
    # Names of the UV map and of the color attribute that the material uses, where it names one.
    uv_maps: set[str] = field(default_factory=set)
    color_attributes: set[str] = field(default_factory=set)
    surroundings: Surroundings = field(default_factory=Surroundings)
    # Blender's material; None for a world.
    material: Any = None
    # Heights of the material's displacement that are rendered as relief, with their factors.
    heights: list[tuple[float, Texture]] = field(default_factory=list)
    # Whether a node has asked for the object, and whether a displacement has asked for its scale.
    asks_for_object: bool = False
    asks_for_scale: bool = False
    # Whether Bump Map Correction is on.
    corrects_normals: bool = True
    # Quantities of strands that nodes have asked for, and whether the material differs between strands and surfaces.
    asked_of_strands: set[str] = field(default_factory=set)
    asks_for_strands: bool = False
    # What texture coordinates of strands carry; None where they are texture coordinates.
    layout: Optional[Layout] = None

    def __post_init__(self) -> None:
        self.evaluator = Evaluator(self, self.images.graph)

    @property
    def has_strands(self) -> bool:
        """Whether strands have the material."""
        return self.surroundings.placed is not None and self.surroundings.placed.has_strands

    def of_strands(self, quantity: str) -> Optional[Expression]:
        """Quantity of strands, by the layout; None where texture coordinates carry it not."""
        self.asked_of_strands.add(quantity)
        return None if self.layout is None else self.layout.value(self.images.graph, quantity)

    def placed(self) -> Optional[Placed]:
        """Object that has the material; None for a world."""
        self.asks_for_object = True
        return self.surroundings.placed

    def scales(self) -> Optional[list[float]]:
        """Scales of the object that has the material along its axes; None for a world."""
        self.asks_for_scale = True
        placed = self.surroundings.placed
        return None if placed is None else [abs(scale) for scale in placed.matrix.to_scale()]

    def warn(self, message: str) -> None:
        """Reports something about this material or world."""
        self.report.warn(self.place, message)

    # ---------------------------------------------------------------------------------------------------- links

    def source(self, socket: Any, groups: tuple[Any, ...]) -> Optional[Source]:
        """Output that a socket is linked to; None where it has a value of its own."""
        while True:
            link = next((link for link in socket.links if link.is_valid and not link.is_muted), None)
            if link is None:
                return None
            node, output = link.from_node, link.from_socket
            if node.type == "REROUTE":
                socket = node.inputs[0]
            elif node.mute:
                passed = next((l for l in node.internal_links if l.to_socket == output), None)
                if passed is None:
                    return None
                socket = passed.from_socket
            elif node.type == "GROUP" and node.node_tree is not None:
                inner = next((n for n in node.node_tree.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output), None)
                found = inner and next((s for s in inner.inputs if s.identifier == output.identifier), None)
                if found is None:
                    return None
                socket, groups = found, (*groups, node)
                if not socket.is_linked:
                    return Source(None, socket, groups)
            elif node.type == "GROUP_INPUT" and groups:
                outer = next((s for s in groups[-1].inputs if s.identifier == output.identifier), None)
                if outer is None:
                    return None
                socket, groups = outer, groups[:-1]
                if not socket.is_linked:
                    return Source(None, socket, groups)
            else:
                return Source(node, output, groups)

    def unsupported(self, node: Any, use: str, output: Any = None) -> None:
        """Reports a node that is not translated, or its output where its other outputs are."""
        named = f'the node "{node.name}" ({node.bl_label})'
        if output is not None and node.type in QUANTITIES:
            named = f"the output {output.name} of {named}"
        if is_unknown(node):
            whose = "EEVEE's alone" if node.type in OF_EEVEE else "of an unknown kind"
            self.report.note(self.place, f"{named} is {whose}; {use} takes its default value, as in Cycles")
            return
        self.warn(f"{named} is not supported; {use} takes its default value")

    # --------------------------------------------------------------------------------------------------- values

    def color(self, socket: Any, groups: tuple[Any, ...]) -> Union[Color, Texture]:
        """Color of a socket: a constant or a texture."""
        value = self._value(socket, groups)
        return (value, value, value) if isinstance(value, float) else value

    def scalar(self, socket: Any, groups: tuple[Any, ...]) -> Union[float, Texture]:
        """Number of a socket: a constant or a texture, of which the luminance counts."""
        value = self._value(socket, groups)
        if isinstance(value, tuple):
            return 0.2126 * value[0] + 0.7152 * value[1] + 0.0722 * value[2]
        if isinstance(value, Texture) and value.attribute is not None:
            self.warn(f'the attribute "{value.attribute}" as a number is not supported; {socket.name} takes its default value')
            return _number(_default(socket))
        return value

    def constant(self, socket: Any, groups: tuple[Any, ...]) -> float:
        """Number of a socket that must be a constant."""
        value = self.scalar(socket, groups)
        if isinstance(value, Texture):
            self.warn(f"a texture of {socket.name} is not supported; its default value is used")
            return float(socket.default_value)
        return value

    def constant_color(self, socket: Any, groups: tuple[Any, ...]) -> Color:
        """Color of a socket that must be a constant."""
        value = self.color(socket, groups)
        if isinstance(value, Texture):
            self.warn(f"a texture of {socket.name} is not supported; its default value is used")
            return _default(socket)
        return value

    def _value(self, socket: Any, groups: tuple[Any, ...]) -> Value:
        source = self.source(socket, groups)
        if source is None:
            return _default(socket)
        if source.node is None:
            return _default(source.socket)
        found = self._translated(source)
        if found is None:
            found = self._computed(source, socket)
        if found is None:
            self.unsupported(source.node, socket.name, source.socket)
            return _default(socket)
        return found

    def _computed(self, source: Source, socket: Any) -> Optional[Value]:
        """Value of an output by a program; None where a program cannot say it."""
        limit = sys.getrecursionlimit()
        # Each node in a chain takes three calls or four.
        sys.setrecursionlimit(max(limit, 100_000))
        try:
            found = self.evaluator.output(source.node, source.socket, source.groups)
        finally:
            sys.setrecursionlimit(limit)
        if found is None:
            return None
        found = convert(found, source.socket.type, socket.type)
        if not found.is_constant:
            too_much = excess(found)
            if too_much is None:
                return Texture(program=found)
            self.warn(f'the node "{source.node.name}" ({source.node.bl_label}) needs {too_much}; {socket.name} takes its default value')
            return _default(socket)
        return found.constant[0] if socket.type == "VALUE" else found.constant

    def _translated(self, source: Source) -> Optional[Value]:
        node, groups = source.node, source.groups
        if node.type in ("RGB", "VALUE"):
            return _default(source.socket)
        if node.type == "TEX_IMAGE" and self.is_missing(node):
            if node.image is not None and node.extension == "CLIP":
                return None
            return 1.0 if source.socket.name == "Alpha" else MISSING
        if node.type == "TEX_IMAGE":
            return self.image_texture(node, "alpha" if source.socket.name == "Alpha" else "color", groups)
        if node.type in ("ATTRIBUTE", "VERTEX_COLOR"):
            return self._attribute(node, source.socket.name)
        if node.type == "INVERT":
            inner = self._value(node.inputs["Color"], groups)
            share = self.scalar(node.inputs["Fac"], groups)
            return self._inverted(inner) if share == 1.0 else None
        if node.type in ("SEPARATE_COLOR", "SEPRGB"):
            if getattr(node, "mode", "RGB") != "RGB":
                return None
            inner = self._value(node.inputs[0], groups)
            channel = [output.name for output in node.outputs].index(source.socket.name)
            if isinstance(inner, tuple):
                return inner[channel]
            if isinstance(inner, Texture) and inner.image is not None:
                return inner.with_operation("rgb"[channel])
        return None

    def as_program(self, texture: Texture) -> Expression:
        """Texture as an expression; an image lies on the UV map."""
        if texture.program is not None:
            return texture.program * texture.factor
        graph = self.images.graph
        flat = replace(texture, factor=(1.0, 1.0, 1.0))
        return graph.bitmap((texture.image.name_full, flat), self.images.element(flat), graph.source("uv")) * texture.factor

    @staticmethod
    def _inverted(value: Value) -> Optional[Value]:
        if isinstance(value, tuple):
            return tuple(1.0 - channel for channel in value)  # type: ignore[return-value]
        if isinstance(value, float):
            return 1.0 - value
        return value.with_operation("invert") if value.image is not None else None

    def _attribute(self, node: Any, output: str) -> Optional[Value]:
        if output not in ("Color", "Fac", "Factor"):
            return None
        if node.type == "ATTRIBUTE" and node.attribute_type != "GEOMETRY":
            return None
        name = node.layer_name if node.type == "VERTEX_COLOR" else node.attribute_name
        self.color_attributes.add(name)
        return Texture.of_vertices(name)

    # ------------------------------------------------------------------------------------------------- textures

    def image_texture(self, node: Any, channel: str, groups: tuple[Any, ...]) -> Optional[Texture]:
        """Texture of an Image Texture node on the UV map; None where it is another or lies otherwise."""
        to_uv = self.uv_transform(node.inputs["Vector"], groups)
        if to_uv is None:
            return None
        self.asked_of_strands.add("uv")
        if self.layout is not None or node.extension == "CLIP" and not self._lies_within(node, to_uv, groups):
            return None
        texture = self.plain_image(node, channel)
        return None if texture is None else replace(texture, to_uv=to_uv)

    def _lies_within(self, node: Any, to_uv: tuple[tuple[float, ...], ...], groups: tuple[Any, ...]) -> bool:
        """Whether all that has the material lies within an image of it."""
        source = self.source(node.inputs["Vector"], groups)
        while source is not None and source.node is not None and source.node.type == "MAPPING":
            source = self.source(source.node.inputs["Vector"], source.groups)
        uv_map = source.node.uv_map if source is not None and source.node is not None and source.node.type == "UVMAP" else ""
        return self.material is not None and not self.has_strands and clipping.lies_within(self.material, uv_map, to_uv)

    def is_missing(self, node: Any) -> bool:
        """Whether the node of an image has none that can be loaded. Cycles then shows magenta."""
        image = node.image
        if image is None:
            return True
        if image.source not in ("FILE", "GENERATED") or image.has_data or len(image.pixels) > 0:
            return False
        self.report.note(self.place, f'the image "{image.name}" cannot be loaded; it is magenta, as in Cycles')
        return True

    def plain_image(self, node: Any, channel: str) -> Optional[Texture]:
        """Texture of an Image Texture node, wherever it lies; None where it cannot be translated."""
        image = node.image
        if image is None or image.source in ("SEQUENCE", "MOVIE", "TILED", "VIEWER"):
            return None
        if node.projection != "FLAT":
            return None
        wrap = {"REPEAT": "repeat", "MIRROR": "mirror"}.get(node.extension, "clamp")
        interpolation = "nearest" if node.interpolation == "Closest" else "bilinear"
        texture = Texture(image=image, operations=(channel,), wrap=wrap, interpolation=interpolation)
        if channel == "color" and _is_premultiplied(node):
            # Cycles multiplies the bytes, before it undoes the sRGB curve.
            return texture.with_operation("premultiplied" if image.colorspace_settings.name == "sRGB" else "covered")
        return texture

    def uv_transform(self, socket: Any, groups: tuple[Any, ...]) -> Optional[tuple[tuple[float, ...], ...]]:
        """Matrix of three rows from the mesh's UVs to those of a texture; None where they are not made of UVs."""
        from mathutils import Matrix

        matrix = Matrix.Identity(4)
        source = self.source(socket, groups)
        while source is not None and source.node is not None and source.node.type == "MAPPING":
            step = self.mapping_matrix(source.node, source.groups)
            if step is None:
                return None
            matrix = matrix @ step
            source = self.source(source.node.inputs["Vector"], source.groups)
        if source is not None:
            node = source.node
            if node is None or not (
                node.type == "UVMAP" or (node.type == "TEX_COORD" and source.socket.name == "UV")
            ):
                return None
            if node.type == "UVMAP" and node.uv_map:
                self.uv_maps.add(node.uv_map)
        a, b, c, d = matrix[0][0], matrix[0][1], matrix[1][0], matrix[1][1]
        return ((a, b, matrix[0][3]), (c, d, matrix[1][3]), (0.0, 0.0, 1.0))

    def mapping_matrix(self, node: Any, groups: tuple[Any, ...]) -> Any:
        """Matrix of a Mapping node; None where its values are linked."""
        from mathutils import Euler, Matrix, Vector

        if any(self.source(s, groups) for s in node.inputs if s.name != "Vector"):
            return None
        get = lambda name: node.inputs[name].default_value if name in node.inputs else (0.0, 0.0, 0.0)  # noqa: E731
        location = Matrix.Translation(Vector(get("Location")))
        rotation = Euler(get("Rotation"), "XYZ").to_matrix().to_4x4()
        scale = Matrix.Diagonal((*get("Scale"), 1.0))
        if node.vector_type == "POINT":
            return location @ rotation @ scale
        if node.vector_type == "VECTOR":
            return rotation @ scale
        if node.vector_type == "TEXTURE":
            try:
                return (location @ rotation @ scale).inverted()
            except ValueError:
                return None
        return None


def _is_premultiplied(node: Any) -> bool:
    """Whether the color of an Image Texture node is that of the image times alpha: Cycles keeps images so, and divides by alpha only
    where the node's Alpha is linked, too."""
    image = node.image
    is_color = image.alpha_mode in ("STRAIGHT", "PREMUL") and image.colorspace_settings.name not in ("Non-Color", "Raw")
    return is_color and has_alpha(image) and not image.is_float and not node.outputs["Alpha"].is_linked


def _number(value: Value) -> float:
    return sum(value) / 3.0 if isinstance(value, tuple) else float(value)  # type: ignore[arg-type]


def _default(socket: Any) -> Value:
    value = getattr(socket, "default_value", 0.0)
    if hasattr(value, "__len__"):
        return (float(value[0]), float(value[1]), float(value[2]))
    return float(value)
