"""Factors of rough metals and of rough glass."""

from __future__ import annotations

import numpy as np
import pytest
from lodestar import facets
from lodestar.programs import Graph


@pytest.mark.parametrize("is_beckmann", [False, True])
@pytest.mark.parametrize("roughness", [0.05, 0.4, 1.0])
def test_a_white_metal_sheds_no_more_light_than_it_gets(roughness: float, is_beckmann: bool) -> None:
    found = facets.shares(roughness**2, is_beckmann)
    assert (found.shed <= 1.0 + 1e-3).all() and 0.0 < found.mean <= 1.0 + 1e-3
    # All reflections together shed all light.
    shed = found.shed / found.factor * (found.factor + facets._lacking(found))
    assert np.abs(shed - 1.0).max() < 1e-6


def test_smooth_facets_have_no_program() -> None:
    """The color of a metal or of glass that is nearly smooth stays a constant."""
    graph = Graph()
    assert facets.metal(graph, (0.5, 0.5, 0.5), 0.05, False, True) is None
    assert facets.glass(graph, (1.0, 1.0, 1.0), 0.05, 1.5, False, True) is None
    assert facets.metal(graph, (0.5, 0.5, 0.5), 0.5, False, True) is not None
