"""Scenes with volumes, which Cycles and Lodestar both render."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Optional

import bpy
import numpy as np
import scenes
from lodestar import grids


def volume(name: str, build: Any, surface: Optional[Any] = None) -> Any:
    """Material of which `build(tree)` returns the volume's socket, and `surface(tree)` the surface's."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(build(tree), output.inputs["Volume"])
    if surface is not None:
        tree.links.new(surface(tree), output.inputs["Surface"])
    return made


def node(tree: Any, kind: str, phase: Optional[str] = None, **inputs: Any) -> Any:
    """Output of a volume node."""
    made = tree.nodes.new(kind)
    if phase is not None and hasattr(made, "phase"):
        made.phase = phase
    for name, value in inputs.items():
        socket = made.inputs[name.replace("_", " ")]
        if isinstance(value, bpy.types.NodeSocket):
            tree.links.new(value, socket)
        else:
            socket.default_value = (*value, 1.0) if isinstance(value, tuple) and socket.type == "RGBA" else value
    return made.outputs[0]


def absorbing(tree: Any, color: Any = (0.7, 0.3, 0.1), density: float = 1.5) -> Any:
    return node(tree, "ShaderNodeVolumeAbsorption", Color=color, Density=density)


def scattering(tree: Any, color: Any = (0.8, 0.6, 0.4), density: Any = 1.0, **inputs: Any) -> Any:
    return node(tree, "ShaderNodeVolumeScatter", Color=color, Density=density, **inputs)


def mixed(tree: Any, first: Any, second: Any, share: float = 0.4) -> Any:
    mix = tree.nodes.new("ShaderNodeMixShader")
    mix.inputs[0].default_value = share
    tree.links.new(first, mix.inputs[1])
    tree.links.new(second, mix.inputs[2])
    return mix.outputs[0]


def added(tree: Any, first: Any, second: Any) -> Any:
    add = tree.nodes.new("ShaderNodeAddShader")
    tree.links.new(first, add.inputs[0])
    tree.links.new(second, add.inputs[1])
    return add.outputs[0]


def stage(strength: float = 0.6) -> Any:
    """Floor under a light world and a wide lamp. The picture has 32 x 32 pixels."""
    scene = scenes.empty()
    scene.render.resolution_percentage = 50
    scenes.camera(scene, (0, -6, 1.6), (0, 0, 0.9), lens=45)
    scenes.plane(scene, "floor", 12, scenes.diffuse("grey", (0.5, 0.5, 0.5)))
    scenes.lamp(scene, "AREA", (1.5, -2.0, 4.0), (0.45, 0.35, 0.0), energy=300.0, size=3.0)
    scenes.world(scene, (0.8, 0.9, 1.0), strength=strength)
    return scene


def bodies() -> Any:
    """Volumes on objects: absorbing, scattering forwards, Principled that emits, a mirrored one, and glass that is filled."""
    scene = stage()
    ball = lambda name, made, at, **place: scenes.ball(scene, name, 0.6, made, location=at, **place)  # noqa: E731
    ball("dark", volume("dark", absorbing), (-1.5, 0, 0.7))
    ball("fog", volume("fog", lambda t: scattering(t, Anisotropy=0.5)), (0, 0, 0.7), scale=(-1, 1, 1))
    hot = dict(Color=(0.5, 0.5, 0.7), Density=1.2, Absorption_Color=(0.3, 0.1, 0.0), Anisotropy=-0.3, Emission_Strength=0.4)
    ball("hot", volume("hot", lambda t: node(t, "ShaderNodeVolumePrincipled", Emission_Color=(1.0, 0.5, 0.2), **hot)), (1.5, 0, 0.7))
    glass = lambda t: scenes.shader(t, "ShaderNodeBsdfGlass", Color=(1, 1, 1), IOR=1.2, Roughness=0.0).outputs[0]  # noqa: E731
    ball("tea", volume("tea", lambda t: absorbing(t, (0.9, 0.5, 0.2), 2.0), glass), (0.5, -1.2, 0.6), smooth=False)
    return scene


def mixes() -> Any:
    """Mixed and added volumes of several phase functions, one inside another."""
    scene = stage()
    both = lambda t: mixed(t, scattering(t, (0.9, 0.9, 0.9), 2.0, Anisotropy=0.7), absorbing(t))  # noqa: E731
    scenes.ball(scene, "mixed", 0.7, volume("mixed", both), location=(-1.2, 0, 0.8))
    sums = lambda t: added(t, scattering(t, (0.7, 0.7, 0.7), 0.5, Anisotropy=-0.4), scattering(t, (0.7, 0.7, 0.7), 0.4, phase="RAYLEIGH"))  # noqa: E731
    scenes.ball(scene, "outer", 0.9, volume("outer", sums), location=(0.9, 0, 1.0))
    scenes.ball(scene, "inner", 0.4, volume("inner", lambda t: absorbing(t, (0.2, 0.5, 0.9), 2.0)), location=(0.9, 0, 1.0))
    return scene


def fog() -> Any:
    """The world is foggy, and the camera stands in the fog; a ball of another volume lies in it."""
    scene = stage(0.0)
    tree = scene.world.node_tree
    output = next(n for n in tree.nodes if n.type == "OUTPUT_WORLD")
    tree.links.new(scattering(tree, (0.8, 0.8, 0.8), 0.12, Anisotropy=0.3), output.inputs["Volume"])
    scenes.ball(scene, "dark", 0.6, volume("dark", absorbing), location=(-1.2, 0, 0.7))
    scenes.ball(scene, "solid", 0.5, scenes.diffuse("red", (0.7, 0.2, 0.1)), location=(0.8, 0.3, 0.5))
    return scene


def within() -> Any:
    """The camera stands within a body that scatters."""
    scene = stage()
    scenes.ball(scene, "around", 7.5, volume("around", lambda t: scattering(t, (0.7, 0.8, 0.9), 0.1)), location=(0, 0, 1))
    return scene


def smoke(folder: Path) -> Any:
    """Volume object of a .vdb file: smoke that a grid of temperatures heats."""
    scene = stage(1.0)
    vdb = grids.openvdb()
    at = np.indices((20, 24, 28)).astype(np.float32)
    r = np.sqrt(((at[0] - 9.5) / 9) ** 2 + ((at[1] - 11.5) / 11) ** 2 + ((at[2] - 13.5) / 13) ** 2)
    density = np.clip(1.0 - r, 0, 1) * (1.5 + np.sin(at[0]) * np.cos(0.7 * at[1]))
    heat = np.clip(0.6 - r - 0.02 * at[2], 0, 1) * 3000.0
    made = []
    for name, values in (("density", density), ("temperature", heat)):
        grid = vdb.FloatGrid()
        grid.copyFromArray(np.ascontiguousarray(values, np.float32), ijk=(-3, 2, 0))
        grid.name, grid.transform = name, vdb.createLinearTransform(0.1)
        made.append(grid)
    path = folder / "smoke.vdb"
    vdb.write(str(path), grids=made)
    data = bpy.data.volumes.new("smoke")
    data.filepath = str(path)
    look = dict(Color=(0.7, 0.6, 0.5), Density=2.0, Anisotropy=0.2, Blackbody_Intensity=0.4, Temperature=1.0)
    data.materials.append(volume("smoke", lambda t: node(t, "ShaderNodeVolumePrincipled", **look)))
    scenes.add(scene, "smoke", data, (-0.7, -1.2, 0.2), (0.0, 0.1, 0.3), (0.8, 0.8, 0.8))
    return scene


def wax() -> Any:
    """Subsurface of different weights, roughness and radii, and that of the node of its own."""
    scene = stage()
    colors = dict(Subsurface_Radius=(1.0, 0.4, 0.2), IOR=1.4)

    def look(name: str, **inputs: Any) -> Any:
        def build(tree: Any) -> Any:
            made = scenes.shader(tree, "ShaderNodeBsdfPrincipled", **colors, **inputs)
            made.subsurface_method = "RANDOM_WALK"
            return made.outputs[0]

        return scenes.material(name, build)

    whole = dict(Subsurface_Weight=1.0, Subsurface_Scale=1.0)
    ball = lambda name, made, at: scenes.ball(scene, name, 0.6, made, location=at)  # noqa: E731
    ball("walk", look("walk", Base_Color=(0.8, 0.6, 0.4), Roughness=0.4, **whole), (-1.5, 0, 0.7))
    half = dict(Subsurface_Weight=0.5, Subsurface_Scale=0.5, Roughness=0.1, Base_Color=(0.3, 0.7, 0.4))
    ball("half", look("half", **half), (1.5, 0, 0.7))
    node = scenes.simple("node", "ShaderNodeSubsurfaceScattering", Color=(0.9, 0.7, 0.5), Radius=(1.0, 0.5, 0.25), Scale=0.6)
    scenes.ball(scene, "node", 0.4, node, location=(0.6, -1.4, 0.45))
    return scene


def skin() -> Any:
    """A ball of skin that fills the middle of the picture."""
    scene = stage()

    def build(tree: Any) -> Any:
        inputs = dict(Base_Color=(0.8, 0.5, 0.4), Roughness=0.3, Subsurface_Radius=(1.0, 0.4, 0.2), IOR=1.4)
        made = scenes.shader(tree, "ShaderNodeBsdfPrincipled", Subsurface_Weight=1.0, Subsurface_Scale=0.3, Subsurface_Anisotropy=0.5, **inputs)
        made.subsurface_method = "RANDOM_WALK_SKIN"
        return made.outputs[0]

    scenes.ball(scene, "skin", 0.9, scenes.material("skin", build), location=(0, 0, 0.9))
    return scene
