"""Principled BSDF as layers: metal over glass over a dielectric with a diffuse base, under a coat; and relief.

A dielectric is a `plastic` or `pplastic` with a weight of its base. With anisotropy, and where programs would exceed a limit, it is Mitsuba's
`principled`, of which the base color is dimmed by the mean reflectance, or without roughness a plain `plastic`.
"""

from __future__ import annotations

import math
from typing import Any, Optional, Union

from . import facets, layers, normals, subsurface, units, xml
from .images import Images, Texture
from .limits import excess
from .nodes import Color, Reader
from .programs import Expression, mix
from .volumes import Volume

Groups = tuple[Any, ...]
# Roughness below which a surface is smooth: its facets' alpha would be less than 10^-4.
SMOOTH = 0.01
# Filter Width of a bump map up to which Cycles' slope is that of the point. It is Blender's default, in pixels.
MOST_FILTER_WIDTH = 0.1001
WHITE: Color = (1.0, 1.0, 1.0)


def translate(reader: Reader, node: Any, groups: Groups, has_subsurface: bool) -> tuple[xml.Element, Optional[Volume]]:
    """BSDF of a Principled node, without its emission, and the medium below it. With a medium, the BSDF is that of the front."""
    principled = _Principled(reader, node, groups, has_subsurface)
    return principled.bsdf(), principled.medium


def default(images: Images) -> xml.Element:
    """Surface of an object without a material: since Blender 5.0 that of a new Principled node, before that a diffuse one."""
    import bpy

    from . import materials

    if bpy.app.version < (5, 0, 0):
        return materials.diffuse(images, materials.DEFAULT)
    return weighted(images, materials.DEFAULT, 0.25, 1.5, layers.dielectric(images.graph, 0.25, 1.5, WHITE, True))


def weighted(
    images: Images,
    base: Union[Color, Texture],
    alpha: Union[float, Texture],
    ior: float,
    layer: tuple[Expression, Expression, float],
    base_roughness: Union[float, Texture] = 0.0,
    film: Optional[Film] = None,
) -> xml.Element:
    """Dielectric over a diffuse base with a weight. A film takes from the base what it reflects, in place of the weight."""
    from . import materials

    weight, factor, most = layer
    element = layers.plastic(images.element(alpha) if isinstance(alpha, Texture) else alpha, ior)
    materials.parameter(images, element, "specular_reflectance", Texture(program=factor, factor=(most,) * 3))
    materials.parameter(images, element, "diffuse_reflectance", base)
    if base_roughness != 0.0:
        materials.parameter(images, element, "base_roughness", base_roughness)
    with_film(images, element, film)
    return materials.two_sided(materials.parameter(images, element, "base_weight", 1.0 if film is not None else Texture(program=weight)))


def _disney(images: Images, base: Union[Color, Texture], roughness: Union[float, Texture], metallic: float, ior: float) -> xml.Element:
    """Mitsuba's `principled`, not yet within `twosided`."""
    from . import materials

    element = xml.add(xml.plugin("bsdf", "principled"), "metallic", metallic)
    # An index of 1 would switch the metal off.
    xml.add(element, "eta", max(ior, 1.001))
    share = 1.0 if metallic == 1.0 else 1.0 - units.mean_reflectance(ior)
    dimmed = base.scaled((share,) * 3) if isinstance(base, Texture) else tuple(share * c for c in base)
    materials.parameter(images, element, "base_color", dimmed)
    return materials.parameter(images, element, "roughness", roughness)


Film = tuple[Union[float, Texture], float]
# Thickness in nanometers up to which Cycles has no film.
LEAST_FILM = 0.1001


def film(reader: Reader, node: Any, groups: Groups) -> Optional[Film]:
    """Thickness in nanometers and index of refraction of a node's thin film; None where it has none. Blender 4.1 knows no film."""
    if "Thin Film Thickness" not in node.inputs:
        return None
    thickness = reader.scalar(node.inputs["Thin Film Thickness"], groups)
    if not isinstance(thickness, Texture) and thickness <= LEAST_FILM:
        return None
    return thickness, max(reader.constant(node.inputs["Thin Film IOR"], groups), 1e-3)


def with_film(images: Images, element: xml.Element, film: Optional[Film]) -> xml.Element:
    """Surface under a thin film, if there is one."""
    from . import materials

    if film is None:
        return element
    return xml.add(materials.parameter(images, element, "film_thickness", film[0]), "film_eta", film[1])


def _alpha(roughness: float) -> float:
    """Roughness of facets; 0 where a surface is smooth."""
    return min(roughness, 1.0) ** 2 if roughness >= SMOOTH else 0.0


def _program(reader: Reader, value: Union[float, Color, Texture]) -> Optional[Expression]:
    """Value as an expression; None for a mesh's colors."""
    if not isinstance(value, Texture):
        return reader.images.graph.constant(value)
    return None if value.attribute is not None else reader.as_program(value)


def tinted_metal(
    reader: Reader,
    base: Union[Color, Texture],
    roughness: Union[float, Texture],
    tint: Color,
    passing: Optional[Expression] = None,
) -> Optional[xml.Element]:
    """Metal with a tint at 82 degrees, which is seen through a coat, and not yet within `twosided`; None where the tint is white or
    cannot be rendered."""
    from . import materials

    if tint == WHITE:
        return None
    if isinstance(roughness, Texture):
        reader.warn("the tint of a metal with a texture of roughness is not supported; white is used")
        return None
    alpha, program = _alpha(roughness), _program(reader, base)
    color = layers.metal_color(program, alpha, tint) if program is not None else None
    if color is not None and passing is not None:
        color = color * passing
    if color is None or excess(color) is not None:
        reader.warn("the tint of a metal whose color is an attribute or needs a long program is not supported; white is used")
        return None
    return materials.parameter(reader.images, layers.lobe(alpha), "specular_reflectance", Texture(program=color))


class _Principled:
    def __init__(self, reader: Reader, node: Any, groups: Groups, has_subsurface: bool) -> None:
        self.reader, self.node, self.groups, self.images = reader, node, groups, reader.images
        self.base = reader.color(node.inputs["Base Color"], groups)
        self.roughness = self._scalar("Roughness")
        self.metallic = self._scalar("Metallic")
        self.transmission = self._scalar("Transmission Weight")
        self.ior = self._constant("IOR")
        self.anisotropic = self._constant("Anisotropic")
        self.diffuse_roughness = self._diffuse_roughness()
        self.subsurface = self._scalar("Subsurface Weight")
        self.tint: Color = self._constant_color("Specular Tint")
        self.film = film(reader, node, groups)
        if self.film is not None and self.tint != WHITE:
            reader.warn("Specular Tint under a thin film is not supported; white is used")
            self.tint = WHITE
        self.medium = self._medium() if has_subsurface else None
        self.coat = self._coat_weight()
        self.passing = self._passing_coat()
        self._report()

    def _scalar(self, name: str) -> Union[float, Texture]:
        value = self.reader.scalar(self.node.inputs[name], self.groups)
        return value if isinstance(value, Texture) else max(value, 0.0)

    def _diffuse_roughness(self) -> Union[float, Texture]:
        """Roughness of the diffuse base, which Blender 4.2 does not have."""
        roughness = self._scalar("Diffuse Roughness") if "Diffuse Roughness" in self.node.inputs else 0.0
        return roughness if isinstance(roughness, Texture) else min(roughness, 1.0)

    def _constant(self, name: str) -> float:
        return self.reader.constant(self.node.inputs[name], self.groups)

    def _constant_color(self, name: str) -> Color:
        return self.reader.constant_color(self.node.inputs[name], self.groups)

    def _medium(self) -> Optional[Volume]:
        """Medium below the surface."""
        if self.subsurface == 0.0 or self.metallic == 1.0 or self.transmission == 1.0:
            return None
        method = self.node.subsurface_method
        color = self.base if not isinstance(self.base, Texture) else (subsurface.ALBEDO_BELOW_TEXTURES,) * 3
        scale = max(self._constant("Subsurface Scale"), 0.0)
        radius = tuple(max(r, 0.0) * scale for r in self.reader.constant_color(self.node.inputs["Subsurface Radius"], self.groups))
        # Christensen and Burley's method has no anisotropy.
        cosine = self._constant("Subsurface Anisotropy") if method != "BURLEY" else 0.0
        ior = self._constant("Subsurface IOR") if method == "RANDOM_WALK_SKIN" else self.ior
        found = subsurface.medium(color, radius, cosine, method, ior)  # type: ignore[arg-type]
        if found is not None:
            self._report_medium(method)
        return found

    def _report_medium(self, method: str) -> None:
        if method == "BURLEY":
            self.reader.warn("Christensen and Burley's subsurface is rendered as a random walk")
        if method == "RANDOM_WALK_SKIN":
            self.reader.warn("light enters skin by the surface's roughness alone; it is up to 9 % darker than in Cycles")
        if isinstance(self.base, Texture):
            albedo = subsurface.ALBEDO_BELOW_TEXTURES
            self.reader.warn(
                f"below a texture of colors, subsurface is a medium of the albedo {albedo}, and the texture tints the light that enters it"
            )

    def _entering(self) -> xml.Element:
        """Surface through which light enters the medium below."""
        from . import materials

        tint: Union[Color, Texture] = WHITE
        if isinstance(self.base, Texture):
            tint = self.base.scaled((1.0 / subsurface.ALBEDO_BELOW_TEXTURES,) * 3)
        ior = units.specular_index(self.ior, self._constant("Specular IOR Level"))
        if abs(ior - 1.0) < 1e-3:
            return materials.parameter(self.images, subsurface.transmitting(), "transmittance", tint)
        element = self._dielectric(ior)
        element.set("id", subsurface.ENTERING)
        return materials.parameter(self.images, element, "specular_transmittance", tint)

    def _report(self) -> None:
        if self.tint != WHITE and (self.transmission != 0.0 or self.medium is not None) and self.metallic != 1.0:
            self.reader.warn("Specular Tint of a surface that transmits light is not supported; white is used there")
        if self.tint != WHITE and (self.anisotropic != 0.0 or self.metallic != 1.0 and not self._is_even()):
            self.reader.warn("Specular Tint with a texture of roughness or an anisotropic surface is not supported; white is used")
        if self.anisotropic != 0.0:
            self.reader.warn("an anisotropic surface has its grain along the UV map")

    def bsdf(self) -> xml.Element:
        from . import materials

        images = self.images
        surface = self._below_metal() if self.metallic != 1.0 else self._metal()
        if self.metallic not in (0.0, 1.0):
            surface = materials.blend(images, self.metallic, surface, self._metal())
        surface = relief(self.reader, self._with_sheen(self._coated(surface)), self.node.inputs["Normal"], self.groups)
        alpha = self._scalar("Alpha")
        if isinstance(alpha, Texture) or alpha < 1.0:
            mask = materials.parameter(images, xml.plugin("bsdf", "mask"), "opacity", alpha)
            surface = xml.with_children(mask, surface)
        return surface

    def _below_metal(self) -> xml.Element:
        from . import materials

        if self.transmission == 1.0:
            return self._glass()
        base = self._opaque() if self.medium is None or self.subsurface != 1.0 else self._entering()
        if self.medium is not None and self.subsurface != 1.0:
            base = materials.blend(self.images, self.subsurface, base, self._entering())
        return base if self.transmission == 0.0 else materials.blend(self.images, self.transmission, base, self._glass())

    def _opaque(self) -> xml.Element:
        """Dielectric with a diffuse base."""
        from . import materials

        level = self._constant("Specular IOR Level")
        ior = units.specular_index(self.ior, level)
        base = self._below_coat(self.base)
        if abs(ior - 1.0) < 1e-3:
            return materials.diffuse(self.images, base, self.diffuse_roughness)
        weighted = self._weighted(base, ior)
        if weighted is not None:
            return weighted
        if self._is_even() and self.tint != WHITE:
            self.reader.warn("Specular Tint under a long program is not supported; white is used")
        if self.diffuse_roughness != 0.0:
            self.reader.warn("Diffuse Roughness of an anisotropic surface or under a long program is not supported; 0 is used")
        if not self._is_even() or self.roughness >= SMOOTH:
            return self._disney(0.0, ior)
        if self.film is not None:
            self.reader.warn("a thin film over a smooth dielectric under a long program is not supported; it is left out")
        return materials.two_sided(materials.parameter(self.images, layers.plastic(0.0, ior), "diffuse_reflectance", base))

    def _is_even(self) -> bool:
        """Whether the surface has one roughness."""
        return not isinstance(self.roughness, Texture) and self.anisotropic == 0.0

    def _weighted(self, base: Union[Color, Texture], ior: float) -> Optional[xml.Element]:
        """Dielectric over a diffuse base with a weight; None where it cannot be rendered."""
        if self.anisotropic != 0.0:
            return None
        is_whole = self.node.distribution == "MULTI_GGX"
        if isinstance(self.roughness, Texture):
            roughness = _program(self.reader, self.roughness)
            if roughness is None:
                return None
            roughness = roughness.graph.of("luminance", value=roughness)
            weight, factor, most = layers.uneven_dielectric(roughness, ior, is_whole)
            alpha: Union[float, Texture] = self.roughness.with_operation("square")
        else:
            alpha = _alpha(self.roughness)
            weight, factor, most = layers.dielectric(self.images.graph, alpha, ior, self.tint, is_whole)
        if self.passing is not None:
            factor = factor * self.passing
        if excess(weight) is not None or excess(factor) is not None:
            return None
        return weighted(self.images, base, alpha, ior, (weight, factor, most), self.diffuse_roughness, self.film)

    def _metal(self) -> xml.Element:
        from . import materials

        if self.anisotropic != 0.0:
            return self._disney(1.0, self.ior)
        metal = tinted_metal(self.reader, self.base, self.roughness, self.tint, self.passing)
        return materials.two_sided(metal) if metal is not None else self._disney(1.0, self.ior)

    def _metal_base(self) -> Union[Color, Texture]:
        """Base color of a metal that sheds as much light as in Cycles."""
        program = _program(self.reader, self.base)
        if program is None or isinstance(self.roughness, Texture) or self.anisotropic != 0.0:
            return self.base
        base = program if isinstance(self.base, Texture) else self.base
        found = facets.disney_base(self.images.graph, base, self.roughness, self.node.distribution == "MULTI_GGX")
        return self.base if found is None else Texture(program=found[0], factor=(found[1],) * 3)

    def _disney(self, metallic: float, ior: float) -> xml.Element:
        from . import materials

        base = self.base if metallic != 1.0 else self._metal_base()
        element = _disney(self.images, self._below_coat(base), self.roughness, metallic, ior)
        if self.anisotropic != 0.0:
            xml.add(element, "anisotropic", min(self.anisotropic, 1.0))
        return materials.two_sided(with_film(self.images, element, self.film))

    def _glass(self) -> xml.Element:
        """Rough glass. Cycles tints what passes by the root of the base color."""
        from . import materials

        base = self.base
        tint = base.with_operation("sqrt") if isinstance(base, Texture) else tuple(math.sqrt(max(c, 0.0)) for c in base)
        tint = self._below_coat(tint)
        if abs(self.ior - 1.0) < 1e-4:
            element = xml.add(xml.add(xml.plugin("bsdf", "thindielectric"), "int_ior", 1.0), "ext_ior", 1.0)
            return materials.parameter(self.images, element, "specular_transmittance", tint)
        element = xml.add(self._dielectric(self.ior), "scale_radiance", False)
        return materials.parameter(self.images, element, "specular_transmittance", tint)

    def _dielectric(self, ior: float) -> xml.Element:
        """Smooth or rough boundary of a body."""
        from . import materials

        if not isinstance(self.roughness, Texture) and self.roughness < SMOOTH:
            element = xml.plugin("bsdf", "dielectric")
        else:
            element = xml.add(xml.plugin("bsdf", "roughdielectric"), "distribution", "ggx")
            rough = self.roughness
            alpha = rough.with_operation("square") if isinstance(rough, Texture) else rough**2
            materials.parameter(self.images, element, "alpha", alpha)
        return with_film(self.images, xml.add(xml.add(element, "int_ior", ior), "ext_ior", 1.0), self.film)

    # ----------------------------------------------------------------------------------------------------------- sheen

    def _with_sheen(self, surface: xml.Element) -> xml.Element:
        """Surface under its sheen of microfibers."""
        color = self._sheen_color()
        if color == (0.0, 0.0, 0.0):
            return surface
        if any(part.get("type") == "thindielectric" for part in surface.iter("bsdf")):
            self.reader.warn("sheen over glass whose index is 1 is not supported; it is left out")
            return surface
        roughness = self._scalar("Sheen Roughness")
        return sheen(self.images, color, roughness, surface)

    def _sheen_color(self) -> Union[Color, Texture]:
        """Tint of the sheen times its weight."""
        weight = self._scalar("Sheen Weight")
        if weight == 0.0:
            return (0.0, 0.0, 0.0)
        tint = self.reader.color(self.node.inputs["Sheen Tint"], self.groups)
        if not isinstance(weight, Texture):
            share = min(weight, 1.0)
            return tint.scaled((share,) * 3) if isinstance(tint, Texture) else (share * tint[0], share * tint[1], share * tint[2])
        programs = _program(self.reader, weight), _program(self.reader, tint)
        if programs[0] is None or programs[1] is None:
            self.reader.warn("a Sheen Weight that is an attribute, or over a tint that is one, is not supported; the sheen is left out")
            return (0.0, 0.0, 0.0)
        color = programs[0].graph.of("luminance", value=programs[0]) * programs[1]
        if excess(color) is not None:
            self.reader.warn("a sheen that needs a long program is not supported; it is left out")
            return (0.0, 0.0, 0.0)
        return Texture(program=color)

    # ------------------------------------------------------------------------------------------------------------ coat

    def _coat_weight(self) -> Union[float, Texture]:
        weight = self._scalar("Coat Weight")
        if weight != 0.0 and self.medium is not None:
            self.reader.warn("a coat over subsurface is not supported; it is left out")
            return 0.0
        if weight != 0.0 and "Coat Normal" in self.node.inputs and self.node.inputs["Coat Normal"].is_linked:
            self.reader.warn("Coat Normal is not supported; the coat has the normal of the surface")
        if not isinstance(weight, Texture):
            return min(weight, 1.0)
        program = _program(self.reader, weight)
        if program is None or excess(program * layers.coat_albedo(self.images.graph, self._coat_index())) is not None:
            self.reader.warn("a Coat Weight that is an attribute or needs a long program is not supported; the coat is left out")
            return 0.0
        return weight

    def _coat_index(self) -> float:
        return max(self._constant("Coat IOR"), 1.0)

    def _passing_coat(self) -> Optional[Expression]:
        """What a tinted coat lets pass; None where there is none."""
        if self.coat == 0.0:
            return None
        tint = self._constant_color("Coat Tint")
        if tint == WHITE:
            return None
        graph = self.images.graph
        passing = layers.coat_tint(graph, tint, self._coat_index())
        if isinstance(self.coat, Texture):
            weight = _program(self.reader, self.coat)
            assert weight is not None
            return mix(WHITE, passing, weight.graph.of("luminance", value=weight))
        return passing if self.coat == 1.0 else (1.0 - self.coat) + self.coat * passing

    def _below_coat(self, color: Union[Color, Texture]) -> Union[Color, Texture]:
        """Color as it is seen through a tinted coat."""
        if self.passing is None:
            return color
        program = _program(self.reader, color)
        if program is not None and excess(program * self.passing) is None:
            return Texture(program=program * self.passing)
        self.reader.warn("Coat Tint over a color that is an attribute or needs a long program is that of perpendicular light")
        # A weight that varies counts as a whole one.
        share = 1.0 if isinstance(self.coat, Texture) else self.coat
        red, green, blue = ((1.0 - share) + share * channel for channel in self._constant_color("Coat Tint"))
        if isinstance(color, Texture):
            return color.scaled((red, green, blue))
        return (color[0] * red, color[1] * green, color[2] * blue)

    def _coated(self, surface: xml.Element) -> xml.Element:
        """Surface under its coat, which keeps from it what a smooth coat would reflect, as in Cycles."""
        from . import materials

        index = self._coat_index()
        if self.coat == 0.0 or index == 1.0:
            return surface
        graph = self.images.graph
        albedo = layers.coat_albedo(graph, index)
        weight = _program(self.reader, self.coat)
        assert weight is not None
        alpha = _alpha(self._constant("Coat Roughness"))
        upper = layers.lobe(alpha)
        if alpha > 0.0:
            factor = layers.coat_factor(graph, alpha, index)
            materials.parameter(self.images, upper, "specular_reflectance", Texture(program=factor))
        return materials.blend(self.images, Texture(program=weight * albedo), surface, materials.two_sided(upper))


def sheen(images: Images, color: Union[Color, Texture], roughness: Union[float, Texture], surface: Optional[xml.Element]) -> xml.Element:
    """Sheen of microfibers over a surface, or over nothing."""
    from . import materials

    if not isinstance(color, Texture):
        red, green, blue = (min(max(channel, 0.0), 1.0) for channel in color)
        color = (red, green, blue)
    element = materials.parameter(images, xml.plugin("bsdf", "sheen"), "reflectance", color)
    materials.parameter(images, element, "roughness", roughness if isinstance(roughness, Texture) else min(max(roughness, 0.0), 1.0))
    return element if surface is None else xml.with_children(element, surface)


def relief(reader: Reader, bsdf: xml.Element, socket: Any, groups: Groups) -> xml.Element:
    """BSDF with the bump or normal map that a Normal socket is linked to, and with the relief of the material's displacement."""
    source = normals.source(reader, socket, groups)
    if source is None or source.node is None:
        return _bumped(reader, bsdf, reader.heights)
    node, groups = source.node, source.groups
    if node.type == "NORMAL_MAP":
        # Cycles mixes in the normals that the displacement makes where the map has not its full strength.
        if reader.heights and reader.scalar(node.inputs["Strength"], groups) != 1.0:
            reader.warn("displacement below a normal map that is not at full strength is not supported; the normal map alone is rendered")
        return _normal_map(reader, bsdf, node, groups)
    if node.type == "BUMP":
        return _bumped(reader, bsdf, _heights(reader, node, groups) + reader.heights)
    reader.warn(f'the node "{node.name}" ({node.bl_label}) is not supported; the surface keeps its normals')
    return _bumped(reader, bsdf, reader.heights)


def _normal_map(reader: Reader, bsdf: xml.Element, node: Any, groups: Groups) -> xml.Element:
    texture = reader.color(node.inputs["Color"], groups)
    if node.space != "TANGENT":
        reader.warn(f"a normal map in {node.space.lower()} space is not supported; the surface keeps its normals")
        return bsdf
    if isinstance(texture, Texture) and texture.program is not None:
        reader.warn("a normal map that is computed is not supported; the surface keeps its normals")
        return bsdf
    if isinstance(texture, Texture) and texture.image is None:
        return bsdf
    if node.uv_map:
        reader.uv_maps.add(node.uv_map)
    strength = reader.constant(node.inputs["Strength"], groups)
    if not isinstance(texture, Texture):
        # Such as the magenta of a missing image.
        found = reader.images.of_color(texture, f"normal {strength}")
    else:
        found = reader.images.element(texture.with_operation(f"normal {strength}") if strength != 1.0 else texture)
    element = _with_rules(xml.plugin("bsdf", "normalmap"), bsdf, reader.corrects_normals)
    return xml.with_children(xml.add(element, "normalmap", found), bsdf)


# Plugins without a diffuse part.
SPECULAR = ("conductor", "roughconductor", "dielectric", "roughdielectric", "thindielectric")


def _is_specular(bsdf: xml.Element) -> bool:
    """Whether a BSDF has no diffuse part."""
    parts = bsdf.findall("bsdf")
    if parts:
        return all(_is_specular(part) for part in parts)
    metallic = bsdf.find("float[@name='metallic']")
    return bsdf.get("type") in SPECULAR or metallic is not None and float(metallic.get("value")) == 1.0


def _with_rules(relief: xml.Element, bsdf: xml.Element, corrects_normals: bool) -> xml.Element:
    """Relief over a BSDF, with the rules of Cycles: light from grazing angles fades on diffuse surfaces only, and others reflect no light
    into the surface where *Bump Map Correction* is on."""
    if _is_specular(bsdf):
        xml.add(relief, "use_shadowing_function", False)
        if corrects_normals:
            xml.add(relief, "raise_invalid_normals", True)
    return relief


def _bumped(reader: Reader, bsdf: xml.Element, heights: list[tuple[float, Texture]]) -> xml.Element:
    """BSDF with the relief of the sum of some heights times their factors."""
    if not heights:
        return bsdf
    if len(heights) == 1:
        scale, height = heights[0]
        element = xml.with_children(xml.plugin("bsdf", "bumpmap"), reader.images.element(height))
        xml.add(element, "scale", scale)
        return xml.with_children(_with_rules(element, bsdf, reader.corrects_normals), bsdf)
    # Bump maps over each other are one of the sum of their heights, but for terms of the second order in the slopes.
    images = reader.images
    total = images.graph.constant(0.0)
    for scale, height in heights:
        total = total + scale * reader.as_program(height)
    element = xml.with_children(xml.plugin("bsdf", "bumpmap"), images.element(Texture(program=total)))
    return xml.with_children(_with_rules(element, bsdf, reader.corrects_normals), bsdf)


def _heights(reader: Reader, node: Any, groups: Groups) -> list[tuple[float, Texture]]:
    """Heights of a Bump node and of those below it, with their factors."""
    heights = []
    height = reader.scalar(node.inputs["Height"], groups)
    if isinstance(height, Texture) and height.attribute is None:
        width = reader.constant(node.inputs["Filter Width"], groups) if "Filter Width" in node.inputs else 0.0
        if width > MOST_FILTER_WIDTH:
            reader.warn(
                f"the Filter Width {width:.3g} of a bump map is not supported; the slope is that of the texture at the point"
            )
        scale = reader.constant(node.inputs["Distance"], groups) * reader.constant(node.inputs["Strength"], groups)
        heights.append((-scale if node.invert else scale, height))
    below = reader.source(node.inputs["Normal"], groups)
    if below is not None and below.node is not None:
        if below.node.type == "BUMP":
            return heights + _heights(reader, below.node, below.groups)
        reader.warn("a bump map over a normal map is not supported; the bump map alone is rendered")
    return heights
