"""Limits of programs: what the renderer would refuse is told before."""

from __future__ import annotations

from typing import Optional, Union

from .programs import Expression

MOST_OPERATIONS = 256
MOST_VALUES = 16
# Operations that are quantities of the point, and take no instruction.
SOURCES = {"uv", "position", "normal", "shading_normal", "incoming"}
# Numbers of the operations that have more than three inputs, behind their coordinates. The renderer makes one vector of each three
# by another operation, unless all three are constants.
NUMBERS = {
    "noise": ("w", "detail", "roughness", "lacunarity", "offset", "gain"),
    "voronoi": ("w", "detail", "roughness", "lacunarity", "smoothness", "randomness"),
    "bricks": ("mortar", "smoothness", "bias", "width", "height"),
}
# Node of the graph, or the numbers of a vector: nodes, and constants or None where the renderer has its default.
Instruction = Union[int, tuple[object, ...]]


def excess(expression: Expression) -> Optional[str]:
    """Limit that an expression exceeds; None where it exceeds none."""
    inputs = _all_inputs(expression)
    order = _order(expression, inputs)
    if len(order) > MOST_OPERATIONS - 4:
        return f"more than {MOST_OPERATIONS} operations"
    return f"more than {MOST_VALUES} values at the same time" if _most_values(inputs, order) > MOST_VALUES else None


def _all_inputs(expression: Expression) -> dict[Instruction, list[Instruction]]:
    """Instructions, and those that each takes its operands from. Each stands behind its inputs."""
    graph = expression.graph
    needed: set[int] = set()
    open_ = [expression.node] if expression.node is not None else []
    while open_:
        node = open_.pop()
        if node not in needed and graph.plugin(node) not in SOURCES:
            needed.add(node)
            open_.extend(graph.inputs(node))
    found: dict[Instruction, list[Instruction]] = {}
    for node in sorted(needed):
        operands = graph.operands(node)
        names = NUMBERS.get(graph.plugin(node).partition("_")[0], ())
        computed = [other.node for name, other in operands.items() if name not in names and other.node in needed]
        of_node: list[Instruction] = [other for other in computed if other is not None]
        for first in range(0, len(names), 3):
            three = [operands.get(name) for name in names[first : first + 3]]
            nodes = [each.node for each in three if each is not None and each.node is not None]
            if nodes:
                key = tuple(None if each is None else each.constant if each.is_constant else each.node for each in three)
                found[key] = [other for other in nodes if other in needed]
                of_node.append(key)
        found[node] = of_node
    return found


def _order(expression: Expression, inputs: dict[Instruction, list[Instruction]]) -> list[Instruction]:
    """Instructions, each behind its inputs. Of two inputs, the one that needs more values comes first, as in the renderer."""
    needs: dict[Instruction, int] = {}
    for instruction, operands in inputs.items():
        of_inputs = sorted((needs[other] for other in operands), reverse=True)
        needs[instruction] = max((need + held for held, need in enumerate(of_inputs)), default=1)
    order: list[Instruction] = []
    done: set[Instruction] = set()
    stack = [(expression.node, False)] if inputs else []
    while stack:
        node, ready = stack.pop()
        if node is None or node in done:
            continue
        if ready:
            done.add(node)
            order.append(node)
            continue
        stack.append((node, True))
        stack.extend((other, False) for other in sorted(inputs[node], key=lambda other: needs[other]))
    return order


def _most_values(inputs: dict[Instruction, list[Instruction]], order: list[Instruction]) -> int:
    """Largest number of values that are held at the same time."""
    last_use = {other: at for at, node in enumerate(order) for other in inputs[node]}
    held, most = set(), 0
    for at, node in enumerate(order):
        held -= {other for other in inputs[node] if last_use[other] == at}
        held.add(node)
        most = max(most, len(held))
    return most
