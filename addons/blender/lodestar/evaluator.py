"""Evaluator: the values of shader nodes as expressions of a program."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Optional

from .programs import Expression, Graph, dot

if TYPE_CHECKING:
    from .nodes import Reader

Groups = tuple[Any, ...]
# What a node gives at one of its outputs; None where it is not translated.
Handler = Callable[["Evaluator", Any, Any, Groups], Optional[Expression]]

# Weights by which Cycles makes a number of a color.
LUMINANCE = (0.2126729, 0.7151522, 0.0721750)


class Evaluator:
    """Makes expressions of the sockets of one material."""

    def __init__(self, reader: "Reader", graph: Graph) -> None:
        self.reader, self.graph = reader, graph
        self._known: dict[Any, Optional[Expression]] = {}

    def output(self, node: Any, socket: Any, groups: Groups) -> Optional[Expression]:
        """Value of a node's output; None where the node is not translated."""
        from . import handlers

        key = (node.as_pointer(), socket.identifier, tuple(group.as_pointer() for group in groups))
        if key not in self._known:
            self._known[key] = None
            handler = handlers.HANDLERS.get(node.type)
            self._known[key] = handler(self, node, socket, groups) if handler is not None else None
        return self._known[key]

    def value(self, socket: Any, groups: Groups, unlinked: Optional[Callable[[], Expression]] = None) -> Expression:
        """Value of an input. `unlinked` stands for coordinates that Blender gives to an input without a link.

        An input that is linked to a group's input is linked: it takes the number that the group's node has.
        """
        source = self.reader.source(socket, groups)
        if source is None:
            return unlinked() if unlinked is not None else self.default(socket)
        if source.node is None:
            return convert(self.default(source.socket), source.socket.type, socket.type)
        value = self.output(source.node, source.socket, source.groups)
        if value is None:
            self.reader.unsupported(source.node, socket.name, source.socket)
            return unlinked() if unlinked is not None else self.default(socket)
        return convert(value, source.socket.type, socket.type)

    def default(self, socket: Any) -> Expression:
        """The socket's own value."""
        value = getattr(socket, "default_value", 0.0)
        return self.graph.constant(list(value)[:3] if hasattr(value, "__len__") and not isinstance(value, str) else float(value))

    def input(self, node: Any, groups: Groups, *names: str, default: float = 0.0) -> Expression:
        """Value of the first input that has one of the names; `default` where this Blender's node has none."""
        socket = self.socket(node, *names)
        return self.graph.constant(default) if socket is None else self.value(socket, groups)

    @staticmethod
    def socket(node: Any, *names: str) -> Optional[Any]:
        """The first input that has one of the names or identifiers."""
        found = (s for name in names for s in node.inputs if name in (s.identifier, s.name) and getattr(s, "enabled", True))
        return next(found, next((s for name in names for s in node.inputs if name in (s.identifier, s.name)), None))


def convert(value: Expression, from_type: str, to_type: str) -> Expression:
    """Value as Blender converts it from one type of socket to another."""
    is_number = lambda kind: kind in ("VALUE", "INT", "BOOLEAN")  # noqa: E731
    if is_number(from_type) or not is_number(to_type):
        return value
    return dot(value, LUMINANCE if from_type == "RGBA" else (1.0 / 3.0,) * 3)
