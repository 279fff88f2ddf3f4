"""XML: elements of Mitsuba's scene format, as a thin layer over the standard library."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable, Sequence
from typing import Union

Element = ElementTree.Element
Color = Sequence[float]


def plugin(tag: str, kind: str, name: str | None = None, **attributes: str) -> Element:
    """Element of a plugin, such as ``<bsdf type="diffuse">``."""
    element = ElementTree.Element(tag, {"type": kind, **attributes})
    if name is not None:
        element.set("name", name)
    return element


def number(value: float) -> str:
    """Text of a number that reads back as the same single-precision number."""
    return f"{value:.9g}"


def add(parent: Element, name: str, value: Union[bool, int, float, str, Color, Element]) -> Element:
    """Adds a parameter, with the tag that its type asks for, and returns `parent`."""
    if isinstance(value, Element):
        value.set("name", name)
        parent.append(value)
        return parent
    if isinstance(value, bool):
        tag, text = "boolean", "true" if value else "false"
    elif isinstance(value, int):
        tag, text = "integer", str(value)
    elif isinstance(value, float):
        tag, text = "float", number(value)
    elif isinstance(value, str):
        tag, text = "string", value
    else:
        tag, text = "rgb", " ".join(number(max(channel, 0.0)) for channel in value[:3])
    ElementTree.SubElement(parent, tag, {"name": name, "value": text})
    return parent


def with_children(parent: Element, *children: Element) -> Element:
    """`parent` with nested objects that need no name."""
    parent.extend(children)
    return parent


def add_matrix(parent: Element, rows: Iterable[Sequence[float]], name: str = "to_world") -> Element:
    """Adds a transform by its rows, and returns `parent`. Rounding may have made the last entry other than 1."""
    rows = [list(row) for row in rows]
    if rows[3][3] != 1.0:
        rows = [[value / rows[3][3] for value in row] for row in rows]
    transform = ElementTree.SubElement(parent, "transform", {"name": name})
    text = " ".join(number(value) for row in rows for value in row)
    ElementTree.SubElement(transform, "matrix", {"value": text})
    return parent


def text_of(scene: Element) -> str:
    """Scene as text, indented."""
    ElementTree.indent(scene)
    return ElementTree.tostring(scene, encoding="unicode") + "\n"
