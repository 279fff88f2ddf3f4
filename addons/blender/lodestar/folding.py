"""Values of operations whose inputs are constants."""

from __future__ import annotations

import colorsys
import math
from collections.abc import Callable

Vector = tuple[float, float, float]
# Largest number in single precision.
LARGEST = 3.4028234663852886e38


def finite(value: float) -> float:
    """Number that single precision has: the largest stands for all that are larger, and 0 for what is no number."""
    return 0.0 if math.isnan(value) else min(max(value, -LARGEST), LARGEST)


def _each(function: Callable[..., float]) -> Callable[..., Vector]:
    def apply(*operands: Vector) -> Vector:
        return tuple(function(*values) for values in zip(*operands))  # type: ignore[return-value]

    return apply


def _power(a: float, b: float) -> float:
    if b == 0.0:
        return 1.0
    if a == 0.0 or (a < 0.0 and b != math.floor(b)):
        return 0.0
    try:
        return math.pow(a, b)
    except OverflowError:
        return -LARGEST if a < 0.0 and b % 2.0 == 1.0 else LARGEST


def _dot(a: Vector, b: Vector) -> Vector:
    return (sum(x * y for x, y in zip(a, b)),) * 3


def _hsv(color: Vector) -> Vector:
    most, least = max(color), min(color)
    # Colors with negative channels may have no brightness.
    return colorsys.rgb_to_hsv(*color) if most != 0.0 or least == 0.0 else (0.0, 0.0, 0.0)


def _rgb(hsv: Vector) -> Vector:
    """Color of a hue, as Cycles has it also for hues that are not between 0 and 1."""
    hue, saturation, value = hsv
    if saturation == 0.0:
        return (value, value, value)
    sector = 0.0 if hue == 1.0 else hue * 6.0
    part = sector - math.floor(sector)
    p, q, t = (value * (1.0 - saturation * share) for share in (1.0, part, 1.0 - part))
    colors = ((value, t, p), (q, value, p), (p, value, t), (p, q, value), (t, p, value))
    return colors[math.floor(sector)] if 0.0 <= sector < 5.0 else (value, p, q)


# What is not listed is left to the renderer. Operands are finite, and values may be larger than `LARGEST`.
FOLDED: dict[str, Callable[..., Vector]] = {
    "add": _each(lambda a, b: a + b),
    "subtract": _each(lambda a, b: a - b),
    "multiply": _each(lambda a, b: a * b),
    "divide": _each(lambda a, b: a / b if b != 0.0 else 0.0),
    "minimum": _each(min),
    "maximum": _each(max),
    "power": _each(_power),
    "absolute": _each(abs),
    "sine": _each(math.sin),
    "square_root": _each(lambda a: math.sqrt(max(a, 0.0))),
    "floor": _each(math.floor),
    "less": _each(lambda a, b: 1.0 if a < b else 0.0),
    "exponential": _each(lambda a: math.exp(min(a, 100.0))),
    "logarithm": _each(lambda a: math.log(a) if a > 0.0 else 0.0),
    "arctangent": _each(math.atan2),
    "mix": _each(lambda a, b, weight: (1.0 - weight) * a + weight * b),
    "dot": _dot,
    "hsv_from_rgb": _hsv,
    "rgb_from_hsv": _rgb,
    "combine": lambda x, y, z: (x[0], y[0], z[0]),
}
