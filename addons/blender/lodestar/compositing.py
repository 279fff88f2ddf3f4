"""Compositing: Blender's passes of what the camera sees first, from the layers that `lodestar layers` writes."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import bpy
import numpy as np

from . import exr, mattes
from .export import Export
from .names import Thing

LAYERS = "layers.exr"
SAMPLES = 64
# Options among More Options that change what is seen.
SHARED = ("--rfilter", "--traversal")
# Before Blender 5.0 they had other names.
OBJECT_INDEX, MATERIAL_INDEX = ("Object Index", "Material Index") if bpy.app.version >= (5, 0, 0) else ("IndexOB", "IndexMA")
# Kinds of Cryptomattes by the switches of a view layer.
MATTES = {
    "use_pass_cryptomatte_object": "CryptoObject",
    "use_pass_cryptomatte_material": "CryptoMaterial",
    "use_pass_cryptomatte_asset": "CryptoAsset",
}
FALLOFFS = {"QUADRATIC": 2.0, "LINEAR": 1.0, "INVERSE_QUADRATIC": 0.5}


class Pass(NamedTuple):
    """Render pass as Blender knows it."""

    name: str
    ids: str
    kind: str


# Passes by the switches of a view layer.
PASSES = {
    "use_pass_position": Pass("Position", "XYZ", "VECTOR"),
    "use_pass_uv": Pass("UV", "UVA", "VECTOR"),
    "use_pass_object_index": Pass(OBJECT_INDEX, "X", "VALUE"),
    "use_pass_material_index": Pass(MATERIAL_INDEX, "X", "VALUE"),
    "use_pass_mist": Pass("Mist", "Z", "VALUE"),
}


def passes(layer: Any) -> list[Pass]:
    """Passes that a view layer asks for. Cryptomattes have Cycles' names and channels."""
    found = [each for switch, each in PASSES.items() if getattr(layer, switch)]
    for kind in _kinds_of_mattes(layer):
        found += [Pass(f"{kind}{at:02}", "rgba", "COLOR") for at in range((min(layer.pass_cryptomatte_depth, 16) + 1) // 2)]
    return found


def _kinds_of_mattes(layer: Any) -> list[str]:
    return [kind for switch, kind in MATTES.items() if getattr(layer, switch)]


def arguments(layer: Any, scene_file: Path, options: dict[str, str], more: str) -> list[str]:
    """Command line that writes the layers of a view layer's passes. `options` are those of the picture, and `more` its other options."""
    wanted = {"objects"}
    if layer.use_pass_position or layer.use_pass_mist:
        wanted.add("position")
    if layer.use_pass_uv:
        wanted.add("uv")
    if layer.use_pass_material_index or layer.use_pass_cryptomatte_material:
        wanted.add("materials")
    line = ["layers", str(scene_file), "-o", LAYERS, "--overwrite", "--quiet", "--spp", str(SAMPLES), "--layers", ",".join(sorted(wanted))]
    for name in ("seed", "device"):
        if name in options:
            line += [f"--{name}", options[name]]
    words = shlex.split(more)
    for at, word in enumerate(words):
        if word in SHARED:
            line += words[at : at + 2]
        elif word.startswith(tuple(f"{name}=" for name in SHARED)):
            line.append(word)
    return line


def fill(layers: exr.Picture, picture: exr.Picture, exported: Export, depsgraph: Any) -> dict[str, np.ndarray]:
    """Numbers of the passes by their names, rows from the top. `layers` is the file of the command, and `picture` the render."""
    view_layer, names = depsgraph.view_layer_eval, exported.names
    # Of what the scene does not name, such as lamps, there is a share, but no matte.
    seen = _matte(layers, "CryptoObject")
    objects = seen.renamed({written: each.name for written, each in names.objects.items()})
    known = list(names.objects.values())
    found: dict[str, np.ndarray] = {}
    if view_layer.use_pass_position:
        found["Position"] = _pixels(layers, "position.X", "position.Y", "position.Z")
    if view_layer.use_pass_uv:
        found["UV"] = _uv(layers, objects, known)
    if view_layer.use_pass_object_index:
        found[OBJECT_INDEX] = objects.indices({each.name: each.index for each in known})
    if view_layer.use_pass_mist:
        found["Mist"] = _mist(layers, picture, seen.total, exported, depsgraph)
    of_kinds: dict[str, Callable[[], mattes.Matte]] = {
        "CryptoObject": lambda: objects,
        "CryptoAsset": lambda: objects.renamed({each.name: each.asset for each in known}),
    }
    if view_layer.use_pass_material_index or view_layer.use_pass_cryptomatte_material:
        materials = _matte(layers, "CryptoMaterial").renamed({written: each.name for written, each in names.materials.items()})
        found[MATERIAL_INDEX] = materials.indices({each.name: each.index for each in names.materials.values()})
        of_kinds["CryptoMaterial"] = lambda: materials
    for kind in _kinds_of_mattes(view_layer):
        matte = of_kinds[kind]()
        found.update({each.name: matte.layer(int(each.name[-2:])) for each in passes(view_layer) if each.name[:-2] == kind})
    return found


def facts(layer: Any, exported: Export) -> dict[str, str]:
    """What a picture with a view layer's mattes says about them, by the keys of its header."""
    objects = exported.names.objects.values()
    names = {
        "CryptoObject": [each.name for each in objects],
        "CryptoMaterial": [each.name for each in exported.names.materials.values()],
        "CryptoAsset": [each.asset for each in objects],
    }
    found: dict[str, str] = {}
    for kind in _kinds_of_mattes(layer):
        found.update(mattes.facts(f"{layer.name}.{kind}", names[kind]))
    return found


def _pixels(picture: exr.Picture, *channels: str) -> np.ndarray:
    """Channels of a picture, one row for each pixel."""
    found = picture.layer(list(channels))
    if found is None:
        raise ValueError(f"the layers for compositing lack {channels[0]}; the program `lodestar` has another version than the add-on")
    return found.reshape(-1, len(channels))


def _matte(layers: exr.Picture, name: str) -> mattes.Matte:
    found = mattes.read(layers, name)
    if found is None:
        raise ValueError(f"the layers for compositing lack {name}; the program `lodestar` has another version than the add-on")
    return found


def _uv(layers: exr.Picture, objects: mattes.Matte, known: list[Thing]) -> np.ndarray:
    """Texture coordinates of the object with the largest share, and the share that has any."""
    has_uv = objects.numbers({each.name: float(each.has_uv) for each in known})
    covered = (objects.shares * has_uv).sum(axis=1) * has_uv[:, 0]
    uv = _pixels(layers, "uv.U", "uv.V")
    # Rows of images run downwards in Lodestar.
    upward = np.stack([uv[:, 0], 1.0 - uv[:, 1]], axis=1)
    return np.concatenate([np.where(covered[:, None] > 0.0, upward, 0.0), covered[:, None]], axis=1)


def _mist(layers: exr.Picture, picture: exr.Picture, covered: np.ndarray, exported: Export, depsgraph: Any) -> np.ndarray:
    """Mist by the distance from the camera, or before it where rays are parallel. Where nothing is seen, it is thickest."""
    world = getattr(depsgraph.view_layer_eval, "world_override", None) or depsgraph.scene_eval.world
    settings = None if world is None else world.mist_settings
    start, depth, power = (0.0, 100.0, 1.0) if settings is None else (settings.start, settings.depth, FALLOFFS[settings.falloff])
    place = np.array(exported.camera_place, np.float32)
    way = _pixels(layers, "position.X", "position.Y", "position.Z") - place[:3, 3]
    distance = np.linalg.norm(way, axis=1)
    aside = np.linalg.norm(np.cross(way, place[:3, 2]), axis=1) if exported.is_orthographic else np.zeros_like(distance)
    if not exported.has_media:
        # The mean over all objects of a pixel, but over points of media, too. The position is that of one object alone.
        mean = _pixels(picture, "depth.Z")[:, 0]
        distance = np.where(np.isfinite(mean), mean, distance)
    before = np.sqrt((distance**2 - aside**2).clip(min=0.0))
    mist = ((before - start) / max(depth, 1e-30)).clip(0.0, 1.0) ** power
    return (1.0 - covered * (1.0 - mist)).astype(np.float32)
