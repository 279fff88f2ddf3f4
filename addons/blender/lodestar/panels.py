"""Panels: the engine's settings in Blender's properties editor, and Blender's own panels that hold for it."""

from __future__ import annotations

from typing import Any

import bpy

from . import compositing, engine, properties

ENGINE = "LODESTAR"
# Panels of Blender that belong to other engines' settings, although they are offered to every engine.
EXCLUDED = {"VIEWLAYER_PT_filter", "RENDER_PT_freestyle", "RENDER_PT_simplify"}

# Panels that Blender offers to its own engines only, with settings that are read here, too.
BORROWED = {
    "DATA_PT_camera_dof",
    "DATA_PT_camera_dof_aperture",
    "DATA_PT_EEVEE_light",
    "EEVEE_MATERIAL_PT_context_material",
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_WORLD_PT_mist",
    "EEVEE_WORLD_PT_surface",
    "VIEWLAYER_PT_layer_passes",
    "VIEWLAYER_PT_layer_passes_cryptomatte",
}


class _Panel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context: Any) -> bool:
        return context.engine == ENGINE


class LODESTAR_PT_length(_Panel, bpy.types.Panel):
    """When a render ends."""

    bl_label = "Length"

    def draw(self, context: Any) -> None:
        settings = context.scene.lodestar
        for name in ("samples", "time", "noise"):
            row = self.layout.row(heading=name.capitalize())
            row.prop(settings, f"use_{name}", text="")
            column = row.column()
            column.active = getattr(settings, f"use_{name}")
            column.prop(settings, name, text="")
        self.layout.prop(settings, "update_every")


class LODESTAR_PT_paths(_Panel, bpy.types.Panel):
    """How light is followed."""

    bl_label = "Paths"

    def draw(self, context: Any) -> None:
        settings, layout = context.scene.lodestar, self.layout
        layout.use_property_split = True
        layout.prop(settings, "sampler")
        layout.prop(settings, "use_max_depth")
        column = layout.column()
        column.active = settings.use_max_depth
        column.prop(settings, "max_depth")
        layout.prop(settings, "filter")
        layout.prop(settings, "seed")
        layout.prop(context.scene.render, "film_transparent", text="Transparent Film")
        layout.prop(settings, "arguments")


class LODESTAR_PT_passes(_Panel, bpy.types.Panel):
    """Layers of the picture."""

    bl_label = "Passes"

    def draw(self, context: Any) -> None:
        settings, layout = context.scene.lodestar, self.layout
        for name in ("albedo", "normal", "depth", "variance"):
            layout.prop(settings, f"pass_{name}")
        layout.prop(settings, "denoise")
        column = layout.column()
        column.active = settings.denoise
        column.prop(settings, "combined_denoised")


class LODESTAR_PT_layer_passes(_Panel, bpy.types.Panel):
    """Passes of a view layer, by Blender's own switches."""

    bl_label = "Data"
    bl_context = "view_layer"
    bl_parent_id = "VIEWLAYER_PT_layer_passes"

    def draw(self, context: Any) -> None:
        self.layout.use_property_split = True
        for name in compositing.PASSES:
            self.layout.prop(context.view_layer, name)


class LODESTAR_PT_material_index(_Panel, bpy.types.Panel):
    """Number of a material in the pass of such numbers."""

    bl_label = "Settings"
    bl_context = "material"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        return super().poll(context) and context.material is not None

    def draw(self, context: Any) -> None:
        self.layout.use_property_split = True
        self.layout.prop(context.material, "pass_index")


class LODESTAR_PT_viewport(_Panel, bpy.types.Panel):
    """The shading mode Rendered of 3D views."""

    bl_label = "Viewport"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: Any) -> None:
        self.layout.use_property_split = True
        for name in ("samples", "pixel", "denoise"):
            self.layout.prop(context.scene.lodestar, f"viewport_{name}")


class LODESTAR_PT_motion(_Panel, bpy.types.Panel):
    """How long the shutter is open."""

    bl_label = "Motion Blur"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context: Any) -> None:
        self.layout.prop(context.scene.render, "use_motion_blur", text="")

    def draw(self, context: Any) -> None:
        render, layout = context.scene.render, self.layout
        layout.use_property_split, layout.active = True, render.use_motion_blur
        layout.prop(render, "motion_blur_position", text="Position")
        layout.prop(render, "motion_blur_shutter")


class LODESTAR_PT_object_motion(_Panel, bpy.types.Panel):
    """Motion of an object, by the settings of Cycles."""

    bl_label = "Motion Blur"
    bl_context = "object"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: Any) -> bool:
        return super().poll(context) and hasattr(context.object, "cycles")

    def draw_header(self, context: Any) -> None:
        self.layout.prop(context.object.cycles, "use_motion_blur", text="")

    def draw(self, context: Any) -> None:
        settings, layout = context.object.cycles, self.layout
        layout.use_property_split, layout.active = True, settings.use_motion_blur
        layout.prop(settings, "motion_steps", text="Steps")


class LODESTAR_PT_device(_Panel, bpy.types.Panel):
    """What renders, and what keeps a device from use."""

    bl_label = "Device"

    def draw(self, context: Any) -> None:
        chosen = engine.preferences()
        if chosen is not None:
            self.layout.prop(chosen, "device")
        properties.draw_devices(self.layout, chosen.program if chosen is not None else "", 44)


CLASSES = (
    LODESTAR_PT_length,
    LODESTAR_PT_paths,
    LODESTAR_PT_viewport,
    LODESTAR_PT_motion,
    LODESTAR_PT_object_motion,
    LODESTAR_PT_passes,
    LODESTAR_PT_layer_passes,
    LODESTAR_PT_material_index,
    LODESTAR_PT_device,
)


def _shared_panels() -> list[Any]:
    """Panels of Blender for every engine, such as those of lamps, cameras and materials."""
    with_engines = (each for each in bpy.types.Panel.__subclasses__() if hasattr(each, "COMPAT_ENGINES"))
    return [p for p in with_engines if p.__name__ in BORROWED or ("BLENDER_RENDER" in p.COMPAT_ENGINES and p.__name__ not in EXCLUDED)]


def register() -> None:
    for each in CLASSES:
        bpy.utils.register_class(each)
    for panel in _shared_panels():
        panel.COMPAT_ENGINES.add(ENGINE)


def unregister() -> None:
    for panel in _shared_panels():
        panel.COMPAT_ENGINES.discard(ENGINE)
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
