"""Names of a scene's objects and materials: ids by which Lodestar tells them apart, and what compositors know of them."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Optional

# Name that Cycles gives to the material of surfaces that have none.
NO_MATERIAL = "default_surface"
# Letters that XML cannot hold, and the one that begins a name of a parameter in scenes.
UNWRITABLE = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f$\ud800-\udfff\ufffe\uffff]")


class Thing(NamedTuple):
    """Object or material as compositors know it."""

    name: str
    # Number that the user has given to it.
    index: int
    # Name of the topmost parent of an object.
    asset: str = ""
    # Whether its surfaces have texture coordinates.
    has_uv: bool = False


@dataclass
class Names:
    """Objects and materials by the names that they have in the scene file."""

    objects: dict[str, Thing] = field(default_factory=dict)
    materials: dict[str, Thing] = field(default_factory=dict)
    # Names in the scene file by names of objects.
    _written: dict[str, str] = field(default_factory=dict, repr=False)

    def of_object(self, owner: Any) -> str:
        """Name of an object in the scene file. As in Cycles, an instance has the name of what it shows."""
        name = owner.name
        written = self._written.get(name)
        if written is None:
            written = self._written[name] = _writable(name)
            top = owner
            while top.parent is not None:
                top = top.parent
            has_uv = len(getattr(owner.data, "uv_layers", ())) > 0
            self.objects[written] = Thing(name, owner.pass_index, top.name, has_uv)
        return written

    def of_material(self, material: Optional[Any]) -> str:
        """Name of a material in the scene file."""
        name = NO_MATERIAL if material is None else material.name
        written = _writable(name)
        self.materials.setdefault(written, Thing(name, 0 if material is None else material.pass_index))
        return written


def _writable(name: str) -> str:
    """Name with another letter in the place of each that a scene file cannot hold."""
    return UNWRITABLE.sub("\ufffd", name)


def id_of_part(name: str, number: int) -> str:
    """Id of a part of an object, or of a form of a material. What follows the last # belongs to no name."""
    return f"{name}#{number}"
