"""Measures how long the viewport takes to answer, in a room of 200,000 triangles at 960 x 540 pixels.

usage: python viewport_bench.py ZIP FOLDER

Installs the extension in a Blender without settings, and prints seconds as JSON: from switching to the first picture, with its parts; from a drag of
the view to the first picture of the new view, while the old one is refined; from an edit of a lamp, and of a mesh, to the first picture of the new
scene; and how long Blender's own thread is busy in the longest call.
"""

from __future__ import annotations

import json
import os
import statistics
import time
from collections.abc import Callable
from typing import Any

import bpy
import in_viewport
import view_scenes

SIZE = (960, 540)
TRIANGLES = 200_000


class Watch:
    """Times of a viewport."""

    def __init__(self) -> None:
        self.longest_call = 0.0
        begin = time.monotonic()
        self.view = in_viewport.View3D(in_viewport.Blind(), SIZE)
        self.switch = self._until(begin, lambda shown: True)

    def _draw(self) -> Any:
        begin = time.monotonic()
        self.view.draw()
        self.longest_call = max(self.longest_call, time.monotonic() - begin)
        return self.view.interactive.viewport.picture

    def _until(self, begin: float, is_right: Callable[[Any], bool]) -> float:
        """Seconds until a right picture is drawn."""
        before = self.view.interactive.viewport and self.view.interactive.viewport.picture
        while True:
            shown = self._draw()
            if shown is not None and shown is not before and is_right(shown):
                return time.monotonic() - begin
            if time.monotonic() > begin + 300.0:
                raise TimeoutError(self.view.interactive.status)
            time.sleep(0.002)

    def refined(self) -> None:
        """Waits until a picture of full size is rendered, and its next one is under way."""
        self._until(time.monotonic(), lambda shown: shown.colors.shape[1] == SIZE[0])
        time.sleep(0.3)

    def drag(self, turn: float) -> float:
        begin = time.monotonic()
        self.view.context.region_data = view_scenes.orbit(*SIZE, turn)
        before = self.view.interactive.viewport.picture.view
        return self._until(begin, lambda shown: shown.view != before)

    def edit(self, change: Callable[[], Any]) -> float:
        begin = time.monotonic()
        change()
        bpy.context.view_layer.update()
        self._draw()
        viewport = self.view.interactive.viewport
        return self._until(begin, lambda shown: not viewport.is_reading)


def reshape(mesh: Any) -> None:
    mesh.vertices[0].co.z += 0.01
    mesh.update()


def main() -> None:
    bpy.ops.extensions.package_install_files(filepath=in_viewport.ZIP, repo="user_default", enable_on_install=True)
    scene = view_scenes.room(TRIANGLES)
    watch = Watch()
    first_call, watch.longest_call = watch.longest_call, 0.0
    parts = watch.view.interactive.viewport._renderer.stats
    drags = []
    for at in range(1, 8):
        watch.refined()
        # One that goes on moves the view before it rests.
        drags += [watch.drag(0.1 * at), watch.drag(0.1 * at + 0.03)]
    lamps = [watch.edit(lambda: setattr(scene.objects["lamp"].location, "x", 0.05 * at)) for at in range(1, 6)]
    longest_call, watch.longest_call = watch.longest_call, 0.0
    meshes = [watch.edit(lambda: reshape(scene.objects["ball"].data)) for _ in range(3)]
    watch.view.close()
    watch.view.interactive.close()
    found = {
        "switch": watch.switch,
        "export at switch": first_call,
        "kernels at switch": parts["pipeline_seconds"],
        "reading at switch": parts["load_seconds"] + parts["bvh_seconds"],
        "drag, median": statistics.median(drags),
        "drag, longest": max(drags),
        "lamp, median": statistics.median(lamps),
        "longest call at drags and lamps": longest_call,
        "mesh of 100,000 triangles, median": statistics.median(meshes),
        "export of that mesh": watch.longest_call,
        "load average": os.getloadavg()[0],
    }
    print(json.dumps({name: round(value, 3) for name, value in found.items()}, indent=1))


if __name__ == "__main__":
    main()
