"""Layers of the Principled BSDF as mixtures, whose shares follow the angle from which the surface is seen.

Cycles dims what lies below a layer by the layer's albedo at this angle. So a layer over a base is a `blendbsdf`: its weight is that
albedo, as a table, and its second part is a conductor that reflects all light, times what the rough layer reflects of it. The facets of
a layer reflect by their own angles; the table has the mean of that for each angle of the surface.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from . import xml
from .color_nodes import table
from .programs import Expression, Graph, absolute, dot

Color = tuple[float, float, float]
Entries = list[Color]
# Entries of a table, for cosines from 0 to 1.
ENTRIES = 256
# Facets for each of the cosines, on a square of this side.
SIDE = 24
# Schlick's weight of the color at grazing angles, at the cosine of 1/7, which is 82 degrees.
AT_82 = (6.0 / 7.0) ** 5


def cosine(graph: Graph) -> Expression:
    """Cosine of the angle from which a surface is seen."""
    return absolute(dot(graph.source("shading_normal"), graph.source("incoming")))


def lobe(alpha: float) -> xml.Element:
    """Conductor that reflects all light; without roughness, a mirror."""
    if alpha == 0.0:
        return xml.plugin("bsdf", "conductor")
    return xml.add(xml.add(xml.plugin("bsdf", "roughconductor"), "distribution", "ggx"), "alpha", alpha)


# ---------------------------------------------------------------------------------------------------------- albedos


def _cosines() -> Any:
    import numpy as np

    return np.maximum(np.arange(ENTRIES) / (ENTRIES - 1.0), 1e-3)


@lru_cache(maxsize=64)
def _facets(alpha: float) -> tuple[Any, Any, Any]:
    """For each angle, cosines between it and the visible facets' normals (Dupuy and Benyoub 2023), and the share of light that leaves:
    in Cycles, whose masking and shadowing are correlated, and in Lodestar, where they are separate."""
    import numpy as np

    mu = _cosines()[:, None]
    if alpha == 0.0:
        return mu, np.ones_like(mu), np.ones_like(mu)
    u, v = (each.ravel()[None, :] for each in np.meshgrid(*((np.arange(SIDE) + 0.5) / SIDE,) * 2))
    sine = np.sqrt(1.0 - mu * mu)
    stretched = np.hypot(alpha * sine, mu)
    x, z = alpha * sine / stretched, mu / stretched
    height = (1.0 - v) * (1.0 + z) - z
    radius = np.sqrt(np.maximum(1.0 - height * height, 0.0))
    normal = [alpha * (radius * np.cos(2.0 * np.pi * u) + x), alpha * radius * np.sin(2.0 * np.pi * u), height + z]
    length = np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
    to_facet = np.clip((normal[0] * sine + normal[2] * mu) / length, 0.0, 1.0)
    left = 2.0 * to_facet * normal[2] / length - mu
    hidden = lambda c: 0.5 * (np.sqrt(1.0 + alpha * alpha * (1.0 / np.maximum(c * c, 1e-12) - 1.0)) - 1.0)  # noqa: E731
    seen, leaves = hidden(mu), hidden(left)
    return to_facet, np.where(left > 0.0, (1.0 + seen) / (1.0 + seen + leaves), 0.0), np.where(left > 0.0, 1.0 / (1.0 + leaves), 0.0)


def fresnel(cosines: Any, ior: float) -> Any:
    """Share of light that a dielectric reflects."""
    import numpy as np

    inside = np.sqrt(np.maximum(1.0 - (1.0 - cosines * cosines) / (ior * ior), 0.0))
    across = (cosines - ior * inside) / (cosines + ior * inside)
    along = (ior * cosines - inside) / (ior * cosines + inside)
    return 0.5 * (across * across + along * along)


def _colors(channels: Any) -> Entries:
    import numpy as np

    red, green, blue = (np.broadcast_to(each, (ENTRIES,)) for each in channels)
    return [(float(r), float(g), float(b)) for r, g, b in zip(red, green, blue)]


# ------------------------------------------------------------------------------------------------------------- coat


def coat_albedo(graph: Graph, ior: float) -> Expression:
    """Share of light that a coat keeps from its base. In Cycles it is that of a smooth coat."""
    return table(cosine(graph), _colors([fresnel(_cosines(), ior)] * 3))


def coat_factor(graph: Graph, alpha: float, ior: float) -> Expression:
    """Factor of the lobe of a rough coat."""
    to_facet, theirs, ours = _facets(alpha)
    factor = (fresnel(to_facet, ior) * theirs).mean(axis=1) / (fresnel(_cosines(), ior) * ours.mean(axis=1))
    return table(cosine(graph), _colors([factor.clip(0.0, 1.0)] * 3))


def coat_tint(graph: Graph, tint: Color, ior: float) -> Expression:
    """What a tinted coat lets pass: its tint at perpendicular incidence, and more of it on longer ways."""
    import numpy as np

    mu = _cosines()
    way = 1.0 / np.sqrt(np.maximum(1.0 - (1.0 - mu * mu) / (ior * ior), 1e-6))
    return table(cosine(graph), _colors([max(channel, 0.0) ** way for channel in tint]))


# ------------------------------------------------------------------------------------------------------------ metal


def metal_color(base: Expression, alpha: float, tint: Color) -> Expression:
    """Factor of the lobe of a metal that has a color at perpendicular incidence and a tint at 82 degrees (Kutz et al. 2021)."""
    to_facet, theirs, ours = _facets(alpha)
    mean = lambda values: (values * theirs).mean(axis=1) / ours.mean(axis=1)  # noqa: E731
    rest = 1.0 - to_facet
    face, edge, dip = mean(1.0 - rest**5), mean(rest**5), mean(to_facet * rest**6) * 7.0 / (AT_82 * 6.0 / 7.0)
    lacking = [1.0 - min(max(channel, 0.0), 1.0) for channel in tint]
    at = cosine(base.graph)
    of_color = table(at, _colors([face - (1.0 - AT_82) * each * dip for each in lacking]))
    return base * of_color + table(at, _colors([edge - AT_82 * each * dip for each in lacking]))


# ------------------------------------------------------------------------------------------------------- dielectric


def specular(graph: Graph, alpha: float, ior: float, tint: Color) -> tuple[Expression, Expression]:
    """Share of light that a rough dielectric with a tint at perpendicular incidence keeps from its base, and the factor of its lobe."""
    import numpy as np

    to_facet, theirs, ours = _facets(alpha)
    least = ((ior - 1.0) / (ior + 1.0)) ** 2
    towards = (fresnel(to_facet, ior) - least) / (1.0 - least)
    share = (towards * theirs).mean(axis=1) / theirs.mean(axis=1)
    faces = [min(max(channel, 0.0) * least, 1.0) for channel in tint]
    kept = np.max([face + (1.0 - face) * share for face in faces], axis=0).clip(1e-6, 1.0)
    factors = [((face + (1.0 - face) * towards) * theirs).mean(axis=1) / (kept * ours.mean(axis=1)) for face in faces]
    at = cosine(graph)
    return table(at, _colors([kept] * 3)), table(at, _colors([each.clip(0.0, 1.0) for each in factors]))
