"""Facets: factors by which rough metals and rough glass shed what those of Cycles do, at each angle from which they are seen.

A lobe of the renderer has facets of which masking and shadowing are separate, and light leaves after one reflection. In Cycles they are
correlated, and a *Multiscatter GGX* lobe is made so much brighter that it sheds the light of all reflections among its facets (Turquin 2019).
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple, Optional, Union

from . import layers
from .color_nodes import table
from .limits import excess
from .programs import Expression, Graph, clamp, dot, less, select

Color = tuple[float, float, float]
# Facets for each of the angles, on a square of this side, and roughnesses of a table in two dimensions.
SIDE, ROUGHNESSES = 32, 17
# Angles of a table: cosines from 0 to 1.
ENTRIES = 256
# Least index of glass; Blender's socket begins at 0.
LEAST_INDEX = 1e-3
# Largest difference from 1 that is left out.
NEAR_ONE = 0.003


class Shares(NamedTuple):
    """For each angle, what a white lobe reflects once in Cycles over what it reflects in Lodestar, that share in Cycles, and its mean."""

    factor: Any
    shed: Any
    mean: float


class Facets(NamedTuple):
    """For each angle, in a row: the weights of visible facets, and cosines between facets and the view, and facets and the surface."""

    weights: Any
    to_view: Any
    to_normal: Any


def _cosines() -> Any:
    import numpy as np

    return np.maximum(np.arange(ENTRIES) / (ENTRIES - 1.0), 2e-3)


@lru_cache(maxsize=8)
def _facets(alpha: float, is_beckmann: bool) -> Facets:
    import numpy as np

    mu = _cosines()[:, None]
    u, v = (each.ravel()[None, :] for each in np.meshgrid(*((np.arange(SIDE) + 0.5) / SIDE,) * 2))
    sine = np.sqrt(1.0 - mu * mu)
    if is_beckmann:
        # Facets as they are distributed; those that are seen have more weight.
        tangent = alpha * np.sqrt(-np.log(1.0 - u))
        z = 1.0 / np.sqrt(1.0 + tangent * tangent)
        to_view = tangent * z * np.cos(2.0 * np.pi * v) * sine + z * mu
        weights = np.maximum(to_view, 0.0) / z
        return Facets(weights / weights.sum(axis=1, keepdims=True), np.maximum(to_view, 1e-4), z)
    # Visible facets (Dupuy and Benyoub 2023).
    stretched = np.hypot(alpha * sine, mu)
    height = (1.0 - v) * (1.0 + mu / stretched) - mu / stretched
    radius = np.sqrt(np.maximum(1.0 - height * height, 0.0))
    x, y = alpha * (radius * np.cos(2.0 * np.pi * u) + alpha * sine / stretched), alpha * radius * np.sin(2.0 * np.pi * u)
    z = height + mu / stretched
    length = np.sqrt(x * x + y * y + z * z)
    to_view = ((x * sine + z * mu) / length).clip(1e-4, 1.0)
    return Facets(np.full_like(to_view, 1.0 / to_view.shape[1]), to_view, z / length)


def _leaving(facets: Facets, left: Any, alpha: float, is_beckmann: bool) -> tuple[Any, Any]:
    """Share of the light that leaves at the cosines `left`, in Cycles and in Lodestar, for each facet."""
    import numpy as np

    seen, leaves = _hidden(_cosines()[:, None], alpha, is_beckmann), _hidden(np.maximum(left, 1e-4), alpha, is_beckmann)
    weights = np.where(left > 0.0, facets.weights, 0.0)
    return weights * (1.0 + seen) / (1.0 + seen + leaves), weights / (1.0 + leaves)


@lru_cache(maxsize=256)
def shares(alpha: float, is_beckmann: bool) -> Shares:
    """Shares of a roughness."""
    facets = _facets(alpha, is_beckmann)
    left = 2.0 * facets.to_view * facets.to_normal - _cosines()[:, None]
    theirs, ours = (each.sum(axis=1) for each in _leaving(facets, left, alpha, is_beckmann))
    return Shares(theirs / ours, theirs.clip(1e-3, 1.0), _mean(theirs))


def _mean(values: Any) -> float:
    """Mean over the light that comes from all angles."""
    mu = _cosines()
    return float((mu * values).sum() / mu.sum())


def _hidden(cosines: Any, alpha: float, is_beckmann: bool) -> Any:
    """Smith's Lambda: the area of facets that others hide, over the area of those that are seen."""
    import numpy as np

    squared = alpha * alpha * (1.0 / np.maximum(cosines * cosines, 1e-12) - 1.0)
    if not is_beckmann:
        return 0.5 * (np.sqrt(1.0 + squared) - 1.0)
    a = 1.0 / np.sqrt(np.maximum(squared, 1e-12))
    return np.where(a < 1.6, (1.0 - 1.259 * a + 0.396 * a * a) / (3.535 * a + 2.181 * a * a), 0.0)


def metal(
    graph: Graph, color: Union[Color, Expression], roughness: Union[float, Expression], is_beckmann: bool, is_whole: bool
) -> Optional[tuple[Expression, float]]:
    """Color of the lobe of a rough metal that has a color: an expression in [0, 1] and a number. None where the metal is nearly smooth,
    so that its own color is as good, or where the program is too long."""
    if isinstance(roughness, Expression):
        factor, more, mean, most = _of_both(layers.cosine(graph), graph.of("luminance", value=roughness), is_beckmann)
    else:
        found = shares(min(roughness, 1.0) ** 2, is_beckmann)
        lacking = _lacking(found)
        seen = slice(ENTRIES // 5, None)
        if max(abs(found.factor - 1.0)[seen].max(), lacking[seen].max() if is_whole else 0.0) < NEAR_ONE:
            return None
        both = table(layers.cosine(graph), [(float(a), float(b), 0.0) for a, b in zip(found.factor, lacking)])
        factor, more, mean, most = both.x, both.y, graph.constant(found.mean), float((found.factor + lacking).max())
    base = color if isinstance(color, Expression) else graph.constant(color)
    if is_whole:
        kept = clamp(base, 0.0, 1.0)
        factor = factor + more * (kept * mean / (1.0 - kept * (1.0 - mean)))
    result = base * factor / most
    return (result, most) if excess(result) is None else None


def _lacking(found: Shares) -> Any:
    """Light of further reflections, as a factor of the lobe of a white metal."""
    return found.factor * (1.0 - found.shed) / found.shed


@lru_cache(maxsize=2)
def _of_roughness(is_beckmann: bool) -> tuple[Any, Any, list[float]]:
    import numpy as np

    found = [shares(max(float(at), 0.01) ** 2, is_beckmann) for at in np.linspace(0.0, 1.0, ROUGHNESSES)]
    return np.stack([each.factor for each in found], axis=1), np.stack([*map(_lacking, found)], axis=1), [each.mean for each in found]


def _of_both(at: Expression, roughness: Expression, is_beckmann: bool) -> tuple[Expression, Expression, Expression, float]:
    factor, more, means = _of_roughness(is_beckmann)
    products = [layers._of_both(at, roughness, values) for values in (factor, more)]
    return products[0], products[1], table(roughness, [(mean,) * 3 for mean in means]), 1.05 * float((factor + more).max())


def disney_base(graph: Graph, base: Union[Color, Expression], roughness: float, is_whole: bool) -> Optional[tuple[Expression, float]]:
    """Base color by which a metal of Disney, whose facets reflect by Schlick's curve, sheds as much light as that of Cycles: as `metal` gives
    a color."""
    import numpy as np

    alpha = min(roughness, 1.0) ** 2
    facets, found = _facets(alpha, False), shares(alpha, False)
    left = 2.0 * facets.to_view * facets.to_normal - _cosines()[:, None]
    theirs, ours = _leaving(facets, left, alpha, False)
    at_edge = (1.0 - facets.to_view) ** 5
    face, edge = ((1.0 - at_edge) * theirs).sum(axis=1), (at_edge * theirs).sum(axis=1)
    face_here, edge_here = ((1.0 - at_edge) * ours).sum(axis=1).clip(1e-4, None), (at_edge * ours).sum(axis=1)
    again = (1.0 - found.shed) / found.shed if is_whole else np.zeros(ENTRIES)
    more = lambda mean: mean * found.mean / (1.0 - mean * (1.0 - found.mean))  # noqa: E731
    most = float((((face + edge) * (1.0 + again) - edge_here) / face_here)[ENTRIES // 20 :].max())
    if most < 1.0 + NEAR_ONE:
        return None
    if not isinstance(base, Expression):
        color = np.clip(base, 0.0, 1.0)
        wanted = (face[:, None] * color + edge[:, None]) * (1.0 + again[:, None] * more((20.0 * color + 1.0) / 21.0))
        rows = ((wanted - edge_here[:, None]) / face_here[:, None] / most).clip(0.0, 1.0)
        return table(layers.cosine(graph), [tuple(map(float, row)) for row in rows]), most
    columns = (face / face_here, edge / face_here, again), (edge_here / face_here / most,) * 3
    of_view, lost = (table(layers.cosine(graph), [tuple(map(float, row)) for row in zip(*three)]) for three in columns)
    wanted_ = base * of_view.x + of_view.y
    if is_whole:
        wanted_ = wanted_ * (1.0 + of_view.z * more((20.0 / 21.0) * clamp(base, 0.0, 1.0) + 1.0 / 21.0))
    result = wanted_ / most - lost
    return (result, most) if excess(result) is None else None


# ------------------------------------------------------------------------------------------------------------ glass


@lru_cache(maxsize=64)
def _glass(alpha: float, ior: float, is_beckmann: bool) -> tuple[Any, Any, Any, float]:
    """For each angle, what glass of an index toward the other side reflects in Cycles over what it reflects in Lodestar, the same for what
    it transmits, the share of light that leaves it in Cycles, and the mean of this share."""
    import numpy as np

    facets = _facets(alpha, is_beckmann)
    mu, cosine = _cosines()[:, None], facets.to_view
    across = 1.0 - (1.0 - cosine * cosine) / (ior * ior)
    beyond = np.sqrt(np.maximum(across, 0.0))
    reflectance = np.where(across > 0.0, layers.fresnel(cosine, ior), 1.0)
    factors, total = [], np.zeros(ENTRIES)
    for part, left in (
        (reflectance, 2.0 * cosine * facets.to_normal - mu),
        (1.0 - reflectance, mu / ior - (cosine / ior - beyond) * facets.to_normal),
    ):
        theirs, ours = ((part * each).sum(axis=1) for each in _leaving(facets, left, alpha, is_beckmann))
        factors.append(np.where(ours > 1e-6, theirs / np.maximum(ours, 1e-6), 1.0))
        total += theirs
    total = total.clip(1e-3, 1.0)
    return factors[0], factors[1], total, _mean(total)


def glass(
    graph: Graph, color: Color, roughness: float, ior: float, is_beckmann: bool, is_whole: bool
) -> Optional[list[tuple[Expression, float]]]:
    """Colors of what rough glass of one color reflects and transmits, as those of a metal. None where the glass is nearly smooth."""
    import numpy as np

    alpha, cosines = min(roughness, 1.0) ** 2, np.arange(ENTRIES) / (ENTRIES - 1.0)
    sides = []
    ior = max(ior, LEAST_INDEX)
    for index in (ior, 1.0 / ior):
        reflected, transmitted, total, mean = _glass(alpha, index, is_beckmann)
        again = np.array([[each * mean / (1.0 - each * (1.0 - mean)) for each in np.clip(color, 0.0, 1.0)]])
        more = 1.0 + again * ((1.0 - total) / total)[:, None] if is_whole else np.ones((ENTRIES, 3))
        sides.append([each[:, None] * more for each in (reflected, transmitted)])
    if max(np.abs(each - 1.0)[cosines > 0.2].max() for side in sides for each in side) < NEAR_ONE:
        return None
    inside = less(dot(graph.source("shading_normal"), graph.source("incoming")), 0.0)
    found = []
    for outer, inner in zip(*sides):
        most = float(max(outer.max(), inner.max()))
        tables = [table(layers.cosine(graph), [tuple(map(float, row)) for row in side / most * color]) for side in (inner, outer)]
        found.append((select(inside, *tables), most))
    return found
