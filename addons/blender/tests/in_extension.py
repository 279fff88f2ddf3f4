"""Installs the extension in a Blender without settings and renders with it. `test_extension.py` runs it in a process of its own.

usage: python in_extension.py ZIP PROGRAM FOLDER

Writes what it has found into the file `found.json` of FOLDER.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import bpy
import numpy as np

ZIP, PROGRAM, FOLDER = sys.argv[1], sys.argv[2], Path(sys.argv[3])


class Layout:
    """Layout that keeps the texts of what is drawn into it."""

    def __init__(self) -> None:
        self.texts: list[str] = []

    def label(self, text: str = "", icon: str = "NONE") -> None:
        self.texts.append(text)

    def operator(self, name: str) -> None:
        self.texts.append(f"operator {name}")

    def box(self) -> Layout:
        return self


def render(name: str) -> Any:
    from bl_ext.user_default.lodestar import exr

    path = FOLDER / f"{name}.exr"
    bpy.context.scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    picture = exr.read(path)
    return {channel: picture.channels[channel] for channel in picture.channels}


def same(first: Any, second: Any) -> bool:
    return first.keys() == second.keys() and all(np.array_equal(first[name], second[name]) for name in first)


def prepare() -> Any:
    scene = bpy.context.scene
    scene.render.engine = "LODESTAR"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 32, 24, 100
    scene.lodestar.samples, scene.lodestar.pass_depth, scene.lodestar.pass_albedo = 16, True, True
    formats = {"media_type": "MULTI_LAYER_IMAGE", "file_format": "OPEN_EXR_MULTILAYER", "use_exr_interleave": True, "color_depth": "32"}
    for name, value in formats.items():
        if hasattr(scene.render.image_settings, name):
            setattr(scene.render.image_settings, name, value)
    return scene


def fault_of(line: str) -> str:
    """Message of a render with more options."""
    bpy.context.scene.lodestar.arguments = line
    try:
        bpy.ops.render.render()
    except RuntimeError as fault:
        return str(fault)
    finally:
        bpy.context.scene.lodestar.arguments = ""
    return ""


def stopped(after: float) -> dict[str, Any]:
    """A render of too many samples that is stopped after some seconds."""
    from bl_ext.user_default.lodestar import inside

    begin, events = time.monotonic(), inside.Inside.events

    def watched(self: Any, patience: float = 0.1) -> Any:
        if after == 0.0:
            self.stop()
        for event in events(self, patience):
            if time.monotonic() - begin > after:
                self.stop()
            yield event

    inside.Inside.events = watched
    bpy.context.scene.lodestar.samples = 2**24
    brightest = max(float(values.max()) for name, values in render("stopped").items() if "Combined" in name)
    inside.Inside.events = events
    return {"seconds": time.monotonic() - begin, "brightest": brightest}


def main() -> None:
    bpy.ops.extensions.package_install_files(filepath=ZIP, repo="user_default", enable_on_install=True)
    from bl_ext.user_default.lodestar import devices, engine, inside, properties

    layout, found = Layout(), devices.found("")
    properties.draw_devices(layout, "")
    result = {"default": found.default, "advice": found.advice, "drawn": layout.texts, "is_inside": inside.package() is not None}
    prepare()
    if not found.default:
        result["fault"] = fault_of("")
    else:
        result["refused"] = fault_of("--view")
        first = render("inside")
        result["mean"] = float(np.mean([values.mean() for name, values in first.items() if "Combined" in name]))
        preferences = engine.preferences()
        preferences.device = found.names[0]
        bpy.context.scene.lodestar.arguments = "--roulette=contribution --nee on"
        result["is_same_with_options"] = same(first, render("options"))
        bpy.context.scene.lodestar.arguments = ""
        preferences.program = PROGRAM
        result["is_same_by_program"] = same(first, render("program"))
        result["listed_by_program"] = devices.found(PROGRAM).names == found.names
        preferences.program = ""
        result["stopped"], result["stopped_at_once"] = stopped(2.0), stopped(0.0)
    (FOLDER / "found.json").write_text(json.dumps(result))


if __name__ == "__main__":
    main()
