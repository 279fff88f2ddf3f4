"""Layers of the Principled BSDF as mixtures, whose shares follow the angle from which the surface is seen.

Cycles dims what lies below a layer by the layer's albedo at this angle. So a layer over a base is a `blendbsdf`: its weight is that
albedo, as a table. The second part of a coat is a conductor that reflects all light, times what the rough layer reflects of it: its facets
reflect by their own angles, of which the table has the mean for each angle of the surface.

A dielectric over a diffuse base is one `plastic` or `pplastic` with a weight of its base: what the albedo leaves.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Union

from . import xml
from .color_nodes import table
from .programs import Expression, Graph, absolute, clamp, dot

Color = tuple[float, float, float]
Entries = list[Color]
# Entries of a table, for cosines from 0 to 1.
ENTRIES = 256
# Facets for each of the cosines, on a square of this side.
SIDE = 24
# Roughnesses of a table in two dimensions.
ROUGHNESSES = 17
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


@lru_cache(maxsize=8)
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


def plastic(alpha: Union[float, xml.Element], ior: float) -> xml.Element:
    """Dielectric over a diffuse base. A roughness that varies is a texture."""
    element = xml.plugin("bsdf", "plastic" if alpha == 0.0 else "pplastic")
    if alpha != 0.0:
        xml.add(xml.add(element, "distribution", "ggx"), "alpha", alpha)
    return xml.add(xml.add(element, "int_ior", ior), "ext_ior", 1.0)


@lru_cache(maxsize=256)
def _dielectric(alpha: float, ior: float, tint: Color, is_whole: bool) -> tuple[Any, Any]:
    """For each angle, the share of light that a rough dielectric with a tint at perpendicular incidence keeps from its base, and for each
    channel what it reflects in Cycles over what its lobe reflects in Lodestar. A whole one sheds the light of all reflections among its
    facets (Turquin 2019)."""
    import numpy as np

    to_facet, theirs, ours = _facets(alpha)
    reflectance, least = fresnel(to_facet, ior), ((ior - 1.0) / (ior + 1.0)) ** 2
    shed, lobe_ = theirs.mean(axis=1), (reflectance * ours).mean(axis=1)
    mu = _cosines()
    mean = lambda values: float((mu * values).sum() / mu.sum())  # noqa: E731
    mean_shed, mean_reflectance = mean(shed), mean(fresnel(mu, ior))
    kept, factors = np.zeros_like(mu), []
    for channel in tint:
        face = min(max(channel, 0.0) * least, 1.0)
        tinted = lambda values: face + (1.0 - face) * (values - least) / (1.0 - least)  # noqa: E731, B023
        reflected = (tinted(reflectance) * theirs).mean(axis=1)
        if is_whole:
            once = tinted(mean_reflectance)
            reflected = reflected * (1.0 + once * mean_shed / (1.0 - once * (1.0 - mean_shed)) * (1.0 - shed) / shed)
        kept = np.maximum(kept, reflected if is_whole else reflected / shed)
        factors.append(reflected / lobe_)
    return kept.clip(1e-6, 1.0), np.stack(factors, axis=1)


def dielectric(graph: Graph, alpha: float, ior: float, tint: Color, is_whole: bool) -> tuple[Expression, Expression, float]:
    """Weight of the base of a dielectric, and the factor of its lobe: an expression in [0, 1] and a number."""
    kept, factors = _dielectric(alpha, ior, tint, is_whole)
    most = float(factors.max())
    at = cosine(graph)
    return table(at, _colors([1.0 - kept] * 3)), table(at, _colors((factors / most).T)), most


@lru_cache(maxsize=64)
def _of_roughness(ior: float, is_whole: bool) -> tuple[Any, Any]:
    """The same for roughnesses from 0 to 1, one a column, without a tint."""
    import numpy as np

    found = [_dielectric(at * at, ior, (1.0, 1.0, 1.0), is_whole) for at in np.linspace(0.0, 1.0, ROUGHNESSES)]
    return np.stack([kept for kept, _ in found], axis=1), np.stack([factors[:, 0] for _, factors in found], axis=1)


def _of_both(at: Expression, roughness: Expression, values: Any) -> Expression:
    """Table in two dimensions: the sum of three products of a function of the angle and one of the roughness."""
    import numpy as np

    left, sizes, right = np.linalg.svd(values, full_matrices=False)
    roots = np.sqrt(sizes[:3])
    of_angle, of_roughness = ([tuple(row) for row in rows] for rows in (left[:, :3] * roots, right[:3].T * roots))
    return dot(table(at, of_angle), table(roughness, of_roughness))


def uneven_dielectric(roughness: Expression, ior: float, is_whole: bool) -> tuple[Expression, Expression, float]:
    """The same for a roughness that varies, without a tint."""
    kept, factors = _of_roughness(ior, is_whole)
    most = 1.05 * float(factors.max())
    at = cosine(roughness.graph)
    weight = clamp(_of_both(at, roughness, 1.0 - kept), 0.0, 1.0)
    return weight, _of_both(at, roughness, factors / most), most
