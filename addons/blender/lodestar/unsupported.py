"""Settings of objects, view layers and the film that are not rendered: the report names them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from .report import Report

UNSEEN_VOLUME = "its invisibility to camera rays is not supported, because it bounds a volume; it is visible"
# Rays to which an object may be invisible. Those of the camera are rendered.
VISIBILITIES = ("diffuse", "glossy", "transmission", "shadow")


def report_object(owner: Any, report: Report) -> None:
    """Reports settings of a surface or a lamp."""
    is_light = owner.type == "LIGHT"
    place = f'object "{owner.name}"'
    hidden = [name for name in VISIBILITIES if not getattr(owner, f"visible_{name}", True)]
    if hidden:
        report.warn(place, f"its invisibility to {', '.join(hidden)} rays is not supported; it is visible")
    linking = getattr(owner, "light_linking", None)
    if linking is not None and (linking.receiver_collection is not None or linking.blocker_collection is not None):
        report.warn(place, "light linking is not supported; its light reaches all objects, and all of them block it")
    if is_light:
        _report_light(owner, report)
        return
    for name, text in (("is_holdout", "a holdout"), ("is_shadow_catcher", "a shadow catcher")):
        if getattr(owner, name, False):
            report.warn(place, f"{text} is not supported; it is an ordinary surface")


def _report_light(owner: Any, report: Report) -> None:
    settings, place = getattr(owner.data, "cycles", None), f'light "{owner.name}"'
    if getattr(settings, "max_bounces", 1024) < 16:
        report.warn(place, "a limit of its bounces is not supported")


def report_scene(depsgraph: Any, report: Report) -> None:
    """Reports settings of the film, the world and the view layer."""
    scene, layer = depsgraph.scene, depsgraph.view_layer
    cycles = getattr(scene, "cycles", None)
    if scene.render.film_transparent and getattr(cycles, "film_transparent_glass", False):
        report.warn("scene", "transparent glass is not supported; a transparent film shows glass as covered")
    for name, light in (("caustics_reflective", "mirrors throw"), ("caustics_refractive", "passes glass")):
        if not getattr(cycles, name, True):
            report.warn("scene", f"light that {light} onto rough surfaces is rendered, although its caustics are off")
    if getattr(cycles, "use_fast_gi", False):
        report.warn("scene", "Fast GI Approximation is not supported; light goes on to the limit of bounces")
    world = getattr(layer, "world_override", None) or scene.world
    visibility = getattr(world, "cycles_visibility", None)
    hidden = [name for name in ("camera", *VISIBILITIES[:3]) if not getattr(visibility, name, True)]
    if hidden:
        report.warn(f'world "{world.name}"', f"its invisibility to {', '.join(hidden)} rays is not supported; it is visible")
    for collection in _collections(layer.layer_collection):
        for name, text in (("holdout", "a holdout"), ("indirect_only", "Indirect Only")):
            if getattr(collection, name):
                report.warn(f'collection "{collection.name}"', f"{text} is not supported; its objects are ordinary ones")


def _collections(collection: Any) -> Iterator[Any]:
    """Collections of a view layer that are rendered."""
    if not collection.exclude:
        yield collection
        for child in collection.children:
            yield from _collections(child)
