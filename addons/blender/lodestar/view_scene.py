"""View scene: what a viewport shows of Blender's data, and which changes of it matter."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple, Optional

import numpy as np
from mathutils import Matrix, Vector

from . import export, properties, xml
from .meshes import Kept
from .view_camera import View

# Types of data that no picture shows. What a camera shows is in its view.
UNSEEN = {"ACTION", "ARMATURE", "BRUSH", "CAMERA", "KEY", "LIBRARY", "PALETTE", "SCREEN", "SOUND", "SPEAKER", "TEXT", "WINDOWMANAGER", "WORKSPACE"}


class Changes:
    """Changes of a scene since its last export."""

    def __init__(self) -> None:
        self.are_seen = True
        self._reshaped: set[int] = set()

    def note(self, updates: Any) -> None:
        """Notes what a depsgraph has evaluated anew (`DepsgraphUpdate`)."""
        for update in updates:
            data = update.id
            is_camera = data.id_type == "OBJECT" and data.type == "CAMERA"
            self.are_seen |= not is_camera and data.id_type not in UNSEEN
            if update.is_updated_geometry:
                self._reshaped.add(data.original.session_uid)

    def taken(self) -> set[int]:
        """Numbers of what has another shape. From here on, nothing has changed."""
        reshaped, self._reshaped, self.are_seen = self._reshaped, set(), False
        return reshaped


class _Dof(NamedTuple):
    use_dof: bool


class _Optics(NamedTuple):
    """What exports ask of a camera's data."""

    type: str
    dof: _Dof
    frame: list[Vector]

    def view_frame(self, scene: Any) -> list[Vector]:
        """Corners of what is seen, in the camera's space."""
        return self.frame


class Eye:
    """View of a region in the place of a scene's camera."""

    name = "viewport"

    def __init__(self, view: View) -> None:
        self._view = view
        self.matrix_world = Matrix(view.place)
        self.projection = Matrix(view.projection) @ self.matrix_world.inverted_safe()
        back = Matrix(view.projection).inverted_safe()
        frame = [back @ Vector((x, y, 0.0, 1.0)) for x, y in ((1, 1), (1, -1), (-1, -1), (-1, 1))]
        corners = [corner.xyz / corner.w for corner in frame]
        self.data = _Optics("ORTHO" if view.is_orthographic else "PERSP", _Dof(view.lens is not None), corners)

    def sensor(self, filter_name: str) -> xml.Element:
        """`<sensor>` whose kind is the view's. The view itself and its film are set afterwards."""
        element = xml.plugin("sensor", self._view.kind)
        for name, value in self._view.sensor().items():
            if isinstance(value, np.ndarray):
                xml.add_matrix(element, value.tolist(), name)
            elif name != "type":
                xml.add(element, name, value)
        return xml.with_children(element, xml.with_children(xml.plugin("film", "hdrfilm"), xml.plugin("rfilter", filter_name)))


class Scenery:
    """Exports of one viewport, in a folder of its own."""

    def __init__(self, folder: Path) -> None:
        self.changes = Changes()
        self._folder, self._kept = folder, Kept()
        self._digest: Optional[str] = None
        self.warnings = 0

    def written(self, depsgraph: Any, space: Any, view: View, forced: bool = False) -> Optional[Path]:
        """File of the scene as it is now; None where its picture would be the same as before."""
        self._kept.forget(self.changes.taken())
        if forced:
            # An export that fails leaves it to the next one.
            self._digest = None

        def shows(instance: Any) -> bool:
            return (instance.parent if instance.is_instance else instance.object).visible_in_viewport_get(space)

        options = properties.options(depsgraph.scene.lodestar)
        done = export.export_view(depsgraph, self._folder, options, export.Viewed(Eye(view), shows, self._kept))
        self._kept.drop_others()
        self.warnings = len(done.report.warnings)
        if done.digest == self._digest:
            return None
        self._digest = done.digest
        return done.scene_file

    def forget(self) -> None:
        """Lets the next export count as another scene."""
        self._digest, self.changes.are_seen = None, True
