"""Handlers: which function translates which type of node."""

from __future__ import annotations

from . import color_nodes, input_nodes, math_nodes, texture_nodes
from .evaluator import Handler

HANDLERS: dict[str, Handler] = {**math_nodes.HANDLERS, **color_nodes.HANDLERS, **texture_nodes.HANDLERS, **input_nodes.HANDLERS}
