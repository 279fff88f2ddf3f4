"""Engine: a frame's render from export to passes."""

from __future__ import annotations

import shlex
import tempfile
import traceback
import weakref
from pathlib import Path
from typing import Any, NamedTuple, Optional

import bpy
import numpy as np

from . import compositing, devices, exr, export, inside, process, properties
from .camera import Unsupported, film
from .interactive import Interactive
from .viewport import close_all


class Pass(NamedTuple):
    """Render pass, and the channels of Lodestar's picture that fill it."""

    name: str
    channels: list[str]
    ids: str
    kind: str


PASSES = {
    "pass_albedo": Pass("Albedo", ["albedo.R", "albedo.G", "albedo.B"], "RGB", "COLOR"),
    "pass_normal": Pass("Normal", ["normal.X", "normal.Y", "normal.Z"], "XYZ", "VECTOR"),
    "pass_depth": Pass("Depth", ["depth.Z"], "Z", "VALUE"),
    "pass_variance": Pass("Variance", ["variance.R", "variance.G", "variance.B"], "RGB", "COLOR"),
    "denoise": Pass("Denoised", ["denoised.R", "denoised.G", "denoised.B"], "RGB", "COLOR"),
}
# Depth of pixels that hit nothing, as Cycles has it.
FAR = 1e10
PICTURE = "picture.exr"


def render_options(settings: Any, device: str) -> dict[str, str]:
    """Options of a render by name, for every way to run it."""
    found = {"sampler": settings.sampler, "seed": str(settings.seed)}
    if settings.use_time:
        found["time"] = f"{settings.time:g}"
    if settings.use_noise:
        found["noise"] = f"{settings.noise:g}"
    if settings.use_samples or not (settings.use_time or settings.use_noise):
        found["spp"] = str(settings.samples)
    chosen = devices.option(device)
    if chosen is not None:
        found["device"] = chosen
    return found


def arguments(settings: Any, scene_file: Path, device: str = "") -> list[str]:
    """Command line of a render."""
    line = ["render", str(scene_file), "-o", PICTURE, "--overwrite", "--log", "json", "--write-every", f"{settings.update_every:g}"]
    for name, value in render_options(settings, device).items():
        line += [f"--{name}", value]
    if settings.denoise:
        line.append("--denoise")
    return line + shlex.split(settings.arguments)


def start(settings: Any, chosen: Optional[Any], scene_file: Path) -> process.Process | inside.Inside:
    """Starts a render: by the program that the preferences name, else by the package that the extension has, else by the program in PATH."""
    program, device = (chosen.program.strip(), chosen.device) if chosen is not None else ("", "")
    package = inside.package() if not program else None
    if package is None:
        return process.Process(process.find(program), arguments(settings, scene_file, device), scene_file.parent, PICTURE)
    keywords = {**render_options(settings, device), **inside.keywords(settings.arguments, package.options())}
    return inside.Inside(package, scene_file, keywords, inside.Wanted(settings.update_every, settings.denoise))


def start_layers(settings: Any, chosen: Optional[Any], scene_file: Path, layer: Any) -> process.Process:
    """Starts the command that writes the layers of a view layer's passes, by the program or the package that has rendered the picture."""
    program, device = (chosen.program.strip(), chosen.device) if chosen is not None else ("", "")
    package = inside.package() if not program else None
    command = [process.find(program)] if package is None else inside.command(package)
    words = compositing.arguments(layer, scene_file, render_options(settings, device), settings.arguments)
    environment = None if package is None else inside.environment(package)
    return process.Process(command[0], [*command[1:], *words], scene_file.parent, compositing.LAYERS, environment)


def preferences() -> Optional[Any]:
    """Preferences of the add-on; None where it is used as a module."""
    addon = bpy.context.preferences.addons.get(__package__)
    return addon.preferences if addon is not None else None


class LodestarEngine(bpy.types.RenderEngine):
    """Path-guided rendering by Lodestar."""

    bl_idname = "LODESTAR"
    bl_label = "Lodestar"
    bl_use_preview = False
    bl_use_shading_nodes_custom = False
    # Material Preview is EEVEE's; the mode Rendered is this engine's.
    bl_use_eevee_viewport = True

    def view_update(self, context: Any, depsgraph: Any) -> None:
        """Notes that data of a viewport have changed."""
        self._interactive().update(self, depsgraph)

    def view_draw(self, context: Any, depsgraph: Any) -> None:
        """Draws a viewport."""
        self._interactive().draw(self, context, depsgraph)

    def _interactive(self) -> Interactive:
        if not hasattr(self, "interactive"):
            self.interactive = Interactive()
            # Blender takes its data from an engine before Python deletes it, so that a method of the engine could not read them.
            weakref.finalize(self, self.interactive.close)
        return self.interactive

    def update_render_passes(self, scene: Any = None, renderlayer: Any = None) -> None:
        """Tells the compositor which passes there are."""
        self.register_pass(scene, renderlayer, "Combined", 4, "RGBA", "COLOR")
        for each in self._passes(scene, renderlayer):
            self.register_pass(scene, renderlayer, each.name, len(each.ids), each.ids, each.kind)

    @staticmethod
    def _passes(scene: Any, layer: Any) -> list[Pass]:
        of_picture = [each for name, each in PASSES.items() if getattr(scene.lodestar, name)]
        return of_picture + [Pass(each.name, [], each.ids, each.kind) for each in compositing.passes(layer)]

    def render(self, depsgraph: Any) -> None:
        """Renders one frame of one view layer."""
        # Blender crashes where it writes a file of a render that has no result, as one that ends before its first picture.
        result = self._begin_result(depsgraph, *film(depsgraph.scene.render).window[2:])
        if result is not None:
            self.end_result(result)
        try:
            self._render(depsgraph)
        except (Unsupported, OSError, ValueError) as fault:
            self._fail(str(fault))
        except Exception as fault:
            # A fault of the add-on must end the render, not Blender.
            traceback.print_exc()
            self._fail(f"the export failed by a fault of the add-on, {type(fault).__name__}: {fault}")

    def _fail(self, message: str) -> None:
        self.report({"ERROR"}, f"Lodestar: {message}")
        self.error_set(f"Lodestar: {message}")

    def _render(self, depsgraph: Any) -> None:
        settings, chosen = depsgraph.scene.lodestar, preferences()
        folder = self._folder(chosen, depsgraph)
        self.update_stats("", "Exporting")
        exported = export.export(depsgraph, folder, properties.options(settings), self.frame_set)
        for warning in exported.report.warnings:
            self.report({"WARNING"}, f"Lodestar: {warning}")
        for note in exported.report.notes:
            self.report({"INFO"}, f"Lodestar: {note}")
        self._run(start(settings, chosen, exported.scene_file), exported, depsgraph)

    @staticmethod
    def _folder(chosen: Optional[Any], depsgraph: Any) -> Path:
        """Folder of the export. It stays, so that the next frame finds the meshes that have not changed."""
        root = Path(bpy.path.abspath(chosen.folder)) if chosen is not None and chosen.folder else None
        root = root or Path(bpy.app.tempdir or tempfile.gettempdir()) / "lodestar"
        name = Path(bpy.data.filepath).stem or "untitled"
        return root / f"{name}-{depsgraph.scene.name}-{depsgraph.view_layer.name}".replace("/", "_")

    def _run(self, running: process.Process | inside.Inside, exported: export.Export, depsgraph: Any) -> None:
        stopped = False
        try:
            for event in running.events():
                if self.test_break() and not stopped:
                    running.stop()
                    stopped = True
                if event is not None:
                    self._follow(event, exported, depsgraph)
        finally:
            running.close()
        if running.failure is not None:
            raise ValueError(running.failure)
        picture = running.picture()
        if picture is None:
            return
        self._show(picture, exported, depsgraph)
        if compositing.passes(depsgraph.view_layer_eval) and not stopped:
            self._show_layers(picture, exported, depsgraph)

    def _show_layers(self, picture: exr.Picture, exported: export.Export, depsgraph: Any) -> None:
        """Fills the passes of what the camera sees first, unless the render is stopped."""
        self.update_stats("", "Passes for compositing")
        layer = depsgraph.view_layer_eval
        running = start_layers(depsgraph.scene.lodestar, preferences(), exported.scene_file, layer)
        try:
            # The render has told the scene's warnings.
            for _ in running.events():
                if self.test_break():
                    return
        finally:
            running.close()
        layers = running.picture()
        if running.failure is not None or layers is None:
            fault = str(running.failure or "no file was written").removeprefix("lodestar: error: ")
            raise ValueError(f"the passes for compositing are missing: {fault}")
        if layers.size != picture.size:
            raise ValueError(f"the passes for compositing have {layers.size} pixels, and the picture has {picture.size}")
        self._show(picture, exported, depsgraph, compositing.fill(layers, picture, exported, depsgraph))
        whole = self.get_result()
        for key, value in compositing.facts(layer, exported).items():
            whole.stamp_data_add_field(key, value)

    def _follow(self, event: process.Event, exported: export.Export, depsgraph: Any) -> None:
        """Shows what an event of the render says."""
        kind, message = event.get("event"), event.get("message")
        if kind == "step":
            fraction = event.get("fraction")
            if fraction is not None:
                self.update_progress(min(max(float(fraction), 0.0), 1.0))
            self.update_stats("", f"{event.get('samples')} samples, {float(event.get('seconds', 0.0)):.0f} s")
        elif kind == "preparing" and message:
            self.update_stats("", str(message))
        elif kind == "warning" and message:
            self.report({"WARNING"}, f"Lodestar: {message}")
        elif kind == "written" and "picture" in event:
            self._show(event["picture"], exported, depsgraph)

    def _show(self, picture: exr.Picture, exported: export.Export, depsgraph: Any, more: Optional[dict[str, np.ndarray]] = None) -> None:
        """Fills the passes: those of the picture, and `more` by their names."""
        scene = depsgraph.scene
        # Blender asks for the border's window only, and puts it into the whole picture itself.
        width, height = exported.film.window[2:]
        result = self._begin_result(depsgraph, width, height)
        if result is None:
            return
        if picture.size != (width, height):
            raise ValueError(f"the picture has {picture.size} pixels, not {(width, height)}")
        known = {each.name: each for each in result.layers[0].passes}
        wanted = [Pass("Combined", _combined(scene.lodestar, picture), "RGBA", "COLOR"), *self._passes(scene, depsgraph.view_layer_eval)]
        for each in wanted:
            data = picture.layer(each.channels) if each.channels else (more or {}).get(each.name)
            if data is None or each.name not in known:
                continue
            if each.name == "Depth":
                data = np.where(np.isfinite(data), data, FAR)
            known[each.name].rect.foreach_set(np.ascontiguousarray(data.reshape(height, width, -1)[::-1]).ravel())
        self.end_result(result)

    def _begin_result(self, depsgraph: Any, width: int, height: int) -> Optional[Any]:
        """Result with all passes, which are black."""
        layer = depsgraph.view_layer.name
        for each in self._passes(depsgraph.scene, depsgraph.view_layer_eval):
            self.add_pass(each.name, len(each.ids), each.ids, layer=layer)
        return self.begin_result(0, 0, width, height, layer=layer)


def _combined(settings: Any, picture: exr.Picture) -> list[str]:
    if settings.denoise and settings.combined_denoised and "denoised.R" in picture.channels:
        return ["denoised.R", "denoised.G", "denoised.B", "A"]
    return ["R", "G", "B", "A"]


def register() -> None:
    bpy.utils.register_class(LodestarEngine)


def unregister() -> None:
    close_all()
    bpy.utils.unregister_class(LodestarEngine)
