"""Nodes that compute with numbers and vectors."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Optional

from .evaluator import Evaluator, Groups, Handler
from .programs import (
    Expression, absolute, arctangent, clamp, combine, cosine, cross, dot, exponential, floor, fraction, length, less, logarithm,
    maximum, minimum, normalized, positive, power, select, sign, sine, smooth_step, square_root, truncated,
)

Binary = Callable[..., Expression]


def _wrapped(value: Expression, high: Expression, low: Expression) -> Expression:
    span = high - low
    return select(positive(absolute(span)), value - span * floor((value - low) / span), low)


def _modulo(a: Expression, b: Expression) -> Expression:
    """What is left of a division that rounds towards 0; 0 where the divisor is 0."""
    return (a - b * truncated(a / b)) * absolute(sign(b))


def _floored_modulo(a: Expression, b: Expression) -> Expression:
    return (a - b * floor(a / b)) * absolute(sign(b))


def _smooth_minimum(a: Expression, b: Expression, distance: Expression) -> Expression:
    h = maximum(distance - absolute(a - b), 0.0) / distance
    return minimum(a, b) - h * h * h * distance * (1.0 / 6.0)


def _ping_pong(a: Expression, b: Expression) -> Expression:
    return absolute(fraction((a - b) / (b * 2.0)) * b * 2.0 - b)


def _hyperbolic(value: Expression, sign_of_second: float) -> Expression:
    return (exponential(value) + exponential(-value) * sign_of_second) * 0.5


def _hyperbolic_tangent(value: Expression) -> Expression:
    decay = exponential(-2.0 * clamp(value, -20.0, 20.0))
    return (1.0 - decay) / (1.0 + decay)


def _arcsine(value: Expression) -> Expression:
    x = clamp(value, -1.0, 1.0)
    return arctangent(x, square_root((1.0 - x) * (1.0 + x)))


def _arccosine(value: Expression) -> Expression:
    x = clamp(value, -1.0, 1.0)
    return arctangent(square_root((1.0 - x) * (1.0 + x)), x)


NUMBERS: dict[str, Binary] = {
    "ADD": lambda a, b, c: a + b,
    "SUBTRACT": lambda a, b, c: a - b,
    "MULTIPLY": lambda a, b, c: a * b,
    "DIVIDE": lambda a, b, c: a / b,
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "POWER": lambda a, b, c: power(a, b),
    "LOGARITHM": lambda a, b, c: logarithm(a) / logarithm(b),
    "SQRT": lambda a, b, c: square_root(a),
    "INVERSE_SQRT": lambda a, b, c: 1.0 / square_root(a),
    "ABSOLUTE": lambda a, b, c: absolute(a),
    "EXPONENT": lambda a, b, c: exponential(a),
    "MINIMUM": lambda a, b, c: minimum(a, b),
    "MAXIMUM": lambda a, b, c: maximum(a, b),
    "LESS_THAN": lambda a, b, c: less(a, b),
    "GREATER_THAN": lambda a, b, c: less(b, a),
    "SIGN": lambda a, b, c: sign(a),
    "COMPARE": lambda a, b, c: 1.0 - less(maximum(c, 1.1920929e-07), absolute(a - b)),
    "SMOOTH_MIN": _smooth_minimum,
    "SMOOTH_MAX": lambda a, b, c: -_smooth_minimum(-a, -b, c),
    "ROUND": lambda a, b, c: floor(a + 0.5),
    "FLOOR": lambda a, b, c: floor(a),
    "CEIL": lambda a, b, c: -floor(-a),
    "TRUNC": lambda a, b, c: truncated(a),
    "FRACT": lambda a, b, c: fraction(a),
    "MODULO": lambda a, b, c: _modulo(a, b),
    "FLOORED_MODULO": lambda a, b, c: _floored_modulo(a, b),
    "WRAP": _wrapped,
    "SNAP": lambda a, b, c: floor(a / b) * b,
    "PINGPONG": lambda a, b, c: _ping_pong(a, b),
    "SINE": lambda a, b, c: sine(a),
    "COSINE": lambda a, b, c: cosine(a),
    "TANGENT": lambda a, b, c: sine(a) / cosine(a),
    "ARCSINE": lambda a, b, c: _arcsine(a),
    "ARCCOSINE": lambda a, b, c: _arccosine(a),
    "ARCTANGENT": lambda a, b, c: arctangent(a, 1.0),
    "ARCTAN2": lambda a, b, c: arctangent(a, b),
    "SINH": lambda a, b, c: _hyperbolic(a, -1.0),
    "COSH": lambda a, b, c: _hyperbolic(a, 1.0),
    "TANH": lambda a, b, c: _hyperbolic_tangent(a),
    "RADIANS": lambda a, b, c: a * (math.pi / 180.0),
    "DEGREES": lambda a, b, c: a * (180.0 / math.pi),
}


def _math(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    operation = NUMBERS.get(node.operation)
    if operation is None:
        return None
    a, b, c = (e.value(node.inputs[at], groups) for at in range(3))
    value = operation(a, b, c)
    return clamp(value) if node.use_clamp else value


def _reflected(a: Expression, b: Expression) -> Expression:
    n = normalized(b)
    return a - n * (2.0 * dot(a, n))


def _refracted(a: Expression, b: Expression, ior: Expression) -> Expression:
    n = normalized(b)
    along = dot(n, a)
    k = 1.0 - ior * ior * (1.0 - along * along)
    return (ior * a - (ior * along + square_root(k)) * n) * (1.0 - less(k, 0.0))


def _faced(a: Expression, b: Expression, c: Expression) -> Expression:
    return a * (2.0 * less(dot(b, c), 0.0) - 1.0)


# Functions of three vectors and a number.
VECTORS: dict[str, Binary] = {
    "ADD": lambda a, b, c, s: a + b,
    "SUBTRACT": lambda a, b, c, s: a - b,
    "MULTIPLY": lambda a, b, c, s: a * b,
    "DIVIDE": lambda a, b, c, s: a / b,
    "MULTIPLY_ADD": lambda a, b, c, s: a * b + c,
    "CROSS_PRODUCT": lambda a, b, c, s: cross(a, b),
    "PROJECT": lambda a, b, c, s: b * (dot(a, b) / dot(b, b)),
    "REFLECT": lambda a, b, c, s: _reflected(a, b),
    "REFRACT": lambda a, b, c, s: _refracted(a, b, s),
    "FACEFORWARD": lambda a, b, c, s: _faced(a, b, c),
    "DOT_PRODUCT": lambda a, b, c, s: dot(a, b),
    "DISTANCE": lambda a, b, c, s: length(a - b),
    "LENGTH": lambda a, b, c, s: length(a),
    "SCALE": lambda a, b, c, s: a * s,
    "NORMALIZE": lambda a, b, c, s: normalized(a),
    "ABSOLUTE": lambda a, b, c, s: absolute(a),
    "POWER": lambda a, b, c, s: power(a, b),
    "SIGN": lambda a, b, c, s: sign(a),
    "MINIMUM": lambda a, b, c, s: minimum(a, b),
    "MAXIMUM": lambda a, b, c, s: maximum(a, b),
    "FLOOR": lambda a, b, c, s: floor(a),
    "CEIL": lambda a, b, c, s: -floor(-a),
    "FRACTION": lambda a, b, c, s: fraction(a),
    "MODULO": lambda a, b, c, s: _modulo(a, b),
    "WRAP": lambda a, b, c, s: _wrapped(a, b, c),
    "SNAP": lambda a, b, c, s: floor(a / b) * b,
    "SINE": lambda a, b, c, s: sine(a),
    "COSINE": lambda a, b, c, s: cosine(a),
    "TANGENT": lambda a, b, c, s: sine(a) / cosine(a),
}


def _vector_math(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    operation = VECTORS.get(node.operation)
    if operation is None:
        return None
    a, b, c = (e.value(node.inputs[at], groups) for at in range(3))
    return operation(a, b, c, e.input(node, groups, "Scale", default=1.0))


def _map_range(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    vector = getattr(node, "data_type", "FLOAT") == "FLOAT_VECTOR"
    suffix = "_FLOAT3" if vector else ""
    names = ("Value" if not vector else "Vector", "From Min", "From Max", "To Min", "To Max", "Steps")
    identifiers = (
        ("Vector", "From_Min_FLOAT3", "From_Max_FLOAT3", "To_Min_FLOAT3", "To_Max_FLOAT3", "Steps_FLOAT3")
        if suffix
        else ("Value", "From Min", "From Max", "To Min", "To Max", "Steps")
    )
    value, from_min, from_max, to_min, to_max, steps = (
        e.input(node, groups, identifier, name) for identifier, name in zip(identifiers, names)
    )
    factor = (value - from_min) / (from_max - from_min)
    kind = node.interpolation_type
    if kind == "STEPPED":
        factor = floor(factor * (steps + 1.0)) / steps * positive(steps)
    elif kind == "SMOOTHSTEP":
        factor = smooth_step(clamp(factor))
    elif kind == "SMOOTHERSTEP":
        t = clamp(factor)
        factor = t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
    elif kind != "LINEAR":
        return None
    result = to_min + factor * (to_max - to_min)
    if not vector:
        # A range of no width gives 0.
        result = result * absolute(sign(from_max - from_min))
    if node.clamp and kind in ("LINEAR", "STEPPED"):
        result = clamp(result, minimum(to_min, to_max), maximum(to_min, to_max))
    return result


def _clamp(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    value, low, high = (e.input(node, groups, name) for name in ("Value", "Min", "Max"))
    if node.clamp_type == "RANGE":
        low, high = minimum(low, high), maximum(low, high)
    return clamp(value, low, high)


def _combine_xyz(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    return combine(*(e.value(node.inputs[at], groups) for at in range(3)))


def _separate_xyz(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    return e.value(node.inputs[0], groups).component("XYZ".index(output.name))


def _normal(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    direction = normalized(e.graph.constant(list(node.outputs["Normal"].default_value)))
    if output.name == "Normal":
        return direction
    return dot(normalized(e.value(node.inputs[0], groups)), direction)


def _rotated(vector: Expression, axis: Expression, angle: Expression) -> Expression:
    """A vector turned about a unit axis (Rodrigues)."""
    c, s = cosine(angle), sine(angle)
    return vector * c + cross(axis, vector) * s + axis * (dot(axis, vector) * (1.0 - c))


def _vector_rotate(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    vector, center = e.input(node, groups, "Vector"), e.input(node, groups, "Center")
    turn = -1.0 if node.invert else 1.0
    axes = {"X_AXIS": (1.0, 0.0, 0.0), "Y_AXIS": (0.0, 1.0, 0.0), "Z_AXIS": (0.0, 0.0, 1.0)}
    if node.rotation_type == "EULER_XYZ":
        return rotated_by_euler(vector - center, e.input(node, groups, "Rotation"), node.invert) + center
    angle = e.input(node, groups, "Angle") * turn
    if node.rotation_type in axes:
        axis = e.graph.constant(axes[node.rotation_type])
    else:
        axis = normalized(e.input(node, groups, "Axis"))
        if axis.is_constant and axis.constant == (0.0, 0.0, 0.0):
            return vector
    return _rotated(vector - center, axis, angle) + center


def rotated_by_euler(vector: Expression, rotation: Expression, inverse: bool) -> Expression:
    """A vector turned about x, then y, then z, or back."""
    graph = vector.graph
    for at in (2, 1, 0) if inverse else (0, 1, 2):
        axis = graph.constant([1.0 if other == at else 0.0 for other in range(3)])
        angle = rotation.component(at)
        if not (angle.is_constant and angle.constant[0] == 0.0):
            vector = _rotated(vector, axis, -angle if inverse else angle)
    return vector


def _mapping(e: Evaluator, node: Any, output: Any, groups: Groups) -> Optional[Expression]:
    graph = e.graph
    vector = e.input(node, groups, "Vector")
    location, rotation, scale = (
        e.input(node, groups, name, default=default) for name, default in (("Location", 0.0), ("Rotation", 0.0), ("Scale", 1.0))
    )
    if all(value.is_constant for value in (location, rotation, scale)):
        matrix = e.reader.mapping_matrix(node, groups)
        if matrix is not None:
            return graph.transformed(vector, tuple(tuple(row) for row in matrix[:3]))
    if node.vector_type == "TEXTURE":
        return rotated_by_euler(vector - location, rotation, True) / scale
    if node.vector_type == "NORMAL":
        return normalized(rotated_by_euler(vector / scale, rotation, False))
    turned = rotated_by_euler(vector * scale, rotation, False)
    return turned + location if node.vector_type == "POINT" else turned


HANDLERS: dict[str, Handler] = {
    "MATH": _math,
    "VECT_MATH": _vector_math,
    "MAP_RANGE": _map_range,
    "CLAMP": _clamp,
    "COMBXYZ": _combine_xyz,
    "SEPXYZ": _separate_xyz,
    "NORMAL": _normal,
    "VECTOR_ROTATE": _vector_rotate,
    "MAPPING": _mapping,
}

