"""Instances: what a scene shows in several places is written once, as a group, and once for each place as an instance of the group."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass, field
from typing import Optional

from . import xml
from .names import id_of_part
from .xml import Course


@dataclass
class _Group:
    """Shapes without a place, and the places that show them, each with the name of the object there."""

    name: str
    shapes: list[xml.Element]
    places: list[Course] = field(default_factory=list)
    owners: list[Optional[str]] = field(default_factory=list)


class Shapes:
    """Shapes of a scene by what they show, in the order of their first appearance."""

    def __init__(self) -> None:
        self._groups: dict[Hashable, _Group] = {}
        # Number of the last id.
        self._last = 0

    def add(self, shown: Hashable, course: Course, build: Callable[[], list[xml.Element]], owner: Optional[str] = None) -> None:
        """Shows shapes in a place, as those of the object `owner`. `build` makes them where nothing with the key `shown` was added before."""
        group = self._groups.get(shown)
        if group is None:
            group = self._groups[shown] = _Group(f"group {len(self._groups)}", build())
        group.places.append(course)
        group.owners.append(owner)

    def elements(self, last: int) -> Iterator[xml.Element]:
        """Shapes that have one place, and groups of those that have several. Numbers of ids follow `last`."""
        self._last = last
        for group in self._groups.values():
            for shape in group.shapes:
                if group.owners[0] is not None:
                    self._last += 1
                    shape.set("id", id_of_part(group.owners[0], self._last))
            if len(group.places) == 1:
                for shape in group.shapes:
                    yield xml.add_course(shape, group.places[0])
            elif group.shapes:
                yield xml.with_children(xml.plugin("shape", "shapegroup", id=group.name), *group.shapes)

    def lines(self) -> Iterator[str]:
        """Instances, each as a line. Elements of a million of them would take gigabytes. One without an id has the names of its group."""
        number = self._last
        for group in self._groups.values():
            if len(group.places) > 1 and group.shapes:
                of_group = group.owners[0]
                for course, owner in zip(group.places, group.owners):
                    id_ = ""
                    if owner is not None and owner != of_group:
                        number += 1
                        id_ = f" id={xml.quoted(id_of_part(owner, number))}"
                    yield f'  <shape type="instance"{id_}><ref id="{group.name}"/>{xml.text_of_course(course)}</shape>\n'
