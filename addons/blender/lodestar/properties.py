"""Properties: settings of the engine in the scene, and the add-on's preferences."""

from __future__ import annotations

import textwrap
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from . import devices
from .export import Options


class LodestarSettings(bpy.types.PropertyGroup):
    """Settings of a render with Lodestar."""

    use_samples: BoolProperty(name="Samples", description="End after a number of samples per pixel", default=True)  # type: ignore[valid-type]
    samples: IntProperty(name="Samples", description="Samples per pixel", default=256, min=1, max=2**31 - 1)  # type: ignore[valid-type]
    use_time: BoolProperty(name="Time", description="End after some time", default=False)  # type: ignore[valid-type]
    time: FloatProperty(name="Time", description="Seconds of rendering", default=60.0, min=0.1, subtype="TIME_ABSOLUTE", unit="TIME_ABSOLUTE")  # type: ignore[valid-type]
    use_noise: BoolProperty(name="Noise", description="End each tile at a relative error", default=False)  # type: ignore[valid-type]
    noise: FloatProperty(name="Noise", description="Estimated relative error of each tile", default=0.05, min=0.0001, max=1.0, precision=4)  # type: ignore[valid-type]
    use_max_depth: BoolProperty(name="Limit Paths", description="Cut off light that travels further", default=False)  # type: ignore[valid-type]
    max_depth: IntProperty(name="Edges", description="Longest path in edges; 1 shows emission only, 2 direct light, too", default=13, min=1, max=1024)  # type: ignore[valid-type]
    sampler: EnumProperty(  # type: ignore[valid-type]
        name="Sampler",
        description="How directions are sampled",
        items=[
            ("product", "Guided", "Learned radiance times cosine, mixed with the surface's BSDF"),
            ("bsdf", "Unguided", "An ordinary path tracer"),
        ],
        default="product",
    )
    filter: EnumProperty(  # type: ignore[valid-type]
        name="Filter",
        description="Reconstruction filter of pixels",
        items=[("gaussian", "Gaussian", "Standard deviation of half a pixel"), ("tent", "Tent", "Radius of one pixel"), ("box", "Box", "One pixel")],
        default="gaussian",
    )
    seed: IntProperty(name="Seed", description="Seed of the random numbers", default=0, min=0)  # type: ignore[valid-type]
    denoise: BoolProperty(name="Denoise", description="Add a pass with the denoised picture; needs Open Image Denoise", default=False)  # type: ignore[valid-type]
    combined_denoised: BoolProperty(name="Denoised in Combined", description="Show the denoised picture as Combined", default=False)  # type: ignore[valid-type]
    update_every: FloatProperty(name="Update Every", description="Seconds between two pictures of the growing render", default=2.0, min=0.2, max=3600.0)  # type: ignore[valid-type]
    viewport_samples: IntProperty(name="Samples", description="Samples per pixel of a viewport that rests", default=128, min=1, max=2**31 - 1)  # type: ignore[valid-type]
    viewport_pixel: EnumProperty(  # type: ignore[valid-type]
        name="Pixel Size",
        description="Side of a rendered pixel on the screen while a viewport rests",
        items=[("1", "1x", "Full size"), ("2", "2x", "A quarter of the pixels"), ("4", "4x", "A 16th"), ("8", "8x", "A 64th")],
        default="1",
    )
    viewport_denoise: BoolProperty(name="Denoise", description="Denoise a viewport that rests; needs Open Image Denoise", default=False)  # type: ignore[valid-type]
    arguments: StringProperty(name="More Options", description="More options of `lodestar render`, as on the command line, such as --grid auto")  # type: ignore[valid-type]
    pass_albedo: BoolProperty(name="Albedo", description="Mean albedo at the first hit", default=False)  # type: ignore[valid-type]
    pass_normal: BoolProperty(name="Normal", description="Mean normal at the first hit", default=False)  # type: ignore[valid-type]
    pass_depth: BoolProperty(name="Depth", description="Mean distance to the first hit", default=False)  # type: ignore[valid-type]
    pass_variance: BoolProperty(name="Variance", description="Variance of each pixel's mean", default=False)  # type: ignore[valid-type]


def _renews(preferences: Any, context: Any) -> None:
    """Another renderer may find other devices."""
    devices.forget()


def _names(preferences: Any, context: Any, typed: str) -> list[str]:
    return devices.found(preferences.program).names


class LodestarPreferences(bpy.types.AddonPreferences):
    """Preferences of the add-on."""

    bl_idname = __package__

    device: StringProperty(name="Device", description="Device that renders; empty: the fastest kind that there is", search=_names)  # type: ignore[valid-type]
    program: StringProperty(name="Program", description="Program lodestar that renders in place of the one in this extension", subtype="FILE_PATH", update=_renews)  # type: ignore[valid-type]
    folder: StringProperty(name="Folder", description="Folder of exported scenes; empty: a folder in Blender's temporary one", subtype="DIR_PATH")  # type: ignore[valid-type]

    def draw(self, context: Any) -> None:
        self.layout.prop(self, "device")
        draw_devices(self.layout, self.program)
        self.layout.prop(self, "program")
        self.layout.prop(self, "folder")


class LODESTAR_OT_look_for_devices(bpy.types.Operator):
    """Look for devices again, such as after a driver was installed"""

    bl_idname = "lodestar.look_for_devices"
    bl_label = "Look Again"

    def execute(self, context: Any) -> set[str]:
        devices.forget()
        return {"FINISHED"}


def draw_devices(layout: Any, program: str, width: int = 60) -> None:
    """Shows the device that renders by default, and what `lodestar devices` advises."""
    found = devices.found(program)
    if found.default:
        layout.label(text=f"Default: {found.default}", icon="CHECKMARK")
    if not found.advice:
        return
    box = layout.box()
    for sentence in found.advice:
        for number, line in enumerate(textwrap.wrap(sentence, width)):
            box.label(text=line, icon="NONE" if number else "ERROR")
    box.operator("lodestar.look_for_devices")


def options(settings: LodestarSettings) -> Options:
    """Settings that the scene file holds."""
    return Options(settings.max_depth if settings.use_max_depth else -1, settings.filter)


CLASSES = (LodestarSettings, LodestarPreferences, LODESTAR_OT_look_for_devices)


def register() -> None:
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Scene.lodestar = PointerProperty(type=LodestarSettings)


def unregister() -> None:
    del bpy.types.Scene.lodestar
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
