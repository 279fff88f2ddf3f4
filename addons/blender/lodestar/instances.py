"""Instances: what a scene shows in several places is written once, as a group, and once for each place as an instance of the group."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass, field

from . import xml
from .xml import Course


@dataclass
class _Group:
    """Shapes without a place, and the places that show them."""

    name: str
    shapes: list[xml.Element]
    places: list[Course] = field(default_factory=list)


class Shapes:
    """Shapes of a scene by what they show, in the order of their first appearance."""

    def __init__(self) -> None:
        self._groups: dict[Hashable, _Group] = {}

    def add(self, shown: Hashable, course: Course, build: Callable[[], list[xml.Element]]) -> None:
        """Shows shapes in a place. `build` makes them where nothing with the key `shown` was added before."""
        group = self._groups.get(shown)
        if group is None:
            group = self._groups[shown] = _Group(f"group {len(self._groups)}", build())
        group.places.append(course)

    def elements(self) -> Iterator[xml.Element]:
        """Shapes that have one place, and groups of those that have several."""
        for group in self._groups.values():
            if len(group.places) == 1:
                for shape in group.shapes:
                    yield xml.add_course(shape, group.places[0])
            elif group.shapes:
                yield xml.with_children(xml.plugin("shape", "shapegroup", id=group.name), *group.shapes)

    def lines(self) -> Iterator[str]:
        """Instances, each as a line. Elements of a million of them would take gigabytes."""
        for group in self._groups.values():
            if len(group.places) > 1 and group.shapes:
                head = f'  <shape type="instance"><ref id="{group.name}"/>'
                for course in group.places:
                    yield f"{head}{xml.text_of_course(course)}</shape>\n"
