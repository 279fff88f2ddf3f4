"""Installs the extension in a Blender without settings and shows its viewport. `test_extension.py` runs it in a process of its own.

usage: python in_viewport.py ZIP FOLDER [EDITS]

There is no window: an engine that renders has a context for drawing, and its viewport is drawn into a picture there. Writes what it has
found into the file `found.json` of FOLDER. EDITS (default: 40) edits are made by chance.
"""

from __future__ import annotations

import gc
import json
import resource
import sys
import threading
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import view_scenes

ZIP, FOLDER = sys.argv[1], Path(sys.argv[2])
EDITS = int(sys.argv[3]) if len(sys.argv) > 3 else 40
WIDTH, HEIGHT = 80, 60
BACKGROUND = (0.25, 0.5, 0.75, 1.0)
SECONDS = 120.0


class Blind:
    """An engine that draws nothing. Undo within a render would take away the render's own scene."""

    def __init__(self) -> None:
        from bl_ext.user_default.lodestar.interactive import Interactive

        self.interactive = Interactive()
        self.interactive._canvas.draw = lambda *_: None

    def view_update(self, context: Any, depsgraph: Any) -> None:
        self.interactive.update(self, depsgraph)

    def view_draw(self, context: Any, depsgraph: Any) -> None:
        self.interactive.draw(self, context, depsgraph)

    def tag_redraw(self) -> None:
        pass

    def update_stats(self, title: str, status: str) -> None:
        pass


class View3D:
    """A 3D view of an engine."""

    def __init__(self, engine: Any, size: tuple[int, int] = (WIDTH, HEIGHT)) -> None:
        self.engine, self.context = engine, view_scenes.context(*size)
        self._following = view_scenes.Following(lambda depsgraph: engine.view_update(self.context, depsgraph))
        bpy.context.view_layer.update()
        engine.view_update(self.context, bpy.context.evaluated_depsgraph_get())

    @property
    def interactive(self) -> Any:
        return self.engine.interactive

    def draw(self) -> Any:
        """Draws the region."""
        self.engine.view_draw(self.context, bpy.context.evaluated_depsgraph_get())

    def rest(self) -> Any:
        """Draws until no picture comes any more. Returns what the region shows."""
        end = time.monotonic() + SECONDS
        while time.monotonic() < end:
            self.draw()
            if self.interactive.viewport.is_done:
                return self.draw()
            time.sleep(0.005)
        raise TimeoutError(self.interactive.status)

    def close(self) -> None:
        self._following.close()


class Seen3D(View3D):
    """A 3D view that is drawn into a picture."""

    def __init__(self, engine: Any) -> None:
        import gpu

        self._screen = gpu.types.GPUOffScreen(WIDTH, HEIGHT, format="RGBA32F")
        super().__init__(engine)

    def draw(self) -> np.ndarray:
        """Draws the region. Returns its pixels, rows from the bottom."""
        import gpu
        from mathutils import Matrix

        with self._screen.bind():
            frame = gpu.state.active_framebuffer_get()
            frame.clear(color=BACKGROUND)
            with gpu.matrix.push_pop():
                # A region's own units are its pixels.
                gpu.matrix.load_matrix(Matrix.Translation((-1, -1, 0)) @ Matrix.Diagonal((2 / WIDTH, 2 / HEIGHT, 1, 1)))
                gpu.matrix.load_projection_matrix(Matrix.Identity(4))
                super().draw()
            pixels = frame.read_color(0, 0, WIDTH, HEIGHT, 4, 0, "FLOAT")
        return np.array(pixels.to_list(), np.float32).reshape(HEIGHT, WIDTH, 4)

    def close(self) -> None:
        super().close()
        self._screen.free()


def pictures(view: View3D) -> dict[str, Any]:
    """Pictures of some views, with what is expected of them."""
    scene, found = bpy.context.scene, {}
    scene.lodestar.viewport_samples, scene.lodestar.filter = 16, "box"
    first = view.rest()
    found["status"], found["mean"] = view.interactive.status, float(first[..., :3].mean())
    # Rows from the bottom, left is left: the left wall is red, the right one green.
    found["left"], found["right"] = (first[20:40, columns, :3].mean(axis=(0, 1)).tolist() for columns in (slice(0, 5), slice(75, 80)))
    found["floor"], found["top"] = float(first[:5].mean()), float(first[-5:].mean())
    space = view.context.space_data
    space.use_render_border = True
    space.render_border_min_x, space.render_border_min_y, space.render_border_max_x, space.render_border_max_y = 0.25, 0.25, 0.5, 0.75
    part = view.rest()
    inside = np.zeros((HEIGHT, WIDTH), bool)
    inside[15:45, 20:40] = True
    found["outside_of_border"] = float(np.abs(part[~inside] - BACKGROUND).max())
    found["inside_of_border"] = float(np.abs(part[inside][:, :3].mean() / first[inside][:, :3].mean() - 1.0))
    space.use_render_border = False
    scene.render.film_transparent = True
    bpy.context.view_layer.update()
    covered = view.rest()
    # Beside the room, the background shows.
    view.context.region_data = view_scenes.orbit(WIDTH, HEIGHT, 0.0, distance=4.0)
    beside = np.abs(view.rest() - BACKGROUND)
    found["covered"] = float(np.abs(covered[..., :3].mean() / found["mean"] - 1.0))
    found["background"], found["room"] = float(beside[-1, 0].max()), float(beside[HEIGHT // 2, WIDTH // 2].max())
    scene.render.film_transparent = False
    scene.lodestar.viewport_denoise = True
    view.context.region_data = view_scenes.orbit(WIDTH, HEIGHT, 0.0)
    smooth = view.rest()
    found["denoised"], found["status_denoised"] = float(smooth[..., :3].mean()), view.interactive.status
    found["noise_left"] = float(np.abs(np.diff(smooth, axis=1)).mean() / np.abs(np.diff(first, axis=1)).mean())
    scene.lodestar.viewport_denoise = False
    return found


def final_picture() -> float:
    """Mean of the same view, by F12."""
    from bl_ext.user_default.lodestar import exr

    scene = bpy.context.scene
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.matrix_world = view_scenes.orbit(WIDTH, HEIGHT, 0.0).view_matrix.inverted()
    camera.data.sensor_width, camera.data.lens = 36.0, 50.0
    scene.collection.objects.link(camera)
    scene.camera, scene.lodestar.samples = camera, 32
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = WIDTH, HEIGHT, 100
    formats = {"media_type": "MULTI_LAYER_IMAGE", "file_format": "OPEN_EXR_MULTILAYER", "color_depth": "32"}
    for name, value in formats.items():
        if hasattr(scene.render.image_settings, name):
            setattr(scene.render.image_settings, name, value)
    scene.render.filepath = str(FOLDER / "final.exr")
    bpy.ops.render.render(write_still=True)
    channels = exr.read(FOLDER / "final.exr").channels
    return float(np.mean([channels[name].mean() for name in channels if name.split(".")[-1] in "RGB" and "Combined" in name]))


def edits(view: View3D) -> dict[str, Any]:
    """Edits by chance, while the view turns and is drawn."""
    scene = bpy.context.scene
    scene.lodestar.viewport_samples = 4
    made, kinds, sizes, statuses = view_scenes.Edits(seed=3), set(), [], set()
    begin = time.monotonic()
    for at in range(EDITS):
        kinds.add(made.make())
        if at % 4 == 0:
            view.context.region_data = view_scenes.orbit(WIDTH, HEIGHT, 0.05 * at)
        end = time.monotonic() + 0.03
        while time.monotonic() < end:
            view.draw()
            time.sleep(0.005)
        statuses.add(view.interactive.status.split(" ")[0])
        if at % max(EDITS // 20, 1) == 0:
            sizes.append(_resident())
    view.rest()
    shown = view.interactive.viewport.picture.colors
    seed = view.interactive.viewport._renderer.settings["seed"]
    return {
        "seconds": time.monotonic() - begin,
        "kinds": len(kinds),
        "megabytes": sizes,
        "statuses": sorted(statuses),
        "mean": float(shown[..., :3].mean()),
        "seed": seed,
    }


def _resident() -> float:
    try:
        text = Path("/proc/self/status").read_text()
        return int(next(line for line in text.splitlines() if line.startswith("VmRSS")).split()[1]) / 1024.0
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def within_engine(act: Callable[[Any], dict[str, Any]]) -> dict[str, Any]:
    """Calls `act` with an engine that may draw, and returns what it finds. The engine is freed afterwards."""
    from bl_ext.user_default.lodestar.engine import LodestarEngine

    found: dict[str, Any] = {}

    class Drawing(bpy.types.RenderEngine):
        # A class that is registered cannot be the base of another one.
        bl_idname, bl_label, bl_use_gpu_context = "LODESTAR_DRAWING", "Drawing", True
        view_update, view_draw, _interactive = LodestarEngine.view_update, LodestarEngine.view_draw, LodestarEngine._interactive

        def render(self, depsgraph: Any) -> None:
            try:
                view = Seen3D(self)
                try:
                    found.update(act(view))
                finally:
                    view.close()
            except Exception:
                found["fault"] = traceback.format_exc()

    bpy.utils.register_class(Drawing)
    scene = bpy.data.scenes.new("drawing")
    scene.render.engine, scene.render.resolution_x, scene.render.resolution_y = "LODESTAR_DRAWING", 8, 8
    scene.camera = bpy.data.objects.new("drawing", bpy.data.cameras.new("drawing"))
    scene.collection.objects.link(scene.camera)
    bpy.ops.render.render(scene=scene.name)
    gc.collect()
    bpy.utils.unregister_class(Drawing)
    return found


def main() -> None:
    bpy.ops.extensions.package_install_files(filepath=ZIP, repo="user_default", enable_on_install=True)
    view_scenes.room()
    result = {"pictures": within_engine(pictures)}
    if "fault" not in result["pictures"]:
        result["final"] = final_picture()
        view_scenes.room(2000)
        view = View3D(Blind())
        result["edits"] = edits(view)
        view.close()
        view.interactive.close()
        del view
        gc.collect()
        end = time.monotonic() + 10.0
        while any("_work" in thread.name for thread in threading.enumerate()) and time.monotonic() < end:
            time.sleep(0.05)
        result["threads"] = [thread.name for thread in threading.enumerate() if "_work" in thread.name]
    (FOLDER / "found.json").write_text(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
