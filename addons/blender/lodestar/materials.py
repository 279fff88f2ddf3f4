"""Materials: a tree of shader nodes as a BSDF and a radiance that the surface sheds."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Optional, Union

from . import facets, hair_shaders, principled, subsurface, volumes, xml
from .images import Images, Texture
from .layouts import Layout, layout
from .nodes import Color, Reader, Surroundings, is_unknown
from .report import Report
from .volumes import Volume

Emission = Union[Color, Texture, None]
Groups = tuple[Any, ...]
BLACK: Color = (0.0, 0.0, 0.0)
DEFAULT: Color = (0.8, 0.8, 0.8)


@dataclass
class Closure:
    """Scattering and emission of a shader. A missing BSDF scatters nothing."""

    bsdf: Optional[xml.Element] = None
    emission: Emission = None
    # Medium below the surface, whose front has the BSDF.
    below: Optional[Volume] = None


@dataclass
class Material:
    """Material as shapes use it."""

    bsdf: Optional[xml.Element]
    emission: Optional[xml.Element]
    uv_map: Optional[str]
    color_attribute: Optional[str]
    is_glass: bool  # whether it is glass, through which light of points and suns is not found
    asks_for_object: bool = False  # whether it differs from object to object
    asks_for_scale: bool = False  # whether it differs between scales of objects
    volume: Optional[Volume] = None  # within the object
    below: Optional[Volume] = None  # below the surface, in the place of the volume
    asks_for_smoke: bool = False  # whether the volume may take grids of a fluid domain
    asks_for_strands: bool = False  # whether it differs between strands and surfaces
    layout: Optional[Layout] = None  # what texture coordinates of its strands carry, where they are none
    asks_for_uv: bool = False  # whether textures lie on a UV map

    @property
    def is_fiber(self) -> bool:
        """Whether strands need texture coordinates that rise around and along them."""
        return self.bsdf is not None and any(bsdf.get("type") == "hair" for bsdf in self.bsdf.iter("bsdf"))


def translate(material: Any, images: Images, report: Report, surroundings: Surroundings) -> Material:
    """Translates a material; None stands for Blender's default."""
    if material is None:
        return Material(principled.default(images), None, None, None, False)
    reader = _reader(material, images, report, surroundings)
    found = _translated(material, reader)
    needed = layout(reader.asked_of_strands, found.is_fiber) if reader.has_strands else None
    if needed is None:
        return found
    # Now it is known what texture coordinates of strands have to carry.
    reader = _reader(material, images, report, surroundings)
    reader.layout = needed
    return _translated(material, reader)


def _reader(material: Any, images: Images, report: Report, surroundings: Surroundings) -> Reader:
    return Reader(f'material "{material.name}"', report, images, surroundings=surroundings, material=material)


def _translated(material: Any, reader: Reader) -> Material:
    images = reader.images
    reader.corrects_normals = getattr(material.cycles, "use_bump_map_correction", True)
    tree = material.node_tree
    if tree is None or not material.use_nodes:
        return Material(diffuse(images, tuple(material.diffuse_color)[:3]), None, None, None, False)
    output = tree.get_output_node("CYCLES") or tree.get_output_node("ALL")
    closure, volume = Closure(), None
    if output is not None:
        translator = _Translator(reader)
        reader.heights = _displacement(reader, material, output.inputs["Displacement"])
        closure = _of_both_sides(translator, output.inputs["Surface"])
        volume = volumes.translate(reader, output.inputs["Volume"], None)
        if volume is not None and reader.source(output.inputs["Surface"], ()) is None:
            closure.bsdf = xml.plugin("bsdf", "null")
        if closure.below is not None and volume is not None:
            reader.warn("a volume below subsurface is not supported; it is left out")
    for kind, names in (("UV map", reader.uv_maps), ("color attribute", reader.color_attributes)):
        if len(names) > 1:
            reader.warn(f"more than one {kind} in a material is not supported; {min(names)} is used")
    element = closure.bsdf if closure.bsdf is not None else diffuse(images, BLACK)
    emission = _radiance(closure.emission, images)
    kinds = _kinds_of_textures(element, images) | (_kinds_of_textures(emission, images) if emission is not None else set())
    if "mesh_attribute" in kinds and len(kinds) > 1:
        reader.warn("a color attribute beside other textures is not supported; the color is white")
        _whiten(element)
        if emission is not None:
            _whiten(emission)
        reader.color_attributes.clear()
    # Before 4.2, the setting is one of Cycles.
    casts_holes = getattr(material, "use_transparent_shadow", getattr(material.cycles, "use_transparent_shadow", True))
    if not casts_holes and any(bsdf.get("type") in ("mask", "null") for bsdf in element.iter("bsdf")):
        reader.warn("Transparent Shadows that are off are not supported; light passes where the surface is transparent")
    is_glass = closure.below is None and any(b.get("type") in ("dielectric", "roughdielectric") for b in element.iter("bsdf"))
    return Material(
        element,
        emission,
        min(reader.uv_maps, default=None),
        min(reader.color_attributes, default=None),
        is_glass,
        reader.asks_for_object,
        reader.asks_for_scale,
        volume,
        closure.below,
        output is not None and volumes.asks_for_grids(output.inputs["Volume"]),
        reader.asks_for_strands,
        reader.layout,
        "uv" in reader.asked_of_strands,
    )


def _of_both_sides(translator: _Translator, socket: Any) -> Closure:
    closure = translator.shader(socket, ())
    if closure.below is None or closure.bsdf is None:
        return closure
    # Light passes strands from behind.
    translator.reader.asks_for_strands = True
    if translator.reader.has_strands:
        translator.reader.warn("subsurface of strands is not supported; they are diffuse")
        translator.has_subsurface = False
        return translator.shader(socket, ())
    covered = subsurface.around(closure.bsdf)
    if covered is None:
        translator.reader.warn("subsurface beside holes is not supported; the surface is diffuse")
        translator.has_subsurface = False
        return translator.shader(socket, ())
    return replace(closure, bsdf=covered)


def _kinds_of_textures(element: xml.Element, images: Images) -> set[str]:
    """Kinds of a BSDF's or an emitter's textures that need texture coordinates, in whose place a mesh's colors have others. A relief has slopes
    along them, whatever it is computed from."""
    has_relief = any(bsdf.get("type") in ("bumpmap", "normalmap") for bsdf in element.iter("bsdf"))
    kinds = {texture.get("type", "") for texture in element.iter("texture")} - {"scale"}
    if any(has_relief or images.graph.reads_uv(each.get("id", "")) for each in element.iter("ref")):
        kinds.add("program")
    return kinds


def _displacement(reader: Reader, material: Any, socket: Any) -> list[tuple[float, Texture]]:
    """Heights of the relief that stands for a displacement. By Blender's default it is relief alone: Cycles moves no surface."""
    source = reader.source(socket, ())
    if source is None:
        return []
    if source.node is None or source.node.type != "DISPLACEMENT":
        reader.warn("displacement by other nodes than Displacement is not supported; it is left out")
        return []
    node, groups = source.node, source.groups
    scale, height = reader.constant(node.inputs["Scale"], groups), reader.scalar(node.inputs["Height"], groups)
    if not isinstance(height, Texture) and (height - reader.constant(node.inputs["Midlevel"], groups)) * scale == 0.0:
        return []
    method = material.displacement_method if hasattr(material, "displacement_method") else material.cycles.displacement_method
    if method != "BUMP":
        reader.warn("displacement that moves the surface is not supported; it is rendered as relief")
    if not isinstance(height, Texture) or height.attribute is not None or scale == 0.0:
        return []
    sides = reader.scales() if node.space == "OBJECT" else None
    if sides is not None:
        if max(sides) > 1.01 * min(sides):
            reader.warn("displacement of an object that is scaled unevenly is scaled by the mean of its scales")
        scale *= sum(sides) / 3.0
    return [(scale, height)]


def _whiten(element: xml.Element) -> None:
    """Replaces the colors of vertices by white."""
    for parent in element.iter():
        for at, child in enumerate(list(parent)):
            if any(texture.get("type") == "mesh_attribute" for texture in child.iter("texture")) and child.tag == "texture":
                parent[at] = xml.ElementTree.Element("rgb", {"name": child.get("name", ""), "value": "1 1 1"})


def _radiance(emission: Emission, images: Images) -> Optional[xml.Element]:
    if emission is None or emission == BLACK:
        return None
    element = xml.plugin("emitter", "area")
    return xml.add(element, "radiance", images.element(emission) if isinstance(emission, Texture) else emission)


def diffuse(images: Images, color: Union[Color, Texture], roughness: Union[float, Texture] = 0.0) -> xml.Element:
    """Lambertian surface, or a rough diffuse one, alike from both sides."""
    if roughness == 0.0:
        return two_sided(parameter(images, xml.plugin("bsdf", "diffuse"), "reflectance", color))
    rough = parameter(images, xml.plugin("bsdf", "roughdiffuse"), "reflectance", color)
    parameter(images, rough, "alpha", roughness)
    return two_sided(xml.add(rough, "energy_preserving", True))


def parameter(images: Images, element: xml.Element, name: str, value: Union[float, Color, Texture]) -> xml.Element:
    """Adds a constant or textured parameter."""
    return xml.add(element, name, images.element(value) if isinstance(value, Texture) else value)


def two_sided(bsdf: xml.Element) -> xml.Element:
    """BSDF that scatters alike from both sides, as Blender's do."""
    return xml.with_children(xml.plugin("bsdf", "twosided"), bsdf)


def blend(images: Images, weight: Union[float, Texture], first: xml.Element, second: xml.Element) -> xml.Element:
    """Mixture of two BSDFs, of which `weight` is the share of the second."""
    if weight == 0.0:
        return first
    if weight == 1.0:
        return second
    element = parameter(images, xml.plugin("bsdf", "blendbsdf"), "weight", weight)
    return xml.with_children(element, copy.deepcopy(first), copy.deepcopy(second))


class _Translator:
    """Translates the shaders of one material."""

    def __init__(self, reader: Reader) -> None:
        self.reader = reader
        self.images = reader.images
        self.has_subsurface = True
        self.handlers: dict[str, Callable[[Any, Groups], Closure]] = {
            "BSDF_PRINCIPLED": self._principled,
            "BSDF_DIFFUSE": self._diffuse,
            "DIFFUSE_BSDF": self._diffuse,  # its name in Blender 4.4
            "BSDF_GLOSSY": self._glossy,
            "BSDF_METALLIC": self._metallic,
            "BSDF_SHEEN": self._sheen,
            "BSDF_GLASS": self._glass,
            "BSDF_REFRACTION": self._refraction,
            "BSDF_TRANSPARENT": self._transparent,
            "BSDF_TRANSLUCENT": self._translucent,
            "SUBSURFACE_SCATTERING": self._subsurface,
            "BSDF_HAIR_PRINCIPLED": lambda node, groups: Closure(hair_shaders.principled(self.reader, node, groups)),
            "BSDF_HAIR": self._hair,
            "EMISSION": self._emission,
            "MIX_SHADER": self._mix,
            "ADD_SHADER": self._add,
        }

    def shader(self, socket: Any, groups: Groups) -> Closure:
        """Closure of a shader socket."""
        source = self.reader.source(socket, groups)
        if source is None or source.node is None:
            return Closure()
        if source.socket.type != "SHADER":
            # As in Cycles, a value in the place of a shader is emitted.
            return Closure(None, self._emitted(socket, groups))
        handler = self.handlers.get(source.node.type)
        return handler(source.node, source.groups) if handler else self._unknown(source.node, source.groups)

    def _unknown(self, node: Any, groups: Groups) -> Closure:
        if is_unknown(node):
            self.reader.unsupported(node, "the surface")
            return Closure(diffuse(self.images, BLACK))
        color = node.inputs.get("Color")
        self.reader.warn(f'the node "{node.name}" ({node.bl_label}) is not supported; a diffuse surface of its color is rendered')
        return Closure(diffuse(self.images, self.reader.color(color, groups) if color is not None else DEFAULT))

    def _principled(self, node: Any, groups: Groups) -> Closure:
        bsdf, below = principled.translate(self.reader, node, groups, self.has_subsurface)
        emission = None
        strength = self.reader.scalar(node.inputs["Emission Strength"], groups)
        if isinstance(strength, Texture) or strength > 0.0:
            emission = self._of_strength(self._emitted(node.inputs["Emission Color"], groups), node.inputs["Emission Strength"], groups)
            emission = self._covered(emission, self.reader.scalar(node.inputs["Alpha"], groups))
        return Closure(bsdf, emission, below)

    def _subsurface(self, node: Any, groups: Groups) -> Closure:
        color: Union[Color, Texture] = self.reader.color(node.inputs["Color"], groups)
        if not self.has_subsurface:
            return Closure(self.relief(diffuse(self.images, color), node, groups))
        is_textured, albedo = isinstance(color, Texture), subsurface.ALBEDO_BELOW_TEXTURES
        scale = max(self.reader.constant(node.inputs["Scale"], groups), 0.0)
        radius = tuple(max(r, 0.0) * scale for r in self.reader.constant_color(node.inputs["Radius"], groups))
        # A method hides the sockets that it has no use for.
        sockets = (node.inputs.get("Anisotropy"), node.inputs.get("IOR"))
        cosine, ior = (self.reader.constant(s, groups) if s is not None else other for s, other in zip(sockets, (0.0, 1.4)))
        below = subsurface.medium((albedo,) * 3 if is_textured else color, radius, cosine, node.falloff, ior)  # type: ignore[arg-type]
        if below is None:
            return Closure(self.relief(diffuse(self.images, color), node, groups))
        if node.falloff == "BURLEY":
            self.reader.warn("Christensen and Burley's subsurface is rendered as a random walk")
        if is_textured:
            self.reader.warn(
                f"below a texture of colors, subsurface is a medium of the albedo {albedo}, and the texture tints the light that enters it"
            )
        tint = color.scaled((1.0 / albedo,) * 3) if isinstance(color, Texture) else (1.0, 1.0, 1.0)
        # Light enters diffusely: Cycles bends it, but reflects none.
        entering = parameter(self.images, subsurface.transmitting(), "transmittance", tint)
        return Closure(self.relief(entering, node, groups), None, below)

    def _translucent(self, node: Any, groups: Groups) -> Closure:
        color = self.reader.color(node.inputs["Color"], groups)
        sheet = parameter(self.images, subsurface.transmitting(), "transmittance", color)
        return Closure(self.relief(sheet, node, groups))

    def _hair(self, node: Any, groups: Groups) -> Closure:
        """Hair BSDF, which Blender has beside the newer Principled Hair."""
        color = self.reader.color(node.inputs["Color"], groups)
        is_through = node.component == "Transmission"
        found = "a translucent" if is_through else "a diffuse"
        self.reader.warn(f'the node "{node.name}" ({node.bl_label}) is not supported; {found} surface of its color is rendered')
        if is_through:
            return Closure(parameter(self.images, subsurface.transmitting(), "transmittance", color))
        return Closure(diffuse(self.images, color))

    def _emitted(self, socket: Any, groups: Groups) -> Union[Color, Texture]:
        """Color of emitted light."""
        color = self.reader.color(socket, groups)
        if isinstance(color, Texture) and color.program is not None:
            if not hasattr(socket, "default_value"):
                self.reader.warn("a computed color in the place of a shader is not supported; the surface is black")
                return BLACK
            self.reader.warn(f"a computed {socket.name} of emitted light is not supported; its default value is used")
            return tuple(socket.default_value)[:3]  # type: ignore[return-value]
        return color

    def _covered(self, emission: Emission, alpha: Union[float, Texture]) -> Emission:
        """Emission of a surface with holes, which do not shine."""
        if not isinstance(alpha, Texture):
            return _scaled(emission, min(max(alpha, 0.0), 1.0))
        if emission is None:
            return None
        if alpha.program is not None:
            self.reader.warn("an emission under a computed alpha is not supported; the holes shine")
            return emission
        if not isinstance(emission, Texture):
            return alpha.scaled(emission)
        if _is_alpha_of(alpha, emission):
            return emission.covered()
        self.reader.warn("an emission by one texture under an alpha by another is not supported; the holes shine")
        return emission

    def _diffuse(self, node: Any, groups: Groups) -> Closure:
        import bpy

        color = self.reader.color(node.inputs["Color"], groups)
        roughness = self.reader.scalar(node.inputs["Roughness"], groups)
        if not isinstance(roughness, Texture):
            roughness = min(max(roughness, 0.0), 1.0)
        if roughness != 0.0 and bpy.app.version < (4, 3, 0):
            self.reader.warn("a rough diffuse surface is that of Blender 4.3 and later")
        return Closure(self.relief(diffuse(self.images, color, roughness), node, groups))

    def _sheen(self, node: Any, groups: Groups) -> Closure:
        if node.distribution != "MICROFIBER":
            self.reader.warn("the sheen of Ashikhmin is not supported; that of microfibers is used")
        color = self.reader.color(node.inputs["Color"], groups)
        element = principled.sheen(self.images, color, self.reader.scalar(node.inputs["Roughness"], groups), None)
        return Closure(self.relief(two_sided(element), node, groups))

    def _facets(self, plugin: str, smooth: str, node: Any, groups: Groups) -> xml.Element:
        """Plugin with facets, or the smooth plugin where the roughness is 0."""
        roughness = self.reader.scalar(node.inputs["Roughness"], groups)
        if not isinstance(roughness, Texture) and roughness < principled.SMOOTH:
            return xml.plugin("bsdf", smooth)
        if node.distribution == "ASHIKHMIN_SHIRLEY":
            self.reader.warn("facets of Ashikhmin and Shirley are not supported; those of GGX are used")
        distribution = "beckmann" if node.distribution == "BECKMANN" else "ggx"
        element = xml.add(xml.plugin("bsdf", plugin), "distribution", distribution)
        anisotropy = node.inputs.get("Anisotropy")
        amount = self.reader.constant(anisotropy, groups) if anisotropy is not None else 0.0
        if amount != 0.0 and not isinstance(roughness, Texture):
            self.reader.warn("an anisotropic surface has its grain along the UV map")
            aspect = math.sqrt(1.0 - 0.9 * min(abs(amount), 1.0))
            u, v = roughness**2 / aspect, roughness**2 * aspect
            u, v = (u, v) if amount > 0.0 else (v, u)
            return xml.add(xml.add(element, "alpha_u", u), "alpha_v", v)
        if amount != 0.0:
            self.reader.warn("anisotropy with a texture of roughness is not supported")
        alpha = roughness.with_operation("square") if isinstance(roughness, Texture) else roughness**2
        return parameter(self.images, element, "alpha", alpha)

    def _glossy(self, node: Any, groups: Groups) -> Closure:
        element = self._facets("roughconductor", "conductor", node, groups)
        self._whitened(element, self.reader.color(node.inputs["Color"], groups), node, groups)
        return Closure(self.relief(two_sided(element), node, groups))

    def _whitened(self, element: xml.Element, color: Union[Color, Texture], node: Any, groups: Groups) -> xml.Element:
        """Metal with a color that reflects as much light as in Cycles."""
        roughness = self.reader.scalar(node.inputs["Roughness"], groups)
        found = None
        if element.get("type") == "roughconductor" and not any(isinstance(v, Texture) and v.attribute for v in (color, roughness)):
            base, rough = (self.reader.as_program(v) if isinstance(v, Texture) else v for v in (color, roughness))
            is_beckmann = node.distribution == "BECKMANN"
            found = facets.metal(self.images.graph, base, rough, is_beckmann, node.distribution == "MULTI_GGX")
        if found is not None:
            color = Texture(program=found[0], factor=(found[1],) * 3)
        return parameter(self.images, element, "specular_reflectance", color)

    def _metallic(self, node: Any, groups: Groups) -> Closure:
        film = principled.film(self.reader, node, groups)
        if node.fresnel_type == "PHYSICAL_CONDUCTOR":
            element = self._facets("roughconductor", "conductor", node, groups)
            xml.add(element, "eta", self.reader.constant_color(node.inputs["IOR"], groups))
            xml.add(element, "k", self.reader.constant_color(node.inputs["Extinction"], groups))
        else:
            if node.distribution == "BECKMANN":
                self.reader.warn("Beckmann's facets with an Edge Tint are not supported; those of GGX are used")
            color = self.reader.color(node.inputs["Base Color"], groups)
            roughness = self.reader.scalar(node.inputs["Roughness"], groups)
            tint = self.reader.constant_color(node.inputs["Edge Tint"], groups)
            if film is not None and tint != principled.WHITE:
                self.reader.warn("Edge Tint under a thin film is not supported; white is used")
                tint = principled.WHITE
            metal = principled.tinted_metal(self.reader, color, roughness, tint)
            element = metal if metal is not None else xml.add(xml.plugin("bsdf", "principled"), "metallic", 1.0)
            if metal is None:
                parameter(self.images, element, "base_color", color)
                parameter(self.images, element, "roughness", roughness)
        return Closure(self.relief(two_sided(principled.with_film(self.images, element, film)), node, groups))

    def _glass(self, node: Any, groups: Groups) -> Closure:
        color = self.reader.color(node.inputs["Color"], groups)
        ior = self.reader.constant(node.inputs["IOR"], groups)
        if abs(ior - 1.0) < 1e-4:
            return Closure(self.clear(color))
        element = self._facets("roughdielectric", "dielectric", node, groups)
        xml.add(xml.add(xml.add(element, "int_ior", ior), "ext_ior", 1.0), "scale_radiance", False)
        reflected, transmitted = self._whole_glass(element, color, ior, node, groups)
        parameter(self.images, element, "specular_reflectance", reflected)
        parameter(self.images, element, "specular_transmittance", transmitted)
        principled.with_film(self.images, element, principled.film(self.reader, node, groups))
        return Closure(self.relief(element, node, groups))

    def _whole_glass(self, element: xml.Element, color: Union[Color, Texture], ior: float, node: Any, groups: Groups) -> Any:
        """Colors of what glass reflects and transmits, by which it sheds as much light as in Cycles."""
        roughness = self.reader.scalar(node.inputs["Roughness"], groups)
        if element.get("type") != "roughdielectric" or isinstance(color, Texture) or isinstance(roughness, Texture):
            return color, color
        is_beckmann = node.distribution == "BECKMANN"
        found = facets.glass(self.images.graph, color, roughness, ior, is_beckmann, node.distribution == "MULTI_GGX")
        return (color, color) if found is None else [Texture(program=each, factor=(most,) * 3) for each, most in found]

    def _refraction(self, node: Any, groups: Groups) -> Closure:
        self.reader.warn("Refraction BSDF is rendered as glass, which also reflects")
        return self._glass(node, groups)

    def _transparent(self, node: Any, groups: Groups) -> Closure:
        return Closure(self.clear(self.reader.color(node.inputs["Color"], groups)))

    def clear(self, color: Union[Color, Texture]) -> xml.Element:
        """Surface that lets light pass straight and tints it."""
        if color == (1.0, 1.0, 1.0):
            return xml.plugin("bsdf", "null")
        element = xml.add(xml.add(xml.plugin("bsdf", "thindielectric"), "int_ior", 1.0), "ext_ior", 1.0)
        return parameter(self.images, element, "specular_transmittance", color)

    def _emission(self, node: Any, groups: Groups) -> Closure:
        color = self._emitted(node.inputs["Color"], groups)
        return Closure(None, self._of_strength(color, node.inputs["Strength"], groups))

    def _of_strength(self, color: Union[Color, Texture], socket: Any, groups: Groups) -> Emission:
        """Emission of a color times a strength, of which one may be an image."""
        strength = self.reader.scalar(socket, groups)
        if isinstance(strength, Texture) and strength.image is not None and not isinstance(color, Texture):
            return strength.with_operation("luminance").scaled(color)
        return _scaled(color, self.reader.constant(socket, groups))

    def _mix(self, node: Any, groups: Groups) -> Closure:
        weight = self.reader.scalar(node.inputs[0], groups)
        first, second = (self.shader(node.inputs[at], groups) for at in (1, 2))
        if not isinstance(weight, Texture):
            weight = min(max(weight, 0.0), 1.0)
        bsdf = None
        if first.bsdf is not None or second.bsdf is not None:
            parts = [part.bsdf if part.bsdf is not None else diffuse(self.images, BLACK) for part in (first, second)]
            bsdf = blend(self.images, weight, *parts)
        below = self._below(first, second, weight)
        if not isinstance(weight, Texture):
            return Closure(bsdf, self._sum(_scaled(first.emission, 1.0 - weight), _scaled(second.emission, weight)), below)
        return Closure(bsdf, self._emission_by_texture(weight, first.emission, second.emission, node), below)

    def _emission_by_texture(self, weight: Texture, first: Emission, second: Emission, node: Any) -> Emission:
        """Emission of a mixture by a texture, which is the share of the second part."""
        first, second = (None if part == BLACK else part for part in (first, second))
        if first is None and second is None:
            return None
        is_one_image = weight.image is not None and (first is None or second is None)
        if first is None and isinstance(second, Texture) and _is_alpha_of(weight, second):
            return second.covered()
        if is_one_image and not isinstance(first, Texture) and not isinstance(second, Texture):
            number = weight.with_operation("luminance")
            return number.scaled(second) if second is not None else number.with_operation("invert").scaled(first)  # type: ignore[arg-type]
        share = float(node.inputs[0].default_value)
        self.reader.warn("emission mixed by a texture is not supported; it is mixed by the factor's default value")
        return self._sum(_scaled(first, 1.0 - share), _scaled(second, share))

    def _below(self, first: Closure, second: Closure, weight: Union[float, Texture]) -> Optional[Volume]:
        """Medium below a mixture, of which `weight` is the share of the second part."""
        media = [part.below for part, none in ((first, 1.0), (second, 0.0)) if part.below is not None and weight != none]
        if len(media) == 2 and media[0] != media[1]:
            self.reader.warn("subsurface of two kinds in one material is not supported; the medium of the first is below both")
        return media[0] if media else None

    def _add(self, node: Any, groups: Groups) -> Closure:
        first, second = (self.shader(node.inputs[at], groups) for at in (0, 1))
        if first.bsdf is not None and second.bsdf is not None:
            self.reader.warn("Add Shader of two surfaces is not supported; the first is rendered")
        bsdf = first.bsdf if first.bsdf is not None else second.bsdf
        below = first.below if first.bsdf is not None else second.below
        return Closure(bsdf, self._sum(first.emission, second.emission), below)

    def _sum(self, first: Emission, second: Emission) -> Emission:
        if first is None or first == BLACK:
            return second
        if second is None or second == BLACK:
            return first
        if isinstance(first, Texture) or isinstance(second, Texture):
            self.reader.warn("the sum of a textured emission and another is not supported; the first is rendered")
            return first
        return (first[0] + second[0], first[1] + second[1], first[2] + second[2])

    def relief(self, bsdf: xml.Element, node: Any, groups: Groups) -> xml.Element:
        """BSDF with the bump or normal map of a node's Normal socket."""
        return principled.relief(self.reader, bsdf, node.inputs["Normal"], groups)


def _is_alpha_of(alpha: Texture, colors: Texture) -> bool:
    """Whether two textures are the alpha and the colors of one image."""
    plain = [replace(texture, operations=(), factor=(1.0, 1.0, 1.0)) for texture in (alpha, colors)]
    return alpha.operations == ("alpha",) and plain[0] == plain[1]


def _scaled(emission: Emission, factor: float) -> Emission:
    if emission is None or factor == 0.0:
        return None
    if isinstance(emission, Texture):
        return emission.scaled((factor, factor, factor))
    return (emission[0] * factor, emission[1] * factor, emission[2] * factor)
