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
    """Factors of lobes, and shares of light, lie between 0 and 1, and what a dielectric reflects is at most what it keeps."""
    graph = Graph()
    weight, factor, most = layers.dielectric(graph, alpha, 2.0, (0.1, 0.5, 1.0), True)
    for each in (layers.coat_factor(graph, alpha, 1.5), weight, factor):
        assert (entries(each) >= 0.0).all() and (entries(each) <= 1.0).all()
    to_facet, _, ours = layers._facets(alpha)
    lobe = most * (layers.fresnel(to_facet, 2.0) * ours).mean(axis=1)[:, None]
    assert (entries(factor) * lobe + entries(weight) <= 1.0 + 1e-6).all()


@pytest.mark.parametrize("is_whole", [False, True])
@pytest.mark.parametrize("ior", [1.3, 1.5, 2.0])
def test_a_roughness_that_varies(ior: float, is_whole: bool) -> None:
    """Three products of tables give the shares and the factors of the roughnesses between their entries, too."""
    at = np.arange(layers.ENTRIES) / (layers.ENTRIES - 1.0)
    for values, index in zip(layers._of_roughness(ior, is_whole), range(2)):
        graph = Graph()
        found = layers._of_both(graph.source("uv"), graph.source("position"), values)
        of_angle, of_roughness = (entries(graph.operands(found.node)[name]) for name in "ab")  # type: ignore[arg-type]
        for roughness in (0.2, 0.43, 0.5, 0.8, 1.0):
            weights = [np.interp(roughness, np.linspace(0.0, 1.0, layers.ROUGHNESSES), each) for each in of_roughness.T]
            exact = layers._dielectric(roughness**2, ior, (1.0, 1.0, 1.0), is_whole)[index].reshape(layers.ENTRIES, -1)[:, 0]
            assert np.abs(of_angle @ weights - exact)[at > 0.05].max() < 0.02


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
