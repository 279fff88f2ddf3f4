"""Subsurface: the medium below a surface, and the surface that light enters and leaves it by.

Cycles' random walk bends light where it enters, by facets of the surface's roughness, lets it walk in a medium, and sheds it diffusely where it
leaves. So does the renderer: the front of the surface is a dielectric, its back transmits diffusely, and between them is a medium.
"""

from __future__ import annotations

import math
from typing import Optional

from . import xml
from .nodes import Color
from .volumes import Volume, of_cosine

# Largest single-scattering albedo and mean cosine, as in Cycles.
MOST_ALBEDO = 0.999999
MOST_COSINE = 0.9
# Albedo of the medium below a surface whose color varies: the color tints the light that enters.
ALBEDO_BELOW_TEXTURES = 0.9
# Id of the dielectric that light enters the medium by, until the surface is complete.
ENTERING = "entering"
# Shortest mean free path, as a share of the longest channel's: light of the other channels leaves where it enters.
LEAST_PATH = 1e-3


def medium(albedo: Color, radius: Color, cosine: float, method: str, ior: float) -> Optional[Volume]:
    """Medium of a walk that sheds the albedo from a half-space; None where light leaves where it enters."""
    color = tuple(min(max(channel, 0.0), 1.0) for channel in albedo)
    if method == "RANDOM_WALK_SKIN":
        index = min(max(ior, 1.01), 3.8)
        paths = [r * math.sqrt(3.0 * (1.0 - _diffusion_albedo(c, index))) for r, c in zip(radius, color)]
    else:
        paths = [0.25 / math.pi * r for r in radius]
    longest = max(paths)
    if longest < 1e-8:
        return None
    g = min(max(cosine, 0.0), MOST_COSINE)
    extinction = [1.0 / (max(path, LEAST_PATH * longest) * (1.0 - g)) for path in paths]
    shares = [_single_albedo(channel, g) for channel in color]
    scattering = tuple(e * s for e, s in zip(extinction, shares))
    absorption = tuple(e - s for e, s in zip(extinction, scattering))
    return Volume(absorption, ((of_cosine(g), scattering),))  # type: ignore[arg-type]


def _single_albedo(albedo: float, g: float) -> float:
    """Share of scattering with which a half-space has an albedo, as Cycles fits it (Chiang et al. 2016; Wrenninge et al. 2017)."""
    powers = [g**n for n in range(8)]
    fit = lambda *factors: sum(f * p for f, p in zip(factors, powers))  # noqa: E731
    a = fit(1.8260523782, -1.28451056436, -1.79904629312, 9.19393289202, -22.8215585862, 32.0234874259, -23.6264803333, 7.21067002658)
    b = 4.98511194385 + 0.127355959438 * math.exp(
        fit(0.0, 31.1491581433, -201.847017512, 841.576016723, -2018.09288505, 2731.71560286, -1935.41424244, 559.009054474)
    )
    c = fit(1.09686102424, -0.394704063468, 1.05258115941, -8.83963712726, 28.8643230661, -46.8802913581, 38.5402837518, -12.7181042538)
    d = fit(0.496310210422, 0.360146581622, -2.15139309747, 17.8896899217, -55.2984010333, 82.065982243, -58.5106008578, 15.8478295021)
    e = 4.23190299701 + 0.00310603949088 * math.exp(
        fit(0.0, 76.7316253952, -594.356773233, 2448.8834203, -5576.68528998, 7116.60171912, -4763.54467887, 1303.5318055)
    )
    f = fit(2.40602999408, -2.51814844609, 9.18494908356, -79.2191708682, 259.082868209, -403.613804597, 302.85712436, -87.4370473567)
    blend = albedo**0.25
    found = (1.0 - blend) * a * math.atan(b * albedo) ** c + blend * d * math.atan(e * albedo) ** f
    return min(max(found, 0.0), MOST_ALBEDO)


def _diffusion_albedo(albedo: float, ior: float) -> float:
    """Reduced albedo of a diffusion dipole with an albedo (Jensen et al. 2001)."""
    if albedo < 1e-4 or albedo >= 0.995:
        return 0.0 if albedo < 1e-4 else MOST_ALBEDO
    internal = (-1.440 / ior + 0.710) / ior + 0.668 + 0.0636 * ior
    boundary = 4.0 / 3.0 * (1.0 + internal) / (1.0 - internal)
    low, high = 0.0, 1.0
    for _ in range(24):
        middle = 0.5 * (low + high)
        s = math.sqrt(3.0 * (1.0 - middle))
        low, high = (middle, high) if 0.5 * middle * (1.0 + math.exp(-boundary * s)) * math.exp(-s) < albedo else (low, middle)
    return 0.5 * (low + high)


def transmitting() -> xml.Element:
    """Surface that all light passes diffusely. It has no color yet."""
    return xml.plugin("bsdf", "difftrans")


def _leaving(front: xml.Element) -> xml.Element:
    """Surface that light of the medium passes, and that sheds it diffusely. Below a dielectric, radiance is higher."""
    leaving = xml.add(transmitting(), "transmittance", (1.0, 1.0, 1.0))
    index = next((part.find("float[@name='int_ior']") for part in front.iter("bsdf") if part.get("id") == ENTERING), None)
    if index is not None:
        ior = float(index.get("value", "1"))
        for part in front.iter("bsdf"):
            if part.get("type") == "difftrans":
                xml.add(xml.add(part, "int_ior", 1.0), "ext_ior", ior)
        xml.add(xml.add(leaving, "int_ior", ior), "ext_ior", 1.0)
    return leaving


def around(front: xml.Element) -> Optional[xml.Element]:
    """Front of a surface with the back that light of the medium leaves by; None where the front has holes that it is not all in."""
    if front.get("type") == "mask":
        inner = next(child for child in front if child.tag == "bsdf")
        covered = around(inner)
        if covered is not None:
            front[list(front).index(inner)] = covered
        return front if covered is not None else None
    front = _one_sided(front)
    if any(part.get("type") in ("mask", "null", "thindielectric") for part in front.iter("bsdf")):
        return None
    leaving = _leaving(front)
    for part in front.iter("bsdf"):
        part.attrib.pop("id", None)
    return xml.with_children(xml.plugin("bsdf", "twosided"), front, leaving)


def _one_sided(element: xml.Element) -> xml.Element:
    """Surface without `twosided`, as one side has it."""
    while element.get("type") == "twosided":
        element = next(child for child in element if child.tag == "bsdf")
    for at, child in enumerate(list(element)):
        if child.tag == "bsdf":
            element[at] = _one_sided(child)
    return element
