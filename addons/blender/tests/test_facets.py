"""Factors of rough metals and of rough glass."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from lodestar import facets
from lodestar.programs import Graph


@pytest.mark.parametrize("is_beckmann", [False, True])
@pytest.mark.parametrize("roughness", [0.05, 0.4, 1.0])
def test_a_white_metal_sheds_no_more_light_than_it_gets(roughness: float, is_beckmann: bool) -> None:
    found = facets.shares(roughness**2, is_beckmann)
    assert (found.shed <= 1.0 + 1e-3).all() and 0.0 < found.mean <= 1.0 + 1e-3


def integral(alpha: float, mu: float, is_beckmann: bool, is_correlated: bool) -> float:
    """Share of light that leaves a white metal after one reflection, over facets of the distribution itself."""
    u, phi = np.meshgrid((np.arange(600) + 0.5) / 600, (np.arange(600) + 0.5) / 600 * 2.0 * np.pi)
    tangent = alpha * np.sqrt(-np.log(1.0 - u) if is_beckmann else u / (1.0 - u))
    z = 1.0 / np.hypot(1.0, tangent)
    to_view = mu * z + np.sqrt(1.0 - mu * mu) * tangent * z * np.cos(phi)
    left = 2.0 * to_view * z - mu

    def hidden(cosine: Any) -> Any:
        slope = alpha * np.sqrt(1.0 - cosine * cosine) / np.maximum(cosine, 1e-6)
        if not is_beckmann:
            return 0.5 * (np.sqrt(1.0 + slope * slope) - 1.0)
        a = 1.0 / np.maximum(slope, 1e-6)
        return 0.5 * (np.vectorize(math.erf)(a) - 1.0) + np.exp(-a * a) / (2.0 * a * math.sqrt(math.pi))

    seen, leaves = hidden(np.array(mu)), hidden(left.clip(0.0, 1.0))
    passing = 1.0 / (1.0 + seen + leaves) if is_correlated else 1.0 / ((1.0 + seen) * (1.0 + leaves))
    return float(np.where((to_view > 0.0) & (left > 0.0), passing * to_view / (mu * z), 0.0).mean())


@pytest.mark.parametrize("is_beckmann", [False, True])
@pytest.mark.parametrize("roughness", [0.3, 0.6, 1.0])
@pytest.mark.parametrize("entry", [80, 160, 250])
def test_shares_are_those_of_integrals(roughness: float, entry: int, is_beckmann: bool) -> None:
    """By facets of the distribution itself, in place of those that are seen. Masking and shadowing are correlated in Cycles alone."""
    found, mu = facets.shares(roughness**2, is_beckmann), entry / (facets.ENTRIES - 1.0)
    theirs, ours = (integral(roughness**2, mu, is_beckmann, is_correlated) for is_correlated in (True, False))
    assert found.shed[entry] == pytest.approx(theirs, abs=0.01)
    assert found.shed[entry] / found.factor[entry] == pytest.approx(ours, abs=0.01)
    if (roughness, entry) == (1.0, 80):
        assert abs(theirs - ours) > 0.02  # The twin: the other form is not so near.


def test_extreme_glass_and_metal_have_colors() -> None:
    """An index of 0, and colors above 1, which Blender's sockets allow."""
    for ior in (0.0, -1.0, 1e6):
        assert facets.glass(Graph(), (1.0, 5.0, 0.0), 0.5, ior, False, True) is not None
    graph = Graph()
    color, _ = facets.metal(graph, (50.0, 0.5, 0.0), 1.0, False, True) or (None, None)
    assert color is not None


def test_smooth_facets_have_no_program() -> None:
    """The color of a metal or of glass that is nearly smooth stays a constant."""
    graph = Graph()
    assert facets.metal(graph, (0.5, 0.5, 0.5), 0.05, False, True) is None
    assert facets.glass(graph, (1.0, 1.0, 1.0), 0.05, 1.5, False, True) is None
    assert facets.metal(graph, (0.5, 0.5, 0.5), 0.5, False, True) is not None
