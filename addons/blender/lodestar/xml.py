"""XML: elements of Mitsuba's scene format, as a thin layer over the standard library."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
import xml.sax.saxutils as saxutils
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple, Union

Element = ElementTree.Element
Color = Sequence[float]
Rows = Iterable[Sequence[float]]


class Course(NamedTuple):
    """Place of an object."""

    matrix: Any
    # Pairs of a time and a matrix, where the object moves. The shutter opens at the time 0 and closes at the time 1.
    keys: tuple[tuple[float, Any], ...] = ()

    def mapped(self, change: Callable[[Any], Any]) -> Course:
        """Course whose matrices are changed."""
        return Course(change(self.matrix), tuple((time, change(matrix)) for time, matrix in self.keys))


def plugin(tag: str, kind: str, name: str | None = None, **attributes: str) -> Element:
    """Element of a plugin, such as ``<bsdf type="diffuse">``."""
    element = ElementTree.Element(tag, {"type": kind, **attributes})
    if name is not None:
        element.set("name", name)
    return element


def quoted(text: str) -> str:
    """Text of an attribute with its quotation marks."""
    return saxutils.quoteattr(text)


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


def add_matrix(parent: Element, rows: Rows, name: str = "to_world") -> Element:
    """Adds a transform by its rows, and returns `parent`."""
    transform = ElementTree.SubElement(parent, "transform", {"name": name})
    ElementTree.SubElement(transform, "matrix", {"value": _entries(rows)})
    return parent


def add_course(parent: Element, course: Course) -> Element:
    """Adds the place of an object that may move, and returns `parent`."""
    parent.append(ElementTree.fromstring(text_of_course(course)))
    return parent


def text_of_course(course: Course) -> str:
    """Place of an object that may move, as text."""
    if not course.keys:
        return f'<transform name="to_world"><matrix value="{_entries(course.matrix)}"/></transform>'
    keys = (f'<transform time="{number(time)}"><matrix value="{_entries(matrix)}"/></transform>' for time, matrix in course.keys)
    return f'<animation name="to_world">{"".join(keys)}</animation>'


def _entries(rows: Rows) -> str:
    """Entries of a matrix. Rounding may have made the last one other than 1."""
    entries = [value for row in rows for value in row]
    if entries[15] != 1.0:
        entries = [value / entries[15] for value in entries]
    return "%.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g" % tuple(entries)


def text_of(scene: Element) -> str:
    """Scene as text, indented."""
    ElementTree.indent(scene)
    return ElementTree.tostring(scene, encoding="unicode") + "\n"
