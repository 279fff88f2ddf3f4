"""View camera: what a region of Blender's 3D view shows, as a camera of the renderer.

Blender's own matrices say it: the lens, the camera's shift and fit, and the zoom and offset of the camera view are all in the matrix that
projects the region.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, Optional

import numpy as np

from . import units
from .camera import focus

Rows = tuple[tuple[float, ...], ...]
Rectangle = tuple[int, int, int, int]
# Part of an orthographic view's depth that lies before its near plane, because a camera has no plane at 0.
BEFORE_NEAR = 1e-3


class Lens(NamedTuple):
    """Lens of a camera that has a depth of field."""

    radius: float
    focus: float


class View(NamedTuple):
    """What a region shows. Equal views have the same picture."""

    # From the camera, which looks along -z with +x to the right, to the world.
    place: Rows
    # From the camera to the region, whose sides are -1 and 1.
    projection: Rows
    size: tuple[int, int]
    # Part of the region that is rendered: x, y from the bottom left, width, height in pixels.
    window: Rectangle
    clip: tuple[float, float]
    lens: Optional[Lens] = None

    @property
    def is_orthographic(self) -> bool:
        return self.projection[3][2] == 0.0

    @property
    def kind(self) -> str:
        """Plugin of its sensor."""
        return "orthographic" if self.is_orthographic else "perspective" if self.lens is None else "thinlens"

    def film(self, pixel: int) -> tuple[int, int]:
        """Size of a film whose pixels cover `pixel` x `pixel` pixels of the window each."""
        return -(-self.window[2] // pixel), -(-self.window[3] // pixel)

    def covered(self, pixel: int) -> Rectangle:
        """Part of the region that such a film covers. It may reach over the window's right and upper side."""
        width, height = self.film(pixel)
        return self.window[0], self.window[1], width * pixel, height * pixel

    def sensor(self, pixel: int = 1) -> dict[str, Any]:
        """Camera of such a film, as Mitsuba's dictionary has it."""
        x, y, width, height = self.covered(pixel)
        left, right = self._across(0, x), self._across(0, x + width)
        low, high = self._across(1, y), self._across(1, y + height)
        middle, half = (0.5 * (left + right), 0.5 * (low + high)), (0.5 * (right - left), 0.5 * (high - low))
        place = np.array(self.place)
        # Mitsuba's camera looks along +z with +x to the left.
        turned = np.diag((-1.0, 1.0, -1.0, 1.0))
        if self.is_orthographic:
            near, far = self.clip
            depth = far - near
            back = max(BEFORE_NEAR * depth - near, 0.0)
            moved = np.eye(4)
            moved[:3, 3] = middle[0], middle[1], back
            to_world = place @ moved @ turned @ np.diag((half[0], half[0], 1.0, 1.0))
            return {"type": "orthographic", "to_world": to_world, "near_clip": near + back, "far_clip": far + back}
        found: dict[str, Any] = {
            "type": self.kind,
            "to_world": place @ turned,
            "fov": math.degrees(2.0 * math.atan(half[0])),
            "fov_axis": "x",
            "principal_point_offset_x": 0.5 * middle[0] / half[0],
            "principal_point_offset_y": -0.5 * middle[1] / half[1],
            "near_clip": self.clip[0],
            "far_clip": self.clip[1],
        }
        if self.lens is not None:
            found.update(aperture_radius=self.lens.radius, focus_distance=self.lens.focus)
        return found

    def _across(self, axis: int, pixels: int) -> float:
        """Coordinate, in camera space at the depth 1, of what is seen `pixels` from the region's left or lower side."""
        at = 2.0 * pixels / self.size[axis] - 1.0
        row = self.projection[axis]
        return (at - row[3] if self.is_orthographic else at + row[2]) / row[axis]


def of_region(region: Any, view: Any, space: Any, depsgraph: Any) -> View:
    """View of a region (`Region`, `RegionView3D`, `SpaceView3D`)."""
    size = (max(region.width, 1), max(region.height, 1))
    projection = _rows(view.window_matrix)
    place = _upright(np.linalg.inv(np.array(_rows(view.view_matrix), np.float64)))
    camera = _camera(view, space, depsgraph)
    window = _window(size, projection, camera, space, depsgraph.scene_eval)
    if projection[3][2] == 0.0:
        scale, offset = projection[2][2], projection[2][3]
        clip, lens = ((1.0 + offset) / scale, (offset - 1.0) / scale), None
    else:
        planes = space if camera is None else camera.data
        clip, lens = (max(planes.clip_start, 1e-6), planes.clip_end), None if camera is None else _lens(camera)
    return View(tuple(map(tuple, place.tolist())), projection, size, window, clip, lens)


def _rows(matrix: Any) -> Rows:
    return tuple(tuple(float(value) for value in row) for row in matrix)


def _upright(place: np.ndarray) -> np.ndarray:
    """Turn and place alone. A camera's parents may shear it."""
    axes = place[:3, :3]
    if np.abs(axes.T @ axes - np.eye(3)).max() > 1e-4:
        left, _, right = np.linalg.svd(axes)
        place[:3, :3] = left @ right
    return place


def _camera(view: Any, space: Any, depsgraph: Any) -> Optional[Any]:
    """Camera that a region looks through; None where it looks through none."""
    camera = space.camera if space.use_local_camera else depsgraph.scene.camera
    if view.view_perspective != "CAMERA" or camera is None or camera.type != "CAMERA":
        return None
    return camera.evaluated_get(depsgraph)


def _lens(camera: Any) -> Optional[Lens]:
    dof = camera.data.dof
    if camera.data.type != "PERSP" or not dof.use_dof or dof.aperture_fstop <= 0.0:
        return None
    return Lens(units.aperture_radius(camera.data.lens, dof.aperture_fstop), focus(dof, camera))


def _window(size: tuple[int, int], projection: Rows, camera: Optional[Any], space: Any, scene: Any) -> Rectangle:
    """Part of the region that its border leaves."""
    low, high = np.zeros(2), np.ones(2)
    if camera is not None:
        if not scene.render.use_border:
            return (0, 0, *size)
        low, high = _frame(projection, camera, scene)
        border = scene.render
        names = ("border_min_x", "border_min_y", "border_max_x", "border_max_y")
    else:
        if not space.use_render_border:
            return (0, 0, *size)
        border, names = space, ("render_border_min_x", "render_border_min_y", "render_border_max_x", "render_border_max_y")
    sides = np.array([getattr(border, name) for name in names]).reshape(2, 2)
    corners = np.clip(low + sides * (high - low), 0.0, 1.0) * size
    x, y = (int(value) for value in np.minimum(corners[0], np.array(size) - 1))
    right, top = (int(value) for value in np.ceil(corners[1]))
    return x, y, max(right - x, 1), max(top - y, 1)


def _frame(projection: Rows, camera: Any, scene: Any) -> tuple[np.ndarray, np.ndarray]:
    """Lower left and upper right corner of the camera's picture, as parts of the region."""
    corners = np.array([(*corner, 1.0) for corner in camera.data.view_frame(scene=scene)])
    seen = corners @ np.array(projection).T
    places = 0.5 + 0.5 * seen[:, :2] / seen[:, 3:]
    return places.min(axis=0), places.max(axis=0)
