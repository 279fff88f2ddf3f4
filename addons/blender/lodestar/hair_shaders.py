"""Hair shaders: Principled Hair as the renderer's fiber (Chiang et al. 2016), and the older Hair BSDF as what is near it.

The numbers are Cycles': absorption of pigments, of a color (Chiang et al. 2016, equation 9), and the curve of Melanin.
"""

from __future__ import annotations

import math
from typing import Any, Union

from . import xml
from .images import Texture
from .limits import excess
from .nodes import Reader
from .programs import Expression, clamp, logarithm, maximum

Groups = tuple[Any, ...]
# Absorption of the pigments per unit of their concentration.
EUMELANIN, PHEOMELANIN = (0.506, 0.841, 1.653), (0.343, 0.733, 1.924)
# Coefficients of the polynomial in the radial roughness by which a color's logarithm is divided, the highest power first.
SCALE = (0.245, 5.574, -10.73, 2.532, -0.215, 5.969)
LEAST_COLOR = 1e-6


def principled(reader: Reader, node: Any, groups: Groups) -> xml.Element:
    """Principled Hair."""
    maker = _Maker(reader, node, groups)
    is_huang = getattr(node, "model", "CHIANG") == "HUANG"
    if is_huang:
        reader.warn(f'the model Huang of the node "{node.name}" is not supported; its hair is that of Chiang, with equal roughness along and around')
    elif reader.constant(node.inputs["Coat"], groups) > 0.0:
        reader.warn(f'the coat of the node "{node.name}" ({node.bl_label}) is not supported; its reflection is as rough as the rest')
    chance = maker.factor_by_chance("Random Roughness")
    along = maker.input("Roughness") * chance
    around = along if is_huang else maker.input("Radial Roughness") * chance
    element = xml.plugin("bsdf", "hair")
    maker.add(element, "longitudinal_roughness", clamp(along, 0.0, 1.0), is_color=False)
    maker.add(element, "azimuthal_roughness", clamp(around, 0.0, 1.0), is_color=False)
    # Cycles turns the scales the other way.
    xml.add(element, "scale_tilt", -math.degrees(reader.constant(node.inputs["Offset"], groups)))
    ior = max(reader.constant(node.inputs["IOR"], groups), 1.0)
    xml.add(xml.add(element, "int_ior", ior if ior > 1.001 else 1.001), "ext_ior", 1.0)
    return maker.add(element, "sigma_a", maker.absorption(around), is_color=True)


def absorption_of_color(color: Expression, roughness: Expression) -> Expression:
    """Absorption by which hair of a radial roughness has a color, when light is scattered often."""
    divisor: Union[Expression, float] = SCALE[0]
    for coefficient in SCALE[1:]:
        divisor = divisor * roughness + coefficient
    share = logarithm(maximum(color, LEAST_COLOR)) / divisor
    return share * share


class _Maker:
    """Makes parameters of a fiber of a node's sockets."""

    def __init__(self, reader: Reader, node: Any, groups: Groups) -> None:
        self._reader, self._node, self._groups = reader, node, groups
        self._graph = reader.images.graph

    def input(self, name: str) -> Expression:
        """Value of a socket."""
        return self._reader.evaluator.input(self._node, self._groups, name)

    def add(self, element: xml.Element, name: str, value: Expression, is_color: bool) -> xml.Element:
        """Adds a parameter that is a constant or computed."""
        if value.is_constant:
            return xml.add(element, name, value.constant if is_color else float(value.constant[0]))
        too_much = excess(value)
        if too_much is not None:
            self._reader.warn(f'the node "{self._node.name}" ({self._node.bl_label}) needs {too_much}; its {name} is 0.3')
            return xml.add(element, name, (0.3, 0.3, 0.3) if is_color else 0.3)
        return xml.add(element, name, self._reader.images.element(Texture(program=value)))

    def factor_by_chance(self, name: str, is_bounded: bool = False) -> Expression:
        """Factor of each strand, which differs from 1 by the share that the socket says."""
        share = self.input(name)
        if is_bounded:
            share = clamp(share, 0.0, 1.0)
        if share.is_constant and share.constant[0] == 0.0:
            return self._graph.constant(1.0)
        return 1.0 + (self._chance() * 2.0 - 1.0) * share

    def _chance(self) -> Expression:
        """Number by chance of each strand."""
        reader, socket = self._reader, self._node.inputs.get("Random")
        reader.asks_for_strands = True
        if not reader.has_strands or (socket is not None and reader.source(socket, self._groups) is not None):
            return self.input("Random")
        found = reader.of_strands("random")
        if found is None and reader.layout is not None:
            reader.warn("numbers by chance of strands have no place beside what else the material asks for; all strands are alike")
        return found if found is not None else self._graph.constant(0.5)

    def absorption(self, roughness: Expression) -> Expression:
        """Absorption per radius of the fiber."""
        kind = self._node.parametrization
        if kind == "ABSORPTION":
            return maximum(self.input("Absorption Coefficient"), 0.0)
        if kind == "COLOR":
            return absorption_of_color(self.input("Color"), roughness)
        melanin = self.input("Melanin") * self.factor_by_chance("Random Color", is_bounded=True)
        pigment = -logarithm(maximum(1.0 - melanin, 0.0001))
        redness = self.input("Melanin Redness")
        graph = self._graph
        pigments = pigment * (1.0 - redness) * graph.constant(EUMELANIN) + pigment * redness * graph.constant(PHEOMELANIN)
        return maximum(pigments, 0.0) + absorption_of_color(self.input("Tint"), roughness)
