"""Clipped images: whether all surfaces of a material lie within its image, so that nothing is clipped."""

from __future__ import annotations

from typing import Any

import numpy as np

# Modifiers that keep texture coordinates, or make others between them.
KEEPING = {
    "ARMATURE", "CURVE", "DISPLACE", "EDGE_SPLIT", "HOOK", "LATTICE", "SIMPLE_DEFORM", "SMOOTH", "SOLIDIFY", "SUBSURF", "TRIANGULATE",
    "WAVE", "WEIGHTED_NORMAL",
}  # fmt: skip
# Room for coordinates that were rounded.
ROOM = 1e-5


def lies_within(material: Any, uv_map: str, to_uv: tuple[tuple[float, ...], ...]) -> bool:
    """Whether the texture coordinates of everything that may have the material lie within an image.

    `to_uv` leads from a mesh's coordinates to those of the image. Where it is not known what has the material, some may lie outside.
    """
    import bpy

    material = material.original
    meshes = {mesh for mesh in bpy.data.meshes if material in list(mesh.materials)}
    users = sum(list(mesh.materials).count(material) for mesh in meshes)
    for owner in bpy.data.objects:
        own = sum(slot.link == "OBJECT" and slot.material == material for slot in owner.material_slots)
        users += own
        if own and owner.type == "MESH":
            meshes.add(owner.data)
        if (own or owner.data in meshes) and any(modifier.show_render and modifier.type not in KEEPING for modifier in owner.modifiers):
            return False
    if users != material.users - material.use_fake_user:
        return False
    return all(_is_within(mesh, uv_map, np.array(to_uv)) for mesh in meshes)


def _is_within(mesh: Any, uv_map: str, to_uv: np.ndarray) -> bool:
    layers = mesh.uv_layers
    layer = layers.get(uv_map) if uv_map else next((each for each in layers if each.active_render), None)
    if layer is None:
        return False
    places = np.empty(2 * len(layer.uv), np.float32)
    layer.uv.foreach_get("vector", places)
    found = places.reshape(-1, 2) @ to_uv[:2, :2].T + to_uv[:2, 2]
    return bool(((found >= -ROOM) & (found <= 1.0 + ROOM)).all())
