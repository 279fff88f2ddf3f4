"""Programs: constants that are folded, nodes in cases of their own, and limits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from lodestar import folding, limits, math_nodes, xml
from lodestar.programs import Expression, Graph, combine, exponential, minimum, power


def at(value: Expression, position: Any) -> np.ndarray:
    """Value of an expression of the position, where the position is known."""
    if value.is_constant:
        return np.array(value.constant)
    assert value.node is not None
    plugin = value.graph.plugin(value.node)
    if plugin == "position":
        return np.array(position, float)
    inputs = [tuple(at(each, position)) for each in value.graph.operands(value.node).values()]
    return np.array(folding.FOLDED[plugin](*inputs))


@pytest.mark.parametrize("operation", [math_nodes.NUMBERS["WRAP"], lambda a, b, c: math_nodes.VECTORS["WRAP"](a, b, c, 1.0)])
def test_wrap_in_no_range_is_its_minimum(operation: Any) -> None:
    """As in Cycles, by component, for bounds that are constants and for those that are computed."""
    graph = Graph()
    position = graph.source("position")
    low, high, value = (2.0, -1.0, 0.5), (2.0, 2.0, 0.5), (7.3, 7.3, -4.0)
    expected = pytest.approx([2.0, 1.3, 0.5])
    assert at(operation(graph.constant(value), graph.constant(high), graph.constant(low)), value) == expected
    assert at(operation(position, graph.constant(high), graph.constant(low)), value) == expected
    shift = minimum(position, -100.0) + 100.0
    assert not shift.is_constant
    assert at(operation(graph.constant(value), shift + high, shift + low), (0.0, 0.0, 0.0)) == expected


def text(value: Expression) -> list[float]:
    """Numbers that a constant has in a scene file."""
    element = value.graph.reference(value)
    words = (child.get("value") for child in element)
    return [float(word) for words in words for word in words.replace(",", " ").split()]


@pytest.mark.parametrize("color", [(0.8, 0.4, 0.2), (0.3, 0.3, 0.3), (3.0, 0.5, 1.0), (0.0, 0.0, 0.0), (-0.5, 0.0, -0.1)])
def test_hues_of_constants_are_folded(color: tuple[float, float, float]) -> None:
    """A color of constants is one, and comes back from its hue where it has no negative channel."""
    graph = Graph()
    hsv = graph.of("hsv_from_rgb", value=graph.constant(color))
    back = graph.of("rgb_from_hsv", value=hsv)
    assert hsv.is_constant and hsv.constant[2] == max(color)
    assert min(color) < 0.0 or back.constant == pytest.approx(color)
    assert not graph.of("hsv_from_rgb", value=graph.source("position")).is_constant


def test_folded_constants_are_in_single_precision() -> None:
    """What is too large becomes the largest number, and the operations behind it take that."""
    graph = Graph()
    large = graph.constant(1e30)
    largest = float(np.finfo(np.float32).max)
    values = [
        exponential(graph.constant(100.0)),
        exponential(graph.constant(1e6)),
        large * 1e30,
        large * -1e30,
        power(graph.constant(10.0), 400.0),
        power(graph.constant(-10.0), 401.0),
        combine(large * large, 2.0, -1.0 * large * large),
        graph.transformed(large, ((1e30, 0.0, 0.0, 0.0),) * 3),
        graph.constant(float("inf")),
    ]
    signs = [1, 1, 1, -1, 1, -1, None, 1, 1]
    for value, sign in zip(values, signs):
        numbers = np.array(text(value))
        assert np.isfinite(numbers.astype(np.float32)).all(), numbers
        assert sign is None or (numbers.astype(np.float32) == sign * np.float32(largest)).all(), numbers
    assert text(values[6])[1] == 2.0
    assert minimum(exponential(graph.constant(1e6)), 3.0).constant == (3.0,) * 3
    assert xml.number(folding.LARGEST) == "3.40282347e+38"
    assert graph.constant(float("nan")).constant == (0.0,) * 3


def sum_of_noises(count: int, computed: bool, bricks: bool = False) -> Expression:
    """Sum of noises in four dimensions, or of walls, whose numbers are computed or constants."""
    graph = Graph()
    position = graph.source("position")
    y = position.component(1)
    total = graph.constant(0.0)
    for number in range(count):
        w = position.component(0) + float(number) if computed else float(number)
        if bricks:
            total = total + graph.of("bricks", coordinates=position, mortar=w, height=y if computed else 0.5)
        else:
            total = total + graph.of("noise_4d", coordinates=position, w=w, detail=y if computed else 2.0)
    return total


def test_vectors_of_numbers_count() -> None:
    """A noise, its sum, its shift and its vector are four operations where its numbers are computed; two where they are not."""
    # There are two components, and one sum and one shift less than noises: 252 operations for 63 noises. The last 4 of 256 are kept free.
    assert limits.excess(sum_of_noises(63, True)) is None
    assert limits.excess(sum_of_noises(64, True)) == "more than 256 operations"
    assert limits.excess(sum_of_noises(126, False)) is None
    assert limits.excess(sum_of_noises(127, False)) == "more than 256 operations"
    # A wall has two vectors of numbers, and all walls share the second one.
    assert limits.excess(sum_of_noises(62, True, True)) is None
    assert limits.excess(sum_of_noises(63, True, True)) == "more than 256 operations"


def test_vectors_of_numbers_take_values() -> None:
    """A vector for each noise stands between its numbers and the noise."""
    graph = Graph()
    position = graph.source("position")

    def held(count: int) -> Expression:
        """Vectors that two sums of noises need in opposite orders."""
        numbers = [graph.of("wrinkled", coordinates=position, octaves=at + 1) for at in range(count)]
        of = lambda at, shift: graph.of("noise_4d", coordinates=position + shift, w=numbers[at], detail=numbers[at])  # noqa: E731
        rising, falling = of(0, 1.0), of(count - 1, 2.0)
        for at in range(1, count):
            rising, falling = rising + of(at, 1.0), falling * of(count - 1 - at, 2.0)
        return rising + falling

    found = held(5)
    inputs = limits._all_inputs(found)
    order = limits._order(found, inputs)
    assert len(order) == len(inputs) == 5 + 5 + 10 + 2 + 8 + 1
    assert all(order.index(other) < order.index(node) for node in inputs for other in inputs[node])
    assert limits.excess(found) is None
    assert limits.excess(held(20)) == "more than 16 values at the same time"
