"""Volumes: a tree of volume shaders as coefficients, and these as a medium of the scene file.

Coefficients are per scene unit. Blender's are sums: where volumes lie in each other, their coefficients add up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, Callable, Optional

import numpy as np

from . import units, xml
from .grids import Grid, Grids
from .images import Texture
from .nodes import Color, Reader

Groups = tuple[Any, ...]
BLACK: Color = (0.0, 0.0, 0.0)
# Largest mean cosine, as in Cycles.
MOST_COSINE = 0.999
# Optical depth across an object by which a medium that emits absorbs at least: the renderer's media emit in proportion to what they absorb.
LEAST_DEPTH = 0.01
# Numbers that are equal but for rounding.
EVEN = 1e-3


@dataclass(frozen=True)
class Phase:
    """Phase function of one lobe: Henyey and Greenstein's with a mean cosine, or Rayleigh's, which has None."""

    cosine: Optional[float]


ISOTROPIC = Phase(0.0)


@dataclass(frozen=True)
class Volume:
    """Coefficients of a volume."""

    absorption: Color = BLACK
    scattering: tuple[tuple[Phase, Color], ...] = ()
    # Emitted radiance per scene unit.
    emission: Color = BLACK
    # Factors of absorption and scattering, and of emission.
    density: Optional[Grid] = None
    glow: Optional[Grid] = None

    @property
    def is_empty(self) -> bool:
        """Whether the volume does nothing to light."""
        return max(self.absorption) <= 0.0 and max(self.emission) <= 0.0 and not self.scattering

    @property
    def has_grid(self) -> bool:
        """Whether the volume varies with the place."""
        return self.density is not None or self.glow is not None

    def scaled(self, factor: float) -> Volume:
        """Volume of which there is so much."""
        if factor <= 0.0:
            return Volume()
        lobes = tuple((phase, _times(color, factor)) for phase, color in self.scattering)
        return replace(self, absorption=_times(self.absorption, factor), scattering=lobes, emission=_times(self.emission, factor))

    def plus(self, other: Volume, warn: Callable[[str], None]) -> Volume:
        """Both volumes in the same place."""
        if self.is_empty or other.is_empty:
            return other if self.is_empty else self
        if (self.density, self.glow) != (other.density, other.glow):
            warn("the sum of a volume of a grid and another volume is not supported; the grid alone is rendered")
            return self if self.has_grid else other
        lobes = dict(self.scattering)
        for phase, color in other.scattering:
            lobes[phase] = _sum(lobes.get(phase, BLACK), color)
        return replace(
            self,
            absorption=_sum(self.absorption, other.absorption),
            scattering=tuple(lobes.items()),
            emission=_sum(self.emission, other.emission),
        )


def _times(color: Color, factor: float) -> Color:
    return (color[0] * factor, color[1] * factor, color[2] * factor)


def _sum(a: Color, b: Color) -> Color:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def translate(reader: Reader, socket: Any, grids: Optional[Grids]) -> Optional[Volume]:
    """Volume of the Volume socket of an output; None where nothing is linked to it. `grids` are those of a Volume object."""
    if reader.source(socket, ()) is None:
        return None
    return _Translator(reader, grids).shader(socket, ())


# Nodes of volumes whose values are constants, whatever grids the object has.
WITHOUT_GRIDS = {
    "VOLUME_ABSORPTION", "VOLUME_SCATTER", "VOLUME_COEFFICIENTS", "EMISSION", "MIX_SHADER", "ADD_SHADER", "RGB", "VALUE", "REROUTE",
}  # fmt: skip


def asks_for_grids(socket: Any) -> bool:
    """Whether nodes that lead to a socket may ask for grids of the object."""
    open_, seen = [socket], set()
    while open_:
        for link in open_.pop().links:
            if link.from_node.type not in WITHOUT_GRIDS:
                return True
            if link.from_node.name not in seen:
                seen.add(link.from_node.name)
                open_.extend(link.from_node.inputs)
    return False


@dataclass
class _Translator:
    reader: Reader
    grids: Optional[Grids]
    handlers: dict[str, Callable[[Any, Groups], Volume]] = field(init=False)

    def __post_init__(self) -> None:
        self.handlers = {
            "VOLUME_ABSORPTION": self._absorption,
            "VOLUME_SCATTER": self._scatter,
            "VOLUME_COEFFICIENTS": self._coefficients,
            "PRINCIPLED_VOLUME": self._principled,
            "EMISSION": self._emission,
            "MIX_SHADER": self._mix,
            "ADD_SHADER": self._add,
        }

    def shader(self, socket: Any, groups: Groups) -> Volume:
        """Volume of a shader socket."""
        source = self.reader.source(socket, groups)
        if source is None or source.node is None:
            return Volume()
        handler = self.handlers.get(source.node.type)
        if handler is not None:
            return handler(source.node, source.groups)
        self.reader.warn(f'the node "{source.node.name}" ({source.node.bl_label}) is not supported in a volume; it is left out')
        return Volume()

    # --------------------------------------------------------------------------------------------------- sockets

    def _color(self, node: Any, name: str, groups: Groups) -> Color:
        color = self.reader.constant_color(node.inputs[name], groups)
        return (max(color[0], 0.0), max(color[1], 0.0), max(color[2], 0.0))

    def _number(self, node: Any, name: str, groups: Groups) -> float:
        return self.reader.constant(node.inputs[name], groups)

    def _density(self, node: Any, groups: Groups) -> tuple[float, Optional[Grid]]:
        """Density as a number and a grid."""
        socket = node.inputs["Density"]
        if self.grids is not None:
            found = self.grids.linked(self.reader, socket, groups)
            if found is not None:
                return found
        value = self.reader.scalar(socket, groups)
        if isinstance(value, Texture):
            self.reader.warn(
                "a density that is computed from place to place is not supported; "
                f"it is {float(socket.default_value):.3g} everywhere, the default value of {socket.name}"
            )
            value = float(socket.default_value)
        return max(value, 0.0), None

    def _phase(self, node: Any, groups: Groups) -> list[tuple[Phase, float]]:
        """Lobes of a phase function with their shares."""
        kind = getattr(node, "phase", "HENYEY_GREENSTEIN")
        number = lambda name: self._number(node, name, groups)  # noqa: E731
        if kind == "RAYLEIGH":
            return [(Phase(None), 1.0)]
        if kind == "DRAINE":
            cosine, alpha = number("Anisotropy"), number("Alpha")
            self._approximated("Draine's")
            return [(of_cosine(draine_cosine(cosine, alpha)), 1.0)]
        if kind == "MIE":
            cosine, draine, alpha, share = mie(number("Diameter"))
            self._approximated("Draine's part of Mie's")
            return [(of_cosine(cosine), 1.0 - share), (of_cosine(draine_cosine(draine, alpha)), share)]
        if kind == "FOURNIER_FORAND":
            backwards = number("Backscatter")
            self.reader.warn(
                "Fournier and Forand's phase function is not supported; that of Henyey and Greenstein scatters the same share backwards"
            )
            return [(of_cosine(cosine_of_backscatter(backwards)), 1.0)]
        return [(of_cosine(number("Anisotropy")), 1.0)]

    def _approximated(self, name: str) -> None:
        self.reader.warn(f"{name} phase function is not supported; that of Henyey and Greenstein has the same mean cosine")

    # --------------------------------------------------------------------------------------------------- shaders

    def _absorption(self, node: Any, groups: Groups) -> Volume:
        color = self._color(node, "Color", groups)
        density, grid = self._density(node, groups)
        return Volume(absorption=_times(_complement(color), density), density=grid)

    def _scatter(self, node: Any, groups: Groups) -> Volume:
        color = self._color(node, "Color", groups)
        density, grid = self._density(node, groups)
        return Volume(scattering=_lobes(self._phase(node, groups), _times(color, density)), density=grid)

    def _coefficients(self, node: Any, groups: Groups) -> Volume:
        scattering = self._color(node, "Scatter Coefficients", groups)
        return Volume(
            absorption=self._color(node, "Absorption Coefficients", groups),
            scattering=_lobes(self._phase(node, groups), scattering),
            emission=self._color(node, "Emission Coefficients", groups),
        )

    def _principled(self, node: Any, groups: Groups) -> Volume:
        color = self._color(node, "Color", groups)
        density, grid = self._density(node, groups)
        glow = heat = None
        if self.grids is not None:
            if grid is None and density > 0.0:
                grid = self.grids.named(self._text(node, "Density Attribute"))
            if self.grids.named(self._text(node, "Color Attribute")) is not None:
                self.reader.warn("a Color Attribute of a volume is not supported; its color is the same everywhere")
            heat = self.grids.named(self._text(node, "Temperature Attribute"))
        hue = _complement(tuple(math.sqrt(c) for c in self._color(node, "Absorption Color", groups)))  # type: ignore[arg-type]
        rest = _complement(color)
        absorption = _times((rest[0] * hue[0], rest[1] * hue[1], rest[2] * hue[2]), density)
        lobes = _lobes(self._phase(node, groups), _times(color, density))
        emission = _times(self._color(node, "Emission Color", groups), max(self._number(node, "Emission Strength", groups), 0.0))
        blackbody = self._number(node, "Blackbody Intensity", groups)
        if blackbody > 0.0:
            tint = self._color(node, "Blackbody Tint", groups)
            temperature = max(self._number(node, "Temperature", groups), 0.0)
            if heat is None:
                heated = blackbody_emission(temperature, blackbody)
                emission = _sum(emission, (tint[0] * heated[0], tint[1] * heated[1], tint[2] * heated[2]))
            elif max(emission) > 0.0:
                self.reader.warn("Emission Strength beside a grid of temperatures is not supported; the blackbody alone is rendered")
            if heat is not None:
                glow = heat.mapped(lambda value: blackbody_emission(temperature * value, blackbody))
                emission = tint
        return Volume(absorption, lobes, emission, grid, glow)

    @staticmethod
    def _text(node: Any, name: str) -> str:
        return str(node.inputs[name].default_value)

    def _emission(self, node: Any, groups: Groups) -> Volume:
        strength = max(self._number(node, "Strength", groups), 0.0)
        return Volume(emission=_times(self._color(node, "Color", groups), strength))

    def _mix(self, node: Any, groups: Groups) -> Volume:
        share = min(max(self.reader.constant(node.inputs[0], groups), 0.0), 1.0)
        first, second = (self.shader(node.inputs[at], groups) for at in (1, 2))
        return first.scaled(1.0 - share).plus(second.scaled(share), self.reader.warn)

    def _add(self, node: Any, groups: Groups) -> Volume:
        first, second = (self.shader(node.inputs[at], groups) for at in (0, 1))
        return first.plus(second, self.reader.warn)


def _complement(color: Color) -> Color:
    return (max(1.0 - color[0], 0.0), max(1.0 - color[1], 0.0), max(1.0 - color[2], 0.0))


def _lobes(phase: list[tuple[Phase, float]], scattering: Color) -> tuple[tuple[Phase, Color], ...]:
    if max(scattering) <= 0.0:
        return ()
    return tuple((lobe, _times(scattering, share)) for lobe, share in phase if share > 0.0)


# ------------------------------------------------------------------------------------------------------ phase functions


def of_cosine(cosine: float) -> Phase:
    """Henyey and Greenstein's function of a mean cosine."""
    return Phase(min(max(cosine, -MOST_COSINE), MOST_COSINE))


def draine_cosine(g: float, alpha: float) -> float:
    """Mean cosine of Draine's phase function (Draine 2003, equation 5)."""
    return g * (1.0 + alpha * (3.0 + 2.0 * g * g) / 5.0) / (1.0 + alpha * (1.0 + 2.0 * g * g) / 3.0)


def mie(diameter: float) -> tuple[float, float, float, float]:
    """Approximation of Mie's phase function for droplets of a diameter in micrometers (Jendersie and d'Eon 2023): mean cosine of Henyey and
    Greenstein's part, g and alpha of Draine's part, and the share of Draine's part."""
    d = max(diameter, 0.0)
    if d <= 0.1:
        return 13.8 * d * d, 1.1456 * d * math.sin(9.29044 * d), 250.0, 0.252977 - 312.983 * d**4.3
    if d < 1.5:
        log = math.log(d)
        angle = (log - 0.238604) * (log + 1.00667) / (0.507522 - 0.15677 * log)
        return (
            0.862 - 0.143 * log * log,
            0.379685 * math.cos(1.19692 * math.cos(angle) + 1.37932 * log + 0.0625835) + 0.344213,
            250.0,
            0.146209 * math.cos(3.38707 * log + 2.11193) + 0.316072 + 0.0778917 * log,
        )
    if d < 5.0:
        log = math.log(d)
        log_log = math.log(log)
        return (
            0.0604931 * log_log + 0.940256,
            0.500411 - 0.081287 / (-2.0 * log + math.tan(log) + 1.27551),
            7.30354 * log + 6.31675,
            0.026914 * (log - math.cos(5.68947 * (log_log - 0.0292149))) + 0.3764,
        )
    return (
        math.exp(-0.0990567 / (d - 1.67154)),
        math.exp(-2.20679 / (d + 3.91029) - 0.428934),
        math.exp(3.62489 - 8.29288 / (d + 5.52825)),
        math.exp(-0.599085 / (d - 0.641583) - 0.665888),
    )


def cosine_of_backscatter(share: float) -> float:
    """Mean cosine of Henyey and Greenstein's function that scatters a share of light backwards."""
    low, high = 0.0, 1.0
    for _ in range(40):
        g = 0.5 * (low + high)
        backwards = (1.0 - g) / (2.0 * g) * ((1.0 + g) / math.sqrt(1.0 + g * g) - 1.0)
        low, high = (g, high) if backwards > share else (low, g)
    return 0.5 * (low + high)


def blackbody_emission(temperature: float, intensity: float) -> Color:
    """Radiance per scene unit of hot gas, as Cycles has it: the law of Stefan and Boltzmann, in units of 10^6 W/m^2."""
    fourth = temperature**4
    power = 5.670373e-8 * 1e-6 / math.pi * (1.0 + intensity * (fourth - 1.0))
    return _times(units.blackbody(temperature), max(power, 0.0)) if power > 0.0 else BLACK


# --------------------------------------------------------------------------------------------------------------- medium


def element(volume: Volume, size: float, warn: Callable[[str], None]) -> xml.Element:
    """Medium of a volume that lies within a body of a size."""
    scattering = BLACK
    for _, color in volume.scattering:
        scattering = _sum(scattering, color)
    emits = max(volume.emission) > 0.0
    absorption = volume.absorption
    if emits:
        least = LEAST_DEPTH / max(size, 1e-9)
        absorption = tuple(max(a, least if e > 0.0 else a) for a, e in zip(absorption, volume.emission))  # type: ignore[assignment]
    medium = xml.plugin("medium", "heterogeneous" if volume.has_grid else "homogeneous")
    xml.add(xml.add(medium, "sigma_a", absorption), "sigma_s", scattering)
    if volume.has_grid:
        _add_grids(medium, volume, LEAST_DEPTH / max(size, 1e-9) / max(*absorption, *scattering))
    if emits:
        xml.add(medium, "emission", tuple(e / a if e > 0.0 else 0.0 for e, a in zip(volume.emission, absorption)))
    return xml.with_children(medium, _phase_element(volume, scattering, warn))


def _add_grids(medium: xml.Element, volume: Volume, least: float) -> None:
    """Adds the grids of a medium, which emits in proportion to its density. Where it emits, the density is at least `least`."""
    box = volume.density or volume.glow
    assert box is not None
    density = (volume.density or box.ones()).values
    if max(volume.emission) > 0.0:
        glow = (volume.glow or box.ones()).values
        glow = glow if glow.ndim == 4 else glow[..., None]
        density = np.where(glow.max(axis=-1) > 0.0, np.maximum(density, least), density)
        xml.add(medium, "emission_factor", box.of(glow / np.maximum(density, 1e-30)[..., None]).element())
    xml.add(medium, "density", box.of(density).element())


def _phase_element(volume: Volume, scattering: Color, warn: Callable[[str], None]) -> xml.Element:
    total = sum(scattering)
    if total <= 0.0:
        return xml.plugin("phase", "isotropic")
    lobes = [(phase, sum(color) / total) for phase, color in volume.scattering]
    for (_, color), (_, share) in zip(volume.scattering, lobes):
        if any(abs(c - share * s) > EVEN * total for c, s in zip(color, scattering)):
            warn("volumes of several colors and phase functions in one place have the same phase function for each color")
            break
    while len(lobes) > 2:
        # The two mean cosines that are nearest to each other become one.
        lobes.sort(key=lambda lobe: (lobe[0].cosine is None, lobe[0].cosine or 0.0))
        warn("more than two phase functions in one place are not supported; those with the nearest mean cosines become one")
        known = [at for at in range(len(lobes) - 1) if lobes[at + 1][0].cosine is not None]
        at = min(known, key=lambda at: lobes[at + 1][0].cosine - lobes[at][0].cosine)  # type: ignore[operator]
        (first, a), (second, b) = lobes[at : at + 2]
        lobes[at : at + 2] = [(Phase((a * first.cosine + b * second.cosine) / (a + b)), a + b)]  # type: ignore[operator]
    made = [_lobe_element(phase) for phase, _ in lobes]
    if len(made) == 1:
        return made[0]
    blend = xml.add(xml.plugin("phase", "blendphase"), "weight", lobes[1][1])
    return xml.with_children(blend, *made)


def _lobe_element(phase: Phase) -> xml.Element:
    if phase.cosine is None:
        return xml.plugin("phase", "rayleigh")
    if phase.cosine == 0.0:
        return xml.plugin("phase", "isotropic")
    return xml.add(xml.plugin("phase", "hg"), "g", phase.cosine)
