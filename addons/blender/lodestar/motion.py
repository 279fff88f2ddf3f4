"""Motion: where objects are while the shutter is open."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterable
from typing import Any, NamedTuple, Optional

import numpy as np

from .report import Report
from .xml import Course

# Sets the frame and its fraction, and evaluates the scene there.
FrameSet = Callable[[int, float], None]
# 2^4 + 1 keys are the most that the renderer takes.
MOST_STEPS = 4
# Most that a key may amplify roundings: half of what the renderer allows.
MOST_AMPLIFICATION = 500.0
# Identity of the camera. Those of instances begin with "object" or "instance", whatever their names are.
CAMERA = ("camera",)


class Shutter:
    """Time in which a scene's shutter is open, from 0 to 1."""

    def __init__(self, scene: Any, frame_set: FrameSet) -> None:
        self._frame_set = frame_set
        self._frame = scene.frame_current + scene.frame_subframe
        render = scene.render
        self._duration = render.motion_blur_shutter
        self._middle = self._frame + {"START": 0.5, "END": -0.5}.get(render.motion_blur_position, 0.0) * self._duration

    def go(self, time: float) -> None:
        """Sets the scene to a time of the shutter."""
        self._set(self._middle + (time - 0.5) * self._duration)

    def close(self) -> None:
        """Sets the scene to its frame."""
        self._set(self._frame)

    def _set(self, frame: float) -> None:
        self._frame_set(math.floor(frame), frame - math.floor(frame))


def shutter(depsgraph: Any, frame_set: FrameSet, report: Report) -> Optional[Shutter]:
    """Shutter of a scene; None where nothing is blurred."""
    scene, render = depsgraph.scene, depsgraph.scene.render
    if not render.use_motion_blur or not getattr(depsgraph.view_layer, "use_motion_blur", True) or render.motion_blur_shutter <= 0.0:
        return None
    if getattr(getattr(scene, "cycles", None), "rolling_shutter_type", "NONE") != "NONE":
        report.warn("scene", "a rolling shutter is not supported; it opens for the whole picture at once")
    curve = render.motion_blur_shutter_curve
    curve.initialize()
    if min(curve.evaluate(curve.curves[0], at / 16.0) for at in range(17)) < 0.99:
        report.warn("scene", "the curve of the shutter is not supported; the shutter opens and closes at once")
    return Shutter(scene, frame_set)


def identity(instance: Any) -> Hashable:
    """What tells an instance from all others, at all times."""
    owner = instance.object
    if not instance.is_instance:
        return "object", owner.name_full
    return "instance", owner.name_full, instance.parent.name_full, tuple(instance.persistent_id)


def key_times(owner: Any, parent: Any, report: Report) -> list[float]:
    """Times of an object's keys. As in Cycles, an object and the one that instances it have 2^steps + 1, and none if one is not blurred."""
    counts = []
    for each in (owner, parent or owner):
        settings = getattr(each, "cycles", None)
        if not getattr(settings, "use_motion_blur", True):
            return []
        counts.append(max(getattr(settings, "motion_steps", 1), 1))
    if max(counts) > MOST_STEPS:
        report.warn(f'object "{owner.name}"', f"more than {MOST_STEPS} steps of motion are not supported; it has {MOST_STEPS}")
    return [float(time) for time in np.linspace(0.0, 1.0, 2 ** min(max(counts), MOST_STEPS) + 1)]


class Motions:
    """Courses of a scene's instances and of its camera."""

    def __init__(self, depsgraph: Any, camera: Any, report: Report, strands_of: Callable[[Any, float], Optional[list[Any]]] = lambda *_: None) -> None:
        """`strands_of` gives the strands that an instance shows at the time that the scene is at, if they may move."""
        self._depsgraph, self._camera, self._report, self._strands_of = depsgraph, camera, report, strands_of
        self._times: dict[Hashable, list[float]] = {}
        self._keys: dict[Hashable, dict[float, Any]] = {}
        # Shapes and lenses when the shutter opens.
        self._first: dict[Hashable, _Shape] = {}
        # Vertices of the meshes of objects that change their shape, by the names of the objects and the times.
        self._vertices: dict[str, dict[float, Vertices]] = {}
        # Strands of such objects, in the same way.
        self._strands: dict[str, dict[float, list[Any]]] = {}
        # Shapes of the visited time by the pointers of their data, and whether a pair of both times is equal.
        self._shapes: dict[int, _Shape] = {}
        self._equal: dict[tuple[int, int], bool] = {}

    def record(self, open_shutter: Shutter) -> None:
        """Visits the times of the shutter, and leaves the scene at the middle."""
        pending, done = {0.0, 0.5, 1.0}, set()
        while pending:
            time = min(pending)
            open_shutter.go(time)
            self._visit(time)
            done.add(time)
            pending = (pending | {time for times in self._times.values() for time in times}) - done
        open_shutter.go(0.5)
        self._keys = {name: keys for name, keys in self._keys.items() if any(key != keys[min(keys)] for key in keys.values())}
        self._vertices = {name: sets for name, sets in self._vertices.items() if self._deforms(name, sets)}
        self._strands = {name: sets for name, sets in self._strands.items() if self._strands_move(name, sets)}
        for each in (self._first, self._shapes, self._equal):
            each.clear()

    def __bool__(self) -> bool:
        return bool(self._keys or self._vertices or self._strands)

    def vertices(self, owner: Any) -> list[Vertices]:
        """Vertices of an object's mesh at evenly spaced times of the shutter; none where it keeps its shape."""
        sets = self._vertices.get(owner.name_full, {}) if self._is_own(owner) else {}
        return [sets[time] for time in sorted(sets)]

    def move_strands(self, owner: Any, groups: list[Any]) -> None:
        """Gives an object's strands their points at evenly spaced times of the shutter, where they move."""
        sets = self._strands.get(owner.name_full, {}) if self._is_own(owner) else {}
        times = [sets[time] for time in sorted(sets)]
        for group, *at_times in zip(groups, *times) if times else ():
            if _is_same(group, at_times[0]):
                group.points, *group.later = (each.points for each in at_times)

    def _is_whole(self, name: str, times: Iterable[float]) -> bool:
        """Whether sets are those of evenly spaced times from the opening to the closing. Reports others."""
        if sorted(times) == [float(time) for time in np.linspace(0.0, 1.0, len(list(times)))]:
            return True
        message = "its shape changes, but it is not shown at all times of the shutter, which is not supported; it keeps its shape"
        self._report.warn(f'object "{name}"', message)
        return False

    def _strands_move(self, name: str, of_times: dict[float, list[Any]]) -> bool:
        """Whether strands move. Reports those that become more or fewer."""
        sets = list(of_times.values())
        first = sets[0]
        is_same = [len(each) == len(first) and all(_is_same(a, b) for a, b in zip(each, first)) for each in sets]
        if not all(is_same):
            message = "its strands become more or fewer while the shutter is open, which is not supported; they move with the object"
            self._report.warn(f'object "{name}"', message)
            return False
        moves = any(_differ(a, b) for each in sets[1:] for a, b in zip(each, first))
        if moves and any(group.is_linear for group in first):
            message = "strands of straight pieces that change their shape while the shutter is open are not supported; they move with the object"
            self._report.warn(f'object "{name}"', message)
            return False
        return moves and self._is_whole(name, of_times)

    def _deforms(self, name: str, of_times: dict[float, Vertices]) -> bool:
        """Whether the vertices of a mesh move. Reports a mesh whose vertices become more or fewer."""
        sets = list(of_times.values())
        first = sets[0]
        if any(each.positions.shape != first.positions.shape or each.normals.shape != first.normals.shape for each in sets):
            message = "its vertices become more or fewer while the shutter is open, which is not supported; it keeps its shape"
            self._report.warn(f'object "{name}"', message)
            return False
        return any(not np.array_equal(each.positions, first.positions) for each in sets[1:]) and self._is_whole(name, of_times)

    def course(self, name: Hashable, matrix: Any, place: str) -> Course:
        """Course of an instance or of the camera, whose place in the middle of the time is `matrix`."""
        if name not in self._keys:
            return Course(matrix)
        keys = tuple(sorted(self._keys[name].items()))
        if _is_usable([key for _, key in keys]):
            return Course(matrix, keys)
        self._report.warn(place, "it is flat, or sheared too much, while it moves, which is not supported; it stands still")
        return Course(matrix)

    def _visit(self, time: float) -> None:
        self._shapes.clear()
        for instance in self._depsgraph.object_instances:
            owner = instance.object
            if owner.type in ("MESH", "LIGHT", "CURVES") and (instance.show_self or instance.show_particles):
                parent = instance.parent if instance.is_instance else None
                name = identity(instance)
                self._add(name, owner, parent, instance.matrix_world, time)
                if time in self._times[name]:
                    self._add_strands(instance, time)
        camera = self._camera.evaluated_get(self._depsgraph)
        self._add(CAMERA, camera, None, camera.matrix_world, time)

    def _add(self, name: Hashable, owner: Any, parent: Any, matrix: Any, time: float) -> None:
        if name not in self._times:
            self._times[name] = key_times(owner, parent, self._report)
        if time in self._times[name]:
            self._keys.setdefault(name, {})[time] = matrix.copy()
            if owner.type == "MESH" and _may_change(owner) and self._is_own(owner):
                sets = self._vertices.setdefault(owner.name_full, {})
                if time not in sets:
                    made, first = Vertices.of(owner.data), next(iter(sets.values()), None)
                    # What stands still is held once.
                    is_still = first is not None and all(np.array_equal(*each) for each in zip(made, first))
                    sets[time] = first if is_still else made
            elif time in (0.0, 1.0) and not (owner.type == "CURVES" and self._is_own(owner)):
                self._compare(name, owner, time)

    def _add_strands(self, instance: Any, time: float) -> None:
        owner = instance.object
        if not _may_change(owner) or time in self._strands.get(owner.name_full, {}) or not self._is_own(owner):
            return
        groups = self._strands_of(instance, time)
        if groups is not None:
            self._strands.setdefault(owner.name_full, {})[time] = groups

    def _is_own(self, owner: Any) -> bool:
        """Whether an instance shows the mesh of its object, and not one that nodes have made for it."""
        return owner.original.evaluated_get(self._depsgraph).data.as_pointer() == owner.data.as_pointer()

    def _compare(self, name: Hashable, owner: Any, time: float) -> None:
        """Reports a shape or a lens that is another when the shutter closes than when it opens."""
        if not _may_change(owner):
            return
        pointer = owner.data.as_pointer()
        if pointer not in self._shapes:
            self._shapes[pointer] = _Shape(pointer, _numbers(owner))
        found = self._shapes[pointer]
        if time == 0.0:
            self._first[name] = found
            return
        first = self._first.get(name)
        if first is None:
            return
        pair = first.pointer, found.pointer
        if pair not in self._equal:
            self._equal[pair] = np.array_equal(first.numbers, found.numbers)
        if self._equal[pair]:
            return
        if owner.type == "CAMERA":
            self._report.warn(f'camera "{owner.name}"', "its lens changes while the shutter is open, which is not supported")
        else:
            message = "its shape changes while the shutter is open, which is not supported; it moves as a whole"
            self._report.warn(f'object "{owner.name}"', message)


class Vertices(NamedTuple):
    """Vertices of a mesh at a time."""

    positions: np.ndarray
    # Normals of the faces' corners.
    normals: np.ndarray

    @staticmethod
    def of(mesh: Any) -> Vertices:
        positions, normals = np.empty(3 * len(mesh.vertices), np.float32), np.empty(3 * len(mesh.loops), np.float32)
        mesh.vertices.foreach_get("co", positions)
        mesh.corner_normals.foreach_get("vector", normals)
        return Vertices(positions.reshape(-1, 3), normals.reshape(-1, 3))


class _Shape(NamedTuple):
    """Shape of a mesh, or lens of a camera."""

    pointer: int
    numbers: np.ndarray


def _differ(a: Any, b: Any) -> bool:
    """Whether points of two groups of strands are in other places, and not only rounded in another way."""
    return bool(np.abs(a.points[:, :3] - b.points[:, :3]).max(initial=0.0) > a.rounding + b.rounding)


def _is_same(a: Any, b: Any) -> bool:
    """Whether groups of strands have the same strands with as many points."""
    return a.slot == b.slot and np.array_equal(a.counts, b.counts) and np.array_equal(a.numbers, b.numbers)


def _may_change(owner: Any) -> bool:
    """Whether something may change an object's shape or lens."""
    if owner.type == "CAMERA":
        return True
    original = owner.original
    is_plain = original.type in ("MESH", "CURVES") and not original.modifiers and getattr(original.data, "shape_keys", None) is None
    return owner.type in ("MESH", "CURVES") and not is_plain and getattr(getattr(owner, "cycles", None), "use_deform_motion", True)


def _numbers(owner: Any) -> np.ndarray:
    """Numbers of a camera's lens, or the points of a mesh or of hair curves."""
    data = owner.data
    if owner.type == "CAMERA":
        return np.array([data.lens, data.ortho_scale, data.sensor_width, data.shift_x, data.shift_y])
    points, name = (data.position_data, "vector") if owner.type == "CURVES" else (data.vertices, "co")
    values = np.empty(3 * len(points), np.float32)
    points.foreach_get(name, values)
    return values


def _is_usable(matrices: list[Any]) -> bool:
    """Whether a motion has an inverse at all times."""
    linear = np.array([matrix.to_3x3() for matrix in matrices], np.float64)
    determinants = np.linalg.det(linear)
    if not np.isfinite(linear).all() or (np.abs(determinants) < 1e-24).any() or np.ptp(np.sign(determinants)) > 0.0:
        return False
    return float((np.abs(linear) @ np.abs(np.linalg.inv(linear))).max()) <= MOST_AMPLIFICATION
