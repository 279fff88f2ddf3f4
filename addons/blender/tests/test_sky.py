"""Models of the sky."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from lodestar.sky_models import Air, MultipleScattering, SingleScattering


@pytest.mark.parametrize("model", [MultipleScattering, SingleScattering], ids=lambda model: model.__name__)
@pytest.mark.parametrize("air", [Air(0, 1, 0, 1), Air(0, 0, 0, 1), Air(0, 0, 0, 0), Air(59_000, 10, 10, 10)], ids=str)
def test_colors_are_finite_for_a_sun_below_the_horizon(model: Any, air: Air) -> None:
    """Paths to a sun that the planet hides go through the planet."""
    found = model(air)
    for elevation in (-1.5, -0.9, -0.6, -0.1, 0.0):
        colors = found.half_table(elevation, 8, 16)
        assert np.isfinite(colors).all() and (colors >= 0.0).all(), elevation
        assert np.isfinite(found.sun(elevation)).all(), elevation
