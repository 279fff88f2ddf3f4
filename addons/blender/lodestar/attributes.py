"""Attributes of meshes as colors of corners."""

from __future__ import annotations

from typing import Any, Optional

import numpy as np

# Member, count of numbers and type of the values of each type of attribute.
MEMBERS: dict[str, tuple[str, int, type]] = {
    "FLOAT": ("value", 1, np.float32),
    "INT": ("value", 1, np.int32),
    "INT8": ("value", 1, np.int32),
    "BOOLEAN": ("value", 1, bool),
    "FLOAT2": ("vector", 2, np.float32),
    "FLOAT_VECTOR": ("vector", 3, np.float32),
    "FLOAT_COLOR": ("color", 4, np.float32),
    "BYTE_COLOR": ("color", 4, np.float32),
}


def colors(mesh: Any, name: str, vertex_of_loop: np.ndarray) -> Optional[np.ndarray]:
    """Colors of all corners by an attribute; an empty name means the one that renders show. As in Blender, a missing attribute is 0.
    None where the attribute is of a kind that is not translated."""
    attribute = mesh.attributes.get(name) if name else _rendered(mesh)
    if attribute is None:
        return np.zeros((len(vertex_of_loop), 3), np.float32)
    if attribute.data_type not in MEMBERS or attribute.domain not in ("POINT", "CORNER", "FACE"):
        return None
    values = three(numbers(attribute))
    if attribute.domain == "CORNER":
        return values
    return values[vertex_of_loop if attribute.domain == "POINT" else _face_of_loop(mesh)]


def numbers(attribute: Any) -> np.ndarray:
    """Values of an attribute whose type is one of `MEMBERS`, as rows of numbers."""
    member, count, kind = MEMBERS[attribute.data_type]
    values = np.empty(count * len(attribute.data), kind)
    attribute.data.foreach_get(member, values)
    return values.reshape(-1, count).astype(np.float32)


def _rendered(mesh: Any) -> Any:
    """Color attribute that renders show where a node names none; None where there is none."""
    attributes = mesh.color_attributes
    index = attributes.render_color_index
    return attributes[index] if 0 <= index < len(attributes) else None


def three(values: np.ndarray) -> np.ndarray:
    """Numbers in all three channels, and vectors of two with a third number 0."""
    if values.shape[1] == 1:
        return np.repeat(values, 3, axis=1)
    return np.pad(values, ((0, 0), (0, 1))) if values.shape[1] == 2 else values[:, :3]


def _face_of_loop(mesh: Any) -> np.ndarray:
    """Index of the face of each corner."""
    counts = np.empty(len(mesh.polygons), np.int32)
    mesh.polygons.foreach_get("loop_total", counts)
    return np.repeat(np.arange(len(counts)), counts)
