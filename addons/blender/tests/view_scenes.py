"""A room, a region that shows it, and edits by chance, for tests and measurements of the viewport."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix, Vector

EYE, TARGET = (0.0, -3.2, 1.0), (0.0, 0.0, 1.0)


def room(triangles: int = 0) -> Any:
    """Scene with a room like Cornell's box, with two balls of so many triangles and a lamp. It has no camera."""
    # Add-ons stay as they are.
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    quarter = 0.5 * math.pi
    _wall("floor", (0, 0, 0), (0, 0, 0), (0.7, 0.7, 0.7))
    _wall("ceiling", (0, 0, 2), (2 * quarter, 0, 0), (0.7, 0.7, 0.7))
    _wall("back", (0, 1, 1), (quarter, 0, 0), (0.7, 0.7, 0.7))
    _wall("left", (-1, 0, 1), (0, quarter, 0), (0.7, 0.1, 0.1))
    _wall("right", (1, 0, 1), (0, -quarter, 0), (0.1, 0.7, 0.1))
    rings = max(int(math.sqrt(triangles / 4)), 4)
    for name, x in (("ball", -0.4), ("other ball", 0.4)):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=rings, ring_count=rings, radius=0.35, location=(x, 0, 0.35))
        bpy.context.object.name = name
    lamp = bpy.data.lights.new("lamp", "AREA")
    lamp.energy, lamp.size = 30.0, 0.5
    held = bpy.data.objects.new("lamp", lamp)
    held.location.z = 1.95
    scene.collection.objects.link(held)
    scene.render.engine = "LODESTAR"
    return scene


def _wall(name: str, location: Any, rotation: Any, color: Any) -> None:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.remove(nodes["Principled BSDF"])
    diffuse = nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (*color, 1.0)
    material.node_tree.links.new(diffuse.outputs[0], nodes["Material Output"].inputs["Surface"])
    mesh.materials.append(material)
    wall = bpy.data.objects.new(name, mesh)
    wall.location, wall.rotation_euler = location, rotation
    bpy.context.scene.collection.objects.link(wall)


def context(width: int, height: int, turn: float = 0.0) -> Any:
    """What an engine is given besides the depsgraph. The 3D view is one of Blender's own; nothing has drawn its region."""
    space = next(area.spaces.active for screen in bpy.data.screens for area in screen.areas if area.type == "VIEW_3D")
    region = SimpleNamespace(width=width, height=height)
    return SimpleNamespace(region=region, space_data=space, region_data=orbit(width, height, turn))


def orbit(width: int, height: int, turn: float, distance: float = 1.0) -> Any:
    """View of the room from a place on a circle around it."""
    eye = Vector(TARGET) + distance * (Matrix.Rotation(turn, 4, "Z") @ (Vector(EYE) - Vector(TARGET)))
    place = Matrix.Translation(eye) @ (eye - Vector(TARGET)).to_track_quat("Z", "Y").to_matrix().to_4x4()
    near, far, across = 0.01, 100.0, 0.36
    depth = ((far + near) / (near - far), 2.0 * far * near / (near - far))
    rows = ((1.0 / across, 0, 0, 0), (0, width / height / across, 0, 0), (0, 0, *depth), (0, 0, -1, 0))
    return SimpleNamespace(window_matrix=Matrix(rows), view_matrix=place.inverted(), view_perspective="PERSP")


class Following:
    """Hands the depsgraph's updates to a viewport, as Blender's window does."""

    def __init__(self, update: Callable[[Any], None]) -> None:
        self._update = update
        bpy.app.handlers.depsgraph_update_post.append(self._handle)

    def _handle(self, scene: Any, depsgraph: Any) -> None:
        self._update(depsgraph)

    def close(self) -> None:
        bpy.app.handlers.depsgraph_update_post.remove(self._handle)


class Edits:
    """Edits of a scene by chance: places, materials, lamps, worlds, meshes, visibility, adding, removing and undo."""

    def __init__(self, seed: int) -> None:
        self._chance = np.random.default_rng(seed)
        bpy.context.preferences.edit.use_global_undo = True
        bpy.ops.ed.undo_push(message="start")

    def make(self) -> str:
        """Makes one edit and says which."""
        names = [name for name in dir(self) if name.startswith("_edit_")]
        name = names[int(self._chance.integers(len(names)))]
        getattr(self, name)()
        bpy.context.view_layer.update()
        if name != "_edit_undo":
            bpy.ops.ed.undo_push(message=name)
        return name

    def _one(self, of: Any) -> Any:
        found = list(of)
        return found[int(self._chance.integers(len(found)))] if found else None

    def _mesh_object(self) -> Any:
        return self._one(each for each in bpy.context.scene.objects if each.type == "MESH")

    def _edit_place(self) -> None:
        each = self._one(bpy.context.scene.objects)
        if each is not None:
            each.location[int(self._chance.integers(3))] += float(self._chance.normal()) * 0.05

    def _edit_material(self) -> None:
        material = self._one(each for each in bpy.data.materials if each.node_tree)
        node = material and next((each for each in material.node_tree.nodes if each.type == "BSDF_DIFFUSE"), None)
        if node:
            node.inputs["Color"].default_value = (*self._chance.random(3), 1.0)

    def _edit_lamp(self) -> None:
        lamp = self._one(bpy.data.lights)
        if lamp is not None:
            lamp.energy = float(self._chance.random()) * 40.0 + 1.0

    def _edit_world(self) -> None:
        scene = bpy.context.scene
        scene.world = scene.world or bpy.data.worlds.new("world")
        if scene.world.node_tree is None:
            scene.world.use_nodes = True
        scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = float(self._chance.random())

    def _edit_mesh(self) -> None:
        each = self._mesh_object()
        if each is not None:
            each.data.vertices[0].co.z += 0.02
            each.data.update()

    def _edit_modifier(self) -> None:
        each = self._mesh_object()
        if each is not None and each.modifiers:
            each.modifiers.clear()
        elif each is not None:
            each.modifiers.new("solid", "SOLIDIFY").thickness = 0.02

    def _edit_visibility(self) -> None:
        each = self._mesh_object()
        if each is not None:
            each.hide_viewport = not each.hide_viewport

    def _edit_add(self) -> None:
        mesh = self._one(bpy.data.meshes)
        if mesh is not None and len(bpy.context.scene.objects) < 20:
            added = bpy.data.objects.new("added", mesh)
            added.location = self._chance.random(3) * (1.0, 1.0, 1.5) - (0.5, 0.5, 0.0)
            added.scale = (0.3, 0.3, 0.3)
            bpy.context.scene.collection.objects.link(added)

    def _edit_remove(self) -> None:
        each = self._one(each for each in bpy.context.scene.objects if each.name.startswith("added"))
        if each is not None:
            bpy.data.objects.remove(each)

    def _edit_undo(self) -> None:
        if bpy.ops.ed.undo.poll():
            bpy.ops.ed.undo()
