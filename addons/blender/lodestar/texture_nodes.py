"""Procedural textures of Blender."""

from __future__ import annotations

import math
from typing import Any, Optional

from .evaluator import Evaluator, Groups, Handler
from .hashes import hash_of_floats
from .programs import (
    Expression, absolute, arctangent, clamp, combine, cosine, dot, floor, length, maximum, mix, select, sine, square_root, truncated,
)

# The renderer's names of Blender's sums of octaves are Blender's in lower case.
FEATURES = {"F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE", "N_SPHERE_RADIUS"}


def offset(seed: float, dimensions: int) -> tuple[float, ...]:
    """Shift of a noise's coordinates that makes another noise of it."""
    if dimensions == 1:
        return (100.0 + 100.0 * hash_of_floats(seed),)
    return tuple(100.0 + 100.0 * hash_of_floats(seed, float(axis)) for axis in range(dimensions))


class _Point:
    """Coordinates of a noise: a point and a fourth number, of which a noise has as many as it has dimensions."""

    def __init__(self, dimensions: int, vector: Expression, w: Expression) -> None:
        self.dimensions, self.vector, self.w = dimensions, vector, w

    def moved(self, by: "list[Expression] | tuple[float, ...]") -> "_Point":
        """Coordinates plus a shift."""
        graph = self.vector.graph
        if self.dimensions == 1:
            return _Point(1, self.vector, self.w + by[0])
        three = combine(*(graph.operand(by[at]) if at < len(by) else graph.constant(0.0) for at in range(3)))
        return _Point(self.dimensions, self.vector + three, self.w + by[3] if self.dimensions == 4 else self.w)


def noise(point: _Point, **parameters: Any) -> Expression:
    """The renderer's noise at a point."""
    return point.vector.graph.of(f"noise_{point.dimensions}d", coordinates=point.vector, w=point.w, **parameters)


def _point(e: Evaluator, node: Any, groups: Groups, dimensions: int) -> _Point:
    scale = e.input(node, groups, "Scale", default=1.0)
    none = e.graph.constant(0.0)
    vector = coordinates(e, node, groups) * scale if dimensions > 1 else none
    w = e.input(node, groups, "W") * scale if dimensions in (1, 4) else none
    return _Point(dimensions, vector, w)


def coordinates(e: Evaluator, node: Any, groups: Groups) -> Expression:
    """Coordinates of a texture: without a link, the generated ones."""
    from .input_nodes import generated

    return e.value(node.inputs["Vector"], groups, lambda: generated(e))


def _noise(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    dimensions = int(node.noise_dimensions[0])
    point = _point(e, node, groups, dimensions)
    kind = getattr(node, "noise_type", "FBM").lower()
    normalize = int(getattr(node, "normalize", True))
    distortion = e.input(node, groups, "Distortion")
    if not (distortion.is_constant and distortion.constant[0] == 0.0):
        single = {"kind": "fbm", "normalize": 0, "detail": 0.0}
        shifts = [noise(point.moved(offset(float(at), dimensions)), **single) * distortion for at in range(dimensions)]
        point = point.moved(shifts)
    parameters: dict[str, Any] = {
        "kind": kind,
        "normalize": normalize,
        "detail": e.input(node, groups, "Detail"),
        "roughness": e.input(node, groups, "Roughness", default=0.5),
        "lacunarity": e.input(node, groups, "Lacunarity", default=2.0),
        "offset": e.input(node, groups, "Offset"),
        "gain": e.input(node, groups, "Gain", default=1.0),
    }
    first = noise(point, **parameters)
    if output.name != "Color":
        return first
    others = [noise(point.moved(offset(float(dimensions + at), dimensions)), **parameters) for at in range(2)]
    return combine(first, *others)


def _voronoi(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    if node.feature not in FEATURES:
        return None
    dimensions = int(node.voronoi_dimensions[0])
    point = _point(e, node, groups, dimensions)
    exponent = e.input(node, groups, "Exponent", default=0.5)
    if node.distance == "MINKOWSKI" and not exponent.is_constant:
        return None
    asked = output.name.lower()
    if (node.feature == "N_SPHERE_RADIUS") != (asked == "radius") or (node.feature == "DISTANCE_TO_EDGE" and asked != "distance"):
        return e.graph.constant(0.0)
    value = e.graph.of(
        f"voronoi_{dimensions}d",
        coordinates=point.vector,
        w=point.w,
        detail=e.input(node, groups, "Detail"),
        roughness=e.input(node, groups, "Roughness"),
        lacunarity=e.input(node, groups, "Lacunarity", default=2.0),
        smoothness=e.input(node, groups, "Smoothness"),
        randomness=e.input(node, groups, "Randomness", default=1.0),
        feature=node.feature.lower(),
        metric=node.distance.lower(),
        output="distance" if asked == "radius" else asked,
        normalize=int(getattr(node, "normalize", False)),
        exponent=exponent if node.distance == "MINKOWSKI" else e.graph.constant(0.5),
    )
    if asked in ("position", "w"):
        value = value / e.input(node, groups, "Scale", default=1.0)
    return value if asked in ("color", "position") else value.x


def _white_noise(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    none = e.graph.constant(0.0)
    dimensions = int(node.noise_dimensions[0])
    vector = e.input(node, groups, "Vector") if dimensions > 1 else none
    w = e.input(node, groups, "W") if dimensions in (1, 4) else none
    value = e.graph.of("white_noise", coordinates=vector, w=w, dimensions=dimensions)
    return value if output.name == "Color" else value.x


def _wave(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    p = coordinates(e, node, groups) * e.input(node, groups, "Scale", default=1.0)
    p = (p + 0.000001) * 0.999999
    if node.wave_type == "BANDS":
        weights = {"X": (20.0, 0.0, 0.0), "Y": (0.0, 20.0, 0.0), "Z": (0.0, 0.0, 20.0), "DIAGONAL": (10.0, 10.0, 10.0)}
        n = dot(p, weights[node.bands_direction])
    else:
        keep = {"X": (0.0, 1.0, 1.0), "Y": (1.0, 0.0, 1.0), "Z": (1.0, 1.0, 0.0), "SPHERICAL": (1.0, 1.0, 1.0)}
        n = length(p * keep[node.rings_direction]) * 20.0
    n = n + e.input(node, groups, "Phase Offset")
    distortion = e.input(node, groups, "Distortion")
    if not (distortion.is_constant and distortion.constant[0] == 0.0):
        point = _Point(3, p * e.input(node, groups, "Detail Scale", default=1.0), e.graph.constant(0.0))
        octaves = {"detail": e.input(node, groups, "Detail"), "roughness": e.input(node, groups, "Detail Roughness", default=0.5)}
        n = n + distortion * (noise(point, kind="fbm", normalize=1, **octaves) * 2.0 - 1.0)
    if node.wave_profile == "SIN":
        return 0.5 + 0.5 * sine(n - 0.5 * math.pi)
    n = n * (0.5 / math.pi)
    if node.wave_profile == "SAW":
        return n - floor(n)
    return absolute(n - floor(n + 0.5)) * 2.0


def _magic(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    p = coordinates(e, node, groups)
    scale, distortion = e.input(node, groups, "Scale", default=5.0), e.input(node, groups, "Distortion", default=1.0)
    p = p - truncated(p * (0.5 / math.pi)) * (2.0 * math.pi)
    px, py, pz = p.x, p.y, p.z
    five = 5.0 * scale
    x, y, z = sine((px + py + pz) * five), cosine((-px + py - pz) * five), -cosine((-px - py + pz) * five)
    depth = node.turbulence_depth
    if depth > 0:
        x, y, z = x * distortion, y * distortion, z * distortion
        y = -cosine(x - y + z) * distortion
    if depth > 1:
        x = cosine(x - y - z) * distortion
    if depth > 2:
        z = sine(-x - y - z) * distortion
    if depth > 3:
        x = -cosine(-x + y - z) * distortion
    if depth > 4:
        y = -sine(-x + y + z) * distortion
    if depth > 5:
        y = -cosine(-x + y + z) * distortion
    if depth > 6:
        x = cosine(x + y + z) * distortion
    if depth > 7:
        z = sine(x + y - z) * distortion
    if depth > 8:
        x = -cosine(-x - y + z) * distortion
    if depth > 9:
        y = -sine(x - y + z) * distortion
    if distortion.is_constant and distortion.constant[0] == 0.0:
        color = 0.5 - combine(x, y, z)
    else:
        color = 0.5 - combine(x, y, z) / (2.0 * distortion)
    return color if output.name == "Color" else dot(color, (1.0 / 3.0,) * 3)


def _gradient(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    p = coordinates(e, node, groups)
    x = p.x
    kind = node.gradient_type
    if kind == "LINEAR":
        value = x
    elif kind == "QUADRATIC":
        value = maximum(x, 0.0) * maximum(x, 0.0)
    elif kind == "EASING":
        t = clamp(x)
        value = t * t * (3.0 - 2.0 * t)
    elif kind == "DIAGONAL":
        value = (x + p.y) * 0.5
    elif kind == "RADIAL":
        value = arctangent(p.y, x) * (0.5 / math.pi) + 0.5
    else:
        r = maximum(0.999999 - square_root(dot(p, p)), 0.0)
        value = r * r if kind == "QUADRATIC_SPHERE" else r
    return clamp(value)


def _checker(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    p = coordinates(e, node, groups) * e.input(node, groups, "Scale", default=5.0)
    first = e.graph.of("checker", coordinates=(p + 0.000001) * 0.999999)
    if output.name != "Color":
        return first
    return select(first, e.input(node, groups, "Color1"), e.input(node, groups, "Color2"))


def _brick(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    p = coordinates(e, node, groups) * e.input(node, groups, "Scale", default=5.0)
    sizes = {
        "mortar": e.input(node, groups, "Mortar Size"),
        "smoothness": e.input(node, groups, "Mortar Smooth"),
        "bias": e.input(node, groups, "Bias"),
        "width": e.input(node, groups, "Brick Width"),
        "height": e.input(node, groups, "Row Height"),
    }
    wall = e.graph.of(
        "bricks", coordinates=p, **sizes, offset=node.offset, squash=node.squash,
        offset_rows=node.offset_frequency, squash_rows=node.squash_frequency,
    )  # fmt: skip
    share = wall.y
    if output.name != "Color":
        return share
    brick = mix(e.input(node, groups, "Color1"), e.input(node, groups, "Color2"), wall.x)
    return mix(brick, e.input(node, groups, "Mortar"), share)


HANDLERS: dict[str, Handler] = {
    "TEX_NOISE": _noise,
    "TEX_VORONOI": _voronoi,
    "TEX_WHITE_NOISE": _white_noise,
    "TEX_WAVE": _wave,
    "TEX_MAGIC": _magic,
    "TEX_GRADIENT": _gradient,
    "TEX_CHECKER": _checker,
    "TEX_BRICK": _brick,
}
