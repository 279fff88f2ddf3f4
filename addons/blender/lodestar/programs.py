"""Programs: textures that are computed, as the renderer's own texture plugins.

A `Graph` holds operations, each once. Those that a scene uses become top-level `<texture>` elements that refer to each other.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Optional, Union

from . import xml
from .folding import FOLDED, Vector, finite

# Rows of an affine map: three of four numbers.
Rows = tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class Expression:
    """Value of a graph: a node's, or a constant. A number stands in all three components."""

    graph: "Graph"
    node: Optional[int] = None
    constant: Vector = (0.0, 0.0, 0.0)

    @property
    def is_constant(self) -> bool:
        """Whether the value is the same everywhere."""
        return self.node is None

    def __add__(self, other: Operand) -> "Expression":
        return self.graph.of("add", a=self, b=other)

    def __radd__(self, other: Operand) -> "Expression":
        return self.graph.of("add", a=other, b=self)

    def __sub__(self, other: Operand) -> "Expression":
        return self.graph.of("subtract", a=self, b=other)

    def __rsub__(self, other: Operand) -> "Expression":
        return self.graph.of("subtract", a=other, b=self)

    def __mul__(self, other: Operand) -> "Expression":
        return self.graph.of("multiply", a=self, b=other)

    __rmul__ = __mul__

    def __truediv__(self, other: Operand) -> "Expression":
        return self.graph.of("divide", a=self, b=other)

    def __rtruediv__(self, other: Operand) -> "Expression":
        return self.graph.of("divide", a=other, b=self)

    def __neg__(self) -> "Expression":
        return self * -1.0

    def component(self, index: int) -> "Expression":
        """One of the three components as a number."""
        return self.graph.of("component", value=self, index=index)

    @property
    def x(self) -> "Expression":
        """First component."""
        return self.component(0)

    @property
    def y(self) -> "Expression":
        """Second component."""
        return self.component(1)

    @property
    def z(self) -> "Expression":
        """Third component."""
        return self.component(2)


Operand = Union[Expression, float, int, Sequence[float]]


class Graph:
    """Operations of one scene."""

    def __init__(self) -> None:
        self._known: dict[Any, int] = {}
        self._nodes: list[tuple[str, dict[str, Any]]] = []

    def constant(self, value: Union[float, Sequence[float]]) -> Expression:
        """Constant expression. Its numbers are finite in single precision."""
        three = tuple(finite(float(v)) for v in value[:3]) if isinstance(value, Sequence) else (finite(float(value)),) * 3
        return Expression(self, None, three)  # type: ignore[arg-type]

    def operand(self, value: Operand) -> Expression:
        """Expression of an operand."""
        return value if isinstance(value, Expression) else self.constant(value)

    def of(self, plugin: str, **inputs: Any) -> Expression:
        """Operation. Whole numbers, strings and matrices are its parameters; all else is an input."""
        inputs = {name: value if isinstance(value, (Expression, int, str, _Matrix)) and not isinstance(value, bool) else
                  self.constant(value) for name, value in inputs.items()}
        if plugin in FOLDED and all(isinstance(v, Expression) and v.is_constant for v in inputs.values()):
            return self.constant(FOLDED[plugin](*(v.constant for v in inputs.values())))
        if plugin == "component" and inputs["value"].is_constant:
            return self.constant(inputs["value"].constant[inputs["index"]])
        return self._simple(plugin, inputs) or self._node(plugin, inputs)

    def _node(self, plugin: str, inputs: dict[str, Any]) -> Expression:
        key = (plugin, tuple((name, _key(value)) for name, value in sorted(inputs.items())))
        if key not in self._known:
            self._known[key] = len(self._nodes)
            self._nodes.append((plugin, inputs))
        return Expression(self, self._known[key])

    def _simple(self, plugin: str, inputs: dict[str, Any]) -> Optional[Expression]:
        """An input that has the operation's value."""
        is_all = lambda value, number: isinstance(value, Expression) and value.is_constant and value.constant == (number,) * 3  # noqa: E731
        a, b = inputs.get("a"), inputs.get("b")
        if plugin == "multiply":
            if is_all(a, 0.0) or is_all(b, 0.0):
                return self.constant(0.0)
            return b if is_all(a, 1.0) else a if is_all(b, 1.0) else None
        if plugin == "add":
            return b if is_all(a, 0.0) else a if is_all(b, 0.0) else None
        if plugin == "subtract" and is_all(b, 0.0):
            return a
        if plugin == "mix":
            return a if is_all(inputs["weight"], 0.0) else b if is_all(inputs["weight"], 1.0) else None
        return None

    def source(self, name: str) -> Expression:
        """Quantity of the point: `uv`, `position`, `normal`, `shading_normal` or `incoming`."""
        return self._node(name, {})

    def transformed(self, value: Expression, rows: Rows) -> Expression:
        """Affine map of a point."""
        if value.is_constant:
            return self.constant([sum(m * v for m, v in zip(row, (*value.constant, 1.0))) for row in rows])
        return self.of("transformed", coordinates=value, to_texture=_Matrix(tuple(tuple(row[:4]) for row in rows[:3])))

    def bitmap(self, key: tuple[Any, ...], element: xml.Element, coordinates: Expression) -> Expression:
        """Image at coordinates. Equal keys stand for equal elements."""
        return self._node("bitmap", {"coordinates": coordinates, "": _Image(key, element)})

    def plugin(self, node: int) -> str:
        """Operation of a node."""
        return self._nodes[node][0]

    def operands(self, node: int) -> dict[str, Expression]:
        """Inputs of a node by their names."""
        return {name: value for name, value in self._nodes[node][1].items() if isinstance(value, Expression)}

    def inputs(self, node: int) -> list[int]:
        """Nodes that a node takes its inputs from."""
        return [value.node for value in self.operands(node).values() if value.node is not None]

    def reads_uv(self, name: str) -> bool:
        """Whether the expression with this name depends on texture coordinates."""
        open_, seen = [int(name.removeprefix("texture "))], set()
        while open_:
            node = open_.pop()
            if node not in seen:
                seen.add(node)
                open_.extend(self.inputs(node))
        return any(self.plugin(node) == "uv" for node in seen)

    # ------------------------------------------------------------------------------------------------------ text

    def name(self, expression: Expression) -> str:
        """The `id` of an expression's element."""
        return f"texture {expression.node}"

    def reference(self, expression: Expression) -> xml.Element:
        """`<ref>` to an expression, or the `<texture>` of a constant."""
        if expression.is_constant:
            return _add(xml.plugin("texture", "rawconstant"), "value", expression, self)
        return xml.ElementTree.Element("ref", {"id": self.name(expression)})

    def elements(self, used: set[str]) -> list[xml.Element]:
        """Elements of the expressions whose names are used, and of those that these need."""
        needed: set[int] = {at for at in range(len(self._nodes)) if f"texture {at}" in used}
        for at in range(len(self._nodes) - 1, -1, -1):
            if at in needed:
                needed |= set(self.inputs(at))
        return [self._element(at) for at in sorted(needed)]

    def _element(self, at: int) -> xml.Element:
        plugin, inputs = self._nodes[at]
        image = inputs.get("")
        element = image.element if isinstance(image, _Image) else xml.plugin("texture", plugin)
        element.set("id", f"texture {at}")
        for name, value in inputs.items():
            if name:
                _add(element, name, value, self)
        return element


@dataclass(frozen=True)
class _Matrix:
    rows: Rows


@dataclass(frozen=True)
class _Image:
    key: tuple[Any, ...]
    element: Any


def _key(value: Any) -> Any:
    if isinstance(value, Expression):
        return ("node", value.node) if value.node is not None else ("constant", value.constant)
    return value.key if isinstance(value, _Image) else value


def _add(element: xml.Element, name: str, value: Any, graph: Graph) -> xml.Element:
    if isinstance(value, _Matrix):
        return xml.add_matrix(element, [*value.rows, (0.0, 0.0, 0.0, 1.0)], name)
    if not isinstance(value, Expression):
        return xml.add(element, name, value)
    if not value.is_constant:
        reference = graph.reference(value)
        reference.set("name", name)
        element.append(reference)
        return element
    if len(set(value.constant)) == 1:
        return xml.add(element, name, value.constant[0])
    text = ", ".join(xml.number(component) for component in value.constant)
    xml.ElementTree.SubElement(element, "vector", {"name": name, "value": text})
    return element


# ------------------------------------------------------------------------------------------- functions of expressions


def combine(x: Operand, y: Operand, z: Operand) -> Expression:
    """Vector of three numbers, of which one at least is an expression."""
    graph = next(v.graph for v in (x, y, z) if isinstance(v, Expression))
    return graph.of("combine", x=x, y=y, z=z)


def minimum(a: Expression, b: Operand) -> Expression:
    """Smaller of two."""
    return a.graph.of("minimum", a=a, b=b)


def maximum(a: Expression, b: Operand) -> Expression:
    """Larger of two."""
    return a.graph.of("maximum", a=a, b=b)


def clamp(value: Expression, low: Operand = 0.0, high: Operand = 1.0) -> Expression:
    """Value between two bounds."""
    return minimum(maximum(value, low), high)


def less(a: Expression, b: Operand) -> Expression:
    """1 where `a` is less than `b`, else 0."""
    return a.graph.of("less", a=a, b=b)


def positive(value: Expression) -> Expression:
    """1 where a value is above 0, else 0."""
    return less(value.graph.constant(0.0), value)


def is_zero(value: Expression) -> Expression:
    """1 where a value is 0, else 0."""
    return 1.0 - positive(absolute(value))


def select(condition: Expression, yes: Operand, no: Operand) -> Expression:
    """`yes` where the condition is 1, and `no` where it is 0, by component."""
    return condition * yes + (1.0 - condition) * no


def mix(a: Operand, b: Operand, weight: Expression) -> Expression:
    """(1 - weight) a + weight b, by component."""
    graph = weight.graph
    return graph.operand(a) * (1.0 - weight) + graph.operand(b) * weight


def absolute(value: Expression) -> Expression:
    """Absolute value."""
    return value.graph.of("absolute", value=value)


def floor(value: Expression) -> Expression:
    """Largest whole number that is not above the value."""
    return value.graph.of("floor", value=value)


def fraction(value: Expression) -> Expression:
    """What a value exceeds its floor by."""
    return value - floor(value)


def truncated(value: Expression) -> Expression:
    """Whole part, towards 0."""
    return floor(maximum(value, 0.0)) - floor(maximum(-value, 0.0))


def sign(value: Expression) -> Expression:
    """-1, 0 or 1."""
    return positive(value) - less(value, 0.0)


def sine(value: Expression) -> Expression:
    """Sine of an angle in radians."""
    return value.graph.of("sine", value=value)


def cosine(value: Expression) -> Expression:
    """Cosine of an angle in radians."""
    return sine(value + 0.5 * math.pi)


def square_root(value: Expression) -> Expression:
    """Square root; 0 where the value is negative."""
    return value.graph.of("square_root", value=value)


def power(a: Operand, b: Operand) -> Expression:
    """Power, of which one at least is an expression."""
    graph = next(v.graph for v in (a, b) if isinstance(v, Expression))
    return graph.of("power", a=a, b=b)


def exponential(value: Expression) -> Expression:
    """Power of Euler's number."""
    return value.graph.of("exponential", value=value)


def logarithm(value: Expression) -> Expression:
    """Natural logarithm; 0 where the value is not positive."""
    return value.graph.of("logarithm", value=value)


def arctangent(y: Operand, x: Operand) -> Expression:
    """Angle of the point (x, y) in radians."""
    graph = next(v.graph for v in (y, x) if isinstance(v, Expression))
    return graph.of("arctangent", a=y, b=x)


def dot(a: Expression, b: Operand) -> Expression:
    """Dot product."""
    return a.graph.of("dot", a=a, b=b)


def length(value: Expression) -> Expression:
    """Length of a vector."""
    return square_root(dot(value, value))


def normalized(value: Expression) -> Expression:
    """Vector of length 1; 0 where the vector is 0."""
    return value / length(value)


def permuted(value: Expression, order: Sequence[int]) -> Expression:
    """Components in another order."""
    return value.graph.transformed(value, tuple(tuple(1.0 if at == from_ else 0.0 for at in range(4)) for from_ in order))


def cross(a: Expression, b: Expression) -> Expression:
    """Cross product."""
    return permuted(a, (1, 2, 0)) * permuted(b, (2, 0, 1)) - permuted(a, (2, 0, 1)) * permuted(b, (1, 2, 0))


def smooth_step(value: Expression) -> Expression:
    """Smooth step from 0 to 1 of a value in [0, 1]."""
    return value * value * (3.0 - 2.0 * value)
