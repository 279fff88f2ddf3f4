"""Limits of programs: what the renderer would refuse is told before."""

from __future__ import annotations

from typing import Optional

from .programs import Expression

MOST_OPERATIONS = 256
MOST_VALUES = 16
# Operations that are quantities of the point, and take no instruction.
SOURCES = {"uv", "position", "normal", "shading_normal", "incoming"}


def excess(expression: Expression) -> Optional[str]:
    """Limit that an expression exceeds; None where it exceeds none."""
    order = _order(expression)
    if len(order) > MOST_OPERATIONS - 4:
        return f"more than {MOST_OPERATIONS} operations"
    return f"more than {MOST_VALUES} values at the same time" if _most_values(expression, order) > MOST_VALUES else None


def _inputs(expression: Expression, node: int) -> list[int]:
    """Nodes that an instruction takes its operands from."""
    found = expression.graph.inputs(node)
    return [other for other in dict.fromkeys(found) if expression.graph.plugin(other) not in SOURCES]


def _order(expression: Expression) -> list[int]:
    """Instructions, each behind its inputs. Of two inputs, the one that needs more values comes first, as in the renderer."""
    needs: dict[int, int] = {}
    needed, order = set(), []
    open_ = [expression.node] if expression.node is not None else []
    while open_:
        node = open_.pop()
        if node not in needed and expression.graph.plugin(node) not in SOURCES:
            needed.add(node)
            open_.extend(_inputs(expression, node))
    for node in sorted(needed):
        of_inputs = sorted((needs[other] for other in _inputs(expression, node)), reverse=True)
        needs[node] = max((need + held for held, need in enumerate(of_inputs)), default=1)
    done: set[int] = set()
    stack = [(expression.node, False)] if needed else []
    while stack:
        node, ready = stack.pop()
        if node is None or node in done:
            continue
        if ready:
            done.add(node)
            order.append(node)
            continue
        stack.append((node, True))
        stack.extend((other, False) for other in sorted(_inputs(expression, node), key=lambda other: needs[other]))
    return order


def _most_values(expression: Expression, order: list[int]) -> int:
    """Largest number of values that are held at the same time."""
    last_use = {other: at for at, node in enumerate(order) for other in _inputs(expression, node)}
    held, most = set(), 0
    for at, node in enumerate(order):
        held -= {other for other in _inputs(expression, node) if last_use[other] == at}
        held.add(node)
        most = max(most, len(held))
    return most
