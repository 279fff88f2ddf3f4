"""Tables of the layers of a Principled surface."""

from __future__ import annotations

import numpy as np
import pytest
from lodestar import layers
from lodestar.programs import Expression, Graph


def entries(expression: Expression) -> np.ndarray:
    """Numbers of a table."""
    graph, node = expression.graph, expression.node
    assert node is not None and graph.plugin(node) == "table"
    return np.array(graph._nodes[node][1]["values"].split(), float).reshape(-1, 3)


def test_a_coat_keeps_what_a_smooth_one_reflects() -> None:
    found = entries(layers.coat_albedo(Graph(), 1.5))[:, 0]
    assert found[-1] == pytest.approx(0.04) and found[0] > 0.98
    assert (np.diff(found) < 0.0).all()


@pytest.mark.parametrize("alpha", [0.0, 0.01, 0.25, 1.0])
def test_layers_gain_no_energy(alpha: float) -> None:
    """Factors of lobes, and shares of light, lie between 0 and 1."""
    graph = Graph()
    kept, factor = layers.specular(graph, alpha, 2.0, (0.1, 0.5, 1.0))
    for each in (layers.coat_factor(graph, alpha, 1.5), kept, factor):
        assert (entries(each) >= 0.0).all() and (entries(each) <= 1.0).all()


def test_a_coat_s_tint_is_that_of_perpendicular_light() -> None:
    found = entries(layers.coat_tint(Graph(), (0.9, 0.5, 0.0), 1.5))
    assert found[-1] == pytest.approx((0.9, 0.5, 0.0))
    # The longest way has the sine of 1 / 1.5.
    assert found[0] == pytest.approx([tint ** (1.0 / np.sqrt(1.0 - 1.0 / 2.25)) for tint in (0.9, 0.5, 0.0)], rel=1e-3)


def test_a_smooth_metal_has_its_tint_at_82_degrees() -> None:
    """The color of a smooth metal is Schlick's at 82 degrees times the tint, and its own at perpendicular incidence."""
    graph, tint = Graph(), (0.2, 0.5, 1.0)
    black, white = (entries_of_sum(layers.metal_color(graph.source("uv"), 0.0, tint), base) for base in (0.0, 1.0))
    at = np.arange(layers.ENTRIES) / (layers.ENTRIES - 1.0)
    for channel in range(3):
        of_82 = [np.interp(1.0 / 7.0, at, colors[:, channel]) for colors in (black, white)]
        assert of_82 == pytest.approx([layers.AT_82 * tint[channel], tint[channel]], rel=1e-3)
        assert (black[-1, channel], white[-1, channel]) == pytest.approx((0.0, 1.0), abs=1e-9)


def entries_of_sum(color: Expression, base: float) -> np.ndarray:
    """Numbers of base * first table + second table."""
    product, edge = (color.graph.operands(color.node)[name] for name in "ab")  # type: ignore[arg-type]
    of_color = color.graph.operands(product.node)["b"]  # type: ignore[arg-type]
    return base * entries(of_color) + entries(edge)
