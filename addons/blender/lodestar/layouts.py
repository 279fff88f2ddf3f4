"""Layouts: quantities of strands that texture coordinates carry.

A strand has one place on each texture: that of its root. So its texture coordinates are free to carry other quantities, too, for programs. Each
of the two numbers has a whole part, and a rest below 1. The rest of the second one is the place along the strand. The other three are the
same on the whole strand.
"""

from __future__ import annotations

from typing import NamedTuple, Optional

import numpy as np

from .programs import Expression, Graph, combine, floor, fraction

# Numbers of which each quantity consists. All are from 0 to 1.
PARTS = {"uv": ("u", "v"), "random": ("random",), "generated": ("generated x", "generated y", "generated z"), "intercept": ("intercept",)}
# Steps of whole parts. A fiber needs a precise rest.
STEPS, STEPS_OF_FIBER = 4096, 512
# Largest rest, and what the place around a fiber may add to it.
REST, AROUND = 0.9375, 1.0 / 64.0
# Share of a texture by which the places on a fiber differ from that of its root.
SPAN_OF_FIBER = 1.0 / 2048.0


class Layout(NamedTuple):
    """Numbers in the whole parts of both coordinates and in the rest of the first one."""

    numbers: tuple[str, ...]
    steps: int

    def value(self, graph: Graph, quantity: str) -> Optional[Expression]:
        """Expression of a quantity; None where there is no place for it."""
        parts = [self._number(graph, name) for name in PARTS[quantity]]
        if any(part is None for part in parts):
            return None
        x, y, z = ([*parts, graph.constant(0.0), graph.constant(0.0)] if len(parts) > 1 else parts * 3)[:3]
        return parts[0] if len(parts) == 1 else combine(x, y, z)  # type: ignore[return-value]

    def _number(self, graph: Graph, name: str) -> Optional[Expression]:
        coordinates = graph.source("uv")
        if name == "intercept":
            return fraction(coordinates.y) * (1.0 / REST)
        if name not in self.numbers:
            return None
        at = self.numbers.index(name)
        if at == 2:
            return fraction(coordinates.x) * (1.0 / REST)
        # The middle of a step.
        return (floor(coordinates.component(at)) + 0.5) * (1.0 / self.steps)

    def coordinates(self, values: dict[str, np.ndarray], intercept: np.ndarray, around: np.ndarray) -> np.ndarray:
        """Texture coordinates of points, of which the numbers of `values` are known."""
        columns = [values.get(name, np.zeros_like(intercept)) for name in self.numbers]
        columns += [np.zeros_like(intercept)] * (3 - len(columns))
        wholes = [np.minimum(np.floor(_within(column) * self.steps), self.steps - 1.0) for column in columns[:2]]
        rest = REST * np.clip(columns[2], 0.0, 1.0) + AROUND * around
        return np.column_stack([wholes[0] + rest, wholes[1] + REST * np.clip(intercept, 0.0, 1.0)])


def layout(asked: set[str], is_fiber: bool) -> Optional[Layout]:
    """Layout for the quantities that a material asks for; None where texture coordinates alone do. What finds no place is left out."""
    if not asked - {"uv"}:
        return None
    names = [name for quantity in PARTS if quantity in asked for name in PARTS[quantity] if name != "intercept"]
    if len(names) > 3:
        names = [name for name in names if not name.startswith("generated")]
    # A number alone stands in the rest, which is more precise.
    ordered = ["", "", names[0]] if len(names) == 1 else names
    return Layout(tuple(ordered), STEPS_OF_FIBER if is_fiber else STEPS)


def plain(uvs: np.ndarray, intercept: np.ndarray, around: Optional[np.ndarray]) -> np.ndarray:
    """Texture coordinates at the roots, which rise a little around and along a fiber. Rows of images run downwards in Mitsuba."""
    places = np.column_stack([uvs[:, 0], 1.0 - uvs[:, 1]])
    if around is not None:
        places += SPAN_OF_FIBER * np.column_stack([around, intercept])
    return places


def _within(values: np.ndarray) -> np.ndarray:
    """Values from 0 to 1; others repeat."""
    return np.where((values >= 0.0) & (values <= 1.0), values, values - np.floor(values))
