"""Nodes that compute with colors."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Optional

from .evaluator import LUMINANCE, Evaluator, Groups, Handler
from .programs import (
    Expression, absolute, clamp, combine, dot, fraction, is_zero, less, maximum, minimum, mix, positive, power,
    select,
)

Blend = Callable[[Expression, Expression, Expression], Expression]
# Entries of the tables of color ramps and curves, as in Cycles.
ENTRIES = 256


def _hsv(color: Expression) -> Expression:
    return color.graph.of("hsv_from_rgb", value=color)


def _rgb(hsv: Expression) -> Expression:
    return hsv.graph.of("rgb_from_hsv", value=hsv)


def _screen(t: Expression, a: Expression, b: Expression) -> Expression:
    return 1.0 - ((1.0 - t) + t * (1.0 - b)) * (1.0 - a)


def _overlay(t: Expression, a: Expression, b: Expression) -> Expression:
    dark = a * ((1.0 - t) + 2.0 * t * b)
    light = 1.0 - ((1.0 - t) + 2.0 * t * (1.0 - b)) * (1.0 - a)
    return select(less(a, 0.5), dark, light)


def _divide(t: Expression, a: Expression, b: Expression) -> Expression:
    return select(is_zero(b), a, (1.0 - t) * a + t * a / b)


def _dodge(t: Expression, a: Expression, b: Expression) -> Expression:
    rest = 1.0 - t * b
    dodged = select(positive(rest), minimum(a / rest, 1.0), 1.0)
    return select(is_zero(a), 0.0, dodged)


def _burn(t: Expression, a: Expression, b: Expression) -> Expression:
    rest = (1.0 - t) + t * b
    return clamp(1.0 - (1.0 - a) / rest) * positive(rest)


def _soft_light(t: Expression, a: Expression, b: Expression) -> Expression:
    screen = 1.0 - (1.0 - b) * (1.0 - a)
    return (1.0 - t) * a + t * ((1.0 - a) * b * a + a * screen)


def _hue(t: Expression, a: Expression, b: Expression) -> Expression:
    own, other = _hsv(a), _hsv(b)
    mixed = mix(a, _rgb(combine(other.x, own.y, own.z)), t)
    return select(is_zero(other.y), a, mixed)


def _saturation(t: Expression, a: Expression, b: Expression) -> Expression:
    own, other = _hsv(a), _hsv(b)
    mixed = _rgb(combine(own.x, mix(own.y, other.y, t), own.z))
    return select(is_zero(own.y), a, mixed)


def _color(t: Expression, a: Expression, b: Expression) -> Expression:
    own, other = _hsv(a), _hsv(b)
    mixed = mix(a, _rgb(combine(other.x, other.y, own.z)), t)
    return select(is_zero(other.y), a, mixed)


def _value(t: Expression, a: Expression, b: Expression) -> Expression:
    own, other = _hsv(a), _hsv(b)
    return _rgb(combine(own.x, own.y, mix(own.z, other.z, t)))


BLENDS: dict[str, Blend] = {
    "MIX": lambda t, a, b: mix(a, b, t),
    "ADD": lambda t, a, b: a + t * b,
    "MULTIPLY": lambda t, a, b: mix(a, a * b, t),
    "SUBTRACT": lambda t, a, b: a - t * b,
    "SCREEN": _screen,
    "OVERLAY": _overlay,
    "DIVIDE": _divide,
    "DIFFERENCE": lambda t, a, b: mix(a, absolute(a - b), t),
    "EXCLUSION": lambda t, a, b: maximum(mix(a, a + b - 2.0 * a * b, t), 0.0),
    "DARKEN": lambda t, a, b: mix(a, minimum(a, b), t),
    "LIGHTEN": lambda t, a, b: mix(a, maximum(a, b), t),
    "DODGE": _dodge,
    "BURN": _burn,
    "HUE": _hue,
    "SATURATION": _saturation,
    "COLOR": _color,
    "VALUE": _value,
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


def table(value: Expression, entries: list[tuple[float, float, float]], steps: bool = False, extrapolate: bool = False) -> Expression:
    """Entries of a table for values from 0 to 1."""
    text = " ".join(f"{number:.9g}" for entry in entries for number in entry)
    return value.graph.of("table", value=value, extrapolate=int(extrapolate), steps=int(steps), values=text)


def _color_ramp(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    factor = e.value(node.inputs[0], groups)
    ramp = node.color_ramp
    entries = [tuple(ramp.evaluate(at / (ENTRIES - 1))) for at in range(ENTRIES)]
    is_alpha = output.name == "Alpha"
    chosen = [(entry[3],) * 3 if is_alpha else entry[:3] for entry in entries]
    if factor.is_constant:
        return e.graph.constant(looked_up(chosen, factor.constant[0], ramp.interpolation == "CONSTANT"))
    return table(factor, chosen, ramp.interpolation == "CONSTANT")


def looked_up(entries: list[tuple[float, ...]], at: float, steps: bool) -> list[float]:
    """Entry of a table for a number from 0 to 1."""
    place = min(max(at, 0.0), 1.0) * (len(entries) - 1)
    low = int(place)
    high, t = min(low + 1, len(entries) - 1), 0.0 if steps else place - low
    return [(1.0 - t) * first + t * second for first, second in zip(entries[low], entries[high])]


def _curves(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    """RGB Curves, Vector Curves and Float Curve."""
    mapping = node.mapping
    mapping.initialize()
    curves = list(mapping.curves)
    low = min(curve.points[0].location[0] for curve in curves)
    high = max(curve.points[-1].location[0] for curve in curves)
    places = [low + at / (ENTRIES - 1) * (high - low) for at in range(ENTRIES)]
    if node.type == "CURVE_RGB":
        combined = [mapping.evaluate(curves[3], place) for place in places]
        entries = [tuple(mapping.evaluate(curve, value) for curve in curves[:3]) for value in combined]
    else:
        channels = curves[:3] if node.type == "CURVE_VEC" else curves[:1] * 3
        entries = [tuple(mapping.evaluate(curve, place) for curve in channels) for place in places]
    factor = e.input(node, groups, "Fac", "Factor", default=1.0)
    value = e.input(node, groups, "Color", "Vector", "Value")
    place = (value - low) * (1.0 / max(high - low, 1e-9))
    found = table(place, entries, extrapolate=mapping.extend == "EXTRAPOLATED")
    return mix(value, found.x if node.type == "CURVE_FLOAT" else found, factor)


def _hue_saturation(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    hue, saturation, value = (e.input(node, groups, name) for name in ("Hue", "Saturation", "Value"))
    factor, color = e.input(node, groups, "Fac", "Factor"), e.input(node, groups, "Color")
    hsv = _hsv(color)
    changed = _rgb(combine(fraction(hsv.x + hue + 0.5), clamp(hsv.y * saturation), hsv.z * value))
    return maximum(mix(color, changed, factor), 0.0)


def _bright_contrast(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    color, bright, contrast = e.input(node, groups, "Color"), e.input(node, groups, "Bright", "Brightness"), e.input(node, groups, "Contrast")
    return maximum((1.0 + contrast) * color + (bright - contrast * 0.5), 0.0)


def _gamma(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    color, gamma = e.input(node, groups, "Color"), e.input(node, groups, "Gamma")
    if gamma.is_constant and gamma.constant[0] == 0.0:
        return e.graph.constant(1.0)
    return select(positive(color), power(maximum(color, 0.0), gamma), color)


def _invert(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    factor, color = e.input(node, groups, "Fac", "Factor"), e.input(node, groups, "Color")
    return mix(color, 1.0 - color, factor)


def _separate_color(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    color = e.value(node.inputs[0], groups)
    mode = getattr(node, "mode", "RGB")
    if mode != "RGB":
        color = e.graph.of(f"{mode.lower()}_from_rgb", value=color)
    return color.component(list(node.outputs).index(output))


def _combine_color(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    parts = combine(*(e.value(node.inputs[at], groups) for at in range(3)))
    mode = getattr(node, "mode", "RGB")
    return parts if mode == "RGB" else e.graph.of(f"rgb_from_{mode.lower()}", value=parts)


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
    "CURVE_RGB": _curves,
    "CURVE_VEC": _curves,
    "CURVE_FLOAT": _curves,
    "HUE_SAT": _hue_saturation,
    "BRIGHTCONTRAST": _bright_contrast,
    "GAMMA": _gamma,
    "INVERT": _invert,
    "SEPARATE_COLOR": _separate_color,
    "COMBINE_COLOR": _combine_color,
    "RGBTOBW": _gray,
    "BLACKBODY": _blackbody,
}
