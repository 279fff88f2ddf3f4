"""Nodes that compute with colors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Optional

from .evaluator import LUMINANCE, Evaluator, Groups, Handler
from .programs import Expression, absolute, clamp, combine, dot, maximum, minimum, mix, power

Blend = Callable[[Expression, Expression, Expression], Expression]
# Least distance of two stops of a ramp: the entries of Cycles' table of it are as far apart.
LEAST_WIDTH = 1.0 / 255.0


def _screen(t: Expression, a: Expression, b: Expression) -> Expression:
    return 1.0 - ((1.0 - t) + t * (1.0 - b)) * (1.0 - a)


def _soft_light(t: Expression, a: Expression, b: Expression) -> Expression:
    screen = 1.0 - (1.0 - b) * (1.0 - a)
    return (1.0 - t) * a + t * ((1.0 - a) * b * a + a * screen)


BLENDS: dict[str, Blend] = {
    "MIX": lambda t, a, b: mix(a, b, t),
    "ADD": lambda t, a, b: a + t * b,
    "MULTIPLY": lambda t, a, b: mix(a, a * b, t),
    "SUBTRACT": lambda t, a, b: a - t * b,
    "SCREEN": _screen,
    "DIFFERENCE": lambda t, a, b: mix(a, absolute(a - b), t),
    "EXCLUSION": lambda t, a, b: maximum(mix(a, a + b - 2.0 * a * b, t), 0.0),
    "DARKEN": lambda t, a, b: mix(a, minimum(a, b), t),
    "LIGHTEN": lambda t, a, b: mix(a, maximum(a, b), t),
    "SOFT_LIGHT": _soft_light,
    "LINEAR_LIGHT": lambda t, a, b: a + t * (2.0 * b - 1.0),
}


def _mix(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    kind = {"FLOAT": "Float", "VECTOR": "Vector", "RGBA": "Color"}.get(node.data_type)
    if kind is None:
        return None
    uneven = kind == "Vector" and node.factor_mode == "NON_UNIFORM"
    factor = e.input(node, groups, "Factor_Vector" if uneven else "Factor_Float")
    a, b = e.input(node, groups, f"A_{kind}"), e.input(node, groups, f"B_{kind}")
    if node.clamp_factor:
        factor = clamp(factor)
    if kind != "Color":
        return mix(a, b, factor)
    blend = BLENDS.get(node.blend_type)
    if blend is None:
        return None
    result = blend(factor, a, b)
    return clamp(result) if node.clamp_result else result


def _mix_rgb(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    blend = BLENDS.get(node.blend_type)
    if blend is None:
        return None
    factor, a, b = (e.value(node.inputs[at], groups) for at in range(3))
    result = blend(clamp(factor), a, b)
    return clamp(result) if node.use_clamp else result


def _color_ramp(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    ramp = node.color_ramp
    if ramp.interpolation != "LINEAR" or ramp.color_mode != "RGB":
        return None
    factor = e.value(node.inputs[0], groups)
    stops = [(stop.position, stop.color[3:] * 3 if output.name == "Alpha" else stop.color[:3]) for stop in ramp.elements]
    value = e.graph.constant(list(stops[0][1]))
    for (start, before), (end, after) in zip(stops, stops[1:]):
        if end - start < LEAST_WIDTH:
            return None
        step = [second - first for first, second in zip(before, after)]
        value = value + clamp((factor - start) * (1.0 / (end - start))) * step
    return value


def _bright_contrast(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    color, bright, contrast = e.input(node, groups, "Color"), e.input(node, groups, "Bright", "Brightness"), e.input(node, groups, "Contrast")
    return maximum((1.0 + contrast) * color + (bright - contrast * 0.5), 0.0)


def _gamma(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    color, gamma = e.input(node, groups, "Color"), e.input(node, groups, "Gamma")
    if gamma.is_constant and gamma.constant[0] == 0.0:
        return e.graph.constant(1.0)
    # Negative parts of a color stay.
    return power(maximum(color, 0.0), gamma) + minimum(color, 0.0)


def _invert(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    factor, color = e.input(node, groups, "Fac", "Factor"), e.input(node, groups, "Color")
    return mix(color, 1.0 - color, factor)


def _separate_color(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    if getattr(node, "mode", "RGB") != "RGB":
        return None
    return e.value(node.inputs[0], groups).component(list(node.outputs).index(output))


def _combine_color(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    if getattr(node, "mode", "RGB") != "RGB":
        return None
    return combine(*(e.value(node.inputs[at], groups) for at in range(3)))


def _gray(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    return dot(e.value(node.inputs[0], groups), LUMINANCE)


def _blackbody(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    from . import units

    temperature = e.value(node.inputs[0], groups)
    return e.graph.constant(units.blackbody(temperature.constant[0])) if temperature.is_constant else None


HANDLERS: dict[str, Handler] = {
    "MIX": _mix,
    "MIX_RGB": _mix_rgb,
    "VALTORGB": _color_ramp,
    "BRIGHTCONTRAST": _bright_contrast,
    "GAMMA": _gamma,
    "INVERT": _invert,
    "SEPARATE_COLOR": _separate_color,
    "COMBINE_COLOR": _combine_color,
    "RGBTOBW": _gray,
    "BLACKBODY": _blackbody,
}
