"""Interactive: the Rendered mode of one 3D view. Exports what has changed, follows the view, and draws the newest picture."""

from __future__ import annotations

import shutil
import tempfile
import traceback
import weakref
from pathlib import Path
from typing import Any, Optional

import bpy

from . import devices, inside, view_camera
from .camera import Unsupported
from .drawing import Canvas
from .view_scene import Scenery
from .viewport import SLICE, Quality, Viewport

NO_PACKAGE = "the viewport needs the extension with the renderer in it; a program renders with F12 only"
# Seconds between two looks for a new picture.
LOOK = 0.03


class Interactive:
    """State of a viewport. An engine has one while it shows a view."""

    def __init__(self) -> None:
        self._package = inside.package()
        self._folder = Path(tempfile.mkdtemp(prefix="lodestar-viewport-", dir=bpy.app.tempdir or None))
        self._scenery, self._canvas = Scenery(self._folder), Canvas()
        self._viewport: Optional[Viewport] = None
        self._options: dict[str, Any] = {}
        self._fault = "" if self._package is not None else NO_PACKAGE
        # What kept the scene as it is now from being exported.
        self._fault_of_export = ""
        self._is_followed = False

    # ----------------------------------------------------------------------------------------------- Blender's calls

    def update(self, engine: Any, depsgraph: Any) -> None:
        """Notes what has changed."""
        self._scenery.changes.note(depsgraph.updates)
        engine.tag_redraw()

    def draw(self, engine: Any, context: Any, depsgraph: Any) -> None:
        """Follows the view, and draws the newest picture."""
        if self._package is not None:
            try:
                self._follow(context, depsgraph)
                self._fault = ""
            except Exception as fault:  # noqa: BLE001: no fault may end the drawing of Blender's window
                self._fault = _words(fault)
        viewport = self._viewport
        if viewport is not None and viewport.picture is not None:
            self._canvas.draw(engine, depsgraph.scene, viewport.picture)
        engine.update_stats("Lodestar", self.status)
        if viewport is not None and not self._is_followed and not bpy.app.background:
            self._is_followed = True
            bpy.app.timers.register(_Look(engine, self), first_interval=LOOK)

    def close(self) -> None:
        """Ends the render and removes its files."""
        if self._viewport is not None:
            self._viewport.close()
        # A thread that still reads the scene fails in silence.
        shutil.rmtree(self._folder, ignore_errors=True)

    # ----------------------------------------------------------------------------------------------- what they need

    @property
    def status(self) -> str:
        """What the viewport does, or what is wrong, in words."""
        fault = self._fault or self._fault_of_export
        if fault:
            return fault
        status = "" if self._viewport is None else self._viewport.status
        warnings = self._scenery.warnings
        return f"{status} | {warnings} warnings: see them after F12" if warnings else status

    @property
    def viewport(self) -> Optional[Viewport]:
        """The render; None before the first one."""
        return self._viewport

    def look(self, engine: Any) -> None:
        """Asks for a redraw where there is something new to draw."""
        if self._viewport is not None and self._viewport.take_change():
            engine.tag_redraw()

    def _follow(self, context: Any, depsgraph: Any) -> None:
        settings, space = depsgraph.scene.lodestar, context.space_data
        view = view_camera.of_region(context.region, context.region_data, space, depsgraph)
        if self._viewport is None:
            self._viewport = Viewport(self._package)
        viewport = self._viewport
        # Files of the scene that is being read must stay, and of many changes in this time only the last one counts.
        if not viewport.is_reading:
            self._export(viewport, depsgraph, space, view)
        quality = Quality(settings.viewport_samples, int(settings.viewport_pixel), settings.viewport_denoise)
        viewport.show(view, quality)

    def _export(self, viewport: Viewport, depsgraph: Any, space: Any, view: view_camera.View) -> None:
        options = self._session_options(depsgraph.scene.lodestar)
        is_forced = options != self._options
        if not self._scenery.changes.are_seen and not is_forced:
            return
        self._options = options
        try:
            scene_file = self._scenery.written(depsgraph, space, view, is_forced)
        except Exception as fault:  # noqa: BLE001: it is told until the scene changes
            self._fault_of_export = _words(fault)
            return
        self._fault_of_export = ""
        if scene_file is not None:
            viewport.change(scene_file, options)

    def _session_options(self, settings: Any) -> dict[str, Any]:
        """Options of the session. When it ends is the viewport's own matter."""
        from . import engine

        chosen = engine.preferences()
        options = {"sampler": settings.sampler, "seed": settings.seed, "slice_ms": SLICE}
        device = devices.option(chosen.device if chosen is not None else "")
        if device is not None:
            options["device"] = device
        return {**options, **inside.keywords(settings.arguments, self._package.options())}


def _words(fault: Exception) -> str:
    """What is wrong, in words. A fault of the add-on is printed, too."""
    if isinstance(fault, (Unsupported, OSError, ValueError)):
        return str(fault)
    traceback.print_exception(fault)
    return f"a fault of the add-on, {type(fault).__name__}: {fault}"


class _Look:
    """Timer of a viewport, which ends with its engine."""

    def __init__(self, engine: Any, interactive: Interactive) -> None:
        self._engine, self._interactive = weakref.ref(engine), weakref.ref(interactive)

    def __call__(self) -> Optional[float]:
        engine, interactive = self._engine(), self._interactive()
        if engine is None or interactive is None:
            return None
        try:
            interactive.look(engine)
        except ReferenceError:
            return None
        return LOOK
