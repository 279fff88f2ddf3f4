"""Procedural textures of Blender."""

from __future__ import annotations

import math
from typing import Any, Optional

from .evaluator import Evaluator, Groups, Handler
from .programs import Expression, clamp, dot, length, maximum, select, sine, square_root


def coordinates(e: Evaluator, node: Any, groups: Groups) -> Expression:
    """Coordinates of a texture: without a link, the generated ones."""
    from .input_nodes import generated

    return e.value(node.inputs["Vector"], groups, lambda: generated(e))


def _wave(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    distortion = e.input(node, groups, "Distortion")
    if node.wave_profile != "SIN" or not distortion.is_constant or distortion.constant[0] != 0.0:
        return None
    p = coordinates(e, node, groups) * e.input(node, groups, "Scale", default=1.0)
    p = (p + 0.000001) * 0.999999
    if node.wave_type == "BANDS":
        weights = {"X": (20.0, 0.0, 0.0), "Y": (0.0, 20.0, 0.0), "Z": (0.0, 0.0, 20.0), "DIAGONAL": (10.0, 10.0, 10.0)}
        n = dot(p, weights[node.bands_direction])
    else:
        keep = {"X": (0.0, 1.0, 1.0), "Y": (1.0, 0.0, 1.0), "Z": (1.0, 1.0, 0.0), "SPHERICAL": (1.0, 1.0, 1.0)}
        n = length(p * keep[node.rings_direction]) * 20.0
    return 0.5 + 0.5 * sine(n + e.input(node, groups, "Phase Offset") - 0.5 * math.pi)


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
        value = e.graph.of("cylindrical", coordinates=p).x
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


HANDLERS: dict[str, Handler] = {"TEX_WAVE": _wave, "TEX_GRADIENT": _gradient, "TEX_CHECKER": _checker}
