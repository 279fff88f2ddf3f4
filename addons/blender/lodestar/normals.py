"""Normals that nodes pass on unchanged, such as those that are scaled by 1 and normalized."""

from __future__ import annotations

from typing import Any, Optional

from .nodes import Reader, Source

AXES = ("X", "Y", "Z")


def source(reader: Reader, socket: Any, groups: tuple[Any, ...]) -> Optional[Source]:
    """Output that makes the normals of a socket: a Normal Map's or a Bump's also where other nodes only pass them on."""
    first = found = reader.source(socket, groups)
    while found is not None and found.node is not None and found.node.type not in ("NORMAL_MAP", "BUMP"):
        found = _passed(reader, found)
    return found if found is not None and found.node is not None else first


def _passed(reader: Reader, found: Source) -> Optional[Source]:
    """Output whose unit vectors a node gives; None where it gives others."""
    node, groups = found.node, found.groups
    if node.type == "VECT_MATH" and node.operation == "NORMALIZE":
        return reader.source(node.inputs[0], groups)
    if node.type != "COMBXYZ":
        return None
    parts = [_part(reader, node.inputs[axis], groups) for axis in AXES]
    if any(part is None for part in parts) or [part.socket.name for part in parts] != list(AXES):  # type: ignore[union-attr]
        return None
    vectors = [reader.source(part.node.inputs[0], part.groups) for part in parts]  # type: ignore[union-attr]
    return vectors[0] if all(vector == vectors[0] for vector in vectors) else None


def _part(reader: Reader, socket: Any, groups: tuple[Any, ...]) -> Optional[Source]:
    """Output of a Separate XYZ node that a socket takes, also by way of products with 1; None where it takes another value."""
    found = reader.source(socket, groups)
    while found is not None and found.node is not None and found.node.type == "MATH":
        if found.node.operation != "MULTIPLY" or found.node.use_clamp:
            return None
        factors = [(reader.source(each, found.groups), each) for each in found.node.inputs[:2]]
        others = [factor for factor, each in factors if not _is_one(factor, each)]
        found = others[0] if len(others) == 1 else None
    return found if found is not None and found.node is not None and found.node.type == "SEPXYZ" else None


def _is_one(found: Optional[Source], socket: Any) -> bool:
    """Whether a socket has the number 1."""
    if found is None:
        return socket.default_value == 1.0
    if found.node is None or found.node.type == "VALUE":
        return getattr(found.socket, "default_value", 0.0) == 1.0
    return False
